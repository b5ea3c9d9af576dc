"""Kernels of the search through state classes.

The successors of some classes are first written to a list, and then stored: in the order of the classes and
of their transitions, so that the result does not depend on how many classes are processed together.
"""

from __future__ import annotations

from dineros.analysis.explicit.kernels.atomics import prefetch
from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.timed.kernels.markings import (
    CLASSES,
    DEADLOCKS,
    EDGES,
    INDEX_BITS,
    INDEX_MASK,
    NEXT,
    REMOVED,
    TAG_SHIFT,
    TODO,
    UNKNOWN,
    number_of,
)
from dineros.analysis.timed.kernels.records import (
    UNBOUNDED,
    ZERO,
    append,
    covers,
    decode,
    find_record,
    is_within,
)
from dineros.analysis.timed.kernels.successors import (
    COLLECTED,
    DONE,
    GOES_ON,
    ITEMS,
    WANTS_BATCH,
    WANTS_CLOCKS,
    WORDS,
    add_matrix,
    add_pieces,
    expand,
    has_room,
    longest_record,
)

BATCH = 256
"""Classes of a batch: what follows them fits into the cache."""
ALIVE = -1


@kernel()
def look_up(known, batch, last):  # type: ignore[no-untyped-def]
    """Find which records are known already."""
    table, mask = known.class_table, known.class_table.size - 1
    for k in range(last):
        batch.target[k] = UNKNOWN
        entry = table[batch.value[k] & mask]
        if entry >> INDEX_BITS == batch.value[k] >> TAG_SHIFT and entry != 0:
            number = (entry & INDEX_MASK) - 1
            batch.target[k] = number
            prefetch(known.class_marking, number)
            prefetch(known.record_start, number)
    for k in range(last):
        if batch.target[k] != UNKNOWN:
            prefetch(known.codes, known.record_start[batch.target[k]])
    for k in range(last):
        number, _ = find_record(
            table, known.class_marking, known.record_start, known.codes,
            batch.marking[k], batch.record, batch.start[k], batch.length[k], batch.value[k],
        )  # fmt: skip
        batch.target[k] = number


@kernel()
def store(  # type: ignore[no-untyped-def]
    control, table, markings, starts, codes, parent, via, edge_target, edge_label,
    marking, value, start, length, target, fired, record, item, last, source, keeps_edges,
):  # fmt: skip
    """Store the records after a class that are new, and note all edges; there must be room."""
    edge = control[EDGES]
    for k in range(item, last):
        number = target[k]
        if number == UNKNOWN:  # or it is new, but not the first of its kind
            number, slot = find_record(
                table, markings, starts, codes, marking[k], record, start[k], length[k], value[k]
            )
            if number == UNKNOWN:
                number = append(control, markings, starts, codes, marking[k], record, start[k], length[k])
                table[slot] = value[k] >> TAG_SHIFT << INDEX_BITS | (number + 1)
                if parent.size:
                    parent[number] = source
                    via[number] = fired[k]
        if keeps_edges:
            edge_target[edge] = number
            edge_label[edge] = fired[k]
        edge += 1
    control[EDGES] = edge


@kernel()
def largest_class(known, marking, clocks, matrix, other, record, start, length, bits, top):  # type: ignore[no-untyped-def]
    """Return the class that holds a matrix with a record, and whether it is new.

    A new class takes the place of those that it holds.
    """
    number = known.first_class[marking]
    while number != UNKNOWN:
        if is_within(known, number, clocks, matrix, bits, top):
            return number, False
        number = known.next_class[number]
    new = append(
        known.control, known.class_marking, known.record_start, known.codes, marking, record, start, length
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


@kernel()
def store_largest(known, work, batch, item, last, source, bits, top):  # type: ignore[no-untyped-def]
    """Store the classes after a class that no other one holds, and note all edges; there must be room."""
    control = known.control
    for k in range(item, last):
        marking, start = batch.marking[k], batch.start[k]
        clocks = known.clocks[marking]
        decode(batch.record, start, clocks, work.matrix, bits, top)
        number, is_new = largest_class(
            known, marking, clocks, work.matrix, work.elapsed, batch.record, start, batch.length[k], bits, top
        )
        if is_new and known.parent.size:
            known.parent[number] = source
            known.via[number] = batch.fired[k]
        known.edge_target[control[EDGES]] = number
        known.edge_label[control[EDGES]] = batch.fired[k]
        control[EDGES] += 1


@kernel()
def next_class(known, is_stack):  # type: ignore[no-untyped-def]
    """Return the next class to expand, -1 if there is none; it stays the next one."""
    control = known.control
    if not is_stack:
        while control[NEXT] < control[CLASSES] and known.replaced_by[control[NEXT]] != ALIVE:
            control[NEXT] += 1
        return control[NEXT] if control[NEXT] < control[CLASSES] else -1
    while control[TODO]:
        number = known.todo[control[TODO] - 1]
        if known.replaced_by[number] == ALIVE:
            return number
        control[TODO] -= 1
    return -1


@kernel(nogil=True)
def explore_by_inclusion(net, known, work, batch, is_strong, is_stack, bits, top, most):  # type: ignore[no-untyped-def]
    """Expand at most so many classes one by one, of which only the largest are kept; say why it ends."""
    control = known.control
    for _ in range(most):
        number = next_class(known, is_stack)
        if number < 0:
            return DONE
        status = expand(net, known, work, batch, number, 1, True, False, is_strong, bits, top)
        if status == DONE:
            status = has_room(net, known, work, batch.control[ITEMS])
        if status != DONE:
            return status
        todo, edges = control[TODO], control[EDGES]
        store_largest(known, work, batch, 0, batch.control[ITEMS], number, bits, top)
        if control[EDGES] == edges:
            control[DEADLOCKS] += 1
        known.edge_first[number] = edges
        known.edge_last[number] = control[EDGES]
        if is_stack:
            # The classes found now are stored above the class itself.
            for at in range(todo, control[TODO]):
                known.todo[at - 1] = known.todo[at]
            control[TODO] -= 1
        else:
            control[NEXT] = number + 1
    return GOES_ON


@kernel(nogil=True)
def explore(net, known, work, batch, is_strong, keeps_edges, bits, top, most):  # type: ignore[no-untyped-def]
    """Expand at most so many classes, in the order in which they were found; say why it ends."""
    control = known.control
    end = control[NEXT] + most
    while control[NEXT] < end:
        first = control[NEXT]
        count = min(control[CLASSES] - first, end - first, BATCH)
        if count == 0:
            return DONE
        status = expand(net, known, work, batch, first, count, True, False, is_strong, bits, top)
        collected = batch.control[COLLECTED]
        look_up(known, batch, batch.last_item[collected - 1] if collected else 0)
        for k in range(collected):
            item, last = batch.first_item[k], batch.last_item[k]
            room = has_room(net, known, work, last - item)
            if room != DONE:
                return room
            edges = control[EDGES]
            store(
                control, known.class_table, known.class_marking, known.record_start, known.codes,
                known.parent, known.via, known.edge_target, known.edge_label, batch.marking, batch.value,
                batch.start, batch.length, batch.target, batch.fired, batch.record, item, last, first + k,
                keeps_edges,
            )  # fmt: skip
            if item == last:
                control[DEADLOCKS] += 1
            if keeps_edges:
                known.edge_first[first + k] = edges
                known.edge_last[first + k] = control[EDGES]
            control[NEXT] = first + k + 1
        if status != DONE and not (status == WANTS_BATCH and collected):
            return status
    return GOES_ON


@kernel()
def begin(net, known, work, batch, is_strong, by_inclusion, bits, top):  # type: ignore[no-untyped-def]
    """Store the initial class, or its pieces; what is lacking."""
    marking = number_of(net, known, work.tokens)
    if known.clocks[marking] + 1 > work.matrix.shape[0]:
        return WANTS_CLOCKS
    if batch.fired.size == 0 or longest_record(work) > batch.record.size:
        return WANTS_BATCH
    initial_matrix(net, known, marking, is_strong, work.pieces[0])
    batch.control[ITEMS], batch.control[WORDS] = 0, 0
    if is_strong:
        status = add_pieces(net, known, work, batch, -1, marking, 0, bits, top)
        if status != DONE:
            return status
    else:
        add_matrix(known, batch, -1, marking, work.pieces[0], bits, top)
    last = batch.control[ITEMS]
    room = has_room(net, known, work, last)
    if room != DONE:
        return room
    if by_inclusion:
        store_largest(known, work, batch, 0, last, -1, bits, top)
        return DONE
    batch.target[:last] = UNKNOWN
    store(
        known.control, known.class_table, known.class_marking, known.record_start, known.codes,
        known.parent, known.via, known.edge_target, known.edge_label, batch.marking, batch.value,
        batch.start, batch.length, batch.target, batch.fired, batch.record, 0, last, -1, False,
    )  # fmt: skip
    return DONE


@kernel()
def initial_matrix(net, known, row, is_strong, initial):  # type: ignore[no-untyped-def]
    """Write the matrix of the initial class, which is not yet cut into pieces."""
    clocks, first = known.clocks[row], known.enabled_start[row]
    for i in range(clocks + 1):
        for j in range(clocks + 1):
            initial[i, j] = ZERO
    if is_strong:
        return
    for i in range(1, clocks + 1):
        transition = known.enabled[first + i - 1]
        initial[i, 0] = net.upper[transition]
        initial[0, i] = net.lower[transition]
    for i in range(1, clocks + 1):
        for j in range(1, clocks + 1):
            if i != j:
                upper, lower = initial[i, 0], initial[0, j]
                initial[i, j] = UNBOUNDED if upper == UNBOUNDED else upper + lower - ((upper | lower) & 1)
