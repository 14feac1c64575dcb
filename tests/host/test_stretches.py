"""Long recordings: which stretches are searched, and whether the others agree."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_diagnose import synthetic

from swaywatch.diagnose.engine import _cannot
from swaywatch.diagnose.fit.data import _too_little, load
from swaywatch.diagnose.fit.fit import Fit, Fitter, Problem, predict_run
from swaywatch.diagnose.fit.stretches import (
    SEARCHED_S,
    STRETCH_S,
    WHOLE_S,
    Stretches,
    divided,
    length_s,
    misfit_of,
)
from swaywatch.drive import Channel, Drive
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library
from swaywatch.effects.runs import RATE_HZ, Run

CASE = Path(__file__).resolve().parents[1] / "data" / "practice" / "p01"


@pytest.fixture(scope="module")
def problem() -> Problem:
    """Two drives of our own plant with noise."""
    return synthetic((), seed=3)


def long_run(run: Run, seconds: float, still: tuple[float, float] = (0.0, 0.0)) -> Run:
    """The run again and again; between the times of `still` it stands."""
    n = round(seconds * RATE_HZ)
    time = np.arange(n) / RATE_HZ
    standing = (time >= still[0]) & (time < still[1])
    channels = {k: np.resize(v, n) * np.where(standing, 0.0, 1.0) for k, v in run.channels.items()}
    return Run(run.name, time, channels, run.positions, run.steering_ratio).prepare()


def test_what_is_not_long_is_searched_whole(problem: Problem) -> None:
    found = divided(problem.runs, _too_little)
    assert found.whole
    assert found.searched == list(problem.runs)
    assert found.contradictions(1.0) == []


def test_of_a_long_recording_the_stretches_that_move_are_searched(problem: Problem) -> None:
    run = long_run(problem.runs[0], 600.0, still=(200.0, 360.0))
    lively = (run.time >= 480.0) & (run.time < 520.0)
    for name in ("car_yaw_rate", "trailer_yaw_rate"):
        run.channels[name] = np.where(lively, 2.0, 1.0) * run.channels[name]
    run.__dict__.pop("yaw_rates", None)
    found = divided([run], _too_little)
    assert not found.whole
    assert sum(map(length_s, found.searched)) == pytest.approx(SEARCHED_S)
    assert found.still_s == pytest.approx(160.0)
    assert sum(map(length_s, found.others)) == pytest.approx(600.0 - SEARCHED_S - 160.0)
    assert any(piece.time[0] == 480.0 for piece in found.searched[:2])
    for piece in found.searched:
        assert not (200.0 <= piece.time[0] < 360.0)
        # its times and inputs are those of the whole
        at = round(float(piece.time[0]) * RATE_HZ)
        assert np.array_equal(piece.steer, run.steer[at : at + piece.time.size])
        assert piece.name == f"{run.name} from {piece.time[0]:.0f} to {piece.time[-1]:.0f} s"


def test_slower_and_faster_stretches_are_searched_in_turn(problem: Problem) -> None:
    """What depends on the speed shows across speeds, though the slow ones move less."""
    fast = long_run(problem.runs[0], 400.0)
    slow = long_run(problem.runs[0], 400.0)
    for name in ("car_yaw_rate", "trailer_yaw_rate"):
        slow.channels[name] *= 0.5
    slow.__dict__.pop("yaw_rates", None)
    slow.speed = 0.7 * slow.speed
    found = divided([fast, slow], _too_little)
    speeds = sorted(float(np.mean(piece.speed)) for piece in found.searched)
    assert speeds[1] < 0.8 * speeds[-2]


def test_stretches_with_something_missing_do_not_fit(problem: Problem) -> None:
    fitter = Fitter(problem)
    fit = fitter.run(fitter.start(), 8)
    softer = next(e for e in library() if e.name == "tyre_stiffness_change:trailer")
    run = problem.runs[0]
    term = ActiveEffect(softer, (0.0, float(run.time[-1]), 0.8), (0,))
    rng = np.random.default_rng(4)
    others = []
    for terms in ((), (term,)):
        shown = predict_run(problem, 0, terms, fit.nuisance[0], fit.shift)
        noisy = {
            n: shown[n] + run.noise[n] * rng.normal(size=run.time.size)
            for n in problem.channels(run)
        }
        others.append(replace(run, channels={**run.channels, **noisy}, scales={}, simulated={}))
    same, other = misfit_of(problem, fit, others)
    assert same < 1.3
    assert other > 3.0
    # of an effect in windows nothing is carried over to another stretch
    with_windows = Fit((term,), fit.nuisance, fit.shift)
    assert misfit_of(problem, with_windows, others[:1]) == pytest.approx([same])


def test_what_does_not_fit_is_searched_and_else_reported(problem: Problem) -> None:
    pieces = divided([long_run(problem.runs[0], 480.0)], _too_little)
    pieces.misfit = [1.0] * len(pieces.others)
    pieces.misfit[1], pieces.misfit[4] = 5.0, 9.0
    assert pieces.apart(1.0) == [4, 1]
    assert pieces.apart(6.0) == []
    again = pieces.with_worst(1.0)
    assert len(again.searched) == len(pieces.searched)
    assert again.searched[-2:] == [pieces.others[4], pieces.others[1]]
    everything = {piece.name for piece in (*again.searched, *again.others)}
    assert everything == {piece.name for piece in (*pieces.searched, *pieces.others)}
    said = pieces.summary(1.0)
    assert said.startswith("480 s were recorded; searched: ")
    assert said.endswith("5 other stretches agree (reduced chi-square up to 1.00)")
    first, second = pieces.contradictions(1.0)
    assert first == (
        f"{pieces.others[4].name} does not fit the findings of the other stretches (reduced "
        "chi-square 9.0): diagnose this part alone"
    )
    assert second.startswith(pieces.others[1].name)
    rows = pieces.entries()
    assert [row["searched"] for row in rows] == [True] * 5 + [False] * 7
    assert rows[9]["reduced_chi_square"] == 9.0


def test_a_sensor_that_dies_is_left_out_from_then_on(problem: Problem) -> None:
    """What is searched has all sensors; what it says nothing of is checked with the others."""
    run = long_run(problem.runs[0], 480.0)
    alive = run.time < 290.0
    run.kept = {"trailer_yaw_rate": alive}
    run.silent = {"trailer_yaw_rate": ~alive}
    found = divided([run], _too_little)
    assert all("trailer_yaw_rate" in piece.channels for piece in found.searched)
    dead = [piece for piece in found.others if piece.time[0] >= 290.0]
    assert len(dead) == 4
    for piece in dead:
        assert "trailer_yaw_rate" not in piece.channels
        assert list(piece.yaw_rates) == ["car"]
    fit = Fitter(problem).start()
    found.misfit = misfit_of(problem, fit, found.others)
    assert np.all(np.isfinite(found.misfit))
    found.misfit = [9.0] * len(found.others)
    again = found.with_worst(1.0)
    assert all("trailer_yaw_rate" in piece.channels for piece in again.searched)


def test_a_stretch_that_cannot_be_simulated_does_not_fit() -> None:
    assert Stretches([], [], 0.0, [1.0, float("nan"), float("inf")]).apart(1.0) == [1, 2]


def test_a_long_recording_in_which_nothing_moves_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    time = np.arange(0.0, WHOLE_S + 2.0 * STRETCH_S, 0.01)
    rng = np.random.default_rng(1)
    sizes = {"speed": 0.02, "steering_wheel_angle": 1e-3, "car_yaw_rate": 1e-4}
    channels = {
        name: Channel(name, time, size * rng.normal(size=time.size), name, "SI")
        for name, size in sizes.items()
    }
    standing = Drive("standing", (), channels, 0)
    monkeypatch.setattr("swaywatch.diagnose.fit.data.load_drives", lambda *_: [standing])
    loaded = load([Path("a.csv")], CASE / "vehicle.toml", CASE / "signals.toml")
    assert loaded.problem is None
    (text,) = loaded.cannot
    assert "in no stretch of 40 s does it drive at 5 m/s" in text
    assert _cannot(loaded)["verdict"] == "unexplained"
