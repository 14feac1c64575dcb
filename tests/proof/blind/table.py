"""Tables of a scored blind set for the README: ``python table.py SCORE.json OUT.md``."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from score import interval

Json = dict[str, Any]

#: Rows of the summary: key of the score, words, what the issue asks for.
SUMMARY = (
    ("first", "one effect concealed, first name right", ""),
    ("set", "the same, or named as equivalent", ""),
    ("first_above_limit", "first name right above the limit of its own recordings", "95 %"),
    ("false_claims_on_clean", "claims where nothing is concealed", "at most 1 %"),
    ("pair_first", "two effects: the first is one of them", ""),
    ("pair_both", "two effects: both named", ""),
    ("pair_both_above_limit", "the same where both are above the limit", ""),
    ("outside", "cause outside the library: reported as unexplained", ""),
    ("fault_outside", "fault of a sensor that is on no list: recognised", ""),
    ("location", "place right, of correctly named effects", ""),
    ("windows_overlap_half", "windows overlap by at least half", ""),
    ("parameter_within_25_percent", "parameters within 25 %", ""),
    ("interval_coverage", "true value inside the 90 % intervals", "80-97 %"),
    ("held_out_improved", "prediction of a run that was left out is better", ""),
    ("held_out_windows_improved", "the same, effects in windows, where that run shows them", ""),
)
COLUMNS = (
    ("first", "first"), ("above_limit", "above the limit"), ("location", "place"),
    ("overlap_median", "overlap"), ("parameter_error_median", "parameter error"),
    ("coverage", "coverage"),
)  # fmt: skip


def cell(value: Any) -> str:
    """A share as right/of, a number with three digits."""
    if isinstance(value, dict):
        return f"{value['right']}/{value['of']}" if value["of"] else "-"
    if value is None:
        return "-"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def summary(total: Json) -> list[str]:
    """The figures of the whole set."""
    lines = ["| figure | reached | required |", "|---|---|---|"]
    for key, words, asked in SUMMARY:
        value = total[key]
        if value["of"]:
            lines.append(f"| {words} | {cell(value)} ({100.0 * value['share']:.0f} %) | {asked} |")
    if total.get("held_out_before_median") is not None:
        lines.append(
            "| NRMSE of the run left out (where a prediction is possible), median | "
            f"{total['held_out_before_median']:.3f} -> {total['held_out_after_median']:.3f} | |"
        )
    for row in total["by_limit"]:
        lines.append(
            f"| one effect that leaves {interval(row)} standard deviations beside the best wrong "
            f"one | {cell(row)} | |"
        )
    for row in total["calibration"]:
        lines.append(
            f"| stated confidence {row['from']:.2f} to {row['to']:.2f}, mean {row['stated']:.2f} "
            f"| right {cell(row)} | |"
        )
    if total["seconds_median"] is not None:
        lines.append(
            f"| seconds per case on a shared machine: median, most | {total['seconds_median']:.0f},"
            f" {total['seconds_max']:.0f} | 60 on an idle machine |"
        )
    return lines


def effects(total: Json) -> list[str]:
    """One row per effect: named of all, named of those above the limit."""
    heads = ["effect", *(head for _, head in COLUMNS)]
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for label, figures in total["effects"].items():
        cells = [label, *(cell(figures[key]) for key, _ in COLUMNS)]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def missed(total: Json) -> list[str]:
    """What was not named although it is above the limit."""
    if not total["missed_above_limit"]:
        return []
    lines = ["", "Above the limit and not named:", "",
             "| case | tier | concealed | standard deviations left | beside | said |",
             "|---|---|---|---|---|---|"]  # fmt: skip
    for row in total["missed_above_limit"]:
        left = " + ".join(f"{value:.0f}" for value in row["left"])
        lines.append(
            f"| {row['case']} | {row['tier']} | {' + '.join(row['ids'])} | {left} | "
            f"{' + '.join(row['best_wrong'])} | {row['said']} |"
        )
    return lines


def page(score: Json, seed: str) -> str:
    """Markdown: the whole set first, then each effect."""
    total = score["summary"]
    lines = [
        f"**`make proof-blind`, seed {seed}, {total['cases']} cases of the rigid-body plant**", "",
        *summary(total), "", "### By effect", "",
        "Right of all; right of those above the limit of their recordings (README of the proof).",
        "", *effects(total), *missed(total),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("score", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", default="?")
    given = parser.parse_args()
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(page(json.loads(given.score.read_text()), given.seed))


if __name__ == "__main__":
    main()
