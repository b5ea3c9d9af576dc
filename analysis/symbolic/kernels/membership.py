"""Kernels that look for single vectors of local states in decision diagrams, and for steps from one."""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.symbolic.kernels.diagrams import HEADER


@kernel()
def holds(mem, states, order, vector):  # type: ignore[no-untyped-def]
    """Whether a set has a vector, given by encoding level; ``order[k]`` is the level of height k + 1."""
    for at in range(order.size - 1, -1, -1):
        if states == 0:
            return False
        child = vector[order[at]] - mem[states + 2]
        if child < 0 or child >= mem[states + 3]:
            return False
        states = mem[states + HEADER + child]
    return states != 0


@kernel()
def first_with(mem, growing, below, order, vector):  # type: ignore[no-untyped-def]
    """The first of sets, each a part of the next one, that has a vector; `below` where none before it has."""
    low, high = 0, below
    while low < high:
        middle = (low + high) // 2
        if holds(mem, growing[middle], order, vector):
            high = middle
        else:
            low = middle + 1
    return low


@kernel()
def earliest_step(  # type: ignore[no-untyped-def]
    mem, growing, at, order, vector, event_start, event_level, event_table, tables
):
    """The first event that leads to the earliest of growing sets, and which that is; none before `at`: -1.

    Event e applies the table that begins at ``tables[event_table[i]]`` to the level ``event_level[i]``, for i
    from ``event_start[e]`` to ``event_start[e + 1]``.
    """
    chosen = -1
    after = vector.copy()
    for event in range(event_start.size - 1):
        first, last = event_start[event], event_start[event + 1]
        is_enabled = True
        for i in range(first, last):
            target = tables[event_table[i] + vector[event_level[i]]]
            if target < 0:
                is_enabled = False
                break
            after[event_level[i]] = target
        if is_enabled and holds(mem, growing[at - 1], order, after):
            at = first_with(mem, growing, at - 1, order, after)
            chosen = event
            if at == 0:
                break
        for i in range(first, last):
            after[event_level[i]] = vector[event_level[i]]
    return chosen, at
