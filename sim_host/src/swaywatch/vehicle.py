"""What the user believes of the combination (SI units); `vehicle_file.py` reads it.

Lengths run from the centre of gravity (COG); `front_axle_to_cog` is positive for an axle ahead of
it, `rear_axle_to_cog` and a car's `hitch_to_cog` for what lies behind it; a trailer's
`hitch_to_cog` is positive for the hitch ahead of its COG. Dissertation: Tables A and B.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

UNKNOWNS = ("mass", "hitch_to_cog", "yaw_inertia", "stiffness", "axle")
"""What may be unknown of a trailer, in the order of ``sway_core_config_t.trailer_assumed``."""


@dataclass(frozen=True)
class Car:
    """The towing car (index 1 of the dissertation)."""

    mass: float
    """kg"""
    yaw_inertia: float
    """kg m2, about the vertical axis through the COG"""
    front_axle_to_cog: float
    """m"""
    rear_axle_to_cog: float
    """m"""
    steering_ratio: float
    """steering wheel angle / road wheel angle"""
    hitch_to_cog: float | None = None
    """m, ball behind the COG"""
    front_cornering_stiffness: float | None = None
    """N/rad, both wheels"""
    rear_cornering_stiffness: float | None = None
    """N/rad, both wheels"""
    front_axle_load: float | None = None
    """N, static"""
    rear_axle_load: float | None = None
    """N, static"""

    @property
    def wheelbase(self) -> float:
        """Distance of the axles, m."""
        return self.front_axle_to_cog + self.rear_axle_to_cog


@dataclass(frozen=True)
class Trailer:
    """The trailer (index 2); a single axle is the rear one, with no front axle."""

    mass: float
    yaw_inertia: float
    rear_axle_to_cog: float
    """m, positive behind the COG"""
    hitch_to_cog: float
    """m, ball ahead of the COG"""
    front_axle_to_cog: float | None = None
    """m, positive ahead of the COG; None: single axle"""
    front_cornering_stiffness: float | None = None
    rear_cornering_stiffness: float | None = None
    front_axle_load: float | None = None
    rear_axle_load: float | None = None
    assumed: tuple[str, ...] = ()
    """Of `mass`, `hitch_to_cog`, `yaw_inertia`, `stiffness`, `axle`: those that nobody gave; their
    values are typical ones."""


@dataclass(frozen=True)
class Vehicle:
    """A combination, or a car alone (`trailer` None)."""

    car: Car
    trailer: Trailer | None
    path: Path | None = None
    tolerance: Mapping[str, float] = dataclasses.field(default_factory=dict)
    """Standard deviation of what is known, by name ("car.mass"): relative; of `cog` and
    `hitch_to_cog` in m. What is not there has a tolerance by its kind (`diagnose.fit.beliefs`)."""
