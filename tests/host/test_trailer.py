"""The trailer from the car's own sensors: command, partly known vehicles, sets of sensors."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import DATA

from swaywatch.analysis import analyze
from swaywatch.cli import main
from swaywatch.drive import Drive, load_drives
from swaywatch.errors import VehicleError
from swaywatch.simulate import simulate_scenario
from swaywatch.simulate.scenario import read_scenario
from swaywatch.trailer import OWN_CHANNELS, TrailerResult, identify, presence_sentence
from swaywatch.vehicle_file import load_vehicle

FOLDER = DATA / "practice" / "p01"
RUNS = [FOLDER / "run2.blf", FOLDER / "run1.blf"]
TRUE_KMH = 123.34

OWN = """dbc = "{dbc}"
[signals]
steering_wheel_angle = "SteeringWheelAngle"
speed = "VehicleSpeed"
car_yaw_rate = "YawRate1"
car_lateral_acceleration = {{ signal = "LatAccRear1", position = -1.383 }}
"""


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A signals.toml with the car's own four channels."""
    path = tmp_path / "signals.toml"
    path.write_text(OWN.format(dbc=(FOLDER / ".." / "measurement.dbc").resolve()))
    return path


def car_only(tmp_path: Path, trailer: str = "") -> Path:
    """p01's car, and what is known of its trailer."""
    text = (FOLDER / "vehicle.toml").read_text()
    path = tmp_path / "vehicle.toml"
    path.write_text(text[: text.index("[trailer]")] + trailer)
    return path


def found(drives: list[Drive], vehicle: Path) -> TrailerResult:
    return identify(drives, load_vehicle(vehicle))


def test_analyze_needs_no_sensor_on_the_trailer(own: Path) -> None:
    """Frequency, damping, critical speed and alarms from the car's own four channels."""
    full = analyze([RUNS[1]], FOLDER / "vehicle.toml", FOLDER / "signals.toml")[0]
    result = analyze([RUNS[1]], FOLDER / "vehicle.toml", own)[0]
    for name in ("frequency_hz", "damping_ratio"):
        mine, theirs = result.values[name], full.values[name]
        assert abs(mine.value - theirs.value) < 3.0 * np.hypot(mine.error, theirs.error)
    critical = result.values["v_crit_m_s"]
    assert abs(3.6 * critical.value - TRUE_KMH) < 2.0
    assert 2.0 * 3.6 * critical.error < 9.0  # 0.15 m of the tyres' lag alone are 2.2 km/h
    assert {alarm.state for alarm in result.alarms} - {"off"}
    assert "A trailer is attached" in presence_sentence(result.estimates.trailer)
    assert presence_sentence(full.estimates.trailer) == ""


@pytest.mark.parametrize(
    ("trailer", "assumed"),
    [
        ("", 5),
        ("[trailer]\nmass = 1880\nhitch_to_axle = 5.27\n", 3),
    ],
)
def test_critical_speed_of_a_trailer_partly_known(
    tmp_path: Path, own: Path, trailer: str, assumed: int
) -> None:
    """Nothing known, and the type plate: within 3 % and inside the interval."""
    vehicle = car_only(tmp_path, trailer)
    known = load_vehicle(vehicle).trailer
    assert (5 if known is None else len(known.assumed)) == assumed
    result = found([load_drives([run], own)[0] for run in RUNS], vehicle)
    assert result.presence == "there"
    assert result.critical_speed_m_s is not None
    assert result.critical_speed_error_m_s is not None
    assert abs(3.6 * result.critical_speed_m_s - TRUE_KMH) < 0.03 * TRUE_KMH
    truth = {"mass": 1880.0, "hitch to axle": 5.27, "yaw inertia": 10350.0}
    for quantity in result.quantities:
        if quantity.name in truth:
            half = quantity.high - quantity.value
            assert abs(quantity.value - truth[quantity.name]) < 2.0 * half
    assert result.manoeuvres


def test_command(own: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Sentences, a table, JSON; recordings with trailer sensors may be used as well."""
    out = tmp_path / "trailer.json"
    arguments = ["trailer", *map(str, RUNS), "--vehicle", str(FOLDER / "vehicle.toml")]
    assert main([*arguments, "--signals", str(FOLDER / "signals.toml"), "--out", str(out)]) == 0
    text = capsys.readouterr().out
    assert "A trailer is attached" in text
    assert "Critical speed 123." in text or "Critical speed 124." in text
    content = json.loads(out.read_text())
    assert content["presence"] == "there"
    assert {q["name"] for q in content["quantities"]} >= {"mass", "yaw inertia"}


def test_command_says_which_channel_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without steering nothing can be identified."""
    path = tmp_path / "signals.toml"
    text = OWN.format(dbc=(FOLDER / ".." / "measurement.dbc").resolve())
    path.write_text(text.replace('steering_wheel_angle = "SteeringWheelAngle"\n', ""))
    vehicle = str(FOLDER / "vehicle.toml")
    assert main(["trailer", str(RUNS[0]), "--vehicle", vehicle, "--signals", str(path)]) == 1
    assert "steering_wheel_angle" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("trailer", "words"),
    [
        ("[trailer]\nhitch_to_axle = -3\n", "hitch_to_axle = -3 must be a number from 0.5 to 20"),
        ("[trailer]\nhitch_to_axle = 5\nhitch_to_cog = 4.8\n", "one of them is enough"),
        ("[trailer]\nweight = 5\n", "weight is not known"),
    ],
)
def test_nonsense_of_a_trailer_is_refused(tmp_path: Path, trailer: str, words: str) -> None:
    """With file, key and what would be right."""
    with pytest.raises(VehicleError, match=words):
        load_vehicle(car_only(tmp_path, trailer))


def scenario(**content: Any) -> Any:
    base = {
        "vehicle": "vehicle.toml", "duration_s": 60.0, "speed_kmh": 100.0,
        "manoeuvre": [
            {"kind": "slalom", "angle_deg": 20.0, "frequency_hz": 0.5, "duration_s": 50.0},
        ],
    }  # fmt: skip
    return read_scenario({**base, **content}, "test", FOLDER, "test.toml")


@pytest.mark.parametrize(("preset", "forces"), [("production", False), ("wheel_force_rims", True)])
def test_sets_of_sensors(preset: str, forces: bool) -> None:
    """A production car has its own four; rims add the car's wheels; nothing is on the trailer."""
    drive, _ = simulate_scenario(scenario(sensors={"preset": preset}))
    assert set(OWN_CHANNELS) <= set(drive.channels)
    assert not [name for name in drive.channels if name.startswith(("trailer", "hitch", "art"))]
    assert ("wheel_lateral_force_fl" in drive.channels) == forces
    step = np.diff(np.unique(drive.channels["car_yaw_rate"].value))
    assert np.degrees(step.min()) == pytest.approx(0.1, rel=1e-6)


def test_a_car_alone_at_production_grade() -> None:
    """No trailer, said as such, and no quantities of one."""
    content = scenario(sensors={"preset": "production"})
    alone = dataclasses.replace(content, vehicle=dataclasses.replace(content.vehicle, trailer=None))
    drive, _ = simulate_scenario(alone)
    result = identify([drive], alone.vehicle)
    assert result.presence == "none"
    assert result.quantities == ()
    assert result.critical_speed_m_s is None
