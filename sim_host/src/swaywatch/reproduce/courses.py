"""Courses over time that the text shows: Fig. 1-3, 1-4, 4-4, 5-10, 5-12 to 5-14, 6-6."""

from __future__ import annotations

import cmath
import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from swaywatch.drive import Channel, Drive
from swaywatch.ecu.core import Estimates, analyze_drive
from swaywatch.models.double_track import Trace
from swaywatch.models.single_track import SingleTrack
from swaywatch.reproduce.chapter5 import ANGLE_DEG, COMPLIANCE, SPEED_KMH, tyre_vehicle
from swaywatch.reproduce.chapter6 import complex_v_crit_kmh, setup_of, theory
from swaywatch.reproduce.page import (
    BLUE,
    COLOURS,
    GREEN,
    GREY,
    ORANGE,
    RED,
    Chapter,
    Check,
    Plot,
    styled,
)
from swaywatch.reproduce.study import (
    KMH,
    VEHICLE,
    ImpulseDrive,
    State,
    drive_of,
    identify,
    in_parallel,
    judge_is_there,
    ladder_of,
)

OWN_N, OWN_DEG, EXTRA_N = 200.0, -60.0, 700.0
"""Load at 2 f that the vehicle has of itself (the text's amplitudes begin at 0.2 kN), and one that
the generator adds."""
TURNS_DEG = (-180.0, -120.0, -60.0, 0.0, 60.0, 120.0)
SERIES_DAMPER, PROTOTYPE = "normal", "failure_2"
LADDER_KMH = (104.0, 110.0, 116.0)
GROWS = -0.005
"""Damping ratio of a swing that doubles in half a minute."""


def make(workers: int | None = None) -> Chapter:
    """The whole chapter."""
    chapter = Chapter(
        "Courses over time (Fig. 1-3, 1-4, 4-4, 5-10 to 5-14, 6-6)",
        "Signals and estimates as they run; estimates are the C core's, at the middle of their "
        "window.",
    )
    _synthetic(chapter)
    _impulse(chapter)
    _own_load(chapter, workers)
    if judge_is_there():
        _dampers(chapter, workers)
    else:
        chapter.text += " Fig. 1-3 and 1-4 are left out: dampers need MuJoCo, not installed here."
    return chapter


# --- Fig. 4-4 -------------------------------------------------------------------------------------


def _synthetic(chapter: Chapter) -> None:
    """Eq. 4.3: a signal whose frequency falls and whose amplitude grows."""
    time = np.arange(0.0, 20.0, 0.01)
    degrees = (5.0 + 0.25 * time) * np.cos(2.0 * np.pi * (0.75 * time - 0.005 * time**2))
    signals = {
        "car_yaw_rate": np.radians(degrees), "speed": np.full(time.size, 30.0),
        "steering_wheel_angle": np.zeros(time.size),
    }  # fmt: skip
    drive = Drive("Eq. 4.3", (), {
        name: Channel(name, time, value, name, "") for name, value in signals.items()
    }, 0)  # fmt: skip
    found = analyze_drive(drive, dataclasses.replace(VEHICLE, trailer=None))
    rows = found.has("line")
    middle = found.time_s[rows]
    courses = (
        ("f [Hz]", found["frequency_hz"][rows], 0.75 - 0.01 * middle),
        ("A", np.degrees(found["amplitude_rad_s"][rows]), 5.0 + 0.25 * middle),
    )
    plot = make_subplots(rows=3, cols=1, shared_xaxes=True, vertical_spacing=0.04)
    plot.add_scatter(x=time, y=degrees, line={"color": GREY, "width": 1}, showlegend=False,
                     row=1, col=1)  # fmt: skip
    plot.update_yaxes(title="s(t)", row=1, col=1)
    for number, (label, ours, true) in enumerate(courses, start=2):
        plot.add_scatter(x=middle, y=true, name="Eq. 4.3", line={"color": GREY},
                         showlegend=number == 2, row=number, col=1)  # fmt: skip
        plot.add_scatter(x=middle, y=ours, name="C core", mode="markers",
                         marker={"color": BLUE, "size": 5}, showlegend=number == 2,
                         row=number, col=1)  # fmt: skip
        plot.update_yaxes(title=label, row=number, col=1)
        worst = float(np.max(np.abs(ours / true - 1.0))) if middle.size else math.nan
        chapter.checks.append(Check(
            f"Fig. 4-4: {label.split()[0]}(t) of Eq. 4.3, worst error", 0.0, 100.0 * worst, 1.0, "%"
        ))  # fmt: skip
    plot.update_xaxes(title="time [s]", row=3, col=1)
    chapter.parts.append(Plot(
        "Fig. 4-4: a synthetic signal that changes", styled(plot, 520),
        "The core knows nothing of it: a window of 1.7 oscillations follows both.",
    ))  # fmt: skip


# --- Fig. 5-10 to 5-14 ----------------------------------------------------------------------------

_AXLE_ROWS = (
    ("lateral_friction", "friction [1]", 1.0),
    ("cornering_stiffness_n_per_rad", "C [kN/rad]", 1e-3),
    ("effective_load_n", "F_z,eff [kN]", 1e-3),
    ("normalised_stiffness_per_rad", "zeta [1/rad]", 1.0),
)
_LABELS = {
    "car_front": "car, front", "car_rear": "car, rear", "trailer_front": "trailer, front",
    "trailer_rear": "trailer, rear",
}  # fmt: skip


def _impulse(chapter: Chapter) -> None:
    setup = ImpulseDrive(
        vehicle=tyre_vehicle(), physics=(COMPLIANCE,), speed_control=True, speed_kmh=SPEED_KMH,
        angle_deg=ANGLE_DEG, sensors="typical",
    )  # fmt: skip
    drive, trace = drive_of(setup)
    found = analyze_drive(drive, setup.vehicle)
    chapter.parts += [_slips(found, trace), *(_axle(found, axle) for axle in ("car_front",
                      "car_rear")), _inertias(found)]  # fmt: skip
    free = found.has("car_rear_load") & (found.time_s > 4.5) & (found.time_s < 10.0)
    for axle, stiffness, load in (("car_front", 109.3e3, 9674.0), ("car_rear", 185.2e3, 10204.0)):
        mean = float(np.mean(found[f"{axle}.normalised_stiffness_per_rad"][free]))
        chapter.checks.append(Check(
            f"Fig. 5-12, 5-13: normalised stiffness, {_LABELS[axle]}, C/F_z of Table A",
            stiffness / load, mean, 0.05 * stiffness / load, "1/rad",
        ))  # fmt: skip
    slip = _true_slip(trace, found.time_s[free])
    ours = found["car_rear.slip_amplitude_rad"][free]
    chapter.checks.append(Check(
        "Fig. 5-10: slip of the car's rear axle, from signals against the plant's, worst", 0.0,
        100.0 * float(np.max(np.abs(ours / slip - 1.0))), 5.0, "%",
    ))  # fmt: skip


def _true_slip(trace: Trace, middle: Any) -> Any:
    """Amplitude of the rear axle's slip about each time, rad, by a fit over one oscillation."""
    slip = 0.5 * (trace["wheel_slip_rl"] + trace["wheel_slip_rr"])
    found = []
    for moment in middle:
        inside = np.abs(trace.time_s - moment) < 0.75
        t = trace.time_s[inside] - moment
        phase = 2.0 * np.pi * 0.669 * t
        columns = np.column_stack([
            np.cos(phase), np.sin(phase), t * np.cos(phase), t * np.sin(phase), np.ones(t.size)
        ])  # fmt: skip
        a, b, *_ = np.linalg.lstsq(columns, slip[inside], rcond=None)[0]
        found.append(math.hypot(a, b))
    return np.array(found)


def _slips(found: Estimates, trace: Trace) -> Plot:
    plot = go.Figure()
    for (axle, label), colour in zip(_LABELS.items(), COLOURS, strict=False):
        rows = found.has(axle)
        plot.add_scatter(
            x=found.time_s[rows], y=np.degrees(found[f"{axle}.slip_amplitude_rad"][rows]),
            name=label, line={"color": colour},
        )  # fmt: skip
    slip = np.degrees(0.5 * (trace["wheel_slip_rl"] + trace["wheel_slip_rr"]))
    plot.add_scatter(x=trace.time_s[::2], y=slip[::2], name="car, rear, the plant's own",
                     line={"color": GREY, "width": 1})  # fmt: skip
    plot.update_xaxes(title="time [s]")
    plot.update_yaxes(title="slip angle, amplitude [deg]")
    return Plot(
        "Fig. 5-10: axle slip over time", styled(plot, 380),
        "Amplitudes by Eq. 4.5-4.7 from yaw rate, lateral acceleration and speed.",
    )  # fmt: skip


def _axle(found: Estimates, axle: str) -> Plot:
    plot = make_subplots(rows=len(_AXLE_ROWS), cols=1, shared_xaxes=True, vertical_spacing=0.03)
    rows = found.has(axle)
    loaded = rows & found.has(f"{axle}_load")
    for number, (column, label, factor) in enumerate(_AXLE_ROWS, start=1):
        use = loaded if "load" in column or "normalised" in column else rows
        plot.add_scatter(
            x=found.time_s[use], y=factor * found[f"{axle}.{column}"][use], showlegend=False,
            line={"color": COLOURS[number - 1]}, row=number, col=1,
        )  # fmt: skip
        plot.update_yaxes(title=label, row=number, col=1)
    plot.update_xaxes(title="middle of the window [s]", row=len(_AXLE_ROWS), col=1)
    figure = "5-12" if axle == "car_front" else "5-13"
    return Plot(
        f"Fig. {figure}: friction, stiffness, effective load, normalised stiffness, "
        f"{_LABELS[axle]}", styled(plot, 560),
        "Table A's vehicle has linear tyres: friction follows the swing, the rest stays.",
    )  # fmt: skip


def _inertias(found: Estimates) -> Plot:
    plot = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.05)
    rows = found.has("car_rear") & (found.time_s > 3.5)
    for name, column, colour in (
        ("car", "car_yaw_inertia", BLUE), ("trailer", "trailer_yaw_inertia", ORANGE)
    ):  # fmt: skip
        plot.add_scatter(x=found.time_s[rows], y=found[f"{column}_kgm2"][rows], name=name,
                         line={"color": colour}, row=1, col=1)  # fmt: skip
        plot.add_scatter(
            x=found.time_s[rows], y=np.degrees(found[f"{column}_argument_rad"][rows]),
            showlegend=False, line={"color": colour}, row=2, col=1,
        )  # fmt: skip
    for name, column, colour in (
        ("trailer, method 1", "trailer_yaw_inertia_1_kgm2", GREEN),
        ("trailer, method 2", "trailer_yaw_inertia_2_kgm2", RED),
    ):
        plot.add_scatter(x=found.time_s[rows], y=found[column][rows], name=name,
                         line={"color": colour}, row=1, col=1)  # fmt: skip
    plot.update_yaxes(title="I_z [kg m2]", row=1, col=1)
    plot.update_yaxes(title="argument [deg]", row=2, col=1)
    plot.update_xaxes(title="middle of the window [s]", row=2, col=1)
    return Plot(
        "Fig. 5-14: yaw inertias over time, with their arguments", styled(plot, 460),
        "An argument away from zero says that something lags between the forces and the body.",
    )  # fmt: skip


# --- Fig. 6-6 -------------------------------------------------------------------------------------


def together(extra_n: float, phase_deg: float) -> tuple[float, float]:
    """Amplitude (N) and phase (deg) of the vehicle's own load and an extra one."""
    own = OWN_N * cmath.exp(1j * math.radians(OWN_DEG))
    whole = own + extra_n * cmath.exp(1j * math.radians(phase_deg))
    return abs(whole), math.degrees(cmath.phase(whole))


def _own_load(chapter: Chapter, workers: int | None) -> None:
    both = [together(EXTRA_N, phase) for phase in TURNS_DEG]
    setups = [dataclasses.replace(setup_of(*one), speed_kmh=theory(*one)[1]) for one in both]
    states = in_parallel(identify, setups, workers)
    fine = np.linspace(-180.0, 180.0, 73)
    drawn = [together(EXTRA_N, phase) for phase in fine]
    plot = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.05)
    plot.add_scatter(x=fine, y=[amplitude for amplitude, _ in drawn], name="own and extra load",
                     line={"color": GREY}, row=1, col=1)  # fmt: skip
    plot.add_scatter(
        x=TURNS_DEG, y=[state.load_harmonic_n for state in states], mode="markers",
        name="C core", marker={"color": BLUE, "size": 8}, row=1, col=1,
    )  # fmt: skip
    speeds = [complex_v_crit_kmh(theory(*one)[0]) for one in drawn]
    plot.add_scatter(x=fine, y=speeds, showlegend=False, line={"color": GREY}, row=2, col=1)
    plot.update_yaxes(title="amplitude at 2 f [N]", row=1, col=1)
    plot.update_yaxes(title="v_crit [km/h]", row=2, col=1)
    plot.update_xaxes(title="phase of the extra load [deg]", dtick=60, row=2, col=1)
    chapter.parts.append(Plot(
        "Fig. 6-6: a vehicle with a load at 2 f of its own", styled(plot, 460),
        f"Own load {OWN_N:.0f} N at {OWN_DEG:.0f} deg, extra {EXTRA_N:.0f} N: what acts depends on "
        "the phase of what is added, by twice the own load.",
    ))  # fmt: skip
    worst = max(
        abs(state.load_harmonic_n - amplitude)
        for state, (amplitude, _) in zip(states, both, strict=True)
    )
    chapter.checks += [
        Check("Fig. 6-6: amplitude of own and extra load, read by the core, worst", 0.0, worst,
              0.1 * EXTRA_N, "N"),
        Check("v_crit over the phase with a load of its own, highest less lowest (text: ca. 10)",
              10.0, max(speeds) - min(speeds), 1.0, "km/h",
              cause="goes with the amplitude, which the text does not give for this figure"),
    ]  # fmt: skip


# --- Fig. 1-3, 1-4 --------------------------------------------------------------------------------


def _road(speed_kmh: float, damper: str) -> ImpulseDrive:
    return ImpulseDrive(model="multibody", damper=damper, speed_kmh=speed_kmh, angle_deg=19.0,
                 duration_s=16.0)  # fmt: skip


def damped(setup: ImpulseDrive) -> tuple[State, Trace]:
    """State after the impulse, and the drive."""
    return identify(setup), drive_of(setup)[1]


def _dampers(chapter: Chapter, workers: int | None) -> None:
    ladder = ladder_of(
        in_parallel(identify, [_road(v, SERIES_DAMPER) for v in LADDER_KMH], workers)
    )
    critical = ladder.v_crit_kmh
    kinds = {"series (normal)": SERIES_DAMPER, "prototype (failure II)": PROTOTYPE}
    drives = in_parallel(damped, [_road(critical, kind) for kind in kinds.values()], workers)
    plot = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.05)
    for row, (name, (state, trace)) in enumerate(zip(kinds, drives, strict=True), start=1):
        for body, colour in (("car", BLUE), ("trailer", ORANGE)):
            plot.add_scatter(
                x=trace.time_s, y=np.degrees(trace[f"{body}_yaw_rate"]), name=body,
                line={"color": colour, "width": 1.2}, showlegend=row == 1, row=row, col=1,
            )  # fmt: skip
        plot.update_yaxes(title=f"{name}<br>yaw rate [deg/s]", row=row, col=1)
        del state
    plot.update_xaxes(title="time [s]", row=2, col=1)
    series, prototype = (state.damping_ratio for state, _ in drives)
    chapter.parts.append(Plot(
        "Fig. 1-3, 1-4: yaw rates after the impulse with two kinds of damper", styled(plot, 480),
        f"Rigid-body plant on MuJoCo, bodies moving, {critical:.1f} km/h: dampers of the kind "
        f"'{SERIES_DAMPER}' (damping ratio {series:+.4f}) and of the kind '{PROTOTYPE}' "
        f"({prototype:+.4f}), see Table 6-1.",
    ))  # fmt: skip
    chapter.checks += [
        Check("Fig. 1-3: yaw rate of the trailer over that of the car (text: almost twice)", 2.0,
              _ratio_of(drives), 0.2, "1",
              cause=f"the single track's mode has {_mode_ratio(critical):.2f} at this speed"),
        Check("Fig. 1-4 less 1-3: damping ratio, prototype less series damper (text: unstable)",
              GROWS, prototype - series, 0.0, "1", "below",
              cause="their rear axle loads at 2 f differ by "
              f"{_line_at_2f(drives[1]) - _line_at_2f(drives[0]):+.0f} N here; {_needed():.0f} N "
              "in the worst phase would do it: a fault of these dampers alone is too small"),
    ]  # fmt: skip


def _line_at_2f(drive: tuple[State, Trace]) -> float:
    """Amplitude in N of the rear axle load at twice the sway frequency, over whole periods."""
    state, trace = drive
    turn = 4.0 * math.pi * state.frequency_hz
    inside = (trace.time_s > 5.0) & (trace.time_s < 5.0 + 8.0 * math.pi / turn * 4.0)
    load = trace.axle_load("car_rear")[inside]
    t = trace.time_s[inside]
    return float(2.0 * abs(np.mean((load - load.mean()) * np.exp(-1j * turn * t))))


def _needed() -> float:
    """Load at 2 f in the worst phase that lowers the damping ratio by `GROWS`, N."""
    model = SingleTrack.of(VEHICLE)
    speed = model.critical_speed()
    slope = (model.modes(speed + 0.5)[0].damping_ratio - model.modes(speed)[0].damping_ratio) / 0.5
    lost = KMH * GROWS / slope  # km/h
    low, high = 0.0, 3000.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        worst = min(theory(middle, phase)[1] for phase in (-60.0, -90.0, -120.0))
        low, high = (middle, high) if KMH * speed - worst < lost else (low, middle)
    return low


def _ratio_of(drives: Sequence[tuple[State, Trace]]) -> float:
    trace = drives[0][1]
    late = trace.time_s > 5.0
    return float(np.std(trace["trailer_yaw_rate"][late]) / np.std(trace["car_yaw_rate"][late]))


def _mode_ratio(speed_kmh: float) -> float:
    """Yaw rate of the trailer over that of the car in the weak mode of the single track."""
    a, _ = SingleTrack.of(VEHICLE).state_space(speed_kmh / KMH)
    values, vectors = np.linalg.eig(a)
    k = int(np.argmax(np.where(values.imag > 1.0, values.real, -np.inf)))
    car, articulation = vectors[1, k], vectors[3, k] * values[k]
    return float(abs(car + articulation) / abs(car))
