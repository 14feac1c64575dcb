"""Warning campaign: how soon the alarm warns, how often for nothing, beside three usual detectors.

``make bench-warning`` simulates

- unstable drives: the damping ratio becomes negative (speed, downhill, a failing tyre) with
  the steering wheel held;
- stable drives: slalom, lane changes, gusts, rough road, damping ratio above 0.03 throughout;
- hours of ordinary driving with a driver in the loop.

The user's vehicle data are wrong by some percent in every drive. Words of the table:

- onset: the first moment at which the true damping ratio of the linear combination is negative, the
  wheel has come to rest for good, and the trailer's yaw rate has swung by 3 deg/s or more within
  1.5 s: below that it is wind and road. A drive without such a moment is not counted as unstable,
  nor is one that ends (articulation beyond 20 deg) within 2.5 oscillations of it.
- delay: from the onset to the first moment at which the warning is on, in oscillations; 0 where it
  is on already.
- missed: not on at any moment from the onset to the end of the drive (up to 30 s).
- false: a warning that begins while the true damping ratio has been above 0.02 for a second, unless
  control is lost within 15 s of it.

Seeds up to 3300 were used to choose thresholds; the campaign starts at 10001.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parent))

import warning_plant as plant
from warning_baselines import DETECTORS

from swaywatch.drive import Channel, Drive
from swaywatch.ecu import _core
from swaywatch.ecu.core import Core, positions_of
from swaywatch.vehicle import Car, Trailer, Vehicle

FloatArray = npt.NDArray[np.float64]

VISIBLE_RAD_S = math.radians(3.0)
FALSE_DAMPING = 0.02
LOST_RAD = math.radians(20)
OURS = "swaywatch"
MANOEUVRES = ("slalom", "lane change", "gusts", "rough road")


@dataclass(frozen=True)
class Result:
    """What one drive gave."""

    kind: str
    seed: int
    hours: float
    frequency_hz: float
    onset_s: float | None
    end_s: float
    lost: bool
    v_crit_m_s: float
    warnings_s: dict[str, list[list[float]]]
    false_s: dict[str, list[float]]
    delay_oscillations: dict[str, float | None]


def combination(rng: np.random.Generator) -> plant.Combination:
    """A random combination around the reference's: load, its place, tyres."""
    mass = rng.uniform(900, 2300)
    shift = rng.uniform(-0.25, 0.2)  # of the trailer's COG, ahead
    stiffness = np.array([109.3e3, 185.2e3, 131.2e3, 124.4e3]) * rng.uniform(0.85, 1.15, 4)
    stiffness[2:] *= (mass / 1880) ** 0.7
    return plant.Combination(
        m1=rng.uniform(1600, 2200),
        m2=mass,
        i1=2690 * rng.uniform(0.85, 1.15),
        i2=10350 * mass / 1880 * rng.uniform(0.8, 1.15),
        lf2=0.124 - shift,
        lr2=0.526 + shift,
        lh2=5.073 - shift,
        stiffness=tuple(stiffness),
        relaxation=tuple(rng.uniform(0.1, 0.6, 4)),
    )


def believed(c: plant.Combination, rng: np.random.Generator) -> Vehicle:
    """What the user writes into vehicle.toml: weighed masses, guessed tyres and inertias."""

    def off(spread: float) -> float:
        return float(1 + np.clip(rng.normal(0, spread), -2.5 * spread, 2.5 * spread))

    car = Car(
        mass=c.m1 * off(0.02), yaw_inertia=c.i1 * off(0.06), front_axle_to_cog=c.lf1,
        rear_axle_to_cog=c.lr1, steering_ratio=c.ratio, hitch_to_cog=c.lh1,
        front_cornering_stiffness=c.stiffness[0] * off(0.1),
        rear_cornering_stiffness=c.stiffness[1] * off(0.1),
    )  # fmt: skip
    both = off(0.1)
    trailer = Trailer(
        mass=c.m2 * off(0.02), yaw_inertia=c.i2 * off(0.06), rear_axle_to_cog=c.lr2,
        hitch_to_cog=c.lh2, front_axle_to_cog=c.lf2,
        front_cornering_stiffness=c.stiffness[2] * both * off(0.03),
        rear_cornering_stiffness=c.stiffness[3] * both * off(0.03),
    )  # fmt: skip
    return Vehicle(car, trailer, Path("vehicle.toml"))


def as_drive(samples: dict[str, tuple[FloatArray, FloatArray]], c: plant.Combination) -> Drive:
    """The measured signals as the product's own drive."""
    position = {"car_lateral_acceleration": -c.lr1}
    channels = {
        name: Channel(name, time_s, value, name, "", position.get(name, 0.0))
        for name, (time_s, value) in samples.items()
    }
    return Drive("warning", (), channels, 0)


def warnings_of_core(drive: Drive, vehicle: Vehicle) -> FloatArray:
    """Start and end of the core's warnings (state `warning` or `critical`), shape (n, 2)."""
    status, _ = Core(vehicle, positions_of(drive)).feed(drive)
    time_s = np.append(status["time_us"] * 1e-6, drive.duration_s)
    edge = np.diff(np.concatenate([[False], status["alarm"] >= 3, [False]]).astype(int))
    return np.column_stack([time_s[np.flatnonzero(edge > 0)], time_s[np.flatnonzero(edge < 0)]])


def even(samples: dict[str, tuple[FloatArray, FloatArray]], n: int) -> dict[str, FloatArray]:
    """Signals on the plain 100 Hz axis that the other detectors work on."""
    axis = np.arange(n) * plant.STEP_S
    return {name: np.interp(axis, t, value) for name, (t, value) in samples.items()}


def damping_over_time(c: plant.Combination, course: plant.Course) -> FloatArray:
    """True damping ratio of the linear combination, every 0.1 s, held between."""
    n = len(course.speed)
    if np.all(course.factor == 1.0):
        # The tyres stay as they are: a table over the speed, every 0.1 m/s, is as good.
        low, high = float(course.speed.min()) - 0.1, float(course.speed.max()) + 0.1
        axis = np.linspace(low, high, 2 + round((high - low) / 0.1))
        values = [plant.damping_ratio(c, speed) for speed in axis]
        return np.asarray(np.interp(course.speed, axis, values))
    result = np.empty(n)
    last: tuple[float, ...] = ()
    value = 0.0
    for k in range(0, n, 10):
        key = (round(course.speed[k], 2), *np.round(course.factor[k], 3))
        if key != last:
            value = plant.damping_ratio(c, course.speed[k], course.factor[k])
            last = key
        result[k : k + 10] = value
    return result


def frequency(motion: plant.Motion, start_s: float) -> float:
    """Of the trailer's yaw rate after `start_s`, from its crossings of the mean."""
    part = motion.trailer_yaw_rate[round(start_s * 100) :][:1200]
    swing = part - np.mean(part)
    crossings = np.flatnonzero(np.diff(np.sign(swing)) != 0)
    if len(crossings) < 3:
        return 0.65
    return float(np.clip(0.5 * 100 / np.median(np.diff(crossings)), 0.3, 1.5))


# --- drives --------------------------------------------------------------------------------------


def _road(course: plant.Course, rng: np.random.Generator, strength: float) -> None:
    plant.add_turbulence(course, rng, strength * rng.uniform(20, 150))
    plant.add_roughness(course, rng, strength * math.radians(rng.uniform(0.01, 0.06)))
    plant.add_hand(course, rng, strength * math.radians(rng.uniform(0.05, 0.25)))


def _tyre_failure(
    c: plant.Combination, rng: np.random.Generator, speed: float
) -> FloatArray | None:
    """Factors on the stiffnesses that make it sway (not spin) at `speed`; None: not found."""
    factor = np.ones(4)
    while factor.min() > 0.4:
        if plant.damping_ratio(c, speed, factor) < -0.015:
            return factor
        factor[int(rng.integers(1, 4))] *= 0.9
        if plant.diverges(c, speed, factor):
            return None
    return None


def _approach(
    rng: np.random.Generator, kind: str, calm_s: float
) -> tuple[plant.Combination, plant.Course]:
    """Car, trailer and course whose damping is negative from about `calm_s` on."""
    while True:
        c = combination(rng)
        v_crit = plant.critical_speed(c)
        if not 62 / 3.6 < v_crit < 135 / 3.6 or plant.diverges(c, 1.12 * v_crit):
            continue
        if kind == "tyre":
            course = plant.course(calm_s + 30, v_crit * rng.uniform(0.85, 0.97))
            factor = _tyre_failure(c, rng, float(course.speed[0]))
            if factor is not None:
                change = np.clip((course.time_s - calm_s) / rng.uniform(0.5, 3), 0, 1)
                course.factor[:] = 1 + (factor - 1) * change[:, None]
                return c, course
        else:
            rate = rng.uniform(0.3, 1.0) if kind == "acceleration" else rng.uniform(0.1, 0.35)
            course = plant.course(calm_s + 30, 0.0)
            climb = np.maximum(v_crit + rate * (course.time_s - calm_s), 0.8 * v_crit)
            course.speed[:] = np.minimum(climb, v_crit * rng.uniform(1.03, 1.12))
            return c, course


def _unstable(rng: np.random.Generator) -> tuple[plant.Combination, plant.Course, str, int]:
    """One drive whose damping becomes negative; and the row from which the wheel is held.

    Swerves and gusts set it swinging; the last one comes within 3 s of the damping's change of
    sign, before or after it. From then on the wheel is held, but for the tremor of the hands.
    """
    kind = str(rng.choice(["acceleration", "downhill", "tyre"]))
    calm_s = 40.0
    c, course = _approach(rng, kind, calm_s)
    time_s = course.time_s
    held = 0.0
    for start in (*np.sort(rng.uniform(5, calm_s - 6, 3)), calm_s + rng.uniform(-3, 3)):
        if rng.random() < 0.6:
            length = rng.uniform(0.6, 0.9)
            angle = math.radians(rng.uniform(6, 16)) * rng.choice([-1, 1])
            course.wheel += plant.half_sine(time_s, start, length, angle)
        else:
            length = rng.uniform(0.6, 2.0)
            k0, count = round(start * 100), round(length * 100)
            shape = 0.5 * (1 - np.cos(2 * np.pi * np.arange(count) / count))
            course.side[k0 : k0 + count, 1] += rng.uniform(500, 1500) * shape
        held = start + length
    _road(course, rng, 1.0)
    return c, course, kind, round(held * 100)


def _stable_combination(rng: np.random.Generator, speed: float, least: float) -> plant.Combination:
    while True:
        c = combination(rng)
        if plant.damping_ratio(c, speed) > least:
            return c


def _stable(rng: np.random.Generator) -> tuple[plant.Combination, plant.Course, str]:
    """A manoeuvre or bad weather, stable throughout."""
    kind = str(rng.choice(MANOEUVRES))
    speed = rng.uniform(60, 120) / 3.6
    c = _stable_combination(rng, speed, 0.03)
    course = plant.course(60.0, speed)
    _road(course, rng, 1.0)
    time_s = course.time_s
    if kind == "slalom":
        frequency_hz = rng.uniform(0.2, 0.8)
        angle = math.radians(rng.uniform(5, 30))
        course.wheel += plant.full_sine(time_s, 8, 1 / frequency_hz, angle, rng.integers(3, 15))
    elif kind == "lane change":
        for start in np.cumsum(rng.uniform(6, 12, 5)):
            angle = math.radians(rng.uniform(10, 40)) * rng.choice([-1, 1])
            course.wheel += plant.full_sine(time_s, start, rng.uniform(1.5, 4), angle)
    elif kind == "gusts":
        plant.add_gusts(course, rng, 10, 900)
    else:
        plant.add_roughness(course, rng, math.radians(rng.uniform(0.1, 0.3)))
    return c, course, kind


def _ordinary(rng: np.random.Generator, seconds: float) -> tuple[plant.Combination, plant.Course]:
    """A stretch of ordinary driving with a driver who keeps and changes lanes."""
    fastest = rng.uniform(75, 115) / 3.6
    c = _stable_combination(rng, fastest, 0.05)
    course = plant.course(seconds, fastest)
    time_s = course.time_s
    slow = plant.coloured(rng, len(time_s), 0.01, 2)
    course.speed[:] = np.clip(fastest * (0.85 + 0.12 * slow), 40 / 3.6, fastest)
    _road(course, rng, 1.0)
    plant.add_gusts(course, rng, 1.0, 500)
    course.follow = rng.uniform(0.4, 0.8)
    lane = np.zeros(len(time_s))
    start = 0.0
    side = 0.0
    while start < seconds:
        start += rng.exponential(60)
        length = rng.uniform(3, 7)
        side_next = 3.6 if side == 0.0 else 0.0
        step = np.clip((time_s - start) / length, 0, 1)
        lane += (side_next - side) * (3 * step**2 - 2 * step**3)
        side = side_next
    course.lane[:] = lane + 0.2 * plant.coloured(rng, len(time_s), 0.05)
    return c, course


def _driven(
    rng: np.random.Generator, seconds: float
) -> tuple[plant.Combination, plant.Course, plant.Motion]:
    """Ordinary driving that stays on the road: a driver who loses it is replaced by another."""
    while True:
        c, course = _ordinary(rng, seconds)
        motion = plant.simulate(c, course)
        if end_of(motion) == len(motion.time_s) - 1:
            return c, course, motion


# --- running and scoring -------------------------------------------------------------------------


def onset_of(motion: plant.Motion, damping: FloatArray, held: int) -> int | None:
    """First row with negative damping, wheel held to the end, and a visible swing."""
    swing = motion.trailer_yaw_rate - np.convolve(
        motion.trailer_yaw_rate, np.ones(150) / 150, mode="same"
    )
    wide = np.lib.stride_tricks.sliding_window_view(np.abs(swing), 150).max(axis=1)
    visible = np.concatenate([np.zeros(149, dtype=bool), wide > VISIBLE_RAD_S])
    rows = np.flatnonzero((damping < 0) & visible)
    rows = rows[rows >= held]
    return int(rows[0]) if len(rows) else None


def end_of(motion: plant.Motion) -> int:
    """Row at which control is lost, or the last."""
    lost = np.flatnonzero(np.abs(motion.articulation) > LOST_RAD)
    return int(lost[0]) if len(lost) else len(motion.time_s) - 1


def run(kind: str, seed: int, seconds: float = 0.0) -> Result:
    """Simulate one drive, run every detector on it, score."""
    rng = np.random.default_rng([seed, len(kind)])
    held: int | None = None
    if kind == "unstable":
        c, course, label, held = _unstable(rng)
    elif kind == "stable":
        c, course, label = _stable(rng)
    else:
        c, course, motion = _driven(rng, seconds)
        label = "ordinary"
    if kind != "ordinary":
        motion = plant.simulate(c, course)
    damping = damping_over_time(c, course)
    end = end_of(motion)
    lost = end < len(motion.time_s) - 1
    onset = onset_of(motion, damping, held) if held is not None else None
    if onset is not None and onset >= end:
        onset = None
    samples = plant.measure(motion, rng)
    samples = {n: (t[: end + 1], v[: end + 1]) for n, (t, v) in samples.items()}
    signals = even(samples, end + 1)
    found = {OURS: warnings_of_core(as_drive(samples, c), believed(c, rng)).tolist()}
    found |= {name: detector(signals).tolist() for name, detector in DETECTORS.items()}
    hertz = frequency(motion, onset / 100 if onset else 5.0)
    false = {
        name: [start for start, _ in warnings if is_false(start, damping, end, lost)]
        for name, warnings in found.items()
    }
    delay = {
        name: None if onset is None else delay_of(warnings, onset / 100, hertz)
        for name, warnings in found.items()
    }
    return Result(
        label, seed, end / 360000, hertz, None if onset is None else onset / 100, end / 100, lost,
        plant.critical_speed(c, course.factor[-1]), found, false, delay,
    )  # fmt: skip


def is_false(start_s: float, damping: FloatArray, end: int, lost: bool) -> bool:
    """A warning at `start_s` is false (see the head of this file)."""
    row = min(int(start_s * 100), end)
    if lost and row > end - 1500:
        return False
    return bool(damping[max(0, row - 100) : row + 1].min() > FALSE_DAMPING)


def delay_of(warnings: list[list[float]], onset_s: float, hertz: float) -> float | None:
    """Oscillations from the onset to the first moment with a warning; None: there is none."""
    after = [max(start, onset_s) for start, stop in warnings if stop > onset_s]
    return (min(after) - onset_s) * hertz if after else None


def summary(results: list[Result]) -> dict[str, Any]:
    """Figures of each detector."""
    detectors: dict[str, Any] = {}
    timed = [r for r in results if r.onset_s is not None]
    # A drive that ends within 2.5 oscillations of its onset does not count as missed.
    fair = [r for r in timed if (r.end_s - (r.onset_s or 0)) * r.frequency_hz >= 2.5]
    ordinary = [r for r in results if r.kind == "ordinary"]
    others = [r for r in results if r.kind in MANOEUVRES]
    for name in (OURS, *DETECTORS):
        delays = [r.delay_oscillations[name] for r in fair]
        got = np.array([d for d in delays if d is not None])
        hours = sum(r.hours for r in ordinary)
        detectors[name] = {
            "median_oscillations": float(np.median(got)) if len(got) else None,
            "p95_oscillations": float(np.percentile(got, 95)) if len(got) else None,
            "warned_before_onset": int(np.sum(got == 0)),
            "missed": sum(d is None for d in delays),
            "false_per_hour_ordinary": sum(len(r.false_s[name]) for r in ordinary)
            / max(hours, 1e-9),
            "false_ordinary": sum(len(r.false_s[name]) for r in ordinary),
            "false_in_stable_drives": sum(bool(r.false_s[name]) for r in others),
            "false_in_unstable_drives": sum(bool(r.false_s[name]) for r in timed),
            "false_by_manoeuvre": {
                kind: sum(bool(r.false_s[name]) for r in others if r.kind == kind)
                for kind in MANOEUVRES
            },
        }
    return {
        "unstable_drives": len(fair),
        "onset_too_late_in_drive": len(timed) - len(fair),
        "stable_drives": len(others),
        "manoeuvres": {kind: sum(r.kind == kind for r in others) for kind in MANOEUVRES},
        "lost_in_stable_drives": sum(r.lost for r in others),
        "ordinary_hours": sum(r.hours for r in ordinary),
        "detectors": detectors,
    }


def table(figures: dict[str, Any]) -> str:
    """The figures as text."""
    lines = [
        f"{figures['unstable_drives']} unstable and {figures['stable_drives']} stable drives, "
        f"{figures['ordinary_hours']:.0f} h of ordinary driving",
        f"{'':26}{'median':>8}{'95 %':>8}{'missed':>8}{'false/h':>9}{'false in stable':>17}",
    ]
    for name, row in figures["detectors"].items():
        median, p95 = row["median_oscillations"], row["p95_oscillations"]
        lines.append(
            f"{name:26}{'-' if median is None else f'{median:.2f}':>8}"
            f"{'-' if p95 is None else f'{p95:.2f}':>8}{row['missed']:>8}"
            f"{row['false_per_hour_ordinary']:>9.3f}{row['false_in_stable_drives']:>17}"
        )
    lines.append("median and 95 %: time from onset to warning in oscillations")
    return "\n".join(lines)


def markdown(figures: dict[str, Any], command: str, first_seed: int) -> str:
    """The figures as a table of README.md."""
    kinds = [f"{count} {kind}" for kind, count in figures["manoeuvres"].items()]
    lines = [
        f"**Warning campaign (`{command}`, seeds from {first_seed}): {figures['unstable_drives']} "
        f"drives that become unstable, {figures['stable_drives']} manoeuvres that do not, "
        f"{figures['ordinary_hours']:.0f} h of ordinary driving; no force sensors**",
        "",
        "| detector | median | 95 % | missed | false per hour | false before onset | "
        "false in slalom | lane change | gusts | rough road |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, row in figures["detectors"].items():
        median, p95 = row["median_oscillations"], row["p95_oscillations"]
        manoeuvres = " | ".join(str(count) for count in row["false_by_manoeuvre"].values())
        lines.append(
            f"| {name} | {'-' if median is None else f'{median:.2f}'} | "
            f"{'-' if p95 is None else f'{p95:.2f}'} | {row['missed']} | "
            f"{row['false_per_hour_ordinary']:.3f} | {row['false_in_unstable_drives']} | "
            f"{manoeuvres} |"
        )
    lines += [
        "",
        "Median and 95 %: oscillations from the onset to a warning. Onset: the first moment when "
        "the true damping ratio is negative, the steering wheel held still from then on, the swing "
        "3 deg/s or more. "
        "Missed: no warning from the onset to the end of the drive, which is 2.5 oscillations or "
        f"more ({figures['onset_too_late_in_drive']} shorter drives are not counted). False: a "
        "warning that starts after the true damping ratio was above 0.02 for 1 s, without loss of "
        "control within 15 s. Last columns: number of drives with a false warning, of "
        f"{', '.join(kinds)} (control is lost in "
        f"{figures['lost_in_stable_drives']} of them, by saturated tyres).",
    ]
    return "\n".join(lines) + "\n"


def jobs_of(drives: int, hours: float, first_seed: int) -> list[tuple[str, int, float]]:
    """Two thirds of the drives become unstable; ordinary driving comes in half-hours."""
    unstable = -(-2 * drives // 3)
    half_hours = math.ceil(hours * 2)
    return (
        [("unstable", first_seed + k, 0.0) for k in range(unstable)]
        + [("stable", first_seed + k, 0.0) for k in range(drives - unstable)]
        + [("ordinary", first_seed + k, 1800.0) for k in range(half_hours)]
    )


def campaign(
    drives: int,
    hours: float,
    first_seed: int = 1,
    workers: int = 1,
    done: Path | None = None,
) -> list[Result]:
    """Run everything; `workers` processes. Finished drives are kept in the file `done`."""
    jobs = jobs_of(drives, hours, first_seed)
    finished = {} if done is None else kept(done)
    missing = [job for job in jobs if key_of(*job) not in finished]
    with ExitStack() as stack:
        pool = stack.enter_context(ProcessPoolExecutor(workers)) if workers > 1 else None
        keep = None if done is None else stack.enter_context(done.open("a", encoding="utf-8"))
        each = (pool.map if pool else map)(run_job, missing)
        for job, result in zip(missing, each, strict=True):
            finished[key_of(*job)] = result
            if keep is not None:
                print(json.dumps([key_of(*job), asdict(result)]), file=keep, flush=True)
    return [finished[key_of(*job)] for job in jobs]


def run_job(job: tuple[str, int, float]) -> Result:
    """One of `jobs_of`."""
    return run(*job)


def key_of(kind: str, seed: int, seconds: float) -> str:
    """Name of a drive."""
    return f"{kind} {seed} {seconds:g}"


def kept(done: Path) -> dict[str, Result]:
    """Drives that an earlier call has finished with the same core and campaign."""
    sources = (Path(_core.__file__), *sorted(Path(__file__).parent.glob("warning_*.py")))
    state = sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()
    lines = done.read_text(encoding="utf-8").splitlines() if done.exists() else []
    if not lines or json.loads(lines[0]) != state:
        done.parent.mkdir(parents=True, exist_ok=True)
        done.write_text(json.dumps(state) + "\n", encoding="utf-8")
        return {}
    found: dict[str, Result] = {}
    for line in lines[1:]:
        key, content = json.loads(line)
        found[key] = Result(**content)
    return found


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=500)
    parser.add_argument("--hours", type=float, default=200)
    parser.add_argument("--seed", type=int, default=10001)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--output", type=Path, help="JSON of the figures and drives")
    parser.add_argument("--markdown", type=Path, help="table for README.md")
    parser.add_argument("--done", type=Path, help="finished drives: a stopped campaign goes on")
    arguments = parser.parse_args()
    started = time.monotonic()
    results = campaign(
        arguments.drives, arguments.hours, arguments.seed, arguments.workers, arguments.done
    )
    figures = summary(results)
    print(table(figures))
    print(f"{time.monotonic() - started:.0f} s")
    if arguments.markdown:
        arguments.markdown.parent.mkdir(parents=True, exist_ok=True)
        arguments.markdown.write_text(markdown(figures, "make bench-warning", arguments.seed))
    if arguments.output:
        arguments.output.parent.mkdir(parents=True, exist_ok=True)
        drives = [asdict(r) for r in results if r.onset_s is not None or any(r.false_s.values())]
        arguments.output.write_text(json.dumps({"figures": figures, "drives": drives}, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
