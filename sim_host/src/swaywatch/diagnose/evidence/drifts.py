"""Drifts that were found before the fit, checked against the model that the fit found.

Before a fit a drift is seen in balances of the recorded signals, which hold for the vehicle as
believed. What the vehicle does beyond that, a steering that follows the heading for instance, can
look like one. Nothing in a model makes a ramp in one channel alone: where the fit leaves just the
ramp that was taken off, the channel was right.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swaywatch.checks.samples import Finding
from swaywatch.diagnose.evidence.evidence import residuals
from swaywatch.diagnose.fit.fit import Fit, Fitter
from swaywatch.effects.runs import BLOCK, RATE_HZ

#: Share of the drift, taken off, that the fit has to leave for the channel to have been right.
LEAVES = (0.6, 1.4)


def contradicted(
    fitter: Fitter, fit: Fit, found: Sequence[tuple[str, Finding]]
) -> frozenset[tuple[str, str]]:
    """Channels that were right as recorded: name of the run and of the channel.

    Parameters
    ----------
    fitter, fit
        The model that was found, where it is judged.
    found
        Findings before the fit with the names of their runs; the first channel of each was put
        right, the others could have been.
    """
    drifts = [(run, finding) for run, finding in found if finding.kind == "drift"]
    if not drifts:
        return frozenset()
    right: set[tuple[str, str]] = set()
    for index, rows in enumerate(residuals(fitter, fit)):
        comparison = fitter.comparison(index)
        time_s = np.arange(len(rows)) * BLOCK / RATE_HZ
        slope = np.polyfit(time_s, rows * comparison.scales, 1)[0]
        left = dict(zip(comparison.names, slope.tolist(), strict=True))
        for run, finding in drifts:
            name = fitter.problem.runs[index].name
            first, *others = finding.channels
            if first not in left or not (name == run or name.startswith(f"{run} from ")):
                continue
            if LEAVES[0] < -left[first] / finding.amount < LEAVES[1]:
                least = LEAVES[0] * abs(finding.amount)
                agree = [channel for channel in others if abs(left.get(channel, 0.0)) < least]
                right |= {(run, channel) for channel in (first, *agree)}
    return frozenset(right)
