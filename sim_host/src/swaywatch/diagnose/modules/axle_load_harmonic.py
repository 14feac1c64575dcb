"""Axle load oscillating at twice the yaw frequency, in windows (4.4.2, 6.2).

The phase is that of the load against the square of the axle's lateral force, lead positive. For
the trailer, whose forces may not be measured, the trailer's lateral acceleration stands for it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.signal import hilbert

from swaywatch.diagnose.effect import Array, Effect, Parameter, Values, Window
from swaywatch.diagnose.plant import PlantInput
from swaywatch.diagnose.runs import Run, band_pass


def force_phase(run: Run, axle: str) -> Array:
    """Instantaneous phase of the axle's lateral force, rad, shape (n,)."""
    key = f"_phase_{axle}"
    if key not in run.simulated:
        c = run.channels
        pair = {"car_front": ("fl", "fr"), "car_rear": ("rl", "rr")}.get(axle, ())
        names = [f"wheel_lateral_force_{wheel}" for wheel in pair]
        if names and all(name in c for name in names):
            signal = c[names[0]] + c[names[1]]
        elif axle.startswith("trailer") and "trailer_lateral_acceleration" in c:
            signal = c["trailer_lateral_acceleration"]
        else:
            signal = c["car_lateral_acceleration"]
        run.simulated[key] = np.unwrap(np.angle(hilbert(band_pass(signal, 0.25, 1.5))))
    return run.simulated[key]


def frequency(run: Run, axle: str, window: Window) -> float:
    """Mean frequency of the axle's force in a window, Hz."""
    inside = (run.time >= window.start) & (run.time <= window.stop)
    if np.count_nonzero(inside) < 10:
        return float("nan")
    slope = np.polyfit(run.time[inside], force_phase(run, axle)[inside], 1)[0]
    return float(slope / (2.0 * np.pi))


def _act(axle: str) -> Callable[[PlantInput, Run, Values, Sequence[Window]], None]:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del values
        if not windows:
            return
        phase = 2.0 * force_phase(run, axle)
        for window in windows:
            v = window.values
            load = v["in_phase_n"] * np.cos(phase) - v["quadrature_n"] * np.sin(phase)
            plant.add_series(f"load_{axle}", load * window.mask(run.time))

    return act


def _report(v: Values) -> dict[str, float]:
    return {
        "amplitude_n": float(np.hypot(v["in_phase_n"], v["quadrature_n"])),
        "phase_deg": float(np.degrees(np.arctan2(v["quadrature_n"], v["in_phase_n"]))),
    }


EFFECTS = [
    Effect(
        id="axle_load_harmonic",
        component=axle,
        kind="physics",
        equation="F_z = F_z0 + amplitude cos(2 phi + phase), phi: phase of the lateral force",
        source="section 4.4.2 and 6.2",
        parameters=(
            Parameter("in_phase_n", "N", 0.0, -9e3, 9e3, (300.0,), 20.0, 60.0),
            Parameter("quadrature_n", "N", 0.0, -9e3, 9e3, (0.0,), 20.0, 60.0),
        ),
        act=_act(axle),
        windowed=True,
        lines=("2f",),
        decided_by="wheel loads of the axle",
        report=_report,
        extra={"frequency": lambda run, window, axle=axle: frequency(run, axle, window)},
    )
    for axle in ("car_front", "car_rear", "trailer_front", "trailer_rear")
]
