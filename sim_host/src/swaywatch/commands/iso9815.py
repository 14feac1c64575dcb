"""``swaywatch iso9815``: ``damping`` with the profile of ISO 9815, for a car with a trailer."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from rich.console import Console

from swaywatch.commands._options import add_files
from swaywatch.commands.damping import say, write
from swaywatch.damping.data import Choice
from swaywatch.damping.study import StudyPlan, evaluate
from swaywatch.terminal.progress import LateProgress

HAS_JSON = True


def add_parser(subparsers: Any) -> None:
    """Add the ``iso9815`` command."""
    parser = subparsers.add_parser(
        "iso9815",
        help="damping of a car with a trailer against speed; zero-damping speed",
        description="Evaluate the free oscillations of several runs of a car with a trailer after "
        "ISO 9815, as `damping` does: damping ratio against speed, zero-damping speed and the "
        "speed of damping ratio 0.05, with 95 % intervals that are valid beyond the speeds "
        "driven; the standard's straight line (Eq. 3.43 of the reference) beside it.",
    )
    add_files(parser, recording="runs of the same combination", vehicle=False)
    parser.add_argument(
        "--out", type=Path, default=Path("swaywatch-iso9815"), metavar="DIR",
        help="folder for iso9815.html and iso9815.json (default: %(default)s)",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Evaluate, write the files, print the summary."""
    plan = StudyPlan(Choice(signals=args.signals), iso9815=True)
    with LateProgress(Console(stderr=True)) as progress:
        study = evaluate(args.recording, plan, progress=progress.tell)
        sources = {"recording": args.recording, "signals": [args.signals]}
        written = write(study, sources, args.out, "iso9815")
    say(args, study, written)
    return 0
