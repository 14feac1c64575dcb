"""Compiled part of the rigid-body plant that nobody lists, from the sixteenth set on.

`multibody_more` asks here for all that is numbered from `FIRST_NEWER` on.
"""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from swaywatch.models.multibody_tables import (
    G_CAR_LEVER,
    G_FULL,
    G_HITCH_DOF,
    G_MORE,
    G_MORE_AT,
    G_MORE_HZ,
    G_MORE_SIZE,
    O_CAR_VX,
    O_CAR_VY,
    O_RATE1,
    O_ROLL1,
    O_SPEED,
    O_STEER,
    O_YAW1,
    O_YAW2,
    W_SIDE,
    W_STEERED,
    Z_MORE,
)

#: The file that this one is compiled with, see `multibody_kernel.MADE_OF`.
MADE_OF = {"multibody_tables": "7e6a397047d3"}
FIRST_NEWER = 159
# Physics beyond what any library of effects lists, numbered as `MORE` of multibody_vehicle.py.
(
    AGED_TYRES, CAMERA_REAR, BISTABLE_WAKE, OPEN_CRACK, CONTROLLED_JOINT, BINDING_RACK,
    TAILGATE_CRATE, CASTER_LOCK, PASSING_LORRY, WALLOWING_TAIL, LANE_DEPARTURE, BRAKING_DRIVER,
) = range(FIRST_NEWER, FIRST_NEWER + 12)  # fmt: skip
SHUTTER_S, SEES_S = 0.012, 0.002  # for how long a camera looks, and its lag meanwhile
WAKE_M, WAKE_BEHIND_M = 4.0, 2.0  # way of a change of the wake; where it pulls
HELD, TURNS_OVER = 2.0, 0.533  # a wake's hold of its side; the other side at 1 of its threshold
CLOSED_N_M, CRACK_S = 2e6, 0.004  # a crack that is pressed shut; damping over stiffness
JOINT_S = 0.1  # lag of the valve of a joint's damper
STEER_RATE_S = 0.02  # lag of a steering rate that is taken from an angle
SLIDES_M_S, WALL_DAMPING, ROOM_M = 0.01, 0.3, 0.05  # of a crate, which has this room either way
PIN_S, LATCH = 0.03, 1.0 / 3.0  # lag of a pin; share of the slip that lifts it where it drops back
LORRY_S, LORRY_REACH_M = 0.4, 3.0  # half a lorry's time past a point; half a trailer's length
TAIL_DAMPING = 0.15
LANE_S = 2.5  # in which a lane goes where the driver means to
STARTLES_RAD_S = 0.02


@njit(cache=True)
def newer_steer(g: Any, z: Any, wheel: int, slip: float, out: Any) -> float:
    """Steering of a wheel's axle, rad; `slip` is without it."""
    kind, size, at, angle = g[G_MORE], g[G_MORE_SIZE], g[G_MORE_AT], 0.0
    if wheel >= 4:
        if kind == AGED_TYRES:
            part = (slip / at) ** 2
            angle = size * part / (1.0 + part) * slip
        elif kind == CASTER_LOCK:
            angle = size * z[Z_MORE] * slip
    elif wheel >= 2:
        if kind in (CAMERA_REAR, WALLOWING_TAIL):
            angle = size * z[Z_MORE]
    elif kind == BINDING_RACK:
        rate = (out[O_STEER] - z[Z_MORE]) / STEER_RATE_S
        angle = -size * abs(slip) * math.tanh(rate / at)
    elif kind == LANE_DEPARTURE:
        beside = z[Z_MORE + 1]
        angle = -size * math.copysign(max(abs(beside) - at, 0.0), beside)
    return float(angle)


@njit(cache=True)
def newer_moments(g: Any, z: Any, view: Any, trailer: int, out: Any) -> None:
    """Moments, and the force of what gives way at the ball."""
    kind, size, hitch = g[G_MORE], g[G_MORE_SIZE], int(g[G_HITCH_DOF])
    if kind == CONTROLLED_JOINT:
        view.qfrc[hitch] -= size * z[Z_MORE] * view.qvel[hitch]
    elif kind == PASSING_LORRY:
        past = _past(g, z)
        view.xfrc[trailer, 5] += LORRY_REACH_M * math.tanh(past) * _push_of_lorry(g, past)
    elif kind == OPEN_CRACK and g[G_FULL] == 0.0:  # a planar trailer's joint after the ball
        side = hitch + 1
        opens = size * view.qpos[side] > 0.0
        stiff = abs(size) if opens else CLOSED_N_M
        view.qfrc[side] -= stiff * (view.qpos[side] + CRACK_S * view.qvel[side])


@njit(cache=True)
def newer_lag(g: Any, z: Any, zdot: Any, out: Any) -> None:
    """States of what is late, sampled, or swings; of the time, and of the place in a lane."""
    kind, at, omega = g[G_MORE], g[G_MORE_AT], g[G_MORE_HZ]
    if kind == CAMERA_REAR:
        zdot[Z_MORE + 1] = 1.0
        if z[Z_MORE + 1] % at < SHUTTER_S:
            zdot[Z_MORE] = (out[O_YAW2] - out[O_YAW1] - z[Z_MORE]) / SEES_S
    elif kind == CONTROLLED_JOINT:
        zdot[Z_MORE] = (abs(out[O_RATE1]) - z[Z_MORE]) / JOINT_S
    elif kind == BINDING_RACK:
        zdot[Z_MORE] = (out[O_STEER] - z[Z_MORE]) / STEER_RATE_S
    elif kind == PASSING_LORRY:
        zdot[Z_MORE] = 1.0
    elif kind == WALLOWING_TAIL:
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = omega * omega * (out[O_ROLL1] - z[Z_MORE])
        zdot[Z_MORE + 1] -= 2.0 * TAIL_DAMPING * omega * z[Z_MORE + 1]
    elif kind == LANE_DEPARTURE:
        course = math.atan2(out[O_CAR_VY], out[O_CAR_VX]) - z[Z_MORE]
        zdot[Z_MORE] = course / LANE_S
        zdot[Z_MORE + 1] = out[O_SPEED] * math.sin(course) - z[Z_MORE + 1] / LANE_S
    elif kind == BRAKING_DRIVER:
        startles = max(abs(out[O_RATE1]) - STARTLES_RAD_S, 0.0)
        zdot[Z_MORE] = 2.0 * (startles - z[Z_MORE]) / at
        zdot[Z_MORE + 1] = 2.0 * (z[Z_MORE] - z[Z_MORE + 1]) / at


@njit(cache=True)
def newer_of_slip(g: Any, z: Any, zdot: Any, middle: float) -> None:
    """State of a pin that the slip of the trailer's axles lifts, and that drops back later."""
    if abs(middle) > g[G_MORE_AT]:
        zdot[Z_MORE] = (1.0 - z[Z_MORE]) / PIN_S
    elif abs(middle) < LATCH * g[G_MORE_AT]:
        zdot[Z_MORE] = -z[Z_MORE] / PIN_S


@njit(cache=True)
def newer_side(g: Any, z: Any, zdot: Any, beta: float, pressure: float, out: Any) -> float:
    """Side force on the car or the trailer, N; as `multibody_more.more_side`."""
    kind, size, side = g[G_MORE], g[G_MORE_SIZE], 0.0
    if kind == TAILGATE_CRATE:
        side = size * pull_of_crate(g, z)
    elif kind == PASSING_LORRY:
        side = _push_of_lorry(g, _past(g, z))
    elif kind == BISTABLE_WAKE:
        goes = math.tanh(HELD * z[Z_MORE] + TURNS_OVER * beta / g[G_MORE_AT])
        zdot[Z_MORE] = (goes - z[Z_MORE]) * out[O_SPEED] / WAKE_M
        side = -size * pressure * z[Z_MORE]
    return float(side)


@njit(cache=True)
def pull_of_crate(g: Any, z: Any) -> float:
    """Acceleration with which floor and walls of a boot hold a crate, m/s2."""
    omega, place, rate = g[G_MORE_HZ], z[Z_MORE], z[Z_MORE + 1]
    pull = g[G_MORE_AT] * math.tanh(rate / SLIDES_M_S)
    pressed = abs(place) - ROOM_M
    if pressed > 0.0:
        pull += omega * omega * math.copysign(pressed, place) + 2.0 * WALL_DAMPING * omega * rate
    return float(pull)


@njit(cache=True)
def _past(g: Any, z: Any) -> float:
    """How far the lorry that comes next, or goes, is past the trailer's COG, 1."""
    return float((z[Z_MORE] % g[G_MORE_AT] - 0.5 * g[G_MORE_AT]) / LORRY_S)


@njit(cache=True)
def _push_of_lorry(g: Any, past: float) -> float:
    """Side force of the air about a lorry: it pushes as it comes, and pulls as it goes, N."""
    return float(g[G_MORE_SIZE] * past * math.exp(0.5 - 0.5 * past * past))


@njit(cache=True)
def newer_drag(g: Any, z: Any, wheel: Any) -> float:
    """Drag of the front wheel whose brake alone holds as the driver brakes, N."""
    if g[G_MORE] == BRAKING_DRIVER and wheel[W_STEERED] > 0.0:
        return float(max(g[G_MORE_SIZE] * wheel[W_SIDE], 0.0) * z[Z_MORE + 1])
    return 0.0


@njit(cache=True)
def newer_ahead(g: Any) -> float:
    """Place of a side force ahead of its body's COG, m; 0 for what is not numbered here."""
    if g[G_MORE] == TAILGATE_CRATE:
        return float(-g[G_CAR_LEVER])
    if g[G_MORE] == BISTABLE_WAKE:
        return -WAKE_BEHIND_M
    return 0.0
