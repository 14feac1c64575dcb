"""Side force and yaw moment of the air on the trailer's side-slip angle."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    arrays.set("aero_side_force", effect.values["side_force_coefficient"])
    arrays.set("aero_yaw_moment", effect.values["yaw_moment_coefficient"])


MODULE = Module(
    id="trailer_aerodynamics",
    title="Side force and yaw moment of the air on the trailer",
    equation="F_y = -c_s q A beta_2, M_z = -c_n q A (1 m) beta_2, q = rho v^2 / 2, A = 5 m2",
    source="Zhang 2015, 5.2.5 and 5.2.6; Standen, Towed vehicle aerodynamics, 1999",
    enters="force and moment at the trailer's COG, beta_2 = atan(v_y2 / v_x2)",
    parameters=(
        PhysicsParameter("side_force_coefficient", "1/rad", -2.0, 10.0, 1.5, meaning="c_s"),
        PhysicsParameter("yaw_moment_coefficient", "1/rad", -10.0, 10.0, 0.5, meaning="c_n"),
    ),
    apply=_apply,
)
