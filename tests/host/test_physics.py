"""Every physics module: its parameters, and that it does what its equation says."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from test_double_track import TIME, VEHICLE, free_mode, impulse

from swaywatch.models.double_track import DoubleTrack, Trace
from swaywatch.models.physics import MODULES, PhysicsEffect
from swaywatch.models.single_track import SingleTrack
from swaywatch.plant.vehicle_view import GRAVITY

# The words of the recordings' list that are physics, not sensors and not parameters.
WORDS = frozenset((
    "steering_compliance", "steering_free_play", "axle_load_harmonic", "tyre_relaxation",
    "tyre_saturation", "tyre_load_sensitivity", "tyre_stiffness_change", "hitch_friction",
    "hitch_damping", "trailer_aerodynamics", "roll_steer", "crosswind_gust", "road_bank",
    "friction_reduction", "damper_fade", "damper_asymmetry", "roll_stiffness_change",
    "drawbar_compliance",
))  # fmt: skip
SLALOM = np.radians(12.0) * np.sin(2.0 * np.pi * 0.5 * TIME) * np.clip(TIME / 4.0, 0.0, 1.0)


def run(*effects: PhysicsEffect, steering: np.ndarray = SLALOM, speed: float = 25.0) -> Trace:
    return DoubleTrack(VEHICLE, effects).run(TIME, steering, speed)


def line(signal: np.ndarray, frequency: float, start: float = 14.0, stop: float = 30.0) -> complex:
    """Complex amplitude at a frequency over whole periods; cosine phase at time zero."""
    inside = (start <= TIME) & (stop > TIME)
    turn = np.exp(-2j * np.pi * frequency * TIME[inside])
    centred = signal[inside] - signal[inside].mean()
    return complex(2.0 * np.mean(centred * turn))


def test_every_word_of_the_list_is_a_module() -> None:
    assert set(MODULES) >= WORDS


@pytest.mark.parametrize("effect_id", MODULES)
def test_modules_are_complete_and_consistent(effect_id: str) -> None:
    module = MODULES[effect_id]
    assert module.id == effect_id
    assert all((module.title, module.equation, module.source, module.enters))
    for parameter in module.parameters:
        assert parameter.low <= parameter.start <= parameter.high
        assert parameter.unit


@pytest.mark.parametrize("effect_id", MODULES)
def test_every_module_at_its_start_values_changes_the_motion(effect_id: str) -> None:
    effects = [PhysicsEffect(effect_id)]
    if effect_id == "roll_stiffness_change":  # it acts through what depends on roll
        effects.append(PhysicsEffect("roll_steer"))
        base = run(PhysicsEffect("roll_steer"))
    else:
        base = run()
    changed = run(*effects)
    loads = [name for name in base if "vertical_load" in name] + ["car_yaw_rate"]
    assert changed.whole
    assert max(np.abs(changed[n] - base[n]).max() / np.ptp(base[n]) for n in loads) > 1e-4


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"effect_id": "hitch_glue"}, r"did you mean 'hitch_load'\? Known: .*hitch_friction"),
        ({"effect_id": "hitch_friction", "moment_nm": -1.0}, "outside 0 to 3000 N m"),
        ({"effect_id": "hitch_friction", "torque": 1.0}, "no parameter 'torque'"),
        ({"effect_id": "tyre_relaxation", "axle": "middle"}, "it can be: car_rear"),
        ({"effect_id": "hitch_friction", "windows": [{}]}, "no time windows"),
        ({"effect_id": "road_bank", "windows": [{"start_s": 3.0, "stop_s": 2.0}]}, "no length"),
        ({"effect_id": "road_bank", "windows": [{"slope": 3.0}]}, "no window value"),
    ],
)
def test_bad_effects_are_refused(arguments: dict[str, object], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        PhysicsEffect(**arguments)  # type: ignore[arg-type]


def test_compliance_is_a_softer_front_axle() -> None:
    """Eq. 5.7: 1/C_eff = 1/C_tyre + 1/K_s, seen from the single track."""
    stiffness = 1.437e6
    trace = run(
        PhysicsEffect("steering_compliance", stiffness_n_per_rad=stiffness),
        steering=impulse(0.05), speed=30.0,
    )  # fmt: skip
    front = VEHICLE.car.front_cornering_stiffness
    assert front is not None
    soft = dataclasses.replace(SingleTrack.of(VEHICLE), cf1=1.0 / (1.0 / front + 1.0 / stiffness))
    assert free_mode(trace)[0] == pytest.approx(soft.modes(30.0)[0].damping_ratio, rel=0.01)


@pytest.mark.parametrize("law", ["backlash", "dead_zone"])
def test_free_play_swallows_half_the_gap_each_way(law: str) -> None:
    trace = run(PhysicsEffect("steering_free_play", gap_deg=4.0, law=law))
    lost = np.degrees(np.abs(SLALOM).max() - np.abs(trace["road_wheel_angle"]).max() * 15.0)
    assert lost == pytest.approx(2.0, abs=1e-6)


@pytest.mark.parametrize("law", ["backlash", "dead_zone", "castor"])
def test_small_steering_inside_the_free_play_does_nothing(law: str) -> None:
    trace = run(PhysicsEffect("steering_free_play", gap_deg=4.0, law=law), steering=SLALOM / 30.0)
    assert np.abs(trace["car_yaw_rate"]).max() == 0.0


def test_castoring_wheels_carry_no_force_inside_the_gap() -> None:
    trace = run(
        PhysicsEffect("steering_free_play", gap_deg=4.0, law="castor"), steering=SLALOM / 3.0
    )
    offset = np.abs(trace["road_wheel_angle"] * 15.0 - SLALOM / 3.0)
    inside = offset < np.radians(2.0) - 1e-9
    assert inside.any()
    assert not inside.all()
    slip = 0.5 * (trace["wheel_slip_fl"] + trace["wheel_slip_fr"])
    assert np.abs(slip[inside]).max() < 1e-12


def test_relaxation_delays_the_force_by_length_over_speed() -> None:
    trace = run(PhysicsEffect("tyre_relaxation", axle="car_rear", length_m=0.5))
    slip = line(trace["wheel_slip_rl"], 0.5) + line(trace["wheel_slip_rr"], 0.5)
    force = line(trace.axle_force("car_rear"), 0.5)
    expected = 1.0 / (1.0 + 1j * 2.0 * np.pi * 0.5 * 0.5 / 25.0)
    rear = VEHICLE.car.rear_cornering_stiffness
    assert rear is not None
    assert force / slip / (0.5 * rear) == pytest.approx(expected, rel=2e-3)


def test_saturation_keeps_the_slope_and_the_peak() -> None:
    slippery = PhysicsEffect("tyre_saturation", peak_friction=0.4)
    trace = run(slippery, steering=impulse(150.0), speed=15.0)
    friction = trace["wheel_lateral_force_fl"] / trace["wheel_vertical_load_fl"]
    assert 0.39 < np.abs(friction).max() <= 0.4
    small = run(PhysicsEffect("tyre_saturation"), steering=impulse(0.05), speed=30.0)
    expected = SingleTrack.of(VEHICLE).modes(30.0)[0].damping_ratio
    assert free_mode(small)[0] == pytest.approx(expected, rel=0.01)


def test_degression_softens_the_axle_with_load_transfer_only() -> None:
    degression = 0.3
    trace = run(PhysicsEffect("tyre_load_sensitivity", degression=degression))
    left, right = trace["wheel_vertical_load_rl"], trace["wheel_vertical_load_rr"]
    share = (right - left) / (right + left)
    slip = 0.5 * (trace["wheel_slip_rl"] + trace["wheel_slip_rr"])
    rear = VEHICLE.car.rear_cornering_stiffness
    assert rear is not None
    expected = rear * slip * (1.0 - degression * share**2)
    error = trace.axle_force("car_rear") - expected
    assert np.abs(error).max() < 1e-3 * np.abs(expected).max()


def test_stiffness_change_acts_in_its_window_only() -> None:
    windows = [{"start_s": 10.0, "stop_s": 15.0, "factor": 0.8}]
    trace = run(PhysicsEffect("tyre_stiffness_change", axle="trailer", windows=windows))
    slip = trace["trailer_wheel_slip_fl"] + trace["trailer_wheel_slip_fr"]
    force = trace.axle_force("trailer_front")
    inside = (TIME > 10.1) & (TIME < 14.9) & (np.abs(slip) > 1e-3)
    outside = (TIME > 15.1) & (np.abs(slip) > 1e-3)
    assert VEHICLE.trailer is not None
    stiffness = VEHICLE.trailer.front_cornering_stiffness
    assert stiffness is not None
    assert np.median(2.0 * force[inside] / slip[inside]) == pytest.approx(0.8 * stiffness, rel=1e-3)
    assert np.median(2.0 * force[outside] / slip[outside]) == pytest.approx(stiffness, rel=1e-3)


@pytest.mark.parametrize("effect", ["hitch_damping", "hitch_friction"])
def test_hitch_moment_opposes_the_rate_and_damps(effect: str) -> None:
    value = {"coefficient_nms_per_rad": 500.0} if effect == "hitch_damping" else {"moment_nm": 60.0}
    trace = run(PhysicsEffect(effect, **value), steering=impulse(10.0), speed=33.0)
    rate = trace["trailer_yaw_rate"] - trace["car_yaw_rate"]
    assert np.all(trace["hitch_moment"] * rate >= 0.0)
    plain = run(steering=impulse(10.0), speed=33.0)
    assert np.ptp(trace["trailer_yaw_rate"][-500:]) < np.ptp(plain["trailer_yaw_rate"][-500:])


def test_aerodynamics_lower_the_damping_a_little() -> None:
    """Zhang 2015, 5.2.6: air costs about 3 km/h of critical speed."""
    trace = run(PhysicsEffect("trailer_aerodynamics"), steering=impulse(0.05), speed=33.0)
    assert trace.whole
    beta = trace["trailer_sideslip"]
    balance = (
        trace.axle_force("trailer_front") + trace.axle_force("trailer_rear")
        + np.sin(trace["articulation"]) * trace["hitch_longitudinal_force"]
        - np.cos(trace["articulation"]) * trace["hitch_lateral_force"]
        - 1880.0 * trace["trailer_acceleration_y"]
    )  # fmt: skip
    assert balance == pytest.approx(1.5 * 0.5 * 1.2 * 5.0 * 33.0**2 * beta, abs=0.05)


def test_roll_steer_turns_the_wheels_with_the_roll() -> None:
    plain, steered = run(), run(PhysicsEffect("roll_steer", axle="car_rear", coefficient=0.1))
    rear = VEHICLE.car.rear_cornering_stiffness
    assert rear is not None
    slip = steered.axle_force("car_rear") / rear
    body = -np.arctan2(
        steered["car_lateral_velocity"] - 1.383 * steered["car_yaw_rate"], steered["speed"]
    )
    assert np.abs(slip - body - 0.1 * steered["car_roll"]).max() < 2e-5
    assert np.abs(plain["car_roll"]).max() > math.radians(0.5)


def test_gust_pushes_inside_its_window() -> None:
    windows = [{"start_s": 5.0, "stop_s": 6.0, "force_n": 900.0}]
    trace = run(
        PhysicsEffect("crosswind_gust", body="car", windows=windows), steering=np.zeros(TIME.size)
    )
    assert np.abs(trace["car_acceleration_y"][TIME < 4.99]).max() == 0.0
    first = trace["car_acceleration_y"][np.searchsorted(TIME, 5.02)]
    assert 0.3 < first < 0.9  # part of 900 N / 1955 kg goes into the trailer


def test_banked_road_pulls_down_and_the_sensor_feels_the_slope() -> None:
    effect = PhysicsEffect("road_bank", angle_deg=2.0)
    trace = run(effect, steering=np.zeros(TIME.size))
    assert trace["car_yaw_rate"][-1] != pytest.approx(0.0, abs=1e-4)
    felt = trace.lateral_acceleration("car") - trace["car_acceleration_y"]
    assert felt == pytest.approx(GRAVITY * math.sin(math.radians(2.0)))
    assert trace["car_roll"][-1] != 0.0


@pytest.mark.parametrize("phase", [0.0, -90.0, 180.0, 60.0])
def test_harmonic_load_has_the_amplitude_and_phase_asked_for(phase: float) -> None:
    effect = PhysicsEffect(
        "axle_load_harmonic", amplitude_n=300.0, phase_deg=phase, frequency_hz=0.5
    )
    trace = run(effect)
    load = line(trace.axle_load("car_rear"), 1.0)
    reference = line(trace.axle_force("car_rear") ** 2, 1.0)
    assert abs(load) == pytest.approx(300.0, rel=0.03)
    turn = np.degrees(np.angle(load / reference * np.exp(-1j * math.radians(phase))))
    assert abs(turn) < 6.0  # the load turns the force that its phase is measured against


@pytest.mark.parametrize(("phase", "sign"), [(0.0, 1.0), (180.0, -1.0)])
def test_harmonic_load_makes_the_effective_stiffness(phase: float, sign: float) -> None:
    """Eq. 4.14: C = zeta (F_z0 + Re F_z,2w / 2)."""
    trace = run(
        PhysicsEffect("axle_load_harmonic", amplitude_n=1000.0, phase_deg=phase, frequency_hz=0.5)
    )
    slip = 0.5 * (line(trace["wheel_slip_rl"], 0.5) + line(trace["wheel_slip_rr"], 0.5))
    stiffness = abs(line(trace.axle_force("car_rear"), 0.5) / slip)
    expected = 185.2e3 * (1.0 + sign * 0.5 * 1000.0 / 10204.0)
    assert stiffness == pytest.approx(expected, rel=0.005)


def test_generator_loads_one_wheel_by_the_sign_of_the_yaw_rate() -> None:
    """6.2: left while the yaw rate is negative, else right; mean free."""
    trace = run(PhysicsEffect("axle_load_harmonic", form="generator", gain_n_s2_per_rad2=8e4))
    plain = run()
    yaw = trace["car_yaw_rate"]
    transfer = plain["wheel_vertical_load_rr"] - plain["wheel_vertical_load_rl"]
    assert np.ptp(transfer) > 0.0
    sure = (TIME > 10.0) & (np.abs(yaw) > 0.02)
    gain, scale = 10204.0, trace["car_roll"] / 0.0089 * 0.45 * 1955.0 * 0.63 / 1.55
    left = trace["wheel_vertical_load_rl"] - 0.5 * gain + scale
    right = trace["wheel_vertical_load_rr"] - 0.5 * gain - scale
    assert np.abs(left[sure & (yaw > 0.0)]).max() < 1e-6
    assert np.abs(right[sure & (yaw < 0.0)]).max() < 1e-6
    extra = left + right
    assert abs(extra[TIME >= 14.0].mean()) < 0.05 * np.ptp(extra)


def test_damper_asymmetry_puts_a_line_at_2f_into_the_axle_load() -> None:
    amplitudes = []
    for ratio in (1.0, 2.0, 4.0):
        trace = run(PhysicsEffect("damper_asymmetry", axle="car_rear", ratio=ratio))
        amplitudes.append(abs(line(trace.axle_load("car_rear"), 1.0)))
    assert amplitudes[0] < 1e-3
    assert 10.0 < amplitudes[1] < amplitudes[2]


def test_faded_dampers_roll_longer() -> None:
    step = np.where(TIME > 1.0, np.radians(10.0), 0.0)
    healthy = run(PhysicsEffect("damper_fade", axle="car", factor=1.0), steering=step)
    faded = run(PhysicsEffect("damper_fade", axle="car", factor=0.1), steering=step)
    assert np.abs(faded["car_roll_rate"]).max() > 1.01 * np.abs(healthy["car_roll_rate"]).max()
    one_side = run(
        PhysicsEffect("damper_fade", axle="car_rear", side="left", factor=0.1), steering=step
    )
    assert np.abs(one_side.axle_load("car_rear") - 10204.0).max() > 5.0


def test_ball_load_raises_the_critical_speed() -> None:
    plain = run(steering=impulse(0.05), speed=33.0)
    loaded = run(PhysicsEffect("hitch_load", force_n=500.0), steering=impulse(0.05), speed=33.0)
    assert free_mode(loaded)[0] > free_mode(plain)[0]
