"""Where an effect acts, found together with the vehicle: pulses that need a reason to be there.

A vehicle calibrated without an effect has bent its values to make up for it, and a course that is
linear about it shows windows that are not there. Here pulses, vehicle and start values are fitted
together, step by step with new derivatives (Gauss-Newton). Each pulse has a prior of its own width,
estimated from the recording: where nothing acts it goes to nothing (automatic relevance
determination; MacKay 1992, Tipping 2001, "Sparse Bayesian learning and the relevance vector
machine").
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.locate import PULSE_S, AmplitudeCourse, Locator, joined, pulses_of
from swaywatch.diagnose.fit.fit import NUISANCES, Fit, Fitter, Trial
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect

Array = NDArray[np.float64]

ROUNDS = 8
SETTLED = 0.01  # relative change of the cost below which no further round is made
WIDE = 1e-3  # first inverse variance of a pulse, in the effect's typical noticeable changes
MOST_PULSES = 200  # of all runs: derivatives beyond it cost more than windows are worth


@dataclass
class _Point:
    """Where the fit is: pulses of each run, shape (pulses, parameters), and the rest."""

    pulses: list[Array]
    nuisance: Array
    shift: Array
    errors: list[Array]
    cost: float


class _Sparse:
    """One fit of all pulses of an effect on top of a parent."""

    def __init__(self, fitter: Fitter, parent: Fit, effect: Effect, pulse_s: float) -> None:
        self.fitter, self.parent, self.effect = fitter, parent, effect
        self.beliefs = fitter.problem.beliefs
        self.edges = []
        for run in fitter.problem.runs:
            start, stop = float(run.time[0]), float(run.time[-1])
            count = max(1, round((stop - start) / pulse_s))
            self.edges.append(np.linspace(start, stop, count + 1))
        p = effect.parameters
        self.scale = np.array([q.scale for q in p])
        self.neutral = np.array([q.neutral for q in p])
        self.low = np.array([q.low for q in p]) - self.neutral
        self.high = np.array([q.high for q in p]) - self.neutral
        self.counts = [(e.size - 1) * len(p) for e in self.edges]
        self.n = sum(self.counts)
        self.weight = np.full(self.n, WIDE)

    def term(self, pulses: Array, run: int) -> ActiveEffect:
        """All pulses of a run as one active effect."""
        edges = self.edges[run]
        values: list[float] = []
        for i, row in enumerate(pulses):
            values += [float(edges[i]), float(edges[i + 1]), *(self.neutral + row).tolist()]
        return ActiveEffect(self.effect, tuple(values), (run,) * len(pulses))

    def trial(self, pulses: Array, run: int, nuisance: Array, shift: Array) -> Trial:
        """A run with its pulses."""
        return Trial(run, (*self.parent.terms, self.term(pulses, run)), nuisance[run], shift)

    def flat(self, pulses: list[Array]) -> Array:
        """Pulses of all runs in typical noticeable changes, shape (n,)."""
        return np.concatenate([(p / self.scale).ravel() for p in pulses])

    def split(self, x: Array) -> list[Array]:
        """The inverse of `flat`, inside the bounds."""
        parts = np.split(x, np.cumsum(self.counts)[:-1])
        shaped = [part.reshape(-1, self.scale.size) * self.scale for part in parts]
        return [np.clip(part, self.low, self.high) for part in shaped]

    def point(self, pulses: list[Array], nuisance: Array, shift: Array) -> _Point:
        """Simulate."""
        runs = range(len(pulses))
        errors = self.fitter.evaluate_all([self.trial(pulses[r], r, nuisance, shift) for r in runs])
        cost = sum(float(np.dot(e, e)) for e in errors)
        cost += float(np.sum(self.beliefs.misfit(shift) ** 2))
        return _Point(pulses, nuisance, shift, errors, cost)

    def penalty(self, point: _Point, level: float) -> float:
        """Cost of the pulses' own priors."""
        return level * float(np.dot(self.weight, self.flat(point.pulses) ** 2))

    def normal(self, point: _Point, level: float) -> tuple[Array, Array]:
        """J'J and J'e, with all priors."""
        b, runs = len(self.beliefs), range(len(point.pulses))
        own = NUISANCES if self.fitter.problem.free_start else 0
        size = self.n + b + own * len(point.pulses)
        hessian, gradient = np.zeros((size, size)), np.zeros(size)
        terms = joined([self.term(point.pulses[r], r) for r in runs])
        whole = Fit((*self.parent.terms, terms), point.nuisance, point.shift)
        locator = Locator(self.fitter, whole, point.errors)
        first = 0
        for r in runs:
            columns = locator.columns(r, pulses_of(self.effect, r, self.edges[r]))
            jacobian = np.hstack([np.stack(columns, axis=1), locator.background[r]])
            at = self.n + b + own * r
            place = np.r_[first : first + self.counts[r], self.n : self.n + b, at : at + own]
            hessian[np.ix_(place, place)] += jacobian.T @ jacobian
            gradient[place] += jacobian.T @ point.errors[r]
            first += self.counts[r]
        pulses = np.arange(self.n)
        hessian[pulses, pulses] += level * self.weight
        gradient[: self.n] += level * self.weight * self.flat(point.pulses)
        hessian[self.n : self.n + b, self.n : self.n + b] += self.beliefs.weight
        gradient[self.n : self.n + b] += self.beliefs.pull(point.shift)
        return hessian, gradient

    def moved(self, point: _Point, step: Array) -> _Point:
        """The point after a step."""
        b = len(self.beliefs)
        nuisance = point.nuisance.copy()
        rest = step[self.n + b :]
        if rest.size:
            nuisance += rest.reshape(nuisance.shape)
        pulses = self.split(self.flat(point.pulses) + step[: self.n])
        return self.point(pulses, nuisance, point.shift + step[self.n : self.n + b])


def sparse_course(
    fitter: Fitter, parent: Fit, effect: Effect, pulse_s: float | None = None
) -> tuple[AmplitudeCourse, Fit] | None:
    """Pulses of an effect fitted together with the vehicle.

    Parameters
    ----------
    fitter, parent
        Under the observer; what the effect is looked for on top of.
    effect
        In windows, its values sizes.
    pulse_s
        Length of a pulse; by default what the effect's module has.

    Returns
    -------
    tuple or None
        The course, and the parent with vehicle and start values as they are beside it. None: the
        recording is too long, or nothing fits. One round costs a simulation for each pulse.
    """
    length = pulse_s or float(str(effect.extra.get("pulse_s", PULSE_S)))
    work = _Sparse(fitter, parent, effect, length)
    if work.n > MOST_PULSES:
        return None
    zero = [np.zeros((e.size - 1, work.scale.size)) for e in work.edges]
    point = work.point(zero, parent.nuisance.copy(), parent.shift.copy())
    count = sum(e.size for e in point.errors)
    damping = 1e-3
    error = np.ones(work.n)
    for _ in range(ROUNDS):
        level = max(point.cost / count, 1.0)
        hessian, gradient = work.normal(point, level)
        before = point.cost + work.penalty(point, level)
        found = None
        for _ in range(6):
            full = hessian + np.diag(damping * np.diag(hessian) + 1e-9)
            step = np.asarray(-np.linalg.solve(full, gradient), dtype=float)
            trial = work.moved(point, step)
            if np.isfinite(trial.cost) and trial.cost + work.penalty(trial, level) < before:
                found = trial
                break
            damping *= 8.0
        if found is None:
            break
        settled = abs(point.cost - found.cost) < SETTLED * point.cost
        point, damping = found, max(0.1 * damping, 1e-6)
        own = np.linalg.inv(hessian + np.diag(1e-9 * np.diag(hessian) + 1e-12))
        variance = level * np.abs(np.diag(own)[: work.n])
        error = np.sqrt(variance)
        work.weight = 1.0 / (work.flat(point.pulses) ** 2 + variance + 1e-6)
        if settled:
            break
    errors = [
        part.reshape(-1, work.scale.size) * work.scale
        for part in np.split(error, np.cumsum(work.counts)[:-1])
    ]
    gain = parent.chi2 - point.cost
    course = AmplitudeCourse(effect, tuple(work.edges), tuple(point.pulses), tuple(errors), gain)
    return course, replace(parent, nuisance=point.nuisance, shift=point.shift, chi2=point.cost)
