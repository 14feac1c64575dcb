"""``swaywatch feed``: a recording or a scenario onto a bus, in time."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from swaywatch.errors import RecordingError
from swaywatch.recording import Frames


def add_parser(subparsers: Any) -> None:
    """Add the ``feed`` command."""
    parser = subparsers.add_parser(
        "feed",
        help="play a recording or a scenario onto a CAN bus",
        description="Play the frames of a recording, or a simulated scenario (.toml), onto a bus "
        "at the times they carry. Any python-can interface will do.",
    )
    parser.add_argument("source", type=Path, help="a recording, or a scenario (.toml)")
    parser.add_argument(
        "--interface", default="socketcan", help="python-can interface (default: socketcan)"
    )
    parser.add_argument("--channel", default="vcan0", help="channel (default: vcan0)")
    parser.add_argument("--bitrate", type=int, help="for interfaces that set it")
    parser.add_argument(
        "--speed", type=float, default=1.0, metavar="N", help="N times real time; 0: without pause"
    )
    parser.add_argument(
        "--signals",
        type=Path,
        metavar="TOML",
        help="send the recording's roles as frames of dbc/swaywatch.dbc instead of its own frames",
    )
    parser.add_argument("--seed", type=int, metavar="N", help="instead of the scenario's seed")


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
    """The bus of ``--interface``, ``--channel`` and ``--bitrate``."""
    import can

    options: dict[str, Any] = {"interface": args.interface, "channel": args.channel}
    if args.bitrate is not None:
        options["bitrate"] = args.bitrate
    try:
        return can.Bus(**options)
    except (can.CanError, OSError, ValueError, ImportError) as error:
        raise RecordingError(
            f"{args.interface} {args.channel}: cannot be opened: {error}; `ip link` lists "
            "SocketCAN interfaces"
        ) from None
