"""XCP: pyxcp measures and calibrates emulated ECUs by their A2L files."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

import cantools
import pytest
from pyxcp.types import XcpResponseError

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "hil"))
sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "firmware"))

import access
import frames as f
import machines
import xcp_master as x

ROOT = Path(__file__).resolve().parents[2]
FW = ROOT / "build" / "firmware"
CASE = "p01-run1"


@pytest.fixture(scope="module", params=["m3", "mips"])
def board(request: pytest.FixtureRequest) -> str:
    """An emulated Cortex-M3; a big-endian MIPS."""
    name = str(request.param)
    wanted = [
        f"replay_{name}.elf",
        f"replay_{name}.a2l",
        f"cases/{CASE}.short.log",
        f"cases/{CASE}.block",
        "replay_x86.elf",  # the answer of an ECU that was started with the page
    ]
    subprocess.run(
        ["make", "-s", "-C", str(ROOT), *(f"build/firmware/{w}" for w in wanted)], check=True
    )
    return name


@contextmanager
def running(board: str, folder: Path) -> Iterator[x.Pipes]:
    """The board with a bus; it ends with the bus."""
    pipes = [folder / "to", folder / "from"]
    for pipe in pipes:
        os.mkfifo(pipe)
    arguments = [str(FW / "cases" / f"{CASE}.block"), *map(str, pipes)]
    if board not in machines.ON_HOST:
        arguments.append(str(folder / "figures"))
    process = subprocess.Popen(machines.command(FW, board, arguments), stderr=subprocess.PIPE)
    try:
        bus = x.Pipes(*pipes)
        yield bus
        bus.close()
        assert process.wait(30.0) == 0
    finally:
        process.kill()


def drive(seconds: float = 15.0) -> list[str]:
    """The recorded drive's first seconds."""
    lines = (FW / "cases" / f"{CASE}.short.log").read_text().splitlines()
    start = float(lines[0][1 : lines[0].index(")")])
    return [line for line in lines if float(line[1 : line.index(")")]) - start < seconds]


COMPARED = {
    # status field: frame, signal, SI units in one of the signal's, bit of `valid`
    "v_crit_mm_s": ("SwayMargin", "CriticalSpeed", Fraction(5, 18), 3),
    "margin_mm_s": ("SwayMargin", "SpeedMargin", Fraction(5, 18), 3),
    "frequency_uhz": ("SwayOscillation", "Frequency", Fraction(1), 0),
    "amplitude_urad_s": ("SwayOscillation", "Amplitude", Fraction(math.pi) / 180, 0),
    "damping_ratio_ppm": ("SwaySignalDamping", "SignalDampingRatio", Fraction(1), 0),
}
ENDINGS = {"mm_s": 1000, "uhz": 10**6, "urad_s": 10**6, "ppm": 10**6}


def raw_of(row: dict[str, int], name: str, signal: cantools.database.Signal, unit: Fraction) -> int:
    """What the frame has to say of a measured value: rounded, halves away from zero."""
    factor = next(n for ending, n in ENDINGS.items() if name.endswith(ending))
    value = Fraction(row[x.STATUS + name], factor) / unit / Fraction(str(signal.scale))
    return math.floor(abs(value) + Fraction(1, 2)) * (1 if value >= 0 else -1)


def test_measured_values_are_those_of_the_status_frames(board: str, tmp_path: Path) -> None:
    """Each sample of a DAQ list at each estimate is, bit for bit, what the status frames say."""
    a2l = x.A2l(FW / f"replay_{board}.a2l")
    names = [x.STATUS + n for n in ("sequence", "valid", *COMPARED)]
    database = cantools.database.load_file(ROOT / "dbc" / "swaywatch.dbc")
    lines = drive()
    with running(board, tmp_path) as bus:
        bus.play(lines[:500])
        samples = x.Samples(x.Session(None, a2l).lists(names, event=0))
        with x.session(bus.master(), a2l, policy=samples) as session:
            assert session.measure("frames_received") == 500
            samples.setup(write_multiple=False)
            before = len(bus.status)
            samples.start()
            bus.play(lines[500:])
            assert session.measure("frames_received") == len(lines)
            samples.stop()
            status = bus.status[before:]
    assert len(samples.rows) > 50
    assert samples.rows[-1][x.STATUS + "valid"] & 8, "no critical speed in this drive"
    for name, (frame, signal, unit, bit) in COMPARED.items():
        message = database.get_message_by_name(frame)
        sent = [d for i, d in status if i == message.frame_id]
        assert len(sent) == len(samples.rows)
        for row, data in zip(samples.rows, sent, strict=True):
            said = message.decode(data, decode_choices=False, scaling=False)
            counted = next(v for k, v in said.items() if k.endswith("Estimate"))
            assert counted == row[x.STATUS + "sequence"] % 16
            if row[x.STATUS + "valid"] >> bit & 1:
                wanted = raw_of(row, name, message.get_signal_by_name(signal), unit)
                assert said[signal] == wanted, name
    at_ms = [stamp // 1_000_000 for stamp in samples.stamps]
    assert at_ms == sorted(at_ms)


def standing(line: str) -> str:
    """The same frame; that of the speed says 0."""
    head, _, frame = line.partition("121#")
    if not frame:
        return line
    data = f.protect(f.SPEED, int(frame[3], 16), bytes(6))
    return f"{head}121#{data.hex().upper()}"


def refused(words: str, do: Callable[[], object]) -> None:
    """The slave answers with this error."""
    with pytest.raises(XcpResponseError) as error:
        do()
    assert str(error.value) == words


def margins(frames: list[tuple[int, bytes]]) -> list[bytes]:
    """SwayMargin frames."""
    return [data for number, data in frames if number == f.MARGIN]


def test_a_calibration_changes_the_answer(board: str, tmp_path: Path) -> None:
    """Locked, out of range and moving are refused; a page switched is as if started with it."""
    a2l = x.A2l(FW / f"replay_{board}.a2l")
    lines = drive()
    mass = "vehicle.trailer.mass_g"
    with running(board, tmp_path) as bus:
        bus.play(lines[:1000])
        with (
            pytest.raises(XcpResponseError),
            x.session(bus.master(), a2l, b"not the right key") as session,
        ):
            session.master.cond_unlock("calpag")
        with x.session(bus.master(), a2l, access.KEY) as session:
            master = session.master
            old = session.parameter(mass)
            assert master.identifier(1) == "swaywatch"
            refused("ERR_ACCESS_LOCKED", lambda: session.calibrate(mass, old + 200_000))
            refused("ERR_ACCESS_LOCKED", lambda: master.setCalPage(0x83, 0, 1))
            master.cond_unlock("calpag")
            refused("ERR_WRITE_PROTECTED", lambda: session.calibrate(mass, old + 200_000))
            master.setCalPage(0x02, 0, 1)
            refused("ERR_OUT_OF_RANGE", lambda: session.calibrate(mass, 60_000_001))
            refused("ERR_OUT_OF_RANGE", lambda: session.calibrate("alarm.notice_margin_mm_s", 0))
            session.calibrate(mass, old + 200_000)
            assert session.parameter(mass) == old + 200_000
            refused("ERR_ACCESS_DENIED", lambda: master.setCalPage(0x01, 0, 1))  # moving
            assert master.getCalPage(1, 0) == 0
            bus.play([standing(line) for line in lines[1000:1200]])
            master.setCalPage(0x01, 0, 1)
            assert master.getCalPage(1, 0) == 1
            refused("ERR_CMD_BUSY", lambda: session.calibrate(mass, old))  # speed not known yet
            before = len(bus.status)
            bus.play(lines[1200:])
            received = session.measure("frames_received")
            changed = margins(bus.status[before:])
            bus.play([standing(line) for line in lines[1000:1200]])  # the clock starts again
            session.calibrate(mass, old)  # on the page that is used: at once
            assert master.getCalPage(1, 0) == 1
            assert received == len(lines)
    plain = (FW / "cases" / f"{CASE}.block").read_bytes()
    index = next(i for i, n in enumerate(a2l.parameters) if n == mass)
    block = tmp_path / "block"
    block.write_bytes(access.with_values(plain, 1, {index: old + 200_000}))
    tail = tmp_path / "tail.log"
    tail.write_text("\n".join(lines[1200:]) + "\n")
    wanted = machines.run(FW, "x86", block, tail, f"xcp-{board}").answers
    wanted_margins = [bytes.fromhex(a.split("#")[1]) for a in wanted if " 1A1#" in a]
    assert len(wanted_margins) > 50
    assert changed == wanted_margins
    same = machines.run(FW, "x86", FW / "cases" / f"{CASE}.block", tail, f"xcp-{board}").answers
    assert [bytes.fromhex(a.split("#")[1]) for a in same if " 1A1#" in a] != changed


def test_only_the_ecu_can_be_read(board: str, tmp_path: Path) -> None:
    """Neither other memory nor half of it; nothing else can be written."""
    a2l = x.A2l(FW / f"replay_{board}.a2l")
    with running(board, tmp_path) as bus:
        bus.play(drive(0.5))
        with x.session(bus.master(), a2l, access.KEY) as session:
            master = session.master
            ecu = min(label.address for label in a2l.measured.values())
            refused("ERR_ACCESS_DENIED", lambda: master.shortUpload(4, 0))
            refused("ERR_ACCESS_DENIED", lambda: master.shortUpload(4, 0xFFFFFFFE))
            refused("ERR_OUT_OF_RANGE", lambda: master.shortUpload(8, ecu))
            master.cond_unlock("calpag")
            master.setMta(ecu)
            refused("ERR_WRITE_PROTECTED", lambda: master.download(bytes(4)))
            first = a2l.parameters["vehicle.car.mass_g"].address
            master.setCalPage(0x02, 0, 1)
            master.setMta(first)
            refused("ERR_OUT_OF_RANGE", lambda: master.download(bytes(2)))
            master.setMta(first)
            count = 4 * len(a2l.parameters)
            words = b"".join(bytes(master.shortUpload(4, first + i)) for i in range(0, count, 4))
            master.setMta(first)
            assert master.buildChecksum(count).checksum == zlib.crc32(words)
