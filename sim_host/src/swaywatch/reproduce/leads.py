"""What chapters 3.2.1, 5.2.6 and 6.3 leave open, each by a computed experiment.

Static gains (Fig. 3-3, Eq. 3.19-3.35), the damping of the car alone (Fig. 3-5), and what the text
supposes to lie between its critical speeds: roll, air, ball load, lags. A figure that is not met
says which experiment would meet it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from swaywatch.diagnose.fit.data import body_of
from swaywatch.models import modes
from swaywatch.models.single_track import SingleTrack
from swaywatch.plant import sprung
from swaywatch.plant.lanes import PlantInput, neutral
from swaywatch.reproduce.page import (
    BLUE,
    COLOURS,
    GREY,
    Chapter,
    Check,
    PageTable,
    Plot,
    styled,
)
from swaywatch.reproduce.study import CAR, KMH, VEHICLE, ImpulseDrive, State, identify, in_parallel

Array = NDArray[np.float64]

G = 9.81
BODY_VALUES = body_of(VEHICLE)
RELAXATION_M = 0.3
RELAXING = {f"relaxation_{axle}": RELAXATION_M for axle in ("car_front", "car_rear", "trailer")}
CRITERION = 0.05
"""5.2.4: within 5 % of the experiment."""
CA = 0.1
"""Of what the text gives as "ca.": a tenth."""
DEGREES = 3.0
"""Of arguments: what separates the text's own two methods (Table 5-1, up to 2 deg) and a bit."""
SIMULATED = {"car_front": -7.6, "car_rear": -5.2, "trailer_front": -13.9, "trailer_rear": -18.3}
"""Arguments of Table 5-1, simulation M1, deg."""
LAGS_DEG = (2.0, 4.0)
"""By which the car's side forces reach its body late, at the sway frequency."""


def v_crit(slots: Mapping[str, float] | None = None, body: Array = BODY_VALUES) -> float:
    """Critical speed of the plant with slots filled, km/h, by its eigenvalues."""
    still = np.zeros(3)
    plant = PlantInput(0.002, still + 20.0, still, still, body, neutral())
    for name, value in (slots or {}).items():
        plant.scalar(name, value)
    return KMH * modes.critical_speed(plant)


def make(workers: int | None = None) -> Chapter:
    """The whole chapter."""
    chapter = Chapter(
        "What the text leaves open (3.2.1, 5.2.6)",
        "Eigenvalues of the plant with what is supposed switched on, one thing at a time, and "
        "simulated drives read by the C core. Sprung vehicle: values by the rules of "
        "plant/sprung.py, a relaxation length of 0.3 m at every axle.",
    )
    _static(chapter)
    _solo_damping(chapter)
    _roll(chapter)
    _air(chapter)
    _ball_load(chapter)
    _sprung_table(chapter, workers)
    _inertia(chapter, workers)
    return chapter


# --- Fig. 3-3 and Eq. 3.19-3.35 -------------------------------------------------------------------


def _static(chapter: Chapter) -> None:
    model = SingleTrack.of(VEHICLE)
    solo = dataclasses.replace(model, has_trailer=False)
    speeds = np.linspace(5.0, 70.0, 131)
    plot = go.Figure()
    length = model.lf1 + model.lr1
    found = {"car alone": _gradient(solo), "with the trailer": _gradient(model)}
    for (name, (own_length, gradient)), colour in zip(found.items(), COLOURS, strict=False):
        gain = speeds / (own_length + gradient * speeds**2 / G)
        plot.add_scatter(
            x=KMH * speeds, y=gain, name=f"{name}: {gradient:.4f} rad", line={"color": colour}
        )
    plot.add_scatter(x=KMH * speeds, y=speeds / length, name="neutral",
                     line={"color": GREY, "dash": "dot"})  # fmt: skip
    over = speeds / (length - 0.012 * speeds**2 / G)
    kept = over > 0.0
    plot.add_scatter(x=KMH * speeds[kept], y=np.minimum(over[kept], 40.0), name="oversteering",
                     line={"color": BLUE, "dash": "dash"})  # fmt: skip
    plot.update_xaxes(title="speed [km/h]")
    plot.update_yaxes(title="yaw rate over road-wheel angle [1/s]", range=[0.0, 30.0])
    chapter.parts.append(Plot(
        "Fig. 3-3: yaw rate gain over the speed", styled(plot, 400),
        "An understeering car has its largest gain at the characteristic speed "
        f"({KMH * math.sqrt(length * G / found['car alone'][1]):.0f} km/h here); an oversteering "
        "one (dashed, -0.012 rad) has none and a static critical speed. The trailer's load takes "
        "understeer away.",
    ))  # fmt: skip
    own, equivalent = _hitch_gradient(model, found["with the trailer"])
    chapter.checks += [
        Check("K_u of the car alone (Eq. 3.20)", 0.04016, found["car alone"][1], 0.00005, "rad"),
        Check("K_u,1'' with the tandem trailer (Eq. 3.28)", 0.03367, found["with the trailer"][1],
              0.00005, "rad"),
        Check("yaw rate gain at 20 m/s (Eq. 3.26)", 4.98953, _gain(model, 20.0), 0.0005, "1/s"),
    ]  # fmt: skip
    chapter.parts.append(PageTable(
        "Eq. 3.33-3.35: the hitch angle",
        ("", "from the steady states of the single track", "Eq. 3.34, 3.35 as printed"),
        (("L_theta [m]", own, _printed_length(model)),
         ("K_u,2'' [rad]", equivalent, _printed_gradient(model))),
        "Hitch angle over road-wheel angle is (L_theta + K_u,2'' v^2/g) / (L + K_u,1'' v^2/g), "
        "psi_2 - psi_1. The last term of Eq. 3.34 as printed lacks the factor (l_1 + l_hr1)/l_1; "
        f"with it L_theta is {_printed_length(model, corrected=True):.4f} m.",
    ))  # fmt: skip
    chapter.checks += [
        Check("L_theta, Eq. 3.34 with its last term corrected, against the steady states", own,
              _printed_length(model, corrected=True), 0.002, "m"),
        Check("K_u,2'' of Eq. 3.35 against the steady states", equivalent,
              _printed_gradient(model), 0.0005, "rad"),
    ]  # fmt: skip


def _gain(model: SingleTrack, speed: float) -> float:
    """Yaw rate of the car over the road-wheel angle, 1/s."""
    return float(model.steady_state(speed)[1])


def _angle(model: SingleTrack, speed: float) -> float:
    """Articulation over the road-wheel angle."""
    return float(model.steady_state(speed)[3])


def _gradient(model: SingleTrack) -> tuple[float, float]:
    """Length (m) and understeer gradient (rad) of v / gain = L + K v^2 / g."""
    speeds = np.array([10.0, 20.0, 30.0])
    over = [v / _gain(model, v) for v in speeds]
    slope, length = np.polyfit(speeds**2, over, 1)
    return float(length), float(slope * G)


def _hitch_gradient(model: SingleTrack, car: tuple[float, float]) -> tuple[float, float]:
    """L_theta (m) and K_u,2'' (rad) from the steady states."""
    speeds = np.array([10.0, 20.0, 30.0])
    above = [_angle(model, v) * (car[0] + car[1] * v**2 / G) for v in speeds]
    slope, length = np.polyfit(speeds**2, above, 1)
    return float(length), float(slope * G)


def _printed(model: SingleTrack) -> tuple[float, ...]:
    """l_1, l_hr1, l_2, l_hf2 of App. A.1 and what Eq. 3.27-3.35 divide by."""
    l1, lhr1, l2 = model.lf1 + model.lr1, model.lh1 - model.lr1, model.lf2 + model.lr2
    lhf2 = model.lh2 - model.lf2
    return l1, lhr1, l2, lhf2, model.cf2 * lhf2 + model.cr2 * (l2 + lhf2)


def _printed_length(model: SingleTrack, corrected: bool = False) -> float:
    l1, lhr1, l2, lhf2, below = _printed(model)
    cf2, cr1, cr2 = model.cf2, model.cr1, model.cr2
    last = cf2 * cr2 * l2**2 * ((l1 + lhr1) / l1 if corrected else 1.0)
    own = cf2 * (lhr1 + lhf2) * lhf2 + cr2 * (l2 + lhf2) * (l2 + lhf2 + lhr1)
    return -(cr1 * own + last) / (cr1 * below)


def _printed_gradient(model: SingleTrack) -> float:
    l1, lhr1, _, lhf2, below = _printed(model)
    car = model.m1 * G / l1 * model.lf1 / model.cr1
    moment = (model.cf2 * model.lf2 - model.cr2 * model.lr2) * (l1 + lhr1)
    trailer = moment + model.cr1 * l1 * (model.lf2 + lhf2)
    return -car + model.m2 * G / l1 * trailer / (model.cr1 * below)


def trailer_alone() -> SingleTrack:
    """The trailer as a vehicle of its own, as in Fig. 3-5."""
    m = SingleTrack.of(VEHICLE)
    return SingleTrack(
        m1=m.m2, iz1=m.iz2, lf1=m.lf2, lr1=m.lr2, lh1=0.0, cf1=m.cf2, cr1=m.cr2,
        steering_ratio=m.steering_ratio, has_trailer=False,
    )  # fmt: skip


def _solo_damping(chapter: Chapter) -> None:
    """Fig. 3-5: its caption calls the trailer neutral; it understeers, and its curve falls."""
    car = dataclasses.replace(SingleTrack.of(VEHICLE), has_trailer=False)
    trailer = trailer_alone()
    chapter.checks += [
        Check("Fig. 3-5: damping ratio of the car alone at 80 km/h", 0.796,
              car.modes(80.0 / KMH)[0].damping_ratio, 0.001, "1"),
        Check("Fig. 3-5: damping ratio of the car alone at 140 km/h", 0.580,
              car.modes(140.0 / KMH)[0].damping_ratio, 0.001, "1"),
        Check("Fig. 3-5: damping ratio of the trailer alone at 140 km/h (its curve)", 0.80,
              trailer.modes(140.0 / KMH)[0].damping_ratio, 0.01, "1"),
        Check("Fig. 3-5: damping ratio of the trailer alone at 140 km/h (text: nearly 1.0)", 1.0,
              trailer.modes(140.0 / KMH)[0].damping_ratio, CA,
              "1", cause="the text calls the trailer neutral; its axles give it K_u = "
              f"{_gradient(trailer)[1]:.3f} rad, twice the car's"),
    ]  # fmt: skip


# --- 5.2.6 ----------------------------------------------------------------------------------------


def _ball_heights_of(target_kmh: float, base: Mapping[str, float]) -> float:
    """Height of the ball over both roll axes that gives a critical speed, m."""
    low, high = 0.0, 0.6
    for _ in range(14):
        middle = 0.5 * (low + high)
        found = v_crit({**base, "ball_height_car": middle, "ball_height_trailer": middle})
        low, high = (middle, high) if found > target_kmh else (low, middle)
    return 0.5 * (low + high)


def _roll(chapter: Chapter) -> None:
    base = sprung.defaults(BODY_VALUES)
    height = _ball_heights_of(117.3, base)
    base |= {"ball_height_car": height, "ball_height_trailer": height}
    rows: list[tuple[str | float, ...]] = []
    speeds: dict[str, float] = {}
    for words, names in (
        ("as it is", ()), ("car", ("car",)), ("car and trailer", ("car", "trailer"))
    ):  # fmt: skip
        slots = base | {
            f"roll_stiffness_{n}": 10.0 * base[f"roll_stiffness_{n}"] for n in names
        }  # fmt: skip
        speeds[words] = v_crit(slots)
        rows.append((words, speeds[words], speeds[words] - speeds["as it is"]))
    chapter.parts.append(PageTable(
        "Roll stiffness times ten", ("stiffer", "v_crit [km/h]", "change [km/h]"), tuple(rows),
        f"Ball {height:.2f} m over both roll axes: so the rolling vehicle has the 117.3 km/h of "
        f"the text's simulation, where a rigid one has {v_crit():.1f} km/h.",
    ))  # fmt: skip
    both = speeds["car and trailer"] - speeds["as it is"]
    chapter.checks.append(Check(
        "v_crit with the car's roll stiffness times ten (text: ca. +6.0)", 6.0,
        speeds["car"] - speeds["as it is"], CA * 6.0, "km/h",
        cause=f"stiffening the trailer too gives {both:+.1f} km/h: all that roll costs, up to the "
        f"rigid {v_crit():.1f}; which body it comes from depends on the height of the ball above "
        "its roll axis, which the text does not give",
    ))  # fmt: skip


def _air(chapter: Chapter) -> None:
    """Side force and yaw moment on areas of 1.5 to 5 m2."""
    rigid, cases = v_crit(), ((1.8, 0.9), (1.0, 0.0), (0.0, 1.0))
    rows: list[tuple[str | float, ...]] = []
    for side, yaw in cases:
        rows.append((f"{side:g}, {yaw:g}", *(
            v_crit({"aero_side": side * area / 5.0, "aero_yaw": yaw * area / 5.0}) - rigid
            for area in (1.5, 3.0, 5.0)
        )))  # fmt: skip
    typical = v_crit({"aero_side": 1.8, "aero_yaw": 0.9}) - rigid
    low, high = 0.0, 10.0
    for _ in range(20):
        middle = 0.5 * (low + high)
        found = v_crit({"aero_side": 1.8, "aero_yaw": middle}) - rigid
        low, high = (middle, high) if found > -3.0 else (low, middle)
    chapter.parts.append(PageTable(
        "Air on the trailer: change of v_crit [km/h]",
        ("side force and yaw moment coefficient", "1.5 m2", "3 m2", "5 m2"), tuple(rows),
        "Coefficients per rad on the area, the moment on the area times 1 m, positive aligning.",
    ))  # fmt: skip
    chapter.checks.append(Check(
        "v_crit with air on the trailer (text: ca. -3.0)", -3.0, typical, CA * 3.0, "km/h",
        cause=f"with c_s 1.8 and c_n 0.9 on 5 m2; a yaw moment of c_n = {middle:.1f} gives -3.0, "
        "the text names neither coefficients nor area",
    ))  # fmt: skip


def ball_load(force_n: float, *, stiffness: bool, moved: float = 0.0) -> float:
    """Critical speed with more load on the ball, km/h.

    Parameters
    ----------
    force_n
        More than the vehicle has.
    stiffness
        Whether stiffnesses follow the axle loads.
    moved
        Distance over which the load was moved forward that does it, m; 0: the centre of gravity
        stays where it is.
    """
    m = SingleTrack.of(VEHICLE)
    l1, lhr1 = m.lf1 + m.lr1, m.lh1 - m.lr1
    axles = m.lh2 + 0.5 * (m.lr2 - m.lf2)
    change: dict[str, float] = {}
    if stiffness:
        loads = (CAR.front_axle_load or 1.0, CAR.rear_axle_load or 1.0)
        own = VEHICLE.trailer
        assert own is not None
        tandem = (own.front_axle_load or 1.0) + (own.rear_axle_load or 1.0)
        change = {
            "cf1": m.cf1 * (1.0 - force_n * lhr1 / l1 / loads[0]),
            "cr1": m.cr1 * (1.0 + force_n * (l1 + lhr1) / l1 / loads[1]),
            "cf2": m.cf2 * (1.0 - force_n / tandem), "cr2": m.cr2 * (1.0 - force_n / tandem),
        }  # fmt: skip
    if moved:
        shift = force_n * axles / (m.m2 * G)
        mass = m.m2 * shift / moved  # from `moved` behind the centre of gravity to it
        change |= {
            "lh2": m.lh2 - shift, "lf2": m.lf2 - shift, "lr2": m.lr2 + shift,
            "iz2": m.iz2 - mass * moved**2 - m.m2 * shift**2,
        }  # fmt: skip
    return KMH * SingleTrack(**{**m.__dict__, **change}).critical_speed()


def _ball_load(chapter: Chapter) -> None:
    before = ball_load(0.0, stiffness=False)
    ways = {
        "stiffness follows the loads, centre of gravity where it was": {"stiffness": True},
        "load moved 1 m forward": {"stiffness": True, "moved": 1.0},
        "load moved 2.5 m forward, from the rear wall": {"stiffness": True, "moved": 2.5},
    }
    change = {
        words: ball_load(500.0, **options) - before  # type: ignore[arg-type]
        for words, options in ways.items()
    }
    chapter.parts.append(PageTable(
        "500 N more on the ball", ("how", "change of v_crit [km/h]"), tuple(change.items()),
        "The axles come to lie further behind the centre of gravity, and a load taken from the "
        "rear takes yaw inertia with it.",
    ))  # fmt: skip
    inertia = 20.0 / -SingleTrack.of(VEHICLE).sensitivity("iz2") / KMH
    most = max(change.values())
    chapter.checks.append(Check(
        "v_crit for 500 N more on the ball (text, measured elsewhere: ca. +20)", 20.0, most,
        CA * 20.0, "km/h",
        cause=f"ball load alone gives {change[next(iter(change))]:+.1f}, with the load taken from "
        f"the rear wall {most:+.1f}; +20 would need {inertia:.0f} % less yaw inertia of the "
        "trailer: the experiments quoted changed more than the ball load",
    ))  # fmt: skip


def _sprung_table(chapter: Chapter, workers: int | None) -> None:
    """Table 5-1 from a vehicle on springs: arguments that nobody put in."""
    base = sprung.defaults(BODY_VALUES)
    setups = {
        "rigid, tyres relax": ImpulseDrive(physics=_relaxing()),
        "on springs": ImpulseDrive(sprung={}),
        "on springs, tyres relax": ImpulseDrive(physics=_relaxing(), sprung={}),
    }
    states = dict(zip(setups, in_parallel(identify, setups.values(), workers), strict=True))
    speeds = {
        "rigid, tyres relax": v_crit(RELAXING),
        "on springs": v_crit(base),
        "on springs, tyres relax": v_crit({**base, **RELAXING}),
    }
    rows: list[tuple[str | float, ...]] = [
        (axle.replace("_", ", "), f"{text:+.1f}",
         *(f"{states[name].stiffness[axle] / 1e3:.1f} ({states[name].argument_deg[axle]:+.1f} deg)"
           for name in setups))
        for axle, text in SIMULATED.items()
    ]  # fmt: skip
    rows.append(("v_crit [km/h]", "117.3", *(f"{speeds[name]:.1f}" for name in setups)))
    chapter.parts.append(PageTable(
        "Table 5-1 from the plant: stiffness [kN/rad] with its argument, core",
        ("", "text, simulation M1 [deg]", *setups), tuple(rows),
        "Nothing of Table 5-1 is put in: arguments come from roll and relaxation of the plant.",
    ))  # fmt: skip
    whole = states["on springs, tyres relax"]
    chapter.checks.append(Check(
        "Table 5-1: v_crit of the vehicle on springs with relaxing tyres", 117.3,
        speeds["on springs, tyres relax"], CRITERION * 117.3, "km/h",
    ))  # fmt: skip
    for axle, text in SIMULATED.items():
        chapter.checks.append(Check(
            f"Table 5-1: argument of {axle.replace('_', ', ')}, from the plant", text,
            whole.argument_deg[axle], DEGREES, "deg", cause=_argument_cause(axle, text, states),
        ))  # fmt: skip


def _relaxing() -> tuple[dict[str, object], ...]:
    return tuple(
        {"id": "tyre_relaxation", "axle": axle, "length_m": RELAXATION_M} for axle in SIMULATED
    )


def _argument_cause(axle: str, text: float, states: Mapping[str, State]) -> str:
    """What relaxation and roll give apart, and the length that would give the text's."""
    relaxed, rolled = (
        states[name].argument_deg[axle] for name in ("rigid, tyres relax", "on springs")
    )
    needed = RELAXATION_M * math.tan(math.radians(rolled - text)) / math.tan(
        math.radians(max(-relaxed, 0.1))
    )  # fmt: skip
    return (
        f"relaxation of {RELAXATION_M:g} m alone gives {relaxed:+.1f} deg, roll alone "
        f"{rolled:+.1f} deg; a length of {needed:.2f} m would give the text's: its tyres and "
        "suspension have more lag than these"
    )


def _inertia(chapter: Chapter, workers: int | None) -> None:
    """Table 5-2 with percentages, and the lag that takes the car's estimate down."""
    lags = [
        ({"id": "suspension_lag", "lag_s": math.tan(math.radians(a)) / (2.0 * math.pi * 0.67)},)
        for a in LAGS_DEG
    ]
    setups = (ImpulseDrive(), *(ImpulseDrive(physics=lag) for lag in lags), ImpulseDrive(sprung={}))
    plain, half, lagged, rolling = in_parallel(identify, setups, workers)
    given = (2690.0, 10350.0, 10350.0, 10350.0)
    text = (2360.0, math.nan, 9920.0, 8185.0)
    names = ("car", "trailer, wheel forces", "trailer, method 1", "trailer, method 2")
    rows: list[tuple[str | float, ...]] = []
    for k, (name, want, said) in enumerate(zip(names, given, text, strict=True)):
        row: list[str | float] = [name, want, said]
        for state in (plain, lagged, rolling):
            row += [state.inertia_kgm2[k], 100.0 * (state.inertia_kgm2[k] / want - 1.0)]
        rows.append(tuple(row))
    chapter.parts.append(PageTable(
        "Table 5-2: yaw inertia [kg m2] and its error [%]",
        ("", "given", "text, simulation", "rigid", "%",
         f"car's forces {LAGS_DEG[1]:g} deg late", "%",
         "on springs", "%"), tuple(rows),
        "Text: 12.3 % for the car, 1.4 % and 16.1 % for the trailer by methods 1 and 2 (means of "
        "experiment and simulation).",
    ))  # fmt: skip
    car = [state.inertia_kgm2[0] for state in (lagged, half, plain)]
    turn = float(np.interp(2360.0, car, [LAGS_DEG[1], LAGS_DEG[0], 0.0]))
    for k, (name, said) in enumerate(zip(names, text, strict=True)):
        if math.isnan(said):
            continue
        chapter.checks.append(Check(
            f"Table 5-2: yaw inertia, {name}, against the text's simulation", said,
            plain.inertia_kgm2[k], CRITERION * said, "kg m2",
            cause=(
                f"without a lag the estimate is the given 2690; side forces that reach the body "
                f"{turn:.1f} deg late make 2360 of it: the car's yaw moment is a small difference "
                "of large ones, and the text's estimates have an argument of 20 deg"
                if k == 0
                else f"rolling on springs brings {rolling.inertia_kgm2[k]:.0f}; the method, which "
                "takes the axles' forces from their loads, errs the same way in both (given 10350)"
            ),
        ))  # fmt: skip
