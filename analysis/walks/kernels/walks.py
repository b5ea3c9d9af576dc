"""Kernels of walks: firings one after the other, and which transitions they enable.

Nets are those of `NetArrays.parts`. The state of a walk is its marking and, by transition, how many of its
arcs ask for what is not there: `enabled` lists those that lack nothing, `position` says where.
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.nets.kernel_cache import kernel

#: Firings that are not in the solution, for each that is.
OTHERS = 1

ENDED, DEADLOCK, GREW = 0, 1, 2
"""How a walk ended: after as many firings as there was room for, with none enabled, with a loop."""


@kernel()
def begin(net, initial, first):  # type: ignore[no-untyped-def]
    """Return the state of a walk at a marking and how many transitions it enables.

    In `first`, by transition, stands after how many firings it was first enabled; less than 0: never yet.
    """
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
            first[t] = max(first[t], 0)
    return (initial.copy(), missing, enabled, position), count


@kernel()
def fire(net, state, count, t, first, firings):  # type: ignore[no-untyped-def]
    """Fire a transition as the next firing; record what is new in `first`; return how many are enabled."""
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
            if missing[transition[k]] == 0 and first[transition[k]] < 0:
                first[transition[k]] = firings + 1
    return count


@kernel()
def drawn(enabled, count, priority):  # type: ignore[no-untyped-def]
    """Draw one of the enabled transitions; every other time, draw two and take the one of higher priority."""
    t = enabled[np.random.randint(count)]
    if np.random.random() < 0.5:
        other = enabled[np.random.randint(count)]
        if priority[other] > priority[t]:
            t = other
    return t


@kernel()
def led(enabled, count, left):  # type: ignore[no-untyped-def]
    """Draw one of the enabled transitions that are still to be fired; less than 0: there is none."""
    start = np.random.randint(count)
    for k in range(count):
        u = enabled[(start + k) % count]
        if left[u] > 0:
            return u
    return -1


@kernel()
def firings_in(counts):  # type: ignore[no-untyped-def]
    """Return the sum; with that of NumPy, a cached kernel would import SciPy when it is loaded."""
    total = 0
    for t in range(counts.size):
        total += counts[t]
    return total


@kernel()
def copy_numbers(source, target):  # type: ignore[no-untyped-def]
    """Copy an array into one of the same size, without the code for an error of its shape."""
    for k in range(source.size):
        target[k] = source[k]


@kernel()
def walk(net, initial, priority, rows, first, length, seed):  # type: ignore[no-untyped-def]
    """Write the markings of one walk; return how many, and whether it ended in a deadlock."""
    np.random.seed(seed)
    state, count = begin(net, initial, first)
    marking, enabled = state[0], state[2]
    written = 0
    while written < rows.shape[0] and written < length:
        for p in range(marking.size):
            rows[written, p] = marking[p]
        written += 1
        if count == 0:
            return written, True
        t = drawn(enabled, count, priority)
        count = fire(net, state, count, t, first, written - 1)
    return written, False


@kernel()
def follow(net, initial, counts, rows, seed):  # type: ignore[no-untyped-def]
    """Write the markings of a walk that fires transitions so often, around; return how many they were."""
    np.random.seed(seed)
    first = np.zeros(counts.size, dtype=np.int64)
    state, count = begin(net, initial, first)
    marking, enabled = state[0], state[2]
    left = firings_in(counts)
    others = OTHERS * left + 10
    written = 0
    while True:
        for p in range(marking.size):
            rows[written % rows.shape[0], p] = marking[p]
        written += 1
        if left == 0 or count == 0 or others == 0:
            return written
        t = led(enabled, count, counts)
        if t >= 0:
            counts[t] -= 1
            left -= 1
        else:
            t = enabled[np.random.randint(count)]
            others -= 1
        count = fire(net, state, count, t, first, written - 1)


@kernel()
def scout(net, initial, priority, counts, wanted, sequence, first, seed):  # type: ignore[no-untyped-def]
    """Walk once, and write what is fired; return how many firings, how it ended, and where its loop begins.

    If transitions are to be fired so often (`counts`), these come first, again and again. Firings that
    lead from a marking to one with as many tokens everywhere, and more at a wanted place, end the walk: they
    are its loop. Markings are compared with one that is taken again after twice as many firings each time.
    """
    np.random.seed(seed)
    state, count = begin(net, initial, first)
    marking, enabled = state[0], state[2]
    change_pointer, change_place, change_tokens = net[5], net[6], net[7]
    before = initial.copy()
    fewer, more = 0, 0
    start, window = 0, 1
    left = counts.copy()
    total = firings_in(counts)
    remaining = total
    for step in range(sequence.size):
        if count == 0:
            return step, DEADLOCK, -1
        t = led(enabled, count, left) if remaining > 0 else -1
        if t >= 0:
            left[t] -= 1
            remaining -= 1
        else:
            t = drawn(enabled, count, priority)
        sequence[step] = t
        count = fire(net, state, count, t, first, step)
        for c in range(change_pointer[t], change_pointer[t + 1]):
            p = change_place[c]
            now, was, then = marking[p], marking[p] - change_tokens[c], before[p]
            fewer += (now < then) - (was < then)
            if wanted[p]:
                more += (now > then) - (was > then)
        if fewer == 0 and more > 0:
            return step + 1, GREW, start
        is_round = total == 0 or remaining == 0
        if total > 0 and remaining == 0:
            copy_numbers(counts, left)
            remaining = total
        if is_round and step + 1 - start >= window:
            copy_numbers(marking, before)
            fewer, more = 0, 0
            start = step + 1
            if total == 0:
                window *= 2
    return sequence.size, ENDED, -1
