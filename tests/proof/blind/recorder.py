"""Sensors, messages and files of a generated recording.

Noise, offsets, quantisation and message timing are those found in the practice recordings:
inertial sensors with 20 Hz low-pass noise, wheel forces with a band of noise about the wheel
hop, every message on its own 10 ms cycle with 0.1 ms of jitter, 16 bit signals.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

from swaywatch.recording import write_recording
from swaywatch.recording.frames import Frames, Series, make_frames

Array = NDArray[np.float64]
START_NS = 1_700_000_000_000_000_000
MARGIN_S = 0.3


@dataclass(frozen=True)
class Signal:
    """One signal of the bus: frame, first byte, order, scale, sign, unit and its noise."""

    name: str
    frame: int
    byte: int
    little: bool
    scale: float
    signed: bool
    unit: str
    noise: str
    size: float
    offset: float


def _signals() -> tuple[Signal, ...]:
    rows = [
        Signal("SteeringWheelAngle", 194, 0, True, 0.1, True, "deg", "none", 0.0, 0.3),
        Signal("SteeringWheelRate", 194, 2, True, 0.5, True, "deg/s", "low", 1.5, 0.0),
        Signal("VehicleSpeed", 416, 0, True, 0.01, False, "km/h", "white", 0.11, 0.0),
        Signal("YawRate1", 688, 0, False, 0.01, True, "deg/s", "low", 0.048, 0.05),
        Signal("LatAccRear1", 688, 2, False, 0.002, True, "m/s2", "low", 0.03, 0.04),
        Signal("YawRate2", 696, 0, False, 0.01, True, "deg/s", "low", 0.048, 0.05),
        Signal("LatAcc2", 696, 2, False, 0.002, True, "m/s2", "low", 0.034, 0.04),
    ]
    wheels = ("FL", "FR", "RL", "RR", "T1L", "T1R", "T2L", "T2R")
    for number, wheel in enumerate(wheels):
        rows.append(Signal(f"Fy{wheel}", 784 + number, 0, True, 1, True, "N", "hop", 32.0, 12.0))
        rows.append(Signal(f"Fz{wheel}", 784 + number, 2, True, 1, False, "N", "hop", 122.0, 1.0))
    rows += [
        Signal("HitchFx", 800, 0, False, 1, True, "N", "low", 11.5, 15.0),
        Signal("HitchFy", 800, 2, False, 1, True, "N", "low", 11.5, 15.0),
        Signal("HitchFz", 801, 0, False, 1, True, "N", "low", 11.5, 6.0),
    ]
    return tuple(rows)


SIGNALS = _signals()
NOISE_RMS = {s.name: s.size for s in SIGNALS}
FRAMES = {
    194: ("STEERING", 0.0), 416: ("SPEED", 0.0011), 688: ("IMU_1", 0.00195),
    696: ("IMU_2", 0.0043), 784: ("RIM_FL", 0.005), 785: ("RIM_FR", 0.0053),
    786: ("RIM_RL", 0.0056), 787: ("RIM_RR", 0.0058), 788: ("RIM_T1L", 0.0062),
    789: ("RIM_T1R", 0.0064), 790: ("RIM_T2L", 0.0067), 791: ("RIM_T2R", 0.0069),
    800: ("HITCH", 0.0071), 801: ("HITCH_Z", 0.0074),
}  # fmt: skip
TRAILER_FRAMES = (788, 789, 790, 791, 801)


def dbc_text(*, trailer: bool) -> str:
    """DBC of the measurement, with or without the trailer's wheels."""
    lines = ['VERSION "1"', "", "NS_ :", "", "BS_:", "", "BU_: CAR LOGGER", ""]
    for frame, (name, _) in FRAMES.items():
        if frame in TRAILER_FRAMES and not trailer:
            continue
        lines.append(f"BO_ {frame} {name}: 8 CAR")
        for s in (s for s in SIGNALS if s.frame == frame):
            start, order = (8 * s.byte, 1) if s.little else (8 * s.byte + 7, 0)
            low, high = (-32768, 32767) if s.signed else (0, 65535)
            lines.append(
                f" SG_ {s.name} : {start}|16@{order}{'-' if s.signed else '+'} ({s.scale:g},0) "
                f'[{low * s.scale:g}|{high * s.scale:g}] "{s.unit}" LOGGER'
            )
        lines.append("")
    return "\n".join(lines)


@cache
def _filter(low_hz: float, high_hz: float = 0.0) -> Array:
    """Butterworth low-pass, or band-pass, of third order at 1 kHz."""
    if high_hz:
        return np.asarray(butter(3, (low_hz, high_hz), "band", fs=1000, output="sos"))
    return np.asarray(butter(3, low_hz, fs=1000, output="sos"))


def noise(rng: Generator, kind: str, size: float, time: Array) -> Array:
    """Noise of a sensor at 1 kHz times, rms `size`."""
    if kind == "none" or size == 0.0:
        return np.zeros_like(time)
    white = rng.standard_normal(time.size + 1000)
    if kind == "white":
        return size * white[1000:]
    if kind == "low":
        shaped = sosfilt(_filter(22.0), white)[1000:]
        return np.asarray(size * shaped / np.std(shaped))
    band = sosfilt(_filter(7.8, 13.2), white)[1000:]
    wide = sosfilt(_filter(25.0), rng.standard_normal(time.size + 1000))[1000:]
    return np.asarray(size * (0.97 * band / np.std(band) + 0.25 * wide / np.std(wide)))


def _faulty(values: Array, time: Array, fault: dict[str, Any], run: str, rng: Generator) -> Array:
    """Sensor faults that change the value as sampled (gain is applied by the caller)."""
    out = values.copy()
    scale = float(np.std(values)) or 1.0
    if "frozen" in fault:
        for start, end in fault["frozen"][run]:
            hit = (time >= start) & (time < end)
            if hit.any():
                out[hit] = out[np.argmax(hit)]
    if "spikes" in fault:
        hit = rng.random(time.size) < 0.004
        out[hit] += rng.choice((-1.0, 1.0), hit.sum()) * 8.0 * scale * fault["spikes"]
    if "drift" in fault:
        out += fault["drift"] * 3.0 * scale * time / time[-1]
    return out


def measure(
    truth: dict[str, Array],
    time: Array,
    sensors: dict[str, dict[str, Any]],
    run: str,
    rng: Generator,
    noise_factor: float,
    hidden: tuple[str, ...] = (),
) -> Frames:
    """Frames of one run, in order of time.

    Parameters
    ----------
    truth : signal name to values in the unit of the bus, over `time` (1 kHz or finer).
    sensors : faults per signal, see :mod:`effects`.
    """
    grid = np.arange(0.0, time[-1], 0.001)
    length = int((time[-1] - MARGIN_S) / 0.01)
    stamps = {
        frame: 0.01 * np.arange(length) + phase * (1 + 0.04 * rng.standard_normal())
        + 0.00012 * np.abs(rng.standard_normal(length))
        for frame, (_, phase) in FRAMES.items()
    }  # fmt: skip
    payload = {
        frame: np.zeros((length, 8), dtype=np.uint8)
        for frame in FRAMES
        if any(s.frame == frame and s.name in truth for s in SIGNALS)
    }
    for s in SIGNALS:
        disturbance = noise(rng, s.noise, s.size * noise_factor, grid)
        offset = s.offset * float(rng.standard_normal())
        if s.name not in truth or s.name in hidden:
            continue
        fault = sensors.get(s.name, {})
        when = stamps[s.frame] * (1.0 + 0.004 * fault.get("clock", 0.0)) - fault.get("delay", 0.0)
        values = np.interp(when, time, truth[s.name]) * fault.get("gain", 1.0)
        values += np.interp(stamps[s.frame], grid, disturbance) + offset
        values = _faulty(values, stamps[s.frame], fault, run, rng)
        raw = np.rint(values / s.scale)
        low, high = (-32768, 32767) if s.signed else (0, 65535)
        code = np.clip(raw, low, high).astype(np.int64) & 0xFFFF
        first, second = (code & 0xFF, code >> 8) if s.little else (code >> 8, code & 0xFF)
        payload[s.frame][:, s.byte], payload[s.frame][:, s.byte + 1] = first, second
    table = [
        (START_NS + np.rint(stamps[frame] * 1e9).astype(np.int64), np.full(length, frame), data)
        for frame, data in payload.items()
    ]
    time_ns, frame, data = (np.concatenate(column) for column in zip(*table, strict=True))
    order = np.argsort(time_ns, kind="stable")
    eight = np.full(order.size, 8)
    return make_frames(
        time_ns[order], frame[order], eight == 0, eight, data[order], np.zeros_like(eight)
    )


def write_simulation(path: Path, time: Array, truth: dict[str, Array]) -> None:
    """Noise-free signals at 100 Hz on the recording's clock, as a simulation tool exports them."""
    grid = np.arange(0.0, time[-1] - MARGIN_S, 0.01)
    units = {s.name: s.unit for s in SIGNALS}
    time_ns = START_NS + np.rint(grid * 1e9).astype(np.int64)
    signals = {
        name: Series(time_ns, np.interp(grid, time, values), units[name])
        for name, values in truth.items()
    }
    write_recording(path, signals)
