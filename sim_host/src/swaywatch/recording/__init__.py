"""Recordings: one file per log format; here the choice between them.

:func:`read_recording` gives a :class:`Recording` of frames or of decoded signals, whatever the
format; :func:`write_recording` is its counterpart. :mod:`swaywatch.recording.dbc` decodes and
encodes.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from swaywatch.errors import RecordingError
from swaywatch.recording.frames import Frames, Recording, Series, must_make_sense
from swaywatch.recording.guard import must_exist, refusing, whole_file

__all__ = [
    "FRAME_SUFFIXES",
    "SIGNAL_SUFFIXES",
    "SUFFIXES",
    "Frames",
    "Recording",
    "Series",
    "read_recording",
    "write_recording",
]

FRAME_SUFFIXES = (".blf", ".asc", ".log", ".trc", ".mf4", ".csv", ".parquet")
"""Formats that can hold CAN frames."""

SIGNAL_SUFFIXES = (".mf4", ".csv", ".parquet", ".mat", ".mcap")
"""Formats that can hold decoded signals."""

SUFFIXES = (*dict.fromkeys((*FRAME_SUFFIXES, *SIGNAL_SUFFIXES)), ".db3")
"""Formats that can be read; a ROS 2 bag (``.db3``) is only read."""


def read_recording(path: Path | str) -> Recording:
    """Read a recording whole.

    Parameters
    ----------
    path
        ``.blf``, ``.asc``, ``.log`` (candump), ``.trc``, ``.mf4``, ``.csv``, ``.parquet``,
        ``.mat``, ``.mcap`` or ``.db3`` (ROS 2 bag).

    Returns
    -------
    Recording
        With `frames`, or with decoded `signals`.

    Raises
    ------
    RecordingError
        Missing, of another format, damaged, cut off or empty.
    """
    path = Path(path)
    must_exist(path)
    suffix = path.suffix.lower()
    recording = _read(path, suffix)
    if recording.frames is not None and len(recording.frames) == 0:
        extra = f" ({recording.error_frames} error frames)" if recording.error_frames else ""
        raise RecordingError(f"{path}: the recording is empty: no data frame in it{extra}")
    if recording.frames is not None:
        must_make_sense(recording.frames, path)
    return recording


_READERS = {
    ".blf": ("blf", "read"),
    ".asc": ("asc", "read"),
    ".log": ("candump", "read"),
    ".trc": ("trc", "read"),
    ".mf4": ("mf4", "read"),
    ".mdf": ("mf4", "read"),
    ".csv": ("table", "read_csv"),
    ".parquet": ("table", "read_parquet"),
    ".mat": ("mat", "read"),
    ".mcap": ("mcap", "read"),
    ".db3": ("ros2", "read"),
}
"""Module and function for each suffix; imported when needed, since some load large libraries."""


def _read(path: Path, suffix: str) -> Recording:
    if suffix not in _READERS:
        raise RecordingError(
            f"{path}: unknown format {suffix or '(no suffix)'!r}; known: {', '.join(SUFFIXES)}"
        )
    module, function = _READERS[suffix]
    with refusing(path, suffix.removeprefix(".").upper()):
        reader = getattr(import_module(f"swaywatch.recording.{module}"), function)
        found: Recording = reader(path)
    return found


def write_recording(path: Path | str, content: Frames | dict[str, Series]) -> None:
    """Write frames, or decoded signals, in the format of the suffix; whole or not at all.

    Parameters
    ----------
    path
        Suffix as for :func:`read_recording`; decoded signals only those of `SIGNAL_SUFFIXES`.
    content
        Frames in order of time, or signals by name.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    known = FRAME_SUFFIXES if isinstance(content, Frames) else SIGNAL_SUFFIXES
    if suffix not in known:
        what = "frames" if isinstance(content, Frames) else "decoded signals"
        raise RecordingError(
            f"{path}: cannot write {what} as {suffix or '(no suffix)'!r}; known: {', '.join(known)}"
        )
    with whole_file(path) as temporary:
        _write(temporary, suffix, content)


def _write(path: Path, suffix: str, content: Frames | dict[str, Series]) -> None:
    from swaywatch.recording import asc, blf, candump, mf4, table, trc

    if suffix == ".csv":
        table.write_csv(path, content)
    elif suffix == ".parquet":
        table.write_parquet(path, content)
    elif not isinstance(content, Frames):
        _write_signals(path, suffix, content)
    else:
        writers = {
            ".blf": blf.write,
            ".asc": asc.write,
            ".log": candump.write,
            ".trc": trc.write,
            ".mf4": mf4.write_frames,
        }
        writers[suffix](path, content)


def _write_signals(path: Path, suffix: str, signals: dict[str, Series]) -> None:
    from swaywatch.recording import mat, mcap, mf4

    writers = {".mf4": mf4.write_signals, ".mat": mat.write, ".mcap": mcap.write}
    writers[suffix](path, signals)
