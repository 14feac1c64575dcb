"""How much a diagnosis may simulate before it says what it has found so far.

Counted in simulated seconds, not in seconds of the clock: the same files give the same verdict on
a fast and on a busy machine. What was left untried is named.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

#: Simulated seconds of one diagnosis: three to seven minutes (15,000 to 38,000 of them took a
#: second on two cores, another diagnosis beside it).
MOST_S = 6e6


@dataclass
class Budget:
    """Simulated seconds spent by all fits of a diagnosis.

    Attributes
    ----------
    most_s
        Simulated seconds after which nothing further is begun.
    spent_s
        Simulated seconds so far.
    begun_by_laws_s
        What was spent when laws were begun; None while none are.
    earlier_laws_s
        Of `spent_s`, what laws have spent that were tried before.
    untried
        What was left out for it, in words, in this order.
    steps_s
        Simulated seconds of the longest step of each kind so far: the next one is expected to take
        as long.
    """

    most_s: float = MOST_S
    spent_s: float = 0.0
    begun_by_laws_s: float | None = None
    earlier_laws_s: float = 0.0
    untried: list[str] = field(default_factory=list)
    steps_s: dict[str, float] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False, compare=False)

    def spend(self, simulated_s: float) -> None:
        """Count simulations."""
        with self._lock:
            self.spent_s += simulated_s

    @property
    def by_laws_s(self) -> float:
        """Simulated seconds that laws have spent."""
        now = 0.0 if self.begun_by_laws_s is None else self.spent_s - self.begun_by_laws_s
        return self.earlier_laws_s + now

    @property
    def by_library_s(self) -> float:
        """Simulated seconds that all else has spent."""
        return self.spent_s - self.by_laws_s

    @contextmanager
    def laws(self) -> Iterator[None]:
        """What is spent within counts as spent by laws, once."""
        if self.begun_by_laws_s is not None:
            yield
            return
        self.begun_by_laws_s = self.spent_s
        try:
            yield
        finally:
            self.earlier_laws_s = self.by_laws_s
            self.begun_by_laws_s = None

    def has_room(self, what: str, share: float = 1.0, spent_s: float | None = None) -> bool:
        """Tell whether a step of this kind ends within a share of the budget, as far as known."""
        spent_s = self.spent_s if spent_s is None else spent_s
        return spent_s + self.steps_s.get(what, 0.0) < share * self.most_s

    def refuses(self, what: str, share: float = 1.0, spent_s: float | None = None) -> bool:
        """Tell whether `what` is left untried because this share of the budget is spent.

        Of `spent_s`, where not everything counts: laws and the library have shares of their own, or
        what laws take in the middle of a search would end it. It is, too, where a step of this kind
        does not end within it if it takes as long as before. To be asked only where no calculations
        run side by side: then the answer does not depend on how threads run.
        """
        if self.has_room(what, share, spent_s):
            return False
        if what not in self.untried:
            self.untried.append(what)
        return True

    @contextmanager
    def step(self, what: str) -> Iterator[None]:
        """Note what a step costs; to be used where none of its kind runs beside it."""
        before = self.spent_s
        yield
        self.steps_s[what] = max(self.steps_s.get(what, 0.0), self.spent_s - before)

    def sentences(self) -> list[str]:
        """What was left untried, for the checks of a diagnosis; empty if nothing was."""
        if not self.untried:
            return []
        return [
            f"the search was ended after {self.spent_s / 1e6:.1f} million simulated seconds; "
            f"not tried: {', '.join(self.untried)}"
        ]
