"""Roll of a body as a lag behind its lateral acceleration, and as the wheel loads show it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from swaywatch.effects.runs import RATE_HZ, Run

Array = NDArray[np.float64]

#: Undamped frequencies, rad/s, and damping ratios among which the wheel loads choose.
FREQUENCIES = (7.0, 9.0, 11.0, 13.0, 16.0, 20.0, 26.0, 35.0, 50.0, 75.0)
DAMPINGS = (0.06, 0.112, 0.2, 0.35, 0.6, 1.0)
_LOADS = tuple(f"wheel_vertical_load_{w}" for w in ("fl", "fr", "rl", "rr"))
_FORCES = tuple(f"wheel_lateral_force_{w}" for w in ("fl", "fr", "rl", "rr"))


def lag(value: Array, frequency: float, damping: float) -> Array:
    """A second-order low-pass, as roll follows the lateral acceleration. Shapes (n,)."""
    # Tustin's rule written out: it is called thousands of times
    k, square = 2.0 * RATE_HZ, frequency**2
    first = k**2 + 2.0 * damping * frequency * k + square
    b = np.array([1.0, 2.0, 1.0]) * (square / first)
    last = k**2 - 2.0 * damping * frequency * k + square
    a = np.array([1.0, 2.0 * (square - k**2) / first, last / first])
    return np.asarray(lfilter(b, a, value))


def seen(runs: Sequence[Run]) -> tuple[float, float] | None:
    """Frequency, rad/s, and damping ratio with which the car's wheel loads follow its forces.

    The load that rolls over to the other side lags the sum of lateral forces as the body's roll
    does, so that no accelerometer is needed. None where loads or forces were not recorded.
    """
    names = (*_LOADS, *_FORCES, "hitch_lateral_force")
    found: tuple[float, tuple[float, float]] | None = None
    if not all(name in run.channels for run in runs for name in names):
        return None
    for frequency in FREQUENCIES:
        for damping in DAMPINGS:
            left = 0.0
            for run in runs:
                c = run.channels
                force = sum((c[name] for name in _FORCES), c["hitch_lateral_force"])
                shift = c[_LOADS[1]] - c[_LOADS[0]] + c[_LOADS[3]] - c[_LOADS[2]]
                follows = lag(force - force.mean(), frequency, damping)
                shift = shift - shift.mean()
                left -= float(np.dot(follows, shift)) ** 2 / float(np.dot(follows, follows))
            if found is None or left < found[0]:
                found = (left, (frequency, damping))
    return None if found is None else found[1]
