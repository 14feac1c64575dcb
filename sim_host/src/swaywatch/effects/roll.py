"""Roll of a body whose springs or dampers differ from those of the user's simulation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bilinear, lfilter

from swaywatch.effects.effect import Parameter, Values
from swaywatch.effects.runs import RATE_HZ, Run

Array = NDArray[np.float64]

#: Roll is not recorded: its frequency and damping, and how far it carries the wheels sideways
#: under the roll centre, are fitted with the change.
ROLL_PARAMETERS = (
    Parameter("sideways_m_per_n", "m/N", 0.0, -1e-4, 1e-4, (0.0,), 1e-6, 1e9),
    Parameter("roll_frequency_rad_s", "rad/s", 11.0, 6.0, 20.0, (11.0,), 0.2, 1e9),
    Parameter("roll_damping", "-", 0.25, 0.05, 0.8, (0.25,), 0.02, 1e9),
)


def changes(
    shift: Array, values: Values, *, stiffness: float = 1.0, damping: float = 1.0
) -> tuple[Array, Array]:
    """Change of the load transfer and of the roll (in newtons of static transfer). Shapes (n,).

    With s^2 + 2 z w s + w^2 = 0 the body's roll, its transfer is that of spring and damper,
    (2 z w s + w^2) roll; the moment that rolls the body is the same before and after.

    Parameters
    ----------
    shift
        Load transfer of the body in the simulation, N, shape (n,).
    values
        With `ROLL_PARAMETERS`.
    stiffness, damping
        Factors on those of the simulation.
    """
    w, z = values["roll_frequency_rad_s"], values["roll_damping"]
    old = np.array([1.0, 2.0 * z * w, w * w])
    new = np.array([1.0, damping * 2.0 * z * w, stiffness * w * w])
    below = np.polymul(new, old[1:])
    transfer = lfilter(*bilinear(np.polymul(new[1:], old), below, RATE_HZ), shift) - shift
    rolled = lfilter(*bilinear(w * w * old, below, RATE_HZ), shift)
    before = lfilter(*bilinear([w * w], old[1:], RATE_HZ), shift)
    return np.asarray(transfer), np.asarray(rolled - before)


def carried(roll: Array, speed: Array, values: Values) -> Array:
    """Slip of the wheels that a change of roll carries sideways, rad, shape (n,)."""
    return np.asarray(values["sideways_m_per_n"] * np.gradient(roll) * RATE_HZ / speed)


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
