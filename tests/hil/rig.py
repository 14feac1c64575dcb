"""The rig: a daemon under test, a bus, and a simulated combination that drives over it.

Runs inside the guest kernel too, so nothing here imports more than numpy and the single track.
"""

from __future__ import annotations

import collections
import json
import os
import select
import signal
import socket
import struct
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import frames as f
import numpy as np

from swaywatch.models.single_track import SingleTrack
from swaywatch.vehicle_file import load_vehicle

ROOT = Path(__file__).resolve().parents[2]
DAEMON = ROOT / "build" / "swaywatchd"
BUS_LOAD = ROOT / "build" / "bus_load"
VEHICLE = ROOT / "tests" / "data" / "practice" / "p01" / "vehicle.toml"
INTERFACE = os.environ.get("HIL_INTERFACE", "vcan0")
SO_TIMESTAMPNS = 35


class Lateness:
    """How late this machine was: by a thread that wants to wake every few ms, and by `note`.

    Real time on a busy machine is not kept, and nothing can be said about a daemon that was not
    given the processor. So it is measured beside each test.
    """

    PERIOD_S = 0.005

    def __init__(self) -> None:
        self.worst_s = 0.0
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self) -> None:
        while True:
            due = time.monotonic() + self.PERIOD_S
            time.sleep(self.PERIOD_S)
            self.note(time.monotonic() - due)

    def note(self, late_s: float) -> None:
        """Somebody was so late."""
        self.worst_s = max(self.worst_s, late_s)

    def restart(self) -> None:
        """Forget what was."""
        self.worst_s = 0.0


LATENESS = Lateness()


def ip(*arguments: str) -> None:
    """``ip ...``, which must work."""
    subprocess.run(["ip", *arguments], check=True, capture_output=True, text=True)


@dataclass
class Seen:
    """One frame seen on the bus."""

    time_s: float  # time.monotonic()
    can_id: int
    data: bytes


class Bus:
    """A raw CAN socket that sends, and a thread that keeps every status frame."""

    def __init__(self, interface: str = INTERFACE) -> None:
        self.interface = interface
        self.out = self._socket()
        self.out.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, b"")
        self.input = self._socket()
        self.seen: collections.deque[Seen] = collections.deque()
        self.not_sent = 0
        self._stop = False
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _socket(self) -> socket.socket:
        s = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        s.bind((self.interface,))
        return s

    def _read(self) -> None:
        self.input.setsockopt(
            socket.SOL_CAN_RAW,
            socket.CAN_RAW_FILTER,
            struct.pack("=IIII", 0x180, 0x780, 0x6E2, 0x7FF),
        )
        while not self._stop:
            if not select.select([self.input], [], [], 0.05)[0]:
                continue
            try:
                raw = self.input.recv(16)
            except OSError:  # the interface is down
                time.sleep(0.01)
                continue
            can_id, length = struct.unpack_from("=IB", raw)
            self.seen.append(Seen(time.monotonic(), can_id, raw[8 : 8 + length]))

    def send(self, frame: bytes) -> bool:
        """One struct can_frame; False where the kernel does not take it (counted)."""
        try:
            self.out.send(frame)
        except OSError:
            self.not_sent += 1
            return False
        return True

    def wait_for(
        self, wanted: Callable[[Seen], bool], timeout_s: float = 5.0, since_s: float | None = None
    ) -> Seen | None:
        """The first frame seen after `since_s` (default: now) that is wanted, or None."""
        since = time.monotonic() if since_s is None else since_s
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            for seen in list(self.seen):
                if seen.time_s >= since and wanted(seen):
                    return seen
            time.sleep(0.005)
        return None

    def close(self) -> None:
        """Stop reading."""
        self._stop = True
        self._thread.join()
        self.input.close()
        self.out.close()


class Daemon:
    """swaywatchd as a process; its counters by SIGUSR1."""

    started: ClassVar[list[Daemon]] = []

    def __init__(self, interface: str = INTERFACE, *options: str) -> None:
        self.lines: list[str] = []
        self.process = subprocess.Popen(
            [
                str(DAEMON),
                "--vehicle",
                str(VEHICLE),
                "--set",
                "car.lateral_acceleration_position=-1.383",
                *options,
                interface,
            ],
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            text=True,
        )
        self.started.append(self)
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()
        assert self.said("running", 5.0), self.lines

    def _read(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.lines.append(line.rstrip())

    def said(self, words: str, timeout_s: float = 2.0, since: int = 0) -> bool:
        """True once a line with these words is on the standard error."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            if any(words in line for line in self.lines[since:]):
                return True
            time.sleep(0.005)
        return False

    def _counts(self, known: int, timeout_s: float = 5.0) -> dict[str, int]:
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            found = [line for line in self.lines if "counts {" in line]
            if len(found) > known:
                return dict(json.loads(found[-1].split("counts ", 1)[1]))
            time.sleep(0.005)
        raise AssertionError(f"no counts: {self.lines[-3:]}")

    def counts(self) -> dict[str, int]:
        """Counters now."""
        known = sum("counts {" in line for line in self.lines)
        self.process.send_signal(signal.SIGUSR1)
        return self._counts(known)

    def stop(self) -> dict[str, int]:
        """End it by SIGTERM; its last counters. It must end with status 0."""
        known = sum("counts {" in line for line in self.lines)
        self.process.send_signal(signal.SIGTERM)
        assert self.process.wait(5.0) == 0
        self._thread.join(2.0)
        return self._counts(known)

    def kill(self) -> None:
        """As the kernel would."""
        self.process.kill()
        self.process.wait(5.0)
        self._thread.join(2.0)


class Plant:
    """The linear single track of the vehicle, stepped in real time; what its sensors measure."""

    def __init__(self, speed_m_s: float, period_s: float) -> None:
        self.model = SingleTrack.of(load_vehicle(VEHICLE))
        self.v_crit = self.model.critical_speed()
        self.period = period_s
        self.state = np.zeros(4)
        self.rng = np.random.default_rng(1)
        self.steer = 0.0
        self.set_speed(speed_m_s)

    def set_speed(self, speed_m_s: float) -> None:
        """Matrices of the bilinear step at this speed."""
        self.speed = speed_m_s
        self.a, self.b = self.model.state_space(speed_m_s)
        half = self.a * (self.period / 2)
        inverse = np.linalg.inv(np.eye(4) - half)
        self.step_a = inverse @ (np.eye(4) + half)
        self.step_b = inverse @ self.b * self.period

    def step(self) -> None:
        """One period, with a little road unevenness."""
        noise = self.rng.standard_normal(2) * 1e-4
        self.state = self.step_a @ self.state + self.step_b * self.steer
        self.state[1:3] += noise * self.period**0.5

    def motion(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Yaw rate and lateral acceleration of car (rear axle) and trailer (COG)."""
        m, x = self.model, self.state
        rate = self.a @ x + self.b * self.steer
        centre = rate[0] + self.speed * x[1]
        trailer = centre - m.lh1 * rate[1] - m.lh2 * (rate[1] + rate[2])
        noise = self.rng.standard_normal(4) * (1e-3, 0.02, 1e-3, 0.02)
        car = (float(x[1] + noise[0]), float(centre - m.lr1 * rate[1] + noise[1]))
        return car, (float(x[1] + x[2] + noise[2]), float(trailer + noise[3]))


Mutation = Callable[[list[bytes]], list[bytes]]


class Feeder(threading.Thread):
    """Plays the plant onto the bus at absolute deadlines.

    `mutate` stands between sensors and bus: faults are put there. `driver` is called each period
    with the plant and the time, and steers or brakes.
    """

    def __init__(self, bus: Bus, speed_m_s: float = 25.0, rate_hz: float = 100.0) -> None:
        super().__init__(daemon=True)
        self.bus = bus
        self.sender = f.Sender()
        self.plant = Plant(speed_m_s, 1.0 / rate_hz)
        self.mutate: Mutation = list
        self.driver: Callable[[Plant, float], None] = swing
        self.sent = 0
        self.periods = 0
        self.worst_late_s = 0.0
        self._stop_asked = False

    def run(self) -> None:
        """Until :meth:`stop`."""
        begin = time.monotonic()
        while not self._stop_asked:
            due = begin + self.periods * self.plant.period
            wait = due - time.monotonic()
            if wait > 0:
                time.sleep(wait)
            else:
                self.worst_late_s = max(self.worst_late_s, -wait)
            self.driver(self.plant, self.periods * self.plant.period)
            self.plant.step()
            car, trailer = self.plant.motion()
            batch = self.sender.motion(self.plant.steer, self.plant.speed, car, trailer)
            self.sent += sum(self.bus.send(frame) for frame in self.mutate(batch))
            self.periods += 1

    def stop(self) -> None:
        """End the drive."""
        self._stop_asked = True
        self.join()
        LATENESS.note(self.worst_late_s)


def end_all() -> int:
    """End what a failed test left running, and how many they were.

    A second ECU or a drive that goes on would spoil every test after it.
    """
    feeders = [t for t in threading.enumerate() if isinstance(t, Feeder)]
    for feeder in feeders:
        feeder.stop()
    left = [d for d in Daemon.started if d.process.poll() is None]
    for daemon in left:
        daemon.kill()
    Daemon.started.clear()
    return len(feeders) + len(left)


def swing(plant: Plant, time_s: float) -> None:
    """A steering impulse every five seconds, so that there is something to see."""
    phase = time_s % 5.0
    plant.steer = 0.33 * np.sin(2 * np.pi * 0.67 * phase) if phase < 0.75 else 0.0


@dataclass
class Report:
    """What each scenario showed; printed at the end of the run."""

    rows: list[dict[str, str]] = field(default_factory=list)

    def add(
        self, scenario: str, said: str, counted: str, right_again_s: float | str | None
    ) -> None:
        """One line of the table."""
        again = right_again_s if isinstance(right_again_s, str) else "never wrong"
        if isinstance(right_again_s, float):
            again = f"after {1000 * right_again_s:.0f} ms"
        self.rows.append(
            {"scenario": scenario, "said": said, "counted": counted, "right again": again}
        )


def inputs_lost(seen: Seen) -> bool:
    """An alarm frame that says that its inputs are lost."""
    return seen.can_id == f.ALARM and bool(seen.data[4] & 2)


def inputs_good(seen: Seen) -> bool:
    """An alarm frame that stands on good inputs."""
    return seen.can_id == f.ALARM and not seen.data[4] & 2


def alarm_state(seen: Seen) -> int:
    """State in an alarm frame."""
    return seen.data[2] & 7


def input_state(seen: Seen, index: int) -> int:
    """State of one message in a SwayInputs frame."""
    return int.from_bytes(seen.data, "little") >> (16 + 2 * index) & 3


def delta(before: dict[str, int], after: dict[str, int]) -> dict[str, int]:
    """Counters that moved."""
    return {k: after[k] - before[k] for k in after if after[k] != before.get(k, 0)}


def counters(counts: dict[str, int], *names: str) -> str:
    """Some counters as text."""
    return ", ".join(f"{name} {counts.get(name, 0)}" for name in names)


def running(feeder: Feeder) -> Iterator[Feeder]:
    """Fixture body: a feeder that drives while the test runs."""
    feeder.start()
    try:
        yield feeder
    finally:
        feeder.stop()
