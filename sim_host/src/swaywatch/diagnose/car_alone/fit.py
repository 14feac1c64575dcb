"""Fit of a car alone: simulate every part from its steering and speed, compare, refit."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from swaywatch.diagnose.car_alone.car import SLOTS, CarInput, simulate_all
from swaywatch.diagnose.car_alone.data import SMOOTH_HZ, CarData, Part
from swaywatch.diagnose.car_alone.effects import ACC, STEER, YAW, CarEffect, Number, Outputs
from swaywatch.effects.runs import BLOCK, RATE_HZ, block_mean, low_pass

Array = NDArray[np.float64]

START_S = 1.0  # of each part, not compared: the start values settle
MODEL_SHARE = 0.03  # of a channel's RMS: what no single-track model of a real car is better than
_STIFFNESS = ("front_cornering_stiffness", "rear_cornering_stiffness")


@dataclass(frozen=True)
class CarModel:
    """A model: explanations with values, stiffnesses, steering offset of each run.

    Attributes
    ----------
    values
        By ``effect name / number``; and the stiffnesses by their names, where they are fitted.
    steering_offset
        Run to road-wheel angle, rad.
    chi2, count
        Sum of squared residuals over their scales, and their number.
    """

    effects: tuple[CarEffect, ...]
    values: dict[str, float]
    steering_offset: dict[int, float]
    chi2: float = np.inf
    count: int = 0
    errors: dict[str, float] = field(default_factory=dict)

    @property
    def mean_square(self) -> float:
        """Mean squared residual over its scale."""
        return self.chi2 / max(self.count, 1)

    def of(self, effect: CarEffect) -> dict[str, float]:
        """Values of one effect by the names of its numbers."""
        return {n.name: self.values[f"{effect.name}/{n.name}"] for n in effect.numbers}


class CarFitter:
    """Everything that is needed to evaluate models of one set of runs."""

    def __init__(self, data: CarData) -> None:
        self.data = data
        car = data.vehicle.car
        self.constants = {
            "mass": car.mass, "yaw_inertia": car.yaw_inertia,
            "front_axle_to_cog": car.front_axle_to_cog, "rear_axle_to_cog": car.rear_axle_to_cog,
        }  # fmt: skip
        self.given = {n: float(v) for n in _STIFFNESS if (v := getattr(car, n)) is not None}
        # start of the fit: 10 and 16 times the axle load, a car that understeers
        load = car.mass * 9.81 / (car.front_axle_to_cog + car.rear_axle_to_cog)
        starts = (10.0 * load * car.rear_axle_to_cog, 16.0 * load * car.front_axle_to_cog)
        self.fitted = [
            Number(n, "N/rad", at, 0.05 * at, 20.0 * at, at)
            for n, at in zip(_STIFFNESS, starts, strict=True) if n not in self.given
        ]  # fmt: skip
        self.inputs = [self._inputs(run) for run in range(len(data.runs))]
        self.scales = self._scales()
        self._states: dict[tuple[Part, Hashable], Outputs] = {}

    def _inputs(self, run: int) -> tuple[Array, Array, Array]:
        channels = self.data.runs[run].channels
        speed = low_pass(channels["speed"], 1.0, order=2)
        steer = low_pass(channels[STEER], SMOOTH_HZ) / self.data.vehicle.car.steering_ratio
        return speed, np.gradient(speed) * RATE_HZ, steer

    def _scales(self) -> dict[str, float]:
        found = {}
        for name in self.data.channels:
            values = [self.data.runs[p.run].channels[name][p.where] for p in self.data.parts]
            spread = float(np.sqrt(np.mean([np.var(v) for v in values])))
            noise = max(self.data.runs[p.run].noise[name] for p in self.data.parts)
            found[name] = float(np.hypot(noise / np.sqrt(BLOCK), MODEL_SHARE * spread))
        return found

    def start(self, effects: Sequence[CarEffect] = ()) -> CarModel:
        """Model before any fit."""
        values = {n.name: n.start for n in self.fitted}
        for effect in effects:
            values |= {f"{effect.name}/{n.name}": n.start for n in effect.numbers}
        return CarModel(tuple(effects), values, dict.fromkeys(range(len(self.data.runs)), 0.0))

    def _key(self, model: CarModel, part: Part) -> Hashable:
        """What the motion in a part depends on; sensors do not change it."""
        return (
            tuple((e.name, *model.of(e).values()) for e in model.effects if e.moves),
            tuple(model.values[n.name] for n in self.fitted),
            model.steering_offset.get(part.run, 0.0),
        )

    def _car(self, model: CarModel, part: Part) -> CarInput:
        """The car in one part."""
        run = self.data.runs[part.run]
        speed, acceleration, steer = (x[part.where] for x in self.inputs[part.run])
        slots = SLOTS | self.constants | self.given
        slots |= {n.name: model.values[n.name] for n in self.fitted}
        first = float(run.channels[YAW][part.start]) if YAW in run.channels else 0.0
        car = CarInput(
            1.0 / RATE_HZ, speed, acceleration, steer + model.steering_offset.get(part.run, 0.0),
            np.zeros(speed.size), slots, (0.0, first), part.run,
            self.data.vehicle.car.steering_ratio,
        )  # fmt: skip
        for effect in model.effects:
            if effect.moves:
                effect.act(car, run.time[part.where], model.of(effect))
        return car

    def prepare(self, asked: Sequence[tuple[CarModel, Part]]) -> None:
        """Simulate side by side what will be asked for next, and forget what was before."""
        before, self._states = self._states, {}
        missing: dict[tuple[Part, Hashable], CarInput] = {}
        for model, part in asked:
            key = (part, self._key(model, part))
            if key in before:
                self._states[key] = before[key]
            elif key not in missing:
                missing[key] = self._car(model, part)
        found = simulate_all(list(missing.values()))
        self._states |= dict(zip(missing, found, strict=True))

    def _state(self, model: CarModel, part: Part) -> Outputs:
        """Motion in one part."""
        key = (part, self._key(model, part))
        if key not in self._states:
            self._states[key] = simulate_all([self._car(model, part)])[0]
        return self._states[key]

    def outputs(self, model: CarModel, part: Part) -> Outputs:
        """Channels of one part as the model has them, and the state: shape (n,) each."""
        run = self.data.runs[part.run]
        time = run.time[part.where]
        state = self._state(model, part)
        result = {
            YAW: state["yaw_rate"], "true_yaw_rate": state["yaw_rate"],
            ACC: state["acceleration"] + run.position_m * state["yaw_acceleration"],
            "lateral_velocity": state["lateral_velocity"],
        }  # fmt: skip
        for effect in model.effects:
            effect.observe(result, time, model.of(effect))
        return result

    def residual(self, model: CarModel, part: Part) -> Array:
        """Over their scales, without their means, 10 Hz, flat."""
        outputs = self.outputs(model, part)
        skip = int(START_S * RATE_HZ)
        rows = []
        for name in self.data.channels:
            measured = self.data.runs[part.run].channels[name][part.where]
            e = block_mean(measured[skip:] - outputs[name][skip:])
            rows.append((e - e.mean()) / self.scales[name])
        return np.concatenate(rows)

    def _numbers_of(self, effect: CarEffect, parts: Sequence[Part]) -> list[Number]:
        """Numbers that these parts determine: of a banked road only where it was driven on."""
        if not effect.windows:
            return list(effect.numbers)
        spans = [
            (p.run, self.data.runs[p.run].time[p.start], self.data.runs[p.run].time[p.stop - 1])
            for p in parts
        ]
        return [
            number
            for number, (run, start, stop) in zip(effect.numbers, effect.windows, strict=True)
            if any(r == run and a < stop and b > start for r, a, b in spans)
        ]

    def fit(
        self, model: CarModel, parts: Sequence[Part], *, free: bool = True, steps: int = 12
    ) -> CarModel:
        """Best values on the given parts, in at most `steps` steps; not `free`: offsets only."""
        names, low, high, at, unit, known = [], [], [], [], [], []
        moves: list[bool] = []
        if free:
            numbers = [(n.name, n, True) for n in self.fitted]
            numbers += [
                (f"{e.name}/{n.name}", n, e.moves)
                for e in model.effects
                for n in self._numbers_of(e, parts)
            ]
            # what no part determines stays as it is: a fit would only carry it off
            for key, n, acts in numbers:
                moves.append(acts)
                names.append(key)
                low.append(n.low)
                high.append(n.high)
                at.append(min(max(model.values[key], n.low), n.high))
                unit.append(max(abs(n.start), 0.02 * (n.high - n.low), 1e-6))
                known.append(n.known)
        runs = sorted({p.run for p in parts})
        k = len(names)
        low += [-0.1] * len(runs)
        high += [0.1] * len(runs)
        at += [model.steering_offset.get(r, 0.0) for r in runs]
        unit += [0.01] * len(runs)

        def build(x: Array) -> CarModel:
            values = model.values | {n: float(v) for n, v in zip(names, x[:k], strict=True)}
            offsets = model.steering_offset | {
                r: float(v) for r, v in zip(runs, x[k:], strict=True)
            }
            return CarModel(model.effects, values, offsets)

        def rest(x: Array, part: Part) -> Array:
            e = self.residual(build(x), part)
            return np.asarray(np.nan_to_num(e, nan=1e3, posinf=1e3, neginf=-1e3))

        def cost(x: Array) -> Array:
            # what is known of a number weighs like a few seconds of data
            self.prepare([(build(x), part) for part in parts])
            prior = [10.0 * (v - b[0]) / b[1] for v, b in zip(x[:k], known, strict=True) if b]
            return np.concatenate([*(rest(x, p) for p in parts), prior])

        def jacobian(x: Array) -> Array:
            """By differences; what only the sensors show first, while the motion is at hand."""
            columns = []
            order = sorted(range(len(x)), key=lambda c: c >= k or moves[c])
            steps = [_step(x[c], low[c], high[c]) for c in range(len(x))]
            for part in parts:
                affected = [c for c in order if c < k or runs[c - k] == part.run]
                moved = {c: x + steps[c] * (np.arange(len(x)) == c) for c in affected}
                self.prepare([(build(at), part) for at in (x, *moved.values())])
                base = rest(x, part)
                block = np.zeros((base.size, len(x)))
                for c in affected:
                    block[:, c] = (rest(moved[c], part) - base) / steps[c]
                columns.append(block)
            sure = np.diag([10.0 / b[1] if b else 0.0 for b in known] + [0.0] * len(runs))
            columns.append(sure[[i for i, b in enumerate(known) if b]])
            return np.concatenate(columns)

        inside = np.clip(at, np.array(low) + 1e-9, np.array(high) - 1e-9)
        found = least_squares(
            cost, inside, jac=jacobian, bounds=(low, high), x_scale=unit, max_nfev=steps,
            ftol=1e-3, xtol=1e-5,
        )  # fmt: skip
        best = build(found.x)
        rows = np.concatenate([self.residual(best, p) for p in parts])
        # residuals at 10 Hz hang together: about a second of them is one independent observation
        share = float(rows @ rows) / rows.size * RATE_HZ / BLOCK
        slopes = np.asarray(found.jac)
        variance = np.abs(np.diag(np.linalg.pinv(slopes.T @ slopes))) * share
        errors = dict(zip(names, np.sqrt(variance[:k]).tolist(), strict=True))
        return CarModel(
            best.effects, best.values, best.steering_offset, float(rows @ rows), rows.size, errors
        )

    def nrmse(self, model: CarModel, parts: Sequence[Part]) -> dict[str, float]:
        """RMS error of each channel over its standard deviation, offsets off, and their mean."""
        skip = int(START_S * RATE_HZ)
        found = {}
        outputs = [self.outputs(model, p) for p in parts]
        for name in self.data.channels:
            wrong = spread = 0.0
            for part, out in zip(parts, outputs, strict=True):
                measured = block_mean(self.data.runs[part.run].channels[name][part.where][skip:])
                e = measured - block_mean(out[name][skip:])
                wrong += float(np.sum((e - e.mean()) ** 2))
                spread += float(np.sum((measured - measured.mean()) ** 2))
            found[name] = float(np.sqrt(wrong / (spread + 1e-12)))
        found["all"] = float(np.sqrt(np.mean(np.square(list(found.values())))))
        return found

    def held_out(self, model: CarModel) -> list[tuple[int, CarModel, dict[str, float]]]:
        """Each fold predicted by what the others taught; its steering offset is its own."""
        found = []
        for fold in sorted({p.fold for p in self.data.parts}):
            ours = [p for p in self.data.parts if p.fold == fold]
            others = [p for p in self.data.parts if p.fold != fold]
            if not others:
                continue
            taught = self.fit(model, others, steps=4)
            taught = self.fit(taught, ours, free=False, steps=4)
            found.append((fold, taught, self.nrmse(taught, ours)))
        return found


def _step(value: float, low: float, high: float) -> float:
    """Step of a derivative: a thousandth of the value, towards the inside of its bounds."""
    step = 1e-3 * value if abs(value) > 1e-9 else 1e-8
    return step if low <= value + step <= high else -step
