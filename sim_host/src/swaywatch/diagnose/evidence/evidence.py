"""Evidence for an explanation: how much likelier a recording is with it, its price paid.

Marginal likelihood by Laplace: the misfit, less the volume that the free numbers were drawn from
over the volume that the recording leaves them (Occam's factor), less the price of having chosen
among all explanations of the library. Residuals of a simulation are coloured: the misfit is counted
in independent samples, of the size that the best model leaves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from swaywatch.diagnose.fit.fit import Fit, Fitter, Trial
from swaywatch.effects.active import ActiveEffect
from swaywatch.effects.effect import Parameter

Array = NDArray[np.float64]

#: Logarithm of the Bayes factor from which something is claimed: 150, "very strong" (Kass and
#: Raftery 1995).
CLAIMED = 5.0
#: Logarithm of the Bayes factor below which two explanations cannot be distinguished: 20.
APART = 3.0
#: Reduced chi-square above which a verdict says that something unexplained remains, ...
UNEXPLAINED_ABOVE = 1.3
#: ... unless so little of what was found is left: the form of a right effect is never exact.
LEFT = 0.1
#: Reduced chi-square that the form of a right effect leaves at most. Near the critical speed a
#: wrong vehicle drifts away without limit, and a share of that means nothing.
ROUGH = 7.0
#: What no model of this depth can carry: an effect has to take away this share of the misfit; one
#: in windows, whose edges may follow the noise, so much, and so much more for each of them, ...
DISCREPANCY = 0.005
IN_WINDOWS, WINDOW_DISCREPANCY = 0.02, 0.01
#: ... and so much more on springs, where loads and their phases are described less exactly, of what
#: acts in windows and of what says that it is `imitated_on_springs` (up to 2.5 % on clean vehicles
#: of another simulator; other constant effects up to 0.15 %), ...
ON_SPRINGS = 0.025
#: ... and this share of all that is explained: the form of a right effect leaves as much, that of
#: one in windows more.
FORM, WINDOW_FORM = 0.004, 0.01
#: Beside a user's simulation our plant is only a correction, and its form is less exact: share of
#: the misfit (without noise, which has no form) that a first effect has to take away, and of all
#: that is left a further one.
BESIDE = (0.05, 0.15)
#: Tolerances at which a bound lies ("within 10 %" is one of 10 % / sqrt(3), see `beliefs`).
BOUND = math.sqrt(3.0)
#: Prior spread of a value, in its typical noticeable changes: effects are mostly weak or moderate.
SPREAD = 20.0
#: Prior spread of an edge of a window, s.
EDGE_S = 12.0
#: A value that only shapes its effect is a typical one more often than not: Student's t.
TAILS = 4.0
LAGS = 20  # blocks, two seconds: longer than a period of sway
#: Logarithm of the prior odds against an effect that a combination may as well not have.
RARE = 1.0


def inflation(residuals: Sequence[Array]) -> float:
    """Samples of the residuals for one independent sample, times their variance; at least 1.

    Parameters
    ----------
    residuals
        Normalised, of each run, shape (blocks, channels).
    """
    total, count = 0.0, 0
    for e in residuals:
        total += float(np.sum(np.mean(e * e, axis=0) * _for_one_independent(e))) * e.shape[0]
        count += e.size
    return max(total / max(count, 1), 1.0)


def colour(residuals: Sequence[Array]) -> float:
    """Samples of the residuals for one independent sample, the mean of all channels and runs.

    Whatever their variance, which is known no better than the noise of each sensor is estimated:
    1.03 to 1.08 for white noise of 40 to 15 s, as correlations by chance count where positive.

    Parameters
    ----------
    residuals
        Normalised, of each run, shape (blocks, channels).
    """
    return float(np.mean(np.concatenate([_for_one_independent(e) for e in residuals])))


def _for_one_independent(e: Array) -> Array:
    """Samples for one independent sample, shape (channels,), of residuals (blocks, channels)."""
    power = np.mean(e * e, axis=0)
    acted = np.ones(e.shape[1])
    open_ = np.ones(e.shape[1], dtype=bool)
    for lag in range(1, min(LAGS, e.shape[0] - 1)):
        rho = np.mean(e[lag:] * e[:-lag], axis=0) / np.maximum(power, 1e-12)
        open_ &= rho > 0.05  # the first positive stretch (Geyer 1992)
        acted += np.where(open_, 2.0 * rho, 0.0)
    return acted


def residuals(fitter: Fitter, fit: Fit) -> list[Array]:
    """Normalised residuals of each run, shape (blocks, channels)."""
    runs = range(len(fitter.problem.runs))
    trials = [Trial(r, fit.terms, fit.nuisance[r], fit.shift) for r in runs]
    found = fitter.evaluate_all(trials)
    return [e.reshape(-1, len(fitter.comparison(r).names)) for r, e in enumerate(found)]


def worth(
    base: Fit, before: Fit, after: Fit, *, beside: bool = False, on_springs: bool = False
) -> bool:
    """Whether one more active effect takes away more than what models of this depth leave anyway.

    Parameters
    ----------
    base, before, after
        Nothing missing; without and with the active effect (the last one).
    beside
        Whether the plant is a correction to the user's own simulation.
    on_springs
        Whether the vehicle is on springs.
    """
    gain = before.chi2 - after.chi2
    term = after.terms[-1]
    least = IN_WINDOWS if term.effect.windowed else DISCREPANCY
    imitated = term.effect.windowed or bool(term.effect.extra.get("imitated_on_springs"))
    least += ON_SPRINGS * (on_springs and imitated) + WINDOW_DISCREPANCY * len(term.window_runs)
    form = WINDOW_FORM if any(t.effect.windowed for t in after.terms) else FORM
    needed = least * before.chi2
    if beside:
        further = len(after.terms) > 1
        needed += BESIDE[1] * before.chi2 if further else BESIDE[0] * form_misfit(base, before)
    return gain > max(needed, form * (base.chi2 - after.chi2))


def form_misfit(base: Fit, fit: Fit) -> float:
    """Misfit that a form which is not exact can make or take away, as a drop of chi2.

    It grows with what has to be described, which is what `base` (nothing missing) leaves beyond
    noise, and is no more than all that is left.
    """
    return min(fit.chi2, max(base.chi2 - base.count, 0.0))


def least_gain(base: Fit, before: Fit, *, windowed: bool, on_springs: bool) -> float:
    """Drop of chi2 without which one more effect cannot be `worth` it, in one window or without.

    Parameters
    ----------
    base, before
        Nothing missing; without the effect.
    windowed
        Whether it acts in windows.
    on_springs
        Whether the vehicle is on springs.
    """
    least = IN_WINDOWS + WINDOW_DISCREPANCY + ON_SPRINGS * on_springs if windowed else DISCREPANCY
    form = WINDOW_FORM if windowed or any(t.effect.windowed for t in before.terms) else FORM
    return max(least * before.chi2, form * (base.chi2 - before.chi2))


def price_of_form(base: Fit, fit: Fit, noise: float) -> float:
    """Logarithm of the evidence beside a user's simulation that form alone may give an explanation.

    The plant is only a correction there. Each further effect and each window can take away misfit
    that the first one's form leaves, so much as `worth` asks of it.
    """
    further = BESIDE[1] * max(len(fit.terms) - 1, 0) * fit.chi2
    windows = WINDOW_DISCREPANCY * sum(len(t.window_runs) for t in fit.terms)
    windows += BESIDE[0] * any(t.effect.windowed for t in fit.terms)
    return (further + windows * form_misfit(base, fit)) * 0.5 / noise


def explained(base: Fit, fit: Fit) -> bool:
    """Whether what a fit leaves is noise, or what the form of a right effect leaves."""
    before, after = (f.chi2 / max(f.count, 1) for f in (base, fit))
    return after <= max(UNEXPLAINED_ABOVE, min(1.0 + LEFT * (before - 1.0), ROUGH))


def prior_spread(parameter: Parameter) -> float:
    """Prior standard deviation of a value of an effect."""
    if parameter.name in ("start", "stop"):
        return EDGE_S
    usual = SPREAD * parameter.scale
    if abs(parameter.neutral) < 100.0:
        usual = max(usual, *(abs(s - parameter.neutral) for s in parameter.starts))
    return usual


def _unusual(parameter: Parameter, value: float) -> float:
    """Price of a shape that is far from the typical one."""
    off = (value - parameter.neutral) / prior_spread(parameter)
    return 0.5 * (TAILS + 1.0) * math.log1p(off * off / TAILS)


def log_evidence(fitter: Fitter, fit: Fit, noise: float, choices: int) -> float:
    """Logarithm of the marginal likelihood of a fit, up to what all fits of a problem share.

    Parameters
    ----------
    noise
        As `inflation` has it.
    choices
        Explanations that each active effect was chosen from.
    """
    beliefs = fitter.problem.beliefs
    values = [t.parameter(j) for t in fit.terms for j in range(len(t.values))]
    volume = fit.volume - beliefs.volume
    volume += 2.0 * sum(math.log(prior_spread(p)) for p in values)
    volume -= len(values) * math.log(noise)
    prior = sum(RARE + math.log(choices) - plausible(t) for t in fit.terms)
    shapes = [(t.parameter(j), v) for t in fit.terms for j, v in enumerate(t.values)]
    prior += sum(_unusual(p, v) for p, v in shapes if p.shapes)
    return -0.5 * fit.chi2 / noise - 0.5 * max(volume, 0.0) - prior


def plausible(term: ActiveEffect) -> float:
    """Logarithm of the prior weight of an explanation among all."""
    return 2.0 * term.effect.plausibility
