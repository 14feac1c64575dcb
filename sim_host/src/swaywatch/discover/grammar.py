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
    BALL,
    BODIES,
    BY_THE_WAY,
    CURVE,
    DEFLECTIONS,
    FADING,
    GROWING,
    HEADINGS,
    IN_SERIES,
    INSTANT,
    KEEPING,
    LAGGED,
    LOST_MOTION,
    MOMENT,
    MOTIONS,
    NOTCHED,
    OF_EACH_RUN,
    ONLY_REFINED,
    OSCILLATING,
    PERIODIC,
    PLACES,
    RATES,
    SHAPES,
    SIDES,
    SIZES,
    SLIDING,
    SLIPS,
    STEPPED,
    STOPS,
    SUDDEN,
    SWINGS,
    THERE,
    TRANSIENT,
    UNEVEN,
    Law,
)
from swaywatch.discover.way import DISTANCE, DRAG
from swaywatch.effects.effect import Effect
from swaywatch.plant.lanes import LAW_FELT

#: Motions that something at any place can sense, follow or give way to.
SENSED = (
    "articulation", "articulation_rate", "yaw_rate_car", "yaw_rate_trailer", "sideslip_car",
    "sideslip_trailer", "steer", "steer_rate", "roll_car", "roll_trailer",
    "lateral_acceleration_car", "lateral_acceleration_trailer", "hitch_force",
)  # fmt: skip
AIR = ("force_car", "force_trailer", "at_car", "at_trailer", "moment_car", "moment_trailer")
#: Powers of the speed that are tried, where others than none: air grows with the square of the
#: speed, with the speed where it answers a rate, what a controller asks of a body may do so or fall
#: with it.
POWERS: dict[tuple[str, str], tuple[int, ...]] = {
    **{(place, air): (2,) for place in AIR for air in ("sideslip_car", "sideslip_trailer")},
    **{(place, "articulation"): (0, 2) for place in (*AIR, "hitch", "slip_trailer")},
    **{(place, "articulation_rate"): (0, 1) for place in AIR},
    ("at_car", "articulation"): (2,),
    ("at_trailer", "articulation"): (2,),
    ("at_car", "articulation_rate"): (1,),
    ("at_trailer", "articulation_rate"): (1,),
    ("moment_car", "sideslip_car"): (0, 2),
    ("moment_car", "steer"): (0, 2),
    ("slip_car_rear", "steer"): (0, 2),
    ("slip_trailer", "steer"): (0, 2),
    ("moment_car", "yaw_rate_car"): (-1, 0, 1, 2),
    ("moment_trailer", "yaw_rate_trailer"): (-1, 0, 1, 2),
}
#: What a road has along it (grooves, a crown) holds an axle in its body's heading; wind comes from
#: one side.
BY_HEADING = (
    ("force_car", "heading"), ("force_trailer", "heading"), ("slip_trailer", "heading"),
    ("slip_car_front", "heading_car"), ("slip_car_rear", "heading_car"),
)  # fmt: skip
#: Places that are a part of another one with the same motion: what is ahead of a body's centre of
#: gravity acts there with air only; the slip of an axle covers the side-slip of its body.
COVERED = (
    *((place, motion) for place in ("at_car", "at_trailer") for motion in SENSED if motion not in (
        "sideslip_car", "sideslip_trailer", "articulation", "articulation_rate"
    )),
    ("slip_car_front", "sideslip_car"), ("slip_car_rear", "sideslip_car"),
    ("slip_trailer", "sideslip_trailer"), ("hitch", "sideslip_car"), ("hitch", "sideslip_trailer"),
)  # fmt: skip
#: Laws whose linear form is in the library or the file: a damper at the ball, the steering ratio, a
#: late steering, roll steer, a softer tyre, air on the trailer, mass and centre of gravity (a force
#: with a body's own yaw rate). Their other forms are none of these.
LINE_KNOWN = (
    ("hitch", "articulation_rate"),
    ("slip_car_front", "steer"),
    ("slip_car_front", "steer_rate"),
    ("slip_car_front", "roll_car"),
    ("slip_car_rear", "roll_car"),
    ("slip_trailer", "roll_trailer"),
    ("force_car", "yaw_rate_car"),
    ("force_trailer", "yaw_rate_trailer"),
    *((place, "sideslip_trailer") for place in ("force_trailer", "moment_trailer", "at_trailer")),
)
#: Pairs of place and motion, and the powers of the speed that are tried with each: every place with
#: every motion.
PAIRS: dict[tuple[str, str], tuple[int, ...]] = {
    (place, motion): POWERS.get((place, motion), (0,))
    for place in (
        "hitch", "force_car", "force_trailer", "at_car", "at_trailer", "moment_car",
        "moment_trailer", *SLIPS
    )
    for motion in (*SENSED, "heading", "heading_car")
    if (motion in SENSED and (place, motion) not in COVERED) or (place, motion) in BY_HEADING
}  # fmt: skip
#: How a mass swings, beside in proportion: in a gap, in one in which it slides on the floor,
#: against a drag, with friction as a part of what holds it, lashed to one side.
SWINGING_SHAPES = ("dead zone", LOST_MOTION, "odd square", "rubbing", UNEVEN)
#: Initial natural frequencies of an oscillating mass, Hz; the most promising one of each row is
#: fitted.
FREQUENCIES_HZ = ((0.35, 0.5, 0.65), (0.75, 0.85, 0.95, 1.1), (1.3, 1.6, 2.0, 2.6))
#: Laws of what is no motion of a body. An axle with play in its wheel bearings is softer at small
#: slip, one with worn bushes beyond some slip, one that steers itself after its slip late in slow
#: turns.
OTHERS = (
    *(
        Law(slip, slip, nonlinear)
        for slip in SLIPS
        for nonlinear in ("saturating", "dead zone", *SIDES, UNEVEN, SLIDING)
    ),
    *(
        Law(slip, slip, response=response)
        for slip in SLIPS
        for response in (LAGGED, GROWING, FADING, OSCILLATING)
    ),
    # tyres whose aligning moment has a limit, a disc that drags on its pads; what scrubs over the
    # road
    *(
        Law(place, slip, nonlinear)
        for place, slip in (
            ("moment_car", "slip_car_front"),
            ("moment_car", "slip_car_rear"),
            ("moment_trailer", "slip_trailer"),
        )
        for nonlinear in ("saturating", "dead zone", "cube", "even square", *SIDES, UNEVEN)
    ),
    *(
        Law(place, THERE, nonlinear)
        for place in ANYWHERE
        for nonlinear in ("saturating", "dead zone", "odd square", *SIDES)
    ),
    # friction and dampers at the ball that work themselves in, or fade as they grow hot
    *(
        Law("hitch", "articulation_rate", "saturating", response=response)
        for response in BY_THE_WAY
    ),
    *(
        Law(place, DISTANCE, response=GROWING)
        for place in ("force_car", "force_trailer", "moment_car", "moment_trailer")
    ),
    *(Law(axle, DISTANCE, response=GROWING) for axle in SLIPS),
)
#: A ball that has play in its coupling, slips in its seat with friction, or gives way to one side
#: more than to the other.
IN_COUPLING = tuple(Law(BALL, "hitch_force", shape) for shape in (LOST_MOTION, SLIDING, UNEVEN))
#: Dampers beside the drawbar whose eyes or valves have play or give way.
STRUTS = tuple(Law("hitch", "articulation", s, response=TRANSIENT) for s in IN_SERIES)


def _straight() -> list[Law]:
    """The linear law of each pair and power of the speed."""
    return [Law(*pair, power=power) for pair, powers in PAIRS.items() for power in powers]


@cache
def grammar() -> tuple[Effect, ...]:
    """All linear laws, and oscillating masses with every initial frequency."""
    found = [effect_of(law) for law in _straight() if (law.place, law.motion) not in LINE_KNOWN]
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
    if law.second or law.motion in alone:
        return []
    return [
        replace(law, second=motion)
        for place, motion in PAIRS
        if place == law.place and motion not in (law.motion, *alone)
    ]


@cache
def breaking() -> tuple[Law, ...]:
    """What may begin on the way: lines, those of the library too, friction, a force that stays."""
    lines = [Law(*pair, power=power) for pair, powers in PAIRS.items() for power in powers]
    lines += [Law(slip, slip) for slip in SLIPS]
    lines += [Law("hitch", "articulation_rate", "saturating")]
    lines += [law for law in OTHERS if law.motion == DISTANCE]
    begun = (replace(law, response=SUDDEN) for law in lines if law.place not in ANYWHERE)
    return tuple(dict.fromkeys(begun))


@cache
def of_bodies() -> tuple[Law, ...]:
    """What may act on a body in places of the road only: lines, those of the library too."""
    return tuple(law for law in _straight() if law.place.startswith(("force_", "moment_")))


@cache
def products() -> tuple[Law, ...]:
    """Laws that the size of another motion multiplies, or its sign: a force presses what rubs.

    Tyres hold less as a body leans on them; pads hold more one way of turning than the other.
    """
    lines = [law for law in _straight() if law.motion not in HEADINGS and not law.power]
    friction = Law("hitch", "articulation_rate", "saturating")
    own = [Law(slip, slip) for slip in SLIPS]
    one_way = [replace(friction, by=friction.motion, side=side) for side in SIDES]
    found = (
        replace(law, by=motion, side=side)
        for law in (friction, *lines, *own)
        for motion in SENSED
        for side in ("", *SIDES)
        if motion not in (law.motion, "steer_rate") and (not side or motion not in LAW_FELT)
    )
    return (*one_way, *found)


def refined(law: Law) -> list[Law]:
    """The same law with another shape or power of the speed, or acting at other times.

    One of both is another one, or the law acts at once in any shape.
    """
    if law.motion == "swing" and law.shape == SHAPES[0]:
        if law.response == FADING:
            return []
        shapes = [Law(law.place, "swing", shape) for shape in SWINGING_SHAPES]
        return [*shapes, replace(law, response=FADING)]
    if (not law.has_gain and law.place != BALL) or law.response == PERIODIC:
        return []

    if law.response == SUDDEN:
        others = (one for one in _forms(law.place, law.motion) if _alike(one, law))
        return [replace(one, response=SUDDEN) for one in others]

    def near(other: Law) -> bool:
        alike = (other.shape, other.power) == (law.shape, law.power)
        return alike or other.response in (law.response, INSTANT)

    home = MOMENT if law.place == DRAG else law.place
    alone = replace(law, place=home, second="", by="", side="")
    pool = [other for other in _forms(home, law.motion) if other != alone and near(other)]
    pool += repeating(alone)
    found = [
        replace(other, place=law.place, second=law.second, by=law.by, side=law.side)
        for other in pool
    ]
    if law.times and not law.side:
        found += [replace(law, side=size) for size in SIZES]
    return [*found, replace(law, place=DRAG)] if law.place == MOMENT else found


def _alike(other: Law, law: Law) -> bool:
    """Another shape that acts at once, with the same power of the speed."""
    return other.response == INSTANT and other.power == law.power and other.shape != law.shape


def repeating(law: Law) -> list[Law]:
    """Forms that come again and again: only a curve says how wide they are. At once too."""
    if law.shape != CURVE:
        return []
    responses = dict.fromkeys((law.response, INSTANT))
    return [replace(law, shape=s, response=r) for s in (STEPPED, NOTCHED) for r in responses]


def elsewhere(law: Law) -> list[Law]:
    """The same form at each other place, and there with each other motion.

    What acts between two bodies is hardly told from what acts on one of them, before the form is
    right; so is what goes with one motion from what goes with another.
    """
    if (law.place, law.motion) not in PAIRS:
        return []
    others = [replace(law, place=place) for place in PLACES]
    if not (law.second or law.by):
        others += [replace(law, motion=motion) for motion in MOTIONS]
    found = []
    for other in others:
        powers = PAIRS.get((other.place, other.motion), ())
        if powers and other != law:
            power = law.power if law.power in powers else powers[0]
            found.append(replace(other, power=power))
    return [law for law in found if _tried(replace(law, second="", by="", side=""))]


def _tried(law: Law) -> bool:
    """Whether a law of one variable is one of those that are tried."""
    pair = (law.place, law.motion)
    line = law == Law(*pair, power=law.power)
    return pair not in LINE_KNOWN if line else law in _forms(*pair)


@cache
def _forms(place: str, motion: str) -> tuple[Law, ...]:
    """All laws of a place and a motion."""
    if (place, motion) not in PAIRS:
        if place == BALL:
            return IN_COUPLING
        listed = [law for law in OTHERS if (law.place, law.motion) == (place, motion)]
        later = [replace(law, response=GROWING) for law in listed if law.response == INSTANT]
        return tuple(dict.fromkeys((*listed, *later)))
    # dry friction at the hitch is a library effect
    closed = (SLIDING,) if place == "hitch" else ()
    closed = closed if motion in DEFLECTIONS else (*closed, "rubbing")
    closed = (*closed, SLIDING) if motion in RATES else closed
    # any form is one: looked for where no form fits (`free_curves`); two only beside one
    closed = (*closed, CURVE, STEPPED, NOTCHED)
    single = motion in ALONE
    if single and motion not in LAW_FELT:
        closed = (*closed, *KEEPING)
    if (place, motion) in LINE_KNOWN:
        closed = (*closed, UNEVEN)
    shapes = [shape for shape in SHAPES if shape not in closed]
    # the power of the speed of the linear law says little about a nonlinear one
    powers = PAIRS[place, motion]
    found = [
        Law(place, motion, s, p, r)
        for r in (INSTANT, GROWING)
        for s in shapes
        for p in powers
        if (s, r) != (SHAPES[0], INSTANT) or (place, motion) not in LINE_KNOWN
    ]
    if single:
        return tuple(found)
    free = [shape for shape in shapes if shape not in KEEPING]
    # a transient shape is that of a spring in series with a damper: its force makes the damper go
    late = [Law(place, motion, s, p, LAGGED) for s in free for p in powers]
    late += [Law(place, motion, s, p, TRANSIENT) for s in IN_SERIES for p in powers]
    late += [Law(place, motion, power=p, response=OSCILLATING) for p in powers]
    return (*found, *late, *(Law(place, motion, power=p, response=FADING) for p in powers))


def plainer(law: Law) -> Law | None:
    """The law with fewer numbers that this one becomes where it does not need them, or None."""
    if law.side in SIZES:
        return replace(law, side="")
    known = (law.place, law.motion) in LINE_KNOWN or law.place == law.motion
    if law.by and known:
        return None  # without the other motion it is the library's
    if law.second or law.by:
        return replace(law, second="", by="", side="")
    return _next_to(law) or _line_of(law)


def _next_to(law: Law) -> Law | None:
    """The law in the form beside its own that has a number less."""
    if law.response == OSCILLATING:
        return replace(law, response=LAGGED)
    if law.shape == CURVE and law.response == LAGGED:
        return replace(law, response=INSTANT)
    fewer = []
    if law.response in (*BY_THE_WAY, SUDDEN):
        fewer.append(replace(law, response=INSTANT))
    if law.place in ANYWHERE:  # without a lever
        fewer.append(replace(law, place=f"force_{ANYWHERE[law.place]}"))
    for other in fewer:
        if (other.place, other.motion) in PAIRS and _tried(other):
            return other
    if law.shape in STOPS:
        return replace(law, shape=SIDES[STOPS.index(law.shape)])
    return None


def _line_of(law: Law) -> Law | None:
    """The law as a line that acts at once."""
    plain = replace(law, shape=SHAPES[0], response=INSTANT)
    lasting = law.slides or law.response in (TRANSIENT, *OF_EACH_RUN, *BY_THE_WAY)
    lasting = lasting and not (law.swings and law.response == FADING)
    known = (law.place, law.motion) in LINE_KNOWN or law.place == BALL
    if law == plain or known or law in OTHERS or lasting:
        return None
    fewer = len(effect_of(plain).parameters) < len(effect_of(law).parameters)
    return plain if fewer else None


@cache
def curves() -> tuple[Law, ...]:
    """A free curve of each pair and power of the speed."""
    return tuple(replace(law, shape=CURVE) for law in _straight() if law.place not in ANYWHERE)


@cache
def without_a_line() -> tuple[Law, ...]:
    """Laws whose linear form is not tried; they are not found from it."""
    alone = (law for law in all_laws() if (law.place, law.motion) in LINE_KNOWN)
    return tuple(dict.fromkeys((*OTHERS, *alone)))


@cache
def all_laws() -> tuple[Law, ...]:
    """All laws in one variable, in every shape, linear ones with a lag too."""
    straight = _straight()
    nonlinear = [law for one in straight for law in refined(one)]
    straight = [law for law in straight if (law.place, law.motion) not in LINE_KNOWN]
    listed = (*straight, *nonlinear, *OTHERS, *STRUTS)
    begun = (law for law in listed if law.shape not in ONLY_REFINED and law.place != DRAG)
    return tuple(dict.fromkeys(begun))
