"""An accelerometer rolls with its body and sees a part of gravity."""

from __future__ import annotations

from collections.abc import Callable

from swaywatch.diagnose.effect import Array, Effect, Parameter, Values
from swaywatch.diagnose.plant import GRAVITY
from swaywatch.diagnose.runs import Run


def _observe(channel: str, roll: str) -> Callable[[dict[str, Array], Run, Values], None]:
    def observe(outputs: dict[str, Array], run: Run, values: Values) -> None:
        del run
        if channel in outputs:
            outputs[channel] = (
                outputs[channel] + GRAVITY * values["roll_per_acceleration"] * outputs[roll]
            )

    return observe


EFFECTS = [
    Effect(
        id="sensor_roll_gravity",
        component=channel,
        kind="measurement",
        equation="measured = a_y + g roll",
        source="fault of the mounting, no physics",
        parameters=(
            Parameter(
                "roll_per_acceleration", "rad per m/s2", 0.0, -0.05, 0.05, (0.005,), 0.0005, 0.001
            ),
        ),
        observe=_observe(channel, roll),
        decided_by="an inertial unit with a roll rate",
    )
    for channel, roll in (
        ("car_lateral_acceleration", "car_roll_acceleration"),
        ("trailer_lateral_acceleration", "trailer_roll_acceleration"),
    )
]
