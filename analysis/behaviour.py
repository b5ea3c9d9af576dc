"""Liveness, reversibility and home markings, by the strongly connected components of the reachability graph.

A net is live iff every terminal component fires every transition, reversible iff there is one component only,
and has home markings iff one component alone is terminal: then they are its markings (Murata, Proc. IEEE
77(4), 1989, Sect. IV).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.compiled import CompiledNet
from dineros.analysis.logic.budget import Budget, BudgetExceededError, Meter
from dineros.analysis.logic.graph import StateGraph


@dataclass(frozen=True)
class Behaviour:
    """What a net can do again and again.

    Attributes
    ----------
    reversible : bool
        Whether the initial marking can be reached from every reachable one.
    home_markings : int
        Number of markings that can be reached from every reachable one.
    not_live : tuple of int
        Transitions that some reachable marking shuts off for ever; none in a live net.
    states : int
        Reachable markings.
    """

    reversible: bool
    home_markings: int
    not_live: tuple[int, ...]
    states: int


def behaviour(
    net: CompiledNet, budget: Budget, progress: Callable[[Any], None] | None = None
) -> Behaviour | str:
    """Decide liveness, reversibility and home markings; a text says why that is not possible.

    Parameters
    ----------
    net : CompiledNet
        A bounded net.
    budget : Budget
        Limits of the search.
    progress : callable, optional
        Told now and then how far it is.
    """
    graph = StateGraph(net, [], Meter(budget, progress))
    try:
        graph.explore()
    except BudgetExceededError as limit:
        return str(limit)
    count, component = _components(graph)
    sources = np.repeat(np.arange(graph.size, dtype=np.int32), np.diff(graph.pointer))
    leaves = component[sources] != component[graph.targets]
    terminal = np.ones(count, dtype=np.bool_)
    terminal[component[sources[leaves]]] = False
    ends = np.flatnonzero(terminal)
    home = int((component == ends[0]).sum()) if ends.size == 1 else 0
    live = set(range(len(net.transitions)))
    for end in ends:
        live &= _fired_in(net, graph, np.flatnonzero(component == end))
    shut_off = tuple(t for t in range(len(net.transitions)) if t not in live)
    return Behaviour(count == 1, home, shut_off, graph.size)


def _components(graph: StateGraph) -> tuple[int, NDArray[np.int32]]:
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(graph.targets.size, dtype=np.int8)
    matrix = csr_matrix((ones, graph.targets, graph.pointer), shape=(graph.size, graph.size))
    count, component = connected_components(matrix, directed=True, connection="strong")
    return int(count), component


def _fired_in(net: CompiledNet, graph: StateGraph, states: NDArray[np.int64]) -> set[int]:
    """Return the transitions that some marking of a terminal component enables: they stay in it."""
    missing = set(range(len(net.transitions)))
    for state in states:
        marking = graph.product.marking(int(state))
        missing -= {transition for transition in missing if net.is_enabled(transition, marking)}
        if not missing:
            break
    return set(range(len(net.transitions))) - missing
