"""What the models read of a vehicle: the keys of ``vehicle.toml`` as attributes."""

from __future__ import annotations

from typing import Protocol


class TrailerLike(Protocol):
    """A trailer; lengths are positive distances from its COG (m), the rest SI."""

    @property
    def mass(self) -> float: ...
    @property
    def yaw_inertia(self) -> float: ...
    @property
    def front_axle_to_cog(self) -> float: ...
    @property
    def rear_axle_to_cog(self) -> float: ...
    @property
    def hitch_to_cog(self) -> float: ...
    @property
    def front_cornering_stiffness(self) -> float: ...
    @property
    def rear_cornering_stiffness(self) -> float: ...
    @property
    def front_axle_load(self) -> float: ...
    @property
    def rear_axle_load(self) -> float: ...


class CarLike(TrailerLike, Protocol):
    """A car: as a trailer, and steered."""

    @property
    def steering_ratio(self) -> float: ...


class VehicleLike(Protocol):
    """A car with a trailer or without."""

    @property
    def car(self) -> CarLike: ...
    @property
    def trailer(self) -> TrailerLike | None: ...
