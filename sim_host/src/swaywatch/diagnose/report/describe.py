"""From a verdict to the `effects` of diagnosis.json: parameters with intervals, windows, scores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.evidence.calibration import BESIDE, interval
from swaywatch.diagnose.evidence.verdict import Verdict
from swaywatch.diagnose.fit.agreement import errors, iso18571, nrmse
from swaywatch.diagnose.fit.fit import Fit, Problem, predict_run
from swaywatch.diagnose.fit.holdout import held_out
from swaywatch.diagnose.report import labels
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Window

Array = NDArray[np.float64]


def describe(verdict: Verdict, problem: Problem, signals: dict[str, str]) -> list[dict[str, Any]]:
    """`effects` of diagnosis.json."""
    if not verdict.fit.terms:
        return []
    fit_block = _fit_block(verdict, problem)
    effects = []
    reached = verdict.noise
    sizes = [len(t.values) for t in verdict.fit.terms]
    covariance = verdict.fit.covariance
    if covariance.shape[0] != sum(sizes):
        covariance = np.zeros((sum(sizes), sum(sizes)))
    for index, term in enumerate(verdict.fit.terms):
        effect = term.effect
        at = sum(sizes[:index])
        own = covariance[at : at + sizes[index], at : at + sizes[index]]
        name = effect.id + ("" if problem.free_start else BESIDE)
        windows: list[dict[str, Any]] = []
        if effect.windowed:
            windows = _windows(term, problem)
            parameters = _over_windows(term, problem, name, windows, own, reached)
            windows.sort(key=lambda w: (w["run"], w["start"]))
        else:
            parameters = _reported(term, name, own, reached)
        entry: dict[str, Any] = {
            "id": effect.id,
            "parameters": parameters,
            "component": signals.get(effect.component, effect.component),
            "role": effect.component,
            "windows": [[round(w["start"], 2), round(w["stop"], 2)] for w in windows],
            "window_details": windows,
            "lines": list(effect.lines),
            "confidence": verdict.confidence[index],
            "equivalent": sorted({name.split(":")[0] for name in verdict.equivalents[index]}),
            "equivalent_details": verdict.equivalents[index],
            "distinguished_by": effect.decided_by if verdict.equivalents[index] else "",
            "equation": effect.equation,
            "source": effect.source,
            "kind": effect.kind,
            "fit": fit_block,
        }
        if effect.id in ("sensor_delay", "sensor_gain", "sensor_roll_gravity"):
            entry["channel"] = entry["component"]
        elif effect.extra.get("side"):
            entry["side"] = effect.extra["side"]
            entry["axle"] = effect.component
        elif effect.id == "parameter_error":
            entry["parameter"] = effect.component
        elif effect.id == "crosswind_gust":
            entry["body"] = effect.component
        elif effect.component in (
            "car_front", "car_rear", "trailer", "trailer_front", "trailer_rear",
        ):  # fmt: skip
            entry["axle"] = effect.component
        effects.append(entry)
    return effects


def _reported(term: ActiveEffect, name: str, covariance: Array, reached: float) -> dict[str, Any]:
    """Reported values of an effect without windows, their errors carried through `report`."""
    effect = term.effect
    names = [p.name for p in effect.parameters]

    def report(values: Any) -> dict[str, float]:
        return effect.report(dict(zip(names, values, strict=True)))

    raw = np.array(term.values)
    found = report(raw)
    neutral = report([p.neutral for p in effect.parameters])
    assumed = float(str(effect.extra.get("assumed_share", 0.0)))
    highs = [p.high for p in effect.parameters]
    errors_ = _carried(report, raw, covariance, highs)
    # of a moment or a place nothing is a share of its size
    located = cast("tuple[str, ...]", effect.extra.get("located", ()))
    sizes = {k: 0.0 if k in located else _size(v, neutral[k]) for k, v in found.items()}
    rows = {
        key: interval(name, value, sizes[key], error, reached, assumed=assumed)
        for (key, value), error in zip(found.items(), errors_, strict=True)
    }
    for key, row in rows.items():
        if abs(neutral[key]) > 100.0 * abs(row["value"]):  # vanishes towards infinity: a factor
            factor = 1.0 + abs(row["high"] - row["value"]) / max(abs(row["value"]), 1e-12)
            row["low"], row["high"] = row["value"] / factor, row["value"] * factor
    return rows


def _size(value: float, neutral: float) -> float:
    """Distance from where the effect vanishes; of what vanishes towards infinity, the value."""
    return value if abs(neutral) > 100.0 * abs(value) else value - neutral


def _windows(term: ActiveEffect, problem: Problem) -> list[dict[str, Any]]:
    """Windows of an active effect in the order of its values."""
    return [
        {
            "run": problem.runs[r].name,
            "start": float(term.values[w * term.stride]),
            "stop": float(term.values[w * term.stride + 1]),
            **_details(term, problem, w, np.array(term.values)),
        }
        for w, r in enumerate(term.window_runs)
    ]


def _details(term: ActiveEffect, problem: Problem, index: int, values: Array) -> dict[str, float]:
    """What is reported of one window, by name, with these values of the effect."""
    own = values[index * term.stride : (index + 1) * term.stride]
    names = [p.name for p in term.effect.parameters]
    details = dict(zip(names, own[2:], strict=True))
    describe_window = term.effect.extra.get("describe")
    if callable(describe_window):
        window = Window(float(own[0]), float(own[1]), details)
        details = describe_window(problem.runs[term.window_runs[index]], window)
    return {k: float(v) for k, v in details.items()}


def _errors_of_windows(
    term: ActiveEffect, problem: Problem, covariance: Array
) -> list[dict[str, float]]:
    """Standard error of what is reported of each window, as if noise were white."""
    found = []
    for index in range(len(term.window_runs)):
        at = slice(index * term.stride, (index + 1) * term.stride)

        def report(own: Array, at: slice = at, index: int = index) -> dict[str, float]:
            values = np.array(term.values)
            values[at] = own
            return _details(term, problem, index, values)

        own = np.array(term.values[at])
        errors_ = _carried(report, own, covariance[at, at], [np.inf] * own.size)
        found.append(dict(zip(report(own), errors_, strict=True)))
    return found


def _carried(
    report: Callable[[Array], dict[str, float]],
    values: Array,
    covariance: Array,
    highs: Sequence[float],
) -> list[float]:
    """Errors of fitted values, carried through what is reported of them; in its order."""
    base = report(values)
    columns = []
    for index, variance in enumerate(np.diag(covariance)):
        step = 0.1 * float(np.sqrt(max(variance, 1e-300)))
        moved = values.copy()
        moved[index] += step if values[index] + step <= highs[index] else -step
        changed = report(moved)
        by = float(moved[index] - values[index])  # none where the fit says that the error is none
        columns.append([_apart(k, changed[k], base[k]) / by if by else 0.0 for k in base])
    slopes = np.array(columns)
    return [float(e) for e in np.sqrt(np.abs(np.diag(slopes.T @ covariance @ slopes)))]


def _over_windows(
    term: ActiveEffect,
    problem: Problem,
    name: str,
    windows: list[dict[str, Any]],
    covariance: Array,
    reached: float,
) -> dict[str, Any]:
    """What is typical of the windows, and the interval of each.

    The interval of the typical value is that of a window: it comes from the fit's errors, and from
    how the windows differ.
    """
    neutral = {p.name: p.neutral for p in term.effect.parameters}
    errors_ = _errors_of_windows(term, problem, covariance)
    parameters: dict[str, Any] = {}
    for key in [k for k in windows[0] if k not in ("run", "start", "stop")]:
        values = np.array([w[key] for w in windows])
        zero = neutral.get(key, 0.0)
        centre = zero + _typical(key, values - zero)
        scatter = float(np.sqrt(np.mean([_apart(key, v, centre) ** 2 for v in values])))
        error = float(np.median([row[key] for row in errors_]))
        parameters[key] = interval(name, centre, centre - zero, error, reached, scatter=scatter)
        parameters[key]["per_window"] = [float(x) for x in values]
        for window, row in zip(windows, errors_, strict=True):
            own = interval(name, window[key], window[key] - zero, row[key], reached)
            window.setdefault("intervals", {})[key] = [own["low"], own["high"]]
    return parameters


def _typical(key: str, sizes: Array) -> float:
    """Median over windows; of windows to both sides, the median size towards the larger side."""
    if _is_phase(key):
        return float(np.degrees(np.angle(np.sum(np.exp(1j * np.radians(sizes))))))
    if np.all(sizes >= 0.0) or np.all(sizes <= 0.0):
        return float(np.median(sizes))
    return float(np.copysign(np.median(np.abs(sizes)), np.sum(sizes)))


def _is_phase(key: str) -> bool:
    return key == "phase_deg"


def _apart(key: str, one: float, other: float) -> float:
    """Difference of two values, of phases the shorter way round."""
    difference = one - other
    return (difference + 180.0) % 360.0 - 180.0 if _is_phase(key) else difference


def _reproduced(problem: Problem, fit: Fit | None) -> tuple[float | None, float | None]:
    """How well a model reproduces the runs: means of NRMSE and ISO/TS 18571."""
    if fit is None:
        return None, None
    scores = []
    for r, run in enumerate(problem.runs):
        outputs = predict_run(problem, r, fit.terms, fit.nuisance[r], fit.shift)
        scores.append((nrmse(errors(problem, r, outputs)), iso18571(run, outputs)))
    mean = np.mean(scores, axis=0)
    return float(mean[0]), float(mean[1])


def _fit_block(verdict: Verdict, problem: Problem) -> dict[str, Any]:
    written, before, after = (
        _reproduced(problem, fit) for fit in (verdict.written, verdict.before, verdict.fit)
    )
    as_written = verdict.before is verdict.written
    block: dict[str, Any] = {
        "baseline": "as_written" if as_written else "calibrated",
        "as_written_nrmse": written[0],
        "baseline_nrmse": before[0],
        "diagnosed_nrmse": after[0],
        "iso18571_as_written": written[1],
        "iso18571_before": before[1],
        "iso18571_after": after[1],
    }
    return block | held_out(problem, verdict.fit, verdict.before, calibrated=not as_written)


def too_small(verdict: Verdict) -> list[str]:
    """A sentence on what explains more than nothing does but is below what is worth a report."""
    if verdict.slight is None:
        return []
    parts = [f"{labels.named(t.effect.name)}, {_largest(t)}" for t in verdict.slight.fit.terms]
    but = ", but is too small to report"
    if len(parts) > 1:
        but = ", together, but not all of it is large enough to report"
    return [f"would explain part of what is left{but}: {'; '.join(parts)}"]


def _largest(term: ActiveEffect) -> str:
    """The largest sizes of an active effect, and from what change on they would be reported."""
    sizes: dict[str, float] = {}
    claims = [p for p in term.effect.parameters if p.minimum > 0.0 and not p.shapes]
    for p in claims:
        found = [v for i, v in enumerate(term.values) if term.parameter(i) is p]
        sizes[p.name] = max(found, key=lambda v: abs(v - p.neutral))
    return ", ".join(
        f"{labels.value(p.name, sizes[p.name])} "
        f"(reported from a change of {labels.rounded(p.minimum)} on)"
        for p in claims
    )


def calibrated(verdict: Verdict, problem: Problem) -> list[dict[str, Any]]:
    """`calibrated` of diagnosis.json: each value of vehicle.toml before and after, SI."""
    fit, beliefs = verdict.fit, problem.beliefs
    errors_ = (
        np.sqrt(np.abs(np.diag(fit.shift_covariance)) * verdict.noise)
        if fit.shift_covariance.size
        else fit.shift
    )
    rows = []
    for index, belief in enumerate(beliefs.items):
        if belief.kind != "vehicle":
            continue
        ratio = problem.runs[0].steering_ratio
        value, believed = (
            beliefs.value(index, problem.body, ratio, z) for z in (float(fit.shift[index]), 0.0)
        )
        above = beliefs.value(index, problem.body, ratio, float(fit.shift[index]) + 1.0)
        rows.append(
            {
                "name": belief.name, "believed": believed, "calibrated": value,
                "standard_error": abs(above - value) * min(float(errors_[index]), 1.0),
                "tolerances": float(fit.shift[index]), "tolerance": belief.tolerance,
                "source": belief.source,
            }
        )  # fmt: skip
    return rows
