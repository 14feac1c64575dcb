"""Intervals: the fitted table, what it may depend on, and what comes of it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "proof" / "blind"))

import calibrate

from swaywatch.diagnose.evidence.calibration import BESIDE, interval, table
from swaywatch.diagnose.report.describe import _reported
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library

PROOF_SEED = 20261121


def test_the_table_was_not_fitted_to_the_proof() -> None:
    provenance = table()["provenance"]
    assert provenance["cases"] > 0
    assert provenance["seeds"]
    assert PROOF_SEED not in provenance["seeds"]
    assert {name.removesuffix(BESIDE) for name in table()["intervals"]["form"]} <= {
        e.id for e in library()
    }


def test_the_calibration_refuses_the_seed_of_the_proof(tmp_path: Path) -> None:
    script = Path(calibrate.__file__)
    done = subprocess.run(
        [sys.executable, str(script), "--set", str(tmp_path), str(tmp_path),
         "--seeds", str(PROOF_SEED), "--out", str(tmp_path / "out.json")],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode != 0
    assert "seed of the proof" in done.stderr


def test_an_interval_holds_its_value_and_widens_with_error_and_size() -> None:
    narrow = interval("hitch_friction", 100.0, 100.0, 1.0, 1.0)
    wide = interval("hitch_friction", 100.0, 100.0, 10.0, 1.0)
    assert narrow["low"] < 100.0 < narrow["high"]
    assert wide["high"] - wide["low"] > narrow["high"] - narrow["low"]
    small = interval("parameter_error", 1.01, 0.01, 1e-4, 1.0)
    large = interval("parameter_error", 1.30, 0.30, 1e-4, 1.0)
    assert small["high"] - small["low"] < large["high"] - large["low"]


@pytest.mark.filterwarnings("error")
def test_a_value_whose_error_is_none_is_reported() -> None:
    import numpy as np

    own = next(e for e in library() if e.name == "tyre_relaxation:car_rear")
    rows = _reported(ActiveEffect(own, (0.5,)), "tyre_relaxation", np.zeros((1, 1)), 1.0)
    assert rows["length_m"]["value"] == 0.5
    assert np.isfinite([rows["length_m"]["low"], rows["length_m"]["high"]]).all()


def test_intervals_fitted_to_known_errors_cover_nine_tenths() -> None:
    import numpy as np

    rng = np.random.default_rng(5)
    found = {
        "hitch_friction": [
            (float(rng.normal(0.0, 0.05 * size / 1.645)), 1e-6 * size, size)
            for size in rng.uniform(10.0, 200.0, 300)
        ]
    }
    fitted = calibrate.intervals(found)
    inside = [abs(error) <= fitted["form"]["hitch_friction"] * size for error, _, size in
              found["hitch_friction"]]  # fmt: skip
    assert np.mean(inside) == pytest.approx(0.9, abs=0.06)


def test_the_table_is_plain_json() -> None:
    assert json.loads(json.dumps(table())) == table()
