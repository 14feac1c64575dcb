"""Healthy drives of random combinations on springs, with the noise and the grid of a logger.

Whatever a check of the sensors says of one of them is a false claim; a fault put into one must be
found. What the user believes of the vehicle is off by the usual tolerances.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.signal import butter, sosfilt

from swaywatch.drive import Channel, Drive
from swaywatch.plant.lanes import BODY, GRAVITY, OUTPUT, PlantInput, neutral, simulate
from swaywatch.plant.sprung import defaults, put, tolerances
from swaywatch.roles import WHEELS
from swaywatch.vehicle import Car, Trailer, Vehicle

Array = npt.NDArray[np.float64]

STEP_S = 0.01
MANOEUVRES = ("tone", "tones", "impulses", "lane_change", "one_sided", "free", "bend")
SENSORS = ("all", "no_forces", "own")
NOISE = {
    "steering_wheel_angle": (0.0, math.radians(0.1), math.radians(0.3)),
    "speed": (0.03, 0.01 / 3.6, 0.0),
    "car_yaw_rate": (math.radians(0.05), math.radians(0.01), math.radians(0.05)),
    "trailer_yaw_rate": (math.radians(0.05), math.radians(0.01), math.radians(0.05)),
    "car_lateral_acceleration": (0.03, 0.002, 0.04),
    "trailer_lateral_acceleration": (0.034, 0.002, 0.04),
    "hitch": (11.5, 1.0, 15.0),
    "lateral_force": (32.0, 1.0, 12.0),
    "vertical_load": (122.0, 1.0, 1.0),
}
"""Noise, resolution and offset (standard deviations) of the practice recordings' sensors."""


@dataclass(frozen=True)
class Drawn:
    """A drive and what the user believes of the vehicle."""

    drive: Drive
    vehicle: Vehicle
    manoeuvre: str
    sensors: str


def drawn(seed: int, **fixed: str) -> Drawn:
    """Drive number `seed`; `fixed` may say its manoeuvre and its sensors."""
    rng = np.random.default_rng((20261122, seed))
    body = draw_body(rng)
    manoeuvre = fixed.get("manoeuvre", str(rng.choice(np.array(MANOEUVRES))))
    sensors = fixed.get("sensors", str(rng.choice(np.array(SENSORS), p=(0.5, 0.3, 0.2))))
    length = float(rng.choice(np.array([8.0, 12.0, 20.0, 40.0])))
    time = np.arange(0.0, length, STEP_S)
    shape, mean = steering(manoeuvre, time, rng), float(rng.uniform(16.0, 27.0))
    speed = mean + 0.2 * np.sin(2.0 * np.pi * (time / rng.uniform(9.0, 20.0) + rng.random()))
    found, size = None, math.radians(float(rng.uniform(4.0, 15.0))) / 15.0
    slots = springs(body, rng)
    for _ in range(6):  # as hard as a road test, no harder
        found = run(body, slots, size * shape, speed)
        worst = float(np.abs(found["car_acceleration"]).max())
        if np.isfinite(worst) and 0.0 < worst < 5.0:
            break
        size *= 0.5
    assert found is not None
    places = (float(rng.uniform(-1.4, 0.5)), float(rng.uniform(-0.5, 0.5)))
    channels = measured(found, 15.0 * size * shape, speed, time, body, places, sensors, rng)
    drive = Drive(f"drawn{seed}", (Path(f"drawn{seed}.blf"),), channels, 0)
    return Drawn(drive, believed(body, rng), manoeuvre, sensors)


def draw_body(rng: np.random.Generator) -> Array:
    """A car and a trailer with one axle or two; the static loads follow from the nose weight."""
    car = rng.uniform(1200.0, 2600.0)
    base, ahead = rng.uniform(2.5, 3.0), rng.uniform(0.44, 0.54)
    trailer, length = car * rng.uniform(0.4, 1.05), rng.uniform(3.2, 5.5)
    axles = (ahead * base, (1.0 - ahead) * base)
    tandem = rng.random() < 0.5
    behind = 0.2 + rng.uniform(-0.05, 0.1)
    apart = 0.4 if tandem else 0.0
    values = {
        "car.mass": car,
        "car.yaw_inertia": car * axles[0] * axles[1] * rng.uniform(0.9, 1.1),
        "car.front_axle_to_cog": axles[0],
        "car.rear_axle_to_cog": axles[1],
        "car.hitch_to_cog": axles[1] + rng.uniform(0.75, 1.1),
        "trailer.mass": trailer,
        "trailer.yaw_inertia": trailer * (0.36 * length) ** 2 * rng.uniform(0.8, 1.2),
        "trailer.front_axle_to_cog": apart - behind,
        "trailer.rear_axle_to_cog": apart + behind,
        "trailer.hitch_to_cog": length,
    }
    nose = trailer * GRAVITY * behind / (length + behind)
    total, lever = car * GRAVITY, values["car.hitch_to_cog"]
    front = (total * axles[1] - nose * (lever - axles[1])) / base
    loads = {"car.front_axle_load": front, "car.rear_axle_load": total + nose - front}
    rest = trailer * GRAVITY - nose
    loads["trailer.front_axle_load"] = 0.5 * rest if tandem else 0.0
    loads["trailer.rear_axle_load"] = rest - loads["trailer.front_axle_load"]
    values |= loads
    for name, factor in (("car.front", 13.0), ("car.rear", 20.0), ("trailer.front", 15.0),
                         ("trailer.rear", 15.0)):  # fmt: skip
        stiffness = loads[f"{name}_axle_load"] * factor * rng.uniform(0.85, 1.15)
        values[f"{name}_cornering_stiffness"] = stiffness
    return np.array([values[name] for name in BODY])


def springs(body: Array, rng: np.random.Generator) -> dict[str, float]:
    """Springs, heights and tyres of a vehicle, somewhere within what is usual."""
    values = defaults(body)
    spread = tolerances(values)
    for name, value in values.items():
        factor = float(np.clip(rng.standard_normal(), -1.5, 1.5))
        values[name] = value + factor * spread[name]
    seen = float(rng.random() < 0.7)  # else the logger has taken gravity out
    values |= {"sensed_roll_car": seen, "sensed_roll_trailer": seen}
    tyres = rng.uniform(0.1, 0.7, size=3)
    names = ("relaxation_car_front", "relaxation_car_rear", "relaxation_trailer")
    values |= dict(zip(names, tyres, strict=True))
    return values | {
        "peak_friction_inverse": 1.0 / rng.uniform(0.9, 1.2),
        "degression": float(rng.uniform(0.0, 0.25)),
        "steering_flexibility": float(rng.uniform(0.0, 2e-6)),
    }


def run(body: Array, slots: dict[str, float], steer: Array, speed: Array) -> dict[str, Array]:
    """Outputs of the plant by name."""
    plant = PlantInput(STEP_S, speed, np.gradient(speed, STEP_S), steer, body,
                       put(neutral(), slots))  # fmt: skip
    found = simulate(plant)
    return {name: found[:, index] for index, name in enumerate(OUTPUT)}


def steering(manoeuvre: str, time: Array, rng: np.random.Generator) -> Array:
    """Road-wheel angle of size about 1."""
    start = rng.uniform(0.8, 1.5)
    rise = np.clip((time - start) / 1.0, 0.0, 1.0)
    hz = float(rng.uniform(0.3, 0.7))
    hands = sosfilt(butter(2, 0.5, fs=1.0 / STEP_S, output="sos"), rng.standard_normal(time.size))
    hands = 0.02 * hands / (np.std(hands) + 1e-12)
    shaped = sosfilt(butter(2, 0.6, fs=1.0 / STEP_S, output="sos"), rng.standard_normal(time.size))
    total = 0.4 * rise * shaped / (np.std(shaped) + 1e-12)  # free driving
    if manoeuvre == "tone":
        total = rise * np.sin(2.0 * np.pi * hz * (time - start)) + 0.1 * hands
    elif manoeuvre == "tones":
        other = hz * rng.uniform(1.3, 1.8)
        first = 0.6 * np.sin(2.0 * np.pi * hz * (time - start))
        second = np.sin(2.0 * np.pi * other * (time - start))
        total = rise * np.where(time < 0.5 * time[-1], first, second) + hands
    elif manoeuvre == "impulses":
        total = hands.copy()
        for at in np.arange(start, time[-1] - 3.0, 12.0):
            inside = (time > at) & (time < at + 0.74)
            total += np.where(inside, np.sin(np.pi * (time - at) / 0.74), 0.0)
    elif manoeuvre == "lane_change":
        inside = (time > start) & (time < start + 2.0)
        back = (time > start + 4.0) & (time < start + 6.0)
        wave = np.where(inside, np.sin(np.pi * (time - start)), 0.0)
        total = wave - np.where(back, np.sin(np.pi * (time - start - 4.0)), 0.0) + hands
    elif manoeuvre == "one_sided":  # held in a bend, let go, held again
        up = np.clip(6.0 * np.sin(2.0 * np.pi * hz / 3.0 * (time - start)), 0.0, 1.0)
        total = rise * 0.4 * up + 0.1 * hands
    elif manoeuvre == "bend":
        total = 0.5 * np.clip((time - start) / (0.5 * time[-1]), 0.0, 1.0) + hands
    return np.asarray(total)


def measured(
    found: dict[str, Array],
    steer: Array,
    speed: Array,
    time: Array,
    body: Array,
    places: tuple[float, float],
    sensors: str,
    rng: np.random.Generator,
) -> dict[str, Channel]:
    """Channels as a logger has them; accelerometers `places` ahead of the centres of gravity."""
    side = found["car_acceleration"] + places[0] * found["car_yaw_acceleration"]
    behind = found["trailer_acceleration"] + places[1] * found["trailer_yaw_acceleration"]
    truth = {
        "steering_wheel_angle": steer,
        "speed": speed,
        "car_yaw_rate": found["car_yaw_rate"],
        "car_lateral_acceleration": side,
    }
    if sensors != "own" or rng.random() < 0.7:
        truth["trailer_yaw_rate"] = found["trailer_yaw_rate"]
    if sensors != "own":
        truth["trailer_lateral_acceleration"] = behind
    if sensors == "all":
        truth |= {"hitch_longitudinal_force": found["hitch_x"]}
        truth |= {"hitch_lateral_force": found["hitch_y"]}
        single = body[BODY.index("trailer.front_axle_load")] == 0.0
        trailer = rng.random() < 0.5
        for wheel in WHEELS:
            truth[f"wheel_lateral_force_{wheel}"] = found[f"lateral_{wheel}"]
            truth[f"wheel_vertical_load_{wheel}"] = found[f"vertical_{wheel}"]
            if trailer and not (single and wheel.startswith("f")):
                for quantity in ("lateral", "vertical"):
                    role = {"lateral": "lateral_force", "vertical": "vertical_load"}[quantity]
                    truth[f"trailer_wheel_{role}_{wheel}"] = found[f"trailer_{quantity}_{wheel}"]
    place = {"car_lateral_acceleration": places[0], "trailer_lateral_acceleration": places[1]}
    two = bool(rng.random() < 0.2)  # loggers, on one clock
    return {
        name: _channel(name, value, time, place.get(name, 0.0), two, rng)
        for name, value in truth.items()
    }


def _channel(
    name: str, value: Array, time: Array, place: float, two: bool, rng: np.random.Generator
) -> Channel:
    kind = next(key for key in NOISE if key in name)
    size, resolution, offset = NOISE[kind]
    white = sosfilt(butter(3, 22.0, fs=1.0 / STEP_S, output="sos"), rng.standard_normal(time.size))
    phase = float(rng.uniform(0.0, STEP_S))
    taken = np.interp(time[:-1] + phase, time, value)
    taken = taken + size * white[:-1] / 0.66 + offset * rng.standard_normal()
    rough = np.round(taken / resolution) * resolution
    stamps = time[:-1] + phase + 0.00012 * np.abs(rng.standard_normal(time.size - 1))
    return Channel(
        name,
        stamps,
        rough,
        name,
        "",
        place,
        ("trailer.blf" if two and name.startswith("trailer") else "car.blf",),
        resolution=resolution,
    )


def vehicle_of(body: Iterable[float]) -> Vehicle:
    """The vehicle of values in the order of `BODY`; without a load its front axle is left out."""
    values: dict[str, dict[str, float | None]] = {"car": {}, "trailer": {}}
    for name, value in zip(BODY, body, strict=True):
        table, key = name.split(".")
        values[table][key] = float(value)
    if values["trailer"]["front_axle_load"] == 0.0:
        for key in [key for key in values["trailer"] if key.startswith("front")]:
            values["trailer"][key] = None
    car = Car(**values["car"], steering_ratio=15.0)  # type: ignore[arg-type]
    return Vehicle(car, Trailer(**values["trailer"]))  # type: ignore[arg-type]


def believed(body: Array, rng: np.random.Generator) -> Vehicle:
    """The vehicle as its user knows it."""
    spread = {"mass": 0.025, "yaw_inertia": 0.1, "stiffness": 0.08, "load": 0.02}
    values = []
    for name, value in zip(BODY, body, strict=True):
        if name.endswith("to_cog"):
            values.append(value + 0.03 * rng.standard_normal())
        else:
            share = next(s for word, s in spread.items() if word in name.split(".")[1])
            values.append(value * (1.0 + share * rng.standard_normal()))
    return vehicle_of(values)


def scaled(drive: Drive, name: str, factor: float) -> Drive:
    """The drive with a channel of the wrong sign or unit."""
    channel = drive.channels[name]
    changed = replace(channel, value=channel.value * factor)
    return replace(drive, channels={**drive.channels, name: changed})
