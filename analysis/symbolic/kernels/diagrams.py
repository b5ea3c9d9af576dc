"""Kernels of multi-valued decision diagrams: node store, operations on two sets, garbage collection.

A diagram is quasi-reduced: a node of level k has children of level k - 1 only (or the empty node 0); level
0 holds the one terminal node 1. Nodes live in one int32 array; a node's identity is the position of its
record::

    [next in hash chain, level, first, size, child of local state first, first + 1, ..., first + size - 1]

so that header and children share cache lines. Free records keep their size, have level -1 and form one list
per size.

`control` holds the scalars of the store (the constants below), so that kernels can stop and be resumed.
"""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel

POOL_TOP, POOL_LIMIT, NODES, CREATED, BUCKET_MASK, CACHE_MASK, FAILED, STACK, HAVE, RESULT, MISSES = range(11)
#: Number of children of a node that count as one cache miss: with wide nodes, the work between two checks of
#: the time, the memory and an interrupt must not grow with the width.
WIDE = 1024
#: Values of FAILED: the store was full when a node was needed; the store was full within an operation on
#: sets, whose buffer then contains only finished nodes; a set of boxes was met whose row is not known yet.
NO_ROOM, UNFINISHED, UNKNOWN = 1, 2, 3
#: For a saturation run: two keys that separate its results from others in the cache, a flag for runs that
#: fire only one event, the node whose image is computed next, and the lowest level with events of a run that
#: closes any set (0: another run).
FIRED_KEY, CLOSED_KEY, STILL, PUSHED, LOWEST = range(11, 16)
CONTROL_SIZE = 16

FIRST_NODE = 8
HEADER = 4
MARK = 1 << 24

#: Third word of a cache entry: one of these operations, whose operands are two nodes (EXCLUSION: a node and
#: the negated number of a set of boxes); or 0 or a node, for the image of a node under a relation (see
#: `saturation_kernels`).
UNION, INTERSECTION, DIFFERENCE, EXCLUSION = -1, -2, -3, -4


@kernel(_nrt=False)
def make_node(mem, heads, control, free, level, buffer, start, low, high):  # type: ignore[no-untyped-def]
    """Return the node of `level` with the children ``buffer[start + low:start + high]``, existing or new.

    Returns 0 if all children are empty; sets FAILED if the store is full.
    """
    while low < high and buffer[start + low] == 0:
        low += 1
    while high > low and buffer[start + high - 1] == 0:
        high -= 1
    size = high - low
    if size == 0:
        return 0
    bucket = _code_of(level, low, buffer, start + low, start + high) & control[BUCKET_MASK]
    node = heads[bucket]
    while node != 0:
        if mem[node + 3] == size and mem[node + 2] == low and mem[node + 1] == level:
            same = True
            for i in range(size):
                if mem[node + HEADER + i] != buffer[start + low + i]:
                    same = False
                    break
            if same:
                return node
        node = mem[node]
    node = free[size]
    if node != 0:
        free[size] = mem[node]
    else:
        node = control[POOL_TOP]
        if node + HEADER + size > control[POOL_LIMIT]:
            control[FAILED] = NO_ROOM
            return 0
        control[POOL_TOP] = node + HEADER + size
    mem[node] = heads[bucket]
    heads[bucket] = node
    mem[node + 1] = level
    mem[node + 2] = low
    mem[node + 3] = size
    for i in range(size):
        mem[node + HEADER + i] = buffer[start + low + i]
    control[NODES] += 1
    control[CREATED] += 1
    return node


@kernel(_nrt=False)
def _code_of(level, low, array, begin, end):  # type: ignore[no-untyped-def]
    """Hash code of a node with the children ``array[begin:end]``.

    Each step takes four children: the products of one step wait for those before, those of children do not.
    """
    code = level * 0x9E3779B1 + low
    i = begin
    while i + 4 <= end:
        code ^= (
            array[i]
            + array[i + 1] * 0x2545F4914F6CDD1D
            + array[i + 2] * 0x369DEA0F31A53F85
            + array[i + 3] * 0x27BB2EE687B0B0FD
        )
        code *= 0x1E3779B97F4A7C15
        code ^= (code >> 29) & 0x7FFFFFFFF
        i += 4
    while i < end:
        code = (code ^ array[i]) * 0x1E3779B97F4A7C15
        code ^= (code >> 29) & 0x7FFFFFFFF
        i += 1
    return code


@kernel(_nrt=False)
def slot_of(a, b, c, mask):  # type: ignore[no-untyped-def]
    """Position of the cache entry for three keys."""
    code = ((a * 0x9E3779B1 + b) * 0x9E3779B1 + c) * 0x1E3779B97F4A7C15
    return (((code >> 31) & 0x1FFFFFFFF) & mask) << 2


@kernel(_nrt=False)
def remember(a, b, c, result, cache, control):  # type: ignore[no-untyped-def]
    """Put a result into the cache under three keys."""
    slot = slot_of(a, b, c, control[CACHE_MASK])
    cache[slot] = a
    cache[slot + 1] = b
    cache[slot + 2] = c
    cache[slot + 3] = result


@kernel(_nrt=False)
def combine(  # type: ignore[no-untyped-def]
    a, b, operation, mem, heads, cache, control, free, base, buffer, pending
):  # fmt: skip
    """Union, intersection or difference of two sets; 0 with FAILED set if the store is full.

    ``pending[k]`` holds the current pair of level k, the current local state and the lowest one; the
    recursion is unrolled because Numba breaks self-recursive functions when it loads them from its cache.

    All new nodes belong to the result. To let a second call continue from them, they must survive garbage
    collection when the store is full: the buffer keeps them, and everything else is removed from it.
    """
    if a == b:
        return 0 if operation == DIFFERENCE else a
    if a == 0:
        return b if operation == UNION else 0
    if b == 0:
        return 0 if operation == INTERSECTION else a
    if a > b and operation != DIFFERENCE:
        a, b = b, a
    slot = slot_of(a, b, operation, control[CACHE_MASK])
    if cache[slot] == a and cache[slot + 1] == b and cache[slot + 2] == operation:
        return cache[slot + 3]
    control[MISSES] += 1 + (mem[a + 3] + mem[b + 3]) // WIDE
    top = level = mem[a + 1]
    i = min(mem[a + 2], mem[b + 2])
    while True:
        first_a, first_b = mem[a + 2], mem[b + 2]
        end_a, end_b = first_a + mem[a + 3], first_b + mem[b + 3]
        high = max(end_a, end_b)
        start = base[level]
        descend = False
        # Neighbouring local states often have the same children.
        last_child, last_other, last_result = 0, 0, 0
        while i < high:
            child = mem[a + HEADER + i - first_a] if first_a <= i < end_a else 0
            other = mem[b + HEADER + i - first_b] if first_b <= i < end_b else 0
            if child == last_child and other == last_other:
                buffer[start + i] = last_result
                i += 1
                continue
            last_child, last_other = child, other
            if child == other:
                if operation == DIFFERENCE:
                    child = 0
            elif child == 0:
                if operation == UNION:
                    child = other
            elif other == 0:
                if operation == INTERSECTION:
                    child = 0
            else:
                if child > other and operation != DIFFERENCE:
                    child, other = other, child
                slot = slot_of(child, other, operation, control[CACHE_MASK])
                if cache[slot] == child and cache[slot + 1] == other and cache[slot + 2] == operation:
                    child = cache[slot + 3]
                else:
                    control[MISSES] += 1 + (mem[child + 3] + mem[other + 3]) // WIDE
                    pending[level, 0] = a
                    pending[level, 1] = b
                    pending[level, 2] = i
                    pending[level, 3] = min(first_a, first_b)
                    a, b = child, other
                    level -= 1
                    i = min(mem[a + 2], mem[b + 2])
                    descend = True
                    break
            buffer[start + i] = last_result = child
            i += 1
        if descend:
            continue
        node = make_node(mem, heads, control, free, level, buffer, start, min(first_a, first_b), high)
        if control[FAILED]:
            control[FAILED] = UNFINISHED
            _keep_made(base, buffer, pending, level, min(first_a, first_b), high, top)
            return 0
        remember(a, b, operation, node, cache, control)
        if level == top:
            return node
        level += 1
        a, b, i = pending[level, 0], pending[level, 1], pending[level, 2]
        buffer[base[level] + i] = node
        i += 1


@kernel(_nrt=False)
def exclude(  # type: ignore[no-untyped-def]
    a, boxes, mem, heads, cache, control, free, base, buffer, pending, state_class, row, following, offset
):  # fmt: skip
    """Remove all boxes from a set; with FAILED set, the result is 0 or a set of boxes (see `box_sets`).

    On the way down, the set of boxes that may still contain the vector changes with each local state: entry
    ``row[boxes] + state_class[...]`` of `following` is the set one level down, 0 if no box is left, -1 if
    a box contains the vector for all states below. With FAILED = UNKNOWN the result is a set without a row.
    `offset` separates the sets of one call from those of another call in the cache.

    ``pending[k]`` holds the current node and set of level k, the current local state and the lowest one.
    """
    if row[boxes] < 0:
        control[FAILED] = UNKNOWN
        return boxes
    top = level = mem[a + 1]
    i = mem[a + 2]
    while True:
        first = mem[a + 2]
        high = first + mem[a + 3]
        start = base[level]
        descend = False
        while i < high:
            child = mem[a + HEADER + i - first]
            if child != 0:
                below = following[row[boxes] + state_class[start + i]]
                if below < 0:
                    child = 0
                elif below > 0:
                    key = -1 - offset - below
                    slot = slot_of(child, key, EXCLUSION, control[CACHE_MASK])
                    if cache[slot] == child and cache[slot + 1] == key and cache[slot + 2] == EXCLUSION:
                        child = cache[slot + 3]
                    else:
                        if row[below] < 0:
                            control[FAILED] = UNKNOWN
                            return below
                        control[MISSES] += 1
                        pending[level, 0] = a
                        pending[level, 1] = boxes
                        pending[level, 2] = i
                        pending[level, 3] = first
                        a, boxes = child, below
                        level -= 1
                        i = mem[a + 2]
                        descend = True
                        break
            buffer[start + i] = child
            i += 1
        if descend:
            continue
        node = make_node(mem, heads, control, free, level, buffer, start, first, high)
        if control[FAILED]:
            control[FAILED] = UNFINISHED
            _keep_made(base, buffer, pending, level, first, high, top)
            return 0
        remember(a, -1 - offset - boxes, EXCLUSION, node, cache, control)
        if level == top:
            return node
        level += 1
        a, boxes, i = pending[level, 0], pending[level, 1], pending[level, 2]
        buffer[base[level] + i] = node
        i += 1


@kernel(_nrt=False)
def _keep_made(base, buffer, pending, level, low, high, top):  # type: ignore[no-untyped-def]
    """Remove all from the buffer except the children of unfinished nodes, from `level` up to `top`."""
    buffer[: base[level] + low] = 0
    done = base[level] + high
    for k in range(level + 1, top + 1):
        buffer[done : base[k] + pending[k, 3]] = 0
        done = base[k] + pending[k, 2]
    buffer[done:] = 0


@kernel(_nrt=False)
def mark(mem, node, stack):  # type: ignore[no-untyped-def]
    """Mark every node below `node`, and `node` itself."""
    if node < FIRST_NODE or mem[node + 1] & MARK:
        return
    mem[node + 1] |= MARK
    depth = 1
    stack[0] = node
    while depth:
        depth -= 1
        node = stack[depth]
        for i in range(mem[node + 3]):
            child = mem[node + HEADER + i]
            if child >= FIRST_NODE and not mem[child + 1] & MARK:
                mem[child + 1] |= MARK
                stack[depth] = child
                depth += 1


@kernel(_nrt=False)
def sweep(mem, heads, cache, control, free):  # type: ignore[no-untyped-def]
    """Free all unmarked nodes, remove cache entries that refer to them, and unmark the rest."""
    for slot in range(0, (control[CACHE_MASK] + 1) << 2, 4):
        a, b, result = cache[slot], cache[slot + 1], cache[slot + 3]
        if a == 0:
            continue
        dead = a >= FIRST_NODE and not mem[a + 1] & MARK
        dead |= result >= FIRST_NODE and not mem[result + 1] & MARK
        third = cache[slot + 2]
        dead |= third < 0 and b >= FIRST_NODE and not mem[b + 1] & MARK
        dead |= third >= FIRST_NODE and not mem[third + 1] & MARK
        if dead:
            cache[slot] = 0
    rehash(mem, heads, control, free, True)


@kernel(_nrt=False)
def rehash(mem, heads, control, free, only_marked):  # type: ignore[no-untyped-def]
    """Rebuild the hash chains and, when `only_marked`, the lists of free records, in one walk."""
    heads[:] = 0
    free[:] = 0
    alive = 0
    node = FIRST_NODE
    while node < control[POOL_TOP]:
        size = mem[node + 3]
        level = mem[node + 1]
        if level >= 0 and (level & MARK or not only_marked):
            level &= MARK - 1
            mem[node + 1] = level
            code = _code_of(level, mem[node + 2], mem, node + HEADER, node + HEADER + size)
            bucket = code & control[BUCKET_MASK]
            mem[node] = heads[bucket]
            heads[bucket] = node
            alive += 1
        else:
            mem[node + 1] = -1
            mem[node] = free[size]
            free[size] = node
        node += HEADER + size
    control[NODES] = alive
