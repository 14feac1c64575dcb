"""Limits of detection: how strong an effect must be to be named rightly nine times in ten.

``python limits.py SCORE.json [SCORE.json ...] --seeds 101 202 --out limits.json`` fits them to
scored sets of other seeds than the proof's. The chance of the right first name is taken as logistic
in the drawn strength u (0: weakest drawn, 1: strongest; the value of every effect is exponential in
it), with one slope for all effects and an offset of its own for each; an effect of which few cases
were made leans on the others. The limit is where the chance passes 90 %; none if it does not up to
u = 1.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

Array = NDArray[np.float64]
Json = dict[str, Any]

PROOF_SEED = 20261121
CHANCE = 0.9
SINGLE = ("planar", "simulation")
SLOPE, SLOPE_SPREAD = 8.0, 4.0  # of the logit from the weakest to the strongest drawn
OFFSET_SPREAD = 2.0  # between effects


def label_of(row: Json) -> str:
    """Effect of a case with one effect, and whether it stands beside a user's simulation."""
    return str(row["ids"][0]) + ("/simulation" if row["kind"] == "simulation" else "")


def fit(rows: list[Json]) -> tuple[float, dict[str, float]]:
    """Common slope and the offset of each effect, by penalised maximum likelihood."""
    labels = sorted({label_of(row) for row in rows})
    index = np.array([labels.index(label_of(row)) for row in rows])
    u = np.array([float(row["strength"]) for row in rows])
    right = np.array([float(bool(row["first"])) for row in rows])

    def cost(x: Array) -> float:
        slope, centre, offsets = x[0], x[1], x[2:]
        z = offsets[index] + slope * u
        loss = float(np.sum(np.logaddexp(0.0, z) - right * z))
        loss += 0.5 * float(np.sum(((offsets - centre) / OFFSET_SPREAD) ** 2))
        return loss + 0.5 * float(((slope - SLOPE) / SLOPE_SPREAD) ** 2)

    start = np.concatenate([[SLOPE, -SLOPE / 2], np.full(len(labels), -SLOPE / 2)])
    best = minimize(
        cost, start, method="L-BFGS-B", bounds=[(1.0, None)] + [(None, None)] * (len(start) - 1)
    ).x
    return float(best[0]), dict(zip(labels, map(float, best[2:]), strict=True))


def value_at(rows: list[Json], u: float) -> float:
    """Value of an effect at a strength; the draws are exponential in it."""
    strength = np.array([float(row["strength"]) for row in rows])
    values = np.log([float(row["value"]) for row in rows])
    if len(rows) == 1 or np.ptp(strength) < 0.05:
        return float(np.exp(values[np.argmin(abs(strength - u))]))
    slope, at_zero = np.polyfit(strength, values, 1)
    return float(np.exp(at_zero + slope * u))


def limits(rows: list[Json]) -> Json:
    """Limit of each effect: strength and value (None: beyond what was drawn), number of cases."""
    singles = [row for row in rows if row["kind"] in SINGLE]
    slope, offsets = fit(singles)
    found: Json = {}
    for label, offset in offsets.items():
        own = [row for row in singles if label_of(row) == label]
        u = (np.log(CHANCE / (1.0 - CHANCE)) - offset) / slope
        known = u <= 1.0
        at = float(np.clip(u, 0.0, 1.0))
        found[label] = {
            "strength": round(at, 3) if known else None,
            "value": float(f"{value_at(own, at):.4g}") if known else None,
            "cases": len(own),
        }
    return found


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scores", nargs="+", type=Path)
    parser.add_argument("--seeds", nargs="+", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    if PROOF_SEED in given.seeds:
        sys.exit(f"{PROOF_SEED} is the seed of the proof: find the limits on others")
    rows = [row for path in given.scores for row in json.loads(path.read_text())["cases"]]
    found = limits(rows)
    given.out.write_text(json.dumps({"seeds": given.seeds, "limits": found}, indent=1) + "\n")
    for label, limit in found.items():
        print(f"{label:34s} {limit['value']} (u = {limit['strength']}, {limit['cases']} cases)")


if __name__ == "__main__":
    main()
