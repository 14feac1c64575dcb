"""The law that came nearest where none is claimed: where to look first.

A law of the right place and variable often leaves more than noise because its form is missing in
the grammar. It is no finding then, and still the best hint that there is. And where several effects
together explain what one law alone would, both are said.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from swaywatch.diagnose.evidence.evidence import UNEXPLAINED_ABOVE
from swaywatch.diagnose.evidence.search import reduced_chi_square
from swaywatch.diagnose.fit.fit import Fit
from swaywatch.discover.begin import law_in
from swaywatch.discover.effect import ID
from swaywatch.discover.law import Law
from swaywatch.discover.report import location, variables
from swaywatch.effects.active import ActiveEffect

WORTH_A_HINT = 0.5  # of the misfit above noise: a law that leaves more of it is no hint
AS_NEAR = 1.5  # times what the nearest law leaves above noise, up to which another one is named
MOST_NAMED = 3
SEVERAL = 2  # findings from which on one law in their place is worth a sentence
ALIKE = 1.1  # times what they leave, up to which it explains as much


def nearest(fits: Iterable[Fit], so_far: Fit) -> list[dict[str, Any]]:
    """Laws that leave least, each of another place or variable; none where they explain little.

    Parameters
    ----------
    fits
        Free simulations with a law each.
    so_far
        The verdict's own, without one.
    """
    best: dict[tuple[str, str, str, str], tuple[float, Fit]] = {}
    for fit in fits:
        law = _law(fit)
        left = reduced_chi_square(fit)
        key = (law.place, law.motion, law.second, law.by + law.side)
        if left < best.get(key, (float("inf"),))[0]:
            best[key] = left, fit
    ranked = sorted(best.values(), key=lambda row: row[0])
    before = reduced_chi_square(so_far)
    if not ranked or _above(ranked[0][0]) > WORTH_A_HINT * _above(before):
        return []
    near = [row for row in ranked if _above(row[0]) <= AS_NEAR * _above(ranked[0][0])]
    return [_entry(fit, left, before, i) for i, (left, fit) in enumerate(near[:MOST_NAMED])]


def instead(fits: Iterable[Fit], found: Fit) -> list[str]:
    """A sentence on one law alone that leaves hardly more than several findings, if there is one.

    Parameters
    ----------
    fits
        Free simulations with a law each.
    found
        The verdict's own.
    """
    alone = [fit for fit in fits if len(fit.terms) == 1]
    if len(found.terms) < SEVERAL or not alone:
        return []
    best = min(alone, key=reduced_chi_square)
    left, theirs = reduced_chi_square(best), reduced_chi_square(found)
    if left > min(UNEXPLAINED_ABOVE, ALIKE * theirs):
        return []
    return [
        f"instead of the {len(found.terms)} findings one law that is in no library would do: "
        f"{_words(best)}; it leaves {left:.2f} times the noise, they leave {theirs:.2f}"
    ]


def _term(fit: Fit) -> ActiveEffect:
    return next(t for t in fit.terms if t.effect.id == ID)


def _law(fit: Fit) -> Law:
    return law_in(_term(fit))


def _above(left: float) -> float:
    """What is left above noise: of the best laws it is less than noise is estimated."""
    return max(left - 1.0, 0.0)


def _words(fit: Fit) -> str:
    """Where a law acts, on what it depends, and the law."""
    law = _law(fit)
    depends_on = " and the ".join(variables(law))
    return f"{location(law)}, with the {depends_on} ({_term(fit).effect.equation})"


def _why_not(left: float) -> str:
    """Why a law is not claimed."""
    if left > UNEXPLAINED_ABOVE:
        return f"a claim leaves at most {UNEXPLAINED_ABOVE:g}"
    return "it is not clearly likelier than the findings, or not in the runs left out"


def _entry(fit: Fit, left: float, before: float, rank: int) -> dict[str, Any]:
    law, term = _law(fit), _term(fit)
    words = _words(fit)
    if rank == 0:
        reason = (
            f"the law that comes nearest is not claimed: {words}. It leaves {left:.2g} times the "
            f"noise, {before:.3g} times without it; {_why_not(left)}. Look there first"
        )
    else:
        reason = f"nearly as near: {words}, {left:.2g} times the noise"
    return {
        "reason": reason,
        "location": location(law),
        "place": law.place,
        "variables": variables(law),
        "depends_on": law.motion,
        "depends_on_too": law.second or law.by,
        "spec": law.spec,
        "values": term.as_dict(),
        "beside": [t.effect.name for t in fit.terms if t is not term],
        "reduced_chi_square": left,
    }
