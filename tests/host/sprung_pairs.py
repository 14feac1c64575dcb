"""The same random combinations for the sprung plant and for MuJoCo, its independent reference."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "proof" / "blind"))

from as_plant import constants, springs

from swaywatch.models.multibody import Motion, Multibody
from swaywatch.models.multibody_vehicle import (
    Axle,
    Body,
    Combination,
    Damper,
    Inputs,
    Physics,
    reference_combination,
)
from swaywatch.plant.lanes import OUTPUT, PlantInput, neutral, simulate
from swaywatch.plant.sprung import put

SPACING = 0.01


def drawn(seed: int) -> Combination:
    """A car and a tandem trailer, drawn around the reference combination."""
    draw = np.random.default_rng(seed)

    def about(value: float, spread: float) -> float:
        return float(value * draw.uniform(1.0 - spread, 1.0 + spread))

    def axle(old: Axle, track: float) -> Axle:
        return replace(
            old,
            to_cog_m=old.to_cog_m + float(draw.uniform(-0.06, 0.06)),
            cornering_stiffness_n_rad=about(old.cornering_stiffness_n_rad, 0.15),
            track_m=track,
            spring_n_m=about(old.spring_n_m, 0.25),
            roll_bar_n_m=about(old.roll_bar_n_m, 0.4),
            damper=Damper("linear", about(1800.0, 0.4)),
        )

    def body(old: Body, heights: float) -> Body:
        track = about(old.front.track_m, 0.06)
        long = float(draw.uniform(0.85, 1.2))  # of the inertias that its length makes
        return replace(
            old,
            mass_kg=about(old.mass_kg, 0.15),
            yaw_inertia_kgm2=long * old.yaw_inertia_kgm2,
            pitch_inertia_kgm2=long * old.pitch_inertia_kgm2,
            roll_inertia_kgm2=about(old.roll_inertia_kgm2, 0.2),
            cog_height_m=about(old.cog_height_m, heights),
            hitch_to_cog_m=about(old.hitch_to_cog_m, 0.08),
            front=axle(old.front, track),
            rear=axle(old.rear, track),
        )

    base = reference_combination()
    return replace(base, car=body(base.car, 0.1), trailer=body(base.trailer, 0.2),
                   ball_height_m=about(0.42, 0.1))  # fmt: skip


def harder(whole: Combination, ratio: float) -> Combination:
    """The same with dampers whose rebound is so many times as hard as their compression."""

    def axle(old: Axle) -> Axle:
        return replace(old, damper=Damper("bilinear", old.damper.coefficient_ns_m, ratio=ratio))

    def body(old: Body) -> Body:
        return replace(old, front=axle(old.front), rear=axle(old.rear))

    return replace(whole, car=body(whole.car), trailer=body(whole.trailer))


def manoeuvre(kind: str, degrees: float, until: float) -> tuple[np.ndarray, np.ndarray]:
    """Time and steering-wheel angle: an impulse of the reference's, or a slalom that grows."""
    time = np.arange(0.0, until, SPACING)
    if kind == "impulse":
        inside = (time > 0.5) & (time < 1.24)
        shape = np.where(inside, np.sin(np.pi * (time - 0.5) / 0.74), 0.0)
    else:
        shape = np.sin(2.0 * np.pi * 0.45 * time) * np.clip(time / 2.0, 0.0, 1.0)
    return time, np.radians(degrees) * shape


def both(
    whole: Combination,
    physics: Physics,
    slots: dict[str, float],
    drive: tuple[np.ndarray, np.ndarray],
    speed: float,
    amplitude: np.ndarray | None = None,
) -> tuple[Motion, dict[str, np.ndarray]]:
    """The motion in MuJoCo, and the plant's outputs for its road-wheel angle and speed.

    `amplitude`: of the load at twice the yaw frequency, on the axle of `physics`.
    """
    time, wheel = drive
    inputs = Inputs(time, wheel, np.full_like(time, speed), harmonic_n=amplitude)
    motion = Multibody(whole, physics).run(inputs).resample(time)
    plant = PlantInput(
        SPACING,
        motion.speed_m_s,
        np.gradient(motion.speed_m_s, SPACING),
        motion.road_wheel_rad,
        constants(whole),
        put(put(neutral(), springs(whole)), slots),
    )
    if physics.axle_load is not None:
        plant.add_series(f"load_{physics.axle_load.axle}", motion.harmonic_n)
        plant.scalar("load_by_struts", 1.0)
    found = simulate(plant)
    return motion, {name: found[:, index] for index, name in enumerate(OUTPUT)}


def differences(motion: Motion, found: dict[str, np.ndarray]) -> dict[str, float]:
    """RMS of the difference over the RMS of MuJoCo's channel; of loads, their change."""
    pairs = {
        "car_yaw_rate": motion.yaw_rate_rad_s, "trailer_yaw_rate": motion.trailer_yaw_rate_rad_s,
        "hitch_y": motion.hitch_y_n, "car_acceleration": motion.car_acceleration_m_s2,
        "trailer_acceleration": motion.trailer_acceleration_m_s2,
        "car_roll": motion.roll_rad, "trailer_roll": motion.trailer_roll_rad,
    }  # fmt: skip
    for wheel in range(8):
        prefix = "" if wheel < 4 else "trailer_"
        name = f"{prefix}vertical_{('fl', 'fr', 'rl', 'rr')[wheel % 4]}"
        pairs[name] = motion.wheel_fz_n[wheel] - motion.wheel_fz_n[wheel, 0]
        found = found | {name: found[name] - found[name][0]}
    return {
        name: float(np.sqrt(np.mean((found[name] - judge) ** 2) / np.mean(judge**2)))
        for name, judge in pairs.items()
    }
