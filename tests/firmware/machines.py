"""The machines that the firmware runs on: how to start a program on each of them."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

CORTEX_M = {
    "m0plus": "mps2-an385",
    "small": "mps2-an385",
    "m3": "mps2-an385",
    "m4f": "mps2-an386",
    "m7": "mps2-an500",
}
"""Emulated boards; ARMv6-M code runs on the Cortex-M3 of the first."""

ON_HOST = ("x86", "x86small", "mips", "stm32g4")
"""Programs of the host; stm32g4 is the program of that board on a model of its registers."""

QUIET = ["-nographic", "-monitor", "none", "-serial", "none"]


@dataclass(frozen=True)
class Outcome:
    """What a run left behind."""

    status: int
    answers: list[str]
    """Frames that the ECU sent, as lines of candump, reports of its health left out."""
    reports: list[str]
    """Its health reports (SwayFaultReport)."""
    figures: dict[str, int]
    message: str


def command(build: Path, target: str, arguments: list[str]) -> list[str]:
    """Return the command that runs a target's program with `arguments`."""
    image = str(build / f"replay_{target}.elf")
    target = target.split(".", maxsplit=1)[0]  # a copy that was damaged on purpose
    if target in ("x86", "x86small", "stm32g4"):
        return [image, *arguments]
    if target == "mips":
        return ["qemu-mips-static", image, *arguments]
    semihosting = "enable=on,target=native" + "".join(f",arg={a}" for a in arguments)
    if target == "r5":
        return [
            *("qemu-system-aarch64", "-M", "xlnx-zcu102,canbus0=bus,canbus1=bus"),
            *("-object", "can-bus,id=bus", "-smp", "6", "-m", "256M"),
            *("-audiodev", "none,id=none", *QUIET, "-icount", "shift=0"),
            *("-semihosting-config", semihosting),
            *("-device", f"loader,file={image}"),
            *("-device", f"loader,file={build / 'a53.bin'},addr=0x10000,force-raw=on"),
            *("-device", "loader,addr=0x10000,cpu-num=0"),
        ]
    return [
        *("qemu-system-arm", "-M", CORTEX_M[target], *QUIET, "-icount", "shift=8"),
        *("-semihosting-config", semihosting, "-kernel", image),
    ]


def run(build: Path, target: str, block: Path, recording: Path, name: str, *extra: str) -> Outcome:
    """Replay `recording` on a target; files of the run are `build`/runs/`name`.*."""
    folder = build / "runs"
    folder.mkdir(parents=True, exist_ok=True)
    output = folder / f"{name}.log"
    figures = folder / f"{name}.figures"
    output.unlink(missing_ok=True)
    figures.unlink(missing_ok=True)
    arguments = [str(block), str(recording), str(output)]
    if target not in ON_HOST:
        arguments.append(str(figures))
    done = subprocess.run(
        command(build, target, [*arguments, *extra]),
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    lines = output.read_text().splitlines() if output.exists() else []
    return Outcome(
        status=done.returncode,
        answers=[line for line in lines if " 6E2#" not in line],
        reports=[line for line in lines if " 6E2#" in line],
        figures=read_figures(figures),
        message=(done.stdout + done.stderr).strip(),
    )


def read_figures(path: Path) -> dict[str, int]:
    """Read `name value` lines; an absent file has none."""
    if not path.exists():
        return {}
    return {k: int(v) for k, v in (line.split() for line in path.read_text().splitlines())}


def frame_of(line: str) -> str:
    """Identifier and bytes of a line of candump."""
    return line.split(" ")[2]
