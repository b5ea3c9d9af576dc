"""Explicit engine: exact state spaces and witnesses by search over packed markings.

Numba is imported by the functions that search, not by this module.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Unpack

import numpy as np

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit.answers import ExplicitStateSpace, Options
from dineros.analysis.explicit.goals import Goal
from dineros.analysis.explicit.guidance import Guidance, guidance
from dineros.analysis.explicit.layout import layout
from dineros.analysis.nets.compiled import CompiledNet, Int64Array
from dineros.analysis.nets.memory import DEFAULT_SHARE, free_memory
from dineros.analysis.nets.witness import WitnessError, replay

if TYPE_CHECKING:
    from dineros.analysis.explicit.search import Search

NO_END = 1 << 60

NEAR = 5_000
"""Number of markings of an unguided search for a goal: it takes milliseconds."""


def explore(net: CompiledNet, budget: Budget = UNLIMITED, **options: Unpack[Options]) -> ExplicitStateSpace:
    """Count the reachable markings.

    Parameters
    ----------
    **options
        See `Options`.

    Examples
    --------
    >>> net = CompiledNet.build({"idle": 2, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})])
    >>> space = explore(net)
    >>> space.markings, space.arcs, space.deadlocks, space.largest_place
    (3, 2, 1, (2, 2))
    """
    search = _search(net, (), budget, options)
    search.run()
    places, total = search.largest()
    return ExplicitStateSpace(
        search.markings,
        search.arcs,
        search.deadlocks,
        places,
        total,
        search.enabled_somewhere(),
        search.reason is None,
        search.reason,
        search.memory,
        search.pumping,
    )


def count_marked(net: CompiledNet, place: str, budget: Budget = UNLIMITED) -> tuple[int | None, str]:
    """Count the reachable markings in which a place is marked; None and a reason if a limit was exceeded."""
    search = _search(net, (), budget, {})
    search.run()
    if search.reason is not None:
        return None, search.reason
    return search.count_marked(net.places.index(place)), ""


def all_marked(
    net: CompiledNet, place: str, places: Sequence[str], budget: Budget = UNLIMITED
) -> tuple[Int64Array, frozenset[str]]:
    """Return the markings in which a place is marked, and the transitions enabled in any marking.

    Parameters
    ----------
    places
        Places whose tokens are returned.

    Returns
    -------
    markings : int64 array, shape (markings, places)
        Each combination of tokens once, sorted.
    enabled : frozenset of str
        Transitions that are enabled in any marking of the net.

    Raises
    ------
    BudgetExceededError
        A limit was exceeded before all markings were found.
    """
    search = _search(net, (), budget, {})
    search.run()
    if search.reason is not None:
        raise BudgetExceededError(search.reason)
    index = {name: position for position, name in enumerate(net.places)}
    parts = list(search.marked(index[place], [index[name] for name in places]))
    markings = np.unique(np.concatenate([np.zeros((0, len(places)), dtype=np.int64), *parts]), axis=0)
    enabled = frozenset(np.array(net.transitions, dtype=object)[search.enabled_somewhere()].tolist())
    return markings, enabled


def find(net: CompiledNet, goal: Goal, budget: Budget = UNLIMITED, **options: Unpack[Options]) -> Outcome:
    """Search for a witness of a goal, a shortest one unless depth first; budget and options as for `explore`.

    Breadth first, distant goals are searched for with guidance, which needs a fraction of the markings. If
    the search for a shorter one then exceeds time or memory, the witness may be a few steps longer.

    Examples
    --------
    >>> net = CompiledNet.build({"idle": 2, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})])
    >>> find(net, Goal.where(net, [({"busy": 1}, ">=", 2)]))
    Outcome(status='reachable', trace=(0, 0), ...)
    >>> find(net, Goal.where(net, [({"busy": 1}, ">", 2)])).status
    'unreachable'
    """
    budget = budget.begun()
    is_led = options.get("order") != "depth-first" and options.get("reduction") is None
    if is_led and net.once(layout).is_bounded and (budget.states is None or budget.states > NEAR):
        alone: Options = {**options, "workers": 1}
        near = find_all(net, [goal], budget.share(most_states=NEAR), **alone)[0]
        if near.reason != "states":
            return near
        budget.stage("a bound on the length of ways")
        known = guidance(net, goal)
        if known is not None:
            return _find_guided(net, goal, known, budget, options)
    return find_all(net, [goal], budget, **options)[0]


def _find_guided(net: CompiledNet, goal: Goal, known: Guidance, budget: Budget, options: Options) -> Outcome:
    """Search with guidance by a bound, and then for a shorter trace than the one found.

    The marking of the goal that is found first is the cheapest. A trace to it is a shortest one, unless the
    bound is below 0 there: then a more expensive trace, with a bound less far below 0, may be shorter.
    """
    best: Outcome | None = None
    wanted, most_cost = goal, None
    at_first = known.bound(net.initial.tolist())
    while True:
        search = _search(net, [wanted], budget, options, known, most_cost)
        search.run()
        if 0 not in search.found:
            return best or _not_found(search)
        found = _witness(net, wanted, search.trace(search.found[0]))
        del search  # release the memory of its markings for the next search
        best = found if best is None or len(found.stem) < len(best.stem) else best
        excess = -known.bound(replay(net, found.stem)[-1])
        if excess <= 0 or not options.get("is_shortest", True):
            return best
        wanted, most_cost = known.nearer(excess), known.unit * len(best.stem) - at_first - 1


def find_all(
    net: CompiledNet, goals: Sequence[Goal], budget: Budget = UNLIMITED, **options: Unpack[Options]
) -> list[Outcome]:
    """Search for several goals at once, until each is found; budget and options as for `explore`.

    An unknown answer has one of the reasons in `ExplicitStateSpace`.

    Raises
    ------
    WitnessError
        A witness cannot be replayed: an error in the engine, never a wrong answer.
    """
    if not goals:
        return []
    search = _search(net, goals, budget, options)
    search.run()
    answers: list[Outcome] = []
    for g, goal in enumerate(goals):
        if g in search.found:
            answers.append(_witness(net, goal, search.trace(search.found[g])))
        else:
            answers.append(_not_found(search))
    return answers


def _not_found(search: Search) -> Outcome:
    if search.reason is None:
        return Outcome("unreachable", states=search.markings)
    return Outcome("unknown", states=search.markings, reason=search.reason)


def _search(
    net: CompiledNet,
    goals: Sequence[Goal],
    budget: Budget,
    options: Options,
    known: Guidance | None = None,
    most_cost: int | None = None,
) -> Search:
    from dineros.analysis.explicit.search import Search

    workers = options.get("workers")
    if budget.memory_bytes is None:
        budget = budget.share(most_bytes=int(free_memory() * DEFAULT_SHARE))
    return Search(
        net,
        goals,
        budget.begun(),
        budget.workers if workers is None else workers,
        options.get("order", "breadth-first") == "depth-first",
        options.get("reduction") is not None,
        options.get("most_if_unbounded", NO_END) if goals else 0,
        known,
        most_cost,
    )


def _witness(net: CompiledNet, goal: Goal, trace: tuple[int, ...]) -> Outcome:
    if not goal.holds(net, replay(net, trace)[-1]):
        raise WitnessError("a witness does not reach its goal")
    return Outcome("reachable", trace)
