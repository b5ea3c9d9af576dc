"""The next markings to expand in a search: whole levels, or those with the least cost by a bound."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from dineros.analysis.explicit.tables import Int64Array, transition_set

#: Rows of the store by worker.
Rows = list[int]


class AgendaPart(NamedTuple):
    """Rows to expand.

    Attributes
    ----------
    starts, ends : list of int
        For each worker, the first row, and the row after the last.
    goes_on : bool
        Whether markings found now belong to the next part and may be expanded at once.
    """

    starts: Rows
    ends: Rows
    transitions: Int64Array
    goes_on: bool


def closure(
    transitions: Int64Array, starts: Rows, ends: Callable[[], Rows], done: Callable[[], Rows]
) -> Iterator[AgendaPart]:
    """Yield all rows from the given ones on, including those found meanwhile, breadth first.

    Parameters
    ----------
    starts
        For each worker, the first row.
    ends
        Returns for each worker the row after the last one found.
    done
        Returns for each worker the row after the last one expanded.
    """
    while starts != (now := ends()):
        yield AgendaPart(starts, now, transitions, True)
        starts = done()


def sets_by_cost(costs: Sequence[int], wanted: Sequence[int]) -> dict[int, Int64Array]:
    """Return the sets of transitions by cost.

    Parameters
    ----------
    costs
        Cost of each transition, in the engine's order.
    wanted
        Transitions to be found: they are put in the set with cost 0, which is checked in every marking.
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
    """Yield rows in order of their least cost, as Dijkstra's algorithm does.

    A level is the set of markings of one cost. It is closed under transitions of cost 0; transitions of a
    higher cost wait until the level to which they lead. So each marking is found at its least cost, and never
    moved.

    Parameters
    ----------
    sets
        Transitions by cost, including those of cost 0.
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
