"""Chapter 6: the axle load that oscillates at twice the yaw frequency (6.2 to 6.4)."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from swaywatch.ecu.core import Estimates, analyze_drive
from swaywatch.models.double_track import Trace
from swaywatch.models.single_track import SingleTrack
from swaywatch.plant.layout import Array
from swaywatch.reproduce import slalom
from swaywatch.reproduce.page import (
    BLUE,
    COLOURS,
    GREEN,
    GREY,
    ORANGE,
    RED,
    Chapter,
    Check,
    PageTable,
    Plot,
    styled,
)  # fmt: skip
from swaywatch.reproduce.study import (
    KMH,
    VEHICLE,
    ImpulseDrive,
    Ladder,
    drive_of,
    in_parallel,
    judge_is_there,
    ladders,
)
from swaywatch.simulate.run import simulate_plant
from swaywatch.simulate.scenario import read_scenario

AMPLITUDES_N = (0.0, 200.0, 400.0, 600.0, 800.0, 1000.0, 1200.0)
PHASES_DEG = tuple(float(phase) for phase in range(-180, 181, 30))
CASES = ((0.0, BLUE), (-90.0, ORANGE), (-180.0, RED))
PHASE_AMPLITUDE_N = 1000.0
OFFSETS_KMH = (-3.0, -1.0, 1.0, 3.0)
LEVEL_TIME_S = 1.5
"""The load follows the level of the oscillation with this time constant; estimates start later."""
FREQUENCY_HZ = 0.672
LOAD_N, STIFFNESS = 10204.0, 185.2e3

# Second-phase validation: Table 6-3 and the impulse before it.
WINDOWS = ((54.0, 56.0, 2.5, -120.0), (59.0, 61.0, 2.0, 30.0))
FORCE_PER_GAIN_N = 400.0
"""Load amplitude per unit of gain at the yaw rate after the impulse: 1 kN at 2.5 (Fig. 6-1)."""
IMPULSE_S = 48.0
LENGTH_S = 72.0
MEAN_TIME_S = 1.0
FRONT_LOAD = "car_front.effective_load_n"


def complex_v_crit_kmh(stiffness: complex) -> float:
    """Critical speed of the single track whose C_ar1 is complex: a lag or lead at the axle."""
    model = SingleTrack.of(VEHICLE)

    def growth(speed: float) -> float:
        m, with_axle, _ = model.matrices(speed)
        _, without, _ = SingleTrack(**{**model.__dict__, "cr1": 0.0}).matrices(speed)
        d = without + (with_axle - without) * (stiffness / model.cr1)
        roots = np.linalg.eigvals(np.linalg.solve(m, d.astype(complex)))
        swaying = roots[roots.imag > 1.0]
        return float(swaying.real.max())

    low, high = 80.0 / KMH, 160.0 / KMH
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if growth(middle) < 0.0 else (low, middle)
    return KMH * low


def theory(amplitude_n: float, phase_deg: float) -> tuple[complex, float]:
    """Complex C_ar1 (Eq. 4.13 with its imaginary part kept) and the critical speed with it."""
    effective = LOAD_N + 0.5 * amplitude_n * cmath.exp(1j * math.radians(phase_deg))
    stiffness = STIFFNESS / LOAD_N * effective
    return stiffness, complex_v_crit_kmh(stiffness)


def harmonic(amplitude_n: float, phase_deg: float) -> tuple[dict[str, Any], ...]:
    """The load of given amplitude and phase as physics; none below 1 N."""
    if amplitude_n < 1.0:
        return ()
    return (
        {
            "id": "axle_load_harmonic", "axle": "car_rear", "form": "harmonic",
            "amplitude_n": amplitude_n, "phase_deg": phase_deg, "frequency_hz": FREQUENCY_HZ,
            "level_time_s": LEVEL_TIME_S,
        },
    )  # fmt: skip


def setup_of(amplitude_n: float, phase_deg: float) -> ImpulseDrive:
    """A drive whose load has settled when it is identified."""
    return ImpulseDrive(
        physics=harmonic(amplitude_n, phase_deg), angle_deg=10.0, duration_s=20.0,
        first_s=5.0, last_s=11.0,
    )  # fmt: skip


def make(workers: int | None = None) -> Chapter:
    """The whole chapter."""
    chapter = Chapter(
        "Chapter 6: harmonic axle load",
        "An extra load at twice the yaw frequency acts on the car's rear axle. Phase is that of "
        "the load to the square of the axle's side force (Fig. 4-5). Lines: single track with the "
        "complex stiffness of Eq. 4.13; points: ladders of simulated impulses, C core.",
    )
    points = [(a, p) for p, _ in CASES for a in AMPLITUDES_N]
    turns = [(PHASE_AMPLITUDE_N, p) for p in PHASES_DEG]
    jobs = points + turns
    setups = [setup_of(a, p) for a, p in jobs]
    around = [theory(a, p)[1] for a, p in jobs]
    found = ladders(setups, OFFSETS_KMH, around, workers, degree=2)
    by_amplitude = found[: len(points)]
    by_phase = found[len(points) :]
    chapter.parts += [
        _figure_65(points, by_amplitude, by_phase),
        _figure_argument(by_phase),
    ]
    _checks(chapter, by_amplitude, by_phase)
    slalom.add_to(chapter, workers)
    _second_phase(chapter)
    if judge_is_there():
        _dampers(chapter, workers)
    else:
        chapter.text += " Table 6-1 is left out: its dampers need MuJoCo, which is not installed."
    return chapter


Measured = Callable[[Ladder], float]
Expected = Callable[[complex, float], float]


def _stiffness(ladder: Ladder) -> float:
    return ladder.at_critical(lambda state: state.stiffness["car_rear"]) / 1e3


def _effective(ladder: Ladder) -> float:
    return ladder.at_critical(lambda state: state.effective_load_n) / 1e3


def _normalised(ladder: Ladder) -> float:
    return ladder.at_critical(lambda state: state.normalised)


def _v_crit_of_identified(ladder: Ladder) -> float:
    """Critical speed of the single track with the stiffness and argument that the core found."""
    turn = math.radians(ladder.at_critical(lambda state: state.argument_deg["car_rear"]))
    return complex_v_crit_kmh(1e3 * _stiffness(ladder) * cmath.exp(1j * turn))


_ROWS: tuple[tuple[str, Measured, Expected], ...] = (
    ("v_crit [km/h]", lambda ladder: ladder.v_crit_kmh, lambda _c, v: v),
    ("|C_ar1| [kN/rad]", _stiffness, lambda c, _v: abs(c) / 1e3),
    ("F_zr,eff [kN]", _effective, lambda c, _v: abs(c) / STIFFNESS * LOAD_N / 1e3),
    ("normalised stiffness [1/rad]", _normalised, lambda _c, _v: STIFFNESS / LOAD_N),
)
"""Panels of Fig. 6-5: label, what the drives give, what theory expects of complex C and v_crit."""


def _figure_65(
    points: Sequence[tuple[float, float]], by_amplitude: list[Ladder], by_phase: list[Ladder]
) -> Plot:
    plot = make_subplots(rows=4, cols=2, shared_xaxes=True, shared_yaxes=True,
                         vertical_spacing=0.03, horizontal_spacing=0.04)  # fmt: skip
    fine = np.linspace(0.0, 1200.0, 25)
    turns = np.linspace(-180.0, 180.0, 73)
    for row, (label, measured, expected) in enumerate(_ROWS, start=1):
        for phase, colour in CASES:
            mine = [k for k, (_, p) in enumerate(points) if p == phase]
            name = f"{phase:g} deg"
            plot.add_scatter(
                x=[points[k][0] / 1e3 for k in mine], y=[measured(by_amplitude[k]) for k in mine],
                mode="markers", marker={"color": colour, "size": 8}, name=name, legendgroup=name,
                showlegend=row == 1, row=row, col=1,
            )  # fmt: skip
            plot.add_scatter(
                x=fine / 1e3, y=[expected(*theory(a, phase)) for a in fine], mode="lines",
                line={"color": colour, "width": 1}, showlegend=False, row=row, col=1,
            )  # fmt: skip
        plot.add_scatter(
            x=PHASES_DEG, y=[measured(ladder) for ladder in by_phase], mode="markers",
            marker={"color": GREEN, "size": 8}, showlegend=False, row=row, col=2,
        )  # fmt: skip
        plot.add_scatter(
            x=turns, y=[expected(*theory(PHASE_AMPLITUDE_N, p)) for p in turns], mode="lines",
            line={"color": GREEN, "width": 1}, showlegend=False, row=row, col=2,
        )  # fmt: skip
        plot.update_yaxes(title=label, row=row, col=1)
    plot.update_yaxes(range=[17.6, 18.7], row=4)
    plot.update_xaxes(title="amplitude of the load [kN]", row=4, col=1)
    plot.update_xaxes(title="phase to F_y squared [deg], 1 kN", dtick=60, row=4, col=2)
    return Plot(
        "Fig. 6-5: influence of amplitude (left) and phase (right)", styled(plot, 860),
        "At 0 and -180 deg the critical speed follows the effective load. At -90 deg it falls "
        "although the effective load stays: the load then turns the argument of C_ar1, which acts "
        "as a lag. The text saw the fall and left it open.",
    )  # fmt: skip


def _figure_argument(by_phase: list[Ladder]) -> Plot:
    turns = np.linspace(-180.0, 180.0, 73)
    plot = go.Figure()
    plot.add_scatter(
        x=PHASES_DEG,
        y=[ladder.at_critical(lambda s: s.argument_deg["car_rear"]) for ladder in by_phase],
        mode="markers", marker={"color": GREEN, "size": 8}, name="simulated drives, C core",
    )  # fmt: skip
    plot.add_scatter(
        x=turns,
        y=[math.degrees(cmath.phase(theory(PHASE_AMPLITUDE_N, p)[0])) for p in turns],
        line={"color": GREY, "width": 1}, name="Eq. 4.13, imaginary part kept",
    )  # fmt: skip
    plot.update_xaxes(title="phase to F_y squared [deg], 1 kN", dtick=60)
    plot.update_yaxes(title="argument of C_ar1 [deg]")
    return Plot(
        "What tells +90 from -90 deg: the argument of C_ar1", styled(plot, 360),
        "The effective load is the same at both; the sign of the argument is not.",
    )  # fmt: skip


def _checks(chapter: Chapter, by_amplitude: list[Ladder], by_phase: list[Ladder]) -> None:
    speeds = [ladder.v_crit_kmh for ladder in by_phase]
    count = len(AMPLITUDES_N)
    last = {p: by_amplitude[k * count + count - 1].v_crit_kmh for k, (p, _) in enumerate(CASES)}
    across = [ladder.v_crit_kmh for ladder in by_amplitude]
    read = [_v_crit_of_identified(ladder) for ladder in by_phase]
    worst = max(abs(a - b) for a, b in zip(speeds, read, strict=True))
    unity = [_normalised(ladder) for ladder in by_amplitude]
    chapter.checks += [
        Check("v_crit over the phase of a load of 1 kN, highest less lowest (text: ca. 10)",
              10.0, max(speeds) - min(speeds), 1.0, "km/h",
              cause=f"a load of {_load_for(10.0):.0f} N gives 10.0 km/h; the text's own amplitude "
              "changes with the phase (Fig. 6-6) and is not given"),
        Check("v_crit over amplitudes to 1.2 kN, highest less lowest (text: ca. 10)",
              10.0, max(across) - min(across), 1.0, "km/h"),
        Check("v_crit over the phase: drives less single track with complex C_ar1, worst",
              0.0, worst, 0.5, "km/h"),
        Check("v_crit at 1.2 kN, 0 deg, change", theory(1200.0, 0.0)[1] - 123.34,
              last[0.0] - 123.34, 0.5, "km/h"),
        Check("v_crit at 1.2 kN, -180 deg, change", theory(1200.0, -180.0)[1] - 123.34,
              last[-180.0] - 123.34, 0.5, "km/h"),
        Check("normalised stiffness stays C/F_z (proportional tyres), worst change",
              0.0, max(abs(value / unity[0] - 1.0) for value in unity) * 100.0, 1.0, "%"),
    ]  # fmt: skip


def _load_for(range_kmh: float) -> float:
    """Load at 2 f whose phase moves the critical speed by so much, N."""
    low, high = 0.0, 2000.0
    for _ in range(20):
        middle = 0.5 * (low + high)
        speeds = [theory(middle, phase)[1] for phase in PHASES_DEG]
        wide = max(speeds) - min(speeds) > range_kmh
        low, high = (low, middle) if wide else (middle, high)
    return low


# Second-phase validation --------------------------------------------------------------------------


def generator_windows(trace: Trace) -> tuple[dict[str, Any], ...]:
    """Table 6-3 as gains and delays of the generator of Fig. 6-3.

    The gain is relative: :data:`FORCE_PER_GAIN_N` at the yaw rate after the impulse. The delay
    puts the load at the wanted phase to F_y squared, knowing how far yaw rate and side force are
    apart and what the high-pass turns.
    """
    late = (trace.time_s > 50.0) & (trace.time_s < 54.0)
    frequency = _frequency(trace.time_s[late], trace["car_yaw_rate"][late])
    yaw = _line(trace.time_s[late], trace["car_yaw_rate"][late], frequency)
    force = _line(trace.time_s[late], trace.axle_force("car_rear")[late], frequency)
    omega_2 = 4.0 * math.pi * frequency
    lead = math.atan(1.0 / (omega_2 * MEAN_TIME_S)) + 2.0 * cmath.phase(yaw / force)
    windows = [
        {
            "start_s": start, "stop_s": stop,
            "gain_n_s2_per_rad2": gain * FORCE_PER_GAIN_N / (0.5 * abs(yaw) ** 2),
            "delay_s": ((lead - math.radians(phase)) % (2.0 * math.pi)) / omega_2,
        }
        for start, stop, gain, phase in WINDOWS
    ]  # fmt: skip
    return (
        {
            "id": "axle_load_harmonic", "axle": "car_rear", "form": "generator",
            "mean_time_s": MEAN_TIME_S, "windows": windows,
        },
    )  # fmt: skip


def _line(time: Array, value: Array, frequency: float) -> complex:
    columns = np.column_stack([
        np.cos(2.0 * math.pi * frequency * time), np.sin(2.0 * math.pi * frequency * time),
        np.ones_like(time),
    ])  # fmt: skip
    a, b, _ = np.linalg.lstsq(columns, value, rcond=None)[0]
    return complex(a, -b)


def _frequency(time: Array, value: Array) -> float:
    """Frequency of a noise-free sine by its own recursion."""
    middle = value[1:-1]
    ratio = float(np.dot(value[2:] + value[:-2], middle) / np.dot(middle, middle))
    turn = math.acos(min(max(0.5 * ratio, -1.0), 1.0))
    return turn / (2.0 * math.pi * float(time[1] - time[0]))


def _second_phase(chapter: Chapter) -> None:
    speed = KMH * SingleTrack.of(VEHICLE).critical_speed()
    common: dict[str, Any] = {
        "speed_kmh": speed, "angle_deg": 10.0, "start_s": IMPULSE_S, "duration_s": LENGTH_S,
        "sensors": "typical",
    }  # fmt: skip
    without = ImpulseDrive(**common)
    drive, trace = drive_of(without)
    found = {"without the load": analyze_drive(drive, VEHICLE)}
    physics = generator_windows(trace)
    loaded, truth = drive_of(ImpulseDrive(**common, physics=physics))
    found["with the load"] = analyze_drive(loaded, VEHICLE)
    chapter.parts += [_figure_drive(trace, truth), *_courses(found), _table_63(physics)]
    _second_checks(chapter, found, truth)


def _figure_drive(without: Trace, loaded: Trace) -> Plot:
    plot = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.05)
    time = without.time_s
    shown = (time > 46.0) & (time < 68.0)
    for trace, name, colour in (
        (without, "without the load", GREY), (loaded, "with the load", BLUE)
    ):  # fmt: skip
        plot.add_scatter(x=time[shown], y=np.degrees(trace["car_yaw_rate"][shown]), name=name,
                         line={"color": colour, "width": 1.3}, row=1, col=1)  # fmt: skip
        plot.add_scatter(x=time[shown], y=trace.axle_load("car_rear")[shown] / 1e3,
                         line={"color": colour, "width": 1.3}, showlegend=False,
                         row=2, col=1)  # fmt: skip
    plot.update_yaxes(title="yaw rate, car [deg/s]", row=1, col=1)
    plot.update_yaxes(title="rear axle load [kN]", row=2, col=1)
    plot.update_xaxes(title="time [s]", row=2, col=1)
    return Plot(
        "Fig. 6-9, 6-13: yaw rate and rear axle load", styled(plot, 460),
        "In 54-56 s the load lets the oscillation grow, in 59-61 s it takes it back.",
    )  # fmt: skip


_SERIES = (
    ("frequency_hz", "f [Hz]", 1.0, "line"),
    ("car_rear.cornering_stiffness_n_per_rad", "C_ar1 [kN/rad]", 1e-3, "car_rear"),
    ("car_rear.effective_load_n", "F_zr,eff [kN]", 1e-3, "car_rear_load"),
    ("car_rear.normalised_stiffness_per_rad", "zeta_r1 [1/rad]", 1.0, "car_rear_load"),
    ("damping_ratio", "damping ratio [1]", 1.0, "line"),
)
_FRONT = (
    ("car_front.load_n", "F_zf [kN]", 1e-3, "car_front_load"),
    ("car_front.cornering_stiffness_n_per_rad", "C_af1 [kN/rad]", 1e-3, "car_front"),
    (FRONT_LOAD, "F_zf,eff [kN]", 1e-3, "car_front_load"),
    ("car_front.normalised_stiffness_per_rad", "zeta_f1 [1/rad]", 1.0, "car_front_load"),
)


def _figure_estimates(
    found: dict[str, Estimates], series: Sequence[tuple[str, str, float, str]], title: str,
    text: str,
) -> Plot:  # fmt: skip
    plot = make_subplots(rows=len(series), cols=1, shared_xaxes=True, vertical_spacing=0.03)
    for row, (column, label, factor, bit) in enumerate(series, start=1):
        for (name, estimates), colour in zip(found.items(), (GREY, BLUE), strict=True):
            rows = estimates.has(bit) & (estimates.time_s > 50.5)
            plot.add_scatter(
                x=estimates.time_s[rows], y=factor * estimates[column][rows], name=name,
                line={"color": colour}, showlegend=row == 1, row=row, col=1,
            )  # fmt: skip
        plot.update_yaxes(title=label, row=row, col=1)
        for start, stop, _, _ in WINDOWS:
            plot.add_vrect(x0=start, x1=stop, fillcolor=ORANGE, opacity=0.15, line_width=0,
                           row=row, col=1)  # fmt: skip
    plot.update_xaxes(title="middle of the window [s]", row=len(series), col=1)
    return Plot(title, styled(plot, 140 * len(series) + 100), text)


def _courses(found: dict[str, Estimates]) -> list[Plot]:
    return [
        _figure_estimates(
            found, _SERIES,
            "Fig. 6-2, 6-9, 6-11, 6-13: f, C_ar1, F_eff, zeta_r and damping with and without the "
            "load",
            "C core, windows of 1.7 oscillations (2.5 s): a load of 2 s shows smaller, spread over "
            "the window.",
        ),
        _figure_estimates(
            found, _FRONT, "Fig. 6-12: the front axle of the car, with and without the load",
            "The load acts at the rear axle; the front axle does not see it.",
        ),
    ]  # fmt: skip


def _table_63(physics: tuple[dict[str, Any], ...]) -> PageTable:
    rows = tuple(
        (f"{start:g}-{stop:g} s", gain, phase, gain * FORCE_PER_GAIN_N, window["delay_s"])
        for (start, stop, gain, phase), window in zip(WINDOWS, physics[0]["windows"], strict=True)
    )
    return PageTable(
        "Table 6-3: generator in the two windows",
        ("window", "gain", "phase [deg]", "amplitude after the impulse [N]", "delay [s]"),
        rows,
        "The text's gain has no unit; here 1 is 400 N at the yaw rate after the impulse, which "
        "gives the 1 kN of Fig. 6-1.",
    )


def _mean_in(estimates: Estimates, column: str, bit: str, first: float, last: float) -> float:
    rows = estimates.has(bit) & (estimates.time_s >= first) & (estimates.time_s <= last)
    return float(np.mean(estimates[column][rows])) if rows.any() else float("nan")


def _plant_line(trace: Trace) -> float:
    """Largest amplitude at 2 f of the plant's rear axle load in the windows, N."""
    sizes = []
    for start, stop, _, _ in WINDOWS:
        inside = (trace.time_s > start) & (trace.time_s < stop)
        load = trace.axle_load("car_rear")[inside]
        sizes.append(abs(_line(trace.time_s[inside], load - load.mean(), 2.0 * FREQUENCY_HZ)))
    return max(sizes)


def _second_checks(chapter: Chapter, found: dict[str, Estimates], loaded: Trace) -> None:
    with_load, plain = found["with the load"], found["without the load"]
    stiffness = "car_rear.cornering_stiffness_n_per_rad"
    for (start, stop, gain, phase), words in zip(
        WINDOWS, ("falls", "rises"), strict=True
    ):  # fmt: skip
        middle = 0.5 * (start + stop)
        inside = (middle - 0.3, middle + 0.3)
        # The core's window of two periods holds the load for two of its three seconds.
        share = (stop - start) * FREQUENCY_HZ / 2.0
        effect = 0.5 * gain * FORCE_PER_GAIN_N * math.cos(math.radians(phase)) / LOAD_N
        change = _mean_in(with_load, stiffness, "car_rear", *inside) / _mean_in(
            plain, stiffness, "car_rear", *inside
        )
        chapter.checks.append(
            Check(f"C_ar1 {words} in {start:g}-{stop:g} s, change", 100.0 * share * effect,
                  100.0 * (change - 1.0), 0.7, "%")
        )  # fmt: skip
    load = "car_rear.load_harmonic_n"
    peak = max(
        _mean_in(with_load, load, "car_rear_load", start, stop) for start, stop, _, _ in WINDOWS
    )
    grown = [
        _mean_in(with_load, "damping_ratio", "line", 0.5 * (a + b) - 0.3, 0.5 * (a + b) + 0.3)
        for a, b, _, _ in WINDOWS
    ]
    chapter.checks += [
        Check("line at 2 f in the rear axle load, largest mean of a window (text: about 1 kN)",
              1000.0, peak, 100.0, "N",
              cause=f"the plant's own load reaches {_plant_line(loaded):.0f} N in its window; the "
              "core's window of 2.5 s holds a load of 2 s for a part of its length"),
        Check("Fig. 6-12: F_zf,eff of the front axle, change in 54-56 s (text: none)", 0.0,
              100.0 * (_mean_in(with_load, FRONT_LOAD, "car_front_load", 54.7, 55.3)
                       / _mean_in(plain, FRONT_LOAD, "car_front_load", 54.7, 55.3) - 1.0),
              1.0, "%"),
        Check("damping ratio in 54-56 s: unstable", 0.0, grown[0], 0.0, "1", "below"),
        Check("damping ratio in 59-61 s: recovers", 0.0, grown[1], 0.0, "1", "above"),
    ]  # fmt: skip


# Table 6-1: what dampers make of it ---------------------------------------------------------------

DAMPERS = {
    "linear": "(1) linear", "bilinear": "(2) bilinear", "normal": "(3) normal",
    "failure_1": "(4) failure I", "failure_2": "(5) failure II",
}  # fmt: skip
SLALOM_HZ = 0.6


def damper_drive(kind: str) -> Trace:
    """Slalom of the rigid-body plant on MuJoCo, bodies moving, all dampers of one kind."""
    content = {
        "vehicle": "-", "duration_s": 24.0, "speed_kmh": 85.0, "model": "multibody",
        "manoeuvre": [{"kind": "slalom", "start_s": 1.0, "duration_s": 22.0, "angle_deg": 14.0,
                       "frequency_hz": SLALOM_HZ}],
        "multibody": {"damper": {"kind": kind}},
    }  # fmt: skip
    scenario = read_scenario(content, kind, Path(), kind, vehicle=VEHICLE)
    return simulate_plant(scenario)


def axle_line(trace: Trace, axle: str, order: int) -> float:
    """Amplitude in N of an axle's load at a multiple of the slalom's frequency."""
    inside = (trace.time_s >= 8.0) & (trace.time_s < 8.0 + 8.0 / SLALOM_HZ)
    load = trace.axle_load(axle)[inside]
    return abs(_line(trace.time_s[inside], load - load.mean(), order * SLALOM_HZ))


def _dampers(chapter: Chapter, workers: int | None) -> None:
    traces = dict(zip(DAMPERS, in_parallel(damper_drive, DAMPERS, workers), strict=True))
    plot = go.Figure()
    for (kind, label), colour in zip(DAMPERS.items(), COLOURS, strict=False):
        trace = traces[kind]
        shown = (trace.time_s > 12.0) & (trace.time_s < 15.4)
        plot.add_scatter(x=trace.time_s[shown], y=trace.axle_load("car_rear")[shown] / 1e3,
                         name=label, line={"color": colour})  # fmt: skip
    plot.update_xaxes(title="time [s]")
    plot.update_yaxes(title="rear axle load [kN]")
    chapter.parts.append(Plot(
        "Table 6-1: rear axle load in a slalom of 0.6 Hz, rigid-body plant on MuJoCo",
        styled(plot, 380),
        "The load swings at twice the slalom's frequency with every kind of damper, because roll, "
        "pitch and the ball move the bodies up and down; dampers that pull and push unequally, or "
        "fail, add to it.",
    ))  # fmt: skip
    lines = {kind: [axle_line(trace, "car_rear", n) for n in (1, 2, 4)]
             for kind, trace in traces.items()}  # fmt: skip
    chapter.parts.append(PageTable(
        "Lines of the rear axle load [N]", ("dampers", "at f", "at 2 f", "at 4 f"),
        tuple((DAMPERS[kind], *values) for kind, values in lines.items()),
    ))  # fmt: skip
    linear, failed = lines["linear"], lines["failure_2"]
    chapter.checks += [
        Check("MuJoCo: line at 2 f of the rear axle load, failure II over linear", linear[1],
              failed[1], 0.0, "N", "above"),
        Check("MuJoCo: line at 2 f, normal over linear dampers", linear[1], lines["normal"][1], 0.0,
              "N", "above"),
    ]  # fmt: skip
