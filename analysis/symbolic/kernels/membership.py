"""Kernels that look up vectors of local states in decision diagrams, and steps from a vector."""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.symbolic.kernels.diagrams import HEADER


@kernel()
def holds(mem, states, order, vector):  # type: ignore[no-untyped-def]
    """Whether a set contains a vector, by encoding level; ``order[k]`` is the level of height k + 1."""
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
    """Return the first set, of sets that grow, that contains a vector; `below` if no earlier one does."""
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
    """Return the first event into the earliest of growing sets, and that set; -1 if none is before `at`.

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
