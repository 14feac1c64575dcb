"""Sets beside the user's own simulation: two effects at once, and the dampers of Table 6-1.

The user's simulation has the "normal" dampers of Table 6-1; of one axle the recording has another
kind of the five. A kind counts as found where `damper_fade` or `damper_asymmetry` is claimed at
that axle, or named among what cannot be distinguished from the claim.
"""

from __future__ import annotations

from dataclasses import replace

import effects
from effects import AXLE_NUMBERS, Draw, change_axle
from numpy.random import Generator

from swaywatch.models.multibody_vehicle import Combination

KINDS = ("linear", "bilinear", "failure_1", "failure_2")
#: Strengths of two effects at once: well above what can be named alone, mostly.
STRONG = (0.6, 1.0)


def damper_kind(rng: Generator, index: int) -> Draw:
    """Dampers of another kind of Table 6-1 at one axle; every fifth case: less friction."""
    if index % (len(KINDS) + 1) == len(KINDS):
        return effects.friction_reduction(rng, float(rng.uniform(0.5, 1.0)))
    kind = KINDS[index % (len(KINDS) + 1)]
    axle = str(rng.choice(("car_front", "car_rear", "trailer")))

    def combination(whole: Combination) -> Combination:
        for number in AXLE_NUMBERS[axle]:
            whole = change_axle(
                whole, number, lambda a: replace(a, damper=replace(a.damper, kind=kind))
            )
        return whole

    return Draw(
        {"id": "damper_kind", "axle": axle, "kind": kind},
        axle, combination=combination, vertical=True, outside=True,
    )  # fmt: skip


def pair(rng: Generator) -> list[Draw]:
    """Two effects of different kinds."""
    ids = list(dict.fromkeys(effects.WITH_SIMULATION))
    found = []
    for number in rng.choice(len(ids), 2, replace=False):
        strength = float(rng.uniform(*STRONG))
        draw: Draw = ids[int(number)](rng, strength)
        draw.strength = strength
        found.append(draw)
    return found


def draw(which: str, rng: Generator, index: int) -> list[Draw]:
    """The effects of a case of a set."""
    return pair(rng) if which == "pairs" else [damper_kind(rng, index)]


SETS = ("pairs", "dampers")
