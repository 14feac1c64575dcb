"""Banked road."""

from __future__ import annotations

import math

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter
from swaywatch.plant.layout import W_BANK


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    for window in effect.windows:
        arrays.windows.append((
            W_BANK, 0, window.start_s, window.stop_s,
            math.radians(window.values["angle_deg"]), 0.0, effect.values["rise_s"],
        ))  # fmt: skip


MODULE = Module(
    id="road_bank",
    title="Banked road",
    equation="F_y = -m g sin(bank) on car and trailer; bank > 0: left side high (ISO 8855)",
    source="ISO 8855:2011 (road bank angle); Mitschke, Dynamik der Kraftfahrzeuge",
    enters="lateral force at both COGs; an accelerometer sees g sin(bank) besides the motion",
    parameters=(
        PhysicsParameter("angle_deg", "deg", -10.0, 10.0, 1.5, windowed=True),
        PhysicsParameter("rise_s", "s", 0.0, 5.0, 0.0, meaning="time of rise and of fall"),
    ),
    apply=_apply,
)
