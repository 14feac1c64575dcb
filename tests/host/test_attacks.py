"""Files made to hurt: refused in one sentence, in little time and memory, and nothing is run."""

from __future__ import annotations

import os
import resource
import shutil
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from conftest import DATA

from swaywatch.drive import load_drives
from swaywatch.errors import SwaywatchError
from swaywatch.recording import Frames, read_recording, write_recording
from swaywatch.recording.dbc import Database, frames_by_identifier
from swaywatch.vehicle_file import load_vehicle

PRACTICE = DATA / "practice"
P01 = PRACTICE / "p01"
BOMB = 640 << 20


def blf_bomb(path: Path) -> None:
    """600 kB that inflate to 640 MB, in containers that say so."""
    part = zlib.compress(bytes(BOMB // 16), 9)
    head = struct.pack("<4sHHLL", b"LOBJ", 16, 1, 32 + len(part), 10)
    container = head + struct.pack("<H6xL4x", 2, BOMB // 16) + part + bytes(len(part) % 4)
    path.write_bytes(b"LOGG" + struct.pack("<L", 144) + bytes(136) + 16 * container)


def blf_liar(path: Path) -> None:
    """One container that says 1000 bytes and holds 640 MB."""
    packer = zlib.compressobj(9)
    part = b"".join(packer.compress(bytes(1 << 24)) for _ in range(BOMB >> 24)) + packer.flush()
    head = struct.pack("<4sHHLL", b"LOBJ", 16, 1, 32 + len(part), 10)
    path.write_bytes(
        b"LOGG" + struct.pack("<L", 144) + bytes(136)
        + head + struct.pack("<H6xL4x", 2, 1000) + part
    )  # fmt: skip


def parquet_bomb(path: Path) -> None:
    """Equal numbers of which only their count is kept."""
    rows = BOMB // 8 // 64
    same = pa.array(np.zeros(rows))
    names = ["time_s", *(f"v{i}" for i in range(63))]
    pyarrow.parquet.write_table(pa.table([same] * 64, names=names), path, compression="zstd")


def parquet_of_long_texts(path: Path) -> None:
    """One text of 1 MB, 640 times."""
    count = 640
    text = pa.DictionaryArray.from_arrays(pa.array(np.zeros(count, np.int32)), ["00" * (1 << 19)])
    table = pa.table(
        {
            "time_ns": np.arange(count), "identifier": np.full(count, 1),
            "extended": [False] * count, "bus": np.zeros(count, np.int64),
            "data": text,
        }
    )  # fmt: skip
    pyarrow.parquet.write_table(table, path, compression="zstd")


def candump_line(path: Path) -> None:
    """One line of 100 kB makes every other as wide."""
    lines = [f"({100 + n * 1e-3:.6f}) can0 123#0011" for n in range(50_000)]
    lines[7] = "(100.007000) can0 123#" + "00" * 100_000
    path.write_text("\n".join(lines) + "\n")


def csv_of_frames(path: Path) -> None:
    rows = [f"{n},5,false,0,0011" for n in range(50_000)]
    rows[7] = "7,5,false,0," + "00" * 100_000
    path.write_text("time_ns,identifier,extended,bus,data\n" + "\n".join(rows) + "\n")


def mf4_bomb(path: Path) -> None:
    """The packed data of a recording, exchanged for 640 MB of zeros."""
    frames = read_recording(P01 / "run1.blf").frames
    assert frames is not None
    write_recording(path, frames)
    raw = bytearray(path.read_bytes())
    packer = zlib.compressobj(9)
    part = b"".join(packer.compress(bytes(1 << 24)) for _ in range(BOMB >> 24)) + packer.flush()
    at = raw.index(b"##DZ")
    size = struct.unpack_from("<Q", raw, at + 8)[0]
    block = raw[at : at + 24] + raw[at + 24 : at + 32] + struct.pack("<QQ", 100_000, len(part))
    struct.pack_into("<Q", block, 8, 48 + len(part))
    link = raw.rindex(struct.pack("<Q", at))
    end = len(raw) + -len(raw) % 8
    struct.pack_into("<Q", raw, link, end)
    raw[at : at + size] = bytes(size)
    path.write_bytes(bytes(raw) + bytes(end - len(raw)) + bytes(block) + part)


BOMBS: dict[str, Callable[[Path], None]] = {
    "bomb.blf": blf_bomb,
    "liar.blf": blf_liar,
    "bomb.parquet": parquet_bomb,
    "texts.parquet": parquet_of_long_texts,
    "line.log": candump_line,
    "frames.csv": csv_of_frames,
    "bomb.mf4": mf4_bomb,
}


@pytest.mark.parametrize("name", BOMBS)
def test_small_files_stay_small(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    BOMBS[name](path)
    code = (
        "import sys, resource\n"
        "from pathlib import Path\n"
        "from swaywatch.errors import RecordingError\n"
        "from swaywatch.recording import read_recording\n"
        "import asammdf, pyarrow.parquet, pyarrow.csv\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "try:\n    read_recording(Path(sys.argv[1]))\n"
        "except RecordingError as error:\n    print(error)\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)],
        capture_output=True, text=True, timeout=120, check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30)),
    )  # fmt: skip
    said, grown_kb = done.stdout.rsplit("\n", 2)[:2]
    assert name in said, done.stdout + done.stderr
    assert int(grown_kb) < 400_000


@pytest.mark.parametrize("name", ["run.blf", "run.log", "run.csv", "run.mf4", "run.parquet"])
def test_a_pipe_is_no_recording(tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / name)
    with pytest.raises(SwaywatchError, match=f"{name}: is a pipe"):
        read_recording(tmp_path / name)


def test_pipes_and_devices_are_no_descriptions(tmp_path: Path) -> None:
    with pytest.raises(SwaywatchError, match="is a pipe or a device"):
        load_vehicle("/dev/zero")
    os.mkfifo(tmp_path / "a.dbc")
    with pytest.raises(SwaywatchError, match=r"a\.dbc: is a pipe"):
        Database([tmp_path / "a.dbc"])


def test_blanks_in_a_header_cost_nothing(tmp_path: Path) -> None:
    path = tmp_path / "blanks.csv"
    path.write_text(f"time_s,a{' ' * 200_000}b\n" + "".join(f"{n / 100},1\n" for n in range(9)))
    assert read_recording(path).signals is not None


# --- descriptions that make no sense --------------------------------------------------------------


def with_mapping(folder: Path, entry: str, above: str = "") -> Path:
    path = folder / "signals.toml"
    above = above or f"dbc = '{PRACTICE / 'measurement.dbc'}'"
    path.write_text(f"{above}\n[signals]\nspeed = {entry}\n")
    return path


@pytest.mark.parametrize(
    ("entry", "word"),
    [
        ("{ signal = [] }", "signal"),
        ("{ signal = 5 }", "signal"),
        ("{ signal = [1, 2] }", "signal"),
        ('{ signal = "" }', "signal"),
        ("[]", "signal"),
        ('{ signal = "VehicleSpeed", unit = 5 }', "unit"),
        ('{ signal = "VehicleSpeed", scale = nan }', "scale"),
        ('{ signal = "VehicleSpeed", scale = 0 }', "scale"),
        ('{ signal = "VehicleSpeed", scale = inf }', "scale"),
        ('{ signal = "VehicleSpeed", delay = 1e300 }', "delay"),
        ('{ signal = "VehicleSpeed", delay = 1e5 }', "delay"),
        (f'{{ signal = "VehicleSpeed", scale = {"9" * 400} }}', "scale"),
        (f'{{ signal = "VehicleSpeed", scale = {"9" * 5000} }}', "TOML"),
        ("[" * 3000 + "]" * 3000, "nested"),
    ],
)
def test_mappings_that_make_no_sense(tmp_path: Path, entry: str, word: str) -> None:
    with pytest.raises(SwaywatchError, match=rf"signals\.toml.*{word}"):
        load_drives([P01 / "run1.blf"], with_mapping(tmp_path, entry))


def test_a_name_that_no_file_can_have(tmp_path: Path) -> None:
    path = with_mapping(tmp_path, '"VehicleSpeed"', 'dbc = "a\\u0000b.dbc"')
    with pytest.raises(SwaywatchError, match="cannot be the name"):
        load_drives([P01 / "run1.blf"], path)


@pytest.mark.parametrize("mass", ["9" * 400, "9" * 5000, "inf", "nan", "1e400"])
def test_masses_that_no_car_has(tmp_path: Path, mass: str) -> None:
    path = tmp_path / "vehicle.toml"
    text = (P01 / "vehicle.toml").read_text()
    path.write_text(text.replace("mass = 1955", f"mass = {mass}", 1))
    with pytest.raises(SwaywatchError, match=r"vehicle\.toml"):
        load_vehicle(path)


# --- recordings and DBCs that do not fit ----------------------------------------------------------


def frames_of(payloads: list[bytes], identifier: int = 0x123) -> Frames:
    data = np.zeros((len(payloads), 8), np.uint8)
    for row, payload in enumerate(payloads):
        data[row, : len(payload)] = list(payload)
    count = len(payloads)
    return Frames(
        np.arange(count, dtype=np.int64) * 10_000_000,
        np.full(count, identifier, np.uint32),
        np.zeros(count, np.bool_),
        np.array([len(p) for p in payloads], np.uint8),
        data,
        np.zeros(count, np.uint8),
    )


def database(tmp_path: Path, message: str) -> Database:
    path = tmp_path / "test.dbc"
    path.write_text(f'VERSION ""\nNS_ :\nBS_:\nBU_: A\n{message}\n')
    return Database([path])


def test_a_signal_beyond_the_frames(tmp_path: Path) -> None:
    base = database(tmp_path, 'BO_ 291 M: 64 A\n SG_ Far : 400|16@1+ (1,0) [0|0] "" A\n')
    frames = frames_of([bytes(8)] * 5)
    found = base.find("Far")
    assert found is not None
    decoded = base.decode(frames, np.arange(5), *found)
    assert decoded.short_frames == 5
    assert len(decoded.series.value) == 0


NESTED = """BO_ 291 M: 8 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" A
 SG_ Sub m1M : 8|8@1+ (1,0) [0|0] "" A
 SG_ Deep m2 : 16|8@1+ (1,0) [0|0] "" A
SG_MUL_VAL_ 291 Sub Page 1-1;
SG_MUL_VAL_ 291 Deep Sub 2-2;
"""


def test_a_signal_of_a_page_that_is_not_sent_is_not_decoded(tmp_path: Path) -> None:
    base = database(tmp_path, NESTED)
    frames = frames_of([bytes([1, 2, 77]), bytes([0, 2, 88]), bytes([1, 3, 99]), bytes([1])])
    found = base.find("Deep")
    assert found is not None
    rows = frames_by_identifier(frames)[(291, False)]
    decoded = base.decode(frames, rows, *found)
    assert decoded.series.value.tolist() == [77.0]
    assert decoded.short_frames == 1


@pytest.mark.parametrize("scale", ["nan", "1e999", "-1e60"])
def test_scales_that_no_signal_has(tmp_path: Path, scale: str) -> None:
    with pytest.raises(SwaywatchError, match=r"test\.dbc"):
        database(tmp_path, f'BO_ 291 M: 8 A\n SG_ X : 0|8@1+ ({scale},0) [0|0] "" A\n')


LOGS = {
    "long.log": "(1.0) can0 123#" + "00" * 256 + "\n(1.1) can0 123#00\n",
    "drops.log": f"(1.0) can0 123#00\nDROPCOUNT: dropped {'9' * 5000} CAN frames\n",
    "seven.trc": ";$FILEVERSION=2.1\n;$STARTTIME=43474.5\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n"
    "1 1.000 DT 1 0123 Rx - 8 00 11 22 33 44 55 66 77\n"
    "2 2.000 DT 1 0123 Rx - 8 00 11 22 33 44 55 66\n",
    "twice.csv": "time_s,v,v\n0,1,2\n0.01,1,2\n",
    "leap.csv": "time_s,v\n0,1\n0.01,1\n9.3e9,1\n",
    "week.csv": "time_s,v\n0,1\n0.01,1\n600000,1\n",
    "half.csv": "time_ns,identifier,extended,bus,data\n0,1,false,0,012\n1,1,false,0,0123\n",
    "wide.csv": "time_ns,identifier,extended,bus,data\n0,4294967301,false,0,01\n",
    "clock.csv": "time,v\n10:00:00.5,1\n10:00:00.6,1\n",
    "one.csv": "time,v\n0,1\n1,1\n2,1\n",
}


@pytest.mark.parametrize("name", LOGS)
def test_texts_that_make_no_sense(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(LOGS[name])
    with pytest.raises(SwaywatchError, match=name):
        read_recording(tmp_path / name)


def test_a_sample_that_no_sensor_gives(tmp_path: Path) -> None:
    path = tmp_path / "wild.csv"
    rows = [f"{n / 100},30" for n in range(500)]
    rows[250] = "2.50,1e155"
    path.write_text("time_s,v [m/s]\n" + "\n".join(rows) + "\n")
    with pytest.raises(SwaywatchError, match=r"wild\.csv.*'v'.*1e\+155.*sample 251"):
        load_drives([path], with_mapping(tmp_path, '"v"'))


def test_a_blf_cut_between_two_containers(tmp_path: Path) -> None:
    raw = (P01 / "run1.blf").read_bytes()
    cut = raw.rindex(b"LOBJ" + struct.pack("<HHL", 16, 1, 0)[:4])
    (tmp_path / "cut.blf").write_bytes(raw[:cut])
    with pytest.raises(SwaywatchError, match=r"cut\.blf: truncated"):
        read_recording(tmp_path / "cut.blf")


# --- forms of tables that other tools write -------------------------------------------------------

ROWS = [(0.01 * n, 100.0 + n) for n in range(20)]
TABLES = {
    "ms": "time,v [km/h]\n" + "".join(f"{1000 * t:g},{v}\n" for t, v in ROWS),
    "us": "timestamp,v [km/h]\n" + "".join(f"{1e6 * t:.0f},{v}\n" for t, v in ROWS),
    "units": "time,v\nms,km/h\n" + "".join(f"{1000 * t:g},{v}\n" for t, v in ROWS),
    "brackets": "time,v\n[s],[km/h]\n" + "".join(f"{t:g},{v}\n" for t, v in ROWS),
    "dates": "timestamp,v [km/h]\n"
    + "".join(f"2026-01-31T12:00:{t:06.3f},{v}\n" for t, v in ROWS),
    "zone": "time,v [km/h]\n" + "".join(f"2026-01-31 12:00:{t:06.3f}Z,{v}\n" for t, v in ROWS),
    "remarks": "# by a logger\n\n# of 2026\ntime_s,v [km/h]\n"
    + "".join(f"{t:g},{v}\n" for t, v in ROWS[:9])
    + "# a break\n"
    + "".join(f"{t:g},{v}\n" for t, v in ROWS[9:]),
    "savetxt": "# time_s,v [km/h]\n" + "".join(f"{t:g},{v}\n" for t, v in ROWS),
    "excel": "sep=;\r\ntime_s;v [km/h]\r\n"
    + "".join(f"{t:g};{v:g}\r\n".replace(".", ",") for t, v in ROWS),
}  # fmt: skip


@pytest.mark.parametrize("name", TABLES)
def test_tables_of_other_tools(tmp_path: Path, name: str) -> None:
    path = tmp_path / f"{name}.csv"
    path.write_text(TABLES[name], newline="")
    signals = read_recording(path).signals
    assert signals is not None
    series = signals["v"]
    assert series.unit == "km/h"
    assert series.value.tolist() == [v for _, v in ROWS]
    step = np.diff(series.time_ns)
    assert np.abs(step - 10_000_000).max() <= 1000


def test_columns_of_text_are_named(tmp_path: Path) -> None:
    path = tmp_path / "text.csv"
    path.write_text("time_s,v,gear\n0,1,D\n0.01,1,R\n")
    assert "gear" in " ".join(read_recording(path).notes)


def test_a_named_signal_whose_message_was_not_sent(tmp_path: Path) -> None:
    """One that nothing can be said without is refused; without another it is said and goes on."""
    from swaywatch.analysis import analyze

    frames = read_recording(P01 / "run1.blf").frames
    assert frames is not None
    for name in ("YawRate1", "YawRate2"):
        yaw = Database([PRACTICE / "measurement.dbc"]).find(name)
        assert yaw is not None
        write_recording(tmp_path / "run.blf", frames.take(frames.identifier != yaw[0].frame_id))
        if name == "YawRate1":
            words = rf"{name}.*{yaw[0].name}.*0x{yaw[0].frame_id:X}"
            with pytest.raises(SwaywatchError, match=words):
                analyze([tmp_path / "run.blf"], P01 / "vehicle.toml", P01 / "signals.toml")
            continue
        result = analyze([tmp_path / "run.blf"], P01 / "vehicle.toml", P01 / "signals.toml")[0]
        assert any(name in finding.text for finding in result.findings)


# --- a folder of recordings that carries code -----------------------------------------------------


def test_no_module_is_taken_from_the_folder_of_recordings(tmp_path: Path) -> None:
    folder = tmp_path / "runs"
    folder.mkdir()
    (folder / "broken.blf").write_bytes((P01 / "run1.blf").read_bytes()[:3000])
    for name in ("vehicle.toml", "signals.toml"):
        shutil.copy(P01 / name, folder / name)
    shutil.copy(PRACTICE / "measurement.dbc", tmp_path)
    for name in ("plotly", "jinja2", "numpy", "scipy", "can", "json", "swaywatch", "numba"):
        (folder / f"{name}.py").write_text(
            f"open({str(tmp_path / 'it_ran')!r}, 'a').write('{name} ')\nraise ImportError\n"
        )
    done = subprocess.run(
        [Path(sys.executable).parent / "swaywatch", "survey", "."],
        cwd=folder, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert not (tmp_path / "it_ran").exists(), (tmp_path / "it_ran").read_text()
    assert done.returncode == 1
    assert "broken.blf" in done.stdout
    assert "truncated BLF" in done.stdout


def test_every_child_process_takes_no_module_from_its_folder() -> None:
    package = Path(load_vehicle.__code__.co_filename).parent
    for path in package.rglob("*.py"):
        lines = path.read_text().splitlines()
        for number, line in enumerate(lines):
            if "sys.executable" in line:
                assert '"-P"' in line or '"-I"' in line, f"{path}:{number + 1}"
