"""Kernel of the depth-first search: the newest marking with unfired transitions is expanded first."""

from __future__ import annotations

import numpy as np

from dineros.analysis.explicit.kernels.expansion import enabled_in, keep_needed, note_enabled
from dineros.analysis.explicit.kernels.markings import (
    ARCS,
    COUNT,
    DEADLOCKS,
    DEPTH,
    EXPANDED,
    HAS_OVERFLOW,
    HITS,
    IS_FULL,
    LIMIT,
    check_goals,
    hash_words,
    insert_all,
)
from dineros.analysis.explicit.kernels.stubborn import lowest_bit
from dineros.analysis.nets.kernel_cache import kernel


@kernel()
def enter(net, goals, stubborn, markings, notes, stack, left, tokens, sums):  # type: ignore[no-untyped-def]
    """Put the newest marking, with its enabled transitions, on the stack."""
    store, control = markings.store, notes.control
    row, depth = control[COUNT] - 1, control[DEPTH]
    enabled = left[depth]
    is_deadlock = enabled_in(net, store, row, enabled)
    note_enabled(notes, enabled, is_deadlock, row)
    if goals.is_open.size:
        check_goals(net, goals, store, notes, 0)
    if stubborn.is_used and not is_deadlock:
        keep_needed(net, goals, stubborn, notes, store, row, enabled, tokens, sums)
    stack[depth] = row
    control[DEPTH] = depth + 1
    control[DEADLOCKS] += is_deadlock
    control[EXPANDED] += 1
    for s in range(enabled.size):
        bits = enabled[s]
        while bits != 0:
            bits &= bits - 1
            control[ARCS] += 1


@kernel(nogil=True)
def descend(  # type: ignore[no-untyped-def]
    shape, net, goals, stubborn, markings, notes, stack, left, budget
):  # fmt: skip
    """Visit up to `budget` markings; end early at a goal, if memory is full, or if a place overflows.

    Parameters
    ----------
    stack
        Rows of the markings from the initial one to the current one.
    left
        By depth: the set of the transitions still to be fired.
    """
    store, control, delta = markings.store, notes.control, net.delta
    tokens = np.empty(stubborn.places, dtype=np.int64)
    sums = np.empty(goals.least.size, dtype=np.int64)
    box = np.empty((1, len(shape)), dtype=np.int64)
    origin = np.empty(1, dtype=np.int64)
    code = np.empty(1, dtype=np.int64)
    end, hits = control[EXPANDED] + budget, control[HITS]
    if control[EXPANDED] == 0:
        enter(net, goals, stubborn, markings, notes, stack, left, tokens, sums)
    while control[DEPTH] > 0 and control[EXPANDED] < end and control[HITS] == hits:
        if control[COUNT] >= control[LIMIT]:
            control[IS_FULL] = 1
            return
        top = control[DEPTH] - 1
        s = 0
        while s < left.shape[1] and left[top, s] == 0:
            s += 1
        if s == left.shape[1]:
            control[DEPTH] = top
            continue
        row, bits, overflows = stack[top], left[top, s], 0
        transition = 64 * s + lowest_bit(bits)
        for w in range(len(shape)):
            box[0, w] = store[row, w] + delta[transition, w]
            overflows |= box[0, w] & net.guards[w]
        if overflows != 0:
            control[HAS_OVERFLOW] = 1
            return
        left[top, s] = bits & (bits - 1)
        origin[0], code[0] = row, hash_words(box, 0, shape)
        before = control[COUNT]
        insert_all(shape, markings, control, 0, box, origin, code, 1)
        if control[COUNT] > before:
            enter(net, goals, stubborn, markings, notes, stack, left, tokens, sums)
