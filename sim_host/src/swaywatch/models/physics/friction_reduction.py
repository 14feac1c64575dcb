"""The road's peak friction falls, the tyres' stiffness does not."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter
from swaywatch.plant.layout import AXLES, W_FRICTION, A


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    for axle in range(len(AXLES)):
        if arrays.axles[axle, A["peak_friction"]] <= 0.0:
            arrays.axles[axle, A["peak_friction"]] = effect.values["dry_friction"]
    for window in effect.windows:
        arrays.windows.append((
            W_FRICTION, 0, window.start_s, window.stop_s, window.values["factor"], 0.0, 0.0
        ))  # fmt: skip


MODULE = Module(
    id="friction_reduction",
    title="Road friction reduced in time windows",
    equation="mu = factor mu_0 inside a window; C_alpha unchanged",
    source="Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, scaling factor lambda_mu",
    enters="peak friction of all wheels; on its own it brings tyre saturation with mu_0",
    parameters=(
        PhysicsParameter("factor", "1", 0.1, 1.0, 0.6, windowed=True),
        PhysicsParameter(
            "dry_friction", "1", 0.5, 2.0, 1.0, meaning="mu_0 where no saturation is set"
        ),
    ),
    apply=_apply,
)
