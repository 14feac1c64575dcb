"""Which runs of a fleet are unlike the others.

Each value that the analysis measures is compared, as its ratio to what vehicle.toml says, with
that of all other runs: the centre is the median; the fleet's own scatter is what explains the
median distance from it beyond the values' standard errors (as in random-effects meta-analysis,
DerSimonian and Laird 1986, with medians, so that the outliers sought do not widen it). A run
stands out beyond a distance that among as many normal values comes once in a hundred fleets.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq
from scipy.stats import norm

from swaywatch.analysis import AXLE_NAMES
from swaywatch.survey.outcome import SurveyOutcome

FloatArray = npt.NDArray[np.float64]

FEWEST = 8
"""Runs with a value, for a fleet that one of them can be unlike."""
FALSE_FLEETS = 0.01
"""Share of fleets of normal runs in which one stands out."""
NORMAL_MEDIAN = float(norm.isf(0.25))
"""Median of the absolute value of a standard normal number."""

NAMES = {
    "v_crit_m_s": "critical speed",
    "car_yaw_inertia_kgm2": "yaw inertia of the car",
    "trailer_yaw_inertia_kgm2": "yaw inertia of the trailer",
} | {f"{axle}.cornering_stiffness_n_per_rad": f"stiffness, {name}"
     for axle, name in AXLE_NAMES.items()}  # fmt: skip
"""Values that are compared, in words; others are in the table only."""


@dataclass(frozen=True)
class FleetComparison:
    """One value over the fleet.

    Attributes
    ----------
    name : key of :data:`NAMES`
    runs : places of the runs that have it, shape (n,)
    ratio : to the centre, of measured over believed, shape (n,)
    error : of the ratio: the value's own and the fleet's scatter, shape (n,)
    scatter : of the fleet, relative
    """

    name: str
    runs: npt.NDArray[np.intp]
    ratio: FloatArray
    error: FloatArray
    scatter: float

    @property
    def distance(self) -> FloatArray:
        """From the centre, in errors, shape (n,)."""
        return (self.ratio - 1.0) / self.error


def compare(outcomes: Sequence[SurveyOutcome]) -> list[FleetComparison]:
    """Every value that enough runs have, over the fleet."""
    return [found for name in NAMES if (found := _one(name, outcomes)) is not None]


def _one(name: str, outcomes: Sequence[SurveyOutcome]) -> FleetComparison | None:
    rows, ratios, errors = [], [], []
    for place, outcome in enumerate(outcomes):
        value, error, believed = outcome.values.get(name, [None, None, None])
        if value is None or error is None or not believed or error <= 0.0:
            continue
        rows.append(place)
        ratios.append(value / believed)
        errors.append(error / believed)
    if len(rows) < FEWEST:
        return None
    ratio, own = np.array(ratios), np.array(errors)
    centre = float(np.median(ratio))
    if centre <= 0.0:
        return None
    ratio, own = ratio / centre, own / centre
    scatter = scatter_of(ratio - 1.0, own)
    return FleetComparison(name, np.array(rows), ratio, np.hypot(own, scatter), scatter)


def scatter_of(distance: FloatArray, error: FloatArray) -> float:
    """Scatter beyond the errors that makes the median distance that of normal numbers."""

    def excess(scatter: float) -> float:
        return float(np.median(np.abs(distance) / np.hypot(error, scatter))) - NORMAL_MEDIAN

    if excess(0.0) <= 0.0:
        return 0.0
    return float(brentq(excess, 0.0, 1e3 * float(np.max(np.abs(distance)))))


def limit(comparisons: Sequence[FleetComparison]) -> float:
    """Distance beyond which a run stands out: once in a hundred normal fleets."""
    count = sum(len(entry.runs) for entry in comparisons)
    return float(norm.isf(FALSE_FLEETS / 2.0 / max(count, 1)))


def mark(outcomes: Sequence[SurveyOutcome]) -> list[FleetComparison]:
    """Say of each run what stands out, the strongest first; the comparisons behind it."""
    comparisons = compare(outcomes)
    far = limit(comparisons)
    found: dict[int, list[tuple[float, str]]] = {}
    for entry in comparisons:
        for place, ratio, distance in zip(entry.runs, entry.ratio, entry.distance, strict=True):
            if abs(distance) > far:
                found.setdefault(int(place), []).append(
                    (abs(distance), _sentence(entry, ratio, distance))
                )
    for place, outcome in enumerate(outcomes):
        outcome.stands_out = [text for _, text in sorted(found.get(place, []), reverse=True)]
    return comparisons


def strength(comparisons: Sequence[FleetComparison], count: int) -> FloatArray:
    """Largest distance of each of `count` runs in any value, shape (count,); 0: none."""
    most = np.zeros(count)
    for entry in comparisons:
        np.maximum.at(most, entry.runs, np.abs(entry.distance))
    return most


def _sentence(entry: FleetComparison, ratio: float, distance: float) -> str:
    off = abs(ratio - 1.0) * 100.0
    digits = 0 if off >= 10.0 else max(0, 1 - math.floor(math.log10(max(off, 1e-6))))
    return (
        f"{NAMES[entry.name]}: {off:.{min(digits, 3)}f} % {'below' if ratio < 1.0 else 'above'} "
        f"the fleet, {abs(distance):.0f} times its scatter"
    )
