"""The laws that are tried.

Effects of the library are excluded, and so is everything that is equivalent to a value of the
vehicle file.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from swaywatch.discover.effect import effect_of
from swaywatch.discover.law import (
    ALONE,
    ANYWHERE,
    BODIES,
    BY_THE_WAY,
    DEFLECTIONS,
    FADING,
    FRICTION,
    GROWING,
    IN_SERIES,
    INSTANT,
    KEEPING,
    LAGGED,
    LIMITED_RATE,
    LINE_AND_CUBE,
    PERIODIC,
    SHAPES,
    SIDES,
    SLIDING,
    SLIPS,
    SWINGS,
    THERE,
    TRANSIENT,
    UNEVEN,
    WAITING,
    Law,
)
from swaywatch.discover.way import DISTANCE
from swaywatch.effects.effect import Effect

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
    *(Law("slip_car_front", "steer", nonlinear) for nonlinear in ("odd square", "cube", SLIDING)),
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
        for nonlinear in ("saturating", "dead zone", *SIDES, UNEVEN, SLIDING)
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
