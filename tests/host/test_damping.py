"""``swaywatch damping``: swings found, values inside their intervals, forced or free."""

from __future__ import annotations

import csv
import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import control
import numpy as np
import pytest
import scipy.io
from conftest import DATA, recordings
from numpy.typing import NDArray
from scipy import signal

from swaywatch.cli import main
from swaywatch.damping.alike import parted
from swaywatch.damping.compare import compare_groups, compare_model
from swaywatch.damping.course import Bend, fit_course, levels, mean_of
from swaywatch.damping.data import NO_SIGNAL, Choice, DampingRun, load_runs
from swaywatch.damping.find import find
from swaywatch.damping.intervals import IntervalValue, Point, points_of
from swaywatch.damping.model import from_systems, load_model
from swaywatch.damping.sentences import comparison_words, sentences, verdict
from swaywatch.damping.size import small_swing
from swaywatch.damping.study import Study, StudyPlan, evaluate, study_of
from swaywatch.damping.window import Estimator
from swaywatch.errors import ModelError, RecordingError, SignalError
from swaywatch.recording import Series, write_recording

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "bench"))

import bicycle_free
import damping_hands

Array = NDArray[np.float64]
PRACTICE = DATA / "practice"
BAND = (0.2, 10.0)
SPEED = {
    "7.2": 2.0, "9": 2.5, "10.8": 3.0, "12.6": 3.5, "14.4": 4.0, "16.2": 4.5, "18": 5.0,
}  # fmt: skip


def a_run(
    value: Array, step_s: float, inputs: Array | None = None, speed: float = 10.0
) -> DampingRun:
    """A run of plain arrays; value (n, channels), inputs (n, 1)."""
    rows, channels = value.shape
    names = () if inputs is None else ("wheel",)
    return DampingRun(
        "run", Path("run.csv"), np.arange(rows) * step_s, step_s,
        tuple(f"c{k}" for k in range(channels)), ("",) * channels, value,
        np.ones(rows, dtype=np.bool_), names,
        np.zeros((rows, 0)) if inputs is None else inputs,
        np.full(rows, speed), "speed", "m/s",
    )  # fmt: skip


def disturbed_swing(
    rng: np.random.Generator, frequency_hz: float, ratio: float, rate_hz: float, share: float
) -> Array:
    """A mode under process noise, hit four times; rate and angle. `share`: noise over swing."""
    omega = 2 * math.pi * frequency_hz / math.sqrt(1 - ratio**2)
    cycles = 16 if ratio > 0.1 else 40
    rows = int(5 * cycles / frequency_hz * rate_hz)
    force = rng.normal(0.0, 1.0, rows)
    system = signal.StateSpace(
        [[0.0, 1.0], [-(omega**2), -2 * ratio * omega]], [[0.0], [1.0]], np.eye(2), np.zeros((2, 1))
    )
    dense = signal.cont2discrete((system.A, system.B, system.C, system.D), 1 / rate_hz)
    _, ambient, _ = signal.dlsim((*dense[:4], 1 / rate_hz), force)
    impulse = np.zeros(rows)
    hits = (np.arange(1, 5) * cycles / frequency_hz * rate_hz).astype(int)
    impulse[hits] = 1.0
    _, free, _ = signal.dlsim((*dense[:4], 1 / rate_hz), impulse)
    free /= np.abs(free).max(axis=0)
    ambient *= share / ambient.std(axis=0)
    return np.asarray(free + ambient + rng.normal(0.0, 0.003, free.shape) + [0.5, -2.0])


def test_intervals_hold_any_vehicle_with_process_noise() -> None:
    rng = np.random.default_rng(5)
    estimator = Estimator()
    inside: list[bool] = []
    found, hits = 0, 0
    for _ in range(24):
        frequency = float(np.exp(rng.uniform(math.log(0.3), math.log(8.0))))
        rate = float(rng.choice([16.0, 40.0, 100.0])) * frequency
        ratio = float(rng.choice([0.03, 0.1, 0.2, 0.3]))
        value = disturbed_swing(rng, frequency, ratio, rate, float(rng.choice([0.02, 0.06])))
        points = points_of(find(a_run(value, 1 / rate), BAND, estimator))
        hits += 4
        found += min(4, len({point.number for point in points}))
        for point in points:
            inside.append(abs(point.damping_ratio.value - ratio) <= point.damping_ratio.half)
            assert point.frequency_hz.value == pytest.approx(frequency, rel=0.4)
    assert found >= 0.95 * hits
    assert 0.85 <= np.mean(inside) <= 0.99, np.mean(inside)


def test_ambient_motion_alone_is_no_oscillation() -> None:
    rng = np.random.default_rng(8)
    estimator = Estimator()
    free, windows = 0, 0.0
    for ratio in (0.15, 0.3, 0.5):
        for _ in range(4):
            value = disturbed_swing(rng, 1.0, ratio, 50.0, 1e3)  # the hits drown in it
            points = points_of(find(a_run(value, 0.02), BAND, estimator))
            free += sum(point.determinable for point in points)
            windows += len(value) * 0.02 / 2.0
    assert free <= 0.02 * windows


def test_slalom_is_forced_and_the_swing_after_it_free() -> None:
    rate, rows = 50.0, 3000
    time = np.arange(rows) / rate
    wheel = np.where((time > 10) & (time < 25), np.sin(2 * math.pi * 0.6 * time), 0.0)
    omega = 2 * math.pi * 0.6
    tf = signal.TransferFunction([omega**2], [1.0, 2 * 0.1 * omega, omega**2])
    _, y, _ = signal.lsim(tf, wheel, time)
    rng = np.random.default_rng(2)
    value = (y + rng.normal(0, 0.02, rows))[:, None]
    inputs = (wheel + rng.normal(0, 0.002, rows))[:, None]
    found = find(a_run(value, 1 / rate, inputs), BAND, Estimator())
    for point in points_of(found):
        assert point.start_s > 24.5
        assert abs(point.damping_ratio.value - 0.1) <= point.damping_ratio.half + 0.01


def steered(
    rng: np.random.Generator, ratio: float, rate_hz: float, wheel: Array, share: float
) -> Array:
    """Mode of 1 Hz that a wheel drives under process noise; rate and angle.

    `share`: of process noise in the largest swing.
    """
    omega = 2 * math.pi
    system = signal.StateSpace(
        [[0.0, 1.0], [-(omega**2), -2 * ratio * omega]], [[0.0], [1.0]], np.eye(2), np.zeros((2, 1))
    )
    time = np.arange(len(wheel)) / rate_hz
    _, driven, _ = signal.lsim(system, wheel, time)
    _, ambient, _ = signal.lsim(system, rng.normal(0.0, 1.0, len(wheel)), time)
    largest = np.abs(driven).max(axis=0)
    value = driven / largest + share * ambient / ambient.std(axis=0)
    return np.asarray(value + rng.normal(0.0, 0.003, value.shape))


def test_swings_that_do_not_die_out_are_found_by_what_began_them() -> None:
    """Two pulses of the wheel in 38 s, weakly damped: there is no quiet time after the first."""
    rng = np.random.default_rng(20)
    estimator = Estimator()
    rate, inside = 40.0, []
    time = np.arange(0.0, 38.0, 1.0 / rate)
    for ratio in (0.003, 0.01, 0.02, 0.03):
        for _ in range(4):
            starts = (float(rng.uniform(4, 6)), float(rng.uniform(20, 24)))
            wheel = rng.normal(0.0, 0.02, len(time))
            for start in starts:
                inside_pulse = (time >= start) & (time < start + 0.5)
                wheel += np.where(inside_pulse, np.sin(2 * math.pi * (time - start)), 0.0)
            value = steered(rng, ratio, rate, wheel, 0.02)
            points = points_of(find(a_run(value, 1 / rate, wheel[:, None]), BAND, estimator))
            assert {point.number for point in points} == {1, 2}, ratio
            for start in starts:
                assert not any(p.start_s < start + 0.4 and p.end_s > start + 0.1 for p in points)
            mean = mean_of([point.damping_ratio for point in points])
            inside.append(abs(mean.value - ratio) <= mean.half)
            assert abs(mean.value - ratio) < 0.01
    assert np.mean(inside) >= 0.8, np.mean(inside)


def test_a_hand_that_is_never_still_begins_no_swing() -> None:
    """Motion from the road under a nervous hand: nothing is determinable."""
    rng = np.random.default_rng(21)
    estimator = Estimator()
    free, windows = 0, 0.0
    rate = 40.0
    for ratio in (0.02, 0.05, 0.15):
        for _ in range(6):
            hand = rng.normal(0.0, 1.0, 2400)
            hand = signal.sosfiltfilt(signal.butter(2, 0.5, fs=rate, output="sos"), hand)
            value = steered(rng, ratio, rate, hand, 1.0)
            points = points_of(find(a_run(value, 1 / rate, hand[:, None]), BAND, estimator))
            free += sum(point.determinable for point in points)
            windows += 30.0
    assert free <= 0.01 * windows, free


def test_slalom_at_any_frequency_is_forced() -> None:
    rng = np.random.default_rng(22)
    estimator = Estimator()
    rate = 40.0
    time = np.arange(0.0, 40.0, 1.0 / rate)
    for ratio in (0.02, 0.1, 0.2):
        for frequency in (0.5, 0.7, 0.85, 1.0, 1.2):
            wheel = np.where((time > 5) & (time < 36), np.sin(2 * math.pi * frequency * time), 0.0)
            wheel += rng.normal(0.0, 0.01, len(time))
            value = steered(rng, ratio, rate, wheel, 0.01)
            for point in points_of(find(a_run(value, 1 / rate, wheel[:, None]), BAND, estimator)):
                assert point.start_s > 35.5, (ratio, frequency, point)


def test_practice_agrees_with_analyze(tmp_path: Path) -> None:
    case = PRACTICE / "p01"
    arguments = ["damping", str(case / "run1.blf"), "--signals", str(case / "signals.toml")]
    assert main([*arguments, "--out", str(tmp_path)]) == 0
    content = json.loads((tmp_path / "damping.json").read_text())
    place = content["places"][0]
    assert main(
        ["analyze", str(case / "run1.blf"), "--vehicle", str(case / "vehicle.toml"), "--signals",
         str(case / "signals.toml"), "--out", str(tmp_path / "a"), "--no-report"]
    ) == 0  # fmt: skip
    values = json.loads((tmp_path / "a" / "summary.json").read_text())["drives"][0]["values"]
    own = place["damping_ratio"]
    assert own["low_95"] <= values["damping_ratio"]["value"] <= own["high_95"]
    assert "<figure class='plot'" in (tmp_path / "damping.html").read_text()


def test_slalom_of_practice_is_forced() -> None:
    case = PRACTICE / "p03"
    choice = Choice(signals=case / "signals.toml")
    found = find(load_runs([case / "run2.asc"], choice)[0], BAND, Estimator())
    assert points_of(found) == []
    assert any(event.forced_by == "steering_wheel_angle" for event in found.events)


def test_a_hand_that_wanders_is_taken_out() -> None:
    """A mode that the wheel drives: a pulse, then a hand that is never still."""
    estimator = Estimator()
    off, without = [], []
    for seed in range(12):
        rng = np.random.default_rng((7, seed))
        omega, ratio, step = 2 * math.pi * 0.7, float(rng.choice([0.04, 0.08])), 0.02
        rows = 1500
        wheel = 0.05 * signal.lfilter([0.1], [1.0, -0.9], rng.normal(size=rows))
        wheel[250:275] += 1.0
        s = complex(-ratio, math.sqrt(1 - ratio**2)) * omega
        pole = np.exp(s * step)
        z = signal.lfilter([(pole - 1) / s], [1.0, -pole], wheel)
        value = z.real + 0.002 * rng.normal(size=rows)
        run = a_run(value[:, None], step, wheel[:, None])
        points = points_of(find(run, BAND, estimator))
        unnamed = replace(run, input_names=(), inputs=np.zeros((rows, 0)))
        blind = points_of(find(unnamed, BAND, estimator))
        if not points or not blind:
            continue
        off.append(points[0].damping_ratio.value - ratio)
        without.append(blind[0].damping_ratio.value - ratio)
    assert len(off) >= 8
    assert np.std(off) < 0.5 * np.std(without)


def test_a_swing_unlike_the_others_is_left_out() -> None:
    """Seven swings of 1 Hz, one of 0.7 Hz: named, not averaged; eight alike: all kept."""
    rng = np.random.default_rng(3)
    for odd in (True, False):
        time = np.arange(9600) * 0.02
        value = 0.01 * rng.normal(size=len(time))
        for k in range(8):
            since = time - 10.0 - 22.0 * k
            omega = 2 * math.pi * (0.7 if odd and k == 4 else 1.0)
            value += np.where(since > 0, np.exp(-0.1 * omega * since) * np.sin(omega * since), 0.0)
        points = points_of(find(a_run(value[:, None], 0.02), BAND, Estimator()))
        usual, others = parted(points)
        assert len({p.number for p in points}) == 8
        at = {round((p.start_s - 10.0) / 22.0) for p in others}
        assert at == ({4} if odd else set())
        assert len(usual) + len(others) == len(points)


@pytest.mark.parametrize("along", [False, True])
@pytest.mark.parametrize("hand", [0.0, 0.1, 0.8])
def test_a_hand_is_seen_in_what_swings_along(hand: float, along: bool) -> None:
    """Of eight swings one has a slow force in the second signal only; as a part of the swing."""
    rng = np.random.default_rng(5)
    time = np.arange(9600) * 0.02
    value = 0.01 * rng.normal(size=(len(time), 2))
    mode = complex(-0.1, 1.0) * 2 * math.pi
    for k in range(8):
        since = time - 10.0 - 22.0 * k
        swing = np.where(since > 0, np.exp(mode * np.maximum(since, 0.0)), 0.0)
        value += np.stack([swing.imag, (0.5 * np.exp(2.0j) * swing).real], axis=1)
        if k == 4:
            value[:, 1] += hand * 0.5 * np.where(since > 0, np.exp(-1.2 * np.abs(since)), 0.0)
    run = a_run(value[:, :1], 0.02)
    if along:
        run = replace(run, along_names=("fork",), along=value[:, 1:])
    points = points_of(find(run, BAND, Estimator()))
    assert len({p.number for p in points}) == 8
    _, others = parted(points)
    at = {round((p.start_s - 10.0) / 22.0) for p in others}
    assert at == ({4} if along and hand > 0.5 else set())
    # where no shape is usual, nobody can say which is the mode's
    none = [
        replace(p, shape=p.shape._replace(middle=p.shape.middle * np.array([1.0, 1j**k])))
        for k, p in enumerate(points)
        if p.shape is not None
    ]
    assert not parted(none)[1]


def test_withdrawn_hands_of_generated_bicycles_are_left_out() -> None:
    """`python tests/bench/damping_hands.py` does 120 of these."""
    found = damping_hands.kept(30_001, 12)
    assert found.free > 80
    assert found.held > 15
    assert found.free_kept >= 0.95 * found.free
    assert found.held_kept <= 0.5 * found.held


def test_what_creeps_back_has_no_damping_ratio() -> None:
    """Pulses on modes of 0.9 and 1.15 in process noise: no damping ratio stated; of 0.4: stated."""
    step, count = 0.01, 7000
    omega = 2 * math.pi * 1.6
    stated = {}
    for ratio in (0.9, 1.15, 0.4):
        a = np.array([[0.0, 1.0], [-(omega**2), -2 * ratio * omega]])
        system = (a, np.array([[0.0], [1.0]]), np.array([[0.0, 1.0]]), np.zeros((1, 1)))
        stated[ratio] = 0
        for seed in range(4):
            rng = np.random.default_rng(seed)
            force = 0.35 * rng.normal(size=count)
            for k in range(5):
                force[800 + 1200 * k : 810 + 1200 * k] += 5.0 * (-1) ** k
            _, rate, _ = signal.dlsim((*signal.cont2discrete(system, step)[:4], step), force)
            value = rate + 0.01 * np.abs(rate).max() * rng.normal(size=rate.shape)
            study = study_of([a_run(value, step)], StudyPlan(Choice()))
            stated[ratio] += any(place.determinable for place in study.places)
            if ratio > 0.5 and study.places:
                assert "not determinable" in verdict(study)[1]
    assert stated == {0.9: 0, 1.15: 0, 0.4: 4}


def test_a_speed_that_is_held_is_one_place() -> None:
    """A nominal speed held within 5 % is one place; 95, 100 and 105 km/h are three."""
    held = np.linspace(4.88, 5.12, 24)
    assert [len(group) for group in levels(held)] == [24]
    steps = np.concatenate([v + np.linspace(-0.1, 0.1, 6) for v in (26.4, 27.8, 29.2)])
    assert [len(group) for group in levels(steps)] == [6, 6, 6]


def test_a_structure_of_structures_is_read(tmp_path: Path) -> None:
    """As data acquisition writes it: one structure, in it data and units of every signal."""
    time = np.arange(0.0, 40.0, 0.1)
    since = time - 10.0
    rate = np.where(since > 0, np.exp(-0.2 * since) * np.sin(2.0 * since), 0.0)
    content = {
        name: {"data": value[:, None], "units": unit}
        for name, value, unit in (
            ("time", time, "s"), ("bYawRate", rate, "deg/s"), ("delta_r", 0.0 * time, "deg"),
        )
    }  # fmt: skip
    path = tmp_path / "flight.mat"
    scipy.io.savemat(path, {"flightdata": content})
    (run,) = load_runs([path], Choice())
    assert run.channels == ("bYawRate",)
    assert run.units == ("deg/s",)
    assert run.may_drive == ()  # the rudder does not move
    (point, *_) = points_of(find(run, BAND, Estimator()))
    assert point.damping_ratio.value == pytest.approx(0.0995, abs=0.01)


@pytest.mark.parametrize("name", ["run1.blf", "simulation_run1.mf4"])
def test_chrono_ladder_is_inside(name: str) -> None:
    """0.056 at small amplitude at 104 km/h, 0.59 Hz (recordings README)."""
    case = recordings("chrono", "practice_chrono")
    choice = Choice(signals=case / "signals.toml")
    points = points_of(find(load_runs([case / name], choice)[0], BAND, Estimator()))
    small = small_swing(points)
    assert small is not None
    assert small.damping_ratio is not None
    assert small.damping_ratio.low <= 0.056 <= small.damping_ratio.high
    assert small.damping_ratio.half < 0.015
    assert points[0].frequency_hz.value == pytest.approx(0.59, abs=0.02)


@pytest.mark.parametrize("car", ["infiniti_g35", "ferrari_250lm"])
def test_solo_cars_do_not_swing(car: str) -> None:
    folder = recordings("real", car)
    choice = Choice(signals=DATA / "real" / f"{car}.toml")
    sure, windows = 0, 0.0
    for run in load_runs(sorted(folder.glob("*.mf4")), choice):
        found = find(run, BAND, Estimator())
        points = points_of(found)
        sure += sum(point.determinable for point in points)
        windows += run.duration_s * found.frequency_hz / 2.0
    assert sure <= max(0.01 * windows, 0.0)


@pytest.mark.parametrize("suffix", [".csv", ".mf4", ".mat", ".parquet"])
def test_rate_and_format_of_the_file_do_not_matter(tmp_path: Path, suffix: str) -> None:
    """The same swing at 10 to 1000 Hz gives the same frequency and damping."""
    found = []
    for rate in (10.0, 100.0, 1000.0):
        time = np.arange(0.0, 60.0, 1.0 / rate)
        rng = np.random.default_rng(4)
        value = rng.normal(0.0, 0.004, len(time))
        for hit in (12.0, 30.0, 46.0):
            since = np.maximum(time - hit, 0.0)
            value += np.exp(-0.5 * since) * np.sin(2 * math.pi * 0.8 * since)
        stamps = np.rint(time * 1e9).astype(np.int64)
        file = tmp_path / f"r{rate:g}{suffix}"
        write_recording(file, {"yaw_rate": Series(stamps, value, "rad/s")})
        (run,) = load_runs([file], Choice(("yaw_rate",)))
        points = points_of(find(run, BAND, Estimator()))
        assert len({point.number for point in points}) == 3
        found.append(points[0])
    truth = 0.5 / math.hypot(0.5, 2 * math.pi * 0.8)
    for point in found:
        assert point.frequency_hz.value == pytest.approx(0.8, rel=0.02)
        assert point.damping_ratio.value == pytest.approx(truth, abs=0.01)


# --- short recordings, controllers, other people's files ------------------------------------------


def dutch_roll(gain: float, rate_hz: float, rows: int, seed: int) -> tuple[Array, Array, float]:
    """Sideslip, roll and yaw rate of an aeroplane after a rudder doublet at 5 s; rudder; truth.

    `gain`: of a yaw damper on the rudder, which is in the rudder's signal.
    """
    a = np.array([[-0.12, 0, -1, 0.054], [-9, -1.6, 0.5, 0], [3, -0.06, -0.25, 0], [0, 1, 0, 0]])
    b = np.array([[0.02], [1.0], [-1.8], [0.0]])
    closed = a + b @ np.array([[0.0, 0.0, gain, 0.0]])
    gust = np.array([[0.3], [0.2], [0.2], [0.0]])
    time = np.arange(rows) / rate_hz
    pilot = 0.05 * (((time >= 5) & (time < 5.8)) * 1.0 - ((time >= 5.8) & (time < 6.6)) * 1.0)
    rng = np.random.default_rng(seed)
    system = signal.StateSpace(closed, np.hstack([b, gust]), np.eye(4), np.zeros((4, 2)))
    _, state, _ = signal.lsim(system, np.column_stack([pilot, rng.normal(0, 0.004, rows)]), time)
    poles = np.linalg.eigvals(closed)
    pole = poles[np.argmax(poles.imag)]
    value = state[:, :3] + rng.normal(0, 0.0008, (rows, 3))
    return value, (pilot + gain * state[:, 2])[:, None], float(-pole.real / abs(pole))


def test_dutch_roll_with_and_without_its_damper() -> None:
    """The swing without the damper fills a record of 25 s; the damper moves the rudder."""
    estimator = Estimator()
    inside, points = [], {}
    for gain in (0.0, 0.5):
        for seed in range(6):
            value, rudder, truth = dutch_roll(gain, 20.0, 500, seed)
            found = find(a_run(value, 0.05, rudder), BAND, estimator)
            own = points_of(found)[:1]
            assert own, (gain, seed)
            assert own[0].start_s > 5.8
            assert any(event.followed_by for event in found.events) == (gain > 0.0)
            points.setdefault(gain, []).append(own[0])
            inside.append(abs(own[0].damping_ratio.value - truth) <= own[0].damping_ratio.half)
    assert sum(inside) >= 10
    both = compare_groups(points[0.0], points[0.5], ("off", "on"))
    assert both is not None
    assert both.p_value < 1e-3


def test_no_window_begins_within_the_pilots_doublet(tmp_path: Path) -> None:
    """Nobody names the rudder; a window that holds some of its doublet shows too little damping."""
    off = []
    for seed in range(4):
        value, rudder, truth = dutch_roll(0.0, 20.0, 800, seed)
        rows = np.column_stack([np.arange(800) / 20.0, value, rudder])
        path = tmp_path / f"{seed}.csv"
        np.savetxt(path, rows, delimiter=",", header="time_s,beta,p,r,rudder", comments="")
        for inputs in ((), (NO_SIGNAL,)):
            study = evaluate([path], StudyPlan(Choice(inputs=inputs)))
            if not inputs:
                assert study.points[0].start_s > 6.55
                off.append(abs(study.points[0].damping_ratio.value - truth))
            else:
                assert not study.found[0].run.input_names
    assert np.median(off) < 0.01


def test_short_recordings_hold_their_truth() -> None:
    """4 to 20 cycles with one swing: found, and no surer than the motion meanwhile allows."""
    rng = np.random.default_rng(11)
    estimator = Estimator()
    inside: list[bool] = []
    for ratio in (0.02, 0.05, 0.15, 0.35):
        for cycles, before in ((4, 0.0), (8, 0.0), (8, 1.5), (20, 2.0)):
            for _ in range(3):
                value = disturbed_swing(rng, 1.0, ratio, 40.0, 0.02)
                period = 16 if ratio > 0.1 else 40
                first = int((period - before) * 40.0)
                part = value[first : first + cycles * 40]
                points = points_of(find(a_run(part, 0.025), BAND, estimator))
                assert points, (ratio, cycles, before)
                truth = abs(points[0].damping_ratio.value - ratio)
                inside.append(truth <= points[0].damping_ratio.half)
    assert np.mean(inside) >= 0.8, np.mean(inside)


def test_short_recordings_of_nothing_are_nothing() -> None:
    rng = np.random.default_rng(3)
    estimator = Estimator()
    free, windows = 0, 0.0
    for ratio in (0.05, 0.15, 0.4):
        for cycles in (6, 12, 30):
            for _ in range(4):
                value = disturbed_swing(rng, 1.0, ratio, 40.0, 1e3)[: cycles * 40]
                points = points_of(find(a_run(value, 0.025), BAND, estimator))
                free += sum(point.determinable for point in points)
                windows += cycles / 2.0
    assert free <= 0.02 * windows


def test_units_separators_and_an_unnamed_input(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two groups of CSV files with units in the head, a decimal comma; the pilot is not named."""
    for name, gain in (("off", 0.0), ("on", 0.5)):
        value, rudder, _ = dutch_roll(gain, 20.0, 800, 1)
        rows = np.column_stack([np.arange(800) / 20.0, np.degrees(value), np.degrees(rudder)])
        lines = ["Time (s);beta (deg);p (deg/s);r (deg/s);rudder (deg);TAS (kt)"]
        for row in rows:
            lines.append(";".join(f"{one:.4f}".replace(".", ",") for one in (*row, 350.0)))
        (tmp_path / f"{name}.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "m.csv").write_text("Speed (m/s),zeta,f_hz\n170,0.052,0.289\n190,0.052,0.289\n")
    arguments = ["damping", str(tmp_path / "off.csv"), "--compare", str(tmp_path / "on.csv")]
    assert main([*arguments, "--names", "off", "on", "--out", str(tmp_path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "Taken as the driver's or pilot's input by name: rudder" in said
    assert "The damping ratio of off is lower than that of on" in said
    assert main([*arguments, "--input", "none", "--out", str(tmp_path)]) == 0
    assert "In the files that could be rudder" in " ".join(capsys.readouterr().out.split())
    model = [*arguments[:2], "--model", str(tmp_path / "m.csv"), "--input", "rudder"]
    assert main([*model, "--out", str(tmp_path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "of m.csv and as measured agree" in said


def test_a_model_of_one_condition_needs_no_speed(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text("damping_ratio,frequency_hz\n0.1,1.0\n")
    scipy.io.savemat(tmp_path / "m.mat", {"A": np.array([[0.0, 1.0], [-40.0, -1.0]])})
    points = [_point(math.nan, 0.1 + 0.002 * k) for k in (-1, 0, 1)]
    against = compare_model(points, load_model(str(tmp_path / "m.csv")))
    assert against is not None
    assert against.p_value > 0.1
    assert load_model(str(tmp_path / "m.mat")).pole(math.nan, 6j).imag == pytest.approx(
        6.305, abs=0.01
    )
    (tmp_path / "k.csv").write_text("speed_kmh,zeta,f_hz\n36,0.1,1.0\n72,0.3,1.0\n")
    model = load_model(str(tmp_path / "k.csv")).over("m/s")
    pole = model.pole(15.0, 6j)
    assert pole is not None
    assert -pole.real / abs(pole) == pytest.approx(0.2, abs=0.005)


# --- the bicycle --------------------------------------------------------------------------------


def _pushes(folder: Path) -> list[dict[str, str]]:
    with (folder / "segments_and_fits.csv").open() as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def bicycle() -> tuple[Path, dict[tuple[str, float], list[Point]], int, int]:
    """Points of the authors' pushes by controller and speed; pushes, and those found."""
    folder = recordings("real", "bicycle_weave")
    pushes = _pushes(folder)
    estimator = Estimator()
    points: dict[tuple[str, float], list[Point]] = {}
    count = hit = 0
    for mode in ("normal", "mm"):
        for name, speed in {"5.4": 1.5, **SPEED}.items():
            (run,) = load_runs(
                [folder / f"{mode}_{name}kph.parquet"], Choice(("lean_rate",), (), "speed")
            )
            own = points_of(find(run, BAND, estimator))
            starts = [
                int(p["start"]) / 100
                for p in pushes
                if p["mode"] == mode and float(p["v_mps"]) == speed
            ]
            chosen = [[p for p in own if abs(p.start_s - start) < 0.5][:1] for start in starts]
            count += len(starts)
            hit += sum(map(len, chosen))
            points[mode, speed] = [p for one in chosen for p in one]
    return folder, points, count, hit


def test_pushes_are_found(bicycle: Any) -> None:
    _, _, count, hit = bicycle
    assert count == 107
    assert hit >= 0.95 * count


def test_pushes_are_found_and_hands_left_out_by_the_fork(bicycle: Any) -> None:
    """Both requirements hold without an option: pushes found, few false ones."""
    folder, *_ = bicycle
    sure = bicycle_free.count(bicycle_free.places_of(folder))
    assert sure.pushes_found >= 0.95 * sure.pushes
    assert sure.forced + sure.other_mode <= 0.02 * sure.judged


def test_means_are_those_of_a_hand_fit(bicycle: Any) -> None:
    folder, points, _, _ = bicycle
    pushes = _pushes(folder)
    off = []
    for (mode, speed), own in points.items():
        if speed == 1.5:  # scatters too much to be used
            continue
        zeta = [
            float(p["zeta"]) for p in pushes if p["mode"] == mode and float(p["v_mps"]) == speed
        ]
        hand, error = np.mean(zeta), np.std(zeta, ddof=1) / math.sqrt(len(zeta))
        mean = mean_of([p.damping_ratio for p in own])
        if abs(mean.value - hand) > 2.0 * math.hypot(error, mean.error):
            off.append((mode, speed, mean, hand, error))
    # two standard errors: one of 14 places may lie beyond by chance, none beyond three
    assert len(off) <= 1, off
    assert all(
        abs(mean.value - hand) <= 3.0 * math.hypot(error, mean.error)
        for _, _, mean, hand, error in off
    )


def test_intervals_hold_the_repeats(bicycle: Any) -> None:
    _, points, _, _ = bicycle
    inside = []
    for own in points.values():
        for k, point in enumerate(own):
            rest = np.array([p.damping_ratio.value for p in own[:k] + own[k + 1 :]])
            others = 1.96 * rest.std(ddof=1) / math.sqrt(len(rest))
            half = math.hypot(point.damping_ratio.half, others)
            inside.append(abs(point.damping_ratio.value - rest.mean()) <= half)
    assert 0.85 <= np.mean(inside) <= 0.98


def test_controllers_differ_at_5_m_s(bicycle: Any) -> None:
    _, points, _, _ = bicycle
    both = compare_groups(points["normal", 5.0], points["mm", 5.0], ("normal", "mm"))
    assert both is not None
    assert both.p_value < 1e-3


def test_course_predicts_5_m_s_and_has_no_zero(bicycle: Any) -> None:
    _, points, _, _ = bicycle
    for mode in ("normal", "mm"):
        slow = [p for (m, v), own in points.items() if m == mode and 2.0 <= v <= 4.0 for p in own]
        course = fit_course(slow)
        assert course is not None
        fast = points[mode, 5.0]
        mean = mean_of([p.damping_ratio for p in fast])
        predicted = course.value(float(np.mean([p.against for p in fast])))
        assert abs(predicted.value - mean.value) <= math.hypot(predicted.half, mean.half)
        every = [p for (m, v), own in points.items() if m == mode and v >= 2.0 for p in own]
        whole = fit_course(every)
        assert whole is not None
        excluded = whole.zero().excluded_up_to
        assert excluded is not None
        assert excluded > float(whole.x.max())


def test_model_is_too_fast_and_its_decay_agrees(bicycle: Any) -> None:
    folder, points, _, _ = bicycle
    model = load_model(f"{folder / 'model_eigenvalues_by_hypothesis.csv'}:nominal")
    normal = [p for (m, v), own in points.items() if m == "normal" and v >= 2.0 for p in own]
    against = compare_model(normal, model)
    assert against is not None
    frequency, growth = against.total("frequency_hz"), against.total("growth_1_s")
    assert frequency is not None
    assert growth is not None
    assert frequency.p_value < 1e-4
    assert frequency.difference.value > 0.0
    for one in against.of("frequency_hz"):
        assert one.second is not None
        if one.differs:
            assert 0.03 <= one.difference.value / one.second.value <= 0.20
    assert not growth.differs


# --- models and input ---------------------------------------------------------------------------


def _point(against: float, ratio: float, frequency: float = 1.0) -> Point:
    growth = -ratio * 2 * math.pi * frequency / math.sqrt(1 - ratio**2)
    return Point(
        "r", 1, 0.0, 1.0, against, IntervalValue(ratio, 0.01, 20.0),
        IntervalValue(frequency, 0.01, 20.0),
        IntervalValue(growth, 0.06, 20.0), np.ones(1), 2.0, 0.0, np.full(3, math.nan),
    )  # fmt: skip


def test_zero_of_a_straight_course() -> None:
    rng = np.random.default_rng(1)
    inside = 0
    for _ in range(200):
        points = [_point(v, 0.6 - 0.0175 * v + rng.normal(0, 0.01)) for v in (25, 27, 29, 31) * 3]
        course = fit_course(points, bend=Bend.NONE)
        assert course is not None
        zero = course.zero()
        assert zero.value is not None
        assert zero.low is not None
        assert zero.high is not None
        inside += zero.low <= 0.6 / 0.0175 <= zero.high
    assert 0.91 <= inside / 200 <= 0.99


def test_models_of_every_kind_agree(tmp_path: Path) -> None:
    speeds = np.array([2.0, 3.0, 4.0])
    matrices = np.array([[[0.0, 1.0], [-40.0 - v, -1.0]] for v in speeds])
    poles = [np.linalg.eigvals(a) for a in matrices]
    expected = poles[1][poles[1].imag > 0][0]
    np.savez(tmp_path / "m.npz", speed=speeds, A=matrices)
    scipy.io.savemat(tmp_path / "m.mat", {"v": speeds, "A": np.moveaxis(matrices, 0, 2)})
    lines = [f"{v},{p[0].real},{abs(p[0].imag)}" for v, p in zip(speeds, poles, strict=True)]
    (tmp_path / "m.csv").write_text("\n".join(["speed,growth,omega", *lines]))
    for name in ("m.npz", "m.mat", "m.csv"):
        assert load_model(str(tmp_path / name)).pole(3.0, 6j) == pytest.approx(expected)
    systems = [
        (float(v), control.ss(a, np.zeros((2, 1)), np.eye(2), np.zeros((2, 1))))
        for v, a in zip(speeds, matrices, strict=True)
    ]
    assert from_systems("control", systems).pole(3.0, 6j) == pytest.approx(expected)
    (tmp_path / "m.py").write_text("def system(v):\n    return [[0, 1], [-40 - v, -1.0]]\n")
    assert load_model(str(tmp_path / "m.py")).pole(3.0, 6j) == pytest.approx(expected)


def test_bad_models_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no such file"):
        load_model(str(tmp_path / "none.csv"))
    (tmp_path / "m.csv").write_text("kind,speed,growth,omega\na,1,-1,6\nb,1,-1,6\n")
    with pytest.raises(ModelError, match="there are a, b"):
        load_model(str(tmp_path / "m.csv"))
    np.savez(tmp_path / "m.npz", speed=[1.0, 2.0], A=np.zeros((3, 2, 2)))
    with pytest.raises(ModelError, match="expected"):
        load_model(str(tmp_path / "m.npz"))


@pytest.mark.parametrize("stuck_from_s", [0.0, 10.0])
def test_a_channel_that_sticks_tells_nothing(stuck_from_s: float) -> None:
    rng = np.random.default_rng(9)
    value = disturbed_swing(rng, 1.0, 0.1, 50.0, 0.02)
    alone = points_of(find(a_run(value[:, :1], 0.02), BAND, Estimator()))
    value[round(stuck_from_s / 0.02) :, 1] = 0.25
    both = points_of(find(a_run(value, 0.02), BAND, Estimator()))
    assert len({point.number for point in both}) == len({point.number for point in alone}) == 4
    for one, other in zip(both[-4:], alone[-4:], strict=True):
        assert other.damping_ratio.low <= one.damping_ratio.value <= other.damping_ratio.high


def test_a_csv_with_other_names_says_what_is_there(tmp_path: Path) -> None:
    time_ns = (np.arange(200) * 1e7).astype(np.int64)
    write_recording(tmp_path / "a.csv", {"temperature": Series(time_ns, np.arange(200.0), "C")})
    with pytest.raises(SignalError, match="Signals there: temperature"):
        load_runs([tmp_path / "a.csv"], Choice())
    with pytest.raises(SignalError, match="no signal 'roll'"):
        load_runs([tmp_path / "a.csv"], Choice(("roll",)))


def _four_swings(frequency_hz: float, rate_hz: float) -> tuple[Array, Array]:
    """Time and value of four swings of damping ratio 0.06 in 60 s, with noise."""
    time = np.arange(0.0, 60.0, 1.0 / rate_hz)
    value = np.random.default_rng(5).normal(0.0, 0.05, len(time))
    omega = 2 * math.pi * frequency_hz
    for hit in (8.0, 20.0, 32.0, 44.0):
        since = np.maximum(time - hit, 0.0)
        value += 6.0 * np.exp(-0.06 * omega * since) * np.sin(omega * since)
    return time, value


def _said(folder: Path, channel: str, time: Array, value: Array, *options: str) -> Study:
    file = folder / "run.csv"
    stamps = np.rint(time * 1e9).astype(np.int64)
    write_recording(file, {channel: Series(stamps, value, "")})
    choice = Choice(options)
    return study_of(load_runs([file], choice), StudyPlan(choice))


def test_signals_are_taken_by_what_their_names_say(tmp_path: Path) -> None:
    """No angle beside its own rate; an angle between two bodies swings along."""
    names = ("LeanAngle", "lean_rate", "yaw angle", "fork_angle", "hitch_angle")
    rng = np.random.default_rng(3)
    rows = np.column_stack([np.arange(400) * 0.02, rng.normal(size=(400, len(names)))])
    path = tmp_path / "ride.csv"
    np.savetxt(path, rows, delimiter=",", header=",".join(("time_s", *names)), comments="")
    for choice, channels, along in (
        (Choice(), ("lean_rate", "hitch_angle"), ("fork_angle", "hitch_angle")),
        (Choice(along=(NO_SIGNAL,)), ("lean_rate", "hitch_angle"), ()),
        (Choice(("LeanAngle",)), ("LeanAngle",), ("fork_angle", "hitch_angle")),
        (Choice(("hitch_angle",), along=("yaw angle",)), ("hitch_angle",), ("yaw angle",)),
        (Choice(("hitch_angle",)), ("hitch_angle",), ("fork_angle",)),
    ):
        (run,) = load_runs([path], choice)
        assert run.channels == channels
        assert run.along_names == along
        assert run.along.shape == (len(run.time_s), len(along))


@pytest.mark.parametrize("dead", ["stuck", "silent"])
def test_an_angle_that_dies_makes_no_other_motion(dead: str, tmp_path: Path) -> None:
    """Half of ten equal swings have no angle between the bodies: they count as the others do."""
    rng = np.random.default_rng(6)
    time = np.arange(9000) * 0.02
    value = 0.002 * rng.normal(size=(len(time), 2))
    mode = complex(-0.1, 1.0) * 2 * math.pi
    for k in range(10):
        since = time - 8.0 - 17.0 * k
        swing = np.where(since > 0, np.exp(mode * np.maximum(since, 0.0)), 0.0)
        value += np.stack([swing.imag, (0.5 * np.exp(2.0j) * swing).real], axis=1)
    text = [f"{t:.2f},{a:.5f},{b:.5f}" for t, (a, b) in zip(time, value, strict=True)]
    last = 6500  # in front of the seventh swing's end
    for row in range(last, len(text)):
        text[row] = f"{text[row].rpartition(',')[0]},{'0.125' if dead == 'stuck' else ''}"
    path = tmp_path / "drive.csv"
    path.write_text("time_s,yaw_rate,fork_angle\n" + "\n".join(text) + "\n")
    study = evaluate([path], StudyPlan(Choice()))
    assert study.found[0].run.along_names == ("fork_angle",)
    assert len({point.number for point in study.points}) == 10
    assert not study.others


def test_german_names_are_known(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    names = "Giergeschwindigkeit,Querbeschleunigung,Knickwinkel,Lenkradwinkel,Fahrgeschwindigkeit"
    rows = np.column_stack([np.arange(400) * 0.02, rng.normal(size=(400, 5))])
    path = tmp_path / "fahrt.csv"
    np.savetxt(path, rows, delimiter=",", header=f"time_s,{names}", comments="")
    (run,) = load_runs([path], Choice())
    assert run.channels == ("Giergeschwindigkeit", "Querbeschleunigung", "Knickwinkel")
    assert run.along_names == ("Knickwinkel",)
    assert run.input_names == ("Lenkradwinkel",)
    assert run.against_name == "Fahrgeschwindigkeit"


def test_a_channel_that_never_changes_is_named(tmp_path: Path) -> None:
    time, _ = _four_swings(0.8, 100.0)
    still = np.full(len(time), 1.25)
    with pytest.raises(RecordingError, match=r"are constant: yaw_rate \(1\.25 throughout\)"):
        _said(tmp_path, "yaw_rate", time, still)
    study = _said(tmp_path, "yaw_rate", time, still, "yaw_rate")
    assert "Never changes, perhaps not connected: yaw_rate in run (1.25)." in sentences(study)


def test_values_that_are_missing_are_counted(tmp_path: Path) -> None:
    """Gaps in two of four swings: no window reaches into them; single values are no gap."""
    time, value = _four_swings(0.8, 100.0)
    lost = value.copy()
    lost[::37] = math.nan
    study = _said(tmp_path, "yaw_rate", time, lost)
    assert len(study.points) == 4
    assert not any("missing" in text for text in sentences(study))
    for hit in (8.0, 32.0):
        lost[(time > hit + 0.8) & (time < hit + 1.3)] = math.nan
    study = _said(tmp_path, "yaw_rate", time, lost)
    run = study.found[0].run
    assert {20, 44} <= {round(point.start_s) for point in study.points}
    assert all(run.valid[run.rows(point.start_s, point.end_s)].all() for point in study.points)
    (text,) = (text for text in sentences(study) if "missing" in text)
    assert run.missing_s == pytest.approx(1.0, abs=0.05)
    assert f"run for {run.missing_s:.3g} of 60 s" in text


def test_what_is_sampled_too_slowly_or_too_short_says_so(tmp_path: Path) -> None:
    """At 10 Hz a swing of 2.4 Hz is right; one of 3.5 Hz (once a growing one of 2.9) is none."""
    time, value = _four_swings(2.4, 10.0)
    slow = _said(tmp_path, "roll_rate", time, value)
    assert slow.points
    assert all(p.damping_ratio.low <= 0.06 <= p.damping_ratio.high for p in slow.points)
    for frequency in (3.0, 3.5, 3.8):
        study = _said(tmp_path, "roll_rate", *_four_swings(frequency, 10.0))
        assert not study.points
        assert any(
            "run (59.9 s, 10 samples a second): 0.2 to 2.5 Hz" in t for t in sentences(study)
        )
    time, value = _four_swings(0.8, 100.0)
    short = _said(tmp_path, "yaw_rate", time[:30], value[:30])
    assert any("run (0.29 s, 100 samples a second): 3.4 to 10 Hz" in t for t in sentences(short))
    with pytest.raises(RecordingError, match=r"lasts 0\.019 s, less than one swing of 10 Hz"):
        _said(tmp_path, "yaw_rate", time[:20] / 10.0, value[800:820])


def test_groups_at_different_speeds_are_compared_where_they_are_nearest() -> None:
    """One test with the damper off at 187 kt, one with it on at 179 kt: no speed in common."""
    off = [_point(187.0, 0.10), _point(205.0, 0.12)]
    on = [_point(160.0, 0.30), _point(179.0, 0.20)]
    found = compare_groups(off, on, ("off", "on"))
    assert found is not None
    assert found.apart == (187.0, 179.0)
    ratio = found.total("damping_ratio")
    assert ratio is not None
    assert ratio.difference.value == pytest.approx(-0.10)
    assert ratio.differs
    assert compare_groups(off, [], ("off", "on")) is None
    same = compare_groups(off, [_point(187.0, 0.2)], ("off", "on"))
    assert same is not None
    assert same.apart is None


def test_what_is_not_certain_to_differ_does_not_agree_for_that() -> None:
    wide = IntervalValue(0.20, 0.10, 5.0)
    points = [replace(_point(179.0, 0.2), damping_ratio=wide)]
    found = compare_groups([_point(179.0, 0.10)], points, ("off", "on"))
    assert found is not None
    study = SimpleNamespace(against_name="airspeed", against_unit="kt")
    said = comparison_words(cast("Study", study), found, model=False)
    assert any("damping ratio of off and of on cannot be shown to differ or to" in s for s in said)
    assert any("frequency of off and of on agree" in s for s in said)
