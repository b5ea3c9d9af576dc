"""Kernel of the search through state classes."""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.timed.kernels.domains import (
    can_fire_first,
    keep_above_and_forget,
    keep_below,
    least_waits,
    let_time_pass,
    linear_ends,
    matrix_after,
    strong_ends,
)
from dineros.analysis.timed.kernels.markings import (
    CLASSES,
    CODES,
    DEADLOCKS,
    EDGES,
    ENABLED,
    KEPT,
    MARKINGS,
    MOST_CLOCKS,
    NEXT,
    REMOVED,
    TODO,
    UNKNOWN,
    fire_once,
    number_of,
)
from dineros.analysis.timed.kernels.records import (
    UNBOUNDED,
    ZERO,
    append,
    class_of,
    covers,
    decode,
    encode,
    encode_after,
    is_within,
    plus,
)

(DONE, GOES_ON, WANTS_TABLE, WANTS_ROOM, WANTS_CLOCKS, TOO_MANY_TOKENS) = range(6)

MOST_TOKENS = 1 << 30
ALIVE = -1
LOAD = 0.6


@kernel()
def has_room(net, known, firings):  # type: ignore[no-untyped-def]
    """What is lacking to fire so many transitions more: `DONE` if nothing is."""
    control = known.control
    if (
        control[MARKINGS] + firings > LOAD * known.marking_table.size
        or control[CLASSES] + firings > LOAD * known.class_table.size
    ):
        return WANTS_TABLE
    rows, record = firings * net.has_clock.size, 2 * known.code.size
    if (
        control[MARKINGS] + firings + 1 > known.markings.shape[0]
        or control[ENABLED] + rows > known.enabled.size
        or control[KEPT] + rows > known.kept.size
        or control[CLASSES] + firings + 1 > known.class_marking.size
        or control[CODES] + firings * record > known.codes.size
        or (known.edge_target.size and control[EDGES] + firings > known.edge_target.size)
    ):
        return WANTS_ROOM
    return DONE


@kernel()
def largest_class(known, marking, clocks, matrix, other, length, bits, top):  # type: ignore[no-untyped-def]
    """Return the class that holds a matrix, whose record is there, and whether it is new.

    A new class takes the place of those that it holds.
    """
    number = known.first_class[marking]
    while number != UNKNOWN:
        if is_within(known, number, clocks, matrix, bits, top):
            return number, False
        number = known.next_class[number]
    new = append(
        known.control, known.class_marking, known.record_start, known.codes, marking, known.code, length
    )
    number, last = known.first_class[marking], UNKNOWN
    while number != UNKNOWN:
        after = known.next_class[number]
        if covers(known, number, clocks, matrix, other, bits, top):
            known.replaced_by[number] = new
            known.control[REMOVED] += 1
            if last == UNKNOWN:
                known.first_class[marking] = after
            else:
                known.next_class[last] = after
        else:
            last = number
        number = after
    known.next_class[new] = known.first_class[marking]
    known.first_class[marking] = new
    known.replaced_by[new] = ALIVE
    known.todo[known.control[TODO]] = new
    known.control[TODO] += 1
    return new, True


@kernel(inline="always")
def same_class(known, marking, length):  # type: ignore[no-untyped-def]
    """Return the class whose record is there, and whether it is new."""
    return class_of(
        known.control,
        known.class_table,
        known.class_marking,
        known.record_start,
        known.codes,
        marking,
        known.code,
        length,
    )


@kernel(inline="always")
def note(known, source, fired, number, is_new, keeps_edges):  # type: ignore[no-untyped-def]
    """Note that a class is reached by a firing."""
    control = known.control
    if is_new and known.parent.size:
        known.parent[number] = source
        known.via[number] = fired
    if keeps_edges:
        known.edge_target[control[EDGES]] = number
        known.edge_label[control[EDGES]] = fired
    control[EDGES] += 1


@kernel()
def reach(known, source, fired, marking, clocks, matrix, other, by_inclusion, keeps_edges, bits, top):  # type: ignore[no-untyped-def]
    """Note that the class of a matrix is reached by a firing."""
    length = encode(matrix, clocks, known.code, bits, top)
    if by_inclusion:
        number, is_new = largest_class(known, marking, clocks, matrix, other, length, bits, top)
    else:
        number, is_new = same_class(known, marking, length)
    note(known, source, fired, number, is_new, keeps_edges)


@kernel()
def reach_pieces(net, known, source, fired, marking, pieces, split, by_inclusion, keeps_edges, bits, top):  # type: ignore[no-untyped-def]
    """Cut a strong class where clocks without a latest bound come to matter no more, and note each piece.

    The class stands in ``pieces[0]``; a piece is cut by one clock after the other.
    """
    clocks, first = known.clocks[marking], known.enabled_start[marking]
    depth = 0
    split[0] = 0
    while depth >= 0:
        clock = split[depth] + 1
        while clock <= clocks and net.upper[known.enabled[first + clock - 1]] < UNBOUNDED:
            clock += 1
        if clock > clocks:
            room = has_room(net, known, 1)
            if room != DONE:
                return room
            reach(
                known, source, fired, marking, clocks, pieces[depth], pieces[-1],
                by_inclusion, keeps_edges, bits, top,
            )  # fmt: skip
            depth -= 1
            continue
        limit = net.lower[known.enabled[first + clock - 1]]
        for i in range(clocks + 1):
            for j in range(clocks + 1):
                pieces[depth + 1, i, j] = pieces[depth, i, j]
        split[depth] = clock
        is_below = keep_below(pieces[depth], clocks, clock, 1 - limit)
        is_above = keep_above_and_forget(pieces[depth + 1], clocks, clock, limit)
        if is_above and is_below:
            split[depth + 1] = clock
            depth += 1
        elif is_above:
            for i in range(clocks + 1):
                for j in range(clocks + 1):
                    pieces[depth, i, j] = pieces[depth + 1, i, j]
    return DONE


@kernel()
def begin(net, known, work, is_strong, by_inclusion, bits, top):  # type: ignore[no-untyped-def]
    """Store the initial class, or its pieces; what is lacking."""
    marking = number_of(net, known, work.tokens)
    clocks, first = known.clocks[marking], known.enabled_start[marking]
    if clocks + 1 > work.matrix.shape[0]:
        return WANTS_CLOCKS
    initial = work.pieces[0]
    for i in range(clocks + 1):
        for j in range(clocks + 1):
            initial[i, j] = 1
    if is_strong:
        return reach_pieces(
            net, known, -1, -1, marking, work.pieces, work.split, by_inclusion, False, bits, top
        )
    for i in range(1, clocks + 1):
        transition = known.enabled[first + i - 1]
        initial[i, 0] = net.upper[transition]
        initial[0, i] = net.lower[transition]
    for i in range(1, clocks + 1):
        for j in range(1, clocks + 1):
            if i != j:
                upper, lower = initial[i, 0], initial[0, j]
                initial[i, j] = UNBOUNDED if upper == UNBOUNDED else upper + lower - ((upper | lower) & 1)
    reach(known, -1, -1, marking, clocks, initial, work.pieces[-1], by_inclusion, False, bits, top)
    return DONE


@kernel()
def next_class(known, by_inclusion, is_stack):  # type: ignore[no-untyped-def]
    """Return the next class to expand, -1 if there is none; it stays the next one."""
    control = known.control
    if not is_stack:
        while by_inclusion and control[NEXT] < control[CLASSES] and known.replaced_by[control[NEXT]] != ALIVE:
            control[NEXT] += 1
        return control[NEXT] if control[NEXT] < control[CLASSES] else -1
    while control[TODO]:
        number = known.todo[control[TODO] - 1]
        if known.replaced_by[number] == ALIVE:
            return number
        control[TODO] -= 1
    return -1


@kernel(nogil=True)
def explore(net, known, work, is_strong, by_inclusion, is_stack, keeps_edges, bits, top, most):  # type: ignore[no-untyped-def]
    """Expand at most so many classes; say why it ends."""
    control = known.control
    for _ in range(most):
        number = next_class(known, by_inclusion, is_stack)
        if number < 0:
            return DONE
        todo, edges = control[TODO], control[EDGES]
        status = expand(net, known, work, number, is_strong, by_inclusion, keeps_edges, bits, top)
        if status != DONE:
            control[EDGES] = edges
            return status
        if control[EDGES] == edges:
            control[DEADLOCKS] += 1
        if keeps_edges:
            known.edge_first[number] = edges
            known.edge_last[number] = control[EDGES]
        if is_stack:
            # What was found now lies above the class itself.
            for at in range(todo, control[TODO]):
                known.todo[at - 1] = known.todo[at]
            control[TODO] -= 1
        else:
            control[NEXT] = number + 1
    return GOES_ON


@kernel()
def expand(net, known, work, number, is_strong, by_inclusion, keeps_edges, bits, top):  # type: ignore[no-untyped-def]
    """Fire all that can fire in a class; what is lacking."""
    row = known.class_marking[number]
    clocks, first, end = known.clocks[row], known.enabled_start[row], known.enabled_start[row + 1]
    room = has_room(net, known, end - first)
    if room != DONE:
        return room
    matrix, low, ends, result = work.matrix, work.low, work.ends, work.pieces[0]
    decode(known.codes, known.record_start[number], clocks, matrix, bits, top)
    before = work.elapsed if is_strong else matrix
    if is_strong:
        if net.above.size == 0 and not let_time_pass(net, known, matrix, row, clocks, -1, before):
            return DONE
    else:
        least_waits(matrix, clocks, low)
    for at in range(first, end):
        fired = known.enabled[at]
        clock = at - first + 1 if at - first < clocks else 0
        if is_strong and net.above.size:
            if is_overridden(net, known, row, clocks, fired):
                continue
            if not let_time_pass(net, known, matrix, row, clocks, fired, before):
                continue
        if is_strong:
            if clock and plus(before[clock, 0], net.lower[fired]) < ZERO:
                continue
        elif not can_fire_first(matrix, clocks, clock):
            continue
        if known.next_marking[at] == UNKNOWN:
            for arc in range(net.put_start[fired], net.put_start[fired + 1]):
                if known.markings[row, net.put_place[arc]] > MOST_TOKENS - net.put_weight[arc]:
                    return TOO_MANY_TOKENS
            fire_once(net, known, row, at, work.tokens)
            if control_clocks(known) + 1 > matrix.shape[0]:
                return WANTS_CLOCKS
        after, kept = known.next_marking[at], known.kept_start[at]
        count, start = known.clocks[after], known.enabled_start[after]
        if is_strong:
            strong_ends(known.kept, kept, count, before, clocks, clock, net.lower[fired], low, ends)
        else:
            linear_ends(
                net.upper, net.lower, known.enabled, start, known.kept, kept, count, matrix, low, clock, ends
            )
        is_cut = is_strong and any_unbounded(net.upper, known.enabled, start, count)
        if not by_inclusion and not is_cut:
            length = encode_after(known.kept, kept, count, before, ends, known.code, bits, top)
            target, is_new = same_class(known, after, length)
            note(known, number, fired, target, is_new, keeps_edges)
            continue
        matrix_after(known.kept, kept, count, before, ends, result)
        if not is_cut:
            reach(
                known, number, fired, after, count, result, work.pieces[-1],
                by_inclusion, keeps_edges, bits, top,
            )  # fmt: skip
            continue
        status = reach_pieces(
            net, known, number, fired, after, work.pieces, work.split, by_inclusion, keeps_edges, bits, top
        )
        if status != DONE:
            return status
    return DONE


@kernel(inline="always")
def any_unbounded(upper, enabled, start, clocks):  # type: ignore[no-untyped-def]
    """Whether any clock of a marking has no latest bound."""
    found = False
    for at in range(start, start + clocks):
        found |= upper[enabled[at]] == UNBOUNDED
    return found


@kernel(inline="always")
def control_clocks(known):  # type: ignore[no-untyped-def]
    """Most clocks of a marking so far."""
    return known.control[MOST_CLOCKS]


@kernel()
def is_overridden(net, known, row, clocks, fired):  # type: ignore[no-untyped-def]
    """Whether a transition without a clock, which may fire at any time, has priority over another."""
    for at in range(known.enabled_start[row] + clocks, known.enabled_start[row + 1]):
        for k in range(net.above_start[fired], net.above_start[fired + 1]):
            if net.above[k] == known.enabled[at]:
                return True
    return False
