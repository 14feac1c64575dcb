"""What laws promise, and the values that each is begun with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from swaywatch.diagnose.evidence.search import Linear
from swaywatch.diagnose.fit.fit import Fit
from swaywatch.discover.effect import OF_A_SHAPE, effect_of
from swaywatch.discover.forms import curve
from swaywatch.discover.free import form_of
from swaywatch.discover.grammar import FREQUENCIES_HZ, grammar, of_two, products, refined
from swaywatch.discover.law import (
    ANYWHERE,
    CURVE,
    INSTANT,
    LAGGED,
    LIMITED,
    MOTIONS,
    OF_EACH_RUN,
    OSCILLATING,
    PLACES,
    SHAPES,
    Law,
)
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect

PAIRED = 32  # laws of two variables that are begun from each vehicle
SHORT_LIST = 12  # laws that are fitted under the observer
FORMS = 8  # of one place and variable that come first
WEAKER = 0.25  # times its initial size, at which a law is looked at
#: Times the initial value at which a bend is looked at: where a law levels off, where others bend.
EARLY, BENT = (0.1, 0.4, 1.0), (0.5, 1.0, 2.0)
LATER = {"lag_s": 3.0, "frequency_hz": 2.0}  # the same of a lag and a frequency, beside it


def law_in_effect(effect: Effect) -> Law:
    """The law that an effect of one has."""
    law = effect.extra["law"]
    assert isinstance(law, Law)
    return law


def law_in(term: ActiveEffect) -> Law:
    """The law of a term of one."""
    return law_in_effect(term.effect)


def weak(law: Law) -> tuple[Effect, tuple[float, ...]]:
    """A law as it is looked at: acting all the time, of a size to which all is in proportion."""
    effect = effect_of(law)
    size, *rest = (p.starts[0] for p in effect.parameters)
    return effect, (WEAKER * size, *rest)


def runs_of(term: ActiveEffect, law: Law) -> tuple[str, ...]:
    """The runs that another form of a term's law has numbers for."""
    runs = term.effect.extra["runs"]
    assert isinstance(runs, tuple)
    return runs if law.response in OF_EACH_RUN else ()


def linear_laws(course: Linear) -> list[ActiveEffect]:
    """The linear laws and oscillating masses with the largest gain in the linearised fit."""
    best: dict[tuple[str, int], tuple[float, tuple[float, ...], Effect]] = {}
    # a frequency must not be extrapolated: each start keeps its own
    for row in course.best(grammar(), shaped=False):
        best.setdefault((row[2].component, _band(row[2])), row)
    ranked = sorted(best.values(), key=lambda row: -row[0])[:SHORT_LIST]
    return [ActiveEffect(effect, values) for _, values, effect in ranked]


def best_of_each_law(fits: Sequence[Fit]) -> list[Fit]:
    """The best fit of each law, the best first."""
    kept: dict[Law, Fit] = {}
    for fit in sorted(fits, key=lambda f: f.chi2):
        kept.setdefault(law_in(fit.terms[-1]), fit)
    return list(kept.values())


def of_two_variables(course: Linear) -> list[ActiveEffect]:
    """The laws of two variables that promise most together, to first order."""
    singles = [e for e in grammar() if law_in_effect(e).place in PLACES]
    tried = [(e, (WEAKER * e.parameters[0].starts[0], *_rest(e))) for e in singles]
    columns = course.columns(tried)
    found = []
    for i, one in enumerate(singles):
        for j, other in enumerate(singles):
            law = replace(law_in_effect(one), second=law_in_effect(other).motion)
            if law_in_effect(one).power != law_in_effect(other).power or law not in of_two(
                law_in_effect(one)
            ):
                continue
            a = np.stack([columns[i], columns[j]], axis=1)
            x = np.linalg.lstsq(a, -course.left, rcond=1e-9)[0]
            rest = course.left + a @ x
            gains = [x[k] * tried[m][1][0] for k, m in ((0, i), (1, j))]
            found.append((float(np.dot(rest, rest)), law, gains))
    found.sort(key=lambda row: row[0])
    kept: dict[frozenset[str], ActiveEffect] = {}
    for _, law, (first, second) in found:
        effect = effect_of(law)
        values = {"gain": first, "second_share": second / first if first else 0.0}
        inside = (
            min(max(values.get(p.name, p.starts[0]), p.low), p.high) for p in effect.parameters
        )
        name = frozenset((law.place, law.motion, law.second, str(law.power)))
        kept.setdefault(name, ActiveEffect(effect, tuple(inside)))
    return list(kept.values())[:PAIRED]


def of_a_product(course: Linear) -> list[ActiveEffect]:
    """The laws that the size of another motion multiplies and that promise most, to first order."""
    terms = [initial(law)[0] for law in products()]
    return by_promise(course, terms)[:PAIRED]


def _rest(effect: Effect) -> tuple[float, ...]:
    """Initial values of what is not the size of an effect."""
    return tuple(p.starts[0] for p in effect.parameters[1:])


def by_promise(course: Linear, terms: Sequence[ActiveEffect]) -> list[ActiveEffect]:
    """Of each law the values that promise the largest drop of the misfit, the best first.

    What a law changes near the recording is in proportion to its size, so that is what the look at
    a weak one says; what it has beside its size is looked at in turn (`looks`).
    """
    firsts: dict[Law, ActiveEffect] = {}
    for term in terms:
        firsts.setdefault(law_in(term), term)
    tried = [look for term in firsts.values() for look in looks(term)]
    promised = sorted(course.sized(tried), key=lambda pair: -pair[0])
    best: dict[Law, ActiveEffect] = {}
    for _, term in promised:
        best.setdefault(law_in(term), term)
    return _spread(list(best.values()))


def _spread(ranked: Sequence[ActiveEffect]) -> list[ActiveEffect]:
    """So ordered that no place with its variable takes up the list with its many forms.

    The form is looked for again once place and variable are known.
    """
    forms: dict[str, int] = {}
    first: list[ActiveEffect] = []
    later: list[ActiveEffect] = []
    for term in ranked:
        name = term.effect.component
        forms[name] = forms.get(name, 0) + 1
        (first if forms[name] <= FORMS else later).append(term)
    return [*first, *later]


def looks(term: ActiveEffect) -> list[ActiveEffect]:
    """A law as weak as it is proportional to its size, with some values of what else it has.

    What bends, bends early and late too; what is late, or oscillates, is looked at later and
    quicker; what acts ahead of the centre of gravity, as far behind it.
    """
    law = law_in(term)
    found = [_with(term, {term.effect.parameters[0].name: WEAKER})]
    if "bend" in term.as_dict():
        bends = EARLY if law.shape in LIMITED else BENT
        found = [_with(look, {"bend": times}) for look in found for times in bends]
    also = {LAGGED: "lag_s", OSCILLATING: "frequency_hz"}.get(law.response)
    if also:
        found += [_with(look, {also: LATER[also]}) for look in found]
    if law.place in ANYWHERE:
        found += [_with(look, {"ahead_m": -1.0}) for look in found]
    return found


def _with(term: ActiveEffect, times: Mapping[str, float]) -> ActiveEffect:
    """Some values so many times as large, within their bounds."""
    values = (
        min(max(times.get(p.name, 1.0) * x, p.low), p.high)
        for p, x in zip(term.effect.parameters, term.values, strict=True)
    )
    return replace(term, values=tuple(values))


def in_other_forms(straight: ActiveEffect) -> list[ActiveEffect]:
    """A linear law in other shapes, with initial values."""
    law = law_in(straight)
    if law.swings:  # with a gap or a drag: the values of the oscillation, and initial ones
        more = [effect_of(other, straight.as_dict()["frequency_hz"]) for other in refined(law)]
        known = straight.values
        return [
            ActiveEffect(e, (*known, *(p.starts[0] for p in e.parameters[len(known) :])))
            for e in more
        ]
    return [in_form(straight, other) for other in refined(law)]


def _strength(shape: str, usual: float, bend: float) -> float:
    """A shape, of gain one, at its largest up to an amplitude of its variable."""
    sides = (np.linspace(0.0, usual, 100), np.linspace(0.0, -usual, 100))
    return max(float(np.max(np.abs(curve(shape, side, bend)))) for side in sides)


def in_form(term: ActiveEffect, law: Law) -> ActiveEffect:
    """A law in another shape, with initial values that make it as strong as the one given.

    At the usual amplitude of the variable (beyond a dead zone) both are of one size: a law that is
    many times stronger than the usual initial values of its shape is not found from those.
    """
    own, known, effect = law_in(term), term.as_dict(), effect_of(law, runs=runs_of(term, law))
    values = {p.name: known.get(p.name, p.starts[0]) for p in effect.parameters}
    if own.shape == CURVE and law.shape != CURVE:
        like = form_of(known, law)
        values |= {name: value for name, value in like.items() if name in values}
    elif law.shape != own.shape and "gain" in known:
        begun = {p.name: p.starts[0] for p in effect.parameters if p.name in OF_A_SHAPE}
        values |= begun
        bend = sum(known.get(name, 0.0) for name in OF_A_SHAPE)
        usual = max(MOTIONS[law.motion].usual, 2.0 * known.get("bend", 0.0))
        before = _strength(own.shape, usual, bend)
        values["gain"] *= before / _strength(law.shape, usual, sum(begun.values()))
    if "gain" in values:
        values["gain"] *= per_size(own, law)
    inside = (min(max(values[p.name], p.low), p.high) for p in effect.parameters)
    return ActiveEffect(effect, tuple(inside))


def per_size(own: Law, law: Law) -> float:
    """Factor on a gain that keeps a law as large at the usual size of what multiplies it.

    Where that multiplies the one law and not the other.
    """
    before = MOTIONS[own.times].usual if own.times else 1.0
    return before / MOTIONS[law.times].usual if law.times else before


def crossed(fits: Sequence[Fit], most: int) -> list[Fit]:
    """Shapes of some fits behind a lag, or with the response of a line of the same motion there.

    What acts beyond a dead zone and late is seen half by either: both come near the recording, and
    laws that have nothing of it may come nearer than each.
    """
    best = best_of_each_law(fits)
    lines = [law_in(fit.terms[-1]) for fit in best]
    found: list[Fit] = []
    for fit in best:
        law = law_in(fit.terms[-1])
        if law.shape == SHAPES[0] or law.response != INSTANT:
            continue
        alike = [
            (line.response, like.terms[-1].as_dict())
            for line, like in zip(lines, best, strict=True)
            if replace(line, power=law.power, response=INSTANT) == replace(law, shape=SHAPES[0])
        ]
        # a lag in any case; with the numbers of the best line that has it, where one is there
        known: dict[str, dict[str, float]] = {LAGGED: {}} | dict(reversed(alike))
        for response, values in known.items():
            both = replace(law, response=response)
            if response != INSTANT and both in refined(law):
                start = in_form(fit.terms[-1], both)
                of_line = {n: x for n, x in values.items() if n not in ("gain", *OF_A_SHAPE)}
                each = tuple(of_line.get(n, x) for n, x in start.as_dict().items())
                found.append(replace(fit, terms=(replace(start, values=each),)))
    return found[:most]


def in_place_of(term: ActiveEffect, law: Law) -> list[ActiveEffect]:
    """A law of the same form at another place or of another motion, as strong, either way."""
    own, known, effect = law_in(term), term.as_dict(), effect_of(law)
    values = {p.name: known.get(p.name, p.starts[0]) for p in effect.parameters}
    wider = MOTIONS[law.motion].usual / MOTIONS[own.motion].usual
    if "bend" in values:
        values["bend"] *= wider
    values["gain"] *= effect.parameters[0].starts[0] / term.effect.parameters[0].starts[0]
    found = []
    for sign in (1.0, -1.0):
        ways = values | {"gain": sign * values["gain"]}
        inside = (min(max(ways[p.name], p.low), p.high) for p in effect.parameters)
        found.append(ActiveEffect(effect, tuple(inside)))
    return found


def initial(law: Law) -> tuple[ActiveEffect, ...]:
    """A law with its initial values, with a positive and a negative gain."""
    effect = effect_of(law)
    gain, *rest = (p.starts[0] for p in effect.parameters)
    if effect.parameters[0].high == 0.0:  # only one sign is possible
        return (ActiveEffect(effect, (gain, *rest)),)
    return ActiveEffect(effect, (gain, *rest)), ActiveEffect(effect, (-gain, *rest))


def _band(effect: Effect) -> int:
    """Band of the initial frequency of an oscillating mass."""
    at = effect.extra["start_hz"]
    return next((i for i, row in enumerate(FREQUENCIES_HZ) if at in row), 0)
