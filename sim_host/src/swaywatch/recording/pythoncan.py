"""The formats that python-can reads and writes frame by frame: ASC, TRC; and its writers."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import can
import numpy as np

from swaywatch.errors import RecordingError
from swaywatch.recording.frames import Frames, Recording, in_time_order, make_frames
from swaywatch.recording.guard import refusing


def messages(frames: Frames) -> Iterator[can.Message]:
    """The frames as python-can messages."""
    wide = frames.data.shape[1] > 8
    columns = (
        frames.time_ns.tolist(),
        frames.identifier.tolist(),
        frames.extended.tolist(),
        frames.length.tolist(),
        frames.bus.tolist(),
    )
    for row, (time_ns, identifier, extended, length, bus) in enumerate(zip(*columns, strict=True)):
        yield can.Message(
            timestamp=time_ns * 1e-9,
            arbitration_id=identifier,
            is_extended_id=extended,
            is_fd=wide and length > 8,
            dlc=length,
            data=frames.data[row, :length].tobytes(),
            channel=bus,
        )


def write(path: Path, frames: Frames, **options: Any) -> None:
    """Write with the python-can writer of the suffix of `path`."""
    with can.Logger(str(path), **options) as writer:
        for message in messages(frames):
            writer.on_message_received(message)


def collect(reader: Any, path: Path, name: str) -> Recording:
    """Every data frame of a python-can reader."""
    times: list[float] = []
    identifiers: list[int] = []
    extended: list[bool] = []
    payloads: list[bytes] = []
    buses: list[int] = []
    error_frames = remote_frames = 0
    with refusing(path, name):
        for message in reader:
            if message.is_error_frame:
                error_frames += 1
            elif message.is_remote_frame:
                remote_frames += 1
            else:
                if len(message.data) != message.dlc:
                    raise RecordingError(
                        f"{path}: damaged {name}: frame {len(times) + 1} "
                        f"(0x{message.arbitration_id:X} at {message.timestamp:.6f} s) says "
                        f"{message.dlc} data bytes and holds {len(message.data)}"
                    )
                if not 0.0 <= message.timestamp < 1e10:
                    raise RecordingError(
                        f"{path}: damaged {name}: frame {len(times) + 1} has the time "
                        f"{message.timestamp:g} s"
                    )
                times.append(message.timestamp)
                identifiers.append(message.arbitration_id)
                extended.append(message.is_extended_id)
                payloads.append(bytes(message.data))
                buses.append(message.channel if isinstance(message.channel, int) else 0)
    frames = from_lists(times, identifiers, extended, payloads, buses)
    frames, notes = in_time_order(frames, path)
    return Recording(
        path,
        name,
        frames=frames,
        error_frames=error_frames,
        remote_frames=remote_frames,
        notes=notes,
    )


def from_lists(
    times_s: list[float],
    identifiers: list[int],
    extended: list[bool],
    payloads: list[bytes],
    buses: list[int],
) -> Frames:
    """Frames from one list per column; times in seconds."""
    width = max([8, *map(len, payloads)]) if payloads else 8
    joined = b"".join(payload.ljust(width, b"\0") for payload in payloads)
    data = np.frombuffer(joined, dtype=np.uint8).reshape(len(payloads), width)
    time_ns = np.rint(np.array(times_s, dtype=np.float64) * 1e6).astype(np.int64) * 1000
    return make_frames(
        time_ns,
        np.array(identifiers, dtype=np.int64),
        extended,
        [len(payload) for payload in payloads],
        data,
        np.clip(np.array(buses, dtype=np.int64), 0, 255),
    )


def text_lines(path: Path, name: str) -> io.StringIO:
    """The text of a log file; bytes that are not UTF-8 are refused with their place."""
    raw = path.read_bytes()
    try:
        return io.StringIO(raw.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise RecordingError(
            f"{path}: not a {name} text file: line {line} holds the byte 0x{raw[error.start]:02X}, "
            "which is not UTF-8. Was it converted with the wrong character set, or is it binary?"
        ) from None
