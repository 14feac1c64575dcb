"""Faults of frames: each is injected a known number of times, and must be counted exactly."""

from __future__ import annotations

import random
import struct
import threading
import time
from collections.abc import Callable

import frames as f
import pytest
import rig


def identifier(frame: bytes) -> int:
    """Identifier of a struct can_frame."""
    return int(struct.unpack_from("=I", frame)[0])


class Fault:
    """Injects a fault into a number of batches, then lets everything through again."""

    def __init__(self, batches: int, change: Callable[[list[bytes], int], list[bytes]]) -> None:
        self.left = batches
        self.change = change
        self.number = 0
        self.done = threading.Event()

    def __call__(self, batch: list[bytes]) -> list[bytes]:
        if self.left == 0:
            self.done.set()
            return batch
        self.left -= 1
        self.number += 1
        return self.change(batch, self.number - 1)


def inject(
    feeder: rig.Feeder, daemon: rig.Daemon, fault: Fault, settle_s: float = 0.3
) -> tuple[dict[str, int], float, float]:
    """Counters that moved, and the times at which the fault began and ended."""
    before = daemon.counts()
    begin = time.monotonic()
    feeder.mutate = fault
    assert fault.done.wait(20.0)
    end = time.monotonic()
    feeder.mutate = list
    time.sleep(settle_s)
    return rig.delta(before, daemon.counts()), begin, end


def right_again(bus: rig.Bus, begin: float, end: float) -> float | None:
    """Seconds from the end of a fault to an alarm frame on good inputs; None: never wrong."""
    good = bus.wait_for(rig.inputs_good, since_s=end)
    assert good is not None
    wrong = [s for s in list(bus.seen) if s.time_s >= begin and rig.inputs_lost(s)]
    return good.time_s - end if wrong else None


def test_lost(bus, daemon, feeder, report):
    """Three of ten batches are lost whole, single frames at random besides."""
    chance = random.Random(1)
    lost = 0

    def drop(batch: list[bytes], number: int) -> list[bytes]:
        nonlocal lost
        kept = [] if number % 10 in (3, 4, 5) else [x for x in batch if chance.random() > 0.1]
        if number == 199:
            kept = batch  # the last one arrives, so that all gaps are closed
        lost += len(batch) - len(kept)
        return kept

    counts, begin, end = inject(feeder, daemon, Fault(200, drop))
    report.add(
        "frames lost",
        f"{lost} withheld",
        rig.counters(counts, "lost", "late", "timeout"),
        right_again(bus, begin, end),
    )
    assert counts["lost"] == lost
    assert "late" not in counts
    assert "repeated" not in counts


def test_long_loss_times_out(bus, daemon, feeder, report):
    """Half a second of nothing: the alarm goes off with its reason, and comes back."""
    counts, begin, end = inject(feeder, daemon, Fault(50, lambda batch, n: []))
    off = bus.wait_for(rig.inputs_lost, since_s=begin)
    assert off is not None
    assert rig.alarm_state(off) == 0
    after = f"InputsLost after {1000 * (off.time_s - begin):.0f} ms"
    report.add(
        "bus silent for 0.5 s",
        after,
        rig.counters(counts, "timeout", "lost"),
        right_again(bus, begin, end),
    )
    assert counts["timeout"] == 4
    assert counts["lost"] == 200


def test_doubled(bus, daemon, feeder, report):
    """Every frame twice."""
    counts, begin, end = inject(
        feeder, daemon, Fault(100, lambda batch, n: [x for y in batch for x in (y, y)])
    )
    report.add(
        "frames doubled",
        "400 doubled",
        rig.counters(counts, "repeated", "lost"),
        right_again(bus, begin, end),
    )
    assert counts["repeated"] == 400
    assert "lost" not in counts
    assert "stuck" not in counts


def test_reordered(bus, daemon, feeder, report):
    """Pairs of batches change places: one is found missing, then comes late."""
    kept: list[bytes] = []

    def swap(batch: list[bytes], number: int) -> list[bytes]:
        nonlocal kept
        if number % 2 == 0:
            kept = batch
            return []
        return batch + kept

    counts, begin, end = inject(feeder, daemon, Fault(100, swap))
    report.add(
        "frames reordered",
        "200 out of order",
        rig.counters(counts, "late", "lost"),
        right_again(bus, begin, end),
    )
    assert counts["late"] == 200
    assert counts["lost"] == 200


def test_late(bus, daemon, feeder, report):
    """Frames 50 ms late are not mixed with newer ones."""
    held: list[list[bytes]] = []

    def hold(batch: list[bytes], number: int) -> list[bytes]:
        held.append(batch[2:3])
        late = held.pop(0) if len(held) > 5 else []
        return batch + (late if number % 5 == 0 else [])

    counts, begin, end = inject(feeder, daemon, Fault(100, hold))
    report.add(
        "frames again 50 ms late",
        "19 late",
        rig.counters(counts, "late", "lost"),
        right_again(bus, begin, end),
    )
    assert counts["late"] == 19
    assert "lost" not in counts


def test_corrupted(bus, daemon, feeder, report):
    """Single bits flip anywhere in the frame."""
    chance = random.Random(2)
    flipped = 0

    def flip(batch: list[bytes], number: int) -> list[bytes]:
        nonlocal flipped
        result = []
        for frame in batch:
            raw = bytearray(frame)
            if chance.random() < 0.3:
                raw[8 + chance.randrange(8)] ^= 1 << chance.randrange(8)
                flipped += 1
            result.append(bytes(raw))
        return result

    counts, begin, end = inject(feeder, daemon, Fault(100, flip))
    report.add(
        "frames corrupted",
        f"{flipped} bits flipped",
        rig.counters(counts, "crc", "lost"),
        right_again(bus, begin, end),
    )
    assert counts["crc"] == flipped
    assert counts["lost"] <= flipped


def test_wrong_crc_for_long(bus, daemon, feeder, report):
    """A sensor whose CRC is always wrong is not believed."""

    def spoil(batch: list[bytes], number: int) -> list[bytes]:
        raw = bytearray(batch[2])
        raw[8] ^= 0xFF
        return [*batch[:2], bytes(raw), batch[3]]

    counts, begin, end = inject(feeder, daemon, Fault(50, spoil))
    off = bus.wait_for(rig.inputs_lost, since_s=begin)
    assert off is not None
    report.add(
        "car motion with a wrong CRC",
        f"InputsLost after {1000 * (off.time_s - begin):.0f} ms",
        rig.counters(counts, "crc", "timeout"),
        right_again(bus, begin, end),
    )
    assert counts["crc"] == 50
    assert counts["timeout"] == 1


def test_wrong_length(bus, daemon, feeder, report):
    """Frames of seven bytes, of none."""

    def cut(batch: list[bytes], number: int) -> list[bytes]:
        return [frame[:4] + bytes((7 * (number % 2),)) + frame[5:] for frame in batch]

    counts, begin, end = inject(feeder, daemon, Fault(5, cut))
    report.add(
        "wrong length",
        "20 frames of 0 or 7 bytes",
        rig.counters(counts, "length"),
        right_again(bus, begin, end),
    )
    assert counts["length"] == 20


def test_stuck_counter(bus, daemon, feeder, report):
    """The trailer's sensor goes on sending with a counter that stands."""
    first: list[bytes] = []

    def stick(batch: list[bytes], number: int) -> list[bytes]:
        if not first:
            first.append(batch[3])
        counter = first[0][9] & 15
        return [
            *batch[:3],
            f.can_frame(f.TRAILER_MOTION, f.protect(f.TRAILER_MOTION, counter, batch[3][10:16])),
        ]

    counts, begin, end = inject(feeder, daemon, Fault(51, stick))
    reported = bus.wait_for(
        lambda s: s.can_id == f.INPUTS and rig.input_state(s, 3) == 3, since_s=begin
    )
    assert reported is not None
    report.add(
        "counter stuck",
        f"SwayInputs reported it after {1000 * (reported.time_s - begin):.0f} ms",
        rig.counters(counts, "repeated", "stuck"),
        right_again(bus, begin, end),
    )
    assert counts["repeated"] == 50
    assert counts["stuck"] == 1


def test_out_of_range(bus, daemon, feeder, report):
    """A steering angle of 3000 deg, rightly protected."""

    def turn(batch: list[bytes], number: int) -> list[bytes]:
        counter = batch[0][9] & 15
        payload = struct.pack("<h4x", 30000)
        return [f.can_frame(f.STEERING, f.protect(f.STEERING, counter, payload)), *batch[1:]]

    counts, begin, end = inject(feeder, daemon, Fault(30, turn))
    report.add(
        "steering out of range",
        "30 samples of 3000 deg",
        rig.counters(counts, "range"),
        right_again(bus, begin, end),
    )
    assert counts["range"] == 30


def test_marked_invalid(bus, daemon, feeder, report):
    """The sender itself says that it has no value."""

    def mark(batch: list[bytes], number: int) -> list[bytes]:
        counter = batch[3][9] & 15
        data = f.protect(f.TRAILER_MOTION, counter, batch[3][10:16], validity=0b1010)
        return [*batch[:3], f.can_frame(f.TRAILER_MOTION, data)]

    counts, begin, end = inject(feeder, daemon, Fault(30, mark))
    report.add(
        "trailer motion marked invalid",
        "30 frames, two signals each",
        rig.counters(counts, "invalid"),
        right_again(bus, begin, end),
    )
    assert counts["invalid"] == 60


def test_frozen_sensor(bus, daemon, feeder, report):
    """The trailer's yaw rate freezes while the car goes on swinging."""
    frozen: list[bytes] = []

    def swing_hard(plant: rig.Plant, time_s: float) -> None:
        plant.steer = 0.35 if int(time_s * 1.4) % 2 else -0.35

    def freeze(batch: list[bytes], number: int) -> list[bytes]:
        if not frozen:
            frozen.append(batch[3][10:12])
        counter = batch[3][9] & 15
        payload = frozen[0] + batch[3][12:16]
        return [
            *batch[:3],
            f.can_frame(f.TRAILER_MOTION, f.protect(f.TRAILER_MOTION, counter, payload)),
        ]

    feeder.driver = swing_hard
    time.sleep(1.5)
    counts, begin, end = inject(feeder, daemon, Fault(400, freeze))
    reported = bus.wait_for(
        lambda s: s.can_id == f.INPUTS and rig.input_state(s, 3) == 3, since_s=begin
    )
    assert reported is not None
    off = bus.wait_for(rig.inputs_lost, since_s=begin)
    assert off is not None
    report.add(
        "trailer yaw rate frozen",
        f"SwayInputs reported it after {reported.time_s - begin:.2f} s",
        rig.counters(counts, "frozen", "invalid"),
        right_again(bus, begin, end),
    )
    assert counts["frozen"] == 1
    assert counts["invalid"] > 100


@pytest.mark.parametrize("kind", ["29-bit", "remote", "other"])
def test_foreign_frames_do_no_harm(bus, daemon, feeder, report, kind):
    """Traffic that is not ours."""
    flags = {"29-bit": 0x80000120, "remote": 0x40000120, "other": 0x456}[kind]
    before = daemon.counts()
    for _ in range(20):
        bus.send(f.can_frame(flags, bytes(8)))
    time.sleep(0.1)
    counts = rig.delta(before, daemon.counts())
    name = "unknown_id" if kind == "other" else "foreign"
    report.add(f"20 {kind} frames", "nothing", rig.counters(counts, name), None)
    assert counts[name] == 20
    assert "crc" not in counts
