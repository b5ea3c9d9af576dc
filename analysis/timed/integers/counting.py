"""Markings of a net in which time is counted: by explicit search, or by decision diagrams."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.stages import Attempt, Share, first_result
from dineros.analysis.explicit.engine import all_marked, count_marked
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.timed.integers.net import IntegerNet

FEW = 2_000_000
"""States up to which they are searched one by one before diagrams are tried."""

FEW_STATES = Share(most_states=FEW)
"""The same as a limit."""


def count_markings(made: IntegerNet, budget: Budget) -> int:
    """Return how many markings of the timed net are reachable.

    Raises
    ------
    BudgetExceededError
        A limit was hit before.
    """
    from dineros.analysis.symbolic.engine import symbolic_state_space
    from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError

    budget = budget.begun()
    reason = ""

    def by_search(share: Budget) -> int | None:
        nonlocal reason
        found, reason = count_marked(made.net, made.end, share)
        if reason == "interrupted" or (found is None and budget.is_over):
            raise BudgetExceededError(reason)
        return found

    def by_diagrams(share: Budget) -> int | None:
        try:
            space = symbolic_state_space(made.net, share)
            return space.satisfying({made.end: (1, None)}) if space.complete else None
        except (UnknownBoundError, LevelSizeError, BudgetExceededError):
            return None

    attempts = (
        Attempt(by_search, time=0.5, memory=0.5, most_states=FEW),
        Attempt(by_diagrams, time=0.7),
        Attempt(by_search),
    )
    found = first_result(attempts, budget)
    if found is None:
        raise BudgetExceededError(reason)
    return found


def all_markings(
    made: IntegerNet, places: Sequence[str], budget: Budget
) -> tuple[Int64Array, frozenset[int]]:
    """Return the markings of the timed net, one a row, sorted, and the transitions that fire.

    Raises
    ------
    BudgetExceededError
        A limit was hit before; one of them is `FEW` states.
    """
    markings, enabled = all_marked(made.net, made.end, places, FEW_STATES.share(budget))
    firing = (t for t, names in enumerate(made.firing) if not enabled.isdisjoint(names))
    return markings, frozenset(firing)
