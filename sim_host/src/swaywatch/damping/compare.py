"""Is it the same? Two groups of runs, or runs and a linear model, place by place and in all."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy import stats

from swaywatch.damping.course import levels, mean_of
from swaywatch.damping.intervals import QUANTITIES, IntervalValue, Point
from swaywatch.damping.model import LinearModel

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Difference:
    """Of one quantity at one place (or over all of them, `place` None).

    Attributes
    ----------
    first, second
        The two groups' means, or the model and the measurement; None over all places.
    difference
        First minus second, with its interval; over all places the weighted mean of them.
    p_value
        Of no difference, two-sided.
    """

    quantity: str
    place: float | None
    first: IntervalValue | None
    second: IntervalValue | None
    difference: IntervalValue
    p_value: float

    @property
    def differs(self) -> bool:
        """With 95 %."""
        return self.p_value < 0.05


@dataclass(frozen=True)
class Comparison:
    """Of two groups, or of a model with a measurement.

    Attributes
    ----------
    apart
        Where each group was, if they were nowhere at the same speed (or other channel) and the
        nearest places are compared: what the speed changes is then part of the differences.
    """

    names: tuple[str, str]
    at: tuple[Difference, ...]
    over_all: tuple[Difference, ...]
    apart: tuple[float, float] | None = None

    def of(self, quantity: str) -> list[Difference]:
        """The places of a quantity."""
        return [one for one in self.at if one.quantity == quantity]

    def total(self, quantity: str) -> Difference | None:
        """Over all places."""
        return next((one for one in self.over_all if one.quantity == quantity), None)

    @property
    def p_value(self) -> float:
        """Of no difference at all: frequency and growth are two chances."""
        both = [one.p_value for one in self.over_all if one.quantity != "damping_ratio"]
        return min(1.0, 2.0 * min(both)) if both else 1.0


def _difference(
    quantity: str, place: float | None, first: IntervalValue, second: IntervalValue
) -> Difference:
    """Welch's test of two means."""
    error = math.hypot(first.error, second.error)
    parts = [v.error**4 / v.freedom for v in (first, second) if v.freedom > 0 and v.error > 0]
    freedom = error**4 / sum(parts) if parts else 1.0
    value = IntervalValue(first.value - second.value, error, max(1.0, freedom))
    return Difference(quantity, place, first, second, value, _p_value(value))


def _p_value(value: IntervalValue) -> float:
    if value.error <= 0.0:
        return 1.0 if value.value == 0.0 else 0.0
    return float(2.0 * stats.t.sf(abs(value.value) / value.error, value.freedom))


def _together(quantity: str, places: Sequence[Difference]) -> Difference:
    """Weighted mean of the differences at all places; its error is not below their scatter's."""
    y = np.array([place.difference.value for place in places])
    error = np.array([max(place.difference.error, 1e-12) for place in places])
    weight = 1.0 / error**2
    mean = float(np.sum(weight * y) / np.sum(weight))
    freedom = float(sum(place.difference.freedom for place in places))
    value = IntervalValue(mean, float(1.0 / math.sqrt(np.sum(weight))), max(1.0, freedom))
    # Differences that change sign from place to place are differences all the same: chi-square.
    chi_square = float(np.sum((y / error) ** 2))
    p_value = min(_p_value(value), float(stats.f.sf(chi_square / len(y), len(y), value.freedom)))
    return Difference(quantity, None, None, None, value, min(1.0, 2.0 * p_value))


def compare_groups(
    first: Sequence[Point], second: Sequence[Point], names: tuple[str, str]
) -> Comparison | None:
    """Two groups of runs where both have points, else where they are nearest; None: one is empty.

    Without a speed (or another channel) all points are at one place.
    """
    if not first or not second:
        return None
    both = [*first, *second]
    x = np.array([point.against for point in both])
    groups = levels(x) if np.isfinite(x).all() else [np.arange(len(both))]
    at: list[Difference] = []
    for group in groups:
        parts = [[both[i] for i in group if (i < len(first)) == own] for own in (True, False)]
        if min(map(len, parts)) < 1:
            continue
        place = float(np.mean([both[i].against for i in group]))
        for quantity in QUANTITIES:
            means = [mean_of([getattr(p, quantity) for p in part], ends=False) for part in parts]
            at.append(_difference(quantity, place, *means))
    return _comparison(names, at) or _nearest(first, second, names)


def _nearest(
    first: Sequence[Point], second: Sequence[Point], names: tuple[str, str]
) -> Comparison | None:
    """The two places of the groups that are nearest to each other."""
    sides = []
    for points in (first, second):
        x = np.array([point.against for point in points])
        sides.append(
            [(float(np.mean(x[group])), [points[i] for i in group]) for group in levels(x)]
        )
    left, right = min(
        ((one, other) for one in sides[0] for other in sides[1]),
        key=lambda pair: abs(pair[0][0] - pair[1][0]),
    )
    at = [
        _difference(
            quantity,
            None,
            *(
                mean_of([getattr(p, quantity) for p in part], ends=False)
                for _, part in (left, right)
            ),
        )
        for quantity in QUANTITIES
    ]
    comparison = _comparison(names, at)
    return comparison and replace(comparison, apart=(left[0], right[0]))


def compare_model(points: Sequence[Point], model: LinearModel) -> Comparison | None:
    """A linear model (first) with the measurement (second) at the places that were driven."""
    x = np.array([point.against for point in points])
    placed = bool(np.isfinite(x).all())
    if not len(x) or not (placed or model.anywhere):
        return None
    at: list[Difference] = []
    for group in levels(x) if placed else [np.arange(len(x))]:
        part = [points[i] for i in group]
        place = float(np.mean(x[group]))
        means = {name: mean_of([getattr(point, name) for point in part]) for name in QUANTITIES}
        pole = model.pole(
            place, complex(means["growth_1_s"].value, 2 * math.pi * means["frequency_hz"].value)
        )
        if pole is None:
            continue
        own = {
            "damping_ratio": -pole.real / abs(pole),
            "frequency_hz": pole.imag / (2 * math.pi),
            "growth_1_s": pole.real,
        }
        for name in QUANTITIES:
            at.append(
                _difference(name, place, IntervalValue(own[name], 0.0, math.inf), means[name])
            )
    return _comparison((model.name, "measured"), at)


def _comparison(names: tuple[str, str], at: list[Difference]) -> Comparison | None:
    if not at:
        return None
    total = [_together(name, [one for one in at if one.quantity == name]) for name in QUANTITIES]
    return Comparison(names, tuple(at), tuple(total))
