"""Directed search for a distant firing, guided by the state equation."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.covering.firings import FEW_MARKINGS
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.satisfies import Question


class DirectedSearch(Method):
    """Search few markings for one that enables a transition."""

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Search for it, if the question is about one transition."""
        if not isinstance(question, Reach):
            return None
        if question.transition is None:
            return None
        way, _ = known.directed.way_to(question.transition, budget, FEW_MARKINGS)
        return None if way is None else question.reached(way[:-1], "directed search")
