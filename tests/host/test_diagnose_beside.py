"""Beside the user's own simulation: our plant as a correction, and what only springs can do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA

from swaywatch.diagnose.evidence.evidence import BESIDE, DISCREPANCY, form_misfit, worth
from swaywatch.diagnose.evidence.search import Search
from swaywatch.diagnose.fit.data import load
from swaywatch.diagnose.fit.fit import COMPARED, Fit, Fitter, Problem, plant_of, predict_run
from swaywatch.diagnose.fit.road_vehicle import on_springs
from swaywatch.diagnose.fit.simulation import Pair, _corrected
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect, library
from swaywatch.plant.lanes import OUTPUT, PlantInput, simulate

CASE = DATA / "road" / "r22"
STIFFER = 1.0  # tolerances
SLOWER = 0.7
_REAR = ("vertical_rl", "vertical_rr")


@pytest.fixture(scope="module")
def problem() -> Problem:
    """Two runs of a car with a trailer."""
    found = load(sorted(CASE.glob("run*.mf4")), CASE / "vehicle.toml", CASE / "signals.toml")
    assert found.problem is not None
    for run in found.problem.runs:  # far from the critical speed
        run.channels["speed"] = SLOWER * run.channels["speed"]
        run.speed, run.acceleration = SLOWER * run.speed, SLOWER * run.acceleration
    return found.problem


def _effect(name: str, component: str, form: str | None = None) -> Effect:
    found = (e for e in library() if (e.id, e.component) == (name, component))
    return next(e for e in found if form is None or e.extra.get("form") == form)


def _simulated(whole: Problem, shift: np.ndarray) -> list[Pair]:
    """What a user's simulation with these values says of each run."""
    fit = Fitter(whole, fine=False).start()
    pairs = []
    for index, run in enumerate(whole.runs):
        made = predict_run(whole, index, (), fit.nuisance[index], shift)
        channels = {name: made[name] for name in COMPARED if name in run.channels}
        channels["speed"] = run.channels["speed"]
        channels["steering_wheel_angle"] = run.channels["steering_wheel_angle"]
        pairs.append((run, channels))
    return pairs


def test_a_simulation_on_springs_is_met_by_the_plant_on_springs(problem: Problem) -> None:
    whole = on_springs(problem)
    shift = np.zeros(len(whole.beliefs))
    for name in ("roll_stiffness_car", "roll_stiffness_trailer"):
        shift[whole.beliefs.at["typical", name]] = STIFFER
    _, found, checks = _corrected(problem, _simulated(whole, shift), [], ())
    assert found.on_springs
    (share,) = (float(c.split("within ")[1].split(" %")[0]) for c in checks)
    assert share < 1.0
    theirs = plant_of(whole, 0, (), np.zeros(5), shift)
    given = dict(found.given)
    for name in ("roll_stiffness_car", "roll_stiffness_trailer"):
        assert given[name] == pytest.approx(theirs.get(name), rel=0.1)
    names = {e.id for e in Search(found, library(), lambda *_: None).effects}
    assert {"damper_fade", "damper_asymmetry", "roll_stiffness_change"} <= names


def test_a_simulation_without_springs_is_met_by_the_plant_without(problem: Problem) -> None:
    rigid = replace(problem, given=())
    _, found, _ = _corrected(problem, _simulated(rigid, np.zeros(len(rigid.beliefs))), [], ())
    assert not found.on_springs
    names = {e.id for e in Search(found, library(), lambda *_: None).effects}
    assert "damper_fade" not in names
    assert "tyre_relaxation" in names


@pytest.fixture
def plant(problem: Problem) -> PlantInput:
    """A run on springs that nothing lifts: the dampers are alike both ways."""
    whole = on_springs(problem, heaves=True)
    made = plant_of(whole, 0, (), np.zeros(5), np.zeros(len(whole.beliefs)))
    for body in ("car", "trailer"):
        made.scalar(f"damper_asymmetry_{body}", 0.0)
        made.scalar(f"jacking_{body}", 0.0)
    return made


def _with(plant: PlantInput, problem: Problem, *terms: ActiveEffect) -> PlantInput:
    made = plant.copy()
    for term in terms:
        term.effect.act(made, problem.runs[0], term.as_dict(), ())
    return made


def _column(plant: PlantInput, name: str) -> np.ndarray:
    return simulate(plant)[:, OUTPUT.index(name)]


def _fade(place: str, form: str, factor: float) -> ActiveEffect:
    effect = _effect("damper_fade", place, form)
    rest = tuple(p.starts[0] for p in effect.parameters[1:])
    return ActiveEffect(effect, (factor, *rest))


def test_half_of_all_dampers_is_half_of_the_roll_damping(
    plant: PlantInput, problem: Problem
) -> None:
    both = [_fade(f"car_{end}", "both", 0.5) for end in ("front", "rear")]
    half = plant.copy()
    half.scalar("roll_damping_rate_car", 0.5 * plant.get("roll_damping_rate_car"))
    faded = _column(_with(plant, problem, *both), "car_roll")
    assert faded == pytest.approx(_column(half, "car_roll"), abs=1e-7)
    assert np.max(np.abs(faded - _column(plant, "car_roll"))) > 1e-4


def test_a_weak_axle_leaves_its_load_to_the_other(plant: PlantInput, problem: Problem) -> None:
    weak = _with(plant, problem, _fade("car_rear", "both", 0.8))
    front, rear = (
        _column(weak, f"vertical_{end}r") - _column(plant, f"vertical_{end}r") for end in "fr"
    )
    assert np.corrcoef(rear - front, _column(plant, "car_roll_rate"))[0, 1] < -0.9


def test_dampers_that_are_weak_on_one_side_lift_the_body(
    plant: PlantInput, problem: Problem
) -> None:
    """Each side the other way; the same on both sides lifts nothing."""
    lifts = {}
    for form in ("both", "left", "right"):
        weak = _with(plant, problem, _fade("car_rear", form, 0.5))
        lifts[form] = sum(_column(weak, w) - _column(plant, w) for w in _REAR)
    assert np.max(np.abs(lifts["both"])) < 1e-3
    assert np.std(lifts["left"]) > 1.0
    assert np.corrcoef(lifts["left"], lifts["right"])[0, 1] < -0.9


def test_no_loss_of_damping_makes_heave_grow(plant: PlantInput, problem: Problem) -> None:
    """However little a body's heave is damped: of that, too, only a share is lost."""
    plant.scalar("heave_damping_car", 0.02)
    plant.scalar("jacking_car", 0.5)
    plant.scalar("roll_damping_rate_car", 4.0 * plant.get("roll_damping_rate_car"))
    weak = _with(plant, problem, _fade("car_rear", "both", 0.0))
    assert np.max(np.abs(_column(weak, "vertical_rl"))) < 2e4


def test_dampers_that_differ_lift_the_body_alike_in_either_bend(
    plant: PlantInput, problem: Problem
) -> None:
    """So the load comes twice in each swing."""
    effect = _effect("damper_asymmetry", "car_rear")
    rest = tuple(p.starts[0] for p in effect.parameters[1:])
    term = ActiveEffect(effect, (0.5, *rest))
    lifts = []
    for side in (1.0, -1.0):
        turned = replace(plant, steer=side * plant.steer)
        other = _with(turned, problem, term)
        lifts.append(sum(_column(other, w) - _column(turned, w) for w in _REAR))
    assert np.std(lifts[0]) > 1.0
    assert lifts[0] == pytest.approx(lifts[1], abs=1e-3)
    assert effect.report({"asymmetry": 0.5})["ratio"] == pytest.approx(3.0)


def test_roll_stiffness_is_that_of_the_plant(plant: PlantInput, problem: Problem) -> None:
    effect = _effect("roll_stiffness_change", "car")
    rest = tuple(p.starts[0] for p in effect.parameters[1:])
    stiffer = _with(plant, problem, ActiveEffect(effect, (1.3, *rest)))
    less = np.std(_column(stiffer, "car_roll")) / np.std(_column(plant, "car_roll"))
    assert 0.7 < less < 0.85


@pytest.mark.parametrize(
    ("base", "after", "said"),
    [
        (1.00, 0.99, True),  # only noise is left, and 1 % of it is an effect
        (1.00, 0.996, False),  # less than models of this depth leave anyway
        (1.50, 1.48, False),  # 4 % of the misfit: the form of another one
        (1.50, 1.46, True),
    ],
)
def test_a_first_effect_takes_its_share_of_the_misfit_not_of_the_noise(
    base: float, after: float, said: bool
) -> None:
    count = 10_000
    effect = _effect("hitch_damping", "hitch")
    term = ActiveEffect(effect, tuple(p.starts[0] for p in effect.parameters))
    fits = [
        Fit(terms, np.zeros((1, 5)), np.zeros(0), chi2=x * count, count=count)
        for x, terms in ((base, ()), (after, (term,)))
    ]
    assert worth(fits[0], *fits, beside=True) == said
    assert form_misfit(fits[0], fits[1]) == pytest.approx(max(base - 1.0, 0.0) * count)
    assert BESIDE[0] > DISCREPANCY


def test_a_further_effect_takes_its_share_of_all_that_is_left() -> None:
    count = 10_000
    effect = _effect("hitch_damping", "hitch")
    term = ActiveEffect(effect, tuple(p.starts[0] for p in effect.parameters))
    fits = [
        Fit((term,) * k, np.zeros((1, 5)), np.zeros(0), chi2=x * count, count=count)
        for k, x in enumerate((3.0, 1.2, 1.05))
    ]
    assert not worth(*fits, beside=True)
    fits[2] = replace(fits[2], chi2=1.0 * count)
    assert worth(*fits, beside=True)
