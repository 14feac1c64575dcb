"""Where laws are begun in a long recording, and when what a fit leaves counts as noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from test_diagnose import synthetic
from test_discover import searched

from swaywatch.diagnose.evidence.evidence import colour
from swaywatch.diagnose.evidence.search import Linear
from swaywatch.diagnose.fit.fit import OBSERVER, Fitter, Problem
from swaywatch.discover.effect import effect_of
from swaywatch.discover.excerpt import PART_S, everything, excerpt_of
from swaywatch.discover.law import Law
from swaywatch.discover.trial import WHITE
from swaywatch.effects.active import ActiveEffect


def close(problem: Problem) -> Fitter:
    """Under the observer, as laws are begun."""
    return Fitter(replace(problem, observer=OBSERVER), fine=False)


def misread(problem: Problem, run: int, first_s: float, last_s: float) -> None:
    """A yaw rate of the car that no vehicle explains, in a part of a run."""
    inside = slice(int(100 * first_s), int(100 * last_s))
    time = problem.runs[run].time[inside]
    problem.runs[run].channels["car_yaw_rate"][inside] += 0.01 * np.sin(9.0 * time)


def test_laws_are_begun_where_each_run_fits_worst() -> None:
    problem = synthetic((), 3, 40.0)
    misread(problem, 0, 11.0, 31.0)
    misread(problem, 1, 2.0, 21.0)
    fitter = close(problem)
    near = fitter.run(fitter.start(), 4)
    excerpt = excerpt_of(fitter, near)
    slow, fast = excerpt.fitter.problem.runs[1], excerpt.fitter.problem.runs[0]
    assert fast.time[0] == pytest.approx(11.0, abs=0.5)
    assert slow.time[0] == pytest.approx(2.0, abs=1.5)
    assert [run.time.size for run in (fast, slow)] == [100 * PART_S] * 2
    assert fast.settling  # it begins in mid-motion
    begun = excerpt.fitter.run(excerpt.of(near), 2)
    again = excerpt.back([begun], near)[0]
    assert np.array_equal(again.nuisance, near.nuisance)
    assert np.array_equal(again.shift, begun.shift)
    assert fitter.run(again, 1).count == near.count


def test_laws_are_begun_in_two_parts_of_a_single_run() -> None:
    problem = synthetic((), 3, 70.0)
    problem = replace(problem, runs=problem.runs[:1])
    misread(problem, 0, 4.0, 24.0)
    misread(problem, 0, 45.0, 65.0)
    fitter = close(problem)
    excerpt = excerpt_of(fitter, fitter.run(fitter.start(), 4))
    begins = [run.time[0] for run in excerpt.fitter.problem.runs]
    assert begins == pytest.approx([4.0, 45.0], abs=1.0)


def test_laws_are_begun_without_a_sensor_that_is_silent_there() -> None:
    """It died half way: nothing of it counts in the part, all else does."""
    problem = synthetic((), 3, 40.0)
    misread(problem, 0, 18.0, 38.0)
    dead = "trailer_yaw_rate"
    for run in problem.runs:
        run.kept[dead] = run.time < 15.0
    fitter = close(problem)
    excerpt = excerpt_of(fitter, fitter.run(fitter.start(), 4))
    part = excerpt.fitter.problem.runs[0]
    assert part.time[0] > 15.0
    assert dead not in part.channels
    assert dead in problem.runs[0].channels
    assert np.isfinite(excerpt.fitter.run(excerpt.of(fitter.start()), 2).chi2)


def test_a_short_recording_and_one_beside_a_simulation_are_searched_whole() -> None:
    short = close(synthetic((), 3, 24.0))
    beside = close(replace(synthetic((), 3, 40.0), free_start=False))
    for fitter in (short, beside):
        start = fitter.start()
        excerpt = excerpt_of(fitter, start)
        assert excerpt.fitter.problem.runs == fitter.problem.runs
        assert excerpt.of(start) is start
        strict, stricter = (
            [f.problem.observer for f in e.fitters] for e in (excerpt, excerpt.stricter())
        )
        assert fitter.problem.observer < strict[0] < stricter[0]
        assert stricter[1:] == strict  # let go step by step


def test_a_strict_observer_shows_what_a_strong_law_changes_in_proportion() -> None:
    """Its size is estimated from a weak look; under that of the search the motion drifts away."""
    law = Law("slip_trailer", "slip_trailer", "saturating")
    gain, bend = -0.83, 0.005
    close = searched((ActiveEffect(effect_of(law), (gain, bend)),)).close
    start = close.start()
    weak = ActiveEffect(effect_of(law), (0.05 * gain, bend))
    off = []
    for course in (everything(close).course(start), Linear(close, start)):
        [(promised, term)] = course.sized([weak])
        left = 1.0 - promised / float(np.dot(course.left, course.left))
        off.append((left, abs(term.values[0] / gain - 1.0)))
    (strict_left, strict), (left, searched_with) = off
    assert strict_left < 0.7 * left
    assert strict < 0.01 < searched_with


def test_white_noise_has_no_colour_whatever_its_size() -> None:
    """The level is as uncertain as the estimate of each sensor's noise; the colour is not."""
    rng = np.random.default_rng(5)
    sizes = np.array([0.8, 1.0, 1.3, 0.7, 1.2, 1.0])
    for blocks in (150, 400):
        found = [
            colour([sizes * rng.normal(size=(blocks, sizes.size)) for _ in range(2)])
            for _ in range(50)
        ]
        assert 1.0 < np.mean(found) < 1.1
    assert np.quantile(found, 0.95) < WHITE
    noise = rng.normal(size=(400, sizes.size))
    assert colour([lfilter([1.0], [1.0, -0.5], noise, axis=0)]) > 2.0
    oscillates = 0.6 * np.sin(0.3 * np.arange(400))[:, None]
    assert colour([noise + oscillates]) > 1.5
