"""Relations of the model in isolation: each from measured signals alone, by window and line.

No feedback can smear a fault here: a relation breaks only if its own signals or its own physics
are wrong. Slip needs the lateral velocity; the same first-order high-pass on both sides of a
relation takes the place of an integration that would drift.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bilinear, lfilter

from swaywatch.effects.runs import RATE_HZ, Run, low_pass

Array = NDArray[np.float64]

CORNER_RAD_S = 2.5
CUTOFF_HZ = 4.0
WINDOW_S = 3.0
HOP_S = 0.5
LINES = ("mean", "f", "2f", "3f", "broadband")


@dataclass(frozen=True)
class Residual:
    """Mismatch of one relation over one run.

    Attributes
    ----------
    name
        For the report.
    residual
        Shape (n,), N or Nm.
    size
        RMS of the largest term of the relation.
    """

    name: str
    residual: Array
    size: float


def _high(x: Array) -> Array:
    b, a = bilinear([1.0, 0.0], [1.0, CORNER_RAD_S], RATE_HZ)
    return np.asarray(lfilter(b, a, x - x[0]))


def _integral(x: Array) -> Array:
    b, a = bilinear([1.0], [1.0, CORNER_RAD_S], RATE_HZ)
    return np.asarray(lfilter(b, a, x))


def relations(run: Run, body: Array) -> list[Residual]:
    """All relations that the recorded channels allow."""
    c = {name: low_pass(v - v.mean(), CUTOFF_HZ) for name, v in run.channels.items()}
    m1, iz1, lf, lr, lh, cf, cr = body[:7]
    v = run.speed
    found: list[Residual] = []

    def add(name: str, *terms: Array) -> None:
        found.append(Residual(name, sum(terms, np.zeros(v.size)), _rms(*terms)))

    front, rear = _pair(c, "f"), _pair(c, "r")
    hitch = c.get("hitch_lateral_force")
    if "car_yaw_rate" in c and "car_lateral_acceleration" in c:
        r = c["car_yaw_rate"]
        rd = np.gradient(r) * RATE_HZ
        ay = c["car_lateral_acceleration"] - run.positions["car_lateral_acceleration"] * rd
        vy = _integral(ay - v * r)
        steer = low_pass(run.steer - run.steer.mean(), CUTOFF_HZ)
        if front is not None:
            add("front force / slip", _high(front), -cf * (_high(steer) - (vy + lf * _high(r)) / v))
        if rear is not None:
            add("rear force / slip", _high(rear), cr * (vy - lr * _high(r)) / v)
        if front is not None and rear is not None and hitch is not None:
            add("car lateral balance", m1 * ay, -front, -rear, -hitch)
            add("car yaw balance", iz1 * rd, -lf * front, lr * rear, lh * hitch)
    found += _trailer(run, c, body, hitch)
    for axle, words in (("f", "front"), ("r", "rear")):
        names = [f"wheel_vertical_load_{axle}l", f"wheel_vertical_load_{axle}r"]
        if all(name in c for name in names):
            total = c[names[0]] + c[names[1]]
            found.append(Residual(f"{words} axle load", total, _rms(c[names[0]])))
    return found


def _trailer(run: Run, c: dict[str, Array], body: Array, hitch: Array | None) -> list[Residual]:
    if hitch is None or not {"trailer_yaw_rate", "trailer_lateral_acceleration"} <= set(c):
        return []
    m2, iz2, lf2, lr2, lh2, cf2, cr2 = body[7:14]
    v = run.speed
    r = c["trailer_yaw_rate"]
    rd = np.gradient(r) * RATE_HZ
    ay = c["trailer_lateral_acceleration"]
    ay = ay - run.positions.get("trailer_lateral_acceleration", 0.0) * rd
    vy = _integral(ay - v * r)
    one = -cf2 * (vy + lf2 * _high(r)) / v
    two = -cr2 * (vy - lr2 * _high(r)) / v
    lateral = (m2 * _high(ay), _high(hitch), -one, -two)
    yaw = (iz2 * _high(rd), lh2 * _high(hitch), -lf2 * one, lr2 * two)
    return [
        Residual("trailer lateral balance", sum(lateral, np.zeros(v.size)), _rms(*lateral)),
        Residual("trailer yaw balance", sum(yaw, np.zeros(v.size)), _rms(*yaw)),
    ]


def _pair(c: dict[str, Array], axle: str) -> Array | None:
    names = [f"wheel_lateral_force_{axle}l", f"wheel_lateral_force_{axle}r"]
    return c[names[0]] + c[names[1]] if all(name in c for name in names) else None


def _rms(*terms: Array) -> float:
    return max(float(np.sqrt(np.mean(term**2))) for term in terms) + 1e-9


def yaw_frequency(run: Run) -> float:
    """Strongest line of the trailer's (else the car's) yaw rate, Hz."""
    name = "trailer_yaw_rate" if "trailer_yaw_rate" in run.channels else "car_yaw_rate"
    x = run.channels[name] - run.channels[name].mean()
    grid = np.linspace(0.2, 1.5, 131)
    t = run.time - run.time[0]
    power = np.abs(np.exp(-2j * np.pi * np.outer(grid, t)) @ (x * np.hanning(x.size)))
    return float(grid[int(np.argmax(power))])


def line_map(run: Run, relation: Residual) -> tuple[Array, Array]:
    """Mismatch of a relation in windows, by line, in per cent of its largest term.

    Returns
    -------
    times
        Middles of the windows, shape (w,), s.
    values
        Shape (w, len(LINES)).
    """
    f = yaw_frequency(run)
    half = int(WINDOW_S * RATE_HZ / 2)
    centres = np.arange(half, run.time.size - half, int(HOP_S * RATE_HZ))
    rows = []
    for centre in centres:
        part = slice(centre - half, centre + half)
        t = run.time[part] - run.time[centre]
        columns = [np.ones(t.size)]
        for order in (1, 2, 3):
            phase = 2.0 * np.pi * order * f * t
            columns += [np.cos(phase), np.sin(phase)]
        a = np.stack(columns, axis=1)
        x = np.linalg.lstsq(a, relation.residual[part], rcond=None)[0]
        rest = relation.residual[part] - a @ x
        lines = [abs(x[0]), *(np.hypot(x[1 + 2 * i], x[2 + 2 * i]) for i in range(3))]
        rows.append([*lines, 1.4142 * float(np.sqrt(np.mean(rest**2)))])
    values = 100.0 * np.array(rows) / (1.4142 * relation.size)
    return run.time[centres], values
