"""Explicit engine: exact state spaces and witnesses by search over packed markings.

Numba is imported by the functions that search, not by this module.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Unpack

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit.answers import ExplicitStateSpace, Options
from dineros.analysis.explicit.goals import Goal
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.memory import DEFAULT_SHARE, free_memory
from dineros.analysis.nets.witness import WitnessError, replay

if TYPE_CHECKING:
    from dineros.analysis.explicit.search import Search

NO_END = 1 << 60


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


def find(net: CompiledNet, goal: Goal, budget: Budget = UNLIMITED, **options: Unpack[Options]) -> Outcome:
    """Search a witness of a goal, a shortest one unless depth first; budget and options as for `explore`.

    Examples
    --------
    >>> net = CompiledNet.build({"idle": 2, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})])
    >>> find(net, Goal.where(net, [({"busy": 1}, ">=", 2)]))
    Outcome(status='reachable', trace=(0, 0), ...)
    >>> find(net, Goal.where(net, [({"busy": 1}, ">", 2)])).status
    'unreachable'
    """
    return find_all(net, [goal], budget, **options)[0]


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
        elif search.reason is None:
            answers.append(Outcome("unreachable", states=search.markings))
        else:
            answers.append(Outcome("unknown", states=search.markings, reason=search.reason))
    return answers


def _search(net: CompiledNet, goals: Sequence[Goal], budget: Budget, options: Options) -> Search:
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
    )


def _witness(net: CompiledNet, goal: Goal, trace: tuple[int, ...]) -> Outcome:
    if not goal.holds(net, replay(net, trace)[-1]):
        raise WitnessError("a witness does not reach its goal")
    return Outcome("reachable", trace)
