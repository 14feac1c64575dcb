"""Tyres hold less in larger swings: the critical speed of a swing of the limit amplitude.

Truth is a simulated plant with tyres that saturate (``tests/bench/warning_plant.py``, independent
of the core): the speed at which a swing of 15 deg/s neither grows nor decays, by bisection over
the driver's impulse and the speed. The core sees swings of 2 to 5 deg/s.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "bench"))

import warning_campaign as warning
import warning_plant as plant

from swaywatch.ecu.core import VALID, Core, positions_of
from swaywatch.vehicle import Car, Trailer, Vehicle

FloatArray = npt.NDArray[np.float64]


def known(c: plant.Combination) -> Vehicle:
    """The combination as it is."""
    car = Car(
        mass=c.m1, yaw_inertia=c.i1, front_axle_to_cog=c.lf1, rear_axle_to_cog=c.lr1,
        steering_ratio=c.ratio, hitch_to_cog=c.lh1, front_cornering_stiffness=c.stiffness[0],
        rear_cornering_stiffness=c.stiffness[1],
    )  # fmt: skip
    trailer = Trailer(
        mass=c.m2, yaw_inertia=c.i2, front_axle_to_cog=c.lf2, rear_axle_to_cog=c.lr2,
        hitch_to_cog=c.lh2, front_cornering_stiffness=c.stiffness[2],
        rear_cornering_stiffness=c.stiffness[3],
    )  # fmt: skip
    return Vehicle(car, trailer, Path("vehicle.toml"))


def peaks(c: plant.Combination, speed: float, angle: float) -> FloatArray:
    """Sizes of the trailer's swings from 3 s on after an impulse of the steering wheel."""
    course = plant.course(14, speed)
    course.wheel += plant.half_sine(course.time_s, 1.0, 0.7, angle)
    rate = plant.simulate(c, course).trailer_yaw_rate
    turns = np.flatnonzero(np.diff(np.sign(np.diff(rate))) != 0) + 1
    return np.abs(rate[turns[turns > 300]])


def held_swing(c: plant.Combination, speed: float) -> float:
    """Amplitude of the swing that neither grows nor decays at a speed, rad/s."""
    low, high = 0.0, math.radians(60)
    for _ in range(22):
        middle = 0.5 * (low + high)
        size = peaks(c, speed, middle)
        grows = len(size) < 6 or size.max() > 1.0 or size[-3:].mean() > size[:3].mean()
        low, high = (low, middle) if grows else (middle, high)
    return float(peaks(c, speed, low)[:8].mean())


def limit_speed(c: plant.Combination, swing: float) -> float:
    """Speed at which a swing of this size neither grows nor decays, m/s."""
    high = plant.critical_speed(c)
    low = 0.75 * high
    for _ in range(9):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if held_swing(c, middle) > swing else (low, middle)
    return 0.5 * (low + high)


@pytest.mark.parametrize(
    ("seed", "friction"),
    [(5, 0.95), (7, 0.95), (10, 0.95), (13, 0.95), (31, 0.95), (4, 0.75), (14, 0.75), (40, 1.1)],
)
def test_the_limit_in_a_large_swing_is_that_of_the_saturating_plant(
    seed: int, friction: float
) -> None:
    c = replace(warning.combination(np.random.default_rng(seed)), peak_friction=friction)
    linear = plant.critical_speed(c)
    course = plant.course(60, 0.92 * linear)
    for k, start in enumerate(range(4, 56, 9)):
        angle = math.radians(4.0) * (-1) ** k
        course.wheel += plant.half_sine(course.time_s, start, 0.7, angle)
    samples = plant.measure(plant.simulate(c, course), np.random.default_rng(7))
    drive = warning.as_drive(samples, c)
    status, _ = Core(known(c), positions_of(drive)).feed(drive)
    last = status[status["valid"] & VALID["lowest_speed"] != 0][-1]
    truth = limit_speed(c, math.radians(15))
    lowest, error = 1e-3 * last["lowest_v_crit_mm_s"], 1e-3 * last["lowest_v_crit_se_mm_s"]
    assert last["lowest_v_crit_swing_urad_s"] == 261799
    assert last["v_crit_swing_urad_s"] < math.radians(6) * 1e6
    assert truth < 0.97 * linear
    assert abs(lowest - truth) < 2 * error
    assert abs(lowest - truth) < 0.5 * (linear - truth), "nearer than the linear critical speed"
    assert error > 1e-3 * last["v_crit_se_mm_s"]


def test_tyres_that_were_not_seen_say_nothing() -> None:
    c = plant.Combination()
    drive = warning.as_drive(
        plant.measure(plant.simulate(c, plant.course(20, 25.0)), np.random.default_rng(1)), c
    )
    status, _ = Core(known(c), positions_of(drive)).feed(drive)
    assert len(status)
    assert not np.any(status["valid"] & VALID["lowest_speed"])
