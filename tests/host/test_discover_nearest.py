"""What is said of laws that come near where none is claimed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from swaywatch.diagnose.fit.fit import Fit
from swaywatch.diagnose.report.labels import what_is_left
from swaywatch.discover.begin import initial
from swaywatch.discover.law import Law
from swaywatch.discover.nearest import instead, nearest
from swaywatch.effects.active import ActiveEffect

COUNT = 1000
NOTHING = Fit((), np.zeros((1, 5)), np.zeros(0), 100.0 * COUNT, COUNT)
SPRING = Law("hitch", "articulation")
ROLLS = Law("slip_car_front", "lateral_acceleration_car", "positive side")


def with_law(law: Law, left: float, *more: ActiveEffect) -> Fit:
    return replace(NOTHING, terms=(*more, initial(law)[0]), chi2=left * COUNT)


def test_the_nearest_law_says_where_to_look_first() -> None:
    (only,) = nearest([with_law(SPRING, 40.0), with_law(ROLLS, 2.7)], NOTHING)
    assert (only["place"], only["depends_on"]) == ("slip_car_front", "lateral_acceleration_car")
    assert only["reduced_chi_square"] == pytest.approx(2.7)
    text = what_is_left(only)
    assert "steering angle of the front axle" in text
    assert "lateral acceleration of the car" in text
    assert "2.7 times the noise, 100 times without it" in text
    assert text.endswith("Look there first")


def test_a_law_that_leaves_less_than_the_noise_is_named_too() -> None:
    (only,) = nearest([with_law(SPRING, 0.9), with_law(ROLLS, 2.7)], NOTHING)
    assert only["spec"] == SPRING.spec
    assert "not clearly likelier than the findings" in only["reason"]
    assert "at most" not in only["reason"]


def test_laws_as_near_are_named_too_each_place_and_variable_once() -> None:
    bent = replace(SPRING, shape="saturating")
    found = nearest(
        [with_law(SPRING, 3.0), with_law(bent, 2.0), with_law(ROLLS, 2.4), with_law(ROLLS, 9.0)],
        NOTHING,
    )
    assert [row["spec"] for row in found] == [bent.spec, ROLLS.spec]
    assert found[1]["reason"].startswith("nearly as near: ")


@pytest.mark.parametrize("left", [60.0, float("inf")])
def test_a_law_that_explains_little_is_no_hint(left: float) -> None:
    assert nearest([with_law(SPRING, left)], NOTHING) == []
    assert nearest([], NOTHING) == []


def test_what_a_law_stands_beside_is_said() -> None:
    beside = initial(Law("tyres", "side_force"))[0]
    (found,) = nearest(
        [with_law(SPRING, 2.0, replace(beside, effect=replace(beside.effect, id="x")))], NOTHING
    )
    assert found["beside"] == [f"x:{beside.effect.component}"]


@pytest.mark.parametrize(
    ("findings", "they_leave", "law_leaves", "said"),
    [(2, 1.1, 1.15, True), (1, 1.1, 1.0, False), (3, 1.0, 1.15, False), (3, 1.4, 1.35, False)],
)
def test_one_law_that_does_what_several_findings_do_is_said_beside_them(
    findings: int, they_leave: float, law_leaves: float, said: bool
) -> None:
    term = initial(Law("tyres", "side_force"))[0]
    found = replace(NOTHING, terms=(term,) * findings, chi2=they_leave * COUNT)
    beside = with_law(SPRING, 0.9, term)  # not alone
    text = instead([with_law(ROLLS, law_leaves), beside], found)
    assert bool(text) == said
    if said:
        assert "instead of the 2 findings" in text[0]
        assert "steering angle of the front axle" in text[0]
        assert "1.15 times the noise, they leave 1.10" in text[0]
    assert instead([], found) == []
