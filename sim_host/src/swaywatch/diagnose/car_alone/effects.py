"""Explanations for a car alone: each a few numbers that enter the model or the sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.car_alone.car import CarInput
from swaywatch.effects.library.sensor_delay import shift
from swaywatch.effects.roll import lag
from swaywatch.plant.lanes import GRAVITY

Array = NDArray[np.float64]
Values = Mapping[str, float]
Outputs = dict[str, Array]

YAW, ACC = "car_yaw_rate", "car_lateral_acceleration"
STEER = "steering_wheel_angle"


@dataclass(frozen=True)
class Number:
    """A free number: bounds, start, and what is known of it beforehand (mean, deviation)."""

    name: str
    unit: str
    neutral: float
    low: float
    high: float
    start: float
    known: tuple[float, float] | None = None


def _nothing(car: CarInput, time: Array, values: Values) -> None:
    del car, time, values


def _as_it_is(outputs: Outputs, time: Array, values: Values) -> None:
    del outputs, time, values


@dataclass(frozen=True)
class CarEffect:
    """One explanation of a mismatch of a car alone.

    Attributes
    ----------
    id, component, kind, title
        As in `effect.Effect`.
    usual
        Every real car has it to some extent: the search starts with all of these and takes away
        what is not needed.
    numbers
        Free numbers.
    act
        Changes the car before a simulation.
    observe
        Changes the channels after it.
    rank
        Order among explanations that fit equally well: the lower the more usual in a healthy car.
    decided_by
        Measurement that tells it from its equivalents.
    """

    id: str
    component: str
    kind: str
    equation: str
    source: str
    numbers: tuple[Number, ...]
    act: Callable[[CarInput, Array, Values], None] = _nothing
    observe: Callable[[Outputs, Array, Values], None] = _as_it_is
    rank: int = 5
    decided_by: str = ""
    lines: tuple[str, ...] = ("f",)
    windows: tuple[tuple[int, float, float], ...] = field(default=())
    usual: bool = False
    title: str = ""

    @property
    def name(self) -> str:
        """Id and component."""
        return f"{self.id}:{self.component}"

    @property
    def moves(self) -> bool:
        """Whether the car moves otherwise, not only what its sensors show."""
        return self.act is not _nothing


def _slot(*names: str, factor: bool = False) -> Callable[[CarInput, Array, Values], None]:
    """Put the only number of an effect into slots of the car."""

    def act(car: CarInput, time: Array, values: Values) -> None:
        del time
        (value,) = values.values()
        for name in names:
            car.slots[name] = car.slots[name] * value if factor else value

    return act


def _friction(*slots: str) -> Callable[[CarInput, Array, Values], None]:
    def act(car: CarInput, time: Array, values: Values) -> None:
        del time
        for slot in slots:
            car.slots[slot] = 1.0 / values["peak_friction"]

    return act


def _ratio(car: CarInput, time: Array, values: Values) -> None:
    del time
    car.steer = car.steer / values["factor"]


def _steering_delay(car: CarInput, time: Array, values: Values) -> None:
    car.steer = shift(time, car.steer, -values["delay_s"])


def _speed(car: CarInput, time: Array, values: Values) -> None:
    del time
    car.speed, car.acceleration = car.speed / values["factor"], car.acceleration / values["factor"]


def _lift(car: CarInput, time: Array, values: Values) -> None:
    del time
    car.slots["lift_front"] = values["front_n_per_m2_s2"]
    car.slots["lift_rear"] = values["rear_n_per_m2_s2"]


def _free_play(car: CarInput, time: Array, values: Values) -> None:
    """The half of the gap that the steering wheel has to cross first (backlash)."""
    del time
    half = 0.5 * np.radians(values["gap_deg"]) / car.steering_ratio
    car.steer = _backlash(car.steer, half)


def _backlash(steer: Array, half: float) -> Array:
    at, out = float(steer[0]), []
    for angle in steer.tolist():
        at = min(max(at, angle - half), angle + half)
        out.append(at)
    return np.array(out)


def _gain(channel: str) -> Callable[[Outputs, Array, Values], None]:
    def observe(outputs: Outputs, time: Array, values: Values) -> None:
        del time
        outputs[channel] = outputs[channel] * values["factor"]

    return observe


def _delay(channel: str) -> Callable[[Outputs, Array, Values], None]:
    def observe(outputs: Outputs, time: Array, values: Values) -> None:
        outputs[channel] = shift(time, outputs[channel], values["delay_s"])

    return observe


def _position(outputs: Outputs, time: Array, values: Values) -> None:
    outputs[ACC] = outputs[ACC] + values["shift_m"] * np.gradient(outputs["true_yaw_rate"], time)


def _roll(outputs: Outputs, time: Array, values: Values) -> None:
    del time
    angle = values["roll_per_acceleration"] * lag(
        outputs[ACC], values["roll_frequency_rad_s"], values["roll_damping"]
    )
    outputs[ACC] = outputs[ACC] + GRAVITY * angle


_FACTOR = Number("factor", "-", 1.0, 0.5, 2.0, 1.05)
_LAG = Number("delay_s", "s", 0.0, -0.15, 0.3, 0.01)
_FAULT = "fault of the measurement"
_SECOND = "a second sensor of the same quantity"


def effects(channels: tuple[str, ...], *, fast: bool = True) -> list[CarEffect]:
    """Every explanation that the recorded channels can test.

    `fast`: the runs are fast enough for lift and drive force to matter.
    """
    found = [
        CarEffect(
            "tyre_saturation", "all", "physics", "F = mu F_z sin(1.35 atan(C a/(1.35 mu F_z)))",
            "Pacejka's characteristic",
            (Number("peak_friction", "-", np.inf, 0.3, 5.0, 1.2),),
            _friction("peak_friction_inverse_front", "peak_friction_inverse_rear"), rank=1,
            decided_by="wheel forces", lines=("f", "3f"),
        ),
        *(
            CarEffect(
                "tyre_saturation", f"car_{axle}", "physics",
                "F = mu F_z sin(1.35 atan(C a/(1.35 mu F_z)))", "Pacejka's characteristic",
                (Number("peak_friction", "-", np.inf, 0.3, 5.0, 1.2, (1.1, 0.4)),),
                _friction(f"peak_friction_inverse_{axle}"), rank=2,
                decided_by="wheel forces", lines=("f", "3f"), usual=True,
            )
            for axle in ("front", "rear")
        ),
        CarEffect(
            "tyre_load_sensitivity", "all", "physics",
            "C = C_0 / sqrt(1 + degression (F_y/F_z)^2): load moved between the wheels costs force",
            "lateral load transfer grows with the lateral force",
            (Number("degression", "-", 0.0, 0.0, 10.0, 0.3),), _slot("degression"), rank=3,
            decided_by="wheel forces and loads", lines=("f", "3f"),
        ),
        CarEffect(
            "tyre_relaxation", "all", "physics", "length/v da'/dt + a' = a",
            "lag of a rolling tyre", (Number("length_m", "m", 0.0, 0.02, 3.0, 0.4, (0.4, 0.3)),),
            _slot("relaxation_front", "relaxation_rear"), rank=2,
            decided_by="steering angle at the wheel and wheel forces", usual=True,
        ),
        CarEffect(
            "longitudinal_load_transfer", "car", "physics",
            "axle loads move by m a_x h / l; stiffness in proportion", "balance of pitch moments",
            (Number("cog_height_m", "m", 0.0, 0.0, 1.5, 0.5, (0.5, 0.15)),), _slot("cog_height"),
            rank=2, decided_by="axle loads", lines=("broadband",), usual=True,
            title="Axle loads shifted by longitudinal acceleration",
        ),
        CarEffect(
            "combined_slip", "car_rear", "physics",
            "rear stiffness falls by 1/(1 + k (a_x/g)^2)", "drive and brake force of the rear axle",
            (Number("k", "-", 0.0, 0.0, 20.0, 0.5, (0.0, 1.0)),), _slot("combined_slip"), rank=3,
            decided_by="wheel torques", lines=("broadband",), usual=fast,
            title="Rear cornering stiffness reduced by drive and brake forces",
        ),
        CarEffect(
            "car_aerodynamics", "car", "physics", "axle load falls by coefficient v^2",
            "lift of a car body",
            (
                Number("front_n_per_m2_s2", "N s2/m2", 0.0, -2.0, 2.0, 0.1, (0.0, 0.3)),
                Number("rear_n_per_m2_s2", "N s2/m2", 0.0, -2.0, 2.0, 0.1, (0.0, 0.3)),
            ),
            _lift, rank=3, decided_by="axle loads or ride heights at speed", lines=("mean",),
            usual=fast, title="Aerodynamic lift of the car",
        ),
        CarEffect(
            "parameter_error", "car.yaw_inertia", "parameter", "true = factor x value of the file",
            "the user's file", (replace(_FACTOR, known=(1.0, 0.1)),),
            _slot("yaw_inertia", factor=True), rank=4, decided_by="measuring the value", usual=True,
        ),
        CarEffect(
            "parameter_error", "car.steering_ratio", "parameter",
            "true = factor x value of the file", "the user's file",
            (replace(_FACTOR, known=(1.0, 0.1)),), _ratio, rank=4,
            decided_by="road-wheel angle measured at the wheel", usual=True,
        ),
        CarEffect(
            "sensor_gain", "speed", "measurement", "measured = factor x true", _FAULT,
            (_FACTOR,), _speed, rank=6, decided_by="GPS speed",
        ),
        CarEffect(
            "sensor_delay", STEER, "measurement", "measured(t) = true(t - delay)", _FAULT,
            (replace(_LAG, known=(0.0, 0.03)),), _steering_delay, rank=5, decided_by=_SECOND,
            usual=True,
        ),
        CarEffect(
            "steering_free_play", "steering", "physics", "backlash of the column", "gap",
            (Number("gap_deg", "deg", 0.0, 0.0, 20.0, 2.0),), _free_play, rank=5,
            decided_by="road-wheel angle measured at the wheel",
        ),
    ]  # fmt: skip
    for channel in (YAW, ACC):
        if channel in channels:
            found += [
                CarEffect(
                    "sensor_gain", channel, "measurement", "measured = factor x true", _FAULT,
                    (_FACTOR,), observe=_gain(channel), rank=6, decided_by=_SECOND,
                ),
                CarEffect(
                    "sensor_delay", channel, "measurement", "measured(t) = true(t - delay)",
                    _FAULT, (_LAG,), observe=_delay(channel), rank=5, decided_by=_SECOND,
                ),
            ]  # fmt: skip
    if ACC in channels:
        found += [
            CarEffect(
                "sensor_roll_gravity", ACC, "measurement",
                "measured = a_y + g roll, roll: second order behind a_y",
                "the body rolls outwards and its accelerometer sees gravity",
                (
                    Number("roll_per_acceleration", "rad per m/s2", 0.0, -0.03, 0.04, 0.008),
                    # as passenger cars have them; the data may move them within that
                    Number("roll_frequency_rad_s", "rad/s", 10.0, 7.0, 25.0, 10.0, (10.0, 2.0)),
                    Number("roll_damping", "-", 0.35, 0.15, 1.0, 0.35, (0.35, 0.15)),
                ),
                observe=_roll, rank=0, decided_by="roll angle or roll rate by an inertial unit",
                usual=True,
            ),
            CarEffect(
                "parameter_error", f"{ACC}.position", "parameter",
                "the accelerometer sits shift_m ahead of its position in signals.toml",
                "the user's file", (Number("shift_m", "m", 0.0, -2.5, 2.5, 0.3, (0.0, 0.6)),),
                observe=_position, rank=3, decided_by="a tape measure", lines=("f",), usual=True,
            ),
        ]  # fmt: skip
    return found


EDGE_S = 2.0  # length of the ramp into a banked stretch


def bank_effect(windows: tuple[tuple[int, float, float], ...]) -> CarEffect:
    """Road bank of one angle in windows (run, start, stop)."""

    def act(car: CarInput, time: Array, values: Values) -> None:
        for number, (where, start, stop) in enumerate(windows):
            if where == car.run:
                rise = np.clip((time - start) / EDGE_S + 0.5, 0.0, 1.0)
                fall = np.clip((stop - time) / EDGE_S + 0.5, 0.0, 1.0)
                angle = np.radians(values[f"angle_deg_{number}"])
                car.bank = car.bank + angle * np.minimum(rise, fall)

    return CarEffect(
        "road_bank", "road", "physics", "g sin(bank) acts on the car and on the accelerometer",
        "gravity",
        tuple(Number(f"angle_deg_{i}", "deg", 0.0, -25.0, 25.0, 0.0) for i in range(len(windows))),
        act, rank=1, decided_by="a survey of the road, or an inertial unit", lines=("mean",),
        windows=windows,
    )  # fmt: skip
