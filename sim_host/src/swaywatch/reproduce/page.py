"""The report of ``swaywatch reproduce`` as one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import plotly.graph_objects as go

from swaywatch.report.shell import PackedPlot, document, plot

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
    cause : why it is missed, if it is, from a computed experiment
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

    def cells(self) -> list[list[tuple[str, bool]]]:
        """Of each row: words, and whether they are a number."""
        return [
            [(_number(cell), True) if isinstance(cell, float) else (cell, False) for cell in row]
            for row in self.rows
        ]


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
    """HTML of the report."""
    meta = (
        f"Simulated drives, evaluated by the C core; made in {seconds:.0f} s. Reference: N. Zhang, "
        "Stability Investigation of Car-trailer Combinations based on Time-Frequency Analysis, "
        "TU Darmstadt 2015"
    )
    checks = [check for chapter in chapters for check in chapter.checks]
    return document(
        "reproduce/page.html",
        "Dissertation reproduced: chapters 3, 5 and 6",
        meta=meta,
        verdict=_verdict(checks),
        checks=[_checked(check) for check in checks],
        chapters=[
            (chapter, [(part, _packed(part)) for part in chapter.parts]) for chapter in chapters
        ],
    )


def _verdict(checks: Sequence[Check]) -> dict[str, object]:
    """How many figures meet the reference, and which do not."""
    missed = [check.what for check in checks if not check.met]
    unexplained = [check.what for check in checks if not check.met and not check.cause]
    reasons = []
    if missed:
        reasons.append(f"Missed: {'; '.join(missed)}.")
        reasons.append(
            f"Without a known cause: {'; '.join(unexplained)}."
            if unexplained
            else "Each miss has a cause that was computed (last column of the table)."
        )
    sentence = f"{len(checks) - len(missed)} of {len(checks)} figures meet the reference"
    return {
        "kind": "bad" if unexplained else "near" if missed else "good",
        "sentence": f"{sentence}, {len(missed)} miss it." if missed else f"{sentence}.",
        "reasons": reasons,
    }


def _packed(part: Plot | PageTable) -> PackedPlot | None:
    return plot(part.plot, name=part.title) if isinstance(part, Plot) else None


def _checked(check: Check) -> dict[str, str]:
    """A figure against its reference, in words."""
    within = f"± {_number(check.tolerance)}" if check.sense == "within" else check.sense
    return {
        "what": check.what, "reference": _number(check.reference), "here": _number(check.value),
        "within": within, "unit": check.unit,
        "difference": _number(check.value - check.reference),
        "outcome": "met" if check.met else "missed", "cause": "" if check.met else check.cause,
    }  # fmt: skip


def _number(value: float) -> str:
    if value != value:  # noqa: PLR0124
        return "–"
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
