"""The report of ``swaywatch reproduce`` as one HTML file that needs nothing else."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass, field

import plotly.graph_objects as go
import plotly.offline

from swaywatch import __version__

BLUE, ORANGE, GREEN, RED, PINK, GREY = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#6b7280",
)  # fmt: skip
COLOURS = (BLUE, ORANGE, GREEN, RED, PINK, GREY)
_STYLE = """
body { font: 15px/1.5 Helvetica, Arial, sans-serif; color: #1f2937; margin: 0; background: #fff; }
main { max-width: 1180px; margin: 0 auto; padding: 24px 28px 60px; }
h1 { font-size: 26px; margin: 0 0 2px; }
h2 { font-size: 20px; margin: 38px 0 6px; border-bottom: 2px solid #e5e7eb; padding-bottom: 4px; }
h3 { font-size: 16px; margin: 26px 0 4px; }
.meta, .note { color: #6b7280; font-size: 13px; }
table { border-collapse: collapse; margin: 8px 0 4px; font-size: 14px; }
th, td { text-align: left; padding: 4px 16px 4px 0; border-bottom: 1px solid #e5e7eb; }
th { color: #4b5563; font-weight: 600; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
.met { color: #15803d; } .missed { color: #b91c1c; font-weight: 600; }
@media print { .js-plotly-plot { break-inside: avoid; } }
"""


@dataclass(frozen=True)
class Check:
    """One figure against its reference.

    Attributes
    ----------
    tolerance : largest distance that counts as met, in ``unit``
    sense : ``within`` the tolerance, or only ``above`` or ``below`` the reference
    """

    what: str
    reference: float
    value: float
    tolerance: float
    unit: str
    sense: str = "within"

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
class Table:
    """Rows of cells under a head; numbers are set right."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str | float, ...], ...]
    note: str = ""


@dataclass(frozen=True)
class Figure:
    """A plot with what it shows."""

    title: str
    plot: go.Figure
    text: str


@dataclass
class Chapter:
    """A chapter of the report, in the order text, parts."""

    title: str
    text: str
    parts: list[Figure | Table] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)


def make_page(chapters: Sequence[Chapter], seconds: float) -> str:
    """HTML of the whole report."""
    body = [
        "<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'>",
        f"<title>Chapters 3, 5 and 6 reproduced</title><style>{_STYLE}</style>",
        f"<script>{plotly.offline.get_plotlyjs()}</script></head><body><main>",
        "<h1>Chapters 3, 5 and 6 reproduced</h1>",
        f"<div class='meta'>swaywatch {html.escape(__version__)}. Simulated drives, read by the C "
        f"core; made in {seconds:.0f} s. Reference: N. Zhang, Stability Investigation of "
        "Car-trailer Combinations based on Time-Frequency Analysis, TU Darmstadt 2015.</div>",
        "<h2>Against the reference</h2>",
        _checks([check for chapter in chapters for check in chapter.checks]),
    ]
    for chapter in chapters:
        body += [f"<h2>{html.escape(chapter.title)}</h2>", f"<p>{html.escape(chapter.text)}</p>"]
        for part in chapter.parts:
            body.append(_table(part) if isinstance(part, Table) else _figure(part))
    body.append("</main></body></html>")
    return "\n".join(body)


def _checks(checks: Sequence[Check]) -> str:
    rows = "".join(
        f"<tr><td>{html.escape(check.what)}</td><td class='number'>{_number(check.reference)}</td>"
        f"<td class='number'>{_number(check.value)}</td>"
        f"<td class='number'>{_allowed(check)}</td>"
        f"<td>{html.escape(check.unit)}</td>"
        f"<td class='{'met' if check.met else 'missed'}'>{'met' if check.met else 'missed'}</td>"
        "</tr>"
        for check in checks
    )
    head = "<tr><th></th><th>reference</th><th>here</th><th>within</th><th>unit</th><th></th></tr>"
    return f"<table>{head}{rows}</table>"


def _allowed(check: Check) -> str:
    return f"&plusmn; {_number(check.tolerance)}" if check.sense == "within" else check.sense


def _table(table: Table) -> str:
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
    return f"<h3>{html.escape(table.title)}</h3><table><tr>{head}</tr>{rows}</table>{note}"


def _figure(figure: Figure) -> str:
    plot = plotly.offline.plot(
        figure.plot, include_plotlyjs=False, output_type="div",
        config={"displaylogo": False, "responsive": True},
    )  # fmt: skip
    return (
        f"<h3>{html.escape(figure.title)}</h3>{plot}"
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


def styled(plot: go.Figure, height: int = 460) -> go.Figure:
    """Common look: white, units on the axes, legend above."""
    plot.update_layout(
        template="plotly_white",
        height=height,
        margin={"l": 78, "r": 24, "t": 34, "b": 52},
        font={"family": "Helvetica, Arial, sans-serif", "size": 13, "color": "#1f2937"},
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0.0},
    )
    axis = {"showline": True, "linecolor": "#9ca3af", "ticks": "outside", "zeroline": False}
    plot.update_xaxes(**axis)
    plot.update_yaxes(**axis)
    return plot
