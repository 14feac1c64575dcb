"""Elastic drawbar: the trailer gives way sideways to the force at the ball."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    arrays.set("drawbar_stiffness", effect.values["stiffness_n_per_m"])


MODULE = Module(
    id="drawbar_compliance",
    title="Elastic drawbar",
    equation="y = F_y / K, of the trailer past the ball, across the trailer",
    source="spring in series with the ball, with a loss of 5 ms of its stiffness",
    enters="place of the ball across the trailer",
    parameters=(PhysicsParameter("stiffness_n_per_m", "N/m", 1e4, 1e8, 2e5, meaning="K"),),
    apply=_apply,
)
