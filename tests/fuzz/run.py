"""``make fuzz``: every fuzzer for some processor time each; the hours are kept in RESULT.md.

Seconds are of the processor, not of the clock, so a busy machine does not shorten them. A row of
the result is one fuzzer on one version: another run on the same version adds to it. Exit status 1
where something was found; then the input is in the folder of the build.
"""

from __future__ import annotations

import argparse
import re
import resource
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ECU_CODE = ("lib", "port", "dbc")
HOST_CODE = ("lib", "port", "dbc", "sim_host/src")
SLICE_S = 300
"""Longest stretch by the clock, after which the processor time is read."""

ATTACKS = {
    "fuzz_real": "numbers of the core's arithmetic",
    "fuzz_track": "samples of the estimator, any order and times",
    "fuzz_node": "frames of the bus, most with right CRC and counter",
    "fuzz_ecu": "parameters over CAN, sessions, power cuts, faults, restarts",
    "fuzz_xcp": "the XCP slave: commands, addresses, sessions, lists",
    "fuzz_files": "parameter blocks, `vehicle.toml`, candump logs",
    "fuzz_recordings": "recordings, DBCs and TOMLs read by the host",
}
"""Name and what it attacks, in the order of the result."""

ROW = re.compile(r"^\| (\w+) \| [^|]+ \| (\w+) \| ([\d-]+) \| ([\d.]+) \| (\d+) \| ([^|]+) \|$")
TITLE = """# Fuzzing

How long each fuzzer ran on which version, by `make fuzz FUZZ_SECONDS=...` (processor time). A
version is the last change of what is fuzzed: lib, port and dbc, for the recordings sim_host/src
too; not every one was fuzzed. In `make test` the committed inputs and some mutations of them run.

| fuzzer | attacks | version | last run | minutes | inputs | found |
|---|---|---|---|---|---|---|
"""


@dataclass(frozen=True)
class Row:
    """One fuzzer on one version."""

    name: str
    version: str
    day: str
    minutes: float
    inputs: int
    found: str

    def __str__(self) -> str:
        return (
            f"| {self.name} | {ATTACKS[self.name]} | {self.version} | {self.day} | "
            f"{self.minutes:.1f} | {self.inputs} | {self.found} |"
        )


def rows_of(result: Path) -> list[Row]:
    """The rows that a result has."""
    if not result.exists():
        return []
    found = [ROW.match(line) for line in result.read_text(encoding="utf-8").splitlines()]
    return [
        Row(m[1], m[2], m[3], float(m[4]), int(m[5]), m[6]) for m in found if m and m[1] in ATTACKS
    ]


def added(rows: list[Row], row: Row) -> list[Row]:
    """The rows with one more, or more of one; in the order of the fuzzers, newest last."""
    kept, same = [], row
    for old in rows:
        if (old.name, old.version) == (row.name, row.version):
            found = row.found if old.found == "nothing" else old.found
            same = replace(
                row,
                minutes=old.minutes + row.minutes,
                inputs=old.inputs + row.inputs,
                found=found,
            )
        else:
            kept.append(old)
    order = list(ATTACKS)
    return sorted([*kept, same], key=lambda r: (order.index(r.name), r.day))


def version(name: str) -> str:
    """Last change of what this one fuzzes, with a mark where there are uncommitted ones."""
    fuzzed = HOST_CODE if name == "fuzz_recordings" else ECU_CODE

    def git(*words: str) -> str:
        done = subprocess.run(
            ("git", *words, "--", *fuzzed), cwd=ROOT, capture_output=True, text=True, check=False
        )
        return done.stdout.strip()

    return (git("log", "-1", "--format=%h") or "unknown") + ("x" if git("diff", "HEAD") else "")


def command(name: str, build: Path, seconds: float, seed: int) -> list[str]:
    """The fuzzer's own command for a stretch of time by the clock."""
    if name == "fuzz_recordings":
        tool = str(HERE / f"{name}.py")
        where = str(build / name)
        return [sys.executable, tool, f"--seconds={seconds}", f"--seed={seed}", f"--out={where}"]
    corpus = build / f"{name}.corpus"
    corpus.mkdir(parents=True, exist_ok=True)
    folders = [str(f) for f in (corpus, HERE / "corpus" / name) if f.exists()]
    return [
        str(build / f"libfuzzer_{name}"), f"-max_total_time={max(1, round(seconds))}",
        "-max_len=4096", f"-artifact_prefix={build / name}-", "-print_final_stats=1", *folders,
    ]  # fmt: skip


def spent_s() -> float:
    """Processor time of all that has run here."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def stretch(name: str, build: Path, seconds: float) -> tuple[float, int, str]:
    """Processor seconds, inputs, and what was found in a stretch of time by the clock."""
    first = spent_s()
    seed = int(time.time()) % 1_000_000_000
    words = command(name, build, seconds, seed)
    done = subprocess.run(words, capture_output=True, text=True, errors="replace", check=False)
    said = done.stdout + done.stderr
    counts = re.findall(r"number_of_executed_units: (\d+)|^(\d+) files, ", said, re.MULTILINE)
    if done.returncode:
        print("\n".join(said.splitlines()[-40:]))
    elif not counts:
        raise SystemExit(f"{name}: no count of inputs in what it wrote:\n{said[-2000:]}")
    inputs = sum(int(a or b) for a, b in counts)
    return spent_s() - first, inputs, "**yes**" if done.returncode else "nothing"


def run(name: str, build: Path, seconds: float, result: Path) -> tuple[float, int, str]:
    """Processor seconds, inputs, and what was found; the result grows with each stretch.

    So what was fuzzed before an interruption is kept.
    """
    spent, inputs, found = 0.0, 0, "nothing"
    while seconds - spent > 0.5 and found == "nothing":
        own_s, own, found = stretch(name, build, min(seconds - spent, SLICE_S))
        spent, inputs = spent + own_s, inputs + own
        row = Row(name, version(name), date.today().isoformat(), own_s / 60, own, found)
        rows = added(rows_of(result), row)
        result.write_text(TITLE + "".join(f"{r}\n" for r in rows), encoding="utf-8")
    return spent, inputs, found


def main() -> int:
    """Run the fuzzers named, one after the other."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="+", choices=list(ATTACKS), metavar="NAME")
    parser.add_argument("--seconds", type=float, default=60.0, help="processor time of each (60)")
    parser.add_argument("--build", type=Path, required=True, help="where the fuzzers are")
    parser.add_argument("--result", type=Path, required=True, help="RESULT.md, gets a row of each")
    args = parser.parse_args()
    bad = False
    for name in args.names:
        seconds, inputs, found = run(name, args.build.resolve(), args.seconds, args.result)
        print(f"{name}: {inputs} inputs in {seconds:.0f} s of processor time, found: {found}")
        bad = bad or found != "nothing"
    return 1 if bad else 0


if __name__ == "__main__":
    raise SystemExit(main())
