"""Searches from each baseline: a vehicle rigid or on springs, exact or as users know it.

What is compared is always a whole explanation: a baseline, calibrated, with its effects.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from swaywatch.diagnose.evidence.evidence import (
    BESIDE,
    CLAIMED,
    DISCREPANCY,
    UNEXPLAINED_ABOVE,
    explained,
    form_misfit,
    price_of_form,
    worth,
)
from swaywatch.diagnose.evidence.search import (
    BEAM,
    LINEAR,
    WINDOWED_STEP,
    Candidate,
    Progress,
    Search,
    reduced_chi_square,
)
from swaywatch.diagnose.fit.fit import Fit
from swaywatch.diagnose.fit.road_vehicle import pushing, without
from swaywatch.effects.active import ActiveEffect

SHORTEST_WINDOW_S = 0.6
MOST_EFFECTS = 3
#: What is left out where a diagnosis has simulated enough: another baseline, more effects.
TRIED = ("effects beside another vehicle", "further combinations of effects")
#: Tolerances of the vehicle's file, as stated and where its values turn out far more exact: a value
#: that is off by its tolerance says nothing among others that are off as far, and much among ones
#: that are not off at all.
CARES = (1.0, 0.15)
EXACT = 0.4  # tolerances, median over the file
#: Misfit, over that of a vehicle on springs, from which a rigid one is not searched any further.
HOPELESS = 1.25
#: Effects that are tried before laws are; more only where no law alone leaves nothing but noise.
BESIDE_LAW = 1
LAWS = "laws that no library has"
#: Misfit, over that of the best, up to which another first effect is followed.
NEAR = 1.5


@dataclass
class Path:
    """A search from one baseline.

    Attributes
    ----------
    search, base, best
        What was searched, the baseline and the best explanation, maybe the baseline itself.
    """

    search: Search
    base: Candidate
    best: Candidate

    @property
    def all(self) -> list[Candidate]:
        """Everything tried, weighed alike, best first."""
        found = [self.search.weighed(c) for c in (self.base, *self.search.tried)]
        return sorted(found, key=lambda c: -c.evidence)

    @property
    def clean(self) -> bool:
        """Noise is left: another baseline cannot do much better."""
        return reduced_chi_square(self.best.fit) <= UNEXPLAINED_ABOVE


def possible(springs: Search) -> Search:
    """A search on springs whose baseline is one that can be: drag holds, and does not push.

    Parameters
    ----------
    springs
        With all that a road vehicle has; what its calibrated vehicle has less than nothing of
        (simulators have no drag) is left out of the search that is returned.
    """
    problem, pulled = springs.problem, springs.baseline().fit
    wrong = pushing(problem, pulled.shift)
    if not wrong:
        return springs
    kept = [belief.name not in wrong for belief in problem.beliefs.items]
    found = Search(without(problem, wrong), springs.effects, springs.progress)
    found.baseline(near=replace(pulled, shift=pulled.shift[kept]))
    return found


def explore(planar: Sequence[Search], springs: Search | None, progress: Progress) -> list[Path]:
    """Search from each baseline that may hold.

    Parameters
    ----------
    planar
        Searches with a rigid vehicle, one for each of `CARES`.
    springs
        Search with a vehicle on springs; None: the baseline is the user's own simulation.
    progress
        Called with a stage and the share done.
    """
    count = len(planar) + (springs is not None)
    part = _Parts(progress, count)
    progress("calibrated vehicle", 0.0)
    first = planar[0]
    base = first.baseline()
    if springs is None:
        paths = [path(first, base, part.next())]
    else:
        paths = _either(first, base, springs, part)
    if paths[-1].search is first and _exact(paths[-1]):
        paths += [_with_care(search, paths[-1], part.next()) for search in planar[1:]]
    noise = min(p.search.noise for p in paths)
    for each in paths:
        each.search.noise = noise
    return paths


class _Parts:
    """Progress of one search after the other."""

    def __init__(self, progress: Progress, count: int) -> None:
        self.progress, self.count, self.done = progress, count, 0

    def next(self) -> Progress:
        first = self.done / self.count
        self.done += 1

        def part(stage: str, share: float) -> None:
            self.progress(stage, min(0.92, first + share / self.count))

        return part


def _either(first: Search, base: Candidate, springs: Search, part: _Parts) -> list[Path]:
    """The likelier of the two baselines first, the other where it may do better; rigid last.

    Where much is missing from both, their misfits say little: one effect beside the rigid one,
    which is faster, is tried first; a rigid one that is far behind, only with effects that last.
    """
    other = springs.baseline()
    first.noise = springs.noise = min(first.noise, springs.noise)
    likelier = first.weighed(base).evidence >= springs.weighed(other).evidence
    far = reduced_chi_square(other.fit) > LINEAR
    unclear = far and (base.fit.chi2 < HOPELESS * other.fit.chi2 or _one_is_enough(first, base))
    known = None
    if likelier or unclear:
        short = path(first, base, first.progress, most=1)
        base = first.baseline()
        if short.clean:
            return [short]
        if short.best.fit.terms and not springs.refuses(TRIED[0]):
            known = _again(springs, short.best.fit.terms, other)
        # a rigid vehicle that the first effect leaves far behind is not searched to the end first
        behind = known is not None and HOPELESS * known.chi2 < short.best.fit.chi2
        if likelier and not behind:
            ended = explained(base.fit, short.best.fit)  # it was searched to the end
            found = short if ended else path(first, base, part.next())
            if found.clean:
                return [found]
            return [path(springs, other, part.next(), known=known), found]
    found = path(springs, other, part.next(), known=known)
    if not found.clean:
        return [found, path(first, base, part.next())]
    return [found, *_rigid_too(first, base, found, part)]


def _rigid_too(first: Search, base: Candidate, found: Path, part: _Parts) -> list[Path]:
    """The search with a rigid vehicle, where one may do better than that found on springs."""
    if first.refuses(TRIED[0]):
        return []
    same = _again(first, found.best.fit.terms, base)
    if _hopeless(first, base, same, found):
        return []
    # beyond one effect more, a rigid vehicle has to do better than this one to be searched on
    rival = Rival(len(found.best.fit.terms) + 1, found.search.weighed(found.best).evidence)
    return [path(first, base, part.next(), rival, known=same)]


def _one_is_enough(rigid: Search, base: Candidate) -> bool:
    """One effect without windows leaves only noise; what is tried is asked for later anyway."""
    found = rigid.extend(base.fit, windowed=False)
    return any(reduced_chi_square(c.fit) <= UNEXPLAINED_ABOVE for c in found)


def _hopeless(rigid: Search, base: Candidate, same: Fit, other: Path) -> bool:
    """A rigid vehicle is far off, with the same effects or without, and one more does not help."""
    parents = [base.fit, same] if same.terms else [base.fit]
    found = [c.fit for parent in parents for c in rigid.extend(parent, windowed=False)]
    return min(f.chi2 for f in (same, *found)) > HOPELESS * other.best.fit.chi2


def _again(search: Search, terms: Sequence[ActiveEffect], base: Candidate) -> Fit:
    """Active effects found beside another baseline, fitted beside this one.

    Where that leaves much, from the vehicle as believed too: this baseline is bent without them.
    """
    fit = search.judge.run(replace(base.fit, terms=_own(search, terms)), 12)
    if not fit.terms or reduced_chi_square(fit) <= UNEXPLAINED_ABOVE:
        return fit
    return min(fit, search.afresh(fit), key=lambda f: f.chi2)


def _own(search: Search, terms: Sequence[ActiveEffect]) -> tuple[ActiveEffect, ...]:
    """Active effects found beside another baseline, as this search says them."""
    known = {(e.name, e.extra.get("form", "box")): e for e in search.effects}
    own = [known.get((t.effect.name, t.effect.extra.get("form", "box"))) for t in terms]
    return tuple(
        replace(t, effect=e) if e is not None and len(e.parameters) == len(t.effect.parameters)
        else t
        for t, e in zip(terms, own, strict=True)
    )  # fmt: skip


def _with_care(search: Search, other: Path, progress: Progress) -> Path:
    """The path of the same vehicle with another care; where little explains, no second search."""
    base = search.baseline()
    same = search.judge.run(other.best.fit, 12)
    if not other.clean:
        search.note([Candidate(same, base.fit)])
        return Path(search, base, search.tried[-1] if same.terms else base)
    return path(search, base, progress, known=same)


def _exact(path: Path) -> bool:
    """The file's values are so near to the calibrated ones that more care is worth a try."""
    beliefs = path.search.problem.beliefs
    file = [i for i, b in enumerate(beliefs.items) if b.scaled]
    shift = np.abs(path.search.weighed(path.best).fit.shift[file])
    return bool(shift.size and np.median(shift) < EXACT)


@dataclass(frozen=True)
class Rival:
    """Another explanation: more effects than `most` only where they already do better than it."""

    most: int
    evidence: float


def path(
    search: Search,
    base: Candidate,
    progress: Progress,
    rival: Rival | None = None,
    known: Fit | None = None,
    most: int = MOST_EFFECTS,
) -> Path:
    """More effects, as long as the evidence grows by more than a claim needs.

    Parameters
    ----------
    search, base
        Where, and its baseline.
    progress
        Called with a stage and the share done.
    rival
        What it has to beat.
    known
        The explanation of another baseline, refitted here: beside one effect that leaves only noise
        nothing in windows is looked for.
    most
        Effects, if they leave more than noise.
    """
    beam = [base]
    if known is not None and not _suffices(search, base, known):
        known = None
    best = base
    for depth in range(1, MOST_EFFECTS + 1):
        if _ends(search, base, best, depth, most, rival):
            break
        found: list[Candidate] = []
        for index, parent in enumerate(beam):
            if index and search.refuses(TRIED[1]):
                break
            progress(f"{depth} effect{'s' * (depth > 1)}", (depth - 1 + index / len(beam)) / 3.0)
            again = known is None or depth > 1
            found += search.extend(parent.fit, windowed=again)
        if known is not None and depth == 1:
            found.append(Candidate(known, base.fit))
            search.note(found[-1:])
        best = search.weighed(best)
        found, slight = _claims(base, best, found)
        found = _ranked(search, base, best, found)
        if not found or found[0].evidence < best.evidence + CLAIMED:
            break
        if _outdone(search, base, best, found[0], _ranked(search, base, best, slight)):
            break
        fit = search.judge.run(found[0].fit, 30, tolerance=1e-4)
        best = found[0] = search.weighed(replace(found[0], fit=fit))
        again = depth == 1 and not search.refuses(TRIED[1])
        again = again and search.has_room(WINDOWED_STEP)  # they take as long once more
        if again and not _needless(search, base, best) and search.rebased(best.fit):
            return path(search, search.baseline(), progress, rival, known, most)
        base = search.baseline()
        # where nothing is left, a second best start leads nowhere else
        clean = explained(base.fit, best.fit)
        beam = [best] if clean else [c for c in found[:BEAM] if _hopeful(c, best)]
    return Path(search, base, _needed(search, best))


def _ranked(
    search: Search, base: Candidate, best: Candidate, found: Sequence[Candidate]
) -> list[Candidate]:
    """Those that are worth a claim by what they take away, the likeliest first.

    Beside the user's own simulation of what the `best` with fewer effects leaves, too: a right
    effect takes away enough where it comes after a wrong one.
    """
    beside = not search.problem.free_start
    ranked = sorted(map(search.weighed, found), key=lambda c: -c.evidence)
    ranked = _simplest(ranked, base.fit, beside)
    form = {"beside": beside, "on_springs": search.on_springs}

    def before(candidate: Candidate) -> Fit:
        fewer = (candidate.parent, best.fit) if beside else (candidate.parent,)
        return min(fewer, key=lambda fit: fit.chi2)

    kept = [c for c in ranked if worth(base.fit, before(c), c.fit, **form)]
    return sorted(kept, key=lambda c: -_likelihood(search, base, c))


def _likelihood(search: Search, base: Candidate, candidate: Candidate) -> float:
    """Evidence; beside the user's own simulation less the price of our plant's form."""
    if search.problem.free_start:
        return candidate.evidence
    return candidate.evidence - price_of_form(base.fit, candidate.fit, search.noise)


def _claims(
    base: Candidate, best: Candidate, found: Sequence[Candidate]
) -> tuple[list[Candidate], list[Candidate]]:
    """What may be claimed, and what is there or may be but is too small for that.

    However small, what alone leaves only noise where more was left is a claim; but small pieces in
    windows can follow anything.
    """
    claims: list[Candidate] = []
    slight: list[Candidate] = []
    for candidate in found:
        if all(map(noticeable, candidate.fit.terms)):
            claims.append(candidate)
        elif is_slight(candidate):
            needed = explained(base.fit, candidate.fit) and not explained(base.fit, best.fit)
            needed &= not any(t.effect.windowed for t in candidate.fit.terms)
            (claims if needed else slight).append(candidate)
    return claims, slight


def _outdone(
    search: Search,
    base: Candidate,
    best: Candidate,
    claim: Candidate,
    slight: Sequence[Candidate],
) -> bool:
    """Only noise is left anyway, and of it another effect, too small for a claim, takes more."""
    if reduced_chi_square(best.fit) > UNEXPLAINED_ABOVE:
        return False
    least = _likelihood(search, base, claim)
    return any(_likelihood(search, base, c) > least for c in slight if c.names != claim.names)


def _ends(
    search: Search, base: Candidate, best: Candidate, depth: int, most: int, rival: Rival | None
) -> bool:
    """Tell whether so many effects are one too many to try."""
    if depth > most and not explained(base.fit, best.fit):
        return True
    if rival and depth > rival.most and search.weighed(best).evidence < rival.evidence:
        return True
    if search.refuses(TRIED[depth > 1]):
        return True
    return depth > BESIDE_LAW and _needless(search, base, best)


def _needless(search: Search, base: Candidate, best: Candidate) -> bool:
    """One law that is none of these effects leaves only noise, and is far likelier than these."""
    if search.beyond is None or explained(base.fit, best.fit):
        return False
    law = search.beyond(search)
    needless = law is not None and search.weighed(best).evidence < law
    search.ended_by_law |= needless
    return needless


def _suffices(search: Search, base: Candidate, known: Fit) -> bool:
    """One effect that leaves only noise of what the baseline leaves more of."""
    if len(known.terms) != 1:
        return False
    return search.settled(base.fit, [known]) and (
        reduced_chi_square(known) <= UNEXPLAINED_ABOVE or not search.on_springs
    )


def _needed(search: Search, best: Candidate) -> Candidate:
    """Without effects that only made up for what a later one explains, each tried from rest."""
    while len(best.fit.terms) > 1:
        fewer = [search.without(best.fit, i) for i in range(len(best.fit.terms))]
        candidates = [search.weighed(Candidate(fit, best.parent)) for fit in fewer]
        first = max(candidates, key=lambda c: c.evidence)
        if first.evidence < search.weighed(best).evidence - CLAIMED:
            break
        search.note([first])
        best = first
    return best


def _hopeful(candidate: Candidate, best: Candidate) -> bool:
    """A second best start is followed as long as what it leaves is not far from the best's."""
    return candidate is best or candidate.fit.chi2 < NEAR * best.fit.chi2


def _simplest(ranked: Sequence[Candidate], base: Fit, beside: bool) -> list[Candidate]:
    """Of several forms of the same effects the simplest that does nearly as well."""
    kept: dict[tuple[str, ...], Candidate] = {}
    for candidate in ranked:
        other = kept.setdefault(candidate.names, candidate)
        fewer = _numbers(candidate) < _numbers(other)
        nearly = DISCREPANCY * other.fit.chi2
        if beside:
            nearly = max(nearly, BESIDE[0] * form_misfit(base, other.fit))
        if fewer and candidate.fit.chi2 < other.fit.chi2 + nearly:
            kept[candidate.names] = candidate
    return list(kept.values())


def _numbers(candidate: Candidate) -> int:
    """Free numbers of the effects, those of windows left out."""
    return sum(0 if t.effect.windowed else len(t.values) for t in candidate.fit.terms)


def each_once(ranked: Sequence[Candidate]) -> list[Candidate]:
    """Of those with the same effects the first."""
    kept: dict[tuple[str, ...], Candidate] = {}
    for candidate in ranked:
        kept.setdefault(candidate.names, candidate)
    return list(kept.values())


def noticeable(term: ActiveEffect) -> bool:
    """Tell whether an effect is large enough to be worth a claim, and not at a bound of its fit."""
    if not _inside(term):
        return False
    if term.effect.windowed:
        return any(noticeable_window(term, w) for w in range(len(term.window_runs)))
    for value, p in zip(term.values, term.effect.parameters, strict=True):
        if abs(value - p.neutral) >= p.minimum:
            return True
    return False


def is_slight(candidate: Candidate) -> bool:
    """Every effect is there or may be, and one of them is too small to be worth a claim."""
    slight = [_small(term) for term in candidate.fit.terms]
    return any(slight) and all(
        small or noticeable(t) for small, t in zip(slight, candidate.fit.terms, strict=True)
    )


def _small(term: ActiveEffect) -> bool:
    """All sizes are below what is worth a claim, in windows that are long enough for one."""
    if not _inside(term):
        return False
    if any(stop - start < SHORTEST_WINDOW_S for start, stop in _edges(term)):
        return False
    sizes = [
        (value, term.parameter(i))
        for i, value in enumerate(term.values)
        if not term.is_edge(i) and term.parameter(i).minimum > 0.0
    ]
    return bool(sizes) and all(abs(value - p.neutral) < p.minimum for value, p in sizes)


def _edges(term: ActiveEffect) -> list[tuple[float, float]]:
    """Beginning and end of each window."""
    v, n = term.values, term.stride
    return [(v[w * n], v[w * n + 1]) for w in range(len(term.window_runs))]


def _inside(term: ActiveEffect) -> bool:
    """No value that is worth a claim lies at a bound, where no effect of its kind could be."""
    possible = term.effect.extra.get("possible")
    if callable(possible) and not possible(term.as_dict()):
        return False
    for index, value in enumerate(term.values):
        p = term.parameter(index)
        bounded = p.neutral not in (p.low, p.high) and not p.steepness
        if p.minimum > 0.0 and not p.shapes and bounded:
            room = 1e-3 * (p.high - p.low)
            if not p.low + room < value < p.high - room:
                return False
    return True


def noticeable_window(term: ActiveEffect, window: int) -> bool:
    """Tell whether a window is long enough and its values large enough for a claim of its own.

    A fit may move its ends past each other, or its values to next to nothing.
    """
    v = term.values[window * term.stride : (window + 1) * term.stride]
    if v[1] - v[0] < SHORTEST_WINDOW_S:
        return False
    return any(
        abs(x - p.neutral) >= p.minimum
        for x, p in zip(v[2:], term.effect.parameters, strict=True)
        if p.minimum > 0.0
    )
