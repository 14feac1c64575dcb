"""Input that users get wrong: the message names file, key and value, and what would be right."""

from __future__ import annotations

import errno
import shutil
from pathlib import Path

import can
import numpy as np
import pytest
from conftest import DATA

from swaywatch.cli import main
from swaywatch.nearest import did_you_mean, with_known

P03 = DATA / "practice" / "p03"
RUN = str(P03 / "run1.asc")
VEHICLE = str(P03 / "vehicle.toml")
SIGNALS = str(P03 / "signals.toml")


def said(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """What a refused command says."""
    assert main(list(words)) == 1
    error = capsys.readouterr().err
    assert "internal error" not in error
    return error


def changed(source: str, old: str, new: str, folder: Path) -> str:
    """A copy of a file of the practice case with one change."""
    text = Path(source).read_text()
    assert old in text
    path = folder / Path(source).name
    path.write_text(text.replace(old, new, 1))
    return str(path)


def test_one_mechanism_names_the_nearest() -> None:
    assert did_you_mean("maas", ["mass", "yaw_inertia"]) == "; did you mean 'mass'?"
    assert did_you_mean("colour", ["mass"]) == ""
    assert with_known("maas", ["mass", "cog"]) == "; did you mean 'mass'? Known: mass, cog"
    assert with_known(3, ["mass", "cog"]) == "; known: mass, cog"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("mass = ", "maas = ", ["[car] maas is not known; did you mean 'mass'? Known: "]),
        ("[trailer]", "[trailor]", ["unknown table [trailor]; did you mean 'trailer'?"]),
        ("mass = ", "# mass = ", ["[car] mass is missing; expected 300 to 60000 kg"]),
    ],
)
def test_key_of_a_vehicle(
    old: str, new: str, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    vehicle = changed(VEHICLE, old, new, tmp_path)
    error = said(capsys, "analyze", RUN, "--vehicle", vehicle, "--signals", SIGNALS)
    assert vehicle in error
    assert all(word in error for word in words), error


def test_role_is_misspelt(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    signals = changed(SIGNALS, "car_yaw_rate", "car_yawrate", tmp_path)
    error = said(capsys, "analyze", RUN, "--vehicle", VEHICLE, "--signals", signals)
    assert f"{signals}: [signals] unknown role 'car_yawrate'; did you mean 'car_yaw_rate'?" in error


def test_effect_is_misspelt(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hint = "did you mean 'hitch_friction'?"
    assert hint in said(capsys, "physics", "hitch_frction")
    scenario = tmp_path / "wrong.toml"
    scenario.write_text(
        f'vehicle = "{VEHICLE}"\nduration_s = 5.0\nspeed_kmh = 80.0\n'
        '[[manoeuvre]]\nkind = "impulse"\nstart_s = 1.0\n[[physics]]\nid = "hitch_frction"\n'
    )
    assert hint in said(capsys, "simulate", str(scenario), "--out", str(tmp_path / "x.blf"))


@pytest.mark.parametrize(
    ("vehicle", "signals", "words"),
    [
        (SIGNALS, VEHICLE, [f"{SIGNALS}: this is a signals.toml", "--vehicle takes", "swapped?"]),
        (VEHICLE, VEHICLE, [f"{VEHICLE}: this is a vehicle.toml", "--signals takes", "swapped?"]),
        (
            str(DATA / "scenarios" / "ladder.toml"), SIGNALS,
            ["this is a scenario", "--vehicle takes a vehicle.toml"],
        ),
    ],
)  # fmt: skip
def test_files_in_the_wrong_place(
    vehicle: str, signals: str, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    error = said(capsys, "analyze", RUN, "--vehicle", vehicle, "--signals", signals)
    assert all(word in error for word in words), error


def test_survey_of_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(RUN, tmp_path)
    error = said(capsys, "survey", str(tmp_path / "run1.asc"), "--out", str(tmp_path / "out"))
    assert f"{tmp_path / 'run1.asc'}: this is a file; survey takes a folder" in error
    assert f"such as {tmp_path}" in error


@pytest.mark.parametrize(
    ("command", "number", "words"),
    [
        ("feed", errno.EAFNOSUPPORT, ["this kernel has no CAN", "modprobe", "virtual"]),
        ("monitor", errno.EAFNOSUPPORT, ["this kernel has no CAN", "modprobe", "virtual"]),
        ("hil", errno.EAFNOSUPPORT, ["this kernel has no CAN", "modprobe", "virtual"]),
        ("feed", errno.ENODEV, ["no such network interface", "ip link add vcan7 type vcan"]),
        ("feed", errno.ENETDOWN, ["it is down", "ip link set vcan7 up"]),
    ],
)
def test_bus_that_does_not_open(
    command: str,
    number: int,
    words: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def refuse(**_options: object) -> None:
        raise OSError(number, "as the kernel says it")

    monkeypatch.setattr(can, "Bus", refuse)
    first = {
        "feed": [RUN], "monitor": ["--vehicle", VEHICLE],
        "hil": [str(DATA / "scenarios" / "brake.toml")],
    }[command]  # fmt: skip
    error = said(capsys, command, *first, "--interface", "socketcan", "--channel", "vcan7")
    assert "--interface socketcan --channel vcan7: cannot be opened" in error
    assert all(word in error for word in words), error
    assert "Errno" not in error


def test_interface_is_misspelt(capsys: pytest.CaptureFixture[str]) -> None:
    error = said(capsys, "feed", RUN, "--interface", "sockecan")
    assert "no such interface; did you mean 'socketcan'?" in error


def test_model_that_is_no_diagnosis(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "scores.json")
    truth = str(P03 / "truth.json")
    error = said(capsys, "predict", "--model", truth, "--recording", RUN, "--out", out)
    assert f"{truth}: holds no model: it is no result of `swaywatch diagnose`" in error
    ended = tmp_path / "diagnosis.json"
    ended.write_text('{"verdict": "bad_data"}')
    error = said(capsys, "predict", "--model", str(ended), "--recording", RUN, "--out", out)
    assert "the diagnosis ended with the verdict 'bad_data'" in error


def test_init_asks_for_units(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A table without units: what is left out is listed with the options that assign it."""
    time = np.arange(0.0, 60.0, 0.02)
    yaw = 10.0 * np.sin(3.0 * time) * np.sin(0.2 * time)
    rows = np.column_stack([time, np.full_like(time, 90.0), yaw, 3.0 * yaw, yaw * 25.0 / 57.3])
    table = tmp_path / "run.csv"
    head = "time,speed,yaw_rate,steering,ay"
    np.savetxt(table, rows, delimiter=",", header=head, comments="", fmt="%.5f")
    words = ["init", str(table), "--out", str(tmp_path / "files"), "--no-questions", "--typical"]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert "[signals] is empty: no signal is assigned to a role" in shown
    answers = []
    for role, signal, unit in (
        ("speed", "speed", "km/h"), ("car_yaw_rate", "yaw_rate", "deg/s"),
        ("car_lateral_acceleration", "ay", "m/s2"), ("steering_wheel_angle", "steering", "deg"),
    ):  # fmt: skip
        assert f"--set role.{role}={signal} --set role.{role}.unit=" in shown
        answers += ["--set", f"role.{role}={signal}", "--set", f"role.{role}.unit={unit}"]
    assert main([*words, "--force", *answers]) == 0
    shown = capsys.readouterr().out
    assert "unit is not known" not in shown
    assert "Not ready yet" not in shown
