"""Recordings as :class:`DampingRun`: the channels that swing, on one even time axis.

Channels are named by the user, or taken by their names where they say what they are; with a
``signals.toml`` they are roles of it, in SI units. Units do not matter to frequency and damping.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from swaywatch.drive import Drive, load_drives
from swaywatch.errors import RecordingError, SignalError
from swaywatch.recording import Series, read_recording
from swaywatch.recording.dbc import Database, frames_by_identifier

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

FEWEST_SAMPLES = 16
"""Of a signal that are numbers."""

SWINGING = (
    "trailer_yaw_rate", "car_yaw_rate", "articulation", "trailer_lateral_acceleration",
    "car_lateral_acceleration",
)  # fmt: skip
"""Roles of a ``signals.toml`` whose swing is evaluated; those that are there."""

DRIVER = "steering_wheel_angle"
MOST_CHANNELS = 15

_SWINGS = re.compile(
    r"yaw.?rate|roll.?rate|lean.?rate|bank.?rate|steer.?rate|articulation|hitch.?angle|"
    r"side.?slip|roll.?angle|lean.?angle|bank.?angle|lateral.?acc|lat.?acc|^ay$|^acc_?y$|"
    r"(?:gier|wank).?(?:rate|geschw)|knick.?winkel|schwimm.?winkel|quer.?beschl|"
    r"gyro.?(?:[xz]|roll|yaw)$|^[pr]$|^beta$|"
    r"(?:roll|yaw|lean|phi|psi).?(?:dot|vel|velocity)$|^d_?(?:phi|psi)$|omega.?[xz]$|w[xz]$",
    re.IGNORECASE,
)
_ANGLES = re.compile(r"(?:^|[_.\s])(?:roll|bank|lean|phi|yaw|psi)(?:$|[_.\s])", re.IGNORECASE)
"""Names that say an angle at most: taken where none says more."""
_INTEGRAL = re.compile(r"(.+?)[_.\s]?angle$", re.IGNORECASE)
_RATES = ("rate", "velocity", "vel", "dot")
_SPEED = re.compile(
    r"(?:^|_|\b)(?:speed|velocity|airspeed|tas|cas|ias|vx|v_x|v)(?:$|_|\b)|speed$|"
    r"^(?:fahr)?geschwindigkeit",
    re.IGNORECASE,
)
_INPUT_LIKE = re.compile(
    r"rudder|aileron|pedal|stick|delta_?[ar]\b|wheel_?angle|hand_?wheel|hand_?angle|handle|torque|"
    r"steer(?!.*rate)|push|force",
    re.IGNORECASE,
)
_DRIVER_NAME = re.compile(
    r"steer(ing)?_?wheel_?angle|hand_?wheel|lenkrad|pilot|stick|yoke|rudder|aileron|delta_?[ar]\b",
    re.IGNORECASE,
)
"""Names of what a driver or pilot moves, taken as inputs where none is named: what a damper adds to
a rudder decays with the swing and is recognised as its own."""

_BETWEEN_NAME = re.compile(r"articulation|(?:hitch|fork).?angle|knick.?winkel", re.IGNORECASE)
"""Names of angles between two bodies, taken as what swings along where none is named."""

NO_SIGNAL = "none"
"""Name that says that no signal is an input, or swings along."""


@dataclass(frozen=True)
class DampingRun:
    """One recording.

    Attributes
    ----------
    time_s : shape (n,)
        Even, from 0.
    step_s
        Between two rows.
    value : shape (n, channels)
        In the units of the file (of the role, with a ``signals.toml``).
    valid : shape (n,)
        False where a channel has a gap.
    inputs : shape (n, inputs)
        What the driver or pilot does.
    against : shape (n,) or None
        What damping is drawn over: speed, or what the user names.
    may_drive
        Other signals of the file whose names are those of an input.
    along_names, along : shape (n, signals)
        Angles that swing along: not evaluated, but every free swing has the same share of them.
        NaN where they have a gap.
    """

    name: str
    path: Path
    time_s: FloatArray
    step_s: float
    channels: tuple[str, ...]
    units: tuple[str, ...]
    value: FloatArray
    valid: BoolArray
    input_names: tuple[str, ...]
    inputs: FloatArray
    against: FloatArray | None
    against_name: str
    against_unit: str
    may_drive: tuple[str, ...] = ()
    along_names: tuple[str, ...] = ()
    along: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def duration_s(self) -> float:
        """From the first to the last row."""
        return float(self.time_s[-1])

    @property
    def missing_s(self) -> float:
        """Time for which a channel has no values."""
        return float(np.sum(~self.valid)) * self.step_s

    def rows(self, start_s: float, end_s: float) -> slice:
        """Rows between two times, both ends in."""
        first = max(0, round(start_s / self.step_s))
        last = min(len(self.time_s) - 1, round(end_s / self.step_s))
        return slice(first, max(first, last + 1))


@dataclass(frozen=True)
class Choice:
    """Which signals are meant; empty: by their names."""

    channels: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    against: str | None = None
    signals: Path | None = None
    dbc: tuple[Path, ...] = ()
    along: tuple[str, ...] = ()


def load_runs(paths: Sequence[Path], choice: Choice) -> list[DampingRun]:
    """Read recordings.

    Raises
    ------
    SwaywatchError
        A file cannot be read, or a signal is not in it: names it and those that are.
    """
    if choice.signals is not None:
        return _role_runs(paths, choice, choice.signals)
    database = Database(list(choice.dbc)) if choice.dbc else None
    return [_run(Path(path), _signals(Path(path), database), choice) for path in paths]


def _signals(path: Path, database: Database | None) -> dict[str, Series]:
    recording = read_recording(path)
    if recording.signals is not None:
        return recording.signals
    assert recording.frames is not None
    if database is None:
        raise SignalError(
            f"{path}: holds CAN frames; name a --dbc to decode them, or a --signals signals.toml"
        )
    rows = frames_by_identifier(recording.frames)
    found: dict[str, Series] = {}
    for name in database.signal_names:
        pair = database.find(name)
        if pair is None:
            continue
        message, signal = pair
        own = rows.get((message.frame_id, message.is_extended_frame))
        if own is not None:
            found[name] = database.decode(recording.frames, own, message, signal).series
    return found


def _role_runs(paths: Sequence[Path], choice: Choice, signals: Path) -> list[DampingRun]:
    runs = []
    for path in paths:
        (drive,) = load_drives([path], signals, join=True)
        if not choice.channels and not any(name in drive.channels for name in SWINGING):
            raise SignalError(
                f"{signals}: none of the roles {', '.join(SWINGING)} is in {path}; name channels "
                "with --channel"
            )
        runs.append(run_of(drive, choice))
    return runs


def run_of(drive: Drive, choice: Choice | None = None) -> DampingRun:
    """A drive by its roles: what swings, the driver's wheel, the speed.

    Raises
    ------
    SwaywatchError
        A role that is named, or any that swings, is not in it.
    """
    choice = choice or Choice()
    series = {
        name: Series(np.rint(channel.time_s * 1e9).astype(np.int64), channel.value, channel.unit)
        for name, channel in drive.channels.items()
    }
    wanted = choice.channels or tuple(name for name in SWINGING if name in series)
    inputs = choice.inputs or ((DRIVER,) if DRIVER in series else ())
    against = choice.against or ("speed" if "speed" in series else None)
    return _run(Path(drive.files[0]), series, Choice(wanted, inputs, against, along=choice.along))


def _usable(path: Path, name: str, series: Series) -> Series:
    """Finite samples in rising order of time."""
    good = np.isfinite(series.value)
    good[1:] &= np.diff(series.time_ns) > 0
    if int(good.sum()) < FEWEST_SAMPLES:
        raise RecordingError(
            f"{path}: {name} has {int(good.sum())} samples that are numbers; {FEWEST_SAMPLES} are "
            "the least"
        )
    return Series(series.time_ns[good], series.value[good], series.unit)


def _pick(path: Path, signals: dict[str, Series], names: Sequence[str]) -> list[Series]:
    missing = [name for name in names if name not in signals]
    if missing:
        there = ", ".join(list(signals)[:20])
        raise SignalError(f"{path}: no signal {missing[0]!r}. Signals there: {there}")
    return [_usable(path, name, signals[name]) for name in names]


def _moves(series: Series) -> bool:
    value = series.value[np.isfinite(series.value)]
    return len(value) >= FEWEST_SAMPLES and float(np.ptp(value)) > 0.0


def _stuck(path: Path, names: Sequence[str], signals: dict[str, Series]) -> RecordingError:
    """What to say of channels that could swing and do not."""
    which = ", ".join(f"{name} ({_held(signals[name])})" for name in names[:6])
    return RecordingError(
        f"{path}: nothing to evaluate, the signals that could oscillate are constant: {which}. A "
        "sensor that is not connected looks like this; name others with --channel"
    )


def _held(series: Series) -> str:
    value = series.value[np.isfinite(series.value)]
    if len(value) < FEWEST_SAMPLES:
        return f"{len(value)} samples that are numbers"
    return f"{value[0]:g} {series.unit}".strip() + " throughout"


def _has_rate(name: str, channels: Sequence[str]) -> bool:
    """Whether a channel is the rate of this angle: the same swing without the angle's drift."""
    angle = _INTEGRAL.match(name)
    if angle is None:
        return False
    rates = {re.sub(r"[_.\s]", "", f"{angle[1]}{rate}").lower() for rate in _RATES}
    return any(re.sub(r"[_.\s]", "", other).lower() in rates for other in channels)


def _by_name(path: Path, signals: dict[str, Series], choice: Choice) -> Choice:
    """The choice with what the user left open taken by the signals' names."""
    channels = choice.channels
    for pattern in (_SWINGS, _ANGLES):
        channels = channels or tuple(
            name for name, series in signals.items() if pattern.search(name) and _moves(series)
        )
    if not choice.channels:
        channels = tuple(name for name in channels if not _has_rate(name, channels))
    if not channels:
        still = [n for n in signals if any(p.search(n) for p in (_SWINGS, _ANGLES))]
        if still:
            raise _stuck(path, still, signals)
        there = ", ".join(list(signals)[:30])
        raise SignalError(
            f"{path}: no signal is called like something that swings (yaw rate, roll rate, lateral "
            f"acceleration, articulation ...); name some with --channel. Signals there: {there}"
        )
    if len(channels) > MOST_CHANNELS:
        raise SignalError(
            f"{path}: {len(channels)} channels; at most {MOST_CHANNELS} are evaluated jointly. "
            "Name some with --channel"
        )
    inputs = choice.inputs or tuple(
        name
        for name, series in signals.items()
        if _DRIVER_NAME.search(name) and name not in channels and _moves(series)
    )
    if inputs == (NO_SIGNAL,) and NO_SIGNAL not in signals:
        inputs = ()
    # the first channel is what the others' share is measured by
    along = choice.along or tuple(
        name
        for name, series in signals.items()
        if _BETWEEN_NAME.search(name) and name not in (channels[0], *inputs) and _moves(series)
    )
    if along == (NO_SIGNAL,) and NO_SIGNAL not in signals:
        along = ()
    speeds = [n for n in signals if _SPEED.search(n) and n not in (*channels, *inputs)]
    against = choice.against or (speeds[0] if speeds else None)
    return Choice(channels, inputs, against, along=along)


def _run(path: Path, signals: dict[str, Series], choice: Choice) -> DampingRun:
    choice = _by_name(path, signals, choice)
    swinging = _pick(path, signals, choice.channels)
    inputs = _pick(path, signals, choice.inputs)
    against = _pick(path, signals, [choice.against])[0] if choice.against else None
    along = _pick(path, signals, choice.along)
    first = max(int(series.time_ns[0]) for series in swinging)
    last = min(int(series.time_ns[-1]) for series in swinging)
    periods = [float(np.median(np.diff(series.time_ns))) * 1e-9 for series in swinging]
    step = max(periods)
    if (last - first) * 1e-9 < FEWEST_SAMPLES * step:
        raise RecordingError(
            f"{path}: the channels {', '.join(choice.channels)} have no time in common"
        )
    if not 1e-4 <= step <= 0.5:
        slow = choice.channels[int(np.argmax(periods))]
        raise RecordingError(
            f"{path}: {slow} has a sample every {step:g} s; 0.5 s to 0.1 ms can be evaluated"
        )
    count = int((last - first) * 1e-9 / step + 1e-9) + 1
    time_s = np.asarray(np.arange(count) * step, dtype=np.float64)
    valid = np.ones(count, dtype=np.bool_)
    columns = []
    for series in swinging:
        own = np.asarray((series.time_ns - first) * 1e-9, dtype=np.float64)
        columns.append(np.interp(time_s, own, series.value))
        valid &= _apart(time_s, own) <= 4.0 * step
    return DampingRun(
        path.stem if path.stem else str(path),
        path,
        time_s,
        step,
        tuple(choice.channels),
        tuple(series.unit for series in swinging),
        np.stack(columns, axis=1),
        valid,
        tuple(choice.inputs),
        _on(time_s, inputs, first),
        None if against is None else _on(time_s, [against], first)[:, 0],
        choice.against or "",
        "" if against is None else against.unit,
        tuple(
            name
            for name, series in signals.items()
            if _INPUT_LIKE.search(name)
            and name not in (*choice.channels, *choice.inputs)
            and _moves(series)
        ),
        tuple(choice.along),
        _without_gaps(time_s, along, first),
    )


def _apart(time_s: FloatArray, own_s: FloatArray) -> FloatArray:
    """Time between the samples before and behind each row, s."""
    after = np.clip(np.searchsorted(own_s, time_s - 1e-9), 1, len(own_s) - 1)
    return np.asarray(own_s[after] - own_s[after - 1])


def _without_gaps(time_s: FloatArray, series: Sequence[Series], first_ns: int) -> FloatArray:
    """Signals on the axis, NaN where one has a gap, is not yet there or no longer."""
    value = _on(time_s, series, first_ns)
    for column, s in enumerate(series):
        own = np.asarray((s.time_ns - first_ns) * 1e-9, dtype=np.float64)
        gap = _apart(time_s, own) > 4.0 * max(time_s[1], float(np.median(np.diff(own))))
        value[gap | (time_s < own[0] - 1e-9) | (time_s > own[-1] + 1e-9), column] = np.nan
    return value


def _on(time_s: FloatArray, series: Sequence[Series], first_ns: int) -> FloatArray:
    """Signals on the axis, shape (n, signals)."""
    columns = [np.interp(time_s, (s.time_ns - first_ns) * 1e-9, s.value) for s in series]
    return np.stack(columns, axis=1) if columns else np.zeros((len(time_s), 0))
