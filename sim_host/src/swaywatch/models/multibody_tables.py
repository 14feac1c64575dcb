"""Columns of the tables of the rigid-body plant; all are float64, SI.

:mod:`swaywatch.models.multibody` fills them, compiled code reads them.
"""

from __future__ import annotations

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
LOST_M_S2 = 1e4  # accelerations of a combination that has left the road
SPEED_GAIN, INTEGRAL_GAIN = 0.8, 0.2  # of the driver who holds the speed, 1/s and 1/s2
GRAVITY_M_S2 = 9.81
