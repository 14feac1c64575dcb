"""Swings that are another motion than the rest at their speed.

A gust while turning, a rider who catches the vehicle, a swing of another mode: each may be one
damped line, and its damping is not that of the others. Where most swings at a place agree, one
whose frequency or damping ratio lies far from theirs is named and left out of means and course.
Far: beyond its own error and what repeats scatter beyond their errors. Where no such majority
exists, nobody can say which of the motions is meant, so nothing is left out.

A force that acts meanwhile (a hand that is withdrawn slowly) can leave frequency and damping as
they are, but not the shape of the swing. Where a signal is named that swings along, a swing is
another motion if its shape differs by more than an input may add (FORCED_SHARE) and the error from
quiet time together. The usual shape is that of most of the energy: a large swing is the mode's
more certainly than a small one. That is sharp for the angle between two bodies (a fork, an
articulation): what a slow force does shows there. A rate has other modes in it, and a rate's own
integral moves as the rate does, whatever acts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from swaywatch.damping.course import levels
from swaywatch.damping.find import FORCED_SHARE
from swaywatch.damping.intervals import Point

FloatArray = npt.NDArray[np.float64]

FEWEST = 6
"""Swings at a place from which most of them say what is usual."""

FAR = 3.0
"""Standard deviations (own error and scatter of the repeats) beyond which it is another motion."""

CERTAIN = 2.0
"""Standard errors of a shape beside what an input may add."""

_NORMAL = 1.4826
"""Standard deviation over the median absolute deviation."""


def parted(points: Sequence[Point]) -> tuple[tuple[Point, ...], tuple[Point, ...]]:
    """Points of the usual swing, and those of another motion; both in order."""
    if not points:
        return (), ()
    x = np.array([point.against for point in points])
    groups = levels(x) if np.isfinite(x).all() else [np.arange(len(x))]
    other: set[int] = set()
    for group in groups:
        part = [points[k] for k in group]
        other |= {int(k) for k in group[_far(part) | _misshapen(part)]}
    usual = tuple(point for k, point in enumerate(points) if k not in other)
    return usual, tuple(point for k, point in enumerate(points) if k in other)


def _far(points: Sequence[Point]) -> npt.NDArray[np.bool_]:
    """Which of the points at one place are far from most of them."""
    known = np.array([point.determinable for point in points])
    far = np.zeros(len(points), dtype=np.bool_)
    if known.sum() < FEWEST:
        return far
    for name in ("frequency_hz", "damping_ratio"):
        value = np.array([getattr(point, name).value for point in points])
        error = np.array([getattr(point, name).error for point in points])
        middle = float(np.median(value[known]))
        scatter = _NORMAL * float(np.median(np.abs(value[known] - middle)))
        # the windows scatter by their own errors too: what repeats add is what is beyond these
        repeats = max(0.0, scatter**2 - float(np.median(error[known] ** 2)))
        far |= np.abs(value - middle) > FAR * np.sqrt(error**2 + repeats)
    # more than a third of them: there is no usual swing here
    return far if far[known].mean() <= 1.0 / 3.0 else np.zeros_like(far)


def _misshapen(points: Sequence[Point]) -> npt.NDArray[np.bool_]:
    """In which of the points at one place other signals do not swing along as usual.

    A line that is not known well enough to state its damping is no wave to look for elsewhere: its
    shape is not judged.
    """
    misshapen = np.zeros(len(points), dtype=np.bool_)
    shapes = [(k, p.shape) for k, p in enumerate(points) if p.determinable and p.shape is not None]
    if len(shapes) < FEWEST:
        return misshapen
    ratio = np.array([shape.middle[1:] / shape.middle[0] for _, shape in shapes])
    energy = np.array([float(points[k].amplitude[0]) ** 2 for k, _ in shapes])
    usual = np.array([_middle(z.real, energy) + 1j * _middle(z.imag, energy) for z in ratio.T])
    for k, shape in shapes:
        off, error = shape.off(usual)
        misshapen[k] = bool((off > np.hypot(FORCED_SHARE, CERTAIN * error)).any())
    # more than half of the energy: there is no usual shape here
    part = float(energy[misshapen[[k for k, _ in shapes]]].sum())
    return misshapen if part <= 0.5 * float(energy.sum()) else np.zeros_like(misshapen)


def _middle(value: FloatArray, weight: FloatArray) -> float:
    """Weighted median."""
    order = np.argsort(value)
    total = np.cumsum(weight[order])
    return float(value[order][np.searchsorted(total, 0.5 * total[-1])])
