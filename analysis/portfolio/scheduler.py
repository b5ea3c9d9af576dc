"""Plans for single questions and for sheets of questions, with methods in turns or side by side.

The scheduler of `dineros.analysis.answers.stages` runs them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from dineros.analysis.answers.beside import first_of_two
from dineros.analysis.answers.budget import RAN_OUT, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import PlanEntry, run_stages
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


@dataclass
class Answering:
    """A question, and what its methods have found.

    Attributes
    ----------
    answer : Outcome or None
        The answer.
    left : Outcome
        The result that is returned if no method answers; it has the reason.
    """

    question: Question
    so_far: SoFar = field(default_factory=SoFar)
    answer: Outcome | None = None
    left: Outcome = field(default_factory=lambda: Outcome("unknown", reason=RAN_OUT["time"]))

    def note(self, found: Outcome) -> None:
        """Record the result of a method."""
        self.so_far = SoFar(self.so_far.way if found.status == "unknown" else found, found)
        if self.question.is_answer(found):
            self.answer = found
        elif found.status == "unknown":
            self.left = found if found.states is not None else replace(found, states=self.left.states)

    @property
    def is_done(self) -> bool:
        """Whether there is an answer."""
        return self.answer is not None

    @property
    def has_way(self) -> bool:
        """Whether there is an answer, or a trace that may not be a shortest one."""
        return self.is_done or self.so_far.way is not None


When: TypeAlias = Callable[[Question, SoFar], bool]
"""Whether a turn is taken, depending on the question and the results of earlier turns."""


def always(question: Question, so_far: SoFar) -> bool:
    """Take the turn in any case."""
    return True


@dataclass(frozen=True)
class Turn(PlanEntry[Answering]):
    """When a method is used, and its limits."""

    method: Method
    when: When = always

    def applies(self, record: Answering) -> bool:
        """Return whether it is used."""
        return self.when(record.question, record.so_far)

    def run(self, record: Answering, budget: Budget) -> None:
        """Ask the method, and record its result if it has one."""
        question = record.question
        found = self.method.answer(question, known_of(question.net), budget)
        if found is not None:
            record.note(found)


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

    def member(self, question: Question) -> Member[Outcome]:
        """Return it as an engine that answers a question."""
        return Member(partial(self._answer, question), self.head_start, self.marking_bytes)

    def _answer(self, question: Question, budget: Budget) -> Outcome | None:
        """Take the turns; the answer of another side ends them by an exception, which propagates."""
        record = Answering(question)
        run_stages(record, self.turns, budget, lambda each: each.has_way, given_up=())
        return record.so_far.last


@dataclass(frozen=True)
class Together(PlanEntry[Answering]):
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

    def applies(self, record: Answering) -> bool:
        """Return whether they are used."""
        return self.when(record.question, record.so_far)

    def run(self, record: Answering, budget: Budget) -> None:
        """Run the sides until one of them has an answer."""
        question = record.question
        members = [side.member(question) for side in self.sides]
        found = None
        with suppress(BudgetExceededError):
            found = first_of_two(members, budget, question.ends_others, self.alone)
        if found is not None:
            record.note(found)
        else:
            record.left = replace(record.left, reason=RAN_OUT["time"])


Plan: TypeAlias = Sequence[Turn | Together]


def answered(question: Question, plan: Plan, budget: Budget) -> Outcome:
    """Answer a question by a plan.

    Returns
    -------
    Outcome
        The first one that answers the question; otherwise a trace that may not be a shortest one, or the
        reason why nothing is known.
    """
    budget = budget.begun()
    record = run_stages(Answering(question), plan, budget, lambda each: each.is_done)
    return replace(record.answer or record.so_far.way or record.left, seconds=budget.spent)


def not_all_stored(known: Known) -> bool:
    """Return whether a stage is useful: if all markings are stored, only stages that use them are."""
    return not known.has_all_markings


@dataclass(frozen=True)
class SheetStage(PlanEntry["Sheet"]):
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

    def applies(self, record: Sheet) -> bool:
        """Return whether it is used."""
        return self.when(known_of(record.net))

    def share(self, budget: Budget) -> Budget:
        """Return its share: a part of the time of all questions, not of the rest."""
        return budget.part(self.part)

    def run(self, record: Sheet, budget: Budget) -> None:
        """Ask the method all open questions."""
        budget.stage(self.name)
        self.method.answer_all(record, known_of(record.net), replace(budget, stages=None))


def answer_sheet(sheet: Sheet, stages: Sequence[SheetStage]) -> None:
    """Answer many questions about a net, stage by stage, until all are answered or the time is over."""
    run_stages(sheet, stages, sheet.budget, lambda each: each.is_done)
