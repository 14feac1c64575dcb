"""Which explanations: a beam search over the library, one and two effects at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.effect import RISE, Effect
from swaywatch.diagnose.fit import Fit, Fitter, Problem, Trial
from swaywatch.diagnose.locate import Course, Locator, reformed, simplified, widened, windows
from swaywatch.diagnose.term import Term

Array = NDArray[np.float64]

WORKERS = 2
BEAM = 3
WINDOW_SHARE = 0.01  # of chi2 that a window must be worth
FAR = 10.0  # level above which start values found without the effect are not trusted
VALUE_PRICE = 0.0005  # share of the level that a free number gains by chance
WINDOW_PRICE = 0.005  # the same for the place of a window
HOPELESS = 4.0  # a rival whose level is so many times the best one's is not polished
SHORT_LIST = 10
WINDOWED_LIST = 5
MORE_SHARE = 0.35  # of the usual amplitude that further windows must have
MOST_WINDOWS = 8
WORTH = 3.0  # a windowed effect is fitted if its linear course comes this near to the best
#: A term stays only if leaving it out raises chi2 by this share.
KEEP_SHARE = 0.02

#: Forms of a windowed effect that its windows are looked for with; others refine them.
FIRST_FORMS = ("box", "box_motion")

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Candidate:
    """A fit with one more term than its parent."""

    fit: Fit
    parent: Fit

    @property
    def level(self) -> float:
        """Mean squared normalised residual, with the price of the windows."""
        return priced(self.fit)


def level(fit: Fit) -> float:
    """Mean squared normalised residual."""
    return fit.chi2 / max(fit.count, 1)


def priced(fit: Fit) -> float:
    """Level with what free numbers, and windows found by looking everywhere, lower by chance."""
    free = sum(len(term.values) for term in fit.terms)
    chosen = sum(len(term.window_runs) for term in fit.terms)
    return level(fit) * (1.0 + VALUE_PRICE * free + WINDOW_PRICE * chosen)


def _each_once(ranked: Sequence[Candidate]) -> list[Candidate]:
    """Of forms of one windowed effect the best: `refined` tries the others on its windows."""
    kept: dict[object, Candidate] = {}
    for index, candidate in enumerate(ranked):
        term = candidate.fit.terms[-1]
        kept.setdefault(term.effect.name if term.effect.windowed else index, candidate)
    return list(kept.values())


def _moved_edges(term: Term, at: int, edge: int) -> list[Term]:
    """The term with an edge of the window at `at` of its values shifted, by what is worth a try."""
    neutral = [p.neutral for p in term.effect.parameters]
    sizes = [j for j, p in enumerate(term.effect.parameters) if p.name != RISE.name]
    found = []
    for shift in (-0.7, -0.35, -0.15, 0.15, 0.35, 0.7):
        for keep in (False, True):
            v = list(term.values)
            old = v[at + 1] - v[at]
            v[at + edge] += shift
            new = v[at + 1] - v[at]
            if new < 0.2:
                continue
            if keep and old > 0.0:
                for j in sizes:
                    v[at + 2 + j] = neutral[j] + (v[at + 2 + j] - neutral[j]) * old / new
            found.append(Term(term.effect, tuple(v), term.window_runs))
    return found


class Search:
    """Search over one problem."""

    def __init__(self, problem: Problem, effects: Sequence[Effect], progress: Progress) -> None:
        self.problem = problem
        self.fitter = Fitter(problem, fine=False)
        self.exact = Fitter(problem)
        against_simulation = bool(problem.runs[0].correction)
        self.effects = [
            e
            for e in effects
            if all(n in problem.runs[0].channels for n in e.needs)
            and (against_simulation or not e.extra.get("needs_simulation"))
        ]
        self.progress = progress
        self.cold = self.fitter.start()
        self.beam = BEAM

    def baseline(self) -> Fit:
        """Fit with nothing missing."""
        found = self.exact.run(self.cold, 8, shared_free=self.problem.free_start)
        self.cold.shared = found.shared
        return found

    def constant(self, parent: Fit, effect: Effect, frozen: Sequence[Array]) -> Fit | None:
        """Best fit of an effect without windows on top of a parent."""
        best: Fit | None = None
        count = max(len(p.starts) for p in effect.parameters)
        origins = [parent.nuisance]
        if level(parent) > FAR:
            origins.append(self.cold.nuisance)
        for start in range(count):
            values = tuple(p.starts[min(start, len(p.starts) - 1)] for p in effect.parameters)
            for nuisance in origins:
                fit = Fit((*parent.terms, Term(effect, values)), nuisance, self.cold.shared)
                fit = self.fitter.run(fit, 4, free=1, frozen=frozen)
                if best is None or fit.chi2 < best.chi2:
                    best = fit
        if best is not None and best.chi2 < 0.8 * parent.chi2:
            best = self.fitter.run(best, 5)
        return best

    def windowed(self, parent: Fit, course: Course) -> Fit | None:
        """Best fit of an effect in windows on top of a parent."""
        fit = self.rough(parent, course)
        return None if fit is None else self.completed(self.edges(fit))

    def rough(self, parent: Fit, course: Course) -> Fit | None:
        """Fit of an effect in windows before their edges are moved over local minima."""
        term = windows(course)
        if term is None:
            return None
        fit = Fit((*parent.terms, term), parent.nuisance, self.cold.shared)
        return self.fitter.run(fit, 6, free=1)

    def completed(self, fit: Fit) -> Fit:
        """With windows that show once the first ones are in the model."""
        term = fit.terms[-1]
        sizes = term.effect.parameters
        rows = np.array(term.values).reshape(-1, term.stride)[:, 2:]
        usual = np.median(np.hypot.reduce(rows - [p.neutral for p in sizes], axis=1))
        course = Locator(self.fitter, fit).course(term.effect)
        if course.gain < len(rows) * WINDOW_SHARE * fit.chi2:
            return fit
        more = windows(course, least=MORE_SHARE * float(usual))
        if more is None or len(rows) + len(more.window_runs) > MOST_WINDOWS:
            return fit
        both = Term(term.effect, term.values + more.values, term.window_runs + more.window_runs)
        trial = Fit((*fit.terms[:-1], simplified(both)), fit.nuisance, fit.shared)
        trial = self.edges(self.fitter.run(trial, 6, free=1))
        added = max(len(trial.terms[-1].window_runs) - len(rows), 1)
        return trial if trial.chi2 < (1.0 - added * WINDOW_SHARE) * fit.chi2 else fit

    def edges(self, fit: Fit, rounds: int = 3) -> Fit:
        """Move the edges of the last term's windows over local minima."""
        for _ in range(rounds):
            moved = self._scan_edges(fit)
            if moved is None:
                return fit
            fit = self.fitter.run(moved, 6, free=1)
        return fit

    def _scan_edges(self, fit: Fit) -> Fit | None:
        """Best shift of each edge in turn, amplitude kept or its product with the length."""
        term = fit.terms[-1]
        changed = False
        for w, r in enumerate(term.window_runs):
            for edge in (0, 1):
                trials = _moved_edges(term, w * term.stride, edge)
                found = term
                best, *others = self._chi2(fit, [term, *trials], r)
                for trial, chi2 in zip(trials, others, strict=True):
                    if chi2 < 0.995 * best:
                        best, found = chi2, trial
                changed |= found is not term
                term = found
        if not changed:
            return None
        return Fit((*fit.terms[:-1], term), fit.nuisance, fit.shared)

    def _chi2(self, fit: Fit, terms: Sequence[Term], run: int) -> list[float]:
        """Of one run, with each of the terms as the last one."""
        nuisance, before = fit.nuisance[run], fit.terms[:-1]
        trials = [Trial(run, (*before, term), nuisance, fit.shared) for term in terms]
        return [float(np.dot(e, e)) for e in self.fitter.evaluate_all(trials)]

    def refined(self, fit: Fit) -> Fit:
        """Better forms of windowed terms, where a module has them."""
        for i, term in enumerate(fit.terms):
            refine = term.effect.extra.get("refine")
            better = refine(term, self.problem.runs) if callable(refine) else None
            others = self.forms(term) if better is None else [better, widened(better, 0.35)]
            for other in others:
                terms = (*fit.terms[:i], other, *fit.terms[i + 1 :])
                trial = self.fitter.run(Fit(terms, fit.nuisance, fit.shared), 8, tolerance=1e-3)
                if i == len(fit.terms) - 1:
                    trial = self.edges(trial, 2)
                if trial.chi2 < fit.chi2:
                    fit = trial
        return fit

    def pruned(self, fit: Fit) -> Fit:
        """Without windows that are not needed: merged, too short, or of no effect."""
        for i in range(len(fit.terms)):
            term = simplified(fit.terms[i])
            trial = self._with_term(fit, i, term)
            if trial.chi2 < 1.05 * fit.chi2:
                fit = trial
            for w in reversed(range(len(fit.terms[i].window_runs))):
                term = fit.terms[i]
                if len(term.window_runs) < 2:
                    break
                k = term.stride
                fewer = Term(
                    term.effect,
                    term.values[: w * k] + term.values[(w + 1) * k :],
                    term.window_runs[:w] + term.window_runs[w + 1 :],
                )
                if self._total(self._replaced(fit, i, fewer)) > 1.5 * fit.chi2:
                    continue
                trial = self._with_term(fit, i, fewer)
                if trial.chi2 < (1.0 + WINDOW_SHARE) * fit.chi2:
                    fit = trial
        return fit

    def _with_term(self, fit: Fit, index: int, term: Term) -> Fit:
        if term.values == fit.terms[index].values or not term.effect.windowed or not term.values:
            return fit
        return self.fitter.run(self._replaced(fit, index, term), 6)

    @staticmethod
    def _replaced(fit: Fit, index: int, term: Term) -> Fit:
        terms = (*fit.terms[:index], term, *fit.terms[index + 1 :])
        return Fit(terms, fit.nuisance, fit.shared)

    def _total(self, fit: Fit) -> float:
        total = 0.0
        runs = range(len(self.problem.runs))
        trials = [Trial(r, fit.terms, fit.nuisance[r], fit.shared) for r in runs]
        for e in self.fitter.evaluate_all(trials):
            total += float(np.dot(e, e))
        return total

    def forms(self, term: Term) -> list[Term]:
        """The same windows with the other forms of the effect, from each start of what they add."""
        if not term.effect.windowed:
            return []
        known = {p.name for p in term.effect.parameters}
        return [
            reformed(term, e, start)
            for e in self.effects
            if e.id == term.effect.id
            and e.component == term.effect.component
            and e.extra.get("form", "box") != term.effect.extra.get("form", "box")
            for start in range(
                max((len(p.starts) for p in e.parameters if p.name not in known), default=1)
            )
        ]

    def polish(self, fits: Sequence[Fit]) -> list[Fit]:
        """Fit to the end, in the best form."""
        shaped = self.fitter.side_by_side(
            lambda fit: self.pruned(self.refined(self.fitter.run(fit, 20, tolerance=1e-4))), fits
        )
        return self.exact.side_by_side(
            lambda fit: self.exact.run(fit, 6, shared_free=self.problem.free_start), shaped
        )

    def linear_gain(self, locator: Locator, effect: Effect) -> float:
        """Drop of chi2 that a linear step of an effect without windows promises."""
        fit = locator.fit
        trials = []
        for r in range(len(self.problem.runs)):
            for j, p in enumerate(effect.parameters):
                values = [q.neutral for q in effect.parameters]
                toward = 1.0 if p.starts[0] >= p.neutral else -1.0
                values[j] += toward * p.scale
                if effect.id == "tyre_saturation":
                    values[j] = 2.0
                if effect.id == "tyre_relaxation":
                    values[j] = 0.2
                term = Term(effect, tuple(values))
                trials.append(Trial(r, (*fit.terms, term), fit.nuisance[r], fit.shared))
        found = self.fitter.evaluate_all(trials)
        k = len(effect.parameters)
        normal = np.zeros((k, k))
        right = np.zeros(k)
        for r in range(len(self.problem.runs)):
            own = found[r * k : (r + 1) * k]
            a = np.stack([e - locator.base[r] for e in own], axis=1)
            n = locator.nuisance[r]
            project = np.linalg.lstsq(n, a, rcond=None)[0]
            a = a - n @ project
            normal += a.T @ a
            right += a.T @ locator.base[r]
        return float(right @ np.linalg.lstsq(normal, right, rcond=None)[0])

    def extend(
        self, parent: Fit, *, everything: bool, kinds: tuple[bool, ...] = (False, True)
    ) -> list[Candidate]:
        """Fits of the parent with one more effect, best first.

        Parameters
        ----------
        parent
            Fit to add to.
        everything
            Fit every constant effect, not only those that a linear step recommends.
        kinds
            Whether effects without (False) and with (True) windows are tried.
        """
        locator = Locator(self.fitter, parent)
        taken = {(t.effect.id, t.effect.component) for t in parent.terms}
        # a second set of windows of the same id only mends the form of the first
        in_windows = {t.effect.id for t in parent.terms if t.effect.windowed}
        open_ = [
            e
            for e in self.effects
            if (e.id, e.component) not in taken and e.windowed in kinds and e.id not in in_windows
        ]
        constant = [e for e in open_ if not e.windowed]
        if not everything:
            gains = self.fitter.side_by_side(lambda e: self.linear_gain(locator, e), constant)
            ranked = sorted(zip(gains, range(len(gains)), strict=True), reverse=True)
            constant = [constant[i] for _, i in ranked[:SHORT_LIST]]
        windowed = [e for e in open_ if e.windowed and e.extra.get("form", "box") in FIRST_FORMS]
        found: list[Candidate] = []
        with ThreadPoolExecutor(WORKERS) as pool:
            courses = list(pool.map(locator.course, windowed))
            fits = self.fitter.side_by_side(
                lambda e: self.constant(parent, e, locator.nuisance), constant
            )
            found = [Candidate(f, parent) for f in fits if f is not None and np.isfinite(f.chi2)]
            best = min((f.chi2 for f in fits if f is not None), default=parent.chi2)
            courses = [c for c in courses if c.gain > 0.05 * parent.chi2]
            courses = [c for c in courses if parent.chi2 - c.gain < WORTH * best]
            courses.sort(key=lambda c: -c.gain)
            started = self.fitter.side_by_side(
                lambda c: self.rough(parent, c), courses[:WINDOWED_LIST]
            )
            rough = [f for f in started if f is not None and np.isfinite(f.chi2)]
            best = min([best, *(f.chi2 for f in rough)])
            near = [f for f in rough if f.chi2 < WORTH * best]
            far = [f for f in rough if f.chi2 >= WORTH * best]
            moved = self.fitter.side_by_side(lambda f: self.completed(self.edges(f)), near)
            found += [Candidate(f, parent) for f in (*moved, *far) if np.isfinite(f.chi2)]
        found = _each_once(sorted(found, key=lambda c: c.level))
        polished = [Candidate(fit, parent) for fit in self.polish([c.fit for c in found[:1]])]
        worth = [c for c in found[1:BEAM] if c.level < HOPELESS * polished[0].level]
        polished += [Candidate(fit, parent) for fit in self.polish([c.fit for c in worth])]
        return sorted([*polished, *found[1 + len(worth) :]], key=lambda c: c.level)

    def swap(self, pair: Candidate) -> list[Candidate]:
        """Each term of a pair searched again in the presence of the other."""
        found = []
        for term in pair.fit.terms:
            rest = tuple(t for t in pair.fit.terms if t is not term)
            fit = self.fitter.run(Fit(rest, pair.fit.nuisance, pair.fit.shared), 3)
            found += self.extend(fit, everything=True, kinds=(term.effect.windowed,))[:BEAM]
        return sorted([pair, *found], key=lambda c: c.level)
