"""The scheduler: methods are asked one after the other, then side by side, each with its share of the budget.

A plan says in which order, and who gets how much. It is data, so that it can be read as a table.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

from dineros.analysis.answers.beside import first_of_two
from dineros.analysis.answers.budget import RAN_OUT, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.turns import Member
from dineros.analysis.portfolio.known import known_of
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach

When: TypeAlias = Callable[[Reach, Outcome | None], bool]
"""Whether a turn comes: by the question, and by a way that is known though it may not be a shortest one."""


def always(question: Reach, way: Outcome | None) -> bool:
    """Let a turn come in any case."""
    return True


@dataclass(frozen=True)
class Turn:
    """When a method is asked, and what it may cost.

    Attributes
    ----------
    method : Method
        The method.
    when : callable
        Whether it is asked.
    time : float
        Part of the time that is left.
    most_seconds : float, optional
        Seconds at most.
    most_bytes, most_states : int, optional
        Bytes, and markings, at most.
    if_more_bytes : int
        It is asked only if the budget has more bytes.
    """

    method: Method
    when: When = always
    time: float = 1.0
    most_seconds: float | None = None
    most_bytes: int | None = None
    most_states: int | None = None
    if_more_bytes: int = 0

    def share(self, budget: Budget) -> Budget:
        """Return what it may cost of a budget."""
        share = budget.share(self.time, most_bytes=self.most_bytes, most_states=self.most_states)
        if self.most_seconds is None or (share.left is not None and share.left <= self.most_seconds):
            return share
        return replace(share, started=None, seconds=self.most_seconds).begun()


@dataclass(frozen=True)
class Side:
    """Turns that are taken one after the other while other sides go on beside them.

    Attributes
    ----------
    turns : tuple of Turn
        The turns.
    weight : float
        Its part of the time, compared with those of the other sides.
    head_start : float
        Seconds of the processor before the other sides begin.
    """

    turns: tuple[Turn, ...]
    weight: float = 1.0
    head_start: float = 0.0


@dataclass(frozen=True)
class Together:
    """Sides that work side by side, and by turns where there is one core; the first answer ends all.

    Attributes
    ----------
    sides : tuple of Side
        The sides; the first one begins.
    when : callable
        Whether they are asked.
    """

    sides: tuple[Side, ...]
    when: When = always


Plan: TypeAlias = Sequence[Turn | Together]


def answered(question: Reach, plan: Plan, budget: Budget) -> Outcome:
    """Answer a question by a plan.

    Returns
    -------
    Outcome
        The first one that answers the question; otherwise a way that may not be a shortest one, or why
        nothing is known.
    """
    budget, way, left = budget.begun(), None, Outcome("unknown", reason=RAN_OUT["time"])
    for turn in plan:
        if not turn.when(question, way):
            continue
        found = None
        with suppress(BudgetExceededError):
            found = _asked(question, turn, budget)
        if found is not None:
            if question.is_answer(found):
                return replace(found, seconds=budget.spent)
            if found.status != "unknown":
                way = found
            else:
                left = found if found.states is not None else replace(found, states=left.states)
        elif isinstance(turn, Together):
            left = replace(left, reason=RAN_OUT["time"])
        if budget.is_over:
            break
    return replace(way or left, seconds=budget.spent)


def _asked(question: Reach, turn: Turn | Together, budget: Budget) -> Outcome | None:
    if isinstance(turn, Turn):
        return turn.method.answer(question, known_of(question.net), turn.share(budget))
    members = [Member(partial(_side, question, side), side.weight, side.head_start) for side in turn.sides]
    return first_of_two(members, budget, question.is_answer)


def _side(question: Reach, side: Side, budget: Budget) -> Outcome | None:
    """Take the turns of a side; the answer of another one ends it by an exception, which passes."""
    found: Outcome | None = None
    for turn in side.turns:
        if budget.memory <= turn.if_more_bytes or not turn.when(question, found):
            continue
        found = _asked(question, turn, budget) or found
        if found is not None and (found.status != "unknown" or question.is_answer(found)):
            return found
        if budget.is_over:
            break
    return found
