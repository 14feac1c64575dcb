"""The end of a benchmark: its table as a file and on the screen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


def written(lines: Sequence[str], path: Path) -> int:
    """Write a report, show it; 0 for the shell."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    print(path.read_text(encoding="utf-8"))
    return 0
