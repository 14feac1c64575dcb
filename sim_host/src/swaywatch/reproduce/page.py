"""The report of ``swaywatch reproduce`` as one HTML file that needs nothing else."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass, field

import plotly.graph_objects as go

from swaywatch.report.shell import document, plot, wide

BLUE, ORANGE, GREEN, RED, PINK, GREY = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#6b7280",
)  # fmt: skip
COLOURS = (BLUE, ORANGE, GREEN, RED, PINK, GREY)


@dataclass(frozen=True)
class Check:
    """One figure against its reference.

    Attributes
    ----------
    tolerance : largest distance that counts as met, in ``unit``
    sense : ``within`` the tolerance, or only ``above`` or ``below`` the reference
    cause : why it is missed where it is: what a computed experiment says
    """

    what: str
    reference: float
    value: float
    tolerance: float
    unit: str
    sense: str = "within"
    cause: str = ""

    @property
    def met(self) -> bool:
        """Does the figure meet its reference."""
        if self.sense == "above":
            return self.value > self.reference
        if self.sense == "below":
            return self.value < self.reference
        return abs(self.value - self.reference) <= self.tolerance

    def words(self) -> str:
        """What is asked for, in words."""
        if self.sense == "within":
            return f"{self.reference:.4g} +- {self.tolerance:.3g} {self.unit}"
        return f"{self.sense} {self.reference:.4g} {self.unit}"


@dataclass(frozen=True)
class PageTable:
    """Rows of cells under a head; numbers are set right."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str | float, ...], ...]
    note: str = ""


@dataclass(frozen=True)
class Plot:
    """A plot with what it shows."""

    title: str
    plot: go.Figure
    text: str


@dataclass
class Chapter:
    """A chapter of the report, in the order text, parts."""

    title: str
    text: str
    parts: list[Plot | PageTable] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)


def make_page(chapters: Sequence[Chapter], seconds: float) -> str:
    """HTML of the whole report."""
    body = [
        "<h2>Against the reference</h2>",
        _checks([check for chapter in chapters for check in chapter.checks]),
    ]
    for chapter in chapters:
        body += [f"<h2>{html.escape(chapter.title)}</h2>", f"<p>{html.escape(chapter.text)}</p>"]
        for part in chapter.parts:
            body.append(_table(part) if isinstance(part, PageTable) else _figure(part))
    meta = (
        f"Simulated drives, read by the C core; made in {seconds:.0f} s. Reference: N. Zhang, "
        "Stability Investigation of Car-trailer Combinations based on Time-Frequency Analysis, "
        "TU Darmstadt 2015"
    )
    return document("Chapters 3, 5 and 6 reproduced", body, meta=meta)


def _checks(checks: Sequence[Check]) -> str:
    rows = "".join(
        f"<tr><td>{html.escape(check.what)}</td><td class='number'>{_number(check.reference)}</td>"
        f"<td class='number'>{_number(check.value)}</td>"
        f"<td class='number'>{_allowed(check)}</td>"
        f"<td>{html.escape(check.unit)}</td>"
        f"<td class='number'>{_number(check.value - check.reference)}</td>"
        f"<td class='{'met' if check.met else 'missed'}'>{'met' if check.met else 'missed'}</td>"
        f"<td>{'' if check.met else html.escape(check.cause)}</td></tr>"
        for check in checks
    )
    head = (
        "<tr><th></th><th>reference</th><th>here</th><th>within</th><th>unit</th>"
        "<th>difference</th><th></th><th>why missed</th></tr>"
    )
    return wide(f"<table>{head}{rows}</table>")


def _allowed(check: Check) -> str:
    return f"&plusmn; {_number(check.tolerance)}" if check.sense == "within" else check.sense


def _table(table: PageTable) -> str:
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in table.head)
    rows = "".join(
        "<tr>"
        + "".join(
            f"<td class='number'>{_number(cell)}</td>"
            if isinstance(cell, float)
            else f"<td>{html.escape(cell)}</td>"
            for cell in row
        )
        + "</tr>"
        for row in table.rows
    )
    note = f"<div class='note'>{html.escape(table.note)}</div>" if table.note else ""
    content = wide(f"<table><tr>{head}</tr>{rows}</table>")
    return f"<h3>{html.escape(table.title)}</h3>{content}{note}"


def _figure(figure: Plot) -> str:
    return (
        f"<h3>{html.escape(figure.title)}</h3>{plot(figure.plot, name=figure.title)}"
        f"<div class='note'>{html.escape(figure.text)}</div>"
    )


def _number(value: float) -> str:
    if value != value:  # noqa: PLR0124
        return "&ndash;"
    if value == 0.0:
        return "0"
    size = abs(value)
    digits = 0 if size >= 1000 else 1 if size >= 100 else 2 if size >= 10 else 4
    return f"{value:.{digits}f}"


def styled(figure: go.Figure, height: int = 460) -> go.Figure:
    """Common look: units on the axes, legend above."""
    figure.update_layout(
        height=height,
        margin={"l": 78, "r": 24, "t": 34, "b": 52},
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0.0},
    )
    axis = {"showline": True, "linecolor": "#9ca3af", "ticks": "outside", "zeroline": False}
    figure.update_xaxes(**axis)
    figure.update_yaxes(**axis)
    return figure
