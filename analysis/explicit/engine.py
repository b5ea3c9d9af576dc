"""Explicit engine: exact state spaces and witnesses by search over packed markings.

Numba is imported by the functions that search, not by this module.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Unpack

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.explicit.answers import Answer, ExplicitStateSpace, Found, Options, Unknown, Unreachable
from dineros.analysis.explicit.goals import Goal
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.memory import DEFAULT_SHARE, free_memory
from dineros.analysis.nets.witness import WitnessError, replay

if TYPE_CHECKING:
    from dineros.analysis.explicit.search import Search


def explore(net: CompiledNet, **options: Unpack[Options]) -> ExplicitStateSpace:
    """Count what is reachable.

    Parameters
    ----------
    net
        The net.
    **options
        See `Options`.

    Examples
    --------
    >>> net = CompiledNet.build({"idle": 2, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})])
    >>> space = explore(net)
    >>> space.markings, space.arcs, space.deadlocks, space.largest_place
    (3, 2, 1, (2, 2))
    """
    search = _search(net, (), options)
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
        search.seconds,
        search.memory,
        search.markings / max(search.seconds, 1e-9),
        search.pumping,
        options.get("reduction"),
    )


def find(net: CompiledNet, goal: Goal, **options: Unpack[Options]) -> Answer:
    """Search a witness of a goal, a shortest one unless depth first; options as for `explore`.

    Examples
    --------
    >>> net = CompiledNet.build({"idle": 2, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})])
    >>> find(net, Goal.where(net, [({"busy": 1}, ">=", 2)]))
    Found(trace=(0, 0), marking=(0, 2))
    >>> find(net, Goal.where(net, [({"busy": 1}, ">", 2)]))
    Unreachable(states=3)
    """
    return find_all(net, [goal], **options)[0]


def find_all(net: CompiledNet, goals: Sequence[Goal], **options: Unpack[Options]) -> list[Answer]:
    """Search for several goals at once, until each is found; options as for `explore`.

    Raises
    ------
    WitnessError
        If a witness does not replay: an error in the engine, never a wrong answer.
    """
    if not goals:
        return []
    search = _search(net, goals, options)
    search.run()
    answers: list[Answer] = []
    for g, goal in enumerate(goals):
        if g in search.found:
            answers.append(_witness(net, goal, search.trace(search.found[g])))
        elif search.reason is None:
            answers.append(Unreachable(search.markings))
        else:
            answers.append(Unknown(search.reason, search.markings))
    return answers


def enabled_anywhere(net: CompiledNet, **options: Unpack[Options]) -> NDArray[np.bool_] | Unknown:
    """By transition: whether some reachable marking enables it; the others are dead.

    Stops as soon as every transition was enabled once.
    """
    goals = [Goal((t,)) for t in range(len(net.transitions))]
    answer = np.zeros(len(goals), dtype=np.bool_)
    if not goals:
        return answer
    search = _search(net, goals, options, keeps_parents=False)
    search.run()
    if search.reason not in (None, "goal"):
        return Unknown(str(search.reason), search.markings)
    answer[sorted(search.found)] = True
    return answer


def _search(net: CompiledNet, goals: Sequence[Goal], options: Options, keeps_parents: bool = True) -> Search:
    from dineros.analysis.explicit.search import Limits, Search

    memory, workers = options.get("memory"), options.get("workers")
    if memory is None:
        memory = int(free_memory() * DEFAULT_SHARE)
    if workers is None:
        workers = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return Search(
        net,
        goals,
        Limits(memory, options.get("states"), options.get("seconds"), options.get("progress")),
        workers,
        options.get("order", "breadth-first") == "depth-first",
        options.get("reduction") is not None,
        bool(goals) and keeps_parents,
        not goals,
    )


def _witness(net: CompiledNet, goal: Goal, trace: tuple[int, ...]) -> Found:
    marking = replay(net, trace)[-1]
    if not goal.holds(net, marking):
        raise WitnessError("a witness does not reach its goal")
    return Found(trace, tuple(marking))
