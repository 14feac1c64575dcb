"""Switchable physics of the simulator: one file per effect.

Each file holds the equation in words, its source, where it enters, its parameters with bounds and
units, and how it is put into the plant's numbers (`plant.layout`), as ``MODULE``; the plant itself
(plant_step.h) has the slot. :class:`Effect` is one effect with its values::

    DoubleTrack(vehicle, physics=[Effect("hitch_friction", moment_nm=130.0)])
"""

from __future__ import annotations

from swaywatch.models.physics._base import Effect, Module, Parameter, Windowed
from swaywatch.models.physics._registry import MODULES, module

__all__ = ["MODULES", "Effect", "Module", "Parameter", "Windowed", "module"]
