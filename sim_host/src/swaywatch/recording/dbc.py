"""Decoding and encoding of frames by a DBC, a whole recording at a time.

cantools reads the DBC; the bits are moved here with numpy, for all frames of a message at once
(cantools decodes frame by frame, about 1000 times slower).
"""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cantools
import numpy as np
import numpy.typing as npt

from swaywatch.errors import SignalError
from swaywatch.recording.frames import Frames, IntArray, Series, make_frames
from swaywatch.recording.guard import must_be_regular

MOST_BYTES = 64 << 20
LARGEST = 1e39
"""Above what a float of 32 bits holds."""

_INVALID_NAME = re.compile(
    r"invalid|not.?avail|^na$|^sna$|error|fault|init|undefined|no.?signal", re.IGNORECASE
)


@dataclass(frozen=True)
class Decoded:
    """A signal of a recording: its samples, and what was wrong with them."""

    series: Series
    message: str
    marked_invalid: int  # the sender said "not valid" (value table)
    out_of_range: int  # outside [minimum, maximum] of the DBC
    short_frames: int  # frames too short to hold the signal
    low: float | None  # range of the DBC
    high: float | None
    raw_limits: tuple[float, float]  # what the bits can hold, in the signal's unit


class Database:
    """One or several DBC files, checked for sense when loaded.

    Raises
    ------
    SignalError
        Missing, no DBC, overlapping signals, a scale of 0.
    """

    def __init__(self, paths: list[Path]) -> None:
        self.paths = paths
        self._signals: dict[str, list[tuple[Any, Any]]] = {}
        self.messages: dict[str, Any] = {}
        for path in paths:
            for message in _load(path).messages:
                self.messages[message.name] = message
                for signal in message.signals:
                    _check_signal(path, message, signal)
                    self._signals.setdefault(signal.name, []).append((message, signal))

    @property
    def signal_names(self) -> list[str]:
        """All signal names."""
        return list(self._signals)

    def find(self, name: str) -> tuple[Any, Any] | None:
        """Message and signal for ``Signal`` or ``Message.Signal``; None where unknown."""
        message_name, _, signal_name = name.rpartition(".")
        found = self._signals.get(signal_name, [])
        if message_name:
            found = [pair for pair in found if pair[0].name == message_name]
        if len(found) > 1:
            options = ", ".join(f"{message.name}.{signal_name}" for message, _ in found)
            raise SignalError(f"signal {name!r} is in several messages; write one of: {options}")
        return found[0] if found else None

    def decode(self, frames: Frames, rows: IntArray, message: Any, signal: Any) -> Decoded:
        """Samples of one signal in the frames of its message.

        Parameters
        ----------
        frames, rows
            All frames, and which of them are this message's.
        message, signal
            From :meth:`find`.
        """
        rows, short = _carrying(frames, rows, message, signal)
        raw = _raw(frames.data, rows, signal)
        value = raw.astype(np.float64) * signal.scale + signal.offset
        invalid = np.isin(raw, invalid_codes(signal))
        low, high = signal.minimum, signal.maximum
        if low is not None and high is not None and low < high:
            margin = 0.5 * abs(signal.scale)
            outside = ~invalid & ((value < low - margin) | (value > high + margin))
        else:
            low = high = None
            outside = np.zeros(len(value), dtype=np.bool_)
        keep = ~(invalid | outside | ~np.isfinite(value))
        return Decoded(
            Series(frames.time_ns[rows][keep], value[keep], signal.unit or ""),
            message.name,
            int(invalid.sum()),
            int(outside.sum()),
            short,
            low,
            high,
            _raw_limits(signal),
        )


def frames_by_identifier(frames: Frames) -> dict[tuple[int, bool], IntArray]:
    """Rows of each (identifier, extended), in order of time."""
    key = frames.identifier.astype(np.int64) * 2 + frames.extended
    order = np.argsort(key, kind="stable")
    keys, starts = np.unique(key[order], return_index=True)
    parts = np.split(order, starts[1:])
    return {(int(k) >> 1, bool(k & 1)): part for k, part in zip(keys, parts, strict=True)}


def encode_messages(
    database: Database,
    samples: dict[str, tuple[IntArray, dict[str, npt.NDArray[np.float64]]]],
    bus: int = 0,
) -> Frames:
    """Frames of several messages, merged by time.

    Parameters
    ----------
    samples
        Message name -> (time_ns of its frames, signal name -> physical value of each frame).
        Signals of the message that are not given are 0 in the raw bits. Values beyond what the
        bits or the DBC's range can hold are clipped.
    bus
        Channel of the logger.

    Returns
    -------
    Frames
        In order of time.
    """
    parts: list[Frames] = []
    for name, (time_ns, values) in samples.items():
        message = database.messages[name]
        count = len(time_ns)
        data = np.zeros((count, max(8, message.length)), dtype=np.uint8)
        for signal_name, value in values.items():
            _put(data, message.get_signal_by_name(signal_name), value)
        parts.append(
            make_frames(
                time_ns,
                np.full(count, message.frame_id, dtype=np.int64),
                np.full(count, message.is_extended_frame),
                np.full(count, message.length),
                data,
                np.full(count, bus),
            )
        )
    width = max((part.data.shape[1] for part in parts), default=8)
    merged = make_frames(
        np.concatenate([part.time_ns for part in parts]),
        np.concatenate([part.identifier for part in parts]),
        np.concatenate([part.extended for part in parts]),
        np.concatenate([part.length for part in parts]),
        np.concatenate([np.pad(p.data, ((0, 0), (0, width - p.data.shape[1]))) for p in parts]),
        np.concatenate([part.bus for part in parts]),
    )
    return merged.take(np.argsort(merged.time_ns, kind="stable"))


def _load(path: Path) -> Any:
    must_be_regular(path, "DBC file", SignalError)
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise SignalError(
            f"{path}: {size} bytes are too many for a DBC file; at most {MOST_BYTES} are read"
        )
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        text = path.read_bytes().decode("cp1252", "replace")
    try:
        database: Any = cantools.database.load_string(text, database_format="dbc")
    except Exception as error:  # the parser raises many kinds
        first = (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
        raise SignalError(f"{path}: not a DBC file that makes sense: {first}") from None
    if not database.messages:
        raise SignalError(f"{path}: no message (BO_) in this DBC")
    return database


def _check_signal(path: Path, message: Any, signal: Any) -> None:
    where = f"{path}: signal {message.name}.{signal.name}"
    if signal.scale == 0:
        raise SignalError(f"{where}: a scale of 0 makes every value the same; the DBC is damaged")
    for name in ("scale", "offset", "minimum", "maximum"):
        number = getattr(signal, name)
        if number is not None and not abs(number) < LARGEST:
            shown = str(number)[:40]
            raise SignalError(f"{where}: a {name} of {shown} is no number that a signal can have")
    if not 1 <= signal.length <= 64:
        raise SignalError(f"{where}: {signal.length} bits; 1 to 64 expected")
    if signal.is_float and signal.length not in (32, 64):
        raise SignalError(f"{where}: a float of {signal.length} bits; 32 or 64 expected")


def _bit_positions(signal: Any) -> list[tuple[int, int, int]]:
    """(byte, bits to the right in that byte, bits taken), most significant part first."""
    parts = []
    left = signal.length
    if signal.byte_order == "little_endian":
        bit = signal.start
        while left:
            inside = bit % 8
            take = min(8 - inside, left)
            parts.append((bit // 8, inside, take))
            bit += take
            left -= take
        return parts[::-1]
    byte, high = divmod(signal.start, 8)
    while left:
        take = min(high + 1, left)
        parts.append((byte, high + 1 - take, take))
        byte, high = byte + 1, 7
        left -= take
    return parts


def _carrying(frames: Frames, rows: IntArray, message: Any, signal: Any) -> tuple[IntArray, int]:
    """Rows that carry a signal, and how many would but are too short to hold it.

    A multiplexed signal is there where its selector, and the selector of that, say so.
    """
    short = 0
    chain = [*_selectors(message, signal), signal]
    for above, below in itertools.pairwise(chain):
        whole = _long_enough(frames, rows, above)
        short += len(rows) - len(whole)
        rows = whole[np.isin(_raw(frames.data, whole, above), list(below.multiplexer_ids))]
    whole = _long_enough(frames, rows, signal)
    return whole, short + len(rows) - len(whole)


def _long_enough(frames: Frames, rows: IntArray, signal: Any) -> IntArray:
    last = max(byte for byte, _, _ in _bit_positions(signal))
    return rows[frames.length[rows] > last]


def _selectors(message: Any, signal: Any) -> list[Any]:
    """The multiplexers above a signal, the outermost first."""
    chain: list[Any] = []
    while signal.multiplexer_ids is not None and signal.multiplexer_signal:
        signal = message.get_signal_by_name(signal.multiplexer_signal)
        if signal in chain:
            raise SignalError(f"multiplexer {signal.name!r} of {message.name} selects itself")
        chain.insert(0, signal)
    return chain


def _raw(data: npt.NDArray[np.uint8], rows: IntArray, signal: Any) -> npt.NDArray[Any]:
    """Raw numbers: int64, uint64 for 64 unsigned bits, or float64."""
    word = np.zeros(len(rows), dtype=np.uint64)
    positions = _bit_positions(signal) if len(rows) else []
    for byte, right, take in positions:
        part = (data[rows, byte] >> np.uint8(right)) & np.uint8((1 << take) - 1)
        word = (word << np.uint64(take)) | part
    if signal.is_float:
        if signal.length == 32:
            return word.astype(np.uint32).view(np.float32).astype(np.float64)
        return word.view(np.float64)
    if signal.length == 64:
        return word.view(np.int64) if signal.is_signed else word
    number = word.view(np.int64)
    if signal.is_signed:
        number = number - ((number >> (signal.length - 1)) << signal.length)
    return number


def _put(data: npt.NDArray[np.uint8], signal: Any, value: npt.NDArray[np.float64]) -> None:
    """Write the physical `value` of each row into the bits of `signal`."""
    low, high = _raw_limits(signal)
    if signal.minimum is not None and signal.maximum is not None:
        low, high = max(low, signal.minimum), min(high, signal.maximum)
    clipped = np.clip(np.nan_to_num(value), min(low, high), max(low, high))
    raw = (clipped - signal.offset) / signal.scale
    if signal.is_float:
        kind = np.float32 if signal.length == 32 else np.float64
        word = raw.astype(kind).view(np.uint32 if signal.length == 32 else np.uint64)
        word = word.astype(np.uint64)
    else:
        word = np.rint(raw).astype(np.int64).view(np.uint64)
    right_of = 0
    for byte, right, take in reversed(_bit_positions(signal)):
        part = (word >> np.uint64(right_of)) & np.uint64((1 << take) - 1)
        data[:, byte] |= (part << np.uint64(right)).astype(np.uint8)
        right_of += take


def _raw_limits(signal: Any) -> tuple[float, float]:
    """What the bits can hold, in the unit of the signal."""
    if signal.is_float:
        return -np.inf, np.inf
    if signal.is_signed:
        raw = (-(2.0 ** (signal.length - 1)), 2.0 ** (signal.length - 1) - 1)
    else:
        raw = (0.0, 2.0**signal.length - 1)
    ends = sorted(end * signal.scale + signal.offset for end in raw)
    return ends[0], ends[1]


def invalid_codes(signal: Any) -> list[int]:
    """Raw values that the value table calls not valid."""
    choices = signal.choices or {}
    return [int(code) for code, name in choices.items() if _INVALID_NAME.search(str(name))]
