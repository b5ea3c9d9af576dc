"""How methods keep a budget while work continues that has no limits of its own."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget, BudgetExceededError, Progress
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.symbolic.saturation import DiagramMemoryError

GIVEN_UP = (BudgetExceededError, DiagramMemoryError, UnknownBoundError, LevelSizeError, MemoryError)
"""What an engine raises that has not got enough, or cannot take the net."""


def told(budget: Budget, memory: int | None = None) -> Budget:
    """Return a budget without a limit of time for work that is ended when that of another one is up.

    What engines do by a part of their time does not depend on the speed of the machine then.
    """

    def tell(_: Progress) -> None:
        budget.check_time()

    return Budget(memory, progress=tell)
