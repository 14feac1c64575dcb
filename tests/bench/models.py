"""Real-time factor of each depth of model, and a campaign on one core and on all.

Factors are simulated time over processor time of this process, so that other work on the machine
does not count. Usage: models.py [--drives N] [--report FILE]
"""

from __future__ import annotations

import argparse
import os
import platform
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from swaywatch.models.double_track import DoubleTrack
from swaywatch.models.physics import PhysicsEffect
from swaywatch.models.single_track import SingleTrack
from swaywatch.simulate.campaign import jobs_of, run_campaign
from swaywatch.simulate.run import simulate_plant
from swaywatch.simulate.scenario import read_scenario
from swaywatch.vehicle_file import load_vehicle

FOLDER = Path(__file__).resolve().parent.parent / "data" / "practice" / "p01"
LENGTH_S = 60.0
PHYSICS = (
    PhysicsEffect("steering_compliance"),
    PhysicsEffect("tyre_relaxation", axle="all", length_m=0.5),
    PhysicsEffect("tyre_saturation"), PhysicsEffect("tyre_load_sensitivity"),
    PhysicsEffect("hitch_friction"),
    PhysicsEffect("trailer_aerodynamics"), PhysicsEffect("roll_steer"),
    PhysicsEffect("axle_load_harmonic", amplitude_n=500.0),
)  # fmt: skip
SCENARIO = """
vehicle = "{vehicle}"
duration_s = 30.0
speed_kmh = 100.0
[[manoeuvre]]
kind = "impulse"
angle_deg = 10.0
[[vary]]
key = "speed_kmh"
low = 80.0
high = 122.0
[[vary]]
key = "manoeuvre.0.angle_deg"
low = 5.0
high = 19.0
"""


def factor(run: Callable[[], object], simulated_s: float = LENGTH_S, times: int = 5) -> float:
    """Best simulated time per processor time."""
    run()  # compiles
    best = float("inf")
    for _ in range(times):
        start = time.process_time()
        run()
        best = min(best, time.process_time() - start)
    return simulated_s / best


def depths() -> list[tuple[str, float]]:
    """Real-time factors by name."""
    vehicle = load_vehicle(FOLDER / "vehicle.toml")
    axis = np.arange(0.0, LENGTH_S, 0.01)
    steering = np.radians(8.0) * np.sin(2.0 * np.pi * 0.5 * axis)
    single, plain = SingleTrack.of(vehicle), DoubleTrack(vehicle)
    rich = DoubleTrack(vehicle, PHYSICS)
    rows = [("single track, 10 ms", factor(lambda: single.run(axis, steering, 25.0)))]
    for name, model in (("double track", plain), ("double track, 8 effects", rich)):
        for step in (0.001, 0.002, 0.005):
            rows.append((
                f"{name}, {1e3 * step:g} ms",
                factor(lambda m=model, s=step: m.run(axis, steering, 25.0, step_s=s)),
            ))  # fmt: skip
    try:
        import mujoco  # noqa: F401
    except ImportError:
        return rows
    for bodies in ("planar", "moving"):
        content = {
            "vehicle": "vehicle.toml", "duration_s": 20.0, "speed_kmh": 90.0,
            "model": "multibody", "manoeuvre": [{"kind": "impulse"}],
            "multibody": {"bodies": bodies},
        }  # fmt: skip
        scenario = read_scenario(content, "bench", FOLDER, "bench")
        speed = factor(lambda s=scenario: simulate_plant(s), 20.0, 3)
        rows.append((f"multibody on MuJoCo, {bodies} bodies, 2 ms", speed))
    return rows


def campaign(drives: int, build: Path) -> list[str]:
    """A campaign on one core and on all: wall time, and how many cores were at work."""
    build.mkdir(parents=True, exist_ok=True)
    file = build / "campaign.toml"
    file.write_text(SCENARIO.replace("{vehicle}", (FOLDER / "vehicle.toml").as_posix()))
    lines = []
    for workers in sorted({1, os.cpu_count() or 1}):
        jobs = jobs_of(file, drives)
        before = os.times()
        start = time.monotonic()
        outcomes = run_campaign(jobs, workers)
        wall = time.monotonic() - start
        after = os.times()
        used = (
            after.user + after.system + after.children_user + after.children_system
            - before.user - before.system - before.children_user - before.children_system
        )  # fmt: skip
        simulated = sum(outcome.duration_s for outcome in outcomes)
        lines.append(
            f"| {drives} drives, {workers} process{'es' if workers > 1 else ''} | {wall:.1f} s | "
            f"{used / wall:.2f} | {simulated / wall:.0f} |"
        )
    return lines


def main() -> None:
    """Print both tables, and write them to --report."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--drives", type=int, default=500)
    parser.add_argument("--report", type=Path, default=Path("build/bench/depths.md"))
    args = parser.parse_args()
    lines = [
        "**`make bench`: simulated seconds per second of one core "
        f"({platform.machine()}, processor time, best of 5)**",
        "", "| model | simulated s per s |", "|---|---|",
        *(f"| {name} | {value:.0f} |" for name, value in depths()),
        "", "**The same: a campaign of 30 s drives with sensors and message times**",
        "", "| | wall time | cores at work | simulated s per s |", "|---|---|---|---|",
        *campaign(args.drives, args.report.parent),
    ]  # fmt: skip
    args.report.parent.mkdir(parents=True, exist_ok=True)
    args.report.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
