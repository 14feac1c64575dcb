"""A survey of a generated fleet on a dask cluster: speed, memory, cost, a worker killed mid-way.

The fleet: one combination whose stiffnesses and masses scatter from vehicle to vehicle, each with
the vehicle.toml of the whole type, and one vehicle among them whose trailer has lost a fifth of
its rear axle's stiffness. Every survey is the command itself, on workers started by `dask worker`.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from swaywatch.ecu.bus import encode_drive
from swaywatch.recording import write_recording
from swaywatch.simulate import simulate_scenario
from swaywatch.simulate.scenario import read_scenario
from swaywatch.simulate.signals import write_signals
from swaywatch.survey.table import COST
from swaywatch.vehicle import Vehicle
from swaywatch.vehicle_file import load_vehicle

ROOT = Path(__file__).resolve().parents[2]
TYPE = ROOT / "tests/data/practice/p01/vehicle.toml"
BIN = Path(sys.executable).parent
SCATTER = 0.03
"""Of stiffnesses from vehicle to vehicle, standard deviation; of masses a third of it."""
LOST = 0.8
"""What is left of the odd vehicle's stiffness."""
SILENT_S = 900.0
"""A survey that says nothing for so long hangs."""


@dataclass(frozen=True)
class Survey:
    """One survey of the fleet: how many workers, how long, what they needed."""

    workers: int
    wall_s: float
    worker_mb: float
    rows: list[dict[str, object]]
    killed: bool = False


def make_fleet(folder: Path, count: int, duration_s: float) -> str:
    """Write `count` recordings with vehicle.toml and signals.toml; name of the odd one."""
    folder.mkdir(parents=True)
    believed = load_vehicle(TYPE)
    random = np.random.default_rng(20261122)
    odd = count * 2 // 3
    for number in range(count):
        vehicle = _scattered(believed, random, LOST if number == odd else 1.0)
        content = {
            "vehicle": "unused",
            "duration_s": duration_s,
            "speed_kmh": 100.0 + 8.0 * random.random(),
            "manoeuvre": [
                {"kind": "impulse", "start_s": 0.5, "angle_deg": 12.0 + 4.0 * random.random()}
            ],
        }
        scenario = read_scenario(content, "fleet", folder, "fleet", number + 1, vehicle)
        drive, _ = simulate_scenario(scenario)
        write_recording(folder / f"vehicle_{number:05d}.blf", encode_drive(drive))
        if number == 0:
            write_signals(folder / "signals.toml", drive)
    shutil.copy(TYPE, folder / "vehicle.toml")
    return f"vehicle_{odd:05d}.blf"


def _scattered(vehicle: Vehicle, random: np.random.Generator, left: float) -> Vehicle:
    car, trailer = vehicle.car, vehicle.trailer
    assert trailer is not None

    def factor(size: float) -> float:
        return float(1.0 + size * random.standard_normal())

    return replace(
        vehicle,
        car=replace(
            car,
            mass=car.mass * factor(SCATTER / 3.0),
            front_cornering_stiffness=(car.front_cornering_stiffness or 0.0) * factor(SCATTER),
            rear_cornering_stiffness=(car.rear_cornering_stiffness or 0.0) * factor(SCATTER),
        ),
        trailer=replace(
            trailer,
            mass=trailer.mass * factor(SCATTER / 3.0),
            front_cornering_stiffness=(trailer.front_cornering_stiffness or 0.0) * factor(SCATTER),
            rear_cornering_stiffness=(trailer.rear_cornering_stiffness or 0.0)
            * factor(SCATTER)
            * left,
        ),
    )


@contextlib.contextmanager
def cluster(count: int, log: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A scheduler and workers on this machine, each a process of its own; address, workers."""
    one_thread = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    started: list[subprocess.Popen[bytes]] = []

    def start(*words: str) -> subprocess.Popen[bytes]:
        with log.open("ab") as stream:
            process = subprocess.Popen(
                [str(BIN / "dask"), *words], stdout=stream, stderr=stream, env=one_thread
            )
        started.append(process)
        return process

    log.write_bytes(b"")
    try:
        start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        address = _address(log)
        alone = ["--nthreads", "1", "--no-dashboard", "--no-nanny"]
        alone += ["--local-directory", str(log.with_suffix(".dask"))]
        workers = [start("worker", address, *alone) for _ in range(count)]
        yield address, workers
    finally:
        for process in reversed(started):  # not asked: a worker whose scheduler ends may hang
            process.kill()
            process.wait()


def _address(log: Path) -> str:
    for _ in range(1200):
        found = re.search(r"Scheduler at:\s+(tcp://\S+)", log.read_text(errors="replace"))
        if found:
            return found[1]
        time.sleep(0.1)
    raise SystemExit(f"no scheduler came up; see {log}")


def survey(fleet: Path, out: Path, count: int, kill: bool = False) -> Survey:
    """Survey the fleet on `count` workers; `kill`: one of them is killed half-way.

    Without workers it is done by the command itself, a run at a time.
    """
    words = ["survey", str(fleet), "--out", str(out), "--diagnose", "none"]
    command = [str(BIN / "swaywatch"), *words]
    with contextlib.ExitStack() as stack:
        workers: list[subprocess.Popen[bytes]] = []
        if count:
            log = out.with_suffix(".log")
            address, workers = stack.enter_context(cluster(count, log))
            _until_connected(log, count)
            command += ["--scheduler", address]
        else:
            command += ["--jobs", "1"]
        start, memory = time.monotonic(), 0.0
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            for line in _lines(process):
                found = re.match(r"\[(\d+)/(\d+)\]", line)
                if not found:
                    continue
                done, of = int(found[1]), int(found[2])
                if done % max(1, of // 20) == 0:
                    memory = max([memory, *map(_memory_mb, workers)])
                if kill and 2 * done >= of:
                    workers[-1].send_signal(signal.SIGKILL)
                    kill = False
        took = time.monotonic() - start
        if process.returncode:
            raise SystemExit(f"{' '.join(command)}: exit code {process.returncode}")
        was_killed = bool(workers) and workers[-1].poll() == -signal.SIGKILL
    return Survey(
        count, took, memory, pq.read_table(out / "survey.parquet").to_pylist(), was_killed
    )


def _lines(process: subprocess.Popen[str]) -> Iterator[str]:
    """What the command says; one that says nothing for too long is ended, and fails thereby."""
    assert process.stdout is not None
    while True:
        alarm = threading.Timer(SILENT_S, process.kill)
        alarm.start()
        try:
            line = process.stdout.readline()
            if not line:
                process.wait()
                return
        finally:
            alarm.cancel()
        yield line


def _until_connected(log: Path, count: int) -> None:
    for _ in range(1200):
        if log.read_text(errors="replace").count("Registered to:") >= count:
            return
        time.sleep(0.1)
    raise SystemExit(f"the workers do not come up; see {log}")


def _memory_mb(worker: subprocess.Popen[bytes]) -> float:
    """Of a worker and all below it, shared pages by their share; 0 when it is gone."""
    total = 0
    for process in [worker.pid, *_children(worker.pid)]:
        with contextlib.suppress(OSError):
            text = Path(f"/proc/{process}/smaps_rollup").read_text()
            total += int(re.search(r"^Pss:\s+(\d+)", text, re.MULTILINE)[1])  # type: ignore[index]
    return total / 1024.0


def _children(process: int) -> list[int]:
    found: list[int] = []
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{process}/task").iterdir():
            for child in (task / "children").read_text().split():
                found += [int(child), *_children(int(child))]
    return found


def unlike_rows(one: Survey, other: Survey) -> list[str]:
    """Names of the runs whose rows differ in more than what they cost, or are in one table only."""
    cost = {name for name, _ in COST}

    def plain(of: Survey) -> dict[str, str]:  # as text: a NaN equals itself
        found = {
            str(row["name"]): repr({k: v for k, v in row.items() if k not in cost})
            for row in of.rows
        }
        assert len(found) == len(of.rows)
        return found

    mine, theirs = plain(one), plain(other)
    return sorted(name for name in mine | theirs if mine.get(name) != theirs.get(name))


def line_of(entry: Survey, first: Survey) -> str:
    """One survey as a row of the table."""
    name = f"{entry.workers or 'none, --jobs 1'}"
    name += ", one killed half-way" if entry.killed else ""
    memory = f"{entry.worker_mb:.0f}" if entry.workers else ""
    unlike = unlike_rows(entry, first)
    return (
        f"| {name} | {entry.wall_s:.0f} | {len(entry.rows) / entry.wall_s:.1f} "
        f"| {first.wall_s / entry.wall_s:.2f} | {memory} "
        f"| {f'NO: {len(unlike)}, such as {unlike[0]}' if unlike else 'yes'} |"
    )


def report(surveys: list[Survey], odd: str, duration_s: float, size_mb: float) -> str:
    """The table, Markdown."""
    first = surveys[0]
    count = len(first.rows)
    lines = [
        f"**`make bench-fleet`: {count} recordings of {duration_s:.0f} s on a dask cluster, "
        f"{os.cpu_count()} cores**\n",
        "| workers | seconds | recordings/s | speed-up | memory per worker [MB] | rows equal |",
        "|---|---|---|---|---|---|",
        *(line_of(entry, first) for entry in surveys),
    ]
    cpu = float(np.mean([float(str(row["cpu_s"])) for row in first.rows]))
    unlike = [row["name"] for row in first.rows if row["stands_out"]]
    wrong = [name for name in unlike if name != odd]
    lines += [
        "",
        f"Processor time per recording {cpu:.2f} s, size {size_mb:.2f} MB, so 1,000 workers with a "
        f"core each would do a million such recordings in {cpu * 1000.0 / 60.0:.0f} min if the "
        f"storage gives {1000.0 * size_mb / cpu / 1000.0:.1f} GB/s and the scheduler "
        f"{1000.0 / cpu:.0f} tasks/s (not tried). "
        f"Vehicle with {100 * (1 - LOST):.0f} % less stiffness at the trailer's rear axle, among "
        f"others that scatter by {100 * SCATTER:.0f} %: {'found' if odd in unlike else 'missed'}; "
        f"others that stand out: {len(wrong)}.",
    ]
    return "\n".join(lines) + "\n"


def main() -> int:
    """Make the fleet, survey it, say what it took; 1 where a row differs or is lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--workers", type=int, nargs="*", default=[1, 2, 4])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--report", type=Path)
    args = parser.parse_args()
    shutil.rmtree(args.out, ignore_errors=True)
    args.out.mkdir(parents=True)
    odd = make_fleet(args.out / "fleet", args.count, args.seconds)
    fleet = args.out / "fleet"
    size_mb = float(np.mean([file.stat().st_size for file in fleet.glob("*.blf")])) / 1e6
    surveys: list[Survey] = []
    for name, count, kill in [
        *((f"w{n}", n, False) for n in [0, *args.workers]),
        ("killed", 2, True),
    ]:
        surveys.append(survey(fleet, args.out / name, count, kill))
        print(line_of(surveys[-1], surveys[0]), file=sys.stderr, flush=True)
        text = report(surveys, odd, args.seconds, size_mb)
        if args.report:  # after each, so that what is done counts where the rest is cut off
            args.report.parent.mkdir(parents=True, exist_ok=True)
            args.report.write_text(text, encoding="utf-8")
    print(text)
    whole = all(
        len(s.rows) == args.count and not unlike_rows(s, surveys[0])
        and all(row["state"] == "not diagnosed" for row in s.rows)
        for s in surveys
    )  # fmt: skip
    return 0 if whole and surveys[-1].killed else 1


if __name__ == "__main__":
    sys.exit(main())
