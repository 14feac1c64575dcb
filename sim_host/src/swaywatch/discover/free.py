"""Free curves: the law of a place and a motion where no form is given, in straight pieces.

To first order a curve is a sum of its pieces, so all of them are solved for together, for every
place and motion. A curve says at which place something acts and on what it depends, whatever form
it has; forms next to it are tried afterwards.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.search import Linear
from swaywatch.discover.effect import effect_of
from swaywatch.discover.forms import curve, in_pieces
from swaywatch.discover.grammar import curves
from swaywatch.discover.law import (
    KEEPING,
    LINE_AND_CUBE,
    MOTIONS,
    NOTCHED,
    PIECES,
    STEPPED,
    UNEVEN,
    Law,
)
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect, Values

Array = NDArray[np.float64]

#: Where the last pieces of a curve begin, over the usual amplitude of its motion.
REACHES = (0.35, 1.0, 2.5)
BEGUN_CURVES = 12  # that are begun, of all places and motions
#: Slopes are believed to be within so many times their usual initial value; what no motion comes
#: to stays at nothing.
BELIEVED = 10.0
TRIED_BENDS = (0.1, 0.2, 0.35, 0.6, 1.0)  # over that of the curve, for a form instead of it
#: The same of what comes again and again, from what pieces of a fifth can show.
FINER_BENDS = {
    STEPPED: tuple(0.15 * 1.1**n for n in range(20)),
    NOTCHED: tuple(0.03 * 1.1**n for n in range(37)),
}


def free_curves(course: Linear) -> list[ActiveEffect]:
    """The curves that promise most to first order, of different places and motions."""
    found = []
    for law in curves():
        effect = effect_of(law)
        ways = [_pieces(course, effect, reach * MOTIONS[law.motion].usual) for reach in REACHES]
        found.append(max(ways, key=lambda way: way[0]))
    found.sort(key=lambda way: -way[0])
    return [term for _, term in found[:BEGUN_CURVES]]


def _pieces(course: Linear, effect: Effect, bend: float) -> tuple[float, ActiveEffect]:
    """Drop of chi2 that a curve of some reach promises, and its slopes."""
    names = [p.name for p in effect.parameters]
    first = {p.name: p.starts[0] for p in effect.parameters} | {"bend": bend}
    none = first | dict.fromkeys(PIECES, 0.0)
    size = first["gain"]
    tried = [tuple((none | {piece: size})[name] for name in names) for piece in PIECES]
    columns = np.stack(course.columns([(effect, values) for values in tried]), axis=1)
    columns = np.where(np.isfinite(columns), columns, 0.0)
    a = columns.T @ columns + np.eye(len(PIECES)) / BELIEVED**2
    b = -columns.T @ course.left
    x = np.linalg.solve(a, b)
    values = none | {piece: size * share for piece, share in zip(PIECES, x, strict=True)}
    inside = tuple(min(max(values[p.name], p.low), p.high) for p in effect.parameters)
    return float(b @ x), ActiveEffect(effect, inside)


def form_of(values: Values, law: Law) -> dict[str, float]:
    """Gain and bend of a form that is like a curve, as far as that reaches."""
    z = np.linspace(-values["bend"], values["bend"], 201)
    whole = in_pieces(z, values)
    # these depend on how it got there, or have no bend: as strong as the curve
    if law.shape in (*KEEPING, UNEVEN, LINE_AND_CUBE):
        return {"gain": float(np.copysign(np.max(np.abs(whole)), whole[-1])) / values["bend"]}
    best = (np.inf, {"gain": values["gain"]})
    for share in FINER_BENDS.get(law.shape, TRIED_BENDS):
        bend = share * values["bend"]
        one = curve(law.shape, z, bend)
        power = float(one @ one)
        gain = float(one @ whole) / power if power > 0.0 else 0.0
        left = float(np.sum((whole - gain * one) ** 2))
        best = min(best, (left, {"gain": gain, "bend": bend}), key=lambda row: row[0])
    return best[1]
