"""``swaywatch plan``: errors predicted are those obtained, speeds are safe, files can be driven."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

from swaywatch.cli import main
from swaywatch.errors import VehicleError
from swaywatch.plan.design import (
    LARGEST_RATE_DEG_S,
    SLALOM,
    Limits,
    candidates,
    fitted,
    iso9815,
    j2664,
    limits_of,
    make_design,
)
from swaywatch.plan.information import critical_of, errors, information, outputs
from swaywatch.plan.knowledge import KnownSensor, known_of, sensors_of
from swaywatch.simulate.run import simulate_plant
from swaywatch.simulate.scenario import load_scenario
from swaywatch.vehicle_file import load_vehicle

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "bench"))

from plan_repeats import ratios

FILE = DATA / "practice" / "p03" / "vehicle.toml"
VEHICLE = load_vehicle(FILE)
KNOWN = known_of(VEHICLE)
LIMITS = limits_of(KNOWN, critical_of(KNOWN), 110.0, 3.0)


def test_errors_are_those_of_simulated_tests() -> None:
    """`make bench-plan` does 100 of three vehicles; a dozen together here."""
    design = make_design(KNOWN, "trailer", goal="parameters", error=2.5)
    predicted, obtained, speed = ratios(KNOWN, design, 12, 3)
    informed = predicted < 0.7
    together = float(np.sqrt(np.mean((obtained[informed] / predicted[informed]) ** 2)))
    assert informed.sum() >= 6
    assert 0.7 <= together <= 1.4
    assert 0.5 <= speed <= 2.0


def test_one_tone_does_not_separate_the_steering_ratio() -> None:
    pool = candidates(KNOWN, LIMITS)
    own = sensors_of("own")
    ratio = [unknown.name for unknown in KNOWN.unknowns].index("steering_ratio")

    def left(words: str) -> float:
        blocks = [b for b in pool if b.words == words][1:2]
        (informed,) = information(KNOWN, [b.drive() for b in blocks], own)
        return float(np.sqrt(errors(informed)[ratio, ratio]))

    assert left("two tones, slow and fast") < 0.5 * left(SLALOM)


def test_blocks_keep_the_limits() -> None:
    pool = candidates(KNOWN, LIMITS)
    both = (
        KnownSensor("c", "car_acceleration", 1.0),
        KnownSensor("t", "trailer_acceleration", 1.0),
    )
    shown = outputs(KNOWN, [b.drive() for b in pool], [KNOWN.values] * len(pool), both)
    for block, part in zip(pool, shown, strict=True):
        assert block.speed_kmh <= LIMITS.fastest_kmh + 0.1
        assert np.abs(part).max() <= 1.05 * LIMITS.acceleration_m_s2
        drive = block.drive()
        rate = np.abs(np.diff(np.degrees(drive.steer))).max() / 0.01
        assert rate <= 1.6 * LARGEST_RATE_DEG_S  # the ramps of a soft start
    critical = critical_of(KNOWN)
    believed = critical.error(np.eye(len(KNOWN.unknowns)))
    assert LIMITS.fastest_kmh <= 3.6 * (critical.speed_m_s - 2 * believed) + 0.1


def test_presets() -> None:
    blocks = iso9815(KNOWN, LIMITS)
    speeds = sorted({block.speed_kmh for block in blocks})
    assert len(speeds) == 5
    assert speeds[-1] - speeds[0] == pytest.approx(30.0, abs=0.2)
    assert {np.sign(b.tables[0]["angle_deg"]) for b in blocks} == {1.0, -1.0}
    steps = np.diff(sorted({block.speed_kmh for block in j2664(KNOWN, LIMITS)}))
    assert steps == pytest.approx(10.0, abs=0.11)
    assert fitted(KNOWN, Limits(90.0, 1.0), blocks)[0].tables[0]["angle_deg"] < (
        0.5 * blocks[0].tables[0]["angle_deg"]
    )


def test_more_sensors_tell_more() -> None:
    design = make_design(KNOWN, "own", preset="iso9815")
    found = [design.by_sensors[name][0] for name in ("own", "trailer", "forces")]
    assert found[0] > found[1] > found[2]
    assert np.all(design.by_sensors["trailer"][1] <= design.by_sensors["own"][1] + 1e-9)


def test_command_writes_what_can_be_driven(tmp_path: Path) -> None:
    arguments = ["plan", "--vehicle", str(FILE), "--out", str(tmp_path)]
    assert main([*arguments, "--goal", "parameters", "--error", "2.9"]) == 0
    content = json.loads((tmp_path / "plan.json").read_text())
    scenario = load_scenario(tmp_path / "plan.toml")
    trace = simulate_plant(scenario)
    assert np.isfinite(trace["car_yaw_rate"]).all()
    assert np.abs(trace["car_acceleration_y"]).max() < 1.3 * 3.0
    robot = np.genfromtxt(tmp_path / "robot.csv", delimiter=",", skip_header=1)
    assert robot[:, 2].max() <= content["fastest_kmh"] + 0.1
    assert robot[-1, 0] == pytest.approx(scenario.duration_s, abs=0.02)
    steer = np.interp(robot[:, 0], scenario.time_s, scenario.plan.steering_rad)
    assert np.radians(robot[:, 1]) == pytest.approx(steer, abs=1e-4)
    page = (tmp_path / "plan.html").read_text()
    assert "What to drive" in page
    assert content["critical_speed_error_m_s"] < 0.5 * 9.8 / 3.6


def test_what_cannot_be_planned_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(VehicleError, match="trailer"):
        known_of(replace(VEHICLE, trailer=None))
    trailer = VEHICLE.trailer
    assert trailer is not None
    heavy = 4.0 * trailer.yaw_inertia
    wild = replace(
        trailer, rear_cornering_stiffness=8e3, front_cornering_stiffness=8e3, yaw_inertia=heavy
    )
    with pytest.raises(VehicleError, match="no test at 40 km/h or more is safe"):
        make_design(known_of(replace(VEHICLE, trailer=wild)), "own")
    arguments = ["plan", "--vehicle", str(FILE), "--out", str(tmp_path / "p")]
    assert main([*arguments, "--error", "0"]) != 0
    assert "--error 0: expected" in capsys.readouterr().err
    assert main([*arguments, "--error", "50"]) != 0
    assert "already accurate enough" in capsys.readouterr().err
    assert not (tmp_path / "p").exists()
