"""Plant and drives of the warning campaign: a small single-track combination, fast enough for days.

Not the simulator of the product (that is ``swaywatch.models``): independent of it and of the core,
with the disturbances that make warnings hard: gusts, rough road, a driver, tyres that lag and
saturate, sensors with noise, steps and offsets. Small angles, ISO 8855 axes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from numba import njit

FloatArray = npt.NDArray[np.float64]

STEP_S = 0.01
SUBSTEPS = 2


@dataclass
class Combination:
    """True parameters of one car and trailer, SI; the reference's by default."""

    m1: float = 1955.0
    m2: float = 1880.0
    i1: float = 2690.0
    i2: float = 10350.0
    lf1: float = 1.302
    lr1: float = 1.383
    lh1: float = 2.166
    lf2: float = 0.124
    lr2: float = 0.526
    lh2: float = 5.073
    ratio: float = 15.0
    stiffness: tuple[float, float, float, float] = (109.3e3, 185.2e3, 131.2e3, 124.4e3)
    relaxation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    peak_friction: float = 0.95
    hitch_friction: float = 0.0
    """Dry friction at the ball, Nm."""

    def vector(self) -> FloatArray:
        """All of it, for the compiled part."""
        return np.array(
            [
                self.m1, self.m2, self.i1, self.i2, self.lf1, self.lr1, self.lh1, self.lf2,
                self.lr2, self.lh2, self.ratio, *self.stiffness, *self.relaxation,
                self.peak_friction, self.hitch_friction,
            ]
        )  # fmt: skip


def roots(
    c: Combination, speed: float, factor: FloatArray | None = None
) -> npt.NDArray[np.complex128]:
    """Roots of the linear combination at `speed`, axle stiffnesses times `factor`.

    The state matrix of App. A.2 of the reference (corrected) with one more state for each axle;
    eigenvalues by numpy.
    """
    stiffness = np.array(c.stiffness) * (1.0 if factor is None else factor)
    mass = np.array(
        [
            [c.m1 + c.m2, -c.m2 * (c.lh1 + c.lh2), -c.m2 * c.lh2],
            [c.m1 * c.lh1, c.i1, 0],
            [
                -c.m2 * c.lh2,
                c.i2 + c.m2 * c.lh2 * (c.lh1 + c.lh2),
                c.i2 + c.m2 * c.lh2**2,
            ],
        ]
    )
    b_f, b_r = c.lh2 - c.lf2, c.lh2 + c.lr2
    arms = np.array(
        [[1, 1, 1, 1], [c.lf1 + c.lh1, c.lh1 - c.lr1, 0, 0], [0, 0, -b_f, -b_r]], dtype=float
    )
    centripetal = np.array([-(c.m1 + c.m2), -c.m1 * c.lh1, c.m2 * c.lh2]) * speed
    slip = np.array(
        [
            [-1 / speed, -c.lf1 / speed, 0, 0],
            [-1 / speed, c.lr1 / speed, 0, 0],
            [-1 / speed, (c.lh1 + b_f) / speed, b_f / speed, 1],
            [-1 / speed, (c.lh1 + b_r) / speed, b_r / speed, 1],
        ]
    )
    rate = speed / np.maximum(np.array(c.relaxation), 0.02)
    a = np.zeros((8, 8))
    inverse = np.linalg.inv(mass)
    a[:3, 1] = inverse @ centripetal
    a[:3, 4:] = inverse @ (arms * stiffness)
    a[3, 2] = 1
    a[4:, :4] = slip * rate[:, None]
    a[4:, 4:] = -np.diag(rate)
    return np.asarray(np.linalg.eigvals(a))


def damping_ratio(c: Combination, speed: float, factor: FloatArray | None = None) -> float:
    """Least damping ratio of the oscillating modes at `speed`, relaxation included."""
    found = roots(c, speed, factor)
    found = found[(found.imag > 0.5) & (np.abs(found) < 30)]
    return float(np.min(-found.real / np.abs(found)))


def diverges(c: Combination, speed: float, factor: FloatArray | None = None) -> bool:
    """A root without oscillation grows: a spin or jackknife, not sway."""
    found = roots(c, speed, factor)
    return bool(np.any((found.real > 0) & (np.abs(found.imag) <= 0.5)))


def critical_speed(c: Combination, factor: FloatArray | None = None) -> float:
    """Speed of zero damping, m/s; 90 m/s if there is none below."""
    low, high = 8.0, 90.0
    if damping_ratio(c, high, factor) > 0:
        return high
    for _ in range(30):
        middle = 0.5 * (low + high)
        if damping_ratio(c, middle, factor) > 0:
            low = middle
        else:
            high = middle
    return low


@njit(cache=True)
def _force(stiffness: float, slip: float, peak: float) -> float:
    return peak * math.tanh(stiffness * slip / peak)


@njit(cache=True)
def _simulate(
    p: FloatArray,
    speed: FloatArray,
    wheel: FloatArray,
    lane: FloatArray,
    follow: float,
    factor: FloatArray,
    side: FloatArray,
    rough: FloatArray,
) -> FloatArray:
    m1, m2, i1, i2, lf1, lr1, lh1, lf2, lr2, lh2, ratio = p[:11]
    b_f, b_r = lh2 - lf2, lh2 + lr2
    mass = np.array(
        [
            [m1 + m2, -m2 * (lh1 + lh2), -m2 * lh2],
            [m1 * lh1, i1, 0.0],
            [-m2 * lh2, i2 + m2 * lh2 * (lh1 + lh2), i2 + m2 * lh2**2],
        ]
    )
    inverse = np.linalg.inv(mass)
    g = 9.81
    peak = p[19] * np.array(
        [
            m1 * g * lr1 / (lf1 + lr1),
            m1 * g * lf1 / (lf1 + lr1),
            m2 * g * (lr2 + 0.02) / (lf2 + lr2 + 0.04),
            m2 * g * (lf2 + 0.02) / (lf2 + lr2 + 0.04),
        ]
    )
    # A tandem's axles share their load through rockers or springs: nearer to equal than static.
    mean = 0.5 * (peak[2] + peak[3])
    peak[2] = 0.5 * (peak[2] + mean)
    peak[3] = 0.5 * (peak[3] + mean)
    n = len(speed)
    out = np.zeros((n, 6))
    vy = r = q = theta = psi = y = 0.0
    lag = np.zeros(4)
    hand = 0.0
    dt = STEP_S / SUBSTEPS
    force = np.zeros(4)
    for k in range(n):
        v = max(speed[k], 3.0)
        ay1 = ay2 = 0.0
        # The driver looks ahead and steers towards the lane, slowly, with a hand that lags.
        ahead = 1.2 * v
        error = lane[k] - (y + ahead * psi)
        aim = follow * ratio * (0.55 * error / ahead - 0.02 * r)
        hand += (aim - hand) * STEP_S / 0.25
        delta = (wheel[k] + hand) / ratio
        for _ in range(SUBSTEPS):
            a0 = delta - (vy + lf1 * r) / v
            a1 = -(vy - lr1 * r) / v
            a2 = theta - (vy - lh1 * r - b_f * (r + q)) / v
            a3 = theta - (vy - lh1 * r - b_r * (r + q)) / v
            slip = (a0, a1, a2, a3)
            for i in range(4):
                sigma = max(p[15 + i], 0.02)
                lag[i] += (slip[i] - lag[i]) * (1 - math.exp(-dt * v / sigma))
                force[i] = _force(p[11 + i] * factor[k, i], lag[i] + rough[k, i], peak[i])
            f1 = force[0] + force[1] + side[k, 0]
            f2 = force[2] + force[3] + side[k, 1]
            rhs0 = f1 + f2 - (m1 + m2) * v * r
            rhs1 = (
                force[0] * (lf1 + lh1)
                + force[1] * (lh1 - lr1)
                + side[k, 0] * (lh1 + 0.3)
                - m1 * lh1 * v * r
            )
            rhs2 = -force[2] * b_f - force[3] * b_r - side[k, 1] * (lh2 - 0.3) + m2 * lh2 * v * r
            drag = p[20] * math.tanh(q / 0.005)
            rhs1 += drag
            rhs2 -= drag
            dvy = inverse[0, 0] * rhs0 + inverse[0, 1] * rhs1 + inverse[0, 2] * rhs2
            dr = inverse[1, 0] * rhs0 + inverse[1, 1] * rhs1 + inverse[1, 2] * rhs2
            dq = inverse[2, 0] * rhs0 + inverse[2, 1] * rhs1 + inverse[2, 2] * rhs2
            ay1 = dvy + v * r - lr1 * dr
            ay2 = dvy + v * r - lh1 * dr - lh2 * (dr + dq)
            vy += dvy * dt
            r += dr * dt
            q += dq * dt
            theta += q * dt
            psi += r * dt
            y += (v * psi + vy) * dt
            if abs(theta) > 0.7:  # jackknifed: what follows is not of interest
                theta = 0.7
                q = 0.0
        out[k, 0] = wheel[k] + hand
        out[k, 1] = r
        out[k, 2] = ay1
        out[k, 3] = r + q
        out[k, 4] = ay2
        out[k, 5] = theta
    return out


@dataclass
class Course:
    """Everything that happens in one drive, shapes (n,), (n, 4), (n, 2)."""

    speed: FloatArray
    wheel: FloatArray
    lane: FloatArray
    follow: float
    factor: FloatArray
    side: FloatArray
    rough: FloatArray

    @property
    def time_s(self) -> FloatArray:
        """Time of each row."""
        return np.arange(len(self.speed)) * STEP_S


def course(seconds: float, speed: float) -> Course:
    """A straight, quiet drive at constant speed with the wheel held."""
    n = round(seconds / STEP_S)
    return Course(
        np.full(n, speed),
        np.zeros(n),
        np.zeros(n),
        0.0,
        np.ones((n, 4)),
        np.zeros((n, 2)),
        np.zeros((n, 4)),
    )


@dataclass
class Motion:
    """True motion, shape (n,) each."""

    time_s: FloatArray
    speed: FloatArray
    steering_wheel_angle: FloatArray
    car_yaw_rate: FloatArray
    car_lateral_acceleration: FloatArray
    trailer_yaw_rate: FloatArray
    trailer_lateral_acceleration: FloatArray
    articulation: FloatArray
    channels: dict[str, tuple[FloatArray, FloatArray]] = field(default_factory=dict)


def simulate(c: Combination, course_: Course) -> Motion:
    """Run a course."""
    out = _simulate(
        c.vector(), course_.speed, course_.wheel, course_.lane, course_.follow, course_.factor,
        course_.side, course_.rough,
    )  # fmt: skip
    return Motion(course_.time_s, course_.speed.copy(), *(out[:, i].copy() for i in range(6)))


SENSORS: dict[str, tuple[float, float, float]] = {
    "steering_wheel_angle": (math.radians(0.03), math.radians(0.1), math.radians(0.5)),
    "speed": (0.02, 0.01, 0.1),
    "car_yaw_rate": (math.radians(0.06), math.radians(0.01), math.radians(0.15)),
    "car_lateral_acceleration": (0.04, 0.01, 0.08),
    "trailer_yaw_rate": (math.radians(0.06), math.radians(0.01), math.radians(0.15)),
    "trailer_lateral_acceleration": (0.06, 0.01, 0.08),
}
"""Noise (standard deviation), step, and standard deviation of the offset of each sensor, SI."""


def measure(motion: Motion, rng: np.random.Generator) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Times and values of each sensor: own clock phase, jitter, noise, offset, steps."""
    result = {}
    for name, (noise, step, offset) in SENSORS.items():
        phase = rng.uniform(0, STEP_S)
        time_s = motion.time_s[:-2] + phase + rng.normal(0, 0.0003, len(motion.time_s) - 2)
        value = np.interp(time_s, motion.time_s, getattr(motion, name))
        value = value + rng.normal(0, offset) + rng.normal(0, noise, len(value))
        value = np.round(value / step) * step
        if name == "speed":
            value = np.maximum(value, 0)
        result[name] = (np.maximum.accumulate(time_s), value)
    return result


# --- what happens on the road -------------------------------------------------------------------


def coloured(rng: np.random.Generator, n: int, corner_hz: float, order: int = 1) -> FloatArray:
    """Unit-variance noise with a low-pass at `corner_hz`."""
    value = rng.normal(0, 1, n)
    a = math.exp(-2 * math.pi * corner_hz * STEP_S)
    for _ in range(order):
        value = _low_pass(value, a)
    spread = float(np.std(value))
    return value / spread if spread > 0 else value


@njit(cache=True)
def _low_pass(value: FloatArray, a: float) -> FloatArray:
    out = np.empty_like(value)
    state = 0.0
    for k in range(len(value)):
        state = a * state + (1 - a) * value[k]
        out[k] = state
    return out


def half_sine(time_s: FloatArray, start: float, length: float, amplitude: float) -> FloatArray:
    """One half-sine (length is half a period)."""
    inside = (time_s >= start) & (time_s < start + length)
    return np.where(inside, amplitude * np.sin(np.pi * (time_s - start) / length), 0.0)


def full_sine(
    time_s: FloatArray, start: float, period: float, amplitude: float, cycles: float = 1.0
) -> FloatArray:
    """Whole sines, for slalom and lane changes."""
    inside = (time_s >= start) & (time_s < start + cycles * period)
    return np.where(inside, amplitude * np.sin(2 * np.pi * (time_s - start) / period), 0.0)


def add_gusts(c: Course, rng: np.random.Generator, per_minute: float, force_n: float) -> None:
    """Single gusts of 1-cos shape, 0.4 to 4 s long, on both bodies (the trailer has the area)."""
    time_s = c.time_s
    for _ in range(rng.poisson(per_minute * time_s[-1] / 60)):
        start, length = rng.uniform(0, time_s[-1]), rng.uniform(0.4, 4.0)
        force = rng.normal(0, force_n)
        k0, k1 = round(start / STEP_S), round(min(start + length, time_s[-1]) / STEP_S)
        shape = 0.5 * (1 - np.cos(2 * np.pi * (time_s[k0:k1] - start) / length))
        c.side[k0:k1, 1] += force * shape
        c.side[k0:k1, 0] += 0.35 * force * shape


def add_turbulence(c: Course, rng: np.random.Generator, force_n: float) -> None:
    """Steady turbulence of the side wind, 0.3 Hz corner."""
    wind = coloured(rng, len(c.speed), 0.3)
    c.side[:, 1] += force_n * wind
    c.side[:, 0] += 0.35 * force_n * wind


def add_roughness(c: Course, rng: np.random.Generator, slip_rad: float) -> None:
    """Slip of each axle from ruts and roll, 2 Hz corner."""
    for axle in range(4):
        c.rough[:, axle] += slip_rad * coloured(rng, len(c.speed), 2.0, 2)


def add_hand(c: Course, rng: np.random.Generator, angle_rad: float) -> None:
    """Small movements of the driver's hand, 0.5 Hz corner."""
    c.wheel += angle_rad * coloured(rng, len(c.speed), 0.5, 2)
