"""A banked stretch of road: gravity has a lateral part on both bodies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swaywatch.effects.effect import Act, Array, Effect, Parameter, Values, Window
from swaywatch.effects.library.crosswind_gust import PULSE_S, SHAPES, ramp
from swaywatch.effects.roll import lag
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import GRAVITY, PlantInput

#: Loads of car and trailer, and the roll they follow.
TRANSFERS = {"car": ("car_front", "car_rear"), "trailer": ("trailer_front", "trailer_rear")}


def _level_bodies(plant: PlantInput, tilt: Array) -> None:
    """Take out of the loads what the bodies' roll against the cross-fall moves; tilt in m/s2."""
    for body, axles in TRANSFERS.items():
        rolled = lag(tilt, plant.get(f"roll_frequency_{body}"), plant.get(f"roll_damping_{body}"))
        for axle in axles:
            plant.add_series(f"shift_{axle}", -plant.get(f"transfer_{axle}") * rolled)


def _act(shape: str, variant: str) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del values
        plant.scalar("bank_unsensed", 1.0 if "motion" in variant else 0.0)
        angle = np.zeros(run.time.size)
        for window in windows:
            angle += np.radians(window.values["angle_deg"]) * SHAPES[shape](window, run.time)
        plant.add_series("bank", angle)
        if "level" in variant and windows:
            _level_bodies(plant, GRAVITY * np.sin(angle))

    return act


EFFECTS = [
    Effect(
        id="road_bank",
        component="road",
        kind="physics",
        equation=f"-m g sin(angle) on both bodies, {shape.replace('_', ' ')} in time",
        source="ISO 8855 (positive: left side high); an accelerometer sees the specific force",
        parameters=(
            Parameter("angle_deg", "deg", 0.0, -15.0, 15.0, (1.0,), 0.05, 0.1),
            *ramp(shape),
        ),
        act=_act(shape, variant),
        windowed=True,
        lines=("mean", "broadband"),
        decided_by="height profile of the road",
        extra={"form": shape + variant, "pulse_s": PULSE_S},
    )
    # inertial units with an attitude filter take gravity's part out; a short or slow bank, or a
    # body that leans against it, leaves the wheel loads alone
    for shape, variant in (
        ("box", ""),
        ("box", "_motion"),
        ("half_sine", ""),
        ("half_sine", "_motion"),
        ("ramped", ""),
        ("ramped", "_motion"),
        ("ramped", "_level"),
        ("ramped", "_motion_level"),
    )
]
