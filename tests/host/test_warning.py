"""The alarm on simulated drives of an independent plant; `make bench-warning` is the campaign.

A small campaign, and what must and must not look like sway: an oscillation that the driver forces
(slalom, driver in the loop) and a free one with the wheel held.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "bench"))

import warning_campaign as warning
import warning_losses as losses
import warning_plant as plant

from swaywatch.ecu.core import QUALITY, Core, positions_of

WARNING = 3


def test_campaign() -> None:
    results = warning.campaign(drives=24, hours=0.5, first_seed=1001)
    figures = warning.summary(results)
    ours = figures["detectors"]["swaywatch"]
    assert figures["unstable_drives"] >= 10
    assert ours["false_ordinary"] == 0
    assert ours["missed"] <= 1
    assert ours["median_oscillations"] < 1.5
    others = [row for name, row in figures["detectors"].items() if name != "swaywatch"]
    assert all(ours["false_in_stable_drives"] <= row["false_in_stable_drives"] for row in others)


@pytest.mark.parametrize("how", losses.HOW)
def test_no_input_that_is_lost_silences_the_alarm(how: str) -> None:
    """Each single loss in drives that become unstable: the swing is in what is left."""
    every = list(losses.drives(1001, 3))
    for name in plant.SENSORS:
        assert losses.row(every, (name,), how).missed == [], name


def status_of(
    c: plant.Combination, course: plant.Course, rng: np.random.Generator
) -> npt.NDArray[np.void]:
    """Statuses of a core that was given slightly wrong vehicle data."""
    motion = plant.simulate(c, course)
    assert warning.end_of(motion) == len(motion.time_s) - 1
    drive = warning.as_drive(plant.measure(motion, rng), c)
    status, _ = Core(warning.believed(c, rng), positions_of(drive)).feed(drive)
    return status


def stable(rng: np.random.Generator, speed: float) -> plant.Combination:
    """A combination with a damping ratio of 0.05 or more at `speed`."""
    while True:
        c = warning.combination(rng)
        if plant.damping_ratio(c, speed) > 0.05:
            return c


@pytest.mark.parametrize("seed", range(8))
def test_a_growing_slalom_is_not_sway(seed: int) -> None:
    """Steering near the yaw frequency, each swing larger than the last: forced, no warning."""
    rng = np.random.default_rng([seed, 101])
    speed = rng.uniform(70, 100) / 3.6
    c = stable(rng, speed)
    course = plant.course(24.0, speed)
    cycles = rng.integers(5, 9)
    period = 1 / rng.uniform(0.4, 0.75)
    sine = plant.full_sine(course.time_s, 8.0, period, 1.0, float(cycles))
    course.wheel += sine * math.radians(2.0) * 1.25 ** ((course.time_s - 8.0) / period)
    plant.add_roughness(course, rng, math.radians(0.02))
    status = status_of(c, course, rng)
    time_s = status["time_us"] * 1e-6
    inside = (time_s > 8.0 + 1.5 * period) & (time_s < 8.0 + cycles * period)
    growing = (status["growth_ppm_per_s"] > 0) & inside
    assert growing.sum() >= 5
    assert np.all((status["quality"][inside] & QUALITY["forced"]) != 0)
    assert not np.any(status["alarm"][inside] >= WARNING)


@pytest.mark.parametrize("seed", range(3))
def test_a_driver_who_weaves_is_not_sway(seed: int) -> None:
    """A driver in the loop who overcorrects, with wind and lane changes: no warning."""
    rng = np.random.default_rng([seed, 102])
    c, course, motion = warning._driven(rng, 300.0)
    assert motion.steering_wheel_angle.std() > math.radians(0.3)
    assert not np.any(status_of(c, course, rng)["alarm"] >= WARNING)


@pytest.mark.parametrize("seed", range(8))
def test_a_free_oscillation_with_the_wheel_held_is_sway(seed: int) -> None:
    """The same combination beyond its critical speed, wheel held: not forced, and warned."""
    rng = np.random.default_rng([seed, 103])
    while True:
        c = warning.combination(rng)
        speed = 1.06 * plant.critical_speed(c)
        if 18 < speed < 38 and not plant.diverges(c, speed):
            break
    course = plant.course(12.0, speed)
    course.wheel += plant.half_sine(course.time_s, 3.0, 0.75, math.radians(6))
    status = status_of(c, course, rng)
    time_s = status["time_us"] * 1e-6
    held = time_s > 8.0
    assert np.all((status["quality"][held] & QUALITY["forced"]) == 0)
    assert np.any(status["alarm"][time_s > 4.0] >= WARNING)
