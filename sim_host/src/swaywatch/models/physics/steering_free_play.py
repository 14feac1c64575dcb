"""Free play (backlash) between steering wheel and road wheels."""

from __future__ import annotations

import math

from swaywatch.models.compiled import inlined
from swaywatch.models.physics._base import Arrays, Effect, Module, Parameter


@inlined
def follow(output: float, wheel_angle: float, gap: float) -> float:
    """Angle behind the play in rad: it stays until one flank of the gap pushes it."""
    half = 0.5 * gap
    if wheel_angle - half > output:
        return wheel_angle - half
    if wheel_angle + half < output:
        return wheel_angle + half
    return output


def _apply(arrays: Arrays, effect: Effect) -> None:
    arrays.set("steering_gap", math.radians(effect.values["gap_deg"]))


MODULE = Module(
    id="steering_free_play",
    title="Steering free play",
    equation="delta' = min(max(delta', delta_H - gap/2), delta_H + gap/2)",
    source="play operator, e.g. Visintin, Differential Models of Hysteresis, 1994",
    enters="steering-wheel angle before the steering ratio; gap is the whole play at the wheel rim",
    parameters=(
        Parameter("gap_deg", "deg", 0.0, 30.0, 4.0, meaning="whole play at the steering wheel"),
    ),
    apply=_apply,
)
