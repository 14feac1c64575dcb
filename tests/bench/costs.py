"""What a finding costs, as the diagnosis says it, beside what the concealed effect does to a plant.

Each case is diagnosed as by ``swaywatch diagnose`` (kept in a folder, so that a table is made
again at once; verdicts of before, without intervals, may lie there too). Costs are compared in
the middle swing, effects in windows window by window. The
plant's own figures:

- critical speeds: those of the smallest motions, beside ours in a swing of 1 deg/s;
- practice and road: the concealed effect with its true values in the true vehicle where that is
  the one of the file (practice, road tiers A and C), else in the calibrated one, whose critical
  speed is compared with that of the generator's plant (``plant_vcrit_kmh``) by itself;
- Chrono: damping ratios at 104 km/h, healthy and changed, and the healthy course over the speed.

A concealed effect that the diagnosis does not name counts with a cost of zero and as not held.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits
from written import written

from swaywatch.diagnose.engine import diagnose, write
from swaywatch.diagnose.fit.data import body_of
from swaywatch.diagnose.fit.fit import Fit, Problem
from swaywatch.diagnose.model import beliefs_in, terms_of
from swaywatch.diagnose.report.stability import MOVING, base_of, causes_of, stability
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect, library
from swaywatch.effects.library.axle_load_harmonic import generator_effect
from swaywatch.effects.runs import Run
from swaywatch.models.costs import KMH, SWINGS_RAD_S, Base, critical_speeds
from swaywatch.plant.lanes import BODY, neutral
from swaywatch.vehicle_file import load_vehicle

SMALL, MIDDLE = 0, 1
EXACT = ("A", "C")
LINEAR = (
    "steering_compliance", "tyre_relaxation", "hitch_damping", "trailer_aerodynamics", "roll_steer",
    "parameter_error",
)  # fmt: skip
"""Effects whose part in the critical speed has no size: the generator's figure is with them."""


CASES = (
    *(f"practice/p{k:02d}" for k in range(1, 11)),
    *(f"road/r{k:02d}" for k in range(1, 39)),
    "chrono/practice_chrono", *(f"chrono/x{k:02d}" for k in (3, 6, 7, 10)),
)  # fmt: skip


@dataclass(frozen=True)
class Row:
    """One figure: the plant's, and ours with its interval (NaN: nothing said)."""

    case: str
    what: str
    kind: str
    truth: float
    ours: float
    low: float
    high: float
    named: bool = True

    @property
    def held(self) -> bool:
        """Is the plant's figure inside the interval."""
        return self.low <= self.truth <= self.high


def diagnosed(folder: Path, kept: Path) -> dict[str, Any]:
    """diagnosis.json of a case, made where it is not kept yet."""
    path = kept / f"{folder.name}.json"
    if not path.exists():
        simulations = sorted(folder.glob("simulation_run*"))
        runs = [p for p in sorted(folder.glob("run[0-9].*")) if p not in simulations]
        result = diagnose(
            runs, folder / "vehicle.toml", folder / "signals.toml", simulations=simulations
        )
        write(result, path)
    return dict(json.loads(path.read_text()))


def problem_of(model: dict[str, Any], effects: list[Effect]) -> Problem:
    """Vehicle, beliefs and runs (without their signals) of a diagnosis."""
    runs = []
    for entry in model["runs"]:
        run = Run(entry["name"], np.zeros(2), {}, {}, float(model["steering_ratio"]))
        run.speed = np.full(2, 30.0)
        runs.append(run)
    body = np.array([model["vehicle"][name] for name in BODY])
    given = tuple((str(name), float(value)) for name, value in model["given"])
    calibration = terms_of(model.get("calibration", {}).get("terms", []), effects)
    return Problem(
        tuple(runs), body, not calibration, calibration, beliefs=beliefs_in(model), given=given
    )


def calibrated(model: dict[str, Any], effects: list[Effect]) -> Base:
    """The vehicle that the diagnosis ended with, without what it claims."""
    problem = problem_of(model, effects)
    at = [k for k, b in enumerate(problem.beliefs.items) if b.kind in MOVING]
    return base_of(problem, at, np.array(model["shift"]))


def weighed(result: dict[str, Any], effects: list[Effect]) -> tuple[dict[str, Any], bool]:
    """`stability` of a diagnosis and whether its intervals are stated.

    A verdict of before has none; its model still tells what its findings cost.
    """
    block = result.get("stability") or {}
    if "causes" in block:
        return block, True
    model = result["model"]
    fit = Fit(terms_of(model["terms"], effects), np.zeros((0, 5)), np.array(model["shift"]))
    return stability(problem_of(model, effects), fit, 1.0), False


def _found(effects: list[Effect], name: str) -> Effect:
    return next(e for e in effects if e.name == name)


def terms(effect: dict[str, Any], effects: list[Effect]) -> list[ActiveEffect]:
    """A concealed effect with its true values; of one in windows each window."""
    kind = effect["id"]
    axle = effect.get("axle", "all")
    values: dict[str, tuple[str, tuple[float, ...]]] = {
        "tyre_relaxation": (axle, (effect.get("length_m", 0.0),)),
        "tyre_saturation": ("all", (effect.get("peak_friction", 1e3),)),
        "hitch_damping": ("hitch", (effect.get("coefficient_nms_per_rad", 0.0),)),
        "trailer_aerodynamics": (
            "trailer",
            (effect.get("side_force_coefficient", 0), effect.get("yaw_moment_coefficient", 0)),
        ),
        "parameter_error": (effect.get("parameter", ""), (effect.get("factor", 1.0),)),
    }
    if kind == "steering_compliance":
        own = _found(effects, "steering_compliance:car_front")
        return [ActiveEffect(own, (1.0 / effect["stiffness_n_per_rad"],))]
    if kind == "hitch_friction":
        own = _found(effects, "hitch_friction:hitch")
        rest = tuple(p.neutral for p in own.parameters[1:])
        return [ActiveEffect(own, (effect["moment_nm"], *rest))]
    if kind == "axle_load_harmonic":
        pairs = zip(effect["amplitude_n"], effect["delay"], strict=True)
        return [
            ActiveEffect(generator_effect(axle), (0.0, 1.0, a, delay), (0,)) for a, delay in pairs
        ]
    if kind not in values:
        return []
    component, numbers = values[kind]
    return [ActiveEffect(_found(effects, f"{kind}:{component}"), tuple(float(v) for v in numbers))]


def speeds(base: Base, every: list[ActiveEffect]) -> list[float]:
    """Critical speed without anything and with each term in turn, km/h; NaN: none."""
    causes = [causes_of(term, 0)[0][0] for term in every]
    cases = [(base, (), SWINGS_RAD_S[MIDDLE])]
    cases += [(base, (cause,), SWINGS_RAD_S[MIDDLE]) for cause in causes]
    return [math.nan if v is None else KMH * v for v in critical_speeds(cases)]


def _windows(truth: dict[str, Any]) -> Iterator[tuple[str, int, float, float]]:
    for number in (1, 2):
        for k, (start, stop) in enumerate(truth[f"run{number}"]["windows"]):
            yield f"run {number}", k, start, stop


def _pairs(
    truth: dict[str, Any], cause: dict[str, Any] | None, backs: list[float]
) -> Iterator[tuple[str, float, dict[str, float] | None]]:
    """What each window truly gives back, beside the claimed window that overlaps most."""
    for run, k, start, stop in _windows(truth):
        best: tuple[float, dict[str, float] | None] = (0.5 * (stop - start), None)
        for w in cause["windows"] if cause else []:
            overlap = min(stop, w["stop"]) - max(start, w["start"])
            if w["run"] == run and overlap > best[0]:
                best = (overlap, w["gives_back_km_h"])
        yield f"{run}, {start:.0f} to {stop:.0f} s", backs[k], best[1]


def _row(case: str, what: str, kind: str, truth: float, ours: dict[str, float] | None) -> Row:
    if ours is None:
        return Row(case, what, kind, truth, 0.0, math.nan, math.nan, named=False)
    return Row(case, what, kind, truth, ours["value"], ours["low"], ours["high"])


def driven(case: str, folder: Path, result: dict[str, Any], effects: list[Effect]) -> list[Row]:
    """Rows of a practice or road case."""
    truth = json.loads((folder / "truth.json").read_text())
    block, rows = result["stability"], []
    model = result["model"]
    exact = truth.get("tier", "A") in EXACT
    vehicle = load_vehicle(folder / "vehicle.toml")
    base = Base(body_of(vehicle), neutral()) if exact else calibrated(model, effects)
    by_id = {cause["id"]: cause for cause in block["causes"]}
    for effect in truth["effects"]:
        own = terms(effect, effects)
        if not own:
            continue
        without, *with_it = speeds(base, own)
        backs = [without - v for v in with_it]
        cause = by_id.get(effect["id"])
        if own[0].effect.windowed:
            for words, back, ours in _pairs(truth, cause, backs):
                rows.append(_row(case, f"{effect['id']}, {words}", "cost", back, ours))
        else:
            ours = cause["gives_back_km_h"][MIDDLE] if cause else None
            rows.append(_row(case, effect["id"], "cost", backs[0], ours))
    if any(effect["id"] == "outside_library" for effect in truth["effects"]):
        return rows
    ours = _smallest(block)
    if ours is not None:
        rows.append(_row(case, "critical speed", "speed", truth["plant_vcrit_kmh"], ours))
    return rows


def _smallest(block: dict[str, Any]) -> dict[str, float] | None:
    """Our critical speed of the smallest motions, as of the generator's eigenvalues.

    In a swing of 1 deg/s tyres are still linear; findings that act by the size of the swing are
    left out, those that do not are in.
    """
    sized = [cause for cause in block["causes"] if cause["id"] not in LINEAR]
    found: list[dict[str, float] | None] = [None]
    if not sized:
        found = block["diagnosed"]["v_crit_km_h"]
    elif len(sized) == len(block["causes"]):
        found = block["calibrated"]["v_crit_km_h"]
    elif len(sized) == 1:
        found = sized[0]["v_crit_without_km_h"]
    return found[SMALL]


def chrono(case: str, folder: Path, result: dict[str, Any]) -> list[Row]:
    """Rows of a Chrono case: what all of its changes cost together, at small amplitude."""
    truth = json.loads((folder.parent / "truth" / f"{folder.name}.json").read_text())
    course = [(p["v_kmh"], p["zeta"]) for p in truth["healthy_damping_vs_speed"]]
    speed, zeta = (np.array(column) for column in zip(*course, strict=True))
    small = truth["damping_small_amplitude_104kmh"]
    change = small["changed"]["zeta"] - small["healthy"]["zeta"]
    healthy, changed = (_zero(speed, zeta + off) for off in (0.0, change))
    block = result["stability"]
    before, after = (block[k]["v_crit_km_h"][SMALL] for k in ("calibrated", "diagnosed"))
    names = " + ".join(effect["id"] for effect in truth["effects"])
    ours: dict[str, float] | None = None
    if before is not None and after is not None:
        spread = math.hypot(*((c["gives_back_km_h"][SMALL] or {"high": 0.0, "value": 0.0})["high"]
                              - (c["gives_back_km_h"][SMALL] or {"value": 0.0})["value"]
                              for c in block["causes"]), 0.0)  # fmt: skip
        back = before["value"] - after["value"]
        ours = {"value": back, "low": back - spread, "high": back + spread}
        if not block["causes"]:
            ours = None
    return [_row(case, names, "cost", healthy - changed, ours)]


def _zero(speed: NDArray[np.float64], zeta: NDArray[np.float64]) -> float:
    return float(np.interp(0.0, -zeta, speed))


def summary(rows: list[Row], kind: str, words: str) -> list[str]:
    """Median error and share of intervals that hold."""
    own = [row for row in rows if row.kind == kind]
    if not own:
        return []
    off = np.abs([row.ours - row.truth for row in own])
    named = np.abs([row.ours - row.truth for row in own if row.named])
    said = [row for row in own if not math.isnan(row.low)]
    held = sum(row.held for row in said)
    return [
        f"- {words}: {len(own)} figures, median error {np.median(off):.2f} km/h, nine tenths "
        f"within {np.quantile(off, 0.9):.1f} km/h; the {len(named)} of what the diagnosis names "
        f"{np.median(named):.2f} km/h; {held} of {len(said)} intervals "
        f"({100 * held / max(len(said), 1):.0f} %, stated 90 %) hold the plant's figure",
    ]


def main() -> int:
    """Diagnose, compare, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=Path, required=True)
    parser.add_argument("--kept", type=Path, required=True, help="folder of the diagnoses")
    parser.add_argument("--report", type=Path, required=True)
    parser.add_argument("--only-kept", action="store_true", help="diagnose nothing")
    parser.add_argument("cases", nargs="*", default=CASES)
    args = parser.parse_args()
    args.kept.mkdir(parents=True, exist_ok=True)
    effects, rows = library(), []
    for case in args.cases:
        folder = args.recordings / case
        if args.only_kept and not (args.kept / f"{folder.name}.json").exists():
            continue
        result = diagnosed(folder, args.kept)
        if not result.get("model"):
            continue
        with threadpool_limits(1):
            result["stability"], stated = weighed(result, effects)
            found = (
                chrono(case, folder, result)
                if case.startswith("chrono")
                else driven(case, folder, result, effects)
            )
        nothing = {} if stated else {"low": math.nan, "high": math.nan}
        rows += [replace(row, **nothing) for row in found]
    lines = [
        "**`make bench-costs`**: critical speed and what effects cost, beside the plant's own",
        "",
        "| case | what | the plant's, km/h | ours, 90 % interval | holds |",
        "|---|---|---|---|---|",
    ]
    for row in rows:
        bounded = not math.isnan(row.low)
        ours = f"{row.ours:.1f}" + (f" ({row.low:.1f} to {row.high:.1f})" if bounded else "")
        ours = ours if row.named else "not named: 0"
        held = ("yes" if row.held else "no") if bounded else "-"
        lines.append(f"| {row.case} | {row.what} | {row.truth:.1f} | {ours} | {held} |")
    lines.append("")
    lines += summary(rows, "cost", "what comes back without a concealed effect")
    lines += summary(rows, "speed", "critical speed of the plant")
    return written(lines, args.report)


if __name__ == "__main__":
    raise SystemExit(main())
