"""Bad input: a message that says what and where, exit code not 0, nothing written, no traceback."""

from __future__ import annotations

import contextlib
import io
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

from swaywatch.cli import main
from swaywatch.recording import Frames, read_recording, write_recording

P01 = DATA / "practice" / "p01"


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """A copy of the practice case to damage."""
    shutil.copytree(P01, tmp_path / "case")
    shutil.copy(DATA / "practice" / "measurement.dbc", tmp_path / "measurement.dbc")
    return tmp_path / "case"


def analyze(case: Path, recording: str = "run1.blf", *more: str) -> tuple[int, str]:
    """Exit code and message of the command, in this process: a start takes a second each."""
    out = case.parent / "out"
    words = [
        "analyze", str(case / recording), "--vehicle", str(case / "vehicle.toml"),
        "--signals", str(case / "signals.toml"), "--out", str(out), *more,
    ]  # fmt: skip
    said, message = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(message):
        code = main(words)
    assert "Traceback" not in said.getvalue() + message.getvalue()
    assert "internal error" not in message.getvalue()
    if code not in (0, 3):
        assert not out.exists()
    return code, message.getvalue()


def refused(case: Path, *words: str, recording: str = "run1.blf") -> None:
    code, message = analyze(case, recording)
    assert code == 1
    for word in words:
        assert word in message, message


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_no_such_file(case: Path) -> None:
    refused(case, "run9.blf", "no such file", recording="run9.blf")


def test_wrong_format(case: Path) -> None:
    (case / "run1.blf").write_text("this is a letter, not a recording")
    refused(case, "run1.blf", "not a BLF file", "LOGG")


def test_unknown_format(case: Path) -> None:
    shutil.copy(case / "run1.blf", case / "run1.xyz")
    refused(case, "run1.xyz", ".blf", ".mf4", recording="run1.xyz")


def test_truncated_file(case: Path) -> None:
    raw = (case / "run1.blf").read_bytes()
    (case / "run1.blf").write_bytes(raw[: len(raw) // 2])
    refused(case, "run1.blf", "truncated BLF", "byte")


def test_dbc_that_does_not_match(case: Path) -> None:
    dbc = case.parent / "measurement.dbc"
    text = dbc.read_text()
    for number, old in enumerate((194, 416, 688, 696, 784, 785, 786, 787, 800)):
        text = text.replace(f" {old} ", f" {1500 + number} ")
    dbc.write_text(text)
    refused(case, "measurement.dbc", "does not match", "0xC2")


def test_dbc_that_is_missing(case: Path) -> None:
    (case.parent / "measurement.dbc").unlink()
    refused(case, "measurement.dbc", "no such file")


def test_missing_role(case: Path) -> None:
    edit(case / "signals.toml", 'car_yaw_rate = "YawRate1"\n', "")
    refused(case, "signals.toml", "car_yaw_rate")


def test_wrong_unit(case: Path) -> None:
    edit(case.parent / "measurement.dbc", '(0.01,0) [0|400] "km/h"', '(0.01,0) [0|400] "m/s"')
    refused(case, "VehicleSpeed", "km/h")


def test_wrong_unit_of_an_angle(case: Path) -> None:
    edit(
        case / "signals.toml",
        'trailer_yaw_rate = "YawRate2"',
        'trailer_yaw_rate = { signal = "YawRate2", unit = "rad/s" }',
    )
    refused(case, "YawRate2", "in deg/s, not in rad/s")


def test_wrong_sign(case: Path) -> None:
    edit(
        case / "signals.toml",
        'hitch_lateral_force = "HitchFy"',
        'hitch_lateral_force = { signal = "HitchFy", sign = -1 }',
    )
    refused(case, "HitchFy", "sign is wrong", "sign = -1")


def test_wrong_sign_may_be_analysed_all_the_same(case: Path) -> None:
    edit(
        case / "signals.toml",
        'hitch_lateral_force = "HitchFy"',
        'hitch_lateral_force = { signal = "HitchFy", sign = -1 }',
    )
    code, _ = analyze(case, "run1.blf", "--ignore-quality")
    assert code == 0


def test_empty_recording(case: Path) -> None:
    frames = read_recording(case / "run1.blf").frames
    assert frames is not None
    write_recording(case / "run1.blf", frames.take(slice(0, 0)))
    refused(case, "run1.blf", "empty")


def test_two_speeds_of_clock(case: Path) -> None:
    frames = read_recording(case / "run1.blf").frames
    assert frames is not None
    start, half = frames.time_ns[0], frames.time_ns[len(frames) // 2]
    time_ns = np.where(frames.time_ns > half, half + 2 * (frames.time_ns - half), frames.time_ns)
    assert time_ns[0] == start
    odd = Frames(
        time_ns, frames.identifier, frames.extended, frames.length, frames.data, frames.bus
    )
    write_recording(case / "run1.blf", odd)
    refused(case, "run1.blf", "clock")


def test_blf_with_an_object_of_size_0(case: Path) -> None:
    raw = bytearray((case / "run1.blf").read_bytes())
    (header,) = struct.unpack_from("<L", raw, 4)
    struct.pack_into("<L", raw, header + 8, 0)
    (case / "run1.blf").write_bytes(raw)
    refused(case, "run1.blf", "size 0")


def test_candump_with_error_frames_and_dropcount_lines(case: Path) -> None:
    frames = read_recording(case / "run1.blf").frames
    assert frames is not None
    write_recording(case / "run1.log", frames)
    lines = (case / "run1.log").read_text().splitlines()
    stamp = lines[10000].split()[0]
    lines[10001:10041] = [
        f"{stamp} can0 20000088#0000000000000000",
        "DROPCOUNT: dropped 39 CAN frames on 'can0' socket (total drops 39)",
    ]
    (case / "run1.log").write_text("\n".join(lines) + "\n")
    code, message = analyze(case, "run1.log")
    assert code == 3
    assert "lost 39 frames" in message
    assert (case.parent / "out" / "report.html").exists()
    code, _ = analyze(case, "run1.log", "--accept-losses")
    assert code == 0


@pytest.mark.parametrize("name", ["signals.toml", "vehicle.toml"])
def test_bytes_that_are_not_utf8(case: Path, name: str) -> None:
    raw = (case / name).read_bytes()
    (case / name).write_bytes(b"# Gr\xfc\xdfe\n" + raw)
    refused(case, name, "UTF-8")


def test_candump_with_bytes_that_are_not_utf8(case: Path) -> None:
    (case / "run1.log").write_bytes(b"(1.0) can0 123#00\n(1.1) can0 1\xff3#00\n")
    refused(case, "run1.log", "line 2", "UTF-8", recording="run1.log")


def test_vehicle_out_of_range(case: Path) -> None:
    edit(case / "vehicle.toml", "mass = 1955", "mass = 1.955")
    refused(case, "vehicle.toml", "mass", "1.955", "kg")


def test_output_folder_that_cannot_be_written(case: Path) -> None:
    blocker = case.parent / "out"
    blocker.write_text("a file where a folder should be")
    command = [
        sys.executable, "-m", "swaywatch.cli", "analyze", str(case / "run1.blf"),
        "--vehicle", str(case / "vehicle.toml"), "--signals", str(case / "signals.toml"),
        "--out", str(blocker),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 1
    assert "cannot be written" in done.stderr
    assert "Traceback" not in done.stderr


def test_wrong_usage() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "swaywatch.cli", "analyze"],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 2
