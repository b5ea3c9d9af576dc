"""The state equation and traps: proofs that a condition is never met, without a state space."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach

STATE_EQUATION, TRAPS = "state equation", "state equation and traps"


class StateEquationAndTraps(Method):
    """Exclude each alternative of the condition by a weighting of the places."""

    def answer(self, question: Reach, known: Known, budget: Budget) -> Outcome | None:
        """Return that the condition is never met; nothing else follows from structure."""
        from dineros.analysis.proofs.exclusion import excluded

        wanted = simplified(question.condition)
        found = excluded(known.equation, wanted, question.conditions, lambda: budget.is_over)
        if found is None:
            return None
        return Outcome("unreachable", by=TRAPS if found.traps else STATE_EQUATION, evidence=found)
