"""swaywatchd over candump logs: what it counts, and clear words for bad input."""

from __future__ import annotations

import fcntl
import json
import os
import re
import signal
import subprocess
import termios
import time
from array import array
from collections.abc import Callable
from pathlib import Path

import pytest

from swaywatch.drive import load_drive
from swaywatch.ecu.bus import encode_drive
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
def test_unreadable_lines_are_reported(good_log: Path, tmp_path: Path, line: bytes) -> None:
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


def test_times_that_run_backwards_are_reported(good_log: Path, tmp_path: Path) -> None:
    lines = good_log.read_text().splitlines()
    log = tmp_path / "back.log"
    log.write_text("\n".join([*lines[:5000], *lines[:100]]) + "\n")
    done, counts = replay(log)
    assert done.returncode == 3
    assert counts["clock_set"] == 1
    jumbled = [line for i in range(0, 5000, 2) for line in (lines[i + 1], lines[i])]
    log.write_text("\n".join(jumbled) + "\n")  # by no more than a frame's time
    done, counts = replay(log)
    assert done.returncode == 0
    assert counts["clock_back"] > 1000
    assert 0 < counts["most_back_us"] < 20000


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
        ("[car]\nweight = 1000\n", ':2: unknown key: "weight"\n'),
        ("[car]\nmaas = 1\n", ':2: unknown key: "maas"; did you mean "mass"?\n'),
        ("[trailer]\nmasss = 1\n", ':2: unknown key: "masss"; did you mean "mass"?\n'),
        ("[trailer]\nsteering_ration = 1\n", ':2: unknown key: "steering_ration"\n'),
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


# --- stamps that cannot be right ------------------------------------------------------------------


def damage(
    good: Path, log: Path, number: int, change: Callable[[float], float], count: int = 1
) -> None:
    """Write a copy of a log, the stamps of `count` lines from `number` on changed."""
    lines = good.read_text().splitlines()
    for i in range(number, min(number + count, len(lines))):
        stamp, rest = lines[i].split(") ", 1)
        lines[i] = f"({change(float(stamp[1:])):.6f}) {rest}"
    log.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize(
    ("option", "meant"),
    [
        ("--vehicel", "--vehicle"),
        ("--repaly=a.log", "--replay"),
        ("--candumpout", "--candump-out"),
        ("--kee", "--key"),
        ("--nothing-like-it", None),
        ("--a-name-that-is-far-too-long-to-be-an-option", None),
        ("--vehicle", None),  # known, its value is missing
    ],
)
def test_an_unknown_option_names_its_nearest(option: str, meant: str | None) -> None:
    done = subprocess.run([DAEMON, option], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    hints = [line for line in done.stderr.splitlines() if "did you mean" in line]
    assert hints == ([] if meant is None else [f"swaywatchd: did you mean {meant}?"])


@pytest.mark.parametrize(
    ("number", "by"),
    [(n, by) for n in (9000, 34000) for by in (1000.0, -1000.0, 0.5, -0.5, 6e7)] + [(0, 1000.0)],
)
def test_one_damaged_stamp_costs_one_stamp(
    good_log: Path, tmp_path: Path, by: float, number: int
) -> None:
    """It was 88 of 1,711 status frames that were left, and exit status 0."""
    log = tmp_path / "damaged.log"
    damage(good_log, log, number, lambda t: t + by)
    done, counts = replay(log)
    whole = replay(good_log)[0].stdout
    assert done.returncode == 3
    assert counts["stamps_damaged"] + counts["clock_set"] == 1
    assert "by" in done.stderr.splitlines()[0]
    assert abs(len(done.stdout.splitlines()) - len(whole.splitlines())) < 60


def test_a_logger_s_clock_set_back_is_reported(good_log: Path, tmp_path: Path) -> None:
    log = tmp_path / "set.log"
    damage(good_log, log, 9000, lambda t: t - 3600.0, 10**6)
    done, counts = replay(log)
    assert done.returncode == 3
    assert counts["clock_set"] == 1
    assert counts["clock_back"] == counts["stamps_damaged"] == 0
    assert "clock was set back by 3599.99" in done.stderr
    whole, expected = replay(good_log)
    assert len(whole.stdout.splitlines()) - len(done.stdout.splitlines()) < 60
    # until the model is there again an estimate costs less, so a few more are made
    assert counts["estimates"] < 1.05 * expected["estimates"]


# --- what a machine does to a daemon --------------------------------------------------------------


def test_version() -> None:
    done = subprocess.run([DAEMON, "--version"], capture_output=True, text=True, check=True)
    assert re.fullmatch(r"swaywatchd \d+\.\d+\.\d+\n", done.stdout)


def test_the_input_is_not_written_over(good_log: Path, tmp_path: Path) -> None:
    log = tmp_path / "input.log"
    log.write_bytes(good_log.read_bytes())
    link = tmp_path / "link.log"
    link.hardlink_to(log)
    done, _ = replay(log, "p01", "--candump-out", str(link))
    assert done.returncode == 1
    assert "is read already" in done.stderr
    assert log.read_bytes() == good_log.read_bytes()


def test_a_full_disk_is_reported_and_ends_a_replay(good_log: Path) -> None:
    done, _ = replay(good_log, "p01", "--candump-out", "/dev/full")
    assert done.returncode == 1
    assert "can no longer be written: No space left" in done.stderr


def test_a_reader_that_leaves_is_reported(good_log: Path) -> None:
    """It died of SIGPIPE."""
    command = [DAEMON, "--vehicle", CASES / "p01" / "vehicle.toml", "--replay", good_log]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    process.stdout.close()
    assert process.stderr is not None
    said = process.stderr.read()
    assert process.wait(60) == 1
    assert "Broken pipe" in said


@pytest.mark.parametrize("option", ["--vehicle", "--replay"])
def test_endless_input_ends(option: str) -> None:
    """/dev/zero as a vehicle is refused at once; as a log it is read until SIGTERM."""
    files = {"--vehicle": str(CASES / "p01" / "vehicle.toml"), "--replay": "/dev/null"}
    files[option] = "/dev/zero"
    command = [str(DAEMON), *(word for item in files.items() for word in item)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if option == "--replay":
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(0.5)
        process.terminate()
    _, said = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "zero byte" in said if option == "--vehicle" else "no frame of swaywatch.dbc" in said


def test_a_fifo_without_a_writer_can_be_left(tmp_path: Path) -> None:
    fifo = tmp_path / "vehicle.toml"
    os.mkfifo(fifo)
    process = subprocess.Popen(
        [DAEMON, "--vehicle", fifo, "--replay", "/dev/null"], stderr=subprocess.PIPE, text=True
    )
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(0.5)
    process.terminate()
    assert process.wait(60) == 1


def waits_for_more(pid: int, pipe: int) -> bool:
    """Return whether a process has read a pipe to its end and sleeps until more is written."""
    unread = array("i", [0])
    fcntl.ioctl(pipe, termios.FIONREAD, unread)
    state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    return unread[0] == 0 and state == "S"


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGUSR1])
def test_the_terminal_goes_and_the_replay_goes_on(
    good_log: Path, tmp_path: Path, number: signal.Signals
) -> None:
    """It died of SIGHUP, and took a signal while it waited for a pipe for the end of the log."""
    fifo = tmp_path / "log"
    os.mkfifo(fifo)
    command = [DAEMON, "--vehicle", CASES / "p01" / "vehicle.toml", "--replay", fifo]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, stderr=subprocess.PIPE)
    lines = good_log.read_text().splitlines(keepends=True)[:4000]
    with fifo.open("w") as writer:
        writer.writelines(lines[:2000])
        writer.flush()
        while not waits_for_more(process.pid, writer.fileno()):
            time.sleep(0.01)
        process.send_signal(number)
        writer.writelines(lines[2000:])
    _, said = process.communicate(timeout=60)
    assert process.returncode == 0
    assert json.loads(said.rsplit("counts ", 1)[1])["received"] == len(lines)


@pytest.mark.parametrize("line", ["DROPCOUNT: dropped " + "9" * 5000, "(1.0) can0 " + "1" * 100000])
def test_absurd_lines_are_counted(good_log: Path, tmp_path: Path, line: str) -> None:
    log = tmp_path / "absurd.log"
    log.write_text(line + "\n" + good_log.read_text())
    done, counts = replay(log)
    assert done.stdout == replay(good_log)[0].stdout
    assert counts["unreadable"] == (0 if line.startswith("DROP") else 1)


def test_length_of_the_window_is_set_and_its_range_is_said(good_log: Path) -> None:
    usual = replay(good_log)[0].stdout
    same = replay(good_log, "p01", "--set", "core.window_oscillations=1.7")[0].stdout
    longer = replay(good_log, "p01", "--set", "core.window_oscillations=3")[0].stdout
    assert same == usual
    assert longer != usual
    for wrong in ("core.window_oscillations=9", "core.window_oscillations=", "core.window=2"):
        done, _ = replay(good_log, "p01", "--set", wrong)
        assert done.returncode == 2
        assert f"--set {wrong}: expected core.window_oscillations=1.5 to 6" in done.stderr
