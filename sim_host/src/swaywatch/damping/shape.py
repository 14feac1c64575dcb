"""Shape of a swing: how other signals swing along, before and behind the middle of a window.

A mode has one shape: the complex ratios of its amplitudes in all signals are the same in every free
swing at a speed and do not change along it. A force that acts meanwhile (a hand that is withdrawn
slowly) adds motion of another shape, also where frequency and damping stay as they are. Each
amplitude is a weighted sum of samples, so the same weights on the quiet windows of the recording
tell its error, in which the hand within the window has no part.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from swaywatch.damping.data import DampingRun
from swaywatch.damping.window import Line

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]
IntArray = npt.NDArray[np.int64]

ASIDE = 0.25
"""Where the shape is looked at: before and behind the middle, in half lengths of the window. At its
ends a shape cannot be determined (an offset is fitted too), in its middle a drift is not seen."""


class Shape(NamedTuple):
    """Amplitudes of the first evaluated channel and of what swings along, in that order.

    Attributes
    ----------
    middle : complex, shape (1 + signals,)
        Of a line without drift.
    aside : complex, shape (2, 1 + signals)
        ASIDE before and behind the middle, of a line whose amplitude drifts.
    quiet : complex, shape (2, 1 + signals, 1 + signals)
        Mean of q conj(q)^T, q: what `aside` is in quiet windows of the same length.
    """

    middle: ComplexArray
    aside: ComplexArray
    quiet: ComplexArray

    def off(self, usual: ComplexArray) -> tuple[FloatArray, FloatArray]:
        """Difference from a usual shape, and its standard error.

        Parameters
        ----------
        usual : complex, shape (signals,)
            Ratios to the first channel.

        Returns
        -------
        off, error : shape (2, signals)
            Before and behind the middle, in parts of the usual amplitude; the error is that of
            one component of the complex difference.
        """
        size = np.maximum(np.abs(usual * self.middle[0]), 1e-300)
        off = np.abs(self.aside[:, 1:] - usual * self.aside[:, :1]) / size
        own = np.einsum("kii->ki", self.quiet).real
        both = (np.conj(usual) * self.quiet[:, 1:, 0]).real
        power = own[:, 1:] - 2.0 * both + np.abs(usual) ** 2 * own[:, :1]
        return off, np.sqrt(np.maximum(power, 0.0) / 2.0) / size


def shape_of(run: DampingRun, line: Line, starts: IntArray) -> Shape | None:
    """Shape of one window; None where no signal swings along, or one has a gap or is stuck in it.

    Parameters
    ----------
    run
        With `along`.
    line
        Of the window: the wave that is looked for in all signals.
    starts
        First rows of quiet windows; one or more.
    """
    if not run.along_names:
        return None
    value = np.column_stack([run.value[:, :1], run.along])
    rows = max(8, round(line.length_s / run.step_s))
    first = max(0, min(round(line.start_s / run.step_s), len(value) - rows))
    own = value[first : first + rows]
    windows = [value[k : k + rows] for k in starts]
    windows = [window for window in windows if np.isfinite(window).all()]
    if not np.isfinite(own).all() or not np.ptp(own, axis=0).all() or not windows:
        return None
    middle, aside = _weights(line, rows, run.step_s)
    quiet = np.array([aside @ window for window in windows])
    power = np.einsum("nki,nkj->kij", quiet, np.conj(quiet)) / len(quiet)
    return Shape(middle @ own, aside @ own, power)


def _weights(line: Line, rows: int, step_s: float) -> tuple[ComplexArray, ComplexArray]:
    """Of the samples in the amplitudes: shapes (rows,) and (2, rows)."""
    time = (np.arange(rows) - (rows - 1) / 2) * step_s
    place = time / time[-1]
    wave = np.exp((line.growth_1_s + 1j * line.omega_rad_s) * time)
    level = [wave.real, -wave.imag, np.ones(rows)]
    plain = np.linalg.pinv(np.stack(level, axis=1))
    drift = np.linalg.pinv(np.stack([*level, place * wave.real, -place * wave.imag], axis=1))
    middle = plain[0] + 1j * plain[1]
    change = ASIDE * (drift[3] + 1j * drift[4])
    return middle, np.stack([middle - change, middle + change])
