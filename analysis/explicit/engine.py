"""Explicit engine: exact state spaces and witnesses by search over packed markings.

Numba is imported by the functions that search, not by this module.
"""

from __future__ import annotations

import os
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
"""Markings in which a goal is looked for without guidance: that takes milliseconds."""


def explore(net: CompiledNet, budget: Budget = UNLIMITED, **options: Unpack[Options]) -> ExplicitStateSpace:
    """Count what is reachable.

    Parameters
    ----------
    net
        The net.
    budget
        Limits; a share of the free memory unless one is given.
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
    """Count the reachable markings in which a place holds tokens; None, and why, where a limit is hit."""
    search = _search(net, (), budget, {})
    search.run()
    if search.reason is not None:
        return None, search.reason
    return search.count_marked(net.places.index(place)), ""


def all_marked(
    net: CompiledNet, place: str, places: Sequence[str], budget: Budget = UNLIMITED
) -> tuple[Int64Array, frozenset[str]]:
    """Return the markings in which a place holds tokens, and what some marking enables.

    Parameters
    ----------
    net, place, budget
        The net, the place, and limits.
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
        A limit was hit before all markings were found.
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
    """Search a witness of a goal, a shortest one unless depth first; budget and options as for `explore`.

    Breadth first, what is not near is searched for with guidance, which needs a fraction of the markings.
    Where time or memory then ends the search for a shorter one, a witness may be longer by a few steps.

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
    """Search where a bound leads, and then for what is shorter than what was found.

    The marking of a goal that is met first is the cheapest. A way to it is a shortest one, unless the bound
    is below 0 there: then another may be shorter that costs more and goes less far below.
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
        del search  # its markings make room for those of the next one
        best = found if best is None or len(found.stem) < len(best.stem) else best
        excess = -known.bound(replay(net, found.stem)[-1])
        if excess <= 0 or not options.get("is_shortest", True):
            return best
        wanted, most_cost = known.nearer(excess), known.unit * len(best.stem) - at_first - 1


def find_all(
    net: CompiledNet, goals: Sequence[Goal], budget: Budget = UNLIMITED, **options: Unpack[Options]
) -> list[Outcome]:
    """Search for several goals at once, until each is found; budget and options as for `explore`.

    Unknown answers have one of the reasons of `ExplicitStateSpace`.

    Raises
    ------
    WitnessError
        If a witness does not replay: an error in the engine, never a wrong answer.
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
    if workers is None:
        workers = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return Search(
        net,
        goals,
        budget.begun(),
        workers,
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
