"""Before and after: how well a model reproduces a run, in the field's own terms."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.fit.fit import Problem
from swaywatch.effects.runs import Run, block_mean

Array = NDArray[np.float64]

#: Channels whose agreement is scored by ISO/TS 18571.
RATED = ("car_yaw_rate", "trailer_yaw_rate", "hitch_lateral_force")
FIVE_PERCENT = 0.05


def errors(problem: Problem, index: int, outputs: Mapping[str, Array]) -> dict[str, float]:
    """RMS error of each channel over its standard deviation, offsets taken off, 10 Hz."""
    run = problem.runs[index]
    found = {}
    for name in problem.channels(run):
        kept = run.kept_blocks(name)
        measured = block_mean(run.channels[name])[kept]
        error = measured - block_mean(outputs[name])[kept]
        found[name] = float(np.std(error) / (np.std(measured) + 1e-12))
    return found


def nrmse(values: Mapping[str, float]) -> float:
    """One figure for a run: quadratic mean over the lateral channels (loads are mostly noise)."""
    used = [v for name, v in values.items() if "vertical" not in name]
    return float(np.sqrt(np.mean(np.square(used)))) if used else float("nan")


def iso18571(run: Run, outputs: Mapping[str, Array]) -> float:
    """Mean ISO/TS 18571 score of the rated channels, 0 to 1 (curves rescaled to 10 kHz).

    NaN where the library that rates is not installed: no diagnosis needs it.
    """
    try:
        from dtwalign import backtrack, cost, window  # type: ignore[import-untyped]
        from objective_rating_metrics.rating import ISO18571
    except ModuleNotFoundError:
        return float("nan")

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
