"""From files to a problem: runs, vehicle, checks of what can be determined at all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from swaywatch.checks.sensor_faults import MOST_LOST, SensorFaults
from swaywatch.diagnose.fit.beliefs import beliefs_of
from swaywatch.diagnose.fit.fit import COMPARED, Problem
from swaywatch.diagnose.fit.load_balance import Weighed, weighed
from swaywatch.diagnose.fit.stretches import STRETCH_S, WHOLE_S, Stretches, divided, length_s
from swaywatch.drive import Drive, load_drives
from swaywatch.effects.runs import RATE_HZ, Run, on_grid
from swaywatch.errors import RecordingError, SignalError, VehicleError
from swaywatch.plant.lanes import BODY
from swaywatch.plant.vehicle_view import constants_of
from swaywatch.vehicle import Car, Trailer, Vehicle
from swaywatch.vehicle_file import load_vehicle

#: Without these there is nothing to drive the model with.
INPUTS = ("steering_wheel_angle", "speed")
MINIMUM_S = 6.0
MINIMUM_SPEED = 5.0
MINIMUM_YAW_RATE = 0.01  # rad/s RMS: below it nothing is excited
NOTHING_MOVES = (
    f"cannot say: in no stretch of {STRETCH_S:.0f} s does it drive at {MINIMUM_SPEED:.0f} m/s and "
    f"do the yaw rates reach {MINIMUM_YAW_RATE} rad/s RMS"
)


@dataclass
class Loaded:
    """Everything a diagnosis starts from.

    Attributes
    ----------
    problem
        None where `cannot` says why.
    vehicle
        As read.
    signals
        Channel to name of the signal in the recording.
    cannot
        Reasons why nothing can be said.
    checks
        Sentences about the data for the report.
    faults
        Of sensors, found before the fit and put right for it.
    stretches
        What of the runs the problem has, and what it leaves to be checked.
    weighed
        What the axle loads of the file say; None without a problem.
    """

    problem: Problem | None
    vehicle: Vehicle
    signals: dict[str, str] = field(default_factory=dict)
    cannot: list[str] = field(default_factory=list)
    checks: list[str] = field(default_factory=list)
    faults: SensorFaults = field(default_factory=SensorFaults)
    stretches: Stretches | None = None
    weighed: Weighed | None = None


def body_of(vehicle: Vehicle) -> np.ndarray:
    """Constants in the order of `plant.lanes.BODY`; a value that is absent is an error."""
    if vehicle.trailer is None:
        raise VehicleError("the diagnosis of a combination needs a [trailer] in vehicle.toml")
    return constants_of(vehicle)


def run_of(drive: Drive, steering_ratio: float, name: str) -> Run:
    """One drive on the grid of the diagnosis."""
    channels = {
        key: (channel.time_s, channel.value)
        for key, channel in drive.channels.items()
        if channel.time_s.size > 1
    }
    for need in INPUTS:
        if need not in channels:
            raise SignalError(f"{name}: no {need}; the model cannot run without it")
    time, values = on_grid(channels)
    positions = {key: channel.position_m for key, channel in drive.channels.items()}
    return Run(name, time, values, positions, steering_ratio)


def load(
    recordings: Sequence[Path],
    vehicle_file: Path,
    signals_file: Path,
    *,
    whole: bool = False,
    right: frozenset[tuple[str, str]] = frozenset(),
) -> Loaded:
    """Read, check, prepare.

    Parameters
    ----------
    whole
        Long recordings are not divided.
    right
        Run and channel that had no drift.
    """
    vehicle = load_vehicle(vehicle_file)
    loaded = Loaded(None, vehicle, faults=SensorFaults(right=right))
    body = body_of(vehicle)
    drives = load_drives(list(recordings), signals_file)
    if not drives:
        raise RecordingError("no run in the recordings")
    runs: list[Run] = []
    for index, recorded in enumerate(drives):
        name = f"run {index + 1}"
        loaded.signals.update({k: c.signal for k, c in recorded.channels.items()})
        drive = loaded.faults.put_right(recorded, vehicle, name)
        run = run_of(drive, vehicle.car.steering_ratio, name)
        run.silent, run.kept = loaded.faults.masks(name, run.time, COMPARED)
        reason = _without_lost(run, loaded)
        if whole or length_s(run) <= WHOLE_S:  # a longer one may stand for a while
            reason = reason or _too_little(run)
        if reason:
            loaded.cannot.append(f"{name}: {reason}")
            continue
        runs.append(run.prepare())
    loaded.checks += loaded.faults.checks
    if runs and not whole:
        loaded.stretches = divided(runs, _too_little)
        if not loaded.stretches.searched:
            loaded.cannot += [f"{run.name}: {NOTHING_MOVES}" for run in runs]
        runs = loaded.stretches.searched
    if runs:
        # order of the files must not matter: sort by what was driven
        runs.sort(key=lambda run: -float(np.mean(run.channels["speed"])))
        loaded.problem = Problem(tuple(runs), body)
        channels = loaded.problem.channels(runs[0])
        believed = beliefs_of(body, channels, vehicle.tolerance)
        loads = weighed(believed, body, vehicle)
        loaded.problem = replace(loaded.problem, beliefs=loads.beliefs)
        loaded.weighed = loads
        loaded.checks += loads.wrong
        missing = [c for c in COMPARED if any(c not in run.channels for run in runs)]
        if missing:
            loaded.checks.append("not recorded: " + ", ".join(missing))
        loaded.checks += _foreign(runs, body)
    return loaded


def _without_lost(run: Run, loaded: Loaded) -> str:
    """Drop channels that say nothing most of the time; why the run is of no use, if one drives."""
    for name, windows in loaded.faults.lost.get(run.name, {}).items():
        share = sum(b - a for a, b in windows) / max(float(run.time[-1]), 1e-9)
        if share < MOST_LOST:
            continue
        signal = loaded.signals.get(name, name)
        if name in INPUTS:
            return f"cannot decide: {signal} is unusable for {100 * share:.0f} % of the run"
        run.channels.pop(name, None)
        loaded.checks.append(
            f"{run.name}: {signal} is unusable for {100 * share:.0f} % of the run: left out"
        )
    return ""


def _too_little(run: Run) -> str:
    if run.time.size < MINIMUM_S * RATE_HZ:
        length = run.time.size / RATE_HZ
        return f"cannot say: {length:.1f} s long, at least {MINIMUM_S:.0f} s needed"
    speed = float(np.median(run.channels["speed"]))
    if speed < MINIMUM_SPEED:
        return f"cannot say: median speed {speed:.1f} m/s, at least {MINIMUM_SPEED:.0f} m/s needed"
    rates = [run.channels[c] for c in ("car_yaw_rate", "trailer_yaw_rate") if c in run.channels]
    if not rates:
        return "cannot say: neither car_yaw_rate nor trailer_yaw_rate is recorded"
    if max(float(np.std(rate)) for rate in rates) < MINIMUM_YAW_RATE:
        return "cannot say: no excitation (yaw rates stay below 0.01 rad/s RMS)"
    return ""


def _foreign(runs: Sequence[Run], body: np.ndarray) -> list[str]:
    """Do the runs come from the vehicle of the file? Static axle loads tell."""
    found = []
    loads = []
    believed = float(body[14] + body[15])
    for run in runs:
        keys = [f"wheel_vertical_load_{w}" for w in ("fl", "fr", "rl", "rr")]
        if not all(key in run.channels for key in keys):
            continue
        load = float(sum(np.mean(run.channels[key]) for key in keys))
        loads.append(load)
        if abs(load / believed - 1.0) > 0.1:
            found.append(
                f"{run.name}: axle loads sum to {load:.0f} N, the file has {believed:.0f} N: "
                "another vehicle or another loading?"
            )
    if len(loads) > 1 and max(loads) / min(loads) > 1.1:
        raise RecordingError(
            "the runs come from different vehicles or loadings: axle loads sum to "
            + ", ".join(f"{load:.0f} N" for load in loads)
        )
    return found


def vehicle_of(body: np.ndarray, steering_ratio: float) -> Vehicle:
    """The combination whose constants are in the order of `plant.lanes.BODY`."""
    parts: dict[str, dict[str, float]] = {"car": {}, "trailer": {}}
    for name, value in zip(BODY, body.tolist(), strict=True):
        part, key = name.split(".")
        parts[part][key] = value
    car = Car(steering_ratio=steering_ratio, **parts["car"])
    return Vehicle(car, Trailer(**parts["trailer"]))  # type: ignore[arg-type]


def load_with_body(
    recording: Path, signals_file: Path, body: np.ndarray, steering_ratio: float
) -> tuple[Problem, list[str]]:
    """One run with constants that are already known, and what was put right in it."""
    drives = load_drives([recording], signals_file)
    loaded = Loaded(None, vehicle_of(body, steering_ratio))
    loaded.signals.update({k: c.signal for k, c in drives[0].channels.items()})
    drive = loaded.faults.put_right(drives[0], loaded.vehicle, recording.name)
    run = run_of(drive, steering_ratio, recording.name)
    run.silent, run.kept = loaded.faults.masks(recording.name, run.time, COMPARED)
    reason = _without_lost(run, loaded) or _too_little(run)
    if reason:
        raise RecordingError(f"{recording.name}: {reason}")
    return Problem((run.prepare(),), body), [*loaded.faults.checks, *loaded.checks]
