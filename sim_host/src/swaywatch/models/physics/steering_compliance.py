"""Elastic steering: the front wheels turn back under their own lateral force."""

from __future__ import annotations

from swaywatch.models.compiled import inlined
from swaywatch.models.physics._base import Arrays, Effect, Module, Parameter


@inlined
def angle_lost(front_lateral_force: float, stiffness: float) -> float:
    """Road-wheel angle lost in rad, Eq. 5.3; stiffness in N/rad, 0 is rigid."""
    if stiffness <= 0.0:
        return 0.0
    return front_lateral_force / stiffness


def _apply(arrays: Arrays, effect: Effect) -> None:
    arrays.set("steering_stiffness", effect.values["stiffness_n_per_rad"])


MODULE = Module(
    id="steering_compliance",
    title="Steering compliance",
    equation="delta_w = delta_H / i_s - (F_y,fl + F_y,fr) / K_s",
    source="Zhang 2015, Eq. 5.3-5.7 (K_s = 1437 kN/rad for the road test's car)",
    enters="road-wheel angle of both front wheels, solved together with the front tyre force",
    parameters=(Parameter("stiffness_n_per_rad", "N/rad", 1e5, 1e8, 1.4e6, meaning="K_s"),),
    apply=_apply,
)
