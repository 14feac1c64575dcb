"""Dry friction at the ball holds small swings and lets large ones go.

The critical speed that counts is that of a swing which friction does not hold. Before it was taken
out of the inertias, the drives of this file with 150 Nm ended with 136 to 248 km/h, 27 to 105 too
many and 2.6 to 7.6 of their standard errors.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from swaywatch.drive import Channel, Drive
from swaywatch.ecu.core import QUALITY, VALID, Core, positions_of
from swaywatch.models import modes
from swaywatch.plant.lanes import BODY, OUTPUT, PlantInput, neutral, simulate
from swaywatch.roles import WHEELS
from swaywatch.vehicle import Car, Trailer, Vehicle

KMH = 3.6
STEP_S = 0.01
GRAVITY = 9.81
NOISE = {"yaw_rate": 8.7e-4, "acceleration": 0.03, "hitch": 11.5, "force": 32.0, "load": 122.0}
NAMES = ("front", "rear")


def body_of(seed: int) -> tuple[np.ndarray[Any, np.dtype[np.float64]], Vehicle]:
    """A combination about the reference's, the trailer with one axle or two, and what is known."""
    rng = np.random.default_rng((77, seed))
    mass = rng.uniform(900, 2300)
    shift = rng.uniform(-0.25, 0.2)
    tyres = np.array([109.3e3, 185.2e3, 131.2e3, 124.4e3]) * rng.uniform(0.85, 1.15, 4)
    tyres[2:] *= (mass / 1880) ** 0.7
    single = bool(rng.random() < 0.4)
    ahead, behind = (-(0.2 + shift), 0.2 + shift) if single else (0.124 - shift, 0.526 + shift)
    car = {
        "mass": rng.uniform(1600, 2200), "yaw_inertia": 2690 * rng.uniform(0.85, 1.15),
        "front_axle_to_cog": 1.302, "rear_axle_to_cog": 1.383, "hitch_to_cog": 2.166,
        "front_cornering_stiffness": tyres[0], "rear_cornering_stiffness": tyres[1],
    }  # fmt: skip
    trailer = {
        "mass": mass, "yaw_inertia": 10350 * mass / 1880 * rng.uniform(0.8, 1.15),
        "front_axle_to_cog": ahead, "rear_axle_to_cog": behind, "hitch_to_cog": 5.073 - shift,
        "front_cornering_stiffness": 0.0 if single else tyres[2],
        "rear_cornering_stiffness": tyres[2] + tyres[3] if single else tyres[3],
    }  # fmt: skip
    middle = behind if single else 0.5 * (behind - ahead)
    nose = mass * GRAVITY * middle / (trailer["hitch_to_cog"] + middle)
    weight = car["mass"] * GRAVITY
    car["front_axle_load"] = (weight * 1.383 - nose * (2.166 - 1.383)) / 2.685
    car["rear_axle_load"] = weight + nose - car["front_axle_load"]
    rest = mass * GRAVITY - nose
    trailer["front_axle_load"] = 0.0 if single else 0.5 * rest
    trailer["rear_axle_load"] = rest - trailer["front_axle_load"]
    tables = {"car": car, "trailer": trailer}
    body = np.array([tables[name.split(".")[0]][name.split(".")[1]] for name in BODY])
    known: dict[str, Any] = dict(trailer)
    if single:
        known |= {key: None for key in trailer if key.startswith("front")}
    return body, Vehicle(Car(**car, steering_ratio=15.0), Trailer(**known))


def critical_kmh(body: np.ndarray[Any, np.dtype[np.float64]]) -> float:
    """Critical speed without friction, by eigenvalues."""
    still = np.zeros(3)
    return KMH * modes.critical_speed(
        PlantInput(0.002, still + 20.0, still, still, body, neutral())
    )


def drive_of(
    body: np.ndarray[Any, np.dtype[np.float64]], moment_nm: float, speed: float, rims: bool
) -> Drive:
    """40 s with a kick of 4 deg at the wheel every 9 s: swings of 1 to 2 deg/s."""
    time = np.arange(0.0, 40.0, STEP_S)
    wheel = np.zeros_like(time)
    for number, start in enumerate(np.arange(2.0, 37.0, 9.0)):
        inside = (time > start) & (time < start + 0.74)
        size = math.radians(4.0) * (-1) ** number
        wheel += np.where(inside, size * np.sin(np.pi * (time - start) / 0.74), 0.0)
    plant = PlantInput(
        STEP_S, np.full_like(time, speed), np.zeros_like(time), wheel / 15.0, body, neutral()
    )
    plant.scalar("hitch_friction", moment_nm)
    plant.scalar("hitch_sticking", 0.01)
    found = dict(zip(OUTPUT, simulate(plant).T, strict=True))
    truth = {
        "steering_wheel_angle": wheel, "speed": np.full_like(time, speed),
        "car_yaw_rate": found["car_yaw_rate"],
        "car_lateral_acceleration": found["car_acceleration"],
        "trailer_yaw_rate": found["trailer_yaw_rate"],
        "trailer_lateral_acceleration": found["trailer_acceleration"],
        "hitch_longitudinal_force": found["hitch_x"], "hitch_lateral_force": found["hitch_y"],
    }  # fmt: skip
    for wheel_name in WHEELS if rims else ():
        truth[f"wheel_lateral_force_{wheel_name}"] = found[f"lateral_{wheel_name}"]
        truth[f"wheel_vertical_load_{wheel_name}"] = found[f"vertical_{wheel_name}"]
    rng = np.random.default_rng(1)
    channels = {}
    for name, value in truth.items():
        noise = next((size for word, size in NOISE.items() if word in name), 0.0)
        measured = value + noise * rng.standard_normal(time.size)
        channels[name] = Channel(name, time, measured, name, "", 0.0)
    return Drive("friction", (), channels, 0)


@pytest.mark.parametrize("rims", [True, False])
@pytest.mark.parametrize("seed", [0, 2, 3, 4])
def test_friction_at_the_ball_adds_no_critical_speed(seed: int, rims: bool) -> None:
    body, vehicle = body_of(seed)
    truth = critical_kmh(body)
    speed = 0.9 * truth / KMH
    flagged = {}
    for moment_nm in (0.0, 150.0):
        drive = drive_of(body, moment_nm, speed, rims)
        status, _ = Core(vehicle, positions_of(drive)).feed(drive)
        valid = status[status["valid"] & VALID["critical_speed"] != 0]
        late = valid[len(valid) // 3 :]
        found, error = KMH * 1e-3 * late["v_crit_mm_s"], KMH * 1e-3 * late["v_crit_se_mm_s"]
        assert len(late) > 10
        assert np.all(found < truth + 3.0 * error), (moment_nm, found.max())
        assert abs(found[-1] - truth) < 3.0 * error[-1] + 1.0
        assert error[-1] < 0.08 * truth
        flagged[moment_nm] = np.mean(late["quality"] & QUALITY["hitch"] != 0)
        assert np.all(late["quality"] & QUALITY["small_swing"] != 0)  # 15 deg/s were not driven
        assert np.degrees(late["v_crit_swing_urad_s"][-1] * 1e-6) < 5.0
    assert flagged[0.0] < 0.02
    assert flagged[150.0] > 0.2
