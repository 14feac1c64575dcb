"""Compiled part of the rigid-body plant: forces on the bodies, and the integration in time.

MuJoCo computes the bodies' motion from the forces; its C functions are called by address from
code compiled with numba, so that a run does not return to Python at each step. The state is
(qpos, qvel) of MuJoCo and `z`, states of tyres, roll, driver and cargo. Integration is the
classical Runge-Kutta method of fourth order (at 2 ms the error of the damping ratio is < 1e-5).

Columns of the tables that :mod:`swaywatch.models.multibody` fills are named by the constants
below; all are float64, SI.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import njit, types
from numba.extending import intrinsic

# One row per wheel.
(
    W_BODY, W_X, W_Y, W_Z, W_AXLE, W_SIDE, W_DOF, W_LOAD, W_STIFFNESS, W_STEERED, W_RELAXATION,
    W_ROLL_STEER, W_SPRING, W_BAR, W_TYRE_SPRING, W_TYRE_DAMPER, W_UNSPRUNG, W_DAMPER_KIND,
    W_DAMPER, W_RATIO, W_KNEE, W_DEGRESSION, W_LOST, W_LOST_FACTOR, W_FADE, W_TRANSFER, W_DRAG,
    W_SIZE,
) = range(28)  # fmt: skip

# Scalars of the vehicle and its physics.
(
    G_FULL, G_LAW, G_FRICTION, G_SHAPE, G_LOAD_DEGRESSION, G_RATIO, G_COMPLIANCE, G_PLAY,
    G_PLAY_LAW, G_HITCH_FRICTION, G_HITCH_DAMPING, G_HITCH_SPRING, G_AIR_SIDE, G_AIR_YAW,
    G_DRAG_CAR, G_DRAG_TRAILER, G_CAR_MASS, G_TRAILER_MASS, G_CAR_ROLL_GAIN, G_CAR_ROLL_OMEGA,
    G_CAR_ROLL_ZETA, G_TRAILER_ROLL_GAIN, G_TRAILER_ROLL_OMEGA, G_TRAILER_ROLL_ZETA,
    G_HARMONIC_AXLE, G_SLOSH_MASS, G_SLOSH_OMEGA, G_SLOSH_ZETA, G_SLOSH_X, G_YAW_CONTROL,
    G_CAR_LEVER, G_TRAILER_LEVER, G_BALL, G_CAR_HEIGHT, G_TRAILER_HEIGHT, G_HITCH_DOF, G_RADIUS,
    G_REAR_X, G_MORE, G_MORE_SIZE, G_MORE_AT, G_MORE_HZ, G_SIZE,
) = range(43)  # fmt: skip

# Inputs, one row per step.
(
    U_STEER, U_SPEED, U_ACCELERATION, U_GUST_CAR, U_GUST_TRAILER, U_BANK, U_FRICTION,
    U_STIFFNESS, _, _, _, U_HARMONIC, U_DELAY, U_FADE, U_SIZE,
) = range(15)  # fmt: skip

# States beyond MuJoCo's.
Z_SLIP, Z_ROLL, Z_SPEED, Z_SLOSH, Z_MEAN, Z_MORE, Z_SIZE = 0, 8, 12, 13, 15, 16, 18

# What is kept of each step.
(
    O_YAW1, O_YAW2, O_RATE1, O_RATE2, O_SPEED, O_ROLL1, O_ROLL2, O_CAR_VX, O_CAR_VY, O_REAR_VX,
    O_REAR_VY, O_TRAILER_VX, O_TRAILER_VY, O_MOMENTUM_X, O_MOMENTUM_Y, O_MOMENTUM_Z, O_FORCE_X,
    O_FORCE_Y, O_FORCE_Z, O_STEER, O_HARMONIC, O_FY, _, _, _, _, _, _, _, O_FZ, _, _, _, _, _, _,
    _, O_TRAVEL, _, _, _, _, _, _, _, O_DAMPER, _, _, _, _, _, _, _, O_SLIP, _, _, _, _, _, _, _,
    O_SIZE,
) = range(62)  # fmt: skip

CAR, TRAILER_PLANAR, TRAILER_FULL = 1, 2, 6
# Rows of the scratch table: a point's position and velocity; of wheels also these two.
TRAVEL, SPEED = 6, 7
AIR_DENSITY, SIDE_AREA = 1.2, 5.0
# Physics beyond what any library of effects lists, numbered as `MORE` of multibody_vehicle.py.
(
    STOP, TRAILER_STEERS, CAR_AIR, TOW_ASSIST, ROOF_LOAD, AXLE_HYSTERESIS, TARPAULIN, HEADING_WIND,
    TRAILER_BRAKES, HYDRAULIC, REAR_STEERS, SCRUB, GAP_AIR, TRAILER_HUBS, VARIABLE_RATIO,
    LATE_ASSIST, CAR_BRAKES, TURNING_LOAD, AIR_DAMPING, ROLLING_LOAD, LOCKED_AXLE, LANE_ASSIST,
    BEARING_PLAY, REAR_CONTROL, DRIVER_ARMS, BAFFLED_LIQUID, WEDGE_FRICTION, COMMAND_STEERING,
    ROLL_HYSTERESIS, HEDGE_WIND, CASTER_AXLE, TYRE_WARMING, REAR_BUSH_PLAY, BUMP_STOP_STEER,
    BENT_RIM, CAM_CENTRING, STABILISER_WINDUP, SLIDING_CRATE, PADDED_LOAD, PUMP_CATCH,
    TORQUE_VECTORING, SWAY_BRAKE, WAKE_SHEDDING, CAR_WAKE, GROOVED_ROAD, GYRO_STABILISER,
    WIRE_STEERING, BRAKE_CABLE, RUBBER_COUPLING, TOW_MODE, CORNER_STEADY, TWO_TANKS, WISHBONE_BUSH,
    BOW_WAVE, ELASTIC_DRAWBAR, SWAY_ASSIST, LATE_AIR, LOOSE_U_BOLTS, PUNCTURE, BINDING_BRAKE,
    GLAZING_PADS, ONE_WAY_DAMPER, UNLOCKED_SLEW, WANDERING_RUTS, YAW_REFERENCE, STEPPING_HORSE,
    HYDRO_BUSH, LOOSE_CURTAIN, DAMPER_PLAY, TOWBAR_TWIST, GALLOPING, REAR_RACK, SLOW_ACTUATOR,
    SIDESLIP_LIMITER, JOCKEY_WHEEL, COUNTER_STEER, CONCRETE_SLABS, LEAKING_LOAD, WORN_SHOULDERS,
    ALIGNING_TORQUE,
) = range(1, 81)  # fmt: skip
MORE_DAMPING = 0.05
TURN = 2.0 * math.pi
ARMS_DAMPING = 0.3
SLOW_RAD_S = 0.005
SLIDES_M_S, WORKED_RAD, REAR_LEFT = 0.01, 0.02, 2
RATE_S, BRAKE_S = 0.02, 0.15  # lag of a rate that is taken from an angle, of trailer brakes
EDDY_GROWTH, EDDY_COUPLING = 0.3, 5.0  # the latter 12 over the trailer's width (Facchinetti 2004)
EDDIES_BEHIND_M, NOSE_AHEAD_M, AIR_AHEAD_M, TAIL_BEHIND_M = 2.0, 2.5, 1.0, 2.0
CORNER_BEHIND_M, CORNER_RIGHT_M, CURTAIN_BEHIND_M = 2.0, 0.9, 1.0
SWAY_S, DRAWBAR_S = 0.6, 0.004  # of the mean of a swing; damping over stiffness of a drawbar
ASKED_BASE_M, ASKED_M_S = 2.7, 28.0  # of the car that a stability controller believes it is in
STEP_M, STEP_M_S2 = 0.15, 1.0  # how far horses step, and for which acceleration
STRUT_NM_RAD, TOWBAR_S, ACTUATOR_S = 1e5, 0.03, 0.1
NOSE_BEHIND_BALL_M = 0.6
LOST_M_S2 = 1e4  # accelerations of a combination that has left the road
SPEED_GAIN, INTEGRAL_GAIN = 0.8, 0.2  # of the driver who holds the speed, 1/s and 1/s2
_G = 9.81


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
        force = wheels[i, W_LOAD] - wheels[i, W_UNSPRUNG] * _G + wheels[i, W_SPRING] * travel
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
def _beyond(value: float, at: float) -> float:
    """What of a value lies beyond `at`, on either side."""
    return math.copysign(max(abs(value) - at, 0.0), value)


@njit(cache=True)
def _more_steer(
    g: Any, z: Any, rate: float, wheel: int, place: float, slip: float, out: Any
) -> float:
    """Steering of a wheel's axle by physics that nobody lists, rad; `slip` is without it.

    `place` is of a planar wheel in its body's frame, m.
    """
    if g[G_MORE] == WANDERING_RUTS:
        way = z[Z_MORE] + place - (0.0 if wheel < 4 else g[G_CAR_LEVER])
        return float(g[G_MORE_SIZE] * math.sin(TURN * way / g[G_MORE_AT]))
    if g[G_MORE] == GROOVED_ROAD:
        heading = out[O_YAW1] if wheel < 4 else out[O_YAW2]
        return float(-g[G_MORE_SIZE] * g[G_MORE_AT] * math.tanh(heading / g[G_MORE_AT]))
    if wheel >= 4:
        return float(_more_of_trailer_axles(g, z, wheel, slip, out))
    if wheel >= 2:
        return float(g[G_MORE_SIZE] * _more_of_rear_axle(g, z, wheel, slip, out))
    return float(g[G_MORE_SIZE] * _more_of_front_axle(g, z, rate, slip, out))


@njit(cache=True)
def _more_of_front_axle(g: Any, z: Any, rate: float, slip: float, out: Any) -> float:
    """The same of the car's front axle, over its size."""
    kind, angle = g[G_MORE], 0.0
    if kind in (LATE_ASSIST, DRIVER_ARMS):
        angle = z[Z_MORE]
    elif kind == TOW_ASSIST:
        angle = rate
    elif kind == VARIABLE_RATIO:
        angle = out[O_STEER] * abs(out[O_STEER])
    elif kind == LANE_ASSIST:
        angle = -out[O_YAW1]
    elif kind == PUMP_CATCH:
        angle = -_beyond((out[O_STEER] - z[Z_MORE]) / RATE_S, g[G_MORE_AT])
    elif kind == WISHBONE_BUSH:
        angle = _beyond(slip, g[G_MORE_AT])
    elif kind == HYDRO_BUSH:
        angle = z[Z_MORE] - slip
    elif kind == COUNTER_STEER:
        angle = g[G_MORE_AT] * math.tanh(out[O_RATE2] / g[G_MORE_AT])
    return float(angle)


@njit(cache=True)
def _more_of_rear_axle(g: Any, z: Any, wheel: int, slip: float, out: Any) -> float:
    """The same of the car's rear axle, or of one wheel that is bent, over its size."""
    kind, angle = g[G_MORE], 0.0
    if kind == REAR_STEERS:
        angle = out[O_STEER]
    elif kind in (REAR_CONTROL, TOWBAR_TWIST):
        angle = z[Z_MORE]
    elif kind == WORN_SHOULDERS:
        angle = abs(slip)
    elif kind == REAR_BUSH_PLAY:
        angle = math.tanh(slip / g[G_MORE_AT])
    elif kind == BENT_RIM and wheel == REAR_LEFT:
        angle = math.sin(z[Z_MORE] / g[G_RADIUS])
    elif kind == BUMP_STOP_STEER:
        angle = _beyond(out[O_ROLL1], g[G_MORE_AT])
    elif kind == TOW_MODE:
        angle = g[G_MORE_AT] * math.tanh((out[O_YAW2] - out[O_YAW1]) / g[G_MORE_AT])
    return float(angle)


@njit(cache=True)
def _more_of_trailer_axles(g: Any, z: Any, wheel: int, slip: float, out: Any) -> float:
    """The same of the trailer's axles."""
    kind, size, angle = g[G_MORE], g[G_MORE_SIZE], 0.0
    if kind == BEARING_PLAY:
        angle = size * math.tanh(slip / (1.2 * size))
    elif kind == TRAILER_STEERS:
        angle = size * (out[O_YAW2] - out[O_YAW1])
    elif kind == COMMAND_STEERING:
        angle = size * out[O_RATE1]
    elif kind == CONCRETE_SLABS:
        angle = size * math.sin(TURN * z[Z_MORE] / g[G_MORE_AT]) * slip
    elif kind in (
        AXLE_HYSTERESIS, ROLL_HYSTERESIS, CASTER_AXLE, WIRE_STEERING, LOOSE_U_BOLTS, SLOW_ACTUATOR,
    ):  # fmt: skip
        angle = size * z[Z_MORE]
    elif kind == TYRE_WARMING or (kind == PUNCTURE and wheel % 2 == 0):
        angle = size * z[Z_MORE] * slip
    return float(angle)


@njit(cache=True)
def _more_moments(g: Any, z: Any, view: Any, trailer: int, out: Any) -> None:
    """Moments of physics that nobody lists."""
    hitch = int(g[G_HITCH_DOF])
    rate = view.qvel[hitch]
    view.qfrc[hitch] -= _more_at_hitch(g, z, rate, out)
    view.xfrc[trailer, 5] += _more_of_trailer(g, z, rate, out)
    view.xfrc[CAR, 5] += _more_of_car(g, z, rate, out)
    if g[G_MORE] == ELASTIC_DRAWBAR and g[G_FULL] == 0.0:  # a planar trailer's joint after the ball
        side = hitch + 1
        view.qfrc[side] -= g[G_MORE_SIZE] * (view.qpos[side] + DRAWBAR_S * view.qvel[side])


@njit(cache=True)
def _more_at_hitch(g: Any, z: Any, rate: float, out: Any) -> float:
    """Moment about the ball against the articulation, N m."""
    kind, size, at = g[G_MORE], g[G_MORE_SIZE], g[G_MORE_AT]
    angle, moment = out[O_YAW2] - out[O_YAW1], 0.0
    if kind == STOP:
        moment = size * _beyond(angle, at)
    elif kind == HYDRAULIC:
        moment = size * abs(rate) * rate
    elif kind == WEDGE_FRICTION:
        moment = size * abs(angle) * math.tanh(rate / SLOW_RAD_S)
    elif kind == CAM_CENTRING:
        moment = size * math.tanh(angle / at)
    elif kind == STABILISER_WINDUP:
        moment = size * z[Z_MORE] / at
    elif kind == RUBBER_COUPLING:
        moment = size * (angle - z[Z_MORE])
    elif kind == GLAZING_PADS:
        moment = size * math.tanh(rate / SLOW_RAD_S) / (1.0 + z[Z_MORE] / at)
    elif kind == ONE_WAY_DAMPER:
        moment = size * max(math.copysign(1.0, size) * rate, 0.0)
    elif kind == DAMPER_PLAY:
        moment = STRUT_NM_RAD * _beyond(angle - z[Z_MORE], at)
    return float(moment)


@njit(cache=True)
def _more_of_trailer(g: Any, z: Any, rate: float, out: Any) -> float:
    """Yaw moment on the trailer, N m."""
    kind, size, at = g[G_MORE], g[G_MORE_SIZE], g[G_MORE_AT]
    r, moment = out[O_RATE2], 0.0
    if kind == TRAILER_BRAKES:
        moment = -size * _beyond(r, at)
    elif kind == SCRUB:
        moment = -size * math.tanh(r / SLOW_RAD_S)
    elif kind == TRAILER_HUBS:
        moment = -size * math.tanh(rate / at)
    elif kind == TURNING_LOAD:
        omega = g[G_MORE_HZ]
        pull = omega * omega * z[Z_MORE] + 2.0 * MORE_DAMPING * omega * z[Z_MORE + 1]
        moment = size * pull
    elif kind == AIR_DAMPING:
        moment = -size * out[O_SPEED] * r
    elif kind == GYRO_STABILISER:
        moment = -size * (r - z[Z_MORE])
    elif kind == UNLOCKED_SLEW:
        moment = at * math.tanh(z[Z_MORE] / SLOW_RAD_S)
    elif kind == ALIGNING_TORQUE:
        slip = 0.25 * (out[O_SLIP + 4] + out[O_SLIP + 5] + out[O_SLIP + 6] + out[O_SLIP + 7])
        moment = size * slip / (1.0 + (slip / at) ** 2)
    return float(moment)


@njit(cache=True)
def _more_of_car(g: Any, z: Any, rate: float, out: Any) -> float:
    """Yaw moment on the car, N m."""
    kind, size, at, moment = g[G_MORE], g[G_MORE_SIZE], g[G_MORE_AT], 0.0
    if kind == CAR_BRAKES:
        moment = size * _beyond(rate, at)
    elif kind == LOCKED_AXLE:
        moment = -size * math.tanh(out[O_RATE1] / (at * max(out[O_SPEED], 1.0)))
    elif kind == TORQUE_VECTORING:
        moment = size * math.tanh(out[O_STEER] / at)
    elif kind == SWAY_ASSIST:
        moment = -size * out[O_RATE1] * min(max(z[Z_MORE] / at - 1.0, 0.0), 1.0)
    elif kind == YAW_REFERENCE:
        v = out[O_SPEED]
        asked = v * out[O_STEER] / (ASKED_BASE_M * (1.0 + (v / ASKED_M_S) ** 2))
        moment = -size * _beyond(out[O_RATE1] - asked, at)
    elif kind == SIDESLIP_LIMITER:
        moment = size * _beyond(_sideslip(out), at)
    return float(moment)


@njit(cache=True)
def _more_lag(g: Any, z: Any, zdot: Any, rate: float, out: Any) -> None:
    """What is late, and the state of dry friction (after Dahl)."""
    kind, at = g[G_MORE], g[G_MORE_AT]
    if kind in (REAR_CONTROL, LATE_ASSIST, RUBBER_COUPLING, WIRE_STEERING, GYRO_STABILISER):
        zdot[Z_MORE] = (_followed(kind, out) - z[Z_MORE]) / at
    elif kind in (AXLE_HYSTERESIS, STABILISER_WINDUP):
        zdot[Z_MORE] = rate - abs(rate) * z[Z_MORE] / at
    elif kind == ROLL_HYSTERESIS:  # of a planar trailer
        rolls = z[Z_ROLL + 3]
        zdot[Z_MORE] = rolls - abs(rolls) * z[Z_MORE] / at
    elif kind == DRIVER_ARMS:
        omega = g[G_MORE_HZ]
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = omega * omega * (out[O_RATE1] - z[Z_MORE])
        zdot[Z_MORE + 1] -= 2.0 * ARMS_DAMPING * omega * z[Z_MORE + 1]
    elif kind == DAMPER_PLAY:
        zdot[Z_MORE] = _more_at_hitch(g, z, rate, out) / g[G_MORE_SIZE]
    elif kind == SLOW_ACTUATOR:
        zdot[Z_MORE] = min(max((out[O_RATE2] - z[Z_MORE]) / ACTUATOR_S, -at), at)
    elif kind == PUMP_CATCH:
        zdot[Z_MORE] = (out[O_STEER] - z[Z_MORE]) / RATE_S
    elif kind == SWAY_ASSIST:
        zdot[Z_MORE] = (abs(out[O_RATE1]) - z[Z_MORE]) / SWAY_S
    else:
        _more_of_way(g, z, zdot, rate, out)
        _more_of_sway(g, z, zdot, out)


@njit(cache=True)
def _more_of_way(g: Any, z: Any, zdot: Any, rate: float, out: Any) -> None:
    """What grows with the distance, or with what pads have rubbed."""
    kind = g[G_MORE]
    if kind in (HEDGE_WIND, BENT_RIM, WANDERING_RUTS, CONCRETE_SLABS):
        zdot[Z_MORE] = out[O_SPEED]
    elif kind in (PUNCTURE, BINDING_BRAKE, LEAKING_LOAD):
        zdot[Z_MORE] = (1.0 - z[Z_MORE]) * out[O_SPEED] / g[G_MORE_AT]
    elif kind == GLAZING_PADS:
        zdot[Z_MORE] = abs(rate)


@njit(cache=True)
def _followed(kind: float, out: Any) -> float:
    """What a state follows late."""
    if kind == REAR_CONTROL:
        return float(out[O_RATE1])
    if kind == GYRO_STABILISER:
        return float(out[O_RATE2])
    if kind == WIRE_STEERING:
        return float(out[O_STEER])
    return float(out[O_YAW2] - out[O_YAW1])


@njit(cache=True)
def _more_of_sway(g: Any, z: Any, zdot: Any, out: Any) -> None:
    """What a planar trailer's lateral acceleration moves: brakes, horses, eddies behind it.

    The last are an oscillator after van der Pol.
    """
    lateral = z[Z_ROLL + 2] / g[G_TRAILER_ROLL_GAIN]
    if g[G_MORE] == SWAY_BRAKE:
        zdot[Z_MORE] = (max(abs(lateral) - g[G_MORE_AT], 0.0) - z[Z_MORE]) / BRAKE_S
    if g[G_MORE] == STEPPING_HORSE:
        zdot[Z_MORE] = (STEP_M * math.tanh(lateral / STEP_M_S2) - z[Z_MORE]) / g[G_MORE_AT]
    if g[G_MORE] != WAKE_SHEDDING:
        return
    omega = TURN * out[O_SPEED] / g[G_MORE_AT]
    q, change = z[Z_MORE], z[Z_MORE + 1]
    zdot[Z_MORE] = change
    zdot[Z_MORE + 1] = EDDY_COUPLING * lateral - omega**2 * q
    zdot[Z_MORE + 1] -= EDDY_GROWTH * omega * (q * q - 1.0) * change


@njit(cache=True)
def _more_side(g: Any, z: Any, zdot: Any, beta: float, pressure: float, out: Any) -> float:
    """Side force of physics that nobody lists, on the car or the trailer, N.

    `beta` and `pressure` (half the air's density times speed squared) are of that body.
    """
    kind, size, omega = g[G_MORE], g[G_MORE_SIZE], g[G_MORE_HZ]
    if kind in (HEADING_WIND, HEDGE_WIND):
        turns = kind == HEADING_WIND
        return float(size * math.sin(out[O_YAW2] if turns else TURN * z[Z_MORE] / g[G_MORE_AT]))
    if kind == TARPAULIN:
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = omega * omega * (beta - z[Z_MORE])
        zdot[Z_MORE + 1] -= 2.0 * MORE_DAMPING * omega * z[Z_MORE + 1]
        return float(-size * pressure * z[Z_MORE])
    if kind == ROOF_LOAD:
        pull = omega * omega * z[Z_MORE] + 2.0 * MORE_DAMPING * omega * z[Z_MORE + 1]
        return float(size * pull)
    if kind in (REAR_RACK, JOCKEY_WHEEL, LEAKING_LOAD):
        return float(size * _more_beside_air(g, z, beta, out))
    if kind == LATE_AIR:
        zdot[Z_MORE] = (beta - z[Z_MORE]) * out[O_SPEED] / g[G_MORE_AT]
    return float(-size * pressure * _more_of_flow(g, z, beta, out))


@njit(cache=True)
def _more_beside_air(g: Any, z: Any, beta: float, out: Any) -> float:
    """Side force of a loose rack, of a wheel at the nose, of mass that is lost, over its size."""
    if g[G_MORE] == REAR_RACK:
        return _pull_of_rack(g, z)
    if g[G_MORE] == JOCKEY_WHEEL:
        slip = beta + _ahead(g) * out[O_RATE2] / out[O_SPEED]
        return -math.tanh(slip / g[G_MORE_AT])
    return float(z[Z_MORE] * g[G_TRAILER_MASS] * z[Z_ROLL + 2] / g[G_TRAILER_ROLL_GAIN])


@njit(cache=True)
def _more_of_flow(g: Any, z: Any, beta: float, out: Any) -> float:
    """Side force of the air over its size and pressure, 1; positive is against it."""
    kind, angle = g[G_MORE], 0.0
    if kind == CAR_AIR:
        angle = beta
    elif kind in (GAP_AIR, BOW_WAVE):
        angle = out[O_YAW2] - out[O_YAW1]
    elif kind == LATE_AIR:
        angle = z[Z_MORE]
    elif kind == WAKE_SHEDDING:
        angle = -z[Z_MORE]
    elif kind == CAR_WAKE:
        angle = -_sideslip(out)
    elif kind == GALLOPING:
        part = (beta / g[G_MORE_AT]) ** 2
        angle = -beta * (1.0 - part) / (1.0 + part)
    elif kind == LOOSE_CURTAIN:
        angle = max(math.copysign(1.0, g[G_MORE_SIZE]) * beta, 0.0)
    return float(angle)


@njit(cache=True)
def _sideslip(out: Any) -> float:
    """Of the car's COG, rad."""
    c, s = math.cos(out[O_YAW1]), math.sin(out[O_YAW1])
    return math.atan2(c * out[O_CAR_VY] - s * out[O_CAR_VX], out[O_SPEED])


@njit(cache=True)
def _pull_of_rack(g: Any, z: Any) -> float:
    """Acceleration with which the car's tail holds what swings there, m/s2."""
    omega = g[G_MORE_HZ]
    slides = g[G_MORE_AT] * math.tanh(z[Z_MORE + 1] / SLIDES_M_S)
    return float(omega * omega * z[Z_MORE] + slides)


@njit(cache=True)
def _more_of_slip(g: Any, z: Any, zdot: Any, middle: float) -> None:
    """State of what follows the slip of axles, taken at their middle."""
    at = g[G_MORE_AT]
    if g[G_MORE] == TYRE_WARMING:
        middle = math.tanh(abs(middle) / WORKED_RAD)
    if g[G_MORE] == LOOSE_U_BOLTS:
        change = (middle - z[Z_MORE + 1]) / RATE_S
        zdot[Z_MORE] = change - abs(change) * z[Z_MORE] / at
        zdot[Z_MORE + 1] = change
        return
    zdot[Z_MORE] = (middle - z[Z_MORE]) / at


@njit(cache=True)
def _more_drag(g: Any, z: Any, wheel: Any, out: Any) -> float:
    """Drag of one wheel of the trailer, N."""
    size = g[G_MORE_SIZE]
    if g[G_MORE] == SWAY_BRAKE:
        return float(0.25 * size * z[Z_MORE])
    if g[G_MORE] == BRAKE_CABLE and wheel[W_SIDE] < 0.0:
        turned = (out[O_YAW2] - out[O_YAW1]) * math.copysign(1.0, size)
        return float(0.5 * abs(size) * max(turned, 0.0))
    if g[G_MORE] == BINDING_BRAKE and wheel[W_SIDE] < 0.0:
        return float(0.5 * size * z[Z_MORE])
    return 0.0


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
    if g[G_MORE] in (CASTER_AXLE, TYRE_WARMING, LOOSE_U_BOLTS):
        middle = 0.25 * (work[4, TRAVEL] + work[5, TRAVEL] + work[6, TRAVEL] + work[7, TRAVEL])
        _more_of_slip(g, z, zdot, middle)
    if g[G_MORE] == HYDRO_BUSH:
        middle = 0.5 * (work[0, TRAVEL] + work[1, TRAVEL]) - out[O_STEER]
        _more_of_slip(g, z, zdot, middle)
    for i in range(8):
        w = wheels[i]
        roll = out[O_ROLL1] if i < 4 else out[O_ROLL2]
        steer = w[W_STEERED] * out[O_STEER] + w[W_ROLL_STEER] * roll
        slip = work[i, TRAVEL] - steer
        steer += _more_steer(g, z, view.qvel[int(g[G_HITCH_DOF])], i, w[W_X], slip, out)
        slip = work[i, TRAVEL] - steer
        out[O_SLIP + i] = slip
        if w[W_RELAXATION] > 0.0:
            zdot[Z_SLIP + i] = work[i, SPEED] / w[W_RELAXATION] * (slip - z[Z_SLIP + i])
            slip = z[Z_SLIP + i]
        force = _wheel_force(g, w, u, load[i], slip)
        out[O_FY + i] = force
        along = 0.5 * drive * w[W_STEERED] - w[W_DRAG]
        if i >= 4:
            along -= _more_drag(g, z, w, out)
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
def _stretch(g: Any, z: Any) -> float:
    """Of the spring that holds the cargo, m; a load that rolls is free between its boards.

    Pads stiffen, as if they were pressed by more; friction alone holds a crate; horses step.
    """
    q = z[Z_SLOSH]
    if g[G_MORE] == ROLLING_LOAD:
        return _beyond(q, g[G_MORE_AT])
    if g[G_MORE] == PADDED_LOAD:
        return float(q * (1.0 + (q / g[G_MORE_AT]) ** 2))
    if g[G_MORE] == STEPPING_HORSE:
        return float(q - z[Z_MORE])
    return 0.0 if g[G_MORE] == SLIDING_CRATE else float(q)


@njit(cache=True)
def _baffled(g: Any, z: Any) -> float:
    """Deceleration of a liquid by baffles, with the square of its rate, or by friction, m/s2."""
    if g[G_MORE] == BAFFLED_LIQUID:
        return float(abs(z[Z_SLOSH + 1]) * z[Z_SLOSH + 1] / g[G_MORE_AT])
    if g[G_MORE] == SLIDING_CRATE:
        return float(g[G_MORE_AT] * math.tanh(z[Z_SLOSH + 1] / SLIDES_M_S))
    return 0.0


@njit(cache=True)
def _pull_behind(g: Any, z: Any) -> float:
    """Acceleration with which the second tank holds its liquid, m/s2."""
    omega = g[G_MORE_HZ]
    return float(omega * omega * z[Z_MORE] + 2.0 * g[G_SLOSH_ZETA] * omega * z[Z_MORE + 1])


@njit(cache=True)
def _cargo(g: Any, z: Any, view: Any, trailer: int, at: Any, out: Any) -> float:
    """Pull of what moves in the trailer across it, N, and push it; `at` is scratch."""
    c, s, omega = math.cos(out[O_YAW2]), math.sin(out[O_YAW2]), g[G_SLOSH_OMEGA]
    up = (g[G_TRAILER_HEIGHT] - g[G_BALL]) * g[G_FULL]
    pull = omega * omega * _stretch(g, z) + 2 * g[G_SLOSH_ZETA] * omega * z[Z_SLOSH + 1]
    pull = g[G_SLOSH_MASS] * (pull + _baffled(g, z))
    behind = 0.0
    if g[G_MORE] == TWO_TANKS:
        pull *= 0.5
        behind = 0.5 * g[G_SLOSH_MASS] * _pull_behind(g, z)
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
def _ahead(g: Any) -> float:
    """Place of a side force ahead of its body's COG, m."""
    kind, ahead = g[G_MORE], 0.0
    if kind == WAKE_SHEDDING:
        ahead = -EDDIES_BEHIND_M
    elif kind == BOW_WAVE:
        ahead = -TAIL_BEHIND_M
    elif kind == CAR_WAKE:
        ahead = NOSE_AHEAD_M
    elif kind == LOOSE_CURTAIN:
        ahead = -CURTAIN_BEHIND_M
    elif kind == LATE_AIR:
        ahead = AIR_AHEAD_M
    elif kind == REAR_RACK:
        ahead = -g[G_CAR_LEVER]
    elif kind == JOCKEY_WHEEL:
        ahead = g[G_TRAILER_LEVER] - NOSE_BEHIND_BALL_M
    return float(ahead)


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
    slope = -_G * math.sin(u[U_BANK])
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
    _more_moments(g, z, view, trailer, out)
    _more_lag(g, z, zdot, view.qvel[int(g[G_HITCH_DOF])], out)
    if g[G_MORE] == CORNER_STEADY:
        _drag_corner(g, view, trailer, at, out)
        return
    if g[G_MORE] in (CAR_AIR, ROOF_LOAD, BOW_WAVE, REAR_RACK):
        beta1 = math.atan2(c1 * cog1[4] - s1 * cog1[3], v1)
        side1 = _more_side(g, z, zdot, beta1, 0.5 * AIR_DENSITY * v1 * v1, out)
        _push(view, CAR, cog1, -s1 * side1, c1 * side1, 0.0)
        view.xfrc[CAR, 5] += _ahead(g) * side1
        return
    side2 = _more_side(g, z, zdot, beta, 0.5 * AIR_DENSITY * v2 * v2, out)
    _push(view, trailer, cog2, -s2 * side2, c2 * side2, 0.0)
    view.xfrc[trailer, 5] += _ahead(g) * side2
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
    if g[G_MORE] == ELASTIC_DRAWBAR:
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
    zdot[Z_SLOSH + 1] = -omega * omega * _stretch(g, z)
    zdot[Z_SLOSH + 1] -= 2 * g[G_SLOSH_ZETA] * omega * z[Z_SLOSH + 1] + _baffled(g, z)
    zdot[Z_SLOSH + 1] -= across2 + g[G_SLOSH_X] * yaw2 + _G * math.sin(u[U_BANK])
    if g[G_MORE] == ROOF_LOAD:
        omega = g[G_MORE_HZ]
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = -omega * omega * z[Z_MORE] - across1
        zdot[Z_MORE + 1] -= 2.0 * MORE_DAMPING * omega * z[Z_MORE + 1]
    if g[G_MORE] == REAR_RACK:
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = -_pull_of_rack(g, z) - across1 + lever * yaw1
    if g[G_MORE] == TWO_TANKS:
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = -_pull_behind(g, z) - across2 + g[G_SLOSH_X] * yaw2
        zdot[Z_MORE + 1] -= _G * math.sin(u[U_BANK])
    if g[G_MORE] == TURNING_LOAD:
        omega = g[G_MORE_HZ]
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = -omega * omega * z[Z_MORE] - yaw2
        zdot[Z_MORE + 1] -= 2.0 * MORE_DAMPING * omega * z[Z_MORE + 1]
    if g[G_MORE] == TOWBAR_TWIST:  # nothing else acts on this trailer than its tyres
        pull = g[G_TRAILER_MASS] * across2 - np.sum(out[O_FY + 4 : O_FY + 8])
        zdot[Z_MORE] = (pull - z[Z_MORE]) / TOWBAR_S
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
