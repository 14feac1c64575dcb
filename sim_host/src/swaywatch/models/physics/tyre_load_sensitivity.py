"""Load sensitivity: cornering stiffness grows less than proportionally with wheel load."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    arrays.set_axle(effect.options["axle"], "degression", effect.values["degression"])


MODULE = Module(
    id="tyre_load_sensitivity",
    title="Degressive cornering stiffness over wheel load",
    equation="C(F_z) = C_0 (F_z/F_z0) (1 - k (F_z/F_z0 - 1))",
    source="Zhang 2015, 6.3 (Fig. 6-7); parabola of Gillespie, Fundamentals of Vehicle Dynamics",
    enters="cornering stiffness of each wheel; load transfer then lowers that of the axle",
    parameters=(PhysicsParameter("degression", "1", 0.0, 1.5, 0.2, meaning="k"),),
    options={
        "axle": ("all", "car", "trailer", "car_front", "car_rear", "trailer_front", "trailer_rear")
    },
    apply=_apply,
)
