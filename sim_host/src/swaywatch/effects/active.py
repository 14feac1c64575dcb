"""A term of a fit: an effect with values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from swaywatch.effects.effect import Effect, Parameter, Window
from swaywatch.effects.runs import Run

_START = Parameter("start", "s", 0.0, -1e9, 1e9, (0.0,), 0.1)
_STOP = Parameter("stop", "s", 0.0, -1e9, 1e9, (0.0,), 0.1)
#: Room before and behind a recording for the edges of a window, s: what rises gradually may have
#: begun before it. A sharp edge outside it says nothing, so that a fit could never bring it back.
ROOM_S = 2.0
SHARP = ("box", "box_motion", "generator")


@dataclass(frozen=True)
class ActiveEffect:
    """An effect with its values.

    Attributes
    ----------
    effect
        The explanation.
    values
        Without windows: in the order of the effect's parameters. With windows: start, stop and
        the parameters of each window in turn.
    window_runs
        With windows: the run of each.
    """

    effect: Effect
    values: tuple[float, ...]
    window_runs: tuple[int, ...] = ()

    def as_dict(self) -> dict[str, float]:
        """Values by parameter name, without windows."""
        if self.effect.windowed:
            return {}
        return dict(zip((p.name for p in self.effect.parameters), self.values, strict=True))

    def parameter(self, index: int) -> Parameter:
        """Parameter of a place in `values`."""
        if not self.effect.windowed:
            return self.effect.parameters[index]
        return (_START, _STOP, *self.effect.parameters)[index % self.stride]

    def is_edge(self, index: int) -> bool:
        """Whether a place in `values` is where a window begins or ends."""
        return self.effect.windowed and index % self.stride < 2

    def bounded(self, index: int, runs: Sequence[Run]) -> Parameter:
        """Parameter of a place in `values`, the edges of a window near the recording of its run."""
        parameter, run = self.parameter(index), self.run_of(index)
        if run is None or not self.is_edge(index):
            return parameter
        time = runs[run].time
        room = 0.0 if self.effect.extra.get("form", "box") in SHARP else ROOM_S
        return replace(parameter, low=float(time[0]) - room, high=float(time[-1]) + room)

    @property
    def stride(self) -> int:
        """Values of one window."""
        return 2 + len(self.effect.parameters)

    def run_of(self, index: int) -> int | None:
        """Run that a place in `values` acts on; None: all."""
        return self.window_runs[index // self.stride] if self.effect.windowed else None

    def windows(self, run: int) -> list[Window]:
        """Windows in one run."""
        if not self.effect.windowed:
            return []
        names = [p.name for p in self.effect.parameters]
        found = []
        for w, where in enumerate(self.window_runs):
            if where == run:
                v = self.values[w * self.stride : (w + 1) * self.stride]
                found.append(Window(v[0], v[1], dict(zip(names, v[2:], strict=True))))
        return found

    def outside(self, run: int) -> ActiveEffect:
        """Without its windows in one run."""
        return self.only([w for w, where in enumerate(self.window_runs) if where != run])

    def without_remainders(self, share: float, gap_s: float) -> ActiveEffect:
        """Without windows that only correct the shape of a larger one beside or around them.

        Parameters
        ----------
        share
            Size, over that of the larger one, below which a window is such a correction.
        gap_s
            Distance from which on it is a window of its own.
        """
        k = self.stride
        rows = [self.values[w * k : (w + 1) * k] for w in range(len(self.window_runs))]
        neutral = [p.neutral for p in self.effect.parameters]
        sizes = [math.dist(row[2:], neutral) for row in rows]

        def corrects(w: int, other: int) -> bool:
            apart = max(rows[w][0] - rows[other][1], rows[other][0] - rows[w][1])
            same = self.window_runs[w] == self.window_runs[other]
            return same and sizes[w] < share * sizes[other] and apart < gap_s

        every = range(len(rows))
        return self.only([w for w in every if not any(corrects(w, other) for other in every)])

    def only(self, kept: Sequence[int]) -> ActiveEffect:
        """With these windows."""
        if not self.effect.windowed or len(kept) == len(self.window_runs):
            return self
        k = self.stride
        values = tuple(value for w in kept for value in self.values[w * k : (w + 1) * k])
        return ActiveEffect(self.effect, values, tuple(self.window_runs[w] for w in kept))
