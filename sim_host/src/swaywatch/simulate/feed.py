"""Plays frames onto a bus in time: every frame at its own absolute deadline.

A late frame is sent at once and the next one keeps its deadline, so delays never add up. A full
transmit buffer is waited for; a frame that cannot be sent ends the feed with an error, never with
a silent loss.
"""

from __future__ import annotations

import errno
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from swaywatch.errors import RecordingError
from swaywatch.recording import Frames

SPIN_S = 0.0005
"""The last part of a wait is spent awake: sleeping overshoots by about as much."""


class Bus(Protocol):
    """What the feed needs of a python-can bus."""

    def send(self, msg: Any, timeout: float | None = None) -> None:
        """Send one message."""


@dataclass
class FeedResult:
    """What happened: frames sent, waits for a full buffer, lateness of each frame in s."""

    sent: int = 0
    waits: int = 0
    lateness_s: list[float] = field(default_factory=list, repr=False)

    def summary(self) -> str:
        """One line for the user."""
        if not self.lateness_s:
            return "nothing sent"
        late = 1e3 * np.array(self.lateness_s)
        median, most = np.median(late), np.percentile(late, 99.9)
        text = f"{self.sent} frames sent; late by {median:.3f} ms (median), {most:.3f} ms (99.9 %)"
        return text + (f"; {self.waits} waits for a full buffer" if self.waits else "")


def feed(
    frames: Frames,
    bus: Bus,
    *,
    speed: float = 1.0,
    retry_s: float = 1.0,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
    result: FeedResult | None = None,
) -> FeedResult:
    """Send frames in time.

    Parameters
    ----------
    frames : in order of time
    bus : a python-can bus, or anything with its ``send``
    speed : 2 plays twice as fast; 0 as fast as the bus takes it
    retry_s : how long a full buffer is waited for
    clock, sleep : for tests
    result : counted into, so that an interrupted feed still knows what it did

    Raises
    ------
    RecordingError
        A frame could not be sent.
    """
    import can

    result = result if result is not None else FeedResult()
    start = clock()
    first = int(frames.time_ns[0]) if len(frames) else 0
    for k in range(len(frames)):
        due = start
        if speed > 0.0:
            due = start + (int(frames.time_ns[k]) - first) * 1e-9 / speed
            wait_until(due, clock, sleep)
        message = can.Message(
            arbitration_id=int(frames.identifier[k]),
            is_extended_id=bool(frames.extended[k]),
            data=bytes(frames.data[k, : frames.length[k]]),
            is_fd=int(frames.length[k]) > 8,
        )
        send(message, bus, retry_s, clock, sleep, result)
        result.sent += 1
        result.lateness_s.append(max(clock() - due, 0.0) if speed > 0.0 else 0.0)
    return result


def wait_until(due: float, clock: Callable[[], float], sleep: Callable[[float], None]) -> None:
    """Until a time of the clock: asleep, and awake at the end."""
    left = due - clock()
    if left > SPIN_S:
        sleep(left - SPIN_S)
    while clock() < due:
        sleep(0.0)


def send(
    message: Any,
    bus: Bus,
    retry_s: float,
    clock: Callable[[], float],
    sleep: Callable[[float], None],
    result: FeedResult,
) -> None:
    """Send one message; a full buffer is waited for, up to ``retry_s``.

    Raises
    ------
    RecordingError
        It could not be sent.
    """
    import can

    give_up = clock() + retry_s
    while True:
        try:
            bus.send(message)
        except (can.CanError, OSError) as error:
            full = _errno(error) in (errno.ENOBUFS, errno.EAGAIN)
            if not full or clock() > give_up:
                raise RecordingError(
                    f"frame {result.sent + 1} (0x{message.arbitration_id:X}) could not be sent: "
                    f"{error}"
                ) from None
        else:
            return
        result.waits += 1
        sleep(0.0005)


def _errno(error: BaseException) -> int | None:
    code = getattr(error, "error_code", None) or getattr(error, "errno", None)
    return int(code) if code is not None else None
