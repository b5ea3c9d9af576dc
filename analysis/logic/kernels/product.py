"""Kernels on the product of a net and an automaton: the table of states, and successors.

A state of the product is a packed marking of the explicit engine, with the automaton's state in an additional
cell. The net is given by the explicit engine's tables (`NetTables`), with an additional last step: staying in
a deadlock. An edge is a step read by an edge of the automaton; its label is ``step * automaton edges +
automaton edge``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.explicit.kernels.atomics import prefetch
from dineros.analysis.explicit.kernels.expansion import enabled_in
from dineros.analysis.explicit.kernels.markings import (
    INDEX_BITS,
    INDEX_MASK,
    TAG_SHIFT,
    hash_words,
    sum_of,
)
from dineros.analysis.explicit.kernels.stubborn import lowest_bit
from dineros.analysis.logic.language.atoms import Combined
from dineros.analysis.nets.kernel_cache import kernel

Int64Array = NDArray[np.int64]


class Conditions(NamedTuple):
    """Atoms and fairness; both are bits in words of 62. The last row by transition is a deadlock's.

    Combinations are in CSR form: numbers of bits, and negative codes of operations (`atoms.Combined`). The
    sums are constraints of the explicit engine (`Goals`), each compared with its bound.
    """

    term_start: Int64Array
    term_cell: Int64Array
    term_offset: Int64Array
    term_factor: Int64Array
    table: Int64Array
    linear_operator: Int64Array
    linear_bound: Int64Array
    linear_bit: Int64Array
    asks_enabled: int
    enabled_bits: Int64Array
    fired_bits: Int64Array
    deadlock_bits: Int64Array
    fired_atoms: Int64Array
    combined_pointer: Int64Array
    combined_code: Int64Array
    combined_bit: Int64Array
    weak_marks: Int64Array
    strong_marks: Int64Array
    all_weak: Int64Array
    required: Int64Array


class Edges(NamedTuple):
    """The automaton's edges in CSR form, and the position of its state in the words.

    `positive` and `negative` have the words of a letter, `marks` those of the marks, by edge.
    """

    pointer: Int64Array
    positive: Int64Array
    negative: Int64Array
    marks: Int64Array
    target: Int64Array
    state_word: int
    state_shift: int
    state_mask: int


class Store(NamedTuple):
    """The states found so far, and their hash table: open addressing, tag and row plus one."""

    words: Int64Array
    table: Int64Array
    counters: Int64Array


class Scratch(NamedTuple):
    """Memory for the successors of one state.

    `box` and `codes` contain all of them with their hashes before the first is looked up: so the memory for
    the lookups can be prefetched, and waits overlap.
    """

    enabled: Int64Array
    enabled_set: Int64Array
    candidates: Int64Array
    letter: Int64Array
    stack: Int64Array
    weak_seen: Int64Array
    strong_seen: Int64Array
    box: Int64Array
    codes: Int64Array


#: counters: states stored, the source of the successor that did not fit into its cell, and whether states
#: may be added (no argument of `expand`: Numba would compile it for each value).
STATES, OVERFLOW_STATE, MAY_ADD = range(3)
CELL_OVERFLOW = -1

#: Bits of a word of a letter, or of marks.
BITS = 62
#: Operations of combinations.
NOT, AND, OR, TRUE, FALSE = Combined.NOT, Combined.AND, Combined.OR, Combined.TRUE, Combined.FALSE


@kernel(inline="always")
def find(store, box, at, code):  # type: ignore[no-untyped-def]
    """Return the index of the state in a row of a box, added if that is allowed; -1: it is not stored."""
    table, words = store.table, store.words
    mask = table.size - 1
    slot, tag = code & mask, code >> TAG_SHIFT
    while table[slot] != 0:
        entry = table[slot]
        if entry >> INDEX_BITS == tag:
            index = (entry & INDEX_MASK) - 1
            same = True
            for w in range(box.shape[1]):
                same &= words[index, w] == box[at, w]
            if same:
                return index
        slot = (slot + 1) & mask
    if store.counters[MAY_ADD] == 0:
        return np.int64(-1)
    index = store.counters[STATES]
    store.counters[STATES] = index + 1
    table[slot] = tag << INDEX_BITS | (index + 1)
    for w in range(box.shape[1]):
        words[index, w] = box[at, w]
    return index


@kernel(inline="always")
def find_enabled(steps, store, scratch, state):  # type: ignore[no-untyped-def]
    """List the transitions enabled in a state; return their number."""
    count = 0
    enabled_in(steps, store.words, state, scratch.enabled_set)
    for s in range(scratch.enabled_set.size):
        bits = scratch.enabled_set[s]
        while bits != 0:
            scratch.enabled[count] = 64 * s + lowest_bit(bits)
            bits &= bits - 1
            count += 1
    return count


@kernel(inline="always")
def read_letter(steps, conditions, store, scratch, state, count):  # type: ignore[no-untyped-def]
    """Write the bits of the atoms that are true in a state whose `count` enabled transitions are listed."""
    letter = scratch.letter
    for w in range(letter.size):
        letter[w] = conditions.deadlock_bits[w] if count == 0 else 0
    for a in range(conditions.linear_bit.size):
        total = sum_of(steps, conditions, store.words, state, a)
        bound, kind = conditions.linear_bound[a], conditions.linear_operator[a]
        if (
            (kind == 0 and total <= bound)
            or (kind == 1 and total >= bound)
            or (kind == 2 and total == bound)
            or (kind == 3 and total != bound)
            or (kind == 4 and total < bound)
            or (kind == 5 and total > bound)
        ):
            bit = conditions.linear_bit[a]
            letter[bit // BITS] |= 1 << (bit % BITS)
    if conditions.asks_enabled != 0:
        for i in range(count):
            for w in range(letter.size):
                letter[w] |= conditions.enabled_bits[scratch.enabled[i], w]
    for c in range(conditions.combined_bit.size):
        if combination(conditions, scratch, c) != 0:
            bit = conditions.combined_bit[c]
            letter[bit // BITS] |= 1 << (bit % BITS)


@kernel()
def combination(conditions, scratch, c):  # type: ignore[no-untyped-def]
    """Evaluate a Boolean combination of known bits."""
    stack = scratch.stack
    top = 0
    for k in range(conditions.combined_pointer[c], conditions.combined_pointer[c + 1]):
        code = conditions.combined_code[k]
        if code >= 0:
            stack[top] = (scratch.letter[code // BITS] >> (code % BITS)) & 1
            top += 1
        elif code == NOT:
            stack[top - 1] = 1 - stack[top - 1]
        elif code <= TRUE:
            stack[top] = 1 if code == TRUE else 0
            top += 1
        else:
            top -= 1
            left, right = stack[top - 1], stack[top]
            if code == AND:
                stack[top - 1] = left & right
            elif code == OR:
                stack[top - 1] = left | right
            else:
                stack[top - 1] = 1 if left == right else 0
    return stack[0]


@kernel()
def expand(  # type: ignore[no-untyped-def]
    steps, conditions, edges, store, scratch, state, targets, labels, top
):  # fmt: skip
    """Write a state's edges in the product behind position `top`; return the new top or CELL_OVERFLOW.

    ``scratch.weak_seen`` and ``strong_seen`` get the marks of weakly fair transitions that are disabled and
    of strongly fair ones that are enabled. If states may not be added, edges to new ones are left out.
    """
    words, delta, guards = store.words, steps.delta, steps.guards
    box, codes = scratch.box, scratch.codes
    transitions = delta.shape[0] - 1
    count = find_enabled(steps, store, scratch, state)
    read_letter(steps, conditions, store, scratch, state, count)
    letter = scratch.letter
    for m in range(scratch.weak_seen.size):
        scratch.weak_seen[m] = conditions.all_weak[m]
        scratch.strong_seen[m] = 0
    for i in range(count):
        t = scratch.enabled[i]
        for m in range(scratch.weak_seen.size):
            scratch.weak_seen[m] &= ~conditions.weak_marks[t, m]
            scratch.strong_seen[m] |= conditions.strong_marks[t, m]
    q = (words[state, edges.state_word] >> edges.state_shift) & edges.state_mask
    possible = 0
    for e in range(edges.pointer[q], edges.pointer[q + 1]):
        wrong = 0
        for w in range(letter.size):
            wrong |= edges.positive[e, w] & ~conditions.fired_atoms[w] & ~letter[w]
            wrong |= edges.negative[e, w] & letter[w]
        if wrong == 0:
            scratch.candidates[possible] = e
            possible += 1
    if possible == 0:
        return top
    mask = store.table.size - 1
    choices = count if count > 0 else 1
    width = edges.target.size
    end = top
    for j in range(possible):
        e = scratch.candidates[j]
        moved = (edges.target[e] - q) << edges.state_shift
        asked = 0
        for w in range(letter.size):
            asked |= (edges.positive[e, w] | edges.negative[e, w]) & conditions.fired_atoms[w]
        for i in range(choices):
            t = scratch.enabled[i] if count > 0 else transitions
            wrong = 0
            if asked != 0:
                for w in range(letter.size):
                    fired = conditions.fired_bits[t, w]
                    wrong |= edges.positive[e, w] & conditions.fired_atoms[w] & ~fired
                    wrong |= edges.negative[e, w] & fired
            if wrong == 0:
                at = end - top
                overflows = 0
                for w in range(guards.size):
                    box[at, w] = words[state, w] + delta[t, w]
                    overflows |= box[at, w] & guards[w]
                if overflows != 0:
                    store.counters[OVERFLOW_STATE] = state
                    return np.int64(CELL_OVERFLOW)
                box[at, edges.state_word] += moved
                codes[at] = hash_words(box, at, guards)
                prefetch(store.table, codes[at] & mask)
                labels[end] = t * width + e
                end += 1
    for at in range(end - top):
        entry = store.table[codes[at] & mask]
        if entry != 0 and entry >> INDEX_BITS == codes[at] >> TAG_SHIFT:
            prefetch(words, (entry & INDEX_MASK) - 1)
    kept = top
    for at in range(end - top):
        index = find(store, box, at, codes[at])
        if index >= 0:
            targets[kept] = index
            labels[kept] = labels[top + at]
            kept += 1
    return kept
