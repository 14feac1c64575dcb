"""Tyre relaxation: the force follows the slip over a length of road."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Act, Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput

#: Shortest length worth a claim, of one axle and of all at once.
LEAST_M = (0.05, 0.04)
AXLES = ("car_front", "car_rear", "trailer")


def _act(component: str) -> Act:
    axles = AXLES if component == "all" else (component,)

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del run, windows
        for axle in axles:
            slot = f"relaxation_{axle}"
            plant.scalar(slot, plant.get(slot) + values["length_m"])

    return act


EFFECTS = [
    Effect(
        id="tyre_relaxation",
        component=axle,
        kind="physics",
        equation="(length/v) dF_y/dt + F_y = C alpha",
        source="Pacejka, first-order relaxation",
        parameters=(
            Parameter("length_m", "m", 0.0, 0.0, 3.0, (0.4,), 0.02, LEAST_M[axle == "all"]),
        ),
        act=_act(axle),
        decided_by="step of slip at two speeds: the lag is a length, not a time",
    )
    for axle in (*AXLES, "all")
]
