"""Cornering stiffness of an axle changes with no change of load (pressure, road surface)."""

from __future__ import annotations

from swaywatch.models.physics._base import (
    Arrays,
    Module,
    PhysicsEffect,
    PhysicsParameter,
    axle_numbers,
)
from swaywatch.plant.layout import W_STIFFNESS


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    for window in effect.windows:
        for axle in axle_numbers(effect.options["axle"]):
            arrays.windows.append((
                W_STIFFNESS, axle, window.start_s, window.stop_s, window.values["factor"], 0.0, 0.0
            ))  # fmt: skip


MODULE = Module(
    id="tyre_stiffness_change",
    title="Cornering stiffness of an axle changed in time windows",
    equation="C = factor C_0 inside a window",
    source="Zhang 2015, 4.4.2 (normalised stiffness, Eq. 4.16)",
    enters="cornering stiffness of both wheels of the axle",
    parameters=(PhysicsParameter("factor", "1", 0.3, 2.0, 0.9, windowed=True),),
    options={
        "axle": ("car_rear", "car_front", "trailer", "trailer_front", "trailer_rear", "car", "all")
    },
    apply=_apply,
)
