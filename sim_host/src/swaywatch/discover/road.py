"""What goes with a motion in places of the road only: air in gaps of a wind, tyres on wet patches.

Under a strict observer a law changes what is left only while it acts, so one simulation of a law
that acts everywhere says what it would promise with any number of repetitions along the road.
What comes and goes whatever the motion is begun from `way.repetitions`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.search import Linear
from swaywatch.diagnose.fit.fit import Fit
from swaywatch.discover.begin import law_in, weak
from swaywatch.discover.effect import effect_of
from swaywatch.discover.grammar import of_bodies
from swaywatch.discover.law import (
    INSTANT,
    MOMENT,
    PERIODIC,
    SIDES,
    SLIPS,
    STOPS,
    Law,
    of_a_motion,
    one_way,
)
from swaywatch.discover.way import (
    AXLES,
    COARSE,
    DISTANCE,
    DRAG,
    FEWEST,
    MOST,
    MOST_GRIPS,
    SLOTS,
    behind_m,
    driven,
    longest_way_km,
    stretch,
)
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.runs import block_mean

Array = NDArray[np.float64]
Waves = NDArray[np.complex128]
#: What a law changes in each run, and by what its wave is behind that of others.
Part = tuple[Sequence[Array], Waves]

BEGUN = 10  # laws, of those that promise most, that are begun
NOTHING = 1e-6  # of what a law changes everywhere, which is no change


def promising(course: Linear) -> list[ActiveEffect]:
    """The laws of a motion that promise most in places of the road, with these places.

    O(laws x rates x blocks).
    """
    laws = of_bodies()
    changes = course.changes([weak(law) for law in laws])
    rates = np.arange(FEWEST, MOST, COARSE / longest_way_km(course.fitter.problem.runs))
    at_once = np.ones(rates.size, complex)
    parts = (((change, at_once),) for change in changes)
    return _first(course, rates, zip(laws, parts, strict=True))


def grips(course: Linear) -> list[ActiveEffect]:
    """The axles, or all of them as each comes there, whose tyres may grip more and less in places.

    What the stiffness of tyres does is what their own slip does as a steering angle.
    """
    problem = course.fitter.problem
    rates = np.arange(FEWEST, MOST_GRIPS, COARSE / longest_way_km(problem.runs))
    changes = list(course.changes([weak(Law(slip, slip)) for slip in SLIPS]))
    ends = ([behind_m(problem.body, slot) for slot, _ in SLOTS[slip]] for slip in SLIPS)
    late = (np.exp(-2j * np.pi * rates * float(np.mean(at)) / 1000.0) for at in ends)
    single = [((change, np.ones(rates.size, complex)),) for change in changes]
    every = tuple(zip(changes, late, strict=True))
    laws = [Law(place, place) for place in (*SLIPS, AXLES)]
    return _first(course, rates, zip(laws, (*single, every), strict=True))


def _first(
    course: Linear, rates: Array, laws: Iterable[tuple[Law, Sequence[Part]]]
) -> list[ActiveEffect]:
    """Of some laws those that promise most in places, each with the best ones."""
    runs = course.fitter.problem.runs
    ways = [block_mean(driven(run)) / 1000.0 for run in runs]
    waves = [np.exp(2j * np.pi * np.outer(rates, way)) for way in ways]
    found: list[tuple[float, ActiveEffect]] = []
    for law, parts in laws:
        in_places = replace(law, response=PERIODIC)
        gram, with_left = _products(course, parts, waves)
        drop, at, factor, phases = _best(gram, with_left, raised=of_a_motion(in_places))
        term = _begun(in_places, tuple(map(stretch, runs)), float(rates[at]), factor, phases)
        found.append((drop, term))
    found.sort(key=lambda pair: -pair[0])
    return [term for _, term in found[:BEGUN]]


def _products(course: Linear, parts: Sequence[Part], waves: Sequence[Waves]) -> tuple[Array, Array]:
    """Products of what acts all the time, and as sine and cosine along the road in each run.

    Parameters
    ----------
    parts
        What a law changes in each run, shape (blocks, channels), and its lag behind the others as a
        factor on the wave, shape (rates,): one of an axle that comes there later.
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
    late = [factor for _, factor in parts]
    first = 0
    for r, wave in enumerate(waves):
        own = [change[r] for change, _ in parts]
        whole = np.sum(own, axis=0)
        rows = slice(first, first + whole.size)
        first += whole.size
        left = course.left[rows].reshape(whole.shape)
        known = course.q[rows].reshape(*whole.shape, -1)
        gram[:, 0, 0] += np.sum(whole**2)
        with_left[:, 0] += np.sum(whole * left)
        with_known[:, 0] += np.einsum("bc,bck->k", whole, known)
        size, square = _squared(own, late, wave)
        sine, cosine = 1 + 2 * r, 2 + 2 * r
        gram[:, sine, sine] = 0.5 * (size - square.real)
        gram[:, cosine, cosine] = 0.5 * (size + square.real)
        gram[:, sine, cosine] = 0.5 * square.imag
        for rows_of, other in (
            (gram[:, 0], whole), (with_left, left), (with_known, known)
        ):  # fmt: skip
            found = _with(other, own, late, wave)
            rows_of[:, sine], rows_of[:, cosine] = found.imag, found.real
    above = np.triu_indices(unknowns, 1)
    gram[:, above[1], above[0]] = gram[:, above[0], above[1]]
    return gram - with_known @ with_known.transpose(0, 2, 1), with_left


def _with(other: Array, own: Sequence[Array], late: Sequence[Waves], wave: Waves) -> Waves:
    """Products of changes, each on its wave, with something in each block and channel; by rate."""
    found = 0.0
    for change, factor in zip(own, late, strict=True):
        each = wave @ np.einsum("bc,bc...->b...", change, other)
        found = found + (factor * each.T).T
    return np.asarray(found)


def _squared(own: Sequence[Array], late: Sequence[Waves], wave: Waves) -> tuple[Array, Waves]:
    """Of the sum of changes, each on its wave, the squared size and the square; by rate."""
    size = np.zeros(wave.shape[0])
    square = np.zeros(wave.shape[0], complex)
    for one, f in zip(own, late, strict=True):
        for other, g in zip(own, late, strict=True):
            power = np.sum(one * other, axis=1)
            size += np.sum(power) * (f * np.conj(g)).real
            square += f * g * (wave**2 @ power)
    return size, square


def _best(gram: Array, with_left: Array, *, raised: bool) -> tuple[float, int, float, Array]:
    """What a law promises in places, over what it promises everywhere; rate, size and phases.

    Phases are those of each run with any mean and size. With them it is of one size in all runs;
    raised: it comes and goes wholly, in either sense, so that half of it acts in the mean.
    Otherwise it goes to both sides of what the vehicle has.
    """
    unknowns = gram.shape[1]
    nothing = (0.0, 0, 0.0, np.zeros(unknowns // 2))
    everywhere = float(gram[0, 0, 0])
    if everywhere < NOTHING or not np.all(np.isfinite(gram)):
        return nothing
    safe = gram + NOTHING * everywhere * np.eye(unknowns)
    free = -np.linalg.solve(safe, with_left[:, :, None])[:, :, 0]
    angles = np.arctan2(free[:, 2::2], free[:, 1::2])
    best = nothing
    for way in (0.0, np.pi) if raised else (0.0,):
        share = np.full(free.shape, 0.5 * raised)
        wave = 0.5 if raised else 1.0
        share[:, 1::2], share[:, 2::2] = wave * np.cos(angles + way), wave * np.sin(angles + way)
        along = np.sum(share * with_left, axis=1)
        power = np.einsum("ri,rij,rj->r", share, safe, share)
        drops = along**2 / power - raised * with_left[0, 0] ** 2 / everywhere
        at = int(np.argmax(drops))
        if drops[at] > best[0]:
            best = float(drops[at]), at, float(-along[at] / power[at]), angles[at] + way
    return best


def _begun(
    law: Law, runs: tuple[str, ...], rate: float, factor: float, phases: Array
) -> ActiveEffect:
    """A law in places of the road, so many times as large as it was looked at."""
    one = Law(SLIPS[0], SLIPS[0]) if law.place == AXLES else law
    effect, sized = weak(replace(one, response=INSTANT))
    values = dict(zip((p.name for p in effect.parameters), sized, strict=True))
    gain = factor * values["gain"]
    if not of_a_motion(law):  # a sine of a negative size is one half a turn on
        gain, phases = abs(gain), phases + (np.pi if gain < 0.0 else 0.0)
    values |= {"gain": gain, "repetitions_per_km": rate}
    values |= {f"phase_{i + 1}_rad": float(x) for i, x in enumerate(phases)}
    return _with_values(law, runs, values)


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
    """A force or a moment in places of the road, begun as a force ahead of the COG or behind it."""
    term = fit.terms[-1]
    law = law_in(term)
    kind, _, body = law.place.partition("_")
    if not of_a_motion(law) or kind not in ("force", "moment"):
        return []
    there = replace(law, place=f"at_{body}")
    lever = next(p.starts[0] for p in effect_of(there, runs=runs).parameters if p.name == "ahead_m")
    gain = term.as_dict()["gain"]
    starts = ((x, gain if kind == "force" else gain / x) for x in (lever, -lever))
    return [_with_law(fit, there, runs, {"ahead_m": x, "gain": size}) for x, size in starts]


def _with_law(fit: Fit, law: Law, runs: tuple[str, ...], changes: Mapping[str, float]) -> Fit:
    """The fit with another law in the place of its own, with its values and these."""
    term = _with_values(law, runs, fit.terms[-1].as_dict() | dict(changes))
    return replace(fit, terms=(*fit.terms[:-1], term))


def _with_values(law: Law, runs: tuple[str, ...], values: Mapping[str, float]) -> ActiveEffect:
    """A law with these values, within their bounds, and otherwise its initial ones."""
    effect = effect_of(law, runs=runs)
    each = (min(max(values.get(p.name, p.starts[0]), p.low), p.high) for p in effect.parameters)
    return ActiveEffect(effect, tuple(each))
