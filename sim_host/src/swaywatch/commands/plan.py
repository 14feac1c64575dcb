"""``swaywatch plan``: plan a test: manoeuvres, speeds and sensors."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from swaywatch.commands._options import add_files
from swaywatch.errors import SwaywatchError
from swaywatch.recording.guard import whole_file
from swaywatch.terminal import output

HAS_JSON = True


def add_parser(subparsers: Any) -> None:
    """Add the ``plan`` command."""
    parser = subparsers.add_parser(
        "plan",
        help="plan a test: manoeuvres, speeds and sensors",
        description="Choose the manoeuvres and speeds that give the smallest errors, at a safe "
        "distance from the combination's expected critical speed: the remaining errors, the gain "
        "from other sensors, the time a plain slalom would take; a scenario for `simulate` and a "
        "steering robot's CSV.",
    )
    add_files(parser, signals=False)
    parser.add_argument(
        "--sensors", choices=("own", "articulation", "trailer", "forces"), default="own",
        help="sensors beside steering-wheel angle and speed; own: yaw rate and lateral "
        "acceleration of the car; articulation: own and the articulation angle; trailer: own, and "
        "yaw rate and lateral acceleration of the trailer; forces: those of trailer, and lateral "
        "wheel forces of the car and lateral hitch force (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--goal", choices=("critical-speed", "parameters"), default="critical-speed",
        help="quantity to determine (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--error", type=float, metavar="X",
        help="standard error to reach: km/h of the critical speed (default: 1), or %% of the worst "
        "of the vehicle's values (default: 2.5)",
    )  # fmt: skip
    parser.add_argument(
        "--preset", choices=("iso9815", "j2664"),
        help="instead of an optimised choice: impulses at five speeds (ISO 9815), or pulses up to "
            "100 km/h as "
        "in SAE J2664",
    )  # fmt: skip
    parser.add_argument(
        "--fastest", type=float, default=110.0, metavar="KMH",
        help="limit set by road and tyres (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--acceleration", type=float, default=3.0, metavar="M_S2",
        help="largest lateral acceleration of car and trailer (default: %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=Path, default=Path("swaywatch-plan"), metavar="DIR",
        help="folder for plan.html, plan.json, plan.toml and robot.csv (default: %(default)s)",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Plan, write, say."""
    from swaywatch.plan import files, page
    from swaywatch.plan.design import make_design
    from swaywatch.plan.knowledge import known_of
    from swaywatch.terminal.progress import LateProgress
    from swaywatch.vehicle_file import load_vehicle

    error = args.error if args.error is not None else {"critical-speed": 1.0}.get(args.goal, 2.5)
    for name, value, low, high in (
        ("--error", error, 0.01, 100.0), ("--fastest", args.fastest, 40.0, 250.0),
        ("--acceleration", args.acceleration, 0.3, 6.0),
    ):  # fmt: skip
        if not low <= value <= high:
            raise SwaywatchError(f"{name} {value:g}: expected {low:g} to {high:g}")
    with LateProgress(Console(stderr=True)) as progress:
        progress.tell("planning", 0.0, 1.0)
        design = make_design(
            known_of(load_vehicle(args.vehicle)), args.sensors, goal=args.goal, error=error,
            fastest_kmh=args.fastest, acceleration_m_s2=args.acceleration, preset=args.preset,
        )  # fmt: skip
    if not design.blocks:
        raise SwaywatchError(
            f"{args.vehicle}: the values of the file are already accurate enough (--error "
            f"{error:g}); nothing "
            "to drive"
        )
    title = {"iso9815": "Test plan after ISO 9815", "j2664": "Test plan as in SAE J2664"}.get(
        args.preset or "", "Test plan"
    )
    content = page.as_json(design)
    output.folder(args.out)
    scenario = args.out / "plan.toml"
    texts = {
        scenario: files.scenario_text(design, args.vehicle, args.out),
        args.out / "plan.json": json.dumps(content, indent=1, allow_nan=False),
        args.out / "plan.html": page.make_page(design, {"vehicle": [args.vehicle]}, title),
    }
    for path, text in texts.items():
        _write(path, text)
    _write(args.out / "robot.csv", files.robot_text(scenario))
    output.result(args, content)
    console = Console(highlight=False)
    console.print(page.critical_words(design), style="bold", markup=False)
    for text in page.sentences(design):
        console.print(f"- {text}", markup=False)
    console.print(_table(page.BLOCK_HEADS, page.rows_of_blocks(design)))
    console.print(_table(page.UNKNOWN_HEADS, page.rows_of_unknowns(design)))
    for path in (*texts, args.out / "robot.csv"):
        console.print(str(path), style="bold" if path.suffix == ".html" else "", soft_wrap=True)
    return 0


def _write(path: Path, text: str) -> None:
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _table(heads: tuple[str, ...], rows: list[list[str]]) -> Table:
    found = Table(box=None, pad_edge=False)
    for head in heads:
        found.add_column(head)
    for row in rows:
        found.add_row(*row)
    return found
