"""Tyre relaxation: the side force builds up over a travelled length."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    arrays.set_axle(effect.options["axle"], "relaxation", effect.values["length_m"])


MODULE = Module(
    id="tyre_relaxation",
    title="Tyre relaxation length",
    equation="(sigma / v_x) d(alpha')/dt + alpha' = alpha; F_y = F_y(alpha')",
    source="Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, Eq. 7.7 (single-point contact model)",
    enters="slip angle of each wheel of the axle, before the tyre force; below 0.02 m none",
    parameters=(PhysicsParameter("length_m", "m", 0.0, 3.0, 0.5, meaning="sigma"),),
    options={
        "axle": ("car_rear", "car_front", "trailer", "trailer_front", "trailer_rear", "car", "all")
    },
    apply=_apply,
)
