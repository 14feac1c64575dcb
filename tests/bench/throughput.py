"""How many times faster than real time a long recording is analysed, each format by itself.

The recording is the practice case played again and again: 16 signals at 100 Hz in nine messages.
CPU seconds are given beside wall-clock seconds, since other work may share the machine.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from swaywatch.recording import Frames, read_recording, write_recording

CASE = Path(__file__).resolve().parents[1] / "data" / "practice" / "p01"


def long_recording(minutes: float) -> Frames:
    """The practice case repeated to `minutes`."""
    frames = read_recording(CASE / "run1.blf").frames
    assert frames is not None
    span_ns = 38_000_000_000
    count = max(1, round(minutes * 60e9 / span_ns))
    return Frames(
        np.concatenate([frames.time_ns + part * span_ns for part in range(count)]),
        np.tile(frames.identifier, count),
        np.tile(frames.extended, count),
        np.tile(frames.length, count),
        np.tile(frames.data, (count, 1)),
        np.tile(frames.bus, count),
    )


def measure(path: Path, out: Path) -> tuple[float, float]:
    """Wall-clock and CPU seconds of the whole command, start of Python included."""
    before = os.times()
    start = time.monotonic()
    subprocess.run(
        [sys.executable, "-m", "swaywatch.cli", "analyze", str(path),
         "--vehicle", str(CASE / "vehicle.toml"), "--signals", str(CASE / "signals.toml"),
         "--out", str(out)],
        check=True, stdout=subprocess.DEVNULL,
    )  # fmt: skip
    after = os.times()
    cpu = after.children_user + after.children_system
    cpu -= before.children_user + before.children_system
    return time.monotonic() - start, cpu


def main() -> None:
    """Print one line for each format."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--formats", nargs="+", default=["mf4", "blf"])
    parser.add_argument("--markdown", type=Path, help="write the table to this file too")
    args = parser.parse_args()
    frames = long_recording(args.minutes)
    length_s = float(frames.time_ns[-1] - frames.time_ns[0]) * 1e-9
    print(f"{length_s / 60:.0f} minutes, {len(frames)} frames, {os.cpu_count()} CPUs, "
          f"load {os.getloadavg()[0]:.1f}")  # fmt: skip
    lines = [
        f"**`make bench-throughput`**: a recording of {length_s / 60:.0f} minutes, {len(frames)} "
        f"frames, analysed with its report; {os.cpu_count()} CPUs, load {os.getloadavg()[0]:.1f}",
        "",
        "| format | wall time | processor time | faster than real time |",
        "|---|---|---|---|",
    ]
    with tempfile.TemporaryDirectory() as folder:
        for suffix in args.formats:
            path = Path(folder) / f"long.{suffix}"
            write_recording(path, frames)
            wall, cpu = measure(path, Path(folder) / "out")
            rate = len(frames) / wall / 1e3
            print(
                f"{suffix:8s} {wall:6.1f} s ({cpu:.1f} s CPU): {length_s / wall:.0f} times "
                f"faster than real time, {rate:.0f} thousand frames/s"
            )
            lines.append(f"| {suffix} | {wall:.1f} s | {cpu:.1f} s | {length_s / wall:.0f} times |")
    if args.markdown is not None:
        args.markdown.parent.mkdir(parents=True, exist_ok=True)
        args.markdown.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
