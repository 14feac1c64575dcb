"""Critical speed and damping that each finding costs: the part of the page on stability."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import plotly.graph_objects as go

from swaywatch.diagnose.report.labels import named, when
from swaywatch.report.shell import plot

COLOURS = ("#93c5fd", "#2563eb", "#1e3a8a")
FASTEST_KMH = 302  # of the search, see `models.modes`
MIDDLE = 1
EXACT_KMH = 0.01  # a narrower interval is not shown
Figures = Sequence[Mapping[str, float] | None]


def costs_part(result: Mapping[str, Any]) -> dict[str, Any] | None:
    """Data of ``costs_page.html``; None without an evaluation of stability."""
    block = result.get("stability")
    if not block:
        return None
    return {
        "summary": _summary(block),
        "plot": plot(_picture(block), name="costs", least_width=600) if block["causes"] else None,
        "head": _head(block),
        "rows": _rows(block),
        "left_out": [(named(entry["name"]), entry["reason"]) for entry in block["left_out"]],
    }


def _summary(block: Mapping[str, Any]) -> str:
    swing = block["swings_deg_s"][MIDDLE]
    text = f"Critical speed of a swing of {swing:g} deg/s: "
    calibrated = _speed(block["calibrated"]["v_crit_km_h"][MIDDLE])
    if block["beside_simulation"]:
        text += f"{calibrated} of our model fitted to your simulation, not of the simulation itself"
    else:
        text += (
            f"{_speed(block['believed_v_crit_km_h'])} from vehicle.toml and its tolerances, "
            f"{calibrated} of the calibrated vehicle"
        )
    if not block["causes"]:
        return text + "."
    before, after = (
        _ratio(block[which]["damping_ratio"][MIDDLE]) for which in ("calibrated", "diagnosed")
    )
    return (
        f"{text} without the findings, {_speed(block['diagnosed']['v_crit_km_h'][MIDDLE])} "
        f"with them. At {block['speed_km_h']:.0f} km/h the damping ratio is {before} without the "
        f"findings and {after} with them."
    )


def _ratio(value: float | None) -> str:
    return "none (no oscillation)" if value is None or value != value else f"{value:.3f}"  # noqa: PLR0124


def _picture(block: Mapping[str, Any]) -> go.Figure:
    """Bars of each finding, the largest gain on top; those without a limit are left out."""
    causes = list(reversed(block["causes"]))
    figure = go.Figure()
    for k, (swing, colour) in enumerate(zip(block["swings_deg_s"], COLOURS, strict=True)):
        rows = [(c["name"], c["gives_back_km_h"][k]) for c in causes]
        shown = [(named(name), row) for name, row in rows if row is not None]
        figure.add_bar(
            y=[name for name, _ in shown], x=[row["value"] for _, row in shown], orientation="h",
            error_x={
                "type": "data", "color": "#6b7280",
                "array": [row["high"] - row["value"] for _, row in shown],
            },
            name=f"swing of {swing:g} deg/s", marker_color=colour,
        )  # fmt: skip
    figure.update_layout(
        title="Critical speed gained without each finding", barmode="group",
        height=170 + 62 * len(causes), margin={"l": 20, "r": 20, "t": 80, "b": 50},
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 1.0, "xanchor": "right"},
    )  # fmt: skip
    figure.update_xaxes(title_text="gain [km/h] (negative: the finding stabilises)", zeroline=True)
    figure.update_yaxes(
        automargin=True, categoryorder="array", categoryarray=[named(c["name"]) for c in causes]
    )
    return figure


def _head(block: Mapping[str, Any]) -> list[str]:
    swings = [f"swing of {swing:g} deg/s" for swing in block["swings_deg_s"]]
    return ["gain without the finding [km/h]", *swings, "damping ratio without it"]


def _rows(block: Mapping[str, Any]) -> list[list[str]]:
    rows = []
    for cause in block["causes"]:
        rows.append([
            named(cause["name"]),
            *(_back(cause, block, k) for k in range(len(block["swings_deg_s"]))),
            _ratio(cause["damping_ratio_without"][MIDDLE]),
        ])  # fmt: skip
        windows = cause["windows"]
        if len(windows) > 1:
            for w in sorted(windows, key=lambda w: (w["run"], w["start"])):
                mark = " (this one counts)" if w["counts"] else ""
                value = w["gives_back_km_h"]
                cells = ["", "no critical speed" if value is None else _interval(value), "", ""]
                rows.append([f"· {when([w])}{mark}", *cells])
    return rows


def _back(cause: Mapping[str, Any], block: Mapping[str, Any], k: int) -> str:
    value = cause["gives_back_km_h"][k]
    if value is not None:
        return _interval(value)
    if block["diagnosed"]["v_crit_km_h"][k] is None:
        without = cause["v_crit_without_km_h"][k]
        return "none with it" + ("" if without is None else f", {_interval(without)} without")
    return "none without it"


def _speed(row: Mapping[str, float] | None) -> str:
    return _interval(row) if row is None else f"{_interval(row)} km/h"


def _interval(row: Mapping[str, float] | None) -> str:
    if row is None:
        return f"none up to {FASTEST_KMH} km/h"
    if row["high"] - row["low"] < EXACT_KMH:
        return f"{row['value']:.1f}"
    return f"{row['value']:.1f} ({row['low']:.1f} to {row['high']:.1f})"
