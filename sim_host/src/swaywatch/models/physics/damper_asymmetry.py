"""Dampers that pull harder than they push: a source of axle load at twice the yaw frequency."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    ratio = effect.values["ratio"]
    arrays.set("heave", 1.0)
    arrays.set_axle(effect.options["axle"], "damper_asymmetry", (ratio - 1.0) / (ratio + 1.0))


MODULE = Module(
    id="damper_asymmetry",
    title="Rebound and compression damping differ",
    equation=(
        "F_d = c v (1 + a sign v), a = (ratio - 1)/(ratio + 1); in roll the two sides add up to "
        "a c |v|, an axle load at 2 f that the body's heave turns"
    ),
    source="Zhang 2015, Table 6-1, columns (2) and (3)",
    enters="wheel loads, roll and heave of the body over the axle",
    parameters=(PhysicsParameter("ratio", "1", 0.1, 10.0, 2.0, meaning="rebound / compression"),),
    options={
        "axle": ("car_rear", "car_front", "trailer", "trailer_front", "trailer_rear", "car", "all")
    },
    apply=_apply,
)
