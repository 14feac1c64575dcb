"""``swaywatch trailer``: what trailer is this, from the car's own sensors."""

from __future__ import annotations

import argparse
import dataclasses
import json
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from swaywatch import __version__
from swaywatch.commands._options import add_files
from swaywatch.drive import load_drives
from swaywatch.ecu.remembered import Remembered, last_of
from swaywatch.recording import read_recording
from swaywatch.recording.guard import whole_file
from swaywatch.terminal import output
from swaywatch.terminal.progress import LateProgress
from swaywatch.trailer import INTERVAL, TrailerResult, as_json, identify
from swaywatch.vehicle_file import load_vehicle

HAS_JSON = True
KMH = 3.6


def add_parser(subparsers: Any) -> None:
    """Add the ``trailer`` command."""
    parser = subparsers.add_parser(
        "trailer",
        help="identify the attached trailer: mass, length, inertia, stiffness from the car's own "
        "sensors",
        description="Identify the attached trailer from steering, speed, yaw rate and lateral "
        "acceleration of the car alone. [trailer] of the vehicle.toml may be complete, partly "
        "known (mass, hitch_to_axle) or absent. Several recordings of the same combination, best "
        "at different speeds, are taken together. Where an ECU was on the bus (message "
        "SwayTrailer), what it said of the trailer that it remembers is repeated.",
    )
    add_files(parser, recording="drives of the same combination")
    parser.add_argument("--out", type=Path, metavar="FILE", help="also write the result as JSON")


def run(args: argparse.Namespace) -> int:
    """Identify and print."""
    console = Console(highlight=False)
    vehicle = load_vehicle(args.vehicle)
    with LateProgress() as progress:
        progress.tell("reading", 0.0, 1.0)
        drives = load_drives(args.recording, args.signals, join=False)
        progress.tell("identifying the trailer", 0.0, 1.0)
        result = identify(drives, vehicle)
    remembered = {path: said for path in args.recording if (said := _said_by_ecu(path))}
    content = {
        "swaywatch": __version__,
        **as_json(result, args.recording),
        "remembered": {str(path): dataclasses.asdict(said) for path, said in remembered.items()},
    }
    output.result(args, content)
    for text in sentences(result):
        console.print(text, markup=False)
    for path, said in remembered.items():
        console.print(f"{path.name}: {said.sentence}", markup=False)
    if result.quantities:
        console.print(_table(result))
    for manoeuvre in result.manoeuvres[:3]:
        limit = manoeuvre.critical_speed_m_s
        shown = "-" if limit is None else f"{limit * KMH:.1f} km/h"
        console.print(
            f"30 s more of {manoeuvre.name}: critical speed to ± {shown}, mass to ± "
            f"{manoeuvre.mass_kg:.0f} kg (simulated)",
            markup=False,
        )
    if args.out is not None:
        with whole_file(args.out) as temporary:
            temporary.write_text(json.dumps(content, indent=1, allow_nan=False), encoding="utf-8")
        console.print(str(args.out), soft_wrap=True)
    return 0


def _said_by_ecu(path: Path) -> Remembered | None:
    """The last message SwayTrailer of a recording, where an ECU was on the bus."""
    frames = read_recording(path).frames
    return None if frames is None else last_of(frames)


def sentences(result: TrailerResult) -> list[str]:
    """Is it there, and how fast may it go."""
    sure = f"{min(100.0 * result.certainty, 99.9):.1f} % certain"
    after = f"after {result.learnt_s:.0f} s of driving"
    if result.presence == "none":
        return [f"No trailer is attached ({sure}, {after})."]
    found = {
        "there": f"A trailer is attached ({sure}, {after}).",
        "undecided": f"Whether a trailer is attached cannot be decided {after}: steer more.",
    }[result.presence]
    if result.critical_speed_m_s is None or result.critical_speed_error_m_s is None:
        return [found, "Its critical speed cannot be stated yet."]
    half = INTERVAL * result.critical_speed_error_m_s
    return [
        found,
        f"Critical speed {result.critical_speed_m_s * KMH:.1f} ± {half * KMH:.1f} km/h "
        "(90 % interval).",
    ]


def _table(result: TrailerResult) -> Table:
    table = Table(box=None, pad_edge=False)
    for heading in ("", "measured", "90 % interval", "vehicle.toml", "error reduced by", "unit"):
        table.add_column(heading, justify="left" if heading in ("", "unit") else "right")
    for quantity in result.quantities:
        digits = 2 if quantity.unit == "m" else 0
        believed = "-" if quantity.believed is None else f"{quantity.believed:.{digits}f}"
        table.add_row(
            quantity.name,
            f"{quantity.value:.{digits}f}",
            f"{quantity.low:.{digits}f} to {quantity.high:.{digits}f}",
            believed,
            f"{100 * quantity.gained:.0f} %",
            quantity.unit,
        )
    return table
