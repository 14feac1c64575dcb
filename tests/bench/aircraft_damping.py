"""Simulated aircraft with a yaw damper: do the intervals of `swaywatch damping` hold the truth?

    python tests/bench/aircraft_damping.py [--first 200] [--count 60]

Lateral motion of rigid aircraft (side-slip, roll rate, yaw rate, bank), derivatives drawn about
those of a light one; in two thirds a damper with washout moves the rudder. A pilot gives doublets
of the rudder, a gust of 1 s correlation time is a side-slip of 0.1 to 0.6 deg RMS. Seeds from 200
on were not used to set any rule.
"""

from __future__ import annotations

import argparse
import itertools
import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import signal

from swaywatch.damping.data import NO_SIGNAL, Choice
from swaywatch.damping.study import StudyPlan, evaluate

Array = npt.NDArray[np.float64]

HEAD = "time_s,roll_rate_deg_s,yaw_rate_deg_s,pilot_rudder_deg,tas_m_s"
WASHOUT_S = 1.5
BINS = (0.0, 0.25, 0.35, 0.5, 0.8)


def aircraft(rng: np.random.Generator) -> tuple[Array, Array, float]:
    """State matrix (side-slip, roll rate, yaw rate, bank, washed-out yaw rate), inputs, gain.

    Inputs: the pilot's rudder and the gust's side-slip.
    """

    def about(middle: float, spread: float) -> float:
        return float(middle * math.exp(rng.normal() * spread))

    while True:
        s = rng.uniform(0.6, 1.6)
        side, roll_beta, roll_p = about(0.25, 0.3) * s, about(16, 0.4) * s * s, about(8.4, 0.3) * s
        roll_r, yaw_beta, yaw_p = about(2.2, 0.3) * s, about(4.5, 0.3) * s * s, about(0.35, 0.3) * s
        a = np.zeros((5, 5))
        a[0, :4] = [-side, 0.0, -1.0, 0.18 * s]
        a[1, :3] = [-roll_beta, -roll_p, roll_r]
        a[2, :3] = [yaw_beta, -yaw_p, -about(0.76, 0.3) * s]
        a[3, 1] = 1.0
        a[4, 2], a[4, 4] = 1.0 / WASHOUT_S, -1.0 / WASHOUT_S
        aileron = np.array([0.0, 29.0, -0.2, 0.0, 0.0]) * s * s
        a += np.outer(aileron, [0.0, -0.01, 0.0, -0.02, 0.0])  # the pilot keeps the wings level
        rudder = np.array([0.07 / s, 2.5, -4.6, 0.0, 0.0]) * s * s
        gain = float(rng.choice([0.0, 0.26, 0.39]))
        closed = a + gain * np.outer(rudder, [0.0, 0.0, 1.0, 0.0, -1.0])
        poles = np.linalg.eigvals(closed)
        if poles.real.max() < 0.03 and (poles.imag > 0.8).sum() == 1:
            return closed, np.stack([rudder, a[:, 0]], axis=1), gain


def record(rng: np.random.Generator, path: Path) -> complex:
    """Write 200 s with their doublets; the pole of the swing."""
    a, b, _ = aircraft(rng)
    poles = np.linalg.eigvals(a)
    pole = complex(poles[np.argmax(poles.imag)])
    rate = float(rng.choice([20.0, 25.0, 50.0, 100.0]))
    time = np.arange(round(200.0 * rate)) / rate
    period = 2 * math.pi / pole.imag
    phase = (time % max(15.0, 6.0 * period) - 4.0) / period
    doublet = 1.0 * ((phase >= 0.0) & (phase < 0.5)) - 1.0 * ((phase >= 0.5) & (phase < 1.0))
    pilot = math.radians(rng.uniform(3.0, 6.0)) * doublet
    keep = math.exp(-1.0 / rate)
    size = math.radians(rng.uniform(0.1, 0.6)) * math.sqrt(1 - keep**2)
    noise = rng.normal(0.0, size, len(time))
    gust = np.asarray(signal.lfilter([1.0], [1.0, -keep], noise), dtype=np.float64)
    force: Array = np.asarray(np.column_stack([pilot, gust]), dtype=np.float64)
    system: Any = signal.StateSpace(a, b, np.eye(5), np.zeros((5, 2)))
    _, state, _ = signal.lsim(system, force, time)
    seen = np.degrees(state[:, 1:3]) + 0.05 * rng.normal(size=(len(time), 2))
    columns = [time, *np.round(seen.T, 2), np.degrees(pilot), np.full(len(time), 80.0)]
    np.savetxt(path, np.stack(columns, axis=1), delimiter=",", header=HEAD, comments="")
    return pole


def main() -> None:
    """Print a line for each range of the damping ratio."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--first", type=int, default=200)
    parser.add_argument("--count", type=int, default=60)
    choice = parser.parse_args()
    rows: dict[str, list[tuple[float, float, bool, bool]]] = {"by name": [], NO_SIGNAL: []}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(choice.first, choice.first + choice.count):
            path = Path(folder) / "flight.csv"
            pole = record(np.random.default_rng(seed), path)
            truth, frequency = -pole.real / abs(pole), pole.imag / (2 * math.pi)
            for name, own in rows.items():
                inputs = (NO_SIGNAL,) if name == NO_SIGNAL else ()
                study = evaluate([path], StudyPlan(Choice(inputs=inputs)))
                for place in study.places[:1]:
                    ratio, hz = place.damping_ratio, place.frequency_hz
                    if place.determinable:
                        inside = ratio.low <= truth <= ratio.high
                        own.append(
                            (truth, ratio.value - truth, inside, hz.low <= frequency <= hz.high)
                        )
    for name, own in rows.items():
        for low, high in itertools.pairwise(BINS):
            part = [row for row in own if low <= row[0] < high]
            if part:
                middle = float(np.median([row[1] for row in part]))
                print(
                    f"input {name}, damping ratio {low:g} to {high:g}: {len(part)} flights, error "
                    f"{middle:+.3f} in the median, intervals hold {sum(r[2] for r in part)}, "
                    f"of the frequency {sum(r[3] for r in part)}"
                )


if __name__ == "__main__":
    main()
