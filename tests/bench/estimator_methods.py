"""Other people's estimators of one line, as they are commonly used, for the comparison.

Every function takes one window of samples at 100 Hz and gives (omega, growth, amplitude, phase):
rad/s, 1/s, units of the samples, rad at mid-window; None for what the method does not give.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import control
import numpy as np
from estimator_core import RATE_HZ, Array, middle_time

Result = tuple[float, float | None, float | None, float | None]


def _peak(magnitude: Array) -> int:
    return int(np.argmax(magnitude[1 : len(magnitude) - 1])) + 1


def _hann(x: Array) -> tuple[np.ndarray, Array]:
    """Spectrum with a periodic Hann window, mean taken out, and its amplitudes."""
    rows = len(x)
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(rows) / rows)
    spectrum = np.fft.rfft((x - x.mean()) * window)
    return spectrum, np.abs(spectrum) * 4 / rows


def _from_bin(x: Array, spectrum: np.ndarray, peak: int, offset: float, amplitude: float) -> Result:
    rows = len(x)
    omega = 2 * np.pi * (peak + offset) * RATE_HZ / rows
    start_phase = np.angle(spectrum[peak]) - offset * np.pi
    return omega, None, amplitude, start_phase + omega * (rows - 1) / 2 / RATE_HZ


def appendix_a3(x: Array) -> Result:
    """The dissertation's triple-spectrum-line interpolation, App. A.3 (Hann window)."""
    spectrum, a = _hann(x)
    peak = _peak(a)
    r = (a[peak + 1] - a[peak - 1]) / a[peak]
    offset = 0.66666287 * r - 0.07398320 * r**3 + 0.01587358 * r**5 - 0.00311639 * r**7
    p = 1.33333327 + 0.52658791 * offset**2 + 0.11699742 * offset**4 + 0.02103885 * offset**6
    amplitude = (a[peak - 1] + 2 * a[peak] + a[peak + 1]) / 4 * p
    return _from_bin(x, spectrum, peak, offset, amplitude)


def hann_three(x: Array) -> Result:
    """Three lines of the Hann window, exact closed form (facts.md)."""
    spectrum, a = _hann(x)
    peak = _peak(a)
    r = (a[peak + 1] - a[peak - 1]) / a[peak]
    offset = 4 * r / (3 + np.sqrt(9 + 4 * r * r))
    p = (1 - offset**2) * (4 - offset**2) / (3 * np.sinc(offset))
    amplitude = (a[peak - 1] + 2 * a[peak] + a[peak + 1]) / 4 * p
    return _from_bin(x, spectrum, peak, offset, amplitude)


def hann_two(x: Array) -> Result:
    """Two lines of the Hann window: the peak and the larger neighbour."""
    spectrum, a = _hann(x)
    peak = _peak(a)
    side = 1 if a[peak + 1] > a[peak - 1] else -1
    ratio = a[peak + side] / a[peak]
    offset = side * (2 * ratio - 1) / (ratio + 1)
    amplitude = a[peak] * (1 - offset**2) / np.sinc(offset)
    return _from_bin(x, spectrum, peak, offset, amplitude)


def jacobsen(x: Array) -> Result:
    """Jacobsen's three complex lines of the rectangular window."""
    rows = len(x)
    spectrum = np.fft.rfft(x - x.mean())
    peak = _peak(np.abs(spectrum))
    below, middle, above = spectrum[peak - 1 : peak + 2]
    offset = float(np.real((below - above) / (2 * middle - below - above)))
    amplitude = 2 / rows * abs(middle) / max(np.sinc(offset), 0.1)
    return _from_bin(x, spectrum, peak, offset, amplitude)


def _detrended(x: Array) -> Array:
    t = middle_time(len(x))
    return x - x.mean() - t * (t @ (x - x.mean())) / (t @ t)


def log_decrement(x: Array) -> Result:
    """Logarithmic decrement: half-waves between crossings of the detrended, smoothed signal."""
    y = np.convolve(_detrended(x), np.ones(9) / 9, mode="same")
    crossings = np.flatnonzero(np.signbit(y[:-1]) != np.signbit(y[1:]))
    extremes = []
    for first, last in pairwise(crossings):
        if last - first < 20:
            continue
        at = first + 1 + int(np.argmax(np.abs(y[first + 1 : last + 1])))
        extremes.append((at, abs(y[at])))
    if len(extremes) < 2:
        return np.nan, np.nan, np.nan, None
    at, size = np.array(extremes).T
    half_period = (at[-1] - at[0]) / (len(at) - 1) / RATE_HZ
    slope, level = np.polyfit(at / RATE_HZ, np.log(size), 1)
    amplitude = np.exp(level + slope * (len(x) - 1) / 2 / RATE_HZ)
    return np.pi / half_period, slope, amplitude, None


def _from_poles(x: Array, poles: np.ndarray, step_s: float) -> Result:
    """Amplitude and phase by least squares with mean and trend on the sway pole."""
    s = np.log(poles[poles != 0].astype(complex)) / step_s
    band = s[(s.imag > 2 * np.pi * 0.25) & (s.imag < 2 * np.pi * 2) & (abs(s.real) < 2)]
    if len(band) == 0:
        return np.nan, np.nan, np.nan, np.nan
    t = middle_time(len(x))
    best: tuple[float, complex, complex] | None = None
    for pole in band:
        wave = np.exp(pole * t)
        columns = np.stack([wave.real, -wave.imag, np.ones(len(t)), t], axis=1)
        c, *_ = np.linalg.lstsq(columns, x, rcond=None)
        rest = float(np.sum((x - columns @ c) ** 2))
        if best is None or rest < best[0]:
            best = (rest, complex(pole), complex(c[0], c[1]))
    assert best is not None
    _, pole, line = best
    return pole.imag, pole.real, abs(line), float(np.angle(line))


def _thinned(x: Array) -> tuple[Array, float]:
    """Means of 4 samples, at 25 Hz."""
    rows = len(x) // 4 * 4
    return x[len(x) - rows :].reshape(-1, 4).mean(axis=1), 4 / RATE_HZ


def matrix_pencil(x: Array) -> Result:
    """Matrix pencil (Hua, Sarkar), order 4: the line, and a double pole at 1 for mean and trend."""
    y, step_s = _thinned(x)
    span = len(y) // 2
    hankel = np.lib.stride_tricks.sliding_window_view(y, span + 1)
    _, _, vh = np.linalg.svd(hankel, full_matrices=False)
    v = vh[:4].conj().T
    poles = np.linalg.eigvals(np.linalg.pinv(v[:-1]) @ v[1:])
    return _from_poles(x, poles, step_s)


def era(x: Array) -> Result:
    """Eigensystem realisation of python-control, order 4, on the window as a free response."""
    y, step_s = _thinned(x)
    half = len(y) // 2 - 1
    system, _ = control.eigensys_realization(y, r=4, m=half, n=half, dt=step_s)
    return _from_poles(x, np.linalg.eigvals(system.A), step_s)


METHODS: dict[str, Callable[[Array], Result]] = {
    "A.3": appendix_a3,
    "Hann 3 lines": hann_three,
    "Hann 2 lines": hann_two,
    "Jacobsen": jacobsen,
    "log decrement": log_decrement,
    "matrix pencil": matrix_pencil,
    "ERA": era,
}

#: Methods that need some 10 ms a window.
SLOW = ("matrix pencil", "ERA")
