"""The simulated twin of a recorded drive: same steering, same speed, same sensors, no noise."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from swaywatch.drive import Drive
from swaywatch.errors import SignalError
from swaywatch.simulate.manoeuvres import Plan
from swaywatch.simulate.run import simulate_scenario
from swaywatch.simulate.scenario import PLANT_RATE_HZ, read_scenario
from swaywatch.simulate.sensors import available
from swaywatch.vehicle import Vehicle

Array = NDArray[np.float64]

INPUTS = ("steering_wheel_angle", "speed")
STEERING_CUTOFF_HZ = 10.0
"""Above it a steering wheel holds noise."""
SPEED_CUTOFF_HZ = 0.7
"""A combination changes its speed more slowly than its sensor's noise; the plant takes its rate."""
LEAST_SPEED_M_S = 2.0
"""A plant with tyres has no slip angle at rest."""


def simulate_twin(
    drive: Drive, vehicle: Vehicle, physics: Sequence[Mapping[str, Any]] = ()
) -> Drive:
    """What the sensors of `drive` would have seen of `vehicle`, driven alike.

    `physics` is added to it, as in a scenario. The simulation starts from straight driving: what
    swings already when the recording begins has no counterpart. Only channels that the recording
    has are simulated.

    Raises
    ------
    SignalError
        Steering or speed was not recorded.
    """
    time_s, inputs = twin_inputs(drive)
    steering, speed = (inputs[name] for name in INPUTS)
    content: dict[str, Any] = {
        "vehicle": "-", "duration_s": float(time_s[-1]), "speed_kmh": 3.6 * float(speed[0]),
        "sensors": {"preset": "perfect"}, "timing": {"jitter_s": 0.0, "latency_s": 0.0},
        "physics": [dict(effect) for effect in physics],
    }  # fmt: skip
    scenario = read_scenario(content, drive.name, Path(), drive.name, vehicle=vehicle)
    plan = Plan(time_s, steering, speed)
    sensors: dict[str, Any] = {"preset": "perfect"}
    for name, channel in drive.channels.items():
        if name.endswith("lateral_acceleration"):
            sensors[name] = {"position_m": channel.position_m}
    scenario = dataclasses.replace(scenario, plan=plan, sensors=sensors)
    twin, trace = simulate_scenario(scenario)
    kept = {name: twin.channels[name] for name in available(trace) if name in drive.channels}
    return dataclasses.replace(twin, channels=kept)


def twin_inputs(drive: Drive) -> tuple[Array, dict[str, Array]]:
    """What drives a simulation of a drive: its time axis, and the inputs on it by role.

    Raises
    ------
    SignalError
        Steering or speed was not recorded.
    """
    missing = [name for name in INPUTS if name not in drive.channels]
    if missing:
        raise SignalError(
            f"{drive.name}: no signal for the role(s) {', '.join(missing)}; a simulation of the "
            "same drive cannot run without it"
        )
    count = int(np.floor(drive.duration_s * PLANT_RATE_HZ)) + 1
    time_s = np.arange(count) / PLANT_RATE_HZ
    steering = _input(drive, "steering_wheel_angle", time_s, STEERING_CUTOFF_HZ)
    speed = np.maximum(_input(drive, "speed", time_s, SPEED_CUTOFF_HZ), LEAST_SPEED_M_S)
    return time_s, {"steering_wheel_angle": steering, "speed": speed}


def _input(drive: Drive, name: str, time_s: Array, cutoff_hz: float) -> Array:
    """A recorded channel on the plant's time axis, without its noise."""
    channel = drive.channels[name]
    value = np.interp(time_s, channel.time_s, channel.value)
    if time_s.size < 64:
        return np.asarray(value)
    sos = butter(2, cutoff_hz / (0.5 * PLANT_RATE_HZ), output="sos")
    return np.asarray(sosfiltfilt(sos, value))
