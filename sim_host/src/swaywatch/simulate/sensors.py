"""Sensors: from a quantity of the plant to what a logger would have of it.

In this order: mounting position, roll and gravity, gain, delay, bias and drift, noise,
quantisation. Numbers are in the channel's SI unit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from swaywatch.models.double_track import Trace
from swaywatch.plant.layout import Array
from swaywatch.plant.vehicle_view import GRAVITY
from swaywatch.roles import CHANNELS
from swaywatch.simulate.table import Table


@dataclass(frozen=True)
class Sensor:
    """One sensor; the default is a perfect one.

    Attributes
    ----------
    noise : standard deviation per sample
    quantisation : step
    bias, drift_per_s : offset, and its growth
    gain : factor on the quantity
    delay_s : age of the value in a sample
    position_m : of an accelerometer, ahead of its body's COG; None: rear axle / COG
    roll_gravity : the accelerometer rolls with the body and sees gravity
    frozen_from_s : from then on the last value stays
    """

    noise: float = 0.0
    quantisation: float = 0.0
    bias: float = 0.0
    drift_per_s: float = 0.0
    gain: float = 1.0
    delay_s: float = 0.0
    position_m: float | None = None
    roll_gravity: bool = False
    frozen_from_s: float = math.inf

    def measure(
        self, time_s: Array, value: Array, at_s: Array, random: np.random.Generator
    ) -> Array:
        """Samples at ``at_s`` of a quantity known at ``time_s``."""
        seen = np.minimum(at_s, self.frozen_from_s) - self.delay_s
        out = self.gain * np.interp(seen, time_s, value)
        out = out + self.bias + self.drift_per_s * (at_s - at_s[0])
        if self.noise > 0.0:
            noise = random.normal(0.0, self.noise, at_s.size)
            out = out + np.where(at_s > self.frozen_from_s, 0.0, noise)
        if self.quantisation > 0.0:
            out = self.quantisation * np.rint(out / self.quantisation)
        return np.asarray(out)


_DEG = math.pi / 180.0
_TYPICAL: dict[str, Sensor] = {
    "steering_wheel_angle": Sensor(noise=0.05 * _DEG, quantisation=0.1 * _DEG),
    "speed": Sensor(noise=0.09 / 3.6, quantisation=0.01 / 3.6),
    "yaw_rate": Sensor(noise=0.05 * _DEG, quantisation=0.01 * _DEG),
    "lateral_acceleration": Sensor(noise=0.03, quantisation=0.002),
    "articulation": Sensor(noise=0.02 * _DEG, quantisation=0.01 * _DEG),
    "hitch": Sensor(noise=15.0, quantisation=1.0),
    "wheel_lateral_force": Sensor(noise=30.0, quantisation=1.0),
    "wheel_vertical_load": Sensor(noise=60.0, quantisation=1.0),
}
_PRODUCTION: dict[str, Sensor] = {
    "steering_wheel_angle": Sensor(noise=0.05 * _DEG, quantisation=0.1 * _DEG, bias=1.0 * _DEG),
    "speed": Sensor(noise=0.1 / 3.6, quantisation=0.05 / 3.6),
    "yaw_rate": Sensor(
        noise=0.15 * _DEG, quantisation=0.1 * _DEG, bias=0.3 * _DEG, drift_per_s=0.0005 * _DEG
    ),
    "lateral_acceleration": Sensor(noise=0.06, quantisation=0.05, bias=0.1, drift_per_s=1e-4),
}
"""Of stability control. Steps: Bosch Motorsport data sheets MM7.10 (yaw rate 0.1 deg/s) and LWS
(steering, 780 deg in 16 bits at 0.1 deg); offsets: workshop manual of Hyundai's ESP sensor (at most
3.75 deg/s and 0.09 g over its life), of which an ECU leaves about a tenth after standstill."""

PRESETS = ("perfect", "typical", "production", "wheel_force_rims")
"""Words for ``preset``: perfect sensors; those of a fully instrumented test vehicle; what a
production car has of its own (steering, speed, yaw rate, lateral acceleration); that with
wheel-force rims on the car."""


def preset(name: str, channel: str) -> Sensor | None:
    """Sensor of a channel before the scenario changes it; None where the set has none."""
    if name == "perfect":
        return Sensor()
    if name == "typical":
        return next(sensor for key, sensor in _TYPICAL.items() if key in channel)
    if channel.startswith("trailer"):
        return None
    if name == "wheel_force_rims" and channel.startswith("wheel_"):
        return next(sensor for key, sensor in _TYPICAL.items() if key in channel)
    return next((sensor for key, sensor in _PRODUCTION.items() if key in channel), None)


def read_sensors(table: Table, channels: list[str]) -> dict[str, Sensor]:
    """Sensors of all channels from ``[sensors]``; ``off = true`` leaves a channel out."""
    name = table.word("preset", PRESETS, "typical")
    every = {channel: preset(name, channel) for channel in channels}
    sensors = {channel: sensor for channel, sensor in every.items() if sensor is not None}
    for channel in [key for key in table.keys() if key != "preset"]:  # noqa: SIM118
        if channel not in channels:
            table.raw("preset")
            table.done()
        entry = table.table(channel)
        if entry.flag("off", False):
            sensors.pop(channel, None)
        else:
            sensors[channel] = _read(entry, sensors.get(channel, Sensor()), CHANNELS[channel].unit)
        entry.done()
    table.done()
    return sensors


def _read(table: Table, base: Sensor, unit: str) -> Sensor:
    big = 1e6
    position = base.position_m
    if table.has("position_m"):
        position = table.number("position_m", -20.0, 20.0, "m")
    return replace(
        base,
        noise=table.number("noise", 0.0, big, unit, base.noise),
        quantisation=table.number("quantisation", 0.0, big, unit, base.quantisation),
        bias=table.number("bias", -big, big, unit, base.bias),
        drift_per_s=table.number("drift_per_s", -big, big, f"{unit} per s", base.drift_per_s),
        gain=table.number("gain", -10.0, 10.0, "1", base.gain),
        delay_s=table.number("delay_s", 0.0, 2.0, "s", base.delay_s),
        position_m=position,
        roll_gravity=table.flag("roll_gravity", base.roll_gravity),
        frozen_from_s=table.number("frozen_from_s", 0.0, 1e9, "s", 1e9),
    )


def quantity(trace: Trace, channel: str, sensor: Sensor, rear_axle_m: float) -> tuple[Array, float]:
    """What a sensor would see of the plant, and its position."""
    if not channel.endswith("lateral_acceleration"):
        return trace[channel], 0.0
    body = channel.split("_", maxsplit=1)[0]
    position = sensor.position_m
    if position is None:
        position = -rear_axle_m if body == "car" else 0.0
    value = trace.lateral_acceleration(body, position)
    if sensor.roll_gravity:
        value = value + GRAVITY * np.sin(trace[f"{body}_roll"])
    return value, position


def available(trace: Mapping[str, Array]) -> list[str]:
    """Channels of :data:`swaywatch.roles.CHANNELS` that the plant has."""
    return [name for name in CHANNELS if name in trace]
