"""How sure, and how exact: evidence and errors turned into stated confidence and intervals.

Both maps were fitted to generated cases whose answers are known (`calibration.json` beside this
file, with its provenance) by ``tests/proof/blind/calibrate.py``; nothing else sets them.
"""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

TABLE = Path(__file__).with_name("calibration.json")
#: Share of what an effect explains that the form of a right model may leave.
FORM_SHARE = 0.002
#: Differences of level below this share of it are chance.
CHANCE_SHARE = 0.004
NINETY = 1.645
#: Marks effects found beside a user's simulation: the plant is then only a correction.
BESIDE = "/simulation"


@cache
def table() -> dict[str, Any]:
    """The fitted maps."""
    found: dict[str, Any] = json.loads(TABLE.read_text())
    return found


def separation(base: float, reached: float, rival: float) -> float:
    """Logarithm of how far the best rival lies behind, in units of what a right model leaves.

    All three are levels (mean squared normalised residuals): of no explanation, of the claimed
    one, of the best other one that is not its equal.
    """
    left = CHANCE_SHARE * reached + FORM_SHARE * max(base - reached, 0.0)
    left += 0.2 * max(reached - 1.15, 0.0)
    return math.log(max(rival - reached, 0.01 * left) / left)


def stated(score: float, *, shared: bool) -> float:
    """Probability that the first name is right; `shared`: others explain it as well."""
    fitted = table()["confidence"]
    x = fitted["offset"] + fitted["slope"] * score - (fitted["shared"] if shared else 0.0)
    return min(1.0 / (1.0 + math.exp(-x)), float(fitted["most"]))


def interval(
    name: str, value: float, deviation: float, error: float, reached: float, assumed: float = 0.0
) -> dict[str, Any]:
    """90 % interval of a value.

    Parameters
    ----------
    name
        Id of the effect; with `BESIDE` where it was found beside a user's simulation.
    value, deviation
        As reported, and its distance from where the effect vanishes.
    error
        Standard error of the fit, as if noise were white and the model exact.
    reached
        Level of the fit.
    assumed
        Share of the size that hangs on a value nobody measured, 90 %.
    """
    fitted = table()["intervals"]
    noise = float(fitted["noise"])
    forms = fitted["form"]
    other = fitted["form_beside" if name.endswith(BESIDE) else "form_other"]
    form = max(float(forms.get(name, other)), assumed)
    half = math.hypot(NINETY * noise * error * math.sqrt(max(reached, 1.0)), form * abs(deviation))
    return {
        "value": float(value), "low": float(value - half), "high": float(value + half),
        "standard_error": float(error * math.sqrt(max(reached, 1.0))),
        "deviation": float(deviation),
    }  # fmt: skip
