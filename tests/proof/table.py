"""Table of the verdicts for the README: ``python table.py RECORDINGS VERDICTS OUT.md``.

Truth is read only where the recordings bring it with them (the practice cases).
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from pathlib import Path
from typing import Any

Json = dict[str, Any]
GROUPS = ("practice", "sealed", "chrono")


def verdicts(folder: Path, group: str) -> dict[str, Json]:
    """By case name."""
    return {p.stem: json.loads(p.read_text()) for p in sorted((folder / group).glob("*.json"))}


def claim(effect: Json) -> str:
    """Name, place, values and confidence of an effect."""
    values = []
    for name, said in effect["parameters"].items():
        each = said.get("per_window") or [said["value"]]
        values.append(f"{name} {', '.join(f'{value:.4g}' for value in each)}")
    place = f" ({effect['component']})" if effect["component"] else ""
    return f"{effect['id']}{place}: {'; '.join(values)} [{effect['confidence']:.2f}]"


def concealed(effect: Json) -> str:
    """An effect as truth.json tells it."""
    rest = ", ".join(f"{k} {v}" for k, v in effect.items() if k not in ("id", "windows"))
    return f"{effect['id']}: {rest}"


def known(recordings: Path, group: str, found: dict[str, Json]) -> list[str]:
    """Rows of the cases whose true values are published."""
    lines = []
    for name, verdict in found.items():
        truth = recordings / group / name / "truth.json"
        if not truth.exists():
            continue
        effects = json.loads(truth.read_text())["effects"]
        true = "; ".join(concealed(e) for e in effects) or "nothing"
        said = "; ".join(claim(e) for e in verdict["effects"]) or verdict["verdict"]
        fit = verdict["effects"][0]["fit"] if verdict["effects"] else {}
        before, after = fit.get("held_out_baseline_nrmse"), fit.get("held_out_diagnosed_nrmse")
        held = f"{before:.3f} -> {after:.3f}" if before is not None and after is not None else "-"
        lines.append(f"| {name} | {true} | {said} | {held} |")
    return lines


def page(recordings: Path, folder: Path) -> str:
    """Practice in full, the others counted by verdict."""
    lines = [
        "**`make proof`: practice cases, whose true values are published**", "",
        "| case | concealed | diagnosis [confidence] | NRMSE of the run left out |",
        "|---|---|---|---|",
    ]  # fmt: skip
    for group in GROUPS:
        lines += known(recordings, group, verdicts(folder, group))
    lines += ["", "### Verdicts by kind", "", "| group | cases | verdicts |", "|---|---|---|"]
    for group in GROUPS:
        words = Counter(v["verdict"] for v in verdicts(folder, group).values())
        text = ", ".join(f"{count} {word}" for word, count in sorted(words.items()))
        lines.append(f"| {group} | {sum(words.values())} | {text} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recordings", type=Path)
    parser.add_argument("verdicts", type=Path)
    parser.add_argument("out", type=Path)
    given = parser.parse_args()
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(page(given.recordings, given.verdicts))


if __name__ == "__main__":
    main()
