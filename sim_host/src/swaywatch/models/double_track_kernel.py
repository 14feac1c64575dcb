"""Compiled equations of motion of the double-track model; used by :mod:`.double_track` only.

Generalised coordinates: the car's velocity (v_x, v_y) in its own axes, both yaw rates and the
articulation theta = psi_2 - psi_1, all angles of any size. With the ball forces eliminated, Newton's
and Euler's equations of the two bodies are ``M q'' = f`` with the symmetric matrix

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
    O,
    P,
)
from swaywatch.models.physics.hitch_damping import moment as damping_moment
from swaywatch.models.physics.hitch_friction import moment as friction_moment
from swaywatch.models.physics.road_bank import side_force as bank_force
from swaywatch.models.physics.roll_steer import angle as roll_steer_angle
from swaywatch.models.physics.steering_compliance import angle_lost
from swaywatch.models.physics.steering_free_play import follow
from swaywatch.models.physics.trailer_aerodynamics import side_force as aero_side_force
from swaywatch.models.physics.trailer_aerodynamics import yaw_moment as aero_yaw_moment
from swaywatch.models.physics.tyre_load_sensitivity import stiffness as load_stiffness
from swaywatch.models.physics.tyre_relaxation import slip_rate
from swaywatch.models.physics.tyre_saturation import lateral_force

# Offsets as plain integers, which the compiler folds.
P_M1, P_IZ1, P_LH1, P_M2, P_IZ2, P_LH2 = (P[n] for n in ("m1", "iz1", "lh1", "m2", "iz2", "lh2"))
P_TRAILER, P_RATIO = P["has_trailer"], P["steering_ratio"]
P_KS, P_GAP = P["steering_stiffness"], P["steering_gap"]
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
O_FIRST = O["speed"]

# What holds during one step: stiffness factors of the axles, friction factor, gust force and moment
# on both bodies, bank, brake forces of both bodies.
(C_MU, C_GUST, C_BANK, C_BRAKE, C_SIZE) = (4, 5, 9, 10, 12)

FLOOR_YAW = 1e-6
FLOOR_FORCE = 2.25e4
"""Mean squares, (rad/s)^2 and N^2, below which the normalised generator fades out."""
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
            spring = 0.5 * ax[axle, A_HM] * (
                omega * omega * z + 2.0 * ax[axle, A_HZ] * omega * z_rate
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
    stiffness = load_stiffness(
        0.5 * ax[axle, A_C] * step[axle], fz[wheel], half, ax[axle, A_DEG]
    )
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
def derivative(
    y: Array, dy: Array, p: Array, ax: Array, step: Array, extra: Array,
    steering: float, speed_rate: float, reference: float,
    fy: Array, fz: Array, slips: Array, asym: Array, o: Array,
) -> None:  # fmt: skip
    """Rates of all states; forces, slips and accelerations land in the scratch arrays."""
    m1, iz1, lh1 = p[P_M1], p[P_IZ1], p[P_LH1]
    m2, iz2, lh2 = p[P_M2], p[P_IZ2], p[P_LH2]
    vx, vy, r1, r2 = y[S_VX], y[S_VY], y[S_R1], y[S_R2]
    has_trailer = p[P_TRAILER] > 0.0
    c, s = math.cos(y[S_THETA]), math.sin(y[S_THETA])
    vh = vy - lh1 * r1
    vx2 = c * vx + s * vh
    vy2 = c * vh - s * vx - lh2 * r2

    wheel_loads(y, p, ax, extra, fz, asym)

    # Side slip of every wheel, then forces.
    nominal = steering / p[P_RATIO]
    front_x, front_t = ax[0, A_X], ax[0, A_T]
    front_steer = roll_steer_angle(y[S_ROLL1], ax[0, A_RS])
    beta_left = math.atan2(vy + r1 * front_x, vx - r1 * front_t) - front_steer
    beta_right = math.atan2(vy + r1 * front_x, vx + r1 * front_t) - front_steer
    delta = front_angle(nominal, beta_left, beta_right, y, p, ax, step, fz)

    x1 = 0.0
    y1 = 0.0
    n1 = 0.0
    x2 = 0.0
    y2 = 0.0
    n2 = 0.0
    axles = 4 if has_trailer else 2
    for axle in range(axles):
        body = axle // 2
        u = vx if body == 0 else vx2
        v = vy if body == 0 else vy2
        r = r1 if body == 0 else r2
        angle = roll_steer_angle(y[S_ROLL1 + 2 * body], ax[axle, A_RS])
        if axle == 0:
            angle += delta
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
            if body == 0:
                x1 += fx_body
                y1 += fy_body
                n1 += ax[axle, A_X] * fy_body - lever * fx_body
            else:
                x2 += fx_body
                y2 += fy_body
                n2 += ax[axle, A_X] * fy_body - lever * fx_body
            if ax[axle, A_SIGMA] > SHORT_RELAXATION:
                dy[S_SLIP + wheel] = slip_rate(
                    slip, y[S_SLIP + wheel], abs(u_wheel), ax[axle, A_SIGMA]
                )
            else:
                dy[S_SLIP + wheel] = 0.0

    # Side force through the suspension with a lag (only if asked for).
    if p[P_LAG] > 0.0:
        dy[S_LAG_Y] = (y1 - y[S_LAG_Y]) / p[P_LAG]
        dy[S_LAG_N] = (n1 - y[S_LAG_N]) / p[P_LAG]
        y1 = y[S_LAG_Y]
        n1 = y[S_LAG_N]

    # Drive force: front wheels, in the car's axes; prescribed speed computes it afterwards.
    drive = y[S_DRIVE] if p[P_FREE] > 0.0 else 0.0
    pressure = 0.5 * p[P_RHO] * vx * vx
    x1 += drive - pressure * p[P_DRAG1] - step[C_BRAKE]
    x2 -= pressure * p[P_DRAG2] + step[C_BRAKE + 1]
    y1 += bank_force(m1, p[P_G], step[C_BANK]) + step[C_GUST]
    n1 += step[C_GUST + 1]

    if has_trailer:
        beta2 = math.atan2(vy2, vx2)
        q_area = 0.5 * p[P_RHO] * (vx2 * vx2 + vy2 * vy2) * p[P_AREA]
        y2 += aero_side_force(q_area, beta2, p[P_AERO_Y])
        n2 += aero_yaw_moment(q_area, beta2, p[P_AERO_N])
        # Weight along the slope, in the trailer's axes (the slope is across the car's heading).
        bank2 = bank_force(m2, p[P_G], step[C_BANK])
        x2 += s * bank2
        y2 += c * bank2 + step[C_GUST + 2]
        n2 += step[C_GUST + 3]
    else:
        beta2 = 0.0

    rate = r2 - r1
    hitch = friction_moment(rate, p[P_FRICTION], p[P_FRICTION_RATE]) + damping_moment(
        rate, p[P_DAMPING]
    )

    # M q'' = f, rows v_y, psi_1, psi_2; v_x is prescribed or eliminated.
    kx = -vy * r1 + lh1 * r1 * r1
    ky = vx * r1
    if has_trailer:
        side = s * x2 + c * y2
        mt = m1 + m2
        f_x = x1 + c * x2 - s * y2 + m1 * vy * r1 - m2 * (kx + c * lh2 * r2 * r2)
        f_y = y1 + side - m1 * vx * r1 - m2 * (ky + s * lh2 * r2 * r2)
        f_1 = n1 + hitch - lh1 * side + m2 * lh1 * (ky + s * lh2 * r2 * r2)
        f_2 = n2 - hitch - lh2 * y2 + m2 * lh2 * (c * ky - s * kx)
        a12 = -m2 * lh1
        a13 = -m2 * lh2 * c
        a22 = iz1 + m2 * lh1 * lh1
        a23 = m2 * lh1 * lh2 * c
        a33 = iz2 + m2 * lh2 * lh2
        cross = m2 * lh2 * s
        if p[P_FREE] > 0.0:
            a33 -= cross * cross / mt
            f_2 -= cross * f_x / mt
        else:
            f_2 -= cross * speed_rate
        # Elimination of a symmetric 3 x 3 system with pivot mt.
        b22 = a22 - a12 * a12 / mt
        b23 = a23 - a12 * a13 / mt
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
        ax2 = c * ahx + s * ahy + lh2 * r2 * r2
        ay2 = -s * ahx + c * ahy - lh2 * r2_dot
        h2x = x2 - m2 * ax2
        h2y = y2 - m2 * ay2
        hx = c * h2x - s * h2y
        hy = s * h2x + c * h2y
    else:
        vx_dot = (x1 + m1 * vy * r1) / m1 if p[P_FREE] > 0.0 else speed_rate
        vy_dot = y1 / m1 - vx * r1
        r1_dot = n1 / iz1
        r2_dot = 0.0
        ax2 = 0.0
        ay2 = 0.0
        hx = 0.0
        hy = 0.0
        hitch = 0.0

    ax1 = vx_dot - vy * r1
    ay1 = vy_dot + vx * r1
    dy[S_VX] = vx_dot
    dy[S_VY] = vy_dot
    dy[S_R1] = r1_dot
    dy[S_R2] = r2_dot
    dy[S_THETA] = rate if has_trailer else 0.0

    # Roll: what tilts the body is what an accelerometer would feel.
    g_bank = p[P_G] * math.sin(step[C_BANK])
    push1 = ay1 + g_bank - p[P_HITCH_ROLL] * hy / m1
    push2 = ay2 + c * g_bank
    dy[S_ROLL1] = y[S_ROLLRATE1]
    dy[S_ROLLRATE1] = (
        p[P_OMEGA1] * p[P_OMEGA1] * (p[P_GAIN1] * push1 - y[S_ROLL1])
        - 2.0 * p[P_ZETA1] * p[P_OMEGA1] * y[S_ROLLRATE1]
    )
    dy[S_ROLL2] = y[S_ROLLRATE2]
    dy[S_ROLLRATE2] = (
        p[P_OMEGA2] * p[P_OMEGA2] * (p[P_GAIN2] * push2 - y[S_ROLL2])
        - 2.0 * p[P_ZETA2] * p[P_OMEGA2] * y[S_ROLLRATE2]
    )
    if p[P_HEAVE] > 0.0:
        heave_rates(y, dy, p, ax, asym)

    # Speed control: PI on the speed, feed-forward on the deceleration (Eq. 5.1-5.2).
    error = reference - vx
    dy[S_SPEED_INTEGRAL] = error
    wanted = (
        p[P_CP] * error + p[P_CI] * y[S_SPEED_INTEGRAL]
        + pressure * (p[P_DRAG1] + p[P_DRAG2])
        + p[P_CF] * (m1 + m2) * (speed_rate - vx_dot)
    )  # fmt: skip
    wanted = min(max(wanted, -p[P_DRIVE_MAX]), p[P_DRIVE_MAX])
    if p[P_FREE] > 0.0:
        dy[S_DRIVE] = (wanted - y[S_DRIVE]) / p[P_CLAG]
    else:
        dy[S_DRIVE] = 0.0
        drive = m1 * ax1 - x1 - hx
    cos_psi, sin_psi = math.cos(y[S_PSI]), math.sin(y[S_PSI])
    dy[S_X] = vx * cos_psi - vy * sin_psi
    dy[S_Y] = vx * sin_psi + vy * cos_psi
    dy[S_PSI] = r1

    o[0] = vx
    o[1] = vy
    o[2] = r1
    o[3] = r2
    o[4] = y[S_THETA]
    o[5] = y[S_ROLL1]
    o[6] = y[S_ROLLRATE1]
    o[7] = y[S_ROLL2]
    o[8] = y[S_ROLLRATE2]
    o[9] = ax1
    o[10] = ay1
    o[11] = r1_dot
    o[12] = ax2
    o[13] = ay2
    o[14] = r2_dot
    o[15] = hx
    o[16] = hy
    o[17] = hitch
    o[18] = drive
    o[19] = delta
    o[20] = y[S_X]
    o[21] = y[S_Y]
    o[22] = y[S_PSI]
    o[23] = beta2
    o[24] = step[C_BANK]


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
    t: float, n: int, h: float, p: Array, windows: Array, history: Array, r1: float, extra: Array
) -> None:
    """Extra wheel loads of the generator of 6.2 from the delayed reference signals."""
    extra[:] = 0.0
    for k in range(windows.shape[0]):
        kind, axle = int(windows[k, 0]), int(windows[k, 1])
        if kind != W_GENERATOR and kind != W_UNIT and kind != W_HARMONIC:
            continue
        if t < windows[k, 2] or t >= windows[k, 3]:
            continue
        source = 2 + axle if kind == W_HARMONIC else (0 if kind == W_GENERATOR else 1)
        back = windows[k, 5] / h
        whole = int(back)
        first = max(n - whole, 0)
        second = max(first - 1, 0)
        part = back - whole
        value = (1.0 - part) * history[source, first] + part * history[source, second]
        wheel = 2 * axle if r1 < 0.0 else 2 * axle + 1
        extra[wheel] += windows[k, 4] * value


@inlined
def remember(
    n: int, h: float, p: Array, r1: float, fy: Array, means: Array, history: Array
) -> None:
    """Advance the high-pass of the reference signals (yaw rate and axle forces squared)."""
    share = 1.0 - math.exp(-h / p[P_MEAN])
    square = r1 * r1
    means[0] += share * (square - means[0])
    means[1] += (1.0 - math.exp(-h / p[P_LEVEL])) * (square - means[1])
    history[0, n] = square - means[0]
    history[1, n] = (square - means[0]) / (means[1] + FLOOR_YAW)
    for axle in range(4):
        force = fy[2 * axle] + fy[2 * axle + 1]
        square = force * force
        means[2 + axle] += share * (square - means[2 + axle])
        history[2 + axle, n] = (square - means[2 + axle]) / (means[2 + axle] + FLOOR_FORCE)


@kernel
def simulate(
    start_time: float, spacing: float, sub: int, steering: Array, speed: Array, speed_rate: Array,
    p: Array, ax: Array, windows: Array, initial: Array, harmonic: bool,
) -> Array:  # fmt: skip
    """Integrate with classical Runge-Kutta; one row of outputs per input sample.

    Parameters
    ----------
    spacing : s between input samples; each is cut into ``sub`` steps
    steering, speed, speed_rate : (n,) arrays, linear between samples
    windows : (k, 7) array
    initial : (STATES,) array
    harmonic : the windows hold a load generator, so its references are recorded

    Returns
    -------
    (n, OUTPUTS) array; rows of NaN from where the motion left all bounds
    """
    count = steering.size
    out = np.full((count, OUTPUTS), np.nan)
    y = initial.copy()
    dy = np.zeros(STATES)
    k1 = np.zeros(STATES)
    k2 = np.zeros(STATES)
    k3 = np.zeros(STATES)
    z = np.zeros(STATES)
    step = np.zeros(C_SIZE)
    extra = np.zeros(8)
    fy = np.zeros(8)
    fz = np.zeros(8)
    slips = np.zeros(8)
    asym = np.zeros(8)
    o = np.zeros(O_FY)
    steps = (count - 1) * sub + 1
    history = np.zeros((6, steps if harmonic else 1))
    means = np.zeros(6)
    h = spacing / sub
    gap = p[P_GAP]
    played = steering[0]
    if p[P_LAG] > 0.0:
        y[S_LAG_Y] = 0.0
    n = 0
    for i in range(count):
        last = i == count - 1
        du = 0.0 if last else (steering[i + 1] - steering[i]) / sub
        dv = 0.0 if last else (speed_rate[i + 1] - speed_rate[i]) / sub
        ds = 0.0 if last else (speed[i + 1] - speed[i]) / sub
        for j in range(1 if last else sub):
            t = start_time + i * spacing + j * h
            conditions(t + 0.5 * h, windows, step)
            u0 = steering[i] + j * du
            u1 = u0 + du
            a0 = speed_rate[i] + j * dv
            v0 = speed[i] + j * ds
            if p[P_FREE] <= 0.0:
                y[S_VX] = v0
            if gap > 0.0:
                before = follow(played, u0, gap)
                played = follow(before, u1, gap)
                u0 = before
                u1 = played
            um = 0.5 * (u0 + u1)
            if harmonic:
                harmonic_loads(t, n - 1, h, p, windows, history, y[S_R1], extra)
            derivative(y, k1, p, ax, step, extra, u0, a0, v0, fy, fz, slips, asym, o)
            if harmonic:
                if n == 0:
                    means[0] = y[S_R1] * y[S_R1]
                    means[1] = means[0]
                remember(n, h, p, y[S_R1], fy, means, history)
            if j == 0:
                for q in range(O_FY):
                    out[i, q] = o[q]
                for q in range(8):
                    out[i, O_FY + q] = fy[q]
                    out[i, O_FZ + q] = fz[q]
                    out[i, O_SLIP + q] = slips[q]
            if last:
                break
            for q in range(STATES):
                z[q] = y[q] + 0.5 * h * k1[q]
            derivative(
                z, k2, p, ax, step, extra, um, a0 + 0.5 * dv, v0 + 0.5 * ds,
                fy, fz, slips, asym, o,
            )  # fmt: skip
            for q in range(STATES):
                z[q] = y[q] + 0.5 * h * k2[q]
            derivative(
                z, k3, p, ax, step, extra, um, a0 + 0.5 * dv, v0 + 0.5 * ds,
                fy, fz, slips, asym, o,
            )  # fmt: skip
            for q in range(STATES):
                z[q] = y[q] + h * k3[q]
            derivative(
                z, dy, p, ax, step, extra, u1, a0 + dv, v0 + ds, fy, fz, slips, asym, o
            )
            for q in range(STATES):
                y[q] += h / 6.0 * (k1[q] + 2.0 * k2[q] + 2.0 * k3[q] + dy[q])
            n += 1
            if not (abs(y[S_R2]) < 20.0 and abs(y[S_VY]) < 200.0 and abs(y[S_THETA]) < 3.2):
                return out
    return out
