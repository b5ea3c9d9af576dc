"""Search for a deadlock without redundant interleavings, by stubborn sets."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.explicit import find
from dineros.analysis.explicit.goals import Goal
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.sheet import DEADLOCK, Sheet


class StubbornSets(Method):
    """Decide whether a deadlock is reachable."""

    def answer_all(self, sheet: Sheet, known: Known, budget: Budget) -> None:
        """Search for one if that is in question."""
        if not (sheet.open_globals() and sheet.whole.is_open(DEADLOCK)):
            return
        share = budget.share(memory=0.5).at_most(sheet.patience)
        answer = find(known.net, Goal.deadlock(), share, reduction="stubborn", workers=1)
        if answer.status != "unknown":
            sheet.whole.tell(DEADLOCK, answer.status == "reachable", "stubborn sets")
