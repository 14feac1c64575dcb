"""Explanations of the same size as the best one, each with another effect in one's place.

A search fits what promises most and goes on from what it finds: near the critical speed a fit that
is not at its end yet says little of where it would end. So what is found is compared once more.
About its own, good fit a first-order course says much: of what one of its effects explains it tells
how much each other effect explains as well, vehicle and sensors free within their tolerances. Those
that explain nearly all of it are fitted to the end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.search import FAR, Linear, Search
from swaywatch.diagnose.fit.fit import Fit, Fitter, Trial, slope
from swaywatch.effects.active import ActiveEffect

Array = NDArray[np.float64]

#: Of what an effect explains, the share that another one explains in its place to first order,
#: from which it is fitted.
SHARE = 0.8
MOST = 3  # in place of one effect
STEP = 1e-3  # of a value's scale, for its derivative


@dataclass(frozen=True)
class Contender:
    """An explanation with another effect in one's place.

    Attributes
    ----------
    start
        Where its fit begins.
    share
        Of what the effect explains, what the other one explains to first order.
    """

    start: Fit
    share: float


def rivals(search: Search, fit: Fit, index: int) -> list[Contender]:
    """Explanations with another effect, one without windows, in the place of the effect `index`.

    Best first.
    """
    slopes = _slopes(search.judge, fit)
    others = [s for i, s in enumerate(slopes) if i != index]
    course = Linear(search.judge, fit, np.hstack(others) if others else None)
    without = course.left + course.column(slopes[index] @ _to_neutral(fit.terms[index]))
    explained = float(np.dot(without, without) - np.dot(course.left, course.left))
    if not explained > 0.0:
        return []
    course.left = without
    taken = {t.effect.name for t in fit.terms}
    open_ = [e for e in search.effects if not e.windowed and e.name not in taken]
    found = []
    for gain, values, effect in course.best(open_, shaped=False):
        term = ActiveEffect(effect, values)
        terms = (*fit.terms[:index], *fit.terms[index + 1 :], term)
        found.append(Contender(replace(fit, terms=terms), gain / explained))
    return found


def fitted(search: Search, fit: Fit, index: int, tried: set[tuple[str, ...]]) -> list[Fit]:
    """Fits, to the end, of those that may explain as much; `tried` (names of effects) grows."""
    starts: list[Fit] = []
    for rival in rivals(search, fit, index):
        names = tuple(sorted(t.effect.name for t in rival.start.terms))
        if rival.share > SHARE and names not in tried and len(starts) < MOST:
            tried.add(names)
            starts.append(rival.start)
    return [f for f in to_the_end(search, starts, afresh=False) if np.isfinite(f.chi2)]


def to_the_end(search: Search, starts: Sequence[Fit], *, afresh: bool = True) -> list[Fit]:
    """Fits from where they stand and, `afresh`, also from the vehicle as believed.

    A vehicle that was fitted without the effect is bent to make up for it, and may not find back.
    Not so those in windows, whose edges would not.
    """

    def fit_of(start: Fit) -> Fit:
        return search.judge.run(start, 30, tolerance=1e-4)

    near = search.judge.side_by_side(fit_of, starts)
    lasting = [afresh and not any(t.effect.windowed for t in f.terms) for f in near]
    again = search.from_rest([f for f, last in zip(near, lasting, strict=True) if last])
    rest = iter(search.judge.side_by_side(fit_of, again))
    return [
        min(f, next(rest), key=lambda g: g.chi2) if last else f
        for f, last in zip(near, lasting, strict=True)
    ]


def _slopes(fitter: Fitter, fit: Fit) -> list[Array]:
    """Derivatives of the residuals to the values of each active effect, (residuals, values)."""
    runs = range(len(fitter.problem.runs))
    moved: list[tuple[ActiveEffect, ...]] = [fit.terms]
    steps: list[list[float]] = []
    for i, term in enumerate(fit.terms):
        steps.append([])
        for j, value in enumerate(term.values):
            p = term.bounded(j, fitter.problem.runs)
            step = STEP * float(p.scale)
            step = step if value + step <= p.high else -step
            values = (*term.values[:j], value + step, *term.values[j + 1 :])
            moved.append((*fit.terms[:i], replace(term, values=values), *fit.terms[i + 1 :]))
            steps[i].append(step)
    trials = [Trial(r, terms, fit.nuisance[r], fit.shift) for terms in moved for r in runs]
    found = fitter.evaluate_all(trials)
    flat = [np.concatenate(found[k * len(runs) : (k + 1) * len(runs)]) for k in range(len(moved))]
    base, rest = flat[0], iter(flat[1:])
    return [np.stack([slope(next(rest), base, h) for h in own], axis=1) for own in steps]


def _to_neutral(term: ActiveEffect) -> Array:
    """By what its values change until it is gone, to first order; shape and windows stay."""
    found = np.zeros(len(term.values))
    for j, value in enumerate(term.values):
        p = term.parameter(j)
        if not (p.shapes or term.is_edge(j)):
            # what is neutral at infinity vanishes with its inverse
            found[j] = value if abs(p.neutral) > FAR else p.neutral - value
    return found
