"""Axle load oscillating at twice the yaw frequency, in windows (4.4.2, 6.2).

The phase is that of the load against the square of the axle's lateral force, lead positive. For
the trailer, whose forces may not be measured, the trailer's lateral acceleration stands for it.
On a body that heaves a share of it is a force of the struts: what presses a wheel down lifts the
body (`load_by_struts`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.signal import hilbert, lfilter

from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Act, Array, Effect, Parameter, Values, Window
from swaywatch.effects.runs import RATE_HZ, Run, band_pass, low_pass
from swaywatch.plant.lanes import PlantInput

LARGEST_N = 3000.0  # beyond it a wheel would leave the road
LEAST_N = 40.0  # that is worth a claim
LEAST_ON_SPRINGS_N = 100.0  # a body bounces on its springs at the same line: known to about 50 N
LONGEST_DELAY_S = 1.2  # tried in a search; a fit may go further
LEAST_YAW = 1e-7  # (rad/s)^2, below it there is no load
MEAN_TIME_S = 1.0  # of the running mean that the generator takes away


def force_phase(run: Run, axle: str) -> Array:
    """Instantaneous phase of the axle's lateral force, rad, shape (n,)."""
    key = f"_phase_{axle}"
    if key not in run.simulated:
        c = run.channels
        pair = {"car_front": ("fl", "fr"), "car_rear": ("rl", "rr")}.get(axle, ())
        names = [f"wheel_lateral_force_{wheel}" for wheel in pair]
        if names and all(name in c for name in names):
            signal = c[names[0]] + c[names[1]]
        elif axle.startswith("trailer") and "trailer_lateral_acceleration" in c:
            signal = c["trailer_lateral_acceleration"]
        else:
            signal = c["car_lateral_acceleration"]
        run.simulated[key] = np.unwrap(np.angle(hilbert(band_pass(signal, 0.25, 1.5))))
    return run.simulated[key]


def frequency(run: Run, axle: str, window: Window) -> float:
    """Mean frequency of the axle's force in a window, Hz."""
    inside = (run.time >= window.start) & (run.time <= window.stop)
    if np.count_nonzero(inside) < 10:
        return float("nan")
    slope = np.polyfit(run.time[inside], force_phase(run, axle)[inside], 1)[0]
    return float(slope / (2.0 * np.pi))


def _act(axle: str) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del values
        if not windows:
            return
        phase = force_phase(run, axle)
        total = np.zeros_like(phase)
        for window in windows:
            v = window.values
            inside, mask = window.part(run.time)
            twice = 2.0 * phase[inside]
            load = v["in_phase_n"] * np.cos(twice) - v["quadrature_n"] * np.sin(twice)
            total[inside] += load * mask
        plant.add_series(f"load_{axle}", total)

    return act


def _generator(run: Run, delay: float, window: Window) -> Array:
    """The generator's load in a window, gain one (Eq. 6.1): square of the yaw rate, less its mean.

    Over the mean of the square in the window, so that the gain is the load's amplitude there.
    """
    if "_square" not in run.simulated:
        rate = low_pass(run.channels["car_yaw_rate"], 6.0)
        q = (rate - np.median(rate)) ** 2  # straight ahead for most of the time: its offset
        step = 1.0 / (RATE_HZ * MEAN_TIME_S)
        run.simulated["_high_pass"] = q - lfilter([step], [1.0, step - 1.0], q)
        run.simulated["_square"] = q  # last: other threads look for it
    inside, mask = window.part(run.time)
    square = float(np.dot(mask, run.simulated["_square"][inside]))
    size = square / max(float(np.sum(mask)), 1.0)
    late = np.interp(run.time[inside] - delay, run.time, run.simulated["_high_pass"])
    return np.asarray(late / (size + LEAST_YAW))


def _act_generator(axle: str) -> Act:
    def act(plant: PlantInput, run: Run, values: Values, windows: Sequence[Window]) -> None:
        del values
        total = np.zeros_like(run.time)
        for window in windows:
            inside, mask = window.part(run.time)
            load = window.values["gain_n"] * _generator(run, window.values["delay_s"], window)
            total[inside] += load * mask
        if windows:
            plant.add_series(f"load_{axle}", total)

    return act


def generator_effect(axle: str, least: float = LEAST_N) -> Effect:
    """The form of the effect whose load the car's own motion makes."""
    return Effect(
        id="axle_load_harmonic",
        component=axle,
        kind="physics",
        equation="F_z = F_z0 + gain (q - mean(q))(t - delay) / mean(q), q: yaw rate squared",
        source="Eq. 6.1 and 6.2, Fig. 6-3",
        parameters=(
            Parameter("gain_n", "N", 0.0, 0.0, LARGEST_N, (500.0,), 20.0, least),
            Parameter("delay_s", "s", 0.0, -0.3, 3.0, (0.1,), 0.01),
        ),
        act=_act_generator(axle),
        windowed=True,
        lines=("2f",),
        decided_by="wheel loads of the axle",
        extra={
            "describe": lambda run, window: _describe(run, axle, window),
            "form": "generator",
            "follows_motion": True,
            "final": True,
        },
    )


def _describe(run: Run, axle: str, window: Window) -> dict[str, float]:
    """Amplitude and phase of the load at 2 f in a window."""
    inside = window.mask(run.time) > 0.5
    f = frequency(run, axle, window)
    if "gain_n" in window.values:
        part, _ = window.part(run.time)
        load = window.values["gain_n"] * _generator(run, window.values["delay_s"], window)
        load = load[inside[part]]
        phase = 2.0 * force_phase(run, axle)[inside]
        columns = np.stack([np.cos(phase), -np.sin(phase), np.ones(phase.size)], axis=1)
        a, b, _ = np.linalg.lstsq(columns, load, rcond=None)[0]
    else:
        a, b = window.values["in_phase_n"], window.values["quadrature_n"]
    return {
        "amplitude_n": float(np.hypot(a, b)),
        "phase_deg": float(np.degrees(np.arctan2(b, a))),
        "frequency_hz": f,
    }


def _as_generator(run: Run, axle: str, window: Window, load: Array) -> tuple[float, float]:
    """Gain and delay of the generator whose load is nearest to some course of it."""
    inside = (run.time >= window.start) & (run.time <= window.stop)
    part, _ = window.part(run.time)
    phase = 2.0 * force_phase(run, axle)[inside]
    best = (np.inf, 0.0, 0.0)
    turn = (run.time[inside][-1] - run.time[inside][0]) / max(float(np.ptp(phase)), 1e-6)
    for delay in np.arange(0.0, 2.0 * np.pi * turn, 0.02):
        g = _generator(run, float(delay), window)[inside[part]]
        gain = float(np.dot(g, load) / (np.dot(g, g) + 1e-12))
        rest = float(np.sum((load - gain * g) ** 2))
        if gain > 0.0 and rest < best[0]:
            best = (rest, gain, float(delay))
    return best[1], best[2]


def _refine(term: ActiveEffect, runs: Sequence[Run]) -> ActiveEffect | None:
    """The same windows with the generator's load, gains and delays fitted to the lines found."""
    axle = term.effect.component
    values: list[float] = []
    for w, index in enumerate(term.window_runs):
        run = runs[index]
        start, stop, a, b = term.values[w * 4 : w * 4 + 4]
        inside = (run.time >= start) & (run.time <= stop)
        if np.count_nonzero(inside) < 20:
            return None
        phase = 2.0 * force_phase(run, axle)[inside]
        load = a * np.cos(phase) - b * np.sin(phase)
        values += [start, stop, *_as_generator(run, axle, Window(start, stop, {}), load)]
    least = term.effect.parameters[0].minimum
    return ActiveEffect(generator_effect(axle, least), tuple(values), term.window_runs)


def _trials(axle: str, start: float, stop: float, run: int, least: float) -> list[ActiveEffect]:
    """The generator's load in a stretch of a run, with every delay that is worth a try."""
    effect = generator_effect(axle, least)
    delays = np.arange(0.0, LONGEST_DELAY_S, 0.08)
    return [ActiveEffect(effect, (start, stop, 300.0, float(delay)), (run,)) for delay in delays]


def _effect(axle: str, least: float) -> Effect:
    """The effect, said from an amplitude of `least` N."""
    return Effect(
        id="axle_load_harmonic",
        component=axle,
        kind="physics",
        equation="F_z = F_z0 + amplitude cos(2 phi + phase), phi: phase of the lateral force",
        source="section 4.4.2 and 6.2",
        parameters=(
            Parameter("in_phase_n", "N", 0.0, -LARGEST_N, LARGEST_N, (300.0,), 20.0, least),
            Parameter("quadrature_n", "N", 0.0, -LARGEST_N, LARGEST_N, (0.0,), 20.0, least),
        ),
        act=_act(axle),
        windowed=True,
        lines=("2f",),
        decided_by="wheel loads of the axle",
        extra={
            "describe": lambda run, window: _describe(run, axle, window),
            "refine": _refine,
            "trials": partial(_trials, least=least),
            "follows_motion": True,
        },
    )


def _with_springs(axle: str) -> Effect:
    """The effect, and how it is said beside a vehicle on springs."""
    return replace(_effect(axle, LEAST_N), on_springs=_effect(axle, LEAST_ON_SPRINGS_N))


EFFECTS = [
    _with_springs(axle) for axle in ("car_front", "car_rear", "trailer_front", "trailer_rear")
]
