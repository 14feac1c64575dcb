"""The whole core on noise-free simulated oscillations: what was simulated comes back.

The goals of the project: stiffnesses within 0.3 % and 0.3 deg, yaw inertias within 1 %, the
effective load within 1 % for an axle load at twice the yaw frequency with any phase.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from conftest import DATA

from swaywatch.drive import Channel, Drive
from swaywatch.ecu.core import AXLES, Estimates, analyze_drive
from swaywatch.models.double_track import DoubleTrack, Trace
from swaywatch.models.physics import PhysicsEffect
from swaywatch.roles import CHANNELS
from swaywatch.vehicle_file import load_vehicle

FloatArray = npt.NDArray[np.float64]

VEHICLE = load_vehicle(DATA / "practice" / "p01" / "vehicle.toml")
STIFFNESS = dict(zip(AXLES, (109.3e3, 185.2e3, 131.2e3, 124.4e3), strict=True))
LOAD = dict(zip(AXLES, (9674.0, 10204.0, 9226.0, 8517.0), strict=True))
WHEELS = {
    "car_front": ("wheel_slip_fl", "wheel_slip_fr"),
    "car_rear": ("wheel_slip_rl", "wheel_slip_rr"),
    "trailer_front": ("trailer_wheel_slip_fl", "trailer_wheel_slip_fr"),
    "trailer_rear": ("trailer_wheel_slip_rl", "trailer_wheel_slip_rr"),
}
TIME_S = np.arange(0.0, 22.0, 0.01)


def simulate(kmh: float, *physics: PhysicsEffect) -> tuple[Trace, Estimates]:
    """A half-sine at the wheel (10 deg), then the wheel is held; every sensor, no noise."""
    inside = (TIME_S >= 2.0) & (TIME_S < 2.74)
    wheel = np.where(inside, math.radians(10) * np.sin(np.pi * (TIME_S - 2.0) / 0.74), 0.0)
    model = DoubleTrack(VEHICLE, physics)
    trace = model.run(TIME_S, wheel, kmh / 3.6)
    assert trace.whole
    place = {"car_lateral_acceleration": model.car_position_m}
    channels = {
        name: Channel(name, trace.time_s, np.asarray(trace[name]), name, "", place.get(name, 0.0))
        for name in trace
        if name in CHANNELS
    }
    return trace, analyze_drive(Drive("simulated", (), channels, 0), VEHICLE)


def undisturbed(estimates: Estimates) -> npt.NDArray[np.bool_]:
    """Windows of the free oscillation, while it is above 0.3 deg/s."""
    good = estimates.has("line") & (estimates.time_s > 5.0)
    good &= estimates["amplitude_rad_s"] > math.radians(0.3)
    for flag in ("forced", "misfit", "gap"):
        good &= ~estimates.flagged(flag)
    return good


@pytest.mark.parametrize("kmh", [100.0, 115.0, 121.0])
def test_stiffnesses_and_inertias_come_back(kmh: float) -> None:
    _, estimates = simulate(kmh)
    good = undisturbed(estimates)
    assert good.sum() > 10
    for axle, truth in STIFFNESS.items():
        assert np.all(estimates.has(axle)[good])
        found = estimates[f"{axle}.cornering_stiffness_n_per_rad"][good]
        assert found == pytest.approx(truth, rel=0.003)
        assert estimates[f"{axle}.argument_rad"][good] == pytest.approx(0, abs=math.radians(0.3))
    assert estimates["car_yaw_inertia_kgm2"][good] == pytest.approx(2690, rel=0.01)
    assert estimates["trailer_yaw_inertia_kgm2"][good] == pytest.approx(10350, rel=0.01)


def fit(
    signal: FloatArray, estimates: Estimates, index: int, harmonics: int = 3
) -> tuple[complex, complex]:
    """Amplitudes of a simulated signal at f and 2 f over the window of one estimate.

    Least squares with the estimate's frequency and growth; mean and slope are taken out.
    """
    middle, length = estimates["mid_time_s"][index], estimates["window_s"][index]
    inside = np.abs(TIME_S - middle) < length / 2
    time = TIME_S[inside] - middle
    s = estimates["growth_per_s"][index] + 2j * np.pi * estimates["frequency_hz"][index]
    columns = [np.ones(len(time)), time]
    for k in range(1, harmonics + 1):
        e = np.exp(k * s.real * time) * np.exp(1j * k * s.imag * time)
        columns += [e.real, -e.imag]
    found = np.linalg.lstsq(np.stack(columns, axis=1), signal[inside], rcond=None)[0]
    return complex(found[2], found[3]), complex(found[4], found[5])


PHASES = [("car_rear", float(phase)) for phase in range(-180, 180, 30)]
PHASES += [(axle, sign * 90.0) for axle in AXLES if axle != "car_rear" for sign in (1, -1)]


@pytest.mark.parametrize(("axle", "phase_deg"), PHASES)
def test_effective_load_all_round_the_circle(axle: str, phase_deg: float) -> None:
    effect = PhysicsEffect(
        "axle_load_harmonic", axle=axle, amplitude_n=900.0, phase_deg=phase_deg, frequency_hz=0.67
    )
    trace, estimates = simulate(112.0, effect)
    good = undisturbed(estimates) & estimates.has(f"{axle}_load") & (estimates.time_s > 7.0)
    assert good.sum() >= 5
    slip = 0.5 * (trace[WHEELS[axle][0]] + trace[WHEELS[axle][1]])
    load, force = trace.axle_load(axle), trace.axle_force(axle)
    zeta = STIFFNESS[axle] / LOAD[axle]
    for index in np.flatnonzero(good):
        slip_1, _ = fit(slip, estimates, index)
        product_1, _ = fit(slip * load, estimates, index)
        force_1, _ = fit(force, estimates, index)
        _, load_2 = fit(load, estimates, index)
        # The truth is what makes the force: force = zeta slip load, at f.
        truth = abs(product_1 / slip_1)
        assert abs(force_1 / slip_1) / zeta == pytest.approx(truth, rel=0.001)
        assert estimates[f"{axle}.effective_load_n"][index] == pytest.approx(truth, rel=0.01)
        phase = np.angle(load_2 * np.exp(-2j * np.angle(force_1)))
        found = estimates[f"{axle}.load_harmonic_phase_rad"][index]
        assert abs(np.angle(np.exp(1j * (found - phase)))) < math.radians(1)
    found = estimates[f"{axle}.load_harmonic_phase_rad"][good]
    if abs(phase_deg) == 90.0:
        # The dissertation's method could not tell these two apart (7.2): here the sign of the
        # phase and of the stiffness' argument say which.
        assert np.all(found * phase_deg > 0)
        assert np.all(estimates[f"{axle}.argument_rad"][good] * phase_deg > 0)
