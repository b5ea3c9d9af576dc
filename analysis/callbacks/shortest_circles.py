"""Finds the shortest circle among those that wait for each other.

Each that waits has ways on, and each way needs all of a set. So those wait for each other of which every way
needs another one of them. Among these, a circle leads from one to the next that it needs, and back.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TypeAlias

from dineros.analysis.callbacks.circles import Circle, Reason, Waiter

Ways: TypeAlias = list[frozenset[Waiter]]
"""Ways on for one that waits; each needs all of a set."""
Needs: TypeAlias = Mapping[Waiter, Sequence[Waiter]]


def shortest_circle(
    ways: Mapping[Waiter, Ways], held: Collection[Waiter], begun: Collection[Waiter], of: Waiter | None = None
) -> Circle | None:
    """Return a shortest circle that begins with a callback; None if there is none.

    Parameters
    ----------
    ways : mapping of Waiter to list of frozenset of Waiter
        The ways on for each that waits.
    held : collection of Waiter
        Places that wait for the callbacks which hold their token.
    begun : collection of Waiter
        Callbacks that have begun: circles begin with one of them.
    of : Waiter, optional
        Only circles that it waits for, those that it is in before others.
    """
    stuck = _stuck(ways)
    if not stuck:
        return None
    needs = {
        waiter: sorted({n for way in ways[waiter] for n in way if n in stuck}, key=text_of)
        for waiter in sorted(stuck, key=text_of)
    }
    circles = list(_circles(needs, begun, of))
    if not circles:
        return None

    def rank(circle: tuple[Waiter, ...]) -> tuple[bool, int, list[str]]:
        return of is not None and of not in circle, len(circle), [waiter.text for waiter in circle]

    waiters = min(circles, key=rank)
    return Circle(waiters, tuple(_reasons(waiters, needs, ways, held)))


def text_of(waiter: Waiter) -> str:
    """Return the text of one that waits, by which they are sorted."""
    return waiter.text


def _stuck(ways: Mapping[Waiter, Ways]) -> set[Waiter]:
    """Return those that wait for each other: of each way on for them, something waits in turn."""
    stuck = {waiter for waiter, each in ways.items() if each}
    while True:
        free = {waiter for waiter in stuck if any(way.isdisjoint(stuck) for way in ways[waiter])}
        if not free:
            return stuck
        stuck -= free


def _circles(needs: Needs, begun: Collection[Waiter], of: Waiter | None) -> Iterator[tuple[Waiter, ...]]:
    """Yield shortest circles through each callback that has begun, of parts that `of` waits for."""
    import networkx as nx  # takes a while to import

    edges = [(one, other) for one in needs for other in needs[one]]
    graph: nx.DiGraph[Waiter] = nx.DiGraph(edges)
    reached = None if of is None else {of, *(nx.descendants(graph, of) if of in graph else ())}
    for part in nx.strongly_connected_components(graph):
        if reached is not None and reached.isdisjoint(part):
            continue
        here: nx.DiGraph[Waiter] = nx.DiGraph([edge for edge in edges if part.issuperset(edge)])
        for waiter in (each for each in here if each in begun):
            for after in here.successors(waiter):
                yield (waiter, *nx.shortest_path(here, after, waiter)[:-1])


def _reasons(
    waiters: Sequence[Waiter], needs: Needs, ways: Mapping[Waiter, Ways], held: Collection[Waiter]
) -> Iterator[Reason]:
    """Yield why those in a circle wait, then why all others wait that they need or could have instead."""
    queue, known = list(waiters), set(waiters)
    for waiter in queue:
        is_choice = len(ways[waiter]) > 1
        yield Reason(waiter, tuple(needs[waiter]), is_choice, waiter.kind != "place" or waiter in held)
        new = [each for each in needs[waiter] if each not in known]
        queue += new
        known.update(new)
