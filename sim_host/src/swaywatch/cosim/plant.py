"""A user's FMU as the plant of `swaywatch hil`: it stands where the double track else does."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from swaywatch.cosim.fmu import Fmu
from swaywatch.cosim.mapping import BRAKES, RATES, STEERING, wire
from swaywatch.errors import FmuError
from swaywatch.models.double_track import Trace


class FmuPlant:
    """An FMU under way, sample by sample; see :class:`swaywatch.simulate.plant.Plant`.

    Parameters
    ----------
    path, signals : the FMU, and its roles (`cosim.mapping`)
    period_s : spacing of the samples
    speed_m_s : at the start
    has_trailer : whether a trailer's yaw rate is expected of it
    rear_axle_m : of the car, behind its COG: where its accelerometer is if nothing says otherwise

    Raises
    ------
    FmuError
        It does not open, its step does not fit the period, or an output is missing.
    """

    def __init__(
        self, path: Path, signals: Path | None, period_s: float, speed_m_s: float,
        *, has_trailer: bool, rear_axle_m: float,
    ) -> None:  # fmt: skip
        self._fmu = Fmu(path)
        self._fmu.__enter__()
        try:
            self._wiring = wire(self._fmu.description, path, signals)
            self._check_outputs(has_trailer)
            self._steps = self._parts(period_s)
            self._period = period_s
            self._in = {STEERING: 0.0, "speed": speed_m_s}
            self._running = self._fmu.start(self._wiring, self._in)
            self._now = self._running.read()
        except BaseException:
            self._fmu.__exit__(None, None, None)
            raise
        self._before = self._now
        self._places = {"car": -rear_axle_m, "trailer": 0.0}
        for one in self._wiring.outputs:
            if one.role.endswith("lateral_acceleration") and one.position_m is not None:
                self._places[one.role.partition("_")[0]] = one.position_m
        self._count = 0

    def _check_outputs(self, has_trailer: bool) -> None:
        there = {one.role for one in self._wiring.outputs}
        for role in ("car_yaw_rate", *(["trailer_yaw_rate"] if has_trailer else [])):
            if role not in there:
                raise FmuError(f"{self._fmu.path}: no output for the role {role}; a drive in the "
                               "loop needs it")  # fmt: skip

    def _parts(self, period_s: float) -> int:
        step = self._fmu.step_s(period_s)
        parts = max(1, math.ceil(period_s / step - 1e-9))
        free = self._fmu.description.coSimulation.canHandleVariableCommunicationStepSize
        if not free and abs(parts * step - period_s) > 1e-9:
            raise FmuError(
                f"{self._fmu.path}: takes steps of {step:g} s only; a cycle of {period_s:g} s is "
                f"no multiple of it: rate_hz = {1.0 / step:g} in [timing] would be"
            )
        return parts

    @property
    def time_s(self) -> float:
        """Time of the last sample since the start."""
        return self._count * self._period

    @property
    def is_whole(self) -> bool:
        """True: an FMU that leaves all bounds raises."""
        return True

    def advance(self, steering_wheel_angle_rad: float, speed_m_s: float) -> None:
        """Go on to the next sample, to which both inputs run linearly.

        Within a step an input without a ``_rate`` beside it stays at its mean.
        """
        ends = {STEERING: steering_wheel_angle_rad, "speed": speed_m_s}
        step = self._period / self._steps
        for part in range(self._steps):
            given = dict(self._in)
            for role, end in ends.items():
                slope = (end - self._in[role]) / self._period
                rate = f"{role}_rate"
                known = rate in RATES and self._wiring.has_input(rate)
                given[role] += slope * step * (part + (0.0 if known else 0.5))
                given[rate] = slope
            self._running.step(given, step)
        self._in |= ends
        self._count += 1
        self._before, self._now = self._now, self._running.read()

    def value(self, name: str) -> float:
        """A quantity of the last sample by the name of its channel."""
        if name == "speed":
            return self._now.get("speed", self._in["speed"])
        return self._now[name]

    def axle_force(self, axle: int) -> float:
        """Side force in N of the car's front axle (0) or rear axle (1) in the last sample."""
        names = [f"wheel_lateral_force_{side}" for side in (("fl", "fr"), ("rl", "rr"))[axle]]
        missing = [name for name in names if name not in self._now]
        if missing:
            raise FmuError(
                f"{self._fmu.path}: no output for {missing[0]}; this driver model uses it"
            )
        return sum(self._now[name] for name in names)

    def brake(self, body: str, force_n: float) -> None:
        """Brake a body with a force from now on; 0 releases it."""
        role = f"{body}_brake_force"
        assert role in BRAKES
        if not self._wiring.has_input(role):
            raise FmuError(f"{self._fmu.path}: no input for {role}; a reaction that brakes needs "
                           f'one: [inputs] {role} = "..." in its mapping')  # fmt: skip
        self._in[role] = force_n

    def trace(self, steering_rad: float) -> Trace:
        """What there is to measure at the last sample."""
        channels = {STEERING: steering_rad, "speed": self.value("speed"), "bank": 0.0, **self._now}
        for body, ahead in self._places.items():
            rate, felt = f"{body}_yaw_rate", f"{body}_lateral_acceleration"
            if rate in self._now and felt in self._now:
                turning = (self._now[rate] - self._before[rate]) / self._period
                channels[f"{body}_yaw_acceleration"] = turning
                channels[f"{body}_acceleration_y"] = self._now[felt] - ahead * turning
        arrays = {name: np.array([value]) for name, value in channels.items()}
        return Trace(np.array([self.time_s]), arrays)

    def close(self) -> None:
        """End it and remove what was unpacked."""
        self._running.close()
        self._fmu.__exit__(None, None, None)
