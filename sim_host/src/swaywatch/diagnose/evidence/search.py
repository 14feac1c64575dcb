"""Which explanations: a beam search over the library, one effect after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.evidence import (
    DISCREPANCY,
    UNEXPLAINED_ABOVE,
    explained,
    inflation,
    least_gain,
    log_evidence,
    residuals,
)
from swaywatch.diagnose.evidence.locate import (
    MOST_AT_ONCE,
    AmplitudeCourse,
    Locator,
    faint_windows,
    joined,
    reformed,
    simplified,
    stretches,
    widened,
    windows,
)
from swaywatch.diagnose.evidence.sparse_course import sparse_course
from swaywatch.diagnose.fit.fit import OBSERVER, Fit, Fitter, Problem, Trial
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import RISE, Effect
from swaywatch.errors import RecordingError
from swaywatch.plant.lanes import BODY

Array = NDArray[np.float64]

WORKERS = 2
BEAM = 3
WINDOW_WORTH = 25.0  # drop of chi2 that pays for the edges and the value of a window
EDGE_WORTH = 4.0  # drop of chi2 that is worth moving an edge
SHORT_LIST = 8  # candidates that are fitted
POLISHED = 3  # of them to the end
WINDOWED_LIST = 5
AT_ONCE = 128  # effects whose residuals are in memory at a time
LARGER = 64.0  # times a given size, up to which the size of an effect is estimated from it
WEAK = 0.6  # of the gain of the best one in windows, below which another is not followed
PROMISED = 0.5  # of what one more effect has to take away to be claimed; below it none is begun
MORE_SHARE = 0.35  # of the usual amplitude that further windows must have; ...
FADED_SHARE = 0.15  # ... of what follows the motion, whose square falls as a swing decays
CLEAR_S = 1.0  # from a larger window to a small one that is not only a correction of its shape
MOST_WINDOWS = 40
COMPLETED = 2  # times that further windows are looked for
CHOICES = 500  # windows that a run of forty seconds has room for
#: Pulls of the observer on the way from the search to free simulation, 1/s: near the critical speed
#: a free simulation converges only from nearby.
RELEASED = (0.5, 0.0)
STUCK = 0.1  # of what an effect takes away, done by its vehicle alone: the baseline was stuck
BENT = 0.8  # an effect that takes more of the misfit away has bent the values of its parent
LINEAR = 2.0  # reduced chi-square up to which free simulation is trusted for first-order courses
TRAILER_FRONT = BODY.index("trailer.front_cornering_stiffness")
FOLLOWED = 3.0  # misfit, over that of the best, up to which an effect without windows is followed
HARDLY = 0.9  # of the misfit: effects that leave more of it wait until those in windows are tried
FAR = 100.0  # a neutral value beyond it stands for infinity
NEAR_NEUTRAL = 0.1  # of the way to a start: where a fit begins that need not go far

RUNS_AWAY = (
    "the simulated vehicle diverges in this recording, even while it is held to the measured yaw "
    "rates: masses, lengths or stiffnesses of vehicle.toml, or the units and signs of steering and "
    "speed, cannot be right"
)

LIBRARY_SHARE = 0.8  # of the budget; laws took 0.4 to 1.2 of the 6 million simulated seconds
WINDOWED_STEP = "effects in windows"  # in words, for what was left untried
#: Forms of a windowed effect that its windows are looked for with; others refine them.
FIRST_FORMS = ("box", "box_motion")

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Candidate:
    """A fit in free simulation, and its evidence.

    Attributes
    ----------
    fit, parent
        With one more active effect than its parent.
    evidence
        Logarithm of the marginal likelihood.
    """

    fit: Fit
    parent: Fit
    evidence: float = -np.inf

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its effects."""
        return tuple(sorted(t.effect.name for t in self.fit.terms))


def reduced_chi_square(fit: Fit) -> float:
    """Reduced chi-square."""
    return fit.chi2 / max(fit.count, 1)


def _moved_edges(term: ActiveEffect, at: int, edge: int) -> list[ActiveEffect]:
    """Active effects with one edge of the window at `at` of its values shifted, worth a try."""
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
            found.append(ActiveEffect(term.effect, tuple(v), term.window_runs))
    return found


class Linear:
    """What effects explain to first order, everything else refitted within its priors."""

    def __init__(self, fitter: Fitter, fit: Fit) -> None:
        self.fitter, self.fit = fitter, fit
        problem = fitter.problem
        self.runs = range(len(problem.runs))
        trials = [Trial(r, fit.terms, fit.nuisance[r], fit.shift) for r in self.runs]
        self.base = fitter.evaluate_all(trials)
        self.background = background = fitter.backgrounds(fit, self.runs, self.base)
        beliefs = problem.beliefs
        b, n = len(beliefs), background[0][0].shape[1] - len(beliefs)
        sizes = [e.size for e in self.base]
        prior = beliefs.misfit(fit.shift)
        rows = np.zeros((sum(sizes) + prior.size, b + n * len(sizes)))
        first = 0
        for r, size in enumerate(sizes):
            columns = background[r][0]
            rows[first : first + size, :b] = columns[:, :b]
            rows[first : first + size, b + r * n : b + (r + 1) * n] = columns[:, b:]
            first += size
        rows[first:, :b] = beliefs.roots
        rows /= np.sqrt(np.sum(rows**2, axis=0)) + 1e-12
        self.q = np.linalg.qr(rows)[0]
        self.left = self._projected(np.concatenate([*self.base, prior]))

    def _projected(self, column: Array) -> Array:
        return np.asarray(column - self.q @ (self.q.T @ column))

    def best(
        self, effects: Sequence[Effect], *, shaped: bool = True
    ) -> list[tuple[float, tuple[float, ...], Effect]]:
        """Of each effect the largest drop of chi2 that a start promises, and values to begin with.

        Those that promise nothing are left out; best first. `shaped`: values that only shape an
        effect are moved too, and those best with them and best without take turns, so that effects
        with many such values do not crowd out a plain one.
        """
        tried = [(e, values) for e in effects for values in _starts(e)]
        moved = self._moved(tried)
        found: dict[tuple[str, str], tuple[float, tuple[float, ...], Effect]] = {}
        for (effect, values), own in zip(tried, moved, strict=True):
            gain, toward = self._promise(effect, np.array(values), own)
            key = form_of(effect)
            if gain > found.get(key, (0.0,))[0]:
                found[key] = gain, tuple(float(x) for x in toward), effect
        plain = sorted(found.values(), key=lambda f: -f[0])
        if not shaped:
            return plain
        moved_too = {id(f[2]): self._with_form(f) for f in plain}
        by_form = sorted(moved_too.values(), key=lambda f: -f[0])
        turns = [id(f[2]) for pair in zip(by_form, plain, strict=True) for f in pair]
        return [moved_too[name] for name in dict.fromkeys(turns)]

    def sized(self, terms: Sequence[ActiveEffect]) -> list[tuple[float, ActiveEffect]]:
        """Of each active effect the drop of chi2 that it promises with its best size, and with it.

        Its size is its first value, and the drop what a change in proportion to it brings; at most
        `LARGER` times the given size, and within its bounds.
        """
        found: list[tuple[float, ActiveEffect]] = []
        for at in range(0, len(terms), AT_ONCE):  # residuals of all at once would fill the memory
            some = terms[at : at + AT_ONCE]
            moved = self._moved([(term.effect, term.values) for term in some])
            found += [self._sized(term, own) for term, own in zip(some, moved, strict=True)]
        return found

    def _sized(self, term: ActiveEffect, moved: Array) -> tuple[float, ActiveEffect]:
        """The same of one, with the residuals that it changes at its values."""
        size, neutral = term.effect.parameters[0], term.effect.parameters[0].neutral
        power, factor = self._along(self._column(moved))
        best = neutral + min(max(factor, -LARGER), LARGER) * (term.values[0] - neutral)
        best = min(max(best, size.low), size.high)
        if power == 0.0 or best == neutral:
            return 0.0, term  # against a bound
        return power * factor**2, replace(term, values=(best, *term.values[1:]))

    def _moved(self, tried: Sequence[tuple[Effect, tuple[float, ...]]]) -> list[Array]:
        """Residuals of all runs with each effect at its values, one after the other."""
        fit, count = self.fit, len(self.runs)
        trials = [
            Trial(r, (*fit.terms, ActiveEffect(e, values)), fit.nuisance[r], fit.shift)
            for e, values in tried
            for r in self.runs
        ]
        found = self.fitter.evaluate_all(trials)
        return [np.concatenate(found[i * count : (i + 1) * count]) for i in range(len(tried))]

    def columns(self, tried: Sequence[tuple[Effect, tuple[float, ...]]]) -> list[Array]:
        """What each effect changes at its values, everything else refitted."""
        return [self._column(moved) for moved in self._moved(tried)]

    def by_run(self, tried: Sequence[tuple[Effect, tuple[float, ...]]]) -> list[Array]:
        """What each effect changes in each run alone, everything else refitted; (rows, runs)."""
        sizes = [e.size for e in self.base]
        edges = [0, *np.cumsum(sizes)]
        found = []
        for moved in self._moved(tried):
            apart = np.zeros((self.left.size, len(sizes)))
            change = moved - np.concatenate(self.base)
            for r in range(len(sizes)):
                inside = slice(edges[r], edges[r + 1])
                apart[inside, r] = change[inside]
            found.append(self._projected(apart))
        return found

    def from_then_on(
        self,
        tried: Sequence[tuple[Effect, tuple[float, ...]]],
        begins: Sequence[Sequence[int]],
    ) -> Iterator[tuple[Array, Array]]:
        """Products of what each effect changes from some blocks of each run on, the rest refitted.

        With each other, shape (n, n), and with what is left, shape (n,), n the blocks of all runs.
        """
        sizes = [e.size for e in self.base]
        edges = [0, *np.cumsum(sizes)]
        for change in self.changes(tried):
            apart = np.zeros((self.left.size, sum(map(len, begins))))
            column = 0
            for r, blocks in enumerate(begins):
                width = change[r].shape[1]
                for block in blocks:
                    rows = slice(edges[r] + block * width, edges[r + 1])
                    apart[rows, column] = change[r][block:].ravel()
                    column += 1
            along = self.q.T @ apart
            yield apart.T @ apart - along.T @ along, apart.T @ self.left

    def changes(self, tried: Sequence[tuple[Effect, tuple[float, ...]]]) -> Iterator[list[Array]]:
        """What each effect changes in each run, shape (blocks, channels); 0 if it ran away."""
        widths = [len(self.fitter.comparison(r).names) for r in self.runs]
        for at in range(0, len(tried), AT_ONCE):
            for moved in self._moved(tried[at : at + AT_ONCE]):
                own = np.split(moved, np.cumsum([e.size for e in self.base])[:-1])
                yield [
                    np.where(np.isfinite(x), x - e, 0.0).reshape(-1, width)
                    for x, e, width in zip(own, self.base, widths, strict=True)
                ]

    def _promise(self, effect: Effect, values: Array, moved: Array) -> tuple[float, Array]:
        """Drop of chi2 along the course towards some values, and where on it to begin."""
        power, factor = self._along(self._column(moved))
        if power == 0.0:
            return 0.0, values
        neutral = np.array([p.neutral for p in effect.parameters])
        if np.any(np.abs(neutral) > FAR):
            return (power * factor**2, values) if factor > 0.0 else (0.0, values)
        start = neutral + np.clip(factor, -3.0, 3.0) * (values - neutral)
        low = np.array([p.low for p in effect.parameters])
        start = np.clip(start, low, [p.high for p in effect.parameters])
        if np.allclose(start, neutral):
            return 0.0, values  # against a bound
        return power * factor**2, start

    def _along(self, column: Array) -> tuple[float, float]:
        """Power of a change, and how much of it is missing; nothing of what ran away."""
        with np.errstate(over="ignore", invalid="ignore"):
            power = float(np.dot(column, column))
        if power < 1e-9 or not np.isfinite(power):
            return 0.0, 0.0
        return power, -float(np.dot(column, self.left)) / power

    def _column(self, moved: Array) -> Array:
        """What residuals changed by, everything else refitted."""
        none = np.zeros(len(self.fitter.problem.beliefs.target))
        return self._projected(np.concatenate([moved - np.concatenate(self.base), none]))

    def _with_form(
        self, found: tuple[float, tuple[float, ...], Effect]
    ) -> tuple[float, tuple[float, ...], Effect]:
        """What an effect promises with the values that only shape it moved too.

        Beside a user's simulation an effect carries what follows from it, of unknown size; along
        its main value alone it promises too little.
        """
        gain, values, effect = found
        shape = [j for j, p in enumerate(effect.parameters) if p.shapes]
        if not shape:
            return found
        steps = [effect.parameters[j].scale for j in shape]
        trials = [values]
        for j, step in zip(shape, steps, strict=True):
            trials.append((*values[:j], values[j] + step, *values[j + 1 :]))
        own, *others = self._moved([(effect, trial) for trial in trials])
        course = self._column(own)
        a = np.stack([course, *(self._column(other) - course for other in others)], axis=1)
        size = np.sqrt(np.sum(a**2, axis=0)) + 1e-12
        if not np.all(np.isfinite(size)):
            return found
        x = np.linalg.lstsq(a / size, -self.left, rcond=1e-6)[0] / size
        rest = self.left + a @ x
        more = float(np.dot(self.left, self.left) - np.dot(rest, rest))
        if x[0] <= 0.0 or more <= gain:
            return found
        start = list(values)
        for j, step, change in zip(shape, steps, x[1:], strict=True):
            p = effect.parameters[j]
            start[j] = float(np.clip(values[j] + step * change, p.low, p.high))
        return more, tuple(start), effect


Beyond = Callable[["Search"], float | None]


class Search:
    """Search over one problem.

    Windows are looked for under an observer, so that nothing is amplified by the nearness of the
    critical speed; what is found is fitted and weighed in free simulation, which carries on what
    the observer forgets. Beside a user's simulation, whose small differences free simulation
    carries on too, everything stays under the observer.
    """

    def __init__(self, problem: Problem, effects: Sequence[Effect], progress: Progress) -> None:
        own = problem.free_start
        self.problem = problem
        watched = replace(problem, observer=OBSERVER)
        self.close = Fitter(watched, fine=False)
        self.judge = Fitter(problem if own else watched)
        self.releases = [Fitter(replace(problem, observer=o)) for o in RELEASED] if own else []
        self.effects = [
            e
            for e in _distinguished(effects, problem)
            if all(n in problem.runs[0].channels for n in e.needs)
            and (not own or not e.extra.get("needs_simulation"))
            and (problem.on_springs or not e.extra.get("needs_springs"))
        ]
        self.progress = progress
        #: Evidence that these effects have to reach because one law that is none of them leaves
        #: only noise; None where there is no such law.
        self.beyond: Beyond | None = None
        self.ended_by_law = False
        self.noise = 1.0
        self.tried: list[Candidate] = []
        self._base: Candidate | None = None
        #: By the identity of a parent: itself and it under the observer, its fits with one effect
        #: without windows there, and where they are judged.
        self._parents: dict[int, tuple[Fit, Fit]] = {}
        self._under: dict[int, list[Fit]] = {}
        self._found: dict[int, list[Fit]] = {}
        #: Likewise a parent and what extends it, in windows too and not.
        self._extended: dict[tuple[int, bool], tuple[Fit, list[Candidate]]] = {}

    @property
    def on_springs(self) -> bool:
        """Whether the vehicle is one on springs."""
        return self.problem.on_springs

    def baseline(self, near: Fit | None = None) -> Candidate:
        """The calibrated vehicle, nothing missing; a fit `near` it is a second start."""
        if self._base is not None:
            return self._base
        starts = [self.close.start(), *([] if near is None else [near])]
        close = self.close.side_by_side(lambda start: self.close.run(start, 20), starts)
        fit = min(map(self.released, close), key=lambda f: f.chi2)
        if not np.isfinite(fit.chi2):
            raise RecordingError(RUNS_AWAY)
        self.noise = inflation(residuals(self.judge, fit))
        self._base = Candidate(fit, fit)
        return self._base

    def rebased(self, found: Fit) -> bool:
        """Whether a search from the baseline has to be begun again, because it was stuck.

        The vehicle that an effect was found beside is the baseline from now on if it fits better
        without the effect than the one before. Where that is much of what the effect took away, the
        effect only led out of there; where it is little, what was found is found from both.
        """
        before = self.baseline().fit
        fit = self.judge.run(replace(found, terms=()), 12, tolerance=3e-4)
        if not fit.chi2 < (1.0 - DISCREPANCY) * before.chi2:
            return False
        self._base = Candidate(fit, fit)
        noise = inflation(residuals(self.judge, fit))
        stuck = before.chi2 - fit.chi2 > STUCK * (before.chi2 - found.chi2)
        self.noise = noise if stuck else min(self.noise, noise)
        return stuck

    def released(self, fit: Fit, iterations: int = 10) -> Fit:
        """A fit under the observer, refitted with everything free where it is judged."""
        for fitter in self.releases or [self.judge]:
            fit = fitter.run(fit, iterations, tolerance=3e-4)
        return fit

    def weighed(self, candidate: Candidate) -> Candidate:
        """With its evidence."""
        value = log_evidence(self.judge, candidate.fit, self.noise, len(self.effects))
        return replace(candidate, evidence=value)

    def constants(self, fitter: Fitter, parent: Fit, open_: Sequence[Effect]) -> list[Fit]:
        """The most promising effects without windows, the best of them with everything free."""
        price = 2.0 * np.log(len(self.effects))
        if parent.terms:
            price = max(price, self._promised(fitter, parent, windowed=False))
        course = Linear(fitter, parent)
        found = [f for f in course.best(open_) if f[0] > price]
        starts = [
            replace(parent, terms=(*parent.terms, ActiveEffect(effect, values)))
            for _, values, effect in found[:SHORT_LIST]
        ]
        near = fitter.side_by_side(lambda f: fitter.run(f, 6, frozen=course.background), starts)
        if fitter is self.close:  # they may be stuck where their parent is bent
            first = near[:POLISHED]
            far = reduced_chi_square(parent) > LINEAR
            stuck = first if far else [f for f in first if f.chi2 > parent.chi2]
            near += self._close_from_rest(stuck)
        near = _best_of_each(near)
        first = _followed(near[:POLISHED])
        best = fitter.side_by_side(lambda f: fitter.run(f, 12, tolerance=3e-4), first)
        return [*best, *near[len(first) :]]

    def _promised(self, fitter: Fitter, parent: Fit, *, windowed: bool) -> float:
        """Drop of chi2 that one more effect has to promise to first order to be begun.

        Nothing where so much is left that a first-order course says little.
        """
        if reduced_chi_square(parent) > LINEAR:
            return 0.0
        base = self.baseline().fit
        base = self._near(base) if fitter is self.close else base
        least = least_gain(base, parent, windowed=windowed, on_springs=self.on_springs)
        return PROMISED * least

    def windowed(self, locator: Locator, course: AmplitudeCourse) -> Fit | None:
        """Best fit of an effect in windows on top of the locator's parent."""
        fit = self.rough(locator, course)
        return None if fit is None else self.completed(self.edges(fit))

    def rough(self, locator: Locator, course: AmplitudeCourse) -> Fit | None:
        """Fit of an effect in windows before their edges are moved over local minima."""
        parent = locator.fit
        terms = [windows(course), self._of_course(locator, course)]
        if terms == [None, None]:
            terms = [faint_windows(course, self._faint(parent))]
        starts = [(parent, t) for t in terms if t is not None]
        own = bool(course.effect.extra.get("trials"))  # its pulses are not its real form
        found = None
        if reduced_chi_square(parent) > LINEAR and not own:
            found = sparse_course(self.close, parent, course.effect)
        if found is not None:
            term = windows(found[0])
            starts += [(found[1], term)] if term is not None else []
        if reduced_chi_square(parent) > LINEAR and not parent.terms:
            # the parent's vehicle is bent to make up for what these windows explain
            rest = self.close.start()
            starts += [(rest, t) for _, t in starts]
        fits = [
            self.close.run(Fit((*parent.terms, t), s.nuisance, s.shift), 6, free=1)
            for s, t in starts
        ]
        return min(fits, key=lambda f: f.chi2, default=None)

    def _of_course(
        self, locator: Locator, course: AmplitudeCourse, least: float = 0.0
    ) -> ActiveEffect | None:
        """The effect in the form that the motion itself gives it, where a module has one."""
        trials = course.effect.extra.get("trials")
        parts = stretches(course, least=least) if callable(trials) else []
        if not callable(trials) or not 0 < len(parts) <= MOST_AT_ONCE:
            return None
        found: list[ActiveEffect] = []
        for r, start, stop in parts:
            terms = trials(course.effect.component, start, stop, r)
            columns = locator.columns(r, terms)
            along = np.array([-float(np.dot(c, locator.base[r])) for c in columns])
            power = np.array([float(np.dot(c, c)) + 1e-12 for c in columns])
            best = int(np.argmax(np.where(along > 0.0, along**2 / power, -1.0)))
            begin, end, size, *rest = terms[best].values
            factor = min(max(along[best] / power[best], 0.1), 5.0)
            values = (begin, end, factor * size, *rest)
            found.append(replace(terms[best], values=values))
        return joined(found)

    def completed(self, fit: Fit) -> Fit:
        """With windows that show once the first ones are in the model."""
        for _ in range(COMPLETED):
            more = self._with_more_windows(fit)
            if more is None:
                return fit
            fit = more
        return fit

    def _with_more_windows(self, fit: Fit) -> Fit | None:
        """With further windows of the last effect, if they are worth it."""
        term = fit.terms[-1]
        count = len(term.window_runs)
        more = self._more_windows(fit)
        if more is None or count + len(more.window_runs) > MOST_WINDOWS:
            return None
        if more.effect is not term.effect and not term.effect.extra.get("final"):
            more = reformed(more, term.effect)
        both = ActiveEffect(
            term.effect, term.values + more.values, term.window_runs + more.window_runs
        )
        trial = Fit((*fit.terms[:-1], simplified(both)), fit.nuisance, fit.shift)
        trial = self.edges(self.close.run(trial, 6, free=1))
        own = trial.terms[-1].without_remainders(MORE_SHARE, CLEAR_S)
        if own is not trial.terms[-1]:
            trial = self.close.run(replace(trial, terms=(*trial.terms[:-1], own)), 6, free=1)
        added = max(len(trial.terms[-1].window_runs) - count, 1)
        return trial if trial.chi2 < fit.chi2 - added * _window_worth(fit) else None

    def _more_windows(self, fit: Fit) -> ActiveEffect | None:
        """Windows of the last effect that stand out beside its own, in pulses short or long."""
        term = fit.terms[-1]
        sizes, extra = term.effect.parameters, term.effect.extra
        rows = np.array(term.values).reshape(-1, term.stride)[:, 2:]
        usual = np.median(np.hypot.reduce(rows - [p.neutral for p in sizes], axis=1))
        least = (FADED_SHARE if extra.get("follows_motion") else MORE_SHARE) * float(usual)
        locator = Locator(self.close, fit)
        course = locator.course(self._first_form(term.effect))
        if course.gain < WINDOW_WORTH + self._by_chance(course):
            return None
        if extra.get("final"):
            return self._of_course(locator, course, least)
        return windows(course, least=least) or faint_windows(course, self._faint(fit))

    def _faint(self, fit: Fit) -> float:
        """Drop of chi2 that a window must promise whose single pulses do not stand out."""
        return _window_worth(fit) + 2.0 * float(np.log(CHOICES * len(self.effects)))

    def _first_form(self, effect: Effect) -> Effect:
        """The form of an effect in windows that it is looked for with."""
        if effect.extra.get("form", "box") in FIRST_FORMS:
            return effect
        same = (e for e in self.effects if (e.id, e.component) == (effect.id, effect.component))
        return next(e for e in same if e.extra.get("form", "box") in FIRST_FORMS)

    def edges(self, fit: Fit, rounds: int = 3) -> Fit:
        """Move the edges of the last active effect's windows over local minima."""
        for _ in range(rounds):
            moved = self._scan_edges(fit)
            if moved is None:
                return fit
            fit = self.close.run(moved, 6, free=1)
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
                    if chi2 < best - EDGE_WORTH:
                        best, found = chi2, trial
                changed |= found is not term
                term = found
        if not changed:
            return None
        return Fit((*fit.terms[:-1], term), fit.nuisance, fit.shift)

    def _chi2(self, fit: Fit, terms: Sequence[ActiveEffect], run: int) -> list[float]:
        """Of one run, with each of the active effects as the last one."""
        nuisance, before = fit.nuisance[run], fit.terms[:-1]
        trials = [Trial(run, (*before, term), nuisance, fit.shift) for term in terms]
        return [float(np.dot(e, e)) for e in self.close.evaluate_all(trials)]

    def refined(self, fit: Fit) -> Fit:
        """Better forms of active effects in windows, where a module has them."""
        for i, term in enumerate(fit.terms):
            refine = term.effect.extra.get("refine")
            better = refine(term, self.problem.runs) if callable(refine) else None
            others = self.forms(term) if better is None else [better, widened(better, 0.35)]
            for other in others:
                terms = (*fit.terms[:i], other, *fit.terms[i + 1 :])
                trial = self.close.run(Fit(terms, fit.nuisance, fit.shift), 8, tolerance=1e-3)
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
            if trial.chi2 < fit.chi2 + _window_worth(fit):
                fit = trial
            for w in reversed(range(len(fit.terms[i].window_runs))):
                term = fit.terms[i]
                if len(term.window_runs) < 2:
                    break
                k = term.stride
                fewer = ActiveEffect(
                    term.effect,
                    term.values[: w * k] + term.values[(w + 1) * k :],
                    term.window_runs[:w] + term.window_runs[w + 1 :],
                )
                if self._total(self._replaced(fit, i, fewer)) > 1.5 * fit.chi2:
                    continue
                trial = self._with_term(fit, i, fewer)
                if trial.chi2 < fit.chi2 + _window_worth(fit):
                    fit = trial
        return fit

    def _with_term(self, fit: Fit, index: int, term: ActiveEffect) -> Fit:
        if term.values == fit.terms[index].values or not term.effect.windowed or not term.values:
            return fit
        return self.close.run(self._replaced(fit, index, term), 6)

    @staticmethod
    def _replaced(fit: Fit, index: int, term: ActiveEffect) -> Fit:
        terms = (*fit.terms[:index], term, *fit.terms[index + 1 :])
        return Fit(terms, fit.nuisance, fit.shift)

    def _total(self, fit: Fit) -> float:
        total = 0.0
        runs = range(len(self.problem.runs))
        trials = [Trial(r, fit.terms, fit.nuisance[r], fit.shift) for r in runs]
        for e in self.close.evaluate_all(trials):
            total += float(np.dot(e, e))
        return total

    def forms(self, term: ActiveEffect) -> list[ActiveEffect]:
        """The same windows with the other forms of the effect, from each start of what they add."""
        if not term.effect.windowed or term.effect.extra.get("final"):
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

    def extend(self, parent: Fit, *, windowed: bool = True) -> list[Candidate]:
        """Fits of the parent with one more effect, in windows too or not, weighed, best first.

        Asked again about the same parent it answers what it found before.
        """
        key = id(parent), windowed
        if key not in self._extended:
            self._extended[key] = parent, self._extensions(parent, windowed)
        return sorted(map(self.weighed, self._extended[key][1]), key=lambda c: -c.evidence)

    def _extensions(self, parent: Fit, windowed: bool) -> list[Candidate]:
        taken = {(t.effect.id, t.effect.component) for t in parent.terms}
        # a second set of windows of the same id only mends the form of the first
        in_windows = {t.effect.id for t in parent.terms if t.effect.windowed}
        open_ = [
            e for e in self.effects if (e.id, e.component) not in taken and e.id not in in_windows
        ]
        lasting = [e for e in open_ if not e.windowed]
        in_parts = [e for e in open_ if e.windowed] if windowed else []
        first = bool(in_parts) and self._hardly(parent, lasting) and not self.refuses(WINDOWED_STEP)
        fits = self._polished(parent, in_parts) if first else []
        if not self.settled(parent, fits):
            lasts = self._lasting(parent, lasting)
            if in_parts and not first and not self._enough(parent, lasts):
                fits = self._polished(parent, in_parts)
            fits = _best_of_each([*lasts, *fits])
        candidates = [Candidate(f, parent) for f in fits if np.isfinite(f.chi2)]
        self.note(candidates)
        return candidates

    def note(self, candidates: Sequence[Candidate]) -> None:
        """Candidates that were tried; the best one says how large an independent sample is."""
        finite = [c for c in candidates if np.isfinite(c.fit.chi2)]
        if finite:
            least = min(finite, key=lambda c: c.fit.chi2)
            self.noise = min(self.noise, inflation(residuals(self.judge, least.fit)))
        self.tried += candidates

    def _enough(self, parent: Fit, lasts: Sequence[Fit]) -> bool:
        """Windows need not be looked for, or may not any more."""
        return self.settled(parent, lasts) or self.refuses(WINDOWED_STEP)

    def refuses(self, what: str) -> bool:
        """Tell whether `what` is left untried because the diagnosis has simulated enough."""
        budget = self.problem.budget
        return budget.refuses(what, self._share, budget.by_library_s)

    def has_room(self, what: str) -> bool:
        """Tell whether another step of a kind ends within the budget, as far as known."""
        budget = self.problem.budget
        return budget.has_room(what, self._share, budget.by_library_s)

    @property
    def _share(self) -> float:
        """Share of the budget that the library may use: laws are to be tried, too."""
        return 1.0 if self.beyond is None else LIBRARY_SHARE

    @staticmethod
    def settled(parent: Fit, fits: Sequence[Fit]) -> bool:
        """The first of the fits leaves only noise of what the parent leaves more of."""
        if not fits or reduced_chi_square(parent) <= UNEXPLAINED_ABOVE:
            return False
        return explained(parent, fits[0]) and reduced_chi_square(fits[0]) < LINEAR

    def _hardly(self, parent: Fit, effects: Sequence[Effect]) -> bool:
        """Effects without windows take hardly anything away under the observer, from rest too."""
        if not self.releases or reduced_chi_square(parent) <= LINEAR:
            return False
        near, under = self._watched(parent, effects)
        return all(f.chi2 > HARDLY * near.chi2 for f in under)

    def _watched(self, parent: Fit, effects: Sequence[Effect]) -> tuple[Fit, list[Fit]]:
        """A parent under the observer, and there, if it is far off, effects without windows.

        Asked again about the same parent it answers what it found before.
        """
        near = self._near(parent)
        if id(parent) not in self._under:
            far = not self.releases or reduced_chi_square(parent) > LINEAR
            self._under[id(parent)] = self.constants(self.close, near, effects) if far else []
        return near, self._under[id(parent)]

    def _near(self, parent: Fit) -> Fit:
        """A parent under the observer."""
        if id(parent) not in self._parents:
            self._parents[id(parent)] = parent, self.close.run(parent, 6)
        return self._parents[id(parent)][1]

    def _lasting(self, parent: Fit, effects: Sequence[Effect]) -> list[Fit]:
        """Effects without windows, found under the observer and free of it; best first.

        Asked again about the same parent it answers what it found before.
        """
        if id(parent) not in self._found:
            under = _followed(self._watched(parent, effects)[1][:POLISHED])
            near = [*under, *self._as_believed(parent, effects)]
            fits = _best_of_each(self.judge.side_by_side(self.released, near))
            if self.releases and not self.settled(parent, fits):
                fits += self.constants(self.judge, parent, effects)
            self._found[id(parent)] = self._unbent(fits, parent, under)
        return self._found[id(parent)]

    def _as_believed(self, parent: Fit, effects: Sequence[Effect]) -> list[Fit]:
        """First effects that the vehicle as believed promises, under the observer.

        Where values within their tolerances make up for an effect down to the noise, no course from
        the calibrated vehicle shows it, and a fit from there ends where it began.
        """
        if parent.terms or not self.releases:
            return []
        rest = self.close.start()
        price = 2.0 * np.log(len(self.effects))
        found = [f for f in Linear(self.close, rest).best(effects) if f[0] > price]
        starts = [
            replace(rest, terms=(ActiveEffect(effect, values),))
            for _, values, effect in found[:POLISHED]
        ]
        near = self.close.side_by_side(lambda f: self.close.run(f, 12), starts)
        return _followed(_best_of_each(near))

    def _polished(self, parent: Fit, effects: Sequence[Effect]) -> list[Fit]:
        """Effects in windows, found under the observer and fitted where they are judged."""
        with self.problem.budget.step(WINDOWED_STEP):
            found = self._windowed(self._near(parent), effects)
            return self._unbent(self.judge.side_by_side(self.released, found), parent)

    def _unbent(self, fits: Sequence[Fit], parent: Fit, watched: Sequence[Fit] = ()) -> list[Fit]:
        """The best of each, and once more from rest where they take away much of the misfit.

        Near the critical speed what starts from a bent vehicle may not reach free simulation at
        all: the best of those `watched` by the observer start from rest too.
        """
        best = _best_of_each(fits)
        if best and best[0].chi2 < BENT * parent.chi2:
            again = _best_of_each([*_followed(best[:BEAM]), *watched])
            best = _best_of_each([*best, *self._from_rest(again)])
        return best

    def _from_rest(self, fits: Sequence[Fit]) -> list[Fit]:
        """Fits once more from the vehicle as believed.

        A parent that lacks the effect has bent the believed values to make up for it; a fit that
        starts from them may not find back.
        """
        return self.judge.side_by_side(self.released, self._close_from_rest(fits))

    def afresh(self, fit: Fit) -> Fit:
        """A fit with one effect once more from the vehicle as believed, its windows moved too."""
        near = self._close_from_rest([fit])[0]
        if fit.terms[-1].effect.windowed:
            near = self.pruned(self.completed(self.edges(near)))
        return self.released(near)

    def _close_from_rest(self, fits: Sequence[Fit]) -> list[Fit]:
        """The same as far as the observer."""
        start = self.close.start()
        again = [replace(f, shift=start.shift, nuisance=start.nuisance) for f in fits]
        return self.close.side_by_side(lambda f: self.close.run(f, 12), again)

    def without(self, fit: Fit, index: int) -> Fit:
        """The fit without one of its active effects, from the vehicle as believed."""
        start = self.close.start()
        terms = (*fit.terms[:index], *fit.terms[index + 1 :])
        near = self.close.run(Fit(terms, start.nuisance, start.shift), 15)
        return self.judge.run(self.released(near), 30, tolerance=1e-4)

    def _windowed(self, parent: Fit, effects: Sequence[Effect]) -> list[Fit]:
        """Effects in windows, under the observer, in their best forms."""
        locator = Locator(self.close, parent)
        first = [e for e in effects if e.extra.get("form", "box") in FIRST_FORMS]
        with ThreadPoolExecutor(WORKERS) as pool:
            courses = list(pool.map(locator.course, first))
        price = 2.0 * np.log(len(self.effects))
        price = max(price, self._promised(self.close, parent, windowed=True))
        courses = [c for c in courses if c.gain > price + self._by_chance(c)]
        courses.sort(key=lambda c: -c.gain)
        started = self.close.side_by_side(lambda c: self.rough(locator, c), courses[:WINDOWED_LIST])
        rough = [f for f in started if f is not None and parent.chi2 - f.chi2 > price]
        rough.sort(key=lambda f: f.chi2)
        gains = [parent.chi2 - f.chi2 for f in rough]
        rough = [f for f, gain in zip(rough, gains, strict=True) if gain > WEAK * gains[0]]
        moved = self.close.side_by_side(
            lambda f: self.completed(self.refined(self.edges(f))), rough[:BEAM]
        )
        kept = _best_of_each(moved)
        return self.close.side_by_side(lambda f: self.pruned(self.close.run(f, 10)), kept)

    @staticmethod
    def _by_chance(course: AmplitudeCourse) -> float:
        """What a course of so many pulses gains by chance."""
        return float(2 * sum(a.size for a in course.amplitude))


def _distinguished(effects: Sequence[Effect], problem: Problem) -> list[Effect]:
    """Effects without those at an axle of a trailer that has only one: it is the trailer's."""
    if problem.body[TRAILER_FRONT] > 0.0:
        return list(effects)
    whole = {e.id for e in effects if e.component == "trailer"}
    return [
        e
        for e in effects
        if e.component != "trailer_front" and not (e.component == "trailer_rear" and e.id in whole)
    ]


def _window_worth(fit: Fit) -> float:
    """Drop of chi2 that a window must be worth beside what the fit leaves."""
    return WINDOW_WORTH * max(reduced_chi_square(fit), 1.0)


def _starts(effect: Effect) -> list[tuple[float, ...]]:
    """Values whose first-order course is looked at: each start, near and far, and each alone."""
    count = max(len(p.starts) for p in effect.parameters)
    found = [
        tuple(p.starts[min(i, len(p.starts) - 1)] for p in effect.parameters) for i in range(count)
    ]
    if any(abs(p.neutral) > FAR for p in effect.parameters):
        return found
    sizes = [p for p in effect.parameters if p.minimum < 1e6]
    for p in sizes if len(sizes) > 1 else []:
        found.append(tuple(q.starts[0] if q is p else q.neutral for q in effect.parameters))
    near = [
        tuple(
            p.neutral + NEAR_NEUTRAL * (x - p.neutral) if p.minimum < 1e6 else x
            for p, x in zip(effect.parameters, values, strict=True)
        )
        for values in found
    ]
    return found + near


def form_of(effect: Effect) -> tuple[str, str]:
    """Name of an effect and of its form, which in windows is only a matter of their shape."""
    return effect.name, "" if effect.windowed else str(effect.extra.get("form", ""))


def _followed(fits: Sequence[Fit]) -> list[Fit]:
    """Of fits the ones that do not leave far more than the best of them."""
    least = min((f.chi2 for f in fits), default=0.0)
    return [f for f in fits if f.chi2 <= FOLLOWED * least]


def _best_of_each(fits: Sequence[Fit]) -> list[Fit]:
    """Of fits with the same effects the best: of one in windows in whatever form."""
    kept: dict[tuple[tuple[str, str], ...], Fit] = {}
    for fit in sorted(fits, key=lambda f: f.chi2):
        kept.setdefault(tuple(sorted(form_of(t.effect) for t in fit.terms)), fit)
    return list(kept.values())
