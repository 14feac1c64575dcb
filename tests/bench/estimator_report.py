"""What the estimator's benchmark says: tables in Markdown, and goals that are met or missed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


def number(value: float) -> str:
    """Three figures, or a dash."""
    return "-" if np.isnan(value) else f"{value:.3g}" if value >= 10 else f"{value:.2f}"


def table(head: list[str], rows: list[list[str]]) -> list[str]:
    """Lines of a table in Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return [*lines, *("| " + " | ".join(row) + " |" for row in rows)]


@dataclass
class Report:
    """Lines of Markdown, the summary that goes before them, and whether every goal was met."""

    lines: list[str] = field(default_factory=list)
    missed: list[str] = field(default_factory=list)
    shown: list[list[str]] = field(default_factory=list)
    by_cycles: list[str] = field(default_factory=list)
    _worst: dict[str, tuple[float, str]] = field(default_factory=dict)

    def say(self, text: str = "") -> None:
        """One line."""
        print(text, flush=True)
        self.lines.append(text)

    def table(self, head: list[str], rows: list[list[str]]) -> None:
        """A table and an empty line."""
        for line in [*table(head, rows), ""]:
            self.say(line)

    def goal(self, name: str, value: float, limit: float, low: float = -np.inf) -> None:
        """A goal: `value` from `low` to `limit`; not a number is a miss."""
        if not low <= value <= limit:
            self.missed.append(f"{name}: {value:.4g}, required {low:.4g} to {limit:.4g}")

    def show(self, what: str, wanted: str, seen: str) -> None:
        """A line of the summary."""
        self.shown.append([what, wanted, seen])

    def verdict(self) -> str:
        """The last line."""
        return "every goal met" if not self.missed else f"{len(self.missed)} goals missed"

    def text(self) -> str:
        """The whole report; the part for the README is its first section."""
        head = ["**`make bench-estimator`**: " + self.verdict(), ""]
        if self.by_cycles:
            head += [*self.by_cycles, ""]
        if self.shown:
            head += [*table(["what", "required", "measured"], self.shown), ""]
        missed = [f"- missed: {line}" for line in self.missed]
        return "\n".join([*head, *missed, "", *self.lines]) + "\n"
