"""Formats of viewers and of MATLAB: round trips, foreign files, damaged ones; merged channels."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA
from scipy.io import loadmat, savemat

from swaywatch.cli import main
from swaywatch.errors import RecordingError
from swaywatch.recording import Series, read_recording, write_recording

P01 = DATA / "practice" / "p01"


def series(count: int = 200, start_ns: int = 1_700_000_000_000_000_000) -> dict[str, Series]:
    time = start_ns + 10_000_000 * np.arange(count)
    return {
        "Yaw.Rate1": Series(time, np.sin(np.arange(count) / 9.0), "rad/s"),
        "Speed": Series(time, np.full(count, 27.3), "m/s"),
        "a signal with a name that is longer than 31": Series(time[::2], np.ones(count // 2), "N"),
    }


def analyzed(out: Path, recording: Path, signals: Path, *more: str) -> int:
    """``swaywatch analyze`` without a page."""
    toml = ["--vehicle", str(P01 / "vehicle.toml"), "--signals", str(signals / "signals.toml")]
    return main(["analyze", str(recording), *toml, "--no-report", "--out", str(out), *more])


@pytest.mark.parametrize("suffix", [".mat", ".mcap"])
def test_round_trip(tmp_path: Path, suffix: str) -> None:
    given = series()
    write_recording(tmp_path / f"x{suffix}", given)
    found = read_recording(tmp_path / f"x{suffix}").signals
    assert found is not None
    assert sorted(found) == sorted(given)
    for name, one in given.items():
        assert np.abs(found[name].time_ns - one.time_ns).max() <= 200
        np.testing.assert_array_equal(found[name].value, one.value)
        assert found[name].unit == one.unit


def test_analysis_is_the_same(tmp_path: Path) -> None:
    """The roles of a recording, written and read again, give the same estimates."""
    out = {}
    for kind in (".parquet", ".mat", ".mcap"):
        merged = tmp_path / f"roles{kind}"
        assert analyzed(tmp_path / "first", P01 / "run1.blf", P01, "--merge", str(merged)) == 0
        signals = read_recording(merged).signals
        assert signals is not None
        roles = [name for name in signals if not name.startswith("swaywatch.")]
        wheels = ("_fl", "_fr", "_rl", "_rr")
        lines = [f'{name} = "{name}"' for name in roles if not name.endswith(wheels)]
        for force in ("wheel_lateral_force", "wheel_vertical_load"):
            names = ", ".join(f'"{force}{wheel}"' for wheel in wheels)
            lines.append(f"{force} = [{names}]")
        for body, position in (("car", -1.383), ("trailer", 0.0)):
            name = f"{body}_lateral_acceleration"
            lines = [x for x in lines if not x.startswith(name)]
            lines.append(f'{name} = {{ signal = "{name}", position = {position} }}')
        (tmp_path / "signals.toml").write_text("[signals]\n" + "\n".join(lines) + "\n")
        folder = tmp_path / f"again{kind}"
        assert analyzed(folder, merged, tmp_path) == 0
        out[kind] = json.loads((folder / "summary.json").read_text())["drives"][0]["values"]
    for name, value in out[".parquet"].items():
        for kind in (".mat", ".mcap"):
            assert out[kind][name]["value"] == pytest.approx(value["value"], rel=1e-4, abs=1e-6)


def test_merged_channels_open_in_asammdf(tmp_path: Path) -> None:
    from asammdf import MDF

    path = tmp_path / "merged.mf4"
    main(["analyze", str(P01 / "run1.blf"), str(P01 / "run2.blf"), "--vehicle",
          str(P01 / "vehicle.toml"), "--signals", str(P01 / "signals.toml"), "--no-report",
          "--out", str(tmp_path / "out"), "--merge", str(path)])  # fmt: skip
    with MDF(tmp_path / "merged_run1.mf4") as mdf:
        rate, estimate = mdf.get("car_yaw_rate"), mdf.get("swaywatch.frequency_hz")
        assert (rate.unit, estimate.unit) == ("rad/s", "Hz")
        assert "measured, YawRate1" in rate.comment
        assert "estimated" in estimate.comment
        assert estimate.timestamps[0] >= 0.0
        assert estimate.timestamps[-1] <= rate.timestamps[-1]
    assert (tmp_path / "merged_run2.mf4").exists()


def test_plain_vectors_of_a_script(tmp_path: Path) -> None:
    path = tmp_path / "script.mat"
    time = np.arange(0.0, 2.0, 0.01)
    savemat(path, {"t": time[:, None], "yaw": np.sin(time)[:, None], "mass": 1955.0})
    found = read_recording(path).signals
    assert found is not None
    assert list(found) == ["yaw"]
    assert len(found["yaw"].value) == len(time)
    savemat(path, {"t": time, "time": time, "yaw": time})
    with pytest.raises(RecordingError, match="several vectors of time"):
        read_recording(path)


def test_matlab_accepts_the_names(tmp_path: Path) -> None:
    path = tmp_path / "x.mat"
    write_recording(path, series())
    names = [name for name in loadmat(path) if not name.startswith("__")]
    assert all(name.isidentifier() and len(name) <= 31 for name in names)


@pytest.mark.parametrize("suffix", [".mat", ".mcap"])
def test_damage_is_one_sentence(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"x{suffix}"
    write_recording(path, series())
    data = bytearray(path.read_bytes())
    random = np.random.default_rng(1)
    for cut in (len(data) // 2, len(data) - 3, 60):
        path.write_bytes(data[:cut])
        with pytest.raises(RecordingError, match=path.name):
            read_recording(path)
    for _ in range(60):
        damaged = bytearray(data)
        damaged[int(random.integers(len(data)))] ^= 1 << int(random.integers(8))
        path.write_bytes(damaged)
        with suppress(RecordingError):  # what is damaged is named, or does not matter
            read_recording(path)


def test_matlab_7_3_is_named(tmp_path: Path) -> None:
    path = tmp_path / "x.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512, b"\0"))
    with pytest.raises(RecordingError, match=r"save it with save\(\.\.\., '-v7'\)"):
        read_recording(path)


def test_a_foreign_mcap_of_json(tmp_path: Path) -> None:
    from mcap.writer import Writer

    path = tmp_path / "x.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel("/imu", "json", 0)
        other = writer.register_channel("/image", "cdr", 0)
        for k in range(20):
            content = json.dumps({"rate": {"z": 0.1 * k}, "frame": "car"}).encode()
            writer.add_message(channel, 10_000_000 * k, content, 0)
            writer.add_message(other, 10_000_000 * k, b"\0", 0)
        writer.finish()
    found = read_recording(path)
    assert found.signals is not None
    assert list(found.signals) == ["/imu/rate.z"]
    assert "/image (cdr)" in found.notes[0]
