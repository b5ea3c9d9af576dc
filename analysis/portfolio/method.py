"""The interface of decision methods."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import fairly

if TYPE_CHECKING:
    from dineros.analysis.portfolio.known import Known
    from dineros.analysis.portfolio.satisfies import Question
    from dineros.analysis.portfolio.sheet import Sheet


class Method:
    """A decision method. A new one is a class in a separate module, and is entered in a plan.

    It answers single questions, or many questions about a net at once, or both.
    """

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Answer a question.

        Returns
        -------
        Outcome or None
            ``reachable`` with a replayed trace, ``unreachable``, or ``unknown`` with a reason; None: the
            method does not apply, or has no result.

        Raises
        ------
        BudgetExceededError
            The budget was not sufficient.
        """
        return None

    def answer_all(self, sheet: Sheet, known: Known, budget: Budget) -> None:
        """Answer as many questions about a net as possible, and record the answers on their sheet.

        By default, each reachability question is asked separately, with a fair share of the time. A method
        that answers all of them at once more efficiently, or that answers other questions, overrides this.

        Raises
        ------
        BudgetExceededError
            The budget was not sufficient.
        """
        for one, share in fairly(sheet.open_questions(), budget):
            if share.is_over:
                return
            with suppress(BudgetExceededError):
                found = self.answer(one.question, known, share.at_most(sheet.patience))
                if found is not None and found.status != "unknown":
                    one.note(found)
