"""The table of sizes and costs, and the limits that it has to keep.

`report.py BUILD CASE.log` runs the case on the images that count, writes BUILD/firmware.md, prints
it, and exits with 1 if a limit is broken that the project claims to keep.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from identical import block_of
from image import forbidden_symbols, stack_bound, tool
from machines import run

LABELS = {
    "m0plus": "Cortex-M0+, 16 channels, 512 samples",
    "m4f": "Cortex-M4F, 16 channels, 512 samples",
    "small": "Cortex-M0+, 4 channels, 128 samples at 50 Hz",
}
CLOCK_MHZ = {"m0plus": 48, "small": 48, "m4f": 168}
ENTRIES = {"receive": "frame received", "work": "slice of work", "send": "frame sent"}
"""What one sway_ecu_poll() does, by the names in the figures."""
LONGEST = 4.0
"""Of each: the longest call to the median one."""
CALL_CYCLES = 96000
"""2 ms of a 48 MHz Cortex-M0+."""
FLASH_KIB = {"m0plus": 64, "m4f": 64, "small": 64}
RAM_KIB = {"m0plus": 64, "m4f": 64, "small": 16}
"""Nothing may be larger."""


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    target: str
    flash: int
    memory: int
    figures: dict[str, int]
    bound: int
    path: list[str]

    @property
    def load(self) -> float:
        """Instructions a second for one instruction a cycle, of the clock."""
        seconds = self.figures["rows"] / 100
        return self.figures["instructions"] / seconds / (CLOCK_MHZ[self.target] * 1e6)

    @property
    def estimate(self) -> int:
        """Instructions that come with an estimate, beyond those of its samples."""
        f = self.figures
        return (f["instructions"] - f["rows"] * f["row_quiet"]) // max(f["estimates"], 1)

    def calls(self, entry: str) -> str:
        """Return median and longest call of an entry point and their ratio."""
        median, longest = self.figures[f"{entry}_median"], self.figures[f"{entry}_longest"]
        return f"{median} / {longest} / {longest / median:.1f}"

    def line(self) -> str:
        """Return the table's line."""
        f = self.figures
        entries = " | ".join(self.calls(entry) for entry in ENTRIES)
        return (
            f"| {LABELS[self.target]} | {self.flash / 1024:.1f} | {self.memory / 1024:.1f} "
            f"| {f['stack']} / {self.bound} | {entries} | {f['row_quiet']} "
            f"| {self.estimate / 1e6:.2f} M "
            f"| {100 * self.load:.0f} % of {CLOCK_MHZ[self.target]} MHz |"
        )


def section_sizes(image: Path) -> tuple[int, int]:
    """Return flash and RAM (stack included) of an image in bytes."""
    sizes = {}
    for line in tool("size", "-A", str(image)).splitlines():
        words = line.split()
        if len(words) == 3 and words[0].startswith("."):
            sizes[words[0]] = int(words[1])
    flash = sum(sizes.get(s, 0) for s in (".text", ".ARM.exidx", ".data", ".crc", ".parameters"))
    memory = sum(sizes.get(s, 0) for s in (".stack", ".noinit", ".data", ".bss"))
    return flash, memory


def measure(build: Path, target: str, case: Path) -> Row:
    """Run one image and look into it."""
    outcome = run(build, target, block_of(case, target), case, f"report-{target}")
    flash, memory = section_sizes(build / f"ecu_{target}.elf")
    image = build / f"replay_{target}.elf"
    bound, path = stack_bound(image, build / target, "main")
    return Row(target, flash, memory, outcome.figures, bound, path)


def broken_limits(build: Path, rows: list[Row]) -> list[str]:
    """Return the limits that are not kept."""
    broken = [
        f"{name} is linked into the image {row.target}"
        for row in rows
        if row.target in ("m0plus", "small")
        for name in forbidden_symbols(build / f"ecu_{row.target}.elf")
    ]
    for row in rows:
        f = row.figures
        for entry, label in ENTRIES.items():
            median, longest = f[f"{entry}_median"], f[f"{entry}_longest"]
            if longest > LONGEST * median:
                broken.append(f"{row.target}: {label}: longest {longest}, median {median}")
            if longest > CALL_CYCLES:
                broken.append(f"{row.target}: {label}: {longest} instructions in one call")
        if f["stack"] > row.bound:
            broken.append(f"{row.target}: stack {f['stack']} beyond its bound {row.bound}")
        if row.flash > FLASH_KIB[row.target] * 1024:
            broken.append(f"{row.target}: {row.flash} bytes of flash")
        if row.memory > RAM_KIB[row.target] * 1024:
            broken.append(f"{row.target}: {row.memory} bytes of RAM")
    return broken


def main(build: Path, case: Path) -> int:
    """Write and print the table."""
    rows = [measure(build, target, case) for target in LABELS]
    lines = [
        "**`make firmware-test`**: the ECU alone (`build/firmware/ecu_*.elf`, `-Os -flto`;"
        " flash with start-up code and parameter block, RAM with stack); instructions while a"
        " recording runs through it (`-Os`), 100 Hz",
        "",
        "| image | flash, KiB | RAM, KiB | stack, painted / static bound, B "
        + "".join(f"| {label}: median / longest / ratio " for label in ENTRIES.values())
        + "| per sample, without estimate | per estimate | load |",
        "|---|---|---|---|---|---|---|---|---|---|",
        *(row.line() for row in rows),
        "",
        "Load: at one instruction per cycle; real processors need 1.2 to 1.5 cycles per "
        "instruction. A call is one sway_ecu_poll(), which does one of the three. Small: see "
        "port/README.md. Aims: 64 KiB of flash, 64 KiB of RAM, small 16; longest call 4 times the "
        "median.",
    ]
    text = "\n".join(lines) + "\n"
    (build / "firmware.md").write_text(text)
    print(text)
    broken = broken_limits(build, rows)
    for limit in broken:
        print(f"firmware: {limit}", file=sys.stderr)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
