"""The driver: turns the meant steering angle into what the hands do.

``holds`` steers the plan and keeps the wheel there. ``lets_go`` takes the hands off: the wheel
then turns under the aligning moment of the front tyres. ``over_corrects`` answers the car's yaw
rate, too late and too much.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Protocol

from swaywatch.simulate.plant import Plant
from swaywatch.simulate.table import Table


class Driver(Protocol):
    """A driver is asked once per sample for the angle at the next one."""

    def steer(self, meant_rad: float, plant: Plant) -> float:
        """Steering-wheel angle in rad for the next sample."""


class LetsGo:
    """Hands off from a time on; steering wheel with inertia, damping and aligning moment.

    J delta'' = -(F_y,f trail) / i_s - d delta' - k delta, with J the steering system's inertia at
    the wheel, trail the sum of caster and pneumatic trail.
    """

    def __init__(self, table: Table, spacing_s: float, steering_ratio: float) -> None:
        self._from = table.number("from_s", 0.0, 1e5, "s", 2.0)
        self._trail = table.number("trail_m", 0.0, 0.2, "m", 0.04)
        self._inertia = table.number("inertia_kgm2", 0.005, 1.0, "kg m2", 0.05)
        self._damping = table.number("damping_nms_per_rad", 0.0, 20.0, "N m s/rad", 0.6)
        self._centring = table.number("centring_nm_per_rad", 0.0, 50.0, "N m/rad", 2.0)
        self._spacing, self._ratio = spacing_s, steering_ratio
        self._angle, self._rate = 0.0, 0.0

    def steer(self, meant_rad: float, plant: Plant) -> float:
        """The plan while the hands are on, then the free wheel."""
        if plant.time_s < self._from:
            self._rate = (meant_rad - self._angle) / self._spacing
            self._angle = meant_rad
            return meant_rad
        parts = max(1, math.ceil(self._spacing / 0.002))
        step = self._spacing / parts
        # The front force is held over the step: at 5 ms the free wheel (3 Hz) stays stable.
        moment = plant.axle_force(0) * self._trail / self._ratio
        for _ in range(parts):
            torque = -moment - self._damping * self._rate - self._centring * self._angle
            self._rate += step * torque / self._inertia
            self._angle += step * self._rate
        return self._angle


class OverCorrects:
    """Counter-steers the car's yaw rate after a reaction time, with a limited rate."""

    def __init__(self, table: Table, spacing_s: float) -> None:
        self._gain = table.number("gain_s", 0.0, 20.0, "rad per rad/s", 1.0)
        delay = table.number("reaction_s", 0.0, 2.0, "s", 0.3)
        self._from = table.number("from_s", 0.0, 1e5, "s", 0.0)
        self._limit = math.radians(table.number("rate_deg_s", 1.0, 2000.0, "deg/s", 400.0))
        self._seen: deque[float] = deque([0.0] * (round(delay / spacing_s) + 1))
        self._spacing = spacing_s
        self._correction = 0.0

    def steer(self, meant_rad: float, plant: Plant) -> float:
        """The plan plus the late correction."""
        self._seen.append(plant.value("car_yaw_rate"))
        wanted = -self._gain * self._seen.popleft() if plant.time_s >= self._from else 0.0
        most = self._limit * self._spacing
        self._correction += min(max(wanted - self._correction, -most), most)
        return meant_rad + self._correction


DRIVERS = ("holds", "lets_go", "over_corrects")
"""Words for ``kind``."""


def make_driver(table: Table, spacing_s: float, steering_ratio: float) -> Driver | None:
    """The driver of a scenario; None for one who holds the wheel as planned."""
    kind = table.word("kind", DRIVERS, "holds")
    driver: Driver | None = None
    if kind == "lets_go":
        driver = LetsGo(table, spacing_s, steering_ratio)
    elif kind == "over_corrects":
        driver = OverCorrects(table, spacing_s)
    table.done()
    return driver
