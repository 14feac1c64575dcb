"""Windows found together with the vehicle, where a vehicle fitted without them is bent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA

from swaywatch.diagnose.evidence.locate import Locator, pulses_of, windows
from swaywatch.diagnose.evidence.search import Search
from swaywatch.diagnose.evidence.sparse_course import MOST_PULSES, sparse_course
from swaywatch.diagnose.fit.data import load
from swaywatch.diagnose.fit.fit import OBSERVER, Fitter, Problem, predict_run
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect, library
from swaywatch.effects.runs import RATE_HZ

CASE = DATA / "practice" / "p01"
TRUE = ((0, 5.3, 9.6), (0, 22.1, 26.2), (1, 14.4, 19.7))
FACTOR = 0.8


def change() -> Effect:
    """Stiffness of the car's rear axle."""
    return next(e for e in library() if e.name == "tyre_stiffness_change:car_rear")


@pytest.fixture(scope="module")
def problem() -> Problem:
    """Two drives of our own plant whose rear tyres are softer in three windows, with noise."""
    found = load(sorted(CASE.glob("run*.blf")), CASE / "vehicle.toml", CASE / "signals.toml")
    own = found.problem
    values = [x for _, start, stop in TRUE for x in (start, stop, FACTOR)]
    term = ActiveEffect(change(), tuple(values), tuple(r for r, *_ in TRUE))
    rng = np.random.default_rng(5)
    runs = []
    for r, run in enumerate(own.runs):
        shown = predict_run(own, r, (term,), np.zeros(5), own.at_rest())
        channels = dict(run.channels)
        for name in own.channels(run):
            size = 0.05 * float(np.std(shown[name])) + 1e-9
            channels[name] = shown[name] + size * rng.normal(size=shown[name].size)
        noise = {name: 0.05 * float(np.std(shown[name])) + 1e-9 for name in own.channels(run)}
        runs.append(
            replace(run, channels=channels, noise={**run.noise, **noise}, scales={}, simulated={})
        )
    return replace(own, runs=tuple(runs), observer=OBSERVER)


def test_a_pulse_beside_others_shows_what_the_whole_simulation_does(problem: Problem) -> None:
    """It is simulated only from its begin until the observer has forgotten it."""
    close = Fitter(problem, fine=False)
    rest = close.start()
    values = [x for _, start, stop in TRUE for x in (start, stop, FACTOR)]
    fit = replace(rest, terms=(ActiveEffect(change(), tuple(values), tuple(r for r, *_ in TRUE)),))
    edges = np.linspace(float(problem.runs[0].time[0]), float(problem.runs[0].time[-1]), 21)
    pulses = pulses_of(change(), 0, edges)[4:8]
    locator = Locator(close, fit)
    for pulse, column in zip(pulses, locator.columns(0, pulses), strict=True):
        whole = close.evaluate(0, (*fit.terms, pulse), fit.nuisance[0], fit.shift)
        moved = whole - locator.base[0]
        assert np.linalg.norm(column - moved) < 0.02 * np.linalg.norm(moved)
        assert np.linalg.norm(moved) > 1.0


def test_what_was_asked_before_is_answered_again(problem: Problem) -> None:
    effects = [e for e in library() if e.id == "tyre_relaxation"]
    search = Search(replace(problem, observer=0.0), effects, lambda stage, share: None)
    base = search.baseline().fit
    first = search.extend(base)
    tried = len(search.tried)
    again = search.extend(base)
    assert first
    assert [id(c.fit) for c in again] == [id(c.fit) for c in first]
    assert len(search.tried) == tried


def test_windows_and_size_are_found_beside_a_bent_vehicle(problem: Problem) -> None:
    close = Fitter(problem, fine=False)
    bent = close.run(close.start(), 12)
    found = sparse_course(close, bent, change())
    assert found is not None
    course, start = found
    assert course.gain > 0.8 * bent.chi2
    term = windows(course)
    assert term is not None
    rows = [(term.window_runs[w], *term.values[3 * w : 3 * w + 3]) for w in range(len(TRUE))]
    assert len(term.window_runs) == len(TRUE)
    for (run, begin, end, factor), (in_run, start_s, stop_s) in zip(rows, TRUE, strict=True):
        assert run == in_run
        assert begin == pytest.approx(start_s, abs=1.1)  # pulses of one second
        assert end == pytest.approx(stop_s, abs=1.1)
        assert factor == pytest.approx(FACTOR, abs=0.05)
    # and the vehicle is no longer bent
    assert np.abs(start.shift).max() < 0.5 * np.abs(bent.shift).max()


def test_nothing_is_found_where_nothing_acts(problem: Problem) -> None:
    clean, free = [], replace(problem, observer=0.0)
    for r, run in enumerate(problem.runs):
        shown = predict_run(free, r, (), np.zeros(5), problem.at_rest())
        rng = np.random.default_rng(r)
        names = problem.channels(run)
        noisy = {n: shown[n] + run.noise[n] * rng.normal(size=shown[n].size) for n in names}
        clean.append(replace(run, channels={**run.channels, **noisy}, scales={}, simulated={}))
    same = replace(problem, runs=tuple(clean))
    close = Fitter(same, fine=False)
    found = sparse_course(close, close.run(close.start(), 8), change())
    assert found is not None
    assert windows(found[0]) is None


def test_a_long_recording_is_left_to_the_linear_course(problem: Problem) -> None:
    duration = sum(run.time.size for run in problem.runs) / RATE_HZ
    close = Fitter(problem, fine=False)
    short = 0.5 * duration / MOST_PULSES
    assert sparse_course(close, close.start(), change(), short) is None
