"""What an ECU says of the trailer that it remembers, in words: the message SwayTrailer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from swaywatch.ecu._core import lib
from swaywatch.ecu.bus import database
from swaywatch.recording import Frames

MESSAGE = "SwayTrailer"


@dataclass(frozen=True)
class Remembered:
    """One message SwayTrailer.

    Attributes
    ----------
    state
        ``unknown``, ``no trailer``, ``new``, ``same`` or ``another``.
    likeness
        Natural logarithm of how many times more probable the drive is with the remembered trailer
        than with one that nobody knows.
    learnt_s
        Driving that the attached trailer was learnt from.
    """

    state: str
    likeness: float
    learnt_s: int

    @property
    def sentence(self) -> str:
        """The state in plain words, with its likelihood."""
        odds = f"{_times(abs(self.likeness))} times"
        more = "more" if self.likeness >= 0.0 else "less"
        compared = f"this drive is {odds} {more} probable with it than with an unknown one"
        words = {
            "no trailer": "no trailer is attached",
            "new": "a trailer is attached; none is remembered to compare it with",
            "same": f"the trailer is the one of earlier drives ({compared})",
            "another": f"this is another trailer than in earlier drives ({compared})",
        }
        if self.state not in words:
            return (
                "The ECU cannot decide yet whether a trailer is attached, or whether it is the one "
                "of earlier drives."
            )
        return f"According to the ECU, {words[self.state]}, after {self.learnt_s} s of driving."


def _times(logarithm: float) -> str:
    if logarithm > math.log(1e6):
        return "over a million"
    factor = math.exp(logarithm)
    if factor < 10.0:
        return f"{factor:.1f}"
    return f"{round(factor, 1 - math.floor(math.log10(factor))):,.0f}"


def heard(identifier: int, extended: bool, data: bytes) -> Remembered | None:
    """The message in a frame; None where it is another one, or damaged."""
    message = database().messages[MESSAGE]
    if extended or identifier != message.frame_id or len(data) != message.length:
        return None
    if not lib.sway_e2e_check(identifier, data):
        return None
    values = message.decode(data)
    return Remembered(
        str(values["TrailerState"]), float(values["TrailerLikeness"]), int(values["TrailerLearnt"])
    )


def last_of(frames: Frames) -> Remembered | None:
    """The last whole one of a recording; None where there is none."""
    own = (frames.identifier == database().messages[MESSAGE].frame_id) & ~frames.extended
    for row in np.flatnonzero(own)[::-1]:
        data = bytes(frames.data[row, : frames.length[row]])
        found = heard(int(frames.identifier[row]), False, data)
        if found is not None:
            return found
    return None
