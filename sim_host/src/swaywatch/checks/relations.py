"""Relations that hold between the channels of a drive whatever the tyres do.

A relation is a sum of terms, one per channel, that is zero (band-passed 0.15-3 Hz): kinematics of
the hitch, balances of forces and moments.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import scipy.optimize
import scipy.signal

from swaywatch.drive import Channel, Drive, Grid
from swaywatch.vehicle import Vehicle

FloatArray = npt.NDArray[np.float64]
_Terms = dict[tuple[str, ...], FloatArray]

BESIDE_S = 0.5
EDGE_S = 0.3
"""At both ends of a run the filters know one side only."""
SMOOTH_HZ = 8.0
BROKEN = 0.6
"""A relation whose rest is above this part of its largest term does not hold."""
EXCITED = 4.0
"""A relation says something where its largest term is so many times the noise of all terms."""
NOISE_BAND_HZ = (4.0, 20.0)
"""Where a vehicle moves little and a sensor shows its noise; wheels hop in a part of it."""
ROLL_HZ = (1.1, 2.0)
"""Natural frequencies of roll that enclose those of trailers and cars (Reimpell et al.),"""
ROLL_DAMPING = 0.25
"""their damping ratio (Dixon, The Shock Absorber Handbook, ch. 1),"""
ROLLING = 0.15
"""and the part of the lateral acceleration that gravity adds at most: 8.6 deg of roll per g,
where Gillespie, Fundamentals of Vehicle Dynamics, ch. 6, gives 3 to 7 for cars."""
ALIKE = 0.85
"""Correlation above which the yaw rate of a car is taken to come of its steering,"""
SLOWEST_YAW_S = 0.4
"""at most so long after it;"""
CHARACTERISTIC_M_S = 30.0
"""characteristic speed of a usual car: 65 to 150 km/h (Mitschke, Dynamik der Kraftfahrzeuge)."""
SEED = 9815
"""Of the noise that is sent through the relations instead of the channels."""


@dataclass(frozen=True)
class Relation:
    """Terms (channels -> array over the grid) that add up to zero.

    `tight` ones are kinematics and balances; loose ones of two terms hold only roughly, and tell
    signs and orders of magnitude.
    """

    name: str
    terms: _Terms
    tight: bool = True
    noise: float = 0.0
    """Root mean square of what the noise of its sensors makes of the sum."""
    rolling: tuple[FloatArray, ...] = ()
    """What gravity adds to the accelerometers of bodies that roll, of sizes not known."""

    @property
    def excited(self) -> bool:
        """Whether the motion stands clear of the noise; where it does not, nothing is said."""
        largest = max(float(np.sqrt(np.mean(term**2))) for term in self.terms.values())
        return largest > EXCITED * self.noise

    @property
    def channels(self) -> set[str]:
        """Channels in it."""
        return {name for names in self.terms for name in names}

    def is_broken(self, channel: str | None = None, factor: float = 1.0) -> bool:
        """Whether it does not hold, with `channel` times `factor`."""
        rest = self.rest(channel, factor)
        if self.tight:
            return rest > BROKEN and (channel is not None or self.rest_of_rolling() > BROKEN)
        sizes = sorted(
            float(np.sqrt(np.mean((term * (factor if channel in names else 1.0)) ** 2)))
            for names, term in self.terms.items()
        )
        return rest > 1.4 or sizes[-1] > 2.5 * sizes[-2]

    def rest_of_rolling(self) -> float:
        """Rest that bodies that roll cannot account for."""
        if not self.rolling:
            return self.rest()
        total = np.sum(list(self.terms.values()), axis=0)
        largest = max(float(np.sqrt(np.mean(term**2))) for term in self.terms.values())
        columns = np.stack(self.rolling, axis=1)
        normal, target = columns.T @ columns, -columns.T @ total
        factor = np.linalg.cholesky(normal + 1e-9 * np.trace(normal) * np.eye(len(normal)))
        found = scipy.optimize.lsq_linear(
            factor.T, np.linalg.solve(factor, target), (-ROLLING, ROLLING)
        )
        return float(np.sqrt(np.mean((total + columns @ found.x) ** 2))) / max(largest, 1e-12)

    def rest(self, channel: str | None = None, factor: float = 1.0) -> float:
        """Root mean square of the sum over that of its largest term, `channel` times `factor`."""
        total = np.zeros(len(next(iter(self.terms.values()))))
        largest = 1e-12
        for names, term in self.terms.items():
            scaled = term * factor if channel in names else term
            total += scaled
            largest = max(largest, float(np.sqrt(np.mean(scaled**2))))
        return float(np.sqrt(np.mean(np.square(total)))) / largest


def make_relations(drive: Drive, vehicle: Vehicle, grid: Grid) -> list[Relation]:
    """Every relation whose channels are there and that is excited."""
    rng = np.random.default_rng(SEED)
    shaken = {
        name: value
        if name == "speed"
        else rng.standard_normal(len(value))
        * math.sqrt(0.5 * grid.rate_hz * noise_density(drive.channels[name]))
        for name, value in grid.value.items()
    }
    noise = {
        relation.name: math.hypot(*(np.std(term) for term in relation.terms.values()))
        for relation in RelationBuilder(drive, vehicle, replace(grid, value=shaken)).all()
    }
    made = [
        replace(relation, noise=noise.get(relation.name, 0.0))
        for relation in RelationBuilder(drive, vehicle, grid).all()
    ]
    return [relation for relation in made if relation.excited]


def noise_density(channel: Channel) -> float:
    """Power density of a sensor's noise at low frequency, unit of the channel squared per Hz.

    Taken for white; at least that of its steps.
    """
    rate_hz = 1.0 / float(np.median(np.diff(channel.time_s)))
    steps = channel.resolution**2 / 12.0 / (0.5 * rate_hz)
    low, high = NOISE_BAND_HZ[0], min(NOISE_BAND_HZ[1], 0.45 * rate_hz)
    if len(channel.value) < 64 or high < 1.25 * low:
        return steps
    size = min(len(channel.value), 2 * round(rate_hz))
    hz, density = scipy.signal.welch(
        channel.value, rate_hz, nperseg=size, detrend=scipy.signal.detrend, average="median"
    )  # the median over the parts: a kick at the wheel is no noise
    inside = (hz >= low) & (hz <= high)
    return max(float(np.median(density[inside])), steps)


class RelationBuilder:
    """Terms of the relations on the grid."""

    BAND_HZ = (0.15, 3.0)

    def __init__(self, drive: Drive, vehicle: Vehicle, grid: Grid) -> None:
        self.drive = drive
        self.car, self.trailer = vehicle.car, vehicle.trailer
        self.value = grid.value
        self.band = scipy.signal.butter(
            2, self.BAND_HZ, btype="bandpass", fs=grid.rate_hz, output="sos"
        )
        self.rate_hz = grid.rate_hz
        self.smoother = scipy.signal.butter(2, SMOOTH_HZ, fs=grid.rate_hz, output="sos")
        self.rolls = [
            scipy.signal.bilinear([w**2], [1.0, 2.0 * ROLL_DAMPING * w, w**2], fs=grid.rate_hz)
            for w in (2.0 * math.pi * hz for hz in ROLL_HZ)
        ]
        good = np.ones(len(grid.time_s), dtype=np.bool_)
        for valid in grid.valid.values():
            good &= valid
        edge = round(EDGE_S * grid.rate_hz)
        good[:edge] = good[len(good) - edge :] = False
        if not good[edge : len(good) - edge].all():  # the filter carries the edge of a gap on
            near = np.ones(2 * round(BESIDE_S * grid.rate_hz) + 1)
            good = np.convolve(~good, near, mode="same") < 0.5
        if "speed" in self.value:
            good &= self.value["speed"] > 5.0
        self.good = good
        self.unfiltered: list[_Terms] = []

    def all(self) -> list[Relation]:
        """Every relation whose channels are there."""
        made = [
            self.speed_times_yaw_rate(),
            self.hitch_kinematics(),
            self.articulation_rate(),
            self.car_lateral(),
            self.car_yaw(),
            self.trailer_lateral(),
            self.trailer_yaw(),
            self.trailer_pull(),
            self.yaw_follows_steering(),
        ]
        return [relation for relation in made if relation is not None]

    def raw(self) -> list[dict[str, tuple[float, FloatArray]]]:
        """Unfiltered terms of the tight relations: channel to (static factor, term).

        The factor is 0 for a channel that enters by its slope.
        """
        self.unfiltered = []
        self.all()
        return [
            {names[0]: (self._factor(names[0], term), term) for names, term in terms.items()}
            for terms in self.unfiltered
        ]

    def _factor(self, name: str, term: FloatArray) -> float:
        value = self.value[name]
        factor = float(term @ value) / (float(value @ value) + 1e-30)
        return factor if np.allclose(term, factor * value, rtol=1e-6) else 0.0

    def has(self, *names: str) -> bool:
        """Whether all these channels are there."""
        return all(name in self.value for name in names)

    def filtered(self, signal: FloatArray) -> FloatArray:
        """Band-passed, the good samples."""
        result: FloatArray = scipy.signal.sosfiltfilt(self.band, signal)
        return result[self.good]

    def slope(self, name: str) -> FloatArray:
        """Time derivative of a channel."""
        # smoothed, or the noise at the ends of the run would go through the band-pass as a kick
        smooth = scipy.signal.sosfiltfilt(self.smoother, self.value[name])
        result: FloatArray = np.gradient(smooth, 1.0 / self.rate_hz)
        return result

    def relation(self, name: str, terms: _Terms, tight: bool = True) -> Relation | None:
        """A relation of these terms; None where too little is good."""
        if self.good.sum() < 3 * self.rate_hz:
            return None
        if tight:
            self.unfiltered.append(terms)
        rolling = tuple(
            self.filtered(scipy.signal.lfilter(*roll, term))
            for roll in self.rolls
            for key, term in terms.items()
            if tight and key[0].endswith("lateral_acceleration")
        )
        filtered = {key: self.filtered(term) for key, term in terms.items()}
        return Relation(name, filtered, tight, rolling=rolling)

    def axle(self, prefix: str, axle: str) -> tuple[tuple[str, str], FloatArray] | None:
        """Names and sum of the lateral forces of an axle."""
        names = (f"{prefix}wheel_lateral_force_{axle}l", f"{prefix}wheel_lateral_force_{axle}r")
        if not self.has(*names):
            return None
        return names, self.value[names[0]] + self.value[names[1]]

    def each(self, names: Iterable[str], factor: float) -> _Terms:
        """Terms of several channels with one factor."""
        return {(name,): factor * self.value[name] for name in names}

    def speed_times_yaw_rate(self) -> Relation | None:
        """Lateral acceleration against speed times yaw rate."""
        if not self.has("speed", "car_yaw_rate", "car_lateral_acceleration"):
            return None
        return self.relation(
            "car lateral acceleration = speed x yaw rate",
            {
                ("car_lateral_acceleration",): self.value["car_lateral_acceleration"],
                ("speed", "car_yaw_rate"): -self.value["speed"] * self.value["car_yaw_rate"],
            },
            tight=False,
        )

    def hitch_kinematics(self) -> Relation | None:
        """The hitch belongs to both bodies."""
        names = (
            "car_yaw_rate",
            "car_lateral_acceleration",
            "trailer_yaw_rate",
            "trailer_lateral_acceleration",
        )
        if not self.has(*names) or self.trailer is None or self.car.hitch_to_cog is None:
            return None
        ahead_1 = self.drive.channels["car_lateral_acceleration"].position_m
        ahead_2 = self.drive.channels["trailer_lateral_acceleration"].position_m
        return self.relation(
            "lateral acceleration of the hitch, seen from both bodies",
            {
                ("car_lateral_acceleration",): self.value["car_lateral_acceleration"],
                ("car_yaw_rate",): -(self.car.hitch_to_cog + ahead_1) * self.slope("car_yaw_rate"),
                ("trailer_lateral_acceleration",): -self.value["trailer_lateral_acceleration"],
                ("trailer_yaw_rate",): -(self.trailer.hitch_to_cog - ahead_2)
                * self.slope("trailer_yaw_rate"),
            },
        )

    def articulation_rate(self) -> Relation | None:
        """Articulation against both yaw rates."""
        if not self.has("articulation", "car_yaw_rate", "trailer_yaw_rate"):
            return None
        return self.relation(
            "rate of articulation = difference of the yaw rates",
            {
                ("articulation",): self.slope("articulation"),
                ("trailer_yaw_rate",): -self.value["trailer_yaw_rate"],
                ("car_yaw_rate",): self.value["car_yaw_rate"],
            },
        )

    def car_acceleration(self) -> _Terms:
        """Terms of m1 times the lateral acceleration of the COG."""
        ahead = self.drive.channels["car_lateral_acceleration"].position_m
        return {
            ("car_lateral_acceleration",): self.car.mass * self.value["car_lateral_acceleration"],
            ("car_yaw_rate",): -self.car.mass * ahead * self.slope("car_yaw_rate"),
        }

    def car_lateral(self) -> Relation | None:
        """Forces on the car."""
        axles = [self.axle("", axle) for axle in ("f", "r")]
        needed = ["car_lateral_acceleration", "car_yaw_rate"]
        needed += ["hitch_lateral_force"] if self.trailer is not None else []
        if None in axles or not self.has(*needed):
            return None
        terms = self.car_acceleration()
        for axle in axles:
            assert axle is not None
            terms |= self.each(axle[0], -1.0)
        if self.trailer is not None:
            terms |= self.each(("hitch_lateral_force",), -1.0)
        return self.relation("lateral forces on the car = mass x lateral acceleration", terms)

    def car_yaw(self) -> Relation | None:
        """Moments on the car."""
        axles = [self.axle("", axle) for axle in ("f", "r")]
        needed = ["car_yaw_rate"] + (["hitch_lateral_force"] if self.trailer is not None else [])
        if None in axles or not self.has(*needed):
            return None
        terms: _Terms = {("car_yaw_rate",): self.car.yaw_inertia * self.slope("car_yaw_rate")}
        levers = (-self.car.front_axle_to_cog, self.car.rear_axle_to_cog)
        for axle, lever in zip(axles, levers, strict=True):
            assert axle is not None
            terms |= self.each(axle[0], lever)
        if self.trailer is not None and self.car.hitch_to_cog is not None:
            terms |= self.each(("hitch_lateral_force",), self.car.hitch_to_cog)
        return self.relation("yaw moments on the car = inertia x yaw acceleration", terms)

    def trailer_forces(self) -> list[tuple[tuple[str, str], FloatArray]] | None:
        """Lateral forces of the trailer axles, if all are measured."""
        axles = [self.axle("trailer_", axle) for axle in ("f", "r")]
        found = [axle for axle in axles if axle is not None]
        if self.trailer is None or not found or not self.has("hitch_lateral_force"):
            return None
        if self.trailer.front_axle_to_cog is not None and len(found) < 2:
            return None
        return found

    def trailer_lateral(self) -> Relation | None:
        """Forces on the trailer."""
        found = self.trailer_forces()
        if found is None or not self.has("trailer_lateral_acceleration", "trailer_yaw_rate"):
            return None
        assert self.trailer is not None
        ahead = self.drive.channels["trailer_lateral_acceleration"].position_m
        mass = self.trailer.mass
        terms: _Terms = {
            ("trailer_lateral_acceleration",): mass * self.value["trailer_lateral_acceleration"],
            ("trailer_yaw_rate",): -mass * ahead * self.slope("trailer_yaw_rate"),
        }
        terms |= self.each(("hitch_lateral_force",), 1.0)
        for names, _ in found:
            terms |= self.each(names, -1.0)
        return self.relation("lateral forces on the trailer = mass x acceleration", terms)

    def trailer_yaw(self) -> Relation | None:
        """Moments on the trailer."""
        found = self.trailer_forces()
        if found is None or not self.has("trailer_yaw_rate"):
            return None
        assert self.trailer is not None
        terms: _Terms = {
            ("trailer_yaw_rate",): self.trailer.yaw_inertia * self.slope("trailer_yaw_rate")
        }
        terms |= self.each(("hitch_lateral_force",), self.trailer.hitch_to_cog)
        for names, _ in found:
            front = names[0].endswith("_fl")
            ahead = self.trailer.front_axle_to_cog if front else -self.trailer.rear_axle_to_cog
            terms |= self.each(names, -(ahead or 0.0))
        return self.relation("yaw moments on the trailer = inertia x yaw acceleration", terms)

    def trailer_pull(self) -> Relation | None:
        """Yaw of the trailer about the middle of its axles, without its tyre forces."""
        names = ("trailer_yaw_rate", "trailer_lateral_acceleration", "hitch_lateral_force")
        if self.trailer is None or self.trailer_forces() is not None or not self.has(*names):
            return None
        trailer = self.trailer
        front = trailer.front_axle_to_cog
        behind = trailer.rear_axle_to_cog
        lever = behind if front is None else 0.5 * (behind - front)
        return self.relation(
            "yaw moments on the trailer about its axles",
            {
                ("trailer_yaw_rate",): trailer.yaw_inertia * self.slope("trailer_yaw_rate"),
                ("hitch_lateral_force",): (trailer.hitch_to_cog + lever)
                * self.value["hitch_lateral_force"],
                ("trailer_lateral_acceleration",): lever
                * trailer.mass
                * self.value["trailer_lateral_acceleration"],
            },
            tight=False,
        )

    def steering_rests(self, factors: Sequence[float]) -> list[float] | None:
        """What is left of the front axle's force if the steering angle is times each factor.

        Front force against front slip without drift (both sides through s/(s+a), a = 2.5 rad/s),
        with a stiffness of its own for each factor: the free factor itself would not be
        determined by a slalom of one frequency, in which two columns fit any phasor. Parts of the
        force; infinite where the stiffness is negative. None where it cannot be determined.
        """
        axle = self.axle("", "f")
        names = ("steering_wheel_angle", "speed", "car_yaw_rate", "car_lateral_acceleration")
        if axle is None or not self.has(*names) or self.good.sum() < 3 * self.rate_hz:
            return None
        corner = 2.5
        high = scipy.signal.bilinear([1.0, 0.0], [1.0, corner], fs=self.rate_hz)
        lag = scipy.signal.bilinear([1.0], [1.0, corner], fs=self.rate_hz)
        speed = np.maximum(self.value["speed"], 5.0)
        ahead = self.drive.channels["car_lateral_acceleration"].position_m
        yaw = self.value["car_yaw_rate"]
        side = self.value["car_lateral_acceleration"] - speed * yaw
        reach = self.car.front_axle_to_cog - ahead
        drift = scipy.signal.lfilter(*lag, side / speed)
        drift = self.filtered(drift + reach * scipy.signal.lfilter(*high, yaw / speed))
        steer = scipy.signal.lfilter(*high, self.value["steering_wheel_angle"])
        steer = self.filtered(steer / self.car.steering_ratio)
        force = self.filtered(scipy.signal.lfilter(*high, axle[1]))
        densities = sum(noise_density(self.drive.channels[name]) for name in axle[0])
        noise = math.sqrt(densities * (self.BAND_HZ[1] - self.BAND_HZ[0]))
        size = float(np.std(force))
        if size < EXCITED * noise:
            return None
        rests = []
        for factor in factors:
            slip = factor * steer - drift
            stiffness = float(slip @ force) / (float(slip @ slip) + 1e-30)
            rest = float(np.std(force - stiffness * slip)) / size
            rests.append(rest if stiffness > 0.0 else math.inf)
        return rests

    def yaw_follows_steering(self) -> Relation | None:
        """The yaw rate of a car alone, where it goes the way of the steering wheel or against it.

        With a trailer a driver may steer against the sway, and the sway comes without steering.
        """
        names = ("steering_wheel_angle", "speed", "car_yaw_rate")
        if self.trailer is not None or not self.has(*names):
            return None
        if self.good.sum() < 3 * self.rate_hz:
            return None
        speed = np.maximum(self.value["speed"], 5.0)
        length = self.car.wheelbase * (1.0 + (speed / CHARACTERISTIC_M_S) ** 2)
        bend = speed * self.value["steering_wheel_angle"] / (self.car.steering_ratio * length)
        yaw = self.filtered(self.value["car_yaw_rate"])
        best: tuple[float, FloatArray] = (0.0, bend)
        for late_s in np.arange(0.0, SLOWEST_YAW_S, 0.05):
            late = np.roll(bend, round(late_s * self.rate_hz))
            late[: round(late_s * self.rate_hz)] = bend[0]
            other = self.filtered(late)
            size = float(np.linalg.norm(yaw) * np.linalg.norm(other))
            like = abs(float(yaw @ other)) / size if size > 0.0 else 0.0
            if like > best[0]:
                best = (like, late)
        if best[0] < ALIKE:
            return None
        return self.relation(
            "the car yaws to the side that it is steered to",
            {
                ("car_yaw_rate",): self.value["car_yaw_rate"],
                ("steering_wheel_angle",): -best[1],
            },
            tight=False,
        )


def badness(rests: list[float]) -> float:
    """One number for the rests of several relations."""
    return float(np.sqrt(np.mean(np.square(np.minimum(rests, 2.0)))))
