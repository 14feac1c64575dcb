"""What is in recordings: every signal with its rate, range and unit, before any role is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from swaywatch.errors import RecordingError, SwaywatchError
from swaywatch.recording import Frames, Series, read_recording
from swaywatch.recording.dbc import Database, frames_by_identifier

FloatArray = npt.NDArray[np.float64]
FEWEST_SAMPLES = 8


@dataclass(frozen=True)
class Signal:
    """One signal of a recording.

    Attributes
    ----------
    name, message, unit
        As file or DBC say.
    time_s, value : float64, shape (n,)
        Since the first sample of the recording; in `unit`.
    """

    name: str
    message: str
    unit: str
    time_s: FloatArray
    value: FloatArray

    @property
    def rate_hz(self) -> float:
        """Samples a second, by the usual step."""
        step = float(np.median(np.diff(self.time_s))) if len(self.time_s) > 1 else 0.0
        return 1.0 / step if step > 0.0 else 0.0

    @property
    def varies(self) -> bool:
        """Is it more than one value."""
        return bool(len(self.value)) and float(np.ptp(self.value)) > 0.0


def dbc_files(recording: Path) -> list[Path]:
    """DBC files beside a recording and in the two folders above it, nearest first."""
    folders = [recording.resolve().parent, *recording.resolve().parents[1:3]]
    return [path for folder in folders for path in sorted(folder.glob("*.dbc"))]


def inventory(
    recordings: Sequence[Path], dbcs: Sequence[Path] = ()
) -> tuple[list[Signal], list[Path]]:
    """Signals of recordings of one vehicle, and the DBC files that decode them.

    Parameters
    ----------
    recordings
        Any format. Of a signal that several hold, the first is taken.
    dbcs
        For frames; none: the files beside the recordings, the one that explains most frames.

    Raises
    ------
    SwaywatchError
        A recording or DBC that cannot be read; frames without any DBC that knows them.
    """
    found: dict[str, Signal] = {}
    used: list[Path] = []
    for path in recordings:
        recording = read_recording(path)
        if recording.frames is None:
            assert recording.signals is not None
            start = min(int(s.time_ns[0]) for s in recording.signals.values() if len(s.time_ns))
            signals = [_signal(n, "", s, start) for n, s in recording.signals.items()]
        else:
            chosen = list(dbcs) or _best(path, recording.frames)
            used += [dbc for dbc in chosen if dbc not in used]
            signals = _decoded(recording.frames, Database(chosen))
            if not signals:
                names = ", ".join(str(dbc) for dbc in chosen)
                raise RecordingError(
                    f"{path}: none of its frames is in {names}; give the logger's own DBC: --dbc"
                )
        for signal in signals:
            found.setdefault(signal.name, signal)
    return list(found.values()), used


def _signal(name: str, message: str, series: Series, start_ns: int) -> Signal:
    time_s = ((series.time_ns - start_ns) * 1e-9).astype(np.float64)
    value = np.asarray(series.value, np.float64)
    return Signal(name, message, series.unit.strip(), time_s, value)


def _best(path: Path, frames: Frames) -> list[Path]:
    """The DBC near a recording that knows most of its frames."""
    near = dbc_files(path)
    counts = {key: len(rows) for key, rows in frames_by_identifier(frames).items()}
    best, most = None, 0
    for dbc in near:
        try:
            database = Database([dbc])
        except SwaywatchError:
            continue
        keys = {(m.frame_id, bool(m.is_extended_frame)) for m in database.messages.values()}
        known = sum(count for key, count in counts.items() if key in keys)
        if known > most:
            best, most = dbc, known
    if best is None:
        where = f"; tried {', '.join(p.name for p in near)}" if near else ""
        raise RecordingError(
            f"{path}: holds CAN frames, but no DBC near it contains them{where}; give the logger's "
            "DBC: --dbc FILE"
        )
    return [best]


def _decoded(frames: Frames, database: Database) -> list[Signal]:
    rows_of = frames_by_identifier(frames)
    start = int(frames.time_ns[0])
    found = []
    seen: set[str] = set()
    for message in database.messages.values():
        rows = rows_of.get((message.frame_id, bool(message.is_extended_frame)))
        if rows is None:
            continue
        for signal in message.signals:
            series = database.decode(frames, rows, message, signal).series
            if len(series.value) < FEWEST_SAMPLES:
                continue
            several = len(database._signals[signal.name]) > 1
            name = f"{message.name}.{signal.name}" if several else signal.name
            if name not in seen:
                seen.add(name)
                found.append(_signal(name, message.name, series, start))
    return found
