"""Axle load that oscillates at twice the yaw frequency, in time windows."""

from __future__ import annotations

import math

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter, Windowed
from swaywatch.plant.layout import AXLES, W_GENERATOR, W_HARMONIC, W_UNIT


def delay_for_phase(phase_deg: float, frequency_hz: float, mean_time_s: float) -> float:
    """Delay in s that puts the load at a phase to F_y squared.

    The high-pass q - mean(q) leads by atan(1 / (2 omega tau)) at the line 2 f; the delay takes that
    off too and lies between 0 and half a yaw period.
    """
    omega_2 = 4.0 * math.pi * frequency_hz
    lead = math.atan(1.0 / (omega_2 * mean_time_s))
    return ((lead - math.radians(phase_deg)) % (2.0 * math.pi)) / omega_2


def _row(effect: PhysicsEffect, axle: int, window: Windowed, mean_time: float) -> tuple[float, ...]:
    values = window.values
    form = effect.options["form"]
    span = (float(axle), window.start_s, window.stop_s)
    if form == "generator":
        return (W_GENERATOR, *span, values["gain_n_s2_per_rad2"], values["delay_s"], 0.0)
    if form == "normalised":
        return (W_UNIT, *span, values["amplitude_n"], values["delay_s"], 0.0)
    delay = delay_for_phase(values["phase_deg"], values["frequency_hz"], mean_time)
    return (W_HARMONIC, *span, values["amplitude_n"], delay, 0.0)


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    axle = AXLES.index(effect.options["axle"])
    mean_time = effect.values["mean_time_s"]
    arrays.set("harmonic_mean_time", mean_time)
    arrays.set("harmonic_level_time", effect.values["level_time_s"])
    for window in effect.windows:
        arrays.windows.append(_row(effect, axle, window, mean_time))


MODULE = Module(
    id="axle_load_harmonic",
    title="Axle load oscillating at twice the yaw frequency",
    equation=(
        "generator: dF_z = gain HP(psi_1'^2)(t - delay), on the left wheel while psi_1' < 0, else "
        "on the right, HP(q) = q - mean(q); normalised: amplitude HP(q)/level(q) (t - delay), "
        "q = psi_1'^2; harmonic: the same with q = (F_y/F_z)^2 of the axle and the delay that "
        "gives phase_deg at 2 f"
    ),
    source="Zhang 2015, Eq. 6.1-6.2, Fig. 6-3, Table 6-3; phase as in Fig. 4-5",
    enters="vertical load of the axle's wheels, hence their side force",
    parameters=(
        PhysicsParameter("amplitude_n", "N", 0.0, 4000.0, 500.0, windowed=True),
        PhysicsParameter("phase_deg", "deg", -360.0, 360.0, 0.0, windowed=True, meaning="to F_y^2"),
        PhysicsParameter(
            "frequency_hz", "Hz", 0.2, 2.0, 0.67, windowed=True, meaning="yaw frequency f"
        ),
        PhysicsParameter("gain_n_s2_per_rad2", "N/(rad/s)^2", -1e6, 1e6, 2e4, windowed=True),
        PhysicsParameter("delay_s", "s", 0.0, 2.0, 0.0, windowed=True),
        PhysicsParameter(
            "mean_time_s", "s", 0.1, 5.0, 1.0, meaning="time constant of the high-pass"
        ),
        PhysicsParameter("level_time_s", "s", 0.1, 10.0, 3.0, meaning="time constant of the level"),
    ),
    options={
        "axle": ("car_rear", "car_front", "trailer_front", "trailer_rear"),
        "form": ("harmonic", "generator", "normalised"),
    },
    apply=_apply,
)
