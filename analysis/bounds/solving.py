"""Response times of all tasks at once: each rests on when messages come, and so on those of what publishes.

The bounds are the least ones that fit together. They hold by induction over time. Let v be the first moment
at which an instance has waited or run longer than its bound. Everything that was published up to v was
published within the bounds, so that all arrivals up to v obey the curves that follow from them, and the
arguments of `dineros.analysis.bounds.lanes` hold up to v: that instance has ended by then. (This is the
reason why holistic analysis and compositional performance analysis are sound.)

A message is published not earlier than its run can be done, if it is published only then, and not later than
the `delay` of its run after the latest moment at which this can be released. So releases become publications
with that spread, and these become arrivals with that of the latency. Of a timer, one tick waits at most, and
one run is under way on each thread that it may have; so its runs in a window are at most these and one for
each strike in it. If messages go round in a circle, arrivals would rest on themselves. Then, and where
nothing bounds a response time, only the least duration of the runs bounds how often a callback publishes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import networkx as nx

from dineros.analysis.bounds.clusters import Cluster
from dineros.analysis.bounds.curves import Curve, added
from dineros.analysis.bounds.engines import Engines
from dineros.analysis.bounds.firing import OpenError
from dineros.analysis.bounds.lanes import Around, Waited, are_alone, waited
from dineros.analysis.bounds.reading import Tasks
from dineros.analysis.bounds.tasks import Engine, EngineReader, Lane, Source, Task
from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import threads_of
from dineros.metamodel.elements import label

MOST_ROUNDS = 400
"""Rounds towards bounds that fit together."""
MOST_TIMES = 100_000
"""A bound that exceeds the sum of all times by more than this factor counts as no bound."""


@dataclass
class Solved:
    """Bounds of all tasks."""

    engines: Engines
    """What rests on these bounds in nodes of the execution `net`."""
    waited: dict[Task, Waited] = field(default_factory=dict)
    """Of the tasks that have bounds."""
    reasons: dict[Task, str] = field(default_factory=dict)
    """Of the others, why they have none."""
    clusters: dict[Task, Cluster] = field(default_factory=dict)
    """Of those that rest on one another; all that follows from an event there is done within its bound."""
    curves: dict[Task, Curve | None] = field(default_factory=dict)
    """Their releases; None if nothing bounds them."""
    published: dict[Source, Curve | None] = field(default_factory=dict)
    """When messages are published; None if nothing bounds that."""


def solve(tasks: Tasks) -> Solved:
    """Return the least bounds that fit together."""
    return _Solver(tasks).solved()


def _depending(lanes: list[Lane]) -> list[list[Task]]:
    """Return which tasks of a node rest on one another: those of a lane, or all if they share threads."""
    return [lane.tasks for lane in lanes] if are_alone(lanes) else [[t for lane in lanes for t in lane.tasks]]


class _Solver:
    def __init__(self, tasks: Tasks) -> None:
        self.tasks = tasks
        self.nodes: dict[sym.NodeNet, list[Lane]] = {}
        for task in tasks.all:
            lanes = self.nodes.setdefault(task.lane.node, [])
            if task.lane not in lanes:
                lanes.append(task.lane)
        self.engines = Engines(tasks, self._published, self._why_not)
        self.found = Solved(self.engines)
        self.curves = self.found.curves
        self.responses: dict[Task, int | None] = dict.fromkeys(tasks.all, 0)
        self.around = Around(self.curves, self.responses, self.nodes)
        self.graph = self._arrivals()
        self.circles: dict[Task | EngineReader, int] = {
            each: number
            for number, part in enumerate(nx.strongly_connected_components(self.graph))
            for each in part
        }
        self.most = MOST_TIMES * sum(
            task.most
            + task.period
            + task.jitter
            + sum(source.latency[1] for source in task.sources)
            + sum(latency[1] for _, latency in task.engines)
            for task in tasks.all
        )

    def solved(self) -> Solved:
        """Solve part by part, each after what it rests on."""
        graph = self.graph.copy()
        for lanes in self.nodes.values():
            for together in _depending(lanes):
                nx.add_cycle(graph, together)
        for part in reversed(list(nx.topological_sort(condensed := nx.condensation(graph)))):
            members = [each for each in condensed.nodes[part]["members"] if isinstance(each, Task)]
            self._solve(sorted(members, key=self.tasks.all.index))
        for task in self.tasks.all:
            for source in task.sources:
                runs = self._runs(source, self.circles[task] == self.circles[source.task])
                self.found.published[source] = None if runs is None else runs.times(source.most)
        self.engines.forget()
        return self.found

    def _arrivals(self) -> nx.DiGraph[Task | EngineReader]:
        """Return the graph from each task to what publishes its messages, also through engines."""
        graph: nx.DiGraph[Task | EngineReader] = nx.DiGraph()
        graph.add_nodes_from(self.tasks.all)
        readers: list[Task | EngineReader] = [*self.tasks.all, *self.tasks.readers.values()]
        for task in readers:
            for writer, _ in task.engines:
                behind = sorted(self.engines.behind(writer), key=lambda each: str(each.place.id))
                graph.add_edges_from((task, self.tasks.readers[each]) for each in behind)
            for source in task.sources:
                if source.paces is None:
                    causes = [each.task for each in source.goals] or [source.task]
                    graph.add_edges_from((task, cause) for cause in causes)
        return graph

    def _solve(self, part: list[Task]) -> None:
        """Find the bounds of tasks that rest on one another; the others that they rest on have theirs."""
        for task in part:
            if task.lane.reason:
                self._leave(task, task.lane.reason)
        if (cluster := self._cluster(part)) is not None and cluster.within is not None:
            self._solve_cluster(part, cluster, cluster.within)
            return
        # Bounds by wait results always exist; so the others are given up first.
        for given_up in ([task for task in part if not task.lane.keeps_order], part):
            for _ in range(MOST_ROUNDS):
                if not self._round(part):
                    return
            for task in given_up:
                self._leave(task, self._why(task))

    def _cluster(self, part: list[Task]) -> Cluster | None:
        """Return tasks that rest on one another as a cluster; None if they do not, or if not all is known."""
        events = {}
        for task in part:
            if task.reason or task.work is None or task in self.found.reasons:
                return None
            outside = [each for each in task.sources if each.task not in part]
            arrivals = [self._published(task, source) for source in outside]
            arrivals += [self._of_engine(task, each) for each in task.engines]
            known = [each for each in arrivals if each is not None]
            if len(known) < len(arrivals) or self._is_fed_by(part, task):
                return None
            events[task] = Curve(((1, task.period, task.jitter),)) if task.is_timer else added(known)
        cluster = Cluster(part, events)
        return cluster if cluster.has_chains else None

    def _solve_cluster(self, part: list[Task], cluster: Cluster, within: int) -> None:
        for task in part:
            self.curves[task] = cluster.arrivals(task)
            self.responses[task] = within
        for task in part:
            start, curve = within - task.least, self.around.curve(task)
            bound = Waited(start, within, curve.within(start), within)
            in_lane = waited(task, self.around)
            self.found.waited[task] = bound if in_lane is None else bound.least(in_lane)
            self.found.clusters[task] = cluster
        for task in part:
            self.responses[task] = self.found.waited[task].response

    def _round(self, part: list[Task]) -> bool:
        """Compute all bounds from the last ones; return whether one has changed."""
        self.engines.forget()
        for task in part:
            self.curves[task] = self._curve(task)
        has_changed = False
        for task in part:
            if task in self.found.reasons:
                continue
            bound = waited(task, self.around)
            before = self.found.waited.get(task)
            if bound is None or bound.response > self.most:
                self._leave(task, self._why(task))
                has_changed = True
            elif bound != before:
                self.found.waited[task] = bound
                self.responses[task] = bound.response
                has_changed = True
        return has_changed

    def _leave(self, task: Task, reason: str) -> None:
        self.found.waited.pop(task, None)
        self.found.reasons.setdefault(task, reason)
        self.responses[task] = None

    def _why(self, task: Task) -> str:
        """Return why a task has no bound, in words."""
        if task.reason:
            return task.reason
        lanes = self.nodes[task.lane.node]
        (together,) = [some for some in _depending(lanes) if task in some]
        for each in together:
            reason = each.reason or (self._why_unknown(each) if self.curves[each] is None else "")
            if reason:
                return reason if each is task else f"{reason} ({each.name} can run before {task.name})"
        return f"the callbacks of node {label(task.lane.node)} need more time than its threads have"

    def _why_not(self, source: Source) -> str:
        """Return why nothing bounds when messages of a source come."""
        circle = f"messages flow in a circle, and {source.task.name} has no least duration"
        return self.found.reasons.get(source.task) or circle

    def _why_engine(self, engine: Engine) -> str:
        """Return why nothing bounds when an engine publishes; empty if that is bounded."""
        try:
            self.engines.published(engine[0])
        except OpenError as error:
            return str(error)
        return ""

    def _of_engine(self, task: Task, engine: Engine) -> Curve | None:
        """Return the curve of messages that arrive from an engine; None if nothing bounds it."""
        writer, (least, most) = engine
        try:
            return self.engines.published(writer).spread(most - least)
        except OpenError:
            return None

    def _is_fed_by(self, part: list[Task], task: Task) -> bool:
        """Return whether an engine publishes to a task what follows from tasks of a part."""
        behind = [each for writer, _ in task.engines for each in self.engines.behind(writer)]
        readers = [self.tasks.readers[each] for each in behind]
        return any(nx.has_path(self.graph, reader, each) for reader in readers for each in part)

    def _why_unknown(self, task: Task) -> str:
        for source in task.sources:
            if self._published(task, source) is None:
                return self._why_not(source)
        return next((why for each in task.engines if (why := self._why_engine(each))), "")

    def _curve(self, task: Task) -> Curve | None:
        if task.is_timer:
            return Curve(((1, task.period, task.jitter),)) if task.period else None
        if task.reason:
            return None
        published = [self._published(task, source) for source in task.sources]
        published += [self._of_engine(task, each) for each in task.engines]
        return added(each for each in published if each is not None) if None not in published else None

    def _published(self, task: Task | EngineReader, source: Source) -> Curve | None:
        """Return the curve of messages that arrive from a source; None if nothing bounds it."""
        runs = self._runs(source, self.circles[task] == self.circles[source.task])
        least, most = source.latency
        return None if runs is None else runs.times(source.most).spread(most - least)

    def _runs_for_goals(self, source: Source, is_in_circle: bool) -> Curve | None:
        """Return the curve of runs for the ends of goals: those under way, and those that are sent."""
        sent = []
        for each in source.goals:
            runs = self._runs(each, is_in_circle)
            if runs is None:
                return None
            sent.append(runs.times(each.most))
        terms = added(sent).terms
        if not terms:
            return None
        (count, period, spread), *others = terms
        earlier = -(-source.under_way // count) * period  # so wide a spread holds all that were sent before
        return Curve(((count, period, spread + earlier), *others), has_moments=False)

    def _runs(self, source: Source, is_in_circle: bool) -> Curve | None:
        """Return the curve of runs that publish; with paces of steps, of what these publish."""
        if source.paces is not None:
            return Curve(tuple((count, least, 0) for count, least in source.paces), has_moments=False)
        if source.goals:
            return self._runs_for_goals(source, is_in_circle)
        task = source.task
        if task in self.found.clusters and not task.is_timer:
            return self.found.clusters[task].publications(source, self.found.waited[task].delay)
        released = self.curves.get(task)
        if released is not None and not is_in_circle:
            spread = None
            if task not in self.found.reasons:
                known = self.found.waited.get(task)
                delay = 0 if known is None else known.delay
                spread = delay - (task.least if source.only_at_end else 0)
            if task.is_timer:
                at_once = 1 if task.lane.is_exclusive else threads_of(task.lane.node)
                under_way = (1 + at_once) * task.period
                if spread is None or spread > under_way:
                    return Curve(released.spread(under_way).terms, has_moments=False)
            if spread is not None:
                return released.spread(max(0, spread))
        if source.separation:
            spread = 0 if source.only_at_end else source.separation
            return Curve(((1, source.separation, spread),), has_moments=False)
        return None
