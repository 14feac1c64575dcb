"""Where laws are begun: near the recording, of a long one in the parts that fit worst.

Which laws of many come near is seen from some tens of seconds. Those that do are then fitted to
everything. A strict observer keeps the motion close to the recorded one, so that what a law changes
is nearly in proportion to it, however strong it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.search import Linear
from swaywatch.diagnose.fit.fit import Fit, Fitter
from swaywatch.diagnose.fit.stretches import piece_of
from swaywatch.effects.runs import BLOCK, RATE_HZ, Run

Array = NDArray[np.float64]

PARTS = 2  # of different runs where there are several: of two speeds, as a rule
PART_S = 20.0
WHOLE_S = 50.0  # up to this length of all runs together laws are begun in everything
#: Pull of the yaw rates while laws are begun, 1/s: more than that of the search, which lets a
#: motion that a law limits drift so far that its force is another one. Beside the calibrated
#: vehicle, and beside that of the file, which is farther from the recording.
STRICT, STRICTER = 6.0, 20.0
CALIBRATED = 6  # iterations of the vehicle under them


@dataclass(frozen=True)
class Excerpt:
    """Where laws are begun.

    Attributes
    ----------
    fitters
        Of the parts, or of the whole recording, under a strict observer, and under less strict ones
        that follow.
    offsets
        Steering offset of the run that each part is from, rad; empty for the whole recording.
    """

    fitters: tuple[Fitter, ...]
    offsets: tuple[float, ...] = ()

    @property
    def fitter(self) -> Fitter:
        """Under the strictest observer."""
        return self.fitters[0]

    def stricter(self) -> Excerpt:
        """The same under a stricter observer, for a vehicle that is far from the recording."""
        return replace(self, fitters=(_under(STRICTER, self.fitter), *self.fitters))

    def course(self, near: Fit, *, calibrated: bool = False) -> Linear:
        """What laws promise in the parts, beside a fit to everything; calibrated there as well."""
        begun = self.of(near)
        return Linear(self.fitter, self.fitter.run(begun, CALIBRATED) if calibrated else begun)

    def of(self, fit: Fit) -> Fit:
        """A fit to everything as a start in the parts."""
        if not self.offsets:
            return fit
        nuisance = np.zeros((len(self.offsets), fit.nuisance.shape[1]))
        nuisance[:, 0] = self.offsets
        return replace(fit, nuisance=nuisance)

    def back(self, fits: Sequence[Fit], near: Fit) -> list[Fit]:
        """Fits to the parts as starts for a fit to everything, their start values those of one."""
        return [replace(f, nuisance=near.nuisance) if self.offsets else f for f in fits]


def everything(whole: Fitter) -> Excerpt:
    """All of it, under a strict observer. O(1)."""
    return Excerpt((_under(STRICT, whole),))


def _under(observer: float, fitter: Fitter) -> Fitter:
    return Fitter(replace(fitter.problem, observer=observer), fine=False)


def excerpt_of(whole: Fitter, near: Fit) -> Excerpt:
    """The parts with the largest misfit of a fit, of as many runs as there are parts.

    Everything where it is short, and beside a user's simulation, whose start values are known.
    O(samples).

    Parameters
    ----------
    whole
        Of everything, under the observer.
    near
        The calibrated vehicle.
    """
    problem = whole.problem
    seconds = sum(run.time.size for run in problem.runs) / RATE_HZ
    if seconds <= WHOLE_S or not problem.free_start:
        return everything(whole)
    size = int(PART_S * RATE_HZ) // BLOCK
    found: list[tuple[int, int]] = []
    misfits = [
        _by_block(whole.evaluate(r, near.terms, near.nuisance[r], near.shift), run)
        for r, run in enumerate(problem.runs)
    ]
    for _ in range(PARTS):
        worst = [(_worst(e, size), r) for r, e in enumerate(misfits)]
        taken = {r for r, _ in found}
        (_, first), r = max([row for row in worst if row[1] not in taken] or worst)
        found.append((r, first))
        misfits[r][first : first + size] = 0.0
    found.sort()
    parts = tuple(_part(problem.runs[r], first, size) for r, first in found)
    offsets = tuple(float(near.nuisance[r, 0]) for r, _ in found)
    within = replace(problem, runs=parts, observer=STRICT)
    return Excerpt((Fitter(within, fine=False),), offsets)


def _by_block(e: Array, run: Run) -> Array:
    """Squared residuals of all channels of each block, shape (blocks,)."""
    return np.asarray(np.sum(e.reshape(run.time.size // BLOCK, -1) ** 2, axis=1))


def _worst(e: Array, size: int) -> tuple[float, int]:
    """The largest sum over some blocks, and where they begin."""
    sums = np.convolve(e, np.ones(min(size, e.size)), "valid")
    return float(np.max(sums)), int(np.argmax(sums))


def _part(run: Run, first: int, size: int) -> Run:
    """A part of a run, by blocks, with start values of its own."""
    if run.time.size <= size * BLOCK:
        return run
    return piece_of(run, first * BLOCK, (first + size) * BLOCK)
