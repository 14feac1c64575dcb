"""Drives: recordings with their signals mapped to roles, in SI units.

``load_drives([files], signals.toml)`` reads the files and groups them: files that follow each
other in time, or that overlap with different signals (two loggers), are one drive; files that
overlap in time with the same signals are separate runs.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from swaywatch.errors import RecordingError, SignalError
from swaywatch.nearest import did_you_mean, with_known
from swaywatch.recording import Frames, Recording, Series, read_recording
from swaywatch.recording.dbc import Database, Decoded, frames_by_identifier
from swaywatch.roles import CHANNELS, SINGLE_ROLES, WHEEL_ROLES, WHEELS
from swaywatch.toml_file import load_toml, refuse_other_kind

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]

UNITS: dict[str, dict[str, float]] = {
    "rad": {"rad": 1.0, "deg": math.pi / 180, "mrad": 1e-3},
    "rad/s": {"rad/s": 1.0, "deg/s": math.pi / 180, "mrad/s": 1e-3},
    "m/s": {"m/s": 1.0, "km/h": 1 / 3.6, "mph": 0.44704, "knots": 1852 / 3600},
    "m/s2": {"m/s2": 1.0, "g": 9.80665, "mg": 9.80665e-3},
    "N": {"N": 1.0, "kN": 1e3, "daN": 10.0},
}
"""Known units for each SI unit, with their factor to it."""

_SPELLINGS = {
    "°": "deg", "degree": "deg", "degrees": "deg", "grad": "deg",
    "°/s": "deg/s", "deg/sec": "deg/s", "degree/s": "deg/s", "dps": "deg/s", "degrees/s": "deg/s",
    "rad/sec": "rad/s", "1/s": "rad/s", "radian": "rad", "radians": "rad",
    "kph": "km/h", "kmh": "km/h", "kmph": "km/h", "mps": "m/s", "kn": "kN", "kt": "knots",
    "m/s^2": "m/s2", "m/s²": "m/s2", "m/s**2": "m/s2", "m/ss": "m/s2", "mps2": "m/s2",
    "n": "N", "newton": "N", "dan": "daN",
}  # fmt: skip


LARGEST = 1e12
"""No factor and no place of a sensor is so far off."""
LONGEST_DELAY_S = 60.0
STANDS = 0.02
"""A clock stands where fewer samples than this part have a time of their own."""
SLOWEST_STEP_S = 5.0
"""Usual step of a signal from which on its time cannot be right: satellites give one a second."""
WILD = 1e4
"""A sample so many times beyond what a channel can reach is no measurement, in any unit."""


@dataclass(frozen=True)
class Mapping:
    """One channel of a signals.toml."""

    channel: str
    signals: tuple[str, ...]  # more than one: their mean
    position_m: float = 0.0
    unit: str | None = None  # overrides the file's
    factor: float = 1.0  # `sign` and `scale` of the mapping
    delay_s: float = 0.0  # taken off the timestamps


@dataclass(frozen=True)
class Channel:
    """Samples of one channel, SI units.

    Attributes
    ----------
    time_s : float64, shape (n,)
        Since the start of the drive.
    value : float64, shape (n,)
        In the unit of ``CHANNELS[name]``.
    signal, unit_in_file
        Where it came from.
    position_m
        Of an accelerometer, ahead of the body's COG.
    """

    name: str
    time_s: FloatArray
    value: FloatArray
    signal: str
    unit_in_file: str
    position_m: float = 0.0
    files: tuple[str, ...] = ()
    limits: tuple[float, float] = (-math.inf, math.inf)
    resolution: float = 0.0

    @property
    def unit(self) -> str:
        """SI unit."""
        return CHANNELS[self.name].unit


@dataclass(frozen=True)
class Grid:
    """Channels on one even time axis: time_s (n,), value and valid per channel (n,)."""

    rate_hz: float
    time_s: FloatArray
    value: dict[str, FloatArray]
    valid: dict[str, BoolArray]


@dataclass(frozen=True)
class Drive:
    """One drive with its channels; `missing` names roles mapped nowhere or without samples.

    `absent` says of channels for which a signal is named why there are no samples of it.
    """

    name: str
    files: tuple[Path, ...]
    channels: dict[str, Channel]
    start_ns: int
    remarks: tuple[str, ...] = field(default=())
    frames: int = 0
    formats: tuple[str, ...] = ()
    lost_frames: int = 0
    absent: dict[str, str] = field(default_factory=dict)

    @property
    def duration_s(self) -> float:
        """From the first to the last sample of any channel."""
        return max((float(c.time_s[-1]) for c in self.channels.values()), default=0.0)

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of all channels the drive does not have."""
        return tuple(name for name in CHANNELS if name not in self.channels)

    def resample(self, rate_hz: float = 100.0, max_gap_s: float = 0.1) -> Grid:
        """Linear interpolation on an even axis over the time all channels cover.

        Parameters
        ----------
        rate_hz
            Rate of the axis.
        max_gap_s
            Between samples farther apart (or twice the channel's own period, if that is more)
            the grid is not valid.
        """
        first = max(float(c.time_s[0]) for c in self.channels.values())
        last = min(float(c.time_s[-1]) for c in self.channels.values())
        start = math.ceil(first * rate_hz)
        time_s = np.arange(start, math.floor(last * rate_hz) + 1) / rate_hz
        value: dict[str, FloatArray] = {}
        valid: dict[str, BoolArray] = {}
        for name, channel in self.channels.items():
            value[name] = np.interp(time_s, channel.time_s, channel.value)
            step = np.diff(channel.time_s)
            limit = max(max_gap_s, 2.0 * float(np.median(step))) if len(step) else max_gap_s
            after = np.clip(np.searchsorted(channel.time_s, time_s), 1, len(channel.time_s) - 1)
            valid[name] = (channel.time_s[after] - channel.time_s[after - 1]) <= limit
        return Grid(rate_hz, time_s, value, valid)


def load_drives(
    paths: Sequence[Path | str], signals: Path | str, *, join: bool | None = None
) -> list[Drive]:
    """Read recordings and map their signals to roles.

    Parameters
    ----------
    paths
        Recordings of any format.
    signals
        A ``signals.toml``.
    join
        True: all files are one drive; False: each is its own; None: by their times (see above).

    Returns
    -------
    list of Drive
        At least one.

    Raises
    ------
    SwaywatchError
        Names file, role, signal and what would be right.
    """
    if not paths:
        raise RecordingError("no recording given")
    signals = Path(signals)
    mappings, dbc_paths = load_signals(signals)
    database = Database(dbc_paths) if dbc_paths else None
    pieces = [_read_piece(Path(path), signals, mappings, database) for path in paths]
    return [_joined(group, signals) for group in _groups(pieces, join)]


def load_drive(paths: Sequence[Path | str], signals: Path | str) -> Drive:
    """Read recordings that are one drive, whatever their times say."""
    return load_drives(paths, signals, join=True)[0]


def load_signals(path: Path) -> tuple[list[Mapping], list[Path]]:
    """Mappings and DBC files of a ``signals.toml``.

    Raises
    ------
    SignalError
        An unknown role, a wheel role without four signals, ...
    """
    content = load_toml(path, SignalError, "signals.toml")
    refuse_other_kind(path, content, SignalError, "signals.toml")
    unknown = sorted(set(content) - {"dbc", "signals"})
    if unknown:
        hint = with_known(unknown[0], ("dbc", "signals"))
        raise SignalError(f"{path}: unknown key {unknown[0]!r}{hint}")
    table = content.get("signals")
    if not isinstance(table, dict):
        raise SignalError(f'{path}: no [signals] table; e.g. speed = "VehicleSpeed"')
    if not table:
        raise SignalError(
            f"{path}: [signals] is empty: no signal is assigned to a role; e.g. speed = "
            '"VehicleSpeed" (`swaywatch roles` lists the roles)'
        )
    mappings = read_mappings(path, table)
    dbc = content.get("dbc", [])
    names = [dbc] if isinstance(dbc, str) else dbc
    if not isinstance(names, list) or not all(isinstance(n, str) and n.strip() for n in names):
        raise SignalError(f"{path}: dbc must be a path or a list of paths, got {repr(dbc)[:60]}")
    return mappings, [path.parent / name for name in dict.fromkeys(names)]


def read_mappings(
    path: Path, table: Any, name: str = "signals", known: Collection[str] | None = None
) -> list[Mapping]:
    """Mappings of a table of roles.

    Parameters
    ----------
    path, name
        File and table, for messages.
    table
        Its content.
    known
        Names of roles beyond the four of a wheel role (default: those of a recording).

    Raises
    ------
    SignalError
        An unknown role, a wheel role without four signals, ...
    """
    roles = SINGLE_ROLES if known is None else known
    if not isinstance(table, dict):
        raise SignalError(f"{path}: [{name}] must be a table of roles")
    mappings: list[Mapping] = []
    for role, entry in table.items():
        if role in WHEEL_ROLES:
            if not isinstance(entry, list) or len(entry) != len(WHEELS):
                raise SignalError(
                    f"{path}: {role} needs four signals in the order [FL, FR, RL, RR], "
                    f"got {entry!r}"
                )
            for wheel, part in zip(WHEELS, entry, strict=True):
                if part not in ("", None):
                    mappings.append(_mapping(path, f"{role}_{wheel}", part))
        elif role in CHANNELS or role in roles:
            mappings.append(_mapping(path, role, entry))
        else:
            hint = with_known(role, (*roles, *WHEEL_ROLES))
            raise SignalError(f"{path}: [{name}] unknown role {role!r}{hint}")
    return mappings


def _mapping(path: Path, channel: str, entry: Any) -> Mapping:
    if isinstance(entry, str) or (isinstance(entry, list) and channel == "speed"):
        return Mapping(channel, _names(path, channel, entry))
    known = {"signal", "position", "unit", "sign", "scale", "delay"}
    if not isinstance(entry, dict) or "signal" not in entry or set(entry) - known:
        raise SignalError(
            f"{path}: {channel} = {entry!r} is not understood; write a signal name, or "
            "{ signal = ..., position = m, unit = ..., sign = -1, scale = ..., delay = s }"
        )
    numbers = _mapping_numbers(path, channel, entry)
    unit = entry.get("unit")
    if unit is not None and not isinstance(unit, str):
        kind = CHANNELS.get(channel)
        options = ", ".join(UNITS[kind.unit]) if kind else "a unit such as N"
        raise SignalError(f"{path}: {channel}: unit = {unit!r} must be one of: {options}")
    return Mapping(
        channel,
        _names(path, channel, entry["signal"]),
        numbers["position"],
        unit,
        numbers["sign"] * numbers["scale"],
        numbers["delay"],
    )


def _mapping_numbers(path: Path, channel: str, entry: dict[str, Any]) -> dict[str, float]:
    """Position, sign, scale and delay of a mapping, each within its range."""
    numbers = {"position": 0.0, "sign": 1.0, "scale": 1.0, "delay": 0.0}
    for key, default in list(numbers.items()):
        value = entry.get(key, default)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise SignalError(f"{path}: {channel}: {key} = {value!r} must be a number")
        if not abs(value) < LARGEST:
            shown = str(value)[:40]
            raise SignalError(f"{path}: {channel}: {key} = {shown} must be a finite number")
        numbers[key] = float(value)
    if numbers["sign"] not in (1.0, -1.0):
        raise SignalError(f"{path}: {channel}: sign = {numbers['sign']:g} must be 1 or -1")
    if numbers["scale"] == 0.0:
        raise SignalError(f"{path}: {channel}: scale = 0 makes every sample 0; expected a factor")
    if not abs(numbers["delay"]) <= LONGEST_DELAY_S:
        raise SignalError(
            f"{path}: {channel}: delay = {numbers['delay']:g} s must be within "
            f"+-{LONGEST_DELAY_S:g} s"
        )
    if not abs(numbers["position"]) <= 15.0:
        raise SignalError(
            f"{path}: {channel}: position = {numbers['position']:g} m must be within +-15 m of "
            "the COG"
        )
    return numbers


def _names(path: Path, channel: str, entry: Any) -> tuple[str, ...]:
    """The signals of a mapping: a name, or a list of names to average."""
    names = tuple(entry) if isinstance(entry, list) else (entry,)
    if not names or not all(isinstance(name, str) and name.strip() for name in names):
        shown = repr(entry)[:60]
        raise SignalError(
            f"{path}: {channel}: signal = {shown} must be the name of a signal, or a list of names "
            "to average"
        )
    return names


@dataclass(frozen=True, eq=False)
class _Piece:
    """What one file contributes."""

    recording: Recording
    samples: dict[str, tuple[Mapping, Series, str, tuple[float, float], float]]
    remarks: tuple[str, ...]
    start_ns: int
    end_ns: int
    absent: dict[str, str]  # channel -> why a signal that is named for it is not there


def _read_piece(
    path: Path, signals: Path, mappings: list[Mapping], database: Database | None
) -> _Piece:
    recording = read_recording(path)
    remarks = [f"{path.name}: {note}" for note in recording.notes]
    source: _Source
    if recording.frames is not None:
        if database is None:
            raise SignalError(
                f"{signals}: {path} holds CAN frames, but no DBC to decode them is named; add e.g. "
                'dbc = "measurement.dbc" above [signals]'
            )
        source = _FrameSource(path, signals, recording.frames, database)
    else:
        assert recording.signals is not None
        source = _SignalSource(path, signals, recording.signals)
    samples = {}
    unknown: list[str] = []
    absent: dict[str, str] = {}
    for mapping in mappings:
        parts = [source.get(name, mapping.channel) for name in mapping.signals]
        if any(part is None for part in parts):
            names = [n for n, part in zip(mapping.signals, parts, strict=True) if part is None]
            absent[mapping.channel] = f"{names[0]!r} {source.why_absent(names[0])}"
            unknown += names
            continue
        series, limits, resolution = _mean([part for part in parts if part is not None])
        if len(series.time_ns) < 2:
            count = len(series.time_ns)
            absent[mapping.channel] = f"{mapping.signals[0]!r} has {count or 'no'} valid sample"
            remarks.append(f"{path.name}: {absent[mapping.channel].replace(chr(39), '')}")
            continue
        name = " + ".join(mapping.signals)
        samples[mapping.channel] = (mapping, series, name, limits, resolution)
    remarks += source.remarks
    if not samples:
        raise SignalError(source.nothing_found(unknown))
    if unknown:
        remarks.append(f"{path.name}: not in this recording: {', '.join(unknown)}")
    losses = (
        (recording.error_frames, "error frames on the bus"),
        (recording.dropped_frames, "frames lost by the logger"),
    )
    remarks += [f"{path.name}: {count} {what}" for count, what in losses if count]
    start = min(int(entry[1].time_ns[0]) for entry in samples.values())
    end = max(int(entry[1].time_ns[-1]) for entry in samples.values())
    return _Piece(recording, samples, tuple(remarks), start, end, absent)


_Part = tuple[Series, tuple[float, float], float]


class _Source:
    """Where samples of a named signal come from."""

    def __init__(self, path: Path, signals: Path) -> None:
        self.path = path
        self.signals = signals
        self.remarks: list[str] = []

    def get(self, name: str, channel: str) -> _Part | None:
        raise KeyError(name)

    def nothing_found(self, names: list[str]) -> str:
        raise KeyError(str(names))

    def why_absent(self, name: str) -> str:
        """What to say of a signal that is named and not there."""
        return "is not in the recording"


class _SignalSource(_Source):
    """Decoded signals of an MF4, CSV or Parquet."""

    def __init__(self, path: Path, signals: Path, series: dict[str, Series]) -> None:
        super().__init__(path, signals)
        self._series = series

    def get(self, name: str, channel: str) -> _Part | None:
        series = self._series.get(name)
        if series is None:
            return None
        finite = np.isfinite(series.value)
        if not finite.all():
            self.remarks.append(
                f"{self.path.name}: {name}: {int((~finite).sum())} of {len(finite)} samples are "
                "not numbers, left out"
            )
            series = Series(series.time_ns[finite], series.value[finite], series.unit)
        return series, (-math.inf, math.inf), 0.0

    def nothing_found(self, names: list[str]) -> str:
        there = ", ".join(list(self._series)[:12])
        return (
            f"{self.path}: none of the signals that {self.signals} names is in it "
            f"({', '.join(names[:6])}, ...). Signals there: {there}"
        )


class _FrameSource(_Source):
    """CAN frames, decoded by a DBC."""

    def __init__(self, path: Path, signals: Path, frames: Frames, database: Database) -> None:
        super().__init__(path, signals)
        self._frames = frames
        self._database = database
        self._rows = frames_by_identifier(frames)
        self._bus_chosen: set[str] = set()

    def get(self, name: str, channel: str) -> _Part | None:
        pair = self._database.find(name)
        if pair is None:
            dbcs = ", ".join(str(path) for path in self._database.paths)
            raise SignalError(
                f"{self.signals}: {channel} = {name!r}, but {dbcs} has no such signal"
                + did_you_mean(name, self._database.signal_names)
            )
        message, signal = pair
        rows = self._rows_of(message)
        if rows is None:
            return None
        rows = self._one_bus(rows, message.name)
        decoded = self._database.decode(self._frames, rows, message, signal)
        self._judge(name, message, decoded, len(rows))
        low, high = decoded.raw_limits
        if decoded.low is not None and decoded.high is not None:
            low, high = max(low, decoded.low), min(high, decoded.high)
        return decoded.series, (low, high), abs(float(signal.scale))

    def why_absent(self, name: str) -> str:
        """Its message was not sent."""
        pair = self._database.find(name)
        assert pair is not None
        message = pair[0]
        return f"is in message {message.name} (0x{message.frame_id:X}), of which no frame is there"

    def _rows_of(self, message: Any) -> IntArray | None:
        """Rows of a message; a J1939 one of the DBC (source 0xFE: any) matches by its PGN."""
        rows = self._rows.get((message.frame_id, message.is_extended_frame))
        if rows is not None or not message.is_extended_frame or message.frame_id & 0xFF != 0xFE:
            return rows
        group = (message.frame_id >> 8) & 0x3FFFF
        found = [
            part
            for (identifier, extended), part in self._rows.items()
            if extended and (identifier >> 8) & 0x3FFFF == group
        ]
        if not found:
            return None
        if len(found) > 1 and message.name not in self._bus_chosen:
            self._bus_chosen.add(message.name)
            self.remarks.append(
                f"{self.path.name}: message {message.name} comes from {len(found)} sources; the "
                "one that sends most often is used"
            )
        return max(found, key=len)

    def _one_bus(self, rows: IntArray, message: str) -> IntArray:
        """Rows of the bus that carries most of them: a gateway may repeat a message elsewhere."""
        buses, counts = np.unique(self._frames.bus[rows], return_counts=True)
        if len(buses) == 1:
            return rows
        best = int(buses[np.argmax(counts)])
        if message not in self._bus_chosen:
            self._bus_chosen.add(message)
            self.remarks.append(
                f"{self.path.name}: message {message} is on buses {buses.tolist()}; bus {best} used"
            )
        kept: IntArray = rows[self._frames.bus[rows] == best]
        return kept

    def _judge(self, name: str, message: Any, decoded: Decoded, count: int) -> None:
        """Refuse what shows that the DBC is another bus's; remark on the rest."""
        dbcs = ", ".join(str(path) for path in self._database.paths)
        if decoded.short_frames > count // 2:
            raise SignalError(
                f"{self.path}: {dbcs} does not fit: frames of {message.name} "
                f"(0x{message.frame_id:X}) are too short to hold {name!r} "
                f"({decoded.short_frames} of {count})"
            )
        if decoded.out_of_range > count // 2:
            raise SignalError(
                f"{self.path}: {dbcs} does not fit: {decoded.out_of_range} of {count} samples of "
                f"{name!r} are outside its range {decoded.low:g} to {decoded.high:g} "
                f"{decoded.series.unit}"
            )
        for number, what in (
            (decoded.marked_invalid, "marked not valid by the sender"),
            (decoded.out_of_range, f"outside {decoded.low} to {decoded.high}"),
            (decoded.short_frames, "in frames that are too short"),
        ):
            if number:
                self.remarks.append(
                    f"{self.path.name}: {name}: {number} of {count} samples {what}, left out"
                )

    def nothing_found(self, names: list[str]) -> str:
        dbcs = ", ".join(str(path) for path in self._database.paths)
        there = ", ".join(f"0x{identifier:X}" for identifier, _ in list(self._rows)[:10])
        return (
            f"{self.path}: {dbcs} does not match this recording: none of the messages that carry "
            f"{', '.join(names[:6])} is in it. Identifiers there: {there}"
        )


def _mean(parts: list[_Part]) -> _Part:
    """Mean of several signals on the times of the first."""
    if len(parts) == 1:
        return parts[0]
    first = parts[0][0]
    total = first.value.copy()
    for series, _, _ in parts[1:]:
        if series.unit != first.unit:
            raise SignalError(
                f"signals to average have units {first.unit!r} and {series.unit!r}; one expected"
            )
        total += np.interp(first.time_ns, series.time_ns, series.value)
    return Series(first.time_ns, total / len(parts), first.unit), parts[0][1], parts[0][2]


def _groups(pieces: list[_Piece], join: bool | None) -> list[list[_Piece]]:
    """Which pieces are one drive."""
    if join is not None:
        return [pieces] if join else [[piece] for piece in pieces]
    groups: list[list[_Piece]] = []
    for piece in sorted(pieces, key=lambda p: p.start_ns):
        for group in groups:
            if _belongs(piece, group):
                group.append(piece)
                break
        else:
            groups.append([piece])
    groups.sort(key=lambda group: min(pieces.index(piece) for piece in group))
    return groups


def _belongs(piece: _Piece, group: list[_Piece]) -> bool:
    """Follows the group within a minute, or overlaps it with other signals."""
    end = max(other.end_ns for other in group)
    if 0 <= piece.start_ns - end <= 60_000_000_000:
        return True
    overlapping = [o for o in group if o.start_ns < piece.end_ns and piece.start_ns < o.end_ns]
    return bool(overlapping) and all(not set(o.samples) & set(piece.samples) for o in overlapping)


def _joined(group: list[_Piece], signals: Path) -> Drive:
    """One drive from its pieces, in SI units."""
    start_ns = min(piece.start_ns for piece in group)
    channels: dict[str, Channel] = {}
    for name in CHANNELS:
        entries = [
            (piece, *piece.samples[name])
            for piece in sorted(group, key=lambda p: p.start_ns)
            if name in piece.samples
        ]
        if entries:
            channels[name] = _channel(name, entries, start_ns, signals)
    remarks = tuple(remark for piece in group for remark in piece.remarks)
    names = list(dict.fromkeys(piece.recording.path.stem for piece in group))
    return Drive(
        "+".join(names),
        tuple(piece.recording.path for piece in group),
        channels,
        start_ns,
        remarks,
        sum(_count(piece.recording) for piece in group),
        tuple(dict.fromkeys(piece.recording.format for piece in group)),
        sum(piece.recording.dropped_frames for piece in group),
        {
            name: reason
            for piece in group
            for name, reason in piece.absent.items()
            if name not in channels
        },
    )


def _count(recording: Recording) -> int:
    """Frames, or samples of decoded signals."""
    if recording.frames is not None:
        return len(recording.frames)
    return sum(len(series.time_ns) for series in (recording.signals or {}).values())


def _channel(name: str, entries: list[Any], start_ns: int, signals: Path) -> Channel:
    times: list[FloatArray] = []
    values: list[FloatArray] = []
    for piece, mapping, series, signal, _, _ in entries:
        path = piece.recording.path
        factor = mapping.factor * unit_factor(
            name, mapping.unit or series.unit, signal, path, signals
        )
        times.append((series.time_ns - start_ns) * 1e-9 - mapping.delay_s)
        values.append(series.value * factor)
        _must_be_measured(name, signal, values[-1], path, signals)
    piece, mapping, series, signal, limits, resolution = entries[0]
    time_s, value = np.concatenate(times), np.concatenate(values)
    count = len(time_s)
    if np.any(np.diff(time_s) <= 0):
        rising = np.concatenate([[True], time_s[1:] > np.maximum.accumulate(time_s)[:-1]])
        time_s, value = time_s[rising], value[rising]
    _must_run(signal, time_s, count, piece.recording.path)
    unit = mapping.unit or series.unit
    factor = mapping.factor * unit_factor(name, unit, signal, piece.recording.path, signals)
    ends = sorted(limit * factor for limit in limits)
    return Channel(
        name,
        time_s,
        value,
        signal,
        unit,
        mapping.position_m,
        tuple(dict.fromkeys(entry[0].recording.path.name for entry in entries)),
        (ends[0], ends[1]),
        resolution * abs(factor),
    )


def _must_run(signal: str, time_s: FloatArray, count: int, path: Path) -> None:
    """Refuse a clock that stands, or is too slow for any motion of a vehicle: another unit."""
    if len(time_s) < STANDS * count:
        raise SignalError(
            f"{path}: the clock stopped: of the {count} samples of signal {signal!r} only "
            f"{len(time_s)} have a time of their own"
        )
    step_s = float(np.median(np.diff(time_s))) if len(time_s) > 2 else 0.0
    if step_s > SLOWEST_STEP_S:
        raise SignalError(
            f"{path}: signal {signal!r} has a sample every {step_s:.3g} s, which shows no motion "
            "of a vehicle; if its time is in ms or us, name it time_ms or time_us"
        )


def _must_be_measured(name: str, signal: str, value: FloatArray, path: Path, signals: Path) -> None:
    """Refuse a sample that no sensor gives, in whatever unit: 1e155 is damage."""
    kind = CHANNELS[name]
    limit = WILD * max(abs(kind.low), abs(kind.high))
    worst = int(np.argmax(np.abs(value)))
    if not abs(value[worst]) <= limit:
        raise SignalError(
            f"{path}: signal {signal!r} ({name}) reaches {value[worst]:g} {kind.unit} at sample "
            f"{worst + 1} of {len(value)}; expected {kind.low:g} to {kind.high:g} {kind.unit}. The "
            f"file is damaged, or the unit or scale in {signals} is wrong"
        )


def canonical_unit(unit: str) -> str:
    """A unit in the spelling of :data:`UNITS`, where it is known."""
    text = unit.strip()
    return _SPELLINGS.get(text, _SPELLINGS.get(text.lower(), text))


def unit_factor(name: str, unit: str, signal: str, path: Path, signals: Path) -> float:
    """Factor from the unit in the file to SI."""
    known = UNITS[CHANNELS[name].unit]
    text = canonical_unit(unit)
    if text in known:
        return known[text]
    options = ", ".join(known)
    if not text:
        raise SignalError(
            f"{path}: signal {signal!r} ({name}) has no unit; add it in {signals}: "
            f'{name} = {{ signal = "{signal}", unit = "{next(iter(known))}" }} (known: {options})'
        )
    raise SignalError(
        f"{path}: signal {signal!r} has the unit {unit!r}, but {name} needs one of: {options}. "
        f"Is it the right signal? Otherwise set `unit = ...` in {signals}"
    )
