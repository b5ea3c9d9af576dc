"""A smaller net: what the condition does not speak of is reduced."""

from __future__ import annotations

from dataclasses import dataclass, replace

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.scheduler import Plan, answered

REDUCED = "explicit search of the reduced net"


@dataclass(frozen=True)
class ReducedNet(Method):
    """Ask the same of the net reduced for the condition; a way of it leads back to one of the net.

    Attributes
    ----------
    plan : Plan
        How it is asked there.
    by : str
        Who answers then.
    """

    plan: Plan
    by: str = REDUCED

    def answer(self, question: Reach, known: Known, budget: Budget) -> Outcome | None:
        """Ask it of the reduced net."""
        smaller = known.reduced(simplified(question.condition), question.names)
        if smaller is None or budget.is_over:
            return None
        small, names = smaller.net, NetNames(smaller.net)
        asked = Reach(small, smaller.formula, names, question.order, is_shown=question.is_shown)
        # What it rests on speaks of the places of the reduced net.
        found = replace(answered(asked, self.plan, budget), by=self.by, evidence=None)
        if found.trace is None or not question.is_shown:
            return replace(found, trace=None)
        way = smaller.reduction.expand([small.transitions[number] for number in found.trace])
        return question.reached([known.transition_index[name] for name in way], self.by)
