"""Hands that are withdrawn slowly from generated bicycles: which swings does `--along` leave out?

Bicycles are drawn around the benchmark of Meijaard et al. (2007, Carvallo-Whipple): masses,
stiffnesses, gyroscopic terms, speed and a controller that steers into the lean, all with a weave
that is damped by 0.1 to 0.42. Half of what begins a swing is a short push; the rest a moment that
rises fast and falls for a third to nine tenths of a cycle. What the moment adds within a window, of
what it had given before it, is known exactly: at most FREE of it is a free swing, more than
FORCED_SHARE is not. Rule and constants of ``damping/alike.py`` and ``shape.py`` were set on the
seeds 2000 to 2079 and 5000 to 5079; no recording was used for them.

Run: ``python tests/bench/damping_hands.py --first 9000 --count 120``.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import signal

from swaywatch.damping.alike import parted
from swaywatch.damping.data import DampingRun
from swaywatch.damping.find import FORCED_SHARE, find
from swaywatch.damping.freed import answer
from swaywatch.damping.intervals import points_of
from swaywatch.damping.window import Estimator

FloatArray = npt.NDArray[np.float64]

STEP_S, LENGTH_S = 0.01, 115.0
FREE = 0.15
_BAND = (0.2, 10.0)
_MASS = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
_GRAVITY = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
_SPEED_SQUARED = np.array([[0.0, 76.59734589573222], [0.0, 2.65431523794604]])
_SPEED = np.array([[0.0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])


class Bicycle(NamedTuple):
    """State (lean, fork and their rates) x' = a x + b (roll moment, fork torque)."""

    a: FloatArray
    b: FloatArray
    weave: complex
    speed_m_s: float


class Ride(NamedTuple):
    """A recording and the moment of the hand in it."""

    run: DampingRun
    moment: FloatArray
    weave: complex


def drawn(rng: np.random.Generator) -> Bicycle:
    """A stable bicycle with one weave of 0.6 to 2 Hz, damped by 0.1 to 0.42."""
    while True:
        speed = rng.uniform(2.0, 6.0)

        def varied(matrix: FloatArray) -> FloatArray:
            return matrix * (1.0 + 0.12 * rng.standard_normal(matrix.shape))

        mass, gravity = varied(_MASS), varied(_GRAVITY)
        mass[1, 0], gravity[1, 0] = mass[0, 1], gravity[0, 1]
        damping = speed * varied(_SPEED)
        damping[1] += [-rng.uniform(0.0, 30.0), rng.uniform(0.0, 4.0)]
        stiffness = 9.81 * gravity + speed**2 * varied(_SPEED_SQUARED)
        stiffness[1, 0] -= rng.uniform(0.0, 40.0)
        if np.linalg.det(mass) <= 0.0:
            continue
        inverse = np.linalg.inv(mass)
        a = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ stiffness, -inverse @ damping]])
        roots = np.linalg.eigvals(a)
        weave = roots[roots.imag > math.pi]
        if roots.real.max() > -0.5 or len(weave) != 1:
            continue
        s = complex(weave[0])
        if 0.1 < -s.real / abs(s) < 0.42 and 0.6 < s.imag / (2 * math.pi) < 2.0:
            return Bicycle(a, np.vstack([np.zeros((2, 2)), inverse]), s, float(speed))


def ride(seed: int, hands: float) -> Ride:
    """Channel: lean rate; along: fork angle. `hands`: share of what is no short push."""
    rng = np.random.default_rng(seed)
    bicycle = drawn(rng)
    time = np.arange(round(LENGTH_S / STEP_S)) * STEP_S
    moment = _moment(rng, time, 2 * math.pi / bicycle.weave.imag, hands)
    swing = _motion(bicycle, np.stack([moment, np.zeros_like(moment)], axis=1))
    fork = 0.03 * rng.uniform(0.3, 2.0)
    noise = np.stack([_noise(rng, len(time)), fork * _noise(rng, len(time))], axis=1)
    ambient = _motion(bicycle, noise)
    level = float(np.abs(swing[:, 2]).max()) / rng.uniform(15.0, 45.0) / float(ambient[:, 2].std())
    seen = (swing + level * ambient)[:, [2, 1]]
    share = rng.uniform(0.001, 0.006, 2)
    seen += rng.standard_normal(seen.shape) * np.abs(seen).max(axis=0) * share
    run = DampingRun(
        f"ride {seed}", Path("ride"), time, STEP_S, ("lean_rate",), ("rad/s",), seen[:, :1],
        np.ones(len(time), dtype=np.bool_), (), np.zeros((len(time), 0)),
        np.full(len(time), bicycle.speed_m_s), "speed", "m/s", (), ("fork_angle",), seen[:, 1:],
    )  # fmt: skip
    return Ride(run, moment, bicycle.weave)


def _moment(rng: np.random.Generator, time: FloatArray, cycle_s: float, hands: float) -> FloatArray:
    moment = np.zeros_like(time)
    at = 3.0 + rng.uniform(0.0, 3.0)
    while at < LENGTH_S - 6.0:
        size = rng.choice([-1.0, 1.0]) * rng.uniform(0.6, 1.3)
        if rng.random() >= hands:
            length = rng.uniform(0.12, 0.35) * cycle_s
            part = np.clip((time - at) / length, 0.0, 1.0)
            moment += size * 0.25 * cycle_s / length * np.sin(math.pi * part)
        else:
            size *= rng.uniform(0.5, 0.9)
            up, down = rng.uniform(0.08, 0.2) * cycle_s, rng.uniform(0.35, 0.9) * cycle_s
            part = (time - at - up) / down
            falls = (
                np.clip(1.0 - part, 0.0, 1.0),
                0.5 * (1.0 + np.cos(math.pi * np.clip(part, 0.0, 1.0))),
                np.exp(-2.5 * np.maximum(part, 0.0)) * (part < 2.0),
            )[int(rng.integers(3))]
            moment += size * np.where(part < 0.0, np.clip((time - at) / up, 0.0, 1.0), falls)
        at += max(3.2, 4.0 * cycle_s) + rng.uniform(1.0, 5.0)
    return moment


def _motion(bicycle: Bicycle, force: FloatArray) -> FloatArray:
    """States under a force that holds from row to row."""
    roots, shapes = np.linalg.eig(bicycle.a)
    gain = np.linalg.inv(shapes) @ bicycle.b
    modes = [answer(force @ gain[k], complex(roots[k]), STEP_S) for k in range(len(roots))]
    return np.asarray((np.stack(modes, axis=1) @ shapes.T).real)


def _noise(rng: np.random.Generator, rows: int) -> FloatArray:
    """Of unit variance, up to 3 Hz."""
    value = signal.lfilter(*signal.butter(1, 6.0 * STEP_S), rng.standard_normal(rows))
    return np.asarray(value / value.std())


def added(one: Ride, start_s: float, end_s: float) -> float:
    """The weave's largest answer to the moment within a window over that to the moment before."""
    first, last = round(start_s / STEP_S), round(end_s / STEP_S)
    memory = round(4 * math.pi / one.weave.imag / STEP_S)
    before = answer(one.moment[max(0, first - memory) : first + 1], one.weave, STEP_S)[-1]
    within = answer(one.moment[first : last + 1], one.weave, STEP_S)
    return float(np.max(np.abs(within)) / max(abs(before), 1e-300))


class Kept(NamedTuple):
    """First windows with a stated damping, and those that are kept, by what is added in them."""

    free: int
    free_kept: int
    held: int
    held_kept: int


def kept(first_seed: int, count: int) -> Kept:
    """Over rides; every fourth has no hand but short pushes."""
    estimator = Estimator()
    total = np.zeros(4, dtype=np.int64)
    for seed in range(first_seed, first_seed + count):
        one = ride(seed, 0.0 if seed % 4 == 0 else 0.5)
        points = points_of(find(one.run, _BAND, estimator))
        usual, _ = parted([replace(point, shape=None) for point in points])
        shaped, _ = parted(points)
        still = {point.start_s for point in shaped}
        for k, point in enumerate(usual):
            if not point.determinable or (k and point.number == usual[k - 1].number):
                continue
            part = added(one, point.start_s, point.end_s)
            here = point.start_s in still
            if part <= FREE:
                total[:2] += [1, here]
            elif part > FORCED_SHARE:
                total[2:] += [1, here]
    return Kept(*(int(value) for value in total))


def main() -> int:
    """Print what is kept."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=9000)
    parser.add_argument("--count", type=int, default=120)
    args = parser.parse_args()
    found = kept(args.first, args.count)
    print(
        f"free: {found.free_kept} of {found.free} kept; with a hand (more than {FORCED_SHARE:g}): "
        f"{found.held - found.held_kept} of {found.held} left out"
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
