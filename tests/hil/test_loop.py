"""The closed loop, its latency, and how much the ECU takes."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import frames as f
import numpy as np
import pytest
import rig

SECONDS = float(os.environ.get("HIL_SECONDS", "6"))


SCENARIO = f"""
vehicle = "{rig.VEHICLE}"
duration_s = 14.0
speed_kmh = 100.0
[[manoeuvre]]
kind = "impulse"
angle_deg = 12.0
start_s = 2.0
"""
EXAMPLE = rig.ROOT / "tests" / "data" / "scenarios" / "brake.toml"
WITHOUT_RIMS = "".join(
    f"[sensors.{body}wheel_{what}_{wheel}]\noff = true\n"
    for body in ("", "trailer_")
    for what in ("lateral_force", "vertical_load")
    for wheel in ("fl", "fr", "rl", "rr")
)
"""Half the frames: what the guest's one core can encode in time on a slow machine, too."""


def swaywatch(command: str, scenario: Path, *options: str) -> str:
    """What `swaywatch COMMAND SCENARIO` on the bus prints."""
    arguments = [sys.executable, "-m", "swaywatch.cli", command, str(scenario)]
    arguments += ["--channel", rig.INTERFACE, *options]
    done = subprocess.run(arguments, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stderr
    late = re.search(r"late by .*?([\d.]+) ms \(99.9 %\)", done.stdout)
    rig.LATENESS.note(1e-3 * float(late.group(1)) if late else 0.0)
    return done.stdout


def number(pattern: str, text: str) -> float:
    """The number that a pattern finds."""
    found = re.search(pattern, text)
    assert found, text
    return float(found.group(1))


def test_alarm_reaches_the_brake(daemon, report, tmp_path):
    """9 km/h above v_crit: braked on the alarm the swaying dies out, else it grows."""
    text = EXAMPLE.read_text().replace("../practice/p01", str(rig.VEHICLE.parent))
    braked = tmp_path / "braked.toml"
    braked.write_text(text + WITHOUT_RIMS)
    alone = tmp_path / "alone.toml"
    alone.write_text(text[: text.index("[reaction]")] + WITHOUT_RIMS)
    grown = swaywatch("hil", alone)
    daemon.stop()
    fresh = rig.Daemon()
    calm = swaywatch("hil", braked)
    counts = fresh.stop()
    last = r"last second ([\d.]+) deg/s"
    sent = int(number(r"(\d+) frames sent", calm))
    report.add(
        "`swaywatch hil`, 9 km/h above v_crit",
        f"reaction from {number(r'reaction: from ([0-9.]+) s', calm):.1f} s on, impulse at 2.0 s; "
        f"at the end {number(last, grown):.1f} deg/s, with the trailer's brake "
        f"{number(last, calm):.1f} deg/s",
        f"sent {sent}, {rig.counters(counts, 'accepted', 'lost', 'kernel_lost')}",
        "-",
    )
    assert number(last, calm) < number(last, grown) / 2
    assert number(r"([\d.]+) km/h at the end", calm) < 120.0
    assert counts["accepted"] == sent
    assert counts["lost"] == counts["kernel_lost"] == 0


def test_feed(bus, daemon, report, tmp_path):
    """`swaywatch feed` plays a drive; the ECU on the bus says its critical speed."""
    before = daemon.counts()
    source = tmp_path / "drive.toml"
    source.write_text(SCENARIO)
    output = swaywatch("feed", source)
    time.sleep(0.2)
    counts = rig.delta(before, daemon.counts())
    sent = int(number(r"(\d+) frames sent", output))
    raw = [s.data[2] | s.data[3] << 8 for s in bus.seen if s.can_id == f.MARGIN]
    speeds = [0.01 * value for value in raw if value != 0xFFFF]
    assert speeds, output
    report.add(
        f"`swaywatch feed`, {sent} frames in 14 s",
        f"critical speed {np.median(speeds):.1f} km/h; feed {output.split('; ')[1].strip()}",
        f"sent {sent}, {rig.counters(counts, 'accepted', 'lost', 'kernel_lost')}",
        "-",
    )
    assert counts["accepted"] == sent
    assert "lost" not in counts
    assert np.median(speeds) == pytest.approx(rig.Plant(28.0, 0.01).v_crit * 3.6, rel=0.02)


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
        f"sent {feeder.sent}, {rig.counters(counts, 'accepted', 'lost', 'kernel_lost')}",
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
        f"sent {sent['sent']:.0f}, "
        + rig.counters(counts, "received", "kernel_lost", "lost", "crc"),
        "-",
    )
    assert counts["received"] == sent["sent"] == counts["accepted"]
    assert not {"kernel_lost", "lost", "crc", "late", "repeated"} & set(counts)


def test_load_as_fast_as_the_kernel_takes_it(bus, daemon, report, tmp_path):
    """Whatever is lost is reported."""
    before = daemon.counts()
    sent = load(0, 2.0, tmp_path / "status")
    time.sleep(1.0)
    bus.send(f.Sender().next(0x456, bytes(6)))  # brings the kernel's last count
    time.sleep(0.2)
    counts = rig.delta(before, daemon.counts())
    report.add(
        f"{sent['sent'] / sent['seconds']:.0f} frames/s (all the kernel takes)",
        "-",
        f"sent {sent['sent']:.0f}, " + rig.counters(counts, "received", "kernel_lost", "lost"),
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
        + rig.counters(counts, "received", "kernel_lost", "send_retries", "send_lost"),
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
