"""`swaywatch init`: roles, units and signs of recordings that nobody has described."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import DATA, recordings

from swaywatch.cli import main
from swaywatch.drive import load_signals
from swaywatch.first_files.inventory import Signal
from swaywatch.first_files.propose import ROAD_WHEEL, propose, words_of
from swaywatch.vehicle_file import load_vehicle

P03 = DATA / "practice" / "p03"


def _init(out: Path, *words: str) -> int:
    return main(["init", *words, "--out", str(out), "--no-questions"])


def _roles(path: Path) -> dict[str, tuple[tuple[str, ...], float]]:
    return {m.channel: (m.signals, np.sign(m.factor)) for m in load_signals(path)[0]}


def test_practice_roles_are_those_of_the_case(tmp_path: Path) -> None:
    assert _init(tmp_path, str(P03 / "run1.asc"), "--typical") == 0
    assert _roles(tmp_path / "signals.toml") == _roles(P03 / "signals.toml")
    assert load_vehicle(tmp_path / "vehicle.toml").trailer is not None
    code = main(
        ["analyze", str(P03 / "run1.asc"), "--vehicle", str(tmp_path / "vehicle.toml"),
         "--signals", str(tmp_path / "signals.toml"), "--out", str(tmp_path / "out"), "-q",
         "--no-report"]
    )  # fmt: skip
    assert code == 0


@pytest.mark.parametrize(
    "case", ["road/r01", "road/r17", "chrono/x01", "chrono/x05", "practice/p07"]
)
def test_roles_of_other_vehicles_are_those_of_the_case(tmp_path: Path, case: str) -> None:
    folder = recordings(*case.split("/"))
    run = next(path for path in sorted(folder.glob("run1.*")))
    assert _init(tmp_path, str(run), "--typical") == 0
    found, right = _roles(tmp_path / "signals.toml"), _roles(folder / "signals.toml")
    assert {c: found.get(c) for c in right} == right


def test_real_cars(tmp_path: Path) -> None:
    run = recordings("real", "infiniti_g35") / "run_21_50_19.mf4"
    assert _init(tmp_path / "g35", str(run), "--typical") == 0
    roles = _roles(tmp_path / "g35" / "signals.toml")
    assert roles["car_yaw_rate"] == (("YawRate",), 1.0)
    assert roles["car_lateral_acceleration"] == (("LatAcc",), 1.0)
    assert roles["speed"] == (("WheelSpeedRL", "WheelSpeedRR"), 1.0)
    # Its steering counts the other way round than its yaw rate and acceleration do.
    assert roles["steering_wheel_angle"] == (("SteeringWheelAngle",), -1.0)
    assert load_vehicle(tmp_path / "g35" / "vehicle.toml").trailer is None
    run = recordings("real", "ferrari_250lm") / "run_20140222_03.mf4"
    assert _init(tmp_path / "f", str(run), "--typical") == 0
    assert _roles(tmp_path / "f" / "signals.toml")["steering_wheel_angle"][0] == ("RoadWheelAngle",)
    assert load_vehicle(tmp_path / "f" / "vehicle.toml").car.steering_ratio == 1.0


def test_a_logger_without_steering(tmp_path: Path) -> None:
    run = next(recordings("real", "canedge").glob("*.MF4"))
    assert _init(tmp_path, str(run)) == 0
    roles = _roles(tmp_path / "signals.toml")
    assert roles["speed"][0] == ("Speed",)
    assert roles["car_yaw_rate"][0] == ("AngularRateZ",)
    assert "steering_wheel_angle" not in roles


# --- physics between channels ---------------------------------------------------------------------


def _signals(names: dict[str, tuple[str, str]], signs: dict[str, float]) -> list[Signal]:
    """A drive with bends: names and units of what is measured, signs that are wrong."""
    time = np.arange(0.0, 60.0, 0.02)
    rng = np.random.default_rng(5)
    speed = 20.0 + 2.0 * np.sin(0.1 * time)
    curvature = 0.01 * np.sin(0.7 * time) + 0.004 * np.sin(2.1 * time)
    rate = speed * curvature
    later = np.interp(time - 0.3, time, rate)
    true = {
        "speed": speed, "rate": rate, "side": speed * rate, "wheel": 15.0 * 2.8 * curvature,
        "rate2": later, "side2": speed * later,
        "angle": np.cumsum(later - rate) * 0.02,
    }  # fmt: skip
    scale = {"km/h": 3.6, "deg/s": 57.2958, "deg": 57.2958, "g": 1 / 9.80665}
    found = []
    for what, (name, unit) in names.items():
        value = true[what] * signs.get(what, 1.0) * scale.get(unit.strip("?"), 1.0)
        value = value + 0.002 * np.std(value) * rng.standard_normal(len(time))
        found.append(Signal(name, "", "" if unit.endswith("?") else unit, time, value))
    return found


NAMES = {
    "speed": ("VehSpd", "km/h"), "rate": ("GierRate", "deg/s"), "side": ("Querbeschl", "m/s2"),
    "wheel": ("Lenkradwinkel", "deg"), "rate2": ("Anhaenger_GierRate", "deg/s"),
    "side2": ("Anhaenger_Querbeschl", "m/s2"), "angle": ("Knickwinkel", "deg"),
}  # fmt: skip
CHANNEL = {
    "speed": "speed", "rate": "car_yaw_rate", "side": "car_lateral_acceleration",
    "wheel": "steering_wheel_angle", "rate2": "trailer_yaw_rate",
    "side2": "trailer_lateral_acceleration", "angle": "articulation",
}  # fmt: skip


@pytest.mark.parametrize("turned", [(), ("side",), ("wheel",), ("rate2", "side2"), ("angle",)])
def test_signs_come_from_the_motion(turned: tuple[str, ...]) -> None:
    found = propose(_signals(NAMES, dict.fromkeys(turned, -1.0)))
    for what, channel in CHANNEL.items():
        assert found[channel].signal == NAMES[what][0]
        assert found[channel].sign == (-1.0 if what in turned else 1.0), channel


@pytest.mark.parametrize(("rate", "side"), [("deg/s?", "m/s2"), ("rad/s?", "g?"), ("deg/s", "g?")])
def test_units_that_no_file_says_come_from_the_motion(rate: str, side: str) -> None:
    names = {**NAMES, "rate": ("GierRate", rate), "side": ("Querbeschl", side)}
    found = propose(_signals(names, {}))
    for channel, unit in (("car_yaw_rate", rate), ("car_lateral_acceleration", side)):
        wanted = unit.strip("?") if unit.endswith("?") else None
        assert found[channel].unit == wanted, channel


def test_of_two_yaw_rates_the_one_that_turns_the_car_is_taken() -> None:
    signals = _signals(NAMES, {})
    time = signals[0].time_s
    other = np.sin(9.0 * time) * 10.0
    signals.insert(0, Signal("YawRateCam", "", "deg/s", time, other))
    assert propose(signals)["car_yaw_rate"].signal == "GierRate"


def test_road_wheel_angle_is_recognised() -> None:
    signals = _signals(NAMES, {})
    thin = [
        Signal(s.name, "", s.unit, s.time_s, s.value / 15.0) if "Lenk" in s.name else s
        for s in signals
    ]
    assert ROAD_WHEEL in propose(thin)["steering_wheel_angle"].reasons
    assert ROAD_WHEEL not in propose(signals)["steering_wheel_angle"].reasons


def test_words() -> None:
    assert words_of("LatAccRear1") == "lat acc rear 1"
    assert words_of("IMU.YawRate_FL") == "yaw rate fl"


# --- files ----------------------------------------------------------------------------------------


def test_answers_make_the_lengths(tmp_path: Path) -> None:
    sets = {
        "car.mass": 1955, "car.wheelbase": 2.685, "car.front_share": 51.5, "car.overhang": 0.783,
        "car.steering_ratio": 15, "car.accelerometer": 0, "trailer.mass": 1880,
        "trailer.drawbar": 5.274, "trailer.axle_spacing": 0.65, "trailer.nose_weight": 71.6,
        "trailer.accelerometer": 0.2,
    }  # fmt: skip
    words = [w for name, value in sets.items() for w in ("--set", f"{name}={value}")]
    assert _init(tmp_path, str(P03 / "run1.asc"), *words) == 0
    mine, right = load_vehicle(tmp_path / "vehicle.toml"), load_vehicle(P03 / "vehicle.toml")
    for body in ("car", "trailer"):
        for key in ("mass", "front_axle_to_cog", "rear_axle_to_cog", "hitch_to_cog"):
            wanted = getattr(getattr(right, body), key)
            assert getattr(getattr(mine, body), key) == pytest.approx(wanted, abs=0.01), key
    positions = {m.channel: m.position_m for m in load_signals(tmp_path / "signals.toml")[0]}
    assert positions["car_lateral_acceleration"] == pytest.approx(-1.383, abs=0.01)
    assert "GUESS" not in (tmp_path / "vehicle.toml").read_text()


def test_what_is_not_known_is_left_open_and_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _init(tmp_path, str(P03 / "run1.asc")) == 0
    said = capsys.readouterr().out
    assert "vehicle.toml is not complete: car.mass" in said
    assert "Not ready yet" in said
    assert "mass" not in tomllib.loads((tmp_path / "vehicle.toml").read_text())["car"]
    assert "# mass =   # MISSING" in (tmp_path / "vehicle.toml").read_text()


def test_files_that_are_there_are_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "vehicle.toml").write_text((P03 / "vehicle.toml").read_text())
    assert _init(tmp_path, str(P03 / "run1.asc")) == 0
    assert (tmp_path / "vehicle.toml").read_text() == (P03 / "vehicle.toml").read_text()
    assert "kept as it is" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--set", "car.mass=heavy"], "must be a number"),
        (["--set", "car.mass=1.9"], "expected 300 to 20000 kg"),
        (["--set", "car.weight=1900"], "no such question"),
        (["--set", "role.speed=Nothing"], "no such signal"),
        (["--set", "car.mass"], "expected NAME=VALUE"),
        (["--dbc", "nowhere.dbc"], "nowhere.dbc"),
    ],
)
def test_wrong_answers_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    assert _init(tmp_path, str(P03 / "run1.asc"), *words) == 1
    assert message in capsys.readouterr().err


def test_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert _init(tmp_path, str(P03 / "run1.asc"), "--json") == 0
    content: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert content["roles"]["speed"]["signal"] == "VehicleSpeed"
    assert len(content["signals"]) == 17
