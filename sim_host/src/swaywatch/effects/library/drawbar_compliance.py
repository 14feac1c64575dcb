"""Elastic drawbar: the trailer gives way sideways to the force at the ball."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    plant.scalar("drawbar_compliance", values["compliance"])


EFFECTS = [
    Effect(
        id="drawbar_compliance",
        component="hitch",
        kind="physics",
        equation="y = F_y / K, of the trailer past the ball, across the trailer",
        source="spring in series with the ball, with a loss of 5 ms of its stiffness",
        parameters=(Parameter("compliance", "m/N", 0.0, 0.0, 1e-4, (1e-5, 3e-6), 1e-6, 2e-6),),
        act=_act,
        decided_by="the trailer pushed sideways at standstill, its front against the ball",
        report=lambda v: {"stiffness_n_per_m": 1.0 / max(v["compliance"], 1e-12)},
    )
]
