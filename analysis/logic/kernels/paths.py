"""Kernels on the stored part of a product: shortest paths, and edges.

All but `edges_from` store nothing: edges to new states are ignored, so that they examine exactly the part
that a search has stored.
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.logic.kernels.product import MAY_ADD, STATES, expand
from dineros.analysis.nets.kernel_cache import kernel

DONE, STORE_FULL, ARCS_FULL, OVERFLOW = range(4)


@kernel()
def shortest_path(  # type: ignore[no-untyped-def]
    steps, conditions, edges, store, scratch, start, allowed, goal, wanted, parents, labels, queue, targets,
    new_labels
):  # fmt: skip
    """Breadth-first search from a state over stored, allowed states to the first edge that reaches a goal.

    A goal is a state with ``goal`` set, or an edge or a target with a mark in `wanted`. `parents` must be
    filled with -1. Returns the edge's source, or -1 if there is none; its target and label are in
    ``new_labels[-2:]``. The path to the source follows from `parents`, where the start has itself as its
    parent.
    """
    store.counters[MAY_ADD] = 0
    width = edges.target.size
    queue[0] = start
    parents[start] = start
    head, tail = 0, 1
    while head < tail:
        state = np.int64(queue[head])
        head += 1
        top = expand(steps, conditions, edges, store, scratch, state, targets, new_labels, np.int64(0))
        for k in range(top):
            target, label = targets[k], new_labels[k]
            if not allowed[target]:
                continue
            t, e = label // width, label % width
            found = goal[target]
            for m in range(wanted.size):
                marks = conditions.weak_marks[t, m] | conditions.strong_marks[t, m]
                marks |= edges.marks[e, m]
                if wanted[m] & (marks | scratch.weak_seen[m]) != 0:
                    found = True
            if found:
                new_labels[-2] = target
                new_labels[-1] = label
                return state
            if parents[target] < 0:
                parents[target] = state
                labels[target] = label
                queue[tail] = target
                tail += 1
    return np.int64(-1)


@kernel()
def inner_edges(  # type: ignore[no-untyped-def]
    steps, conditions, edges, store, scratch, states, first, number, sources, targets, labels, weak, strong
):  # fmt: skip
    """List the edges between the given states, from position `first` on, as far as there is room.

    `number` has the position of each state in `states`, or -1. Returns the position to continue from and the
    number of edges written.
    """
    store.counters[MAY_ADD] = 0
    room = scratch.enabled.size * scratch.candidates.size
    top = 0
    position = first
    while position < states.size and top + room <= targets.size:
        state = np.int64(states[position])
        end = expand(steps, conditions, edges, store, scratch, state, targets, labels, top)
        for m in range(scratch.weak_seen.size):
            weak[position, m] = scratch.weak_seen[m]
            strong[position, m] = scratch.strong_seen[m]
        kept = top
        for k in range(top, end):
            inside = number[targets[k]]
            if inside >= 0:
                sources[kept] = position
                targets[kept] = inside
                labels[kept] = labels[k]
                kept += 1
        top = kept
        position += 1
    return position, top


@kernel()
def edges_from(  # type: ignore[no-untyped-def]
    steps, conditions, edges, store, scratch, first, end, sources, targets, labels, weak, strong
):  # fmt: skip
    """List the edges of the states from `first` up to `end`, and store their successors.

    Returns a status, the state to continue from, and the number of edges written.
    """
    store.counters[MAY_ADD] = 1
    room = scratch.enabled.size * scratch.candidates.size
    state, top = np.int64(first), np.int64(0)
    while state < end:
        if store.counters[STATES] + room > store.words.shape[0] or (
            2 * (store.counters[STATES] + room) > store.table.size
        ):
            return STORE_FULL, state, top
        if top + room > targets.size:
            return ARCS_FULL, state, top
        after = expand(steps, conditions, edges, store, scratch, state, targets, labels, top)
        if after < 0:
            return OVERFLOW, state, top
        for m in range(scratch.weak_seen.size):
            weak[state, m] = scratch.weak_seen[m]
            strong[state, m] = scratch.strong_seen[m]
        for k in range(top, after):
            sources[k] = state
        top = after
        state += 1
    return DONE, state, top
