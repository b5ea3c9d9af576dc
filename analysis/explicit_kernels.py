"""Kernels of the explicit engine: packed markings in a hash table, fired level by level.

Every worker owns the markings whose hash falls to it: it alone inserts them, so no locks are needed. What a
worker finds for another goes to a box that the owner empties in the next round. Which transitions are
enabled is read off tables: each cell's code gives the set of transitions it allows, and the intersection
over all cells is what is enabled.

References
----------
U. Stern, D. L. Dill, *Parallelizing the Mur-phi verifier*, CAV 1997, LNCS 1254 (owners by hash).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from dineros.analysis.explicit_stubborn import keep_stubborn, lowest_bit, read_tokens

COUNT, ARCS, DEADLOCKS, NEXT, CHECKED, LIMIT, IS_FULL, HITS, HAS_OVERFLOW, DEADLOCK_ROW, TOUCHED = range(11)
CONTROL_SIZE = 11

#: Insertions whose waits for memory overlap.
BATCH = 256

INDEX_BITS = 40
INDEX_MASK = (1 << INDEX_BITS) - 1
TAG_MASK = (1 << 22) - 1


@njit(cache=True, inline="always")
def hash_words(words, at, shape):  # type: ignore[no-untyped-def]
    """Non-negative hash of row `at`."""
    code = 0
    for w in range(len(shape)):
        code = (code ^ words[at, w]) * 0x1E3779B97F4A7C15
        code ^= (code >> 32) & 0xFFFFFFFF
    code *= 0x2545F4914F6CDD1D
    return (code ^ (code >> 29)) & 0x7FFFFFFFFFFFFFFF


@njit(cache=True)
def owner_of(words, at, shape, workers):  # type: ignore[no-untyped-def]
    """Worker that row `at` belongs to; these bits of the hash choose no slot."""
    return (hash_words(words, at, shape) & 63) % workers


@njit(cache=True, nogil=True)
def rebuild(shape, worker):  # type: ignore[no-untyped-def]
    """Fill a fresh, zeroed table with all stored markings."""
    table, mask, count = worker.table, worker.table.size - 1, worker.control[COUNT]
    codes = np.empty(BATCH, dtype=np.int64)
    touched = 0
    for start in range(0, count, BATCH):
        size = min(BATCH, count - start)
        for at in range(size):
            codes[at] = hash_words(worker.store, start + at, shape)
            touched |= table[(codes[at] >> 6) & mask]
        for at in range(size):
            code = codes[at]
            slot = (code >> 6) & mask
            while table[slot] != 0:
                slot = (slot + 1) & mask
            table[slot] = ((code >> 20) & TAG_MASK) << INDEX_BITS | (start + at + 1)
    worker.control[TOUCHED] = touched


@njit(cache=True, nogil=True)
def insert_all(shape, worker, box, box_parents, codes, start, size):  # type: ignore[no-untyped-def]
    """Insert rows ``start:start + size`` of a box, at most `BATCH`, unless known; there must be room.

    Two loops first touch what the insertions will need, so that the waits for memory overlap.
    """
    store, table, control, parents = worker.store, worker.table, worker.control, worker.parents
    mask = table.size - 1
    touched = 0
    for at in range(size):
        code = hash_words(box, start + at, shape)
        codes[at] = code
        touched |= table[(code >> 6) & mask]
    for at in range(size):
        code = codes[at]
        entry = table[(code >> 6) & mask]
        if entry != 0 and entry >> INDEX_BITS == (code >> 20) & TAG_MASK:
            touched |= store[(entry & INDEX_MASK) - 1, 0]
    control[TOUCHED] = touched
    count = control[COUNT]
    for at in range(size):
        code = codes[at]
        tag = (code >> 20) & TAG_MASK
        slot = (code >> 6) & mask
        is_new = True
        while table[slot] != 0:
            entry = table[slot]
            if entry >> INDEX_BITS == tag:
                known = (entry & INDEX_MASK) - 1
                same = True
                for w in range(len(shape)):
                    same &= store[known, w] == box[start + at, w]
                if same:
                    is_new = False
                    break
            slot = (slot + 1) & mask
        if is_new:
            for w in range(len(shape)):
                store[count, w] = box[start + at, w]
            if parents.size:
                parents[count] = box_parents[start + at]
            count += 1
            table[slot] = tag << INDEX_BITS | count
    control[COUNT] = count


@njit(cache=True, inline="always")
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


@njit(cache=True, nogil=True)
def check_goals(net, goals, worker):  # type: ignore[no-untyped-def]
    """Note the first marking of each open conjunction among those not yet looked at."""
    control, store = worker.control, worker.store
    for row in range(control[CHECKED], control[COUNT]):
        for goal in range(goals.is_open.size):
            if goals.is_open[goal] == 0 or worker.goal_row[goal] >= 0:
                continue
            holds = True
            for c in range(goals.constraint_start[goal], goals.constraint_start[goal + 1]):
                if sum_of(net, goals, store, row, c) < goals.least[c]:
                    holds = False
                    break
            if holds:
                worker.goal_row[goal] = row
                control[HITS] += 1
    control[CHECKED] = control[COUNT]


@njit(cache=True, nogil=True)
def receive(shape, net, goals, worker, box, box_parents, size):  # type: ignore[no-untyped-def]
    """Insert `size` markings that another worker found; there must be room."""
    codes = np.empty(BATCH, dtype=np.int64)
    for start in range(0, size, BATCH):
        insert_all(shape, worker, box, box_parents, codes, start, min(BATCH, size - start))
        check_goals(net, goals, worker)


@njit(cache=True, nogil=True)
def expand(  # type: ignore[no-untyped-def]
    shape, me, net, goals, stubborn, worker, end, boxes, box_parents, box_size
):  # fmt: skip
    """Fire everything in the markings from ``control[NEXT]`` up to `end`.

    Stops early when a goal is met, a box for another worker or the table is full, or a place overflows its
    cell. What it found for itself is inserted before it returns.
    """
    store, control, delta = worker.store, worker.control, net.delta
    workers = boxes.shape[0]
    transitions = delta.shape[0]
    room = boxes.shape[1] - transitions
    cells = net.word.size
    sets = net.everything.size
    enabled = np.empty(sets, dtype=np.int64)
    codes = np.empty(BATCH, dtype=np.int64)
    sizes = np.empty(workers, dtype=np.int64)
    tokens = np.empty(stubborn.places, dtype=np.int64)
    sums = np.empty(goals.least.size, dtype=np.int64)
    words = np.empty((1, len(shape)), dtype=np.int64)
    is_done = False
    hits = control[HITS]
    while True:
        row = control[NEXT]
        is_done |= row >= end or control[HITS] != hits
        if box_size[me] >= BATCH or is_done or row >= control[COUNT]:
            for start in range(0, box_size[me], BATCH):
                size = min(BATCH, box_size[me] - start)
                insert_all(shape, worker, boxes[me], box_parents[me], codes, start, size)
            box_size[me] = 0
            if goals.is_open.size:
                check_goals(net, goals, worker)
            if is_done or row >= control[COUNT]:
                return
            if control[HITS] != hits:
                continue
        if control[COUNT] + box_size[me] + transitions > control[LIMIT]:
            control[IS_FULL] = 1
            is_done = True
            continue
        for other in range(workers):
            is_done |= box_size[other] > room
        if is_done:
            continue
        for s in range(sets):
            enabled[s] = net.everything[s]
        for k in range(cells):
            code = (store[row, net.word[k]] >> net.shift[k]) & net.mask[k]
            if net.is_wide[k]:
                amount, code = code, 0
                for i in range(net.threshold_start[k], net.threshold_start[k + 1]):
                    code += amount >= net.threshold[i]
            for i in range(net.lookup_start[k], net.lookup_start[k + 1]):
                enabled[net.lookup_word[i]] &= net.allowed[net.lookup_offset[i] + code]
        is_deadlock = True
        for s in range(sets):
            bits = enabled[s]
            is_deadlock &= bits == 0
            worker.ever[s] |= bits
            met = bits & worker.wanted[s]
            worker.wanted[s] &= ~met
            while met != 0:
                worker.transition_row[64 * s + lowest_bit(met)] = row
                met &= met - 1
                control[HITS] += 1
        if is_deadlock and control[DEADLOCK_ROW] < 0:
            control[DEADLOCK_ROW] = row
            control[HITS] += 1
        if stubborn.is_used and not is_deadlock:
            read_tokens(net, stubborn, store, row, tokens)
            for c in range(sums.size):
                sums[c] = sum_of(net, goals, store, row, c)
            keep_stubborn(stubborn, goals, worker.wanted, tokens, sums, enabled)
        arcs, overflows = 0, 0
        for other in range(workers):
            sizes[other] = box_size[other]
        for s in range(sets):
            bits = enabled[s]
            while bits != 0:
                transition = 64 * s + lowest_bit(bits)
                bits &= bits - 1
                arcs += 1
                if not net.moves[transition]:
                    continue
                if workers == 1:
                    at = box_size[me]
                    for w in range(len(shape)):
                        value = store[row, w] + delta[transition, w]
                        overflows |= value & net.guards[w]
                        boxes[me, at, w] = value
                    box_parents[me, at] = row
                    box_size[me] = at + 1
                else:
                    for w in range(len(shape)):
                        words[0, w] = store[row, w] + delta[transition, w]
                        overflows |= words[0, w] & net.guards[w]
                    owner = owner_of(words, 0, shape, workers)
                    at = box_size[owner]
                    for w in range(len(shape)):
                        boxes[owner, at, w] = words[0, w]
                    box_parents[owner, at] = row * workers + me
                    box_size[owner] = at + 1
        if overflows != 0:
            for other in range(workers):
                box_size[other] = sizes[other]
            control[HAS_OVERFLOW] = 1
            is_done = True
            continue
        control[ARCS] += arcs
        control[DEADLOCKS] += is_deadlock
        control[NEXT] = row + 1


@njit(cache=True, nogil=True)
def repack(store, target, count, word, shift, mask, new_word, new_shift):  # type: ignore[no-untyped-def]
    """Write the first `count` markings in a layout with other positions of the cells."""
    for row in range(count):
        for w in range(target.shape[1]):
            target[row, w] = 0
        for k in range(word.size):
            code = (store[row, word[k]] >> shift[k]) & mask[k]
            target[row, new_word[k]] |= code << new_shift[k]


@njit(cache=True, nogil=True)
def survey(store, count, net, offset, tokens, seen, largest):  # type: ignore[no-untyped-def]
    """Flag the codes seen, note the largest tokens of wide cells; return the largest total of a marking."""
    best = 0
    for row in range(count):
        total = 0
        for k in range(net.word.size):
            code = (store[row, net.word[k]] >> net.shift[k]) & net.mask[k]
            if net.is_wide[k]:
                largest[k] = max(largest[k], code)
                total += code
            else:
                seen[offset[k] + code] = 1
                total += tokens[offset[k] + code]
        best = max(best, total)
    return best
