"""``swaywatch convert``: a recording in another format, or as frames of ``swaywatch.dbc``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from swaywatch.errors import RecordingError, SignalError
from swaywatch.recording import (
    FRAME_SUFFIXES,
    SIGNAL_SUFFIXES,
    Series,
    read_recording,
    write_recording,
)

WRITTEN = tuple(dict.fromkeys((*FRAME_SUFFIXES, *SIGNAL_SUFFIXES)))
DECODED = (".mat", ".mcap")
"""Formats that hold decoded signals only: the roles, in SI units, without frames."""


def add_parser(subparsers: Any) -> None:
    """Add the ``convert`` command."""
    parser = subparsers.add_parser(
        "convert",
        help="write a recording in another format, or as the frames that the ECU reads",
        description="Write a recording in the format of the new file's suffix. With --signals the "
        "roles are encoded as frames of dbc/swaywatch.dbc, counters and CRCs included, which the "
        "daemon, the firmware and `swaywatch monitor` read; without, the content stays as it is.",
    )
    parser.add_argument("recording", type=Path, help="the recording to read")
    parser.add_argument("--signals", type=Path, metavar="TOML", help="roles of the signals")
    parser.add_argument(
        "--to",
        type=Path,
        required=True,
        metavar="FILE",
        help=f"the file to write: {', '.join(WRITTEN)} (.log is candump; .mat and .mcap hold the "
        "decoded roles)",
    )


def run(args: argparse.Namespace) -> int:
    """Convert one recording."""
    if args.to.exists() and args.to.samefile(args.recording):
        raise RecordingError(f"{args.to}: is the recording itself; give another name with --to")
    if args.signals is None:
        recording = read_recording(args.recording)
        content = recording.frames if recording.frames is not None else recording.signals
        assert content is not None
        write_recording(args.to, content)
        print(f"{args.to}: {len(content)} {'frames' if recording.frames else 'signals'}")
        return 0
    from swaywatch.drive import load_drive
    from swaywatch.ecu.bus import encode_drive

    drive = load_drive([args.recording], args.signals)
    if not drive.channels:
        raise SignalError(f"{args.recording}: no channel to encode")
    if args.to.suffix.lower() in DECODED:
        signals = {
            name: Series(
                drive.start_ns + np.rint(channel.time_s * 1e9).astype(np.int64),
                channel.value, channel.unit,
            )
            for name, channel in drive.channels.items()
        }  # fmt: skip
        write_recording(args.to, signals)
        print(f"{args.to}: {len(signals)} channels, ISO 8855 and SI units")
        return 0
    frames = encode_drive(drive)
    write_recording(args.to, frames)
    print(f"{args.to}: {len(frames)} frames of swaywatch.dbc, {len(drive.channels)} channels")
    return 0
