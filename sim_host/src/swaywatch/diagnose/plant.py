"""Planar car-trailer plant of the diagnosis: exact large-angle kinematics, wheel by wheel.

One compiled function holds every place ("slot") where missing physics can enter; a module of
`swaywatch.diagnose.modules` fills slots. It is a reduced model on purpose (planar, speed
prescribed, no driver, no sensors): a diagnosis evaluates it some ten thousand times.

Axes ISO 8855; articulation is psi_trailer - psi_car; hitch force is that of the trailer on the car
in car axes. Equations: Newton-Euler of two rigid bodies with a common point, Eq. 3.1-3.12 of the
reference dissertation without its small-angle steps.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRAVITY = 9.81
AIR_DENSITY = 1.2
SHAPE = 1.35  # of the saturating characteristic, Pacejka's C
TRAILER_AREA = 5.0  # m2, reference area of `trailer_aerodynamics`
#: Lag of the state of a shorter relaxation; the rest of its slip comes through at once, so that the
#: delay at the frequencies of sway is that of the length itself and the step stays stable.
SHORTEST_LAG_M = 0.15

#: Constants of the combination, in the order the kernel reads them.
BODY = (
    "car.mass", "car.yaw_inertia", "car.front_axle_to_cog", "car.rear_axle_to_cog",
    "car.hitch_to_cog", "car.front_cornering_stiffness", "car.rear_cornering_stiffness",
    "trailer.mass", "trailer.yaw_inertia", "trailer.front_axle_to_cog",
    "trailer.rear_axle_to_cog", "trailer.hitch_to_cog", "trailer.front_cornering_stiffness",
    "trailer.rear_cornering_stiffness", "car.front_axle_load", "car.rear_axle_load",
    "trailer.front_axle_load", "trailer.rear_axle_load",
)  # fmt: skip
AXLES = ("car_front", "car_rear", "trailer_front", "trailer_rear")

#: Scalar slots of missing physics, zero (or infinite, see `neutral`) in the baseline.
SCALARS = (
    "steering_flexibility",  # rad/N, road-wheel angle per front lateral force (Eq. 5.3)
    "free_play",  # rad at the road wheel, half gap, lost against the lateral force
    "hitch_friction",  # Nm
    "hitch_sticking",  # rad/s, articulation rate below which dry friction is not yet full
    "hitch_damping",  # Nms/rad
    "aero_side",  # -
    "aero_yaw",  # -
    "peak_friction_inverse",  # -, 0: tyre linear
    "degression",  # -
    "relaxation_car_front", "relaxation_car_rear", "relaxation_trailer",  # m
    "roll_steer_car_front", "roll_steer_car_rear", "roll_steer_trailer",  # rad/rad
    "transfer_car_front", "transfer_car_rear",  # N per m/s2, wheel load per side
    "transfer_trailer_front", "transfer_trailer_rear",
    "roll_gain_car", "roll_gain_trailer",  # rad per m/s2
    "roll_frequency_car", "roll_damping_car",  # rad/s, -
    "roll_frequency_trailer", "roll_damping_trailer",
    "steer_frequency_car", "steer_damping_car", "steer_frequency_trailer", "steer_damping_trailer",
    "observer",  # 1/s, pull of the yaw rates to the measured ones (0: free simulation)
    "bank_unsensed",  # 1: the accelerations are those of the motion, without gravity's part
)  # fmt: skip

#: Slots that are functions of time.
SERIES = (
    "stiffness_car_front", "stiffness_car_rear", "stiffness_trailer_front",
    "stiffness_trailer_rear",  # factor on the stiffness at unchanged load
    "load_car_front", "load_car_rear", "load_trailer_front", "load_trailer_rear",  # N
    "force_car", "moment_car", "force_trailer", "moment_trailer", "bank",  # N, Nm, rad
    "shift_car_front", "shift_car_rear", "shift_trailer_front", "shift_trailer_rear",  # N to right
    "heave_car_front", "heave_car_rear", "heave_trailer_front", "heave_trailer_rear",  # N, both
    "friction",  # factor - 1 on the peak friction
    "measured_car", "measured_trailer",  # rad/s, yaw rates for the observer
    "slip_car_front", "slip_car_rear", "slip_trailer_front", "slip_trailer_rear",  # rad
)  # fmt: skip

#: Columns of the result.
OUTPUT = (
    "lateral_velocity", "car_yaw_rate", "articulation", "trailer_yaw_rate",
    "lateral_fl", "lateral_fr", "lateral_rl", "lateral_rr", "lateral_tf", "lateral_tr",
    "vertical_fl", "vertical_fr", "vertical_rl", "vertical_rr",
    "hitch_x", "hitch_y", "car_acceleration", "trailer_acceleration",
    "car_yaw_acceleration", "trailer_yaw_acceleration", "car_roll", "trailer_roll",
    "slip_f", "slip_r", "slip_tf", "slip_tr",
    "trailer_lateral_fl", "trailer_lateral_fr", "trailer_lateral_rl", "trailer_lateral_rr",
    "trailer_vertical_fl", "trailer_vertical_fr", "trailer_vertical_rl", "trailer_vertical_rr",
)  # fmt: skip
_STATES = 16
_RELAXATION = [index for index, name in enumerate(SCALARS) if name.startswith("relaxation")]
SHORT_RELAXATION_M = 0.4  # below it two samples are too long a step


#: What vehicle.toml does not say: load transfer and roll of a mid-size car (frequency and damping
#: as the wheel loads of the practice recordings show them; roll gain from these, a roll radius of
#: gyration of 0.57 m and a track of 1.55 m: m h / (I omega^2)) and of a caravan, 8.4 deg per g.
_TYPICAL = {
    "hitch_sticking": 0.01,
    "transfer_car_front": 435.0, "transfer_car_rear": 356.0,
    "transfer_trailer_front": 420.0, "transfer_trailer_rear": 390.0,
    "roll_gain_car": 0.0115, "roll_gain_trailer": 0.0150,
    "roll_frequency_car": 13.0, "roll_damping_car": 0.112,
    "roll_frequency_trailer": 13.0, "roll_damping_trailer": 0.112,
    "steer_frequency_car": 13.0, "steer_damping_car": 0.112,
    "steer_frequency_trailer": 9.0, "steer_damping_trailer": 0.3,
}  # fmt: skip


def neutral() -> Array:
    """Scalar slots of the baseline: nothing missing, typical load transfer."""
    scalars = np.zeros(len(SCALARS))
    for name, value in _TYPICAL.items():
        scalars[SCALARS.index(name)] = value
    return scalars


@dataclass
class PlantInput:
    """What one simulation needs. All arrays of shape (n,), SI units.

    Attributes
    ----------
    period_s
        Grid period.
    speed, acceleration
        Prescribed longitudinal speed of the car's centre of gravity and its derivative.
    steer
        Road-wheel angle, rad.
    body
        Constants in the order of `BODY`.
    scalars
        Scalar slots in the order of `SCALARS`.
    series
        Time-function slots by name; absent ones are neutral.
    initial
        Lateral velocity, car yaw rate, articulation, trailer yaw rate at the first sample.
    """

    period_s: float
    speed: Array
    acceleration: Array
    steer: Array
    body: Array
    scalars: Array = field(default_factory=neutral)
    series: dict[str, Array] = field(default_factory=dict)
    initial: Array = field(default_factory=lambda: np.zeros(4))

    def get(self, name: str) -> float:
        """A scalar slot."""
        return float(self.scalars[SCALARS.index(name)])

    def scalar(self, name: str, value: float) -> None:
        """Set a scalar slot."""
        self.scalars[SCALARS.index(name)] = value

    def add_series(self, name: str, value: Array) -> None:
        """Add to a time-function slot (factors are added as factor - 1)."""
        self.series[name] = self.series.get(name, 0.0) + value


_FAST = {"contract", "arcp", "nsz"}
#: A call of the derivative costs as much as its sums.
_inlined = njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy", inline="always")


@_inlined
def _atan(x):  # type: ignore[no-untyped-def] # pragma: no cover
    """Arc tangent; the series is good to 1e-9 below 0.1."""
    if np.abs(x) < 0.1:
        q = x * x
        return x * (1.0 - q * (1.0 / 3.0 - q * (0.2 - q / 7.0)))
    return np.arctan(x)


@_inlined
def _axle(stiffness, load, extra, side, shift, heave, slip, degression, mu_inv, out):  # type: ignore[no-untyped-def] # pragma: no cover
    """Lateral force of an axle from its two wheels; out: left, right force and load.

    `side` is -1 (left) or 1 (right): the wheel that carries the extra load; `shift` goes from left
    to right, `heave` is shared.
    """
    total = 0.0
    for wheel in range(2):
        sign = -1.0 if wheel == 0 else 1.0
        fz = 0.5 * (load + heave) + sign * shift
        if sign == side:
            fz += extra
        fz = max(fz, 0.0)
        z = 2.0 * fz / load
        linear = 0.5 * stiffness * slip * z * (1.0 - degression * (z - 1.0))
        force = linear
        if mu_inv > 0.0 and fz > 1.0:
            peak = fz / mu_inv
            force = peak * np.sin(SHAPE * np.arctan(linear / (SHAPE * peak)))
        out[wheel] = force
        out[2 + wheel] = fz
        total += force
    return total


@_inlined
def _derivative(x, vx, ax, steer, ser, p, e, dx, out, w):  # type: ignore[no-untyped-def] # noqa: PLR0915
    vy, r1, th, r2 = x[0], x[1], x[2], x[3]
    m1, iz1, lf, lr, lh = p[0], p[1], p[2], p[3], p[4]
    m2, iz2, lf2, lr2, lh2 = p[7], p[8], p[9], p[10], p[11]
    s, c = np.sin(th), np.cos(th)
    a_f1, a_f2 = x[4], x[5]
    roll1, roll2 = e[19] * x[12], e[20] * x[13]
    hvy = vy - lh * r1
    vx2 = c * vx + s * hvy
    vy2 = -s * vx + c * hvy - lh2 * r2
    sl_f = steer - _atan((vy + lf * r1) / vx) + e[12] * roll1 + ser[24]
    sl_r = -_atan((vy - lr * r1) / vx) + e[13] * roll1 + ser[25]
    sl_1 = -_atan((vy2 + lf2 * r2) / vx2) + e[14] * roll2 + ser[26]
    sl_2 = -_atan((vy2 - lr2 * r2) / vx2) + e[14] * roll2 + ser[27]
    ef, er, e1, e2 = sl_f, sl_r, sl_1, sl_2
    if e[9] > 0.0:
        ef = sl_f + min(e[9] / SHORTEST_LAG_M, 1.0) * (x[6] - sl_f)
    if e[10] > 0.0:
        er = sl_r + min(e[10] / SHORTEST_LAG_M, 1.0) * (x[7] - sl_r)
    if e[11] > 0.0:
        part = min(e[11] / SHORTEST_LAG_M, 1.0)
        e1, e2 = sl_1 + part * (x[8] - sl_1), sl_2 + part * (x[9] - sl_2)
    cf = p[5] * (1.0 + ser[0])
    mu_inv = e[7] / (1.0 + ser[21])
    if e[0] != 0.0:
        ef = ef / (1.0 + e[0] * cf * (1.0 + ser[4] / p[14]))
    if e[1] > 0.0:
        ef = ef - e[1] * np.tanh(cf * ef / 50.0)
    # Fig. 6-3 of the dissertation: the extra load sits on the left while the yaw rate is negative
    side = -1.0 if r1 < 0.0 else 1.0
    ff = _axle(cf, p[14], ser[4], side, e[15] * a_f1 + ser[13], ser[17], ef, e[8], mu_inv, w[0])
    fr = _axle(
        p[6] * (1.0 + ser[1]),
        p[15],
        ser[5],
        side,
        e[16] * a_f1 + ser[14],
        ser[18],
        er,
        e[8],
        mu_inv,
        w[1],
    )
    t1 = _axle(
        p[12] * (1.0 + ser[2]),
        p[16],
        ser[6],
        side,
        e[17] * a_f2 + ser[15],
        ser[19],
        e1,
        e[8],
        mu_inv,
        w[2],
    )
    t2 = _axle(
        p[13] * (1.0 + ser[3]),
        p[17],
        ser[7],
        side,
        e[18] * a_f2 + ser[16],
        ser[20],
        e2,
        e[8],
        mu_inv,
        w[3],
    )
    tilt = 0.0
    if ser[12] != 0.0:
        tilt = -GRAVITY * np.sin(ser[12])  # ISO 8855: positive with the left side high
    y1 = ser[8] + m1 * tilt
    n1 = ser[9]
    y2 = ser[10] + m2 * tilt
    n2 = ser[11]
    if e[5] != 0.0 or e[6] != 0.0:
        q = 0.5 * AIR_DENSITY * vx2 * vx2 * TRAILER_AREA * _atan(vy2 / vx2)
        y2 -= q * e[5]
        n2 -= q * e[6]
    rate = r2 - r1
    mh = e[4] * rate
    if e[2] != 0.0:
        mh += e[2] * np.tanh(rate / e[3])
    tt = t1 + t2 + y2
    fc = ff * np.cos(steer)
    ahx = ax - vy * r1 + lh * r1 * r1
    m = m1 + m2
    a12, a13 = -m2 * lh, -m2 * c * lh2
    a22, a23 = iz1 + m2 * lh * lh, lh * m2 * c * lh2
    a33 = iz2 + m2 * lh2 * lh2
    b1 = fc + fr + y1 + c * tt - m * vx * r1 - m2 * s * lh2 * r2 * r2
    b2 = lf * fc - lr * fr + n1 + mh - lh * (c * tt - m2 * vx * r1 - m2 * s * lh2 * r2 * r2)
    b3 = lf2 * t1 - lr2 * t2 + n2 - mh - lh2 * tt + lh2 * m2 * (-s * ahx + c * vx * r1)
    # symmetric 3 x 3
    d22 = a22 - a12 * a12 / m
    d23 = a23 - a12 * a13 / m
    d33 = a33 - a13 * a13 / m
    g2 = b2 - a12 * b1 / m
    g3 = b3 - a13 * b1 / m
    r2d = (g3 - d23 * g2 / d22) / (d33 - d23 * d23 / d22)
    r1d = (g2 - d23 * r2d) / d22
    vyd = (b1 - a12 * r1d - a13 * r2d) / m
    ay1 = vyd + vx * r1
    ahy = ay1 - lh * r1d
    a2x = c * ahx + s * ahy + lh2 * r2 * r2
    a2y = -s * ahx + c * ahy - lh2 * r2d
    px = -m2 * a2x
    py = tt - m2 * a2y
    dx[0], dx[1], dx[2], dx[3] = vyd, r1d, rate, r2d
    # an observer keeps the state near the measured one, so that what is missing shows where and
    # when it acts instead of being carried on (innovation form of the prediction-error method)
    dx[1] += e[29] * (ser[22] - r1)
    dx[3] += e[29] * (ser[23] - r2)
    # roll and load transfer: second order behind the acceleration that the body feels
    dx[4] = x[10]
    dx[10] = e[21] * (e[21] * (ay1 - tilt - a_f1) - 2.0 * e[22] * x[10])
    dx[5] = x[11]
    dx[11] = e[23] * (e[23] * (a2y - tilt - a_f2) - 2.0 * e[24] * x[11])
    # the roll that steers may be damped otherwise than the load transfer
    dx[12], dx[13], dx[14], dx[15] = 0.0, 0.0, 0.0, 0.0
    if e[12] != 0.0 or e[13] != 0.0 or e[14] != 0.0:
        dx[12], dx[13] = x[14], x[15]
        dx[14] = e[25] * (e[25] * (ay1 - tilt - x[12]) - 2.0 * e[26] * x[14])
        dx[15] = e[27] * (e[27] * (a2y - tilt - x[13]) - 2.0 * e[28] * x[15])
    dx[6] = (sl_f - x[6]) * vx / max(e[9], SHORTEST_LAG_M) if e[9] > 0.0 else 0.0
    dx[7] = (sl_r - x[7]) * vx / max(e[10], SHORTEST_LAG_M) if e[10] > 0.0 else 0.0
    dx[8] = (sl_1 - x[8]) * vx / max(e[11], SHORTEST_LAG_M) if e[11] > 0.0 else 0.0
    dx[9] = (sl_2 - x[9]) * vx / max(e[11], SHORTEST_LAG_M) if e[11] > 0.0 else 0.0
    out[0], out[1], out[2], out[3] = vy, r1, th, r2
    out[4], out[5], out[6], out[7] = w[0, 0], w[0, 1], w[1, 0], w[1, 1]
    out[8], out[9] = t1, t2
    out[10], out[11], out[12], out[13] = w[0, 2], w[0, 3], w[1, 2], w[1, 3]
    out[14], out[15] = c * px - s * py, s * px + c * py
    sensed = tilt * (1.0 - e[30])
    out[16], out[17] = ay1 - sensed, a2y - sensed
    out[18], out[19], out[20], out[21] = r1d, r2d, roll1, roll2
    out[22], out[23], out[24], out[25] = ef, er, e1, e2
    out[26], out[27], out[28], out[29] = w[2, 0], w[2, 1], w[3, 0], w[3, 1]
    out[30], out[31], out[32], out[33] = w[2, 2], w[2, 3], w[3, 2], w[3, 3]


@njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy")
def _integrate(h, stride, first, n, vx, ax, steer, series, p, e, x0, y, keep):  # type: ignore[no-untyped-def] # noqa: C901 # pragma: no cover
    """Runge-Kutta 4 over samples `first` to `n`; a stride of 2 takes the middle one at stage 3."""
    ns = series.shape[1]
    x = x0.copy()
    k = np.zeros(_STATES)
    w = np.zeros((4, 4))
    scratch = np.zeros(y.shape[1])
    now = np.zeros(ns)
    tmp = np.zeros(_STATES)
    total = np.zeros(_STATES)
    i = first
    while i < n:
        if keep.shape[0] > 0:
            keep[i] = x
        double = stride == 2 and i + 2 < n
        step = 2.0 * h if double else h
        m = i + 1
        last = min(i + 2 if double else m, n - 1)
        half = 1.0 if double else 0.5  # the middle is a sample, or between two of them
        for j in range(_STATES):
            tmp[j] = x[j]
            total[j] = 0.0
        # one place of call, so that the compiler takes the derivative into the loop
        for stage in range(4):
            out = y[i] if stage == 0 else (y[m] if stage == 2 and double else scratch)
            if stage in (0, 3):
                at = i if stage == 0 else last
                v, a, d = vx[at], ax[at], steer[at]
                for j in range(ns):
                    now[j] = series[at, j]
            elif stage == 1 and m < n:
                v = half * vx[m] + (1.0 - half) * vx[i]
                a = half * ax[m] + (1.0 - half) * ax[i]
                d = half * steer[m] + (1.0 - half) * steer[i]
                for j in range(ns):
                    now[j] = half * series[m, j] + (1.0 - half) * series[i, j]
            _derivative(tmp, v, a, d, now, p, e, k, out, w)
            weight = 1.0 if stage in (0, 3) else 2.0
            ahead = step if stage == 2 else 0.5 * step
            for j in range(_STATES):
                total[j] += weight * k[j]
                tmp[j] = x[j] + ahead * k[j]
            if m >= n:
                return
        for j in range(_STATES):
            x[j] += step / 6.0 * total[j]
            if not np.abs(x[j]) < 1e6:
                return
        i = last


@dataclass
class Trajectory:
    """A simulation from whose samples others can branch off.

    Attributes
    ----------
    output
        Shape (n, len(OUTPUT)); zeros after a divergence.
    states
        Full states at the samples that were stepped on, shape (n, states).
    """

    output: Array
    states: Array


def simulate(plant: PlantInput, *, fine: bool = True) -> Array:
    """Run the plant. Result of shape (n, len(OUTPUT)); zeros after a divergence.

    Not `fine` takes steps of two samples: half the time, up to 0.1 % off near the critical speed.
    """
    n = plant.speed.size
    result = np.zeros((n, len(OUTPUT)))
    _run(plant, fine, (0, n), _start(plant), result, np.zeros((0, _STATES)))
    return result


def trajectory(plant: PlantInput, *, fine: bool = True) -> Trajectory:
    """Run the plant and keep its states."""
    n = plant.speed.size
    found = Trajectory(np.zeros((n, len(OUTPUT))), np.zeros((n, _STATES)))
    _run(plant, fine, (0, n), _start(plant), found.output, found.states)
    return found


def branch(
    base: Trajectory, plant: PlantInput, start: int, stop: int, *, fine: bool = True
) -> Array:
    """Run the plant between two samples only, from a state of another simulation.

    Returns
    -------
    Array
        Outputs of samples `start` to `stop`, shape (stop - start, len(OUTPUT)). `start` is even.
    """
    result = np.zeros((plant.speed.size, len(OUTPUT)))
    _run(plant, fine, (start, stop), base.states[start], result, np.zeros((0, _STATES)))
    return result[start:stop]


def _start(plant: PlantInput) -> Array:
    state = np.zeros(_STATES)
    state[:4] = plant.initial
    return state


def _run(
    plant: PlantInput, fine: bool, span: tuple[int, int], state: Array, result: Array, keep: Array
) -> None:
    series = np.zeros((plant.speed.size, len(SERIES)))
    for name, value in plant.series.items():
        series[:, SERIES.index(name)] = value
    lengths = [value for value in plant.scalars[_RELAXATION] if value > 0.0]
    stride = 1 if fine or (lengths and min(lengths) < SHORT_RELAXATION_M) else 2
    _integrate(
        plant.period_s, stride, *span, plant.speed, plant.acceleration, plant.steer, series,
        plant.body, plant.scalars, state, result, keep,
    )  # fmt: skip
