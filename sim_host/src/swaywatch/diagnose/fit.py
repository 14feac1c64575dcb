"""Fit of explanations: simulate, compare with every channel, refit, compare likelihoods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bilinear, lfilter

from swaywatch.diagnose.effect import Parameter
from swaywatch.diagnose.plant import OUTPUT, SCALARS, PlantInput, neutral, simulate
from swaywatch.diagnose.runs import BLOCK, RATE_HZ, Run, block_mean
from swaywatch.diagnose.term import Term

Array = NDArray[np.float64]

_COLUMN = {name: index for index, name in enumerate(OUTPUT)}
_WHEELS = ("fl", "fr", "rl", "rr")
RELATIVE_FLOOR = 0.003  # of a channel's RMS: what no planar model is better than

#: Channels compared with the simulation (the longitudinal force is left out: it is the drive).
COMPARED = (
    "car_yaw_rate", "trailer_yaw_rate", "car_lateral_acceleration",
    "trailer_lateral_acceleration", "articulation", "hitch_lateral_force",
    *(f"wheel_lateral_force_{w}" for w in _WHEELS),
    *(f"wheel_vertical_load_{w}" for w in _WHEELS),
)  # fmt: skip
_NUISANCES = 5  # steering offset and four initial states, for each run
_NUISANCE_STEP = np.array([2e-4, 2e-2, 2e-3, 1e-3, 2e-3])
_SHARED = ("transfer_car_front", "transfer_car_rear")


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
    shared
        Load transfer of the car's axles, N per m/s2.
    chi2
        Sum of squared normalised residuals (20 Hz).
    count
        Number of residuals.
    covariance
        Of the effect values, order of `terms`, shape (k, k).
    """

    terms: tuple[Term, ...]
    nuisance: Array
    shared: Array
    chi2: float = np.inf
    count: int = 0
    covariance: Array = field(default_factory=lambda: np.zeros((0, 0)))


@dataclass(frozen=True)
class Problem:
    """Runs of one combination with the user's constants (order of `plant.BODY`)."""

    runs: tuple[Run, ...]
    body: Array

    def channels(self, run: Run) -> list[str]:
        """Compared channels that the run has."""
        return [name for name in COMPARED if name in run.channels]


def predict_run(
    problem: Problem,
    index: int,
    terms: Sequence[Term],
    nuisance: Array,
    shared: Array,
    *,
    fine: bool = True,
) -> dict[str, Array]:
    """Channels of one run as the model with `terms` has them, shape (n,) each."""
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
    for name, value in zip(_SHARED, shared, strict=True):
        plant.scalar(name, float(value))
    for term in terms:
        term.effect.act(plant, run, term.as_dict(), term.windows(index))
    result = simulate(plant, fine=fine)
    return observe(result, run, terms)


def observe(result: Array, run: Run, terms: Sequence[Term]) -> dict[str, Array]:
    """Sensors: plant outputs (n, len(OUTPUT)) to channels of the recording."""
    col = {name: result[:, index] for name, index in _COLUMN.items()}
    car = run.positions.get("car_lateral_acceleration", 0.0)
    trailer = run.positions.get("trailer_lateral_acceleration", 0.0)
    out = {
        "car_yaw_rate": col["car_yaw_rate"],
        "trailer_yaw_rate": col["trailer_yaw_rate"],
        "articulation": col["articulation"],
        "car_lateral_acceleration": col["car_acceleration"] + car * col["car_yaw_acceleration"],
        "trailer_lateral_acceleration": col["trailer_acceleration"]
        + trailer * col["trailer_yaw_acceleration"],
        "hitch_longitudinal_force": col["hitch_x"],
        "hitch_lateral_force": col["hitch_y"],
        # roll follows the lateral acceleration: see `sensor_roll_gravity`
        "car_roll_acceleration": col["car_roll"] / 0.009,
        "trailer_roll_acceleration": col["trailer_roll"] / 0.009,
    }
    for wheel in _WHEELS:
        out[f"wheel_lateral_force_{wheel}"] = col[f"lateral_{wheel}"]
        out[f"wheel_vertical_load_{wheel}"] = col[f"vertical_{wheel}"]
    for term in terms:
        term.effect.observe(out, run, term.as_dict())
    return out


def scale(run: Run, name: str) -> float:
    """Standard deviation of a 20 Hz residual of a channel."""
    if name not in run.scales:
        floor = RELATIVE_FLOOR * float(np.std(run.channels[name]))
        run.scales[name] = float(np.sqrt(run.noise[name] ** 2 / BLOCK + floor**2))
    return run.scales[name]


def residual(problem: Problem, index: int, outputs: Mapping[str, Array]) -> Array:
    """Normalised residuals of one run without their means, shape (n / 5, channels)."""
    run = problem.runs[index]
    names = problem.channels(run)
    e = block_mean(np.stack([run.channels[name] - outputs[name] for name in names], axis=1))
    return np.asarray((e - e.mean(axis=0)) / np.array([scale(run, name) for name in names]))


def roll_filter(acceleration: Array) -> Array:
    """Acceleration behind the roll of the car's body. Shapes (n,)."""
    scalars = neutral()
    omega = float(scalars[SCALARS.index("roll_frequency_car")])
    damping = float(scalars[SCALARS.index("roll_damping_car")])
    b, a = bilinear([omega**2], [1.0, 2.0 * damping * omega, omega**2], RATE_HZ)
    return np.asarray(lfilter(b, a, acceleration))


class Fitter:
    """Levenberg-Marquardt over effect values, start values and offsets of all runs."""

    def __init__(self, problem: Problem, *, fine: bool = True) -> None:
        self.problem = problem
        self.fine = fine
        self.evaluations = 0

    def evaluate(
        self, index: int, terms: Sequence[Term], nuisance: Array, shared: Array
    ) -> Array:
        """Normalised residuals of one run, flat."""
        self.evaluations += 1
        outputs = predict_run(self.problem, index, terms, nuisance, shared, fine=self.fine)
        return np.asarray(residual(self.problem, index, outputs).ravel())

    def nuisance_columns(self, index: int, fit: Fit, base: Array) -> Array:
        """Derivatives to offset and start values of one run, shape (residuals, 5)."""
        columns = np.zeros((base.size, _NUISANCES))
        for c in range(_NUISANCES):
            nu = fit.nuisance[index].copy()
            nu[c] += _NUISANCE_STEP[c]
            e = self.evaluate(index, fit.terms, nu, fit.shared)
            columns[:, c] = (e - base) / _NUISANCE_STEP[c]
        return columns

    def start(self) -> Fit:
        """Fit without any effect from rest."""
        runs = len(self.problem.runs)
        return Fit((), np.zeros((runs, _NUISANCES)), self._transfer())

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
        shared_free: bool = False,
        frozen: Sequence[Array] | None = None,
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
            Number of terms, counted from the end, whose values move; all by default.
        shared_free
            Also move the load transfer.
        frozen
            Derivatives to the offsets and start values of each run, if they are to be reused.
        """
        use = list(range(len(self.problem.runs))) if runs is None else list(runs)
        terms = list(start.terms)
        first = 0 if free is None else len(terms) - free
        layout = [(i, j) for i in range(first, len(terms)) for j in range(len(terms[i].values))]
        values = np.array([terms[i].values[j] for i, j in layout])
        parameters = [terms[i].parameter(j) for i, j in layout]
        places = [terms[i].run_of(j) for i, j in layout]
        nuisance, shared = start.nuisance.copy(), start.shared.copy()
        damping = 1e-3

        def build(v: Array) -> list[Term]:
            new = [list(t.values) for t in terms]
            for (i, j), x in zip(layout, v, strict=True):
                new[i][j] = float(x)
            return [
                Term(t.effect, tuple(w), t.window_runs) for t, w in zip(terms, new, strict=True)
            ]

        def evaluate(v: Array, nu: Array, sh: Array) -> list[Array]:
            built = build(v)
            return [self.evaluate(r, built, nu[r], sh) for r in use]

        current = evaluate(values, nuisance, shared)
        chi2 = float(sum(np.dot(e, e) for e in current))
        k = len(values)
        s = len(shared) if shared_free else 0
        size = k + s + _NUISANCES * len(use)
        hessian = np.eye(size)
        for _ in range(iterations):
            jtj = np.zeros((size, size))
            jte = np.zeros(size)
            built = build(values)
            for position, r in enumerate(use):
                base = current[position]
                columns = np.zeros((base.size, k + s + _NUISANCES))
                for c in range(k):
                    if places[c] not in (None, r):
                        continue
                    step = _step(parameters[c], values[c])
                    v = values.copy()
                    v[c] += step
                    columns[:, c] = (
                        self.evaluate(r, build(v), nuisance[r], shared) - base
                    ) / step
                for c in range(s):
                    sh = shared.copy()
                    sh[c] += 5.0
                    columns[:, k + c] = (self.evaluate(r, built, nuisance[r], sh) - base) / 5.0
                state = Fit(tuple(built), nuisance, shared)
                columns[:, k + s :] = (
                    self.nuisance_columns(r, state, base) if frozen is None else frozen[r]
                )
                where = np.r_[
                    0 : k + s, k + s + position * _NUISANCES : k + s + (position + 1) * _NUISANCES
                ]
                jtj[np.ix_(where, where)] += columns.T @ columns
                jte[where] += columns.T @ base
            jtj += np.diag(np.where(np.diag(jtj) < 1e-9, 1e-6, 0.0))
            hessian = jtj
            improved = False
            for _ in range(6):
                weight = np.diag(np.maximum(np.diag(jtj), 1e-12)) * damping
                try:
                    move = -np.linalg.solve(jtj + weight, jte)
                except np.linalg.LinAlgError:
                    damping *= 10.0
                    continue
                v = values + move[:k]
                v = np.array(
                    [min(max(x, p.low), p.high) for x, p in zip(v, parameters, strict=True)]
                )
                sh = shared + move[k : k + s] if s else shared
                nu = nuisance.copy()
                for position, r in enumerate(use):
                    at = k + s + position * _NUISANCES
                    nu[r] += move[at : at + _NUISANCES]
                trial = evaluate(v, nu, sh)
                new = float(sum(np.dot(e, e) for e in trial))
                if np.isfinite(new) and new < chi2:
                    improved = True
                    break
                damping *= 8.0
            if not improved:
                break
            gain = chi2 - new
            values, nuisance, shared, current, chi2 = v, nu, sh, trial, new
            damping = max(damping * 0.2, 1e-9)
            if gain < tolerance * chi2:
                break
        covariance = np.linalg.pinv(hessian)[:k, :k] if k else np.zeros((0, 0))
        return Fit(
            tuple(build(values)), nuisance, shared, chi2,
            int(sum(e.size for e in current)), covariance,
        )  # fmt: skip


def _step(parameter: Parameter, value: float) -> float:
    step = 0.2 * float(parameter.scale)
    return step if value + step <= parameter.high else -step
