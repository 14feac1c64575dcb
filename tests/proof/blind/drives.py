"""Vehicles and manoeuvres of the generated cases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.signal import butter, sosfilt

from swaywatch.models.multibody_vehicle import (
    Axle,
    Body,
    Combination,
    Damper,
    reference_combination,
)

Array = NDArray[np.float64]
#: After it the manoeuvres of a run are driven again.
PATTERN_S = 38.3
RATE_HZ = 500.0


def draw_combination(rng: Generator) -> Combination:
    """The reference combination, or a variation of it that is about as stable.

    For cases beside a user's simulation, whose caravan has two axles with wheel force rims.
    """
    whole = reference_combination()
    if rng.random() < 0.5:
        return whole

    def tyre(axle: Axle) -> Axle:
        factor = float(rng.uniform(0.9, 1.12))
        return replace(
            axle, cornering_stiffness_n_rad=round(axle.cornering_stiffness_n_rad * factor, -2)
        )

    def body(old: Body) -> Body:
        mass, size = float(rng.uniform(0.85, 1.12)), float(rng.uniform(0.94, 1.06))
        yaw = float(rng.uniform(0.92, 1.05)) * mass
        return replace(
            old,
            mass_kg=round(old.mass_kg * mass),
            yaw_inertia_kgm2=round(old.yaw_inertia_kgm2 * yaw),
            roll_inertia_kgm2=old.roll_inertia_kgm2 * mass,
            pitch_inertia_kgm2=old.pitch_inertia_kgm2 * yaw,
            hitch_to_cog_m=round(old.hitch_to_cog_m * size, 3),
            front=tyre(old.front),
            rear=tyre(old.rear),
        )

    return replace(
        whole,
        car=body(whole.car),
        trailer=body(whole.trailer),
        nose_load_n=round(float(rng.uniform(500.0, 900.0))),
    )


FIELDS = {
    "mass": "mass_kg",
    "yaw_inertia": "yaw_inertia_kgm2",
    "hitch_to_cog": "hitch_to_cog_m",
}


def believed(whole: Combination, factors: dict[str, float]) -> Combination:
    """The combination as the user believes it to be; `factors` are true over believed."""
    for key, factor in factors.items():
        name, parameter = key.split(".")
        if parameter == "steering_ratio":
            whole = replace(whole, steering_ratio=whole.steering_ratio / factor)
            continue
        body: Body = getattr(whole, name)
        if parameter in FIELDS:
            value = getattr(body, FIELDS[parameter]) / factor
            body = replace(body, **{FIELDS[parameter]: value})
        else:
            place = parameter.split("_")[0]
            axle: Axle = getattr(body, place)
            axle = replace(axle, cornering_stiffness_n_rad=axle.cornering_stiffness_n_rad / factor)
            body = replace(body, **{place: axle})  # type: ignore[arg-type]
        whole = replace(whole, **{name: body})  # type: ignore[arg-type]
    return whole


def with_suspension(whole: Combination) -> Combination:
    """Degressive dampers as in series cars, for bodies that heave, pitch and roll."""
    car, trailer = Damper("normal", 2200.0), Damper("normal", 3500.0)

    def body(old: Body, damper: Damper) -> Body:
        return replace(
            old, front=replace(old.front, damper=damper), rear=replace(old.rear, damper=damper)
        )

    return replace(whole, car=body(whole.car, car), trailer=body(whole.trailer, trailer))


def signals_toml(rear_m: float, dbc: str, hidden: tuple[str, ...], *, trailer: bool) -> str:
    """Roles of the signals; hidden ones are left out. `rear_m`: where LatAccRear1 is believed."""
    rows = [
        ("steering_wheel_angle", '"SteeringWheelAngle"'),
        ("speed", '"VehicleSpeed"'),
        ("car_yaw_rate", '"YawRate1"'),
        (
            "car_lateral_acceleration",
            f'{{ signal = "LatAccRear1", position = {rear_m:.4f} }}',
        ),
        ("trailer_yaw_rate", '"YawRate2"'),
        ("trailer_lateral_acceleration", '{ signal = "LatAcc2", position = 0.0 }'),
        ("wheel_lateral_force", '["FyFL", "FyFR", "FyRL", "FyRR"]'),
        ("wheel_vertical_load", '["FzFL", "FzFR", "FzRL", "FzRR"]'),
    ]
    if trailer:
        rows += [
            ("trailer_wheel_lateral_force", '["FyT1L", "FyT1R", "FyT2L", "FyT2R"]'),
            ("trailer_wheel_vertical_load", '["FzT1L", "FzT1R", "FzT2L", "FzT2R"]'),
        ]
    rows += [("hitch_longitudinal_force", '"HitchFx"'), ("hitch_lateral_force", '"HitchFy"')]
    if trailer:
        rows.append(("hitch_vertical_force", '"HitchFz"'))
    lines = ["# Role of each signal in this recording.", f'dbc = "../{dbc}"', "[signals]"]
    for role, text in rows:
        if not any(f'"{name}"' in text for name in hidden):
            lines.append(f"{role} = {text}")
    return "\n".join(lines) + "\n"


def times(length_s: float) -> Array:
    """Times of a run's inputs."""
    return np.arange(0.0, length_s, 1.0 / RATE_HZ)


def _pulse(time: Array, start: float, length: float) -> Array:
    inside = (time > start) & (time < start + length)
    return np.where(inside, np.sin(np.pi * (time - start) / length), 0.0)


def _restless(time: Array, rng: Generator, size: float) -> Array:
    """Small movements of a driver's hands below 0.6 Hz, rms `size`."""
    white = rng.standard_normal(time.size + 20000)
    shaped = sosfilt(butter(2, 0.5, fs=RATE_HZ, output="sos"), white)[20000:]
    return np.asarray(size * shaped / np.std(shaped))


def _impulses(time: Array, rng: Generator) -> Array:
    first, second = 5.0 + rng.uniform(-0.4, 0.4), 22.0 + rng.uniform(-0.5, 0.5)
    return _pulse(time, first, 0.74) + rng.uniform(0.7, 1.0) * _pulse(time, second, 0.74)


def _slalom(time: Array, rng: Generator) -> Array:
    """Two frequencies and two amplitudes."""
    low, high = rng.uniform(0.5, 0.58), rng.uniform(0.74, 0.84)
    start, change = 2.0, 18.0 + rng.uniform(-0.5, 0.5)
    rise = np.clip((time - start) / 2.0, 0.0, 1.0)
    first = 0.55 * rise * np.sin(2 * np.pi * low * (time - start))
    second = np.sin(2 * np.pi * high * (time - change)) * (time < PATTERN_S)
    return np.where(time < start, 0.0, np.where(time < change, first, second))


def _lane_change(time: Array, rng: Generator) -> Array:
    """An impulse to the right, and later a lane change: out and back."""
    out = -_pulse(time, 3.0 + rng.uniform(-0.4, 0.4), 0.6)
    start, length = 15.0 + rng.uniform(-0.5, 0.5), 1.6
    inside = (time > start) & (time < start + length)
    return out + np.where(inside, 0.6 * np.sin(2 * np.pi * (time - start) / length), 0.0)


SHAPES = {"run1": _impulses, "run2": _slalom, "run3": _lane_change}


def steering(run: str, length_s: float, size_deg: float, seed: int) -> Array:
    """Steering wheel angle of a run, rad; the same seed gives the same shape at any size."""
    rng = np.random.default_rng(seed)
    time = times(length_s)
    shape = SHAPES[run](time, rng)
    for start in np.arange(PATTERN_S, length_s - 10.0, PATTERN_S):
        shape = shape + rng.uniform(0.6, 1.0) * SHAPES[run](time - start, rng) * (time > start)
    return np.asarray(np.radians(size_deg * shape + _restless(time, rng, 0.28)))


def speed(length_s: float, mean_m_s: float, seed: int) -> Array:
    """Speed of a run, m/s: two slow waves about the mean."""
    rng = np.random.default_rng(seed)
    time = times(length_s)
    total = np.full_like(time, mean_m_s)
    for period, size in ((rng.uniform(9.0, 12.0), 0.13), (rng.uniform(14.0, 20.0), 0.1)):
        total += size * np.sin(2 * np.pi * (time / period + rng.random()))
    return np.asarray(total)
