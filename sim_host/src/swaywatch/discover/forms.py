"""Forms of a law: its curve over the course of its variable, and the law in symbols."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from swaywatch.discover.law import (
    BY_THE_WAY,
    CURVE,
    FADING,
    FALLING,
    FIFTHS,
    GROWING,
    INSTANT,
    LAGGED,
    LATE,
    LEVELS,
    LIMITED_RATE,
    LINE_AND_CUBE,
    LOST_MOTION,
    MOTIONS,
    NOTCHED,
    OSCILLATING,
    PERIODIC,
    PLACES,
    SHAPES,
    SIDES,
    STEPPED,
    STOPS,
    SUDDEN,
    SWITCHED,
    TRANSIENT,
    UNEVEN,
    WAITING,
    Law,
    of_a_motion,
    one_way,
)
from swaywatch.discover.way import DISTANCE, SPEED_M_S, left
from swaywatch.effects.effect import Values
from swaywatch.effects.runs import RATE_HZ, Run
from swaywatch.plant.lanes import LAW_FELT

Array = NDArray[np.float64]

SWING_SEEN_S, SWING_KEPT_S, WAITING_SHARE = 0.05, 1.0, 0.1  # as in plant_lanes.c
HURRY_S, PLAYED_S, STEEP = 0.05, 0.02, 8.0  # as in plant_lanes.c
SWITCHED_SHARE, STEP_SHARE = 0.1, 0.03  # as in plant_lanes.c


def rubs_at_hitch(law: Law) -> bool:
    """Whether something at the hitch works itself in, or fades, with the angle worked through."""
    hitch = (law.place, law.motion) == ("hitch", "articulation_rate")
    return hitch and law.response in BY_THE_WAY


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


def played(z: Array, bend: float) -> Array:
    """What follows `z` once that is farther away than the play `bend`, shape (n,)."""
    state = np.zeros_like(z)
    share = -math.expm1(-1.0 / (RATE_HZ * PLAYED_S))
    for i, target in enumerate(0.5 * (z[1:] + z[:-1])):
        behind = target - state[i]
        state[i + 1] = state[i] + share * (behind - np.clip(behind, -bend, bend))
    return state


def _waited(z: Array, bend: float) -> Array:
    """What acts while something swings beyond `bend`, shape (n,)."""
    return 0.5 * z * (1.0 + np.tanh((swing_of(z) / bend - 1.0) / WAITING_SHARE))


def _switched(z: Array, bend: float) -> Array:
    """Nothing within `bend`, as much as that beyond it, shape (n,)."""
    on = 0.5 * bend * (1.0 + np.tanh((np.abs(z) / bend - 1.0) / SWITCHED_SHARE))
    return np.asarray(np.where(z < 0.0, -on, on))


def _stepped(z: Array, bend: float) -> Array:
    """Steps as high as they are wide, the first half a step from nothing, shape (n,)."""
    steps = z / bend - 0.5
    within = steps - np.round(steps)
    rise = np.tanh(within / STEP_SHARE) / math.tanh(0.5 / STEP_SHARE)
    return np.asarray(bend * (np.round(steps) + 0.5 + 0.5 * rise))


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
    STOPS[0]: lambda z, bend: np.maximum(z - bend, 0.0),
    STOPS[1]: lambda z, bend: np.minimum(z + bend, 0.0),
    LINE_AND_CUBE: lambda z, steeper: z * (1.0 + steeper * z**2),
    LOST_MOTION: played,
    FALLING: lambda z, bend: bend * np.tanh(STEEP * z / bend) / (1.0 + (z / bend) ** 2),
    SWITCHED: _switched,
    STEPPED: _stepped,
    NOTCHED: lambda z, bend: bend * np.sin(z / bend),
}
assert {*_CURVES, CURVE} == set(SHAPES)


def in_pieces(z: Array, values: Values) -> Array:
    """A free curve over the course of its variable, shape (n,)."""
    found = values["gain"] * z + values["of_size"] * np.abs(z)
    for fifth in FIFTHS:
        at = fifth * values["bend"] / len(FIFTHS)
        found = found + values[f"right_{fifth}"] * np.maximum(z - at, 0.0)
        found = found + values[f"left_{fifth}"] * np.minimum(z + at, 0.0)
    return np.asarray(found)


def amount(shape: str, z: Array, values: Values, bend: float) -> Array:
    """A law at once over the course of its variable, with its gain, shape (n,)."""
    return in_pieces(z, values) if shape == CURVE else values["gain"] * curve(shape, z, bend)


def sized(law: Law, y: Array, values: Values) -> Array:
    """The size of a motion that multiplies a law, shape (n,)."""
    size, bend = np.abs(y), values.get("by_bend", 1.0)
    if law.side == LEVELS:
        size = size**2 / (size**2 + bend**2)
    return np.asarray(np.maximum(size - bend, 0.0) if law.side == LATE else size)


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
        STOPS[0]: f"max({symbol} - bend, 0)",
        STOPS[1]: f"min({symbol} + bend, 0)",
        UNEVEN: f"{symbol}, on the negative side times the other",
        WAITING: f"({symbol} while it swings beyond +-bend)",
        LINE_AND_CUBE: f"({symbol} + per_square x {symbol}^3)",
        LOST_MOTION: f"({symbol}, followed with a play of +-bend)",
        FALLING: f"bend tanh({STEEP:g} {symbol} / bend) / (1 + ({symbol} / bend)^2)",
        SWITCHED: f"bend sign({symbol}) beyond +-bend",
        STEPPED: f"{symbol} in steps of bend",
        NOTCHED: f"bend sin({symbol} / bend)",
        CURVE: f"{symbol} in straight pieces, with other slopes beyond each fifth of +-bend",
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
    when = _ONE_WAY[law.shape] if one_way(law) else when
    if law.motion == DISTANCE:
        return f"{left} = gain{speed}{when}"
    if law.response == PERIODIC:
        when = when if one_way(law) or not of_a_motion(law) else _RAISED
        return f"{left} = gain x {symbol}{speed}{when}"
    if law.motion in (*LAW_FELT, "steer_rate"):
        when = f"{_WHEN[LAGGED]}{when}"
    size = _of_size(law) if law.by else ""
    return f"{left} = gain x {nonlinear}{size}{speed}{when}"


def _of_size(law: Law) -> str:
    """What the motion that multiplies it, or on whose side it acts, adds to a formula."""
    symbol = MOTIONS[law.by].symbol
    return {
        "": f" x |{symbol}|",
        SIDES[0]: f" where {symbol} > 0",
        SIDES[1]: f" where {symbol} < 0",
        LEVELS: f" x {symbol}^2 / ({symbol}^2 + by_bend^2)",
        LATE: f" x max(|{symbol}| - by_bend, 0)",
    }[law.side]


_WHEN = {
    INSTANT: "",
    LAGGED: " with a lag",
    TRANSIENT: ", without what lasts",
    GROWING: " x (1 - exp(-way / over))",
    FADING: " x exp(-way / over)",
    OSCILLATING: ", as an oscillator of its own follows it",
    SUDDEN: " from a moment of each run on",
    PERIODIC: " x sin(2 pi repetitions x way + phase)",
}
_RAISED = " x (1 + sin(2 pi repetitions x way + phase)) / 2"
_ONE_WAY = {
    SIDES[0]: " x max(sin(2 pi repetitions x way + phase), 0)",
    STOPS[0]: " x max(sin(2 pi repetitions x way + phase) - above, 0) / (1 - above)",
}
_AT_HITCH = {
    GROWING: " x (1 - 1 / (1 + angle worked / over))",
    FADING: " / (1 + angle worked / over)",
}
