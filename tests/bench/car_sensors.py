"""What the car's own sensors are worth: recordings, ordinary drives, warnings.

Parts of ``make bench-car`` (`car_shown.py` makes the table). Recordings: practice and road;
steering, speed, yaw rate and lateral acceleration only (and with the car's wheel forces, which are
fed but not used by the trailer's observer), the trailer known as the user knows it, by mass and
length, or not at all. Drives: the independent plant of the warning campaign, 100 s at each of three
speeds, sensors of a production car. Warnings: drives of that campaign with its full set of sensors
and with the car's own at production grade.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import warning_campaign as wc
import warning_plant as plant

from swaywatch.analysis import usable, weighted_mean
from swaywatch.drive import Drive, load_drives
from swaywatch.ecu.core import PRESENCE, VALID, Core, Estimates, columns_of, positions_of
from swaywatch.trailer import INTERVAL, OWN_CHANNELS, chained, identify
from swaywatch.vehicle import UNKNOWNS, Trailer, Vehicle
from swaywatch.vehicle_file import (
    TYPICAL_AXLE_M,
    TYPICAL_GYRATION,
    TYPICAL_LENGTH_M,
    TYPICAL_MASS_SHARE,
    load_vehicle,
)

FloatArray = npt.NDArray[np.float64]
FIRST_SEED = 20_001
FORCES = tuple(f"wheel_lateral_force_{wheel}" for wheel in ("fl", "fr", "rl", "rr"))

PRODUCTION = {
    "steering_wheel_angle": (math.radians(0.05), math.radians(0.1), math.radians(1.0)),
    "speed": (0.03, 0.02, 0.1),
    "car_yaw_rate": (math.radians(0.15), math.radians(0.1), math.radians(0.3)),
    "car_lateral_acceleration": (0.06, 0.05, 0.1),
}
"""Noise, step, standard deviation of the offset: as preset ``production`` of the simulator."""


def known(vehicle: Vehicle, how: str) -> Vehicle:
    """The vehicle as somebody knows it: all, mass and length, or nothing of the trailer.

    "attached": that there is one, an empty ``[trailer]``.
    """
    trailer = vehicle.trailer
    if how == "all" or trailer is None:
        return vehicle
    if how == "nothing":
        return dataclasses.replace(vehicle, trailer=None)
    if how == "attached":
        mass = TYPICAL_MASS_SHARE * vehicle.car.mass
        return dataclasses.replace(
            vehicle,
            trailer=Trailer(
                mass=mass, hitch_to_cog=TYPICAL_LENGTH_M, rear_axle_to_cog=TYPICAL_AXLE_M,
                yaw_inertia=TYPICAL_GYRATION * mass * TYPICAL_LENGTH_M**2, assumed=UNKNOWNS,
            ),
        )  # fmt: skip
    front, rear = trailer.front_axle_to_cog, trailer.rear_axle_to_cog
    axle = trailer.hitch_to_cog + (rear if front is None else 0.5 * (rear - front))
    return dataclasses.replace(
        vehicle,
        trailer=dataclasses.replace(
            trailer, front_axle_to_cog=None, front_cornering_stiffness=None,
            rear_cornering_stiffness=None, front_axle_load=None, rear_axle_load=None,
            hitch_to_cog=axle - 0.18, rear_axle_to_cog=0.18,
            yaw_inertia=0.22 * trailer.mass * (axle - 0.18) ** 2,
            assumed=("yaw_inertia", "stiffness", "axle"),
        ),
    )  # fmt: skip


def only(drive: Drive, names: Sequence[str]) -> Drive:
    """The drive with these channels alone."""
    kept = {name: c for name, c in drive.channels.items() if name in names}
    return dataclasses.replace(drive, channels=kept)


def free_line(drive: Drive, vehicle: Vehicle) -> dict[str, Any]:
    """Mean frequency and damping ratio of the free oscillation of a drive."""
    core = Core(vehicle, positions_of(drive))
    status, inputs = core.feed(drive)
    estimates = Estimates(status, {}, inputs, core.trailer(), columns_of(status))
    good = usable(estimates) & ~estimates.flagged("forced")
    return {
        name: weighted_mean(estimates, name, error, good)
        for name, error in (("frequency_hz", "frequency_se_hz"),
                            ("damping_ratio", "damping_ratio_se"))
    }  # fmt: skip


def limit(drives: Sequence[Drive], vehicle: Vehicle) -> dict[str, Any]:
    """Critical speed by the car's own sensors over some drives, and what hangs on the ball."""
    whole = chained(drives)
    core = Core(vehicle, positions_of(whole))
    status, _ = core.feed(whole)
    report = core.trailer()
    last = status[-1]
    has = bool(last["valid"] & VALID["critical_speed"])
    return {
        "v_crit": float(last["v_crit_mm_s"]) * 3.6e-3 if has else None,
        "se": float(last["v_crit_se_mm_s"]) * 3.6e-3,
        "presence": PRESENCE[report["presence"]],
        "learnt_s": report["learnt_ms"] / 1e3,
    }


def one_recording(folder: Path) -> dict[str, Any]:
    """Every figure of one case."""
    truth = json.loads((folder / "truth.json").read_text())
    vehicle = load_vehicle(folder / "vehicle.toml")
    files = sorted(folder.glob("run*.*"))[::-1]
    drives = [load_drives([f], folder / "signals.toml")[0] for f in files]
    result: dict[str, Any] = {"case": folder.name, "v_crit": truth["plant_vcrit_kmh"]}
    for how in ("all", "mass and length", "nothing"):
        result[how] = limit([only(d, OWN_CHANNELS) for d in drives], known(vehicle, how))
    if all(name in drives[0].channels for name in FORCES):
        card = [only(d, (*OWN_CHANNELS, *FORCES)) for d in drives]
        result["card"] = limit(card, vehicle)
    impulses = drives[-1]
    result["own"] = free_line(only(impulses, OWN_CHANNELS), vehicle)
    result["full"] = free_line(impulses, vehicle)
    return result


def recordings(root: Path) -> dict[str, Any]:
    """All cases of practice and road."""
    folders = [*sorted((root / "practice").glob("p*")), *sorted((root / "road").glob("r*"))]
    cases = [one_recording(folder) for folder in folders]
    figures: dict[str, Any] = {"cases": len(cases)}
    for how in ("all", "mass and length", "nothing", "card"):
        found = [(c[how], c["v_crit"]) for c in cases if how in c and c[how]["v_crit"]]
        error = np.array([100 * (f["v_crit"] / true - 1) for f, true in found])
        z = np.array([(f["v_crit"] - true) / f["se"] for f, true in found])
        figures[how] = {
            "reported": len(found), "median_error_percent": float(np.median(np.abs(error))),
            "bias_percent": float(np.median(error)),
            "largest_percent": float(np.abs(error).max()),
            "in_90_percent_interval": float(np.mean(np.abs(z) < INTERVAL)),
            "there": sum(f["presence"] == "there" for f, _ in found),
        }  # fmt: skip
    for name in ("frequency_hz", "damping_ratio"):
        pairs = [(c["own"][name], c["full"][name]) for c in cases]
        both = [(o, f) for o, f in pairs if o is not None and f is not None]
        figures[name] = {
            "cases": len(both),
            "own_minus_full_median": float(np.median([abs(o.value - f.value) for o, f in both])),
            "error_ratio_median": float(np.median([o.error / f.error for o, f in both])),
            "inside_95": float(np.mean([
                abs(o.value - f.value) < 1.96 * math.hypot(o.error, f.error) for o, f in both
            ])),
        }  # fmt: skip
    figures["table"] = [
        {"case": c["case"], "true": c["v_crit"],
         **{how: (c[how]["v_crit"], c[how]["se"]) for how in
            ("all", "mass and length", "nothing", "card") if how in c}}
        for c in cases if c["case"] in ("p01", "p03", "p05", "p08")
    ]  # fmt: skip
    return figures


def solo(folder: Path, roles: Path) -> dict[str, str]:
    """What is said of each real run of a car without a trailer, with its certainty."""
    vehicle = load_vehicle(folder / "vehicle.toml")
    result = {}
    for file in sorted(folder.glob("*.mf4")):
        found = identify(load_drives([file], roles), vehicle)
        claims = found.quantities or found.critical_speed_m_s is not None
        more = " and more" if found.presence == "none" and claims else ""
        result[file.stem] = f"{found.presence}{more}, {100 * found.certainty:.1f} %"
    return result


def measured(motion: plant.Motion, rng: np.random.Generator) -> Any:
    """The car's own sensors at production grade, 50 Hz."""
    keep = plant.SENSORS
    try:
        plant.SENSORS = PRODUCTION
        samples = plant.measure(motion, rng)
    finally:
        plant.SENSORS = keep
    return {name: (time[::2], value[::2]) for name, (time, value) in samples.items()}


def without_trailer(c: plant.Combination) -> plant.Combination:
    """The same car with next to nothing on its ball."""
    return dataclasses.replace(
        c, m2=1.0, i2=0.1, stiffness=(*c.stiffness[:2], 500.0, 500.0), lf2=0.3, lr2=0.3, lh2=2.0
    )


def driven(
    c: plant.Combination,
    rng: np.random.Generator,
    kmh: float,
    seconds: float,
    *,
    alone: bool,
    swerves: int,
) -> plant.Motion | None:
    """Ordinary driving with some swerves; None where the driver loses it."""
    _, course = wc._ordinary(rng, seconds)
    course.speed[:] *= kmh / 3.6 / course.speed.mean()
    for start in rng.uniform(4, seconds - 8, swerves):
        angle = math.radians(rng.uniform(10, 30)) * rng.choice([-1, 1])
        course.wheel += plant.full_sine(course.time_s, start, rng.uniform(1.5, 4), angle)
    if alone:
        course.side[:, 1] = 0.0  # no trailer, no wind on it
    motion = plant.simulate(c, course)
    return motion if wc.end_of(motion) == len(motion.time_s) - 1 else None


def one_drive(
    seed: int,
    *,
    alone: bool,
    seconds: float,
    speeds: Sequence[float],
    swerves: int = 0,
    how: str = "nothing",
) -> Any:
    """Driving at some speeds, with the trailer `known` like this."""
    for attempt in range(100):  # a driver who loses it is replaced by another
        rng = np.random.default_rng([seed, 77, attempt])
        c = wc._stable_combination(rng, max(speeds) / 3.6, 0.05)
        if alone:
            c = without_trailer(c)
        vehicle = wc.believed(c, rng)
        motions = [driven(c, rng, kmh, seconds, alone=alone, swerves=swerves) for kmh in speeds]
        drives = [wc.as_drive(measured(m, rng), c) for m in motions if m is not None]
        if len(drives) == len(speeds):
            break
    return limit(drives, known(vehicle, how)), plant.critical_speed(c) * 3.6


def ordinary(count: int, how: str) -> dict[str, Any]:
    """Five minutes at three speeds: error of the critical speed, held intervals."""
    found = [one_drive(FIRST_SEED + seed, alone=False, seconds=100.0, speeds=(70, 85, 100), how=how)
             for seed in range(count)]  # fmt: skip
    reported = [(f, true) for f, true in found if f["v_crit"] and f["v_crit"] < 249 and true < 250]
    if not reported:
        return {"drives": count, "reported": 0}
    error = np.array([100 * (f["v_crit"] / true - 1) for f, true in reported])
    z = np.array([(f["v_crit"] - true) / f["se"] for f, true in reported])
    return {
        "drives": count, "reported": len(reported),
        "median_error_percent": float(np.median(np.abs(error))),
        "bias_percent": float(np.median(error)),
        "in_90_percent_interval": float(np.mean(np.abs(z) < INTERVAL)),
    }  # fmt: skip


def presence(count: int, swerves: int) -> dict[str, Any]:
    """A minute of driving with some swerves: trailer or none."""
    result: dict[str, Any] = {"drives_of_each": count, "swerves": swerves}
    for alone in (False, True):
        found = [
            one_drive(FIRST_SEED + seed, alone=alone, seconds=60.0, speeds=(85,), swerves=swerves)[
                0
            ]
            for seed in range(count)
        ]
        words = [f["presence"] for f in found]
        result["alone" if alone else "with a trailer"] = {
            word: words.count(word) for word in ("there", "none", "undecided")
        }
    return result


def warnings(drives: int, hours: float) -> dict[str, Any]:
    """The campaign with all sensors and with the car's own at production grade."""
    jobs = wc.jobs_of(drives, hours, 30_001)
    full_set, as_drive, detectors = plant.measure, wc.as_drive, wc.DETECTORS
    result = {}
    for name in ("all sensors", "own"):
        wc.DETECTORS = {}
        if name == "own":
            plant.measure = lambda motion, rng: {  # the others' columns are not looked at
                **full_set(motion, rng),
                **full_set_own(motion, rng, full_set),
            }
            wc.as_drive = lambda samples, c: only(as_drive(samples, c), OWN_CHANNELS)
        results = [wc.run(*job) for job in jobs]
        unstable = [r for r in results if r.onset_s is not None]
        delays = [r.delay_oscillations[wc.OURS] for r in unstable]
        seen = [d for d in delays if d is not None]
        result[name] = {
            "unstable": len(unstable), "missed": len(delays) - len(seen),
            "median": float(np.median(seen)), "95 %": float(np.percentile(seen, 95)),
            "false": sum(len(r.false_s[wc.OURS]) for r in results),
            "hours": sum(r.hours for r in results),
        }  # fmt: skip
    plant.measure, wc.as_drive, wc.DETECTORS = full_set, as_drive, detectors
    return result


def full_set_own(motion: plant.Motion, rng: np.random.Generator, measure: Any) -> Any:
    """The car's own channels at production grade, 100 Hz."""
    keep = plant.SENSORS
    plant.SENSORS = PRODUCTION
    try:
        return measure(motion, rng)
    finally:
        plant.SENSORS = keep
