"""Faults of a sensor that need no model: put right before the fit, and said in the verdict.

:mod:`swaywatch.checks.quality` finds them, for every command alike. Here samples that say nothing
are left out of the fit, what can be put right is put right, and what was found becomes an effect of
the verdict. A constant delay or a moderate gain stays with the modules of the library: these weigh
it against missing physics.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swaywatch.checks.quality import check_drive
from swaywatch.checks.samples import Finding, Window, cleaned, inside, listed
from swaywatch.drive import Channel, Drive
from swaywatch.vehicle import Vehicle

BoolArray = NDArray[np.bool_]

IDS = {
    "spike": "sensor_spikes",
    "stuck": "sensor_frozen",
    "clipped": "sensor_clipped",
    "drift": "sensor_drift",
    "swapped": "sensor_swapped",
    "clock": "sensor_clock",
    "sign_or_unit": "sensor_unit",
}
LINES = {"spike": "broadband", "drift": "mean", "clipped": "f", "stuck": "f"}
TITLES = {
    "sensor_spikes": "Single wrong samples",
    "sensor_frozen": "Signal constant for some time",
    "sensor_clipped": "Signal limited by the measuring range",
    "sensor_drift": "Offset that changes steadily with time",
    "sensor_swapped": "Two signals interchanged",
    "sensor_clock": "Signal recorded with a separate clock",
    "sensor_unit": "Wrong unit",
    "sensor_sign": "Inverted sign",
}
EQUATIONS = {
    "sensor_spikes": "isolated samples far from their neighbours; left out",
    "sensor_frozen": "measured(t) = measured(start); left out",
    "sensor_clipped": "measured = min(max(true, low), high); left out at the ends",
    "sensor_drift": "measured(t) = true(t) + rate t; removed",
    "sensor_swapped": "measured of one = true of the other; swapped back",
    "sensor_clock": "measured(t) = true(t - delay(t)), delay growing evenly; corrected",
    "sensor_unit": "measured = true / factor; corrected",
    "sensor_sign": "measured = -true; corrected",
}
SURE = 0.98
SHARED = 0.55  # where another channel explains the balances as well
SETTLE_S = 1.5  # what the model needs to forget an input that was not there
LEFT_OUT = ("stuck", "clipped", "gap")
MOST_LOST = 0.6  # of a channel: beyond it the rest is left out too
DRIVERS = ("steering_wheel_angle", "speed", "car_yaw_rate", "trailer_yaw_rate")


@dataclass
class SensorFaults:
    """What was found in the runs, in their order in time of driving.

    Attributes
    ----------
    found
        Name of the run and finding.
    lost
        Name of the run to windows of each channel in which it is unusable.
    checks
        Sentences for the report.
    right
        Run and channel that a model which was found shows to have had no drift (see `drifts`).
    """

    found: list[tuple[str, Finding]] = field(default_factory=list)
    lost: dict[str, dict[str, list[Window]]] = field(default_factory=dict)
    checks: list[str] = field(default_factory=list)
    right: frozenset[tuple[str, str]] = frozenset()

    def put_right(self, drive: Drive, vehicle: Vehicle, run: str) -> Drive:
        """The drive as its sensors should have shown it; what was wrong is kept here."""
        findings = [f for f in check_drive(drive, vehicle) if f.kind in (*IDS, "gap")]
        findings = [f for finding in findings for f in self._drifting(finding, run)]
        mine = [f for f in findings if f.kind == "gap" or f.channels]
        fixed = cleaned(drive, mine)
        for finding in mine:
            if finding.kind in IDS:
                self.found.append((run, finding))
                fixed = _repaired(fixed, finding)
            for name in finding.channels if finding.kind in LEFT_OUT else ():
                self.lost.setdefault(run, {}).setdefault(name, []).extend(finding.windows)
            self.checks.append(f"{run}: {_sentence(finding)}")
        self.checks += [f"{run}: {f.text}" for f in findings if f not in mine]
        return fixed

    def _drifting(self, finding: Finding, run: str) -> list[Finding]:
        """The finding, without channels that had no drift; none where none is left."""
        left = tuple(c for c in finding.channels if (run, c) not in self.right)
        if finding.kind != "drift" or left == finding.channels:
            return [finding]
        if left:
            return [replace(finding, channels=left)]
        self.checks.append(f"{run}: {finding.text}; but the fitted model shows no drift")
        return []

    def masks(
        self, run: str, time: NDArray[np.float64], names: Iterable[str]
    ) -> tuple[dict[str, BoolArray], dict[str, BoolArray]]:
        """Where channels of the grid say nothing, and which samples count. Shapes of `time`.

        While an input of the model is missing, and shortly after, no channel counts.
        """
        lost = self.lost.get(run, {})
        blind: list[Window] = [
            (a, b + SETTLE_S)
            for name in DRIVERS
            for a, b in lost.get(name, [])
            if b - a > 0.2 and b - a < MOST_LOST * float(time[-1] - time[0])
        ]
        silent = {name: inside(time, windows) for name, windows in lost.items()}
        kept: dict[str, BoolArray] = {}
        for name in names:
            out = inside(time, [*lost.get(name, []), *blind])
            if out.any():
                kept[name] = ~out
        return silent, kept

    def entries(self, signals: dict[str, str]) -> list[dict[str, Any]]:
        """`effects` of diagnosis.json."""
        groups: dict[tuple[str, tuple[str, ...]], list[tuple[str, Finding]]] = {}
        for run, finding in self.found:
            shown = finding.channels if finding.kind in ("swapped", "clock") else ()
            key = (effect_id(finding), shown or finding.channels[:1])
            groups.setdefault(key, []).append((run, finding))
        return [entry(name, channels, group, signals) for (name, channels), group in groups.items()]


def effect_id(finding: Finding) -> str:
    """Id of the effect that a finding is."""
    if finding.kind == "sign_or_unit" and finding.amount == -1.0:
        return "sensor_sign"
    return IDS[finding.kind]


def entry(
    name: str,
    channels: Sequence[str],
    group: Sequence[tuple[str, Finding]],
    signals: dict[str, str],
) -> dict[str, Any]:
    """One effect from findings of several runs."""
    details: list[dict[str, Any]] = [
        {"run": run, "start": a, "stop": b} for run, finding in group for a, b in finding.windows
    ]
    first = group[0][1]
    others = first.channels[1:] if name not in ("sensor_swapped", "sensor_clock") else ()
    named = [signals.get(channel, channel) for channel in channels]
    return {
        "id": name,
        "parameters": _parameters(name, [finding for _, finding in group]),
        "component": " and ".join(named),
        "role": channels[0],
        "channel": named[0],
        "channels": named,
        "windows": [[round(d["start"], 3), round(d["stop"], 3)] for d in details],
        "window_details": details,
        "lines": [LINES.get(first.kind, "broadband")],
        "confidence": SHARED if others else SURE,
        "equivalent": [name] if others else [],
        "equivalent_details": [f"{name}:{signals.get(c, c)}" for c in others],
        "distinguished_by": "a second sensor of the same quantity" if others else "",
        "equation": EQUATIONS[name],
        "source": "fault of the measurement",
        "kind": "measurement",
        "text": [f"{run}: {finding.text}" for run, finding in group],
        "fit": {},
    }


def combined(verdict: str, faults: Sequence[dict[str, Any]]) -> str:
    """The verdict on runs that had such faults; what is missing behind them comes first."""
    return "measurement_fault" if faults and verdict == "consistent" else verdict


def _parameters(name: str, found: Sequence[Finding]) -> dict[str, dict[str, float]]:
    if name in ("sensor_spikes", "sensor_frozen", "sensor_clipped"):
        key, value = "count", float(sum(len(f.windows) for f in found))
    elif name == "sensor_swapped":
        return {}
    elif name == "sensor_drift":
        key, value = "rate_per_s", float(np.mean([f.amount for f in found]))
    elif name == "sensor_clock":
        key, value = "delay_per_s", float(np.mean([f.amount for f in found]))
    else:
        key, value = "factor", 1.0 / found[0].amount
    values = [f.amount for f in found] if name in ("sensor_drift", "sensor_clock") else [value]
    return {key: {"value": value, "low": float(min(values)), "high": float(max(values))}}


def _sentence(finding: Finding) -> str:
    """What was done about it."""
    if finding.kind in ("spike", "stuck", "clipped"):
        return f"{finding.text}; left out of the fit"
    if finding.kind == "gap":
        return f"{finding.signals[0]}: no sample {listed(finding.windows)}; left out of the fit"
    return f"{finding.text}; corrected before the fit"


def _repaired(drive: Drive, finding: Finding) -> Drive:
    """The drive with a channel put right."""
    channels = dict(drive.channels)
    if finding.kind == "swapped":
        first, second = finding.channels
        channels[first] = _with_samples_of(channels[first], channels[second])
        channels[second] = _with_samples_of(drive.channels[second], drive.channels[first])
    for name in finding.channels if finding.kind in ("sign_or_unit", "drift", "clock") else ():
        channel = channels[name]
        if finding.kind == "sign_or_unit":
            channel = replace(channel, value=channel.value * finding.amount)
        elif finding.kind == "drift":
            ramp = finding.amount * (channel.time_s - finding.windows[0][0])
            channel = replace(channel, value=channel.value - ramp)
        else:
            channel = replace(channel, time_s=channel.time_s * (1.0 - finding.amount))
        channels[name] = channel
        if finding.kind != "clock":
            break  # the others would explain it as well
    return replace(drive, channels=channels)


def _with_samples_of(channel: Channel, other: Channel) -> Channel:
    return replace(channel, time_s=other.time_s, value=other.value, signal=other.signal)
