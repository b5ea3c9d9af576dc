"""Callbacks that can wait forever in a net with times.

A state class from which no class without the callback can be reached holds only states in which it waits
forever. Linear classes do not show the converse, so that every callback can end is proved in another way: no
run stays in it forever, or its response time has a bound.

Runs of a callback can overlap, so that it always runs although each run ends. If runs end again and again,
it is not said to wait forever.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from dineros.analysis.answers.stages import Share
from dineros.analysis.callbacks.blocking import MOST_PARTS, Blocked
from dineros.analysis.callbacks.circles import Circle, Waiter
from dineros.analysis.callbacks.waiting import Callback
from dineros.analysis.callbacks.walking import Walks
from dineros.analysis.checks.blocking import Callbacks
from dineros.analysis.checks.question import Checked
from dineros.analysis.logic.graphs.predicates import Flags
from dineros.analysis.nets.graph_parts import numbered_parts
from dineros.analysis.timed.graph import WAITING, TimedGraph, timed_graph
from dineros.analysis.timed_checks.timed_checked import TimedChecked, with_times

ALL_END = "every callback that has begun ends"
OTHERS_END = "every other callback that has begun ends"
GRAPH = Share(time=0.5)
"""Part of the time that is left for the graph of all classes."""


class TimedCallbacks(Callbacks):
    """Whether callbacks can wait forever with times."""

    needs_space: ClassVar[bool] = True

    def ask(self, checked: Checked) -> None:
        """Look for classes that no way out leads from."""
        known = with_times(checked)
        callbacks = list(checked.waiting.callbacks.values())
        if not callbacks:
            return
        if not known.explored.is_complete:
            found = self._report(checked, _met(known))
            if known.ending_by_bounds >= {each.page for each in callbacks}:
                checked.report.proved.append(ALL_END)
                return
            asks = "which other callbacks can wait forever" if found else self.asks
            checked.leave_open(asks, known.explored.reason)
            return
        net = known.timed.timed
        graph = timed_graph(net, "S" if net.has_priorities else "W", GRAPH.share(checked.budget))
        known.waits = waits_of(graph, callbacks)
        found = self._report(checked, _blocked(graph, known.waiting.circle, callbacks))
        is_open = {
            each.page
            for each, (waits, ends) in zip(callbacks, known.waits, strict=True)
            if not (ends or waits)
        }
        if not is_open or is_open <= known.ending_by_bounds:
            checked.report.proved.append(OTHERS_END if found else ALL_END)
        else:
            asks = "which other callbacks can wait forever" if found else self.asks
            checked.leave_open(asks, "some run stays in one forever, and linear classes cannot decide more")


def _met(known: TimedChecked) -> list[Blocked]:
    """Return the callbacks that never end after a random run, each once: in a circle if one is known.

    A callback that never ends without times never ends with them.
    """
    walks = Walks(known.subject.net, known.waiting)
    found: dict[Waiter, Blocked] = {}
    for run in known.walked.runs:
        if known.budget.is_over:
            break
        for each in walks.blocked_after(run):
            best = found.get(each.callback)
            if best is None or _rank(each) < _rank(best):
                found[each.callback] = each
    inside = {waiter for each in found.values() if each.circle for waiter in each.circle.waiters}
    some = [each for each in found.values() if each.circle or each.callback not in inside]
    return sorted(some, key=_rank)


def _rank(blocked: Blocked) -> tuple[bool, int]:
    return blocked.circle is None, len(blocked.trace)


def waits_of(graph: TimedGraph, callbacks: list[Callback]) -> list[tuple[bool, bool]]:
    """Return by callback whether it can wait forever, and whether no run stays in it forever."""
    return [(_waits(graph, each), _always_ends(graph, each)) for each in callbacks]


def _waits(graph: TimedGraph, callback: Callback) -> bool:
    doomed = _doomed(graph, callback)
    return bool(doomed.any()) and any(not ends for _, ends in _last_classes(graph, doomed, callback))


def _blocked(graph: TimedGraph, circle_of: object, callbacks: list[Callback]) -> Iterator[Blocked]:
    """Yield the callbacks that wait forever: each circle once, and each other callback once."""
    assert callable(circle_of)
    known: set[Circle] = set()
    for callback in callbacks:
        doomed = _doomed(graph, callback)
        if not doomed.any():
            continue
        is_alone, stuck = True, []
        for number, ends in _last_classes(graph, doomed, callback):
            circle: Circle | None = circle_of(graph.markings[graph.marking_of[number]].tolist())
            is_alone &= circle is None
            stuck += [] if ends else [number]
            if circle is not None and circle not in known:
                known.add(circle)
                yield Blocked(callback.waiter, circle, _way(graph, number))
        if is_alone and stuck:
            yield Blocked(callback.waiter, None, _way(graph, stuck[0]))


def _runs(graph: TimedGraph, callback: Callback) -> Flags:
    """Return by class whether a callback has begun and not ended."""
    tokens = graph.markings[:, list(callback.places)].max(axis=1)
    return np.asarray(tokens > 0)[graph.marking_of]


def _doomed(graph: TimedGraph, callback: Callback) -> Flags:
    """Return the classes from which no class without a callback can be reached."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import breadth_first_order

    ended = np.flatnonzero(~_runs(graph, callback))
    # Backwards, from one more node that leads to all classes without it.
    source = np.concatenate([graph.target, np.full(len(ended), graph.classes)])
    target = np.concatenate([graph.source, ended])
    size = graph.classes + 1
    matrix = csr_array((np.ones(len(source), dtype=np.int8), (source, target)), shape=(size, size))
    doomed = np.ones(size, dtype=np.bool_)
    doomed[breadth_first_order(matrix, graph.classes, return_predecessors=False)] = False
    return doomed[:-1]


def _always_ends(graph: TimedGraph, callback: Callback) -> bool:
    """Whether no run stays forever in classes with a callback."""
    runs = _runs(graph, callback)
    inside = runs[graph.source] & runs[graph.target]
    source, target = graph.source[inside], graph.target[inside]
    if (source == target).any():
        return False
    _, part = numbered_parts(graph.classes, source.astype(np.int32), target.astype(np.int32))
    has_after = np.zeros(graph.classes, dtype=np.bool_)
    has_after[graph.source] = True
    return bool((part[source] != part[target]).all() and has_after[runs].all())


def _last_classes(graph: TimedGraph, among: Flags, callback: Callback) -> list[tuple[int, bool]]:
    """Return one class of each part that is never left, and whether runs of a callback end in that part.

    `among`: classes that are never left together.
    """
    inside = among[graph.source]
    source, target = graph.source[inside], graph.target[inside]
    _, part = numbered_parts(graph.classes, source.astype(np.int32), target.astype(np.int32))
    parts = int(part.max(initial=0)) + 1
    leaves, ends = np.zeros(parts, dtype=np.bool_), np.zeros(parts, dtype=np.bool_)
    stays = part[source] == part[target]
    leaves[part[source[~stays]]] = True
    running = graph.markings[:, list(callback.places)].sum(axis=1)[graph.marking_of]
    ends[part[source[stays & (running[source] > running[target])]]] = True
    numbers = np.flatnonzero(among & ~leaves[part])
    _, first = np.unique(part[numbers], return_index=True)
    lasts = [int(numbers[at]) for at in np.sort(first)[:MOST_PARTS]]
    return [(number, bool(ends[part[number]])) for number in lasts]


def _way(graph: TimedGraph, goal: int) -> tuple[int, ...]:
    """Return a shortest firing sequence to a class."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import breadth_first_order

    fires = np.flatnonzero(graph.label != WAITING)
    source, target = graph.source[fires], graph.target[fires]
    size = graph.classes
    matrix = csr_array((np.ones(len(source), dtype=np.int8), (source, target)), shape=(size, size))
    _, before = breadth_first_order(matrix, 0, return_predecessors=True)
    way: list[int] = []
    while goal != 0:
        previous = int(before[goal])
        edge = np.flatnonzero((source == previous) & (target == goal))[0]
        way.append(int(graph.label[fires[edge]]))
        goal = previous
    return tuple(reversed(way))
