"""An accelerometer rolls with its body and sees a part of gravity.

The roll is a second-order lag behind the lateral acceleration; its frequency and damping are
fitted with it, for a constant part of gravity alone would be a gain.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from swaywatch.effects.effect import Array, Effect, Parameter, Values
from swaywatch.effects.roll import lag
from swaywatch.effects.runs import RATE_HZ, Run
from swaywatch.plant.lanes import GRAVITY


def _observe(channel: str) -> Callable[[dict[str, Array], Run, Values], None]:
    body = channel.split("_", maxsplit=1)[0]

    def _of_the_body(outputs: dict[str, Array], run: Run) -> Array:
        """A body rolls with the acceleration of its centre of gravity, wherever the sensor is."""
        ahead, yaw_rate = run.positions.get(channel, 0.0), outputs.get(f"{body}_yaw_rate")
        if ahead == 0.0 or yaw_rate is None:
            return outputs[channel]
        return np.asarray(outputs[channel] - ahead * np.gradient(yaw_rate) * RATE_HZ)

    def observe(outputs: dict[str, Array], run: Run, values: Values) -> None:
        if channel in outputs:
            angle = values["roll_per_acceleration"] * lag(
                _of_the_body(outputs, run), values["roll_frequency_rad_s"], values["roll_damping"]
            )
            outputs[channel] = outputs[channel] + GRAVITY * angle

    return observe


EFFECTS = [
    Effect(
        id="sensor_roll_gravity",
        title="Accelerometer that rolls with the body and measures part of gravity",
        component=channel,
        kind="measurement",
        equation="measured = a_y + g roll, roll: second order behind a_y",
        source="fault of the mounting, no physics",
        parameters=(
            Parameter(
                "roll_per_acceleration", "rad per m/s2", 0.0, -0.05, 0.05, (0.008,), 0.0005, 0.001
            ),
            Parameter("roll_frequency_rad_s", "rad/s", 13.0, 4.0, 40.0, (13.0, 8.0), 0.2, 1e9),
            Parameter("roll_damping", "-", 0.112, 0.05, 1.5, (0.112, 0.3), 0.02, 1e9),
        ),
        observe=_observe(channel),
        decided_by="an inertial unit with a roll rate",
    )
    for channel in ("car_lateral_acceleration", "trailer_lateral_acceleration")
]
