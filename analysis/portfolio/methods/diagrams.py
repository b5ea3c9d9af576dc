"""Decision diagrams of all reachable markings."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.syntax import Exists, Finally
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach

DIAGRAMS = "decision diagrams"


class DecisionDiagrams(Method):
    """Make the diagram of all markings, and look for one that fulfils the condition."""

    def answer(self, question: Reach, known: Known, budget: Budget) -> Outcome | None:
        """Ask whether some marking fulfils it, and for a way there."""
        from dineros.analysis.logic.ctl.checking import check_ctl

        way = Exists(Finally(question.condition))
        answer = check_ctl(question.net, way, question.names, budget, engine="symbolic")
        if answer.status == "holds" and answer.trace is not None and not answer.reason.startswith("a run"):
            return question.reached(answer.trace, DIAGRAMS)
        if answer.status == "violated":
            return Outcome("unreachable", states=answer.states, by=DIAGRAMS)
        return None
