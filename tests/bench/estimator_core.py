"""The C estimator (tests/bench/estimator_shim.c) for numpy, and the Cramer-Rao bound it is held to.

All signals are sampled at 100 Hz; angles in rad, time in s, t counted from mid-window.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

RATE_HZ = 100.0
CHANNELS = 16
Array = NDArray[np.float64]

NO_OSCILLATION, FORCED, GAP, SPEED, NONLINEAR, SEEKING, STARTING, NOT_CONVERGED, MISFIT, APART = (
    1 << bit for bit in range(10)
)
UNUSABLE = NO_OSCILLATION | SEEKING | NOT_CONVERGED


def middle_time(rows: int) -> Array:
    """Times of `rows` samples, counted from their middle, in s."""
    return (np.arange(rows) - (rows - 1) / 2) / RATE_HZ


@dataclass(frozen=True)
class Line:
    """A damped line amplitude e^(growth t) cos(omega t + phase)."""

    omega: float
    growth: float
    amplitude: float
    phase: float


def signal(line: Line, rows: int, mean: float, trend: float) -> Array:
    """The line with a mean and a trend per window, at `rows` samples."""
    t = middle_time(rows)
    wave = line.amplitude * np.exp(line.growth * t) * np.cos(line.omega * t + line.phase)
    return wave + mean + trend * t * RATE_HZ / rows


def bound(lines: list[Line], sigmas: list[float], rows: int) -> tuple[float, float, Array, Array]:
    """Cramer-Rao bound of channels that share omega and growth, mean and trend unknown in each.

    Returns
    -------
    Standard deviations: of omega [rad/s], of growth [1/s], of the amplitudes, of the phases [rad].
    """
    t = middle_time(rows)
    count = len(lines)
    jacobian = np.zeros((count * rows, 2 + 4 * count))
    for k, (line, sigma) in enumerate(zip(lines, sigmas, strict=True)):
        rise = np.exp(line.growth * t)
        cosine = rise * np.cos(line.omega * t + line.phase)
        sine = rise * np.sin(line.omega * t + line.phase)
        at = slice(k * rows, (k + 1) * rows)
        jacobian[at, 0] = -line.amplitude * t * sine / sigma
        jacobian[at, 1] = line.amplitude * t * cosine / sigma
        own = np.stack([cosine, -line.amplitude * sine, np.ones(rows), t], axis=1) / sigma
        jacobian[at, 2 + 4 * k : 6 + 4 * k] = own
    information = jacobian.T @ jacobian
    scale = 1 / np.sqrt(np.diag(information))
    covariance = np.linalg.inv(information * np.outer(scale, scale)) * np.outer(scale, scale)
    deviation = np.sqrt(np.diag(covariance))
    return deviation[0], deviation[1], deviation[2::4], deviation[3::4]


@dataclass(frozen=True)
class Estimate:
    """One estimate; arrays by channel, in the units of the samples times `unit`."""

    omega: float
    omega_se: float
    growth: float
    growth_se: float
    mid_time: float
    rows: int
    flags: int
    amplitude: NDArray[np.complex128]
    amplitude_se: Array
    phase_se: Array
    second: NDArray[np.complex128]
    noise: Array

    @property
    def half_s(self) -> float:
        """Half the length of the window."""
        return self.rows / 2 / RATE_HZ

    @property
    def end_time(self) -> float:
        """End of the window, in s."""
        return self.mid_time + self.half_s


def _estimate(common: Array, channel: Array) -> Estimate:
    return Estimate(
        omega=float(common[0]),
        omega_se=float(common[1]),
        growth=float(common[2]),
        growth_se=float(common[3]),
        mid_time=float(common[4]),
        rows=int(common[5]),
        flags=int(common[6]),
        amplitude=channel[:, 0] + 1j * channel[:, 1],
        amplitude_se=channel[:, 2],
        phase_se=channel[:, 3],
        second=channel[:, 4] + 1j * channel[:, 5],
        noise=channel[:, 8],
    )


def _pointer(array: NDArray[np.generic]) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


class Core:
    """The estimator of lib/ in a shared library. Samples are integers in micro-units."""

    def __init__(self, library: Path) -> None:
        self._library = ctypes.CDLL(str(library.resolve()))

    def window(self, samples: dict[int, Array]) -> Estimate:
        """One estimate over exactly the samples given, by channel; cold start, own search."""
        rows = len(next(iter(samples.values())))
        table = np.zeros((rows, CHANNELS), np.int32)
        mask = 0
        for channel, values in samples.items():
            table[:, channel] = np.round(values * 1e6)
            mask |= 1 << channel
        common, result = np.zeros(10), np.zeros((CHANNELS, 10))
        status = self._library.estimate(
            _pointer(table), rows, mask, _pointer(common), _pointer(result)
        )
        if status < 0:
            raise RuntimeError(f"the estimator refused {rows} rows with {status}")
        return _estimate(common, result)

    def follow(
        self, samples: dict[int, Array], cycles: float, valid: dict[int, Array] | None = None
    ) -> list[Estimate]:
        """All estimates of a long signal, row by row."""
        rows = len(next(iter(samples.values())))
        table = np.zeros((rows, CHANNELS), np.int32)
        masks = np.zeros(rows, np.uint32)
        mask = 0
        for channel, values in samples.items():
            table[:, channel] = np.round(values * 1e6)
            mask |= 1 << channel
            good = np.ones(rows, bool) if valid is None else valid[channel]
            masks |= np.where(good, 1 << channel, 0).astype(np.uint32)
        common, result = np.zeros((rows, 10)), np.zeros((rows, CHANNELS, 10))
        records = self._library.follow(
            _pointer(table), _pointer(masks), rows, mask, int(cycles * 1000),
            _pointer(common), _pointer(result), rows,
        )  # fmt: skip
        return [_estimate(common[i], result[i]) for i in range(records)]

    def follow_samples(
        self, time_s: Array, channel: NDArray[np.int64], value: Array, cycles: float
    ) -> list[Estimate]:
        """All estimates from samples that come at their own times, through the grid."""
        time_us = np.round(time_s * 1e6).astype(np.int64)
        inputs = channel.astype(np.int32)
        integers = np.round(value * 1e6).astype(np.int32)
        mask = 0
        for one in np.unique(channel):
            mask |= 1 << int(one)
        count = len(time_s)
        common, result = np.zeros((count, 10)), np.zeros((count, CHANNELS, 10))
        records = self._library.follow_samples(
            _pointer(time_us), _pointer(inputs), _pointer(integers), count, mask,
            int(cycles * 1000), _pointer(common), _pointer(result), count,
        )  # fmt: skip
        return [_estimate(common[i], result[i]) for i in range(records)]
