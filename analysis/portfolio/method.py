"""What a method of deciding is."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome

if TYPE_CHECKING:
    from dineros.analysis.portfolio.known import Known
    from dineros.analysis.portfolio.satisfies import Question
    from dineros.analysis.portfolio.sheet import Sheet


class Method:
    """A method of deciding. A new one is a class in a module of its own, and stands in a plan.

    It answers single questions, or many about a net at once, or both.
    """

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Answer a question.

        Parameters
        ----------
        question : Reach or Satisfies
            The question.
        known : Known
            What is known of its net.
        budget : Budget
            What it may cost; its clock runs.

        Returns
        -------
        Outcome or None
            ``reachable`` with a replayed trace, ``unreachable``, or ``unknown`` with a reason; None where the
            method does not apply, or has nothing to say.

        Raises
        ------
        BudgetExceededError
            The budget did not suffice.
        """
        return None

    def answer_all(self, sheet: Sheet, known: Known, budget: Budget) -> None:
        """Answer what can be answered of many questions about a net, and note it on their sheet.

        Each question whether a marking can be reached is asked alone, with a fair share of the time. A method
        that can do better for all of them at once, or that answers other questions, has its own way.

        Raises
        ------
        BudgetExceededError
            The budget did not suffice.
        """
        asked = sheet.open_questions()
        for number, one in enumerate(asked):
            if budget.is_over:
                return
            share = budget.share(1 / (len(asked) - number)).at_most(sheet.patience)
            with suppress(BudgetExceededError):
                found = self.answer(one.question, known, share)
                if found is not None and found.status != "unknown":
                    one.note(found)
