"""Windows of a diagnosis: their forms, and where a course over time has them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from test_diagnose import effect, synthetic

from swaywatch.diagnose.evidence.evidence import least_gain
from swaywatch.diagnose.evidence.locate import (
    AmplitudeCourse,
    Locator,
    faint_windows,
    reformed,
    simplified,
    windows,
)
from swaywatch.diagnose.evidence.search import Search
from swaywatch.diagnose.fit.fit import EDGE_STEP_S, OBSERVER, Fit, Fitter, Problem
from swaywatch.diagnose.report.describe import _over_windows, _windows
from swaywatch.effects.active import ROOM_S, ActiveEffect
from swaywatch.effects.effect import RISE, Effect, Parameter, Window, library
from swaywatch.effects.library.axle_load_harmonic import generator_effect
from swaywatch.effects.library.sensor_roll_gravity import EFFECTS as GRAVITY_EFFECTS
from swaywatch.effects.roll import lag, seen
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import BODY, PlantInput

SIZE = Parameter("n", "N", 0.0, -1e4, 1e4, (1.0,), 1.0)
FORCE = Effect("push", "car", "physics", "", "", (SIZE,), windowed=True)


def _course(amplitude: list[float], error: list[float]) -> AmplitudeCourse:
    size = len(amplitude)
    return AmplitudeCourse(
        FORCE,
        (np.arange(size + 1.0),),
        (np.array(amplitude)[:, None],),
        (np.array(error)[:, None],),
        1.0,
    )


def _effect(name: str, form: str) -> Effect:
    return next(e for e in library() if e.name == name and e.extra.get("form") == form)


def test_ramps_are_at_half_at_the_edges_of_the_window() -> None:
    time = np.arange(0.0, 10.0, 0.01)
    window = Window(3.0, 6.0, {"rise_s": 1.0})
    value = window.ramped(time)
    assert value[[200, 450, 800]] == pytest.approx([0.0, 1.0, 0.0])
    assert np.interp([3.0, 6.0], time, value) == pytest.approx([0.5, 0.5], abs=0.02)
    assert np.sum(value) * 0.01 == pytest.approx(3.0, abs=0.02)
    sharp = Window(3.0, 6.0, {"rise_s": 0.0})
    assert np.abs(sharp.ramped(time) - sharp.mask(time)).max() < 0.51


def test_a_wild_amplitude_that_means_nothing_hides_no_window() -> None:
    quiet = [0.1, -0.2, 0.1, 0.2, -0.1]
    found = windows(_course([90.0, *quiet, 10.0, 9.0, 11.0, *quiet], [60.0, *[0.5] * 13]))
    assert found is not None
    assert found.values == pytest.approx((6.0, 9.0, 10.0))


def test_no_window_without_evidence() -> None:
    rng = np.random.default_rng(1)
    assert windows(_course(list(rng.normal(size=40)), [1.0] * 40)) is None


def test_a_gap_found_as_a_window_of_the_other_sign_splits_the_long_one() -> None:
    term = ActiveEffect(FORCE, (5.0, 15.0, 100.0, 9.0, 11.0, -95.0), (0, 0))
    assert simplified(term).values == (5.0, 9.0, 100.0, 11.0, 15.0, 100.0)


def test_windows_that_overlap_stay_and_those_that_touch_are_one() -> None:
    overlapping = ActiveEffect(FORCE, (5.0, 12.0, 100.0, 10.0, 15.0, 100.0), (0, 0))
    assert simplified(overlapping).values == overlapping.values
    touching = ActiveEffect(FORCE, (5.0, 10.0, 100.0, 10.2, 15.0, 100.0), (0, 0))
    assert simplified(touching).values == pytest.approx((5.0, 15.0, 100.0))


def test_another_form_keeps_the_windows_and_begins_what_it_adds() -> None:
    box, ramped = (_effect("crosswind_gust:car", form) for form in ("box", "ramped"))
    other = reformed(ActiveEffect(box, (2.0, 4.0, 300.0), (1,)), ramped, 1)
    assert other.values == (2.0, 4.0, 300.0, RISE.starts[1], 0.0)
    assert other.window_runs == (1,)


def _rolling(frequency: float, damping: float) -> Run:
    time = np.arange(0.0, 30.0, 0.01)
    force = 2000.0 * np.sin(4.0 * time) * np.exp(-((time - 12.0) ** 2) / 30.0)
    force[500:560] += 1500.0
    shift = 0.4 * lag(force - force.mean(), frequency, damping)
    channels = {f"wheel_lateral_force_{w}": 0.25 * force for w in ("fl", "fr", "rl", "rr")}
    channels |= {"hitch_lateral_force": np.zeros(time.size)}
    for side, sign in (("l", -0.25), ("r", 0.25)):
        channels |= {f"wheel_vertical_load_{end}{side}": 4000.0 + sign * shift for end in "fr"}
    return Run("run1", time, channels, {}, 16.0)


def test_the_lag_of_the_roll_is_read_from_the_wheel_loads() -> None:
    assert seen([_rolling(13.0, 0.112)]) == (13.0, 0.112)
    run = _rolling(20.0, 0.35)
    assert seen([run]) == (20.0, 0.35)
    del run.channels["hitch_lateral_force"]
    assert seen([run]) is None


def test_gravity_in_an_accelerometer_follows_the_centre_of_gravity() -> None:
    time = np.arange(0.0, 20.0, 0.01)
    yaw, ahead = 0.1 * np.sin(4.0 * time), -1.4
    of_the_body = 3.0 * np.sin(4.0 * time + 0.3)
    channel = "car_lateral_acceleration"
    measured = of_the_body + ahead * np.gradient(yaw) * 100.0
    outputs = {channel: measured.copy(), "car_yaw_rate": yaw}
    run = Run("run1", time, {}, {channel: ahead}, 16.0)
    effect = next(e for e in GRAVITY_EFFECTS if e.component == channel)
    values = {"roll_per_acceleration": 0.01, "roll_frequency_rad_s": 40.0, "roll_damping": 0.4}
    effect.observe(outputs, run, values)
    expected = measured + 9.81 * 0.01 * lag(of_the_body, 40.0, 0.4)
    assert outputs[channel] == pytest.approx(expected, abs=1e-9)


def _plant(time: np.ndarray) -> PlantInput:
    none = np.zeros(time.size)
    return PlantInput(0.01, none + 25.0, none, none, np.ones(len(BODY)))


def test_a_gust_turns_the_body_by_its_force_at_the_centre_of_pressure() -> None:
    time = np.arange(0.0, 8.0, 0.01)
    plant, run = _plant(time), Run("run1", time, {}, {}, 16.0)
    values = {"force_n": -800.0, "rise_s": 0.5, "arm_m": 0.6}
    _effect("crosswind_gust:trailer", "ramped").act(plant, run, {}, [Window(3.0, 5.0, values)])
    force, moment = plant.series["force_trailer"], plant.series["moment_trailer"]
    assert force.min() == pytest.approx(-800.0)
    assert moment == pytest.approx(0.6 * force)
    simple = _plant(time)
    box = Window(3.0, 5.0, {"force_n": 500.0})
    _effect("crosswind_gust:trailer", "box").act(simple, run, {}, [box])
    assert not np.any(simple.series["moment_trailer"])


def test_the_load_made_by_the_motion_has_the_gain_as_amplitude_whatever_the_offset() -> None:
    time = np.arange(0.0, 40.0, 0.01)
    rate = 0.02 * np.sin(2.0 * np.pi * 0.7 * time)
    found = []
    for offset in (0.0, 0.002):
        plant = _plant(time)
        run = Run("run1", time, {"car_yaw_rate": rate + offset}, {}, 16.0)
        window = Window(15.0, 25.0, {"gain_n": 600.0, "delay_s": 0.2})
        generator_effect("car_rear").act(plant, run, {}, [window])
        found.append(plant.series["load_car_rear"])
    load = found[0][(time > 16.0) & (time < 24.0)]
    # a mean over a second lets nearly all of the double frequency pass
    assert load.max() == pytest.approx(600.0, rel=0.05)
    assert load.min() == pytest.approx(-600.0, rel=0.05)
    assert found[1] == pytest.approx(found[0], abs=6.0)


def test_the_load_made_by_the_motion_may_be_asked_for_by_several_threads() -> None:
    time = np.arange(0.0, 20.0, 0.01)
    rate = 0.02 * np.sin(2.0 * np.pi * 0.7 * time)
    window = Window(5.0, 15.0, {"gain_n": 600.0, "delay_s": 0.2})

    class Interrupted(dict[str, np.ndarray]):
        """After the first values that are kept another thread asks."""

        left = 2

        def __setitem__(self, name: str, value: np.ndarray) -> None:
            super().__setitem__(name, value)
            if self.left:
                self.left -= 1
                generator_effect("car_rear").act(_plant(time), run, {}, [window])

    run = Run("run1", time, {"car_yaw_rate": rate}, {}, 16.0)
    run.simulated = Interrupted()
    plant, quiet = _plant(time), _plant(time)
    generator_effect("car_rear").act(plant, run, {}, [window])
    generator_effect("car_rear").act(quiet, replace(run, simulated={}), {}, [window])
    assert plant.series["load_car_rear"] == pytest.approx(quiet.series["load_car_rear"])


@pytest.fixture(scope="module")
def softer() -> Fitter:
    """Trailer tyres that are softer for some seconds of the first run, held by an observer."""
    term = ActiveEffect(effect("tyre_stiffness_change:trailer"), (12.0, 23.0, 0.8), (0,))
    return Fitter(replace(synthetic((term,), seed=3), observer=OBSERVER), fine=False)


def _fitted(fitter: Fitter, values: tuple[float, ...], iterations: int) -> tuple[float, ...]:
    start = fitter.start()
    term = ActiveEffect(effect("tyre_stiffness_change:trailer"), values, (0,))
    fit = fitter.run(Fit((term,), start.nuisance, start.shift), iterations, tolerance=1e-6)
    return fit.terms[0].values


def test_an_edge_beyond_the_recording_is_moved_to_its_end(softer: Fitter) -> None:
    time = softer.problem.runs[0].time
    start, stop, factor = _fitted(softer, (-1e9, 1e9, 0.9), 1)
    assert time[0] <= start < stop <= time[-1]
    assert factor < 1.0


def test_an_edge_moves_a_little_in_one_iteration(softer: Fitter) -> None:
    start = (10.0, 21.0, 0.95)
    moved = np.abs(np.subtract(_fitted(softer, start, 1), start))[:2]
    assert 0.5 * EDGE_STEP_S < moved.max() <= EDGE_STEP_S + 1e-12


def test_what_rises_gradually_may_have_begun_before_the_recording() -> None:
    run = Run("run1", np.arange(5.0, 30.0, 0.01), {}, {}, 16.0)
    for form, room in (("box", 0.0), ("half_sine", ROOM_S)):
        gust = _effect("crosswind_gust:car", form)
        values = (0.0, 1e9, *(p.neutral for p in gust.parameters))
        term = ActiveEffect(gust, values, (0,))
        start, stop, size = (term.bounded(i, [run]) for i in range(3))
        assert start == replace(start, low=5.0 - room, high=float(run.time[-1]) + room)
        assert (stop.low, stop.high) == (start.low, start.high)
        assert size == gust.parameters[0]


def _faint(amplitude: np.ndarray) -> AmplitudeCourse:
    """Pulses of two values, each known to 10 N, whose mean nobody knows."""
    pulses, values = amplitude.shape
    both = replace(FORCE, parameters=(SIZE,) * values)
    level = np.kron(np.full((pulses, pulses), 1.0 / pulses), np.eye(values))
    information = 0.01 * (np.eye(amplitude.size) - level)
    course = _course([0.0] * pulses, [10.0] * pulses)
    return replace(
        course, effect=both, amplitude=(amplitude,), error=(np.full(amplitude.shape, 10.0),),
        information=(information,), toward=(information @ amplitude.ravel(),),
    )  # fmt: skip


def test_weak_pulses_of_one_sign_are_a_window_together() -> None:
    """None of them is sure, and all lie over a level that the vehicle's own values leave open."""
    amplitude = np.full((36, 2), 5.0)
    amplitude[8:13] += (-30.0, 10.0)
    amplitude[25:29] += (-30.0, 10.0)
    course = _faint(amplitude)
    assert windows(course) is None
    found = faint_windows(course, 25.0)
    assert found is not None
    assert found.values == pytest.approx((8.0, 13.0, -30.0, 10.0, 25.0, 29.0, -30.0, 10.0))
    assert faint_windows(course, 60.0) is None


def test_what_lasts_most_of_a_run_is_no_window() -> None:
    amplitude = np.zeros((36, 2))
    amplitude[:17] += 30.0
    found = faint_windows(_faint(amplitude), 25.0)
    assert found is not None
    assert found.values[:2] == (0.0, 17.0)
    assert faint_windows(_faint(np.full((36, 2), 30.0)), 1e-6) is None


@pytest.mark.parametrize(("factor", "begun"), [(0.99, False), (0.97, True)])
def test_no_windows_are_begun_that_could_not_be_claimed(factor: float, begun: bool) -> None:
    """One effect is more than chance in both, but only one takes away as much as a claim needs."""
    softer = effect("tyre_stiffness_change:trailer")
    problem = synthetic((ActiveEffect(softer, (12.0, 17.0, factor), (0,)),), seed=3)
    search = Search(problem, library(), lambda stage, share: None)
    near = search._near(search.baseline().fit)
    course = Locator(search.close, near).course(softer)
    assert course.gain > 2.0 * np.log(len(search.effects)) + search._by_chance(course)
    least = least_gain(near, near, windowed=True, on_springs=False)
    assert (course.gain > least) is begun
    tried: list[AmplitudeCourse] = []
    search.rough = lambda locator, course: tried.append(course)  # type: ignore[method-assign]
    assert search._windowed(near, [softer]) == []
    assert bool(tried) is begun


def test_a_small_window_beside_a_larger_one_is_no_swing_of_its_own() -> None:
    rows = ((10.0, 14.0, 900.0), (11.0, 12.0, -250.0), (14.5, 15.0, 200.0), (16.0, 17.0, 200.0),
            (20.0, 21.0, 400.0))  # fmt: skip
    term = ActiveEffect(FORCE, tuple(x for row in rows for x in row), (0, 0, 0, 0, 0))
    own = term.without_remainders(0.35, 1.0)
    assert [w.start for w in own.windows(0)] == [10.0, 16.0, 20.0]
    apart = replace(term, window_runs=(0, 1, 1, 0, 0))  # of another run
    assert [w.start for w in apart.without_remainders(0.35, 1.0).windows(1)] == [11.0, 14.5]
    assert own.without_remainders(0.35, 1.0) is own


def _reported_of(effect: Effect, values: tuple[float, ...], errors: list[float]) -> dict[str, Any]:
    """Reported values of windows in one run, with the standard errors of the fitted ones."""
    run = _rolling(13.0, 0.112)
    count = len(values) // (2 + len(effect.parameters))
    term = ActiveEffect(effect, values, (0,) * count)
    problem = cast("Problem", SimpleNamespace(runs=(run,)))
    windows = _windows(term, problem)
    covariance = np.diag(np.square(np.tile(errors, count)))
    return _over_windows(term, problem, effect.id, windows, covariance, 1.0) | {"all": windows}


def test_windows_to_both_sides_have_a_typical_size_not_one_near_nothing() -> None:
    gust = _effect("crosswind_gust:trailer", "box")
    found = _reported_of(
        gust, (2.0, 4.0, 300.0, 8.0, 9.0, -280.0, 12.0, 14.0, 310.0), [0.0, 0.0, 5.0]
    )
    assert found["force_n"]["value"] == pytest.approx(300.0)
    assert found["force_n"]["low"] < 300.0 < found["force_n"]["high"]
    assert [w["intervals"]["force_n"][0] < w["force_n"] for w in found["all"]] == [True] * 3


def test_how_windows_differ_widens_an_interval_once() -> None:
    """What was seen needs no factor for what a fit does not know of its own errors."""
    gust = _effect("crosswind_gust:trailer", "box")
    same, differ = (
        _reported_of(gust, (2.0, 4.0, a, 8.0, 10.0, b), [0.0, 0.0, 1.0])["force_n"]
        for a, b in ((400.0, 400.0), (300.0, 500.0))
    )
    half = [0.5 * (row["high"] - row["low"]) for row in (same, differ)]
    assert half[1] == pytest.approx(np.hypot(half[0], 1.645 * 100.0), rel=1e-6)


def test_an_amplitude_is_as_exact_as_its_parts_whichever_of_them_is_none() -> None:
    """Its error was that of the part in phase over that part: without end where it is none."""
    load = next(
        e for e in library() if e.name == "axle_load_harmonic:car_rear" and len(e.parameters) == 2
    )
    found = _reported_of(load, (10.0, 14.0, 0.01, 400.0), [0.0, 0.0, 6.0, 6.0])
    assert found["amplitude_n"]["value"] == pytest.approx(400.0, rel=1e-3)
    assert found["amplitude_n"]["standard_error"] == pytest.approx(6.0, rel=0.02)
    assert found["phase_deg"]["standard_error"] == pytest.approx(np.degrees(6.0 / 400.0), rel=0.02)
