"""Kernel that makes the diagram of an encoding from that of a smaller one (see `stages.contraction`)."""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.symbolic.kernels.diagrams import FAILED, make_node


@kernel(_nrt=False)
def expand_nodes(  # type: ignore[no-untyped-def]
    level_of, start, first, child, of_state, mem, heads, control, free, base, buffer, made
):  # fmt: skip
    """Make all nodes, numbered as in `DiagramCounts`, into ``made``; False if the store is full.

    ``of_state[base[k] + i]`` is the child of the smaller node that becomes child i of a node of level k.
    """
    made[0] = 1
    for node in range(1, level_of.size):
        level = level_of[node]
        here, width = base[level], base[level + 1] - base[level]
        size = start[node + 1] - start[node]
        for i in range(width):
            at = of_state[here + i] - first[node]
            buffer[here + i] = 0
            if 0 <= at < size and child[start[node] + at] >= 0:
                buffer[here + i] = made[child[start[node] + at]]
        made[node] = make_node(mem, heads, control, free, level, buffer, here, 0, width)
        if control[FAILED]:
            return False
    return True
