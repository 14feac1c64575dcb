"""Axle loads of the vehicle's file, which masses and lengths have to agree with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from test_diagnose import synthetic

from swaywatch.diagnose.engine import _take_mass_or_loads
from swaywatch.diagnose.fit.beliefs import Beliefs, beliefs_of, moved
from swaywatch.diagnose.fit.data import Loaded, body_of
from swaywatch.diagnose.fit.load_balance import TOLERANCE, static_loads, weighed
from swaywatch.effects.effect import library
from swaywatch.plant.lanes import BODY, GRAVITY
from swaywatch.vehicle import Vehicle
from swaywatch.vehicle_file import load_vehicle


@pytest.fixture(scope="module")
def known() -> Vehicle:
    """Car with a tandem trailer whose loads balance."""
    vehicle = load_vehicle(DATA / "road" / "r22" / "vehicle.toml")
    front, rear, trailer = static_loads(body_of(vehicle))
    return with_loads(vehicle, front, rear, trailer)


def with_loads(vehicle: Vehicle, front: float, rear: float, trailer: float) -> Vehicle:
    """The vehicle with other axle loads, N."""
    car = replace(vehicle.car, front_axle_load=front, rear_axle_load=rear)
    share = 0.5 if vehicle.trailer.front_axle_to_cog is not None else 0.0
    towed = replace(
        vehicle.trailer,
        front_axle_load=share * trailer if share else None,
        rear_axle_load=(1.0 - share) * trailer,
    )
    return replace(vehicle, car=car, trailer=towed)


def of(vehicle: Vehicle) -> tuple[np.ndarray, Beliefs, tuple[str, ...]]:
    """Constants, beliefs and what is wrong."""
    body = body_of(vehicle)
    found = weighed(beliefs_of(body, ["car_yaw_rate"]), body, vehicle)
    return body, found.beliefs, found.wrong


def most_probable(beliefs: object) -> dict[str, float]:
    """Values of the file that the loads alone make most probable, in tolerances."""
    z = np.linalg.solve(beliefs.weight, beliefs.roots.T @ beliefs.target)
    return {b.name: float(x) for b, x in zip(beliefs.items, z, strict=True) if b.scaled}


def test_loads_carry_the_whole_weight_and_no_moment(known: Vehicle) -> None:
    body = dict(zip(BODY, body_of(known), strict=True))
    front, rear, trailer = static_loads(body_of(known))
    assert front + rear + trailer == pytest.approx(
        GRAVITY * (body["car.mass"] + body["trailer.mass"])
    )
    # about the front axle: rear axle, car, ball
    hitch = GRAVITY * body["trailer.mass"] - trailer
    lf, lr, lh = (
        body[f"car.{k}"] for k in ("front_axle_to_cog", "rear_axle_to_cog", "hitch_to_cog")
    )
    assert rear * (lf + lr) == pytest.approx(GRAVITY * body["car.mass"] * lf + hitch * (lf + lh))


def test_a_file_that_balances_is_left_as_it_is_and_known_better(known: Vehicle) -> None:
    body, beliefs, wrong = of(known)
    assert not wrong
    assert all(abs(z) < 1e-6 for z in most_probable(beliefs).values())
    spread = np.sqrt(np.diag(np.linalg.inv(beliefs.weight)))
    at = beliefs.at
    assert spread[at["vehicle", "trailer.mass"]] < 0.75
    assert spread[at["vehicle", "car.mass"]] < 0.75
    assert spread[at["vehicle", "trailer.yaw_inertia"]] == pytest.approx(1.0)
    del body


def test_scales_correct_a_mass_that_is_off(known: Vehicle) -> None:
    """The trailer's mass 2 % too low in the file, its axles weighed as they are."""
    truth = static_loads(body_of(known))
    trailer = replace(known.trailer, mass=known.trailer.mass * 0.98)
    _, beliefs, wrong = of(with_loads(replace(known, trailer=trailer), *truth))
    assert not wrong
    found = most_probable(beliefs)
    assert found["trailer.mass"] * 0.015 == pytest.approx(0.02, abs=0.008)
    assert abs(found["car.mass"]) < 0.3


def test_loads_of_another_vehicle_are_left_out_with_a_word(known: Vehicle) -> None:
    front, rear, trailer = static_loads(body_of(known))
    _, beliefs, wrong = of(with_loads(known, front, 1.22 * rear, trailer))
    assert beliefs.weighings == ()
    assert len(wrong) == 1
    assert "car.rear_axle_load is" in wrong[0]
    assert f"{1.22 * rear:.0f} N" in wrong[0]
    assert f"{rear:.0f} N" in wrong[0]


@pytest.mark.parametrize("factor", [0.7, 1.25])
def test_loads_that_another_mass_fits_say_which(known: Vehicle, factor: float) -> None:
    """The mass of an empty trailer beside the axle loads of a laden one."""
    truth = static_loads(body_of(known))
    trailer = replace(known.trailer, mass=known.trailer.mass / factor)
    body = body_of(replace(known, trailer=trailer))
    mistaken = with_loads(replace(known, trailer=trailer), *truth)
    found = weighed(beliefs_of(body, ["car_yaw_rate"]), body, mistaken)
    assert found.beliefs.weighings == ()
    assert found.otherwise is not None
    beliefs, sentence = found.otherwise
    mass = 1.0 + 0.015 * most_probable(beliefs)["trailer.mass"]
    assert mass == pytest.approx(factor, rel=0.01)
    assert f"trailer.mass = {known.trailer.mass:.0f} kg" in sentence


def test_no_mass_makes_one_wrong_load_fit(known: Vehicle) -> None:
    front, rear, trailer = static_loads(body_of(known))
    body, wrong = body_of(known), with_loads(known, front, 1.22 * rear, trailer)
    found = weighed(beliefs_of(body, ["car_yaw_rate"]), body, wrong)
    assert found.otherwise is None


@pytest.mark.parametrize("mass_is_wrong", [True, False])
def test_the_recording_says_whether_mass_or_loads_are_wrong(
    known: Vehicle, mass_is_wrong: bool
) -> None:
    """With the hitch force the mass shows: beside it loads of 0.8 times the right ones."""
    problem = synthetic((), 3)
    front, rear, trailer = static_loads(problem.body)
    body = problem.body.copy()
    if mass_is_wrong:
        body[BODY.index("trailer.mass")] /= 0.8
    else:
        lighter = body.copy()
        moved(lighter, "trailer.mass", -0.2)
        front, rear, trailer = static_loads(lighter)
    stated = with_loads(known, front, rear, trailer)
    believed = beliefs_of(body, problem.channels(problem.runs[0]))
    loads = weighed(believed, body, stated)
    assert loads.otherwise is not None
    loaded = Loaded(replace(problem, body=body, beliefs=loads.beliefs), stated, weighed=loads)
    loaded.checks = list(loads.wrong)
    _take_mass_or_loads(loaded, library())
    assert loaded.problem is not None
    assert bool(loaded.problem.beliefs.weighings) == mass_is_wrong
    assert ("trailer.mass =" in loaded.checks[0]) == mass_is_wrong


def test_a_file_without_loads_says_nothing(known: Vehicle) -> None:
    car = replace(known.car, front_axle_load=None, rear_axle_load=None)
    towed = replace(known.trailer, front_axle_load=None, rear_axle_load=None)
    _, beliefs, wrong = of(Vehicle(car, towed))
    assert not wrong
    assert beliefs.weighings == ()
    assert beliefs.target == pytest.approx(0.0)


def test_the_pull_is_the_slope_of_the_misfit(known: Vehicle) -> None:
    truth = static_loads(body_of(known))
    trailer = replace(known.trailer, mass=known.trailer.mass * 0.98)
    body, beliefs, _ = of(with_loads(replace(known, trailer=trailer), *truth))
    rng = np.random.default_rng(3)
    z = rng.normal(size=len(beliefs))
    step = 1e-5
    for i in (0, 3, 7):
        moves = [z + sign * step * np.eye(z.size)[i] for sign in (1.0, -1.0)]
        up, down = (float(np.sum(beliefs.misfit(m) ** 2)) for m in moves)
        assert beliefs.pull(z)[i] == pytest.approx((up - down) / (4.0 * step), rel=1e-5)
    assert TOLERANCE > 0.0
    changed = body.copy()
    moved(changed, "trailer.cog", 0.1)
    at = {name: i for i, name in enumerate(BODY)}
    # everything moves against the centre of gravity, the ball too
    assert changed[at["trailer.hitch_to_cog"]] == pytest.approx(
        body[at["trailer.hitch_to_cog"]] - 0.1
    )
    assert changed[at["trailer.rear_axle_to_cog"]] == pytest.approx(
        body[at["trailer.rear_axle_to_cog"]] + 0.1
    )
