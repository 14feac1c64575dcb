"""``swaywatch diagnose``: where simulation and recording differ, and what physics was left out."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from swaywatch.commands._options import add_files, add_simulation_signals
from swaywatch.terminal import output

HAS_JSON = True


def add_parser(subparsers: Any) -> None:
    """Add the ``diagnose`` command."""
    parser = subparsers.add_parser(
        "diagnose",
        help="find what physics a simulation lacks, or what is wrong with the measurement",
        description="Compare runs of a combination with a simulation, locate what differs, name "
        "the missing physics, fit it and test it on runs that were left out of the fit.",
    )
    add_files(parser, recording="runs of the same combination")
    parser.add_argument(
        "--simulation", nargs="*", type=Path, default=[],
        help="your own simulation of the runs, in their order, or one FMU, which is driven with "
        "the recorded steering and speed (default: our own model)",
    )  # fmt: skip
    add_simulation_signals(parser)
    parser.add_argument(
        "--physics", nargs="+", type=Path, default=[], metavar="FILE",
        help="effect files of your own, tried beside the library",
    )  # fmt: skip
    parser.add_argument(
        "--save-law",
        type=Path,
        metavar="FILE.py",
        help="write a law that no library effect explains as such an effect file",
    )
    parser.add_argument(
        "--out", type=Path, default=Path("swaywatch-diagnosis"), metavar="DIR",
        help="folder for report.html and diagnosis.json (default: %(default)s)",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Diagnose, write diagnosis.json and report.html, print the verdict."""
    from swaywatch.analysis import refuse_trailer_roles
    from swaywatch.diagnose.engine import diagnose, write
    from swaywatch.diagnose.report.labels import VERDICTS, what_is_left
    from swaywatch.discover.save import read_physics, save_law
    from swaywatch.terminal.progress import LateProgress
    from swaywatch.vehicle_file import load_vehicle

    refuse_trailer_roles(load_vehicle(args.vehicle), args.signals)
    output.folder(args.out)
    report = args.out / "report.html"
    with LateProgress() as progress:
        result = diagnose(
            args.recording, args.vehicle, args.signals, simulations=args.simulation,
            simulation_signals=args.simulation_signals,
            extra=read_physics(args.physics), report=report, progress=progress.stage,
        )  # fmt: skip
    write(result, args.out / "diagnosis.json")
    output.result(args, result)
    print(f"verdict: {result['verdict']}: {VERDICTS[result['verdict']][1]}")
    _print_findings(result)
    if args.save_law is not None and not save_law(result, args.save_law):
        print(f"  no law was found beyond the library: {args.save_law} is not written")
    for name, quantity in result.get("quantities", {}).items():
        interval = f"{quantity['low']:.3g} to {quantity['high']:.3g}"
        print(f"  {name}: {quantity['value']:.3g} ({interval})")
    for note in result["unexplained"]:
        print("  unexplained: " + what_is_left(note))
    for text in result.get("failed", []):
        print(f"swaywatch diagnose: {text}; the verdict stands without it", file=sys.stderr)
    return 0


def _print_findings(result: dict[str, Any]) -> None:
    """Effects and laws, how large they are, and how much better the simulation is with them."""
    from swaywatch.diagnose.report.labels import how_much, how_well, part
    from swaywatch.diagnose.report.sentences import sentence

    for effect in result["effects"]:
        place = part(effect["component"])
        print(f"  {effect['id']} at {place} (confidence {effect['confidence']:.2f})")
        print(f"    {sentence(effect, result.get('stability'))}")
        for text in how_much(effect):
            print(f"    {text}")
        if effect["equivalent_details"]:
            print("    cannot be distinguished from: " + ", ".join(effect["equivalent_details"]))
    if how_well(result):
        print(f"  {how_well(result)}")
    for law in result.get("discovered", []):
        print(f"  a law that is in no library: {law['text']}")
        if law["perhaps"]:
            print(f"    perhaps {law['perhaps']}")
