"""A progress bar with the time left, for what takes longer than a second."""

from __future__ import annotations

import sys
import threading
import time
from types import TracebackType

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from swaywatch.terminal import output


class LateProgress:
    """Shows itself after a second, on a terminal only; with ``-v`` a line for each step.

    Parameters
    ----------
    console
        Where to draw; by default standard error, which keeps the output clean.
    """

    def __init__(self, console: Console | None = None) -> None:
        console = console or Console(stderr=True)
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f} %"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._tasks: dict[str, TaskID] = {}
        self._stage = ""
        self._start = time.monotonic()
        self._timer = threading.Timer(1.0, self._progress.start)
        self._timer.daemon = True

    def __enter__(self) -> LateProgress:
        self._timer.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._timer.cancel()
        self._timer.join()
        self._progress.stop()
        self._say("done" if error is None else "stopped")

    def tell(self, what: str, done: float, total: float) -> None:
        """`done` of `total` of what is going on."""
        if what not in self._tasks:
            self._tasks[what] = self._progress.add_task(what, total=total)
            self._say(what)
        self._progress.update(self._tasks[what], completed=done, total=total)

    def stage(self, what: str, share: float) -> None:
        """One task in stages: which stage, and the share of all that is done."""
        if "all" not in self._tasks:
            self._tasks["all"] = self._progress.add_task(what, total=1.0)
        if what != self._stage:
            self._stage = what
            self._say(what)
        self._progress.update(self._tasks["all"], description=what, completed=share)

    def _say(self, what: str) -> None:
        if output.verbose:
            print(f"{time.monotonic() - self._start:7.1f} s  {what}", file=sys.stderr, flush=True)
