"""Roll steer: wheels of an axle turn with the roll of their body."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    arrays.set_axle(effect.options["axle"], "roll_steer", effect.values["coefficient"])


MODULE = Module(
    id="roll_steer",
    title="Roll steer",
    equation="delta = k phi; phi > 0 leans right (ISO 8855), as in a left turn",
    source="Wu, Yaw/roll motions of a multiple steering articulated vehicle, IMechE D 215, 2001",
    enters="wheel angle of the axle, from the roll angle of its body",
    parameters=(PhysicsParameter("coefficient", "rad/rad", -0.5, 0.5, 0.05, meaning="k"),),
    options={"axle": ("car_rear", "trailer", "car_front", "trailer_front", "trailer_rear")},
    apply=_apply,
)
