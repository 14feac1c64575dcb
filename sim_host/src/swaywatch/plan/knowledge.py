"""Assumed properties of a combination before a test: values, tolerances, sensors.

The unknowns are the plant's own (`plant.lanes`): values of ``vehicle.toml`` with the tolerances
that such values usually have, and what such a file does not say: how late the tyres' forces come,
and how much the steering gives way. All but these are relative to the value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.fit.data import body_of
from swaywatch.plant.lanes import BODY, OUTPUT, PlantInput, neutral
from swaywatch.simulate.sensors import preset
from swaywatch.vehicle import Vehicle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Unknown:
    """A number that a test shall tell.

    Attributes
    ----------
    name
        As in ``vehicle.toml``, or a slot of the plant.
    words
        For the report.
    value
        Believed.
    deviation
        Of the belief, in the unit of the value.
    unit
        For the report.
    put
        Writes a value into the plant.
    """

    name: str
    words: str
    value: float
    deviation: float
    unit: str
    put: Callable[[PlantInput, float], None]


@dataclass(frozen=True)
class KnownSensor:
    """A channel: the output of the plant and its noise (standard deviation of a sample)."""

    role: str
    output: str
    noise: float


@dataclass(frozen=True)
class Knowledge:
    """A combination as believed.

    Attributes
    ----------
    body : as of `plant.lanes.PlantInput`
    steering_ratio : steering wheel over road wheel
    """

    body: Array
    steering_ratio: float
    unknowns: tuple[Unknown, ...]

    def plant(self, time_s: Array, steer: Array, speed: Array, values: Array) -> PlantInput:
        """The plant with values of the unknowns; `steer` at the steering wheel, rad."""
        step = float(time_s[1] - time_s[0])
        plant = PlantInput(
            step, speed, np.gradient(speed, step), steer / self.steering_ratio, self.body.copy(),
            neutral(),
        )  # fmt: skip
        for unknown, value in zip(self.unknowns, values, strict=True):
            unknown.put(plant, float(value))
        return plant

    @property
    def values(self) -> Array:
        """Believed values of the unknowns."""
        return np.array([unknown.value for unknown in self.unknowns])

    @property
    def deviations(self) -> Array:
        """Of the beliefs."""
        return np.array([unknown.deviation for unknown in self.unknowns])


TOLERANCES = {
    "car.front_cornering_stiffness": 0.10, "car.rear_cornering_stiffness": 0.10,
    "trailer.cornering_stiffness": 0.15, "car.yaw_inertia": 0.10, "trailer.yaw_inertia": 0.10,
    "trailer.mass": 0.03, "steering_ratio": 0.03,
}  # fmt: skip
"""Standard deviations, relative: tyres from a catalogue, inertias from a rule of thumb, a trailer
as loaded, a ratio from a data sheet (it varies over the angle)."""

RELAXATION_M, RELAXATION_ERROR_M = 0.4, 0.2
FLEXIBILITY, FLEXIBILITY_ERROR = 5e-7, 4e-7
"""Of the steering, rad/N: Eq. 5.3 of the reference, cars with some 2e-7 to 1e-6."""

_WORDS = {
    "car.front_cornering_stiffness": ("cornering stiffness, car front", "N/rad"),
    "car.rear_cornering_stiffness": ("cornering stiffness, car rear", "N/rad"),
    "trailer.cornering_stiffness": ("cornering stiffness, trailer", "N/rad"),
    "car.yaw_inertia": ("yaw inertia, car", "kg m2"),
    "trailer.yaw_inertia": ("yaw inertia, trailer", "kg m2"),
    "trailer.mass": ("mass, trailer", "kg"),
    "steering_ratio": ("steering ratio", "-"),
}


def _body(name: str) -> Callable[[PlantInput, float], None]:
    index = BODY.index(name)

    def put(plant: PlantInput, value: float) -> None:
        plant.body[index] = value

    return put


def _trailer_tyres(body: Array) -> Callable[[PlantInput, float], None]:
    front, rear = (BODY.index(f"trailer.{end}_cornering_stiffness") for end in ("front", "rear"))
    share = float(body[front] / (body[front] + body[rear]))

    def put(plant: PlantInput, value: float) -> None:
        plant.body[front], plant.body[rear] = share * value, (1.0 - share) * value

    return put


def _ratio(believed: float) -> Callable[[PlantInput, float], None]:
    def put(plant: PlantInput, value: float) -> None:
        plant.steer = plant.steer * (believed / value)

    return put


def _slots(*names: str) -> Callable[[PlantInput, float], None]:
    def put(plant: PlantInput, value: float) -> None:
        for name in names:
            plant.scalar(name, max(value, 0.0))

    return put


def known_of(vehicle: Vehicle) -> Knowledge:
    """Beliefs about a combination.

    Raises
    ------
    VehicleError
        No trailer, or a value is missing.
    """
    body = body_of(vehicle)
    ratio = vehicle.car.steering_ratio
    tyres = float(
        sum(body[BODY.index(f"trailer.{e}_cornering_stiffness")] for e in ("front", "rear"))
    )
    unknowns = []
    for name, tolerance in TOLERANCES.items():
        words, unit = _WORDS[name]
        if name == "steering_ratio":
            value, put = ratio, _ratio(ratio)
        elif name == "trailer.cornering_stiffness":
            value, put = tyres, _trailer_tyres(body)
        else:
            value, put = float(body[BODY.index(name)]), _body(name)
        unknowns.append(Unknown(name, words, value, tolerance * value, unit, put))
    relaxations = {
        "relaxation_car": (
            "relaxation length, car",
            ("relaxation_car_front", "relaxation_car_rear"),
        ),
        "relaxation_trailer": ("relaxation length, trailer", ("relaxation_trailer",)),
    }
    unknowns += [
        Unknown(name, words, RELAXATION_M, RELAXATION_ERROR_M, "m", _slots(*slots))
        for name, (words, slots) in relaxations.items()
    ]
    unknowns.append(
        Unknown("steering_flexibility", "steering compliance", FLEXIBILITY, FLEXIBILITY_ERROR,
                "rad/N", _slots("steering_flexibility"))
    )  # fmt: skip
    return Knowledge(body, ratio, tuple(unknowns))


_OWN = {"car_yaw_rate": "car_yaw_rate", "car_lateral_acceleration": "car_acceleration"}
_TRAILER = {
    "trailer_yaw_rate": "trailer_yaw_rate", "trailer_lateral_acceleration": "trailer_acceleration",
}  # fmt: skip
_FORCES = {
    **{f"wheel_lateral_force_{wheel}": f"lateral_{wheel}" for wheel in ("fl", "fr", "rl", "rr")},
    "hitch_lateral_force": "hitch_y",
}
SETS: Mapping[str, tuple[str, Mapping[str, str]]] = {
    "own": ("the car's own: yaw rate, lateral acceleration", _OWN),
    "articulation": (
        "the car's own, and the articulation angle", {**_OWN, "articulation": "articulation"},
    ),
    "trailer": (
        "the car's own, and yaw rate and lateral acceleration of the trailer", {**_OWN, **_TRAILER},
    ),
    "forces": (
        "those of trailer, and lateral wheel forces of the car and lateral hitch force",
        {**_OWN, **_TRAILER, **_FORCES},
    ),
}  # fmt: skip
"""Sets of sensors beside steering-wheel angle and speed, each with more than the one before."""


def sensors_of(name: str) -> tuple[KnownSensor, ...]:
    """Sensors of a set, with the noise of a test vehicle's (`simulate.sensors`, typical)."""
    found = []
    for role, output in SETS[name][1].items():
        kind = preset("typical", role)
        assert kind is not None
        assert output in OUTPUT
        noise = float(np.hypot(kind.noise, kind.quantisation / np.sqrt(12.0)))
        found.append(KnownSensor(role, output, noise))
    return tuple(found)
