"""A car alone: made-up runs with a known concealed roll, and the real cars where they are."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA, recordings

from swaywatch.diagnose.car_alone.car import SLOTS, CarInput, simulate
from swaywatch.diagnose.car_alone.data import load_car_runs
from swaywatch.diagnose.car_alone.relations import banked, relations
from swaywatch.diagnose.engine import diagnose, write
from swaywatch.diagnose.predict import predict
from swaywatch.effects.roll import lag
from swaywatch.errors import RecordingError, SignalError
from swaywatch.plant.lanes import GRAVITY
from swaywatch.vehicle_file import load_vehicle

VEHICLE = """[car]
mass = 1500
yaw_inertia = 2300
front_axle_to_cog = 1.25
rear_axle_to_cog = 1.45
steering_ratio = 15
"""
SIGNALS = """[signals]
steering_wheel_angle = "Steer"
speed = "Speed"
car_yaw_rate = "Yaw"
car_lateral_acceleration = "Acc"
wheel_speed = ["FL", "FR", "RL", "RR"]
"""
ROLL = 0.009  # rad per m/s2
TRACK = 1.5


def _car(speed: np.ndarray, wheel: np.ndarray, **slots: float) -> dict[str, np.ndarray]:
    values = SLOTS | {
        "mass": 1500.0, "yaw_inertia": 2300.0, "front_axle_to_cog": 1.25,
        "rear_axle_to_cog": 1.45, "front_cornering_stiffness": 90e3,
        "rear_cornering_stiffness": 130e3,
    } | slots  # fmt: skip
    n = speed.size
    return simulate(
        CarInput(0.01, speed, np.gradient(speed) * 100.0, wheel / 15.0, np.zeros(n), values)
    )


def _run(path: Path, seed: int, *, sign: float = 1.0, gravity: float = ROLL) -> Path:
    """Two lane changes and a slalom, noisy, with a standstill in front."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 40.0, 0.01)
    speed = np.clip((time - 3.0) * 6.0, 0.0, 18.0 + 3.0 * seed)
    wheel = 0.5 * np.sin(2.0 * np.pi * (0.25 + 0.05 * seed) * (time - 10.0)) * (time > 10.0)
    wheel += 0.3 * np.sin(2.0 * np.pi * 0.7 * (time - 24.0)) * (time > 24.0)
    out = _car(np.maximum(speed, 1.0), wheel)
    moving = speed > 1.0
    true = np.where(moving, out["acceleration"], 0.0)
    yaw = np.where(moving, out["yaw_rate"], 0.0)
    seen = true + GRAVITY * gravity * lag(true, 10.0, 0.35)
    columns = {
        "time_s": time,
        "Steer [rad]": sign * wheel,
        "Speed [m/s]": speed,
        "Yaw [rad/s]": yaw + 0.01 + rng.normal(0.0, 3e-3, time.size),
        "Acc [m/s2]": seen - 0.2 + rng.normal(0.0, 0.05, time.size),
    }
    for name, side in (("FL", -1), ("FR", 1), ("RL", -1), ("RR", 1)):
        columns[f"{name} [m/s]"] = np.maximum(speed + side * 0.5 * TRACK * yaw, 0.0)
    columns["Steer [rad]"][2000] = 0.9
    np.savetxt(
        path, np.column_stack(list(columns.values())), delimiter=",", comments="",
        header=",".join(columns),
    )  # fmt: skip
    return path


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Path], Path, Path]:
    """Folder, two runs, vehicle, signals."""
    folder = tmp_path_factory.mktemp("solo")
    (folder / "vehicle.toml").write_text(VEHICLE)
    (folder / "signals.toml").write_text(SIGNALS)
    runs = [_run(folder / f"run{i}.csv", i) for i in (0, 1)]
    return folder, runs, folder / "vehicle.toml", folder / "signals.toml"


def test_the_steady_turn_is_that_of_the_single_track() -> None:
    n = 2000
    out = _car(np.full(n, 20.0), np.full(n, 15.0 * 1e-3))
    base, mass = 2.7, 1500.0
    understeer = mass / base * (1.45 / 90e3 - 1.25 / 130e3)
    assert out["yaw_rate"][-1] == pytest.approx(1e-3 * 20.0 / (base + understeer * 400.0), rel=1e-3)
    assert out["acceleration"][-1] == pytest.approx(20.0 * out["yaw_rate"][-1], rel=1e-6)


def test_a_concealed_roll_is_found_and_predicts(
    case: tuple[Path, list[Path], Path, Path], tmp_path: Path
) -> None:
    folder, runs, vehicle, signals = case
    result = diagnose(runs, vehicle, signals, report=tmp_path / "report.html")
    names = {e["id"]: e for e in result["effects"]}
    assert "sensor_roll_gravity" in names
    value = names["sensor_roll_gravity"]["parameters"]["roll_per_acceleration"]
    assert value["value"] == pytest.approx(ROLL, rel=0.2)
    seen = result["quantities"]["roll_that_the_accelerometer_alone_says_deg_per_m_s2"]
    assert seen["value"] == pytest.approx(np.degrees(ROLL), rel=0.1)
    # gains of 2, 2 and 1 % are 3 % of gravity
    assert 0.28 < 0.5 * (seen["high"] - seen["low"]) < 0.4
    known = result["quantities"]["roll_per_lateral_acceleration_deg_per_m_s2"]
    assert known["low"] < np.degrees(ROLL) < known["high"]
    assert known["high"] - known["low"] < 0.8 * (seen["high"] - seen["low"])
    assert names["sensor_spikes"]["parameters"]["count"]["value"] == 2
    assert names["sensor_spikes"]["windows"][0][0] == pytest.approx(20.0, abs=0.02)
    fit = names["sensor_roll_gravity"]["fit"]
    assert fit["held_out_diagnosed_nrmse"] < 0.7 * fit["held_out_baseline_nrmse"]
    assert any("fitted to the recordings" in check for check in result["checks"])
    assert "Simulation before and after" in (tmp_path / "report.html").read_text()
    write(result, tmp_path / "diagnosis.json")
    third = _run(folder / "third.csv", 2)
    scores = predict(tmp_path / "diagnosis.json", third)
    assert scores["diagnosed_nrmse"] < 0.7 * scores["baseline_nrmse"]
    assert json.loads((tmp_path / "diagnosis.json").read_text())["model"]["kind"] == "solo"


def test_relations_name_track_and_gain(case: tuple[Path, list[Path], Path, Path]) -> None:
    _, runs, vehicle, signals = case
    data = load_car_runs(runs, load_vehicle(vehicle), signals)
    found = {f.name.split(",", maxsplit=1)[0]: f for f in relations(data)}
    assert found["rear wheels' speed difference / yaw rate"].value == pytest.approx(TRACK, rel=0.02)
    turn = found["lateral acceleration / (speed x yaw rate)"].value
    # the rate of the side-slip takes some of it in quick manoeuvres; the model gives it back
    assert 1.01 < turn < 1.0 + GRAVITY * ROLL + 0.02
    assert banked(data, 1.0) == ()


def test_steering_of_the_other_sign_is_said_and_turned(tmp_path: Path) -> None:
    (tmp_path / "vehicle.toml").write_text(VEHICLE)
    (tmp_path / "signals.toml").write_text(SIGNALS)
    run = _run(tmp_path / "run.csv", 0, sign=-1.0)
    data = load_car_runs([run], load_vehicle(tmp_path / "vehicle.toml"), tmp_path / "signals.toml")
    assert any("sign = -1" in check for check in data.checks)
    steer, yaw = (
        data.runs[0].channels["steering_wheel_angle"],
        data.runs[0].channels["car_yaw_rate"],
    )
    assert np.corrcoef(steer, yaw)[0, 1] > 0.3
    other = _run(tmp_path / "other.csv", 1)
    data = load_car_runs(
        [run, other], load_vehicle(tmp_path / "vehicle.toml"), tmp_path / "signals.toml"
    )
    said = [check for check in data.checks if "sign is wrong" in check]
    assert [check.split(":")[0] for check in said] == ["run.csv"]
    for one in data.runs:
        channels = one.channels
        assert np.corrcoef(channels["steering_wheel_angle"], channels["car_yaw_rate"])[0, 1] > 0.3


def test_a_car_that_stands_is_not_judged(tmp_path: Path) -> None:
    (tmp_path / "vehicle.toml").write_text(VEHICLE)
    (tmp_path / "signals.toml").write_text(SIGNALS)
    run = _run(tmp_path / "run.csv", 0)
    rows = np.genfromtxt(run, delimiter=",", skip_header=1)
    rows[:, 2] = 0.0
    head = run.read_text().splitlines()[0]
    np.savetxt(run, rows, delimiter=",", header=head, comments="")
    result = diagnose([run], tmp_path / "vehicle.toml", tmp_path / "signals.toml")
    assert result["verdict"] == "unexplained"
    assert "cannot say: no stretch" in result["unexplained"][0]["reason"]


def test_missing_roles_are_said(case: tuple[Path, list[Path], Path, Path], tmp_path: Path) -> None:
    _, runs, vehicle, _ = case
    few = tmp_path / "few.toml"
    few.write_text("\n".join(line for line in SIGNALS.splitlines() if "Acc" not in line))
    data = load_car_runs(runs, load_vehicle(vehicle), few)
    assert any("not recorded: car_lateral_acceleration" in check for check in data.checks)
    few.write_text("\n".join(line for line in SIGNALS.splitlines() if "Steer" not in line))
    with pytest.raises(SignalError, match="no steering_wheel_angle"):
        load_car_runs(runs, load_vehicle(vehicle), few)


def test_a_simulation_of_a_car_alone_is_refused(case: tuple[Path, list[Path], Path, Path]) -> None:
    _, runs, vehicle, signals = case
    with pytest.raises(RecordingError, match="a car alone is compared with our own model only"):
        diagnose(runs, vehicle, signals, simulations=runs)


def test_dropouts_of_the_infiniti_and_its_turns() -> None:
    folder = recordings("real", "infiniti_g35")
    data = load_car_runs(
        sorted(folder.glob("run*.mf4")), load_vehicle(folder / "vehicle.toml"),
        DATA / "real" / "infiniti_g35.toml",
    )  # fmt: skip
    wild = [f for _, f in data.faults.found]
    assert {f.channels for f in wild} == {("steering_wheel_angle",)}
    assert sum(len(f.windows) for f in wild) == 3
    found = {f.name.split(",", maxsplit=1)[0]: f for f in relations(data)}
    assert 1.05 < found["lateral acceleration / (speed x yaw rate)"].value < 1.2
    # no gain of the yaw rate: the wheels say a track that the car can have
    assert 1.45 < found["front wheels' speed difference / yaw rate"].value < 1.6
    (bank,) = banked(data, 1.1)
    assert data.runs[bank[0]].name == "run_21_50_19.mf4"
    assert bank[2] == pytest.approx(20.0, abs=3.0)


def test_spikes_of_the_ferrari() -> None:
    folder = recordings("real", "ferrari_250lm")
    data = load_car_runs(
        sorted(folder.glob("run*.mf4")), load_vehicle(folder / "vehicle.toml"),
        DATA / "real" / "ferrari_250lm.toml",
    )  # fmt: skip
    ((_, finding),) = data.faults.found
    assert finding.channels == ("steering_wheel_angle",)
    times = [start for start, _ in finding.windows]
    assert np.allclose(times, [57.28, 353.50, 374.86, 521.68], atol=0.011)
