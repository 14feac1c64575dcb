"""Identification on the practice recordings: the truth lies in the stated intervals."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from conftest import recordings

from swaywatch.analysis import conclude
from swaywatch.drive import load_drive
from swaywatch.ecu.core import AXLES, Estimates, analyze_drive
from swaywatch.recording import read_recording, write_recording
from swaywatch.vehicle_file import load_vehicle

STIFFNESS = (109.3e3, 185.2e3, 131.2e3, 124.4e3)
"""Of the plant behind the practice set: that of its vehicle.toml, which is not wrong there."""


def estimates_of(case: str, run: str) -> tuple[Estimates, Path]:
    """Estimates of one run of a practice case."""
    folder = recordings("practice", case)
    drive = load_drive([next(folder.glob(f"{run}.*"))], folder / "signals.toml")
    return analyze_drive(drive, load_vehicle(folder / "vehicle.toml")), folder


def clean(estimates: Estimates) -> np.ndarray:
    """Estimates of one undisturbed damped line with all axles identified."""
    good = estimates.has("line") & estimates.has("critical_speed")
    for axle in AXLES:
        good &= estimates.has(axle)
    for flag in ("misfit", "gap", "nonlinear"):
        good &= ~estimates.flagged(flag)
    return good


def coverage(estimate: np.ndarray, error: np.ndarray, truth: float) -> float:
    """Share of the estimates whose 95 % interval holds the truth."""
    return float(np.mean(np.abs(estimate - truth) < 1.96 * error))


def truth_of(case: str) -> dict:
    """The known truth of a practice case."""
    return dict(json.loads((recordings("practice", case) / "truth.json").read_text()))


def effect_on(case: str, axle: int, effect_id: str) -> dict | None:
    """The concealed effect of that kind on an axle."""
    for effect in truth_of(case)["effects"]:
        if effect["id"] == effect_id and effect["axle"] == AXLES[axle]:
            return dict(effect)
    return None


def stiffness_at(case: str, axle: int, estimates: Estimates) -> np.ndarray:
    """True size of an axle's stiffness at each estimate's frequency and speed.

    With a relaxation length: |C/(1 + sigma s/v)|.
    """
    relaxation = effect_on(case, axle, "tyre_relaxation")
    sigma = relaxation["length_m"] if relaxation else 0.0
    s = estimates["growth_per_s"] + 2j * np.pi * estimates["frequency_hz"]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(STIFFNESS[axle] / np.abs(1 + sigma * s / estimates["speed_m_s"]))


def undisturbed(case: str, run: str, estimates: Estimates, axle: int) -> np.ndarray:
    """Clean estimates in which the axle's truth is one number.

    Where an axle load swings for a span of time its stiffness is another there
    (test_the_load_harmonic_and_its_phase_are_found).
    """
    good = clean(estimates)
    half = estimates["window_s"] / 2
    if effect_on(case, axle, "axle_load_harmonic"):
        for start, stop in truth_of(case)[run]["windows"]:
            good &= (estimates.time_s + half < start) | (estimates.time_s - half > stop)
    return good


RUNS = [(case, run) for case in ("p01", "p03", "p05", "p08") for run in ("run1", "run2")]


@pytest.mark.parametrize(("case", "run"), RUNS)
def test_every_estimate_states_its_interval_honestly(case: str, run: str) -> None:
    """Of all the 95 % intervals of the stiffnesses at least 95 % hold the truth."""
    estimates, _ = estimates_of(case, run)
    inside = []
    for index, axle in enumerate(AXLES):
        good = undisturbed(case, run, estimates, index)
        assert good.sum() > 20
        truth = stiffness_at(case, index, estimates)[good]
        found = estimates[f"{axle}.cornering_stiffness_n_per_rad"][good]
        error = estimates[f"{axle}.cornering_stiffness_se_n_per_rad"][good]
        held = np.abs(found - truth) < 1.96 * error
        inside += [float(np.mean(held))]
        assert float(np.median(found / truth)) == pytest.approx(1, rel=0.01)
    # A run has about ten windows that do not overlap: one axle may miss a few per cent more.
    assert np.mean(inside) >= 0.95
    assert min(inside) > 0.9


def settled_critical_speed(case: str, run: str) -> tuple[np.ndarray, np.ndarray]:
    """Critical speed and its error, km/h, from 10 s after the first estimate on.

    The user's values have been replaced by then.
    """
    estimates, _ = estimates_of(case, run)
    good = clean(estimates)
    settled = good & (estimates.time_s > estimates.time_s[good][0] + 10)
    assert settled.sum() > 30
    return (
        estimates["v_crit_m_s"][settled] * 3.6,
        estimates["v_crit_se_m_s"][settled] * 3.6,
    )


@pytest.mark.parametrize(("case", "run"), RUNS)
def test_critical_speed_ends_in_its_interval(case: str, run: str) -> None:
    truth = truth_of(case)["plant_vcrit_kmh"]
    found, error = settled_critical_speed(case, run)
    assert abs(float(np.median(found)) - truth) < 1.0
    assert abs(found[-1] - truth) < 1.96 * error[-1]
    assert error[-1] < 1.0


def test_critical_speed_states_its_interval_honestly() -> None:
    """Where it is one number: a swinging axle load moves the live critical speed itself."""
    inside = []
    for case, run in RUNS:
        if not any(effect_on(case, axle, "axle_load_harmonic") for axle in range(4)):
            found, error = settled_critical_speed(case, run)
            inside.append(coverage(found, error, truth_of(case)["plant_vcrit_kmh"]))
    assert np.mean(inside) >= 0.95
    assert min(inside) >= 0.95


FORMATS = ("blf", "asc", "log", "trc", "mf4", "csv", "parquet")


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("case", ["p01", "p03", "p05", "p08"])
def test_a_run_lies_in_its_intervals_in_every_format(
    case: str, suffix: str, tmp_path: Path
) -> None:
    """What `analyze` says of run 1: each axle's stiffness and the critical speed."""
    folder = recordings("practice", case)
    frames = read_recording(next(folder.glob("run1.*"))).frames
    assert frames is not None
    path = tmp_path / f"run1.{suffix}"
    write_recording(path, frames)
    vehicle = load_vehicle(folder / "vehicle.toml")
    drive = load_drive([path], folder / "signals.toml")
    estimates = analyze_drive(drive, vehicle)
    values = conclude(drive, vehicle, estimates, []).values
    critical = values["v_crit_m_s"]
    truth = truth_of(case)["plant_vcrit_kmh"] / 3.6
    assert abs(critical.value - truth) < 1.96 * critical.error
    assert critical.error * 3.6 < 1.0
    for index, axle in enumerate(AXLES):
        found = values[f"{axle}.cornering_stiffness_n_per_rad"]
        at = stiffness_at(case, index, estimates)[clean(estimates)]
        assert abs(found.value - float(np.mean(at))) < 1.96 * found.error
        assert found.error < 0.01 * found.value


@pytest.mark.parametrize("case", ["p01", "p08"])
def test_arguments_are_none_without_lag(case: str) -> None:
    estimates, _ = estimates_of(case, "run1")
    good = clean(estimates) & ~estimates.flagged("forced")
    for axle in AXLES:
        argument = estimates[f"{axle}.argument_rad"][good]
        assert abs(math.degrees(float(np.median(argument)))) < 0.3


def test_relaxation_is_the_argument_of_its_axle_only() -> None:
    estimates, _ = estimates_of("p05", "run1")
    good = clean(estimates) & ~estimates.flagged("forced")
    omega = 2 * np.pi * estimates["frequency_hz"][good]
    lag = np.arctan(omega * 0.7 / estimates["speed_m_s"][good])
    found = -estimates["car_rear.argument_rad"][good]
    assert float(np.median(found - lag)) == pytest.approx(0, abs=math.radians(0.4))
    for axle in ("car_front", "trailer_front", "trailer_rear"):
        argument = math.degrees(float(np.median(estimates[f"{axle}.argument_rad"][good])))
        assert abs(argument) < 0.4


def test_a_wrong_yaw_inertia_is_found() -> None:
    estimates, _ = estimates_of("p08", "run1")
    good = clean(estimates) & estimates.has("trailer_inertia") & ~estimates.flagged("forced")
    found = float(np.median(estimates["trailer_yaw_inertia_kgm2"][good]))
    assert found == pytest.approx(10350 * 1.12, rel=0.01)
    car = float(np.median(estimates["car_yaw_inertia_kgm2"][good]))
    assert car == pytest.approx(2690, rel=0.02)


def test_the_load_harmonic_and_its_phase_are_found() -> None:
    estimates, folder = estimates_of("p03", "run1")
    truth = json.loads((folder / "truth.json").read_text())["run1"]
    for window, harmonic in zip(truth["windows"], truth["harmonic"], strict=True):
        # Estimates whose own window lies inside that of the harmonic.
        half = estimates["window_s"] / 2
        inside = (estimates["mid_time_s"] - half > window[0] - 0.3) & (
            estimates["mid_time_s"] + half < window[1] + 0.3
        )
        inside &= estimates.has("car_rear_load")
        assert inside.any()
        amplitude = estimates["car_rear.load_harmonic_n"][inside]
        phase = estimates["car_rear.load_harmonic_phase_rad"][inside]
        vector = np.mean(amplitude * np.exp(1j * phase))
        assert abs(vector) == pytest.approx(harmonic["amplitude_n"], rel=0.15)
        difference = np.angle(vector * np.exp(-1j * math.radians(harmonic["phase_deg"])))
        assert abs(math.degrees(float(difference))) < 20
