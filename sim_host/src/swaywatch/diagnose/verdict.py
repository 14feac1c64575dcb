"""From a search to a verdict: which explanations are claimed, how surely, what is equivalent."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from swaywatch.diagnose.calibration import separation, stated
from swaywatch.diagnose.effect import Effect
from swaywatch.diagnose.fit import Fit, Fitter, Problem
from swaywatch.diagnose.roll import seen
from swaywatch.diagnose.search import Candidate, Progress, Search, level, priced
from swaywatch.diagnose.term import Term

#: Mean squared residual against the noise of each channel that clean recordings reach: 0.97 to
#: 1.15 in the practice cases once their effect is in the model. Above it something is left.
CLEAN = 1.15
#: Below it a second effect is not looked for.
PERFECT = 1.2
#: Share of the mismatch that the correction of a user's simulation leaves.
CORRECTION_SHARE = 0.05
#: Share of what windows explain that their form (sharp edges, one size) leaves.
WINDOW_FORM = 0.012
#: Nor a second effect in windows below this one: windows fit the form of the first.
SECOND_WINDOWED = 1.6
#: A second effect must lower the level by this share.
SECOND_SHARE = 0.04
#: Beside a correction or windows, whose form is not exact, by this one.
SECOND_BESIDE = 0.25
#: A third effect must lower it to this share: two are rare enough.
THIRD_SHARE = 0.5
SHORTEST_WINDOW_S = 0.6
#: A first effect must lower the level by this share.
FIRST_SHARE = 0.015
#: Above this level a verdict says that something unexplained remains.
REMAINS = 1.7
#: Above this one nothing is claimed firmly.
UNEXPLAINED = 3.5
#: unless the excess of the best rival is so many times larger.
APART = 5.0
#: Explanations whose excess over the clean level differs less than this cannot be told apart.
EQUIVALENT_SHARE = 0.06
#: The two readings of an accelerometer that shows too much.
ROLLED = ("sensor_gain", "sensor_roll_gravity")
#: Pairs that are the same in every planar signal.
TWINS = (
    ("steering_compliance:car_front", "parameter_error:car.front_cornering_stiffness"),
    ("sensor_gain:steering_wheel_angle", "parameter_error:car.steering_ratio"),
)


@dataclass
class Verdict:
    """What is claimed.

    Attributes
    ----------
    word
        One of the five verdicts.
    fit, baseline
        The model with and without the claimed effects.
    equivalents
        For each claimed term the names of effects that do as well.
    confidence
        For each claimed term.
    candidates
        Ranked alternatives (name, level).
    separation
        Of each claimed term: distance of the best explanation without it; see `calibration`.
    hidden
        Where nothing is claimed: sizes up to which effects could be there unseen.
    notes
        What remains, for `unexplained`.
    """

    word: str
    fit: Fit
    baseline: Fit
    equivalents: list[list[str]] = field(default_factory=list)
    confidence: list[float] = field(default_factory=list)
    candidates: list[tuple[str, float]] = field(default_factory=list)
    separation: list[float] = field(default_factory=list)
    hidden: list[dict[str, Any]] = field(default_factory=list)
    notes: list[dict[str, Any]] = field(default_factory=list)


def noticeable(term: Term) -> bool:
    """Tell whether an effect is large enough to be worth a claim, and not at a bound of its fit."""
    if not _inside(term):
        return False
    if term.effect.windowed:
        return any(_window_noticeable(term, w) for w in range(len(term.window_runs)))
    for value, p in zip(term.values, term.effect.parameters, strict=True):
        if abs(value - p.neutral) >= p.minimum:
            return True
    return False


def _hidden(singles: Sequence[Candidate]) -> list[dict[str, Any]]:
    """Largest size of each effect without windows that this recording cannot tell from none."""
    found = []
    for candidate in singles:
        term, covariance = candidate.fit.terms[-1], candidate.fit.covariance
        if term.effect.windowed or covariance.shape[0] < len(term.values):
            continue
        p = term.effect.parameters[0]
        error = math.sqrt(abs(float(covariance[-len(term.values), -len(term.values)])))
        room = abs(term.values[0] - p.neutral) + 3.0 * error * math.sqrt(level(candidate.fit))
        found.append(
            {"id": term.effect.id, "component": term.effect.component, "parameter": p.name,
             "neutral": p.neutral, "up_to": room}
        )  # fmt: skip
    return sorted(found, key=lambda row: (row["id"], row["component"]))


def _too_small(ranked: Sequence[Candidate], first: Candidate) -> bool:
    """Something too small to claim explains it better than the first that could be claimed."""
    top = ranked[0]
    return _inside(top.fit.terms[-1]) and priced(first.fit) > _limit(priced(top.fit))


def _inside(term: Term) -> bool:
    """No value that is worth a claim lies at a bound, where no effect of its kind could be."""
    for index, value in enumerate(term.values):
        p = term.parameter(index)
        if 0.0 < p.minimum < 1e6 and p.neutral not in (p.low, p.high):
            room = 1e-3 * (p.high - p.low)
            if not p.low + room < value < p.high - room:
                return False
    return True


def _window_noticeable(term: Term, window: int) -> bool:
    """Tell whether a window is long enough and its values large enough."""
    v = term.values[window * term.stride : (window + 1) * term.stride]
    if v[1] - v[0] < SHORTEST_WINDOW_S:
        return False
    return any(
        abs(x - p.neutral) >= p.minimum
        for x, p in zip(v[2:], term.effect.parameters, strict=True)
        if p.minimum > 0.0
    )


def _key(fit: Fit) -> tuple[str, ...]:
    return tuple(sorted(t.effect.name for t in fit.terms))


def _label(fit: Fit) -> str:
    return " + ".join(t.effect.name for t in fit.terms)


def decide(search: Search, progress: Progress) -> Verdict:
    """Run the search and choose."""
    progress("baseline", 0.02)
    base = search.baseline()
    clean = clean_level(search, base)
    progress("one effect", 0.08)
    singles = search.extend(base, everything=True)
    ranked = [(_label(c.fit), level(c.fit)) for c in singles]
    accepted = [c for c in singles if noticeable(c.fit.terms[-1])]
    first = _choose(accepted)
    if first is not None and _too_small(singles, first):
        first = None
    if first is None or not _worth_one(base, first.fit):
        cleared = Verdict("consistent", base, base, candidates=ranked[:8], hidden=_hidden(singles))
        if level(base) > REMAINS:
            cleared.word = "unexplained"
        return cleared
    first = _by_roll(search, accepted, first)
    progress("two effects", 0.55)
    best, alternatives = first, accepted
    if level(first.fit) > PERFECT + clean - CLEAN:
        pairs: list[Candidate] = []
        for index, single in enumerate(accepted[: search.beam]):
            if level(single.fit) > 4.0 * level(first.fit):
                break
            pairs += search.extend(single.fit, everything=False)
            progress("two effects", 0.55 + 0.12 * (index + 1))
        pairs = [c for c in pairs if all(noticeable(t) for t in c.fit.terms)]
        pairs.sort(key=lambda c: c.level)
        pair = _choose(pairs)
        exact = search.problem.free_start  # a correction is not: no use in searching on
        if pair is not None and exact and level(pair.fit) > REMAINS:
            pairs = search.swap(pair) + pairs
            pairs = [c for c in pairs if all(noticeable(t) for t in c.fit.terms)]
            pairs.sort(key=lambda c: c.level)
            pair = _choose(pairs)
        if pair is not None and _worth_two(base, first.fit, pair.fit, clean):
            best, alternatives = pair, pairs
            ranked = [(_label(c.fit), level(c.fit)) for c in pairs] + ranked
            ranked.sort(key=lambda item: item[1])
            progress("three effects", 0.85)
            three = _third(search, pairs) if exact and level(pair.fit) > REMAINS else []
            third = _choose(three)
            if third is not None and level(third.fit) < THIRD_SHARE * level(pair.fit):
                best, alternatives = third, three
                ranked = [(_label(c.fit), level(c.fit)) for c in three] + ranked
                ranked.sort(key=lambda item: item[1])
    progress("judging", 0.92)
    return _verdict(search, base, best, alternatives, accepted, ranked)


def _third(search: Search, pairs: Sequence[Candidate]) -> list[Candidate]:
    """The best pairs, each with one more effect, best first."""
    seen: set[tuple[str, ...]] = set()
    found: list[Candidate] = []
    for pair in pairs:
        if _key(pair.fit) in seen:
            continue
        seen.add(_key(pair.fit))
        found += search.extend(pair.fit, everything=False)
        if len(seen) == search.beam:
            break
    found = [c for c in found if all(noticeable(t) for t in c.fit.terms)]
    return sorted(found, key=lambda c: c.level)


def settle(verdict: Verdict, problem: Problem) -> None:
    """Refit what was found in free simulation; kept where it converges nearby.

    Against a user's simulation only the start changes to that of the free correction: what is
    small there is told by the observer alone.
    """
    if problem.start_nuisance is not None and problem.start_shared is not None:
        nuisance, shared = problem.start_nuisance, problem.start_shared
        verdict.baseline = replace(verdict.baseline, nuisance=nuisance, shared=shared)
        verdict.fit = replace(verdict.fit, nuisance=nuisance, shared=shared)
        return
    fitter = Fitter(problem)
    free = fitter.run(verdict.baseline, 8)
    verdict.baseline = replace(verdict.baseline, nuisance=free.nuisance)
    if not verdict.fit.terms:
        verdict.fit = verdict.baseline
        return
    found = fitter.run(verdict.fit, 10, shared_free=True, tolerance=1e-4)
    before = [v for t in verdict.fit.terms for v in t.values]
    after = [v for t in found.terms for v in t.values]
    near = all(abs(b - a) <= 0.25 * abs(a) + 0.05 for a, b in zip(before, after, strict=True))
    if near:
        chi2, count = verdict.fit.chi2, verdict.fit.count
        verdict.fit = replace(found, chi2=chi2, count=count)
        return
    still = fitter.run(verdict.fit, 8, free=0)
    verdict.fit = replace(verdict.fit, nuisance=still.nuisance)


def _worth_one(base: Fit, one: Fit) -> bool:
    """A first effect must lower the level noticeably, more so with windows to choose."""
    share = FIRST_SHARE + 0.01 * sum(len(t.window_runs) for t in one.terms)
    return level(one) < (1.0 - share) * level(base)


def clean_level(search: Search, base: Fit) -> float:
    """Level at which nothing is left to explain.

    Against a user's simulation our plant is only the correction, good to about a tenth: the larger
    the mismatch, the more of it stays.
    """
    own = bool(search.problem.runs[0].correction)
    return CLEAN + (CORRECTION_SHARE * level(base) if own else 0.0)


def _worth_two(base: Fit, one: Fit, two: Fit, clean: float) -> bool:
    """A second effect is claimed only if the first leaves much and the second explains it."""
    added = two.terms[-1].effect
    clean += (
        WINDOW_FORM * max(level(base) - level(one), 0.0) * any(t.effect.windowed for t in one.terms)
    )
    extra = clean - CLEAN
    if level(one) < extra + (SECOND_WINDOWED if added.windowed else PERFECT):
        return False
    excess_one, excess_two = level(one) - clean + 0.15, level(two) - clean + 0.15
    windows = [sum(len(t.window_runs) for t in fit.terms) for fit in (one, two)]
    share = SECOND_SHARE if extra == 0.0 else SECOND_BESIDE
    share += 0.01 * max(windows[1] - windows[0], 0)
    return level(two) < (1.0 - share) * level(one) and excess_two < 0.5 * excess_one


def _choose(ranked: Sequence[Candidate]) -> Candidate | None:
    """The best; among equals the more plausible."""
    if not ranked:
        return None
    top = ranked[0]
    limit = _limit(priced(top.fit))
    equals = [c for c in ranked if priced(c.fit) <= limit]
    return max(equals, key=lambda c: (sum(_plausibility(t) for t in c.fit.terms), -c.level))


def _by_roll(search: Search, ranked: Sequence[Candidate], chosen: Candidate) -> Candidate:
    """Gain or gravity in an accelerometer, where both do: the better fit decides.

    Roll has to lag as the wheel loads do, so that both have one number to fit. Beside a simulation
    with suspensions loads lead the roll, by their dampers: the lag stays free, and is paid for.
    """
    mine = chosen.fit.terms[-1].effect
    if mine.id not in ROLLED or not mine.component.endswith("lateral_acceleration"):
        return chosen
    rest = [t.effect.name for t in chosen.fit.terms[:-1]]
    pair = {
        c.fit.terms[-1].effect.id: c
        for c in reversed(ranked)
        if c.fit.terms[-1].effect.component == mine.component
        and [t.effect.name for t in c.fit.terms[:-1]] == rest
        and priced(c.fit) <= _limit(priced(ranked[0].fit))
    }
    if not all(id_ in pair for id_ in ROLLED):
        return chosen
    dynamics = seen(search.problem.runs) if search.problem.free_start else None
    if dynamics is None:
        return min(pair.values(), key=lambda c: priced(c.fit))
    rolled = pair["sensor_roll_gravity"].fit
    effect = rolled.terms[-1].effect
    known = tuple(
        replace(p, low=value, high=value)
        for p, value in zip(effect.parameters[1:], dynamics, strict=True)
    )
    term = Term(
        replace(effect, parameters=(effect.parameters[0], *known)),
        (rolled.terms[-1].values[0], *dynamics),
    )
    fit = replace(rolled, terms=(*rolled.terms[:-1], term))
    fit = search.exact.run(fit, 6, shared_free=search.problem.free_start, tolerance=1e-5)
    better = fit.chi2 < pair["sensor_gain"].fit.chi2
    return pair["sensor_roll_gravity" if better else "sensor_gain"]


def _limit(best: float) -> float:
    return best + max(EQUIVALENT_SHARE * (best - CLEAN), 0.015 * best)


def _plausibility(term: Term) -> float:
    """Prior rank of equal explanations: few free numbers, ordinary values."""
    effect: Effect = term.effect
    score = effect.plausibility - 0.02 * len(term.values)
    if effect.id == "steering_compliance":
        score += 0.5
    if effect.id == "sensor_gain" and effect.component == "steering_wheel_angle":
        score -= 0.2
    return score


def _verdict(
    search: Search,
    base: Fit,
    best: Candidate,
    alternatives: Sequence[Candidate],
    singles: Sequence[Candidate],
    ranked: list[tuple[str, float]],
) -> Verdict:
    fit = best.fit
    terms = sorted(fit.terms, key=lambda t: -_loss(search, fit, t))
    fit = _ordered(fit, terms)
    reached = level(fit)
    cost = priced(fit)
    limit = _limit(cost)
    equals = [c for c in alternatives if priced(c.fit) <= limit and c is not best]
    equivalents = [_equivalents(term, terms, equals) for term in terms]
    others = [
        level(c.fit) for c in alternatives if c is not best and priced(c.fit) > limit
        and _key(c.fit) != _key(fit)
        and not any(e in _key(c.fit) for group in equivalents for e in group)
    ]  # fmt: skip
    rival = others[0] if others else level(base)
    scores = []
    for term, group in zip(terms, equivalents, strict=True):
        same = {term.effect.name, *group}
        without = [priced(c.fit) for c in (*alternatives, *singles) if not same & set(_key(c.fit))]
        scores.append(separation(level(base), cost, min([level(base), *without])))
    confidence = [
        round(stated(score, shared=bool(group)), 3)
        for score, group in zip(scores, equivalents, strict=True)
    ]
    kinds = {t.effect.kind for t in terms}
    word = {"physics": "missing_physics", "measurement": "measurement_fault"}.get(
        terms[0].effect.kind, "parameter_error"
    )
    if "physics" in kinds:
        word = "missing_physics"
    result = Verdict(word, fit, base, equivalents, confidence, ranked[:8], separation=scores)
    more = clean_level(search, base) - CLEAN
    if reached > UNEXPLAINED + more:
        apart = (rival - CLEAN) / (reached - CLEAN)
        if apart < APART:
            result.word = "unexplained"
        most = 0.4 if apart < APART else 0.8
        result.confidence = [round(min(c, most), 3) for c in confidence]
    return result


def _equivalents(term: Term, terms: Sequence[Term], equals: Sequence[Candidate]) -> list[str]:
    """Names that could stand in a term's place."""
    rest = {t.effect.name for t in terms if t is not term}
    names: set[str] = set()
    for candidate in equals:
        theirs = {t.effect.name for t in candidate.fit.terms}
        if rest <= theirs:
            names |= theirs - rest - {term.effect.name}
    for twin in TWINS:
        if term.effect.name in twin:
            other = twin[1 - twin.index(term.effect.name)]
            if _possible_twin(term, other):
                names.add(other)
    return sorted(names)


def _possible_twin(term: Term, other: str) -> bool:
    """Compliance can only soften the front axle."""
    if other.startswith("steering_compliance"):
        return term.values[0] < 1.0
    return True


def _loss(search: Search, fit: Fit, term: Term) -> float:
    """Rise of chi2 when a term is taken out and nothing refitted."""
    rest = tuple(t for t in fit.terms if t is not term)
    total = 0.0
    for r in range(len(search.problem.runs)):
        e = search.fitter.evaluate(r, rest, fit.nuisance[r], fit.shared)
        total += float(np.dot(e, e))
    return total


def _ordered(fit: Fit, terms: Sequence[Term]) -> Fit:
    """The fit with its terms, and their covariance, in another order."""
    covariance = fit.covariance
    sizes = [len(t.values) for t in fit.terms]
    if covariance.shape[0] == sum(sizes):
        starts = [sum(sizes[:i]) for i in range(len(sizes))]
        place = {id(t): i for i, t in enumerate(fit.terms)}
        order = [starts[place[id(t)]] + j for t in terms for j in range(len(t.values))]
        covariance = covariance[np.ix_(order, order)]
    return replace(fit, terms=tuple(terms), covariance=covariance)
