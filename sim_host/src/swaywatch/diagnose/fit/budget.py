"""How much a diagnosis may simulate before it says what it has found so far.

Counted in simulated seconds, not in seconds of the clock: the same files give the same verdict on
a fast and on a busy machine. What was left untried is named.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, field

#: Simulated seconds of one diagnosis: six to eight minutes of processor time (13,000 to 17,000 of
#: them took a second).
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
    untried
        What was left out for it, in words, in this order.
    """

    most_s: float = MOST_S
    spent_s: float = 0.0
    untried: list[str] = field(default_factory=list)
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False, compare=False)

    def spend(self, simulated_s: float) -> None:
        """Count simulations."""
        with self._lock:
            self.spent_s += simulated_s

    def refuses(self, what: str, share: float = 1.0) -> bool:
        """Tell whether `what` is left untried because this share of the budget is spent.

        To be asked only where no calculations run side by side: then the answer does not depend on
        how threads run.
        """
        if self.spent_s < share * self.most_s:
            return False
        if what not in self.untried:
            self.untried.append(what)
        return True

    def sentences(self) -> list[str]:
        """What was left untried, for the checks of a diagnosis; empty if nothing was."""
        if not self.untried:
            return []
        return [
            f"the search was ended after {self.spent_s / 1e6:.1f} million simulated seconds; "
            f"not tried: {', '.join(self.untried)}"
        ]
