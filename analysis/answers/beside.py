"""Engines side by side: with two cores, all engines but the first run in a child process.

The first engine works alone until its first turn is over, so that easy questions need no second process. Then
the process is forked, and the other engines take turns in it; they leave one core to the first engine. The
first answer on either side ends the other side, with all its data; only answers are transferred. Timing
decides which engine answers, but not the answer.

The child process also ends when the first engine knows of more markings than the others can store: they
cannot answer, and only slow it down.
"""

from __future__ import annotations

import math
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
"""Bytes for engines below which there is only one process: the second one needs memory for itself."""


def first_of_two(
    members: Sequence[Member[Answer]],
    budget: Budget,
    is_final: Callable[[Answer], bool] = lambda answer: True,
    alone: float | None = None,
) -> Answer | None:
    """Return the first final answer of some engines; if there is none, the first other answer, or None.

    The first engine works alone for `alone` seconds of processor time, by default one turn, before the
    process is forked. The other parameters are those of `first_answer`, which is used instead with one core,
    with little memory, or outside of the main thread, since only the main thread may fork. Answers are
    pickled.
    """
    first, *others = members
    is_alone = budget.workers < 2 or budget.memory < LEAST_MEMORY
    if not others or is_alone or threading.current_thread() is not threading.main_thread():
        return first_answer(members, budget, is_final)
    with ExitStack() as stack:
        share = turns.SHARE if alone is None else alone
        return _Pair(first, others, budget.begun(), is_final, share, stack).run()


LOOK_SECONDS = 0.02
"""Seconds between checks whether the other process has an answer."""


class _Pair(Generic[Answer]):
    """The first engine in this process, and the others in a child process once they have begun."""

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
        least = min(member.marking_bytes for member in others)
        self._most_markings = budget.memory / least if least else math.inf
        self._is_hopeless = False
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
        if self._is_hopeless or (mine is not None and self._is_final(mine)):
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
        """Report the progress of the first engine, and check for an answer of the others."""
        if self._budget.progress is not None:
            self._budget.progress(progress)
        if progress.at_least > self._most_markings:
            self._is_hopeless = True
            if self._beside is not None:
                self._beside.end()
        self._look_beside()

    def _enter(self, stage: str) -> None:
        """Report a new stage of the first engine, and check as well: some stages report nothing else."""
        self._budget.stage(stage)
        self._look_beside()

    def _look_beside(self) -> None:
        """Start the others when it is time, and end the first engine when they have an answer."""
        if self._beside is None and not self._is_hopeless and time.process_time() >= self._until:
            with warnings.catch_warnings():
                # Only threads of the first engine exist here, and the child process does not need them.
                warnings.simplefilter("ignore", DeprecationWarning)
                self._beside = self._stack.enter_context(Apart(lambda _: self._work_beside()))
        if (now := time.monotonic()) - self._looked < LOOK_SECONDS:
            return
        self._looked = now
        self._look(0.0)
        if self._is_over and self._theirs is not None and self._is_final(self._theirs):
            raise BudgetExceededError("another engine has answered")

    def _work_beside(self) -> Answer | None:
        share = self._budget.share(memory=1 - self._part)
        budget = replace(share, progress=None, stages=None, cores=max(1, share.workers - 1))
        try:
            return first_answer(self._others, budget, self._is_final)
        except BudgetExceededError:
            return None

    def _look(self, seconds: float) -> None:
        """Take the answer of the others; there is none if their process was killed."""
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
