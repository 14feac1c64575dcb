"""Limits of effects beside our own model, on the package's plant at the true vehicle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import explanations
import numpy as np
import recorder
from explanations import AtStrength
from information import BLOCK_NOISE, Array, Limit, Wrong, limit_of, with_prior

from swaywatch.diagnose.fit.beliefs import Belief, beliefs_of
from swaywatch.diagnose.fit.data import body_of, run_of
from swaywatch.diagnose.fit.fit import COMPARED, NUISANCES, Fit, Fitter, Problem, Trial
from swaywatch.diagnose.fit.load_balance import weighed
from swaywatch.diagnose.fit.road_vehicle import on_springs, outside
from swaywatch.drive import load_drives
from swaywatch.effects.effect import library
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import BODY
from swaywatch.vehicle import Vehicle

Json = dict[str, Any]
#: Share of an effect that is taken away for its derivative.
STEP = 0.1
_RMS = {name: recorder.NOISE_RMS[signal] for signal, name in explanations.CHANNELS.items()}
_WHEEL = {"lateral": recorder.NOISE_RMS["FyFL"], "vertical": recorder.NOISE_RMS["FzFL"]}


def noise(channel: str) -> float:
    """RMS of the noise of a channel, SI."""
    if "wheel" in channel:
        return _WHEEL["vertical" if "vertical" in channel else "lateral"]
    size = _RMS.get(channel, recorder.NOISE_RMS["HitchFz"])
    return float(np.radians(size)) if channel.endswith("yaw_rate") else size


def runs_of(folder: Path, vehicle: Vehicle, noise_factor: float) -> tuple[Run, ...]:
    """Inputs and channels of the two runs of a case, with the noise as it was made."""
    found = []
    for name in ("run1", "run2"):
        (file,) = folder.glob(f"{name}.*")
        (drive,) = load_drives([file], folder / "signals.toml")
        run = run_of(drive, vehicle.car.steering_ratio, name).prepare()
        run.scales = {
            channel: noise(channel) * noise_factor * BLOCK_NOISE
            for channel in COMPARED
            if channel in run.channels
        }
        found.append(run)
    return tuple(found)


@dataclass(frozen=True)
class Known:
    """What the user of a case knows.

    Attributes
    ----------
    exact
        The vehicle's file is right and its user knows that: its values have no tolerance.
    sensors
        Sensors have tolerances too.
    slots
        Of the plant, as they truly are.
    springs
        The vehicle is on springs.
    """

    exact: bool
    slots: Mapping[str, float]
    springs: bool
    sensors: bool = True

    def has_tolerance(self, belief: Belief) -> bool:
        """Tell whether a value may move."""
        if belief.kind == "vehicle":
            return not self.exact
        return self.sensors or belief.kind == "typical"


@dataclass(frozen=True)
class Concealed:
    """What is concealed: an effect at a share of its strength, or by how much the file is wrong.

    Attributes
    ----------
    effect
        None: the file is wrong.
    wrong
        True less believed of values of the file, as `beliefs.moved` takes it, by name.
    """

    effect: AtStrength | None
    wrong: Mapping[str, float]


def problem_of(runs: tuple[Run, ...], true: Vehicle, known: Known) -> Problem:
    """The runs with the true vehicle, and the tolerances that the diagnosis states by itself."""
    body = body_of(true)
    problem = Problem(runs, body)
    beliefs = weighed(beliefs_of(body, problem.channels(runs[0])), body, true).beliefs
    problem = replace(problem, beliefs=beliefs)
    if not known.springs:
        return replace(problem, given=tuple(known.slots.items()))
    problem = on_springs(problem)
    given = tuple((name, known.slots.get(name, value)) for name, value in problem.given)
    return replace(problem, given=given)


def wrong_values(true: Vehicle, believed: Vehicle) -> dict[str, float]:
    """By how much the true values are above those of a file, by name."""
    found = {}
    for name, right, said in zip(BODY, body_of(true), body_of(believed), strict=True):
        if name.endswith("_to_cog"):
            found[name] = float(right - said)
        elif said > 0.0:
            found[name] = float(right / said - 1.0)
    found["car.steering_ratio"] = true.car.steering_ratio / believed.car.steering_ratio - 1.0
    return {name: off for name, off in found.items() if abs(off) > 1e-4}


class _Point:
    """Channels at the truth and their derivatives, rows of the priors below."""

    def __init__(self, problem: Problem, known: Known, concealed: Sequence[Concealed]) -> None:
        self.problem, self.known = problem, known
        self.effects = [c.effect for c in concealed if c.effect is not None]
        self.fitter = Fitter(problem)
        self.count = len(problem.runs)
        self.terms = tuple(effect(1.0) for effect in self.effects)
        self.rest = np.zeros((self.count, NUISANCES))
        self.shift = problem.at_rest()
        (self.base,) = self.channels([self.terms])
        if not np.all(np.isfinite(self.base)):
            raise FloatingPointError("the true combination runs away on the package's plant")
        beliefs = problem.beliefs
        self.kept = [i for i, b in enumerate(beliefs.items) if known.has_tolerance(b)]
        self.slopes, self.nuisance = self._nuisance()
        # rows of the beliefs themselves, then of the axle loads that bind them
        self.loads = beliefs.roots[len(beliefs) :]

    def channels(self, sets: Sequence[tuple[Any, ...]]) -> list[Array]:
        """Normalised residuals of all runs, for several sets of effects."""
        trials = [
            Trial(run, terms, self.rest[run], self.shift)
            for terms in sets
            for run in range(self.count)
        ]
        found = self.fitter.evaluate_all(trials)
        return [
            np.concatenate(found[at : at + self.count]) for at in range(0, len(found), self.count)
        ]

    def _nuisance(self) -> tuple[Array, Array]:
        """Derivatives to all beliefs; and to those with a tolerance and what is free, as rows."""
        beliefs = self.problem.beliefs
        runs = range(self.count)
        found = self.fitter.backgrounds(Fit(self.terms, self.rest, self.shift), runs)
        size = len(beliefs)
        slopes = np.vstack([found[run][0][:, :size] for run in runs])
        free = np.zeros((slopes.shape[0], NUISANCES * self.count))
        at = 0
        for run in runs:
            own = found[run][0][:, size:]
            free[at : at + len(own), NUISANCES * run : NUISANCES * (run + 1)] = own
            at += len(own)
        prior = beliefs.roots[:, self.kept]
        return slopes, with_prior(np.hstack([slopes[:, self.kept], free]), prior)

    def rows(self, change: Array, loads: Array | None = None) -> Array:
        """A direction of the channels with rows for the priors; `loads`: what these say of it."""
        below = np.zeros(len(self.problem.beliefs))
        loads = np.zeros(len(self.loads)) if loads is None else loads
        return np.concatenate([change, below, loads])

    def of_value(self, index: int) -> Array:
        """Direction of a value of the file that is wrong: axle loads speak against it too."""
        return self.rows(self.slopes[:, index], self.loads[:, index])

    def change(self, concealed: Concealed) -> Array:
        """What a concealed effect makes of channels and priors."""
        if concealed.effect is not None:
            weaker = [e(1.0 - STEP if e is concealed.effect else 1.0) for e in self.effects]
            (found,) = self.channels([tuple(weaker)])
            return self.rows((found - self.base) / STEP)
        total = self.rows(np.zeros(self.base.size))
        for name, off in concealed.wrong.items():
            index = self.problem.beliefs.at["vehicle", name]
            total += off / self.problem.beliefs.items[index].tolerance * self.of_value(index)
        return total

    def wrong(self, concealed: Sequence[Concealed]) -> list[Wrong]:
        """All other explanations."""
        effects = outside(library()) if self.known.springs else library()
        channels = self.problem.channels(self.problem.runs[0])
        found = explanations.others(effects, self.terms, channels)
        flat = [(name, effect) for name, some in found.items() for effect in some]
        moved = self.channels([(*self.terms, effect) for _, effect in flat])
        directions: dict[str, list[Array]] = {name: [] for name in found}
        for (name, _), own in zip(flat, moved, strict=True):
            directions[name].append(self.rows(own - self.base))
        wrong = [Wrong(name, np.stack(some, axis=1)) for name, some in directions.items() if some]
        true = {name for c in concealed for name in c.wrong}
        for index, belief in enumerate(self.problem.beliefs.items):
            is_value = belief.kind == "vehicle" and not belief.name.endswith(".cog")
            if is_value and belief.name not in true:
                direction = self.of_value(index)[:, np.newaxis]
                wrong.append(Wrong(f"parameter_error:{belief.name}", direction))
        return wrong


def limits(problem: Problem, known: Known, concealed: Sequence[Concealed]) -> list[Limit]:
    """Limit of each of the concealed effects, the others known but for their size."""
    point = _Point(problem, known, concealed)
    changes = [point.change(own) for own in concealed]
    wrong = point.wrong(concealed)
    found = []
    for number, change in enumerate(changes):
        beside = [other for k, other in enumerate(changes) if k != number]
        nuisance = np.hstack([point.nuisance, *(other[:, np.newaxis] for other in beside)])
        found.append(limit_of(change, nuisance, wrong))
    return found
