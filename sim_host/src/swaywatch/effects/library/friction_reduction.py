"""The road's peak friction falls for a time while the stiffness stays."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del values
    if plant.get("peak_friction_inverse") == 0.0:
        plant.scalar("peak_friction_inverse", 1.0)  # a dry road below tyres believed linear
    for window in windows:
        plant.add_series("friction", (window.values["factor"] - 1.0) * window.mask(run.time))


EFFECTS = [
    Effect(
        id="friction_reduction",
        component="road",
        kind="physics",
        equation="mu = factor x mu_0 in the windows, C unchanged",
        source="characteristic of `tyre_saturation`",
        parameters=(Parameter("factor", "-", 1.0, 0.15, 1.5, (0.7,), 0.02, 0.1),),
        act=_act,
        windowed=True,
        lines=("f", "3f"),
        decided_by="a run at higher lateral acceleration on the same road",
        extra={"needs_simulation": True},
    )
]
