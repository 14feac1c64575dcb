"""``make bench-plan``: errors that a plan predicts beside those of simulated tests.

Each repeat draws a combination within the tolerances, drives the plan with sensor noise, road and
wind, and estimates the unknowns from what the sensors show (maximum likelihood with the belief as
prior). Errors of the estimates over the repeats against those of `swaywatch plan`: their ratio is
to lie between 0.7 and 1.4, of every unknown that the test tells more of than was believed.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from written import written

from swaywatch.plan.design import Design, make_design
from swaywatch.plan.information import (
    DISTURBANCES,
    PlannedDrive,
    critical_of,
    disturbed,
    lines_of,
    outputs,
    right_side,
    spectrum,
)
from swaywatch.plan.knowledge import Knowledge, KnownSensor, known_of, sensors_of
from swaywatch.plant.lanes import OUTPUT, Job, run_jobs
from swaywatch.vehicle_file import load_vehicle

Array = NDArray[np.float64]
TRUST = (1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, *([1.0] * 14))
"""Weight of what the sensors say against the belief, a round each."""
SETTLED = 1e-3
STARTS, PLAUSIBLE = 5, 1.5
FARTHEST = 2.0
"""Standard deviations of a belief that a drawn value may be off."""


def measured(
    known: Knowledge,
    drives: list[PlannedDrive],
    truth: Array,
    sensors: tuple[KnownSensor, ...],
    random: np.random.Generator,
) -> list[Array]:
    """What the sensors show of a drawn combination on a road in the wind; each (n, m)."""
    jobs = []
    for drive in drives:
        plant = known.plant(drive.time_s, drive.steer, drive.speed, truth)
        for disturbance in DISTURBANCES:
            course = disturbed(len(drive.steer), disturbance.rms, random)
            plant.add_series(disturbance.slot, course)
        jobs.append(Job(plant, columns=tuple(OUTPUT.index(s.output) for s in sensors)))
    noise = np.array([sensor.noise for sensor in sensors])
    found = []
    for outcome in run_jobs(jobs):
        assert outcome.output is not None
        offset = 5.0 * noise * random.normal(size=len(noise))
        found.append(outcome.output + offset + noise * random.normal(size=outcome.output.shape))
    return found


def estimated(
    known: Knowledge,
    drives: list[PlannedDrive],
    shown: list[Array],
    sensors: tuple[KnownSensor, ...],
) -> Array:
    """Unknowns from what the sensors show, in units of the tolerances from the belief.

    An estimate that leaves far more than road, wind and noise do has ended in a wrong place: then
    it is begun again elsewhere, and the likeliest end counts.
    """
    random = np.random.default_rng(1)
    ends = []
    start = np.zeros(len(known.unknowns))
    for _ in range(STARTS):
        off, left, unlikely = followed(known, drives, shown, sensors, start)
        ends.append((unlikely, off))
        if left < PLAUSIBLE:
            break
        start = np.clip(random.normal(size=len(start)), -FARTHEST, FARTHEST)
    return min(ends, key=lambda end: end[0])[1]


def followed(
    known: Knowledge,
    drives: list[PlannedDrive],
    shown: list[Array],
    sensors: tuple[KnownSensor, ...],
    start: Array,
) -> tuple[Array, float, float]:
    """Where Gauss-Newton ends, what it leaves (1: as expected), minus twice the log posterior.

    Far from the answer sensors that are very exact pull unknowns that they hardly see to nowhere:
    the first rounds trust them less (`TRUST`).
    """
    lowest = -known.values / known.deviations
    off = np.maximum(start, lowest)
    for trust in TRUST:
        at = known.values + off * known.deviations
        model = outputs(known, drives, [at] * len(drives), sensors)
        normal, right = np.eye(len(off)), -off
        power, unlikely, count = 0.0, float(off @ off), 0
        for own, seen, said in zip(
            lines_of(known, drives, sensors, at, scatter=False), shown, model, strict=True
        ):
            rest = spectrum(seen - said)
            informed, weight = own.weights()
            normal = normal + trust * informed
            right = right + trust * right_side(weight, rest)
            covariance = own.covariance()
            solved = np.linalg.solve(covariance, rest[:, :, None])[:, :, 0]
            power += float(np.sum(rest.conj() * solved).real)
            unlikely += 2.0 * float(np.sum(np.linalg.slogdet(covariance)[1]))
            count += rest.size
        moved = np.maximum(off + np.clip(np.linalg.solve(normal, right), -1.0, 1.0), lowest)
        if trust == 1.0 and np.abs(moved - off).max() < SETTLED:
            break
        off = moved
    return np.asarray(off), power / count, unlikely + 2.0 * power


def ratios(known: Knowledge, design: Design, repeats: int, seed: int) -> tuple[Array, Array, float]:
    """Of every unknown: predicted error, error obtained; and the ratio for the critical speed."""
    random = np.random.default_rng(seed)
    sensors = sensors_of(design.sensors)
    drives = [block.drive() for block in design.blocks]
    critical = critical_of(known)
    errors, speeds = [], []
    for _ in range(repeats):
        drawn = np.clip(random.normal(size=len(known.unknowns)), -FARTHEST, FARTHEST)
        drawn = np.maximum(drawn, -known.values / known.deviations)  # none is below zero
        truth = known.values + drawn * known.deviations
        shown = measured(known, drives, truth, sensors, random)
        errors.append(estimated(known, drives, shown, sensors) - drawn)
        speeds.append(float(critical.slopes @ errors[-1]))
    predicted = np.sqrt(np.diag(design.covariance))
    obtained = np.sqrt(np.mean(np.square(errors), axis=0))
    speed = critical.error(design.covariance) / float(np.sqrt(np.mean(np.square(speeds))))
    return predicted, np.asarray(obtained), speed


def main() -> int:
    """Table over three vehicles."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=100)
    parser.add_argument("--report", type=Path, required=True)
    args = parser.parse_args()
    data = Path(__file__).resolve().parent.parent / "data" / "practice"
    lines = [
        f"**`make bench-plan`**: errors that `plan` predicts over those of {args.repeats} "
        "simulated tests each",
        "",
        "| vehicle | sensors | goal | blocks of 20 s | critical speed | unknowns | slalom for it |",
        "|---|---|---|---|---|---|---|",
    ]
    base = load_vehicle(data / "p03" / "vehicle.toml")
    assert base.trailer is not None
    for name, sensors, mass, inertia in (
        ("as in p03", "trailer", 1.0, 1.0),
        ("light trailer", "own", 0.6, 0.5),
        ("long trailer", "forces", 1.1, 1.5),
    ):
        trailer = replace(
            base.trailer, mass=mass * base.trailer.mass,
            yaw_inertia=inertia * base.trailer.yaw_inertia,
        )  # fmt: skip
        known = known_of(replace(base, trailer=trailer))
        for goal, error in (("critical-speed", 1.0), ("parameters", 2.5)):
            design = make_design(known, sensors, goal=goal, error=error)
            predicted, obtained, speed = ratios(known, design, args.repeats, 5)
            informed = predicted < 0.7
            part = predicted[informed] / obtained[informed]
            lines.append(
                f"| {name} | {sensors} | {goal} | {len(design.blocks)} | {speed:.2f} | "
                f"{part.min():.2f} to {part.max():.2f} ({informed.sum():d} of {len(informed)}) | "
                f"{design.slalom_blocks:.0f} blocks |"
            )
    return written(lines, args.report)


if __name__ == "__main__":
    raise SystemExit(main())
