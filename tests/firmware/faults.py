"""Faults on purpose, on every emulated machine: `faults.py BUILD CASE.log`.

A write to NULL, a read from it, a stack that overflows, an undefined instruction, a program that
hangs, its state overwritten: the machine has to catch each, restart, say in SwayFaultReport what
happened, and then give the same answers as if nothing had been. A damaged image, constants or
memory has to end in the safe state. Parameters are changed, stored, cut off and refused over CAN.
"""

from __future__ import annotations

import concurrent.futures
import re
import subprocess
import sys
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import access
import cantools
from identical import block_of, common, first_difference, shared
from image import tool
from machines import Outcome, frame_of, run

CORTEX_M = ("m0plus", "m3", "m4f", "m7")
EVERYWHERE = (*CORTEX_M, "r5")
HARD_FAULT, MEM_MANAGE, PREFETCH, USAGE, WATCHDOG = 3, 4, 5, 6, 16
RUNNING, SAFE = 0, 1
ARITHMETIC, MEMORY, IMAGE = 32, 33, 34
NO_BLOCK, BLOCK_VERSION, BLOCK_CRC, BLOCK_REFUSED, STORE_CUT = 49, 50, 51, 52, 56
REPLY, REQUEST, REPORT, QUALITY = 0x6E1, 0x6E0, 0x6E2, 0x1B3
CRC_TABLE = bytes.fromhex("000000006410b71d")
"""Start of the checksum's table in an image, as it lies in memory."""

LINES = 6000
"""Frames of the case that are used: 5 s, 28 estimates."""

DATABASE = cantools.database.load_file(Path(__file__).parents[2] / "dbc" / "swaywatch.dbc")


@dataclass(frozen=True)
class Drill:
    """A fault, where it is made, and the causes that may be reported for it."""

    name: str
    targets: tuple[str, ...]
    causes: tuple[int, ...]


DRILLS = [
    Drill("null", EVERYWHERE, (MEM_MANAGE,)),
    Drill("read", EVERYWHERE, (MEM_MANAGE,)),
    # Where the processor cannot save its registers any more, the fault comes while it tries.
    Drill("stack", EVERYWHERE, (MEM_MANAGE,)),
    Drill("undefined", EVERYWHERE, (USAGE,)),
    Drill("hang", CORTEX_M, (WATCHDOG,)),
    Drill("state", CORTEX_M, (WATCHDOG,)),
]
"""The emulated R5 has no watchdog: what only a watchdog ends is not tried on it."""


def crc(frame_id: int, data: bytes) -> int:
    """CRC of AUTOSAR E2E profile 2, bit by bit."""
    value = 0xFF
    for byte in (*data[1:], frame_id & 255):
        value ^= byte
        for _ in range(8):
            value = (value << 1) ^ (0x2F if value & 0x80 else 0)
        value &= 255
    return value ^ 0xFF


def request(number: int, command: int, index: int = 0, value: int = 0) -> str:
    """One SwayParameterRequest as identifier and bytes."""
    message = DATABASE.get_message_by_frame_id(REQUEST)
    data = bytearray(
        message.encode(
            {
                "ParameterRequestCrc": 0,
                "ParameterRequestCounter": number % 16,
                "ParameterCommand": command,
                "ParameterIndex": index,
                "ParameterValue": value,
            }
        )
    )
    data[0] = crc(REQUEST, bytes(data))
    return f"{REQUEST:03X}#{data.hex().upper()}"


def decode(line: str) -> tuple[int, dict[str, int]]:
    """Identifier and raw signals of a line of candump."""
    name, _, data = frame_of(line).partition("#")
    frame_id = int(name, 16)
    message = DATABASE.get_message_by_frame_id(frame_id)
    signals = message.decode(bytes.fromhex(data), decode_choices=False, scaling=False)
    return frame_id, {k: int(v) for k, v in signals.items()}


def last_report(outcome: Outcome) -> dict[str, int]:
    """Return what the ECU said of its health last; nothing at all if it never did."""
    return decode(outcome.reports[-1])[1] if outcome.reports else {}


def check_report(outcome: Outcome, state: int, causes: tuple[int, ...], restarts: int) -> list[str]:
    """Compare the health report with what is wanted."""
    said = last_report(outcome)
    if (
        said.get("EcuState") == state
        and said.get("FaultCause") in causes
        and said.get("FaultRestarts") == restarts
    ):
        return []
    return [f"reported {said or 'nothing'}, wanted state {state}, cause {causes}, {restarts}"]


# --- faults of the program ------------------------------------------------------------------------


def run_drill(build: Path, drill: Drill, target: str, case: Path, expected: list[str]) -> list[str]:
    """One fault on one machine: caught, reported, and the same answers after it."""
    outcome = run(build, target, block_of(case), case, f"{drill.name}-{target}", drill.name)
    wrong = [] if outcome.status == 0 else [f"status {outcome.status}: {outcome.message[-200:]}"]
    # ARMv6-M has one exception for all faults of the program.
    causes = drill.causes if target != "m0plus" or WATCHDOG in drill.causes else (HARD_FAULT,)
    wrong += check_report(outcome, RUNNING, causes, 1)
    found = [frame_of(line) for line in outcome.answers]
    wanted = shared(expected, target)
    if found != wanted:
        wrong.append(first_difference(wanted, found))
    return wrong


def outputs_before_estimates(lines: list[str]) -> list[str]:
    """Look for a value of the signals, or an alarm, before there is an estimate of them."""
    wrong: list[str] = []
    has_estimate = False
    group: dict[str, int] = {}
    first = next((line.split()[0] for line in lines if f" {QUALITY:X}#" in line), "")
    for line in lines:
        frame_id, signals = decode(line)
        name = DATABASE.get_message_by_frame_id(frame_id).name
        if name == "SwayAlarm" and line.split()[0] < first and signals["AlarmState"] != 0:
            wrong.append(f"an alarm before the first estimate: {line}")
        if re.match(r"Sway(SignalDamping|Oscillation|Stiffness|Load|Tyre|Inertia)", name):
            group |= {k: v for k, v in signals.items() if is_value(frame_id, k, v)}
        if frame_id == QUALITY:
            has_estimate = True
            nothing = signals["QualityNoOscillation"] or signals["QualitySeeking"]
            if nothing and group:
                wrong.append(f"values without an oscillation: {group}")
            group = {}
    if not has_estimate:
        wrong.append("no estimate at all")
    return wrong[:3]


def is_value(frame_id: int, name: str, raw: int) -> bool:
    """Tell a value from "not valid now" and from what is no value."""
    comment = str(DATABASE.get_message_by_frame_id(frame_id).get_signal_by_name(name).comment)
    found = re.search(r"not valid now: (-?\d+)", comment)
    return found is not None and raw != int(found.group(1))


# --- faults of image, memory, parameters ----------------------------------------------------------


def damaged_image(build: Path, target: str, name: str, pattern: bytes | None) -> str:
    """Write a copy of a target's image with one bit flipped; return the copy's target name."""
    source = build / f"replay_{target}.elf"
    content = bytearray(source.read_bytes())
    if pattern is None:  # the last byte of the program
        end = next(
            int(line.split()[0], 16)
            for line in tool("nm", str(source)).splitlines()
            if line.endswith(" image_crc")
        )
        at = offset_in_file(source, end - 1)
    else:
        at = content.index(pattern) + len(pattern) - 2
    content[at] ^= 1
    copy = build / f"replay_{target}.{name}.elf"
    copy.write_bytes(content)
    return f"{target}.{name}"


def offset_in_file(image: Path, address: int) -> int:
    """Where the byte loaded at `address` lies in the ELF file."""
    for line in tool("readelf", "-lW", str(image)).splitlines():
        words = line.split()
        if words[:1] == ["LOAD"]:
            offset, _, load, size = (int(word, 16) for word in words[1:5])
            if load <= address < load + size:
                return offset + address - load
    raise ValueError(f"{image.name}: nothing is loaded at {address:#x}")


def check_safe(outcome: Outcome, cause: int) -> list[str]:
    """In the safe state there is the report and nothing else."""
    wrong = check_report(outcome, SAFE, (cause,), 0)
    if outcome.answers:
        wrong.append(f"says {outcome.answers[0]} in the safe state")
    if len(outcome.reports) < 10:
        wrong.append(f"only {len(outcome.reports)} reports")
    return wrong


def bad_blocks(build: Path, case: Path) -> dict[Path, int]:
    """Parameter blocks that must not be used, and the cause to tell."""
    good = block_of(case).read_bytes()
    folder = build / "runs"
    folder.mkdir(exist_ok=True)

    def sealed(content: bytearray) -> bytes:
        return bytes(content[:-4]) + zlib.crc32(content[:-4]).to_bytes(4, "little")

    damaged = bytearray(good)
    damaged[100] ^= 0x10
    older = bytearray(good)
    older[4] -= 1
    refused = bytearray(good)
    refused[12:16] = bytes(4)  # a car without mass
    contents = {
        "damaged": (bytes(damaged), BLOCK_CRC),
        "older": (sealed(older), BLOCK_VERSION),
        "refused": (sealed(refused), BLOCK_REFUSED),
        "half": (good[: len(good) // 2], BLOCK_CRC),
        "empty": (b"", NO_BLOCK),
    }
    blocks = {}
    for name, (content, cause) in contents.items():
        path = folder / f"{name}.block"
        path.write_bytes(content)
        blocks[path] = cause
    return blocks


# --- parameters over CAN --------------------------------------------------------------------------

READ, WRITE, APPLY, STORE, VERSION, OPEN = 0, 1, 2, 3, 5, 6
DONE, NO_INDEX, REFUSED, NO_COMMAND, LOCKED, FORGED = 0, 1, 2, 4, 5, 7
DIALOGUE = [
    (0.4, VERSION, 0, 0),
    (0.5, OPEN, 1, None),
    (0.6, WRITE, 0, 1900000),
    (0.7, STORE, 1, {0: 1900000}),
    (1.2, READ, 0, 0),
    (1.3, OPEN, 2, None),
    (1.4, WRITE, 0, 0),
    (1.5, APPLY, 2, {0: 0}),  # a car without mass
    (1.6, OPEN, 2, None),
    (1.7, WRITE, 0, 1955000),
    (1.8, STORE, 2, {0: 1955000}),
    (2.3, VERSION, 0, 0),
    (2.4, READ, 9999, 0),
    (2.5, 7, 0, 0),
    (2.6, WRITE, 0, 1900000),  # without a session
]
"""Requests: seconds, command, number of the word, value; for those of a session the stored block's
sequence number that its proof is made for, and the values that it is made for."""
ANSWERS = [
    (DONE, 0, None),
    (DONE, None, None),
    (DONE, 0, 1900000),
    (DONE, 0, 0),
    (DONE, 0, 1900000),
    (DONE, None, None),
    (DONE, 0, 0),
    (REFUSED, 0, 0),
    (DONE, None, None),
    (DONE, 0, 1955000),
    (DONE, 0, 0),
    (DONE, 0, None),
    (NO_INDEX, 9999, 0),
    (NO_COMMAND, 0, 0),
    (LOCKED, 0, 1900000),
]
"""Result, number and value of each reply; none: not looked at."""
AHEAD_S = 3.0
"""The dialogue is so long before the recording, the car standing."""
SPEED = 0x121


def standing(start_us: int) -> list[tuple[int, str]]:
    """Return frames of a speed of nothing, every 10 ms."""
    frames = []
    for i in range(int(AHEAD_S * 100)):
        data = bytearray(8)
        data[1] = i % 16
        data[0] = crc(SPEED, bytes(data))
        frames.append((start_us + 10000 * i, f"{SPEED:03X}#{data.hex().upper()}"))
    return frames


def asked(block: bytes, start_us: int) -> list[tuple[int, str]]:
    """Return the requests, their proofs made."""
    frames = []
    opened = b""
    for number, (seconds, command, first, second) in enumerate(DIALOGUE):
        time_us = start_us + round(seconds * 1e6) + 3000
        index, value = first, second
        if command == OPEN:
            opened = access.challenge(access.KEY, time_us, first)
            index = value = 0
        elif isinstance(second, dict):
            staged = access.with_values(block, first + 1, second)
            index, value = access.proof(access.KEY, opened, command, staged)
        assert isinstance(value, int)
        frames.append((time_us, request(number, command, index, value)))
    return frames


def dialogue(build: Path, case: Path) -> Path:
    """Write the case with the dialogue before it."""
    lines = case.read_text().splitlines()
    start_us = round((float(lines[0].split(")")[0][1:]) - AHEAD_S) * 1e6)
    before = [
        f"({t // 1000000}.{t % 1000000:06d}) can0 {frame}"
        for t, frame in sorted(standing(start_us) + asked(block_of(case).read_bytes(), start_us))
    ]
    path = build / "runs" / "dialogue.log"
    path.write_text("\n".join([*before, *lines]) + "\n")
    return path


def replies_of(outcome: Outcome) -> list[tuple[int, int, int]]:
    """Result, number and value of all SwayParameterReply."""
    decoded = [decode(line) for line in outcome.answers if f" {REPLY:X}#" in line]
    names = ("ParameterResult", "ParameterReplyIndex", "ParameterReplyValue")
    return [tuple(signals[name] for name in names) for _, signals in decoded]  # type: ignore[misc]


def check_replies(outcome: Outcome, sequence: int) -> list[str]:
    """Compare the replies; `sequence` is that of the block at the start.

    Where it is not 1, the proof of the first store was made for another block.
    """
    found = replies_of(outcome)
    if len(found) != len(ANSWERS):
        return [f"{len(found)} replies to {len(ANSWERS)} requests"]
    wrong = []
    for number, (reply, usual) in enumerate(zip(found, ANSWERS, strict=True)):
        is_forged = sequence != 1 and DIALOGUE[number][1:3] == (STORE, 1)
        wanted = (FORGED, None, None) if is_forged else usual
        if any(w not in (None, r) for r, w in zip(reply, wanted, strict=True)):
            wrong.append(f"reply {number} is {reply}, not {wanted}")
    stored = [
        reply[2] >> 16
        for reply, (_, command, *_) in zip(found, DIALOGUE, strict=True)
        if command == VERSION
    ]
    if stored != [sequence, 3]:
        wrong.append(f"sequence numbers {stored} from {sequence} on")
    return wrong


# --- all of it ------------------------------------------------------------------------------------


def brief(build: Path, case: Path) -> Path:
    """Write the first seconds of a case, with its parameter block beside it."""
    path = build / "runs" / "brief.log"
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(case.read_text().splitlines()[:LINES]) + "\n")
    block_of(path).write_bytes(block_of(case).read_bytes())
    return path


def tests_of(build: Path, case: Path) -> dict[str, Callable[[], list[str]]]:
    """Return all tests by name: each runs one machine and returns what was wrong."""
    block = block_of(case)
    plain = run(build, "x86", block, case, "faults-x86")
    expected = [frame_of(line) for line in plain.answers]
    tests: dict[str, Callable[[], list[str]]] = {
        "outputs before estimates": lambda: outputs_before_estimates(plain.answers)
    }
    for drill in DRILLS:
        for target in drill.targets:
            tests[f"{drill.name} {target}"] = partial(
                run_drill, build, drill, target, case, expected
            )

    def safe(target: str, which: Path, name: str, cause: int, *extra: str) -> list[str]:
        return check_safe(run(build, target, which, case, name, *extra), cause)

    for target in ("m0plus", "m4f", "r5"):
        for name, pattern, cause in (("image", None, IMAGE), ("constants", CRC_TABLE, ARITHMETIC)):
            broken = damaged_image(build, target, name, pattern)
            tests[f"damaged {name} {target}"] = partial(safe, broken, block, broken, cause)
    for target in ("m0plus", "m7"):
        tests[f"no memory {target}"] = partial(
            safe, target, block, f"memory-{target}", MEMORY, "memory"
        )
    for path, cause in bad_blocks(build, case).items():
        for target in ("x86", "m0plus", "r5"):
            name = f"{path.stem}-block-{target}"
            tests[f"{path.stem} block {target}"] = partial(safe, target, path, name, cause)
    return tests | dialogues(build, case)


def dialogues(build: Path, case: Path) -> dict[str, Callable[[], list[str]]]:
    """Return the tests of parameters over CAN by name."""
    block, talk = block_of(case), dialogue(build, case)
    plain = run(build, "x86", block, talk, "dialogue-x86")
    expected = [frame_of(line) for line in plain.answers]

    def ask(target: str) -> list[str]:
        outcome = run(build, target, block, talk, f"dialogue-{target}")
        given = common([frame_of(line) for line in outcome.answers], target)
        same = given == shared(expected, target)
        return [
            *check_replies(outcome, 1),
            *check_report(outcome, RUNNING, (0,), 0),
            *([] if same else ["answers differ from x86"]),
        ]

    def cut(target: str) -> list[str]:
        # Restarted between erasing and writing: the block stored before is used, and it is said.
        outcome = run(build, target, block, talk, f"cut-{target}", "cut")
        return [
            *check_replies(outcome, 2),
            *check_report(outcome, RUNNING, (STORE_CUT,), 0),
        ]

    tests: dict[str, Callable[[], list[str]]] = {"dialogue x86": lambda: check_replies(plain, 1)}
    for target in ("mips", *EVERYWHERE, "stm32g4"):
        tests[f"dialogue {target}"] = partial(ask, target)
    for target in ("m0plus", "m4f", "r5"):
        tests[f"cut {target}"] = partial(cut, target)
    return tests


def checked(test: Callable[[], list[str]]) -> list[str]:
    """Run a test; a machine that never ends is wrong, too."""
    try:
        return test()
    except subprocess.TimeoutExpired:
        return ["never ended"]


def main(build: Path, case: Path) -> int:
    """Print one line, and what was wrong."""
    tests = tests_of(build, brief(build, case))
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        done = dict(zip(tests, pool.map(checked, tests.values()), strict=True))
    wrong = [f"{name}: {what}" for name, faults in done.items() for what in faults]
    for line in wrong:
        print(f"faults: {line}", file=sys.stderr)
    failed = sum(bool(faults) for faults in done.values())
    print(f"faults and parameters on emulated machines: {len(done)} tests, {failed} failed")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
