"""Scenarios on the rigid-body plant: ``model = "multibody"``.

::

    model = "multibody"
    [multibody]
    bodies = "moving"               # heave, pitch, roll on suspensions; or "planar"
    tyre_law = "magic_formula"      # or "linear", "brush"
    peak_friction = 1.1
    hitch_friction_nm = 60.0
    [multibody.relaxation_m]
    car_rear = 0.4
    [multibody.damper]              # all wheels, Table 6-1
    kind = "failure_2"
    [multibody.damper_factor]       # fading
    car_rear = 0.2

What the vehicle file does not say (heights, springs, tracks) is that of the reference combination.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swaywatch.errors import ScenarioError
from swaywatch.models.double_track import Trace
from swaywatch.models.multibody import Motion, Multibody
from swaywatch.models.multibody_vehicle import (
    AXLES,
    DAMPER_KINDS,
    GRAVITY,
    TYRE_LAWS,
    Axle,
    Body,
    Combination,
    Damper,
    Inputs,
    Physics,
    reference_combination,
)
from swaywatch.roles import WHEELS
from swaywatch.simulate.table import Table
from swaywatch.vehicle import Car, Trailer, Vehicle

Array = NDArray[np.float64]
MODEL = "multibody"


def combination_of(vehicle: Vehicle, place: str, damper: Damper | None = None) -> Combination:
    """The vehicle file's combination on the reference's suspensions.

    Raises
    ------
    ScenarioError
        No trailer, a single-axle trailer, or a stiffness that the file leaves out.
    """
    if vehicle.trailer is None or vehicle.trailer.front_axle_to_cog is None:
        raise ScenarioError(f"{place}: model = 'multibody' needs a trailer with two axles")
    whole = reference_combination()
    loads = (vehicle.car.front_axle_load, vehicle.car.rear_axle_load)
    nose = whole.nose_load_n
    if loads[0] is not None and loads[1] is not None:
        nose = loads[0] + loads[1] - vehicle.car.mass * GRAVITY
    return replace(
        whole,
        car=_body(whole.car, vehicle.car, place, damper),
        trailer=_body(whole.trailer, vehicle.trailer, place, damper),
        steering_ratio=vehicle.car.steering_ratio,
        nose_load_n=nose,
    )


def _body(old: Body, data: Car | Trailer, place: str, damper: Damper | None) -> Body:
    scale = data.mass / old.mass_kg

    def axle(axle: Axle, to_cog: float | None, stiffness: float | None, name: str) -> Axle:
        if to_cog is None or stiffness is None:
            raise ScenarioError(
                f"{place}: model = 'multibody' needs {name}_cornering_stiffness of both bodies"
            )
        return replace(
            axle,
            to_cog_m=to_cog,
            cornering_stiffness_n_rad=stiffness,
            damper=damper or axle.damper,
        )

    if data.hitch_to_cog is None:
        raise ScenarioError(f"{place}: model = 'multibody' needs the car's hitch_to_cog")
    return replace(
        old,
        mass_kg=data.mass,
        yaw_inertia_kgm2=data.yaw_inertia,
        roll_inertia_kgm2=old.roll_inertia_kgm2 * scale,
        pitch_inertia_kgm2=old.pitch_inertia_kgm2 * data.yaw_inertia / old.yaw_inertia_kgm2,
        hitch_to_cog_m=data.hitch_to_cog,
        front=axle(old.front, data.front_axle_to_cog, data.front_cornering_stiffness, "front"),
        rear=axle(old.rear, -data.rear_axle_to_cog, data.rear_cornering_stiffness, "rear"),
    )


def _axles(table: Table, low: float, high: float, unit: str, default: float) -> tuple[float, ...]:
    values = tuple(table.number(name, low, high, unit, default) for name in AXLES)
    table.done()
    return values


def _damper(table: Table) -> Damper:
    start = Damper("normal", 2200.0)
    damper = Damper(
        kind=table.word("kind", DAMPER_KINDS, start.kind),
        coefficient_ns_m=table.number("coefficient_ns_m", 0, 2e4, "N s/m", start.coefficient_ns_m),
        ratio=table.number("ratio", 0.1, 20.0, "1", start.ratio),
        knee_m_s=table.number("knee_m_s", 0.001, 5.0, "m/s", start.knee_m_s),
        degression=table.number("degression", 0.0, 1.0, "1", start.degression),
        lost_travel_m=table.number("lost_travel_m", 0.0, 0.2, "m", start.lost_travel_m),
        lost_factor=table.number("lost_factor", 0.0, 1.0, "1", start.lost_factor),
    )
    table.done()
    return damper


def read_multibody(content: Any, place: str) -> tuple[Physics, Damper]:
    """Physics and dampers from the table ``[multibody]``.

    Raises
    ------
    ScenarioError
        Names the key and what would be right.
    """
    table = Table(content, f"{place} [multibody]")
    a, b, c, d = _axles(table.table("relaxation_m"), 0.0, 3.0, "m", 0.0)
    factors = _axles(table.table("damper_factor"), 0.0, 10.0, "1", 1.0)
    base = Physics()
    physics = Physics(
        full=table.word("bodies", ("moving", "planar"), "moving") == "moving",
        tyre_law=table.word("tyre_law", TYRE_LAWS, base.tyre_law),
        peak_friction=table.number("peak_friction", 0.05, 10.0, "1", base.peak_friction),
        load_degression=table.number("load_degression", 0.0, 1.5, "1", 0.0),
        relaxation_m=(a, b, c, d),
        steering_stiffness_n_rad=table.number("steering_stiffness_n_rad", 0, 1e9, "N/rad", 0.0),
        hitch_friction_nm=table.number("hitch_friction_nm", 0.0, 1e4, "N m", 0.0),
        hitch_damping_nms_rad=table.number("hitch_damping_nms_rad", 0.0, 1e5, "N m s/rad", 0.0),
        damper_factor=tuple(factors[i // 2] for i in range(8)),
    )
    damper = _damper(table.table("damper"))
    table.done()
    return physics, damper


def simulate_multibody(
    vehicle: Vehicle, content: Any, place: str, time_s: Array, steering_rad: Array, speed_m_s: Array
) -> Trace:
    """Run the rigid-body plant with a driver who holds the wheel.

    Parameters
    ----------
    vehicle : the combination.
    content, place : table ``[multibody]``, and where it stands.
    time_s, steering_rad, speed_m_s : even times, steering wheel angle, wanted speed, shape (n,).
    """
    physics, damper = read_multibody(content, place)
    plant = Multibody(combination_of(vehicle, place, damper), physics)
    try:
        motion = plant.run(Inputs(time_s, steering_rad, speed_m_s))
    except (FloatingPointError, ValueError) as error:
        raise ScenarioError(f"{place}: {error}") from None
    return Trace(time_s, _channels(motion.resample(time_s)))


def _channels(motion: Motion) -> dict[str, Array]:
    """Channels by the names of :mod:`swaywatch.roles`, and what sensors are placed by."""
    step = float(motion.time_s[1] - motion.time_s[0])
    out = {
        "steering_wheel_angle": motion.steering_wheel_rad,
        "speed": motion.speed_m_s,
        "car_yaw_rate": motion.yaw_rate_rad_s,
        "trailer_yaw_rate": motion.trailer_yaw_rate_rad_s,
        "car_lateral_acceleration": motion.rear_acceleration_m_s2,
        "trailer_lateral_acceleration": motion.trailer_acceleration_m_s2,
        "articulation": motion.trailer_yaw_rad - motion.yaw_rad,
        "hitch_longitudinal_force": motion.hitch_x_n,
        "hitch_lateral_force": motion.hitch_y_n,
        "hitch_vertical_force": motion.hitch_z_n,
        "car_acceleration_y": motion.car_acceleration_m_s2,
        "trailer_acceleration_y": motion.trailer_acceleration_m_s2,
        "car_yaw_acceleration": np.gradient(motion.yaw_rate_rad_s, step),
        "trailer_yaw_acceleration": np.gradient(motion.trailer_yaw_rate_rad_s, step),
        "car_roll": motion.roll_rad,
        "trailer_roll": motion.trailer_roll_rad,
        "bank": np.zeros_like(motion.time_s),
    }
    for i in range(8):
        name = f"{'trailer_' if i >= 4 else ''}wheel_{{}}_{WHEELS[i % 4]}"
        out[name.format("lateral_force")] = motion.wheel_fy_n[i]
        out[name.format("vertical_load")] = motion.wheel_fz_n[i]
    return out
