"""A channel reports late."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from swaywatch.effects.effect import Array, Effect, Parameter, Values, Window
from swaywatch.effects.runs import FAULT_CHANNELS, Run
from swaywatch.plant.lanes import PlantInput

LEAST_S = 0.003  # that is worth a claim
#: Dampers let a wheel's load run ahead of the roll by up to twice the damping ratio over the roll
#: frequency, 20 to 40 ms, differently at each axle: known to about half of that.
LEAST_OF_A_LOAD_ON_SPRINGS_S = 0.02
_DELAY = Parameter("delay_s", "s", 0.0, -0.02, 0.4, (0.02,), 0.002, LEAST_S)
_LOAD_DELAY = replace(_DELAY, minimum=LEAST_OF_A_LOAD_ON_SPRINGS_S)


def shift(time: Array, value: Array, delay: float) -> Array:
    """`value` later by `delay`. Shapes (n,)."""
    return np.interp(time - delay, time, value)


def _observe(channels: tuple[str, ...]) -> Callable[[dict[str, Array], Run, Values], None]:
    def observe(outputs: dict[str, Array], run: Run, values: Values) -> None:
        for channel in channels:
            if channel in outputs:
                outputs[channel] = shift(run.time, outputs[channel], values["delay_s"])

    return observe


def _undo(measured: Array, run: Run, values: Values) -> Array:
    return shift(run.time, measured, -values["delay_s"])


def _steering(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del windows
    plant.steer = shift(run.time, plant.steer, -values["delay_s"])


def _effect(group: str, channels: tuple[str, ...]) -> Effect:
    found = Effect(
        id="sensor_delay",
        title="Signal delayed",
        component=group,
        kind="measurement",
        equation="measured(t) = true(t - delay)",
        source="fault of the measurement",
        parameters=(_DELAY,),
        observe=_observe(channels),
        extra={"undo": _undo},
        decided_by="a second sensor of the same quantity",
    )
    if not all("vertical_load" in channel for channel in channels):
        return found
    return replace(found, on_springs=replace(found, parameters=(_LOAD_DELAY,)))


EFFECTS = [_effect(group, channels) for group, channels in FAULT_CHANNELS.items()] + [
    Effect(
        id="sensor_delay",
        title="Signal delayed",
        component="steering_wheel_angle",
        kind="measurement",
        equation="measured(t) = true(t - delay)",
        source="fault of the measurement",
        parameters=(_DELAY,),
        act=_steering,
        decided_by="a second sensor of the same quantity",
    )
]
