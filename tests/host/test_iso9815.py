"""The profile of ISO 9815: zero-damping speed of a towing combination, also when extrapolated."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from swaywatch.cli import main
from swaywatch.damping.course import Bend, fit_course
from swaywatch.damping.data import Choice, run_of
from swaywatch.damping.intervals import IntervalValue, Point
from swaywatch.damping.page import make_page
from swaywatch.damping.sentences import sentences
from swaywatch.damping.study import Study, StudyPlan, as_json, study_of
from swaywatch.damping.window import Estimator

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "bench"))

import iso9815 as bench

DATA = Path(__file__).resolve().parent.parent / "data" / "practice"


def iso9815_study() -> Study:
    """A drawn combination's test."""
    rng = np.random.default_rng((20261122, 0))
    test = bench.drawn(rng, sprung=False, linear=False)
    return study_of(
        [run_of(drive) for drive in bench.drives(test, rng)], StudyPlan(Choice(), iso9815=True)
    )


def test_extrapolated_zeros_are_those_of_the_plants() -> None:
    """`make bench-iso9815` does 300 of these."""
    estimator = Estimator()
    held, off, line_off = [], [], []
    for number in (2, 5, 6, 9, 13, 14):  # planar, and on springs with linear tyres
        rng = np.random.default_rng((7, number))
        test = bench.drawn(rng, sprung=number % 2 == 1, linear=True)
        zeros = bench.zeros(bench.drives(test, rng), estimator)
        bent, line = zeros["bent"], zeros["straight line"]
        assert bent is not None
        assert bent.value is not None
        assert line is not None
        assert line.value is not None
        held.append(bench.holds(bent, test.critical_m_s))
        off.append(abs(bent.value - test.critical_m_s))
        line_off.append(abs(line.value - test.critical_m_s))
    assert sum(held) >= 5
    assert np.median(off) < 0.6 * np.median(line_off)


def _point(speed: float, ratio: float) -> Point:
    return Point(
        "r", 1, 0.0, 1.0, speed, IntervalValue(ratio, 0.005, 30.0), IntervalValue(0.6, 0.01, 30.0),
        IntervalValue(-0.1, 0.02, 30.0), np.ones(1), 2.0, 0.0, np.full(3, np.nan),
    )  # fmt: skip


def test_bend_of_a_towing_combination_holds_where_a_straight_line_does_not() -> None:
    """Damping that goes with a power of the speed, drawn as the constant says."""
    rng = np.random.default_rng(3)
    inside = {Bend.TOWED: 0, Bend.NONE: 0}
    for _ in range(300):
        power = -0.35 + 0.3 * rng.standard_normal()
        critical, speeds = 34.0, np.repeat(np.linspace(22.0, 30.0, 5), 3)
        ratio = 0.35 * ((speeds / critical) ** power - 1.0) / -power
        points = [
            _point(float(v), float(z) + 0.005 * rng.standard_normal())
            for v, z in zip(speeds, ratio, strict=True)
        ]
        for bend in inside:
            course = fit_course(points, bend=bend)
            assert course is not None
            inside[bend] += bench.holds(course.zero(), critical)
    assert 0.90 <= inside[Bend.TOWED] / 300 <= 0.99
    assert inside[Bend.NONE] / 300 < 0.7


def test_page_and_json_say_both_lines() -> None:
    study = iso9815_study()
    page = make_page(study, {})
    assert "Damping against speed (ISO 9815)" in page
    content = json.loads(json.dumps(as_json(study), allow_nan=False))
    assert content["straight_line"]["zero_damping"]["value"] < content["zero_damping"]["value"]
    assert any("straight line alone" in text for text in sentences(study))
    assert len(content["windows"]) == len(study.points) >= 8


@pytest.mark.parametrize("more", [[], ["--json"]])
def test_one_speed_is_refused_without_leaving_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str]
) -> None:
    case = DATA / "p01"
    code = main(
        [
            "iso9815", str(next(case.glob("run1.*"))), "--signals", str(case / "signals.toml"),
            "--out", str(tmp_path / "out"), *more,
        ]
    )  # fmt: skip
    assert code != 0
    assert "km/h" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
