"""Make cases whose concealed cause is known, on the rigid-body plant.

``python generate.py --seed S --count N --out DIR --answers DIR`` writes DIR/b001.. like the
practice recordings, and their answers and held-out runs to another directory, which only
``score.py`` reads. The same seed gives the same signals.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import multiprocessing
import shutil
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import beside
import drives
import effects
import knowledge
import numpy as np
import recorder
import unlisted
from effects import Draw
from knowledge import Knowledge
from numpy.random import Generator
from numpy.typing import NDArray

from swaywatch.models import multibody
from swaywatch.models.multibody import Motion, Multibody
from swaywatch.models.multibody_vehicle import GRAVITY, Combination, Inputs, Physics
from swaywatch.recording import write_recording

Array = NDArray[np.float64]
Json = dict[str, Any]
Plants = tuple[Multibody, Multibody]
SUFFIXES = (".blf", ".mf4", ".asc", ".log")
KINDS = ("clean", "planar", "simulation", "clean_simulation", "pair", "outside", "fault")
SHARES = (0.12, 0.48, 0.18, 0.04, 0.09, 0.05, 0.04)
FASTEST_M_S = 37.0
NOT_OF_THE_CASES = (
    "score.py", "beside_score.py", "unlisted_score.py", "diagnose_all.py", "calibrate.py",
    "table.py", "information.py", "as_plant.py", "explanations.py", "own_limits.py",
    "beside_limits.py", "case_limits.py",
)  # fmt: skip


@dataclass
class Case:
    """One case before it is driven."""

    kind: str
    draws: list[Draw]
    healthy: Combination
    base: Physics
    known: Knowledge
    always: dict[str, dict[str, Any]] = field(default_factory=dict)
    hidden: tuple[str, ...] = ()
    noise_factor: float = 1.0
    seeds: dict[str, Any] = field(default_factory=dict)
    suffix: str = ".blf"

    @property
    def simulated(self) -> bool:
        """The user gives a simulation of their own."""
        return "simulation" in self.kind

    def sensors(self) -> dict[str, dict[str, Any]]:
        """Sensor faults of all effects, by signal."""
        out = {name: dict(fault) for name, fault in self.always.items()}
        for draw in self.draws:
            for signal, fault in draw.sensors.items():
                out[signal] = out.get(signal, {}) | fault
        return out

    def plant(self, *, healthy: bool = False) -> Multibody:
        """The plant with the effects, or without: then as the user believes it to be."""
        whole, physics = self.healthy, self.base
        if healthy:
            for draw in self.draws:
                whole = drives.believed(whole, draw.user)
        for draw in [] if healthy else self.draws:
            whole, physics = draw.combination(whole), draw.physics(physics)
        return Multibody(whole, physics)

    def inputs(self, run: str, mean_m_s: float, size_deg: float, *, healthy: bool) -> Inputs:
        """Inputs of a run, with what the effects put in."""
        length = self.known.lengths_s[run]
        time = drives.times(length)
        extra: dict[str, Any] = {}
        for draw in [] if healthy else self.draws:
            extra |= draw.inputs(run, time)
        return Inputs(
            time,
            drives.steering(run, length, size_deg, self.seeds["steer"] + int(run[3])),
            drives.speed(length, mean_m_s, self.seeds["speed"] + int(run[3])),
            **extra,
        )


def full_physics() -> Physics:
    """The healthy plant with moving bodies: saturating tyres, air drag."""
    return Physics(
        full=True, tyre_law="magic_formula", peak_friction=1.15, load_degression=0.05,
        drag_area_m2=(0.7, 2.2),
    )  # fmt: skip


#: What tier F has in any case: it is not what is concealed there.
ALWAYS_THERE = (
    effects.tyre_relaxation, effects.tyre_saturation, effects.tyre_load_sensitivity,
    effects.sensor_roll_gravity,
)  # fmt: skip


def road_physics(rng: Generator) -> Physics:
    """Bodies on springs, tyres that saturate, relax and are sensitive to load."""
    front, rear = map(float, rng.uniform(0.15, 0.35, 2))
    return Physics(
        full=True, tyre_law="magic_formula", peak_friction=float(rng.uniform(0.95, 1.15)),
        load_degression=float(rng.uniform(0.03, 0.08)), relaxation_m=(front, front, rear, rear),
        drag_area_m2=(0.7, 2.0),
    )  # fmt: skip


def draw_kind(
    rng: Generator, index: int, only: str | None = None
) -> tuple[str, list[Draw], Knowledge]:
    """Kind of the case, its effects, what is known; strengths are spread evenly.

    `only`: a tier, in which nothing is concealed; a set of the unlisted kinds; or one `beside`.
    """
    kind = str(rng.choice(KINDS, p=SHARES))
    strength = float(rng.uniform(0.0, 1.0))
    if only is not None:
        return _only(rng, index, only)
    known = knowledge.draw(rng, tier="A" if "simulation" in kind else None)

    def make(function: Any, u: float) -> Draw:
        draw: Draw = function(rng, u)
        draw.strength = u
        return draw

    def open_to(functions: tuple[Any, ...]) -> list[Any]:
        return [f for f in functions if not (known.sprung and f in ALWAYS_THERE)]

    draws = []
    if kind == "planar":
        among = open_to(effects.PLANAR)
        draws = [make(among[index % len(among)], strength)]
    elif kind == "simulation":
        draws = [make(rng.choice(np.array(effects.WITH_SIMULATION)), strength)]
    elif kind == "pair":
        first, second = rng.choice(np.array(open_to(effects.PAIRS)), 2, replace=False)
        draws = [make(f, float(rng.uniform(0.45, 1.0))) for f in (first, second)]
    elif kind == "outside":
        draws = [make(rng.choice(np.array(effects.OUTSIDE)), strength)]
    elif kind == "fault":
        draws = [make(effects.outside_sensor, strength)]
    if any(draw.windows for draw in draws) or "simulation" in kind:
        known = replace(known, lengths_s=knowledge.USUAL_S)
    return kind, draws, known


def _only(rng: Generator, index: int, only: str) -> tuple[str, list[Draw], Knowledge]:
    if only in unlisted.SETS:
        return "unlisted", [unlisted.draw(only, rng, index)], knowledge.draw(rng, tier="A")
    if only in beside.SETS:
        known = knowledge.draw(rng, tier="A")
        known = replace(known, lengths_s=knowledge.USUAL_S)
        return f"{only}_simulation", beside.draw(only, rng, index), known
    return "clean", [], knowledge.draw(rng, tier=only)


def draw_hidden(rng: Generator, draws: list[Draw], known: Knowledge) -> tuple[str, ...]:
    """What the tier lacks, now and then another channel; never one that is faulty itself."""
    groups = (("FzFL", "FzFR", "FzRL", "FzRR"), ("HitchFx", "HitchFy"), ("LatAcc2",))
    hidden = known.hidden
    if not hidden and rng.random() < 0.15:
        hidden = groups[int(rng.integers(len(groups)))]
    used = {name for draw in draws for name in draw.sensors}
    return () if used & set(hidden) else hidden


def draw_case(seed: int, index: int, only: str | None = None) -> Case:
    """Case number `index` of a seed."""
    rng = np.random.default_rng((seed, index))
    kind, draws, known = draw_kind(rng, index, only)
    base, always = Physics(), {}
    if "simulation" in kind:
        whole, base = drives.with_suspension(drives.draw_combination(rng)), full_physics()
    else:
        whole = knowledge.draw_combination(rng)
    if known.sprung:
        whole, base = knowledge.on_springs(whole), road_physics(rng)
        sees = float(rng.random() < 0.5)
        always = {name: {"roll_gravity": sees} for name in ("LatAccRear1", "LatAcc2") if sees}
    return Case(
        kind,
        draws,
        whole,
        base,
        known,
        always,
        hidden=draw_hidden(rng, draws, known),
        noise_factor=float(rng.uniform(0.8, 1.3)),
        suffix=SUFFIXES[index % len(SUFFIXES)],
        seeds={name: int(rng.integers(2**31)) for name in ("steer", "speed", "noise")},
    )


def bus_signals(motion: Motion, case: Case, run: str, *, healthy: bool) -> dict[str, Array]:
    """Signals as the sensors would read them without noise, units of the bus."""
    degrees = 180.0 / np.pi
    steer = motion.steering_wheel_rad * degrees
    out = {
        "SteeringWheelAngle": steer,
        "SteeringWheelRate": np.gradient(steer, motion.time_s),
        "VehicleSpeed": motion.speed_m_s * 3.6,
        "YawRate1": motion.yaw_rate_rad_s * degrees,
        "LatAccRear1": motion.rear_acceleration_m_s2.copy(),
        "YawRate2": motion.trailer_yaw_rate_rad_s * degrees,
        "LatAcc2": motion.trailer_acceleration_m_s2.copy(),
        "HitchFx": motion.hitch_x_n,
        "HitchFy": motion.hitch_y_n,
    }
    names = ("FL", "FR", "RL", "RR", "T1L", "T1R", "T2L", "T2R")
    for i, name in enumerate(names if case.simulated else names[:4]):
        out[f"Fy{name}"], out[f"Fz{name}"] = motion.wheel_fy_n[i], motion.wheel_fz_n[i]
    if case.simulated:
        out["HitchFz"] = motion.hitch_z_n
    _tilt(out, motion, case.always)
    if healthy:
        return out
    time = drives.times(case.known.lengths_s[run])
    for draw in case.draws:
        _tilt(out, motion, draw.sensors)
        for name, fault in draw.sensors.items():
            if "bank" in fault:
                bank = np.interp(motion.time_s, time, draw.inputs(run, time)["bank_rad"])
                out[name] = out[name] + GRAVITY * np.sin(bank)
    return out


def _tilt(out: dict[str, Array], motion: Motion, sensors: dict[str, dict[str, Any]]) -> None:
    """Gravity in accelerometers that roll with their body."""
    for name, fault in sensors.items():
        if "roll_gravity" in fault:
            roll = motion.roll_rad if name == "LatAccRear1" else motion.trailer_roll_rad
            out[name] = out[name] + GRAVITY * np.sin(fault["roll_gravity"] * roll)


def _peak(motion: Motion) -> float:
    return float(
        max(
            np.abs(motion.trailer_acceleration_m_s2).max(),
            np.abs(motion.car_acceleration_m_s2).max(),
        )
    )


def critical_speed(plant: Multibody) -> float:
    """Speed at which an impulse's sway keeps about four fifths of its size over ten seconds, m/s.

    As a test driver would find it: by going a little faster each time.
    """
    low, high = 18.0, 45.0
    time = np.arange(0.0, 18.0, 0.01)
    wheel = np.radians(13.0) * np.where(
        (time > 0.5) & (time < 1.24), np.sin(np.pi * (time - 0.5) / 0.74), 0.0
    )
    for _ in range(8):
        speed = 0.5 * (low + high)
        try:
            motion = plant.run(Inputs(time, wheel, np.full_like(time, speed)))
            rate = np.abs(motion.trailer_yaw_rate_rad_s)
            early = rate[(motion.time_s > 2.5) & (motion.time_s < 5.0)].max()
            late = rate[(motion.time_s > 15.0) & (motion.time_s < 17.5)].max()
            steady = late < 0.8 * early and _peak(motion) < 6.0
        except FloatingPointError:
            steady = False
        low, high = (speed, high) if steady else (low, speed)
    return low


def drive(case: Case, plant: Multibody, run: str, mean_m_s: float, *, healthy: bool) -> Motion:
    """A run with the steering turned down until the lateral acceleration is a road test's."""
    size = {"run1": 15.0, "run2": 12.5, "run3": 15.0}[run]
    size = case.seeds.get(f"size_{run}", size)
    most = 3.4 if case.simulated else 4.3
    for _ in range(5):
        motion = plant.run(case.inputs(run, mean_m_s, size, healthy=healthy))
        if healthy or _peak(motion) < most:
            break
        size *= max(0.5, 0.9 * most / _peak(motion))
    case.seeds[f"size_{run}"] = size
    return motion


def harmonic_truth(motion: Motion, case: Case, draw: Draw, run: str) -> list[dict[str, float]]:
    """Frequency, amplitude and phase to the squared axle force, in each window."""
    wheels = effects.WHEEL_NUMBERS[draw.answer["axle"]]
    force = motion.wheel_fy_n[list(wheels)].sum(axis=0)
    load = motion.harmonic_n if not case.simulated else motion.wheel_fz_n[list(wheels)].sum(axis=0)
    out = []
    for start, end in draw.windows[run]:
        hit = (motion.time_s >= start + 0.2) & (motion.time_s <= end - 0.2)
        t = motion.time_s[hit]
        squared = force[hit] ** 2 - np.mean(force[hit] ** 2)
        spectrum = np.abs(np.fft.rfft(squared * np.hanning(t.size), 1 << 15))
        double = float(np.argmax(spectrum) / ((1 << 15) * (t[1] - t[0])))
        basis = np.stack([np.cos(2 * np.pi * double * t), np.sin(2 * np.pi * double * t),
                          np.ones_like(t), t - t.mean()])  # fmt: skip
        a, *_ = np.linalg.lstsq(basis.T, load[hit], rcond=None)
        b, *_ = np.linalg.lstsq(basis.T, force[hit] ** 2, rcond=None)
        phase = np.angle((a[0] - 1j * a[1]) / (b[0] - 1j * b[1]), deg=True)
        out.append(
            {
                "frequency_hz": round(double / 2, 4),
                "amplitude_n": round(float(np.hypot(a[0], a[1])), 1),
                "phase_deg": round(float(phase), 1),
            }
        )
    return out


def sensed(truth: dict[str, Array], time: Array, sensors: dict[str, Any]) -> dict[str, Array]:
    """Signals with the delay and gain of faulty sensors."""
    out = dict(truth)
    for name, fault in sensors.items():
        if name in out:
            late = np.interp(time - fault.get("delay", 0.0), time, out[name])
            out[name] = late * fault.get("gain", 1.0)
    return out


def visibility(changed: dict[str, Array], healthy: dict[str, Array], factor: float) -> float:
    """Largest rms change of a signal in units of its noise."""
    ratios = [
        np.sqrt(np.mean((changed[name] - healthy[name]) ** 2)) / (recorder.NOISE_RMS[name] * factor)
        for name in changed
        if recorder.NOISE_RMS[name] > 0 and name not in ("SteeringWheelRate", "VehicleSpeed")
    ]
    return float(max(ratios))


def generator_digest() -> str:
    """Digest of everything that a case depends on but its seed."""
    digest = hashlib.sha256()
    plant = Path(multibody.__file__).parent.glob("multibody*.py")
    for path in sorted([*Path(__file__).parent.glob("*.py"), *plant]):
        if path.name not in NOT_OF_THE_CASES:
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _answer(case: Case, name: str, truths: dict[str, Any]) -> dict[str, Any]:
    return {
        "case": name,
        "generator": generator_digest(),
        "kind": case.kind,
        "effects": [draw.answer for draw in case.draws],
        "components": [draw.component for draw in case.draws],
        "strengths": [round(draw.strength, 4) for draw in case.draws],
        "values": [draw.value for draw in case.draws],
        "outside": [draw.outside for draw in case.draws],
        "fault": [draw.fault for draw in case.draws],
        "windows": [draw.windows for draw in case.draws],
        "hidden_channels": list(case.hidden),
        "noise_factor": round(case.noise_factor, 3),
        "simulation": case.simulated,
        "tier": case.known.tier,
        "lengths_s": case.known.lengths_s,
        "single_axle": knowledge.single_axle(case.healthy),
        **truths,
    }


def make_run(case: Case, plants: Plants, run: str, mean_m_s: float, place: Path) -> Json:
    """Drive a run, write its recording (and simulation); returns what the answer says of it."""
    motion = drive(case, plants[0], run, mean_m_s, healthy=False)
    truth = bus_signals(motion, case, run, healthy=False)
    sensors = case.sensors()
    rng = np.random.default_rng((case.seeds["noise"], int(run[3])))
    frames = recorder.measure(
        truth, motion.time_s, sensors, run, rng, case.noise_factor, case.hidden
    )
    write_recording(place / f"{run}{case.suffix}", frames)
    said: Json = {"v_kmh": round(mean_m_s * 3.6, 2), "peak_m_s2": round(_peak(motion), 3)}
    if case.simulated or run != "run3":
        same = drive(case, plants[1], run, mean_m_s, healthy=True)
        clean = bus_signals(same, case, run, healthy=True)
        seen = visibility(sensed(truth, motion.time_s, sensors), clean, case.noise_factor)
        said["visibility"] = round(seen, 3)
        if case.simulated:
            recorder.write_simulation(place / f"simulation_{run}.mf4", motion.time_s, clean)
    for draw in case.draws:
        if draw.answer["id"] == "axle_load_harmonic":
            said["harmonic"] = harmonic_truth(motion, case, draw, run)
    return said


def make_runs(case: Case, plants: Plants, top: float, out: Path, answers: Path) -> Json:
    """Write the three runs of a case, the fastest near the speed `top`; the truth of each."""
    top = min(top, FASTEST_M_S)
    speeds = {"run1": top, "run2": min(25.0, 0.8 * top), "run3": 0.94 * top}
    if case.simulated:
        speeds["run1"] = 0.96 * top
    return {
        run: make_run(case, plants, run, mean, answers if run == "run3" else out)
        for run, mean in speeds.items()
    }


def make_case(seed: int, index: int, out: Path, answers: Path, only: str | None = None) -> str:
    """Write one case; returns its name."""
    name = f"b{index + 1:03d}"
    kept, digest = answers / name / "answer.json", generator_digest()
    if kept.exists() and json.loads(kept.read_text()).get("generator") == digest:
        return name
    case = draw_case(seed, index, only)
    plants = case.plant(), case.plant(healthy=True)
    restless = any(draw.restless for draw in case.draws)
    top = 0.99 * critical_speed(plants[1] if restless else plants[0])
    for attempt in range(4):
        for folder in (out / name, answers / name):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
        try:
            truths = make_runs(case, plants, top, out / name, answers / name)
            break
        except FloatingPointError:  # one of the two plants turns over: drive more slowly
            if attempt == 3:
                raise
            top *= 0.9
    dbc = "measurement_trailer.dbc" if case.simulated else "measurement.dbc"
    user = {key: factor for draw in case.draws for key, factor in draw.user.items()}
    vehicle = knowledge.vehicle_toml(case.healthy, case.known, user)
    (out / name / "vehicle.toml").write_text(vehicle)
    rear = case.healthy.car.rear.to_cog_m + case.known.shift_m["car"]
    roles = drives.signals_toml(rear, dbc, case.hidden, trailer=case.simulated)
    (out / name / "signals.toml").write_text(roles)
    kept.write_text(json.dumps(_answer(case, name, truths), indent=1, default=float))
    return name


def _job(arguments: tuple[int, int, Path, Path, str | None]) -> str:
    return make_case(*arguments)


def generate(
    seed: int, count: int, out: Path, answers: Path, jobs: int, only: str | None = None
) -> None:
    """Write `count` cases; those that are there already are kept."""
    out.mkdir(parents=True, exist_ok=True)
    answers.mkdir(parents=True, exist_ok=True)
    (out / "measurement.dbc").write_text(recorder.dbc_text(trailer=False))
    (out / "measurement_trailer.dbc").write_text(recorder.dbc_text(trailer=True))
    work = [(seed, index, out, answers, only) for index in range(count)]
    with multiprocessing.get_context("spawn").Pool(jobs) as pool:
        for done, name in enumerate(pool.imap_unordered(_job, work), 1):
            print(f"\r{done}/{count} {name}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--answers", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--clean", choices=knowledge.TIERS, help="nothing concealed, this tier")
    parser.add_argument("--unlisted", choices=unlisted.SETS, help="physics that nobody lists")
    parser.add_argument("--beside", choices=beside.SETS, help="beside the user's own simulation")
    given = parser.parse_args()
    only = given.clean or given.unlisted or given.beside
    generate(given.seed, given.count, given.out, given.answers, given.jobs, only)


if __name__ == "__main__":
    main()
