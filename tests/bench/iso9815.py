"""``make bench-iso9815``: simulated tests after ISO 9815, and whether their intervals hold.

A test: a drawn car with a trailer (every other one on springs with relaxing tyres), 4 to 6 speeds
over 15 to 35 km/h that end 5 to 30 km/h below its critical speed, two steering impulses at each,
sensors with noise and offsets, a hand that is not quite still. The truth is where the eigenvalues
of the very plant become unstable.
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "host"))

from drawn_drives import STEP_S, draw_body, measured, run, springs, steering
from written import written

from swaywatch.damping.course import Bend, Zero, fit_course
from swaywatch.damping.data import run_of
from swaywatch.damping.find import find
from swaywatch.damping.intervals import points_of
from swaywatch.damping.window import Estimator
from swaywatch.drive import Drive
from swaywatch.models.modes import critical_speed
from swaywatch.plant.lanes import BODY, PlantInput, neutral
from swaywatch.plant.sprung import put

Array = npt.NDArray[np.float64]
KMH = 3.6
BAND = (0.2, 10.0)
SECONDS = 28.0


@dataclass(frozen=True)
class Test:
    """One test: the vehicle, its critical speed and the speeds driven, m/s."""

    body: Array
    slots: dict[str, float]
    critical_m_s: float
    speeds: Array

    @property
    def gap_kmh(self) -> float:
        """From the fastest run to the critical speed."""
        return (self.critical_m_s - float(self.speeds.max())) * KMH


def drawn(rng: np.random.Generator, sprung: bool, linear: bool) -> Test:
    """A combination that sways: critical speed 85 to 160 km/h."""
    while True:
        body = draw_body(rng)
        body[BODY.index("trailer.yaw_inertia")] *= rng.uniform(1.2, 3.0)
        for axle in ("front", "rear"):
            body[BODY.index(f"trailer.{axle}_cornering_stiffness")] *= rng.uniform(0.7, 1.0)
        slots = springs(body, rng) if sprung else {}
        if linear:
            slots |= {"peak_friction_inverse": 0.0, "degression": 0.0}
        critical = critical_speed(_plant(body, slots))
        if not 85.0 <= critical * KMH <= 160.0:
            continue
        fastest = critical - rng.uniform(5.0, 30.0) / KMH
        span = rng.uniform(15.0, 35.0) / KMH
        speeds = np.linspace(fastest - span, fastest, int(rng.integers(4, 7)))
        return Test(body, slots, critical, speeds)


def _plant(body: Array, slots: dict[str, float]) -> PlantInput:
    still = np.zeros(3)
    return PlantInput(0.002, still + 20.0, still, still, body, put(neutral(), slots))


def drives(test: Test, rng: np.random.Generator) -> list[Drive]:
    """A recording per speed."""
    time = np.arange(0.0, SECONDS, STEP_S)
    found = []
    size = math.radians(rng.uniform(8.0, 19.0)) / 15.0
    for number, speed in enumerate(test.speeds):
        shape = steering("impulses", time, rng)
        course = np.full(time.size, speed)
        motion = run(test.body, test.slots, size * shape, course)
        places = (float(rng.uniform(-1.4, 0.5)), float(rng.uniform(-0.5, 0.5)))
        channels = measured(
            motion, 15.0 * size * shape, course, time, test.body, places, "no_forces", rng
        )
        found.append(Drive(f"run{number}", (Path(f"run{number}.blf"),), channels, 0))
    return found


def zeros(runs: list[Drive], estimator: Estimator) -> dict[str, Zero | None]:
    """Zero-damping speed with the combination's bend, and of the straight line."""
    points = [p for drive in runs for p in points_of(find(run_of(drive), BAND, estimator))]
    found: dict[str, Zero | None] = {}
    for name, bend in (("bent", Bend.TOWED), ("straight line", Bend.NONE)):
        course = fit_course(points, bend=bend)
        found[name] = None if course is None else course.zero()
    return found


def holds(zero: Zero, truth_m_s: float) -> bool:
    """The interval holds the truth."""
    return (zero.low is None or zero.low <= truth_m_s) and (
        zero.high is None or truth_m_s <= zero.high
    )


def main() -> int:
    """Run the tests, write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tests", type=int, default=300)
    parser.add_argument("--seed", type=int, default=20261122)
    parser.add_argument("--report", type=Path, required=True)
    args = parser.parse_args()
    estimator = Estimator()
    rows: dict[tuple[str, str], list[tuple[float, bool, float]]] = {}
    for number in range(args.tests):
        rng = np.random.default_rng((args.seed, number))
        sprung = number % 2 == 1
        linear = number % 4 == 1
        test = drawn(rng, sprung, linear)
        for name, zero in zeros(drives(test, rng), estimator).items():
            kind = (
                "on springs, linear tyres"
                if linear
                else "on springs, tyres that saturate"
                if sprung
                else "planar, linear tyres"
            )
            own = rows.setdefault((name, kind), [])
            if zero is None or zero.value is None:
                own.append((math.nan, True, math.nan))
                continue
            bounded = zero.low is not None and zero.high is not None
            width = (zero.high - zero.low) * KMH if bounded else math.nan  # type: ignore[operator]
            off = (zero.value - test.critical_m_s) * KMH
            own.append((off, holds(zero, test.critical_m_s), width))
    lines = [
        f"**`make bench-iso9815`**: {args.tests} simulated tests, critical speed 85 to 160 km/h, "
        "fastest run 5 to 30 km/h below it",
        "",
        "| course | vehicle | tests | error, median | 95 % of errors | intervals hold | "
        "half-width, median | not bounded |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for (name, kind), own in sorted(rows.items()):
        off = np.array([row[0] for row in own])
        width = np.array([row[2] for row in own])
        finite = np.isfinite(width)
        held = np.array([row[1] for row in own])[finite]
        good = off[finite]
        low, high = np.percentile(good, [2.5, 97.5])
        lines.append(
            f"| {name} | {kind} | {len(own)} | {np.median(good):+.1f} km/h | {low:+.1f} to "
            f"{high:+.1f} | {100 * held.mean():.0f} % | {np.median(width[finite]) / 2:.1f} km/h | "
            f"{int((~finite).sum())} |"
        )
    return written(lines, args.report)


if __name__ == "__main__":
    raise SystemExit(main())
