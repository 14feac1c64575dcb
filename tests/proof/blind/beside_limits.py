"""Limits of effects beside the user's own simulation, on the plant that made both.

The simulation is exact but for the effect. So nothing of the vehicle has a tolerance, sensors have
theirs; what an effect changes, and what another would, are differences of two drives of the MuJoCo
plant. Effects below `NAMEABLE` are not compared with others: that can only take more away.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import beside_score
import drives
import effects
import generate
import numpy as np
import recorder
from effects import Draw
from generate import Case
from information import BLOCK_NOISE, NAMEABLE, Array, Limit, Wrong, limit_of, with_prior

from swaywatch.diagnose.fit.beliefs import SENSOR
from swaywatch.models.multibody import Motion

Json = dict[str, Any]
INPUTS = ("SteeringWheelAngle", "SteeringWheelRate", "VehicleSpeed")
#: The drive, which is not compared.
NOT_COMPARED = (*INPUTS, "HitchFx")
RUNS = ("run1", "run2")
BLOCK_S = 0.1
#: Strength of wrong effects: between hardly seen and plain.
TYPICAL = 0.5
#: Draws after which every place of an effect has come up.
DRAWS = 40
VALUE_OFF = 0.02


class Seen:
    """Channels of both runs of a case, with whatever is concealed in it."""

    def __init__(self, case: Case, answer: Json) -> None:
        self.case = case
        self.mean = {run: float(answer[run]["v_kmh"]) / 3.6 for run in RUNS}
        plant = case.plant()
        for run in RUNS:  # as far as the steering was turned down
            generate.drive(case, plant, run, self.mean[run], healthy=False)
        self.noise: Array = np.zeros(0)
        self.healthy = self._motions([])
        self.base = self.signals([])

    def _motions(self, draws: list[Draw]) -> dict[str, Motion]:
        case = replace(self.case, draws=draws)
        plant = case.plant()
        size = self.case.seeds
        return {
            run: plant.run(case.inputs(run, self.mean[run], size[f"size_{run}"], healthy=False))
            for run in RUNS
        }

    def signals(self, draws: list[Draw]) -> list[Array]:
        """Means over blocks of every compared channel of each run, over their noise."""
        moving = any(_moves(draw) for draw in draws)
        motions = self._motions(draws) if moving else self.healthy
        case = replace(self.case, draws=draws)
        return [self._blocks(case, run, motion) for run, motion in motions.items()]

    def _blocks(self, case: Case, run: str, motion: Motion) -> Array:
        truth = generate.bus_signals(motion, case, run, healthy=False)
        truth = generate.sensed(truth, motion.time_s, case.sensors())
        names = [n for n in truth if n not in (*NOT_COMPARED, *case.hidden)]
        each = round(BLOCK_S / float(motion.time_s[1] - motion.time_s[0]))
        rows = motion.time_s.size // each * each
        table = np.stack([truth[n][:rows].reshape(-1, each).mean(axis=1) for n in names], axis=1)
        noise = np.array([recorder.NOISE_RMS[n] for n in names])
        return np.asarray(table / (noise * case.noise_factor * BLOCK_NOISE))

    def change(self, draws: list[Draw], without: list[Draw]) -> Array:
        """What some effects make of the channels beside some of them, without offsets, flat."""
        after = self.signals(draws)
        before = self.signals(without) if without else self.base
        parts = [a - b for a, b in zip(after, before, strict=True)]
        return np.concatenate([(part - part.mean(axis=0)).ravel() for part in parts])

    def sensors(self) -> tuple[Array, Array]:
        """Derivatives to gain and delay of every channel, in tolerances, shape (n, channels)."""
        found: list[list[Array]] = [[], []]
        for table in self.base:
            slope = -np.gradient(table, BLOCK_S, axis=0) * SENSOR["delay_s"][0]
            for kind, part in enumerate((table * SENSOR["gain"][0], slope)):
                each = part - part.mean(axis=0)
                count = each.shape[1]
                diagonal = each[:, :, np.newaxis] * np.eye(count)
                found[kind].append(diagonal.reshape(-1, count))
        return np.vstack(found[0]), np.vstack(found[1])


def _moves(draw: Draw) -> bool:
    """Whether it does anything but change what a sensor shows."""
    if draw.user:
        return False
    return not draw.sensors or bool(draw.inputs("run1", drives.times(1.0)))


def wrong_draws(case: Case) -> Iterator[tuple[str, list[Draw]]]:
    """Other effects at every place, by name; in windows where a concealed one has windows."""
    true = {_place(draw) for draw in case.draws}
    windows = next((draw.windows for draw in case.draws if draw.windows), None)
    found: dict[str, list[Draw]] = {}
    for function in dict.fromkeys((*effects.WITH_SIMULATION, effects.parameter_error)):
        for seed in range(DRAWS):
            draw: Draw = function(np.random.default_rng(seed), TYPICAL)
            name = _place(draw, form=True)
            if true & _alike(draw) or (draw.windows and windows is None):
                continue
            # air has two coefficients: two draws of it span both
            most = 2 if draw.answer["id"] == "trailer_aerodynamics" else 1
            if len(found.setdefault(name, [])) >= most:
                continue
            if windows is not None:
                for run, own in draw.windows.items():
                    own[:] = windows[run]
            if draw.user:
                (key,) = draw.user
                draw = _value(key)
            found[name].append(draw)
    yield from found.items()


def _value(key: str) -> Draw:
    """A simulation with another value of the vehicle."""
    return Draw(
        {"id": "parameter_error", "parameter": key},
        key,
        combination=lambda whole: drives.believed(whole, {key: 1.0 - VALUE_OFF}),
    )


def _place(draw: Draw, *, form: bool = False) -> str:
    """Id and where it is; also in which form."""
    answer = draw.answer
    keys = ("axle", "body", "channel", "parameter", *(("side", "law", "sensing") if form else ()))
    return ":".join([answer["id"], *(str(answer[key]) for key in keys if key in answer)])


def _alike(draw: Draw) -> set[str]:
    """Its place, and that of another kind of damper, which is a fade or an asymmetry."""
    answer = draw.answer
    dampers = answer["id"] in beside_score.SAME["damper_kind"]
    return {_place(draw), *([f"damper_kind:{answer['axle']}"] if dampers else [])}


def limits(case: Case, answer: Json) -> list[Limit]:
    """Limit of each of the concealed effects, the others known but for their size."""
    seen = Seen(case, answer)
    gains, delays = seen.sensors()
    sensors = np.hstack([gains, delays])
    prior = np.eye(sensors.shape[1])
    rows = len(prior)

    def row(change: Array) -> Array:
        return np.concatenate([change, np.zeros(rows)])

    changes = []
    for draw in case.draws:
        rest = [other for other in case.draws if other is not draw]
        changes.append(row(seen.change(case.draws, rest)))
    below = with_prior(sensors, prior)
    nuisances = []
    for number in range(len(changes)):
        beside = [other[:, np.newaxis] for k, other in enumerate(changes) if k != number]
        nuisances.append(np.hstack([below, *beside]))
    alone = [limit_of(c, n, []) for c, n in zip(changes, nuisances, strict=True)]
    if max(own.detect for own in alone) < NAMEABLE:
        return alone
    wrong = _wrong(seen, row)
    return [limit_of(c, n, wrong) for c, n in zip(changes, nuisances, strict=True)]


def _wrong(seen: Seen, row: Any) -> list[Wrong]:
    found = []
    for name, draws in wrong_draws(seen.case):
        try:
            columns = [row(seen.change([draw], [])) for draw in draws]
        except FloatingPointError:  # with it the combination turns over
            continue
        found.append(Wrong(name, np.stack(columns, axis=1)))
    return found
