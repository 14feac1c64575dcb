"""Tyre relaxation: the force follows the slip over a length of road."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from swaywatch.diagnose.effect import Effect, Parameter, Values, Window
from swaywatch.diagnose.plant import PlantInput
from swaywatch.diagnose.runs import Run


def _act(slot: str) -> Callable[[PlantInput, Run, Values, Sequence[Window]], None]:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del run, windows
        plant.scalar(slot, max(plant.get(slot) + values["length_m"], 0.13))

    return act


EFFECTS = [
    Effect(
        id="tyre_relaxation",
        component=axle,
        kind="physics",
        equation="(length/v) dF_y/dt + F_y = C alpha",
        source="Pacejka, first-order relaxation",
        parameters=(Parameter("length_m", "m", 0.0, 0.13, 3.0, (0.4,), 0.02, 0.16),),
        act=_act(f"relaxation_{axle}"),
        decided_by="step of slip at two speeds: the lag is a length, not a time",
    )
    for axle in ("car_front", "car_rear", "trailer")
]
