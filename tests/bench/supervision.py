"""Supervision campaign: how soon a broken sensor or another vehicle is found and correctly named.

``make bench-supervision`` simulates drives of 180 s with a swerve about every eight seconds, in
wind and on a road as in the warning campaign, and breaks something after 60 s (or has the vehicle
configured wrongly from the start). The core hears steering, speed, yaw rate and lateral
acceleration of both bodies; the vehicle is configured as its user knows it (masses 2 %, inertias
6 %, stiffnesses 10 % off). Words of the table:

- found: something becomes suspect, is rejected or reported after the fault began; seconds from
  there (median).
- right: the cause reported at the end of the drive is the true one (for a sensor: this sensor; its
  kind of fault may have another name).
- wrong: something else is reported, or another sensor is rejected.
- false: something is reported or rejected before the fault, or in a drive without any.

Seeds up to 3300 were used to choose tolerances and limits; the table starts at 10001.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parent))

import warning_campaign as warning
import warning_plant as plant

from swaywatch.ecu._core import lib
from swaywatch.ecu.core import Core, positions_of

FloatArray = npt.NDArray[np.float64]

SECONDS = 180.0
FAULT_S = 60.0
SENSORS = {
    "car_yaw_rate": 1,
    "car_lateral_acceleration": 2,
    "trailer_yaw_rate": 3,
    "trailer_lateral_acceleration": 4,
}
"""Sensors that are broken, and their channels in the core."""
SENSOR_FAULTS = ("delayed 80 ms", "scaled 1.25", "offset", "drifting", "inverted")
VEHICLE_FAULTS = (
    "trailer tyres -20 %",
    "200 kg moved 0.5 m",
    "wrong trailer",
    "hitch friction 150 Nm",
    "accelerometers roll",
)
CAUSES = ("nothing", *SENSOR_FAULTS, *VEHICLE_FAULTS)
RIGHT = {
    "trailer tyres -20 %": (lib.SWAY_FINDING_TRAILER_TYRES,),
    "200 kg moved 0.5 m": (lib.SWAY_FINDING_LOAD, lib.SWAY_FINDING_TRAILER),
    "wrong trailer": (lib.SWAY_FINDING_TRAILER,),
    "hitch friction 150 Nm": (lib.SWAY_FINDING_FRICTION,),
}
"""Findings that name a cause."""


@dataclass(frozen=True)
class Outcome:
    """What was said in one drive."""

    cause: str
    seed: int
    found_s: float | None
    right: bool
    wrong: bool
    false: bool
    finding: int
    size: float
    error: float


def swerves(course: plant.Course, rng: np.random.Generator) -> None:
    """A half-sine on the wheel about every eight seconds."""
    start = rng.uniform(3, 8)
    while start < SECONDS - 5:
        angle = math.radians(rng.uniform(5, 14)) * rng.choice([-1, 1])
        course.wheel += plant.half_sine(course.time_s, start, rng.uniform(0.6, 0.9), angle)
        start += rng.uniform(5, 11)


def moved_load(c: plant.Combination) -> plant.Combination:
    """200 kg half a metre to the rear."""
    shift = 200 * 0.5 / c.m2
    return replace(c, lf2=c.lf2 + shift, lr2=c.lr2 - shift, lh2=c.lh2 + shift)


def broken(
    cause: str, time_s: FloatArray, value: FloatArray, name: str, begin_s: float
) -> FloatArray:
    """A sensor's samples with `cause` from `begin_s` on."""
    on = time_s >= begin_s
    is_rate = name.endswith("yaw_rate")
    if cause == "delayed 80 ms":
        return np.where(on, np.interp(time_s - 0.08, time_s, value), value)
    if cause == "scaled 1.25":
        return np.where(on, 1.25 * value, value)
    if cause == "inverted":
        return np.where(on, -value, value)
    if cause == "offset":
        return value + on * (math.radians(3) if is_rate else 1.5)
    rate = math.radians(0.05) if is_rate else 0.025  # a second
    return value + on * (time_s - begin_s) * rate


def roll(time_s: FloatArray, value: FloatArray) -> FloatArray:
    """What an accelerometer shows that rolls with its body: 5 % more, roll mode of 1.5 Hz."""
    omega, damping = 2 * math.pi * 1.5, 0.3
    angle = rate = 0.0
    result = np.empty_like(value)
    for k, a in enumerate(value):
        dt = float(time_s[k] - time_s[k - 1]) if k else 0.01
        rate += dt * (omega**2 * (0.005 * a - angle) - 2 * damping * omega * rate)
        angle += dt * rate
        result[k] = a + 9.81 * angle
    return result


def drive(cause: str, seed: int) -> tuple[Any, Any, str, int, float]:
    """Drive, believed vehicle, broken sensor, its channel, and when the fault begins."""
    rng = np.random.default_rng([seed, len(cause), CAUSES.index(cause)])
    speed = rng.uniform(70, 110) / 3.6
    c = warning._stable_combination(rng, speed, 0.03)
    vehicle = warning.believed(c, rng)
    course = plant.course(SECONDS, speed)
    warning._road(course, rng, 1.0)
    swerves(course, rng)
    begin_s = FAULT_S
    if cause == "trailer tyres -20 %":
        course.factor[round(FAULT_S * 100) :, 2:] = 0.8
    elif cause == "hitch friction 150 Nm":
        c, begin_s = replace(c, hitch_friction=150.0), 0.0
    elif cause == "200 kg moved 0.5 m":
        c, begin_s = moved_load(c), 0.0
    elif cause == "wrong trailer":
        other = warning.believed(warning._stable_combination(rng, speed, 0.03), rng)
        vehicle, begin_s = replace(vehicle, trailer=other.trailer), 0.0
    samples = plant.measure(plant.simulate(c, course), rng)
    name = str(rng.choice(list(SENSORS)))
    if cause in SENSOR_FAULTS:
        time_s, value = samples[name]
        samples[name] = (time_s, broken(cause, time_s, value, name, begin_s))
    elif cause == "accelerometers roll":
        begin_s = 0.0
        for body in ("car", "trailer"):
            time_s, value = samples[f"{body}_lateral_acceleration"]
            samples[f"{body}_lateral_acceleration"] = (time_s, roll(time_s, value))
    return warning.as_drive(samples, c), vehicle, name, SENSORS[name], begin_s


def outcome(cause: str, seed: int) -> Outcome:
    """Runs one drive and reads what the core reports."""
    recording, vehicle, _, channel, begin_s = drive(cause, seed)
    status, _ = Core(vehicle, positions_of(recording)).feed(recording)
    said = (status["suspect_inputs"] | status["rejected_inputs"]) != 0
    said |= status["finding"] != 0
    time_s = status["time_us"] * 1e-6
    before = time_s < begin_s
    after = np.flatnonzero(said & ~before)
    last = status[-1]
    finding, rejected = int(last["finding"]), int(last["rejected_inputs"])
    reported_before = bool(np.any((status["finding"] != 0) & before))
    if cause in SENSOR_FAULTS:
        right = finding >= 16 and finding % 16 == channel and rejected & ~(1 << channel) == 0
    else:
        right = rejected == 0 and finding in RIGHT.get(cause, (0,))
    something = finding != 0 or rejected != 0
    harmless = cause in ("nothing", "accelerometers roll")
    return Outcome(
        cause, seed, float(time_s[after[0]] - begin_s) if len(after) else None,
        right and not reported_before, something and not right,
        reported_before or (harmless and something), finding,
        int(last["finding_size_micro"]) * 1e-6, int(last["finding_se_micro"]) * 1e-6,
    )  # fmt: skip


def rows(
    causes: tuple[str, ...], first_seed: int, each: int
) -> Iterator[tuple[str, list[Outcome]]]:
    """Every cause with its drives."""
    for cause in causes:
        yield cause, [outcome(cause, first_seed + k) for k in range(each)]


def line(cause: str, every: list[Outcome]) -> str:
    """A row of the table."""
    found = [t.found_s for t in every if t.found_s is not None]
    sizes = [t.size for t in every if t.right and t.finding]
    return (
        f"| {cause} | {len(every)} | {len(found)} | "
        f"{f'{np.median(found):.0f} s' if found else '-'} | {sum(t.right for t in every)} | "
        f"{sum(t.wrong for t in every)} | {sum(t.false for t in every)} | "
        f"{f'{np.median(sizes):.3f}' if sizes else '-'} |"
    )


def main() -> int:
    """Print and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first-seed", type=int, default=10001)
    parser.add_argument("--each", type=int, default=46, help="drives for each cause")
    parser.add_argument("--cause", choices=CAUSES, action="append", help="only this one")
    parser.add_argument("--verbose", action="store_true", help="every drive")
    parser.add_argument("--output", type=Path, help="write the table to this file")
    args = parser.parse_args()
    lines = [
        f"**`make bench-supervision`, seeds from {args.first_seed}: steering, speed, yaw rate and "
        "acceleration of both bodies**",
        "",
        "| cause | drives | found | after | correctly named | wrong | false | reported size |",
        "|---|---|---|---|---|---|---|---|",
    ]
    print("\n".join(lines), flush=True)
    for cause, every in rows(tuple(args.cause or CAUSES), args.first_seed, args.each):
        lines.append(line(cause, every))
        print(lines[-1], flush=True)
        if args.verbose:
            for t in every:
                print("   ", t)
    if args.output:
        args.output.parent.mkdir(parents=True, exist_ok=True)
        args.output.write_text("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
