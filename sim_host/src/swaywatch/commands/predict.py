"""``swaywatch predict``: a diagnosed model on the inputs of another run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any


def add_parser(subparsers: Any) -> None:
    """Add the ``predict`` command."""
    parser = subparsers.add_parser(
        "predict",
        help="run a diagnosed model on another run and score it",
        description="Drive the baseline and the diagnosed model with the steering and speed of a "
        "run and score both against what was recorded.",
    )
    parser.add_argument("--model", required=True, type=Path, help="diagnosis.json")
    parser.add_argument("--recording", required=True, type=Path, help="the run to predict")
    parser.add_argument(
        "--signals", type=Path, default=None,
        help="signals.toml of the run (default: the one of the diagnosis)",
    )  # fmt: skip
    parser.add_argument("--out", required=True, type=Path, help="JSON file for the scores")


def run(args: argparse.Namespace) -> int:
    """Predict, write the scores, print them."""
    from swaywatch.diagnose.engine import write
    from swaywatch.diagnose.predict import predict

    result = predict(args.model, args.recording, args.signals)
    args.out.parent.mkdir(parents=True, exist_ok=True)
    write(result, args.out)
    print(
        f"NRMSE baseline {result['baseline_nrmse']:.3f}, "
        f"diagnosed {result['diagnosed_nrmse']:.3f}; "
        f"ISO/TS 18571 {result['baseline_iso18571']:.3f} to {result['diagnosed_iso18571']:.3f}"
    )
    return 0
