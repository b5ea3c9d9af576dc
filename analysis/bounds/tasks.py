"""The tasks of a system model, and which threads work on them.

A task is a callback with what releases it: its timer, or one of its reader histories. Tasks that exclude each
other are in one lane: those of a node with one thread, or of an exclusive callback group. Times are counted
in units of their greatest common divisor, so that all arithmetic is exact in whole numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction

from dineros.analysis.bounds.work import NotBoundedError, Work, Works
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.groups import (
    callback_page_of,
    group_or_node,
    has_clients,
    readers_of,
    runs_callbacks,
    threads_of,
)
from dineros.metamodel.elements import channels, label, node_net_of, node_nets, resolve
from dineros.metamodel.matching import are_matched
from dineros.metamodel.times.given import latency_between, period_of
from dineros.metamodel.times.orders import keeps_order
from dineros.metamodel.times.rates import seconds_of


@dataclass(eq=False, repr=False)
class Lane:
    """Tasks of which one at a time runs, or those of one reentrant callback.

    Attributes
    ----------
    node : sym.NodeNet
    tasks : list of Task
    is_exclusive : bool
        Whether one of them at a time runs.
    reason : str
        Why nothing bounds when they run; empty if their works and arrivals do.
    keeps_order : bool
        Whether the rules take the callbacks of the node in an order that is known.
    """

    node: sym.NodeNet
    is_exclusive: bool = True
    tasks: list[Task] = field(default_factory=list)
    reason: str = ""
    keeps_order: bool = False


@dataclass(frozen=True)
class Source:
    """Where messages of a task come from; times in units.

    Attributes
    ----------
    task : Task
        What publishes them.
    writer : sym.PublisherPort
    most : int
        Messages of one run.
    separation : int
        Least time that runs of that callback take; 0 if they may overlap.
    only_at_end : bool
        Whether it publishes only when it ends.
    latency : tuple of int
        Least and greatest time on the way.
    """

    task: Task
    writer: sym.PublisherPort
    most: int
    separation: int
    only_at_end: bool
    latency: tuple[int, int]


@dataclass(eq=False, repr=False)
class Task:
    """A callback, and what releases it; times in units.

    Attributes
    ----------
    page : sym.CallbackPage
    reader : sym.SubscriberPort or None
        The history that releases it; None of a timer.
    lane : Lane
    work : Work or None
        None if nothing bounds what a run does; then `reason` says why.
    reason : str
        Why nothing bounds when it is released, or how long it works.
    least, most : int
        How long a run takes.
    period, jitter : int
        Of a timer.
    sources : list of Source
        Of a subscription.
    """

    page: sym.CallbackPage
    reader: sym.SubscriberPort | None
    lane: Lane
    work: Work | None = None
    reason: str = ""
    least: int = 0
    most: int = 0
    period: int = 0
    jitter: int = 0
    sources: list[Source] = field(default_factory=list)

    @property
    def name(self) -> str:
        """How reports call it."""
        return f"callback {label(self.page)}"


class Tasks:
    """The tasks of a model.

    Parameters
    ----------
    model : sym.SystemModel
        A model of the middleware ``ros2``.

    Attributes
    ----------
    all : list of Task
    unit : Fraction
        Seconds of a unit of time.
    """

    def __init__(self, model: sym.SystemModel) -> None:
        self.model = model
        self.works = Works(model)
        self.all: list[Task] = []
        for node in node_nets(model):
            if runs_callbacks(node):
                self._read_node(node)
        self.unit = _unit(self._times())
        self._scale()
        for task in self.all:
            if task.reader is not None and not task.reason:
                task.reason = self._read_sources(task, task.reader)

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
        reason = _why_not_followed(node, pages)
        lanes: dict[object, Lane] = {}
        is_ordered = keeps_order(node)
        for page in pages:
            group = None if threads_of(node) == 1 else group_or_node(page)
            is_reentrant = (
                isinstance(group, sym.CallbackGroup) and group.kind == sym.CallbackGroupKind.reentrant
            )
            key: object = page if is_reentrant else group
            lane = lanes.setdefault(key, Lane(node, not is_reentrant, reason=reason, keeps_order=is_ordered))
            if page.kind == sym.CallbackKind.timer:
                self._read_task(page, None, lane)
            else:
                for reader in readers_of(page):
                    self._read_task(page, reader, lane)

    def _read_task(self, page: sym.CallbackPage, reader: sym.SubscriberPort | None, lane: Lane) -> None:
        task = Task(page, reader, lane)
        self.all.append(task)
        lane.tasks.append(task)
        if page.kind == sym.CallbackKind.timer and readers_of(page):
            task.reason = f"{task.name} is called by a timer and by messages"
            return
        if page.kind == sym.CallbackKind.timer and period_of(page) is None:
            task.reason = f"the period of {task.name} is not given"
        try:
            message = None if reader is None else resolve(reader.place)
            assert message is None or isinstance(message, pn.Place)
            for each in () if message is None else self.works.around[message]:
                if callback_page_of(each) is not page:
                    raise NotBoundedError(f"transition {label(each)} changes what releases {task.name}")
            task.work = self.works.of(page, message)
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
        for topic in channels(self.model, sym.TopicChannel):
            for writer in topic.publishers:
                for reader in topic.subscribers:
                    latency = latency_between(writer, reader)
                    if latency is not None and latency.latest is not None:
                        yield seconds_of(latency.earliest or 0.0)
                        yield seconds_of(latency.latest)

    def _scale(self) -> None:
        for task in self.all:
            if task.work is not None:
                task.least, task.most = self.units(task.work.least), self.units(task.work.most)
            if (period := period_of(task.page)) is not None:
                task.period = self.units(seconds_of(period))
                task.jitter = self.units(seconds_of(task.page.jitter or 0.0))

    # ------------------------------------------------------------------------------- where messages come from

    def _read_sources(self, task: Task, reader: sym.SubscriberPort) -> str:
        """Fill in the sources of a task; return why nothing bounds when messages come, in words."""
        topic = reader.channel
        if topic is None:
            return f"{task.name} reads no topic"
        for writer in topic.publishers:
            if are_matched(writer, reader) and (reason := self._read_writer(task, writer, reader)):
                return reason
        return ""

    def _read_writer(self, task: Task, writer: sym.PublisherPort, reader: sym.SubscriberPort) -> str:
        topic = f"topic {writer.channel.topic if writer.channel is not None else ''}"
        for port in (writer, reader):
            node = node_net_of(port.place)
            if node is not None and node.lifecycle is not None:
                return f"node {label(node)} of {topic} is managed: it comes and goes"
        latency = latency_between(writer, reader)
        if latency is None or latency.latest is None:
            return f"the latency of {topic} is not given"
        place = resolve(writer.place)
        assert isinstance(place, pn.Place)
        if place.tokens:
            return f"messages of {topic} are there at the start"
        span = self.units(seconds_of(latency.earliest or 0.0)), self.units(seconds_of(latency.latest))
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
            for other in known:
                if other.work is None:
                    return other.reason
                publishes = other.work.publishes.get(place)
                if publishes is not None:
                    separation = other.least if other.lane.is_exclusive else 0
                    source = Source(other, writer, publishes.most, separation, publishes.only_at_end, span)
                    task.sources.append(source)
        return ""


def _why_not_followed(node: sym.NodeNet, pages: list[sym.CallbackPage]) -> str:
    """Return why nothing bounds when a node runs its callbacks, in words; empty if it can be bounded."""
    name = f"node {label(node)}"
    if node.lifecycle is not None:
        return f"{name} is managed: its callbacks run only in some states"
    for page in pages:
        if page.kind not in (sym.CallbackKind.timer, sym.CallbackKind.subscriber):
            return f"{name} has callback {label(page)}, which is called neither by a timer nor by messages"
    if has_clients(node):
        return f"{name} has clients of services or actions"
    return ""


def _unit(times: Iterable[Fraction]) -> Fraction:
    """Return the greatest common divisor of some times."""
    numerators, denominator = [], 1
    found = [each for each in times if each]
    for each in found:
        denominator = math.lcm(denominator, each.denominator)
    numerators = [each.numerator * (denominator // each.denominator) for each in found]
    return Fraction(math.gcd(*numerators) or 1, denominator)
