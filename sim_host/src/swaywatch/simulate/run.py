"""Runs a scenario: plant and driver, then sensors and message times, into a drive."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from swaywatch.drive import Channel, Drive
from swaywatch.ecu.bus import MESSAGES
from swaywatch.errors import ScenarioError
from swaywatch.models.double_track import DoubleTrack, SpeedControl, Trace
from swaywatch.models.single_track import SingleTrack
from swaywatch.plant.stepping import COLUMNS
from swaywatch.roles import CHANNELS
from swaywatch.simulate.driver import Driver, make_driver
from swaywatch.simulate.scenario import PLANT_RATE_HZ, Scenario
from swaywatch.simulate.sensors import available, quantity, read_sensors
from swaywatch.simulate.table import Table


def simulate_scenario(scenario: Scenario) -> tuple[Drive, Trace]:
    """Simulate a scenario.

    Returns
    -------
    drive : what the sensors and the logger make of it
    trace : the truth

    Raises
    ------
    ScenarioError
        A key in [driver] or [sensors] is wrong, or the combination leaves all bounds at once.
    """
    trace = simulate_plant(scenario)
    whole = np.isfinite(trace["car_yaw_rate"])
    if not whole[1:].any():
        raise ScenarioError(f"{scenario.name}: the motion diverges at once")
    end = float(trace.time_s[whole][-1])
    return _drive(scenario, trace, min(end, scenario.duration_s)), trace


def simulate_plant(scenario: Scenario) -> Trace:
    """The plant with its driver, without sensors."""
    if scenario.reaction:
        raise ScenarioError(
            f"{scenario.name} [reaction]: no ECU here to react to; `swaywatch hil` has one"
        )
    ratio = scenario.vehicle.car.steering_ratio
    driver = make_driver(
        Table(scenario.driver, f"{scenario.name} [driver]"), 1.0 / PLANT_RATE_HZ, ratio
    )
    plan = scenario.plan
    if scenario.model == "single_track":
        if driver is not None:
            raise ScenarioError(f"{scenario.name} [driver]: the single track has a holding driver")
        return _single_track(scenario)
    if scenario.model == "multibody":
        if driver is not None:
            raise ScenarioError(f"{scenario.name} [driver]: the rigid-body plant's driver holds")
        from swaywatch.simulate.multibody import simulate_multibody  # needs mujoco

        return simulate_multibody(
            scenario.vehicle, scenario.multibody, scenario.name,
            plan.time_s, plan.steering_rad, plan.speed_m_s,
        )  # fmt: skip
    if scenario.model == "fmu":
        raise ScenarioError(f"{scenario.name}: model = 'fmu' is the plant of `swaywatch hil`")
    model = DoubleTrack(
        scenario.vehicle, [*scenario.physics, *plan.effects], sprung=scenario.sprung
    )
    control = SpeedControl() if scenario.speed_control else None
    if driver is None:
        return model.run(
            plan.time_s, plan.steering_rad, plan.speed_m_s,
            speed_cutoff_hz=None, speed_control=control,
        )  # fmt: skip
    return _closed_loop(scenario, model, driver, control)


def _closed_loop(
    scenario: Scenario, model: DoubleTrack, driver: Driver, control: SpeedControl | None
) -> Trace:
    plan = scenario.plan
    spacing = 1.0 / PLANT_RATE_HZ
    plant = model.stepper(spacing, float(plan.speed_m_s[0]), speed_control=control)
    rows = np.full((plan.time_s.size, len(COLUMNS)), np.nan)
    steering = np.zeros(plan.time_s.size)
    rows[0] = plant.sample
    for k in range(1, plan.time_s.size):
        steering[k] = driver.steer(float(plan.steering_rad[k]), plant)
        rows[k] = plant.advance(float(steering[k]), float(plan.speed_m_s[k]))
        if not np.isfinite(rows[k, 0]):
            break
    return model.trace(plan.time_s, steering, rows)


def _single_track(scenario: Scenario) -> Trace:
    plan = scenario.plan
    speed = float(plan.speed_m_s[0])
    model = SingleTrack.of(scenario.vehicle)
    channels = model.run(plan.time_s, plan.steering_rad, speed)
    channels["steering_wheel_angle"] = plan.steering_rad
    channels["speed"] = plan.speed_m_s
    channels["bank"] = np.zeros(plan.time_s.size)
    bodies = ("car", "trailer") if model.has_trailer else ("car",)
    channels.setdefault("articulation", np.zeros(plan.time_s.size))
    for body in bodies:
        channels[f"{body}_acceleration_y"] = channels[f"{body}_lateral_acceleration"]
        channels[f"{body}_yaw_acceleration"] = np.gradient(
            channels[f"{body}_yaw_rate"], 1.0 / PLANT_RATE_HZ
        )
        channels[f"{body}_roll"] = np.zeros(plan.time_s.size)
    return Trace(plan.time_s, channels)


def _drive(scenario: Scenario, trace: Trace, duration_s: float) -> Drive:
    sensors = read_sensors(Table(scenario.sensors, f"{scenario.name} [sensors]"), available(trace))
    streams = iter(np.random.default_rng(scenario.seed).spawn(len(MESSAGES) + len(CHANNELS)))
    time_of: dict[str, list[np.ndarray]] = {}
    for number, entries in enumerate(MESSAGES.values()):
        phase = 0.9 * number / len(MESSAGES)
        times = scenario.timing.times(duration_s, phase, next(streams))
        time_of |= {entry[0]: times for entry in entries}
    generators = dict(zip(CHANNELS, streams, strict=True))
    whole = np.isfinite(trace["car_yaw_rate"])
    channels = {}
    for name, sensor in sensors.items():
        value, position = quantity(trace, name, sensor, scenario.vehicle.car.rear_axle_to_cog)
        sampled, stamps = time_of[name]
        measured = sensor.measure(trace.time_s[whole], value[whole], sampled, generators[name])
        kind = CHANNELS[name]
        channels[name] = Channel(
            name, stamps, measured, name, kind.unit, position, (scenario.name,),
            (kind.low, kind.high), sensor.quantisation,
        )  # fmt: skip
    start_ns = round(scenario.start_s * 1e9)
    return Drive(scenario.name, (Path(f"{scenario.name}.toml"),), channels, start_ns)
