"""A smaller net: parts that do not affect the condition are reduced."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit.goals import Goal
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.logic.language.syntax import Enabled, Name
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.satisfies import Question
from dineros.analysis.portfolio.scheduler import Plan, answered

if TYPE_CHECKING:
    from dineros.analysis.reductions import Reduction

REDUCED = "explicit search of the reduced net"


@dataclass(frozen=True)
class ReducedNet(Method):
    """Decide the question on the net reduced for it; its trace is translated to a trace of the net."""

    plan: Plan
    by: str = REDUCED

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Decide the question on the reduced net."""
        if not isinstance(question, Reach):
            return None
        smaller = _reduced(question, known)
        if smaller is None or budget.is_over:
            return None
        reduction, asked = smaller
        # Its evidence is about the places of the reduced net.
        found = replace(answered(asked, self.plan, budget), by=self.by, evidence=None)
        if found.trace is None or not question.is_shown:
            return replace(found, trace=None)
        last = [] if question.transition is None else [known.net.transitions[question.transition]]
        names = reduction.expand([*(asked.net.transitions[number] for number in found.trace), *last])
        way = [known.transition_index[name] for name in names[: len(names) - len(last)]]
        return question.reached(way, self.by)


def _reduced(question: Reach, known: Known) -> tuple[Reduction, Reach] | None:
    """Return the reduction of the net, and the question about the reduced net."""
    order, is_shown = question.order, question.is_shown
    if question.transition is not None:
        name = known.net.transitions[question.transition]
        reduction = known.reduced_for_firing(name)
        small, goals = reduction.net, (Goal.enabled(reduction.net, name),)
        condition = Enabled(Name(name))
        return reduction, Reach(small, condition, NetNames(small), order, own_goals=goals, is_shown=is_shown)
    found = known.reduced(simplified(question.condition), question.names)
    if found is None:
        return None
    return found.reduction, Reach(found.net, found.formula, NetNames(found.net), order, is_shown=is_shown)
