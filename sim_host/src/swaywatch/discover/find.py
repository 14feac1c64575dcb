"""Selection of a law: laws against the library, in free simulation, by evidence and left-out runs.

A law is tried alone and together with the effects found in the library, from each baseline. All are
weighed alike (`diagnose/evidence/evidence.py`), with a penalty for the choice among all laws and
effects. A law is claimed only where its evidence exceeds that of the best explanation from the
library, where it reduces the misfit by more than the discrepancy of models of this depth, and where
it makes the left-out runs likelier, given what the other runs taught.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.baselines import LAWS, Path, noticeable
from swaywatch.diagnose.evidence.evidence import (
    APART,
    CLAIMED,
    UNEXPLAINED_ABOVE,
    explained,
    worth,
)
from swaywatch.diagnose.evidence.search import (
    Candidate,
    Progress,
    Search,
    reduced_chi_square,
)
from swaywatch.diagnose.evidence.verdict import predicts_worse
from swaywatch.diagnose.fit.fit import Fit
from swaywatch.diagnose.fit.holdout import left_out
from swaywatch.discover.begin import law_in
from swaywatch.discover.effect import ID
from swaywatch.discover.grammar import all_laws
from swaywatch.discover.law import Law
from swaywatch.discover.trial import (
    BESIDE_KNOWN,
    NOISE_CLOSE,
    LawSearch,
    laws_refuse,
    least_ahead,
    library_suffices,
)
from swaywatch.effects.active import ActiveEffect

Array = NDArray[np.float64]
MOST_OPEN = 40  # laws that are started in another search than the quickest one
POLISHED = 2  # of them in free simulation, beside each parent, ...
MOST_POLISHED = 4  # ... and of all
NEAR = 1.15  # misfit under the observer, over the smallest, up to which a law is kept
BESIDE = "laws beside effects of the library"  # in words, for what was left untried


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
        self._every: list[LawSearch] = []

    def alone(self, search: Search) -> float | None:
        """Evidence that the library has to reach against a law that leaves only noise, or None.

        Parameters
        ----------
        search
            Where the library is searched; laws are tried in the quickest one before. Results are
            kept for further calls.
        """
        first, springs = self.searches[0], self.searches[-1]
        if _calibrated(springs) <= UNEXPLAINED_ABOVE < _calibrated(first):
            return None  # nothing but springs may be missing
        for where in dict.fromkeys((self.searches[0], search)):
            law_search = self._begun(where)
            search.noise = where.noise = min(search.noise, where.noise)
            best = _best([law_search])
            if best is not None and _leaves_noise(*best):
                return best[1].evidence - least_ahead(law_in(best[1].fit.terms[-1]))
        return None

    def tried_alone(self) -> tuple[Search, Fit] | None:
        """The single law with the smallest misfit, claimed or not, and its search."""
        found = [(h.search, c.fit) for h in self._alone.values() for c in h.tried]
        return min(found, key=lambda pair: pair[1].chi2, default=None)

    def tried(self) -> list[Fit]:
        """Free simulations with a law, claimed or not."""
        return [candidate.fit for h in self._every for candidate in h.tried]

    def _going_on(self, path: Path) -> LawSearch:
        """The laws of a path, with the single laws tried before."""
        begun = self._alone.get(id(path.search))
        if begun is None:
            return self._new(path)
        self._every.append(LawSearch(path, [*begun.tried], alone=True))
        return self._every[-1]

    def _new(self, path: Path) -> LawSearch:
        found = LawSearch(path)
        self._every.append(found)
        found.open = partial(self._open, found)
        if not path.search.on_springs:
            self._on_rigid.append(found)
        return found

    def _open(self, asking: LawSearch) -> Sequence[Law]:
        """All laws on a rigid vehicle; with suspension, which is slow, the best of them.

        The best as they promise there, where they were looked at, or as they fit a rigid vehicle.
        """
        if not asking.search.on_springs:
            return all_laws()
        if asking.ranked:
            return asking.ranked[:MOST_OPEN]
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
            with search.problem.budget.laws():
                _polish_best([law_search])
        return self._alone[id(search)]

    def _ended(self) -> bool:
        """Tell whether the diagnosis has simulated enough."""
        return laws_refuse(self.searches[0].problem.budget, LAWS)

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
        with self.searches[0].problem.budget.laws():
            return self._discovered(paths, progress)

    def _discovered(self, paths: Sequence[Path], progress: Progress) -> Discovery | None:
        """The same; what it simulates counts as spent by laws."""
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
        for law_search in law_searches:
            law_search.suffices = clean
        _share_noise(law_searches)
        best = _best(law_searches)
        if best is None or not _leaves_noise(*best) or not _ahead(law_searches, best[1]):
            # where the library leaves only noise, the paths on which it does so tell whether a law
            # may be missing
            asked = [h for h in law_searches if h.path.clean or not clean]
            if not self._ended() and any(h.promising() for h in asked):
                _polish_best(asked)
            _share_noise(law_searches)
            best = _best(law_searches)
        if best is None or not _ahead(law_searches, best[1]):
            return None
        law_search, candidate = best
        progress("shape of the law", 0.95)
        candidate = _with_known(law_search, law_search.shaped(candidate))
        _share_noise(law_searches)
        candidate = law_search.plain(_completed(law_search, candidate))
        return _claimed(law_searches, law_search, candidate)


def _calibrated(search: Search) -> float:
    """What the calibrated vehicle leaves."""
    return reduced_chi_square(search.baseline().fit)


def _polish_best(law_searches: Sequence[LawSearch]) -> None:
    """The best laws of all parents and baselines in free simulation."""
    near: list[tuple[LawSearch, Candidate]] = []
    for law_search in law_searches:
        for parent in _parents(law_search):
            if near and laws_refuse(law_search.search.problem.budget, BESIDE):
                break
            near += [(law_search, candidate) for candidate in law_search.beside(parent)]
    if not near:
        return
    least = min(candidate.fit.chi2 for _, candidate in near)
    near = [pair for pair in near if pair[1].fit.chi2 < NEAR * least]
    near.sort(key=lambda pair: _priced(*pair))
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


def _priced(law_search: LawSearch, candidate: Candidate) -> float:
    """Misfit, and a price for each number of the law: one that it does not need fits, too."""
    fit = candidate.fit
    return fit.chi2 + 2.0 * CLAIMED * law_search.search.noise * len(fit.terms[-1].values)


def _ahead(law_searches: Sequence[LawSearch], candidate: Candidate) -> bool:
    """The law is likelier than the best of the library by more than the model error allows."""
    least = least_ahead(law_in(candidate.fit.terms[-1]))
    return candidate.evidence > _library(law_searches)[1].evidence + least


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


def _parents(law_search: LawSearch) -> list[Fit]:
    """Models that laws are added to: the vehicle alone, and with the effects from the library.

    With suspension a single effect that leaves only noise is not removed first: a law that makes it
    unnecessary is found together with it, and the effect is removed later (`_completed`).
    """
    path, known = law_search.path, law_search.path.best.fit
    alone = [] if law_search.alone or (library_suffices(path) and known.terms) else [path.base.fit]
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


def _with_known(law_search: LawSearch, candidate: Candidate) -> Candidate:
    """With an effect of the library beside the law, where the law alone leaves more than noise.

    The library was searched without the law: what it found then made up for the law.
    """
    search, fit = law_search.search, candidate.fit
    alone = len(fit.terms) == 1 and reduced_chi_square(fit) > NOISE_CLOSE
    if not alone or laws_refuse(search.problem.budget, BESIDE):
        return candidate
    for found in search.extend(fit, windowed=False)[:1]:
        law, known = found.fit.terms
        both = search.judge.run(replace(found.fit, terms=(known, law)), 20)
        if worth(law_search.path.base.fit, fit, both, on_springs=search.on_springs):
            candidate = law_search.weighed(replace(candidate, fit=both))
    return candidate


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
    if predicts_worse(law_search.search, base, candidate.fit):
        return None
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
