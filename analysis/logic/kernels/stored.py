"""Kernels on stored reachability graphs: building them, and the fixpoints of CTL over predecessor lists.

A graph consists of the markings stored by a `Product`; its edges are stored, too, while the LTL search
discards them: branching-time questions use each of them several times.

References
----------
E. M. Clarke, E. A. Emerson, A. P. Sistla, *Automatic verification of finite-state concurrent systems using
temporal logic specifications*, TOPLAS 8(2), 1986. B. Vergauwen, J. Lewi, *A linear algorithm for solving
fixed-point equations on transition systems*, CAAP 1992, LNCS 581 (counting successors for EG).
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.logic.kernels.product import MAY_ADD, STATES, expand, find_enabled, read_letter
from dineros.analysis.nets.kernel_cache import kernel

COMPLETE, STORE_FULL, ARCS_FULL, OVERFLOW, PAUSED = range(5)


@kernel()
def build(  # type: ignore[no-untyped-def]
    steps, conditions, edges, store, scratch, pointer, targets, labels, first, visits
):  # fmt: skip
    """Expand states in order of discovery, from `first` on; write their successors in CSR form.

    Returns a status and the state to continue from.
    """
    room = steps.delta.shape[0] * scratch.candidates.size
    store.counters[MAY_ADD] = 1
    state = first
    while state < store.counters[STATES]:
        if visits <= 0:
            return PAUSED, state
        if store.counters[STATES] + room > store.words.shape[0] or (
            2 * (store.counters[STATES] + room) > store.table.size
        ):
            return STORE_FULL, state
        if pointer[state] + room > targets.size:
            return ARCS_FULL, state
        top = pointer[state]
        end = expand(steps, conditions, edges, store, scratch, state, targets[top:], labels, np.int64(0))
        if end < 0:
            return OVERFLOW, state
        pointer[state + 1] = top + end
        state += 1
        visits -= 1
    return COMPLETE, state


@kernel()
def letters(steps, conditions, store, scratch, result):  # type: ignore[no-untyped-def]
    """Write the bits of the atoms true in each state."""
    for state in range(store.counters[STATES]):
        count = find_enabled(steps, store, scratch, state)
        read_letter(steps, conditions, store, scratch, state, count)
        for w in range(scratch.letter.size):
            result[state, w] = scratch.letter[w]


@kernel()
def predecessors(pointer, targets, back_pointer, sources):  # type: ignore[no-untyped-def]
    """Reverse a graph in CSR form; `back_pointer` must be zero."""
    size = pointer.size - 1
    for k in range(pointer[size]):
        back_pointer[targets[k] + 1] += 1
    for s in range(size):
        back_pointer[s + 1] += back_pointer[s]
    place = back_pointer[:-1].copy()
    for s in range(size):
        for k in range(pointer[s], pointer[s + 1]):
            t = targets[k]
            sources[place[t]] = s
            place[t] += 1


@kernel()
def some_successor(pointer, targets, inside, result):  # type: ignore[no-untyped-def]
    """EX: states with a successor in a set."""
    for s in range(pointer.size - 1):
        for k in range(pointer[s], pointer[s + 1]):
            if inside[targets[k]]:
                result[s] = True
                break


@kernel()
def some_until(back_pointer, sources, stay, result, queue):  # type: ignore[no-untyped-def]
    """E[stay U goal]: `result` holds the goal and becomes the answer."""
    tail = 0
    for s in range(result.size):
        if result[s]:
            queue[tail] = s
            tail += 1
    head = 0
    while head < tail:
        s = queue[head]
        head += 1
        for k in range(back_pointer[s], back_pointer[s + 1]):
            p = sources[k]
            if stay[p] and not result[p]:
                result[p] = True
                queue[tail] = p
                tail += 1


@kernel()
def some_globally(pointer, targets, back_pointer, sources, result, queue):  # type: ignore[no-untyped-def]
    """EG: `result` holds a set and becomes its states from which a run stays in it forever."""
    size = result.size
    left = np.zeros(size, dtype=np.int32)
    tail = 0
    for s in range(size):
        if result[s]:
            for k in range(pointer[s], pointer[s + 1]):
                if result[targets[k]]:
                    left[s] += 1
            if left[s] == 0:
                queue[tail] = s
                tail += 1
    for i in range(tail):
        result[queue[i]] = False
    head = 0
    while head < tail:
        s = queue[head]
        head += 1
        for k in range(back_pointer[s], back_pointer[s + 1]):
            p = sources[k]
            if result[p]:
                left[p] -= 1
                if left[p] == 0:
                    result[p] = False
                    queue[tail] = p
                    tail += 1


@kernel()
def path_states(pointer, targets, start, allowed, goal, parents, queue):  # type: ignore[no-untyped-def]
    """Breadth-first search over allowed states for the end of a shortest path with an edge to a goal.

    `parents` must be filled with -1. Returns the last state but one, and the goal; (-1, -1) if there is none.
    """
    queue[0] = start
    parents[start] = start
    head, tail = 0, 1
    while head < tail:
        s = queue[head]
        head += 1
        for k in range(pointer[s], pointer[s + 1]):
            t = targets[k]
            if goal[t]:
                return s, t
            if allowed[t] and parents[t] < 0:
                parents[t] = s
                queue[tail] = t
                tail += 1
    return -1, -1
