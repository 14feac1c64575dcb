"""``swaywatch map``: lets the ECU listen to a car's own bus instead of our frames."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any


def add_parser(subparsers: Any) -> None:
    """Add the ``map`` command."""
    parser = subparsers.add_parser(
        "map",
        help="map of a car's own bus for the ECU, from its DBC and signals.toml",
        description="Write the map by which swaywatchd (--map) or an ECU finds its inputs in the "
        "frames of a car's own bus: identifier, position, scale, sign and range of each, with "
        "or without CRC and counter. It is checked by the ECU's own code.",
    )
    parser.add_argument("--signals", type=Path, required=True, metavar="TOML",
                        help="roles and DBC of the bus, as for a recording of it")  # fmt: skip
    parser.add_argument("--protection", type=Path, metavar="TOML",
                        help="CRC and counter of its messages; see "
                             "swaywatch.ecu.bus_map")  # fmt: skip
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="file for the map")


def run(args: argparse.Namespace) -> int:
    """Make, check and write it."""
    from swaywatch.ecu.bus_map import make_map
    from swaywatch.recording.guard import whole_file

    found = make_map(args.signals, args.protection)
    with whole_file(args.out) as temporary:
        temporary.write_bytes(found.to_bytes())
    for line in found.lines:
        print(line)
    places = "".join(
        f" --set {name.partition('_')[0]}.lateral_acceleration_position={position:g}"
        for name, position in found.positions.items()
    )
    print(f"swaywatchd --vehicle vehicle.toml --map {args.out}{places} INTERFACE")
    return 0
