"""`stability` of diagnosis.json: each claimed term a cause, the errors those of the fit."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from test_diagnose import BODY_VALUES, effect

from swaywatch.diagnose.evidence.verdict import _Joint
from swaywatch.diagnose.fit.beliefs import beliefs_of
from swaywatch.diagnose.fit.fit import Fit, Problem
from swaywatch.diagnose.report.costs_page import costs_part
from swaywatch.diagnose.report.stability import OUTSIDE, SENSOR, _covariance, stability
from swaywatch.discover.effect import ALONG_THE_ROAD, effect_of
from swaywatch.discover.law import law_of
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.library.axle_load_harmonic import generator_effect
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import BODY
from swaywatch.report.shell import fill

BELIEFS = beliefs_of(BODY_VALUES, ["car_yaw_rate"])


def _problem() -> Problem:
    run = Run("run 1", np.arange(3) * 0.01, {}, {}, 15.0)
    run.speed = np.full(3, 30.0)
    return Problem((run,), BODY_VALUES, beliefs=BELIEFS)


def _found(terms: tuple[ActiveEffect, ...]) -> Fit:
    """A fit that knows all it moves to a tenth of its prior, effects to 2 %."""
    values = np.array([v for t in terms for v in t.values])
    count = len(BELIEFS)
    return Fit(
        terms, np.zeros((1, 5)), np.zeros(count), 1.0, 1, np.diag((0.02 * values + 1e-6) ** 2),
        0.01 * np.eye(count), cross=np.zeros((values.size, count)),
    )  # fmt: skip


def _law(spec: str, gain: float, **others: float) -> ActiveEffect:
    """A law with its gain; its other numbers as they are at first."""
    law = effect_of(law_of(spec))
    values = (others.get(p.name, p.starts[0]) for p in law.parameters[1:])
    return ActiveEffect(law, (gain, *values))


def test_every_term_is_a_cause_and_what_has_no_cost_says_why() -> None:
    windows = (1.0, 4.0, 700.0, 0.05, 6.0, 9.0, 700.0, 0.42)
    terms = (
        ActiveEffect(effect("tyre_relaxation:car_rear"), (0.5,)),
        ActiveEffect(generator_effect("car_rear"), windows, (0, 0)),
        ActiveEffect(effect("crosswind_gust:car"), (2.0, 3.0, 500.0), (0,)),
        ActiveEffect(effect("sensor_delay:car_yaw_rate"), (0.04,)),
        ActiveEffect(effect("parameter_error:car.steering_ratio"), (1.05,)),
    )
    block = stability(_problem(), _found(terms), 4.0)
    by_name = {cause["name"]: cause for cause in block["causes"]}
    assert {entry["name"]: entry["reason"] for entry in block["left_out"]} == {
        "crosswind_gust:car": OUTSIDE, "sensor_delay:car_yaw_rate": SENSOR,
    }  # fmt: skip
    assert set(by_name) == {
        "tyre_relaxation:car_rear", "axle_load_harmonic:car_rear",
        "parameter_error:car.steering_ratio",
    }  # fmt: skip
    assert by_name["parameter_error:car.steering_ratio"]["gives_back_km_h"][1]["value"] == 0.0
    assert by_name["tyre_relaxation:car_rear"]["gives_back_km_h"][1]["value"] > 3.0
    load = by_name["axle_load_harmonic:car_rear"]
    each = [w["gives_back_km_h"]["value"] for w in load["windows"]]
    assert max(each) - min(each) > 6.0  # two phases of one load
    assert [w["counts"] for w in load["windows"]] == [v == max(each) for v in each]
    page = fill("diagnose/report/costs_page.html", costs=costs_part({"stability": block}))
    assert "Effect on critical speed and damping</h2>" in page
    assert "(this one counts)" in page
    assert SENSOR in page


def test_what_comes_or_fades_over_a_way_costs_what_it_does_at_its_largest() -> None:
    at_once = _law("hitch/articulation/straight/0/instant", 4000.0)
    block = stability(_problem(), _found((at_once,)), 4.0)
    for response in ("growing", "fading"):
        term = _law(f"hitch/articulation/straight/0/{response}", 4000.0, over_m=60.0)
        other = stability(_problem(), _found((term,)), 4.0)
        assert other["diagnosed"]["v_crit_km_h"][0]["value"] == pytest.approx(
            block["diagnosed"]["v_crit_km_h"][0]["value"], abs=0.01
        )
    assert (
        block["diagnosed"]["v_crit_km_h"][0]["value"]
        > 1.02 * (block["calibrated"]["v_crit_km_h"][0]["value"])
    )


def test_what_comes_and_goes_along_the_road_has_no_cost_and_says_so() -> None:
    for spec in (
        "force_trailer/distance/straight/0/periodic",
        "slip_trailer/slip_trailer/straight/0/periodic",
    ):
        term = _law(spec, 0.2)
        block = stability(_problem(), _found((term,)), 4.0)
        assert block["causes"] == []
        assert [entry["reason"] for entry in block["left_out"]] == [ALONG_THE_ROAD]


def test_a_brake_that_binds_acts_from_outside() -> None:
    block = stability(
        _problem(), _found((_law("moment_trailer/distance/straight/0/growing", 900.0),)), 4.0
    )
    assert [entry["reason"] for entry in block["left_out"]] == [OUTSIDE]


def test_uncertainties_of_the_vehicle_are_those_of_the_fit_and_never_more_than_believed() -> None:
    problem = _problem()
    known = stability(problem, _found(()), 1.0)
    believed, calibrated = known["believed_v_crit_km_h"], known["calibrated"]["v_crit_km_h"][1]
    assert 0.15 < calibrated["standard_error"] / believed["standard_error"] < 0.4
    blind = replace(_found(()), shift_covariance=np.eye(len(BELIEFS)))  # an uninformative recording
    same = stability(problem, blind, 50.0)["calibrated"]["v_crit_km_h"][1]
    assert abs(same["standard_error"] / believed["standard_error"] - 1.0) < 0.05
    assert known["causes"] == []
    part = costs_part({"stability": known})
    assert part is not None
    assert "Critical speed of a swing of 4 deg/s" in part["summary"]


def test_a_value_said_as_an_effect_is_known_together_with_what_is_left_of_it() -> None:
    """A front axle softer than its tolerance: elastic steering and the tyre's own tolerance."""
    count = len(BELIEFS)
    front = next(
        k for k, b in enumerate(BELIEFS.items) if b.name == "car.front_cornering_stiffness"
    )
    known = np.diag(np.full(count, 0.1**2))
    shift = np.zeros(count)
    shift[front] = -3.0
    whole = Fit((), np.zeros((1, 5)), shift, 1.0, 1, shift_covariance=known)
    joint = _Joint(whole)
    stiffness = float(BODY_VALUES[BODY.index("car.front_cornering_stiffness")])
    factor = 1.0 - 3.0 * BELIEFS.items[front].tolerance
    slope = -BELIEFS.items[front].tolerance / (factor**2 * stiffness)
    joint.said_as_term(front, slope, 1.0)
    term = ActiveEffect(
        effect("steering_compliance:car_front"), ((1.0 / factor - 1.0) / stiffness,)
    )
    alone = joint.fit(replace(whole, terms=(term,), shift=np.zeros(count)), 1)
    assert abs(alone.covariance[0, 0] / (slope**2 * (1.0 + 0.1**2)) - 1.0) < 1e-9
    together, before = (
        stability(_problem(), fit, 1.0)[key]["v_crit_km_h"][1]
        for fit, key in ((alone, "diagnosed"), (whole, "calibrated"))
    )
    assert abs(together["value"] - before["value"]) < 0.05
    assert abs(together["standard_error"] / before["standard_error"] - 1.0) < 0.15


def test_rounding_where_much_is_known_makes_nothing_less_known_than_believed() -> None:
    """The page of an elastic drawbar had a critical speed of 140 (-10482 to 10761) km/h."""
    rng = np.random.default_rng(1)
    count = 12
    said = rng.normal(size=(6, count)) * 1e3  # six sums known exactly, the rest as believed
    known = np.linalg.inv(said.T @ said + np.eye(count))
    rounding = 1e-6 * rng.normal(size=(count, count))
    known *= 1.0 + 0.5 * (rounding + rounding.T)
    fit = Fit((), np.zeros((1, 5)), np.zeros(count), shift_covariance=known)
    problem = cast("Any", SimpleNamespace(beliefs=SimpleNamespace(weight=np.eye(count))))
    for fewer in (1.0, 30.0):
        assert np.all(np.diag(_covariance(problem, fit, fewer)) < 1.001)
