"""Vector BLF.

Reading is vectorised (python-can's reader makes an object per frame, which is too slow for hours
of recording, and loops for ever on an object of size 0); writing is python-can's.

A BLF file is a header "LOGG" and objects "LOBJ"; log containers (type 10) hold zlib-compressed
parts of one stream of further objects, which may straddle containers.
"""

from __future__ import annotations

import struct
import zlib
from array import array
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from swaywatch.errors import RecordingError
from swaywatch.recording import pythoncan
from swaywatch.recording.frames import (
    ByteArray,
    Frames,
    IntArray,
    Recording,
    in_time_order,
    make_frames,
)
from swaywatch.recording.guard import must_fit

_FILE_HEADER = struct.Struct("<4sLBBBBBBBBQQLL8H8H")
_OBJECT = struct.Struct("<4sHHLL")  # signature, header size, header version, size, type
_CAN_MESSAGE, _LOG_CONTAINER, _CAN_ERROR = 1, 10, 2
_CAN_ERROR_EXT, _CAN_MESSAGE2, _CAN_FD, _CAN_FD_64 = 73, 86, 100, 101
_DROPPED_TYPES = (54,)  # data lost begin
_FD_LENGTH = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64], dtype=np.uint8)


def read(path: Path) -> Recording:
    """Read every data frame of a BLF file.

    Raises
    ------
    RecordingError
        Not a BLF file; cut off; an object of impossible size.
    """
    raw = path.read_bytes()
    header_size, start_ns = _file_header(path, raw)
    stream = _inflate(path, raw, header_size)
    offsets, types = _index(path, stream)
    parts: list[tuple[IntArray, Frames]] = []
    buffer = np.frombuffer(stream, dtype=np.uint8)
    for kind in (_CAN_MESSAGE, _CAN_MESSAGE2, _CAN_FD, _CAN_FD_64):
        chosen = offsets[types == kind]
        if len(chosen):
            parts.append((chosen, _decode(path, buffer, chosen, kind, start_ns)))
    frames = _joined(parts)
    remote = frames.length == 255
    error_frames = int(np.isin(types, (_CAN_ERROR, _CAN_ERROR_EXT)).sum())
    frames, notes = in_time_order(frames.take(~remote), path)
    return Recording(
        path,
        "BLF",
        frames=frames,
        error_frames=error_frames,
        remote_frames=int(remote.sum()),
        dropped_frames=int(np.isin(types, _DROPPED_TYPES).sum()),
        notes=notes,
    )


def write(path: Path, frames: Frames) -> None:
    """Write frames as BLF."""
    pythoncan.write(path, frames)


def _file_header(path: Path, raw: bytes) -> tuple[int, int]:
    """Size of the file header and start of measurement in ns since 1970."""
    if raw[:4] != b"LOGG":
        raise RecordingError(
            f"{path}: not a BLF file: it starts with {raw[:4]!r}, a BLF file with b'LOGG'"
        )
    if len(raw) < _FILE_HEADER.size:
        raise RecordingError(f"{path}: truncated BLF: {len(raw)} bytes, its header needs 144")
    header = _FILE_HEADER.unpack_from(raw)
    size = int(header[1])
    if not _FILE_HEADER.size <= size <= len(raw):
        raise RecordingError(f"{path}: damaged BLF: header size {size}, should be 144")
    if header[10] > len(raw):
        raise RecordingError(
            f"{path}: truncated BLF: its header says {header[10]} bytes, {len(raw)} are there. "
            "Was the copy interrupted?"
        )
    year, month, _, day, hour, minute, second, milli = header[14:22]
    try:
        start = datetime(year, month, day, hour, minute, second, milli * 1000, tzinfo=UTC)
    except ValueError:
        return size, 0
    return size, round(start.timestamp() * 1000) * 1_000_000


def _inflate(path: Path, raw: bytes, offset: int) -> bytes:
    """The stream inside the containers."""
    chunks: list[bytes] = []
    unpacked = 0
    while offset < len(raw):
        if len(raw) - offset < _OBJECT.size:
            if any(raw[offset:]):
                raise _truncated(path, offset, _OBJECT.size, len(raw) - offset)
            break
        signature, header_size, _, size, kind = _OBJECT.unpack_from(raw, offset)
        if signature != b"LOBJ":
            raise RecordingError(
                f"{path}: damaged BLF: byte {offset} should start an object (b'LOBJ') "
                f"but holds {signature!r}"
            )
        _check_size(path, offset, size, header_size)
        if offset + size > len(raw):
            raise _truncated(path, offset, size, len(raw) - offset)
        if kind == _LOG_CONTAINER:
            if size < 32:
                _check_size(path, offset, size, 32)
            method, expected = struct.unpack_from("<H6xL", raw, offset + 16)
            unpacked += expected
            must_fit(path, unpacked, "BLF")
            body = raw[offset + 32 : offset + size]
            chunks.append(_unpack(path, offset, method, expected, body))
        else:  # objects may also stand outside containers
            chunks.append(raw[offset : offset + size + size % 4])
        offset += size + size % 4
    return b"".join(chunks)


def _unpack(path: Path, offset: int, method: int, expected: int, body: bytes) -> bytes:
    if method == 0:
        return body
    if method != 2:
        raise RecordingError(
            f"{path}: damaged BLF: container at byte {offset} has compression {method}, known: 0, 2"
        )
    unpacker = zlib.decompressobj()
    try:
        chunk = unpacker.decompress(body, expected + 1)
    except zlib.error as error:
        raise RecordingError(
            f"{path}: damaged BLF: container at byte {offset} does not decompress ({error})"
        ) from None
    if len(chunk) != expected or not unpacker.eof:
        more = " or more" if len(chunk) > expected else ""
        raise RecordingError(
            f"{path}: damaged BLF: container at byte {offset} holds {len(chunk)} bytes{more}, "
            f"says {expected}"
        )
    return chunk


def _check_size(path: Path, offset: int, size: int, header_size: int) -> None:
    if size < max(_OBJECT.size, header_size):
        raise RecordingError(
            f"{path}: damaged BLF: object at byte {offset} has size {size}, "
            f"at least {max(_OBJECT.size, header_size)} expected"
        )


def _truncated(path: Path, offset: int, needed: int, there: int) -> RecordingError:
    return RecordingError(
        f"{path}: truncated BLF: object at byte {offset} needs {needed} bytes, {there} are there. "
        "Was the logger switched off while writing, or the copy interrupted?"
    )


def _index(path: Path, stream: bytes) -> tuple[IntArray, IntArray]:
    """Offset and type of every object of the stream."""
    offsets, types = array("q"), array("q")
    unpack, end, offset = _OBJECT.unpack_from, len(stream) - _OBJECT.size, 0
    while offset <= end:
        signature, header_size, _, size, kind = unpack(stream, offset)
        if signature != b"LOBJ":
            shift = stream.find(b"LOBJ", offset, offset + 8)  # padding differs between writers
            if shift < 0:
                raise RecordingError(
                    f"{path}: damaged BLF: object {len(offsets) + 1} should start at byte {offset} "
                    "of the unpacked stream and does not"
                )
            offset = shift
            continue
        if size < 16 or size < header_size:
            _check_size(path, offset, size, header_size)
        offsets.append(offset)
        types.append(kind)
        offset += size + size % 4
    last = offsets[-1] if offsets else 0
    if offsets and last + _OBJECT.unpack_from(stream, last)[3] > len(stream):
        raise _truncated(path, last, _OBJECT.unpack_from(stream, last)[3], len(stream) - last)
    return np.array(offsets, dtype=np.int64), np.array(types, dtype=np.int64)


def _column(buffer: ByteArray, at: IntArray, dtype: str) -> np.ndarray:
    """The number of `dtype` at each byte offset `at`."""
    size = np.dtype(dtype).itemsize
    rows = np.empty((len(at), size), dtype=np.uint8)
    for byte in range(size):
        rows[:, byte] = buffer[at + byte]
    return rows.view(dtype)[:, 0]


def _decode(path: Path, buffer: ByteArray, at: IntArray, kind: int, start_ns: int) -> Frames:
    """Frames of one object type; remote frames get length 255."""
    header_size = _column(buffer, at + 4, "<u2").astype(np.int64)
    flags = _column(buffer, at + 16, "<u4")
    stamp = _column(buffer, at + 24, "<u8").astype(np.int64)
    time_ns = start_ns + np.where(flags == 1, stamp * 10_000, stamp)  # 1: 10 us, 2: 1 ns
    body = at + header_size
    size = _column(buffer, at + 8, "<u4").astype(np.int64)
    need = {_CAN_MESSAGE: 16, _CAN_MESSAGE2: 16, _CAN_FD: 20, _CAN_FD_64: 40}[kind]
    if np.any(size < header_size + need):
        bad = int(np.argmax(size < header_size + need))
        raise RecordingError(
            f"{path}: damaged BLF: frame object at byte {int(at[bad])} of the unpacked stream has "
            f"size {int(size[bad])}, at least {int(header_size[bad]) + need} expected"
        )
    if kind in (_CAN_MESSAGE, _CAN_MESSAGE2):
        bus, code = _column(buffer, body, "<u2"), buffer[body + 3]
        remote = (buffer[body + 2] & 0x80) != 0
        raw_id, first, width = _column(buffer, body + 4, "<u4"), body + 8, 8
        length = np.minimum(code, 8)
    elif kind == _CAN_FD:
        bus, remote = _column(buffer, body, "<u2"), (buffer[body + 2] & 0x80) != 0
        raw_id, first, width = _column(buffer, body + 4, "<u4"), body + 20, 64
        length = np.minimum(buffer[body + 14], 64)
    else:
        bus, code = buffer[body].astype(np.uint16), buffer[body + 1] & 15
        raw_id, first, width = _column(buffer, body + 4, "<u4"), body + 40, 64
        remote = (_column(buffer, body + 12, "<u4") & 0x0010) != 0
        length = np.minimum(buffer[body + 2], _FD_LENGTH[code])
    data = np.zeros((len(at), width), dtype=np.uint8)
    for byte in range(int(length.max(initial=0))):
        rows = length > byte
        where = first[rows] + byte
        if len(where) and int(where.max()) >= len(buffer):
            raise _truncated(path, int(at[-1]), int(size[-1]), len(buffer) - int(at[-1]))
        data[rows, byte] = buffer[where]
    return make_frames(
        time_ns,
        raw_id & 0x1FFFFFFF,
        (raw_id & 0x80000000) != 0,
        np.where(remote, 255, length),
        data,
        np.clip(bus.astype(np.int64) - 1, 0, 255),  # the file counts channels from 1
    )


def _joined(parts: list[tuple[IntArray, Frames]]) -> Frames:
    """Frames of all object types in the order of the file."""
    if not parts:
        nothing = np.zeros(0)
        return make_frames(nothing, nothing, nothing, nothing, np.zeros((0, 8), np.uint8), nothing)
    if len(parts) == 1:
        return parts[0][1]
    order = np.argsort(np.concatenate([offsets for offsets, _ in parts]), kind="stable")
    width = max(frames.data.shape[1] for _, frames in parts)
    data = [np.pad(f.data, ((0, 0), (0, width - f.data.shape[1]))) for _, f in parts]
    return Frames(
        np.concatenate([f.time_ns for _, f in parts])[order],
        np.concatenate([f.identifier for _, f in parts])[order],
        np.concatenate([f.extended for _, f in parts])[order],
        np.concatenate([f.length for _, f in parts])[order],
        np.concatenate(data)[order],
        np.concatenate([f.bus for _, f in parts])[order],
    )
