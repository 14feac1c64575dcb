"""What a recording holds, whatever its format: CAN frames, or signals already decoded."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from swaywatch.errors import RecordingError

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
ByteArray = npt.NDArray[np.uint8]
BoolArray = npt.NDArray[np.bool_]

LONGEST_LEAP_NS = 86_400 * 1_000_000_000
LONGEST_NS = 366 * 86_400 * 1_000_000_000


@dataclass(frozen=True)
class Frames:
    """CAN data frames, one row each, in order of time.

    Attributes
    ----------
    time_ns : int64, shape (n,)
        Timestamp since 1970 (or since the start of measurement where the format knows no date).
    identifier : uint32, shape (n,)
        11 or 29 bits, without flags.
    extended : bool, shape (n,)
        29-bit identifier.
    length : uint8, shape (n,)
        Data bytes.
    data : uint8, shape (n, 8) or (n, 64)
        Bytes beyond `length` are 0.
    bus : uint8, shape (n,)
        Channel of the logger.
    """

    time_ns: IntArray
    identifier: npt.NDArray[np.uint32]
    extended: BoolArray
    length: ByteArray
    data: ByteArray
    bus: ByteArray

    def __len__(self) -> int:
        return len(self.time_ns)

    def take(self, rows: IntArray | BoolArray | slice) -> Frames:
        """The frames of `rows`."""
        return Frames(
            self.time_ns[rows],
            self.identifier[rows],
            self.extended[rows],
            self.length[rows],
            self.data[rows],
            self.bus[rows],
        )


@dataclass(frozen=True)
class Series:
    """One signal: time_ns int64 (n,), value float64 (n,), in `unit` as the file says.

    `comment` is for viewers and only written where the format has a place for it.
    """

    time_ns: IntArray
    value: FloatArray
    unit: str
    comment: str = ""


@dataclass(frozen=True)
class Recording:
    """A file, read whole. Either `frames` or `signals` is set."""

    path: Path
    format: str
    frames: Frames | None = None
    signals: dict[str, Series] | None = None
    error_frames: int = 0
    remote_frames: int = 0
    dropped_frames: int = 0
    notes: tuple[str, ...] = field(default=())

    def with_note(self, note: str) -> Recording:
        """The same recording with one more remark for the report."""
        return replace(self, notes=(*self.notes, note))


def make_frames(
    time_ns: npt.ArrayLike,
    identifier: npt.ArrayLike,
    extended: npt.ArrayLike,
    length: npt.ArrayLike,
    data: ByteArray,
    bus: npt.ArrayLike,
) -> Frames:
    """Frames from columns; narrows the data to 8 bytes where no frame is longer."""
    lengths = np.asarray(length, dtype=np.uint8)
    width = 8 if len(lengths) == 0 or int(lengths.max()) <= 8 else 64
    if data.shape[1] < width:
        data = np.pad(data, ((0, 0), (0, width - data.shape[1])))
    return Frames(
        np.asarray(time_ns, dtype=np.int64),
        np.asarray(identifier, dtype=np.uint32),
        np.asarray(extended, dtype=np.bool_),
        lengths,
        np.ascontiguousarray(data[:, :width], dtype=np.uint8),
        np.asarray(bus, dtype=np.uint8),
    )


def must_make_sense(frames: Frames, path: Path) -> None:
    """Refuse identifiers and times that no bus has: signs of a damaged file."""
    limit = np.where(frames.extended, 0x1FFFFFFF, 0x7FF)
    bad = np.flatnonzero(frames.identifier > limit)
    if len(bad):
        row = int(bad[0])
        raise RecordingError(
            f"{path}: damaged: identifier 0x{int(frames.identifier[row]):X} of frame {row + 1} "
            f"does not fit into {29 if frames.extended[row] else 11} bits"
        )
    if not len(frames):
        return
    first, last = int(frames.time_ns.min()), int(frames.time_ns.max())
    if first < 0 or last - first > LONGEST_NS:
        raise RecordingError(
            f"{path}: damaged: timestamps from {first * 1e-9:.3f} s to {last * 1e-9:.3f} s; a "
            "recording starts at 0 or later and lasts less than a year"
        )
    must_not_leap(path, frames.time_ns, "frame")


def must_rise(path: Path, time_ns: IntArray) -> None:
    """Refuse timestamps of a table that go back, or leap so far that one of them is damaged."""
    step = np.diff(time_ns)
    if np.any(step < 0):
        row = int(np.argmax(step < 0)) + 2
        raise RecordingError(
            f"{path}: time goes back at data row {row} ({time_ns[row - 2] * 1e-9:.9g} s -> "
            f"{time_ns[row - 1] * 1e-9:.9g} s); timestamps must rise"
        )
    must_not_leap(path, time_ns, "data row")


def must_not_leap(path: Path, time_ns: IntArray, what: str) -> None:
    """Refuse rising timestamps with a hole of more than a day."""
    step = np.diff(time_ns)
    if len(step) and int(step.max()) > LONGEST_LEAP_NS:
        row = int(np.argmax(step)) + 2
        raise RecordingError(
            f"{path}: the time leaps by {int(step.max()) * 1e-9:.3f} s at {what} {row} of "
            f"{len(time_ns)}; a timestamp is damaged, or two drives are in one file: split it there"
        )


def in_time_order(frames: Frames, path: Path) -> tuple[Frames, tuple[str, ...]]:
    """Sort by time where loggers wrote slightly out of order; refuse a clock set back.

    Returns the frames and remarks for the report.
    """
    if len(frames) < 2:
        return frames, ()
    step = np.diff(frames.time_ns)
    worst = int(step.min())
    if worst >= 0:
        return frames, ()
    back_ns = int((np.maximum.accumulate(frames.time_ns) - frames.time_ns).max())
    if back_ns > 1_000_000_000:
        row = int(np.argmin(step)) + 1
        raise RecordingError(
            f"{path}: the clock jumps back by {back_ns * 1e-9:.3f} s at frame {row + 1} of "
            f"{len(frames)}; timestamps must rise. Split the file there and give both parts"
        )
    order = np.argsort(frames.time_ns, kind="stable")
    count = int((step < 0).sum())
    note = f"{count} frames out of order by up to {back_ns * 1e-6:.3f} ms, sorted by time"
    return frames.take(order), (note,)
