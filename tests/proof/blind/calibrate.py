"""Fit the map of `diagnose/evidence/calibration.json` to generated cases whose answers are known.

    python calibrate.py --set ANSWERS DIAGNOSES [--set ...] --seeds 101 202 --out calibration.json

Never with the seed of the proof: the map would be fitted to the cases it is judged on.

Intervals: the error of a
parameter is taken as normal, its variance that of the fit times a common factor plus a share of
the effect's size, one for each effect ("form": what the shape of a right model costs).
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from score import load, located, measured_harmonic, numbers

from swaywatch.diagnose.evidence.calibration import BESIDE

Array = NDArray[np.float64]
Json = dict[str, Any]
PROOF_SEED = 20261121
NINETY = 1.645
HEAVY = 2.132 / NINETY  # 90 % of Student's t with 4 degrees of freedom, over those of a normal
FORM_PRIOR = 0.05  # typical form error of a reduced model, with a factor of e either way


def pairs(answers: Path, diagnoses: Path) -> list[tuple[Json, Json]]:
    """Answer and diagnosis of each case that has both."""
    found = []
    for path in sorted(answers.glob("*/answer.json")):
        diagnosis = load(diagnoses / path.parent.name / "diagnosis.json")
        answer = load(path)
        if answer and diagnosis and diagnosis.get("evidence"):
            found.append((answer, diagnosis))
    return found


def deviations(cases: list[tuple[Json, Json]]) -> dict[str, list[tuple[float, float, float]]]:
    """By effect: (error, standard error, size) of each parameter of a rightly named effect."""
    found: dict[str, list[tuple[float, float, float]]] = defaultdict(list)
    for answer, diagnosis in cases:
        for truth, component in zip(answer["effects"], answer["components"], strict=True):
            true = truth
            if truth["id"] == "axle_load_harmonic":
                true = truth | measured_harmonic(answer)
            for effect in diagnosis["effects"]:
                if effect["id"] != truth["id"] or not located(effect, truth, component):
                    continue
                key = truth["id"] + (BESIDE if answer["simulation"] else "")
                for name, value in numbers(true).items():
                    said = effect["parameters"].get(name)
                    if said and "standard_error" in said:
                        error = said["value"] - value
                        own = math.hypot(said["standard_error"], said.get("scatter", 0.0))
                        found[key].append((error, own, abs(said["deviation"])))
    return dict(found)


def intervals(found: dict[str, list[tuple[float, float, float]]]) -> Json:
    """Factor on the errors of the fit, and share of the size for each effect."""
    names = sorted(found)

    def cost(x: Array) -> float:
        noise, forms = np.exp(x[0]), np.exp(x[1:])
        total = 0.5 * (x[0] - np.log(2.0)) ** 2
        for name, form in zip(names, forms, strict=True):
            error, se, size = np.array(found[name]).T
            sigma = np.hypot(noise * se, form / NINETY * size) + 1e-12
            # Student's t with 4 degrees of freedom: one wild case must not widen all intervals
            z = (error / sigma) ** 2
            total += float(np.sum(np.log(sigma) + 2.5 * np.log1p(z / 4.0)))
            total += 0.5 * float(np.log(form / FORM_PRIOR)) ** 2
        return total

    start = np.concatenate([[np.log(2.0)], np.full(len(names), np.log(FORM_PRIOR))])
    best = minimize(cost, start, method="L-BFGS-B").x
    forms = {
        name: round(HEAVY * float(np.exp(x)), 4) for name, x in zip(names, best[1:], strict=True)
    }
    return {
        "noise": round(HEAVY * float(np.exp(best[0])), 3),
        "form_other": _typical(forms, beside=False),
        "form_beside": _typical(forms, beside=True),
        "form": forms,
    }


def _typical(forms: dict[str, float], *, beside: bool) -> float:
    """Share for effects of which no case was generated: the median of those of their kind."""
    known = [form for name, form in forms.items() if name.endswith(BESIDE) == beside]
    return round(float(np.median(known)), 4) if known else FORM_PRIOR


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--set", nargs=2, type=Path, action="append", required=True)
    parser.add_argument("--seeds", nargs="+", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    if PROOF_SEED in given.seeds:
        sys.exit(f"{PROOF_SEED} is the seed of the proof: calibrate on others")
    cases = [case for answers, diagnoses in given.set for case in pairs(answers, diagnoses)]
    if not cases:
        sys.exit("no case has both an answer and a diagnosis with its evidence")
    found = deviations(cases)
    table = {
        "provenance": {
            "command": "tests/proof/blind/calibrate.py",
            "seeds": given.seeds,
            "cases": len(cases),
            "parameters": dict(Counter({name: len(rows) for name, rows in found.items()})),
        },
        "intervals": intervals(found),
    }
    given.out.write_text(json.dumps(table, indent=1) + "\n")
    print(json.dumps(table, indent=1))


if __name__ == "__main__":
    main()
