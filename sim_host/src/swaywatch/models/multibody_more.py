"""Compiled part of the rigid-body plant that nobody lists, concealed by `make proof-unlisted`."""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from swaywatch.models.multibody_newer import (
    FIRST_NEWER,
    TAILGATE_CRATE,
    newer_ahead,
    newer_drag,
    newer_lag,
    newer_moments,
    newer_of_slip,
    newer_side,
    newer_steer,
    pull_of_crate,
)
from swaywatch.models.multibody_tables import (
    CAR,
    G_CAR_LEVER,
    G_CAR_ROLL_GAIN,
    G_FULL,
    G_HITCH_DOF,
    G_MORE,
    G_MORE_AT,
    G_MORE_HZ,
    G_MORE_SIZE,
    G_RADIUS,
    G_RATIO,
    G_SLOSH_ZETA,
    G_TRAILER_LEVER,
    G_TRAILER_MASS,
    G_TRAILER_ROLL_GAIN,
    O_CAR_VX,
    O_CAR_VY,
    O_RATE1,
    O_RATE2,
    O_ROLL1,
    O_ROLL2,
    O_SLIP,
    O_SPEED,
    O_STEER,
    O_YAW1,
    O_YAW2,
    W_SIDE,
    W_STEERED,
    Z_MORE,
    Z_ROLL,
    Z_SLOSH,
)

#: The files that this one is compiled with, see `multibody_kernel.MADE_OF`.
MADE_OF = {"multibody_tables": "7e6a397047d3", "multibody_newer": "7805f9138981"}
# Physics beyond what any library of effects lists, numbered as `MORE` of multibody_vehicle.py.
# Those from `FIRST_NEWER` on are in multibody_newer.py.
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
    ALIGNING_TORQUE, BINDING_BALL, BALL_RATTLE, SPRING_BARS, SLACK_LASHING, LINGERING_FLOW,
    TORN_CABLE, HUB_DRIVES, ANGLE_VECTORING, LEVELLING_PUMP, CLAY_TREAD, RACKED_FRAME,
    CASTER_FLUTTER, SQUEALING_PADS, OUTWARD_DAMPER, SEIZED_TOP_MOUNT, CROSSWIND_ASSIST,
    LINK_STEERING, BROKEN_LEAF, SNOW_TRACKS, HUNTING_VECTORING, ROOF_TENT, TEARING_CANVAS,
    COCKED_OVERRUN, LOOSENING_STRAPS, BRINELLED_RING, STEPPER_REAR, GAP_PUMP, LEAKY_LINK, BENT_ARM,
    SOLENOID_BRAKES, SERVO_BALL, ROCKING_HULL, QUICK_REAR, CREEPING_CLAMP, RAG_JOINT, CURVE_BRAKE,
    LOCKER_CORNER, HANGING_LOAD, BUMP_STEER, WORKING_FRAME, LATE_REAR_STEERING, SLACK_TARPAULIN,
    TILTED_HEAD, PUDDLES, ROLL_PROTECTION, SUBFRAME_RUBBER, SOFT_TYRE, GREASY_BALL, CROOKED_JOINT,
    SOFT_VERGE, LEANING_STACK, LOOSE_HUB, BROKEN_LINK, SLIPPING_NECK, OPEN_DOOR, SHIMMY,
    LORRY_RUTS, STANDING_WATER, BUMP_STOP_GRIP, LOOSE_HANDS, WORN_PAD, TRACK_ROD_END,
    HOPPING_WHEELS, BUCKLED_WHEEL, SKEW_JOINTS, SLOW_PUNCTURE, LATE_CORRECTION, RUT_WALLS,
    ROLLED_UNDER, ONE_WHEEL_BRAKE, STOP_OVERLOAD, WIND_SHADOW, WET_STRETCHES, SLIDING_BOX,
    LOOSE_SUBFRAME, GAP_HEADWIND, STICKY_BEAM, WORN_SPOT,
) = range(1, 159)  # fmt: skip
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
BALL_N_M, BALL_S_M = 4e5, 4.0  # of the ball in its head, after Hunt and Crossley
FLUTTER_DAMPING = 0.15
TENT_BEHIND_M, LOOSENED = 1.0, 0.85  # of straps: the share of their stiffness that they lose
SERVO_S, RELEASE_S, SWITCH_RAD_S = 0.05, 0.3, 0.001  # lags of motors, of solenoids that let go
WALL = 10.0  # stiffness of a wall over that of a pendulum
SEAT_M = 2e-4  # of a ball neck: how far it gives way before it slips
STACK = 0.6  # share of what holds a stack that is friction
BREAKS_S = 0.05
DOOR_BEHIND_M, DOOR_DAMPING = 2.5, 0.2
SHIMMY_GROWTH, SHIMMY_COUPLING = 0.3, 5.0  # the latter 1/rad, of the tyres' slip
COURSE_S = 2.5  # in which a road and its ruts go where the driver means to
WATER_M_S = 25.0  # speed at which a drag of water is its size
FRONT_LEFT, REAR_RIGHT, TRAILER_FRONT_RIGHT = 0, 3, 5
JOINT = 64  # power of a wave that leaves of it kicks, each a tenth of its length
WALL_M, FLOOR_M_S2 = 0.05, 0.5  # width of a rut's wall; friction of a smooth floor per mass
GAP_M = 2.0  # half the width of what presses air out of a gap, and so on its edge


@njit(cache=True)
def _beyond(value: float, at: float) -> float:
    """What of a value lies beyond `at`, on either side."""
    return math.copysign(max(abs(value) - at, 0.0), value)


@njit(cache=True)
def more_steer(
    g: Any, z: Any, rate: float, wheel: int, place: float, slip: float, out: Any
) -> float:
    """Steering of a wheel's axle by physics that nobody lists, rad; `slip` is without it.

    `place` is of a planar wheel in its body's frame, m.
    """
    if g[G_MORE] >= FIRST_NEWER:
        return float(newer_steer(g, z, wheel, slip, out))
    if g[G_MORE] in (
        WANDERING_RUTS, GROOVED_ROAD, LORRY_RUTS, SKEW_JOINTS, RUT_WALLS, WET_STRETCHES
    ):  # fmt: skip
        return float(_more_of_road(g, z, wheel, place, slip, out))
    if wheel >= 4:
        return float(_more_of_trailer_axles(g, z, wheel, slip, out))
    if wheel >= 2:
        return float(g[G_MORE_SIZE] * _more_of_rear_axle(g, z, wheel, slip, out))
    if g[G_MORE] == TRACK_ROD_END and wheel != FRONT_LEFT:
        return 0.0
    return float(g[G_MORE_SIZE] * _more_of_front_axle(g, z, rate, slip, out))


@njit(cache=True)
def _more_of_road(g: Any, z: Any, wheel: int, place: float, slip: float, out: Any) -> float:
    """The same of what lies along the road, or across it, under all wheels or the trailer's."""
    kind, size, at, angle = g[G_MORE], g[G_MORE_SIZE], g[G_MORE_AT], 0.0
    way = z[Z_MORE] + place - (0.0 if wheel < 4 else g[G_CAR_LEVER])
    if kind == WANDERING_RUTS:
        angle = size * math.sin(TURN * way / at)
    elif kind == SKEW_JOINTS:
        angle = size * math.cos(0.5 * TURN * way / at) ** JOINT
    elif kind == LORRY_RUTS:
        across = (z[Z_MORE + 1] + _across(g, z, wheel, place, out)) / at
        angle = -2.0 * size * across / (1.0 + across * across)
    elif kind == WET_STRETCHES:
        angle = size * max(math.sin(TURN * way / at), 0.0) * slip
    elif kind == RUT_WALLS:
        if wheel >= 4:
            beside = _beyond(_across(g, z, wheel, place, out), at)
            angle = -size * math.tanh(beside / WALL_M)
    else:
        heading = out[O_YAW1] if wheel < 4 else out[O_YAW2]
        angle = -size * at * math.tanh(heading / at)
    return float(angle)


@njit(cache=True)
def _across(g: Any, z: Any, wheel: int, place: float, out: Any) -> float:
    """Place of a point of a planar body to the left of the car's COG, across the road, m."""
    car = out[O_YAW1] - z[Z_MORE]
    if wheel < 4:
        return float(place * math.sin(car))
    return float(place * math.sin(out[O_YAW2] - z[Z_MORE]) - g[G_CAR_LEVER] * math.sin(car))


@njit(cache=True)
def _more_of_front_axle(g: Any, z: Any, rate: float, slip: float, out: Any) -> float:
    """The same of the car's front axle, over its size."""
    kind, angle = g[G_MORE], 0.0
    if kind in (
        LATE_ASSIST, DRIVER_ARMS, CROSSWIND_ASSIST, SEIZED_TOP_MOUNT, LOOSE_HANDS, LOOSE_SUBFRAME
    ):  # fmt: skip
        angle = z[Z_MORE]
    elif kind == LATE_CORRECTION:
        angle = -z[Z_MORE + 1]
    elif kind == TOW_ASSIST:
        angle = rate
    elif kind == VARIABLE_RATIO:
        angle = out[O_STEER] * abs(out[O_STEER])
    elif kind == LANE_ASSIST:
        angle = -out[O_YAW1]
    elif kind == PUMP_CATCH:
        angle = -_beyond((out[O_STEER] - z[Z_MORE]) / RATE_S, g[G_MORE_AT])
    elif kind == COUNTER_STEER:
        angle = g[G_MORE_AT] * math.tanh(out[O_RATE2] / g[G_MORE_AT])
    else:
        angle = _more_of_front_parts(g, z, slip, out)
    return float(angle)


@njit(cache=True)
def _more_of_front_parts(g: Any, z: Any, slip: float, out: Any) -> float:
    """The same of what is soft, bent or soiled there, and of its joints."""
    kind, angle = g[G_MORE], 0.0
    if kind == WISHBONE_BUSH:
        angle = _beyond(slip, g[G_MORE_AT])
    elif kind == HYDRO_BUSH:
        angle = z[Z_MORE] - slip
    elif kind == CLAY_TREAD:
        angle = (1.0 - z[Z_MORE]) * slip
    elif kind == RAG_JOINT:
        angle = z[Z_MORE] - out[O_STEER]
    elif kind == BENT_ARM:
        angle = abs(out[O_ROLL1])
    elif kind == BUMP_STEER:
        angle = out[O_ROLL1] ** 3
    elif kind == PUDDLES:
        angle = 0.5 * (1.0 + math.sin(TURN * z[Z_MORE] / g[G_MORE_AT])) * slip
    else:
        angle = _more_of_steering_joints(g, z, slip, out)
    return float(angle)


@njit(cache=True)
def _more_of_steering_joints(g: Any, z: Any, slip: float, out: Any) -> float:
    """The same of joints that are worn, or put together wrongly."""
    kind, angle = g[G_MORE], 0.0
    if kind == CROOKED_JOINT:
        angle = math.sin(out[O_STEER] * g[G_RATIO]) ** 2
    elif kind == SHIMMY:
        angle = 0.5 * z[Z_MORE]
    elif kind == TRACK_ROD_END:
        angle = math.tanh(slip / g[G_MORE_AT])
    return float(angle)


@njit(cache=True)
def _more_of_rear_axle(g: Any, z: Any, wheel: int, slip: float, out: Any) -> float:
    """The same of the car's rear axle, or of one wheel that is bent, over its size."""
    kind, angle = g[G_MORE], 0.0
    if kind == REAR_STEERS:
        angle = out[O_STEER]
    elif kind in (
        REAR_CONTROL, TOWBAR_TWIST, LEVELLING_PUMP, LINK_STEERING, STEPPER_REAR,
        LATE_REAR_STEERING, SUBFRAME_RUBBER, STICKY_BEAM,
    ):  # fmt: skip
        angle = z[Z_MORE]
    elif kind == QUICK_REAR:
        angle = g[G_MORE_AT] * math.tanh((out[O_STEER] - z[Z_MORE]) / (RATE_S * g[G_MORE_AT]))
    elif kind == REAR_BUSH_PLAY:
        angle = math.tanh(slip / g[G_MORE_AT])
    elif kind == BENT_RIM and wheel == REAR_LEFT:
        angle = math.sin(z[Z_MORE] / g[G_RADIUS])
    elif kind == BUMP_STOP_STEER:
        angle = _beyond(out[O_ROLL1], g[G_MORE_AT])
    elif kind == TOW_MODE:
        angle = g[G_MORE_AT] * math.tanh((out[O_YAW2] - out[O_YAW1]) / g[G_MORE_AT])
    elif kind == BROKEN_LINK:
        angle = z[Z_MORE] * out[O_ROLL1]
    else:
        angle = _more_of_rear_grip(g, z, wheel, slip, out)
    return float(angle)


@njit(cache=True)
def _more_of_rear_grip(g: Any, z: Any, wheel: int, slip: float, out: Any) -> float:
    """The same of tyres that hold less: one way, under a lean, on a rough road, without air."""
    kind, angle = g[G_MORE], 0.0
    if kind == WORN_SHOULDERS:
        angle = abs(slip)
    elif kind == BUMP_STOP_GRIP:
        angle = math.tanh(max(abs(out[O_ROLL1]) / g[G_MORE_AT] - 1.0, 0.0)) * slip
    elif kind == HOPPING_WHEELS:
        angle = max(math.sin(TURN * z[Z_MORE] / g[G_MORE_AT]), 0.0) * slip
    elif kind == SLOW_PUNCTURE and wheel == REAR_RIGHT:
        angle = z[Z_MORE] * slip
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
        CASTER_FLUTTER,
    ):  # fmt: skip
        angle = size * z[Z_MORE]
    elif kind == BUCKLED_WHEEL and wheel == TRAILER_FRONT_RIGHT:
        angle = size * math.sin(z[Z_MORE] / g[G_RADIUS])
    elif kind == TYRE_WARMING or (kind == PUNCTURE and wheel % 2 == 0):
        angle = size * z[Z_MORE] * slip
    else:
        angle = _more_of_trailer_frame(g, z, wheel, slip, out)
    return float(angle)


@njit(cache=True)
def _more_of_trailer_frame(g: Any, z: Any, wheel: int, slip: float, out: Any) -> float:
    """The same of what holds the axles or is led from the drawbar, and of what they roll on."""
    kind, size, angle = g[G_MORE], g[G_MORE_SIZE], 0.0
    if kind == RACKED_FRAME:
        angle = size * math.tanh(z[Z_MORE] / g[G_MORE_AT])
    elif kind == BROKEN_LEAF:
        angle = abs(size) * max(math.copysign(1.0, size) * out[O_ROLL2], 0.0)
    elif kind == SNOW_TRACKS:
        angle = size * math.tanh(((out[O_YAW2] - out[O_YAW1]) / g[G_MORE_AT]) ** 2) * slip
    elif kind == LEAKY_LINK:
        angle = size * (out[O_YAW2] - out[O_YAW1] - z[Z_MORE])
    elif kind == CREEPING_CLAMP:
        angle = z[Z_MORE]
    elif kind == WORKING_FRAME:
        angle = size * z[Z_MORE + 1]
    elif kind == SOFT_TYRE:
        leans = max(math.copysign(1.0, size) * out[O_ROLL2], 0.0)
        angle = abs(size) * math.tanh(leans / g[G_MORE_AT]) * slip
    else:
        angle = _more_of_trailer_grip(g, wheel, slip, out)
    return float(angle)


@njit(cache=True)
def _more_of_trailer_grip(g: Any, wheel: int, slip: float, out: Any) -> float:
    """The same of a tyre that rolls under, of tyres that carry all of a lean."""
    kind, size, angle = g[G_MORE], g[G_MORE_SIZE], 0.0
    if kind == ROLLED_UNDER:
        side = math.copysign(1.0, size)
        if (wheel % 2 == 0) == (side > 0.0):  # its force is inwards
            angle = size * max(side * slip, 0.0)
    elif kind == STOP_OVERLOAD:
        part = max(abs(out[O_ROLL2]) / g[G_MORE_AT] - 1.0, 0.0) ** 2
        angle = size * part / (1.0 + part) * slip
    return float(angle)


@njit(cache=True)
def more_moments(g: Any, z: Any, view: Any, trailer: int, out: Any) -> None:
    """Moments of physics that nobody lists."""
    if g[G_MORE] >= FIRST_NEWER:
        newer_moments(g, z, view, trailer, out)
        return
    hitch = int(g[G_HITCH_DOF])
    rate = view.qvel[hitch]
    view.qfrc[hitch] -= _more_at_hitch(g, z, rate, out)
    view.xfrc[trailer, 5] += _more_of_trailer(g, z, rate, out)
    view.xfrc[CAR, 5] += _more_of_car(g, z, rate, out)
    if g[G_MORE] == ELASTIC_DRAWBAR and g[G_FULL] == 0.0:  # a planar trailer's joint after the ball
        side = hitch + 1
        view.qfrc[side] -= g[G_MORE_SIZE] * (view.qpos[side] + DRAWBAR_S * view.qvel[side])
    if g[G_MORE] == BALL_RATTLE and g[G_FULL] == 0.0:
        side = hitch + 1
        pressed = _beyond(view.qpos[side], g[G_MORE_SIZE])
        meets = math.copysign(view.qvel[side], view.qvel[side] * pressed)
        view.qfrc[side] -= BALL_N_M * pressed * max(1.0 + BALL_S_M * meets, 0.0)
    if g[G_MORE] == SLIPPING_NECK and g[G_FULL] == 0.0:
        side = hitch + 1
        view.qfrc[side] -= g[G_MORE_AT] * z[Z_MORE] / SEAT_M
        view.qfrc[side] -= (view.qpos[side] + DRAWBAR_S * view.qvel[side]) / g[G_MORE_SIZE]


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
    else:
        moment = size * _more_at_ball(g, z, rate, out)
    return float(moment)


@njit(cache=True)
def _more_at_ball(g: Any, z: Any, rate: float, out: Any) -> float:
    """The same over its size: of what presses or leans on the ball, what lets go, and its pads.

    And of dents, of a motor, of what is touched on one side.
    """
    kind, at, moment = g[G_MORE], g[G_MORE_AT], 0.0
    if kind == BINDING_BALL:
        moment = abs(z[Z_MORE]) * math.tanh(rate / SLOW_RAD_S)
    elif kind == SPRING_BARS:
        moment = _beyond(out[O_ROLL2], at)
    elif kind == OUTWARD_DAMPER:
        moment = 0.5 * (rate + abs(rate) * math.tanh((out[O_YAW2] - out[O_YAW1]) / at))
    elif kind == BRINELLED_RING:
        moment = math.sin(TURN * (out[O_YAW2] - out[O_YAW1]) / at)
    elif kind == SERVO_BALL:
        moment = math.tanh(z[Z_MORE] / at)
    elif kind == TILTED_HEAD:
        moment = abs(out[O_ROLL2]) * math.tanh(rate / SLOW_RAD_S)
    elif kind == LOCKER_CORNER:
        side = math.copysign(1.0, g[G_MORE_SIZE])
        moment = max(side * (out[O_YAW2] - out[O_YAW1]) - at, 0.0)
    else:
        moment = _more_of_pads(g, rate, out)
    return float(moment)


@njit(cache=True)
def _more_of_pads(g: Any, rate: float, out: Any) -> float:
    """The same of pads that are damp, greased on one side, or worn on one; of a worn ball."""
    kind, at, moment = g[G_MORE], g[G_MORE_AT], 0.0
    rubs, side = math.tanh(rate / SLOW_RAD_S), math.copysign(1.0, g[G_MORE_SIZE])
    if kind == SQUEALING_PADS:
        moment = rubs / (1.0 + (rate / at) ** 2)
    elif kind == GREASY_BALL:
        moment = 0.5 * (side + math.tanh((out[O_YAW2] - out[O_YAW1]) / at)) * rubs
    elif kind == WORN_PAD:
        moment = side * rubs * (1.0 if side * rubs > 0.0 else at)
    elif kind == WORN_SPOT:
        part = ((out[O_YAW2] - out[O_YAW1]) / at) ** 2
        moment = rubs * part / (1.0 + part)
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
    elif kind == HUB_DRIVES:
        moment = size * z[Z_MORE]
    else:
        moment = _more_by_contact(g, z, r, out)
    return float(moment)


@njit(cache=True)
def _more_by_contact(g: Any, z: Any, r: float, out: Any) -> float:
    """The same of friction and tyres."""
    kind, size, at, moment = g[G_MORE], g[G_MORE_SIZE], g[G_MORE_AT], 0.0
    if kind == UNLOCKED_SLEW:
        moment = at * math.tanh(z[Z_MORE] / SLOW_RAD_S)
    elif kind == ALIGNING_TORQUE:
        slip = 0.25 * (out[O_SLIP + 4] + out[O_SLIP + 5] + out[O_SLIP + 6] + out[O_SLIP + 7])
        moment = size * slip / (1.0 + (slip / at) ** 2)
    elif kind == SOLENOID_BRAKES:
        moment = -size * z[Z_MORE] * math.tanh(r / SLOW_RAD_S)
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
    elif kind in (HUNTING_VECTORING, CURVE_BRAKE, ONE_WHEEL_BRAKE):
        moment = size * z[Z_MORE]
    elif kind == ANGLE_VECTORING:
        moment = size * math.tanh((out[O_YAW2] - out[O_YAW1]) / at)
    elif kind == SWAY_ASSIST:
        moment = -size * out[O_RATE1] * min(max(z[Z_MORE] / at - 1.0, 0.0), 1.0)
    elif kind == YAW_REFERENCE:
        v = out[O_SPEED]
        asked = v * out[O_STEER] / (ASKED_BASE_M * (1.0 + (v / ASKED_M_S) ** 2))
        moment = -size * _beyond(out[O_RATE1] - asked, at)
    elif kind == SIDESLIP_LIMITER:
        moment = size * _beyond(_sideslip(out), at)
    elif kind == LOOSE_HUB:
        moment = 0.5 * size * abs(out[O_SLIP] + out[O_SLIP + 1])
    return float(moment)


@njit(cache=True)
def more_lag(g: Any, z: Any, zdot: Any, rate: float, out: Any) -> None:
    """What is late, and the state of dry friction (after Dahl)."""
    kind, at = g[G_MORE], g[G_MORE_AT]
    if kind >= FIRST_NEWER:
        newer_lag(g, z, zdot, out)
    elif kind in (
        REAR_CONTROL, LATE_ASSIST, RUBBER_COUPLING, WIRE_STEERING, GYRO_STABILISER, HUB_DRIVES,
        LEVELLING_PUMP, LEAKY_LINK, LATE_REAR_STEERING,
    ):  # fmt: skip
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
    elif kind in (PUMP_CATCH, QUICK_REAR):
        zdot[Z_MORE] = (out[O_STEER] - z[Z_MORE]) / RATE_S
    elif kind == SWAY_ASSIST:
        zdot[Z_MORE] = (abs(out[O_RATE1]) - z[Z_MORE]) / SWAY_S
    else:
        _more_of_way(g, z, zdot, rate, out)
        _more_of_sway(g, z, zdot, out)
        _more_of_steering(g, z, zdot, rate, out)
        _more_of_motors(g, z, zdot, out)
        _more_that_stays(g, z, zdot, out)


@njit(cache=True)
def _more_of_steering(g: Any, z: Any, zdot: Any, rate: float, out: Any) -> None:
    """What steers a planar car, or turns it: in time, late, through play, what binds or rings."""
    kind, at, omega = g[G_MORE], g[G_MORE_AT], g[G_MORE_HZ]
    if kind == CROSSWIND_ASSIST:
        lateral = z[Z_ROLL] / g[G_CAR_ROLL_GAIN]
        zdot[Z_MORE] = min(max((lateral - z[Z_MORE]) / ACTUATOR_S, -at), at)
    elif kind == LINK_STEERING:
        zdot[Z_MORE] = _beyond(out[O_RATE2] - z[Z_MORE], at) / RATE_S
    elif kind == SEIZED_TOP_MOUNT:
        _stays_behind(g, z, zdot, -out[O_STEER])
    elif kind == LATE_CORRECTION:
        zdot[Z_MORE] = 2.0 * (out[O_RATE1] - z[Z_MORE]) / at
        zdot[Z_MORE + 1] = 2.0 * (z[Z_MORE] - z[Z_MORE + 1]) / at
    elif kind == STICKY_BEAM:
        rolls = z[Z_ROLL + 1]
        zdot[Z_MORE] = rolls - abs(rolls) * z[Z_MORE] / at
    elif kind == HUNTING_VECTORING:
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = omega * omega * (rate - z[Z_MORE])
        zdot[Z_MORE + 1] -= 2.0 * FLUTTER_DAMPING * omega * z[Z_MORE + 1]


@njit(cache=True)
def _more_of_motors(g: Any, z: Any, zdot: Any, out: Any) -> None:
    """What answers in steps, by a switch, beyond a threshold, or at the ball; a soft column."""
    kind, at, omega = g[G_MORE], g[G_MORE_AT], g[G_MORE_HZ]
    if kind == STEPPER_REAR:
        zdot[Z_MORE] = (at * math.floor(out[O_RATE1] / at + 0.5) - z[Z_MORE]) / SERVO_S
    elif kind == SERVO_BALL:
        zdot[Z_MORE] = (out[O_RATE2] - z[Z_MORE]) / SERVO_S
    elif kind == SOLENOID_BRAKES:
        on = 0.5 + 0.5 * math.tanh((abs(out[O_RATE2]) - at) / SWITCH_RAD_S)
        zdot[Z_MORE] = (on - z[Z_MORE]) / RELEASE_S
    elif kind == CURVE_BRAKE:
        lateral = z[Z_ROLL] / g[G_CAR_ROLL_GAIN]
        zdot[Z_MORE] = (_beyond(lateral, at) - z[Z_MORE]) / BRAKE_S
    elif kind == ONE_WHEEL_BRAKE:
        zdot[Z_MORE] = (_beyond(-out[O_RATE1], at) - z[Z_MORE]) / BRAKE_S
    elif kind == RAG_JOINT:
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = omega * omega * (out[O_STEER] - z[Z_MORE])
        zdot[Z_MORE + 1] -= 2.0 * FLUTTER_DAMPING * omega * z[Z_MORE + 1]


@njit(cache=True)
def _more_that_stays(g: Any, z: Any, zdot: Any, out: Any) -> None:
    """What has broken once, and the friction inside a stack."""
    if g[G_MORE] == BROKEN_LINK and abs(out[O_ROLL1]) > g[G_MORE_AT]:
        zdot[Z_MORE] = (1.0 - z[Z_MORE]) / BREAKS_S
    if g[G_MORE] == LEANING_STACK:
        leans = z[Z_SLOSH + 1]
        zdot[Z_MORE] = leans - abs(leans) * z[Z_MORE] / g[G_MORE_AT]


@njit(cache=True)
def _more_of_way(g: Any, z: Any, zdot: Any, rate: float, out: Any) -> None:
    """What goes with the distance or the place across the road, or with what pads have rubbed."""
    kind = g[G_MORE]
    if kind in (
        HEDGE_WIND, BENT_RIM, WANDERING_RUTS, CONCRETE_SLABS, PUDDLES, SOFT_VERGE, STANDING_WATER,
        HOPPING_WHEELS, BUCKLED_WHEEL, SKEW_JOINTS, WET_STRETCHES, GAP_HEADWIND,
    ):  # fmt: skip
        zdot[Z_MORE] = out[O_SPEED]
    elif kind == RUT_WALLS:  # they go where the car went, and so does a chord between the COGs
        course = math.atan2(out[O_CAR_VY], out[O_CAR_VX]) - z[Z_MORE]
        zdot[Z_MORE] = 2.0 * course * out[O_SPEED] / (g[G_CAR_LEVER] + g[G_TRAILER_LEVER])
    elif kind == LORRY_RUTS:
        course = math.atan2(out[O_CAR_VY], out[O_CAR_VX]) - z[Z_MORE]
        zdot[Z_MORE] = course / COURSE_S
        zdot[Z_MORE + 1] = out[O_SPEED] * math.sin(course) - z[Z_MORE + 1] / COURSE_S
    elif kind in (
        PUNCTURE, BINDING_BRAKE, LEAKING_LOAD, CLAY_TREAD, TEARING_CANVAS, LOOSENING_STRAPS,
        SLOW_PUNCTURE,
    ):  # fmt: skip
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
    if kind in (WIRE_STEERING, HUB_DRIVES, LATE_REAR_STEERING):
        return float(out[O_STEER])
    if kind == LEVELLING_PUMP:
        return float(out[O_ROLL1])
    return float(out[O_YAW2] - out[O_YAW1])


@njit(cache=True)
def _more_of_sway(g: Any, z: Any, zdot: Any, out: Any) -> None:
    """What a planar trailer's lateral acceleration moves: brakes, horses, eddies behind it.

    The last are an oscillator after van der Pol.
    """
    lateral = z[Z_ROLL + 2] / g[G_TRAILER_ROLL_GAIN]
    if g[G_MORE] in (SWAY_BRAKE, TORN_CABLE):
        zdot[Z_MORE] = (max(abs(lateral) - g[G_MORE_AT], 0.0) - z[Z_MORE]) / BRAKE_S
    if g[G_MORE] == ROLL_PROTECTION:
        zdot[Z_MORE] = (_beyond(lateral, g[G_MORE_AT]) - z[Z_MORE]) / BRAKE_S
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
def more_side(g: Any, z: Any, zdot: Any, beta: float, pressure: float, out: Any) -> float:
    """Side force of physics that nobody lists, on the car or the trailer, N.

    `beta` and `pressure` (half the air's density times speed squared) are of that body.
    """
    kind, size, omega = g[G_MORE], g[G_MORE_SIZE], g[G_MORE_HZ]
    if kind >= FIRST_NEWER:
        return float(newer_side(g, z, zdot, beta, pressure, out))
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
    if kind == LINGERING_FLOW:
        _stays_behind(g, z, zdot, beta)
    if kind == OPEN_DOOR:
        _turn_of_door(g, z, zdot, beta, out)
    return float(-size * pressure * _more_of_flow(g, z, beta, out))


@njit(cache=True)
def _turn_of_door(g: Any, z: Any, zdot: Any, beta: float, out: Any) -> None:
    """State of a door that the air at its place turns, as a vane."""
    omega = TURN * out[O_SPEED] / g[G_MORE_AT]
    zdot[Z_MORE] = z[Z_MORE + 1]
    zdot[Z_MORE + 1] = omega * omega * (_flow_at_door(beta, out) - z[Z_MORE])
    zdot[Z_MORE + 1] -= 2.0 * DOOR_DAMPING * omega * z[Z_MORE + 1]


@njit(cache=True)
def _flow_at_door(beta: float, out: Any) -> float:
    """Side-slip of the trailer's rear, rad."""
    return float(beta - DOOR_BEHIND_M * out[O_RATE2] / out[O_SPEED])


@njit(cache=True)
def _more_beside_air(g: Any, z: Any, beta: float, out: Any) -> float:
    """Side force of a loose rack, of a wheel at the nose, of mass that is lost, over its size."""
    if g[G_MORE] == REAR_RACK:
        return pull_of_rack(g, z)
    if g[G_MORE] == JOCKEY_WHEEL:
        slip = beta + acts_ahead(g) * out[O_RATE2] / out[O_SPEED]
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
    elif kind in (LATE_AIR, LINGERING_FLOW):
        angle = z[Z_MORE]
    elif kind == WAKE_SHEDDING:
        angle = -z[Z_MORE]
    elif kind == GAP_PUMP:
        angle = -(out[O_RATE2] - out[O_RATE1]) * GAP_M / out[O_SPEED]
    elif kind == CAR_WAKE:
        angle = -_sideslip(out)
    elif kind == GALLOPING:
        part = (beta / g[G_MORE_AT]) ** 2
        angle = -beta * (1.0 - part) / (1.0 + part)
    elif kind == OPEN_DOOR:
        angle = _flow_at_door(beta, out) - z[Z_MORE]
    elif kind == WIND_SHADOW:
        turned = out[O_YAW2] - out[O_YAW1]
        angle = -turned * abs(turned)
    else:
        angle = _more_of_canvas(g, z, beta)
    return float(angle)


@njit(cache=True)
def _more_of_canvas(g: Any, z: Any, beta: float) -> float:
    """The same of what the air fills, or of air that does not blow everywhere."""
    kind, angle = g[G_MORE], 0.0
    if kind in (ROOF_TENT, SLACK_TARPAULIN):
        angle = _beyond(beta, g[G_MORE_AT])
    elif kind == TEARING_CANVAS:
        angle = z[Z_MORE] * beta
    elif kind == GAP_HEADWIND:
        angle = 0.5 * (1.0 + math.sin(TURN * z[Z_MORE] / g[G_MORE_AT])) * beta
    elif kind == LOOSE_CURTAIN:
        angle = max(math.copysign(1.0, g[G_MORE_SIZE]) * beta, 0.0)
    return float(angle)


@njit(cache=True)
def _sideslip(out: Any) -> float:
    """Of the car's COG, rad."""
    c, s = math.cos(out[O_YAW1]), math.sin(out[O_YAW1])
    return math.atan2(c * out[O_CAR_VY] - s * out[O_CAR_VX], out[O_SPEED])


@njit(cache=True)
def pull_of_rack(g: Any, z: Any) -> float:
    """Acceleration with which the car's tail holds what swings or slides there, m/s2."""
    if g[G_MORE] == TAILGATE_CRATE:
        return float(pull_of_crate(g, z))
    omega = g[G_MORE_HZ]
    slides = g[G_MORE_AT] * math.tanh(z[Z_MORE + 1] / SLIDES_M_S)
    return float(omega * omega * z[Z_MORE] + slides)


@njit(cache=True)
def more_of_slip(g: Any, z: Any, zdot: Any, middle: float) -> None:
    """State of what follows the slip of axles, taken at their middle."""
    at = g[G_MORE_AT]
    if g[G_MORE] >= FIRST_NEWER:
        newer_of_slip(g, z, zdot, middle)
        return
    if g[G_MORE] == TYRE_WARMING:
        middle = math.tanh(abs(middle) / WORKED_RAD)
    if g[G_MORE] in (LOOSE_U_BOLTS, LOOSE_SUBFRAME):
        _stays_behind(g, z, zdot, middle)
        return
    if g[G_MORE] == CREEPING_CLAMP:
        zdot[Z_MORE] = g[G_MORE_SIZE] * _beyond(middle - z[Z_MORE], at)
        return
    if g[G_MORE] == CASTER_FLUTTER:
        omega = g[G_MORE_HZ]
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = omega * omega * (middle - z[Z_MORE])
        zdot[Z_MORE + 1] -= 2.0 * FLUTTER_DAMPING * omega * z[Z_MORE + 1]
        return
    if g[G_MORE] == SHIMMY:  # an oscillator after van der Pol
        omega, q = g[G_MORE_HZ], z[Z_MORE]
        zdot[Z_MORE] = z[Z_MORE + 1]
        zdot[Z_MORE + 1] = omega * omega * (SHIMMY_COUPLING * middle - q)
        zdot[Z_MORE + 1] -= SHIMMY_GROWTH * omega * (q * q - 1.0) * z[Z_MORE + 1]
        return
    zdot[Z_MORE] = (middle - z[Z_MORE]) / at


@njit(cache=True)
def more_of_pull(g: Any, z: Any, zdot: Any, pull: float) -> None:
    """State of what follows the pull of the ball, and of dry friction that it moves."""
    zdot[Z_MORE] = (pull - z[Z_MORE]) / TOWBAR_S
    if g[G_MORE] == WORKING_FRAME:
        zdot[Z_MORE + 1] = zdot[Z_MORE] - abs(zdot[Z_MORE]) * z[Z_MORE + 1] / g[G_MORE_AT]


@njit(cache=True)
def slips_in_seat(g: Any, z: Any, zdot: Any, view: Any) -> None:
    """State of the dry friction of a planar trailer's ball neck that moves sideways."""
    if g[G_MORE] == SLIPPING_NECK and g[G_FULL] == 0.0:
        rate = view.qvel[int(g[G_HITCH_DOF]) + 1]
        zdot[Z_MORE] = rate - abs(rate) * z[Z_MORE] / SEAT_M


@njit(cache=True)
def _stays_behind(g: Any, z: Any, zdot: Any, value: float) -> None:
    """State of dry friction that a value moves, by its rate."""
    change = (value - z[Z_MORE + 1]) / RATE_S
    zdot[Z_MORE] = change - abs(change) * z[Z_MORE] / g[G_MORE_AT]
    zdot[Z_MORE + 1] = change


@njit(cache=True)
def more_drag(g: Any, z: Any, wheel: Any, out: Any) -> float:
    """Drag of one wheel of the trailer, or of the car where water lies, N."""
    kind, size, drag = g[G_MORE], g[G_MORE_SIZE], 0.0
    if kind >= FIRST_NEWER:
        drag = newer_drag(g, z, wheel)
    elif kind == SWAY_BRAKE:
        drag = 0.25 * size * z[Z_MORE]
    elif kind == ROLL_PROTECTION:
        drag = size * max(-wheel[W_SIDE] * z[Z_MORE], 0.0)
    elif kind == BRAKE_CABLE and wheel[W_SIDE] < 0.0:
        turned = (out[O_YAW2] - out[O_YAW1]) * math.copysign(1.0, size)
        drag = 0.5 * abs(size) * max(turned, 0.0)
    elif kind == BINDING_BRAKE and wheel[W_SIDE] < 0.0:
        drag = 0.5 * size * z[Z_MORE]
    elif kind == TORN_CABLE and wheel[W_SIDE] < 0.0:
        drag = size * z[Z_MORE]
    elif kind == COCKED_OVERRUN and wheel[W_SIDE] > 0.0:
        drag = abs(size) * max(math.copysign(1.0, size) * z[Z_MORE] - g[G_MORE_AT], 0.0)
    elif kind == SOFT_VERGE and wheel[W_SIDE] < 0.0:
        drag = size * max(math.sin(TURN * z[Z_MORE] / g[G_MORE_AT]), 0.0)
    elif kind == STANDING_WATER and wheel[W_STEERED] > 0.0 and wheel[W_SIDE] > 0.0:
        drag = size * max(math.sin(TURN * z[Z_MORE] / g[G_MORE_AT]), 0.0)
        drag *= (out[O_SPEED] / WATER_M_S) ** 2
    return float(drag)


@njit(cache=True)
def stretch(g: Any, z: Any) -> float:
    """Of the spring that holds the cargo, m; one that rolls or slides is free between boards.

    Pads stiffen, as if they were pressed by more; friction alone holds a crate; horses step;
    slack straps hold less to their side, others less with the way; a hull rocks between rollers.
    What hangs meets walls; a part of what holds a stack is friction.
    """
    kind, at, q = g[G_MORE], g[G_MORE_AT], z[Z_SLOSH]
    held = q
    if kind in (ROLLING_LOAD, SLIDING_BOX):
        held = _beyond(q, at)
    elif kind == PADDED_LOAD:
        held = q * (1.0 + (q / at) ** 2)
    elif kind == STEPPING_HORSE:
        held = q - z[Z_MORE]
    elif kind == SLACK_LASHING:
        held = q * (abs(at) if q * at > 0.0 else 1.0)
    elif kind == LOOSENING_STRAPS:
        held = q * (1.0 - LOOSENED * z[Z_MORE])
    elif kind == ROCKING_HULL:
        held = at * math.tanh(q / at)
    elif kind == HANGING_LOAD:
        held = q + WALL * _beyond(q, at)
    elif kind == LEANING_STACK:
        held = (1.0 - STACK) * q + STACK * z[Z_MORE]
    elif kind == SLIDING_CRATE:
        held = 0.0
    return float(held)


@njit(cache=True)
def baffled(g: Any, z: Any) -> float:
    """Deceleration of a liquid by baffles, with the square of its rate, or by friction, m/s2."""
    if g[G_MORE] == BAFFLED_LIQUID:
        return float(abs(z[Z_SLOSH + 1]) * z[Z_SLOSH + 1] / g[G_MORE_AT])
    if g[G_MORE] == SLIDING_CRATE:
        return float(g[G_MORE_AT] * math.tanh(z[Z_SLOSH + 1] / SLIDES_M_S))
    if g[G_MORE] == SLIDING_BOX:
        return float(FLOOR_M_S2 * math.tanh(z[Z_SLOSH + 1] / SLIDES_M_S))
    return 0.0


@njit(cache=True)
def pull_behind(g: Any, z: Any) -> float:
    """Acceleration with which the second tank holds its liquid, m/s2."""
    omega = g[G_MORE_HZ]
    return float(omega * omega * z[Z_MORE] + 2.0 * g[G_SLOSH_ZETA] * omega * z[Z_MORE + 1])


@njit(cache=True)
def acts_ahead(g: Any) -> float:
    """Place of a side force ahead of its body's COG, m."""
    kind, ahead = g[G_MORE], newer_ahead(g)
    if kind == WAKE_SHEDDING:
        ahead = -EDDIES_BEHIND_M
    elif kind in (BOW_WAVE, GAP_PUMP):
        ahead = -TAIL_BEHIND_M
    elif kind in (CAR_WAKE, WIND_SHADOW, GAP_HEADWIND):
        ahead = NOSE_AHEAD_M
    elif kind == ROOF_TENT:
        ahead = -TENT_BEHIND_M
    elif kind == OPEN_DOOR:
        ahead = -DOOR_BEHIND_M
    elif kind in (LOOSE_CURTAIN, TEARING_CANVAS, SLACK_TARPAULIN):
        ahead = -CURTAIN_BEHIND_M
    elif kind in (LATE_AIR, LINGERING_FLOW):
        ahead = AIR_AHEAD_M
    elif kind == REAR_RACK:
        ahead = -g[G_CAR_LEVER]
    elif kind == JOCKEY_WHEEL:
        ahead = g[G_TRAILER_LEVER] - NOSE_BEHIND_BALL_M
    return float(ahead)
