"""A plan in words, figures and as a page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from swaywatch import __version__
from swaywatch.plan.design import BLOCK_S, KMH, Design
from swaywatch.plan.files import courses
from swaywatch.plan.knowledge import SETS
from swaywatch.report.shell import document, plot
from swaywatch.simulate.manoeuvres import make_plan
from swaywatch.simulate.table import Table

_STEP_S = 0.02
_DETERMINED = 0.7
"""An error that the test reduces by less than this share is reported as hardly determined."""


def critical_words(design: Design) -> str:
    """Error of the critical speed after the test."""
    critical = design.critical
    if not math.isfinite(critical.speed_m_s):
        return "With the values of vehicle.toml there is no critical speed up to 300 km/h."
    believed = KMH * critical.error(np.eye(len(design.known.unknowns)))
    return (
        f"This test determines the critical speed to ± {design.error_kmh:.1f} km/h (expected from "
        f"vehicle.toml: {KMH * critical.speed_m_s:.0f} ± {believed:.0f} km/h)."
    )


def sentences(design: Design) -> list[str]:
    """Further results, the most important first."""
    minutes = courses(design.blocks)[1] / 60.0 if design.blocks else 0.0
    limits = design.limits
    texts = [
        f"{len(design.blocks)} block{'s' * (len(design.blocks) != 1)} of {BLOCK_S:g} s, "
        f"{minutes:.1f} min including transitions; no faster than {limits.fastest_kmh:.0f} km/h"
        + (
            f", {KMH * design.critical.speed_m_s - limits.fastest_kmh:.0f} km/h below the expected "
            "critical speed"
            if math.isfinite(design.critical.speed_m_s)
            else ""
        )
        + f"; lateral acceleration up to {limits.acceleration_m_s2:g} m/s²."
    ]
    worst = _worst(design)
    if worst:
        texts.insert(0, worst)
    blind = [
        u.words
        for u, e in zip(design.known.unknowns, _errors(design), strict=True)
        if e > _DETERMINED
    ]
    if blind:
        texts.append(f"Hardly determined: {', '.join(blind)}.")
    if math.isinf(design.slalom_blocks):
        texts.append("A slalom at the sway frequency does not reach this accuracy in 1000 blocks.")
    elif design.slalom_blocks > 1.5 * max(1, len(design.blocks)):
        times = design.slalom_blocks / max(1, len(design.blocks))
        texts.append(
            f"A slalom at the sway frequency, at the best of the speeds, would take "
            f"{times:.0f} times as long for the same accuracy."
        )
    return texts


def _worst(design: Design) -> str:
    """The value of the vehicle that is known least after the test."""
    known = [
        (error * unknown.deviation / unknown.value, unknown)
        for unknown, error in zip(design.known.unknowns, _errors(design), strict=True)
        if "." in unknown.name
    ]
    if not known:
        return ""
    error, unknown = max(known, key=lambda one: one[0])
    return (
        f"Values of the vehicle: known to ± {100.0 * error:.2g} % or better (the worst is "
        f"{unknown.words}, ± {100.0 * unknown.deviation / unknown.value:.2g} % before the test)."
    )


def _errors(design: Design) -> np.ndarray:
    return np.sqrt(np.diag(design.covariance))


def rows_of_unknowns(design: Design) -> list[list[str]]:
    """Every unknown: value, standard error before and predicted after the test."""
    rows = []
    for unknown, error in zip(design.known.unknowns, _errors(design), strict=True):
        before, after = unknown.deviation / unknown.value, error * unknown.deviation / unknown.value
        rows.append(
            [
                unknown.words, _value(unknown.value, unknown.unit), f"± {100 * before:.0f} %",
                f"± {100 * after:.2g} %",
            ]
        )  # fmt: skip
    return rows


def _value(value: float, unit: str) -> str:
    number = f"{value:,.0f}" if value >= 1000.0 else f"{value:.3g}"
    return number if unit == "-" else f"{number} {unit}"


def rows_of_blocks(design: Design) -> list[list[str]]:
    """Every block in the order to be driven."""
    return [
        [
            str(number), f"{block.speed_kmh:.0f}", block.words,
            " and ".join(_steering(t) for t in block.tables),
        ]
        for number, block in enumerate(design.blocks, 1)
    ]  # fmt: skip


def _steering(entry: dict[str, Any]) -> str:
    words = f"{entry['angle_deg']:g} deg"
    if "frequency_hz" in entry:
        words += f" at {entry['frequency_hz']:g} Hz"
    if "from_hz" in entry:
        words += f" from {entry['from_hz']:g} to {entry['to_hz']:g} Hz"
    return words


def rows_of_sensors(design: Design) -> list[list[str]]:
    """Result of the same test with each set of sensors."""
    rows = []
    for name, (error, unknowns) in design.by_sensors.items():
        worst = int(np.argmax(unknowns))
        shown = "-" if not math.isfinite(design.critical.speed_m_s) else f"± {KMH * error:.2f} km/h"
        rows.append(
            [
                f"{'→ ' if name == design.sensors else ''}{name}: {SETS[name][0]}", shown,
                f"{int(np.sum(unknowns < _DETERMINED))} of {len(unknowns)}",
                design.known.unknowns[worst].words,
            ]
        )  # fmt: skip
    return rows


UNKNOWN_HEADS = ("unknown", "expected value", "error before", "error after")
BLOCK_HEADS = ("block", "km/h", "manoeuvre", "steering wheel")
SENSOR_HEADS = ("sensors", "critical speed", "unknowns determined", "least certain")


def course_figure(design: Design) -> go.Figure:
    """Steering wheel and speed over the whole test."""
    tables, duration, first = courses(design.blocks)
    time = np.asarray(np.arange(0.0, duration, _STEP_S), dtype=np.float64)
    made = make_plan(time, first / KMH, [Table(dict(t), "plan") for t in tables])
    figure = make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.06,
                           row_heights=[0.6, 0.4])  # fmt: skip
    style = {"color": "#0072B2", "width": 1}
    figure.add_trace(
        go.Scatter(x=time, y=np.degrees(made.steering_rad), line=style, name="steering wheel",
                   showlegend=False), row=1, col=1,
    )  # fmt: skip
    figure.add_trace(
        go.Scatter(x=time, y=KMH * made.speed_m_s, line=style, name="speed", showlegend=False),
        row=2, col=1,
    )  # fmt: skip
    if math.isfinite(design.critical.speed_m_s):
        figure.add_hline(
            y=KMH * design.critical.speed_m_s, line={"color": "#D55E00", "dash": "dash"}, row=2,
            col=1, annotation_text="expected critical speed", annotation_position="top left",
        )  # fmt: skip
    figure.update_yaxes(title_text="steering wheel [deg]", row=1, col=1)
    figure.update_yaxes(title_text="speed [km/h]", row=2, col=1, rangemode="tozero")
    figure.update_xaxes(title_text="time [s]", row=2, col=1)
    figure.update_layout(height=460, margin={"l": 80, "r": 24, "t": 20, "b": 52})
    return figure


def error_figure(design: Design) -> go.Figure:
    """Errors before and after, and with each set of sensors."""
    names = [unknown.words for unknown in design.known.unknowns]
    share = np.array([100 * u.deviation / u.value for u in design.known.unknowns])
    figure = go.Figure()
    figure.add_trace(
        go.Bar(y=names, x=share, orientation="h", name="before the test", marker_color="#9ca3af")
    )
    colours = ("#0072B2", "#E69F00", "#009E73", "#CC79A7")
    for colour, (name, (_, errors)) in zip(colours, design.by_sensors.items(), strict=True):
        figure.add_trace(
            go.Bar(y=names, x=share * errors, orientation="h", name=f"after, sensors: {name}",
                   marker_color=colour)
        )  # fmt: skip
    figure.update_xaxes(title_text="standard error [%]", type="log", dtick=1)
    figure.update_yaxes(autorange="reversed", automargin=True)
    figure.update_layout(
        height=60 * len(names) + 120, barmode="group", margin={"l": 200, "r": 24, "t": 34, "b": 52},
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom"},
    )  # fmt: skip
    return figure


def make_page(design: Design, sources: Mapping[str, Sequence[Path]], title: str) -> str:
    """The page of a plan."""
    return document(
        "plan/page.html",
        title,
        sources=sources,
        critical=critical_words(design),
        sentences=sentences(design),
        blocks=(BLOCK_HEADS, rows_of_blocks(design)),
        course=plot(course_figure(design), name="plan", run="plan"),
        unknowns=(UNKNOWN_HEADS, rows_of_unknowns(design)),
        errors=plot(error_figure(design), name="errors"),
        sensors=(SENSOR_HEADS, rows_of_sensors(design)),
    )


def as_json(design: Design) -> dict[str, Any]:
    """Everything in plain numbers, SI units."""
    finite = math.isfinite(design.critical.speed_m_s)
    slalom = design.slalom_blocks
    return {
        "swaywatch": __version__,
        "critical_speed_m_s": design.critical.speed_m_s if finite else None,
        "critical_speed_error_m_s": design.critical.error(design.covariance) if finite else None,
        "fastest_kmh": design.limits.fastest_kmh,
        "lateral_acceleration_m_s2": design.limits.acceleration_m_s2,
        "sensors": design.sensors,
        "blocks": [
            {"speed_kmh": b.speed_kmh, "manoeuvre": b.words, "tables": list(b.tables)}
            for b in design.blocks
        ],
        "unknowns": [
            {
                "name": u.name, "unit": u.unit, "value": u.value, "believed_error": u.deviation,
                "predicted_error": float(e) * u.deviation,
            }
            for u, e in zip(design.known.unknowns, _errors(design), strict=True)
        ],
        "critical_speed_error_by_sensors_m_s": {n: e for n, (e, _) in design.by_sensors.items()},
        "blocks_of_plain_slalom": slalom if math.isfinite(slalom) else None,
    }  # fmt: skip
