"""The report of a diagnosis: one self-contained HTML page."""

from __future__ import annotations

import html
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from swaywatch.diagnose.fingerprint import LINES, line_map, relations
from swaywatch.diagnose.fit import Fit, Problem, predict_run

_STYLE = """
body{font:15px/1.5 system-ui,sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:1em 0}td,th{border:1px solid #ccc;padding:.25em .6em;
text-align:left}h1{font-size:1.5em}h2{font-size:1.2em;margin-top:2em}.v{font-size:1.2em}
"""
_SHOWN = ("trailer_yaw_rate", "car_lateral_acceleration", "hitch_lateral_force")
#: A balance of linear terms is this far off on clean recordings (noise, small-angle remainders).
CLEAN_PERCENT = 3.0


def _table(head: list[str], rows: list[list[str]]) -> str:
    cells = "".join(f"<th>{html.escape(x)}</th>" for x in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(x)}</td>" for x in row) + "</tr>" for row in rows
    )
    return f"<table><tr>{cells}</tr>{body}</table>"


def _figure(figure: go.Figure, first: bool) -> str:
    return str(figure.to_html(full_html=False, include_plotlyjs=first))


def where(problem: Problem, index: int) -> go.Figure:
    """Map of relation and line over time, mismatch in colour (per cent of the largest term)."""
    run = problem.runs[index]
    names, rows, times = [], [], np.zeros(0)
    for relation in relations(run, problem.body):
        times, values = line_map(run, relation)
        for column, line in enumerate(LINES):
            names.append(f"{relation.name}, {line}")
            rows.append(values[:, column])
    heat = go.Heatmap(
        z=np.array(rows), x=times, y=names, zmin=0.0, zmax=20.0, colorscale="YlOrRd",
        colorbar={"title": "% of the<br>largest term"},
    )  # fmt: skip
    figure = go.Figure(heat)
    figure.update_layout(
        title=f"{run.name}: mismatch of each relation, from measured signals alone",
        xaxis_title="time in s", height=max(360, 17 * len(names)), margin={"l": 220},
    )  # fmt: skip
    figure.update_yaxes(autorange="reversed", tickfont={"size": 10})
    return figure


def before_after(problem: Problem, baseline: Fit, fit: Fit, index: int) -> go.Figure:
    """Measured signals with the simulation before and after."""
    run = problem.runs[index]
    shown = [name for name in _SHOWN if name in run.channels]
    figure = make_subplots(len(shown), 1, shared_xaxes=True, subplot_titles=shown)
    before = predict_run(problem, index, baseline.terms, baseline.nuisance[index], baseline.shared)
    after = predict_run(problem, index, fit.terms, fit.nuisance[index], fit.shared)
    for row, name in enumerate(shown, start=1):
        offset = float(np.mean(run.channels[name] - after[name]))
        for label, values, colour in (
            ("measured", run.channels[name] - offset, "#888"),
            ("before", before[name], "#d62728"),
            ("after", after[name], "#1f77b4"),
        ):
            figure.add_scatter(
                x=run.time[::2], y=values[::2], name=label, row=row, col=1,
                line={"color": colour, "width": 1}, showlegend=row == 1,
            )  # fmt: skip
    figure.update_layout(title=f"{run.name}: before and after", height=230 * len(shown))
    return figure


def _what(result: dict[str, Any]) -> str:
    rows = []
    for effect in result["effects"]:
        values = "; ".join(
            f"{k} {v['value']:.4g} [{v['low']:.4g}, {v['high']:.4g}]"
            for k, v in effect["parameters"].items()
        )
        windows = "; ".join(f"{a:.1f}-{b:.1f} s" for a, b in effect["windows"]) or "always"
        same = ", ".join(effect["equivalent_details"]) or "none"
        if effect["told_apart_by"]:
            same += f" (decided by: {effect['told_apart_by']})"
        rows.append(
            [
                effect["id"],
                effect["component"],
                values,
                windows,
                ", ".join(effect["lines"]),
                f"{effect['confidence']:.2f}",
                same,
                effect["equation"],
            ]
        )
    head = [
        "what",
        "where",
        "how much (90 %)",
        "when",
        "lines",
        "confidence",
        "equivalent",
        "model",
    ]
    return _table(head, rows) if rows else "<p>No effect is claimed.</p>"


def _fits(result: dict[str, Any]) -> str:
    if not result["effects"]:
        return ""
    fit = result["effects"][0]["fit"]
    return _table(
        ["figure", "before", "after"],
        [
            ["NRMSE, fitted runs", _number(fit["baseline_nrmse"]), _number(fit["diagnosed_nrmse"])],
            [
                "NRMSE, each run predicted from the others",
                _number(fit["held_out_baseline_nrmse"]),
                _number(fit["held_out_diagnosed_nrmse"]),
            ],
            ["ISO/TS 18571", _number(fit["iso18571_before"]), _number(fit["iso18571_after"])],
        ],
    )


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


def page(result: dict[str, Any], problem: Problem, baseline: Fit, fit: Fit) -> str:
    """The whole page."""
    evidence = result["evidence"]
    parts = [
        "<h1>Diagnosis</h1>",
        f"<p class=v>Verdict: <b>{html.escape(result['verdict'].replace('_', ' '))}</b></p>",
        f"<p>Mean squared mismatch over the noise: {evidence['level_without']:.2f} without, "
        f"{evidence['level_with']:.2f} with what is claimed; clean recordings reach about 1, "
        f"at most {evidence['level_clean']:.2f}.</p>",
        "<h2>What</h2>", _what(result),
        "<h2>Where</h2>",
        f"<p>On clean recordings a relation is off by up to {CLEAN_PERCENT:.0f} %.</p>",
    ]  # fmt: skip
    first = True
    for index in range(len(problem.runs)):
        parts.append(_figure(where(problem, index), first))
        first = False
    parts += ["<h2>Before and after</h2>", _fits(result)]
    for index in range(len(problem.runs)):
        parts.append(_figure(before_after(problem, baseline, fit, index), first=False))
    ranking = [[x["name"], f"{x['level']:.2f}"] for x in evidence["ranking"]]
    parts += ["<h2>Ranking</h2>", _table(["explanation", "mismatch with it"], ranking)]
    parts.append("<h2>What remains</h2>")
    notes = [note.get("reason") or _place(note) for note in result["unexplained"]]
    parts += [f"<p>{html.escape(note)}</p>" for note in notes] or ["<p>Nothing above noise.</p>"]
    parts.append("<h2>Checks</h2>")
    parts += [f"<p>{html.escape(str(check))}</p>" for check in result["checks"]]
    return (
        "<!doctype html><html lang=en><head><meta charset=utf-8><title>Diagnosis</title>"
        f"<style>{_STYLE}</style></head><body>{''.join(parts)}</body></html>\n"
    )


def _place(note: dict[str, Any]) -> str:
    return (
        f"an unknown force in the {note['location']} would take {note['share_of_mismatch']:.0%} "
        f"of the rest away, strongest at {note['frequency_hz']:.2f} Hz"
    )


def write_page(text: str, path: Path) -> None:
    """Write whole or not at all."""
    part = path.with_suffix(".part")
    part.write_text(text)
    part.replace(path)
