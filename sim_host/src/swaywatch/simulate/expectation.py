"""What a HIL drive has to show, and whether it did: ``[expect]`` of a scenario.

Every key is one verdict, beside "the ECU answers"; none of them is asked for by itself::

    [expect]
    alarm = "warning"            # this state or a higher one is reached,
    alarm_by_s = 8.0             # not later than this (default: at any time)
    no_alarm = "notice"          # for a quiet drive: neither this state nor a higher one
    largest_swing_deg_s = 30.0   # yaw rate of the trailer (of a car alone), never above
    last_swing_deg_s = 2.0       # the same in the last second
    final_speed_kmh = 110.0      # at the end, not above
    latest_cycle_ms = 50.0       # the loop itself: no cycle later than this
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from swaywatch.ecu.core import ALARM
from swaywatch.recording.guard import whole_file
from swaywatch.simulate.closed_loop import LoopResult
from swaywatch.simulate.table import Table

WORDS = tuple(ALARM[state] for state in sorted(ALARM))
"""Alarm states from the lowest on."""


@dataclass(frozen=True)
class Requirement:
    """One thing that was wanted.

    Attributes
    ----------
    name : what, as a sentence
    passed : did it happen
    seen : what happened
    """

    name: str
    passed: bool
    seen: str


@dataclass(frozen=True)
class _Limit:
    """A key with a number: range, unit, sentence."""

    key: str
    high: float
    unit: str
    sentence: str


_LIMITS = (
    _Limit("largest_swing_deg_s", 200.0, "deg/s", "the swing never exceeds"),
    _Limit("last_swing_deg_s", 200.0, "deg/s", "the swing of the last second stays below"),
    _Limit("final_speed_kmh", 300.0, "km/h", "the speed at the end is at most"),
    _Limit("latest_cycle_ms", 60000.0, "ms", "no cycle of the loop is later than"),
)


class Expectation:
    """``[expect]`` of a scenario.

    Raises
    ------
    ScenarioError
        A key is not known, or a value out of its range.
    """

    def __init__(self, table: Table) -> None:
        self._alarm = self._state(table, "alarm")
        self._no_alarm = self._state(table, "no_alarm")
        self._by_s = table.number("alarm_by_s", 0.0, 86400.0, "s", np.inf) if (
            table.has("alarm_by_s")) else np.inf  # fmt: skip
        self._limits = [
            (limit, table.number(limit.key, 0.0, limit.high, limit.unit))
            for limit in _LIMITS
            if table.has(limit.key)
        ]
        for limit in _LIMITS:
            table.raw(limit.key)
        table.raw("alarm_by_s")
        self.is_given = bool(table.keys())
        table.done()

    @staticmethod
    def _state(table: Table, key: str) -> int | None:
        return WORDS.index(table.word(key, WORDS[2:])) if table.has(key) else table.raw(key)

    def judge(self, result: LoopResult) -> list[Requirement]:
        """Every verdict on a drive, in the order of the module's text."""
        answered = Requirement(
            "the ECU answers", result.status_frames > 0, f"{result.status_frames} alarm frames"
        )
        return [answered, *self._alarms(result), *self._numbers(result)]

    def _alarms(self, result: LoopResult) -> Iterator[Requirement]:
        worst = max((state for _, state in result.alarms), default=0)
        said = f"highest state: {WORDS[worst]}" if result.alarms else "no alarm frame"
        if self._alarm is not None:
            at = next((time for time, state in result.alarms if state >= self._alarm), None)
            by = f" by {self._by_s:g} s" if np.isfinite(self._by_s) else ""
            yield Requirement(
                f"{WORDS[self._alarm]} or more{by}",
                at is not None and at <= self._by_s,
                said if at is None else f"at {at:.2f} s",
            )
        if self._no_alarm is not None:
            quiet = bool(result.alarms) and worst < self._no_alarm
            yield Requirement(f"never {WORDS[self._no_alarm]}", quiet, said)

    def _numbers(self, result: LoopResult) -> Iterator[Requirement]:
        swing = np.degrees(result.swing_rad_s) if result.swing_rad_s else np.array([np.inf])
        late = result.feed.lateness_s
        seen = {
            "largest_swing_deg_s": float(swing.max()),
            "last_swing_deg_s": float(swing[-1]),
            "final_speed_kmh": 3.6 * result.speed_m_s,
            "latest_cycle_ms": 1e3 * max(late) if late else np.inf,
        }
        for limit, most in self._limits:
            value = seen[limit.key]
            name = f"{limit.sentence} {most:g} {limit.unit}"
            yield Requirement(name, value <= most, f"{value:.1f} {limit.unit}")


def as_json(scenario: str, result: LoopResult, verdicts: list[Requirement]) -> dict[str, Any]:
    """The drive and its verdicts, for ``--json``."""
    late = result.feed.lateness_s
    return {
        "scenario": scenario,
        "passed": all(verdict.passed for verdict in verdicts),
        "verdicts": [asdict(verdict) for verdict in verdicts],
        "alarms": [{"time_s": time, "state": WORDS[state]} for time, state in result.alarms],
        "reacted_s": result.reacted_s,
        "largest_swing_deg_s": [float(v) for v in np.degrees(result.swing_rad_s)],
        "final_speed_kmh": 3.6 * result.speed_m_s,
        "frames_sent": result.feed.sent,
        "status_frames": result.status_frames,
        "latest_cycle_ms": 1e3 * max(late) if late else None,
    }


def write_junit(path: Path, scenario: str, result: LoopResult, verdicts: list[Requirement]) -> None:
    """Write the verdicts as JUnit's XML, which test benches and CI servers read."""
    failures = sum(not verdict.passed for verdict in verdicts)
    suite = ElementTree.Element(
        "testsuite", name=f"swaywatch hil {scenario}", tests=str(len(verdicts)),
        failures=str(failures), errors="0", skipped="0", time=f"{len(result.swing_rad_s)}",
    )  # fmt: skip
    for verdict in verdicts:
        case = ElementTree.SubElement(suite, "testcase", classname=scenario, name=verdict.name)
        if verdict.passed:
            ElementTree.SubElement(case, "system-out").text = verdict.seen
        else:
            ElementTree.SubElement(case, "failure", message=verdict.seen)
    root = ElementTree.Element("testsuites")
    root.append(suite)
    with whole_file(path) as temporary:
        ElementTree.ElementTree(root).write(temporary, encoding="utf-8", xml_declaration=True)
