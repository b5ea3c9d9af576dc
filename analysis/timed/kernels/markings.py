"""Kernels for the markings of state classes, and what firing a transition does to them.

All that does not depend on clocks is found once for each marking: the enabled transitions, and for each of
them the next marking and the clocks that continue.
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.nets.kernel_cache import kernel

(
    MARKINGS,
    ENABLED,
    KEPT,
    CLASSES,
    CODES,
    EDGES,
    TODO,
    NEXT,
    DEADLOCKS,
    MOST_CLOCKS,
    REMOVED,
    STATUS,
) = range(12)
CONTROL_SIZE = 12

INDEX_BITS = 40
INDEX_MASK = (1 << INDEX_BITS) - 1
TAG_SHIFT = 41
UNKNOWN = -1


@kernel(inline="always")
def mixed(code, word):  # type: ignore[no-untyped-def]
    """Take a word into a hash."""
    code = (code ^ word) * 0x1E3779B97F4A7C15
    return code ^ ((code >> 32) & 0xFFFFFFFF)


@kernel(inline="always")
def finished(code):  # type: ignore[no-untyped-def]
    """Return the hash, not negative."""
    code *= 0x2545F4914F6CDD1D
    return (code ^ (code >> 29)) & 0x7FFFFFFFFFFFFFFF


@kernel()
def is_enabled(net, tokens, transition):  # type: ignore[no-untyped-def]
    """Whether a marking has enough tokens, and few enough for inhibitor arcs."""
    for arc in range(net.test_start[transition], net.test_start[transition + 1]):
        if tokens[net.test_place[arc]] < net.test_weight[arc]:
            return False
    for arc in range(net.inhibitor_start[transition], net.inhibitor_start[transition + 1]):
        if tokens[net.inhibitor_place[arc]] >= net.inhibitor_weight[arc]:
            return False
    return True


@kernel()
def hash_of(tokens):  # type: ignore[no-untyped-def]
    """Hash of a marking."""
    code = 0
    for place in range(tokens.size):
        code = mixed(code, np.int64(tokens[place]))
    return finished(code)


@kernel()
def number_of(net, known, tokens):  # type: ignore[no-untyped-def]
    """Return the number of a marking; one that is new is stored with its enabled transitions.

    Transitions with a clock stand before those without. There must be room.
    """
    control = known.control
    code = hash_of(tokens)
    mask = known.marking_table.size - 1
    slot, tag = code & mask, code >> TAG_SHIFT
    while known.marking_table[slot] != 0:
        entry = known.marking_table[slot]
        if entry >> INDEX_BITS == tag:
            row = (entry & INDEX_MASK) - 1
            is_same = True
            for place in range(tokens.size):
                if known.markings[row, place] != tokens[place]:
                    is_same = False
                    break
            if is_same:
                return row
        slot = (slot + 1) & mask
    row = control[MARKINGS]
    control[MARKINGS] = row + 1
    known.marking_table[slot] = tag << INDEX_BITS | (row + 1)
    for place in range(tokens.size):
        known.markings[row, place] = tokens[place]
    at = control[ENABLED]
    known.enabled_start[row] = at
    for wants_clock in (True, False):
        for transition in range(net.has_clock.size):
            if net.has_clock[transition] == wants_clock and is_enabled(net, tokens, transition):
                known.enabled[at] = transition
                known.next_marking[at] = UNKNOWN
                at += 1
        if wants_clock:
            known.clocks[row] = at - known.enabled_start[row]
            control[MOST_CLOCKS] = max(control[MOST_CLOCKS], known.clocks[row])
    known.enabled_start[row + 1] = at
    control[ENABLED] = at
    known.first_class[row] = UNKNOWN
    return row


@kernel()
def fire_once(net, known, row, at, tokens):  # type: ignore[no-untyped-def]
    """Fire the enabled transition at a position for the first time in a marking.

    Notes the next marking, and by clock of that the number of the clock that continues: from 1, or 0 if it
    starts again. A clock continues if its transition is enabled in both markings and while the tokens are
    taken, and is not the one that fires.
    """
    fired = known.enabled[at]
    for place in range(tokens.size):
        tokens[place] = known.markings[row, place]
    for arc in range(net.take_start[fired], net.take_start[fired + 1]):
        tokens[net.take_place[arc]] -= net.take_weight[arc]
    first, clocks = known.enabled_start[row], known.clocks[row]
    goes_on = np.zeros(clocks, dtype=np.bool_)
    for clock in range(clocks):
        other = known.enabled[first + clock]
        goes_on[clock] = other != fired and is_enabled(net, tokens, other)
    for arc in range(net.put_start[fired], net.put_start[fired + 1]):
        tokens[net.put_place[arc]] += net.put_weight[arc]
    after = number_of(net, known, tokens)
    kept = known.control[KEPT]
    clock = 0  # both lists are in the order of transitions
    for number in range(known.clocks[after]):
        transition = known.enabled[known.enabled_start[after] + number]
        while clock < clocks and known.enabled[first + clock] < transition:
            clock += 1
        is_kept = clock < clocks and known.enabled[first + clock] == transition and goes_on[clock]
        known.kept[kept + number] = clock + 1 if is_kept else 0
    known.control[KEPT] = kept + known.clocks[after]
    known.kept_start[at] = kept
    known.next_marking[at] = after


@kernel()
def find_markings_again(known):  # type: ignore[no-untyped-def]
    """Put all markings into a fresh table."""
    mask = known.marking_table.size - 1
    for row in range(known.control[MARKINGS]):
        code = hash_of(known.markings[row])
        slot = code & mask
        while known.marking_table[slot] != 0:
            slot = (slot + 1) & mask
        known.marking_table[slot] = (code >> TAG_SHIFT) << INDEX_BITS | (row + 1)
