"""The validation as a page and as plain types."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from swaywatch import __version__
from swaywatch.analysis import AXLE_NAMES, DriveResult, usable
from swaywatch.ecu.core import AXLES
from swaywatch.report.shell import document, plot
from swaywatch.validate.compare import CRITERION, LEAST_DAMPING_RATIO, ComparedLine, MeanValue
from swaywatch.validate.correct import RELAXATION, Correction
from swaywatch.validate.loop import Round, Validation

KMH = 3.6
RECORDED, SIMULATED = "#0072B2", "#D55E00"
_DIGITS = {"Hz": 4, "–": 4, "km/h": 1, "kN/rad": 1, "deg": 1, "N": 0, "kg m²": 0}
_WORDS = {
    "within": "within 5 %",
    "perhaps within": "within 5 %, not certain",
    "perhaps beyond": "beyond 5 %, not certain",
    "beyond": "beyond 5 %",
    "not compared": "one side only",
}


def sentences(found: Validation) -> list[str]:
    """The result in sentences, the answer first."""
    last = found.rounds[-1]
    said = [_answer(found, last)]
    if not last.failed and (widest := _widest(last)) is not None:
        said.append(
            f"Largest difference in relation to its limit: {widest.name}, {_difference(widest)}"
            f"{'' if _in_percent(widest) else _unit(widest)} "
            f"({100.0 * abs(widest.difference) / widest.allowed:.0f} % of the limit)."
        )
    changes = found.total
    if changes and found.own:
        said.append("Corrected: " + "; ".join(map(change_text, changes)) + ".")
        first, end = _v_crit(found.rounds[0]), _v_crit(last)
        if first is not None and end is not None:
            said.append(
                f"Critical speed of the simulation: {first * KMH:.1f} km/h before, "
                f"{end * KMH:.1f} km/h after the corrections."
            )
    elif changes:
        said.append("To correct in your simulation: " + "; ".join(map(factor_text, changes)) + ".")
    if any(change.key.endswith(RELAXATION) for change in changes):
        said.append(
            "The relaxation length covers any lag of an axle's force: of the tyre, of the "
            "suspension or of a delayed sensor. `swaywatch diagnose` finds which; vehicle.toml "
            "has no key for it."
        )
    failed = [line for _, line in last.failed]
    if failed and any(line.kind != "parameter" for line in failed):
        said.append(
            "The remaining difference cannot be corrected by a value of the vehicle: physics is "
            "missing, or a sensor is faulty. `swaywatch diagnose` with the corrected vehicle names "
            "it."
        )
    return said


def _answer(found: Validation, last: Round) -> str:
    compared = [x for xs in last.lines for x in xs if x.outcome != "not compared"]
    if not compared:
        return (
            "Nothing could be compared: recording or simulation has no estimate of an oscillation."
        )
    failed = last.failed
    turns = len(found.rounds)
    rounds = f" after {turns} rounds" if turns > 1 else ""
    if not failed:
        unsure = sum(line.outcome == "perhaps within" for line in compared)
        note = f", {unsure} of them not with certainty" if unsure else ""
        return (
            f"The simulation agrees with the recording{rounds}: all {len(compared)} values are "
            f"within 5 %{note}."
        )
    names = ", ".join(dict.fromkeys(line.name for _, line in failed))
    return (
        f"The simulation differs from the recording{rounds}: {len(failed)} of {len(compared)} "
        f"values differ by more than 5 % ({names})."
    )


def _widest(last: Round) -> ComparedLine | None:
    """The value whose difference is the largest share of what its criterion allows."""
    compared = [x for xs in last.lines for x in xs if x.outcome != "not compared"]
    return max(compared, key=lambda x: abs(x.difference) / x.allowed, default=None)


def _unit(line: ComparedLine) -> str:
    return "" if line.unit == "–" else f" {line.unit}"


def change_text(change: Correction) -> str:
    """``rear axle of the car, cornering stiffness: 185.2 -> 170.1 +- 0.4 kN/rad (-8.2 %)``."""
    unit, factor, digits = _unit_of(change.key)
    if change.key.endswith(RELAXATION):
        return (
            f"{_label(change.key)} {change.before:.2f} to {change.after:.2f} ± {change.error:.2f} m"
        )
    return (
        f"{_label(change.key)} {change.before * factor:.{digits}f} to "
        f"{change.after * factor:.{digits}f} ± {change.error * factor:.{digits}f} {unit} "
        f"({100.0 * change.share:+.1f} %)"
    )


def factor_text(change: Correction) -> str:
    """The same for a simulation whose own values are not known here."""
    if change.key.endswith(RELAXATION):
        return f"{_label(change.key)} longer by {change.after:.2f} ± {change.error:.2f} m"
    error = change.error / change.before
    return f"{_label(change.key)} times {1.0 + change.share:.3f} ± {error:.3f}"


def _label(key: str) -> str:
    body, _, name = key.partition(".")
    if name == "yaw_inertia":
        return f"yaw inertia of the {body}"
    if name == RELAXATION:
        return f"relaxation length of the {AXLE_NAMES[body]}"
    which, _, what = name.partition("_")
    return f"{what.replace('_', ' ')} of the {AXLE_NAMES[f'{body}_{which}']}"


def _unit_of(key: str) -> tuple[str, float, int]:
    if key.endswith("stiffness"):
        return "kN/rad", 1e-3, 1
    if key.endswith(RELAXATION):
        return "m", 1.0, 2
    return ("kg m²", 1.0, 0) if key.endswith("inertia") else ("N", 1.0, 0)


def _v_crit(turn: Round) -> float | None:
    values = [r.values["v_crit_m_s"].value for r in turn.simulations if "v_crit_m_s" in r.values]
    return sum(values) / len(values) if values else None


def rows(lines: Sequence[ComparedLine]) -> list[list[str]]:
    """The comparison as text: name, recording, simulation, difference, criterion, unit."""
    return [
        [
            line.name, _cell(line.recording, line), _cell(line.simulation, line),
            _difference(line), _WORDS[line.outcome], line.unit,
        ]
        for line in lines
    ]  # fmt: skip


def _cell(figure: MeanValue | None, line: ComparedLine) -> str:
    if figure is None:
        return "–"
    digits = _DIGITS[line.unit]
    return f"{figure.value * line.factor:z.{digits}f} ± {figure.error * line.factor:.{digits}f}"


def _in_percent(line: ComparedLine) -> bool:
    return not (line.unit in ("deg", "–") or line.key.endswith("load_harmonic"))


def _difference(line: ComparedLine) -> str:
    if line.outcome == "not compared" or line.recording is None:
        return "–"
    if not _in_percent(line):
        digits = _DIGITS[line.unit]
        return (
            f"{line.difference * line.factor:+z.{digits}f} ± {line.error * line.factor:.{digits}f}"
        )
    share = 100.0 / abs(line.recording.value)
    return f"{line.difference * share:+z.1f} ± {line.error * share:.1f} %"


def make_page(found: Validation, sources: Mapping[str, Sequence[Path | str]]) -> str:
    """HTML of a validation."""
    last = found.rounds[-1]
    said = sentences(found)
    names = [result.drive.name for result in found.recordings]
    courses = [
        plot(_courses(result, simulation), run=name, name=f"{name}_stiffness")
        for name, result, simulation in zip(names, found.recordings, last.simulations, strict=True)
    ]
    return document(
        "validate/page.html",
        "Validation: simulation against recording",
        meta=", ".join(names),
        sources=sources,
        verdict={
            "kind": "good" if found.passed else "bad", "sentence": said[0], "reasons": said[1:]
        },
        history=_history(found) if len(found.rounds) > 1 else [],
        changes=_changes(found),
        compared=[(name, rows(lines)) for name, lines in zip(names, last.lines, strict=True)],
        criterion=CRITERION,
        least_damping_ratio=LEAST_DAMPING_RATIO,
        courses=list(zip(names, courses, strict=True)),
    )  # fmt: skip


def _history(found: Validation) -> list[list[str]]:
    body = []
    for number, turn in enumerate(found.rounds, start=1):
        v_crit = _v_crit(turn)
        body.append([
            str(number), str(len(turn.failed)), f"{turn.worst:.2f}",
            "–" if v_crit is None else f"{v_crit * KMH:.1f} km/h",
            "; ".join(change_text(c) for c in turn.corrections) or "nothing to correct",
        ])  # fmt: skip
    return body


def _changes(found: Validation) -> list[list[str]]:
    body = []
    for change in found.total:
        unit, factor, digits = _unit_of(change.key)
        before, after = (f"{x * factor:.{digits}f}" for x in (change.before, change.after))
        body.append([
            change.key, before, f"{after} ± {change.error * factor:.{digits}f}",
            f"{100 * change.share:+.1f} %" if change.before else "added", unit,
        ])  # fmt: skip
    return body


def _courses(recording: DriveResult, simulation: DriveResult) -> go.Figure:
    shown = [a for a in AXLES if any(r.estimates.has(a).any() for r in (recording, simulation))]
    figure = make_subplots(rows=max(1, len(shown)), cols=1, shared_xaxes=True,
                           vertical_spacing=0.04)  # fmt: skip
    for number, axle in enumerate(shown, start=1):
        for result, name, colour in (
            (recording, "recording", RECORDED), (simulation, "simulation", SIMULATED),
        ):  # fmt: skip
            estimates = result.estimates
            good = usable(estimates) & estimates.has(axle)
            figure.add_scatter(
                x=estimates.time_s[good],
                y=1e-3 * estimates[f"{axle}.cornering_stiffness_n_per_rad"][good],
                mode="markers", marker={"color": colour, "size": 4}, name=name,
                legendgroup=name, showlegend=number == 1, row=number, col=1,
            )  # fmt: skip
        figure.update_yaxes(title=f"{axle.replace('_', ' ')} [kN/rad]", row=number, col=1)
    figure.update_xaxes(title="time [s]", row=max(1, len(shown)), col=1)
    figure.update_layout(
        height=170 * max(1, len(shown)) + 60, margin={"l": 76, "r": 24, "t": 40, "b": 52},
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0.0},
    )  # fmt: skip
    return figure


def as_json(found: Validation) -> dict[str, Any]:
    """A validation as plain types, SI units."""
    return {
        "swaywatch": __version__,
        "passed": found.passed,
        "conclusion": sentences(found),
        "corrections": [
            {"key": c.key, "before": c.before, "after": c.after, "standard_error": c.error}
            for c in found.total
        ],
        "rounds": [
            {
                "beyond": len(turn.failed),
                "worst": turn.worst,
                "v_crit_m_s": _v_crit(turn),
                "drives": [
                    {"name": result.drive.name, "lines": [_json_line(x) for x in lines]}
                    for result, lines in zip(found.recordings, turn.lines, strict=True)
                ],
            }
            for turn in found.rounds
        ],
    }


def _json_line(line: ComparedLine) -> dict[str, Any]:
    def figure(side: MeanValue | None) -> dict[str, float] | None:
        return None if side is None else {"value": side.value, "standard_error": side.error}

    def number(value: float) -> float | None:
        return value if math.isfinite(value) else None

    return {
        "key": line.key, "kind": line.kind, "recording": figure(line.recording),
        "simulation": figure(line.simulation), "difference": number(line.difference),
        "standard_error": number(line.error), "allowed": number(line.allowed),
        "outcome": line.outcome,
    }  # fmt: skip
