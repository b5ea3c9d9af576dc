"""State spaces: the choice of the engine, and all counts in one object."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
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
#: Maximum number of nodes of the coverability tree to explain why a net is unbounded.
COVERABILITY_NODES = 2_000


@dataclass(frozen=True)
class StateSpace:
    """Exact figures of a state space; None: an engine cannot count it.

    Attributes
    ----------
    places, transitions : int
        Size of the net explored.
    states, arcs, deadlocks : int or None
        Reachable markings, arcs between them, and deadlocks; for an incomplete exploration, the counts so
        far.
    max_tokens_in_place, max_tokens_in_marking : int or None
        The largest number of tokens of a place, and of a whole marking.
    engine : str
        The engine that answered.
    complete : bool
        Whether all markings were counted.
    reason : str
        Why not: memory, an unbounded net.
    seconds : float
        Wall-clock time, including the search for a variable order.
    peak_memory_bytes : int
        Peak memory of the process so far.
    pumping : Pumping or None
        For an unbounded net, a sequence that makes places grow forever. Then there are no counts, since there
        are infinitely many markings.
    without : tuple of str
        For an unbounded net: the places from which no transition takes tokens and that no invariant bounds,
        such as counters and logs.
    rest : StateSpace or None
        The figures without those: of the net in which they are removed, or limited to the largest number with
        which a transition compares them. It has the same runs; the most tokens are counted only if all are
        removed.
    levels : tuple of tuple of str
        Groups of places by level, if decision diagrams were used.
    reduced_states : int or None
        Markings of the reduced net, if the net was reduced for counting.
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

    ``auto`` uses decision diagrams, in parallel with the explicit engine if they take long, and the explicit
    engine alone if bounds of places are unknown. In an unbounded net with counters and logs, it counts the
    net without them.

    Parameters
    ----------
    net : CompiledNet
        The net.
    engine : {"auto", "explicit", "symbolic", "tina"}
        The engine; ``tina`` is TINA of LAAS, if it is on the PATH.
    budget : Budget, optional
        Budget. TINA uses only its time.
    orders : OrderCache, optional
        Stored variable orders for the symbolic engine.
    order : {"breadth-first", "depth-first"}
        Order of the explicit engine.

    Raises
    ------
    TinaError
        TINA is not available, or failed.
    BudgetError
        Memory was exhausted before anything was counted.
    """
    task = Counting(net, budget.begun(), time.perf_counter(), orders, order)
    return _with_rest(task, COUNTERS[engine].count(task), engine)


def unfinished(net: CompiledNet, engine: str, states: int | None, reason: str, seconds: float) -> StateSpace:
    """Return the figures of an unfinished count, with the number of markings so far if it is known."""
    began = time.perf_counter() - seconds
    return figures_of(net, engine, began, (states, None, None), reason=reason)


def differences(net: CompiledNet, counts: TinaCounts, budget: Budget = UNLIMITED) -> list[str]:
    """Compare TINA's counts with those of an own engine; one line for each difference.

    Raises
    ------
    TinaError
        The engine could not count everything within its memory.
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


@dataclass(frozen=True)
class Counting:
    """A net to count, the budget, and the start time."""

    net: CompiledNet
    budget: Budget
    began: float
    orders: OrderCache | None
    order: Order

    def within(self, budget: Budget) -> Counting:
        """Return the same task with another budget."""
        return replace(self, budget=budget)

    def nothing(self, engine: str, reason: str) -> StateSpace:
        """Return figures without counts, with the reason."""
        return figures_of(self.net, engine, self.began, reason=reason)


class Counter(ABC):
    """Counts state spaces. A new one is a subclass, and is entered in `COUNTERS`."""

    @abstractmethod
    def count(self, task: Counting) -> StateSpace:
        """Count; raises as `state_space` does."""


class _Automatic(Counter):
    """Diagrams, in parallel with explicit search if they take long; search alone without bounds."""

    def count(self, task: Counting) -> StateSpace:
        from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError

        try:
            found = first_of_two(
                [
                    Member(lambda share: _by_diagrams(task.within(share)), head_start=HEAD_START),
                    Member(lambda share: _by_search(task.within(share))),
                ],
                task.budget,
                lambda space: space.complete or space.pumping is not None,
                alone=HEAD_START,
            )
        except (UnknownBoundError, LevelSizeError):
            return _by_search(task)
        if found is None:
            task.budget.check_time()
            raise BudgetExceededError("no engine has given an answer")
        return found


class _Explicit(Counter):
    """Explicit search."""

    def count(self, task: Counting) -> StateSpace:
        return _by_search(task)


class _Symbolic(Counter):
    """Decision diagrams."""

    def count(self, task: Counting) -> StateSpace:
        from dineros.analysis.symbolic.levels import UnknownBoundError

        try:
            return _by_diagrams(task)
        except UnknownBoundError as error:
            return task.nothing("symbolic", str(error))


class _Tina(Counter):
    """TINA of LAAS, if it is on the PATH; it uses only the time of the budget."""

    def count(self, task: Counting) -> StateSpace:
        from dineros.analysis.tina import TinaBudgetError, count

        try:
            counts = count(task.net, task.budget)
        except TinaBudgetError as limit:
            return task.nothing("tina", limit.why)
        if not counts.is_bounded:
            return task.nothing("tina", "unbounded")
        return figures_of(task.net, "tina", task.began, (counts.states, counts.arcs, counts.deadlocks))


COUNTERS: dict[Engine, Counter] = {
    "auto": _Automatic(),
    "explicit": _Explicit(),
    "symbolic": _Symbolic(),
    "tina": _Tina(),
}
"""By name, the value of `--engine`."""


def _by_diagrams(task: Counting) -> StateSpace:
    from dineros.analysis.symbolic.engine import symbolic_state_space

    budget = task.budget
    try:
        space = symbolic_state_space(task.net, budget, orders=task.orders)
        if not space.complete:
            return task.nothing("symbolic", RAN_OUT[space.reason])
        states = space.markings
    except BudgetExceededError as limit:
        return task.nothing("symbolic", str(limit))
    try:
        budget.stage("counting arcs, deadlocks and tokens")
        space.sets.budget = budget
        counts = states, space.arcs(), space.deadlocks()
    except BudgetExceededError as limit:
        reason = f"{limit}; these are all states, and the rest is not counted"
        return figures_of(task.net, "symbolic", task.began, (states, None, None), reason=reason)
    tokens = max(space.largest_place(), default=0), space.largest_total()
    return replace(figures_of(task.net, "symbolic", task.began, counts, tokens), levels=space.order)


def _by_search(task: Counting) -> StateSpace:
    from dineros.analysis.explicit import explore
    from dineros.analysis.nets.coverability import coverability

    net = task.net
    space = explore(net, task.budget.share(most_bytes=task.budget.memory), order=task.order)
    if space.pumping is not None:
        # The search has found a proof; the coverability tree often has a shorter one.
        others = coverability(net, COVERABILITY_NODES).pumping
        pumping = min(
            [space.pumping, *([others] if others else [])], key=lambda p: len(p.prefix) + len(p.suffix)
        )
        grown = ", ".join(net.places[place] for place in pumping.places)
        return replace(task.nothing("explicit", f"unbounded: {grown} can grow forever"), pumping=pumping)
    counts = space.markings, space.arcs, space.deadlocks
    tokens = max(space.largest_place, default=0), space.largest_total
    reason = "" if space.complete else RAN_OUT.get(space.reason or "", space.reason or "unknown")
    return figures_of(net, "explicit", task.began, counts, tokens, reason)


def _with_rest(task: Counting, space: StateSpace, engine: Engine) -> StateSpace:
    """Count an unbounded net without its counters and logs, if it has any."""
    if space.pumping is None:
        return space
    from dineros.analysis.covering.growing import growing_places, largest_weights, limited
    from dineros.analysis.nets.bounds import place_bounds

    net, budget = task.net, task.budget
    bounds, weights = place_bounds(net), largest_weights(net)
    limits = {place: weights[place] for place in growing_places(net) if bounds[place] is None}
    if not limits:
        return space
    budget.stage("the net without places that only grow")
    smaller = limited(net, limits).net
    began = time.perf_counter()
    try:
        rest = state_space(smaller, engine, budget, task.orders, task.order)
    except BudgetExceededError as limit:
        rest = figures_of(smaller, engine, began, reason=str(limit))
    if any(limits.values()):
        # Some places are complements, whose tokens represent free room.
        rest = replace(rest, max_tokens_in_place=None, max_tokens_in_marking=None)
    return replace(space, without=tuple(net.places[place] for place in limits), rest=rest)


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
