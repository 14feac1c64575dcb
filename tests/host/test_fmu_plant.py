"""The plant as FMUs: FMPy accepts and runs them, with the plant's own answers."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA, built_fmu
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

from swaywatch.models.double_track import DoubleTrack, SpeedControl, Stepper, Trace
from swaywatch.plant.sprung import defaults
from swaywatch.plant.vehicle_view import constants_of
from swaywatch.vehicle_file import load_vehicle

STEP_S = 0.01
STEPS = 600


@pytest.fixture(scope="module", params=["2", "3"])
def fmu(request: pytest.FixtureRequest) -> Path:
    """The FMU of one version."""
    return built_fmu(f"swaywatch_plant_fmi{request.param}")


def model() -> DoubleTrack:
    vehicle = load_vehicle(DATA / "practice" / "p03" / "vehicle.toml")
    return DoubleTrack(vehicle, sprung=defaults(constants_of(vehicle)))


def steering(sample: int) -> float:
    """An impulse."""
    since = sample * STEP_S - 1.0
    return math.radians(18.0) * math.sin(math.pi * since) if 0.0 < since < 1.0 else 0.0


def ours(plant: Stepper, own: DoubleTrack, speed: float) -> Trace:
    """The same drive; the trailer is braked from 4 s on."""
    rows, angles = [plant.sample], [0.0]
    for k in range(1, STEPS + 1):
        if k - 1 == 400:
            plant.brake("trailer", 800.0)
        angles.append(steering(k))
        rows.append(plant.advance(angles[-1], speed))
    return own.trace(np.arange(STEPS + 1) * STEP_S, np.array(angles), np.array(rows))


def given(speed: float) -> np.ndarray:
    rows = []
    for k in range(STEPS + 1):
        rate = (steering(k + 1) - steering(k)) / STEP_S
        rows.append((k * STEP_S, steering(k), rate, speed, 0.0 if k < 400 else 800.0))
    names = ("time", "steering_wheel_angle", "steering_wheel_angle_rate", "target_speed",
             "trailer_brake_force")  # fmt: skip
    return np.array(rows, dtype=[(name, float) for name in names])


def run(fmu: Path, speed: float, wanted: list[str], **start: float) -> np.ndarray:
    return simulate_fmu(
        str(fmu), start_time=0.0, stop_time=STEPS * STEP_S, output_interval=STEP_S,
        input=given(speed), output=wanted, start_values=start,
    )  # fmt: skip


def test_fmpy_finds_nothing_wrong(fmu: Path) -> None:
    """Schema, names, units, structure, required start values."""
    assert validate_fmu(str(fmu)) == []


@pytest.mark.parametrize("controlled", [True, False])
def test_it_moves_as_the_plant_does(fmu: Path, controlled: bool) -> None:
    """Every output at every step of a swing near the critical speed, with a brake."""
    own, speed = model(), 32.0
    control = SpeedControl() if controlled else None
    trace = ours(own.stepper(STEP_S, speed, speed_control=control), own, speed)
    names = [v.name for v in read_model_description(str(fmu)).modelVariables
             if v.causality == "output"]  # fmt: skip
    found = run(fmu, speed, names, speed_control=float(controlled))
    assert len(names) > 50
    assert float(np.ptp(trace["trailer_yaw_rate"])) > math.radians(8.0)
    assert float(np.ptp(trace["speed"])) > (0.05 if controlled else -1.0)
    for name in names:
        size = max(float(np.abs(trace[name]).max()), 1.0)
        np.testing.assert_allclose(found[name], trace[name], rtol=0.0, atol=1e-9 * size)


def test_parameters_change_it_and_wrong_ones_are_refused(fmu: Path) -> None:
    wanted = ["trailer_yaw_rate", "car_roll"]
    plain = run(fmu, 25.0, wanted)
    rough = run(fmu, 25.0, wanted, **{"hitch.friction": 300.0})
    rigid = run(fmu, 25.0, wanted, **{"sprung.sprung_mass_car": 0.0,
                                      "sprung.sprung_mass_trailer": 0.0})  # fmt: skip
    for other in (rough, rigid):
        assert float(np.abs(other["trailer_yaw_rate"] - plain["trailer_yaw_rate"]).max()) > 0.002
    for wrong in ({"car.mass": 0.0}, {"car.steering_ratio": 0.0}):
        with pytest.raises(Exception, match="ExitInitializationMode"):
            run(fmu, 25.0, wanted, **wrong)
    with pytest.raises(Exception, match=r"DoStep|ExitInitializationMode"):
        run(fmu, 0.1, wanted)
