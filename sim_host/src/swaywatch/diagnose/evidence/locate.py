"""Where in time a windowed effect acts: pulses of a second each, then their merging."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.fit.fit import Fit, Fitter, Trial, plant_of, slope
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect, Window
from swaywatch.effects.runs import RATE_HZ
from swaywatch.plant.lanes import ALL, BLOCK, LANES, Job, Outcome, run_jobs

Array = NDArray[np.float64]

AT_ONCE = 4 * LANES  # pulses in memory at a time
PULSE_S = 1.0
HELD = 1e12  # weight of a belief that does not move
MOST_AT_ONCE = 8  # windows that a course begins with
MOST_FAINT = 4  # windows of a run whose single pulses do not stand out
LONGEST = 0.5  # of a run: what lasts longer is no window
NORMAL_QUARTER = 0.3186  # a quarter of normal numbers are smaller than so many sigmas
NEIGHBOUR = 0.6  # a pulse beside a sure one needs this share of the same evidence
UNSEEN = 0.02  # share of its pulses' own effect below which a constant level is not observable
#: Length of a window over its width at half height, by the form of what acts in it.
LONGER = {"half_sine": 1.5, "one_minus_cosine": 2.0}
FADE = 8.0  # times the observer's time constant: the pulled combination forgets by e^-4


@dataclass(frozen=True)
class AmplitudeCourse:
    """Amplitudes of an effect over time.

    Attributes
    ----------
    effect
        The windowed effect.
    edges
        Per run, shape (pulses + 1,), s.
    amplitude
        Per run, shape (pulses, parameters), distance from neutral.
    error
        Same shape, standard error.
    gain
        Drop of chi2 that the linear course promises.
    information, toward
        Per run, shapes (n, n) and (n,) with n = pulses times parameters, in scales of the
        parameters: second derivative of half of chi2 to the amplitudes with all else refitted, and
        slope of its fall where nothing acts.
    """

    effect: Effect
    edges: tuple[Array, ...]
    amplitude: tuple[Array, ...]
    error: tuple[Array, ...]
    gain: float
    information: tuple[Array, ...] = ()
    toward: tuple[Array, ...] = ()


def pulses_of(effect: Effect, run: int, edges: Array) -> list[ActiveEffect]:
    """Of each pulse between two edges, and of each value of the effect, one scale of it alone."""
    found = []
    for start, stop in pairwise(edges.tolist()):
        for j, p in enumerate(effect.parameters):
            values = [q.neutral for q in effect.parameters]
            values[j] += p.scale
            found.append(ActiveEffect(effect, (start, stop, *values), (run,)))
    return found


class Locator:
    """Linear courses of windowed effects about a fit. Caches what does not depend on the effect."""

    def __init__(self, fitter: Fitter, fit: Fit, base: Sequence[Array] | None = None) -> None:
        self.fitter = fitter
        self.fit = fit
        problem, runs = fitter.problem, range(len(fitter.problem.runs))
        trials = [Trial(r, fit.terms, fit.nuisance[r], fit.shift) for r in runs]
        self.base = fitter.evaluate_all(trials) if base is None else list(base)
        found = fitter.backgrounds(fit, runs, self.base)
        self.background = [found[r][0] for r in runs]
        self.plants = [plant_of(problem, t.run, t.terms, t.nuisance, t.shift) for t in trials]
        jobs = [Job(plant, columns=ALL, states=True) for plant in self.plants]
        self.paths = run_jobs(jobs, fine=fitter.fine)

    def _job(self, r: int, term: ActiveEffect) -> Job:
        """A run with one more active effect in windows, simulated only while it can be seen."""
        problem, path = self.fitter.problem, self.paths[r]
        run, window = problem.runs[r], term.windows(r)[0]
        n = run.time.size
        first = int((window.start - run.time[0]) * RATE_HZ) // 2 * 2 - 2
        first = min(max(first, 0), (n - 1) // 2 * 2) // BLOCK * BLOCK
        last = n
        if problem.observer > 0.0 and run.both_watched:
            fades = int((window.stop - run.time[0] + FADE / problem.observer) * RATE_HZ)
            last = min(n, max(fades, first + 2))
        assert path.states is not None
        plant = self.plants[r].copy()
        term.effect.act(plant, run, {}, [window])
        columns = self.fitter.comparison(r).wanted((*self.fit.terms, term))
        return Job(plant, (first, last), path.states[first], columns)

    def _residual(self, r: int, term: ActiveEffect, job: Job, branch: Outcome) -> Array:
        """Residuals of the run that goes along the branch, elsewhere without the active effect."""
        path, (first, last) = self.paths[r], job.span or (0, 0)
        assert path.output is not None
        blocks = path.blocks.copy()
        stop = -(-last // BLOCK)
        blocks[first // BLOCK : stop] = branch.blocks[first // BLOCK : stop]
        if last % BLOCK:
            blocks[stop - 1] += path.output[last : stop * BLOCK].sum(axis=0)
        output = None
        if branch.output is not None:
            output = path.output[:, job.columns]
            output[first:last] = branch.output[first:last]
        joined = Outcome(blocks, job.columns, output, None)
        return (
            self.fitter.comparison(r)
            .residual(joined, (*self.fit.terms, term), self.fit.shift)
            .ravel()
        )

    def columns(self, r: int, terms: Sequence[ActiveEffect]) -> list[Array]:
        """Change of the residuals of a run by each of the active effects in windows."""
        found: list[Array] = []
        for at in range(0, len(terms), AT_ONCE):
            some = terms[at : at + AT_ONCE]
            jobs = [self._job(r, term) for term in some]
            spans = [job.span or (0, 0) for job in jobs]
            self.fitter.problem.budget.spend(sum(b - a for a, b in spans) / RATE_HZ)
            branches = run_jobs(jobs, fine=self.fitter.fine)
            found += [
                slope(self._residual(r, term, job, branch), self.base[r], 1.0)
                for term, job, branch in zip(some, jobs, branches, strict=True)
            ]
        return found

    def _prior(self, size: int, pulses: int, held: bool) -> tuple[Array, Array]:
        """Weights of the beliefs, shape (size, size), and their pull to what is believed.

        `held`: the vehicle stays as it was fitted.
        """
        weight, pull = np.zeros((size, size)), np.zeros(size)
        beliefs = self.fitter.problem.beliefs
        at = slice(pulses, pulses + len(beliefs))
        weight[at, at] = HELD * np.eye(len(beliefs)) if held else beliefs.weight
        pull[at] = 0.0 if held else beliefs.pull(self.fit.shift)
        return weight, pull

    def course(
        self,
        effect: Effect,
        ridge: float = 1e-3,
        pulse_s: float | None = None,
        *,
        held: bool = False,
    ) -> AmplitudeCourse:
        """Least-squares amplitudes of pulses of one effect, as long as its module has them.

        With the vehicle `held` as it was fitted; otherwise within what is believed of it.
        """
        pulse_s = pulse_s or float(str(effect.extra.get("pulse_s", PULSE_S)))
        runs = self.fitter.problem.runs
        edges, amplitude, error, gain = [], [], [], 0.0
        information, toward = [], []
        for r, run in enumerate(runs):
            start, stop = float(run.time[0]), float(run.time[-1])
            count = max(1, round((stop - start) / pulse_s))
            edge = np.linspace(start, stop, count + 1)
            a = np.stack(self.columns(r, pulses_of(effect, r, edge)), axis=1)
            k = a.shape[1]
            full = np.hstack([a, self.background[r]])
            normal = full.T @ full
            weight, pull = self._prior(full.shape[1], k, held)
            prior = weight[k:, k:].copy()
            right = full.T @ self.base[r] + pull
            cross, nuisance = normal[k:, :k], normal[k:, k:] + prior
            nuisance += np.diag(1e-9 * np.diag(nuisance) + 1e-12)
            refitted = np.linalg.solve(nuisance, np.c_[cross, right[k:]])
            information.append(normal[:k, :k] - cross.T @ refitted[:, :-1])
            toward.append(cross.T @ refitted[:, -1] - right[:k])
            weight[range(k), range(k)] = ridge * np.mean(np.diag(normal)[:k])
            constant = _constant_level(normal, k, len(effect.parameters))
            normal += weight + np.diag(1e-9 * np.diag(normal) + 1e-12)
            normal[:k, :k] += np.mean(np.diag(normal)[:k]) * constant @ constant.T
            x = -np.linalg.solve(normal, right)
            rest = self.base[r] + full @ x
            for level in constant.T:
                if level.any():
                    x[:k] -= level * np.median(x[:k][level > 0.0])
            only = self.background[r]
            known = only.T @ only
            known += prior + np.diag(1e-9 * np.diag(known) + 1e-12)
            y = -np.linalg.solve(known, only.T @ self.base[r] + pull[k:])
            rest_only = self.base[r] + only @ y
            gain += float(np.dot(rest_only, rest_only) - np.dot(rest, rest))
            sigma = float(np.dot(rest, rest)) / rest.size
            se = np.sqrt(np.diag(np.linalg.inv(normal))[:k] * sigma)
            scales = np.tile([p.scale for p in effect.parameters], count)
            edges.append(edge)
            amplitude.append((x[:k] * scales).reshape(count, -1))
            error.append((se * scales).reshape(count, -1))
        return AmplitudeCourse(
            effect, tuple(edges), tuple(amplitude), tuple(error), gain,
            tuple(information), tuple(toward),
        )  # fmt: skip


def _constant_level(normal: Array, pulses: int, parameters: int) -> Array:
    """Directions of equal pulses that leave nothing to be seen, shape (pulses, parameters).

    A side force or a bank over the whole run goes with the offsets of the channels and the start
    values: a column is zero unless the constant level keeps less than `UNSEEN` of what as many
    single pulses show, offsets and start values refitted.
    """
    cross, nuisance = normal[pulses:, :pulses], normal[pulses:, pulses:]
    seen = normal[:pulses, :pulses] - cross.T @ np.linalg.lstsq(nuisance, cross, rcond=None)[0]
    found = np.zeros((pulses, parameters))
    for j in range(parameters):
        level = np.zeros(pulses)
        level[j::parameters] = 1.0
        if level @ seen @ level < UNSEEN * np.trace(seen * np.diag(level)):
            found[:, j] = level
    return found


def windows(
    course: AmplitudeCourse, share: float = 0.35, sigmas: float = 4.0, least: float = 0.0
) -> ActiveEffect | None:
    """Windows where the course stands out, as an active effect to start a fit from.

    Parameters
    ----------
    least
        Amplitude below which a pulse does not count.
    """
    values: list[float] = []
    runs: list[int] = []
    for r, (on, sure) in enumerate(_standing_out(course, share, sigmas, least)):
        i = 0
        while i < len(on):
            if not on[i]:
                i += 1
                continue
            j = i
            while j + 1 < len(on) and on[j + 1] and _same(course.amplitude[r], i, j + 1):
                j += 1
            if sure[i : j + 1].any():
                part = course.amplitude[r][i : j + 1]
                level = np.median(part, axis=0) if j - i > 1 else part.mean(axis=0)
                values += [
                    float(course.edges[r][i]), float(course.edges[r][j + 1]),
                    *(
                        float(p.neutral + x)
                        for p, x in zip(course.effect.parameters, level, strict=True)
                    ),
                ]  # fmt: skip
                runs.append(r)
            i = j + 1
    if not runs or len(runs) > MOST_AT_ONCE:
        return None
    return ActiveEffect(course.effect, tuple(values), tuple(runs))


def faint_windows(course: AmplitudeCourse, worth: float) -> ActiveEffect | None:
    """Windows of an effect whose single pulses do not stand out, as an active effect.

    One after the other, each where, with all before it and the vehicle refitted, it takes most of
    chi2 away to first order: several weak pulses of the same sign are found together.

    Parameters
    ----------
    course
        In pulses.
    worth
        Drop of chi2 below which a window is none.
    """
    scales = np.array([p.scale for p in course.effect.parameters])
    neutral = np.array([p.neutral for p in course.effect.parameters])
    values: list[float] = []
    runs: list[int] = []
    for r, edges in enumerate(course.edges):
        found, sizes = _one_by_one(course.information[r], course.toward[r], scales.size, worth)
        for (first, stop), size in sorted(zip(found, sizes, strict=True)):
            values += [float(edges[first]), float(edges[stop]), *(neutral + scales * size).tolist()]
            runs.append(r)
    if not runs or len(runs) > MOST_AT_ONCE:
        return None
    return ActiveEffect(course.effect, tuple(values), tuple(runs))


def _one_by_one(
    information: Array, toward: Array, parameters: int, worth: float
) -> tuple[list[tuple[int, int]], list[tuple[float, ...]]]:
    """First and last edge of windows, and their amplitudes, of a run."""
    n = toward.size // parameters
    each = information.reshape(n, parameters, n, parameters)
    own = np.zeros((n + 1, parameters, n + 1, parameters))  # sums over the first pulses
    own[1:, :, 1:] = each.cumsum(axis=0).cumsum(axis=2)
    found: list[tuple[int, int]] = []
    inside: Array = np.zeros((toward.size, 0))
    sizes: Array = np.zeros(0)
    while len(found) < MOST_FAINT:
        beside = information @ inside
        within = inside.T @ beside
        pull = _summed((toward - beside @ sizes).reshape(n, parameters))
        cross = _summed(beside.reshape(n, parameters, -1))
        best = (worth, (0, 0))
        for i in range(n):
            for j in range(i + 1, min(i + int(LONGEST * n), n) + 1):
                if any(i < stop and first < j for first, stop in found):
                    break
                square = own[j, :, j] - own[i, :, j] - own[j, :, i] + own[i, :, i]
                drop = _drop(square, pull[j] - pull[i], cross[j] - cross[i], within)
                if drop > best[0]:
                    best = drop, (i, j)
        if best[1] == (0, 0):
            break
        found.append(best[1])
        column = np.zeros((n, parameters, parameters))
        column[slice(*best[1])] = np.eye(parameters)
        inside = np.hstack([inside, column.reshape(-1, parameters)])
        sizes = np.asarray(
            np.linalg.solve(inside.T @ information @ inside, inside.T @ toward), float
        )
    return found, [tuple(row) for row in sizes.reshape(-1, parameters).tolist()]


def _summed(rows: Array) -> Array:
    """Sums over the first rows, none of them to all. Shape (n, ...) to (n + 1, ...)."""
    return np.concatenate([np.zeros((1, *rows.shape[1:])), rows.cumsum(axis=0)])


def _drop(square: Array, pull: Array, cross: Array, within: Array) -> float:
    """Drop of chi2 by one more window, the amplitudes of those before refitted."""
    own = 1e-6 * np.diag(np.diag(square))  # what those before have as well promises nothing
    try:
        if within.size:
            square = square + own - cross @ np.linalg.solve(within, cross.T)
        return float(pull @ np.linalg.solve(square, pull))
    except np.linalg.LinAlgError:
        return 0.0


def stretches(
    course: AmplitudeCourse, share: float = 0.35, sigmas: float = 4.0, least: float = 0.0
) -> list[tuple[int, float, float]]:
    """Run, begin and end in s, where the course stands out in any direction.

    Two quiet pulses do not end a stretch: an effect may pause where the motion does.
    """
    found = []
    for r, (on, sure) in enumerate(_standing_out(course, share, sigmas, least)):
        at = np.flatnonzero(on)
        for part in np.split(at, np.flatnonzero(np.diff(at) > 3) + 1):
            if part.size and sure[part].any():
                edges = course.edges[r]
                found.append((r, float(edges[part[0]]), float(edges[part[-1] + 1])))
    return found


def _standing_out(
    course: AmplitudeCourse, share: float, sigmas: float, least: float
) -> list[tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
    """Of each run the pulses that count, and those that are sure, shape (pulses,) each."""
    sizes = [np.hypot.reduce(a, axis=1) for a in course.amplitude]
    ratios = [
        size / np.hypot.reduce(e, axis=1) for size, e in zip(sizes, course.error, strict=True)
    ]
    # what a wrong explanation scatters by is more than the noise: taken from the quietest quarter
    needs = [max(sigmas, 2.0 * float(np.quantile(z, 0.25)) / NORMAL_QUARTER) for z in ratios]
    sure = [z > need for z, need in zip(ratios, needs, strict=True)]
    # pulses at a time when the effect can hardly act have wild amplitudes, and say nothing
    known = [float(size[on].max()) for size, on in zip(sizes, sure, strict=True) if on.any()]
    if not known:
        return []
    least = max(least, share * max(known))
    return [
        ((size > least) & (z > NEIGHBOUR * need), certain)
        for size, z, need, certain in zip(sizes, ratios, needs, sure, strict=True)
    ]


def joined(terms: Sequence[ActiveEffect]) -> ActiveEffect:
    """Windows of one effect as one active effect."""
    values = tuple(value for term in terms for value in term.values)
    return ActiveEffect(
        terms[0].effect, values, tuple(run for term in terms for run in term.window_runs)
    )


def widened(term: ActiveEffect, by: float) -> ActiveEffect:
    """The active effect with every window longer by `by` s at both ends."""
    values = list(term.values)
    for w in range(len(term.window_runs)):
        values[w * term.stride] -= by
        values[w * term.stride + 1] += by
    return ActiveEffect(term.effect, tuple(values), term.window_runs)


def stretched(term: ActiveEffect, factor: float) -> ActiveEffect:
    """The active effect with every window so much longer about its middle."""
    values = list(term.values)
    for w in range(len(term.window_runs)):
        start, stop = values[w * term.stride : w * term.stride + 2]
        more = 0.5 * (factor - 1.0) * (stop - start)
        values[w * term.stride : w * term.stride + 2] = [start - more, stop + more]
    return ActiveEffect(term.effect, tuple(values), term.window_runs)


def reformed(term: ActiveEffect, effect: Effect, start: int = 0) -> ActiveEffect:
    """An effect's windows in another form of it; what that form adds begins at `start`.

    Windows become as long as the form needs to have the same width at half of its height.
    """
    values: list[float] = []
    for w in range(len(term.window_runs)):
        old = term.values[w * term.stride : (w + 1) * term.stride]
        known = dict(zip((p.name for p in term.effect.parameters), old[2:], strict=True))
        new = [
            known.get(p.name, p.starts[min(start, len(p.starts) - 1)]) for p in effect.parameters
        ]
        values += [*old[:2], *new]
    longer = LONGER.get(str(effect.extra.get("form")), 1.0)
    longer /= LONGER.get(str(term.effect.extra.get("form")), 1.0)
    return stretched(ActiveEffect(effect, tuple(values), term.window_runs), longer)


def simplified(term: ActiveEffect, shortest: float = 0.6, gap: float = 0.6) -> ActiveEffect:
    """Windows of one run that nearly touch and agree become one; crumbs are dropped."""
    k = term.stride
    rows = sorted((r, *term.values[w * k : (w + 1) * k]) for w, r in enumerate(term.window_runs))
    neutral = np.array([p.neutral for p in term.effect.parameters])
    merged: list[list[float]] = []
    for row in rows:
        last = merged[-1] if merged else None
        if last is not None and last[0] == row[0] and abs(row[1] - last[2]) < gap:
            a, b = np.array(last[3:]) - neutral, np.array(row[3:]) - neutral
            if np.linalg.norm(a - b) < 0.5 * max(np.linalg.norm(a), np.linalg.norm(b)):
                la, lb = last[2] - last[1], row[2] - row[1]
                mean = neutral + (a * la + b * lb) / max(la + lb, 1e-9)
                merged[-1] = [
                    last[0],
                    min(last[1], row[1]),
                    max(last[2], row[2]),
                    *mean,
                ]
                continue
        elif last is not None and last[0] == row[0] and row[2] < last[2] - shortest:
            a, b = np.array(last[3:]) - neutral, np.array(row[3:]) - neutral
            if np.linalg.norm(a + b) < 0.3 * np.linalg.norm(a):  # a gap in the window before
                merged[-1] = [*last[:2], row[1], *last[3:]]
                merged.append([row[0], row[2], *last[2:]])
                continue
        merged.append(list(row))
    kept = [row for row in merged if row[2] - row[1] >= shortest]
    values = [float(x) for row in kept for x in row[1:]]
    return ActiveEffect(term.effect, tuple(values), tuple(int(row[0]) for row in kept))


def _same(amplitude: Array, first: int, candidate: int) -> bool:
    """Same direction as the first pulse of the window."""
    return bool(np.dot(amplitude[first], amplitude[candidate]) > 0.0)


def overlap(a: list[Window], b: list[Window]) -> float:
    """Intersection over union of two lists of windows."""
    grid = np.arange(0.0, 200.0, 0.05)
    in_a = np.zeros(grid.size, bool)
    in_b = np.zeros(grid.size, bool)
    for w in a:
        in_a |= (grid >= w.start) & (grid <= w.stop)
    for w in b:
        in_b |= (grid >= w.start) & (grid <= w.stop)
    union = np.count_nonzero(in_a | in_b)
    return float(np.count_nonzero(in_a & in_b) / union) if union else 1.0
