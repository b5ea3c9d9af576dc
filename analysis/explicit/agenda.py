"""What a search expands next: whole levels, or what a bound says to cost the least."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from dineros.analysis.explicit.tables import Int64Array, transition_set

#: Rows of the store by worker.
Rows = list[int]


class AgendaPart(NamedTuple):
    """Rows to be expanded.

    Attributes
    ----------
    starts, ends : list of int
        By worker: the first row, and the one after the last.
    transitions : int64 array
        The set of those that are fired.
    goes_on : bool
        Whether what is found by that belongs to the next part and may be expanded at once.
    """

    starts: Rows
    ends: Rows
    transitions: Int64Array
    goes_on: bool


def closure(
    transitions: Int64Array, starts: Rows, ends: Callable[[], Rows], done: Callable[[], Rows]
) -> Iterator[AgendaPart]:
    """Yield all rows from these on, and those that are found meanwhile, breadth first.

    Parameters
    ----------
    transitions
        Those that are fired.
    starts
        By worker: the first row.
    ends
        Tells the row after the last one that was found.
    done
        Tells the row after the last one that was expanded.
    """
    while starts != (now := ends()):
        yield AgendaPart(starts, now, transitions, True)
        starts = done()


def sets_by_cost(costs: Sequence[int], wanted: Sequence[int]) -> dict[int, Int64Array]:
    """Return the sets of transitions by what they cost.

    Parameters
    ----------
    costs
        By transition, in the engine's order.
    wanted
        Transitions that are looked for: they stand with those that cost nothing, which every marking is
        asked for.
    """
    return {
        cost: transition_set(
            [t for t, other in enumerate(costs) if other == cost or (cost == 0 and t in wanted)], len(costs)
        )
        for cost in {0, *costs}
    }


def by_cost(
    sets: dict[int, Int64Array],
    starts: Rows,
    ends: Callable[[], Rows],
    done: Callable[[], Rows],
    most: int | None = None,
) -> Iterator[AgendaPart]:
    """Yield rows in the order of what the cheapest way to them costs, as Dijkstra's algorithm does.

    A level are the markings of one cost. It is closed under what costs nothing; then what costs more waits
    until the level it leads to. So each marking is met at its least cost, and never moved.

    Parameters
    ----------
    sets
        Transitions by cost; those that cost nothing are among them.
    starts, ends, done
        As for `closure`.
    most
        The largest cost that is looked at.
    """
    costs = sorted(cost for cost in sets if cost)
    waiting: list[tuple[int, int, Rows, Rows]] = []
    level = 0
    while True:
        yield from closure(sets[0], starts, ends, done)
        now = ends()
        if now != starts:
            for cost in costs:
                heapq.heappush(waiting, (level + cost, cost, starts, now))
        starts = now
        if not waiting or (most is not None and waiting[0][0] > most):
            return
        level = waiting[0][0]
        while waiting and waiting[0][0] == level:
            _, cost, first, last = heapq.heappop(waiting)
            yield AgendaPart(first, last, sets[cost], False)
