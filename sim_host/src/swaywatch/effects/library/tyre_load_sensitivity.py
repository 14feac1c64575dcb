"""Tyre load sensitivity: the stiffness grows less than in proportion to the wheel load."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    plant.scalar("degression", plant.get("degression") + values["degression"])
    for axle in ("front", "rear"):
        slot = f"transfer_trailer_{axle}"
        plant.scalar(slot, plant.get(slot) * values["trailer_transfer"])


def _report(values: Values) -> dict[str, float]:
    return {"degression": values["degression"]}


EFFECTS = [
    Effect(
        id="tyre_load_sensitivity",
        component="all",
        kind="physics",
        equation="C = C_0 (F_z/F_z0) (1 - degression (F_z/F_z0 - 1)) at each wheel",
        source="section 6.3 leaves it open",
        parameters=(
            Parameter("degression", "-", 0.0, -0.5, 2.0, (0.2,), 0.01, 0.04),
            # the trailer's wheel loads are seldom recorded: its transfer is fitted with it
            Parameter("trailer_transfer", "-", 1.0, 0.6, 1.6, (1.0,), 0.05, 1e9),
        ),
        report=_report,
        act=_act,
        lines=("f", "3f"),
        decided_by="lateral force of left and right wheel apart",
    )
]
