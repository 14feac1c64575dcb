"""The bus as ``dbc/swaywatch.dbc`` says it: drives as frames for the ECU.

``encode_drive`` is what ``swaywatch convert`` and the bus feed send: every message of the inputs
with validity, rolling counter and CRC (``lib/bus/sway_e2e.h`` writes the last two).
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from swaywatch.drive import Channel, Drive
from swaywatch.ecu._core import ffi, lib
from swaywatch.errors import SignalError
from swaywatch.recording import Frames
from swaywatch.recording.dbc import Database, encode_messages

_INSTALLED = Path(__file__).resolve().parents[1] / "swaywatch.dbc"
DBC_PATH = (
    _INSTALLED if _INSTALLED.is_file()
    else Path(__file__).resolve().parents[4] / "dbc" / "swaywatch.dbc"
)  # fmt: skip
"""The bus description: beside the rooms where the package is installed, else the checkout's."""

_DEG = 180 / math.pi
_VALID, _NOT_AVAILABLE = 0, 1


def _messages() -> dict[str, tuple[tuple[str, str, str, float], ...]]:
    """Message -> (channel, signal, its validity signal, factor from SI to the DBC's unit)."""
    table: dict[str, tuple[tuple[str, str, str, float], ...]] = {
        "SwaySteering": (
            ("steering_wheel_angle", "SteeringWheelAngle", "SteeringWheelAngleValidity", _DEG),
        ),
        "SwaySpeed": (("speed", "VehicleSpeed", "VehicleSpeedValidity", 3.6),),
    }
    for body in ("Car", "Trailer"):
        low = body.lower()
        table[f"Sway{body}Motion"] = (
            (f"{low}_yaw_rate", f"{body}YawRate", f"{body}YawRateValidity", _DEG),
            (
                f"{low}_lateral_acceleration",
                f"{body}LateralAcc",
                f"{body}LateralAccValidity",
                1.0,
            ),
        )
    table["SwayArticulation"] = (
        ("articulation", "ArticulationAngle", "ArticulationAngleValidity", _DEG),
    )
    table["SwayHitchForces"] = tuple(
        (f"hitch_{direction}_force", f"HitchF{axis}", "HitchForcesValidity", 1.0)
        for axis, direction in (("x", "longitudinal"), ("y", "lateral"), ("z", "vertical"))
    )
    for prefix, body in (("", "Car"), ("trailer_", "Trailer")):
        for wheel in ("FL", "FR", "RL", "RR"):
            name = f"{body}Wheel{wheel}"
            low = wheel.lower()
            table[f"Sway{name}"] = (
                (f"{prefix}wheel_lateral_force_{low}", f"{name}Fy", f"{name}FyValidity", 1.0),
                (f"{prefix}wheel_vertical_load_{low}", f"{name}Fz", f"{name}FzValidity", 1.0),
            )
    return table


MESSAGES = _messages()
"""What each message of the inputs carries."""


@cache
def database() -> Database:
    """``dbc/swaywatch.dbc``, read once."""
    return Database([DBC_PATH])


def encode_drive(drive: Drive, bus: int = 0) -> Frames:
    """Frames of ``swaywatch.dbc`` for a drive, protected, in order of time.

    A message is sent at the times of the first of its channels that the drive has; channels that
    are missing are marked "not available", samples beyond a signal's range are clipped to it.

    Parameters
    ----------
    drive
        Any drive.
    bus
        Channel of the logger.

    Raises
    ------
    SignalError
        The drive has no channel that the bus carries.
    """
    samples = {}
    for message, entries in MESSAGES.items():
        there = [entry for entry in entries if entry[0] in drive.channels]
        if not there:
            continue
        lead = drive.channels[there[0][0]]
        time_us = drive.start_ns // 1000 + np.rint(lead.time_s * 1e6).astype(np.int64)
        time_ns = time_us * 1000  # whole microseconds, as candump logs keep
        values: dict[str, npt.NDArray[np.float64]] = {}
        for channel, signal, validity, factor in entries:
            present = channel in drive.channels
            if present:
                values[signal] = factor * _at(drive.channels[channel], lead)
            state = np.full(len(time_ns), float(_VALID if present else _NOT_AVAILABLE))
            known = values.get(validity)
            values[validity] = state if known is None else np.minimum(known, state)
        samples[message] = (time_ns, values)
    if not samples:
        raise SignalError(f"{drive.name}: no channel that swaywatch.dbc carries")
    return protect(encode_messages(database(), samples, bus))


def protect(frames: Frames) -> Frames:
    """The frames with rolling counters (one for each identifier) and CRCs written into them."""
    data = np.ascontiguousarray(frames.data)
    identifier = np.ascontiguousarray(frames.identifier)
    lib.core_protect(
        ffi.cast("uint32_t *", identifier.ctypes.data),
        ffi.cast("uint8_t *", data.ctypes.data),
        data.shape[1],
        len(frames),
    )
    return Frames(frames.time_ns, identifier, frames.extended, frames.length, data, frames.bus)


def _at(channel: Channel, lead: Channel) -> npt.NDArray[np.float64]:
    """Samples of a channel at the times of another."""
    if channel is lead or np.array_equal(channel.time_s, lead.time_s):
        return channel.value
    result: npt.NDArray[np.float64] = np.interp(lead.time_s, channel.time_s, channel.value)
    return result
