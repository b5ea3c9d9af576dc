"""Kernels for what follows state classes: the records after all firings, a batch of classes at a time.

So the table of known classes is asked for many records one after the other, and need not wait for memory
each time.
"""

from __future__ import annotations

from dineros.analysis.explicit.kernels.atomics import prefetch
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
    EDGES,
    ENABLED,
    KEPT,
    MARKINGS,
    UNKNOWN,
    fire_once,
)
from dineros.analysis.timed.kernels.records import (
    UNBOUNDED,
    ZERO,
    decode,
    encode,
    encode_after,
    hash_record,
    plus,
)

(DONE, GOES_ON, WANTS_TABLE, WANTS_ROOM, WANTS_CLOCKS, WANTS_BATCH, TOO_MANY_TOKENS) = range(7)

ITEMS, WORDS, COLLECTED, PENDING = range(4)
"""What is counted of a batch: records, their elements, classes, firings whose next marking is not known."""
BATCH_CONTROL = 4

MOST_TOKENS = 1 << 30
LOAD = 0.6


@kernel(inline="always")
def longest_record(work):  # type: ignore[no-untyped-def]
    """Length that no record exceeds."""
    size = work.matrix.shape[0]
    return size * (size + 2)


@kernel()
def has_room(net, known, work, firings):  # type: ignore[no-untyped-def]
    """Return the table that has no room for a number of further firings; `DONE` if all have room."""
    control = known.control
    if (
        control[MARKINGS] + firings > LOAD * known.marking_table.size
        or control[CLASSES] + firings > LOAD * known.class_table.size
    ):
        return WANTS_TABLE
    rows, record = firings * net.has_clock.size, 2 * longest_record(work)
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
def expand(net, known, work, batch, first, most, may_fire, is_second, is_strong, bits, top):  # type: ignore[no-untyped-def]
    """Write the successors of at most so many classes, of each all or none; return what the next one lacks.

    With `may_fire`, new markings are stored. Without it, only the batch is written: a class from which a
    transition fires for the first time in its marking is put off, and the firing is pending. The second call
    expands the classes that were put off. All is in one loop: a call of a kernel that gets all tables takes
    as long as a firing.
    """
    control = batch.control
    if not is_second:
        control[ITEMS], control[WORDS], control[PENDING] = 0, 0, 0
    control[COLLECTED] = 0
    before = work.elapsed if is_strong else work.matrix
    longest = longest_record(work)
    item, word = control[ITEMS], control[WORDS]
    for number in range(first, first + most):
        place = number - first
        if is_second and not batch.is_put_off[place]:
            control[COLLECTED] += 1
            continue
        item_before, word_before, is_put_off = item, word, False
        row = known.class_marking[number]
        clocks = known.clocks[row]
        start, end = known.enabled_start[row], known.enabled_start[row + 1]
        status = has_room(net, known, work, end - start)
        if status != DONE:
            return status
        if item + end - start > batch.fired.size or word + (end - start) * longest > batch.record.size:
            return WANTS_BATCH
        if control[PENDING] + end - start > batch.pending.size:
            return WANTS_BATCH
        decode(known.codes, known.record_start[number], clocks, work.matrix, bits, top)
        if is_strong:
            if net.above.size == 0 and not let_time_pass(net, known, work.matrix, row, clocks, -1, before):
                end = start
        else:
            least_waits(work.matrix, clocks, work.low)
        for at in range(start, end):
            fired = known.enabled[at]
            clock = at - start + 1 if at - start < clocks else 0
            if is_strong:
                if net.above.size:
                    if is_overridden(net, known, row, clocks, fired):
                        continue
                    if not let_time_pass(net, known, work.matrix, row, clocks, fired, before):
                        continue
                if clock and plus(before[clock, 0], net.lower[fired]) < ZERO:
                    continue
            elif not can_fire_first(work.matrix, clocks, clock):
                continue
            if known.next_marking[at] == UNKNOWN and not may_fire:
                batch.pending[control[PENDING]] = at
                batch.pending_class[control[PENDING]] = place
                control[PENDING] += 1
                is_put_off = True
            if is_put_off:
                continue
            if known.next_marking[at] == UNKNOWN:
                for arc in range(net.put_start[fired], net.put_start[fired + 1]):
                    if known.markings[row, net.put_place[arc]] > MOST_TOKENS - net.put_weight[arc]:
                        return TOO_MANY_TOKENS
                fire_once(net, known, row, at, work.tokens)
            after, kept = known.next_marking[at], known.kept_start[at]
            count, running = known.clocks[after], known.enabled_start[after]
            if count + 1 > work.matrix.shape[0]:
                return WANTS_CLOCKS
            if is_strong:
                strong_ends(
                    known.kept, kept, count, before, clocks, clock, net.lower[fired], work.low, work.ends
                )
                if any_unbounded(net.upper, known.enabled, running, count):
                    matrix_after(known.kept, kept, count, before, work.ends, work.pieces[0])
                    control[ITEMS], control[WORDS] = item, word
                    status = add_pieces(net, known, work, batch, fired, after, end - at, bits, top)
                    if status != DONE:
                        return status
                    item, word = control[ITEMS], control[WORDS]
                    continue
            else:
                linear_ends(
                    net.upper, net.lower, known.enabled, running, known.kept, kept, count,
                    work.matrix, work.low, clock, work.ends,
                )  # fmt: skip
            length = encode_after(known.kept, kept, count, before, work.ends, batch.record, word, bits, top)
            value = hash_record(after, batch.record, word, length)
            prefetch(known.class_table, value & (known.class_table.size - 1))
            batch.fired[item] = fired
            batch.marking[item] = after
            batch.value[item] = value
            batch.start[item] = word
            batch.length[item] = length
            item += 1
            word += length
        if is_put_off:
            item, word = item_before, word_before
        batch.is_put_off[place] = is_put_off
        batch.first_item[place] = item_before
        batch.last_item[place] = item
        control[ITEMS], control[WORDS] = item, word
        control[COLLECTED] += 1
    return DONE


@kernel()
def is_overridden(net, known, row, clocks, fired):  # type: ignore[no-untyped-def]
    """Whether a transition without a clock, which may fire at any time, has priority over another."""
    for at in range(known.enabled_start[row] + clocks, known.enabled_start[row + 1]):
        for k in range(net.above_start[fired], net.above_start[fired + 1]):
            if net.above[k] == known.enabled[at]:
                return True
    return False


@kernel(inline="always")
def any_unbounded(upper, enabled, start, clocks):  # type: ignore[no-untyped-def]
    """Whether any clock of a marking has no latest bound."""
    found = False
    for at in range(start, start + clocks):
        found |= upper[enabled[at]] == UNBOUNDED
    return found


@kernel()
def add_matrix(known, batch, fired, marking, matrix, bits, top):  # type: ignore[no-untyped-def]
    """Add the record of a matrix, for which there is room."""
    control = batch.control
    item, word = control[ITEMS], control[WORDS]
    length = encode(matrix, known.clocks[marking], batch.record, word, bits, top)
    batch.fired[item] = fired
    batch.marking[item] = marking
    batch.value[item] = hash_record(marking, batch.record, word, length)
    batch.start[item] = word
    batch.length[item] = length
    control[ITEMS] = item + 1
    control[WORDS] = word + length


@kernel()
def add_pieces(net, known, work, batch, fired, marking, more, bits, top):  # type: ignore[no-untyped-def]
    """Add the pieces of the strong class in ``work.pieces[0]``, with room for `more`; what is lacking."""
    control, depth = batch.control, 0
    work.split[0] = 0
    while depth >= 0:
        depth = whole_piece(net, known, marking, work.pieces, work.split, depth)
        if (
            control[ITEMS] + 1 + more > batch.fired.size
            or control[WORDS] + (1 + more) * longest_record(work) > batch.record.size
        ):
            return WANTS_BATCH
        add_matrix(known, batch, fired, marking, work.pieces[depth], bits, top)
        depth -= 1
    return DONE


@kernel()
def whole_piece(net, known, marking, pieces, split, depth):  # type: ignore[no-untyped-def]
    """Cut a strong class where clocks without a latest bound come to matter no more; return a whole piece.

    The class is in ``pieces[0]``, and ``split[0]`` is 0. A piece is cut by one clock after the other; the
    rest waits below the piece that is returned, so the next one is found from there on.
    """
    clocks, first = known.clocks[marking], known.enabled_start[marking]
    while True:
        clock = split[depth] + 1
        while clock <= clocks and net.upper[known.enabled[first + clock - 1]] < UNBOUNDED:
            clock += 1
        if clock > clocks:
            return depth
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
