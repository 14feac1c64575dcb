"""The daemon on a car's own bus: it hears production.dbc through a map, and nothing of ours."""

from __future__ import annotations

import struct
import subprocess
import sys
import time

import frames as f
import rig

FOLDER = rig.ROOT / "tests" / "data" / "bus"
SECONDS = 8.0
DEG = 57.29577951308232


class Foreign:
    """Encoder of tests/data/bus/production.dbc, with what protects the steering angle."""

    def __init__(self) -> None:
        self.count = 0

    def motion(self, steering_rad, speed_m_s, car, _trailer):
        """Three frames, as struct can_frame; of the trailer nothing is on this bus."""
        self.count += 1
        angle = struct.pack("<hxxB", round(-10.0 * DEG * steering_rad), self.count % 16)
        lws = angle + bytes([self._crc(b"\xb4\0" + angle)])
        acceleration = round(100.0 * (car[1] + 20.48)) & 0xFFF
        motion = struct.pack(
            ">HBB4x", round(100.0 * DEG * car[0]) & 0x7FFF, (acceleration & 0xF) << 4,
            acceleration >> 4,
        )  # fmt: skip
        speed = struct.pack(">xHx", round(360.0 * speed_m_s))
        made = ((180, lws), (581, motion), (1001, speed))
        return [struct.pack("=IB3x8s", name, len(data), data) for name, data in made]

    @staticmethod
    def _crc(data: bytes) -> int:
        """CRC-8 SAE J1850, bit by bit."""
        value = 0xFF
        for byte in data:
            value ^= byte
            for _ in range(8):
                value = (value << 1 ^ (0x1D if value & 0x80 else 0)) & 0xFF
        return value ^ 0xFF


def test_only_a_production_bus(bus, report, tmp_path):
    """Steering, speed, yaw rate, lateral acceleration under foreign identifiers."""
    made = tmp_path / "car.map"
    subprocess.run(
        [sys.executable, "-m", "swaywatch.cli", "map", "--signals", FOLDER / "production.toml",
         "--protection", FOLDER / "protection.toml", "--out", made],
        check=True, capture_output=True,
    )  # fmt: skip
    daemon = rig.Daemon(rig.INTERFACE, "--map", str(made))
    feeder = rig.Feeder(bus)
    feeder.sender = Foreign()
    feeder.start()
    time.sleep(SECONDS)
    feeder.stop()
    time.sleep(0.2)
    estimates = [seen for seen in bus.seen if seen.can_id == f.OSCILLATION]
    counts = daemon.stop()
    report.add(
        "a car's own bus only, through a map", f"{len(estimates)} estimates",
        f"sent {feeder.sent}, {rig.counters(counts, 'accepted', 'lost', 'kernel_lost')}", "-",
    )  # fmt: skip
    cycles = feeder.sent // 3
    assert counts["accepted"] == 4 * cycles  # yaw rate and acceleration share a frame
    assert counts["crc"] == counts["repeated"] == counts["unknown_id"] == counts["range"] == 0
    assert len(estimates) > 10
