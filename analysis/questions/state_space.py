"""State spaces: the engine chosen, and everything that is counted in one object."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from dineros.analysis.answers.beside import first_of_two
from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.turns import HEAD_START, Member
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.memory import peak_memory

if TYPE_CHECKING:
    from dineros.analysis.explicit import Order
    from dineros.analysis.nets.coverability import Pumping
    from dineros.analysis.symbolic.order_cache import OrderCache
    from dineros.analysis.tina import TinaCounts

Engine = Literal["auto", "explicit", "symbolic", "tina"]
LevelOrder = tuple[tuple[str, ...], ...]
_NOT_OF_EVERY_NET = ("pumping", "levels", "reduced_states", "without", "rest")
#: Nodes of the coverability tree that may be made to explain why a net is unbounded.
COVERABILITY_NODES = 2_000


@dataclass(frozen=True)
class StateSpace:
    """Exact figures of a state space; None where an engine cannot count something.

    Attributes
    ----------
    places, transitions : int
        Size of the net explored.
    states, arcs, deadlocks : int or None
        Reachable markings, arcs between them, markings that enable nothing; of an incomplete exploration,
        what was seen.
    max_tokens_in_place, max_tokens_in_marking : int or None
        The largest number of tokens of a place, and of a whole marking.
    engine : str
        The engine that answered.
    complete : bool
        Whether these are all markings.
    reason : str
        Why not: memory, an unbounded net.
    seconds : float
        Wall-clock time, order search included.
    peak_memory_bytes : int
        Peak memory of the process so far.
    pumping : Pumping or None
        Where the net is unbounded: a sequence that makes places grow for ever. Then there are no counts:
        there is no end of markings, and how many were seen says nothing.
    without : tuple of str
        Where it is unbounded: the places that nothing takes from and that no invariant bounds, such as
        counters and logs.
    rest : StateSpace or None
        What there is without those: counts of the net in which they are gone, or stop at the largest number
        that a transition compares them with. It has the same runs; the most tokens are counted only where all
        are gone.
    levels : tuple of tuple of str
        Groups of places by level, where they are decision diagrams that counted.
    reduced_states : int or None
        Markings of the smaller net, where a net was reduced to be counted.
    """

    places: int
    transitions: int
    states: int | None
    arcs: int | None
    deadlocks: int | None
    max_tokens_in_place: int | None
    max_tokens_in_marking: int | None
    engine: str
    complete: bool
    reason: str
    seconds: float
    peak_memory_bytes: int
    pumping: Pumping | None = None
    levels: LevelOrder = ()
    reduced_states: int | None = None
    without: tuple[str, ...] = ()
    rest: StateSpace | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the figures for JSON."""
        return {name: value for name, value in asdict(self).items() if name not in _NOT_OF_EVERY_NET}


def state_space(
    net: CompiledNet,
    engine: Engine = "auto",
    budget: Budget = UNLIMITED,
    orders: OrderCache | None = None,
    order: Order = "breadth-first",
) -> StateSpace:
    """Count the state space of a net.

    ``auto`` takes decision diagrams, side by side with the explicit engine where they take long, and the
    explicit engine alone where bounds of places are not known. Of an unbounded net with counters and logs, it
    counts what is left without them.

    Parameters
    ----------
    net : CompiledNet
        The net.
    engine : {"auto", "explicit", "symbolic", "tina"}
        Which engine; ``tina`` is TINA of LAAS, where it is on the PATH.
    budget : Budget, optional
        What it may cost. TINA takes its time only.
    orders : OrderCache, optional
        Where orders of levels are kept for the symbolic engine.
    order : {"breadth-first", "depth-first"}
        How the explicit engine goes.

    Raises
    ------
    TinaError
        TINA is not there, or failed.
    BudgetError
        Memory ran out before there was anything to count.
    """
    from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError

    began, budget = time.perf_counter(), budget.begun()
    if engine == "tina":
        return _tina(net, budget, began)
    if engine == "explicit":
        return _with_rest(net, _explicit(net, budget, began, order), engine, budget, orders, order)
    if engine == "symbolic":
        try:
            return _symbolic(net, budget, began, orders)
        except UnknownBoundError as error:
            return _nothing(net, "symbolic", str(error), began)
    try:
        found = first_of_two(
            [
                Member(lambda share: _symbolic(net, share, began, orders), head_start=HEAD_START),
                Member(lambda share: _explicit(net, share, began, order)),
            ],
            budget,
            lambda space: space.complete or space.pumping is not None,
            alone=HEAD_START,
        )
    except (UnknownBoundError, LevelSizeError):
        found = _explicit(net, budget, began, order)
    if found is None:
        budget.check_time()
        raise BudgetExceededError("no engine has answered")
    return _with_rest(net, found, engine, budget, orders, order)


def unfinished(net: CompiledNet, engine: str, states: int | None, reason: str, seconds: float) -> StateSpace:
    """Return the figures of a state space whose count ended early, with the markings seen if known."""
    began = time.perf_counter() - seconds
    return figures_of(net, engine, began, (states, None, None), reason=reason)


def differences(net: CompiledNet, counts: TinaCounts, budget: Budget = UNLIMITED) -> list[str]:
    """Compare what TINA counted with an engine of ours; a line for each figure that differs.

    Raises
    ------
    TinaError
        The engine could not count all within its memory.
    """
    from dineros.analysis.tina import TinaError

    space = state_space(net, budget=budget)
    if not space.complete:
        if not counts.is_bounded and "bound" in space.reason:
            return []
        raise TinaError(f"nothing to compare with: {space.reason}")
    pairs = {
        "states": (counts.states, space.states),
        "arcs": (counts.arcs, space.arcs),
        "deadlocks": (counts.deadlocks, space.deadlocks),
    }
    return [
        f"{name}: {theirs} by tina, {ours} by the {space.engine} engine"
        for name, (theirs, ours) in pairs.items()
        if theirs is not None and ours is not None and theirs != ours
    ]


def _symbolic(net: CompiledNet, budget: Budget, began: float, orders: OrderCache | None) -> StateSpace:
    from dineros.analysis.symbolic.engine import symbolic_state_space

    try:
        space = symbolic_state_space(net, budget, orders=orders)
        if not space.complete:
            return _nothing(net, "symbolic", RAN_OUT[space.reason], began)
        budget.stage("counting arcs, deadlocks and tokens")
        space.sets.budget = budget
        counts = space.markings, space.arcs(), space.deadlocks()
    except BudgetExceededError as limit:
        return _nothing(net, "symbolic", str(limit), began)
    tokens = max(space.largest_place(), default=0), space.largest_total()
    return replace(figures_of(net, "symbolic", began, counts, tokens), levels=space.order)


def _explicit(net: CompiledNet, budget: Budget, began: float, order: Order) -> StateSpace:
    from dineros.analysis.explicit import explore
    from dineros.analysis.nets.coverability import coverability

    space = explore(net, budget.share(most_bytes=budget.memory), order=order)
    if space.pumping is not None:
        # What the search came across is a proof; the coverability tree often has a shorter one.
        others = coverability(net, COVERABILITY_NODES).pumping
        pumping = min(
            [space.pumping, *([others] if others else [])], key=lambda p: len(p.prefix) + len(p.suffix)
        )
        grown = ", ".join(net.places[place] for place in pumping.places)
        reason = f"unbounded: {grown} can grow for ever"
        return replace(_nothing(net, "explicit", reason, began), pumping=pumping)
    counts = space.markings, space.arcs, space.deadlocks
    tokens = max(space.largest_place, default=0), space.largest_total
    reason = "" if space.complete else RAN_OUT.get(space.reason or "", space.reason or "unknown")
    return figures_of(net, "explicit", began, counts, tokens, reason)


def _tina(net: CompiledNet, budget: Budget, began: float) -> StateSpace:
    from dineros.analysis.tina import TinaBudgetError, count

    try:
        counts = count(net, budget)
    except TinaBudgetError as limit:
        return _nothing(net, "tina", limit.why, began)
    if not counts.is_bounded:
        return _nothing(net, "tina", "unbounded", began)
    return figures_of(net, "tina", began, (counts.states, counts.arcs, counts.deadlocks))


def _with_rest(
    net: CompiledNet,
    space: StateSpace,
    engine: Engine,
    budget: Budget,
    orders: OrderCache | None,
    order: Order,
) -> StateSpace:
    """Count an unbounded net without its counters and logs, where it has any."""
    if space.pumping is None:
        return space
    from dineros.analysis.covering.growing import growing_places, largest_weights, limited
    from dineros.analysis.nets.bounds import place_bounds

    bounds, weights = place_bounds(net), largest_weights(net)
    limits = {place: weights[place] for place in growing_places(net) if bounds[place] is None}
    if not limits:
        return space
    budget.stage("the net without places that only grow")
    smaller = limited(net, limits).net
    began = time.perf_counter()
    try:
        rest = state_space(smaller, engine, budget, orders, order)
    except BudgetExceededError as limit:
        rest = _nothing(smaller, engine, str(limit), began)
    if any(limits.values()):
        # Among the places are some that say how much room is left.
        rest = replace(rest, max_tokens_in_place=None, max_tokens_in_marking=None)
    return replace(space, without=tuple(net.places[place] for place in limits), rest=rest)


def _nothing(net: CompiledNet, engine: str, reason: str, began: float) -> StateSpace:
    return figures_of(net, engine, began, reason=reason)


def figures_of(
    net: CompiledNet,
    engine: str,
    began: float,
    counts: tuple[int | None, int | None, int | None] = (None, None, None),
    tokens: tuple[int | None, int | None] = (None, None),
    reason: str = "",
) -> StateSpace:
    """Return counts (states, arcs, deadlocks) and largest tokens as figures; complete without a reason."""
    return StateSpace(
        len(net.places),
        len(net.transitions),
        *counts,
        *tokens,
        engine,
        not reason,
        reason,
        time.perf_counter() - began,
        peak_memory(),
    )
