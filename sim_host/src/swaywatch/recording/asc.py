"""Vector ASC, read and written by python-can, guarded where it would lose frames silently."""

from __future__ import annotations

import re
from pathlib import Path

import can

from swaywatch.errors import RecordingError
from swaywatch.recording import pythoncan
from swaywatch.recording.frames import Frames, Recording

_HEADER = re.compile(r"^\s*(date\s|base\s+(hex|dec))", re.IGNORECASE | re.MULTILINE)
_RELATIVE = re.compile(r"^base\s+\w+\s+timestamps\s+relative", re.IGNORECASE | re.MULTILINE)
_FRAME = re.compile(
    r"^[ \t]*\d+\.\d+[ \t]+(?:\d+[ \t]+(?:\w+[ \t]+(?:Rx|Tx)\b|ErrorFrame)|CANFD[ \t]).*$",
    re.IGNORECASE | re.MULTILINE,
)
_CLASSIC = re.compile(r"\s(?:Rx|Tx)\s+d\s+([0-9a-f])((?:\s+[0-9a-f]{1,3}(?![\w=:]))*)", re.I)


def read(path: Path) -> Recording:
    """Read every data frame of an ASC file.

    Raises
    ------
    RecordingError
        Not ASC; not UTF-8; a frame line that cannot be read whole; relative timestamps.
    """
    text = pythoncan.text_lines(path, "ASC")
    whole = text.getvalue()
    if not _HEADER.search(whole[:4096]):
        raise RecordingError(
            f"{path}: not an ASC file: its head has neither a `date` nor a `base hex` line"
        )
    if _RELATIVE.search(whole[:4096]):
        raise RecordingError(
            f"{path}: timestamps are relative to the previous event; "
            "export it with `timestamps absolute`"
        )
    _check_last_line(path, whole)
    recording = pythoncan.collect(can.ASCReader(text, relative_timestamp=False), path, "ASC")
    if "begin triggerblock" in whole.lower() and "end triggerblock" not in whole[-4096:].lower():
        recording = recording.with_note(
            "no `End TriggerBlock`: the file may be cut off between two lines"
        )
    found = sum(1 for _ in _FRAME.finditer(whole))
    frames = recording.frames
    assert frames is not None
    read_back = len(frames) + recording.error_frames + recording.remote_frames
    if found != read_back:
        raise RecordingError(
            f"{path}: damaged ASC: {found} lines look like frames, {read_back} could be read"
        )
    return recording


def write(path: Path, frames: Frames) -> None:
    """Write frames as ASC (times relative to the first frame, 1 us)."""
    pythoncan.write(path, frames)


def _check_last_line(path: Path, text: str) -> None:
    """Refuse a file whose last frame line stops before its data does."""
    lines = text.rstrip("\r\n").rsplit("\n", 1)
    match = _CLASSIC.search(lines[-1])
    ends = text.endswith("\n")
    if match and len(match[2].split()) < min(8, int(match[1], 16)):
        raise RecordingError(
            f"{path}: truncated ASC: the last line ends after {len(match[2].split())} of "
            f"{int(match[1], 16)} data bytes: {lines[-1].strip()!r}"
        )
    if not ends and not lines[-1].strip().lower().startswith("end") and not match:
        raise RecordingError(
            f"{path}: truncated ASC: the last line is not whole: {lines[-1].strip()!r}"
        )
