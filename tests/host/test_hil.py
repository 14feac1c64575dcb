"""The closed loop of ``swaywatch hil``, with the ECU software on a bus in the same process."""

from __future__ import annotations

import json
from collections import deque
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import can
import numpy as np
import pytest
from conftest import DATA, Clock

from swaywatch.cli import main
from swaywatch.ecu.live import NodeFeed
from swaywatch.errors import ScenarioError
from swaywatch.simulate.closed_loop import LoopResult, drive_closed_loop
from swaywatch.simulate.expectation import Expectation
from swaywatch.simulate.scenario import Scenario, load_scenario, read_scenario
from swaywatch.simulate.table import Table
from swaywatch.vehicle_file import load_vehicle

FOLDER = DATA / "practice" / "p01"
REAR_AXLE_M = -1.383
FAST = 132.0  # km/h, v_crit is 123.3


def scenario(speed_kmh: float = FAST, **content: Any) -> Scenario:
    base: dict[str, Any] = {
        "vehicle": "vehicle.toml",
        "duration_s": 16.0,
        "speed_kmh": speed_kmh,
        "speed_control": True,
        "manoeuvre": [{"kind": "impulse", "angle_deg": 6.0, "start_s": 2.0}],
    }
    return read_scenario({**base, **content}, "test", FOLDER, "test.toml")


class EcuBus:
    """A bus with the ECU software on it."""

    def __init__(self, clock: Clock) -> None:
        positions = {"car_lateral_acceleration": REAR_AXLE_M, "trailer_lateral_acceleration": 0.0}
        self.clock = clock
        self.ecu = NodeFeed(load_vehicle(FOLDER / "vehicle.toml"), positions)
        self.answers: deque[can.Message] = deque()
        self.times: list[float] = []

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        self.times.append(self.clock.now)
        msg.timestamp = self.clock.now + 4e-6 * (len(self.times) % 16)
        for identifier, data in self.ecu.receive(msg):
            self.answers.append(
                can.Message(arbitration_id=identifier, data=data, is_extended_id=False)
            )

    def recv(self, timeout: float | None = None) -> can.Message | None:
        return self.answers.popleft() if self.answers else None


def drive(plan: Scenario) -> tuple[LoopResult, EcuBus]:
    clock = Clock()
    bus = EcuBus(clock)
    return drive_closed_loop(plan, bus, clock=clock, sleep=clock.sleep), bus


def test_the_ecu_accepts_every_frame() -> None:
    result, bus = drive(scenario(90.0, duration_s=4.0))
    assert result.feed.sent == len(bus.times) == bus.ecu.counts.used
    assert set(bus.ecu.faults().values()) == {0}
    assert result.status_frames > 30


def test_frames_withheld_are_counted_by_the_ecu() -> None:
    _, whole = drive(scenario(90.0, duration_s=4.0))
    _, bus = drive(scenario(90.0, duration_s=4.0, timing={"lost": 0.05}))
    missing = len(whole.times) - len(bus.times)
    assert missing > 100
    # What is missing at the very end nobody can know: at most one frame of each message.
    assert missing - 14 <= bus.ecu.faults()["lost"] <= missing


@pytest.mark.parametrize(
    "reaction",
    [
        {"kind": "trailer_brake", "force_n": 4000.0, "at": "warning"},
        {"kind": "slow_down", "deceleration_m_s2": 3.0, "at": "warning"},
    ],
)
def test_the_alarm_ends_the_swaying(reaction: dict[str, Any]) -> None:
    """The same drive, above its critical speed, with and without an answer to the alarm."""
    alone, _ = drive(scenario())
    answered, _ = drive(scenario(reaction=reaction))
    assert alone.reacted_s is None
    assert answered.reacted_s is not None
    assert answered.speed_m_s < alone.speed_m_s - 5.0
    assert answered.swing_rad_s[-1] < 0.5 * alone.swing_rad_s[-1]


def test_the_example_brakes_in_time() -> None:
    result, _ = drive(load_scenario(DATA / "scenarios" / "brake.toml"))
    assert result.reacted_s is not None
    assert result.swing_rad_s[-1] < 0.01


def test_what_the_sensors_do_offline_they_do_in_the_loop() -> None:
    """A frozen sensor is reported by the ECU."""
    sensors = {"trailer_yaw_rate": {"frozen_from_s": 3.0}}
    slalom = [{"kind": "slalom", "angle_deg": 20.0}]
    _, bus = drive(scenario(90.0, duration_s=9.0, sensors=sensors, manoeuvre=slalom))
    assert bus.ecu.faults()["frozen"] > 0


def test_a_trailer_brake_needs_a_speed_that_forces_can_change() -> None:
    plan = scenario(speed_control=False, reaction={"kind": "trailer_brake"})
    with pytest.raises(ScenarioError, match="speed_control = true"):
        drive(plan)


def test_a_reaction_needs_an_ecu(tmp_path: Path, capsys: Any) -> None:
    text = f"""vehicle = "{FOLDER / "vehicle.toml"}"
duration_s = 2.0
speed_kmh = 90.0
[reaction]
kind = "slow_down"
"""
    file = tmp_path / "loop.toml"
    file.write_text(text)
    assert main(["simulate", str(file), "--out", str(tmp_path / "x.blf")]) == 1
    assert "swaywatch hil" in capsys.readouterr().err
    assert not (tmp_path / "x.blf").exists()


def test_the_command_says_when_no_ecu_answers(tmp_path: Path, capsys: Any) -> None:
    file = tmp_path / "loop.toml"
    file.write_text(f'vehicle = "{FOLDER / "vehicle.toml"}"\nduration_s = 1.0\nspeed_kmh = 90.0\n')
    assert main(["hil", str(file), "--interface", "virtual", "--channel", "swaywatch-hil"]) == 0
    out = capsys.readouterr().out
    assert "ECU: silent" in out
    assert "frames sent" in out


def judged(result: LoopResult, **expect: Any) -> dict[str, bool]:
    table = Table(expect, "test [expect]")
    return {verdict.name: verdict.passed for verdict in Expectation(table).judge(result)}


def test_verdicts_of_a_drive() -> None:
    """What happened passes, what did not fails, each by itself."""
    plan = load_scenario(DATA / "scenarios" / "brake.toml")
    result, _ = drive(plan)
    assert all(judged(result, **plan.expect).values())
    swing, speed = np.degrees(max(result.swing_rad_s)), 3.6 * result.speed_m_s
    warned = next(time for time, state in result.alarms if state >= 3)
    found = judged(
        result, alarm="warning", alarm_by_s=warned - 0.1, no_alarm="critical",
        largest_swing_deg_s=swing - 0.1, last_swing_deg_s=swing, final_speed_kmh=speed + 1.0,
    )  # fmt: skip
    highest = max(state for _, state in result.alarms)
    assert list(found.values()) == [True, False, highest < 4, False, True, True]


def test_a_silent_ecu_passes_nothing() -> None:
    """Not even that there was no alarm: nobody said so."""
    found = judged(LoopResult(), no_alarm="notice", alarm="warning", latest_cycle_ms=1e3)
    assert not any(found.values())


def test_a_wrong_expectation_is_named() -> None:
    with pytest.raises(ScenarioError, match="unknown key 'alarms'"):
        judged(LoopResult(), alarms="warning")
    with pytest.raises(ScenarioError, match="expected one of: notice, warning, critical"):
        judged(LoopResult(), alarm="off")


def test_junit_and_json_of_the_command(tmp_path: Path, capsys: Any) -> None:
    """Without an ECU every verdict fails: XML, JSON and status say so."""
    file, junit = tmp_path / "loop.toml", tmp_path / "out" / "junit.xml"
    file.write_text(
        f'vehicle = "{FOLDER / "vehicle.toml"}"\nduration_s = 1.0\nspeed_kmh = 90.0\n'
        '[expect]\nno_alarm = "warning"\nlast_swing_deg_s = 90.0\n'
    )
    bus = ["--interface", "virtual", "--channel", "swaywatch-hil"]
    assert main(["hil", str(file), *bus, "--junit", str(junit), "--json"]) == 1
    result = json.loads(capsys.readouterr().out)
    assert not result["passed"]
    assert [v["passed"] for v in result["verdicts"]] == [False, False, True]
    suite = ElementTree.parse(junit).getroot()[0]
    assert (suite.get("tests"), suite.get("failures")) == ("3", "2")
    failed = [case.get("name") for case in suite if case.find("failure") is not None]
    assert failed == ["the ECU answers", "never warning"]
