"""The findings in plain English, most important first."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np

from swaywatch.damping.compare import Comparison, Difference
from swaywatch.damping.course import Zero
from swaywatch.damping.data import NO_SIGNAL
from swaywatch.damping.find import SLOWEST
from swaywatch.damping.intervals import IntervalValue, too_high
from swaywatch.damping.model import LinearModel
from swaywatch.damping.study import SpeedGroup, Study, kind_of

_NAMES = {
    "damping_ratio": "damping ratio", "frequency_hz": "frequency", "growth_1_s": "growth",
}  # fmt: skip
#: Half-width of a difference, over the size of what is compared, above which "agree" says too much.
AGREE = 0.25
QUICK = 0.35
"""Damping ratio from which a swing is over within one cycle."""

_HIGH = "the motion is over within half a cycle, so its damping is high or it is overdamped"
_UNITS = {"damping_ratio": "", "frequency_hz": " Hz", "growth_1_s": " 1/s"}


def interval(value: IntervalValue, digits: int = 3) -> str:
    """``0.243 (0.221 to 0.265)``."""
    if not math.isfinite(value.half) or value.error == 0.0:
        return f"{value.value:.{digits}f}"
    return f"{value.value:.{digits}f} ({value.low:.{digits}f} to {value.high:.{digits}f})"


def probability(p_value: float) -> str:
    """``p = 0.012`` or ``p < 0.0001``."""
    return "p < 0.0001" if p_value < 1e-4 else f"p = {p_value:.2g}"


def _at(study: Study, value: float, digits: int = 3) -> str:
    unit = study.against_unit
    text = f"{value:.{digits}g} {unit}".rstrip()
    return f"{text} ({value * 3.6:.1f} km/h)" if unit == "m/s" and value > 12.0 else text


def _where(study: Study, place: SpeedGroup) -> str:
    """`` at 120 km/h``; with the signal's name where the file gives no unit."""
    if math.isnan(place.against):
        return ""
    name = "" if study.against_unit else f"{study.against_name} "
    return f" at {name}{_at(study, place.against)}"


def verdict(study: Study) -> tuple[str, str]:
    """Colour (``good``, ``near``, ``bad``) and one sentence."""
    if not study.points:
        return "near", _none(study)
    known = [place for place in study.places if place.determinable]
    worst = min(known or study.places, key=lambda place: place.damping_ratio.value)
    where = _where(study, worst)
    lowest = interval(worst.damping_ratio)
    if worst.damping_ratio.high < 0.0:
        return "bad", f"The oscillation grows{where}: damping ratio {lowest}."
    zero = study.zero
    bounded = zero is not None and (zero.low is not None or zero.high is not None)
    if zero is not None and zero.value is not None and zero.value > 0.0 and bounded:
        return "near", _zero_words(study, zero)
    if not known:
        return (
            "near",
            f"The damping ratio{where} is not determinable: {_why(worst)}.",
        )
    if len(study.places) == 1:
        kind = "good" if worst.damping_ratio.low > 0.0 else "near"
        return kind, f"The damping ratio is {lowest}{where}, {_frequency(worst)}."
    sure = worst.damping_ratio.low > 0.0
    text = f"The lowest damping ratio is {lowest}{where}, {_frequency(worst)}."
    return ("good" if sure else "near"), text


def _why(place: SpeedGroup) -> str:
    """Why a damping ratio is not determinable."""
    if too_high(place.damping_ratio):
        return _HIGH
    return f"{interval(place.damping_ratio)}, {_frequency(place)}"


def _frequency(place: SpeedGroup) -> str:
    return f"frequency {interval(place.frequency_hz)} Hz"


def _none(study: Study) -> str:
    forced = sum(bool(event.forced_by) for found in study.found for event in found.events)
    if forced:
        return f"No free oscillation: {forced} swing{'s' * (forced > 1)} driven by an input."
    return "No free oscillation is distinguishable from the rest of the motion."


def sentences(study: Study) -> list[str]:
    """What else is to be said."""
    texts = [
        _counts(study), _forced(study), _followed(study), _others(study), _still(study),
        _gaps(study), _searched(study), _unquiet(study), _zero(study), _iso9815(study),
        _weak(study), _quick(study), *_sizes(study), _later(study),
    ]  # fmt: skip
    if study.groups is not None:
        texts += comparison_words(study, study.groups, model=False)
    elif study.compared is not None:
        texts.append(_not_compared(study))
    if study.against_model is not None:
        texts += comparison_words(study, study.against_model, model=True)
    elif study.model is not None:
        texts.append(_no_model(study, study.model))
    said = verdict(study)[1]
    return [text for text in texts if text and text != said]


def _no_model(study: Study, model: LinearModel) -> str:
    """Why the model is not beside the measurement."""
    if not study.points:
        return f"{model.name}: nothing measured to compare it with."
    return (
        f"{model.name} has no oscillating mode at the speeds that were driven{model.range_words()}."
    )


def _not_compared(study: Study) -> str:
    """Why there is no difference to tell."""
    assert study.compared is not None
    which = " and the ".join(
        name for name, one in (("first", study), ("second", study.compared)) if not one.points
    )
    return f"Nothing can be compared: no free oscillation in the {which} group."


def _counts(study: Study) -> str:
    swings = len({(point.run, point.number) for point in study.points})
    kinds = Counter(kind_of(found, k) for found in study.found for k in range(len(found.events)))
    text = (
        f"{swings} free oscillation{'s' * (swings != 1)}, evaluated in {len(study.points)} "
        f"window{'s' * (len(study.points) != 1)}"
    )
    if kinds["not one damped line"]:
        text += f"; {kinds['not one damped line']} other events are not one damped oscillation"
    return text + "."


def _forced(study: Study) -> str:
    inputs = Counter(e.forced_by for found in study.found for e in found.events if e.forced_by)
    texts = []
    if inputs:
        which = ", ".join(f"{count} by {name}" for name, count in inputs.items())
        texts.append(f"Forced, and left out: {which}. Their decay says nothing about the damping.")
    names = list(dict.fromkeys(name for found in study.found for name in found.run.input_names))
    choice = study.plan.choice
    if names and not choice.inputs and choice.signals is None:
        texts.append(
            f"Taken as the driver's or pilot's input by name: {', '.join(names)} (--input names "
            f"another, --input {NO_SIGNAL} none)."
        )
    if not names:
        there = dict.fromkeys(name for found in study.found for name in found.run.may_drive)
        could = f" In the files that could be {', '.join(list(there)[:6])}." if there else ""
        texts.append(
            "No input of the driver or pilot was named (--input): that the swings are free is "
            f"assumed, not seen.{could}"
        )
    return " ".join(texts)


def _followed(study: Study) -> str:
    inputs = Counter(e.followed_by for found in study.found for e in found.events if e.followed_by)
    if not inputs:
        return ""
    which = ", ".join(f"{name} in {count}" for name, count in inputs.items())
    return (
        f"Follows the swing and dies out with it: {which}. A damper, a controller or the driver's "
        "own answer does so; the damping is that of the vehicle with it."
    )


def _others(study: Study) -> str:
    """Windows that are not like the rest."""
    if not study.others:
        return ""
    which = ", ".join(
        f"{point.run} at {point.start_s:.1f} s ({point.frequency_hz.value:.2f} Hz, damping ratio "
        f"{point.damping_ratio.value:.2f})"
        for point in study.others[:3]
    )
    more = f" and {len(study.others) - 3} more" if len(study.others) > 3 else ""
    along = dict.fromkeys(name for found in study.found for name in found.run.along_names)
    kind = "frequency or damping"
    if along:
        kind = f"frequency, damping or how {', '.join(along)} swing{'s' * (len(along) == 1)} along"
    return (
        f"Another motion than the other swings at that {study.against_name or 'place'}, by "
        f"{kind}, and left out of the means: {which}{more}. A hand, a gust or another mode does so."
    )


def _still(study: Study) -> str:
    """Channels that never change: a signal that is not connected looks like this."""
    which = [
        f"{name} in {found.run.name} ({value[0]:g} {unit}".rstrip() + ")"
        for found in study.found
        for name, unit, value in zip(
            found.run.channels, found.run.units, found.run.value.T, strict=True
        )
        if float(np.ptp(value)) == 0.0
    ]
    if not which:
        return ""
    more = f" and {len(which) - 6} more" if len(which) > 6 else ""
    return f"Never changes, perhaps not connected: {', '.join(which[:6])}{more}."


def _gaps(study: Study) -> str:
    """Where samples are missing: no swing is seen there, and one that reaches there is cut off."""
    runs = [found.run for found in study.found if found.run.missing_s > 0.0]
    if not runs:
        return ""
    which = ", ".join(
        f"{run.name} for {run.missing_s:.3g} of {run.duration_s:.3g} s" for run in runs[:6]
    )
    more = f" and {len(runs) - 6} more" if len(runs) > 6 else ""
    return (
        f"Values are missing (gaps, or no numbers): {which}{more}. No window reaches into a gap: "
        "a swing there is evaluated beside it, or reported as not one damped oscillation."
    )


def _searched(study: Study) -> str:
    """Why a swing may not have been found: sampled too slowly or too short."""
    seen = {point.run for point in study.points}
    cut = [
        found
        for found in study.found
        if found.run.name not in seen
        and (found.band_hz[0] > study.plan.band_hz[0] or found.band_hz[1] < study.plan.band_hz[1])
    ]
    if not cut:
        return ""
    which = ", ".join(
        f"{found.run.name} ({found.run.duration_s:.3g} s, {1.0 / found.run.step_s:.3g} samples a "
        f"second): {found.band_hz[0]:.2g} to {found.band_hz[1]:.2g} Hz"
        for found in cut[:6]
    )
    return (
        f"Only these frequencies could be searched: {which}. Below, less than one swing lasts as "
        f"long as the recording; above, a swing has fewer than {SLOWEST:g} samples."
    )


def _unquiet(study: Study) -> str:
    """Windows whose errors could not be seen in quiet motion."""
    names = dict.fromkeys(point.run for point in study.points if not point.quiet_known)
    if not names:
        return ""
    return (
        f"{', '.join(names)}: too short a time without a swing to measure the effect of wind, road "
        "and driver. It is estimated from the residuals of the swings instead, so these intervals "
        "are approximate."
    )


def _zero_words(study: Study, zero: Zero) -> str:
    assert zero.value is not None
    low = "" if zero.low is None else f"{zero.low:.3g}"
    high = "" if zero.high is None else f"{zero.high:.3g}"
    limits = f"{low} to {high}" if low and high else f"{low} or more" if low else f"up to {high}"
    name = study.against_name or "value"
    place = "beyond what was driven" if zero.extrapolated else "within what was driven"
    return (
        f"The damping is zero at a {name} of {_at(study, zero.value)} "
        f"(95 %: {limits} {study.against_unit}".rstrip()
        + f"), {place}."
    )


def _zero(study: Study) -> str:
    zero, course = study.zero, study.course
    if zero is None or course is None:
        return ""
    low, high = float(course.x.min()), float(course.x.max())
    if zero.value is not None and (zero.low is not None or zero.high is not None):
        return _zero_words(study, zero)
    if zero.excluded_up_to is not None and zero.excluded_up_to > high:
        return (
            f"No critical {study.against_name or 'value'} within or near what was driven "
            f"({low:.3g} to {_at(study, high)}): the damping is certain (95 %) not to be zero up "
            f"to {_at(study, zero.excluded_up_to)}."
        )
    if zero.excluded_up_to is None and zero.value is None:
        return ""
    return (
        f"Whether the damping reaches zero within or near what was driven ({low:.3g} to "
        f"{_at(study, high)}) cannot be determined from these recordings."
    )


def _iso9815(study: Study) -> str:
    """The other speed of ISO 9815, and what its straight line would say."""
    if study.line is None or study.limit is None:
        return ""
    limit, line = study.limit, study.line.zero()
    texts = []
    if limit.value is not None and limit.low is not None and limit.high is not None:
        texts.append(
            f"The damping ratio is {limit.target:g} at {_at(study, limit.value)} (95 %: "
            f"{limit.low:.3g} to {limit.high:.3g} {study.against_unit}), "
            f"{'beyond' if limit.extrapolated else 'within'} what was driven."
        )
    if line.value is not None:
        texts.append(
            f"ISO 9815's straight line alone would put the zero at {_at(study, line.value)}; a "
            "trailer's damping decreases as 1/speed, so the course is curved, and a straight line "
            "extrapolated beyond the speeds driven ends too low."
        )
    return " ".join(texts)


def _quick(study: Study) -> str:
    places = [p for p in study.places if p.determinable and p.damping_ratio.value >= QUICK]
    if not places:
        return ""
    return (
        "A swing with a damping ratio of 0.35 or more is over within one cycle; a second motion "
        "that dies out beside it can hardly be distinguished from it. In simulated aircraft such "
        "ratios came out 0.05 too low, those above 0.5 even 0.15."
    )


def _weak(study: Study) -> str:
    known = [place for place in study.places if place.determinable]
    weak = [place for place in study.places if not place.determinable] if known else []
    lost = [found.run.name for found in study.found if not _has_point(study, found.run.name)]
    texts = []
    for high, why in (
        (False, "the 95 % interval is wider than 0.2 to either side"),
        (True, _HIGH),
    ):
        own = [place for place in weak if too_high(place.damping_ratio) == high]
        if own:
            where = ", ".join("all" if math.isnan(p.against) else f"{p.against:.3g}" for p in own)
            at = f"{where} {study.against_unit}".rstrip()
            texts.append(f"The damping ratio at {at} is not determinable: {why}.")
    if lost and len(lost) < len(study.found):
        texts.append(f"No free oscillation that can be evaluated: {', '.join(lost)}.")
    return " ".join(texts)


def _has_point(study: Study, name: str) -> bool:
    return any(point.run == name for point in study.points)


def _sizes(study: Study) -> list[str]:
    """Damping that depends on the size of the swing, and what it is at small ones."""
    texts = []
    for place in study.places:
        small = place.small
        if small is None or not small.depends:
            continue
        where = "" if math.isnan(place.against) else f" at {_at(study, place.against)}"
        run = study.found[0].run
        unit, to_unit = run.units[small.channel], 1.0
        if unit in ("rad/s", "rad"):
            unit, to_unit = unit.replace("rad", "deg"), math.degrees(1.0)
        sizes = f"{to_unit * small.smallest:.2g} to {to_unit * small.largest:.2g} {unit}".rstrip()
        head = (
            f"The damping{where} depends on the size of the swing ({probability(small.p_value)}; "
            f"{run.channels[small.channel]} {sizes})"
        )
        if small.damping_ratio is None:
            texts.append(
                f"{head}: it rises towards small swings as dry friction makes it, so there is no "
                "value for small ones; the values here are those of the swings that were seen."
            )
        else:
            texts.append(
                f"{head}: damping ratio {interval(small.damping_ratio)} at small amplitude, "
                f"{abs(small.change.value):.3f} {'less' if small.change.value < 0 else 'more'} at "
                "the largest; the values here are means over each swing."
            )
    return texts


def _later(study: Study) -> str:
    """Damping that depends on where the window begins."""
    change = np.array([point.later[0] for point in study.points])
    change = change[np.isfinite(change)]
    if len(change) < 4:
        return ""
    mean, error = float(np.mean(change)), float(np.std(change, ddof=1) / math.sqrt(len(change)))
    typical = float(np.median([abs(point.damping_ratio.value) for point in study.points]))
    if abs(mean) < 3.0 * error or abs(mean) < max(0.01, 0.1 * typical):
        return ""
    return (
        f"Begun an eighth of a swing later, the windows give a damping ratio {abs(mean):.3f} "
        f"{'higher' if mean > 0 else 'lower'}: it depends on the amplitude (friction, free play), "
        "or a second motion dies out beside this one. The values here are those from the first "
        "turn of each swing on."
    )


def comparison_words(study: Study, comparison: Comparison, *, model: bool) -> list[str]:
    """Where two groups, or model and measurement, differ, and how sure."""
    texts = []
    for quantity in ("frequency_hz", "damping_ratio", "growth_1_s"):
        total = comparison.total(quantity)
        if total is not None:
            texts.append(_one_quantity(study, comparison, total, model))
    if comparison.apart is not None:
        places = zip(comparison.names, comparison.apart, strict=True)
        texts.append(
            f"The two groups have no {study.against_name or 'speed'} in common; the nearest are "
            "compared ("
            + ", ".join(f"{name} at {_at(study, at)}" for name, at in places)
            + "), so what lies between them is part of each difference."
        )
    return texts


def _one_quantity(study: Study, comparison: Comparison, total: Difference, model: bool) -> str:
    name, unit = _NAMES[total.quantity], _UNITS[total.quantity]
    first, second = comparison.names
    at = comparison.of(total.quantity)
    certain = [one for one in at if one.differs]
    both = f"of {first} and of {second}" if not model else f"of {first} and as measured"
    if not total.differs:
        said = f"difference {interval(total.difference)}{unit}, {probability(total.p_value)}"
        if total.difference.half > AGREE * _size(at):
            return f"The {name} {both} cannot be shown to differ or to agree: {said}."
        return f"The {name} {both} agree: {said}."
    where = ""
    if certain and not math.isnan(at[0].place or 0.0) and len(at) > 1:
        places = ", ".join(f"{one.place:.3g}" for one in certain if one.place is not None)
        where = f"; for certain (95 %) at {places} {study.against_unit}".rstrip()
    higher = "higher" if total.difference.value > 0 else "lower"
    return (
        f"The {name} of {first} is {higher} than {'measured' if model else 'that of ' + second}"
        f"{_percent(certain or at, total)}: difference {interval(total.difference)}{unit}, "
        f"{probability(total.p_value)}{where}."
    )


def _size(at: list[Difference]) -> float:
    """Typical size of what is compared."""
    values = [abs(side.value) for one in at for side in (one.first, one.second) if side is not None]
    return float(np.median(values))


def _percent(at: list[Difference], total: Difference) -> str:
    """Range of the differences in per cent, of a frequency."""
    if total.quantity != "frequency_hz":
        return ""
    shares = [
        100.0 * one.difference.value / one.second.value for one in at if one.second is not None
    ]
    low, high = min(map(abs, shares)), max(map(abs, shares))
    return f" by {low:.0f} %" if round(low) == round(high) else f" by {low:.0f} to {high:.0f} %"
