"""Compiled equations of motion of the double-track model; used by :mod:`.double_track` only.

Generalised coordinates: the car's velocity (v_x, v_y) in its own axes, both yaw rates and the
articulation theta = psi_2 - psi_1, all angles of any size. With the ball forces eliminated, the
equations of Newton and Euler for the two bodies are ``M q'' = f`` with the symmetric matrix

    [ m1+m2        0              0                    m2 lh2 s     ]   v_x'
    [ 0            m1+m2         -m2 lh1              -m2 lh2 c     ]   v_y'
    [ 0           -m2 lh1         Iz1 + m2 lh1^2       m2 lh1 lh2 c ]   psi_1''
    [ m2 lh2 s    -m2 lh2 c       m2 lh1 lh2 c         Iz2+m2 lh2^2 ]   psi_2''

with c, s = cos, sin theta. The ball force follows from the trailer's balance afterwards.
"""

from __future__ import annotations

import math

import numpy as np

from swaywatch.models.compiled import inlined, kernel
from swaywatch.models.layout import (
    O_FY,
    O_FZ,
    O_SLIP,
    OUTPUTS,
    S_DRIVE,
    S_HEAVE,
    S_LAG_N,
    S_LAG_Y,
    S_PSI,
    S_R1,
    S_R2,
    S_ROLL1,
    S_ROLL2,
    S_ROLLRATE1,
    S_ROLLRATE2,
    S_SLIP,
    S_SPEED_INTEGRAL,
    S_THETA,
    S_VX,
    S_VY,
    S_X,
    S_Y,
    STATES,
    W_BANK,
    W_BRAKE,
    W_FRICTION,
    W_GENERATOR,
    W_GUST,
    W_HARMONIC,
    W_STIFFNESS,
    W_UNIT,
    A,
    Array,
    P,
)
from swaywatch.models.physics.hitch_damping import moment as damping_moment
from swaywatch.models.physics.hitch_friction import moment as friction_moment
from swaywatch.models.physics.road_bank import side_force as bank_force
from swaywatch.models.physics.roll_steer import angle as roll_steer_angle
from swaywatch.models.physics.steering_compliance import angle_lost
from swaywatch.models.physics.steering_free_play import castor, follow
from swaywatch.models.physics.trailer_aerodynamics import side_force as aero_side_force
from swaywatch.models.physics.trailer_aerodynamics import yaw_moment as aero_yaw_moment
from swaywatch.models.physics.tyre_load_sensitivity import stiffness as load_stiffness
from swaywatch.models.physics.tyre_relaxation import slip_rate
from swaywatch.models.physics.tyre_saturation import lateral_force

# Offsets as plain integers, which the compiler folds.
P_M1, P_IZ1, P_LH1, P_M2, P_IZ2, P_LH2 = (P[n] for n in ("m1", "iz1", "lh1", "m2", "iz2", "lh2"))
P_TRAILER, P_RATIO = P["has_trailer"], P["steering_ratio"]
P_KS, P_GAP, P_LAW = P["steering_stiffness"], P["steering_gap"], P["steering_gap_law"]
P_FRICTION, P_FRICTION_RATE = P["hitch_friction"], P["hitch_friction_rate"]
P_DAMPING, P_AERO_Y, P_AERO_N = P["hitch_damping"], P["aero_side_force"], P["aero_yaw_moment"]
P_RHO, P_AREA, P_DRAG1, P_DRAG2 = (
    P[n] for n in ("air_density", "aero_area", "car_drag_area", "trailer_drag_area")
)
P_ROLLING, P_G = P["rolling_resistance"], P["gravity"]
P_GAIN1, P_OMEGA1, P_ZETA1 = P["roll_gain_1"], P["roll_omega_1"], P["roll_zeta_1"]
P_GAIN2, P_OMEGA2, P_ZETA2 = P["roll_gain_2"], P["roll_omega_2"], P["roll_zeta_2"]
P_HITCH_ROLL, P_FREE = P["hitch_height_over_track_1"], P["free_speed"]
P_CP, P_CI, P_CF, P_CLAG = (
    P[n] for n in ("control_p", "control_i", "control_feed_forward", "control_lag")
)
P_DRIVE_MAX, P_HEAVE, P_LAG = P["drive_force_max"], P["heave"], P["suspension_lag"]
P_MEAN, P_LEVEL, P_SHAPE = (
    P["harmonic_mean_time"], P["harmonic_level_time"], P["saturation_shape"],
)  # fmt: skip
A_X, A_T, A_LOAD, A_C = A["x"], A["half_track"], A["load"], A["stiffness"]
A_SIGMA, A_MU, A_DEG, A_RS = A["relaxation"], A["peak_friction"], A["degression"], A["roll_steer"]
A_TRANSFER, A_HM, A_HW, A_HZ = (
    A["transfer"], A["heave_mass"], A["heave_omega"], A["heave_zeta"],
)  # fmt: skip
A_DAMP, A_DL, A_DR, A_ASYM = (
    A["damping"], A["damper_left"], A["damper_right"], A["damper_asymmetry"],
)  # fmt: skip

# What holds during one step: stiffness factors of the axles, friction factor, gust force and moment
# on both bodies, bank, brake forces of both bodies.
(C_MU, C_GUST, C_BANK, C_BRAKE, C_SIZE) = (4, 5, 9, 10, 12)

FLOOR_YAW = 1e-6
FLOOR_FRICTION = 2.5e-5
"""Mean squares, (rad/s)^2 and 1, below which the normalised generator fades out."""
SHORT_RELAXATION = 0.02
"""Relaxation lengths in m below this act as none."""


@inlined
def damper_extra(rate: float, damping: float, factor: float, asymmetry: float) -> float:
    """Force of a faulty damper in N beyond that of the healthy one; rate > 0 extends it."""
    sign = 1.0 if rate > 0.0 else -1.0
    return damping * rate * (factor * (1.0 + asymmetry * sign) - 1.0)


@inlined
def wheel_loads(y: Array, p: Array, ax: Array, extra: Array, fz: Array, asym: Array) -> None:
    """Vertical loads of the eight wheels; ``asym`` gets the extra damper forces per wheel."""
    for axle in range(4):
        body = axle // 2
        roll = y[S_ROLL1 + 2 * body]
        gain = p[P_GAIN1] if body == 0 else p[P_GAIN2]
        transfer = ax[axle, A_TRANSFER] * roll / gain
        left = 0.5 * ax[axle, A_LOAD] - transfer + extra[2 * axle]
        right = 0.5 * ax[axle, A_LOAD] + transfer + extra[2 * axle + 1]
        if p[P_HEAVE] > 0.0 and ax[axle, A_HM] > 0.0:
            z, z_rate = y[S_HEAVE + axle], y[S_HEAVE + 4 + axle]
            swing = y[S_ROLLRATE1 + 2 * body] * ax[axle, A_T]
            omega = ax[axle, A_HW]
            spring = (
                0.5 * ax[axle, A_HM] * (omega * omega * z + 2.0 * ax[axle, A_HZ] * omega * z_rate)
            )
            asym[2 * axle] = damper_extra(
                z_rate + swing, ax[axle, A_DAMP], ax[axle, A_DL], ax[axle, A_ASYM]
            )
            asym[2 * axle + 1] = damper_extra(
                z_rate - swing, ax[axle, A_DAMP], ax[axle, A_DR], ax[axle, A_ASYM]
            )
            left -= spring + asym[2 * axle]
            right -= spring + asym[2 * axle + 1]
        fz[2 * axle] = max(left, 0.0)
        fz[2 * axle + 1] = max(right, 0.0)


@inlined
def wheel_force(
    wheel: int, slip: float, y: Array, p: Array, ax: Array, step: Array, fz: Array
) -> float:
    """Side force in N of one wheel in its own axes from its geometric slip angle."""
    axle = wheel // 2
    half = 0.5 * ax[axle, A_LOAD]
    if half <= 0.0 or ax[axle, A_C] <= 0.0:
        return 0.0
    stiffness = load_stiffness(0.5 * ax[axle, A_C] * step[axle], fz[wheel], half, ax[axle, A_DEG])
    used = y[S_SLIP + wheel] if ax[axle, A_SIGMA] > SHORT_RELAXATION else slip
    return lateral_force(stiffness, used, fz[wheel], ax[axle, A_MU] * step[C_MU], p[P_SHAPE])


@inlined
def front_angle(
    nominal: float, beta_left: float, beta_right: float,
    y: Array, p: Array, ax: Array, step: Array, fz: Array,
) -> float:  # fmt: skip
    """Road-wheel angle under steering compliance: Newton on delta + F_y(delta)/K_s = nominal."""
    if p[P_KS] <= 0.0:
        return nominal
    delta = nominal
    if ax[0, A_SIGMA] > SHORT_RELAXATION:
        force = wheel_force(0, 0.0, y, p, ax, step, fz) + wheel_force(1, 0.0, y, p, ax, step, fz)
        return nominal - angle_lost(force, p[P_KS])
    slope = 1.0 + ax[0, A_C] * step[0] / p[P_KS]
    for _ in range(4):
        force = wheel_force(0, delta - beta_left, y, p, ax, step, fz) + wheel_force(
            1, delta - beta_right, y, p, ax, step, fz
        )
        delta -= (delta - nominal + angle_lost(force, p[P_KS])) / slope
    return delta


@inlined
def axle_forces(
    axle: int, u: float, v: float, r: float, angle: float,
    y: Array, dy: Array, p: Array, ax: Array, step: Array,
    fy: Array, fz: Array, slips: Array, forces: Array,
) -> None:  # fmt: skip
    """Add one axle's force and moment to its body's (x, y, n) in ``forces``."""
    base = 3 * (axle // 2)
    for side in range(2):
        wheel = 2 * axle + side
        lever = ax[axle, A_T] if side == 0 else -ax[axle, A_T]
        u_wheel = u - r * lever
        slip = angle - math.atan2(v + r * ax[axle, A_X], u_wheel)
        slips[wheel] = slip
        force = wheel_force(wheel, slip, y, p, ax, step, fz)
        fy[wheel] = force
        fx_body = -force * math.sin(angle) - p[P_ROLLING] * fz[wheel]
        fy_body = force * math.cos(angle)
        forces[base] += fx_body
        forces[base + 1] += fy_body
        forces[base + 2] += ax[axle, A_X] * fy_body - lever * fx_body
        if ax[axle, A_SIGMA] > SHORT_RELAXATION:
            dy[S_SLIP + wheel] = slip_rate(slip, y[S_SLIP + wheel], abs(u_wheel), ax[axle, A_SIGMA])
        else:
            dy[S_SLIP + wheel] = 0.0


@inlined
def tyre_forces(
    steering: float, vx2: float, vy2: float,
    y: Array, dy: Array, p: Array, ax: Array, step: Array,
    fy: Array, fz: Array, slips: Array, forces: Array,
) -> float:  # fmt: skip
    """Forces of all axles in their bodies' axes; returns the road-wheel angle."""
    vx, vy, r1 = y[S_VX], y[S_VY], y[S_R1]
    forces[:] = 0.0
    front = roll_steer_angle(y[S_ROLL1], ax[0, A_RS])
    sideways = vy + r1 * ax[0, A_X]
    left = math.atan2(sideways, vx - r1 * ax[0, A_T]) - front
    right = math.atan2(sideways, vx + r1 * ax[0, A_T]) - front
    nominal = steering / p[P_RATIO]
    if p[P_LAW] == 2.0:
        nominal = castor(nominal, 0.5 * (left + right), 0.5 * p[P_GAP] / p[P_RATIO])
    delta = front_angle(nominal, left, right, y, p, ax, step, fz)
    axle_forces(0, vx, vy, r1, delta + front, y, dy, p, ax, step, fy, fz, slips, forces)
    rear = roll_steer_angle(y[S_ROLL1], ax[1, A_RS])
    axle_forces(1, vx, vy, r1, rear, y, dy, p, ax, step, fy, fz, slips, forces)
    if p[P_TRAILER] > 0.0:
        for axle in range(2, 4):
            angle = roll_steer_angle(y[S_ROLL2], ax[axle, A_RS])
            axle_forces(axle, vx2, vy2, y[S_R2], angle, y, dy, p, ax, step, fy, fz, slips, forces)
    return delta


@inlined
def other_forces(
    vx2: float, vy2: float, c: float, s: float,
    y: Array, dy: Array, p: Array, step: Array, forces: Array,
) -> float:  # fmt: skip
    """Add air, brake, bank, gust and drive; returns the trailer's side-slip angle."""
    if p[P_LAG] > 0.0:  # the car's side force reaches its body with a lag
        dy[S_LAG_Y] = (forces[1] - y[S_LAG_Y]) / p[P_LAG]
        dy[S_LAG_N] = (forces[2] - y[S_LAG_N]) / p[P_LAG]
        forces[1] = y[S_LAG_Y]
        forces[2] = y[S_LAG_N]
    pressure = 0.5 * p[P_RHO] * y[S_VX] * y[S_VX]
    drive = y[S_DRIVE] if p[P_FREE] > 0.0 else 0.0
    forces[0] += drive - pressure * p[P_DRAG1] - step[C_BRAKE]
    forces[1] += bank_force(p[P_M1], p[P_G], step[C_BANK]) + step[C_GUST]
    forces[2] += step[C_GUST + 1]
    if p[P_TRAILER] <= 0.0:
        return 0.0
    beta = math.atan2(vy2, vx2)
    q_area = 0.5 * p[P_RHO] * (vx2 * vx2 + vy2 * vy2) * p[P_AREA]
    # Weight along the slope, in the trailer's axes (the slope is across the car's heading).
    slope = bank_force(p[P_M2], p[P_G], step[C_BANK])
    forces[3] += s * slope - pressure * p[P_DRAG2] - step[C_BRAKE + 1]
    forces[4] += c * slope + step[C_GUST + 2] + aero_side_force(q_area, beta, p[P_AERO_Y])
    forces[5] += step[C_GUST + 3] + aero_yaw_moment(q_area, beta, p[P_AERO_N])
    return beta


@inlined
def solve_car(speed_rate: float, y: Array, dy: Array, p: Array, forces: Array, o: Array) -> None:
    """Accelerations of a car alone."""
    vx_dot = speed_rate
    if p[P_FREE] > 0.0:
        vx_dot = forces[0] / p[P_M1] + y[S_VY] * y[S_R1]
    dy[S_VX] = vx_dot
    dy[S_VY] = forces[1] / p[P_M1] - y[S_VX] * y[S_R1]
    dy[S_R1] = forces[2] / p[P_IZ1]
    dy[S_R2] = 0.0
    dy[S_THETA] = 0.0
    for q in range(12, 18):
        o[q] = 0.0


@inlined
def solve_combination(
    speed_rate: float, c: float, s: float, y: Array, dy: Array, p: Array, forces: Array, o: Array
) -> None:
    """Accelerations of both bodies and the ball's force: M q'' = f of the module's text."""
    m1, lh1, m2, lh2 = p[P_M1], p[P_LH1], p[P_M2], p[P_LH2]
    vx, vy, r1, r2 = y[S_VX], y[S_VY], y[S_R1], y[S_R2]
    x2, y2 = forces[3], forces[4]
    hitch = friction_moment(r2 - r1, p[P_FRICTION], p[P_FRICTION_RATE]) + damping_moment(
        r2 - r1, p[P_DAMPING]
    )
    kx = -vy * r1 + lh1 * r1 * r1
    ky = vx * r1
    side = s * x2 + c * y2
    mt = m1 + m2
    turn = ky + s * lh2 * r2 * r2
    f_x = forces[0] + c * x2 - s * y2 + m1 * vy * r1 - m2 * (kx + c * lh2 * r2 * r2)
    f_y = forces[1] + side - m1 * vx * r1 - m2 * turn
    f_1 = forces[2] + hitch - lh1 * side + m2 * lh1 * turn
    f_2 = forces[5] - hitch - lh2 * y2 + m2 * lh2 * (c * ky - s * kx)
    a12 = -m2 * lh1
    a13 = -m2 * lh2 * c
    cross = m2 * lh2 * s
    a33 = p[P_IZ2] + m2 * lh2 * lh2
    if p[P_FREE] > 0.0:
        a33 -= cross * cross / mt
        f_2 -= cross * f_x / mt
    else:
        f_2 -= cross * speed_rate
    # Elimination of a symmetric 3 x 3 system with pivot mt.
    b22 = p[P_IZ1] + m2 * lh1 * lh1 - a12 * a12 / mt
    b23 = m2 * lh1 * lh2 * c - a12 * a13 / mt
    b33 = a33 - a13 * a13 / mt
    g1 = f_1 - a12 * f_y / mt
    g2 = f_2 - a13 * f_y / mt
    det = b22 * b33 - b23 * b23
    r1_dot = (b33 * g1 - b23 * g2) / det
    r2_dot = (b22 * g2 - b23 * g1) / det
    vy_dot = (f_y - a12 * r1_dot - a13 * r2_dot) / mt
    vx_dot = (f_x - cross * r2_dot) / mt if p[P_FREE] > 0.0 else speed_rate
    ahx = vx_dot + kx
    ahy = vy_dot + ky - lh1 * r1_dot
    o[12] = c * ahx + s * ahy + lh2 * r2 * r2
    o[13] = -s * ahx + c * ahy - lh2 * r2_dot
    o[14] = r2_dot
    h2x = x2 - m2 * o[12]
    h2y = y2 - m2 * o[13]
    o[15] = c * h2x - s * h2y
    o[16] = s * h2x + c * h2y
    o[17] = hitch
    dy[S_VX] = vx_dot
    dy[S_VY] = vy_dot
    dy[S_R1] = r1_dot
    dy[S_R2] = r2_dot
    dy[S_THETA] = r2 - r1


@inlined
def roll_rates(c: float, y: Array, dy: Array, p: Array, step: Array, o: Array) -> None:
    """Roll of both bodies; what tilts them is what an accelerometer would feel."""
    g_bank = p[P_G] * math.sin(step[C_BANK])
    push = o[10] + g_bank - p[P_HITCH_ROLL] * o[16] / p[P_M1]
    dy[S_ROLL1] = y[S_ROLLRATE1]
    dy[S_ROLLRATE1] = (
        p[P_OMEGA1] * p[P_OMEGA1] * (p[P_GAIN1] * push - y[S_ROLL1])
        - 2.0 * p[P_ZETA1] * p[P_OMEGA1] * y[S_ROLLRATE1]
    )
    dy[S_ROLL2] = y[S_ROLLRATE2]
    dy[S_ROLLRATE2] = (
        p[P_OMEGA2] * p[P_OMEGA2] * (p[P_GAIN2] * (o[13] + c * g_bank) - y[S_ROLL2])
        - 2.0 * p[P_ZETA2] * p[P_OMEGA2] * y[S_ROLLRATE2]
    )


@inlined
def speed_rates(
    speed_rate: float, reference: float, y: Array, dy: Array, p: Array, forces: Array, o: Array
) -> float:
    """Speed control: PI on the speed, feed-forward on the deceleration (Eq. 5.1-5.2).

    Returns the drive force: the controller's, or what the prescribed speed takes.
    """
    if p[P_FREE] <= 0.0:
        dy[S_SPEED_INTEGRAL] = 0.0
        dy[S_DRIVE] = 0.0
        return float(p[P_M1] * o[9] - forces[0] - o[15])
    error = reference - y[S_VX]
    dy[S_SPEED_INTEGRAL] = error
    pressure = 0.5 * p[P_RHO] * y[S_VX] * y[S_VX]
    mass = p[P_M1] + p[P_M2]
    wanted = (
        p[P_CP] * error + p[P_CI] * y[S_SPEED_INTEGRAL]
        + pressure * (p[P_DRAG1] + p[P_DRAG2]) + p[P_ROLLING] * mass * p[P_G]
        + mass * speed_rate + p[P_CF] * mass * (speed_rate - dy[S_VX])
    )  # fmt: skip
    wanted = min(max(wanted, -p[P_DRIVE_MAX]), p[P_DRIVE_MAX])
    dy[S_DRIVE] = (wanted - y[S_DRIVE]) / p[P_CLAG]
    return float(y[S_DRIVE])


@inlined
def derivative(
    y: Array, dy: Array, p: Array, ax: Array, step: Array, extra: Array,
    steering: float, speed_rate: float, reference: float,
    fy: Array, fz: Array, slips: Array, asym: Array, forces: Array, o: Array,
) -> None:  # fmt: skip
    """Rates of all states; forces, slips and accelerations land in the scratch arrays."""
    c, s = math.cos(y[S_THETA]), math.sin(y[S_THETA])
    vh = y[S_VY] - p[P_LH1] * y[S_R1]
    vx2 = c * y[S_VX] + s * vh
    vy2 = c * vh - s * y[S_VX] - p[P_LH2] * y[S_R2]
    wheel_loads(y, p, ax, extra, fz, asym)
    o[19] = tyre_forces(steering, vx2, vy2, y, dy, p, ax, step, fy, fz, slips, forces)
    o[23] = other_forces(vx2, vy2, c, s, y, dy, p, step, forces)
    if p[P_TRAILER] > 0.0:
        solve_combination(speed_rate, c, s, y, dy, p, forces, o)
    else:
        solve_car(speed_rate, y, dy, p, forces, o)
    o[9] = dy[S_VX] - y[S_VY] * y[S_R1]
    o[10] = dy[S_VY] + y[S_VX] * y[S_R1]
    o[11] = dy[S_R1]
    roll_rates(c, y, dy, p, step, o)
    if p[P_HEAVE] > 0.0:
        heave_rates(y, dy, p, ax, asym)
    o[18] = speed_rates(speed_rate, reference, y, dy, p, forces, o)
    cos_psi, sin_psi = math.cos(y[S_PSI]), math.sin(y[S_PSI])
    dy[S_X] = y[S_VX] * cos_psi - y[S_VY] * sin_psi
    dy[S_Y] = y[S_VX] * sin_psi + y[S_VY] * cos_psi
    dy[S_PSI] = y[S_R1]


@inlined
def record(row: Array, y: Array, step: Array, fy: Array, fz: Array, slips: Array, o: Array) -> None:
    """One row of outputs: states, accelerations and forces, wheels."""
    for q in range(9):
        row[q] = y[q]
    for q in range(9, 20):
        row[q] = o[q]
    row[20] = y[S_X]
    row[21] = y[S_Y]
    row[22] = y[S_PSI]
    row[23] = o[23]
    row[24] = step[C_BANK]
    for q in range(8):
        row[O_FY + q] = fy[q]
        row[O_FZ + q] = fz[q]
        row[O_SLIP + q] = slips[q]


@inlined
def heave_rates(y: Array, dy: Array, p: Array, ax: Array, asym: Array) -> None:
    """Heave of the body over each axle, and what the extra damper forces do to roll."""
    for body in range(2):
        gain = p[P_GAIN1] if body == 0 else p[P_GAIN2]
        omega_roll = p[P_OMEGA1] if body == 0 else p[P_OMEGA2]
        stiffness = 0.0
        moment = 0.0
        for axle in range(2 * body, 2 * body + 2):
            t = ax[axle, A_T]
            stiffness += 2.0 * t * ax[axle, A_TRANSFER] / gain
            moment += t * (asym[2 * axle + 1] - asym[2 * axle])
            z, z_rate = y[S_HEAVE + axle], y[S_HEAVE + 4 + axle]
            dy[S_HEAVE + axle] = z_rate
            if ax[axle, A_HM] > 0.0:
                omega = ax[axle, A_HW]
                dy[S_HEAVE + 4 + axle] = (
                    -omega * omega * z
                    - 2.0 * ax[axle, A_HZ] * omega * z_rate
                    - (asym[2 * axle] + asym[2 * axle + 1]) / ax[axle, A_HM]
                )
            else:
                dy[S_HEAVE + 4 + axle] = 0.0
        if stiffness > 0.0:
            dy[S_ROLLRATE1 + 2 * body] += moment * omega_roll * omega_roll / stiffness


@inlined
def ramp(t: float, start: float, stop: float, rise: float) -> float:
    """0 outside a window, 1 inside, cosine flanks of length ``rise`` inside it."""
    if t < start or t >= stop:
        return 0.0
    if rise <= 0.0:
        return 1.0
    edge = min(t - start, stop - t) / rise
    return 1.0 if edge >= 1.0 else 0.5 - 0.5 * math.cos(math.pi * edge)


@inlined
def conditions(t: float, windows: Array, step: Array) -> None:
    """Fill what holds during the step at time t from the windows."""
    step[:] = 0.0
    step[0] = 1.0
    step[1] = 1.0
    step[2] = 1.0
    step[3] = 1.0
    step[C_MU] = 1.0
    for k in range(windows.shape[0]):
        kind, target = int(windows[k, 0]), int(windows[k, 1])
        start, stop, a, b = windows[k, 2], windows[k, 3], windows[k, 4], windows[k, 5]
        if t < start or t >= stop:
            continue
        if kind == W_STIFFNESS:
            step[target] *= a
        elif kind == W_FRICTION:
            step[C_MU] *= a
        elif kind == W_GUST:
            share = ramp(t, start, stop, windows[k, 6])
            step[C_GUST + 2 * target] += a * share
            step[C_GUST + 2 * target + 1] += b * share
        elif kind == W_BANK:
            step[C_BANK] += a * ramp(t, start, stop, windows[k, 6])
        elif kind == W_BRAKE:
            step[C_BRAKE + target] += a * ramp(t, start, stop, windows[k, 6])


@inlined
def harmonic_loads(
    t: float, n: int, h: float, windows: Array, history: Array, r1: float, extra: Array
) -> None:
    """Extra wheel loads of the generator of 6.2 from the references up to step n."""
    extra[:] = 0.0
    length = history.shape[1]
    for k in range(windows.shape[0]):
        kind, axle = int(windows[k, 0]), int(windows[k, 1])
        if kind not in (W_GENERATOR, W_UNIT, W_HARMONIC):
            continue
        if t < windows[k, 2] or t >= windows[k, 3]:
            continue
        source = 2 + axle if kind == W_HARMONIC else (0 if kind == W_GENERATOR else 1)
        back = windows[k, 5] / h
        whole = int(back)
        first = max(n - whole, 0)
        second = max(first - 1, 0)
        part = back - whole
        value = (1.0 - part) * history[source, first % length] + part * history[
            source, second % length
        ]
        wheel = 2 * axle if r1 < 0.0 else 2 * axle + 1
        extra[wheel] += windows[k, 4] * value


@inlined
def remember(
    n: int, h: float, p: Array, r1: float, fy: Array, fz: Array, means: Array, history: Array
) -> None:
    """Advance the high-pass of the references: yaw rate squared, friction used squared.

    Friction (side force over load) stands for the side force: the load that is made from it does
    not distort it. Rows of ``means``: mean, level, for the yaw rate and the four axles.
    """
    if history.shape[1] == 1:
        return
    share = 1.0 - math.exp(-h / p[P_MEAN])
    slow = 1.0 - math.exp(-h / p[P_LEVEL])
    for k in range(5):
        value = r1
        floor = FLOOR_YAW
        if k > 0:
            load = fz[2 * k - 2] + fz[2 * k - 1]
            value = (fy[2 * k - 2] + fy[2 * k - 1]) / max(load, 1.0)
            floor = FLOOR_FRICTION
        square = value * value
        if n == 0:
            means[0, k] = square
            means[1, k] = square
        means[0, k] += share * (square - means[0, k])
        means[1, k] += slow * (square - means[1, k])
        history[1 + k, n % history.shape[1]] = (square - means[0, k]) / (means[1, k] + floor)
    history[0, n % history.shape[1]] = r1 * r1 - means[0, 0]


@inlined
def inside(y: Array) -> bool:
    """False once the motion has left all bounds (also for NaN)."""
    return bool(abs(y[S_R2]) < 20.0 and abs(y[S_VY]) < 200.0 and abs(y[S_THETA]) < 3.2)


@kernel
def simulate(
    start_time: float, spacing: float, sub: int, steering: Array, speed: Array, speed_rate: Array,
    p: Array, ax: Array, windows: Array,
    y: Array, history: Array, means: Array, memory: Array,
) -> Array:  # fmt: skip
    """Integrate with classical Runge-Kutta; one row of outputs per input sample.

    Called again with the last input sample as the first, and what it left in ``y``, ``history``,
    ``means`` and ``memory``, it goes on as if it had never stopped.

    Parameters
    ----------
    spacing : s between input samples; each is cut into ``sub`` steps
    steering, speed, speed_rate : (n,) arrays, linear between samples
    windows : (k, 7) array
    y : (STATES,) array, the state, changed
    history : (6, length) ring of references that covers the longest delay; length 1 if the windows
        hold no load generator
    means : (2, 5) array of the references' means
    memory : [steps done, steering angle behind the free play]

    Returns
    -------
    (n, OUTPUTS) array; rows of NaN from where the motion left all bounds
    """
    count = steering.size
    out = np.full((count, OUTPUTS), np.nan)
    rates = np.zeros((4, STATES))
    z = np.zeros(STATES)
    step = np.zeros(C_SIZE)
    extra = np.zeros(8)
    fy = np.zeros(8)
    fz = np.zeros(8)
    slips = np.zeros(8)
    asym = np.zeros(8)
    forces = np.zeros(6)
    o = np.zeros(O_FY)
    steps = (count - 1) * sub
    h = spacing / sub
    done = int(memory[0])
    for n in range(steps + 1):
        i = n // sub
        first = (n - i * sub) / sub
        last = first + 1.0 / sub
        after = min(i + 1, count - 1)
        t = start_time + n * h
        conditions(t + 0.5 * h, windows, step)
        a0 = speed_rate[i] + first * (speed_rate[after] - speed_rate[i])
        a1 = speed_rate[i] + last * (speed_rate[after] - speed_rate[i])
        v0 = speed[i] + first * (speed[after] - speed[i])
        v1 = speed[i] + last * (speed[after] - speed[i])
        u0 = follow(
            memory[1], steering[i] + first * (steering[after] - steering[i]), p[P_GAP], p[P_LAW]
        )
        u1 = follow(u0, steering[i] + last * (steering[after] - steering[i]), p[P_GAP], p[P_LAW])
        if p[P_FREE] <= 0.0:
            y[S_VX] = v0
        harmonic_loads(t, done + n - 1, h, windows, history, y[S_R1], extra)
        derivative(y, rates[0], p, ax, step, extra, u0, a0, v0, fy, fz, slips, asym, forces, o)
        if n == i * sub:
            record(out[i], y, step, fy, fz, slips, o)
        if n == steps:
            break
        memory[1] = u1
        remember(done + n, h, p, y[S_R1], fy, fz, means, history)
        for stage in range(1, 4):
            reach = h if stage == 3 else 0.5 * h
            part = reach / h
            for q in range(STATES):
                z[q] = y[q] + reach * rates[stage - 1, q]
            derivative(
                z, rates[stage], p, ax, step, extra,
                u0 + part * (u1 - u0), a0 + part * (a1 - a0), v0 + part * (v1 - v0),
                fy, fz, slips, asym, forces, o,
            )  # fmt: skip
        for q in range(STATES):
            y[q] += h / 6.0 * (rates[0, q] + 2.0 * rates[1, q] + 2.0 * rates[2, q] + rates[3, q])
        if not inside(y):
            break
    memory[0] = done + steps
    return out
