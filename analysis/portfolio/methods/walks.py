"""Walks: at random, and along solutions of the state equation; they find distant, but not rare, markings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.covering.goals import with_goals
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.satisfies import Question
from dineros.analysis.walks.first_round import first_round

if TYPE_CHECKING:
    from dineros.analysis.portfolio.sheet import Sheet

WALKS = "walks"


class Walks(Method):
    """Walk to one of the goals."""

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Return the trace of a successful walk; without one, nothing is proved."""
        if not isinstance(question, Reach):
            return None
        goals = question.goals
        asked = None if goals is None else with_goals(question.net, goals)
        if goals is None or asked is None:
            return None
        found = first_round(asked.net, budget, asked.transitions, any(goal.is_deadlock for goal in goals))
        ways = [asked.way(found.ways[t][:-1]) for t in asked.transitions if t in found.ways]
        if found.deadlock is not None:
            way = asked.way(found.deadlock)
            ways += [way] if question.holds(replay(question.net, way)[-1]) else []
        return question.reached(min(ways, key=len), WALKS) if ways else None


class RandomWalks(Method):
    """Walk at random until all reachable answers are found or the time is over; traces are not kept."""

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Evaluate the markings of random walks, if the question needs no trace."""
        from dineros.analysis.logic.graphs.predicates import satisfied

        if not isinstance(question, Reach):
            return None
        if question.is_shown or budget.deadline is None:
            return None
        while not budget.is_over:
            if satisfied(known.walker.walk(), question.condition, question.conditions).any():
                return Outcome("reachable", by="random walk")
        return None

    def answer_all(self, sheet: Sheet, known: Known, budget: Budget) -> None:
        """Evaluate all questions on the markings of the same walks."""
        while not budget.is_over and not sheet.is_done:
            rows = known.walker.walk()
            sheet.look(rows, "random walk")
            sheet.whole.look(rows, known.walker)
            if not (sheet.open_goals() or sheet.open_limits() or sheet.open_globals()):
                return
