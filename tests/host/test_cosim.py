"""A user's FMU as `--simulation` and as the plant of `hil`; here it is our own plant's."""

from __future__ import annotations

import dataclasses
import json
import math
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import DATA, built_fmu
from fmpy import read_model_description
from test_hil import drive

from swaywatch.cli import main
from swaywatch.cosim.fmu import Fmu
from swaywatch.cosim.mapping import wire
from swaywatch.cosim.plant import FmuPlant
from swaywatch.drive import load_drive
from swaywatch.errors import FmuError, ScenarioError, SwaywatchError
from swaywatch.models.double_track import DoubleTrack, SpeedControl
from swaywatch.plant.sprung import defaults
from swaywatch.plant.vehicle_view import constants_of
from swaywatch.simulate.scenario import read_scenario
from swaywatch.validate.fmu_twin import twin_of
from swaywatch.validate.twin import simulate_twin
from swaywatch.vehicle_file import load_vehicle

P01, P03 = DATA / "practice" / "p01", DATA / "practice" / "p03"
RIGID = """[parameters]
"sprung.sprung_mass_car" = 0
"sprung.sprung_mass_trailer" = 0.0
speed_control = false
"""
"""The practice recordings are of bodies that do not roll."""


@pytest.fixture(scope="module")
def plant() -> Path:
    """The plant as an FMU of FMI 2."""
    return built_fmu("swaywatch_plant_fmi2")


@pytest.fixture
def rigid(tmp_path: Path) -> Path:
    path = tmp_path / "rigid.toml"
    path.write_text(RIGID)
    return path


def changed(fmu: Path, to: Path, change: Callable[[str], str], platform: str = "linux64") -> Path:
    """The same FMU with another description, or for another machine."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(to, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                content = change(content.decode()).encode()
            place = name.replace("linux64", platform)
            new.writestr(place.replace(".so", ".dll") if "win" in platform else place, content)
    return to


def wired(fmu: Path, toml: Path, text: str) -> Any:
    toml.write_text(text)
    return wire(read_model_description(str(fmu), validate=False), fmu, toml)


def test_it_drives_as_the_own_simulation_does(plant: Path, rigid: Path) -> None:
    """The same recorded inputs, the same vehicle, two ways: motion and forces within 1 %."""
    recorded = load_drive([P01 / "run1.blf"], P01 / "signals.toml")
    ours = simulate_twin(recorded, load_vehicle(P01 / "vehicle.toml"))
    theirs = twin_of(recorded, plant, rigid)
    assert set(theirs.channels) == set(recorded.channels)
    for name in (
        "car_yaw_rate", "trailer_yaw_rate", "trailer_lateral_acceleration",
        "car_lateral_acceleration", "wheel_lateral_force_rl", "hitch_lateral_force",
    ):  # fmt: skip
        own, other = ours.channels[name], theirs.channels[name]
        at = own.time_s[own.time_s <= other.time_s[-1]]
        value = own.value[: at.size]
        error = np.interp(at, other.time_s, other.value) - value
        assert float(np.std(error)) < 0.01 * float(np.std(value)), name


def test_a_diagnosis_against_an_fmu_names_the_effect(
    plant: Path, rigid: Path, tmp_path: Path
) -> None:
    code = main([
        "diagnose", str(P03 / "run1.asc"), str(P03 / "run2.asc"), "--vehicle",
        str(P03 / "vehicle.toml"), "--signals", str(P03 / "signals.toml"), "--simulation",
        str(plant), "--simulation-signals", str(rigid), "--out", str(tmp_path),
    ])  # fmt: skip
    assert code == 0
    truth = json.loads((P03 / "truth.json").read_text())
    found = json.loads((tmp_path / "diagnosis.json").read_text())
    assert [e["id"] for e in found["effects"]] == [truth["effects"][0]["id"]]
    assert found["effects"][0]["component"] == truth["effects"][0]["axle"]


def test_names_units_and_signs_come_from_a_table(plant: Path, tmp_path: Path) -> None:
    def rename(text: str) -> str:
        text = text.replace('name="steering_wheel_angle"', 'name="delta_sw"')
        text = text.replace('name="target_speed"', 'name="v_set"')
        return text.replace('name="car_yaw_rate"', 'name="psi_dot"')

    other = changed(plant, tmp_path / "user.fmu", rename)
    with pytest.raises(FmuError, match=r"no input for the role steering_wheel_angle; its inputs: "
                       r"delta_sw \[rad\]"):  # fmt: skip
        wire(read_model_description(str(other)), other)
    text = """
        [signals]
        car_yaw_rate = { signal = "psi_dot", unit = "deg/s", sign = -1 }
        [inputs]
        steering_wheel_angle = "delta_sw"
        speed = { signal = "v_set", unit = "km/h" }
        [parameters]
        "car.mass" = 1500
    """
    found = wired(other, tmp_path / "user.toml", text)
    assert {w.role: w.factor for w in found.inputs} == {
        "steering_wheel_angle": 1.0, "speed": pytest.approx(1 / 3.6)
    }  # fmt: skip
    assert found.outputs[0].factor == pytest.approx(-math.pi / 180.0)
    assert "steering_wheel_angle_rate" in found.idle
    assert found.parameters == {"car.mass": 1500.0}
    for old, new, said in (
        ("psi_dot", "psi_dott", r"no such variable; did you mean 'psi_dot'\? Its outputs"),
        ('"v_set", unit = "km/h"', '"v_set", unit = "N"', "needs one of: m/s, km/h"),
        ('"delta_sw"', '"psi_dot"', "is a variable of causality output"),
        ("car.mass", "car.mas", "did you mean 'car.mass'"),
        ("1500", '"heavy"', "must be a number, or a role"),
        ("speed =", "sped =", "unknown role 'sped'"),
    ):
        with pytest.raises(SwaywatchError, match=said):
            wired(other, tmp_path / "wrong.toml", text.replace(old, new))


@pytest.mark.parametrize(
    ("change", "platform", "said"),
    [
        (lambda t: t.replace('fmiVersion="2.0"', 'fmiVersion="1.0"'), "linux64", "FMI 1.0; 2.0"),
        (lambda t: t, "win64", "no binary for this machine .*; it has: win64"),
        (lambda t: t.replace("CoSimulation", "ModelExchange"), "linux64", "for model exchange"),
        (lambda t: t[:400], "linux64", "not an FMU"),
        (lambda t: t.replace('"2.0" ', '"2.0" colour="red" '), "linux64", "not meet its standard"),
    ],
)  # fmt: skip
def test_what_cannot_be_run_is_reported(
    plant: Path, tmp_path: Path, change: Callable[[str], str], platform: str, said: str
) -> None:
    broken = changed(plant, tmp_path / "broken.fmu", change, platform)
    with pytest.raises(FmuError, match=said):
        Fmu(broken)


def test_a_unit_that_does_not_fit_is_reported(plant: Path, tmp_path: Path) -> None:
    old, new = 'Real unit="rad/s" />', 'Real unit="N" />'
    wrong = changed(plant, tmp_path / "user.fmu", lambda t: t.replace(old, new))
    with pytest.raises(FmuError, match="'car_yaw_rate' has the unit 'N', but car_yaw_rate needs"):
        wire(read_model_description(str(wrong)), wrong)


def test_a_start_value_it_refuses_is_reported(plant: Path, tmp_path: Path) -> None:
    toml = tmp_path / "user.toml"
    toml.write_text('[parameters]\n"car.mass" = 0\n')
    with pytest.raises(FmuError, match="cannot be started"):
        FmuPlant(plant, toml, 0.01, 25.0, has_trailer=True, rear_axle_m=1.383)


@pytest.mark.parametrize("version", ["2", "3"])
def test_in_the_loop_it_is_the_plant(version: str) -> None:
    """Sample by sample within 1e-9 of our own, a brake included."""
    vehicle = load_vehicle(P03 / "vehicle.toml")
    own = DoubleTrack(vehicle, sprung=defaults(constants_of(vehicle)))
    ours = own.stepper(0.01, 30.0, speed_control=SpeedControl())
    theirs = FmuPlant(built_fmu(f"swaywatch_plant_fmi{version}"), None, 0.01, 30.0,
                      has_trailer=True, rear_axle_m=vehicle.car.rear_axle_to_cog)  # fmt: skip
    for k in range(300):
        angle = 0.3 * math.sin(0.04 * k)
        for one in (ours, theirs):
            if k == 150:
                one.brake("trailer", 3000.0)
            one.advance(angle, 30.0)
        a, b = ours.trace(angle), theirs.trace(angle)
        for name in ("trailer_yaw_rate", "car_lateral_acceleration", "speed"):
            assert float(b[name][0]) == pytest.approx(float(a[name][0]), abs=1e-9)
    theirs.close()
    assert float(b["speed"][0]) < 29.9


def loop(plant: Path, **content: Any) -> Any:
    base: dict[str, Any] = {
        "vehicle": "vehicle.toml", "duration_s": 14.0, "speed_kmh": 134.0, "model": "fmu",
        "manoeuvre": [{"kind": "impulse", "angle_deg": 8.0, "start_s": 2.0}],
        "reaction": {"kind": "trailer_brake", "force_n": 4000.0, "at": "warning"},
        "fmu": {"file": str(plant)},
    }  # fmt: skip
    return read_scenario({**base, **content}, "test", P03, "test.toml")


def test_the_alarm_brakes_the_fmu(plant: Path, tmp_path: Path) -> None:
    result, bus = drive(loop(plant))
    assert set(bus.ecu.faults().values()) == {0}
    assert result.reacted_s is not None
    assert result.swing_rad_s[-1] < 0.5 * max(result.swing_rad_s)
    alone, _ = drive(loop(plant, reaction={}))
    assert alone.swing_rad_s[-1] > 2.0 * result.swing_rad_s[-1]


def test_what_does_not_fit_the_loop_is_reported(plant: Path, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"needs model = 'fmu'"):
        loop(plant, model="double_track")
    with pytest.raises(ScenarioError, match=r"needs \[fmu\]"):
        read_scenario({**_content(), "model": "fmu"}, "test", P03, "test.toml")
    with pytest.raises(ScenarioError, match=r"own physics is in the FMU"):
        loop(plant, physics=[{"id": "hitch_friction", "moment_nm": 100.0}])
    unbraked = changed(plant, tmp_path / "unbraked.fmu",
                       lambda t: t.replace("trailer_brake_force", "trailer_wind"))  # fmt: skip
    with pytest.raises(FmuError, match="no input for trailer_brake_force"):
        drive(loop(unbraked))
    slow = changed(plant, tmp_path / "slow.fmu", lambda t: t.replace(
        ' canHandleVariableCommunicationStepSize="true"', "").replace(
        'stepSize="0.01"', 'stepSize="0.004"'))  # fmt: skip
    with pytest.raises(FmuError, match=r"takes steps of 0.008 s only; .* rate_hz = 125"):
        drive(loop(slow))
    plain = dataclasses.replace(loop(plant), fmu=(tmp_path / "none.fmu", None))
    with pytest.raises(FmuError, match=r"none\.fmu"):
        drive(plain)


def _content() -> dict[str, Any]:
    return {"vehicle": "vehicle.toml", "duration_s": 5.0, "speed_kmh": 80.0}
