"""What goes with a motion in places of the road only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from test_discover import difference, plant, searched, silent

from swaywatch.discover import road
from swaywatch.discover.begin import law_in
from swaywatch.discover.effect import effect_of
from swaywatch.discover.excerpt import everything
from swaywatch.discover.find import Laws
from swaywatch.discover.grammar import of_bodies
from swaywatch.discover.law import Law, law_of
from swaywatch.discover.report import variables
from swaywatch.discover.sentences import energy, sentence, suggestion
from swaywatch.discover.way import course, driven, stretch
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.runs import Run
from swaywatch.plant.lanes import simulate

GAPS = Law("moment_trailer", "sideslip_trailer", power=2, response="periodic")
PHASES = (0.5, 2.0)


def _in_places(law: Law, gain: float, per_km: float, **values: float) -> ActiveEffect:
    runs = tuple(stretch(run) for run in searched(()).problem.runs)
    effect = effect_of(law, runs=runs)
    known = {p.name: p.starts[0] for p in effect.parameters} | values
    known |= {"gain": gain, "repetitions_per_km": per_km}
    known |= {f"phase_{i + 1}_rad": at for i, at in enumerate(PHASES)}
    return ActiveEffect(effect, tuple(known[p.name] for p in effect.parameters))


def _off(values: Mapping[str, float], per_km: float, runs: Sequence[Run]) -> float:
    """Largest error of the phase in the middle of a run, rad."""
    off = []
    for i, (run, at) in enumerate(zip(runs, PHASES, strict=True)):
        middle = 0.5 * float(driven(run)[-1]) / 1000.0
        turned = 2.0 * np.pi * (values["repetitions_per_km"] - per_km) * middle
        off.append(abs(np.angle(np.exp(1j * (values[f"phase_{i + 1}_rad"] - at + turned)))))
    return float(max(off))


def test_one_simulation_promises_a_law_in_places_of_the_road() -> None:
    """It is among those that are begun, with its repetitions and phases, at a small price."""
    for law, gain, per_km in (
        (GAPS, -4e4, 8.0),
        (Law("force_car", "sideslip_car", power=2, response="periodic"), -2e4, 14.0),
        (Law("moment_trailer", "yaw_rate_trailer", response="periodic"), -1e4, 8.0),
    ):
        close = searched((_in_places(law, gain, per_km),)).close
        spent = close.problem.budget.spent_s
        linear = everything(close).stricter().course(close.start())
        values = next(t for t in road.promising(linear) if law_in(t) == law).as_dict()
        assert values["gain"] == pytest.approx(gain, rel=0.35)
        assert values["repetitions_per_km"] == pytest.approx(per_km, rel=0.1)
        assert _off(values, per_km, close.problem.runs) < 0.7
        seconds = sum(run.time.size for run in close.problem.runs) / 100.0
        assert close.problem.budget.spent_s - spent < 3.0 * len(of_bodies()) * seconds


def test_wind_in_gaps_is_found_with_its_places() -> None:
    """Air on the trailer is in the library; that of a wind that houses keep off is not."""
    found = Laws([searched((_in_places(GAPS, -5e4, 8.0),))]).discover([], silent)
    assert found is not None
    assert found.law == GAPS
    values = found.term.as_dict()
    assert values["gain"] == pytest.approx(-5e4, rel=0.1)
    assert values["repetitions_per_km"] == pytest.approx(8.0, rel=0.03)


@pytest.mark.parametrize(
    ("place", "per_km"), [("axles", 9.0), ("slip_car_rear", 14.0), ("slip_trailer", 60.0)]
)
def test_grip_is_seen_in_what_the_slip_of_an_axle_changes(place: str, per_km: float) -> None:
    """Of one axle, or of all as each comes there, from three simulations of each run."""
    law = Law(place, place, response="periodic")
    close = searched((_in_places(law, 0.3, per_km),)).close
    linear = everything(close).stricter().course(close.start())
    spent = close.problem.budget.spent_s
    values = next(t for t in road.grips(linear) if law_in(t) == law).as_dict()
    assert values["gain"] == pytest.approx(0.3, rel=0.35)
    assert values["repetitions_per_km"] == pytest.approx(per_km, abs=0.5)
    assert _off(values, per_km, close.problem.runs) < 0.7
    seconds = sum(run.time.size for run in close.problem.runs) / 100.0
    assert close.problem.budget.spent_s - spent == pytest.approx(3.0 * seconds)


def test_what_acts_everywhere_promises_nothing_more_in_places() -> None:
    """Beside itself: the drop that counts is that over what acts all the time."""
    law = Law("moment_trailer", "yaw_rate_car")
    close = searched((ActiveEffect(effect_of(law), (-2000.0,)),)).close
    linear = everything(close).stricter().course(close.start())
    in_places = [t for t in road.promising(linear) if law_in(t).place == law.place]
    assert not [t for t in in_places if law_in(t).motion == law.motion]


def test_between_its_places_a_law_does_nothing() -> None:
    """Half of a full law in the mean, none of it in a run that is not known."""
    run = Run("r", np.arange(0.0, 12.0, 0.01), {}, {}, 15.0, speed=np.full(1200, 28.0))
    effect = effect_of(GAPS, runs=(stretch(run),))
    values = {"gain": -5e4, "repetitions_per_km": 0.2, "phase_1_rad": -0.5 * np.pi}
    still = plant()  # the first tenth of a turn of the road: next to nothing
    effect.act(still, run, values, ())
    assert difference(simulate(still)[:400], simulate(plant())[:400]) < 0.03
    whole, there = plant(), plant()
    effect_of(replace(GAPS, response="instant")).act(whole, run, {"gain": -5e4}, ())
    effect.act(there, run, values | {"phase_1_rad": 0.5 * np.pi}, ())
    assert difference(simulate(whole)[:400], simulate(there)[:400]) < 0.03
    assert difference(simulate(whole), simulate(plant())) > 0.1
    other = plant()
    effect.act(other, replace(run, name="another"), values, ())
    assert np.array_equal(simulate(other), simulate(plant()))
    share = course(
        run, {"repetitions_per_km": 50.0, "phase_1_rad": 0.0}, (stretch(run),), raised=True
    )
    assert (share.min(), share.max()) == pytest.approx((0.0, 1.0), abs=1e-3)


def test_other_courses_are_begun_as_large() -> None:
    """Stretches, pulses, and a force with a lever in the place of a moment."""
    close = searched(()).close
    runs = tuple(map(stretch, close.problem.runs))
    fit = replace(close.start(), terms=(_in_places(GAPS, -5e4, 8.0),))
    (half,) = road.halves(fit, runs)
    assert law_in(half.terms[-1]) == replace(GAPS, shape="positive side")
    assert half.terms[-1].as_dict() == fit.terms[-1].as_dict()
    (pulse,) = road.pulses(half, runs)
    assert pulse.terms[-1].as_dict()["above"] > 0.0
    assert road.pulses(fit, runs) == road.halves(half, runs) == road.of_air(fit, runs) == []
    ahead, behind = (each.terms[-1].as_dict() for each in road.ahead(fit, runs))
    assert ahead["gain"] * ahead["ahead_m"] == behind["gain"] * behind["ahead_m"] == -5e4
    assert law_of(law_in(road.ahead(fit, runs)[0].terms[-1]).spec).place == "at_trailer"


def test_words_of_what_acts_in_places() -> None:
    rows = {
        name: {"value": x, "low": 0.9 * x, "high": 1.1 * x}
        for name, x in _in_places(GAPS, -5e4, 8.0).as_dict().items()
    }
    words = sentence(GAPS, rows)
    assert "sideslip angle of the trailer" in words
    assert "coming and going" in words
    assert variables(GAPS) == ["sideslip angle of the trailer", "distance driven", "speed"]
    assert "every 125.0 m" in words
    short = replace(GAPS, shape="positive stop")
    assert "in places over 33 % of the way" in sentence(
        short, rows | {"above": {"value": 0.5, "low": 0.4, "high": 0.6}}
    )
    assert "wind" in suggestion(GAPS, -1.0)
    assert energy(GAPS, -1.0).startswith("can supply")
    assert "(1 + sin(" in effect_of(GAPS).equation
    assert "^2" in effect_of(GAPS).equation
