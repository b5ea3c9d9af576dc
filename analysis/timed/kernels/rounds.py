"""Kernels of a round: many classes are expanded by several threads, with the result of one thread.

A round has phases, and a phase ends when all threads have ended it. In each phase, a thread writes only where
no other one reads or writes:

* `expand_parts`: a thread takes a part of the classes at a time and writes the batch of that part. The tables
  of all that is known are only read. A class from which a transition fires for the first time in its marking
  is put off.
* `fire_pending` stores new markings in one thread, in the order of classes and transitions, as one thread
  would. Then `expand_parts` expands the classes that were put off, and looks all records up.
* `find_first`: each thread takes the unknown records whose hash is its own, in order, and notes the first
  record of each kind in a table of its own.
* `give_room` counts the first records of each part; so each part knows its numbers and its room.
* `store_parts`: a thread stores the first records of a part in the room of that part. Threads share only the
  table of classes: an entry is written by compare and swap into a free slot. No entry is compared or moved,
  and all are of different classes, so the order of the writes changes slots, but no answer of the table.
* `link_parts` notes the edges, once all numbers are known.
"""

from __future__ import annotations

from dineros.analysis.explicit.kernels.atomics import compare_and_swap, fetch_and_add
from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.timed.kernels.exploration import look_up
from dineros.analysis.timed.kernels.markings import (
    CLASSES,
    CODES,
    DEADLOCKS,
    EDGES,
    INDEX_BITS,
    NEXT,
    TAG_SHIFT,
    UNKNOWN,
    fire_once,
)
from dineros.analysis.timed.kernels.successors import (
    COLLECTED,
    DONE,
    ITEMS,
    MOST_TOKENS,
    PENDING,
    expand,
    has_room,
)
from dineros.analysis.timed.tables import Batch

OWNER_SHIFT = 48
ROUND_SHIFT = 32

NEW, NEW_WORDS, EDGES_OF, DEAD = range(4)
"""What is counted of a part: new classes, elements of their records, edges, classes without successors."""
COUNTS = 4


@kernel()
def batch_of(batches, part):  # type: ignore[no-untyped-def]
    """Return the batch of a part."""
    return Batch(
        batches.control[part],
        batches.first_item[part],
        batches.last_item[part],
        batches.is_put_off[part],
        batches.pending[part],
        batches.pending_class[part],
        batches.fired[part],
        batches.marking[part],
        batches.value[part],
        batches.start[part],
        batches.length[part],
        batches.target[part],
        batches.origin[part],
        batches.record[part],
    )


@kernel(nogil=True)
def expand_parts(net, known, work, batches, turn, count, is_second, is_strong, bits, top):  # type: ignore[no-untyped-def]
    """Expand the classes of one part after the other, those that were put off in the second call."""
    size = batches.first_item.shape[1]
    first = known.control[NEXT]
    while True:
        part = fetch_and_add(turn, 0, 1)
        left = count - part * size
        if left <= 0:
            return
        batch, start = batch_of(batches, part), first + part * size
        expand(net, known, work, batch, start, min(left, size), False, is_second, is_strong, bits, top)
        if is_second:
            look_up(known, batch, batch.control[ITEMS])


@kernel(nogil=True)
def fire_pending(net, known, work, batches, count):  # type: ignore[no-untyped-def]
    """Fire what fires for the first time; return how many classes can be expanded now."""
    size, first = batches.first_item.shape[1], known.control[NEXT]
    for part in range((count + size - 1) // size):
        collected = batches.control[part, COLLECTED]
        for k in range(batches.control[part, PENDING]):
            place, at = batches.pending_class[part, k], batches.pending[part, k]
            if place >= collected:
                break
            if known.next_marking[at] != UNKNOWN:
                continue
            row, fired = known.class_marking[first + part * size + place], known.enabled[at]
            fits = has_room(net, known, work, 1) == DONE
            for arc in range(net.put_start[fired], net.put_start[fired + 1]):
                fits &= known.markings[row, net.put_place[arc]] <= MOST_TOKENS - net.put_weight[arc]
            if not fits:
                return part * size + place
            fire_once(net, known, row, at, work.tokens)
        if collected < min(size, count - part * size):
            return part * size + collected
    return count


@kernel(nogil=True)
def expanded(batches, count):  # type: ignore[no-untyped-def]
    """Return how many classes were expanded, without a gap, and how many records follow them at most."""
    size, items = batches.first_item.shape[1], 0
    for part in range((count + size - 1) // size):
        items += batches.control[part, ITEMS]
        collected = batches.control[part, COLLECTED]
        if collected < min(size, count - part * size):
            return part * size + collected, items
    return count, items


@kernel(nogil=True)
def find_first(batches, seen, number, me, workers, count, counts):  # type: ignore[no-untyped-def]
    """Note by unknown record whose hash is one's own the first record that equals it; count what is new.

    Records are numbered through all parts. An entry of `seen` holds the number of the round, above 0, and
    that of a record; entries of other rounds are free.
    """
    size, items = batches.first_item.shape[1], batches.target.shape[1]
    mask = seen.size - 1
    for part in range((count + size - 1) // size):
        new = words = edges = dead = 0
        for place in range(min(size, count - part * size)):
            first, last = batches.first_item[part, place], batches.last_item[part, place]
            edges += last - first
            dead += first == last
            for item in range(first, last):
                if batches.target[part, item] != UNKNOWN:
                    continue
                value = batches.value[part, item]
                if (value >> OWNER_SHIFT) % workers != me:
                    continue
                slot, found = value & mask, False
                while seen[slot] >> ROUND_SHIFT == number:
                    other = seen[slot] & ((1 << ROUND_SHIFT) - 1)
                    if is_same(batches, other // items, other % items, part, item):
                        batches.origin[part, item] = other
                        found = True
                        break
                    slot = (slot + 1) & mask
                if not found:
                    seen[slot] = number << ROUND_SHIFT | (part * items + item)
                    batches.origin[part, item] = part * items + item
                    new += 1
                    words += batches.length[part, item]
        counts[me, part, NEW], counts[me, part, NEW_WORDS] = new, words
        counts[me, part, EDGES_OF], counts[me, part, DEAD] = edges, dead


@kernel()
def is_same(batches, part, item, other_part, other):  # type: ignore[no-untyped-def]
    """Whether two records of a round are equal."""
    length = batches.length[part, item]
    if (
        batches.value[part, item] != batches.value[other_part, other]
        or batches.marking[part, item] != batches.marking[other_part, other]
        or length != batches.length[other_part, other]
    ):
        return False
    one, two = batches.start[part, item], batches.start[other_part, other]
    at = 0
    while at < length and batches.record[part, one + at] == batches.record[other_part, two + at]:
        at += 1
    return at == length


@kernel(nogil=True)
def give_room(known, counts, parts, room, total):  # type: ignore[no-untyped-def]
    """Write by part where its classes, their records and its edges begin, and where those of the last end."""
    control = known.control
    total[NEW], total[NEW_WORDS], total[EDGES_OF] = control[CLASSES], control[CODES], control[EDGES]
    total[DEAD] = 0
    for part in range(parts):
        room[part] = total
        for worker in range(counts.shape[0]):
            total[NEW] += counts[worker, part, NEW]
            total[NEW_WORDS] += counts[worker, part, NEW_WORDS]
        total[EDGES_OF] += counts[0, part, EDGES_OF]
        total[DEAD] += counts[0, part, DEAD]


@kernel(nogil=True)
def store_parts(known, batches, room, turn, count):  # type: ignore[no-untyped-def]
    """Store the new records of one part after the other."""
    size, items = batches.first_item.shape[1], batches.target.shape[1]
    table, mask, first_class = known.class_table, known.class_table.size - 1, known.control[NEXT]
    while True:
        part = fetch_and_add(turn, 0, 1)
        left = count - part * size
        if left <= 0:
            return
        number, code = room[part, NEW], room[part, NEW_WORDS]
        for place in range(min(size, left)):
            for item in range(batches.first_item[part, place], batches.last_item[part, place]):
                if batches.target[part, item] != UNKNOWN or batches.origin[part, item] != part * items + item:
                    continue
                start, value = batches.start[part, item], batches.value[part, item]
                for at in range(batches.length[part, item]):
                    known.codes[code + at] = batches.record[part, start + at]
                code += batches.length[part, item]
                known.class_marking[number] = batches.marking[part, item]
                known.record_start[number + 1] = code
                entry, slot = value >> TAG_SHIFT << INDEX_BITS | (number + 1), value & mask
                while table[slot] != 0 or not compare_and_swap(table, slot, 0, entry):
                    slot = (slot + 1) & mask
                if known.parent.size:
                    known.parent[number] = first_class + part * size + place
                    known.via[number] = batches.fired[part, item]
                batches.target[part, item] = number
                number += 1


@kernel(nogil=True)
def link_parts(known, batches, room, turn, count):  # type: ignore[no-untyped-def]
    """Note the edges from the classes of one part after the other."""
    size, items = batches.first_item.shape[1], batches.target.shape[1]
    first = known.control[NEXT]
    while True:
        part = fetch_and_add(turn, 0, 1)
        left = count - part * size
        if left <= 0:
            return
        edge = room[part, EDGES_OF]
        for place in range(min(size, left)):
            known.edge_first[first + part * size + place] = edge
            for item in range(batches.first_item[part, place], batches.last_item[part, place]):
                number = batches.target[part, item]
                if number == UNKNOWN:
                    origin = batches.origin[part, item]
                    number = batches.target[origin // items, origin % items]
                known.edge_target[edge] = number
                known.edge_label[edge] = batches.fired[part, item]
                edge += 1
            known.edge_last[first + part * size + place] = edge


@kernel(nogil=True)
def end_round(known, total, count):  # type: ignore[no-untyped-def]
    """Take over what all parts have stored."""
    control = known.control
    control[CLASSES], control[CODES], control[EDGES] = total[NEW], total[NEW_WORDS], total[EDGES_OF]
    control[DEADLOCKS] += total[DEAD]
    control[NEXT] += count
