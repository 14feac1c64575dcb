"""The vehicle on springs as a baseline: what is believed of it, what it keeps from being said."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from conftest import DATA

from swaywatch.diagnose.engine import diagnose
from swaywatch.diagnose.evidence.baselines import noticeable
from swaywatch.diagnose.evidence.evidence import explained, worth
from swaywatch.diagnose.evidence.search import Search, reduced_chi_square
from swaywatch.diagnose.evidence.verdict import TANDEM, _counteract, _whole, _without_slight_windows
from swaywatch.diagnose.fit.beliefs import beliefs_of
from swaywatch.diagnose.fit.data import load
from swaywatch.diagnose.fit.fit import Fit, plant_of
from swaywatch.diagnose.fit.road_vehicle import TYRES, WITHIN, on_springs, outside, values
from swaywatch.diagnose.model import beliefs_in, model_block
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library
from swaywatch.effects.runs import Run, low_pass
from swaywatch.errors import VehicleError
from swaywatch.plant.lanes import BODY, SCALARS
from swaywatch.vehicle_file import load_vehicle

CASE = DATA / "road" / "r22"


@pytest.fixture(scope="module")
def loaded() -> object:
    """Two runs of a vehicle on springs, as its user knows it."""
    return load(sorted(CASE.glob("run*.mf4")), CASE / "vehicle.toml", CASE / "signals.toml")


def test_every_value_is_a_slot_of_the_plant_with_a_source(loaded: object) -> None:
    problem = on_springs(loaded.problem)
    slots = set(SCALARS)
    assert set(values(problem.body, heaves=True)) <= slots
    typical = [b for b in problem.beliefs.items if b.kind == "typical"]
    assert {b.name for b in typical} <= slots
    assert all(b.source and b.tolerance > 0.0 for b in typical)
    assert set(TYRES) <= {b.name for b in typical}


def test_a_value_falls_towards_zero_and_never_below(loaded: object) -> None:
    problem = on_springs(loaded.problem)
    shift = np.zeros(len(problem.beliefs))
    at = problem.beliefs.at[("typical", "roll_stiffness_trailer")]
    own = dict(problem.given)["roll_stiffness_trailer"]
    found = []
    for z in (-20.0, -1.0, 0.0, 1.0):
        shift[at] = z
        plant = plant_of(problem, 0, (), np.zeros(5), shift)
        found.append(plant.get("roll_stiffness_trailer") / own)
    assert found[0] > 0.0
    assert found == sorted(found)
    assert found[2] == 1.0


def test_a_height_over_the_roll_axis_may_be_less_than_nothing(loaded: object) -> None:
    problem = on_springs(loaded.problem)
    for name in ("ball_height_car", "roll_axis_height_trailer", "wind_height_trailer"):
        belief = problem.beliefs.items[problem.beliefs.at[("typical", name)]]
        assert belief.signed
        own = dict(problem.given)[name]
        shift = np.zeros(len(problem.beliefs))
        shift[problem.beliefs.at[("typical", name)]] = -2.0 * own / belief.tolerance
        assert plant_of(problem, 0, (), np.zeros(5), shift).get(name) == pytest.approx(-own)


def test_an_observer_holds_the_body_whose_yaw_rate_is_there(loaded: object) -> None:
    """The car alone where the trailer has no sensor: it does not swing on by itself."""
    whole = replace(loaded.problem, observer=2.0)
    run = replace(whole.runs[0], channels=dict(whole.runs[0].channels))
    del run.channels["trailer_yaw_rate"]
    for problem, pulls in ((whole, (2.0, 2.0)), (replace(whole, runs=(run,)), (2.0, 0.0))):
        plant = plant_of(problem, 0, (), np.zeros(5), problem.at_rest())
        assert (plant.get("observer_car"), plant.get("observer_trailer")) == pulls
        assert problem.runs[0].both_watched == all(pulls)


def test_what_every_road_vehicle_has_is_no_missing_effect() -> None:
    names = {effect.id for effect in outside(library())}
    assert not names & set(WITHIN)
    assert "hitch_friction" in names


def test_a_small_load_at_twice_the_frequency_is_the_bodys_own_bounce() -> None:
    """60 N is a claim beside a rigid vehicle, not beside one on springs; 150 N beside both."""
    rigid = [e for e in library() if e.id == "axle_load_harmonic"]
    on_springs_ = [e for e in outside(library()) if e.id == "axle_load_harmonic"]
    assert [e.name for e in rigid] == [e.name for e in on_springs_]
    for effects, said in ((rigid, [True, True]), (on_springs_, [False, True])):
        for effect in effects:
            terms = [ActiveEffect(effect, (2.0, 9.0, size, 0.0), (0,)) for size in (60.0, 150.0)]
            assert [noticeable(term) for term in terms] == said
            trial = effect.extra["trials"](effect.component, 2.0, 9.0, 0)[0]
            ends, (_, delay) = trial.values[:2], trial.values[2:]
            loads = [replace(trial, values=(*ends, size, delay)) for size in (60.0, 150.0)]
            assert [noticeable(term) for term in loads] == said


@pytest.mark.parametrize(
    ("slight", "costs", "left_out"),
    [
        ((3.0, 5.0, 20.0, 0.0), 1.005, True),
        ((3.0, 5.0, 20.0, 0.0), 1.05, False),
        ((8.5, 9.0, 300.0, 0.0), 1.05, True),
    ],
)
def test_a_window_in_which_nothing_happens_is_none(
    slight: tuple[float, ...], costs: float, left_out: bool
) -> None:
    """A load of 20 N is left out unless the misfit says that something is there, half a second
    always: it corrects the shape of the longer one.
    """
    effect = next(e for e in library() if e.id == "axle_load_harmonic")
    term = ActiveEffect(effect, (2.0, 9.0, 60.0, 0.0, *slight, 1.0, 3.0, 80.0, 5.0), (0, 0, 1))

    def run(fit: Fit, *_: object, **__: object) -> Fit:
        return replace(fit, chi2=costs * fit.chi2)

    search = cast("Search", SimpleNamespace(judge=SimpleNamespace(run=run)))
    found = _without_slight_windows(
        search, Fit((term,), np.zeros((2, 5)), np.zeros(0), 1000.0)
    ).terms[0]
    fewer = ActiveEffect(effect, (2.0, 9.0, 60.0, 0.0, 1.0, 3.0, 80.0, 5.0), (0, 1))
    assert found == (fewer if left_out else term)


@pytest.mark.parametrize(
    ("shift", "counteract"),
    [
        ((2.9, -3.2), True), ((-3.7, 3.9), True), ((-3.0, 0.5), False), ((0.0, 3.0), False),
        ((3.0, 2.0), False), ((-3.0, -2.0), False),
    ],
)  # fmt: skip
def test_axles_of_a_tandem_that_counteract_each_other(
    shift: tuple[float, float], counteract: bool
) -> None:
    """14 % stiffer in front, 16 % softer behind is an error of form; both softer are tyres."""
    at = {("vehicle", "car.mass"): 0, ("vehicle", TANDEM[0]): 1, ("vehicle", TANDEM[1]): 2}
    problem = SimpleNamespace(beliefs=SimpleNamespace(at=at))
    search = cast("Search", SimpleNamespace(problem=problem))
    assert _counteract(search, Fit((), np.zeros((2, 5)), np.array([5.0, *shift]))) == counteract
    del at["vehicle", TANDEM[1]]  # a single axle
    assert not _counteract(search, Fit((), np.zeros((2, 5)), np.array([5.0, *shift])))


def test_a_load_somewhat_early_or_late_is_the_dampers() -> None:
    """12 ms: a fault of a yaw rate on springs, not of a wheel load; 25 ms is one of both."""
    effects = {e.component: e for e in outside(library()) if e.id == "sensor_delay"}
    for channel, said in (("car_yaw_rate", True), ("wheel_vertical_load_fl", False)):
        small, large = (ActiveEffect(effects[channel], (delay,)) for delay in (0.012, 0.025))
        assert noticeable(small) == said
        assert noticeable(large)


@pytest.mark.parametrize(
    ("before", "after", "enough"),
    [(5.0, 1.2, True), (5.0, 1.6, False), (40.0, 4.5, True), (1300.0, 100.0, False)],
)
def test_a_share_of_what_drifts_away_is_no_explanation(
    before: float, after: float, enough: bool
) -> None:
    """Reduced chi-squares without and with an effect; near the critical speed the first is huge."""
    start = Fit((), np.zeros((1, 5)), np.zeros(0), chi2=before * 900.0, count=900)
    assert explained(start, replace(start, chi2=after * 900.0)) == enough


def test_the_model_keeps_what_was_believed(loaded: object) -> None:
    problem = on_springs(loaded.problem)
    fit = Search(problem, [], lambda stage, share: None).close.start()
    block = json.loads(json.dumps(model_block(problem, fit, fit)))
    assert beliefs_in(block).items == problem.beliefs.items
    assert dict(block["given"]) == pytest.approx(values(problem.body, heaves=True))


def test_a_rigid_vehicle_has_no_such_beliefs(loaded: object) -> None:
    rigid = beliefs_of(loaded.problem.body, loaded.problem.channels(loaded.problem.runs[0]))
    assert not {b.name for b in rigid.items} & set(TYRES)


def test_the_load_of_a_trailers_wheels_is_asked_for_where_their_forces_are(loaded: object) -> None:
    """A tyre's side force grows with its load: heights and tracks show in left against right."""
    wheels = [f"trailer_wheel_lateral_force_{wheel}" for wheel in ("fl", "fr", "rl", "rr")]
    body, without = loaded.problem.body, loaded.problem.channels(loaded.problem.runs[0])
    transfer = {"transfer_trailer_front", "transfer_trailer_rear"}
    tandem, single = body.copy(), body.copy()
    front = BODY.index("trailer.front_cornering_stiffness")
    tandem[front], single[front] = 9e4, 0.0
    for vehicle, channels, asked in (
        (tandem, [*without, *wheels], transfer),
        (single, [*without, *wheels[2:]], {"transfer_trailer_rear"}),
        (tandem, without, set()),
    ):
        names = {b.name for b in beliefs_of(vehicle, channels).items}
        assert names & transfer == asked


def test_friction_at_the_hitch_of_a_vehicle_on_springs() -> None:
    """As its user knows it, from one run; tyres relax and saturate, accelerometers see gravity."""
    runs = sorted(CASE.glob("run*.mf4"))[:1]
    result = diagnose(runs, CASE / "vehicle.toml", CASE / "signals.toml")
    truth = json.loads((CASE / "truth.json").read_text())["effects"][0]
    assert result["verdict"] == "missing_physics"
    physics = [e for e in result["effects"] if e["id"] != "parameter_error"]
    assert [e["id"] for e in physics] == ["hitch_friction"]
    value = physics[0]["parameters"]["moment_nm"]["value"]
    assert value == pytest.approx(truth["moment_nm"], rel=0.25)
    assert result["evidence"]["reduced_chi_square_diagnosed"] < 1.3


def test_a_recording_that_begins_in_mid_motion_fits_like_the_whole(loaded: object) -> None:
    """Its bodies roll at the start, which no channel says: the first two seconds hardly count."""
    whole = loaded.problem.runs[0]
    assert whole.settling == 0
    acceleration = np.abs(low_pass(whole.channels["car_lateral_acceleration"], 2.0))
    cut = int(np.argmax(acceleration[: whole.time.size // 2]))
    channels = {name: value[cut:] for name, value in whole.channels.items()}
    piece = Run("cut", whole.time[cut:], channels, whole.positions, whole.steering_ratio).prepare()
    problem = on_springs(replace(loaded.problem, runs=(piece,)))
    search = Search(problem, library(), lambda stage, share: None)
    truth = json.loads((CASE / "truth.json").read_text())["effects"][0]
    effect = next(e for e in library() if e.id == "hitch_friction")
    term = ActiveEffect(effect, (truth["moment_nm"], *(p.starts[0] for p in effect.parameters[1:])))
    near = search.close.run(replace(search.close.start(), terms=(term,)), 20)
    assert reduced_chi_square(search.released(near)) < 1.1  # 1.25 where they count


def test_a_tolerance_of_the_file_is_taken(tmp_path: Path) -> None:
    text = (CASE / "vehicle.toml").read_text()
    path = tmp_path / "vehicle.toml"
    path.write_text(text + "\n[tolerance.trailer]\nmass = 0.04\ncog = 0.1\n")
    problem = load(sorted(CASE.glob("run*.mf4"))[:1], path, CASE / "signals.toml").problem
    known = {b.name: b for b in problem.beliefs.items if b.kind == "vehicle"}
    assert known["trailer.mass"].tolerance == 0.04
    assert known["trailer.cog"].source == "vehicle.toml"
    assert known["car.mass"].tolerance < 0.04


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ("[tolerance]\nmass = 0.02", "known: \\[tolerance.car\\]"),
        ("[tolerance.car]\nweight = 0.02", "weight is not known; known: mass"),
        ("[tolerance.car]\nmass = 2.0", "0.0001 to 0.5 \\(0.02 is 2 %\\)"),
        ("[tolerance.trailer]\ncog = true", "must be a number from 0.0001 to 0.5 m"),
    ],
)
def test_a_wrong_tolerance_is_refused_with_what_would_be_right(
    tmp_path: Path, lines: str, says: str
) -> None:
    path = tmp_path / "vehicle.toml"
    path.write_text((CASE / "vehicle.toml").read_text() + "\n" + lines + "\n")
    with pytest.raises(VehicleError, match=says):
        load_vehicle(path)


@pytest.mark.parametrize(
    ("name", "share"),
    [("trailer_aerodynamics:trailer", 0.005), ("steering_free_play:steering", 0.03)],
)
def test_what_springs_imitate_has_to_take_away_more(name: str, share: float) -> None:
    effect = next(e for e in library() if e.name == name)
    term = ActiveEffect(effect, tuple(p.starts[0] for p in effect.parameters))
    before = Fit((), np.zeros((1, 5)), np.zeros(0), chi2=10_000.0)
    for factor, enough in ((0.9, False), (1.1, True)):
        after = replace(before, terms=(term,), chi2=(1.0 - factor * share) * before.chi2)
        assert worth(before, before, after, on_springs=True) == enough
        assert worth(before, before, after) or not enough


@pytest.mark.parametrize(
    ("before", "after", "whole"),
    [(5.0, 1.2, True), (5.0, 1.5, False), (31.1, 2.17, False), (100.0, 1.9, True)],
)
def test_much_more_than_noise_is_not_a_whole_explanation(
    before: float, after: float, whole: bool
) -> None:
    """Walls of ruts pass as tyres that are stiffer at times, which leave 2.2 of 31."""
    start = Fit((), np.zeros((1, 5)), np.zeros(0), chi2=before * 900.0, count=900)
    assert _whole(start, replace(start, chi2=after * 900.0)) == whole
