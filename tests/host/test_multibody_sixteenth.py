"""Kinds of physics of the rigid-body plant that nobody lists, of the sixteenth set: each says what
its law says.
"""

import numpy as np
import pytest

pytest.importorskip("mujoco")

from multibody_sizes import UNLISTED
from test_multibody import (
    _changed,
    _rest_of_the_trailer,
    _sideslip_of_the_trailer,
    _steered,
    _with,
    _without_rack,
    impulse,
)
from test_multibody_more import _late, _rest_of_the_car, _travel_of_the_trailers_axle
from test_multibody_newest import _places

from swaywatch.models.multibody import Multibody
from swaywatch.models.multibody_vehicle import Inputs, Physics, reference_combination

OF_NO_SIZE = (
    "aged_tyres", "camera_rear", "bistable_wake", "controlled_joint", "binding_rack",
    "caster_lock", "passing_lorry", "wallowing_tail", "lane_departure", "braking_driver",
)  # fmt: skip


@pytest.fixture(scope="module")
def planar() -> Multibody:
    return Multibody(reference_combination())


@pytest.mark.parametrize("kind", OF_NO_SIZE)
def test_of_no_size_it_changes_nothing(planar, kind):
    change = _changed(planar, more=kind, more_size=0.0, more_at=UNLISTED[kind][1])
    assert np.abs(change).max() < 1e-12


def test_old_rubber_slides_early(planar):
    size, at = UNLISTED["aged_tyres"]
    motion, whole = _with("aged_tyres"), planar.combination
    for wheel, axle in ((4, whole.trailer.front), (6, whole.trailer.rear)):
        travel = _travel_of_the_trailers_axle(motion, whole, axle)
        x = travel / at
        said = -axle.cornering_stiffness_n_rad * travel * (1.0 - size * x**2 / (1.0 + x**2))
        force = motion.wheel_fy_n[wheel : wheel + 2].sum(axis=0)
        assert np.abs(x).max() > 2.0
        assert np.abs(force - said)[50:-50].max() < 0.05 * np.abs(force).max()


def test_rear_wheels_hold_what_a_camera_last_saw(planar):
    size, at = UNLISTED["camera_rear"]
    motion = _with("camera_rear")
    turned, last = motion.trailer_yaw_rad - motion.yaw_rad, np.floor(motion.time_s / at) * at
    said = size * np.interp(last + 0.01, motion.time_s, turned)
    angle = _steered(motion, planar.combination.car, 2)
    looks = (motion.time_s - last > 0.014) & (motion.time_s - last < at - 0.004)
    assert np.abs(said).max() > 1e-3
    assert np.abs(angle - said)[looks].max() < 0.05 * np.abs(said).max()


def test_wake_turns_over_beyond_a_sideslip_and_stays(planar):
    """It pulls at the tail, which turns the trailer the other way."""
    size, at = UNLISTED["bistable_wake"]
    motion, wake = _with("bistable_wake"), 0.0
    sideslip, lies = _sideslip_of_the_trailer(motion, planar.combination), []
    for beta, speed in zip(sideslip, motion.speed_m_s, strict=True):
        lies.append(wake)
        wake += 0.002 * (np.tanh(2.0 * wake + 0.533 * beta / at) - wake) * speed / 4.0
    said = -size * 0.6 * motion.speed_m_s**2 * np.array(lies)
    side, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert (np.diff(np.sign(lies[1000:])) != 0.0).sum() >= 2
    straight = (motion.time_s > 2.0) & (np.abs(sideslip) < 0.3 * at)
    assert np.abs(np.array(lies)[straight]).min() > 0.7
    assert np.abs(side - said)[50:-50].max() < 0.2 * np.abs(said).max()
    assert np.abs(moment + 2.0 * said)[50:-50].max() < 0.2 * np.abs(2.0 * said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_crack_opens_one_way(planar, sense):
    """Its mirror image opens the other way; one that is as stiff as if it were shut is soft so."""
    size = sense * UNLISTED["open_crack"][0]
    whole = planar.combination
    one, other = (
        impulse(Multibody(whole, Physics(more="open_crack", more_size=way * size)), 100.0, way * 20)
        for way in (1.0, -1.0)
    )
    turns = one.trailer_yaw_rate_rad_s
    assert np.abs(turns + other.trailer_yaw_rate_rad_s).max() < 1e-6 * np.abs(turns).max()
    off = np.abs(_changed(planar, more="open_crack", more_size=size)).max()
    shut = np.abs(_changed(planar, more="open_crack", more_size=sense * 2e6)).max()
    both = np.abs(_changed(planar, more="elastic_drawbar", more_size=abs(size))).max()
    assert shut < 0.2 * off
    assert 0.1 * both < off < 0.9 * both


def test_valve_of_a_joint_closes_with_the_cars_yaw_rate(planar):
    size, _ = UNLISTED["controlled_joint"]
    motion = _with("controlled_joint")
    said = -size * _late(np.abs(motion.yaw_rate_rad_s), 0.1)
    said = said * (motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s)
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert np.abs(said).max() > 200.0
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_rack_binds_as_it_is_moved_under_a_side_force(planar):
    size, at = UNLISTED["binding_rack"]
    motion = _with("binding_rack")
    angle = _steered(motion, planar.combination.car, 0)
    steer = motion.road_wheel_rad
    rate = (steer - _late(steer, 0.02)) / 0.02
    slip = motion.wheel_slip_rad[:2].mean(axis=0) + angle
    said = -size * np.abs(slip) * np.tanh(rate / at)
    assert np.abs(said).max() > 5e-4
    assert np.abs(angle - said)[50:-50].max() < 0.1 * np.abs(said).max()
    assert np.abs(angle[motion.time_s > 1.6]).max() < 0.05 * np.abs(said).max()


def test_crate_that_is_held_is_a_part_of_the_car(planar):
    """With friction that never slips the whole is the combination that its user knows."""
    mass = UNLISTED["tailgate_crate"][0]
    whole = _without_rack(planar.combination, mass)
    healthy = impulse(planar, 100.0, 20.0).yaw_rate_rad_s
    off, slides, without = (
        np.abs(impulse(Multibody(whole, physics), 100.0, 20.0).yaw_rate_rad_s - healthy).max()
        for physics in (
            Physics(more="tailgate_crate", more_size=mass, more_at=8.0, more_frequency_hz=3.0),
            Physics(more="tailgate_crate", more_size=mass, more_at=0.3, more_frequency_hz=3.0),
            Physics(),
        )
    )
    assert off < 0.1 * without
    assert slides > 0.3 * without


def test_crate_is_pushed_by_friction_until_it_strikes_a_wall(planar):
    mass, at = UNLISTED["tailgate_crate"]
    whole = _without_rack(planar.combination, mass)
    physics = Physics(more="tailgate_crate", more_size=mass, more_at=at, more_frequency_hz=3.0)
    motion = impulse(Multibody(whole, physics), 100.0, 20.0)
    front = motion.wheel_fy_n[:2].sum(axis=0) * np.cos(motion.road_wheel_rad)
    push = whole.car.mass_kg * motion.car_acceleration_m_s2 - front
    push = np.abs(push - motion.wheel_fy_n[2:4].sum(axis=0) - motion.hitch_y_n)[50:-50]
    assert push.max() > 1.5 * mass * at
    assert (push < 1.2 * mass * at).mean() > 0.5
    assert (np.abs(push - mass * at) < 0.2 * mass * at).mean() > 0.1


def test_pin_of_a_self_steering_axle_drops_back_later_than_it_rises(planar):
    size, at = UNLISTED["caster_lock"]
    motion, whole = _with("caster_lock"), planar.combination
    axles = ((4, whole.trailer.front), (6, whole.trailer.rear))
    travel = [_travel_of_the_trailers_axle(motion, whole, axle) for _, axle in axles]
    pin, up = 0.0, []
    for slip in np.abs(np.mean(travel, axis=0)):
        up.append(pin)
        if slip > at or slip < at / 3.0:
            pin += 0.002 / 0.03 * ((1.0 if slip > at else 0.0) - pin)
    up = np.array(up)
    assert (up > 0.9).mean() > 0.1
    assert (up < 0.1).mean() > 0.1
    for (wheel, axle), slip in zip(axles, travel, strict=True):
        said = -axle.cornering_stiffness_n_rad * slip * (1.0 - size * up)
        force = motion.wheel_fy_n[wheel : wheel + 2].sum(axis=0)
        off = np.abs(force - said)[50:-50] / np.abs(force).max()
        assert np.quantile(off, 0.95) < 0.05


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_lorries_push_at_the_tail_and_pull_at_the_nose(planar, sense):
    size, at = sense * UNLISTED["passing_lorry"][0], UNLISTED["passing_lorry"][1]
    plant = Multibody(planar.combination, Physics(more="passing_lorry", more_size=size, more_at=at))
    time = np.arange(0.0, 12.0, 0.01)
    motion = plant.run(Inputs(time, 0.0 * time, np.full_like(time, 22.0)))
    past = (motion.time_s % at - 0.5 * at) / 0.4
    said = size * past * np.exp(0.5 - 0.5 * past**2)
    turns = 3.0 * np.tanh(past) * said
    side, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert np.abs(said).max() == pytest.approx(abs(size), rel=0.01)
    assert np.abs(side - said)[50:-50].max() < 0.1 * np.abs(said).max()
    assert np.abs(moment - turns)[50:-50].max() < 0.1 * np.abs(turns).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_tail_wallows_after_a_lean(planar, sense):
    size, omega = sense * UNLISTED["wallowing_tail"][0], 2.0 * np.pi * 1.2
    physics = Physics(more="wallowing_tail", more_size=size, more_frequency_hz=1.2)
    motion = impulse(Multibody(planar.combination, physics), 80.0, 20.0)
    place, rate, swings = 0.0, 0.0, []
    for roll in motion.roll_rad:
        swings.append(place)
        rate += 0.002 * (omega**2 * (roll - place) - 0.3 * omega * rate)
        place += 0.002 * rate
    said = size * np.array(swings)
    angle = _steered(motion, planar.combination.car, 2)
    assert np.abs(said).max() > 1e-3
    assert np.abs(angle - said)[50:-50].max() < 0.05 * np.abs(said).max()


def test_steering_back_begins_beside_the_middle_of_a_lane(planar):
    size, at = UNLISTED["lane_departure"]
    motion = _with("lane_departure")
    turns = motion.car_acceleration_m_s2 / motion.speed_m_s - motion.yaw_rate_rad_s
    place = _places(motion, planar.combination, np.cumsum(turns) * 0.002)[0]
    said = -size * np.sign(place) * np.clip(np.abs(place) - at, 0.0, None)
    angle = _steered(motion, planar.combination.car, 0)
    assert np.abs(said).max() > 1e-3
    assert (said == 0.0).mean() > 0.1
    assert np.abs(angle - said)[50:-50].max() < 0.05 * np.abs(said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_one_front_brake_turns_the_car_as_its_driver_brakes(planar, sense):
    """To its own side, whichever way the car swings, after a reaction time."""
    size, at = UNLISTED["braking_driver"]
    physics = Physics(more="braking_driver", more_size=sense * size, more_at=at)
    car = planar.combination.car
    motion = impulse(Multibody(planar.combination, physics), 100.0, 20.0)
    startles = np.clip(np.abs(motion.yaw_rate_rad_s) - 0.02, 0.0, None)
    said = sense * 0.5 * car.front.track_m * size * _late(_late(startles, at / 2.0), at / 2.0)
    moment = _rest_of_the_car(car, motion)
    assert np.abs(said).max() > 300.0
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()
