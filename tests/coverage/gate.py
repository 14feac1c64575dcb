"""Gate of the coverage of lib/: every line and every branch is run, but for those that are allowed.

`gate.py GCOVR_JSON ALLOWED` compares gcovr's report with ``ALLOWED``, a line each as
``FILE: SOURCE LINE # reason``. A line of the list that is run whole, or is not there any more,
fails like one that is missing in it: the list can only shrink. ``FILE: *`` is all of a file.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path


def gaps(report: dict, root: Path) -> tuple[dict[str, str], int, int]:
    """What is not run, as the list has it, with what is missing; counts of lines and branches."""
    found: dict[str, str] = {}
    lines = branches = 0
    for entry in report["files"]:
        source = (root / entry["file"]).read_text().splitlines()
        for line in entry["lines"]:
            if line.get("gcovr/noncode"):
                continue
            counts = [branch["count"] for branch in line["branches"]]
            lines += 1
            branches += len(counts)
            number = line["line_number"]
            if line["count"] == 0 or 0 in counts:
                what = (
                    "line" if line["count"] == 0 else f"{counts.count(0)} of {len(counts)} branches"
                )
                found[f"{entry['file']}: {source[number - 1].strip()}"] = f"line {number}: {what}"
    return found, lines, branches


def main(report_path: Path, allowed_path: Path) -> int:
    """Compare; say what does not agree."""
    report = json.loads(report_path.read_text())
    found, lines, branches = gaps(report, Path.cwd())
    allowed = {
        line.split(" # ")[0] for line in allowed_path.read_text().splitlines() if " # " in line
    }
    whole = {name[: -len(": *")] for name in allowed if name.endswith(": *")}
    inside = {name for name in found if name.split(": ")[0] in whole}
    allowed -= {f"{name}: *" for name in whole & {gap.split(": ")[0] for gap in inside}}
    allowed |= inside
    for name in sorted(set(found) - allowed):
        print(f"coverage: not run: {name} ({found[name]})")
    for name in sorted(allowed - set(found)):
        print(f"coverage: {allowed_path}: run, or not there: {name}")
    if set(found) == allowed:
        print(f"coverage of lib/: {lines} lines, {branches} branches, all run but {len(allowed)}")
        return 0
    return 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
