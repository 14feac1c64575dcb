"""An accelerometer rolls with its body and sees a part of gravity.

The roll is a second-order lag behind the lateral acceleration; its frequency and damping are
fitted with it, for a constant part of gravity alone would be a gain.
"""

from __future__ import annotations

from collections.abc import Callable

from swaywatch.diagnose.effect import Array, Effect, Parameter, Values
from swaywatch.diagnose.plant import GRAVITY
from swaywatch.diagnose.roll import lag
from swaywatch.diagnose.runs import Run


def _observe(channel: str) -> Callable[[dict[str, Array], Run, Values], None]:
    def observe(outputs: dict[str, Array], run: Run, values: Values) -> None:
        del run
        if channel in outputs:
            angle = values["roll_per_acceleration"] * lag(
                outputs[channel], values["roll_frequency_rad_s"], values["roll_damping"]
            )
            outputs[channel] = outputs[channel] + GRAVITY * angle

    return observe


EFFECTS = [
    Effect(
        id="sensor_roll_gravity",
        component=channel,
        kind="measurement",
        equation="measured = a_y + g roll, roll: second order behind a_y",
        source="fault of the mounting, no physics",
        parameters=(
            Parameter(
                "roll_per_acceleration", "rad per m/s2", 0.0, -0.05, 0.05, (0.008,), 0.0005, 0.001
            ),
            Parameter("roll_frequency_rad_s", "rad/s", 13.0, 4.0, 40.0, (13.0, 8.0), 0.2, 1e9),
            Parameter("roll_damping", "-", 0.112, 0.03, 1.5, (0.112, 0.3), 0.02, 1e9),
        ),
        observe=_observe(channel),
        decided_by="an inertial unit with a roll rate",
    )
    for channel in ("car_lateral_acceleration", "trailer_lateral_acceleration")
]
