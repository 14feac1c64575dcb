"""What a diagnosis costs: the whole command on each case, one after the other.

Wall-clock seconds say something on a machine that does nothing else; processor seconds and peak
memory on any. Nothing is asserted.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

COMMITTED = Path(__file__).resolve().parents[1] / "data" / "practice"


@dataclass(frozen=True)
class Cost:
    """Of one diagnosis: seconds, and MiB at the peak."""

    name: str
    wall_s: float
    cpu_s: float
    peak_mib: float


def cases(recordings: Path | None) -> list[Path]:
    """Folders of cases: the committed ones, or every practice and Chrono case of `recordings`."""
    if recordings is None:
        return sorted(path.parent for path in COMMITTED.glob("*/vehicle.toml"))
    found = [*recordings.glob("practice/*/vehicle.toml"), *recordings.glob("chrono/*/vehicle.toml")]
    return sorted(path.parent for path in found)


def command(case: Path, out: Path) -> list[str]:
    """Command line of the diagnosis of one case."""
    line = [sys.executable, "-m", "swaywatch.cli", "diagnose"]
    line += map(str, sorted(case.glob("run*.*")))
    line += ["--vehicle", str(case / "vehicle.toml"), "--signals", str(case / "signals.toml")]
    simulations = sorted(case.glob("simulation_run*.*"))
    if simulations:
        line += ["--simulation", *map(str, simulations)]
    return [*line, "--out", str(out)]


def measure(case: Path) -> Cost:
    """Run it, start of Python and report included."""
    with tempfile.TemporaryDirectory() as out:
        start = time.monotonic()
        with subprocess.Popen(
            command(case, Path(out)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as process:
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        wall = time.monotonic() - start
    if process.returncode:
        sys.exit(f"{case}: exit code {process.returncode}")
    return Cost(case.name, wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0)


def table(costs: list[Cost]) -> str:
    """The median, and what was most, with the case it belongs to."""
    lines = [
        f"**`make bench-diagnosis`: {len(costs)} cases of two runs, whole command, "
        f"{os.cpu_count()} cores**", "",
        "| figure | median | most | required |", "|---|---|---|---|",
    ]  # fmt: skip
    for title, key, asked in (
        ("wall-clock seconds", "wall_s", "60"),
        ("processor seconds", "cpu_s", ""),
        ("peak memory, MiB", "peak_mib", "2048"),
    ):
        ranked = sorted(costs, key=lambda cost: getattr(cost, key))
        median, most = ranked[len(ranked) // 2], ranked[-1]
        lines.append(
            f"| {title} | {getattr(median, key):.0f} | {getattr(most, key):.0f} ({most.name}) "
            f"| {asked} |"
        )
    return "\n".join(lines) + "\n"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=Path, help="folder with practice/ and chrono/")
    parser.add_argument("--out", type=Path, required=True, help="table to write")
    given = parser.parse_args()
    costs = []
    for case in cases(given.recordings):
        cost = measure(case)
        costs.append(cost)
        print(
            f"{cost.name}: {cost.wall_s:.1f} s, {cost.cpu_s:.1f} s of a core, "
            f"{cost.peak_mib:.0f} MiB",
            flush=True,
        )
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(table(costs))


if __name__ == "__main__":
    main()
