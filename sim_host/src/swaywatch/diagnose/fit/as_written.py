"""The simulation before anything was adapted: the vehicle as its file has it."""

from __future__ import annotations

import numpy as np

from swaywatch.diagnose.fit.agreement import errors
from swaywatch.diagnose.fit.fit import Fit, Fitter, Problem, predict_run

ITERATIONS = 10
RUNS_AWAY = 10.0
"""RMS error over RMS of the signal from which a simulation is no picture of the run."""


def as_written(problem: Problem) -> Fit | None:
    """The vehicle of `vehicle.toml` and the sensors as they are believed, nothing missing added.

    Only the steering's offset and the start values of each run are fitted, because no file has
    them. Beside the user's own simulation it is that simulation.

    Returns
    -------
    Fit or None
        None where this vehicle runs away: it is unstable as it is written.
    """
    fitter = Fitter(problem)
    fit = fitter.run(fitter.start(), ITERATIONS, calibrate=False)
    for index in range(len(problem.runs)):
        outputs = predict_run(problem, index, (), fit.nuisance[index], fit.shift)
        off = errors(problem, index, outputs).values()
        if not all(np.isfinite(x) and x < RUNS_AWAY for x in off):
            return None
    return fit
