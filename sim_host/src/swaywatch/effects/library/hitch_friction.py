"""Dry friction of the hitch (friction stabiliser): a moment against the articulation rate."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    plant.scalar("hitch_friction", values["moment_nm"])
    plant.scalar("hitch_sticking", values["sticking_rad_s"])


def _report(values: Values) -> dict[str, float]:
    return {"moment_nm": values["moment_nm"]}


EFFECTS = [
    Effect(
        id="hitch_friction",
        component="hitch",
        kind="physics",
        equation="M = moment sign(articulation rate), on the car, opposite on the trailer",
        source="Coulomb friction",
        parameters=(
            Parameter("moment_nm", "Nm", 0.0, 0.0, 5000.0, (100.0,), 2.0, 5.0),
            # how a ball sticks before it slips differs; it shows as the sway dies out
            Parameter("sticking_rad_s", "rad/s", 0.01, 0.001, 0.04, (0.01,), 0.001, 1e9),
        ),
        report=_report,
        act=_act,
        lines=("f", "3f"),
        decided_by="hitch moment at two amplitudes",
    )
]
