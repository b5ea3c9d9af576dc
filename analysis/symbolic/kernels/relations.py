"""Kernel that chains local tables to events; equal tails are shared."""

from __future__ import annotations

import numpy as np

from dineros.analysis.nets.kernel_cache import kernel


@kernel()
def chain(  # type: ignore[no-untyped-def]
    position, table_start, table_pairs, pair_source, pair_target, row_start, row_level, row_table,
    level, table, below, event_start, event_relation, pair_start, source, target,
):  # fmt: skip
    """Fill the arrays of `Relations` (see there) from those of `EventTables`."""
    events = row_start.size - 1
    slots = 16
    while slots < 4 * (row_level.size + 1):
        slots *= 2
    seen = np.zeros(slots, dtype=np.int64)
    chained = np.zeros(events, dtype=np.int64)
    count = 1
    for event in range(events):
        first, last = row_start[event], row_start[event + 1]
        done = 0
        tail = 0
        for _ in range(last - first):
            step, lowest = -1, 0
            for i in range(first, last):
                at = position[row_level[i]]
                if at > done and (step < 0 or at < lowest):
                    step, lowest = i, at
            done = lowest
            start = table_start[row_table[step]]
            slot = (lowest * 7919 + start * 104729 + tail * 1299709) & (slots - 1)
            while seen[slot] != 0:
                r = seen[slot]
                if level[r] == lowest and table[r] == start and below[r] == tail:
                    break
                slot = (slot + 1) & (slots - 1)
            if seen[slot] == 0:
                seen[slot] = count
                level[count], table[count], below[count] = lowest, start, tail
                count += 1
            tail = seen[slot]
        chained[event] = tail
    for event in range(events):
        event_start[level[chained[event]] + 1] += 1
    for k in range(1, event_start.size):
        event_start[k] += event_start[k - 1]
    filled = np.zeros(event_start.size, dtype=np.int64)
    origin = np.zeros(events, dtype=np.int64)
    for event in range(events):
        k = level[chained[event]]
        at = event_start[k] + filled[k]
        event_relation[at] = chained[event]
        origin[at] = event
        filled[k] += 1
    count = 0
    for at in range(events):
        top = level[event_relation[at]]
        pair_start[at] = count
        for i in range(row_start[origin[at]], row_start[origin[at] + 1]):
            if position[row_level[i]] == top:
                for pair in range(table_pairs[row_table[i]], table_pairs[row_table[i] + 1]):
                    source[count], target[count] = pair_source[pair], pair_target[pair]
                    count += 1
    pair_start[events] = count
