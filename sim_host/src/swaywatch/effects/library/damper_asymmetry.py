"""Rebound and compression damping that differ more than in the user's simulation.

In roll one damper of the axle extends while the other is compressed: what they differ by adds up
to an axle load at twice the yaw frequency, which lifts and drops the body.
"""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Act, Effect, Parameter, Values, Window
from swaywatch.effects.library.damper_fade import (
    ASIDE,
    ASSUMED_SHARE,
    AXLES,
    observe_hitch,
    side_effect,
)
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput

#: Asymmetry of usual dampers, (rebound - compression) / (rebound + compression).
USUAL = 0.25


def _act(place: str) -> Act:
    body = place.split("_", maxsplit=1)[0]
    slots = [f"damper_changed_{axle}" for axle in AXLES[place]]

    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del windows
        for slot in slots:
            plant.scalar(slot, values["asymmetry"] - plant.get(f"damper_asymmetry_{body}"))
        side_effect(plant, run, values)

    return act


def _report(values: Values) -> dict[str, float]:
    return {"ratio": (1.0 + values["asymmetry"]) / (1.0 - values["asymmetry"])}


EFFECTS = [
    Effect(
        id="damper_asymmetry",
        component=place,
        kind="physics",
        equation="each damper's force times 1 + a sign(rate), a = (ratio - 1)/(ratio + 1)",
        source="Table 6-1, columns (2) and (3)",
        parameters=(
            Parameter("asymmetry", "-", USUAL, -0.9, 0.9, (0.5, 0.0), 0.01, 0.05),
            *ASIDE,
        ),
        act=_act(place),
        observe=observe_hitch(place),
        lines=("2f",),
        decided_by="damper force or suspension travel",
        report=_report,
        extra={"needs_simulation": True, "needs_springs": True, "assumed_share": ASSUMED_SHARE},
    )
    for place in AXLES
]
