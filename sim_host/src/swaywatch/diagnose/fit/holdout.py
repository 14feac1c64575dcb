"""Judging a model on what it was not fitted to: a run left out, windows valued by other windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.fit.agreement import errors, iso18571, nrmse
from swaywatch.diagnose.fit.fit import Fit, Fitter, Problem, predict_run, residual
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Effect
from swaywatch.effects.runs import BLOCK, RATE_HZ, Run

Array = NDArray[np.float64]

#: The part of a run that its start values and its steering offset are taken from.
START_S = 5.0


def first_seconds(run: Run, seconds: float) -> Run:
    """The run with only its first seconds."""
    return run.part(0, min(int(seconds * RATE_HZ) // BLOCK * BLOCK, run.time.size))


def start_values(
    problem: Problem, index: int, terms: Sequence[ActiveEffect], shift: Array
) -> Array:
    """Steering offset and start values of a run, from its first seconds only.

    Against a user's simulation these are the simulation's own: nothing is taken from the recording.
    """
    if not problem.free_start and problem.start_nuisance is not None:
        return np.asarray(problem.start_nuisance[index])
    start = first_seconds(problem.runs[index], START_S)
    one = replace(problem, runs=(start,), start_nuisance=None, start_shift=None)
    constant = tuple(t for t in terms if not t.effect.windowed)
    fit = Fitter(one).run(Fit(constant, np.zeros((1, 5)), shift), 6, free=0)
    return np.asarray(fit.nuisance[0])


def valued(
    problem: Problem,
    index: int,
    terms: Sequence[ActiveEffect],
    effect: Effect,
    spans: Sequence[tuple[float, float]],
    candidates: Sequence[tuple[float, ...]],
    nuisance: Array,
    shift: Array,
) -> ActiveEffect:
    """Windows at given times, each with the one of the given values that fits the run best.

    Nothing is fitted: the choice among the candidates is all that the run decides.
    """
    chosen: list[float] = []
    for start, stop in spans:
        best = (np.inf, candidates[0])
        for values in candidates:
            count = len(chosen) // (2 + len(values)) + 1
            term = ActiveEffect(effect, (*chosen, start, stop, *values), (index,) * count)
            outputs = predict_run(problem, index, (*terms, term), nuisance, shift)
            e = residual(problem, index, outputs)
            chi2 = float(np.sum(e * e))
            if chi2 < best[0]:
                best = (chi2, values)
        chosen += [start, stop, *best[1]]
    return ActiveEffect(effect, tuple(chosen), (index,) * len(spans))


def values_of(term: ActiveEffect, runs: Sequence[int]) -> list[tuple[float, ...]]:
    """Values of an active effect's windows in some runs."""
    k = term.stride
    return [
        term.values[w * k + 2 : (w + 1) * k] for w, r in enumerate(term.window_runs) if r in runs
    ]


def carried(
    problem: Problem, index: int, taught: Fit, nuisance: Array, notes: set[str]
) -> list[ActiveEffect]:
    """Active effects for a run that was left out: windows keep their times, never their values."""
    others = [r for r in range(len(problem.runs)) if r != index]
    terms = [t for t in taught.terms if not t.effect.windowed]
    for term in (t for t in taught.terms if t.effect.windowed):
        spans = [(w.start, w.stop) for w in term.windows(index)]
        candidates = values_of(term, others)
        if spans and candidates:
            notes.add(
                f"windows of {term.effect.name}: times from the left-out run itself, values from "
                "the windows of the other runs (the best fitting of them)"
            )
            terms.append(
                valued(
                    problem, index, terms, term.effect, spans, candidates, nuisance, taught.shift
                )
            )
        elif spans:
            notes.add(
                f"{term.effect.name} acts in windows of {problem.runs[index].name} only: no other "
                "window gives their values, left out when that run is predicted"
            )
    return terms


def by_the_others(
    problem: Problem, index: int, fit: Fit, notes: set[str]
) -> tuple[dict[str, Array], int]:
    """A run as the model fitted to the other runs predicts it, and how many effects took part."""
    others = [r for r in range(len(problem.runs)) if r != index]
    taught = Fitter(problem).run(Fit(fit.terms, fit.nuisance, fit.shift), 5, runs=others)
    constant = tuple(t for t in taught.terms if not t.effect.windowed)
    nuisance = start_values(problem, index, constant, taught.shift)
    terms = carried(problem, index, taught, nuisance, notes)
    return predict_run(problem, index, terms, nuisance, taught.shift), len(terms)


def left_out(problem: Problem, fit: Fit) -> list[float]:
    """Error (NRMSE) of each run predicted by what the others taught; empty with a single run."""
    count = len(problem.runs)
    return [
        nrmse(errors(problem, index, by_the_others(problem, index, fit, set())[0]))
        for index in range(count if count > 1 else 0)
    ]


def typical(rows: Sequence[Sequence[float]]) -> list[float]:
    """Geometric means over the left-out runs of the errors, one for each column.

    Near the critical speed a run drifts away with any value that is a little off, and its errors
    are tens of times those of the others; so each run counts by how many times better it is.
    """
    return [float(x) for x in np.exp(np.mean(np.log(np.array(rows) + 1e-12), axis=0))]


def held_out(problem: Problem, fit: Fit, before: Fit, *, calibrated: bool = True) -> dict[str, Any]:
    """Each run predicted by what the other runs taught, with the findings and without any.

    Parameters
    ----------
    fit
        The model with the findings.
    before
        The model without: the calibrated vehicle alone.
    calibrated
        ``before`` is calibrated to the other runs as well; False: it is the vehicle as written.

    Returns
    -------
    dict
        ``held_out_baseline_nrmse``, ``held_out_diagnosed_nrmse`` (means over the runs, or null),
        the same of ISO/TS 18571, ``held_out_runs`` (pairs), ``held_out_how`` (sentences).
    """
    empty: dict[str, Any] = {
        "held_out_baseline_nrmse": None, "held_out_diagnosed_nrmse": None,
        "held_out_iso18571_before": None, "held_out_iso18571_after": None, "held_out_runs": [],
    }  # fmt: skip
    if not fit.terms:
        return empty | {"held_out_how": ["no effect is claimed"]}
    if len(problem.runs) < 2:
        return empty | {"held_out_how": ["one run only: nothing can be left out"]}
    notes = {
        "each run is predicted by the models fitted to the others, with and without the findings"
        if calibrated
        else "each run is predicted by the model fitted to the others; without the findings it is "
        "the vehicle as written"
    }
    scores = []
    used = 0
    for index, run in enumerate(problem.runs):
        with_findings, count = by_the_others(problem, index, fit, notes)
        used += count
        if calibrated:
            without, _ = by_the_others(
                problem, index, Fit((), before.nuisance, before.shift), set()
            )
        else:
            start = start_values(problem, index, (), before.shift)
            without = predict_run(problem, index, (), start, before.shift)
        scores.append(
            [
                nrmse(errors(problem, index, without)),
                nrmse(errors(problem, index, with_findings)),
                iso18571(run, without), iso18571(run, with_findings),
            ]
        )  # fmt: skip
    if not used:
        return empty | {"held_out_how": sorted(notes)}
    mean = np.mean(scores, axis=0)
    return {
        "held_out_baseline_nrmse": float(mean[0]), "held_out_diagnosed_nrmse": float(mean[1]),
        "held_out_iso18571_before": float(mean[2]), "held_out_iso18571_after": float(mean[3]),
        "held_out_runs": [row[:2] for row in scores], "held_out_how": sorted(notes),
    }  # fmt: skip
