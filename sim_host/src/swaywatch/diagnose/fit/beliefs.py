"""What is believed of vehicle and sensors, and how exactly: the priors of every fit.

Nobody knows a vehicle exactly. Every value of vehicle.toml and every sensor carries a tolerance
(one standard deviation); a fit moves all of them within it, and what it ends with is the calibrated
vehicle. A missing effect is what is left beyond that.

A belief is a number z, 0 where the file says so and 1 at one tolerance from it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from swaywatch.effects.runs import per_sample
from swaywatch.plant.lanes import BODY, PlantInput

Array = NDArray[np.float64]

#: One standard deviation of what users know, with its source. Relative; lengths in metres.
#: A stated bound "within 10 %" that nothing prefers the middle of is 10 % / sqrt(3).
VEHICLE: dict[str, tuple[float, str]] = {
    "mass": (0.015, "axle scales 1 %, fuel and load between weighing and drive"),
    "yaw_inertia": (0.06, "estimated from mass and lengths: within 10 %"),
    "cornering_stiffness": (0.05, "tyre data of another pressure and wear: within 8 %"),
    "cog": (0.025, "from axle loads of 1 %: within 3 to 5 cm"),
    "hitch_to_cog": (0.03, "ball to a centre of gravity that is not visible: within 5 cm"),
    "steering_ratio": (0.01, "gear and compliance of the linkage about the centre"),
}
SENSOR: dict[str, tuple[float, str]] = {
    "gain": (0.005, "data sheets of inertial units and wheel force sensors: 0.5 to 1 %"),
    "delay_s": (0.002, "a fifth of a message period of 10 ms"),
    "position_m": (0.02, "tape measure to a centre of gravity"),
    "speed": (0.003, "rolling radius over the speed range, after the gain is corrected"),
}
#: What no file says, about the typical values of the plant.
TYPICAL: dict[str, tuple[float, str]] = {
    "transfer_car_front": (0.35, "heights, tracks and roll stiffness of passenger cars"),
    "transfer_car_rear": (0.35, "heights, tracks and roll stiffness of passenger cars"),
    "roll_frequency_car": (0.25, "1.5 to 2.5 Hz"),
    "roll_damping_car": (0.7, "0.1 to 0.4, entered on a low typical value"),
}
#: The same of a trailer: asked for where its wheels' side forces are recorded, which share the
#: load between left and right.
TYPICAL_TRAILER: dict[str, tuple[float, str]] = {
    "transfer_trailer_front": (0.5, "heights and tracks from low box trailers to caravans"),
    "transfer_trailer_rear": (0.5, "heights and tracks from low box trailers to caravans"),
    "roll_frequency_trailer": (0.35, "1 to 2.5 Hz"),
    "roll_damping_trailer": (0.7, "0.1 to 0.4, entered on a low typical value"),
}
LEAST_SHARE = 0.05  # of a value of the file, below which none is moved
SENSORS = ("gain", "delay")  # kinds of beliefs about each channel
_INDEX = {name: index for index, name in enumerate(BODY)}
#: A shift of a centre of gravity ahead, and what it does to the distances from it.
_COG = {
    "car": (("front_axle_to_cog", -1.0), ("rear_axle_to_cog", 1.0), ("hitch_to_cog", 1.0)),
    "trailer": (("front_axle_to_cog", -1.0), ("rear_axle_to_cog", 1.0), ("hitch_to_cog", -1.0)),
}
_ACCELEROMETER = {"car": "car_lateral_acceleration", "trailer": "trailer_lateral_acceleration"}


@dataclass(frozen=True)
class Belief:
    """One number that is known to a tolerance.

    Attributes
    ----------
    kind
        "vehicle", "typical" (of no file), "gain", "delay" or "position".
    name
        Value of vehicle.toml, slot of the plant, or channel.
    tolerance
        Standard deviation: relative of values and gains; of lengths in m, of delays in s.
    source
        Where the tolerance is from.
    signed
        A typical value, such as a height over the roll axis, that may be zero or less: its
        tolerance is in its unit.
    centre
        Where it is believed to be, in tolerances from what the file says.
    """

    kind: str
    name: str
    tolerance: float
    source: str
    signed: bool = False
    centre: float = 0.0

    @property
    def scaled(self) -> bool:
        """Of the vehicle's file, whose values share one care."""
        return self.kind == "vehicle"


@dataclass(frozen=True)
class Weighing:
    """A measurement that several values of the vehicle's file have to agree with.

    Attributes
    ----------
    name
        What was measured.
    off
        Measured less what the file's values make of it, in standard deviations of the measurement.
    slopes
        Of each value's name: by how many of these a tolerance of it changes that.
    """

    name: str
    off: float
    slopes: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Beliefs:
    """All beliefs of a problem, and what they do to plant and sensors.

    The logarithm of their prior is -|roots z - target|^2 / 2.

    Attributes
    ----------
    items
        In the order of z.
    care
        Factor on the tolerances of the vehicle's file: 1 as stated; smaller where its values
        turn out to be as exact as that.
    weighings
        What binds them together.
    """

    items: tuple[Belief, ...] = ()
    care: float = 1.0
    weighings: tuple[Weighing, ...] = ()

    def __len__(self) -> int:
        return len(self.items)

    @cached_property
    def spread(self) -> Array:
        """Prior standard deviation of each z."""
        return np.array([self.care if b.scaled else 1.0 for b in self.items])

    @cached_property
    def roots(self) -> Array:
        """Rows of the prior, shape (beliefs + weighings, beliefs)."""
        rows = np.zeros((len(self.weighings), len(self)))
        for i, weighing in enumerate(self.weighings):
            for name, slope in weighing.slopes:
                rows[i, self.at["vehicle", name]] = slope
        return np.vstack([np.diag(1.0 / self.spread), rows])

    @cached_property
    def target(self) -> Array:
        """What the rows should come to, shape (beliefs + weighings,)."""
        centres = np.array([b.centre for b in self.items]) / self.spread
        return np.concatenate([centres, [w.off for w in self.weighings]])

    @cached_property
    def weight(self) -> Array:
        """Inverse of the prior's covariance, shape (beliefs, beliefs)."""
        return np.asarray(self.roots.T @ self.roots)

    @cached_property
    def volume(self) -> float:
        """Logarithm of the determinant of `weight`."""
        return float(np.linalg.slogdet(self.weight)[1]) if self.items else 0.0

    def misfit(self, z: Array) -> Array:
        """How far z is from what is believed, in standard deviations, as the rows of `roots`."""
        return np.asarray(self.roots @ z - self.target)

    def pull(self, z: Array) -> Array:
        """Half the derivative of the squared `misfit`, shape (beliefs,)."""
        return np.asarray(self.roots.T @ self.misfit(z))

    def act(self, plant: PlantInput, z: Array) -> None:
        """Move the constants of the plant by z."""
        moves = z * self._tolerances
        body, shares, lengths = self._of_the_file
        plant.body += lengths @ z
        plant.body[body] *= np.maximum(1.0 + moves[shares], LEAST_SHARE)
        for index, name, signed in self._typical:
            move = float(moves[index])
            if signed:
                plant.scalar(name, plant.get(name) + move)
            elif move:
                # falls towards zero and never below
                factor = 1.0 + move if move > 0.0 else math.exp(move)
                plant.scalar(name, plant.get(name) * factor)
        if ratio := self.amount("vehicle", "car.steering_ratio", z):
            plant.steer = plant.steer / (1.0 + ratio)
        if gain := self.amount("gain", "speed", z):
            plant.speed = plant.speed / (1.0 + gain)
            plant.acceleration = plant.acceleration / (1.0 + gain)
        if delay := self.amount("delay", "steering_wheel_angle", z):
            plant.steer = plant.steer + delay / plant.period_s * per_sample(plant.steer)

    @cached_property
    def _tolerances(self) -> Array:
        """Of each belief, shape (beliefs,)."""
        return np.array([b.tolerance for b in self.items])

    @cached_property
    def _of_the_file(self) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
        """Constants of the plant that beliefs move by a share, these; and what moves lengths.

        The last of shape (constants, beliefs), in m.
        """
        lengths = np.zeros((len(BODY), len(self)))
        shares = []
        for i, belief in enumerate(self.items):
            if belief.kind != "vehicle" or belief.name == "car.steering_ratio":
                continue
            if belief.name in _INDEX and not _is_length(belief.name):
                shares.append((_INDEX[belief.name], i))
            else:
                moved(lengths[:, i], belief.name, belief.tolerance)
        places = np.array(shares, dtype=np.intp).reshape(-1, 2)
        return places[:, 0], places[:, 1], lengths

    @cached_property
    def _typical(self) -> list[tuple[int, str, bool]]:
        """Beliefs about typical values: place, slot of the plant, whether it may be negative."""
        return [
            (i, b.name, b.signed)
            for i, b in enumerate(self.items)
            if b.signed or b.kind == "typical"
        ]

    @cached_property
    def at(self) -> dict[tuple[str, str], int]:
        """Place of each belief by kind and name."""
        return {(b.kind, b.name): i for i, b in enumerate(self.items)}

    def amount(self, kind: str, name: str, z: Array) -> float:
        """By how much a belief is off, in units of the value; 0 where there is none."""
        index = self.at.get((kind, name))
        return 0.0 if index is None else float(z[index]) * self.items[index].tolerance

    def position(self, channel: str, z: Array) -> float:
        """Metres by which an accelerometer sits further ahead of the centre of gravity."""
        body = channel.split("_", maxsplit=1)[0]
        return self.amount("position", channel, z) - self.amount("vehicle", f"{body}.cog", z)

    def sensed(self, channel: str, value: Array, step_s: float, z: Array) -> Array:
        """A channel with its gain and delay. Shape (n,)."""
        return self.all_sensed([channel], value[:, np.newaxis], step_s, z)[:, 0]

    def all_sensed(self, channels: Sequence[str], values: Array, step_s: float, z: Array) -> Array:
        """`sensed` of several channels at once. Shape (n, channels)."""
        moves = self.amounts(tuple(channels), z)
        if moves[0].any():
            values = values * (1.0 + moves[0])
        if moves[1].any():
            values = values - moves[1] / step_s * per_sample(values)
        return values

    def amounts(self, channels: tuple[str, ...], z: Array) -> Array:
        """`amount` of the gain, then of the delay, of each channel. Shape (2, channels)."""
        if channels not in self._places:
            places = np.array([[self.at.get((k, c), -1) for c in channels] for k in SENSORS])
            tolerances = np.array([*(b.tolerance for b in self.items), 0.0])
            self._places[channels] = places, tolerances[places]
        places, tolerances = self._places[channels]
        return np.asarray(np.append(z, 0.0)[places] * tolerances)

    @cached_property
    def _places(self) -> dict[tuple[str, ...], tuple[NDArray[np.intp], Array]]:
        """Of channels once asked for: places of their beliefs (-1: none), and tolerances."""
        return {}

    def value(self, index: int, body: Array, ratio: float, z: float) -> float:
        """Calibrated value of a belief about the vehicle, SI."""
        belief = self.items[index]
        move = z * belief.tolerance
        if belief.name.endswith(".cog"):
            return move
        if belief.name == "car.steering_ratio":
            return ratio * (1.0 + move)
        if belief.name in _INDEX:
            own = float(body[_INDEX[belief.name]])
            return own + move if _is_length(belief.name) else own * (1.0 + move)
        return move


def _is_length(name: str) -> bool:
    return name.endswith("_to_cog")


def moved(body: Array, name: str, move: float) -> None:
    """Change a value of the file in constants in the order of `lanes.BODY`: in m, or by a share."""
    part, key = name.split(".")
    if key == "cog":
        for length, sign in _COG[part]:
            body[_INDEX[f"{part}.{length}"]] += sign * move
    elif _is_length(key):
        body[_INDEX[name]] += move
    else:
        body[_INDEX[name]] *= max(1.0 + move, LEAST_SHARE)


def wheels_of_trailer(channels: Sequence[str]) -> bool:
    """Tell whether side forces of the trailer's wheels are among the channels."""
    return any(name.startswith("trailer_wheel_lateral_force") for name in channels)


def beliefs_of(
    body: Array, channels: Sequence[str], stated: Mapping[str, float] | None = None
) -> Beliefs:
    """Beliefs about a combination whose runs have `channels`.

    Parameters
    ----------
    body
        Constants in the order of `plant.lanes.BODY`.
    channels
        Compared channels.
    stated
        Tolerances that vehicle.toml states itself, by name.
    """
    items = []
    for part in ("car", "trailer"):
        single = part == "trailer" and body[_INDEX["trailer.front_cornering_stiffness"]] < 1.0
        for key in ("mass", "yaw_inertia"):
            items.append(Belief("vehicle", f"{part}.{key}", *VEHICLE[key]))
        for axle in ("front", "rear"):
            if not (single and axle == "front"):
                name = f"{part}.{axle}_cornering_stiffness"
                items.append(Belief("vehicle", name, *VEHICLE["cornering_stiffness"]))
        items.append(Belief("vehicle", f"{part}.cog", *VEHICLE["cog"]))
        items.append(Belief("vehicle", f"{part}.hitch_to_cog", *VEHICLE["hitch_to_cog"]))
    items.append(Belief("vehicle", "car.steering_ratio", *VEHICLE["steering_ratio"]))
    typical = dict(TYPICAL)
    if wheels_of_trailer(channels):
        typical |= TYPICAL_TRAILER
        if body[_INDEX["trailer.front_cornering_stiffness"]] < 1.0:
            del typical["transfer_trailer_front"]
    items += [Belief("typical", name, *known) for name, known in typical.items()]
    items.append(Belief("gain", "speed", *SENSOR["speed"]))
    items.append(Belief("delay", "steering_wheel_angle", *SENSOR["delay_s"]))
    for name in channels:
        items.append(Belief("gain", name, *SENSOR["gain"]))
        items.append(Belief("delay", name, *SENSOR["delay_s"]))
        if name in _ACCELEROMETER.values():
            items.append(Belief("position", name, *SENSOR["position_m"]))
    own = stated or {}
    return Beliefs(
        tuple(
            replace(b, tolerance=own[b.name], source="vehicle.toml")
            if b.kind == "vehicle" and b.name in own
            else b
            for b in items
        )
    )
