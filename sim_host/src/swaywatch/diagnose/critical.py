"""Critical speed of the plant with and without what was diagnosed: what it means for stability.

The linear single-track model (Eq. 3.38-3.43) knows only stiffnesses and masses; relaxation,
compliance, friction or load transfer it does not. So the plant itself is kicked by a half sine of
steering at constant speed, and the speed is sought at which its free oscillation neither grows nor
decays. With friction and saturation that depends on the size of the kick: it is that of the road
test (19 deg at the steering wheel, 0.675 Hz).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.fit import Problem
from swaywatch.diagnose.plant import OUTPUT, PlantInput, neutral, simulate
from swaywatch.diagnose.runs import RATE_HZ, Run
from swaywatch.diagnose.term import Term

Array = NDArray[np.float64]

KICK_DEG, KICK_HZ = 19.0, 0.675
LENGTH_S = 34.0
EARLY_S, LATE_S, SPAN_S = 16.0, 28.0, 5.0
CALM = -0.002  # 1/s: saturating tyres hold an oscillation, which then neither grows nor decays
SLOWEST, FASTEST, STEP = 10.0, 80.0, 5.0  # m/s
ROUNDS = 9
GONE = 1e-3  # of the largest yaw rate: nothing is left
JACKKNIFE_RAD = 0.5  # the trailer has swung out for good


def _growth(problem: Problem, terms: Sequence[Term], shift: Array, speed: float) -> float:
    """Rate at which the trailer's yaw oscillation grows after the kick, 1/s."""
    n = int(LENGTH_S * RATE_HZ)
    time = np.arange(n) / RATE_HZ
    ratio = problem.runs[0].steering_ratio
    steer = np.radians(KICK_DEG) / ratio * np.sin(2.0 * np.pi * KICK_HZ * (time - 0.5))
    steer[(time < 0.5) | (time > 0.5 + 0.5 / KICK_HZ)] = 0.0
    run = Run("kick", time, {}, {}, ratio)
    plant = PlantInput(
        1.0 / RATE_HZ, np.full(n, speed), np.zeros(n), steer, problem.body.copy(), neutral()
    )
    for name, value in problem.given:
        plant.scalar(name, value)
    problem.beliefs.act(plant, shift)
    for term in (*problem.calibration, *terms):
        term.effect.act(plant, run, term.as_dict(), term.windows(0))
    result = simulate(plant)
    rate = result[:, OUTPUT.index("trailer_yaw_rate")]
    fold = float(np.max(np.abs(result[:, OUTPUT.index("articulation")])))
    if not np.all(np.isfinite(rate)) or rate[-1] == 0.0 or fold > JACKKNIFE_RAD:
        return 1.0
    parts = [rate[int(s * RATE_HZ) : int((s + SPAN_S) * RATE_HZ)] for s in (EARLY_S, LATE_S)]
    early, late = (float(np.std(p)) + 1e-15 for p in parts)
    if late < GONE * float(np.max(np.abs(rate))):
        return -1.0
    return float(np.log(late / early) / (LATE_S - EARLY_S))


def critical_speed(problem: Problem, terms: Sequence[Term], shift: Array) -> float | None:
    """Lowest speed at which the kicked plant does not calm down, m/s; None: none up to 80 m/s."""
    low = SLOWEST
    while low < FASTEST and _growth(problem, terms, shift, low + STEP) < CALM:
        low += STEP
    if low >= FASTEST:
        return None
    high = low + STEP
    for _ in range(ROUNDS):
        middle = 0.5 * (low + high)
        if _growth(problem, terms, shift, middle) < CALM:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def lasting(terms: Sequence[Term]) -> list[Term]:
    """Terms as they act for good; one in windows acts with the mean of their values."""
    found = []
    for term in terms:
        if not term.effect.windowed:
            found.append(term)
            continue
        rows = np.array(term.values).reshape(-1, term.stride)
        mean = np.average(rows[:, 2:], axis=0, weights=np.maximum(rows[:, 1] - rows[:, 0], 1e-3))
        found.append(Term(term.effect, (-1.0, LENGTH_S + 1.0, *(float(x) for x in mean)), (0,)))
    return found


def stability(problem: Problem, terms: Sequence[Term], shift: Array) -> dict[str, Any]:
    """`stability` of diagnosis.json: critical speed before, after, and of each effect alone.

    An axle load at twice the frequency and a force from outside have no critical speed of their
    own: the first depends on its phase (section 6.3), the second adds to the motion.
    """
    block: dict[str, Any] = {
        "v_crit_baseline_km_h": _km_h(critical_speed(problem, (), shift)),
        "kick": f"half sine, {KICK_DEG:.0f} deg at the steering wheel, {KICK_HZ} Hz",
        "without": {},
    }
    able = [t for t in terms if t.effect.id not in ("axle_load_harmonic", "crosswind_gust")]
    able = [t for t in able if not t.effect.extra.get("needs_simulation")]
    every = lasting(able)
    block["v_crit_diagnosed_km_h"] = _km_h(critical_speed(problem, every, shift))
    for term, acting in zip(able, every, strict=True):
        rest = [t for t in every if t is not acting]
        block["without"][term.effect.name] = _km_h(critical_speed(problem, rest, shift))
    block["left_out"] = [t.effect.name for t in terms if t not in able]
    return block


def _km_h(speed: float | None) -> float | None:
    return None if speed is None else round(3.6 * speed, 2)
