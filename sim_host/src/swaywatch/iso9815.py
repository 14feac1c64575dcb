"""Damping against speed over several runs, after ISO 9815 and Eq. 3.43 of the reference.

Every free oscillation in the runs gives points (speed, damping ratio): the core's estimates of
windows that do not overlap, without steering, gaps or too small a swing. A straight line
``ratio = c0 + c1 v`` (3.43) through them, weighted, gives the zero-damping speed and the speed at
which the ratio is 0.05, each with a 95 % confidence interval (Fieller's, which is not symmetric and
is unbounded where the slope is not certain).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import optimize, stats

from swaywatch.analysis import DriveResult
from swaywatch.errors import RecordingError

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

LIMIT_RATIO = 0.05
"""Damping ratio whose speed is given beside that of zero damping."""

LEAST_SWING_RAD_S = math.radians(1.0)
"""Amplitude of the yaw rate below which an oscillation is not evaluated."""

FEWEST_POINTS = 4
LEAST_SPREAD_M_S = 5 / 3.6
"""Speeds of the points must differ by this much for a slope."""

_OUT = ("no_oscillation", "seeking", "forced", "gap", "misfit", "slow", "no_speed")


@dataclass(frozen=True)
class Point:
    """One window of free oscillation."""

    run: str
    time_s: float
    speed_m_s: float
    damping_ratio: float
    standard_error: float
    amplitude_rad_s: float
    frequency_hz: float


@dataclass(frozen=True)
class Speed:
    """Speed at which the line reaches a damping ratio; limits of 95 %, None: not bounded."""

    damping_ratio: float
    value_m_s: float | None
    low_m_s: float | None
    high_m_s: float | None
    extrapolated: bool


@dataclass(frozen=True)
class Evaluation:
    """The line through the points.

    Attributes
    ----------
    c0, c1
        Eq. 3.43; c1 in s/m.
    covariance : shape (2, 2)
        Of (c0, c1).
    disturbance_rad_s
        Amplitude of what disturbs the swings: adds ``disturbance / amplitude`` to the error of
        each point, chosen so that the points scatter as their errors say.
    """

    points: tuple[Point, ...]
    c0: float
    c1: float
    covariance: FloatArray
    disturbance_rad_s: float
    quantile: float
    zero: Speed
    limit: Speed

    def ratio(self, speed_m_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The line and the half-width of its 95 % band at some speeds."""
        design = np.stack([np.ones_like(speed_m_s), speed_m_s], axis=1)
        variance = np.einsum("ij,jk,ik->i", design, self.covariance, design)
        return self.c0 + self.c1 * speed_m_s, self.quantile * np.sqrt(variance)


def points_of(result: DriveResult) -> list[Point]:
    """Windows of free oscillation of one run that do not overlap."""
    estimates = result.estimates
    if not len(estimates):
        return []
    good = estimates.has("line") & (estimates["amplitude_rad_s"] >= LEAST_SWING_RAD_S)
    for flag in _OUT:
        good &= ~estimates.flagged(flag)
    points = []
    last_s = -math.inf
    for k in np.flatnonzero(good):
        time_s = float(estimates.time_s[k])
        if time_s - last_s < float(estimates["window_s"][k]):
            continue
        last_s = time_s
        points.append(
            Point(
                result.drive.name,
                time_s,
                float(estimates["speed_m_s"][k]),
                float(estimates["damping_ratio"][k]),
                float(estimates["damping_ratio_se"][k]),
                float(estimates["amplitude_rad_s"][k]),
                float(estimates["frequency_hz"][k]),
            )
        )
    return points


def _fit(
    speed: FloatArray, ratio: FloatArray, variance: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """Weighted line: coefficients, covariance, chi-square."""
    design = np.stack([np.ones_like(speed), speed], axis=1)
    normal = design.T @ (design / variance[:, None])
    covariance = np.linalg.inv(normal).astype(np.float64)
    coefficients = covariance @ (design.T @ (ratio / variance))
    residual = ratio - design @ coefficients
    return coefficients, covariance, float(np.sum(residual**2 / variance))


def _crossing(
    target: float,
    coefficients: FloatArray,
    covariance: FloatArray,
    quantile: float,
    measured: tuple[float, float],
) -> Speed:
    """Where the line reaches `target`, with Fieller's interval."""
    c0, c1 = float(coefficients[0]) - target, float(coefficients[1])
    q = quantile**2
    a = c1**2 - q * covariance[1, 1]
    if a <= 0 or c1 >= 0:  # the slope is not certain to fall: no bounded interval
        value = -c0 / c1 if c1 < 0 else None
        return Speed(target, value, None, None, True)
    b = c0 * c1 - q * covariance[0, 1]
    c = c0**2 - q * covariance[0, 0]
    root = math.sqrt(max(b * b - a * c, 0.0))
    value = -c0 / c1
    low, high = (-b - root) / a, (-b + root) / a
    return Speed(target, value, low, high, not measured[0] <= value <= measured[1])


def evaluate(results: Sequence[DriveResult]) -> Evaluation:
    """Line through the points of all runs.

    Raises
    ------
    RecordingError
        Too few free oscillations, or at too much the same speed.
    """
    points = [point for result in results for point in points_of(result)]
    names = ", ".join(str(path) for result in results for path in result.drive.files)
    if len(points) < FEWEST_POINTS:
        raise RecordingError(
            f"{names}: {len(points)} windows of free oscillation; a regression of damping over "
            f"speed needs {FEWEST_POINTS} or more (steering held after an impulse, swing above "
            f"{math.degrees(LEAST_SWING_RAD_S):g} deg/s)"
        )
    speed = np.array([p.speed_m_s for p in points])
    if float(np.ptp(speed)) < LEAST_SPREAD_M_S:
        raise RecordingError(
            f"{names}: all free oscillations at {speed.min() * 3.6:.1f} to "
            f"{speed.max() * 3.6:.1f} km/h; a regression over speed needs runs at speeds that "
            f"differ by {LEAST_SPREAD_M_S * 3.6:g} km/h or more"
        )
    ratio = np.array([p.damping_ratio for p in points])
    error = np.array([p.standard_error for p in points])
    amplitude = np.array([p.amplitude_rad_s for p in points])
    freedom = len(points) - 2

    def excess(disturbance: float) -> float:
        variance = error**2 + (disturbance / amplitude) ** 2
        return _fit(speed, ratio, variance)[2] - freedom

    most = 0.1
    disturbance = 0.0
    if excess(0.0) > 0:
        disturbance = float(optimize.brentq(excess, 0.0, most)) if excess(most) < 0 else most
    variance = error**2 + (disturbance / amplitude) ** 2
    coefficients, covariance, _ = _fit(speed, ratio, variance)
    quantile = float(stats.t.ppf(0.975, freedom))
    measured = (float(speed.min()), float(speed.max()))
    return Evaluation(
        tuple(points),
        float(coefficients[0]),
        float(coefficients[1]),
        covariance,
        disturbance,
        quantile,
        _crossing(0.0, coefficients, covariance, quantile, measured),
        _crossing(LIMIT_RATIO, coefficients, covariance, quantile, measured),
    )
