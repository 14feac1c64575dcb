"""PEAK TRC, read and written by python-can, guarded where it would lose frames silently."""

from __future__ import annotations

import re
from pathlib import Path

import can
import numpy as np

from swaywatch.errors import RecordingError
from swaywatch.recording import pythoncan
from swaywatch.recording.frames import Frames, Recording

_ROW = re.compile(r"^[ \t]*[^;\s]", re.MULTILINE)
_NO_DATA_TYPES = re.compile(
    r"^[ \t]*\d+\)?[ \t]+\d+[.,]?\d*[ \t]+(?:ST|EC|ER|EV|Warng|Error)\b", re.MULTILINE
)


def read(path: Path) -> Recording:
    """Read every data frame of a TRC file.

    Raises
    ------
    RecordingError
        Not TRC; not UTF-8; a frame line that cannot be read whole.
    """
    text = pythoncan.text_lines(path, "TRC")
    whole = text.getvalue()
    if not whole.lstrip().startswith(";"):
        raise RecordingError(
            f"{path}: not a TRC file: it should start with `;$FILEVERSION` or another `;` line"
        )
    recording = pythoncan.collect(can.TRCReader(text), path, "TRC")
    frames = recording.frames
    assert frames is not None
    found = sum(1 for _ in _ROW.finditer(whole))
    other = sum(1 for _ in _NO_DATA_TYPES.finditer(whole))
    read_back = len(frames) + recording.remote_frames + recording.error_frames
    if found - other != read_back:
        raise RecordingError(
            f"{path}: damaged TRC: {found - other} lines look like frames, "
            f"{read_back} could be read"
        )
    return recording


def write(path: Path, frames: Frames) -> None:
    """Write frames as TRC 2.1 (times relative to the first frame, 1 us); classic CAN only."""
    if np.any(frames.length > 8):
        raise RecordingError(
            f"{path}: TRC is written for classic CAN only, and a frame holds "
            f"{int(frames.length.max())} bytes; choose .mf4, .blf, .asc, .log, .csv or .parquet"
        )
    pythoncan.write(path, frames)
