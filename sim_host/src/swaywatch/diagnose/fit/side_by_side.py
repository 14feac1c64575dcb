"""Calculations in threads of their own whose requests are answered together, as one batch."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Generic, TypeVar

Item = TypeVar("Item")
Request = TypeVar("Request")
Answer = TypeVar("Answer")
Result = TypeVar("Result")


@dataclass(eq=False)
class _Asked(Generic[Request, Answer]):
    requests: Sequence[Request]
    answers: list[Answer] = field(default_factory=list)
    error: BaseException | None = None
    done: threading.Event = field(default_factory=threading.Event)


class SideBySide(Generic[Request, Answer]):
    """Answers requests; those of calculations under `map` as soon as all of them wait.

    An answer must not depend on the requests beside it: then the results do not depend on how
    the threads run.
    """

    def __init__(self, answer: Callable[[Sequence[Request]], list[Answer]]) -> None:
        self._answer = answer
        self._lock = threading.Lock()
        self._running = 0
        self._waiting: list[_Asked[Request, Answer]] = []
        self._own = threading.local()

    def map(
        self, calculate: Callable[[Item], Result], items: Iterable[Item], workers: int
    ) -> list[Result]:
        """`calculate` of every item, in their order; at most `workers` of them at a time."""
        items = list(items)
        if len(items) < 2 or getattr(self._own, "inside", False):
            return [calculate(item) for item in items]
        with ThreadPoolExecutor(min(workers, len(items))) as pool:
            return list(pool.map(lambda item: self._one(calculate, item), items))

    def _one(self, calculate: Callable[[Item], Result], item: Item) -> Result:
        self._own.inside = True
        with self._lock:
            self._running += 1
        try:
            return calculate(item)
        finally:
            with self._lock:
                self._running -= 1
                together = self._all_that_wait()
            self._serve(together)

    def ask(self, requests: Sequence[Request]) -> list[Answer]:
        """Answers in the order of the requests."""
        if not getattr(self._own, "inside", False):
            return self._answer(requests)
        own: _Asked[Request, Answer] = _Asked(requests)
        with self._lock:
            self._waiting.append(own)
            together = self._all_that_wait()
        self._serve(together)
        own.done.wait()
        if own.error is not None:
            raise own.error
        return own.answers

    def _all_that_wait(self) -> list[_Asked[Request, Answer]]:
        """Those that wait, to be served, if nobody is left who does not; under the lock.

        The last one that asks or ends serves: no thread is woken before its answers are there.
        """
        if len(self._waiting) < self._running:
            return []
        together, self._waiting = self._waiting, []
        return together

    def _serve(self, together: Sequence[_Asked[Request, Answer]]) -> None:
        if not together:
            return
        error: BaseException | None = None
        answers: list[Answer] = []
        try:
            answers = self._answer([r for asked in together for r in asked.requests])
        except BaseException as problem:  # every thread must hear of it
            error = problem
        at = 0
        for asked in together:
            asked.answers = answers[at : at + len(asked.requests)]
            at += len(asked.requests)
            asked.error = error
            asked.done.set()
