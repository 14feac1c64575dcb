"""``swaywatch roles``: the roles that a signals.toml can name."""

from __future__ import annotations

import argparse
from typing import Any

from swaywatch.roles import CHANNELS
from swaywatch.terminal import output

HAS_JSON = True


def add_parser(subparsers: Any) -> None:
    """Add the ``roles`` command."""
    subparsers.add_parser(
        "roles",
        help="list the roles that a signals.toml can assign, with units and signs",
        description="The roles that a signals.toml can assign, with units and signs.",
    )


def run(args: argparse.Namespace) -> int:
    """Print the table of roles."""
    output.result(args, {c.name: {"unit": c.unit, "meaning": c.meaning} for c in CHANNELS.values()})
    for channel in CHANNELS.values():
        print(f"{channel.name:34s} {channel.unit:6s} {channel.meaning}")
    return 0
