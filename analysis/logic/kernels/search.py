"""On-the-fly emptiness check of a product by strongly connected components, as a machine that can stop.

Depth-first search with a stack of roots of components; a closing edge joins the components above its target
and adds their marks. A component with all marks contains the loop of an accepting run, and the search stops
there. A search that pauses, for memory or for the clock, can be continued. The net is accessed only by
`expand`.

References
----------
J.-M. Couvreur, *On-the-fly verification of linear temporal logic*, FM 1999, LNCS 1708. J.-M. Couvreur, A.
Duret-Lutz, D. Poitrenaud, *On-the-fly emptiness checks for generalized Buchi automata*, SPIN 2005, LNCS 3639.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.logic.kernels.product import MAY_ADD, STATES, expand, find_enabled
from dineros.analysis.nets.kernel_cache import kernel

Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

EMPTY, FOUND, CANDIDATE, STORE_FULL, SEARCH_FULL, OVERFLOW, PAUSED = range(7)
#: control: sizes of the stacks, number given last, whether the candidate on top was looked at.
FRAMES, POOL, LIVE, ROOTS, NUMBERED, IS_REJECTED = range(6)
DEAD = -1

MOST_PASSES = 3
"""Maximum number of passes over a component that look for states without a successor in it."""


class Search(NamedTuple):
    """The stacks of the search, and each state's number: 0 not visited, DEAD after its component.

    `is_kept` is memory for `may_be_fair`.
    """

    number: Int32Array
    is_kept: BoolArray
    frame_state: Int32Array
    frame_pool: Int64Array
    pool_target: Int32Array
    pool_label: Int32Array
    live: Int32Array
    root_number: Int32Array
    root_marks: Int64Array
    root_strong: Int64Array
    root_arc: Int64Array
    control: Int64Array


@kernel()
def is_accepting(search, root, required):  # type: ignore[no-untyped-def]
    """Whether a component has all required marks and is fair to the strongly fair transitions in it."""
    for m in range(required.size):
        marks = search.root_marks[root, m]
        if marks & required[m] != required[m] or search.root_strong[root, m] & ~marks != 0:
            return False
    return True


@kernel()
def has_required(search, root, required):  # type: ignore[no-untyped-def]
    """Whether a component has all required marks."""
    missing = 0
    for m in range(required.size):
        missing |= required[m] & ~search.root_marks[root, m]
    return missing == 0


@kernel()
def close_cycle(search, conditions, edges, number, label):  # type: ignore[no-untyped-def]
    """Join the components above a live state's, after an edge to it; return whether the result accepts."""
    control = search.control
    width = edges.target.size
    t, e = label // width, label % width
    root = control[ROOTS] - 1
    while search.root_number[root] > number:
        for m in range(conditions.required.size):
            search.root_marks[root - 1, m] |= search.root_marks[root, m] | search.root_arc[root, m]
            search.root_strong[root - 1, m] |= search.root_strong[root, m]
        root -= 1
    control[ROOTS] = root + 1
    for m in range(conditions.required.size):
        marks = conditions.weak_marks[t, m] | conditions.strong_marks[t, m]
        marks |= edges.marks[e, m]
        search.root_marks[root, m] |= marks
    return is_accepting(search, root, conditions.required)


@kernel()
def may_be_fair(steps, conditions, edges, store, scratch, search, lowest):  # type: ignore[no-untyped-def]
    """Whether a cycle of the component on top of the stack may be fair.

    A cycle is unfair through a state that enables a strongly fair transition which the component does not
    fire. Such states are removed, then states without a successor that is left; if no state is left, no cycle
    is fair. `lowest` is the position of the component's first state in `live`.
    """
    number, is_kept, control = search.number, search.is_kept, search.control
    root = control[ROOTS] - 1
    left = 0
    for at in range(lowest, control[LIVE]):
        state = search.live[at]
        is_kept[state] = True
        for i in range(find_enabled(steps, store, scratch, state)):
            for m in range(conditions.required.size):
                strong = conditions.strong_marks[scratch.enabled[i], m]
                if strong & search.root_strong[root, m] & ~search.root_marks[root, m] != 0:
                    is_kept[state] = False
        left += is_kept[state]
    store.counters[MAY_ADD] = 0
    for _ in range(MOST_PASSES):
        before = left
        # States found late reach few others.
        for at in range(control[LIVE] - 1, lowest - 1, -1):
            state = search.live[at]
            if is_kept[state]:
                top = control[POOL]
                end = expand(
                    steps,
                    conditions,
                    edges,
                    store,
                    scratch,
                    np.int64(state),
                    search.pool_target,
                    search.pool_label,
                    top,
                )
                goes_on = False
                for k in range(top, end):
                    target = search.pool_target[k]
                    goes_on |= number[target] >= search.root_number[root] and is_kept[target]
                is_kept[state] = goes_on
                left -= not goes_on
        if left == 0 or left == before:
            break
    store.counters[MAY_ADD] = 1
    return left > 0


@kernel()
def explore(steps, conditions, edges, store, scratch, search, visits):  # type: ignore[no-untyped-def]
    """Continue the search until it is decided, needs something, or has visited `visits` more states."""
    store.counters[MAY_ADD] = 1
    control, number = search.control, search.number
    width = edges.target.size
    mark_words = conditions.required.size
    room = steps.delta.shape[0] * scratch.candidates.size
    while True:
        frames, top = control[FRAMES], control[POOL]
        if frames == 0 and top == 0:
            return EMPTY
        if frames > 0 and top == search.frame_pool[frames - 1]:
            state = search.frame_state[frames - 1]
            root = control[ROOTS] - 1
            if search.root_number[root] == number[state]:
                # The marks of a lone state are not cycle's: an edge to itself would have been closed.
                live = control[LIVE] - 1
                while search.live[live] != state:
                    live -= 1
                if (
                    live < control[LIVE] - 1
                    and control[IS_REJECTED] == 0
                    and has_required(search, root, conditions.required)
                    and may_be_fair(steps, conditions, edges, store, scratch, search, live)
                ):
                    return CANDIDATE
                control[IS_REJECTED] = 0
                for at in range(live, control[LIVE]):
                    number[search.live[at]] = DEAD
                control[LIVE] = live
                control[ROOTS] = root
            control[FRAMES] = frames - 1
            continue
        if visits <= 0:
            return PAUSED
        state, label = np.int64(search.pool_target[top - 1]), np.int64(search.pool_label[top - 1])
        if number[state] == DEAD:
            control[POOL] = top - 1
            continue
        if number[state] > 0:
            control[POOL] = top - 1
            if close_cycle(search, conditions, edges, number[state], label):
                return FOUND
            continue
        if store.counters[STATES] + room > store.words.shape[0] or (
            2 * (store.counters[STATES] + room) > store.table.size
        ):
            return STORE_FULL
        if (
            top + room > search.pool_target.size
            or frames + 1 > search.frame_state.size
            or control[LIVE] + 1 > search.live.size
            or control[ROOTS] + 1 > search.root_number.size
        ):
            return SEARCH_FULL
        # Successors are put above the edge taken; only if all have room, it is removed and the state visited.
        end = expand(
            steps, conditions, edges, store, scratch, state, search.pool_target, search.pool_label, top
        )
        if end < 0:
            return OVERFLOW
        visits -= 1
        control[NUMBERED] += 1
        number[state] = control[NUMBERED]
        search.live[control[LIVE]] = state
        control[LIVE] += 1
        root = control[ROOTS]
        search.root_number[root] = number[state]
        for m in range(mark_words):
            search.root_marks[root, m] = scratch.weak_seen[m]
            search.root_strong[root, m] = scratch.strong_seen[m]
            search.root_arc[root, m] = 0
            if label >= 0:
                t, e = label // width, label % width
                search.root_arc[root, m] = conditions.weak_marks[t, m] | conditions.strong_marks[t, m]
                search.root_arc[root, m] |= edges.marks[e, m]
        control[ROOTS] = root + 1
        search.frame_state[frames] = state
        search.frame_pool[frames] = top - 1
        control[FRAMES] = frames + 1
        # Edges to live states close cycles at once, so that loops are found early; those to dead states are
        # dropped.
        kept = top - 1
        for k in range(top, end):
            target, way = np.int64(search.pool_target[k]), np.int64(search.pool_label[k])
            if number[target] == 0:
                search.pool_target[kept] = target
                search.pool_label[kept] = way
                kept += 1
            elif number[target] > 0 and close_cycle(search, conditions, edges, number[target], way):
                control[POOL] = kept
                return FOUND
        control[POOL] = kept
