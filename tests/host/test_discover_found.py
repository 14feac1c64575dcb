"""Laws beyond the library, found in runs of our own plant, and none where none is missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_diagnose import effect
from test_discover import plant, searched, seen_as_the_law_says, silent

from swaywatch.diagnose.evidence.baselines import Path as Tried
from swaywatch.diagnose.evidence.search import Candidate, reduced_chi_square
from swaywatch.diagnose.fit.fit import Fit
from swaywatch.diagnose.model import _entries, terms_of
from swaywatch.discover.begin import by_promise, crossed, in_form, initial, law_in
from swaywatch.discover.effect import effect_of, effect_of_form
from swaywatch.discover.excerpt import everything, excerpt_of
from swaywatch.discover.find import (
    Laws,
)
from swaywatch.discover.grammar import all_laws
from swaywatch.discover.law import Law
from swaywatch.discover.save import named
from swaywatch.discover.sentences import sentence
from swaywatch.discover.trial import NOISE_CLOSE, SCREENED, LawSearch
from swaywatch.discover.way import repetitions, stretch
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library
from swaywatch.errors import SwaywatchError


def test_a_hitch_spring_is_found() -> None:
    truth = ActiveEffect(effect_of(Law("hitch", "articulation")), (4000.0,))
    search = searched((truth,), 26.0)
    assert excerpt_of(
        search.close, search.close.start()
    ).offsets  # long enough to be begun in parts
    found = Laws([search]).discover([], silent)
    assert found is not None
    assert (found.law.place, found.law.motion, found.law.shape) == (
        "hitch", "articulation", "straight",
    )  # fmt: skip
    seen_as_the_law_says(found)
    error = np.sqrt(found.fit.covariance[0, 0])
    assert abs(found.term.values[0] - 4000.0) < 5.0 * error
    for vehicle, library_, law in found.kept_out:
        assert law < 0.6 * min(vehicle, library_)
    assert len(found.likelier) == 2
    assert min(found.likelier) > 50.0
    kept = terms_of(_entries(found.fit.terms), library())
    assert kept[0].effect.extra["law"] == found.law
    assert kept[0].values == found.term.values


def test_a_stop_is_found_that_is_hardly_a_straight_line() -> None:
    """Touched in the largest swings only: the best straight law says little and is elsewhere."""
    truth = ActiveEffect(effect_of(Law("hitch", "articulation", "dead zone")), (60000.0, 0.025))
    found = Laws([searched((truth,))]).discover([], silent)
    assert found is not None
    assert (found.law.place, found.law.motion, found.law.shape) == (
        "hitch", "articulation", "dead zone",
    )  # fmt: skip
    assert found.term.values == pytest.approx((60000.0, 0.025), rel=0.1)


#: As many again take the same way; they are left to `make long`.
LONG = [
    (Law("moment_trailer", "yaw_rate_trailer", "saturating"), (-40000.0, 0.005)),
    (Law("hitch", "articulation_rate", "odd square"), (6000.0,)),
    (Law("hitch", "articulation", "rubbing"), (3000.0,)),
    (Law("slip_trailer", "yaw_rate_car"), (0.02,)),
    (Law("slip_trailer", "slip_trailer", "saturating"), (-0.83, 0.005)),
    (Law("slip_trailer", "slip_trailer", response="lagged"), (-0.5, 0.5)),
    (Law("slip_car_front", "slip_car_front", "dead zone"), (-0.3, 0.006)),
    (Law("force_trailer", "sideslip_trailer", "straight", 2, "lagged"), (-14000.0, 0.3)),
    (Law("slip_car_rear", "roll_car", "dead zone"), (0.3, 0.01, 13.0, 0.112)),
    (Law("trailer", "swing", "hysteretic"), (90.0, -0.6, 0.8)),
    (Law("slip_car_rear", "yaw_rate_trailer", "lost motion"), (-0.03, 0.012)),
    (Law("moment_car", "yaw_rate_car", "dead zone", response="lagged"), (-25000.0, 0.02, 0.15)),
]


def _with(law: Law, values: tuple[float, ...], chi2: float) -> Fit:
    terms = (ActiveEffect(effect_of(law), values),)
    return Fit(terms, np.zeros((1, 5)), np.zeros(0), chi2=chi2)


def test_a_shape_is_tried_behind_the_lag_of_a_line_of_the_same_motion() -> None:
    """A brake that answers late from a yaw rate on: a dead zone sees half of it, a lag half."""
    bent = Law("moment_car", "yaw_rate_car", "dead zone")
    late = Law("moment_car", "yaw_rate_car", power=1, response="lagged")
    slip = Law("moment_car", "lateral_acceleration_car", "dead zone")
    fits = [
        _with(bent, (-11000.0, 0.01), 4.1),
        _with(late, (-10800.0, 0.12), 3.9),
        _with(slip, (-900.0, 0.3, 0.02), 2.9),  # what is felt has a lag already
        _with(Law("hitch", "yaw_rate_car", "dead zone"), (-7000.0, 0.01), 4.2),
    ]
    known, other = crossed(fits, 4)
    assert law_in(known.terms[-1]) == replace(bent, response="lagged")
    assert known.terms[-1].as_dict() == {"gain": -11000.0, "bend": 0.01, "lag_s": 0.12}
    assert law_in(other.terms[-1]).place == "hitch"
    assert other.terms[-1].as_dict()["lag_s"] == pytest.approx(0.1)
    assert crossed(fits, 1)[0].terms == known.terms


@pytest.mark.parametrize(
    ("law", "values"),
    [
        (Law("force_trailer", "heading"), (9000.0,)),
        (Law("slip_trailer", "roll_trailer", "hysteretic"), (0.15, 0.01, 8.0, 0.25)),
        (Law("hitch", "articulation_rate", "falling"), (9000.0, 0.04)),
        *(pytest.param(*case, marks=pytest.mark.long) for case in LONG),
    ],
)
def test_a_law_is_found_whose_straight_form_is_not_or_is_the_librarys(
    law: Law, values: tuple[float, ...]
) -> None:
    """A scrub is nearly of one size; a hydraulic damper is no damping; a wind no motion."""
    found = Laws([searched((ActiveEffect(effect_of(law), values),))]).discover([], silent)
    assert found is not None
    assert found.law == law
    if law.shape == "saturating":  # its size; how steeply it gets there is hardly seen
        values = (values[0] * values[1],)
        assert found.term.values[0] * found.term.values[1] == pytest.approx(values[0], rel=0.05)
    else:
        assert found.term.values == pytest.approx(values, rel=0.05)


@pytest.mark.parametrize(
    ("law", "values"),
    [
        (Law("hitch", "articulation", "dead zone"), (60000.0, 0.025)),
        (Law("slip_trailer", "articulation", "hysteretic"), (0.3, 0.01)),
        (Law("slip_trailer", "roll_trailer", "hysteretic"), (0.15, 0.01, 8.0, 0.25)),
        (Law("hitch", "articulation", "rubbing"), (4000.0,)),
        (Law("moment_car", "yaw_rate_trailer", "cube"), (1.5e5,)),
        (Law("moment_car", "articulation", "saturating", 2), (44000.0, 0.02)),
        (Law("slip_car_front", "steer_rate", "dead zone"), (-0.2, 0.02, 0.05)),
        (Law("force_trailer", "sideslip_car", power=2), (9000.0,)),
        (Law("slip_trailer", "heading"), (-0.1,)),
        (Law("hitch", "articulation", response="transient"), (8000.0, 0.3)),
    ],
)
def test_the_law_that_acts_is_among_the_few_that_are_begun(
    law: Law, values: tuple[float, ...]
) -> None:
    """By one to four simulations of most, from either vehicle (file, calibrated).

    Among a quarter of all laws, and so in the first quarter of those that are begun.
    """
    close = searched((ActiveEffect(effect_of(law), values),)).close
    some = list(dict.fromkeys([law, *all_laws()[::4]]))
    terms = [term for other in some for term in initial(other)]
    spent = close.problem.budget.spent_s
    places = []
    for fit in (close.run(close.start(), 20), close.start()):
        ranked = [law_in(term) for term in by_promise(everything(close).course(fit), terms)]
        assert set(ranked) == set(some)
        places.append(ranked.index(law))
    assert min(places) < SCREENED // 4, places
    seconds = sum(run.time.size for run in close.problem.runs) / 100.0
    assert close.problem.budget.spent_s - spent < 5.0 * len(terms) * seconds


def test_a_controller_that_compares_two_motions_is_found() -> None:
    """Neither motion alone leaves only noise; the right difference does."""
    law = Law("moment_car", "yaw_rate_car", second="steer")
    found = Laws([searched((ActiveEffect(effect_of(law), (-30000.0, -5.0)),))]).discover([], silent)
    assert found is not None
    assert (found.law.place, found.law.shape, found.law.response) == (
        "moment_car", "straight", "instant",
    )  # fmt: skip
    assert {found.law.motion, found.law.second} == {"yaw_rate_car", "steer"}
    seen_as_the_law_says(found)
    rows = {
        name: {"value": value, "low": 1.1 * value, "high": 0.9 * value}
        for name, value in (("gain", -3e4), ("second_share", -5.0))
    }
    assert "yaw rate of the car less 5.00 +- 0.50 times the steering angle" in sentence(law, rows)


def test_what_comes_and_goes_along_the_road_is_found_with_a_phase_for_each_run() -> None:
    """How often is seen in what the vehicle leaves; every axle in turn, as it comes there."""
    law = Law("axles", "distance", response="periodic")
    runs = tuple(map(stretch, searched(()).problem.runs))
    effect = effect_of(law, runs=runs)
    search = searched((ActiveEffect(effect, (0.003, 17.3, *np.linspace(0.4, 2.0, len(runs)))),))
    left_over = [
        search.close.evaluate(r, (), np.zeros(5), search.close.start().shift)
        for r in range(len(runs))
    ]
    assert repetitions(search.problem.runs, left_over)[0] == pytest.approx(17.3, abs=0.3)
    found = Laws([search]).discover([], silent)
    assert found is not None
    assert (found.law.place, found.law.motion, found.law.response) == (
        "axles", "distance", "periodic",
    )  # fmt: skip
    values = found.term.as_dict()
    assert values["repetitions_per_km"] == pytest.approx(17.3, abs=0.05)
    assert abs(values["gain"]) == pytest.approx(0.003, rel=0.05)
    again = effect_of_form(str(found.term.effect.extra["form"]))
    assert [p.name for p in again.parameters] == [p.name for p in effect.parameters]
    nothing = plant()
    again.act(nothing, search.problem.runs[0], values, ())  # its phase is not known in a new run
    assert not any(np.any(course) for course in nothing.series.values())
    with pytest.raises(SwaywatchError, match="a phase of its own in every run"):
        named("ruts", law.spec, {})


@pytest.mark.parametrize("place", ["moment_trailer", "drag_trailer"])
def test_what_pulls_one_way_along_the_road_is_no_sine(place: str) -> None:
    """A verge drags in stretches, and never pushes; air does not hold the trailer back."""
    law = Law(place, "distance", "positive side", response="periodic")
    runs = tuple(map(stretch, searched(()).problem.runs))
    effect = effect_of(law, runs=runs)
    acts = ActiveEffect(effect, (-1500.0, 17.3, *np.linspace(0.4, 2.0, len(runs))))
    search = searched((acts,))
    found = Laws([search]).discover([], silent)
    assert found is not None
    assert found.law == law
    values = found.term.as_dict()
    assert values["repetitions_per_km"] == pytest.approx(17.3, abs=0.05)
    assert values["gain"] == pytest.approx(-1500.0, rel=0.05)
    rows = {name: {"value": v, "low": v - 0.1, "high": v + 0.1} for name, v in values.items()}
    assert "one way only, with nothing between, 17.3" in sentence(law, rows)
    assert "positive" not in sentence(law, rows)
    assert "max(sin(" in effect.equation
    run, slots = search.problem.runs[0], plant()
    slots.speed = run.speed
    effect.act(slots, run, acts.as_dict(), ())
    assert np.max(slots.series["moment_trailer"]) <= 0.0
    assert np.mean(slots.series["moment_trailer"] == 0.0) > 0.3


SPRING, LOAD = Law("hitch", "articulation"), Law("trailer", "swing")


@pytest.mark.parametrize(
    ("acts", "values", "tried", "begun", "kept"),
    [
        (LOAD, (90.0, 0.85, 0.05, -0.6), replace(LOAD, shape="odd square"), 0.0, LOAD),
        (SPRING, (4000.0,), replace(SPRING, response="lagged"), 0.01, SPRING),
        (
            replace(SPRING, response="lagged"), (4000.0, 0.2),
            replace(SPRING, response="lagged"), 0.2, replace(SPRING, response="lagged"),
        ),
    ],
)  # fmt: skip
def test_a_number_that_a_law_does_not_need_is_not_reported(
    acts: Law, values: tuple[float, ...], tried: Law, begun: float, kept: Law
) -> None:
    """A drag of 0.0 beside a swinging load, and a spring that is 10 ms late, say nothing."""
    search = searched((ActiveEffect(effect_of(acts), values),))
    base = search.baseline()
    count = len(effect_of(tried).parameters)
    term = ActiveEffect(effect_of(tried), (*values[: count - 1], begun))
    fit = search.judge.run(replace(search.judge.start(), terms=(term,)), 20, tolerance=1e-6)
    plain = LawSearch(Tried(search, base, base)).plain(Candidate(fit, base.fit))
    assert law_in(plain.fit.terms[0]) == kept


@pytest.mark.parametrize("near", ["straight", "saturating", "dead zone"])
def test_what_is_off_or_on_is_found_from_any_form_near_it(near: str) -> None:
    law = Law("moment_trailer", "yaw_rate_trailer", "switched")
    close = searched((ActiveEffect(effect_of(law), (-30000.0, 0.03)),)).close
    starts = [replace(close.start(), terms=(t,)) for t in initial(replace(law, shape=near))]
    best = min((close.run(start, 12) for start in starts), key=lambda fit: fit.chi2)
    assert reduced_chi_square(best) > 5.0
    bent = close.run(replace(best, terms=(in_form(best.terms[-1], law),)), 15)
    assert bent.terms[-1].values == pytest.approx((-30000.0, 0.03), rel=0.05)
    assert reduced_chi_square(bent) < NOISE_CLOSE


def test_a_swinging_load_is_found_with_its_frequency() -> None:
    effect = effect_of(Law("trailer", "swing"))
    truth = ActiveEffect(effect, (90.0, 0.85, 0.05, -0.6))
    found = Laws([searched((truth,))]).discover([], silent)
    assert found is not None
    assert (found.law.place, found.law.swings) == ("trailer", True)
    mass, hertz, damping, place = found.term.values
    assert hertz == pytest.approx(0.85, abs=0.01)
    assert mass == pytest.approx(90.0, rel=0.1)
    assert damping == pytest.approx(0.05, abs=0.02)
    assert place == pytest.approx(-0.6, abs=0.2)


def test_laws_are_begun_only_where_one_promises_enough() -> None:
    """Beside the library effect that acts none does; beside one that only passes for a law, one."""
    relaxation = ActiveEffect(effect("tyre_relaxation:car_rear"), (0.5,))
    search = searched((relaxation,))
    base = search.baseline()
    fit = search.judge.run(replace(base.fit, terms=(relaxation,)), 12)
    right = Tried(search, base, Candidate(fit, base.fit))
    assert right.clean
    assert not LawSearch(right).promising()
    spent = search.problem.budget.spent_s
    assert Laws([search]).discover([right], silent) is None
    seconds = sum(run.time.size for run in search.problem.runs) / 100.0
    assert search.problem.budget.spent_s - spent < 6.0 * len(all_laws()) * seconds

    law = ActiveEffect(effect_of(Law("hitch", "articulation")), (1000.0,))
    search = searched((law,))
    base = search.baseline()
    passing = replace(base.fit, terms=(relaxation,), count=10**9)  # a misfit that passes for noise
    wrong = Tried(search, base, Candidate(passing, base.fit))
    assert wrong.clean
    assert LawSearch(wrong).promising()


def test_nothing_is_found_where_nothing_is_missing() -> None:
    assert Laws([searched(())]).discover([], silent) is None
