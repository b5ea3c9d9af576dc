"""Satisfiability solvers: k-induction with bounded model checking, and property-directed reachability."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.satisfies import Question


class Solver(Method):
    """Let a solver find a trace, or a proof that there is none; for nets with few tokens on each place.

    A subclass defines the function that calls the solver, `_asks`.
    """

    _asks: ClassVar[Callable[[], Callable[..., Outcome]]]

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Call the solver."""
        if not isinstance(question, Reach) or known.sums is None:
            return None
        ask = type(self)._asks()
        answer = ask(question.net, question.condition, question.conditions, budget, known.sums)
        if answer.trace is not None:
            return question.reached(answer.trace, answer.by)
        return answer if answer.status == "unreachable" else None


def _induction() -> Callable[..., Outcome]:
    # The solver is imported at its first use: most questions are answered without it.
    from dineros.analysis.proofs.induction import by_induction

    return by_induction


def _clauses() -> Callable[..., Outcome]:
    from dineros.analysis.proofs.pdr import by_clauses

    return by_clauses


class Induction(Solver):
    """Search for a trace, or for a proof that there is none, at increasing depth."""

    _asks = staticmethod(_induction)


class Clauses(Solver):
    """Learn clauses that exclude the condition, or find a trace."""

    _asks = staticmethod(_clauses)
