"""The whole ECU software through cffi: frames of ``swaywatch.dbc`` in, status frames out.

It is ``sway_node_t``, as in the daemon and the firmware: the same frames give the same bytes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from swaywatch.ecu._core import ffi, lib
from swaywatch.ecu.core import STATUS_DTYPE, core_config
from swaywatch.errors import VehicleError
from swaywatch.recording import Frames
from swaywatch.recording.frames import make_frames
from swaywatch.vehicle import Vehicle

_EXTENDED = 0x80000000


class Node:
    """One ``sway_node_t`` of its own.

    Parameters
    ----------
    vehicle
        The combination.
    positions_m
        Of the accelerometers, by channel, ahead of the COG.
    """

    def __init__(self, vehicle: Vehicle, positions_m: Mapping[str, float] | None = None) -> None:
        self._node = ffi.new("sway_node_t *")
        error = lib.sway_node_init(self._node, core_config(vehicle, positions_m))
        if error != lib.SWAY_OK:
            raise VehicleError(f"{vehicle.path}: the core refuses this configuration ({error})")
        self._id = ffi.new("uint32_t *")
        self._dlc = ffi.new("uint8_t *")
        self._data = ffi.new("uint8_t[8]")

    def receive(self, time_us: int, identifier: int, extended: bool, data: bytes) -> int:
        """One frame from the bus; the core's error code (0: used)."""
        can_id = identifier | (_EXTENDED if extended else 0)
        error = int(lib.sway_node_receive(self._node, time_us, can_id, len(data), data))
        while lib.sway_node_run(self._node):
            pass
        return error

    def advance(self, time_us: int) -> None:
        """Bus time goes on without a frame."""
        lib.sway_node_time(self._node, time_us)

    def transmit(self) -> Iterator[tuple[int, bytes]]:
        """The status frames that are due: identifier, data."""
        while lib.sway_node_transmit(self._node, self._id, self._dlc, self._data):
            yield int(self._id[0]), bytes(ffi.buffer(self._data, self._dlc[0]))

    def status(self) -> npt.NDArray[Any]:
        """The newest status, shape (1,)."""
        pointer = lib.sway_core_status(ffi.addressof(self._node.core))
        raw = bytes(ffi.buffer(pointer, ffi.sizeof("sway_status_t")))
        return np.frombuffer(raw, dtype=STATUS_DTYPE)

    @property
    def inputs_lost(self) -> bool:
        """A message that the judgement needs is not good."""
        return bool(lib.sway_node_inputs_lost(self._node))

    def fault_count(self) -> dict[str, int]:
        """Faults of received frames since start, by name."""
        names = ffi.typeof("sway_frame_fault_t").relements
        return {
            name.removeprefix("SWAY_FRAME_FAULT_").lower(): int(self._node.frame_fault[value])
            for name, value in sorted(names.items(), key=lambda item: item[1])
            if not name.endswith("_COUNT")
        }

    def replay(self, frames: Frames) -> Frames:
        """All status frames that the frames of a recording cause, with the times they were due."""
        time_us = np.ascontiguousarray(frames.time_ns // 1000)
        can_id = frames.identifier | np.where(frames.extended, _EXTENDED, 0).astype(np.uint32)
        can_id = np.ascontiguousarray(can_id, dtype=np.uint32)
        length = np.ascontiguousarray(frames.length)
        data = np.ascontiguousarray(frames.data)
        room = 4096
        out_time = np.zeros(room, dtype=np.int64)
        out_id = np.zeros(room, dtype=np.uint32)
        out_data = np.zeros((room, 8), dtype=np.uint8)
        next_frame = ffi.new("size_t *")
        times, identifiers, payloads = [], [], []
        while True:
            count = lib.core_replay(
                self._node,
                ffi.cast("int64_t *", time_us.ctypes.data),
                ffi.cast("uint32_t *", can_id.ctypes.data),
                ffi.cast("uint8_t *", length.ctypes.data),
                ffi.cast("uint8_t *", data.ctypes.data),
                data.shape[1],
                len(frames),
                next_frame,
                ffi.cast("int64_t *", out_time.ctypes.data),
                ffi.cast("uint32_t *", out_id.ctypes.data),
                ffi.cast("uint8_t *", out_data.ctypes.data),
                room,
            )
            times.append(out_time[:count].copy())
            identifiers.append(out_id[:count].copy())
            payloads.append(out_data[:count].copy())
            if next_frame[0] >= len(frames) and count < room:
                break
        total = sum(len(part) for part in times)
        return make_frames(
            np.concatenate(times) * 1000,
            np.concatenate(identifiers),
            np.zeros(total, dtype=np.bool_),
            np.full(total, 8),
            np.concatenate(payloads),
            np.zeros(total),
        )
