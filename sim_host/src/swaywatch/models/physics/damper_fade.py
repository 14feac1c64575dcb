"""A damper that has lost its force."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    side, factor = effect.options["side"], effect.values["factor"]
    arrays.set("heave", 1.0)
    if side in ("both", "left"):
        arrays.set_axle(effect.options["axle"], "damper_left", factor)
    if side in ("both", "right"):
        arrays.set_axle(effect.options["axle"], "damper_right", factor)


MODULE = Module(
    id="damper_fade",
    title="Faded damper",
    equation="F_d = factor c v at the wheels named; roll and heave lose that damping",
    source="Zhang 2015, Table 6-1; Dixon, The Shock Absorber Handbook, 2nd ed. 2007",
    enters="wheel loads, roll and heave of the body over the axle",
    parameters=(
        PhysicsParameter("factor", "1", 0.0, 2.0, 0.3, meaning="what is left of the force"),
    ),
    options={
        "axle": ("car_rear", "car_front", "trailer", "trailer_front", "trailer_rear", "car"),
        "side": ("both", "left", "right"),
    },
    apply=_apply,
)
