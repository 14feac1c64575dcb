"""Names of the numbers that effects write into before a simulation (`models.physics`)."""

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
    "drawbar_stiffness",       # N/m, sideways at the ball; 0: rigid
    "aero_side_force",         # trailer, 1/rad on q A
    "aero_yaw_moment",         # trailer, 1/rad on q A x 1 m
    "roll_gain_1", "roll_omega_1", "roll_zeta_1",   # rad/(m/s2), rad/s, 1
    "roll_gain_2", "roll_omega_2", "roll_zeta_2",
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
    "damper",           # N s/m of one damper at the wheel
    "damper_left", "damper_right",   # factors of the dampers
    "softening",         # 1, of the stiffness with (force / load)^2
    "damper_asymmetry",  # (rebound - compression)/(rebound + compression), 0: symmetric
)  # fmt: skip
A: Final = {name: index for index, name in enumerate(A_NAMES)}

# Time windows: rows [kind, target, start, stop, a, b, c] -----------------------------------------
W_STIFFNESS, W_FRICTION, W_GUST, W_BANK, W_HARMONIC, W_GENERATOR, W_UNIT, W_BRAKE = range(8)
W_COLUMNS: Final = 7
