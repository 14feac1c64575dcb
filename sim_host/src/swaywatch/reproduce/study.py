"""Simulated drives and what the C core finds in them."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from swaywatch.drive import Drive
from swaywatch.ecu.core import AXLES, Estimates, analyze_drive
from swaywatch.models.double_track import Trace
from swaywatch.simulate.run import simulate_scenario
from swaywatch.simulate.scenario import read_scenario
from swaywatch.vehicle import Car, Trailer, Vehicle

KMH = 3.6
WEIGHT = 9.81
Item = TypeVar("Item")
Result = TypeVar("Result")

CAR = Car(
    mass=1955.0, yaw_inertia=2690.0, front_axle_to_cog=1.302, rear_axle_to_cog=1.383,
    hitch_to_cog=2.166, steering_ratio=15.0, front_cornering_stiffness=109.3e3,
    rear_cornering_stiffness=185.2e3, front_axle_load=9674.0, rear_axle_load=10204.0,
)  # fmt: skip
TRAILER = Trailer(
    mass=1880.0, yaw_inertia=10350.0, front_axle_to_cog=0.124, rear_axle_to_cog=0.526,
    hitch_to_cog=5.073, front_cornering_stiffness=131.2e3, rear_cornering_stiffness=124.4e3,
    front_axle_load=9226.0, rear_axle_load=8517.0,
)  # fmt: skip
VEHICLE = Vehicle(CAR, TRAILER)
"""Tables A and B."""


@dataclass(frozen=True)
class ImpulseDrive:
    """One drive to simulate: an impulse at a speed.

    Identified are the windows whose middle lies ``first_s`` to ``last_s`` after that of the first
    whole window of free oscillation.
    """

    vehicle: Vehicle = VEHICLE
    speed_kmh: float = 107.9
    angle_deg: float = 5.0
    start_s: float = 2.0
    duration_s: float = 14.0
    physics: tuple[Mapping[str, Any], ...] = ()
    sensors: str = "perfect"
    speed_control: bool = False
    seed: int = 1
    model: str = "double_track"
    sprung: Mapping[str, float] | None = None
    damper: str = ""
    first_s: float = 0.5
    last_s: float = 6.0


def judge_is_there() -> bool:
    """Is MuJoCo installed, with what its plant needs. `make run` alone does not bring it."""
    try:
        import mujoco  # noqa: F401

        from swaywatch.models import multibody_kernel  # noqa: F401
    except ModuleNotFoundError:
        return False
    return True


def drive_of(setup: ImpulseDrive) -> tuple[Drive, Trace]:
    """Simulate a set-up through the same door as ``swaywatch simulate``."""
    content = {
        "vehicle": "-",
        "duration_s": setup.duration_s,
        "speed_kmh": setup.speed_kmh,
        "seed": setup.seed,
        "speed_control": setup.speed_control,
        "model": setup.model,
        "manoeuvre": [{"kind": "impulse", "start_s": setup.start_s, "angle_deg": setup.angle_deg}],
        "physics": [dict(effect) for effect in setup.physics],
        "sensors": {"preset": setup.sensors},
        "timing": {"jitter_s": 0.0, "latency_s": 0.0} if setup.sensors == "perfect" else {},
    }
    if setup.sprung is not None:
        content["sprung"] = dict(setup.sprung)
    if setup.model == "multibody":  # what the linear models have: bodies that stay level
        content["multibody"] = (
            {"damper": {"kind": setup.damper}} if setup.damper else {"bodies": "planar"}
        )
    scenario = read_scenario(content, "study", Path(), "study", vehicle=setup.vehicle)
    return simulate_scenario(scenario)


@dataclass(frozen=True)
class State:
    """What the core found in the free oscillation after the impulse.

    Attributes
    ----------
    damping_ratio, frequency_hz : and their standard errors
    stiffness, argument_deg : of each axle (N/rad), Eq. 4.9
    effective_load_n, load_harmonic_n, load_phase_deg, normalised : car's rear axle, Eq. 4.10-4.16
    inertia_kgm2 : car (Eq. 4.18), trailer, trailer by method 1 and by method 2
    """

    speed_kmh: float
    damping_ratio: float
    damping_se: float
    frequency_hz: float
    stiffness: dict[str, float] = field(default_factory=dict)
    argument_deg: dict[str, float] = field(default_factory=dict)
    effective_load_n: float = float("nan")
    load_harmonic_n: float = float("nan")
    load_phase_deg: float = float("nan")
    normalised: float = float("nan")
    inertia_kgm2: tuple[float, ...] = ()
    model_v_crit_kmh: float = float("nan")


def identify(setup: ImpulseDrive) -> State:
    """Simulate, run the core, and average its usable estimates.

    Raises
    ------
    ValueError
        The core found no usable line.
    """
    drive, _ = drive_of(setup)
    estimates = analyze_drive(drive, setup.vehicle)
    return state_of(estimates, setup)


def free_rows(
    estimates: Estimates, begin_s: float, first_s: float, last_s: float
) -> NDArray[np.bool_]:
    """Estimates whose whole window lies in the free oscillation after ``begin_s``."""
    middle = estimates.time_s
    free = estimates.has("line") & (middle - 0.5 * estimates["window_s"] >= begin_s)
    if not free.any():
        raise ValueError("the core found no line in the free oscillation")
    earliest = float(middle[free][0])
    rows = free & (middle >= earliest + first_s) & (middle <= earliest + last_s)
    return np.asarray(rows)


def state_of(estimates: Estimates, setup: ImpulseDrive) -> State:
    """Averages over the rows of :func:`free_rows`, weighted by their standard errors."""
    rows = free_rows(estimates, setup.start_s + 0.5 / 0.675, setup.first_s, setup.last_s)

    def mean(name: str, extra: str | None = None) -> float:
        use = rows if extra is None else rows & estimates.has(extra)
        return float(np.mean(estimates[name][use])) if use.any() else float("nan")

    weight = 1.0 / np.maximum(estimates["damping_ratio_se"][rows], 1e-9) ** 2
    phase = estimates["car_rear.load_harmonic_phase_rad"][rows]
    inertias = tuple(
        mean(f"{name}_kgm2")
        for name in (
            "car_yaw_inertia", "trailer_yaw_inertia",
            "trailer_yaw_inertia_1", "trailer_yaw_inertia_2",
        )
    )  # fmt: skip
    return State(
        setup.speed_kmh,
        float(np.average(estimates["damping_ratio"][rows], weights=weight)),
        float(1.0 / np.sqrt(weight.sum())),
        float(np.average(estimates["frequency_hz"][rows], weights=weight)),
        {axle: mean(f"{axle}.cornering_stiffness_n_per_rad", axle) for axle in AXLES},
        {axle: float(np.degrees(mean(f"{axle}.argument_rad", axle))) for axle in AXLES},
        mean("car_rear.effective_load_n", "car_rear_load"),
        mean("car_rear.load_harmonic_n", "car_rear_load"),
        float(np.degrees(np.angle(np.exp(1j * phase).mean()))),
        mean("car_rear.normalised_stiffness_per_rad", "car_rear_load"),
        inertias,
        KMH * mean("v_crit_m_s", "critical_speed"),
    )


@dataclass(frozen=True)
class Ladder:
    """Impulses at a ladder of speeds (ISO 9815) and the speed where the damping vanishes.

    Attributes
    ----------
    v_crit_kmh : zero of the regression of damping over speed (Eq. 3.43)
    at_critical : the state nearest to it, interpolated in speed
    """

    states: tuple[State, ...]
    v_crit_kmh: float

    def at_critical(self, quantity: Callable[[State], float]) -> float:
        """A quantity at the critical speed, by a line over speed."""
        speeds = [state.speed_kmh for state in self.states]
        values = [quantity(state) for state in self.states]
        return float(np.polyval(np.polyfit(speeds, values, 1), self.v_crit_kmh))


def ladder_of(states: Sequence[State], degree: int = 1) -> Ladder:
    """The regression of Eq. 3.43, or a parabola where the speeds lie far apart."""
    speeds = np.array([state.speed_kmh for state in states])
    damping = np.array([state.damping_ratio for state in states])
    middle = float(speeds.mean())
    roots = np.roots(np.polyfit(speeds - middle, damping, degree))
    real = roots[np.abs(roots.imag) < 1e-9].real + middle
    if not real.size:
        return Ladder(tuple(states), float("nan"))
    return Ladder(tuple(states), float(real[np.argmin(np.abs(real - middle))]))


def ladders(
    setups: Sequence[ImpulseDrive],
    offsets_kmh: Sequence[float],
    around_kmh: Sequence[float],
    workers: int | None = None,
    degree: int = 1,
) -> list[Ladder]:
    """Ladders of several set-ups at once, each around its own expected critical speed."""
    jobs = [
        dataclasses.replace(setup, speed_kmh=around + offset)
        for setup, around in zip(setups, around_kmh, strict=True)
        for offset in offsets_kmh
    ]  # fmt: skip
    states = in_parallel(identify, jobs, workers)
    size = len(offsets_kmh)
    return [ladder_of(states[k : k + size], degree) for k in range(0, len(states), size)]


@cache
def _pool(workers: int) -> ProcessPoolExecutor:
    """Processes that stay for the whole report: starting one takes longer than a drive."""
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"))


def in_parallel(
    function: Callable[[Item], Result], items: Iterable[Item], workers: int | None = None
) -> list[Result]:
    """Map over processes on all cores, in order."""
    work = list(items)
    count = workers or os.cpu_count() or 1
    if count <= 1 or len(work) == 1:
        return [function(item) for item in work]
    first = function(work[0])  # compiled once, before there are several processes
    chunk = max(1, len(work) // (4 * count))
    return [first, *_pool(count).map(function, work[1:], chunksize=chunk)]
