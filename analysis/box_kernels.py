"""Kernel that takes a box (a product of sets of local states) out of a decision diagram."""

from __future__ import annotations

from numba import njit

from dineros.analysis.diagram_kernels import CACHE_MASK, FAILED, HEADER, MISSES, make_node, slot_of

SUBTRACT = -2


@njit(cache=True)
def subtract_box(  # type: ignore[no-untyped-def]
    root, number, mem, heads, cache, control, free, base, buffer, pending, masks, mask_start, bottom
):  # fmt: skip
    """Vectors of `root` outside the box; 0 with FAILED set when the store is full.

    `number` tells boxes apart in the cache; levels with ``mask_start[k] < 0`` and those below `bottom` are
    free.
    """
    if root == 0:
        return 0
    node, top, level, i = root, mem[root + 1], mem[root + 1], 0
    key = (number << 2) | 3
    while True:
        first, size = mem[node + 2], mem[node + 3]
        start, mask = base[level], mask_start[level]
        descend = False
        while i < size:
            child = mem[node + HEADER + i]
            if child != 0 and (mask < 0 or masks[mask + first + i]):
                if level == bottom:
                    child = 0
                else:
                    slot = slot_of(child, key, control[CACHE_MASK])
                    if cache[slot] == child and cache[slot + 1] == key and cache[slot + 2] == SUBTRACT:
                        child = cache[slot + 3]
                    else:
                        control[MISSES] += 1
                        pending[level, 0] = node
                        pending[level, 2] = i
                        node, i = child, 0
                        level -= 1
                        descend = True
                        break
            buffer[start + first + i] = child
            i += 1
        if descend:
            continue
        result = make_node(mem, heads, control, free, level, buffer, start, first, first + size)
        if control[FAILED]:
            return 0
        slot = slot_of(node, key, control[CACHE_MASK])
        cache[slot] = node
        cache[slot + 1] = key
        cache[slot + 2] = SUBTRACT
        cache[slot + 3] = result
        if level == top:
            return result
        level += 1
        node, i = pending[level, 0], pending[level, 2]
        buffer[base[level] + mem[node + 2] + i] = result
        i += 1
