"""Dry friction at the hitch (stabiliser, pintle)."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    arrays.set("hitch_friction", effect.values["moment_nm"])
    arrays.set("hitch_friction_rate", effect.values["rate_scale_rad_s"])


MODULE = Module(
    id="hitch_friction",
    title="Dry friction at the hitch",
    equation="M = M_0 tanh(theta' / s), on the car; -M on the trailer",
    source="Sharp, Alonso Fernandez, Car-caravan snaking, Part 1, Proc. IMechE C 216, 2002",
    enters="yaw moment between car and trailer",
    parameters=(
        PhysicsParameter("moment_nm", "N m", 0.0, 3000.0, 100.0, meaning="M_0"),
        PhysicsParameter(
            "rate_scale_rad_s", "rad/s", 1e-3, 0.1, 0.01, meaning="s, smooths the sign"
        ),
    ),
    apply=_apply,
)
