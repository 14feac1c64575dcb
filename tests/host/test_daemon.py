"""swaywatchd over candump logs: what it counts, and clear words for bad input."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from swaywatch.bus import encode_drive
from swaywatch.drive import load_drive
from swaywatch.recording import write_recording

ROOT = Path(__file__).resolve().parents[2]
DAEMON = ROOT / "build" / "swaywatchd"
CASES = ROOT / "tests" / "data" / "practice"

pytestmark = pytest.mark.skipif(not DAEMON.exists(), reason="build/swaywatchd is not built")


def replay(
    log: Path, case: str = "p01", *options: str
) -> tuple[subprocess.CompletedProcess[str], dict[str, int]]:
    """Run it over a log; the process and its counters."""
    done = subprocess.run(
        [DAEMON, "--vehicle", CASES / case / "vehicle.toml", *options, "--replay", log],
        capture_output=True,
        text=True,
        errors="replace",
        timeout=60,
        check=False,
    )
    counts = [line for line in done.stderr.splitlines() if "counts {" in line]
    return done, json.loads(counts[-1].split("counts ", 1)[1]) if counts else {}


@pytest.fixture(scope="module")
def good_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive as a candump log."""
    folder = CASES / "p01"
    drive = load_drive([folder / "run1.blf"], folder / "signals.toml")
    log = tmp_path_factory.mktemp("log") / "good.log"
    write_recording(log, encode_drive(drive))
    return log


def test_marks_of_direction_do_not_matter(good_log: Path, tmp_path: Path) -> None:
    marked = tmp_path / "marked.log"
    lines = good_log.read_text().splitlines()
    plain = [line.removesuffix(" R").removesuffix(" T") for line in lines]
    marked.write_text("\n".join(f"{line} R" for line in plain) + "\n")
    bare = tmp_path / "bare.log"
    bare.write_text("\r\n".join(plain) + "\r\n")
    assert replay(marked)[0].stdout == replay(bare)[0].stdout != ""


def test_what_is_no_data_frame_is_counted_by_kind(good_log: Path, tmp_path: Path) -> None:
    stamp = good_log.read_text().split(" ", 1)[0]
    extra = {
        "error_frames": f"{stamp} can0 20000004#0004000000000000",
        "foreign": f"{stamp} can0 12345678#0011",
        "dropped_by_logger": "DROPCOUNT: dropped 7 CAN frames on 'can0' socket (total drops 7)",
    }
    more = [f"{stamp} can0 123#R", f"{stamp} can0 123##0112233", ""]
    log = tmp_path / "mixed.log"
    log.write_text("\n".join([*extra.values(), *more]) + "\n" + good_log.read_text())
    done, counts = replay(log)
    assert done.returncode == 0
    assert counts["error_frames"] == 1
    assert counts["foreign"] == 3
    assert counts["dropped_by_logger"] == 7
    assert counts["unreadable"] == 0
    assert done.stdout == replay(good_log)[0].stdout


@pytest.mark.parametrize(
    "line",
    [
        b"\xff\xfe\x00garbage",
        b"(abc) can0 120#00",
        b"(1.0) can0 120#001",
        b"120#0011",
        b"(1.0) can0 9999#00",
        b"(1.0) can0 120#00112233445566778899",
        b"(" + b"1" * 400 + b") can0 120#00",
    ],
)
def test_unreadable_lines_are_told(good_log: Path, tmp_path: Path, line: bytes) -> None:
    log = tmp_path / "bad.log"
    log.write_bytes(line + b"\n" + good_log.read_bytes())
    done, counts = replay(log)
    assert done.returncode == 3
    assert counts["unreadable"] == 1
    assert ":1: not a line of a candump log" in done.stderr
    assert done.stdout == replay(good_log)[0].stdout


def test_cut_off_log_is_read_to_its_end(good_log: Path, tmp_path: Path) -> None:
    log = tmp_path / "cut.log"
    log.write_bytes(good_log.read_bytes()[:-9])
    done, counts = replay(log)
    assert done.returncode in (0, 3)
    assert counts["received"] + counts["unreadable"] == len(good_log.read_text().splitlines())


def test_times_that_run_backwards_are_told(good_log: Path, tmp_path: Path) -> None:
    lines = good_log.read_text().splitlines()
    log = tmp_path / "back.log"
    log.write_text("\n".join([*lines[:5000], *lines[:100]]) + "\n")
    _, counts = replay(log)
    assert counts["clock_back"] == 100
    assert counts["most_back_us"] > 1_000_000


@pytest.mark.parametrize("content", [b"", b"(1.0) can0 7FF#00\n", b"\n\n"])
def test_log_without_our_frames_is_an_error(tmp_path: Path, content: bytes) -> None:
    log = tmp_path / "other.log"
    log.write_bytes(content)
    done, _ = replay(log)
    assert done.returncode == 1
    assert "no frame of swaywatch.dbc" in done.stderr


def test_missing_files_are_named(tmp_path: Path) -> None:
    done, _ = replay(tmp_path / "none.log")
    assert done.returncode == 1
    assert "none.log: No such file" in done.stderr
    missing = subprocess.run(
        [DAEMON, "--vehicle", "none.toml", "--replay", "-"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert missing.returncode == 1
    assert "none.toml: No such file" in missing.stderr


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[car]\nmass = heavy\n", ':2: not a number: "heavy"'),
        ("[car]\nmass = 1e9\n", "car.mass = 1e+09 is out of range; expected 300 to 60000"),
        ("[car]\nweight = 1000\n", ':2: unknown key: "weight"'),
        ("[boat]\n", ":1: unknown table"),
        ("mass = 1000\n", "before the first table"),
        ("[car\nmass = 1000\n", ":1: a table is written as"),
        ("[car]\nmass 1000\n", ':2: expected "key = number"'),
        ("[car]\nmass = 1000\n", "car.front_axle_to_cog = 0 is missing"),
    ],
)
def test_wrong_vehicle_files_are_explained(tmp_path: Path, text: str, words: str) -> None:
    vehicle = tmp_path / "vehicle.toml"
    vehicle.write_text(text)
    done = subprocess.run(
        [DAEMON, "--vehicle", vehicle, "--replay", "-"],
        capture_output=True,
        text=True,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    assert done.returncode == 1
    assert words in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize(
    "arguments", ["", "vcan0", "--vehicle x", "--vehicle x a b", "--vehicle x --replay a b", "--no"]
)
def test_wrong_arguments_show_the_usage(arguments: str) -> None:
    done = subprocess.run([DAEMON, *arguments.split()], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "usage: swaywatchd" in done.stderr
