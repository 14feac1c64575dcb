"""Which vehicle a diagnosis searches first: what one effect beside each of them leaves decides."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from swaywatch.diagnose.evidence import baselines, verdict
from swaywatch.diagnose.evidence import search as search_room
from swaywatch.diagnose.evidence.baselines import Path, explore
from swaywatch.diagnose.evidence.evidence import worth
from swaywatch.diagnose.evidence.search import PROMISED, Candidate, Search
from swaywatch.diagnose.evidence.verdict import (
    SHOWN,
    Verdict,
    _clear,
    _clear_ones,
    _shown,
    _to_the_end,
    possible_of,
)
from swaywatch.diagnose.fit.beliefs import beliefs_of
from swaywatch.diagnose.fit.fit import Fit, Problem
from swaywatch.diagnose.report.describe import too_small
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import library
from swaywatch.plant.lanes import BODY

COUNT = 1000
FRICTION = next(e for e in library() if e.name == "hitch_friction:hitch")
TERM = ActiveEffect(FRICTION, tuple(p.starts[0] for p in FRICTION.parameters))
WINDOWED = next(e for e in library() if e.windowed)
GUST = ActiveEffect(WINDOWED, (2.0, 4.0, *(p.starts[0] for p in WINDOWED.parameters)), (0,))


def _fit(reduced: float, *terms: ActiveEffect) -> Fit:
    return Fit(terms, np.zeros((1, 5)), np.zeros(0), reduced * COUNT, COUNT)


def _search(name: str, calibrated: float, evidence: float) -> Search:
    base = Candidate(_fit(calibrated), _fit(calibrated), evidence)
    return cast(
        "Search",
        SimpleNamespace(
            name=name, noise=1.0, progress=None, weighed=lambda c: c, baseline=lambda: base,
            refuses=lambda what: name == "rigid", on_springs=name == "springs",
        ),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("rigid", "beside_springs", "order"),
    [
        (1.1, 0.0, ["rigid 1"]),  # one effect leaves only noise: nothing else is searched
        (12.0, 1.2, ["rigid 1", "springs 3"]),  # the same effect leaves far less on springs
        (12.0, 11.0, ["rigid 1", "rigid 3", "springs 3"]),  # it does not: the likelier one first
    ],
)
def test_a_rigid_vehicle_far_behind_with_the_same_effect_is_not_searched_to_the_end(
    rigid: float, beside_springs: float, order: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    searched: list[str] = []
    left = {"rigid": rigid, "springs": 1.1 if beside_springs < 2.0 else 5.0}

    def path(search: Any, base: Candidate, *_: object, most: int = 3, **__: object) -> Path:
        searched.append(f"{search.name} {most}")
        return Path(search, base, Candidate(_fit(left[search.name], TERM), base.fit))

    def again(search: Any, terms: object, base: object) -> Fit:
        del terms, base
        return _fit(beside_springs if search.name == "springs" else rigid, TERM)

    monkeypatch.setattr(baselines, "path", path)
    monkeypatch.setattr(baselines, "_again", again)
    monkeypatch.setattr(baselines, "_exact", lambda path: False)
    explore(
        [_search("rigid", 190.0, -1e5)], _search("springs", 700.0, -4e5), lambda stage, share: None
    )
    assert searched == order


@pytest.mark.parametrize(
    ("one_lasting", "order"), [(1.1, ["rigid 1"]), (12.0, ["springs 3", "rigid 3"])]
)
def test_one_lasting_effect_is_tried_on_a_rigid_vehicle_that_is_far_behind(
    one_lasting: float, order: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where much is missing from both, the misfits of the calibrated vehicles say little."""
    searched: list[str] = []

    def path(search: Any, base: Candidate, *_: object, most: int = 3, **__: object) -> Path:
        searched.append(f"{search.name} {most}")
        left = one_lasting if search.name == "rigid" else 5.0
        return Path(search, base, Candidate(_fit(left, TERM), base.fit))

    def extend(parent: Fit, *, windowed: bool) -> list[Candidate]:
        assert not windowed
        return [Candidate(_fit(one_lasting, TERM), parent)]

    monkeypatch.setattr(baselines, "path", path)
    monkeypatch.setattr(baselines, "_exact", lambda path: False)
    rigid = _search("rigid", 48.0, -4e5)
    vars(rigid)["extend"] = extend
    explore([rigid], _search("springs", 19.0, -1e5), lambda stage, share: None)
    assert searched == order


@pytest.mark.parametrize(
    ("in_windows", "first"), [(1.37, "hitch_friction"), (1.2, "axle_load_harmonic")]
)
def test_beside_a_simulation_windows_must_take_away_more_than_a_lasting_effect_leaves(
    in_windows: float, first: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """There the form of a right effect leaves misfit, which windows of a wrong one can follow."""
    load = next(e for e in library() if e.name == "axle_load_harmonic:car_rear")
    rows = [p.starts[0] for p in load.parameters]
    window = ActiveEffect(load, (5.0, 15.0, *rows), (0,))
    found = [
        Candidate(_fit(left, term), _fit(1.7), -0.5 * left * COUNT)
        for left, term in ((in_windows, window), (1.4, TERM))
    ]
    base = Candidate(_fit(1.7), _fit(1.7), -0.5 * 1.7 * COUNT)
    search = SimpleNamespace(
        problem=SimpleNamespace(free_start=False), noise=1.0, on_springs=False, beyond=None,
        weighed=lambda c: c, baseline=lambda: base, tried=[],
        refuses=lambda what: what == baselines.TRIED[1], extend=lambda *_, **__: found,
        judge=SimpleNamespace(run=lambda fit, *_, **__: fit),
    )  # fmt: skip
    monkeypatch.setattr(baselines, "noticeable", lambda term: True)
    path = baselines.path(cast("Search", search), base, lambda stage, share: None)
    assert [t.effect.id for t in path.best.fit.terms] == [first]


@pytest.mark.parametrize(
    ("calibrated", "slight", "large", "named"),
    [
        (1.25, 1.05, 1.15, []),  # of noise the slight one takes more
        (1.25, 1.17, 1.15, ["hitch_friction"]),
        (1.6, 1.4, 1.45, ["hitch_friction"]),  # more than noise is left: something is there
        (1.6, 1.05, 1.15, ["hitch_damping"]),  # however small, it alone leaves only noise
    ],
)
def test_what_a_slight_effect_explains_better_is_not_claimed(
    calibrated: float, slight: float, large: float, named: list[str]
) -> None:
    """A weak gust on the car was called a banked road, a late sensor a trailer that steers."""
    damping = next(e for e in library() if e.name == "hitch_damping:hitch")
    small = ActiveEffect(damping, tuple(p.neutral + 0.5 * p.minimum for p in damping.parameters))
    size = FRICTION.parameters[0].neutral + 2.0 * FRICTION.parameters[0].minimum
    claim = ActiveEffect(FRICTION, (size, *TERM.values[1:]))
    base = Candidate(_fit(calibrated), _fit(calibrated), -0.5 * calibrated * COUNT)
    found = [
        Candidate(_fit(left, term), base.fit, -0.5 * left * COUNT)
        for left, term in ((slight, small), (large, claim))
    ]
    search = SimpleNamespace(
        problem=SimpleNamespace(free_start=True), noise=1.0, on_springs=False, beyond=None,
        weighed=lambda c: c, baseline=lambda: base, tried=[], rebased=lambda fit: False,
        refuses=lambda what: what == baselines.TRIED[1], extend=lambda *_, **__: found,
        judge=SimpleNamespace(run=lambda fit, *_, **__: fit),
    )  # fmt: skip
    path = baselines.path(cast("Search", search), base, lambda stage, share: None)
    assert [t.effect.id for t in path.best.fit.terms] == named


def test_small_pieces_in_windows_that_leave_only_noise_are_no_claim() -> None:
    """Fourteen gusts of 10 to 97 N to both sides had imitated a brake that the drawbar pulls."""
    gust = next(
        e for e in library()
        if e.name == "crosswind_gust:trailer" and e.extra["form"] == "box"
    )  # fmt: skip
    pieces = [(4.0 * w, 4.0 * w + 2.0, 60.0 * (-1.0) ** w) for w in range(8)]
    values = tuple(v for piece in pieces for v in piece)
    damping = next(e for e in library() if e.name == "hitch_damping:hitch")
    small = tuple(p.neutral + 0.5 * p.minimum for p in damping.parameters)
    base = Candidate(_fit(2.1), _fit(2.1))
    windows, lasting = (
        Candidate(_fit(1.05, term), base.fit)
        for term in (ActiveEffect(gust, values, (0,) * 8), ActiveEffect(damping, small))
    )
    assert baselines._claims(base, base, [windows, lasting]) == ([lasting], [windows])


def test_what_another_vehicle_found_says_how_large_an_independent_sample_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A gust of 780 N had an interval of 4,700 N: its noise stayed that of the bare vehicle."""
    base = Candidate(_fit(20.0), _fit(20.0), -10.0 * COUNT)
    known = _fit(1.03, TERM)
    poor = Candidate(_fit(18.0, TERM), base.fit, -9.0 * COUNT)
    monkeypatch.setattr(search_room, "residuals", lambda judge, fit: fit)
    monkeypatch.setattr(search_room, "inflation", lambda fit: 20.0 * fit.chi2 / COUNT)
    search = Search.__new__(Search)
    search.noise, search.tried, search.beyond = 400.0, [], None
    search.judge = cast("Any", SimpleNamespace(run=lambda fit, *_, **__: fit))
    search.problem = cast("Any", SimpleNamespace(free_start=True, on_springs=False))
    for name, stub in {
        "weighed": lambda c: replace(c, evidence=-0.5 * c.fit.chi2),
        "extend": lambda *_, **__: [poor],
        "refuses": lambda what: what == baselines.TRIED[1],
        "baseline": lambda: base,
        "rebased": lambda fit: False,
        "settled": lambda parent, fits: True,
    }.items():
        monkeypatch.setattr(search, name, stub, raising=False)
    monkeypatch.setattr(baselines, "noticeable", lambda term: True)
    path = baselines.path(search, base, lambda stage, share: None, known=known)
    assert path.best.fit is known
    assert search.noise == pytest.approx(20.0 * 1.03)


def test_what_is_claimed_is_in_the_list_of_explanations_wherever_it_stands() -> None:
    """Its factor is what a reader compares the others with."""
    each = {e.name: e for e in library() if not e.windowed}
    effects = list(each.values())[: SHOWN + 3]
    every = [
        Candidate(_fit(1.0, ActiveEffect(e, tuple(p.starts[0] for p in e.parameters))),
                  _fit(2.0), -float(place))
        for place, e in enumerate(effects)
    ]  # fmt: skip
    plain = Candidate(_fit(2.0), _fit(2.0), -1000.0)
    claimed = every[-1]
    shown = _shown([*every, plain], claimed, plain)
    assert [name for name, _ in shown] == [*(e.name for e in effects[:SHOWN]), effects[-1].name]
    assert shown[-1][1] == 1000.0 - (SHOWN + 2)


@pytest.mark.parametrize(("calibrated", "left"), [(1.3, 1.2), (190.0, 1.2)])
def test_what_an_effect_must_promise_is_half_of_what_makes_it_worth_it(
    calibrated: float, left: float
) -> None:
    """The stronger the first effect, the more its form leaves, and the more a second must take."""
    search = Search(Problem((), np.zeros(len(BODY))), [], lambda stage, share: None)
    search._base = Candidate(_fit(calibrated), _fit(calibrated))
    before = _fit(left, TERM)
    least = search._promised(search.judge, before, windowed=False) / PROMISED
    for share, enough in ((0.99, False), (1.01, True)):
        after = Fit((*before.terms, TERM), before.nuisance, before.shift)
        after.chi2, after.count = before.chi2 - share * least, COUNT
        assert worth(_fit(calibrated), before, after) is enough
    assert search._promised(search.judge, _fit(5.0, TERM), windowed=False) == 0.0


def test_a_likelier_fit_at_a_bound_does_not_stand_for_a_claim() -> None:
    """Else the claim's own effects are missing from what its confidence is a share of."""
    most = FRICTION.parameters[0].high
    at_bound = ActiveEffect(FRICTION, (most, *TERM.values[1:]))
    damping = next(e for e in library() if e.name == "hitch_damping:hitch")
    damped = ActiveEffect(damping, tuple(p.starts[0] for p in damping.parameters))
    best, likelier, other = (
        Candidate(_fit(1.0, term), _fit(2.0), evidence)
        for term, evidence in ((TERM, -20.0), (at_bound, -10.0), (damped, -21.0))
    )
    found = possible_of(best, [likelier, best, other])
    assert [c.evidence for c in found] == [-20.0, -21.0]


@pytest.mark.parametrize(("error_nm", "claimed"), [(2.0, True), (30.0, False)])
def test_an_effect_whose_interval_reaches_nothing_is_not_claimed(
    error_nm: float, claimed: bool
) -> None:
    """Beside a second one that is clear it alone is left out."""
    damping = next(e for e in library() if e.name == "hitch_damping:hitch")
    clear = ActiveEffect(damping, tuple(100.0 * p.minimum for p in damping.parameters))
    size = FRICTION.parameters[0].neutral + 20.0 * FRICTION.parameters[0].minimum
    weak = ActiveEffect(FRICTION, (size, *TERM.values[1:]))
    errors = [1e-3] * len(clear.values) + [error_nm] + [1e-3] * (len(weak.values) - 1)
    fit = replace(_fit(1.0, clear, weak), covariance=np.diag(np.square(errors)))
    assert _clear(fit, 0, 1.0)
    assert _clear(fit, 1, 1.0) == claimed
    alone = replace(_fit(1.02, clear), covariance=np.diag(np.square(errors[:1])))
    judge = SimpleNamespace(run=lambda f, *_, **__: f)
    search = cast("Search", SimpleNamespace(noise=1.0, judge=judge, without=lambda f, i: alone))
    kept = _clear_ones(search, _fit(3.0), fit)
    assert [t.effect.id for t in kept.terms] == ["hitch_damping", "hitch_friction"][: 1 + claimed]
    needed = _fit(2.0, clear)  # without it more than noise is left
    search = cast("Search", SimpleNamespace(noise=1.0, judge=judge, without=lambda f, i: needed))
    assert _clear_ones(search, _fit(3.0), fit) is fit


@pytest.mark.parametrize(
    ("calibrated", "left", "stays"),
    [(2.86, 1.7, True), (2.3, 1.7, False), (1.25, 1.05, False)],
)
def test_what_takes_away_most_of_a_misfit_stays_however_wide_its_interval(
    calibrated: float, left: float, stays: bool
) -> None:
    """A damper of which nothing is left, at its bound, had an interval up to nearly all of it."""
    size = FRICTION.parameters[0].neutral + 20.0 * FRICTION.parameters[0].minimum
    wide = ActiveEffect(FRICTION, (size, *TERM.values[1:]))
    errors = [30.0] + [1e-3] * (len(wide.values) - 1)
    fit = replace(_fit(left, wide), covariance=np.diag(np.square(errors)))
    search = SimpleNamespace(
        noise=1.0, judge=SimpleNamespace(run=lambda f, *_, **__: f), on_springs=False, effects=[],
        problem=SimpleNamespace(beliefs=beliefs_of(np.full(len(BODY), 1e5), ())),
    )  # fmt: skip
    assert len(_clear_ones(cast("Search", search), _fit(calibrated), fit).terms) == stays


@pytest.mark.parametrize(
    ("beside_it", "without_it", "stays"),
    [(0.5, -4.5, True), (-4.4, -4.5, False), (0.5, 0.6, False)],
)
def test_what_is_not_clear_stays_where_without_it_a_value_is_beyond_belief(
    beside_it: float, without_it: float, stays: bool
) -> None:
    """A trailer's roll steer of -0.028 (right: -0.032) was called tyres 22 % too soft."""
    beliefs = beliefs_of(np.full(len(BODY), 1e5), ())
    at = beliefs.at["vehicle", "trailer.rear_cornering_stiffness"]

    def off(fit: Fit, tolerances: float) -> Fit:
        shift = np.zeros(len(beliefs))
        shift[at] = tolerances
        return replace(fit, shift=shift, shift_covariance=1e-4 * np.eye(len(beliefs)))

    size = FRICTION.parameters[0].neutral + 20.0 * FRICTION.parameters[0].minimum
    weak = ActiveEffect(FRICTION, (size, *TERM.values[1:]))
    errors = [30.0] + [1e-3] * (len(weak.values) - 1)
    fit = replace(off(_fit(1.03, weak), beside_it), covariance=np.diag(np.square(errors)))
    base = off(_fit(1.07), without_it)
    judge = SimpleNamespace(run=lambda f, *_, **__: f)
    search = SimpleNamespace(
        noise=1.0, judge=judge, on_springs=False, effects=library(),
        problem=SimpleNamespace(beliefs=beliefs, body=np.full(len(BODY), 1e5)),
    )  # fmt: skip
    kept = _clear_ones(cast("Search", search), base, fit)
    assert len(kept.terms) == stays


@pytest.mark.parametrize(("without_it", "stays"), [(-3.0, True), (60.0, False)])
def test_what_is_not_clear_stays_where_a_clear_effect_is_nothing_without_it(
    without_it: float, stays: bool
) -> None:
    damping = next(e for e in library() if e.name == "hitch_damping:hitch")
    clear = ActiveEffect(damping, tuple(100.0 * p.minimum for p in damping.parameters))
    size = FRICTION.parameters[0].neutral + 20.0 * FRICTION.parameters[0].minimum
    weak = ActiveEffect(FRICTION, (size, *TERM.values[1:]))
    errors = [1e-3] * len(clear.values) + [30.0] + [1e-3] * (len(weak.values) - 1)
    fit = replace(_fit(1.0, clear, weak), covariance=np.diag(np.square(errors)))
    alone = replace(_fit(1.02, clear), covariance=np.diag(np.square(errors[:1])))
    judge = SimpleNamespace(run=lambda f, *_, **__: f)
    search = SimpleNamespace(
        noise=1.0, judge=judge, without=lambda f, i: alone,
        weighed=lambda c: replace(c, evidence=without_it),
    )  # fmt: skip
    best = Candidate(fit, _fit(3.0), evidence=100.0)
    found = _to_the_end(cast("Search", search), _fit(3.0), best, 10.0)
    assert len(found.fit.terms) == 1 + stays
    assert found.evidence == (100.0 if stays else without_it)


@pytest.mark.parametrize(
    ("evidence", "stretched", "compared"),
    [(10.0, False, "baseline"), (10.0, True, "written"), (0.0, False, "written")],
)
def test_a_claim_is_not_compared_with_a_vehicle_that_nobody_would_believe(
    evidence: float, stretched: bool, compared: str
) -> None:
    base, written = _fit(1.01), _fit(400.0)
    verdict = Verdict(
        "missing_physics", _fit(1.0, TERM), base, cast("Problem", None),
        evidence=evidence, written=written, stretched=stretched,
    )  # fmt: skip
    assert verdict.before is {"baseline": base, "written": written}[compared]


@pytest.mark.parametrize(
    ("left", "stretched", "runs", "errors", "watched", "worse"),
    [
        (1.1, False, 2, (0.057, 0.026), 1.0, True),  # 0.052 and 0.023 without the effect
        (1.1, False, 2, (0.057, 0.026), 0.9, False),  # near the critical speed, by chance
        (1.1, False, 2, (0.040, 0.028), 1.0, False),
        (1.1, False, 2, (0.053, 0.023), 1.0, False),  # by chance
        (1.1, False, 1, (0.057, 0.026), 1.0, False),
        (1.1, True, 2, (0.057, 0.026), 1.0, False),
        (5.0, False, 2, (0.057, 0.026), 1.0, False),
    ],
)
def test_what_predicts_left_out_runs_worse_than_a_vehicle_that_leaves_noise_is_not_claimed(
    left: float,
    stretched: bool,
    runs: int,
    errors: tuple[float, ...],
    watched: float,
    worse: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    base, fit = _fit(left), _fit(0.99 * left, TERM)
    problem = Problem(cast("Any", (None,) * runs), np.zeros(0))
    search = SimpleNamespace(problem=problem)
    predicted = {id(base): (0.052, 0.023), id(fit): errors}

    def left_out(problem: Problem, f: Fit) -> list[float]:
        if problem.observer > 0.0:
            return [0.01 * (watched if f is fit else 1.0)] * runs
        return list(predicted[id(f)][:runs])

    monkeypatch.setattr(verdict, "left_out", left_out)
    monkeypatch.setattr(verdict, "_stretched", lambda search, base: stretched)
    assert verdict.predicts_worse(cast("Search", search), base, fit) is worse


@pytest.mark.parametrize(
    ("before", "after", "own_model", "claimed"),
    [
        (1.86, 1.77, True, False),  # a clock that drifts had been called roll steer
        (530.0, 519.0, True, False),
        (5.0, 3.0, True, True),  # one of two equal effects
        (3.4, 1.45, True, True),
        (1.86, 1.29, True, True),  # only noise is left
        (1.67, 1.47, False, True),  # beside the user's own simulation
    ],
)
def test_effects_that_leave_far_more_than_they_explain_are_not_claimed(
    before: float, after: float, own_model: bool, claimed: bool
) -> None:
    search = SimpleNamespace(problem=SimpleNamespace(free_start=own_model))
    leaves = verdict._leaves_most(cast("Search", search), _fit(before), _fit(after, TERM))
    assert leaves is not claimed


@pytest.mark.parametrize(
    ("before", "after", "claimed"),
    [
        (4.86, 3.28, False),  # eight gusts that follow a steering that moves in steps
        (68.9, 16.9, False),  # tyres that change in four windows, where a ring has worn in places
        (5.0, 3.0, False),
        (12.5, 1.45, True),
        (10.0, 1.96, True),
    ],
)
def test_windows_that_follow_the_misfit_are_not_claimed(
    before: float, after: float, claimed: bool
) -> None:
    search = SimpleNamespace(problem=SimpleNamespace(free_start=True))
    leaves = verdict._leaves_most(cast("Search", search), _fit(before), _fit(after, GUST))
    assert leaves is not claimed


@pytest.mark.parametrize(
    ("left", "own_model", "claimed"),
    [
        (34.6, True, False),  # bent: a trailer 1.7 times as heavy, a yaw inertia of a quarter
        (4.7, True, False),  # beside a hitch damper that explains 97 %: a yaw inertia of a tenth
        (1.2, True, True),
        (3.0, False, True),  # beside the user's own simulation
    ],
)
def test_values_of_the_file_are_called_wrong_only_where_noise_is_left(
    monkeypatch: pytest.MonkeyPatch, left: float, own_model: bool, claimed: bool
) -> None:
    search = SimpleNamespace(problem=SimpleNamespace(free_start=own_model))
    monkeypatch.setattr(verdict, "_beyond", lambda search, fit: replace(fit, terms=(TERM,)))
    found = verdict._wrong_values(cast("Search", search), _fit(left))
    assert bool(found.terms) is claimed


def test_what_is_too_small_to_report_is_said_where_nothing_is_claimed() -> None:
    """An engineer who knows that a gust was there sees that it was seen."""
    gust = next(e for e in library() if e.name == "crosswind_gust:car")
    row = [-p.minimum if p.name == "force_n" else p.neutral for p in gust.parameters]
    at = [p.name for p in gust.parameters].index("force_n")
    rows = [[start, start + 2.0, *row] for start in (5.0, 15.0)]
    rows[0][2 + at] *= 0.4
    rows[1][2 + at] *= 0.6
    term = ActiveEffect(gust, tuple(value for window in rows for value in window), (0, 0))
    small = Candidate(_fit(1.05, term), _fit(1.2))
    assert baselines.is_slight(small)
    base = _fit(1.2)
    said = Verdict("consistent", base, base, cast("Problem", None), slight=small)
    (text,) = too_small(said)
    least = gust.parameters[at].minimum
    assert f"crosswind gust (car), force {-0.6 * least:.4g} N" in text
    assert f"reported from a change of {least:.4g} on" in text
    assert too_small(replace(said, slight=None)) == []
    assert "but is too small to report: " in text
    (both,) = too_small(replace(said, slight=Candidate(_fit(1.05, term, TERM), _fit(1.2))))
    assert "together, but not all of it is large enough to report: " in both
