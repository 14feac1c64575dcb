"""A diagnosis ends with a verdict or a named error: runaways, failed parts, bounded work."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import recordings
from test_diagnose import effect, synthetic

from swaywatch.cli import main
from swaywatch.diagnose import engine
from swaywatch.diagnose.evidence.baselines import LAWS, TRIED, path
from swaywatch.diagnose.evidence.search import Search
from swaywatch.diagnose.fit.budget import Budget
from swaywatch.diagnose.fit.data import Loaded, load
from swaywatch.diagnose.fit.fit import Fit, Fitter, Problem, slope
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect, Parameter
from swaywatch.errors import RecordingError


def _silent(stage: str, share: float) -> None:
    del stage, share


@pytest.fixture(scope="module")
def friction() -> Problem:
    """Two runs with friction at the ball."""
    found = effect("hitch_friction:hitch")
    rest = tuple(p.neutral for p in found.parameters[1:])
    return synthetic((ActiveEffect(found, (90.0, *rest)),), seed=3)


def test_a_budget_refuses_once_it_is_spent() -> None:
    budget = Budget(most_s=100.0)
    budget.spend(60.0)
    assert not budget.refuses("more")
    assert budget.refuses("again", 0.5)
    assert not budget.refuses("more")
    budget.spend(40.0)
    assert budget.refuses("more")
    assert budget.refuses("more")
    assert budget.untried == ["again", "more"]
    assert "not tried: again, more" in budget.sentences()[0]
    assert Budget().sentences() == []


def test_laws_do_not_spend_what_the_library_may() -> None:
    """They are tried in the middle of its search, which goes on afterwards."""
    budget = Budget(most_s=100.0)
    budget.spend(30.0)
    with budget.laws():
        budget.spend(50.0)
        assert not budget.refuses("more laws", 1.0, budget.by_laws_s)
        with budget.laws():  # tried by those that are tried
            budget.spend(55.0)
            assert budget.refuses("more laws", 1.0, budget.by_laws_s)
    assert (budget.by_laws_s, budget.by_library_s) == (105.0, 30.0)
    assert not budget.refuses("more effects", 0.8, budget.by_library_s)
    budget.spend(55.0)
    assert budget.refuses("more effects", 0.8, budget.by_library_s)
    assert budget.untried == ["more laws", "more effects"]


def test_a_step_is_refused_that_would_not_end_within_the_budget() -> None:
    """Windows beside a second vehicle took 3.9 million simulated seconds beyond the limit."""
    budget = Budget(most_s=100.0)
    assert not budget.refuses("windows")
    for cost in (30.0, 20.0):
        with budget.step("windows"):
            budget.spend(cost)
    assert not budget.refuses("windows")  # 50 spent, the longest took 30
    budget.spend(25.0)
    assert budget.refuses("windows")
    assert not budget.refuses("laws")
    assert "windows" in budget.sentences()[0]


def test_every_simulation_of_a_fit_counts(friction: Problem) -> None:
    problem = replace(friction, budget=Budget())
    fitter = Fitter(problem)
    fitter.run(fitter.start(), 1)
    length = sum(run.time.size for run in problem.runs) / 100.0
    assert problem.budget.spent_s >= length
    assert problem.budget.spent_s % (0.5 * length) == pytest.approx(0.0, abs=1e-6)


def test_without_budget_the_search_ends_with_what_it_has(friction: Problem) -> None:
    found = {}
    for most in (0.0, 1e9):
        problem = replace(friction, budget=Budget(most_s=most))
        search = Search(problem, [effect("hitch_friction:hitch")], _silent)
        found[most] = path(search, search.baseline(), _silent)
        assert problem.budget.untried == ([TRIED[0]] if most == 0.0 else [])
    assert found[0.0].best is found[0.0].base
    assert [t.effect.id for t in found[1e9].best.fit.terms] == ["hitch_friction"]


def test_derivatives_to_what_runs_away_are_none() -> None:
    base = np.array([1.0, 2.0])
    assert slope(np.array([1.5, 2.0]), base, 0.5).tolist() == [1.0, 0.0]
    for bad in (np.nan, np.inf, 1e200):
        assert slope(np.array([bad, 2.0]), base, 0.5).tolist() == [0.0, 0.0]


def _runs_away(beyond: float) -> Effect:
    """A channel that is infinite where the effect is larger than so much."""

    def observe(outputs: dict[str, Any], run: object, values: dict[str, float]) -> None:
        del run
        size = np.inf if values["size"] > beyond else values["size"]
        outputs["car_yaw_rate"] = outputs["car_yaw_rate"] + size

    return Effect(
        id="runs_away", component="car", kind="measurement", equation="", source="none",
        observe=observe,
        parameters=(Parameter("size", "rad/s", 0.0, -1.0, 1.0, (0.1,), 0.05),),
    )  # fmt: skip


@pytest.mark.parametrize("beyond", [0.005, -1.0])
def test_a_fit_that_runs_away_ends(friction: Problem, beyond: float) -> None:
    """Its derivative is infinite (0.005), or it is from the start (-1)."""
    fitter = Fitter(friction)
    start = fitter.start()
    term = ActiveEffect(_runs_away(beyond), (0.0,))
    fit = fitter.run(Fit((term,), start.nuisance, start.shift), 3)
    assert np.isfinite(fit.chi2) == (beyond > 0.0)
    assert len(fit.terms) == 1


def test_a_vehicle_that_runs_away_is_said(friction: Problem) -> None:
    class Away(Fitter):
        def run(self, start: Fit, *args: Any, **kwargs: Any) -> Fit:
            del args, kwargs
            return replace(start, chi2=np.inf)

    search = Search(friction, [], _silent)
    search.close, search.judge, search.releases = Away(friction), Away(friction), []
    with pytest.raises(RecordingError, match="diverges"):
        search.baseline()


def test_a_verdict_is_kept_where_a_part_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """And a diagnosis that may simulate no more names what it left out."""

    def no_budget(*args: Any, **kwargs: Any) -> Loaded:
        loaded = load(*args, **kwargs)
        assert loaded.problem is not None
        loaded.problem = replace(loaded.problem, budget=Budget(most_s=1.0))
        return loaded

    def fails(*args: object) -> str:
        raise ZeroDivisionError("no motion")

    for name in ("page", "stability"):
        monkeypatch.setattr(engine, name, fails)
    monkeypatch.setattr(engine, "load", no_budget)
    case = recordings("practice", "p03")
    runs = [str(run) for run in sorted(case.glob("run*"))]
    files = ["--vehicle", str(case / "vehicle.toml"), "--signals", str(case / "signals.toml")]
    assert main(["diagnose", *runs, *files, "--json", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr()
    result = engine.json.loads((tmp_path / "diagnosis.json").read_text())
    assert result["verdict"] == "unexplained"
    assert len(result["failed"]) == 2
    assert "the page failed (ZeroDivisionError: no motion)" in said.err
    (ended,) = [text for text in result["checks"] if "the search was ended" in text]
    assert TRIED[0] in ended
    assert LAWS in ended
    assert result["evidence"]["simulated_s"] > 1.0
