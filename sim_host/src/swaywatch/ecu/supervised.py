"""What the core's supervision has found, in words: a broken sensor, or another vehicle.

The core checks the relations between its inputs as it reads them (``lib/judge/sway_supervise.h``)
and says code, size and standard error of its last finding in every status and in the frame
``SwayFinding``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from swaywatch.checks.samples import Finding
from swaywatch.ecu._core import lib
from swaywatch.ecu.core import Estimates

CHANNELS: dict[int, tuple[str, str]] = {
    0: ("steering_wheel_angle", "the steering wheel angle"),
    1: ("car_yaw_rate", "the car's yaw rate"),
    2: ("car_lateral_acceleration", "the car's lateral acceleration"),
    3: ("trailer_yaw_rate", "the trailer's yaw rate"),
    4: ("trailer_lateral_acceleration", "the trailer's lateral acceleration"),
    5: ("articulation_angle", "the articulation angle"),
    7: ("hitch_fy", "the lateral hitch force"),
    8: ("car_front_fy", "the lateral force of the car's front axle"),
    9: ("car_rear_fy", "the lateral force of the car's rear axle"),
    12: ("trailer_front_fy", "the lateral force of the trailer's front axle"),
    13: ("trailer_rear_fy", "the lateral force of the trailer's rear axle"),
}
"""Role and name of the channels that can be rejected, by ``sway_channel_t``."""

VEHICLE: dict[int, tuple[str, float, str]] = {
    2: ("stiffness of the car's front tyres", 100.0, "%"),
    3: ("stiffness of the car's rear tyres", 100.0, "%"),
    4: ("stiffness of the trailer's tyres", 100.0, "%"),
    5: ("centre of gravity of the trailer, to the front,", 1000.0, "mm"),
    6: ("dry friction at the hitch", 100.0, "Nm"),
}
"""What of the vehicle can differ (``sway_finding_t``): name, factor and unit of its size."""

RELATIONS = (
    "articulation rate",
    "motion of the ball",
    "lateral balance of the car",
    "yaw balance of the car",
    "lateral balance of the trailer",
    "yaw balance of the trailer",
    "car front axle",
    "car rear axle",
    "trailer front axle",
    "trailer rear axle",
)
"""Relations between the inputs, by ``sway_relation_t``."""

BREAKS = int(lib.SWAY_RELATION_BREAKS)

GAIN, DELAY, OFFSET = 16, 32, 48
"""Bases of the codes of a sensor's findings; the channel is added."""


def words(code: int, size: float, error: float) -> str:
    """One sentence of a finding.

    Parameters
    ----------
    code
        ``sway_finding_t``, not 0.
    size, error
        As the core says them, in units of one (its integers times 1e-6).
    """

    def amount(factor: float, unit: str) -> str:
        digits = 0 if abs(error * factor) >= 1.0 else 1
        return f"{size * factor:+.{digits}f} ± {error * factor:.{digits}f} {unit}"

    if code >= GAIN:
        base = max(b for b in (GAIN, DELAY, OFFSET) if b <= code)
        _, name = CHANNELS[code - base]
        if base == GAIN:
            return f"{name} has a gain error of {amount(100.0, '%')}"
        if base == DELAY:
            return f"{name} is late by {amount(1000.0, 'ms')}"
        turns = code - base in (1, 3)
        return f"{name} has an offset of " + (
            amount(180.0 / np.pi, "deg/s") if turns else amount(1.0, "m/s2")
        )
    if code in VEHICLE:
        name, factor, unit = VEHICLE[code]
        return f"the vehicle is not the one configured: {name} {amount(factor, unit)}"
    return f"the true speed differs from the measured one by {amount(100.0, '%')}"


def findings_text(status: npt.NDArray[Any]) -> str:
    """The last finding of statuses (structured, shape (n,)) in words; empty where there is none."""
    if not len(status) or status["finding"][-1] == 0:
        return ""
    last = status[-1]
    text = words(
        int(last["finding"]),
        float(last["finding_size_micro"]) * 1e-6,
        float(last["finding_se_micro"]) * 1e-6,
    )
    left_out = [n for c, (_, n) in CHANNELS.items() if int(last["rejected_inputs"]) >> c & 1]
    return text + (f"; rejected since the finding: {', '.join(left_out)}" if left_out else "")


def broken(status: npt.NDArray[Any]) -> list[str]:
    """Relations that break at the end of statuses (structured, shape (n,)), with their sizes.

    Each status tells of one relation, in turn; size and deviation are shares of the relation's
    terms, and beyond three deviations it breaks.
    """
    newest: dict[int, Any] = {int(row["relation"]) % 256: row for row in status}
    return [
        f"{RELATIONS[number]} ({row['relation_ppm'] * 1e-4:.0f} % of its terms, "
        f"{row['relation_se_ppm'] * 1e-4:.0f} % by tolerances)"
        for number, row in sorted(newest.items())
        if int(row["relation"]) // 256 == BREAKS
    ]


def findings_of(estimates: Estimates) -> list[Finding]:
    """What the supervision found in a drive, as a finding of its page."""
    text = findings_text(estimates.status)
    if not text:
        return []
    breaks = broken(estimates.status)
    text += f"; violated relations: {', '.join(breaks)}" if breaks else ""
    rejected = int(estimates.status["rejected_inputs"][-1])
    roles = tuple(role for c, (role, _) in CHANNELS.items() if rejected >> c & 1)
    first = int(np.flatnonzero(estimates.status["finding"])[0])
    return [
        Finding(
            "warning",
            "supervision",
            (),
            f"The ECU's supervision: {text}.",
            float(estimates.status["time_us"][first]) * 1e-6,
            channels=roles,
        )
    ]
