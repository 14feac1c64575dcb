"""Roles, units, vehicles, and which files are one drive."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA, recordings

from swaywatch.drive import load_drive, load_drives
from swaywatch.ecu.core import vehicle_ranges
from swaywatch.errors import SignalError, VehicleError
from swaywatch.recording import Series, write_recording
from swaywatch.vehicle_file import load_vehicle

P01 = DATA / "practice" / "p01"
RUNS = [P01 / "run1.blf", P01 / "run2.blf"]


def signals_file(folder: Path, text: str) -> Path:
    path = folder / "signals.toml"
    path.write_text(f'dbc = "{DATA / "practice" / "measurement.dbc"}"\n{text}')
    return path


def test_runs_that_overlap_are_separate_drives() -> None:
    drives = load_drives(RUNS, P01 / "signals.toml")
    assert [drive.name for drive in drives] == ["run1", "run2"]
    assert all(len(drive.channels) == 16 for drive in drives)
    assert drives[0].duration_s == pytest.approx(37.97, abs=0.01)


def test_values_are_in_si_units() -> None:
    channels = load_drive(RUNS[:1], P01 / "signals.toml").channels
    assert np.mean(channels["speed"].value) == pytest.approx(33.75, abs=0.3)
    assert np.abs(channels["car_yaw_rate"].value).max() < 0.5
    assert channels["car_lateral_acceleration"].position_m == -1.383
    assert np.mean(channels["wheel_vertical_load_fl"].value) == pytest.approx(4837, rel=0.05)


def test_two_loggers_are_one_drive(tmp_path: Path) -> None:
    drive = load_drive(RUNS[:1], P01 / "signals.toml")

    def series(name: str) -> Series:
        channel = drive.channels[name]
        time_ns = 1_700_000_000_000_000_000 + (channel.time_s * 1e9).astype(np.int64)
        return Series(time_ns, channel.value, channel.unit)

    write_recording(tmp_path / "car.mf4", {"a": series("speed"), "b": series("car_yaw_rate")})
    write_recording(tmp_path / "trailer.csv", {"c": series("trailer_yaw_rate")})
    path = tmp_path / "signals.toml"
    path.write_text('[signals]\nspeed = "a"\ncar_yaw_rate = "b"\ntrailer_yaw_rate = "c"\n')
    drives = load_drives([tmp_path / "car.mf4", tmp_path / "trailer.csv"], path)
    assert len(drives) == 1
    assert set(drives[0].channels) == {"speed", "car_yaw_rate", "trailer_yaw_rate"}
    assert np.allclose(drives[0].channels["speed"].value, drive.channels["speed"].value)


def test_parts_that_follow_each_other_are_one_drive(tmp_path: Path) -> None:
    path = tmp_path / "signals.toml"
    path.write_text('[signals]\nspeed = { signal = "v", unit = "km/h" }\n')
    for part in range(3):
        time_ns = np.arange(100, dtype=np.int64) * 10_000_000 + part * 1_000_000_000
        write_recording(tmp_path / f"{part}.csv", {"v": Series(time_ns, np.full(100, 36.0), "")})
    drives = load_drives([tmp_path / f"{part}.csv" for part in (2, 0, 1)], path)
    assert len(drives) == 1
    assert len(drives[0].channels["speed"].value) == 300
    assert np.all(np.diff(drives[0].channels["speed"].time_s) > 0)
    assert np.allclose(drives[0].channels["speed"].value, 10.0)


def test_resampling_marks_gaps(tmp_path: Path) -> None:
    path = tmp_path / "signals.toml"
    path.write_text('[signals]\nspeed = "v"\n')
    time_ns = np.arange(300, dtype=np.int64) * 10_000_000
    keep = (time_ns < 1_000_000_000) | (time_ns > 1_500_000_000)
    write_recording(
        tmp_path / "v.csv", {"v": Series(time_ns[keep], np.full(keep.sum(), 9.0), "m/s")}
    )
    grid = load_drive([tmp_path / "v.csv"], path).resample(100.0)
    bad = grid.time_s[~grid.valid["speed"]]
    assert bad.min() == pytest.approx(1.0, abs=0.02)
    assert bad.max() == pytest.approx(1.5, abs=0.02)


def test_sign_scale_unit_and_delay_of_a_mapping(tmp_path: Path) -> None:
    path = signals_file(
        tmp_path,
        '[signals]\nspeed = "VehicleSpeed"\n'
        'car_yaw_rate = { signal = "YawRate1", sign = -1, scale = 2.0, unit = "rad/s", '
        "delay = 0.1 }",
    )
    plain = load_drive(RUNS[:1], P01 / "signals.toml").channels
    changed = load_drive(RUNS[:1], path).channels
    factor = -2.0 * 180 / np.pi
    assert np.allclose(changed["car_yaw_rate"].value, factor * plain["car_yaw_rate"].value)
    later = plain["car_yaw_rate"].time_s - changed["car_yaw_rate"].time_s
    assert np.allclose(later - later[0], 0.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('speed = "VehicleSpeed"', "signals"),
        ('[signals]\nspeeed = "VehicleSpeed"', "speeed"),
        ('[signals]\nspeed = "VehicelSpeed"', "did you mean 'VehicleSpeed'"),
        ('[signals]\nspeed = { signal = "VehicleSpeed", positon = 1 }', "position"),
        ('[signals]\nspeed = { signal = "VehicleSpeed", unit = "furlong" }', "furlong.*km/h"),
        ('[signals]\nspeed = { signal = "VehicleSpeed", sign = 2 }', "sign"),
        ('[signals]\nspeed = "YawRate1"', "deg/s.*km/h"),
        ('[signals]\nwheel_lateral_force = ["FyFL"]', "FL, FR, RL, RR"),
        ("[signals]\nspeed = ", "TOML"),
    ],
)
def test_faults_of_the_mapping_are_named(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(SignalError, match=f"(?s)signals.toml.*{words}|{words}.*signals.toml"):
        load_drives(RUNS[:1], signals_file(tmp_path, text))


def test_a_dbc_of_another_bus_is_refused(tmp_path: Path) -> None:
    dbc = (DATA / "practice" / "measurement.dbc").read_text()
    other = tmp_path / "other.dbc"
    for identifier in ("194", "416", "688", "696", "784", "785", "786", "787", "800"):
        dbc = dbc.replace(f"BO_ {identifier} ", f"BO_ {1100 + int(identifier) % 97} ")
        dbc = dbc.replace(f"SG_ {identifier} ", f"SG_ {1100 + int(identifier) % 97} ")
    other.write_text(dbc)
    path = tmp_path / "signals.toml"
    path.write_text((P01 / "signals.toml").read_text().replace("../measurement.dbc", "other.dbc"))
    with pytest.raises(SignalError, match=r"other\.dbc does not match"):
        load_drives(RUNS[:1], path)


def test_a_dbc_with_other_scales_is_refused(tmp_path: Path) -> None:
    dbc = (DATA / "practice" / "measurement.dbc").read_text()
    (tmp_path / "wrong.dbc").write_text(
        dbc.replace("0|16@1+ (0.01,0) [0|400]", "0|16@1+ (1,0) [0|400]")
    )
    path = tmp_path / "signals.toml"
    path.write_text((P01 / "signals.toml").read_text().replace("../measurement.dbc", "wrong.dbc"))
    with pytest.raises(SignalError, match=r"wrong\.dbc does not fit.*VehicleSpeed.*400"):
        load_drives(RUNS[:1], path)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("mass = 1955", "mass = 1.955", "car.*mass.*1.955.*300 to"),
        ("mass = 1955", "", "car.*mass is missing"),
        ("mass = 1955", 'mass = "heavy"', "car.*mass.*number"),
        ("mass = 1955", "mass = 1955\nmas = 3", "mas is not known"),
        ("[trailer]", "[trialer]", "trialer"),
        (
            "front_axle_to_cog = 1.302",
            "front_axle_to_cog = -1.302",
            "front_axle_to_cog.*out of range",
        ),
        ("yaw_inertia = 10350", "yaw_inertia = 103500000", "yaw_inertia.*out of range"),
        ("rear_axle_to_cog = 0.526", "rear_axle_to_cog = -0.526", "behind the rear axle"),
        ("[car]", "[car", "TOML"),
    ],
)
def test_faults_of_the_vehicle_are_named(tmp_path: Path, old: str, new: str, words: str) -> None:
    text = (P01 / "vehicle.toml").read_text()
    assert old in text
    path = tmp_path / "vehicle.toml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(VehicleError, match=f"vehicle.toml.*{words}"):
        load_vehicle(path)


KEYS = [
    (table, line.split(" = ")[0])
    for table, text in zip(
        ("car", "trailer"),
        (P01 / "vehicle.toml").read_text().partition("[car]")[2].split("[trailer]"),
        strict=True,
    )
    for line in text.splitlines()
    if " = " in line
]


BESIDE = [
    (table, key, value)
    for table, key in KEYS
    for value in ("-1e9", "1e9", "nan", "0")
    if (table, value) != ("trailer", "0") or not key.endswith("_axle_to_cog")
]
"""An axle of a trailer may stand below the centre of gravity."""


@pytest.mark.parametrize(("table", "key", "value"), BESIDE)
def test_every_parameter_out_of_range_is_named_with_its_range(
    tmp_path: Path, table: str, key: str, value: str
) -> None:
    head, _, tail = (P01 / "vehicle.toml").read_text().partition(f"[{table}]")
    path = tmp_path / "vehicle.toml"
    path.write_text(
        head + f"[{table}]" + re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", tail, count=1)
    )
    words = rf"vehicle\.toml: \[{table}\] {key} = .* out of range; expected [-\d.e+]+ to [-\d.e+]+"
    with pytest.raises(VehicleError, match=words):
        load_vehicle(path)


@pytest.mark.parametrize("side", ["low", "high"])
@pytest.mark.parametrize(("table", "key"), KEYS)
def test_no_value_is_accepted_that_the_core_refuses(
    tmp_path: Path, table: str, key: str, side: str
) -> None:
    low, high = vehicle_ranges()[f"{table}.{key}"]
    value = low - 0.001 * abs(low) if side == "low" else high * 1.001
    head, _, tail = (P01 / "vehicle.toml").read_text().partition(f"[{table}]")
    path = tmp_path / "vehicle.toml"
    path.write_text(
        head + f"[{table}]" + re.sub(rf"(?m)^{key} = .*$", f"{key} = {value!r}", tail, count=1)
    )
    with pytest.raises(VehicleError, match=rf"\[{table}\] {key} = "):
        load_vehicle(path)


def test_every_practice_format_reads() -> None:
    for case in ("p02", "p04", "p07", "p09"):
        folder = recordings("practice", case)
        files = sorted(folder.glob("run*"))
        drives = load_drives(files, folder / "signals.toml")
        assert len(drives) == 2
        assert load_vehicle(folder / "vehicle.toml").trailer is not None


def test_j1939_messages_match_by_their_parameter_group(tmp_path: Path) -> None:
    (tmp_path / "j1939.dbc").write_text(
        'VERSION ""\nNS_ :\nBS_:\nBU_: A\nBO_ 2566844926 CCVS1: 8 A\n'
        ' SG_ WheelBasedVehicleSpeed : 8|16@1+ (0.00390625,0) [0|250.996] "km/h" A\n'
    )
    path = tmp_path / "signals.toml"
    path.write_text('dbc = "j1939.dbc"\n[signals]\nspeed = "WheelBasedVehicleSpeed"\n')
    lines = [f"({100 + n / 10:.6f}) can0 18FEF100#FF00{n:02X}FFFFFFFFFF" for n in range(50)]
    (tmp_path / "truck.log").write_text("\n".join(lines) + "\n")
    speed = load_drive([tmp_path / "truck.log"], path).channels["speed"]
    assert speed.value[-1] == pytest.approx(49.0 / 3.6)


def test_a_real_loggers_mf4_reads(tmp_path: Path) -> None:
    folder = recordings("real", "canedge")
    path = tmp_path / "signals.toml"
    path.write_text(
        f'dbc = "{folder / "canmod-gps.dbc"}"\n[signals]\nspeed = "Speed"\n'
        'car_lateral_acceleration = "AccelerationY"\n'
    )
    drive = load_drive(sorted(folder.glob("*.MF4")), path)
    assert len(drive.channels["car_lateral_acceleration"].value) > 1000
    assert np.all(drive.channels["speed"].value < 60.0)
