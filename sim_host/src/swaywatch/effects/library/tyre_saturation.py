"""Tyre saturation: the lateral force falls below linear towards the peak friction."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    plant.scalar("peak_friction_inverse", 1.0 / values["peak_friction"])


EFFECTS = [
    Effect(
        id="tyre_saturation",
        component="all",
        kind="physics",
        equation="F_y = mu F_z sin(c atan(C alpha / (c mu F_z))) at each wheel, c = 1.35",
        source="Pacejka, Tire and Vehicle Dynamics, Eq. 4.6 with E = 0",
        parameters=(Parameter("peak_friction", "-", 1e3, 0.3, 1e3, (1.0,), 0.02),),
        act=_act,
        lines=("f", "3f"),
        decided_by="a run at higher lateral acceleration",
    )
]
