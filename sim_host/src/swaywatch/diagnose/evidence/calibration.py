"""How exact: errors of a fit turned into stated intervals.

The map was fitted to generated cases whose answers are known (`calibration.json` beside this file,
with its provenance) by ``tests/proof/blind/calibrate.py``; nothing else sets it. How sure a claim
is follows from the evidence alone (`evidence.py`).
"""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

TABLE = Path(__file__).with_name("calibration.json")
NINETY = 1.645
#: Marks effects found beside a user's simulation: the plant is then only a correction.
BESIDE = "/simulation"


@cache
def table() -> dict[str, Any]:
    """The fitted map."""
    found: dict[str, Any] = json.loads(TABLE.read_text())
    return found


def noise() -> float:
    """Factor on the errors of a fit."""
    return float(table()["intervals"]["noise"])


def form_share(name: str) -> float:
    """Share of an effect's size that the form of a right model costs, 90 %; see `interval`."""
    fitted = table()["intervals"]
    other = fitted["form_beside" if name.endswith(BESIDE) else "form_other"]
    return float(fitted["form"].get(name, other))


def interval(
    name: str,
    value: float,
    deviation: float,
    error: float,
    reached: float,
    *,
    assumed: float = 0.0,
    scatter: float = 0.0,
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
        Size of an independent sample of the residuals (`evidence.inflation`).
    assumed
        Share of the size that hangs on a value nobody measured, 90 %.
    scatter
        Standard deviation of the value over its windows: what was seen needs no factor.
    """
    form = max(form_share(name), assumed)
    whole = NINETY * noise() * error * math.sqrt(max(reached, 1.0))
    half = math.hypot(whole, form * abs(deviation), NINETY * scatter)
    return {
        "value": float(value), "low": float(value - half), "high": float(value + half),
        "standard_error": float(error * math.sqrt(max(reached, 1.0))),
        "deviation": float(deviation), **({"scatter": scatter} if scatter else {}),
    }  # fmt: skip
