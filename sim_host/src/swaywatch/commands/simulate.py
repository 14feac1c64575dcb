"""``swaywatch simulate``: a scenario becomes a recording."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from swaywatch.recording import FRAME_SUFFIXES


def add_parser(subparsers: Any) -> None:
    """Add the ``simulate`` command."""
    parser = subparsers.add_parser(
        "simulate",
        help="simulate a scenario and write it as a recording",
        description="Simulate a scenario (TOML: vehicle, manoeuvres, physics, driver, sensors, "
        "message timing; see swaywatch.simulate.scenario) and write what a logger on the bus of "
        "dbc/swaywatch.dbc would have recorded. The same scenario and seed give the same file.",
    )
    parser.add_argument("scenario", type=Path, help="the scenario, TOML")
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="FILE",
        help=f"the recording to write: {', '.join(FRAME_SUFFIXES)} (.log is candump)",
    )
    parser.add_argument("--seed", type=int, metavar="N", help="instead of the scenario's seed")
    parser.add_argument(
        "--signals",
        type=Path,
        metavar="TOML",
        help="also write the signals.toml with which `swaywatch analyze` reads the recording",
    )


def run(args: argparse.Namespace) -> int:
    """Simulate one scenario."""
    from swaywatch.bus import encode_drive
    from swaywatch.recording import write_recording
    from swaywatch.simulate import load_scenario, simulate_scenario
    from swaywatch.simulate.signals import write_signals

    scenario = load_scenario(args.scenario, args.seed)
    drive, trace = simulate_scenario(scenario)
    frames = encode_drive(drive)
    write_recording(args.out, frames)
    if args.signals is not None:
        write_signals(args.signals, drive)
    end = "" if trace.whole else f"; out of bounds after {drive.duration_s:.2f} s"
    print(f"{args.out}: {drive.duration_s:.1f} s, {len(frames)} frames{end}")
    return 0
