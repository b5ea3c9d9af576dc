"""Bounds of callbacks that call one another on the same threads, or go to and fro between threads.

Let a cluster be some nodes, or lanes of them, and let an event be what releases one of its tasks from
outside: a tick, or a message of a publisher elsewhere. The tree of an event is all that follows from it in
the cluster: runs, and messages on their way between them. Let x be an event at r, and t the last moment up to
r at which no tree of an event before t is unfinished. From t until the tree of x is done, a run of some
tree works, or else a message of one is on its way: if a run waits, then a run keeps its lane busy, or runs
keep all threads busy. Each run takes at most its C, and each message its latency. So the trees of the events
in [t, t + L) are done by t + L, for the least L with

    sum over events e of  before_e(L) * (all C and latencies in the tree of e)  <=  L,

and r is before t + L. So each tree is done within L. The sum counts what runs at the same time as if it
came one after another, which is safe. It counts a busy lane once for a chain of callbacks, where the sum of
their response times counts it for each of them. If some runs take no time, events at t + L count, too.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from dineros.analysis.bounds.curves import Curve, added
from dineros.analysis.bounds.lanes import least_window
from dineros.analysis.bounds.tasks import Source, Task


@dataclass(frozen=True)
class _TaskShare:
    """How often a task runs in the tree of an event at most, and when it is released at the earliest."""

    most: int
    earliest: int


class Cluster:
    """Tasks that rest on one another, and the events that release them from outside.

    Parameters
    ----------
    tasks : list of Task
        All tasks of their lanes; the works of all of them are bounded.
    events : dict from Task to Curve
        What releases them from outside.

    Attributes
    ----------
    within : int or None
        So long the tree of an event takes at most, in units of time; None if nothing bounds it.
    """

    def __init__(self, tasks: list[Task], events: dict[Task, Curve]) -> None:
        self._events = events
        self._inside = {task: [each for each in task.sources if each.task in events] for task in tasks}
        self._order = self._sorted()
        self._parts: dict[Task, dict[Task, _TaskShare]] = {}
        self.within = self._bounded()

    @property
    def has_chains(self) -> bool:
        """Whether one of its tasks releases another one, or itself."""
        return any(self._inside.values())

    def arrivals(self, task: Task) -> Curve:
        """Return the curve of the releases of a task."""
        assert self.within is not None
        return added(
            self._events[event].times(part.most).spread(0 if event is task else self.within - part.earliest)
            for event, part in self._parts[task].items()
        )

    def publications(self, source: Source, delay: int) -> Curve:
        """Return the curve of the runs that publish, at the moments at which they do.

        `delay` is that of the task.
        """
        assert self.within is not None
        task, later = source.task, source.task.least if source.only_at_end else 0
        return added(
            self._events[event]
            .times(part.most)
            .spread((delay if event is task else self.within) - part.earliest - later)
            for event, part in self._parts[task].items()
        )

    def _sorted(self) -> list[Task] | None:
        """Return the tasks, each after what releases it; None if messages go round in a circle."""
        order: list[Task] = []
        left = dict(self._inside)
        while left:
            ready = [task for task, sources in left.items() if not any(each.task in left for each in sources)]
            if not ready:
                return None
            order += ready
            for task in ready:
                del left[task]
        return order

    def _bounded(self) -> int | None:
        if self._order is None:
            return None
        for task in self._order:
            self._parts[task] = self._parts_of(task)
        costs = self._costs()
        trees = [(curve, costs[task]) for task, curve in self._events.items() if curve.terms and costs[task]]
        if sum((curve.rate * cost for curve, cost in trees), Fraction(0)) >= 1:
            return None
        if not trees:
            return 0
        if all(task.most for task in self._order):
            first = sum(curve.within(0) * cost for curve, cost in trees)
            return least_window(lambda at: sum(curve.before(at) * cost for curve, cost in trees), first)
        return least_window(lambda at: sum(curve.within(at) * cost for curve, cost in trees))

    def _parts_of(self, task: Task) -> dict[Task, _TaskShare]:
        found = {task: _TaskShare(1, 0)} if self._events[task].terms else {}
        for source in self._inside[task]:
            before = source.task.least if source.only_at_end else 0
            for event, part in self._parts[source.task].items():
                earliest = part.earliest + before + source.latency[0]
                known = found.get(event, _TaskShare(0, earliest))
                found[event] = _TaskShare(known.most + part.most * source.most, min(known.earliest, earliest))
        return found

    def _costs(self) -> dict[Task, int]:
        """Return by task how long all that follows from one release takes, one after another."""
        assert self._order is not None
        costs = {task: task.most for task in self._order}
        for task in reversed(self._order):
            for source in self._inside[task]:
                costs[source.task] += source.most * (source.latency[1] + costs[task])
        return costs
