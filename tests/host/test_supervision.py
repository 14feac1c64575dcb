"""Supervision in the whole core: a refuted sensor leaves the estimate, and the estimate goes on."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

import supervision

from swaywatch._core import lib
from swaywatch.core import VALID, Core, positions_of


def test_a_healthy_drive_has_no_finding() -> None:
    recording, vehicle, *_ = supervision.drive("nothing", 11)
    status, _ = Core(vehicle, positions_of(recording)).feed(recording)
    assert not np.any(status["finding"] | status["doubted_inputs"] | status["refuted_inputs"])


def test_a_refuted_sensor_is_left_out_and_the_margin_goes_on() -> None:
    """An inverted sensor is refuted after its fault; lines and margin come without it."""
    recording, vehicle, _, channel, begin_s = supervision.drive("inverted", 12)
    status, _ = Core(vehicle, positions_of(recording)).feed(recording)
    refuted = status["refuted_inputs"] != 0
    assert refuted.any()
    first = int(np.flatnonzero(refuted)[0])
    assert status["time_us"][first] * 1e-6 > begin_s
    assert np.all(status["refuted_inputs"][first:] == 1 << channel)
    assert np.all(status["missing_inputs"][first:] & (1 << channel) == 0)
    assert status["finding"][-1] in (
        lib.SWAY_FINDING_GAIN + channel, lib.SWAY_FINDING_DELAY + channel,
    )  # fmt: skip
    later = status[first + 30 :]
    assert np.mean(later["valid"] & VALID["margin"] != 0) > 0.5
    assert np.any(later["valid"] & VALID["line"] != 0)
