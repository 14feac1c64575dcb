"""The double track: its linear limit, its balances, and the recordings of practice."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest
from conftest import DATA, recordings
from scipy.signal import butter, sosfiltfilt

from swaywatch.drive import load_drive
from swaywatch.models.double_track import DoubleTrack, SpeedControl, Trace
from swaywatch.models.physics import MODULES, PhysicsEffect
from swaywatch.models.single_track import SingleTrack
from swaywatch.vehicle_file import load_vehicle

VEHICLE = load_vehicle(DATA / "practice" / "p01" / "vehicle.toml")
TIME = np.arange(0.0, 30.0, 0.01)


def impulse(degrees: float, time: np.ndarray = TIME) -> np.ndarray:
    """Half sine of 0.675 Hz from 1 s."""
    phase = 2.0 * np.pi * 0.675 * (time - 1.0)
    return np.where((phase > 0.0) & (phase < np.pi), np.radians(degrees) * np.sin(phase), 0.0)


def free_mode(trace: Trace, start: float = 5.0) -> tuple[float, float]:
    """Damping ratio and frequency of the free oscillation: AR(2) by least squares, noise-free."""
    signal = trace["trailer_yaw_rate"][(trace.time_s > start)]
    x = np.column_stack([signal[1:-1], signal[:-2]])
    a, b = np.linalg.lstsq(x, signal[2:], rcond=None)[0]
    root = np.log(np.roots([1.0, -a, -b]).astype(complex)[0]) / 0.01
    return -root.real / abs(root), abs(root.imag) / (2.0 * np.pi)


@pytest.mark.parametrize("speed_kmh", [80.0, 100.0, 107.9, 117.3, 123.3397, 130.0])
def test_linear_limit_is_the_single_track(speed_kmh: float) -> None:
    trace = DoubleTrack(VEHICLE).run(TIME, impulse(0.05), speed_kmh / 3.6)
    damping, frequency = free_mode(trace)
    mode = SingleTrack.of(VEHICLE).modes(speed_kmh / 3.6)[0]
    assert damping == pytest.approx(mode.damping_ratio, rel=0.01, abs=1e-4)
    assert frequency == pytest.approx(mode.frequency_hz, rel=1e-3)


def test_small_motion_matches_the_single_track_sample_by_sample() -> None:
    steering = impulse(0.5)
    trace = DoubleTrack(VEHICLE, car_acceleration_position_m=0.0).run(TIME, steering, 28.0)
    for name, expected in SingleTrack.of(VEHICLE).run(TIME, steering, 28.0).items():
        assert np.abs(trace[name] - expected).max() < 1e-4 * np.abs(expected).max(), name


def test_single_axle_trailer_and_car_alone() -> None:
    assert VEHICLE.trailer is not None
    single = dataclasses.replace(
        VEHICLE,
        trailer=dataclasses.replace(
            VEHICLE.trailer, front_axle_to_cog=None, front_axle_load=None,
            front_cornering_stiffness=None, rear_axle_to_cog=0.2, rear_axle_load=None,
            rear_cornering_stiffness=2.5e5,
        ),
    )  # fmt: skip
    for vehicle in (single, dataclasses.replace(VEHICLE, trailer=None)):
        steering = impulse(0.5)
        trace = DoubleTrack(vehicle, car_acceleration_position_m=0.0).run(TIME, steering, 25.0)
        for name, expected in SingleTrack.of(vehicle).run(TIME, steering, 25.0).items():
            assert np.abs(trace[name] - expected).max() < 1e-4 * np.abs(expected).max(), name


def test_forces_balance_in_a_violent_motion() -> None:
    """Newton and Euler for both bodies from the outputs alone, at large angles."""
    trace = DoubleTrack(
        VEHICLE, [PhysicsEffect("hitch_damping", coefficient_nms_per_rad=300.0)]
    ).run(TIME, impulse(60.0), 27.0)
    car, trailer = VEHICLE.car, VEHICLE.trailer
    assert trailer is not None
    assert np.abs(trace["articulation"]).max() > math.radians(6.0)
    hx, hy = trace["hitch_longitudinal_force"], trace["hitch_lateral_force"]
    theta = trace["articulation"]
    h2y = -np.sin(theta) * hx + np.cos(theta) * hy
    rear = [trace.axle_force(f"trailer_{end}") for end in ("front", "rear")]
    lateral = sum(rear) - h2y - trailer.mass * trace["trailer_acceleration_y"]
    assert np.abs(lateral).max() < 1e-6 * np.abs(h2y).max()
    assert trailer.front_axle_to_cog is not None
    moment = (
        trailer.front_axle_to_cog * rear[0] - trailer.rear_axle_to_cog * rear[1]
        - trailer.hitch_to_cog * h2y - trace["hitch_moment"]
        - trailer.yaw_inertia * trace["trailer_yaw_acceleration"]
    )  # fmt: skip
    assert np.abs(moment).max() < 1e-6 * np.abs(trailer.hitch_to_cog * h2y).max()
    delta = trace["road_wheel_angle"]
    front = trace.axle_force("car_front") * np.cos(delta)
    lateral = front + trace.axle_force("car_rear") + hy - car.mass * trace["car_acceleration_y"]
    assert np.abs(lateral).max() < 1e-6 * np.abs(hy).max()


def test_articulation_is_the_difference_of_headings() -> None:
    trace = DoubleTrack(VEHICLE).run(TIME, impulse(40.0), 25.0)
    difference = np.cumsum(trace["trailer_yaw_rate"] - trace["car_yaw_rate"]) * 0.01
    assert np.abs(trace["articulation"] - difference).max() < 2e-3


def test_halving_the_step_changes_nothing_that_matters() -> None:
    physics = [
        PhysicsEffect("tyre_saturation"),
        PhysicsEffect("tyre_relaxation", axle="all", length_m=0.4),
    ]
    model = DoubleTrack(VEHICLE, physics)
    coarse, fine = (model.run(TIME, impulse(20.0), 28.0, step_s=step) for step in (0.005, 0.0025))
    worst = np.abs(coarse["trailer_yaw_rate"] - fine["trailer_yaw_rate"]).max()
    assert worst < 1e-5 * np.abs(fine["trailer_yaw_rate"]).max()


def test_speed_controller_holds_the_speed_through_the_oscillation() -> None:
    steering = impulse(19.0)
    held = DoubleTrack(VEHICLE).run(TIME, steering, 28.0, speed_control=SpeedControl())
    without = SpeedControl(proportional_n_s_per_m=0.0, integral_n_per_m=0.0, feed_forward=0.0)
    dropped = DoubleTrack(VEHICLE).run(TIME, steering, 28.0, speed_control=without)
    assert np.abs(held["speed"] - 28.0).max() < 0.02
    assert dropped["speed"].min() < 27.94


def test_motion_out_of_bounds_ends_in_nan_and_says_so() -> None:
    time = np.arange(0.0, 90.0, 0.01)
    slippery = [PhysicsEffect("tyre_saturation", peak_friction=0.5)]
    trace = DoubleTrack(VEHICLE, slippery).run(time, impulse(5.0, time), 55.0)
    assert not trace.whole


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((np.array([0.0, 0.1, 0.5]), np.zeros(3), 20.0), "even spacing"),
        ((TIME, np.full(TIME.size, np.nan), 20.0), "not finite"),
        ((TIME, np.zeros(TIME.size), 0.0), "needs 0.5 m/s"),
    ],
)
def test_bad_input_is_refused(arguments: tuple[object, ...], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        DoubleTrack(VEHICLE).run(*arguments)  # type: ignore[arg-type]


# Practice recordings: the true effect must bring the simulation to the recording -----------------


def effects_of(case: str, run: str) -> list[PhysicsEffect]:
    """What truth.json names, as effects of the model; a parameter error changes the vehicle."""
    truth = json.loads((recordings("practice", case) / "truth.json").read_text())
    out = []
    for effect in truth["effects"]:
        values = {key: value for key, value in effect.items() if key != "id"}
        if effect["id"] == "axle_load_harmonic":
            windows = [
                {"start_s": a, "stop_s": b, "amplitude_n": amplitude, "delay_s": delay}
                for (a, b), amplitude, delay in zip(
                    truth[run]["windows"], effect["amplitude_n"], effect["delay"], strict=True
                )
            ]
            out.append(
                PhysicsEffect(effect["id"], axle=effect["axle"], form="normalised", windows=windows)
            )
        elif effect["id"] in MODULES:
            out.append(PhysicsEffect(effect["id"], **values))
    return out


def mismatch(case: str, run: str, effects: list[PhysicsEffect]) -> float:
    """Largest NRMSE of both yaw rates and the ball's side force, below 4 Hz, without offset."""
    folder = recordings("practice", case)
    file = next(folder.glob(f"{run}.*"))
    grid = load_drive([file], folder / "signals.toml").resample()
    vehicle = load_vehicle(folder / "vehicle.toml")
    truth = json.loads((folder / "truth.json").read_text())
    for effect in truth["effects"]:
        if effect["id"] == "parameter_error" and effects is not None:
            body, key = effect["parameter"].split(".")
            part = getattr(vehicle, body)
            changed = dataclasses.replace(part, **{key: getattr(part, key) * effect["factor"]})
            vehicle = dataclasses.replace(vehicle, **{body: changed})
    trace = DoubleTrack(vehicle, effects).run(
        grid.time_s, grid.value["steering_wheel_angle"], grid.value["speed"]
    )
    sos = butter(3, 4.0 / 50.0, output="sos")
    inner = slice(200, -100)
    worst = 0.0
    for name in ("car_yaw_rate", "trailer_yaw_rate", "hitch_lateral_force"):
        recorded = sosfiltfilt(sos, grid.value[name])[inner]
        error = recorded - sosfiltfilt(sos, trace[name])[inner]
        worst = max(worst, float(np.std(error) / np.std(recorded)))
    return worst


CASES = ["p01", "p02", "p03", "p04", "p05", "p06", "p07", "p08", "p10"]


@pytest.mark.parametrize("case", CASES)
def test_true_effect_brings_the_slalom_to_the_recording(case: str) -> None:
    """1 % is what sensor noise, offsets and quantisation leave below 4 Hz."""
    assert mismatch(case, "run2", effects_of(case, "run2")) < 0.01


@pytest.mark.parametrize("case", CASES)
def test_true_effect_brings_the_impulses_near_the_critical_speed_close(case: str) -> None:
    """Within the dissertation's 5 %, where the least disturbance rings for seconds."""
    assert mismatch(case, "run1", effects_of(case, "run1")) < 0.05


@pytest.mark.parametrize("case", ["p02", "p03", "p05", "p06", "p07"])
def test_without_the_effect_the_slalom_misses(case: str) -> None:
    assert mismatch(case, "run2", []) > 0.02


def test_stepping_is_running() -> None:
    """Sample by sample or whole: the same motion, with every kind of memory in it."""
    physics = [
        PhysicsEffect("steering_free_play", gap_deg=2.0),
        PhysicsEffect("tyre_relaxation", axle="all", length_m=0.4),
        PhysicsEffect("axle_load_harmonic", amplitude_n=500.0, phase_deg=90.0, frequency_hz=0.67),
    ]
    model = DoubleTrack(VEHICLE, physics)
    steering = impulse(19.0)
    whole = model.run(TIME, steering, 28.0)
    stepper = model.stepper(0.01, 28.0)
    yaw = [stepper.value("trailer_yaw_rate")]
    yaw += [float(stepper.advance(angle, 28.0)[3]) for angle in steering[1:]]
    assert stepper.time_s == pytest.approx(TIME[-1])
    assert np.abs(np.array(yaw) - whole["trailer_yaw_rate"]).max() < 1e-12


def test_trailer_brake_stretches_the_combination() -> None:
    """Braking the trailer damps the sway (Zhang 2015, 2.1: active caravan brake)."""
    last = []
    for force in (0.0, 4000.0):
        stepper = DoubleTrack(VEHICLE).stepper(0.01, 33.0)
        for angle in impulse(15.0)[:1500]:
            stepper.advance(angle, 33.0)
            if stepper.time_s == pytest.approx(4.0):
                stepper.brake("trailer", force)
        last.append(abs(stepper.value("hitch_longitudinal_force")))
    assert last[1] == pytest.approx(last[0] + 4000.0, abs=300.0)
