"""Steering compliance: the road-wheel angle falls with the front lateral force (Eq. 5.3)."""

from __future__ import annotations

from collections.abc import Sequence

from swaywatch.effects.effect import Effect, Parameter, Values, Window
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import PlantInput


def _act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
    del run, windows
    plant.scalar("steering_flexibility", values["flexibility"])


EFFECTS = [
    Effect(
        id="steering_compliance",
        component="car_front",
        kind="physics",
        equation="delta_road = delta_wheel / i_s - F_yf / K_s",
        source="Eq. 5.3",
        parameters=(Parameter("flexibility", "rad/N", 0.0, 0.0, 1e-5, (1e-6,), 1e-7, 1e-7),),
        act=_act,
        decided_by="road-wheel angle measured at the wheel",
        # every steering is elastic; tyres that are too soft look the same in every planar signal
        plausibility=1.0,
        report=lambda v: {"stiffness_n_per_rad": 1.0 / max(v["flexibility"], 1e-12)},
    )
]
