"""The trailer remembered from drive to drive: simulated drives through swaywatchd --remember."""

from __future__ import annotations

import argparse
import io
import json
import shutil
import struct
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

import trailer_swap
from rich.console import Console
from trailer_swap import Answer

from swaywatch.cli import main
from swaywatch.commands.monitor import picture, said_of_trailer
from swaywatch.ecu._core import ffi, lib
from swaywatch.ecu.bus import DBC_PATH
from swaywatch.ecu.live import NodeFeed
from swaywatch.ecu.remembered import heard, last_of
from swaywatch.recording import read_recording
from swaywatch.recording.frames import make_frames
from swaywatch.recording.pythoncan import messages
from swaywatch.report.live import LivePage
from swaywatch.vehicle import Vehicle
from swaywatch.vehicle_file import load_vehicle

pytestmark = pytest.mark.skipif(
    not trailer_swap.DAEMON.exists(), reason="build/swaywatchd is not built"
)

SWAP = DATA / "scenarios" / "swap"
CARAVAN = load_vehicle(SWAP / "caravan_vehicle.toml")
SMALLER = load_vehicle(SWAP / "smaller_vehicle.toml")
SIGNALS = """dbc = "{dbc}"
[signals]
steering_wheel_angle = "SteeringWheelAngle"
speed = "VehicleSpeed"
car_yaw_rate = "CarYawRate"
car_lateral_acceleration = {{ signal = "CarLateralAcc", position = -1.383 }}
"""
ALONE = replace(CARAVAN, trailer=None)


@dataclass(frozen=True)
class Garage:
    """The car and the file of its ECU; nothing of a trailer in its vehicle.toml."""

    folder: Path

    @property
    def file(self) -> Path:
        """What the ECU keeps."""
        return self.folder / "trailer.bin"

    def drive(self, vehicle: Vehicle, seed: int) -> Answer:
        """A drive of three minutes with this on the ball."""
        log = self.folder / "drive.log"
        trailer_swap.write_log(vehicle, seed, log)
        rear_m = vehicle.car.rear_axle_to_cog
        return trailer_swap.replayed(SWAP / "car.toml", rear_m, log, self.file)


@pytest.fixture(scope="module")
def left(tmp_path_factory: pytest.TempPathFactory) -> Garage:
    """A file that a drive with the caravan has left."""
    garage = Garage(tmp_path_factory.mktemp("garage"))
    answer = garage.drive(CARAVAN, 1)
    assert (answer.state, answer.writes) == ("new", 1)
    assert answer.learnt_s > 170
    return garage


@pytest.fixture
def garage(left: Garage, tmp_path: Path) -> Garage:
    """The same, to be used up."""
    shutil.copy(left.file, tmp_path)
    return Garage(tmp_path)


def test_another_trailer_is_noticed_and_remembered_from_then_on(garage: Garage) -> None:
    answer = garage.drive(SMALLER, 2)
    assert answer.states == ("unknown", "another")
    assert answer.likeness < -1.0
    assert answer.writes == 1
    assert garage.drive(SMALLER, 3).state == "same"
    assert garage.drive(CARAVAN, 4).state == "another"


def test_the_same_trailer_is_known_again_whatever_the_drive(garage: Garage) -> None:
    for seed in (5, 6):
        answer = garage.drive(CARAVAN, seed)
        assert answer.states == ("unknown", "same")
        assert answer.likeness > 3.0


def bus_of(garage: Garage) -> Path:
    """What a logger on the bus would have of the last drive: sensors and ECU."""
    lines = [
        line
        for name in ("drive.log", "drive.status.log")
        for line in (garage.folder / name).read_text().splitlines()
    ]
    path = garage.folder / "bus.log"
    path.write_text("\n".join(sorted(lines, key=lambda line: line.split(")")[0])) + "\n")
    return path


def test_monitor_its_page_and_trailer_say_it(
    garage: Garage, capsys: pytest.CaptureFixture[str]
) -> None:
    """In plain words, from the frames that the ECU has sent."""
    likeness = garage.drive(SMALLER, 2).likeness
    bus = bus_of(garage)
    car = str(SWAP / "car.toml")
    arguments = ["monitor", str(bus), "--speed", "0", "--vehicle", car]
    assert main([*arguments, "--car-accelerometer", "-1.383"]) == 0
    assert "trailer another" in capsys.readouterr().out
    feed = NodeFeed(load_vehicle(SWAP / "car.toml"), {"car_lateral_acceleration": -1.383})
    page = LivePage(load_vehicle(SWAP / "car.toml"), "test")
    frames = read_recording(bus).frames
    assert frames is not None
    for message in messages(frames):
        feed.receive(message)
    page.note(feed.status(), said_of_trailer(feed))
    words = "this is another trailer than in earlier drives"
    assert words in json.loads(page.state())["trailer"]
    shown = Console(width=200, record=True, file=io.StringIO())
    shown.print(picture(feed, argparse.Namespace(recording=bus)))
    assert words in shown.export_text()
    out = garage.folder / "trailer.json"
    signals = garage.folder / "signals.toml"
    signals.write_text(SIGNALS.format(dbc=DBC_PATH))
    arguments = ["trailer", str(bus), "--vehicle", car, "--signals", str(signals)]
    assert main([*arguments, "--out", str(out)]) == 0
    assert words in " ".join(capsys.readouterr().out.split())
    said = json.loads(out.read_text())["remembered"][str(bus)]
    assert said == {"state": "another", "likeness": likeness, "learnt_s": 179}


def frame(state: int, likeness: int, learnt_s: int) -> bytes:
    data = bytearray(8)
    data[1] = state << 4
    data[2:6] = struct.pack("<hH", likeness, learnt_s)
    buffer = ffi.new("uint8_t[8]", bytes(data))
    lib.sway_e2e_protect(0x6E6, 3, buffer)
    return bytes(ffi.buffer(buffer))


@pytest.mark.parametrize(
    ("state", "likeness", "words"),
    [
        (0, 0, "cannot decide yet"),
        (1, 0, "According to the ECU, no trailer is attached, after 60 s of driving."),
        (2, 0, "a trailer is attached; none is remembered to compare it with"),
        (3, 652, "the one of earlier drives (this drive is 680 times more probable with it"),
        (3, 3000, "over a million times more probable"),
        (4, -150, "another trailer than in earlier drives (this drive is 4.5 times less probable"),
        (4, 20, "another trailer than in earlier drives (this drive is 1.2 times more probable"),
    ],
)
def test_every_state_has_its_words(state: int, likeness: int, words: str) -> None:
    found = heard(0x6E6, False, frame(state, likeness, 60))
    assert found is not None
    assert words in found.sentence


def test_a_damaged_or_foreign_frame_says_nothing() -> None:
    whole = frame(3, 652, 60)
    damaged = bytes([*whole[:3], whole[3] ^ 1, *whole[4:]])
    assert heard(0x6E6, False, damaged) is None
    assert heard(0x6E6, True, whole) is None
    assert heard(0x6E5, False, whole) is None
    assert heard(0x6E6, False, whole[:7]) is None
    rows = np.zeros((3, 8), dtype=np.uint8)
    for row, data in zip(rows, (frame(2, 0, 50), whole, damaged), strict=True):
        row[:] = np.frombuffer(data, dtype=np.uint8)
    frames = make_frames(range(3), [0x6E6] * 3, [False] * 3, [8] * 3, rows, [0] * 3)
    last = last_of(frames)
    assert last is not None
    assert last.state == "same"  # the newest one that is whole
    assert last_of(frames.take(np.array([False, False, True]))) is None


def test_no_trailer_is_said_and_what_was_remembered_stays(garage: Garage) -> None:
    before = garage.file.read_bytes()
    answer = garage.drive(ALONE, 7)
    assert answer.states == ("unknown", "no trailer")
    assert answer.writes == 0
    assert garage.file.read_bytes() == before
    assert garage.drive(CARAVAN, 8).state == "same"
