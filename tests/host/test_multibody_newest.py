"""Kinds of physics of the rigid-body plant that nobody lists, of the fourteenth and the fifteenth
set: each says what its law says.
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
from test_multibody_more import _dry, _late, _rest_of_the_car, _travel_of_the_trailers_axle

from swaywatch.models.multibody import Multibody
from swaywatch.models.multibody_vehicle import Physics, reference_combination

FOURTEENTH = (
    "lorry_ruts", "standing_water", "bump_stop_grip", "loose_hands", "worn_pad", "track_rod_end",
    "hopping_wheels", "buckled_wheel", "skew_joints", "slow_puncture",
)  # fmt: skip
FIFTEENTH = (
    "late_correction", "rut_walls", "rolled_under", "one_wheel_brake", "stop_overload",
    "wind_shadow", "wet_stretches", "loose_subframe", "gap_headwind", "sticky_beam", "worn_spot",
)  # fmt: skip


@pytest.fixture(scope="module")
def planar() -> Multibody:
    return Multibody(reference_combination())


def _places(motion, whole, sideslip):
    """Places across the road, m, of the car's COG and the trailer's; and headings of both on it."""
    course = motion.yaw_rad + sideslip
    road, across = _late(course, 2.5), np.zeros_like(course)
    for i in range(1, across.size):
        moves = motion.speed_m_s[i] * np.sin(course[i - 1] - road[i - 1])
        across[i] = across[i - 1] + 0.002 * (moves - across[i - 1] / 2.5)
    car, trailer = motion.yaw_rad - road, motion.trailer_yaw_rad - road
    behind = whole.car.hitch_to_cog_m * np.sin(car)
    behind = behind + whole.trailer.hitch_to_cog_m * np.sin(trailer)
    return across, across - behind, car, trailer


@pytest.mark.parametrize("kind", FOURTEENTH + FIFTEENTH)
def test_of_no_size_it_changes_nothing(planar, kind):
    change = _changed(planar, more=kind, more_size=0.0, more_at=UNLISTED[kind][1])
    assert np.abs(change).max() < 1e-12


@pytest.mark.parametrize("speed", [70.0, 100.0])
def test_walls_of_ruts_push_each_axle_back(planar, speed):
    """By its own place across them: of the trailer's axle, by that of the ball and its heading."""
    size, at = UNLISTED["lorry_ruts"]
    whole = planar.combination
    plant = Multibody(whole, Physics(more="lorry_ruts", more_size=size, more_at=at))
    motion = impulse(plant, speed, 20.0)
    # the wheels' slip is beside their own angle: the sideslip comes from the acceleration
    turns = motion.car_acceleration_m_s2 / motion.speed_m_s - motion.yaw_rate_rad_s
    sideslip = np.cumsum(turns) * 0.002
    across, behind, car, trailer = _places(motion, whole, sideslip)
    for wheel, axle, place, heading, travel in (
        (0, whole.car.front, across, car, sideslip - motion.road_wheel_rad),
        (2, whole.car.rear, across, car, sideslip),
    ):
        x = (place + axle.to_cog_m * np.sin(heading)) / at
        said = -2.0 * size * x / (1.0 + x**2)
        slips = travel + axle.to_cog_m * motion.yaw_rate_rad_s / motion.speed_m_s
        angle = slips - motion.wheel_slip_rad[wheel]
        assert np.abs(said).max() > 0.8 * size
        assert np.abs(angle - said)[50:-50].max() < 0.15 * size
    axle = whole.trailer.rear
    x = (behind + axle.to_cog_m * np.sin(trailer)) / at
    said = -2.0 * size * x / (1.0 + x**2)
    ball = sideslip - whole.car.hitch_to_cog_m * motion.yaw_rate_rad_s / motion.speed_m_s
    lever = whole.trailer.hitch_to_cog_m - axle.to_cog_m
    slips = ball + motion.yaw_rad - motion.trailer_yaw_rad
    slips = slips - lever * motion.trailer_yaw_rate_rad_s / motion.speed_m_s
    angle = slips - motion.wheel_slip_rad[6]
    assert np.abs(said).max() > 0.8 * size
    assert np.abs(angle - said)[50:-50].max() < 0.2 * size


def test_water_drags_on_the_wheel_that_throws_it_aside(planar):
    size, at = UNLISTED["standing_water"]
    motion, car = _with("standing_water"), planar.combination.car
    lies = np.clip(np.sin(2.0 * np.pi * _way(motion) / at), 0.0, None)
    said = 0.5 * car.front.track_m * size * (motion.speed_m_s / 25.0) ** 2 * lies
    moment = _rest_of_the_car(car, motion)
    assert said.max() > 500.0
    assert (said == 0.0).mean() > 0.3
    assert np.abs(moment - said)[50:-50].max() < 0.15 * said.max()


def test_bump_stops_cost_the_rear_tyres_grip(planar):
    size, at = UNLISTED["bump_stop_grip"]
    motion, car = _with("bump_stop_grip"), planar.combination.car
    travel = motion.wheel_slip_rad[2:4].mean(axis=0) + _steered(motion, car, 2)
    lost = size * np.tanh(np.clip(np.abs(motion.roll_rad) / at - 1.0, 0.0, None))
    said = -car.rear.cornering_stiffness_n_rad * travel * (1.0 - lost)
    force = motion.wheel_fy_n[2:4].sum(axis=0)
    assert lost.max() > 0.7 * size
    assert (lost == 0.0).mean() > 0.2
    assert np.abs(force - said)[50:-50].max() < 0.05 * np.abs(force).max()


def test_loose_hands_let_the_wheels_turn_late(planar):
    size, at = UNLISTED["loose_hands"]
    motion = _with("loose_hands")
    angle = _steered(motion, planar.combination.car, 0)
    said = size * _late(motion.wheel_slip_rad[:2].mean(axis=0) + angle, at)
    assert np.abs(said).max() > 5e-4
    assert np.abs(angle - said)[50:-50].max() < 0.05 * np.abs(said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_worn_pad_holds_less_one_way(planar, sense):
    size, share = sense * UNLISTED["worn_pad"][0], UNLISTED["worn_pad"][1]
    physics = Physics(more="worn_pad", more_size=size, more_at=share)
    motion = impulse(Multibody(planar.combination, physics), 100.0, 20.0)
    rubs = np.tanh((motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s) / 0.005)
    said = -abs(size) * rubs * np.where(sense * rubs > 0.0, 1.0, share)
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    most = sorted((-sense * said.min(), sense * said.max()), key=abs)
    assert most == pytest.approx([sense * share * abs(size), sense * abs(size)], rel=0.05)
    assert np.abs(moment - said)[50:-50].max() < 0.1 * abs(size)


def test_worn_track_rod_end_lets_one_wheel_give_way_to_a_stop(planar):
    size, at = UNLISTED["track_rod_end"]
    motion = _with("track_rod_end")
    left, right = motion.wheel_slip_rad[:2]
    said = size * np.tanh(right / at)
    assert np.abs(said).max() > 0.5 * size
    # their places differ across the car: wheels of one axle travel by not quite one angle
    assert np.abs(right - left - said)[50:-50].max() < 0.05 * np.abs(said).max()


def test_rear_wheels_hop_on_rough_stretches(planar):
    size, at = UNLISTED["hopping_wheels"]
    motion, car = _with("hopping_wheels"), planar.combination.car
    travel = motion.wheel_slip_rad[2:4].mean(axis=0) + _steered(motion, car, 2)
    grip = 1.0 - size * np.clip(np.sin(2.0 * np.pi * _way(motion) / at), 0.0, None)
    said = -car.rear.cornering_stiffness_n_rad * travel * grip
    force = motion.wheel_fy_n[2:4].sum(axis=0)
    assert grip.min() < 1.01 - size
    assert (grip == 1.0).mean() > 0.3
    assert np.abs(force - said)[50:-50].max() < 0.05 * np.abs(force).max()


def test_buckled_wheel_wobbles_as_it_rolls(planar):
    """One turn in the length of its tread, and the other wheels do not."""
    size, _ = UNLISTED["buckled_wheel"]
    motion = _with("buckled_wheel")
    wobbles = motion.wheel_slip_rad[4] - motion.wheel_slip_rad[5]
    said = size * np.sin(_way(motion) / planar.combination.wheel_radius_m)
    assert np.abs(wobbles - said)[50:-50].max() < 0.25 * size  # a place of 1 cm is 2 deg of a turn
    assert np.ptp(motion.wheel_slip_rad[6] - motion.wheel_slip_rad[7]) < 0.05 * size


def test_slow_puncture_takes_the_force_of_one_rear_tyre(planar):
    size, at = UNLISTED["slow_puncture"]
    motion = _with("slow_puncture")
    left, right = motion.wheel_fy_n[2:4] / motion.wheel_fz_n[2:4]  # a force goes with its load
    kept = 1.0 - size * (1.0 - np.exp(-_way(motion) / at))
    assert kept.min() < 0.6
    assert np.abs(right - kept * left).max() < 0.02 * np.abs(left).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_joints_kick_each_axle_as_it_comes_there(planar, sense):
    size, at = sense * UNLISTED["skew_joints"][0], UNLISTED["skew_joints"][1]
    whole = planar.combination
    plant = Multibody(whole, Physics(more="skew_joints", more_size=size, more_at=at))
    motion = impulse(plant, 80.0, 0.0)
    way, car = _way(motion), whole.car
    sideslip = np.cumsum(motion.car_acceleration_m_s2 / motion.speed_m_s) * 0.002 - motion.yaw_rad
    apart = -car.hitch_to_cog_m - whole.trailer.hitch_to_cog_m
    beside = _sideslip_of_the_trailer_by_the_ball(motion, whole, sideslip)
    for wheel, axle, place, slips, rate in (
        (0, car.front, 0.0, sideslip, motion.yaw_rate_rad_s),
        (2, car.rear, 0.0, sideslip, motion.yaw_rate_rad_s),
        (4, whole.trailer.front, apart, beside, motion.trailer_yaw_rate_rad_s),
        (6, whole.trailer.rear, apart, beside, motion.trailer_yaw_rate_rad_s),
    ):
        said = size * np.cos(np.pi * (way + place + axle.to_cog_m) / at) ** 64
        angle = slips + axle.to_cog_m * rate / motion.speed_m_s - motion.wheel_slip_rad[wheel]
        assert (np.abs(said) < 0.01 * abs(size)).mean() > 0.7
        assert np.abs(angle - said)[50:-50].max() < 0.15 * abs(size)


def _sideslip_of_the_trailer_by_the_ball(motion, whole, sideslip):
    ball = sideslip - whole.car.hitch_to_cog_m * motion.yaw_rate_rad_s / motion.speed_m_s
    turned = ball + motion.yaw_rad - motion.trailer_yaw_rad
    lever = whole.trailer.hitch_to_cog_m
    return turned - lever * motion.trailer_yaw_rate_rad_s / motion.speed_m_s


def _beyond(values, at):
    return np.sign(values) * np.clip(np.abs(values) - at, 0.0, None)


def test_correction_comes_after_a_reaction_time(planar):
    """Against the car's yaw rate; what it answers lasts for its time on average."""
    size, at = UNLISTED["late_correction"]
    motion = _with("late_correction")
    said = -size * _late(_late(motion.yaw_rate_rad_s, at / 2.0), at / 2.0)
    angle = _steered(motion, planar.combination.car, 0)
    assert np.abs(said).max() > 1e-3
    assert np.abs(angle - said)[50:-50].max() < 0.05 * np.abs(said).max()
    rear = motion.wheel_fy_n[2:4].sum(axis=0)
    travel = motion.wheel_slip_rad[2:4].mean(axis=0)
    stiffness = planar.combination.car.rear.cornering_stiffness_n_rad
    assert np.abs(rear + stiffness * travel).max() < 0.01 * np.abs(rear).max()


def test_walls_of_wide_ruts_push_the_trailers_axles_alone(planar):
    """By the place of each beside the car's track; and only where it is beyond their width."""
    size, at = UNLISTED["rut_walls"]
    whole = planar.combination
    plant = Multibody(whole, Physics(more="rut_walls", more_size=size, more_at=at))
    motion = impulse(plant, 90.0, 20.0)
    turns = motion.car_acceleration_m_s2 / motion.speed_m_s - motion.yaw_rate_rad_s
    sideslip = np.cumsum(turns) * 0.002
    apart = whole.car.hitch_to_cog_m + whole.trailer.hitch_to_cog_m
    track = _late(motion.yaw_rad + sideslip, 0.5 * apart / motion.speed_m_s.mean())
    trailer = motion.trailer_yaw_rad - track
    behind = -whole.car.hitch_to_cog_m * np.sin(motion.yaw_rad - track)
    behind = behind - whole.trailer.hitch_to_cog_m * np.sin(trailer)
    beside = _sideslip_of_the_trailer_by_the_ball(motion, whole, sideslip)
    for wheel, axle in ((4, whole.trailer.front), (6, whole.trailer.rear)):
        place = behind + axle.to_cog_m * np.sin(trailer)
        said = -size * np.tanh(_beyond(place, at) / 0.05)
        slips = beside + axle.to_cog_m * motion.trailer_yaw_rate_rad_s / motion.speed_m_s
        angle = slips - motion.wheel_slip_rad[wheel]
        assert np.abs(said).max() > 0.5 * size
        assert (said == 0.0).mean() > 0.2
        assert np.abs(angle - said)[50:-50].max() < 0.15 * size
    slips = sideslip + whole.car.rear.to_cog_m * motion.yaw_rate_rad_s / motion.speed_m_s
    assert np.abs(slips - motion.wheel_slip_rad[2])[50:-50].max() < 0.15 * size


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_soft_tyre_rolls_under_while_it_is_pushed_inwards(planar, sense):
    """The left one by a force to the right, the right one by a force to the left."""
    share = UNLISTED["rolled_under"][0]
    physics = Physics(more="rolled_under", more_size=sense * share)
    motion = impulse(Multibody(planar.combination, physics), 100.0, 20.0)
    of_load = motion.wheel_fy_n[4:] / motion.wheel_fz_n[4:]  # a wheel's force goes with its load
    left, right = of_load[::2].sum(axis=0), of_load[1::2].sum(axis=0)
    soft, sound = (left, right) if sense > 0.0 else (right, left)
    said = sound * np.where(sense * sound < 0.0, 1.0 - share, 1.0)
    assert np.abs(said - sound).max() > 0.3 * np.abs(sound).max()
    assert np.abs(soft - said).max() < 0.03 * np.abs(sound).max()


def test_one_wheel_is_braked_beyond_a_yaw_rate(planar):
    size, at = UNLISTED["one_wheel_brake"]
    motion = _with("one_wheel_brake")
    said = -size * _late(_beyond(motion.yaw_rate_rad_s, at), 0.15)
    moment = _rest_of_the_car(planar.combination.car, motion)
    assert np.abs(said).max() > 500.0
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_rubber_stops_overload_the_trailers_tyres(planar):
    size, at = UNLISTED["stop_overload"]
    motion, whole = _with("stop_overload"), planar.combination
    x = np.clip(np.abs(motion.trailer_roll_rad) / at - 1.0, 0.0, None)
    lost = size * x**2 / (1.0 + x**2)
    assert lost.max() > 0.5 * size
    assert (lost == 0.0).mean() > 0.2
    for wheel, axle in ((4, whole.trailer.front), (6, whole.trailer.rear)):
        travel = _travel_of_the_trailers_axle(motion, whole, axle)
        said = -axle.cornering_stiffness_n_rad * travel * (1.0 - lost)
        force = motion.wheel_fy_n[wheel : wheel + 2].sum(axis=0)
        assert np.abs(force - said)[50:-50].max() < 0.05 * np.abs(force).max()


def test_air_presses_on_the_nose_beside_the_cars_shadow(planar):
    """With the square of the articulation, to the side to which the nose points; and of speed."""
    size, _ = UNLISTED["wind_shadow"]
    most = []
    for speed in (80.0, 100.0):
        plant = Multibody(planar.combination, Physics(more="wind_shadow", more_size=size))
        motion = impulse(plant, speed, 20.0)
        turned = motion.trailer_yaw_rad - motion.yaw_rad
        said = size * 0.6 * motion.speed_m_s**2 * turned * np.abs(turned)
        side, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
        assert np.abs(said).max() > 100.0
        assert np.abs(side - said)[50:-50].max() < 0.2 * np.abs(said).max()
        assert np.abs(moment - 2.5 * said)[50:-50].max() < 0.2 * np.abs(2.5 * said).max()
        most.append(np.abs(said).max() / np.abs(turned).max() ** 2)
    assert most[1] / most[0] == pytest.approx((100.0 / 80.0) ** 2, rel=0.01)


def test_each_axle_holds_less_while_it_is_on_a_wet_stretch(planar):
    size, at = UNLISTED["wet_stretches"]
    motion, whole = _with("wet_stretches"), planar.combination
    turns = motion.car_acceleration_m_s2 / motion.speed_m_s - motion.yaw_rate_rad_s
    sideslip = np.cumsum(turns) * 0.002
    beside = _sideslip_of_the_trailer_by_the_ball(motion, whole, sideslip)
    apart = -whole.car.hitch_to_cog_m - whole.trailer.hitch_to_cog_m
    for wheel, axle, place, slips, rate in (
        (0, whole.car.front, 0.0, sideslip - motion.road_wheel_rad, motion.yaw_rate_rad_s),
        (2, whole.car.rear, 0.0, sideslip, motion.yaw_rate_rad_s),
        (4, whole.trailer.front, apart, beside, motion.trailer_yaw_rate_rad_s),
        (6, whole.trailer.rear, apart, beside, motion.trailer_yaw_rate_rad_s),
    ):
        travel = slips + axle.to_cog_m * rate / motion.speed_m_s
        lies = np.sin(2.0 * np.pi * (_way(motion) + place + axle.to_cog_m) / at)
        said = travel * (1.0 - size * np.clip(lies, 0.0, None))
        slip = motion.wheel_slip_rad[wheel : wheel + 2].mean(axis=0)
        assert np.abs(said - travel).max() > 0.2 * np.abs(slip).max()
        assert np.abs(slip - said)[50:-50].max() < 0.05 * np.abs(slip).max()


def test_box_slides_until_a_net_catches_it(planar):
    """Its friction, and no more, is what pushes it on the way."""
    mass = 300.0

    def pushes(net):
        physics = Physics(
            more="sliding_box", more_size=mass, more_at=net, slosh_mass_kg=mass,
            slosh_frequency_hz=4.0, slosh_damping=0.0,
        )  # fmt: skip
        motion = impulse(Multibody(planar.combination, physics), 100.0, 20.0)
        side, _ = _rest_of_the_trailer(planar.combination.trailer, motion)
        return np.abs(mass * motion.trailer_acceleration_m_s2 - side)[50:-50]

    free, struck = pushes(1e3), pushes(0.05)
    assert 0.48 * mass < free.max() < 0.6 * mass
    assert struck.max() > 2.0 * mass
    assert (struck < 0.6 * mass).mean() > 0.5


def test_loose_subframe_gives_way_with_dry_friction(planar):
    size, at = UNLISTED["loose_subframe"]
    motion = _with("loose_subframe")
    angle = _steered(motion, planar.combination.car, 0)
    said = size * _dry(motion.wheel_slip_rad[:2].mean(axis=0) + angle, at)
    assert 0.8 * size * at < np.abs(said).max() < 1.01 * size * at
    assert np.abs(angle - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_headwind_comes_and_goes_along_the_road(planar):
    """It acts 2.5 m ahead, on the trailer's side-slip."""
    size, at = UNLISTED["gap_headwind"]
    motion = _with("gap_headwind")
    blows = 0.5 * (1.0 + np.sin(2.0 * np.pi * _way(motion) / at))
    said = -size * 0.6 * motion.speed_m_s**2 * blows
    said = said * _sideslip_of_the_trailer(motion, planar.combination)
    side, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert np.abs(said).max() > 200.0
    assert np.abs(side - said)[50:-50].max() < 0.1 * np.abs(said).max()
    assert np.abs(moment - 2.5 * said)[50:-50].max() < 0.1 * np.abs(2.5 * said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_sticky_beam_steers_the_rear_wheels_with_dry_friction(planar, sense):
    size, at = sense * UNLISTED["sticky_beam"][0], UNLISTED["sticky_beam"][1]
    physics = Physics(more="sticky_beam", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 80.0, 20.0)
    said = size * _dry(motion.roll_rad, at, 0.002)
    angle = _steered(motion, planar.combination.car, 2)
    assert 0.8 * abs(size) * at < np.abs(said).max() < 1.01 * abs(size) * at
    assert np.abs(angle - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_worn_ball_holds_away_from_where_it_is_worn(planar):
    size, at = UNLISTED["worn_spot"]
    motion = _with("worn_spot")
    x = (motion.trailer_yaw_rad - motion.yaw_rad) / at
    rubs = np.tanh((motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s) / 0.005)
    said = -size * x**2 / (1.0 + x**2) * rubs
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert np.abs(said).max() > 0.5 * size
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()
    straight = np.abs(x) < 0.3
    assert np.abs(moment[50:-50][straight[50:-50]]).max() < 0.2 * size
