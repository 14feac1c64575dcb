"""Single-track car alone, with a slot for every place where physics can be missing.

Two states (lateral velocity, yaw rate) and two lags of the slip angles; speed is prescribed.
Equations: Newton-Euler of a body on two axles, Eq. 3.1-3.6 of the reference dissertation without
the trailer; characteristic of a saturating tyre as in `plant`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from swaywatch.diagnose.plant import GRAVITY, SHAPE

Array = NDArray[np.float64]

#: Constants and slots in the order the kernel reads them, with their neutral values.
SLOTS: dict[str, float] = {
    "mass": 0.0, "yaw_inertia": 0.0, "front_axle_to_cog": 0.0, "rear_axle_to_cog": 0.0,
    "front_cornering_stiffness": 0.0, "rear_cornering_stiffness": 0.0,
    "peak_friction_inverse_front": 0.0, "peak_friction_inverse_rear": 0.0,
    "relaxation_front": 0.0, "relaxation_rear": 0.0,  # m
    "cog_height": 0.0,  # m, moves axle load with the longitudinal acceleration
    "lift_front": 0.0, "lift_rear": 0.0,  # N per (m/s)2 taken off the axle load
    "combined_slip": 0.0,  # share of the rear stiffness lost at 1 g of longitudinal acceleration
    "degression": 0.0,  # of the stiffness of an axle with the square of its lateral force over load
}  # fmt: skip
_NAMES = tuple(SLOTS)
OUTPUT = (
    "lateral_velocity", "yaw_rate", "acceleration", "yaw_acceleration", "front", "rear",
    "slip_front", "slip_rear",
)  # fmt: skip
_LEAST_SPEED = 1.0
_FAST = {"contract", "arcp", "nsz"}


@njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy", inline="always")
def _atan(x):  # type: ignore[no-untyped-def] # pragma: no cover
    """Arc tangent; the series is good to 1e-9 below 0.1."""
    if np.abs(x) < 0.1:
        q = x * x
        return x * (1.0 - q * (1.0 / 3.0 - q * (0.2 - q / 7.0)))
    return np.arctan(x)


@dataclass
class CarInput:
    """What one simulation needs: arrays of shape (n,), SI.

    Attributes
    ----------
    steer
        Road-wheel angle, rad.
    bank
        Of the road, rad, positive if gravity pulls to the left.
    slots
        Values by the names of `SLOTS`.
    initial
        Lateral velocity and yaw rate at the first sample.
    run, steering_ratio
        For effects that act in windows of a run or at the steering wheel.
    """

    period_s: float
    speed: Array
    acceleration: Array
    steer: Array
    bank: Array
    slots: dict[str, float] = field(default_factory=lambda: dict(SLOTS))
    initial: tuple[float, float] = (0.0, 0.0)
    run: int = 0
    steering_ratio: float = 15.0


@njit(cache=True, nogil=True, error_model="numpy")
def _force(stiffness, slip, load, static, mu_inv, degression):  # type: ignore[no-untyped-def] # pragma: no cover
    linear = stiffness * slip * (load / static)
    if degression > 0.0:
        linear = linear / np.sqrt(1.0 + degression * (linear / load) ** 2)
    if mu_inv <= 0.0:
        return linear
    peak = load / mu_inv
    return peak * np.sin(SHAPE * np.arctan(linear / (SHAPE * peak)))


@njit(cache=True, nogil=True, error_model="numpy")
def _slope(x, vx, ax, steer, tilt, p, dx, out):  # type: ignore[no-untyped-def] # pragma: no cover
    m, iz, lf, lr = p[0], p[1], p[2], p[3]
    base = lf + lr
    static_f, static_r = m * GRAVITY * lr / base, m * GRAVITY * lf / base
    moved = m * ax * p[10] / base
    load_f = max(static_f - moved - p[11] * vx * vx, 0.1 * static_f)
    load_r = max(static_r + moved - p[12] * vx * vx, 0.1 * static_r)
    slip_f = steer - _atan((x[0] + lf * x[1]) / vx)
    slip_r = -_atan((x[0] - lr * x[1]) / vx)
    used_f = x[2] if p[8] > 0.0 else slip_f
    used_r = x[3] if p[9] > 0.0 else slip_r
    weak = 1.0 / (1.0 + p[13] * (ax / GRAVITY) ** 2)
    front = _force(p[4], used_f, load_f, static_f, p[6], p[14]) * np.cos(steer)
    rear = _force(p[5] * weak, used_r, load_r, static_r, p[7], p[14])
    felt = (front + rear) / m
    dx[0] = felt + tilt - vx * x[1]
    dx[1] = (lf * front - lr * rear) / iz
    out[0], out[1], out[2], out[3], out[4], out[5] = x[0], x[1], felt, dx[1], front, rear
    out[6], out[7] = slip_f, slip_r


@njit(cache=True, nogil=True, error_model="numpy")
def _lagged(old, first, last, way, length):  # type: ignore[no-untyped-def] # pragma: no cover
    """First-order lag of a relaxation length after a way on which the slip went evenly."""
    if length <= 0.0:
        return last
    z = way / length
    decay = np.exp(-z)
    if z < 1e-6:
        return old
    rise = (last - first) / z
    return last - rise + (old - first + rise) * decay


@njit(cache=True, nogil=True, error_model="numpy")
def _integrate(h, vx, ax, steer, tilt, p, start, y):  # type: ignore[no-untyped-def] # pragma: no cover
    """Runge-Kutta 4 over two samples at a time; the one between is met at the middle stages.

    The lags of the slip angles are much faster than that at speed: they are stepped exactly for a
    slip that changes evenly from one end of the step to the other.
    """
    n = vx.shape[0]
    x = np.zeros(4)
    x[:2] = start
    k = np.zeros((4, 2))
    tmp = np.zeros(4)
    step = 2.0 * h
    i = 0
    while True:
        _slope(x, vx[i], ax[i], steer[i], tilt[i], p, k[0], y[i])
        if i + 1 >= n:
            return
        m, last = i + 1, min(i + 2, n - 1)
        tmp[2], tmp[3] = x[2], x[3]
        for j in range(2):
            tmp[j] = x[j] + 0.5 * step * k[0, j]
        _slope(tmp, vx[m], ax[m], steer[m], tilt[m], p, k[1], y[m])
        for j in range(2):
            tmp[j] = x[j] + 0.5 * step * k[1, j]
        for j in range(2):
            tmp[2 + j] = _lagged(x[2 + j], y[i, 6 + j], y[m, 6 + j], h * vx[i], p[8 + j])
        _slope(tmp, vx[m], ax[m], steer[m], tilt[m], p, k[2], y[m])
        if last == m:
            return
        for j in range(2):
            tmp[j] = x[j] + step * k[2, j]
        _slope(tmp, vx[last], ax[last], steer[last], tilt[last], p, k[3], y[last])
        for j in range(2):
            tmp[2 + j] = _lagged(x[2 + j], y[i, 6 + j], y[last, 6 + j], step * vx[i], p[8 + j])
            x[j] += step / 6.0 * (k[0, j] + 2.0 * k[1, j] + 2.0 * k[2, j] + k[3, j])
            if not np.abs(x[j]) < 1e4:
                return
        x[2], x[3] = tmp[2], tmp[3]
        i = last


def simulate(car: CarInput) -> dict[str, Array]:
    """Run the car: arrays of shape (n,) by the names of `OUTPUT`; zeros after a divergence.

    `acceleration` is what an accelerometer at the centre of gravity feels on a body that does not
    roll: lateral tyre forces over mass.
    """
    result = np.zeros((car.speed.size, len(OUTPUT)))
    values = np.array([car.slots[name] for name in _NAMES])
    speed = np.maximum(car.speed, _LEAST_SPEED)
    _integrate(
        car.period_s, speed, car.acceleration, car.steer, GRAVITY * np.sin(car.bank),
        values, np.array(car.initial), result,
    )  # fmt: skip
    return {name: result[:, index] for index, name in enumerate(OUTPUT)}
