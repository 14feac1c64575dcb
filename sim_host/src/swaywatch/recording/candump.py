"""candump logs (``candump -l``): ``(1700000000.000022) can0 0C2#FEFF050000000000``.

Our own reader: python-can's takes error frames for data frames and stops at DROPCOUNT lines.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from swaywatch.errors import RecordingError
from swaywatch.recording import pythoncan
from swaywatch.recording.frames import Frames, Recording, in_time_order, make_frames

_LINE = re.compile(
    r"\((\d{1,10})\.(\d{1,9})\)[ \t]+(\S+)[ \t]+([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})"
    r"#(?:#([0-9A-Fa-f]))?((?:[0-9A-Fa-f]{2}){0,64}|R[0-9A-Fa-f]?)(?:_[0-9A-Fa-f])?"
    r"(?:[ \t]+[RT]X?)?[ \t]*"
)
_DROP = re.compile(r"DROPCOUNT:\s*dropped (\d{1,18}) CAN frames?", re.IGNORECASE)
_ERROR_FLAG = 0x20000000


def read(path: Path) -> Recording:
    """Read every data frame of a candump log; count error frames, remote frames and losses.

    Raises
    ------
    RecordingError
        Not a candump log; not UTF-8; a line that cannot be read (its number is named).
    """
    lines = pythoncan.text_lines(path, "candump").getvalue().splitlines()
    seconds: list[str] = []
    fractions: list[str] = []
    buses: list[str] = []
    identifiers: list[str] = []
    payloads: list[str] = []
    errors = remotes = dropped = 0
    match_line = _LINE.fullmatch
    for number, line in enumerate(lines, 1):
        match = match_line(line)
        if match is None:
            drop = _DROP.search(line)
            if drop:
                dropped += int(drop[1])
            elif line.strip():
                raise _bad_line(path, number, line, len(lines), bool(seconds))
            continue
        second, fraction, bus, identifier, _, data = match.groups()
        if data[:1] in ("R", "r"):
            remotes += 1
        elif len(identifier) == 8 and int(identifier, 16) & _ERROR_FLAG:
            errors += 1
        else:
            seconds.append(second)
            fractions.append(fraction)
            buses.append(bus)
            identifiers.append(identifier)
            payloads.append(data)
    frames = _columns(seconds, fractions, buses, identifiers, payloads)
    frames, notes = in_time_order(frames, path)
    return Recording(
        path,
        "candump",
        frames=frames,
        error_frames=errors,
        remote_frames=remotes,
        dropped_frames=dropped,
        notes=notes,
    )


def write(path: Path, frames: Frames) -> None:
    """Write frames as a candump log (1 us)."""
    hexes = frames.data.tobytes().hex().upper()
    stride = 2 * frames.data.shape[1]
    rows = zip(
        (frames.time_ns // 1000).tolist(),
        frames.bus.tolist(),
        frames.identifier.tolist(),
        frames.extended.tolist(),
        frames.length.tolist(),
        strict=True,
    )
    with path.open("w", encoding="ascii") as file:
        for row, (time_us, bus, identifier, extended, length) in enumerate(rows):
            name = f"{identifier:08X}" if extended else f"{identifier:03X}"
            data = hexes[row * stride : row * stride + 2 * length]
            mark = "##0" if length > 8 else "#"
            file.write(
                f"({time_us // 1_000_000}.{time_us % 1_000_000:06d}) can{bus} {name}{mark}{data}\n"
            )


def _columns(
    seconds: list[str],
    fractions: list[str],
    buses: list[str],
    identifiers: list[str],
    payloads: list[str],
) -> Frames:
    count = len(seconds)
    width = 2 * max(8, max(map(len, payloads), default=0) // 2)
    data = bytes.fromhex("".join([payload.ljust(width, "0") for payload in payloads]))
    digits = np.array([len(fraction) for fraction in fractions], dtype=np.int64)
    fraction_ns = np.array(fractions or [], dtype=object).astype(np.int64)
    fraction_ns = fraction_ns * 10 ** np.maximum(9 - digits, 0) // 10 ** np.maximum(digits - 9, 0)
    names = {name: number for number, name in enumerate(dict.fromkeys(buses))}
    return make_frames(
        np.array(seconds, dtype=object).astype(np.int64) * 1_000_000_000 + fraction_ns,
        np.array([int(identifier, 16) & 0x1FFFFFFF for identifier in identifiers], dtype=np.int64),
        [len(identifier) == 8 for identifier in identifiers],
        [len(payload) // 2 for payload in payloads],
        np.frombuffer(data, dtype=np.uint8).reshape(count, width // 2),
        [min(names[bus], 255) for bus in buses],
    )


def _bad_line(path: Path, number: int, line: str, count: int, any_read: bool) -> RecordingError:
    shown = line.strip()[:80]
    if number == count and any_read:
        return RecordingError(
            f"{path}: truncated candump log: line {number}, the last, is not whole: {shown!r}"
        )
    return RecordingError(
        f"{path}: not a candump log: line {number} is {shown!r}, "
        "expected like `(1700000000.000022) can0 0C2#FEFF050000000000`"
    )
