"""Runs on one common grid, with the noise of each channel, ready for the diagnosis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

Array = NDArray[np.float64]

RATE_HZ = 100.0
NOISE_BAND_HZ = (3.0, 4.8)
HIGH_SHARE = 0.7
BLOCK = 10  # samples averaged for one residual: 10 Hz, and the wheels' ripple at 10 Hz drops out
#: Samples after a start in mid-motion until bodies and tyres have forgotten how they rolled then.
SETTLING = 200
MOVING_RAD_S = 0.02  # yaw rate at the first block from which a recording starts in mid-motion

#: Channels a single measurement fault can sit in, by the name of the component.
FAULT_CHANNELS: dict[str, tuple[str, ...]] = {
    name: (name,)
    for name in (
        "car_yaw_rate", "car_lateral_acceleration", "trailer_yaw_rate",
        "trailer_lateral_acceleration", "hitch_lateral_force",
        "wheel_lateral_force_fl", "wheel_lateral_force_fr",
        "wheel_lateral_force_rl", "wheel_lateral_force_rr",
        "wheel_vertical_load_fl", "wheel_vertical_load_fr",
        "wheel_vertical_load_rl", "wheel_vertical_load_rr",
    )
}  # fmt: skip


@dataclass
class Run:
    """One recording on an even grid from its first common sample.

    Attributes
    ----------
    name
        Name of the file, for reports only.
    time
        Shape (n,), seconds since the first message of the recording.
    channels
        Channel name to values of shape (n,), SI.
    noise
        White noise of each channel, one sample, SI.
    positions
        Metres ahead of the centre of gravity of the accelerometers.
    steering_ratio
        From vehicle.toml.
    speed, acceleration, steer
        Smoothed inputs of the plant, shape (n,).
    scales
        Standard deviation of the residual of each channel (filled on demand).
    correction
        What the user's own simulation has beyond the plant, by channel, shape (n,).
    observed
        The same with both under the observer: what is wrong where and when it is, not carried on.
    simulated
        Scratch of the modules.
    silent
        Of the channels that say nothing at times: where, shape (n,).
    kept
        Of the channels of which not all samples count: which do, shape (n,).
    settling
        Samples at the beginning that hardly count: nobody knows how the bodies roll there.
    """

    name: str
    time: Array
    channels: dict[str, Array]
    positions: dict[str, float]
    steering_ratio: float
    noise: dict[str, float] = field(default_factory=dict)
    speed: Array = field(default_factory=lambda: np.zeros(0))
    acceleration: Array = field(default_factory=lambda: np.zeros(0))
    steer: Array = field(default_factory=lambda: np.zeros(0))
    scales: dict[str, float] = field(default_factory=dict)
    correction: dict[str, Array] = field(default_factory=dict)
    observed: dict[str, Array] = field(default_factory=dict)
    simulated: dict[str, Array] = field(default_factory=dict)
    silent: dict[str, NDArray[np.bool_]] = field(default_factory=dict)
    kept: dict[str, NDArray[np.bool_]] = field(default_factory=dict)
    settling: int = 0

    def kept_blocks(self, name: str) -> NDArray[np.bool_]:
        """Which block means of a channel count. Shape (n // BLOCK,)."""
        if name not in self.kept:
            return np.ones(self.time.size // BLOCK, dtype=np.bool_)
        return block_mean(self.kept[name].astype(float)) > 0.999

    @cached_property
    def yaw_rates(self) -> dict[str, Array]:
        """Smoothed yaw rates of the bodies whose own is recorded, by body, shape (n,) each."""
        found = {}
        for body in ("car", "trailer"):
            if f"{body}_yaw_rate" in self.channels:
                rate = self._filled(f"{body}_yaw_rate")
                found[body] = low_pass(rate - rate.mean(), 5.0)
        return found

    @property
    def both_watched(self) -> bool:
        """Whether an observer can hold both bodies."""
        return len(self.yaw_rates) == 2

    def part(self, first: int, last: int) -> Run:
        """Samples `first` to `last` as a run of their own, its times those of the whole."""
        inside = slice(first, last)
        found = replace(
            self,
            time=self.time[inside],
            channels={k: v[inside] for k, v in self.channels.items()},
            speed=self.speed[inside],
            acceleration=self.acceleration[inside],
            steer=self.steer[inside],
            scales=dict(self.scales),
            correction={k: v[inside] for k, v in self.correction.items()},
            observed={k: v[inside] for k, v in self.observed.items()},
            # what modules keep for themselves (_...) depends on the whole run
            simulated={k: v[inside] for k, v in self.simulated.items() if not k.startswith("_")},
            silent={k: v[inside] for k, v in self.silent.items()},
            kept={k: v[inside] for k, v in self.kept.items()},
        )
        # the offsets of the sensors are those of the whole
        found.yaw_rates = {k: v[inside] for k, v in self.yaw_rates.items()}
        return found

    def _filled(self, name: str) -> Array:
        """A channel, estimated from the others where its sensor is silent. Shape (n,)."""
        value = self.channels[name]
        silent = self.silent.get(name)
        if silent is None:
            return value
        good = ~silent
        columns = [np.ones(value.size)]
        for other, theirs in self.channels.items():
            if other != name and not np.any(self.silent.get(other, good) & silent):
                smooth = low_pass(theirs, 5.0)
                columns += [smooth, np.gradient(smooth) * RATE_HZ]
        a = np.stack(columns, axis=1)
        a = a / (np.sqrt(np.mean(a**2, axis=0)) + 1e-12)
        estimated = a @ np.linalg.lstsq(a[good], value[good], rcond=None)[0]
        return np.where(good, value, estimated)

    def prepare(self) -> Run:
        """Drop dead channels, measure noise, smooth the inputs."""
        for name in list(self.channels):
            if float(np.std(self.channels[name])) == 0.0:
                del self.channels[name]
        self.noise = {name: white_noise(value) for name, value in self.channels.items()}
        self.speed = low_pass(self.channels["speed"], 0.7, order=2)
        self.acceleration = np.gradient(self.speed) * RATE_HZ
        self.steer = low_pass(self.channels["steering_wheel_angle"], 10.0) / self.steering_ratio
        rates = [v for k, v in self.channels.items() if k.endswith("yaw_rate")]
        moving = any(abs(float(np.mean(rate[:BLOCK]))) > MOVING_RAD_S for rate in rates)
        self.settling = SETTLING if moving else 0
        return self


def low_pass(value: Array, cutoff_hz: float, order: int = 4) -> Array:
    """Zero-phase Butterworth low-pass. Shapes (n,)."""
    sos = butter(order, cutoff_hz / (0.5 * RATE_HZ), output="sos")
    return np.asarray(sosfiltfilt(sos, value))


def band_pass(value: Array, low_hz: float, high_hz: float, order: int = 2) -> Array:
    """Zero-phase Butterworth band-pass. Shapes (n,)."""
    nyquist = 0.5 * RATE_HZ
    sos = butter(order, [low_hz / nyquist, high_hz / nyquist], btype="band", output="sos")
    return np.asarray(sosfiltfilt(sos, value))


def white_noise(value: Array) -> float:
    """Standard deviation of one sample of white noise as strong as the noise from 3 to 4.8 Hz.

    That band lies above the motion and its harmonics and below the ripple of the wheels; sensors
    are filtered, so what lies higher says little about the noise where it matters. The median
    keeps short steering impulses out. Wheel sensors are the other way round: 3 to 4.8 Hz is a
    valley between road and wheel hop, so a share of what lies above 8 Hz is the least.
    """
    above = value - low_pass(value, 8.0)
    high_noise = float(np.sqrt(np.mean(above**2) / (1.0 - 8.0 / (0.5 * RATE_HZ))))
    low, high = NOISE_BAND_HZ
    rest = band_pass(value, low, high, order=3)
    share = (high - low) / (0.5 * RATE_HZ)
    low_noise = float(1.4826 * np.median(np.abs(rest)) / np.sqrt(share))
    return max(low_noise, HIGH_SHARE * high_noise) + 1e-12


def block_mean(value: Array) -> Array:
    """Means of `BLOCK` samples. Shape (n,) to (n // BLOCK,) or (n, k) to (n // BLOCK, k)."""
    n = value.shape[0] // BLOCK
    return np.asarray(value[: n * BLOCK].reshape(n, BLOCK, *value.shape[1:]).mean(axis=1))


def per_sample(value: Array) -> Array:
    """Central differences along the first axis. Shape (n,) or (n, k), n of 2 or more.

    What `numpy.gradient` gives, in a fifth of its time: every simulation needs two.
    """
    found = np.empty_like(value)
    np.subtract(value[2:], value[:-2], out=found[1:-1])
    found[1:-1] *= 0.5
    found[0] = value[1] - value[0]
    found[-1] = value[-1] - value[-2]
    return found


def on_grid(
    channels: Mapping[str, tuple[Array, Array]],
) -> tuple[Array, dict[str, Array]]:
    """Interpolate asynchronous channels (time, value) to one grid at `RATE_HZ`."""
    start = max(time[0] for time, _ in channels.values())
    stop = min(time[-1] for time, _ in channels.values())
    first = min(time[0] for time, _ in channels.values())
    grid = start + np.arange(int((stop - start) * RATE_HZ)) / RATE_HZ
    values = {name: np.interp(grid, time, value) for name, (time, value) in channels.items()}
    return grid - first, values
