"""Damping at small swings, where tyres or dampers give less of it to large ones.

One line over a whole swing gives a mean over its sizes. Here each window is cut into parts of two
cycles or more, and the parts of all swings at a speed tell how the damping ratio goes with the
amplitude A: ratio = c[0] + c[1] law(A). Three laws are physics: A (brush tyre), A^2 (smooth
saturation, the first term that symmetry allows) and a knee (degressive damper: constant up to an
amplitude somewhere within what was driven). All are fitted, they count as well as they fit, and
what they differ by is part of the interval. So c[0] is known only as well as the sizes that were
driven allow.

Dry friction goes like 1/A: where that fits clearly better there is no value at small amplitude.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy import stats

from swaywatch.damping.course import OWN_FREEDOM, extra_scatter
from swaywatch.damping.intervals import IntervalValue, Point, SwingPart

FloatArray = npt.NDArray[np.float64]

FEWEST_PARTS = 3

CLEAR = 8.0
"""Amplitude of a part over what its line leaves: near the motion that goes on anyway, that motion
decides how a swing dies out, and a swing that ends in it would look as if its damping fell."""

KNEES = (1.4, 2.0, 2.8, 4.0, 5.6)
"""Amplitudes up to which a damper is taken as linear, over that of the smallest part."""

FIRST_ORDER = 0.1
"""Of the change: a growth that varies within a cycle is averaged to first order only."""

Law = Callable[[FloatArray], FloatArray]

_CLEARLY = 2.0
"""Less chi-square by which 1/A has to fit better than any law that has an end."""


@dataclass(frozen=True)
class SmallSwing:
    """The damping ratio by the size of the swing.

    Attributes
    ----------
    damping_ratio
        At small amplitude; None: it grows towards small swings as with dry friction.
    change
        Of the damping ratio from small amplitude to the largest part.
    channel
        Index of the channel whose amplitude is meant.
    smallest, largest
        Amplitudes of the parts, in that channel's unit.
    p_value
        Of no change with the size.
    """

    damping_ratio: IntervalValue | None
    change: IntervalValue
    channel: int
    smallest: float
    largest: float
    p_value: float

    @property
    def depends(self) -> bool:
        """On the size, with 99 %: it is asked at every speed."""
        return self.p_value < 0.01


def small_swing(points: Sequence[Point]) -> SmallSwing | None:
    """Of the swings at one place; None: too few parts, or all of one size."""
    parts = [part for point in points for part in point.parts if _clear(part)]
    if len(parts) < FEWEST_PARTS or len({part.amplitude.shape for part in parts}) > 1:
        return None
    heard = np.array([part.amplitude / np.maximum(part.noise, 1e-300) for part in parts])
    channel = int(np.argmax(np.sum(np.minimum(heard, 1e6) ** 2, axis=0)))
    size = np.array([part.amplitude[channel] for part in parts])
    if size.min() <= 0.0 or size.max() < 1.3 * size.min():
        return None
    y = np.array([part.damping_ratio.value for part in parts])
    error = np.maximum([part.damping_ratio.error for part in parts], 1e-6)
    laws, prior = _laws(float(size.min()), float(size.max()))
    fits = [_fit(_design(parts, size, law), y, error) for law in laws]
    friction = _fit(_design(parts, size, _rubbing), y, error)
    best = min(fit.chi_square for fit in fits)
    # where the parts scatter more than their errors say, so do these sums
    beyond = max(1.0, min(best, friction.chi_square) / max(len(parts) - 2, 1))
    weight = prior * np.exp(-0.5 * (np.array([fit.chi_square for fit in fits]) - best) / beyond)
    weight /= weight.sum()
    change = _mixed([fit.value(np.array([0.0, 1.0])) for fit in fits], weight)
    small = _mixed([fit.value(np.array([1.0, 0.0])) for fit in fits], weight)
    small = replace(small, error=math.hypot(small.error, FIRST_ORDER * change.value))
    rubs = friction.chi_square < best - _CLEARLY * beyond and friction.coefficients[1] > 0.0
    p_value = float(2.0 * stats.t.sf(abs(change.value) / change.error, change.freedom))
    return SmallSwing(
        None if rubs else small, change, channel, float(size.min()), float(size.max()), p_value
    )


def _clear(part: SwingPart) -> bool:
    return bool(np.max(part.amplitude / np.maximum(part.noise, 1e-300)) >= CLEAR)


@dataclass(frozen=True)
class _Fit:
    coefficients: FloatArray
    covariance: FloatArray
    chi_square: float
    freedom: float

    def value(self, row: FloatArray) -> IntervalValue:
        error = math.sqrt(float(row @ self.covariance @ row))
        return IntervalValue(float(row @ self.coefficients), error, self.freedom)


def _fit(design: FloatArray, y: FloatArray, error: FloatArray) -> _Fit:
    """Weighted least squares; the parts' scatter beyond their errors is added to each."""
    extra = extra_scatter(design, y, error)
    variance = error**2 + extra**2
    covariance = np.asarray(
        np.linalg.pinv(design.T @ (design / variance[:, None])), dtype=np.float64
    )
    c = np.asarray(covariance @ (design.T @ (y / variance)), dtype=np.float64)
    chi_square = float(np.sum((y - design @ c) ** 2 / error**2))
    return _Fit(c, covariance, chi_square, OWN_FREEDOM + len(y) - 2.0)


def _rubbing(size: FloatArray) -> FloatArray:
    """Dry friction."""
    return 1.0 / size


def _knee(at: float) -> Law:
    """What a damper lacks whose force rises no more beyond an amplitude (describing function)."""

    def lacks(size: FloatArray) -> FloatArray:
        part = np.minimum(1.0, at / np.maximum(size, 1e-300))
        whole = 2.0 / math.pi * (np.arcsin(part) + part * np.sqrt(1.0 - part**2))
        return np.asarray(1.0 - whole, dtype=np.float64)

    return lacks


def _laws(smallest: float, largest: float) -> tuple[list[Law], FloatArray]:
    """The laws and how much each counts before the parts are seen: the three kinds alike."""
    knees = [_knee(times * smallest) for times in KNEES if times * smallest < 0.8 * largest]
    laws: list[Law] = [lambda size: size, np.square, *knees]
    return laws, np.array([1.0, 1.0, *([1.0 / max(1, len(knees))] * len(knees))])


def _design(parts: Sequence[SwingPart], size: FloatArray, law: Law) -> FloatArray:
    """One, and the mean of a law as each part's growth sees it, over the largest of them."""
    mean = np.array([_seen(part.fall, one, law) for part, one in zip(parts, size, strict=True)])
    return np.stack([np.ones(len(mean)), mean / max(float(np.abs(mean).max()), 1e-300)], axis=1)


def _seen(fall: float, size: float, law: Law) -> float:
    """By what the growth of a part is moved if it goes like a law of the amplitude.

    Least squares weigh ln A by A^2, so the slope sees the larger half of a part more.
    """
    time = (np.arange(64) + 0.5) / 64.0 - 0.5
    moved = np.cumsum(law(size * np.exp(fall * time))) / 64.0
    weight = np.exp(2.0 * fall * time)
    off = time - np.sum(weight * time) / np.sum(weight)
    return float(np.sum(weight * off * moved) / np.sum(weight * off**2))


def _mixed(values: Sequence[IntervalValue], weight: FloatArray) -> IntervalValue:
    """Mean of what the laws say; how far they are apart is part of its error."""
    each = np.array([value.value for value in values])
    mean = float(weight @ each)
    variance = float(weight @ (np.array([value.error**2 for value in values]) + (each - mean) ** 2))
    return IntervalValue(mean, math.sqrt(variance), values[0].freedom)
