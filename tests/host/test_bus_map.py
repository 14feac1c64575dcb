"""`swaywatch map`: the ECU hears a car's own bus, through the map and nothing else."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA
from production_bus import FOLDER, LWS_ID, PROTECTION, SIGNALS, frames_of

from swaywatch.cli import main
from swaywatch.drive import load_drive
from swaywatch.ecu.bus import database, encode_drive
from swaywatch.ecu.bus_map import make_map
from swaywatch.errors import SignalError
from swaywatch.recording import read_recording, write_recording

P01 = DATA / "practice" / "p01"
DAEMON = DATA.parents[1] / "build" / "swaywatchd"
WHERE = "car.lateral_acceleration_position=-1.383"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A map by the command."""
    path = tmp_path_factory.mktemp("map") / "car.map"
    assert main(["map", "--signals", str(SIGNALS), "--protection", str(PROTECTION),
                 "--out", str(path)]) == 0  # fmt: skip
    return path


def replay(log: Path, *options: str) -> tuple[dict[str, int], str, int]:
    """Counters, status frames and exit status of the daemon over a log."""
    done = subprocess.run(
        [DAEMON, "--vehicle", P01 / "vehicle.toml", "--set", WHERE, *options, "--replay", log],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    counts = [line for line in done.stderr.splitlines() if "counts {" in line]
    return (json.loads(counts[-1].split("counts ", 1)[1]) if counts else {},
            done.stdout if counts else done.stderr, done.returncode)  # fmt: skip


def last_values(log: Path, message: str, signal: str) -> np.ndarray:
    """Values of a status signal over time, shape (n,)."""
    kind = database().messages[message]
    frames = read_recording(log).frames
    assert frames is not None
    rows = np.flatnonzero(frames.identifier == kind.frame_id)
    return np.array([
        float(kind.decode(bytes(frames.data[r, : kind.length]), decode_choices=False)[signal])
        for r in rows
    ])  # fmt: skip


@pytest.mark.skipif(not DAEMON.exists(), reason="build/swaywatchd is not built")
def test_it_hears_the_cars_own_bus_as_it_hears_ours(made: Path, tmp_path: Path) -> None:
    """The same drive through a foreign DBC and through our own frames: the same frequency."""
    foreign, ours = tmp_path / "car.log", tmp_path / "ours.log"
    frames = frames_of(P01 / "run1.blf", P01 / "signals.toml")
    write_recording(foreign, frames)
    only = tmp_path / "signals.toml"
    lines = (P01 / "signals.toml").read_text().replace("../", f"{P01.parent}/").splitlines()
    only.write_text("\n".join(s for s in lines if not s.startswith(("trailer", "wheel", "hitch"))))
    write_recording(ours, encode_drive(load_drive([P01 / "run1.blf"], only)))
    found = {}
    for name, log, options in (("foreign", foreign, ("--map", str(made))), ("ours", ours, ())):
        counts, status, code = replay(log, *options)
        assert code == 0, status
        assert counts["crc"] == counts["unknown_id"] == counts["repeated"] == counts["range"] == 0
        assert counts["accepted"] > 10000
        (tmp_path / f"{name}.status.log").write_text(status)
        found[name] = last_values(tmp_path / f"{name}.status.log", "SwayOscillation", "Frequency")
    assert len(found["foreign"]) == pytest.approx(len(found["ours"]), rel=0.1)
    middle = {name: float(np.median(value[value > 0.0])) for name, value in found.items()}
    assert middle["foreign"] == pytest.approx(middle["ours"], rel=0.02)
    counts, _, code = replay(foreign)
    assert code == 1
    assert counts["accepted"] == 0


@pytest.mark.skipif(not DAEMON.exists(), reason="build/swaywatchd is not built")
def test_damaged_and_repeated_frames_are_counted(made: Path, tmp_path: Path) -> None:
    frames = frames_of(P01 / "run1.blf", P01 / "signals.toml")
    rows = np.flatnonzero(frames.identifier == LWS_ID)
    frames.data[rows[100], 0] ^= 1
    frames.data[rows[201]] = frames.data[rows[200]]
    write_recording(tmp_path / "car.log", frames)
    counts, _, _ = replay(tmp_path / "car.log", "--map", str(made))
    assert (counts["crc"], counts["repeated"]) == (1, 1)


@pytest.mark.skipif(not DAEMON.exists(), reason="build/swaywatchd is not built")
def test_a_damaged_map_is_refused(made: Path, tmp_path: Path) -> None:
    content = bytearray(made.read_bytes())
    for at, value, said in ((0, 9, "no map of version 1"), (12 + 4, 9, "message 0 (0xB4)")):
        wrong = bytearray(content)
        wrong[at] = value
        (tmp_path / "wrong.map").write_bytes(wrong)
        assert said in replay(P01 / "none.log", "--map", str(tmp_path / "wrong.map"))[1]
    (tmp_path / "wrong.map").write_bytes(content[:-1])
    assert "a map has" in replay(P01 / "none.log", "--map", str(tmp_path / "wrong.map"))[1]


def test_the_words_say_what_the_dbc_says(made: Path) -> None:
    """Factor and range of each signal: 0.1 deg to the right, 0.01 m/s2 from -20.48, 4095: none."""
    found = make_map(SIGNALS, PROTECTION)
    assert [m.name for m in found.messages] == ["LWS_Standard", "ESP_Speed", "ESP_Motion"]
    steering, _, _, acceleration = found.signals
    assert steering[6] / steering[7] == pytest.approx(-0.1 * np.pi / 180.0 * 1e6, rel=1e-9)
    assert acceleration[6:9] == (10000, 1, -20480000)
    assert acceleration[9:] == (0, 4094)
    assert found.positions == {"car_lateral_acceleration": -1.383}


def test_what_no_map_can_hold_is_reported(tmp_path: Path) -> None:
    (tmp_path / "production.dbc").write_text((FOLDER / "production.dbc").read_text())
    signals = tmp_path / "signals.toml"
    text = SIGNALS.read_text()
    for old, new, said in (
        ('"ESP_YawRate"', '"ESP_YawRat"', "no DBC has such a signal"),
        ('"ESP_VehicleSpeed"', '["ESP_VehicleSpeed", "ESP_YawRate"]', "a mean of signals"),
        ('"ESP_VehicleSpeed"', '"ESP_YawRate"', "has the unit 'deg/s', but speed needs"),
    ):
        signals.write_text(text.replace(old, new))
        with pytest.raises(SignalError, match=said):
            make_map(signals)
    signals.write_text(text)
    for old, new, said in (
        ("BO_ 180 ", "BO_ 288 ", r"LWS_Standard \(0x120\) cannot be in a map"),
        ("BO_ 180 ", "BO_ 2147483828 ", "29 bits"),
        ("ESP_YawRate : 6|15@0-", "ESP_YawRate : 39|32@0-", "32 bits; a map takes 31"),
    ):
        dbc = (FOLDER / "production.dbc").read_text()
        (tmp_path / "production.dbc").write_text(dbc.replace(old, new))
        with pytest.raises(SignalError, match=said):
            make_map(signals)
    (tmp_path / "production.dbc").write_text((FOLDER / "production.dbc").read_text())
    guard = tmp_path / "guard.toml"
    for wrong, said in (
        ("[ESP]\ncounter = 'X'", "no role is in a message 'ESP'"),
        ("[LWS_Standard]\ncounter = 'X'", "has no signal 'X'"),
        ("[LWS_Standard]\ncrc = 'LWS_Counter'", "must be one byte"),
        ("[LWS_Standard]\ncrc_start = 300", "must be 0 to 255"),
        ("[LWS_Standard]\ncolour = 1", "knows counter, crc"),
    ):
        guard.write_text(wrong)
        with pytest.raises(SignalError, match=said):
            make_map(signals, guard)
