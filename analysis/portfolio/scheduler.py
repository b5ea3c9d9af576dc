"""The scheduler: runs methods one after the other, then side by side, each with its share of the budget.

A plan defines the order and the shares. It is data, so that it can be read as a table.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from dineros.analysis.answers.beside import first_of_two
from dineros.analysis.answers.budget import RAN_OUT, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.turns import Member
from dineros.analysis.portfolio.known import Known, known_of
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.satisfies import Question

if TYPE_CHECKING:
    from dineros.analysis.portfolio.sheet import Sheet


@dataclass(frozen=True)
class SoFar:
    """The results of earlier turns.

    Attributes
    ----------
    way : Outcome or None
        A known trace that may not be a shortest one.
    last : Outcome or None
        The last result of a method that had one.
    """

    way: Outcome | None = None
    last: Outcome | None = None


When: TypeAlias = Callable[[Question, SoFar], bool]
"""Whether a turn is taken, depending on the question and the results of earlier turns."""


def always(question: Question, so_far: SoFar) -> bool:
    """Take the turn in any case."""
    return True


@dataclass(frozen=True)
class Turn:
    """When a method is used, and its limits.

    Attributes
    ----------
    when : callable
        Returns whether it is used.
    time : float
        Share of the remaining time.
    most_bytes, most_states : int, optional
        Maximum memory, and maximum number of markings.
    if_more_bytes : int
        It is used only if the budget has more memory than this.
    """

    method: Method
    when: When = always
    time: float = 1.0
    most_seconds: float | None = None
    most_bytes: int | None = None
    most_states: int | None = None
    if_more_bytes: int = 0

    def share(self, budget: Budget) -> Budget:
        """Return its share of a budget."""
        share = budget.share(self.time, most_bytes=self.most_bytes, most_states=self.most_states)
        return share if self.most_seconds is None else share.at_most(self.most_seconds)


@dataclass(frozen=True)
class Side:
    """Turns taken one after the other, while other sides run at the same time.

    Attributes
    ----------
    head_start : float
        Seconds of processor time before the other sides begin.
    marking_bytes : int
        Bytes that it needs at least for each marking that exists; 0 if it does not store all of them.
    """

    turns: tuple[Turn, ...]
    head_start: float = 0.0
    marking_bytes: int = 0


@dataclass(frozen=True)
class Together:
    """Sides that run in parallel, or in turns with one core; the first answer ends all.

    Attributes
    ----------
    sides : tuple of Side
        The sides; the first one begins.
    when : callable
        Returns whether they are used.
    alone : float, optional
        Seconds of processor time of the first side before there is a second process; by default one turn.
    """

    sides: tuple[Side, ...]
    when: When = always
    alone: float | None = None


Plan: TypeAlias = Sequence[Turn | Together]


def answered(question: Question, plan: Plan, budget: Budget) -> Outcome:
    """Answer a question by a plan.

    Returns
    -------
    Outcome
        The first one that answers the question; otherwise a trace that may not be a shortest one, or the
        reason why nothing is known.
    """
    budget, so_far, left = budget.begun(), SoFar(), Outcome("unknown", reason=RAN_OUT["time"])
    for turn in plan:
        if not turn.when(question, so_far):
            continue
        found = None
        with suppress(BudgetExceededError):
            found = _asked(question, turn, budget)
        if found is not None:
            if question.is_answer(found):
                return replace(found, seconds=budget.spent)
            so_far = SoFar(so_far.way if found.status == "unknown" else found, found)
            if found.status == "unknown":
                left = found if found.states is not None else replace(found, states=left.states)
        elif isinstance(turn, Together):
            left = replace(left, reason=RAN_OUT["time"])
        if budget.is_over:
            break
    return replace(so_far.way or left, seconds=budget.spent)


def _asked(question: Question, turn: Turn | Together, budget: Budget) -> Outcome | None:
    if isinstance(turn, Turn):
        return turn.method.answer(question, known_of(question.net), turn.share(budget))
    members = [
        Member(partial(_side, question, side), side.head_start, side.marking_bytes) for side in turn.sides
    ]
    return first_of_two(members, budget, question.ends_others, turn.alone)


def _side(question: Question, side: Side, budget: Budget) -> Outcome | None:
    """Take the turns of a side; the answer of another side ends it by an exception, which propagates."""
    found: Outcome | None = None
    for turn in side.turns:
        if budget.memory <= turn.if_more_bytes or not turn.when(question, SoFar(None, found)):
            continue
        found = _asked(question, turn, budget) or found
        if found is not None and (found.status != "unknown" or question.is_answer(found)):
            return found
        if budget.is_over:
            break
    return found


def not_all_stored(known: Known) -> bool:
    """Return whether a stage is useful: if all markings are stored, only stages that use them are."""
    return not known.has_all_markings


@dataclass(frozen=True)
class Stage:
    """A method with all open questions about a net.

    Attributes
    ----------
    part : float
        Share of the time of all questions.
    when : callable
        Returns whether it is used, given the known facts about the net.
    """

    name: str
    method: Method
    part: float
    when: Callable[[Known], bool] = not_all_stored


def answer_sheet(sheet: Sheet, stages: Sequence[Stage], known: Known) -> None:
    """Answer many questions about a net, stage by stage, until all are answered or the time is over."""
    whole = sheet.budget.seconds
    for stage in stages:
        if sheet.is_done or sheet.budget.is_over:
            return
        if not stage.when(known):
            continue
        sheet.budget.stage(stage.name)
        share = sheet.budget if whole is None else sheet.budget.at_most(stage.part * whole)
        with suppress(BudgetExceededError):
            stage.method.answer_all(sheet, known, replace(share, stages=None))
