"""Kinds of physics of the rigid-body plant that nobody lists, from the ninth set on: each says
what its law says.
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
    _way,
    _with,
    impulse,
)

from swaywatch.models.multibody import Multibody
from swaywatch.models.multibody_vehicle import Inputs, Physics, reference_combination


@pytest.fixture(scope="module")
def planar() -> Multibody:
    return Multibody(reference_combination())


def _rest_of_the_car(car, motion):
    """Yaw moment on the car beside those of its wheels and the hitch force, N m."""
    known = car.front.to_cog_m * motion.wheel_fy_n[:2].sum(axis=0) * np.cos(motion.road_wheel_rad)
    known = known + car.rear.to_cog_m * motion.wheel_fy_n[2:4].sum(axis=0)
    known = known - car.hitch_to_cog_m * motion.hitch_y_n
    return car.yaw_inertia_kgm2 * np.gradient(motion.yaw_rate_rad_s, 0.002) - known


def _late(values, lag_s):
    """What follows `values` with a lag, from zero."""
    left = np.zeros_like(values)
    for i in range(1, left.size):
        left[i] = left[i - 1] + 0.002 / lag_s * (values[i - 1] - left[i - 1])
    return left


def _dry(values, slides, lag_s=0.02):
    """State of dry friction that the rate of `values` moves."""
    rate, state = np.gradient(_late(values, lag_s), 0.002), np.zeros_like(values)
    for i in range(1, state.size):
        state[i] = state[i - 1] + 0.002 * (rate[i] - abs(rate[i]) * state[i - 1] / slides)
    return state


def _travel_of_the_trailers_axle(motion, whole, axle):
    travel = _sideslip_of_the_trailer(motion, whole)
    return travel + axle.to_cog_m * motion.trailer_yaw_rate_rad_s / motion.speed_m_s


def test_ball_without_grease_binds_as_it_is_pressed(planar):
    size, _ = UNLISTED["binding_ball"]
    motion = _with("binding_ball")
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    rate = motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s
    said = -size * np.abs(_late(-motion.hitch_y_n, 0.03)) * np.tanh(rate / 0.005)
    assert np.abs(said).max() > 150.0
    assert np.abs(moment - said)[50:-50].max() < 0.12 * np.abs(said).max()


def test_ball_that_rattles_is_held_beyond_its_play(planar):
    """Within it nothing acts between the bodies; without it they are those of the user."""
    healthy = impulse(planar, 100.0, 20.0)
    motion = _with("ball_rattle")
    free = np.abs(motion.hitch_y_n) < 5.0
    before = np.abs(healthy.hitch_y_n) < 5.0
    swings = (motion.time_s > 0.6) & (motion.time_s < 6.0)
    assert free[swings].mean() > before[swings].mean() + 0.05
    changes = [
        np.abs(_changed(planar, more="ball_rattle", more_size=play)).max() for play in (2e-4, 4e-3)
    ]
    assert changes[0] < 0.25 * changes[1]


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_spring_bars_turn_the_trailer_as_it_leans(planar, sense):
    """Its moment is on the car the other way round."""
    size, at = sense * UNLISTED["spring_bars"][0], UNLISTED["spring_bars"][1]
    plant = Multibody(planar.combination, Physics(more="spring_bars", more_size=size, more_at=at))
    motion = impulse(plant, 80.0, 20.0)
    roll = motion.trailer_roll_rad
    said = -size * np.sign(roll) * np.clip(np.abs(roll) - at, 0.0, None)
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert np.abs(said).max() > 200.0
    assert (said == 0.0).mean() > 0.2
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()
    moment = _rest_of_the_car(planar.combination.car, motion)
    assert np.abs(moment + said)[50:-50].max() < 0.15 * np.abs(said).max()


def test_slack_straps_hold_softly_to_their_side(planar):
    """Of one share to both sides a load on a spring; to one side its mirror is the other's."""
    mass, at = UNLISTED["slack_lashing"]

    def run(share, size_deg=20.0, more="slack_lashing"):
        physics = Physics(more=more, more_size=mass, more_at=share, slosh_mass_kg=mass)
        return impulse(Multibody(planar.combination, physics), 100.0, size_deg)

    even, load = run(1.0).trailer_yaw_rate_rad_s, run(0.0, more="").trailer_yaw_rate_rad_s
    assert np.abs(even - load).max() < 1e-9
    left, right = run(at).trailer_yaw_rate_rad_s, run(-at, -20.0).trailer_yaw_rate_rad_s
    assert np.abs(left + right).max() < 1e-6
    assert np.abs(left - even).max() > 0.02 * np.abs(even).max()
    assert np.abs(left - run(-at).trailer_yaw_rate_rad_s).max() > 0.02 * np.abs(even).max()


def test_flow_that_lingers_stays_behind_as_friction_does(planar):
    size, at = UNLISTED["lingering_flow"]
    motion = _with("lingering_flow")
    side, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    beta = _sideslip_of_the_trailer(motion, planar.combination)
    said = -size * 0.6 * motion.speed_m_s**2 * _dry(beta, at)
    assert np.abs(said).max() > 150.0
    assert np.abs(said).max() < 1.01 * size * 0.6 * motion.speed_m_s.max() ** 2 * at
    assert np.abs(side - said)[50:-50].max() < 0.15 * np.abs(said).max()
    assert np.abs(moment - said)[50:-50].max() < 0.15 * np.abs(said).max()


def test_torn_cable_brakes_the_right_side_at_either_sway(planar):
    """The trailer is turned to the right, whichever way it swings."""
    size, at = UNLISTED["torn_cable"]
    trailer = planar.combination.trailer
    physics = Physics(more="torn_cable", more_size=size, more_at=at)
    for sense in (1.0, -1.0):
        motion = impulse(Multibody(planar.combination, physics), 90.0, sense * 15.0)
        lateral = np.abs(motion.trailer_roll_rad) / trailer.roll_gain_rad_m_s2
        drag = 2.0 * size * _late(np.clip(lateral - at, 0.0, None), 0.15)
        said = -0.5 * trailer.front.track_m * drag
        _, moment = _rest_of_the_trailer(trailer, motion)
        assert said.min() < -300.0
        assert np.abs(moment - said)[50:-50].max() < 0.15 * -said.min()
        assert moment[50:-50].max() < 0.15 * -said.min()


def test_hub_drives_turn_the_trailer_late_as_the_car_is_steered(planar):
    size, at = UNLISTED["hub_drives"]
    motion = _with("hub_drives")
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    said = size * _late(motion.road_wheel_rad, at)
    assert np.abs(said).max() > 300.0
    assert np.abs(moment - said)[50:-50].max() < 0.12 * np.abs(said).max()
    at_once = size * motion.road_wheel_rad
    assert np.abs(moment - at_once)[50:-50].max() > 0.4 * np.abs(said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_angle_vectoring_turns_the_car_as_far_as_it_can(planar, sense):
    size, at = sense * UNLISTED["angle_vectoring"][0], UNLISTED["angle_vectoring"][1]
    physics = Physics(more="angle_vectoring", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 80.0, 20.0)
    said = size * np.tanh((motion.trailer_yaw_rad - motion.yaw_rad) / at)
    assert 0.7 * abs(size) < np.abs(said).max() < abs(size)
    moment = _rest_of_the_car(planar.combination.car, motion)
    assert np.abs(moment - said)[50:-50].max() < 0.1 * abs(size)


def test_levelling_pump_steers_the_rear_wheels_after_a_lean(planar):
    size, at = UNLISTED["levelling_pump"]
    motion = _with("levelling_pump")
    angle = _steered(motion, planar.combination.car, 2)
    said = size * _late(motion.roll_rad, at)
    assert np.abs(said).max() > 1e-3
    assert np.abs(angle - said)[50:-50].max() < 0.05 * np.abs(said).max()
    assert np.abs(angle - size * motion.roll_rad)[50:-50].max() > 0.4 * np.abs(said).max()


def test_clay_leaves_the_front_tyres_along_the_road(planar):
    size, at = UNLISTED["clay_tread"]
    motion, car = _with("clay_tread"), planar.combination.car
    travel = motion.wheel_slip_rad[:2].mean(axis=0) + _steered(motion, car, 0)
    grip = 1.0 - size * np.exp(-_way(motion) / at)
    said = -car.front.cornering_stiffness_n_rad * travel * grip
    force = motion.wheel_fy_n[:2].sum(axis=0)
    assert grip[0] == pytest.approx(1.0 - size, abs=0.01)
    assert grip[-1] > 0.95
    assert np.abs(force - said)[50:-50].max() < 0.03 * np.abs(force).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_frame_racks_with_the_pull_of_the_ball_up_to_its_stop(planar, sense):
    size, at = sense * UNLISTED["racked_frame"][0], UNLISTED["racked_frame"][1]
    physics = Physics(more="racked_frame", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 80.0, 20.0)
    said = size * np.tanh(_late(-motion.hitch_y_n, 0.03) / at)
    assert 0.6 * abs(size) < np.abs(said).max()
    trailer = planar.combination.trailer
    for wheel, axle in ((4, trailer.front), (6, trailer.rear)):
        angle = _travel_of_the_trailers_axle(motion, planar.combination, axle)
        angle = angle - motion.wheel_slip_rad[wheel]
        assert np.abs(angle - said)[50:-50].max() < 0.1 * abs(size)


def test_self_steering_axle_swings_after_its_slip(planar):
    size, whole = UNLISTED["caster_flutter"][0], planar.combination
    motion = _with("caster_flutter")
    ways = [_travel_of_the_trailers_axle(motion, whole, a) for a in (
        whole.trailer.front, whole.trailer.rear
    )]  # fmt: skip
    middle, omega = 0.5 * (ways[0] + ways[1]), 2.0 * np.pi
    swing, change = np.zeros_like(middle), 0.0
    for i in range(1, swing.size):
        pull = omega**2 * (middle[i] - swing[i - 1]) - 2.0 * 0.15 * omega * change
        change += 0.002 * pull
        swing[i] = swing[i - 1] + 0.002 * change
    assert np.abs(swing).max() > 1.2 * np.abs(middle).max()
    for wheel, way in ((4, ways[0]), (6, ways[1])):
        angle = way - motion.wheel_slip_rad[wheel]
        assert np.abs(angle - size * swing)[50:-50].max() < 0.05 * size * np.abs(swing).max()


def test_pads_that_squeal_hold_less_as_they_slide_faster(planar):
    size, at = UNLISTED["squealing_pads"]
    motion = _with("squealing_pads")
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    rate = motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s
    said = -size * np.tanh(rate / 0.005) / (1.0 + (rate / at) ** 2)
    assert np.abs(rate).max() > 1.5 * at
    assert np.abs(said).max() > 0.8 * size
    assert np.abs(moment - said)[50:-50].max() < 0.1 * size


def test_outward_damper_lets_the_drawbar_come_back(planar):
    size, at = UNLISTED["outward_damper"]
    motion = _with("outward_damper")
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    rate = motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s
    angle = motion.trailer_yaw_rad - motion.yaw_rad
    said = -0.5 * size * (rate + np.abs(rate) * np.tanh(angle / at))
    assert np.abs(said).max() > 300.0
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()
    back = (angle * rate < 0.0) & (np.abs(angle) > 2.0 * at)
    assert np.abs(size * rate[back]).max() > 200.0
    assert np.abs(moment[back][50:-50]).max() < 0.15 * np.abs(said).max()


def test_seized_mount_holds_the_wheels_back_until_it_slides(planar):
    size, at = UNLISTED["seized_top_mount"]
    motion = _with("seized_top_mount")
    angle = _steered(motion, planar.combination.car, 0)
    said = -size * _dry(motion.road_wheel_rad, at)
    assert 0.8 * size * at < np.abs(said).max() < 1.01 * size * at
    assert np.abs(angle - said)[50:-50].max() < 0.05 * size * at


def test_crosswind_assist_follows_no_faster_than_its_motor(planar):
    size, at = UNLISTED["crosswind_assist"]
    motion, car = _with("crosswind_assist"), planar.combination.car
    angle = _steered(motion, car, 0)
    lateral, said = motion.roll_rad / car.roll_gain_rad_m_s2, np.zeros_like(motion.roll_rad)
    for i in range(1, said.size):
        said[i] = said[i - 1] + 0.002 * np.clip((lateral[i - 1] - said[i - 1]) / 0.1, -at, at)
    assert np.abs(said).max() > 0.5
    assert (np.abs(np.gradient(said, 0.002)) > 0.95 * at).mean() > 0.02
    assert np.abs(angle - size * said)[50:-50].max() < 0.05 * size * np.abs(said).max()


def test_link_steering_answers_once_its_play_is_used_up(planar):
    size, at = UNLISTED["link_steering"]
    motion = _with("link_steering")
    angle = _steered(motion, planar.combination.car, 2)
    turns, rack = motion.trailer_yaw_rate_rad_s, np.zeros_like(angle)
    for i in range(1, rack.size):
        off = turns[i - 1] - rack[i - 1]
        rack[i] = rack[i - 1] + 0.1 * np.sign(off) * max(abs(off) - at, 0.0)
    assert np.abs(rack).max() > 2.0 * at
    assert (np.abs(np.diff(rack)) == 0.0).mean() > 0.1
    assert np.abs(angle - size * rack)[50:-50].max() < 0.05 * size * np.abs(rack).max()
    assert np.abs(angle - size * turns)[50:-50].max() > 0.2 * size * np.abs(rack).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_axle_swings_on_its_broken_leaf_to_one_side(planar, sense):
    size = sense * UNLISTED["broken_leaf"][0]
    plant = Multibody(planar.combination, Physics(more="broken_leaf", more_size=size))
    motion = impulse(plant, 90.0, 20.0)
    said = abs(size) * np.clip(sense * motion.trailer_roll_rad, 0.0, None)
    assert said.max() > 1e-3
    trailer = planar.combination.trailer
    for wheel, axle in ((4, trailer.front), (6, trailer.rear)):
        angle = _travel_of_the_trailers_axle(motion, planar.combination, axle)
        angle = angle - motion.wheel_slip_rad[wheel]
        assert np.abs(angle - said)[50:-50].max() < 0.1 * said.max()


def test_tyres_beside_the_tracks_grip_less(planar):
    size, at = UNLISTED["snow_tracks"]
    motion, axle = _with("snow_tracks"), planar.combination.trailer.front
    force = motion.wheel_fy_n[4:6].sum(axis=0)
    travel = _travel_of_the_trailers_axle(motion, planar.combination, axle)
    beside = np.tanh(((motion.trailer_yaw_rad - motion.yaw_rad) / at) ** 2)
    said = -axle.cornering_stiffness_n_rad * travel * (1.0 - size * beside)
    even = -axle.cornering_stiffness_n_rad * travel
    assert beside.max() > 0.9
    assert np.abs(force - said)[50:-50].max() < 0.05 * np.abs(force).max()
    assert np.abs(force - even)[50:-50].max() > 0.2 * np.abs(force).max()


def test_hunting_vectoring_rings_after_the_articulation_rate(planar):
    size, omega = UNLISTED["hunting_vectoring"][0], 2.0 * np.pi
    motion = _with("hunting_vectoring")
    rate = motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s
    rings, change = np.zeros_like(rate), 0.0
    for i in range(1, rings.size):
        change += 0.002 * (omega**2 * (rate[i] - rings[i - 1]) - 0.3 * omega * change)
        rings[i] = rings[i - 1] + 0.002 * change
    said = size * rings
    assert np.abs(said).max() > 300.0
    moment = _rest_of_the_car(planar.combination.car, motion)
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_roof_tent_is_slack_before_it_is_a_sail(planar):
    size, at = UNLISTED["roof_tent"]
    motion, car = _with("roof_tent"), planar.combination.car
    sideslip = motion.wheel_slip_rad[2] - car.rear.to_cog_m * motion.yaw_rate_rad_s / (
        motion.speed_m_s
    )
    sail = np.sign(sideslip) * np.clip(np.abs(sideslip) - at, 0.0, None)
    said = -size * 0.6 * motion.speed_m_s**2 * sail
    front = motion.wheel_fy_n[:2].sum(axis=0) * np.cos(motion.road_wheel_rad)
    side = car.mass_kg * motion.car_acceleration_m_s2 - front
    side = side - motion.wheel_fy_n[2:4].sum(axis=0) - motion.hitch_y_n
    moment = _rest_of_the_car(car, motion)
    assert np.abs(said).max() > 150.0
    assert (said == 0.0).mean() > 0.2
    assert np.abs(side - said)[50:-50].max() < 0.15 * np.abs(said).max()
    assert np.abs(moment + said)[50:-50].max() < 0.15 * np.abs(said).max()


def test_canvas_catches_more_air_as_it_tears(planar):
    size, at = UNLISTED["tearing_canvas"]
    motion = _with("tearing_canvas")
    side, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    beta = _sideslip_of_the_trailer(motion, planar.combination)
    torn = 1.0 - np.exp(-_way(motion) / at)
    said = -size * 0.6 * motion.speed_m_s**2 * beta * torn
    assert np.abs(said).max() > 150.0
    assert np.abs(side - said)[50:-50].max() < 0.15 * np.abs(said).max()
    assert np.abs(moment + said)[50:-50].max() < 0.15 * np.abs(said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_cocked_overrun_brakes_the_left_side_at_one_pull(planar, sense):
    size, at = sense * UNLISTED["cocked_overrun"][0], UNLISTED["cocked_overrun"][1]
    trailer = planar.combination.trailer
    physics = Physics(more="cocked_overrun", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 90.0, sense * 15.0)
    pull = _late(-motion.hitch_y_n, 0.03)
    drag = 2.0 * abs(size) * np.clip(sense * pull - at, 0.0, None)
    said = 0.5 * trailer.front.track_m * drag
    _, moment = _rest_of_the_trailer(trailer, motion)
    assert said.max() > 300.0
    assert (said == 0.0).mean() > 0.3
    assert np.abs(moment - said)[50:-50].max() < 0.15 * said.max()


def test_straps_that_have_come_loose_hold_softly(planar):
    """At first a load on its spring, in the end on the 0.15 of it that are left."""
    mass, _ = UNLISTED["loosening_straps"]

    def run(**settings):
        physics = Physics(slosh_mass_kg=mass, **settings)
        return impulse(Multibody(planar.combination, physics), 100.0, 20.0).trailer_yaw_rate_rad_s

    given = {"slosh_frequency_hz": 1.2, "slosh_damping": 0.06}
    left = np.sqrt(0.15)
    load = run(**given)
    soft = run(slosh_frequency_hz=1.2 * left, slosh_damping=0.06 / left)
    tight = run(more="loosening_straps", more_size=mass, more_at=1e7, **given)
    loose = run(more="loosening_straps", more_size=mass, more_at=1.0, **given)
    changes = np.abs(soft - load).max()
    assert changes > 0.05 * np.abs(load).max()
    assert np.abs(tight - load).max() < 0.01 * changes
    assert np.abs(loose - soft).max() < 0.02 * changes


def test_dented_race_snaps_from_dent_to_dent(planar):
    size, at = UNLISTED["brinelled_ring"]
    motion = _with("brinelled_ring")
    angle = motion.trailer_yaw_rad - motion.yaw_rad
    said = -size * np.sin(2.0 * np.pi * angle / at)
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert np.abs(angle).max() > at
    assert np.abs(moment - said)[50:-50].max() < 0.05 * size


def test_motor_at_the_ball_works_against_the_trailers_yaw_rate(planar):
    """On both bodies, as strong as it can and no stronger."""
    size, at = UNLISTED["servo_ball"]
    motion = _with("servo_ball")
    said = size * np.tanh(_late(motion.trailer_yaw_rate_rad_s, 0.05) / at)
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    on_the_car = _rest_of_the_car(planar.combination.car, motion)
    assert 0.7 * size < np.abs(said).max() < size
    assert np.abs(moment + said)[50:-50].max() < 0.05 * size
    assert np.abs(on_the_car - said)[50:-50].max() < 0.05 * size


def test_solenoids_hold_on_for_a_while(planar):
    """One size beyond the yaw rate, then less and less, and none before the first turn."""
    size, at = UNLISTED["solenoid_brakes"]
    motion = _with("solenoid_brakes")
    rate = motion.trailer_yaw_rate_rad_s
    on = 0.5 + 0.5 * np.tanh((np.abs(rate) - at) / 0.001)
    said = -size * _late(on, 0.3) * np.tanh(rate / 0.005)
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert np.abs(said).max() > 0.5 * size
    assert np.abs(said)[np.abs(rate) < 0.5 * at].max() > 0.1 * size
    assert np.abs(moment - said)[50:-50].max() < 0.1 * size


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_curve_brake_waits_for_a_lateral_acceleration(planar, sense):
    size, at = sense * UNLISTED["curve_brake"][0], UNLISTED["curve_brake"][1]
    physics = Physics(more="curve_brake", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 80.0, 20.0)
    across = motion.roll_rad / planar.combination.car.roll_gain_rad_m_s2
    said = size * _late(np.sign(across) * np.clip(np.abs(across) - at, 0.0, None), 0.15)
    moment = _rest_of_the_car(planar.combination.car, motion)
    assert np.abs(said).max() > 300.0
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_soft_column_lets_the_wheels_swing_after_the_hand(planar):
    size, omega = UNLISTED["rag_joint"][0], 2.0 * np.pi
    motion = _with("rag_joint")
    place = rate = 0.0
    swings = np.zeros_like(motion.road_wheel_rad)
    for i, asked in enumerate(motion.road_wheel_rad):
        swings[i] = place
        rate += 0.002 * (omega**2 * (asked - place) - 0.3 * omega * rate)
        place += 0.002 * rate
    said = size * (swings - motion.road_wheel_rad)
    angle = _steered(motion, planar.combination.car, 0)
    assert np.abs(said).max() > 0.005
    assert np.abs(angle - said)[50:-50].max() < 0.05 * np.abs(said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_bent_arm_steers_one_way_at_a_lean_to_either_side(planar, sense):
    size = sense * UNLISTED["bent_arm"][0]
    plant = Multibody(planar.combination, Physics(more="bent_arm", more_size=size))
    motion = impulse(plant, 80.0, 20.0)
    said = size * np.abs(motion.roll_rad)
    angle = _steered(motion, planar.combination.car, 0)
    assert np.abs(said).max() > 0.001
    assert np.ptp(np.sign(motion.roll_rad)) == 2.0
    assert np.abs(angle - said)[50:-50].max() < 0.1 * np.abs(said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_rear_wheels_answer_how_quickly_the_front_ones_are_steered(planar, sense):
    size, at = sense * UNLISTED["quick_rear"][0], UNLISTED["quick_rear"][1]
    physics = Physics(more="quick_rear", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 80.0, 20.0)
    rate = (motion.road_wheel_rad - _late(motion.road_wheel_rad, 0.02)) / 0.02
    said = size * at * np.tanh(rate / at)
    angle = _steered(motion, planar.combination.car, 2)
    assert np.abs(said).max() > 0.6 * abs(size) * at
    assert np.abs(angle - said)[50:-50].max() < 0.05 * abs(size) * at


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_stepper_follows_the_yaw_rate_in_steps(planar, sense):
    size, at = sense * UNLISTED["stepper_rear"][0], UNLISTED["stepper_rear"][1]
    physics = Physics(more="stepper_rear", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 80.0, 20.0)
    steps = at * np.round(motion.yaw_rate_rad_s / at)
    said = size * _late(steps, 0.05)
    angle = _steered(motion, planar.combination.car, 2)
    assert np.unique(steps).size >= 4
    assert np.abs(angle - said)[50:-50].max() < 0.1 * abs(size) * at


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_leaky_link_loses_an_angle_that_lasts(planar, sense):
    size, at = sense * UNLISTED["leaky_link"][0], UNLISTED["leaky_link"][1]
    whole = planar.combination
    motion = impulse(
        Multibody(whole, Physics(more="leaky_link", more_size=size, more_at=at)), 70.0, 20.0
    )
    turned = motion.trailer_yaw_rad - motion.yaw_rad
    said = size * (turned - _late(turned, at))
    assert np.abs(said).max() > 0.002
    for wheel, axle in ((4, whole.trailer.front), (6, whole.trailer.rear)):
        angle = _travel_of_the_trailers_axle(motion, whole, axle) - motion.wheel_slip_rad[wheel]
        assert np.abs(angle - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_clamps_creep_beyond_their_grip_and_stay(planar):
    size, at = UNLISTED["creeping_clamp"]
    motion, whole = _with("creeping_clamp"), planar.combination
    slips = motion.wheel_slip_rad[4:].mean(axis=0)
    said = 0.002 * np.cumsum(size * np.sign(slips) * np.clip(np.abs(slips) - at, 0.0, None))
    assert np.abs(said).max() > 0.002
    assert (np.abs(slips) < at).mean() > 0.2
    for wheel, axle in ((4, whole.trailer.front), (6, whole.trailer.rear)):
        angle = _travel_of_the_trailers_axle(motion, whole, axle) - motion.wheel_slip_rad[wheel]
        assert np.abs(angle - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_closing_gap_presses_air_against_the_cars_tail(planar):
    size, _ = UNLISTED["gap_pump"]
    motion, car = _with("gap_pump"), planar.combination.car
    closes = motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s
    said = size * 0.6 * motion.speed_m_s * 2.0 * closes
    front = motion.wheel_fy_n[:2].sum(axis=0) * np.cos(motion.road_wheel_rad)
    side = car.mass_kg * motion.car_acceleration_m_s2 - front
    side = side - motion.wheel_fy_n[2:4].sum(axis=0) - motion.hitch_y_n
    moment = _rest_of_the_car(car, motion)
    assert np.abs(said).max() > 150.0
    assert np.abs(side - said)[50:-50].max() < 0.15 * np.abs(said).max()
    assert np.abs(moment + 2.0 * said)[50:-50].max() < 0.3 * np.abs(said).max()


def test_hull_between_rollers_is_held_by_no_more_than_they_can(planar):
    """What the trailer does to it is of one size, whichever side it lies on."""
    mass, at = UNLISTED["rocking_hull"]
    motion = _with("rocking_hull")
    side, _ = _rest_of_the_trailer(planar.combination.trailer, motion)
    push = (mass * motion.trailer_acceleration_m_s2 - side)[50:-50]
    most = mass * (2.0 * np.pi * 0.9) ** 2 * at
    assert push.max() < 1.1 * most
    assert push.min() > -1.1 * most
    assert (np.abs(push) > 0.9 * most).mean() > 0.3


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_corner_of_a_locker_is_touched_on_one_side(planar, sense):
    size, at = sense * UNLISTED["locker_corner"][0], UNLISTED["locker_corner"][1]
    physics = Physics(more="locker_corner", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 90.0, 20.0)
    turned = sense * (motion.trailer_yaw_rad - motion.yaw_rad)
    said = -size * np.clip(turned - at, 0.0, None)
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert np.abs(said).max() > 200.0
    assert turned.min() < -at
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_hanging_load_is_a_pendulum_between_walls(planar):
    """Free of its walls it is a load on a spring; one that touches them is pushed harder."""
    mass, at = UNLISTED["hanging_load"]

    def run(more, wall=1e3):
        physics = Physics(more=more, more_size=mass, more_at=wall, slosh_mass_kg=mass,
                          slosh_frequency_hz=0.6)  # fmt: skip
        return impulse(Multibody(planar.combination, physics), 90.0, 20.0)

    free, load = run("hanging_load"), run("")
    assert np.abs(free.trailer_yaw_rate_rad_s - load.trailer_yaw_rate_rad_s).max() < 1e-9
    pushes = []
    for motion in (free, run("hanging_load", at)):
        side, _ = _rest_of_the_trailer(planar.combination.trailer, motion)
        pushes.append(np.abs(mass * motion.trailer_acceleration_m_s2 - side)[50:-50].max())
    assert pushes[1] > 1.3 * pushes[0]


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_bump_steer_grows_with_the_cube_of_a_lean(planar, sense):
    size = sense * UNLISTED["bump_steer"][0]
    plant = Multibody(planar.combination, Physics(more="bump_steer", more_size=size))
    motion = impulse(plant, 80.0, 25.0)
    said = size * motion.roll_rad**3
    angle = _steered(motion, planar.combination.car, 0)
    assert np.abs(said).max() > 5e-4
    assert np.abs(angle - said)[50:-50].max() < 0.1 * np.abs(said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_joints_of_a_frame_work_with_dry_friction(planar, sense):
    size, at = sense * UNLISTED["working_frame"][0], UNLISTED["working_frame"][1]
    whole = planar.combination
    physics = Physics(more="working_frame", more_size=size, more_at=at)
    motion = impulse(Multibody(whole, physics), 80.0, 20.0)
    said = size * _dry(-motion.hitch_y_n, at, 0.03)
    assert 0.7 * abs(size) * at < np.abs(said).max() < 1.01 * abs(size) * at
    for wheel, axle in ((4, whole.trailer.front), (6, whole.trailer.rear)):
        angle = _travel_of_the_trailers_axle(motion, whole, axle) - motion.wheel_slip_rad[wheel]
        assert np.abs(angle - said)[50:-50].max() < 0.1 * np.abs(said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_rear_wheels_are_steered_after_the_front_ones(planar, sense):
    size, at = sense * UNLISTED["late_rear_steering"][0], UNLISTED["late_rear_steering"][1]
    physics = Physics(more="late_rear_steering", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 80.0, 20.0)
    said = size * _late(motion.road_wheel_rad, at)
    angle = _steered(motion, planar.combination.car, 2)
    assert np.abs(said).max() > 5e-4
    assert np.abs(angle - said)[50:-50].max() < 0.05 * np.abs(said).max()


def test_tarpaulin_is_slack_before_the_wind_fills_it(planar):
    size, at = UNLISTED["slack_tarpaulin"]
    motion = _with("slack_tarpaulin")
    side, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    beta = _sideslip_of_the_trailer(motion, planar.combination)
    full = np.sign(beta) * np.clip(np.abs(beta) - at, 0.0, None)
    said = -size * 0.6 * motion.speed_m_s**2 * full
    assert np.abs(said).max() > 150.0
    assert (said == 0.0).mean() > 0.2
    assert np.abs(side - said)[50:-50].max() < 0.15 * np.abs(said).max()
    assert np.abs(moment + said)[50:-50].max() < 0.15 * np.abs(said).max()


def test_tilted_head_jams_as_the_trailer_leans(planar):
    size, _ = UNLISTED["tilted_head"]
    motion = _with("tilted_head")
    rate = motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s
    said = -size * np.abs(motion.trailer_roll_rad) * np.tanh(rate / 0.005)
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert np.abs(said).max() > 200.0
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_front_tyres_float_on_puddles_along_the_road(planar):
    size, at = UNLISTED["puddles"]
    motion, car = _with("puddles"), planar.combination.car
    travel = motion.wheel_slip_rad[:2].mean(axis=0) + _steered(motion, car, 0)
    grip = 1.0 - 0.5 * size * (1.0 + np.sin(2.0 * np.pi * _way(motion) / at))
    said = -car.front.cornering_stiffness_n_rad * travel * grip
    force = motion.wheel_fy_n[:2].sum(axis=0)
    assert grip.min() < 1.01 - size
    assert grip.max() > 0.99
    assert np.abs(force - said)[50:-50].max() < 0.03 * np.abs(force).max()


def test_roll_protection_brakes_the_outer_wheels(planar):
    """Against the turn, whichever way it is, and later than that."""
    size, at = UNLISTED["roll_protection"]
    motion, trailer = _with("roll_protection"), planar.combination.trailer
    across = motion.trailer_roll_rad / trailer.roll_gain_rad_m_s2
    drag = 2.0 * size * _late(np.sign(across) * np.clip(np.abs(across) - at, 0.0, None), 0.15)
    said = -0.5 * trailer.front.track_m * drag
    _, moment = _rest_of_the_trailer(trailer, motion)
    assert min(said.max(), -said.min()) > 200.0
    assert np.abs(moment - said)[50:-50].max() < 0.15 * np.abs(said).max()


def test_subframe_in_rubber_gives_way_late(planar):
    size, at = UNLISTED["subframe_rubber"]
    motion = _with("subframe_rubber")
    angle = _steered(motion, planar.combination.car, 2)
    said = size * _late(motion.wheel_slip_rad[2:4].mean(axis=0) + angle, at)
    assert np.abs(said).max() > 5e-4
    assert np.abs(angle - said)[50:-50].max() < 0.05 * np.abs(said).max()
    at_once = size * (motion.wheel_slip_rad[2:4].mean(axis=0) + angle)
    assert np.abs(angle - at_once)[50:-50].max() > 0.2 * np.abs(said).max()


THIRTEENTH = (
    "soft_tyre", "greasy_ball", "crooked_joint", "soft_verge", "leaning_stack", "loose_hub",
    "broken_link", "slipping_neck", "open_door", "shimmy",
)  # fmt: skip


@pytest.mark.parametrize("kind", THIRTEENTH)
def test_of_no_size_it_changes_nothing(planar, kind):
    """A ball neck that gives way by a micrometre for ten newtons does nearly nothing."""
    stiff = kind == "slipping_neck"
    size, at = (1e-7 if stiff else 0.0), UNLISTED[kind][1]
    change = np.abs(_changed(planar, more=kind, more_size=size, more_at=at)).max()
    assert change < (2e-4 if stiff else 1e-12)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_soft_tyres_hold_less_as_the_trailer_leans_on_them(planar, sense):
    size, at = sense * UNLISTED["soft_tyre"][0], UNLISTED["soft_tyre"][1]
    whole = planar.combination
    motion = impulse(
        Multibody(whole, Physics(more="soft_tyre", more_size=size, more_at=at)), 90.0, 20.0
    )
    travel = _travel_of_the_trailers_axle(motion, whole, whole.trailer.front)
    lost = abs(size) * np.tanh(np.clip(sense * motion.trailer_roll_rad, 0.0, None) / at)
    said = -whole.trailer.front.cornering_stiffness_n_rad * travel * (1.0 - lost)
    force = motion.wheel_fy_n[4:6].sum(axis=0)
    assert lost.max() > 0.7 * abs(size)
    assert (lost == 0.0).mean() > 0.2
    assert np.abs(force - said)[50:-50].max() < 0.05 * np.abs(force).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_greased_side_of_a_ball_does_not_hold(planar, sense):
    size, at = sense * UNLISTED["greasy_ball"][0], UNLISTED["greasy_ball"][1]
    physics = Physics(more="greasy_ball", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 100.0, 20.0)
    turned = sense * (motion.trailer_yaw_rad - motion.yaw_rad)
    rate = motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s
    said = -abs(size) * 0.5 * (1.0 + np.tanh(turned / at)) * np.tanh(rate / 0.005)
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert np.abs(said).max() > 0.9 * abs(size)
    assert np.abs(moment - said)[50:-50].max() < 0.1 * abs(size)
    greased = turned < -2.0 * at
    assert greased.mean() > 0.04
    assert np.abs(moment[greased][50:-50]).max() < 0.15 * abs(size)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_crooked_joint_favours_one_side(planar, sense):
    size = sense * UNLISTED["crooked_joint"][0]
    plant = Multibody(planar.combination, Physics(more="crooked_joint", more_size=size))
    time = np.arange(0.0, 8.0, 0.01)
    motion = plant.run(
        Inputs(time, np.radians(20.0) * np.sin(3.0 * time), np.full(time.size, 20.0))
    )
    said = size * np.sin(motion.steering_wheel_rad) ** 2
    angle = _steered(motion, planar.combination.car, 0)
    assert np.abs(said).max() > 0.002
    assert np.abs(angle - said)[50:-50].max() < 0.05 * np.abs(said).max()


def test_soft_verge_drags_in_stretches_of_the_road(planar):
    size, at = UNLISTED["soft_verge"]
    motion, trailer = _with("soft_verge"), planar.combination.trailer
    drag = 2.0 * size * np.clip(np.sin(2.0 * np.pi * _way(motion) / at), 0.0, None)
    said = -0.5 * trailer.front.track_m * drag
    _, moment = _rest_of_the_trailer(trailer, motion)
    assert said.min() < -1.9 * size * 0.5 * trailer.front.track_m
    assert np.abs(moment - said)[50:-50].max() < 0.15 * np.abs(said).max()


def test_stack_leans_with_friction_in_it(planar):
    """Held by its friction it is a load on a spring; else by what is left of the spring."""
    mass, at = UNLISTED["leaning_stack"]

    def run(hz=1.3, **settings):
        physics = Physics(slosh_mass_kg=mass, slosh_frequency_hz=hz, slosh_damping=0.0, **settings)
        return impulse(Multibody(planar.combination, physics), 70.0, 20.0)

    def stack(slides):
        return run(more="leaning_stack", more_size=mass, more_at=slides)

    held, load = stack(1e6).trailer_yaw_rate_rad_s, run().trailer_yaw_rate_rad_s
    assert np.abs(held - load).max() < 1e-6
    loose, soft = stack(5e-4), run(1.3 * np.sqrt(0.4))
    apart = np.abs(soft.trailer_yaw_rate_rad_s - load).max()
    assert np.abs(loose.trailer_yaw_rate_rad_s - soft.trailer_yaw_rate_rad_s).max() < 0.1 * apart
    motion, omega = stack(at), 2.0 * np.pi * 1.3
    place = rate = rubs = lost = 0.0
    said = np.zeros_like(motion.time_s)
    for i, pushed in enumerate(motion.trailer_acceleration_m_s2):
        said[i] = mass * omega**2 * (0.4 * place + 0.6 * rubs)
        lost += 0.002 * mass * omega**2 * 0.6 * rubs * rate
        rate -= 0.002 * (omega**2 * (0.4 * place + 0.6 * rubs) + pushed)
        rubs += 0.002 * (rate - abs(rate) * rubs / at)
        place += 0.002 * rate
    side, _ = _rest_of_the_trailer(planar.combination.trailer, motion)
    pull = side - mass * motion.trailer_acceleration_m_s2
    assert np.abs(pull - said)[50:-50].max() < 0.1 * np.abs(said).max()
    assert lost > 10.0


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_loose_hub_drags_on_its_pads_at_either_side_force(planar, sense):
    size = sense * UNLISTED["loose_hub"][0]
    plant = Multibody(planar.combination, Physics(more="loose_hub", more_size=size))
    motion = impulse(plant, 80.0, 20.0)
    slips = motion.wheel_slip_rad[:2].mean(axis=0)
    said = size * np.abs(slips)
    moment = _rest_of_the_car(planar.combination.car, motion)
    assert np.abs(said).max() > 300.0
    assert np.ptp(np.sign(slips)) == 2.0
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_link_breaks_at_the_first_hard_lean(planar, sense):
    """Nothing before, then steering by leaning; nothing at all where it never leans so far."""
    size, at = sense * UNLISTED["broken_link"][0], UNLISTED["broken_link"][1]
    physics = Physics(more="broken_link", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 80.0, 20.0)
    hard = int(np.argmax(np.abs(motion.roll_rad) > at))
    angle = _steered(motion, planar.combination.car, 2)
    said = size * motion.roll_rad
    largest = np.abs(said).max()
    assert hard > 300
    assert np.abs(angle[50:hard]).max() < 0.02 * largest
    assert np.abs(angle - said)[hard + 150 : -50].max() < 0.05 * largest
    assert np.abs(motion.roll_rad[hard + 150 :]).min() < 0.1 * at
    gentle = _changed(planar, 2.0, more="broken_link", more_size=size, more_at=at)
    assert np.abs(gentle).max() < 1e-12


def test_neck_slips_in_its_seat_beyond_its_friction(planar):
    """Without friction it is an elastic drawbar; with enough of it nothing moves."""
    size, at = UNLISTED["slipping_neck"]

    def changes(size_deg, friction):
        return np.abs(
            _changed(planar, size_deg, more="slipping_neck", more_size=size, more_at=friction)
        ).max()

    free = _changed(planar, more="slipping_neck", more_size=size, more_at=0.0)
    elastic = _changed(planar, more="elastic_drawbar", more_size=1.0 / size)
    assert np.abs(free - elastic).max() < 1e-9
    largest = np.abs(elastic).max()
    assert changes(20.0, 1e4) < 0.1 * largest
    assert 0.2 * largest < changes(20.0, at)
    assert changes(1.0, at) < 0.2 * changes(1.0, 0.0)


def test_open_door_turns_into_the_flow_as_a_vane(planar):
    """Its swing takes a length of the road; its force acts at the trailer's rear."""
    size, at = UNLISTED["open_door"]
    for speed in (70.0, 100.0):
        plant = Multibody(planar.combination, Physics(more="open_door", more_size=size, more_at=at))
        motion = impulse(plant, speed, 20.0)
        flow = _sideslip_of_the_trailer(motion, planar.combination)
        flow = flow - 2.5 * motion.trailer_yaw_rate_rad_s / motion.speed_m_s
        omega, change, door = 2.0 * np.pi * motion.speed_m_s / at, 0.0, np.zeros_like(flow)
        for i in range(1, door.size):
            pull = omega[i] ** 2 * (flow[i] - door[i - 1]) - 0.4 * omega[i] * change
            change += 0.002 * pull
            door[i] = door[i - 1] + 0.002 * change
        said = -size * 0.6 * motion.speed_m_s**2 * (flow - door)
        side, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
        assert np.abs(said).max() > 100.0
        assert np.abs(side - said)[50:-50].max() < 0.15 * np.abs(said).max()
        assert np.abs(moment + 2.5 * said)[50:-50].max() < 0.15 * 2.5 * np.abs(said).max()


@pytest.mark.parametrize("hz", [2.0, 4.0])
def test_front_wheels_shimmy_by_themselves(planar, hz):
    """Once they are touched; never larger than its size, and not before."""
    size = UNLISTED["shimmy"][0]
    plant = Multibody(
        planar.combination, Physics(more="shimmy", more_size=size, more_frequency_hz=hz)
    )
    motion = impulse(plant, 70.0, 0.5, until=20.0)
    angle = _steered(motion, planar.combination.car, 0)
    late = angle[motion.time_s > 12.0][:-50]
    spectrum = np.abs(np.fft.rfft(late * np.hanning(late.size), 1 << 16))
    assert np.argmax(spectrum) / ((1 << 16) * 0.002) == pytest.approx(hz, rel=0.05)
    assert np.abs(late).max() == pytest.approx(size, rel=0.1)
    assert np.abs(angle[motion.time_s < 0.5]).max() < 1e-9
