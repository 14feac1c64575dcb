"""A swing without what the driver adds to it: his part is taken out of the samples.

A hand on a wheel is never quite still, and what it does at the swing's own frequency drives the
swing. A linear mode answers an input u by z' = s z + u, and each channel shows Re(g z). The act
that began the swing tells g: the amplitude at the begin of the window over the z that all input
before it has left. The same g then says what the input within the window adds, which is taken out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import signal

from swaywatch.damping.data import DampingRun
from swaywatch.damping.window import Line

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

ADDED = 0.25
"""Answer to the input within a window over the free swing, up to which it can be taken out."""

GAIN_UNCERTAINTY = 0.25
"""What stays uncertain of the input's part: an act is larger than a hand's wandering, so tyres give
less for it, and other motion is in the amplitude at the begin of the window."""

_MEMORY_DECAYS, _MEMORY_CYCLES = 5.0, 40.0
"""How far back the input counts."""


class Freed(NamedTuple):
    """Samples without an input's part, and the sizes of the mode's two parts at every row."""

    samples: FloatArray
    free: FloatArray
    answer: FloatArray

    def little(self, begin: int, end: int) -> bool:
        """The input adds little to what is left of the swing at the begin of some rows."""
        begin = min(max(begin, 0), len(self.free) - 1)
        most = float(np.max(self.answer[begin : max(end, begin + 1)]))
        return most <= ADDED * float(self.free[begin])


def without_input(run: DampingRun, line: Line, which: int, end_s: float) -> Freed | None:
    """The samples from the begin of a line on without an input's part in them.

    Parameters
    ----------
    run
        Its input `which` began the swing.
    line
        Of the swing's first window.
    end_s
        Up to where.

    Returns
    -------
    Freed or None
        None: the input before does not outweigh the one within, so the gain is not known.
    """
    rows = run.rows(line.start_s, end_s)
    s = complex(line.growth_1_s, line.omega_rad_s)
    memory = _MEMORY_CYCLES / line.frequency_hz
    if s.real < 0.0:
        memory = min(memory, _MEMORY_DECAYS / -s.real)
    first = run.rows(max(0.0, line.start_s - memory), line.start_s).start
    value = run.inputs[first : rows.stop, which]
    value = value - np.median(value)
    at = rows.start - first
    if at < 4:
        return None
    before = complex(answer(value[: at + 1], s, run.step_s)[-1])
    within = answer(value[at:], s, run.step_s)
    free = np.exp(s.real * np.arange(len(within)) * run.step_s) * max(abs(before), 1e-300)
    first_cycles = round(2.0 / (line.frequency_hz * run.step_s))
    if float(np.max(np.abs(within[:first_cycles]))) > ADDED * abs(before):
        return None
    begin = line.amplitude * np.exp(s * (run.time_s[rows.start] - line.mid_s))
    added = (within[:, None] * (begin / before)).real
    return Freed(run.value[rows] - added, free, np.abs(within))


def answer(value: FloatArray, s: complex, step_s: float) -> ComplexArray:
    """Solution of z' = s z + value, z = 0 at the first row; an input holds from row to row."""
    pole = np.exp(s * step_s)
    held = np.concatenate([[0.0], value[:-1]]).astype(np.complex128)
    return np.asarray(signal.lfilter([(pole - 1.0) / s], [1.0, -pole], held))
