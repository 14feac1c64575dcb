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
    done: bool = False


class SideBySide(Generic[Request, Answer]):
    """Answers requests; those of calculations under `map` as soon as all of them wait.

    An answer must not depend on the requests beside it: then the results do not depend on how
    the threads run.
    """

    def __init__(self, answer: Callable[[Sequence[Request]], list[Answer]]) -> None:
        self._answer = answer
        self._changed = threading.Condition()
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
        with self._changed:
            self._running += 1
        try:
            return calculate(item)
        finally:
            with self._changed:
                self._running -= 1
                self._changed.notify_all()

    def ask(self, requests: Sequence[Request]) -> list[Answer]:
        """Answers in the order of the requests."""
        if not getattr(self._own, "inside", False):
            return self._answer(requests)
        own: _Asked[Request, Answer] = _Asked(requests)
        with self._changed:
            self._waiting.append(own)
            self._changed.notify_all()
            self._changed.wait_for(lambda: own.done or self._leads(own))
            together = [] if own.done else self._waiting
            if together:
                self._waiting = []
        if together:
            self._serve(together)
        if own.error is not None:
            raise own.error
        return own.answers

    def _leads(self, own: _Asked[Request, Answer]) -> bool:
        """The first of those that wait answers, once nobody is left who does not."""
        waiting = self._waiting
        return bool(waiting) and waiting[0] is own and len(waiting) == self._running

    def _serve(self, together: list[_Asked[Request, Answer]]) -> None:
        error: BaseException | None = None
        answers: list[Answer] = []
        try:
            answers = self._answer([r for asked in together for r in asked.requests])
        except BaseException as problem:  # every thread must hear of it
            error = problem
        with self._changed:
            at = 0
            for asked in together:
                asked.answers = answers[at : at + len(asked.requests)]
                at += len(asked.requests)
                asked.error, asked.done = error, True
            self._changed.notify_all()
