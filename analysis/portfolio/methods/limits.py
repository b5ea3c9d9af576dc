"""Decision diagrams of a net in which unbounded places are limited."""

from __future__ import annotations

from dataclasses import dataclass, replace

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.syntax import Exists, Finally
from dineros.analysis.portfolio.count import Count
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.satisfies import Question, Satisfies


@dataclass(frozen=True)
class NetWithLimits(Method):
    """Decide questions on nets with an infinite state space.

    Attributes
    ----------
    most_work : int, optional
        Cache misses of saturation after which it gives up; about three million per second.
    """

    most_work: int | None = None

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Use the diagram of the net with limits."""
        from dineros.analysis.logic.ctl.limits import decide_with_limits

        if isinstance(question, Count):
            return None
        net, names = question.net, question.names
        if isinstance(question, Satisfies):
            return decide_with_limits(net, question.formula, names, budget, self.most_work)
        way = Exists(Finally(question.condition))
        found = decide_with_limits(net, way, names, budget, self.most_work)
        if found is None or found.trace is not None:
            return found and question.reached(found.stem, found.by)
        return replace(found, status="unreachable")
