"""Markings of a net in which time is counted: by explicit search, or by decision diagrams."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.explicit.engine import all_marked, count_marked
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.timed.integers.net import IntegerNet

FEW = 2_000_000
"""States up to which they are searched one by one before diagrams are tried."""


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
    found, reason = count_marked(made.net, made.end, budget.share(0.5, 0.5, most_states=FEW))
    if found is not None:
        return found
    if reason == "interrupted" or budget.is_over:
        raise BudgetExceededError(reason)
    try:
        space = symbolic_state_space(made.net, budget.share(0.7))
        if space.complete:
            return space.satisfying({made.end: (1, None)})
    except (UnknownBoundError, LevelSizeError, BudgetExceededError):
        budget.stage("explicit search")
    found, reason = count_marked(made.net, made.end, budget)
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
    most = FEW if budget.states is None else min(FEW, budget.states)
    markings, enabled = all_marked(made.net, made.end, places, budget.share(most_states=most))
    firing = (t for t, names in enumerate(made.firing) if not enabled.isdisjoint(names))
    return markings, frozenset(firing)
