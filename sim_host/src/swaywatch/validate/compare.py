"""Recording beside simulation, line by line, after the 5 % criterion of 5.2.4.

Compared are the estimates of the C core at the same times of the drive, so that a load or a
frequency that changes along the drive changes on both sides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from swaywatch.analysis import AXLE_NAMES, DriveResult, usable
from swaywatch.drive import Drive
from swaywatch.ecu.core import AXLES, Estimates

Array = NDArray[np.float64]

CRITERION = 0.05
"""Of the experiment's value (5.2.4)."""
LEAST_DAMPING_RATIO = 0.1
"""A damping ratio near 0 is compared with 5 % of this one: near 0 no share means anything."""
SAME_TIME_S = 0.1
"""Estimates of both sides belong together when the middles of their windows are this near."""
SURE = 2.0
"""Standard errors by which a difference has to be clear of the criterion to be called sure."""

Outcome = Literal["within", "perhaps within", "perhaps beyond", "beyond", "not compared"]


@dataclass(frozen=True)
class MeanValue:
    """A mean with its standard error."""

    value: float
    error: float


@dataclass(frozen=True)
class ComparedLine:
    """One line of the comparison.

    Attributes
    ----------
    key
        ``car_rear.cornering_stiffness`` and so on.
    name, unit, factor
        For people; values times `factor` are in `unit`.
    kind
        ``parameter`` (of the vehicle, can be corrected), ``state`` (of the motion), ``limit``.
    recording, simulation
        Means over the same times; None where that side has no estimate.
    difference, error
        Simulation minus recording, and its standard error.
    allowed
        What the criterion allows.
    """

    key: str
    name: str
    unit: str
    factor: float
    kind: str
    recording: MeanValue | None
    simulation: MeanValue | None
    difference: float = math.nan
    error: float = math.nan
    allowed: float = math.nan

    @property
    def outcome(self) -> Outcome:
        """Within or beyond the criterion, and whether that is certain."""
        if not (math.isfinite(self.difference) and self.allowed > 0.0):
            return "not compared"
        size, half_width = abs(self.difference), SURE * self.error
        if size <= self.allowed:
            return "within" if size + half_width <= self.allowed else "perhaps within"
        return "beyond" if size - half_width > self.allowed else "perhaps beyond"

    @property
    def passed(self) -> bool:
        """Within the criterion, surely or perhaps, or not to be compared."""
        return self.outcome in ("within", "perhaps within", "not compared")


@dataclass(frozen=True)
class _Quantity:
    key: str
    name: str
    unit: str
    factor: float
    kind: str
    column: str
    error_column: str
    valid: str
    rule: str  # "share", "damping", "angle", "load"
    free_only: bool = False


def _quantities() -> list[_Quantity]:
    deg = 180.0 / math.pi
    found = [
        _Quantity("frequency", "frequency of the oscillation", "Hz", 1.0, "state",
                  "frequency_hz", "frequency_se_hz", "line", "share", free_only=True),
        _Quantity("damping_ratio", "damping ratio, free", "–", 1.0, "state",
                  "damping_ratio", "damping_ratio_se", "line", "damping", free_only=True),
        _Quantity("v_crit", "critical speed", "km/h", 3.6, "limit",
                  "v_crit_m_s", "v_crit_se_m_s", "critical_speed", "share"),
    ]  # fmt: skip
    for axle in AXLES:
        name = AXLE_NAMES[axle]
        found += [
            _Quantity(f"{axle}.cornering_stiffness", f"cornering stiffness, {name}", "kN/rad",
                      1e-3, "parameter", f"{axle}.cornering_stiffness_n_per_rad",
                      f"{axle}.cornering_stiffness_se_n_per_rad", axle, "share"),
            _Quantity(f"{axle}.argument", f"argument of the stiffness, {name}", "deg", deg, "state",
                      f"{axle}.argument_rad", f"{axle}.argument_se_rad", axle, "angle"),
            _Quantity(f"{axle}.effective_load", f"effective load, {name}", "N", 1.0, "state",
                      f"{axle}.effective_load_n", f"{axle}.effective_load_se_n", f"{axle}_load",
                      "share"),
            _Quantity(f"{axle}.load_harmonic", f"load at twice the frequency, {name}", "N", 1.0,
                      "state", f"{axle}.load_harmonic_n", f"{axle}.effective_load_se_n",
                      f"{axle}_load", "load"),
        ]  # fmt: skip
    for body in ("car", "trailer"):
        found.append(
            _Quantity(f"{body}.yaw_inertia", f"yaw inertia, {body}", "kg m²", 1.0, "parameter",
                      f"{body}_yaw_inertia_kgm2", f"{body}_yaw_inertia_se_kgm2",
                      f"{body}_inertia", "share")
        )  # fmt: skip
    found += [
        _Quantity("trailer.yaw_inertia_1", "yaw inertia, trailer, method 1 (Eq. 4.20)", "kg m²",
                  1.0, "state", "trailer_yaw_inertia_1_kgm2", "trailer_yaw_inertia_se_kgm2",
                  "trailer_inertia_1", "share"),
        _Quantity("trailer.yaw_inertia_2", "yaw inertia, trailer, method 2 (Eq. 4.23)", "kg m²",
                  1.0, "state", "trailer_yaw_inertia_2_kgm2", "trailer_yaw_inertia_se_kgm2",
                  "trailer_inertia_2", "share"),
    ]  # fmt: skip
    return found


def compare(recording: DriveResult, simulation: DriveResult) -> list[ComparedLine]:
    """Every line that both sides, or at least one, can say something about."""
    ours, theirs = _together(recording.estimates, simulation.estimates)
    lines = []
    for quantity in _quantities():
        line = _line(quantity, recording, simulation, ours, theirs)
        if line is not None:
            lines.append(line)
    return lines + _static_loads(recording.drive, simulation.drive)


def _together(first: Estimates, second: Estimates) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Indices of estimates of both whose windows have the same middle. Shapes (n,)."""
    if not len(first) or not len(second):
        none = np.zeros(0, dtype=np.intp)
        return none, none
    after = np.searchsorted(second.time_s, first.time_s).clip(1, max(1, len(second) - 1))
    before = after - 1
    late = np.minimum(after, len(second) - 1)
    near = np.where(
        np.abs(second.time_s[before] - first.time_s) < np.abs(second.time_s[late] - first.time_s),
        before, late,
    )  # fmt: skip
    good = np.abs(second.time_s[near] - first.time_s) <= SAME_TIME_S
    return np.flatnonzero(good), near[good]


def _valid(result: DriveResult, quantity: _Quantity) -> NDArray[np.bool_]:
    estimates = result.estimates
    mask = usable(estimates) & estimates.has(quantity.valid)
    if quantity.free_only:
        mask &= ~estimates.flagged("forced")
    return np.asarray(mask)


def _line(
    quantity: _Quantity,
    recording: DriveResult,
    simulation: DriveResult,
    ours: NDArray[np.intp],
    theirs: NDArray[np.intp],
) -> ComparedLine | None:
    first, second = recording.estimates, simulation.estimates
    if not len(first) or not len(second):
        return None
    mine, other = _valid(recording, quantity), _valid(simulation, quantity)
    both = mine[ours] & other[theirs] if ours.size else np.zeros(0, dtype=bool)
    if not both.any():
        if not mine.any() and not other.any():
            return None
        return ComparedLine(quantity.key, quantity.name, quantity.unit, quantity.factor,
            quantity.kind,
                    _alone(first, quantity, mine), _alone(second, quantity, other))  # fmt: skip
    at, there = ours[both], theirs[both]
    a, b = first[quantity.column][at], second[quantity.column][there]
    error = np.hypot(first[quantity.error_column][at], second[quantity.error_column][there])
    error = np.maximum(error, 1e-12)
    difference = b - a
    if quantity.rule == "angle":
        difference = np.angle(np.exp(1j * difference))
    weight = 1.0 / (error**2 + 0.01 * np.median(error) ** 2)
    mean, spread = _mean(difference, weight)
    independent = 1.0 if quantity.kind == "limit" else _independent(first, at)
    typical = float(1.0 / np.sqrt(np.mean(1.0 / error**2)))
    own, _ = _mean(a, weight)
    recorded, simulated = (
        MeanValue(
            _mean(value, weight)[0],
            float(np.median(side[quantity.error_column][index])) / math.sqrt(independent),
        )
        for value, side, index in ((a, first, at), (b, second, there))
    )
    return ComparedLine(
        quantity.key, quantity.name, quantity.unit, quantity.factor,
            quantity.kind,
        recorded, simulated, difference=mean, error=max(typical, spread) / math.sqrt(independent),
        allowed=_allowed(quantity, own, first, at),
    )  # fmt: skip


def _allowed(
    quantity: _Quantity, recorded: float, estimates: Estimates, at: NDArray[np.intp]
) -> float:
    if quantity.rule == "damping":
        return CRITERION * max(abs(recorded), LEAST_DAMPING_RATIO)
    if quantity.rule == "angle":
        return CRITERION  # of |C|, turned by the angle: 5 % in the complex plane
    if quantity.rule == "load":
        axle = quantity.key.partition(".")[0]
        return CRITERION * float(np.mean(estimates[f"{axle}.load_n"][at]))
    return CRITERION * abs(recorded)


def _mean(value: Array, weight: Array) -> tuple[float, float]:
    mean = float(np.sum(weight * value) / np.sum(weight))
    return mean, float(np.sqrt(np.sum(weight * (value - mean) ** 2) / np.sum(weight)))


def _independent(estimates: Estimates, at: NDArray[np.intp]) -> float:
    """Windows overlap: one independent estimate for each length of a window."""
    time = estimates.time_s[at]
    window = float(np.median(estimates["window_s"][at]))
    step = float(np.median(np.diff(time))) if time.size > 1 else window
    return max(1.0, time.size * step / max(window, step))


def _alone(estimates: Estimates, quantity: _Quantity, mask: NDArray[np.bool_]) -> MeanValue | None:
    """Mean of one side where the other has nothing."""
    if not mask.any():
        return None
    error = np.maximum(estimates[quantity.error_column][mask], 1e-12)
    return MeanValue(
        _mean(estimates[quantity.column][mask], 1.0 / error**2)[0], float(np.median(error))
    )


def _static_loads(recording: Drive, simulation: Drive) -> list[ComparedLine]:
    """Mean axle loads, measured and simulated."""
    lines = []
    for axle in AXLES:
        prefix = "trailer_" if axle.startswith("trailer") else ""
        wheels = ("fl", "fr") if axle.endswith("front") else ("rl", "rr")
        names = [f"{prefix}wheel_vertical_load_{wheel}" for wheel in wheels]
        if not all(n in recording.channels and n in simulation.channels for n in names):
            continue
        sides = []
        for drive in (recording, simulation):
            values = [drive.channels[name].value for name in names]
            # the load swings with the drive: the spread of the means of its quarters says how much
            # of that a mean over the drive keeps
            quarters = [sum(float(np.mean(q)) for q in pair) for pair in _quarters(values)]
            total = float(np.mean(values[0]) + np.mean(values[1]))
            sides.append(MeanValue(total, float(np.std(quarters)) / 2.0))
        lines.append(
            ComparedLine(f"{axle}.axle_load", f"static load, {AXLE_NAMES[axle]}", "N", 1.0,
            "parameter",
                 sides[0], sides[1], sides[1].value - sides[0].value,
                 math.hypot(sides[0].error, sides[1].error), CRITERION * abs(sides[0].value))
        )  # fmt: skip
    return lines


def _quarters(values: list[Array]) -> list[tuple[Array, ...]]:
    """Each channel in four parts, the parts of all channels together."""
    return list(zip(*(np.array_split(value, 4) for value in values), strict=True))
