"""Supervision in the whole core: a rejected sensor leaves the estimate, which continues."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

import supervision

from swaywatch.ecu._core import lib
from swaywatch.ecu.core import VALID, Core, positions_of
from swaywatch.ecu.supervised import RELATIONS, broken, findings_text, words


def test_a_healthy_drive_has_no_finding() -> None:
    recording, vehicle, *_ = supervision.drive("nothing", 11)
    status, _ = Core(vehicle, positions_of(recording)).feed(recording)
    assert not np.any(status["finding"] | status["suspect_inputs"] | status["rejected_inputs"])
    assert findings_text(status) == ""
    assert broken(status) == []
    assert {int(row["relation"]) % 256 for row in status} == set(range(len(RELATIONS)))
    held = {int(r) % 256 for r in status["relation"] if int(r) // 256 == lib.SWAY_RELATION_HOLDS}
    assert {
        RELATIONS.index("motion of the ball"),
        RELATIONS.index("yaw balance of the car"),
    } <= held


def test_a_rejected_sensor_is_left_out_and_the_margin_goes_on() -> None:
    """An inverted sensor is rejected after its fault; lines and margin come without it."""
    recording, vehicle, _, channel, begin_s = supervision.drive("inverted", 12)
    status, _ = Core(vehicle, positions_of(recording)).feed(recording)
    rejected = status["rejected_inputs"] != 0
    assert rejected.any()
    first = int(np.flatnonzero(rejected)[0])
    assert status["time_us"][first] * 1e-6 > begin_s
    assert np.all(status["rejected_inputs"][first:] == 1 << channel)
    assert np.all(status["missing_inputs"][first:] & (1 << channel) == 0)
    assert status["finding"][-1] in (
        lib.SWAY_FINDING_GAIN + channel, lib.SWAY_FINDING_DELAY + channel,
    )  # fmt: skip
    assert "; rejected since the finding: the " in findings_text(status)
    later = status[first + 30 :]
    assert np.mean(later["valid"] & VALID["margin"] != 0) > 0.5
    assert np.any(later["valid"] & VALID["line"] != 0)


def test_findings_are_said_with_size_error_and_unit() -> None:
    assert words(lib.SWAY_FINDING_TRAILER_TYRES, -0.22, 0.03) == (
        "the vehicle is not the one configured: stiffness of the trailer's tyres -22 ± 3 %"
    )
    assert words(lib.SWAY_FINDING_FRICTION, 1.5, 0.2).endswith("friction at the hitch +150 ± 20 Nm")
    assert words(lib.SWAY_FINDING_LOAD, -0.05, 0.012).endswith("to the front, -50 ± 12 mm")
    assert words(lib.SWAY_FINDING_SPEED, 0.25, 0.04).endswith("measured one by +25 ± 4 %")
    assert words(lib.SWAY_FINDING_GAIN + 1, 0.25, 0.02) == (
        "the car's yaw rate has a gain error of +25 ± 2 %"
    )
    assert words(lib.SWAY_FINDING_DELAY + 4, 0.08, 0.006).endswith("is late by +80 ± 6 ms")
    assert words(lib.SWAY_FINDING_OFFSET + 3, 0.02, 0.002).endswith("of +1.1 ± 0.1 deg/s")
    assert words(lib.SWAY_FINDING_OFFSET + 2, 2.0, 0.2).endswith("of +2.0 ± 0.2 m/s2")
