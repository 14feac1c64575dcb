"""Damping against speed: points, line, intervals; the command."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from swaywatch.analysis import DriveResult
from swaywatch.cli import main
from swaywatch.commands.iso9815 import as_json, make_page
from swaywatch.core import analyze_drive
from swaywatch.drive import Channel, Drive
from swaywatch.errors import RecordingError
from swaywatch.iso9815 import evaluate, points_of
from swaywatch.vehicle import Car, Trailer, Vehicle

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "bench"))

import warning_plant as plant

DATA = Path(__file__).resolve().parent.parent / "data" / "practice"
REFERENCE = plant.Combination(peak_friction=50.0)


def reference_vehicle() -> Vehicle:
    """The reference's combination as the user knows it."""
    c = REFERENCE
    car = Car(c.m1, c.i1, c.lf1, c.lr1, c.ratio, c.lh1, c.stiffness[0], c.stiffness[1])
    trailer = Trailer(c.m2, c.i2, c.lr2, c.lh2, c.lf2, c.stiffness[2], c.stiffness[3])
    return Vehicle(car, trailer, Path("vehicle.toml"))


def impulse_run(speed_kmh: float, seed: int) -> DriveResult:
    """A steering impulse at constant speed, then the wheel held."""
    course = plant.course(20.0, speed_kmh / 3.6)
    course.wheel += plant.half_sine(course.time_s, 3.0, 0.74, math.radians(19))
    motion = plant.simulate(REFERENCE, course)
    samples = plant.measure(motion, np.random.default_rng(seed))
    position = {"car_lateral_acceleration": -REFERENCE.lr1}
    channels = {
        name: Channel(name, time_s, value, name, "", position.get(name, 0.0))
        for name, (time_s, value) in samples.items()
    }
    drive = Drive(f"run{speed_kmh:g}", (Path(f"run{speed_kmh:g}.blf"),), channels, 0)
    vehicle = reference_vehicle()
    rest: dict[str, Any] = {
        f.name: {} if f.name == "values" else []
        for f in fields(DriveResult)
        if f.name not in {"drive", "vehicle", "estimates"}
    }
    return DriveResult(drive, vehicle, analyze_drive(drive, vehicle), **rest)


@pytest.fixture(scope="module")
def runs() -> list[DriveResult]:
    """Six runs below the critical speed."""
    return [impulse_run(v, k) for k, v in enumerate((90, 95, 100, 105, 110, 115))]


def test_points_are_free_windows_that_do_not_overlap(runs: list[DriveResult]) -> None:
    for run, speed in zip(runs, (90, 95, 100, 105, 110, 115), strict=True):
        points = points_of(run)
        assert len(points) >= (2 if speed >= 95 else 1)
        truth = plant.damping_ratio(REFERENCE, speed / 3.6)
        for point in points:
            assert point.time_s > 4.0  # the impulse is not in it
            assert point.damping_ratio == pytest.approx(truth, abs=0.04)
        assert np.all(np.diff([p.time_s for p in points]) > 2.0)


def test_zero_damping_speed_is_that_of_the_plant(runs: list[DriveResult]) -> None:
    result = evaluate(runs)
    v_crit = plant.critical_speed(REFERENCE)
    v_05 = next(
        v for v in np.arange(25, 40, 0.01) if plant.damping_ratio(REFERENCE, float(v)) < 0.05
    )
    assert result.c1 < 0
    for speed, truth in ((result.zero, v_crit), (result.limit, v_05)):
        assert speed.value_m_s is not None
        assert speed.low_m_s is not None
        assert speed.high_m_s is not None
        assert speed.low_m_s < speed.value_m_s < speed.high_m_s
        # The line is straight, the true curve bends a little: 1 m/s beside the interval.
        assert speed.low_m_s - 1.0 < truth < speed.high_m_s + 1.0
        assert speed.high_m_s - speed.low_m_s < 6.0
    assert result.zero.extrapolated
    assert not result.limit.extrapolated


def test_interval_covers_the_truth_as_often_as_it_says() -> None:
    from swaywatch.iso9815 import _crossing, _fit

    rng = np.random.default_rng(3)
    speed = np.repeat(np.array([25.0, 27.0, 29.0, 31.0]), 3)
    inside = 0
    trials = 600
    for _ in range(trials):
        error = np.full(len(speed), 0.01)
        ratio = 0.6 - 0.0175 * speed + rng.normal(0, error)
        coefficients, covariance, _ = _fit(speed, ratio, error**2)
        found = _crossing(0.0, coefficients, covariance, 1.96, (25.0, 31.0))
        assert found.low_m_s is not None
        assert found.high_m_s is not None
        inside += found.low_m_s < 0.6 / 0.0175 < found.high_m_s
    assert 0.92 < inside / trials < 0.98


def test_page_and_json_hold_the_result(runs: list[DriveResult]) -> None:
    result = evaluate(runs)
    page = make_page(result, runs)
    assert "zero-damping speed" in page
    assert "https://" not in page.split("<script")[0]
    content = json.loads(json.dumps(as_json(result, runs), allow_nan=False))
    assert content["zero_damping_speed"]["value_m_s"] == result.zero.value_m_s
    assert len(content["points"]) == len(result.points)


def test_runs_at_one_speed_are_refused(runs: list[DriveResult]) -> None:
    with pytest.raises(RecordingError, match="regression over speed needs runs at speeds"):
        evaluate([runs[3], impulse_run(105, 77)])


def test_command_refuses_without_leaving_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = DATA / "p01"
    code = main(
        [
            "iso9815", str(next(case.glob("run1.*"))), "--vehicle", str(case / "vehicle.toml"),
            "--signals", str(case / "signals.toml"), "--out", str(tmp_path / "out"),
        ]
    )  # fmt: skip
    assert code != 0
    assert "km/h" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
