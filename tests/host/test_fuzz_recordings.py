"""A fixed few of the mutated files of ``make fuzz``, and those that it once found."""

from __future__ import annotations

import importlib.util
import math
import struct
import sys
from pathlib import Path
from types import ModuleType

import pytest
from asammdf import MDF

from swaywatch.errors import RecordingError
from swaywatch.recording import read_recording

PLACE = Path(__file__).resolve().parent.parent / "fuzz" / "fuzz_recordings.py"


@pytest.fixture(scope="module")
def fuzzer() -> ModuleType:
    spec = importlib.util.spec_from_file_location("fuzz_recordings", PLACE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_mutated_files_end_in_a_result_or_a_sentence(fuzzer: ModuleType) -> None:
    ended, findings = fuzzer.fuzz(math.inf, 1300, 20261122, None)
    assert findings == []
    assert sum(ended.values()) == 1300
    names = {name.split(":")[0] for name in ended}
    assert len(names) == 13
    refused = sum(count for name, count in ended.items() if name.endswith("refused"))
    assert refused > 0.2 * sum(ended.values())  # the mutations bite


@pytest.mark.parametrize("name", ["CAN_DataFrame.DataBytes", "speed"])
def test_a_channel_behind_its_record_is_refused(
    fuzzer: ModuleType, tmp_path: Path, name: str
) -> None:
    """Seed 20261124, file 7921: asammdf copied from behind its buffer and the interpreter ended."""
    fuzzer.seeds(tmp_path)
    path = tmp_path / ("frames.mf4" if name.startswith("CAN") else "signals.mf4")
    read_recording(path)
    with MDF(path) as mdf:
        group, index = mdf.channels_db[name][0]
        block = mdf.groups[group].channels[index]
        at, offset = block.address + 24 + 8 * block.links_nr + 4, block.byte_offset
    data = bytearray(path.read_bytes())
    assert struct.unpack_from("<I", data, at) == (offset,)
    struct.pack_into("<I", data, at, 55056)
    path.write_bytes(data)
    with pytest.raises(RecordingError, match=r"damaged MF4: channel .* of a record of \d+"):
        read_recording(path)


def test_fuzzing_hours_are_kept(tmp_path: Path) -> None:
    """What a run adds to RESULT.md is read again: more of the same version, a row of another."""
    spec = importlib.util.spec_from_file_location("fuzz_run", PLACE.with_name("run.py"))
    assert spec is not None
    assert spec.loader is not None
    run = importlib.util.module_from_spec(spec)
    sys.modules["fuzz_run"] = run  # its dataclass looks itself up there
    spec.loader.exec_module(run)
    result = tmp_path / "RESULT.md"
    for row in (
        run.Row("fuzz_xcp", "abc1234", "2026-11-25", 10.0, 5000, "**yes**"),
        run.Row("fuzz_real", "abc1234", "2026-11-25", 1.0, 7, "nothing"),
        run.Row("fuzz_xcp", "abc1234", "2026-11-26", 50.5, 6000, "nothing"),
        run.Row("fuzz_xcp", "fed4321x", "2026-11-27", 1.0, 1, "nothing"),
    ):
        rows = run.added(run.rows_of(result), row)
        result.write_text(run.TITLE + "".join(f"{r}\n" for r in rows))
    assert run.rows_of(result) == [
        run.Row("fuzz_real", "abc1234", "2026-11-25", 1.0, 7, "nothing"),
        run.Row("fuzz_xcp", "abc1234", "2026-11-26", 60.5, 11000, "**yes**"),
        run.Row("fuzz_xcp", "fed4321x", "2026-11-27", 1.0, 1, "nothing"),
    ]
    stretches = iter([(300.0, 50, "nothing"), (200.0, 40, "**yes**")])
    run.stretch = lambda name, build, seconds: next(stretches)
    run.version = lambda name: "0123456"
    assert run.run("fuzz_ecu", tmp_path, 900.0, result) == (500.0, 90, "**yes**")
    kept = [(r.minutes, r.inputs, r.found) for r in run.rows_of(result) if r.name == "fuzz_ecu"]
    assert kept == [(8.3, 90, "**yes**")]
    committed = PLACE.with_name("RESULT.md")
    assert {row.name for row in run.rows_of(committed)} == set(run.ATTACKS)
    assert all(row.found == "nothing" for row in run.rows_of(committed))
