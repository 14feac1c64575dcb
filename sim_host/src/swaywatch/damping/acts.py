"""What the driver or pilot does: pulses of an input that stand out of its own quiet level.

A hand on a wheel is never still, but it is still most of the time beside what begins a swing. What
goes on all the time (a slalom, a controller) has no quiet level to stand out of and is no act.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from swaywatch.damping.data import DampingRun

STANDS_OUT = 5.0
"""Change of an input within half a cycle over its usual one (standard deviations)."""

OF_THE_LARGEST = 0.1
"""Part of the largest change in the recording below which it begins nothing."""

_QUARTILE = 0.3186
"""25th percentile of |x| of a normal distribution, in standard deviations."""


@dataclass(frozen=True)
class Act:
    """One act; `which`: the input that stands out most in it."""

    start_s: float
    end_s: float
    which: int


def acts_of(run: DampingRun, frequency_hz: float) -> list[Act]:
    """Acts of all inputs in order; those less than half a cycle apart are one.

    Parameters
    ----------
    run
        A recording; `inputs` may have no column.
    frequency_hz
        Of the swing: what is slow beside it is no act.
    """
    half = max(2, round(0.5 / (frequency_hz * run.step_s)))
    if not run.inputs.shape[1] or len(run.inputs) < 8 * half:
        return []
    change = np.abs(run.inputs[half:] - run.inputs[:-half])
    usual = np.percentile(change, 25.0, axis=0) / _QUARTILE
    least = np.maximum(STANDS_OUT * usual, OF_THE_LARGEST * change.max(axis=0))
    stands = np.where(change > 0.0, change / np.maximum(least, 1e-300), 0.0)
    acts = []
    for first, last in _groups(np.max(stands, axis=1) >= 1.0, half):
        which = int(np.argmax(stands[max(0, first - half) : last].max(axis=0)))
        end = min(last, len(run.time_s) - 1)
        acts.append(Act(float(run.time_s[first]), float(run.time_s[end]), which))
    return acts


def _groups(loud: npt.NDArray[np.bool_], half: int) -> list[tuple[int, int]]:
    """First and last rows of what moved the differences; nearer than `half` is one."""
    closed = ndimage.binary_closing(np.pad(loud, half), np.ones(half, dtype=np.bool_))[half:-half]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], closed.astype(np.int8), [0]])))
    # difference k reaches from row k to row k + half: a step at row r is loud from r - half to r
    return [
        (int(first) + half, int(max(last, first + half)))
        for first, last in zip(edges[::2], edges[1::2], strict=True)
    ]
