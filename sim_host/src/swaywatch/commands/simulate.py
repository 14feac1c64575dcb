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
        "--drives",
        type=int,
        metavar="N",
        help="a campaign: N drives with seeds that count up and the values of [[vary]], on all "
        "cores; --out is then a folder, which also gets drives.csv",
    )
    parser.add_argument(
        "--format",
        default=".blf",
        choices=FRAME_SUFFIXES,
        help="format of a campaign's recordings (default: .blf)",
    )
    parser.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="number of processes of a campaign (default: one for each processor core)",
    )
    parser.add_argument(
        "--signals",
        type=Path,
        metavar="TOML",
        help="also write the signals.toml with which `swaywatch analyze` reads the recording",
    )


def run(args: argparse.Namespace) -> int:
    """Simulate one scenario, or a campaign of it."""
    return _one(args) if args.drives is None else _campaign(args)


def _campaign(args: argparse.Namespace) -> int:
    from swaywatch.errors import ScenarioError
    from swaywatch.simulate.campaign import jobs_of, run_campaign, write_table
    from swaywatch.terminal.progress import LateProgress

    if args.signals is not None:
        raise ScenarioError("--signals goes with a single drive; write it once without --drives")
    seed = 1 if args.seed is None else args.seed
    jobs = jobs_of(args.scenario, args.drives, args.out, args.format, seed)
    try:
        args.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ScenarioError(f"{args.out}: cannot be made: {error.strerror}") from None
    with LateProgress() as progress:
        outcomes = run_campaign(
            jobs, args.workers, lambda done: progress.tell("simulating", done, len(jobs))
        )
    write_table(args.out / "drives.csv", outcomes)
    left = sum(not outcome.whole for outcome in outcomes)
    end = f"; {left} left all bounds and end early" if left else ""
    print(f"{args.out}: {len(outcomes)} drives{end}; drives.csv lists them")
    return 0


def _one(args: argparse.Namespace) -> int:
    from swaywatch.ecu.bus import encode_drive
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
