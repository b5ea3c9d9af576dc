"""CTL on nets with an infinite state space, as far as it can be decided."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.satisfies import Question, Satisfies

if TYPE_CHECKING:
    from dineros.analysis.logic.ctl.endless import Check


@dataclass(frozen=True)
class EndlessNet(Method):
    """Decide a formula on an unbounded net, or report what grows.

    Attributes
    ----------
    check : callable
        Decides a formula on a bounded net.
    """

    check: Check

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Decide it, if the net is proved to be unbounded."""
        if not isinstance(question, Satisfies):
            return None
        from dineros.analysis.logic.ctl.endless import decide_endless

        formula, names = question.formula, question.names
        return decide_endless(question.net, formula, question.bound, names, budget, self.check)
