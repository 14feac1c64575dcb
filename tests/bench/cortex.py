"""Table of the estimator's instructions, RAM and flash on Cortex-M, beside FFTs of 256 points.

    cortex.py REPORT NAME=FIGURES=OBJECTS ...

FIGURES is what tests/bench/cortex.c printed under the emulator, OBJECTS a folder of the
estimator's objects for that core. Exit status 1 where a goal is missed.
"""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

CHANNELS = 16
#: Real signals that one complex FFT takes at once, as its real and its imaginary part.
PACKED = 2
LIMIT_M4 = 3000
LIMIT_RATIO = 20.0
FFTS = ("kissfft Q31", "CMSIS-DSP Q31", "CMSIS-DSP Q15")
#: Software floating point and the heap, by the names that the compiler calls.
FORBIDDEN = re.compile(r"^(__aeabi_(f|d|[ui]2[fd]|[ul]+2[fd]|c?[fd]cmp)\w*|malloc|calloc|free)$")


@dataclass(frozen=True)
class Core:
    """Figures of one core."""

    name: str
    figures: dict[str, int]
    flash: int
    forbidden: list[str]

    @property
    def row(self) -> int:
        """Instructions of ring and sliding sums for one row of 16 channels."""
        return self.figures["ring and sliding sums, a row most"]

    def fft(self, kind: str) -> int:
        """Instructions of an FFT of every channel, two channels by each complex one."""
        return self.figures[f"{kind} complex 256"] * CHANNELS // PACKED

    def ratio(self, kind: str) -> float:
        """How many times more that is."""
        return self.fft(kind) / self.row


def tool(*arguments: str) -> str:
    """Output of one of the cross tools."""
    return subprocess.run(arguments, capture_output=True, text=True, check=True).stdout


def read(argument: str) -> Core:
    """NAME=FIGURES=OBJECTS."""
    name, figures, objects = argument.split("=")
    found = dict(re.findall(r"^(.*) (-?\d+)$", Path(figures).read_text(encoding="utf-8"), re.M))
    paths = sorted(str(path) for path in Path(objects).glob("*.o"))
    total = tool("arm-none-eabi-size", "-t", *paths).splitlines()[-1].split()
    ours = [path for path in paths if Path(path).name.startswith("sway_")]
    names = tool("arm-none-eabi-nm", "--undefined-only", *ours).split()
    return Core(
        name,
        {key: int(value) for key, value in found.items()},
        int(total[0]) + int(total[1]),
        sorted({symbol for symbol in names if FORBIDDEN.match(symbol)}),
    )


def lines(cores: list[Core]) -> list[str]:
    """The table, one column for each core."""

    def row(what: str, values: list[str]) -> str:
        return f"| {what} | " + " | ".join(values) + " |"

    def figure(what: str, key: str) -> str:
        return row(what, [f"{core.figures[key]:,}" for core in cores])

    table = [
        row("instructions", [core.name for core in cores]),
        "|" + "---|" * (len(cores) + 1),
        figure(
            "ring and sliding sums, 16 channels, 5 lines, per row",
            "ring and sliding sums, a row most",
        ),
        figure("grid: 25 samples of a row", "grid: samples of a row most"),
        figure("grid: a row handed out", "grid: hand out a row most"),
        figure("an estimate, 16 channels, 2 oscillations, mean", "estimate mean"),
        figure("an estimate, longest", "estimate most"),
        figure("longest slice of it", "slice most"),
    ]
    for kind in FFTS:
        values = [f"{core.fft(kind):,} ({core.ratio(kind):.0f} times the sums)" for core in cores]
        table.append(row(f"beside: {kind}, 256 points, 16 channels by 8 complex FFTs", values))
    table.append(figure("RAM: track (ring, sums, estimate), bytes", "RAM of sway_track_t"))
    table.append(figure("RAM: grid, bytes", "RAM of sway_grid_t"))
    table.append(row("flash: estimator and kissfft, -Os, bytes", [f"{c.flash:,}" for c in cores]))
    table.append(
        row(
            "calls of floating point or heap in objects of lib/",
            [" ".join(core.forbidden) or "none" for core in cores],
        )
    )
    return table


def missed(cores: list[Core]) -> list[str]:
    """Goals that are not met."""
    found = []
    for core in cores:
        if "M4" in core.name and core.row > LIMIT_M4:
            found.append(f"{core.name}: {core.row} instructions per row, wanted {LIMIT_M4}")
        for kind in FFTS[:2]:
            if core.ratio(kind) < LIMIT_RATIO:
                found.append(f"{core.name}: {kind} {core.ratio(kind):.1f} times, wanted 20")
        if core.forbidden:
            found.append(f"{core.name}: {' '.join(core.forbidden)}")
    return found


def main(arguments: list[str]) -> int:
    """Writes and prints the table."""
    cores = [read(argument) for argument in arguments[1:]]
    wrong = missed(cores)
    text = "\n".join(
        [
            "**`make bench-cortex`**: instructions counted by the emulator, the same run after run",
            "",
            *lines(cores),
            "",
            "Required: at most 3,000 for the sums on the M4, a Q31 FFT at least 20 times that: "
            + ("met." if not wrong else "missed."),
            *[f"- missed: {line}" for line in wrong],
        ]
    )
    Path(arguments[0]).write_text(text + "\n", encoding="utf-8")
    print(text)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
