"""Finds the physics modules: every file of this folder that does not start with an underscore."""

from __future__ import annotations

import importlib
import pkgutil
from pathlib import Path

from swaywatch.models.physics._base import Module


def _find() -> dict[str, Module]:
    names = sorted(info.name for info in pkgutil.iter_modules([str(Path(__file__).parent)]))
    found = {}
    for name in names:
        if not name.startswith("_"):
            found[name] = importlib.import_module(f"swaywatch.models.physics.{name}").MODULE
    return found


MODULES: dict[str, Module] = _find()
"""Every physics module by id."""


def module(effect_id: str) -> Module:
    """The module of an effect; ValueError names the known ones."""
    if effect_id not in MODULES:
        raise ValueError(f"physics {effect_id!r} is unknown; known: {', '.join(MODULES)}")
    return MODULES[effect_id]
