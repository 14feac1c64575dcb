"""``swaywatch hil``: a scenario in real time on a bus, closed by the ECU that listens there."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from swaywatch.commands._options import add_bus
from swaywatch.terminal import output

HAS_JSON = True


def add_parser(subparsers: Any) -> None:
    """Add the ``hil`` command."""
    parser = subparsers.add_parser(
        "hil",
        help="hardware in the loop: drive a scenario in real time, react to the ECU's alarm",
        description="Drive a scenario in real time over a CAN bus: the simulated combination sends "
        "what its sensors measure (dbc/swaywatch.dbc), the ECU on the bus answers, and its alarm "
        "brakes the trailer or slows the driver as [reaction] of the scenario says. The rate is "
        "rate_hz of [timing]; see swaywatch.simulate.closed_loop. What [expect] asks for (see "
        "swaywatch.simulate.expectation) becomes a verdict each; exit 1 if one fails.",
    )
    parser.add_argument("scenario", type=Path, help="the scenario, TOML")
    add_bus(parser)
    parser.add_argument(
        "--seed", type=int, metavar="N", help="random seed, instead of the scenario's"
    )
    parser.add_argument(
        "--junit", type=Path, metavar="XML", help="also write the verdicts as a JUnit XML file"
    )


def run(args: argparse.Namespace) -> int:
    """Drive one scenario."""
    from swaywatch.commands.feed import open_bus
    from swaywatch.simulate import load_scenario
    from swaywatch.simulate.closed_loop import LoopResult, drive_closed_loop
    from swaywatch.simulate.expectation import Expectation, as_json, write_junit
    from swaywatch.simulate.table import Table

    scenario = load_scenario(args.scenario, args.seed)
    expectation = Expectation(Table(scenario.expect, f"{scenario.name} [expect]"))
    result = LoopResult()
    stopped = False
    with open_bus(args) as bus:
        try:
            drive_closed_loop(scenario, bus, result=result)
        except KeyboardInterrupt:
            stopped = True
            print("stopped")
        finally:
            print(result.summary())
    verdicts = expectation.judge(result)
    if expectation.is_given:
        for verdict in verdicts:
            print(f"{'passed' if verdict.passed else 'FAILED'}: {verdict.name} ({verdict.seen})")
    if args.junit is not None:
        write_junit(args.junit, scenario.name, result, verdicts)
    output.result(args, as_json(scenario.name, result, verdicts))
    failed = expectation.is_given and not all(verdict.passed for verdict in verdicts)
    return 1 if failed or (stopped and expectation.is_given) else 0
