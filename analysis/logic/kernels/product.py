"""Kernels on the product of a net and an automaton: the table of states, and successors.

A state of the product is a packed marking with the automaton's state in the last field; its hash is linear in
its words (before mixing), so that the hash of a successor is a sum. An edge is a step of the net (a
transition, or staying in a deadlock) read by an edge of the automaton; its label is ``transition * automaton
edges + automaton edge``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from dineros.analysis.logic.language.atoms import Combined

Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]
Words = NDArray[np.uint64]


class Triggers(NamedTuple):
    """Transitions grouped by one input place, so that only those with this place marked are looked at.

    `mask` has the fields of these places, ``group_of_bit[word]`` the group of each bit by its De Bruijn
    number, `without` a word with a group's field cleared. Groups are in CSR form; `always` lists transitions
    without input places.
    """

    mask: Words
    group_of_bit: Int32Array
    without: Words
    pointer: Int64Array
    transitions: Int64Array
    always: Int64Array


class NetTables(NamedTuple):
    """Arcs of a net for one layout, in CSR form by transition: words touched and the value for each."""

    pre_pointer: Int64Array
    pre_word: Int64Array
    pre_value: Words
    inhibitor_pointer: Int64Array
    inhibitor_word: Int64Array
    inhibitor_value: Words
    inhibitor_guard: Words
    change_pointer: Int64Array
    change_word: Int64Array
    change_value: Words
    hash_change: Words
    guards: Words
    multipliers: Words
    triggers: Triggers


class Conditions(NamedTuple):
    """Atoms and fairness; both are bits in words of 62. The last row by transition is a deadlock's.

    Combinations are in CSR form: numbers of bits, and negative codes of operations (`atoms.Combined`).
    """

    linear_pointer: Int64Array
    linear_word: Int64Array
    linear_shift: Words
    linear_mask: Words
    linear_factor: Int64Array
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
    """The automaton's edges in CSR form, and where its state stands in the words.

    `positive` and `negative` have the words of a letter, `marks` those of the marks, by edge.
    """

    pointer: Int64Array
    positive: Int64Array
    negative: Int64Array
    marks: Int64Array
    target: Int64Array
    state_word: int
    state_shift: int


class Store(NamedTuple):
    """States found so far, and an open-addressing table of 32 bits of hash and 32 of index + 1; 0: free."""

    words: Words
    table: Words
    counters: Int64Array


class Scratch(NamedTuple):
    """Room for the successors of one state.

    `hashes`, `entries` and `touched` let the kernels read the table for all successors before they look at
    the first: the reads miss the cache, and so they wait together instead of one after the other.
    """

    enabled: Int64Array
    candidates: Int64Array
    letter: Int64Array
    stack: Int64Array
    weak_seen: Int64Array
    strong_seen: Int64Array
    successor: Words
    hashes: Words
    entries: Words
    touched: Words


#: counters: states stored, the transition and source whose successor had no room in its field, and whether
#: states may be added (no argument of `expand`: Numba would compile it for each value).
STATES, OVERFLOW_TRANSITION, OVERFLOW_STATE, MAY_ADD = range(4)
FIELD_OVERFLOW = -1

#: Bits of a word of a letter, or of marks.
BITS = 62
#: Operations of combinations.
NOT, AND, OR, TRUE, FALSE = Combined.NOT, Combined.AND, Combined.OR, Combined.TRUE, Combined.FALSE

#: Multiplied by a power of two, its highest six bits tell which one (Leiserson, Prokop, Randall, 1998).
DE_BRUIJN = 0x03F79D71B4CB0A89
MIX = np.uint64(0xD6E8FEB86659FD93)
HALF = np.uint64(32)
LOW = np.uint64(0xFFFFFFFF)
ZERO = np.uint64(0)
ONE = np.uint64(1)


@njit(cache=True, inline="always")
def mixed(value):  # type: ignore[no-untyped-def]
    """Spread a linear hash over all bits."""
    value ^= value >> HALF
    value *= MIX
    value ^= value >> HALF
    value *= MIX
    return value ^ (value >> HALF)


@njit(cache=True)
def linear_hash(words, multipliers):  # type: ignore[no-untyped-def]
    """Sum of words times odd constants."""
    total = ZERO
    for i in range(words.size):
        total += words[i] * multipliers[i]
    return total


@njit(cache=True)
def find(store, vector, hash_value):  # type: ignore[no-untyped-def]
    """Return the index of a state, adding it if that is allowed; -1 if it is not there."""
    code = mixed(hash_value)
    table, words = store.table, store.words
    last = np.uint64(table.size - 1)
    slot = code & last
    tag = code >> HALF
    while True:
        entry = table[slot]
        if entry == ZERO:
            break
        if entry >> HALF == tag:
            index = np.int64(entry & LOW) - 1
            same = True
            for i in range(vector.size):
                if words[index, i] != vector[i]:
                    same = False
                    break
            if same:
                return index
        slot = (slot + ONE) & last
    if store.counters[MAY_ADD] == 0:
        return np.int64(-1)
    index = store.counters[STATES]
    store.counters[STATES] = index + 1
    table[slot] = (tag << HALF) | np.uint64(index + 1)
    for i in range(vector.size):
        words[index, i] = vector[i]
    return index


@njit(cache=True)
def fill_table(store, multipliers):  # type: ignore[no-untyped-def]
    """Enter all stored states into an empty table."""
    last = np.uint64(store.table.size - 1)
    for index in range(store.counters[STATES]):
        code = mixed(linear_hash(store.words[index], multipliers))
        slot = code & last
        while store.table[slot] != ZERO:
            slot = (slot + ONE) & last
        store.table[slot] = ((code >> HALF) << HALF) | np.uint64(index + 1)


@njit(cache=True, inline="always")
def is_enabled(net, vector, t):  # type: ignore[no-untyped-def]
    """Whether a transition is enabled in a state."""
    for k in range(net.pre_pointer[t], net.pre_pointer[t + 1]):
        w = net.pre_word[k]
        guard = net.guards[w]
        if ((vector[w] | guard) - net.pre_value[k]) & guard != guard:
            return False
    for k in range(net.inhibitor_pointer[t], net.inhibitor_pointer[t + 1]):
        w = net.inhibitor_word[k]
        if ((vector[w] | net.guards[w]) - net.inhibitor_value[k]) & net.inhibitor_guard[k] != ZERO:
            return False
    return True


@njit(cache=True)
def find_enabled(net, vector, enabled):  # type: ignore[no-untyped-def]
    """List the transitions enabled in a state; return how many there are."""
    count = 0
    triggers = net.triggers
    for w in range(vector.size):
        marked = vector[w] & triggers.mask[w]
        while marked != ZERO:
            lowest = marked & (~marked + ONE)
            group = triggers.group_of_bit[w, (lowest * np.uint64(DE_BRUIJN)) >> np.uint64(58)]
            marked &= triggers.without[group]
            for k in range(triggers.pointer[group], triggers.pointer[group + 1]):
                t = triggers.transitions[k]
                if is_enabled(net, vector, t):
                    enabled[count] = t
                    count += 1
    for t in triggers.always:
        if is_enabled(net, vector, t):
            enabled[count] = t
            count += 1
    return count


@njit(cache=True)
def read_letter(conditions, scratch, vector, count):  # type: ignore[no-untyped-def]
    """Write the bits of the atoms that are true in a state whose `count` enabled transitions are listed."""
    letter = scratch.letter
    for w in range(letter.size):
        letter[w] = conditions.deadlock_bits[w] if count == 0 else 0
    for a in range(conditions.linear_bit.size):
        total = 0
        for k in range(conditions.linear_pointer[a], conditions.linear_pointer[a + 1]):
            field = (
                vector[conditions.linear_word[k]] >> conditions.linear_shift[k]
            ) & conditions.linear_mask[k]
            total += conditions.linear_factor[k] * np.int64(field)
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


@njit(cache=True)
def combination(conditions, scratch, c):  # type: ignore[no-untyped-def]
    """Evaluate a boolean combination of bits that are known."""
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


@njit(cache=True)
def read_ahead(store, scratch, count):  # type: ignore[no-untyped-def]
    """Read what `find` will read first for each of the hashes."""
    last = np.uint64(store.table.size - 1)
    for k in range(count):
        scratch.entries[k] = store.table[mixed(scratch.hashes[k]) & last]
    for k in range(count):
        entry = scratch.entries[k]
        if entry != ZERO:
            index = np.int64(entry & LOW) - 1
            scratch.touched[k] = store.words[index, 0] ^ store.words[index, store.words.shape[1] - 1]


@njit(cache=True)
def expand(  # type: ignore[no-untyped-def]
    net, conditions, edges, store, scratch, state, targets, labels, top
):  # fmt: skip
    """Write a state's edges in the product behind position `top`; return the new top or FIELD_OVERFLOW.

    ``scratch.weak_seen`` and ``strong_seen`` get the marks of weakly fair transitions that are disabled and
    of strongly fair ones that are enabled. Where states may not be added, edges to new ones are left out.
    """
    vector = store.words[state]
    transitions = net.pre_pointer.size - 1
    count = find_enabled(net, vector, scratch.enabled)
    read_letter(conditions, scratch, vector, count)
    letter = scratch.letter
    for m in range(scratch.weak_seen.size):
        scratch.weak_seen[m] = conditions.all_weak[m]
        scratch.strong_seen[m] = 0
    for i in range(count):
        t = scratch.enabled[i]
        for m in range(scratch.weak_seen.size):
            scratch.weak_seen[m] &= ~conditions.weak_marks[t, m]
            scratch.strong_seen[m] |= conditions.strong_marks[t, m]
    q = np.int64(vector[edges.state_word] >> np.uint64(edges.state_shift))
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
    here = linear_hash(vector, net.multipliers)
    steps = count if count > 0 else 1
    width = edges.target.size
    end = top
    for j in range(possible):
        e = scratch.candidates[j]
        moved = np.uint64(edges.target[e] - q) << np.uint64(edges.state_shift)
        base = here + moved * net.multipliers[edges.state_word]
        asked = 0
        for w in range(letter.size):
            asked |= (edges.positive[e, w] | edges.negative[e, w]) & conditions.fired_atoms[w]
        for i in range(steps):
            t = scratch.enabled[i] if count > 0 else transitions
            wrong = 0
            if asked != 0:
                for w in range(letter.size):
                    fired = conditions.fired_bits[t, w]
                    wrong |= edges.positive[e, w] & conditions.fired_atoms[w] & ~fired
                    wrong |= edges.negative[e, w] & fired
            if wrong == 0:
                scratch.hashes[end - top] = base + net.hash_change[t]
                labels[end] = t * width + e
                end += 1
    read_ahead(store, scratch, end - top)
    successor = scratch.successor
    kept = top
    for k in range(top, end):
        t, e = labels[k] // width, labels[k] % width
        for w in range(vector.size):
            successor[w] = vector[w]
        if t < transitions:
            for c in range(net.change_pointer[t], net.change_pointer[t + 1]):
                w = net.change_word[c]
                successor[w] += net.change_value[c]
                if successor[w] & net.guards[w] != ZERO:
                    store.counters[OVERFLOW_TRANSITION] = t
                    store.counters[OVERFLOW_STATE] = state
                    return FIELD_OVERFLOW
        successor[edges.state_word] += np.uint64(edges.target[e] - q) << np.uint64(edges.state_shift)
        index = find(store, successor, scratch.hashes[k - top])
        if index >= 0:
            targets[kept] = index
            labels[kept] = labels[k]
            kept += 1
    return kept
