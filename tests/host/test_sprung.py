"""The sprung plant: against MuJoCo over random vehicles, and against balances of its own."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA
from test_double_track import VEHICLE
from test_plant import BODY, plant

from swaywatch.diagnose.fit.data import body_of
from swaywatch.errors import ScenarioError
from swaywatch.models.double_track import Trace
from swaywatch.models.modes import critical_speed, critical_speeds, modes
from swaywatch.models.single_track import SingleTrack
from swaywatch.plant.lanes import BODY as NAMES
from swaywatch.plant.lanes import GRAVITY, OUTPUT, SCALARS, PlantInput, neutral, simulate
from swaywatch.plant.sprung import BELIEFS, defaults, put, tolerances
from swaywatch.simulate.run import simulate_plant
from swaywatch.simulate.scenario import read_scenario

# where the words of the plant for a generated combination are
sys.path.insert(0, str(Path(__file__).parents[1] / "proof" / "blind"))

RELAXED = {"relaxation_car_front": 0.4, "relaxation_car_rear": 0.5, "relaxation_trailer": 0.6}
SATURATED = {"peak_friction_inverse": 1.0, "degression": 0.2}


@pytest.mark.parametrize("seed", range(12))
def test_random_vehicles_move_as_the_judge_says(seed: int) -> None:
    """MuJoCo with moving bodies shares no code; without the coupling the plant is far off."""
    pytest.importorskip("mujoco")
    from sprung_pairs import both, differences, drawn, manoeuvre

    from swaywatch.models.multibody_vehicle import Physics

    physics, slots = [
        (Physics(full=True), {}),
        (
            Physics(full=True, tyre_law="magic_formula", shape=1.35, load_degression=0.2),
            SATURATED,
        ),
        (Physics(full=True, relaxation_m=(0.4, 0.5, 0.6, 0.6)), RELAXED),
    ][seed % 3]
    drive = manoeuvre("impulse" if seed % 2 else "slalom", 6.0, 8.0)
    off = differences(*both(drawn(seed), physics, slots, drive, 24.0))
    assert max(value for name, value in off.items() if "vertical" not in name) < 0.03
    assert max(off.values()) < 0.09
    rigid = slots | {"sprung_mass_car": 0.0, "sprung_mass_trailer": 0.0}
    far = differences(*both(drawn(seed), physics, rigid, drive, 24.0))
    assert far["trailer_yaw_rate"] > 3.0 * off["trailer_yaw_rate"]


@pytest.mark.parametrize("seed", range(3))
def test_drag_pulls_the_trailer_straight_and_loads_the_rear(seed: int) -> None:
    """Air drag is a pull at the ball and moves load to the rear axle; the drive steers."""
    pytest.importorskip("mujoco")
    from sprung_pairs import both, differences, drawn, manoeuvre

    from swaywatch.models.multibody_vehicle import Physics, static_loads

    whole = drawn(seed)
    slots = {
        "drag_area_car": 0.7, "drag_area_trailer": 2.0, "front_drive": 1.0,
        "pitch_transfer": 1.0,
        "wind_height_car": whole.car.cog_height_m,
        "wind_height_trailer": whole.trailer.cog_height_m,
    }  # fmt: skip
    physics = Physics(full=True, drag_area_m2=(0.7, 2.0))
    drive = manoeuvre("impulse", 6.0, 8.0)
    motion, found = both(whole, physics, slots, drive, 26.0)
    off = differences(motion, found)
    still = differences(*both(whole, physics, {}, drive, 26.0))
    for name in ("trailer_yaw_rate", "hitch_y", "car_yaw_rate"):
        assert off[name] < 0.05
        assert still[name] > 3.0 * off[name]
    for axle, first in (("f", 0), ("r", 2)):
        judge = np.mean(motion.wheel_fz_n[first : first + 2].sum(axis=0)[-300:])
        ours = np.mean((found[f"vertical_{axle}l"] + found[f"vertical_{axle}r"])[-300:])
        moved = judge - static_loads(whole)[first // 2]
        assert abs(moved) > 50.0
        assert ours - static_loads(whole)[first // 2] == pytest.approx(moved, rel=0.15)


def test_hard_rebound_and_leaning_struts_bounce_a_rolling_car() -> None:
    """Dampers harder in rebound, and side forces of a leaning body, load an axle at twice f.

    Each axle bounces for itself here, while MuJoCo's body pitches too: half of the variance.
    """
    pytest.importorskip("mujoco")
    from as_plant import bounce
    from sprung_pairs import both, drawn, harder, manoeuvre

    from swaywatch.models.multibody_vehicle import Physics

    drive = manoeuvre("slalom", 9.0, 8.0)
    rest = whole = 0.0
    for seed in range(6):
        vehicle = harder(drawn(seed), 2.5)
        motion, found = both(vehicle, Physics(full=True), bounce(vehicle), drive, 24.0)
        for axle, first in (("f", 0), ("r", 2)):
            judge = motion.wheel_fz_n[first : first + 2].sum(axis=0)
            ours = found[f"vertical_{axle}l"] + found[f"vertical_{axle}r"]
            whole, rest = whole + np.var(judge), rest + np.var(judge - ours)
    assert rest < 0.5 * whole


@pytest.mark.parametrize(("axle", "first"), [("car_front", 0), ("car_rear", 2)])
def test_an_extra_load_lifts_and_rolls_the_body_over_it(axle: str, first: int) -> None:
    """Wheel loads and roll change as they do in MuJoCo, where the load is a force of the strut.

    Each axle bounces for itself here, while MuJoCo's body pitches too: half of the variance.
    """
    pytest.importorskip("mujoco")
    from as_plant import bounce
    from sprung_pairs import both, drawn, harder, manoeuvre

    from swaywatch.models.multibody_vehicle import HarmonicLoad, Physics

    drive = manoeuvre("slalom", 9.0, 8.0)
    amplitude = 400.0 * np.clip(drive[0] - 2.0, 0.0, 1.0)
    rest = dict.fromkeys(("load", "shift", "roll"), 0.0)
    whole = dict(rest)
    for seed in range(4):
        vehicle = harder(drawn(seed), 1.5)
        changes = []
        for physics in (Physics(full=True), Physics(full=True, axle_load=HarmonicLoad(axle))):
            motion, found = both(vehicle, physics, bounce(vehicle), drive, 24.0, amplitude)
            left, right = (found[f"vertical_{axle[4]}{side}"] for side in "lr")
            judge = motion.wheel_fz_n[first : first + 2]
            changes.append(
                {
                    "load": (judge.sum(axis=0), left + right),
                    "shift": (judge[1] - judge[0], right - left),
                    "roll": (motion.roll_rad, found["car_roll"]),
                }
            )
        for name in rest:
            judge, ours = (changes[1][name][k] - changes[0][name][k] for k in (0, 1))
            whole[name] += float(np.var(judge))
            rest[name] += float(np.var(judge - ours))
    assert all(rest[name] < 0.5 * whole[name] for name in rest)


def alone(body: np.ndarray) -> np.ndarray:
    """The same car without its trailer."""
    return np.where([name.startswith("trailer") for name in NAMES], 0.0, body)


def drive(body: np.ndarray, steer: np.ndarray, **slots: float) -> dict[str, np.ndarray]:
    """Outputs at 20 m/s."""
    scalars = put(neutral(), slots)
    n = steer.size
    found = simulate(PlantInput(0.01, np.full(n, 20.0), np.zeros(n), steer, body, scalars))
    return {name: found[:, index] for index, name in enumerate(OUTPUT)}


def turn(size: float, n: int = 1500) -> np.ndarray:
    return np.asarray(size * np.minimum(np.arange(n) / 200.0, 1.0))


def test_a_car_alone_turns_in_balance() -> None:
    """Steady cornering: yaw gain of the single track; load transfer about the road."""
    body = alone(BODY)
    values = defaults(body)
    found = drive(body, turn(0.01), **values)
    end = {name: column[-1] for name, column in found.items()}
    front, rear, cf, cr = body[2], body[3], body[5], body[6]
    base, mass = front + rear, body[0]
    understeer = mass / base * (rear / cf - front / cr)
    assert end["car_yaw_rate"] == pytest.approx(0.01 * 20.0 / (base + understeer * 400.0), rel=2e-3)
    assert end["articulation"] == 0.0
    roll, ay = end["car_roll"], 20.0 * end["car_yaw_rate"]
    lever = values["sprung_mass_car"] * values["sprung_height_car"]
    net = values["roll_stiffness_car"] - lever * GRAVITY
    assert roll == pytest.approx(lever * ay / net, rel=1e-4)
    assert np.degrees(roll) == pytest.approx(5.5 * ay / GRAVITY, rel=1e-3)
    carried = 0.5 * (end["vertical_fr"] - end["vertical_fl"]) * values["track_car_front"]
    carried += 0.5 * (end["vertical_rr"] - end["vertical_rl"]) * values["track_car_rear"]
    high = lever + values["sprung_mass_car"] * values["roll_axis_height_car"]
    low = (mass - values["sprung_mass_car"]) * values["wheel_radius"]
    assert carried == pytest.approx((high + low) * ay + lever * GRAVITY * roll, rel=2e-3)
    share = values["sensed_roll_car"] * GRAVITY * np.sin(roll)
    assert end["car_acceleration"] == pytest.approx(ay + share, rel=1e-4)


def test_an_axle_that_is_not_there_carries_nothing() -> None:
    """Single-axle trailer: all load transfer on the one axle, finite, moments in balance."""
    body = BODY.copy()
    body[[9, 12, 16]] = 0.0
    body[17] = 13000.0
    found = drive(body, turn(0.01), **defaults(body))
    for name in ("trailer_vertical_fl", "trailer_vertical_fr", "lateral_tf"):
        assert not found[name].any()
    shift = found["trailer_vertical_rr"][-1] - found["trailer_vertical_rl"][-1]
    assert found["trailer_vertical_rr"][-1] + found["trailer_vertical_rl"][-1] == pytest.approx(
        13000.0
    )
    assert shift > 500.0
    assert np.isfinite(np.array(list(found.values()))).all()


def test_a_single_axle_of_a_file_carries_the_load() -> None:
    """Without axle loads in the file, nothing goes on the axle that is not there."""
    trailer = replace(
        VEHICLE.trailer, front_axle_to_cog=None, front_cornering_stiffness=None,
        front_axle_load=None, rear_axle_load=None, rear_axle_to_cog=0.2,
    )  # fmt: skip
    body = dict(zip(NAMES, body_of(replace(VEHICLE, trailer=trailer)), strict=True))
    assert body["trailer.front_axle_load"] == body["trailer.front_cornering_stiffness"] == 0.0
    share = trailer.hitch_to_cog / (trailer.hitch_to_cog + 0.2)
    assert body["trailer.rear_axle_load"] == pytest.approx(trailer.mass * GRAVITY * share)


def test_the_trail_turns_the_axle_back_and_vanishes() -> None:
    """Yaw balance of the car with an aligning moment: t F for small slip, less when it slides."""
    body = alone(BODY)
    trail = {f"trail_{axle}": 0.03 for axle in ("car_front", "car_rear", "trailer")}
    shares = []
    for size in (0.002, 0.1):
        found = drive(body, turn(size), **defaults(body), **trail, peak_friction_inverse=1.0)
        front = (found["lateral_fl"] + found["lateral_fr"]) * np.cos(turn(size))
        rear = found["lateral_rl"] + found["lateral_rr"]
        moment = body[1] * found["car_yaw_acceleration"] - body[2] * front + body[3] * rear
        shares.append(moment[-1] / (front + rear)[-1])
    assert shares[0] == pytest.approx(-0.03, rel=0.05)
    assert -0.6 * 0.03 < shares[1] < 0.0


def test_rigid_settings_leave_no_trace_of_the_springs() -> None:
    """Without sprung mass none of the other values has any effect, bit by bit."""
    values = defaults(BODY) | {"sprung_mass_car": 0.0, "sprung_mass_trailer": 0.0}
    values |= {"sensed_roll_car": 0.0, "sensed_roll_trailer": 0.0}
    with_values, without = plant(400, 2), plant(400, 2)
    put(with_values.scalars, values)
    np.testing.assert_array_equal(simulate(with_values), simulate(without))


def test_beliefs_are_complete_and_follow_the_vehicle() -> None:
    values = defaults(BODY)
    spread = tolerances(values)
    assert set(values) == set(spread) <= set(SCALARS)
    assert all(belief.unit and belief.words and belief.source for belief in BELIEFS)
    assert all(value > 0.0 for value in values.values())
    heavy = BODY.copy()
    heavy[0] *= 1.5
    assert defaults(heavy)["roll_stiffness_car"] == pytest.approx(
        1.5 * values["roll_stiffness_car"]
    )
    stiff = defaults(BODY, {"roll_stiffness_car": 2.0 * values["roll_stiffness_car"]})
    assert stiff["roll_damping_rate_car"] > values["roll_damping_rate_car"]
    with pytest.raises(ValueError, match="'roll_stifness_car' is no value"):
        defaults(BODY, {"roll_stifness_car": 1.0})


def still(body: np.ndarray, **slots: float) -> PlantInput:
    """A plant for its eigenvalues."""
    none = np.zeros(1)
    return PlantInput(0.01, none, none, none, body, put(neutral(), slots))


def test_eigenvalues_of_the_rigid_plant_are_the_single_track() -> None:
    track = SingleTrack.of(VEHICLE)
    body = body_of(VEHICLE)
    assert 3.6 * critical_speed(still(body)) == pytest.approx(123.3397, abs=1e-3)
    for speed in (22.0, 30.0, 38.0):
        expected = [mode.eigenvalue for mode in track.modes(speed)]
        found = [mode.eigenvalue for mode in modes(still(body), speed)]
        for value in expected:
            assert min(abs(value - other) for other in found) < 1e-5 * abs(value)
    softer = still(body, steering_flexibility=1.0 / 1.4e6)
    assert critical_speeds([still(body), softer])[0] != critical_speed(softer)


def test_a_car_alone_that_understeers_has_no_critical_speed() -> None:
    assert critical_speed(still(alone(body_of(VEHICLE)), **defaults(BODY))) == np.inf


@pytest.mark.parametrize("seed", range(4))
def test_damping_and_frequency_are_those_of_the_judge(seed: int) -> None:
    pytest.importorskip("mujoco")
    from as_plant import constants, springs
    from sprung_pairs import drawn
    from test_multibody import damping_and_frequency, impulse

    from swaywatch.models.multibody import Multibody
    from swaywatch.models.multibody_vehicle import Physics

    whole = drawn(seed)
    plant = still(constants(whole), **springs(whole))
    speed = 0.85 * critical_speed(plant)
    motion = impulse(Multibody(whole, Physics(full=True)), 3.6 * speed, 0.5)
    mode = modes(plant, speed)[0]
    damping, frequency = damping_and_frequency(motion)
    assert mode.damping_ratio == pytest.approx(damping, abs=0.002)
    assert mode.frequency_hz == pytest.approx(frequency, rel=0.005)
    rigid = modes(still(constants(whole)), speed)[0]
    assert abs(rigid.damping_ratio - damping) > 0.01


def simulated(**more: object) -> Trace:
    """An impulse at 90 km/h with bodies on springs, as `swaywatch simulate` runs it."""
    content = {
        "vehicle": "vehicle.toml", "duration_s": 12.0, "speed_kmh": 90.0, "sprung": {},
        "manoeuvre": [{"kind": "impulse", "angle_deg": 15.0}], **more,
    }  # fmt: skip
    folder = DATA / "practice" / "p01"
    return simulate_plant(read_scenario(content, "test", folder, "test.toml"))


def test_a_scenario_on_springs_oscillates_as_its_eigenvalues_say() -> None:
    trace = simulated()
    body = body_of(VEHICLE)
    values = defaults(body) | {"sensed_roll_car": 0.0, "sensed_roll_trailer": 0.0}
    mode = modes(still(body, **values), 25.0)[0]
    damping, frequency = free_mode_of(trace)
    assert damping == pytest.approx(mode.damping_ratio, rel=0.02)
    assert frequency == pytest.approx(mode.frequency_hz, rel=0.005)
    rigid = modes(still(body), 25.0)[0].damping_ratio
    assert abs(rigid - damping) > 0.05 * damping


def free_mode_of(trace: Trace) -> tuple[float, float]:
    """Damping ratio and frequency after the impulse, once the roll has died away."""
    inside = (trace.time_s > 4.0) & (trace.time_s < 11.0)
    x = trace["trailer_yaw_rate"][inside]
    rows = np.column_stack([x[1:-1], x[:-2]])
    a, b = np.linalg.lstsq(rows, x[2:], rcond=None)[0]
    root = np.log(np.roots([1.0, -a, -b]).astype(complex)[0]) * 200.0
    return float(-root.real / abs(root)), float(abs(root.imag) / (2.0 * np.pi))


def test_a_free_speed_keeps_both_bodies_in_balance_on_springs() -> None:
    """Newton along and across the car from the outputs, with the sprung mass's part."""
    trace = simulated(speed_control=True)
    body = dict(zip(NAMES, body_of(VEHICLE), strict=True))
    values = defaults(body_of(VEHICLE))
    delta = trace["road_wheel_angle"]
    along = trace["drive_force"] - trace.axle_force("car_front") * np.sin(delta)
    along -= 0.5 * 1.2 * 0.7 * trace["speed"] ** 2
    along -= 0.012 * (trace.axle_load("car_front") + trace.axle_load("car_rear"))
    along += trace["hitch_longitudinal_force"]
    error = along - body["car.mass"] * trace["car_acceleration_x"]
    assert np.abs(error).max() < 1e-6 * np.abs(trace["drive_force"]).max()
    across = trace.axle_force("car_front") * np.cos(delta) + trace.axle_force("car_rear")
    across += trace["hitch_lateral_force"] - body["car.mass"] * trace["car_acceleration_y"]
    lever = values["sprung_mass_car"] * values["sprung_height_car"]
    spin = np.gradient(trace["car_roll_rate"], trace.time_s)
    part = lever * spin  # by differences, a little off where the steering has corners
    assert np.std(across + part) < 0.02 * np.std(part)
    assert np.std(part) > 0.03 * np.std(trace["hitch_lateral_force"])
    assert np.abs(np.gradient(trace["speed"], trace.time_s)).max() > 1e-4


def test_a_value_of_no_spring_is_refused() -> None:
    with pytest.raises(ScenarioError, match="'roll_stifness_car' is no value of the sprung plant"):
        simulated(sprung={"roll_stifness_car": 9e4})


def test_weak_dampers_of_a_body_on_springs_let_it_roll_longer() -> None:
    rolls = []
    for factor in (1.0, 0.1):
        physics = [{"id": "damper_fade", "axle": "car", "factor": factor}]
        trace = simulated(physics=physics, manoeuvre=[{"kind": "gust", "body": "car"}])
        rolls.append(np.std(trace["car_roll_rate"][trace.time_s > 3.0]))
    assert rolls[1] > 1.2 * rolls[0]
