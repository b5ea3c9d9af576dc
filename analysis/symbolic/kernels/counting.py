"""Kernels that count on finished decision diagrams, modulo several primes at once.

Counts of markings have hundreds of bits. Rows of residues keep the arithmetic in machine words, also for
products; the Chinese remainder theorem then gives the exact numbers (module `counting`).
"""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.symbolic.kernels.diagrams import FIRST_NODE, HEADER, MARK


@kernel()
def find_nodes(mem, root, ids):  # type: ignore[no-untyped-def]
    """Write the positions of all nodes below `root`, itself included, to `ids`; return how many there are."""
    if root < FIRST_NODE:
        return 0
    ids[0] = root
    mem[root + 1] |= MARK
    count, at = 1, 0
    while at < count:
        node = ids[at]
        at += 1
        for i in range(mem[node + 3]):
            child = mem[node + HEADER + i]
            if child >= FIRST_NODE and not mem[child + 1] & MARK:
                mem[child + 1] |= MARK
                ids[count] = child
                count += 1
    for at in range(count):
        mem[ids[at] + 1] &= MARK - 1
    return count


@kernel()
def child_indices(mem, ids, order, rank, level_start, first, child):  # type: ignore[no-untyped-def]
    """Copy the diagram: nodes renumbered by ascending level, number 0 the terminal, -1 no child.

    ``rank[i]`` is the new number of node ``ids[i]``; node n has the children ``child[level_start[n]:...]``
    for the local states from ``first[n]`` on.
    """
    at = 0
    for n in range(1, order.size + 1):
        node = ids[order[n - 1]]
        level_start[n] = at
        first[n] = mem[node + 2]
        for i in range(mem[node + 3]):
            below = mem[node + HEADER + i]
            if below == 0:
                child[at] = -1
            elif below == 1:
                child[at] = 0
            else:
                low, high = 0, ids.size
                while low < high:
                    middle = (low + high) >> 1
                    if ids[middle] < below:
                        low = middle + 1
                    else:
                        high = middle
                child[at] = rank[low]
            at += 1
    level_start[order.size + 1] = at


@kernel()
def count_below(start, child, primes, below):  # type: ignore[no-untyped-def]
    """Row n: number of vectors below node n."""
    below[0, :] = 1
    for n in range(1, start.size - 1):
        for i in range(start[n], start[n + 1]):
            if child[i] >= 0:
                for q in range(primes.size):
                    total = below[n, q] + below[child[i], q]
                    below[n, q] = total - primes[q] if total >= primes[q] else total


@kernel()
def count_above(start, child, root, primes, above):  # type: ignore[no-untyped-def]
    """Row n: number of ways from the root down to node n."""
    above[root, :] = 1
    for n in range(start.size - 2, 0, -1):
        for i in range(start[n], start[n + 1]):
            if child[i] >= 0:
                for q in range(primes.size):
                    total = above[child[i], q] + above[n, q]
                    above[child[i], q] = total - primes[q] if total >= primes[q] else total


@kernel()
def count_box(  # type: ignore[no-untyped-def]
    start, first, child, levels, masks, mask_start, top, bottom, primes, above, below, ways, answer
):  # fmt: skip
    """Add to `answer` the number of vectors whose local states all lie in the masks.

    ``masks[mask_start[k] + i]`` states whether local state i of level k is allowed (``mask_start[k] < 0``:
    all are allowed); levels above `top` and below `bottom` are free. ``levels[k]:levels[k + 1]`` are the
    nodes of level k; `ways` is a buffer with one row per node, all zero before and after.
    """
    for n in range(levels[top], levels[top + 1]):
        for q in range(primes.size):
            ways[n, q] = above[n, q]
    for k in range(top, bottom - 1, -1):
        mask = mask_start[k]
        for n in range(levels[k], levels[k + 1]):
            some = False
            for q in range(primes.size):
                some |= ways[n, q] != 0
            if not some:
                continue
            for i in range(start[n], start[n + 1]):
                target = child[i]
                if target < 0 or (mask >= 0 and not masks[mask + first[n] + i - start[n]]):
                    continue
                if k == bottom:
                    for q in range(primes.size):
                        answer[q] = (answer[q] + ways[n, q] * below[target, q]) % primes[q]
                else:
                    for q in range(primes.size):
                        total = ways[target, q] + ways[n, q]
                        ways[target, q] = total - primes[q] if total >= primes[q] else total
            ways[n, :] = 0


@kernel()
def heaviest(start, first, child, weights, weight_start, level_of, low, middle, high, best):  # type: ignore[no-untyped-def]
    """Largest sum of weights of local states over the levels of nodes ``low`` to ``high - 1``.

    Levels from that of ``middle`` on are the highest of these. `best` is a buffer with a number per node.
    """
    largest = 0
    for n in range(low, high):
        offset = weight_start[level_of[n]] + first[n] - start[n]
        found = False
        for i in range(start[n], start[n + 1]):
            if child[i] >= 0:
                value = weights[offset + i] + (best[child[i]] if child[i] >= low else 0)
                if not found or value > best[n]:
                    best[n] = value
                    found = True
        if n >= middle and (n == middle or best[n] > largest):
            largest = best[n]
    return largest


@kernel()
def local_states(start, first, child, level_of, offset, seen):  # type: ignore[no-untyped-def]
    """Flag every local state that occurs: ``seen[offset[k] + i]`` for level k."""
    for n in range(1, start.size - 1):
        base = offset[level_of[n]] + first[n] - start[n]
        for i in range(start[n], start[n + 1]):
            if child[i] >= 0:
                seen[base + i] = 1
