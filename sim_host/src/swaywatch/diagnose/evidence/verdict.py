"""From a search to a verdict: which explanations are claimed, how surely, what is equivalent."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.baselines import (
    SHORTEST_WINDOW_S,
    Path,
    each_once,
    explore,
    is_slight,
    noticeable,
    noticeable_window,
)
from swaywatch.diagnose.evidence.calibration import NINETY
from swaywatch.diagnose.evidence.calibration import noise as noise_factor
from swaywatch.diagnose.evidence.evidence import (
    APART,
    BESIDE,
    BOUND,
    CLAIMED,
    ROUGH,
    UNEXPLAINED_ABOVE,
    WINDOW_DISCREPANCY,
    explained,
    form_misfit,
    inflation,
    price_of_form,
    residuals,
)
from swaywatch.diagnose.evidence.search import BENT, Candidate, Progress, Search, reduced_chi_square
from swaywatch.diagnose.fit.fit import OBSERVER, Fit, Problem
from swaywatch.diagnose.fit.holdout import left_out, typical
from swaywatch.diagnose.fit.road_vehicle import WITHIN
from swaywatch.effects.active import ActiveEffect
from swaywatch.plant.lanes import BODY

Array = NDArray[np.float64]

#: Misfit, over that of a vehicle on springs, up to which one effect on a rigid one is enough.
ALONE = 1.1
#: Share of a value, or metres of a length, by which the form of a vehicle on springs may pull it.
FORM_PULLS = 0.04
#: Share of the misfit that right effects leave at most in our own model, and the reduced chi-square
#: up to which that counts: all right verdicts of the sets that were run leave 1.3 or less.
WHOLE, AT_MOST = 0.02, 2.0
#: Confidence in a value beyond its bound: that it is off is sure, that it is this one less so.
OUTSIDE = 0.9
#: Error of a left-out run with the effects, over that without, above which they are not claimed
#: where a calibrated vehicle leaves only noise: what acts predicts, too ...
WORSE = 1.05
#: ... unless it is smaller than this under the observer: near the critical speed a free simulation
#: with the values of other runs drifts away by chance.
BETTER = 0.98
#: What effects leave above noise, over what they take away, above which they are not claimed: more
#: is missing than was found, and some of it looks like any effect. One of two equal ones leaves 1.
LEFT_OVER = 2.0
#: The same where all of them act in windows: those go where the misfit is, whatever its cause.
#: Right ones leave up to 0.12.
LEFT_IN_WINDOWS = 0.5
#: Two axles so close together that only the sum of their forces is clear.
TANDEM = ("trailer.front_cornering_stiffness", "trailer.rear_cornering_stiffness")
FRONT_STIFFNESS = BODY.index("car.front_cornering_stiffness")
REAR_TYRES = "parameter_error:car.rear_cornering_stiffness"
#: Explanations that are listed, beside what is claimed.
SHOWN = 8
#: Most that is ever stated: the library is not the world.
SUREST = 0.99
#: Pairs that are the same in every planar signal.
TWINS = (
    ("steering_compliance:car_front", "parameter_error:car.front_cornering_stiffness"),
    ("sensor_gain:steering_wheel_angle", "parameter_error:car.steering_ratio"),
    # a stiffness that differs all the time is a value of the file or what has become of the tyre
    *(
        (f"parameter_error:{body}.{end}_cornering_stiffness", f"tyre_stiffness_change:{body}_{end}")
        for body in ("car", "trailer")
        for end in ("front", "rear")
    ),
)


@dataclass
class Verdict:
    """What is claimed.

    Attributes
    ----------
    word
        One of the five verdicts.
    fit, baseline
        The model with and without the claimed effects, both calibrated.
    problem
        With the beliefs under which it was found.
    equivalents
        For each claimed active effect the names of effects that do as well.
    confidence
        For each claimed active effect.
    candidates
        Ranked alternatives: names, logarithm of the Bayes factor to the calibrated vehicle.
    noise
        Size of an independent sample of the residuals, see `evidence.inflation`.
    evidence
        Logarithm of the Bayes factor of the claim to the calibrated vehicle.
    hidden
        Where nothing is claimed: sizes up to which effects could be there unseen.
    slight
        Where nothing is claimed: what explains more than nothing does but is too small for a claim.
    notes
        What no effect explains, for `unexplained`.
    remarks
        Other explanations that leave as little, for `checks`.
    near
        Laws that come nearest where none is claimed, for `unexplained` too.
    paths
        What was tried, from each baseline.
    written
        The vehicle of the file as it is written; None where it runs away, or not simulated yet.
    stretched
        The calibrated vehicle leaves only noise without the claim, with values beyond their bounds.
    """

    word: str
    fit: Fit
    baseline: Fit
    problem: Problem
    equivalents: list[list[str]] = field(default_factory=list)
    confidence: list[float] = field(default_factory=list)
    candidates: list[tuple[str, float]] = field(default_factory=list)
    noise: float = 1.0
    evidence: float = 0.0
    hidden: list[dict[str, Any]] = field(default_factory=list)
    slight: Candidate | None = None
    notes: list[dict[str, Any]] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    near: list[dict[str, Any]] = field(default_factory=list)
    paths: Sequence[Path] = ()
    written: Fit | None = None
    stretched: bool = False

    @property
    def before(self) -> Fit:
        """What the claim is compared with.

        The calibrated vehicle where the claim goes beyond it; where calibration itself is the
        claim, or does the same with values that nobody would believe, or nothing is claimed, the
        vehicle as written.
        """
        calibrated = self.evidence > 0.0 and not self.stretched
        return self.baseline if self.written is None or calibrated else self.written


def _hidden(tried: Sequence[Candidate], noise: float) -> list[dict[str, Any]]:
    """Largest size of each effect without windows that this recording cannot tell from none."""
    found = []
    for candidate in tried:
        if len(candidate.fit.terms) != 1 or candidate.fit.terms[0].effect.windowed:
            continue
        term, covariance = candidate.fit.terms[0], candidate.fit.covariance
        p = term.effect.parameters[0]
        error = math.sqrt(abs(float(covariance[0, 0])) * noise)
        found.append(
            {"id": term.effect.id, "component": term.effect.component, "parameter": p.name,
             "neutral": p.neutral, "up_to": abs(term.values[0] - p.neutral) + 3.0 * error}
        )  # fmt: skip
    return sorted(found, key=lambda row: (row["id"], row["component"]))


def _label(fit: Fit) -> str:
    return " + ".join(t.effect.name for t in fit.terms) or "calibrated vehicle"


def _said_from(search: Search, tolerance: float) -> float:
    """Tolerances beyond its bound from which a value of the file is called wrong.

    A rigid vehicle's form is exact; that of one on springs is not, and pulls its values: on clean
    vehicles of another simulator by 1 % mostly, and at most by `FORM_PULLS`.
    """
    return FORM_PULLS / tolerance if search.on_springs else 0.1


def _beyond(search: Search, fit: Fit) -> Fit:
    """Values of the file that lie beyond their bound, as active effects; the model is unchanged.

    A softer front axle and an elastic steering are the same in every planar signal; vehicles have
    the second, unless the rear axle is softer than believed as well.
    """
    if not fit.shift_covariance.size:
        return fit
    taken = {t.effect.name for t in fit.terms}
    rear = search.problem.beliefs.at.get(("vehicle", "car.rear_cornering_stiffness"))
    alike = rear is not None and bool(fit.shift[rear] < -BOUND)
    shift = fit.shift.copy()
    terms: list[ActiveEffect] = []
    joint = _Joint(fit)
    counteract = _counteract(search, fit)
    for index, belief in enumerate(search.problem.beliefs.items):
        if counteract and belief.name in TANDEM:
            continue
        z = float(fit.shift[index])
        error = math.sqrt(abs(float(fit.shift_covariance[index, index])) * search.noise)
        if not belief.scaled or abs(z) - BOUND < max(
            2.0 * error, _said_from(search, belief.tolerance)
        ):
            continue
        found = _as_term(search, belief.name, 1.0 + z * belief.tolerance, alike)
        if found is None or found[0].effect.name in taken:
            continue
        terms.append(found[0])
        # the value's own error within its tolerance cannot be distinguished from another effect
        own = found[0].effect.id != "parameter_error"
        left = float(search.problem.beliefs.spread[index]) ** 2 if own else 0.0
        joint.said_as_term(index, belief.tolerance * found[1], left)
        shift[index] = 0.0
    if not terms:
        return fit
    return joint.fit(replace(fit, terms=(*fit.terms, *terms), shift=shift), len(terms))


def _bent(search: Search, fit: Fit) -> bool:
    """More than noise is left, and values of the file have bent to make up for what is missing.

    What the form of a right effect leaves, however strong the effect, does not bend the vehicle.
    Beside the user's own simulation our plant is a correction, and always leaves something.
    """
    more = reduced_chi_square(fit) > UNEXPLAINED_ABOVE
    return search.problem.free_start and more and _values_beyond(search, fit)


def _wrong_values(search: Search, fit: Fit) -> Fit:
    """The fit with values of the file beyond their bounds as active effects, where they stand."""
    return fit if _bent(search, fit) else _beyond(search, fit)


def _counteract(search: Search, fit: Fit) -> bool:
    """One axle of a tandem is off to one side by about what the other is off to the other side.

    Tyres of a tandem are alike, and what differs between its axles acts through the short distance
    between them: a small error of a model's form looks like a large difference there.
    """
    at = search.problem.beliefs.at
    both = [float(fit.shift[at["vehicle", n]]) for n in TANDEM if ("vehicle", n) in at]
    if len(both) < len(TANDEM):
        return False
    low, high = sorted(both)
    return low < 0.0 < high and 0.5 < -low / high < 2.0


class _Joint:
    """Covariance of a fit's values and shifts, in which shifts become active effects."""

    def __init__(self, fit: Fit) -> None:
        self.values, shifts = sum(len(t.values) for t in fit.terms), fit.shift.size
        self.matrix = np.zeros((self.values + shifts, self.values + shifts))
        self.matrix[self.values :, self.values :] = fit.shift_covariance
        if fit.covariance.shape[0] == self.values:
            self.matrix[: self.values, : self.values] = fit.covariance
        if fit.cross.shape == (self.values, shifts):
            self.matrix[: self.values, self.values :] = fit.cross
            self.matrix[self.values :, : self.values] = fit.cross.T

    def said_as_term(self, index: int, slope: float, left: float) -> None:
        """Tell a shift as a value of its own, last of all.

        The value is `slope` times the shift less what is left of it, of variance `left`: both
        together are known as well as the shift was.
        """
        at, size = self.values + index, self.matrix.shape[0]
        turn = np.zeros((size + 1, size + 1))
        turn[:size, :size] = np.eye(size)
        turn[at, :] = 0.0
        turn[at, size] = 1.0
        turn[size, at], turn[size, size] = slope, -slope
        wide = np.zeros((size + 1, size + 1))
        wide[:size, :size] = self.matrix
        wide[size, size] = left
        self.matrix = turn @ wide @ turn.T

    def fit(self, fit: Fit, more: int) -> Fit:
        """A fit with so many more values than before, and its covariances."""
        size = self.matrix.shape[0]
        values = [*range(self.values), *range(size - more, size)]
        shifts = list(range(self.values, size - more))
        return replace(
            fit, covariance=self.matrix[np.ix_(values, values)],
            cross=self.matrix[np.ix_(values, shifts)],
            shift_covariance=self.matrix[np.ix_(shifts, shifts)],
        )  # fmt: skip


def _as_term(
    search: Search, name: str, factor: float, alike: bool
) -> tuple[ActiveEffect, float] | None:
    """The effect that a factor on a value of the file is, and the derivative of its own value.

    `alike`: the rear axle is softer than believed too, so that the tyres are what is wrong.
    """
    if factor < 1.0 and name == "car.front_cornering_stiffness" and not alike:
        effect = next((e for e in search.effects if e.id == "steering_compliance"), None)
        if effect is not None:
            front = float(search.problem.body[FRONT_STIFFNESS])
            return ActiveEffect(effect, ((1.0 / factor - 1.0) / front,)), -1.0 / (factor**2 * front)
    same = (e for e in search.effects if e.id == "parameter_error" and e.component == name)
    effect = next(same, None)
    # a shift of the centre of gravity is none of the library's words
    return (
        None
        if effect is None or name.endswith("_to_cog")
        else (ActiveEffect(effect, (factor,)), 1.0)
    )


def _shown(
    every: Sequence[Candidate], claimed: Candidate, plain: Candidate
) -> list[tuple[str, float]]:
    """The likeliest of all that was tried, best first, and what is claimed wherever it stands."""
    kept = [
        c for place, c in enumerate(each_once(every)) if place < SHOWN or c.names == claimed.names
    ]
    return [(_label(c.fit), c.evidence - plain.evidence) for c in kept]


def decide(planar: Sequence[Search], springs: Search | None, progress: Progress) -> Verdict:
    """Search from each baseline (see `baselines.explore`) and choose."""
    paths = explore(planar, springs, progress)
    progress("judging", 0.92)
    return replace(_verdict(paths), paths=paths)


def _alone(paths: Sequence[Path], chosen: Path) -> Path | None:
    """The rigid vehicle with one effect that every road vehicle has, where that one is enough.

    A vehicle on springs has all of them within its beliefs and explains the recording too; but who
    knows a rigid one wants to hear which one it lacks.
    """
    if chosen.best.fit.terms:
        return None
    for path in paths:
        if path is chosen:
            continue
        ones = [c for c in path.search.tried if len(c.fit.terms) == 1]
        ones = [c for c in ones if _of_the_road(c.fit.terms[0])]
        best = min(ones, key=lambda c: c.fit.chi2, default=None)
        if best is None or best.fit.chi2 > ALONE * chosen.base.fit.chi2:
            continue
        if best.fit.chi2 < BENT * path.base.fit.chi2 and explained(path.base.fit, best.fit):
            return replace(path, best=best)
    return None


def _of_the_road(term: ActiveEffect) -> bool:
    """A noticeable effect that every road vehicle has."""
    return term.effect.id in WITHIN and noticeable(term)


def _without_slight_windows(search: Search, fit: Fit) -> Fit:
    """The fit without windows in which nothing worth a claim happens."""
    for index in range(len(fit.terms)):
        for window in reversed(range(len(fit.terms[index].window_runs))):
            fit = _without_window(search, fit, index, window)
    return fit


def _without_window(search: Search, fit: Fit, index: int, window: int) -> Fit:
    """The fit without a window that is too short, or too weak and takes away hardly any misfit.

    A short one beside a long one corrects its shape, however much of the misfit it takes away.
    """
    term = fit.terms[index]
    kept = [w for w in range(len(term.window_runs)) if w != window]
    if not kept or noticeable_window(term, window):
        return fit
    terms = (*fit.terms[:index], term.only(kept), *fit.terms[index + 1 :])
    fewer = search.judge.run(replace(fit, terms=terms), 4, tolerance=1e-4)
    start, stop = term.values[window * term.stride : window * term.stride + 2]
    short = stop - start < SHORTEST_WINDOW_S
    return fewer if short or fewer.chi2 < (1.0 + WINDOW_DISCREPANCY) * fit.chi2 else fit


def _to_the_end(search: Search, base: Fit, best: Candidate, least: float) -> Candidate:
    """What is claimed, fitted to the very end (weak effects sit in flat valleys), without the rest.

    Its evidence stays that of the search unless an effect was left out. One that is not clear stays
    where a clear one is not worth a claim (`least` evidence) without it.
    """
    exact = search.judge.run(best.fit, 20, tolerance=1e-7)
    exact = _without_slight_windows(search, exact)
    kept = replace(best, fit=_clear_ones(search, base, exact))
    if len(kept.fit.terms) == len(best.fit.terms):
        return kept
    kept = search.weighed(kept)
    clear = {t.effect.name for i, t in enumerate(exact.terms) if _clear(exact, i, search.noise)}
    lost = clear and (kept.evidence < least or not clear <= set(kept.names))
    return replace(best, fit=exact) if lost else kept


def _clear_ones(search: Search, base: Fit, fit: Fit) -> Fit:
    """The fit without effects whose own interval reaches where they would not be worth a claim.

    Such an effect lies in a valley in which the vehicle, or another effect, does nearly the same.
    One is kept without which more than noise would be left, or, where more is left with it too,
    twice as much of that (at a bound an interval says little: a damper of which nothing is left);
    or a vehicle with values that nobody would believe: that is an explanation, too, and it is the
    less likely one.
    """
    while True:
        unclear = [i for i in range(len(fit.terms)) if not _clear(fit, i, search.noise)]
        if not unclear:
            return fit
        alone = len(fit.terms) == 1
        rest = base if alone else min((search.without(fit, i) for i in unclear), key=_chi2)
        if explained(base, fit) and not explained(base, rest):
            return fit
        if reduced_chi_square(fit) > UNEXPLAINED_ABOVE and _excess(rest) > 2.0 * _excess(fit):
            return fit
        if _values_beyond(search, rest) and not _values_beyond(search, fit):
            return fit
        fit = rest if alone else search.judge.run(rest, 20, tolerance=1e-7)


def _chi2(fit: Fit) -> float:
    return fit.chi2


def _excess(fit: Fit) -> float:
    """What is left beyond noise."""
    return fit.chi2 - fit.count


def _clear(fit: Fit, index: int, noise: float) -> bool:
    """Tell whether some size of an effect is worth a claim at the near end of its interval, too."""
    first = sum(len(t.values) for t in fit.terms[:index])
    term = fit.terms[index]
    sizes = [
        j
        for j in range(len(term.values))
        if not term.is_edge(j) and term.parameter(j).minimum > 0.0 and not term.parameter(j).shapes
    ]
    for j in sizes:
        p = term.parameter(j)
        error = math.sqrt(abs(float(fit.covariance[first + j, first + j])) * noise)
        if abs(term.values[j] - p.neutral) - p.minimum > NINETY * noise_factor() * error:
            return True
    return not sizes


def _verdict(paths: Sequence[Path]) -> Verdict:
    chosen = max(paths, key=lambda p: p.search.weighed(p.best).evidence)
    alone = _alone(paths, chosen)
    if alone is not None:
        chosen, paths = alone, [alone]
    plain = max((p.search.weighed(p.base) for p in paths), key=lambda c: c.evidence)
    search, noise = chosen.search, chosen.search.noise
    best = search.weighed(chosen.best)
    every = sorted((c for p in paths for c in p.all), key=lambda c: -c.evidence)
    base = search.weighed(chosen.base).fit
    least = plain.evidence + CLAIMED
    if best.fit.terms and best.evidence >= least:
        best = _to_the_end(search, base, best, least)
        doubtful = predicts_worse(search, base, best.fit) or _leaves_most(search, base, best.fit)
        doubtful = doubtful or any(t.effect.windowed and not noticeable(t) for t in best.fit.terms)
        best = Candidate(base, base) if doubtful else best
    if not best.fit.terms or best.evidence < least:
        best, base = plain, plain.fit
        search = max(paths, key=lambda p: p.search.weighed(p.base).evidence).search
    found = _wrong_values(search, best.fit)
    if not found.terms:
        result = Verdict(
            "consistent", plain.fit, plain.fit, search.problem,
            candidates=_shown(every, plain, plain), hidden=_hidden(every, noise),
            noise=inflation(residuals(search.judge, plain.fit)),
            slight=next((c for c in every if is_slight(c) and c.evidence > least), None),
        )  # fmt: skip
        if reduced_chi_square(plain.fit) > UNEXPLAINED_ABOVE:
            result.word = "unexplained"
        return result
    terms = sorted(found.terms, key=lambda t: -_loss(search, found, t))
    fit = _ordered(found, terms)
    same = possible_of(best, every)
    behind, apart = _behind(search, base, same, best, noise)
    equals = [c for c, less in zip(same, behind, strict=True) if less > -apart]
    equivalents = [equivalents_of(term, terms, equals) for term in terms]
    behind *= APART / apart
    weights = np.exp(np.clip(behind, -700.0, 50.0))
    confidence = []
    for term in terms:
        has = np.array([term.effect.name in c.names for c in same])
        share = float(np.sum(weights * has) / np.sum(weights))
        if term.effect.name not in best.names:  # a value beyond its bound, found without a search
            share = OUTSIDE
        confidence.append(round(min(share, SUREST), 3))
    kinds = {t.effect.kind for t in terms}
    word = {"physics": "missing_physics", "measurement": "measurement_fault"}.get(
        terms[0].effect.kind, "parameter_error"
    )
    if "physics" in kinds:
        word = "missing_physics"
    result = Verdict(
        word, fit, base, search.problem, equivalents, confidence, _shown(every, best, plain), noise,
        max(best.evidence - plain.evidence, 0.0),
        stretched=_stretched(search, base),
    )  # fmt: skip
    # beside the user's own simulation our plant is a correction, and what it leaves is said beside
    # the claim
    if search.problem.free_start and (not _whole(base, fit) or _bent(search, fit)):
        result.word = "unexplained"
    return result


def _whole(base: Fit, fit: Fit) -> bool:
    """Whether hardly more than noise is left, as with right effects, however strong they are.

    A search may stop at more (`explained`), which a wrong effect can leave as well.
    """
    before, after = reduced_chi_square(base), reduced_chi_square(fit)
    return after <= max(UNEXPLAINED_ABOVE, min(1.0 + WHOLE * (before - 1.0), AT_MOST))


def _stretched(search: Search, base: Fit) -> bool:
    """The calibrated vehicle is itself another explanation: wrong values that leave only noise."""
    return reduced_chi_square(base) <= UNEXPLAINED_ABOVE and _values_beyond(search, base)


def _values_beyond(search: Search, fit: Fit) -> bool:
    """Some values of the file are beyond their bounds in a calibrated vehicle."""
    return len(_beyond(search, fit).terms) > len(fit.terms)


def predicts_worse(search: Search, base: Fit, fit: Fit) -> bool:
    """The calibrated vehicle leaves only noise, and predicts left-out runs better without effects.

    Not asked of effects in windows, which say nothing about another run, nor where the calibrated
    vehicle has values that nobody would believe.
    """
    problem = search.problem
    stands = reduced_chi_square(base) <= UNEXPLAINED_ABOVE and not _stretched(search, base)
    if not stands or len(problem.runs) < 2 or any(t.effect.windowed for t in fit.terms):
        return False
    watched = replace(problem, observer=OBSERVER)
    return _error_ratio(problem, base, fit) > WORSE and _error_ratio(watched, base, fit) > BETTER


def _error_ratio(problem: Problem, base: Fit, fit: Fit) -> float:
    """Error of the left-out runs with effects over that without."""
    without, with_effects = typical(
        list(zip(left_out(problem, base), left_out(problem, fit), strict=True))
    )
    return with_effects / without


def _leaves_most(search: Search, base: Fit, fit: Fit) -> bool:
    """What is left unexplained is far more than what the effects explain.

    Or, of effects in windows alone, half as much, or more than the form of a right one leaves. Not
    asked beside the user's own simulation, where our plant is a correction.
    """
    if not search.problem.free_start or explained(base, fit):
        return False
    windowed = all(t.effect.windowed for t in fit.terms)
    if windowed and reduced_chi_square(fit) > ROUGH:
        return True
    most = LEFT_IN_WINDOWS if windowed else LEFT_OVER
    return fit.chi2 - fit.count > most * (base.chi2 - fit.chi2)


def possible_of(best: Candidate, every: Sequence[Candidate]) -> list[Candidate]:
    """The claim and what could be claimed in its place, each set of effects once.

    Of the same effects a likelier fit may have ended with a value at its bound: it says nothing.
    """
    return each_once([best, *(c for c in every if all(noticeable(t) for t in c.fit.terms))])


def _behind(
    search: Search, base: Fit, candidates: Sequence[Candidate], best: Candidate, noise: float
) -> tuple[Array, float]:
    """By how much each candidate's evidence exceeds the claim's, and what of it says nothing.

    Beside the user's own simulation our plant is a correction, whose form is not exact.
    """
    behind = np.array([c.evidence - best.evidence for c in candidates])
    if search.problem.free_start:
        return behind, APART
    prices = [price_of_form(base, c.fit, noise) for c in candidates]
    behind += price_of_form(base, best.fit, noise) - np.array(prices)
    return behind, max(APART, BESIDE[0] * 0.5 * form_misfit(base, best.fit) / noise)


def equivalents_of(
    term: ActiveEffect, terms: Sequence[ActiveEffect], equals: Sequence[Candidate]
) -> list[str]:
    """Names that could stand in an active effect's place."""
    rest = {t.effect.name for t in terms if t is not term}
    names: set[str] = set()
    for candidate in equals:
        theirs = set(candidate.names)
        if rest <= theirs and term.effect.name not in theirs:
            names |= theirs - rest
    for twin in TWINS:
        if term.effect.name in twin:
            other = twin[1 - twin.index(term.effect.name)]
            if _possible_twin(term, other, terms):
                names.add(other)
    return sorted(names)


def _possible_twin(term: ActiveEffect, other: str, terms: Sequence[ActiveEffect]) -> bool:
    """Compliance can only soften the front axle; a change in windows is no value of the file.

    Where the rear tyres are stiffer than believed the front ones may be as well, and the front
    axle soft against them.
    """
    if term.effect.windowed:
        return False
    if other.startswith("steering_compliance"):
        rear = [t.values[0] for t in terms if t.effect.name == REAR_TYRES]
        return term.values[0] < max([1.0, *rear])
    return True


def _loss(search: Search, fit: Fit, term: ActiveEffect) -> float:
    """Rise of chi2 when an active effect is taken out and nothing refitted."""
    rest = tuple(t for t in fit.terms if t is not term)
    total = 0.0
    for r in range(len(search.problem.runs)):
        e = search.judge.evaluate(r, rest, fit.nuisance[r], fit.shift)
        total += float(np.dot(e, e))
    return total


def _ordered(fit: Fit, terms: Sequence[ActiveEffect]) -> Fit:
    """The fit with its active effects, and their covariance, in another order."""
    covariance, cross = fit.covariance, fit.cross
    sizes = [len(t.values) for t in fit.terms]
    if covariance.shape[0] == sum(sizes):
        starts = [sum(sizes[:i]) for i in range(len(sizes))]
        place = {id(t): i for i, t in enumerate(fit.terms)}
        order = [starts[place[id(t)]] + j for t in terms for j in range(len(t.values))]
        covariance, cross = covariance[np.ix_(order, order)], cross[order]
    return replace(fit, terms=tuple(terms), covariance=covariance, cross=cross)
