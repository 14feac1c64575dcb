"""The rigid-body plant on MuJoCo: linear limit, loads, dampers, tyres, repeatability."""

import hashlib
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from scipy.optimize import least_squares

pytest.importorskip("mujoco")

from multibody_sizes import CARGO, UNLISTED

from swaywatch.models import multibody_kernel, multibody_more, multibody_newer
from swaywatch.models.multibody import Motion, Multibody
from swaywatch.models.multibody_kernel import damper_force, tyre_force
from swaywatch.models.multibody_tables import W_SIZE
from swaywatch.models.multibody_vehicle import (
    DAMPER_KINDS,
    MORE,
    Body,
    Combination,
    Damper,
    HarmonicLoad,
    Inputs,
    Physics,
    reference_combination,
    static_loads,
)

# Speed in km/h, damping ratio and damped frequency in Hz of the corrected single-track model.
GOLDEN = (
    (80.0, 0.2520, 0.6478),
    (100.0, 0.1115, 0.6659),
    (107.9, 0.0689, 0.6690),
    (117.3, 0.0250, 0.6712),
    (140.0, -0.0587, 0.6729),
)


def impulse(plant: Multibody, speed_kmh: float, size_deg: float, until: float = 10.0) -> Motion:
    time = np.arange(0.0, until, 0.01)
    wheel = np.where((time > 0.5) & (time < 1.24), np.sin(np.pi * (time - 0.5) / 0.74), 0.0)
    return plant.run(
        Inputs(time, np.radians(size_deg) * wheel, np.full_like(time, speed_kmh / 3.6))
    )


def damping_and_frequency(motion: Motion) -> tuple[float, float]:
    """Of the free oscillation after the impulse, by least squares."""
    after = motion.time_s > 3.0
    t, y = motion.time_s[after] - 3.0, motion.trailer_yaw_rate_rad_s[after]
    y = y / np.abs(y).max()

    def residual(p):
        return np.exp(-p[0] * t) * (p[2] * np.cos(p[1] * t) + p[3] * np.sin(p[1] * t)) - y

    p = least_squares(residual, [0.3, 4.2, y[0], 0.0]).x
    return p[0] / np.hypot(p[0], p[1]), p[1] / (2 * np.pi)


@pytest.fixture(scope="module")
def planar() -> Multibody:
    return Multibody(reference_combination())


@pytest.mark.parametrize(("speed", "damping", "frequency"), GOLDEN)
def test_linear_limit_is_the_single_track_model(planar, speed, damping, frequency):
    found = damping_and_frequency(impulse(planar, speed, 1.0))
    assert found[0] == pytest.approx(damping, rel=0.01)
    assert found[1] == pytest.approx(frequency, rel=0.01)


def stiff(combination: Combination) -> Combination:
    """Suspensions and tyres so stiff, centres of gravity so low, that nothing rolls."""

    def axle(old):
        return replace(
            old,
            spring_n_m=3e6,
            roll_bar_n_m=0.0,
            tyre_vertical_stiffness_n_m=6e6,
            damper=Damper("linear", 20e3),
        )

    def body(old: Body) -> Body:
        return replace(old, front=axle(old.front), rear=axle(old.rear), cog_height_m=0.33)

    return replace(combination, car=body(combination.car), trailer=body(combination.trailer))


def test_moving_bodies_that_are_stiff_reach_the_same_limit():
    motion = impulse(Multibody(stiff(reference_combination()), Physics(full=True)), 107.9, 1.0)
    damping, frequency = damping_and_frequency(motion)
    assert damping == pytest.approx(0.0689, rel=0.01)
    assert frequency == pytest.approx(0.6690, rel=0.01)


def test_loads_at_rest_and_weight_in_motion():
    whole = reference_combination()
    loads = static_loads(whole)
    assert loads[:2] == pytest.approx((9674.0, 10204.0), abs=1.0)
    assert sum(loads) == pytest.approx(9.81 * (1955.0 + 1880.0), rel=1e-9)
    motion = impulse(Multibody(whole, Physics(full=True)), 90.0, 10.0)
    assert motion.hitch_z_n[0] == pytest.approx(-700.0, abs=0.5)
    assert motion.wheel_fz_n[:, 0] == pytest.approx(np.repeat(loads, 2) / 2, abs=0.1)
    # Nothing but the road carries the combination, so the mean load is the weight.
    assert motion.wheel_fz_n.sum(axis=0).mean() == pytest.approx(sum(loads), rel=1e-3)


def test_momentum_of_the_car_balances(planar):
    """Tyre and hitch forces of the run explain the car's lateral and yaw motion."""
    motion = impulse(planar, 100.0, 15.0)
    front = motion.wheel_fy_n[:2].sum(axis=0) * np.cos(motion.road_wheel_rad)
    rear = motion.wheel_fy_n[2:4].sum(axis=0)
    force = front + rear + motion.hitch_y_n
    inertia = 1955.0 * motion.car_acceleration_m_s2
    assert np.abs(force - inertia).max() < 0.01 * np.abs(inertia).max()
    moment = 1.302 * front - 1.383 * rear - 2.166 * motion.hitch_y_n
    yaw = 2690.0 * np.gradient(motion.yaw_rate_rad_s, motion.time_s)
    assert np.abs(moment - yaw).max() < 0.015 * np.abs(yaw).max()


def dampers(combination: Combination, kind: str, **values: float) -> Combination:
    def body(old: Body) -> Body:
        damper = Damper(kind, 3000.0, **values)
        return replace(
            old, front=replace(old.front, damper=damper), rear=replace(old.rear, damper=damper)
        )

    return replace(combination, car=body(combination.car), trailer=body(combination.trailer))


def second_harmonic(motion: Motion, wheels: slice, frequency_hz: float) -> float:
    """Amplitude at twice `frequency_hz` of the load of an axle over whole periods, N."""
    count = 8
    t = motion.time_s - motion.time_s[-1] + count / frequency_hz
    load = motion.wheel_fz_n[wheels].sum(axis=0)[t >= 0.0]
    t = t[t >= 0.0]
    basis = np.stack(
        [np.cos(4 * np.pi * frequency_hz * t), np.sin(4 * np.pi * frequency_hz * t), t * 0 + 1, t]
    )
    a, *_ = np.linalg.lstsq(basis.T, load, rcond=None)
    return float(np.hypot(a[0], a[1]))


def slalom(plant: Multibody, frequency_hz: float = 0.65) -> Motion:
    time = np.arange(0.0, 20.0, 0.01)
    wheel = np.radians(6.0) * np.clip(time / 3, 0, 1) * np.sin(2 * np.pi * frequency_hz * time)
    return plant.run(Inputs(time, wheel, np.full_like(time, 25.0)))


def test_nonlinear_and_faded_dampers_make_an_axle_load_at_twice_the_frequency():
    """Table 6-1: none from linear dampers; from an asymmetric one; from failures."""
    rear = slice(2, 4)
    found = {}
    for kind in DAMPER_KINDS:
        whole = dampers(reference_combination(), kind, lost_travel_m=0.015)
        found[kind] = second_harmonic(slalom(Multibody(whole, Physics(full=True))), rear, 0.65)
    # What linear dampers leave is the tyre force along the tilted slide of the wheel.
    assert found["bilinear"] > found["linear"] + 100.0
    assert found["normal"] > found["linear"] + 100.0
    assert found["failure_1"] > found["normal"] + 40.0
    assert found["failure_2"] > found["normal"] + 40.0
    # The rear dampers fade: the axle's own second harmonic goes with them, the front axle's stays.
    whole = dampers(reference_combination(), "normal")
    faded = Physics(full=True, damper_factor=(1, 1, 0.1, 0.1, 1, 1, 1, 1))
    healthy, sick = (slalom(Multibody(whole, p)) for p in (Physics(full=True), faded))
    change = sick.wheel_fz_n[rear].sum(axis=0) - healthy.wheel_fz_n[rear].sum(axis=0)
    difference = second_harmonic(replace(sick, wheel_fz_n=np.stack([change] * 8) / 2), rear, 0.65)
    assert difference > 15.0


def test_damper_laws():
    row = np.zeros(W_SIZE)
    row[17:24] = (0.0, 1500.0, 2.0, 0.1, 0.4, 0.01, 0.05)
    assert damper_force(row, 0.3, False) == pytest.approx(450.0)
    row[17] = 1.0
    assert damper_force(row, 0.2, False) == pytest.approx(200.0)
    assert damper_force(row, -0.2, False) == pytest.approx(-400.0)
    row[17] = 2.0
    assert damper_force(row, 0.2, False) == pytest.approx(100.0 + 40.0)
    row[17] = 3.0
    assert damper_force(row, 0.05, True) == pytest.approx(0.05 * 50.0)
    assert damper_force(row, -0.05, True) == pytest.approx(-100.0)
    row[17] = 4.0
    assert damper_force(row, -0.05, True) == pytest.approx(-5.0)


def test_tyre_laws():
    for law in (0.0, 1.0, 2.0):
        assert tyre_force(law, 1.5, 5e4, 4e3, 1e-4) == pytest.approx(-5.0, rel=2e-3)
        assert tyre_force(law, 1.5, 5e4, 4e3, -1e-4) == pytest.approx(5.0, rel=2e-3)
    assert tyre_force(1.0, 1.5, 5e4, 4e3, 0.2) == pytest.approx(-4e3, rel=0.02)
    assert tyre_force(2.0, 1.5, 5e4, 4e3, 0.5) == pytest.approx(-4e3)


def test_harmonic_load_has_its_amplitude_and_frequency(planar):
    physics = Physics(axle_load=HarmonicLoad("car_rear"))
    time = np.arange(0.0, 20.0, 0.01)
    wheel = np.radians(7.0) * np.sin(2 * np.pi * 0.6 * time)
    inputs = Inputs(
        time,
        wheel,
        np.full_like(time, 25.0),
        harmonic_n=np.full_like(time, 500.0),
        harmonic_delay_s=np.full_like(time, 0.1),
    )
    motion = Multibody(reference_combination(), physics).run(inputs)
    plain = planar.run(inputs)
    load = motion.wheel_fz_n - plain.wheel_fz_n
    found = second_harmonic(replace(motion, wheel_fz_n=load), slice(2, 4), 0.6)
    assert found == pytest.approx(500.0, rel=0.05)


def test_compliance_softens_the_front_axle(planar):
    soft = Multibody(reference_combination(), Physics(steering_stiffness_n_rad=1e6))
    motion = impulse(soft, 90.0, 10.0)
    force = motion.wheel_fy_n[:2].sum(axis=0)
    twist = motion.steering_wheel_rad / 15.0 - motion.road_wheel_rad
    assert twist == pytest.approx(force / 1e6, abs=1e-6)


def test_runs_repeat_exactly_and_are_independent(planar):
    first = impulse(planar, 100.0, 10.0, until=4.0)
    impulse(planar, 60.0, 30.0, until=2.0)
    again = impulse(planar, 100.0, 10.0, until=4.0)
    np.testing.assert_array_equal(first.hitch_y_n, again.hitch_y_n)


def test_overturning_is_said():
    plant = Multibody(reference_combination(), Physics(full=True))
    with pytest.raises(FloatingPointError, match="valid range"):
        impulse(plant, 200.0, 400.0, until=30.0)


@pytest.mark.parametrize("kind", MORE)
def test_what_nobody_lists_acts_where_it_says(planar, kind):
    """On the car, the trailer or between: the other body's own balance does not show it."""
    size, at = UNLISTED[kind]
    whole, here = planar.combination, planar.combination.car.mass_kg
    physics = Physics(more=kind, more_size=size, more_at=at)
    if kind in CARGO:
        physics = replace(physics, slosh_mass_kg=size)
    plant = Multibody(whole, physics)
    motion, healthy = impulse(plant, 100.0, 20.0), impulse(planar, 100.0, 20.0)
    change = motion.trailer_yaw_rate_rad_s - healthy.trailer_yaw_rate_rad_s
    assert np.abs(change).max() > 0.002 * np.abs(healthy.trailer_yaw_rate_rad_s).max()
    inner = slice(50, -50)
    along = motion.wheel_fy_n[:4].sum(axis=0) + motion.hitch_y_n
    rest = (here * motion.car_acceleration_m_s2 - along)[inner]
    # wheels are steered by up to 1.5 deg: their forces lean by that
    leans = 0.002 * np.abs(motion.wheel_fy_n).sum(axis=0).max()
    on_the_car = kind in (
        "car_air", "roof_load", "bow_wave", "rear_rack", "roof_tent", "gap_pump", "tailgate_crate"
    )  # fmt: skip
    assert (np.abs(rest).max() > 4.0 * leans) == on_the_car
    side, moment = _rest_of_the_trailer(whole.trailer, motion)
    assert (np.abs(side[inner]).max() > 4.0 * leans) == (
        kind in CARGO
        or kind
        in (
            "tarpaulin", "heading_wind", "gap_air", "hedge_wind", "wake_shedding", "car_wake",
            "late_air", "loose_curtain", "galloping", "jockey_wheel", "leaking_load",
            "lingering_flow", "tearing_canvas", "slack_tarpaulin", "open_door", "wind_shadow",
            "gap_headwind", "bistable_wake", "passing_lorry",
        )
    )  # fmt: skip
    turns = (
        "trailer_brakes", "tandem_scrub", "jackknife_stop", "hydraulic_hitch", "trailer_hubs",
        "turning_load", "air_damping", "wedge_friction", "cam_centring", "stabiliser_windup",
        "gyro_stabiliser", "wake_shedding", "car_wake", "brake_cable", "rubber_coupling",
        "corner_steady", "late_air", "loose_curtain", "binding_brake", "glazing_pads",
        "one_way_damper", "unlocked_slew", "damper_play", "jockey_wheel", "aligning_torque",
        "binding_ball", "spring_bars", "lingering_flow", "torn_cable", "hub_drives",
        "squealing_pads", "outward_damper", "tearing_canvas", "cocked_overrun",
        "brinelled_ring", "solenoid_brakes", "servo_ball", "locker_corner", "tilted_head",
        "roll_protection", "slack_tarpaulin", "greasy_ball", "soft_verge", "open_door", "worn_pad",
        "worn_spot", "wind_shadow", "gap_headwind", "bistable_wake", "controlled_joint",
        "passing_lorry",
    )  # fmt: skip
    assert (np.abs(moment[inner]).max() > 100.0) == (kind in turns)


def _with(kind):
    """The reference combination with one kind, after a steering impulse; of the size above."""
    size, at = UNLISTED[kind]
    cargo = {"slosh_mass_kg": size, "slosh_damping": 0.0} if kind in CARGO else {}
    physics = Physics(more=kind, more_size=size, more_at=at, **cargo)
    return impulse(Multibody(reference_combination(), physics), 100.0, 20.0)


PASSIVE = (
    "stabiliser_windup", "cam_centring", "gyro_stabiliser", "one_way_damper", "glazing_pads",
    "damper_play", "squealing_pads", "outward_damper", "tilted_head",
    "greasy_ball", "worn_spot", "controlled_joint",
)  # fmt: skip


@pytest.mark.parametrize("kind", PASSIVE)
def test_passive_moments_put_no_energy_in(kind):
    motion = _with(kind)
    _, moment = _rest_of_the_trailer(reference_combination().trailer, motion)
    turns = motion.trailer_yaw_rate_rad_s
    if kind != "gyro_stabiliser":  # it acts on both bodies
        turns = turns - motion.yaw_rate_rad_s
    work = np.cumsum(moment * turns)[50:-50] * 0.002
    # the wheels' lean and the differences leave a moment of some 10 N m
    turned = np.abs(turns).sum() * 0.002
    assert work.max() < 10.0 * turned
    lost = 0.2 if kind == "cam_centring" else 0.8
    assert (work[-1] < -lost * np.ptp(work)) == (kind != "cam_centring")


def test_gyroscope_lets_a_lasting_turn_be():
    """Its moment fades within the gimbal's time although the trailer goes on turning."""
    size, at = UNLISTED["gyro_stabiliser"]
    time = np.arange(0.0, 12.0, 0.01)
    wheel = np.radians(30.0) * np.clip(time - 1.0, 0.0, 1.0)
    physics = Physics(more="gyro_stabiliser", more_size=size, more_at=at)
    plant = Multibody(reference_combination(), physics)
    motion = plant.run(Inputs(time, wheel, np.full_like(time, 15.0)))
    _, moment = _rest_of_the_trailer(reference_combination().trailer, motion)
    left = np.zeros_like(moment)
    for i in range(1, left.size):
        left[i] = left[i - 1] + 0.002 / at * (motion.trailer_yaw_rate_rad_s[i - 1] - left[i - 1])
    said = -size * (motion.trailer_yaw_rate_rad_s - left)
    assert np.abs(said).max() > 200.0
    assert np.abs(moment[-100:-50]).max() < 0.15 * np.abs(said).max()
    assert np.abs((moment - said)[50:-50]).max() < 0.15 * np.abs(said).max()


def test_crate_is_pushed_no_harder_than_its_friction():
    size, at = UNLISTED["sliding_crate"]
    motion, trailer = _with("sliding_crate"), reference_combination().trailer
    side, _ = _rest_of_the_trailer(trailer, motion)
    push = size * motion.trailer_acceleration_m_s2 - side  # what the trailer does to the crate
    assert 0.97 * size * at < np.abs(push[50:-50]).max() < 1.1 * size * at


def test_brakes_against_sway_pull_the_hitch_back(planar):
    """As strong as the acceleration beyond their threshold says, and not at all below it."""
    size, at = UNLISTED["sway_brake"]
    motion, healthy = _with("sway_brake"), impulse(planar, 100.0, 20.0)
    pull = -(motion.hitch_x_n - healthy.hitch_x_n)
    beyond = size * max(np.abs(motion.trailer_acceleration_m_s2).max() - at, 0.0)
    assert beyond > 500.0
    assert 0.2 * beyond < pull.max() < 1.1 * beyond
    still = motion.time_s < 0.5
    assert np.abs(pull[still]).max() < 1.0


def test_eddies_go_with_the_distance():
    """They sustain themselves on a straight road; their frequency is the speed over a length."""
    size, at = UNLISTED["wake_shedding"]
    plant = Multibody(
        reference_combination(), Physics(more="wake_shedding", more_size=size, more_at=at)
    )
    for speed in (18.0, 27.0):
        motion = impulse(plant, 3.6 * speed, 1.0, until=30.0)
        late = motion.time_s > 10.0
        sway = motion.trailer_acceleration_m_s2[late]
        spectrum = np.abs(np.fft.rfft(sway * np.hanning(sway.size), 1 << 16))
        hz = np.argmax(spectrum) / ((1 << 16) * 0.002)
        assert hz == pytest.approx(speed / at, rel=0.05)
        assert np.abs(sway[-2000:]).max() > 0.8 * np.abs(sway[:2000]).max()


def test_brake_cable_drags_to_one_side_only(planar):
    """Half of the time nothing, then as strong as the articulation says; from the right wheels."""
    size, _ = UNLISTED["brake_cable"]
    motion, trailer = _with("brake_cable"), planar.combination.trailer
    angle = motion.trailer_yaw_rad - motion.yaw_rad
    drag = size * np.clip(angle, 0.0, None)
    _, moment = _rest_of_the_trailer(trailer, motion)
    assert drag.max() > 300.0
    inner = slice(50, -50)
    assert np.abs(moment + 0.5 * trailer.front.track_m * drag)[inner].max() < 0.1 * drag.max()


def test_corner_steady_drags_where_the_trailer_leans_on_it(planar):
    size, at = UNLISTED["corner_steady"]
    motion = _with("corner_steady")
    drag = size * np.clip(motion.trailer_roll_rad - at, 0.0, None)
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert drag.max() > 500.0
    assert (drag == 0.0).mean() > 0.3
    assert np.abs(moment + 0.9 * drag)[50:-50].max() < 0.1 * drag.max()


def _changed(planar, size_deg=20.0, **settings):
    """Change of the trailer's yaw rate by physics."""
    plant = Multibody(planar.combination, Physics(**settings))
    motion, healthy = impulse(plant, 100.0, size_deg), impulse(planar, 100.0, size_deg)
    return motion.trailer_yaw_rate_rad_s - healthy.trailer_yaw_rate_rad_s


def test_air_that_follows_at_once_is_the_librarys(planar):
    """Air acts 1 m ahead: as a side force and a moment of the same coefficient on 5 m2."""
    late = _changed(planar, more="late_air", more_size=30.0, more_at=0.2)
    at_once = _changed(planar, side_force_coefficient=6.0, yaw_moment_coefficient=6.0)
    assert np.abs(late - at_once).max() < 0.05 * np.abs(at_once).max()


def test_stiffer_drawbar_moves_less(planar):
    """What it changes goes with its compliance; a stiff one is none."""
    soft, stiff = (
        _changed(planar, more="elastic_drawbar", more_size=size) for size in (1e6, 4e6)
    )  # fmt: skip
    assert np.abs(stiff).max() > 1e-4
    assert np.abs(soft - 4.0 * stiff).max() < 0.1 * np.abs(soft).max()


def test_sway_assist_waits_for_a_swing(planar):
    size, at = UNLISTED["sway_assist"]
    small, large = (
        _changed(planar, size_deg, more="sway_assist", more_size=size, more_at=at)
        for size_deg in (1.0, 20.0)
    )
    assert np.abs(small).max() < 1e-9
    assert np.abs(large).max() > 1e-3


def test_frozen_tanks_are_a_load(planar):
    """Liquid that hardly moves: the inertia of the combination without it and its own are one."""
    mass, away = 200.0, 1.2
    trailer = planar.combination.trailer
    rest = replace(trailer, yaw_inertia_kgm2=trailer.yaw_inertia_kgm2 - mass * away**2)
    frozen = Physics(
        more="two_tanks", more_size=mass, more_frequency_hz=12.0, slosh_mass_kg=mass,
        slosh_frequency_hz=12.0, slosh_position_m=away, slosh_damping=0.3,
    )  # fmt: skip
    whole = replace(planar.combination, trailer=rest)
    motion, healthy = impulse(Multibody(whole, frozen), 100.0, 20.0), impulse(planar, 100.0, 20.0)
    light = impulse(Multibody(whole), 100.0, 20.0)
    off, without = (
        np.abs(m.trailer_yaw_rate_rad_s - healthy.trailer_yaw_rate_rad_s).max()
        for m in (motion, light)
    )
    assert off < 0.2 * without


def _way(motion):
    """What the car has covered, m."""
    return np.cumsum(motion.speed_m_s) * 0.002


def test_puncture_takes_the_left_tyres_force_along_the_road(planar):
    size, at = UNLISTED["puncture"]
    motion = _with("puncture")
    of_load = motion.wheel_fy_n[4:] / motion.wheel_fz_n[4:]  # a wheel's force goes with its load
    left, right = of_load[::2].sum(axis=0), of_load[1::2].sum(axis=0)
    kept = 1.0 - size * (1.0 - np.exp(-_way(motion) / at))
    assert kept.min() < 0.6
    assert np.abs(left - kept * right).max() < 0.02 * np.abs(right).max()


def test_binding_brake_drags_more_and_more(planar):
    size, at = UNLISTED["binding_brake"]
    motion, healthy = _with("binding_brake"), impulse(planar, 100.0, 20.0)
    drag = size * (1.0 - np.exp(-_way(motion) / at))
    pull = -(motion.hitch_x_n - healthy.hitch_x_n)
    calm = (motion.time_s < 0.5) | (motion.time_s > 7.0)
    calm[:50] = calm[-50:] = False
    assert np.abs(pull - drag)[calm].max() < 0.1 * size
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    half = 0.5 * planar.combination.trailer.front.track_m
    assert np.abs(moment + half * drag)[50:-50].max() < 0.1 * size


def test_pads_glaze_as_they_rub(planar):
    """Their friction goes with what they have rubbed, and so is the less the later."""
    size, at = UNLISTED["glazing_pads"]
    motion = _with("glazing_pads")
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    rate = motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s
    rubbed = np.cumsum(np.abs(rate)) * 0.002
    said = -size * np.tanh(rate / 0.005) / (1.0 + rubbed / at)
    assert rubbed[-1] > at
    assert np.abs(said).max() > 0.7 * size
    assert np.abs(moment - said)[50:-50].max() < 0.1 * size


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_one_way_damper_resists_one_way_only(planar, sense):
    size = sense * UNLISTED["one_way_damper"][0]
    plant = Multibody(planar.combination, Physics(more="one_way_damper", more_size=size))
    motion = impulse(plant, 100.0, 20.0)
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    rate = motion.trailer_yaw_rate_rad_s - motion.yaw_rate_rad_s
    said = -size * np.clip(sense * rate, 0.0, None)
    assert np.abs(said).max() > 300.0
    assert (said == 0.0).mean() > 0.3
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_unlocked_slew_takes_along_no_more_than_its_friction(planar):
    _, at = UNLISTED["unlocked_slew"]
    trailer = planar.combination.trailer
    _, moment = _rest_of_the_trailer(trailer, _with("unlocked_slew"))
    leans = np.abs(_rest_of_the_trailer(trailer, impulse(planar, 100.0, 20.0))[1])[50:-50].max()
    assert 0.9 * at < np.abs(moment[50:-50]).max() < at + 2.0 * leans
    rest = replace(trailer, yaw_inertia_kgm2=trailer.yaw_inertia_kgm2 - 600.0)
    held = Physics(more="unlocked_slew", more_size=600.0, more_at=6000.0)
    motion = impulse(Multibody(replace(planar.combination, trailer=rest), held), 100.0, 20.0)
    change = motion.trailer_yaw_rate_rad_s - impulse(planar, 100.0, 20.0).trailer_yaw_rate_rad_s
    assert np.abs(change).max() < 0.01 * np.abs(motion.trailer_yaw_rate_rad_s).max()


@pytest.mark.parametrize("speed", [18.0, 27.0])
def test_wandering_ruts_lead_each_axle_where_it_is(planar, speed):
    """The slip of an axle is what its place's motion makes of it, less the angle of the ruts."""
    _, at = UNLISTED["wandering_ruts"]
    size = 1e-4
    physics = Physics(more="wandering_ruts", more_size=size, more_at=at)
    motion = impulse(Multibody(planar.combination, physics), 3.6 * speed, 0.0, until=40.0)
    late, omega = motion.time_s > 24.0, 2.0 * np.pi * speed / at
    window = np.hanning(late.sum()) * np.exp(-1j * omega * motion.time_s[late])
    window /= 0.5 * np.abs(window).sum()
    car, trailer = planar.combination.car, planar.combination.trailer

    def part(values):
        """Of a signal, what swings at the speed over the length."""
        return complex((values[late] * window).sum())

    def ruts(ahead):
        return -1j * size * np.exp(2j * np.pi * ahead / at)

    turns = part(motion.yaw_rate_rad_s)
    sideslip = part(motion.car_acceleration_m_s2) / (1j * omega * speed) - part(motion.yaw_rad)
    for wheel, axle in ((0, car.front), (2, car.rear)):
        travel = sideslip + axle.to_cog_m * turns / speed
        led = travel - part(motion.wheel_slip_rad[wheel])
        assert abs(led - ruts(axle.to_cog_m)) < 0.03 * size
    apart = trailer.front.to_cog_m - trailer.rear.to_cog_m
    travel = apart * part(motion.trailer_yaw_rate_rad_s) / speed
    led = travel - part(motion.wheel_slip_rad[4]) + part(motion.wheel_slip_rad[6])
    first = trailer.front.to_cog_m - car.hitch_to_cog_m - trailer.hitch_to_cog_m
    assert abs(led - ruts(first) + ruts(first - apart)) < 0.03 * size


def test_yaw_reference_brakes_beyond_what_the_steering_asks(planar):
    size, at = UNLISTED["yaw_reference"]
    motion, car = _with("yaw_reference"), planar.combination.car
    v = motion.speed_m_s
    asked = v * motion.road_wheel_rad / (2.7 * (1.0 + (v / 28.0) ** 2))
    off = motion.yaw_rate_rad_s - asked
    said = -size * np.sign(off) * np.clip(np.abs(off) - at, 0.0, None)
    known = car.front.to_cog_m * motion.wheel_fy_n[:2].sum(axis=0)
    known = known + car.rear.to_cog_m * motion.wheel_fy_n[2:4].sum(axis=0)
    known = known - car.hitch_to_cog_m * motion.hitch_y_n
    moment = car.yaw_inertia_kgm2 * np.gradient(motion.yaw_rate_rad_s, 0.002) - known
    assert np.abs(said).max() > 300.0
    assert (said == 0.0).mean() > 0.3
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_horse_that_does_not_step_is_a_load_on_a_spring(planar):
    mass, _ = UNLISTED["stepping_horse"]
    stands, steps, load = (
        impulse(Multibody(planar.combination, physics), 100.0, 20.0).trailer_yaw_rate_rad_s
        for physics in (
            Physics(more="stepping_horse", more_size=mass, more_at=1e6, slosh_mass_kg=mass),
            Physics(more="stepping_horse", more_size=mass, more_at=0.5, slosh_mass_kg=mass),
            Physics(slosh_mass_kg=mass),
        )
    )
    assert np.abs(stands - load).max() < 1e-5
    assert np.abs(steps - load).max() > 0.05 * np.abs(load).max()


def test_hydro_bush_yields_to_a_force_that_lasts(planar):
    """The first of a turn is as of stiffer tyres, the rest as of the healthy ones."""
    size, at = UNLISTED["hydro_bush"]
    time = np.arange(0.0, 12.0, 0.01)
    wheel = np.radians(10.0) * np.clip((time - 1.0) / 0.05, 0.0, 1.0)
    inputs = Inputs(time, wheel, np.full_like(time, 15.0))
    plant = Multibody(planar.combination, Physics(more="hydro_bush", more_size=size, more_at=at))
    force, healthy = (p.run(inputs).wheel_fy_n[:2].sum(axis=0) for p in (plant, planar))
    begins, ends = round(1.06 / 0.002), -100
    stiffer = force[begins] / healthy[begins] - 1.0
    assert 0.6 * size < stiffer < 1.1 * size
    assert abs(force[ends] / healthy[ends] - 1.0) < 0.01


def test_loose_curtain_fills_from_one_side(planar):
    motion = _with("loose_curtain")
    side, _ = _rest_of_the_trailer(planar.combination.trailer, motion)
    side = side[50:-50]
    assert side.min() < -200.0
    assert side.max() < 0.1 * -side.min()
    assert (side > 0.1 * side.min()).mean() > 0.3


def test_damper_in_worn_eyes_does_nothing_within_their_play(planar):
    """Outside it resists as the damper does whose strut is stiff."""
    size, at = UNLISTED["damper_play"]
    motion = _with("damper_play")
    angle, rod = motion.trailer_yaw_rad - motion.yaw_rad, 0.0
    said = np.zeros_like(angle)
    for i, turned in enumerate(angle):
        pressed = turned - rod
        said[i] = -1e5 * np.sign(pressed) * max(abs(pressed) - at, 0.0)
        rod -= 0.002 * said[i] / size
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    assert np.abs(said).max() > 200.0
    assert (said == 0.0)[motion.time_s > 0.5].mean() > 0.2
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()
    small = _changed(planar, 1.0, more="damper_play", more_size=size, more_at=at)
    assert np.abs(small).max() < 1e-9


def test_tow_bar_twists_the_rear_axle_with_the_pull_at_the_ball(planar):
    """Its wheels' slip is that of their place, less the angle of the force 30 ms before."""
    size, _ = UNLISTED["towbar_twist"]
    motion = _with("towbar_twist")
    angle = _steered(motion, planar.combination.car, 2)
    pull = np.interp(motion.time_s - 0.03, motion.time_s, -motion.hitch_y_n)
    inner = slice(100, -100)
    assert np.abs(size * pull).max() > 5e-4
    assert np.abs(angle - size * pull)[inner].max() < 0.1 * size * np.abs(pull).max()


def test_sharp_edges_drive_a_small_sideslip_and_resist_a_larger_one(planar):
    size, at = UNLISTED["galloping"]
    motion = _with("galloping")
    side, _ = _rest_of_the_trailer(planar.combination.trailer, motion)
    part = (_sideslip_of_the_trailer(motion, planar.combination) / at) ** 2
    drives = side * np.sign(_sideslip_of_the_trailer(motion, planar.combination))
    pressure = 0.6 * motion.speed_m_s**2
    said = size * pressure * at * np.sqrt(part) * (1.0 - part) / (1.0 + part)
    assert said.max() > 50.0
    assert said.min() < -200.0
    assert np.abs(drives - said)[50:-50].max() < 0.1 * np.abs(said).max()


def _without_rack(whole, mass_kg):
    """The car less a mass above its ball: as `_without_rack` of the concealed cases, from sums."""
    car = whole.car
    rest = car.mass_kg - mass_kg
    ahead = mass_kg * car.hitch_to_cog_m / rest
    inertia = car.yaw_inertia_kgm2 - mass_kg * car.hitch_to_cog_m**2 - rest * ahead**2
    lighter = replace(
        car, mass_kg=rest, yaw_inertia_kgm2=inertia, hitch_to_cog_m=car.hitch_to_cog_m + ahead,
        front=replace(car.front, to_cog_m=car.front.to_cog_m - ahead),
        rear=replace(car.rear, to_cog_m=car.rear.to_cog_m - ahead),
    )  # fmt: skip
    return replace(whole, car=lighter)


def test_rack_that_is_held_is_a_part_of_the_car(planar):
    """With friction that never slips the whole is the combination that its user knows."""
    mass = UNLISTED["rear_rack"][0]
    whole = _without_rack(planar.combination, mass)
    held = Physics(more="rear_rack", more_size=mass, more_at=8.0, more_frequency_hz=12.0)
    loose = replace(held, more_at=0.05, more_frequency_hz=1.2)
    healthy = impulse(planar, 100.0, 20.0).yaw_rate_rad_s
    off, swings, without = (
        np.abs(impulse(Multibody(whole, physics), 100.0, 20.0).yaw_rate_rad_s - healthy).max()
        for physics in (held, loose, Physics())
    )
    assert off < 0.1 * without
    assert swings > 0.5 * without


def test_actuator_follows_the_yaw_rate_no_faster_than_it_can(planar):
    size, at = UNLISTED["slow_actuator"]
    motion = _with("slow_actuator")
    travel = _sideslip_of_the_trailer(motion, planar.combination)
    place = planar.combination.trailer.front.to_cog_m
    travel = travel + place * motion.trailer_yaw_rate_rad_s / motion.speed_m_s
    angle = travel - motion.wheel_slip_rad[4]
    rate = np.gradient(angle, 0.002)[50:-50]
    assert 0.9 * size * at < np.abs(rate).max() < 1.1 * size * at
    assert (np.abs(rate) > 0.9 * size * at).mean() > 0.05
    small = impulse(
        Multibody(planar.combination, Physics(more="slow_actuator", more_size=size, more_at=at)),
        100.0, 1.0,
    )  # fmt: skip
    fast = impulse(
        Multibody(planar.combination, Physics(more="slow_actuator", more_size=size, more_at=1e3)),
        100.0, 1.0,
    )  # fmt: skip
    assert np.abs(small.trailer_yaw_rate_rad_s - fast.trailer_yaw_rate_rad_s).max() < 1e-9


def test_sideslip_limiter_turns_the_car_to_where_it_goes(planar):
    size, at = UNLISTED["sideslip_limiter"]
    motion, car = _with("sideslip_limiter"), planar.combination.car
    sideslip = motion.wheel_slip_rad[2] - car.rear.to_cog_m * motion.yaw_rate_rad_s / (
        motion.speed_m_s
    )
    said = size * np.sign(sideslip) * np.clip(np.abs(sideslip) - at, 0.0, None)
    known = car.front.to_cog_m * motion.wheel_fy_n[:2].sum(axis=0)
    known = known + car.rear.to_cog_m * motion.wheel_fy_n[2:4].sum(axis=0)
    known = known - car.hitch_to_cog_m * motion.hitch_y_n
    moment = car.yaw_inertia_kgm2 * np.gradient(motion.yaw_rate_rad_s, 0.002) - known
    assert np.abs(said).max() > 300.0
    assert (said == 0.0).mean() > 0.3
    assert np.abs(moment - said)[50:-50].max() < 0.1 * np.abs(said).max()


def test_jockey_wheel_scrubs_at_the_nose(planar):
    """No harder than it can; its moment is its force at its place."""
    size, at = UNLISTED["jockey_wheel"]
    motion, trailer = _with("jockey_wheel"), planar.combination.trailer
    side, moment = _rest_of_the_trailer(trailer, motion)
    ahead = trailer.hitch_to_cog_m - 0.6
    slip = _sideslip_of_the_trailer(motion, planar.combination)
    slip = slip + ahead * motion.trailer_yaw_rate_rad_s / motion.speed_m_s
    said = -size * np.tanh(slip / at)
    assert 0.3 * size < np.abs(said).max() < size
    assert np.abs(side - said)[50:-50].max() < 0.15 * np.abs(said).max()
    assert np.abs(moment - ahead * said)[50:-50].max() < 0.1 * ahead * np.abs(said).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_counter_steer_goes_as_far_as_it_may(planar, sense):
    size, at = sense * UNLISTED["counter_steer"][0], UNLISTED["counter_steer"][1]
    plant = Multibody(planar.combination, Physics(more="counter_steer", more_size=size, more_at=at))
    motion = impulse(plant, 100.0, 20.0)
    angle = _steered(motion, planar.combination.car, 0)
    said = size * at * np.tanh(motion.trailer_yaw_rate_rad_s / at)
    assert 0.6 * abs(size) * at < np.abs(said).max()
    assert np.abs(angle - said)[50:-50].max() < 0.03 * abs(size) * at


def test_slabs_take_and_give_grip_along_the_road(planar):
    size, at = UNLISTED["concrete_slabs"]
    motion, trailer = _with("concrete_slabs"), planar.combination.trailer
    force = motion.wheel_fy_n[4:6].sum(axis=0)
    travel = _sideslip_of_the_trailer(motion, planar.combination)
    travel = travel + trailer.front.to_cog_m * motion.trailer_yaw_rate_rad_s / motion.speed_m_s
    grip = 1.0 - size * np.sin(2.0 * np.pi * _way(motion) / at)
    said = -trailer.front.cornering_stiffness_n_rad * travel * grip
    even = -trailer.front.cornering_stiffness_n_rad * travel
    assert np.abs(force - said)[50:-50].max() < 0.03 * np.abs(force).max()
    assert np.abs(force - even)[50:-50].max() > 0.15 * np.abs(force).max()


def test_trailer_that_has_lost_its_load_is_a_lighter_one(planar):
    """Of less mass, which is what its swing and its hitch force show in the end."""
    size, _ = UNLISTED["leaking_load"]
    trailer = planar.combination.trailer
    lighter = replace(trailer, mass_kg=trailer.mass_kg * (1.0 - size))
    light = replace(planar.combination, trailer=lighter)
    lost = _changed(planar, more="leaking_load", more_size=size, more_at=1e-1)
    lighter = impulse(Multibody(light), 100.0, 20.0).trailer_yaw_rate_rad_s
    lighter = lighter - impulse(planar, 100.0, 20.0).trailer_yaw_rate_rad_s
    assert np.abs(lost - lighter).max() < 0.2 * np.abs(lighter).max()
    later = _changed(planar, more="leaking_load", more_size=size, more_at=1e6)
    assert np.abs(later).max() < 0.01 * np.abs(lighter).max()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_worn_shoulders_hold_better_one_way(planar, sense):
    size, axle = sense * UNLISTED["worn_shoulders"][0], planar.combination.car.rear
    plant = Multibody(planar.combination, Physics(more="worn_shoulders", more_size=size))
    motion = impulse(plant, 100.0, 20.0)
    angle = _steered(motion, planar.combination.car, 2)
    travel = motion.wheel_slip_rad[2] + angle
    for way in (travel > 0.003, travel < -0.003):
        stiffness = -motion.wheel_fy_n[2:4].sum(axis=0)[way] / travel[way]
        expected = axle.cornering_stiffness_n_rad * (1.0 - size * np.sign(travel[way]))
        assert way.sum() > 100
        assert stiffness == pytest.approx(expected, rel=0.02)


def test_aligning_torque_fades_as_the_tread_slides(planar):
    size, at = UNLISTED["aligning_torque"]
    motion = _with("aligning_torque")
    _, moment = _rest_of_the_trailer(planar.combination.trailer, motion)
    slip = motion.wheel_slip_rad[4:].mean(axis=0)
    said = size * slip / (1.0 + (slip / at) ** 2)
    assert np.abs(slip).max() > 1.3 * at
    assert np.abs(said).max() == pytest.approx(0.5 * size * at, rel=0.01)
    assert np.abs(moment - said)[50:-50].max() < 0.15 * np.abs(said).max()


def _steered(motion, car, wheel):
    """Angle of the car's axle with this wheel beside the driver's, from how both axles slip."""
    axles, other = {0: car.front, 2: car.rear}, 2 - wheel
    slip = {i: motion.wheel_slip_rad[i : i + 2].mean(axis=0) for i in (0, 2)}
    slip[0] = slip[0] + motion.road_wheel_rad
    apart = axles[wheel].to_cog_m - axles[other].to_cog_m
    return slip[other] + apart * motion.yaw_rate_rad_s / motion.speed_m_s - slip[wheel]


def _sideslip_of_the_trailer(motion, whole):
    """At its COG, from the motion of the ball, rad."""
    v, car = motion.speed_m_s, whole.car
    across = v * motion.wheel_slip_rad[2:4].mean(axis=0)
    across = across - (car.hitch_to_cog_m + car.rear.to_cog_m) * motion.yaw_rate_rad_s
    angle = motion.trailer_yaw_rad - motion.yaw_rad
    along = v * np.cos(angle) + across * np.sin(angle)
    across = across * np.cos(angle) - v * np.sin(angle)
    return (across - whole.trailer.hitch_to_cog_m * motion.trailer_yaw_rate_rad_s) / along


def _rest_of_the_trailer(trailer, motion):
    """Side force and moment about its COG beside those of its wheels and the hitch force."""
    angle = motion.trailer_yaw_rad - motion.yaw_rad
    across = -(motion.hitch_y_n * np.cos(angle) - motion.hitch_x_n * np.sin(angle))
    front, rear = motion.wheel_fy_n[4:6].sum(axis=0), motion.wheel_fy_n[6:].sum(axis=0)
    known = trailer.hitch_to_cog_m * across
    known = known + trailer.front.to_cog_m * front + trailer.rear.to_cog_m * rear
    inertia = trailer.yaw_inertia_kgm2 * np.gradient(motion.trailer_yaw_rate_rad_s, 0.002)
    side = trailer.mass_kg * motion.trailer_acceleration_m_s2 - front - rear - across
    return side, inertia - known


@pytest.mark.parametrize("compiled", [multibody_newer, multibody_more, multibody_kernel])
def test_compiled_code_is_made_anew_where_what_it_is_made_of_has_changed(
    compiled: ModuleType,
) -> None:
    """Numba looks at the file of a function only; so that file says which others it is made of."""
    folder = Path(compiled.__file__ or "").parent
    found = {
        name: hashlib.sha1((folder / f"{name}.py").read_bytes()).hexdigest()[:12]
        for name in compiled.MADE_OF
    }
    assert found == compiled.MADE_OF, f"write MADE_OF = {found} in {compiled.__name__}"
