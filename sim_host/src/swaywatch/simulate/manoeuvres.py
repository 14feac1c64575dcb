"""Manoeuvres: what the driver means to do, and what road and wind do.

Each is a function of a table of the scenario; several add up. Steering angles are at the steering
wheel in deg, speeds in km/h in the scenario, SI inside.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from swaywatch.errors import ScenarioError
from swaywatch.models.physics import PhysicsEffect
from swaywatch.plant.layout import Array
from swaywatch.simulate.table import Table

KMH = 3.6


@dataclass
class Plan:
    """What the manoeuvres add up to, on ``time_s``.

    Attributes
    ----------
    steering_rad : (n,) array, meant steering-wheel angle
    speed_m_s : (n,) array, meant speed
    effects : road and wind as physics of the model
    impulses_s : times at which a steering impulse has ended: free oscillations start there
    """

    time_s: Array
    steering_rad: Array
    speed_m_s: Array
    effects: list[PhysicsEffect] = field(default_factory=list)
    impulses_s: list[float] = field(default_factory=list)


Manoeuvre = Callable[[Plan, Table], None]


def _steering(table: Table, default: float | None = None) -> float:
    return math.radians(table.number("angle_deg", -720.0, 720.0, "deg", default))


def _start(table: Table, plan: Plan) -> float:
    return table.number("start_s", float(plan.time_s[0]), float(plan.time_s[-1]), "s", 1.0)


def _half_sine(plan: Plan, start: float, angle: float, frequency: float) -> None:
    phase = 2.0 * math.pi * frequency * (plan.time_s - start)
    inside = (phase > 0.0) & (phase < math.pi)
    plan.steering_rad += np.where(inside, angle * np.sin(phase), 0.0)
    plan.impulses_s.append(start + 0.5 / frequency)


def impulse(plan: Plan, table: Table) -> None:
    """Half-sine steering impulse (ISO 9815; Zhang 2015, 5.2.5: 19 deg, 0.675 Hz)."""
    _half_sine(
        plan,
        _start(table, plan),
        _steering(table, 19.0),
        table.number("frequency_hz", 0.1, 5.0, "Hz", 0.675),
    )


def double_impulse(plan: Plan, table: Table) -> None:
    """Two half-sine impulses; the second by default to the other side."""
    start, angle = _start(table, plan), _steering(table, 19.0)
    frequency = table.number("frequency_hz", 0.1, 5.0, "Hz", 0.675)
    gap = table.number("gap_s", 0.0, 120.0, "s", 10.0)
    sign = -1.0 if table.flag("opposite", True) else 1.0
    _half_sine(plan, start, angle, frequency)
    _half_sine(plan, start + 0.5 / frequency + gap, sign * angle, frequency)


def impulse_ladder(plan: Plan, table: Table) -> None:
    """Impulses at a ladder of speeds (ISO 9815): reach the speed, settle, impulse, wait."""
    speeds = table.raw("speeds_kmh")
    if not isinstance(speeds, list) or not speeds:
        raise ScenarioError(f"{table.place}: speeds_kmh must be a list of speeds in km/h")
    hold = table.number("hold_s", 2.0, 300.0, "s", 14.0)
    settle = table.number("settle_s", 0.5, 60.0, "s", 3.0)
    rate = table.number("acceleration_m_s2", 0.05, 3.0, "m/s2", 0.5)
    angle, frequency = _steering(table, 19.0), table.number("frequency_hz", 0.1, 5.0, "Hz", 0.675)
    moment = _start(table, plan)
    for number, speed in enumerate(speeds):
        if isinstance(speed, bool) or not isinstance(speed, (int, float)) or not 5 <= speed <= 300:
            raise ScenarioError(f"{table.place}: speeds_kmh holds {speed!r}; expected 5 to 300")
        target = speed / KMH
        before = float(np.interp(moment, plan.time_s, plan.speed_m_s))
        ramp = abs(target - before) / rate
        _to_speed(plan, moment, ramp, target)
        moment += ramp + settle
        _half_sine(plan, moment, angle * (-1.0) ** number, frequency)
        moment += hold
    if moment > plan.time_s[-1] + 1e-9:
        raise ScenarioError(
            f"{table.place}: the ladder takes {moment:.1f} s, the scenario has "
            f"{plan.time_s[-1]:.1f} s; raise duration_s"
        )


def slalom(plan: Plan, table: Table) -> None:
    """Steering as a sine with soft start and end."""
    start = _start(table, plan)
    duration = table.number("duration_s", 0.5, 3600.0, "s", 10.0)
    frequency = table.number("frequency_hz", 0.05, 5.0, "Hz", 0.5)
    soft = table.number("soft_s", 0.0, 60.0, "s", 1.0)
    since = plan.time_s - start
    plan.steering_rad += (
        _steering(table, 15.0) * np.sin(2.0 * math.pi * frequency * since)
        * _window(since, duration, soft)
    )  # fmt: skip


def sine_sweep(plan: Plan, table: Table) -> None:
    """Sine of constant amplitude whose frequency grows evenly on a logarithmic scale."""
    start = _start(table, plan)
    duration = table.number("duration_s", 1.0, 3600.0, "s", 40.0)
    low = table.number("from_hz", 0.02, 10.0, "Hz", 0.1)
    high = table.number("to_hz", 0.02, 10.0, "Hz", 2.0)
    since = plan.time_s - start
    rate = math.log(high / low) / duration
    if rate == 0.0:
        raise ScenarioError(f"{table.place}: from_hz and to_hz must differ")
    phase = 2.0 * math.pi * low * np.expm1(rate * np.clip(since, 0.0, duration)) / rate
    soft = table.number("soft_s", 0.0, 60.0, "s", 1.0)
    plan.steering_rad += _steering(table, 10.0) * np.sin(phase) * _window(since, duration, soft)


def lane_change(plan: Plan, table: Table) -> None:
    """One period of a sine: out of the lane and straight again."""
    start, angle = _start(table, plan), _steering(table, 20.0)
    frequency = table.number("frequency_hz", 0.05, 2.0, "Hz", 0.3)
    phase = 2.0 * math.pi * frequency * (plan.time_s - start)
    inside = (phase > 0.0) & (phase < 2.0 * math.pi)
    plan.steering_rad += np.where(inside, angle * np.sin(phase), 0.0)
    plan.impulses_s.append(start + 1.0 / frequency)


def steady_circle(plan: Plan, table: Table) -> None:
    """Steering ramps to an angle and stays there (ISO 4138)."""
    ramp = table.number("ramp_s", 0.05, 600.0, "s", 3.0)
    since = plan.time_s - _start(table, plan)
    plan.steering_rad += _steering(table, 30.0) * np.clip(since / ramp, 0.0, 1.0)


def gust(plan: Plan, table: Table) -> None:
    """A gust from the side on car or trailer (physics ``crosswind_gust``)."""
    start = _start(table, plan)
    duration = table.number("duration_s", 0.1, 600.0, "s", 1.5)
    _effect(plan, table, "crosswind_gust", start, duration, "force_n")


def banked_road(plan: Plan, table: Table) -> None:
    """A stretch of banked road (physics ``road_bank``)."""
    start = _start(table, plan)
    duration = table.number("duration_s", 0.1, 3600.0, "s", 10.0)
    _effect(plan, table, "road_bank", start, duration, "angle_deg")


def change_speed(plan: Plan, table: Table) -> None:
    """Accelerate or brake to a speed, with constant acceleration and rounded corners."""
    target = table.number("speed_kmh", 5.0, 300.0, "km/h") / KMH
    rate = table.number("acceleration_m_s2", 0.05, 9.0, "m/s2", 1.0)
    start = _start(table, plan)
    before = float(np.interp(start, plan.time_s, plan.speed_m_s))
    _to_speed(plan, start, abs(target - before) / rate, target)


MANOEUVRES: dict[str, Manoeuvre] = {
    "impulse": impulse,
    "double_impulse": double_impulse,
    "impulse_ladder": impulse_ladder,
    "slalom": slalom,
    "sine_sweep": sine_sweep,
    "lane_change": lane_change,
    "steady_circle": steady_circle,
    "gust": gust,
    "banked_road": banked_road,
    "accelerate": change_speed,
    "brake": change_speed,
}
"""Manoeuvres by the word for ``kind``."""


def make_plan(time_s: Array, speed_m_s: float, tables: list[Table]) -> Plan:
    """Add up the manoeuvres of a scenario, in the order they are written."""
    plan = Plan(time_s, np.zeros(time_s.size), np.full(time_s.size, speed_m_s))
    for table in tables:
        MANOEUVRES[table.word("kind", list(MANOEUVRES))](plan, table)
        table.done()
    return plan


def _to_speed(plan: Plan, start: float, ramp: float, target: float) -> None:
    before = float(np.interp(start, plan.time_s, plan.speed_m_s))
    share = np.clip((plan.time_s - start) / max(ramp, 1e-9), 0.0, 1.0)
    after = plan.time_s >= start
    plan.speed_m_s = np.where(after, before + share * (target - before), plan.speed_m_s)


def _window(since: Array, duration: float, soft: float) -> Array:
    """1 inside, with cosine flanks of length ``soft``."""
    edge = np.minimum(since, duration - since)
    if soft <= 0.0:
        return (edge >= 0.0).astype(float)
    return np.asarray(0.5 - 0.5 * np.cos(math.pi * np.clip(edge / soft, 0.0, 1.0)))


def _effect(
    plan: Plan, table: Table, effect: str, start: float, duration: float, value: str
) -> None:
    window: dict[str, Any] = {"start_s": start, "stop_s": start + duration}
    rest = {key: item for key, item in table.rest().items() if key != "kind"}
    if value in rest:
        window[value] = rest.pop(value)
    try:
        plan.effects.append(PhysicsEffect(effect, windows=[window], **rest))
    except (ValueError, TypeError) as error:
        raise ScenarioError(f"{table.place}: {error}") from None
