"""A value of vehicle.toml is wrong; no physics is missing."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Act, Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import BODY, PlantInput


def _act(index: int) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del run, windows
        plant.body[index] *= values["factor"]

    return act


def _steering(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    plant.steer = plant.steer / values["factor"]


_FACTOR = Parameter("factor", "-", 1.0, 0.4, 2.5, (1.05,), 0.005, 0.006)

EFFECTS = [
    Effect(
        id="parameter_error",
        title="Wrong value in vehicle.toml",
        component=name,
        kind="parameter",
        equation="true value = factor x value of the file",
        source="the user's file",
        parameters=(_FACTOR,),
        act=_act(index),
        decided_by="weighing or measuring the value",
    )
    for index, name in enumerate(BODY)
    if not name.endswith("axle_load")
] + [
    Effect(
        id="parameter_error",
        title="Wrong value in vehicle.toml",
        component="car.steering_ratio",
        kind="parameter",
        equation="true value = factor x value of the file",
        source="the user's file",
        parameters=(_FACTOR,),
        act=_steering,
        decided_by="road-wheel angle measured at the wheel",
    )
]
