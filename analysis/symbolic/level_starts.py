"""Initial orders of levels, made only from the levels that each event touches.

Levels are added one after the other. The next level is the one that begins the fewest events and ends the
most, so that few events are open at any height. Then the heuristic FORCE may move all levels towards the
middle of the events that touch them. The best of these orders, and its better direction, depend on the net;
`level_order` tries them. Ties are broken by the numbers of the levels, which come from a canonical order of
the net.

References
----------
F. A. Aloul, I. L. Markov, K. A. Sakallah, *FORCE: a fast and easy-to-implement variable-ordering heuristic*,
GLSVLSI 2003.

E. G. Amparore, S. Donatelli, M. Beccuti, G. Garbi, A. Miner, *Decision diagrams for Petri nets: a comparison
of variable ordering algorithms*, Transactions on Petri Nets and Other Models of Concurrency XIII, 2018
(FORCE-P; orders that put on one place after the other, by Noack and by Tovchigrechko).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from heapq import heapify, heappop, heappush

import numpy as np

from dineros.analysis.symbolic.kernels.force import force
from dineros.analysis.symbolic.levels import Encoding
from dineros.analysis.symbolic.relations import EventTables, Int64Array

FORCE_ROUNDS = 60
#: Number of levels from which an order is started; the order with the shortest total span is used.
ROOTS = 16
#: Wide levels are tried at the top if the widest has this many times the local states of the narrowest.
UNEVEN = 8


def first_start(encoding: Encoding, events: EventTables) -> list[int]:
    """Return one order of the levels, bottom first, that is cheap to make and good for most nets."""
    spans = _flowing(encoding, events)
    return spans.grown(spans.end())[::-1]


def wide_on_top(encoding: Encoding, events: EventTables) -> list[int] | None:
    """Return an order with the levels of most local states at the top; None if all have similar numbers.

    If each wide level shares events with many narrow ones, as a processor with all memories, no order has
    short spans. Then it matters more that few nodes are wide. The race of orders does not try this order:
    its narrow levels finish early, so its progress does not predict its total work.
    """
    widths = [len(level.states) for level in encoding.levels]
    if max(widths, default=0) < UNEVEN * min(widths, default=1):
        return None
    return sorted(first_start(encoding, events), key=widths.__getitem__)


def starts(encoding: Encoding, events: EventTables) -> Iterator[list[int]]:
    """Yield distinct orders of the levels, bottom first; those that are best most often come first."""
    known: set[tuple[int, ...]] = set()
    for order in _proposed(encoding, events):
        for turned in (order[::-1], order):
            if tuple(turned) not in known:
                known.add(tuple(turned))
                yield turned


def force_order(events: EventTables, start: Sequence[int]) -> list[int]:
    """Return the order that the FORCE heuristic makes from another order."""
    return _forced(start, events.event_start, events.event_level)


def _proposed(encoding: Encoding, events: EventTables) -> Iterator[list[int]]:
    lengths = np.cumsum([len(flow) for flow in encoding.flows], dtype=np.int64)
    start = np.concatenate([events.event_start, events.event_start[-1] + lengths])
    level = np.concatenate([events.event_level, *(np.array(flow, dtype=np.int64) for flow in encoding.flows)])
    size = len(encoding.levels)
    for spans in (_flowing(encoding, events), _Spans(size, events.levels_of_events)):
        roots = dict.fromkeys([spans.end(), *(size * n // ROOTS for n in range(ROOTS))])
        order = min((spans.grown(root) for root in roots), key=lambda order: span(events, order))
        yield order
        yield _forced(order, start, level)
        yield force_order(events, order)
    yield _forced(range(size), start, level)


def span(events: EventTables, order: Sequence[int]) -> int:
    """Return the sum, over all events, of the distance between the lowest and the highest level."""
    if events.event_level.size == 0:
        return 0
    position = np.empty(len(order), dtype=np.int64)
    position[np.array(order)] = np.arange(len(order))
    touched, start = position[events.event_level], events.event_start[:-1]
    return int((np.maximum.reduceat(touched, start) - np.minimum.reduceat(touched, start)).sum())


def orders_of_spans(size: int, spans: Sequence[Sequence[int]]) -> list[list[int]]:
    """Return two orders, bottom first, in which the levels of each span are close: one and its reverse."""
    if not size:
        return [[]]
    grouped = _Spans(size, spans)

    def length(order: list[int]) -> int:
        position = {level: at for at, level in enumerate(order)}
        return sum(max(map(position.__getitem__, s)) - min(map(position.__getitem__, s)) for s in spans)

    roots = dict.fromkeys([grouped.end(), *(size * n // ROOTS for n in range(ROOTS))])
    best = min((grouped.grown(root) for root in roots), key=length)
    return [best[::-1], best] if size > 1 else [best]


def _flowing(encoding: Encoding, events: EventTables) -> _Spans:
    return _Spans(len(encoding.levels), [*events.levels_of_events, *map(list, encoding.flows)])


def _forced(order: Sequence[int], start: Int64Array, level: Int64Array) -> list[int]:
    moved = np.array(order, dtype=np.int64)
    force(moved, start, level, FORCE_ROUNDS)
    return [int(level) for level in moved]


class _Spans:
    """Levels, and groups of levels that should be close: those of each event, optionally of each semiflow."""

    def __init__(self, size: int, spans: Sequence[Sequence[int]]) -> None:
        self._spans = [span for span in spans if len(span) > 1]
        self._of: list[list[int]] = [[] for _ in range(size)]
        for number, span in enumerate(self._spans):
            for level in span:
                self._of[level].append(number)

    def grown(self, root: int) -> list[int]:
        """Add levels in turn: next, the connected level that begins the fewest spans and ends the most."""
        size = len(self._of)
        left = [len(span) for span in self._spans]
        begun = [False] * len(self._spans)
        # By level: (whether no connected level was added yet, spans begun minus spans ended, when the level
        # was first met, number). Entries of the heap that differ from it are outdated.
        keys = [(True, len(of), 0, level) for level, of in enumerate(self._of)]
        if size:
            keys[root] = (False, -size, 0, root)
        heap = keys.copy()
        heapify(heap)
        order: list[int] = []
        is_put = [False] * size
        while heap:
            key = heappop(heap)
            level = key[3]
            if is_put[level] or key != keys[level]:
                continue
            is_put[level] = True
            order.append(level)
            change: dict[int, int] = {}
            for span in self._of[level]:
                left[span] -= 1
                others = self._spans[span]
                # Whether a further level of the span begins it, continues with it, or ends it.
                gain = (0 if begun[span] else -1) - (1 if left[span] == 1 else 0)
                if not begun[span] or left[span] == 1:
                    begun[span] = True
                    for other in others:
                        change[other] = change.get(other, 0) + gain
            for other, gain in change.items():
                if not is_put[other]:
                    is_new, balance, met, _ = keys[other]
                    keys[other] = (False, balance + gain, len(order) if is_new else met, other)
                    heappush(heap, keys[other])
        return order

    def end(self) -> int:
        """Return a level far from the others: the last level of a search from the last level of a search."""
        return self._met_from(self._met_from(0)) if self._of else 0

    def _met_from(self, root: int) -> int:
        """Return the last level of a breadth-first search; ties go to levels in few spans."""
        seen = {root}
        queue = deque([root])
        level = root
        while queue:
            level = queue.popleft()
            met = {other for span in self._of[level] for other in self._spans[span]} - seen
            seen |= met
            queue.extend(sorted(met, key=lambda other: (len(self._of[other]), other)))
        return level
