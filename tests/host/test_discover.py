"""Laws beyond the library: slots of the plant and the search for them."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import bilinear, lfilter
from sprung_pairs import SPACING, constants, manoeuvre
from test_diagnose import BODY_VALUES, synthetic

from swaywatch.diagnose.evidence.baselines import Path as Tried
from swaywatch.diagnose.evidence.search import Candidate, Search
from swaywatch.diagnose.fit.fit import Fit
from swaywatch.diagnose.fit.holdout import typical
from swaywatch.diagnose.model import _entries, terms_of
from swaywatch.discover.begin import in_form, initial, law_in
from swaywatch.discover.effect import effect_of
from swaywatch.discover.find import (
    Discovery,
    _beside_what_suffices,
    _left_out_evidence,
    _likelier,
)
from swaywatch.discover.forms import curve
from swaywatch.discover.grammar import all_laws, plainer, products, refined
from swaywatch.discover.inputs import followed, missing_inputs
from swaywatch.discover.law import MOTIONS, ROLLS, SHAPES, Law, law_of
from swaywatch.discover.save import named, read_physics, save_law
from swaywatch.discover.sentences import energy, sentence, suggestion
from swaywatch.discover.trial import SWINGING, LawSearch
from swaywatch.discover.way import HALF_TRACK_M, driven, stretch
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library
from swaywatch.effects.runs import Run
from swaywatch.errors import SwaywatchError
from swaywatch.models.multibody import Multibody
from swaywatch.models.multibody_vehicle import Inputs, Physics, reference_combination
from swaywatch.plant.lanes import (
    ALL,
    BODY,
    LAW_OF,
    LAW_TO,
    OUTPUT,
    SCALARS,
    Job,
    PlantInput,
    neutral,
    run_jobs,
    simulate,
)  # fmt: skip
from swaywatch.plant.sprung import defaults

SPEED = 28.0
YAW = [OUTPUT.index(name) for name in ("car_yaw_rate", "trailer_yaw_rate", "hitch_y")]


def plant(**slots: float) -> PlantInput:
    """A slalom of the reference combination with slots of the plant set."""
    time = np.arange(0.0, 12.0, 0.01)
    steer = 0.02 * np.sin(2.0 * np.pi * 0.55 * time) * np.clip(time, 0.0, 1.0)
    found = PlantInput(
        0.01, np.full(time.size, SPEED), np.zeros(time.size), steer, BODY_VALUES.copy(), neutral()
    )
    for name, value in slots.items():
        found.scalar(name, value)
    return found


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """RMS over the RMS of the first, the worst of the yaw rates and the hitch force."""
    parts = [np.std(one[:, i] - other[:, i]) / np.std(one[:, i]) for i in YAW]
    return float(max(parts))


def test_a_law_of_the_articulation_rate_is_the_hitch_damper() -> None:
    named_ = simulate(plant(hitch_damping=900.0))
    law = simulate(plant(law_gain=900.0, law_of_articulation_rate=1.0, law_to_hitch=1.0))
    assert difference(named_, law) < 1e-9
    assert difference(named_, simulate(plant())) > 0.01


def test_a_law_of_steering_is_another_steering_ratio() -> None:
    other = plant()
    other.steer = 1.05 * other.steer
    law = plant(law_gain=0.05, law_of_steer=1.0, law_to_slip_car_front=1.0)
    assert difference(simulate(other), simulate(law)) < 1e-3


def test_a_law_of_the_cars_heading_steers_with_it() -> None:
    law = plant()
    effect_of(Law("slip_car_front", "heading_car")).act(law, None, {"gain": -0.05}, ())
    moved = simulate(law)
    heading = np.cumsum(moved[:, OUTPUT.index("car_yaw_rate")]) * 0.01
    other = plant()
    other.steer = other.steer - 0.05 * heading
    assert difference(simulate(other), moved) < 5e-3
    assert difference(simulate(plant()), moved) > 0.02


def test_what_is_off_or_on_is_of_one_size_beyond_a_limit() -> None:
    z = np.array([-0.3, -0.11, -0.08, 0.0, 0.08, 0.11, 0.3])
    on = curve("switched", z, 0.1)
    assert on == pytest.approx([-0.1, -0.088, -0.0018, 0.0, 0.0018, 0.088, 0.1], abs=1e-3)
    pushed = plant()
    pushed.add_series("moment_car", 5e4 * curve("switched", pushed.steer, 0.01))
    law = plant(
        law_gain=5e4, law_of_steer=1.0, law_to_moment_car=1.0, law_shape=18.0, law_bend=0.01
    )  # fmt: skip
    assert difference(simulate(pushed), simulate(law)) < 5e-3
    assert difference(simulate(plant()), simulate(law)) > 0.02


def test_wheels_that_give_way_all_the_way_are_softer_tyres() -> None:
    """Within the play nothing but the rest of the slip makes force: -0.3 of it is 30 % softer."""
    gives = plant(
        law_gain=-0.3, law_of_slip_trailer=1.0, law_to_slip_trailer=1.0, law_shape=1.0,
        law_bend=50.0,
    )  # fmt: skip
    softer = plant()
    for end in ("front", "rear"):
        softer.body[BODY.index(f"trailer.{end}_cornering_stiffness")] *= 0.7
    # the slip of two axles is their mean
    assert difference(simulate(softer), simulate(gives)) < 0.05
    assert difference(simulate(plant()), simulate(gives)) > 0.1
    car = plant(law_gain=-0.3, law_of_slip_car_rear=1.0, law_to_slip_car_rear=1.0)
    softer = plant()
    softer.body[BODY.index("car.rear_cornering_stiffness")] *= 0.7
    assert difference(simulate(softer), simulate(car)) < 1e-9


def test_wheels_that_give_way_ever_more_are_tyres_that_grow_softer() -> None:
    """The slot of the stiffness, over the way, against the law; and a force that comes with it."""
    gives, softer = plant(), plant()
    time = np.arange(0.0, 12.0, 0.01)
    run = Run("r", time, {}, {}, 15.0, speed=gives.speed)
    law = Law("slip_car_rear", "slip_car_rear", response="growing")
    effect_of(law).act(gives, run, {"gain": -0.5, "over_m": 100.0}, ())
    share = 1.0 - np.exp(-np.cumsum(gives.speed) * 0.01 / 100.0)
    softer.add_series("stiffness_car_rear", -0.5 * share)
    assert difference(simulate(softer), simulate(gives)) < 1e-6
    assert difference(simulate(plant()), simulate(gives)) > 0.05
    pushed, comes = plant(), plant()
    effect_of(Law("hitch", "distance", response="growing")).act(
        comes, run, {"gain": 900.0, "over_m": 100.0}, ()
    )
    pushed.add_series("moment_car", 900.0 * share)
    pushed.add_series("moment_trailer", -900.0 * share)
    assert difference(simulate(pushed), simulate(comes)) < 1e-9
    # a part of a recording goes on where the one before it ended
    assert np.allclose(driven(run.part(500, 900)), driven(run)[500:900], rtol=2e-3)


def test_a_law_of_two_slopes_has_a_line_and_one_side_as_its_ends() -> None:
    spring = {"law_gain": 6e3, "law_of_articulation": 1.0, "law_to_hitch": 1.0}
    even, one = (simulate(plant(**spring, law_shape=11.0, law_bend=b)) for b in (1.0, 0.0))
    assert difference(simulate(plant(**spring)), even) < 1e-9
    assert difference(simulate(plant(**spring, law_shape=8.0)), one) < 1e-9
    z = np.array([-2.0, -1.0, 0.0, 1.0])
    assert curve("uneven", z, 0.5) == pytest.approx([-1.0, -0.5, 0.0, 1.0])
    law = Law("hitch", "articulation", "uneven")
    rows = {
        name: {"value": value, "low": 0.9 * value, "high": 1.1 * value}
        for name, value in (("gain", 6000.0), ("other_side", 0.5))
    }
    assert "0.500 +- 0.050 times as much while that is negative" in sentence(law, rows)


def test_what_waits_for_a_swing_does_nothing_before_and_everything_after() -> None:
    damps = {"law_gain": 4e3, "law_of_articulation_rate": 1.0, "law_to_hitch": 1.0}
    waits = damps | {"law_shape": 10.0}
    base, always = simulate(plant()), simulate(plant(**damps))
    assert difference(base, simulate(plant(**waits, law_bend=1.0))) < 1e-6  # it never swings so far
    assert difference(always, simulate(plant(**waits, law_bend=1e-6))) < 0.01
    # a law that has to swing beyond 0.1 rad/s acts from then on, also where the rate goes through 0
    found = simulate(plant(**waits, law_bend=0.1))
    rate = found[:, YAW[1]] - found[:, YAW[0]]
    moment = 4e3 * curve("waiting", rate, 0.1)
    begins = int(np.argmax(np.abs(moment) > 100.0))
    assert np.max(np.abs(rate[:begins])) > 0.09
    assert difference(base[: begins - 5], found[: begins - 5]) < 1e-3
    assert np.corrcoef(rate[begins + 100 :], moment[begins + 100 :])[0, 1] > 0.999


def test_a_force_against_what_a_body_feels_is_a_mass() -> None:
    felt = {"law_of_lateral_acceleration_trailer": 1.0, "law_to_force_trailer": 1.0}
    heavier = plant()
    heavier.body[BODY.index("trailer.mass")] += 60.0
    law = plant(law_gain=-60.0, **felt, law_lag=0.02, law_transient=3.0)
    assert difference(simulate(plant()), simulate(heavier)) > 0.02
    assert difference(simulate(heavier), simulate(law)) < 0.01


def test_an_axle_can_steer_with_the_force_on_the_ball() -> None:
    """Late by the lag: as if the force of the same drive were known before."""
    lag, gain = 0.1, 1e-7
    base = simulate(plant())
    before = plant()
    steers = gain * (base[:, OUTPUT.index("hitch_y")])
    kept = np.exp(-0.01 / lag)
    before.add_series("slip_car_rear", lfilter([1.0 - kept], [1.0, -kept], steers))
    law = plant(
        law_gain=gain, law_of_hitch_force=1.0, law_to_slip_car_rear=1.0, law_lag=lag,
        law_transient=3.0,
    )  # fmt: skip
    moved = (simulate(before) - base)[:, YAW]
    law_moved = (simulate(law) - base)[:, YAW]
    assert np.all(np.std(moved, axis=0) > 1e-6)
    assert np.all(np.std(law_moved - moved, axis=0) < 0.05 * np.std(moved, axis=0))


def test_an_actuator_goes_no_faster_than_it_can() -> None:
    acts = {"law_gain": 2e4, "law_of_articulation": 1.0, "law_to_moment_car": 1.0}
    hurries = acts | {"law_shape": 12.0}
    quick = simulate(plant(**hurries, law_bend=1e3))
    assert difference(simulate(plant(**acts, law_lag=0.05)), quick) < 1e-9
    assert difference(simulate(plant()), simulate(plant(**hurries, law_bend=1e-9))) < 1e-6
    followed = curve("limited rate", np.sin(np.arange(0.0, 20.0, 0.01)), 0.5)
    assert np.max(np.abs(np.diff(followed))) == pytest.approx(0.005)
    slow = simulate(plant(**hurries, law_bend=0.05))
    assert difference(quick, slow) > 0.01


def test_a_link_with_play_follows_what_is_beyond_it() -> None:
    drive = np.sin(np.arange(0.0, 20.0, 0.01))
    followed = curve("lost motion", drive, 0.3)
    assert np.max(followed[1000:]) == pytest.approx(0.7, abs=0.005)
    turns = followed[np.argmax(followed[500:]) + 500 :][:100]
    assert np.ptp(turns) < 1e-3  # it waits while the play is passed through
    acts = {"law_gain": 0.5, "law_of_steer": 1.0, "law_to_slip_car_rear": 1.0}
    plays = acts | {"law_shape": 14.0}
    late = simulate(plant(**acts, law_lag=0.02))
    assert difference(late, simulate(plant(**plays, law_bend=1e-9))) < 1e-6
    assert difference(simulate(plant()), simulate(plant(**plays, law_bend=1.0))) == 0.0
    series = plant()
    series.add_series("slip_car_rear", 0.5 * curve("lost motion", series.steer, 0.004))
    assert difference(late, simulate(series)) > 0.05
    assert difference(simulate(series), simulate(plant(**plays, law_bend=0.004))) < 0.01


def test_friction_that_falls_holds_half_as_much_at_its_bend() -> None:
    fast, slow = curve("falling", np.array([0.5, 0.02]), 0.5)
    assert fast == pytest.approx(0.25, rel=1e-3)
    assert slow == pytest.approx(0.5 * np.tanh(0.32), rel=1e-2)
    falls = {
        "law_gain": 5e4, "law_of_steer": 1.0, "law_to_moment_car": 1.0, "law_shape": 15.0,
        "law_bend": 0.01,
    }  # fmt: skip
    series = plant()
    series.add_series("moment_car", 5e4 * curve("falling", series.steer, 0.01))
    assert difference(simulate(plant()), simulate(series)) > 0.05
    assert difference(simulate(series), simulate(plant(**falls))) < 1e-4


@pytest.mark.parametrize(("shape", "number"), [("positive stop", 16.0), ("negative stop", 17.0)])
def test_a_stop_on_one_side_has_slack(shape: str, number: float) -> None:
    acts = {"law_gain": 2e4, "law_of_articulation": 1.0, "law_to_hitch": 1.0, "law_bend": 0.0}
    taut = simulate(plant(**acts, law_shape=number - 8.0))  # of one side only
    assert difference(taut, simulate(plant(**acts, law_shape=number))) < 1e-6
    assert difference(simulate(plant()), taut) > 0.02
    slack = acts | {"law_shape": number, "law_bend": 0.01}
    assert difference(taut, simulate(plant(**slack))) > 0.01
    z = np.array([-0.03, -0.01, 0.0, 0.01, 0.03])
    side = z > 0.0 if shape == "positive stop" else z < 0.0
    assert curve(shape, z, 0.02) == pytest.approx(curve("dead zone", z, 0.02) * side)
    law = Law("hitch", "articulation", shape)
    assert plainer(law) == Law("hitch", "articulation", shape.replace("stop", "side"))


def test_friction_follows_what_has_no_rate_of_its_own() -> None:
    """Its rate is seen from where it was a moment ago."""
    sticks = {"law_gain": 0.3, "law_of_steer": 1.0, "law_to_slip_car_front": 1.0, "law_shape": 6.0}
    dragged = plant()
    dragged.add_series("slip_car_front", 0.3 * curve("hysteretic", dragged.steer, 0.008))
    assert difference(simulate(plant()), simulate(dragged)) > 0.1
    assert difference(simulate(dragged), simulate(plant(**sticks, law_bend=0.008))) < 0.05


@pytest.mark.parametrize("shape", ["hysteretic", "lost motion", "limited rate", "waiting"])
def test_what_keeps_something_follows_what_is_felt(shape: str) -> None:
    """What the law felt in one simulation, as a force of time, gives the same simulation."""
    felt = {"law_of_hitch_force": 1.0, "law_lag": 0.05, "law_transient": 3.0}
    bend = 900.0 if shape == "limited rate" else 300.0
    kept = {"law_shape": float(SHAPES.index(shape)), "law_bend": bend}
    found = simulate(plant(law_gain=3e-6, law_to_slip_car_rear=1.0, **felt, **kept))
    ahead, back = bilinear([1.0], [0.05, 1.0], 100.0)
    late = np.asarray(lfilter(ahead, back, found[:, OUTPUT.index("hitch_y")]))
    series = plant()
    series.add_series("slip_car_rear", 3e-6 * curve(shape, late, bend))
    acted = difference(found, simulate(plant()))
    assert acted > 0.04
    assert difference(found, simulate(series)) < 0.15 * acted


def test_an_oscillator_that_follows_a_motion_overshoots_as_one_does() -> None:
    follows = Law("force_trailer", "steer", response="oscillating")
    values = {"gain": 3e4, "frequency_hz": 1.5, "damping_ratio": 0.15}
    law, series = plant(), plant()
    effect_of(follows).act(law, Run("r", np.zeros(1), {}, {}, 15.0), values, ())
    series.add_series("force_trailer", 3e4 * followed(series.steer, 1.5, 0.15))
    assert difference(simulate(series), simulate(plant())) > 0.05
    assert difference(simulate(series), simulate(law)) < 1e-4


def test_an_oscillator_that_creeps_is_a_lag_and_a_pressed_library_law_is_no_plain_one() -> None:
    creeps = Law("force_trailer", "sideslip_trailer", power=2, response="oscillating")
    assert plainer(creeps) == replace(creeps, response="lagged")
    assert plainer(Law("moment_car", "steer", by="hitch_force")) == Law("moment_car", "steer")
    assert plainer(Law("hitch", "articulation_rate", "saturating", by="hitch_force")) is None


def test_wheels_that_drag_on_one_side_hold_the_trailer_back() -> None:
    """The same moment, and a pull at the ball, which is not across the car in a bend."""
    moment = Law("moment_trailer", "yaw_rate_trailer", "dead zone")
    drags = replace(moment, place="drag_trailer")
    assert drags in refined(moment)
    assert drags not in all_laws()
    assert replace(moment, place="drag_trailer", shape="saturating") in refined(drags)
    run = Run("r", np.zeros(1), {}, {}, 15.0)
    found = []
    for law in (moment, drags):
        slots = plant()
        effect_of(law).act(slots, run, {"gain": -3e4, "bend": 0.01}, ())
        found.append(simulate(slots))
    assert difference(simulate(plant()), found[0]) > 0.03
    assert difference(*found) > 1e-3
    along = OUTPUT.index("hitch_x")
    pull = found[1][:, along] - found[0][:, along]
    yaw = found[1][:, OUTPUT.index("trailer_yaw_rate")]
    said = 3e4 * np.maximum(np.abs(yaw) - 0.01, 0.0) / HALF_TRACK_M
    assert np.max(said) > 500.0
    assert np.max(np.abs(np.abs(pull) - said)) < 0.1 * np.max(said)
    assert "side" in sentence(drags, _rows(drags))
    assert "forward motion" in energy(drags, -3e4)
    assert "brakes" in suggestion(drags, -3e4)


def _rows(law: Law) -> dict[str, dict[str, float]]:
    """Values as a report has them."""
    starts = {p.name: p.starts[0] for p in effect_of(law).parameters}
    return {name: {"value": v, "low": 0.9 * v, "high": 1.1 * v} for name, v in starts.items()}


def test_the_size_of_another_motion_multiplies_a_law() -> None:
    """A moment by the size of the articulation, times its sign, is the plain one."""
    line = Law("moment_trailer", "articulation")
    run = Run("r", np.zeros(1), {}, {}, 15.0)
    found = []
    for law, gain in ((replace(line, by="articulation"), 4e5), (line, 4e5)):
        slots = plant()
        effect_of(law).act(slots, run, {"gain": gain}, ())
        slots.scalar("law_shape", 0.0 if law.by else 4.0)  # odd square
        found.append(simulate(slots))
    assert difference(*found) < 1e-9
    assert difference(found[0], simulate(plant())) > 0.03


def test_the_size_of_another_motion_levels_off_or_begins_late() -> None:
    """It levels off at one, or is nothing up to a bend: at the ends that is all, and nothing."""
    line = Law("moment_trailer", "articulation_rate")
    run = Run("r", np.zeros(1), {}, {}, 15.0)

    def driven(law: Law, **values: float) -> np.ndarray:
        slots = plant()
        effect_of(law).act(slots, run, {"gain": -4e3} | values, ())
        return simulate(slots)

    levels, late = (replace(line, by="articulation", side=s) for s in ("levels off", "beyond"))
    alone, none = driven(line), simulate(plant())
    assert difference(driven(levels, by_bend=1e-5), alone) < 1e-3
    assert difference(driven(levels, by_bend=10.0), none) < 1e-3
    assert difference(driven(late, by_bend=1.0), none) < 1e-9
    small = driven(replace(line, by="articulation"), gain=-8e4)
    assert difference(driven(late, by_bend=1e-6, gain=-8e4), small) < 1e-3
    for law in (levels, late):
        within = driven(law, by_bend=0.02, gain=-4e3 if law is levels else -8e4)
        assert difference(within, none) > 0.01
        assert difference(within, alone) > 0.01


def test_a_size_is_tried_as_one_that_levels_off_and_back() -> None:
    friction = Law("hitch", "articulation_rate", "saturating", by="articulation")
    levels, late = (replace(friction, side=s) for s in ("levels off", "beyond"))
    assert {levels, late} < set(refined(friction))
    assert not {levels, late} & set(refined(levels))
    assert plainer(levels) == plainer(late) == friction
    assert law_of(levels.spec) == levels
    assert law_of(late.spec) == late
    term = ActiveEffect(effect_of(friction), (4e5, 0.004))
    usual = MOTIONS["articulation"].usual
    assert in_form(term, levels).as_dict()["gain"] == pytest.approx(4e5 * usual)
    assert in_form(term, late).as_dict()["gain"] == 4e5
    assert in_form(in_form(term, levels), friction).as_dict()["gain"] == pytest.approx(4e5)


@pytest.mark.parametrize("body", ["car", "trailer"])
def test_the_roll_of_a_rigid_body_multiplies_a_law_too(body: str) -> None:
    law = Law("hitch", "articulation_rate", by=f"roll_{body}")
    run = Run("r", np.zeros(1), {}, {}, 15.0)
    slots, other = plant(), plant()
    effect_of(law).act(slots, run, {"gain": 2e6}, ())
    effect_of(replace(law, by="steer")).act(other, run, {"gain": 2e6}, ())
    found = simulate(slots)
    assert difference(found, simulate(plant())) > 0.03
    together = run_jobs([Job(one, columns=ALL) for one in (other, slots, other)])
    assert np.array_equal(together[1].output, found)
    assert np.array_equal(together[0].output, simulate(other))


def test_a_line_with_its_cube() -> None:
    z = np.array([-1.0, 0.5, 1.0])
    assert curve("line and cube", z, -4.0) == pytest.approx([3.0, 0.0, -3.0])
    line = {"law_gain": 6e3, "law_of_articulation": 1.0, "law_to_hitch": 1.0}
    bent = line | {"law_shape": 13.0}
    assert difference(simulate(plant(**line)), simulate(plant(**bent, law_bend=0.0))) == 0.0
    # so much of a cube that the line is nothing beside it
    cube = plant(**(line | {"law_shape": 3.0, "law_gain": 6e6}))
    most = plant(**(bent | {"law_gain": 1.0, "law_bend": 6e6}))
    assert difference(simulate(cube), simulate(most)) < 1e-4


def test_a_force_at_a_place_turns_its_body_too() -> None:
    """With the sideslip of that place: against its tyres it takes the front axle away."""
    softer = plant()
    stiffness = float(softer.body[BODY.index("trailer.front_cornering_stiffness")])
    softer.body[BODY.index("trailer.front_cornering_stiffness")] = 0.9 * stiffness
    ahead = float(softer.body[BODY.index("trailer.front_axle_to_cog")])
    assert ahead > 0.1
    acting = plant()
    run = SimpleNamespace(speed=np.full(3, SPEED), time=np.zeros(3))
    law = Law("at_trailer", "sideslip_there", "saturating")
    values = {"gain": 0.1 * stiffness, "bend": 50.0, "ahead_m": ahead}
    effect_of(law).act(acting, run, values, ())
    assert difference(simulate(plant()), simulate(softer)) > 0.02
    assert difference(simulate(softer), simulate(acting)) < 0.002


def test_grip_that_comes_and_goes_is_a_factor_on_the_stiffness() -> None:
    law = Law("slip_trailer", "slip_trailer", response="periodic")
    run = SimpleNamespace(
        name="run1", time=np.arange(0.0, 10.0, 0.01), speed=np.full(1000, 25.0), channels={}
    )
    gripping = effect_of(law, runs=(stretch(run),))
    values = {"gain": 0.3, "repetitions_per_km": 40.0, "phase_1_rad": 0.5}
    found = plant()
    gripping.act(found, run, values, ())
    assert set(found.series) == {"stiffness_trailer_front", "stiffness_trailer_rear"}
    assert np.max(found.series["stiffness_trailer_rear"]) == pytest.approx(0.3, abs=1e-3)
    parameters = {
        name: {"value": value, "low": 0.9 * value, "high": 1.1 * value}
        for name, value in values.items()
    }
    text = sentence(law, parameters)
    assert text.startswith("the cornering stiffness of the trailer's tyres comes and goes by 30")
    assert "every 25.0 m" in text
    assert "adds no force" in energy(law, 0.3)


@pytest.mark.parametrize("place", LAW_TO)
def test_every_place_acts(place: str) -> None:
    size = 0.5 if place.startswith("slip") else 2e4
    slots = {"law_gain": size, "law_of_yaw_rate_trailer": 1.0, f"law_to_{place}": 1.0}
    assert difference(simulate(plant(**slots)), simulate(plant())) > 1e-3


def test_shapes_and_speed() -> None:
    straight = {"law_gain": 6e3, "law_of_articulation": 1.0, "law_to_hitch": 1.0}
    base = simulate(plant(**straight))
    wide = {"law_shape": 1.0, "law_bend": 50.0}
    assert difference(base, simulate(plant(**straight, **wide))) < 1e-4  # tanh of next to nothing
    dead = simulate(plant(**straight, law_shape=2.0, law_bend=1.0))
    assert difference(simulate(plant()), dead) < 1e-12  # never beyond its zone
    faster = plant(**straight, law_speed_power=2.0)
    equal = plant(**(straight | {"law_gain": 6e3 * (SPEED / 25.0) ** 2}))
    assert difference(simulate(faster), simulate(equal)) < 1e-9
    slower = plant(**straight, law_speed_power=-1.0)
    equal = plant(**(straight | {"law_gain": 6e3 * 25.0 / SPEED}))
    assert difference(simulate(slower), simulate(equal)) < 1e-9
    sticks = {"law_shape": 6.0}
    assert difference(base, simulate(plant(**straight, **sticks, law_bend=1e3))) < 1e-3
    slips = simulate(plant(**straight, **sticks, law_bend=0.002))
    assert difference(base, slips) > 1e-3
    late = simulate(plant(**straight, law_lag=0.0005))
    assert difference(base, late) < 0.02  # held at its shortest lag
    assert difference(base, simulate(plant(**straight, law_lag=0.4))) > 0.005


@pytest.mark.parametrize("sprung", [False, True])
def test_friction_follows_a_roll_too(sprung: bool) -> None:
    """Without springs roll exists only where something needs it: a law of it does."""
    steers = {"law_gain": 0.3, "law_of_roll_trailer": 1.0, "law_to_slip_trailer": 1.0}
    values = defaults(BODY_VALUES)
    on = {name: values[name] for name in SCALARS if sprung and name in values}
    base = simulate(plant(**on))
    named_ = simulate(plant(**on, roll_steer_trailer=0.3))
    law = simulate(plant(**on, **steers))
    assert difference(base, named_) > 0.02
    assert difference(named_, law) < 1e-9
    held = simulate(plant(**on, **steers, law_shape=6.0, law_bend=1e3))
    assert difference(law, held) < 5e-3
    assert difference(law, simulate(plant(**on, **steers, law_shape=6.0, law_bend=1e-3))) > 0.01


def test_friction_that_grows_with_a_deflection_damps_alike_at_any_size() -> None:
    """Over a cycle it takes away 2 gain A^2, as a damper of 2 gain / (pi omega) does."""
    time = np.arange(0.0, 12.0, 0.01)
    omega = 2.0 * np.pi * 0.55
    rubs = {"law_gain": 2000.0, "law_of_articulation": 1.0, "law_to_hitch": 1.0}
    damper = 2.0 * 2000.0 / (np.pi * omega)
    for size in (0.5, 1.0):
        found = []
        for slots in (rubs | {"law_shape": 7.0}, {"hitch_damping": damper}, {}):
            driven = plant(**slots)
            driven.steer = size * 0.02 * np.sin(omega * time) * np.clip(time, 0.0, 1.0)
            found.append(simulate(driven))
        assert difference(found[2], found[0]) > 0.01
        assert difference(found[1], found[0]) < 0.35 * difference(found[2], found[0])


def test_neutral_slots_are_those_of_the_plant_without_laws() -> None:
    assert all(neutral()[SCALARS.index(f"law_of_{name}")] == 0.0 for name in LAW_OF)
    with_places = plant(law_of_articulation=1.0, law_to_hitch=1.0)  # but no gain
    assert difference(simulate(plant()), simulate(with_places)) == 0.0


def test_what_a_law_forgets_within_no_time_is_its_rate() -> None:
    """A moment against what a yaw rate has changed within a short lag is a larger inertia."""
    gyro = plant(
        law_gain=-40000.0, law_of_yaw_rate_trailer=1.0, law_to_moment_trailer=1.0, law_lag=0.01,
        law_transient=1.0,
    )  # fmt: skip
    heavier = plant()
    heavier.body[BODY.index("trailer.yaw_inertia")] += 400.0
    assert difference(simulate(heavier), simulate(gyro)) < 0.01
    assert difference(simulate(plant()), simulate(gyro)) > 0.05
    ahead = plant()
    effect_of(Law("slip_car_front", "steer_rate")).act(ahead, None, {"gain": 0.05}, ())
    shifted = plant()
    shifted.steer = shifted.steer + 0.05 * np.gradient(shifted.steer, 0.01)
    assert difference(simulate(shifted), simulate(ahead)) < 0.03
    assert difference(simulate(plant()), simulate(ahead)) > 0.1


def test_a_load_that_comes_loose_swings_as_slowly_in_the_end_as_what_still_holds_it_says() -> None:
    law = Law("trailer", "swing", response="fading")
    run = Run("r", np.zeros(1200), {}, {}, 15.0)
    run.speed = np.full(1200, SPEED)
    held = {"mass_kg": 150.0, "frequency_hz": 1.6, "damping_ratio": 0.1, "position_m": -0.5}
    values = held | {"over_m": 1.0, "lost": 0.75}
    late, slow, in_the_end, fast = plant(), plant(), plant(), plant()
    effect_of(law, 1.6).act(late, run, values, ())
    effect_of(law, 1.6).extra["at_its_largest"](in_the_end, run, values, ())
    plain = effect_of(replace(law, response="instant"), 1.6)
    plain.act(slow, run, held | {"frequency_hz": 0.8, "damping_ratio": 0.2}, ())
    plain.act(fast, run, held, ())
    assert difference(simulate(slow), simulate(late)) < 1e-2
    assert difference(simulate(slow), simulate(in_the_end)) < 1e-9
    assert difference(simulate(slow), simulate(fast)) > 0.05
    assert plainer(law) == replace(law, response="instant")
    assert law in refined(replace(law, response="instant"))
    rows = {name: {"value": x, "low": 0.9 * x, "high": 1.1 * x} for name, x in values.items()}
    rows["over_m"]["value"] = 180.0
    assert "held 75 % less stiffly in the end, two thirds of that after the first 180 m" in (
        sentence(law, rows)
    )
    assert suggestion(law, 150.0) == "a load whose straps come loose"


def test_a_swinging_mass_that_is_held_fast_is_a_rigid_trailer() -> None:
    """Where it stands does not matter then: centre of gravity and inertia are the file's."""
    rigid = simulate(plant())
    for place in (0.0, 1.2):
        stiff = plant()
        effect = effect_of(Law("trailer", "swing"))
        values = {"mass_kg": 150.0, "frequency_hz": 8.0, "damping_ratio": 0.7, "position_m": place}
        effect.act(stiff, Run("r", np.zeros(1), {}, {}, 15.0), values, ())
        assert difference(rigid, simulate(stiff)) < 0.006
        soft = plant()
        effect.act(soft, Run("r", np.zeros(1), {}, {}, 15.0), values | {"frequency_hz": 0.7}, ())
        assert difference(rigid, simulate(soft)) > 0.05


@pytest.mark.parametrize(
    ("physics", "law", "values"),
    [
        (Physics(hitch_spring_nm_rad=6000.0), Law("hitch", "articulation"), (6000.0,)),
        (
            Physics(yaw_moment_nms_rad=4000.0), Law("moment_car", "yaw_rate_car"), (-4000.0,),
        ),
        (
            Physics(slosh_mass_kg=140.0, slosh_frequency_hz=0.9, slosh_damping=0.05,
                    slosh_position_m=0.0),
            Law("trailer", "swing"), (140.0, 0.9, 0.05, 0.0),
        ),
        (
            Physics(more="axle_hysteresis", more_size=0.4, more_at=0.01),
            Law("slip_trailer", "articulation", "hysteretic"), (0.4, 0.01),
        ),
        (
            Physics(more="tandem_scrub", more_size=400.0),
            Law("moment_trailer", "yaw_rate_trailer", "saturating"), (-80000.0, 0.005),
        ),
        (
            Physics(more="heading_wind", more_size=20000.0),
            Law("force_trailer", "heading"), (20000.0,),
        ),
        (
            Physics(more="hydraulic_hitch", more_size=10000.0),
            Law("hitch", "articulation_rate", "odd square"), (10000.0,),
        ),
        (
            Physics(more="wedge_friction", more_size=8000.0),
            Law("hitch", "articulation", "rubbing"), (8000.0,),
        ),
        (
            Physics(more="command_steering", more_size=0.05),
            Law("slip_trailer", "yaw_rate_car"), (0.05,),
        ),
        (
            Physics(more="variable_ratio", more_size=5.0),
            Law("slip_car_front", "steer", "odd square"), (5.0,),
        ),
        (
            Physics(more="rolling_load", more_size=140.0, more_at=0.02, slosh_mass_kg=140.0,
                    slosh_frequency_hz=0.9, slosh_damping=0.05, slosh_position_m=0.0),
            Law("trailer", "swing", "dead zone"), (140.0, 0.9, 0.05, 0.0, 0.0, 0.02),
        ),
        (
            Physics(more="sliding_box", more_size=300.0, more_at=0.02, slosh_mass_kg=300.0,
                    slosh_frequency_hz=1.2, slosh_damping=0.0, slosh_position_m=0.0),
            Law("trailer", "swing", "lost motion"), (300.0, 1.2, 0.0, 0.0, 0.02, 0.5),
        ),
        (
            # a pendulum of 0.5 Hz between walls that are ten times as stiff
            Physics(more="hanging_load", more_size=300.0, more_at=0.06, slosh_mass_kg=300.0,
                    slosh_frequency_hz=0.5, slosh_damping=0.05, slosh_position_m=0.0),
            Law("trailer", "swing", "dead zone"),
            (300.0, 0.5 * math.sqrt(11.0), 0.05 / math.sqrt(11.0), 0.0, 1.0 / 11.0, 0.06),
        ),
        (
            Physics(more="leaning_stack", more_size=140.0, more_at=0.02, slosh_mass_kg=140.0,
                    slosh_frequency_hz=0.9, slosh_damping=0.05, slosh_position_m=0.0),
            Law("trailer", "swing", "rubbing"), (140.0, 0.9, 0.05, 0.0, 0.02, 0.6),
        ),
        (
            Physics(more="baffled_liquid", more_size=140.0, more_at=0.1, slosh_mass_kg=140.0,
                    slosh_frequency_hz=0.9, slosh_damping=0.01, slosh_position_m=0.0),
            Law("trailer", "swing", "odd square"), (140.0, 0.9, 0.01, 0.0, 10.0),
        ),
        (
            Physics(more="turning_load", more_size=400.0, more_frequency_hz=0.8),
            Law("trailer", "turn"), (400.0, 0.8, 0.05),
        ),
        (
            Physics(more="caster_axle", more_size=0.4, more_at=0.4),
            Law("slip_trailer", "slip_trailer", response="lagged"), (-0.4, 0.4),
        ),
        (
            Physics(more="gyro_stabiliser", more_size=20000.0, more_at=0.4),
            Law("moment_trailer", "yaw_rate_trailer", response="transient"), (-20000.0, 0.4),
        ),
        (
            Physics(more="pump_catch", more_size=0.1, more_at=0.02),
            Law("slip_car_front", "steer_rate", "dead zone"), (-0.1, 0.02, 0.02),
        ),
        (
            Physics(more="sliding_crate", more_size=200.0, more_at=1.0, slosh_mass_kg=200.0,
                    slosh_frequency_hz=0.9, slosh_damping=0.0, slosh_position_m=0.0),
            Law("trailer", "swing", "hysteretic"), (200.0, 0.0, 1.0),
        ),
        (
            Physics(more="one_way_damper", more_size=6000.0),
            Law("hitch", "articulation_rate", "positive side"), (6000.0,),
        ),
        (
            Physics(more="one_way_damper", more_size=-6000.0),
            Law("hitch", "articulation_rate", "negative side"), (6000.0,),
        ),
        (
            Physics(more="yaw_reference", more_size=12000.0, more_at=0.01),
            # asked: v / (l (1 + (v / v_ch)^2)) of the steering angle, l 2.7 m and v_ch 28 m/s
            Law("moment_car", "yaw_rate_car", "dead zone", second="steer"),
            (-12000.0, 0.01, -SPEED / (2.7 * (1.0 + (SPEED / 28.0) ** 2))),
        ),
        (
            Physics(more="damper_play", more_size=6000.0, more_at=0.006),
            # a strut of 100 kN m/rad before a damper of 6 kN m s/rad
            Law("hitch", "articulation", "dead zone", response="transient"), (1e5, 0.006, 0.06),
        ),
        (
            Physics(more="glazing_pads", more_size=900.0, more_at=0.4),
            Law("hitch", "articulation_rate", "saturating", response="fading"),
            (900.0 / 0.005, 0.005, 0.4),
        ),
        (
            Physics(more="wandering_ruts", more_size=0.004, more_at=50.0),
            Law("axles", "distance", response="periodic"), (0.004, 20.0, 0.0),
        ),
        (
            Physics(more="hedge_wind", more_size=900.0, more_at=60.0),
            Law("force_trailer", "distance", response="periodic"), (900.0, 1000.0 / 60.0, 0.0),
        ),
        (
            Physics(more="soft_verge", more_size=800.0, more_at=76.0),
            Law("drag_trailer", "distance", "positive side", response="periodic"),
            (-800.0 * reference_combination().trailer.front.track_m, 1000.0 / 76.0, 0.0),
        ),
        (
            Physics(more="ball_rattle", more_size=0.004),
            Law("ball", "hitch_force", "lost motion"), (0.004, 2.5e-6),
        ),
        (
            Physics(more="slipping_neck", more_size=1e-5, more_at=120.0),
            Law("ball", "hitch_force", "hysteretic"), (1e-5, 120.0),
        ),
        (
            Physics(more="greasy_ball", more_size=900.0, more_at=0.002),
            Law("hitch", "articulation_rate", "saturating", by="articulation",
                side="positive side"), (900.0 / 0.005, 0.005),
        ),
        (
            Physics(more="gap_headwind", more_size=60.0, more_at=100.0),
            Law("at_trailer", "sideslip_trailer", power=2, response="periodic"),
            (-0.6 * 25.0**2 * 60.0, 2.5, 10.0, 0.0),
        ),
        (
            Physics(more="open_crack", more_size=6e4), Law("ball", "hitch_force", "uneven"),
            (1.0 / 6e4, 8.3),
        ),
        (
            Physics(more="worn_spot", more_size=900.0, more_at=0.01),
            Law("hitch", "articulation_rate", "saturating", by="articulation",
                side="levels off"), (900.0 / 0.005, 0.005, 0.01),
        ),
        (
            # the two axles of the bogie are one law here
            Physics(more="working_frame", more_size=8e-6, more_at=600.0),
            Law("slip_trailer", "hitch_force", "hysteretic"), (-8e-6, 600.0, 0.02),
        ),
        (
            Physics(more="binding_ball", more_size=0.4),
            Law("hitch", "articulation_rate", "saturating", by="hitch_force"), (80.0, 0.005),
        ),
        (
            Physics(more="slack_lashing", more_size=140.0, more_at=-0.3, slosh_mass_kg=140.0,
                    slosh_frequency_hz=0.9, slosh_damping=0.1, slosh_position_m=0.0),
            Law("trailer", "swing", "uneven"), (140.0, 0.9, 0.1, 0.0, 0.3),
        ),
        (
            Physics(more="caster_flutter", more_size=0.2, more_frequency_hz=1.5),
            Law("slip_trailer", "slip_trailer", response="oscillating"), (-0.2, 1.5, 0.15),
        ),
    ],
)  # fmt: skip
def test_laws_agree_with_an_independent_simulator(
    physics: Physics, law: Law, values: tuple[float, ...]
) -> None:
    """MuJoCo's bodies with the same physics: far nearer with the law than without it."""
    whole = reference_combination()
    time, wheel = manoeuvre("slalom", 20.0, 10.0)
    driven = whole
    if law.motion == "turn":  # the load is a part of the inertia of the file
        rest = whole.trailer.yaw_inertia_kgm2 - values[0]
        driven = replace(whole, trailer=replace(whole.trailer, yaw_inertia_kgm2=rest))
    motion = Multibody(driven, physics).run(Inputs(time, wheel, np.full_like(time, SPEED)))
    motion = motion.resample(time)
    own = PlantInput(
        SPACING, motion.speed_m_s, np.gradient(motion.speed_m_s, SPACING), motion.road_wheel_rad,
        constants(whole),
    )  # fmt: skip
    judged = np.stack([motion.yaw_rate_rad_s, motion.trailer_yaw_rate_rad_s], axis=1)

    def off(slots: PlantInput) -> float:
        found = simulate(slots)[:, YAW[:2]]
        return float(np.std(found - judged) / np.std(judged))

    without = off(own)
    rates = dict(zip(("car", "trailer"), judged.T, strict=True))
    run = Run("r", time, dict.fromkeys(("car_yaw_rate", "trailer_yaw_rate"), time), {}, 15.0)
    run.speed, run.yaw_rates = motion.speed_m_s, rates
    runs = (stretch(run),) if law.response == "periodic" else ()
    term = ActiveEffect(effect_of(law, runs=runs), values)
    term.effect.act(own, run, term.as_dict(), ())
    assert off(own) < 0.02
    assert off(own) < 0.25 * without


def searched(terms: tuple[ActiveEffect, ...], duration_s: float = 15.0) -> Search:
    """A search over two noisy runs of the plant, the vehicle known."""
    return Search(synthetic(terms, 3, duration_s), library(), lambda stage, share: None)


def silent(stage: str, share: float) -> None:
    """No progress."""
    del stage, share


def seen_as_the_law_says(found: Discovery) -> None:
    """The missing force as the runs show it, without the law, is what the law makes."""
    for run in missing_inputs(found)["runs"]:
        shown, made = np.array(run["value"]), np.array(run["law"])
        assert np.corrcoef(shown, made)[0, 1] > 0.97
        assert shown @ made / (made @ made) == pytest.approx(1.05, abs=0.15)


def test_a_law_of_roll_has_a_roll_only_where_the_vehicle_has_none() -> None:
    """On springs the roll is the vehicle's own: numbers without effect would count as evidence."""
    search = searched(())
    base = Candidate(search.close.start(), search.close.start())
    laws = LawSearch(Tried(search, base, base))
    effects = [effect_of(law) for law in all_laws()]
    terms = [ActiveEffect(e, tuple(p.starts[0] for p in e.parameters)) for e in effects]
    assert laws._sprung(terms) == terms
    search.problem = replace(search.problem, given=(("sprung_mass_car", 1.0),))
    on_springs = laws._sprung(terms)
    assert [law_in(t) for t in on_springs] == [law_in(t) for t in terms]
    for rigid, sprung in zip(terms, on_springs, strict=True):
        more = set(rigid.as_dict()) - set(sprung.as_dict())
        rolls = law_in(rigid).motion in ROLLS
        assert more == ({"roll_frequency_rad_s", "roll_damping"} if rolls else set())


def test_a_law_is_saved_and_taken_as_an_effect(tmp_path: Path) -> None:
    law = Law("hitch", "articulation")
    result = {
        "discovered": [{
            "text": "a moment", "law": "M = gain x theta", "spec": law.spec,
            "parameters": {"gain": {"value": 3100.0, "low": 1.0, "high": 2.0, "unit": "Nm/rad"}},
        }],
        "inputs": {"recordings": ["run1.blf"]},
    }  # fmt: skip
    path = tmp_path / "weight_distributing_hitch.py"
    assert save_law(result, path)
    (effect,) = read_physics([path])
    assert effect.id == "weight_distributing_hitch"
    assert effect.parameters[0].starts == (3100.0,)
    run = Run("r", np.zeros(1), {}, {}, 15.0)
    given = plant()
    effect.act(given, run, {"gain": 3100.0}, ())
    assert given.get("law_gain") == 3100.0
    (entry,) = _entries((ActiveEffect(effect, (3100.0,)),))
    (kept,) = terms_of([entry], library())  # a model with it needs no file
    assert (kept.effect.id, kept.values) == (effect.id, (3100.0,))
    assert not save_law({"discovered": []}, tmp_path / "none.py")


def test_wrong_effect_files(tmp_path: Path) -> None:
    with pytest.raises(SwaywatchError, match="no such file"):
        read_physics([tmp_path / "none.py"])
    path = tmp_path / "broken.py"
    path.write_text("EFFECTS = [1]\n")
    with pytest.raises(SwaywatchError, match="list EFFECTS"):
        read_physics([path])
    path.write_text("1 / 0\n")
    with pytest.raises(SwaywatchError, match="ZeroDivisionError"):
        read_physics([path])
    path.write_text("from swaywatch.diagnose.effect import Effect\n")
    with pytest.raises(SwaywatchError, match="for another version of swaywatch"):
        read_physics([path])
    with pytest.raises(SwaywatchError, match="has no stiffness"):
        named("spring", Law("hitch", "articulation").spec, {"stiffness": 1.0})


def test_each_left_out_run_counts_by_how_many_times_better_it_is() -> None:
    """A run near its critical speed drifts away with everything: it does not decide alone."""
    _, library_, law = typical([(1.99, 0.169, 0.286), (0.114, 0.130, 0.030)])
    assert library_ == pytest.approx(np.sqrt(0.169 * 0.130))
    assert law < 0.65 * library_


@pytest.mark.parametrize("straight", [-25000.0, 300.0])
@pytest.mark.parametrize(
    "shape",
    [
        "saturating",
        "dead zone",
        "cube",
        "odd square",
        "positive side",
        "waiting",
        "falling",
        "positive stop",
    ],
)
def test_another_shape_begins_as_strong_as_the_straight_line(straight: float, shape: str) -> None:
    """Up to the usual amplitude both give the same moment at the most, the same way."""
    line = ActiveEffect(effect_of(Law("moment_trailer", "articulation_rate")), (straight,))
    found = in_form(line, Law("moment_trailer", "articulation_rate", shape))
    usual = MOTIONS["articulation_rate"].usual
    values = found.as_dict()
    moment = values["gain"] * curve(shape, np.linspace(0.0, usual, 100), values.get("bend", 0.0))
    assert moment[np.argmax(np.abs(moment))] == pytest.approx(straight * usual)


def test_a_law_that_already_has_a_bend_keeps_it_at_another_power_of_the_speed() -> None:
    own = effect_of(Law("hitch", "articulation", "dead zone"))
    found = in_form(
        ActiveEffect(own, (60000.0, 0.03)), Law("hitch", "articulation", "dead zone", 2)
    )
    assert found.values == (60000.0, 0.03)
    wide = in_form(ActiveEffect(own, (60000.0, 0.06)), Law("hitch", "articulation", "saturating"))
    assert wide.values[0] > 0.0  # beyond its zone it acts, at the usual amplitude it does not


def of_two_runs(gains: tuple[float, float], more: tuple[ActiveEffect, ...] = ()) -> LawSearch:
    """Two runs, each with a spring at the hitch of its own, and no law tried yet."""
    springs = [ActiveEffect(effect_of(Law("hitch", "articulation")), (gain,)) for gain in gains]
    one, other = (synthetic((spring, *more), 4) for spring in springs)
    both = replace(one, runs=(one.runs[0], other.runs[1]))
    search = Search(both, library(), silent)
    base = search.baseline()
    return LawSearch(Tried(search, base, base))


def times_likelier(searched_: LawSearch, start: tuple[ActiveEffect, ...]) -> list[float]:
    """Of each run with a spring at the hitch, to none, as logarithms."""
    base = searched_.path.base.fit
    spring = ActiveEffect(effect_of(Law("hitch", "articulation")), (1000.0,))
    law = searched_.search.judge.run(replace(base, terms=(*start, spring)), 10)
    known = searched_.search.judge.run(replace(base, terms=start), 10)
    return _likelier(_left_out_evidence(searched_, law), _left_out_evidence(searched_, known))


def test_a_law_makes_a_left_out_run_likelier_only_where_it_is_one_law() -> None:
    """A spring of one stiffness predicts both runs; one for each run predicts neither."""
    assert min(times_likelier(of_two_runs((3000.0, 3000.0)), ())) > 50.0
    assert sum(times_likelier(of_two_runs((3000.0, -3000.0)), ())) < 0.0


def test_windows_of_a_left_out_run_are_not_taught_by_the_others() -> None:
    """A gust in one run only: what the other run teaches has no gust."""
    gust = next(e for e in library() if e.name == "crosswind_gust:trailer")
    term = ActiveEffect(gust, (6.0, 12.0, 900.0), (1,))
    assert term.outside(0) == term
    assert term.outside(1).values == ()
    spring = ActiveEffect(effect_of(Law("hitch", "articulation")), (3000.0,))
    assert spring.outside(1) == spring
    both = of_two_runs((0.0, 0.0), (term,))
    judge = both.search.judge
    fit = judge.run(replace(both.path.base.fit, terms=(term,)), 20, tolerance=1e-5)
    taught = judge.run(replace(fit, terms=()), 20, runs=[0], tolerance=1e-5)
    whole, part = (both.weighed(Candidate(f, f)).evidence for f in (fit, taught))
    assert _left_out_evidence(both, fit)[1] == pytest.approx(whole - part, abs=0.1)


@pytest.mark.parametrize(
    ("reduced", "beside", "needless"),
    [(1.1, "hitch_friction:hitch", True), (1.1, "", False), (1.5, "hitch_friction:hitch", False)],
)
def test_no_law_beside_effects_that_leave_only_noise(
    reduced: float, beside: str, needless: bool
) -> None:
    friction = next(e for e in library() if e.name == "hitch_friction:hitch")
    known = ActiveEffect(friction, tuple(p.starts[0] for p in friction.parameters))
    law = initial(all_laws()[0])[0]
    explains = Fit((known,), np.zeros((1, 5)), np.zeros(0), reduced * 1000.0, 1000)
    terms = (known, law) if beside else (law,)
    assert _beside_what_suffices(explains, replace(explains, terms=terms)) is needless


def test_every_law_that_is_tried_can_be_reported() -> None:
    """A sliding load has no bend to report a limit of."""
    for law in (*all_laws(), *SWINGING, *products()):
        assert law_of(law.spec) == law
        effect_ = effect_of(law)
        found = effect_.report({p.name: p.starts[0] for p in effect_.parameters})
        rows = {key: {"value": v, "low": 0.9 * v, "high": 1.1 * v} for key, v in found.items()}
        assert sentence(law, rows)
        assert isinstance(suggestion(law, 1.0), str)
        assert energy(law, 1.0)


def test_what_comes_at_once_or_never_fades_is_reported_as_a_law_that_always_acts() -> None:
    stop = Law("hitch", "articulation", "dead zone")
    for response in ("growing", "fading"):
        assert plainer(replace(stop, response=response)) == stop
    friction = Law("hitch", "articulation_rate", response="fading")  # a damper is the library's
    assert plainer(friction) is None
    assert plainer(Law("slip_trailer", "slip_trailer", response="growing")) is None
    assert plainer(Law("force_trailer", "distance", response="growing")) is None
    late = Law("at_trailer", "sideslip_trailer", "straight", 2, "lagged")
    assert plainer(late) == replace(late, place="force_trailer")  # where its lever says nothing
