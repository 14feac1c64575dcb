"""ASAM MDF 4 by asammdf: bus logging (CAN_DataFrame groups) or physical channels."""

from __future__ import annotations

import logging
import zlib
from datetime import UTC
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from swaywatch.errors import RecordingError
from swaywatch.recording.frames import (
    ByteArray,
    FloatArray,
    Frames,
    IntArray,
    Recording,
    Series,
    in_time_order,
    make_frames,
    must_rise,
)
from swaywatch.recording.guard import must_fit, refusing

_BUS_EVENT = 0x2  # flag of a channel group that holds bus events
_COUNTED = (3, 6)  # types of channel that are not in the record: its number is their value
_HAS_INVALIDATION = 0x2  # flag of a channel
_LINKING = (b"##DG", b"##DL", b"##HL", b"##LD", b"##CG", b"##CN")
_PLAIN = (b"##DT", b"##SD", b"##RD", b"##DV", b"##DI")
_CHUNK = 1 << 20
_TIME_NAMES = ("time", "timestamp", "timestamps", "t")


def read(path: Path) -> Recording:
    """Read an MF4: all CAN data frames of a bus logging, else all numeric channels.

    Raises
    ------
    RecordingError
        Not MDF; cut off; neither frames nor numeric channels in it.
    """
    with path.open("rb") as file:
        magic = file.read(8)
    if magic not in (b"MDF     ", b"UnFinMF "):
        raise RecordingError(
            f"{path}: not an MF4 file: it starts with {magic!r}, an MF4 file with b'MDF     '"
        )
    _check_whole(path)
    from asammdf import MDF  # heavy import, only for this format
    from asammdf.blocks.mdf_v4 import MDF4

    logging.getLogger("asammdf").setLevel(logging.CRITICAL)
    MDF4._file = None  # its destructor asks for it even where its constructor has failed
    with refusing(path, "MF4"), MDF(path) as mdf:
        _check_records(path, mdf)
        start_ns = round(mdf.header.start_time.timestamp() * 1e6) * 1000
        frame_groups = [i for i, group in enumerate(mdf.groups) if _holds(group, "CAN_DataFrame")]
        if frame_groups:
            return _read_frames(path, mdf, frame_groups, start_ns)
        signals = _read_signals(path, mdf, start_ns)
    if not signals:
        raise RecordingError(
            f"{path}: holds neither CAN frames (CAN_DataFrame) nor numeric channels with samples"
        )
    return Recording(path, "MF4", signals=signals)


def write_frames(path: Path, frames: Frames) -> None:
    """Write frames as an MF4 bus logging, one CAN_DataFrame group."""
    from asammdf import MDF, Signal, Source
    from asammdf.blocks import v4_constants

    start_ns = int(frames.time_ns[0]) if len(frames) else 0
    width = frames.data.shape[1]
    rows = np.empty(
        len(frames),
        dtype=[
            ("CAN_DataFrame.BusChannel", "<u1"),
            ("CAN_DataFrame.ID", "<u4"),
            ("CAN_DataFrame.IDE", "<u1"),
            ("CAN_DataFrame.DLC", "<u1"),
            ("CAN_DataFrame.DataLength", "<u1"),
            ("CAN_DataFrame.DataBytes", f"({width},)u1"),
            ("CAN_DataFrame.Dir", "<u1"),
        ],
    )
    rows["CAN_DataFrame.BusChannel"] = frames.bus
    rows["CAN_DataFrame.ID"] = frames.identifier
    rows["CAN_DataFrame.IDE"] = frames.extended
    rows["CAN_DataFrame.DLC"] = np.where(frames.length > 8, 15, frames.length)
    rows["CAN_DataFrame.DataLength"] = frames.length
    rows["CAN_DataFrame.DataBytes"] = frames.data
    rows["CAN_DataFrame.Dir"] = 0
    source = Source("CAN", "CAN", "", v4_constants.SOURCE_BUS, v4_constants.BUS_TYPE_CAN)
    with MDF(version="4.10") as mdf:
        _set_start(mdf, start_ns)
        mdf.append(
            Signal(
                samples=rows,
                timestamps=(frames.time_ns - start_ns) * 1e-9,
                name="CAN_DataFrame",
                source=source,
            ),
            acq_source=source,
            comment="CAN frames",
        )
        group: Any = mdf.groups[-1].channel_group
        group.flags |= v4_constants.FLAG_CG_BUS_EVENT | v4_constants.FLAG_CG_PLAIN_BUS_EVENT
        mdf.save(path, overwrite=True, compression=1)


def write_signals(path: Path, signals: dict[str, Series]) -> None:
    """Write decoded signals, one group for each time base."""
    from asammdf import MDF, Signal

    start_ns = min((int(s.time_ns[0]) for s in signals.values() if len(s.time_ns)), default=0)
    groups: dict[bytes, list[Any]] = {}
    for name, series in signals.items():
        time_s = (series.time_ns - start_ns) * 1e-9
        signal = Signal(
            samples=series.value, timestamps=time_s, name=name, unit=series.unit,
            comment=series.comment,
        )  # fmt: skip
        groups.setdefault(series.time_ns.tobytes(), []).append(signal)
    with MDF(version="4.10") as mdf:
        _set_start(mdf, start_ns)
        for members in groups.values():
            mdf.append(members, common_timebase=True)
        mdf.save(path, overwrite=True, compression=1)


def _set_start(mdf: Any, start_ns: int) -> None:
    from datetime import datetime

    mdf.header.start_time = datetime.fromtimestamp(start_ns / 1e9, tz=UTC)
    mdf.header.abs_time = start_ns


def _check_records(path: Path, mdf: Any) -> None:
    """Every channel lies within its record: asammdf reads it from wherever the file says."""
    for index, group in enumerate(mdf.groups):
        record = group.channel_group
        size = int(record.samples_byte_nr)
        for channel in group.channels if record.cycles_nr else []:
            if channel.channel_type in _COUNTED:
                continue
            end = int(channel.byte_offset) + -(-(channel.bit_offset + channel.bit_count) // 8)
            if end > size:
                raise RecordingError(
                    f"{path}: damaged MF4: channel {channel.name} of group {index} ends at byte "
                    f"{end} of a record of {size}"
                )
            bit = int(channel.pos_invalidation_bit)
            if channel.flags & _HAS_INVALIDATION and bit >= 8 * record.invalidation_bytes_nr:
                raise RecordingError(
                    f"{path}: damaged MF4: channel {channel.name} of group {index} says that bit "
                    f"{bit} of {8 * record.invalidation_bytes_nr} tells whether it is valid"
                )


def _holds(group: Any, name: str) -> bool:
    if not group.channel_group.flags & _BUS_EVENT or not group.channel_group.cycles_nr:
        return False
    return any(channel.name == name for channel in group.channels)


def _read_frames(path: Path, mdf: Any, groups: list[int], start_ns: int) -> Recording:
    parts = []
    for index in groups:
        columns = mdf.get("CAN_DataFrame", group=index, raw=True, ignore_invalidation_bits=True)
        samples, time_s = columns.samples, columns.timestamps
        cycles = int(mdf.groups[index].channel_group.cycles_nr)
        if len(samples) != cycles:
            raise RecordingError(
                f"{path}: truncated MF4: group {index} says {cycles} frames, {len(samples)} are "
                "there"
            )
        parts.append(_group_frames(path, samples, time_s, start_ns))
    frames = parts[0]
    if len(parts) > 1:
        width = max(part.data.shape[1] for part in parts)
        frames = make_frames(
            np.concatenate([part.time_ns for part in parts]),
            np.concatenate([part.identifier for part in parts]),
            np.concatenate([part.extended for part in parts]),
            np.concatenate([part.length for part in parts]),
            np.concatenate([np.pad(p.data, ((0, 0), (0, width - p.data.shape[1]))) for p in parts]),
            np.concatenate([part.bus for part in parts]),
        )
        order = np.argsort(frames.time_ns, kind="stable")
        frames = frames.take(order)
    frames, notes = in_time_order(frames, path)
    return Recording(
        path,
        "MF4",
        frames=frames,
        error_frames=_cycles(mdf, "CAN_ErrorFrame"),
        remote_frames=_cycles(mdf, "CAN_RemoteFrame"),
        notes=notes,
    )


def _cycles(mdf: Any, name: str) -> int:
    return sum(int(g.channel_group.cycles_nr) for g in mdf.groups if _holds(g, name))


def _group_frames(path: Path, samples: Any, time_s: FloatArray, start_ns: int) -> Frames:
    """Frames from the record array of a CAN_DataFrame channel."""
    prefix = "CAN_DataFrame."
    names = {name.removeprefix(prefix): name for name in samples.dtype.names}
    data: ByteArray = np.asarray(samples[names["DataBytes"]], dtype=np.uint8)
    count = len(samples)
    identifier = np.asarray(samples[names["ID"]], dtype=np.int64)
    if "IDE" in names:
        extended = np.asarray(samples[names["IDE"]]) != 0
    else:
        extended = (identifier & 0x80000000) != 0
    if "DataLength" in names:
        length = np.asarray(samples[names["DataLength"]], dtype=np.int64)
    else:
        length = np.asarray(samples[names["DLC"]], dtype=np.int64)
    bus = np.asarray(samples[names["BusChannel"]]) if "BusChannel" in names else np.zeros(count)
    return make_frames(
        _time_ns(path, time_s, start_ns),
        identifier & 0x1FFFFFFF,
        extended,
        np.minimum(length, data.shape[1]),
        data,
        bus,
    )


def _time_ns(path: Path, time_s: FloatArray, start_ns: int) -> IntArray:
    """Timestamps since 1970; refuses what is no number or no time."""
    bad = np.flatnonzero(~(np.abs(time_s) < 1e9))
    if len(bad):
        raise RecordingError(
            f"{path}: damaged MF4: record {int(bad[0]) + 1} has the time {time_s[bad[0]]:g} s"
        )
    time_ns: IntArray = start_ns + np.rint(time_s * 1e9).astype(np.int64)
    return time_ns


def _read_signals(path: Path, mdf: Any, start_ns: int) -> dict[str, Series]:
    """Every numeric channel; of channels of the same name the one with most samples."""
    signals: dict[str, Series] = {}
    for group_index, group in enumerate(mdf.groups):
        if not group.channel_group.cycles_nr:
            continue
        for channel_index, channel in enumerate(group.channels):
            if channel.channel_type in (2, 3) or channel.name.lower() in _TIME_NAMES:
                continue
            signal = mdf.get(group=group_index, index=channel_index)
            if signal.samples.dtype.kind not in "iufb" or signal.samples.ndim != 1:
                continue
            value = signal.samples.astype(np.float64)
            if signal.invalidation_bits is not None:
                value[np.asarray(signal.invalidation_bits)] = np.nan
            time_ns = _time_ns(path, signal.timestamps, start_ns)
            must_rise(path, time_ns)
            known = signals.get(channel.name)
            if known is None or len(known.time_ns) < len(time_ns):
                signals[channel.name] = Series(time_ns, value, signal.unit or "")
    return signals


def _check_whole(path: Path) -> None:
    """Walk the blocks; refuse links behind the end of the file, and more data than fit."""
    size = path.stat().st_size
    data = cycles = 0
    with path.open("rb") as file:
        file.seek(64)
        head = file.read(104)
        if len(head) < 104 or head[:4] != b"##HD":
            raise RecordingError(
                f"{path}: damaged MF4: byte 64 should hold the header block (##HD), "
                f"the file has {size} bytes"
            )
        pending = [int.from_bytes(head[24:32], "little")]
        seen: set[int] = set()
        while pending:
            address = pending.pop()
            if not address or address in seen:
                continue
            seen.add(address)
            kind, length, links = _block(path, file, address, size)
            if kind in _LINKING:
                raw = file.read(8 * min(links, 1 << 20))
                pending += np.frombuffer(raw[: len(raw) // 8 * 8], dtype="<u8").tolist()
            if kind == b"##CG":
                cycles += int.from_bytes(file.read(16)[8:], "little")
            elif kind == b"##DZ":
                data += _unpacked(path, file, address, size)
            elif kind in _PLAIN:
                data += length
            must_fit(path, data, "MF4")
    if cycles > data:
        raise RecordingError(
            f"{path}: damaged MF4: it says {cycles} records and has {data} bytes of data"
        )


def _block(path: Path, file: BinaryIO, address: int, size: int) -> tuple[bytes, int, int]:
    """Kind, length and number of links of a block; the file stands behind its head."""
    if address + 24 > size:
        raise RecordingError(
            f"{path}: truncated MF4: a link leads to byte {address} of a file of {size} bytes. "
            "Was the logger switched off while writing?"
        )
    file.seek(address)
    block = file.read(24)
    kind = block[:4]
    length = int.from_bytes(block[8:16], "little")
    if len(block) < 24 or kind[:2] != b"##" or address + max(length, 24) > size:
        raise RecordingError(
            f"{path}: truncated MF4: a block at byte {address} does not fit into the file's "
            f"{size} bytes. Was the logger switched off while writing?"
        )
    return kind, length, int.from_bytes(block[16:24], "little")


def _unpacked(path: Path, file: BinaryIO, address: int, size: int) -> int:
    """Bytes of a compressed block, which must become just as many as it says."""
    file.seek(address + 24)
    head = file.read(24)
    said, packed = (int.from_bytes(head[at : at + 8], "little") for at in (8, 16))
    must_fit(path, said, "MF4")
    if len(head) < 24 or address + 48 + packed > size:
        raise RecordingError(
            f"{path}: truncated MF4: the block at byte {address} says {packed} packed bytes, the "
            f"file has {size}"
        )
    if head[2] > 1:  # not zlib: the reader asks its library, which knows the size
        return said
    unpacker, found, rest = zlib.decompressobj(), 0, file.read(packed)
    try:
        while rest and found <= said:
            found += len(unpacker.decompress(rest, _CHUNK))
            rest = unpacker.unconsumed_tail
    except zlib.error as error:
        raise RecordingError(
            f"{path}: damaged MF4: the block at byte {address} does not decompress ({error})"
        ) from None
    if found != said:
        raise RecordingError(
            f"{path}: damaged MF4: the block at byte {address} says {said} bytes and unpacks to "
            f"{'more' if found > said else found}"
        )
    return said
