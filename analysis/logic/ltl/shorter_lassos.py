"""Shorter counterexamples: the part of a product near its initial state, searched in order of distance.

Depth-first search often finds an accepting run soon, but far away. A second, small search in order of
distance is worth its time if a person has to read the result.
"""

from __future__ import annotations

from itertools import islice

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import BudgetExceededError
from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.kernels.paths import OVERFLOW, STORE_FULL, edges_from
from dineros.analysis.logic.ltl.fairness import InnerGraph
from dineros.analysis.logic.ltl.lassos import ProductRun, find_run

CHOICES = 3
"""Number of nearest accepting components for which a run is made."""


def shortened(run: ProductRun, product: Product, most_states: int) -> ProductRun:
    """Return an accepting run that is as short as a limited search finds, or the given one.

    Parameters
    ----------
    product : Product
        The same product, with only its initial state stored.
    """
    try:
        # A run of this length reaches no state that is farther away. One more step: a deadlock is repeated.
        graph = _near(product, most_states, len(run.stem) + len(run.loop) + 1)
    except BudgetExceededError:
        return run
    required = product.conditions.required
    found = [run]
    for component in islice(graph.components(required), CHOICES):
        part = component.accepting_part(required)
        if part is not None:
            found.append(find_run(product, part))
    return min(found, key=lambda candidate: (len(candidate.stem) + len(candidate.loop), len(candidate.stem)))


def _near(product: Product, limit: int, levels: int) -> InnerGraph:
    """Return the graph of the states of the first levels, breadth first up to a limit."""
    words = product.conditions.required.size
    disabled, asked = (np.empty((limit, words), dtype=np.int64) for _ in range(2))
    buffers = [np.empty(product.room + (1 << 16), dtype=np.int32) for _ in range(3)]
    parts: list[list[NDArray[np.int32]]] = []
    state = 0
    end = 1  # of the level
    while state < min(limit, product.states):
        if state == end:
            levels, end = levels - 1, product.states
            if levels == 0:
                break
        product.budget.check_memory(
            product.memory_bytes + sum(array.nbytes for part in parts for array in part)
        )
        status, state, count = edges_from(*product.parts, state, min(limit, end), *buffers, disabled, asked)
        parts.append([buffer[:count].copy() for buffer in buffers])
        if status == STORE_FULL:
            product.grow()
        elif status == OVERFLOW:
            product.widen()
    sources, targets, labels = (np.concatenate(column) for column in zip(*parts, strict=True))
    inside = targets < state
    return InnerGraph(
        np.arange(state, dtype=np.int32),
        sources[inside],
        targets[inside],
        product.marks_of(labels[inside]),
        disabled[:state],
        asked[:state],
    )
