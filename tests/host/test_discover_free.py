"""Laws as free curves, where no form is theirs."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_discover import difference, plant, searched, seen_as_the_law_says, silent

from swaywatch.diagnose.evidence.baselines import noticeable
from swaywatch.diagnose.evidence.search import Linear
from swaywatch.diagnose.evidence.verdict import Verdict
from swaywatch.diagnose.fit.fit import Fit, Problem
from swaywatch.discover.begin import in_form, law_in
from swaywatch.discover.effect import effect_of
from swaywatch.discover.find import Laws
from swaywatch.discover.forms import curve, in_pieces
from swaywatch.discover.free import BEGUN_CURVES, free_curves
from swaywatch.discover.grammar import all_laws, curves, plainer, refined
from swaywatch.discover.law import CURVE, PIECES, Law, law_of
from swaywatch.discover.report import with_law
from swaywatch.discover.sentences import energy, sentence, suggestion
from swaywatch.effects.active import ActiveEffect
from swaywatch.plant.lanes import simulate

STEERED = Law("moment_car", "steer", CURVE)


def values_of(**pieces: float) -> dict[str, float]:
    """Numbers of a curve, of nothing where none is given."""
    return dict.fromkeys(PIECES, 0.0) | {"bend": 0.02} | pieces


def test_a_curve_is_what_its_pieces_say() -> None:
    """The same in the plant as a moment that is prescribed."""
    values = values_of(gain=4e4, of_size=2e4, right_1=-9e4, right_4=5e4, left_2=-7e4, left_5=3e4)
    pushed, law = plant(), plant()
    pushed.add_series("moment_car", in_pieces(pushed.steer, values))
    effect_of(STEERED).act(law, None, values, ())
    assert difference(simulate(pushed), simulate(law)) < 5e-3
    assert difference(simulate(plant()), simulate(law)) > 0.02


def test_forms_are_curves() -> None:
    z = np.linspace(-0.05, 0.05, 101)
    play = values_of(right_5=3.0, left_5=3.0)
    assert in_pieces(z, play) == pytest.approx(3.0 * curve("dead zone", z, 0.02))
    right = values_of(gain=1.5, of_size=1.5)
    assert in_pieces(z, right) == pytest.approx(3.0 * curve("positive side", z, 0.0))


@pytest.mark.parametrize(
    ("pieces", "shape", "gain", "bend"),
    [
        ({"gain": 5.0}, "straight", 5.0, None),
        ({"right_3": 5.0, "left_3": 5.0}, "dead zone", 5.0, 0.012),
        ({"of_size": 5.0, "gain": 5.0}, "positive side", 10.0, None),
        ({"gain": 5.0, "right_1": -5.0, "left_1": -5.0}, "saturating", 6.0, 0.004),
    ],
)
def test_a_form_begins_as_the_curve_that_it_takes_the_place_of(
    pieces: dict[str, float], shape: str, gain: float, bend: float | None
) -> None:
    effect = effect_of(STEERED)
    scale = effect.parameters[0].starts[0]
    values = values_of(**{name: scale * value for name, value in pieces.items()})
    term = ActiveEffect(effect, tuple(values[p.name] for p in effect.parameters))
    found = in_form(term, Law("moment_car", "steer", shape)).as_dict()
    assert found["gain"] == pytest.approx(gain * scale, rel=0.25)
    if bend is not None:
        assert found["bend"] == pytest.approx(bend, rel=0.1)


@pytest.mark.parametrize(("shape", "wide"), [("stepped", 0.01), ("notched", 0.0025)])
def test_what_comes_again_and_again_begins_as_wide_as_the_curve_says(
    shape: str, wide: float
) -> None:
    effect = effect_of(STEERED)
    knots = 0.02 * np.arange(-5, 6) / 5.0
    slopes = np.diff(3e4 * curve(shape, knots, wide)) / np.diff(knots)
    left, right = slopes[4::-1], slopes[5:]
    values = values_of(gain=0.5 * (right[0] + left[0]), of_size=0.5 * (right[0] - left[0]))
    values |= {f"right_{n}": float(right[n] - right[n - 1]) for n in range(1, 5)}
    values |= {f"left_{n}": float(left[n] - left[n - 1]) for n in range(1, 5)}
    term = ActiveEffect(effect, tuple(values[p.name] for p in effect.parameters))
    found = in_form(term, Law("moment_car", "steer", shape)).as_dict()
    assert found["bend"] == pytest.approx(wide, rel=0.15)
    assert found["gain"] == pytest.approx(3e4, rel=0.4)


@pytest.mark.parametrize(("shape", "number"), [("stepped", 20.0), ("notched", 21.0)])
def test_steps_and_notches(shape: str, number: float) -> None:
    """The same in the plant as a moment that is prescribed."""
    z = np.array([-0.016, -0.004, 0.004, 0.016, 0.026])
    steps = {"stepped": [-0.02, 0.0, 0.0, 0.02, 0.03], "notched": 0.01 * np.sin(z / 0.01)}[shape]
    assert curve(shape, z, 0.01) == pytest.approx(steps, abs=2e-3)
    pushed = plant()
    pushed.add_series("moment_car", 5e4 * curve(shape, pushed.steer, 0.005))
    law = plant(
        law_gain=5e4, law_of_steer=1.0, law_to_moment_car=1.0, law_shape=number, law_bend=0.005
    )  # fmt: skip
    assert difference(simulate(pushed), simulate(law)) < 5e-3
    assert difference(simulate(plant()), simulate(law)) > 0.02


def test_steps_and_notches_in_words() -> None:
    values = {"gain": 2e5, "bend": 0.00142, "limit": 284.0}
    rows = {k: {"value": v, "low": 0.99 * v, "high": 1.01 * v} for k, v in values.items()}
    notched = Law("hitch", "articulation", "notched")
    assert sentence(notched, rows).endswith(
        "up to 284.0 +- 2.8 Nm to and fro, again every 0.00892 rad, independent of speed"
    )
    assert energy(notched, 2e5).endswith("passive")
    assert suggestion(notched, 2e5) == "something that snaps from notch to notch"
    stepped = Law("slip_car_rear", "yaw_rate_car", "stepped", response="lagged")
    words = sentence(stepped, rows | {"lag_s": {"value": 0.05}})
    assert ", in steps of 0.00142 rad/s, independent of speed, 50 ms lag" in words
    assert suggestion(stepped, 0.1) == "an actuator that moves in steps"


def test_curves_are_looked_for_by_themselves() -> None:
    """Any form is one, so they stand beside no other form of a law."""
    assert not any(law.shape == CURVE for law in all_laws())
    assert not any(law.shape == CURVE for law in refined(Law("hitch", "articulation")))
    assert Law("hitch", "articulation", CURVE) in curves()
    for shape in ("stepped", "notched"):  # only a curve says how wide they are
        other = Law("hitch", "articulation", shape)
        assert other not in all_laws()
        assert other in refined(Law("hitch", "articulation", CURVE))
        assert other not in refined(Law("hitch", "articulation"))
    late = Law("slip_car_rear", "yaw_rate_car", CURVE, response="lagged")
    assert plainer(late) == Law("slip_car_rear", "yaw_rate_car", CURVE)
    assert law_of(late.spec) == late


def test_a_curve_in_words() -> None:
    rows = {name: {"value": value} for name, value in values_of(gain=6e4, right_1=-6e4).items()}
    words = sentence(Law("hitch", "articulation", CURVE), rows)
    assert "a curve of the articulation: -1.2 at -0.02, -0.96 at -0.016" in words
    assert "0.24 at 0.004, 0.24 at 0.008" in words
    assert "(kNm at theta in rad), independent of speed" in words
    assert suggestion(Law("hitch", "articulation", CURVE), 1.0) == ""
    braked = Law("moment_car", "yaw_rate_car", CURVE)
    assert energy(braked, -1.0).startswith("can supply")
    assert energy(Law("hitch", "articulation", CURVE), 1.0).startswith("stores")


def notched() -> ActiveEffect:
    """A ring at the ball that is worn in notches: it pulls there, and back a degree later."""
    effect = effect_of(Law("hitch", "articulation", CURVE))
    values = values_of(
        gain=4e4, bend=0.025, right_1=-4e4, right_2=-4e4, right_3=4e4,
        left_1=-4e4, left_2=-4e4, left_3=4e4,
    )  # fmt: skip
    return ActiveEffect(effect, tuple(values[p.name] for p in effect.parameters))


def test_what_has_no_form_is_among_the_curves_that_are_begun() -> None:
    """From the vehicle of the file and from the calibrated one."""
    close = searched((notched(),)).close
    for near in (close.start(), close.run(close.start(), 6)):
        begun = [law_in(term) for term in free_curves(Linear(close, near))]
        assert len(set(begun)) == len(begun) == BEGUN_CURVES
        assert Law("hitch", "articulation", CURVE) in begun


@pytest.mark.long
def test_what_has_no_form_is_found_as_a_curve() -> None:
    truth = notched()
    found = Laws([searched((truth,))]).discover([], silent)
    assert found is not None
    assert found.law == Law("hitch", "articulation", CURVE)
    seen_as_the_law_says(found)
    z = np.linspace(-0.015, 0.015, 61)
    said, true = in_pieces(z, found.term.as_dict()), in_pieces(z, truth.as_dict())
    assert np.sqrt(np.mean((said - true) ** 2)) < 0.1 * np.sqrt(np.mean(true**2))


def test_a_law_stands_before_the_library_that_was_not_claimed() -> None:
    """Windows that followed the misfit are not claimed; in the ranking the law is ahead of them."""
    vehicle = Fit((), np.zeros((1, 5)), np.zeros(1), chi2=5000.0, count=1000)
    law = replace(vehicle, terms=(notched(),), chi2=1000.0)
    verdict = Verdict(
        "unexplained", vehicle, vehicle, Problem.__new__(Problem),
        candidates=[("tyres that change", 900.0), ("calibrated vehicle", 0.0)],
    )  # fmt: skip
    search = SimpleNamespace(problem=verdict.problem, noise=1.0)
    said = with_law(verdict, SimpleNamespace(fit=law, base=vehicle, search=search, evidence=80.0))
    assert (said.word, said.evidence) == ("missing_physics", 980.0)
    assert [name for name, _ in said.candidates][1:] == ["tyres that change", "calibrated vehicle"]


@pytest.mark.parametrize(
    "law", [Law("slip_car_rear", "steer_rate"), Law("hitch", "lateral_acceleration_trailer")]
)
def test_what_is_as_quick_as_may_be_can_be_claimed(law: Law) -> None:
    """Its lag is at a bound then, which says nothing against it."""
    effect = effect_of(law)
    lag = effect.parameters[-1]
    assert lag.name == "lag_s"
    assert noticeable(ActiveEffect(effect, (effect.parameters[0].starts[0], lag.low)))


def test_a_rate_of_steering_is_what_has_changed_within_its_lag() -> None:
    quick, slow, shifted = plant(), plant(), plant()
    law = effect_of(Law("slip_car_front", "steer_rate", "dead zone"))
    for steered, lag in ((quick, 0.02), (slow, 0.1)):
        law.act(steered, None, {"gain": 0.05, "bend": 0.01, "lag_s": lag}, ())
    rate = np.gradient(shifted.steer, 0.01)
    shifted.steer = shifted.steer + 0.05 * curve("dead zone", rate, 0.01)
    assert difference(simulate(shifted), simulate(quick)) < 0.03
    assert difference(simulate(quick), simulate(slow)) > 0.03
