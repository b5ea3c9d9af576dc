"""Kernels of walks: firings one after the other, and which transitions they enable.

Nets are those of `NetArrays.parts`. The state of a walk is its marking and, by transition, how many of its
arcs ask for what is not there: `enabled` lists those that lack nothing, `position` says where.
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.nets.kernel_cache import kernel

#: Firings that are not in the solution, for each that is.
OTHERS = 1


@kernel()
def begin(net, initial, fired):  # type: ignore[no-untyped-def]
    """Return the state of a walk at a marking and how many transitions it enables; note these in `fired`."""
    pointer, transition, weight, inhibits, asked, _, _, _ = net
    size = asked.size
    missing = asked.copy()
    for p in range(initial.size):
        for k in range(pointer[p], pointer[p + 1]):
            if (initial[p] >= weight[k]) != (inhibits[k] == 1):
                missing[transition[k]] -= 1
    enabled = np.empty(size, dtype=np.int64)
    position = np.full(size, -1, dtype=np.int64)
    count = 0
    for t in range(size):
        if missing[t] == 0:
            enabled[count] = t
            position[t] = count
            count += 1
            fired[t] = True
    return (initial.copy(), missing, enabled, position), count


@kernel()
def fire(net, state, count, t, fired):  # type: ignore[no-untyped-def]
    """Fire a transition; return how many are enabled then, and note those that have come in `fired`."""
    pointer, transition, weight, inhibits, _, change_pointer, change_place, change_tokens = net
    marking, missing, enabled, position = state
    for c in range(change_pointer[t], change_pointer[t + 1]):
        p = change_place[c]
        before = marking[p]
        after = before + change_tokens[c]
        marking[p] = after
        for k in range(pointer[p], pointer[p + 1]):
            was, now = before >= weight[k], after >= weight[k]
            if was != now:
                u = transition[k]
                if now != (inhibits[k] == 1):
                    missing[u] -= 1
                    if missing[u] == 0:
                        enabled[count] = u
                        position[u] = count
                        count += 1
                else:
                    if missing[u] == 0:
                        count -= 1
                        last = enabled[count]
                        enabled[position[u]] = last
                        position[last] = position[u]
                        position[u] = -1
                    missing[u] += 1
    # Only now: between two changes of one firing, transitions may lack nothing that no marking enables.
    for c in range(change_pointer[t], change_pointer[t + 1]):
        p = change_place[c]
        for k in range(pointer[p], pointer[p + 1]):
            if missing[transition[k]] == 0:
                fired[transition[k]] = True
    return count


@kernel()
def walk(net, initial, priority, rows, fired, length, seed):  # type: ignore[no-untyped-def]
    """Write the markings of one walk; return how many, and whether it ended in a deadlock."""
    np.random.seed(seed)
    state, count = begin(net, initial, fired)
    marking, enabled = state[0], state[2]
    written = 0
    while written < rows.shape[0] and written < length:
        for p in range(marking.size):
            rows[written, p] = marking[p]
        written += 1
        if count == 0:
            return written, True
        t = enabled[np.random.randint(count)]
        if np.random.random() < 0.5:
            other = enabled[np.random.randint(count)]
            if priority[other] > priority[t]:
                t = other
        count = fire(net, state, count, t, fired)
    return written, False


@kernel()
def follow(net, initial, counts, rows, seed):  # type: ignore[no-untyped-def]
    """Write the markings of a walk that fires transitions so often, around; return how many they were."""
    np.random.seed(seed)
    fired = np.zeros(counts.size, dtype=np.bool_)
    state, count = begin(net, initial, fired)
    marking, enabled = state[0], state[2]
    left = counts.sum()
    others = OTHERS * left + 10
    written = 0
    while True:
        for p in range(marking.size):
            rows[written % rows.shape[0], p] = marking[p]
        written += 1
        if left == 0 or count == 0 or others == 0:
            return written
        start = np.random.randint(count)
        t = -1
        for k in range(count):
            u = enabled[(start + k) % count]
            if counts[u] > 0:
                t = u
                break
        if t >= 0:
            counts[t] -= 1
            left -= 1
        else:
            t = enabled[start]
            others -= 1
        count = fire(net, state, count, t, fired)
