"""Swings that are another motion than the rest at their speed.

A gust while turning, a rider who catches the vehicle, a swing of another mode: each may be one
damped line, and its damping is not that of the others. Where most swings at a place agree, one
whose frequency or damping ratio lies far from theirs is named and left out of means and course.
Far: beyond its own error and what repeats scatter beyond their errors. Where no such majority
exists, nobody can say which of the motions is meant, so nothing is left out.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from swaywatch.damping.course import levels
from swaywatch.damping.intervals import Point

FloatArray = npt.NDArray[np.float64]

FEWEST = 6
"""Swings at a place from which most of them say what is usual."""

FAR = 3.0
"""Standard deviations (own error and scatter of the repeats) beyond which it is another motion."""

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
        other |= {int(k) for k in group[_far([points[k] for k in group])]}
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
