"""What a manoeuvre tells: Fisher information of the plant's outputs about the unknowns.

Outputs are simulated with every unknown moved a little both ways. What hides these slopes is sensor
noise, and what road and wind do to the motion: side forces and moments on both bodies that go
through the plant itself, so that near the critical speed they are large where the sway is. In the
frequency domain both are one matrix per frequency, S = noise + sum of h h* (h: outputs per force),
and the information is the sum of D* S^-1 D over the frequencies; what the motion carries in and out
of a record that is no period of it acts like an unknown state at its start (Pintelon, Schoukens,
System Identification, 2nd ed. 2012, ch. 6 and 9). Information of runs adds up, and so does that of
the belief (one over its variance); errors are the roots of the diagonal of the inverse. That is the
best a test can tell of a plant that is as believed; a model that is wrong errs by more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from swaywatch.diagnose.plant import OUTPUT, Job, PlantInput, run_jobs
from swaywatch.models.modes import critical_speeds
from swaywatch.plan.knowledge import Knowledge, Sensor

Array = NDArray[np.float64]
STEP_S = 0.01
BAND_HZ = (0.1, 4.0)
CORNER_HZ = 0.4
STARTS = np.array([0.1, 0.01, 0.01, 0.01])
"""Of lateral velocity, yaw rate, articulation, the trailer's yaw rate: small, the scale is free."""


@dataclass(frozen=True)
class Disturbance:
    """What road and wind do: a slot of the plant and the RMS of its course."""

    slot: str
    rms: float


DISTURBANCES = (
    Disturbance("force_car", 80.0), Disturbance("moment_car", 80.0),
    Disturbance("force_trailer", 120.0), Disturbance("moment_trailer", 120.0),
)  # fmt: skip
"""N and N m, of first order with `CORNER_HZ`: a trailer's side area of 8 m2 in a side wind that
varies by 1 m/s at 100 km/h."""

SHARE = 0.1
"""Of its tolerance by which an unknown is moved."""


@dataclass(frozen=True)
class Drive:
    """Steering-wheel angle, rad, and speed, m/s, on a grid of `STEP_S`."""

    steer: Array
    speed: Array

    @property
    def time_s(self) -> Array:
        """Of the samples."""
        return np.asarray(np.arange(len(self.steer)) * STEP_S, dtype=np.float64)


def outputs(
    known: Knowledge, drives: Sequence[Drive], values: Sequence[Array], sensors: Sequence[Sensor]
) -> list[Array]:
    """What the sensors would show without noise, one drive and one set of values each; (n, m)."""
    columns = tuple(OUTPUT.index(sensor.output) for sensor in sensors)
    jobs = [
        Job(known.plant(drive.time_s, drive.steer, drive.speed, own), columns=columns)
        for drive, own in zip(drives, values, strict=True)
    ]
    found = []
    for outcome in run_jobs(jobs):
        assert outcome.output is not None
        found.append(outcome.output)
    return found


def lines(samples: int) -> Array:
    """Frequencies that count, Hz: offsets and drift are below, nothing of the sway above."""
    frequency = np.fft.rfftfreq(samples, STEP_S)
    return np.asarray(frequency[_inside(samples)], dtype=np.float64)


def _inside(samples: int) -> NDArray[np.bool_]:
    frequency = np.fft.rfftfreq(samples, STEP_S)
    return np.asarray((frequency >= BAND_HZ[0]) & (frequency <= BAND_HZ[1]))


def spectrum(signal: Array) -> NDArray[np.complex128]:
    """Lines of signals over axis 0."""
    whole = np.fft.rfft(signal - signal.mean(axis=0), axis=0)
    return np.asarray(whole[_inside(len(signal))], dtype=np.complex128)


def slopes(
    known: Knowledge, drives: Sequence[Drive], at: Array, sensors: Sequence[Sensor]
) -> list[NDArray[np.complex128]]:
    """Lines of the change of every output per tolerance of every unknown; each (lines, m, k)."""
    count = len(known.unknowns)
    moves = SHARE * np.diag(known.deviations)
    every = [drive for drive in drives for _ in range(2 * count)]
    values = [at + sign * moves[k] for _ in drives for k in range(count) for sign in (1.0, -1.0)]
    found = outputs(known, every, values, sensors)
    result = []
    for number in range(len(drives)):
        own = found[2 * count * number : 2 * count * (number + 1)]
        part = [(own[2 * k] - own[2 * k + 1]) / (2 * SHARE) for k in range(count)]
        result.append(spectrum(np.stack(part, axis=2)))
    return result


def covariances(
    known: Knowledge, drives: Sequence[Drive], sensors: Sequence[Sensor], at: Array | None = None
) -> list[NDArray[np.complex128]]:
    """Of the lines of the outputs about their expectation; each (lines, m, m).

    `at`: values of the unknowns; the believed ones without it.
    """
    values = known.values if at is None else at
    columns = tuple(OUTPUT.index(sensor.output) for sensor in sensors)
    jobs = []
    for drive in drives:
        still = Drive(np.zeros_like(drive.steer), drive.speed)
        for disturbance in DISTURBANCES:
            plant = known.plant(still.time_s, still.steer, still.speed, values)
            kick = np.zeros(len(drive.steer))
            kick[1] = disturbance.rms  # one sample long, so its spectrum is flat
            plant.add_series(disturbance.slot, kick)
            jobs.append(Job(plant, columns=columns))
    responses = iter(run_jobs(jobs))
    found = []
    for drive in drives:
        samples = len(drive.steer)
        frequency = lines(samples)
        total = np.zeros((len(frequency), len(sensors), len(sensors)), dtype=np.complex128)
        for number, sensor in enumerate(sensors):
            total[:, number, number] = samples * sensor.noise**2
        for _ in DISTURBANCES:
            answer = next(responses).output
            assert answer is not None
            h = np.fft.rfft(answer, axis=0)[_inside(samples)]
            power = samples * _share(frequency)
            total += power[:, None, None] * h[:, :, None] * h[:, None, :].conj()
        found.append(total)
    return found


def _share(frequency_hz: Array) -> Array:
    """Power of a sample of a disturbance of RMS 1 over the lines: first order, see `disturbed`."""
    pole = np.exp(-2.0 * np.pi * CORNER_HZ * STEP_S)
    turn = np.exp(-2j * np.pi * frequency_hz * STEP_S)
    return np.asarray((1.0 - pole**2) / np.abs(1.0 - pole * turn) ** 2, dtype=np.float64)


def disturbed(samples: int, rms: float, random: np.random.Generator) -> Array:
    """A course of a disturbance."""
    pole = np.exp(-2.0 * np.pi * CORNER_HZ * STEP_S)
    white = random.normal(0.0, 1.0, samples + 1000)
    course = lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], white)
    return np.asarray(rms * course[1000:], dtype=np.float64)


def weighed(
    slope: NDArray[np.complex128], covariance: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """S^-1 D at every line."""
    return np.asarray(np.linalg.solve(covariance, slope), dtype=np.complex128)


def carried(
    known: Knowledge, drives: Sequence[Drive], at: Array, sensors: Sequence[Sensor]
) -> list[NDArray[np.complex128]]:
    """Lines of the free motions from each state at the start; each (lines, m, 4)."""
    columns = tuple(OUTPUT.index(sensor.output) for sensor in sensors)
    jobs = []
    for drive in drives:
        for state in range(4):
            still = np.zeros_like(drive.steer)
            plant = known.plant(drive.time_s, still, drive.speed, at)
            plant.initial = STARTS * np.eye(4)[state]
            jobs.append(Job(plant, columns=columns))
    found = [spectrum(one.output) for one in run_jobs(jobs) if one.output is not None]
    return [np.stack(found[4 * k : 4 * k + 4], axis=2) for k in range(len(drives))]


def normal_of(
    slope: NDArray[np.complex128],
    free: NDArray[np.complex128],
    covariance: NDArray[np.complex128],
    rest: NDArray[np.complex128] | None = None,
) -> tuple[Array, Array]:
    """Information of one drive, and its right side for a residual; states at the start are free.

    Parameters
    ----------
    slope, free, covariance
        Of :func:`slopes`, :func:`carried` and :func:`covariances`.
    rest
        Lines of measured less modelled outputs, (lines, m).
    """
    both = np.concatenate([slope, free], axis=2)
    weight = weighed(both, covariance)
    # the lines of negative frequency say the same once more: hence the 2
    matrix = 2.0 * np.einsum("fmi,fmj->ij", both.conj(), weight).real
    right = np.zeros(len(matrix))
    if rest is not None:
        right = 2.0 * np.einsum("fmi,fm->i", weight.conj(), rest).real
    k = slope.shape[2]
    size = np.sqrt(np.maximum(np.diag(matrix)[k:], 1e-300))
    inner = np.linalg.pinv(matrix[k:, k:] / np.outer(size, size), rcond=1e-9)
    across = matrix[:k, k:] / size
    told = matrix[:k, :k] - across @ inner @ across.T
    return np.asarray(told), np.asarray(right[:k] - across @ inner @ (right[k:] / size))


def information(
    known: Knowledge, drives: Sequence[Drive], sensors: Sequence[Sensor]
) -> list[Array]:
    """Fisher information of each drive, unknowns in units of their tolerances; (k, k)."""
    return [
        normal_of(slope, free, covariance)[0]
        for slope, free, covariance in zip(
            slopes(known, drives, known.values, sensors),
            carried(known, drives, known.values, sensors),
            covariances(known, drives, sensors),
            strict=True,
        )
    ]


def errors(told: Array) -> Array:
    """Covariance of the unknowns, in units of their tolerances, from information and belief."""
    return np.asarray(np.linalg.inv(told + np.eye(len(told))), dtype=np.float64)


@dataclass(frozen=True)
class Critical:
    """The critical speed as believed.

    Attributes
    ----------
    speed_m_s
        inf: none up to 84 m/s.
    slopes
        m/s per tolerance of each unknown.
    """

    speed_m_s: float
    slopes: Array

    def error(self, covariance: Array) -> float:
        """Standard error with a covariance in units of the tolerances, m/s."""
        return math.sqrt(max(float(self.slopes @ covariance @ self.slopes), 0.0))


def critical_of(known: Knowledge) -> Critical:
    """Critical speed and how it goes with the unknowns."""
    moves = 0.5 * np.diag(known.deviations)
    still = np.zeros(3)
    plants: list[PlantInput] = [
        known.plant(np.array([0.0, 0.002, 0.004]), still, still + 20.0, known.values + move)
        for move in (np.zeros(len(moves)), *moves, *-moves)
    ]
    speeds = critical_speeds(plants)
    count = len(known.unknowns)
    up, down = np.array(speeds[1 : 1 + count]), np.array(speeds[1 + count :])
    both = np.isfinite(up) & np.isfinite(down)
    change = np.zeros(count)
    change[both] = up[both] - down[both]
    return Critical(float(speeds[0]), change)
