"""A diagnosis of two 40 s runs stays far below 2 GiB, measured in a process of its own."""

from __future__ import annotations

from pathlib import Path

from conftest import diagnose_alone, recordings

LIMIT_KIB = 2 * 1024 * 1024


def test_peak_memory(diagnosed_p08: Path) -> None:
    assert int((diagnosed_p08 / "peak_kib").read_text()) < LIMIT_KIB


def test_peak_memory_beside_a_simulation(tmp_path: Path) -> None:
    diagnose_alone(recordings("chrono", "practice_chrono"), tmp_path)
    assert int((tmp_path / "peak_kib").read_text()) < LIMIT_KIB
