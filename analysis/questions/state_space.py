"""State spaces: all counts in one object, by a plan of the portfolio."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.count import Count, Counted, StateSpace, figures_of
from dineros.analysis.portfolio.plans import COUNT
from dineros.analysis.portfolio.scheduler import answered

if TYPE_CHECKING:
    from dineros.analysis.explicit import Order
    from dineros.analysis.symbolic.order_cache import OrderCache

Engine = Literal["auto", "explicit", "symbolic", "tina"]


def state_space(
    net: CompiledNet,
    engine: Engine = "auto",
    budget: Budget = UNLIMITED,
    orders: OrderCache | None = None,
    order: Order = "breadth-first",
) -> StateSpace:
    """Count the state space of a net.

    ``auto`` uses decision diagrams, in parallel with the explicit engine if they take long, and the explicit
    engine alone if bounds of places are unknown. In an unbounded net with counters and logs, it counts the
    net without them.

    Parameters
    ----------
    engine : {"auto", "explicit", "symbolic", "tina"}
        The engine; ``tina`` is TINA of LAAS, if it is on the PATH.
    budget : Budget, optional
        Budget. TINA uses only its time.
    order : {"breadth-first", "depth-first"}
        Order of the explicit engine.

    Raises
    ------
    TinaError
        TINA is not available, or failed.
    BudgetError
        Memory was exhausted before anything was counted.
    """
    question, budget = Count(net, orders, order), budget.begun()
    found = answered(question, COUNT[engine], budget)
    if not isinstance(found, Counted) or found.space is None:
        budget.check_time()
        raise BudgetExceededError("no engine has given an answer")
    return _with_rest(question, found.space, engine, budget)


def unfinished(net: CompiledNet, engine: str, states: int | None, reason: str, seconds: float) -> StateSpace:
    """Return the figures of an unfinished count, with the number of markings so far if it is known."""
    began = time.perf_counter() - seconds
    return figures_of(net, engine, began, (states, None, None), reason=reason)


def _with_rest(question: Count, space: StateSpace, engine: Engine, budget: Budget) -> StateSpace:
    """Count an unbounded net without its counters and logs, if it has any."""
    if space.pumping is None:
        return space
    from dineros.analysis.covering.growing import growing_places, largest_weights, limited
    from dineros.analysis.nets.bounds import place_bounds

    net = question.net
    bounds, weights = place_bounds(net), largest_weights(net)
    limits = {place: weights[place] for place in growing_places(net) if bounds[place] is None}
    if not limits:
        return space
    budget.stage("the net without places that only grow")
    smaller = limited(net, limits).net
    began = time.perf_counter()
    try:
        rest = state_space(smaller, engine, budget, question.orders, question.order)
    except BudgetExceededError as limit:
        rest = figures_of(smaller, engine, began, reason=str(limit))
    if any(limits.values()):
        # Some places are complements, whose tokens represent free room.
        rest = replace(rest, max_tokens_in_place=None, max_tokens_in_marking=None)
    return replace(space, without=tuple(net.places[place] for place in limits), rest=rest)
