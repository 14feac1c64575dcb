"""Tyre saturation: the side force falls below linear as slip grows."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    arrays.set_axle(effect.options["axle"], "peak_friction", effect.values["peak_friction"])
    arrays.set("saturation_shape", effect.values["shape"])


MODULE = Module(
    id="tyre_saturation",
    title="Tyre saturation",
    equation="F_y = mu F_z sin(C atan(C_alpha alpha / (C mu F_z)))",
    source="Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, Eq. 4.6 (E = 0)",
    enters="side force of each wheel from its slip angle, stiffness and load",
    parameters=(
        PhysicsParameter("peak_friction", "1", 0.3, 3.0, 1.0, meaning="mu, peak of |F_y|/F_z"),
        PhysicsParameter("shape", "1", 1.0, 1.9, 1.35, meaning="C, shape factor"),
    ),
    options={
        "axle": ("all", "car", "trailer", "car_front", "car_rear", "trailer_front", "trailer_rear")
    },
    apply=_apply,
)
