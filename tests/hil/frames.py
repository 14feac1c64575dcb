"""Frames of swaywatch.dbc for the tests: an encoder that shares no code with lib/.

Only the standard library, because it runs at 1 kHz inside an emulated kernel.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

STEERING, SPEED, CAR_MOTION, TRAILER_MOTION, ARTICULATION, HITCH = range(0x120, 0x126)
CAR_WHEELS = tuple(range(0x130, 0x134))
TRAILER_WHEELS = tuple(range(0x134, 0x138))
ALARM, MARGIN, OSCILLATION = 0x1A0, 0x1A1, 0x1A4
FAULTS_SAMPLES, FAULTS_ESTIMATES, FAULTS_FRAMES, FAULTS_ORDER, INPUTS = range(0x1B4, 0x1B9)
FAULT_REPORT = 0x6E2

_CAN_FRAME = struct.Struct("=IB3x8s")


def _table() -> bytes:
    table = bytearray()
    for byte in range(256):
        value = byte
        for _ in range(8):
            value = (value << 1) ^ (0x12F if value & 0x80 else 0)
        table.append(value)
    return bytes(table)


_CRC = _table()


def crc(can_id: int, data: bytes) -> int:
    """CRC of AUTOSAR E2E profile 2 over bytes 1 to 7 and the data ID."""
    table = _CRC
    value = 0xFF
    for byte in (*data[1:], can_id & 255):
        value = table[value ^ byte]
    return value ^ 0xFF


def protect(can_id: int, counter: int, payload: bytes, validity: int = 0) -> bytes:
    """Eight bytes: CRC, counter and validity codes, then six bytes of payload."""
    data = bytes((0, counter | validity << 4)) + payload
    return bytes((crc(can_id, data),)) + data[1:]


def good(can_id: int, data: bytes) -> bool:
    """True where length and CRC of a received frame are right."""
    return len(data) == 8 and data[0] == crc(can_id, data)


def can_frame(can_id: int, data: bytes) -> bytes:
    """The kernel's struct can_frame."""
    return _CAN_FRAME.pack(can_id, len(data), data)


@dataclass
class Sender:
    """The sensors of the combination: keeps a rolling counter for each message."""

    counters: dict[int, int] = field(default_factory=dict)

    def next(self, can_id: int, payload: bytes, validity: int = 0) -> bytes:
        """The next frame of `can_id`, as struct can_frame."""
        counter = self.counters.get(can_id, 0)
        self.counters[can_id] = (counter + 1) % 16
        return can_frame(can_id, protect(can_id, counter, payload, validity))

    def motion(
        self,
        steering_rad: float,
        speed_m_s: float,
        car: tuple[float, float],
        trailer: tuple[float, float],
    ) -> list[bytes]:
        """The four messages that the judgement needs; `car`, `trailer`: yaw rate, acceleration."""
        deg = 57.29577951308232
        return [
            self.next(STEERING, struct.pack("<h4x", round(steering_rad * deg * 10))),
            self.next(SPEED, struct.pack("<H4x", round(speed_m_s * 360))),
            self.next(CAR_MOTION, pair(car[0] * deg * 100, car[1] * 500)),
            self.next(TRAILER_MOTION, pair(trailer[0] * deg * 100, trailer[1] * 500)),
        ]


def pair(first: float, second: float) -> bytes:
    """Two signed 16-bit values, held at their ends."""
    low, high = -32768, 32767
    values = [min(max(round(v), low), high) for v in (first, second)]
    return struct.pack("<hh2x", *values)
