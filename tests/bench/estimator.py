"""Accuracy of the estimator against the Cramer-Rao bound and against other methods.

    estimator.py LIBRARY [--quick] [--report FILE]

Seeds are fixed. Prints the tables in Markdown; exit status 1 where a goal is missed.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # small matrices: one core each
    os.environ.setdefault(threads, "1")

from estimator_accuracy import (  # noqa: E402
    CYCLES,
    SNR_DB,
    accuracy,
    dynamic_range,
    equation_4_3,
    joint,
    noise_free,
)
from estimator_core import Core  # noqa: E402
from estimator_disturbed import disturbances  # noqa: E402
from estimator_report import Report  # noqa: E402


def drift(report: Report, said: str) -> None:
    """The sentence of tests/proofs/fast_forward.c."""
    found = re.match(r"after (\d+) rows in each of \d+ channels the .* equal", said)
    report.goal("rows after which the sliding sums are fresh", int(found[1]) if found else 0,
                float("inf"), 1e9)  # fmt: skip
    report.show("sliding sums after 1e9 samples per channel", "equal fresh ones bit for bit", said)


def main() -> int:
    """Runs the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("library", type=Path)
    parser.add_argument("--quick", action="store_true", help="a subset, in some seconds")
    parser.add_argument("--report", type=Path, help="write the tables to this file")
    parser.add_argument("--drift", type=Path, help="what fast_forward said")
    options = parser.parse_args()
    core, report = Core(options.library), Report()
    cells = [(cycles, snr) for snr in SNR_DB for cycles in CYCLES]
    if options.quick:
        cells = [(1.6, 40), (2.0, 20), (2.0, 60), (3.0, 40)]
    accuracy(core, report, 400 if options.quick else 1000, 0 if options.quick else 100, cells)
    joint(core, report, 300 if options.quick else 500, cells)
    noise_free(core, report, 4 if options.quick else 32)
    equation_4_3(core, report)
    disturbances(core, report, 4 if options.quick else 40)
    dynamic_range(core, report, 100 if options.quick else 500)
    if options.drift:
        drift(report, options.drift.read_text(encoding="utf-8").strip())
    for line in report.missed:
        print(f"- missed: {line}")
    print(report.verdict())
    if options.report:
        options.report.write_text(report.text(), encoding="utf-8")
    return 1 if report.missed else 0


if __name__ == "__main__":
    sys.exit(main())
