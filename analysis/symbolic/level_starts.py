"""Orders of levels to begin with, made from which events touch which levels and nothing else.

One level after the other is put on, always one that begins the fewest events and ends the most: so few events
are under way at any height. Then FORCE may move all levels to the middle of what they have to do with. Which
of these orders is best, and whether it is better upside down, hangs on the net; `level_order` tries them.
Where levels are alike, their numbers decide, and those come from a canonical order of the net.

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
#: Levels from which orders are grown; the one in which events span least is taken.
ROOTS = 16


def first_start(encoding: Encoding, events: EventTables) -> list[int]:
    """Return one order of the levels, bottom first, that costs little to make and is good for most nets."""
    spans = _flowing(encoding, events)
    return spans.grown(spans.end())[::-1]


def starts(encoding: Encoding, events: EventTables) -> Iterator[list[int]]:
    """Orders of the levels, bottom first, each of them once; those that are most often good come first."""
    known: set[tuple[int, ...]] = set()
    for order in _proposed(encoding, events):
        for turned in (order[::-1], order):
            if tuple(turned) not in known:
                known.add(tuple(turned))
                yield turned


def force_order(events: EventTables, start: Sequence[int]) -> list[int]:
    """Return the order that the FORCE heuristic makes of another one."""
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
    """Return how far the lowest and the highest level of each event are apart, summed up."""
    if events.event_level.size == 0:
        return 0
    position = np.empty(len(order), dtype=np.int64)
    position[np.array(order)] = np.arange(len(order))
    touched, start = position[events.event_level], events.event_start[:-1]
    return int((np.maximum.reduceat(touched, start) - np.minimum.reduceat(touched, start)).sum())


def _flowing(encoding: Encoding, events: EventTables) -> _Spans:
    return _Spans(len(encoding.levels), [*events.levels_of_events, *map(list, encoding.flows)])


def _forced(order: Sequence[int], start: Int64Array, level: Int64Array) -> list[int]:
    moved = np.array(order, dtype=np.int64)
    force(moved, start, level, FORCE_ROUNDS)
    return [int(level) for level in moved]


class _Spans:
    """Levels, and what should lie close together: the levels of each event, and maybe of each semiflow."""

    def __init__(self, size: int, spans: Sequence[Sequence[int]]) -> None:
        self._spans = [span for span in spans if len(span) > 1]
        self._of: list[list[int]] = [[] for _ in range(size)]
        for number, span in enumerate(self._spans):
            for level in span:
                self._of[level].append(number)

    def grown(self, root: int) -> list[int]:
        """Put on next what begins the fewest spans and ends the most, of what has to do with those put on."""
        size = len(self._of)
        left = [len(span) for span in self._spans]
        begun = [False] * len(self._spans)
        # By level: (whether nothing that it has to do with is there, spans begun less ended, when it was
        # met first, number); entries of the heap that differ from it are stale.
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
        """Return a level that is far from others: of those last met from the last one met from the first."""
        return self._met_from(self._met_from(0)) if self._of else 0

    def _met_from(self, root: int) -> int:
        """Return the level that a search breadth first meets last, those in few spans before others."""
        seen = {root}
        queue = deque([root])
        level = root
        while queue:
            level = queue.popleft()
            met = {other for span in self._of[level] for other in self._spans[span]} - seen
            seen |= met
            queue.extend(sorted(met, key=lambda other: (len(self._of[other]), other)))
        return level
