"""Kernels of walks: firings one after the other, and which transitions they enable."""

from __future__ import annotations

import numpy as np

from dineros.analysis.nets.kernel_cache import kernel

#: Firings that are not in the solution, for each that is.
OTHERS = 1


@kernel()
def walk(  # type: ignore[no-untyped-def]
    pointer, transition, weight, inhibits, asked, change_pointer, change_place, change_tokens,
    initial, priority, rows, fired, length, seed,
):  # fmt: skip
    """Write the markings of one walk; return how many, and whether it ended in a deadlock."""
    np.random.seed(seed)
    size = asked.size
    marking = initial.copy()
    missing = asked.copy()
    for p in range(marking.size):
        for k in range(pointer[p], pointer[p + 1]):
            if (marking[p] >= weight[k]) != (inhibits[k] == 1):
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
    written = 0
    while written < rows.shape[0] and written < length:
        rows[written, :] = marking
        written += 1
        if count == 0:
            return written, True
        t = enabled[np.random.randint(count)]
        if np.random.random() < 0.5:
            other = enabled[np.random.randint(count)]
            if priority[other] > priority[t]:
                t = other
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
                            fired[u] = True
                    else:
                        if missing[u] == 0:
                            count -= 1
                            last = enabled[count]
                            enabled[position[u]] = last
                            position[last] = position[u]
                            position[u] = -1
                        missing[u] += 1
    return written, False


@kernel()
def follow(  # type: ignore[no-untyped-def]
    pointer, transition, weight, inhibits, asked, change_pointer, change_place, change_tokens,
    initial, counts, rows, seed,
):  # fmt: skip
    """Write the markings of a walk, around; return how many they were."""
    np.random.seed(seed)
    size = asked.size
    marking = initial.copy()
    missing = asked.copy()
    for p in range(marking.size):
        for k in range(pointer[p], pointer[p + 1]):
            if (marking[p] >= weight[k]) != (inhibits[k] == 1):
                missing[transition[k]] -= 1
    enabled = np.empty(size, dtype=np.int64)
    position = np.full(size, -1, dtype=np.int64)
    count = 0
    for t in range(size):
        if missing[t] == 0:
            enabled[count] = t
            position[t] = count
            count += 1
    left = counts.sum()
    others = OTHERS * left + 10
    written = 0
    while True:
        rows[written % rows.shape[0], :] = marking
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
