"""Order of the numbers that the double-track kernel works on.

The kernel takes plain float arrays, so that changing a parameter never recompiles anything.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

AXLES = ("car_front", "car_rear", "trailer_front", "trailer_rear")
BODIES = ("car", "trailer")
WHEELS = ("fl", "fr", "rl", "rr")

# Global parameters -------------------------------------------------------------------------------
P_NAMES = (
    "m1", "iz1", "lh1", "m2", "iz2", "lh2", "has_trailer", "steering_ratio",
    "steering_stiffness",      # N/rad; 0: rigid
    "steering_gap",            # rad at the steering wheel; 0: none
    "steering_gap_law",        # 0: backlash, 1: dead zone, 2: castor
    "hitch_friction",          # N m
    "hitch_friction_rate",     # rad/s at which dry friction is 76 % developed
    "hitch_damping",           # N m s/rad
    "aero_side_force",         # trailer, 1/rad on q A
    "aero_yaw_moment",         # trailer, 1/rad on q A x 1 m
    "air_density", "aero_area",
    "car_drag_area", "trailer_drag_area",   # Cd A, m2
    "rolling_resistance",
    "gravity",
    "roll_gain_1", "roll_omega_1", "roll_zeta_1",   # rad/(m/s2), rad/s, 1
    "roll_gain_2", "roll_omega_2", "roll_zeta_2",
    "hitch_height_over_track_1",   # load transfer of the hitch force, 1
    "free_speed",              # 1: speed is a state under the controller, 0: prescribed
    "control_p", "control_i", "control_feed_forward", "control_lag",
    "drive_force_max",
    "heave",                   # 1: axle heave states are integrated
    "suspension_lag",          # s, lateral force from the axle to the car body
    "harmonic_mean_time",      # s, time constant of the high-pass of the 6.2 generator
    "harmonic_level_time",     # s, time constant of the level that the normalised form divides by
    "saturation_shape",        # Magic Formula shape factor C
)  # fmt: skip
P: Final = {name: index for index, name in enumerate(P_NAMES)}

# Per-axle parameters -----------------------------------------------------------------------------
A_NAMES = (
    "x",                # m ahead of the body's COG
    "half_track",       # m
    "load",             # N, static axle load
    "stiffness",        # N/rad of the axle at its static load
    "relaxation",       # m
    "peak_friction",    # 1; 0: force linear in slip
    "degression",       # 1
    "roll_steer",       # rad per rad of roll
    "transfer",         # N per (m/s2) of one wheel, in a steady turn
    "heave_mass",       # kg on the axle
    "heave_omega", "heave_zeta",
    "damping",          # N s/m of one damper at the wheel
    "damper_left", "damper_right",   # factors of the dampers
    "damper_asymmetry",  # (rebound - compression)/(rebound + compression), 0: symmetric
)  # fmt: skip
A: Final = {name: index for index, name in enumerate(A_NAMES)}

# Time windows: rows [kind, target, start, stop, a, b, c] -----------------------------------------
W_STIFFNESS, W_FRICTION, W_GUST, W_BANK, W_HARMONIC, W_GENERATOR, W_UNIT, W_BRAKE = range(8)
W_COLUMNS: Final = 7

# States ------------------------------------------------------------------------------------------
(
    S_VX, S_VY, S_R1, S_R2, S_THETA, S_ROLL1, S_ROLLRATE1, S_ROLL2, S_ROLLRATE2,
    S_SPEED_INTEGRAL, S_DRIVE, S_X, S_Y, S_PSI, S_LAG_Y, S_LAG_N,
) = range(16)  # fmt: skip
S_SLIP: Final = 16
"""First of eight slip states (tyre relaxation)."""
S_HEAVE: Final = 24
"""First of four axle heave states, followed by their four rates."""
STATES: Final = 32

# Outputs per sample ------------------------------------------------------------------------------
O_NAMES = (
    "speed", "car_lateral_velocity", "car_yaw_rate", "trailer_yaw_rate", "articulation",
    "car_roll", "car_roll_rate", "trailer_roll", "trailer_roll_rate",
    "car_acceleration_x", "car_acceleration_y", "car_yaw_acceleration",
    "trailer_acceleration_x", "trailer_acceleration_y", "trailer_yaw_acceleration",
    "hitch_longitudinal_force", "hitch_lateral_force", "hitch_moment",
    "drive_force", "road_wheel_angle", "x", "y", "yaw", "trailer_sideslip",
    "bank",
)  # fmt: skip
OUTPUT: Final = {name: index for index, name in enumerate(O_NAMES)}
O_FY: Final = len(O_NAMES)
O_FZ: Final = O_FY + 8
O_SLIP: Final = O_FZ + 8
OUTPUTS: Final = O_SLIP + 8


def target_number(name: str) -> int:
    """Axle or body as its number; ``trailer`` as an axle group is handled by the caller."""
    return AXLES.index(name) if name in AXLES else BODIES.index(name)
