"""Explicit search of a smaller net: what the condition does not speak of is reduced."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.disjunctions import goals_of
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.methods.explicit_search import nearest, search
from dineros.analysis.portfolio.reach import Reach

REDUCED = "explicit search of the reduced net"


class ReducedNet(Method):
    """Search the net reduced for the condition; its way leads back to a way of the net."""

    def answer(self, question: Reach, known: Known, budget: Budget) -> Outcome | None:
        """Search the reduced net."""
        smaller = known.reduced(simplified(question.condition), question.names)
        if smaller is None:
            return None
        goals = goals_of(smaller.net, smaller.formula, NetNames(smaller.net))
        if goals is None:
            return None
        answers = (search(smaller.net, goal, budget, question.order, is_shortest=False) for goal in goals)
        answer = nearest(answers, REDUCED)
        if answer.trace is None:
            return answer
        names = smaller.reduction.expand([smaller.net.transitions[number] for number in answer.trace])
        return question.reached([known.transition_index[name] for name in names], REDUCED)
