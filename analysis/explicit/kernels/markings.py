"""Kernels of the explicit engine: packed markings in a hash table shared by all workers.

A worker appends a presumably new marking to its own ones, and then tries to put its row into the table by one
compare-and-swap: the first worker to do so has found the marking. So no locks are needed, and workers
exchange no messages. The memory for an insertion is prefetched well before it is needed, for many insertions
at a time.

References
----------
A. Laarman, J. van de Pol, M. Weber, *Boosting multi-core reachability performance with shared hash tables*,
FMCAD 2010.
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.explicit.kernels.atomics import compare_and_swap, load, prefetch
from dineros.analysis.nets.kernel_cache import kernel

(
    COUNT,
    ARCS,
    DEADLOCKS,
    EXPANDED,
    NEXT,
    CHUNK_END,
    CHECKED,
    LIMIT,
    IS_FULL,
    HITS,
    HAS_OVERFLOW,
    DEADLOCK_ROW,
    DEPTH,
) = range(13)
CONTROL_SIZE = 13

#: Number of insertions whose memory accesses overlap.
BATCH = 256

INDEX_BITS = 40
INDEX_MASK = (1 << INDEX_BITS) - 1
#: The tag of an entry: the highest bits of a hash, the lowest ones choose the slot.
TAG_SHIFT = 41


@kernel(inline="always")
def hash_words(words, at, shape):  # type: ignore[no-untyped-def]
    """Non-negative hash of row `at`."""
    code = 0
    for w in range(len(shape)):
        code = (code ^ words[at, w]) * 0x1E3779B97F4A7C15
        code ^= (code >> 32) & 0xFFFFFFFF
    code *= 0x2545F4914F6CDD1D
    return (code ^ (code >> 29)) & 0x7FFFFFFFFFFFFFFF


@kernel(nogil=True)
def rebuild(shape, store, table, first, count):  # type: ignore[no-untyped-def]
    """Put `count` stored markings, all different, into a fresh table."""
    mask = table.size - 1
    codes = np.empty(BATCH, dtype=np.int64)
    for start in range(first, first + count, BATCH):
        size = min(BATCH, first + count - start)
        for at in range(size):
            codes[at] = hash_words(store, start + at, shape)
            prefetch(table, codes[at] & mask)
        for at in range(size):
            slot = codes[at] & mask
            entry = (codes[at] >> TAG_SHIFT) << INDEX_BITS | (start + at + 1)
            while table[slot] != 0 or not compare_and_swap(table, slot, 0, entry):
                slot = (slot + 1) & mask


@kernel(nogil=True)
def insert_all(shape, markings, control, base, box, origins, codes, size):  # type: ignore[no-untyped-def]
    """Insert the first rows of a box, with known hashes and prefetched slots; there must be room."""
    store, table, parents = markings.store, markings.table, markings.parents
    mask = table.size - 1
    for at in range(size):
        entry = table[codes[at] & mask]
        if entry != 0 and entry >> INDEX_BITS == codes[at] >> TAG_SHIFT:
            prefetch(store, (entry & INDEX_MASK) - 1)
    new = base + control[COUNT]
    for at in range(size):
        tag = codes[at] >> TAG_SHIFT
        slot = codes[at] & mask
        while True:
            entry = load(table, slot)
            if entry == 0:
                for w in range(len(shape)):
                    store[new, w] = box[at, w]
                if parents.size:
                    parents[new] = origins[at]
                if compare_and_swap(table, slot, 0, tag << INDEX_BITS | (new + 1)):
                    new += 1
                    break
                entry = load(table, slot)
            if entry >> INDEX_BITS == tag:
                known = (entry & INDEX_MASK) - 1
                same = True
                for w in range(len(shape)):
                    same &= store[known, w] == box[at, w]
                if same:
                    break
            slot = (slot + 1) & mask
    control[COUNT] = new - base


@kernel(inline="always")
def sum_of(net, goals, store, row, c):  # type: ignore[no-untyped-def]
    """Sum of a linear constraint in a stored marking."""
    total = 0
    for term in range(goals.term_start[c], goals.term_start[c + 1]):
        k = goals.term_cell[term]
        code = (store[row, net.word[k]] >> net.shift[k]) & net.mask[k]
        if goals.term_offset[term] < 0:
            total += goals.term_factor[term] * code
        else:
            total += goals.table[goals.term_offset[term] + code]
    return total


@kernel(nogil=True)
def check_goals(net, goals, store, notes, base):  # type: ignore[no-untyped-def]
    """Record the first marking of each open conjunction among the markings not checked yet."""
    control = notes.control
    for row in range(base + control[CHECKED], base + control[COUNT]):
        for goal in range(goals.is_open.size):
            if goals.is_open[goal] == 0 or notes.goal_row[goal] >= 0:
                continue
            holds = True
            for c in range(goals.constraint_start[goal], goals.constraint_start[goal + 1]):
                if sum_of(net, goals, store, row, c) < goals.least[c]:
                    holds = False
                    break
            if holds:
                notes.goal_row[goal] = row
                control[HITS] += 1
    control[CHECKED] = control[COUNT]


@kernel(nogil=True)
def repack(store, target, count, word, shift, mask, new_word, new_shift):  # type: ignore[no-untyped-def]
    """Write the first `count` markings with other positions of the cells."""
    for row in range(count):
        for w in range(target.shape[1]):
            target[row, w] = 0
        for k in range(word.size):
            code = (store[row, word[k]] >> shift[k]) & mask[k]
            target[row, new_word[k]] |= code << new_shift[k]


@kernel(nogil=True)
def survey(store, first, count, net, offset, tokens, seen, largest):  # type: ignore[no-untyped-def]
    """Flag the codes seen, note the largest tokens of wide cells; return the largest total of a marking."""
    word, shift, mask, is_wide = net.word, net.shift, net.mask, net.is_wide
    best = 0
    for row in range(first, first + count):
        total = 0
        for k in range(word.size):
            code = (store[row, word[k]] >> shift[k]) & mask[k]
            if is_wide[k]:
                largest[k] = max(largest[k], code)
                total += code
            else:
                seen[offset[k] + code] = 1
                total += tokens[offset[k] + code]
        best = max(best, total)
    return best
