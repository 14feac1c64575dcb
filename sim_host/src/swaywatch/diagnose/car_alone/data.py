"""From files to the moving parts of the runs of a car alone, and what is wrong with its signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swaywatch.checks.samples import inside
from swaywatch.checks.sensor_faults import SensorFaults
from swaywatch.diagnose.car_alone.effects import ACC, STEER, YAW
from swaywatch.drive import Drive, load_drives
from swaywatch.effects.runs import RATE_HZ, low_pass, on_grid, white_noise
from swaywatch.errors import RecordingError, SignalError
from swaywatch.vehicle import Vehicle

Array = NDArray[np.float64]

COMPARED = (YAW, ACC)
LEAST_SPEED = 4.0  # m/s: below it slip angles say nothing
SHORTEST_PART_S = 4.0
LONGEST_PART_S = 60.0
SMOOTH_HZ = 8.0
LONGEST_BRIDGED_S = 0.2  # of a sensor that says nothing
LEAST_EXCITATION = 0.02  # rad/s RMS of the yaw rate


@dataclass
class CarRun:
    """One recording on an even grid.

    Attributes
    ----------
    time
        Shape (n,), s.
    channels
        Cleaned, offsets at standstill taken off.
    position_m
        Of the lateral accelerometer ahead of the centre of gravity.
    offsets
        Channel to what it shows at standstill.
    flipped
        Whether the steering had the sign opposite to the yaw rate.
    """

    name: str
    time: Array
    channels: dict[str, Array]
    position_m: float
    offsets: dict[str, float] = field(default_factory=dict)
    flipped: bool = False
    noise: dict[str, float] = field(default_factory=dict)
    steps: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Part:
    """A stretch of a run in motion: slice of its grid and the fold it is held out with."""

    run: int
    start: int
    stop: int
    fold: int

    @property
    def where(self) -> slice:
        """Into the run's arrays."""
        return slice(self.start, self.stop)


@dataclass
class CarData:
    """All of it, with sentences about the data."""

    runs: list[CarRun]
    parts: list[Part]
    vehicle: Vehicle
    signals: dict[str, str]
    checks: list[str] = field(default_factory=list)
    cannot: list[str] = field(default_factory=list)
    faults: SensorFaults = field(default_factory=SensorFaults)

    @property
    def channels(self) -> tuple[str, ...]:
        """Compared channels that every run has."""
        return tuple(c for c in COMPARED if all(c in run.channels for run in self.runs))


def load_car_runs(recordings: Sequence[Path], vehicle: Vehicle, signals: Path) -> CarData:
    """Read, clean, cut into parts.

    Raises
    ------
    SwaywatchError
        Steering, speed or every lateral channel is missing.
    """
    data = CarData([], [], vehicle, {})
    for number, drive in enumerate(load_drives(list(recordings), signals, join=False)):
        data.signals.update({k: c.signal for k, c in drive.channels.items()})
        data.checks += list(drive.remarks)
        name = recordings[number].name
        data.runs.append(_run(data.faults.put_right(drive, vehicle, name), name))
    data.checks += data.faults.checks
    data.runs.sort(key=lambda run: run.name)
    _signs(data)
    _parts(data)
    if not data.channels:
        raise SignalError(
            f"{recordings[0]}: neither {YAW} nor {ACC} is in every run; one of them is needed"
        )
    missing = [c for c in COMPARED if c not in data.channels]
    data.checks += [
        f"not recorded: {c}; explanations that act on it cannot be tested" for c in missing
    ]
    if not any("wheel_speed_fl" in run.channels for run in data.runs):
        data.checks.append(
            "without wheel speeds the gain of the yaw rate is checked against nothing but the model"
        )
    return data


def _run(drive: Drive, name: str) -> CarRun:
    channels = {k: (c.time_s, c.value) for k, c in drive.channels.items() if c.time_s.size > 1}
    for need in (STEER, "speed"):
        if need not in channels:
            raise SignalError(f"{name}: no {need}; the model cannot run without it")
    time, values = on_grid(channels)
    position = drive.channels[ACC].position_m if ACC in drive.channels else 0.0
    run = CarRun(name, time, values, position)
    for key in (k for k in COMPARED if k in channels):
        run.steps[key] = _step(channels[key][1])
        run.noise[key] = max(white_noise(values[key]), run.steps[key] / np.sqrt(12.0))
    _take_offsets_off(run)
    return run


def _take_offsets_off(run: CarRun) -> None:
    """What the sensors show while the car stands."""
    still = run.channels["speed"] < 0.05
    if np.count_nonzero(still) > RATE_HZ:
        for key in (k for k in COMPARED if k in run.channels):
            run.offsets[key] = float(np.mean(run.channels[key][still]))
            run.channels[key] = run.channels[key] - run.offsets[key]


def _step(value: Array) -> float:
    """Quantisation step: the smallest distance of different values that recurs."""
    levels = np.unique(np.round(value, 9))
    return float(np.median(np.diff(levels))) if 2 < levels.size < 400 else 0.0


def _signs(data: CarData) -> None:
    """Steering positive to the left, like the yaw rate; a flip is said."""
    for run in data.runs:
        if YAW not in run.channels:
            continue
        fast = run.channels["speed"] > LEAST_SPEED
        if np.count_nonzero(fast) < SHORTEST_PART_S * RATE_HZ:
            continue
        a, b = run.channels[STEER][fast], run.channels[YAW][fast]
        run.flipped = bool(np.corrcoef(a, b)[0, 1] < -0.3)
    if any(run.flipped for run in data.runs):
        if not all(run.flipped for run in data.runs if YAW in run.channels):
            names = ", ".join(run.name for run in data.runs if run.flipped)
            raise RecordingError(
                f"steering and yaw rate have opposite signs in {names} and the same in the other "
                "runs: different vehicles or mappings"
            )
        for run in data.runs:
            run.channels[STEER] = -run.channels[STEER]
        data.checks.append(
            f"{data.signals.get(STEER, STEER)} is positive to the right in the recording (the yaw "
            "rate to the left): taken with the opposite sign; set sign = -1 in signals.toml"
        )


def _parts(data: CarData) -> None:
    """Stretches in motion; folds are runs, or consecutive stretches of a single run."""
    for number, run in enumerate(data.runs):
        moving = low_pass(run.channels["speed"], 1.0) > LEAST_SPEED
        for windows in data.faults.lost.get(run.name, {}).values():
            moving &= ~inside(run.time, [w for w in windows if w[1] - w[0] > LONGEST_BRIDGED_S])
        edges = np.flatnonzero(np.diff(np.r_[False, moving, False].astype(int)))
        pieces = [
            (a, b) for a, b in zip(edges[::2], edges[1::2], strict=True)
            if b - a >= SHORTEST_PART_S * RATE_HZ
        ]  # fmt: skip
        kept = 0
        for a, b in pieces:
            lively = YAW not in run.channels or np.std(run.channels[YAW][a:b]) > LEAST_EXCITATION
            if not lively:
                continue
            count = max(1, int(np.ceil((b - a) / (LONGEST_PART_S * RATE_HZ))))
            ends = np.linspace(a, b, count + 1).astype(int)
            for first, last in pairwise(ends):
                data.parts.append(Part(number, int(first), int(last), number))
                kept += 1
        if not kept:
            data.cannot.append(
                f"{run.name}: cannot say: no stretch of {SHORTEST_PART_S:.0f} s faster than "
                f"{LEAST_SPEED:.0f} m/s with a yaw rate above {LEAST_EXCITATION} rad/s RMS"
            )
    if len({part.run for part in data.parts}) == 1 and len(data.parts) > 1:
        data.parts = [Part(p.run, p.start, p.stop, i % 5) for i, p in enumerate(data.parts)]
