"""Kernel of the breadth-first search: fires all enabled transitions in the markings of a level.

The enabled transitions are looked up in tables: each cell's code gives the set of transitions that it allows,
and the intersection over all cells is the enabled set. Workers take markings of the level in small chunks,
first their own and then those of others, so that all end at about the same time.
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.explicit.kernels.atomics import fetch_and_add, load, prefetch
from dineros.analysis.explicit.kernels.markings import (
    ARCS,
    BATCH,
    CHUNK_END,
    COUNT,
    DEADLOCK_ROW,
    DEADLOCKS,
    EXPANDED,
    HAS_OVERFLOW,
    HITS,
    IS_FULL,
    LIMIT,
    NEXT,
    check_goals,
    hash_words,
    insert_all,
    sum_of,
)
from dineros.analysis.explicit.kernels.stubborn import keep_stubborn, lowest_bit, read_tokens
from dineros.analysis.nets.kernel_cache import kernel

#: Number of markings that a worker takes at a time.
CHUNK = 64
#: Elements of the frontier per worker: what one writes must not lie in a cache line of another.
STRIDE = 16


@kernel(inline="always")
def enabled_in(net, store, row, enabled):  # type: ignore[no-untyped-def]
    """Set of the transitions that a stored marking enables; whether it is empty."""
    word, shift, mask, is_wide = net.word, net.shift, net.mask, net.is_wide
    start, lookup_word, lookup_offset, allowed = (
        net.lookup_start,
        net.lookup_word,
        net.lookup_offset,
        net.allowed,
    )
    for s in range(enabled.size):
        enabled[s] = net.fired[s]
    for k in range(word.size):
        code = (store[row, word[k]] >> shift[k]) & mask[k]
        if is_wide[k]:
            amount, code = code, 0
            for i in range(net.threshold_start[k], net.threshold_start[k + 1]):
                code += amount >= net.threshold[i]
        for i in range(start[k], start[k + 1]):
            enabled[lookup_word[i]] &= allowed[lookup_offset[i] + code]
    is_deadlock = True
    for s in range(enabled.size):
        is_deadlock &= enabled[s] == 0
    return is_deadlock


@kernel()
def note_enabled(notes, enabled, is_deadlock, row):  # type: ignore[no-untyped-def]
    """Record wanted transitions, and a deadlock, that occur in a marking."""
    control = notes.control
    for s in range(enabled.size):
        notes.ever[s] |= enabled[s]
        met = enabled[s] & notes.wanted[s]
        notes.wanted[s] &= ~met
        while met != 0:
            notes.transition_row[64 * s + lowest_bit(met)] = row
            met &= met - 1
            control[HITS] += 1
    if is_deadlock and control[DEADLOCK_ROW] < 0:
        control[DEADLOCK_ROW] = row
        control[HITS] += 1


@kernel()
def keep_needed(net, goals, stubborn, notes, store, row, enabled, tokens, sums):  # type: ignore[no-untyped-def]
    """Reduce the enabled set of a stored marking to a stubborn subset."""
    read_tokens(net, stubborn, store, row, tokens)
    for c in range(sums.size):
        sums[c] = sum_of(net, goals, store, row, c)
    keep_stubborn(stubborn, goals, notes.wanted, tokens, sums, enabled)


@kernel(nogil=True)
def expand(  # type: ignore[no-untyped-def]
    shape, me, net, goals, stubborn, markings, notes, frontier, box, origins, codes, budget, alone
):  # fmt: skip
    """Fire all enabled transitions in up to `budget` markings of the frontier.

    Stops early if the frontier is exhausted, a goal is found, there is no room, or a place overflows its
    cell. Found markings are inserted before it returns.

    Parameters
    ----------
    frontier
        By worker, `STRIDE` apart: the next row of the level to be taken, and the end.
    alone
        While a level has at most this number of markings, continue with the next one; only for a single
        active worker.
    """
    store, control, table = markings.store, notes.control, markings.table
    delta, moves, guards = net.delta, net.moves, net.guards
    mask = table.size - 1
    base = me * markings.rows
    workers = frontier.size // STRIDE
    transitions = delta.shape[0]
    sets = net.fired.size
    enabled = np.empty(sets, dtype=np.int64)
    tokens = np.empty(stubborn.places, dtype=np.int64)
    sums = np.empty(goals.least.size, dtype=np.int64)
    row, last = control[NEXT], control[CHUNK_END]
    size, arcs, deadlocks, expanded = 0, 0, 0, 0
    hits = control[HITS]
    is_done = False
    while True:
        if row == last and not is_done:
            row = last = 0
            for step in range(workers):
                at = (me + step) % workers * STRIDE
                if load(frontier, at) < frontier[at + 1]:
                    first = fetch_and_add(frontier, at, CHUNK)
                    if first < frontier[at + 1]:
                        row, last = first, min(first + CHUNK, frontier[at + 1])
                        break
        is_over = row == last
        if size >= BATCH or is_done or is_over or control[COUNT] + size + transitions > control[LIMIT]:
            insert_all(shape, markings, control, base, box, origins, codes, size)
            size = 0
            if goals.is_open.size:
                check_goals(net, goals, store, notes, base)
            is_done |= control[HITS] != hits
            if is_over and not is_done:
                at = me * STRIDE
                start, end = frontier[at + 1], base + control[COUNT]
                if start < end <= start + alone:
                    frontier[at], frontier[at + 1] = start, end
                    continue
            if not is_over and control[COUNT] + transitions > control[LIMIT]:
                control[IS_FULL] = 1
                is_done = True
            if is_done or is_over:
                control[NEXT], control[CHUNK_END] = row, last
                control[ARCS] += arcs
                control[DEADLOCKS] += deadlocks
                control[EXPANDED] += expanded
                return
        if expanded == budget:
            is_done = True
            continue
        is_deadlock = enabled_in(net, store, row, enabled)
        note_enabled(notes, enabled, is_deadlock, row)
        is_done = control[HITS] != hits
        if stubborn.is_used and not is_deadlock:
            keep_needed(net, goals, stubborn, notes, store, row, enabled, tokens, sums)
        before, overflows, fired = size, 0, 0
        for s in range(sets):
            bits = enabled[s]
            while bits != 0:
                transition = 64 * s + lowest_bit(bits)
                bits &= bits - 1
                fired += 1
                if not moves[transition]:
                    continue
                for w in range(len(shape)):
                    value = store[row, w] + delta[transition, w]
                    overflows |= value & guards[w]
                    box[size, w] = value
                codes[size] = hash_words(box, size, shape)
                prefetch(table, codes[size] & mask)
                origins[size] = row
                size += 1
        if overflows != 0:
            size = before
            control[HAS_OVERFLOW] = 1
            is_done = True
            continue
        arcs += fired
        deadlocks += is_deadlock
        expanded += 1
        row += 1
