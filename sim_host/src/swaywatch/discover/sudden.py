"""What begins on the way: something breaks, comes loose or is switched on at a moment of each run.

Under a strict observer a law changes what is left only while it acts, so one simulation of a law
that acts all the time says what it would promise from any moment on.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.search import Linear
from swaywatch.discover.begin import weak
from swaywatch.discover.effect import effect_of
from swaywatch.discover.grammar import breaking
from swaywatch.discover.law import Law
from swaywatch.discover.way import DISTANCE, stretch
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.runs import BLOCK, Run

Array = NDArray[np.float64]

MOMENTS = 24  # of each run, at which something is looked at as beginning
SWEEPS = 3  # over the runs, each with the best moments of the others
#: Share of the runs' length that has to be without it: otherwise it acts all the time.
WITHOUT = 0.1
NEVER_S = 2.0  # after the end of a run, where something does not begin in it
BEGUN = 6  # laws, of those that promise most, that are begun


def promising(course: Linear) -> list[ActiveEffect]:
    """The laws that promise most from some moment of each run on, with these moments."""
    runs = course.fitter.problem.runs
    moments = [_moments(run) for run in runs]
    moving = [law for law in breaking() if law.motion != DISTANCE]
    staying = [law for law in breaking() if law.motion == DISTANCE]
    tried = [weak(law) for law in moving]
    blocks = [[at // BLOCK for at in each] for each in moments]
    looked = course.from_then_on(tried, blocks)
    found = []
    for law, (gram, left) in (
        *zip(moving, looked, strict=True),
        *((law, _stepped(course, law, moments)) for law in staying),
    ):
        gain, factor, chosen = _best(gram, left, [len(each) for each in moments])
        begins = [_time(run, each[i]) for run, each, i in zip(runs, moments, chosen, strict=True)]
        if _on_the_way(runs, begins):
            found.append((gain, _from(law, runs, factor, begins)))
    found.sort(key=lambda pair: -pair[0])
    return [term for _, term in found[:BEGUN]]


def _from(law: Law, runs: Sequence[Run], factor: float, begins: Sequence[float]) -> ActiveEffect:
    """A law that begins at a moment of each run, so many times as large as it was looked at."""
    effect, values = weak(law)
    sudden = effect_of(law, runs=tuple(map(stretch, runs)))
    known = dict(zip((p.name for p in effect.parameters), values, strict=True))
    known |= {f"begins_{i + 1}_s": at for i, at in enumerate(begins)}
    first = sudden.parameters[0]
    known[first.name] = min(max(factor * values[0], first.low), first.high)
    return ActiveEffect(sudden, tuple(known[p.name] for p in sudden.parameters))


def _stepped(course: Linear, law: Law, moments: Sequence[Sequence[int]]) -> tuple[Array, Array]:
    """The same products of a force that stays, simulated from each moment on.

    What stays is an offset, which no channel shows: only how it begins does.
    """
    runs = course.fitter.problem.runs
    tried = []
    for j in range(MOMENTS + 1):
        begins = [_time(run, each[j]) for run, each in zip(runs, moments, strict=True)]
        term = _from(law, runs, 1.0, begins)
        tried.append((term.effect, term.values))
    columns = course.by_run(tried)
    every = np.concatenate([np.stack([c[:, r] for c in columns], 1) for r in range(len(runs))], 1)
    return every.T @ every, every.T @ course.left


def _time(run: Run, sample: int) -> float:
    """When a sample of a run is; that behind the last one, never."""
    return float(run.time[sample]) if sample < run.time.size else float(run.time[-1]) + NEVER_S


def _moments(run: Run) -> list[int]:
    """Samples at which something may begin, from the first one to the end."""
    return [int(x) // BLOCK * BLOCK for x in np.linspace(0, run.time.size, MOMENTS + 1)]


def _on_the_way(runs: Sequence[Run], begins: Sequence[float]) -> bool:
    """Whether enough of the runs is without what begins on the way, and some of them with it."""
    whole = sum(float(run.time[-1] - run.time[0]) for run in runs)
    without = sum(
        min(at, float(run.time[-1])) - float(run.time[0])
        for run, at in zip(runs, begins, strict=True)
    )
    return WITHOUT * whole <= without <= (1.0 - WITHOUT) * whole


def _best(gram: Array, left: Array, counts: Sequence[int]) -> tuple[float, float, list[int]]:
    """Drop of the misfit, size and moments: of each run in turn the best beside the others'."""
    starts = np.cumsum([0, *counts[:-1]])
    chosen = [0] * len(counts)
    best = (0.0, 0.0)
    for _ in range(SWEEPS):
        for run, count in enumerate(counts):
            others = [starts[r] + chosen[r] for r in range(len(counts)) if r != run]
            own = starts[run] + np.arange(count)
            power = gram[own, own] + 2.0 * gram[np.ix_(own, others)].sum(axis=1)
            power += gram[np.ix_(others, others)].sum()
            along = left[own] + left[others].sum()
            safe = np.maximum(power, 1e-9)
            gains = np.where(power > 1e-9, along**2 / safe, 0.0)
            chosen[run] = int(np.argmax(gains))
            at = chosen[run]
            best = float(gains[at]), float(-along[at] / safe[at])
    return *best, chosen
