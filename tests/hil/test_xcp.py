"""pyxcp measures and calibrates the daemon on a real bus, by its A2L file."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import can
import frames as f
import pytest
import rig
import xcp_master as x
from pyxcp.types import XcpResponseError

KEY = b"key of the tests"
MASS = "vehicle.trailer.mass_g"
V_CRIT = x.STATUS + "v_crit_mm_s"
NUMBER = x.STATUS + "sequence"
VALID = x.STATUS + "valid"
HAS_V_CRIT = 8
NOT_AVAILABLE = 0xFFFF


@pytest.fixture
def daemon(bus: rig.Bus, tmp_path: Path) -> Iterator[rig.Daemon]:
    """A daemon with XCP and a key."""
    (tmp_path / "key").write_bytes(KEY)
    made = rig.Daemon(rig.INTERFACE, "--xcp", "--key", str(tmp_path / "key"))
    yield made
    made.stop()


def master_bus() -> can.BusABC:
    """A socket of its own."""
    wanted = [{"can_id": x.REPLY_ID, "can_mask": 0x7FF}]
    return can.Bus(interface="socketcan", channel=rig.INTERFACE, can_filters=wanted)


def stand(feeder: rig.Feeder, speed_m_s: float) -> None:
    """Another speed, sent by the sensor and received by the ECU."""
    feeder.plant.speed = speed_m_s
    time.sleep(0.2)


def mean_v_crit(session: x.Session, bus: rig.Bus, seconds: float) -> float:
    """Mean of the critical speeds of the next estimates in m/s, from the status frames."""
    begin = time.monotonic()
    while session.measure(VALID) & HAS_V_CRIT == 0:
        assert time.monotonic() < begin + 20.0, "no critical speed"
        time.sleep(0.1)
    since = time.monotonic()
    time.sleep(seconds)
    said = [int.from_bytes(s.data[2:4], "little") for s in list(bus.seen)
            if s.can_id == f.MARGIN and s.time_s > since]  # fmt: skip
    known = [v / 360 for v in said if v != NOT_AVAILABLE]
    return sum(known) / len(known)


def test_pyxcp_session(bus, daemon, feeder, report):
    """Measure, calibrate, switch pages; what is locked, moving or out of range is refused."""
    a2l = x.A2l(rig.ROOT / "build" / "swaywatchd.a2l")
    samples = x.Samples(x.Session(None, a2l).lists([NUMBER, VALID, V_CRIT], event=0))
    with x.session(master_bus(), a2l, KEY, samples) as session:
        master = session.master
        before = mean_v_crit(session, bus, 3.0)
        samples.setup(write_multiple=False)
        samples.start()
        since = time.monotonic()
        time.sleep(3.0)
        samples.stop()
        time.sleep(0.2)
        sent = {s.data[1] >> 4: int.from_bytes(s.data[2:4], "little") for s in list(bus.seen)
                if s.can_id == f.MARGIN and s.time_s > since}  # fmt: skip
        assert len(samples.rows) >= 8
        for row in samples.rows[-8:]:
            raw = (row[V_CRIT] * 9 * 2 + 25) // 50  # 0.01 km/h, rounded
            wanted = raw if row[VALID] & HAS_V_CRIT else NOT_AVAILABLE
            assert sent[row[NUMBER] % 16] == wanted
        assert any(row[VALID] & HAS_V_CRIT for row in samples.rows)

        old = session.parameter(MASS)
        with pytest.raises(XcpResponseError, match="LOCKED"):
            master.setCalPage(0x83, 0, 1)
        master.cond_unlock("calpag")
        with pytest.raises(XcpResponseError, match="DENIED"):
            master.setCalPage(0x01, 0, 1)  # it moves
        master.setCalPage(0x02, 0, 1)
        with pytest.raises(XcpResponseError, match="OUT_OF_RANGE"):
            session.calibrate(MASS, 0)
        session.calibrate(MASS, old * 4 // 3)
        speed = feeder.plant.speed
        stand(feeder, 0.0)
        master.setCalPage(0x01, 0, 1)
        stand(feeder, speed)
        heavier = mean_v_crit(session, bus, 3.0)
        stand(feeder, 0.0)
        master.cond_unlock("calpag")  # the time of the first may be over
        master.setCalPage(0x01, 0, 0)
        stand(feeder, speed)
        again = mean_v_crit(session, bus, 3.0)
    assert heavier < before - 1.0
    assert again == pytest.approx(before, abs=0.5)
    counts = daemon.counts()
    report.add(
        "pyxcp: trailer mass + 1/3, and back",
        f"v_crit {before:.2f}, {heavier:.2f}, {again:.2f} m/s",
        rig.counters(counts, "crc", "lost"),
        "-",
    )
