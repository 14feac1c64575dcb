"""The report as a page of swaywatch's look: verdict, courses, windows on the signals, tables."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from swaywatch.damping.compare import Comparison
from swaywatch.damping.find import Found
from swaywatch.damping.intervals import Point
from swaywatch.damping.sentences import interval, probability, sentences, verdict
from swaywatch.damping.study import Study, kind_of
from swaywatch.report.figures import thinned
from swaywatch.report.shell import PackedPlot, document, plot

_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#6b7280")
_TITLES = {
    "damping_ratio": "damping ratio [–]",
    "frequency_hz": "frequency [Hz]",
    "growth_1_s": "growth [1/s]",
}
_MOST_RUNS = 12
_MOST_WINDOWS = 400
_ROW_PX, _TITLE_LETTERS = 150, 16
_MOST_OPEN = 24
"""Windows up to which their table is not folded."""


def make_page(study: Study, sources: dict[str, list[Path]]) -> str:
    """HTML of an evaluation."""
    kind, sentence = verdict(study)
    shown = study.found[:_MOST_RUNS]
    return document(
        "damping/page.html",
        "Damping against speed (ISO 9815)" if study.plan.iso9815 else "Free oscillations",
        meta=", ".join(found.run.path.name for found in study.found),
        sources=sources,
        verdict={"kind": kind, "sentence": sentence, "reasons": sentences(study)},
        course=plot(course_figure(study), name="damping") if study.points else None,
        course_over=study.against_name if study.course is not None else "",
        comparisons=_groups(study),
        against_name=study.against_name or "",
        places=_places(study),
        windows=_windows(study),
        most_open=_MOST_OPEN,
        signals=[
            (found.run.name, plot(signal_figure(found), run=found.run.name, name=found.run.name))
            for found in shown
        ],
        more_recordings=len(study.found) - len(shown),
    )


def _against_title(study: Study) -> str:
    unit = f" [{study.against_unit}]" if study.against_unit else ""
    return f"{study.against_name or 'window'}{unit}"


def course_figure(study: Study) -> go.Figure:
    """Damping ratio, frequency and growth over the speed: points, course, second group, model."""
    figure = make_subplots(rows=3, cols=1, shared_xaxes=True, vertical_spacing=0.05,
                           row_heights=[0.46, 0.27, 0.27])  # fmt: skip
    if study.course is not None:
        _band(figure, study)
    groups = [(study, "measured" if study.groups is None else study.groups.names[0], _COLOURS[0])]
    if study.compared is not None:
        name = "second" if study.groups is None else study.groups.names[1]
        groups.append((study.compared, name, _COLOURS[1]))
    for row, quantity in enumerate(_TITLES, 1):
        for group, name, colour in groups:
            _points(figure, list(group.points), quantity, row, name, colour)
        if study.against_model is not None:
            at = study.against_model.of(quantity)
            figure.add_trace(
                go.Scatter(
                    x=[one.place for one in at],
                    y=[one.first.value for one in at if one.first is not None],
                    mode="lines+markers", line={"color": _COLOURS[2], "dash": "dash"},
                    name=study.against_model.names[0], showlegend=row == 1,
                ), row=row, col=1,
            )  # fmt: skip
        figure.update_yaxes(title_text=_TITLES[quantity], row=row, col=1)
        span = _span(study, quantity)
        if span is not None:
            figure.update_yaxes(range=span, row=row, col=1)
    figure.add_hline(y=0.0, line={"color": "#D55E00", "width": 1}, row=1, col=1)
    if study.plan.iso9815 and study.limit is not None:
        figure.add_hline(
            y=study.limit.target, line={"color": "#E69F00", "width": 1, "dash": "dash"}, row=1,
            col=1,
        )  # fmt: skip
    figure.update_xaxes(title_text=_against_title(study), row=3, col=1)
    figure.update_layout(
        height=720, margin={"l": 92, "r": 24, "t": 34, "b": 52}, hovermode="closest",
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom"},
    )  # fmt: skip
    return figure


def _span(study: Study, quantity: str) -> list[float] | None:
    """Range of an axis; a window that says next to nothing does not stretch it."""
    both = [*study.points, *(study.compared.points if study.compared else ())]
    ends = []
    for point in both:
        value = getattr(point, quantity)
        if point.determinable:
            ends += [value.low, value.high]
    if len(ends) < 4:
        return None
    low, high = float(np.percentile(ends, 2.0)), float(np.percentile(ends, 98.0))
    if quantity == "damping_ratio":
        low, high = min(low, 0.0), max(high, 0.0)
    more = 0.08 * (high - low)
    return [low - more, high + more]


def _points(
    figure: go.Figure, points: list[Point], quantity: str, row: int, name: str, colour: str
) -> None:
    values = [getattr(point, quantity) for point in points]
    place = [
        number if math.isnan(point.against) else point.against
        for number, point in enumerate(points, 1)
    ]
    figure.add_trace(
        go.Scatter(
            x=place,
            y=[value.value for value in values],
            error_y={"array": [value.half for value in values], "thickness": 0.8, "width": 0},
            mode="markers", marker={"color": colour, "size": 6}, name=name, showlegend=row == 1,
        ), row=row, col=1,
    )  # fmt: skip


def _band(figure: go.Figure, study: Study) -> None:
    course, zero = study.course, study.zero
    assert course is not None
    low, high = float(course.x.min()), float(course.x.max())
    ends = [low, high]
    if zero is not None and zero.value is not None and zero.value < high + (high - low):
        ends.append(zero.value)
    more = 0.06 * (max(ends) - min(ends))
    axis = np.linspace(min(ends) - more, max(ends) + more, 160)
    line, error = course.at(axis)
    half = course.quantile * error
    figure.add_trace(
        go.Scatter(
            x=np.concatenate([axis, axis[::-1]]),
            y=np.concatenate([line + half, (line - half)[::-1]]),
            fill="toself", fillcolor="rgba(107,114,128,0.2)", line={"width": 0},
            name="95 % band of the course", hoverinfo="skip",
        ), row=1, col=1,
    )  # fmt: skip
    figure.add_trace(
        go.Scatter(x=axis, y=line, mode="lines", line={"color": "#6b7280"}, name="course"),
        row=1, col=1,
    )  # fmt: skip
    if study.line is not None:
        figure.add_trace(
            go.Scatter(
                x=axis, y=study.line.at(axis)[0], mode="lines", name="straight line (ISO 9815)",
                line={"color": "#6b7280", "width": 1, "dash": "dot"},
            ), row=1, col=1,
        )  # fmt: skip


def _groups(study: Study) -> list[dict[str, Any]]:
    """Each comparison: its heading, its plot, names and rows of its table."""
    return [
        {
            "heading": heading, "plot": _difference_plot(study, comparison),
            "names": comparison.names, "rows": _differences(comparison),
        }
        for heading, comparison in (
            ("Two groups", study.groups), ("Model and measurement", study.against_model),
        )
        if comparison is not None
    ]  # fmt: skip


def _difference_plot(study: Study, comparison: Comparison) -> PackedPlot:
    """Difference of each quantity over the speed with its interval."""
    figure = make_subplots(rows=1, cols=3, horizontal_spacing=0.08)
    for column, quantity in enumerate(_TITLES, 1):
        at = comparison.of(quantity)
        figure.add_trace(
            go.Scatter(
                x=[k if one.place is None or math.isnan(one.place) else one.place
                   for k, one in enumerate(at, 1)],
                y=[one.difference.value for one in at],
                error_y={"array": [one.difference.half for one in at], "thickness": 1},
                mode="markers", marker={"color": _COLOURS[0], "size": 7}, showlegend=False,
            ), row=1, col=column,
        )  # fmt: skip
        figure.add_hline(y=0.0, line={"color": "#6b7280", "width": 1}, row=1, col=column)
        figure.update_yaxes(title_text=f"difference, {_TITLES[quantity]}", row=1, col=column)
        figure.update_xaxes(title_text=_against_title(study), row=1, col=column)
    figure.update_layout(height=340, margin={"l": 70, "r": 20, "t": 20, "b": 52})
    return plot(figure, name="difference", least_width=900)


def _differences(comparison: Comparison) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    apart = comparison.apart
    everywhere = "all" if apart is None else f"{apart[0]:.4g}, {apart[1]:.4g}"
    for one in (*comparison.at, *(comparison.over_all if apart is None else ())):
        whole = one.place is None or math.isnan(one.place)
        rows.append(
            (
                _TITLES[one.quantity],
                everywhere if whole else f"{one.place:.4g}",
                "" if one.first is None else interval(one.first),
                "" if one.second is None else interval(one.second),
                interval(one.difference),
                probability(one.p_value),
            )
        )
    return rows


def _places(study: Study) -> list[tuple[str, ...]]:
    return [
        (
            "" if math.isnan(place.against) else f"{place.against:.4g} {study.against_unit}",
            str(place.count),
            interval(place.frequency_hz),
            interval(place.damping_ratio) if place.determinable
            else f"not determinable: {interval(place.damping_ratio)}",
            interval(place.growth_1_s),
        )
        for place in study.places
    ]  # fmt: skip


def _windows(study: Study) -> list[tuple[str, ...]]:
    return [
        (
            point.run, str(point.number), f"{point.start_s:.2f}", f"{point.end_s:.2f}",
            f"{point.cycles:.1f}", "" if math.isnan(point.against) else f"{point.against:.4g}",
            interval(point.frequency_hz), interval(point.damping_ratio),
            interval(point.growth_1_s, 2),
        )
        for point in study.points[:_MOST_WINDOWS]
    ]  # fmt: skip


def _axis_title(name: str, unit: str) -> str:
    """Name and unit in lines that fit beside one row of the plot."""
    shown = unit.replace("m/s2", "m/s²")
    words = re.split(r"[_\s]+", name) + ([f"[{shown}]"] if shown else [])
    lines = [words[0]]
    for word in words[1:]:
        if len(lines[-1]) + 1 + len(word) <= _TITLE_LETTERS:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return "<br>".join(lines)


def signal_figure(found: Found) -> go.Figure:
    """The channels, first the swinging ones, with the windows that were found."""
    run = found.run
    shown = [
        *zip(run.channels, run.units, run.value.T, strict=True),
        *[(name, "", run.inputs[:, k]) for k, name in enumerate(run.input_names)],
    ][:5]  # fmt: skip
    figure = make_subplots(rows=len(shown), cols=1, shared_xaxes=True, vertical_spacing=0.04)
    for row, (name, unit, value) in enumerate(shown, 1):
        time, thin = thinned(run.time_s, value)
        figure.add_trace(
            go.Scatter(x=time, y=thin, line={"color": _COLOURS[0], "width": 1}, name=name,
                       showlegend=False), row=row, col=1,
        )  # fmt: skip
        figure.update_yaxes(title_text=_axis_title(name, unit), row=row, col=1)
    figure.update_layout(shapes=_marks(found, len(shown)))
    figure.update_xaxes(title_text="time [s]", row=len(shown), col=1)
    figure.update_layout(
        height=max(240, _ROW_PX * len(shown)), margin={"l": 92, "r": 24, "t": 20, "b": 52},
        hovermode="x unified",
    )  # fmt: skip
    return figure


def _marks(found: Found, rows: int) -> list[dict[str, object]]:
    """Windows and other events as shapes of every row.

    All at once: added one by one each copies all before it, minutes for a long flight.
    """
    marks: list[dict[str, object]] = []

    def mark(x0: float, x1: float, **looks: object) -> None:
        for row in range(1, rows + 1):
            axis = "" if row == 1 else str(row)
            marks.append(
                {"x0": x0, "x1": x1, "y0": 0, "y1": 1, "xref": f"x{axis}",
                 "yref": f"y{axis} domain", **looks}
            )  # fmt: skip

    for number, event in enumerate(found.events):
        kind = kind_of(found, number)
        if kind == "not one damped line":
            grey = {"color": "#9ca3af", "width": 1}
            mark(event.peak_s, event.peak_s, type="line", line=grey)
        for window in event.windows:
            begin, end = window.line.start_s, window.line.start_s + window.line.length_s
            colour = _COLOURS[0] if kind == "free" else _COLOURS[4]
            mark(begin, end, type="rect", line={"width": 0}, fillcolor=colour, opacity=0.18)
    return marks
