"""Before and after: how well a model reproduces a run, in the field's own terms."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.fit import Fit, Fitter, Problem, predict_run
from swaywatch.diagnose.runs import BLOCK, RATE_HZ, Run, block_mean
from swaywatch.diagnose.term import Term

Array = NDArray[np.float64]

#: Channels whose agreement is scored by ISO/TS 18571.
RATED = ("car_yaw_rate", "trailer_yaw_rate", "hitch_lateral_force")
FIVE_PERCENT = 0.05


def errors(problem: Problem, index: int, outputs: Mapping[str, Array]) -> dict[str, float]:
    """RMS error of each channel over its standard deviation, offsets taken off, 10 Hz."""
    run = problem.runs[index]
    found = {}
    for name in problem.channels(run):
        measured = block_mean(run.channels[name])
        error = measured - block_mean(outputs[name])
        found[name] = float(np.std(error) / (np.std(measured) + 1e-12))
    return found


def nrmse(values: Mapping[str, float]) -> float:
    """One figure for a run: quadratic mean over the lateral channels (loads are mostly noise)."""
    used = [v for name, v in values.items() if "vertical" not in name]
    return float(np.sqrt(np.mean(np.square(used)))) if used else float("nan")


def iso18571(run: Run, outputs: Mapping[str, Array]) -> float:
    """Mean ISO/TS 18571 score of the rated channels, 0 to 1 (curves rescaled to 10 kHz)."""
    from dtwalign import backtrack, cost, window  # type: ignore[import-untyped]
    from objective_rating_metrics.rating import ISO18571

    for function in (
        backtrack._backtrack_jit,
        cost._calc_cumsum_matrix_jit,
        *(f for f in vars(window).values() if hasattr(f, "enable_caching")),
    ):
        function.enable_caching()  # the library compiles for ten seconds at every start
    scores = []
    for name in RATED:
        if name not in run.channels:
            continue
        measured = block_mean(run.channels[name])
        simulated = block_mean(outputs[name])
        simulated = simulated + float(np.mean(measured) - np.mean(simulated))
        time = np.arange(measured.size) / 10_000.0
        rating = ISO18571(
            reference_curve=np.stack([time, measured], axis=1),
            comparison_curve=np.stack([time, simulated], axis=1),
        )
        scores.append(float(rating.overall_rating()))
    return float(np.mean(scores)) if scores else float("nan")


def first_seconds(problem: Problem, seconds: float) -> Problem:
    """The problem with only the first seconds of each run."""
    count = int(seconds * RATE_HZ) // BLOCK * BLOCK
    runs = []
    for run in problem.runs:
        cut = min(count, run.time.size)
        runs.append(
            Run(
                run.name,
                run.time[:cut],
                {k: v[:cut] for k, v in run.channels.items()},
                run.positions,
                run.steering_ratio,
                run.noise,
                run.speed[:cut],
                run.acceleration[:cut],
                run.steer[:cut],
                run.scales,
            )
        )
    return Problem(tuple(runs), problem.body)


def start_values(problem: Problem, index: int, terms: tuple[Term, ...], shared: Array) -> Array:
    """Steering offset and start values of a run, from its first five seconds only."""
    one = first_seconds(Problem((problem.runs[index],), problem.body), 5.0)
    constant = tuple(t for t in terms if not t.effect.windowed)
    fit = Fitter(one).run(Fit(constant, np.zeros((1, 5)), shared), 6, free=0)
    return np.asarray(fit.nuisance[0])


def held_out(problem: Problem, fit: Fit) -> list[tuple[float, float]]:
    """Each run predicted by what the other runs taught: (baseline, diagnosed) NRMSE.

    Only effects without windows are carried over: windows belong to their run.
    """
    found = []
    constant = tuple(t for t in fit.terms if not t.effect.windowed)
    if not constant or len(problem.runs) < 2:
        return []
    for index in range(len(problem.runs)):
        others = [r for r in range(len(problem.runs)) if r != index]
        fitter = Fitter(problem)
        taught = fitter.run(Fit(fit.terms, fit.nuisance, fit.shared), 5, runs=others)
        terms = tuple(t for t in taught.terms if not t.effect.windowed)
        pair = []
        for model in ((), terms):
            nuisance = start_values(problem, index, model, fit.shared)
            outputs = predict_run(problem, index, model, nuisance, fit.shared)
            pair.append(nrmse(errors(problem, index, outputs)))
        found.append((pair[0], pair[1]))
    return found
