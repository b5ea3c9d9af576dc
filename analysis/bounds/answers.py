"""Safe bounds of a system model: response times, longest histories, lost ticks, and latencies of chains.

Each bound holds for every run that the model allows. The model is not explored, so bounds can be computed for
systems of any size. A bound need not be attained. Each thread of a node is assumed to have its own processor,
as in all questions with time.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

from dineros.analysis.bounds.engines import Passed
from dineros.analysis.bounds.firing import OpenError
from dineros.analysis.bounds.histories import histories_of_calls
from dineros.analysis.bounds.reading import Tasks
from dineros.analysis.bounds.solving import solve
from dineros.analysis.bounds.tasks import Task, is_of_engine
from dineros.analysis.bounds.work import Publishing
from dineros.analysis.latencies.answers import OF_ENGINES, RELEASED, End, named
from dineros.analysis.latencies.measuring import Bound
from dineros.analysis.latencies.paths import Hop, Path, callback_pages, paths_between, responses_of
from dineros.analysis.latencies.results import Everything, Latency
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.groups import callback_page_of, runs_callbacks
from dineros.metamodel.elements import channels, label, node_net_of, resolve
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.matching import is_best_effort
from dineros.metamodel.times.given import latency_between, period_of, require_known
from dineros.metamodel.times.rates import on_the_way, seconds_of

ASSUMES = "each thread of an executor has a processor of its own, and nothing outside of the model publishes"
"""Assumptions of bounds other than the times of the model, for reports."""


class Bounds:
    """Bounds how long data takes through a system model.

    `model`: a model of the middleware ``ros2``.

    Raises
    ------
    DinerosError
        The model says something of time that no rule obeys.
    """

    def __init__(self, model: sym.SystemModel) -> None:
        require_known(model)
        self._model = model
        self._tasks = Tasks(model)
        self._solved = solve(self._tasks)
        self._engines = self._solved.engines

    def response(self, page: sym.CallbackPage) -> Latency:
        """Return bounds of the response time of a callback: from its release to its end, in seconds."""
        return _worst([self._along(path) for path in responses_of(page)])

    def between(self, first: End, last: End) -> Latency:
        """Return bounds of how long data takes from a callback or topic to another one, on any way.

        Raises
        ------
        DinerosError
            No data goes from one to the other.
        """
        paths = paths_between(self._model, first, last)
        if not paths:
            raise DinerosError(
                f"no data flows from {named(first)} to {named(last)}",
                hint="bounds follow data through topics to the callbacks that take its messages; "
                "requests, responses, goals, results and feedback are not followed",
            )
        found = _worst([self._along(path) for path in paths])
        return self._reacting(paths[0], found) if len(paths) == 1 else found

    def longest(self, reader: sym.SubscriberPort) -> int | None:
        """Return how many messages wait in a history at most, if it is deep enough; None if that is open."""
        if is_of_engine(reader):
            return self._engines.history(reader).longest
        waited = [self._solved.waited.get(task) for task in self._tasks.all if task.reader is reader]
        return waited[0].longest if waited and waited[0] is not None else None

    def never_overflows(self, reader: sym.SubscriberPort) -> bool:
        """Return whether it is proved that a history never overflows."""
        longest = self.longest(reader)
        return longest is not None and longest <= reader.limit

    def never_waits(self, writer: sym.PublisherPort, reader: sym.SubscriberPort) -> bool:
        """Return whether it is proved that messages never wait in a writer history of the net with times.

        They do not if each that can be on its way has a clock: those were published within the latency.
        """
        latency, clocks = latency_between(writer, reader), on_the_way(writer, reader)
        if any(_is_managed(port) for port in (writer, reader)) or latency is None or latency.latest is None:
            return False
        tasks = [task for task in self._tasks.all if task.reader is reader]
        if not clocks or not tasks or tasks[0].reason:
            return False
        published = [self._solved.published[each] for each in tasks[0].sources if each.writer is writer]
        window = self._tasks.units(seconds_of(latency.latest))
        known = [each for each in published if each is not None]
        return len(known) == len(published) and sum(each.within(window) for each in known) <= clocks

    def loses_no_tick(self, page: sym.CallbackPage) -> bool:
        """Return whether it is proved that a timer never strikes while its last tick still waits."""
        if not runs_callbacks(node_net_of(page)):
            return not self._engines.why_late(page)
        task = self._task(page, None)
        waited = None if task is None else self._solved.waited.get(task)
        return task is not None and waited is not None and waited.start < task.period - task.jitter

    def runs_per_second(self, page: sym.CallbackPage) -> Fraction | None:
        """Return how often a callback runs at most, in the long run; None if that is open."""
        curves = [self._solved.curves.get(task) for task in self._tasks.of(page)]
        if not curves or any(curve is None for curve in curves):
            return None
        return sum((curve.rate for curve in curves if curve is not None), Fraction(0)) / self._tasks.unit

    def share_of_thread(self, page: sym.CallbackPage) -> Fraction | None:
        """Return which part of the time of a thread a callback needs at most, in the long run; None: open."""
        found, tasks = Fraction(0), self._tasks.of(page)
        if not tasks:
            return None
        for task in tasks:
            curve = self._solved.curves.get(task)
            if curve is None or task.work is None:
                return None
            found += curve.rate * task.most
        return found

    def everything(self) -> Everything:
        """Return bounds of all response times, and what is proved to be never lost."""
        found = Everything(is_exact=False)
        for page in callback_pages(self._model):
            if page.kind in (RELEASED if runs_callbacks(node_net_of(page)) else OF_ENGINES):
                found.callbacks[page.id] = self.response(page)
                if period_of(page) is not None:
                    found.timers[page.id] = False if self.loses_no_tick(page) else None
                    found.reasons[page.id] = self._why_late(page)
        for topic in channels(self._model, sym.TopicChannel):
            for reader in topic.subscribers:
                longest = self.longest(reader)
                at_most = int(reader.limit) if longest is None else min(longest, int(reader.limit))
                found.readers[reader.place.id] = at_most, False if self.never_overflows(reader) else None
                found.reasons[reader.place.id] = self._why_full(reader)
        for name, (waiting, reason) in histories_of_calls(self._model, self._tasks.all, self._solved).items():
            found.readers[name], found.reasons[name] = waiting, reason
        return found

    # ------------------------------------------------------------------------------------------------- paths

    def _task(self, page: sym.CallbackPage, reader: sym.SubscriberPort | None) -> Task | None:
        found = [task for task in self._tasks.of(page) if task.reader is reader]
        return found[0] if found else None

    def _along(self, path: Path) -> Latency:
        """Return bounds of a path: the sum of those of its callbacks, and of the times on the way."""
        for stored in path.stores:
            reason = f"callback {label(stored.reader)} reads what callback {label(stored.writer)} stores"
            return Latency(Bound(Fraction(0)), None, None, False, reason)
        entering: list[sym.SubscriberPort | None] = [hop.reader for hop in path.topics]
        leaving: list[sym.PublisherPort | None] = [hop.writer for hop in path.topics]
        readers = [*entering] if path.begins_with_message else [path.reader, *entering]
        writers = [*(leaving[1:] if path.begins_with_message else leaving), path.last]
        least, reasons, is_kept = Fraction(0), [], True
        parts: list[Task | Passed] = []
        for page, reader, writer in zip(path.callbacks, readers, writers, strict=True):
            is_kept = is_kept and (reader is None or self.never_overflows(reader))
            if not runs_callbacks(node_net_of(page)):
                try:
                    parts.append(self._engines.through(page, reader, writer))
                    least += parts[-1].least * self._tasks.unit
                except OpenError as error:
                    reasons.append(str(error))
                continue
            task = self._task(page, reader)
            waited = None if task is None else self._solved.waited.get(task)
            if task is None or waited is None:
                reasons.append(self._why(page, task))
            else:
                parts.append(task)
            is_kept = is_kept and waited is not None
            publishing = _publishing(task, writer)
            if task is not None and task.work is not None and (publishing is None or publishing.only_at_end):
                least += task.work.least
        for hop in path.topics:
            latency = latency_between(hop.writer, hop.reader)
            least += Fraction(0) if latency is None else seconds_of(latency.earliest or 0.0)
            if latency is None or latency.latest is None:
                topic = "" if hop.writer.channel is None else hop.writer.channel.topic
                reasons.append(f"the model gives no latency for topic {topic}")
            is_kept = is_kept and not is_best_effort(hop.writer, hop.reader)
        return Latency(
            Bound(least),
            None if reasons else Bound(self._greatest(path, parts)),
            False if is_kept else None,
            False,
            reasons[0] if reasons else "",
        )

    def _greatest(self, path: Path, parts: list[Task | Passed]) -> Fraction:
        """Return the greatest time of a path whose callbacks have bounds, and whose latencies are given."""
        ways = [self._time_of(path, parts, since_strike=False)]
        tasks = [each for each in parts if isinstance(each, Task)]
        if len(tasks) == len(parts) and tasks[0].is_timer and all(each.lane.is_exclusive for each in tasks):
            ways.append(self._time_of(path, parts, since_strike=True))
        return min(ways)

    def _time_of(self, path: Path, parts: list[Task | Passed], since_strike: bool) -> Fraction:
        """Return the sum of response times and latencies; of delays if it counts from the strike of a timer.

        Tasks of a cluster that follow one another count once.
        """
        hops: list[Hop | None] = [*path.topics] if path.begins_with_message else [None, *path.topics]
        total = parts[0].jitter if since_strike and isinstance(parts[0], Task) else 0
        inside, cluster = 0, None
        for task, hop in zip(parts, hops, strict=True):
            on_the_way = 0
            if hop is not None:
                latency = latency_between(hop.writer, hop.reader)
                assert latency is not None and latency.latest is not None
                on_the_way = self._tasks.units(seconds_of(latency.latest))
            if isinstance(task, Passed):
                total += inside + on_the_way
                inside, cluster = task.greatest, None
                continue
            known, curve = self._solved.clusters.get(task), self._solved.curves[task]
            waited = self._solved.waited[task]
            if known is not None and known is cluster:
                assert known.within is not None
                inside = min(known.within, inside + on_the_way + waited.response)
                continue
            has_moments = known is None and curve is not None and curve.one_period is not None
            total += inside + on_the_way
            inside = waited.delay if since_strike and has_moments else waited.response
            cluster = known
        return (total + inside) * self._tasks.unit

    def _reacting(self, path: Path, found: Latency) -> Latency:
        """Return it with the longest reaction time and data age, if they are known.

        An event that happens just after a release is in the data of the next one, which comes a period and
        the jitter later at most; its data comes out within the latency, as none is lost. Until then, an
        output of the release before is the newest one. A run of each callback must publish.
        """
        first = path.callbacks[0]
        if found.greatest is None:
            return found
        if path.reader is not None or path.begins_with_message or first.kind != sym.CallbackKind.timer:
            return replace(found, reasons=_of_both("bounds are known only of chains that begin at a timer"))
        writers = [hop.writer for hop in path.topics] + ([] if path.last is None else [path.last])
        readers = [None, *(hop.reader for hop in path.topics)]
        publishes = all(map(self._must_publish, path.callbacks, readers, writers))
        if reason := self._why_no_reaction(found, publishes, first):
            return replace(found, reasons=_of_both(reason))
        period = seconds_of(first.timer or 0.0) + seconds_of(first.jitter or 0.0)
        longest = Bound(found.greatest.value + period)
        return replace(found, reaction=longest, age=longest)

    def _must_publish(
        self, page: sym.CallbackPage, reader: sym.SubscriberPort | None, writer: sym.PublisherPort
    ) -> bool:
        if not runs_callbacks(node_net_of(page)):
            return self._engines.through(page, reader, writer).is_certain
        known = _publishing(self._task(page, reader), writer)
        return known is not None and known.fewest > 0

    def _why_no_reaction(self, found: Latency, publishes: bool, first: sym.CallbackPage) -> str:
        if found.is_lost is not False:
            return "data on the way may be lost"
        if not publishes:
            return "a callback on the way need not publish"
        return "" if self.loses_no_tick(first) else f"callback {label(first)} may lose ticks"

    def _why_full(self, reader: sym.SubscriberPort) -> str:
        """Return why it is open whether a history overflows."""
        if is_of_engine(reader):
            return self._engines.history(reader).reason
        waited = [task for task in self._tasks.all if task.reader is reader]
        if not waited or waited[0] not in self._solved.waited:
            page = callback_page_of(resolve(reader.place))
            if waited:
                return self._solved.reasons.get(waited[0], "nothing bounds what waits")
            return "it is not read by a callback" if page is None else self._why(page, None)
        longest = self._solved.waited[waited[0]].longest
        return f"bounds allow {longest} waiting messages, and its depth is {int(reader.limit)}"

    def _why_late(self, page: sym.CallbackPage) -> str:
        """Return why it is open whether a timer loses ticks."""
        if not runs_callbacks(node_net_of(page)):
            return self._engines.why_late(page)
        task = self._task(page, None)
        if task is None or task not in self._solved.waited:
            return self._why(page, task)
        late = float(self._solved.waited[task].start * self._tasks.unit)
        return (
            f"bounds allow its callback to begin {late:g} s after a tick, and it ticks every {page.timer:g} s"
        )

    def _why(self, page: sym.CallbackPage, task: Task | None) -> str:
        if task is not None:
            return self._solved.reasons[task]
        return f"callback {label(page)} is not called by a timer, messages or requests"


def _of_both(reason: str) -> dict[str, str]:
    return {"reaction": reason, "age": reason}


def _is_managed(port: sym.TopicPort) -> bool:
    node = node_net_of(port.place)
    return node is not None and node.lifecycle is not None


def _publishing(task: Task | None, writer: sym.PublisherPort | None) -> Publishing | None:
    """Return how a task publishes by a port; None if it does not, or if that is not asked."""
    if task is None or task.work is None or writer is None:
        return None
    place = resolve(writer.place)
    assert isinstance(place, pn.Place)
    return task.work.publishes.get(place)


def _worst(found: list[Latency]) -> Latency:
    """Return bounds that hold for all of several paths."""
    if not found:
        return Latency(None, None, None, False, "nothing releases it")
    least = min((each.least for each in found if each.least is not None), key=lambda each: each.value)
    greatest = [each.greatest for each in found if each.greatest is not None]
    reason = next((each.reason for each in found if each.reason), "")
    return Latency(
        least,
        None if reason else max(greatest, key=lambda each: each.value),
        False if all(each.is_lost is False for each in found) else None,
        False,
        reason,
    )
