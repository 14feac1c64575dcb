"""A plan as files: a scenario that ``simulate`` runs, and steering and speed for a robot."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from swaywatch.plan.design import BLOCK_S, Block, Design
from swaywatch.simulate.scenario import load_scenario

ACCELERATION_M_S2 = 0.5
SETTLE_S = 4.0
"""Steady speed before a block begins."""
ROBOT_STEP_S = 0.01


def courses(blocks: tuple[Block, ...]) -> tuple[list[dict[str, Any]], float, float]:
    """Manoeuvres of a whole scenario, its duration in s and its first speed in km/h."""
    tables: list[dict[str, Any]] = []
    moment, speed = SETTLE_S, blocks[0].speed_kmh
    first = speed
    for block in blocks:
        if block.speed_kmh != speed:
            tables.append(
                {
                    "kind": "accelerate" if block.speed_kmh > speed else "brake",
                    "start_s": round(moment, 2), "speed_kmh": block.speed_kmh,
                    "acceleration_m_s2": ACCELERATION_M_S2,
                }
            )  # fmt: skip
            moment += abs(block.speed_kmh - speed) / 3.6 / ACCELERATION_M_S2 + SETTLE_S
            speed = block.speed_kmh
        tables += [{**t, "start_s": round(moment + t["start_s"], 2)} for t in block.tables]
        if any(t["kind"] == "steady_circle" for t in block.tables):
            # out of the circle again, before anything else begins
            circle = next(t for t in block.tables if t["kind"] == "steady_circle")
            back = {**circle, "angle_deg": -circle["angle_deg"], "ramp_s": 1.0}
            tables.append({**back, "start_s": round(moment + BLOCK_S, 2)})
            moment += SETTLE_S
        moment += BLOCK_S
    return tables, moment + 1.0, first


def scenario_text(design: Design, vehicle: Path, out: Path) -> str:
    """TOML of the plan; `out` is the folder it is for."""
    tables, duration, first = courses(design.blocks)
    file = os.path.relpath(vehicle.resolve(), out.resolve())
    lines = [
        f"# Test plan by `swaywatch plan`: {len(design.blocks)} blocks, fastest "
        f"{design.limits.fastest_kmh:.0f} km/h, lateral acceleration up to "
        f"{design.limits.acceleration_m_s2:g} m/s2.",
        f'vehicle = "{Path(file).as_posix()}"',
        f"duration_s = {duration:.2f}",
        f"speed_kmh = {first:.1f}",
    ]
    for table in tables:
        lines += ["", "[[manoeuvre]]"]
        lines += [
            f'{key} = "{value}"' if isinstance(value, str) else f"{key} = {value!r}"
            for key, value in table.items()
        ]
    return "\n".join([*lines, ""])


def robot_text(scenario: Path) -> str:
    """CSV of the scenario for a steering robot: time, steering-wheel angle, speed."""
    plan = load_scenario(scenario).plan
    time = np.arange(0.0, float(plan.time_s[-1]) + 1e-9, ROBOT_STEP_S)
    steer = np.degrees(np.interp(time, plan.time_s, plan.steering_rad))
    speed = 3.6 * np.interp(time, plan.time_s, plan.speed_m_s)
    rows = [f"{t:.2f},{a:.3f},{v:.2f}" for t, a, v in zip(time, steer, speed, strict=True)]
    return "\n".join(["time_s,steering_wheel_angle_deg,speed_kmh", *rows, ""])
