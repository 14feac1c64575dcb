"""Side force of the car's axles reaches its body with a lag (suspension compliance)."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    arrays.set("suspension_lag", effect.values["lag_s"])


MODULE = Module(
    id="suspension_lag",
    title="Suspension lag of the car",
    equation="T d(F_y, M_z)/dt + (F_y, M_z) = tyre forces",
    source="Zhang 2015, 5.2.6 (about 20 deg at 0.67 Hz in the car's yaw inertia: T about 0.09 s)",
    enters="side force and yaw moment of the car's tyres on its body",
    parameters=(PhysicsParameter("lag_s", "s", 0.0, 0.3, 0.05, meaning="T"),),
    apply=_apply,
)
