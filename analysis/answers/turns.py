"""Engines that take turns on one question: it is not known in advance which is fastest.

Each engine works in its own thread, one at a time. When it has used its share of processor time and next
reports progress, it passes the turn on, and later continues from that point. So a question costs at most the
time of the fastest engine times the number of engines. Timing decides which engine answers, but not the
answer.

References
----------
B. A. Huberman, R. M. Lukose, T. Hogg, *An economics approach to hard computational problems*, Science 275,
1997 (portfolios).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from dineros.analysis.answers.budget import Budget, BudgetExceededError, Progress

Answer = TypeVar("Answer")

SHARE = 0.5
"""Seconds of processor time per turn."""

HEAD_START = 2.0
"""Seconds for the engine that is usually best, before the others begin."""


@dataclass(frozen=True)
class Member(Generic[Answer]):
    """An engine that may answer."""

    work: Callable[[Budget], Answer | None]
    """The work. It gets a budget, must report progress by `Budget.report`, and returns an answer or None."""
    head_start: float = 0.0
    """Seconds of processor time for its first turn; easy questions, answered within it, cost no more."""
    marking_bytes: int = 0
    """Bytes that it needs at least for each marking that exists; 0 if it does not store all of them."""


def first_answer(
    members: Sequence[Member[Answer]],
    budget: Budget,
    is_final: Callable[[Answer], bool] = lambda answer: True,
) -> Answer | None:
    """Return the first final answer of some engines; if there is none, the first other answer, or None.

    Parameters
    ----------
    members : sequence of Member
        The first one begins, and works in this thread: an interrupt of it interrupts all.
    budget : Budget
        Its time is shared by all engines, its memory is divided.
    is_final : callable
        Returns whether an answer ends the work of the others.
    """
    if len(members) == 1:
        return members[0].work(budget.begun())
    table = _Table(members, budget.begun(), is_final)
    return table.run()


class _Table(Generic[Answer]):
    """The engine whose turn it is, and the answers so far."""

    def __init__(
        self, members: Sequence[Member[Answer]], budget: Budget, is_final: Callable[[Answer], bool]
    ) -> None:
        self._members, self._budget, self._is_final = members, budget, is_final
        self._changed = threading.Condition()
        self._here = list(range(len(members)))  #: engines that still work
        self._answers: list[Answer] = []
        self._final: list[Answer] = []
        self._error: BaseException | None = None
        self._is_over = False
        self._turn = 0
        self._until = time.process_time() + max(SHARE, members[0].head_start)

    def run(self) -> Answer | None:
        others = [
            threading.Thread(target=self._in_thread, args=(number,), daemon=True)
            for number in range(1, len(self._members))
        ]
        for thread in others:
            thread.start()
        try:
            self._work(0)
            self._wait_for_all()
        finally:
            self._end()
            for thread in others:
                thread.join()
        if self._error is not None:
            raise self._error
        return next(iter([*self._final, *self._answers]), None)

    def _in_thread(self, number: int) -> None:
        try:
            self._wait(number)
            self._work(number)
        except BudgetExceededError:
            pass  # another engine has answered before this one began
        except BaseException as error:
            self._error = self._error or error
            self._end()

    def _work(self, number: int) -> None:
        """Let an engine work to its end, and remove it."""
        answer = None
        try:
            answer = self._members[number].work(self._share_of(number))
        except BudgetExceededError:
            pass
        finally:
            with self._changed:
                if answer is not None and not self._is_over:
                    (self._final if self._is_final(answer) else self._answers).append(answer)
                    self._is_over = bool(self._final)
                self._pass_on(number)
                self._here.remove(number)
                self._changed.notify_all()

    def _share_of(self, number: int) -> Budget:
        told = self._budget.progress

        def tell(progress: Progress) -> None:
            if told is not None:
                told(progress)
            self._report(number)

        return replace(self._budget.share(memory=1 / len(self._members)), progress=tell)

    def _report(self, number: int) -> None:
        """If the share is used up, pass the turn on and wait for the next one."""
        if time.process_time() > self._until or self._is_over:
            with self._changed:
                self._pass_on(number)
            self._wait(number)

    def _pass_on(self, number: int) -> None:
        position = self._here.index(number)
        self._turn = self._here[(position + 1) % len(self._here)]
        self._until = time.process_time() + SHARE
        self._changed.notify_all()

    def _wait(self, number: int) -> None:
        with self._changed:
            while self._turn != number and not self._is_over:
                self._changed.wait()
        if self._is_over:
            raise BudgetExceededError("another engine has answered")

    def _wait_for_all(self) -> None:
        with self._changed:
            while self._here and not self._is_over:
                self._changed.wait()

    def _end(self) -> None:
        with self._changed:
            self._is_over = True
            self._changed.notify_all()
