"""Roll stiffness of a body differs from the user's simulation.

A stiffer body rolls less and earlier: load transfer changes in phase with the roll, and where one
end became stiffer than the other, load moves between the axles.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from swaywatch.diagnose.effect import Effect, Parameter, Values, Window
from swaywatch.diagnose.modules.damper_fade import STIFFNESS, side_effect
from swaywatch.diagnose.plant import PlantInput
from swaywatch.diagnose.runs import Run


def _act(body: str) -> Callable[[PlantInput, Run, Values, Sequence[Window]], None]:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        shift = run.simulated.get(f"shift_{body}", np.zeros(run.time.size))
        plant.add_series(f"shift_{body}_front", 0.5 * values["front_share"] * shift)
        plant.add_series(f"shift_{body}_rear", 0.5 * values["rear_share"] * shift)
        side_effect(plant, run, values)

    return act


def _report(values: Values) -> dict[str, float]:
    # half of the roll moment is carried by each axle: what one gains the other loses
    moved = 0.5 * (values["front_share"] - values["rear_share"])
    total = values["front_share"] + values["rear_share"]
    return {"factor": float(1.0 + 2.0 * abs(moved) + total / 0.08)}


EFFECTS = [
    Effect(
        id="roll_stiffness_change",
        component=body,
        kind="physics",
        equation="load transfer of each axle changes in phase with the roll",
        source="balance of roll moments",
        parameters=(
            Parameter("front_share", "-", 0.0, -0.9, 0.9, (0.02,), 0.002, 0.008),
            Parameter("rear_share", "-", 0.0, -0.9, 0.9, (0.02,), 0.002, 0.008),
            STIFFNESS,
        ),
        act=_act(body),
        needs=("wheel_vertical_load_fl", "trailer_wheel_vertical_load_fl"),
        decided_by="roll angle of the body",
        report=_report,
        extra={"needs_simulation": True},
    )
    for body in ("car", "trailer")
]
