"""Chapter 6.3, Fig. 6-7: what a degressive tyre makes of load and slip, in sway and in a slalom."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from plotly.subplots import make_subplots

from swaywatch.ecu.core import Estimates, analyze_drive
from swaywatch.models.double_track import Trace
from swaywatch.plant.layout import Array
from swaywatch.reproduce.page import BLUE, GREEN, ORANGE, RED, Chapter, Check, Plot, styled
from swaywatch.reproduce.study import VEHICLE, in_parallel
from swaywatch.simulate.run import simulate_plant, simulate_scenario
from swaywatch.simulate.scenario import Scenario, read_scenario

DEGRESSION, PEAK_FRICTION = 0.3, 0.9
TYRE: tuple[Mapping[str, Any], ...] = (
    {"id": "tyre_load_sensitivity", "degression": DEGRESSION},
    {"id": "tyre_saturation", "peak_friction": PEAK_FRICTION},
)
"""Stands for the text's Magic Formula: less than proportional to load, and to slip."""
AMPLITUDES_N = (0.0, 250.0, 500.0, 750.0)
ANGLES_DEG = (6.0, 12.0, 18.0, 24.0)
SLALOM_KMH, SLALOM_HZ, SLALOM_DEG = 90.0, 0.75, 12.0
FIRST_S, LAST_S = 9.0, 15.0
SWAYING_RAD = 0.05
"""Slip of a swing that has grown beyond use."""
CASES = ((0.0, BLUE), (-90.0, ORANGE), (-180.0, RED))


@dataclass(frozen=True)
class AxlePoint:
    """The car's rear axle in one drive: load and slip that varied, stiffness that followed."""

    effective_load_n: float
    slip_deg: float
    normalised: float


def load(amplitude_n: float, phase_deg: float, frequency_hz: float) -> tuple[dict[str, Any], ...]:
    """The harmonic load as physics; none below 1 N."""
    if amplitude_n < 1.0:
        return ()
    return (
        {
            "id": "axle_load_harmonic", "axle": "car_rear", "form": "harmonic",
            "amplitude_n": amplitude_n, "phase_deg": phase_deg, "frequency_hz": frequency_hz,
            "level_time_s": 1.5,
        },
    )  # fmt: skip


def scenario_of(content: Mapping[str, Any]) -> Scenario:
    """A drive with perfect sensors."""
    whole = {
        "vehicle": "-", "duration_s": 18.0, "sensors": {"preset": "perfect"},
        "timing": {"jitter_s": 0.0, "latency_s": 0.0}, **content,
    }  # fmt: skip
    return read_scenario(whole, "slalom", Path(), "slalom", vehicle=VEHICLE)


def drive(content: Mapping[str, Any]) -> AxlePoint:
    """One drive through ``swaywatch simulate``'s door and the C core.

    Without a speed the critical one is looked for: there the swing neither grows nor decays.
    """
    if "speed_kmh" not in content:
        content = {**content, "speed_kmh": critical_kmh(content)}
    recorded, trace = simulate_scenario(scenario_of(content))
    return point_of(analyze_drive(recorded, VEHICLE), trace)


def critical_kmh(content: Mapping[str, Any]) -> float:
    """Speed at which the slip of the rear axle is as large late in the drive as early."""
    low, high = 80.0, 140.0
    for _ in range(12):
        middle = 0.5 * (low + high)
        trace = simulate_plant(scenario_of({**content, "speed_kmh": middle}))
        size = [
            float(np.std(trace["wheel_slip_rl"][(trace.time_s >= a) & (trace.time_s < a + 3.0)]))
            for a in (FIRST_S, LAST_S - 3.0)
        ]
        decays = size[1] < size[0] < SWAYING_RAD  # not so where the motion left all bounds
        low, high = (middle, high) if decays else (low, middle)
    return 0.5 * (low + high)


def point_of(estimates: Estimates, trace: Trace) -> AxlePoint:
    """Means over the settled part of a drive."""
    time = estimates.time_s
    rows = (time >= FIRST_S) & (time <= LAST_S)
    rows &= estimates.has("car_rear") & estimates.has("car_rear_load")
    within = (trace.time_s >= FIRST_S) & (trace.time_s <= LAST_S)
    slip: Array = 0.5 * (trace["wheel_slip_rl"] + trace["wheel_slip_rr"])[within]
    return AxlePoint(
        float(np.mean(estimates["car_rear.effective_load_n"][rows])),
        float(np.degrees(np.sqrt(2.0) * np.std(slip))),
        float(np.mean(estimates["car_rear.normalised_stiffness_per_rad"][rows])),
    )


def sway(amplitude_n: float, phase_deg: float) -> dict[str, Any]:
    """Free oscillation at its critical speed."""
    return {
        "manoeuvre": [{"kind": "impulse", "start_s": 2.0, "angle_deg": 6.0}],
        "physics": [*TYRE, *load(amplitude_n, phase_deg, 0.672)],
    }


def slalom(amplitude_n: float, phase_deg: float, angle_deg: float) -> dict[str, Any]:
    """A slalom at 90 km/h, at nearly the frequency of the sway."""
    return {
        "speed_kmh": SLALOM_KMH,
        "manoeuvre": [
            {
                "kind": "slalom", "start_s": 1.0, "duration_s": 17.0, "angle_deg": angle_deg,
                "frequency_hz": SLALOM_HZ,
            }
        ],
        "physics": [*TYRE, *load(amplitude_n, phase_deg, SLALOM_HZ)],
    }  # fmt: skip


def add_to(chapter: Chapter, workers: int | None = None) -> None:
    """Fig. 6-7 and its checks."""
    free = [sway(a, p) for p, _ in CASES for a in AMPLITUDES_N]
    loaded = [slalom(a, p, SLALOM_DEG) for p in (0.0, -180.0) for a in AMPLITUDES_N]
    steered = [slalom(0.0, 0.0, angle) for angle in ANGLES_DEG]
    points = in_parallel(drive, [*free, *loaded, *steered], workers)
    parts = points[: len(free)], points[len(free) : -len(steered)], points[-len(steered) :]
    chapter.parts.append(_figure(*parts))
    _checks(chapter, *parts)


def _figure(
    free: Sequence[AxlePoint], loaded: Sequence[AxlePoint], steered: Sequence[AxlePoint]
) -> Plot:
    plot = make_subplots(
        rows=2, cols=2, shared_yaxes=True, vertical_spacing=0.16, horizontal_spacing=0.05,
    )  # fmt: skip
    size = len(AMPLITUDES_N)
    for number, (phase, colour) in enumerate(CASES):
        part = free[number * size : (number + 1) * size]
        _line(plot, part, "load", f"{phase:.0f} deg", colour, 1, 1, legend=True)
        _line(plot, part, "slip", f"{phase:.0f} deg", colour, 1, 2)
    for number, (phase, colour) in enumerate((CASES[0], CASES[2])):
        part = loaded[number * size : (number + 1) * size]
        _line(plot, part, "load", f"{phase:.0f} deg", colour, 2, 1)
    _line(plot, steered, "slip", "steering amplitude", GREEN, 2, 2, legend=True)
    for row in (1, 2):
        plot.update_yaxes(title="normalised stiffness [1/rad]", row=row, col=1)
    for place, (what, row, col) in enumerate(
        (("sway, F_zr,eff [kN]", 1, 1), ("sway, slip amplitude of the axle [deg]", 1, 2),
         ("slalom, load varied, F_zr,eff [kN]", 2, 1),
         ("slalom, steering varied, slip [deg]", 2, 2))
    ):  # fmt: skip
        plot.update_xaxes(title=f"({'abcd'[place]}) {what}", row=row, col=col)
    return Plot(
        "Fig. 6-7: load and slip on a degressive tyre, in sway and in a slalom", styled(plot, 560),
        "Load alone and slip alone both lower the normalised stiffness. In the sway they change "
        "together and cannot be distinguished; in the slalom each is varied by itself.",
    )  # fmt: skip


def _line(
    plot: Any, points: Sequence[AxlePoint], quantity: str, name: str, colour: str, row: int,
    col: int,
    legend: bool = False,
) -> None:  # fmt: skip
    x = [p.effective_load_n / 1e3 if quantity == "load" else p.slip_deg for p in points]
    plot.add_scatter(
        x=x, y=[p.normalised for p in points], name=name, showlegend=legend,
        mode="lines+markers", line={"color": colour, "width": 1.3}, row=row, col=col,
    )  # fmt: skip


def slope(points: Sequence[AxlePoint], quantity: str) -> float:
    """Change of the normalised stiffness in percent, for 1 % of load or 1 deg of slip."""
    normalised = np.array([p.normalised for p in points])
    x = np.array([p.effective_load_n if quantity == "load" else p.slip_deg for p in points])
    fall = float(np.polyfit(x - x.mean(), normalised / normalised.mean(), 1)[0])
    return fall * float(x.mean()) if quantity == "load" else 100.0 * fall


def _slip_words(
    free: Sequence[AxlePoint], loaded: Sequence[AxlePoint], steered: Sequence[AxlePoint]
) -> str:
    """The ratio with the part of the slip, which changes in the sway too, taken out."""
    load_n = np.array([p.effective_load_n for p in free])
    slip = np.array([p.slip_deg for p in free])
    share = np.array([p.normalised for p in free])
    of_slip = slope(steered, "slip") / 100.0 * share.mean() * (slip - slip.mean())
    rest = float(np.polyfit(load_n - load_n.mean(), (share - of_slip) / share.mean(), 1)[0])
    ratio = rest * float(load_n.mean()) / slope(loaded[len(AMPLITUDES_N) :], "load")
    return (
        f"slip changes by {np.ptp(slip):.2f} deg along with the load; with its part, as (d) has "
        f"it, taken out the ratio is {ratio:.2f}"
    )


def _checks(
    chapter: Chapter,
    free: Sequence[AxlePoint],
    loaded: Sequence[AxlePoint],
    steered: Sequence[AxlePoint],
) -> None:
    size = len(AMPLITUDES_N)
    ratio = slope(free[2 * size :], "load") / slope(loaded[size:], "load")
    chapter.checks += [
        Check("Fig. 6-7 (c): normalised stiffness for +1 % of load, slalom: falls", 0.0,
              slope(loaded, "load"), 0.0, "%", "below"),
        Check("Fig. 6-7 (a) over (c): slope at -180 deg, sway over slalom (text: nearly 1)", 1.0,
              ratio, 0.1, "1", cause=_slip_words(free[2 * size :], loaded, steered)),
        Check("Fig. 6-7 (d): normalised stiffness for 1 deg more slip, slalom: falls", 0.0,
              slope(steered, "slip"), 0.0, "%", "below"),
    ]  # fmt: skip
