"""One plain sentence for each finding: what, how much, when, and what it does to stability."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from swaywatch.diagnose.report.labels import how_much, part, rounded, when

Effect = Mapping[str, Any]
MIDDLE = 1
"""Of the swings: the one by which findings are ranked."""
BY_SIZE = 0.2
"""Share by which a cost has to differ in the largest swing for both to be stated."""
LEAST_KMH = 0.05
"""A shift of the critical speed that is shown as a number."""


def sentence(effect: Effect, stability: Mapping[str, Any] | None = None) -> str:
    """``The load of the car's rear axle swings by 760 N at twice the yaw frequency, ...``.

    Parameters
    ----------
    effect
        Of ``diagnosis.json``.
    stability
        Its ``stability``: the shift of the critical speed is stated where it is known.
    """
    make = _SENTENCES.get(effect["id"])
    windows = effect.get("window_details") or []
    text = make(effect) if make and not effect.get("text") else _plain(effect)
    times = when(windows) if windows and not effect.get("text") else ""
    if times:
        text += f" ({times})"
    return text + _worth(effect, stability or {}) + "."


def _plain(effect: Effect) -> str:
    values = "; ".join(how_much(effect)).rstrip(".")
    what = effect["id"].replace("_", " ").capitalize()
    return f"{what}, {part(effect['component'])}" + (f": {values}" if values else "")


def _worth(effect: Effect, stability: Mapping[str, Any]) -> str:
    """How much it lowers or raises the critical speed of the middle swing."""
    name = f"{effect['id']}:{effect.get('role', effect['component'])}"
    cause = next((c for c in stability.get("causes", ()) if c["name"] == name), None)
    if cause is None:
        return ""
    with_it = stability["diagnosed"]["v_crit_km_h"][MIDDLE]
    without = cause["v_crit_without_km_h"][MIDDLE]
    if with_it is None or without is None:
        limit = "with it no critical speed is found" if with_it is None else (
            f"with it the critical speed is {with_it['value']:.1f} km/h, without it none is found"
        )  # fmt: skip
        return f"; {limit}"
    back = cause["gives_back_km_h"][MIDDLE]
    if abs(back["value"]) < LEAST_KMH:
        return "; it does not change the critical speed"
    verb = "lowers" if back["value"] > 0.0 else "raises"
    least, most = sorted((abs(back["low"]), abs(back["high"])))
    if back["low"] < 0.0 < back["high"]:
        least = 0.0
    windows = [w["gives_back_km_h"] for w in cause["windows"] if w["gives_back_km_h"] is not None]
    several = len(windows) > 1
    text = (
        f"; {'in its worst window ' if several else ''}it {verb} the critical speed by "
        f"{abs(back['value']):.1f} ({least:.1f} to {most:.1f}) km/h, "
        f"from {without['value']:.1f} to {with_it['value']:.1f} km/h"
    )
    large = cause["gives_back_km_h"][-1]
    if large is not None and abs(large["value"] - back["value"]) > BY_SIZE * abs(back["value"]):
        small, great = (stability["swings_deg_s"][k] for k in (MIDDLE, -1))
        text += (
            f" for a swing of {small:g} deg/s, and by {abs(large['value']):.1f} km/h for one of "
            f"{great:g} deg/s"
        )
    best = min((w["value"] for w in windows), default=0.0)
    if several and back["value"] > 0.0 > best + LEAST_KMH:
        text += f"; in its most favourable window it raises it by {-best:.1f} km/h"
    return text


# --- of each id -----------------------------------------------------------------------------------


def _value(effect: Effect, name: str) -> float | None:
    """A parameter, or the largest size that it has in any window."""
    sizes = [d[name] for d in effect.get("window_details") or [] if name in d]
    if sizes:
        return float(max(sizes, key=abs))
    found = effect["parameters"].get(name)
    return None if found is None else float(found["value"])


def _limits(effect: Effect, name: str) -> tuple[float, float] | None:
    """The 90 % interval of a value; None for the largest of several windows, which has none."""
    found = effect["parameters"].get(name)
    if found is None or len(effect.get("window_details") or []) > 1:
        return None
    low, high = found.get("low"), found.get("high")
    return None if low is None or high is None or low == high else (float(low), float(high))


def _number(effect: Effect, name: str, unit: str, factor: float = 1.0) -> str:
    """A value with its 90 % interval and unit, such as ``130 (127 to 133) N m``."""
    value = _value(effect, name)
    if value is None:
        return "an unknown amount"
    limits = _limits(effect, name)
    text = _short(value * factor)
    if limits is not None:
        text += f" ({_short(limits[0] * factor)} to {_short(limits[1] * factor)})"
    return f"{text} {unit}".strip()


def _short(number: float) -> str:
    """Three digits; large numbers written out."""
    size = 10.0 ** (math.floor(math.log10(abs(number))) - 2) if number else 1.0
    return rounded(round(number / size) * size)


def _percent(effect: Effect, more: str = "higher", less: str = "lower") -> str:
    """A factor as ``12 % lower (-14 to -10 %)``, with its 90 % interval."""
    value = _value(effect, "factor")
    if value is None:
        return "changed"
    text = f"{abs(value - 1.0):.0%} {more if value > 1.0 else less}".replace("%", " %")
    limits = _limits(effect, "factor")
    if limits is not None:
        low, high = (100.0 * (limit - 1.0) for limit in limits)
        text += f" ({low:+.0f} to {high:+.0f} %)"
    return text


def _axle(effect: Effect) -> str:
    return {
        "car_front": "the car's front axle", "car_rear": "the car's rear axle",
        "trailer_front": "the trailer's front axle", "trailer_rear": "the trailer's rear axle",
        "trailer": "the trailer", "all": "all axles", "car": "the car",
    }.get(effect["component"], part(effect["component"]))  # fmt: skip


def _several(effect: Effect, one: str, more: str) -> str:
    windows: Sequence[Any] = effect.get("window_details") or []
    return more if len(windows) > 1 else one


_SENTENCES: dict[str, Callable[[Effect], str]] = {
    "axle_load_harmonic": lambda e: (
        f"The load of {_axle(e)} swings by {_several(e, '', 'up to ')}"
        f"{_number(e, 'amplitude_n', 'N')} at twice the yaw frequency; a damper is the usual cause"
    ),
    "tyre_relaxation": lambda e: (
        f"The lateral force of {_axle(e)} builds up over a relaxation length of "
        f"{_number(e, 'length_m', 'm')}"
    ),
    "tyre_saturation": lambda e: (
        f"The tyres of {_axle(e)} saturate at a force of {_number(e, 'peak_friction', '')} "
        "times the wheel load"
    ),
    "tyre_load_sensitivity": lambda e: (
        f"The cornering stiffness of {_axle(e)} grows less than the wheel load (degression "
        f"{_number(e, 'degression', '')})"
    ),
    "tyre_stiffness_change": lambda e: (
        f"The cornering stiffness of {_axle(e)} is {_percent(e)} at unchanged wheel load; tyre "
        "pressure or the road surface are the usual causes"
    ),
    "friction_reduction": lambda e: f"The road's peak friction is {_percent(e)}",
    "hitch_friction": lambda e: f"Dry friction at the hitch: {_number(e, 'moment_nm', 'N m')}",
    "hitch_damping": lambda e: (
        f"The hitch damps the articulation by {_number(e, 'coefficient_nms_per_rad', 'N m s/rad')}"
    ),
    "drawbar_compliance": lambda e: (
        "The drawbar is elastic: the trailer gives way sideways to the force at the ball "
        f"(stiffness {_number(e, 'stiffness_n_per_m', 'N/m')})"
    ),
    "trailer_aerodynamics": lambda e: (
        "Air flow exerts a side force and a yaw moment on the trailer (coefficients "
        f"{_number(e, 'side_force_coefficient', '')} and "
        f"{_number(e, 'yaw_moment_coefficient', '')})"
    ),
    "roll_steer": lambda e: (
        f"{_axle(e).capitalize()} steers by {_number(e, 'coefficient', 'rad')} for each rad of roll"
    ),
    "roll_stiffness_change": lambda e: f"The roll stiffness of {_axle(e)} is {_percent(e)}",
    "damper_fade": lambda e: f"The damping force of the dampers of {_axle(e)} is {_percent(e)}",
    "damper_asymmetry": lambda e: (
        f"The dampers of {_axle(e)} are stiffer in one direction than in the other, which shifts "
        "the axle load"
    ),
    "crosswind_gust": lambda e: (
        f"A gust exerts a side force of {_number(e, 'force_n', 'N')} on the {part(e['component'])}"
    ),
    "road_bank": lambda e: f"The road is banked by {_number(e, 'angle_deg', 'deg')}",
    "steering_compliance": lambda e: (
        "The steering is elastic: the front wheels yield to their lateral force (stiffness "
        f"{_number(e, 'stiffness_n_per_rad', 'N/rad')})"
    ),
    "steering_free_play": lambda e: (
        f"The steering has {_number(e, 'gap_deg', 'deg')} of play at the steering wheel"
    ),
    "sensor_delay": lambda e: (
        f"The signal {part(e['component'])} is delayed by {_number(e, 'delay_s', 'ms', 1e3)}; the "
        "vehicle is as modelled"
    ),
    "sensor_gain": lambda e: (
        f"The signal {part(e['component'])} is {_percent(e, 'too high', 'too low')}; the vehicle "
        "is as modelled"
    ),
    "sensor_roll_gravity": lambda e: (
        f"The sensor of {part(e['component'])} rolls with the body and measures a part of gravity; "
        "the vehicle is as modelled"
    ),
    "parameter_error": lambda e: f"{e['component']} of vehicle.toml should be {_percent(e)}",
}
