"""What happens around the daemon: a clock is set, a terminal goes, a second daemon runs."""

from __future__ import annotations

import itertools
import os
import signal
import time

import frames as f
import pytest
import rig

GUEST_ONLY = pytest.mark.skipif(
    "HIL_GUEST" not in os.environ, reason="the clock of this machine is not a test's to set"
)


def longest_silence(bus: rig.Bus, begin_s: float, end_s: float) -> float:
    """Longest time without an alarm frame, which has a heartbeat of 0.1 s."""
    alarms = [s.time_s for s in list(bus.seen) if s.can_id == f.ALARM]
    edges = [begin_s, *(t for t in alarms if begin_s < t < end_s), end_s]
    return max(b - a for a, b in itertools.pairwise(edges))


@GUEST_ONLY
@pytest.mark.parametrize("by_s", [-8.0, -3600.0, 8.0, 3600.0])
def test_clock_of_day_is_set(bus, daemon, report, by_s):
    """Back by 8 s it was silent for 8 to 9 s, with neither alarm nor heartbeat."""
    feeder = rig.Feeder(bus, rate_hz=500.0)
    feeder.start()
    assert bus.wait_for(rig.inputs_good)
    time.sleep(1.0)
    before = daemon.counts()
    begin = time.monotonic()
    time.clock_settime(time.CLOCK_REALTIME, time.time() + by_s)
    time.sleep(3.0)
    end = time.monotonic()
    feeder.stop()
    counts = rig.delta(before, daemon.counts())
    silence = longest_silence(bus, begin, end)
    report.add(
        f"clock of day set by {by_s:+.0f} s, 2,000 frames/s",
        f"longest silence {silence:.2f} s",
        rig.counters(counts, "clock_set", "stamped_here", "clock_back", "timeout"),
        "-",
    )
    assert silence < 0.35
    assert counts["clock_set"] == 1
    assert daemon.said("the clock of day was set by")
    assert "timeout" not in counts
    assert counts.get("clock_back", 0) < 10


def test_terminal_goes(daemon, feeder, bus):
    """SIGHUP ended it; now it says its counters and goes on."""
    feeder.bus.seen.clear()
    daemon.process.send_signal(signal.SIGHUP)
    assert daemon.said("counts {")
    assert bus.wait_for(rig.inputs_good)
    assert daemon.process.poll() is None


def test_second_ecu_is_reported(daemon, feeder, bus, report):
    """Two of them on one bus: each says so."""
    other = rig.Daemon()
    assert bus.wait_for(rig.inputs_good)
    assert daemon.said("another swaywatch ECU", 5.0)
    assert other.said("another swaywatch ECU", 5.0)
    counts = other.stop()
    assert counts["other_ecu"] > 0
    report.add(
        "two daemons on a bus", "each reports the other", rig.counters(counts, "other_ecu"), "-"
    )


def test_alone_there_is_no_second_ecu(daemon, feeder, bus):
    """Its own frames are none of another's."""
    assert bus.wait_for(rig.inputs_good)
    time.sleep(1.0)
    assert daemon.counts()["other_ecu"] == 0


def test_what_a_failed_test_leaves_is_ended(bus):
    """A daemon that a test started and never ended was a second ECU in every test after it."""
    left, feeder = rig.Daemon(), rig.Feeder(bus)
    feeder.start()
    assert rig.end_all() == 2
    assert left.process.poll() is not None
    assert not feeder.is_alive()
    assert rig.end_all() == 0
