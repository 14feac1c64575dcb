"""A diagnosis of two 40 s runs stays far below 2 GiB, measured in a process of its own."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from conftest import recordings

LIMIT_KIB = 2 * 1024 * 1024
PROGRAM = """
import resource, sys
from pathlib import Path
from swaywatch.diagnose.engine import diagnose
case = Path(sys.argv[1])
diagnose(sorted(case.glob("run*.*")), case / "vehicle.toml", case / "signals.toml",
         simulations=sorted(case.glob("simulation_run*.*")))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.parametrize("parts", [("practice", "p08"), ("chrono", "practice_chrono")])
def test_peak_memory(parts: tuple[str, ...]) -> None:
    import subprocess

    case: Path = recordings(*parts)
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(case)], capture_output=True, text=True, check=True
    )
    assert int(done.stdout.split()[-1]) < LIMIT_KIB
