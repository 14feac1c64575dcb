"""Generated swings whose damping depends on their size, or which a driver's hand goes on driving.

1. One mode whose damping falls with the amplitude by a known law, hit several times, with and
   without motion from the road: truth at small amplitude is the law's. With dry friction there is
   no such value; there the right answer is to state none.
2. Drawn combinations (``warning_plant``) with tyres that saturate, pulses of the wheel, and a hand
   that wanders all the time. Truth is the same plant's own decay from a small pulse, hands off.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import warning_campaign
import warning_plant as plant
from numba import njit

from swaywatch.damping.data import DampingRun, run_of
from swaywatch.damping.find import find
from swaywatch.damping.intervals import points_of
from swaywatch.damping.size import small_swing
from swaywatch.damping.window import Estimator

FloatArray = npt.NDArray[np.float64]

BAND = (0.2, 10.0)
LAWS = ("constant", "A", "A^2", "knee", "brush", "dry friction")


@njit(cache=True)
def _swing(
    law: int, omega: float, ratio: float, lost: float, step_s: float, sub: int,
    hits: FloatArray, force: FloatArray,
) -> FloatArray:  # fmt: skip
    """Rate over omega, and angle, of a mode; `hits`: rate that each row adds, over omega."""
    out = np.empty((len(hits), 2))
    x = v = 0.0
    dt = step_s / sub
    knee = 0.3 * omega
    for row in range(len(hits)):
        v += omega * hits[row]
        for k in range(sub):
            size = math.hypot(x, v / omega)
            rate = v
            if law == 1:
                rate = v * (1.0 - lost * size)
            elif law == 2:
                rate = v * (1.0 - lost * size**2)
            elif law == 3:
                inner = min(max(v, -knee), knee)
                rate = inner + (1.0 - 1.5 * lost) * (v - inner)
            elif law == 4:
                rate = v * (1.0 - lost * min(1.0, abs(v) / omega))
            push = force[row * sub + k]
            if law == 5:
                push -= 0.01 * omega**2 * math.tanh(v / (0.003 * omega))
            v += dt * (push - 2.0 * ratio * omega * rate - omega**2 * x)
            x += dt * v
        out[row, 0] = v / omega
        out[row, 1] = x
    return out


def _drawn(rng: np.random.Generator, law: int) -> tuple[DampingRun, float]:
    """A run, and the damping ratio at small amplitude."""
    frequency = float(np.exp(rng.uniform(math.log(0.4), math.log(4.0))))
    ratio = float(rng.choice([0.03, 0.06, 0.12, 0.2]))
    omega = 2 * math.pi * frequency
    share, rate = float(rng.choice([0.0, 0.01, 0.03])), float(rng.choice([25.0, 50.0, 100.0]))
    step, sub = 1.0 / (rate * frequency), math.ceil(400 / rate)
    between = 16 if ratio > 0.1 else 30
    rows = round(int(rng.choice([2, 4])) * between * rate)
    hits = np.zeros(rows)
    hits[round((between - 10) * rate) :: round(between * rate)] = 1.0
    hits *= rng.uniform(0.5, 1.0, rows)
    power = share**2 / 2 * 4 * ratio * omega / (step / sub)
    force = rng.normal(0.0, math.sqrt(power), rows * sub)
    lost = float(rng.uniform(0.1, 0.5))
    value = _swing(law, omega, ratio, lost, step, sub, hits, force)
    value += rng.normal(0.0, 0.004, value.shape) + 0.3
    channels = int(rng.integers(1, 3))
    return DampingRun(
        "drawn", Path("drawn.csv"), np.arange(rows) * step, step, ("rate", "angle")[:channels],
        ("",) * channels, value[:, :channels], np.ones(rows, dtype=np.bool_), (),
        np.zeros((rows, 0)), None, "", "",
    ), ratio  # fmt: skip


class Held(NamedTuple):
    """Intervals at small amplitude: how many are stated, hold, and leave out the truth."""

    stated: int
    held: int
    none: int
    half: float
    """Median half-width over the truth."""


def held_at_small(pairs: list[tuple[DampingRun, float]], estimator: Estimator) -> Held:
    """The intervals at small amplitude of runs with their truths."""
    held, halves, none = 0, [], 0
    for run, truth in pairs:
        small = small_swing(points_of(find(run, BAND, estimator)))
        if small is None or small.damping_ratio is None:
            none += 1
            continue
        held += small.damping_ratio.low <= truth <= small.damping_ratio.high
        halves.append(small.damping_ratio.half / truth)
    return Held(len(halves), held, none, float(np.median(halves)) if halves else math.nan)


def laws(first_seed: int, count: int) -> dict[str, Held]:
    """Of each law, `count` runs."""
    estimator = Estimator()
    return {
        name: held_at_small(
            [_drawn(np.random.default_rng((seed, law)), law)
             for seed in range(first_seed, first_seed + count)],
            estimator,
        )
        for law, name in enumerate(LAWS)
    }  # fmt: skip


def own_decay(c: plant.Combination, speed: float, estimator: Estimator) -> float | None:
    """Damping ratio of the plant's decay from a small pulse."""
    course = plant.course(12.0, speed)
    course.wheel += plant.half_sine(course.time_s, 1.0, 0.4, math.radians(0.5))
    motion = plant.simulate(c, course)
    value = np.stack([motion.trailer_yaw_rate, motion.car_yaw_rate], axis=1)
    rows = slice(round(3.5 / plant.STEP_S), round(9.5 / plant.STEP_S))
    line = estimator.line(value[rows], 3.5, plant.STEP_S, 0.7)
    return None if line is None or not line.converged() else line.damping_ratio


def vehicles(
    first_seed: int, count: int, *, saturating: bool
) -> list[tuple[float, DampingRun, float]]:
    """Hand (deg), run and truth of drawn combinations."""
    estimator = Estimator()
    found = []
    for seed in range(first_seed, first_seed + count):
        rng = np.random.default_rng(seed)
        speed = float(rng.uniform(60, 120)) / 3.6
        c = warning_campaign._stable_combination(rng, speed, 0.03)
        if not saturating:
            c = replace(c, peak_friction=30.0)
        truth = own_decay(c, speed, estimator)
        hand = float(rng.choice([0.1, 0.3, 0.6]))
        course = plant.course(float(rng.choice([40.0, 60.0, 100.0])), speed)
        plant.add_hand(course, rng, math.radians(hand))
        apart = float(rng.choice([14.0, 18.0, 25.0]))
        for start in np.arange(6.0, course.time_s[-1] - 12.0, apart):
            angle, length = math.radians(rng.uniform(10, 30)), float(rng.uniform(0.4, 0.9))
            course.wheel += plant.half_sine(course.time_s, start, length, angle)
        if truth is None or truth > 0.2:
            continue
        motion = plant.simulate(c, course)
        drive = warning_campaign.as_drive(plant.measure(motion, rng), c)
        found.append((hand, run_of(replace(drive, files=("drawn",))), truth))
    return found
