"""Images for boards that are not emulated here: `boards.py BUILD`.

Looks into .elf, .hex and .bin of each: that the three hold the same bytes, that the program fits,
that the processor would find its stack and its first instruction, and that the CRC which the
start-up check compares is that of the bytes. It does not run them.
"""

from __future__ import annotations

import struct
import sys
import zlib
from dataclasses import dataclass
from pathlib import Path

from image import forbidden_symbols, tool


@dataclass(frozen=True)
class Board:
    """A part's memory as its data sheet gives it."""

    name: str
    flash: int
    flash_size: int
    ram: int
    ram_size: int
    interrupts: dict[int, str]
    """Numbers in the vector table (16 is the first interrupt) and the functions they need."""


BOARDS = {
    "stm32g474re": Board(
        "NUCLEO-G474RE",
        0x08000000,
        256 * 1024,
        0x20000000,
        96 * 1024,
        {2: "interrupt_nmi", 15: "interrupt_tick", 16 + 21: "interrupt_21"},
    )
}


def read_hex(path: Path) -> dict[int, int]:
    """Return the bytes of an Intel HEX file by address."""
    found: dict[int, int] = {}
    upper = 0
    for line in path.read_text().split():
        record = bytes.fromhex(line[1:])
        if sum(record) % 256:
            raise ValueError(f"{path.name}: wrong checksum in {line}")
        count, at, kind = record[0], record[1] << 8 | record[2], record[3]
        if kind == 0:
            found |= {upper + at + i: b for i, b in enumerate(record[4 : 4 + count])}
        elif kind == 4:
            upper = (record[4] << 8 | record[5]) << 16
    return found


def symbols(image: Path) -> dict[str, int]:
    """Return the addresses of all symbols."""
    lines = (line.split() for line in tool("nm", str(image)).splitlines())
    return {words[2]: int(words[0], 16) for words in lines if len(words) == 3}


def faults(build: Path, key: str, board: Board) -> list[str]:
    """Return what is wrong with a board's files."""
    stem = build / f"sway_{key}"
    binary = stem.with_suffix(".bin").read_bytes()
    address = symbols(stem.with_suffix(".elf"))
    wrong = []
    if read_hex(stem.with_suffix(".hex")) != {board.flash + i: b for i, b in enumerate(binary)}:
        wrong.append(".hex and .bin differ")
    if len(binary) > board.flash_size:
        wrong.append(f"{len(binary)} bytes do not fit")
    vectors = struct.unpack_from("<48I", binary)
    if vectors[0] != address["handler_stack_top"] or vectors[0] % 8:
        wrong.append(f"stack at {vectors[0]:#x}")
    wanted = {1: "reset_handler", 3: "fault_entry", **board.interrupts}
    for number, name in wanted.items():
        if vectors[number] != address[name] | 1:
            wrong.append(f"vector {number} is {vectors[number]:#x}, not {name}")
    for number in board.interrupts:
        if vectors[number] == vectors[3]:
            wrong.append(f"interrupt {number} would be a fault")
    if not board.ram < address["bss_end"] <= board.ram + board.ram_size:
        wrong.append(f"RAM up to {address['bss_end']:#x}")
    first, crc = address["code_start"] - board.flash, address["image_crc"] - board.flash
    if struct.unpack_from("<I", binary, crc)[0] != zlib.crc32(binary[first:crc]):
        wrong.append("the CRC is not that of the program")
    wrong += [f"{name} is linked" for name in forbidden_symbols(stem.with_suffix(".elf"))]
    return [f"{board.name}: {fault}" for fault in wrong]


def main(build: Path) -> int:
    """Check all boards."""
    wrong = []
    for key, board in BOARDS.items():
        wrong += faults(build, key, board)
        size = (build / f"sway_{key}.bin").stat().st_size
        print(f"{board.name}: .elf .hex .bin of {size / 1024:.1f} KiB, not run on hardware here")
    for fault in wrong:
        print(f"firmware: {fault}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
