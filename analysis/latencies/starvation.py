"""Whether a ready callback can wait forever, because other callbacks are always taken first.

It can if there is an endless run in which the callback is ready from some moment on, and never begins: a
circle of state classes in which it is ready, without an edge by which it begins; or a class in which it is
ready and nothing has to happen any more. Every run goes through the largest classes, too, so where these have
no such circle, there is none. If they have one, classes that are compared by equality decide: each of their
endless paths is one of a run. A circle during which a clock that must end keeps running takes no time, so a
run leaves it.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.parts import Parts
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.exploring import Explored
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.search import ClassSearch
from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import readers_of


class Starvation:
    """Answers which callbacks can wait without end.

    Parameters
    ----------
    parts, explored
        The net, and its largest state classes, all of them.
    budget
        Limits of the search through classes that are compared by equality.
    """

    def __init__(self, parts: Parts, explored: Explored, budget: Budget) -> None:
        self._parts, self._explored, self._budget = parts, explored, budget
        self._net: TimedNet = explored.net
        self._graph: ClassSearch | None = None
        self._known: dict[sym.CallbackPage, bool | None] = {}

    def of(self, page: sym.CallbackPage) -> bool | None:
        """Return whether a callback can be ready forever without starting; None: unknown."""
        if page not in self._known:
            self._known[page] = self._decided(page)
        return self._known[page]

    def _decided(self, page: sym.CallbackPage) -> bool | None:
        ready, begins = self._ready(page), self._begins(page)
        if not ready or not begins:
            return None
        if not self._waits(self._explored.search, ready, begins):
            return False
        if self._graph is None:
            kind: Kind = "S" if self._net.has_priorities else "W"
            self._graph = ClassSearch(self._net, kind, self._budget, keeps_edges=True)
            self._graph.run()
        return self._waits(self._graph, ready, begins) if self._graph.is_done else None

    def _ready(self, page: sym.CallbackPage) -> list[int]:
        """Return the places of which one is marked while a callback is ready."""
        parts = self._parts
        if page.kind == sym.CallbackKind.timer:
            names = [parts.ticks[page][1]] if page in parts.ticks else []
        elif page.kind == sym.CallbackKind.subscriber:
            histories = [parts.histories.get(reader) for reader in readers_of(page)]
            names = [queue.load for queue in histories if queue is not None]
        else:
            names = [
                place
                for service, places in parts.requests.items()
                if service.server.page is page
                for place in places
            ]
        return [self._net.untimed.places.index(name) for name in names]

    def _begins(self, page: sym.CallbackPage) -> list[int]:
        running = {place for run in self._parts.runs_of(page) for place in run.places}
        places = self._net.untimed.places
        found = []
        for transition in range(len(self._net.untimed.transitions)):
            taken = dict(self._net.take.row(transition))
            put = self._net.put.row(transition)
            if any(places[p] in running and weight > taken.get(p, 0) for p, weight in put):
                found.append(transition)
        return found

    def _waits(self, search: ClassSearch, ready: list[int], begins: list[int]) -> bool:
        """Return whether classes have a circle, or one to stay in, where a callback is ready all the time."""
        held: NDArray[np.bool_] = np.any(search.markings()[:, ready] > 0, axis=1)
        marked = held[search.marking_of]
        source, target, label = _edges(search)
        if (marked & ~np.isin(np.arange(search.classes), source) & _alive(search)).any():
            return True
        if (marked & _alive(search) & self._may_stay(search)).any():
            return True
        inside = marked[source] & marked[target] & ~np.isin(label, begins)
        return self._has_circle(search, source[inside], target[inside], label[inside])

    def _has_circle(
        self, search: ClassSearch, source: Int64Array, target: Int64Array, label: Int64Array
    ) -> bool:
        """Return whether edges have a circle in which each clock that must end is stopped at some edge.

        In any other circle time cannot continue, so a run leaves it.
        """
        graph = csr_array(
            (np.ones(len(source), dtype=np.int8), (source, target)), shape=(search.classes, search.classes)
        )
        component = connected_components(graph, directed=True, connection="strong")[1]
        within = component[source] == component[target]
        source, target, label = source[within], target[within], label[within]
        circles = set(component[source].tolist())
        for clock, interval in enumerate(self._net.intervals):
            if circles and interval.latest is not None:
                stops = ~self._keeps(search, source, target, label, clock)
                circles &= set(component[source[stops]].tolist())
        return bool(circles)

    def _keeps(
        self, search: ClassSearch, source: Int64Array, target: Int64Array, label: Int64Array, clock: int
    ) -> NDArray[np.bool_]:
        """Return of edges whether a transition stays enabled by them, with the same clock."""
        markings, net = search.markings(), self._net
        before, after = search.marking_of[source], search.marking_of[target]
        stays: NDArray[np.bool_] = label != clock
        for place, weight in net.untimed.pre.row(clock):
            taken = np.array([row.get(place, 0) for row in self._taken])[label]
            held = markings[:, place]
            stays &= (held[before] - taken >= weight) & (held[after] >= weight)
        for place, below in net.untimed.inhibitor.row(clock):
            held = markings[:, place]
            stays &= (held[before] < below) & (held[after] < below)
        return stays

    @cached_property
    def _taken(self) -> list[dict[int, int]]:
        """By transition, what it takes from places."""
        return [dict(self._net.take.row(each)) for each in range(len(self._net.untimed.transitions))]

    def _may_stay(self, search: ClassSearch) -> NDArray[np.bool_]:
        """Return by class whether nothing that is enabled there ever has to happen."""
        known = search.known
        latest = np.array([interval.latest is not None for interval in self._net.intervals])
        rows = int(search.marking_of.max()) + 1
        starts = known.enabled_start[: rows + 1]
        has_to = np.zeros(rows, dtype=bool)
        for row in range(rows):
            has_to[row] = latest[known.enabled[starts[row] : starts[row + 1]]].any()
        may: NDArray[np.bool_] = ~has_to[search.marking_of]
        return may


def _alive(search: ClassSearch) -> NDArray[np.bool_]:
    if not search.by_inclusion:
        return np.ones(search.classes, dtype=bool)
    alive: NDArray[np.bool_] = search.kept() == np.arange(search.classes)
    return alive


def _edges(search: ClassSearch) -> tuple[Int64Array, Int64Array, Int64Array]:
    """Return source, target and transition of the edges between classes that are kept."""
    known, alive = search.known, _alive(search)
    first, last = known.edge_first[: search.classes], known.edge_last[: search.classes]
    many = np.where(alive, last - first, 0)
    source = np.repeat(np.arange(search.classes), many)
    offset = np.arange(len(source)) - np.repeat(np.cumsum(many) - many, many)
    at = first[source] + offset
    target = known.edge_target[at]
    if search.by_inclusion:
        target = search.kept()[target]
    return source, target, known.edge_label[at]
