"""Which law: laws against the library, in free simulation, by evidence and by the run left out.

A law is tried beside nothing and beside what the library found, from each baseline. All weigh alike
(`diagnose/evidence/evidence.py`), with the price of having been chosen among all laws and effects;
a law is claimed only where it is 150 times likelier than the best that the library can say, takes
away more than models of this depth leave anyway, and predicts each run from the others better than
that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.baselines import Path, noticeable
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
from swaywatch.diagnose.fit.fit import Background, Fit
from swaywatch.diagnose.fit.holdout import BETTER, left_out, typical
from swaywatch.discover.grammar import (
    BENT_ONLY,
    BODIES,
    FREQUENCIES_HZ,
    ID,
    SHAPES,
    Law,
    bendable,
    effect_of,
    grammar,
    refined,
)
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect
from swaywatch.plant.lanes import BODY

Array = NDArray[np.float64]

SHORT_LIST = 12  # laws that are fitted under the observer
BEGUN = 3  # steps of the fits of all shapes; the best of them are fitted on
MOST_OPEN = 40  # laws that are begun in another search than the quickest one
POLISHED = 2  # of them in free simulation, beside each parent, ...
MOST_POLISHED = 4  # ... and of all
NEAR = 1.15  # misfit under the observer, over the least, up to which a law is followed
#: Logarithm of the odds from which a law is said: clean vehicles of another simulator, whose
#: springs and struts are not ours, gave laws of up to 55. A pneumatic trail every tyre has.
FORM = 75.0
SWING_HZ = (0.6, 0.8, 1.0, 1.4)  # where a swinging mass is looked for in the vehicle as believed
SWING_SHARE = 0.07  # of the body's mass or inertia, to begin with
#: What swings there: sideways, free in the middle too, and about the vertical.
SWINGING = tuple(
    Law(body, *kind) for kind in (("swing",), ("turn",), ("swing", "dead zone")) for body in BODIES
)
#: Library effects that may be one law: any, where laws are quickly tried; on springs several.
SEVERAL = {False: 1, True: 2}
#: Share of the misfit that is left by which a law has to lower it beside library effects.
BESIDE_KNOWN = 0.03


@dataclass(frozen=True)
class Discovery:
    """A law that is claimed.

    Attributes
    ----------
    search
        Where it was found; its noise is that of the best model.
    base, library, fit
        Calibrated vehicle, the best that the library says from any baseline, and with the law.
    evidence
        Logarithm of the Bayes factor to the best that the library says.
    others
        Laws that do as well, within a Bayes factor of 20: names and their logarithm.
    kept_out
        Error (NRMSE) of each run predicted from the others: vehicle, library, law; empty with one
        run. What is said of several is `typical`.
    """

    search: Search
    base: Fit
    library: Fit
    fit: Fit
    evidence: float
    others: list[tuple[Law, float]]
    kept_out: list[tuple[float, float, float]]

    @cached_property
    def index(self) -> int:
        """Place of the law among the terms."""
        return next(i for i, t in enumerate(self.fit.terms) if t.effect.id == ID)

    @property
    def term(self) -> ActiveEffect:
        """The law with its values."""
        return self.fit.terms[self.index]

    @property
    def law(self) -> Law:
        """What it is."""
        return law_in(self.term)


def law_in(term: ActiveEffect) -> Law:
    """The law of a term of one."""
    law = term.effect.extra["law"]
    assert isinstance(law, Law)
    return law


def _promising(course: Linear) -> list[ActiveEffect]:
    """The straight laws, and swinging masses, that promise most in the linear answer."""
    best: dict[tuple[str, int], tuple[float, tuple[float, ...], Effect]] = {}
    # a frequency is not to be extrapolated: each start keeps its own
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


def _bent(straight: ActiveEffect) -> list[ActiveEffect]:
    """A straight law in other shapes, as fits begin with them."""
    law = law_in(straight)
    if law.swings:  # free within a gap: the swing's own values, and a gap to begin with
        more = [effect_of(other, straight.as_dict()["frequency_hz"]) for other in refined(law)]
        return [ActiveEffect(e, (*straight.values, e.parameters[-1].starts[0])) for e in more]
    against = straight.values[0] < 0.0
    return [_begun(law)[against] for law in refined(law_in(straight))]


def _begun(law: Law) -> tuple[ActiveEffect, ...]:
    """A law with the values that a fit begins with, with a positive gain and a negative one."""
    effect = effect_of(law)
    gain, *rest = (p.starts[0] for p in effect.parameters)
    if effect.parameters[0].high == 0.0:  # only one sense is possible
        return (ActiveEffect(effect, (gain, *rest)),)
    return ActiveEffect(effect, (gain, *rest)), ActiveEffect(effect, (-gain, *rest))


def _band(effect: Effect) -> int:
    """Where on the scale of frequencies the fit of a swinging mass begins."""
    at = effect.extra["start_hz"]
    return next((i for i, row in enumerate(FREQUENCIES_HZ) if at in row), 0)


@dataclass
class Hunt:
    """Laws tried on one path of the diagnosis."""

    path: Path
    tried: list[Candidate] = field(default_factory=list)
    alone: bool = False  # laws were tried beside nothing
    open: Sequence[Law] = field(default_factory=bendable)  # begun from the vehicle as believed
    ranked: list[Law] = field(default_factory=list)  # of those, the best first

    @property
    def search(self) -> Search:
        """Of the path."""
        return self.path.search

    @property
    def _plain(self) -> bool:
        """The library leaves only noise, and needs nothing that may be a law."""
        return _plain(self.path)

    def weighed(self, candidate: Candidate) -> Candidate:
        """With its evidence: a law was chosen among all laws too, and its shape among shapes."""
        found = self.search.weighed(candidate)
        laws = [law_in(t) for t in found.fit.terms if t.effect.id == ID]
        bent = sum(law.shape != SHAPES[0] for law in laws)
        price = len(laws) * math.log(len(grammar())) + bent * math.log(len(SHAPES))
        return replace(found, evidence=found.evidence - price)

    def beside(self, parent: Fit) -> list[Candidate]:
        """The most promising laws beside what a parent has, under the observer."""
        close = self.search.close
        near = close.run(parent, 6)
        course = Linear(close, near)
        terms = _promising(course)
        starts = [replace(near, terms=(*near.terms, term)) for term in terms]
        fits = close.side_by_side(lambda f: close.run(f, 6, frozen=course.background), starts)
        if not self._plain:
            fits = [*fits, *self._in_other_shapes(near, fits, course.background)]
        least = (1.0 - BESIDE_KNOWN * bool(parent.terms)) * near.chi2
        least -= 2.0 * (CLAIMED + math.log(len(grammar()))) * self.search.noise
        found = [Candidate(f, parent) for f in fits if f.chi2 < least]
        return found if parent.terms else [*found, *self._swinging(parent, least)]

    def _in_other_shapes(
        self, near: Fit, straight: Sequence[Fit], background: Background
    ) -> list[Fit]:
        """The straight laws in other shapes: a stop or a cube is hardly a straight line.

        Only where the library is not plain. Beside nothing every open law, in both
        senses, also from the vehicle as believed: the calibrated one is bent to make up for the
        law, and what a small one would do says little of one that holds the swing. A shape has to
        do clearly better than the straight line.
        """
        close = self.search.close
        terms = [bent for fit in straight for bent in _bent(fit.terms[-1])]
        terms += [term for law in BENT_ONLY for term in _begun(law)]
        starts = [replace(near, terms=(*near.terms, term)) for term in terms]
        begun = close.side_by_side(lambda f: close.run(f, BEGUN, frozen=background), starts)
        begun = _best_of_each_law(begun)[:SHORT_LIST]
        if not near.terms:
            believed = close.start()
            starts = [replace(believed, terms=(t,)) for law in self.open for t in _begun(law)]
            rest = Linear(close, believed).background
            far = close.side_by_side(lambda f: close.run(f, BEGUN, frozen=rest), starts)
            far = _best_of_each_law(far)
            self.ranked = [law_in(f.terms[-1]) for f in far]
            # a vehicle that is not bent yet leaves more: the best of each start go on
            begun = _best_of_each_law([*begun, *far[:SHORT_LIST]])
        found = close.side_by_side(lambda f: close.run(f, 10), begun)
        lines: dict[str, float] = {}
        for fit in (*straight, *found):
            term = fit.terms[-1]
            if law_in(term).shape == SHAPES[0]:
                name = term.effect.component
                lines[name] = min(lines.get(name, fit.chi2), fit.chi2)
        return [f for f in found if self._bends(f, lines)]

    def _bends(self, fit: Fit, lines: Mapping[str, float]) -> bool:
        """A straight line, or clearly better than the same law as one."""
        term = fit.terms[-1]
        line = lines.get(term.effect.component, math.inf)
        if law_in(term).shape == SHAPES[0] or not math.isfinite(line):
            return True
        return fit.chi2 < line - max(2.0 * CLAIMED * self.search.noise, DISCREPANCY * line)

    def _swinging(self, parent: Fit, least: float) -> list[Candidate]:
        """Swinging masses in the vehicle as believed, where the library is not plain.

        Near the frequency of the sway such a mass changes the whole motion; a vehicle bent to make
        up for it is too far from the true one for the mass to be found beside it.
        """
        if self._plain:
            return []
        close = self.search.close
        start = close.start()
        starts = [
            replace(
                start, terms=(ActiveEffect(e, self._at_start(e, SWING_SHARE * self._whole(law))),)
            )
            for law in SWINGING
            for e in (effect_of(law, hz) for hz in SWING_HZ)
        ]
        fits = close.side_by_side(lambda f: close.run(f, 10), starts)
        return [Candidate(f, parent) for f in fits if f.chi2 < least]

    def _whole(self, law: Law) -> float:
        """Mass, or yaw inertia, of the body that something swings in."""
        of = "yaw_inertia" if law.motion == "turn" else "mass"
        return float(self.search.close.problem.body[BODY.index(f"{law.place}.{of}")])

    @staticmethod
    def _at_start(effect: Effect, mass_kg: float) -> tuple[float, ...]:
        """Values of a swinging mass of a size."""
        return (mass_kg, *(p.starts[0] for p in effect.parameters[1:]))

    def polish(self, candidates: Sequence[Candidate]) -> None:
        """Fits in free simulation, from the parent's values or from the vehicle as believed.

        A parent that lacks the law has bent the believed values to make up for it.
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
        """The size of an independent sample is what the best model leaves."""
        if candidates:
            least = min(candidates, key=lambda c: c.fit.chi2)
            noise = inflation(residuals(self.search.judge, least.fit))
            self.search.noise = min(self.search.noise, noise)

    def shaped(self, candidate: Candidate) -> Candidate:
        """With its law in another shape, or behind a lag, where that does clearly better."""
        fit = candidate.fit
        term = fit.terms[-1]
        starts = []
        for law in refined(law_in(term)):
            effect = effect_of(law)
            known = dict(zip((p.name for p in term.effect.parameters), term.values, strict=True))
            same = law.shape == law_in(term).shape
            values = tuple(
                known[p.name] if p.name in known and (same or p.name != "gain")
                else math.copysign(p.starts[0], term.values[0] if p.name == "gain" else 1.0)
                for p in effect.parameters
            )  # fmt: skip
            starts.append(replace(fit, terms=(*fit.terms[:-1], ActiveEffect(effect, values))))
        judge = self.search.judge
        near = judge.side_by_side(lambda f: judge.run(f, 8), starts)
        best = min(near, key=lambda f: f.chi2, default=fit)
        least = max(2.0 * CLAIMED * self.search.noise, DISCREPANCY * fit.chi2)
        if not best.chi2 < fit.chi2 - least:
            return candidate
        found = Candidate(best, candidate.parent)
        self.tried.append(found)
        self.quieten([found])
        return found


class Laws:
    """Laws of one diagnosis: tried while the library is searched, and after it.

    The library goes more effects deep where one is not enough; where one law alone leaves only
    noise that would be time lost. So laws are tried before, beside nothing.
    """

    def __init__(self, searches: Sequence[Search]) -> None:
        """Searches of baselines, the quickest first."""
        self.searches = searches
        self._alone: dict[int, Hunt] = {}

    def alone(self, search: Search) -> float | None:
        """What the library has to reach against a law that leaves only noise; None without one.

        Parameters
        ----------
        search
            Where the library is searched; laws are tried in the quickest one before. Asked again
            it answers from what it has tried.
        """
        for where in dict.fromkeys((self.searches[0], search)):
            hunt = self._begun(where)
            search.noise = where.noise = min(search.noise, where.noise)
            best = _best([hunt])
            if best is not None and _leaves_noise(*best):
                return best[1].evidence - _least_ahead(best[1])
        return None

    def tried_alone(self) -> tuple[Search, Fit] | None:
        """The law beside nothing that leaves least, claimed or not, and where it was tried."""
        found = [(h.search, c.fit) for h in self._alone.values() for c in h.tried]
        return min(found, key=lambda pair: pair[1].chi2, default=None)

    def _going_on(self, path: Path) -> Hunt:
        """A hunt on a path, with what was tried beside nothing before."""
        begun = self._alone.get(id(path.search))
        if begun is None:
            return Hunt(path, open=self._open(path.search))
        return Hunt(path, [*begun.tried], alone=True)

    def _open(self, search: Search) -> Sequence[Law]:
        """Every law in the quickest search, the best of those in the others: springs take long."""
        if not search.on_springs:
            return bendable()
        return self._begun(self.searches[0]).ranked[:MOST_OPEN]

    def _begun(self, search: Search) -> Hunt:
        """Laws beside nothing, tried once."""
        if id(search) not in self._alone:
            base = search.baseline()
            hunt = Hunt(Path(search, base, base), open=self._open(search))
            self._alone[id(search)] = hunt
            _polish_best([hunt])
        return self._alone[id(search)]

    def discover(self, paths: Sequence[Path], progress: Progress) -> Discovery | None:
        """The law that explains the runs better than the library does, or None.

        Laws are tried beside a rigid vehicle in any case, beside one on springs where it explains
        the runs best or no path leaves only noise.

        Parameters
        ----------
        paths
            What the diagnosis tried, from each baseline.
        progress
            Called with a stage and the share done.
        """
        progress("laws beyond the library", 0.93)
        clean = any(path.clean for path in paths)
        best_of_each = _one_of_each(paths)
        tried = {path.search.on_springs for path in best_of_each}
        if clean:
            best_of_each = [
                p for p in best_of_each if p is best_of_each[0] or not p.search.on_springs
            ]
        hunts = [self._going_on(path) for path in best_of_each]
        for search in self.searches:
            wanted = id(search) in self._alone or not (search.on_springs and clean)
            if wanted and search.on_springs not in tried:
                base = search.baseline()
                hunts.append(self._going_on(Path(search, base, base)))
        _share_noise(hunts)
        best = _best(hunts)
        if best is None or not _leaves_noise(*best) or not _ahead(hunts, best[1]):
            _polish_best(hunts)
            _share_noise(hunts)
            best = _best(hunts)
        if best is None or not _ahead(hunts, best[1]):
            return None
        hunt, candidate = best
        progress("shape of the law", 0.95)
        candidate = hunt.shaped(candidate)
        _share_noise(hunts)
        candidate = _completed(hunt, candidate)
        return _claimed(hunts, hunt, candidate)


def _polish_best(hunts: Sequence[Hunt]) -> None:
    """The best laws of all parents and baselines in free simulation."""
    near = [(h, c) for h in hunts for parent in _parents(h) for c in h.beside(parent)]
    if not near:
        return
    near.sort(key=lambda pair: pair[1].fit.chi2)
    near = [pair for pair in near if pair[1].fit.chi2 < NEAR * near[0][1].fit.chi2]
    fewest: list[tuple[Hunt, Candidate]] = []
    for hunt, candidate in near:
        alone = sum(h is hunt and len(c.fit.terms) == len(candidate.fit.terms) for h, c in fewest)
        if alone < POLISHED and len(fewest) < MOST_POLISHED:
            fewest.append((hunt, candidate))
    for hunt in hunts:
        own = [c for h, c in fewest if h is hunt]
        if own:
            hunt.polish(own)


def _ahead(hunts: Sequence[Hunt], candidate: Candidate) -> bool:
    """The law is likelier than the best of the library, by more than the plant's own form."""
    return candidate.evidence > _library(hunts)[1].evidence + _least_ahead(candidate)


def _least_ahead(candidate: Candidate) -> float:
    """Logarithm of the odds from which a law is said."""
    every_tyre = law_in(candidate.fit.terms[-1]).motion == "side_force"
    return CLAIMED if every_tyre else FORM


def _library(hunts: Sequence[Hunt]) -> tuple[Hunt, Candidate]:
    """The best without a law."""
    found = [(h, h.weighed(c)) for h in hunts for c in (h.path.base, h.path.best)]
    return max(found, key=lambda pair: pair[1].evidence)


def _one_of_each(paths: Sequence[Path]) -> list[Path]:
    """The likeliest path of those with a rigid vehicle, and of those with one on springs."""
    found: dict[bool, Path] = {}
    for path in sorted(paths, key=lambda p: -p.search.weighed(p.best).evidence):
        found.setdefault(path.search.on_springs, path)
    return list(found.values())


def _plain(path: Path) -> bool:
    return path.clean and len(path.best.fit.terms) < SEVERAL[path.search.on_springs]


def _parents(hunt: Hunt) -> list[Fit]:
    """What laws are tried beside: nothing, and what the library found.

    On springs one effect that leaves only noise is not asked to make room: a law that would do
    without it is found beside it, and takes it out then (`_completed`).
    """
    path, known = hunt.path, hunt.path.best.fit
    alone = [] if hunt.alone or (_plain(path) and known.terms) else [path.base.fit]
    return [*alone, known] if known.terms else alone


def _share_noise(hunts: Sequence[Hunt]) -> None:
    noise = min(h.search.noise for h in hunts)
    for hunt in hunts:
        hunt.search.noise = noise


def _best(hunts: Sequence[Hunt]) -> tuple[Hunt, Candidate] | None:
    """The likeliest law that takes away enough."""
    found = [(h, h.weighed(c)) for h in hunts for c in h.tried if _enough(h, c)]
    return max(found, key=lambda pair: pair[1].evidence, default=None)


def _leaves_noise(hunt: Hunt, candidate: Candidate) -> bool:
    """The law leaves only noise of what the calibrated vehicle leaves."""
    return explained(hunt.path.base.fit, candidate.fit)


def _enough(hunt: Hunt, candidate: Candidate) -> bool:
    fit, parent = candidate.fit, candidate.parent
    springs = hunt.search.on_springs
    enough = worth(hunt.path.base.fit, parent, fit, on_springs=springs)
    if not noticeable(fit.terms[-1]) or not enough:
        return False
    return not parent.terms or fit.chi2 < (1.0 - BESIDE_KNOWN) * parent.chi2


def _completed(hunt: Hunt, candidate: Candidate) -> Candidate:
    """Without library effects that the law makes needless, to the very end of the fit.

    Beside it one has to be worth what it would have to be worth beside another effect.
    """
    search, base = hunt.search, hunt.path.base.fit
    while len(candidate.fit.terms) > 1:
        candidate = hunt.weighed(candidate)
        terms = candidate.fit.terms
        fewer = [
            hunt.weighed(Candidate(search.without(candidate.fit, i), candidate.parent))
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
    return hunt.weighed(replace(candidate, fit=fit))


def _claimed(hunts: Sequence[Hunt], hunt: Hunt, candidate: Candidate) -> Discovery | None:
    """The law as a claim, if the library does not do as well."""
    from_, library = _library(hunts)
    if not _ahead(hunts, candidate) or not noticeable(candidate.fit.terms[-1]):
        return None
    if (
        reduced_chi_square(candidate.fit) > UNEXPLAINED_ABOVE
    ):  # a vehicle bent to fit a wrong law: not even a share counts
        return None
    base = hunt.path.base.fit
    rows = list(
        zip(
            left_out(hunt.search.problem, base),
            left_out(from_.search.problem, library.fit),
            left_out(hunt.search.problem, candidate.fit),
            strict=True,
        )
    )
    if rows:
        _, by_library, by_law = typical(rows)
        if by_law > BETTER * by_library:
            return None
    return Discovery(
        hunt.search, base, library.fit, candidate.fit, candidate.evidence - library.evidence,
        _others(hunts, candidate), rows,
    )  # fmt: skip


def _others(hunts: Sequence[Hunt], best: Candidate) -> list[tuple[Law, float]]:
    """Other laws that cannot be told from the best."""
    law = law_in(best.fit.terms[-1])
    found: dict[str, tuple[Law, float]] = {}
    for hunt in hunts:
        for candidate in map(hunt.weighed, hunt.tried):
            other = law_in(candidate.fit.terms[-1])
            behind = candidate.evidence - best.evidence
            same = (other.place, other.motion) == (law.place, law.motion)
            if same or behind < -APART or not _enough(hunt, candidate):
                continue
            name = candidate.fit.terms[-1].effect.component
            if name not in found or found[name][1] < behind:
                found[name] = other, behind
    return sorted(found.values(), key=lambda pair: -pair[1])
