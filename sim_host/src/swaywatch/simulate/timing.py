"""When messages are sent and stamped: rate, phase, latency, jitter, loss.

Channels of one message share its times. Each message has its own phase in the cycle, so that no two
messages are synchronous, as on a real bus.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swaywatch.plant.layout import Array
from swaywatch.simulate.table import Table


@dataclass(frozen=True)
class Timing:
    """Timing of all messages.

    Attributes
    ----------
    rate_hz : of every message
    jitter_s : standard deviation of the time stamps, never before the sample
    latency_s : from sampling to the stamp
    lost : share of messages that never arrive
    clock_ppm : how much the logger's clock runs fast
    """

    rate_hz: float = 100.0
    jitter_s: float = 0.0002
    latency_s: float = 0.0005
    lost: float = 0.0
    clock_ppm: float = 0.0

    def times(self, duration_s: float, phase: float, random: np.random.Generator) -> list[Array]:
        """Sampling times and time stamps of one message; ``phase`` is a share of the cycle."""
        count = int(duration_s * self.rate_hz)
        sampled = (np.arange(count) + phase) / self.rate_hz
        sampled = sampled[sampled <= duration_s]
        late = self.latency_s + np.abs(random.normal(0.0, self.jitter_s, sampled.size))
        stamps = np.maximum.accumulate((sampled + late) * (1.0 + 1e-6 * self.clock_ppm))
        stamps += 1e-7 * np.arange(stamps.size) * 1e-3  # equal stamps become a growing pair
        kept = random.random(sampled.size) >= self.lost
        return [sampled[kept], stamps[kept]]


def read_timing(table: Table) -> Timing:
    """Timing from ``[timing]``."""
    base = Timing()
    timing = Timing(
        rate_hz=table.number("rate_hz", 1.0, 1000.0, "Hz", base.rate_hz),
        jitter_s=table.number("jitter_s", 0.0, 0.1, "s", base.jitter_s),
        latency_s=table.number("latency_s", 0.0, 0.5, "s", base.latency_s),
        lost=table.number("lost", 0.0, 0.9, "1", base.lost),
        clock_ppm=table.number("clock_ppm", -1e4, 1e4, "ppm", base.clock_ppm),
    )
    table.done()
    return timing
