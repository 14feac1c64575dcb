"""Rebound and compression damping that differ more than in the user's simulation.

In roll one damper of the axle extends while the other is compressed: what they differ by adds up
to an axle load at twice the yaw frequency, turned by the body's heave.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from swaywatch.effects.effect import Act, Array, Effect, Parameter, Values, Window
from swaywatch.effects.library.damper_fade import (
    OTHER,
    ROLL_DAMPING_S,
    STIFFNESS,
    rectified,
    side_effect,
)
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(axle: str) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        part = rectified(run, axle)
        load = values["in_phase_s"] * part.real + values["quadrature_s"] * part.imag
        plant.add_series(f"heave_{axle}", load)
        side_effect(plant, run, values)

    return act


def _observe(axle: str) -> Callable[[dict[str, Array], Run, Values], None]:
    def observe(outputs: dict[str, Array], run: Run, values: Values) -> None:
        part = rectified(run, axle)
        outputs["hitch_vertical_force"] = (
            outputs["hitch_vertical_force"]
            + values["hitch_in_phase_s"] * part.real
            + values["hitch_quadrature_s"] * part.imag
        )

    return observe


def _size(values: Values) -> float:
    """Asymmetry a: at 1 the damper gives no force at all one way."""
    return float(np.hypot(values["in_phase_s"], values["quadrature_s"])) / ROLL_DAMPING_S


def _possible(values: Values) -> bool:
    return _size(values) < 1.0


def _report(values: Values) -> dict[str, float]:
    size = min(_size(values), 0.9)
    return {"ratio": (1.0 + size) / (1.0 - size)}


_PARTS = (
    ("in_phase_s", 0.0012),
    ("quadrature_s", 0.0012),
    ("hitch_in_phase_s", 1e9),
    ("hitch_quadrature_s", 1e9),
)

EFFECTS = [
    Effect(
        id="damper_asymmetry",
        component=axle,
        kind="physics",
        equation="F_z of the axle gains a c |roll rate|, a = (ratio - 1)/(ratio + 1)",
        source="Table 6-1, columns (2) and (3)",
        parameters=(
            *(Parameter(name, "s", 0.0, -0.1, 0.1, (0.001,), 1e-4, low) for name, low in _PARTS),
            STIFFNESS,
        ),
        act=_act(axle),
        observe=_observe(axle),
        lines=("2f",),
        needs=("wheel_vertical_load_fl", "hitch_vertical_force"),
        decided_by="damper force or suspension travel",
        report=_report,
        extra={"needs_simulation": True, "follows_motion": True, "possible": _possible},
    )
    for axle in OTHER
]
