"""A small warning campaign; `make bench-warning` is the whole one."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "bench"))

import warning_campaign as warning


def test_campaign() -> None:
    results = warning.campaign(drives=24, hours=0.5, first_seed=1001)
    figures = warning.summary(results)
    ours = figures["detectors"]["swaywatch"]
    assert figures["unstable_drives"] >= 10
    assert ours["false_ordinary"] == 0
    assert ours["missed"] <= 1
    assert ours["median_oscillations"] < 1.5
    others = [row for name, row in figures["detectors"].items() if name != "swaywatch"]
    assert all(ours["false_in_stable_drives"] <= row["false_in_stable_drives"] for row in others)
