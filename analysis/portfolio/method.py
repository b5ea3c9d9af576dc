"""What a method of deciding is."""

from __future__ import annotations

from abc import ABC, abstractmethod

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.reach import Reach


class Method(ABC):
    """A method of deciding. A new one is a class in a module of its own, and stands in a plan."""

    @abstractmethod
    def answer(self, question: Reach, known: Known, budget: Budget) -> Outcome | None:
        """Answer a question.

        Parameters
        ----------
        question : Reach
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
