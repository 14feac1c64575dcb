"""What wind, road or rider do to a fit where no quiet time tells it: from what the line leaves.

The motion that goes on meanwhile is taken as the same mode under random forces: a complex process
with the line's own pole. Most of it looks like the line and is taken up by the fit, which is what
makes the fit wrong; the rest of it stays in the residual, within the band of the swing. Drawn
processes tell both parts, so the residual gives the size of the whole, and that the scatter of
growth and frequency. Noise of the sensors, which is as strong beyond the band, is taken out first.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy import signal

from swaywatch.damping.window import Line, core_rows, sensitivity

FloatArray = npt.NDArray[np.float64]

_DRAWN = 100
_SEED = 1
_LEAST_DECAY = 0.02
"""Of a drawn process, over its frequency: an undamped one would have no finite size."""

_BAND = 2.0
"""Times the line's frequency: up to there motion counts, beyond it noise."""


def ambient_covariance(samples: FloatArray, step_s: float, line: Line) -> FloatArray:
    """Covariance (2, 2) of growth (1/s) and omega (rad/s) from motion that goes on meanwhile.

    Parameters
    ----------
    samples : shape (rows, channels)
        The window's, raw.
    step_s
        Between two rows.
    line
        What was found in it.
    """
    rows, step, _ = core_rows(samples, step_s)
    moves = sensitivity(line, len(rows), step)
    left = _left(rows, step, line, np.zeros(2))
    mode = _drawn(line, len(rows), step)  # (drawn, rows, channels)
    shifts = np.einsum("irc,drc->di", moves, mode)
    rests = [_left(one, step, line, shift) for one, shift in zip(mode, shifts, strict=True)]
    unit = np.mean([_in_band(rest, step, line)[0] for rest in rests], axis=0)
    inside, noise = _in_band(left, step, line)
    power = np.maximum(inside - noise, 0.0) / np.maximum(unit, 1e-12)
    sized = np.einsum("irc,drc,c->di", moves, mode, np.sqrt(power))
    return np.asarray(sized.T @ sized / len(sized), dtype=np.float64)


def _drawn(line: Line, rows: int, step_s: float) -> FloatArray:
    """The mode under random forces, RMS 1 in every channel; the same in every call."""
    decay = max(-line.growth_1_s, _LEAST_DECAY * line.omega_rad_s)
    pole = np.exp((-decay + 1j * line.omega_rad_s) * step_s)
    rng = np.random.default_rng(_SEED)
    shape = (_DRAWN, rows)
    force = rng.normal(size=shape) + 1j * rng.normal(size=shape)
    force *= math.sqrt(1.0 - abs(pole) ** 2)
    force[:, 0] /= math.sqrt(1.0 - abs(pole) ** 2)  # as large at the begin as ever after
    process = signal.lfilter([1.0], [1.0, -pole], force, axis=1)
    turned = np.exp(1j * np.angle(line.amplitude))
    return np.asarray((process[:, :, None] * turned).real, dtype=np.float64)


def _left(samples: FloatArray, step_s: float, line: Line, shift: FloatArray) -> FloatArray:
    """What mean, slope, the line and a shift of its growth and omega leave of samples."""
    time = (np.arange(len(samples)) - (len(samples) - 1) / 2) * step_s
    wave = np.exp((line.growth_1_s + 1j * line.omega_rad_s) * time)
    columns = [wave.real, wave.imag, np.ones(len(time)), time]
    base = np.stack(columns[: 3 if line.level else 4], axis=1)
    turned = (wave * time)[:, None] * line.amplitude
    moved = samples - turned.real * shift[0] + turned.imag * shift[1]
    return np.asarray(moved - base @ np.linalg.lstsq(base, moved, rcond=None)[0], dtype=np.float64)


def _in_band(rest: FloatArray, step_s: float, line: Line) -> tuple[FloatArray, FloatArray]:
    """Mean power of every channel within the band, and how much of it would be noise."""
    power = np.abs(np.fft.rfft(rest, axis=0)) ** 2 / len(rest) ** 2 * 2.0
    inside = np.fft.rfftfreq(len(rest), step_s) <= _BAND * line.frequency_hz
    beyond = np.median(power[~inside], axis=0) / math.log(2.0) if (~inside).sum() >= 4 else 0.0
    return power[inside].sum(axis=0), np.asarray(beyond * inside.sum() * np.ones(rest.shape[1]))
