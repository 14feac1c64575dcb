"""``swaywatch feed``: a recording or a scenario onto a bus, in real time."""

from __future__ import annotations

import argparse
import errno
from pathlib import Path
from typing import Any

from swaywatch.commands._options import add_bus
from swaywatch.errors import RecordingError
from swaywatch.nearest import with_known
from swaywatch.recording import Frames


def add_parser(subparsers: Any) -> None:
    """Add the ``feed`` command."""
    parser = subparsers.add_parser(
        "feed",
        help="play a recording or a scenario onto a CAN bus",
        description="Play the frames of a recording, or a simulated scenario (.toml), onto a bus "
        "at their recorded times, through any interface of python-can.",
    )
    parser.add_argument("source", type=Path, help="a recording, or a scenario (.toml)")
    add_bus(parser)
    parser.add_argument(
        "--speed",
        type=float,
        default=1.0,
        metavar="N",
        help="play at N times real time (default: 1); 0: without pause",
    )
    parser.add_argument(
        "--signals",
        type=Path,
        metavar="TOML",
        help="send the recording's roles as frames of dbc/swaywatch.dbc instead of its own frames",
    )
    parser.add_argument(
        "--seed", type=int, metavar="N", help="random seed, instead of the scenario's"
    )


def run(args: argparse.Namespace) -> int:
    """Feed one source."""
    from swaywatch.simulate.feed import FeedResult, feed

    if args.speed < 0.0:
        raise RecordingError(f"--speed {args.speed:g} must not be negative")
    frames = _frames(args)
    result = FeedResult()
    with open_bus(args) as bus:
        try:
            feed(frames, bus, speed=args.speed, result=result)
        finally:
            print(result.summary())
    return 0


def _frames(args: argparse.Namespace) -> Frames:
    from swaywatch.recording import read_recording

    if args.source.suffix.lower() == ".toml":
        from swaywatch.ecu.bus import encode_drive
        from swaywatch.simulate import load_scenario, simulate_scenario

        return encode_drive(simulate_scenario(load_scenario(args.source, args.seed))[0])
    if args.signals is not None:
        from swaywatch.drive import load_drive
        from swaywatch.ecu.bus import encode_drive

        return encode_drive(load_drive([args.source], args.signals))
    recording = read_recording(args.source)
    if recording.frames is None:
        raise RecordingError(
            f"{args.source}: holds decoded signals, not frames; give --signals to encode them"
        )
    return recording.frames


def open_bus(args: argparse.Namespace) -> Any:
    """The bus of ``--interface``, ``--channel`` and ``--bitrate``.

    Raises
    ------
    RecordingError
        Names interface and channel, the cause, and what would be right.
    """
    import can

    options: dict[str, Any] = {"interface": args.interface, "channel": args.channel}
    if args.bitrate is not None:
        options["bitrate"] = args.bitrate
    try:
        return can.Bus(**options)
    except Exception as error:  # drivers raise anything from OSError to NameError
        raise RecordingError(
            f"--interface {args.interface} --channel {args.channel}: cannot be opened: "
            f"{_bus_words(args, error)}"
        ) from error


def _bus_words(args: argparse.Namespace, error: Exception) -> str:
    """Why a bus cannot be opened, and what would be right."""
    number = getattr(error, "errno", None)
    if number == errno.EAFNOSUPPORT:
        return (
            "this kernel has no CAN (AF_CAN); load it with `sudo modprobe can_raw vcan`, use a "
            "machine that has it, or another --interface (on one machine `virtual`; over a "
            "network `udp_multicast`)"
        )
    if number == errno.ENODEV and args.interface == "socketcan":
        return (
            "there is no such network interface; `ip link` lists them. A virtual one: `sudo ip "
            f"link add {args.channel} type vcan && sudo ip link set {args.channel} up`"
        )
    if number == errno.ENETDOWN:
        return f"it is down; `sudo ip link set {args.channel} up` starts it"
    import can

    names = sorted(can.VALID_INTERFACES)
    if args.interface not in names:
        return f"there is no such interface{with_known(args.interface, names)}"
    return str(error) or type(error).__name__
