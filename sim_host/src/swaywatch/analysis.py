"""The main job: recordings in; estimates, findings and a conclusion out."""

from __future__ import annotations

import itertools
import math
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from swaywatch.checks.quality import Finding, check_balances, check_drive
from swaywatch.drive import Drive, load_drives, load_signals
from swaywatch.ecu.core import (
    ALARM,
    AXLES,
    PRESENCE,
    QUALITY,
    REASON,
    SOURCE,
    USUAL_WINDOW,
    VCRIT,
    Estimates,
    analyze_drive,
    model_damping,
)
from swaywatch.ecu.supervised import findings_of
from swaywatch.errors import RecordingError, SignalError
from swaywatch.vehicle import Vehicle
from swaywatch.vehicle_file import load_vehicle

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

AXLE_NAMES = {
    "car_front": "front axle of the car",
    "car_rear": "rear axle of the car",
    "trailer_front": "front axle of the trailer",
    "trailer_rear": "rear axle of the trailer",
}

UNUSABLE = ("no_oscillation", "seeking", "singular", "misfit", "slow", "no_speed")
"""Quality flags of estimates that are left out of means."""

FEWEST_FREE = 8
"""Estimates of a free oscillation that its damping needs at least: half a window's length."""

LIMITS = ("found", "divergence")
"""Kinds of a critical speed that was found, not where the search ended."""

FASTEST_TOWING_M_S, FASTEST_ALONE_M_S = 180.0 / 3.6, 360.0 / 3.6
"""Tests of stability with a trailer end below 150 km/h."""

UNLIKE = 0.3
"""Share by which a stiffness may differ from the assumed one without a finding: tyres of another
load, pressure or temperature do by 10 to 20 %."""

SEARCHED_M_S = (10.0 / 3.6, 250.0 / 3.6)
"""Speeds between which the core looks for the critical one (``sway_vcrit_t``)."""

_FORCES = tuple(f"wheel_lateral_force_{wheel}" for wheel in ("fl", "fr", "rl", "rr"))
_LOADS = tuple(f"wheel_vertical_load_{wheel}" for wheel in ("fl", "fr", "rl", "rr"))
_CAR = ("speed", "car_yaw_rate", "car_lateral_acceleration")
_TRAILER = ("trailer_yaw_rate", "trailer_lateral_acceleration")


def _trailer(names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"trailer_{name}" for name in names)


NEEDS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    ("frequency and damping of the oscillation", "line", ("car_yaw_rate",)),
    ("distinguishing free from steered oscillations", "", ("steering_wheel_angle",)),
    (
        "cornering stiffness of the car's front axle",
        "car_front",
        (*_CAR, "steering_wheel_angle", *_FORCES[:2]),
    ),
    ("cornering stiffness of the car's rear axle", "car_rear", (*_CAR, *_FORCES[2:])),
    (
        "cornering stiffness of the trailer's front axle",
        "trailer_front",
        (*_CAR, *_TRAILER, *_trailer(_FORCES[:2])),
    ),
    (
        "cornering stiffness of the trailer's rear axle",
        "trailer_rear",
        (*_CAR, *_TRAILER, *_trailer(_FORCES[2:])),
    ),
    ("effective load of the car's front axle", "car_front_load", (*_FORCES[:2], *_LOADS[:2])),
    ("effective load of the car's rear axle", "car_rear_load", (*_FORCES[2:], *_LOADS[2:])),
    ("effective load of the trailer's front axle", "trailer_front_load", _trailer(_LOADS[:2])),
    ("effective load of the trailer's rear axle", "trailer_rear_load", _trailer(_LOADS[2:])),
    ("yaw inertia of the car", "car_inertia", ("car_yaw_rate", *_FORCES, "hitch_lateral_force")),
    ("yaw inertia of the trailer", "trailer_inertia", (*_TRAILER, "hitch_lateral_force")),
    ("critical speed and margin", "critical_speed", ("speed",)),
)
"""Results, the bit of ``valid`` that says they are there, and the channels they are best had from.
"""


@dataclass(frozen=True)
class Value:
    """A number with its standard error and the number of estimates behind it."""

    value: float
    error: float
    count: int
    scatter: float = 0.0


@dataclass(frozen=True)
class AlarmInterval:
    """A stretch of time in one alarm state."""

    start_s: float
    end_s: float
    state: str
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class DriveResult:
    """Everything found in one drive."""

    drive: Drive
    vehicle: Vehicle
    estimates: Estimates
    findings: list[Finding]
    values: dict[str, Value]
    alarms: list[AlarmInterval]
    switched_off: list[tuple[str, tuple[str, ...]]]
    indirect: list[tuple[str, tuple[str, ...]]]
    balances: dict[str, float]
    critical_kind: str = "none"
    """``found``; ``beyond_range`` or ``below_range`` where the search ended at its bound;
    ``divergence`` where the limit is static; ``none``."""
    sentences: list[str] = field(default_factory=list)
    window_oscillations: float = USUAL_WINDOW


def usable(estimates: Estimates) -> BoolArray:
    """Estimates of an oscillation that none of the flags in UNUSABLE speaks against."""
    good = estimates.has("line")
    for flag in UNUSABLE:
        good = good & ~estimates.flagged(flag)
    return good


def analyze(
    paths: Sequence[Path],
    vehicle_path: Path,
    signals_path: Path,
    *,
    join: bool | None = None,
    strict: bool = True,
    window: float | None = None,
    progress: Callable[[str, float, float], None] | None = None,
) -> list[DriveResult]:
    """Analyse recordings.

    Parameters
    ----------
    paths, vehicle_path, signals_path
        Recordings, ``vehicle.toml`` and ``signals.toml``.
    join
        As in :func:`swaywatch.drive.load_drives`.
    strict
        Refuse recordings in which a sign, a unit or a clock is wrong.
    window
        Length of the window in oscillations; None: the core's own.
    progress
        Called with what is done, how far, and of how much.

    Raises
    ------
    SwaywatchError
        The input is at fault.
    """

    def tell(what: str, done: float, total: float) -> None:
        if progress:
            progress(what, done, total)

    twice = [path for k, path in enumerate(paths) if path in paths[:k]]
    if twice:
        raise RecordingError(f"{twice[0]}: is given twice; name each recording once")
    vehicle = load_vehicle(vehicle_path)
    refuse_trailer_roles(vehicle, signals_path)
    tell("reading", 0.0, 1.0)
    drives = load_drives(paths, signals_path, join=join)
    tell("reading", 1.0, 1.0)
    for drive in drives:
        _must_have(drive, signals_path)
    stop = threading.Event()
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        # The core runs in C without the interpreter's lock, beside the checks of the data.
        running = [pool.submit(_run_core, drive, vehicle, tell, stop, window) for drive in drives]
        try:
            checks = [check_drive(drive, vehicle) for drive in drives]
            if strict:
                for drive, findings in zip(drives, checks, strict=True):
                    _refuse_wrong(drive, findings)
            return [
                replace(
                    conclude(drive, vehicle, core.result(), findings),
                    window_oscillations=USUAL_WINDOW if window is None else window,
                )
                for drive, core, findings in zip(drives, running, checks, strict=True)
            ]
        except BaseException:
            stop.set()
            raise


class _StoppedError(Exception):
    """Nobody waits for this drive any more."""


def _run_core(
    drive: Drive,
    vehicle: Vehicle,
    tell: Callable[[str, float, float], None],
    stop: threading.Event,
    window: float | None,
) -> Estimates:
    def tell_core(done: float) -> None:
        if stop.is_set():
            raise _StoppedError
        tell(f"analysing {drive.name}", done, drive.duration_s)

    return analyze_drive(drive, vehicle, tell_core, window)


def _refuse_wrong(drive: Drive, findings: list[Finding]) -> None:
    """Raise if a sign, a unit or a clock is wrong."""
    wrong = [finding for finding in findings if finding.severity == "error"]
    if wrong:
        listed = "\n  ".join(finding.text for finding in wrong)
        raise SignalError(
            f"{', '.join(map(str, drive.files))}: the signals do not fit together:\n  "
            f"{listed}\n(--ignore-quality analyses it anyway)"
        )


def _must_have(drive: Drive, signals_path: Path) -> None:
    """Refuse drives without the channels nothing can be said without.

    All else is decided by what the core can tell from the channels there are.
    """
    missing = [name for name in ("speed", "car_yaw_rate") if name not in drive.channels]
    for name in missing:
        if name in drive.absent:
            raise SignalError(
                f"{', '.join(map(str, drive.files))}: no samples of {name}: {signals_path} names "
                f"{drive.absent[name]}. Without it stability cannot be assessed"
            )
    if missing:
        raise SignalError(
            f"{', '.join(map(str, drive.files))}: no signal for the role(s) {', '.join(missing)}; "
            f'name them in {signals_path}, e.g. {missing[0]} = "SignalName". Without them '
            "nothing can be said about stability"
        )


def refuse_trailer_roles(vehicle: Vehicle, signals_path: Path) -> None:
    """Refuse signals of a trailer that the vehicle.toml does not have.

    They would be read as those of a car alone, whose critical speed has nothing to do with that of
    the combination.

    Raises
    ------
    SignalError
        Names the roles and both ways to put it right.
    """
    if vehicle.trailer is not None:
        return
    roles = [
        mapping.channel
        for mapping in load_signals(signals_path)[0]
        if mapping.channel.startswith(("trailer_", "hitch_", "articulation"))
    ]
    if roles:
        raise SignalError(
            f"{signals_path} has signals of a trailer ({', '.join(roles[:3])}"
            f"{', ...' if len(roles) > 3 else ''}), but {vehicle.path} has no [trailer]: add it "
            "there (mass, yaw_inertia, hitch_to_cog, rear_axle_to_cog; and hitch_to_cog to [car]), "
            "or leave these roles out if the car drove alone"
        )


def conclude(
    drive: Drive, vehicle: Vehicle, estimates: Estimates, findings: list[Finding]
) -> DriveResult:
    """Means over the usable estimates, alarms, and what could not be said."""
    good = usable(estimates)
    values = _values(estimates, good)
    findings = [
        *findings, *_implausible(drive, vehicle), *_unlike_file(vehicle, values),
        *findings_of(estimates),
    ]  # fmt: skip
    off, indirect = _lacking(drive, vehicle, estimates)
    return DriveResult(
        drive,
        vehicle,
        estimates,
        findings,
        values,
        alarm_intervals(estimates, drive.duration_s),
        off,
        indirect,
        check_balances(drive, vehicle),
        critical_kind(estimates, good),
    )


def observed(estimates: Estimates) -> bool:
    """Whether what is said of a trailer comes from the car's own sensors alone."""
    return PRESENCE.get(estimates.trailer.get("presence", -1)) in ("there", "undecided")


def _implausible(drive: Drive, vehicle: Vehicle) -> list[Finding]:
    """A speed that no such vehicle is driven at: the one unit that no relation can check."""
    speed = drive.channels.get("speed")
    if speed is None or not len(speed.value):
        return []
    top, what = (FASTEST_ALONE_M_S, "a car") if vehicle.trailer is None else (
        FASTEST_TOWING_M_S, "a car with a trailer"
    )  # fmt: skip
    seen = float(np.percentile(speed.value, 99))
    if seen <= top:
        return []
    return [
        Finding(
            "warning",
            "implausible",
            (speed.signal,),
            f"{speed.signal}: {seen * 3.6:.0f} km/h is faster than {what} is driven; check its "
            f"unit ({speed.unit_in_file or 'none said'}): every stiffness and the critical speed "
            "depend on it",
            channels=("speed",),
        )
    ]


def _unlike_file(vehicle: Vehicle, values: dict[str, Value]) -> list[Finding]:
    """Tyres so far from those of ``vehicle.toml`` that one of the two has to be wrong.

    A wrong unit of the speed or the steering shows here where no relation can check it.
    """
    far = []
    for axle in AXLES:
        key = f"{axle}.cornering_stiffness_n_per_rad"
        found, believed = values.get(key), believed_value(vehicle, key)
        if found is None or not believed:
            continue
        off = found.value - believed
        if abs(off) > UNLIKE * believed and abs(off) > 2.5 * found.error:
            far.append(f"{axle.replace('_', ' ')} {100.0 * off / believed:+.0f} %")
    if not far:
        return []
    return [
        Finding(
            "warning",
            "unlike_file",
            (),
            f"cornering stiffnesses far from those of the vehicle.toml ({', '.join(far)}): "
            "either the file is a guess, or a unit or sign (speed, steering angle), the steering "
            "ratio, a mass or a length is wrong",
        )
    ]


def _best_critical(estimates: Estimates, good: BoolArray) -> BoolArray:
    """Estimates whose critical speed counts: from identified tyres if any, and usable ones.

    From the car's own sensors one filter runs over the whole drive: its last word counts.
    """
    critical = estimates.has("critical_speed")
    if observed(estimates) and critical.any():
        last: BoolArray = np.arange(len(critical)) == np.flatnonzero(critical)[-1]
        return last
    identified = estimates.status["source"] == _code(SOURCE, "identified")
    for best in (critical & good & identified, critical & good):
        if best.any():
            return best
    return critical


def found_critical(estimates: Estimates) -> BoolArray:
    """Where the critical speed was found, and is not a bound of the search, shape (n,)."""
    kinds = [_code(VCRIT, name) for name in LIMITS]
    found: BoolArray = np.isin(estimates.status["v_crit_kind"], kinds)
    return found


def critical_kind(estimates: Estimates, good: BoolArray) -> str:
    """What most of the estimates that count say of the critical speed."""
    best = _best_critical(estimates, good)
    if not best.any():
        return "none"
    kinds = np.bincount(estimates.status["v_crit_kind"][best].astype(np.int64), minlength=8)
    return VCRIT[int(kinds.argmax())]


def _values(estimates: Estimates, good: BoolArray) -> dict[str, Value]:
    values: dict[str, Value] = {}

    def add(name: str, column: str, error: str, mask: BoolArray, *, filtered: bool = False) -> None:
        found = weighted_mean(estimates, column, error, mask, filtered=filtered)
        if found is not None:
            values[name] = found

    free = good & ~estimates.flagged("forced")
    if free.sum() < FEWEST_FREE:
        free = np.zeros(len(good), dtype=np.bool_)
    add("frequency_hz", "frequency_hz", "frequency_se_hz", free)
    if not free.any() and good.any():
        driven = estimates["frequency_hz"][good]
        for name, share in (("driven_low_hz", 5), ("driven_high_hz", 95)):
            values[name] = Value(float(np.percentile(driven, share)), 0.0, int(good.sum()))
    add("damping_ratio", "damping_ratio", "damping_ratio_se", free)
    add("model_damping_ratio", "model_damping_ratio", "model_damping_ratio_se",
        estimates.has("model") & (free if free.any() else good), filtered=True)  # fmt: skip
    # A search that ended at its bound has found no critical speed: the bound is none.
    if critical_kind(estimates, good) in LIMITS:
        best = _best_critical(estimates, good) & found_critical(estimates)
        add("v_crit_m_s", "v_crit_m_s", "v_crit_se_m_s", best, filtered=True)
    for axle in AXLES:
        add(
            f"{axle}.cornering_stiffness_n_per_rad",
            f"{axle}.cornering_stiffness_n_per_rad",
            f"{axle}.cornering_stiffness_se_n_per_rad",
            estimates.has(axle) & good,
        )
        add(f"{axle}.argument_rad", f"{axle}.argument_rad", f"{axle}.argument_se_rad",
            estimates.has(axle) & good)  # fmt: skip
    if observed(estimates) and estimates.trailer["learnt_ms"] > 0:
        for axle in ("car_front", "car_rear"):
            value, error = estimates.trailer[f"{axle}_n_per_rad"]
            name = f"{axle}.cornering_stiffness_n_per_rad"
            values[name] = Value(float(value), float(error), len(estimates))
    add("car_yaw_inertia_kgm2", "car_yaw_inertia_kgm2", "car_yaw_inertia_se_kgm2",
        estimates.has("car_inertia") & good)  # fmt: skip
    add("trailer_yaw_inertia_kgm2", "trailer_yaw_inertia_kgm2", "trailer_yaw_inertia_se_kgm2",
        estimates.has("trailer_inertia") & good)  # fmt: skip
    return values


def _code(table: dict[int, str], name: str) -> int:
    return next(code for code, text in table.items() if text == name)


def weighted_mean(
    estimates: Estimates,
    column: str,
    error_column: str,
    mask: BoolArray,
    *,
    filtered: bool = False,
) -> Value | None:
    """Mean weighted by the estimates' own errors.

    Neighbouring windows overlap, so the error of the mean counts one independent estimate for each
    length of a window, and is not below what the scatter says. What the core has `filtered` over
    all windows already (the model and its critical speed) gains nothing from a mean.
    """
    if not mask.any():
        return None
    value, error = estimates[column][mask], np.maximum(estimates[error_column][mask], 1e-12)
    weight = 1.0 / (error**2 + np.median(error) ** 2 * 0.01)
    mean = float(np.sum(weight * value) / np.sum(weight))
    scatter = float(np.sqrt(np.sum(weight * (value - mean) ** 2) / np.sum(weight)))
    time = np.sort(estimates.time_s[mask])
    window = float(np.median(estimates["window_s"][mask]))
    step = float(np.median(np.diff(time))) if len(time) > 1 else window
    independent = 1.0 if filtered else max(1.0, len(time) * step / max(window, step))
    typical = float(1.0 / np.sqrt(np.mean(1.0 / error**2)))
    return Value(
        mean, max(typical, scatter) / float(np.sqrt(independent)), int(mask.sum()), scatter
    )


def damping_gap(values: dict[str, Value]) -> float | None:
    """Measured minus modelled damping ratio, where they differ beyond their errors; else None."""
    measured, model = values.get("damping_ratio"), values.get("model_damping_ratio")
    if measured is None or model is None:
        return None
    gap = measured.value - model.value
    error = math.hypot(measured.error, model.error)
    return gap if abs(gap) > max(0.015, 3.0 * error) else None


def shifted_critical_speed(result: DriveResult, speed_m_s: float) -> float | None:
    """Speed at which the model's damping, shifted by the gap to the measured one, reaches 0."""
    gap = damping_gap(result.values)
    if gap is None:
        return None
    speeds = np.linspace(0.4, 2.0, 321) * speed_m_s
    stiffness = {
        axle: result.values[f"{axle}.cornering_stiffness_n_per_rad"].value
        for axle in AXLES
        if f"{axle}.cornering_stiffness_n_per_rad" in result.values
    }
    damping, _ = model_damping(result.vehicle, speeds, stiffness)
    below = np.flatnonzero(damping + gap <= 0.0)
    return float(speeds[below[0]]) if len(below) and below[0] > 0 else None


def alarm_intervals(estimates: Estimates, end_s: float) -> list[AlarmInterval]:
    """Stretches of equal alarm state, with every reason given in each."""
    if not len(estimates):
        return []
    state, reasons = estimates.status["alarm"], estimates.status["reasons"]
    time = estimates["time_s"]  # when the state was reported, not the middle of the window
    edges = [0, *(np.flatnonzero(np.diff(state)) + 1).tolist(), len(state)]
    intervals = []
    for start, stop in itertools.pairwise(edges):
        bits = int(np.bitwise_or.reduce(reasons[start:stop]))
        names = tuple(name for name, bit in REASON.items() if bits & bit)
        until = float(time[stop]) if stop < len(state) else max(end_s, float(time[-1]))
        intervals.append(AlarmInterval(float(time[start]), until, ALARM[int(state[start])], names))
    return intervals


def _lacking(
    drive: Drive, vehicle: Vehicle, estimates: Estimates
) -> tuple[list[tuple[str, tuple[str, ...]]], list[tuple[str, tuple[str, ...]]]]:
    """Results that cannot be had, and those had indirectly, with the channels they lack.

    Without force sensors the core takes forces from the balances of the bodies, with the masses and
    inertias of the vehicle.toml: such results are there, but rest on more beliefs.
    """
    off, indirect = [], []
    for result, bit, needed in NEEDS:
        if not _concerns(vehicle, result, bit):
            continue
        lacking = tuple(name for name in needed if name not in drive.channels)
        if vehicle.trailer is None:
            lacking = tuple(n for n in lacking if not n.startswith(("hitch", "trailer")))
        if lacking and bit and len(estimates) and estimates.has(bit).any():
            indirect.append((result, lacking))
        elif lacking:
            off.append((result, lacking))
    return off, indirect


def _concerns(vehicle: Vehicle, result: str, bit: str) -> bool:
    """Whether the vehicle has what the result is about."""
    if vehicle.trailer is None:
        return "trailer" not in result
    single = vehicle.trailer.front_axle_to_cog is None
    return not (single and bit.startswith("trailer_front"))


def flag_share(estimates: Estimates) -> dict[str, float]:
    """Part of the estimates that carries each quality flag, largest first; zeros left out."""
    count = max(1, len(estimates))
    shares = {name: float(np.sum(estimates.flagged(name))) / count for name in QUALITY}
    return dict(sorted(((n, s) for n, s in shares.items() if s > 0.0), key=lambda item: -item[1]))


def believed_value(vehicle: Vehicle, name: str) -> float | None:
    """What ``vehicle.toml`` states for a measured value, in its unit; None where it has none."""
    if name == "v_crit_m_s":
        return _believed_critical_m_s(vehicle)
    body, _, inertia = name.partition("_yaw_inertia")
    if inertia:
        found = getattr(getattr(vehicle, body, None), "yaw_inertia", None)
    elif name.endswith(".cornering_stiffness_n_per_rad"):
        body, _, which = name.partition(".")[0].partition("_")
        found = getattr(getattr(vehicle, body, None), f"{which}_cornering_stiffness", None)
    else:
        return None
    return None if found is None else float(found)


def _believed_critical_m_s(vehicle: Vehicle) -> float | None:
    """Speed at which the damping of the vehicle in the file first falls below zero."""
    speed = np.linspace(*SEARCHED_M_S, 241)
    damping, _ = model_damping(vehicle, speed)
    after = np.flatnonzero((damping[1:] <= 0.0) & (damping[:-1] > 0.0))
    if not len(after):
        return None
    k = int(after[0])
    share = damping[k] / (damping[k] - damping[k + 1])
    return float(speed[k] + share * (speed[k + 1] - speed[k]))


def as_json(result: DriveResult) -> dict[str, Any]:
    """The result as plain types, SI units."""
    return {
        "name": result.drive.name,
        "files": [str(path) for path in result.drive.files],
        "formats": list(result.drive.formats),
        "duration_s": round(result.drive.duration_s, 6),
        "frames": result.drive.frames,
        "channels": {
            name: {"signal": c.signal, "unit_in_file": c.unit_in_file, "samples": len(c.value)}
            for name, c in result.drive.channels.items()
        },
        "conclusion": result.sentences,
        "window_oscillations": result.window_oscillations,
        "values": {
            name: {
                "value": v.value,
                "standard_error": v.error,
                "estimates": v.count,
                "believed": believed_value(result.vehicle, name),
            }
            for name, v in result.values.items()
        },
        "critical_speed": {"kind": result.critical_kind, "searched_m_s": list(SEARCHED_M_S)},
        "alarms": [
            {
                "start_s": alarm.start_s,
                "end_s": alarm.end_s,
                "state": alarm.state,
                "reasons": list(alarm.reasons),
            }
            for alarm in result.alarms
        ],
        "findings": [
            {
                "severity": finding.severity,
                "kind": finding.kind,
                "signals": list(finding.signals),
                "text": finding.text,
                "time_s": finding.time_s,
            }
            for finding in result.findings
        ],
        "switched_off": [
            {"result": name, "missing_channels": list(channels)}
            for name, channels in result.switched_off
        ],
        "indirect": [
            {"result": name, "missing_channels": list(channels)}
            for name, channels in result.indirect
        ],
        "balances": result.balances,
        "trailer_from_car": {
            **result.estimates.trailer,
            "presence": PRESENCE.get(result.estimates.trailer.get("presence", -1), "undecided"),
        },
        "estimates": len(result.estimates),
        "fault_count": result.estimates.fault_count,
        "quality_flags": flag_share(result.estimates),
    }
