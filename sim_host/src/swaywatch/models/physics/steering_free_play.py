"""Free play between steering wheel and road wheels."""

from __future__ import annotations

import math

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter

LAWS = ("backlash", "dead_zone", "castor")
"""Where the road wheels are inside the gap: where they were, straight, or where they roll to."""


def follow(output: float, wheel_angle: float, gap: float, law: float) -> float:
    """Steering-wheel angle in rad that reaches the road wheels, from the one before.

    Laws 0 (backlash): it stays until one flank of the gap pushes it; 1 (dead zone): nothing within
    half a gap of straight ahead; 2 (castor): all of it, the gap is the plant's `free_play`.
    """
    half = 0.5 * gap
    if law == 2.0:
        return wheel_angle
    if law == 1.0:
        if wheel_angle > half:
            return wheel_angle - half
        return min(wheel_angle + half, 0.0)
    if wheel_angle - half > output:
        return wheel_angle - half
    return min(output, wheel_angle + half)


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    arrays.set("steering_gap", math.radians(effect.values["gap_deg"]))
    arrays.set("steering_gap_law", float(LAWS.index(effect.options["law"])))


MODULE = Module(
    id="steering_free_play",
    title="Steering free play",
    equation=(
        "backlash: delta' = min(max(delta', delta_H - gap/2), delta_H + gap/2); dead_zone: "
        "delta' = delta_H -+ gap/2 outside, 0 inside; castor: delta_w = direction of travel within "
        "(delta_H -+ gap/2)/i_s"
    ),
    source="play operator, e.g. Visintin, Differential Models of Hysteresis, 1994; castor: own",
    enters="steering-wheel angle before the steering ratio; gap is the whole play at the wheel rim",
    parameters=(
        PhysicsParameter(
            "gap_deg", "deg", 0.0, 30.0, 4.0, meaning="whole play at the steering wheel"
        ),
    ),
    options={"law": LAWS},
    apply=_apply,
)
