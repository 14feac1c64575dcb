"""A banked stretch of road: gravity has a lateral part on both bodies."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from swaywatch.diagnose.effect import Effect, Parameter, Values, Window
from swaywatch.diagnose.modules.crosswind_gust import PULSE_S, SHAPES, ramp
from swaywatch.diagnose.plant import PlantInput
from swaywatch.diagnose.runs import Run


def _act(shape: str, sensing: str) -> Callable[[PlantInput, Run, Values, Sequence[Window]], None]:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del values
        plant.scalar("bank_unsensed", 1.0 if sensing else 0.0)
        for window in windows:
            angle = np.radians(window.values["angle_deg"])
            plant.add_series("bank", angle * SHAPES[shape](window, run.time))

    return act


EFFECTS = [
    Effect(
        id="road_bank",
        component="road",
        kind="physics",
        equation=f"-m g sin(angle) on both bodies, {shape.replace('_', ' ')} in time",
        source="ISO 8855 (positive: left side high); an accelerometer sees the specific force",
        parameters=(
            Parameter("angle_deg", "deg", 0.0, -15.0, 15.0, (1.0,), 0.05, 0.1), *ramp(shape),
        ),  # fmt: skip
        act=_act(shape, sensing),
        windowed=True,
        lines=("mean", "broadband"),
        decided_by="height profile of the road",
        extra={"form": shape + sensing, "pulse_s": PULSE_S},
    )
    for shape in SHAPES
    # inertial units with an attitude filter take gravity's part out
    for sensing in ("", "_motion")
]
