"""The simulation before anything was adapted: the vehicle as its file has it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from swaywatch.diagnose.fit.agreement import errors
from swaywatch.diagnose.fit.fit import Fit, Fitter, Problem, predict_run
from swaywatch.diagnose.fit.holdout import start_values

RUNS_AWAY = 10.0
"""RMS error over RMS of the signal from which a simulation is no picture of the run."""


def as_written(problem: Problem) -> Fit | None:
    """The vehicle of `vehicle.toml` and the sensors as they are believed, nothing missing added.

    Steering offset and start values, which no file has, are of the first seconds of each run: of
    the whole run they would take part of the mismatch away. Beside the user's own simulation it is
    that simulation.

    Returns
    -------
    Fit or None
        None where this vehicle runs away: it is unstable as it is written.
    """
    fitter = Fitter(problem)
    rest = fitter.start()
    runs = range(len(problem.runs))
    begun = np.array([start_values(problem, index, (), rest.shift) for index in runs])
    fit = fitter.run(replace(rest, nuisance=begun), 0, calibrate=False)
    for index in runs:
        outputs = predict_run(problem, index, (), fit.nuisance[index], fit.shift)
        off = errors(problem, index, outputs).values()
        if not all(np.isfinite(x) and x < RUNS_AWAY for x in off):
            return None
    return fit
