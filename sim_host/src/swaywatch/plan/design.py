"""Which manoeuvres to drive: candidates within safe limits, chosen one after the other.

Candidates are blocks of 20 s, one manoeuvre at one speed. Speeds stay a margin below the critical
speed as believed; steering is as large as lateral acceleration allows. The block that tells most
for what has been chosen so far is taken next, until the error asked for is reached.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swaywatch.errors import VehicleError
from swaywatch.models.modes import modes
from swaywatch.plan.information import (
    STEP_S,
    Critical,
    PlannedDrive,
    critical_of,
    drawn,
    errors,
    information,
    lines_of,
    outputs,
)
from swaywatch.plan.knowledge import SETS, Knowledge, KnownSensor, sensors_of
from swaywatch.plant.lanes import OUTPUT
from swaywatch.simulate.manoeuvres import make_plan
from swaywatch.simulate.table import Table

Array = NDArray[np.float64]
KMH = 3.6

BLOCK_S = 20.0
MOST_BLOCKS = 15
SLOWEST_KMH = 40.0
LEAST_MARGIN_KMH = 10.0
LEAST_DAMPING = 0.05
SIZES = 2.0
"""Standard deviations of the believed critical speed that the fastest block stays below it."""
LARGEST_ANGLE_DEG, LARGEST_RATE_DEG_S = 90.0, 300.0
"""At the steering wheel: what a hand can do."""
SWAY_HZ = (0.05, 1.3)
"""Where a trailer's sway is looked for; what is above is the car's own."""
SPEEDS = (0.55, 0.7, 0.85, 1.0)
"""Of the fastest speed that is safe."""
ROUNDS, CLOSER = 4, 0.95
"""Choices for the combination as believed, each for a smaller error, until the mean over what the
belief allows is as asked."""
GAIN = 1e-3
"""Share of the error by which one more block must lower it."""


@dataclass(frozen=True)
class Block:
    """One manoeuvre at one speed.

    Attributes
    ----------
    words
        For the report.
    speed_kmh
        Held.
    tables
        Manoeuvres as a scenario has them, times from the block's start.
    """

    words: str
    speed_kmh: float
    tables: tuple[dict[str, Any], ...]

    def drive(self) -> PlannedDrive:
        """Steering and speed over `BLOCK_S`."""
        time = np.asarray(np.arange(round(BLOCK_S / STEP_S)) * STEP_S, dtype=np.float64)
        made = make_plan(
            time, self.speed_kmh / KMH, [Table(dict(t), self.words) for t in self.tables]
        )
        return PlannedDrive(made.steering_rad, made.speed_m_s)

    def scaled(self, factor: float) -> Block:
        """The same with all steering larger or smaller, within what a hand can do."""

        def angle(entry: dict[str, Any]) -> float:
            fastest = max(entry.get("frequency_hz", 0.675), entry.get("to_hz", 0.0))
            if entry["kind"] == "steady_circle":
                fastest = 1.0 / (2.0 * math.pi * entry["ramp_s"])
            most = min(LARGEST_ANGLE_DEG, LARGEST_RATE_DEG_S / (2.0 * math.pi * fastest))
            return round(float(np.clip(factor * entry["angle_deg"], -most, most)), 1)

        tables = tuple({**entry, "angle_deg": angle(entry)} for entry in self.tables)
        return Block(self.words, self.speed_kmh, tables)


@dataclass(frozen=True)
class Limits:
    """What must not be exceeded: speed and lateral acceleration of either body."""

    fastest_kmh: float
    acceleration_m_s2: float


@dataclass(frozen=True)
class Design:
    """A plan and what it will tell.

    Attributes
    ----------
    blocks
        In the order to be driven: the slow ones first.
    covariance
        Of the unknowns after the test, in units of their tolerances: mean over combinations that
        the belief allows.
    by_sensors
        Error of the critical speed (m/s) and of every unknown (in tolerances) with each set of
        sensors, by its name.
    slalom_blocks
        Blocks of a plain slalom (sway frequency, the best of the speeds) for the same error of
        the critical speed; inf: not with a thousand.
    """

    known: Knowledge
    limits: Limits
    critical: Critical
    sensors: str
    blocks: tuple[Block, ...]
    covariance: Array
    by_sensors: dict[str, tuple[float, Array]]
    slalom_blocks: float

    @property
    def error_kmh(self) -> float:
        """Standard error of the critical speed after the test."""
        return KMH * self.critical.error(self.covariance)

    @property
    def seconds(self) -> float:
        """Of all blocks, without the ways between them."""
        return BLOCK_S * len(self.blocks)


def limits_of(
    known: Knowledge, critical: Critical, fastest_kmh: float, acceleration: float
) -> Limits:
    """Safe limits.

    Raises
    ------
    VehicleError
        No speed of 40 km/h or more is safe.
    """
    believed = critical.error(np.eye(len(known.unknowns)))
    margin = max(LEAST_MARGIN_KMH, SIZES * believed * KMH)
    top = min(fastest_kmh, critical.speed_m_s * KMH - margin)
    while top >= SLOWEST_KMH and _damping(known, top) < LEAST_DAMPING:
        top -= 2.0
    if top < SLOWEST_KMH:
        raise VehicleError(
            f"the combination of the file has a critical speed of {critical.speed_m_s * KMH:.0f} "
            f"km/h, known to {believed * KMH:.0f} km/h: no test at {SLOWEST_KMH:g} km/h or more is "
            "safe"
        )
    return Limits(float(top), acceleration)


def _sway(known: Knowledge, speed_kmh: float) -> tuple[float, float]:
    """Damping ratio and frequency of the trailer's sway; 1 and 0.6 Hz where there is none."""
    still = np.zeros(3)
    plant = known.plant(
        np.array([0.0, 0.002, 0.004]), still, still + speed_kmh / KMH, known.values
    )  # fmt: skip
    swings = [
        mode
        for mode in modes(plant, speed_kmh / KMH)
        if SWAY_HZ[0] < mode.frequency_hz < SWAY_HZ[1]
    ]
    return (swings[0].damping_ratio, swings[0].frequency_hz) if swings else (1.0, 0.6)


def _damping(known: Knowledge, speed_kmh: float) -> float:
    return _sway(known, speed_kmh)[0]


def candidates(known: Knowledge, limits: Limits) -> list[Block]:
    """Manoeuvres at a few speeds, steered as hard as the limits allow."""
    found = []
    for share in SPEEDS:
        speed = max(SLOWEST_KMH, share * limits.fastest_kmh)
        f = _sway(known, speed)[1]
        for words, tables in _kinds(f):
            found.append(Block(words, round(speed, 1), tuple(tables)))
    return fitted(known, limits, found)


SLALOM = "slalom"


def _kinds(f: float) -> list[tuple[str, list[dict[str, Any]]]]:
    hz = round(f, 3)
    tone: dict[str, Any] = {"kind": "slalom", "angle_deg": 10.0, "soft_s": 1.0}
    return [
        ("steering impulse, then free", [{"kind": "impulse", "start_s": 1.0, "angle_deg": 10.0}]),
        (SLALOM, [{**tone, "start_s": 0.5, "duration_s": 19.0, "frequency_hz": hz}]),
        ("two tones, slow and fast", [
            {**tone, "start_s": 0.5, "duration_s": 9.5, "frequency_hz": round(0.45 * f, 3)},
            {**tone, "start_s": 10.2, "duration_s": 9.0, "frequency_hz": round(1.8 * f, 3)},
        ]),
        ("sine sweep", [{
            "kind": "sine_sweep", "start_s": 0.5, "angle_deg": 10.0, "duration_s": 19.0,
            "from_hz": 0.12, "to_hz": 2.0,
        }]),
        ("lane change, then free", [
            {"kind": "lane_change", "start_s": 1.0, "angle_deg": 10.0, "frequency_hz": 0.3}
        ]),
        ("step steer, then a circle", [
            {"kind": "steady_circle", "start_s": 1.0, "angle_deg": 10.0, "ramp_s": 0.3}
        ]),
    ]  # fmt: skip


_BOTH = (
    KnownSensor("car", "car_acceleration", 1.0),
    KnownSensor("trailer", "trailer_acceleration", 1.0),
)


def fitted(known: Knowledge, limits: Limits, blocks: Sequence[Block]) -> list[Block]:
    """Blocks steered so hard that the acceleration limit is just reached."""
    assert all(sensor.output in OUTPUT for sensor in _BOTH)
    found = list(blocks)
    for _ in range(2):  # the plant is nearly linear in the angle, not wholly
        shown = outputs(known, [b.drive() for b in found], [known.values] * len(found), _BOTH)
        largest = [float(np.max(np.abs(part))) for part in shown]
        found = [
            block.scaled(limits.acceleration_m_s2 / max(peak, 1e-6))
            for block, peak in zip(found, largest, strict=True)
        ]
    return found


def iso9815(known: Knowledge, limits: Limits) -> list[Block]:
    """Impulses at five speeds over 30 km/h, two at each, to either side (ISO 9815)."""
    low = max(SLOWEST_KMH, limits.fastest_kmh - 30.0)
    blocks = [
        Block(
            "steering impulse, then free", round(float(speed), 1),
            ({"kind": "impulse", "start_s": 1.0, "angle_deg": sign * 10.0},),
        )
        for speed in np.linspace(low, limits.fastest_kmh, 5)
        for sign in (1.0, -1.0)
    ]  # fmt: skip
    return fitted(known, limits, blocks)


def j2664(known: Knowledge, limits: Limits) -> list[Block]:
    """Steering pulses at speeds 10 km/h apart up to 100 km/h, two at each (as SAE J2664)."""
    top = min(100.0, limits.fastest_kmh)
    blocks = [
        Block(
            "steering pulse, then free", round(float(speed), 1),
            ({"kind": "impulse", "start_s": 1.0, "angle_deg": sign * 10.0, "frequency_hz": 1.0},),
        )
        for speed in np.arange(top, max(SLOWEST_KMH, top - 40.0) - 0.1, -10.0)[::-1]
        for sign in (1.0, -1.0)
    ]  # fmt: skip
    return fitted(known, limits, blocks)


PRESETS = {"iso9815": iso9815, "j2664": j2664}


def _figure(known: Knowledge, critical: Critical, covariance: Array, goal: str) -> float:
    """What shall become small: error of the critical speed in km/h, or of the worst unknown."""
    if goal == "critical-speed" and math.isfinite(critical.speed_m_s):
        return KMH * critical.error(covariance)
    relative = np.array([u.deviation / u.value for u in known.unknowns])
    vehicle = np.array(["." in u.name for u in known.unknowns])
    return float(100.0 * np.max((np.sqrt(np.diag(covariance)) * relative)[vehicle]))


def choose(
    known: Knowledge, critical: Critical, informed: Sequence[Array], goal: str, error: float
) -> list[int]:
    """Numbers of the candidates to drive; one may be driven several times."""
    size = len(known.unknowns)
    total = np.zeros((2, size, size))
    chosen: list[int] = []
    now = _figure(known, critical, errors(total), goal)
    while now > error and len(chosen) < MOST_BLOCKS:
        after = [_figure(known, critical, errors(total + one), goal) for one in informed]
        best = int(np.argmin(after))
        if after[best] > (1.0 - GAIN) * now:
            break
        chosen.append(best)
        total = total + informed[best]
        now = after[best]
    return chosen


def make_design(
    known: Knowledge,
    sensors: str,
    *,
    goal: str = "critical-speed",
    error: float = 1.0,
    fastest_kmh: float = 110.0,
    acceleration_m_s2: float = 3.0,
    preset: str | None = None,
) -> Design:
    """The plan.

    Parameters
    ----------
    sensors
        A key of `knowledge.SETS`.
    goal, error
        ``critical-speed`` to so many km/h, or ``parameters`` (the vehicle's) to so many per cent;
        standard errors.
    preset
        A key of `PRESETS`: its blocks instead of a choice.

    Raises
    ------
    VehicleError
        No speed is safe.
    """
    critical = critical_of(known)
    limits = limits_of(known, critical, fastest_kmh, acceleration_m_s2)
    pool = candidates(known, limits)
    informed = information(known, [block.drive() for block in pool], sensors_of(sensors))
    if preset is not None:
        blocks = PRESETS[preset](known, limits)
        expected = _expected(known, blocks)
        own = information(known, [block.drive() for block in blocks], sensors_of(sensors))
        believed = errors(np.sum(own, axis=0))
    else:
        aim = error
        for _ in range(ROUNDS):
            chosen = choose(known, critical, informed, goal, aim)
            blocks = sorted((pool[k] for k in chosen), key=lambda b: (b.speed_kmh, b.words))
            expected = _expected(known, blocks)
            figure = _figure(known, critical, expected[sensors], goal)
            if figure <= error or len(blocks) == MOST_BLOCKS:
                break
            aim *= CLOSER * error / figure
        believed = errors(
            np.sum([np.zeros_like(informed[0]), *(informed[k] for k in chosen)], axis=0)
        )
    by_sensors = {
        name: (critical.error(one), np.sqrt(np.diag(one))) for name, one in expected.items()
    }
    slaloms = [own for block, own in zip(pool, informed, strict=True) if block.words == SLALOM]
    wanted = _figure(known, critical, believed, goal)
    needed = min(
        (_blocks_for(known, critical, own, wanted, goal) for own in slaloms), default=math.inf
    )
    return Design(
        known, limits, critical, sensors, tuple(blocks), expected[sensors], by_sensors, needed
    )  # fmt: skip


def _expected(known: Knowledge, blocks: Sequence[Block]) -> dict[str, Array]:
    """Covariance of the unknowns with each set of sensors, mean over what the belief allows."""
    sets = {name: sensors_of(name) for name in SETS}
    every = list(dict.fromkeys(sensor for own in sets.values() for sensor in own))
    columns = {name: [every.index(sensor) for sensor in own] for name, own in sets.items()}
    drives = [block.drive() for block in blocks]
    total: dict[str, list[Array]] = {name: [] for name in SETS}
    for turn, at in enumerate(drawn(known)):
        found = lines_of(known, drives, every, at, turn=turn)
        for name, own in columns.items():
            nothing = np.zeros((2, *2 * known.values.shape))
            total[name].append(sum((one.of(own).information() for one in found), nothing))
    return {name: errors(np.stack(informed)) for name, informed in total.items()}


def _blocks_for(
    known: Knowledge, critical: Critical, informed: Array, wanted: float, goal: str
) -> float:
    """Times that one block has to be driven for an error."""
    low, high = 0.0, 1000.0
    if _figure(known, critical, errors(high * informed), goal) > wanted:
        return math.inf
    for _ in range(30):
        middle = 0.5 * (low + high)
        if _figure(known, critical, errors(middle * informed), goal) > wanted:
            low = middle
        else:
            high = middle
    return high
