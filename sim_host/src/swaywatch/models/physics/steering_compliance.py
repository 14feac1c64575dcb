"""Elastic steering: the front wheels turn back under their own lateral force."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    arrays.set("steering_stiffness", effect.values["stiffness_n_per_rad"])


MODULE = Module(
    id="steering_compliance",
    title="Steering compliance",
    equation="delta_w = delta_H / i_s - (F_y,fl + F_y,fr) / K_s",
    source="Zhang 2015, Eq. 5.3-5.7 (K_s = 1437 kN/rad for the road test's car)",
    enters="road-wheel angle of both front wheels, solved together with the front tyre force",
    parameters=(PhysicsParameter("stiffness_n_per_rad", "N/rad", 1e5, 1e8, 1.4e6, meaning="K_s"),),
    apply=_apply,
)
