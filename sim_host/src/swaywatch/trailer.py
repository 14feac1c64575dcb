"""What trailer is this? Asked of steering, speed, yaw rate and acceleration of the car alone.

The estimator is ``lib/model/sway_trailer.h``; here drives are put one after the other into it, its
numbers get intervals, and manoeuvres that have not been driven are tried in a simulation.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from swaywatch.drive import Drive
from swaywatch.ecu._core import ffi, lib
from swaywatch.ecu.core import PRESENCE, VCRIT, Core, positions_of, real_to_float
from swaywatch.errors import RecordingError
from swaywatch.models.single_track import SingleTrack
from swaywatch.vehicle import Vehicle

FloatArray = npt.NDArray[np.float64]

OWN_CHANNELS = ("steering_wheel_angle", "speed", "car_yaw_rate", "car_lateral_acceleration")
"""What is needed, and all that is used."""

INTERVAL = 1.645
"""Standard errors on each side of a 90 % interval."""

PAUSE_S = 5.0
"""Between two drives: longer than what the core bridges."""


@dataclass(frozen=True)
class Quantity:
    """One property of the trailer.

    Attributes
    ----------
    name, unit
        In words.
    value, low, high
        Identified value and its 90 % interval.
    believed
        Of the ``vehicle.toml``; None where unknown.
    gained
        Share of the initial uncertainty that is removed, 0 to 1.
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    believed: float | None
    gained: float


@dataclass(frozen=True)
class Manoeuvre:
    """Uncertainty after 30 s of a manoeuvre (90 % half widths, simulated)."""

    name: str
    critical_speed_m_s: float | None
    mass_kg: float


@dataclass(frozen=True)
class TrailerResult:
    """The attached trailer, identified from the car's own sensors.

    Attributes
    ----------
    presence
        ``there``, ``none`` or ``undecided``.
    certainty
        Probability of ``presence``.
    learnt_s
        Driving that it was learnt from.
    quantities
        Of the trailer; empty where there is none.
    critical_speed_m_s, critical_speed_error_m_s
        With its standard error; None where it cannot be determined.
    manoeuvres
        Those that would sharpen it, the best first.
    """

    presence: str
    certainty: float
    learnt_s: float
    quantities: tuple[Quantity, ...]
    critical_speed_m_s: float | None
    critical_speed_error_m_s: float | None
    manoeuvres: tuple[Manoeuvre, ...]


def certainty(report: dict[str, Any]) -> float:
    """Probability of what `presence` says, from the odds."""
    odds = abs(report["evidence_milli"]) / 1e3
    return 1.0 / (1.0 + math.exp(-odds))


def presence_sentence(report: dict[str, Any]) -> str:
    """One sentence, or nothing where sensors of the trailer were heard or nothing was learnt."""
    what = PRESENCE.get(report.get("presence", -1), "sensed")
    if what == "sensed" or report["learnt_ms"] == 0:
        return ""
    sure = min(100.0 * certainty(report), 99.9)
    if what == "none":
        return f"No trailer is attached, according to the car's own sensors ({sure:.1f} % certain)."
    if what == "there":
        return f"A trailer is attached, according to the car's own sensors ({sure:.1f} % certain)."
    return "Whether a trailer is attached cannot be decided: too little steering in this drive."


def chained(drives: Sequence[Drive]) -> Drive:
    """The car's own channels of several drives, one after the other, with a pause between.

    Raises
    ------
    RecordingError
        A drive lacks one of the four channels.
    """
    offset = 0.0
    parts: dict[str, list[tuple[FloatArray, FloatArray]]] = {name: [] for name in OWN_CHANNELS}
    for drive in drives:
        lacking = [name for name in OWN_CHANNELS if name not in drive.channels]
        if lacking:
            raise RecordingError(
                f"{', '.join(map(str, drive.files))}: no signal for the role(s) "
                f"{', '.join(lacking)}; the trailer is identified from {', '.join(OWN_CHANNELS)}"
            )
        for name in OWN_CHANNELS:
            channel = drive.channels[name]
            parts[name].append((channel.time_s + offset, channel.value))
        offset += drive.duration_s + PAUSE_S
    channels = {
        name: dataclasses.replace(
            drives[0].channels[name],
            time_s=np.concatenate([time for time, _ in pieces]),
            value=np.concatenate([value for _, value in pieces]),
        )
        for name, pieces in parts.items()
    }
    return dataclasses.replace(
        drives[0], channels=channels, files=tuple(f for d in drives for f in d.files)
    )


def identify(drives: Sequence[Drive], vehicle: Vehicle) -> TrailerResult:
    """The trailer of some drives with the same combination.

    Parameters
    ----------
    drives
        Any manoeuvres with steering, best at different speeds. Only the car's own four channels are
        used, whatever else there is.
    vehicle
        A car; its [trailer] complete, partly known or absent.
    """
    whole = chained(drives)
    core = Core(vehicle, positions_of(whole))
    first = core.trailer()
    core.feed(whole)
    report = core.trailer()
    speed = float(np.median(whole.channels["speed"].value))
    watch = _watch(core)
    critical = _model(watch, max(speed, 10.0))
    what = PRESENCE[report["presence"]]
    gone = what == "none" or report["learnt_ms"] == 0
    found = critical is not None and not gone
    return TrailerResult(
        what,
        certainty(report),
        report["learnt_ms"] / 1e3,
        () if gone else _quantities(report, first, vehicle),
        critical[0] if found and critical else None,
        critical[1] if found and critical else None,
        () if what != "there" else _manoeuvres(watch, report, vehicle, whole, critical),
    )


def _watch(core: Core) -> Any:
    """A copy of what the core knows of the trailer."""
    copy = ffi.new("sway_trailer_watch_t *")
    copy[0] = core.watch[0]
    return copy


def _model(watch: Any, speed_m_s: float) -> tuple[float, float] | None:
    """Critical speed and its standard error, m/s; None where it cannot be determined."""
    watch.complete = False  # all derivatives anew
    speed = lib.sway_real_ratio(round(speed_m_s * 1e3), 1000)
    lib.sway_trailer_model_start(watch, speed)
    while lib.sway_trailer_model_run(watch):
        pass
    if VCRIT[watch.model.kind] not in ("found", "divergence"):
        return None
    return real_to_float(watch.model.v_crit_m_s), real_to_float(watch.model.v_crit_se_m_s)


_NAMES = (
    ("mass_kg", "mass", "kg", 1.0),
    ("hitch_to_axle_mm", "hitch to axle", "m", 1e-3),
    ("hitch_to_cog_mm", "hitch to centre of gravity", "m", 1e-3),
    ("yaw_inertia_kgm2", "yaw inertia", "kg m2", 1.0),
    ("stiffness_n_per_rad", "cornering stiffness, all axles", "kN/rad", 1e-3),
    ("friction_nm", "dry friction at the ball", "Nm", 1.0),
)


def _quantities(
    report: dict[str, Any], first: dict[str, Any], vehicle: Vehicle
) -> tuple[Quantity, ...]:
    believed = _believed(vehicle)
    result = []
    for key, name, unit, scale in _NAMES:
        value, error = report[key]
        before = max(first[key][1], 1)
        half = INTERVAL * error * scale
        result.append(
            Quantity(
                name, unit, value * scale, value * scale - half, value * scale + half,
                believed.get(key), max(0.0, 1.0 - error / before),
            )
        )  # fmt: skip
    return tuple(result)


def _believed(vehicle: Vehicle) -> dict[str, float]:
    """The user's values in the units of `_NAMES`; what nobody gave is left out."""
    trailer = vehicle.trailer
    if trailer is None:
        return {}
    front, rear = trailer.front_cornering_stiffness or 0.0, trailer.rear_cornering_stiffness or 0.0
    ahead = trailer.front_axle_to_cog or 0.0
    behind = trailer.rear_axle_to_cog
    if trailer.front_axle_to_cog is not None:
        share = front / (front + rear) if front and rear else 0.5
        behind = (1.0 - share) * behind - share * ahead
    values = {
        "mass": ("mass_kg", trailer.mass),
        "yaw_inertia": ("yaw_inertia_kgm2", trailer.yaw_inertia),
        "stiffness": ("stiffness_n_per_rad", (front + rear) * 1e-3),
        "hitch_to_cog": ("hitch_to_cog_mm", trailer.hitch_to_cog),
        "axle": ("hitch_to_axle_mm", trailer.hitch_to_cog + behind),
    }
    return {key: value for name, (key, value) in values.items() if name not in trailer.assumed}


# --- what would sharpen it ------------------------------------------------------------------------

RATE_HZ = 100.0
DRIVEN_S = 30.0
HARDEST_M_S2 = 3.0
"""Lateral acceleration that nobody need exceed for a measurement."""
_ACCELERATIONS = ("car_lateral_acceleration", "trailer_lateral_acceleration")


def _candidates(top_m_s: float, sway_hz: float) -> list[tuple[str, float, FloatArray]]:
    """Name, speed and steering wheel angle at 100 Hz of manoeuvres within an ordinary driver."""
    time = np.arange(0.0, DRIVEN_S, 1.0 / RATE_HZ)
    result = []
    for speed in sorted({min(22.0, top_m_s), top_m_s}):
        kmh = round(speed * 3.6 / 5.0) * 5
        for frequency in (0.25, 0.45, round(sway_hz, 2)):
            angle = np.radians(12.0) * np.sin(2 * np.pi * frequency * time)
            result.append((f"slalom at {frequency:g} Hz, {kmh} km/h", speed, angle))
        pulse = np.zeros_like(time)
        for begin in (2.0, 16.0):
            inside = (time >= begin) & (time < begin + 0.75)
            pulse[inside] = np.radians(20.0) * np.sin(np.pi * (time[inside] - begin) / 0.75)
        result.append((f"two steering impulses, {kmh} km/h", speed, pulse))
    return result


def _single_track(report: dict[str, Any], vehicle: Vehicle) -> SingleTrack:
    car = vehicle.car
    length = report["hitch_to_cog_mm"][0] * 1e-3
    return SingleTrack(
        m1=car.mass, iz1=car.yaw_inertia, lf1=car.front_axle_to_cog, lr1=car.rear_axle_to_cog,
        lh1=car.hitch_to_cog or car.rear_axle_to_cog + 1.0,
        cf1=report["car_front_n_per_rad"][0], cr1=report["car_rear_n_per_rad"][0],
        steering_ratio=car.steering_ratio, m2=report["mass_kg"][0],
        iz2=report["yaw_inertia_kgm2"][0], lh2=length,
        lr2=report["hitch_to_axle_mm"][0] * 1e-3 - length, cr2=report["stiffness_n_per_rad"][0],
    )  # fmt: skip


def _manoeuvres(
    watch: Any,
    report: dict[str, Any],
    vehicle: Vehicle,
    drive: Drive,
    critical: tuple[float, float] | None,
) -> tuple[Manoeuvre, ...]:
    model = _single_track(report, vehicle)
    top = min(0.75 * critical[0] if critical else 25.0, 33.0)
    position = drive.channels["car_lateral_acceleration"].position_m
    sway = np.abs(np.linalg.eigvals(model.state_space(top)[0]).imag).max() / (2 * np.pi)
    result = []
    for name, speed, angle in _candidates(top, float(sway)):
        motion = model.run(np.arange(len(angle)) / RATE_HZ, angle, speed)
        if max(np.abs(motion[k]).max() for k in _ACCELERATIONS) > HARDEST_M_S2:
            continue
        tried = ffi.new("sway_trailer_watch_t *")
        tried[0] = watch[0]
        _drive(tried, motion, speed, angle, position)
        after = ffi.new("sway_trailer_report_t *")
        lib.sway_trailer_report(tried, after)
        found = _model(tried, speed)
        result.append(
            Manoeuvre(
                name,
                INTERVAL * found[1] if found else None,
                INTERVAL * after.mass_kg.se,
            )
        )
    return tuple(sorted(result, key=lambda m: (m.critical_speed_m_s or math.inf, m.mass_kg)))


def _drive(
    watch: Any,
    motion: dict[str, FloatArray],
    speed_m_s: float,
    angle: FloatArray,
    position_m: float,
) -> None:
    """Let the estimator hear a simulated motion, with the noise of production sensors."""
    time = np.arange(len(angle)) / RATE_HZ
    noise = np.random.default_rng(1)
    yaw = motion["car_yaw_rate"] + 0.003 * noise.standard_normal(len(time))
    acc = motion["car_lateral_acceleration"] + position_m * np.gradient(
        motion["car_yaw_rate"], 1 / RATE_HZ
    )
    acc = acc + 0.05 * noise.standard_normal(len(time))
    row = ffi.new("sway_row_t *")
    places = [
        int(getattr(lib, f"SWAY_CHANNEL_{name}"))
        for name in ("STEERING_WHEEL_ANGLE", "SPEED", "CAR_YAW_RATE", "CAR_LATERAL_ACC")
    ]
    row.valid_mask = sum(1 << place for place in places)
    row.restart = True
    for values in zip(angle * 1e6, np.full(len(time), speed_m_s * 1e3), yaw * 1e6, acc * 1e6,
                      strict=True):  # fmt: skip
        for place, value in zip(places, values, strict=True):
            row.value[place] = round(float(value))
        lib.sway_trailer_push(watch, row)
        row.restart = False
        while lib.sway_trailer_cost(watch):
            lib.sway_trailer_run(watch)


def as_json(result: TrailerResult, files: Sequence[Path]) -> dict[str, Any]:
    """The result as plain types, SI units."""
    content = dataclasses.asdict(result)
    return {"files": [str(path) for path in files], **content}
