"""Bounded model checking with k-induction, by a satisfiability solver."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.satisfies import Question


class Induction(Method):
    """Look for a way, or for a proof that there is none, ever deeper; of nets with few tokens in a place."""

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Ask the solver."""
        from dineros.analysis.proofs.induction import by_induction

        if not isinstance(question, Reach):
            return None
        if known.sums is None:
            return None
        answer = by_induction(question.net, question.condition, question.conditions, budget, known.sums)
        if answer.trace is not None:
            return question.reached(answer.trace, answer.by)
        return answer if answer.status == "unreachable" else None
