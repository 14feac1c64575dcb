"""What a manoeuvre tells: Fisher information of the plant's outputs about the unknowns.

Outputs are simulated with every unknown moved a little both ways. What hides these slopes is sensor
noise, and what road and wind do to the motion: side forces and moments on both bodies that go
through the plant itself, so that near the critical speed they are large where the sway is. In the
frequency domain both are one matrix per frequency, S = noise + sum of h h* (h: outputs per kick of
a force at one of several moments of the drive: a steered combination answers otherwise at each),
and the information is M = sum of D* S^-1 D over the frequencies; what the motion carries in and out
of a record that is no period of it acts like an unknown state at its start (Pintelon, Schoukens,
System Identification, 2nd ed. 2012, ch. 6 and 9). A matrix per frequency does not know that kicks
make neighbouring frequencies answer together. How far an estimate with these weights is really
scattered is therefore counted kick by kick: J, and errors are (M + 1)^-1 (J + 1) (M + 1)^-1 (White,
Econometrica 50, 1982, with the belief as prior; 1: unknowns are in units of their tolerances). M
and J of runs add up. Errors are averaged over combinations that the belief allows. That is the best
a test can tell of a plant like that; a model that is wrong errs by more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from swaywatch.models.modes import critical_speeds
from swaywatch.plan.knowledge import Knowledge, KnownSensor
from swaywatch.plant.lanes import OUTPUT, Job, PlantInput, run_jobs

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
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

KICKS = 12
"""Moments of a drive at which road and wind kick it."""
GOLDEN = 0.618034

SHARE = 0.1
"""Of its tolerance by which an unknown is moved."""


@dataclass(frozen=True)
class PlannedDrive:
    """Steering-wheel angle, rad, and speed, m/s, on a grid of `STEP_S`."""

    steer: Array
    speed: Array

    @property
    def time_s(self) -> Array:
        """Of the samples."""
        return np.asarray(np.arange(len(self.steer)) * STEP_S, dtype=np.float64)


def outputs(
    known: Knowledge,
    drives: Sequence[PlannedDrive],
    values: Sequence[Array],
    sensors: Sequence[KnownSensor],
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


def _inside(samples: int) -> NDArray[np.bool_]:
    """Lines that count: offsets and drift are below, nothing of the sway above."""
    frequency = np.fft.rfftfreq(samples, STEP_S)
    return np.asarray((frequency >= BAND_HZ[0]) & (frequency <= BAND_HZ[1]))


def spectrum(signal: Array) -> Complex:
    """Lines of signals over axis 0; an offset is on none of them."""
    whole = np.fft.rfft(signal, axis=0)
    return np.asarray(whole[_inside(len(signal))], dtype=np.complex128)


@dataclass(frozen=True)
class Lines:
    """Lines of one drive at one set of values.

    Attributes
    ----------
    slope
        Of the change of every output per tolerance of every unknown; (lines, m, k).
    free
        Of the free motions from each state at the start; (lines, m, 4).
    noise
        Power of the sensors' noise; (m,).
    kicks
        Of what kicks do, so that the sum of h h* is the power of all disturbances: one half for the
        weights, another for the scatter; (2, lines, m, kicks).
    """

    slope: Complex
    free: Complex
    noise: Array
    kicks: Complex

    def of(self, columns: Sequence[int]) -> Lines:
        """The same with some of the outputs only."""
        own = list(columns)
        return Lines(self.slope[:, own], self.free[:, own], self.noise[own], self.kicks[:, :, own])

    def covariance(self) -> Complex:
        """Of the outputs about their expectation; (lines, m, m)."""
        kick = self.kicks[0]
        return np.asarray(kick @ kick.conj().transpose(0, 2, 1) + np.diag(self.noise))

    def weights(self) -> tuple[Array, Complex]:
        """Information, (k, k), and weights W of a residual r for the right side 2 Re sum W* r.

        States at the start are free. Weights: (lines, m, k).
        """
        both = np.concatenate([self.slope, self.free], axis=2)
        weight = np.linalg.solve(self.covariance(), both)
        # the lines of negative frequency say the same once more: hence the 2
        matrix = 2.0 * np.einsum("fmi,fmj->ij", both.conj(), weight).real
        k = self.slope.shape[2]
        size = np.sqrt(np.maximum(np.diag(matrix)[k:], 1e-300))
        inner = np.linalg.pinv(matrix[k:, k:] / np.outer(size, size), rcond=1e-9)
        out = inner @ (matrix[k:, :k] / size[:, None]) / size[:, None]
        informed = matrix[:k, :k] - matrix[:k, k:] @ out
        return np.asarray(informed), np.asarray(weight[:, :, :k] - weight[:, :, k:] @ out)

    def information(self) -> Array:
        """Information and the scatter of its right side; (2, k, k)."""
        matrix, weight = self.weights()
        noise = 2.0 * np.einsum("fmi,m,fmj->ij", weight.conj(), self.noise, weight).real
        pulled = 2.0 * np.einsum("fmi,fmn->in", weight.conj(), self.kicks[1]).real
        return np.stack([matrix, noise + pulled @ pulled.T])


def right_side(weight: Complex, rest: Complex) -> Array:
    """Of a residual, measured less modelled; weights of :meth:`Lines.weights`, rest (lines, m)."""
    return np.asarray(2.0 * np.einsum("fmi,fm->i", weight.conj(), rest).real)


def lines_of(
    known: Knowledge,
    drives: Sequence[PlannedDrive],
    sensors: Sequence[KnownSensor],
    at: Array,
    *,
    scatter: bool = True,
    turn: int = 0,
) -> list[Lines]:
    """Simulated at values of the unknowns, all drives side by side; equal drives once.

    Without `scatter` only :meth:`Lines.weights` can be asked. `turn`: each has kicks at other
    moments.
    """
    keys = [(drive.steer.tobytes(), drive.speed.tobytes()) for drive in drives]
    different = dict(zip(keys, drives, strict=True))
    found = _lines_of(known, list(different.values()), sensors, at, turn, 2 if scatter else 1)
    own = dict(zip(different, found, strict=True))
    return [own[key] for key in keys]


def _lines_of(
    known: Knowledge,
    drives: Sequence[PlannedDrive],
    sensors: Sequence[KnownSensor],
    at: Array,
    turn: int,
    halves: int,
) -> list[Lines]:
    count = len(known.unknowns)
    columns = tuple(OUTPUT.index(sensor.output) for sensor in sensors)
    moves = SHARE * np.diag(known.deviations)
    plants: list[PlantInput] = []
    for drive in drives:
        for k in range(count):
            for sign in (1.0, -1.0):
                values = at + sign * moves[k]
                plants.append(known.plant(drive.time_s, drive.steer, drive.speed, values))
        for state in range(4):
            still = np.zeros_like(drive.steer)
            plant = known.plant(drive.time_s, still, drive.speed, at)
            plant.initial = STARTS * np.eye(4)[state]
            plants.append(plant)
        plants.append(known.plant(drive.time_s, drive.steer, drive.speed, at))
        for kick in _kicks(len(drive.steer), turn)[: halves * KICKS]:
            for disturbance in DISTURBANCES:
                plant = known.plant(drive.time_s, drive.steer, drive.speed, at)
                plant.add_series(disturbance.slot, disturbance.rms * kick)
                plants.append(plant)
    each = len(plants) // max(len(drives), 1)
    outcomes = run_jobs([Job(plant, columns=columns) for plant in plants])
    shown = [outcome.output for outcome in outcomes if outcome.output is not None]
    assert len(shown) == len(plants)
    found = []
    for number, drive in enumerate(drives):
        own = shown[each * number : each * (number + 1)]
        slope = [(own[2 * k] - own[2 * k + 1]) / (2 * SHARE) for k in range(count)]
        free, calm = own[2 * count : 2 * count + 4], own[2 * count + 4]
        kicks = np.stack([spectrum(one - calm) for one in own[2 * count + 5 :]], axis=2)
        samples = len(drive.steer)
        part = np.stack(np.split(np.sqrt(samples / KICKS) * kicks, halves, axis=2))
        noise = np.array([samples * sensor.noise**2 for sensor in sensors])
        found.append(
            Lines(spectrum(np.stack(slope, axis=2)), spectrum(np.stack(free, axis=2)), noise, part)
        )
    return found


def _kicks(samples: int, turn: int) -> list[Array]:
    """What one moment adds to a disturbance of RMS 1, at twice `KICKS` moments of a drive.

    Either half of them is spread evenly.
    """
    pole = np.exp(-2.0 * np.pi * CORNER_HZ * STEP_S)
    shape = np.sqrt(1.0 - pole**2) * pole ** np.arange(samples)
    # golden ratio: no period of the steering is met at one phase only
    shares = np.mod(0.5 + GOLDEN * (np.arange(2 * KICKS) + 2 * KICKS * turn), 1.0)
    starts = np.round(shares * (samples - 1)).astype(int)
    return [np.concatenate([np.zeros(k), shape[: samples - k]]) for k in starts]


def disturbed(samples: int, rms: float, random: np.random.Generator) -> Array:
    """A course of a disturbance."""
    pole = np.exp(-2.0 * np.pi * CORNER_HZ * STEP_S)
    white = random.normal(0.0, 1.0, samples + 1000)
    course = lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], white)
    return np.asarray(rms * course[1000:], dtype=np.float64)


DRAWS = 32


def drawn(known: Knowledge) -> list[Array]:
    """Values of the unknowns of `DRAWS` combinations that the belief allows."""
    random = np.random.default_rng(1)
    found = []
    for _ in range(DRAWS):
        off = np.clip(random.normal(size=len(known.unknowns)), -2.0, 2.0)
        found.append(np.maximum(known.values + off * known.deviations, 0.0))
    return found


def information(
    known: Knowledge, drives: Sequence[PlannedDrive], sensors: Sequence[KnownSensor]
) -> list[Array]:
    """Information of each drive; (2, k, k), see :meth:`Lines.information`."""
    return [own.information() for own in lines_of(known, drives, sensors, known.values)]


def errors(informed: Array) -> Array:
    """Covariance of the unknowns, in units of their tolerances, from the drives and the tolerances.

    `informed`: sum over the drives, (2, k, k); of several combinations, (n, 2, k, k), their mean.
    """
    one = np.eye(informed.shape[-1])
    inverse = np.linalg.inv(informed[..., 0, :, :] + one)
    found = inverse @ (informed[..., 1, :, :] + one) @ inverse
    return np.asarray(found.reshape(-1, *one.shape).mean(axis=0), dtype=np.float64)


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
