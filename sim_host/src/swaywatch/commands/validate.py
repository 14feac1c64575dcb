"""``swaywatch validate``: comparison of a simulation with recordings, and its corrections."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from swaywatch.commands._options import add_files, add_simulation_signals
from swaywatch.recording.guard import whole_file
from swaywatch.terminal.progress import LateProgress
from swaywatch.validate.correct import write
from swaywatch.validate.loop import ROUNDS, validate
from swaywatch.validate.page import as_json, make_page, rows, sentences


def add_parser(subparsers: Any) -> None:
    """Add the ``validate`` command."""
    parser = subparsers.add_parser(
        "validate",
        help="compare a simulation with recordings value by value, correct the vehicle",
        description="Evaluate recording and simulation with the same core and compare frequency, "
        "damping, stiffness of each axle with its argument, loads, inertias and critical speed; "
        "they have to agree within 5 %. Our own simulation is driven with the recorded steering "
        "and speed, corrected and run again until they agree.",
    )
    add_files(parser, recording="measured drives of the combination")
    parser.add_argument(
        "--simulation", type=Path, nargs="+", default=[], metavar="FILE",
        help="your own simulation of each recording, in the same order, or one FMU, instead of "
        "ours",
    )  # fmt: skip
    add_simulation_signals(parser)
    parser.add_argument(
        "--write", type=Path, metavar="TOML", help="write the corrected vehicle.toml there"
    )
    parser.add_argument(
        "--rounds", type=int, default=ROUNDS, choices=range(1, 21), metavar="N",
        help="most rounds of simulating and correcting (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=Path, default=Path("swaywatch-validation"), metavar="DIR",
        help="folder for validation.html and validation.json (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--ignore-quality", action="store_true",
        help="validate even if a sign, a unit or a clock is wrong",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Validate, write the files, print the comparison. Exit code 0: done, whatever came out."""
    console = Console(highlight=False)
    with LateProgress(Console(stderr=True)) as progress:
        found = validate(
            args.recording, args.vehicle, args.signals,
            simulations=args.simulation, simulation_signals=args.simulation_signals,
            rounds=args.rounds, strict=not args.ignore_quality, progress=progress.tell,
        )  # fmt: skip
    sources = {
        "recording": args.recording, "simulation": args.simulation,
        "vehicle": [args.vehicle], "signals": [args.signals],
    }  # fmt: skip
    written = []
    for name, text in (
        ("validation.json", json.dumps(as_json(found), indent=1, allow_nan=False)),
        ("validation.html", make_page(found, {k: v for k, v in sources.items() if v})),
    ):
        path = args.out / name
        with whole_file(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
        written.append(path)
    if args.write:
        first, last = found.rounds[0].vehicle, found.rounds[-1].vehicle
        names = ", ".join(path.name for path in args.recording)
        write(last, first, f"corrected by swaywatch validate from {names}", args.write)
        written.append(args.write)
    for text in sentences(found):
        console.print(text, markup=False, soft_wrap=True)
    for result, lines in zip(found.recordings, found.rounds[-1].lines, strict=True):
        console.print(_table(result.drive.name, rows(lines)))
    for path in written:
        console.print(str(path), soft_wrap=True)
    return 0


def _table(name: str, body: list[list[str]]) -> Table:
    table = Table(title=name, title_justify="left", box=None, pad_edge=False)
    for heading in ("", "recording", "simulation", "difference", "criterion", "unit"):
        right = heading in ("recording", "simulation", "difference")
        table.add_column(heading, justify="right" if right else "left")
    for row in body:
        table.add_row(*row)
    return table
