"""The node through cffi and the live view."""

from __future__ import annotations

import subprocess
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import can
import numpy as np
import pytest
from can.interfaces.virtual import channels as virtual_channels
from conftest import DATA

from swaywatch.cli import main
from swaywatch.drive import load_drive
from swaywatch.ecu.bus import MESSAGES, database, encode_drive
from swaywatch.ecu.core import Core, integer_samples, positions_of
from swaywatch.ecu.node import Node
from swaywatch.recording import Frames, read_recording, write_recording
from swaywatch.recording.dbc import frames_by_identifier
from swaywatch.recording.pythoncan import messages
from swaywatch.roles import CHANNELS
from swaywatch.vehicle_file import load_vehicle

P01 = DATA / "practice" / "p01"
ROOT = Path(__file__).resolve().parents[2]
VEHICLE = load_vehicle(P01 / "vehicle.toml")
DRIVE = load_drive([P01 / "run1.blf"], P01 / "signals.toml")


@pytest.fixture(scope="module")
def frames() -> Frames:
    return encode_drive(DRIVE)


def test_every_input_of_the_core_is_on_the_bus() -> None:
    carried = {entry[0] for entries in MESSAGES.values() for entry in entries}
    assert {name for name, kind in CHANNELS.items() if kind.core_input} <= carried


def test_encoded_channels_come_back(frames: Frames) -> None:
    rows = frames_by_identifier(frames)
    for name, entries in MESSAGES.items():
        for channel, signal, _, factor in entries:
            if channel not in DRIVE.channels:
                continue
            message, description = database().messages[name], signal
            found = message.get_signal_by_name(description)
            decoded = database().decode(frames, rows[message.frame_id, False], message, found)
            expected = DRIVE.channels[channel].value * factor
            assert np.abs(decoded.series.value - expected).max() <= 0.51 * found.scale


def test_the_node_accepts_every_frame(frames: Frames) -> None:
    node = Node(VEHICLE, positions_of(DRIVE))
    out = node.replay(frames)
    assert len(out) > 1000
    assert set(node.fault_count().values()) == {0}
    assert not node.inputs_lost
    assert node.status()["v_crit_mm_s"][0] * 3.6e-3 == pytest.approx(123.34, abs=2.0)


def test_one_frame_at_a_time_gives_the_same_bytes(frames: Frames) -> None:
    whole = Node(VEHICLE, positions_of(DRIVE)).replay(frames)
    node = Node(VEHICLE, positions_of(DRIVE))
    single: list[tuple[int, bytes]] = []
    for message in messages(frames):
        node.receive(round(message.timestamp * 1e6), message.arbitration_id, False,
                     bytes(message.data))  # fmt: skip
        single += node.transmit()
    assert [identifier for identifier, _ in single] == whole.identifier.tolist()
    assert b"".join(data for _, data in single) == whole.data.tobytes()


def test_a_damaged_frame_is_counted_and_left_out(frames: Frames) -> None:
    data = frames.data.copy()
    data[5000, 3] ^= 1
    odd = Frames(
        frames.time_ns, frames.identifier, frames.extended, frames.length, data, frames.bus
    )
    node = Node(VEHICLE, positions_of(DRIVE))
    node.replay(odd)
    faults = node.fault_count()
    assert faults["crc"] == 1
    assert faults["lost"] == 1


@pytest.mark.parametrize("run", ["run1", "run2"])
def test_the_daemon_sends_the_same_bytes(tmp_path: Path, run: str) -> None:
    daemons = sorted((ROOT / "build").glob("*/socketcan/swaywatchd")) or sorted(
        (ROOT / "build").rglob("swaywatchd")
    )
    daemons = [path for path in daemons if path.is_file()]
    if not daemons:
        pytest.skip("swaywatchd is not built here (make builds it)")
    drive = load_drive([P01 / f"{run}.blf"], P01 / "signals.toml")
    log = tmp_path / "run.log"
    write_recording(log, encode_drive(drive))
    done = subprocess.run(
        [str(daemons[0]), "--vehicle", str(P01 / "vehicle.toml"),
         "--set", "car.lateral_acceleration_position=-1.383", "--replay", str(log)],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    path = tmp_path / "status.log"
    path.write_text(done.stdout)
    theirs = read_recording(path).frames
    again = read_recording(log).frames
    assert theirs is not None
    assert again is not None
    theirs = theirs.take(theirs.identifier != 0x6E2)  # the port's own report, not the node's
    ours = Node(VEHICLE, positions_of(drive)).replay(again)
    assert len(ours) > 1000
    assert theirs.identifier.tolist() == ours.identifier.tolist()
    assert theirs.data.tobytes() == ours.data.tobytes()
    assert np.array_equal(theirs.time_ns // 1000, ours.time_ns // 1000)


def test_feeding_in_bulk_is_feeding_one_by_one() -> None:
    bulk, _ = Core(VEHICLE, positions_of(DRIVE)).feed(DRIVE)
    core = Core(VEHICLE, positions_of(DRIVE))
    samples: list[tuple[int, int, str, float]] = []
    for name, channel in DRIVE.channels.items():
        time_us, _ = integer_samples(channel)
        samples += [
            (t, i, name, v) for i, (t, v) in enumerate(zip(time_us, channel.value, strict=True))
        ]
    order = {name: number for number, name in enumerate(DRIVE.channels)}
    samples.sort(key=lambda sample: (sample[0], order[sample[2]], sample[1]))
    for time_us, _, name, value in samples[:160_00]:
        core.input(name, time_us * 1e-6, float(value))
    status = core.status()
    same = bulk[bulk["sequence"] == status["sequence"][0]]
    for field in ("frequency_uhz", "v_crit_mm_s", "time_us", "alarm", "valid"):
        assert same[field][0] == status[field][0]


@pytest.mark.parametrize("own", [True, False])
def test_monitor_shows_the_state_of_a_live_bus(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, frames: Frames, own: bool
) -> None:
    """Its duration is over when all has been taken from the bus, on a slow machine too."""
    channel = f"swaywatch-test-{own}"
    sent = frames if own else read_recording(P01 / "run1.blf").frames
    assert sent is not None
    sent = sent.take(slice(0, 14000))  # 15 s of driving, sent at once
    offset = time.time() - sent.time_ns[0] * 1e-9
    now = [0.0]
    clock = SimpleNamespace(time=time.time, monotonic=lambda: now[0])
    monkeypatch.setattr("swaywatch.commands.monitor.time", clock)

    def send() -> None:
        while not virtual_channels.get(channel):
            time.sleep(0.02)
        (listening,) = virtual_channels[channel]
        with can.Bus(interface="virtual", channel=channel, preserve_timestamps=True) as bus:
            for message in messages(sent):
                message.timestamp += offset
                bus.send(message)
            now[0] = 14.9
            while not listening.empty():
                time.sleep(0.02)
            now[0] = 15.0

    sender = threading.Thread(target=send, daemon=True)
    sender.start()
    arguments = ["monitor", "--interface", "virtual", "--channel", channel, "--duration", "15",
                 "--vehicle", str(P01 / "vehicle.toml")]  # fmt: skip
    if own:
        arguments += ["--car-accelerometer", "-1.383"]
    else:
        arguments += ["--signals", str(P01 / "signals.toml")]
    code = main(arguments)
    sender.join()
    assert code == 0
    last = capsys.readouterr().out.strip().splitlines()[-1]
    assert "frames used 14000" in last
    critical = float(last.split("v_crit ")[1].split()[0])
    assert critical == pytest.approx(123.3, abs=2.0)


def test_a_bus_that_cannot_be_opened_is_said_so(capsys: pytest.CaptureFixture[str]) -> None:
    code = main(
        ["monitor", "--interface", "nonsense", "--channel", "can7",
         "--vehicle", str(P01 / "vehicle.toml")]
    )  # fmt: skip
    assert code == 1
    message = capsys.readouterr().err
    assert "nonsense" in message
    assert "can7" in message
