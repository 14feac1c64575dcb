"""Switchable physics of the double-track model: one file per effect.

Each file holds the equation (a small compiled function that the kernel calls), its source, where
it enters, and its parameters with bounds and units, as ``MODULE``. :class:`Effect` is one effect
with its values::

    DoubleTrack(vehicle, physics=[Effect("hitch_friction", moment_nm=130.0)])
"""

from __future__ import annotations

from swaywatch.models.physics._base import Effect, Module, Parameter, Windowed
from swaywatch.models.physics._registry import MODULES, module

__all__ = ["MODULES", "Effect", "Module", "Parameter", "Windowed", "module"]
