"""Gust from the side on one body."""

from __future__ import annotations

from swaywatch.models.physics._base import Arrays, Module, PhysicsEffect, PhysicsParameter
from swaywatch.plant.layout import BODIES, W_GUST


def _apply(arrays: Arrays, effect: PhysicsEffect) -> None:
    body = BODIES.index(effect.options["body"])
    for window in effect.windows:
        force = window.values["force_n"]
        arrays.windows.append((
            W_GUST, body, window.start_s, window.stop_s,
            force, force * effect.values["arm_m"], effect.values["rise_s"],
        ))  # fmt: skip


MODULE = Module(
    id="crosswind_gust",
    title="Crosswind gust",
    equation="F_y = F inside a window, at arm_m ahead of the COG, rising and falling as a cosine",
    source="ISO 12021 (crosswind sensitivity), force instead of a fan",
    enters="side force and yaw moment on the body",
    parameters=(
        PhysicsParameter(
            "force_n", "N", -8000.0, 8000.0, 800.0, windowed=True, meaning="positive left"
        ),
        PhysicsParameter("arm_m", "m", -4.0, 4.0, 0.0, meaning="point of attack ahead of the COG"),
        PhysicsParameter("rise_s", "s", 0.0, 2.0, 0.0, meaning="time of rise and of fall"),
    ),
    options={"body": ("trailer", "car")},
    apply=_apply,
)
