"""A vehicle.toml that is far off is calibrated: the fit of the baseline finds the tyres."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import pytest
from conftest import DATA

from swaywatch.diagnose.evidence.search import Candidate, Search, reduced_chi_square
from swaywatch.diagnose.evidence.verdict import _as_term, equivalents_of
from swaywatch.diagnose.fit.data import load
from swaywatch.diagnose.fit.fit import Problem
from swaywatch.diagnose.fit.road_vehicle import on_springs
from swaywatch.ecu.bus import encode_drive
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library
from swaywatch.plant.lanes import BODY
from swaywatch.recording import write_recording
from swaywatch.simulate import simulate_scenario
from swaywatch.simulate.scenario import read_scenario
from swaywatch.simulate.signals import write_signals
from swaywatch.vehicle_file import load_vehicle

TYPE = DATA / "practice" / "p03" / "vehicle.toml"
_ENDS = ("front", "rear")
OFF = 1.47
"""The tyres of the dissertation's car are stiffer than its simulation believed."""
TYRES = [f"{part}.{end}_cornering_stiffness" for part in ("car", "trailer") for end in _ENDS]


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    """A drive on springs with everything measured, all tyres believed too soft."""
    folder = tmp_path_factory.mktemp("afar")
    content = {
        "vehicle": "unused", "duration_s": 30.0, "speed_kmh": 108.0, "sprung": {},
        "manoeuvre": [
            {"kind": "impulse", "start_s": 2.0 + 9.0 * k, "angle_deg": angle, "frequency_hz": 0.6}
            for k, angle in enumerate((14.0, -20.0, 17.0))
        ],
    }  # fmt: skip
    scenario = read_scenario(content, "afar", folder, "afar", 1, load_vehicle(TYPE))
    drive, _ = simulate_scenario(scenario)
    write_recording(folder / "run1.blf", encode_drive(drive))
    write_signals(folder / "signals.toml", drive)
    found = load([folder / "run1.blf"], TYPE, folder / "signals.toml").problem
    body = found.body.copy()
    body[[BODY.index(name) for name in TYRES]] /= OFF
    return replace(found, body=body)


def test_all_tyres_off_by_half_are_found_on_springs(problem: Problem) -> None:
    whole = on_springs(problem)
    search = Search(whole, [], lambda stage, share: None)
    fit = search.baseline().fit
    assert reduced_chi_square(fit) < 1.2
    for name in TYRES:
        index = whole.beliefs.at["vehicle", name]
        factor = 1.0 + fit.shift[index] * whole.beliefs.items[index].tolerance
        assert factor == pytest.approx(OFF, rel=0.04), name


@pytest.mark.parametrize(
    ("front", "rear", "elastic"),
    [(0.9, None, True), (1.1, None, False), (1.36, 1.45, True), (1.36, 1.2, False)],
)
def test_a_front_axle_softer_than_the_rear_may_be_an_elastic_steering(
    front: float, rear: float | None, elastic: bool
) -> None:
    """Where the rear tyres are stiffer than believed, those in front may be as well (Eq. 5.3)."""
    effects = {e.name: e for e in library()}
    terms = [ActiveEffect(effects[f"parameter_error:{TYRES[0]}"], (front,))]
    if rear is not None:
        terms.append(ActiveEffect(effects[f"parameter_error:{TYRES[1]}"], (rear,)))
    names = equivalents_of(terms[0], terms, [])
    assert ("steering_compliance:car_front" in names) == elastic


@pytest.mark.parametrize(
    ("alike", "said"), [(False, "steering_compliance"), (True, "parameter_error")]
)
def test_tyres_that_are_all_too_soft_are_no_elastic_steering(
    problem: Problem, alike: bool, said: str
) -> None:
    search = Search(problem, library(), lambda stage, share: None)
    found = _as_term(search, TYRES[0], 0.87, alike)
    assert found is not None
    assert found[0].effect.id == said
    beside = [ActiveEffect({e.name: e for e in library()}[f"parameter_error:{TYRES[1]}"], (0.87,))]
    names = equivalents_of(found[0], [found[0], *beside], [])
    assert len(names) >= 1, "the other of the two is said beside it"


def test_what_stands_beside_a_claim_is_no_equivalent_of_it() -> None:
    """Gain + friction + a load: the load does not stand in the place of the gain (blind pair)."""
    names = {e.name: e for e in library()}
    gain = "sensor_gain:car_lateral_acceleration"
    rolls = "sensor_roll_gravity:car_lateral_acceleration"
    load = "axle_load_harmonic:car_rear"
    term = ActiveEffect(names[gain], (1.07,))
    others = [SimpleNamespace(names=frozenset(n)) for n in ((gain, load), (rolls,))]
    assert equivalents_of(term, [term], cast("list[Candidate]", others)) == [rolls]


def test_a_baseline_that_was_stuck_is_begun_again(problem: Problem) -> None:
    """From where an effect led out; one that is as good as it can be stays."""
    search = Search(problem, [], lambda stage, share: None)
    best = search.baseline()
    assert not search.rebased(best.fit)
    assert search.baseline() is best
    shift = best.fit.shift.copy()
    shift[problem.beliefs.at["vehicle", TYRES[1]]] += 3.0
    stuck = search.judge.run(replace(best.fit, shift=shift), 0)
    assert stuck.chi2 > 1.1 * best.fit.chi2
    search._base = Candidate(stuck, stuck)
    effect = next(e for e in library() if e.name == "hitch_damping:hitch")
    assert search.rebased(replace(best.fit, terms=(ActiveEffect(effect, (1.0,)),)))
    assert not search.baseline().fit.terms
    assert search.baseline().fit.chi2 == pytest.approx(best.fit.chi2, rel=1e-3)


def test_a_search_is_not_begun_again_for_a_baseline_that_was_a_little_off(
    problem: Problem,
) -> None:
    """What an effect took away is far more than what its vehicle alone does."""
    search = Search(problem, [], lambda stage, share: None)
    best = search.baseline()
    shift = best.fit.shift.copy()
    shift[problem.beliefs.at["vehicle", TYRES[1]]] += 3.0
    off = search.judge.run(replace(best.fit, shift=shift), 0)
    search._base = Candidate(off, off)
    effect = next(e for e in library() if e.name == "hitch_damping:hitch")
    terms = (ActiveEffect(effect, (1.0,)),)
    much = replace(best.fit, terms=terms, chi2=off.chi2 - 20.0 * (off.chi2 - best.fit.chi2))
    assert not search.rebased(much)
    assert search.baseline().fit.chi2 == pytest.approx(best.fit.chi2, rel=1e-3)
