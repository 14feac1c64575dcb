"""Dry friction of the hitch (friction stabiliser): a moment against the articulation rate."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.diagnose.effect import Effect, Parameter, Values, Window
from swaywatch.diagnose.plant import PlantInput
from swaywatch.diagnose.runs import Run


def _act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    plant.scalar("hitch_friction", values["moment_nm"])


EFFECTS = [
    Effect(
        id="hitch_friction",
        component="hitch",
        kind="physics",
        equation="M = moment sign(articulation rate), on the car, opposite on the trailer",
        source="Coulomb friction",
        parameters=(Parameter("moment_nm", "Nm", 0.0, 0.0, 5000.0, (100.0,), 2.0, 5.0),),
        act=_act,
        lines=("f", "3f"),
        decided_by="hitch moment at two amplitudes",
    )
]
