"""Explicit engine: exact state spaces and shortest witnesses by breadth-first search over packed markings.

Numba is imported by the functions that search, not by this module.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.compiled import CompiledNet
from dineros.analysis.coverability import Pumping
from dineros.analysis.explicit_goals import Comparison, Goal
from dineros.analysis.explicit_memory import DEFAULT_SHARE, free_memory
from dineros.analysis.witness import WitnessError, replay

if TYPE_CHECKING:
    from dineros.analysis.explicit_search import Search

#: Called about twice a second with markings, markings a second and bytes; may raise KeyboardInterrupt to
#: stop.
Progress = Callable[[int, float, int], None]
Reduction = Literal["stubborn"]


@dataclass(frozen=True)
class ExplicitStateSpace:
    """What an exploration saw; exact for the net when `complete` and nothing was reduced.

    Attributes
    ----------
    markings, arcs, deadlocks : int
        Reachable markings, firings (pairs of a marking and an enabled transition), markings that enable
        nothing.
    largest_place : tuple of int
        By place: the most tokens in any marking.
    largest_total : int
        The most tokens in all places together in any marking.
    enabled : bool array
        By transition: whether some marking enables it.
    complete : bool
        Whether everything was seen.
    reason : str, optional
        What ended an incomplete exploration: ``memory``, ``states``, ``time``, ``unbounded`` or
        ``interrupted``.
    seconds : float
    memory : int
        Bytes of markings and tables at the end.
    rate : float
        Markings a second.
    pumping : Pumping, optional
        Where unbounded: the proof.
    reduction : str, optional
        ``stubborn`` if only stubborn sets were fired: then the figures are of the reduced graph.
    """

    markings: int
    arcs: int
    deadlocks: int
    largest_place: tuple[int, ...]
    largest_total: int
    enabled: NDArray[np.bool_]
    complete: bool
    reason: str | None
    seconds: float
    memory: int
    rate: float
    pumping: Pumping | None = None
    reduction: Reduction | None = None


@dataclass(frozen=True)
class Found:
    """A shortest way to the goal, already replayed: transitions, and the marking they lead to."""

    trace: tuple[int, ...]
    marking: tuple[int, ...]


@dataclass(frozen=True)
class Unreachable:
    """A proof by exhaustion: none of the markings that had to be looked at, `states` in number, is one."""

    states: int


@dataclass(frozen=True)
class Unknown:
    """The search ended early, and why; `states` markings were seen."""

    reason: str
    states: int


Answer = Found | Unreachable | Unknown


def explore(
    net: CompiledNet,
    *,
    memory: int | None = None,
    states: int | None = None,
    seconds: float | None = None,
    workers: int | None = None,
    reduction: Reduction | None = None,
    progress: Progress | None = None,
) -> ExplicitStateSpace:
    """Count what is reachable.

    Parameters
    ----------
    net
        The net.
    memory
        Bytes for markings and tables; a share of the free memory unless given.
    states, seconds
        Limits.
    workers
        Threads; as many as there are processors unless given.
    reduction
        ``stubborn`` keeps the deadlocks only.
    progress
        Called about twice a second.

    Examples
    --------
    >>> net = CompiledNet.build({"idle": 2, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})])
    >>> space = explore(net)
    >>> space.markings, space.arcs, space.deadlocks, space.largest_place
    (3, 2, 1, (2, 2))
    """
    search = _search(net, (), memory, states, seconds, workers, reduction, progress)
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
        reduction,
    )


def find(
    net: CompiledNet,
    goal: Goal,
    *,
    memory: int | None = None,
    states: int | None = None,
    seconds: float | None = None,
    workers: int | None = None,
    reduction: Reduction | None = None,
    progress: Progress | None = None,
) -> Answer:
    """Search a shortest witness of a goal; parameters as for `explore`.

    Examples
    --------
    >>> net = CompiledNet.build({"idle": 2, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})])
    >>> find(net, Goal.where(net, [({"busy": 1}, ">=", 2)]))
    Found(trace=(0, 0), marking=(0, 2))
    >>> find(net, Goal.where(net, [({"busy": 1}, ">", 2)]))
    Unreachable(states=3)
    """
    return find_all(
        net,
        [goal],
        memory=memory,
        states=states,
        seconds=seconds,
        workers=workers,
        reduction=reduction,
        progress=progress,
    )[0]


def find_all(
    net: CompiledNet,
    goals: Sequence[Goal],
    *,
    memory: int | None = None,
    states: int | None = None,
    seconds: float | None = None,
    workers: int | None = None,
    reduction: Reduction | None = None,
    progress: Progress | None = None,
) -> list[Answer]:
    """Search for several goals at once, until each is found; parameters as for `explore`.

    Raises
    ------
    WitnessError
        If a witness does not replay: an error in the engine, never a wrong answer.
    """
    if not goals:
        return []
    search = _search(net, goals, memory, states, seconds, workers, reduction, progress)
    search.run()
    answers: list[Answer] = []
    for g, goal in enumerate(goals):
        if g in search.found:
            answers.append(_witness(net, goal, search.trace(*search.found[g])))
        elif search.reason is None:
            answers.append(Unreachable(search.markings))
        else:
            answers.append(Unknown(search.reason, search.markings))
    return answers


def enabled_anywhere(
    net: CompiledNet,
    *,
    memory: int | None = None,
    states: int | None = None,
    seconds: float | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> NDArray[np.bool_] | Unknown:
    """By transition: whether some reachable marking enables it; the others are dead.

    Stops as soon as every transition was enabled once.
    """
    goals = [Goal((t,)) for t in range(len(net.transitions))]
    answer = np.zeros(len(goals), dtype=np.bool_)
    if not goals:
        return answer
    search = _search(net, goals, memory, states, seconds, workers, None, progress, keeps_parents=False)
    search.run()
    if search.reason not in (None, "goal"):
        return Unknown(str(search.reason), search.markings)
    answer[sorted(search.found)] = True
    return answer


def _search(
    net: CompiledNet,
    goals: Sequence[Goal],
    memory: int | None,
    states: int | None,
    seconds: float | None,
    workers: int | None,
    reduction: Reduction | None,
    progress: Progress | None,
    keeps_parents: bool = True,
) -> Search:
    from dineros.analysis.explicit_search import Limits, Search

    if memory is None:
        memory = int(free_memory() * DEFAULT_SHARE)
    if workers is None:
        workers = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return Search(
        net,
        goals,
        Limits(memory, states, seconds, progress),
        workers,
        reduction is not None,
        bool(goals) and keeps_parents,
        not goals,
    )


def _witness(net: CompiledNet, goal: Goal, trace: tuple[int, ...]) -> Found:
    marking = replay(net, trace)[-1]
    if not goal.holds(net, marking):
        raise WitnessError("a witness does not reach its goal")
    return Found(trace, tuple(marking))


__all__ = [
    "Answer",
    "Comparison",
    "ExplicitStateSpace",
    "Found",
    "Goal",
    "Progress",
    "Unknown",
    "Unreachable",
    "enabled_anywhere",
    "explore",
    "find",
    "find_all",
]
