"""Identification on the practice recordings: the truth lies in the stated intervals."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from conftest import recordings

from swaywatch.core import AXLES, Estimates, analyze_drive
from swaywatch.drive import load_drive
from swaywatch.vehicle import load_vehicle

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


@pytest.mark.parametrize("run", ["run1", "run2"])
@pytest.mark.parametrize("case", ["p01", "p03", "p05", "p08"])
def test_critical_speed(case: str, run: str) -> None:
    estimates, folder = estimates_of(case, run)
    content = json.loads((folder / "truth.json").read_text())
    truth = content["plant_vcrit_kmh"]
    swings = any(effect["id"] == "axle_load_harmonic" for effect in content["effects"])
    good = clean(estimates)
    # From 10 s after the first estimate on: the user's values have been replaced by then.
    settled = good & (estimates.time_s > estimates.time_s[good][0] + 10)
    assert settled.sum() > 30
    found = estimates["v_crit_m_s"][settled] * 3.6
    error = estimates["v_crit_se_m_s"][settled] * 3.6
    assert abs(float(np.median(found)) - truth) < 2.0
    # An axle load that swings at 2f makes the live critical speed wander about that of the plant.
    if swings:
        assert abs(float(np.mean(found)) - truth) < 1.96 * float(np.mean(error)) + 0.5
    else:
        assert coverage(found, error, truth) > 0.85


@pytest.mark.parametrize("case", ["p01", "p08"])
def test_stiffnesses_are_within_their_intervals(case: str) -> None:
    estimates, _ = estimates_of(case, "run1")
    good = clean(estimates) & ~estimates.flagged("forced")
    for axle, truth in zip(AXLES, STIFFNESS, strict=True):
        found = estimates[f"{axle}.cornering_stiffness_n_per_rad"][good]
        error = estimates[f"{axle}.cornering_stiffness_se_n_per_rad"][good]
        assert float(np.median(found)) == pytest.approx(truth, rel=0.01)
        assert coverage(found, error, truth) > 0.85
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
