"""Laws tried on one path of the diagnosis, under the observer, then the best in free simulation."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from swaywatch.diagnose.evidence.baselines import Path
from swaywatch.diagnose.evidence.evidence import (
    CLAIMED,
    DISCREPANCY,
    colour,
    inflation,
    residuals,
)
from swaywatch.diagnose.evidence.search import Candidate, Linear, Search, reduced_chi_square
from swaywatch.diagnose.fit.budget import Budget
from swaywatch.diagnose.fit.fit import Fit, Fitter
from swaywatch.discover import road, sudden
from swaywatch.discover.begin import (
    SHORT_LIST,
    best_of_each_law,
    by_promise,
    crossed,
    in_form,
    in_other_forms,
    in_place_of,
    initial,
    law_in,
    law_in_effect,
    linear_laws,
    looks,
    of_a_product,
    of_two_variables,
    per_size,
    runs_of,
)
from swaywatch.discover.effect import ID, effect_of
from swaywatch.discover.excerpt import Excerpt, everything, excerpt_of
from swaywatch.discover.free import free_curves
from swaywatch.discover.grammar import (
    IN_COUPLING,
    all_laws,
    elsewhere,
    grammar,
    plainer,
    refined,
    repeating,
    without_a_line,
)
from swaywatch.discover.law import (
    ALONE,
    BALL,
    BODIES,
    CURVE,
    FADING,
    INSTANT,
    LAGGED,
    LOST_MOTION,
    MOMENT,
    MOTIONS,
    PERIODIC,
    RESPONSES,
    ROLLS,
    SHAPES,
    SIDES,
    SLIDING,
    UNEVEN,
    Law,
)
from swaywatch.discover.way import (
    DISTANCE,
    DRAG,
    ROAD_PLACES,
    repetitions,
    stretch,
)
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect
from swaywatch.plant.lanes import BODY

PAIRED_ON = 4  # of them that are continued
CROSSED = 12  # shapes that are begun behind a lag
LATE_CURVES = 2  # free curves, of those that fit best, that are tried with a lag too
MOVED = 2  # of them that are looked for at other places and with other motions
GONE_OVER = 2  # times that this is done
#: Reduced chi-square under the observer, and samples for an independent one, up to which one
#: variable is enough: a law that is not quite the right one leaves what is no noise, however
#: little. Right ones leave 0.95 to 1.16, as well as noise is estimated, and 1.03 to 1.1.
NOISE_CLOSE, WHITE = 1.2, 1.12
#: Reduced chi-square of the vehicle alone from which on one law that leaves only noise is enough:
#: many do where it is little above it.
FAR_ABOVE = 5.0
SCREENED = 48  # laws that are begun, of those that a vehicle promises most of to first order
SCREENED_WEAK = 24  # the same where the library leaves only noise
RESHAPED = 2  # times that the form of a law is looked for
BEGUN = 3  # iterations of their fits; the best of them are continued
HELD = 8  # iterations of these under a strict observer
SHARES = (1.0, 0.3, 0.1)  # of the size that a law promises, with which it is begun
#: Of the budget of a diagnosis, what laws may spend beside the library, and what both: until then
#: laws are begun.
OF_LAWS, OF_BOTH = 1.0, 2.0
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
SET_GOING, GOING_ON = 6, 8  # iterations of each of them, and how many are gone on with
#: How it moves: oscillates laterally, about the vertical axis, laterally with a gap, in which it
#: may slide, with a drag that grows with its rate, with friction within or lashed to one side,
#: slides, or comes loose on the way.
SWINGING = tuple(
    Law(body, *kind)
    for kind in (
        ("swing",),
        ("turn",),
        ("swing", "dead zone"),
        ("swing", LOST_MOTION),
        ("swing", "odd square"),
        ("swing", "rubbing"),
        ("swing", UNEVEN),
        ("swing", SLIDING),
        ("swing", SHAPES[0], 0, FADING),
    )
    for body in BODIES
)
#: Library effects from which on one law may replace them: one, with suspension two.
SEVERAL = {False: 1, True: 2}
#: Share by which a law has to reduce the misfit that the library effects leave.
BESIDE_KNOWN = 0.03
#: Of what a law has to take away to be claimed, that it promises to first order beside library
#: effects that leave only noise; below it no law is begun. Laws that replaced such effects promised
#: 0.38 and 0.5 of what they took away then (docs/experiments.md).
PROMISED = 0.3
#: The same at a first look, at each law once: where the library names what acts, 4,353 looks showed
#: up to 1.6 times what the best of the first ones did.
AT_FIRST = 0.15


@dataclass
class LawSearch:
    """Laws tried on one path of the diagnosis."""

    path: Path
    tried: list[Candidate] = field(default_factory=list)
    alone: bool = False  # laws were tried without other effects
    open: Callable[[], Sequence[Law]] = all_laws  # started from the vehicle of the file
    ranked: Sequence[Law] = ()  # all laws, once they were looked at, the best first
    suffices: bool = False  # the library leaves only noise, on this path or another
    excerpt: Excerpt | None = None  # where laws are begun, once it was looked for

    @property
    def search(self) -> Search:
        """Of the path."""
        return self.path.search

    @property
    def _plain(self) -> bool:
        """The library leaves only noise, without effects that one law may replace."""
        return library_suffices(self.path)

    def weighed(self, candidate: Candidate) -> Candidate:
        """With its evidence, including the choice among all laws and shapes."""
        found = self.search.weighed(candidate)
        laws = [law_in(t) for t in found.fit.terms if t.effect.id == ID]
        nonlinear = sum(law.shape != SHAPES[0] for law in laws)
        price = len(laws) * math.log(len(grammar())) + nonlinear * math.log(len(SHAPES))
        price += sum(bool(law.second or law.by) for law in laws) * math.log(len(MOTIONS))
        price += sum(bool(law.side) for law in laws) * math.log(len(SIDES))
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
            runs = runs_of(term, law)
            effect = effect_of(law, sprung=True, runs=runs) if law.motion in ROLLS else term.effect
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
        lines = course.best(grammar(), shaped=False)
        lines_promise = any(self._enough_promised(row[2], row[0]) for row in lines)
        # on springs all laws are looked at, as only the best of them are begun
        if self._plain or (lines_promise and not self.search.on_springs):
            return lines_promise
        if not lines_promise and not self._at_first(course):
            return False
        terms = [look for law in all_laws() for look in looks(initial(law)[0])]
        best = sorted(course.sized(self._sprung(terms)), key=lambda pair: -pair[0])
        self.ranked = tuple(dict.fromkeys(law_in(term) for _, term in best))
        return lines_promise or any(self._enough_promised(t.effect, g) for g, t in best)

    def _at_first(self, course: Linear) -> bool:
        """A first look at every law that does not depend on the speed shows any of use."""
        terms = self._sprung([initial(law)[0] for law in all_laws() if law.power == 0])
        return any(self._enough_promised(t.effect, g, AT_FIRST) for g, t in course.sized(terms))

    def _enough_promised(self, effect: Effect, gain: float, share: float = PROMISED) -> bool:
        """Enough of the drop of chi2 from which a law is claimed."""
        least = least_ahead(law_in_effect(effect)) + math.log(len(grammar()))
        return gain > share * 2.0 * least * self.search.noise

    def beside(self, parent: Fit) -> list[Candidate]:
        """The most promising laws together with the effects of a parent, under the observer."""
        close = self.search.close
        near = close.run(parent, 6)
        course = Linear(close, near)
        terms = self._sprung(linear_laws(course))
        starts = [replace(near, terms=(*near.terms, term)) for term in terms]
        fits = close.side_by_side(lambda f: close.run(f, 6, frozen=course.background), starts)
        if not self._plain:
            straight = fits
            # cheap ones first, so that they are tried before the budget is spent
            fits = [*fits, *self._swinging(parent)]
            fits = [*fits, *self._along_the_road(fits, parent)]
            fits = [*fits, *self._on_the_way(fits, parent)]
            if not self._settled(near, fits):
                fits = [*fits, *self._in_other_shapes(course, straight)]
            fits = [*fits, *self._in_curves(fits, parent)]
            fits = [*fits, *self._of_two(fits, parent)]
        least = (1.0 - BESIDE_KNOWN * bool(parent.terms)) * near.chi2
        least -= 2.0 * (CLAIMED + math.log(len(grammar()))) * self.search.noise
        return [Candidate(f, parent) for f in fits if f.chi2 < least]

    def _in_other_shapes(self, course: Linear, straight: Sequence[Fit]) -> list[Fit]:
        """The linear laws in other shapes: a linear law hardly imitates a stop or a cubic law.

        Only where the library alone does not suffice. Without other effects all open laws are
        also started, with both signs, from the vehicle of the file: the values of the calibrated
        one are distorted to compensate for the law, and the response to a small law says little
        about one that limits the oscillation. A shape has to fit clearly better than the
        linear law.
        """
        close = self.search.close
        terms = [nonlinear for fit in straight for nonlinear in in_other_forms(fit.terms[-1])]
        terms += [term for law in without_a_line() for term in initial(law)]
        begun = self._begun_best(course.fit, self._sprung(terms), self._excerpt(course.fit))[0]
        if not course.fit.terms:
            terms = [term for law in self.open() for term in initial(law)]
            start = close.start()
            stricter = self._excerpt(start).stricter()
            far, self.ranked = self._begun_best(start, self._sprung(terms), stricter)
            # the vehicle of the file leaves a larger misfit: the best of each start are kept
            begun = best_of_each_law(close.side_by_side(lambda f: close.run(f, 0), [*begun, *far]))
        found = close.side_by_side(lambda f: close.run(f, 10), begun)
        if not course.fit.terms and not self._only_noise(found):
            found = self._gone_over(found)
        return self._shaped_for_a_reason(found, straight)

    def _begun_best(
        self, near: Fit, terms: Sequence[ActiveEffect], excerpt: Excerpt
    ) -> tuple[list[Fit], list[Law]]:
        """A short list of fits of the laws that promise most, begun; all laws, ranked.

        What a law promises is seen from one to twelve simulations of each run; a fit takes ten.
        """
        course = excerpt.course(near, calibrated=near.count > 0)
        ranked = by_promise(course, terms)
        kept = ranked[: SCREENED_WEAK if self.suffices else SCREENED]
        parts, known = excerpt.fitter, course.background
        starts = self._not_too_strong(parts, course.fit, kept)
        begun = parts.side_by_side(lambda f: parts.run(f, 1, frozen=known), starts)
        begun.sort(key=lambda f: f.chi2)
        better = begun[: -(-len(begun) // 2)]  # which half is better is seen after one iteration
        better = parts.side_by_side(lambda f: parts.run(f, BEGUN - 1, frozen=known), better)
        first = [law_in(fit.terms[-1]) for fit in best_of_each_law([*better, *begun])]
        found = self._let_go(excerpt, best_of_each_law(better)[:SHORT_LIST], near)
        return found, [*first, *map(law_in, ranked[len(kept) :])]

    def _not_too_strong(self, parts: Fitter, near: Fit, terms: Sequence[ActiveEffect]) -> list[Fit]:
        """Starts of the size that each law promises or, where these run away, of a part of it."""
        starts = [
            replace(near, terms=(*near.terms, replace(t, values=(x * t.values[0], *t.values[1:]))))
            for t in terms
            for x in SHARES
        ]
        seen = parts.side_by_side(lambda f: parts.run(f, 0), starts)
        each = [seen[i : i + len(SHARES)] for i in range(0, len(seen), len(SHARES))]
        return [min(some, key=lambda f: f.chi2) for some in each]

    def _let_go(self, excerpt: Excerpt, fits: Sequence[Fit], near: Fit) -> list[Fit]:
        """Fits under a strict observer to the end, then under a less strict one, where they agree.

        What has only been begun there runs away under the observer of the search.
        """
        for parts in excerpt.fitters:
            fits = _held(parts, fits)
        fits = excerpt.back(fits, near)
        return _held(everything(self.search.close).fitter, fits) if excerpt.offsets else fits

    def _excerpt(self, near: Fit) -> Excerpt:
        """Where laws are begun: with effects beside them, that may act in windows, everywhere."""
        close = self.search.close
        if near.terms:
            return everything(close)
        if self.excerpt is None:
            self.excerpt = excerpt_of(close, near)
        return self.excerpt

    def _shaped_for_a_reason(self, fits: Sequence[Fit], straight: Sequence[Fit]) -> list[Fit]:
        """Fits whose law is linear, or whose shape fits clearly better than a line there."""
        lines: dict[str, float] = {}
        for fit in (*straight, *fits):
            term = fit.terms[-1]
            if law_in(term).shape == SHAPES[0]:
                name = term.effect.component
                lines[name] = min(lines.get(name, fit.chi2), fit.chi2)
        best = min(fits, key=lambda f: f.chi2, default=None)
        if best is None:
            return []
        noise = self._least_noise(best)
        dragging = self._with_drag_for_a_reason(fits)
        return [f for f in dragging if self._fits_better(f, lines, noise)]

    def _least_noise(self, best: Fit) -> float:
        """Of the best fit: what the vehicle alone leaves is far from white without a strong law."""
        return min(self.search.noise, inflation(residuals(self.search.close, best)))

    def _with_drag_for_a_reason(self, fits: Sequence[Fit]) -> list[Fit]:
        """Without drags of wheels that fit no better than the moments that they make."""
        if not any(law_in(fit.terms[-1]).place == DRAG for fit in fits):
            return list(fits)
        noise = self._least_noise(min(fits, key=lambda f: f.chi2))
        plain = {law_in(f.terms[-1]): f.chi2 for f in fits}
        return [f for f in fits if _drags_for_a_reason(f, plain, noise)]

    def _fits_better(self, fit: Fit, lines: Mapping[str, float], noise: float) -> bool:
        """A linear law, or clearly better than the same law in linear form."""
        term = fit.terms[-1]
        line = lines.get(term.effect.component, math.inf)
        if law_in(term).shape == SHAPES[0] or not math.isfinite(line):
            return True
        return fit.chi2 < line - max(2.0 * CLAIMED * noise, DISCREPANCY * line)

    def _of_two(self, fits: Sequence[Fit], parent: Fit) -> list[Fit]:
        """Laws of two variables, where one leaves more than noise.

        What a controller asks for is often the difference of two motions: the yaw rate less the one
        that the steering asks for. Neither alone need come near it.
        """
        best = min((fit.chi2 for fit in fits), default=math.inf)
        if parent.terms or self._only_noise(fits) or self._spent("laws of two variables"):
            return []
        close = self.search.close
        calibrated, of_file = close.run(parent, 6), close.start()
        course = self._excerpt(calibrated).course(calibrated)
        # far from the recording a product says little: its factor is not what it was
        far = self._excerpt(of_file).stricter().course(of_file)
        begun = [(calibrated, term) for term in of_two_variables(course)]
        # products take many simulations, so in the vehicle of the file alone
        begun += [(of_file, term) for term in (*of_two_variables(far), *of_a_product(far))]
        starts = [replace(near, terms=tuple(self._sprung([term]))) for near, term in begun]
        straight = self._gone_on(starts)
        found = self._shaped_for_a_reason([*straight, *self._bent(straight)], ())
        return [fit for fit in found if fit.chi2 < (1.0 - BESIDE_KNOWN) * best]

    def _in_curves(self, fits: Sequence[Fit], parent: Fit) -> list[Fit]:
        """Free curves, where no form leaves only noise."""
        if parent.terms or self._only_noise(fits) or self._spent("free curves"):
            return []
        close = self.search.close
        starts = [
            replace(near, terms=tuple(self._sprung([term])))
            for near in (close.run(parent, 6), close.start())
            for term in free_curves(self._excerpt(near).course(near))
        ]
        best = min((fit.chi2 for fit in fits), default=math.inf)
        found = sorted(self._gone_on(starts), key=lambda f: f.chi2)
        late = [
            replace(fit, terms=tuple(self._sprung([in_form(fit.terms[-1], law)])))
            for fit in found[:LATE_CURVES]
            if (law := replace(law_in(fit.terms[-1]), response=LAGGED)).motion not in ALONE
        ]
        found += close.side_by_side(lambda f: close.run(f, 10), late)
        found += self._repeating(found)
        return [fit for fit in found if fit.chi2 < (1.0 - BESIDE_KNOWN) * best]

    def _repeating(self, curves: Sequence[Fit]) -> list[Fit]:
        """Steps or notches in the place of the best curves, from the vehicle of the file too."""
        best = sorted(curves, key=lambda f: f.chi2)[:LATE_CURVES]
        return self._gone_on(
            [
                replace(fit, terms=tuple(self._sprung([in_form(fit.terms[-1], law)])))
                for fit in best
                for law in repeating(law_in(fit.terms[-1]))
            ]
        )

    def _spent(self, what: str) -> bool:
        """What the diagnosis may simulate is spent; it names then what was not tried."""
        return laws_refuse(self.search.problem.budget, what)

    def _only_noise(self, fits: Sequence[Fit]) -> bool:
        """Whether the best of some fits leaves nothing under the observer but white noise.

        Not asked where the library leaves no more: then no other law is looked for.
        """
        if self.suffices:
            return True
        best = min(fits, key=lambda fit: fit.chi2, default=None)
        if best is None or reduced_chi_square(best) > NOISE_CLOSE:
            return False
        return colour(residuals(self.search.close, best)) <= WHITE

    def _settled(self, without: Fit, fits: Sequence[Fit]) -> bool:
        """Whether a law leaves only noise of what is far above it, which no wrong one does."""
        far = reduced_chi_square(without) > FAR_ABOVE and not self.suffices
        return far and self._only_noise(fits)

    def _bent(self, fits: Sequence[Fit]) -> list[Fit]:
        """Laws in forms next to their own, each begun as it is."""
        return self._gone_on(
            [
                replace(fit, terms=tuple(self._sprung([in_form(fit.terms[-1], law)])))
                for fit in fits
                for law in refined(law_in(fit.terms[-1]))
            ]
        )

    def _gone_over(self, fits: Sequence[Fit]) -> list[Fit]:
        """With laws near the best: their forms, then these elsewhere; and once more."""
        found = list(fits)
        found += self._gone_on(
            [replace(f, terms=tuple(self._sprung(f.terms))) for f in crossed(found, CROSSED)]
        )
        formed: set[Law] = set()
        moved: set[Law] = set()
        for _ in range(GONE_OVER):
            best = best_of_each_law(found)[:PAIRED_ON]
            if self._only_noise(best):
                break
            found += self._bent([fit for fit in best if law_in(fit.terms[-1]) not in formed])
            formed |= {law_in(fit.terms[-1]) for fit in best}
            best = best_of_each_law(found)[:MOVED]
            found += self._elsewhere([fit for fit in best if law_in(fit.terms[-1]) not in moved])
            moved |= {law_in(fit.terms[-1]) for fit in best}
        return found

    def _elsewhere(self, fits: Sequence[Fit]) -> list[Fit]:
        """Laws in their form at other places and of other motions."""
        return self._gone_on(
            [
                replace(fit, terms=tuple(self._sprung([term])))
                for fit in fits
                for law in elsewhere(law_in(fit.terms[-1]))
                for term in in_place_of(fit.terms[-1], law)
            ]
        )

    def _gone_on(self, starts: Sequence[Fit]) -> list[Fit]:
        """Begun under the observer, and of the best laws gone on with.

        Each also in the vehicle of the file, its own values alone to begin with: the values of a
        vehicle that has another law are distorted to compensate for what that one lacks.
        """
        close = self.search.close
        of_file = close.start()
        excerpt = self._excerpt(of_file)
        parts, near = excerpt.fitter, [excerpt.of(f) for f in starts]
        own = excerpt.of(of_file)
        alone = [replace(f, shift=own.shift, nuisance=own.nuisance) for f in near]
        strict = excerpt.stricter().fitter
        alone = strict.side_by_side(lambda f: strict.run(f, BEGUN, calibrate=False), alone)
        begun = parts.side_by_side(lambda f: parts.run(f, BEGUN), [*near, *alone])
        best = self._let_go(excerpt, best_of_each_law(begun)[:PAIRED_ON], of_file)
        return close.side_by_side(lambda f: close.run(f, 10), best)

    def _along_the_road(self, fits: Sequence[Fit], parent: Fit) -> list[Fit]:
        """What comes and goes along the road, where laws of the motion leave more than noise."""
        close = self.search.close
        if parent.terms or self._only_noise(fits) or self._spent("laws along the road"):
            return []
        found: list[Fit] = []
        for fit in (close.run(parent, 6), close.start()):
            near = Linear(close, fit)
            runs = close.problem.runs
            forces = [Law(place, DISTANCE, response=PERIODIC) for place in ROAD_PLACES]
            waves = [
                wave
                for rate in repetitions(runs, near.base)
                for wave in self._waves(near, rate, forces)
            ]
            first = sorted(waves, key=lambda wave: -wave[0])[:PAIRED_ON]
            starts = [replace(fit, terms=(term,)) for _, term in first]
            found += close.side_by_side(lambda f: close.run(f, 10), starts)
        found = self._in_other_courses([*found, *self._under_way(road.grips, parent)])
        if not self._only_noise(found):
            found += self._in_other_courses(self._under_way(road.promising, parent))
        return self._with_drag_for_a_reason(found)

    def _in_other_courses(self, fits: Sequence[Fit]) -> list[Fit]:
        """What comes and goes along the road, in the other ways in which it may do so, too."""
        close = self.search.close
        best = best_of_each_law(fits)
        names = tuple(map(stretch, close.problem.runs))
        for forms in (road.halves, road.pulses, road.of_air, road.ahead, road.dragging):
            of_each = [others for fit in best if (others := forms(fit, names))]
            others = [fit for some in of_each[:PAIRED_ON] for fit in some]
            best = best_of_each_law(
                [*best, *close.side_by_side(lambda f: close.run(f, 10), others)]
            )
        return best

    def _under_way(
        self, promising: Callable[[Linear], list[ActiveEffect]], parent: Fit
    ) -> list[Fit]:
        """Laws that act in a part of the recording, that promise most in a vehicle, begun."""
        close = self.search.close
        calibrated, of_file = close.run(parent, 6), close.start()
        all_of_it = everything(close)
        starts = [
            replace(near, terms=tuple(self._sprung([term])))
            for near, course in (
                (calibrated, all_of_it.course(calibrated, calibrated=True)),
                (of_file, all_of_it.stricter().course(of_file)),
            )
            for term in promising(course)
        ]
        found = best_of_each_law(_held(all_of_it.fitter, starts))[:PAIRED_ON]
        return close.side_by_side(lambda f: close.run(f, 10), found)

    def _on_the_way(self, fits: Sequence[Fit], parent: Fit) -> list[Fit]:
        """What begins on the way, where laws that act all the time leave more than noise."""
        if parent.terms or self._only_noise(fits) or self._spent("what begins on the way"):
            return []
        found = self._under_way(sudden.promising, parent)
        best = min((fit.chi2 for fit in fits), default=math.inf)
        return [fit for fit in found if fit.chi2 < (1.0 - BESIDE_KNOWN) * best]

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

    def _swinging(self, parent: Fit) -> list[Fit]:
        """Oscillating masses, and a ball that moves, in the vehicle of the file.

        Where the library alone does not suffice.

        Near the frequency of the sway such a mass changes the whole motion; a vehicle whose values
        compensate for it is too far from the true one for the mass to be found from there.
        """
        if parent.terms:
            return []
        close = self.search.close
        start = close.start()
        starts = [
            replace(start, terms=(ActiveEffect(e, values),))
            for law in (*SWINGING, *IN_COUPLING)
            for e, values in self._set_going(law)
        ]
        excerpt = self._excerpt(start)
        parts = excerpt.fitter
        begun = parts.side_by_side(lambda f: parts.run(f, SET_GOING), map(excerpt.of, starts))
        best = excerpt.back(best_of_each_law(begun)[:GOING_ON], start)
        fits = close.side_by_side(lambda f: close.run(f, 10), best)
        return self._shaped_for_a_reason(fits, ())

    def _whole(self, law: Law) -> float:
        """Mass, or yaw inertia, of the body that contains the oscillating mass."""
        of = "yaw_inertia" if law.motion == "turn" else "mass"
        return float(self.search.close.problem.body[BODY.index(f"{law.place}.{of}")])

    def _set_going(self, law: Law) -> Iterator[tuple[Effect, tuple[float, ...]]]:
        """What moves by itself, with initial values: a mass by its frequency, or friction."""
        if law.place == BALL:
            effect = effect_of(law)
            size, other = effect.parameters
            yield from ((effect, (x, y)) for x in size.starts for y in other.starts)
            return
        mass = SWING_SHARE * self._whole(law)
        if law.slides:
            effect = effect_of(law)
            place, friction = effect.parameters[1:]
            yield from ((effect, (mass, place.starts[0], f)) for f in friction.starts)
            return
        for hz in SWING_HZ:
            effect = effect_of(law, hz)
            *middle, last = effect.parameters[1:]
            ends = last.starts if law.shape == UNEVEN else last.starts[:1]  # softer on either side
            yield from ((effect, (mass, *(p.starts[0] for p in middle), end)) for end in ends)

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
        """With its law in another form, where that fits clearly better; and once more.

        In a form instead of a free curve, which has more numbers, where that fits as well.
        """
        judge = self.search.judge
        for _ in range(RESHAPED):
            fit = candidate.fit
            term = fit.terms[-1]
            others = self._sprung([in_form(term, law) for law in refined(law_in(term))])
            starts = [replace(fit, terms=(*fit.terms[:-1], other)) for other in others]
            near = judge.side_by_side(lambda f: judge.run(f, 8), starts)
            best = min(near, key=lambda f: f.chi2, default=fit)
            better = -self._clearly(fit) if law_in(term).shape != CURVE else self._clearly(fit)
            if not best.chi2 < fit.chi2 + better:
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
            own = law_in(fit.terms[at])
            law = plainer(own)
            if law is None:
                return candidate
            known = fit.terms[at].as_dict()
            if "gain" in known:
                known["gain"] *= per_size(own, law)
            if law.response == LAGGED and "damping_ratio" in known:  # an oscillator that creeps
                known["lag_s"] = known["damping_ratio"] / (math.pi * known["frequency_hz"])
            hz = known["frequency_hz"] if law.swings else None
            runs = runs_of(fit.terms[at], law)
            effect = effect_of(law, hz, sprung=self.search.on_springs, runs=runs)
            inside = (min(max(known[p.name], p.low), p.high) for p in effect.parameters)
            term = ActiveEffect(effect, tuple(inside))
            terms = (*fit.terms[:at], term, *fit.terms[at + 1 :])
            found = self.search.judge.run(replace(fit, terms=terms), 20, tolerance=1e-6)
            if not found.chi2 < fit.chi2 + self._clearly(fit):
                return candidate
            self.tried.append(Candidate(found, candidate.parent))
            candidate = self.weighed(self.tried[-1])

    def _clearly(self, fit: Fit) -> float:
        """Drop of chi2 from which another shape fits clearly better."""
        return max(2.0 * CLAIMED * self.search.noise, DISCREPANCY * fit.chi2)


def _held(fitter: Fitter, fits: Sequence[Fit]) -> list[Fit]:
    """Fits under a strict observer, gone on with."""
    return fitter.side_by_side(lambda f: fitter.run(f, HELD), fits)


def _drags_for_a_reason(fit: Fit, plain: Mapping[Law, float], noise: float) -> bool:
    """No drag of wheels, or one that fits clearly better than the moment that it makes."""
    law = law_in(fit.terms[-1])
    if law.place != DRAG:
        return True
    moment = plain.get(replace(law, place=MOMENT), math.inf)
    return fit.chi2 < moment - max(2.0 * CLAIMED * noise, DISCREPANCY * moment)


def laws_refuse(budget: Budget, what: str) -> bool:
    """Laws have spent what they may; what was not tried for it is named."""
    return budget.refuses(what, OF_LAWS, budget.by_laws_s) or budget.refuses(what, OF_BOTH)


def least_ahead(law: Law) -> float:
    """Logarithm of the odds from which a law is claimed."""
    every_tyre = law.motion == "side_force"
    return CLAIMED if every_tyre else FORM


def library_suffices(path: Path) -> bool:
    """The library leaves only noise, without effects that one law may replace."""
    return path.clean and len(path.best.fit.terms) < SEVERAL[path.search.on_springs]
