"""Laws in words."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from swaywatch.diagnose.evidence.baselines import noticeable
from swaywatch.discover.effect import effect_of
from swaywatch.discover.grammar import grammar, plainer
from swaywatch.discover.known import KNOWN
from swaywatch.discover.law import Law, law_of
from swaywatch.discover.sentences import energy, sentence, suggestion
from swaywatch.discover.way import course, stretch
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.runs import Run
from swaywatch.errors import SwaywatchError


def test_every_law_has_a_word_and_its_word_is_read_back() -> None:
    for one in grammar():
        law = one.extra["law"]
        assert isinstance(law, Law)
        assert law_of(str(one.extra["form"])) == law
        rows = {p.name: {"value": 1.0, "low": 0.9, "high": 1.1} for p in one.parameters}
        assert sentence(law, rows)
        assert energy(law, 1.0)
    for place, motion in KNOWN:
        assert law_of(Law(place, motion).spec)
    for wrong in (
        "hitch",
        "hitch/articulation/round/0/instant",
        "nose/articulation/straight/0/instant",
    ):
        with pytest.raises(SwaywatchError, match="no"):
            law_of(wrong)


def test_words() -> None:
    spring = Law("hitch", "articulation")
    row = {"gain": {"value": 3100.0, "low": 2900.0, "high": 3300.0}}
    assert "3.10 +- 0.20 kNm per rad of the articulation" in sentence(spring, row)
    assert "spring" in suggestion(spring, 3100.0)
    scrub = Law("moment_trailer", "yaw_rate_trailer", "saturating")
    limit = {"value": 188.0, "low": 184.0, "high": 192.0}
    row = {"gain": row["gain"], "bend": {"value": 0.005}, "limit": limit}
    assert "saturating at 188.0 +- 4.0 Nm" in sentence(scrub, row)
    wind = Law("force_trailer", "heading")
    assert "kN per rad of the heading of the trailer" in sentence(wind, row)
    assert "wind" in suggestion(wind, 9000.0)
    assert "stores" in energy(spring, 3100.0)
    assert "dissipates" in energy(Law("moment_trailer", "yaw_rate_trailer"), -500.0)
    assert "dissipates" in energy(Law("at_trailer", "sideslip_there", "saturating"), -2e4)
    assert "can supply" in energy(Law("moment_trailer", "yaw_rate_trailer"), 500.0)
    assert "stop" in suggestion(replace(spring, shape="dead zone"), 3100.0)
    damper = Law("hitch", "articulation_rate", "negative side")
    assert "only while that is negative" in sentence(damper, {"gain": row["gain"]})
    assert "one way only" in suggestion(damper, 3100.0)
    assert "chain" in suggestion(replace(spring, shape="positive side"), 3100.0)
    rubs = replace(spring, shape="rubbing")
    assert "eyes are worn" in suggestion(
        replace(spring, shape="dead zone", response="transient"), 3100.0
    )
    fades = Law("hitch", "articulation_rate", "saturating", response="fading")
    assert effect_of(fades).equation.endswith("/ (1 + angle worked / over)")
    assert "against its rate" in sentence(rubs, {"gain": row["gain"]})
    assert "worn coupling" in suggestion(rubs, 3100.0)
    assert "dissipates" in energy(rubs, 3100.0)
    assert "supplies" in energy(rubs, -3100.0)
    liquid = Law("trailer", "swing", "odd square")
    rows = {p.name: {"value": 2.0, "low": 1.9, "high": 2.1} for p in effect_of(liquid).parameters}
    assert "2 1/m times the square of its rate" in sentence(liquid, rows)
    assert "liquid" in suggestion(liquid, 2.0)


def test_pulses_along_the_road() -> None:
    """As high as they are said to be, over the share of the way that is said, one way only."""
    law = Law("axles", "distance", "positive stop", response="periodic")
    run = Run("r", np.arange(0.0, 40.0, 0.01), {}, {}, 15.0)
    run.speed = np.full(run.time.size, 25.0)
    effect = effect_of(law, runs=(stretch(run),))
    names = [p.name for p in effect.parameters]
    assert names == ["gain", "above", "repetitions_per_km", "phase_1_rad"]
    values = dict(zip(names, (0.002, 0.8, 20.0, 0.4), strict=True))
    found = course(run, values, (stretch(run),), half=True)
    assert np.max(found) == pytest.approx(1.0, abs=1e-3)
    assert np.min(found) == 0.0
    share = math.acos(0.8) / math.pi
    assert np.mean(found > 0.0) == pytest.approx(share, rel=0.02)
    rows = {name: {"value": v, "low": 0.9 * v, "high": 1.1 * v} for name, v in values.items()}
    words = sentence(law, rows)
    assert "in pulses over 20 % of the way" in words
    assert "every 50.0 m" in words
    assert "- above, 0)" in effect.equation
    assert plainer(law) == replace(law, shape="positive side")


def test_grip_that_is_lost_in_places() -> None:
    """Rough stretches on which an axle hops: it holds less there, and never more."""
    law = Law("slip_car_rear", "slip_car_rear", "positive side", response="periodic")
    effect = effect_of(law, runs=("r",))
    assert effect.parameters[0].low < 0.0
    assert effect_of(replace(law, shape="straight"), runs=("r",)).parameters[0].low == 0.0
    assert effect.equation.startswith("angle = gain x alpha_r x max(sin(")
    values = {"gain": -0.33, "repetitions_per_km": 10.9, "phase_1_rad": 0.1}
    rows = {name: {"value": v, "low": v - 0.01, "high": v + 0.01} for name, v in values.items()}
    words = sentence(law, rows)
    assert "changes in places by -33.0 +- 1.0 %" in words
    assert "one way only" in words


def test_words_of_a_stack() -> None:
    law = Law("trailer", "swing", "rubbing")
    values = {
        "mass_kg": 400.0, "frequency_hz": 0.86, "damping_ratio": 0.05, "position_m": 0.1,
        "slips_m": 0.034, "rubbing_share": 0.6,
    }  # fmt: skip
    rows = {name: {"value": v, "low": 0.9 * v, "high": 1.1 * v} for name, v in values.items()}
    assert "60 % of what holds it is friction that slips after 34 mm" in sentence(law, rows)
    assert "stack" in suggestion(law, 400.0)


def test_words_of_a_box_in_a_net() -> None:
    law = Law("trailer", "swing", "lost motion")
    values = {
        "mass_kg": 400.0, "frequency_hz": 1.4, "damping_ratio": 0.0, "position_m": 0.1,
        "gap_m": 0.046, "friction_m_s2": 0.5,
    }  # fmt: skip
    rows = {name: {"value": v, "low": 0.9 * v, "high": 1.1 * v} for name, v in values.items()}
    words = sentence(law, rows)
    assert "sliding on the floor (friction 0.500 +- 0.050 m/s2) within 46 mm either way" in words
    assert "net" in suggestion(law, 400.0)


def test_words_of_a_product() -> None:
    law = Law("hitch", "articulation_rate", "saturating", by="hitch_force")
    sizes = {"gain": 65.0, "bend": 0.006, "limit": 0.39}
    rows = {name: {"value": v, "low": 0.9 * v, "high": 1.1 * v} for name, v in sizes.items()}
    found = sentence(law, rows)
    assert "articulation rate and per N of the size of the side force of the trailer" in found
    assert "saturating at 0.390 +- 0.039 Nm per N" in found
    assert "coupling without grease" in suggestion(law, 65.0)


def test_words_of_a_product_that_levels_off_or_begins_late() -> None:
    sizes = {"gain": 65.0, "bend": 0.006, "limit": 0.39, "by_bend": 0.01}
    rows = {name: {"value": v, "low": 0.9 * v, "high": 1.1 * v} for name, v in sizes.items()}
    law = Law("hitch", "articulation_rate", "saturating", by="articulation", side="levels off")
    found = sentence(law, rows)
    assert "where the articulation is large: half of it at 0.01 rad" in found
    assert "saturating at 0.390 +- 0.039 Nm" in found
    assert "dry friction" in suggestion(law, 65.0)
    assert "theta^2 / (theta^2 + by_bend^2)" in effect_of(law).equation
    late = replace(law, side="beyond")
    assert "per rad of the size of the articulation beyond 0.01 rad" in sentence(late, rows)
    assert "max(|theta| - by_bend, 0)" in effect_of(late).equation
    assert effect_of(late).parameters[0].unit.endswith("per rad")


def test_words_of_what_rises_as_steeply_as_a_fit_allows() -> None:
    """Its size is known, and how steeply it gets there is not: no number says so."""
    law = Law("hitch", "articulation_rate", "saturating", by="roll_trailer")
    steepest = effect_of(law).parameters[0].high
    sizes = {"gain": steepest, "bend": 0.006, "limit": 0.006 * steepest}
    rows = {name: {"value": v, "low": 0.9 * v, "high": 1.1 * v} for name, v in sizes.items()}
    found = sentence(law, rows)
    assert "per rad of the size of the roll of the trailer, with the sign of" in found
    assert "all of it from 0.012 rad/s on" in found
    assert "saturating" not in found
    assert "jams on its ball" in suggestion(law, steepest)
    assert "dry friction" in suggestion(replace(law, by=""), steepest)
    rows["gain"]["value"] = 0.5 * steepest
    assert "saturating at" in sentence(law, rows)
    term = ActiveEffect(
        effect_of(law), (steepest, 0.006, 13.0, 0.1)[: len(effect_of(law).parameters)]
    )
    assert noticeable(term)
    assert not noticeable(replace(term, effect=effect_of(replace(law, shape="straight"))))


def test_friction_that_falls_is_said_in_newton_metres() -> None:
    law = Law("hitch", "articulation_rate", "falling")
    values = effect_of(law).report({"gain": 17000.0, "bend": 0.04})
    assert values["limit"] == pytest.approx(680.0)
    rows = {name: {"value": x, "low": 0.9 * x, "high": 1.1 * x} for name, x in values.items()}
    said = sentence(law, rows)
    assert "0.680 +- 0.068 kNm where that is small, half of it at 0.04 rad/s" in said
    assert suggestion(law, 17000.0) == "dry friction that falls as it slides faster"
