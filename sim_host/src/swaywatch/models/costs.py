"""What each cause costs: critical speed and damping with and without it, at swings of any size.

Eigenvalues know only the smallest of motions. Dry friction, free play, saturating tyres and axle
loads at twice the yaw frequency act by the size of the swing, so the plant itself is set swinging:
it starts in the shape of its least damped mode, the trailer's yaw rate at a given amplitude, and
swings freely for three and a half periods. Growth and frequency are those of its yaw rate between
two windows a period apart (:func:`swings`); the critical speed at that size is where the growth is
zero. What follows the motion (a load after Eq. 6.1-6.2 of the reference) is made of that very
swing: its lines, drawn on to both sides, are the run that such a cause looks at.

    costs = weigh(Base(body, scalars), causes, speed_m_s=30.0)
    costs.causes[0].back[1]      # km/h that come back without it, middle swing; and its error

Limits: the speed is held, and the steering wheel too; a swing far from the critical speed changes
its size while it is measured, so there the size is that at the start. A cause that adds to the
motion from outside (a gust, a bank) moves no critical speed and does not belong here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from swaywatch.effects.library.axle_load_harmonic import force_phase
from swaywatch.effects.runs import RATE_HZ, Run
from swaywatch.models.modes import FASTEST_M_S, SLOWEST_M_S, STEP_S, transitions
from swaywatch.plant.lanes import AXLES, BLOCK, OUTPUT, SCALARS, Job, PlantInput, run_jobs

Array = NDArray[np.float64]
KMH = 3.6

SWINGS_RAD_S = (math.radians(1.0), math.radians(4.0), math.radians(10.0))
"""Amplitudes of the trailer's yaw rate: just seen, felt, frightening (an articulation of about 0.3,
1 and 3 degrees)."""
MIDDLE = 1
"""The swing by which causes are ranked."""

BAND_HZ = (0.15, 3.0)
PERIODS = 3.5
SAMPLE_S = 1.0 / RATE_HZ
BESIDE = 80 * BLOCK
"""Samples by which the lines of a swing are drawn on, to both sides: filters and running means of
what follows the motion settle."""
SPACING_M_S = 4.0
POINTS = 5
"""Speeds between two that hold the critical one, tried at once."""
CLOSE_M_S = 0.01
FASTER_M_S = 0.25
"""Step that tells how growth goes with speed."""
DISORDER = 50.0
"""1/s: growth of a combination that leaves all bounds."""
LEAST_SHARE = 1e-4
"""Of the variance of one value: directions of the errors with less are left out."""

_SMALLEST_ONLY = ("hitch_friction", "free_play")
"""Slots that hold the smallest of motions: without them in the search for the mode's shape."""
_CHANNELS = {
    "trailer_yaw_rate": "trailer_yaw_rate",
    "car_yaw_rate": "car_yaw_rate",
    "car_lateral_acceleration": "car_acceleration",
    "trailer_lateral_acceleration": "trailer_acceleration",
    **{f"wheel_lateral_force_{w}": f"lateral_{w}" for w in ("fl", "fr", "rl", "rr")},
}
"""Channels of the run that a cause looks at, and outputs of the plant."""
_COLUMNS = tuple(OUTPUT.index(name) for name in _CHANNELS.values())


@dataclass(frozen=True)
class Cause:
    """Something that acts in the plant.

    Attributes
    ----------
    name
        For the table. Causes of one name are the same thing at different times: only one of them
        acts at once, and the one that leaves the lowest critical speed counts.
    values : shape (n,)
        What was found of it.
    act
        Fills slots of the plant, from values and the swing itself.
    follows
        Whether `act` looks at the swing.
    """

    name: str
    values: Array
    act: Callable[[PlantInput, Array, Run], None]
    follows: bool = False


def _as_it_is(plant: PlantInput, values: Array) -> None:
    del plant, values


@dataclass(frozen=True)
class Base:
    """The vehicle without the causes.

    Attributes
    ----------
    body, scalars
        As of `plant.lanes.PlantInput`.
    values : shape (m,)
        What of it is not exact, ...
    act
        ... and what these values do to the plant.
    steering_ratio
        For causes that are given at the steering wheel.
    """

    body: Array
    scalars: Array
    values: Array = field(default_factory=lambda: np.zeros(0))
    act: Callable[[PlantInput, Array], None] = _as_it_is
    steering_ratio: float = 15.0


@dataclass(frozen=True)
class CostValue:
    """A number with its standard error; None: there is none up to the fastest speed tried."""

    value: float | None
    error: float


@dataclass(frozen=True)
class Cost:
    """One cause; of each swing.

    Attributes
    ----------
    without
        Critical speed with all causes but this one, km/h.
    back
        `without` less the critical speed with all: what comes back, km/h.
    damping_without
        Damping ratio at the speed asked for, with all but this one.
    each
        Of causes of one name, in their order: what comes back in the middle swing, km/h.
    worst
        Place of the one that counts among them.
    """

    name: str
    without: tuple[CostValue, ...]
    back: tuple[CostValue, ...]
    damping_without: tuple[float, ...]
    each: tuple[CostValue, ...] = ()
    worst: int = 0


@dataclass(frozen=True)
class Costs:
    """All causes, what gives back most (middle swing) first; of each swing.

    Attributes
    ----------
    healthy, found
        Critical speed with none and with all of the causes, km/h.
    damping_healthy, damping_found
        Damping ratios at `speed_m_s`; NaN where the swing is no oscillation any more.
    """

    swings_rad_s: tuple[float, ...]
    speed_m_s: float
    healthy: tuple[CostValue, ...]
    found: tuple[CostValue, ...]
    damping_healthy: tuple[float, ...]
    damping_found: tuple[float, ...]
    causes: tuple[Cost, ...]


_Case = tuple[Base, tuple[Cause, ...], float, float]
"""Vehicle, causes, speed in m/s, swing in rad/s."""


def _plant(case: _Case, samples: int, motion: Run | None) -> PlantInput:
    """The plant of a case; with its motion, `BESIDE` samples longer to both sides."""
    base, causes, speed, _ = case
    if motion is not None:
        samples = motion.time.size
    plant = PlantInput(
        SAMPLE_S, np.full(samples, speed), np.zeros(samples), np.zeros(samples),
        base.body.copy(), base.scalars.copy(),
    )  # fmt: skip
    base.act(plant, base.values)
    time = np.asarray(np.arange(samples) * SAMPLE_S)
    constant = np.full(samples, speed)
    still = motion or Run("swing", time, {}, {}, base.steering_ratio, speed=constant)
    for cause in causes:
        if not cause.follows or motion is not None:
            cause.act(plant, cause.values, still)
    return plant


def _shapes(cases: Sequence[_Case]) -> list[tuple[complex, Array] | None]:
    """Eigenvalue and shape (trailer's yaw rate at its top) of each case's sway; None: none."""
    plants = []
    for case in cases:
        plant = _plant(case, 3, None)
        for name in _SMALLEST_ONLY:
            plant.scalar(name, 0.0)
        plants.append(plant)
    found: list[tuple[complex, Array] | None] = []
    for matrix in transitions(plants, [case[2] for case in cases]):
        if not np.all(np.isfinite(matrix)):  # values beyond all sense leave no vehicle
            found.append(None)
            continue
        values, vectors = np.linalg.eig(matrix)
        # a state that never moves (1) or forgets at once (0) is no swing
        s = np.log(np.where(np.abs(values) < 1e-12, 1.0, values).astype(complex)) / STEP_S
        swings = (s.imag > 2 * np.pi * BAND_HZ[0]) & (s.imag < 2 * np.pi * BAND_HZ[1])
        swings &= np.abs(vectors[3]) > 1e-9 * np.abs(vectors).max(axis=0)
        if not swings.any():
            found.append(None)
            continue
        k = int(np.flatnonzero(swings)[np.argmax(s.real[swings] / np.abs(s[swings]))])
        shape = vectors[:, k] / vectors[3, k]
        found.append((complex(s[k]), np.asarray(shape.real, dtype=np.float64)))
    return found


def _turned(signal: Array, omega: float, start: int, rows: int) -> complex:
    """A signal's line over two periods (Hann window: no mean, no double frequency)."""
    part = signal[start : start + rows]
    place = (np.arange(len(part)) + 0.5) / rows
    window = 1.0 - np.cos(2.0 * np.pi * place)
    return complex(np.sum(part * window * np.exp(-1j * omega * SAMPLE_S * np.arange(len(part)))))


def _rows(s: complex) -> int:
    """Samples of two periods, an even number."""
    return 2 * round(2.0 * np.pi / s.imag / SAMPLE_S)


def _measured(output: Array, s: complex) -> complex:
    """Growth and frequency of a swing, s = growth + j omega."""
    rows = _rows(s)
    period = rows // 2
    omega = 4.0 * np.pi / (rows * SAMPLE_S)  # two whole periods in the window
    signal = output[:, 0]
    if not np.all(np.isfinite(signal)) or np.all(signal[-3:] == 0.0):
        return complex(DISORDER, s.imag)
    for _ in range(3):
        first = _turned(signal, omega, period // 2, rows)
        last = _turned(signal, omega, period // 2 + period, rows)
        turn = np.log(last / first * np.exp(1j * omega * SAMPLE_S * period))
        span = period * SAMPLE_S
        turns = round((s.imag * span - turn.imag) / (2.0 * np.pi))
        found = complex(turn.real, turn.imag + 2.0 * np.pi * turns) / span
        omega = float(np.clip(found.imag, 0.6 * s.imag, 1.6 * s.imag))
    return complex(min(found.real, DISORDER), found.imag)


def _motion(output: Array, found: complex, rough: complex, case: _Case) -> Run:
    """The swing as a run: the line of each signal, drawn on to both sides at the size it had."""
    rows = _rows(rough)
    start = rows // 2
    time = (np.arange(output.shape[0] + 2 * BESIDE) - BESIDE) * SAMPLE_S
    grown = np.clip(time, 0.0, output.shape[0] * SAMPLE_S) - (start + 0.5 * rows) * SAMPLE_S
    s = complex(np.clip(found.real, -3.0, 3.0), found.imag)
    course = np.exp(s.real * grown + 1j * s.imag * (time - start * SAMPLE_S))
    place = (np.arange(rows) + 0.5) / rows
    window = (1.0 - np.cos(2.0 * np.pi * place)) * np.exp(-1j * s.imag * SAMPLE_S * np.arange(rows))
    line = 2.0 / rows * np.einsum("i,ij->j", window, output[start : start + rows])
    channels = {
        name: np.asarray(np.real(x * course)) for name, x in zip(_CHANNELS, line, strict=True)
    }
    base, _, speed, _ = case
    run = Run("swing", time, channels, {}, base.steering_ratio)
    run.speed = np.full(time.size, speed)
    run.acceleration = run.steer = np.zeros(time.size)
    return run


def swings(cases: Sequence[_Case]) -> list[complex]:
    """Growth and angular frequency, 1/s, of the free swing of each case.

    Cases without an oscillating mode come out as ``-DISORDER``.
    """
    shapes = _each_shape(cases)
    live = [k for k, shape in enumerate(shapes) if shape is not None]
    result = [complex(-DISORDER, 0.0)] * len(cases)
    motions: dict[int, Run] = {}
    following = [k for k in live if any(cause.follows for cause in cases[k][1])]
    for number in range(1 + 2 * bool(following)):
        active = live if number == 0 else following
        jobs = []
        for k in active:
            rough, shape = shapes[k] or (0j, np.zeros(0))
            samples = math.ceil(PERIODS / 2 * _rows(rough)) + 2
            plant = _plant(cases[k], samples, motions.get(k))
            first = BESIDE if k in motions else 0
            state = cases[k][3] * shape
            jobs.append(Job(plant, (first, first + samples), state, _COLUMNS))
        for k, job, outcome in zip(active, jobs, run_jobs(jobs), strict=True):
            rough, _ = shapes[k] or (0j, np.zeros(0))
            assert outcome.output is not None
            assert job.span is not None
            output = outcome.output[job.span[0] : job.span[1]]
            result[k] = _measured(output, rough)
            if k in following and result[k].real < DISORDER:
                motions[k] = _motion(output, result[k], rough, cases[k])
    return result


def _each_shape(cases: Sequence[_Case]) -> list[tuple[complex, Array] | None]:
    """Shapes of all cases; those that differ in the size of the swing have the same."""
    keys = [(id(base), tuple(id(c) for c in causes), speed) for base, causes, speed, _ in cases]
    first = dict(zip(keys, cases, strict=True))
    found = dict(zip(first, _shapes(list(first.values())), strict=True))
    return [found[key] for key in keys]


def critical_speeds(cases: Sequence[tuple[Base, tuple[Cause, ...], float]]) -> list[float | None]:
    """Lowest speed at which each swing does not decay, m/s; None: none up to 84 m/s."""
    grid = np.arange(SLOWEST_M_S, FASTEST_M_S + 1e-9, SPACING_M_S)
    growth = _growth([(b, c, float(v), a) for b, c, a in cases for v in grid])
    bounds: list[tuple[float, float] | None] = []
    for row in growth.reshape(len(cases), -1):
        above = np.flatnonzero(row > 0.0)
        k = int(above[0]) if len(above) else -1
        bounds.append(None if k < 0 else (float(grid[max(k - 1, 0)]), float(grid[k])))
    while any(b is not None and b[1] - b[0] > CLOSE_M_S for b in bounds):
        open_ = [k for k, b in enumerate(bounds) if b is not None and b[1] - b[0] > CLOSE_M_S]
        tried = [np.linspace(*(bounds[k] or (0.0, 0.0)), POINTS + 2) for k in open_]
        growth = _growth(
            [
                (*cases[k][:2], float(v), cases[k][2])
                for k, v in zip(open_, tried, strict=True)
                for v in v[1:-1]
            ]
        ).reshape(len(open_), POINTS)
        for k, speeds, row in zip(open_, tried, growth, strict=True):
            above = np.flatnonzero(row > 0.0)
            first = int(above[0]) + 1 if len(above) else POINTS + 1
            bounds[k] = (float(speeds[first - 1]), float(speeds[first]))
    return [None if b is None else 0.5 * (b[0] + b[1]) for b in bounds]


def _growth(cases: Sequence[_Case]) -> Array:
    return np.array([s.real for s in swings(cases)])


def _ratio(s: complex) -> float:
    return math.nan if s.imag == 0.0 else -s.real / abs(s)


def _directions(covariance: Array) -> Array:
    """Moves of all values that are independent of each other, one standard deviation each.

    Shape (moves, values). Taken along single values, errors that hold each other would not cancel.
    """
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    scale = np.where(size > 0.0, size, 1.0)
    variance, turned = np.linalg.eigh(covariance / np.outer(scale, scale))
    kept = variance > LEAST_SHARE
    return np.asarray((turned[:, kept] * np.sqrt(variance[kept])).T * size)


@dataclass(frozen=True)
class _Question:
    """Causes that act, by their places, and the size of the swing."""

    members: tuple[int, ...]
    swing: float


def _moved(base: Base, causes: Sequence[Cause], by: Array) -> tuple[Base, tuple[Cause, ...]]:
    """Vehicle and causes with all values moved; shape of `by`: (values of all,)."""
    at = base.values.size
    changed = []
    for cause in causes:
        changed.append(replace(cause, values=cause.values + by[at : at + cause.values.size]))
        at += cause.values.size
    return replace(base, values=base.values + by[: base.values.size]), tuple(changed)


def _changes(
    base: Base, causes: tuple[Cause, ...], asked: Sequence[_Question],
    at: Sequence[float | None], moves: Array,
) -> Array:  # fmt: skip
    """Change of each critical speed with each of `moves`, m/s; shape (asked, moves)."""
    states = [(base, causes), *(_moved(base, causes, move) for move in moves)]
    cases: list[_Case] = []
    for question, speed in zip(asked, at, strict=True):
        if speed is None:
            continue
        own, swing = question.members, question.swing
        parts = [(vehicle, tuple(of[k] for k in own)) for vehicle, of in states]
        cases.append((*parts[0], speed + FASTER_M_S, swing))
        cases += [(*part, speed, swing) for part in parts]
    growth = iter(_growth(cases).reshape(-1, len(states) + 1))
    changes = np.zeros((len(asked), len(moves)))
    for row, speed in enumerate(at):
        if speed is not None:
            faster, still, *moved = next(growth)
            slope = max((faster - still) / FASTER_M_S, 1e-6)
            changes[row] = -(np.array(moved) - still) / slope
    return changes


class _Answers:
    """Critical speeds of all questions, with what moves them together."""

    def __init__(
        self, base: Base, causes: tuple[Cause, ...], asked: Sequence[_Question], covariance: Array
    ) -> None:
        parts = [tuple(causes[k] for k in question.members) for question in asked]
        found = critical_speeds(
            [(base, part, q.swing) for part, q in zip(parts, asked, strict=True)]
        )
        moves = _directions(covariance)
        changes = _changes(base, causes, asked, found, moves)
        self._found = dict(zip(asked, zip(found, changes, strict=True), strict=True))

    def speed(self, question: _Question) -> CostValue:
        """A critical speed, km/h."""
        value, changes = self._found[question]
        return _figure(value, changes)

    def back(self, without: _Question, found: _Question) -> CostValue:
        """By how much one critical speed is higher than another, km/h."""
        higher, own = self._found[without]
        lower, other = self._found[found]
        if higher is None or lower is None:
            return CostValue(None, 0.0)
        return _figure(higher - lower, own - other)


def _worst(
    base: Base, causes: Sequence[Cause], groups: Sequence[Sequence[int]], swing: float
) -> tuple[int, ...]:
    """Of each group the cause with which the critical speed is lowest."""
    lasting = tuple(causes[group[0]] for group in groups if len(group) == 1)
    several = [k for group in groups if len(group) > 1 for k in group]
    if not several:
        return tuple(group[0] for group in groups)
    speeds = critical_speeds([(base, (*lasting, causes[k]), swing) for k in several])
    speed = {k: math.inf if v is None else v for k, v in zip(several, speeds, strict=True)}
    return tuple(min(group, key=lambda k: speed.get(k, 0.0)) for group in groups)


def weigh(
    base: Base,
    causes: Sequence[Cause],
    speed_m_s: float,
    covariance: Array | None = None,
    swings_rad_s: Sequence[float] = SWINGS_RAD_S,
) -> Costs:
    """Critical speed and damping with and without each cause.

    Parameters
    ----------
    base
        The vehicle without the causes.
    causes
        What acts, with what is known of its values.
    speed_m_s
        At which dampings are given.
    covariance : shape (k, k)
        Of the values of the vehicle and of all causes, in their order; None: they are exact.
    swings_rad_s
        Amplitudes of the trailer's yaw rate.
    """
    every = tuple(causes)
    count = base.values.size + sum(cause.values.size for cause in every)
    matrix = np.zeros((count, count)) if covariance is None else covariance
    assert matrix.shape == (count, count)
    names = list(dict.fromkeys(cause.name for cause in every))
    groups = [[k for k, cause in enumerate(every) if cause.name == name] for name in names]
    middle = swings_rad_s[len(swings_rad_s) // 2]
    all_of = _worst(base, every, groups, middle)
    without = [tuple(k for k in all_of if k != left) for left in all_of]
    chosen = list(dict.fromkeys([(), all_of, *without]))
    asked = [_Question(members, swing) for members in chosen for swing in swings_rad_s]
    others = {
        k: _Question(tuple(k if m == own else m for m in all_of), middle)
        for own, group in zip(all_of, groups, strict=True)
        for k in group
    }
    asked += [question for question in others.values() if question not in asked]
    answers = _Answers(base, every, asked, matrix)
    ratios = _dampings(base, every, chosen, speed_m_s, swings_rad_s)

    def over(members: tuple[int, ...]) -> tuple[CostValue, ...]:
        return tuple(answers.speed(_Question(members, swing)) for swing in swings_rad_s)

    costs = []
    for name, group, own, rest in zip(names, groups, all_of, without, strict=True):
        back = tuple(answers.back(_Question(rest, a), _Question(all_of, a)) for a in swings_rad_s)
        each = tuple(answers.back(_Question(rest, middle), others[k]) for k in group)
        costs.append(Cost(name, over(rest), back, ratios[rest], each, group.index(own)))
    found = over(all_of)
    costs.sort(key=lambda cost: -_middle(cost.back, found))
    return Costs(
        tuple(swings_rad_s), speed_m_s, over(()), found, ratios[()], ratios[all_of], tuple(costs)
    )


def _dampings(
    base: Base, causes: Sequence[Cause], chosen: Sequence[tuple[int, ...]], speed: float,
    swings_rad_s: Sequence[float],
) -> dict[tuple[int, ...], tuple[float, ...]]:  # fmt: skip
    """Damping ratios at one speed, of each choice of causes and each swing."""
    cases = [
        (base, tuple(causes[k] for k in members), speed, swing)
        for members in chosen
        for swing in swings_rad_s
    ]
    ratios = [_ratio(s) for s in swings(cases)]
    size = len(swings_rad_s)
    return {members: tuple(ratios[k * size : (k + 1) * size]) for k, members in enumerate(chosen)}


def _middle(back: Sequence[CostValue], found: Sequence[CostValue]) -> float:
    """What comes back in the middle swing, for the order; without end where nothing is left."""
    value = back[len(back) // 2].value
    if value is not None:
        return value
    return -math.inf if found[len(found) // 2].value is None else math.inf


def _figure(speed: float | None, changes: Array) -> CostValue:
    if speed is None:
        return CostValue(None, 0.0)
    return CostValue(KMH * speed, KMH * float(np.linalg.norm(changes)))


# --- causes --------------------------------------------------------------------------------------


def slots(name: str, values: Mapping[str, float]) -> Cause:
    """A cause that is some scalar slots of the plant (`plant.lanes.SCALARS`).

    Raises
    ------
    ValueError
        A slot is unknown.
    """
    wrong = sorted(set(values) - set(SCALARS))
    if wrong:
        raise ValueError(f"{wrong[0]!r} is no slot of the plant")
    names = tuple(values)

    def act(plant: PlantInput, given: Array, swing: Run) -> None:
        del swing
        for slot, value in zip(names, given, strict=True):
            plant.scalar(slot, float(value))

    return Cause(name, np.array([values[slot] for slot in names]), act)


def double_frequency(name: str, axle: str, amplitude_n: float, phase_rad: float) -> Cause:
    """An axle load at twice the yaw frequency: amplitude cos(2 phi + phase).

    Its values are the parts in phase and in quadrature, N.

    Parameters
    ----------
    axle
        Of `plant.lanes.AXLES`; phi is the phase of its lateral force (4.4.2 of the reference), of
        the trailer's axles that of its lateral acceleration.
    """
    if axle not in AXLES:
        raise ValueError(f"{axle!r} is no axle; there are {', '.join(AXLES)}")

    def act(plant: PlantInput, given: Array, swing: Run) -> None:
        phase = 2.0 * force_phase(swing, axle)
        plant.add_series(f"load_{axle}", given[0] * np.cos(phase) - given[1] * np.sin(phase))

    parts = amplitude_n * np.array([math.cos(phase_rad), math.sin(phase_rad)])
    return Cause(name, parts, act, follows=True)
