"""Other people's estimators of frequency and damping of one swing, as they are commonly used.

Every function takes one window of one channel, from which the median of the whole recording has
been taken, and the time between two samples, and gives a :class:`Swing`; its `error` is the
standard error of the damping ratio that the method states, NaN where it states none. Orders: 2 is
the swing alone, 3 leaves a pole for what is left of the mean; both are shown, for neither is better
everywhere (orders 4 and 6 were tried and are worse).
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import control
import numpy as np
from numpy.typing import NDArray

os.environ.setdefault("TQDM_DISABLE", "1")  # pyOMA2 draws a bar for every window
try:
    import logging

    from pyoma2.functions import ssi

    logging.getLogger("pyoma2").setLevel(logging.ERROR)
except ImportError:  # `make bench-damping` fetches it
    ssi = None

Array = NDArray[np.float64]

BAND_HZ = (0.2, 10.0)


class Swing(NamedTuple):
    """What a method says of a window."""

    frequency_hz: float
    damping_ratio: float
    error: float = math.nan


NOTHING = Swing(math.nan, math.nan)


def _of(s: complex, error: float = math.nan) -> Swing:
    return Swing(s.imag / (2 * math.pi), -s.real / abs(s), error)


def _strongest(x: Array, poles: NDArray[np.complex128], step_s: float) -> Swing:
    """The pole in the band that leaves least of the window, with its mean."""
    s = np.log(poles[np.abs(poles) > 1e-6].astype(complex)) / step_s
    inside = (s.imag > 2 * math.pi * BAND_HZ[0]) & (s.imag < 2 * math.pi * BAND_HZ[1])
    time = np.arange(len(x)) * step_s
    best, least = NOTHING, math.inf
    for pole in s[inside]:
        wave = np.exp(pole * time)
        columns = np.stack([wave.real, wave.imag, np.ones(len(x))], axis=1)
        c, *_ = np.linalg.lstsq(columns, x, rcond=None)
        rest = float(np.sum((x - columns @ c) ** 2))
        if rest < least:
            best, least = _of(complex(pole)), rest
    return best


def matrix_pencil(x: Array, step_s: float, order: int) -> Swing:
    """Matrix pencil (Hua, Sarkar 1990) with the pencil parameter of half the window."""
    hankel = np.lib.stride_tricks.sliding_window_view(x, len(x) // 2 + 1)
    _, _, vh = np.linalg.svd(hankel, full_matrices=False)
    v = vh[:order].conj().T
    return _strongest(x, np.linalg.eigvals(np.linalg.pinv(v[:-1]) @ v[1:]), step_s)


def era(x: Array, step_s: float, order: int) -> Swing:
    """Eigensystem realisation (Juang, Pappa 1985) of python-control."""
    half = len(x) // 2 - 1
    system, _ = control.eigensys_realization(x, r=order, m=half, n=half, dt=step_s)
    return _strongest(x, np.linalg.eigvals(system.A), step_s)


def log_decrement(x: Array, step_s: float) -> Swing:
    """Logarithmic decrement over the half-waves about the mean of the last half of the window."""
    y = x - x[len(x) // 2 :].mean()
    crossings = np.flatnonzero(np.signbit(y[:-1]) != np.signbit(y[1:]))
    edges = np.concatenate([[0], crossings, [len(y) - 1]])
    largest = float(np.max(np.abs(y)))
    at, size = [], []
    for first, last in pairwise(edges):
        part = np.abs(y[first : last + 1])
        if len(part) > 2 and 0 < int(np.argmax(part)) < len(part) - 1:
            at.append(first + int(np.argmax(part)))
            size.append(float(part.max()))
    keep = [k for k, s in enumerate(size) if s > 0.05 * largest]
    if len(keep) < 2:
        return NOTHING
    time, log = np.array(at)[keep] * step_s, np.log(np.array(size)[keep])
    omega = math.pi * (len(keep) - 1) / (time[-1] - time[0])
    slope, _ = np.polyfit(time, log, 1)
    s = complex(slope, omega)
    if len(keep) < 4:  # a line through three points says little of its own error
        return _of(s)
    rest = log - np.polyval(np.polyfit(time, log, 1), time)
    spread = math.sqrt(
        float(rest @ rest) / (len(keep) - 2) / float(np.sum((time - time.mean()) ** 2))
    )
    return _of(s, spread * omega**2 / abs(s) ** 3)


def ssi_window(x: Array, step_s: float, order: int) -> Swing:
    """pyOMA2's stochastic subspace identification (data-driven) on the window alone."""
    blocks = len(x) // 4
    y = x[None, :]
    hankel, _ = ssi.build_hank(y, y, blocks, "dat")
    _, a, _, _ = ssi.SSI_fast(hankel, blocks, order)
    return _strongest(x, np.linalg.eigvals(a[order]), step_s)


def ssi_whole(x: Array, step_s: float, about_hz: float) -> Swing:
    """The same on a whole recording, as it is meant: covariances, order 10, with its error.

    The mode is the one next to a frequency that is known; block rows over one and a half swings.
    """
    every = max(1, int(1.0 / (step_s * 25.0 * about_hz)))
    rows = len(x) // every * every
    y = x[:rows].reshape(-1, every).mean(axis=1)
    step, order = step_s * every, 10
    y = (y - y.mean())[None, :]
    blocks = max(order + 2, round(1.5 / (about_hz * step)))
    hankel, t = ssi.build_hank(y, y, blocks, "cov", calc_unc=True, nb=20)
    observed, a, c, _ = ssi.SSI_fast(hankel, blocks, order)
    poles = ssi.SSI_poles(
        observed, a, c, order, step, HC=False, calc_unc=True, H=hankel, T=t, xi_max=1.0
    )
    frequency, ratio, ratio_error = poles[0][:, -1], poles[1][:, -1], poles[5][:, -1]
    swings = np.isfinite(frequency) & (ratio > 0.0) & (ratio < 0.9)
    if not swings.any():
        return NOTHING
    off = np.where(swings, np.abs(np.log(np.maximum(frequency, 1e-9) / about_hz)), np.inf)
    k = int(np.argmin(off))
    z = float(ratio[k])
    return Swing(float(frequency[k]) * math.sqrt(1 - z**2), z, float(ratio_error[k]))


def on_windows() -> dict[str, Callable[[Array, float], Swing]]:
    """The methods that are here, by name."""
    methods: dict[str, Callable[[Array, float], Swing]] = {"log decrement": log_decrement}
    for order in (2, 3):
        methods[f"matrix pencil, order {order}"] = partial(matrix_pencil, order=order)
        methods[f"ERA (python-control), order {order}"] = partial(era, order=order)
        if ssi is not None:
            methods[f"SSI (pyOMA2), order {order}"] = partial(ssi_window, order=order)
    return methods
