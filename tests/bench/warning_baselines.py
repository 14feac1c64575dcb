"""What else one could build: three usual detectors, on the same measured signals.

Each takes the measured signals on a 100 Hz axis and returns when it would warn: start and end of
each episode, shape (n, 2); an episode ends after 2 s of silence. Their parameters are
usual values, not tuned to the campaign.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from numba import njit
from scipy.signal import butter, sosfilt

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

RATE_HZ = 100.0
_BAND = butter(2, [0.3, 1.5], btype="bandpass", fs=RATE_HZ, output="sos")


def episodes(active: BoolArray, silence_s: float = 2.0) -> FloatArray:
    """Start and end of runs of True that are at least `silence_s` apart, shape (n, 2), s."""
    index = np.flatnonzero(active)
    if not len(index):
        return np.zeros((0, 2))
    first = np.diff(index, prepend=-(10**9)) > silence_s * RATE_HZ
    last = np.append(first[1:], True)
    return np.column_stack([index[first] / RATE_HZ, index[last] / RATE_HZ + silence_s])


def _quiet(steering: FloatArray, window_s: float, limit_rad: float) -> BoolArray:
    """The wheel has stayed within +-limit for `window_s`."""
    n = round(window_s * RATE_HZ)
    view = np.lib.stride_tricks.sliding_window_view(steering, n)
    inside = (view.max(axis=1) - view.min(axis=1)) < 2 * limit_rad
    return np.concatenate([np.zeros(n - 1, dtype=bool), inside])


@njit(cache=True)
def _peaks(signal: FloatArray) -> tuple[npt.NDArray[np.int64], FloatArray]:
    """Extrema between zero crossings; index is that of the crossing that ends the half-wave."""
    index = np.zeros(len(signal), dtype=np.int64)
    value = np.zeros(len(signal))
    count = 0
    best = 0.0
    for k in range(1, len(signal)):
        if signal[k] * signal[k - 1] < 0:
            index[count] = k
            value[count] = best
            count += 1
            best = 0.0
        if abs(signal[k]) > abs(best):
            best = signal[k]
    return index[:count], value[:count]


def peak_counter(
    signals: dict[str, FloatArray], threshold: float = math.radians(5.0)
) -> FloatArray:
    """Two successive half-swings of the trailer's yaw rate over a threshold, in the sway band."""
    band = np.asarray(sosfilt(_BAND, signals["trailer_yaw_rate"]))
    index, value = _peaks(band)
    active = np.zeros(len(band), dtype=bool)
    for k in range(1, len(index)):
        spacing = (index[k] - index[k - 1]) / RATE_HZ
        high = min(abs(value[k]), abs(value[k - 1])) > threshold
        if high and 0.3 < spacing < 2.0:
            active[index[k] : index[k] + 50] = True
    return episodes(active)


def log_decrement(
    signals: dict[str, FloatArray], threshold: float = math.radians(1.5), peaks: int = 4
) -> FloatArray:
    """Line through the logarithms of the last half-swings rises, steering quiet."""
    band = np.asarray(sosfilt(_BAND, signals["trailer_yaw_rate"]))
    index, value = _peaks(band)
    quiet = _quiet(signals["steering_wheel_angle"], 1.5, math.radians(1.5))
    active = np.zeros(len(band), dtype=bool)
    place = np.arange(peaks) - (peaks - 1) / 2
    for k in range(peaks, len(index)):
        last = np.abs(value[k - peaks + 1 : k + 1])
        if last.min() < threshold or not quiet[min(index[k], len(quiet) - 1)]:
            continue
        if float(place @ np.log(last)) / float(place @ place) > 0:
            active[index[k] : index[k] + 100] = True
    return episodes(active)


@njit(cache=True)
def _rls(y: FloatArray, u: FloatArray, forget: float) -> FloatArray:
    """Damping ratio from a recursive ARX(2, 2) of y on u at 10 Hz; nan before it is settled."""
    theta = np.zeros(4)
    p = np.eye(4) * 1e3
    out = np.full(len(y), np.nan)
    for k in range(2, len(y)):
        x = np.array([y[k - 1], y[k - 2], u[k - 1], u[k - 2]])
        px = p @ x
        gain = px / (forget + x @ px)
        theta = theta + gain * (y[k] - x @ theta)
        p = (p - np.outer(gain, px)) / forget
        if np.trace(p) > 1e8:
            p = np.eye(4) * 1e3
        discriminant = theta[0] ** 2 + 4 * theta[1]
        if k > 30 and discriminant < 0 and theta[1] < 0:
            radius = math.sqrt(-theta[1])
            angle = math.atan2(math.sqrt(-discriminant), theta[0])
            growth = math.log(radius) * 10.0
            omega = angle * 10.0
            if 1.5 < omega < 10.0:
                out[k] = -growth / math.hypot(growth, omega)
    return out


def recursive_least_squares(
    signals: dict[str, FloatArray], threshold: float = math.radians(1.5)
) -> FloatArray:
    """Negative damping of a recursive ARX model with steering input, for half a second."""
    band = np.asarray(sosfilt(_BAND, signals["trailer_yaw_rate"]))
    wheel = np.asarray(sosfilt(_BAND, signals["steering_wheel_angle"]))
    ratio = _rls(band[::10] * 10, wheel[::10] * 10, 0.96)
    envelope = np.array(
        [np.abs(band[max(0, 10 * k - 80) : 10 * k + 1]).max() for k in range(len(ratio))]
    )
    unstable = (ratio < 0) & (envelope > threshold)
    held = np.convolve(unstable, np.ones(5), mode="full")[: len(unstable)] >= 5
    return episodes(np.repeat(held, 10))


DETECTORS = {
    "peak counter": peak_counter,
    "log decrement": log_decrement,
    "recursive least squares": recursive_least_squares,
}
