"""Long recordings: the stretches that are searched, and whether the others agree.

A search takes memory and time for every second that it looks at. Of recordings longer together than
`WHOLE_S` the stretches with the most motion are searched, slower and faster ones in turn, because
what depends on the speed shows across speeds. What was found is then simulated over every other
stretch in which something moves, each from start values of its own; where it does not fit, these
stretches are searched too, once, and what does not fit after that is reported.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swaywatch.checks.sensor_faults import MOST_LOST
from swaywatch.diagnose.fit.fit import OBSERVER, Fit, Fitter, Problem, Trial
from swaywatch.effects.runs import BLOCK, RATE_HZ, SETTLING, Run
from swaywatch.plant.lanes import LANES

Array = NDArray[np.float64]

WHOLE_S = 300.0  # up to this length of all runs together everything is searched
STRETCH_S = 40.0
SEARCHED_S = 200.0  # as many pulses of a second are fitted together with the vehicle
APART = 2.0  # reduced chi-square over that of what was searched from which a stretch does not fit


@dataclass
class Stretches:
    """Of a long recording.

    Attributes
    ----------
    searched, others
        What is fitted, and what is only checked; a stretch without all sensors is not searched.
    still_s
        Length of what was left out: too slow, or nothing moves.
    misfit
        Reduced chi-square of each of the others, once they were checked.
    """

    searched: list[Run]
    others: list[Run]
    still_s: float
    misfit: list[float]

    @property
    def whole(self) -> bool:
        """Nothing was left out of the search."""
        return not self.others and self.still_s == 0.0

    def apart(self, reference: float) -> list[int]:
        """Those of the others that do not fit, worst first."""
        limit = APART * max(reference, 1.0)
        found = [i for i, x in enumerate(self.misfit) if not x <= limit]
        return sorted(found, key=lambda i: -self.misfit[i])

    def with_worst(self, reference: float) -> Stretches:
        """Half of what was searched, and of those that do not fit the worst in its place."""
        complete = [frozenset(run.channels) for run in self.searched]
        bad = [i for i in self.apart(reference) if frozenset(self.others[i].channels) in complete]
        number = len(self.searched)
        worst = bad[: number - number // 2]
        kept = self.searched[: number - len(worst)]
        back = self.searched[number - len(worst) :]
        taken = set(worst)
        rest = [run for i, run in enumerate(self.others) if i not in taken]
        return Stretches(
            [*kept, *(self.others[i] for i in worst)], [*rest, *back], self.still_s, []
        )

    def summary(self, reference: float) -> str:
        """What was searched, and whether the others agree."""
        seconds = sum(length_s(run) for run in (*self.searched, *self.others)) + self.still_s
        bad = self.apart(reference)
        good = [x for i, x in enumerate(self.misfit) if i not in bad]
        text = f"{seconds:.0f} s were recorded; searched: " + "; ".join(
            run.name for run in self.searched
        )
        if good:
            text += (
                f"; {len(good)} other stretches agree (reduced chi-square up to {max(good):.2f})"
            )
        if self.still_s:
            text += f"; {self.still_s:.0f} s left out: too slow, or nothing moves"
        return text

    def contradictions(self, reference: float) -> list[str]:
        """A sentence on each stretch that does not fit what was found."""
        return [
            f"{self.others[i].name} does not fit the findings of the other stretches (reduced "
            f"chi-square {self.misfit[i]:.1f}): diagnose this part alone"
            for i in self.apart(reference)
        ]

    def entries(self) -> list[dict[str, Any]]:
        """For diagnosis.json."""
        rows = [(run, True, None) for run in self.searched]
        checked = [(run, False, x) for run, x in zip(self.others, self.misfit, strict=True)]
        return [
            {
                "run": run.name,
                "start_s": float(run.time[0]),
                "stop_s": float(run.time[-1]),
                "searched": searched,
                "reduced_chi_square": misfit,
            }
            for run, searched, misfit in (*rows, *checked)
        ]


def length_s(run: Run) -> float:
    """Seconds."""
    return run.time.size / RATE_HZ


def divided(runs: Sequence[Run], of_no_use: Callable[[Run], str]) -> Stretches:
    """What of some runs is searched, and what is only checked.

    Parameters
    ----------
    runs
        Prepared.
    of_no_use
        Why nothing can be learnt of a stretch, or nothing.
    """
    if sum(map(length_s, runs)) <= WHOLE_S:
        return Stretches(list(runs), [], 0.0, [])
    pieces = [piece for run in runs for piece in _cut(run)]
    of_use = [piece for piece in pieces if not of_no_use(piece)]
    still_s = sum(map(length_s, pieces)) - sum(map(length_s, of_use))
    most = max((len(piece.channels) for piece in of_use), default=0)
    complete = [piece for piece in of_use if len(piece.channels) == most]
    searched = _in_turn(complete)[: round(SEARCHED_S / STRETCH_S)]
    taken = {id(piece) for piece in searched}
    return Stretches(searched, [p for p in of_use if id(p) not in taken], still_s, [])


def _cut(run: Run) -> list[Run]:
    blocks = run.time.size // BLOCK
    count = max(1, round(length_s(run) / STRETCH_S))
    edges = [round(i * blocks / count) * BLOCK for i in range(count + 1)]
    found = []
    for first, last in pairwise(edges):
        found.append(piece_of(run, first, last))
    return found


def piece_of(run: Run, first: int, last: int) -> Run:
    """Samples `first` to `last` of a run, with start values of its own, as they are searched.

    Without the channels of which hardly anything counts there.
    """
    piece = run.part(first, last)
    piece.name = f"{run.name} from {piece.time[0]:.0f} to {piece.time[-1]:.0f} s"
    if first:  # cut in mid-motion
        piece.settling = SETTLING
    return _without_silent(piece)


def _without_silent(piece: Run) -> Run:
    """Without channels of which hardly anything counts there: a sensor may have died before."""
    for name, kept in list(piece.kept.items()):
        if np.mean(kept) < 1.0 - MOST_LOST:
            del piece.kept[name]
            piece.channels.pop(name, None)
            piece.yaw_rates.pop(name.removesuffix("_yaw_rate"), None)
    return piece


def _motion(run: Run) -> float:
    """RMS of the yaw rates, each about its mean, rad/s."""
    return float(np.sqrt(sum(np.var(rate) for rate in run.yaw_rates.values())))


def _in_turn(pieces: Sequence[Run]) -> list[Run]:
    """Those with the most motion first, the faster and the slower half in turn."""
    by_speed = sorted(pieces, key=lambda run: -float(np.mean(run.speed)))
    half = -(-len(by_speed) // 2)
    fast, slow = (
        sorted(some, key=lambda run: -_motion(run)) for some in (by_speed[:half], by_speed[half:])
    )
    turns = [run for pair in zip(fast, slow, strict=False) for run in pair]
    return turns + fast[len(slow) :]


def misfit_of(problem: Problem, fit: Fit, others: Sequence[Run]) -> list[float]:
    """Reduced chi-square of each of some stretches with what lasts of a fit.

    Each has start values and an offset of its own; vehicle, sensors and effects are the fit's.
    Under the observer: what is asked is whether the forces are right, not how long a course is
    kept. O(samples), a few stretches in memory at a time.
    """
    constant = tuple(term for term in fit.terms if not term.effect.windowed)
    found: list[float] = []
    for at in range(0, len(others), LANES):
        some = tuple(others[at : at + LANES])
        part = replace(problem, runs=some, observer=OBSERVER, start_nuisance=None)
        fitter = Fitter(part, fine=False)
        start = Fit(constant, np.zeros((len(some), 5)), fit.shift)
        near = fitter.run(start, 4, free=0, calibrate=False)
        trials = [Trial(i, constant, near.nuisance[i], fit.shift) for i in range(len(some))]
        found += [float(np.dot(e, e)) / e.size for e in fitter.evaluate_all(trials)]
    return found
