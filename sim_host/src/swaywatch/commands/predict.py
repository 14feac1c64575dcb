"""``swaywatch predict``: a diagnosed model on the inputs of another run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from swaywatch.commands._options import add_simulation_signals
from swaywatch.terminal import output

HAS_JSON = True


def add_parser(subparsers: Any) -> None:
    """Add the ``predict`` command."""
    parser = subparsers.add_parser(
        "predict",
        help="run a diagnosed model on another run and score it",
        description="Drive the baseline and the diagnosed model with the steering and speed of a "
        "run and score both against the recording.",
    )
    parser.add_argument("--model", required=True, type=Path, metavar="JSON",
                        help="diagnosis.json that `swaywatch diagnose` wrote")  # fmt: skip
    parser.add_argument("--recording", required=True, type=Path, metavar="FILE",
                        help="the run to predict")  # fmt: skip
    parser.add_argument(
        "--signals", type=Path, default=None, metavar="TOML",
        help="signals.toml of the run (default: the one beside the recording, else the one "
        "that is kept in the model)",
    )  # fmt: skip
    parser.add_argument(
        "--simulation", type=Path, default=None, metavar="FILE",
        help="your own simulation of this run, or an FMU; the diagnosed physics is a correction "
        "to it",
    )  # fmt: skip
    add_simulation_signals(parser)
    parser.add_argument("--out", required=True, type=Path, metavar="JSON",
                        help="file for the scores")  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Predict, write the scores, print them."""
    from swaywatch.diagnose.engine import write
    from swaywatch.diagnose.predict import predict

    result = predict(
        args.model, args.recording, args.signals, args.simulation, args.simulation_signals
    )
    output.folder(args.out.parent)
    write(result, args.out)
    output.result(args, result)
    print(f"roles: {result['signals']}")
    written = result.get("as_written_nrmse")
    first = "" if written is None else f"vehicle.toml as written {written:.3f}, "
    print(
        f"NRMSE {first}baseline {result['baseline_nrmse']:.3f}, "
        f"diagnosed {result['diagnosed_nrmse']:.3f}"
    )
    if result["baseline_iso18571"] is not None:
        print(
            f"ISO/TS 18571 baseline {result['baseline_iso18571']:.3f}, "
            f"diagnosed {result['diagnosed_iso18571']:.3f}"
        )
    if "diagnosed_with_windows_nrmse" in result:
        times = ", ".join(f"{w['start']:.1f}-{w['stop']:.1f} s" for w in result["windows_found"])
        print(
            f"with windows found in the run ({times or 'none'}): "
            f"NRMSE {result['diagnosed_with_windows_nrmse']:.3f}"
        )
    for note in result["notes"]:
        print(f"note: {note}")
    return 0
