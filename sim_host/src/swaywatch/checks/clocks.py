"""The logger's clock, from the messages alone: its rate, and steps in it.

Control units send in cycles of round numbers of milliseconds by quartzes that are right to some
hundredths of a percent: where all messages of a recording keep one strange cycle, the clock that
gave the stamps is wrong, not they.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from swaywatch.checks.samples import Finding, listed
from swaywatch.drive import Channel, Drive

FloatArray = npt.NDArray[np.float64]

CYCLES_S = np.array([1, 2, 4, 5, 8, 10, 16, 20, 25, 40, 50, 80, 100, 200, 250, 500, 1000]) * 1e-3
"""Cycles that messages are sent in."""
LEAST_OFF = 0.004
"""A clock so far off is reported: a quartz is right to a twentieth of it."""
MOST_OFF = 0.04
"""Beyond it another cycle may be meant."""
ALIKE = 0.0005
"""Cycles that are off by the same, within so much, are off by the clock."""
FEWEST = 3
"""Messages that must agree."""
STEP = 2.5
"""Stamps step where each message leaves out so many of its cycles at once,"""
TOGETHER_S = 0.1
"""within so much."""
MOST_STEPS = 20


def check_rate(drive: Drive) -> list[Finding]:
    """A clock that runs fast or slow against all senders."""
    off = []
    for channel in _messages(drive):
        cycle = float(np.median(np.diff(channel.time_s)))
        mean = _steady(channel, cycle)
        nominal = float(CYCLES_S[np.argmin(np.abs(np.log(CYCLES_S / cycle)))])
        off.append(mean / nominal - 1.0)
    if len(off) < FEWEST:
        return []
    middle = float(np.median(off))
    if not LEAST_OFF < abs(middle) < MOST_OFF or max(abs(np.array(off) - middle)) > ALIKE:
        return []
    word = "fast" if middle > 0.0 else "slow"
    return [
        Finding(
            "warning",
            "clock",
            (),
            f"the logger's clock runs {100 * abs(middle):.1f} % {word}: the cycle times of "
            f"all {len(off)} messages deviate by this amount, and so do frequencies, decay rates "
            f"and rates of change ({', '.join(path.name for path in drive.files)})",
        )
    ]


def check_steps(drive: Drive) -> list[Finding]:
    """Moments at which all messages are late together: a step of the clock, or frames lost."""
    messages = _messages(drive)
    if len(messages) < FEWEST:
        return []
    starts = [_late(channel) for channel in messages]
    common = [
        (a, b)
        for a, b in starts[0]
        if all(any(abs(c - a) < TOGETHER_S for c, _ in other) for other in starts[1:])
    ]
    if not common or len(common) > MOST_STEPS:
        return []
    longest = max(b - a for a, b in common)
    return [
        Finding(
            "warning",
            "clock",
            tuple(channel.signal for channel in messages),
            f"all messages are silent together ({listed(common)}), at most {longest * 1e3:.0f} ms: "
            "the logger's clock was set, or it lost frames; windows across it are unreliable",
            common[0][0],
            (),
            tuple(common),
        )
    ]


def _messages(drive: Drive) -> list[Channel]:
    """One channel of each message, with samples enough to tell its cycle."""
    found: list[Channel] = []
    for channel in drive.channels.values():
        known = any(np.array_equal(channel.time_s, other.time_s) for other in found)
        if not known and len(channel.time_s) >= 200:
            found.append(channel)
    return found


def _steady(channel: Channel, cycle: float) -> float:
    """Mean cycle without the stretches in which samples are missing."""
    step = np.diff(channel.time_s)
    usual = step[(step > 0.5 * cycle) & (step < 1.5 * cycle)]
    return float(np.mean(usual)) if len(usual) else cycle


def _late(channel: Channel) -> list[tuple[float, float]]:
    """Where a message leaves out some cycles, but fewer than make a gap."""
    step = np.diff(channel.time_s)
    cycle = float(np.median(step))
    at = np.flatnonzero((step > STEP * cycle) & (step < max(TOGETHER_S, 3.0 * cycle)))
    return [(float(channel.time_s[i]), float(channel.time_s[i + 1])) for i in at[:1000]]
