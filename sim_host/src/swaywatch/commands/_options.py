"""Arguments that several commands share, with one wording each."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_files(
    parser: argparse.ArgumentParser,
    *,
    recording: str | None = None,
    vehicle: bool = True,
    signals: bool = True,
) -> None:
    """Add recordings, ``--vehicle`` and ``--signals``.

    Parameters
    ----------
    recording
        Help of the positional argument, one or more files; None: without it.
    vehicle, signals
        Whether the command needs the file; False: without the option.
    """
    if recording is not None:
        parser.add_argument("recording", type=Path, nargs="+", help=recording)
    if vehicle:
        parser.add_argument(
            "--vehicle", type=Path, required=True, metavar="TOML",
            help="vehicle.toml of the combination",
        )  # fmt: skip
    if signals:
        parser.add_argument(
            "--signals", type=Path, required=True, metavar="TOML",
            help="signals.toml of the recordings",
        )  # fmt: skip


def add_simulation_signals(parser: argparse.ArgumentParser) -> None:
    """Add ``--simulation-signals``, beside a ``--simulation`` of the command."""
    parser.add_argument(
        "--simulation-signals", type=Path, metavar="TOML",
        help="signals.toml of the simulation, if its signals have other names than those of the "
        "recording; for an FMU also inputs and parameters (documentation: Your own simulation)",
    )  # fmt: skip


def add_bus(parser: argparse.ArgumentParser) -> None:
    """Add ``--interface``, ``--channel`` and ``--bitrate`` of a CAN bus."""
    parser.add_argument(
        "--interface", default="socketcan", help="python-can interface (default: %(default)s)"
    )
    parser.add_argument(
        "--channel", default="vcan0", help="channel of the interface (default: %(default)s)"
    )
    add_bitrate(parser)


def add_bitrate(parser: argparse.ArgumentParser) -> None:
    """Add ``--bitrate``."""
    parser.add_argument(
        "--bitrate", type=int, metavar="BIT/S",
        help="bit rate, for interfaces that set it, such as 500000",
    )  # fmt: skip
