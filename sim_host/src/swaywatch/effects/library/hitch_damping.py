"""Viscous damping of the hitch: a moment in proportion to the articulation rate."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    plant.scalar("hitch_damping", values["coefficient_nms_per_rad"])


EFFECTS = [
    Effect(
        id="hitch_damping",
        component="hitch",
        kind="physics",
        equation="M = coefficient x articulation rate, on the car, opposite on the trailer",
        source="linear damper",
        parameters=(
            Parameter("coefficient_nms_per_rad", "Nms/rad", 0.0, 0.0, 5e4, (1e3,), 20.0, 40.0),
        ),
        act=_act,
        lines=("f",),
        decided_by="hitch moment at two amplitudes",
    )
]
