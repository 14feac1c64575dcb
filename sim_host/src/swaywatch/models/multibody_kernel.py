"""Compiled part of the rigid-body plant: forces on the bodies, and the integration in time.

MuJoCo computes the bodies' motion from the forces; its C functions are called by address from
code compiled with numba, so that a run does not return to Python at each step. The state is
(qpos, qvel) of MuJoCo and `z`, states of tyres, roll, driver and cargo. Integration is the
classical Runge-Kutta method of fourth order (at 2 ms the error of the damping ratio is < 1e-5).

Columns of the tables are named in :mod:`swaywatch.models.multibody_tables`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import njit, types
from numba.extending import intrinsic

from swaywatch.models.multibody_more import (
    BALL_RATTLE,
    BINDING_BALL,
    BOW_WAVE,
    CAR_AIR,
    CASTER_AXLE,
    CASTER_FLUTTER,
    COCKED_OVERRUN,
    CORNER_BEHIND_M,
    CORNER_RIGHT_M,
    CORNER_STEADY,
    CREEPING_CLAMP,
    ELASTIC_DRAWBAR,
    GAP_PUMP,
    HYDRO_BUSH,
    LOOSE_HANDS,
    LOOSE_SUBFRAME,
    LOOSE_U_BOLTS,
    MORE_DAMPING,
    RACKED_FRAME,
    REAR_RACK,
    ROOF_LOAD,
    ROOF_TENT,
    SHIMMY,
    SLIPPING_NECK,
    SLOW_RAD_S,
    STANDING_WATER,
    SUBFRAME_RUBBER,
    TOWBAR_TWIST,
    TURNING_LOAD,
    TWO_TANKS,
    TYRE_WARMING,
    UNLOCKED_SLEW,
    WORKING_FRAME,
    acts_ahead,
    baffled,
    more_drag,
    more_lag,
    more_moments,
    more_of_pull,
    more_of_slip,
    more_side,
    more_steer,
    pull_behind,
    pull_of_rack,
    slips_in_seat,
    stretch,
)
from swaywatch.models.multibody_newer import (
    BRAKING_DRIVER,
    CASTER_LOCK,
    OPEN_CRACK,
    TAILGATE_CRATE,
)
from swaywatch.models.multibody_tables import (
    AIR_DENSITY,
    CAR,
    G_AIR_SIDE,
    G_AIR_YAW,
    G_BALL,
    G_CAR_HEIGHT,
    G_CAR_LEVER,
    G_CAR_MASS,
    G_CAR_ROLL_GAIN,
    G_CAR_ROLL_OMEGA,
    G_CAR_ROLL_ZETA,
    G_COMPLIANCE,
    G_DRAG_CAR,
    G_DRAG_TRAILER,
    G_FRICTION,
    G_FULL,
    G_HARMONIC_AXLE,
    G_HITCH_DAMPING,
    G_HITCH_DOF,
    G_HITCH_FRICTION,
    G_HITCH_SPRING,
    G_LAW,
    G_LOAD_DEGRESSION,
    G_MORE,
    G_MORE_AT,
    G_MORE_HZ,
    G_MORE_SIZE,
    G_PLAY,
    G_PLAY_LAW,
    G_RADIUS,
    G_RATIO,
    G_REAR_X,
    G_SHAPE,
    G_SLOSH_MASS,
    G_SLOSH_OMEGA,
    G_SLOSH_X,
    G_SLOSH_ZETA,
    G_TRAILER_HEIGHT,
    G_TRAILER_LEVER,
    G_TRAILER_MASS,
    G_YAW_CONTROL,
    GRAVITY_M_S2,
    INTEGRAL_GAIN,
    LOST_M_S2,
    O_CAR_VX,
    O_CAR_VY,
    O_DAMPER,
    O_FORCE_X,
    O_FORCE_Y,
    O_FORCE_Z,
    O_FY,
    O_FZ,
    O_HARMONIC,
    O_MOMENTUM_X,
    O_RATE1,
    O_RATE2,
    O_REAR_VX,
    O_REAR_VY,
    O_ROLL1,
    O_ROLL2,
    O_SIZE,
    O_SLIP,
    O_SPEED,
    O_STEER,
    O_TRAILER_VX,
    O_TRAILER_VY,
    O_TRAVEL,
    O_YAW1,
    O_YAW2,
    SIDE_AREA,
    SPEED,
    SPEED_GAIN,
    TRAILER_FULL,
    TRAILER_PLANAR,
    TRAVEL,
    U_ACCELERATION,
    U_BANK,
    U_DELAY,
    U_FADE,
    U_FRICTION,
    U_GUST_CAR,
    U_GUST_TRAILER,
    U_HARMONIC,
    U_SPEED,
    U_STEER,
    U_STIFFNESS,
    W_AXLE,
    W_BAR,
    W_BODY,
    W_DAMPER,
    W_DAMPER_KIND,
    W_DEGRESSION,
    W_DOF,
    W_DRAG,
    W_FADE,
    W_KNEE,
    W_LOAD,
    W_LOST,
    W_LOST_FACTOR,
    W_RATIO,
    W_RELAXATION,
    W_ROLL_STEER,
    W_SIDE,
    W_SPRING,
    W_STEERED,
    W_STIFFNESS,
    W_TRANSFER,
    W_TYRE_DAMPER,
    W_TYRE_SPRING,
    W_UNSPRUNG,
    W_X,
    W_Y,
    W_Z,
    Z_MEAN,
    Z_MORE,
    Z_ROLL,
    Z_SIZE,
    Z_SLIP,
    Z_SLOSH,
    Z_SPEED,
)

#: Contents (SHA-1, first twelve digits) of the files that this one is compiled with. Numba keeps
#: compiled code until the file of a function changes, whatever else it is made of: a change of
#: those has to change this file too (tests/host/test_multibody.py says what to write).
MADE_OF = {
    "multibody_tables": "7e6a397047d3",
    "multibody_newer": "7805f9138981",
    "multibody_more": "8e654867ef92",
}


class View(NamedTuple):
    """Arrays inside MuJoCo's own memory, and the masses of the bodies."""

    xpos: Any
    xmat: Any
    xipos: Any
    cvel: Any
    com: Any
    xfrc: Any
    qfrc: Any
    qpos: Any
    qvel: Any
    qacc: Any
    mass: Any


class Calls(NamedTuple):
    """Addresses: model, data, and the C functions that the kernel calls."""

    model: int
    data: int
    position: int
    velocity: int
    actuation: int
    acceleration: int
    constraint: int
    integrate: int


def _call_two(context: Any, function: Any, a: Any, b: Any) -> Any:
    """Call the C function ``void f(void *, void *)`` at the address `function`."""
    signature = types.void(types.int64, types.int64, types.int64)

    def generate(codegen: Any, builder: Any, _signature: Any, args: Any) -> Any:
        word = ir.IntType(64)
        kind = ir.FunctionType(ir.VoidType(), [word, word])
        builder.call(builder.inttoptr(args[0], kind.as_pointer()), args[1:])
        return codegen.get_dummy_value()

    return signature, generate


def _call_four(context: Any, function: Any, a: Any, b: Any, c: Any, h: Any) -> Any:
    """Call ``void f(const void *, double *, const double *, double)`` at `function`."""
    signature = types.void(types.int64, types.int64, types.int64, types.int64, types.float64)

    def generate(codegen: Any, builder: Any, _signature: Any, args: Any) -> Any:
        word = ir.IntType(64)
        kind = ir.FunctionType(ir.VoidType(), [word, word, word, ir.DoubleType()])
        builder.call(builder.inttoptr(args[0], kind.as_pointer()), args[1:])
        return codegen.get_dummy_value()

    return signature, generate


_call2: Any = intrinsic(_call_two)
_call_integrate: Any = intrinsic(_call_four)


@njit(cache=True)
def damper_force(wheel: Any, speed: float, lost: bool) -> float:
    """Force of a damper against compression, N (Table 6-1).

    Parameters
    ----------
    wheel : row of the wheel table.
    speed : of compression, m/s; negative is rebound.
    lost : the stroke is still within the lost travel.
    """
    kind = wheel[W_DAMPER_KIND]
    if kind == 0.0:
        return float(wheel[W_DAMPER] * speed)
    ratio = wheel[W_RATIO]
    slope = wheel[W_DAMPER] * 2.0 / (1.0 + ratio)
    if speed < 0.0:
        slope *= ratio
    size = abs(speed)
    force = slope * size
    if kind >= 2.0 and size > wheel[W_KNEE]:
        force = slope * (wheel[W_KNEE] + wheel[W_DEGRESSION] * (size - wheel[W_KNEE]))
    if lost and ((kind == 3.0 and speed > 0.0) or kind == 4.0):
        force *= wheel[W_LOST_FACTOR]
    return float(math.copysign(force, speed))


@njit(cache=True)
def tyre_force(law: float, shape: float, stiffness: float, limit: float, slip: float) -> float:
    """Lateral force of one tyre against its slip, N.

    `stiffness` N/rad at this load, `limit` peak force N, `slip` rad; laws as in
    :class:`swaywatch.models.multibody_vehicle.Physics`.
    """
    if law == 0.0 or limit <= 0.0:
        return float(-stiffness * slip) if law == 0.0 else 0.0
    x = stiffness * math.tan(slip) / limit
    if law == 1.0:
        return float(-limit * math.sin(shape * math.atan(x / shape)))
    size = abs(x)
    if size >= 3.0:
        return float(-math.copysign(limit, x))
    return float(-limit * x * (1.0 - size / 3.0 + size * size / 27.0))


@njit(cache=True)
def _point(view: Any, body: int, x: float, y: float, z: float, out: Any) -> None:
    """Position and velocity (world) of a point fixed in a body, into `out` of 6."""
    m, p = view.xmat, view.xpos
    out[0] = p[body, 0] + m[body, 0] * x + m[body, 1] * y + m[body, 2] * z
    out[1] = p[body, 1] + m[body, 3] * x + m[body, 4] * y + m[body, 5] * z
    out[2] = p[body, 2] + m[body, 6] * x + m[body, 7] * y + m[body, 8] * z
    _velocity(view, body, out)


@njit(cache=True)
def _velocity(view: Any, body: int, out: Any) -> None:
    """Fill in the velocity at the position out[0:3] of a body; MuJoCo's reference is the COG."""
    rx, ry, rz = out[0] - view.com[1, 0], out[1] - view.com[1, 1], out[2] - view.com[1, 2]
    w = view.cvel
    out[3] = w[body, 3] + w[body, 1] * rz - w[body, 2] * ry
    out[4] = w[body, 4] + w[body, 2] * rx - w[body, 0] * rz
    out[5] = w[body, 5] + w[body, 0] * ry - w[body, 1] * rx


@njit(cache=True)
def _push(view: Any, body: int, at: Any, fx: float, fy: float, fz: float) -> None:
    """Add a world force at the point `at` to a body."""
    c, f = view.xipos, view.xfrc
    rx, ry, rz = at[0] - c[body, 0], at[1] - c[body, 1], at[2] - c[body, 2]
    f[body, 0] += fx
    f[body, 1] += fy
    f[body, 2] += fz
    f[body, 3] += ry * fz - rz * fy
    f[body, 4] += rz * fx - rx * fz
    f[body, 5] += rx * fy - ry * fx


@njit(cache=True)
def _wheel_force(g: Any, wheel: Any, u: Any, load: float, slip: float) -> float:
    """Lateral force of the tyre of one wheel at its load and (transient) slip angle, N."""
    ratio = load / wheel[W_LOAD]
    stiff = wheel[W_STIFFNESS] * u[U_STIFFNESS + int(wheel[W_AXLE])] * ratio
    stiff *= 1.0 - g[G_LOAD_DEGRESSION] * (ratio - 1.0)
    return float(
        tyre_force(g[G_LAW], g[G_SHAPE], stiff, g[G_FRICTION] * u[U_FRICTION] * load, slip)
    )


@njit(cache=True)
def _steer(g: Any, wheels: Any, u: Any, z: Any, work: Any, load: Any, play: float) -> float:
    """Road wheel angle behind play and compliance (Eq. 5.3), rad.

    `work` holds the direction in which each wheel moves, against its body. Force and angle
    depend on each other; the step is scaled so that a linear tyre is solved at once.
    """
    half = 0.5 * g[G_PLAY]
    angle = min(max(play, u[U_STEER] - half), u[U_STEER] + half) / g[G_RATIO]
    if g[G_PLAY_LAW] == 1.0:
        soft = 0.5 * (work[0, TRAVEL] + work[1, TRAVEL])
        angle = min(max(soft, (u[U_STEER] - half) / g[G_RATIO]), (u[U_STEER] + half) / g[G_RATIO])
    if g[G_COMPLIANCE] <= 0.0:
        return float(angle)
    steer = angle
    lagged = wheels[0, W_RELAXATION] > 0.0
    gain = 1.0
    if not lagged:
        gain /= 1.0 + (wheels[0, W_STIFFNESS] + wheels[1, W_STIFFNESS]) / g[G_COMPLIANCE]
    for _ in range(6):
        total = 0.0
        for i in range(2):
            slip = z[Z_SLIP + i] if lagged else work[i, TRAVEL] - steer
            total += _wheel_force(g, wheels[i], u, load[i], slip)
        steer += gain * (angle - total / g[G_COMPLIANCE] - steer)
    return float(steer)


@njit(cache=True)
def _suspension(g: Any, wheels: Any, u: Any, view: Any, lost: Any, out: Any) -> None:
    """Springs, anti-roll bars and dampers onto the slide joints (compression is positive)."""
    for i in range(8):
        dof = int(wheels[i, W_DOF])
        other = int(wheels[i + 1 - 2 * (i % 2), W_DOF])
        travel, rate = view.qpos[dof + 1], view.qvel[dof]
        damping = damper_force(wheels[i], rate, lost[i] > 0.5)
        damping *= 1.0 + (wheels[i, W_FADE] - 1.0) * u[U_FADE]
        force = (
            wheels[i, W_LOAD] - wheels[i, W_UNSPRUNG] * GRAVITY_M_S2 + wheels[i, W_SPRING] * travel
        )
        force += wheels[i, W_BAR] * (travel - view.qpos[other + 1]) + damping
        if int(wheels[i, W_AXLE]) == int(g[G_HARMONIC_AXLE]):
            force += out[O_HARMONIC] * (0.5 + 0.5 * _side(wheels[i], out))
        view.qfrc[dof] -= force
        out[O_TRAVEL + i] = travel
        out[O_DAMPER + i] = damping


@njit(cache=True)
def _side(wheel: Any, out: Any) -> float:
    """+1 for the wheel that carries the harmonic load, -1 for the other (section 6.2)."""
    return float(-wheel[W_SIDE]) if out[O_RATE1] >= 0.0 else float(wheel[W_SIDE])


@njit(cache=True)
def _loads(g: Any, wheels: Any, view: Any, z: Any, load: Any, work: Any, out: Any) -> None:
    """Wheel loads: of the tyre's spring, or of the quasi-static balance of roll."""
    for i in range(8):
        w = wheels[i]
        if g[G_FULL] == 1.0:
            at = work[i]
            _point(view, int(w[W_BODY]), 0.0, 0.0, 0.0, at)
            spring = w[W_TYRE_SPRING] * (g[G_RADIUS] - at[2]) - w[W_TYRE_DAMPER] * at[5]
            load[i] = max(w[W_LOAD] + spring, 0.0)
            continue
        body = i // 4
        lateral = z[Z_ROLL + 2 * body] / g[G_CAR_ROLL_GAIN + 3 * body]
        load[i] = w[W_LOAD] - w[W_SIDE] * w[W_TRANSFER] * lateral
        if int(w[W_AXLE]) == int(g[G_HARMONIC_AXLE]):
            load[i] += out[O_HARMONIC] * (0.5 + 0.5 * _side(w, out))
        load[i] = max(load[i], 0.0)


@njit(cache=True)
def _tyres(
    g: Any, wheels: Any, u: Any, z: Any, zdot: Any, view: Any, play: float, drive: float,
    work: Any, out: Any,
) -> None:  # fmt: skip
    """Loads, slip and lateral force of every wheel, pushed onto its body."""
    load = out[O_FZ : O_FZ + 8]
    _loads(g, wheels, view, z, load, work, out)
    for i in range(8):
        w, at = wheels[i], work[i]
        body = int(w[W_BODY])
        _point(view, body, w[W_X], w[W_Y], w[W_Z], at)
        at[2] = 0.0
        _velocity(view, body, at)
        yaw = out[O_YAW1] if i < 4 else out[O_YAW2]
        c, s = math.cos(yaw), math.sin(yaw)
        at[SPEED] = max(c * at[3] + s * at[4], 1.0)
        at[TRAVEL] = math.atan2(c * at[4] - s * at[3], at[SPEED])
    out[O_STEER] = _steer(g, wheels, u, z, work, load, play)
    if g[G_MORE] in (
        CASTER_AXLE, TYRE_WARMING, LOOSE_U_BOLTS, CASTER_FLUTTER, CREEPING_CLAMP, CASTER_LOCK
    ):  # fmt: skip
        middle = 0.25 * (work[4, TRAVEL] + work[5, TRAVEL] + work[6, TRAVEL] + work[7, TRAVEL])
        more_of_slip(g, z, zdot, middle)
    if g[G_MORE] in (HYDRO_BUSH, SHIMMY, LOOSE_HANDS, LOOSE_SUBFRAME):
        middle = 0.5 * (work[0, TRAVEL] + work[1, TRAVEL]) - out[O_STEER]
        more_of_slip(g, z, zdot, middle)
    if g[G_MORE] == SUBFRAME_RUBBER:
        more_of_slip(g, z, zdot, 0.5 * (work[2, TRAVEL] + work[3, TRAVEL]))
    for i in range(8):
        w = wheels[i]
        roll = out[O_ROLL1] if i < 4 else out[O_ROLL2]
        steer = w[W_STEERED] * out[O_STEER] + w[W_ROLL_STEER] * roll
        slip = work[i, TRAVEL] - steer
        steer += more_steer(g, z, view.qvel[int(g[G_HITCH_DOF])], i, w[W_X], slip, out)
        slip = work[i, TRAVEL] - steer
        out[O_SLIP + i] = slip
        if w[W_RELAXATION] > 0.0:
            zdot[Z_SLIP + i] = work[i, SPEED] / w[W_RELAXATION] * (slip - z[Z_SLIP + i])
            slip = z[Z_SLIP + i]
        force = _wheel_force(g, w, u, load[i], slip)
        out[O_FY + i] = force
        along = 0.5 * drive * w[W_STEERED] - w[W_DRAG]
        if i >= 4 or g[G_MORE] in (STANDING_WATER, BRAKING_DRIVER):
            along -= more_drag(g, z, w, out)
        yaw = steer + (out[O_YAW1] if i < 4 else out[O_YAW2])
        c, s = math.cos(yaw), math.sin(yaw)
        fx, fy = c * along - s * force, s * along + c * force
        up = load[i] if g[G_FULL] == 1.0 else 0.0
        _push(view, int(w[W_BODY]), work[i], fx, fy, up)
        if i >= 4:
            out[O_FORCE_X] += fx
            out[O_FORCE_Y] += fy
            out[O_FORCE_Z] += up


@njit(cache=True)
def _cargo(g: Any, z: Any, view: Any, trailer: int, at: Any, out: Any) -> float:
    """Pull of what moves in the trailer across it, N, and push it; `at` is scratch."""
    c, s, omega = math.cos(out[O_YAW2]), math.sin(out[O_YAW2]), g[G_SLOSH_OMEGA]
    up = (g[G_TRAILER_HEIGHT] - g[G_BALL]) * g[G_FULL]
    pull = omega * omega * stretch(g, z) + 2 * g[G_SLOSH_ZETA] * omega * z[Z_SLOSH + 1]
    pull = g[G_SLOSH_MASS] * (pull + baffled(g, z))
    behind = 0.0
    if g[G_MORE] == TWO_TANKS:
        pull *= 0.5
        behind = 0.5 * g[G_SLOSH_MASS] * pull_behind(g, z)
        _point(view, trailer, -g[G_TRAILER_LEVER] - g[G_SLOSH_X], 0.0, up, at)
        _push(view, trailer, at, -s * behind, c * behind, 0.0)
    _point(view, trailer, -g[G_TRAILER_LEVER] + g[G_SLOSH_X], 0.0, up, at)
    _push(view, trailer, at, -s * pull, c * pull, 0.0)
    return float(pull + behind)


@njit(cache=True)
def _drag_corner(g: Any, view: Any, trailer: int, at: Any, out: Any) -> None:
    """Drag of a corner steady on the road; `at` is scratch."""
    c, s = math.cos(out[O_YAW2]), math.sin(out[O_YAW2])
    _point(view, trailer, -g[G_TRAILER_LEVER] - CORNER_BEHIND_M, -CORNER_RIGHT_M, 0.0, at)
    drag = g[G_MORE_SIZE] * max(out[O_ROLL2] - g[G_MORE_AT], 0.0)
    _push(view, trailer, at, -c * drag, -s * drag, 0.0)
    out[O_FORCE_X] -= c * drag
    out[O_FORCE_Y] -= s * drag


@njit(cache=True)
def _bodies(
    g: Any, u: Any, z: Any, zdot: Any, view: Any, trailer: int, work: Any, out: Any
) -> None:
    """Air, gusts, cross-fall, cargo, yaw control and what nobody lists."""
    full = g[G_FULL]
    lever, up = g[G_TRAILER_LEVER], (g[G_TRAILER_HEIGHT] - g[G_BALL]) * full
    c1, s1, c2, s2 = (
        math.cos(out[O_YAW1]), math.sin(out[O_YAW1]), math.cos(out[O_YAW2]), math.sin(out[O_YAW2])
    )  # fmt: skip
    cog1, cog2, at = work[8], work[9], work[10]
    _point(view, CAR, 0.0, 0.0, g[G_CAR_HEIGHT] * full, cog1)
    _point(view, trailer, -lever, 0.0, up, cog2)
    v1, v2 = c1 * cog1[3] + s1 * cog1[4], c2 * cog2[3] + s2 * cog2[4]
    beta = math.atan2(c2 * cog2[4] - s2 * cog2[3], v2)
    pressure = 0.5 * AIR_DENSITY * SIDE_AREA * v2 * v2
    drag1, drag2 = (
        0.5 * AIR_DENSITY * g[G_DRAG_CAR] * v1 * v1, 0.5 * AIR_DENSITY * g[G_DRAG_TRAILER] * v2 * v2
    )  # fmt: skip
    slope = -GRAVITY_M_S2 * math.sin(u[U_BANK])
    side1 = u[U_GUST_CAR] + g[G_CAR_MASS] * slope
    side2 = u[U_GUST_TRAILER] + (g[G_TRAILER_MASS] - g[G_SLOSH_MASS]) * slope
    side2 -= g[G_AIR_SIDE] * pressure * beta
    _push(view, CAR, cog1, -drag1 * c1 - side1 * s1, -drag1 * s1 + side1 * c1, 0.0)
    _push(view, trailer, cog2, -drag2 * c2 - side2 * s2, -drag2 * s2 + side2 * c2, 0.0)
    view.xfrc[trailer, 5] -= g[G_AIR_YAW] * pressure * beta
    view.xfrc[CAR, 5] -= g[G_YAW_CONTROL] * out[O_RATE1]
    if g[G_SLOSH_MASS] > 0.0:
        side2 += _cargo(g, z, view, trailer, at, out)
    out[O_FORCE_X] += -drag2 * c2 - side2 * s2
    out[O_FORCE_Y] += -drag2 * s2 + side2 * c2
    if g[G_MORE] == 0.0:
        return
    more_moments(g, z, view, trailer, out)
    more_lag(g, z, zdot, view.qvel[int(g[G_HITCH_DOF])], out)
    if g[G_MORE] == CORNER_STEADY:
        _drag_corner(g, view, trailer, at, out)
        return
    if g[G_MORE] in (
        CAR_AIR, ROOF_LOAD, BOW_WAVE, REAR_RACK, ROOF_TENT, GAP_PUMP, TAILGATE_CRATE
    ):  # fmt: skip
        beta1 = math.atan2(c1 * cog1[4] - s1 * cog1[3], v1)
        side1 = more_side(g, z, zdot, beta1, 0.5 * AIR_DENSITY * v1 * v1, out)
        _push(view, CAR, cog1, -s1 * side1, c1 * side1, 0.0)
        view.xfrc[CAR, 5] += acts_ahead(g) * side1
        return
    side2 = more_side(g, z, zdot, beta, 0.5 * AIR_DENSITY * v2 * v2, out)
    _push(view, trailer, cog2, -s2 * side2, c2 * side2, 0.0)
    view.xfrc[trailer, 5] += acts_ahead(g) * side2
    out[O_FORCE_X] -= s2 * side2
    out[O_FORCE_Y] += c2 * side2


@njit(cache=True)
def _momentum(view: Any, trailer: int, v: Any, out: Any) -> None:
    """Momentum of the trailer and its wheels, less what moves inside it."""
    for body in range(trailer, view.mass.shape[0]):
        for i in range(3):
            v[i] = view.xipos[body, i]
        _velocity(view, body, v)
        for i in range(3):
            out[O_MOMENTUM_X + i] += view.mass[body] * v[3 + i]


@njit(cache=True)
def _observe(g: Any, z: Any, view: Any, trailer: int, v: Any, out: Any) -> None:
    """Attitudes, rates and velocities that the forces need and the run keeps."""
    m1, m2 = view.xmat[CAR], view.xmat[trailer]
    out[:] = 0.0
    out[O_YAW1], out[O_YAW2] = math.atan2(m1[3], m1[0]), math.atan2(m2[3], m2[0])
    for i in range(3):  # body z axis
        out[O_RATE1] += m1[3 * i + 2] * view.cvel[CAR, i]
        out[O_RATE2] += m2[3 * i + 2] * view.cvel[trailer, i]
    full = g[G_FULL]
    out[O_ROLL1] = math.asin(m1[7]) if full == 1.0 else z[Z_ROLL]
    out[O_ROLL2] = math.asin(m2[7]) if full == 1.0 else z[Z_ROLL + 2]
    _point(view, CAR, 0.0, 0.0, g[G_CAR_HEIGHT] * full, v)
    out[O_CAR_VX], out[O_CAR_VY] = v[3], v[4]
    out[O_SPEED] = math.cos(out[O_YAW1]) * v[3] + math.sin(out[O_YAW1]) * v[4]
    _point(view, CAR, g[G_REAR_X], 0.0, g[G_CAR_HEIGHT] * full, v)
    out[O_REAR_VX], out[O_REAR_VY] = v[3], v[4]
    height = (g[G_TRAILER_HEIGHT] - g[G_BALL]) * full
    _point(view, trailer, -g[G_TRAILER_LEVER], 0.0, height, v)
    out[O_TRAILER_VX], out[O_TRAILER_VY] = v[3], v[4]
    _momentum(view, trailer, v, out)


@njit(cache=True)
def _state_rates(g: Any, u: Any, z: Any, zdot: Any, view: Any, out: Any) -> None:
    """Roll of planar bodies, cargo, and the mean of the squared yaw rate."""
    a = view.qacc
    yaw1 = a[5] if g[G_FULL] == 1.0 else a[2]
    yaw2 = yaw1 + a[int(g[G_HITCH_DOF])]
    c1, s1, c2, s2 = (
        math.cos(out[O_YAW1]), math.sin(out[O_YAW1]), math.cos(out[O_YAW2]), math.sin(out[O_YAW2])
    )  # fmt: skip
    r1, lever = out[O_RATE1], g[G_CAR_LEVER]
    across1 = -s1 * a[0] + c1 * a[1]
    ball_x = a[0] + lever * (yaw1 * s1 + r1 * r1 * c1)
    ball_y = a[1] + lever * (-yaw1 * c1 + r1 * r1 * s1)
    ball = -s2 * ball_x + c2 * ball_y
    across2 = ball - g[G_TRAILER_LEVER] * yaw2
    if g[G_MORE] in (ELASTIC_DRAWBAR, BALL_RATTLE, SLIPPING_NECK, OPEN_CRACK):
        across2 += a[int(g[G_HITCH_DOF]) + 1]
    for body in range(2):
        gain = g[G_CAR_ROLL_GAIN + 3 * body]
        omega, zeta = g[G_CAR_ROLL_OMEGA + 3 * body], g[G_CAR_ROLL_ZETA + 3 * body]
        roll, rate = z[Z_ROLL + 2 * body], z[Z_ROLL + 2 * body + 1]
        lateral = across1 if body == 0 else across2
        zdot[Z_ROLL + 2 * body] = rate
        zdot[Z_ROLL + 2 * body + 1] = omega * omega * (gain * lateral - roll)
        zdot[Z_ROLL + 2 * body + 1] -= 2.0 * zeta * omega * rate
    omega = g[G_SLOSH_OMEGA]
    zdot[Z_SLOSH] = z[Z_SLOSH + 1]
    zdot[Z_SLOSH + 1] = -omega * omega * stretch(g, z)
    zdot[Z_SLOSH + 1] -= 2 * g[G_SLOSH_ZETA] * omega * z[Z_SLOSH + 1] + baffled(g, z)
    zdot[Z_SLOSH + 1] -= across2 + g[G_SLOSH_X] * yaw2 + GRAVITY_M_S2 * math.sin(u[U_BANK])
    if g[G_MORE] == ROOF_LOAD:
        omega = g[G_MORE_HZ]
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = -omega * omega * z[Z_MORE] - across1
        zdot[Z_MORE + 1] -= 2.0 * MORE_DAMPING * omega * z[Z_MORE + 1]
    if g[G_MORE] in (REAR_RACK, TAILGATE_CRATE):
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = -pull_of_rack(g, z) - across1 + lever * yaw1
    if g[G_MORE] == TWO_TANKS:
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = -pull_behind(g, z) - across2 + g[G_SLOSH_X] * yaw2
        zdot[Z_MORE + 1] -= GRAVITY_M_S2 * math.sin(u[U_BANK])
    if g[G_MORE] == TURNING_LOAD:
        omega = g[G_MORE_HZ]
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = -omega * omega * z[Z_MORE] - yaw2
        zdot[Z_MORE + 1] -= 2.0 * MORE_DAMPING * omega * z[Z_MORE + 1]
    if g[G_MORE] in (TOWBAR_TWIST, BINDING_BALL, RACKED_FRAME, COCKED_OVERRUN, WORKING_FRAME):
        # across these trailers nothing else acts than their tyres
        pull = g[G_TRAILER_MASS] * across2 - np.sum(out[O_FY + 4 : O_FY + 8])
        more_of_pull(g, z, zdot, pull)
    if g[G_MORE] == UNLOCKED_SLEW:  # its yaw rate less the trailer's
        zdot[Z_MORE] = -yaw2
        zdot[Z_MORE] -= g[G_MORE_AT] / g[G_MORE_SIZE] * math.tanh(z[Z_MORE] / SLOW_RAD_S)
    zdot[Z_MEAN] = r1 * r1 - z[Z_MEAN]
    zdot[Z_SPEED] = u[U_SPEED] - out[O_SPEED]


@njit(cache=True)
def _evaluate(
    g: Any, wheels: Any, u: Any, z: Any, zdot: Any, view: Any, calls: Any, held: Any, work: Any,
    out: Any,
) -> None:  # fmt: skip
    """Accelerations and state rates at the state that is in MuJoCo's memory and `z`.

    `held` is what stays over a step: [play, harmonic load, lost damper strokes of 8 wheels].
    """
    _call2(calls.position, calls.model, calls.data)
    _call2(calls.velocity, calls.model, calls.data)
    trailer = TRAILER_FULL if g[G_FULL] == 1.0 else TRAILER_PLANAR
    _observe(g, z, view, trailer, work[11], out)
    out[O_HARMONIC] = held[1] * u[U_HARMONIC]
    view.xfrc[:] = 0.0
    view.qfrc[:] = 0.0
    zdot[:] = 0.0
    mass = g[G_CAR_MASS] + g[G_TRAILER_MASS]
    drive = u[U_ACCELERATION] + SPEED_GAIN * (u[U_SPEED] - out[O_SPEED])
    drive = mass * (drive + INTEGRAL_GAIN * z[Z_SPEED])
    if g[G_FULL] == 1.0:
        _suspension(g, wheels, u, view, held[2:], out)
    _tyres(g, wheels, u, z, zdot, view, held[0], drive, work, out)
    _bodies(g, u, z, zdot, view, trailer, work, out)
    hitch = int(g[G_HITCH_DOF])
    rate, angle = view.qvel[hitch], out[O_YAW2] - out[O_YAW1]
    moment = g[G_HITCH_FRICTION] * math.tanh(rate / 0.004) + g[G_HITCH_DAMPING] * rate
    view.qfrc[hitch] -= moment + g[G_HITCH_SPRING] * angle
    _call2(calls.actuation, calls.model, calls.data)
    _call2(calls.acceleration, calls.model, calls.data)
    _call2(calls.constraint, calls.model, calls.data)
    _state_rates(g, u, z, zdot, view, out)
    slips_in_seat(g, z, zdot, view)


@njit(cache=True)
def _hold(
    g: Any,
    wheels: Any,
    u: Any,
    view: Any,
    history: Any,
    step: int,
    h: float,
    memory: Any,
    held: Any,
) -> None:
    """Update what changes by steps: play, delayed harmonic, strokes of the dampers.

    `memory` is [8 directions of stroke, 8 places where the stroke began].
    """
    half = 0.5 * g[G_PLAY]
    held[0] = min(max(held[0], u[U_STEER] - half), u[U_STEER] + half)
    back = step - u[U_DELAY] / h
    low = math.floor(back)
    held[1] = 0.0
    if low >= 0:
        part = back - low
        high = min(low + 1, step)
        held[1] = (1.0 - part) * history[low] + part * history[high]
    if g[G_FULL] == 0.0:
        return
    for i in range(8):
        dof = int(wheels[i, W_DOF])
        direction = 1.0 if view.qvel[dof] > 0.0 else -1.0
        if direction != memory[i]:
            memory[i] = direction
            memory[8 + i] = view.qpos[dof + 1]
        held[2 + i] = 1.0 if abs(view.qpos[dof + 1] - memory[8 + i]) < wheels[i, W_LOST] else 0.0


@njit(cache=True)
def run(
    g: Any, wheels: Any, inputs: Any, h: float, view: Any, calls: Any, z: Any, log: Any
) -> None:
    """Integrate over all rows of `inputs` (one per step of `h` seconds) and fill `log`.

    Parameters
    ----------
    g, wheels, inputs : tables with the columns named at the top of this file.
    h : step, s.
    view, calls : of the MuJoCo model and data, whose qpos and qvel hold the start.
    z : states beyond MuJoCo's, shape (Z_SIZE,), at the start.
    log : shape (rows, O_SIZE), filled.
    """
    rows, nv = inputs.shape[0], view.qvel.shape[0]
    rates = np.zeros((4, Z_SIZE))
    v0, q0, z0 = view.qvel.copy(), view.qpos.copy(), z.copy()
    speed, force = np.zeros((4, nv)), np.zeros((4, nv))
    mean = np.zeros(nv)
    out, work = np.zeros(O_SIZE), np.zeros((12, 8))
    history, held, memory = np.zeros(rows), np.zeros(10), np.zeros(16)
    parts = np.array([0.5, 0.5, 1.0])
    half = np.zeros(inputs.shape[1])
    held[0] = inputs[0, U_STEER]
    for k in range(rows):
        last = min(k + 1, rows - 1)
        rate = view.qvel[5] if g[G_FULL] == 1.0 else view.qvel[2]
        floor = max(z[Z_MEAN], 7.6e-5)  # 0.5 deg/s squared: no load without sway
        history[k] = min(max((rate * rate - z[Z_MEAN]) / floor, -1.5), 1.5)
        _hold(g, wheels, inputs[k], view, history, k, h, memory, held)
        q0[:] = view.qpos
        v0[:] = view.qvel
        z0[:] = z
        half[:] = 0.5 * (inputs[k] + inputs[last])
        for stage in range(4):
            if stage > 0:
                step = h * parts[stage - 1]
                mean[:] = speed[stage - 1]
                view.qpos[:] = q0
                _call_integrate(
                    calls.integrate, calls.model, view.qpos.ctypes.data, mean.ctypes.data, step
                )
                view.qvel[:] = v0 + step * force[stage - 1]
                z[:] = z0 + step * rates[stage - 1]
            u = inputs[k] if stage == 0 else (inputs[last] if stage == 3 else half)
            _evaluate(g, wheels, u, z, rates[stage], view, calls, held, work, out)
            speed[stage] = view.qvel
            force[stage] = view.qacc
            if stage == 0:
                log[k] = out
                if not (np.max(np.abs(view.qacc)) < LOST_M_S2 and abs(out[O_ROLL1]) < 1.0):
                    log[k:] = np.nan
                    return
        mean[:] = (speed[0] + 2.0 * speed[1] + 2.0 * speed[2] + speed[3]) / 6.0
        view.qpos[:] = q0
        _call_integrate(calls.integrate, calls.model, view.qpos.ctypes.data, mean.ctypes.data, h)
        view.qvel[:] = v0 + h / 6.0 * (force[0] + 2.0 * force[1] + 2.0 * force[2] + force[3])
        z[:] = z0 + h / 6.0 * (rates[0] + 2.0 * rates[1] + 2.0 * rates[2] + rates[3])
