"""The whole evaluation: runs in; points, course, zero, comparisons and sentences out."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from swaywatch import __version__
from swaywatch.damping.alike import parted
from swaywatch.damping.compare import Comparison, Difference, compare_groups, compare_model
from swaywatch.damping.course import (
    TOWED_POWER,
    TOWED_SPREAD,
    Bend,
    Course,
    Zero,
    fit_course,
    levels,
    mean_of,
)
from swaywatch.damping.data import Choice, DampingRun, load_runs
from swaywatch.damping.find import SLOWEST, Found, find
from swaywatch.damping.intervals import (
    QUANTITIES,
    IntervalValue,
    Point,
    known,
    points_of,
    sure,
    too_high,
)
from swaywatch.damping.model import LinearModel
from swaywatch.damping.size import SmallSwing, small_swing
from swaywatch.damping.window import Estimator
from swaywatch.errors import RecordingError, SignalError

LIMIT_RATIO = 0.05
"""Damping ratio whose speed ISO 9815 gives beside that of zero damping."""

LEAST_SPREAD_M_S = 5 / 3.6
"""Speeds of an evaluation after ISO 9815 must differ by this much."""

FEWEST_ISO_POINTS = 4


@dataclass(frozen=True)
class StudyPlan:
    """What is asked for.

    Attributes
    ----------
    against_values
        Speed (or what else) of each recording, where no channel has it.
    iso9815
        A towing combination's test: zero-damping speed and the speed of damping ratio 0.05, with
        the bend of its damping; the standard's straight line beside it.
    """

    choice: Choice
    band_hz: tuple[float, float] = (0.2, 10.0)
    against_values: tuple[float, ...] = ()
    iso9815: bool = False


@dataclass(frozen=True)
class SpeedGroup:
    """The points at one speed: number of them, means of damping ratio, frequency and growth.

    Attributes
    ----------
    small
        The damping by the size of the swing; None where the swings are too few or of one size.
    """

    against: float
    count: int
    runs: tuple[str, ...]
    damping_ratio: IntervalValue
    frequency_hz: IntervalValue
    growth_1_s: IntervalValue
    small: SmallSwing | None = None

    @property
    def determinable(self) -> bool:
        """The mean damping ratio is known to 0.2 or better, and is surely that of a swing."""
        return known(self.damping_ratio) and not too_high(self.damping_ratio)


@dataclass(frozen=True)
class Study:
    """The result; `compared` is the second group's, `line` the straight one of ISO 9815.

    Attributes
    ----------
    names
        Of the two groups.
    others
        Windows of another motion than the rest at their speed, left out.
    """

    plan: StudyPlan
    found: tuple[Found, ...]
    points: tuple[Point, ...]
    places: tuple[SpeedGroup, ...]
    course: Course | None
    zero: Zero | None
    limit: Zero | None
    line: Course | None = None
    compared: Study | None = None
    groups: Comparison | None = None
    model: LinearModel | None = None
    against_model: Comparison | None = None
    others: tuple[Point, ...] = ()
    names: tuple[str, str] = ("first", "second")

    @property
    def against_name(self) -> str:
        """What damping is drawn over."""
        return next((f.run.against_name for f in self.found if f.run.against_name), "")

    @property
    def against_unit(self) -> str:
        """Its unit as the file says."""
        return next((f.run.against_unit for f in self.found if f.run.against_unit), "")


def evaluate(
    paths: Sequence[Path],
    plan: StudyPlan,
    *,
    compare: Sequence[Path] = (),
    names: tuple[str, str] = ("first", "second"),
    model: LinearModel | None = None,
    progress: Callable[[str, float, float], None] | None = None,
) -> Study:
    """Read, find, estimate, fit, compare.

    Raises
    ------
    SwaywatchError
        The input is at fault, or is not enough for ISO 9815.
    """
    study = _study(paths, plan, progress)
    if plan.iso9815:
        _must_do(study)
    if compare:
        if plan.against_values:
            raise SignalError(
                "--against-values is for one group of recordings; to compare, the speed must be a "
                "channel (--against)"
            )
        second = _study(compare, plan, progress)
        groups = compare_groups(study.points, second.points, names)
        study = replace(study, compared=second, groups=groups, names=names)
    if model is not None:
        model = model.over(study.against_unit)
        placed = any(math.isfinite(point.against) for point in study.points)
        if study.points and not placed and not model.anywhere:
            raise SignalError(
                "the model needs a speed: name the channel with --against, or one number for each "
                "recording with --against-values"
            )
        study = replace(study, model=model, against_model=compare_model(study.points, model))
    return study


def _study(
    paths: Sequence[Path], plan: StudyPlan, progress: Callable[[str, float, float], None] | None
) -> Study:
    runs = load_runs(paths, plan.choice)
    if plan.against_values:
        if len(plan.against_values) != len(runs):
            raise SignalError(
                f"--against-values: {len(plan.against_values)} numbers for {len(runs)} recordings"
            )
        runs = [
            replace(run, against=np.full(len(run.time_s), value), against_name="given value")
            for run, value in zip(runs, plan.against_values, strict=True)
        ]
    return study_of(runs, plan, progress)


def study_of(
    runs: Sequence[DampingRun],
    plan: StudyPlan,
    progress: Callable[[str, float, float], None] | None = None,
) -> Study:
    """One group of runs that are loaded already (`data.load_runs`, `data.run_of`).

    Raises
    ------
    RecordingError
        A run is too slow or too short for the band.
    """
    estimator = Estimator()
    found = []
    for number, run in enumerate(runs):
        if progress:
            progress(f"evaluating {run.name}", number, len(runs))
        found.append(sure(find(run, _band(run, plan.band_hz), estimator)))
    points, others = parted([point for one in found for point in points_of(one)])
    course = fit_course(points, bend=Bend.TOWED if plan.iso9815 else Bend.ANY)
    return Study(
        plan,
        tuple(found),
        points,
        _places(points),
        course,
        course.zero() if course else None,
        course.zero(LIMIT_RATIO) if course else None,
        fit_course(points, bend=Bend.NONE) if plan.iso9815 else None,
        others=others,
    )


def _band(run: DampingRun, band_hz: tuple[float, float]) -> tuple[float, float]:
    """The band, refused where the recording is too slow for it."""
    if band_hz[0] * SLOWEST * run.step_s >= 1.0:
        raise RecordingError(
            f"{run.path}: {1.0 / run.step_s:.3g} samples a second are too few for a line of "
            f"{band_hz[0]:g} Hz and more; see --band"
        )
    if run.duration_s * band_hz[1] <= 1.0:
        raise RecordingError(
            f"{run.path}: lasts {run.duration_s:.3g} s, less than one swing of {band_hz[1]:g} Hz; "
            "see --band"
        )
    if run.duration_s * band_hz[0] < 1.0:
        return (1.0 / run.duration_s, band_hz[1])
    return band_hz


def _places(points: Sequence[Point]) -> tuple[SpeedGroup, ...]:
    """Means by speed; of all together where there is no speed."""
    x = np.array([point.against for point in points])
    if not len(x):
        return ()
    groups = levels(x) if np.isfinite(x).all() else [np.arange(len(x))]
    places = []
    for group in groups:
        part = [points[i] for i in group]
        mean = {name: mean_of([getattr(point, name) for point in part]) for name in QUANTITIES}
        runs = tuple(dict.fromkeys(point.run for point in part))
        small = small_swing(part)
        places.append(SpeedGroup(float(np.mean(x[group])), len(part), runs, **mean, small=small))
    return tuple(places)


def _must_do(study: Study) -> None:
    """Refuse what ISO 9815 cannot be applied to."""
    names = ", ".join(str(found.run.path) for found in study.found)
    speeds = np.array([point.against for point in study.points])
    if len(speeds) < FEWEST_ISO_POINTS:
        raise RecordingError(
            f"{names}: {len(speeds)} windows of free oscillation; a regression of damping over "
            f"speed needs {FEWEST_ISO_POINTS} or more (steering held after an impulse)"
        )
    if not np.isfinite(speeds).all():
        raise SignalError(f"{names}: no speed; name its channel with --against")
    if float(np.ptp(speeds)) < LEAST_SPREAD_M_S or study.course is None:
        raise RecordingError(
            f"{names}: all free oscillations at {speeds.min() * 3.6:.1f} to "
            f"{speeds.max() * 3.6:.1f} km/h; a regression over speed needs runs at speeds that "
            f"differ by {LEAST_SPREAD_M_S * 3.6:g} km/h or more"
        )


def as_json(study: Study) -> dict[str, Any]:
    """Everything in plain numbers; null where there is none."""
    content: dict[str, Any] = {
        "swaywatch": __version__,
        "recordings": [_run_json(found) for found in study.found],
        "against": {"signal": study.against_name, "unit": study.against_unit},
        "windows": [_point_json(point) for point in study.points],
        "other_motion": [_point_json(point) for point in study.others],
        "places": [
            {
                "against": _number(place.against),
                "windows": place.count,
                "recordings": list(place.runs),
                "determinable": place.determinable,
                **{name: _value_json(getattr(place, name)) for name in QUANTITIES},
                "by_size": _size_json(study, place.small),
            }
            for place in study.places
        ],
        "course": None if study.course is None else _course_json(study.course),
        "zero_damping": _zero_json(study.zero),
        "limit_damping": _zero_json(study.limit),
    }
    if study.line is not None:
        content["straight_line"] = {
            **_course_json(study.line),
            "zero_damping": _zero_json(study.line.zero()),
            "limit_damping": _zero_json(study.line.zero(LIMIT_RATIO)),
        }
    if study.compared is not None:
        content["compared_with"] = as_json(study.compared)
        content["difference"] = _comparison_json(study.groups)
    if study.model is not None:
        content["model"] = _comparison_json(study.against_model)
    return content


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _value_json(value: IntervalValue) -> dict[str, float | None]:
    return {
        "value": _number(value.value),
        "standard_error": _number(value.error),
        "low_95": _number(value.low),
        "high_95": _number(value.high),
    }


def _size_json(study: Study, small: SmallSwing | None) -> dict[str, Any] | None:
    if small is None:
        return None
    ratio = small.damping_ratio
    return {
        "damping_ratio_at_small_amplitude": None if ratio is None else _value_json(ratio),
        "change_to_the_largest": _value_json(small.change),
        "amplitudes": [small.smallest, small.largest],
        "amplitude_of": study.found[0].run.channels[small.channel],
        "p_value_of_no_change": _number(small.p_value),
    }


def _run_json(found: Found) -> dict[str, Any]:
    return {
        "file": str(found.run.path),
        "channels": list(found.run.channels),
        "inputs": list(found.run.input_names),
        "along": list(found.run.along_names),
        "duration_s": found.run.duration_s,
        "events": [
            {
                "time_s": event.peak_s,
                "times_the_quiet_level": event.rise,
                "kind": kind_of(found, k),
                "forced_by": event.forced_by or None,
                "followed_by": event.followed_by or None,
                "input_share": event.share,
            }
            for k, event in enumerate(found.events)
        ],
    }


def kind_of(found: Found, number: int) -> str:
    """``free``, ``forced``, or ``not one damped line`` of an event of a run."""
    event = found.events[number]
    if not event.windows:
        return "not one damped line"
    return "forced" if event.forced_by else "free"


def _point_json(point: Point) -> dict[str, Any]:
    return {
        "recording": point.run,
        "oscillation": point.number,
        "start_s": point.start_s,
        "end_s": point.end_s,
        "against": _number(point.against),
        "cycles": point.cycles,
        "determinable": point.determinable,
        "input_share": point.share,
        "quiet_known": point.quiet_known,
        "amplitude": [float(a) for a in point.amplitude],
        **{name: _value_json(getattr(point, name)) for name in QUANTITIES},
        "begun_later_changes": {
            name: _number(change) for name, change in zip(QUANTITIES, point.later, strict=True)
        },
    }


_EQUATIONS = {
    Bend.NONE: "damping_ratio = c[0] + c[1] x, x = (against - middle) / half",
    Bend.ANY: "damping_ratio = c[0] + c[1] x + c[2] x^2, x = (against - middle) / half",
    Bend.TOWED: "damping_ratio = c[0] + c[1] f(p) + c[2] (f(p - s) - f(p + s)) / 2, f(p) = "
    f"((against / middle)^p - 1) / p middle / half, p = {TOWED_POWER:g}, s = {TOWED_SPREAD:g}",
}


def _course_json(course: Course) -> dict[str, Any]:
    return {
        "equation": _EQUATIONS[course.bend],
        "c": course.coefficients.tolist(),
        "covariance": course.covariance.tolist(),
        "middle": course.middle,
        "half": course.half,
        "scatter_beyond_errors": course.scatter,
    }


def _zero_json(zero: Zero | None) -> dict[str, Any] | None:
    if zero is None:
        return None
    return {
        "damping_ratio": zero.target,
        "value": zero.value,
        "low_95": zero.low,
        "high_95": zero.high,
        "extrapolated": zero.extrapolated,
        "excluded_up_to": zero.excluded_up_to,
    }


def _comparison_json(comparison: Comparison | None) -> dict[str, Any] | None:
    if comparison is None:
        return None

    def one(difference: Difference) -> dict[str, Any]:
        first, second = difference.first, difference.second
        return {
            "quantity": difference.quantity,
            "against": None if difference.place is None else _number(difference.place),
            "first": None if first is None else _value_json(first),
            "second": None if second is None else _value_json(second),
            "difference": _value_json(difference.difference),
            "p_value": difference.p_value,
        }

    return {
        "names": list(comparison.names),
        "p_value": comparison.p_value,
        "apart": None if comparison.apart is None else list(comparison.apart),
        "at": [one(difference) for difference in comparison.at],
        "over_all": [one(difference) for difference in comparison.over_all],
    }
