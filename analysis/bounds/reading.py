"""Reads the tasks of a system model, and which threads work on them.

Times are counted in units of their greatest common divisor, so that all arithmetic is exact in whole numbers.

A callback that waits for responses has no bound, and so has no other one of its lane. But a timer runs at
most once for a tick, however long that takes; so what it publishes and asks for is bounded. Requests are
followed where the client waits for each response and never gives up: then each of its runs has at most as
many under way as it may have outstanding. A request waits for an instance of its server only while the
server's lane works, as an instance is free at once when its run has ended, and each run gives one response.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction

from dineros.analysis.bounds.followed import Requests, clients_of, require_held, slots_of, why_not_followed
from dineros.analysis.bounds.tasks import EngineReader, Lane, Source, Task, is_of_engine
from dineros.analysis.bounds.work import NotBoundedError, Works
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import (
    callback_page_of,
    group_or_node,
    readers_of,
    runs_callbacks,
    threads_of,
)
from dineros.metamodel.elements import channels, label, node_net_of, node_nets, resolve
from dineros.metamodel.matching import are_matched
from dineros.metamodel.times.given import (
    latency_between,
    latency_of_calls,
    period_of,
    reaction_of,
    runs_at_once,
    waits,
)
from dineros.metamodel.times.handlers import handled_until
from dineros.metamodel.times.once import unchanged
from dineros.metamodel.times.orders import keeps_order
from dineros.metamodel.times.paces import paces
from dineros.metamodel.times.rates import seconds_of
from dineros.metamodel.times.results import goals_ended
from dineros.metamodel.times.runs import most_put, only_put_by


class Tasks:
    """The tasks of a model.

    `model`: a model of the middleware ``ros2``.

    Attributes
    ----------
    all : list of Task
    readers : dict from sym.SubscriberPort to EngineReader
        Histories that engines read.
    requests : Requests
        How many requests clients have under way.
    unit : Fraction
        Seconds of a unit of time.
    """

    def __init__(self, model: sym.SystemModel) -> None:
        self.model = model
        self.works = Works(model)
        self.requests = Requests(model)
        self.all: list[Task] = []
        self.readers: dict[sym.SubscriberPort, EngineReader] = {}
        with unchanged():
            self._read()

    def _read(self) -> None:
        for node in node_nets(self.model):
            if runs_callbacks(node):
                self._read_node(node)
        self.unit = _unit(self._times())
        self._scale()
        for task in self.all:
            if task.reader is not None and not task.reason:
                task.reason = self._read_sources(task, task.reader)
            if task.server is not None and not task.reason:
                task.reason = self._read_requests(task, task.server)
        for topic in channels(self.model, sym.TopicChannel):
            for reader in filter(is_of_engine, topic.subscribers):
                heard = self.readers[reader] = EngineReader(reader)
                heard.reason = self._read_sources(heard, reader)

    def of(self, page: sym.CallbackPage) -> list[Task]:
        """Return the tasks of a callback."""
        return [task for task in self.all if task.page is page]

    def units(self, seconds: Fraction) -> int:
        """Return a time in units."""
        found = seconds / self.unit
        assert found.denominator == 1
        return found.numerator

    # ---------------------------------------------------------------------------------- nodes and their lanes

    def _read_node(self, node: sym.NodeNet) -> None:
        pages = [each for each in node.eAllContents() if isinstance(each, sym.CallbackPage)]
        is_managed = node.lifecycle is not None
        reason = f"node {label(node)} is managed: its callbacks run only in some states" if is_managed else ""
        servers = {each.server.page: each.server for each in channels(self.model, sym.ServiceChannel)}
        lanes: dict[object, Lane] = {}
        is_ordered = keeps_order(node)
        for page in pages:
            group = None if threads_of(node) == 1 else group_or_node(page)
            is_exclusive = runs_at_once(page) == 1
            key: object = group if is_exclusive else page
            lane = lanes.setdefault(key, Lane(node, is_exclusive, reason=reason, keeps_order=is_ordered))
            lane.most_at_once = 1 if is_exclusive else slots_of(page)
            lane.reason = lane.reason or why_not_followed(page, is_exclusive, page in servers)
            if page.kind == sym.CallbackKind.subscriber:
                for reader in readers_of(page):
                    self._read_task(Task(page, reader, lane))
            else:
                self._read_task(Task(page, None, lane, server=servers.get(page)))

    def _read_task(self, task: Task) -> None:
        page, lane = task.page, task.lane
        if task.server is not None:
            task.requests = self.requests.all_of(clients_of(task.server))
        self.all.append(task)
        lane.tasks.append(task)
        if page.kind == sym.CallbackKind.timer and readers_of(page):
            task.reason = f"{task.name} is called by a timer and by messages"
            return
        if page.kind == sym.CallbackKind.timer and period_of(page) is None:
            task.reason = f"the period of {task.name} is not given"
        try:
            if page.kind not in (sym.CallbackKind.timer, sym.CallbackKind.subscriber) and task.server is None:
                raise NotBoundedError(lane.reason)
            if task.server is not None:
                require_held(task.server)
            message = _message_of(task)
            for each in () if message is None else self.works.around[message]:
                if callback_page_of(each) is not page:
                    raise NotBoundedError(
                        f"transition {label(each)} changes the tokens that release {task.name}"
                    )
            work = self.works.of(page, message)
            if task.server is not None:
                answers = work.publishes.get(_place(task.server.exit))
                if answers is None or (answers.fewest, answers.most) != (1, 1):
                    raise NotBoundedError(f"{task.name} does not give one response to each request")
                task.is_held = answers.only_at_end
            task.work = work
        except NotBoundedError as error:
            task.reason = str(error)

    # -------------------------------------------------------------------------------------------------- times

    def _times(self) -> Iterable[Fraction]:
        for task in self.all:
            if task.work is not None:
                yield task.work.least
                yield task.work.most
            if (period := period_of(task.page)) is not None:
                yield seconds_of(period)
            if task.page.jitter:
                yield seconds_of(task.page.jitter)
        for node in node_nets(self.model):
            if not runs_callbacks(node):
                yield from _times_of_engine(node)
        for topic in channels(self.model, sym.TopicChannel):
            for writer in topic.publishers:
                for reader in topic.subscribers:
                    yield from _bounds_of(latency_between(writer, reader))
                place = _place(writer.place)
                for page in only_put_by(place) or ():
                    yield from (each.separation for each in paces(page, place) or ())
        for service in channels(self.model, sym.ServiceChannel):
            for client in service.clients:
                yield from _bounds_of(latency_of_calls(client))

    def _scale(self) -> None:
        for task in self.all:
            if task.work is not None:
                task.least, task.most = self.units(task.work.least), self.units(task.work.most)
            if (period := period_of(task.page)) is not None:
                task.period = self.units(seconds_of(period))
                task.jitter = self.units(seconds_of(task.page.jitter or 0.0))

    # ------------------------------------------------------------------------------- where messages come from

    def _read_sources(self, task: Task | EngineReader, reader: sym.SubscriberPort) -> str:
        """Fill in the sources of a task; return why nothing bounds when messages come, in words."""
        topic = reader.channel
        if topic is None:
            return f"{task.name} reads no topic"
        for writer in topic.publishers:
            if are_matched(writer, reader) and (reason := self._read_writer(task, writer, reader)):
                return reason
        return ""

    def _read_writer(
        self, task: Task | EngineReader, writer: sym.PublisherPort, reader: sym.SubscriberPort
    ) -> str:
        topic = f"topic {writer.channel.topic if writer.channel is not None else ''}"
        for port in (writer, reader):
            node = node_net_of(port.place)
            if node is not None and node.lifecycle is not None:
                return f"node {label(node)} of {topic} is managed: it can be stopped and started"
        return self._read_port(task, writer, writer.place, topic, latency_between(writer, reader))

    def _read_requests(self, task: Task, server: sym.ServerPort) -> str:
        """Fill in where requests come from; return why nothing bounds when they come, in words."""
        for client in clients_of(server):
            service = f"service {'' if server.channel is None else server.channel.service}"
            latency = latency_of_calls(client)
            if reason := self._read_port(task, client, client.request, service, latency):
                return reason
        return ""

    def _read_port(
        self,
        task: Task | EngineReader,
        writer: sym.PublisherPort | sym.ClientPort,
        port: pn.Place,
        topic: str,
        latency: pn.TimeInterval | None,
    ) -> str:
        """Fill in what puts tokens on the place of a port."""
        if latency is None or latency.latest is None:
            return f"the model gives no latency for {topic}"
        place = _place(port)
        if place.tokens:
            return f"{topic} has messages at the start"
        span = self.units(seconds_of(latency.earliest or 0.0)), self.units(seconds_of(latency.latest))
        if isinstance(writer, sym.PublisherPort) and is_of_engine(writer):
            task.engines.append((writer, span))
            return ""
        publishing = set()
        for transition in self.works.around[place]:
            move = self.works.moves[transition]
            if move.takes[place]:
                return f"transition {label(transition)} takes messages of {topic}"
            if move.puts[place]:
                publishing.add(callback_page_of(transition))
                if callback_page_of(transition) is None:
                    node = node_net_of(transition)
                    where = "" if node is None else f", which node {label(node)} publishes at any time"
                    return f"nothing bounds how often {topic} is published{where}"
        for page in sorted((each for each in publishing if each is not None), key=lambda each: str(each.id)):
            known = self.of(page)
            if not known:
                return f"nothing bounds how often {topic} is published: by callback {label(page)}"
            if isinstance(writer, sym.ClientPort) and place not in Body(page).requests:
                return f"callback {label(page)} does not wait for the response of {topic}"
            for other in known:
                if other.work is None:
                    most = most_put(page, place) if _runs_once_a_tick(other) else None
                    if most is not None:
                        task.sources.append(Source(other, writer, most, 0, False, span))
                        continue
                    steps = paces(page, place)
                    if steps is None:
                        called = self._called_by_goals(other, writer, place, span)
                        if called is None:
                            return other.reason
                        task.sources.append(called)
                        break
                    moments = tuple((each.tokens, self.units(each.separation)) for each in steps)
                    task.sources.append(Source(other, writer, 1, 0, False, span, moments))
                    break  # of all tasks of the callback
                publishes = other.work.publishes.get(place)
                if publishes is not None:
                    separation = other.least if other.lane.is_exclusive else 0
                    source = Source(other, writer, publishes.most, separation, publishes.only_at_end, span)
                    task.sources.append(source)
        return ""

    def _called_by_goals(
        self,
        task: Task,
        writer: sym.PublisherPort | sym.ClientPort,
        place: pn.Place,
        span: tuple[int, int],
    ) -> Source | None:
        """Return what a callback publishes for the ends of goals; None if nothing bounds its runs."""
        ended, most = goals_ended(task.page), most_put(task.page, place)
        if ended is None or most is None:
            return None
        sent: list[Source] = []
        under_way = runs_at_once(task.page)
        for goals in ended:
            pages = None if goals.goal.tokens else only_put_by(goals.goal)
            if pages is None:
                return None
            under_way += goals.times * goals.under_way
            for page in pages:
                number = most_put(page, goals.goal)
                senders = self.of(page)
                if number is None or len(senders) != 1 or not _runs_for_each_tick(senders[0]):
                    return None
                if number:
                    sent.append(Source(senders[0], goals.client, number * goals.times, 0, False, (0, 0)))
        return Source(task, writer, most, 0, False, span, goals=tuple(sent), under_way=under_way)


def _runs_for_each_tick(task: Task) -> bool:
    """Return whether a callback, however long it takes, runs once for a tick, and not twice at a time."""
    page = task.page
    is_plain = task.is_timer and not page.awaits and not readers_of(page)
    return is_plain and task.lane.is_exclusive and task.period > 0


def _runs_once_a_tick(task: Task) -> bool:
    """Return whether that holds for a callback that waits."""
    return waits(task.page) and _runs_for_each_tick(task)


def _message_of(task: Task) -> pn.Place | None:
    """Return the place whose tokens release a task; None for a timer."""
    if task.server is not None:
        return _place(task.server.entry)
    return None if task.reader is None else _place(task.reader.place)


def _place(place: pn.Place) -> pn.Place:
    found = resolve(place)
    assert isinstance(found, pn.Place)
    return found


def _bounds_of(interval: pn.TimeInterval | None) -> Iterable[Fraction]:
    if interval is not None and interval.latest is not None:
        yield seconds_of(interval.earliest or 0.0)
        yield seconds_of(interval.latest)


def _times_of_engine(node: sym.NodeNet) -> Iterable[Fraction]:
    if (reaction := reaction_of(node)) is not None:
        yield seconds_of(reaction.earliest or 0.0)
        yield seconds_of(reaction.latest or 0.0)
    for each in node.eAllContents():
        if isinstance(each, pn.Transition):
            if each.interval is not None:
                yield seconds_of(each.interval.earliest or 0.0)
                yield seconds_of(each.interval.latest or 0.0)
            if (until := handled_until(node, each)) is not None:
                yield seconds_of(until)
        elif isinstance(each, sym.CallbackPage):
            if (period := period_of(each)) is not None:
                yield seconds_of(period)
            yield seconds_of(each.jitter or 0.0)


def _unit(times: Iterable[Fraction]) -> Fraction:
    """Return the greatest common divisor of some times."""
    numerators, denominator = [], 1
    found = [each for each in times if each]
    for each in found:
        denominator = math.lcm(denominator, each.denominator)
    numerators = [each.numerator * (denominator // each.denominator) for each in found]
    return Fraction(math.gcd(*numerators) or 1, denominator)
