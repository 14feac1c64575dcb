"""What goes with a motion in places of the road only: air in the gaps that a wind blows through.

Under a strict observer a law changes what is left only while it acts, so one simulation of a law
that acts everywhere says what it would promise with any number of repetitions along the road.
What comes and goes whatever the motion is begun from `way.repetitions`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.search import Linear
from swaywatch.diagnose.fit.fit import Fit
from swaywatch.discover.begin import law_in, weak
from swaywatch.discover.effect import effect_of
from swaywatch.discover.grammar import of_bodies
from swaywatch.discover.law import MOMENT, PERIODIC, SIDES, STOPS, Law, of_a_motion, one_way
from swaywatch.discover.way import (
    DISTANCE,
    DRAG,
    FEWEST,
    GRIP_FINENESS,
    MOST,
    driven,
    longest_way_km,
    stretch,
)
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.runs import block_mean

Array = NDArray[np.float64]
Waves = NDArray[np.complex128]

BEGUN = 12  # laws, of those that promise most, that are begun
NOTHING = 1e-6  # of what a law changes everywhere, which is no change


def promising(course: Linear) -> list[ActiveEffect]:
    """The laws of a motion that promise most in places of the road, with these places.

    O(laws x rates x blocks).
    """
    runs = course.fitter.problem.runs
    rates = np.arange(FEWEST, MOST, GRIP_FINENESS / longest_way_km(runs))
    ways = [block_mean(driven(run)) / 1000.0 for run in runs]
    waves = [np.exp(2j * np.pi * np.outer(rates, way)) for way in ways]
    names = tuple(map(stretch, runs))
    laws = of_bodies()
    found: list[tuple[float, ActiveEffect]] = []
    for law, change in zip(laws, course.changes([weak(law) for law in laws]), strict=True):
        drop, at, factor, phases = _best(*_products(course, change, waves))
        found.append((drop, _begun(law, names, float(rates[at]), factor, phases)))
    found.sort(key=lambda pair: -pair[0])
    return [term for _, term in found[:BEGUN]]


def _products(
    course: Linear, change: Sequence[Array], waves: Sequence[Waves]
) -> tuple[Array, Array]:
    """Products of what acts all the time, and as sine and cosine along the road in each run.

    Parameters
    ----------
    change
        What a law changes in each run, shape (blocks, channels).
    waves
        Of each run, shape (rates, blocks).

    Returns
    -------
    tuple
        With each other, shape (rates, n, n), and with what is left, shape (rates, n), the rest
        refitted; n = 1 + 2 runs.
    """
    count, unknowns = waves[0].shape[0], 1 + 2 * len(waves)
    gram = np.zeros((count, unknowns, unknowns))
    with_left = np.zeros((count, unknowns))
    with_known = np.zeros((count, unknowns, course.q.shape[1]))
    first = 0
    for r, (own, wave) in enumerate(zip(change, waves, strict=True)):
        rows = slice(first, first + own.size)
        first += own.size
        power = np.sum(own**2, axis=1)
        left = np.sum(own * course.left[rows].reshape(own.shape), axis=1)
        known = np.einsum("bc,bck->bk", own, course.q[rows].reshape(*own.shape, -1))
        sine, cosine = 1 + 2 * r, 2 + 2 * r
        gram[:, 0, 0] += np.sum(power)
        once, twice = wave @ power, wave**2 @ power
        gram[:, 0, sine], gram[:, 0, cosine] = once.imag, once.real
        gram[:, sine, sine] = 0.5 * (np.sum(power) - twice.real)
        gram[:, cosine, cosine] = 0.5 * (np.sum(power) + twice.real)
        gram[:, sine, cosine] = 0.5 * twice.imag
        with_left[:, 0] += np.sum(left)
        with_left[:, sine], with_left[:, cosine] = (wave @ left).imag, (wave @ left).real
        with_known[:, 0] += np.sum(known, axis=0)
        of_known = wave @ known
        with_known[:, sine], with_known[:, cosine] = of_known.imag, of_known.real
    above = np.triu_indices(unknowns, 1)
    gram[:, above[1], above[0]] = gram[:, above[0], above[1]]
    return gram - with_known @ with_known.transpose(0, 2, 1), with_left


def _best(gram: Array, with_left: Array) -> tuple[float, int, float, Array]:
    """What a law promises in places, over what it promises everywhere; rate, size and phases.

    Phases are those of each run with any mean and size; with them it comes and goes wholly, so that
    half of it acts in the mean, and is of one size in all runs, in either sense.
    """
    unknowns = gram.shape[1]
    everywhere = float(gram[0, 0, 0])
    if everywhere < NOTHING or not np.all(np.isfinite(gram)):
        return 0.0, 0, 0.0, np.zeros(unknowns // 2)
    safe = gram + NOTHING * everywhere * np.eye(unknowns)
    free = -np.linalg.solve(safe, with_left[:, :, None])[:, :, 0]
    angles = np.arctan2(free[:, 2::2], free[:, 1::2])
    best = (0.0, 0, 0.0, np.zeros(unknowns // 2))
    for way in (0.0, np.pi):
        share = np.full(free.shape, 0.5)
        share[:, 1::2], share[:, 2::2] = 0.5 * np.cos(angles + way), 0.5 * np.sin(angles + way)
        along = np.sum(share * with_left, axis=1)
        power = np.einsum("ri,rij,rj->r", share, safe, share)
        drops = along**2 / power - with_left[0, 0] ** 2 / everywhere
        at = int(np.argmax(drops))
        if drops[at] > best[0]:
            size = float(-along[at] / power[at])
            best = float(drops[at]), at, size, np.asarray(angles[at] + way)
    return best


def _begun(
    law: Law, runs: tuple[str, ...], rate: float, factor: float, phases: Array
) -> ActiveEffect:
    """A law in places of the road, so many times as large as it was looked at."""
    effect, sized = weak(law)
    values = dict(zip((p.name for p in effect.parameters), sized, strict=True))
    values |= {"gain": factor * values["gain"], "repetitions_per_km": rate}
    values |= {f"phase_{i + 1}_rad": float(x) for i, x in enumerate(phases)}
    return _with_values(replace(law, response=PERIODIC), runs, values)


def pulses(fit: Fit, runs: tuple[str, ...]) -> list[Fit]:
    """What comes and goes in one direction, begun in shorter pulses."""
    law = law_in(fit.terms[-1])
    return [_with_law(fit, replace(law, shape=STOPS[0]), runs, {})] if one_way(law) else []


def of_air(fit: Fit, runs: tuple[str, ...]) -> list[Fit]:
    """A force that comes and goes, begun as one that grows with the square of the speed."""
    law = law_in(fit.terms[-1])
    if law.motion != DISTANCE or law.power:
        return []
    return [_with_law(fit, replace(law, power=2), runs, {})]


def dragging(fit: Fit, runs: tuple[str, ...]) -> list[Fit]:
    """A moment on the trailer that comes and goes, begun as one of wheels that drag."""
    law = law_in(fit.terms[-1])
    if law.place != MOMENT or law.motion != DISTANCE:
        return []
    return [_with_law(fit, replace(law, place=DRAG), runs, {})]


def halves(fit: Fit, runs: tuple[str, ...]) -> list[Fit]:
    """What comes and goes, begun in one direction only: in either, with the same sine."""
    term = fit.terms[-1]
    law, known = law_in(term), term.as_dict()
    half = replace(law, shape=SIDES[0])
    if one_way(law):
        return []
    if of_a_motion(law):  # it acts one way already
        return [_with_law(fit, half, runs, {})]
    found = []
    for sign in (1.0, -1.0):  # half a sine contains half of its size as a sine
        turned = {
            name: x if sign > 0.0 else x - math.copysign(math.pi, x)
            for name, x in known.items()
            if name.startswith("phase_")
        }
        changes = turned | {"gain": 2.0 * sign * known["gain"]}
        found.append(_with_law(fit, half, runs, changes))
    return found


def ahead(fit: Fit, runs: tuple[str, ...]) -> list[Fit]:
    """A force or a moment in places of the road, begun as a force ahead of the centre of gravity.

    Or behind it.
    """
    term = fit.terms[-1]
    law = law_in(term)
    kind, _, body = law.place.partition("_")
    there = f"at_{body}"
    if not of_a_motion(law) or kind not in ("force", "moment"):
        return []
    other = replace(law, place=there)
    lever = next(p for p in effect_of(other, runs=runs).parameters if p.name == "ahead_m").starts[0]
    gain = term.as_dict()["gain"]
    return [
        _with_law(
            fit,
            other,
            runs,
            {"ahead_m": x, "gain": gain if kind == "force" else gain / x},
        )
        for x in (lever, -lever)
    ]


def _with_law(fit: Fit, law: Law, runs: tuple[str, ...], changes: Mapping[str, float]) -> Fit:
    """The fit with another law in the place of its own, with its values and these."""
    term = _with_values(law, runs, fit.terms[-1].as_dict() | dict(changes))
    return replace(fit, terms=(*fit.terms[:-1], term))


def _with_values(law: Law, runs: tuple[str, ...], values: Mapping[str, float]) -> ActiveEffect:
    """A law with these values, within their bounds, and otherwise its initial ones."""
    effect = effect_of(law, runs=runs)
    each = (min(max(values.get(p.name, p.starts[0]), p.low), p.high) for p in effect.parameters)
    return ActiveEffect(effect, tuple(each))
