"""The closed loop, its latency, and how much the ECU takes."""

from __future__ import annotations

import json
import os
import subprocess
import time
from pathlib import Path

import frames as f
import numpy as np
import pytest
import rig

SECONDS = float(os.environ.get("HIL_SECONDS", "6"))
DEG = 57.29577951308232


def newest_alarm(bus: rig.Bus) -> int:
    """State of the newest alarm frame."""
    for seen in reversed(bus.seen):
        if seen.can_id == f.ALARM:
            return rig.alarm_state(seen)
    return 0


def impulse(plant: rig.Plant, time_s: float) -> None:
    """A steering impulse at 4 s."""
    phase = time_s - 4.0
    plant.steer = 0.33 * float(np.sin(2 * np.pi * 0.67 * phase)) if 0 <= phase < 0.75 else 0.0


def drive(bus: rig.Bus, *, reacts: bool, seconds: float) -> tuple[float, float, int]:
    """A car 14 km/h above its critical speed; the trailer brake listens to the ECU, or does not.

    Returns the largest trailer yaw rate of the last two seconds (deg/s), the last speed (m/s), and
    the highest alarm state.
    """
    feeder = rig.Feeder(bus, 25.0, 100.0, forces=True)
    feeder.plant.set_speed(feeder.plant.v_crit + 4.0)
    worst: list[float] = []
    highest = 0

    def driver(plant: rig.Plant, time_s: float) -> None:
        nonlocal highest
        impulse(plant, time_s)
        worst.append(abs(float(plant.state[1] + plant.state[2])))
        state = newest_alarm(bus)
        highest = max(highest, state)
        if reacts and state >= 3 and plant.speed > 20.0:
            plant.set_speed(plant.speed - 2.5 / 100.0)

    feeder.driver = driver
    feeder.start()
    time.sleep(seconds)
    feeder.stop()
    return max(worst[-200:]) * DEG, feeder.plant.speed, highest


def test_alarm_reaches_the_brake(bus, daemon, report):
    """With the brake the swaying dies out, without it grows: the loop closes over the bus."""
    grown, fast, _ = drive(bus, reacts=False, seconds=14.0)
    daemon.stop()
    bus.seen.clear()
    fresh = rig.Daemon()
    calm, slow, highest = drive(bus, reacts=True, seconds=20.0)
    counts = fresh.stop()
    report.add(
        "closed loop, 4 m/s above v_crit",
        f"alarm state {highest}; without brake {grown:.1f} deg/s at {fast * 3.6:.0f} km/h, "
        f"with brake {calm:.1f} deg/s at {slow * 3.6:.0f} km/h",
        rig.told(counts, "estimates", "lost"),
        "-",
    )
    assert highest >= 3
    assert slow < fast - 5.0
    assert calm < grown / 2
    assert counts["lost"] == 0


@pytest.mark.parametrize("rate_hz", [100.0, 1000.0])
def test_closed_loop_rate(bus, daemon, report, rate_hz):
    """Plant and ECU in step; nothing is lost."""
    before = daemon.counts()
    feeder = rig.Feeder(bus, 25.0, rate_hz)
    begin = time.monotonic()
    feeder.start()
    time.sleep(SECONDS)
    feeder.stop()
    took = time.monotonic() - begin
    time.sleep(0.1)
    counts = rig.delta(before, daemon.counts())
    report.add(
        f"closed loop at {rate_hz:.0f} Hz",
        f"{feeder.periods / took:.0f} steps/s, worst {1e3 * feeder.worst_late_s:.1f} ms late",
        f"sent {feeder.sent}, {rig.told(counts, 'accepted', 'lost', 'kernel_lost')}",
        "-",
    )
    assert counts["accepted"] == feeder.sent
    assert "lost" not in counts
    assert "kernel_lost" not in counts


def load(rate: float, seconds: float, output: Path) -> dict[str, float]:
    """Run bus_load; what it says."""
    command = [str(rig.BUS_LOAD), rig.INTERFACE, str(rate), str(seconds), str(output)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def test_load_of_8000_frames_a_second(bus, daemon, report, tmp_path):
    """Nothing is lost at 8,000 frames/s."""
    before = daemon.counts()
    sent = load(8000, SECONDS, tmp_path / "status")
    time.sleep(0.2)
    counts = rig.delta(before, daemon.counts())
    rate = sent["sent"] / sent["seconds"]
    report.add(
        f"{rate:.0f} frames/s for {sent['seconds']:.0f} s",
        "status frames as always",
        f"sent {sent['sent']:.0f}, " + rig.told(counts, "received", "kernel_lost", "lost", "crc"),
        "-",
    )
    assert counts["received"] == sent["sent"] == counts["accepted"]
    assert not {"kernel_lost", "lost", "crc", "late", "repeated"} & set(counts)


def test_load_as_fast_as_the_kernel_takes_it(bus, daemon, report, tmp_path):
    """Whatever is lost is told."""
    before = daemon.counts()
    sent = load(0, 2.0, tmp_path / "status")
    time.sleep(1.0)
    bus.send(f.Sender().next(0x456, bytes(6)))  # brings the kernel's last count
    time.sleep(0.2)
    counts = rig.delta(before, daemon.counts())
    report.add(
        f"{sent['sent'] / sent['seconds']:.0f} frames/s (all the kernel takes)",
        "-",
        f"sent {sent['sent']:.0f}, " + rig.told(counts, "received", "kernel_lost", "lost"),
        "-",
    )
    assert counts["received"] + counts.get("kernel_lost", 0) == sent["sent"] + 1


def test_load_of_a_full_bus(bus, daemon, report, tmp_path):
    """A bus of 500 kbit/s at 100 %: sending takes its turn, receiving goes on."""
    subprocess.run(["busybox", "modprobe", "sch_tbf"], check=False, capture_output=True)
    limit = [
        "tc",
        "qdisc",
        "add",
        "dev",
        rig.INTERFACE,
        "root",
        "tbf",
        "rate",
        "500kbit",
        "burst",
        "256",
        "limit",
        "3200",
    ]
    if subprocess.run(limit, check=False, capture_output=True).returncode != 0:
        pytest.skip("no token bucket filter in this kernel")
    try:
        before = daemon.counts()
        sent = load(0, 4.0, tmp_path / "status")
    finally:
        subprocess.run(["tc", "qdisc", "del", "dev", rig.INTERFACE, "root"], check=True)
    end = time.monotonic()
    bus.send(f.Sender().next(f.SPEED, bytes(6)))
    again = bus.wait_for(lambda s: s.can_id == f.ALARM, 5.0, end)
    assert again is not None
    counts = rig.delta(before, daemon.counts())
    report.add(
        f"bus at 100 % ({sent['sent'] / sent['seconds']:.0f} frames/s)",
        "-",
        f"sent {sent['sent']:.0f}, "
        + rig.told(counts, "received", "kernel_lost", "send_retries", "send_lost"),
        again.time_s - end,
    )
    assert counts["received"] + counts.get("kernel_lost", 0) == sent["sent"] + 1


def test_latency(report, tmp_path):
    """From a frame's arrival to the status frame that it makes due, by the kernel's stamps."""
    out = tmp_path / "out.log"
    daemon = rig.Daemon(rig.INTERFACE, "--candump-out", str(out))
    load(1000, SECONDS, tmp_path / "status")
    daemon.stop()
    made = [line.split() for line in out.read_text().splitlines()]
    came = [line.split() for line in (tmp_path / "status").read_text().splitlines()]
    cause = [(float(t.strip("()")) * 1e6, *frame.split("#")) for t, _, frame in made]
    cause = [c for c in cause if c[1] != "6E2"]
    assert [tuple(c[1:]) for c in came] == [tuple(c[1:]) for c in cause][: len(came)]
    latency = np.array([int(t[0]) - c[0] for t, c in zip(came, cause, strict=False)])
    alarm = latency[[c[1] == "1A0" for c in came]]
    first = {"median": np.median(alarm), "99.9 %": np.percentile(alarm, 99.9)}
    whole = {"median": np.median(latency), "99.9 %": np.percentile(latency, 99.9)}
    report.add(
        f"latency at 1,000 frames/s, {len(latency)} status frames",
        f"alarm frame: median {first['median']:.0f} us, 99.9 % {first['99.9 %']:.0f} us; "
        f"all: median {whole['median']:.0f} us, 99.9 % {whole['99.9 %']:.0f} us",
        "-",
        "-",
    )
    assert len(latency) > 100
    assert latency.min() > -50
