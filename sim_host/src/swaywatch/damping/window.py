"""One window through the C core: a damped line that all channels share, and what may be off in it.

The core works on windows of 32 to 496 rows; :func:`core_rows` brings a window of any length and
rate there (means of whole blocks where there are too many rows, a spline where there are too few).
The core gets times as if a row lasted 10 ms, so 0.2 Hz and 10 Hz are the same to it. Nothing
is estimated here: :class:`Line` is what ``sway_line`` found; the functions below say how a
disturbance of the samples would have moved it (its first-order sensitivity).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import interpolate

from swaywatch.ecu._core import ffi, lib

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

NO_OSCILLATION = 0x001
NOT_CONVERGED = 0x080
MISFIT = 0x100
"""Flags of ``sway_line.h`` that a window can have."""

FEWEST_ROWS, MOST_ROWS = 40, 448
MOST_CHANNELS = 15
_FULL = 2.0**26
_PERIOD_US = 10_000
_STARTS = (1.0, 0.75, 1.33)
"""Starts of the search, times the frequency that was asked for."""


@dataclass(frozen=True)
class Line:
    """A damped line Re(a e^((growth + j omega) (t - mid_s))) in every channel.

    Attributes
    ----------
    mid_s, length_s
        Middle and length of the window, s.
    omega_rad_s, growth_1_s
        Common to all channels; with their standard errors for white noise.
    amplitude : complex, shape (channels,)
        At the middle of the window, unit of the channel.
    noise : shape (channels,)
        Standard deviation of the residual.
    flags
        Of ``sway_line.h``.
    """

    mid_s: float
    length_s: float
    omega_rad_s: float
    omega_se_rad_s: float
    growth_1_s: float
    growth_se_1_s: float
    amplitude: ComplexArray
    noise: FloatArray
    flags: int
    level: bool = False

    @property
    def damping_ratio(self) -> float:
        """-growth over the natural frequency."""
        return -self.growth_1_s / math.hypot(self.growth_1_s, self.omega_rad_s)

    @property
    def frequency_hz(self) -> float:
        """Of the damped swing."""
        return self.omega_rad_s / (2 * math.pi)

    @property
    def cycles(self) -> float:
        """Oscillations in the window."""
        return self.length_s * self.frequency_hz

    @property
    def start_s(self) -> float:
        """Begin of the window."""
        return self.mid_s - 0.5 * self.length_s

    def size(self, time_s: FloatArray | float) -> FloatArray:
        """Envelope of every channel at some times, shape (..., channels)."""
        rise = np.exp(self.growth_1_s * (np.asarray(time_s, dtype=np.float64) - self.mid_s))
        return np.asarray(np.abs(self.amplitude) * rise[..., None], dtype=np.float64)

    def converged(self) -> bool:
        """The core's last step was small."""
        return not self.flags & NOT_CONVERGED


def core_rows(samples: FloatArray, step_s: float) -> tuple[FloatArray, float, float]:
    """A window with a number of rows that the core takes.

    Parameters
    ----------
    samples : shape (rows, channels)
        4 rows or more.
    step_s
        Time between two rows.

    Returns
    -------
    samples, step_s
        Means of whole blocks, or a spline through the rows.
    factor
        By what the core's white-noise errors have to be multiplied: rows of a spline are not
        independent.
    """
    rows = len(samples)
    if rows > MOST_ROWS:
        block = -(-rows // MOST_ROWS)
        kept = rows // block * block
        shape = (kept // block, block, samples.shape[1])
        return samples[rows - kept :].reshape(shape).mean(axis=1), step_s * block, 1.0
    if rows < FEWEST_ROWS:
        times = -(-FEWEST_ROWS // (rows - 1))
        place = np.arange((rows - 1) * times + 1) / times
        smooth = interpolate.CubicSpline(np.arange(rows), samples, axis=0)(place)
        return np.asarray(smooth, dtype=np.float64), step_s / times, math.sqrt(times)
    return samples, step_s, 1.0


class Estimator:
    """Memory of the core for windows, one after the other."""

    def __init__(self) -> None:
        self._memory = ffi.new("core_window_t *")
        self._found = ffi.new("core_line_t *")

    def line(
        self,
        samples: FloatArray,
        start_s: float,
        step_s: float,
        frequency_hz: float,
        *,
        level: bool = False,
    ) -> Line | None:
        """Estimate one window from several starts around a frequency; the best, or None.

        Parameters
        ----------
        samples : shape (rows, channels)
            Raw, offsets and all; 8 rows or more.
        start_s, step_s
            Time of the first row, time between rows.
        frequency_hz
            Where to look.
        level
            No slope in the model of a channel.
        """
        if len(samples) < 8:
            return None
        offset = samples.mean(axis=0)
        size = np.maximum(np.max(np.abs(samples - offset), axis=0), 1e-300)
        rows, step, factor = core_rows((samples - offset) / size, step_s)
        first = start_s + (len(samples) - 1) * step_s - (len(rows) - 1) * step
        best: Line | None = None
        for times in _STARTS:
            line = self._once(rows, first, step, frequency_hz * times, factor, level)
            if line is not None and (best is None or _rank(line) < _rank(best) * 0.999):
                best = line
            if best is not None and best.converged() and times == 1.0 and _rank(best) < 0.15:
                break
        if best is None:
            return None
        return replace(best, amplitude=best.amplitude * size, noise=best.noise * size)

    def _once(
        self,
        rows: FloatArray,
        first_s: float,
        step_s: float,
        frequency_hz: float,
        factor: float,
        level: bool,
    ) -> Line | None:
        count, channels = rows.shape
        whole = np.ascontiguousarray(np.rint(rows * _FULL).astype(np.int32))
        scale = step_s / (_PERIOD_US * 1e-6)
        omega = 2 * math.pi * frequency_hz * scale
        lib.core_window(
            self._memory, ffi.cast("int32_t *", whole.ctypes.data), count, channels,
            (1 << channels) - 1, _PERIOD_US, omega, level, self._found,
        )  # fmt: skip
        found: Any = self._found
        if found.error != lib.SWAY_OK or found.omega_rad_s <= 0.0:
            return None
        used = int(found.rows)
        real, imaginary = list(found.amplitude_re), list(found.amplitude_im)
        amplitude = np.array(real[:channels]) + 1j * np.array(imaginary[:channels])
        last = first_s + (count - 1) * step_s
        return Line(
            last - (used - 1) * step_s / 2,
            used * step_s,
            found.omega_rad_s / scale,
            found.omega_se_rad_s / scale * factor,
            found.growth_1_s / scale,
            found.growth_se_1_s / scale * factor,
            amplitude / _FULL,
            np.array(list(found.noise_rms)[:channels]) / _FULL,
            int(found.flags),
            level,
        )


def _rank(line: Line) -> float:
    """Smaller is better: what the line leaves, in the channels' largest values."""
    rest = float(np.sqrt(np.mean(line.noise**2)))
    return rest * (1.0 if line.converged() else 2.0) + 1e-9


def sensitivity(line: Line, rows: int, step_s: float) -> FloatArray:
    """How every sample moves growth and omega, shape (2, rows, channels).

    First-order, of the least-squares fit with mean and slope of its own in every channel (no
    slope where the line is `level`), weighed by each channel's noise as the core does.
    """
    time = (np.arange(rows) - (rows - 1) / 2) * step_s
    half = max(float(time[-1]), 1e-12)
    exponent = (line.growth_1_s + 1j * line.omega_rad_s) * time
    wave = np.exp(exponent)
    columns = [wave.real, -wave.imag, np.ones(rows), time / half]
    base = np.stack(columns[: 3 if line.level else 4], axis=1)
    orthogonal, _ = np.linalg.qr(base)
    size = np.abs(line.amplitude)
    floor = np.maximum(line.noise, 1e-12 * size)
    swings = size > 1e-150  # a channel that stands still (stuck, frozen) tells nothing
    weight = np.where(swings, 1.0 / np.where(swings, floor, 1.0) ** 2, 0.0)
    moved = np.empty((2, rows, len(weight)))
    for channel, amplitude in enumerate(line.amplitude):
        turned = amplitude * wave * time
        both = np.stack([turned.real, -turned.imag], axis=1)
        both -= orthogonal @ (orthogonal.T @ both)
        moved[:, :, channel] = both.T
    normal = np.einsum("irc,jrc,c->ij", moved, moved, weight)
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    inverse = np.linalg.pinv(normal / np.outer(scale, scale)) / np.outer(scale, scale)
    return np.asarray(np.einsum("ij,jrc,c->irc", inverse, moved, weight), dtype=np.float64)


def damping_error(line: Line, covariance: FloatArray) -> float:
    """Standard error of the damping ratio from the covariance (2, 2) of growth and omega."""
    size = math.hypot(line.growth_1_s, line.omega_rad_s)
    slope = (
        np.array([-(line.omega_rad_s**2), line.growth_1_s * line.omega_rad_s], dtype=np.float64)
        / size**3
    )
    return math.sqrt(max(0.0, float(slope @ covariance @ slope)))
