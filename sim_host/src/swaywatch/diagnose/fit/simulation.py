"""The user's own simulation as the baseline: our plant is only the correction to it.

Our plant is calibrated to the simulation, never to the recording: once without springs (tyres, load
transfer), once on springs (all that `road_vehicle` believes); the one that comes nearer is taken.
What is left between the two is kept per channel and added to every prediction, so that a model with
nothing missing is exactly the user's simulation, and an effect acts as the change that it makes to
the calibrated plant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from swaywatch.cosim import is_fmu
from swaywatch.cosim.fmu import Fmu
from swaywatch.cosim.mapping import wire
from swaywatch.diagnose.fit.beliefs import TYPICAL, Belief, Beliefs
from swaywatch.diagnose.fit.fit import (
    COMPARED,
    OBSERVER,
    Fit,
    Fitter,
    Problem,
    plant_of,
    predict_run,
)
from swaywatch.diagnose.fit.road_vehicle import on_springs
from swaywatch.drive import load_drives, load_signals
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.library.parameter_error import EFFECTS as PARAMETERS
from swaywatch.effects.library.tyre_load_sensitivity import EFFECTS as LOAD
from swaywatch.effects.library.tyre_relaxation import EFFECTS as RELAXATION
from swaywatch.effects.library.tyre_saturation import EFFECTS as SATURATION
from swaywatch.effects.runs import RATE_HZ, Run, low_pass
from swaywatch.errors import RecordingError
from swaywatch.plant.lanes import OUTPUT, SCALARS, neutral, simulate
from swaywatch.validate.fmu_twin import drive_fmu, remarks

Array = NDArray[np.float64]
Pair = tuple[Run, dict[str, Array]]
"""A run and the channels of its simulation on its time."""

TRANSFER = ("transfer_car_front", "transfer_car_rear")
CALIBRATED = (
    "car.front_cornering_stiffness", "car.rear_cornering_stiffness",
    "trailer.front_cornering_stiffness", "trailer.rear_cornering_stiffness",
    "car.yaw_inertia", "trailer.yaw_inertia",
)  # fmt: skip
LARGEST_OFFSET_S = 5.0
NOTABLE_OFFSET_S = 0.015
LEAST_CORRELATION = 0.9


def clock_offset(run: Run, time: Array, steering: Array) -> tuple[float, float]:
    """Seconds the simulation's clock is ahead, and the correlation of the steering there."""
    own = low_pass(run.channels["steering_wheel_angle"], 5.0)
    own = own - own.mean()
    best = (0.0, -1.0)
    coarse = np.arange(-LARGEST_OFFSET_S, LARGEST_OFFSET_S, 0.05)
    for shifts in (coarse, None):
        grid = shifts if shifts is not None else best[0] + np.arange(-0.06, 0.0601, 0.005)
        for shift in grid:
            other = np.interp(run.time + shift, time, steering)
            other = other - other.mean()
            norm = float(np.linalg.norm(own) * np.linalg.norm(other)) + 1e-12
            score = float(np.dot(own, other)) / norm
            if score > best[1]:
                best = (float(shift), score)
    return best


def attach(
    problem: Problem,
    simulations: Sequence[Path],
    signals: Path,
    calibration: Sequence[ActiveEffect] = (),
    simulation_signals: Path | None = None,
) -> tuple[Problem, Problem, list[str]]:
    """Pair each run with its simulation and make it the baseline.

    Parameters
    ----------
    problem, simulations, signals
        The runs and the simulations of them, in any order; or one FMU, which is driven with each.
    simulation_signals
        The roles of the simulations, where they are others (`cosim.mapping` for an FMU).
    calibration
        What fits the plant to simulations of this combination, if that is known already; else it
        is fitted to these.

    Returns
    -------
    problem
        With corrections in the runs and the constants calibrated in free simulation.
    observed
        The same under the observer: near the critical speed a free plant carries every small
        difference on, and its correction with it; pulled to the simulation it does not.
    checks
        Sentences for the report.
    """
    if any(is_fmu(path) for path in simulations):
        pairs, checks = _driven(problem, simulations, signals, simulation_signals)
    else:
        pairs, checks = _paired(problem, simulations, simulation_signals or signals)
    return _corrected(problem, pairs, checks, calibration)


def _driven(
    problem: Problem, simulations: Sequence[Path], signals: Path, simulation_signals: Path | None
) -> tuple[list[Pair], list[str]]:
    """Each run with what an FMU makes of its inputs."""
    if len(simulations) != 1:
        raise RecordingError(
            f"{len(simulations)} simulations, an FMU among them; one FMU is driven with every run"
        )
    recorded = {m.channel: m.signals[0] for m in load_signals(signals)[0]}
    path, pairs = simulations[0], []
    with Fmu(path) as fmu:
        wiring = wire(fmu.description, path, simulation_signals, recorded)
        checks = remarks(path, wiring)
        for run in problem.runs:
            inputs = dict(run.channels)
            inputs["steering_wheel_angle"] = run.steer * run.steering_ratio
            inputs["speed"] = run.speed
            made = drive_fmu(fmu, wiring, run.time, inputs, run.positions)
            channels = {name: value for name, value in made.items() if name in run.channels}
            if not {"car_yaw_rate", "trailer_yaw_rate"} & set(channels):
                raise RecordingError(f"{path}: no output for car_yaw_rate or trailer_yaw_rate; "
                                     "without one it cannot be compared")  # fmt: skip
            pairs.append((run, channels))
    return pairs, checks


def _paired(
    problem: Problem, simulations: Sequence[Path], signals: Path
) -> tuple[list[Pair], list[str]]:
    """Each run with the simulation that has its steering."""
    checks: list[str] = []
    drives = []
    for path in simulations:
        drives += load_drives([path], signals)
    pairs: list[Pair] = []
    for run in problem.runs:
        best = (-1.0, 0.0, -1)
        for index, drive in enumerate(drives):
            steering = drive.channels["steering_wheel_angle"]
            shift, score = clock_offset(run, steering.time_s, steering.value)
            if score > best[0]:
                best = (score, shift, index)
        if best[0] < LEAST_CORRELATION:
            raise RecordingError(
                f"{run.name}: no simulation has its steering (best correlation {best[0]:.2f}, "
                f"at least {LEAST_CORRELATION} is needed)"
            )
        shift = best[1] if abs(best[1]) > NOTABLE_OFFSET_S else 0.0
        if shift:
            checks.append(f"{run.name}: the simulation's clock is {shift:+.3f} s ahead; aligned")
        channels = {
            name: np.interp(run.time + shift, c.time_s, c.value)
            for name, c in drives[best[2]].channels.items()
        }
        pairs.append((run, channels))
    return pairs, checks


def rolling(problem: Problem, index: int, fit: Fit) -> dict[str, Array]:
    """Roll of both bodies, rad, and its rate, rad/s, as the plant has them; by name."""
    made = simulate(plant_of(problem, index, fit.terms, fit.nuisance[index], fit.shift))
    names = [f"{body}_{value}" for body in ("car", "trailer") for value in ("roll", "roll_rate")]
    return {name: made[:, OUTPUT.index(name)] for name in names}


def _corrected(
    problem: Problem,
    pairs: Sequence[Pair],
    checks: list[str],
    calibration: Sequence[ActiveEffect],
) -> tuple[Problem, Problem, list[str]]:
    simulated = []
    for run, channels in pairs:
        twin = Run(
            run.name, run.time, dict(channels), run.positions, run.steering_ratio,
            noise=dict.fromkeys(run.noise, 0.0),  # a simulation has none
        )  # fmt: skip
        twin.speed = low_pass(channels["speed"], 0.7, order=2)
        twin.acceleration = np.gradient(twin.speed) * RATE_HZ
        twin.steer = low_pass(channels["steering_wheel_angle"], 10.0) / run.steering_ratio
        simulated.append(twin)
    plain = Problem(tuple(simulated), problem.body, observer=OBSERVER)
    kinds = [_rigid(plain), on_springs(plain, heaves=True)]
    if calibration:
        kinds = [replace(plain, given=problem.given)]
    fits = [(kind, _calibrated(kind, calibration)) for kind in kinds]
    close_problem, close = min(fits, key=lambda pair: pair[1].chi2)
    free_problem = replace(close_problem, observer=0.0)
    free = _calibrated(free_problem, calibration, near=close)
    runs = []
    share = []
    for index, (run, channels) in enumerate(pairs):
        names = [name for name in COMPARED if name in channels]
        own = predict_run(free_problem, index, free.terms, free.nuisance[index], free.shift)
        run.correction = {name: channels[name] - own[name] for name in names}
        own = predict_run(close_problem, index, close.terms, close.nuisance[index], close.shift)
        run.observed = {name: channels[name] - own[name] for name in names}
        run.simulated.update(rolling(close_problem, index, close))
        run.speed, run.acceleration = simulated[index].speed, simulated[index].acceleration
        run.steer = simulated[index].steer
        for name in ("car_yaw_rate", "trailer_yaw_rate"):
            if name in run.correction:
                share.append(float(np.std(run.correction[name]) / np.std(channels[name])))
        runs.append(run)
    checks.append(
        "the plant of the correction reproduces the yaw rates of the simulation within "
        f"{100.0 * max(share):.1f} %"
    )
    made, observed = (
        Problem(
            tuple(runs), problem.body, False, f.terms, f.nuisance, np.zeros(0), p.observer,
            given=_given(p, f),
        )
        for p, f in ((free_problem, free), (close_problem, close))
    )  # fmt: skip
    return made, observed, checks


def _rigid(problem: Problem) -> Problem:
    """The planar plant, its load transfer believed typical."""
    items = tuple(Belief("typical", name, *TYPICAL[name]) for name in TRANSFER)
    given = tuple((name, float(neutral()[SCALARS.index(name)])) for name in TRANSFER)
    return replace(problem, beliefs=Beliefs(items), given=given)


def _given(problem: Problem, fit: Fit) -> tuple[tuple[str, float], ...]:
    """Slots of the plant as they were calibrated, by name."""
    plant = plant_of(problem, 0, (), fit.nuisance[0], fit.shift)
    return tuple((name, plant.get(name)) for name, _ in problem.given)


def _calibrated(problem: Problem, known: Sequence[ActiveEffect], near: Fit | None = None) -> Fit:
    """The plant fitted to the user's simulation, by constants that such simulations differ in.

    From a fit `near` it, if there is one; `known` constants are kept.
    """
    fitter = Fitter(problem, fine=False)
    fit = fitter.run(fitter.start(), 6)
    if known:
        return fitter.run(Fit(tuple(known), fit.nuisance, fit.shift), 10, free=0)
    terms, shift = (near.terms, near.shift) if near else (_starts(problem), fit.shift)
    return fitter.run(Fit(terms, fit.nuisance, shift), 15, calibrate=True, tolerance=3e-3)


def _starts(problem: Problem) -> tuple[ActiveEffect, ...]:
    terms = tuple(ActiveEffect(e, (1.0,)) for e in PARAMETERS if e.component in CALIBRATED)
    if problem.on_springs:
        return terms
    terms += tuple(ActiveEffect(e, (0.15,)) for e in RELAXATION if e.component != "all")
    return (*terms, ActiveEffect(LOAD[0], (0.0, 1.0)), ActiveEffect(SATURATION[0], (1.5,)))
