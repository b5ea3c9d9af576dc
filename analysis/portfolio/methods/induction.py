"""A satisfiability solver: bounded model checking with k-induction."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.satisfies import Question


class Induction(Method):
    """Search for a trace, or for a proof that there is none, at increasing depth.

    Only nets with few tokens on each place are searched.
    """

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Call the solver."""
        # The solver is imported at its first use: most questions are answered without it.
        from dineros.analysis.proofs.induction import by_induction

        if not isinstance(question, Reach) or known.sums is None:
            return None
        answer = by_induction(question.net, question.condition, question.conditions, budget, known.sums)
        if answer.trace is not None:
            return question.reached(answer.trace, answer.by)
        return answer if answer.status == "unreachable" else None
