"""The logger's clock, found from the messages; and the speed against the wheels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA

from swaywatch.checks.clocks import check_rate, check_steps
from swaywatch.checks.quality import check_drive
from swaywatch.drive import Channel, Drive, load_drive
from swaywatch.vehicle_file import load_vehicle

P01 = DATA / "practice" / "p01"


@pytest.fixture(scope="module")
def drive() -> Drive:
    return load_drive([P01 / "run1.blf"], P01 / "signals.toml")


def stamped(drive: Drive, stamp: object) -> Drive:
    assert callable(stamp)
    return replace(
        drive,
        channels={n: replace(c, time_s=stamp(c.time_s)) for n, c in drive.channels.items()},
    )


def test_a_sound_clock_is_left_alone(drive: Drive) -> None:
    assert check_rate(drive) == []
    assert check_steps(drive) == []


@pytest.mark.parametrize("factor", [1.015, 0.985, 1.006])
def test_a_clock_that_runs_fast_or_slow(drive: Drive, factor: float) -> None:
    (found,) = check_rate(stamped(drive, lambda time: factor * time))
    assert found.kind == "clock"
    assert f"{100 * abs(factor - 1):.1f} % {'fast' if factor > 1 else 'slow'}" in found.text


def test_a_step_of_the_stamps(drive: Drive) -> None:
    (found,) = check_steps(stamped(drive, lambda time: time + 0.03 * (time > 17.0)))
    assert found.time_s == pytest.approx(17.0, abs=0.05)
    assert "clock was set, or it lost frames" in found.text


def test_a_speed_that_the_wheels_contradict(drive: Drive) -> None:
    speed = drive.channels["speed"]
    wheels = {
        f"wheel_speed_{wheel}": replace(speed, name=f"wheel_speed_{wheel}", signal=f"Wheel{wheel}")
        for wheel in ("fl", "fr", "rl", "rr")
    }
    wrong = replace(speed, value=speed.value / 3.6)
    plain: dict[str, Channel] = {"speed": wrong, **wheels}
    (found,) = [
        f
        for f in check_drive(replace(drive, channels=plain), load_vehicle(P01 / "vehicle.toml"))
        if f.severity == "error"
    ]
    assert speed.signal in found.text
    assert "it is in m/s, not in km/h" in found.text
    assert np.isclose(found.amount, 3.6)
