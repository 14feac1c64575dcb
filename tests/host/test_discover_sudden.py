"""What begins on the way, acts on one side of another motion, or moves in a coupling."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_discover import difference, plant, searched, silent

from swaywatch.discover.begin import in_form, initial, law_in
from swaywatch.discover.effect import effect_of, effect_of_form
from swaywatch.discover.excerpt import everything
from swaywatch.discover.find import Laws
from swaywatch.discover.grammar import IN_COUPLING, breaking, plainer, products, refined
from swaywatch.discover.law import Law, law_of
from swaywatch.discover.sentences import energy, sentence, suggestion
from swaywatch.discover.sudden import promising
from swaywatch.discover.trial import SWINGING, LawSearch
from swaywatch.discover.way import since, stretch
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import simulate

BROKEN = Law("slip_car_rear", "roll_car", response="sudden")
GREASE = Law(
    "hitch", "articulation_rate", "saturating", by="articulation", side="positive side"
)  # fmt: skip


def _rows(effect: Effect, values: tuple[float, ...]) -> dict[str, dict[str, float]]:
    named = zip((p.name for p in effect.parameters), values, strict=True)
    return {name: {"value": x, "low": 0.9 * x, "high": 1.1 * x} for name, x in named}


def _begun(law: Law, begins: tuple[float, ...], **values: float) -> ActiveEffect:
    runs = tuple(stretch(run) for run in searched(()).problem.runs)
    effect = effect_of(law, runs=runs)
    known = {p.name: p.starts[0] for p in effect.parameters} | values
    known |= {f"begins_{i + 1}_s": at for i, at in enumerate(begins)}
    return ActiveEffect(effect, tuple(known[p.name] for p in effect.parameters))


def test_what_breaks_is_found_with_its_moment_in_each_run() -> None:
    """Roll steer is in the library; that of an axle whose link breaks on the way is not."""
    found = Laws([searched((_begun(BROKEN, (6.0, 9.0), gain=0.3),))]).discover([], silent)
    assert found is not None
    assert found.law == BROKEN
    values = found.term.as_dict()
    assert values["gain"] == pytest.approx(0.3, rel=0.1)
    assert [values[f"begins_{i}_s"] for i in (1, 2)] == pytest.approx([6.0, 9.0], abs=0.3)
    words = sentence(found.law, _rows(found.term.effect, found.term.values))
    assert "s of run 1 on and from" in words
    assert suggestion(found.law, 0.3).startswith("what breaks")


def test_one_simulation_promises_a_law_from_any_moment_on() -> None:
    """Each law is among those that are begun, with moments that are near the right ones."""
    for law, gain in (
        (Law("moment_trailer", "distance", response="sudden"), 800.0),
        (Law("hitch", "articulation_rate", response="sudden"), 3000.0),
        (Law("slip_trailer", "articulation", response="sudden"), 0.1),
        (BROKEN, 0.2),
    ):
        close = searched((_begun(law, (5.0, 10.0), gain=gain),)).close
        spent = close.problem.budget.spent_s
        course = everything(close).stricter().course(close.start())
        best = next(term for term in promising(course) if law_in(term) == law)
        begins = [best.as_dict()[f"begins_{i}_s"] for i in (1, 2)]
        assert begins == pytest.approx([5.0, 10.0], abs=1.5)
        seconds = sum(run.time.size for run in close.problem.runs) / 100.0
        assert close.problem.budget.spent_s - spent < 3.0 * len(breaking()) * seconds


def test_nothing_promises_to_begin_where_it_acts_all_the_time() -> None:
    close = searched((ActiveEffect(effect_of(Law("slip_trailer", "articulation")), (0.1,)),)).close
    course = everything(close).stricter().course(close.start())
    same = [t for t in promising(course) if law_in(t).place == "slip_trailer"]
    assert not [t for t in same if law_in(t).motion == "articulation"]


def test_before_its_moment_a_law_does_nothing_and_in_another_run_it_acts() -> None:
    run = Run("r", np.arange(0.0, 12.0, 0.01), {}, {}, 15.0)
    law = Law("slip_trailer", "articulation", response="sudden")
    effect = effect_of(law, runs=(stretch(run),))
    slots, whole = plant(), plant()
    effect.act(slots, run, {"gain": 0.2, "begins_1_s": 6.0}, ())
    effect_of(replace(law, response="instant")).act(whole, run, {"gain": 0.2}, ())
    found, none = simulate(slots), simulate(plant())
    assert difference(found[:400], none[:400]) < 1e-6
    assert difference(found, none) > 0.03
    other = replace(run, name="another")
    assert np.all(since(other, {"begins_1_s": 6.0}, (stretch(run),)) == 1.0)
    assert np.all(since(run, {}, ()) == 1.0)
    slots = plant()
    effect_of_form(f"{law.spec}@2").act(slots, other, {"gain": 0.2}, ())
    assert np.array_equal(simulate(slots), simulate(whole))


def test_another_form_keeps_the_moments() -> None:
    term = _begun(Law("moment_car", "steer", response="sudden"), (3.0, 4.0), gain=100.0)
    others = refined(law_in(term))
    assert {law.response for law in others} == {"sudden"}
    assert "saturating" in {law.shape for law in others}
    for law in others:
        values = in_form(term, law).as_dict()
        assert (values["begins_1_s"], values["begins_2_s"]) == (3.0, 4.0)
    assert plainer(law_in(term)) == Law("moment_car", "steer")
    assert plainer(BROKEN) is None  # all the time it would be the library's


@pytest.mark.parametrize("side", ["positive side", "negative side"])
def test_a_law_acts_on_one_side_of_another_motion(side: str) -> None:
    """Both sides together are the law without."""
    run = Run("r", np.zeros(1), {}, {}, 15.0)
    law = replace(GREASE, side=side)
    assert law_of(law.spec) == law
    sign = 1.0 if side == "positive side" else -1.0
    slots = plant()
    effect_of(law).act(slots, run, {"gain": 20000.0, "bend": 0.02}, ())
    found, none = simulate(slots), simulate(plant())
    assert difference(found, none) > 0.03
    # a turn to the other side: nothing acts
    still = plant()
    still.steer = np.full(still.steer.size, -sign * 0.01)
    free, held = (simulate(replace(still)) for _ in range(2))
    effect_of(law).act(still, run, {"gain": 20000.0, "bend": 0.02}, ())
    held = simulate(still)
    turned = sign * free[200:, 2]
    acts = difference(free[200:], held[200:]) > 1e-4
    assert acts == bool(np.mean(turned) > 0.0)


def test_words_of_one_side() -> None:
    effect = effect_of(GREASE)
    rows = _rows(effect, (180000.0, 0.005)) | {"limit": {"value": 900.0, "low": 850, "high": 950}}
    words = sentence(GREASE, rows)
    assert "only while the articulation is positive" in words
    assert "friction" in suggestion(GREASE, 1.0)
    assert " where theta > 0" in effect.equation
    assert not effect.parameters[0].unit.endswith("per rad")
    assert effect.parameters[0].starts == effect_of(replace(GREASE, by="", side="")).parameters[
        0
    ].starts  # fmt: skip
    assert GREASE in products()
    assert initial(GREASE)


def test_a_ball_that_moves_in_its_coupling() -> None:
    """Free within its play; friction takes energy; no play is the elastic drawbar."""
    run = Run("r", np.zeros(1), {}, {}, 15.0)
    play, slips, cracked = IN_COUPLING
    held = plant(drawbar_compliance=2e-5)
    found = plant()
    effect_of(slips).act(found, run, {"compliance": 2e-5, "friction_n": 0.0}, ())
    assert np.array_equal(simulate(found), simulate(held))
    loose, tight = plant(), plant()
    effect_of(play).act(loose, run, {"play_m": 0.005, "compliance": 2.5e-6}, ())
    effect_of(play).act(tight, run, {"play_m": 0.0, "compliance": 2.5e-6}, ())
    assert difference(simulate(loose), simulate(tight)) > 0.01
    assert np.array_equal(simulate(tight), simulate(plant(drawbar_compliance=2.5e-6)))
    rubs = plant()
    effect_of(slips).act(rubs, run, {"compliance": 2e-5, "friction_n": 2000.0}, ())
    near, far = (difference(simulate(x), simulate(plant())) for x in (rubs, held))
    assert near < 0.7 * far  # held by its friction, which creeps
    alike, soft, stiff = plant(), plant(), plant()
    effect_of(cracked).act(alike, run, {"compliance": 2e-5, "other_side": 1.0}, ())
    assert np.array_equal(simulate(alike), simulate(held))
    effect_of(cracked).act(soft, run, {"compliance": 2e-5, "other_side": 8.0}, ())
    effect_of(cracked).act(stiff, run, {"compliance": 2.5e-6, "other_side": 0.125}, ())
    one, other, none = simulate(soft), simulate(stiff), simulate(plant())
    assert difference(one, none) < 0.8 * difference(simulate(held), none)
    # a slalom goes to both sides alike: mirrored it is the other side's
    mirrored = plant()
    mirrored.steer = -mirrored.steer
    effect_of(cracked).act(mirrored, run, {"compliance": 2.5e-6, "other_side": 0.125}, ())
    assert difference(simulate(mirrored), -one) < 1e-6
    assert difference(one, other) > 0.01


def test_words_of_a_ball() -> None:
    play, slips, cracked = IN_COUPLING
    words = sentence(play, _rows(effect_of(play), (0.004, 2.5e-6)))
    assert "freely across its coupling by 4.0" in words
    words = sentence(slips, _rows(effect_of(slips), (4e-5, 120.0)))
    assert "40.0 +- 4.0 mm per kN" in words
    assert "120 +- 12 N" in words
    words = sentence(cracked, _rows(effect_of(cracked), (6e-5, 20.0)))
    assert "to the left by 60.0 +- 6.0 mm per kN, and is 20.0 +- 2.0 times as stiff" in words
    assert "crack" in suggestion(cracked, 1.0)
    for law in IN_COUPLING:
        assert law_of(law.spec) == law
        assert "coupling" in suggestion(law, 1.0)
        assert "friction" in energy(law, 1.0)
        assert plainer(law) is None
        assert refined(law) == [other for other in IN_COUPLING if other != law]
        assert law not in SWINGING


def test_a_ball_with_play_is_found() -> None:
    play = IN_COUPLING[0]
    truth = ActiveEffect(effect_of(play), (0.004, 2.5e-6))
    found = Laws([searched((truth,))]).discover([], silent)
    assert found is not None
    assert found.law == play
    assert found.term.values[0] == pytest.approx(0.004, rel=0.1)
    assert SimpleNamespace(**found.term.as_dict()).compliance < 1e-5


def test_what_swings_is_tried_first_and_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """It leaves only noise of a misfit far above it: laws in other shapes would cost ten times."""

    def refused(*_: object) -> list[object]:
        raise AssertionError("not needed")

    monkeypatch.setattr(LawSearch, "_in_other_shapes", refused)
    truth = ActiveEffect(effect_of(Law("trailer", "swing"), 0.8), (120.0, 0.8, 0.05, 0.0))
    found = Laws([searched((truth,))]).discover([], silent)
    assert found is not None
    assert found.law == Law("trailer", "swing")
    assert found.term.values[:2] == pytest.approx((120.0, 0.8), rel=0.05)


def test_air_along_the_road_grows_with_the_square_of_the_speed() -> None:
    run = Run("r", np.arange(0.0, 12.0, 0.01), {}, {}, 15.0)
    run.speed = np.full(run.time.size, 50.0)
    law = Law("force_trailer", "distance", "positive side", response="periodic")
    values = {"gain": 100.0, "repetitions_per_km": 20.0, "phase_1_rad": 0.0}
    most = []
    for power in (0, 2):
        slots = plant()
        effect = effect_of(replace(law, power=power), runs=(stretch(run),))
        effect.act(slots, run, values, ())
        most.append(np.max(slots.series["force_trailer"]))
        words = sentence(replace(law, power=power), _rows(effect, (100.0, 20.0, 0.1)))
        assert ("square of the speed" in words) == (power == 2)
        assert ("water" in suggestion(replace(law, power=power), 100.0)) == (power == 2)
    assert most == pytest.approx([100.0, 400.0], rel=0.01)  # gains are stated at 25 m/s
