"""A drive as a car's own bus carries it: tests/data/bus/production.dbc."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from conftest import DATA

from swaywatch.drive import load_drive
from swaywatch.recording.dbc import Database, encode_messages
from swaywatch.recording.frames import Frames

FOLDER = DATA / "bus"
SIGNALS = FOLDER / "production.toml"
PROTECTION = FOLDER / "protection.toml"
LWS_ID = 180
_SIGNALS = {
    "LWS_Standard": {"LWS_Angle": ("steering_wheel_angle", np.degrees(1.0))},
    "ESP_Motion": {
        "ESP_YawRate": ("car_yaw_rate", np.degrees(1.0)),
        "ESP_LateralAcc": ("car_lateral_acceleration", 1.0),
    },
    "ESP_Speed": {"ESP_VehicleSpeed": ("speed", 3.6)},
}


def crc8(data: bytes) -> int:
    """CRC-8 SAE J1850, bit by bit."""
    crc = 0xFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1) ^ (0x1D if crc & 0x80 else 0)
        crc &= 0xFF
    return crc ^ 0xFF


def frames_of(run: Path, signals: Path) -> Frames:
    """The frames of a recorded drive, steering protected by counter and CRC."""
    drive = load_drive([run], signals)
    samples = {}
    for message, entries in _SIGNALS.items():
        first = drive.channels[next(iter(entries.values()))[0]]
        values = {
            name: factor * np.interp(first.time_s, drive.channels[role].time_s,
                                     drive.channels[role].value)
            for name, (role, factor) in entries.items()
        }  # fmt: skip
        time_ns = drive.start_ns + np.rint(first.time_s * 1e9).astype(np.int64)
        samples[message] = (time_ns, values)
    frames = encode_messages(Database([FOLDER / "production.dbc"]), samples)
    for count, row in enumerate(np.flatnonzero(frames.identifier == LWS_ID)):
        frames.data[row, 4] = count % 16
        frames.data[row, 5] = crc8(bytes([0xB4, 0x00]) + bytes(frames.data[row, :5]))
    return frames
