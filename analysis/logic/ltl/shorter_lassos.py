"""Shorter counterexamples: the part of a product near its initial state, searched in order of distance.

Depth-first search often finds an accepting run soon, but far away. A second, small search in order of
distance is worth its time if a person has to read the result.
"""

from __future__ import annotations

from itertools import islice

import numpy as np

from dineros.analysis.answers.budget import BudgetExceededError
from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.kernels.stored import COMPLETE, OVERFLOW, PAUSED, STORE_FULL, build
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
        expanded = _explore(product, most_states, len(run.stem) + len(run.loop) + 1)
    except BudgetExceededError:
        return run
    graph = InnerGraph.of(product, np.arange(expanded, dtype=np.int32))
    required = product.conditions.required
    found = [run]
    for component in islice(graph.components(required), CHOICES):
        part = component.accepting_part(required)
        if part is not None:
            found.append(find_run(product, part))
    return min(found, key=lambda candidate: (len(candidate.stem) + len(candidate.loop), len(candidate.stem)))


def _explore(product: Product, limit: int, levels: int) -> int:
    """Expand the states of the first levels, breadth first up to a limit; return their number."""
    pointer = np.zeros(limit + 2, dtype=np.int64)
    targets = np.empty(1 << 16 | 2 * product.room, dtype=np.int32)
    labels = np.empty(product.room, dtype=np.int32)
    state, status = 0, PAUSED
    end = 1  # of the level
    while status != COMPLETE and state < limit:
        if state == end:
            levels, end = levels - 1, product.states
            if levels == 0:
                break
        # Only the states are needed here, not their arcs: each call overwrites them.
        pointer[state] = 0
        status, state = build(
            *product.parts,
            pointer,
            targets,
            labels,
            state,
            min(limit, end) - state,
        )
        if status == STORE_FULL:
            product.grow()
        elif status == OVERFLOW:
            product.widen()
    return int(state)
