"""Free oscillations of a recording: where they begin and end, and what the core says of each.

1. Energy: the channels, band-passed for this step only, each in units of its own quiet level. Where
   it rises far above that, something happened (a push, a gust, the driver).
2. Window: behind the rise, the earliest start from which one damped line, the same in all channels,
   leaves no more than the quiet signal would; the end is where its envelope sinks into that. A long
   decay gives several windows one after the other; a growing swing is taken before its end.
3. Forced or free: what an input of the driver adds to the swing within the window, against what it
   had given before it (both turned back by the line: the share of its own mode).

A recording without any quiet time (one decay, cut out by hand) is taken as it is; one so short that
a swing fills most of it is measured by its quietest cycle, and asked for more. Where the driver is
recorded and his own pulses begin the swings, these tell where each begins, however weakly they are
damped: no quiet time is needed then.

An input that falls with the swing, by the swing's own line, follows it: a damper or controller (or
the driver's own answer), which belongs to what is measured. A driver who forces a swing does not.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage, signal

from swaywatch.damping.acts import Act, acts_of
from swaywatch.damping.data import DampingRun
from swaywatch.damping.freed import GAIN_UNCERTAINTY, without_input
from swaywatch.damping.window import NO_OSCILLATION, Estimator, Line

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.int64]

RISE = 3.0
"""RMS over one cycle in units of the quiet RMS, all channels together, that makes an event."""

VISIBLE = 2.0
"""RMS of a swing in units of the quiet RMS, at the larger end of a window."""

SLOWEST = 4.0
"""Rows a swing needs in one cycle: a line of fewer looks like its mirror image (of 3.3 rows
none is found, of 2.9 one that grows)."""

SHORTEST, LONGEST = 1.0, 6.0
"""Length of a window in cycles."""

LOCAL = 3.0
"""Cycles of a window where no longer one is one damped line."""

SHORT = 2.5
"""Windows of one channel with fewer cycles are fitted without a slope, which would take part of
the swing; where several channels share the line, that does not happen."""

PART = 2.0
"""Cycles of the parts of a window that tell how its damping goes with the amplitude."""

EIGHTH = 0.125
"""Of a cycle: by which windows are moved to see what the choice does."""

FADED = math.exp(-2.0)
"""Part of its first amplitude at which a window ends: two time constants, which hold nearly all
that is to be known of the damping; below that, other motion counts."""

LEFT_OVER = 1.6
"""Residual of a window in units of the quiet signal's, up to which it is one damped line."""

EXPLAINED = 0.95
"""Share of the motion that a line explains where the quiet level does not decide."""

FORCED_SHARE = 0.25
"""Part of the swing that the driver may add within the window."""

FOLLOWS = 0.9
"""Share of an input's power that the swing's own line explains where it follows the swing."""

FOLLOWED_CYCLES = 2.0
"""Cycles for which it has to do so."""

SCARCE = 40.0
"""Cycles of a recording up to which a swing may fill most of it."""

SCARCE_RISE, SCARCE_CYCLES = 5.0, 2.0
"""Rise over the quietest cycle, and cycles that one line has to explain, in such a recording."""

FREED_TWICE = 2
"""Times the input's part is taken out: the line without it tells it better."""

MOST_QUIET = 200
"""Quiet windows of one length that are looked at, evenly over a long recording."""

_QUIET_PERCENTILE = 25.0
_QUIET_POWER = 0.288
"""25th percentile of the power of a narrow-band process over its mean: -ln 0.75."""


@dataclass(frozen=True)
class SwingWindow:
    """One window of an oscillation, with the same line over windows a little beside it.

    Attributes
    ----------
    line
        The core's.
    beside
        The lines of windows that end sooner or later.
    later
        The line of a window that begins an eighth of a cycle later; None where it cannot.
    rest
        RMS of what the line leaves, in units of the quiet signal's; NaN where that is not known.
    freed : shape (rows, channels) or None
        The window's samples without the input's part; None: nothing was taken out.
    parts
        The lines of its parts of PART cycles or more, one after the other.
    """

    line: Line
    beside: tuple[Line, ...]
    later: Line | None
    rest: float
    freed: FloatArray | None = None
    parts: tuple[Line, ...] = ()


@dataclass(frozen=True)
class Event:
    """Something that happened, and the windows of one damped line in it.

    Attributes
    ----------
    peak_s
        Where the energy is highest.
    windows
        One after the other; empty: not one damped line.
    forced_by
        The input that drives it, or "".
    share
        Part of the swing that the inputs added within the first window; 0 without any.
    limit_s
        Where the next event begins.
    followed_by
        The input that follows it, or "".
    """

    peak_s: float
    rise: float
    windows: tuple[SwingWindow, ...]
    forced_by: str = ""
    share: float = 0.0
    limit_s: float = math.inf
    followed_by: str = ""


@dataclass(frozen=True)
class Found:
    """All that was found in a run.

    Attributes
    ----------
    quiet : bool, shape (n,)
        Rows away from every event.
    level : shape (channels,)
        Quiet RMS of the band-passed channels; 0 where there is no quiet time.
    """

    run: DampingRun
    events: tuple[Event, ...]
    quiet: BoolArray
    level: FloatArray
    frequency_hz: float
    band_hz: tuple[float, float] = field(default=(0.2, 10.0))


def find(run: DampingRun, band_hz: tuple[float, float], estimator: Estimator) -> Found:
    """Events of a run and their windows.

    Parameters
    ----------
    run
        A recording.
    band_hz
        Lowest and highest frequency of a line.
    """
    return _Finder(run, band_hz, estimator).found()


class _Measure(NamedTuple):
    """By what a swing is measured: quiet RMS of every channel, rise over it, quiet rows."""

    level: FloatArray
    rise: FloatArray
    quiet: BoolArray


class _Finder:
    """One run on its way through the three steps."""

    def __init__(self, run: DampingRun, band_hz: tuple[float, float], estimator: Estimator) -> None:
        self.run = run
        self.estimator = estimator
        rate = 1.0 / run.step_s
        self.band = (band_hz[0], min(band_hz[1], rate / SLOWEST))
        self.smooth = _band_passed(run.value, rate, self.band)
        self.frequency = _dominant(self.smooth, run.step_s, self.band)
        self.level, self.rise = self._energy(self.frequency)
        for _ in range(2):  # the frequency of what is loud, not of the drift between
            loud = np.clip(self.rise / RISE - 0.5, 0.0, 1.0)[:, None] * self.smooth / self.level
            if not loud.any():
                break
            self.frequency = _dominant(loud, run.step_s, self.band)
            self.level, self.rise = self._energy(self.frequency)
        self._rests: dict[int, FloatArray] = {}
        self.quiet = self._quiet_rows()
        self.acts = acts_of(run, self.frequency)

    # --- energy ------------------------------------------------------------------------------

    def _energy(self, frequency_hz: float) -> tuple[FloatArray, FloatArray]:
        """Quiet RMS of each channel, and the RMS of all in units of it at every row."""
        rows = max(3, round(1.0 / (frequency_hz * self.run.step_s)))
        power = ndimage.uniform_filter1d(self.smooth**2, rows, axis=0, mode="nearest")
        good = self.run.valid[:, None] & _moves(self.run.value, rows)
        quiet = np.array(
            [
                np.percentile(power[own, k], _QUIET_PERCENTILE) if own.any() else 0.0
                for k, own in enumerate(good.T)
            ]
        )
        quiet /= _QUIET_POWER
        floor = 1e-8 * np.maximum(np.max(power, axis=0), 1e-300)
        level = np.sqrt(np.maximum(quiet, floor))
        return level, np.sqrt(np.max(power / level**2, axis=1))

    def _quiet_rows(self) -> BoolArray:
        """Rows away from events: a cycle before the rise to four cycles behind the last of it."""
        loud = (self.rise >= RISE) | ~self.run.valid
        cycle = 1.0 / (self.frequency * self.run.step_s)
        before, behind = round(1.5 * cycle), round(3.0 * cycle)
        spread = np.convolve(loud, np.ones(before + behind + 1))
        # a loud row blots out `before` rows before it and `behind` rows behind it
        near: BoolArray = spread[before : before + len(loud)] > 0.5
        return ~near

    def quiet_starts(self, rows: int) -> IntArray:
        """First rows of quiet windows of a length, half overlapping."""
        return quiet_starts(self.quiet, rows)

    def _rest(self, rows: int) -> FloatArray:
        """RMS of a quiet window about mean and slope, per channel; empty where there is none."""
        if rows not in self._rests:
            starts = self.quiet_starts(rows)
            if len(starts) > MOST_QUIET:
                starts = starts[np.linspace(0, len(starts) - 1, MOST_QUIET).astype(np.int64)]
            line = np.linspace(-1.0, 1.0, rows)
            base, _ = np.linalg.qr(np.stack([np.ones(rows), line], axis=1))
            power = [self._beside_line(base, k) for k in starts]
            self._rests[rows] = np.sqrt(np.mean(power, axis=0)) if len(power) >= 2 else np.zeros(0)
        return self._rests[rows]

    def _beside_line(self, base: FloatArray, first: int) -> FloatArray:
        """Mean square of every channel beside mean and slope (`base`) from a row on."""
        value = self.run.value[first : first + len(base)]
        value = value - value.mean(axis=0)
        rest = value - base @ (base.T @ value)
        return np.asarray(np.mean(rest**2, axis=0))

    # --- events ------------------------------------------------------------------------------

    def found(self) -> Found:
        first = _Measure(self.level, self.rise, self.quiet)
        by_energy = self._found(self._by_energy())
        self._measure_again(first)
        behind = self._behind_acts()
        if not behind:
            return by_energy
        by_acts = self._found(behind)
        return by_acts if _free_cycles(by_acts) > _free_cycles(by_energy) else by_energy

    def _found(self, events: list[Event]) -> Found:
        events = self._judged(events)
        return Found(self.run, tuple(events), self.quiet, self.level, self.frequency, self.band)

    def _by_energy(self) -> list[Event]:
        peaks = self._peaks(RISE)
        events = self._events(peaks) if len(peaks) else self._whole()
        if not any(event.windows for event in events):
            events = self._scarce() or events
        return events

    def _behind_acts(self) -> list[Event]:
        """Swings that the driver's pulses began, where one goes on into the next.

        Only where what counts as quiet may be a swing itself; of each swing more is asked than of
        one that stands out of quiet time. It is taken where it finds more than the energy does.
        """
        quietest = self._quietest()
        if quietest is None or not self.acts:
            return []
        if np.min(self.level / quietest) < SCARCE_RISE:
            return []
        self._measure_by(quietest)
        ends = [act.start_s for act in self.acts[1:]] + [self.run.duration_s]
        found = [self._behind(act, end) for act, end in zip(self.acts, ends, strict=True)]
        return [event for event in found if event is not None]

    def _behind(self, act: Act, limit_s: float) -> Event | None:
        """The swing between two acts of the driver."""
        rows = self.run.rows(act.end_s, min(limit_s, act.end_s + 3.0 / self.frequency))
        if rows.stop - rows.start < 8:
            return None
        seed = self._seed(rows.start, rows.stop - 1)
        windows = self._chain(act.end_s, limit_s, seed)
        if sum(window.line.cycles for window in windows) < SCARCE_CYCLES:
            return None
        rise = self._size(windows[0].line, windows[0].line.start_s)
        if rise < SCARCE_RISE:
            return None
        return Event(windows[0].line.start_s, rise, tuple(windows), limit_s=limit_s)

    def _peaks(self, height: float) -> IntArray:
        """Rows where the energy is highest, each that many times above the quiet level.

        Nothing is before the recording or behind it, so it may begin or end in a swing.
        """
        distance = max(1, round(1.2 / (self.frequency * self.run.step_s)))
        energy = np.pad(np.log(np.maximum(self.rise, 1e-6)), 1, constant_values=-20.0)
        peaks, _ = signal.find_peaks(
            energy, height=math.log(height), distance=distance, prominence=math.log(1.4)
        )
        return np.asarray(peaks - 1, dtype=np.int64)

    def _events(self, peaks: IntArray) -> list[Event]:
        events: list[Event] = []
        valleys = [0]
        for before, after in itertools.pairwise(peaks):
            valleys.append(int(before + np.argmin(self.rise[before : after + 1])))
        valleys.append(len(self.rise) - 1)
        done_s = -math.inf
        for index, peak in enumerate(peaks):
            low, high = valleys[index], valleys[index + 1]
            windows = self._decay(int(peak), low, high, done_s)
            if not windows:
                windows = self._growth(int(peak), low)
            if windows:
                done_s = windows[-1].line.start_s + windows[-1].line.length_s
            events.append(
                Event(
                    float(self.run.time_s[peak]), float(self.rise[peak]), tuple(windows),
                    limit_s=self._limit(high),
                )
            )  # fmt: skip
        return events

    def _seed(self, first: int, last: int) -> float:
        """Frequency with most energy between two rows, channels in units of their quiet level."""
        part = self.smooth[first : last + 1] / self.level
        return _dominant(part, self.run.step_s, self.band)

    def _line(
        self, start_s: float, length_s: float, frequency_hz: float, level: bool | None = None
    ) -> Line | None:
        """One window; without a slope if it is SHORT, or as `level` says."""
        if level is None:
            level = length_s * frequency_hz < SHORT and len(self.level) == 1
        rows = self.run.rows(start_s, start_s + length_s)
        if rows.stop - rows.start < 8 or not self.run.valid[rows].all():
            return None
        line = self.estimator.line(
            self.run.value[rows], float(self.run.time_s[rows.start]), self.run.step_s, frequency_hz,
            level=level,
        )  # fmt: skip
        if line is None or not self.band[0] <= line.frequency_hz <= self.band[1]:
            return None
        return line

    def _until(self, line: Line, limit_s: float) -> float:
        """Where the envelope is down to FADED or the quiet level, within LONGEST cycles."""
        start = line.start_s
        longest = start + LONGEST / line.frequency_hz
        if line.growth_1_s < 0.0:
            falls = max(1.0, min(1.0 / FADED, self._size(line, start)))
            longest = min(longest, start + math.log(falls) / -line.growth_1_s)
        shortest = start + SHORTEST / line.frequency_hz
        return min(max(longest, shortest), limit_s)

    def _size(self, line: Line, time_s: float) -> float:
        """RMS of the swing at a time in units of the quiet level, all channels together."""
        return float(np.sqrt(np.mean((line.size(time_s) / self.level) ** 2 / 2.0)))

    def rest_of(self, line: Line) -> float:
        """RMS of a line's residual in units of the quiet signal's; NaN if that is not known."""
        rest = self._rest(max(8, round(line.length_s / self.run.step_s)))
        if not len(rest):
            return math.nan
        return float(np.sqrt(np.mean((line.noise / np.maximum(rest, 1e-300)) ** 2)))

    def accepts(self, line: Line | None) -> bool:
        """One damped line, as far as the residual can say."""
        if line is None or not line.converged() or line.cycles < 0.95 * SHORTEST:
            return False
        if line.omega_se_rad_s > 0.15 * line.omega_rad_s:
            return False
        rest = self.rest_of(line)
        share = self.share(line)
        if math.isnan(rest):
            return share >= EXPLAINED and not line.flags & NO_OSCILLATION
        return (rest <= LEFT_OVER and share >= 0.5) or share >= EXPLAINED

    def share(self, line: Line) -> float:
        """Part of the motion that a line explains in the channel that stands out most."""
        time = line.start_s + (np.arange(64) + 0.5) / 64 * line.length_s
        power = np.mean(line.size(time) ** 2, axis=0) / 2.0
        best = int(np.argmax(power / self.level**2))
        return float(power[best] / max(float(power[best] + line.noise[best] ** 2), 1e-300))

    def _decay(self, peak: int, low: int, high: int, done_s: float) -> list[SwingWindow]:
        """Windows behind a peak."""
        cycle = 1.0 / self.frequency
        behind = min(high, peak + round(2.0 * cycle / self.run.step_s))
        seed = self._seed(max(low, peak - round(0.5 * cycle / self.run.step_s)), behind)
        limit = self._limit(high)
        return self._chain(max(self._turn(peak, low, high, seed), done_s), limit, seed)

    def _chain(self, begin_s: float, limit: float, seed_hz: float) -> list[SwingWindow]:
        """Windows one after the other, the first as soon behind `begin_s` as one fits."""
        first = self._first(begin_s, limit, seed_hz)
        windows: list[SwingWindow] = []
        while first is not None:
            windows.append(self._with_beside(first, limit))
            start = first.start_s + first.length_s
            if (
                first.frequency_hz * (limit - start) < SHORTEST
                or self._size(first, start) < VISIBLE
            ):
                break
            first = self._next(start, limit, first.frequency_hz)
        return windows

    def _next(self, start_s: float, limit_s: float, seed_hz: float) -> Line | None:
        """The window that begins where the one before ends, if it is one damped line."""
        for longest in (math.inf, LOCAL):
            line = self._sized(start_s, min(limit_s, start_s + longest / seed_hz), seed_hz)
            if self.accepts(line):
                return line
        return None

    def _limit(self, high: int) -> float:
        """Up to where the swing is alone: the mean energy begins to rise half a cycle early."""
        time = self.run.time_s
        if high >= len(time) - 1:
            return float(time[-1])
        return float(time[high]) + 0.35 / self.frequency

    def _sized(self, start_s: float, limit_s: float, seed_hz: float) -> Line | None:
        """A line from `start_s` on whose window ends where its own envelope does."""
        frequency, length = seed_hz, 2.0 / seed_hz
        line: Line | None = None
        for _ in range(3):
            length = min(length, limit_s - start_s)
            if length * frequency < 0.95 * SHORTEST:
                return None
            line = self._line(start_s, length, frequency)
            if line is None:
                return None
            wanted = self._until(line, limit_s) - start_s
            if abs(wanted - length) < 0.1 * length:
                break
            frequency, length = line.frequency_hz, wanted
        return line

    def _turn(self, peak: int, low: int, high: int, seed_hz: float) -> float:
        """Time at which the first of the channels turns back from its largest value."""
        half = round(0.6 / seed_hz / self.run.step_s)
        first, last = max(low, peak - half), min(high, peak + half) + 1
        size = np.abs(self.smooth[first:last]) / self.level
        largest = size.max(axis=0)
        clear = largest >= 0.3 * float(largest.max())
        return float(self.run.time_s[first + int(np.min(np.argmax(size, axis=0)[clear]))])

    def _first(self, begin_s: float, limit_s: float, seed_hz: float) -> Line | None:
        """The earliest start within a cycle from which one damped line goes on.

        Where none does, for a few cycles only: damping that depends on the amplitude (friction,
        free play) is one line over a short part of the decay.
        """
        starts = begin_s + np.arange(0.0, 1.01, 0.0625) / seed_hz
        for longest in (math.inf, LOCAL):
            for start in starts:
                limit = min(limit_s, float(start) + longest / seed_hz)
                line = self._sized(float(start), limit, seed_hz)
                if line is not None and self.accepts(line):
                    return line
        return None

    def _with_beside(self, line: Line, limit_s: float) -> SwingWindow:
        """The same line from windows that end sooner or later, and that begin later."""
        cycle = 1.0 / line.frequency_hz
        beside = []
        for longer in (-0.15, 0.15):
            length = max(line.length_s * (1.0 + longer), 0.9 * SHORTEST * cycle)
            other = self._other(line, line.start_s, length, limit_s)
            if other is not None:
                beside.append(other)
        later = self._other(line, line.start_s + EIGHTH * cycle, line.length_s, limit_s)
        return SwingWindow(line, tuple(beside), later, self.rest_of(line), parts=self._parts(line))

    def _parts(self, line: Line) -> tuple[Line, ...]:
        """The window in equal parts, each a line of its own; itself where it is short."""
        count = int(line.cycles / PART + 0.05)
        if count < 2:
            return (line,)
        length = line.length_s / count
        parts = [
            self._line(line.start_s + k * length, length, line.frequency_hz, line.level)
            for k in range(count)
        ]
        return tuple(part for part in parts if part is not None and part.converged())

    def _other(self, line: Line, start_s: float, length_s: float, limit_s: float) -> Line | None:
        """The line of another window, if it is there and settles."""
        if start_s + length_s > limit_s + 0.5 / line.frequency_hz:
            return None
        other = self._line(start_s, length_s, line.frequency_hz, line.level)
        return other if other is not None and other.converged() else None

    def _growth(self, peak: int, low: int) -> list[SwingWindow]:
        """A window before a peak, if the swing grew into it for more than a cycle and a half."""
        time = self.run.time_s
        end = float(time[peak])
        seed = self._seed(max(low, peak - round(3.0 / self.frequency / self.run.step_s)), peak)
        for cycles in (4.0, 3.0, 2.0, 1.6):
            start = end - cycles / seed
            if start < float(time[low]):
                continue
            line = self._line(start, cycles / seed, seed)
            if line is not None and line.growth_1_s > 0.0 and self.accepts(line):
                return [self._with_beside(line, end)]
        return []

    def _whole(self) -> list[Event]:
        """A recording with no event: windows of three cycles in which a line explains nearly all.

        Only where the whole of it is such a swing: then no quiet level is known.
        """
        cycle = 1.0 / self.frequency
        length = 3.0 * cycle
        windows: list[SwingWindow] = []
        count = 0
        start = 0.0
        self._rests.clear()
        self.quiet = np.zeros_like(self.quiet)
        while start + length <= self.run.duration_s + 0.5 * self.run.step_s:
            line = self._line(start, length, self.frequency)
            count += 1
            if line is not None and self.accepts(line):
                windows.append(self._with_beside(line, self.run.duration_s))
            start += length
        if not windows or len(windows) < 0.6 * count:
            self.quiet = self._quiet_rows()
            return []
        return [Event(windows[0].line.start_s, 0.0, tuple(windows))]

    def _scarce(self) -> list[Event]:
        """A short recording that a swing fills: by its quietest cycle; no quiet level is known."""
        quietest = self._quietest()
        if self.run.duration_s * self.frequency > SCARCE or quietest is None:
            return []
        kept = self._measure_by(quietest)
        events = self._events(self._peaks(SCARCE_RISE))
        cycles = [sum(window.line.cycles for window in event.windows) for event in events]
        if len(events) != 1 or cycles[0] < SCARCE_CYCLES:  # several are what goes on all the time
            events = []
        if not events:
            self._measure_again(kept)
        return events

    def _quietest(self) -> FloatArray | None:
        """RMS of each channel in the quietest cycle; None where there are gaps."""
        if not self.run.valid.all():
            return None
        rows = max(3, round(1.0 / (self.frequency * self.run.step_s)))
        power = ndimage.uniform_filter1d(self.smooth**2, rows, axis=0, mode="nearest")
        most = np.maximum(power.max(axis=0), 1e-300)
        at = int(np.argmin(np.sum(power / most, axis=1)))
        return np.asarray(np.sqrt(np.maximum(power[at], 1e-8 * most)), dtype=np.float64)

    def _measure_by(self, level: FloatArray) -> _Measure:
        """Take this as the quiet level, and no row as quiet; gives what it was."""
        kept = _Measure(self.level, self.rise, self.quiet)
        rows = max(3, round(1.0 / (self.frequency * self.run.step_s)))
        power = ndimage.uniform_filter1d(self.smooth**2, rows, axis=0, mode="nearest")
        rise = np.sqrt(np.max(power / level**2, axis=1))
        self._measure_again(_Measure(level, rise, np.zeros_like(self.quiet)))
        return kept

    def _measure_again(self, kept: _Measure) -> None:
        self.level, self.rise, self.quiet = kept
        self._rests.clear()

    # --- forced or free ----------------------------------------------------------------------

    def _judged(self, events: list[Event]) -> list[Event]:
        """Events with what the inputs have to do with them."""
        if not self.run.input_names:
            return events
        drives = [self._drive(event, event) for event in events]
        known = [drive for drive in drives if drive is not None]
        judged = []
        for event, drive in zip(events, drives, strict=True):
            if drive is None:
                judged.append(event)
                continue
            share, which = self._share(drive, known)
            act = self._act_within(event)
            if act is not None or share > FORCED_SHARE:
                which = which if act is None else act.which
                judged.append(self._after_the_input(event, known, share, which))
            else:
                judged.append(replace(event, share=share))
        return [self._freed(event) for event in judged]

    def _freed(self, event: Event) -> Event:
        """The same windows without what the input that began the swing adds within them."""
        if not event.windows or event.forced_by or event.followed_by:
            return event
        own = self._drive(event, event)
        assert own is not None
        which = int(np.argmax(own.before / np.maximum(np.ptp(self.run.inputs, axis=0), 1e-300)))
        limit = min(event.limit_s, self.run.duration_s)
        run, windows = self.run, event.windows
        for _ in range(FREED_TWICE):
            freed = without_input(run, windows[0].line, which, limit)
            if freed is None:
                return event
            first = run.rows(windows[0].line.start_s, limit).start
            value = run.value.copy()
            value[first : first + len(freed.samples)] = freed.samples
            self.run = replace(run, value=value)
            again = [self._again(window.line, limit) for window in windows]
            self.run = run
            kept = itertools.takewhile(lambda window: window is not None, again)
            windows = tuple(window for window in kept if window is not None)
            if not windows:
                return event
        # behind the first window the same hand may be more than what is left of the swing
        count = 1
        for window in windows[1:]:
            rows = run.rows(window.line.start_s, window.line.start_s + window.line.length_s)
            if freed is None or not freed.little(rows.start - first, rows.stop - first):
                break
            count += 1
        return replace(event, windows=windows[:count], share=GAIN_UNCERTAINTY * event.share)

    def _again(self, line: Line, limit_s: float) -> SwingWindow | None:
        """The window of a line, estimated on what is now in the run."""
        other = self._line(line.start_s, line.length_s, line.frequency_hz, line.level)
        if other is None or not other.converged():
            return None
        rows = self.run.rows(line.start_s, line.start_s + line.length_s)
        return replace(self._with_beside(other, limit_s), freed=self.run.value[rows])

    def _act_within(self, event: Event) -> Act | None:
        """An act of the driver that reaches into the first window by more than EIGHTH cycle."""
        line = event.windows[0].line
        margin = EIGHTH / line.frequency_hz
        begin, end = line.start_s + margin, line.start_s + line.length_s - margin
        return next((a for a in self.acts if a.end_s > begin and a.start_s < end), None)

    def _after_the_input(
        self, event: Event, known: Sequence[_Drive], share: float, which: int
    ) -> Event:
        """The same swing from later on, where the input is still or follows it; else forced."""
        line = event.windows[0].line
        name = self.run.input_names[which]
        if self._follows(line, which):
            return replace(event, followed_by=name)
        for cycles in (0.25, 0.5, 0.75, 1.0, 1.5, 2.0):
            begin = line.start_s + cycles / line.frequency_hz
            windows = self._chain(begin, min(event.limit_s, self.run.duration_s), line.frequency_hz)
            later = replace(event, windows=tuple(windows))
            drive = self._drive(later, event)
            if drive is None:
                break
            rest, _ = self._share(drive, known)
            if rest <= FORCED_SHARE and self._act_within(later) is None:
                return replace(later, share=rest)
            if self._follows(later.windows[0].line, which):
                return replace(later, followed_by=name)
        return replace(event, forced_by=name, share=share)

    def _follows(self, line: Line, which: int) -> bool:
        """An input falls as the swing does, by the swing's own line, for two cycles or more.

        A swing that does not fall tells nothing here: a driver who goes on and on looks the same.
        Nor does one cycle, nor a swing that is over in one: the last turn of a slalom, and then
        none, looks like a decay there.
        """
        length = max(line.length_s, FOLLOWED_CYCLES / line.frequency_hz)
        if (
            -line.growth_1_s * length < 1.0
            or -line.growth_1_s > -math.log(FADED) * line.frequency_hz
        ):
            return False
        rows = self.run.rows(line.start_s, line.start_s + length)
        part = self.run.inputs[rows, which]
        part = part - part.mean()
        time = self.run.time_s[rows] - line.mid_s
        wave = np.exp((line.growth_1_s + 1j * line.omega_rad_s) * time)
        columns = np.stack([wave.real, wave.imag, np.ones(len(time))], axis=1)
        rest = part - columns @ np.linalg.lstsq(columns, part, rcond=None)[0]
        return float(rest @ rest) <= (1.0 - FOLLOWS) * float(part @ part)

    def _drive(self, event: Event, whole: Event) -> _Drive | None:
        """What each input gave to the mode before and within the first window.

        Before: from two cycles before the windows of the `whole` event on.
        """
        if not event.windows:
            return None
        line = event.windows[0].line
        s = complex(line.growth_1_s, line.omega_rad_s)
        cycle = 1.0 / line.frequency_hz
        length = min(line.length_s, 2.0 * cycle)
        rows = max(4, round(length / self.run.step_s))
        # what is driven grows because it is driven: there late input counts as early input does
        s = complex(min(s.real, 0.0), s.imag)
        noise = [self._modal(k * self.run.step_s, length, s) for k in self.quiet_starts(rows)[:40]]
        first = whole.windows[0].line.start_s - 2.0 * cycle
        return _Drive(
            before=self._modal(first, line.start_s - first, s, backward=True),
            within=self._modal(line.start_s, length, s),
            noise=np.percentile(noise, 75, axis=0) if len(noise) >= 4 else np.zeros(1),
            size=self._size(line, line.start_s),
        )

    def _modal(
        self, start_s: float, length_s: float, s: complex, backward: bool = False
    ) -> FloatArray:
        """Largest |integral of the input times e^(-s (t - t0))| over a cycle; t0: where both meet.

        Of one cycle, so that an input that goes on (a slalom) gives as much within as before,
        however long each is.
        """
        rows = self.run.rows(max(0.0, start_s), start_s + length_s)
        part = self.run.inputs[rows]
        if len(part) < 4:
            return np.zeros(self.run.inputs.shape[1])
        part = part - np.median(part, axis=0)
        time = np.arange(len(part)) * self.run.step_s
        if backward:
            time = time - time[-1]
        wave = np.exp(np.clip(-s.real * time, -3.0, 3.0) - 1j * s.imag * time)
        rising = np.cumsum(wave[:, None] * part, axis=0)
        sums = np.concatenate([np.zeros((1, part.shape[1])), rising])
        cycle = min(len(part), max(4, round(2 * math.pi / (s.imag * self.run.step_s))))
        most = np.abs(sums[cycle:] - sums[:-cycle]).max(axis=0)
        return np.asarray(most * self.run.step_s, dtype=np.float64)

    def _share(self, drive: _Drive, others: Sequence[_Drive]) -> tuple[float, int]:
        """The largest share of an input in the swing, and which input."""
        shares = []
        for which in range(len(self.run.input_names)):
            quiet = float(drive.noise[which]) if which < len(drive.noise) else 0.0
            if drive.within[which] <= 3.0 * quiet or drive.within[which] <= 0.0:
                shares.append(0.0)
                continue
            gains = [
                float(d.before[which]) / d.size
                for d in others
                if d.before[which] > 3.0 * (d.noise[which] if which < len(d.noise) else 0.0)
            ]
            given = max(
                float(drive.before[which]), float(np.median(gains)) * drive.size if gains else 0.0
            )
            shares.append(float(drive.within[which]) / max(given, 1e-300))
        best = int(np.argmax(shares))
        return min(shares[best], 99.0), best


def _free_cycles(found: Found) -> float:
    """Cycles of free swings that stand out of a quiet level."""
    events = [event for event in found.events if event.rise > 0.0 and not event.forced_by]
    return sum(window.line.cycles for event in events for window in event.windows)


@dataclass(frozen=True)
class _Drive:
    """What inputs gave to a mode: before a window, within it, in quiet; the swing's size."""

    before: FloatArray
    within: FloatArray
    noise: FloatArray
    size: float


def quiet_starts(quiet: BoolArray, rows: int) -> IntArray:
    """First rows of windows of `rows` quiet rows, half overlapping."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], quiet.astype(np.int8), [0]])))
    starts = [
        np.arange(first, last - rows + 1, max(1, rows // 2))
        for first, last in zip(edges[::2], edges[1::2], strict=True)
    ]
    return np.concatenate([np.zeros(0, dtype=np.int64), *starts]).astype(np.int64)


def _moves(value: FloatArray, rows: int) -> BoolArray:
    """Where a channel is not the same for `rows` rows and more: a stuck sensor is not quiet."""
    still = (np.diff(value, axis=0, prepend=np.nan) == 0.0).astype(np.int8)
    width = rows | 1  # odd, so that closing in from both sides is symmetric
    core = ndimage.minimum_filter1d(still, width, axis=0, mode="nearest")
    stuck = ndimage.maximum_filter1d(core, width, axis=0, mode="nearest") > 0
    return np.asarray(~stuck, dtype=np.bool_)


def _band_passed(value: FloatArray, rate_hz: float, band_hz: tuple[float, float]) -> FloatArray:
    """Zero-phase, half an octave wider than the band on both sides."""
    low, high = band_hz[0] / 1.5, min(band_hz[1] * 1.5, 0.45 * rate_hz)
    middle = value - np.median(value, axis=0)
    sections = signal.butter(2, [low, high], btype="bandpass", fs=rate_hz, output="sos")
    pad = min(len(value) - 1, int(2 * rate_hz / low))
    out = signal.sosfiltfilt(sections, middle, axis=0, padlen=pad)
    return np.asarray(out, dtype=np.float64)


def _dominant(value: FloatArray, step_s: float, band_hz: tuple[float, float]) -> float:
    """Frequency with most energy per octave in the band, channels at equal weight."""
    count = len(value)
    size = np.maximum(np.sqrt(np.mean(value**2, axis=0)), 1e-300)
    points = max(1024, 1 << (2 * count - 1).bit_length())
    power = np.sum(np.abs(np.fft.rfft(value / size, points, axis=0)) ** 2, axis=1)
    frequency = np.fft.rfftfreq(points, step_s)
    resolution = 1.0 / (count * step_s)
    width = max(1.0, 0.12 * band_hz[0] / (frequency[1] - frequency[0]), resolution / frequency[1])
    power = ndimage.gaussian_filter1d(power, min(width, 200.0)) * frequency
    inside = (frequency >= band_hz[0]) & (frequency <= band_hz[1])
    if not inside.any():
        return math.sqrt(band_hz[0] * band_hz[1])
    return float(frequency[inside][np.argmax(power[inside])])


Progress = Callable[[str, float, float], None]
