"""Budgets of methods that call work without limits of its own."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget, BudgetExceededError, Progress
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.symbolic.saturation import DiagramMemoryError

GIVEN_UP = (BudgetExceededError, DiagramMemoryError, UnknownBoundError, LevelSizeError, MemoryError)
"""Errors of an engine whose limits are too low, or that does not support the net."""


def told(budget: Budget, memory: int | None = None) -> Budget:
    """Return a budget without its own time limit, for work that ends with the time of another budget.

    So decisions that depend on a share of the time are independent of the speed of the machine.
    """

    def tell(_: Progress) -> None:
        budget.check_time()

    return Budget(memory, progress=tell)
