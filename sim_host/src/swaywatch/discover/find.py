"""Selection of a law: laws against the library, in free simulation, by evidence and left-out runs.

A law is tried alone and together with the effects found in the library, from each baseline. All are
weighed alike (`diagnose/evidence/evidence.py`), with a penalty for the choice among all laws and
effects. A law is claimed only where its evidence exceeds that of the best explanation from the
library, where it reduces the misfit by more than the discrepancy of models of this depth, and where
it makes the left-out runs likelier, given what the other runs taught.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.baselines import LAWS, Path, noticeable
from swaywatch.diagnose.evidence.evidence import (
    APART,
    CLAIMED,
    DISCREPANCY,
    UNEXPLAINED_ABOVE,
    explained,
    inflation,
    residuals,
    worth,
)
from swaywatch.diagnose.evidence.search import (
    Candidate,
    Linear,
    Progress,
    Search,
    reduced_chi_square,
)
from swaywatch.diagnose.fit.fit import Fit
from swaywatch.diagnose.fit.holdout import left_out
from swaywatch.discover.grammar import (
    ANYWHERE,
    BODIES,
    FREQUENCIES_HZ,
    ID,
    INSTANT,
    MOTIONS,
    NONLINEAR_ONLY,
    OF_A_SHAPE,
    PERIODIC,
    PLACES,
    RESPONSES,
    ROLLS,
    SHAPES,
    SLIDING,
    Law,
    all_laws,
    curve,
    effect_of,
    grammar,
    of_two,
    plainer,
    refined,
)
from swaywatch.discover.way import (
    DISTANCE,
    GRIP_PLACES,
    ROAD_PLACES,
    grip_rates,
    repetitions,
    stretch,
)
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect
from swaywatch.plant.lanes import BODY

Array = NDArray[np.float64]

PAIRED = 8  # laws of two variables that are begun from each vehicle
PAIRED_ON = 4  # of them that are continued
NOISE_CLOSE = 1.15  # reduced chi-square under the observer up to which one variable is enough
SHORT_LIST = 12  # laws that are fitted under the observer
SCREENED = 72  # laws that are begun, of those that a vehicle promises most of to first order
FORMS = 8  # of one place and variable that come first
STRONGER, WEAKER = 4.0, 0.25  # times its initial size at which a law is looked at too
RESHAPED = 2  # times that the form of a law is looked for
BEGUN = 3  # iterations of their fits; the best of them are continued
MOST_OPEN = 40  # laws that are started in another search than the quickest one
POLISHED = 2  # of them in free simulation, beside each parent, ...
MOST_POLISHED = 4  # ... and of all
NEAR = 1.15  # misfit under the observer, over the smallest, up to which a law is kept
#: Logarithm of the odds from which a law is claimed: clean vehicles of another simulator, with
#: other suspension models, gave laws of up to 55. Every tyre has a pneumatic trail.
FORM = 75.0
SWING_HZ = (
    0.6,
    0.8,
    1.0,
    1.4,
)  # initial frequencies of an oscillating mass in the vehicle of the file
SWING_SHARE = 0.07  # of the body's mass or inertia, to begin with
#: How it moves: oscillates laterally, about the vertical axis, laterally with a gap or with a drag
#: that grows with its rate, or slides.
SWINGING = tuple(
    Law(body, *kind)
    for kind in (
        ("swing",),
        ("turn",),
        ("swing", "dead zone"),
        ("swing", "odd square"),
        ("swing", SLIDING),
    )
    for body in BODIES
)
#: Library effects from which on one law may replace them: one, with suspension two.
SEVERAL = {False: 1, True: 2}
#: Share by which a law has to reduce the misfit that the library effects leave.
BESIDE_KNOWN = 0.03
BESIDE = "laws beside effects of the library"  # in words, for what was left untried
#: Of what a law has to take away to be claimed, that it promises to first order beside library
#: effects that leave only noise; below it no law is begun. Laws that replaced such effects promised
#: 0.38 and 0.5 of what they took away then (docs/experiments.md).
PROMISED = 0.3


@dataclass(frozen=True)
class Discovery:
    """A law that is claimed.

    Attributes
    ----------
    search
        Where it was found; its noise is that of the best model.
    base, library, fit
        Calibrated vehicle, best explanation from the library of any baseline, and with the law.
    evidence
        Logarithm of the Bayes factor to the best explanation from the library.
    others
        Laws that fit equally well, within a Bayes factor of 20: names and its logarithm.
    kept_out
        Error (NRMSE) of each run predicted from the others: vehicle, library, law; empty with one
        run. `typical` combines several.
    likelier
        Logarithm of how many times likelier each run is, given the others, than with the best
        explanation from the library; empty with one run.
    """

    search: Search
    base: Fit
    library: Fit
    fit: Fit
    evidence: float
    others: list[tuple[Law, float]]
    kept_out: list[tuple[float, float, float]]
    likelier: list[float]

    @cached_property
    def index(self) -> int:
        """Index of the law among the terms."""
        return next(i for i, t in enumerate(self.fit.terms) if t.effect.id == ID)

    @property
    def term(self) -> ActiveEffect:
        """The term of the law, with its values."""
        return self.fit.terms[self.index]

    @property
    def law(self) -> Law:
        """The law itself."""
        return law_in(self.term)


def _law(effect: Effect) -> Law:
    """The law that an effect of one has."""
    law = effect.extra["law"]
    assert isinstance(law, Law)
    return law


def law_in(term: ActiveEffect) -> Law:
    """The law of a term of one."""
    return _law(term.effect)


def _promising(course: Linear) -> list[ActiveEffect]:
    """The linear laws and oscillating masses with the largest gain in the linearised fit."""
    best: dict[tuple[str, int], tuple[float, tuple[float, ...], Effect]] = {}
    # a frequency must not be extrapolated: each start keeps its own
    for row in course.best(grammar(), shaped=False):
        best.setdefault((row[2].component, _band(row[2])), row)
    ranked = sorted(best.values(), key=lambda row: -row[0])[:SHORT_LIST]
    return [ActiveEffect(effect, values) for _, values, effect in ranked]


def _best_of_each_law(fits: Sequence[Fit]) -> list[Fit]:
    """The best fit of each law, the best first."""
    kept: dict[Law, Fit] = {}
    for fit in sorted(fits, key=lambda f: f.chi2):
        kept.setdefault(law_in(fit.terms[-1]), fit)
    return list(kept.values())


def _pairs(course: Linear) -> list[ActiveEffect]:
    """The laws of two variables that promise most together, to first order."""
    singles = [e for e in grammar() if _law(e).place in PLACES]
    tried = [(e, (WEAKER * e.parameters[0].starts[0], *_rest(e))) for e in singles]
    columns = course.columns(tried)
    found = []
    for i, one in enumerate(singles):
        for j, other in enumerate(singles):
            law = replace(_law(one), second=_law(other).motion)
            if _law(one).power != _law(other).power or law not in of_two(_law(one)):
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


def _rest(effect: Effect) -> tuple[float, ...]:
    """Initial values of what is not the size of an effect."""
    return tuple(p.starts[0] for p in effect.parameters[1:])


def _ranked(course: Linear, terms: Sequence[ActiveEffect]) -> list[ActiveEffect]:
    """Of each law the values that promise the largest drop of the misfit, the best first.

    Each with the first of its initial values, with `STRONGER` ones the other way and with `WEAKER`
    ones: what a strong law that limits or cuts off changes is nothing like what a weak one does.
    """
    firsts: dict[Law, ActiveEffect] = {}
    for term in terms:
        firsts.setdefault(law_in(term), term)
    tried = [look for term in firsts.values() for look in _looks(term)]
    promised = sorted(zip(course.promises(tried), tried, strict=True), key=lambda pair: -pair[0])
    best: dict[Law, ActiveEffect] = {}
    for _, term in promised:
        best.setdefault(law_in(term), term)
    return _spread(list(best.values()))


def _spread(ranked: Sequence[ActiveEffect]) -> list[ActiveEffect]:
    """So ordered that no place with its variable takes up the list with its many forms.

    The form is looked for again once place and variable are known.
    """
    forms: dict[str, int] = {}
    first, later = [], []
    for term in ranked:
        name = term.effect.component
        forms[name] = forms.get(name, 0) + 1
        (first if forms[name] <= FORMS else later).append(term)
    return [*first, *later]


def _looks(term: ActiveEffect) -> list[ActiveEffect]:
    """A law as it is, several times as strong, the other way where it can act so, and weaker."""
    size, bounds = term.values[0], term.effect.parameters[0]
    other_way = bounds.low < 0.0 < bounds.high
    strong = min(max((-STRONGER if other_way else STRONGER) * size, bounds.low), bounds.high)
    looks = [replace(term, values=(x, *term.values[1:])) for x in (size, strong, WEAKER * size)]
    return [*looks, *(_behind(look) for look in looks if law_in(look).place in ANYWHERE)]


def _behind(term: ActiveEffect) -> ActiveEffect:
    """What acts ahead of the centre of gravity as far behind it."""
    values = term.as_dict() | {"ahead_m": -term.as_dict()["ahead_m"]}
    return replace(term, values=tuple(values[p.name] for p in term.effect.parameters))


def _nonlinear(straight: ActiveEffect) -> list[ActiveEffect]:
    """A linear law in other shapes, with initial values."""
    law = law_in(straight)
    if law.swings:  # with a gap or a drag: the values of the oscillation, and an initial one
        more = [effect_of(other, straight.as_dict()["frequency_hz"]) for other in refined(law)]
        return [ActiveEffect(e, (*straight.values, e.parameters[-1].starts[0])) for e in more]
    return [_like(straight, other) for other in refined(law)]


def _strength(shape: str, usual: float, bend: float) -> float:
    """A shape, of gain one, at an amplitude of its variable to the stronger side."""
    sides = (np.linspace(0.0, usual, 100), np.linspace(0.0, -usual, 100))
    return max(abs(float(curve(shape, side, bend)[-1])) for side in sides)


def _like(term: ActiveEffect, law: Law) -> ActiveEffect:
    """A law in another shape, with initial values that make it as strong as the one given.

    At the usual amplitude of the variable (beyond a dead zone) both are of one size: a law that is
    many times stronger than the usual initial values of its shape is not found from those.
    """
    own, known, effect = law_in(term), term.as_dict(), effect_of(law)
    values = {p.name: known.get(p.name, p.starts[0]) for p in effect.parameters}
    if law.shape != own.shape and "gain" in known:
        begun = {p.name: p.starts[0] for p in effect.parameters if p.name in OF_A_SHAPE}
        values |= begun
        bend = sum(known.get(name, 0.0) for name in OF_A_SHAPE)
        usual = max(MOTIONS[law.motion].usual, 2.0 * known.get("bend", 0.0))
        before = _strength(own.shape, usual, bend)
        values["gain"] *= before / _strength(law.shape, usual, sum(begun.values()))
    inside = (min(max(values[p.name], p.low), p.high) for p in effect.parameters)
    return ActiveEffect(effect, tuple(inside))


def _begun(law: Law) -> tuple[ActiveEffect, ...]:
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


@dataclass
class LawSearch:
    """Laws tried on one path of the diagnosis."""

    path: Path
    tried: list[Candidate] = field(default_factory=list)
    alone: bool = False  # laws were tried without other effects
    open: Callable[[], Sequence[Law]] = all_laws  # started from the vehicle of the file
    ranked: Sequence[Law] = ()  # of those, once they were started, the best first

    @property
    def search(self) -> Search:
        """Of the path."""
        return self.path.search

    @property
    def _plain(self) -> bool:
        """The library leaves only noise, without effects that one law may replace."""
        return _plain(self.path)

    def weighed(self, candidate: Candidate) -> Candidate:
        """With its evidence, including the choice among all laws and shapes."""
        found = self.search.weighed(candidate)
        laws = [law_in(t) for t in found.fit.terms if t.effect.id == ID]
        nonlinear = sum(law.shape != SHAPES[0] for law in laws)
        price = len(laws) * math.log(len(grammar())) + nonlinear * math.log(len(SHAPES))
        price += sum(bool(law.second) for law in laws) * math.log(len(MOTIONS))
        price += sum(law.response != INSTANT for law in laws) * math.log(len(RESPONSES))
        return replace(found, evidence=found.evidence - price)

    def _sprung(self, terms: Sequence[ActiveEffect]) -> list[ActiveEffect]:
        """Laws as a vehicle on springs has them, where this is one: it rolls by itself."""
        if not self.search.on_springs:
            return list(terms)
        found = []
        for term in terms:
            law = law_in(term)
            # values of a roll of its own are the last ones
            effect = effect_of(law, sprung=True) if law.motion in ROLLS else term.effect
            found.append(ActiveEffect(effect, term.values[: len(effect.parameters)]))
        return found

    def promising(self) -> bool:
        """A law may be claimed: the library leaves more than noise, or a law promises enough.

        Library effects that leave only noise and are not the cause leave what a law takes away
        beside them, too: it has to be far likelier than they are.
        """
        if not self.path.clean:
            return True
        close = self.search.close
        course = Linear(close, close.run(self.path.best.fit, 6))
        if any(
            self._enough_promised(row[2], row[0]) for row in course.best(grammar(), shaped=False)
        ):
            return True
        if self._plain:
            return False
        terms = self._sprung([look for law in all_laws() for look in _looks(_begun(law)[0])])
        gains = course.promises(terms)
        return any(self._enough_promised(t.effect, g) for t, g in zip(terms, gains, strict=True))

    def _enough_promised(self, effect: Effect, gain: float) -> bool:
        """Enough of the drop of chi2 from which a law is claimed."""
        least = _least_ahead(_law(effect)) + math.log(len(grammar()))
        return gain > PROMISED * 2.0 * least * self.search.noise

    def beside(self, parent: Fit) -> list[Candidate]:
        """The most promising laws together with the effects of a parent, under the observer."""
        close = self.search.close
        near = close.run(parent, 6)
        course = Linear(close, near)
        terms = self._sprung(_promising(course))
        starts = [replace(near, terms=(*near.terms, term)) for term in terms]
        fits = close.side_by_side(lambda f: close.run(f, 6, frozen=course.background), starts)
        if not self._plain:
            fits = [*fits, *self._in_other_shapes(course, fits)]
            fits = [*fits, *self._of_two(fits, parent)]
            fits = [*fits, *self._along_the_road(fits, parent)]
        least = (1.0 - BESIDE_KNOWN * bool(parent.terms)) * near.chi2
        least -= 2.0 * (CLAIMED + math.log(len(grammar()))) * self.search.noise
        found = [Candidate(f, parent) for f in fits if f.chi2 < least]
        return found if parent.terms else [*found, *self._swinging(parent, least)]

    def _in_other_shapes(self, course: Linear, straight: Sequence[Fit]) -> list[Fit]:
        """The linear laws in other shapes: a linear law hardly imitates a stop or a cubic law.

        Only where the library alone does not suffice. Without other effects all open laws are
        also started, with both signs, from the vehicle of the file: the values of the calibrated
        one are distorted to compensate for the law, and the response to a small law says little
        about one that limits the oscillation. A shape has to fit clearly better than the
        linear law.
        """
        close = self.search.close
        terms = [nonlinear for fit in straight for nonlinear in _nonlinear(fit.terms[-1])]
        terms += [term for law in NONLINEAR_ONLY for term in _begun(law)]
        begun = self._begun_best(course, self._sprung(terms))[0][:SHORT_LIST]
        if not course.fit.terms:
            of_file = Linear(close, close.start())
            terms = [term for law in self.open() for term in _begun(law)]
            far, self.ranked = self._begun_best(of_file, self._sprung(terms))
            # the vehicle of the file leaves a larger misfit: the best of each start are kept
            begun = _best_of_each_law([*begun, *far[:SHORT_LIST]])
        found = close.side_by_side(lambda f: close.run(f, 10), begun)
        if not course.fit.terms and min(f.chi2 / f.count for f in found) > NOISE_CLOSE:
            found = [*found, *self._bent(_best_of_each_law(found)[:PAIRED_ON])]
        return self._shaped_for_a_reason(found, straight)

    def _begun_best(
        self, course: Linear, terms: Sequence[ActiveEffect]
    ) -> tuple[list[Fit], list[Law]]:
        """Fits of the laws that promise most, begun, the best first; all laws, ranked.

        What a law promises is seen from two simulations of each run; a fit takes ten.
        """
        ranked = _ranked(course, terms)
        kept = {law_in(term): term for term in ranked[:SCREENED]}
        usual = [term for term in terms if law_in(term) in kept]
        seen = {(law_in(term), term.values) for term in usual}
        terms = usual + [term for law, term in kept.items() if (law, term.values) not in seen]
        starts = [replace(course.fit, terms=(*course.fit.terms, term)) for term in terms]
        close = self.search.close
        begun = _best_of_each_law(
            close.side_by_side(lambda f: close.run(f, BEGUN, frozen=course.background), starts)
        )
        first = [law_in(fit.terms[-1]) for fit in begun]
        return begun, [*first, *map(law_in, ranked[len(kept) :])]

    def _shaped_for_a_reason(self, fits: Sequence[Fit], straight: Sequence[Fit]) -> list[Fit]:
        """Fits whose law is linear, or whose shape fits clearly better than a line there."""
        lines: dict[str, float] = {}
        for fit in (*straight, *fits):
            term = fit.terms[-1]
            if law_in(term).shape == SHAPES[0]:
                name = term.effect.component
                lines[name] = min(lines.get(name, fit.chi2), fit.chi2)
        return [f for f in fits if self._fits_better(f, lines)]

    def _fits_better(self, fit: Fit, lines: Mapping[str, float]) -> bool:
        """A linear law, or clearly better than the same law in linear form."""
        term = fit.terms[-1]
        line = lines.get(term.effect.component, math.inf)
        if law_in(term).shape == SHAPES[0] or not math.isfinite(line):
            return True
        return fit.chi2 < line - max(2.0 * CLAIMED * self.search.noise, DISCREPANCY * line)

    def _of_two(self, fits: Sequence[Fit], parent: Fit) -> list[Fit]:
        """Laws of two variables, where one leaves more than noise.

        What a controller asks for is often the difference of two motions: the yaw rate less the one
        that the steering asks for. Neither alone need come near it.
        """
        best = min((fit.chi2 for fit in fits), default=math.inf)
        if parent.terms or best <= NOISE_CLOSE * parent.count:
            return []
        close = self.search.close
        starts = [
            replace(fit, terms=(term,))
            for fit in (close.run(parent, 6), close.start())
            for term in self._sprung(_pairs(Linear(close, fit)))
        ]
        straight = self._gone_on(starts)
        found = self._shaped_for_a_reason([*straight, *self._bent(straight)], ())
        return [fit for fit in found if fit.chi2 < (1.0 - BESIDE_KNOWN) * best]

    def _bent(self, fits: Sequence[Fit]) -> list[Fit]:
        """Laws in forms next to their own, each begun as it is."""
        return self._gone_on(
            [
                replace(fit, terms=tuple(self._sprung([_like(fit.terms[-1], law)])))
                for fit in fits
                for law in refined(law_in(fit.terms[-1]))
            ]
        )

    def _gone_on(self, starts: Sequence[Fit]) -> list[Fit]:
        """Begun under the observer, and of the best laws gone on with."""
        close = self.search.close
        begun = close.side_by_side(lambda f: close.run(f, BEGUN), starts)
        best = _best_of_each_law(begun)[:PAIRED_ON]
        return close.side_by_side(lambda f: close.run(f, 10), best)

    def _along_the_road(self, fits: Sequence[Fit], parent: Fit) -> list[Fit]:
        """What comes and goes along the road, where laws of the motion leave more than noise."""
        close = self.search.close
        best = min((fit.chi2 / max(fit.count, 1) for fit in fits), default=math.inf)
        if parent.terms or best <= NOISE_CLOSE:
            return []
        found = []
        for fit in (close.run(parent, 6), close.start()):
            near = Linear(close, fit)
            runs = close.problem.runs
            forces = [Law(place, DISTANCE, response=PERIODIC) for place in ROAD_PLACES]
            waves = [
                wave
                for rate in repetitions(runs, near.base)
                for wave in self._waves(near, rate, forces)
            ]
            grips = [Law(place, place, response=PERIODIC) for place in GRIP_PLACES]
            slabs = [wave for rate in grip_rates(runs) for wave in self._waves(near, rate, grips)]
            starts = [
                replace(fit, terms=(term,))
                for some in (waves, slabs)
                for _, term in sorted(some, key=lambda wave: -wave[0])[:PAIRED_ON]
            ]
            found += close.side_by_side(lambda f: close.run(f, 10), starts)
        return _best_of_each_law(found)

    def _waves(
        self, near: Linear, rate: float, laws: Sequence[Law]
    ) -> list[tuple[float, ActiveEffect]]:
        """What one number of repetitions promises at each place, and values to begin with."""
        runs = tuple(map(stretch, near.fitter.problem.runs))
        effects = [effect_of(law, runs=runs) for law in laws]
        tried = []
        for effect in effects:
            size, none = effect.parameters[0].starts[0], len(runs)
            tried += [(effect, (size, rate, *([turn] * none))) for turn in (0.0, 0.5 * math.pi)]
        columns = near.by_run(tried)
        found = []
        for i, effect in enumerate(effects):
            a = np.concatenate([columns[2 * i], columns[2 * i + 1]], axis=1)
            x = np.linalg.lstsq(a, -near.left, rcond=1e-9)[0]
            rest = near.left + a @ x
            gain = float(np.dot(near.left, near.left) - np.dot(rest, rest))
            sine, cosine = x[: len(runs)], x[len(runs) :]
            size = float(np.mean(np.hypot(sine, cosine))) * effect.parameters[0].starts[0]
            size = min(size, effect.parameters[0].high)
            phase = [float(np.arctan2(c, s)) for s, c in zip(sine, cosine, strict=True)]
            found.append((gain, ActiveEffect(effect, (size, rate, *phase))))
        return found

    def _swinging(self, parent: Fit, least: float) -> list[Candidate]:
        """Oscillating masses in the vehicle of the file, where the library alone does not suffice.

        Near the frequency of the sway such a mass changes the whole motion; a vehicle whose values
        compensate for it is too far from the true one for the mass to be found from there.
        """
        if self._plain:
            return []
        close = self.search.close
        start = close.start()
        starts = [
            replace(start, terms=(ActiveEffect(e, values),))
            for law in SWINGING
            for e, values in self._set_going(law)
        ]
        fits = close.side_by_side(lambda f: close.run(f, 10), starts)
        fits = self._shaped_for_a_reason(fits, ())
        return [Candidate(f, parent) for f in fits if f.chi2 < least]

    def _whole(self, law: Law) -> float:
        """Mass, or yaw inertia, of the body that contains the oscillating mass."""
        of = "yaw_inertia" if law.motion == "turn" else "mass"
        return float(self.search.close.problem.body[BODY.index(f"{law.place}.{of}")])

    def _set_going(self, law: Law) -> Iterator[tuple[Effect, tuple[float, ...]]]:
        """A mass that moves in its body, with initial values: frequencies, or frictions."""
        mass = SWING_SHARE * self._whole(law)
        if law.slides:
            effect = effect_of(law)
            place, friction = effect.parameters[1:]
            yield from ((effect, (mass, place.starts[0], f)) for f in friction.starts)
            return
        for hz in SWING_HZ:
            effect = effect_of(law, hz)
            yield effect, (mass, *(p.starts[0] for p in effect.parameters[1:]))

    def polish(self, candidates: Sequence[Candidate]) -> None:
        """Fits in free simulation, from the values of the parent or from the vehicle of the file.

        In a parent that lacks the law the values of the file are distorted to compensate for it.
        """
        search = self.search
        start = search.close.start()
        again = [replace(c.fit, shift=start.shift, nuisance=start.nuisance) for c in candidates]
        again = search.close.side_by_side(lambda f: search.close.run(f, 12), again)
        near = [c.fit if c.fit.chi2 < f.chi2 else f for c, f in zip(candidates, again, strict=True)]
        found = search.judge.side_by_side(search.released, near)
        kept = [
            Candidate(f, c.parent)
            for f, c in zip(found, candidates, strict=True)
            if np.isfinite(f.chi2)
        ]
        self.tried += kept
        self.quieten(kept)

    def quieten(self, candidates: Sequence[Candidate]) -> None:
        """The variance of an independent sample is that of the residuals of the best model."""
        if candidates:
            least = min(candidates, key=lambda c: c.fit.chi2)
            noise = inflation(residuals(self.search.judge, least.fit))
            self.search.noise = min(self.search.noise, noise)

    def shaped(self, candidate: Candidate) -> Candidate:
        """With its law in another form, where that fits clearly better; and once more."""
        judge = self.search.judge
        for _ in range(RESHAPED):
            fit = candidate.fit
            term = fit.terms[-1]
            others = self._sprung([_like(term, law) for law in refined(law_in(term))])
            starts = [replace(fit, terms=(*fit.terms[:-1], other)) for other in others]
            near = judge.side_by_side(lambda f: judge.run(f, 8), starts)
            best = min(near, key=lambda f: f.chi2, default=fit)
            if not best.chi2 < fit.chi2 - self._clearly(fit):
                break
            candidate = Candidate(best, candidate.parent)
            self.tried.append(candidate)
            self.quieten([candidate])
            if reduced_chi_square(best) <= NOISE_CLOSE:
                break
        return candidate

    def plain(self, candidate: Candidate) -> Candidate:
        """Without what its law has more than it needs: a second variable, a shape or a lag."""
        while True:
            fit = candidate.fit
            at = next(i for i, t in enumerate(fit.terms) if t.effect.id == ID)
            law = plainer(law_in(fit.terms[at]))
            if law is None:
                return candidate
            known = fit.terms[at].as_dict()
            effect = effect_of(law, known.get("frequency_hz"), sprung=self.search.on_springs)
            term = ActiveEffect(effect, tuple(known[p.name] for p in effect.parameters))
            terms = (*fit.terms[:at], term, *fit.terms[at + 1 :])
            found = self.search.judge.run(replace(fit, terms=terms), 20, tolerance=1e-6)
            if not found.chi2 < fit.chi2 + self._clearly(fit):
                return candidate
            self.tried.append(Candidate(found, candidate.parent))
            candidate = self.weighed(self.tried[-1])

    def _clearly(self, fit: Fit) -> float:
        """Drop of chi2 from which another shape fits clearly better."""
        return max(2.0 * CLAIMED * self.search.noise, DISCREPANCY * fit.chi2)


class Laws:
    """Laws of one diagnosis, tried while the library is searched and after it.

    The library is searched for further effects where one does not suffice; where a single law
    leaves only noise that is unnecessary. So laws alone are tried before.
    """

    def __init__(self, searches: Sequence[Search]) -> None:
        """Searches of baselines, the quickest first."""
        self.searches = searches
        self._alone: dict[int, LawSearch] = {}
        self._on_rigid: list[LawSearch] = []

    def alone(self, search: Search) -> float | None:
        """Evidence that the library has to reach against a law that leaves only noise, or None.

        Parameters
        ----------
        search
            Where the library is searched; laws are tried in the quickest one before. Results are
            kept for further calls.
        """
        for where in dict.fromkeys((self.searches[0], search)):
            law_search = self._begun(where)
            search.noise = where.noise = min(search.noise, where.noise)
            best = _best([law_search])
            if best is not None and _leaves_noise(*best):
                return best[1].evidence - _least_ahead(law_in(best[1].fit.terms[-1]))
        return None

    def tried_alone(self) -> tuple[Search, Fit] | None:
        """The single law with the smallest misfit, claimed or not, and its search."""
        found = [(h.search, c.fit) for h in self._alone.values() for c in h.tried]
        return min(found, key=lambda pair: pair[1].chi2, default=None)

    def _going_on(self, path: Path) -> LawSearch:
        """The laws of a path, with the single laws tried before."""
        begun = self._alone.get(id(path.search))
        if begun is None:
            return self._new(path)
        return LawSearch(path, [*begun.tried], alone=True)

    def _new(self, path: Path) -> LawSearch:
        found = LawSearch(path, open=partial(self._open, path.search))
        if not path.search.on_springs:
            self._on_rigid.append(found)
        return found

    def _open(self, search: Search) -> Sequence[Law]:
        """All laws on a rigid vehicle; with suspension, which is slow, the best of them there."""
        if not search.on_springs:
            return all_laws()
        ranked = [law_search.ranked for law_search in self._on_rigid if law_search.ranked]
        if not ranked:
            if self._ended():
                return []
            ranked = [self._begun(self.searches[0]).ranked]
        return ranked[-1][:MOST_OPEN]

    def _begun(self, search: Search) -> LawSearch:
        """Single laws, tried once."""
        if id(search) not in self._alone:
            base = search.baseline()
            law_search = self._new(Path(search, base, base))
            self._alone[id(search)] = law_search
            _polish_best([law_search])
        return self._alone[id(search)]

    def _ended(self) -> bool:
        """Tell whether the diagnosis has simulated enough."""
        return self.searches[0].problem.budget.refuses(LAWS)

    def discover(self, paths: Sequence[Path], progress: Progress) -> Discovery | None:
        """The law that explains the runs better than the library does, or None.

        Laws are always tried on a rigid vehicle, and on one with suspension where it explains the
        runs best or no path leaves only noise.

        Parameters
        ----------
        paths
            Models tried by the diagnosis, from each baseline.
        progress
            Called with a stage and the completed share.
        """
        progress("laws beyond the library", 0.93)
        if not self._alone and self._ended():
            return None
        clean = any(path.clean for path in paths)
        best_of_each = _one_of_each(paths)
        tried = {path.search.on_springs for path in best_of_each}
        if clean:
            best_of_each = [
                p for p in best_of_each if p is best_of_each[0] or not p.search.on_springs
            ]
        law_searches = [self._going_on(path) for path in best_of_each]
        for search in self.searches:
            wanted = id(search) in self._alone or not (search.on_springs and clean)
            if wanted and search.on_springs not in tried:
                base = search.baseline()
                law_searches.append(self._going_on(Path(search, base, base)))
        # which laws are worth trying with suspension is seen without it
        law_searches.sort(key=lambda law_search: law_search.search.on_springs)
        _share_noise(law_searches)
        best = _best(law_searches)
        if best is None or not _leaves_noise(*best) or not _ahead(law_searches, best[1]):
            if not self._ended() and any(h.promising() for h in law_searches):
                _polish_best(law_searches)
            _share_noise(law_searches)
            best = _best(law_searches)
        if best is None or not _ahead(law_searches, best[1]):
            return None
        law_search, candidate = best
        progress("shape of the law", 0.95)
        candidate = law_search.shaped(candidate)
        _share_noise(law_searches)
        candidate = law_search.plain(_completed(law_search, candidate))
        return _claimed(law_searches, law_search, candidate)


def _polish_best(law_searches: Sequence[LawSearch]) -> None:
    """The best laws of all parents and baselines in free simulation."""
    near: list[tuple[LawSearch, Candidate]] = []
    for law_search in law_searches:
        for parent in _parents(law_search):
            if near and law_search.search.problem.budget.refuses(BESIDE):
                break
            near += [(law_search, candidate) for candidate in law_search.beside(parent)]
    if not near:
        return
    near.sort(key=lambda pair: pair[1].fit.chi2)
    near = [pair for pair in near if pair[1].fit.chi2 < NEAR * near[0][1].fit.chi2]
    fewest: list[tuple[LawSearch, Candidate]] = []
    for law_search, candidate in near:
        alone = sum(
            h is law_search and len(c.fit.terms) == len(candidate.fit.terms) for h, c in fewest
        )
        if alone < POLISHED and len(fewest) < MOST_POLISHED:
            fewest.append((law_search, candidate))
    for law_search in law_searches:
        own = [c for h, c in fewest if h is law_search]
        if own:
            law_search.polish(own)


def _ahead(law_searches: Sequence[LawSearch], candidate: Candidate) -> bool:
    """The law is likelier than the best of the library by more than the model error allows."""
    least = _least_ahead(law_in(candidate.fit.terms[-1]))
    return candidate.evidence > _library(law_searches)[1].evidence + least


def _least_ahead(law: Law) -> float:
    """Logarithm of the odds from which a law is claimed."""
    every_tyre = law.motion == "side_force"
    return CLAIMED if every_tyre else FORM


def _library(law_searches: Sequence[LawSearch]) -> tuple[LawSearch, Candidate]:
    """The best without a law."""
    found = [(h, h.weighed(c)) for h in law_searches for c in (h.path.base, h.path.best)]
    return max(found, key=lambda pair: pair[1].evidence)


def _one_of_each(paths: Sequence[Path]) -> list[Path]:
    """The likeliest path of those with a rigid vehicle, and of those with suspension."""
    found: dict[bool, Path] = {}
    for path in sorted(paths, key=lambda p: -p.search.weighed(p.best).evidence):
        found.setdefault(path.search.on_springs, path)
    return list(found.values())


def _plain(path: Path) -> bool:
    return path.clean and len(path.best.fit.terms) < SEVERAL[path.search.on_springs]


def _parents(law_search: LawSearch) -> list[Fit]:
    """Models that laws are added to: the vehicle alone, and with the effects from the library.

    With suspension a single effect that leaves only noise is not removed first: a law that makes it
    unnecessary is found together with it, and the effect is removed later (`_completed`).
    """
    path, known = law_search.path, law_search.path.best.fit
    alone = [] if law_search.alone or (_plain(path) and known.terms) else [path.base.fit]
    return [*alone, known] if known.terms else alone


def _share_noise(law_searches: Sequence[LawSearch]) -> None:
    noise = min(h.search.noise for h in law_searches)
    for law_search in law_searches:
        law_search.search.noise = noise


def _best(law_searches: Sequence[LawSearch]) -> tuple[LawSearch, Candidate] | None:
    """The likeliest law that reduces the misfit enough."""
    found = [(h, h.weighed(c)) for h in law_searches for c in h.tried if _enough(h, c)]
    return max(found, key=lambda pair: pair[1].evidence, default=None)


def _leaves_noise(law_search: LawSearch, candidate: Candidate) -> bool:
    """The law explains the residuals of the calibrated vehicle down to noise."""
    return explained(law_search.path.base.fit, candidate.fit)


def _enough(law_search: LawSearch, candidate: Candidate) -> bool:
    fit, parent = candidate.fit, candidate.parent
    springs = law_search.search.on_springs
    enough = worth(law_search.path.base.fit, parent, fit, on_springs=springs)
    if not noticeable(fit.terms[-1]) or not enough:
        return False
    return not parent.terms or fit.chi2 < (1.0 - BESIDE_KNOWN) * parent.chi2


def _completed(law_search: LawSearch, candidate: Candidate) -> Candidate:
    """Without library effects that the law makes unnecessary, and fitted to convergence.

    An effect beside the law has to contribute as much as beside another effect.
    """
    search, base = law_search.search, law_search.path.base.fit
    while len(candidate.fit.terms) > 1:
        candidate = law_search.weighed(candidate)
        terms = candidate.fit.terms
        fewer = [
            law_search.weighed(Candidate(search.without(candidate.fit, i), candidate.parent))
            for i in range(len(terms) - 1)
        ]
        first = max(range(len(fewer)), key=lambda i: fewer[i].evidence)
        last = (*terms[:first], *terms[first + 1 :], terms[first])
        whole = replace(candidate.fit, terms=last)
        needed = worth(base, fewer[first].fit, whole, on_springs=search.on_springs)
        if needed and fewer[first].evidence < candidate.evidence - CLAIMED:
            break
        candidate = fewer[first]
    fit = search.judge.run(candidate.fit, 20, tolerance=1e-6)
    return law_search.weighed(replace(candidate, fit=fit))


def _claimed(
    law_searches: Sequence[LawSearch], law_search: LawSearch, candidate: Candidate
) -> Discovery | None:
    """The law as a claim, if the library does not explain the runs equally well."""
    from_, library = _library(law_searches)
    if not _ahead(law_searches, candidate) or not noticeable(candidate.fit.terms[-1]):
        return None
    if _beside_what_suffices(library.fit, candidate.fit):
        return None
    if (
        reduced_chi_square(candidate.fit) > UNEXPLAINED_ABOVE
    ):  # distorted vehicle values that fit a wrong law: a share of the misfit does not count
        return None
    likelier = _likelier(
        _left_out_evidence(law_search, candidate.fit), _left_out_evidence(from_, library.fit)
    )
    if likelier and sum(likelier) < CLAIMED:
        return None
    base = law_search.path.base.fit
    rows = list(
        zip(
            left_out(law_search.search.problem, base),
            left_out(from_.search.problem, library.fit),
            left_out(law_search.search.problem, candidate.fit),
            strict=True,
        )
    )
    return Discovery(
        law_search.search, base, library.fit, candidate.fit, candidate.evidence - library.evidence,
        _others(law_searches, candidate), rows, likelier,
    )  # fmt: skip


def _likelier(one: Sequence[float], other: Sequence[float]) -> list[float]:
    return [float(a - b) for a, b in zip(one, other, strict=True)]


def _left_out_evidence(law_search: LawSearch, fit: Fit) -> list[float]:
    """Logarithm of each run's likelihood, given the others; empty with one run.

    The evidence of all runs less that of the others. So what the others leave open counts as open:
    near the critical speed a run that is simulated with the values of another one drifts away, with
    the right law as well as with a wrong one, and the error says which values happened to be lucky.
    """
    judge = law_search.search.judge
    runs = range(len(judge.problem.runs))
    if len(runs) < 2:
        return []

    def evidence(taught: Fit) -> float:
        return law_search.weighed(Candidate(taught, taught)).evidence

    fit = judge.run(fit, 20, tolerance=1e-5)
    found = []
    for run in runs:
        terms = [t.outside(run) for t in fit.terms]
        kept = tuple(t for t in terms if t.values)
        others = [r for r in runs if r != run]
        taught = judge.run(replace(fit, terms=kept), 20, runs=others, tolerance=1e-5)
        found.append(evidence(fit) - evidence(taught))
    return found


def _beside_what_suffices(library: Fit, fit: Fit) -> bool:
    """Library effects that leave only noise, and a law that replaces none of them.

    Such a law absorbs what the form of the effects leaves: the stronger they act, the more.
    """
    names = {t.effect.name for t in fit.terms}
    return (
        bool(library.terms)
        and reduced_chi_square(library) <= UNEXPLAINED_ABOVE
        and all(t.effect.name in names for t in library.terms)
    )


def _others(law_searches: Sequence[LawSearch], best: Candidate) -> list[tuple[Law, float]]:
    """Other laws that cannot be distinguished from the best."""
    law = law_in(best.fit.terms[-1])
    found: dict[str, tuple[Law, float]] = {}
    for law_search in law_searches:
        for candidate in map(law_search.weighed, law_search.tried):
            other = law_in(candidate.fit.terms[-1])
            behind = candidate.evidence - best.evidence
            same = (other.place, other.motion) == (law.place, law.motion)
            if same or behind < -APART or not _enough(law_search, candidate):
                continue
            name = candidate.fit.terms[-1].effect.component
            if name not in found or found[name][1] < behind:
                found[name] = other, behind
    return sorted(found.values(), key=lambda pair: -pair[1])
