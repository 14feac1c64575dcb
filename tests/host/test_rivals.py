"""An explanation is claimed where it beats others of its size, all of them fitted to the end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_diagnose import BODY_VALUES, effect, synthetic

from swaywatch.diagnose.evidence import baselines
from swaywatch.diagnose.evidence.baselines import _ended, _noticeable_to_the_end, _with_rivals
from swaywatch.diagnose.evidence.evidence import APART
from swaywatch.diagnose.evidence.rivals import SHARE, rivals, to_the_end
from swaywatch.diagnose.evidence.search import BENT, Candidate, Search
from swaywatch.diagnose.fit.beliefs import beliefs_of
from swaywatch.diagnose.fit.fit import COMPARED, Fit, Fitter, Problem
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library

GAIN, RATIO = "sensor_gain:steering_wheel_angle", "parameter_error:car.steering_ratio"
SATURATION, DEGRESSION = "tyre_saturation:all", "tyre_load_sensitivity:all"


def _believed(*terms: ActiveEffect) -> Problem:
    problem = synthetic(terms, seed=3)
    channels = [n for n in COMPARED if n in problem.runs[0].channels]
    return replace(problem, beliefs=beliefs_of(BODY_VALUES, channels))


def _term(name: str) -> ActiveEffect:
    return ActiveEffect(effect(name), tuple(p.starts[0] for p in effect(name).parameters))


def _silent(stage: str, share: float) -> None:
    del stage, share


def _found(search: Search, name: str, values: tuple[float, ...]) -> Fit:
    base = search.baseline().fit
    start = replace(base, terms=(ActiveEffect(effect(name), values),))
    return to_the_end(search, [start])[0]


@pytest.mark.parametrize("speed", [33.0, 35.0])
def test_derivatives_are_true_near_the_critical_speed(speed: float) -> None:
    """Against differences both ways, extrapolated; steps of 0.05 tolerances are 4 and 5 % off."""
    problem = _believed()
    problem.runs[0].speed = np.full(problem.runs[0].speed.size, speed)
    fitter = Fitter(problem)
    start = fitter.start()
    found = fitter.backgrounds(start, [0])[0][0]

    def at(place: int, h: float) -> np.ndarray:
        shift, nuisance = start.shift.copy(), start.nuisance[0].copy()
        if place < shift.size:
            shift[place] += h
        else:
            nuisance[place - shift.size] += 1e-3 * h
        return fitter.evaluate(0, (), nuisance, shift)

    places = [*fitter._simulated, *range(start.shift.size, found.shape[1])]
    errors = []
    for place in places:
        wide, narrow = ((at(place, h) - at(place, -h)) / (2.0 * h) for h in (0.02, 0.01))
        true = (4.0 * narrow - wide) / 3.0
        true /= 1.0 if place < start.shift.size else 1e-3
        size = float(np.linalg.norm(true))
        if size > 1.0:
            errors.append(float(np.linalg.norm(found[:, place] - true)) / size)
    assert len(errors) > 15
    assert max(errors) < 0.003


def test_a_wrong_explanation_gives_way_to_the_right_one_of_its_size() -> None:
    """Though the search has fitted only the wrong one."""
    truth = ActiveEffect(effect(SATURATION), (1.2,))
    search = Search(_believed(truth), library(()), _silent)
    base = search.baseline().fit
    wrong = search.weighed(Candidate(_found(search, DEGRESSION, (0.2, 1.0)), base))
    found = _with_rivals(search, [wrong])
    assert found[0].names == (SATURATION,)
    assert found[0].evidence > search.weighed(wrong).evidence + APART
    assert found[0].fit.terms[0].values == pytest.approx((1.2,), rel=0.05)
    # what it was compared with stays in the ranking
    assert {SATURATION} == {c.names[0] for c in search.tried if c.fit is found[0].fit}


def test_of_two_that_are_the_same_both_are_tried_and_others_are_not() -> None:
    truth = ActiveEffect(effect(GAIN), (1.05,))
    search = Search(_believed(truth), library(()), _silent)
    best = search.weighed(Candidate(_found(search, GAIN, (1.02,)), search.baseline().fit))
    screened = {r.start.terms[-1].effect.name: r.share for r in rivals(search, best.fit, 0)}
    assert screened.pop(RATIO) == pytest.approx(1.0, abs=0.05)
    assert max(screened.values()) < SHARE
    spent = search.problem.budget.spent_s
    found = {c.names[0]: c.evidence for c in _with_rivals(search, [best])}
    assert set(found) == {GAIN, RATIO}
    assert abs(found[GAIN] - found[RATIO]) < APART
    # a screening simulates each effect a few times, a fit some fifty times
    runs = sum(run.time.size for run in search.problem.runs) / 100.0
    assert search.problem.budget.spent_s - spent < 12.0 * len(search.effects) * runs


@pytest.mark.parametrize(
    ("left", "promise", "ended"),
    [
        (0.9, 90.0, [DEGRESSION, SATURATION]),
        (0.9, 10.0, [DEGRESSION]),  # it promised far less
        (0.5, 90.0, [DEGRESSION]),  # what takes so much away was fitted from rest, as were others
    ],
)
def test_those_that_promise_nearly_as_much_are_fitted_to_the_end_too(
    left: float, promise: float, ended: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fit that went nowhere ranks behind, whatever it would have come to."""
    search = Search(_believed(), library(()), _silent)
    base = replace(search.judge.start(), chi2=1000.0, count=1000)
    asked: list[str] = []

    def to_the_end(search: Search, starts: list[Fit], *, afresh: bool) -> list[Fit]:
        assert afresh is (left > BENT)
        asked.extend(f.terms[0].effect.name for f in starts)
        return [replace(f, chi2=f.chi2 - 500.0 * (f is not starts[0])) for f in starts]

    monkeypatch.setattr(baselines, "to_the_end", to_the_end)
    shares = {DEGRESSION: left, SATURATION: 0.99, RATIO: 0.995}
    found = [
        Candidate(replace(base, terms=(_term(name),), chi2=1000.0 * share), base)
        for name, share in shares.items()
    ]
    search._promises[id(base)] = base, {DEGRESSION: 100.0, SATURATION: promise, RATIO: 1.0}
    names = [c.names[0] for c in _ended(search, found)]
    assert asked == ended
    assert [c.names[0] for c in search.tried] == ended  # with these fits, for what is said of them
    assert sorted(names) == sorted(shares)
    assert names[0] == ended[-1]


def test_what_ends_at_a_bound_is_not_claimed(monkeypatch: pytest.MonkeyPatch) -> None:
    """It may have been inside before it was fitted to the end."""
    search = Search(_believed(), library(()), _silent)
    base = search.judge.start()
    low = effect(GAIN).parameters[0].low

    def ended(search: Search, found: list[Candidate]) -> list[Candidate]:
        del search
        first = found[0]
        if first.names == (GAIN,):
            at_bound = replace(_term(GAIN), values=(low,))
            first = replace(first, fit=replace(first.fit, terms=(at_bound,)))
        return [first, *found[1:]]

    monkeypatch.setattr(baselines, "_ended", ended)
    both = [Candidate(replace(base, terms=(_term(n),)), base) for n in (GAIN, RATIO)]
    assert [c.names for c in _noticeable_to_the_end(search, both)] == [(RATIO,)]
    assert _noticeable_to_the_end(search, both[:1]) == []
