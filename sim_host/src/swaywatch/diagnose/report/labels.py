"""An effect of diagnosis.json in words, the same on every page and screen."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

#: End of a parameter's name to its unit, the longest first.
UNITS = (
    ("_n_per_m2_s2", "N s²/m²"), ("_nms_per_rad", "N m s/rad"), ("_n_per_rad", "N/rad"),
    ("_n_per_m", "N/m"),
    ("roll_per_acceleration", "rad per m/s²"), ("_rad_s", "rad/s"), ("delay_per_s", "s per s"),
    ("_per_s", "per s"), ("_deg", "deg"), ("_nm", "N m"), ("_hz", "Hz"), ("_n", "N"),
    ("_m", "m"), ("_s", "s"),
)  # fmt: skip
COMPONENTS = {
    "car_front": "car, front axle", "car_rear": "car, rear axle",
    "trailer_front": "trailer, front axle", "trailer_rear": "trailer, rear axle",
    "all": "all axles",
}  # fmt: skip
MOST_WINDOWS = 6
VERDICTS = {
    "consistent": ("good", "Simulation and recording agree: no physics is missing."),
    "missing_physics": ("bad", "Physics is missing in the simulation"),
    "measurement_fault": ("near", "The measurement is at fault, not the simulation"),
    "parameter_error": ("near", "A value of vehicle.toml is wrong; no physics is missing"),
    "unexplained": (
        "bad",
        "Simulation and recording differ; no known effect explains it with sufficient confidence",
    ),
}
"""Verdict to its colour and its sentence."""


def quantity(name: str) -> tuple[str, str]:
    """Label and unit of a parameter: ``amplitude_n`` is an amplitude in N."""
    base = re.sub(r"_(\d+)$", "", name)
    number = name[len(base) + 1 :]
    unit = next((unit for end, unit in UNITS if base.endswith(end)), "")
    end = next((end for end, _ in UNITS if base.endswith(end)), "")
    label = base.removesuffix(end) if end.startswith("_") and base != end else base
    text = label.replace("_", " ")
    return (f"{text} {int(number) + 1}" if number else text), unit


def part(name: str) -> str:
    """Name of the place where an effect acts."""
    return COMPONENTS.get(name, name.replace("_", " ") if name.islower() else name)


def named(name: str) -> str:
    """``id:component`` of an explanation, in words."""
    effect, _, component = name.partition(":")
    words = effect.replace("_", " ")
    return f"{words} ({part(component)})" if component else words


def value(name: str, number: float) -> str:
    """A number with the name and unit of its parameter."""
    label, unit = quantity(name)
    return f"{label} {rounded(number)}{' ' + unit if unit else ''}"


def rounded(number: float) -> str:
    """Four digits; large numbers written out."""
    return f"{number:,.0f}".replace(",", " ") if abs(number) >= 1e4 else f"{number:.4g}"


def when(windows: Sequence[Mapping[str, Any]], run: str = "") -> str:
    """Windows of an effect; single samples by their time."""
    words: list[str] = []
    last = run
    for w in windows[:MOST_WINDOWS]:
        named = f"{w['run']}: " if w["run"] != last else ""
        last = w["run"]
        span = f"{w['start']:.2f} s" if w["start"] == w["stop"] else (
            f"{w['start']:.1f} to {w['stop']:.1f} s"
        )  # fmt: skip
        words.append(named + span)
    more = len(windows) - MOST_WINDOWS
    return ", ".join(words) + (f" and {more} more" if more > 0 else "")


def how_well(result: Mapping[str, Any]) -> str:
    """Errors of the simulation with and without the findings; empty where nothing is claimed."""
    fit = next((effect["fit"] for effect in result["effects"] if effect.get("fit")), None)
    if fit is None:
        return ""
    beside = "calibration" in result.get("model", {})
    named_errors = {
        "as_written_nrmse": "with " + ("your simulation" if beside else "vehicle.toml as written"),
        "baseline_nrmse": "without the findings",
        "diagnosed_nrmse": "with the findings",
    }
    if fit.get("baseline") == "as_written":  # calibration itself is the finding
        del named_errors["baseline_nrmse"]
    parts = [
        f"{fit[key]:.3f} {words}" for key, words in named_errors.items() if fit.get(key) is not None
    ]
    left = [fit.get(key) for key in ("held_out_baseline_nrmse", "held_out_diagnosed_nrmse")]
    more = ""
    if None not in left:
        more = f"; of runs left out of the fit {left[0]:.3f} without and {left[1]:.3f} with them"
    return "error of the simulation (NRMSE): " + ", ".join(parts) + more


def how_much(effect: Mapping[str, Any]) -> list[str]:
    """Parameters with 90 % intervals; of an effect in several windows a line for each window.

    A mean over windows has no meaning: a phase of +56 deg here and -151 deg there is no -49 deg.
    """
    parameters = effect["parameters"]
    details = effect.get("window_details") or []
    if effect.get("text"):  # a fault of a sensor: what was found in each run
        return list(effect["text"])
    if len(details) > 1:
        return [
            f"{d['run']} {d['start']:.1f} to {d['stop']:.1f} s: "
            + ", ".join(value(name, d[name]) for name in parameters if name in d)
            for d in details
        ]
    return [
        ", ".join(
            f"{value(name, v['value'])} ({rounded(v['low'])} to {rounded(v['high'])})"
            + (", at the end of the range searched" if v.get("at_bound") else "")
            for name, v in parameters.items()
        )
    ]


def what_is_left(note: Mapping[str, Any]) -> str:
    """The mismatch that no explanation covers, in a sentence."""
    if note.get("reason"):
        return str(note["reason"])
    return (
        f"an unknown force at the {note['location']} would explain {note['share_of_mismatch']:.0%} "
        f"of the remaining mismatch; it is strongest at {note['frequency_hz']:.2f} Hz"
    )
