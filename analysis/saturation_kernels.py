"""Saturation: the reachable markings of a net as a decision diagram, as a machine that can stop and go on.

The recursion of the algorithm goes one level down at a time, and at any moment each level has at most one
unfinished node. So the recursion's stack is an array indexed by level, and the kernel can return to Python
(for garbage collection, progress, an interrupt) and be called again.

References
----------
G. Ciardo, G. Luettgen, R. Siminiceanu, *Saturation: an efficient iteration strategy for symbolic state-space
generation*, TACAS 2001, LNCS 2031. G. Ciardo, R. Marmorstein, R. Siminiceanu, *The saturation algorithm for
symbolic state-space exploration*, STTT 8(1), 2006.
"""

from __future__ import annotations

from numba import njit

from dineros.analysis.diagram_kernels import (
    CACHE_MASK,
    FAILED,
    HAVE,
    HEADER,
    MISSES,
    NODES,
    RESULT,
    STACK,
    make_node,
    slot_of,
    union,
)

DONE, STORE_FULL, PAUSED = range(3)
FIRING, SATURATING = 0, 1

#: Columns of the frame of a level: what is under way there.
PHASE, NODE, RELATION, INDEX, TARGET, EVENT, IDLE, CLOCK = range(8)
FRAME_SIZE = 8


@njit(cache=True)
def saturate(  # type: ignore[no-untyped-def]
    mem, heads, cache, control, free, base, width, scratch, pending, work, changed, frame,
    relation_level, relation_table, relation_next, tables, event_start,
    event_relation, pair_start, pair_source, pair_target, fired, top, effort_limit, node_limit,
):  # fmt: skip
    """Run until the frame of level `top` is finished (node in ``control[RESULT]``) or something is needed.

    ``work[base[k] + i]`` is the child under construction for local state i of level k; relation r is the
    table ``tables[relation_table[r]:]`` at level ``relation_level[r]``, then relation ``relation_next[r]``
    below (0: nothing).

    Returns DONE, STORE_FULL (collect garbage, call again) or PAUSED (at `effort_limit` cache misses or
    `node_limit` nodes).
    """
    while True:
        k = control[STACK]
        if k > top:
            return DONE
        if control[MISSES] >= effort_limit or control[NODES] > node_limit:
            return PAUSED
        start = base[k]
        relation = frame[k, RELATION]
        push_node, push_relation = 0, 0
        if frame[k, PHASE] == FIRING:
            node = frame[k, NODE]
            first, size = mem[node + 2], mem[node + 3]
            here = relation_level[relation] == k
            below = relation_next[relation] if here else relation
            table = relation_table[relation] + first
            i = frame[k, INDEX]
            if control[HAVE]:
                control[HAVE] = 0
                work[start + frame[k, TARGET]] = control[RESULT]
                i += 1
            while i < size:
                child = mem[node + HEADER + i]
                if child != 0:
                    j = tables[table + i] if here else first + i
                    if j >= 0:
                        if below == 0:
                            work[start + j] = child
                        else:
                            slot = slot_of(child, below, control[CACHE_MASK])
                            if cache[slot] == child and cache[slot + 1] == below and cache[slot + 2] == 0:
                                work[start + j] = cache[slot + 3]
                            else:
                                push_node, push_relation = child, below
                                frame[k, TARGET] = j
                                break
                i += 1
            frame[k, INDEX] = i
            if push_node == 0:
                found = False
                for j in range(width[k]):
                    found |= work[start + j] != 0
                    changed[start + j] = 1
                if found:
                    frame[k, PHASE] = SATURATING
                    begin(k, frame, event_start, pair_start, fired)
                else:
                    _remember(cache, control, node, relation, 0)
                    control[RESULT] = 0
                    control[HAVE] = 1
                    control[STACK] = k + 1
                    continue
        if push_node == 0:
            pair, event, idle = frame[k, INDEX], frame[k, EVENT], frame[k, IDLE]
            first_event, last_event = event_start[k], event_start[k + 1]
            finished = first_event == last_event
            if not finished:
                below = relation_next[event_relation[event]]
                last_pair = pair_start[event + 1]
            while not finished:
                if pair == last_pair:
                    # A sweep over the event's pairs follows its own direction, so it never has to be
                    # repeated for # what it changed itself; the level is closed once every event had
                    # nothing to do in turn.
                    event += 1
                    if event == last_event:
                        event = first_event
                    idle += 1
                    if idle > last_event - first_event:
                        finished = True
                        break
                    pair, last_pair = pair_start[event], pair_start[event + 1]
                    below = relation_next[event_relation[event]]
                    continue
                i, j = start + pair_source[pair], start + pair_target[pair]
                child = work[i]
                if child == 0 or changed[i] <= fired[pair]:
                    pair += 1
                    continue
                image = child
                if control[HAVE]:
                    image = control[RESULT]
                elif below != 0:
                    slot = slot_of(child, below, control[CACHE_MASK])
                    if cache[slot] == child and cache[slot + 1] == below and cache[slot + 2] == 0:
                        image = cache[slot + 3]
                    else:
                        push_node, push_relation = child, below
                        break
                old = work[j]
                new = union(old, image, mem, heads, cache, control, free, base, scratch, pending)
                if control[FAILED]:
                    break
                control[HAVE] = 0
                frame[k, CLOCK] += 1
                fired[pair] = frame[k, CLOCK]
                if new != old:
                    frame[k, CLOCK] += 1
                    work[j] = new
                    changed[j] = frame[k, CLOCK]
                    idle = 0
                pair += 1
            frame[k, INDEX], frame[k, EVENT], frame[k, IDLE] = pair, event, idle
            if control[FAILED]:
                return STORE_FULL
            if finished:
                node = make_node(mem, heads, control, free, k, work, start, 0, width[k])
                if control[FAILED]:
                    return STORE_FULL
                if relation != 0:
                    _remember(cache, control, frame[k, NODE], relation, node)
                control[RESULT] = node
                control[HAVE] = 1
                control[STACK] = k + 1
                continue
        control[MISSES] += 1
        k -= 1
        frame[k, PHASE] = FIRING
        frame[k, NODE] = push_node
        frame[k, RELATION] = push_relation
        frame[k, INDEX] = 0
        start = base[k]
        for j in range(start, start + width[k]):
            work[j] = 0
        control[STACK] = k


@njit(cache=True)
def _remember(cache, control, node, relation, image):  # type: ignore[no-untyped-def]
    slot = slot_of(node, relation, control[CACHE_MASK])
    cache[slot] = node
    cache[slot + 1] = relation
    cache[slot + 2] = 0
    cache[slot + 3] = image


@njit(cache=True)
def begin(k, frame, event_start, pair_start, fired):  # type: ignore[no-untyped-def]
    """Set the frame of level k to the beginning of its fixed point: nothing fired, all changed at time 1."""
    event = event_start[k]
    frame[k, EVENT] = event
    frame[k, INDEX] = pair_start[event]
    frame[k, IDLE] = 0
    frame[k, CLOCK] = 1
    for pair in range(pair_start[event], pair_start[event_start[k + 1]]):
        fired[pair] = 0


@njit(cache=True)
def transfer(old, new, control):  # type: ignore[no-untyped-def]
    """Put the entries of a cache into a larger one."""
    for slot in range(0, old.size, 4):
        if old[slot] != 0:
            target = slot_of(old[slot], old[slot + 1], control[CACHE_MASK])
            for i in range(4):
                new[target + i] = old[slot + i]
