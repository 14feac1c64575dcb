"""What each finding costs: critical speed and damping with and without it, at three swings.

The vehicle is the calibrated one, each claimed term a cause (`models/costs.py`); the errors are
those of the fit, values of the vehicle and of the effects together. An effect in windows acts as if
its window lasted: each of its windows is weighed, and the one that costs most counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.calibration import BESIDE, NINETY, form_share, noise
from swaywatch.diagnose.fit.fit import Fit, Problem
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Act, Window
from swaywatch.effects.runs import Run
from swaywatch.models.costs import KMH, Base, Cause, Cost, CostValue, weigh
from swaywatch.plant.lanes import PlantInput, neutral

Array = NDArray[np.float64]

#: Beliefs about what moves; the others are about sensors.
MOVING = ("vehicle", "typical")

#: What a single window gives back errs by this share of the finding's largest, 90 %: a load at
#: twice the yaw frequency is another one in every window, and its phase in two or three
#: oscillations, of which those off the sway's frequency say least, hangs on the form of the model.
#: 1.645 times the robust deviation (median over 0.6745) of 14 windows in four sealed recordings
#: (s05, s12, s13, s19; 11 lie inside); `make bench-costs` tests it on practice and road.
ONE_WINDOW = 0.43

LASTING = Window(-1e6, 1e6, {})
OUTSIDE = "acts from outside: it adds to the motion and does not change how it dies out"
SENSOR = "a sensor moves no critical speed"
_FROM_OUTSIDE = ("crosswind_gust", "road_bank")


def stability(problem: Problem, fit: Fit, reached: float) -> dict[str, Any]:
    """`stability` of diagnosis.json.

    Parameters
    ----------
    problem, fit
        What was found, with its errors.
    reached
        Size of an independent sample of the residuals (`evidence.inflation`).
    """
    at = [k for k, b in enumerate(problem.beliefs.items) if b.kind in MOVING]
    base = base_of(problem, at, fit.shift)
    terms = [t for t in fit.terms if not _left_out(t)]
    joint = _covariance(problem, fit, max(reached, 1.0) * noise() ** 2)
    places = [len(joint) - fit.shift.size + k for k in at]
    causes: list[Cause] = []
    for term in terms:
        found, own = causes_of(term, _first(fit.terms, term))
        causes += found
        places += own
    speed = max(float(np.mean(run.speed)) for run in problem.runs)
    costs = weigh(base, causes, speed, joint[np.ix_(places, places)])
    believed = weigh(
        replace(base, values=np.zeros(len(at))), (), speed,
        np.asarray(np.linalg.inv(problem.beliefs.weight)[np.ix_(at, at)], dtype=np.float64),
        costs.swings_rad_s[1:2],
    )  # fmt: skip
    by_name = {term.effect.name: term for term in terms}
    return {
        "swings_deg_s": np.degrees(costs.swings_rad_s).round(3).tolist(),
        "speed_km_h": KMH * speed,
        "beside_simulation": not problem.free_start,
        "believed_v_crit_km_h": _speeds(believed.healthy)[0],
        "calibrated": {
            "v_crit_km_h": _speeds(costs.healthy), "damping_ratio": costs.damping_healthy,
        },
        "diagnosed": {
            "v_crit_km_h": _speeds(costs.found), "damping_ratio": costs.damping_found,
        },
        "causes": [_entry(c, by_name[c.name], problem) for c in costs.causes],
        "left_out": [
            {"name": t.effect.name, "reason": _left_out(t)} for t in fit.terms if _left_out(t)
        ],
    }  # fmt: skip


def _left_out(term: ActiveEffect) -> str:
    """Why an active effect has no cost; empty where it has one."""
    if term.effect.kind == "measurement":
        return SENSOR
    outside = term.effect.id in _FROM_OUTSIDE or term.effect.extra.get("from_outside")
    return OUTSIDE if outside else str(term.effect.extra.get("no_cost", ""))


def base_of(problem: Problem, at: Sequence[int], shift: Array) -> Base:
    """The calibrated vehicle; its values are the shifts of the beliefs about what moves."""
    scalars = neutral()
    plant = PlantInput(0.01, np.zeros(1), np.zeros(1), np.zeros(1), problem.body, scalars)
    for name, value in problem.given:
        plant.scalar(name, value)
    still = Run("still", np.zeros(2), {}, {}, problem.runs[0].steering_ratio)

    def act(moved: PlantInput, values: Array) -> None:
        z = np.zeros(len(problem.beliefs))
        z[list(at)] = values
        problem.beliefs.act(moved, z)
        for term in problem.calibration:
            term.effect.act(moved, still, term.as_dict(), ())

    return Base(problem.body, scalars, shift[list(at)], act, problem.runs[0].steering_ratio)


def _first(terms: Sequence[ActiveEffect], term: ActiveEffect) -> int:
    """Place of an active effect's first value among those of all active effects."""
    found = next(k for k, t in enumerate(terms) if t is term)
    return sum(len(t.values) for t in terms[:found])


def causes_of(term: ActiveEffect, first: int) -> tuple[list[Cause], list[int]]:
    """A cause of each window of an active effect, or one; and the places of their values."""
    effect = term.effect
    names = [p.name for p in effect.parameters]
    follows = bool(effect.extra.get("follows_motion"))
    # what comes or fades over a way costs what it does where it is largest
    act: Act = cast("Act", effect.extra.get("at_its_largest", effect.act))

    def lasting(plant: PlantInput, values: Array, swing: Run) -> None:
        given = dict(zip(names, values.tolist(), strict=True))
        windows = [replace(LASTING, values=given)] if effect.windowed else []
        act(plant, swing, {} if effect.windowed else given, windows)

    rows: list[list[int]] = [list(range(len(names)))]
    if effect.windowed:
        rows = [
            list(range(w * term.stride + 2, (w + 1) * term.stride))
            for w in range(len(term.window_runs))
        ]
    causes = [
        Cause(effect.name, np.array([term.values[k] for k in row]), lasting, follows)
        for row in rows
    ]
    return causes, [first + k for row in rows for k in row]


def _covariance(problem: Problem, fit: Fit, fewer: float) -> Array:
    """Of all values of effects and all shifts, shape (values + shifts,) twice.

    Independent samples are fewer than samples: what the recording says counts `fewer` times less,
    what was believed before it counts as it is.
    """
    values, shifts = sum(len(t.values) for t in fit.terms), fit.shift.size
    joint = np.zeros((values + shifts, values + shifts))
    own = np.arange(values + shifts)
    joint[values:, values:] = np.linalg.inv(problem.beliefs.weight)
    for block, rows, columns in (
        (fit.covariance, own[:values], own[:values]),
        (fit.cross, own[:values], own[values:]),
        (fit.cross.T, own[values:], own[:values]),
        (fit.shift_covariance, own[values:], own[values:]),
    ):
        if block.shape == (rows.size, columns.size):
            joint[np.ix_(rows, columns)] = block
    prior = np.zeros_like(joint)
    prior[values:, values:] = problem.beliefs.weight
    scale = np.sqrt(np.maximum(np.diag(joint), 1e-300))
    prior *= np.outer(scale, scale)
    said = np.linalg.pinv(joint / np.outer(scale, scale), hermitian=True) - prior
    # what is known exactly leaves rounding errors elsewhere; no recording takes knowledge away
    value, vector = np.linalg.eigh(0.5 * (said + said.T))
    said = (vector * np.maximum(value, 0.0)) @ vector.T / fewer + prior
    value, vector = np.linalg.eigh(0.5 * (said + said.T))
    kept = np.maximum(value, 1e-9)
    return np.asarray((vector / kept) @ vector.T * np.outer(scale, scale))


def _speeds(figures: Sequence[CostValue]) -> list[dict[str, float] | None]:
    return [_stated(figure) for figure in figures]


def _stated(figure: CostValue, form: float = 0.0) -> dict[str, float] | None:
    """A number with its 90 % interval, `form` of it from the model's; None: there is none."""
    if figure.value is None:
        return None
    value, error = figure.value, figure.error
    half = math.hypot(NINETY * error, form)
    found = {"value": value, "standard_error": error, "low": value - half, "high": value + half}
    return {key: round(number, 3) for key, number in found.items()}


def _entry(cost: Cost, term: ActiveEffect, problem: Problem) -> dict[str, Any]:
    share = form_share(term.effect.id + ("" if problem.free_start else BESIDE))
    if term.effect.windowed and term.effect.extra.get("follows_motion"):
        share = max(share, ONE_WINDOW)
    # what costs by its phase errs with its size, not with what it happens to cost
    largest = max((abs(figure.value or 0.0) for figure in cost.each), default=0.0)

    def back(figures: Sequence[CostValue]) -> list[dict[str, float] | None]:
        return [_stated(f, share * max(abs(f.value or 0.0), largest)) for f in figures]

    entry: dict[str, Any] = {
        "name": cost.name, "id": term.effect.id, "component": term.effect.component,
        "v_crit_without_km_h": _speeds(cost.without),
        "gives_back_km_h": back(cost.back),
        "damping_ratio_without": cost.damping_without,
        "windows": [],
    }  # fmt: skip
    if term.effect.windowed:
        entry["windows"] = [
            {
                "run": problem.runs[run].name,
                "start": term.values[w * term.stride],
                "stop": term.values[w * term.stride + 1],
                "gives_back_km_h": figure,
                "counts": w == cost.worst,
            }
            for w, (run, figure) in enumerate(zip(term.window_runs, back(cost.each), strict=True))
        ]
    return entry
