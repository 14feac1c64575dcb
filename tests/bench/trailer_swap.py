"""Is a swapped trailer noticed? Drives of one car with two trailers, through the daemon.

Part of ``make bench-car``. Each pair is one car and two trailers (`tests/host/drawn_drives.py`):
what an ECU goes through is replayed by ``swaywatchd --replay --remember FILE``, with nothing of a
trailer in its ``vehicle.toml``: a drive with the first one, then, each with a copy of the file
which that drive left, one with the second, one with the first again and one without any. Plant:
``swaywatch simulate``, bodies on springs, tyres that saturate and relax; sensors: preset
``production``, with offsets of their own in each drive.
"""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "host"))

from drawn_drives import believed, draw_body, vehicle_of

from swaywatch.ecu.bus import database, encode_drive
from swaywatch.ecu.remembered import MESSAGE, heard
from swaywatch.errors import ScenarioError
from swaywatch.models.single_track import SingleTrack
from swaywatch.recording import write_recording
from swaywatch.simulate import simulate_scenario
from swaywatch.simulate.scenario import read_scenario
from swaywatch.validate.correct import as_toml
from swaywatch.vehicle import Car, Vehicle

ROOT = Path(__file__).resolve().parents[2]
DAEMON = ROOT / "build" / "swaywatchd"
SWAY_TRAILER = database().messages[MESSAGE].frame_id
FIRST_SEED = 20_001
LEAST_LIMIT_KMH = 100.0
"""Critical speed that every combination has at the least: its driver goes 85 km/h."""
SWAYING_KMH = 180.0
"""Critical speed of a combination that sways, as caravans do, at the most."""
SPEEDS_KMH = (60.0, 72.0, 85.0)
LASTS_S = 60.0
"""At each of the speeds."""
OFFSETS = {
    "steering_wheel_angle": math.radians(1.0),
    "car_yaw_rate": math.radians(0.3),
    "car_lateral_acceleration": 0.1,
}
"""Standard deviations of the offsets of preset ``production``, rad, rad/s, m/s2."""
ANSWERS = ("unknown", "no trailer", "new", "same", "another")


@dataclass(frozen=True)
class Answer:
    """What the daemon said at the end of a drive.

    Attributes
    ----------
    state, likeness
        TrailerState in words, TrailerLikeness of the last SwayTrailer.
    states
        Every state of the drive, in order.
    learnt_s
        Of that frame too.
    writes
        Of the file, that at the end included.
    """

    state: str
    likeness: float
    states: tuple[str, ...]
    learnt_s: int
    writes: int


@dataclass(frozen=True)
class Pair:
    """One car and two trailers; the answers to the four drives."""

    seed: int
    limits_kmh: tuple[float, float]
    first: Answer
    other: Answer
    same: Answer
    alone: Answer


def with_loads_of_statics(vehicle: Vehicle) -> Vehicle:
    """Axle loads from masses and lengths, whatever trailer is on the ball."""
    trailer = vehicle.trailer
    return replace(
        vehicle,
        car=replace(vehicle.car, front_axle_load=None, rear_axle_load=None),
        trailer=trailer and replace(trailer, front_axle_load=None, rear_axle_load=None),
    )


def drawn_pair(seed: int, most_kmh: float) -> tuple[Vehicle, Vehicle, Vehicle]:
    """The car with the first trailer, with the other one, and what its user writes of it."""
    rng = np.random.default_rng((20261124, seed))

    def drawn(car: Car | None) -> tuple[Any, Vehicle]:
        for _ in range(10_000):
            body = draw_body(rng)
            vehicle = with_loads_of_statics(vehicle_of(body))
            vehicle = replace(vehicle, car=car or vehicle.car)
            if LEAST_LIMIT_KMH < limit_kmh(vehicle) < most_kmh:
                return body, vehicle
        raise RuntimeError("no such combination")

    body, first = drawn(None)
    user = replace(with_loads_of_statics(believed(body, rng)), trailer=None)
    return first, drawn(first.car)[1], user


def limit_kmh(vehicle: Vehicle) -> float:
    """Critical speed of the linear single track; infinite if there is none."""
    return 3.6 * SingleTrack.of(vehicle).critical_speed()


def scenario_of(seed: int) -> dict[str, Any]:
    """Three minutes at three speeds: nine swerves, gusts, sensors of a production car."""
    rng = np.random.default_rng((7, seed))
    manoeuvres: list[dict[str, Any]] = []
    for number, speed in enumerate(SPEEDS_KMH):
        begin = number * LASTS_S
        if number:
            manoeuvres.append({"kind": "accelerate", "start_s": begin, "speed_kmh": speed})
        for k in range(3):
            manoeuvres.append({
                "kind": "lane_change", "start_s": begin + 8.0 + 17.0 * k + float(rng.uniform(0, 8)),
                "angle_deg": float(rng.choice([-1, 1]) * rng.uniform(12, 28)),
                "frequency_hz": float(rng.uniform(0.25, 0.5)),
            })  # fmt: skip
        for body, force in (("trailer", 400.0), ("trailer", 400.0), ("car", 150.0)):
            manoeuvres.append({
                "kind": "gust", "start_s": begin + float(rng.uniform(1, LASTS_S - 6)),
                "duration_s": float(rng.uniform(1, 4)), "body": body, "rise_s": 0.4,
                "force_n": float(np.clip(rng.normal(0, force), -2 * force, 2 * force)),
            })  # fmt: skip
    sensors: dict[str, Any] = {
        name: {"bias": float(rng.normal(0, spread))} for name, spread in OFFSETS.items()
    }
    return {
        "vehicle": "unused", "duration_s": len(SPEEDS_KMH) * LASTS_S,
        "speed_kmh": SPEEDS_KMH[0], "manoeuvre": manoeuvres, "sprung": {},
        "physics": [
            {"id": "tyre_saturation", "axle": "all"},
            {"id": "tyre_relaxation", "axle": "all", "length_m": float(rng.uniform(0.2, 0.6))},
        ],
        "sensors": {"preset": "production", **sensors},
    }  # fmt: skip


def write_log(vehicle: Vehicle, seed: int, path: Path) -> None:
    """Simulate drive number `seed` of a combination (or of the car alone) as a candump log."""
    content = scenario_of(seed)
    if vehicle.trailer is None:
        gust = [m for m in content["manoeuvre"] if m.get("body") == "trailer"]
        content["manoeuvre"] = [m for m in content["manoeuvre"] if m not in gust]
    drive, _ = simulate_scenario(read_scenario(content, "swap", ROOT, "swap", seed, vehicle))
    if drive.duration_s < content["duration_s"] - 1.0:
        raise ScenarioError(f"drive {seed}: control is lost after {drive.duration_s:.0f} s")
    write_recording(path, encode_drive(drive))


def replayed(vehicle: Path, rear_axle_m: float, log: Path, file: Path) -> Answer:
    """The daemon over a log with --remember FILE; its frames go beside the log."""
    done = subprocess.run(
        [DAEMON, "--vehicle", vehicle, "--set", f"car.lateral_acceleration_position={-rear_axle_m}",
         "--remember", file, "--replay", log],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    log.with_suffix(".status.log").write_text(done.stdout)
    pattern = re.compile(rf" {SWAY_TRAILER:03X}#([0-9A-F]{{16}})")
    frames = [heard(SWAY_TRAILER, False, bytes.fromhex(d)) for d in pattern.findall(done.stdout)]
    said = [frame for frame in frames if frame is not None]
    states = [frame.state for frame in said]
    return Answer(
        said[-1].state, said[-1].likeness,
        tuple(s for k, s in enumerate(states) if k == 0 or s != states[k - 1]),
        said[-1].learnt_s, int(re.findall(r"(\d+) written", done.stderr)[-1]),
    )  # fmt: skip


def pair(seed: int, most_kmh: float, folder: Path) -> Pair:
    """The four drives of a pair."""
    first, other, user = drawn_pair(seed, most_kmh)
    toml = folder / "vehicle.toml"
    toml.write_text(as_toml(user, user, "what the user knows: the car"))
    kept, copy, log = folder / "trailer.bin", folder / "copy.bin", folder / "drive.log"
    kept.unlink(missing_ok=True)

    def drive(vehicle: Vehicle, number: int, file: Path) -> Answer:
        write_log(vehicle, 10 * seed + number, log)
        return replayed(toml, user.car.rear_axle_to_cog, log, file)

    answers = [drive(first, 0, kept)]
    for number, vehicle in enumerate((other, first, replace(first, trailer=None)), 1):
        copy.unlink(missing_ok=True)
        if kept.exists():
            shutil.copy(kept, copy)
        answers.append(drive(vehicle, number, copy))
    return Pair(seed, (limit_kmh(first), limit_kmh(other)), *answers)


def pairs(count: int, most_kmh: float, first_seed: int = FIRST_SEED) -> list[Pair]:
    """Pairs from `first_seed` on whose critical speeds are below `most_kmh`."""
    result = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first_seed, first_seed + count):
            result.append(pair(seed, most_kmh, Path(folder)))
            print(result[-1], file=sys.stderr, flush=True)
    return result


def counted(found: Sequence[Pair]) -> dict[str, dict[str, int]]:
    """For each kind of drive how often each answer came."""
    return {
        name: {word: [getattr(p, name).state for p in found].count(word) for word in ANSWERS}
        for name in ("first", "other", "same", "alone")
    }
