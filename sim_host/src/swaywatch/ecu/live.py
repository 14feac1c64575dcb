"""What is known at this moment, from a live bus: the state behind ``swaywatch monitor``.

Frames of ``swaywatch.dbc`` go to a whole node (:class:`swaywatch.ecu.node.Node`), exactly as in the
daemon; frames of another bus are decoded by its DBC, mapped to roles, and go to the core.
"""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import can
import numpy as np
import numpy.typing as npt

from swaywatch.drive import Mapping, load_signals, unit_factor
from swaywatch.ecu.core import Core
from swaywatch.ecu.node import Node
from swaywatch.ecu.remembered import Remembered, heard
from swaywatch.errors import SignalError
from swaywatch.recording.dbc import Database, frames_by_identifier
from swaywatch.recording.frames import Frames, make_frames
from swaywatch.vehicle import Vehicle


@dataclass
class Counts:
    """What came over the bus."""

    used: int = 0
    other: int = 0
    errors: int = 0
    last_time_s: float = 0.0
    rate_hz: float = 0.0
    _window: deque[float] = field(default_factory=lambda: deque(maxlen=500))

    def note(self, time_s: float) -> None:
        """One more frame at `time_s`."""
        self.last_time_s = time_s
        self._window.append(time_s)
        span = self._window[-1] - self._window[0]
        if span > 0.0:
            self.rate_hz = (len(self._window) - 1) / span


class Playback:
    """A recording as a bus that is read only: each frame comes at its own time.

    Parameters
    ----------
    frames
        In order of time.
    speed
        2 plays twice as fast; 0 without any pause.
    """

    def __init__(self, frames: Frames, speed: float = 1.0) -> None:
        self._frames = frames
        self._speed = speed
        self._next = 0
        self._start = time.monotonic()

    def __enter__(self) -> Playback:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    @property
    def at_end(self) -> bool:
        """Has every frame been read."""
        return self._next >= len(self._frames)

    def recv(self, timeout: float) -> can.Message | None:
        """The next frame, when it is due; None where that is later than `timeout` from now."""
        if self.at_end:
            return None
        k, frames = self._next, self._frames
        if self._speed > 0.0:
            since_s = (int(frames.time_ns[k]) - int(frames.time_ns[0])) * 1e-9 / self._speed
            wait = self._start + since_s - time.monotonic()
            if wait > 0.0:
                time.sleep(min(wait, timeout))
            if wait > timeout:
                return None
        self._next += 1
        return can.Message(
            timestamp=int(frames.time_ns[k]) * 1e-9,
            arbitration_id=int(frames.identifier[k]),
            is_extended_id=bool(frames.extended[k]),
            data=bytes(frames.data[k, : frames.length[k]]),
            is_fd=int(frames.length[k]) > 8,
        )


def _trailer(message: can.Message) -> Remembered | None:
    """What the ECU on the bus says of the trailer; this node itself keeps none."""
    return heard(message.arbitration_id, message.is_extended_id, bytes(message.data))


class NodeFeed:
    """Frames of ``swaywatch.dbc`` into the ECU software.

    Parameters
    ----------
    vehicle
        The combination.
    positions_m
        Of the accelerometers, by channel, ahead of the COG.
    """

    def __init__(self, vehicle: Vehicle, positions_m: dict[str, float]) -> None:
        self.node = Node(vehicle, positions_m)
        self.counts = Counts()
        self.trailer: Remembered | None = None

    def receive(self, message: can.Message) -> list[tuple[int, bytes]]:
        """One frame; the status frames that it causes."""
        if message.is_error_frame:
            self.counts.errors += 1
            return []
        if message.is_remote_frame:
            return []
        self.counts.note(message.timestamp)
        self.trailer = _trailer(message) or self.trailer
        time_us = round(message.timestamp * 1e6)
        error = self.node.receive(
            time_us, message.arbitration_id, message.is_extended_id, bytes(message.data)
        )
        if error == 0:
            self.counts.used += 1
        else:
            self.counts.other += 1
        return list(self.node.transmit())

    def advance(self, time_s: float) -> None:
        """Time goes on without a frame."""
        self.node.advance(round(time_s * 1e6))
        for _ in self.node.transmit():
            pass

    def status(self) -> npt.NDArray[Any]:
        """The newest status, shape (1,)."""
        return self.node.status()

    def faults(self) -> dict[str, int]:
        """Faults of frames, by name."""
        return self.node.fault_count()


class RoleFeed:
    """Frames of any bus, by DBC and roles, into the core.

    Parameters
    ----------
    vehicle
        The combination.
    signals
        A ``signals.toml`` with a DBC.

    Raises
    ------
    SignalError
        No DBC, or a signal that it does not have.
    """

    def __init__(self, vehicle: Vehicle, signals: Path) -> None:
        mappings, paths = load_signals(signals)
        if not paths:
            raise SignalError(f"{signals}: names no DBC; frames cannot be decoded without one")
        self._database = Database(paths)
        positions = {m.channel: m.position_m for m in mappings}
        self.core = Core(vehicle, positions)
        self.counts = Counts()
        self.trailer: Remembered | None = None
        self._entries: dict[tuple[int, bool], list[tuple[Mapping, Any, Any, float]]] = {}
        for mapping in mappings:
            for name in mapping.signals[:1]:
                found = self._database.find(name)
                if found is None:
                    dbcs = ", ".join(str(path) for path in paths)
                    raise SignalError(
                        f"{signals}: {mapping.channel} = {name!r}, but {dbcs} has no such signal"
                    )
                message, signal = found
                unit = mapping.unit or signal.unit or ""
                factor = mapping.factor * unit_factor(
                    mapping.channel, unit, name, paths[0], signals
                )
                key = (int(message.frame_id), bool(message.is_extended_frame))
                self._entries.setdefault(key, []).append((mapping, message, signal, factor))
        self._start_s: float | None = None

    def receive(self, message: can.Message) -> list[tuple[int, bytes]]:
        """One frame into the core."""
        if message.is_error_frame:
            self.counts.errors += 1
            return []
        if message.is_remote_frame:
            return []
        self.counts.note(message.timestamp)
        self.trailer = _trailer(message) or self.trailer
        entries = self._entries.get((message.arbitration_id, message.is_extended_id))
        if entries is None:
            self.counts.other += 1
            return []
        self.counts.used += 1
        if self._start_s is None:
            self._start_s = message.timestamp
        data = np.zeros((1, 64), dtype=np.uint8)
        data[0, : len(message.data)] = np.frombuffer(bytes(message.data), dtype=np.uint8)
        frame = make_frames(
            [0], [message.arbitration_id], [message.is_extended_id], [len(message.data)], data, [0]
        )
        row = next(iter(frames_by_identifier(frame).values()))
        for mapping, description, signal, factor in entries:
            decoded = self._database.decode(frame, row, description, signal).series.value
            if len(decoded):
                time_s = message.timestamp - self._start_s - mapping.delay_s
                self.core.input(mapping.channel, time_s, float(decoded[0]) * factor)
        return []

    def advance(self, time_s: float) -> None:
        """Time goes on without a frame: nothing is due."""
        del time_s

    def status(self) -> npt.NDArray[Any]:
        """The newest status, shape (1,)."""
        return self.core.status()

    def faults(self) -> dict[str, int]:
        """Faults of samples are in the status."""
        return {}
