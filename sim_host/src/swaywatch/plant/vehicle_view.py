"""What the models need of a vehicle: every number of ``vehicle.toml`` present, or derived."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swaywatch.errors import VehicleError
from swaywatch.vehicle import Car, Trailer, Vehicle

GRAVITY = 9.81
"""m/s2"""


@dataclass(frozen=True)
class BodyView:
    """Car or trailer with all its numbers (SI); an axle that is not there has no stiffness."""

    mass: float
    yaw_inertia: float
    front_axle_to_cog: float
    rear_axle_to_cog: float
    hitch_to_cog: float
    front_cornering_stiffness: float
    rear_cornering_stiffness: float
    front_axle_load: float
    rear_axle_load: float


def _given(value: float | None, vehicle: Vehicle, body: str, key: str) -> float:
    if value is None:
        place = vehicle.path or "vehicle"
        raise VehicleError(f"{place}: [{body}] {key} is missing; a simulation needs it")
    return value


def car_of(vehicle: Vehicle) -> BodyView:
    """The car; axle loads that are not given come from its mass and COG."""
    car: Car = vehicle.car
    weight = car.mass * GRAVITY
    front, rear = car.front_axle_load, car.rear_axle_load
    return BodyView(
        car.mass,
        car.yaw_inertia,
        car.front_axle_to_cog,
        car.rear_axle_to_cog,
        car.hitch_to_cog or 0.0,
        _given(car.front_cornering_stiffness, vehicle, "car", "front_cornering_stiffness"),
        _given(car.rear_cornering_stiffness, vehicle, "car", "rear_cornering_stiffness"),
        weight * car.rear_axle_to_cog / car.wheelbase if front is None else front,
        weight * car.front_axle_to_cog / car.wheelbase if rear is None else rear,
    )


def trailer_of(vehicle: Vehicle) -> BodyView | None:
    """The trailer, or None; a single axle is the rear one.

    Axle loads that are not given share the trailer's weight equally between the axles, less the
    part that the ball carries: for a single axle what its position leaves, for a tandem nothing.
    """
    trailer: Trailer | None = vehicle.trailer
    if trailer is None:
        return None
    weight = trailer.mass * GRAVITY
    rear_stiffness = _given(
        trailer.rear_cornering_stiffness, vehicle, "trailer", "rear_cornering_stiffness"
    )
    if trailer.front_axle_to_cog is None:
        on_axle = weight * trailer.hitch_to_cog / (trailer.hitch_to_cog + trailer.rear_axle_to_cog)
        load = on_axle if trailer.rear_axle_load is None else trailer.rear_axle_load
        front, front_stiffness, front_load, rear_load = 0.0, 0.0, 0.0, load
    else:
        front = trailer.front_axle_to_cog
        front_stiffness = _given(
            trailer.front_cornering_stiffness, vehicle, "trailer", "front_cornering_stiffness"
        )
        half = 0.5 * weight
        front_load = half if trailer.front_axle_load is None else trailer.front_axle_load
        rear_load = half if trailer.rear_axle_load is None else trailer.rear_axle_load
    return BodyView(
        trailer.mass,
        trailer.yaw_inertia,
        front,
        trailer.rear_axle_to_cog,
        trailer.hitch_to_cog,
        front_stiffness,
        rear_stiffness,
        front_load,
        rear_load,
    )


def constants_of(vehicle: Vehicle) -> NDArray[np.float64]:
    """Constants of the plant in the order of its `BODY`; a car alone has a trailer of zeros.

    Raises
    ------
    VehicleError
        Names the value that is missing.
    """
    rows: list[float] = []
    loads: list[float] = []
    for body in (car_of(vehicle), trailer_of(vehicle)):
        if body is None:
            rows += [0.0] * 7
            loads += [0.0] * 2
            continue
        rows += [
            body.mass, body.yaw_inertia, body.front_axle_to_cog, body.rear_axle_to_cog,
            body.hitch_to_cog, body.front_cornering_stiffness, body.rear_cornering_stiffness,
        ]  # fmt: skip
        loads += [body.front_axle_load, body.rear_axle_load]
    return np.array([*rows, *loads])
