"""Engines side by side: where there are two cores, the others work in a process of their own.

What is answered at once never gets that far: the first engine works alone until its first turn is over. Then
the process is forked, and the others take turns there. Which side knows first ends the other one; with it
goes all that it has made, so only answers come back. Time decides who answers, never what the answer is.
"""

from __future__ import annotations

import os
import threading
import time
import warnings
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Generic

from dineros.analysis.answers import turns
from dineros.analysis.answers.apart import PATIENCE, Apart, ApartDiedError
from dineros.analysis.answers.budget import Budget, BudgetExceededError, Progress
from dineros.analysis.answers.turns import Answer, Member, first_answer

LEAST_MEMORY = 256 << 20
"""Bytes for engines below which there is one process: the other one needs some for itself."""


def first_of_two(
    members: Sequence[Member[Answer]],
    budget: Budget,
    is_final: Callable[[Answer], bool] = lambda answer: True,
    alone: float | None = None,
) -> Answer | None:
    """Return the first final answer of some engines; without one the first other answer, or None.

    The first engine works alone for so many seconds of the processor (`alone`; a turn unless given), before
    the process is forked. Other parameters are those of `first_answer`, which is asked where there is one
    core, little memory, or where this is not a main thread, from which alone a process may be forked. Answers
    go through `pickle`.
    """
    first, *others = members
    is_alone = len(os.sched_getaffinity(0)) < 2 or budget.memory < LEAST_MEMORY
    if not others or is_alone or threading.current_thread() is not threading.main_thread():
        return first_answer(members, budget, is_final)
    with ExitStack() as stack:
        share = turns.SHARE if alone is None else alone
        return _Pair(first, others, budget.begun(), is_final, share, stack).run()


LOOK_SECONDS = 0.02
"""Between two looks at whether those beside know."""


class _Pair(Generic[Answer]):
    """The first engine here, the others next to it once they have begun."""

    def __init__(
        self,
        first: Member[Answer],
        others: Sequence[Member[Answer]],
        budget: Budget,
        is_final: Callable[[Answer], bool],
        alone: float,
        stack: ExitStack,
    ) -> None:
        self._first, self._others, self._budget, self._is_final = first, others, budget, is_final
        self._stack = stack
        self._part = 1 / (1 + len(others))
        self._until = time.process_time() + alone
        self._beside: Apart | None = None
        self._looked = 0.0
        self._is_over = False
        self._theirs: Answer | None = None

    def run(self) -> Answer | None:
        mine = None
        try:
            share = self._budget.share(memory=self._part)
            mine = self._first.work(replace(share, progress=self._tell, stages=self._enter))
        except BudgetExceededError:
            if self._beside is None and self._budget.is_over:
                raise
        if mine is not None and self._is_final(mine):
            return mine
        if self._beside is None:
            theirs = first_of_two(self._others, self._budget, self._is_final)
        else:
            self._wait()
            theirs = self._theirs
        if mine is None or (theirs is not None and self._is_final(theirs)):
            return theirs
        return mine

    def _tell(self, progress: Progress) -> None:
        """Say how far the first engine is, and look for what those next to it know."""
        if self._budget.progress is not None:
            self._budget.progress(progress)
        self._look_beside()

    def _enter(self, stage: str) -> None:
        """Say where the first engine is, and look as well: some stages have no more to say."""
        self._budget.stage(stage)
        self._look_beside()

    def _look_beside(self) -> None:
        """Let the others begin when it is time, and end the first engine when they know."""
        if self._beside is None and time.process_time() >= self._until:
            with warnings.catch_warnings():
                # Of threads, only those of the first engine are there, and none of theirs is needed beside.
                warnings.simplefilter("ignore", DeprecationWarning)
                self._beside = self._stack.enter_context(Apart(lambda _: self._work_beside()))
        if (now := time.monotonic()) - self._looked < LOOK_SECONDS:
            return
        self._looked = now
        self._look(0.0)
        if self._is_over and self._theirs is not None and self._is_final(self._theirs):
            raise BudgetExceededError("another engine has answered")

    def _work_beside(self) -> Answer | None:
        budget = replace(self._budget.share(memory=1 - self._part), progress=None, stages=None)
        try:
            return first_answer(self._others, budget, self._is_final)
        except BudgetExceededError:
            return None

    def _look(self, seconds: float) -> None:
        """Take what those beside say; they have nothing to say where their process was ended."""
        if self._beside is None or self._is_over:
            return
        for _ in self._beside.messages(seconds):
            pass
        if self._beside.is_over:
            self._is_over = True
            try:
                self._theirs = self._beside.value()
            except ApartDiedError:
                return

    def _wait(self) -> None:
        while not self._is_over and not self._budget.is_over:
            self._look(PATIENCE)
