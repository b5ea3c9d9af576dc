"""Saturation: fixed points of events on decision diagrams, as a machine that can pause and continue.

The recursion of the algorithm descends one level at a time, and each level has at most one unfinished node at
any time. Therefore the stack of the recursion is an array indexed by level, and the kernel can return to
Python (for garbage collection, progress or an interrupt) and be called again.

A run may be *constrained*: then it only reaches vectors of a given set. CTL needs this: events run backwards
under the constraint that markings are reachable.

A run may also close a set that is not closed below, under a few of all events (see `stages`). Then
``control[LOWEST]`` is the lowest of their top levels, and nodes below it are closed.

References
----------
G. Ciardo, G. Luettgen, R. Siminiceanu, *Saturation: an efficient iteration strategy for symbolic state-space
generation*, TACAS 2001, LNCS 2031. G. Ciardo, R. Marmorstein, R. Siminiceanu, *The saturation algorithm for
symbolic state-space exploration*, STTT 8(1), 2006. Y. Zhao, G. Ciardo, *Symbolic CTL model checking of
asynchronous systems using constrained saturation*, ATVA 2009, LNCS 5799.
"""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.symbolic.kernels.diagrams import (
    CACHE_MASK,
    CLOSED_KEY,
    FAILED,
    FIRED_KEY,
    HAVE,
    HEADER,
    INTERSECTION,
    LOWEST,
    MISSES,
    NODES,
    PUSHED,
    RESULT,
    STACK,
    STILL,
    UNION,
    WIDE,
    combine,
    make_node,
    remember,
    slot_of,
)

DONE, STORE_FULL, PAUSED = range(3)
#: Current work of a level: images of the children of a node under a relation, the fixed point of its own
#: events, or the closure of the children of a node.
FIRING, SATURATING, CLOSING = range(3)

#: Columns of the frame of a level, which holds its current work. The constraint 0 allows everything.
PHASE, NODE, RELATION, INDEX, TARGET, EVENT, IDLE, CLOCK, CONSTRAINT, OPENED = range(10)
FRAME_SIZE = 10


@kernel(_nrt=False)
def saturate(  # type: ignore[no-untyped-def]
    mem, heads, cache, control, free, base, width, scratch, pending, work, changed, frame,
    relation_level, relation_table, relation_next, tables, event_start,
    event_relation, pair_start, pair_source, pair_target, fired, top, effort_limit, node_limit,
):  # fmt: skip
    """Run until the frame of level `top` is finished (node in ``control[RESULT]``) or something is needed.

    ``work[base[k] + i]`` is the child under construction for local state i of level k; relation r is the
    table ``tables[relation_table[r]:]`` at level ``relation_level[r]``, then relation ``relation_next[r]``
    below (0: nothing).

    Returns DONE, STORE_FULL (collect garbage and call again; `scratch` keeps the nodes of `combine` so far)
    or PAUSED (at `effort_limit` cache misses or `node_limit` nodes).
    """
    while True:
        k = control[STACK]
        if k > top:
            return DONE
        if control[MISSES] >= effort_limit or control[NODES] > node_limit:
            return PAUSED
        start = base[k]
        relation, constraint, phase = frame[k, RELATION], frame[k, CONSTRAINT], frame[k, PHASE]
        push, push_relation, push_constraint = False, 0, 0
        if phase != SATURATING:
            node = frame[k, NODE]
            first, size = mem[node + 2], mem[node + 3]
            here = phase == FIRING and relation_level[relation] == k
            below = relation_next[relation] if here else relation
            table = relation_table[relation] + first
            i = frame[k, INDEX]
            # Neighbouring local states often have the same child.
            last_child, last_image = 0, 0
            if control[HAVE]:
                control[HAVE] = 0
                work[start + frame[k, TARGET]] = control[RESULT]
                if constraint == 0:
                    last_child, last_image = mem[node + HEADER + i], control[RESULT]
                i += 1
            while i < size:
                child = mem[node + HEADER + i]
                if child != 0:
                    j = tables[table + i] if here else first + i
                    if j >= 0:
                        allowed = _allowed(mem, constraint, j)
                        if constraint == 0 or allowed != 0:
                            if child == last_child:
                                image = last_image
                            elif phase == CLOSING and constraint == 0:
                                image = child
                                if k > control[LOWEST]:
                                    image = _known_closure(child, 0, cache, control)
                                    control[PUSHED] = child
                            else:
                                image = _known_image(
                                    child, below, allowed, k, mem, heads, cache, control, free, base, scratch,
                                    pending,
                                )  # fmt: skip
                            if image < 0:
                                push, push_relation, push_constraint = True, below, allowed
                                frame[k, TARGET] = j
                                break
                            work[start + j] = image
                            if constraint == 0:
                                last_child, last_image = child, image
                i += 1
            frame[k, INDEX] = i
            if control[FAILED]:
                return STORE_FULL
            if not push:
                opened = make_node(mem, heads, control, free, k, work, start, 0, width[k])
                if control[FAILED]:
                    return STORE_FULL
                closed = opened
                if event_start[k] != event_start[k + 1]:
                    closed = _known_closure(opened, constraint, cache, control)
                if closed >= 0:
                    _finish(k, closed, frame, cache, control)
                    continue
                for j in range(width[k]):
                    changed[start + j] = 1
                frame[k, OPENED] = opened
                frame[k, PHASE] = SATURATING
                begin(k, frame, event_start, pair_start, fired)
        if not push:
            pair, event, idle = frame[k, INDEX], frame[k, EVENT], frame[k, IDLE]
            first_event, last_event = event_start[k], event_start[k + 1]
            finished = first_event == last_event
            last_child, last_image, last_old, last_new = 0, 0, -1, 0
            if not finished:
                below = relation_next[event_relation[event]]
                last_pair = pair_start[event + 1]
            while not finished:
                if pair == last_pair:
                    last_child, last_old = 0, -1
                    # A sweep over the event's pairs follows its own direction and need not be repeated for
                    # its own changes; the level is closed once every event in turn had nothing to do.
                    event += 1
                    if event == last_event:
                        event = first_event
                    # The stored state must allow continuing, also if the store turns out full below.
                    pair, last_pair = pair_start[event], pair_start[event + 1]
                    below = relation_next[event_relation[event]]
                    idle += 1
                    finished = idle > last_event - first_event
                    continue
                i, j = start + pair_source[pair], start + pair_target[pair]
                child = work[i]
                if child == 0 or changed[i] <= fired[pair]:
                    pair += 1
                    continue
                allowed = _allowed(mem, constraint, j - start)
                if constraint != 0 and allowed == 0:
                    pair += 1
                    continue
                old = work[j]
                if child == last_child and old == last_old:
                    new = last_new
                else:
                    if control[HAVE]:
                        image = control[RESULT]
                    elif child == last_child:
                        image = last_image
                    else:
                        image = _known_image(
                            child, below, allowed, k, mem, heads, cache, control, free, base, scratch, pending
                        )  # fmt: skip
                        if control[FAILED]:
                            break
                        if image < 0:
                            push, push_relation, push_constraint = True, below, allowed
                            break
                    new = combine(old, image, UNION, mem, heads, cache, control, free, base, scratch, pending)
                    if control[FAILED]:
                        break
                    control[HAVE] = 0
                    if constraint == 0:
                        last_child, last_image, last_old, last_new = child, image, old, new
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
                _finish(k, node, frame, cache, control)
                continue
        control[MISSES] += 1 + width[k - 1] // WIDE
        k -= 1
        frame[k, PHASE] = FIRING if push_relation != 0 else CLOSING
        frame[k, NODE] = control[PUSHED]
        frame[k, RELATION] = push_relation
        frame[k, CONSTRAINT] = push_constraint
        frame[k, INDEX] = 0
        start = base[k]
        for j in range(start, start + width[k]):
            work[j] = 0
        control[STACK] = k


@kernel(_nrt=False)
def _allowed(mem, constraint, state):  # type: ignore[no-untyped-def]
    """Return the part of a constraint below a local state of its level; 0 if there is none."""
    if constraint == 0:
        return 0
    at = state - mem[constraint + 2]
    return mem[constraint + HEADER + at] if 0 <= at < mem[constraint + 3] else 0


@kernel(_nrt=False)
def _known_image(  # type: ignore[no-untyped-def]
    child, relation, allowed, k, mem, heads, cache, control, free, base, scratch, pending
):  # fmt: skip
    """Closed image of a node below level k under a relation; relation 0 is the identity.

    If it is not known yet, -1, with the node to compute it from in ``control[PUSHED]``; -1 with FAILED
    set if the store is full.
    """
    if relation == 0:
        if allowed == 0:
            return child  # without a constraint, all nodes are closed
        part = combine(child, allowed, INTERSECTION, mem, heads, cache, control, free, base, scratch, pending)
        if control[FAILED]:
            return -1
        if part == 0 or k == 1 or control[STILL]:
            return part
        child, second, third = part, allowed, control[CLOSED_KEY]
    else:
        second, third = relation + control[FIRED_KEY], allowed
    slot = slot_of(child, second, third, control[CACHE_MASK])
    if cache[slot] == child and cache[slot + 1] == second and cache[slot + 2] == third:
        return cache[slot + 3]
    control[PUSHED] = child
    return -1


@kernel(_nrt=False)
def _known_closure(node, constraint, cache, control):  # type: ignore[no-untyped-def]
    """Closure of a node whose children are closed; -1 if it is not known yet."""
    if node == 0:
        return 0
    slot = slot_of(node, constraint, control[CLOSED_KEY], control[CACHE_MASK])
    if cache[slot] == node and cache[slot + 1] == constraint and cache[slot + 2] == control[CLOSED_KEY]:
        return cache[slot + 3]
    return -1


@kernel(_nrt=False)
def _finish(k, result, frame, cache, control):  # type: ignore[no-untyped-def]
    """Pass the result of a level to the level above, and cache it under its source."""
    node, relation, constraint = frame[k, NODE], frame[k, RELATION], frame[k, CONSTRAINT]
    if frame[k, OPENED] != 0:
        remember(frame[k, OPENED], constraint, control[CLOSED_KEY], result, cache, control)
        frame[k, OPENED] = 0
    if node != 0:
        second = relation + control[FIRED_KEY] if relation != 0 else constraint
        third = constraint if relation != 0 else control[CLOSED_KEY]
        remember(node, second, third, result, cache, control)
    if 0 < control[LOWEST] <= k and result != 0:
        remember(result, 0, control[CLOSED_KEY], result, cache, control)
    control[RESULT] = result
    control[HAVE] = 1
    control[STACK] = k + 1


@kernel(_nrt=False)
def begin(k, frame, event_start, pair_start, fired):  # type: ignore[no-untyped-def]
    """Set the frame of level k to the start of its fixed point: no event fired, all changed at time 1."""
    event = event_start[k]
    frame[k, EVENT] = event
    frame[k, INDEX] = pair_start[event]
    frame[k, IDLE] = 0
    frame[k, CLOCK] = 1
    for pair in range(pair_start[event], pair_start[event_start[k + 1]]):
        fired[pair] = 0


@kernel(_nrt=False)
def transfer(old, new, control):  # type: ignore[no-untyped-def]
    """Copy the entries of a cache into a larger one."""
    for slot in range(0, old.size, 4):
        if old[slot] != 0:
            target = slot_of(old[slot], old[slot + 1], old[slot + 2], control[CACHE_MASK])
            for i in range(4):
                new[target + i] = old[slot + i]
