"""A car alone: the plant without its trailer, driven by what the car's own sensors tell.

What may differ along a real drive (axle loads from braking and lift, combined slip, a banked road)
enters the plant as loads, stiffnesses and bank over time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from swaywatch.plant.lanes import AXLE, BODY, GRAVITY, OUTPUT, SCALARS, Job, PlantInput, run_jobs

Array = NDArray[np.float64]

#: Constants and slots with their neutral values.
SLOTS: dict[str, float] = {
    "mass": 0.0, "yaw_inertia": 0.0, "front_axle_to_cog": 0.0, "rear_axle_to_cog": 0.0,
    "front_cornering_stiffness": 0.0, "rear_cornering_stiffness": 0.0,
    "peak_friction_inverse_front": 0.0, "peak_friction_inverse_rear": 0.0,
    "relaxation_front": 0.0, "relaxation_rear": 0.0,  # m
    "cog_height": 0.0,  # m, moves axle load with the longitudinal acceleration
    "lift_front": 0.0, "lift_rear": 0.0,  # N per (m/s)2 taken off the axle load
    "combined_slip": 0.0,  # share of the rear stiffness lost at 1 g of longitudinal acceleration
    "degression": 0.0,  # of the stiffness of an axle with the square of its lateral force over load
}  # fmt: skip
_LEAST_SPEED = 1.0
_COLUMNS = (
    "lateral_velocity", "car_yaw_rate", "car_acceleration", "car_yaw_acceleration",
    "lateral_fl", "lateral_fr", "lateral_rl", "lateral_rr", "slip_f", "slip_r",
)  # fmt: skip
_INDEX = tuple(OUTPUT.index(name) for name in _COLUMNS)


@dataclass
class CarInput:
    """What one simulation needs: arrays of shape (n,), SI.

    Attributes
    ----------
    steer
        Road-wheel angle, rad.
    bank
        Of the road, rad, positive if gravity pulls to the left.
    slots
        Values by the names of `SLOTS`.
    initial
        Lateral velocity and yaw rate at the first sample.
    run, steering_ratio
        For effects that act in windows of a run or at the steering wheel.
    """

    period_s: float
    speed: Array
    acceleration: Array
    steer: Array
    bank: Array
    slots: dict[str, float] = field(default_factory=lambda: dict(SLOTS))
    initial: tuple[float, float] = (0.0, 0.0)
    run: int = 0
    steering_ratio: float = 15.0


def _plant(car: CarInput) -> PlantInput:
    """The car as the plant takes it: no trailer, no roll."""
    slots = car.slots
    speed = np.maximum(car.speed, _LEAST_SPEED)
    lengths = {name: slots[name] for name in ("front_axle_to_cog", "rear_axle_to_cog")}
    base, mass = sum(lengths.values()), slots["mass"]
    rest = {
        "front": mass * GRAVITY * lengths["rear_axle_to_cog"] / base,
        "rear": mass * GRAVITY * lengths["front_axle_to_cog"] / base,
    }
    constants = {f"car.{name}": value for name, value in slots.items()}
    constants |= {f"car.{axle}_axle_load": load for axle, load in rest.items()}
    body = np.array([constants.get(name, 0.0) for name in BODY])
    axles = np.zeros((4, len(AXLE)))
    for row, axle in enumerate(rest):
        axles[row, AXLE.index("peak_friction_inverse")] = slots[f"peak_friction_inverse_{axle}"]
        axles[row, AXLE.index("relaxation")] = slots[f"relaxation_{axle}"]
        axles[row, AXLE.index("softening")] = slots["degression"]
    plant = PlantInput(
        car.period_s, speed, car.acceleration, car.steer, body, np.zeros(len(SCALARS)),
        axles=axles, initial=np.array([*car.initial, 0.0, 0.0]),
    )  # fmt: skip
    moved = mass * car.acceleration * slots["cog_height"] / base
    for axle, sign in (("front", -1.0), ("rear", 1.0)):
        lift = slots[f"lift_{axle}"] * speed**2
        if slots["cog_height"] != 0.0 or slots[f"lift_{axle}"] != 0.0:
            load = np.maximum(rest[axle] + sign * moved - lift, 0.1 * rest[axle])
            plant.add_series(f"heave_car_{axle}", load - rest[axle])
    if slots["combined_slip"] != 0.0:
        weak = 1.0 / (1.0 + slots["combined_slip"] * (car.acceleration / GRAVITY) ** 2)
        plant.add_series("stiffness_car_rear", weak - 1.0)
    if car.bank.any():  # the plant's bank is positive with the left side high
        plant.add_series("bank", -car.bank)
    return plant


def simulate_all(cars: Sequence[CarInput]) -> list[dict[str, Array]]:
    """Run several cars side by side: arrays of shape (n,) by name for each.

    `acceleration` is what an accelerometer at the centre of gravity feels on a body that does not
    roll: lateral tyre forces over mass. Zeros after a divergence.
    """
    jobs = [Job(_plant(car), columns=_INDEX) for car in cars]
    found = []
    for car, outcome in zip(cars, run_jobs(jobs, fine=False), strict=True):
        assert outcome.output is not None
        col = dict(zip(_COLUMNS, outcome.output.T, strict=True))
        found.append({
            "lateral_velocity": col["lateral_velocity"], "yaw_rate": col["car_yaw_rate"],
            "acceleration": col["car_acceleration"],
            "yaw_acceleration": col["car_yaw_acceleration"],
            "front": (col["lateral_fl"] + col["lateral_fr"]) * np.cos(car.steer),
            "rear": col["lateral_rl"] + col["lateral_rr"],
            "slip_front": col["slip_f"], "slip_rear": col["slip_r"],
        })  # fmt: skip
    return found


def simulate(car: CarInput) -> dict[str, Array]:
    """Run one car, see :func:`simulate_all`."""
    return simulate_all([car])[0]
