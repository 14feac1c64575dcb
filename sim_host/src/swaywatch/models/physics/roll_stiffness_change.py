"""Roll stiffness of a body differs from what was believed."""

from __future__ import annotations

import math

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter
from swaywatch.plant.layout import BODIES


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    number = BODIES.index(effect.options["body"]) + 1
    factor = effect.values["factor"]
    arrays.set(f"roll_gain_{number}", arrays.get(f"roll_gain_{number}") / factor)
    for name, scale in (("omega", math.sqrt(factor)), ("zeta", 1.0 / math.sqrt(factor))):
        arrays.set(f"roll_{name}_{number}", arrays.get(f"roll_{name}_{number}") * scale)


MODULE = Module(
    id="roll_stiffness_change",
    title="Roll stiffness changed",
    equation="phi_steady / factor, omega_roll sqrt(factor), zeta_roll / sqrt(factor)",
    source="Zhang 2015, outlook and 2.1 (total roll stiffness x 10 gave +6 km/h of v_crit)",
    enters="roll of the body: load transfer in time, roll steer",
    parameters=(PhysicsParameter("factor", "1", 0.1, 20.0, 2.0),),
    options={"body": ("car", "trailer")},
    apply=_apply,
)
