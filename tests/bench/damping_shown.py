"""``make bench-damping``, last table: what is required of ``swaywatch damping``, and what it does.

Each row is a requirement with its aim, today's figure and yes or no; one whose recordings are not
there says so. Nothing here is a test: a "no" is printed and stays.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import itertools
import json
import math
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import bicycle_free
import damping
import damping_sizes
import numpy as np
import warning_campaign
import warning_plant as plant
from written import written

from swaywatch.cli import main as swaywatch
from swaywatch.damping.compare import compare_groups, compare_model
from swaywatch.damping.course import fit_course, mean_of
from swaywatch.damping.data import NO_SIGNAL, Choice, DampingRun, load_runs, run_of
from swaywatch.damping.find import Found, find
from swaywatch.damping.freed import ADDED
from swaywatch.damping.intervals import IntervalValue, Point, points_of
from swaywatch.damping.model import load_model
from swaywatch.damping.sentences import interval
from swaywatch.damping.size import small_swing
from swaywatch.damping.study import Study, StudyPlan, study_of
from swaywatch.damping.window import Estimator

BAND = (0.2, 10.0)
ROLES = Path(__file__).resolve().parents[1] / "data" / "real"
STRAIGHT_S = 120.0
FIRST_SEED = 40_001

BESIDE = "-"
"""In place of a line of the issue: a check beside, wherever it is made."""


@dataclass(frozen=True)
class Row:
    """A promise, what was asked, what came out, and whether that is it."""

    promise: str
    aim: str
    figure: str
    shown: bool | None
    line: str = ""
    """Line of issue 18's "It must show" that it belongs to; BESIDE: a check beside."""


def inside(value: IntervalValue, truth: float) -> bool:
    """The 95 % interval holds it."""
    return value.low <= truth <= value.high


# --- the bicycle ------------------------------------------------------------------------------


def bicycle(folder: Path) -> Iterator[Row]:
    """Everything about the riderless bicycle."""
    places = bicycle_free.places_of(folder)
    fast = [place for place in places if place.speed_m_s >= bicycle_free.FEWEST_M_S]
    yield _means(fast)
    yield _repeats(places)
    yield from _found(places)
    yield from _found_alone(bicycle_free.places_of(folder, (NO_SIGNAL,)))
    of_pushes = {(p.mode, p.speed_m_s): p.of_pushes for p in places}
    yield _controllers(of_pushes["normal", 5.0], of_pushes["mm", 5.0], "the authors' pushes")
    for mode in ("normal", "mm"):
        own = {speed: points for (m, speed), points in of_pushes.items() if m == mode}
        yield _predicted(own, f"{mode}, the authors' pushes")
    yield from _as_commanded(folder)
    yield from _model(
        folder, [p for place in fast if place.mode == "normal" for p in place.of_pushes]
    )


def _means(places: Sequence[bicycle_free.Place]) -> Row:
    off = []
    for place in places:
        hand = np.array([push.damping_ratio for push in place.pushes])
        mean = mean_of([point.damping_ratio for point in place.of_pushes])
        error = math.hypot(mean.error, float(hand.std(ddof=1)) / math.sqrt(len(hand)))
        off.append(abs(mean.value - float(hand.mean())) / error)
    beyond = sum(one > 2.0 for one in off)
    return Row(
        "bicycle: mean damping ratio per speed and controller against least squares by hand on "
        "the authors' windows",
        "all within 2 standard errors",
        f"{len(off) - beyond} of {len(off)}, the farthest {max(off):.1f}",
        beyond == 0,
    )


def _repeats(places: Sequence[bicycle_free.Place]) -> Row:
    held = []
    for place in places:
        own = place.of_pushes
        for k, point in enumerate(own):
            rest = np.array([p.damping_ratio.value for p in own[:k] + own[k + 1 :]])
            others = 1.96 * rest.std(ddof=1) / math.sqrt(len(rest))
            half = math.hypot(point.damping_ratio.half, others)
            held.append(abs(point.damping_ratio.value - rest.mean()) <= half)
    share = float(np.mean(held))
    return Row(
        "bicycle: stated 95 % intervals contain the other repeats' mean",
        "85 to 98 %",
        f"{100 * share:.1f} % of {len(held)}",
        0.85 <= share <= 0.98,
    )


def _found(places: Sequence[bicycle_free.Place]) -> Iterator[Row]:
    count = bicycle_free.count(places)
    share = count.pushes_found / count.pushes
    yield Row(
        "bicycle: pushes found without a given list",
        ">= 95 %",
        f"{count.pushes_found} of {count.pushes} ({100 * share:.1f} %)",
        share >= 0.95,
    )
    free = count.pushes_free / max(count.pushes_found, 1)
    yield Row(
        "check of the criterion: the authors' pushes are free by their roll equation, and the hand "
        "is seen before them",
        ">= 95 % each",
        f"{count.pushes_free} of {count.pushes_found} ({100 * free:.1f} %), {count.pushes_seen} of "
        f"{count.pushes}",
        free >= 0.95 and count.pushes_seen >= 0.95 * count.pushes,
    )
    false = count.forced + count.other_mode
    share = false / count.judged
    sure = count.unlisted - count.not_determinable
    yield Row(
        "bicycle: false ones among all with a stated damping (a hand within the window by the roll "
        "equation, or not the mode of the pushes)",
        "<= 2 %",
        f"{false} of {count.judged} ({100 * share:.1f} %): {count.forced} with a hand "
        f"({count.forced_alike} of them with the pushes' damping and frequency), "
        f"{count.other_mode} of another damping or frequency; {sure - false} of {sure} that the "
        f"authors do not list are free and the same mode, {count.not_determinable} more are "
        "reported as not determinable",
        share <= 0.02,
    )
    compared = count.little.compared + count.held.compared
    ratios = count.little.ratio_held + count.held.ratio_held
    frequencies = count.little.frequency_held + count.held.frequency_held
    yield Row(
        "not a requirement: what the authors do not list, by the hand's part within the window "
        f"(at most {ADDED:g} of what began the swing, or more): 95 % intervals that "
        "contain the pushes' mean",
        "85 to 98 % each",
        f"damping ratio {ratios} of {compared} ({100 * ratios / compared:.1f} %), frequency "
        f"{frequencies} of "
        f"{compared} ({100 * frequencies / compared:.1f} %); {_agreeing('little', count.little)}; "
        f"{_agreeing('more', count.held)}; {count.pushes_alone} of {count.pushes_stated} pushes "
        "have little",
        all(0.85 <= held / compared <= 0.98 for held in (ratios, frequencies)),
        BESIDE,
    )


def _found_alone(places: Sequence[bicycle_free.Place]) -> Iterator[Row]:
    """The same by the lean rate alone, which does not show a hand."""
    count = bicycle_free.count(places)
    false = count.forced + count.other_mode
    yield Row(
        f"not a requirement: without the fork angle (--along {NO_SIGNAL}): pushes found, and false "
        "ones",
        ">= 95 %, <= 2 %",
        f"{count.pushes_found} of {count.pushes}, {false} of {count.judged} "
        f"({100 * false / count.judged:.1f} %)",
        count.pushes_found >= 0.95 * count.pushes and false <= 0.02 * count.judged,
        BESIDE,
    )


def _agreeing(part: str, own: bicycle_free.Agreement) -> str:
    return (
        f"{part}: {own.count}, damping ratio {own.excess:+.3f} +- {1.96 * own.excess_error:.3f} "
        "from the pushes'"
    )


def _controllers(normal: Sequence[Point], other: Sequence[Point], which: str) -> Row:
    both = compare_groups(normal, other, ("normal", "model matching"))
    total = None if both is None else both.total("damping_ratio")
    p_value = math.nan if both is None or total is None else both.p_value
    return Row(
        f"bicycle: the two controllers distinguished at 5 m/s ({which})",
        "p < 0.05",
        f"p = {p_value:.1g}",
        p_value < 0.05,
    )


def _predicted(points: dict[float, list[Point]], which: str) -> Row:
    slow = [p for speed, own in points.items() if 2.0 <= speed <= 4.0 for p in own]
    fast = points[5.0]
    course = fit_course(slow)
    mean = mean_of([point.damping_ratio for point in fast])
    if course is None:
        return Row(f"bicycle: 2 to 4 m/s predicts 5 m/s ({which})", "inside", "no course", False)
    predicted = course.value(float(np.mean([point.against for point in fast])))
    return Row(
        f"bicycle: fitted on 2 to 4 m/s it predicts 5 m/s ({which})",
        "mean inside the predicted interval",
        f"{predicted.value:.3f} ({predicted.low:.3f} to {predicted.high:.3f}), measured "
        f"{mean.value:.3f}",
        inside(predicted, mean.value),
    )


def _study(folder: Path, mode: str) -> Study:
    paths = [folder / f"{mode}_{n}kph.parquet" for n, v in bicycle_free.SPEEDS.items() if v >= 2.0]
    choice = Choice(("lean_rate",), (), "speed")
    return study_of(load_runs(paths, choice), StudyPlan(choice))


def _as_commanded(folder: Path) -> Iterator[Row]:
    """The same with every oscillation that the command finds, listed or not."""
    by_mode: dict[str, dict[float, list[Point]]] = {}
    for mode in ("normal", "mm"):
        points: dict[float, list[Point]] = {}
        for point in _study(folder, mode).points:
            speed = next(v for n, v in bicycle_free.SPEEDS.items() if point.run == f"{mode}_{n}kph")
            points.setdefault(speed, []).append(point)
        by_mode[mode] = points
    yield _controllers(by_mode["normal"][5.0], by_mode["mm"][5.0], "all that is found")
    for mode, points in by_mode.items():
        yield _predicted(points, f"{mode}, all that is found")


def _model(folder: Path, normal: list[Point]) -> Iterator[Row]:
    model = load_model(f"{folder / 'model_eigenvalues_by_hypothesis.csv'}:nominal")
    against = compare_model(normal, model)
    if against is None:
        return
    frequency = against.total("frequency_hz")
    assert frequency is not None
    shares = [
        100.0 * one.difference.value / one.second.value
        for one in against.of("frequency_hz")
        if one.second is not None and one.differs
    ]
    yield Row(
        "bicycle: the authors' model has too high a frequency",
        "by 3 to 19 %, with significance",
        f"by {min(shares):.0f} to {max(shares):.0f} % at {len(shares)} of "
        f"{len(against.of('frequency_hz'))} speeds, p = {frequency.p_value:.1g}",
        frequency.p_value < 0.05 and min(shares) >= 2.5 and max(shares) <= 19.5,
    )
    growth, ratio = against.total("growth_1_s"), against.total("damping_ratio")
    assert growth is not None
    assert ratio is not None
    yield Row(
        "bicycle: its damping agrees (sigma; the ratio has the frequency in it)",
        "no significant difference of sigma",
        f"sigma {growth.difference.value:+.2f} 1/s, p = {growth.p_value:.2g} (damping ratio "
        f"{ratio.difference.value:+.3f}, p = {ratio.p_value:.1g})",
        not growth.differs,
    )


# --- car with trailer -------------------------------------------------------------------------


def found_in(path: Path, signals: Path, estimator: Estimator) -> Found:
    """Of a recording with its roles."""
    (run,) = load_runs([path], Choice(signals=signals))
    return find(run, BAND, estimator)


def analyzed(case: Path, path: Path) -> dict[str, Any] | None:
    """The damping ratio that ``swaywatch analyze`` gives; None where it has none."""
    with tempfile.TemporaryDirectory() as out, contextlib.redirect_stdout(io.StringIO()):
        code = swaywatch(
            ["analyze", str(path), "--vehicle", str(case / "vehicle.toml"), "--signals",
             str(case / "signals.toml"), "--out", out, "--no-report"]
        )  # fmt: skip
        if code:
            return None
        summary = json.loads((Path(out) / "summary.json").read_text(encoding="utf-8"))
    value: dict[str, Any] | None = summary["drives"][0]["values"].get("damping_ratio")
    return value


def trailers(recordings: Path, name: str, cases: Sequence[Path]) -> Iterator[Row]:
    """Agreement of ``damping`` with ``analyze`` on the impulse runs."""
    agree, differ, silent = 0, [], []
    estimator = Estimator()
    for case in cases:
        path = next(iter(sorted(case.glob("run1.*"))))
        points = points_of(found_in(path, case / "signals.toml", estimator))
        other = analyzed(case, path)
        if not points or other is None:
            silent.append(case.name)
            continue
        mean = mean_of([point.damping_ratio for point in points])
        allowed = math.hypot(mean.half, 1.96 * float(other["standard_error"] or 0.0))
        if abs(mean.value - float(other["value"])) <= allowed:
            agree += 1
        else:
            differ.append(f"{case.name} {mean.value:.3f}/{float(other['value']):.3f}")
    text = f"{agree} of {len(cases)}"
    text += f"; differ: {', '.join(differ)}" if differ else ""
    text += f"; no answer: {', '.join(silent)}" if silent else ""
    yield Row(
        f"{name}: damping and analyze agree (impulse runs)",
        "all, within both 95 % intervals",
        text,
        agree == len(cases),
    )


def ladder(recordings: Path, cases: Sequence[Path]) -> Row:
    """Chrono's own damping against the mean of each run, recordings and simulations."""
    estimator = Estimator()
    held, count, off = 0, 0, []
    half: list[float] = []
    for case in cases:
        truth = json.loads((recordings / "chrono" / "truth" / f"{case.name}.json").read_text())
        steps = truth["healthy_damping_vs_speed"]
        speeds, ratios = [s["v_kmh"] for s in steps], [s["zeta"] for s in steps]
        small = truth["damping_small_amplitude_104kmh"]
        for path in (next(iter(case.glob("run1.*"))), case / "simulation_run1.mf4"):
            changed = 0.0
            if path.name.startswith("run1"):
                if not isinstance(small["changed"], dict):
                    continue  # the effect comes and goes
                changed = small["changed"]["zeta"] - small["healthy"]["zeta"]
            points = points_of(found_in(path, case / "signals.toml", estimator))
            count += 1
            if not points:
                off.append(f"{case.name} none")
                continue
            small = small_swing(points)
            speed = 3.6 * float(np.mean([point.against for point in points]))
            expected = float(np.interp(speed, speeds, ratios)) + changed
            kind = "sim" if path.name.startswith("sim") else "run"
            if small is None or small.damping_ratio is None:
                off.append(f"{case.name} {kind} no value")
                continue
            ratio = small.damping_ratio
            half.append(ratio.half)
            held += inside(ratio, expected)
            if not inside(ratio, expected):
                off.append(f"{case.name} {kind} {interval(ratio)}/{expected:.3f}")
    text = f"{held} of {count}, intervals +-{np.median(half):.3f} in the median"
    return Row(
        "Chrono's ladder: its damping ratio at small amplitude inside the interval that is stated "
        "for it (impulse runs at 103 to 105 km/h, 10 recordings and 11 simulations)",
        "inside",
        text + (f"; not: {', '.join(off)}" if off else ""),
        held == count,
    )


SIZES_DEG_S = (9.0, 4.5, 2.2, 1.1)
"""Amplitudes of the trailer's yaw rate between which a decay is cut."""


def sizes(recordings: Path, cases: Sequence[Path]) -> Row:
    """Chrono's noise-free simulations: the decay in parts of equal ratio, from large to small."""
    estimator = Estimator()
    off: dict[int, list[float]] = {}
    for case in cases:
        truth = json.loads((recordings / "chrono" / "truth" / f"{case.name}.json").read_text())
        steps = truth["healthy_damping_vs_speed"]
        speeds, ratios = [s["v_kmh"] for s in steps], [s["zeta"] for s in steps]
        path = case / "simulation_run1.mf4"
        found = find(load_runs([path], Choice(signals=case / "signals.toml"))[0], BAND, estimator)
        run = found.run
        for point in points_of(found):
            first, growth = math.degrees(point.amplitude[0]), -point.growth_1_s.value
            for part, (large, small) in enumerate(itertools.pairwise(SIZES_DEG_S)):
                begin = point.start_s + max(0.0, math.log(first / large)) / growth
                end = point.start_s + math.log(first / small) / growth
                if first < 6.0 or end > run.duration_s:
                    continue
                rows = run.rows(begin, end)
                if float(np.ptp(run.inputs[rows])) > math.radians(3):  # the next pulse
                    continue
                line = estimator.line(run.value[rows], begin, run.step_s, point.frequency_hz.value)
                assert line is not None
                assert run.against is not None
                speed = 3.6 * float(np.mean(run.against[rows]))
                difference = line.damping_ratio - float(np.interp(speed, speeds, ratios))
                off.setdefault(part, []).append(difference)
    texts, last = [], IntervalValue(math.nan, math.nan, 1.0)
    for part, values in sorted(off.items()):
        error = float(np.std(values, ddof=1)) / math.sqrt(len(values))
        last = IntervalValue(float(np.mean(values)), error, len(values) - 1.0)
        texts.append(
            f"{SIZES_DEG_S[part]:g} to {SIZES_DEG_S[part + 1]:g} deg/s {last.value:+.4f} "
            f"+- {error:.4f}"
        )
    return Row(
        "Chrono: damping ratio minus that at small amplitude, by the size of the swing (trailer's "
        "yaw rate)",
        "none at the smallest size",
        "; ".join(texts),
        inside(last, 0.0),
    )


def slaloms(cases: Sequence[Path]) -> Row:
    """Every slalom: nothing free while the driver steers."""
    estimator = Estimator()
    free, forced = [], 0
    for case in cases:
        path = next(iter(sorted(case.glob("run2.*"))))
        found = found_in(path, case / "signals.toml", estimator)
        free += [f"{case.name} {p.start_s:.0f} s" for p in points_of(found)]
        forced += any(event.forced_by for event in found.events)
    return Row(
        "slaloms (run2 of practice, sealed and Chrono): no free oscillation reported",
        "none",
        f"{len(free)} in {len(cases)} runs (in {forced} reported as forced)"
        + (f": {', '.join(free)}" if free else ""),
        not free,
    )


# --- negative controls --------------------------------------------------------------------------


def solo(folder: Path, car: str) -> Row:
    """A car without a trailer."""
    estimator = Estimator()
    stated, any_, windows, seconds = 0, 0, 0.0, 0.0
    for run in load_runs(sorted(folder.glob("*.mf4")), Choice(signals=ROLES / f"{car}.toml")):
        found = find(run, BAND, estimator)
        points = points_of(found)
        stated += sum(point.determinable for point in points)
        any_ += len(points)
        windows += run.duration_s * found.frequency_hz / 2.0
        seconds += run.duration_s
    return Row(
        f"solo car {car} (real, {seconds:.0f} s): windows of two cycles with a stated damping",
        "<= 1 %",
        f"{stated} of {windows:.0f} ({any_ - stated} more reported as not determinable)"
        if any_
        else f"0 of {windows:.0f}",
        stated <= 0.01 * windows,
    )


def _run(motion: plant.Motion, rng: np.random.Generator, c: plant.Combination) -> DampingRun:
    """What the sensors of a drive measured."""
    drive = warning_campaign.as_drive(plant.measure(motion, rng), c)
    return run_of(replace(drive, files=("drawn",)))


def straight(drives: int) -> Row:
    """Random combinations straight on under wind, road and a driver's hand."""
    estimator = Estimator()
    stated, any_, windows = 0, 0, 0.0
    for seed in range(FIRST_SEED, FIRST_SEED + drives):
        rng = np.random.default_rng(seed)
        speed = rng.uniform(60, 110) / 3.6
        combination = warning_campaign._stable_combination(rng, speed, 0.03)
        course = plant.course(STRAIGHT_S, speed)
        warning_campaign._road(course, rng, 1.0)
        motion = plant.simulate(combination, course)
        found = find(_run(motion, rng, combination), BAND, estimator)
        points = points_of(found)
        stated += sum(point.determinable for point in points)
        any_ += len(points)
        windows += STRAIGHT_S * found.frequency_hz / 2.0
    return Row(
        f"straight driving ({drives} drawn combinations, {STRAIGHT_S:.0f} s each, wind, road and "
        "hand): windows of two cycles with a stated damping",
        "<= 1 %",
        f"{stated} of {windows:.0f} ({100 * stated / windows:.2f} %); with those reported as not "
        f"determinable {any_} ({100 * any_ / windows:.2f} %)",
        stated <= 0.01 * windows,
    )


def overlapping(drives: int) -> Row:
    """Slaloms and lane changes: what is called free although the driver steers."""
    estimator = Estimator()
    low, overlap, forced = 0, 0, 0
    held: list[bool] = []
    for seed in range(FIRST_SEED, FIRST_SEED + drives):
        rng = np.random.default_rng(seed)
        speed = rng.uniform(60, 120) / 3.6
        combination = warning_campaign._stable_combination(rng, speed, 0.03)
        truth = plant.damping_ratio(combination, speed)
        course = plant.course(60.0, speed)
        plant.add_hand(course, rng, math.radians(0.1))
        steered = np.zeros(len(course.speed))
        for start in np.cumsum(rng.uniform(6, 14, 5)):
            hertz, cycles = rng.uniform(0.3, 1.0), int(rng.integers(1, 5))
            angle = math.radians(rng.uniform(3, 20))
            steered += plant.full_sine(course.time_s, start, 1 / hertz, angle, cycles)
        course.wheel += steered
        motion = plant.simulate(combination, course)
        found = find(_run(motion, rng, combination), BAND, estimator)
        forced += sum(bool(event.forced_by) for event in found.events)
        for point in points_of(found):
            if not point.determinable:
                continue
            rows = slice(round(point.start_s / plant.STEP_S), round(point.end_s / plant.STEP_S))
            driven = np.mean(np.abs(steered[rows]) > math.radians(0.5)) > 0.25
            overlap += bool(driven)
            if not driven:
                held.append(inside(point.damping_ratio, truth))
            low += bool(driven and point.damping_ratio.high < truth)
    return Row(
        f"the driver steers during an oscillation ({drives} drawn drives of 60 s, five manoeuvres "
        "each, 0.3 to 1 Hz): windows whose stated damping ratio is too low because of it",
        "none",
        f"{low} of {overlap} windows with steering in more than a quarter of their time ({forced} "
        f"swings reported as forced; of {len(held)} other windows "
        f"{100 * float(np.mean(held)):.0f} % contain the linear plant's damping ratio)",
        low == 0,
    )


# --- generated ----------------------------------------------------------------------------------


def generated(count: int) -> Iterator[Row]:
    """Swings whose damping depends on their size; a hand that wanders while they die out."""
    by_law = damping_sizes.laws(FIRST_SEED, count)
    rubs = by_law.pop("dry friction")
    stated = sum(one.stated for one in by_law.values())
    held = sum(one.held for one in by_law.values())
    yield Row(
        f"generated: damping ratio at small amplitude, five laws of its size, {count} runs each",
        "90 % of the intervals or more contain the true value",
        f"{100 * held / max(stated, 1):.0f} % of {stated} ("
        + ", ".join(
            f"{n} {o.held} of {o.stated}, +-{100 * o.half:.0f} %" for n, o in by_law.items()
        )
        + f"); with dry friction, which has no such value, {rubs.none} of {count} state none",
        held / max(stated, 1) >= 0.9,
    )
    estimator = Estimator()
    for saturating in (False, True):
        drives = damping_sizes.vehicles(FIRST_SEED, 2 * count, saturating=saturating)
        pairs = [(run, truth) for _, run, truth in drives]
        small = damping_sizes.held_at_small(pairs, estimator)
        windows = [
            inside(point.damping_ratio, truth)
            for run, truth in pairs
            for point in points_of(find(run, BAND, estimator))
        ]
        yield Row(
            f"generated: {len(drives)} drives with a wandering hand of 0.1 to 0.6 deg, tyres "
            f"{'that saturate' if saturating else 'linear'}",
            "90 % of the intervals contain the true value"
            + (" at small amplitude (a window's own is of its size)" if saturating else ""),
            f"windows {100 * float(np.mean(windows)):.0f} % of {len(windows)}, at small amplitude "
            f"{small.held} of {small.stated}",
            small.held >= 0.9 * small.stated and (saturating or float(np.mean(windows)) >= 0.9),
        )


# --- beside others ------------------------------------------------------------------------------


def beside(folder: Path) -> Row:
    """Other methods on the same windows of the bicycle."""
    rows, pushes = damping.on_pushes(folder)
    own = rows[damping.HERE]
    asked = ("pyOMA2", "ERA", "matrix pencil", "log decrement")

    def figures(row: damping.Row) -> str:
        return (
            f"{np.median(np.abs(row.error)):.3f}, {damping.coverage(row)}, "
            f"{1e3 * np.median(row.seconds):.2g} ms"
        )

    others = {
        name: row for name, row in rows.items() if any(word in name for word in asked) and row.error
    }
    there = all(any(word in name for name in others) for word in asked)
    best = min(float(np.median(np.abs(row.error))) for row in others.values())
    return Row(
        f"bicycle, {pushes} pushes in the authors' windows: error of the damping ratio against the "
        "repeats' mean (median), intervals that contain it, time; beside pyOMA2, ERA, matrix "
        "pencil and log decrement",
        "all beside; no worse than the best, intervals 85 % or more",
        f"swaywatch {figures(own)}; "
        + "; ".join(f"{name} {figures(row)}" for name, row in others.items())
        + ("" if there else "; not all are here: make bench-damping fetches pyOMA2"),
        there
        and float(np.median(np.abs(own.error))) <= 1.05 * best
        and float(np.mean(own.held)) >= 0.85,
    )


# --- the table ----------------------------------------------------------------------------------


LINES = {
    "bicycle": "Bicycle: means, intervals, pushes found and false ones, two controllers, 5 m/s "
    "predicted, model against measurement",
    "trailers": "Practice and Chrono agree with `analyze`; Chrono's ladder inside intervals",
    "controls": "Negative controls: solo cars, straight driving; an overlap with the driver's "
    "input is called forced",
    "beside": "Beside pyOMA2, ERA, matrix pencil and log decrement on the same windows",
}
"""The lines under "It must show" of issue 18."""


def table(rows: Sequence[Row]) -> list[str]:
    """Markdown: the promises, then issue 18 line by line."""
    words = {True: "yes", False: "**no**", None: "not run"}
    lines = [
        "**`make bench-damping`, requirements on `swaywatch damping`**",
        "",
        "| requirement | aim | measured | met |",
        "|---|---|---|---|",
    ]
    lines += [f"| {r.promise} | {r.aim} | {r.figure} | {words[r.shown]} |" for r in rows]
    lines += ["", '### Issue 18, "It must show", line by line', "", "| line | met |", "|---|---|"]
    for key, text in LINES.items():
        own = [row for row in rows if row.line == key]
        met = sum(row.shown is True for row in own)
        verdict = "met" if own and met == len(own) else "**not met**"
        lacking = "; ".join(f"{r.promise}: {r.figure}" for r in own if r.shown is not True)
        lines.append(
            f"| {text} | {verdict}: {met} of {len(own)} rows above"
            + (f"; lacking: {lacking}" if lacking else "")
            + " |"
        )
    return lines


def shown(recordings: Path, drives: int) -> list[Row]:
    """Every row; those without their recordings say so."""
    rows: list[Row] = []

    def add(row: Row, line: str) -> None:
        rows.append(replace(row, line=row.line or line))
        print(f"{row.promise}: {row.figure}", file=sys.stderr, flush=True)

    def where(
        line: str, name: str, needs: Sequence[Path], call: Callable[[], Iterator[Row]]
    ) -> None:
        if needs and all(path.exists() for path in needs):
            for row in call():
                add(row, line)
        else:
            add(Row(name, "-", "no recordings here", None), line)

    weave = recordings / "real" / "bicycle_weave"
    practice = sorted((recordings / "practice").glob("p*"))
    sealed = sorted((recordings / "sealed").glob("s*/"))
    chrono = sorted(p.parent for p in (recordings / "chrono").glob("*/signals.toml"))
    sealed = [case for case in sealed if (case / "signals.toml").is_file()]
    where("bicycle", "bicycle", [weave], lambda: bicycle(weave))
    for name, cases in (("practice", practice), ("Chrono", chrono)):
        where("trailers", name, cases, lambda n=name, c=cases: trailers(recordings, n, c))  # type: ignore[misc]
    where("trailers", "Chrono's ladder", chrono, lambda: iter([ladder(recordings, chrono)]))
    where("", "Chrono by size", chrono, lambda: iter([sizes(recordings, chrono)]))
    every = [*practice, *sealed, *chrono]
    where("controls", "slaloms", every, lambda: iter([slaloms(every)]))
    for car in ("infiniti_g35", "ferrari_250lm"):
        folder = recordings / "real" / car
        where("controls", car, [folder], lambda f=folder, c=car: iter([solo(f, c)]))  # type: ignore[misc]
    add(straight(drives), "controls")
    add(overlapping(drives), "controls")
    where("beside", "beside other methods", [weave], lambda: iter([beside(weave)]))
    for row in generated(max(4, drives // 3)):
        add(row, "")
    return rows


def main() -> int:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=Path, required=True)
    parser.add_argument("--drives", type=int, default=60, help="drawn drives (default: 60)")
    parser.add_argument("--report", type=Path, required=True)
    args = parser.parse_args()
    return written(table(shown(args.recordings, args.drives)), args.report)


if __name__ == "__main__":
    raise SystemExit(main())
