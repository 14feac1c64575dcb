"""The laws that are tried: a place, a variable and a shape, with their dimensions.

A law has no name, only a place where it acts, one motion variable on which it depends and the gain
between them (plant slots `law_*`); or it is a mass that oscillates (`mode_*`); or a lever of the
tyre side force (`trail_*`). Effects of the library are excluded, and so is everything that is
equivalent to a value of the vehicle file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from swaywatch.discover.known import KNOWN
from swaywatch.discover.way import AXLES, DISTANCE, SLOTS, comes_and_goes, left, phases
from swaywatch.effects.effect import Effect, Parameter, Values, Window
from swaywatch.effects.runs import RATE_HZ, Run
from swaywatch.errors import SwaywatchError
from swaywatch.plant.lanes import BODY, LAW_FELT, LAW_TO, PlantInput

Array = NDArray[np.float64]

ID = "law"
SPEED_M_S = 25.0  # at which the gain of a law is stated
#: In the plant's numbering. Hysteretic: dry friction behind an elastic part, after Dahl. Rubbing:
#: friction as large as the deflection, against its rate (structural damping, after Reid).
SHAPES = (
    "straight", "saturating", "dead zone", "cube", "odd square", "even square", "hysteretic",
    "rubbing", "positive side", "negative side", "waiting", "uneven", "limited rate",
    "line and cube",
)  # fmt: skip
#: Of another slope on the other side: what one side's tyres make, or two unlike springs.
UNEVEN = "uneven"
#: What a controller that waits for a swing to grow makes: nothing up to a swing, all beyond it.
WAITING = "waiting"
SWING_SEEN_S, SWING_KEPT_S, WAITING_SHARE = 0.05, 1.0, 0.1  # as in plant_lanes.c
#: What grows stiffer or softer, or drives a small motion and resists a large one.
LINE_AND_CUBE = "line and cube"
#: What an actuator makes that can go no faster.
LIMITED_RATE = "limited rate"
HURRY_S = 0.05  # as in plant_lanes.c
#: What acts to one side only: a rope, a chain, a valve, a stop.
SIDES = ("positive side", "negative side")
SLIDING = "hysteretic"
FRICTION = (SLIDING, "rubbing")  # these follow a deflection whose rate is a state too
ROLLS = ("roll_car", "roll_trailer")
DEFLECTIONS = ("articulation", *ROLLS)
IN_SERIES = (SHAPES[0], "saturating", "dead zone")  # shapes of a spring before a damper
KEEPING = (*FRICTION, WAITING, LIMITED_RATE)  # shapes that keep the one state of a law
OF_A_SHAPE = ("bend", "other_side", "per_square")  # numbers that only a shape has
BENDS = (1, 2, 6, 10, 12)  # shapes with a bend
LIMITED = ("saturating", "hysteretic")  # shapes that level off at gain times bend
#: When a law acts: at once, behind a lag, only while its variable changes (a washout: what has
#: lasted longer than the lag is forgotten), or the more the farther the recording has gone, until
#: it does so wholly; or the less; or again and again along the road.
RESPONSES = INSTANT, LAGGED, TRANSIENT, GROWING, FADING, PERIODIC = (
    "instant", "lagged", "transient", "growing", "fading", "periodic",
)  # fmt: skip
BY_THE_WAY = (GROWING, FADING)
RATE_S = 0.05  # over which the rate of steering is taken


@dataclass(frozen=True)
class Place:
    """Where a law can act: slot, words, unit, and a noticeable amplitude."""

    slot: str
    words: str
    unit: str
    level: float


@dataclass(frozen=True)
class Dependence:
    """A variable of a law: slot, words, symbol, unit, usual amplitude in a test drive."""

    slot: str
    words: str
    symbol: str
    unit: str
    usual: float


#: The side-slip of the place itself at which something acts.
THERE = "sideslip_there"
#: Places with a lever of their own, and the bodies that they are on.
ANYWHERE = {"at_car": "car", "at_trailer": "trailer"}
#: Half the log prior weight of a law without a known cause, see `Effect.plausibility`.
UNHEARD_OF = -1.0

PLACES = {
    p.slot: p
    for p in (
        Place("hitch", "moment at the hitch on the car, its opposite on the trailer", "Nm", 300.0),
        Place("force_car", "side force on the car", "N", 200.0),
        Place("force_trailer", "side force on the trailer", "N", 200.0),
        Place("at_car", "side force at a place of the car", "N", 200.0),
        Place("at_trailer", "side force at a place of the trailer", "N", 200.0),
        Place("moment_car", "yaw moment on the car", "Nm", 300.0),
        Place("moment_trailer", "yaw moment on the trailer", "Nm", 300.0),
        Place("slip_car_front", "steering angle of the front axle", "rad", 0.002),
        Place("slip_car_rear", "steering angle of the car's rear axle", "rad", 0.002),
        Place("slip_trailer", "steering angle of the trailer's axles", "rad", 0.002),
        Place(AXLES, "steering angle of every axle as it comes to a place", "rad", 0.002),
    )
}
MOTIONS = {
    m.slot: m
    for m in (
        Dependence("articulation", "articulation", "theta", "rad", 0.05),
        Dependence("articulation_rate", "articulation rate", "dtheta/dt", "rad/s", 0.15),
        Dependence("yaw_rate_car", "yaw rate of the car", "r1", "rad/s", 0.12),
        Dependence("yaw_rate_trailer", "yaw rate of the trailer", "r2", "rad/s", 0.15),
        Dependence("sideslip_car", "sideslip angle of the car", "beta1", "rad", 0.03),
        Dependence("sideslip_trailer", "sideslip angle of the trailer", "beta2", "rad", 0.04),
        Dependence("steer", "steering angle of the front wheels", "delta", "rad", 0.02),
        Dependence("steer_rate", "steering rate of the front wheels", "ddelta/dt", "rad/s", 0.06),
        Dependence("roll_car", "roll of the car", "phi1", "rad", 0.03),
        Dependence("roll_trailer", "roll of the trailer", "phi2", "rad", 0.03),
        Dependence("heading", "heading of the trailer", "psi2", "rad", 0.1),
        Dependence("heading_car", "heading of the car", "psi1", "rad", 0.1),
        Dependence("slip_car_front", "slip angle of the car's front tyres", "alpha_f", "rad", 0.02),
        Dependence("slip_car_rear", "slip angle of the car's rear tyres", "alpha_r", "rad", 0.02),
        Dependence("slip_trailer", "slip angle of the trailer's tyres", "alpha_t", "rad", 0.02),
        Dependence(
            "lateral_acceleration_car", "lateral acceleration of the car", "a_y1", "m/s2", 1.5
        ),
        Dependence(
            "lateral_acceleration_trailer",
            "lateral acceleration of the trailer",
            "a_y2",
            "m/s2",
            2.0,
        ),
        Dependence("hitch_force", "side force of the trailer on the ball", "F_ball", "N", 800.0),
        Dependence(AXLES, "slip angle of its tyres", "alpha", "rad", 0.02),
        Dependence(THERE, "side-slip angle of that place", "beta_there", "rad", 0.04),
        Dependence(DISTANCE, "distance driven", "s", "m", 1.0),
    )
}

#: Plant slots of motions that have none of their own.
MADE_OF = {
    "heading_car": {"heading": 1.0, "articulation": -1.0},
    "steer_rate": {"steer": 1.0 / RATE_S},  # what has changed within that time
}
HEADINGS = ("heading", "heading_car")
ALONE = (*HEADINGS, "steer_rate", *LAW_FELT)  # these take the one state that a law has
SLIPS = ("slip_car_front", "slip_car_rear", "slip_trailer")
AIR = ("force_trailer", "moment_trailer", "at_trailer")  # where it acts on the trailer

#: Pairs of place and motion, and the powers of the speed that are tried with each. Excluded are
#: library effects (hitch damping, air on the trailer, roll steer) and equivalents of a value of the
#: file (a force with a body's own sideslip is its cornering stiffness, with its yaw rate its mass).
#: What a controller or a linkage can act by (the yaw moment of a body, the steering of an axle) is
#: there with every motion that it can sense: both yaw rates, articulation, its rate, steering, its
#: rate, lateral accelerations; and a frame or an axle gives way to the force on the ball. Air
#: acts on the trailer with the sideslip of the car, whose wake it is in; what a road has
#: along it (grooves, a crown) holds every axle in its body's heading.
PAIRS: dict[str, dict[str, tuple[int, ...]]] = {
    "hitch": {"articulation": (0, 2)},
    "force_car": {
        "sideslip_car": (2,), "articulation": (0, 2), "heading": (0,),
        "lateral_acceleration_car": (0,),
    },
    "force_trailer": {
        "articulation": (0, 2), "heading": (0,), "sideslip_car": (2,),
        "lateral_acceleration_trailer": (0,),
    },
    "at_trailer": {"sideslip_car": (2,), "articulation": (2,)},
    "moment_car": {
        "yaw_rate_car": (-1, 0, 1, 2), "yaw_rate_trailer": (0,), "articulation": (0, 2),
        "articulation_rate": (0,), "sideslip_car": (0, 2), "steer": (0, 2), "roll_car": (0,),
        "steer_rate": (0,), "lateral_acceleration_car": (0,), "hitch_force": (0,),
        "lateral_acceleration_trailer": (0,),
    },
    "moment_trailer": {
        "yaw_rate_trailer": (-1, 0, 1, 2), "yaw_rate_car": (0,), "articulation": (0, 2),
        "articulation_rate": (0,), "steer": (0,), "roll_trailer": (0,),
        "steer_rate": (0,), "sideslip_car": (2,), "lateral_acceleration_trailer": (0,),
        "lateral_acceleration_car": (0,), "hitch_force": (0,),
    },
    "slip_car_front": {
        "yaw_rate_car": (0,), "articulation": (0,), "articulation_rate": (0,), "heading_car": (0,),
        "yaw_rate_trailer": (0,), "lateral_acceleration_car": (0,), "hitch_force": (0,),
    },
    "slip_car_rear": {
        "steer": (0, 2), "yaw_rate_car": (0,), "articulation": (0,), "articulation_rate": (0,),
        "yaw_rate_trailer": (0,), "steer_rate": (0,), "heading_car": (0,),
        "lateral_acceleration_car": (0,), "hitch_force": (0,),
    },
    "slip_trailer": {
        "articulation": (0, 2), "articulation_rate": (0,), "yaw_rate_trailer": (0,),
        "yaw_rate_car": (0,), "steer": (0, 2), "steer_rate": (0,), "heading": (0,),
        "lateral_acceleration_trailer": (0,), "hitch_force": (0,),
    },
}  # fmt: skip
#: Initial natural frequencies of an oscillating mass, Hz; the most promising one of each row is
#: fitted.
FREQUENCIES_HZ = ((0.35, 0.5, 0.65), (0.75, 0.85, 0.95, 1.1), (1.3, 1.6, 2.0, 2.6))
BODIES = ("car", "trailer")
SWINGS = ("swing", "turn")
#: Lever at which an oscillating mass acts by its moment only, m.
FAR_M = 1000.0
MOST_DAMPED = 0.7  # damping ratio up to which it counts as oscillating: 5 % overshoot


@dataclass(frozen=True)
class Law:
    """One law of the grammar.

    Attributes
    ----------
    place
        A key of `PLACES`; for an oscillating mass its body; for a lever of the side force "tyres".
    motion
        A key of `MOTIONS`; "side_force"; of an oscillation "swing" (lateral) or "turn" (about the
        vertical axis).
    shape
        One of `SHAPES`.
    power
        Of the speed.
    response
        One of `RESPONSES`.
    second
        Another motion that it depends on: on the sum of both, weighted; empty: on the first alone.
    """

    place: str
    motion: str
    shape: str = SHAPES[0]
    power: int = 0
    response: str = INSTANT
    second: str = ""

    @property
    def spec(self) -> str:
        """The law as one string, as stored in a model block."""
        of = "+".join(filter(None, (self.motion, self.second)))
        return "/".join((self.place, of, self.shape, str(self.power), self.response))

    @property
    def swings(self) -> bool:
        """A mass that moves in its body: it oscillates, or slides."""
        return self.motion in SWINGS

    @property
    def slides(self) -> bool:
        """A mass that dry friction alone holds on the floor."""
        return self.motion == "swing" and self.shape == SLIDING


#: Laws whose linear form is in the library or the file: a damper at the ball, the steering ratio,
#: a late steering, roll steer, a softer tyre. Friction at the ball and free play of the steering
#: are library effects too. An axle with play in its wheel bearings is softer at small slip, one
#: with worn bushes beyond some slip, one that steers itself after its slip late in slow turns. Air
#: on the trailer that is late, or that separates, is not the library's.
NONLINEAR_ONLY = (
    *(
        Law("hitch", "articulation_rate", nonlinear)
        for nonlinear in ("odd square", "cube", "dead zone", *SIDES, WAITING)
    ),
    *(Law("slip_car_front", "steer", nonlinear) for nonlinear in ("odd square", "cube")),
    *(
        Law("slip_car_front", "steer_rate", nonlinear)
        for nonlinear in ("saturating", "dead zone", "odd square", "cube")
    ),
    *(
        Law(axle, roll, nonlinear)
        for axle, roll in (
            ("slip_car_front", "roll_car"),
            ("slip_car_rear", "roll_car"),
            ("slip_trailer", "roll_trailer"),
        )
        for nonlinear in ("saturating", "dead zone", "odd square", "cube", *FRICTION)
    ),
    *(
        Law(slip, slip, nonlinear)
        for slip in SLIPS
        for nonlinear in ("saturating", "dead zone", *SIDES, UNEVEN)
    ),
    *(Law(slip, slip, response=response) for slip in SLIPS for response in (LAGGED, GROWING)),
    # tyres whose aligning moment has a limit; something that scrubs or drags over the road
    *(
        Law(place, slip, nonlinear)
        for place, slip in (
            ("moment_car", "slip_car_front"),
            ("moment_car", "slip_car_rear"),
            ("moment_trailer", "slip_trailer"),
        )
        for nonlinear in ("saturating", "dead zone", "cube", *SIDES)
    ),
    *(
        Law(place, THERE, nonlinear)
        for place in ANYWHERE
        for nonlinear in ("saturating", "dead zone", "odd square", *SIDES)
    ),
    # friction and dampers at the ball that work themselves in, or fade as they grow hot
    *(
        Law("hitch", "articulation_rate", shape, response=response)
        for shape in (SHAPES[0], "saturating")
        for response in BY_THE_WAY
    ),
    *(
        Law(place, DISTANCE, response=GROWING)
        for place in ("force_car", "force_trailer", "moment_car", "moment_trailer")
    ),
    *(Law(axle, DISTANCE, response=GROWING) for axle in SLIPS),
    *(
        Law(place, "sideslip_trailer", nonlinear, 2)
        for place in AIR
        for nonlinear in ("saturating", "dead zone", "odd square", "cube", *SIDES, LINE_AND_CUBE)
    ),
    *(
        Law(place, "sideslip_trailer", power=2, response=response)
        for place in AIR
        for response in (LAGGED, TRANSIENT)
    ),
)


#: Dampers beside the drawbar whose eyes or valves have play or give way.
STRUTS = tuple(Law("hitch", "articulation", s, response=TRANSIENT) for s in IN_SERIES)


def law_of(spec: str) -> Law:
    """The law of a string written by `Law.spec`."""
    try:
        place, of, shape, power, response = spec.partition("@")[0].split("/")
        motion, _, second = of.partition("+")
        found = Law(place, motion, shape, int(power), response, second)
    except ValueError:
        raise SwaywatchError(f"{spec!r} is no law (place/motion/shape/power/response)") from None
    known = motion in MOTIONS and place in PLACES and (not second or second in MOTIONS)
    known |= motion in SWINGS and place in BODIES
    known |= motion == "side_force" and place == "tyres"
    if not known or shape not in SHAPES or response not in RESPONSES:
        raise SwaywatchError(f"{spec!r}: no such place, motion, shape or response")
    return found


def effect_of_form(form: str) -> Effect:
    """The effect that a model block names: of what goes along the road, where phases are unknown.

    It has a place for the phase of each run that it was found in, and does nothing in others.
    """
    law, _, tail = form.partition("@")
    found = law_of(law)
    unknown = int(tail) if found.response == PERIODIC and tail else 0
    return effect_of(found, runs=tuple(f"?{i}" for i in range(unknown)))


Act = Callable[[PlantInput, Run, Values, Sequence[Window]], None]


def _comes(law: Law) -> Act:
    """What does not depend on the motion enters where unknown forces do."""

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        course = values["gain"] * share_by_the_way(law, run, values)
        course *= (run.speed / SPEED_M_S) ** law.power
        for slot, sign in SLOTS[law.place]:
            plant.add_series(slot, sign * course)

    return act


def bend_of(values: Values) -> float:
    """The number that a shape has beside its gain; 0 without one."""
    return next((values[name] for name in OF_A_SHAPE if name in values), 0.0)


def made_of(law: Law, run: Run, values: Values) -> dict[str, float]:
    """Motions in the plant that make the first variable of a law, with their weights."""
    if law.motion == THERE:
        body = ANYWHERE[law.place]
        per_rate = values["ahead_m"] / float(np.mean(run.speed))
        return {f"sideslip_{body}": 1.0, f"yaw_rate_{body}": per_rate}
    return MADE_OF.get(law.motion, {law.motion: 1.0})


def acts_at(place: str, values: Values) -> dict[str, float]:
    """Places in the plant at which a law acts, with their weights (of moments: levers, m)."""
    if place not in ANYWHERE:
        return {place: 1.0}
    body = ANYWHERE[place]
    return {f"force_{body}": 1.0, f"moment_{body}": values["ahead_m"]}


def _moves(law: Law) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        plant.scalar("law_gain", values["gain"])
        plant.scalar("law_shape", float(SHAPES.index(law.shape)))
        plant.scalar("law_bend", bend_of(values))
        plant.scalar("law_speed_power", float(law.power))
        rate, felt = law.motion == "steer_rate", law.motion in LAW_FELT
        plant.scalar("law_lag", RATE_S if rate else max(values.get("lag_s", 0.0), 0.0))
        passing = 2.0 * (law.response == TRANSIENT)
        plant.scalar("law_transient", 1.0 if rate else 3.0 if felt else passing)
        if law.response in BY_THE_WAY:
            plant.add_series("law", share_by_the_way(law, run, values) - 1.0)
        for motion, share in made_of(law, run, values).items():
            plant.scalar(f"law_of_{motion}", share)
        if law.second:
            plant.scalar(f"law_of_{law.second}", values["second_share"])
        for place, share in acts_at(law.place, values).items():
            plant.scalar(f"law_to_{place}", share)
        if "roll_frequency_rad_s" in values:
            body = law.motion.removeprefix("roll_")
            plant.scalar(f"steer_frequency_{body}", values["roll_frequency_rad_s"])
            plant.scalar(f"steer_damping_{body}", values["roll_damping"])

    return act


def _swings(body: str) -> Act:
    """The oscillating mass is a part of the mass of its body: the total stays as weighed."""

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del run, windows
        mass, place = values["mass_kg"], values["position_m"]
        whole = plant.body[BODY.index(f"{body}.mass")]
        rest = whole - mass
        # the centre of gravity of the rest is as far the other way as the masses say
        ahead = -mass * place / rest
        plant.scalar(f"mode_mass_{body}", mass)
        plant.scalar(f"mode_frequency_{body}", 2.0 * math.pi * values.get("frequency_hz", 0.0))
        plant.scalar(f"mode_damping_{body}", values.get("damping_ratio", 0.0))
        plant.scalar(f"mode_gap_{body}", abs(values.get("gap_m", 0.0)))
        plant.scalar(f"mode_drag_{body}", max(values.get("drag_per_m", 0.0), 0.0))
        plant.scalar(f"mode_friction_{body}", max(values.get("friction_m_s2", 0.0), 0.0))
        plant.scalar(f"mode_place_{body}", place - ahead)
        plant.scalar(f"sensor_ahead_{body}", -ahead)
        plant.body[BODY.index(f"{body}.mass")] = rest
        plant.body[BODY.index(f"{body}.yaw_inertia")] -= mass * place**2 + rest * ahead**2
        hitch = ahead if body == "car" else -ahead
        plant.body[BODY.index(f"{body}.front_axle_to_cog")] -= ahead
        plant.body[BODY.index(f"{body}.rear_axle_to_cog")] += ahead
        plant.body[BODY.index(f"{body}.hitch_to_cog")] += hitch
        sprung = plant.get(f"sprung_mass_{body}")
        if sprung > 0.0:
            plant.scalar(f"sprung_mass_{body}", sprung - mass)

    return act


def _turns(body: str) -> Act:
    """The oscillating inertia is a part of the yaw inertia of its body."""

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del run, windows
        inertia = values["inertia_kgm2"]
        plant.scalar(f"mode_mass_{body}", inertia / FAR_M**2)
        plant.scalar(f"mode_place_{body}", FAR_M)
        plant.scalar(f"mode_frequency_{body}", 2.0 * math.pi * values["frequency_hz"])
        plant.scalar(f"mode_damping_{body}", values["damping_ratio"])
        plant.body[BODY.index(f"{body}.yaw_inertia")] -= inertia

    return act


def _lever(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    for axle in ("car_front", "car_rear", "trailer"):
        plant.scalar(f"trail_{axle}", values["lever_m"])


def effect_of(
    law: Law, start_hz: float | None = None, *, sprung: bool = False, runs: tuple[str, ...] = ()
) -> Effect:
    """The law as an effect of the plant, fitted and judged like any other.

    Parameters
    ----------
    start_hz
        For an oscillating mass: the initial frequency of the fit.
    sprung
        Whether the vehicle rolls on springs; one without has a roll of its own for a law of it.
    runs
        Names of the runs, for what comes and goes along the road: each has a phase of its own. It
        does nothing in others.
    """
    return _effect(law, start_hz, sprung, runs)


@cache
def _effect(law: Law, start_hz: float | None, sprung: bool, runs: tuple[str, ...]) -> Effect:
    act: Act
    parameters: tuple[Parameter, ...]
    if law.swings:
        act, parameters, equation = _with_a_frequency(law, start_hz or 0.8)
    elif law.motion == "side_force":
        act = _lever
        parameters = (Parameter("lever_m", "m", 0.0, -0.15, 0.15, (0.03,), 0.005, 0.003),)
        equation = "M = -lever x side force, of each tyre"
    else:
        act = _comes(law) if law.motion == DISTANCE else _moves(law)
        parameters = _numbers(law)
        if law.response == PERIODIC:
            grip = law.motion != DISTANCE
            act = comes_and_goes(law.place, runs, grip=grip)
            parameters = (*parameters, *phases(runs))
        if law.motion in ROLLS and not sprung:
            parameters = (*parameters, *OWN_ROLL[law.motion])
        equation = formula(law)
    return Effect(
        id=ID,
        component=f"{law.place} of {' and '.join(filter(None, (law.motion, law.second)))}",
        kind="physics",
        equation=equation,
        source="identified from the recording",
        parameters=parameters,
        act=act,
        report=_with_limit if law.shape in LIMITED and not law.swings else dict,
        plausibility=0.0 if (law.place, law.motion) in KNOWN else UNHEARD_OF,
        decided_by="the same manoeuvre at another speed and another amplitude",
        extra={
            "form": law.spec + (f"@{start_hz:g}" if start_hz else f"@{len(runs)}" if runs else ""),
            "law": law,
            "start_hz": start_hz,
            "imitated_on_springs": True,
        }
        | ({"possible": _can_swing} if law.swings and not law.slides else {}),
    )


def _with_a_frequency(law: Law, at: float) -> tuple[Act, tuple[Parameter, ...], str]:
    """Act, parameters and equation of an oscillating mass, with its initial frequency."""
    swings = (
        Parameter("frequency_hz", "Hz", at, 0.15, 4.0, (at,), 0.03, 1e9),
        Parameter("damping_ratio", "1", 0.05, 0.0, 1.5, (0.05,), 0.02, 1e9),
    )
    if law.motion == "turn":
        size = Parameter("inertia_kgm2", "kg m2", 0.0, 0.0, 3000.0, (150.0,), 25.0, 5.0)
        equation = "I (q'' + 2 zeta omega q' + omega^2 q) = -I r'"
        return _turns(law.place), (size, *swings), equation
    mass = Parameter("mass_kg", "kg", 0.0, 0.0, 900.0, (60.0,), 10.0, 2.0)
    place = Parameter("position_m", "m", 0.0, -4.0, 4.0, (0.0,), 0.05, 1e9)
    if law.slides:
        rubs = Parameter("friction_m_s2", "m/s2", 1e3, 0.02, 20.0, (1.0, 0.4, 2.0), 0.05, 1e9)
        equation = "m q'' = -m a_y of its place - m friction sign(q')"
        return _swings(law.place), (mass, place, rubs), equation
    found: tuple[Parameter, ...] = (mass, *swings, place)
    held, drag = "q", ""
    if law.shape == "dead zone":
        found = (*found, Parameter("gap_m", "m", 0.01, 0.0, 0.3, (0.01,), 0.003, 1e9))
        held = "(q beyond +-gap)"
    if law.shape == "odd square":
        found = (*found, Parameter("drag_per_m", "1/m", 0.0, 0.0, 100.0, (3.0,), 0.3, 1e9))
        drag = " + drag |q'| q'"
    equation = f"m (q'' + 2 zeta omega q'{drag} + omega^2 {held}) = -m a_y of its place"
    return _swings(law.place), found, equation


def _with_limit(values: Values) -> dict[str, float]:
    """Values with the one at which the law saturates."""
    return dict(values) | {"limit": abs(values["gain"] * values["bend"])}


def _can_swing(values: Values) -> bool:
    """Overdamped is not oscillating: a load or a liquid passes its rest position."""
    return values["damping_ratio"] < MOST_DAMPED


#: As of the library's roll steer: roll is not recorded, and a rigid vehicle has none.
OWN_ROLL = {
    motion: (
        Parameter("roll_frequency_rad_s", "rad/s", hz, 4.0, 40.0, (hz,), 0.2, 1e9),
        Parameter("roll_damping", "1", ratio, 0.03, 1.5, (ratio,), 0.02, 1e9),
    )
    for motion, hz, ratio in (("roll_car", 13.0, 0.112), ("roll_trailer", 9.0, 0.3))
}


def _numbers(law: Law) -> tuple[Parameter, ...]:
    """Numbers of a law, scaled by its dimensions; the gain is the first one."""
    second = (_second_share(law),) if law.second else ()
    return (_gain(law), *_of_shape(law), *_of_way(law), *second, *_of_place_and_lag(law))


def _gain(law: Law) -> Parameter:
    """Gain of a law."""
    place, motion = PLACES[law.place], MOTIONS[law.motion]
    curve = {"cube": 3, "odd square": 2, "even square": 2}.get(law.shape, 1)
    start = place.level / motion.usual**curve
    unit = f"{place.unit} per {motion.unit}" + (f"^{curve}" if curve > 1 else "")
    unit = place.unit if law.motion == DISTANCE else unit
    if law.motion == law.place:  # the compliance of a wheel is at most its slip
        low, high, start, step, noticed = {
            GROWING: (-0.9, 1.0, -0.2, 0.05, 0.02),
            PERIODIC: (0.0, 0.95, 0.2, 0.05, 0.02),
        }.get(law.response, (-1.0, 0.0, -0.5, 0.1, 0.1))
        return Parameter("gain", unit, 0.0, low, high, (start,), step, noticed)
    high = 100.0 * start
    return Parameter("gain", unit, 0.0, -high, high, (start,), 0.2 * start, 0.02 * start)


def _of_shape(law: Law) -> list[Parameter]:
    """The number that a shape has."""
    motion = MOTIONS[law.motion]
    if law.shape == UNEVEN:
        return [Parameter("other_side", "1", 1.0, -2.0, 3.0, (0.5,), 0.1, 1e9)]
    if law.shape == LINE_AND_CUBE:
        most = 1.0 / motion.usual**2
        bounds = -50.0 * most, 50.0 * most, (-0.5 * most,)
        return [Parameter("per_square", f"1/({motion.unit})^2", 0.0, *bounds, 0.1 * most, 1e9)]
    if SHAPES.index(law.shape) not in BENDS:
        return []
    share = {"saturating": 0.5, LIMITED_RATE: 2.0}.get(law.shape, 0.3)
    bend, per_s = share * motion.usual, "/s" if law.shape == LIMITED_RATE else ""
    bounds = 0.02 * bend, 20.0 * bend, (bend,)
    return [Parameter("bend", motion.unit + per_s, 1e3, *bounds, 0.1 * bend, 1e9)]


def _of_way(law: Law) -> list[Parameter]:
    """How far, or through which angle, what grows or fades takes."""
    if law.response not in BY_THE_WAY:
        return []
    if rubs_at_hitch(law):
        return [Parameter("over_rad", "rad", 1e3, 0.02, 50.0, (0.5,), 0.05, 1e9)]
    return [Parameter("over_m", "m", 1e6, 20.0, 2e4, (250.0,), 30.0, 1e9)]


def _of_place_and_lag(law: Law) -> list[Parameter]:
    """A lever, where a force has a place of its own, and a lag."""
    found = []
    if law.place in ANYWHERE:
        found.append(Parameter("ahead_m", "m", 0.0, -5.0, 5.0, (2.5,), 0.1, 1e9))
    if law.motion in LAW_FELT:
        found.append(Parameter("lag_s", "s", 0.0, 0.02, 1.5, (0.06,), 0.01, 1e9))
    elif law.response == LAGGED:
        late = 0.4 if law.motion in SLIPS else 0.1  # a shorter one of a slip is a relaxation
        found.append(Parameter("lag_s", "s", 0.0, 0.0, 1.5, (late,), 0.01, 1e9))
    elif law.response == TRANSIENT:
        found.append(Parameter("lag_s", "s", 1e3, 0.02, 3.0, (0.3,), 0.03, 1e9))
    return found


def rubs_at_hitch(law: Law) -> bool:
    """Whether something at the hitch works itself in, or fades, with the angle worked through."""
    hitch = (law.place, law.motion) == ("hitch", "articulation_rate")
    return hitch and law.response in BY_THE_WAY


def _second_share(law: Law) -> Parameter:
    """Weight of the second motion of a law: in a test drive as much as the first, to begin with."""
    first, second = MOTIONS[law.motion], MOTIONS[law.second]
    usual = first.usual / second.usual
    unit = f"{first.unit} per {second.unit}"
    return Parameter("second_share", unit, 0.0, -20 * usual, 20 * usual, (usual,), 0.2 * usual, 1e9)


def share_by_the_way(law: Law, run: Run, values: Values) -> Array:
    """Share of a law that has come over some way, or that is left after it, shape (n,).

    What rubs at the hitch works itself in, or fades, with the angle that it has worked through.
    """
    if law.response not in BY_THE_WAY:
        return np.ones(run.time.size)
    return left(run, values) if law.response == FADING else 1.0 - left(run, values)


def swing_of(z: Array) -> Array:
    """How far something swings: what it was at the most, forgotten within a while, shape (n,)."""
    state = np.zeros_like(z)
    for i, size in enumerate(np.abs(z[1:])):
        beyond = size - state[i]
        within = SWING_SEEN_S if beyond > 0.0 else SWING_KEPT_S
        state[i + 1] = state[i] + beyond * -math.expm1(-1.0 / (RATE_HZ * within))
    return state


def dragged(z: Array, bend: float) -> Array:
    """Deflection of an element with dry friction that slides at `bend` (Dahl), shape (n,)."""
    state = np.zeros_like(z)
    for i, step in enumerate(np.diff(z)):
        kept = math.exp(-abs(step) / bend)  # exact while z goes one way
        state[i + 1] = kept * state[i] + math.copysign(bend * (1.0 - kept), step)
    return state


def hurried(z: Array, bend: float) -> Array:
    """What follows `z` no faster than `bend` a second, shape (n,)."""
    state = np.zeros_like(z)
    for i, target in enumerate(z[1:]):
        rate = np.clip((target - state[i]) / HURRY_S, -bend, bend)
        state[i + 1] = state[i] + rate / RATE_HZ
    return state


def _waited(z: Array, bend: float) -> Array:
    """What acts while something swings beyond `bend`, shape (n,)."""
    return 0.5 * z * (1.0 + np.tanh((swing_of(z) / bend - 1.0) / WAITING_SHARE))


_CURVES: dict[str, Callable[[Array, float], Array]] = {
    "straight": lambda z, _: z,
    "saturating": lambda z, bend: bend * np.tanh(z / bend),
    "dead zone": lambda z, bend: z - np.clip(z, -bend, bend),
    "cube": lambda z, _: z**3,
    "odd square": lambda z, _: z * np.abs(z),
    "even square": lambda z, _: z**2,
    "hysteretic": dragged,
    "rubbing": lambda z, _: np.abs(z) * np.sign(np.gradient(z)),
    "positive side": lambda z, _: np.maximum(z, 0.0),
    "negative side": lambda z, _: np.minimum(z, 0.0),
    UNEVEN: lambda z, other: np.maximum(z, 0.0) + other * np.minimum(z, 0.0),
    WAITING: _waited,
    LIMITED_RATE: hurried,
    LINE_AND_CUBE: lambda z, steeper: z * (1.0 + steeper * z**2),
}
assert set(_CURVES) == set(SHAPES)


def curve(shape: str, z: Array, bend: float) -> Array:
    """A shape, of gain one, over the course of its variable, shape (n,)."""
    signed = shape in (UNEVEN, LINE_AND_CUBE)
    return np.asarray(_CURVES[shape](z, bend if signed else max(bend, 1e-9)))


def formula(law: Law) -> str:
    """The law in symbols."""
    symbol = MOTIONS[law.motion].symbol
    if law.second:
        symbol = f"({symbol} + share x {MOTIONS[law.second].symbol})"
    nonlinear = {
        "straight": symbol,
        "saturating": f"bend tanh({symbol} / bend)",
        "dead zone": f"({symbol} beyond +-bend)",
        "cube": f"{symbol}^3",
        "odd square": f"{symbol} |{symbol}|",
        "even square": f"{symbol}^2",
        "hysteretic": f"z, dz/dt = d{symbol}/dt - |d{symbol}/dt| z / bend",
        "rubbing": f"|{symbol}| sign(d{symbol}/dt)",
        "positive side": f"max({symbol}, 0)",
        "negative side": f"min({symbol}, 0)",
        UNEVEN: f"{symbol}, on the negative side times the other",
        WAITING: f"({symbol} while it swings beyond +-bend)",
        LINE_AND_CUBE: f"({symbol} + per_square x {symbol}^3)",
        LIMITED_RATE: f"({symbol}, followed no faster than bend a second)",
    }[law.shape]
    left = {"N": "F", "Nm": "M", "rad": "angle"}[PLACES[law.place].unit]
    speed = {
        -1: f" / (v / {SPEED_M_S:g} m/s)",
        0: "",
        1: f" (v / {SPEED_M_S:g} m/s)",
        2: f" (v / {SPEED_M_S:g} m/s)^2",
    }[law.power]
    when = (_AT_HITCH if rubs_at_hitch(law) else _WHEN)[law.response]
    if law.motion == DISTANCE:
        return f"{left} = gain{speed}{when}"
    if law.motion in LAW_FELT:
        when = f"{_WHEN[LAGGED]}{when}"
    return f"{left} = gain x {nonlinear}{speed}{when}"


_WHEN = {
    INSTANT: "",
    LAGGED: " with a lag",
    TRANSIENT: ", without what lasts",
    GROWING: " x (1 - exp(-way / over))",
    FADING: " x exp(-way / over)",
    PERIODIC: " x sin(2 pi repetitions x way + phase)",
}
_AT_HITCH = {
    GROWING: " x (1 - 1 / (1 + angle worked / over))",
    FADING: " / (1 + angle worked / over)",
}


@cache
def grammar() -> tuple[Effect, ...]:
    """All linear laws, and oscillating masses with every initial frequency."""
    found = [
        effect_of(Law(place, motion, power=power))
        for place, motions in PAIRS.items()
        for motion, powers in motions.items()
        for power in powers
    ]
    found.append(effect_of(Law("tyres", "side_force")))
    found += [
        effect_of(Law(body, motion), hz)
        for body in BODIES
        for motion in SWINGS
        for row in FREQUENCIES_HZ
        for hz in row
    ]
    return tuple(found)


def of_two(law: Law) -> list[Law]:
    """The same law with a second variable: what a controller at the place can sense besides."""
    alone = (*ALONE, DISTANCE)
    if law.second or law.place not in PAIRS or law.motion in alone:
        return []
    others = [motion for motion in PAIRS[law.place] if motion not in (law.motion, *alone)]
    return [replace(law, second=motion) for motion in others]


def refined(law: Law) -> list[Law]:
    """The same law with another shape or power of the speed, or acting at other times.

    One of both is another one, or the law acts at once in any shape.
    """
    if law.motion == "swing" and law.shape == SHAPES[0]:
        return [Law(law.place, "swing", shape) for shape in ("dead zone", "odd square")]
    if law.swings or law.motion == "side_force" or law.response == PERIODIC:
        return []

    def near(other: Law) -> bool:
        alike = (other.shape, other.power) == (law.shape, law.power)
        return alike or other.response in (law.response, INSTANT)

    alone = replace(law, second="")
    pool = [other for other in _forms(law.place, law.motion) if other != alone and near(other)]
    return [replace(other, second=law.second) for other in pool]


@cache
def _forms(place: str, motion: str) -> tuple[Law, ...]:
    """All laws of a place and a motion."""
    if place not in PAIRS or motion not in PAIRS[place]:
        listed = [law for law in NONLINEAR_ONLY if (law.place, law.motion) == (place, motion)]
        later = [replace(law, response=GROWING) for law in listed if law.response == INSTANT]
        return tuple(dict.fromkeys((*listed, *later)))
    rubs = motion in DEFLECTIONS
    # dry friction at the hitch is a library effect
    closed = () if rubs and place != "hitch" else ("hysteretic",) if rubs else FRICTION
    single = motion in ALONE
    if single:
        closed = (*closed, WAITING, LIMITED_RATE)
    shapes = [shape for shape in SHAPES if shape not in closed]
    # the power of the speed of the linear law says little about a nonlinear one
    powers = PAIRS[place][motion]
    found = [
        Law(place, motion, s, p, r) for r in (INSTANT, GROWING) for s in shapes for p in powers
    ]
    if single:
        return tuple(found)
    free = [shape for shape in shapes if shape not in KEEPING]
    # a transient shape is that of a spring in series with a damper: its force makes the damper go
    late = [Law(place, motion, s, p, LAGGED) for s in free for p in powers]
    late += [Law(place, motion, s, p, TRANSIENT) for s in IN_SERIES for p in powers]
    return (*found, *late, *(Law(place, motion, power=p, response=FADING) for p in powers))


def plainer(law: Law) -> Law | None:
    """The law with fewer numbers that this one becomes where it does not need them, or None."""
    if law.second:
        return replace(law, second="")
    plain = replace(law, shape=SHAPES[0], response=INSTANT)
    lasting = law.slides or law.response in (TRANSIENT, PERIODIC, *BY_THE_WAY)
    if law == plain or law in NONLINEAR_ONLY or lasting:
        return None
    fewer = len(effect_of(plain).parameters) < len(effect_of(law).parameters)
    return plain if fewer else None


@cache
def all_laws() -> tuple[Law, ...]:
    """All laws in one variable, in every shape, linear ones with a lag too."""
    straight = [Law(p, m, power=w) for p, ms in PAIRS.items() for m, ws in ms.items() for w in ws]
    nonlinear = [law for one in straight for law in refined(one)]
    # two slopes, or a line with its cube, are looked for where one of both was found
    listed = (*straight, *nonlinear, *NONLINEAR_ONLY, *STRUTS)
    begun = (law for law in listed if law.shape not in (UNEVEN, LINE_AND_CUBE))
    return tuple(dict.fromkeys(begun))


assert set(PLACES) == {*LAW_TO, AXLES, *ANYWHERE}
