"""A law: a place, a variable and a form, with their words and dimensions.

A law has no name, only a place where it acts, one motion variable on which it depends (or two) and
the gain between them; or it is a mass that oscillates; or a lever of the tyre side force.
"""

from __future__ import annotations

from dataclasses import dataclass

from swaywatch.discover.way import AXLES, DISTANCE, DRAG
from swaywatch.errors import SwaywatchError
from swaywatch.plant.lanes import LAW_FELT, LAW_OF, LAW_TO

#: In the plant's numbering. Hysteretic: dry friction behind an elastic part, after Dahl. Rubbing:
#: friction as large as the deflection, against its rate (structural damping, after Reid).
SHAPES = (
    "straight", "saturating", "dead zone", "cube", "odd square", "even square", "hysteretic",
    "rubbing", "positive side", "negative side", "waiting", "uneven", "limited rate",
    "line and cube", "lost motion", "falling", "positive stop", "negative stop", "switched",
    "free curve", "stepped", "notched",
)  # fmt: skip
#: Of another slope on the other side: what one side's tyres make, or two unlike springs.
UNEVEN = "uneven"
#: What a controller that waits for a swing to grow makes: nothing up to a swing, all beyond it.
WAITING = "waiting"
#: What grows stiffer or softer, or drives a small motion and resists a large one.
LINE_AND_CUBE = "line and cube"
#: What an actuator makes that can go no faster.
LIMITED_RATE = "limited rate"
#: What a link with play makes, and dry friction that falls as what it brakes goes faster.
LOST_MOTION, FALLING = "lost motion", "falling"
#: What is off or on: brakes that a sensor applies.
SWITCHED = "switched"
#: What a motor makes that moves in steps, and dents that something snaps into.
STEPPED, NOTCHED = "stepped", "notched"
#: What no other form is: straight pieces through nothing, with the numbers of `PIECES`.
CURVE = "free curve"
#: Slope at nothing, what is added to it on the right and taken from it on the left, and what the
#: slopes change by beyond each fifth of the bend, on either side.
FIFTHS = (1, 2, 3, 4, 5)
PIECES = ("gain", "of_size", *(f"{side}_{n}" for side in ("right", "left") for n in FIFTHS))
#: What acts to one side only: a rope, a chain, a valve, a stop.
SIDES = ("positive side", "negative side")
#: What the size of a motion that multiplies a law may do: level off, or count beyond a bend only.
SIZES = LEVELS, LATE = "levels off", "beyond"
#: In a law's string.
_SIGN = {"": "", SIDES[0]: ">0", SIDES[1]: "<0", LEVELS: "~", LATE: "^"}
#: The same with slack: only once that is beyond it.
STOPS = ("positive stop", "negative stop")
#: Shapes that are looked for only where a form near them was found, with its values to begin with.
ONLY_REFINED = (
    UNEVEN,
    LINE_AND_CUBE,
    LOST_MOTION,
    FALLING,
    *STOPS,
    SWITCHED,
    CURVE,
    STEPPED,
    NOTCHED,
)
SLIDING = "hysteretic"
FRICTION = (SLIDING, "rubbing")  # these follow a deflection whose rate is a state too
ROLLS = ("roll_car", "roll_trailer")
DEFLECTIONS = ("articulation", *ROLLS)
RATES = ("articulation_rate", "yaw_rate_car", "yaw_rate_trailer")
IN_SERIES = (SHAPES[0], "saturating", "dead zone")  # shapes of a spring before a damper
KEEPING = (*FRICTION, WAITING, LIMITED_RATE, LOST_MOTION)  # shapes that keep the one state of a law
LIMITED = ("saturating", "hysteretic")  # shapes that level off at gain times bend
#: When a law acts: at once, behind a lag, only while its variable changes (a washout: what has
#: lasted longer than the lag is forgotten), or the more the farther the recording has gone, until
#: it does so wholly; or the less; or again and again along the road; or behind an oscillator of its
#: own, which overshoots; or from a moment of each run on, as what has broken does.
RESPONSES = INSTANT, LAGGED, TRANSIENT, GROWING, FADING, PERIODIC, OSCILLATING, SUDDEN = (
    "instant", "lagged", "transient", "growing", "fading", "periodic", "oscillating", "sudden",
)  # fmt: skip
BY_THE_WAY = (GROWING, FADING)
OF_EACH_RUN = (PERIODIC, SUDDEN)  # with a number for each run


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
#: Where the ball is across the trailer: a displacement, no force.
BALL = "ball"
#: Places with a lever of their own, and the bodies that they are on.
ANYWHERE = {"at_car": "car", "at_trailer": "trailer"}
MOMENT = "moment_trailer"
PLACES = {
    p.slot: p
    for p in (
        Place("hitch", "moment at the hitch on the car, its opposite on the trailer", "Nm", 300.0),
        Place(BALL, "place of the ball across its coupling", "m", 0.002),
        Place("force_car", "side force on the car", "N", 200.0),
        Place("force_trailer", "side force on the trailer", "N", 200.0),
        Place("at_car", "side force at a place of the car", "N", 200.0),
        Place("at_trailer", "side force at a place of the trailer", "N", 200.0),
        Place("moment_car", "yaw moment on the car", "Nm", 300.0),
        Place(MOMENT, "yaw moment on the trailer", "Nm", 300.0),
        Place(DRAG, "yaw moment on the trailer by the drag of wheels on one side", "Nm", 300.0),
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
HEADINGS = ("heading", "heading_car")
ALONE = (*HEADINGS, "steer_rate", *LAW_FELT)  # these take the state that a lag has
SLIPS = ("slip_car_front", "slip_car_rear", "slip_trailer")
BODIES = ("car", "trailer")
SWINGS = ("swing", "turn")


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
    by
        Another motion whose size multiplies it (friction that a force presses); empty: none.
    side
        One of `SIDES`: that motion does not multiply it, but it acts on this side of it only (pads
        that hold while the drawbar is turned one way). One of `SIZES`: it multiplies by what grows
        from nothing to one (`LEVELS`), or by what is beyond some size. Empty: it multiplies.
    """

    place: str
    motion: str
    shape: str = SHAPES[0]
    power: int = 0
    response: str = INSTANT
    second: str = ""
    by: str = ""
    side: str = ""

    @property
    def spec(self) -> str:
        """The law as one string, as stored in a model block."""
        of = "+".join(filter(None, (self.motion, self.second)))
        of += f"*{self.by}{_SIGN[self.side]}" * bool(self.by)
        return "/".join((self.place, of, self.shape, str(self.power), self.response))

    @property
    def times(self) -> str:
        """The motion whose size multiplies it; empty: none."""
        return "" if self.side in (*SIDES, LEVELS) else self.by

    @property
    def swings(self) -> bool:
        """A mass that moves in its body: it oscillates, or slides."""
        return self.motion in SWINGS

    @property
    def has_gain(self) -> bool:
        """It is a gain times what it depends on; other laws are made of other numbers."""
        return not self.swings and self.motion != "side_force" and self.place != BALL

    @property
    def slides(self) -> bool:
        """A mass that dry friction alone holds on the floor."""
        return self.motion == "swing" and self.shape == SLIDING


def one_way(law: Law) -> bool:
    """Whether it comes and goes along the road in one direction only, in short pulses or not."""
    return law.response == PERIODIC and law.shape in (SIDES[0], STOPS[0])


def of_a_motion(law: Law) -> bool:
    """Whether what acts in places of the road only goes with a motion: no force, no grip."""
    return law.response == PERIODIC and law.motion not in (DISTANCE, law.place)


def law_of(spec: str) -> Law:
    """The law of a string written by `Law.spec`."""
    try:
        place, of, shape, power, response = spec.partition("@")[0].split("/")
        of, _, by = of.partition("*")
        side = next((side for side, sign in _SIGN.items() if sign and by.endswith(sign)), "")
        by = by.removesuffix(_SIGN[side])
        motion, _, second = of.partition("+")
        found = Law(place, motion, shape, int(power), response, second, by, side)
    except ValueError:
        raise SwaywatchError(f"{spec!r} is no law (place/motion/shape/power/response)") from None
    known = motion in MOTIONS and place in PLACES
    known &= (not second or second in MOTIONS) and (not by or by in (*LAW_OF, *LAW_FELT))
    known |= motion in SWINGS and place in BODIES
    known |= motion == "side_force" and place == "tyres"
    if not known or shape not in SHAPES or response not in RESPONSES:
        raise SwaywatchError(f"{spec!r}: no such place, motion, shape or response")
    return found


assert set(PLACES) == {*LAW_TO, AXLES, BALL, DRAG, *ANYWHERE}
