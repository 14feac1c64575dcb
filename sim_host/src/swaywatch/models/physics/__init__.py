"""Switchable physics of the simulator: one file per effect.

Each file holds the equation in words, its source, where it enters, its parameters with bounds and
units, and how it is put into the plant's numbers (`plant.layout`), as ``MODULE``; the plant itself
(plant_step.h) has the slot. :class:`PhysicsEffect` is one effect with its values::

    DoubleTrack(vehicle, physics=[PhysicsEffect("hitch_friction", moment_nm=130.0)])
"""

from __future__ import annotations

from swaywatch.models.physics._base import (
    Module,
    PhysicsEffect,
    PhysicsParameter,
    Windowed,
    module,
    modules,
)

MODULES = modules()
"""Every physics module by id."""

__all__ = ["MODULES", "Module", "PhysicsEffect", "PhysicsParameter", "Windowed", "module"]
