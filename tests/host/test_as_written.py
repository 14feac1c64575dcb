"""The simulation of vehicle.toml as it is written: what a finding is shown to improve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from test_diagnose import BODY_VALUES, synthetic

from swaywatch.diagnose.evidence.search import reduced_chi_square
from swaywatch.diagnose.evidence.verdict import Verdict
from swaywatch.diagnose.fit.as_written import as_written
from swaywatch.diagnose.fit.fit import Fit
from swaywatch.diagnose.report.labels import how_well
from swaywatch.plant.lanes import BODY

REAR = BODY.index("car.rear_cornering_stiffness")


def test_only_offsets_and_start_values_are_fitted() -> None:
    problem = synthetic((), 3)
    right = as_written(problem)
    assert right is not None
    assert reduced_chi_square(right) < 1.5
    body = BODY_VALUES.copy()
    body[REAR] *= 0.85
    wrong = as_written(replace(problem, body=body))
    assert wrong is not None
    assert not wrong.terms
    assert not np.any(wrong.shift)
    assert reduced_chi_square(wrong) > 20.0 * reduced_chi_square(right)


def test_a_vehicle_that_runs_away_is_no_simulation() -> None:
    body = BODY_VALUES.copy()
    body[REAR] *= 0.05
    assert as_written(replace(synthetic((), 3), body=body)) is None


def test_what_calibration_found_is_compared_with_the_file() -> None:
    problem = synthetic((), 3)
    fit, calibrated, written = (Fit((), np.zeros((2, 5)), np.zeros(0), chi2=c) for c in (1, 2, 3))
    verdict = Verdict("missing_physics", fit, calibrated, problem, written=written)
    assert verdict.before is written
    verdict.evidence = 10.0  # found beyond the calibration
    assert verdict.before is calibrated
    assert Verdict("consistent", fit, calibrated, problem).before is calibrated


def test_the_improvement_in_words() -> None:
    fit = {
        "baseline": "calibrated", "as_written_nrmse": 0.4, "baseline_nrmse": 0.2,
        "diagnosed_nrmse": 0.01, "held_out_baseline_nrmse": 0.6, "held_out_diagnosed_nrmse": 0.012,
    }  # fmt: skip
    sensor_fault = {"fit": None}
    result = {"effects": [sensor_fault, {"fit": fit}], "model": {}}
    begin = "error of the simulation (NRMSE): 0.400 with vehicle.toml as written, "
    end = "0.010 with the findings; of runs left out of the fit 0.600 without and 0.012 with them"
    assert how_well(result) == begin + "0.200 without the findings, " + end
    fit["baseline"] = "as_written"
    assert how_well(result) == begin + end
    fit |= {"held_out_baseline_nrmse": None, "as_written_nrmse": None, "baseline": "calibrated"}
    assert how_well(result) == (
        "error of the simulation (NRMSE): 0.200 without the findings, 0.010 with the findings"
    )
    fit["as_written_nrmse"] = 0.3
    beside = result | {"model": {"calibration": {}}}
    assert "0.300 with your simulation" in how_well(beside)
    assert how_well({"effects": [sensor_fault]}) == ""
