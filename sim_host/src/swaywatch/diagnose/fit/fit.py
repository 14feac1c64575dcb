"""Fit of explanations: simulate, compare with every channel, refit, compare likelihoods."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bilinear, lfilter

from swaywatch.diagnose.fit.beliefs import Beliefs
from swaywatch.diagnose.fit.budget import Budget
from swaywatch.diagnose.fit.side_by_side import Item, Result, SideBySide
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Parameter, no_observation
from swaywatch.effects.runs import BLOCK, RATE_HZ, Run, block_mean, per_sample
from swaywatch.plant.lanes import (
    OUTPUT,
    SCALARS,
    Job,
    Outcome,
    PlantInput,
    neutral,
    run_along,
    simulate,
)  # fmt: skip

Array = NDArray[np.float64]
ColumnOf = Callable[[int], Array]
#: Of each run: derivatives to beliefs, offsets and start values, and their products.
Background = dict[int, tuple[Array, Array]]

WHILE_SETTLING = 0.05  # weight of residuals
#: Pull of the yaw rates during the search, 1/s: half the angular frequency of sway.
OBSERVER = 2.0
ADDED = (
    "_added_front",
    "_added_rear",
)  # sums of the car's axle loads, before any sensor
ROUNDING_N2 = 1e-9  # variance of an axle load that nothing was added to
HEAVE_N = 10.0  # axle loads (RMS over a run) well below it move no body
_COLUMN = {name: index for index, name in enumerate(OUTPUT)}
_WHEELS = ("fl", "fr", "rl", "rr")
RELATIVE_FLOOR = 0.003  # of a channel's RMS: what no planar model is better than

#: Channels compared with the simulation (the longitudinal force is left out: it is the drive).
COMPARED = (
    "car_yaw_rate", "trailer_yaw_rate", "car_lateral_acceleration",
    "trailer_lateral_acceleration", "articulation", "hitch_lateral_force",
    *(f"wheel_lateral_force_{w}" for w in _WHEELS),
    *(f"wheel_vertical_load_{w}" for w in _WHEELS),
    *(f"trailer_wheel_lateral_force_{w}" for w in _WHEELS),
    *(f"trailer_wheel_vertical_load_{w}" for w in _WHEELS),
    "hitch_vertical_force",
)  # fmt: skip
#: Compared only with a simulation that has them: the planar plant does not.
_VERTICAL = ("trailer_wheel_vertical", "hitch_vertical")
WORKERS = 16  # calculations whose trials share the lanes
NUISANCES = 5  # steering offset and four initial states, for each run
_NUISANCE_STEP = np.array([2e-4, 2e-2, 2e-3, 1e-3, 2e-3])
FRESH = 5  # iterations after which derivatives to what hardly moves are calculated anew
MOVED = 0.3  # gain of an iteration, of what it leaves, after which derivatives are old at once
FARTHEST = 2.0  # wide tolerances by which a typical value moves in one iteration
EDGE_STEP_S = 0.3  # by which an edge of a window moves in one iteration: it is known by no more
#: Steps of derivatives: of beliefs in tolerances, of values and edges of windows in their scales.
_SHIFT_STEP, _VALUE_STEP, _EDGE_STEP = 0.05, 0.01, 0.2


@dataclass
class Fit:
    """State of a fit.

    Attributes
    ----------
    terms
        Explanations in it.
    nuisance
        Shape (runs, 5): road-wheel angle offset, lateral velocity, yaw rate, articulation,
        trailer yaw rate at the start.
    shift
        Tolerances by which each belief of the problem is off, shape (beliefs,).
    chi2
        Sum of squared normalised residuals (10 Hz) and of the shifts over their priors.
    count
        Number of residuals.
    covariance
        Of the effect values, order of `terms`, shape (k, k).
    shift_covariance
        Covariance of the shifts, shape (beliefs, beliefs).
    cross
        Covariance of effect values and shifts, shape (k, beliefs).
    volume
        Logarithm of the determinant of the information about values and shifts.
    """

    terms: tuple[ActiveEffect, ...]
    nuisance: Array
    shift: Array
    chi2: float = np.inf
    count: int = 0
    covariance: Array = field(default_factory=lambda: np.zeros((0, 0)))
    shift_covariance: Array = field(default_factory=lambda: np.zeros((0, 0)))
    volume: float = 0.0
    cross: Array = field(default_factory=lambda: np.zeros((0, 0)))


@dataclass(frozen=True)
class Problem:
    """Runs of one combination with the user's constants (order of `plant.lanes.BODY`).

    Attributes
    ----------
    runs, body
        What is compared.
    free_start
        Whether steering offset and start values are fitted (not against a user's simulation,
        which shares both with the recording).
    observer
        Pull of the simulated yaw rates to the measured ones, 1/s; 0: free simulation.
    beliefs
        Priors of vehicle and sensors.
    given
        Slots of the plant that are known, by name: load transfer as in the user's simulation.
    calibration, start_nuisance, start_shift
        What fits the plant to the user's simulation; part of every model.
    budget
        What all fits of the diagnosis may simulate, shared by problems made from this one.
    """

    runs: tuple[Run, ...]
    body: Array
    free_start: bool = True
    calibration: tuple[ActiveEffect, ...] = ()
    start_nuisance: Array | None = None
    start_shift: Array | None = None
    observer: float = 0.0
    beliefs: Beliefs = field(default_factory=Beliefs)
    given: tuple[tuple[str, float], ...] = ()
    budget: Budget = field(default_factory=Budget, compare=False)

    @property
    def on_springs(self) -> bool:
        """Whether the vehicle is one on springs."""
        return any(name.startswith("sprung_mass") for name, _ in self.given)

    def at_rest(self) -> Array:
        """Shifts of the vehicle and the sensors as they are believed, shape (beliefs,)."""
        return np.zeros(len(self.beliefs))

    def channels(self, run: Run) -> list[str]:
        """Compared channels that the run has."""
        if run.correction:
            return [n for n in COMPARED if n in run.channels and n in run.correction]
        return [n for n in COMPARED if n in run.channels and not n.startswith(_VERTICAL)]


def plant_of(
    problem: Problem, index: int, terms: Sequence[ActiveEffect], nuisance: Array, shift: Array
) -> PlantInput:
    """What the plant needs to simulate one run with `terms`."""
    run = problem.runs[index]
    plant = PlantInput(
        period_s=1.0 / RATE_HZ,
        speed=run.speed,
        acceleration=run.acceleration,
        steer=run.steer + nuisance[0],
        body=problem.body.copy(),
        scalars=neutral(),
        initial=nuisance[1:5].copy(),
    )
    for name, value in problem.given:
        plant.scalar(name, value)
    problem.beliefs.act(plant, shift)
    for term in (*problem.calibration, *terms):
        term.effect.act(plant, run, term.as_dict(), term.windows(index))
    if problem.observer > 0.0:
        for body, rate in run.yaw_rates.items():
            true = rate
            plant.scalar(f"observer_{body}", problem.observer)
            for term in terms:
                undo = term.effect.extra.get("undo")
                if callable(undo) and term.effect.component == f"{body}_yaw_rate":
                    true = undo(true, run, term.as_dict())
            gain = problem.beliefs.amount("gain", f"{body}_yaw_rate", shift)
            plant.add_series(f"measured_{body}", true / (1.0 + gain))
    return plant


def predict_run(
    problem: Problem,
    index: int,
    terms: Sequence[ActiveEffect],
    nuisance: Array,
    shift: Array,
    *,
    fine: bool = True,
) -> dict[str, Array]:
    """Channels of one run as the model with `terms` has them, shape (n,) each."""
    plant = plant_of(problem, index, terms, nuisance, shift)
    return observe(problem, index, simulate(plant, fine=fine), terms, shift)


#: Outputs of the plant whose sum a channel is, where their names differ.
_SOURCES: dict[str, tuple[str, ...]] = {
    "car_lateral_acceleration": ("car_acceleration",),
    "trailer_lateral_acceleration": ("trailer_acceleration",),
    "hitch_longitudinal_force": ("hitch_x",),
    "hitch_lateral_force": ("hitch_y",),
    "hitch_vertical_force": (),
    **{f"wheel_lateral_force_{w}": (f"lateral_{w}",) for w in _WHEELS},
    **{f"wheel_vertical_load_{w}": (f"vertical_{w}",) for w in _WHEELS},
    **{f"trailer_wheel_lateral_force_{w}": (f"trailer_lateral_{w}",) for w in _WHEELS},
    **{f"trailer_wheel_vertical_load_{w}": (f"trailer_vertical_{w}",) for w in _WHEELS},
    ADDED[0]: ("vertical_fl", "vertical_fr"),
    ADDED[1]: ("vertical_rl", "vertical_rr"),
}
#: and what turns an accelerometer that is not at the centre of gravity.
_TURNING = {
    "car_lateral_acceleration": "car_yaw_acceleration",
    "trailer_lateral_acceleration": "trailer_yaw_acceleration",
}
#: Every channel, and the columns of the plant that it is made of.
_MADE_OF = {
    name: tuple(
        _COLUMN[source]
        for source in (
            *_SOURCES.get(name, (name,)),
            *((_TURNING[name],) if name in _TURNING else ()),
        )
    )
    for name in (*COMPARED, "hitch_longitudinal_force", *ADDED)
}


class Channels(dict[str, Array]):
    """Channels of a run at every sample, made of the plant's outputs when they are read.

    Attributes
    ----------
    used
        Columns of the plant that were read.
    changed
        Channels that were written to.
    """

    def __init__(
        self,
        run: Run,
        correction: Mapping[str, Array],
        column: ColumnOf,
        ahead: Callable[[str], float] = lambda name: 0.0,
    ) -> None:
        super().__init__()
        self._ahead = ahead
        self.used: set[int] = set()
        self.changed: set[str] = set()
        self._run, self._correction, self._column = run, correction, column

    def __contains__(self, name: object) -> bool:
        return name in _MADE_OF

    def __setitem__(self, name: str, value: Array) -> None:
        self.changed.add(name)
        super().__setitem__(name, value)

    def __missing__(self, name: str) -> Array:
        columns = _MADE_OF[name]
        self.used.update(columns)
        parts = [self._column(column) for column in columns]
        if name in _TURNING:
            parts[-1] = (self._run.positions.get(name, 0.0) + self._ahead(name)) * parts[-1]
        if name in self._correction:
            parts.append(self._correction[name])
        value = parts[0] if parts else np.zeros(self._run.time.size)
        for part in parts[1:]:
            value = value + part
        super().__setitem__(name, value)
        return value


def correction_of(problem: Problem, run: Run) -> dict[str, Array]:
    """What the user's simulation has beyond the plant."""
    return run.observed if problem.observer > 0.0 else run.correction


def observe(
    problem: Problem, index: int, result: Array, terms: Sequence[ActiveEffect], shift: Array
) -> dict[str, Array]:
    """Sensors: plant outputs (n, len(OUTPUT)) to channels of the recording."""
    run, beliefs = problem.runs[index], problem.beliefs
    out = Channels(
        run,
        correction_of(problem, run),
        lambda column: result[:, column],
        lambda name: beliefs.position(name, shift),
    )
    for term in terms:
        term.effect.observe(out, run, term.as_dict())
    return {name: beliefs.sensed(name, out[name], 1.0 / RATE_HZ, shift) for name in _MADE_OF}


def scale(run: Run, name: str) -> float:
    """Standard deviation of a 10 Hz residual of a channel."""
    if name not in run.scales:
        floor = RELATIVE_FLOOR * float(np.std(run.channels[name]))
        run.scales[name] = float(np.sqrt(run.noise[name] ** 2 / BLOCK + floor**2))
    return run.scales[name]


def residual(problem: Problem, index: int, outputs: Mapping[str, Array]) -> Array:
    """Normalised residuals of one run without their means, shape (n / BLOCK, channels)."""
    comparison = RunComparison(problem, index)
    means = block_mean(np.stack([outputs[n] for n in comparison.names], axis=1))
    return comparison.normalised(means, [block_mean(outputs[key]) for key in ADDED])


def _without_heave(names: Sequence[str], loads: Sequence[Array], e: Array) -> Array:
    """Residuals without what the bodies' heave and pitch make of an axle load that was added.

    Beside a simulation the planar plant knows the load that an effect puts on an
    axle, not the vertical motion that answers it: that linear answer (the load and its first two
    derivatives) is fitted to each vertical channel, so that only the rest counts. `loads` are
    means over blocks.
    """
    columns: list[Array] = []
    size = 0.0
    for added in loads:
        own = float(np.var(added))
        size += own
        if size > 0.01 and own > ROUNDING_N2:
            first = np.gradient(added)
            columns += [added, first, np.gradient(first)]
    if not columns:
        return e
    a = np.stack(columns, axis=1)
    a = (a - a.mean(axis=0)) / (a.std(axis=0) + 1e-12)
    at = [i for i, name in enumerate(names) if "vertical" in name]
    e = e.copy()
    share = size / (size + HEAVE_N**2)
    e[:, at] -= share * (a @ np.linalg.lstsq(a, e[:, at], rcond=None)[0])
    return e


_LOADS = [[_COLUMN[f"vertical_{w}"] for w in axle] for axle in (("fl", "fr"), ("rl", "rr"))]


class RunComparison:
    """Simulation and recording of one run at 10 Hz: what does not depend on the model."""

    def __init__(self, problem: Problem, index: int) -> None:
        self.problem, self.index = problem, index
        run = problem.runs[index]
        self.run = run
        self.names = problem.channels(run)
        self.measured = block_mean(np.stack([run.channels[n] for n in self.names], axis=1))
        self.scales = np.array([scale(run, name) for name in self.names])
        # 0 where the sensor said nothing; enough while a piece settles to find its start values
        rows = [run.kept_blocks(name) for name in self.names]
        self.kept = np.stack(rows, axis=1).astype(float)
        self.kept[: run.settling // BLOCK] *= WHILE_SETTLING
        self.kept_of_each = self.kept.sum(axis=0), np.sqrt((self.kept**2).mean(axis=0))
        self.columns = [(*_MADE_OF[name], 0)[0] for name in self.names]
        self.unmade = [i for i, name in enumerate(self.names) if not _MADE_OF[name]]
        self.read: dict[Callable[..., None], tuple[int, ...]] = {}
        self.turning = [
            (i, _MADE_OF[name][1], run.positions.get(name, 0.0))
            for i, name in enumerate(self.names)
            if name in _TURNING
        ]
        correction = correction_of(problem, run)
        self.correction = np.zeros_like(self.measured)
        for i, name in enumerate(self.names):
            if name in correction:
                self.correction[:, i] = block_mean(correction[name])

    def wanted(self, terms: Sequence[ActiveEffect]) -> tuple[int, ...]:
        """Columns of the plant that effects in the sensors need at every sample."""
        found: set[int] = set()
        for term in terms:
            sensor = term.effect.observe
            if sensor is no_observation:
                continue
            if sensor not in self.read:
                trial = Channels(self.run, {}, self._nothing)
                sensor(trial, self.run, term.as_dict())
                self.read[sensor] = tuple(trial.used)
            found.update(self.read[sensor])
        return tuple(sorted(found))

    def _nothing(self, column: int) -> Array:
        del column
        return np.zeros(self.run.time.size)

    def residual(self, outcome: Outcome, terms: Sequence[ActiveEffect], shift: Array) -> Array:
        """Normalised residuals of a simulation, shape (n / BLOCK, channels).

        The outcome has the columns that are `wanted` for the active effects.
        """
        sums = outcome.blocks[: self.measured.shape[0]]
        means = np.take(sums, self.columns, axis=1)
        means[:, self.unmade] = 0.0
        beliefs = self.problem.beliefs
        for i, column, position in self.turning:
            ahead = position + beliefs.position(self.names[i], shift)
            means[:, i] += ahead * sums[:, column]
        means /= BLOCK
        means += self.correction
        active = [term for term in terms if term.effect.observe is not no_observation]
        if active:
            place = {column: i for i, column in enumerate(outcome.columns)}
            output = outcome.output if outcome.output is not None else np.zeros((0, 0))
            channels = Channels(
                self.run,
                correction_of(self.problem, self.run),
                lambda column: output[:, place[column]],
                lambda name: beliefs.position(name, shift),
            )
            for term in active:
                term.effect.observe(channels, self.run, term.as_dict())
            for i, name in enumerate(self.names):
                if name in channels.changed:
                    means[:, i] = block_mean(channels[name])
        means = beliefs.all_sensed(self.names, means, BLOCK / RATE_HZ, shift)
        loads = [(sums[:, left] + sums[:, right]) / BLOCK for left, right in _LOADS]
        return self.normalised(means, loads)

    def sensors(self, e: Array) -> Array:
        """Derivatives of flat residuals to the gains and delays of the channels' sensors.

        Shape (residuals, beliefs + 5), zero at what must be simulated. What the model shows is
        the measured less the residual.
        """
        beliefs = self.problem.beliefs
        shown = self.measured - e.reshape(self.measured.shape) * self.scales
        found = np.zeros((*self.measured.shape, len(beliefs) + NUISANCES))
        step = BLOCK / RATE_HZ
        for i, name in enumerate(self.names):
            for kind, column in (
                ("gain", shown[:, i]),
                ("delay", -per_sample(shown[:, i]) / step),
            ):
                at = beliefs.at.get((kind, name))
                if at is not None:
                    kept = self.kept[:, i]
                    own = (column - (column * kept).sum() / kept.sum()) * kept
                    found[:, i, at] = -beliefs.items[at].tolerance * own / self.scales[i]
        return found.reshape(e.size, -1)

    def normalised(self, means: Array, loads: Sequence[Array]) -> Array:
        """Measured minus simulated means of the channels, without offsets, over their scales."""
        e = self.measured - means
        if self.run.correction and not self.problem.on_springs:
            e = _without_heave(self.names, loads, e)
        if not self.run.kept and not self.run.settling:
            return np.asarray((e - e.mean(axis=0)) / self.scales)
        count, size = self.kept_of_each
        mean = (e * self.kept).sum(axis=0) / count
        return np.asarray((e - mean) / self.scales * self.kept / size)


def roll_filter(acceleration: Array) -> Array:
    """Acceleration behind the roll of the car's body. Shapes (n,)."""
    scalars = neutral()
    omega = float(scalars[SCALARS.index("roll_frequency_car")])
    damping = float(scalars[SCALARS.index("roll_damping_car")])
    b, a = bilinear([omega**2], [1.0, 2.0 * damping * omega, omega**2], RATE_HZ)
    return np.asarray(lfilter(b, a, acceleration))


@dataclass(frozen=True)
class Trial:
    """One run to be simulated with one set of values."""

    run: int
    terms: tuple[ActiveEffect, ...]
    nuisance: Array
    shift: Array


def slope(moved: Array, base: Array, step: float) -> Array:
    """Derivative of residuals; none to a value whose trial has run away. Shapes (n,)."""
    with np.errstate(over="ignore", invalid="ignore"):
        found = (moved - base) / step
        usable = np.isfinite(np.dot(found, found))
    return np.asarray(found if usable else np.zeros_like(found))


class Fitter:
    """Levenberg-Marquardt over effect values, start values and offsets of all runs."""

    def __init__(self, problem: Problem, *, fine: bool = True) -> None:
        self.problem = problem
        self.fine = fine
        self.comparisons: dict[int, RunComparison] = {}
        self._threads = SideBySide(self._evaluated)

    def comparison(self, index: int) -> RunComparison:
        """What a run is compared by."""
        if index not in self.comparisons:
            self.comparisons[index] = RunComparison(self.problem, index)
        return self.comparisons[index]

    def evaluate(
        self, index: int, terms: Sequence[ActiveEffect], nuisance: Array, shift: Array
    ) -> Array:
        """Normalised residuals of one run, flat."""
        return self.evaluate_all([Trial(index, tuple(terms), nuisance, shift)])[0]

    def evaluate_all(self, trials: Sequence[Trial]) -> list[Array]:
        """Normalised residuals of several trials, flat, simulated side by side."""
        return self._threads.ask(trials)

    def side_by_side(
        self, calculate: Callable[[Item], Result], items: Iterable[Item]
    ) -> list[Result]:
        """`calculate` of every item, in their order, with the trials of all simulated together."""
        return self._threads.map(calculate, items, WORKERS)

    def _evaluated(self, trials: Sequence[Trial]) -> list[Array]:
        runs = self.problem.runs
        self.problem.budget.spend(sum(runs[t.run].speed.size for t in trials) / RATE_HZ)
        jobs = (
            Job(
                plant_of(self.problem, t.run, t.terms, t.nuisance, t.shift),
                columns=self.comparison(t.run).wanted(t.terms),
            )
            for t in trials
        )
        found: dict[int, Array] = {}
        for index, outcome in run_along(jobs, fine=self.fine):
            trial = trials[index]
            with np.errstate(over="ignore", invalid="ignore"):  # a trial that has run away
                e = self.comparison(trial.run).residual(outcome, trial.terms, trial.shift)
            found[index] = np.asarray(e.ravel())
        return [found[index] for index in range(len(trials))]

    def background_trials(self, index: int, fit: Fit) -> list[Trial]:
        """What `background` needs: each belief moved that must be simulated, each nuisance."""
        trials = []
        for c in self._simulated:
            shift = fit.shift.copy()
            shift[c] += _SHIFT_STEP
            trials.append(Trial(index, fit.terms, fit.nuisance[index], shift))
        for c in range(NUISANCES if self.problem.free_start else 0):
            nu = fit.nuisance[index].copy()
            nu[c] += _NUISANCE_STEP[c]
            trials.append(Trial(index, fit.terms, nu, fit.shift))
        return trials

    @cached_property
    def _simulated(self) -> list[int]:
        """Beliefs that are not of the sensors alone."""
        sensors = {n for run in self.problem.runs for n in self.problem.channels(run)}
        if self.problem.observer > 0.0:
            sensors -= {"car_yaw_rate", "trailer_yaw_rate"}  # their gains pull at the plant
        return [
            i
            for i, b in enumerate(self.problem.beliefs.items)
            if b.kind not in ("gain", "delay") or b.name not in sensors
        ]

    def background(self, index: int, base: Array, moved: Sequence[Array]) -> Array:
        """Derivatives to beliefs, offset and start values of a run, (residuals, beliefs + 5)."""
        beliefs = len(self.problem.beliefs)
        places = [*self._simulated, *range(beliefs, beliefs + NUISANCES)]
        steps = [*([_SHIFT_STEP] * len(self._simulated)), *_NUISANCE_STEP]
        found = self.comparison(index).sensors(base)
        for c, h, e in zip(places, steps, moved, strict=False):
            found[:, c] = slope(e, base, h)
        return found[:, : beliefs + (NUISANCES if self.problem.free_start else 0)]

    def backgrounds(
        self, fit: Fit, use: Sequence[int], bases: Sequence[Array] | None = None
    ) -> Background:
        """`background` of some runs, with their products."""
        asked = [self.background_trials(r, fit) for r in use]
        if bases is None:
            bases = self.evaluate_all(
                [Trial(r, fit.terms, fit.nuisance[r], fit.shift) for r in use]
            )
        moved = self.evaluate_all([t for trials in asked for t in trials])
        found: Background = {}
        first = 0
        for r, trials, base in zip(use, asked, bases, strict=True):
            columns = self.background(r, base, moved[first : first + len(trials)])
            first += len(trials)
            found[r] = columns, columns.T @ columns
        return found

    def start(self) -> Fit:
        """Fit without any effect from rest, the vehicle as believed."""
        runs = len(self.problem.runs)
        if self.problem.start_nuisance is not None and self.problem.start_shift is not None:
            return Fit((), self.problem.start_nuisance, self.problem.start_shift)
        shift = self.problem.at_rest()
        transfer = dict(
            zip(("transfer_car_front", "transfer_car_rear"), self._transfer(), strict=True)
        )
        for i, belief in enumerate(self.problem.beliefs.items):
            if belief.kind == "typical" and belief.name in transfer:
                usual = float(neutral()[SCALARS.index(belief.name)])
                shift[i] = (transfer[belief.name] / usual - 1.0) / belief.tolerance
        return Fit((), np.zeros((runs, NUISANCES)), shift)

    def _transfer(self) -> Array:
        """Load transfer from wheel loads and forces (no accelerometer needed)."""
        m1 = self.problem.body[0]
        found = []
        for axle, default in (("f", 435.0), ("r", 356.0)):
            top = bottom = 0.0
            for run in self.problem.runs:
                c = run.channels
                keys = [f"wheel_lateral_force_{w}" for w in _WHEELS] + ["hitch_lateral_force"]
                loads = [f"wheel_vertical_load_{axle}l", f"wheel_vertical_load_{axle}r"]
                if not all(key in c for key in keys + loads):
                    continue
                a = sum(c[key] for key in keys) / m1
                a = roll_filter(a - a.mean())
                dz = 0.5 * (c[loads[1]] - c[loads[0]])
                top += float(np.dot(a, dz - dz.mean()))
                bottom += float(np.dot(a, a))
            found.append(top / bottom if bottom > 0.0 else default)
        return np.array(found)

    def run(
        self,
        start: Fit,
        iterations: int = 8,
        *,
        runs: Sequence[int] | None = None,
        free: int | None = None,
        calibrate: bool = True,
        frozen: Background | None = None,
        tolerance: float = 1e-3,
    ) -> Fit:
        """Improve a fit.

        Parameters
        ----------
        start
            Where to begin.
        runs
            Indices of runs to use; all by default.
        free
            Number of active effects, counted from the end, whose values move; all by default.
        calibrate
            Whether the beliefs move too, within their tolerances.
        frozen
            Derivatives to beliefs, offsets and start values, if they are to be reused throughout;
            else they are calculated anew where they have grown old.
        tolerance
            Relative gain of chi2 below which to stop.
        """
        use = tuple(range(len(self.problem.runs))) if runs is None else tuple(runs)
        task = _Task(self, start.terms, use, free, calibrate)
        state = task.first(start)
        if not np.isfinite(state.chi2):  # it runs away from the first: there is no way to go
            return replace(start, chi2=np.inf)
        background = frozen if frozen is not None else task.background(state)
        age = 0
        hessian = np.eye(task.size)
        damping = 1e-3
        for _ in range(iterations):
            hessian, gradient = task.normal(state, background)
            found = None
            for _ in range(5):
                trial = task.move(state, hessian, gradient, damping)
                if trial is not None and trial.chi2 < state.chi2:
                    found = trial
                    break
                damping *= 8.0
            gain = 0.0 if found is None else state.chi2 - found.chi2
            state = found or state
            damping = max(damping * 0.2, 1e-9)
            age += 1
            done = gain < tolerance * state.chi2
            # what is only searched with is judged by another fit anyway
            if done and (frozen is not None or age == 1 or not self.fine):
                break
            far = not start.terms and gain > MOVED * state.chi2
            if frozen is None and (done or far or age == FRESH):
                background, age = task.background(state), 0
                damping = min(damping, 1e-3)
        k, b = task.k, task.b
        inverse = np.linalg.pinv(hessian) if task.size else np.zeros((0, 0))
        return Fit(
            task.terms(state.values), state.nuisance, state.shift, state.chi2,
            int(sum(e.size for e in state.errors)), np.asarray(inverse[:k, :k], dtype=float),
            np.asarray(inverse[k : k + b, k : k + b], dtype=float), task.volume(hessian),
            np.asarray(inverse[:k, k : k + b], dtype=float),
        )  # fmt: skip


@dataclass(frozen=True)
class _State:
    values: Array
    nuisance: Array
    shift: Array
    errors: tuple[Array, ...]
    prior: float

    @property
    def chi2(self) -> float:
        with np.errstate(over="ignore", invalid="ignore"):  # a trial that has run away
            total = float(sum(np.dot(e, e) for e in self.errors)) + self.prior
        return total if np.isfinite(total) else np.inf


class _Task:
    """What moves in a fit, and its normal equations."""

    def __init__(
        self,
        fitter: Fitter,
        terms: Sequence[ActiveEffect],
        use: tuple[int, ...],
        free: int | None,
        calibrate: bool,
    ) -> None:
        self.fitter = fitter
        self.given = tuple(terms)
        self.use = use
        first = 0 if free is None else len(terms) - free
        self.layout = [
            (i, j) for i in range(first, len(terms)) for j in range(len(terms[i].values))
        ]
        runs = fitter.problem.runs
        self.parameters = [terms[i].bounded(j, runs) for i, j in self.layout]
        self.places = [terms[i].run_of(j) for i, j in self.layout]
        self.edges = [c for c, (i, j) in enumerate(self.layout) if terms[i].is_edge(j)]
        self.k = len(self.layout)
        self.beliefs = fitter.problem.beliefs
        self.b = len(self.beliefs) if calibrate else 0
        self.typical = [i for i, b in enumerate(self.beliefs.items) if b.kind == "typical"]
        self.n = NUISANCES if fitter.problem.free_start else 0
        self.size = self.k + self.b + self.n * len(use)

    def volume(self, hessian: Array) -> float:
        """Logarithm of the determinant of the information about values and beliefs."""
        common = self.k + self.b
        if not common:
            return 0.0
        own, rest = hessian[:common, :common], hessian[common:, common:]
        cross = hessian[:common, common:]
        if rest.size:
            own = own - cross @ np.linalg.lstsq(rest, cross.T, rcond=None)[0]
        values = np.linalg.eigvalsh(0.5 * (own + own.T))
        return float(np.sum(np.log(np.maximum(values, 1e-12))))

    def terms(self, values: Array) -> tuple[ActiveEffect, ...]:
        new = [list(t.values) for t in self.given]
        for (i, j), x in zip(self.layout, values, strict=True):
            new[i][j] = float(x)
        return tuple(
            ActiveEffect(t.effect, tuple(w), t.window_runs)
            for t, w in zip(self.given, new, strict=True)
        )

    def state(self, values: Array, nuisance: Array, shift: Array) -> _State:
        built = self.terms(values)
        found = self.fitter.evaluate_all([Trial(r, built, nuisance[r], shift) for r in self.use])
        off = self.beliefs.misfit(shift)
        with np.errstate(over="ignore", invalid="ignore"):  # a step to nowhere
            prior = float(np.dot(off, off))
        return _State(values, nuisance, shift, tuple(found), prior)

    def first(self, start: Fit) -> _State:
        values = self.inside([self.given[i].values[j] for i, j in self.layout])
        return self.state(values, start.nuisance.copy(), start.shift.copy())

    def inside(self, values: Iterable[float]) -> Array:
        """Values of the effects inside their bounds."""
        return np.array(
            [min(max(x, p.low), p.high) for x, p in zip(values, self.parameters, strict=True)]
        )

    def moved(self, state: _State, position: int) -> tuple[list[Trial], list[tuple[int, float]]]:
        """Trials for the derivatives of one run; place and step of each value."""
        r = self.use[position]
        trials: list[Trial] = []
        steps: list[tuple[int, float]] = []
        for c in range(self.k):
            if self.places[c] not in (None, r):
                continue
            step = _step(self.parameters[c], state.values[c], edge=c in self.edges)
            v = state.values.copy()
            v[c] += step
            trials.append(Trial(r, self.terms(v), state.nuisance[r], state.shift))
            steps.append((c, step))
        return trials, steps

    def background(self, state: _State) -> Background:
        """Derivatives to all but the values."""
        fit = Fit(self.terms(state.values), state.nuisance, state.shift)
        return self.fitter.backgrounds(fit, self.use, state.errors)

    def normal(self, state: _State, background: Background) -> tuple[Array, Array]:
        """J'J and J'e over all runs, with the priors of the beliefs."""
        hessian = np.zeros((self.size, self.size))
        gradient = np.zeros(self.size)
        k, common = self.k, self.k + self.b
        skipped = len(self.beliefs) - self.b
        asked = [self.moved(state, position) for position in range(len(self.use))]
        found = self.fitter.evaluate_all([trial for trials, _ in asked for trial in trials])
        first = 0
        for position, (trials, steps) in enumerate(asked):
            base = state.errors[position]
            columns = np.zeros((base.size, k))
            for (c, step), e in zip(steps, found[first : first + len(trials)], strict=True):
                columns[:, c] = slope(e, base, step)
            first += len(trials)
            at = common + position * self.n
            rest = np.r_[k:common, at : at + self.n]
            other, gram = background[self.use[position]]
            hessian[:k, :k] += columns.T @ columns
            cross = (columns.T @ other)[:, skipped:]
            hessian[np.ix_(range(k), rest)] += cross
            hessian[np.ix_(rest, range(k))] += cross.T
            hessian[np.ix_(rest, rest)] += gram[skipped:, skipped:]
            gradient[:k] += columns.T @ base
            gradient[rest] += (other.T @ base)[skipped:]
        if self.b:
            hessian[k:common, k:common] += self.beliefs.weight
            gradient[k:common] += self.beliefs.pull(state.shift)
        hessian += np.diag(np.where(np.diag(hessian) < 1e-9, 1e-6, 0.0))
        return hessian, gradient

    def move(self, state: _State, hessian: Array, gradient: Array, damping: float) -> _State | None:
        """State after a damped step inside the bounds.

        A typical value moves by `FARTHEST` at most: it alone is held back, or the whole step is
        made shorter, whichever ends lower.
        """
        try:
            damped = hessian + damping * np.diag(np.diag(hessian))
            step = np.asarray(-np.linalg.solve(damped, gradient), dtype=float)
        except np.linalg.LinAlgError:
            return None
        step[self.edges] = np.clip(step[self.edges], -EDGE_STEP_S, EDGE_STEP_S)
        typical = [self.k + i for i in self.typical] if self.b else []
        longest = float(np.max(np.abs(step[typical]), initial=0.0))
        if longest <= FARTHEST:
            return self._stepped(state, step)
        held = step.copy()
        held[typical] = np.clip(step[typical], -FARTHEST, FARTHEST)
        shorter = step * (FARTHEST / longest)
        return min(self._stepped(state, held), self._stepped(state, shorter), key=lambda s: s.chi2)

    def _stepped(self, state: _State, step: Array) -> _State:
        """State after a step, the values of effects inside their bounds."""
        values = self.inside(state.values + step[: self.k])
        shift = state.shift.copy()
        if self.b:
            shift += step[self.k : self.k + self.b]
        nuisance = state.nuisance.copy()
        for position, r in enumerate(self.use):
            at = self.k + self.b + position * self.n
            nuisance[r, : self.n] += step[at : at + self.n]
        return self.state(values, nuisance, shift)


def _step(parameter: Parameter, value: float, *, edge: bool) -> float:
    """Change of a value for its derivative; an edge of a window crosses samples."""
    step = (_EDGE_STEP if edge else _VALUE_STEP) * float(parameter.scale)
    return step if value + step <= parameter.high else -step
