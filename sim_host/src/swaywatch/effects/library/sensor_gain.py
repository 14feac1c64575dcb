"""A channel reports too much or too little."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from swaywatch.effects.effect import Array, Effect, Parameter, Values, Window
from swaywatch.effects.runs import FAULT_CHANNELS, Run
from swaywatch.plant.lanes import PlantInput

_FACTOR = Parameter("factor", "-", 1.0, 0.3, 3.0, (1.05,), 0.005, 0.006)


def _observe(channels: tuple[str, ...]) -> Callable[[dict[str, Array], Run, Values], None]:
    def observe(outputs: dict[str, Array], run: Run, values: Values) -> None:
        for channel in channels:
            if channel in outputs:
                outputs[channel] = outputs[channel] * values["factor"]

    return observe


def _undo(measured: Array, run: Run, values: Values) -> Array:
    del run
    return measured / values["factor"]


def _steering(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del windows
    plant.steer = plant.steer / values["factor"]


def _speed(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    plant.speed = plant.speed / values["factor"]
    plant.acceleration = plant.acceleration / values["factor"]


EFFECTS = [
    Effect(
        id="sensor_gain",
        title="Wrong gain of a sensor",
        component=group,
        kind="measurement",
        equation="measured = factor x true",
        source="fault of the measurement",
        parameters=(_FACTOR,),
        observe=_observe(channels),
        extra={"undo": _undo},
        decided_by="a second sensor of the same quantity",
    )
    for group, channels in FAULT_CHANNELS.items()
] + [
    Effect(
        id="sensor_gain",
        title="Wrong gain of a sensor",
        component=channel,
        kind="measurement",
        equation="measured = factor x true",
        source="fault of the measurement",
        parameters=(_FACTOR,),
        act=act,
        decided_by="a second sensor of the same quantity",
    )
    for channel, act in (("steering_wheel_angle", _steering), ("speed", _speed))
]
