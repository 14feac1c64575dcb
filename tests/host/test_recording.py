"""Every log format: what is written is read back, what is damaged is refused."""

from __future__ import annotations

import struct
from pathlib import Path

import can
import numpy as np
import pytest
from conftest import DATA

from swaywatch.errors import RecordingError, SignalError
from swaywatch.recording import FRAME_SUFFIXES, Frames, Series, read_recording, write_recording
from swaywatch.recording.dbc import Database, encode_messages, frames_by_identifier

RUN = DATA / "practice" / "p01" / "run1.blf"
DBC = DATA / "practice" / "measurement.dbc"


@pytest.fixture(scope="module")
def frames() -> Frames:
    content = read_recording(RUN).frames
    assert content is not None
    return content.take(slice(0, 3000))


def test_blf_reader_agrees_with_python_can() -> None:
    ours = read_recording(RUN).frames
    assert ours is not None
    with can.BLFReader(str(RUN)) as reader:
        theirs = list(reader)
    assert len(theirs) == len(ours)
    assert [m.arbitration_id for m in theirs] == ours.identifier.tolist()
    assert b"".join(bytes(m.data) for m in theirs) == ours.data.tobytes()
    worst = max(
        abs(m.timestamp - t * 1e-9) for m, t in zip(theirs, ours.time_ns.tolist(), strict=True)
    )
    assert worst < 1e-6


@pytest.mark.parametrize("suffix", FRAME_SUFFIXES)
def test_frames_come_back(tmp_path: Path, frames: Frames, suffix: str) -> None:
    path = tmp_path / f"copy{suffix}"
    write_recording(path, frames)
    back = read_recording(path).frames
    assert back is not None
    assert np.array_equal(back.identifier, frames.identifier)
    assert np.array_equal(back.data, frames.data)
    assert np.array_equal(back.length, frames.length)
    assert not back.extended.any()
    step = np.diff(back.time_ns) - np.diff(frames.time_ns)
    assert np.abs(step).max() <= 2000  # formats keep 1 us, at both ends of a step
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("suffix", FRAME_SUFFIXES)
def test_extended_short_and_fd_frames_come_back(tmp_path: Path, suffix: str) -> None:
    data = np.zeros((3, 64), dtype=np.uint8)
    data[0, :3] = (1, 2, 3)
    data[2, :64] = np.arange(64)
    content = Frames(
        np.array([0, 1, 2], dtype=np.int64) * 10_000_000 + 1_700_000_000_000_000_000,
        np.array([0x123, 0x18FEF100, 0x321], dtype=np.uint32),
        np.array([False, True, False]),
        np.array([3, 0, 64], dtype=np.uint8),
        data,
        np.zeros(3, dtype=np.uint8),
    )
    if suffix == ".trc":
        with pytest.raises(RecordingError, match="classic CAN"):
            write_recording(tmp_path / "x.trc", content)
        return
    write_recording(tmp_path / f"x{suffix}", content)
    back = read_recording(tmp_path / f"x{suffix}").frames
    assert back is not None
    assert back.identifier.tolist() == content.identifier.tolist()
    assert back.extended.tolist() == [False, True, False]
    assert back.length.tolist() == [3, 0, 64]
    assert np.array_equal(back.data, data)


@pytest.mark.parametrize("suffix", [".mf4", ".csv", ".parquet"])
def test_signals_come_back(tmp_path: Path, suffix: str) -> None:
    time_ns = np.arange(50, dtype=np.int64) * 10_000_000 + 1_000_000_000
    content = {
        "Yaw": Series(time_ns, np.sin(time_ns * 1e-9), "deg/s"),
        "Speed": Series(time_ns[::5], np.full(10, 33.0), "m/s"),
    }
    path = tmp_path / f"signals{suffix}"
    write_recording(path, content)
    back = read_recording(path).signals
    assert back is not None
    for name, series in content.items():
        assert back[name].unit == series.unit
        assert np.allclose(back[name].value, series.value)
        step = np.diff(back[name].time_ns) - np.diff(series.time_ns)
        assert np.abs(step).max() < 1000


@pytest.mark.parametrize("suffix", FRAME_SUFFIXES)
@pytest.mark.parametrize("part", [0.03, 0.37, 0.81, 0.999])
def test_truncated_files_are_refused(
    tmp_path: Path, frames: Frames, suffix: str, part: float
) -> None:
    whole = tmp_path / f"whole{suffix}"
    write_recording(whole, frames)
    raw = whole.read_bytes()
    cut = int(len(raw) * part)
    if suffix in (".asc", ".log", ".trc", ".csv"):
        cut = raw.rfind(b"\n", 0, cut) + 9  # inside a line: between lines nobody can tell
    path = tmp_path / f"cut{suffix}"
    path.write_bytes(raw[:cut])
    with pytest.raises(RecordingError, match=f"cut{suffix}"):
        read_recording(path)


@pytest.mark.parametrize("suffix", FRAME_SUFFIXES)
def test_other_content_is_refused(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"image{suffix}"
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 40)
    with pytest.raises(RecordingError, match="image"):
        read_recording(path)


@pytest.mark.parametrize("suffix", FRAME_SUFFIXES)
def test_empty_files_are_refused(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"empty{suffix}"
    path.write_bytes(b"")
    with pytest.raises(RecordingError, match="empty"):
        read_recording(path)


@pytest.mark.parametrize("suffix", FRAME_SUFFIXES)
def test_recordings_without_frames_are_refused(tmp_path: Path, frames: Frames, suffix: str) -> None:
    path = tmp_path / f"none{suffix}"
    write_recording(path, frames.take(slice(0, 0)))
    with pytest.raises(RecordingError, match="none"):
        read_recording(path)


def test_blf_object_of_size_zero_is_refused(tmp_path: Path) -> None:
    raw = bytearray(RUN.read_bytes())
    (header,) = struct.unpack_from("<L", raw, 4)
    struct.pack_into("<L", raw, header + 8, 0)
    path = tmp_path / "zero.blf"
    path.write_bytes(raw)
    with pytest.raises(RecordingError, match="size 0"):
        read_recording(path)


def test_blf_object_of_size_zero_inside_a_container_is_refused(tmp_path: Path) -> None:
    inner = struct.pack("<4sHHLL", b"LOBJ", 32, 1, 0, 1) + bytes(48)
    container = struct.pack("<4sHHLL", b"LOBJ", 16, 1, 32 + len(inner), 10)
    container += struct.pack("<H6xL4x", 0, len(inner)) + inner
    raw = RUN.read_bytes()
    (header,) = struct.unpack_from("<L", raw, 4)
    path = tmp_path / "inner.blf"
    start = bytearray(raw[:header])
    struct.pack_into("<Q", start, 16, header + len(container))
    path.write_bytes(bytes(start) + container)
    with pytest.raises(RecordingError, match="size 0"):
        read_recording(path)


def test_candump_error_frames_and_losses_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "lossy.log"
    path.write_text(
        "(10.000000) can0 123#0102\n"
        "(10.000100) can0 20000080#0000000000000000\n"
        "DROPCOUNT: dropped 7 CAN frames on 'can0' socket (total drops 7)\n"
        "(10.000200) can0 124#R\n"
        "(10.000300) can0 125#\n"
    )
    recording = read_recording(path)
    assert recording.frames is not None
    assert recording.frames.identifier.tolist() == [0x123, 0x125]
    assert recording.error_frames == 1
    assert recording.remote_frames == 1
    assert recording.dropped_frames == 7


@pytest.mark.parametrize("suffix", [".asc", ".log", ".trc", ".csv"])
def test_bytes_that_are_not_utf8_are_refused(tmp_path: Path, frames: Frames, suffix: str) -> None:
    path = tmp_path / f"bytes{suffix}"
    write_recording(path, frames)
    raw = path.read_bytes()
    middle = raw.find(b"\n", len(raw) // 2)
    path.write_bytes(raw[:middle] + b"\xff\xfe\xe4" + raw[middle:])
    with pytest.raises(RecordingError, match="bytes"):
        read_recording(path)


def test_a_clock_set_back_is_refused(tmp_path: Path, frames: Frames) -> None:
    time_ns = frames.time_ns.copy()
    time_ns[1500:] -= 60_000_000_000
    back = Frames(
        time_ns, frames.identifier, frames.extended, frames.length, frames.data, frames.bus
    )
    write_recording(tmp_path / "back.log", back)
    with pytest.raises(RecordingError, match="jumps back"):
        read_recording(tmp_path / "back.log")


def test_nothing_is_left_of_a_write_that_fails(tmp_path: Path, frames: Frames) -> None:
    path = tmp_path / "kept.blf"
    path.write_bytes(b"old")
    broken = Frames(
        frames.time_ns, frames.identifier[:10], frames.extended, frames.length, frames.data,
        frames.bus,
    )  # fmt: skip
    with pytest.raises(ValueError, match="shorter"):
        write_recording(path, broken)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_decoding_agrees_with_cantools(frames: Frames) -> None:
    database = Database([DBC])
    rows = frames_by_identifier(frames)
    for message in database.messages.values():
        here = rows[(message.frame_id, message.is_extended_frame)]
        reference = [message.decode(frames.data[row].tobytes()) for row in here]
        for signal in message.signals:
            decoded = database.decode(frames, here, message, signal)
            assert np.allclose(
                decoded.series.value, [float(values[signal.name]) for values in reference]
            )


def test_odd_layouts_decode_as_cantools_does(tmp_path: Path) -> None:
    path = tmp_path / "odd.dbc"
    path.write_text(
        'VERSION ""\nNS_ :\nBS_:\nBU_: A\nBO_ 5 Odd: 8 A\n'
        ' SG_ MotorolaOdd : 5|11@0- (0.5,-3) [0|0] "x" A\n'
        ' SG_ IntelOdd : 19|13@1- (2,1) [0|0] "x" A\n'
        ' SG_ Wide : 39|31@0+ (1,0) [0|0] "x" A\n'
        'BO_ 6 Real: 8 A\n SG_ F32 : 0|32@1- (1,0) [0|0] "x" A\nSIG_VALTYPE_ 6 F32 : 1;\n'
    )
    database = Database([path])
    random = np.random.default_rng(1)
    data = random.integers(0, 256, (200, 8), dtype=np.uint8)
    data[:, 3] &= 0x3F  # keeps the float finite
    for name in ("Odd", "Real"):
        message = database.messages[name]
        content = Frames(
            np.arange(200, dtype=np.int64), np.full(200, message.frame_id, np.uint32),
            np.zeros(200, np.bool_), np.full(200, 8, np.uint8), data, np.zeros(200, np.uint8),
        )  # fmt: skip
        reference = [message.decode(row.tobytes()) for row in data]
        for signal in message.signals:
            decoded = database.decode(content, np.arange(200), message, signal)
            expected = [float(values[signal.name]) for values in reference]
            assert np.allclose(decoded.series.value, expected)
            again = encode_messages(
                database, {name: (content.time_ns, {signal.name: np.array(expected)})}
            )
            back = database.decode(again, np.arange(200), message, signal)
            assert np.allclose(back.series.value, expected)


@pytest.mark.parametrize(
    ("line", "word"),
    [
        (' SG_ S : 0|16@1- (0,0) [0|0] "x" A', "scale of 0"),
        (' SG_ S : 60|16@1- (1,0) [0|0] "x" A', "DBC"),
        ("garbage", "DBC"),
    ],
)
def test_dbc_files_without_sense_are_refused(tmp_path: Path, line: str, word: str) -> None:
    path = tmp_path / "bad.dbc"
    path.write_text(f'VERSION ""\nNS_ :\nBS_:\nBU_: A\nBO_ 5 M: 8 A\n{line}\n')
    with pytest.raises(SignalError, match=word):
        Database([path])
