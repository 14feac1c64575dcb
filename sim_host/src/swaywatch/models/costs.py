"""What each cause costs: critical speed and damping with and without it, at swings of any size.

Eigenvalues know only the smallest of motions. Dry friction, free play, saturating tyres and axle
loads at twice the yaw frequency act by the size of the swing, so the plant itself is set swinging:
it starts in the shape of its least damped mode, the trailer's yaw rate at a given amplitude, and
swings freely for three and a half periods. Growth and frequency are those of its yaw rate between
two windows a period apart (:func:`swings`); the critical speed at that size is where the growth is
zero. A load that follows the motion (Eq. 6.1-6.2 of the reference) is locked to the phase of the
axle forces of that very swing.

    costs = weigh(Base(body, scalars), causes, speed_m_s=30.0)
    costs.causes[0].back[1]      # km/h that come back without it, middle swing; and its error

Limits: the speed is held; a swing far from the critical speed changes its size while it is
measured, so there the size is that at the start. A cause that adds to the motion from outside (a
gust, a bank) moves no critical speed and does not belong here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.plant import AXLES, OUTPUT, SCALARS, Job, PlantInput, run_jobs
from swaywatch.models.modes import FASTEST_M_S, SLOWEST_M_S, STEP_S, transitions

Array = NDArray[np.float64]
KMH = 3.6

SWINGS_RAD_S = (math.radians(1.0), math.radians(4.0), math.radians(10.0))
"""Amplitudes of the trailer's yaw rate: just seen, felt, frightening (an articulation of about 0.3,
1 and 3 degrees)."""

BAND_HZ = (0.15, 3.0)
PERIODS = 3.5
SAMPLE_S = 0.01
SPACING_M_S = 4.0
POINTS = 5
"""Speeds between two that hold the critical one, tried at once."""
CLOSE_M_S = 0.01
FASTER_M_S = 0.25
"""Step that tells how growth goes with speed."""
DISORDER = 50.0
"""1/s: growth of a combination that leaves all bounds."""

_SMALLEST_ONLY = ("hitch_friction", "free_play")
"""Slots that hold the smallest of motions: without them in the search for the mode's shape."""
_FORCES = {
    "car_front": ("lateral_fl", "lateral_fr"), "car_rear": ("lateral_rl", "lateral_rr"),
    "trailer_front": ("trailer_lateral_fl", "trailer_lateral_fr"),
    "trailer_rear": ("trailer_lateral_rl", "trailer_lateral_rr"),
}  # fmt: skip
_COLUMNS = tuple(
    OUTPUT.index(name)
    for name in ("trailer_yaw_rate", *(name for pair in _FORCES.values() for name in pair))
)


@dataclass(frozen=True)
class Motion:
    """The swing that a load follows.

    Attributes
    ----------
    time_s : shape (n,)
    phase : by axle, shape (n,)
        Of the axle's lateral force, rad.
    """

    time_s: Array
    phase: Mapping[str, Array]


@dataclass(frozen=True)
class Cause:
    """Something that acts in the plant.

    Attributes
    ----------
    name
        For the table.
    values : shape (n,)
        What was found of it.
    act
        Fills slots of the plant, from values; a load that follows the motion takes its phase from
        the last argument.
    covariance : shape (n, n)
        Of the values; zeros: they are exact.
    follows
        Whether `act` looks at the motion.
    """

    name: str
    values: Array
    act: Callable[[PlantInput, Array, Motion], None]
    covariance: Array
    follows: bool = False


@dataclass(frozen=True)
class Base:
    """The vehicle without the causes.

    Attributes
    ----------
    body, scalars
        As of `plant.PlantInput`.
    deviation : shape of `body`
        Standard deviations of the vehicle's values; zeros: exact.
    """

    body: Array
    scalars: Array
    deviation: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class Figure:
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
    """

    name: str
    without: tuple[Figure, ...]
    back: tuple[Figure, ...]
    damping_without: tuple[float, ...]


@dataclass(frozen=True)
class Costs:
    """All causes, the dearest (middle swing) first; of each swing.

    Attributes
    ----------
    healthy, found
        Critical speed with none and with all of the causes, km/h.
    damping_healthy, damping_found
        Damping ratios at `speed_m_s`; NaN where the swing is no oscillation any more.
    """

    swings_rad_s: tuple[float, ...]
    speed_m_s: float
    healthy: tuple[Figure, ...]
    found: tuple[Figure, ...]
    damping_healthy: tuple[float, ...]
    damping_found: tuple[float, ...]
    causes: tuple[Cost, ...]


_Case = tuple[Base, tuple[Cause, ...], float, float]
"""Vehicle, causes, speed in m/s, swing in rad/s."""


def _plant(case: _Case, samples: int, motion: Motion | None) -> PlantInput:
    base, causes, speed, _ = case
    plant = PlantInput(
        SAMPLE_S, np.full(samples, speed), np.zeros(samples), np.zeros(samples),
        base.body.copy(), base.scalars.copy(),
    )  # fmt: skip
    time = np.asarray(np.arange(samples) * SAMPLE_S, dtype=np.float64)
    still = Motion(time, {axle: np.zeros(samples) for axle in AXLES})
    for cause in causes:
        if not cause.follows or motion is not None:
            cause.act(plant, cause.values, motion or still)
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


def _motion(output: Array, found: complex, rough: complex, samples: int) -> Motion:
    """Phases of the axle forces over the swing."""
    rows = _rows(rough)
    start = rows // 2
    time = np.arange(samples) * SAMPLE_S
    phase: dict[str, Array] = {}
    for number, axle in enumerate(_FORCES):
        force = output[:, 1 + 2 * number] + output[:, 2 + 2 * number]
        line = _turned(force, found.imag, start, rows)
        turned = found.imag * (time - start * SAMPLE_S) + float(np.angle(line))
        phase[axle] = np.asarray(turned, dtype=np.float64)
    return Motion(np.asarray(time, dtype=np.float64), phase)


def swings(cases: Sequence[_Case]) -> list[complex]:
    """Growth and angular frequency, 1/s, of the free swing of each case.

    Cases without an oscillating mode come out as ``-DISORDER``.
    """
    shapes = _shapes(cases)
    live = [k for k, shape in enumerate(shapes) if shape is not None]
    result = [complex(-DISORDER, 0.0)] * len(cases)
    lengths = {}
    for k in live:
        s, _ = shapes[k] or (0j, np.zeros(0))
        lengths[k] = math.ceil(PERIODS / 2 * _rows(s)) + 2
    motions: dict[int, Motion] = {}
    passes = 1 + 2 * any(cause.follows for case in cases for cause in case[1])
    for number in range(passes):
        active = live if number == 0 else [k for k in live if any(c.follows for c in cases[k][1])]
        jobs = []
        for k in active:
            _, shape = shapes[k] or (0j, np.zeros(0))
            plant = _plant(cases[k], lengths[k], motions.get(k))
            jobs.append(Job(plant, state=cases[k][3] * shape, columns=_COLUMNS))
        for k, outcome in zip(active, run_jobs(jobs), strict=True):
            rough, _ = shapes[k] or (0j, np.zeros(0))
            assert outcome.output is not None
            result[k] = _measured(outcome.output, rough)
            if number + 1 < passes and result[k].real < DISORDER:
                motions[k] = _motion(outcome.output, result[k], rough, lengths[k])
    return result


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


@dataclass(frozen=True)
class _Knob:
    """A number that is not exact: by how much, and the case with it moved."""

    cause: int  # -1: the vehicle
    index: int
    step: float


def _moved(
    base: Base, causes: tuple[Cause, ...], knob: _Knob, by: float
) -> tuple[Base, tuple[Cause, ...]]:
    if knob.cause < 0:
        body = base.body.copy()
        body[knob.index] += by
        return replace(base, body=body), causes
    own = causes[knob.cause]
    values = own.values.copy()
    values[knob.index] += by
    changed = list(causes)
    changed[knob.cause] = replace(own, values=values)
    return base, tuple(changed)


def _knobs(base: Base, causes: Sequence[Cause]) -> list[_Knob]:
    found = [
        _Knob(number, k, float(step))
        for number, cause in enumerate(causes)
        for k, step in enumerate(np.sqrt(np.diag(cause.covariance)))
        if step > 0.0
    ]
    return found + [_Knob(-1, k, float(d)) for k, d in enumerate(base.deviation) if d > 0.0]


def _covariance(base: Base, causes: Sequence[Cause], knobs: Sequence[_Knob]) -> Array:
    """Of all knobs; causes are independent of each other and of the vehicle."""
    matrix = np.zeros((len(knobs), len(knobs)))
    for a, one in enumerate(knobs):
        for b, other in enumerate(knobs):
            if one.cause == other.cause >= 0:
                matrix[a, b] = causes[one.cause].covariance[one.index, other.index]
            elif one.cause == other.cause and one.index == other.index:
                matrix[a, b] = one.step**2
    return matrix


def _slopes(
    base: Base, causes: tuple[Cause, ...], chosen: Sequence[tuple[int, ...]],
    knobs: Sequence[_Knob], at: Sequence[float | None], swing: float,
) -> Array:  # fmt: skip
    """Change of each choice's critical speed with each knob, m/s per its unit; (choices, knobs)."""
    cases: list[_Case] = []
    places: list[tuple[int, int]] = []
    for row, (members, speed) in enumerate(zip(chosen, at, strict=True)):
        if speed is None:
            continue
        part = tuple(causes[k] for k in members)
        cases += [(base, part, speed + dv, swing) for dv in (0.0, FASTER_M_S)]
        places += [(row, -2), (row, -1)]
        for column, knob in enumerate(knobs):
            if knob.cause >= 0 and knob.cause not in members:
                continue
            moved_base, moved = _moved(base, causes, knob, knob.step)
            cases.append((moved_base, tuple(moved[k] for k in members), speed, swing))
            places.append((row, column))
    slopes = np.zeros((len(chosen), len(knobs)))
    still = np.zeros(len(chosen))
    with_speed = np.ones(len(chosen))
    for (row, column), growth in zip(places, _growth(cases), strict=True):
        if column == -2:
            still[row] = growth
        elif column == -1:
            with_speed[row] = max((growth - still[row]) / FASTER_M_S, 1e-6)
        else:
            slopes[row, column] = -(growth - still[row]) / knobs[column].step / with_speed[row]
    return slopes


def weigh(
    base: Base,
    causes: Sequence[Cause],
    speed_m_s: float,
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
    swings_rad_s
        Amplitudes of the trailer's yaw rate.
    """
    every = tuple(causes)
    all_of = tuple(range(len(every)))
    chosen: list[tuple[int, ...]] = [(), all_of]
    chosen += [tuple(k for k in all_of if k != left) for left in all_of]
    knobs = _knobs(base, every)
    covariance = _covariance(base, every, knobs)
    speeds: list[list[Figure]] = []
    backs: list[list[Figure]] = []
    dampings: list[list[float]] = []
    for swing in swings_rad_s:
        parts = [tuple(every[k] for k in members) for members in chosen]
        critical = critical_speeds([(base, part, swing) for part in parts])
        slopes = _slopes(base, every, chosen, knobs, critical, swing)
        speeds.append(
            [_figure(v, row, covariance) for v, row in zip(critical, slopes, strict=True)]
        )
        found = critical[1]
        backs.append([
            Figure(None, 0.0) if found is None or critical[2 + k] is None
            else _figure((critical[2 + k] or 0.0) - found, slopes[2 + k] - slopes[1], covariance)
            for k in all_of
        ])  # fmt: skip
        now = swings_of(base, parts, speed_m_s, swing)
        dampings.append([_ratio(s) for s in now])

    def over(rows: Sequence[Sequence[Figure]], index: int) -> tuple[Figure, ...]:
        return tuple(row[index] for row in rows)

    costs = [
        Cost(cause.name, over(speeds, 2 + k), over(backs, k), tuple(row[2 + k] for row in dampings))
        for k, cause in enumerate(every)
    ]
    costs.sort(key=lambda cost: -abs(_middle(cost.back)))
    return Costs(
        tuple(swings_rad_s), speed_m_s, over(speeds, 0), over(speeds, 1),
        tuple(row[0] for row in dampings), tuple(row[1] for row in dampings), tuple(costs),
    )  # fmt: skip


def swings_of(
    base: Base, parts: Sequence[tuple[Cause, ...]], speed_m_s: float, swing: float
) -> list[complex]:
    """Growth and frequency at one speed and size with each choice of causes."""
    return swings([(base, part, speed_m_s, swing) for part in parts])


def _middle(figures: Sequence[Figure]) -> float:
    value = figures[len(figures) // 2].value
    return math.inf if value is None else value


def _figure(speed: float | None, slopes: Array, covariance: Array) -> Figure:
    if speed is None:
        return Figure(None, 0.0)
    return Figure(KMH * speed, KMH * math.sqrt(max(float(slopes @ covariance @ slopes), 0.0)))


# --- causes --------------------------------------------------------------------------------------


def slots(
    name: str, values: Mapping[str, float], errors: Mapping[str, float] | None = None
) -> Cause:
    """A cause that is some scalar slots of the plant (`plant.SCALARS`).

    Raises
    ------
    ValueError
        A slot is unknown.
    """
    wrong = sorted(set(values) - set(SCALARS))
    if wrong:
        raise ValueError(f"{wrong[0]!r} is no slot of the plant")
    names = tuple(values)

    def act(plant: PlantInput, given: Array, motion: Motion) -> None:
        del motion
        for slot, value in zip(names, given, strict=True):
            plant.scalar(slot, float(value))

    deviation = [float((errors or {}).get(slot, 0.0)) for slot in names]
    return Cause(
        name, np.array([values[slot] for slot in names]), act, np.diag(np.square(deviation))
    )


def double_frequency(
    name: str,
    axle: str,
    amplitude_n: float,
    phase_rad: float,
    errors: tuple[float, float] = (0.0, 0.0),
) -> Cause:
    """An axle load at twice the yaw frequency: amplitude cos(2 phi + phase).

    Parameters
    ----------
    axle
        Of `plant.AXLES`; phi is the phase of its lateral force (4.4.2 of the reference).
    errors
        Standard errors of the parts in phase and in quadrature, N.
    """
    if axle not in AXLES:
        raise ValueError(f"{axle!r} is no axle; there are {', '.join(AXLES)}")

    def act(plant: PlantInput, given: Array, motion: Motion) -> None:
        phase = 2.0 * motion.phase[axle]
        plant.add_series(f"load_{axle}", given[0] * np.cos(phase) - given[1] * np.sin(phase))

    parts = amplitude_n * np.array([math.cos(phase_rad), math.sin(phase_rad)])
    return Cause(name, parts, act, np.diag(np.square(errors)), follows=True)
