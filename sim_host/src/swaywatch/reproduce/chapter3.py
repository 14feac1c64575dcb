"""Chapter 3: root locus, damping over speed, sensitivities (Fig. 3-4 to 3-7)."""

from __future__ import annotations

import dataclasses

import numpy as np
import plotly.graph_objects as go

from swaywatch.models.single_track import PARAMETERS, SingleTrack
from swaywatch.reproduce.leads import trailer_alone
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
    State,
    identify,
    in_parallel,
    judge_is_there,
    ladder_of,
    ladders,
)  # fmt: skip
from swaywatch.vehicle import Vehicle

SPEEDS_KMH = (80.0, 85.0, 90.0, 95.0, 100.0, 107.9, 112.0, 117.3, 120.0, 123.0, 126.0, 129.0)
OFFSETS_KMH = (-5.0, -1.7, 1.7, 5.0)
AXLES = {
    "cf1": ("car", "front_cornering_stiffness", "car, front"),
    "cr1": ("car", "rear_cornering_stiffness", "car, rear"),
    "cf2": ("trailer", "front_cornering_stiffness", "trailer, front"),
    "cr2": ("trailer", "rear_cornering_stiffness", "trailer, rear"),
}
FIELDS = {
    "m1": ("car", "mass"), "iz1": ("car", "yaw_inertia"), "lf1": ("car", "front_axle_to_cog"),
    "lr1": ("car", "rear_axle_to_cog"), "lh1": ("car", "hitch_to_cog"),
    "m2": ("trailer", "mass"), "iz2": ("trailer", "yaw_inertia"),
    "lf2": ("trailer", "front_axle_to_cog"), "lr2": ("trailer", "rear_axle_to_cog"),
    "lh2": ("trailer", "hitch_to_cog"), **{name: AXLES[name][:2] for name in AXLES},
}  # fmt: skip
LABELS = dict(
    zip(
        PARAMETERS,
        ("m1", "m2", "Iz1", "Iz2", "lf1", "lr1", "lh1", "lf2", "lr2", "lh2",
         "Caf1", "Car1", "Caf2", "Car2"),
        strict=True,
    )
)  # fmt: skip
REFERENCE = {
    "m1": 0.188, "m2": -0.216, "iz1": 0.140, "iz2": -0.721, "lf1": 0.064, "lr1": 0.844,
    "lh1": -0.767, "lf2": -0.062, "lr2": 0.284, "lh2": 1.452, "cf1": -0.156, "cr1": 0.440,
    "cf2": 0.005, "cr2": 0.334,
}  # fmt: skip


def changed(name: str, factor: float) -> Vehicle:
    """The vehicle with one parameter of the single track scaled."""
    body, key = FIELDS[name]
    part = getattr(VEHICLE, body)
    part = dataclasses.replace(part, **{key: getattr(part, key) * factor})
    return dataclasses.replace(VEHICLE, **{body: part})


def make(workers: int | None = None) -> Chapter:
    """The whole chapter."""
    model = SingleTrack.of(VEHICLE)
    setups = [
        ImpulseDrive(speed_kmh=speed, sensors="typical", angle_deg=15.0) for speed in SPEEDS_KMH
    ]
    states = in_parallel(identify, setups, workers)
    near = [state for state in states if state.speed_kmh >= 117.0]
    v_crit = ladder_of(near).v_crit_kmh
    chapter = Chapter(
        "Chapter 3: stability of the combination",
        "Lines: the linear single track. Points: impulses simulated with the double track, eight "
        "wheels and sensors with noise, as `swaywatch simulate` makes them; damping and frequency "
        "are the C core's.",
    )
    exact = KMH * model.critical_speed()
    chapter.checks += [
        Check("critical speed of the single track (Tables A, B)", 123.34, exact, 0.01, "km/h"),
        Check("critical speed of the simulated drives (Eq. 3.43)", 123.3, v_crit, 1.2, "km/h"),
        *_agreement(model, states),
    ]
    chapter.parts += [_root_locus(model, states), _damping(model, states)]
    _depths(chapter, model, workers)
    _sensitivities(chapter, model, workers)
    _stiffness(chapter, model, workers)
    return chapter


def _depths(chapter: Chapter, model: SingleTrack, workers: int | None) -> None:
    """The three depths of model in the linear limit."""
    speeds = (80.0, 100.0, 107.9, 117.3)
    depths: tuple[str, ...] = ("single_track", "double_track")
    if judge_is_there():
        depths = (*depths, "multibody")
    jobs = [ImpulseDrive(speed_kmh=speed, model=depth, angle_deg=1.0) for speed in speeds
            for depth in depths]  # fmt: skip
    states = in_parallel(identify, jobs, workers)
    rows: list[tuple[str | float, ...]] = []
    worst = {depth: [0.0, 0.0] for depth in depths}
    for number, speed in enumerate(speeds):
        mode = model.modes(speed / KMH)[0]
        mine = states[number * len(depths) : (number + 1) * len(depths)]
        rows.append((f"{speed:g} km/h", mode.damping_ratio,
                     *(state.damping_ratio for state in mine), mode.frequency_hz,
                     *(state.frequency_hz for state in mine)))  # fmt: skip
        for depth, state in zip(depths, mine, strict=True):
            worst[depth] = [
                max(worst[depth][0], abs(state.damping_ratio / mode.damping_ratio - 1.0)),
                max(worst[depth][1], abs(state.frequency_hz / mode.frequency_hz - 1.0)),
            ]
    for depth, (damping, frequency) in worst.items():
        chapter.checks += [
            Check(f"{depth}, linear limit, 80-117.3 km/h: damping, worst", 0.0, 100.0 * damping,
                  1.0, "%"),
            Check(f"{depth}, linear limit, 80-117.3 km/h: frequency, worst", 0.0, 100.0 * frequency,
                  1.0, "%"),
        ]  # fmt: skip
    head = ("", "damping: exact", *depths, "frequency [Hz]: exact", *depths)
    chapter.parts.append(
        PageTable("Three depths of model, impulse of 1 deg, C core", head, tuple(rows),
              "multibody: the rigid-body plant on MuJoCo with level bodies, where it is installed.")
    )  # fmt: skip


def _agreement(model: SingleTrack, states: list[State]) -> list[Check]:
    """Linear limit: damping and frequency of single and double track within 1 %."""
    checks = []
    for speed in (80.0, 100.0, 107.9, 117.3):
        state = next(state for state in states if state.speed_kmh == speed)
        mode = model.modes(speed / KMH)[0]
        tolerance = 0.01 * mode.damping_ratio + 2.0 * state.damping_se
        checks += [
            Check(f"damping ratio at {speed:g} km/h", mode.damping_ratio, state.damping_ratio,
                  tolerance, "1"),
            Check(f"frequency at {speed:g} km/h", mode.frequency_hz, state.frequency_hz,
                  0.01 * mode.frequency_hz, "Hz"),
        ]  # fmt: skip
    return checks


def _root_locus(model: SingleTrack, states: list[State]) -> Plot:
    plot = go.Figure()
    speeds = np.linspace(30.0, 140.0, 111)
    roots = model.root_locus([speed / KMH for speed in speeds])
    for column in range(4):
        plot.add_scatter(
            x=roots[:, column].real, y=roots[:, column].imag, mode="markers",
            marker={"size": 5, "color": speeds, "colorscale": "Viridis", "showscale": column == 0,
                    "colorbar": {"title": "km/h"}},
            showlegend=False, text=[f"{speed:g} km/h" for speed in speeds],
        )  # fmt: skip
    omega = [2.0 * np.pi * state.frequency_hz for state in states]
    sigma = [
        -state.damping_ratio * w / np.sqrt(1.0 - state.damping_ratio**2)
        for state, w in zip(states, omega, strict=True)
    ]
    plot.add_scatter(
        x=sigma, y=omega, mode="markers", name="simulated drives, C core",
        marker={"symbol": "circle-open", "size": 11, "color": RED, "line": {"width": 2}},
    )  # fmt: skip
    plot.add_vline(x=0.0, line={"color": GREY, "dash": "dot"})
    plot.update_xaxes(title="real part [1/s]", range=[-12.0, 1.5])
    plot.update_yaxes(title="imaginary part [rad/s]")
    return Plot(
        "Fig. 3-4: root locus over the speed", styled(plot),
        "The weakly damped pair crosses the axis at 123.34 km/h; the simulated drives lie on it.",
    )  # fmt: skip


def _damping(model: SingleTrack, states: list[State]) -> Plot:
    speeds = np.linspace(30.0, 140.0, 111)
    car = dataclasses.replace(model, has_trailer=False)
    trailer = trailer_alone()
    plot = go.Figure()
    for name, single, colour in (
        ("car alone", car, BLUE), ("trailer alone", trailer, GREEN)
    ):  # fmt: skip
        values = [single.modes(speed / KMH)[0].damping_ratio for speed in speeds]
        plot.add_scatter(x=speeds, y=values, name=name, line={"color": colour})
    both = [model.modes(speed / KMH) for speed in speeds]
    for place, name in ((0, "combination, weak mode"), (-1, "combination, other mode")):
        plot.add_scatter(
            x=speeds, y=[modes[place].damping_ratio for modes in both], name=name,
            line={"color": ORANGE, "dash": "solid" if place == 0 else "dash"},
        )  # fmt: skip
    plot.add_scatter(
        x=[state.speed_kmh for state in states], y=[state.damping_ratio for state in states],
        mode="markers", name="simulated drives, C core",
        marker={"symbol": "circle-open", "size": 10, "color": RED, "line": {"width": 2}},
        error_y={"type": "data", "array": [2.0 * state.damping_se for state in states]},
    )  # fmt: skip
    plot.add_hline(y=0.0, line={"color": GREY, "dash": "dot"})
    plot.update_xaxes(title="speed [km/h]")
    plot.update_yaxes(title="yaw damping ratio [1]")
    return Plot(
        "Fig. 3-5: damping ratios of car, trailer and combination", styled(plot),
        "The text says that the trailer alone stays near 1 because it steers neutrally; it "
        "understeers (0.086 rad) and its curve falls to 0.80. Only the combination has a mode "
        "whose damping falls to zero.",
    )  # fmt: skip


def _sensitivities(chapter: Chapter, model: SingleTrack, workers: int | None) -> None:
    setups = [ImpulseDrive(vehicle=changed(name, 1.01)) for name in PARAMETERS]
    shifts = {name: KMH * model.sensitivity(name) for name in PARAMETERS}
    around = [123.34 + shifts[name] for name in PARAMETERS]
    found = ladders([ImpulseDrive(), *setups], OFFSETS_KMH, [123.34, *around], workers, degree=2)
    base = found[0].v_crit_kmh
    simulated = {
        name: ladder.v_crit_kmh - base for name, ladder in zip(PARAMETERS, found[1:], strict=True)
    }
    plot = go.Figure()
    labels = [LABELS[name] for name in PARAMETERS]
    for name, values, colour in (
        ("single track", shifts, BLUE), ("simulated drives, C core", simulated, ORANGE)
    ):  # fmt: skip
        plot.add_bar(x=labels, y=[values[key] for key in PARAMETERS], name=name,
                     marker={"color": colour})  # fmt: skip
    plot.update_yaxes(title="change of critical speed [km/h] for +1 %")
    chapter.parts.append(Plot(
        "Fig. 3-6: sensitivity of the critical speed to each parameter (Eq. 3.44)", styled(plot),
        "Each bar of the simulated drives is the difference of two ladders of impulses.",
    ))  # fmt: skip
    chapter.checks += [
        Check(f"v_crit for +1 % of {LABELS[name]}, simulated drives", REFERENCE[name],
              simulated[name], 0.02, "km/h")
        for name in PARAMETERS
    ]  # fmt: skip


def _stiffness(chapter: Chapter, model: SingleTrack, workers: int | None) -> None:
    factors = np.linspace(0.8, 1.2, 41)
    points = (0.8, 0.9, 1.1, 1.2)
    plot = go.Figure()
    setups, around = [], []
    for name in AXLES:
        for factor in points:
            grown = dataclasses.replace(model, **{name: getattr(model, name) * factor})
            setups.append(ImpulseDrive(vehicle=changed(name, factor)))
            around.append(KMH * grown.critical_speed())
    found = ladders(setups, OFFSETS_KMH, around, workers, degree=2)
    for number, (name, (_, _, label)) in enumerate(AXLES.items()):
        base = getattr(model, name)
        line = [
            KMH * dataclasses.replace(model, **{name: base * factor}).critical_speed()
            for factor in factors
        ]
        colour = COLOURS[number]
        plot.add_scatter(x=100.0 * (factors - 1.0), y=line, name=label, line={"color": colour})
        mine = found[number * len(points) : (number + 1) * len(points)]
        plot.add_scatter(
            x=[100.0 * (factor - 1.0) for factor in points],
            y=[ladder.v_crit_kmh for ladder in mine], mode="markers", showlegend=False,
            marker={"color": colour, "size": 10, "symbol": "circle-open", "line": {"width": 2}},
        )  # fmt: skip
    plot.update_xaxes(title="change of the axle's cornering stiffness [%]")
    plot.update_yaxes(title="critical speed [km/h]")
    chapter.parts.append(Plot(
        "Fig. 3-7: critical speed over the axles' cornering stiffness", styled(plot),
        "Circles: simulated drives, C core. The rear axle of the car has the largest influence.",
    ))  # fmt: skip
    worst = max(abs(ladder.v_crit_kmh - v) for ladder, v in zip(found, around, strict=True))
    chapter.checks.append(
        Check("Fig. 3-7: worst distance of simulated drives to the line", 0.0, worst, 0.1, "km/h")
    )
