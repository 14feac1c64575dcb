"""How sure each window is: what white noise, the quiet signal and the choice of window do to it.

A free oscillation comes on top of what the vehicle does anyway (road, wind, its own control). That
part is the same before and behind, so the quiet windows of the recording say what it does to the
fit: the fit's sensitivity applied to each of them gives the scatter of growth and frequency. Where
there is too little quiet time, what the line leaves within its own band tells it (``ambient.py``).
What the estimate moves by when the window ends sooner or later is added. What it moves by when the
window begins later is another thing: the same in every repeat (damping that depends on amplitude, a
second motion that dies out beside this one), so it is kept apart as ``later``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy import stats

from swaywatch.damping.ambient import ambient_covariance
from swaywatch.damping.find import Event, Found, SwingWindow, quiet_starts
from swaywatch.damping.shape import Shape, shape_of
from swaywatch.damping.window import Line, damping_error, sensitivity

FloatArray = npt.NDArray[np.float64]

FEWEST_QUIET = 6
"""Quiet windows from which their scatter is believed."""

HIGHEST = math.sqrt(0.5)
"""Damping ratio that an interval must not reach to be stated: from there on nothing resonates, a
motion is over within half a cycle, and what creeps back (overdamped) is fitted by such a line."""

_MOST_QUIET = 80
_WEAK = 0.2
"""Half-width of the 95 % interval of a damping ratio above which it is not determinable."""


@dataclass(frozen=True)
class IntervalValue:
    """A number, its standard error, and the limits of its 95 % interval.

    Attributes
    ----------
    ends
        By what it moves if the window ends 15 % later (of half the change from 15 % sooner): no
        scatter, for it may be the same in every repeat (see `mean_of`).
    """

    value: float
    error: float
    freedom: float
    ends: float = 0.0

    @property
    def half(self) -> float:
        """Half-width of the 95 % interval."""
        return float(stats.t.ppf(0.975, self.freedom)) * self.error

    @property
    def low(self) -> float:
        """Lower limit of 95 %."""
        return self.value - self.half

    @property
    def high(self) -> float:
        """Upper limit of 95 %."""
        return self.value + self.half


def known(ratio: IntervalValue) -> bool:
    """A damping ratio is known to 0.2 or better."""
    return ratio.half <= _WEAK


def too_high(ratio: IntervalValue) -> bool:
    """It is known, and so high that the motion may be overdamped."""
    return known(ratio) and ratio.high >= HIGHEST


@dataclass(frozen=True)
class SwingPart:
    """A part of a window: its damping ratio and the size of the swing in it.

    Attributes
    ----------
    amplitude, noise : shape (channels,)
        In its middle; RMS of what its line leaves.
    fall
        ln of the amplitude at its end over that at its begin.
    """

    damping_ratio: IntervalValue
    amplitude: FloatArray
    noise: FloatArray
    fall: float


@dataclass(frozen=True)
class Point:
    """One window of free oscillation.

    Attributes
    ----------
    number
        Of its oscillation in the run, from 1; windows of one oscillation share it.
    start_s, end_s
        Of the window.
    against
        Mean of the speed (or what the user named) over the window; NaN where there is none.
    amplitude : shape (channels,)
        At the begin of the window.
    share
        What the inputs added to the swing within the window, of the swing.
    later : shape (3,)
        By what damping ratio, frequency and growth change if the window begins an eighth of a
        cycle later; NaN where it cannot.
    quiet_known
        The recording was quiet for long enough to say what the quiet motion does to the fit; else
        that is inferred from what the line leaves.
    parts
        How its damping goes with the size of the swing.
    shape
        How other signals swing along; None: none is named, or that cannot be determined.
    """

    run: str
    number: int
    start_s: float
    end_s: float
    against: float
    damping_ratio: IntervalValue
    frequency_hz: IntervalValue
    growth_1_s: IntervalValue
    amplitude: FloatArray
    cycles: float
    share: float
    later: FloatArray
    quiet_known: bool = True
    parts: tuple[SwingPart, ...] = ()
    shape: Shape | None = None

    @property
    def determinable(self) -> bool:
        """The damping ratio is known to 0.2 or better, and is surely that of a swing."""
        return known(self.damping_ratio) and not too_high(self.damping_ratio)


def points_of(found: Found) -> list[Point]:
    """Every window of free oscillation of a run with its interval, in order of time."""
    points = []
    number = 0
    for event in found.events:
        if event.forced_by:
            continue
        own = [point_of(found, event, window, number + 1) for window in event.windows]
        own = [point for point in own if _swings(event, point)]
        number += bool(own)
        points += own
    return points


def _swings(event: Event, point: Point) -> bool:
    """It is surely an oscillation (95 %).

    What rises into the peak without growing for certain was pushed there; what may as well grow as
    creep back is any motion. A decay that may as well be steady stays: leaving out those that come
    out below zero would bias the mean.
    """
    ratio = point.damping_ratio
    if 0.5 * (point.start_s + point.end_s) < event.peak_s and ratio.high >= 0.0:
        return False
    return not (ratio.low < 0.0 and ratio.high > 1.0)


def sure(found: Found) -> Found:
    """The same without windows that are not surely an oscillation."""
    events = [
        replace(
            event,
            windows=tuple(w for w in event.windows if _swings(event, point_of(found, event, w, 1))),
        )
        for event in found.events
    ]
    return replace(found, events=tuple(events))


def point_of(found: Found, event: Event, window: SwingWindow, number: int) -> Point:
    """A window with its interval; `number`: of its oscillation."""
    line = window.line
    run = found.run
    covariance, freedom = _covariance(found, line, _samples(found, window))
    forced = _pushed(event, line)
    size = math.hypot(line.growth_1_s, line.omega_rad_s)

    def value(name: str, variance: float, pushed: float) -> IntervalValue:
        middle = float(getattr(line, name))
        moved = [float(getattr(other, name)) - middle for other in window.beside]
        beside = float(np.mean(np.square(moved))) if moved else 0.0
        ends = 0.5 * (moved[1] - moved[0]) if len(moved) == 2 else 0.0
        return IntervalValue(middle, math.sqrt(variance + beside + pushed), freedom, ends)

    rows = run.rows(line.start_s, line.start_s + line.length_s)
    against = math.nan if run.against is None else float(np.mean(run.against[rows]))
    turn = (2 * math.pi) ** 2
    starts = _quiet_windows(found, line)
    return Point(
        run.name,
        number,
        line.start_s,
        line.start_s + line.length_s,
        against,
        value("damping_ratio", damping_error(line, covariance) ** 2, forced),
        value("frequency_hz", float(covariance[1, 1]) / turn, forced * size**2 / turn),
        value("growth_1_s", float(covariance[0, 0]), forced * size**2),
        line.size(line.start_s),
        line.cycles,
        event.share,
        _later(window),
        len(starts) >= FEWEST_QUIET,
        tuple(_part(found, event, window, part) for part in window.parts),
        _shape(found, window, starts),
    )


def _shape(found: Found, window: SwingWindow, starts: npt.NDArray[np.int64]) -> Shape | None:
    """How other signals swing along; not where an input is taken out of the channels alone."""
    if window.freed is not None or len(starts) < FEWEST_QUIET:
        return None
    return shape_of(found.run, window.line, _some(starts))


def _pushed(event: Event, line: Line) -> float:
    """Variance of the damping ratio from what the inputs added.

    The share is that of the first window; a smaller swing gets as much input.
    """
    first = event.windows[0].line
    ratio = first.size(first.start_s) / np.maximum(line.size(line.start_s), 1e-300)
    share = event.share * max(1.0, float(np.median(ratio)))
    return (share / (2 * math.pi * max(line.cycles, 1.0))) ** 2


def _samples(found: Found, window: SwingWindow) -> FloatArray:
    """What the line of a window was estimated on."""
    if window.freed is not None:
        return window.freed
    run, line = found.run, window.line
    rows = max(8, round(line.length_s / run.step_s))
    first = max(0, min(round(line.start_s / run.step_s), len(run.value) - rows))
    return run.value[first : first + rows]


def _part(found: Found, event: Event, window: SwingWindow, line: Line) -> SwingPart:
    """A part of a window with its interval."""
    step = found.run.step_s
    samples = _samples(found, window)
    rows = max(8, round(line.length_s / step))
    first = max(0, min(round((line.start_s - window.line.start_s) / step), len(samples) - rows))
    covariance, freedom = _covariance(found, line, samples[first : first + rows])
    error = math.sqrt(damping_error(line, covariance) ** 2 + _pushed(event, line))
    return SwingPart(
        IntervalValue(line.damping_ratio, error, freedom), line.size(line.mid_s), line.noise,
        line.growth_1_s * line.length_s,
    )  # fmt: skip


QUANTITIES = ("damping_ratio", "frequency_hz", "growth_1_s")


def _later(window: SwingWindow) -> FloatArray:
    if window.later is None:
        return np.full(3, math.nan)
    return np.array(
        [getattr(window.later, name) - getattr(window.line, name) for name in QUANTITIES]
    )


def _quiet_windows(found: Found, line: Line) -> npt.NDArray[np.int64]:
    """First rows of quiet windows as long as the line's."""
    return quiet_starts(found.quiet, max(8, round(line.length_s / found.run.step_s)))


def _some(starts: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """At most _MOST_QUIET of them, evenly."""
    chosen = np.linspace(0, len(starts) - 1, min(len(starts), _MOST_QUIET)).astype(np.int64)
    return np.asarray(starts[chosen], dtype=np.int64)


def _covariance(found: Found, line: Line, samples: FloatArray) -> tuple[FloatArray, float]:
    """Of growth and omega, and its degrees of freedom; `samples`: the line's own."""
    white = np.diag([line.growth_se_1_s**2, line.omega_se_rad_s**2])
    run = found.run
    rows = max(8, round(line.length_s / run.step_s))
    starts = _quiet_windows(found, line)
    if len(starts) < FEWEST_QUIET:
        meanwhile = ambient_covariance(samples, run.step_s, line)
        return white + meanwhile, max(4.0, 2.0 * line.cycles)
    starts = _some(starts)
    moves = sensitivity(line, rows, run.step_s)
    shifts = np.array(
        [np.einsum("irc,rc->i", moves, run.value[k : k + rows]) for k in starts], dtype=np.float64
    )
    quiet = shifts.T @ shifts / len(shifts)
    larger = np.maximum(np.diag(quiet), np.diag(white))
    # the larger of both for each; the correlation is the quiet signal's
    scale = np.sqrt(larger / np.maximum(np.diag(quiet), 1e-300))
    freedom = max(4.0, len(starts) / 2.0)
    return np.asarray(quiet * np.outer(scale, scale), dtype=np.float64), freedom
