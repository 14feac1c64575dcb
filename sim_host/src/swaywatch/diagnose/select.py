"""Which explanations: a beam search over the library, one and two effects at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from swaywatch.diagnose.effect import Effect
from swaywatch.diagnose.fit import Fit, Fitter, Problem, Term
from swaywatch.diagnose.locate import Locator, windows

WORKERS = 2
BEAM = 3
SHORT_LIST = 10
#: A term stays only if leaving it out raises chi2 by this share.
KEEP_SHARE = 0.02

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Candidate:
    """A fit with one more term than its parent."""

    fit: Fit
    parent: Fit

    @property
    def level(self) -> float:
        """Mean squared normalised residual, with the price of the windows."""
        free = sum(len(term.values) for term in self.fit.terms)
        return self.fit.chi2 / self.fit.count * (1.0 + 0.0005 * free)


def level(fit: Fit) -> float:
    """Mean squared normalised residual."""
    return fit.chi2 / max(fit.count, 1)


class Search:
    """Search over one problem."""

    def __init__(self, problem: Problem, effects: Sequence[Effect], progress: Progress) -> None:
        self.problem = problem
        self.fitter = Fitter(problem)
        self.effects = [e for e in effects if all(n in problem.runs[0].channels for n in e.needs)]
        self.progress = progress
        self.cold = self.fitter.start()

    def baseline(self) -> Fit:
        """Fit with nothing missing."""
        return self.fitter.run(self.cold, 8)

    def constant(self, parent: Fit, effect: Effect) -> Fit | None:
        """Best fit of an effect without windows on top of a parent."""
        best: Fit | None = None
        count = max(len(p.starts) for p in effect.parameters)
        for start in range(count):
            values = tuple(p.starts[min(start, len(p.starts) - 1)] for p in effect.parameters)
            for origin in (parent, self.cold):
                nuisance = parent.nuisance if origin is parent else self.cold.nuisance
                fit = Fit((*parent.terms, Term(effect, values)), nuisance, self.cold.shared)
                fit = self.fitter.run(fit, 3, free=1)
                if best is None or fit.chi2 < best.chi2:
                    best = fit
        if best is not None:
            best = self.fitter.run(best, 6)
        return best

    def windowed(self, locator: Locator, parent: Fit, effect: Effect) -> Fit | None:
        """Best fit of an effect in windows on top of a parent."""
        course = locator.course(effect)
        if course.gain < 0.05 * parent.chi2:
            return None
        term = windows(course)
        if term is None:
            return None
        fit = Fit((*parent.terms, term), parent.nuisance, self.cold.shared)
        return self.fitter.run(fit, 10)

    def linear_gain(self, locator: Locator, effect: Effect) -> float:
        """Drop of chi2 that a linear step of an effect without windows promises."""
        fit = locator.fit
        gain = 0.0
        columns: list[list[np.ndarray]] = []
        for r in range(len(self.problem.runs)):
            row = []
            for j, p in enumerate(effect.parameters):
                values = [q.neutral for q in effect.parameters]
                toward = 1.0 if p.starts[0] >= p.neutral else -1.0
                values[j] += toward * p.scale
                if effect.id == "tyre_saturation":
                    values[j] = 2.0
                if effect.id == "tyre_relaxation":
                    values[j] = 0.2
                term = Term(effect, tuple(values))
                e = self.fitter.evaluate(r, (*fit.terms, term), fit.nuisance[r], fit.shared)
                row.append(e - locator.base[r])
            columns.append(row)
        k = len(effect.parameters)
        normal = np.zeros((k, k))
        right = np.zeros(k)
        for r, row in enumerate(columns):
            a = np.stack(row, axis=1)
            n = locator.nuisance[r]
            project = np.linalg.lstsq(n, a, rcond=None)[0]
            a = a - n @ project
            normal += a.T @ a
            right += a.T @ locator.base[r]
        gain = float(right @ np.linalg.lstsq(normal, right, rcond=None)[0])
        return gain

    def extend(self, parent: Fit, *, everything: bool) -> list[Candidate]:
        """Fits of the parent with one more effect, best first."""
        locator = Locator(self.fitter, parent)
        taken = {(t.effect.id, t.effect.component) for t in parent.terms}
        open_ = [e for e in self.effects if (e.id, e.component) not in taken]
        constant = [e for e in open_ if not e.windowed]
        if not everything:
            gains = [(self.linear_gain(locator, e), i) for i, e in enumerate(constant)]
            gains.sort(reverse=True)
            constant = [constant[i] for _, i in gains[:SHORT_LIST]]
        windowed = [e for e in open_ if e.windowed and e.extra.get("form", "box") == "box"]

        def work(effect: Effect) -> Fit | None:
            if effect.windowed:
                return self.windowed(locator, parent, effect)
            return self.constant(parent, effect)

        found: list[Candidate] = []
        with ThreadPoolExecutor(WORKERS) as pool:
            for fit in pool.map(work, [*constant, *windowed]):
                if fit is not None and np.isfinite(fit.chi2):
                    found.append(Candidate(fit, parent))
        found.sort(key=lambda c: c.level)
        polished = [
            Candidate(self.fitter.run(c.fit, 20, tolerance=1e-4), parent) for c in found[:BEAM]
        ]
        found = sorted([*polished, *found[BEAM:]], key=lambda c: c.level)
        return found
