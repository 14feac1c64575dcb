"""Which swings of the riderless bicycle are free: by its roll equation, which no estimate uses.

The authors list 107 pushes; swaywatch finds more oscillations than that in their recordings. The
criterion below was written down, and committed, before it was applied to any of them.

1. *A hand on the frame.* The roll equation of a bicycle (the first row of the Carvallo-Whipple
   model) is the same for every controller, for a controller only turns the fork:
   ``lean'' = a lean + b fork + c fork' + d fork'' + moment / inertia``.
   Its four coefficients and an offset are fitted for each speed and controller within the authors'
   windows alone. What it leaves anywhere else is the moment of a hand, a cable or the belt. That
   residual goes into ``find()`` as a recorded input, and the product's own rule for what a driver
   does, with its own constants, says whether a swing is forced by it.
2. *The same mode.* Damping ratio and frequency lie within three standard errors (their own, and
   that of the mean with the scatter of the repeats) of the mean of the authors' pushes at that
   speed and controller; 2 m/s and above, for at 1.5 m/s the pushes scatter too much to be a
   reference.

An oscillation that the authors do not list is false if it fails either. What is said to be not
determinable claims no damping and is counted apart. The check of the check: the authors' own pushes
have to pass the first (95 %), and the push itself has to be seen by it before its window.

Beside it (written later, when the false ones had been looked at, so no requirement rests on it):
*the hand's part*. The mode's answer to the moment within the window, at its largest, over its
answer to all moment before, as `freed.py` has it. The act rule above asks whether a hand's action
is distinct; this asks how much it adds, and where it adds more than `freed.ADDED` the oscillation
is not free, whatever began it. What such a hand does to the values shows in the pushes' mean.

Signals are those that the command takes by their names: the lean rate swings, the fork angle swings
along; the rule that uses it was set on generated bicycles (``damping_hands.py``). With
``along=("none",)`` it is left out.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy import signal

from swaywatch.damping.alike import parted
from swaywatch.damping.data import Choice, DampingRun, load_runs
from swaywatch.damping.find import find
from swaywatch.damping.freed import ADDED, answer
from swaywatch.damping.intervals import Point, points_of
from swaywatch.damping.window import Estimator

FloatArray = npt.NDArray[np.float64]

BAND = (0.2, 10.0)
NEAR_S = 0.5
"""A window that is found belongs to a push whose own begins within this."""

SMOOTH_ROWS, SMOOTH_ORDER = 21, 3
"""Savitzky-Golay, the same for every signal of the roll equation (0.21 s)."""

BEFORE_CYCLES = 2.0
"""How far back the moment counts: the swings are damped by 0.2 and more."""

FEWEST_M_S = 2.0
SPEEDS = {
    "5.4": 1.5, "7.2": 2.0, "9": 2.5, "10.8": 3.0, "12.6": 3.5, "14.4": 4.0, "16.2": 4.5, "18": 5.0,
}  # fmt: skip


@dataclass(frozen=True)
class Push:
    """One of the authors' windows and the hand fit in it."""

    start_s: float
    end_s: float
    damping_ratio: float
    frequency_hz: float


@dataclass(frozen=True)
class Swing:
    """An oscillation that swaywatch found: its first window.

    Attributes
    ----------
    listed
        It is one of the authors' pushes.
    forced
        By a moment on the frame, as far as the roll equation tells.
    part
        What that moment adds within the window, of what it had given before.
    """

    point: Point
    listed: bool
    forced: bool
    part: float


@dataclass(frozen=True)
class Place:
    """A recording: the authors' pushes, and what was found without knowing of them."""

    mode: str
    speed_m_s: float
    pushes: tuple[Push, ...]
    swings: tuple[Swing, ...]
    pushed_before: int

    @property
    def of_pushes(self) -> list[Point]:
        """Points of the authors' pushes."""
        return [swing.point for swing in self.swings if swing.listed]


def pushes_of(folder: Path, mode: str, speed_m_s: float) -> list[Push]:
    """The authors' windows of a recording."""
    with (folder / "segments_and_fits.csv").open(encoding="utf-8") as file:
        rows = [
            row
            for row in csv.DictReader(file)
            if row["mode"] == mode and float(row["v_mps"]) == speed_m_s
        ]
    found = []
    for row in rows:
        start, end = sorted((int(row["start"]) / 100, int(row["stop"]) / 100))
        found.append(Push(start, end, float(row["zeta"]), float(row["f"])))
    return sorted(found, key=lambda push: push.start_s)


def roll_moment(path: Path, pushes: Sequence[Push]) -> FloatArray:
    """Moment on the frame over its inertia, rad/s^2, at every row: what the equation leaves."""
    channels = ("lean_angle", "lean_rate", "fork_angle", "fork_rate")
    (run,) = load_runs([path], Choice(channels, (), "speed"))
    lean, lean_rate, fork, fork_rate = run.value.T

    def smooth(value: FloatArray, derivative: int = 0) -> FloatArray:
        return np.asarray(
            signal.savgol_filter(
                value, SMOOTH_ROWS, SMOOTH_ORDER, deriv=derivative, delta=run.step_s
            )
        )

    columns = np.stack(
        [smooth(lean), smooth(fork), smooth(fork_rate), smooth(fork_rate, 1), np.ones(len(lean))],
        axis=1,
    )
    acceleration = smooth(lean_rate, 1)
    inside = np.zeros(len(lean), dtype=np.bool_)
    for push in pushes:
        inside[run.rows(push.start_s, push.end_s)] = True
    fit, *_ = np.linalg.lstsq(columns[inside], acceleration[inside], rcond=None)
    return np.asarray(acceleration - columns @ fit, dtype=np.float64)


def place_of(
    folder: Path, mode: str, name: str, estimator: Estimator, along: tuple[str, ...] = ()
) -> Place:
    """One recording, without and with the moment as an input; `along`: as ``--along``."""
    speed = SPEEDS[name]
    path = folder / f"{mode}_{name}kph.parquet"
    pushes = pushes_of(folder, mode, speed)
    (run,) = load_runs([path], Choice(along=along))
    points, _ = parted(points_of(find(run, BAND, estimator)))
    moment = roll_moment(path, pushes)
    free, seen = _free_under(run, moment, estimator, pushes)
    first = [p for k, p in enumerate(points) if k == 0 or p.number != points[k - 1].number]
    swings = [
        Swing(
            point,
            _near(point, pushes),
            not any(abs(point.start_s - f) < NEAR_S for f in free),
            hands_part(run, moment, point),
        )
        for point in first
    ]
    return Place(mode, speed, tuple(pushes), tuple(swings), seen)


def _near(point: Point, pushes: Sequence[Push]) -> bool:
    return any(abs(point.start_s - push.start_s) < NEAR_S for push in pushes)


def _free_under(
    run: DampingRun, moment: FloatArray, estimator: Estimator, pushes: Sequence[Push]
) -> tuple[list[float], int]:
    """Starts of what is free although the moment is known; pushes that the moment shows."""
    known = replace(run, input_names=("roll moment",), inputs=moment[:, None])
    found = find(known, BAND, estimator)
    usual = float(np.percentile(np.abs(moment - np.median(moment)), 75.0))
    seen = 0
    for push in pushes:
        before = moment[run.rows(push.start_s - 0.5, push.start_s)]
        seen += bool(np.max(np.abs(before - np.median(moment))) > 3.0 * usual)
    return [point.start_s for point in points_of(found)], seen


def hands_part(run: DampingRun, moment: FloatArray, point: Point) -> float:
    """Largest answer of the mode to the moment within a window over that to all before."""
    s = complex(point.growth_1_s.value, 2 * math.pi * point.frequency_hz.value)
    value = moment - np.median(moment)
    rows = run.rows(point.start_s, point.end_s)
    before = run.rows(
        max(0.0, point.start_s - BEFORE_CYCLES / point.frequency_hz.value), run.time_s[rows.start]
    )
    given = answer(value[before.start : rows.start + 1], s, run.step_s)[-1]
    return float(np.max(np.abs(answer(value[rows], s, run.step_s))) / max(abs(given), 1e-300))


def deviations(point: Point, pushes: Sequence[Push]) -> list[tuple[float, float]]:
    """Of damping ratio and frequency from the mean of the authors' pushes, with standard errors."""
    found = []
    for value, hand in (
        (point.damping_ratio, [push.damping_ratio for push in pushes]),
        (point.frequency_hz, [push.frequency_hz for push in pushes]),
    ):
        scatter = float(np.std(hand, ddof=1)) * math.sqrt(1.0 + 1.0 / len(hand))
        found.append((value.value - float(np.mean(hand)), math.hypot(value.error, scatter)))
    return found


def same_mode(point: Point, pushes: Sequence[Push]) -> bool:
    """Within three standard errors of the mean of the authors' pushes."""
    return all(abs(off) <= 3.0 * error for off, error in deviations(point, pushes))


def places_of(folder: Path, along: tuple[str, ...] = ()) -> list[Place]:
    """All sixteen recordings; `along`: as ``--along``."""
    estimator = Estimator()
    return [
        place_of(folder, mode, name, estimator, along)
        for mode in ("normal", "mm")
        for name in SPEEDS
    ]


@dataclass(frozen=True)
class Agreement:
    """Swings and how their damping and frequency compare with the pushes at their place.

    Attributes
    ----------
    count, compared
        All, and those at FEWEST_M_S and above.
    ratio_held, frequency_held
        Of these: the pushes' mean is within 1.96 standard errors (own, and a push's scatter).
    excess, excess_error
        Mean of the damping ratio above that of the pushes, and its standard error.
    """

    count: int
    compared: int
    ratio_held: int
    frequency_held: int
    excess: float
    excess_error: float


def agreement(swings: Sequence[tuple[Place, Swing]]) -> Agreement:
    """Over swings and the places at which they are."""
    compared = [(p, swing.point) for p, swing in swings if p.speed_m_s >= FEWEST_M_S]
    off = np.array([deviations(point, place.pushes) for place, point in compared]).reshape(-1, 2, 2)
    within = np.abs(off[:, :, 0]) <= 1.96 * off[:, :, 1]
    excess = off[:, 0, 0]
    return Agreement(
        len(swings), len(compared), int(within[:, 0].sum()), int(within[:, 1].sum()),
        float(excess.mean()), float(excess.std(ddof=1)) / math.sqrt(len(excess)),
    )  # fmt: skip


@dataclass(frozen=True)
class Count:
    """What became of the oscillations that were found."""

    pushes: int
    pushes_found: int
    pushes_free: int
    pushes_seen: int
    unlisted: int
    not_determinable: int
    forced: int
    other_mode: int
    forced_alike: int
    """Of the forced ones: the mode of the pushes all the same."""
    judged: int
    """Determinable, listed or not: what false ones are a share of."""
    pushes_alone: int
    """Pushes with a stated damping in whose window the hand's part is at most ADDED."""
    pushes_stated: int
    little: Agreement
    """Unlisted, the hand's part at most ADDED."""
    held: Agreement
    """Unlisted, the hand's part larger."""


def count(places: Sequence[Place]) -> Count:
    """Over all recordings."""
    swings = [(place, swing) for place in places for swing in place.swings]
    listed = [swing for _, swing in swings if swing.listed]
    unlisted = [(place, swing) for place, swing in swings if not swing.listed]
    sure = [(place, swing) for place, swing in unlisted if swing.point.determinable]
    forced = [swing for _, swing in sure if swing.forced]
    alike = [p for p, swing in sure if swing.forced and same_mode(swing.point, p.pushes)]
    other = [
        swing
        for place, swing in sure
        if not swing.forced
        and place.speed_m_s >= FEWEST_M_S
        and not same_mode(swing.point, place.pushes)
    ]
    return Count(
        pushes=sum(len(place.pushes) for place in places),
        pushes_found=len(listed),
        pushes_free=sum(not swing.forced for swing in listed),
        pushes_seen=sum(place.pushed_before for place in places),
        unlisted=len(unlisted),
        not_determinable=len(unlisted) - len(sure),
        forced=len(forced),
        other_mode=len(other),
        forced_alike=len(alike),
        judged=len(listed) + len(sure),
        pushes_alone=sum(swing.part <= ADDED for swing in listed if swing.point.determinable),
        pushes_stated=sum(swing.point.determinable for swing in listed),
        little=agreement([(p, swing) for p, swing in sure if swing.part <= ADDED]),
        held=agreement([(p, swing) for p, swing in sure if swing.part > ADDED]),
    )
