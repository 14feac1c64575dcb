"""Aerodynamic side force and yaw moment of the trailer."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    plant.scalar("aero_side", values["side_force_coefficient"])
    plant.scalar("aero_yaw", values["yaw_moment_coefficient"])


EFFECTS = [
    Effect(
        id="trailer_aerodynamics",
        component="trailer",
        kind="physics",
        equation="Y = -c_s q A beta, N = -c_n q A (1 m) beta, q = rho v^2 / 2, A = 5 m2",
        source="quasi-steady aerodynamics",
        parameters=(
            Parameter("side_force_coefficient", "-", 0.0, 0.0, 12.0, (1.0,), 0.05, 0.06),
            Parameter("yaw_moment_coefficient", "-", 0.0, -5.0, 10.0, (0.5,), 0.05, 0.1),
        ),
        act=_act,
        decided_by="the same manoeuvre at another speed: air forces grow with its square",
    )
]
