"""What to correct in the vehicle, from the lines of the comparison."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from swaywatch.validate.compare import SURE, ComparedLine
from swaywatch.vehicle import Vehicle

WORTH = 0.005
"""Relative change below which a value is not changed."""
MOST = 2.0
"""Largest factor of one correction: beyond it the belief was of another vehicle."""

LEAST_LAG_RAD = 0.01
"""An argument that differs by less needs no lag."""
LEAST_LENGTH_M = 0.02
RELAXATION = "relaxation_length"

_FIELDS = {
    "cornering_stiffness": "{which}_cornering_stiffness",
    "axle_load": "{which}_axle_load",
}


@dataclass(frozen=True)
class Correction:
    """One value of the vehicle, before and after.

    Attributes
    ----------
    key
        As in vehicle.toml, ``car.rear_cornering_stiffness``.
    before, after
        SI units.
    error
        Standard error of `after`.
    """

    key: str
    before: float
    after: float
    error: float

    @property
    def share(self) -> float:
        """Relative change."""
        return self.after / self.before - 1.0 if self.before else math.inf


def field_of(line: ComparedLine) -> str | None:
    """Key of vehicle.toml that a line can correct, or None."""
    if line.kind != "parameter":
        return None
    place, _, what = line.key.partition(".")
    if what == "yaw_inertia":
        return f"{place}.yaw_inertia"
    body, _, which = place.partition("_")
    return f"{body}.{_FIELDS[what].format(which=which)}"


def corrections(vehicle: Vehicle, drives: Sequence[Sequence[ComparedLine]]) -> list[Correction]:
    """Values that all drives together say are off.

    The ratio of both sides, not the recording's own estimate, corrects a value: what the method
    errs by on both sides drops out. Drives are weighted by their errors.
    """
    ratios: dict[str, list[tuple[float, float]]] = {}
    for lines in drives:
        for line in lines:
            key = field_of(line)
            if key is None or line.recording is None or line.simulation is None:
                continue
            if not math.isfinite(line.difference) or line.simulation.value <= 0.0:
                continue
            ratio = line.recording.value / line.simulation.value
            ratios.setdefault(key, []).append((ratio, line.error / line.simulation.value))
    found = []
    for key, pairs in ratios.items():
        before = value_of(vehicle, key)
        if before is None:
            continue
        weights = [1.0 / (error**2 + 1e-8) for _, error in pairs]
        ratio = sum(w * r for w, (r, _) in zip(weights, pairs, strict=True)) / sum(weights)
        error = _error([r for r, _ in pairs], weights, ratio)
        if abs(ratio - 1.0) > max(WORTH, SURE * error):
            factor = min(max(ratio, 1.0 / MOST), MOST)
            found.append(Correction(key, before, before * factor, before * error))
    return found


def _error(ratios: Sequence[float], weights: Sequence[float], mean: float) -> float:
    """Standard error of the weighted mean; larger where the drives contradict each other."""
    error = 1.0 / math.sqrt(sum(weights))
    if len(ratios) < 2:
        return error
    chi2 = sum(w * (r - mean) ** 2 for w, r in zip(weights, ratios, strict=True))
    return error * math.sqrt(max(1.0, chi2 / (len(ratios) - 1)))


@dataclass(frozen=True)
class OperatingPoint:
    """Where a drive was compared: mean speed (m/s) and angular frequency (rad/s)."""

    speed_m_s: float
    omega_rad_s: float


def lags(
    lengths: Mapping[str, float],
    drives: Sequence[Sequence[ComparedLine]],
    motions: Sequence[OperatingPoint],
) -> list[Correction]:
    """Relaxation lengths (m) that give the axles' forces the lag which the recording has.

    sigma = v tan(-arg C) / omega, from the argument of Eq. 4.9. Whether the lag is the tyre's, the
    suspension's or a delayed sensor's cannot be said from one line; a length stands for it.

    Parameters
    ----------
    lengths
        Of the simulation, by axle.
    drives, motions
        The comparison of each drive, and where it was made.
    """
    pairs: dict[str, list[tuple[float, float]]] = {}
    for lines, motion in zip(drives, motions, strict=True):
        for line in lines:
            axle, _, what = line.key.partition(".")
            if what != "argument" or not math.isfinite(line.difference):
                continue
            turn = motion.omega_rad_s / motion.speed_m_s
            late = math.atan(turn * lengths.get(axle, 0.0)) + line.difference
            length = math.tan(min(max(late, 0.0), 1.4)) / turn
            pairs.setdefault(axle, []).append((length, line.error / turn))
    found = []
    for axle, values in pairs.items():
        weights = [1.0 / (error**2 + 1e-8) for _, error in values]
        after = sum(w * v for w, (v, _) in zip(weights, values, strict=True)) / sum(weights)
        error = _error([v for v, _ in values], weights, after)
        before = lengths.get(axle, 0.0)
        turn = sum(m.omega_rad_s / m.speed_m_s for m in motions) / len(motions)
        if abs(after - before) * turn > max(LEAST_LAG_RAD, SURE * error * turn):
            after = after if after > LEAST_LENGTH_M else 0.0
            found.append(Correction(f"{axle}.{RELAXATION}", before, after, error))
    return found


def physics_of(lengths: Mapping[str, float]) -> list[dict[str, Any]]:
    """Relaxation lengths as physics of a scenario."""
    return [
        {"id": "tyre_relaxation", "axle": axle, "length_m": length}
        for axle, length in lengths.items()
        if length > 0.0
    ]


def value_of(vehicle: Vehicle, key: str) -> float | None:
    """Value of a key such as ``trailer.yaw_inertia``."""
    body, _, name = key.partition(".")
    part = getattr(vehicle, body)
    value = None if part is None else getattr(part, name)
    return None if value is None else float(value)


def corrected(vehicle: Vehicle, changes: Sequence[Correction]) -> Vehicle:
    """The vehicle with new values; a lag is none of its values."""
    for change in changes:
        if change.key.endswith(RELAXATION):
            continue
        body, _, name = change.key.partition(".")
        part = dataclasses.replace(getattr(vehicle, body), **{name: change.after})
        vehicle = dataclasses.replace(vehicle, **{body: part})
    return vehicle


def as_toml(vehicle: Vehicle, original: Vehicle, source: str) -> str:
    """``vehicle.toml`` of a corrected vehicle; each changed value says what it was.

    Parameters
    ----------
    source
        Where the values come from, one line of text.
    """
    lines = [f"# {source}"]
    for body in ("car", "trailer"):
        part, before = getattr(vehicle, body), getattr(original, body)
        if part is None:
            continue
        lines += ["", f"[{body}]"]
        for field in dataclasses.fields(part):
            value = getattr(part, field.name)
            if not isinstance(value, (int, float)):
                continue
            was = getattr(before, field.name)
            note = (
                "" if was == value else f"  # was {was:.6g} ({100.0 * (value / was - 1.0):+.1f} %)"
            )
            lines.append(f"{field.name} = {value:.7g}{note}")
    return "\n".join(lines) + "\n"


def write(vehicle: Vehicle, original: Vehicle, source: str, path: Path) -> None:
    """Write the corrected ``vehicle.toml``, whole or not at all."""
    from swaywatch.recording.guard import whole_file

    with whole_file(path) as temporary:
        temporary.write_text(as_toml(vehicle, original, source), encoding="utf-8")
