"""Viscous damping at the hitch."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    arrays.set("hitch_damping", effect.values["coefficient_nms_per_rad"])


MODULE = Module(
    id="hitch_damping",
    title="Viscous damping at the hitch",
    equation="M = c theta', on the car; -M on the trailer",
    source="Sharp, Alonso Fernandez, Car-caravan snaking, Part 1, Proc. IMechE C 216, 2002",
    enters="yaw moment between car and trailer",
    parameters=(
        PhysicsParameter("coefficient_nms_per_rad", "N m s/rad", 0.0, 2e4, 500.0, meaning="c"),
    ),
    apply=_apply,
)
