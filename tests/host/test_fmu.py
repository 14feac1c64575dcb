"""The core as FMUs: FMPy accepts and runs them, with the core's own answers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA, built_fmu
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

from swaywatch.drive import Drive, load_drive
from swaywatch.ecu._core import ffi, lib
from swaywatch.ecu.core import STATUS_DTYPE, columns_of, core_config
from swaywatch.roles import CHANNELS
from swaywatch.vehicle import Vehicle
from swaywatch.vehicle_file import load_vehicle

P01 = DATA / "practice" / "p01"
CAR_ACC = "car_lateral_acceleration"
STEP_S = 0.01
SECONDS = 12.0


@pytest.fixture(scope="module", params=["2", "3"])
def fmu(request: pytest.FixtureRequest) -> Path:
    """The FMU of one version."""
    return built_fmu(f"swaywatch_fmi{request.param}")


NAMES = (
    "steering_wheel_angle", "speed", "car_yaw_rate", "car_lateral_acceleration",
    "trailer_yaw_rate", "trailer_lateral_acceleration", "wheel_lateral_force_fl",
    "wheel_lateral_force_fr", "wheel_lateral_force_rl", "wheel_lateral_force_rr",
)  # fmt: skip


def held() -> Drive:
    """Channels of a practice run at even times from 0 on."""
    drive = load_drive([P01 / "run1.blf"], P01 / "signals.toml")
    time = np.arange(0.5, 0.5 + SECONDS, STEP_S)
    channels = {
        name: replace(
            drive.channels[name],
            time_s=np.arange(len(time)) * STEP_S,
            value=np.interp(time, drive.channels[name].time_s, drive.channels[name].value),
        )
        for name in NAMES
    }
    return replace(drive, channels=channels)


def test_fmpy_finds_nothing_wrong(fmu: Path) -> None:
    """Schema, names, units, structure, required start values."""
    assert validate_fmu(str(fmu)) == []


def test_it_answers_as_the_core_does(fmu: Path) -> None:
    """The same samples give the same numbers at every step, in a vehicle of the user's own."""
    vehicle = load_vehicle(P01 / "vehicle.toml")
    drive = held()
    given = samples(drive, *NAMES)
    start = {}
    for body in ("car", "trailer"):
        for name, value in vars(getattr(vehicle, body)).items():
            if isinstance(value, float):
                start[f"{body}.{name}"] = value
    start["car.lateral_acceleration_position"] = -1.383
    known = {v: start[v] for v in start if v in parameters(fmu)}
    wanted = ["sequence", "valid", "alarm", "quality", "frequency_hz", "damping_ratio",
              "v_crit_m_s", "margin_m_s", "car_rear.cornering_stiffness_n_per_rad"]  # fmt: skip
    found = simulate_fmu(
        str(fmu), start_time=0.0, stop_time=float(given["time"][-1]), step_size=STEP_S,
        output_interval=STEP_S, input=given, output=wanted, start_values=known,
    )  # fmt: skip
    ours = stepped(vehicle, given)
    assert ours["sequence"][-1] > 30
    assert ours["v_crit_m_s"][-1] > 20.0
    for name in wanted:
        np.testing.assert_allclose(found[name][1:], ours[name], rtol=0.0, atol=1e-9)


def stepped(vehicle: Vehicle, given: np.ndarray) -> dict[str, np.ndarray]:
    """Status after each step of a core that gets all samples of a time before it goes on."""
    core, config = ffi.new("sway_core_t *"), core_config(vehicle, {CAR_ACC: -1.383})
    config.input_period_us = 0
    assert lib.sway_core_init(core, config) == lib.SWAY_OK
    size = ffi.sizeof("sway_status_t")
    statuses = b""
    for row in given[:-1]:
        for name in NAMES:
            kind = CHANNELS[name]
            value = round(float(row[name]) * kind.core_scale)
            lib.sway_core_input(
                core, getattr(lib, str(kind.core_input)), round(float(row["time"]) * 1e6), value
            )
        while lib.sway_core_run(core):
            pass
        statuses += bytes(ffi.buffer(lib.sway_core_status(core), size))
    return columns_of(np.frombuffer(statuses, dtype=STATUS_DTYPE))


def samples(drive: Drive, *names: str) -> np.ndarray:
    """Inputs as FMPy wants them."""
    columns = [drive.channels["speed"].time_s, *(drive.channels[n].value for n in names)]
    kind = [("time", float), *((name, float) for name in names)]
    return np.array(list(zip(*columns, strict=True)), dtype=kind)


def parameters(fmu: Path) -> list[str]:
    """Names of its parameters."""
    variables = read_model_description(str(fmu)).modelVariables
    return [v.name for v in variables if v.causality == "parameter"]


def test_a_vehicle_out_of_range_and_a_step_too_long_are_refused(fmu: Path) -> None:
    given = samples(held(), "speed")
    with pytest.raises(Exception, match="ExitInitializationMode"):
        simulate_fmu(str(fmu), stop_time=1.0, step_size=STEP_S, input=given,
                     start_values={"car.mass": 1.0})  # fmt: skip
    with pytest.raises(Exception, match="DoStep"):
        simulate_fmu(str(fmu), stop_time=1.0, step_size=0.2, output_interval=0.2, input=given)
