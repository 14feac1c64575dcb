"""The findings in plain English: how far from instability, and what this is based on."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from swaywatch.analysis import (
    AXLE_NAMES,
    SEARCHED_M_S,
    DriveResult,
    Value,
    damping_gap,
    flag_share,
    found_critical,
    shifted_critical_speed,
    usable,
)
from swaywatch.ecu.core import AXLES, PARAMETER, Estimates
from swaywatch.trailer import presence_sentence

KMH = 3.6

REASON_WORDS = {
    "small_margin": "little speed margin",
    "above_critical_speed": "faster than the critical speed",
    "low_damping": "oscillation decays slowly",
    "growing": "oscillation grows",
    "large_amplitude": "large amplitude",
    "short_time": "limit reached soon",
    "static": "above the static critical speed",
}

LEVER_WORDS = {
    "trailer_hitch": "distance from the trailer's centre of gravity to the hitch",
    "car_hitch": "distance from the car's centre of gravity to the hitch",
    "car_front_axle": "distance from the car's centre of gravity to its front axle",
    "car_rear_axle": "distance from the car's centre of gravity to its rear axle",
    "trailer_front_axle": "distance from the trailer's centre of gravity to its front axle",
    "trailer_rear_axle": "distance from the trailer's centre of gravity to its rear axle",
}

FEW = 0.1
"""Share of usable estimates below which a result is a rough guide."""

NOT_FITTING = ("sign_or_unit", "swapped", "implausible")
"""Kinds of findings that say that the signals contradict each other."""

NEAR_KMH = 15.0
"""Margin below which the page is yellow."""

FLAG_WORDS = {
    "no_oscillation": "no oscillation above the noise",
    "forced": "the driver steers with the oscillation",
    "gap": "samples are missing in the window",
    "speed_changing": "the speed changes",
    "nonlinear": "beyond the linear range",
    "seeking": "no oscillation is tracked yet",
    "slow": "slower than 30 km/h",
    "no_speed": "speed unknown",
    "singular": "equations without a solution",
    "missing_input": "an input is missing",
    "misfit": "not a single damped oscillation: a step, an onset, a gust",
    "model_disagrees": "model and signals disagree about the damping",
    "equal_split": "trailer forces divided in the ratio of the vehicle.toml's stiffnesses",
    "user_inertia": "yaw inertia of the trailer taken from the vehicle.toml",
    "hitch": "friction or damping at the ball, removed from the critical speed",
    "small_swing": "the critical speed comes from smaller swings than the alarm's limit",
    "unexplained": "an inertia has an implausible imaginary part: its error is larger",
}


def plus_minus(value: Value, factor: float = 1.0, digits: int = 1) -> str:
    """``123.4 ± 0.6``."""
    return f"{value.value * factor:.{digits}f} ± {value.error * factor:.{digits}f}"


def speed_used_m_s(result: DriveResult) -> float:
    """Highest speed at which there was something to estimate from, else the highest at all."""
    estimates = result.estimates
    good = usable(estimates) if len(estimates) else np.zeros(0, dtype=np.bool_)
    if good.any():
        return float(np.percentile(estimates["speed_m_s"][good], 95))
    return float(np.percentile(result.drive.channels["speed"].value, 95))


def verdict(result: DriveResult) -> tuple[str, str]:
    """Colour (``good``, ``near``, ``bad``, ``unknown``) and one sentence."""
    speed = speed_used_m_s(result)
    critical = result.values.get("v_crit_m_s")
    thing = "this combination" if result.vehicle.trailer is not None else "this car"
    if critical is None:
        return _no_critical(result, speed, thing)
    if damping_gap(result.values) is not None:
        return _qualified(result, *_disagreement(result, speed, thing, critical))
    margin = critical.value - speed
    side = "below" if margin >= 0.0 else "above"
    distance = Value(abs(margin), critical.error, critical.count)
    text = (
        f"At {speed * KMH:.1f} km/h {thing} is {plus_minus(distance, KMH)} km/h {side} its "
        f"critical speed of {plus_minus(critical, KMH)} km/h"
    )
    if abs(margin) < 2.0 * critical.error:
        text += "; within two standard errors it may be on either side"
        return _qualified(result, "near" if margin > 0.0 else "bad", f"{text}.")
    if margin < 0.0:
        return _qualified(result, "bad", f"{text}: yaw oscillations grow.")
    return _qualified(result, "near" if margin * KMH < NEAR_KMH else "good", f"{text}.")


def _qualified(result: DriveResult, kind: str, text: str) -> tuple[str, str]:
    """The verdict, qualified where few estimates or inconsistent signals limit it."""
    broken = any(f.severity != "info" and f.kind in NOT_FITTING for f in result.findings)
    few = len(result.estimates) and usable(result.estimates).mean() < FEW
    if not broken and not few:
        return kind, text
    why = "the signals do not fit together" if broken else "few estimates were usable"
    return ("near" if kind == "good" else kind), f"{text} But {why} (see below): a rough guide."


def critical_words(result: DriveResult) -> str:
    """The critical speed as a cell of a table: a number with its error, or what is known."""
    critical = result.values.get("v_crit_m_s")
    if critical is not None:
        return plus_minus(critical, KMH)
    low, high = (speed * KMH for speed in SEARCHED_M_S)
    return {
        "beyond_range": f"none up to {high:.0f}", "below_range": f"below {low:.0f}"
    }.get(result.critical_kind, "–")  # fmt: skip


def _no_critical(result: DriveResult, speed_m_s: float, thing: str) -> tuple[str, str]:
    """Verdict where the search found no critical speed."""
    low, high = (speed * KMH for speed in SEARCHED_M_S)
    if result.critical_kind == "beyond_range" and damping_gap(result.values) is not None:
        measured, model = result.values["damping_ratio"], result.values["model_damping_ratio"]
        kind = "near" if measured.value > 2.0 * measured.error else "bad"
        return _qualified(
            result,
            kind,
            f"At {speed_m_s * KMH:.1f} km/h the sway of {thing} has a measured damping ratio of "
            f"{plus_minus(measured, 1.0, 3)}; the single-track model gives {model.value:.3f} and "
            f"no critical speed up to {high:.0f} km/h: physics is missing from it.",
        )
    if result.critical_kind == "beyond_range":
        return _qualified(
            result,
            "good",
            f"At {speed_m_s * KMH:.1f} km/h {thing} is stable: it has no critical speed up to "
            f"{high:.0f} km/h, where the search ends.",
        )
    if result.critical_kind == "below_range":
        return "bad", (
            f"The model of {thing} is unstable already at {low:.0f} km/h, where the search begins: "
            f"check signs and positions in {result.vehicle.path}."
        )
    return "unknown", (
        f"No critical speed could be found from {result.drive.name}: {_why_none(result)}."
    )


def _why_none(result: DriveResult) -> str:
    """What stands in the way of a critical speed."""
    estimates = result.estimates
    if not len(estimates):
        return "the drive is too short or too quiet for a single estimate"
    if usable(estimates).any():
        lacking = next((c for n, c in result.switched_off if n.startswith("critical")), ())
        if lacking:
            return f"there is no signal for {', '.join(lacking)}"
        return (
            "the stiffnesses of some axles are neither in the vehicle.toml nor could they be "
            "identified"
        )
    return f"none of its {len(estimates)} estimates is usable ({_flags(result) or 'see below'})"


def _disagreement(
    result: DriveResult, speed_m_s: float, thing: str, critical: Value
) -> tuple[str, str]:
    """Verdict where the measured damping is not the model's."""
    measured, model = result.values["damping_ratio"], result.values["model_damping_ratio"]
    more = measured.value > model.value
    text = (
        f"At {speed_m_s * KMH:.1f} km/h the sway of {thing} "
        f"{'decays' if measured.value > 0 else 'grows'} with a measured damping ratio of "
        f"{plus_minus(measured, 1.0, 3)}, {'more' if more else 'less'} than the {model.value:.3f} "
        f"of the single-track model, whose critical speed is {plus_minus(critical, KMH)} km/h."
    ).replace("-0.000", "0.000")
    return ("near" if measured.value > 2.0 * measured.error else "bad"), text


def sentences(result: DriveResult) -> list[str]:
    """Why we think so, most important first."""
    return [
        text
        for text in (
            presence_sentence(result.estimates.trailer),
            _missing_physics(result),
            _damping(result),
            _source(result),
            _swing(result),
            _stiffness(result),
            _changes(result),
            _load_harmonics(result),
            _levers(result),
            _alarms(result),
            _trust(result),
        )
        if text
    ]


def _missing_physics(result: DriveResult) -> str:
    if damping_gap(result.values) is None:
        return ""
    text = (
        "The model lacks something that damps or excites the real vehicle (`swaywatch diagnose` "
        "searches for it); where they differ, the measured damping is that of the vehicle"
    )
    shifted = shifted_critical_speed(result, speed_used_m_s(result))
    if shifted is None:
        return text + "."
    return f"{text}. Shifted onto it, the model reaches 0 near {shifted * KMH:.0f} km/h."


def _damping(result: DriveResult) -> str:
    frequency = result.values.get("frequency_hz")
    damping = result.values.get("damping_ratio")
    if "driven_low_hz" in result.values:
        low, high = result.values["driven_low_hz"].value, result.values["driven_high_hz"].value
        return (
            f"The steering drives every oscillation here ({low:.2f} to {high:.2f} Hz): there is no "
            "free one whose damping could be measured."
        )
    if frequency is None:
        return "No yaw oscillation exceeded the noise, so no damping was measured."
    thing = "combination" if result.vehicle.trailer is not None else "car"
    text = f"The {thing} sways at {plus_minus(frequency, 1.0, 3)} Hz"
    if damping is None:
        return text + "."
    per_cycle = 1.0 - float(
        np.exp(-2 * np.pi * damping.value / np.sqrt(max(1e-9, 1.0 - damping.value**2)))
    )
    motion = (
        f"losing {100 * per_cycle:.0f} % of its amplitude each swing"
        if per_cycle >= 0.0
        else f"gaining {-100 * per_cycle:.0f} % of amplitude each swing"
    )
    text += (
        "; with the wheel held still it has a damping ratio of "
        f"{plus_minus(damping, 1.0, 3)}, {motion}"
    )
    model = result.values.get("model_damping_ratio")
    if model is not None and abs(model.value) <= 1.0:
        said = f"{model.value:.3f}".replace("-0.000", "0.000")
        text += f" (the single-track model with the identified tyres gives {said})"
    return text + "."


def _source(result: DriveResult) -> str:
    estimates = result.estimates
    if result.critical_kind == "none":
        return ""
    sources = estimates.status["source"][estimates.has("critical_speed")]
    kind = int(np.bincount(sources.astype(np.int64), minlength=4).argmax())
    if kind == 3 and "v_crit_m_s" not in result.values:
        return "The stiffnesses of all axles were identified in this drive."
    count = result.values["v_crit_m_s"].count if "v_crit_m_s" in result.values else 0
    if kind == 3:
        return (
            f"The critical speed comes from the cornering stiffnesses of all axles, identified in "
            f"{count} windows of this drive; masses and lengths are those of the vehicle.toml."
        )
    if kind == 2:
        return (
            "The critical speed is based partly on measured cornering stiffnesses, partly on "
            "those of the vehicle.toml."
        )
    return "The critical speed is based on the vehicle.toml alone: no tyre could be identified."


def _lowest(estimates: Estimates) -> str:
    """Smallest critical speed over the size of the swing, where it is that of larger swings."""
    mask = estimates.has("lowest_speed")
    if not mask.any():
        return ""
    last = np.flatnonzero(mask)[-1]
    swing = float(estimates["lowest_v_crit_swing_rad_s"][last])
    if swing <= float(estimates["v_crit_swing_rad_s"][last]):
        return ""
    speed, error = (
        KMH * float(estimates[f"lowest_v_crit{part}_m_s"][last]) for part in ("", "_se")
    )
    return (
        f" In swings of {math.degrees(swing):.0f} deg/s it would be {speed:.0f} ± {error:.0f} km/h "
        "with tyres whose lateral force saturates at 0.9 times their load. This is extrapolated "
        "with an assumed tyre, not measured, and the alarm does not use it."
    )


def _swing(result: DriveResult) -> str:
    """For which swings the critical speed holds."""
    estimates = result.estimates
    mask = estimates.has("critical_speed") & (estimates.status["v_crit_swing_urad_s"] > 0)
    if "v_crit_m_s" not in result.values or not mask.any():
        return ""
    seen = math.degrees(float(estimates["v_crit_swing_rad_s"][mask].max()))
    body = "car" if result.vehicle.trailer is None else "trailer"
    text = (
        f"The tyres were observed in swings of the {body} up to {seen:.1f} deg/s; in larger ones "
        "their force may level off, and the critical speed may be lower."
    )
    text += _lowest(estimates)
    if flag_share(estimates).get("hitch", 0.0) > 0.1:
        text += (
            " There is friction or damping at the ball. It damps small swings more than large "
            "ones, so the critical speed is given without it."
        )
    return text


def _stiffness(result: DriveResult) -> str:
    parts = []
    for axle in AXLES:
        found = result.values.get(f"{axle}.cornering_stiffness_n_per_rad")
        if found is None:
            continue
        body, _, which = axle.partition("_")
        believed = getattr(getattr(result.vehicle, body), f"{which}_cornering_stiffness", None)
        text = f"{AXLE_NAMES[axle]} {plus_minus(found, 1e-3)} kN/rad"
        if believed:
            text += f" ({100 * (found.value / believed - 1):+z.1f} % against vehicle.toml)"
        parts.append(text)
    if not parts:
        return ""
    shared = flag_share(result.estimates).get("equal_split", 0.0) > 0.3
    note = (
        " The trailer's total axle force is divided in the ratio of vehicle.toml's stiffnesses "
        "times the measured slip angles: the sum is measured, the ratio is not."
    )
    return "Cornering stiffness: " + "; ".join(parts) + "." + (note if shared else "")


def _changes(result: DriveResult) -> str:
    """Axles whose stiffness is not the same throughout."""
    estimates, good = result.estimates, usable(result.estimates)
    parts = []
    for axle in AXLES:
        mask = good & estimates.has(axle)
        found = result.values.get(f"{axle}.cornering_stiffness_n_per_rad")
        if found is None or mask.sum() < 8:
            continue
        value = estimates[f"{axle}.cornering_stiffness_n_per_rad"][mask]
        error = estimates[f"{axle}.cornering_stiffness_se_n_per_rad"][mask]
        typical = float(np.median(value))
        away = (value - typical) / typical
        clear = (np.abs(away) > 0.04) & (np.abs(value - typical) > 4.0 * error)
        if clear.sum() < 4:
            continue
        time = estimates.time_s[mask][clear]
        parts.append(
            f"that of the {AXLE_NAMES[axle]} moves between {100 * away[clear].min():+.0f} and "
            f"{100 * away[clear].max():+.0f} % around its median ({time.min():.1f} to "
            f"{time.max():.1f} s)"
        )
    return "The cornering stiffness is not constant: " + "; ".join(parts) + "." if parts else ""


def _load_harmonics(result: DriveResult) -> str:
    estimates, good = result.estimates, usable(result.estimates)
    parts = []
    for axle in AXLES:
        mask = good & estimates.has(f"{axle}_load")
        if mask.sum() < 4:
            continue
        amplitude = np.abs(estimates[f"{axle}.load_harmonic_n"][mask])
        load = float(np.median(estimates[f"{axle}.load_n"][mask]))
        peak = int(np.argmax(amplitude))
        if amplitude[peak] > 0.02 * load and amplitude[peak] > 4.0 * np.median(amplitude):
            time = estimates.time_s[mask]
            inside = time[amplitude > 0.5 * amplitude[peak]]
            parts.append(
                f"The load of the {AXLE_NAMES[axle]} swings by up to {amplitude[peak]:.0f} N at "
                f"twice the yaw frequency ({_stretches(inside)}); a damper is the usual cause"
                f"{_worth_of_load(result, axle, mask)}."
            )
    return " ".join(parts)


def _stretches(time: npt.NDArray[np.float64]) -> str:
    """Times of windows as stretches: ``9.5 to 12.5 s and 15.0 to 18.0 s``."""
    parts = np.split(time, np.flatnonzero(np.diff(time) > 1.0) + 1)
    return " and ".join(f"{part[0]:.1f} to {part[-1]:.1f} s" for part in parts[:4])


def _worth_of_load(result: DriveResult, axle: str, mask: npt.NDArray[np.bool_]) -> str:
    """What the shift of the effective load does to the critical speed there."""
    estimates = result.estimates
    ratio = estimates[f"{axle}.effective_load_n"][mask] / estimates[f"{axle}.load_n"][mask] - 1.0
    known = mask & found_critical(estimates) & estimates.has("critical_speed")
    ratio = ratio[np.isfinite(ratio)]
    if not known.any() or not len(ratio):
        return ""
    slope = float(np.median(estimates[f"sensitivity_m_s.{axle}_stiffness"][known])) * KMH
    low, high = sorted((100.0 * float(ratio.min()) * slope, 100.0 * float(ratio.max()) * slope))
    return f"; it moves the critical speed by {low:+.1f} to {high:+.1f} km/h while it lasts"


def _levers(result: DriveResult) -> str:
    """The parameters the critical speed depends on most."""
    estimates = result.estimates
    mask = estimates.has("critical_speed") & found_critical(estimates)
    if not mask.any():
        return ""
    slopes = {
        name: float(np.median(estimates[f"sensitivity_m_s.{name}"][mask])) * KMH
        for name in PARAMETER.values()
    }
    largest = sorted(slopes.items(), key=lambda item: -abs(item[1]))[:3]
    if not largest or largest[0][1] == 0.0:
        return ""
    shown = ", ".join(
        f"{LEVER_WORDS.get(name, name.replace('_', ' '))} {slope:+.2f}" for name, slope in largest
    )
    return f"What moves the critical speed most, in km/h for +1 %: {shown}."


def _alarms(result: DriveResult) -> str:
    seconds: dict[str, float] = {}
    reasons: dict[str, set[str]] = {}
    for alarm in result.alarms:
        seconds[alarm.state] = seconds.get(alarm.state, 0.0) + alarm.end_s - alarm.start_s
        reasons.setdefault(alarm.state, set()).update(alarm.reasons)
    parts = [
        f"{state} for {seconds[state]:.1f} s ("
        + ", ".join(sorted(REASON_WORDS.get(r, r) for r in reasons[state]))
        + ")"
        for state in ("critical", "warning", "notice")
        if state in seconds
    ]
    if parts:
        return "Alarm: " + "; ".join(parts) + "."
    return "No alarm was raised." if "normal" in seconds else ""


def _trust(result: DriveResult) -> str:
    count = len(result.estimates)
    if not count:
        return "The drive is too short or too quiet for a single estimate."
    good = int(usable(result.estimates).sum())
    flags = _flags(result)
    if good == 0:
        return (
            f"None of the {count} estimates was usable"
            + (f" ({flags})" if flags else "")
            + ": no statement about this vehicle is possible. A drive above 30 km/h with a "
            "steering impulse "
            "or a slalom, the wheel then held still, gives estimates."
        )
    text = f"{good} of {count} estimates were usable"
    if good < FEW * count:
        text = f"Only {text}, so take this as a rough guide"
    return text + (f"; flags: {flags}." if flags else ".")


def _flags(result: DriveResult) -> str:
    """What most often spoke against an estimate, with its share."""
    return ", ".join(
        [
            f"{FLAG_WORDS.get(name, name)} ({100 * share:.0f} %)"
            for name, share in flag_share(result.estimates).items()
            if share >= 0.02
        ][:5]
    )
