"""Warnings with inputs lost: each one, and every two, from the start, from mid-swing, flickering.

``make bench-losses`` takes the unstable drives of the warning campaign (its words: onset, delay,
missed) and withholds inputs from the core:

- start: the input never comes;
- swing: it falls silent half a second before the onset;
- flicker: it is silent for 0.7 s of every 2 s.

A drive counts as missed where no warning is on at any moment from the onset to its end, as in the
campaign; only drives that end 3 oscillations or more after their onset are asked. A warning that
the remaining inputs do not allow is not distinguished from a missed one: all are counted.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parent))

import warning_campaign as warning
import warning_plant as plant

from swaywatch.vehicle import Vehicle

FloatArray = npt.NDArray[np.float64]
Samples = dict[str, tuple[FloatArray, FloatArray]]

HOW = ("start", "swing", "flicker")
LEAST_OSCILLATIONS = 3.0


@dataclass(frozen=True)
class Unstable:
    """One drive that becomes unstable: what was measured, what the user believes, the onset."""

    seed: int
    combination: plant.Combination
    believed: Vehicle
    samples: Samples
    onset_s: float
    end_s: float
    frequency_hz: float


def unstable(seed: int) -> Unstable | None:
    """Drive `seed` of the campaign; None where it has no onset with enough after it."""
    rng = np.random.default_rng([seed, len("unstable")])
    c, course, _, held = warning._unstable(rng)
    motion = plant.simulate(c, course)
    damping = warning.damping_over_time(c, course)
    end = warning.end_of(motion)
    onset = warning.onset_of(motion, damping, held)
    samples = plant.measure(motion, rng)
    if onset is None or onset >= end:
        return None
    hertz = warning.frequency(motion, onset / 100)
    if (end - onset) / 100 * hertz < LEAST_OSCILLATIONS:
        return None
    cut = {name: (t[: end + 1], v[: end + 1]) for name, (t, v) in samples.items()}
    return Unstable(seed, c, warning.believed(c, rng), cut, onset / 100, end / 100, hertz)


def drives(first_seed: int, count: int) -> Iterator[Unstable]:
    """The first `count` drives that qualify, from `first_seed` on."""
    found = (drive for seed in itertools.count(first_seed) if (drive := unstable(seed)))
    return itertools.islice(found, count)


def without(drive: Unstable, lost: tuple[str, ...], how: str) -> Samples:
    """The samples of `drive` with the inputs `lost` withheld (one of `HOW`)."""
    result = dict(drive.samples)
    for name in lost:
        time_s, value = result.pop(name)
        if how != "start":
            keep = time_s < drive.onset_s - 0.5 if how == "swing" else time_s % 2.0 < 1.3
            result[name] = (time_s[keep], value[keep])
    return result


def delay(drive: Unstable, lost: tuple[str, ...], how: str) -> float | None:
    """Oscillations from the onset to a warning; None: missed."""
    found = warning.warnings_of_core(
        warning.as_drive(without(drive, lost, how), drive.combination), drive.believed
    )
    return warning.delay_of(found.tolist(), drive.onset_s, drive.frequency_hz)


@dataclass(frozen=True)
class Row:
    """What was seen with one loss."""

    lost: tuple[str, ...]
    how: str
    drives: int
    missed: list[int]
    delays: list[float]

    def line(self) -> str:
        """A row of the table."""
        median, p95 = (
            (f"{np.median(self.delays):.2f}", f"{np.percentile(self.delays, 95):.2f}")
            if self.delays
            else ("-", "-")
        )
        name = " and ".join(self.lost).replace("_", " ") or "nothing"
        how = self.how if self.lost else ""
        return f"| {name} | {how} | {self.drives} | {len(self.missed)} | {median} | {p95} |"


def row(every: list[Unstable], lost: tuple[str, ...], how: str) -> Row:
    """Runs the core over all drives with one loss."""
    found = [(drive.seed, delay(drive, lost, how)) for drive in every]
    return Row(
        lost, how, len(every), [seed for seed, d in found if d is None],
        [d for _, d in found if d is not None],
    )  # fmt: skip


def losses(pairs: bool) -> list[tuple[tuple[str, ...], str]]:
    """Every loss: nothing, one input, two inputs."""
    single: list[tuple[str, ...]] = [(name,) for name in plant.SENSORS]
    double = list(itertools.combinations(plant.SENSORS, 2))
    chosen = double if pairs else single
    return [((), "start"), *((lost, how) for lost in chosen for how in HOW)]


def main() -> int:
    """Print and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first-seed", type=int, default=10001)
    parser.add_argument("--single", type=int, default=200, help="drives for each single loss")
    parser.add_argument("--double", type=int, default=20, help="drives for each double loss")
    parser.add_argument("--output", type=Path, help="write the table to this file")
    args = parser.parse_args()
    every = list(drives(args.first_seed, max(args.single, args.double)))
    lines = [
        f"**`make bench-losses`, seeds from {args.first_seed}: unstable drives of the warning "
        f"campaign with {LEAST_OSCILLATIONS:g} oscillations or more after the onset**",
        "",
        "| lost | how | drives | missed | median, oscillations | 95 % |",
        "|---|---|---|---|---|---|",
    ]
    print("\n".join(lines), flush=True)
    for count, pairs in ((args.single, False), (args.double, True)):
        for lost, how in losses(pairs) if count else []:
            lines.append(row(every[:count], lost, how).line())
            print(lines[-1], flush=True)
    if args.output:
        args.output.parent.mkdir(parents=True, exist_ok=True)
        args.output.write_text("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
