"""The interface, the controller and the daemon itself fail and come back."""

from __future__ import annotations

import os
import pty
import select
import subprocess
import termios
import threading
import time
import tty
from collections.abc import Iterator
from contextlib import suppress
from fcntl import ioctl
from pathlib import Path

import frames as f
import pytest
import rig

ERROR_FLAG = 0x20000000
NETWORK = Path("/sys/class/net")
TIOCSETD, N_SLCAN = 0x5423, 17
CLASSES = (
    "tx-timeout",
    "arbitration-lost",
    "controller",
    "protocol",
    "transceiver",
    "no-ack",
    "bus-off",
    "bus-error",
    "restarted",
    "error-counters",
)


def recovered(bus: rig.Bus, since_s: float, timeout_s: float = 5.0) -> float:
    """Seconds from `since_s` to the first alarm frame on good inputs."""
    good = bus.wait_for(rig.inputs_good, timeout_s, since_s)
    assert good is not None
    return good.time_s - since_s


def test_interface_down_and_up(bus, daemon, feeder, report):
    """ip link set down, two seconds, up."""
    before = daemon.counts()
    rig.ip("link", "set", rig.INTERFACE, "down")
    assert daemon.said("interface is down")
    time.sleep(2.0)
    rig.ip("link", "set", rig.INTERFACE, "up")
    begin = time.monotonic()
    assert daemon.said("interface is up")
    again = recovered(bus, begin)
    counts = rig.delta(before, daemon.counts())
    report.add(
        "interface down for 2 s",
        "down and up reported",
        rig.counters(counts, "downs", "send_lost", "timeout"),
        again,
    )
    assert counts["downs"] == 1
    assert counts["timeout"] >= 4


def test_interface_removed_and_made_again(report):
    """ip link delete, and a new one of the same name."""
    name = "swhilx"
    rig.ip("link", "add", "dev", name, "type", "vcan")
    rig.ip("link", "set", name, "up")
    daemon = rig.Daemon(name)
    try:
        rig.ip("link", "del", name)
        assert daemon.said("interface is gone") or daemon.said("interface is down")
        time.sleep(0.3)
        rig.ip("link", "add", "dev", name, "type", "vcan")
        rig.ip("link", "set", name, "up")
        begin = time.monotonic()
        assert daemon.said("interface is up")
        bus = rig.Bus(name)
        feeder = rig.Feeder(bus)
        feeder.start()
        again = recovered(bus, begin)
        feeder.stop()
        counts = daemon.stop()
        bus.close()
        report.add(
            "interface deleted and made again",
            "gone and up reported",
            rig.counters(counts, "downs"),
            again,
        )
        assert counts["downs"] == 1
        assert counts["accepted"] > 0
    finally:
        with suppress(subprocess.CalledProcessError):
            rig.ip("link", "del", name)


@pytest.mark.parametrize(
    ("bit", "name"),
    list(enumerate(CLASSES)),
)
def test_error_frames_of_every_class(bus, daemon, bit, name):
    """The kernel's error frames are counted by class and never taken for data."""
    before = daemon.counts()
    for detail in range(8):
        data = bytes((0, 1 << detail, 1 << detail, 0, 1 << detail, 0, 0, 0))
        bus.send(f.can_frame(ERROR_FLAG | 1 << bit, data))
    bus.send(f.can_frame(ERROR_FLAG | 0x1FF, bytes(8)))  # many at once
    time.sleep(0.1)
    counts = rig.delta(before, daemon.counts())
    assert counts["error_frames"] == 9
    assert counts[name] == (9 if 1 << bit & 0x1FF else 8)
    assert "received" not in counts


def test_error_frames_between_data(bus, daemon, feeder, report):
    """A storm of error frames does not touch the data."""
    before, sent_before = daemon.counts(), feeder.sent
    begin = time.monotonic()
    sent = 0
    while time.monotonic() - begin < 1.0:
        sent += sum(bus.send(f.can_frame(ERROR_FLAG | 1 << bit, bytes(8))) for bit in range(10))
        time.sleep(0.005)
    feeder.stop()
    time.sleep(0.1)
    counts = rig.delta(before, daemon.counts())
    report.add(
        f"{sent} error frames of ten classes",
        "bus-off and restart reported each time",
        rig.counters(counts, "error_frames", "accepted", "lost"),
        None,
    )
    assert counts["error_frames"] == sent
    assert abs(counts["accepted"] - (feeder.sent - sent_before)) <= 4  # one batch under way
    assert not {"lost", "crc", "kernel_lost"} & set(counts)


def test_killed_and_started_again(bus, feeder, daemon, report):
    """SIGKILL, and a new daemon."""
    daemon.kill()
    begin = time.monotonic()
    fresh = rig.Daemon()
    again = recovered(bus, begin)
    estimate = bus.wait_for(
        lambda s: s.can_id == f.OSCILLATION and s.data[2:4] != b"\xff\xff", 15.0, begin
    )
    assert estimate is not None
    counts = fresh.stop()
    report.add(
        "daemon killed and started again",
        f"first frequency after {estimate.time_s - begin:.1f} s",
        rig.counters(counts, "lost", "late", "crc"),
        again,
    )
    assert "crc" not in rig.delta(dict.fromkeys(counts, 0), counts)


def test_sigterm_ends_it_cleanly(bus, daemon):
    """Status 0, and what it counted."""
    counts = daemon.stop()
    assert counts["kernel_lost"] == 0


def test_stopped_daemon_tells_what_the_kernel_dropped(bus, daemon, report):
    """The process is held while the bus goes on: SO_RXQ_OVFL says how many were lost."""
    sender = f.Sender()
    before = daemon.counts()
    daemon.process.send_signal(19)  # SIGSTOP
    sent = 0
    begin = time.monotonic()
    while sent < 60000 and time.monotonic() - begin < 20.0:
        sent += bus.send(sender.next(f.SPEED, bytes((40, 35, 0, 0, 0, 0))))
    daemon.process.send_signal(18)  # SIGCONT
    time.sleep(0.5)
    sent += bus.send(sender.next(f.SPEED, bytes((40, 35, 0, 0, 0, 0))))
    time.sleep(0.2)
    counts = rig.delta(before, daemon.counts())
    report.add(
        f"daemon held for {sent} frames",
        "the kernel's losses reported",
        rig.counters(counts, "received", "kernel_lost"),
        "-",
    )
    assert counts["received"] + counts.get("kernel_lost", 0) == sent


class Adapter:
    """A serial CAN adapter: the peer of the kernel's slcan driver, at the other end of a pty."""

    def __init__(self) -> None:
        subprocess.run(["busybox", "modprobe", "slcan"], check=False, capture_output=True)
        known = {path.name for path in NETWORK.iterdir()}
        self.peer, self.line = pty.openpty()
        tty.setraw(self.line)
        attributes = termios.tcgetattr(self.peer)
        attributes[3] &= ~termios.ECHO
        termios.tcsetattr(self.peer, termios.TCSANOW, attributes)
        ioctl(self.line, TIOCSETD, N_SLCAN.to_bytes(4, "little"))
        self.name = ({path.name for path in NETWORK.iterdir()} - known).pop()
        self.heard = b""
        self.deaf = False
        self._stop = False
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        while not self._stop:
            if self.deaf or not select.select([self.peer], [], [], 0.02)[0]:
                time.sleep(0.005)
                continue
            self.heard += os.read(self.peer, 4096)

    def says(self, text: str) -> None:
        """A line from the adapter to the driver."""
        os.write(self.peer, text.encode() + b"\r")

    def frame(self, raw: bytes) -> None:
        """A data frame received from the bus."""
        can_id = int.from_bytes(raw[:4], "little")
        self.says(f"t{can_id:03X}8{raw[8:16].hex().upper()}")

    def close(self) -> None:
        """Take the adapter away."""
        self._stop = True
        self._thread.join()
        os.close(self.line)
        os.close(self.peer)


@pytest.fixture
def adapter() -> Iterator[Adapter]:
    """An adapter whose interface is up at 500 kbit/s."""
    try:
        made = Adapter()
    except (OSError, KeyError) as error:
        pytest.skip(f"no slcan driver in this kernel: {error}")
    rig.ip("link", "set", made.name, "type", "can", "bitrate", "500000")
    rig.ip("link", "set", made.name, "txqueuelen", "10", "up")
    yield made
    with suppress(subprocess.CalledProcessError):
        rig.ip("link", "set", made.name, "down")
    made.close()


def feed(adapter: Adapter, sender: f.Sender, seconds: float) -> None:
    """Sensors on the adapter's bus, 50 Hz."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for raw in sender.motion(0.0, 25.0, (0.0, 0.0), (0.0, 0.0)):
            adapter.frame(raw)
        time.sleep(0.02)


def test_controller_states_and_bus_off(adapter, report):
    """A real controller driver: warning, passive, bus errors, bus-off, and back."""
    daemon = rig.Daemon(adapter.name)
    sender = f.Sender()
    feed(adapter, sender, 0.5)
    for line in ("sw100000", "sp128000", "e1a", "e1s", "e1c", "e1f", "e1b", "sb000256"):
        adapter.says(line)
        time.sleep(0.05)
    assert daemon.said("bus-off")
    at_bus_off = daemon.counts()
    # Recovery: the interface is set down and up, as a supervisor (or restart-ms) would.
    rig.ip("link", "set", adapter.name, "down")
    assert daemon.said("interface is down")
    adapter.heard = b""
    rig.ip("link", "set", adapter.name, "up")
    begin = time.monotonic()
    assert daemon.said("interface is up")
    feed(adapter, sender, 0.5)
    alarms = b"t1A08" in adapter.heard
    counts = daemon.stop()
    report.add(
        "controller: warning, passive, five bus errors, bus-off, restart",
        "bus-off, down and up reported",
        rig.counters(counts, "controller", "bus-error", "bus-off", "downs"),
        None if not alarms else time.monotonic() - begin - 0.5,
    )
    assert at_bus_off["controller"] >= 2
    assert at_bus_off["bus-error"] + at_bus_off["protocol"] >= 5
    assert at_bus_off["bus-off"] == 1
    assert alarms


def test_full_transmit_queue(adapter, report):
    """An adapter that takes nothing for two seconds: ENOBUFS, retried; then all goes on."""
    daemon = rig.Daemon(adapter.name)
    sender = f.Sender()
    feed(adapter, sender, 0.3)
    adapter.deaf = True
    feed(adapter, sender, 6.0)
    full = daemon.counts()
    adapter.deaf = False
    adapter.heard = b""
    feed(adapter, sender, 0.7)
    counts = daemon.stop()
    report.add(
        "transmit queue full", "nothing", rig.counters(counts, "send_retries", "send_lost"), None
    )
    assert full["send_retries"] > 0
    assert counts["sent"] > full["sent"]
    assert counts["lost"] == 0
    assert b"t1A08" in adapter.heard
