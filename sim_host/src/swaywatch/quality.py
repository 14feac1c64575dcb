"""Is the recording what it says it is? Gaps, stuck or clipped signals, signs, units, delays.

Single channels are looked at on their own; signs, units and delays by relations that must hold
between channels whatever the tyres do: kinematics of the hitch, balances of forces and moments.
A relation is a sum of terms, one per channel, that is zero (band-passed 0.15-3 Hz).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.signal

from swaywatch.drive import Channel, Drive, Grid
from swaywatch.vehicle import Vehicle

FloatArray = npt.NDArray[np.float64]
_Terms = dict[tuple[str, ...], FloatArray]

RATE_HZ = 100.0
GRAVITY = 9.80665
LIVELIEST = 12000
"""Samples (two minutes) that are enough to find a delay from."""

BROKEN = 0.6
"""A relation whose rest is above this part of its largest term does not hold."""

FACTORS: tuple[tuple[float, str], ...] = (
    (-1.0, "its sign is wrong"),
    (180 / math.pi, "it is in rad, not in deg"),
    (math.pi / 180, "it is in deg, not in rad"),
    (GRAVITY, "it is in g (or kg), not in m/s2 (or N)"),
    (1 / GRAVITY, "it is in m/s2 (or N), not in g (or kg)"),
    (3.6, "it is in m/s, not in km/h"),
    (1 / 3.6, "it is in km/h, not in m/s"),
    (1e3, "it is in kilo-units"),
    (1e-3, "it is in milli-units"),
)
"""Factor that puts a channel right, and what it means."""


@dataclass(frozen=True)
class Finding:
    """Something to know about a recording.

    Attributes
    ----------
    severity
        ``error``: results would be wrong; ``warning``: some are affected; ``info``.
    kind
        ``gap``, ``stuck``, ``clipped``, ``spike``, ``sign_or_unit``, ``delay``, ``clock``,
        ``load``, ``loss``, ``remark``.
    signals
        Names in the recording.
    text
        One sentence, with numbers.
    """

    severity: str
    kind: str
    signals: tuple[str, ...]
    text: str
    time_s: float | None = None


@dataclass(frozen=True)
class Relation:
    """Terms (channels -> array over the grid) that add up to zero.

    `tight` ones are kinematics and balances; loose ones of two terms hold only roughly, and tell
    signs and orders of magnitude.
    """

    name: str
    terms: _Terms
    tight: bool = True

    @property
    def channels(self) -> set[str]:
        """Channels in it."""
        return {name for names in self.terms for name in names}

    def is_broken(self, channel: str | None = None, factor: float = 1.0) -> bool:
        """Whether it does not hold, with `channel` times `factor`."""
        rest = self.rest(channel, factor)
        if self.tight:
            return rest > BROKEN
        sizes = sorted(
            float(np.sqrt(np.mean((term * (factor if channel in names else 1.0)) ** 2)))
            for names, term in self.terms.items()
        )
        return rest > 1.4 or sizes[-1] > 2.5 * sizes[-2]

    def rest(self, channel: str | None = None, factor: float = 1.0) -> float:
        """Root mean square of the sum over that of its largest term, `channel` times `factor`."""
        total = np.zeros(len(next(iter(self.terms.values()))))
        largest = 1e-12
        for names, term in self.terms.items():
            scaled = term * factor if channel in names else term
            total += scaled
            largest = max(largest, float(np.sqrt(np.mean(scaled**2))))
        return float(np.sqrt(np.mean(np.square(total)))) / largest


def check_drive(drive: Drive, vehicle: Vehicle) -> list[Finding]:
    """Everything worth saying about the data, worst first.

    Parameters
    ----------
    drive, vehicle
        Masses and lengths enter the balances.
    """
    findings: list[Finding] = []
    for channel in drive.channels.values():
        findings += check_channel(channel)
    findings += _check_clock(drive)
    findings += _check_speed(drive)
    findings += _check_pairs(drive) or _check_loads(drive, vehicle)
    grid = drive.resample(RATE_HZ)
    if len(grid.time_s) >= 4 * RATE_HZ:
        relations = make_relations(drive, vehicle, grid)
        wrong = _check_factors(drive, relations) or _check_steering(drive, vehicle, grid)
        findings += wrong or (
            _check_drift(drive, grid, relations) or _check_delays(drive, grid, relations)
        )
    if drive.lost_frames:
        findings.append(
            Finding(
                "warning",
                "loss",
                (),
                f"the logger lost {drive.lost_frames} frames ({', '.join(drive_files(drive))}); "
                "estimates are from what is there",
            )
        )
    findings += [Finding("info", "remark", (), remark) for remark in drive.remarks]
    order = {"error": 0, "warning": 1, "info": 2}
    return sorted(findings, key=lambda finding: order[finding.severity])


def check_balances(drive: Drive, vehicle: Vehicle) -> dict[str, float]:
    """Every relation that could be checked, and its rest as part of its largest term.

    The rest tells noise (a few percent), missing physics (some ten) and wrong signals (more); of
    the rough relations only sign and order of magnitude are checked, and they are left out here.
    """
    grid = drive.resample(RATE_HZ)
    if len(grid.time_s) < 4 * RATE_HZ:
        return {}
    relations = make_relations(drive, vehicle, grid)
    return {relation.name: relation.rest() for relation in relations if relation.tight}


# --- one channel ----------------------------------------------------------------------------------


def check_channel(channel: Channel) -> list[Finding]:
    """Gaps, stuck and clipped stretches, single wild samples of one channel."""
    findings = _gaps(channel)
    runs = _runs(channel.value)
    findings += _stuck(channel, runs) or _clipped(channel, runs)
    return findings + _spikes(channel)


def _gaps(channel: Channel) -> list[Finding]:
    step = np.diff(channel.time_s)
    period = float(np.median(step))
    limit = max(0.1, 3.0 * period)
    wide = np.flatnonzero(step > limit)
    if not len(wide):
        return []
    worst = wide[np.argmax(step[wide])]
    return [
        Finding(
            "warning",
            "gap",
            (channel.signal,),
            f"{channel.signal}: {len(wide)} gap(s) without a valid sample, the longest "
            f"{step[worst]:.2f} s at {channel.time_s[worst]:.2f} s (usual step {period * 1e3:.1f} "
            "ms); estimates whose window touches a gap are marked",
            float(channel.time_s[worst]),
        )
    ]


def _runs(value: FloatArray) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Start and length of each stretch of equal samples."""
    edges = np.flatnonzero(np.diff(value) != 0.0) + 1
    starts = np.concatenate([[0], edges])
    lengths = np.diff(np.concatenate([starts, [len(value)]]))
    return starts, lengths


def _resolution(channel: Channel) -> float:
    if channel.resolution > 0.0:
        return channel.resolution
    steps = np.abs(np.diff(np.unique(channel.value)))
    return float(steps.min()) if len(steps) else 0.0


def _stuck(channel: Channel, runs: tuple[npt.NDArray[np.int64], ...]) -> list[Finding]:
    starts, lengths = runs
    longest = int(np.argmax(lengths))
    start, count = int(starts[longest]), int(lengths[longest])
    period = float(np.median(np.diff(channel.time_s)))
    if count == len(channel.value):
        return [
            Finding(
                "warning",
                "stuck",
                (channel.signal,),
                f"{channel.signal}: the same value {channel.value[0]:g} {channel.unit} through the "
                "whole recording; is the sensor connected?",
            )
        ]
    typical = float(np.percentile(np.repeat(lengths, lengths), 90))
    quiet = channel.name in ("steering_wheel_angle", "speed")  # may rest at one value
    if quiet or count * period < 0.5 or count < 8 * typical:
        return []
    return [
        Finding(
            "warning",
            "stuck",
            (channel.signal,),
            f"{channel.signal}: stuck at {channel.value[start]:g} {channel.unit} for "
            f"{count * period:.2f} s from {channel.time_s[start]:.2f} s (otherwise it changes "
            f"every {typical * period:.2f} s)",
            float(channel.time_s[start]),
        )
    ]


def _clipped(channel: Channel, runs: tuple[npt.NDArray[np.int64], ...]) -> list[Finding]:
    """Flat tops: several stretches at the highest or lowest value, entered by a large step."""
    starts, lengths = runs
    value, resolution = channel.value, _resolution(channel)
    for end, word in ((float(value.max()), "upper"), (float(value.min()), "lower")):
        if end == 0.0:  # standing still is no clipping
            continue
        at_end = (value[starts] == end) & (lengths >= 4) & (starts > 0)
        entry = np.abs(value[starts] - value[np.maximum(starts - 1, 0)])
        flat = at_end & (entry >= 3.0 * resolution)
        limit = max(channel.limits) if word == "upper" else min(channel.limits)
        on_limit = math.isfinite(limit) and end != 0.0 and abs(end - limit) <= resolution
        if int(flat.sum()) >= 2 or (on_limit and np.any(at_end)):
            first = float(channel.time_s[starts[np.argmax(flat | at_end)]])
            return [
                Finding(
                    "warning",
                    "clipped",
                    (channel.signal,),
                    f"{channel.signal}: clipped at its {word} end {end:g} {channel.unit} "
                    f"({int(lengths[at_end].sum())} samples, first at {first:.2f} s)"
                    + ("; that is the limit of its bits or its DBC range" if on_limit else ""),
                    first,
                )
            ]
    return []


def _spikes(channel: Channel) -> list[Finding]:
    """Single samples far off both neighbours, which agree with each other."""
    value = channel.value
    if len(value) < 50:
        return []
    bend = value[1:-1] - 0.5 * (value[2:] + value[:-2])
    around = np.abs(value[2:] - value[:-2])
    scale = 1.4826 * float(np.median(np.abs(bend))) + _resolution(channel)
    wild = np.flatnonzero(
        (np.abs(bend) > max(25.0 * scale, 0.1 * np.std(value))) & (around < 0.3 * np.abs(bend))
    )
    if not len(wild):
        return []
    worst = int(wild[np.argmax(np.abs(bend[wild]))])
    return [
        Finding(
            "warning",
            "spike",
            (channel.signal,),
            f"{channel.signal}: {len(wild)} single-sample spike(s), the largest by "
            f"{bend[worst]:+.3g} {channel.unit} at {channel.time_s[worst + 1]:.2f} s",
            float(channel.time_s[worst + 1]),
        )
    ]


# --- clock, speed, loads --------------------------------------------------------------------------


def _check_clock(drive: Drive) -> list[Finding]:
    """One clock for the whole drive: the usual step of every channel must stay the same."""
    ratios = {}
    for channel in drive.channels.values():
        step = np.diff(channel.time_s)
        if len(step) < 200:
            continue
        parts = [float(np.median(part)) for part in np.array_split(step, 8)]
        ratios[channel.signal] = max(parts) / max(min(parts), 1e-9)
    if len(ratios) < 2:
        return []
    typical = float(np.median(list(ratios.values())))
    if typical < 1.02:
        return []
    return [
        Finding(
            "error",
            "clock",
            tuple(ratios),
            f"the clock changes its speed: the usual step of the messages changes by "
            f"{100 * (typical - 1):.0f} % within the drive ({', '.join(drive_files(drive))}); all "
            "timestamps must come from one clock",
        )
    ]


def drive_files(drive: Drive) -> list[str]:
    """Names of the files of a drive."""
    return [path.name for path in drive.files]


def _check_speed(drive: Drive) -> list[Finding]:
    channel = drive.channels.get("speed")
    if channel is None:
        return []
    fastest = float(np.percentile(channel.value, 99))
    if fastest > 70.0:
        return [
            Finding(
                "error",
                "sign_or_unit",
                (channel.signal,),
                f"{channel.signal}: speed reaches {fastest:.1f} m/s = {fastest * 3.6:.0f} km/h, "
                "which no car with a trailer drives; is it in km/h, though the recording says "
                f"{channel.unit_in_file}? Say `unit = ...` in the signals.toml",
            )
        ]
    if float(np.percentile(channel.value, 1)) < -0.5:
        return [
            Finding(
                "error",
                "sign_or_unit",
                (channel.signal,),
                f"{channel.signal}: speed is negative ({channel.value.min():.1f} m/s); its sign "
                "is wrong, or the car drives backwards",
            )
        ]
    return []


def _check_loads(drive: Drive, vehicle: Vehicle) -> list[Finding]:
    """Mean vertical loads against the weight."""
    findings = []
    for prefix, body in (("", vehicle.car), ("trailer_", vehicle.trailer)):
        names = [f"{prefix}wheel_vertical_load_{wheel}" for wheel in ("fl", "fr", "rl", "rr")]
        if body is None or not all(name in drive.channels for name in names):
            continue
        channels = [drive.channels[name] for name in names]
        total = sum(float(np.mean(channel.value)) for channel in channels)
        weight = body.mass * GRAVITY
        ratio = total / weight
        if 0.6 < ratio < 1.5:
            continue
        signals = tuple(channel.signal for channel in channels)
        text = (
            f"{', '.join(signals)}: the wheel loads add up to {total:.0f} N, the "
            f"{'trailer' if prefix else 'car'} weighs {weight:.0f} N"
        )
        reason = _factor_text(1.0 / ratio if ratio else math.inf)
        findings.append(
            Finding("error", "load", signals, f"{text}; {reason}" if reason else f"{text}; check")
        )
    return findings


def _factor_text(factor: float) -> str | None:
    """What a factor that puts a channel right means, if it is a known one."""
    for known, text in FACTORS:
        if 0.75 < factor / known < 1.33:
            return text
    return None


# --- relations ------------------------------------------------------------------------------------


def make_relations(drive: Drive, vehicle: Vehicle, grid: Grid) -> list[Relation]:
    """Every relation whose channels are there and that is excited."""
    builder = _Builder(drive, vehicle, grid)
    made = [
        builder.speed_times_yaw_rate(),
        builder.hitch_kinematics(),
        builder.articulation_rate(),
        builder.car_lateral(),
        builder.car_yaw(),
        builder.trailer_lateral(),
        builder.trailer_yaw(),
        builder.trailer_pull(),
    ]
    return [relation for relation in made if relation is not None]


class _Builder:
    """Terms of the relations on the grid."""

    def __init__(self, drive: Drive, vehicle: Vehicle, grid: Grid) -> None:
        self.drive = drive
        self.car, self.trailer = vehicle.car, vehicle.trailer
        self.value = grid.value
        self.band = scipy.signal.butter(
            2, (0.15, 3.0), btype="bandpass", fs=grid.rate_hz, output="sos"
        )
        self.rate_hz = grid.rate_hz
        good = np.ones(len(grid.time_s), dtype=np.bool_)
        for valid in grid.valid.values():
            good &= valid
        if "speed" in self.value:
            good &= self.value["speed"] > 5.0
        self.good = good

    def has(self, *names: str) -> bool:
        return all(name in self.value for name in names)

    def filtered(self, signal: FloatArray) -> FloatArray:
        result: FloatArray = scipy.signal.sosfiltfilt(self.band, signal)
        return result[self.good]

    def slope(self, name: str) -> FloatArray:
        result: FloatArray = np.gradient(self.value[name], 1.0 / self.rate_hz)
        return result

    def relation(self, name: str, terms: _Terms, tight: bool = True) -> Relation | None:
        if self.good.sum() < 3 * self.rate_hz:
            return None
        return Relation(name, {key: self.filtered(term) for key, term in terms.items()}, tight)

    def axle(self, prefix: str, axle: str) -> tuple[tuple[str, str], FloatArray] | None:
        names = (f"{prefix}wheel_lateral_force_{axle}l", f"{prefix}wheel_lateral_force_{axle}r")
        if not self.has(*names):
            return None
        return names, self.value[names[0]] + self.value[names[1]]

    def each(self, names: Iterable[str], factor: float) -> _Terms:
        return {(name,): factor * self.value[name] for name in names}

    def speed_times_yaw_rate(self) -> Relation | None:
        if not self.has("speed", "car_yaw_rate", "car_lateral_acceleration"):
            return None
        return self.relation(
            "car lateral acceleration = speed x yaw rate",
            {
                ("car_lateral_acceleration",): self.value["car_lateral_acceleration"],
                ("speed", "car_yaw_rate"): -self.value["speed"] * self.value["car_yaw_rate"],
            },
            tight=False,
        )

    def hitch_kinematics(self) -> Relation | None:
        names = (
            "car_yaw_rate",
            "car_lateral_acceleration",
            "trailer_yaw_rate",
            "trailer_lateral_acceleration",
        )
        if not self.has(*names) or self.trailer is None or self.car.hitch_to_cog is None:
            return None
        ahead_1 = self.drive.channels["car_lateral_acceleration"].position_m
        ahead_2 = self.drive.channels["trailer_lateral_acceleration"].position_m
        return self.relation(
            "lateral acceleration of the hitch, seen from both bodies",
            {
                ("car_lateral_acceleration",): self.value["car_lateral_acceleration"],
                ("car_yaw_rate",): -(self.car.hitch_to_cog + ahead_1) * self.slope("car_yaw_rate"),
                ("trailer_lateral_acceleration",): -self.value["trailer_lateral_acceleration"],
                ("trailer_yaw_rate",): -(self.trailer.hitch_to_cog - ahead_2)
                * self.slope("trailer_yaw_rate"),
            },
        )

    def articulation_rate(self) -> Relation | None:
        if not self.has("articulation", "car_yaw_rate", "trailer_yaw_rate"):
            return None
        return self.relation(
            "rate of articulation = difference of the yaw rates",
            {
                ("articulation",): self.slope("articulation"),
                ("trailer_yaw_rate",): -self.value["trailer_yaw_rate"],
                ("car_yaw_rate",): self.value["car_yaw_rate"],
            },
        )

    def car_acceleration(self) -> _Terms:
        """Terms of m1 times the lateral acceleration of the COG."""
        ahead = self.drive.channels["car_lateral_acceleration"].position_m
        return {
            ("car_lateral_acceleration",): self.car.mass * self.value["car_lateral_acceleration"],
            ("car_yaw_rate",): -self.car.mass * ahead * self.slope("car_yaw_rate"),
        }

    def car_lateral(self) -> Relation | None:
        axles = [self.axle("", axle) for axle in ("f", "r")]
        needed = ["car_lateral_acceleration", "car_yaw_rate"]
        needed += ["hitch_lateral_force"] if self.trailer is not None else []
        if None in axles or not self.has(*needed):
            return None
        terms = self.car_acceleration()
        for axle in axles:
            assert axle is not None
            terms |= self.each(axle[0], -1.0)
        if self.trailer is not None:
            terms |= self.each(("hitch_lateral_force",), -1.0)
        return self.relation("lateral forces on the car = mass x lateral acceleration", terms)

    def car_yaw(self) -> Relation | None:
        axles = [self.axle("", axle) for axle in ("f", "r")]
        needed = ["car_yaw_rate"] + (["hitch_lateral_force"] if self.trailer is not None else [])
        if None in axles or not self.has(*needed):
            return None
        terms: _Terms = {("car_yaw_rate",): self.car.yaw_inertia * self.slope("car_yaw_rate")}
        levers = (-self.car.front_axle_to_cog, self.car.rear_axle_to_cog)
        for axle, lever in zip(axles, levers, strict=True):
            assert axle is not None
            terms |= self.each(axle[0], lever)
        if self.trailer is not None and self.car.hitch_to_cog is not None:
            terms |= self.each(("hitch_lateral_force",), self.car.hitch_to_cog)
        return self.relation("yaw moments on the car = inertia x yaw acceleration", terms)

    def trailer_forces(self) -> list[tuple[tuple[str, str], FloatArray]] | None:
        axles = [self.axle("trailer_", axle) for axle in ("f", "r")]
        found = [axle for axle in axles if axle is not None]
        if self.trailer is None or not found or not self.has("hitch_lateral_force"):
            return None
        if self.trailer.front_axle_to_cog is not None and len(found) < 2:
            return None
        return found

    def trailer_lateral(self) -> Relation | None:
        found = self.trailer_forces()
        if found is None or not self.has("trailer_lateral_acceleration", "trailer_yaw_rate"):
            return None
        assert self.trailer is not None
        ahead = self.drive.channels["trailer_lateral_acceleration"].position_m
        mass = self.trailer.mass
        terms: _Terms = {
            ("trailer_lateral_acceleration",): mass * self.value["trailer_lateral_acceleration"],
            ("trailer_yaw_rate",): -mass * ahead * self.slope("trailer_yaw_rate"),
        }
        terms |= self.each(("hitch_lateral_force",), 1.0)
        for names, _ in found:
            terms |= self.each(names, -1.0)
        return self.relation("lateral forces on the trailer = mass x acceleration", terms)

    def trailer_yaw(self) -> Relation | None:
        found = self.trailer_forces()
        if found is None or not self.has("trailer_yaw_rate"):
            return None
        assert self.trailer is not None
        terms: _Terms = {
            ("trailer_yaw_rate",): self.trailer.yaw_inertia * self.slope("trailer_yaw_rate")
        }
        terms |= self.each(("hitch_lateral_force",), self.trailer.hitch_to_cog)
        for names, _ in found:
            front = names[0].endswith("_fl")
            ahead = self.trailer.front_axle_to_cog if front else -self.trailer.rear_axle_to_cog
            terms |= self.each(names, -(ahead or 0.0))
        return self.relation("yaw moments on the trailer = inertia x yaw acceleration", terms)

    def trailer_pull(self) -> Relation | None:
        """Yaw of the trailer about the middle of its axles, without its tyre forces."""
        names = ("trailer_yaw_rate", "trailer_lateral_acceleration", "hitch_lateral_force")
        if self.trailer is None or self.trailer_forces() is not None or not self.has(*names):
            return None
        trailer = self.trailer
        front = trailer.front_axle_to_cog
        behind = trailer.rear_axle_to_cog
        lever = behind if front is None else 0.5 * (behind - front)
        return self.relation(
            "yaw moments on the trailer about its axles",
            {
                ("trailer_yaw_rate",): trailer.yaw_inertia * self.slope("trailer_yaw_rate"),
                ("hitch_lateral_force",): (trailer.hitch_to_cog + lever)
                * self.value["hitch_lateral_force"],
                ("trailer_lateral_acceleration",): lever
                * trailer.mass
                * self.value["trailer_lateral_acceleration"],
            },
            tight=False,
        )

    def steering_gain(self) -> float | None:
        """Part of the front slip that the steering angle makes, over what it should make.

        Front force against front slip without drift (both sides through s/(s+a), a = 2.5 rad/s);
        the steering angle and the rest of the slip get a stiffness each, the result is their
        ratio: 1 where the steering angle is right. None where it cannot be told.
        """
        axle = self.axle("", "f")
        names = ("steering_wheel_angle", "speed", "car_yaw_rate", "car_lateral_acceleration")
        if axle is None or not self.has(*names) or self.good.sum() < 3 * self.rate_hz:
            return None
        corner = 2.5
        high = scipy.signal.bilinear([1.0, 0.0], [1.0, corner], fs=self.rate_hz)
        lag = scipy.signal.bilinear([1.0], [1.0, corner], fs=self.rate_hz)
        speed = np.maximum(self.value["speed"], 5.0)
        ahead = self.drive.channels["car_lateral_acceleration"].position_m
        yaw = self.value["car_yaw_rate"]
        side = self.value["car_lateral_acceleration"] - speed * yaw
        reach = self.car.front_axle_to_cog - ahead
        drift = scipy.signal.lfilter(*lag, side / speed)
        drift = drift + reach * scipy.signal.lfilter(*high, yaw / speed)
        steer = scipy.signal.lfilter(*high, self.value["steering_wheel_angle"])
        force = scipy.signal.lfilter(*high, axle[1])
        columns = np.column_stack(
            [self.filtered(steer / self.car.steering_ratio), self.filtered(-drift)]
        )
        target = self.filtered(force)
        fit, *_ = np.linalg.lstsq(columns, target, rcond=None)
        rest = target - columns @ fit
        error = float(np.std(rest) / np.sqrt(np.sum(columns[:, 0] ** 2) + 1e-12))
        if fit[1] <= 0.0 or abs(fit[0]) < 15.0 * error or np.std(rest) > 0.5 * np.std(target):
            return None
        return float(fit[0] / fit[1])


def _check_steering(drive: Drive, vehicle: Vehicle, grid: Grid) -> list[Finding]:
    """Sign and unit of the steering angle, from the force it makes at the front axle."""
    gain = _Builder(drive, vehicle, grid).steering_gain()
    if gain is None or 0.4 < gain < 2.5:
        return []
    signal = drive.channels["steering_wheel_angle"].signal
    reason = _factor_text(gain) or "check its sign, its unit and the steering ratio"
    return [
        Finding(
            "error",
            "sign_or_unit",
            (signal,),
            f"{signal}: {reason}. The front axle's lateral force follows it with "
            f"{gain:+.3g} times the expected gain; say so in the signals.toml, e.g. "
            f'steering_wheel_angle = {{ signal = "{signal}", '
            + ("sign = -1 }" if gain < 0.0 else 'unit = "..." }'),
        )
    ]


def _check_pairs(drive: Drive) -> list[Finding]:
    """Left and right wheel of an axle carry forces of the same size."""
    findings = []
    for name, left in drive.channels.items():
        right = drive.channels.get(name[:-1] + "r")
        if not name.startswith(("wheel", "trailer_wheel")) or name[-1] != "l" or right is None:
            continue
        if "vertical" in name:
            sizes = float(np.mean(left.value)), float(np.mean(right.value))
        else:
            sizes = float(np.std(left.value)), float(np.std(right.value))
        ratio = sizes[0] / sizes[1] if sizes[1] else math.inf
        if 0.2 < ratio < 5.0:
            continue
        text = _factor_text(ratio) or (_factor_text(1.0 / ratio) if ratio else None)
        findings.append(
            Finding(
                "error",
                "sign_or_unit",
                (left.signal, right.signal),
                f"{left.signal} and {right.signal}, left and right of one axle, are {sizes[0]:.3g} "
                f"and {sizes[1]:.3g} N; they should be of the same size and sign"
                + (f" (for one of them {text})" if text else ""),
            )
        )
    return findings


def _check_factors(drive: Drive, relations: list[Relation]) -> list[Finding]:
    """The one channel whose sign or unit explains every relation that does not hold."""
    broken = [relation for relation in relations if relation.is_broken()]
    if not broken:
        return []
    candidates: list[tuple[float, str, float, str]] = []
    suspects = sorted(set().union(*(relation.channels for relation in broken)))
    for name, (factor, text) in itertools.product(suspects, FACTORS):
        if not _fits_quantity(name, factor):
            continue
        if not any(relation.is_broken(name, factor) for relation in relations):
            rests = [relation.rest(name, factor) for relation in relations]
            candidates.append((_badness(rests), name, factor, text))
    candidates.sort()
    if not candidates:
        return _unexplained(broken, drive)
    best = candidates[0]
    equal = [c for c in candidates if c[0] < 1.15 * best[0] + 0.02][:4]
    signals = tuple(dict.fromkeys(drive.channels[c[1]].signal for c in equal))
    parts = [f"{drive.channels[name].signal}: {text}" for _, name, _, text in equal]
    names = "; ".join(relation.name for relation in broken)
    advice = f'say so in the signals.toml, e.g. {best[1]} = {{ signal = "{signals[0]}", ' + (
        "sign = -1 }" if best[2] == -1.0 else 'unit = "..." }'
    )
    return [
        Finding(
            "error",
            "sign_or_unit",
            signals,
            f"{' - or '.join(parts)}. Does not hold: {names} "
            f"(rest {100 * max(relation.rest() for relation in broken):.0f} %, when put right "
            f"{100 * max(relation.rest(best[1], best[2]) for relation in broken):.0f} %); {advice}",
        )
    ]


def _badness(rests: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(np.minimum(rests, 2.0)))))


def _fits_quantity(name: str, factor: float) -> bool:
    """Whether a unit error of `factor` can happen to a channel."""
    if factor in (-1.0, 1e3, 1e-3):
        return not (factor == -1.0 and name == "speed")
    if factor in (3.6, 1 / 3.6):
        return name == "speed"
    if factor in (GRAVITY, 1 / GRAVITY):
        return "acceleration" in name or "force" in name
    return "yaw_rate" in name or "angle" in name or name == "articulation"


def _unexplained(broken: list[Relation], drive: Drive) -> list[Finding]:
    findings = []
    for relation in broken:
        signals = tuple(drive.channels[name].signal for name in sorted(relation.channels))
        findings.append(
            Finding(
                "warning",
                "sign_or_unit",
                signals,
                f"does not hold: {relation.name} (rest {100 * relation.rest():.0f} % of its "
                "largest term), and no wrong sign or unit of one signal explains it; check the "
                "masses and lengths in the vehicle.toml and the positions of the accelerometers",
            )
        )
    return findings


# --- delays ---------------------------------------------------------------------------------------


def _check_delays(drive: Drive, grid: Grid, relations: list[Relation]) -> list[Finding]:
    """The one channel whose shift in time lets the tight relations hold better."""
    tight = _liveliest([relation for relation in relations if relation.tight])
    if not tight:
        return []
    now = _badness([relation.rest() for relation in tight])
    best: tuple[float, str, float] = (now, "", 0.0)
    for name in sorted(set().union(*(relation.channels for relation in tight))):
        mine = [relation for relation in tight if name in relation.channels]
        delay_s = _best_delay(mine, {name}, grid.rate_hz)
        rests = [_shifted_rest(relation, {name}, delay_s, grid.rate_hz) for relation in mine]
        others = [relation.rest() for relation in tight if name not in relation.channels]
        score = _badness(rests + others)
        if score < best[0]:
            best = (score, name, delay_s)
    score, name, delay_s = best
    if not name or abs(delay_s) < 0.008 or score > 0.6 * now or now < 0.08:
        return []
    channel = drive.channels[name]
    word = "late" if delay_s > 0 else "early"
    return [
        Finding(
            "warning",
            "delay",
            (channel.signal,),
            f"{channel.signal} comes {abs(delay_s) * 1e3:.0f} ms too {word} against the other "
            f"signals (rest of the balances {100 * now:.0f} %, {100 * score:.0f} % when shifted); "
            f"put it right with `delay = {delay_s:.3f}` in the signals.toml",
        )
    ]


def _check_drift(drive: Drive, grid: Grid, relations: list[Relation]) -> list[Finding]:
    """Two clocks: the delay of one file's signals against the other's grows with time."""
    files = sorted({channel.files for channel in drive.channels.values()})
    tight = [relation for relation in relations if relation.tight]
    for file in files[1:] if len(files) > 1 else []:
        names = {name for name, channel in drive.channels.items() if channel.files == file}
        mine = [r for r in tight if r.channels & names and r.channels - names]
        delays, middles = _delays_by_part(mine, names, grid)
        if len(delays) < 3:
            continue
        slope, start = np.polyfit(middles, delays, 1)
        scatter = float(np.std(delays - np.polyval([slope, start], middles)))
        change = abs(slope) * (middles[-1] - middles[0])
        if change > max(0.03, 3.0 * scatter):
            return [
                Finding(
                    "error",
                    "clock",
                    tuple(drive.channels[name].signal for name in sorted(names)),
                    f"two speeds of clock: the signals of {', '.join(file)} run "
                    f"{100 * abs(slope):.2f} % {'slow' if slope < 0 else 'fast'} against those of "
                    f"{', '.join(files[0])} (their delay goes from {delays[0] * 1e3:+.0f} to "
                    f"{delays[-1] * 1e3:+.0f} ms); put the files on one clock first",
                )
            ]
    return []


def _delays_by_part(
    relations: list[Relation], names: set[str], grid: Grid
) -> tuple[FloatArray, FloatArray]:
    """Delay of the channels in each excited sixth of the grid, and the middles of these in s."""
    delays, middles = [], []
    if not relations:
        return np.zeros(0), np.zeros(0)
    count = len(next(iter(relations[0].terms.values())))
    strong = max(float(np.std(term)) for term in relations[0].terms.values())
    for part in np.array_split(np.arange(count), 6):
        cut = [
            Relation(r.name, {key: term[part] for key, term in r.terms.items()}) for r in relations
        ]
        here = max(float(np.std(term)) for term in cut[0].terms.values())
        if here < 0.3 * strong or len(part) < grid.rate_hz:
            continue
        cut = _liveliest(cut)
        delay_s = _best_delay(cut, names, grid.rate_hz)
        if max(_shifted_rest(relation, names, delay_s, grid.rate_hz) for relation in cut) < 0.4:
            delays.append(delay_s)
            middles.append(float(np.mean(part)) / grid.rate_hz)
    return np.array(delays), np.array(middles)


def _liveliest(relations: list[Relation]) -> list[Relation]:
    """The stretch of LIVELIEST samples with most motion, of a long drive."""
    if not relations:
        return relations
    motion = next(iter(relations[0].terms.values())) ** 2
    if len(motion) <= LIVELIEST:
        return relations
    total = np.concatenate([[0.0], np.cumsum(motion)])
    start = int(np.argmax(total[LIVELIEST:] - total[:-LIVELIEST]))
    part = slice(start, start + LIVELIEST)
    return [Relation(r.name, {key: term[part] for key, term in r.terms.items()}) for r in relations]


def _shifted_rest(relation: Relation, names: set[str], delay_s: float, rate_hz: float) -> float:
    """Rest of a relation with the channels taken `delay_s` earlier."""
    terms = {}
    for channels, term in relation.terms.items():
        if names & set(channels):
            index = np.arange(len(term)) + delay_s * rate_hz
            terms[channels] = np.interp(index, np.arange(len(term)), term)
        else:
            terms[channels] = term
    return Relation(relation.name, terms).rest()


def _best_delay(relations: list[Relation], names: set[str], rate_hz: float) -> float:
    """Delay within +-0.4 s with the smallest rest, to 1 ms."""
    delays = np.arange(-0.4, 0.4001, 0.02)
    for width in (0.004, 0.001, 0.0):
        scores = [
            _badness([_shifted_rest(relation, names, float(d), rate_hz) for relation in relations])
            for d in delays
        ]
        middle = float(delays[int(np.argmin(scores))])
        delays = middle + width * np.arange(-5, 6)
    return middle
