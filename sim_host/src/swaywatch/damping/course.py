"""Damping over speed, or over any other channel: a fitted course and where it is zero.

The points carry their own errors; by how much they scatter more than these say (another push,
another road) is estimated with the course and added to each. The course is a line with a bend that
is held to what is known of it (:class:`Bend`), unless the points say otherwise, or a straight line.
So an extrapolation opens up as fast as it should. Zeros come with the set of speeds whose 95 % band
holds the target (Fieller's interval for a straight line): it is not symmetric, and not bounded
where the slope is not certain.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
import numpy.typing as npt
from scipy import optimize, stats

from swaywatch.damping.intervals import IntervalValue, Point, too_high

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

FEWEST_POINTS = 4


class Bend(Enum):
    """What is known of a course's bend before the points are seen.

    Attributes
    ----------
    NONE
        A straight line (Eq. 3.43, ISO 9815).
    ANY
        The slope may change over the range that was driven by as much as itself.
    TOWED
        A car with a trailer: what damps its sway are tyre forces, which fall like one over the
        speed; so the damping ratio goes like a power of the speed a little flatter than that.
    """

    NONE = 0
    ANY = 1
    TOWED = 2


TOWED_POWER, TOWED_SPREAD = -0.35, 0.3
"""Power of the speed that a towing combination's damping ratio goes with, and its standard
deviation over combinations. Second differences of the eigenvalues of 240 drawn combinations, half
of them on springs with relaxing tyres, over 10 to 35 km/h that end 5 to 30 km/h below a critical
speed of 85 to 180 km/h: -0.40 (95 % -0.63 to -0.12) planar, -0.31 (two thirds -0.50 to 0.04) on
springs."""

OWN_FREEDOM = 4.0
"""Repeats that the points' own errors are worth (two windows alone would have an interval of 12.7
standard errors)."""

SAME, WIDE = 0.02, 0.06
"""Of the mean speed: gap below which two points are at one place, and width up to which one place
is not divided. A speed that a driver or a treadmill holds varies by as much (1 to 6 % in the
recordings of the riderless bicycle)."""

_REACH = 2.0
"""Zeros are looked for up to this many spans beyond what was driven."""


@dataclass(frozen=True)
class Zero:
    """Where a course reaches a target; limits of 95 %, None: not bounded.

    Attributes
    ----------
    value
        None: nowhere within two spans of what was driven.
    excluded_up_to
        Highest value up to which (from the lowest driven on) the course is certain, with 95 %, not
        to have reached the target; None: not even at the lowest.
    """

    target: float
    value: float | None
    low: float | None
    high: float | None
    extrapolated: bool
    excluded_up_to: float | None


@dataclass(frozen=True)
class Course:
    """A sum of two or three functions of x, see :meth:`design`.

    Attributes
    ----------
    coefficients, covariance
        Of the functions; shapes (n,), (n, n).
    scatter
        Standard deviation of the points beyond their own errors.
    """

    quantity: str
    x: FloatArray
    y: FloatArray
    error: FloatArray
    middle: float
    half: float
    bend: Bend
    coefficients: FloatArray
    covariance: FloatArray
    scatter: float
    freedom: float

    @property
    def quantile(self) -> float:
        """Of Student's t for 95 %."""
        return float(stats.t.ppf(0.975, self.freedom))

    def design(self, x: FloatArray) -> FloatArray:
        """Values of the functions at x, shape (n, coefficients)."""
        return _design(np.asarray(x, dtype=np.float64), self.middle, self.half, self.bend)

    def at(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The course and its standard error, shape of x."""
        design = self.design(x)
        variance = np.einsum("...j,jk,...k->...", design, self.covariance, design)
        return np.asarray(design @ self.coefficients), np.sqrt(np.maximum(variance, 0.0))

    def value(self, x: float) -> IntervalValue:
        """The course at one place."""
        y, error = self.at(np.array([x]))
        return IntervalValue(float(y[0]), float(error[0]), self.freedom)

    def zero(self, target: float = 0.0) -> Zero:
        """Where the course falls or rises to a target; the place nearest to what was driven."""
        low, high = float(self.x.min()), float(self.x.max())
        reach = _REACH * max(high - low, 1e-9)
        first = max(0.0, low - reach) if low >= 0.0 else low - reach
        grid = np.unique(np.concatenate([np.linspace(first, high + reach, 8001), [low, high]]))
        y, error = self.at(grid)
        off = y - target
        value = _nearest_root(grid, off, low, high)
        outside = np.abs(off) > self.quantile * error
        excluded = _excluded(grid, outside, low)
        if value is None:
            return Zero(target, None, None, None, True, excluded)
        left, right = _bounds(grid, ~outside, value)
        return Zero(target, value, left, right, not low <= value <= high, excluded)


def _design(x: FloatArray, middle: float, half: float, bend: Bend) -> FloatArray:
    """One, the line over the driven range, and what it may bend by (none with ``Bend.NONE``)."""
    scaled = (x - middle) / half
    one = np.ones_like(scaled)
    if bend is Bend.NONE:
        return np.stack([one, scaled], axis=-1)
    if bend is Bend.ANY:
        return np.stack([one, scaled, scaled**2], axis=-1)

    def power(p: float) -> FloatArray:
        """x^p, shifted and stretched to value 0 and slope 1 per half at the middle."""
        log = np.log(np.maximum(x, 0.05 * middle) / middle)
        return np.asarray(np.expm1(p * log) / p * middle / half, dtype=np.float64)

    steep, flat = power(TOWED_POWER - TOWED_SPREAD), power(TOWED_POWER + TOWED_SPREAD)
    return np.stack([one, power(TOWED_POWER), 0.5 * (steep - flat)], axis=-1)


def _nearest_root(grid: FloatArray, off: FloatArray, low: float, high: float) -> float | None:
    """Root nearest to the range low..high."""
    crossing = np.flatnonzero(np.sign(off[:-1]) * np.sign(off[1:]) <= 0)
    if not len(crossing):
        return None
    step = off[crossing] - off[crossing + 1]
    part = np.where(step == 0.0, 0.0, off[crossing] / np.where(step == 0.0, 1.0, step))
    roots = grid[crossing] + part * (grid[crossing + 1] - grid[crossing])
    distance = np.maximum(np.maximum(low - roots, roots - high), 0.0)
    return float(roots[np.argmin(distance)])


def _bounds(grid: FloatArray, inside: BoolArray, value: float) -> tuple[float | None, float | None]:
    """Ends of the set `inside` around a value; None where it goes on to the end of the grid."""
    at = int(np.clip(np.searchsorted(grid, value), 0, len(grid) - 1))
    left = right = at
    while left > 0 and inside[left - 1]:
        left -= 1
    while right < len(grid) - 1 and inside[right + 1]:
        right += 1
    return (
        float(grid[left]) if left > 0 else None,
        float(grid[right]) if right < len(grid) - 1 else None,
    )


def _excluded(grid: FloatArray, outside: BoolArray, low: float) -> float | None:
    """How far the target is excluded without a break from `low` on."""
    start = int(np.searchsorted(grid, low))
    if not outside[start]:
        return None
    stop = start
    while stop < len(grid) - 1 and outside[stop + 1]:
        stop += 1
    return float(grid[stop])


def _solve(
    design: FloatArray, y: FloatArray, variance: FloatArray, prior: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Weighted least squares with a precision `prior` on each coefficient; and the covariance."""
    normal = design.T @ (design / variance[:, None]) + np.diag(prior)
    covariance = np.linalg.inv(normal)
    return covariance @ (design.T @ (y / variance)), np.asarray(covariance, dtype=np.float64)


def extra_scatter(design: FloatArray, y: FloatArray, error: FloatArray) -> float:
    """Standard deviation beyond the errors that makes chi-square equal to its freedom."""
    freedom = len(y) - np.linalg.matrix_rank(design)
    if freedom < 1:
        return 0.0
    none = np.zeros(design.shape[1])

    def excess(extra: float) -> float:
        variance = error**2 + extra**2
        c, _ = _solve(design, y, variance, none + 1e-12)
        return float(np.sum((y - design @ c) ** 2 / variance)) - float(freedom)

    if excess(0.0) <= 0.0:
        return 0.0
    most = float(np.ptp(y)) + 1e-12
    return float(optimize.brentq(excess, 0.0, most)) if excess(most) < 0.0 else most


def fit_course(
    points: Sequence[Point], quantity: str = "damping_ratio", bend: Bend = Bend.ANY
) -> Course | None:
    """Course of a quantity over the points' `against`.

    Parameters
    ----------
    points
        Those with an `against`; one with a wide interval counts by its error, one that may be
        overdamped does not count.
    quantity
        ``damping_ratio``, ``frequency_hz`` or ``growth_1_s``.
    bend
        What is known of the bend. ``ANY`` needs 6 points at 3 places, else the line is straight.

    Returns
    -------
    Course or None
        None: fewer than 4 points, or all at one place.
    """
    points = [point for point in points if not too_high(point.damping_ratio)]
    values: list[IntervalValue] = [getattr(point, quantity) for point in points]
    x = np.array([point.against for point in points], dtype=np.float64)
    y = np.array([value.value for value in values])
    error = np.maximum(np.array([value.error for value in values]), 1e-9)
    if len(x) < FEWEST_POINTS or not np.isfinite(x).all() or float(np.ptp(x)) <= 0.0:
        return None
    places = levels(x)
    spread = float(np.ptp(x))
    if len(places) < 2 or spread < 0.02 * max(abs(float(x.mean())), 1e-9):
        return None
    if bend is Bend.ANY and (len(places) < 3 or len(x) < 6):
        bend = Bend.NONE
    if bend is Bend.TOWED and float(x.min()) <= 0.0:
        bend = Bend.ANY
    middle, half = 0.5 * float(x.max() + x.min()), 0.5 * spread
    design = _design(x, middle, half, bend)
    line = design[:, :2]
    # a bend that is held counts as no free parameter of the scatter
    scatter = extra_scatter(design if bend is Bend.ANY else line, y, error)
    variance = error**2 + scatter**2
    prior = np.zeros(design.shape[1])
    if bend is not Bend.NONE:
        first, certain = _solve(line, y, variance, np.zeros(2))
        slope = max(abs(float(first[1])), math.sqrt(float(certain[1, 1])))
        prior[2] = 1.0 / max((1.0 if bend is Bend.TOWED else 0.5) * slope, 1e-12) ** 2
    coefficients, covariance = _solve(design, y, variance, prior)
    freedom = len(x) - (3 if bend is Bend.ANY else 2)
    return Course(
        quantity, x, y, error, middle, half, bend, coefficients, covariance, scatter,
        max(1.0, float(freedom)),
    )  # fmt: skip


def levels(x: FloatArray) -> list[npt.NDArray[np.int64]]:
    """Indices of the points by place: groups with gaps between, or slices of a wide group."""
    x = np.asarray(x, dtype=np.float64)
    order = np.argsort(x)
    spread = float(np.ptp(x))
    size = abs(float(x.mean())) if len(x) else 0.0
    if len(x) < 2 or spread < SAME * max(size, 1e-12):
        return [order.astype(np.int64)]
    gaps = np.flatnonzero(np.diff(x[order]) > max(0.05 * spread, SAME * size)) + 1
    found = []
    for group in np.split(order, gaps):
        width = float(np.ptp(x[group]))
        parts = min(
            max(1, math.ceil(width / max(0.2 * spread, WIDE * size))), max(1, len(group) // 3)
        )
        edges = np.linspace(float(x[group].min()), float(x[group].max()), parts + 1)[1:-1]
        slices = np.split(group, np.searchsorted(x[group], edges, side="right"))
        found += [part.astype(np.int64) for part in slices if len(part)]
    return found


def mean_of(values: Sequence[IntervalValue], *, ends: bool = True) -> IntervalValue:
    """Mean of repeats; its error is from their scatter, and from what moves them all alike.

    Parameters
    ----------
    values
        Of windows at one place.
    ends
        Count what the choice of the windows' ends does to all alike; not where two means are
        compared whose windows were chosen by the same rule, for it falls out of their difference.
    """
    y = np.array([value.value for value in values])
    error = np.maximum(np.array([value.error for value in values]), 1e-12)
    if len(y) == 1:
        return values[0]
    extra = extra_scatter(np.ones((len(y), 1)), y, error)
    # errors go with the value (the less damped swing is the longer one): weights by them alone
    # would pull the mean, so they are held together by their median
    weight = 1.0 / (error**2 + extra**2 + float(np.median(error)) ** 2)
    weight /= np.sum(weight)
    mean = float(np.sum(weight * y))
    spread = float(np.sum(weight * (y - mean) ** 2)) / (len(y) - 1)
    own = float(np.sum(weight**2 * error**2))
    freedom = float(len(y) - 1)
    alike = _alike(np.array([value.ends for value in values]), weight) if ends else 0.0
    if spread > own * float(stats.chi2.ppf(0.95, freedom)) / freedom:
        return IntervalValue(mean, math.sqrt(spread + alike), freedom)
    # no more than the errors say: both tell the same, so few repeats are not all that is known
    both = (OWN_FREEDOM * own + freedom * spread) / (OWN_FREEDOM + freedom)
    return IntervalValue(mean, math.sqrt(max(spread, both) + alike), OWN_FREEDOM + freedom)


def _alike(ends: FloatArray, weight: FloatArray) -> float:
    """Variance from the choice of the windows' ends, as far as it moves all repeats alike.

    A second motion that dies out beside the swing does so after every push alike: the scatter of
    the repeats does not show it.
    """
    mean = float(np.sum(weight * ends))
    chance = float(np.sum(weight * (ends - mean) ** 2)) / (len(ends) - 1)
    return max(0.0, mean**2 - chance)
