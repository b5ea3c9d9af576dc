"""State spaces counted on a reduced net; only counts that the reduction preserves are returned.

B. Berthomieu, D. Le Botlan, S. Dal Zilio, *Petri net reductions for counting markings*, SPIN 2018, LNCS
10869.
"""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.count import StateSpace, figures_of
from dineros.analysis.questions.state_space import Engine, state_space
from dineros.analysis.reductions import Property, Reduction, reduce, ways_to_share

if TYPE_CHECKING:
    from dineros.analysis.explicit import Order
    from dineros.analysis.symbolic.order_cache import OrderCache


def reduced_state_space(
    net: CompiledNet,
    engine: Engine = "auto",
    budget: Budget = UNLIMITED,
    orders: OrderCache | None = None,
    order: Order = "breadth-first",
) -> StateSpace:
    """Count the state space of a net on a reduced net.

    Decision diagrams count markings with weights, so places whose tokens can be distributed in every way may
    be merged. Other engines count a net in which each marking represents the same number of markings.

    Returns
    -------
    StateSpace
        ``states`` and ``deadlocks`` are those of the net; other counts are not preserved and are None.
        ``places``, ``transitions`` and ``reduced_states`` are those of the reduced net. If the net is
        unbounded, the result is that of `state_space`.

    Raises
    ------
    TinaError, BudgetError, BudgetExceededError
        As for `state_space`.

    Examples
    --------
    >>> chain = [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"c": 1}), ("v", {"c": 1}, {"d": 1})]
    >>> space = reduced_state_space(CompiledNet.build({"a": 9, "b": 0, "c": 0, "d": 0}, chain))
    >>> space.places, space.reduced_states, space.states, space.deadlocks
    (1, 1, 220, 1)
    """
    began, budget = time.perf_counter(), budget.begun()
    space = None
    if engine in ("auto", "symbolic"):
        space = _weighted(net, budget, orders, began)
    if space is None:
        space = _by_factor(net, engine, budget, orders, order)
    if space.pumping is not None:
        return state_space(net, "explicit", budget, order=order)
    return replace(space, seconds=time.perf_counter() - began)


def _weighted(net: CompiledNet, budget: Budget, orders: OrderCache | None, began: float) -> StateSpace | None:
    """Count by decision diagrams; None: bounds of places are unknown."""
    from dineros.analysis.symbolic.engine import symbolic_state_space
    from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError

    reduction = reduce(net, {Property.MARKINGS, Property.DEADLOCKS})
    small, merged = reduction.net, reduction.merged
    try:
        space = symbolic_state_space(small, budget, orders=orders, keep=merged)
    except (UnknownBoundError, LevelSizeError):
        return None
    if not space.complete:
        return figures_of(small, "symbolic", began, reason=space.reason)
    weights = {place: partial(ways_to_share, places=number) for place, number in merged.items()}
    states = space.weighted(weights) * reduction.marking_factor
    counts = states, None, _times(space.deadlocks(), reduction.deadlock_factor)
    return replace(figures_of(small, "symbolic", began, counts), reduced_states=space.markings)


def _by_factor(
    net: CompiledNet, engine: Engine, budget: Budget, orders: OrderCache | None, order: Order
) -> StateSpace:
    reduction = reduce(net, {Property.STATE_SPACE_SIZE, Property.DEADLOCKS})
    space = state_space(reduction.net, engine, budget, orders, order)
    return _of_net(space, reduction)


def _of_net(space: StateSpace, reduction: Reduction) -> StateSpace:
    """Return the figures of the net from those of the reduced net."""
    return replace(
        space,
        states=_times(space.states, reduction.count_factor),
        arcs=None,
        deadlocks=_times(space.deadlocks, reduction.deadlock_factor),
        max_tokens_in_place=None,
        max_tokens_in_marking=None,
        reduced_states=space.states,
    )


def _times(count: int | None, factor: int) -> int | None:
    return None if count is None else count * factor
