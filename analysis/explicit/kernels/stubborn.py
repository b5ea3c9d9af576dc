"""Stubborn sets: subsets of the enabled transitions of a marking that suffice for a question.

A set of transitions is closed as follows. For a disabled member, one violated condition is chosen, and all
transitions that can make it hold are added (so no transition outside can enable the member). For an enabled
member, all transitions are added that could disable it or that it could disable (so the member commutes with
all transitions outside and stays a key transition, rules D1 and D2). Started from an enabled transition, this
preserves all deadlocks; started from all transitions that can bring a goal nearer, it preserves shortest
traces to the goal.

References
----------
A. Valmari, *The state explosion problem*, Lectures on Petri Nets I, LNCS 1491, 1998. L. M. Kristensen, K.
Schmidt, A. Valmari, *Question-guided stubborn set methods for state properties*, Formal Methods in System
Design 29, 2006.
"""

from __future__ import annotations

import numpy as np
from numba.cpython.unsafe.numbers import trailing_zeros

from dineros.analysis.nets.kernel_cache import kernel


@kernel(inline="always")
def lowest_bit(bits):  # type: ignore[no-untyped-def]
    """Position of the lowest bit that is set."""
    return trailing_zeros(bits)  # type: ignore[call-arg]


@kernel()
def read_tokens(net, stubborn, store, row, tokens):  # type: ignore[no-untyped-def]
    """Tokens of every place in a stored marking."""
    for k in range(net.word.size):
        code = (store[row, net.word[k]] >> net.shift[k]) & net.mask[k]
        first, last = stubborn.cell_start[k], stubborn.cell_start[k + 1]
        for i in range(first, last):
            if net.is_wide[k]:
                tokens[stubborn.cell_place[i]] = code
            else:
                at = stubborn.value_offset[k] + code * (last - first) + i - first
                tokens[stubborn.cell_place[i]] = stubborn.values[at]


@kernel()
def add(members, todo, size, transition):  # type: ignore[no-untyped-def]
    """Add a transition to the set, and to those still to be closed; return how many these are."""
    if members[transition] == 0:
        members[transition] = 1
        todo[size] = transition
        return size + 1
    return size


@kernel()
def close(stubborn, tokens, enabled, members, todo, size):  # type: ignore[no-untyped-def]
    """Add the transitions required by the first `size` ones of `todo`; return the number of enabled ones."""
    count = 0
    while size > 0:
        size -= 1
        t = todo[size]
        if (enabled[t >> 6] >> (t & 63)) & 1:
            count += 1
            for i in range(stubborn.conflict_start[t], stubborn.conflict_start[t + 1]):
                size = add(members, todo, size, stubborn.conflict[i])
            continue
        # Of the violated conditions, choose the one that the fewest transitions can make hold.
        place, is_raised, fewest = -1, True, 0
        for i in range(stubborn.pre_start[t], stubborn.pre_start[t + 1]):
            p = stubborn.pre_place[i]
            few = stubborn.raising_start[p + 1] - stubborn.raising_start[p]
            if tokens[p] < stubborn.pre_weight[i] and (place < 0 or few < fewest):
                place, fewest = p, few
        for i in range(stubborn.inhibitor_start[t], stubborn.inhibitor_start[t + 1]):
            p = stubborn.inhibitor_place[i]
            few = stubborn.lowering_start[p + 1] - stubborn.lowering_start[p]
            if tokens[p] >= stubborn.inhibitor_weight[i] and (place < 0 or few < fewest):
                place, is_raised, fewest = p, False, few
        if is_raised:
            for i in range(stubborn.raising_start[place], stubborn.raising_start[place + 1]):
                size = add(members, todo, size, stubborn.raising[i])
        else:
            for i in range(stubborn.lowering_start[place], stubborn.lowering_start[place + 1]):
                size = add(members, todo, size, stubborn.lowering[i])
    return count


@kernel()
def add_towards_goals(stubborn, goals, wanted, sums, members, todo):  # type: ignore[no-untyped-def]
    """Start a set with all transitions that can bring an open goal nearer; return their number."""
    size = 0
    for s in range(wanted.size):
        bits = wanted[s]
        while bits != 0:
            size = add(members, todo, size, 64 * s + lowest_bit(bits))
            bits &= bits - 1
    for goal in range(goals.is_open.size):
        if goals.is_open[goal] == 0:
            continue
        # One violated constraint is sufficient: it must become true in every trace to the goal.
        chosen = -1
        for c in range(goals.constraint_start[goal], goals.constraint_start[goal + 1]):
            few = stubborn.helping_start[c + 1] - stubborn.helping_start[c]
            if sums[c] < goals.least[c] and (
                chosen < 0 or few < stubborn.helping_start[chosen + 1] - stubborn.helping_start[chosen]
            ):
                chosen = c
        if chosen >= 0:
            for i in range(stubborn.helping_start[chosen], stubborn.helping_start[chosen + 1]):
                size = add(members, todo, size, stubborn.helping[i])
    return size


@kernel()
def keep_stubborn(stubborn, goals, wanted, tokens, sums, enabled):  # type: ignore[no-untyped-def]
    """Reduce an enabled set to a stubborn subset."""
    transitions = stubborn.pre_start.size - 1
    best = np.zeros(enabled.size, dtype=np.int64)
    members = np.zeros(transitions, dtype=np.int64)
    todo = np.empty(transitions, dtype=np.int64)
    size = add_towards_goals(stubborn, goals, wanted, sums, members, todo)
    found = close(stubborn, tokens, enabled, members, todo, size)
    if stubborn.keeps_deadlocks and found == 0:
        fewest = -1
        trial = np.empty(transitions, dtype=np.int64)
        for s in range(enabled.size):
            bits = enabled[s]
            while bits != 0 and fewest != 1:
                seed = 64 * s + lowest_bit(bits)
                bits &= bits - 1
                trial[:] = 0
                count = close(stubborn, tokens, enabled, trial, todo, add(trial, todo, 0, seed))
                if fewest < 0 or count < fewest:
                    fewest = count
                    for t in range(transitions):
                        members[t] = trial[t]
    for t in range(transitions):
        if members[t]:
            best[t >> 6] |= 1 << (t & 63)
    for s in range(enabled.size):
        enabled[s] &= best[s]
