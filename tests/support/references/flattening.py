"""A second flattener, written from the table of rules with dictionaries and loops, to compare the rules with.

It shares no code with `dineros.transformations`. Names of nodes are tuples, such as
``("ready", service, client)``, so that two nets are compared by structure and not by ids.
"""

from __future__ import annotations

import itertools
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import TypeAlias

from dineros.metamodel import pn, sym

Name: TypeAlias = Hashable
Changes: TypeAlias = "dict[Name, tuple[bool | str, bool | str]]"


@dataclass
class PlainNet:
    """Places with their tokens, transitions, and arcs (source, target, weight, kind)."""

    places: dict[Name, int] = field(default_factory=dict)
    transitions: set[Name] = field(default_factory=set)
    arcs: list[tuple[Name, Name, int, str]] = field(default_factory=list)
    overrides: set[tuple[Name, Name]] = field(default_factory=set)

    def place(self, name: Name, tokens: int = 0) -> Name:
        assert name not in self.places
        self.places[name] = tokens
        return name

    def transition(self, name: Name) -> Name:
        assert name not in self.transitions
        self.transitions.add(name)
        return name

    def move(self, transition: Name, taken: list[Name], put: list[Name]) -> None:
        """Let a transition take one token from each of some places and put one on each of others."""
        self.arcs += [(place, transition, 1, "normal") for place in taken]
        self.arcs += [(transition, place, 1, "normal") for place in put]


def plain_net_of(net: pn.Net) -> PlainNet:
    """Return a net of one page without references in the plain form."""
    plain = PlainNet()
    (page,) = net.pages
    for node in page.objects:
        if isinstance(node, pn.Place):
            plain.place(node.id, node.tokens)
        else:
            assert isinstance(node, pn.Transition)
            plain.transition(node.id)
            plain.overrides |= {(node.id, lower.id) for lower in node.overrides}
    plain.arcs = [(arc.source.id, arc.target.id, arc.weight, str(arc.kind)) for arc in page.arcs]
    return plain


def reference_flattening(model: sym.SystemModel, signals: str, overflow: str) -> PlainNet:
    """Flatten a system model in a variant of signals and of overflow."""
    return _Flattening(model, signals, overflow).run()


class _Flattening:
    def __init__(self, model: sym.SystemModel, signals: str, overflow: str) -> None:
        self.model = model
        self.signals = signals
        self.overflow = overflow
        self.net = PlainNet()
        self.topics = [channel for channel in model.channels if isinstance(channel, sym.TopicChannel)]
        self.services = [channel for channel in model.channels if isinstance(channel, sym.ServiceChannel)]
        self.prototype: dict[pn.Page, sym.ServiceChannel] = {}
        self.pages: list[pn.Page] = []
        for page in model.pages:
            self._collect(page, None)

    def _collect(self, page: pn.Page, service: sym.ServiceChannel | None) -> None:
        """Note every page, and for pages on a server page (itself included) the service."""
        service = next((channel for channel in self.services if channel.server.page is page), service)
        self.pages.append(page)
        if service is not None:
            self.prototype[page] = service
        for inner in page.objects:
            if isinstance(inner, pn.Page):
                self._collect(inner, service)

    def _copies(self, page: pn.Page | None) -> list[int]:
        """Return the numbers of the copies of a page's contents; 0 is the original of what is not copied."""
        assert page is not None
        if page not in self.prototype:
            return [0]
        service = self.prototype[page]
        return list(range(1, self._instances(service) + 1))

    def _instances(self, service: sym.ServiceChannel) -> int:
        if service.instances is not None:
            return service.instances
        return sum(len(self._copies(client.request.page)) for client in service.clients)

    def _name(self, node: pn.Node | pn.Page, copy: int) -> Name:
        """Return the name of a node seen from a copy: nodes off the server page are shared."""
        while isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition)):
            node = node.target
        assert node.page is not None
        return (node.id, copy if node.page in self.prototype else 0)

    def run(self) -> PlainNet:
        self._take_over()
        for topic in self.topics:
            self._topic(topic)
        for service in self.services:
            self._service(service)
        if self.signals != "none":
            self._signals()
        return self.net

    def _take_over(self) -> None:
        self.clauses: dict[Name, sym.InputClause] = {}
        transitions = []
        for page in self.pages:
            for copy in self._copies(page):
                for node in page.objects:
                    if isinstance(node, pn.Place):
                        self.net.place(self._name(node, copy), node.tokens)
                    elif isinstance(node, pn.Transition):
                        name = self.net.transition(self._name(node, copy))
                        transitions.append((node, copy))
                        if isinstance(node, sym.Transition) and node.clause is not None:
                            self.clauses[name] = node.clause
                for arc in page.arcs:
                    ends = self._name(arc.source, copy), self._name(arc.target, copy)
                    self.net.arcs.append((*ends, arc.weight, str(arc.kind)))
        for higher, copy in transitions:
            for lower in higher.overrides:
                same = self.prototype.get(_page(lower)) is self.prototype.get(_page(higher))
                for other in [copy] if same else self._copies(lower.page):
                    self.net.overrides.add((self._name(higher, copy), self._name(lower, other)))

    def _queue(self, key: Name, source: Name, limit: int, sinks: list[Name]) -> Name:
        """Add an overflow queue and return the transition where tokens leave it."""
        load, capacity = self.net.place((key, "load")), self.net.place((key, "capacity"), limit)
        enter, leave = self.net.transition((key, "in")), self.net.transition((key, "out"))
        drop = self.net.transition((key, "drop"))
        self.net.move(enter, [source, capacity], [load])
        self.net.move(leave, [load], [capacity, *sinks])
        self.net.move(drop, [source], [])
        self._full(drop, load, capacity, limit)
        return leave

    def _full(self, drop: Name, load: Name, capacity: Name, limit: int) -> None:
        """Let a transition fire only while a queue is full."""
        if self.overflow == "inhibitor":
            self.net.arcs.append((capacity, drop, 1, "inhibitor"))
        else:
            self.net.arcs += [(load, drop, limit, "normal"), (drop, load, limit, "normal")]

    def _topic(self, topic: sym.TopicChannel) -> None:
        place = self.net.place(("topic", topic.id))
        transport = self.net.transition(("transport", topic.id))
        self.net.move(transport, [place], [])
        for number, publisher in enumerate(topic.publishers):
            self._publisher(("T2", topic.id, number), publisher, place)
        leave: dict[str, Name] = {}
        limits = {dispatcher.node.id: dispatcher.limit for dispatcher in topic.dispatchers}
        for number, subscriber in enumerate(topic.subscribers):
            node = _node_net(subscriber.place)
            if node not in leave:
                received = self.net.place(("In", topic.id, node))
                self.net.move(transport, [], [received])
                leave[node] = self._queue(("T3", topic.id, node), received, limits.get(node, 16), [])
            received = self.net.place(("In", topic.id, number))
            self.net.move(leave[node], [], [received])
            self._queue(
                ("T4", topic.id, number), received, subscriber.limit, [self._name(subscriber.place, 0)]
            )

    def _publisher(self, key: Name, publisher: sym.PublisherPort, topic: Name) -> None:
        """Add the one queue of a publisher, which every copy of its place writes to."""
        load, capacity = self.net.place((key, "load")), self.net.place((key, "capacity"), publisher.limit)
        self.net.move(self.net.transition((key, "out")), [load], [capacity, topic])
        for copy in self._copies(publisher.place.page):
            source = self._name(publisher.place, copy)
            drop = self.net.transition((key, "drop", copy))
            self.net.move(self.net.transition((key, "in", copy)), [source, capacity], [load])
            self.net.move(drop, [source], [])
            self._full(drop, load, capacity, publisher.limit)

    def _service(self, service: sym.ServiceChannel) -> None:
        key = service.id
        instances = range(1, self._instances(service) + 1)
        for number in instances:
            self.net.place(("active", key, number))
            self.net.place(("inactive", key, number), 1)
        for client in service.clients:
            for copy in self._copies(client.request.page):
                self._client(service, client, copy)

    def _client(self, service: sym.ServiceChannel, client: sym.ClientPort, copy: int) -> None:
        """Add a client, or the copy of it that an instance of the server page has that it stands on."""
        key, own = service.id, (service.id, client.client, copy)
        ready = self.net.place(("ready", own), 1)
        requests, responses = self.net.place(("requests", own)), self.net.place(("responses", own))
        request, response = self._name(client.request, copy), self._name(client.response, copy)
        self.net.move(self.net.transition(("req", own)), [request, ready], [requests])
        self.net.move(self.net.transition(("res", own)), [responses], [response, ready])
        for number in range(1, self._instances(service) + 1):
            active, inactive = ("active", key, number), ("inactive", key, number)
            in_use = self.net.place(("inUse", own, number))
            entry = self._name(service.server.entry, number)
            exit_ = self._name(service.server.exit, number)
            call = self.net.transition(("call", own, number))
            self.net.move(call, [requests, inactive], [entry, active, in_use])
            back = self.net.transition(("return", own, number))
            self.net.move(back, [exit_, active, in_use], [responses, inactive])

    def _signals(self) -> None:
        used: dict[str, sym.InputSignal] = {}
        users: dict[str, list[Name]] = {}
        disjunctions: list[tuple[Name, sym.Disjunction]] = []
        for transition, clause in self.clauses.items():
            for number, disjunction in enumerate(clause.disjunctions):
                true = [literal for literal in disjunction.literals if _starts_true(literal)]
                name = self.net.place(("D", transition, number), len(true))
                disjunctions.append((name, disjunction))
                self.net.arcs.append((name, transition, 1, "read"))
                for literal in disjunction.literals:
                    signal = literal.signal
                    used[signal.id] = signal
                    if transition not in users.setdefault(signal.id, []):
                        users[signal.id].append(transition)
        plain_arcs = [arc for arc in self.net.arcs if not _is_disjunction(arc[0])]
        for id, signal in used.items():
            for setting in _settings(signal):
                self.net.place(("is", id, setting), int(_start(signal) == setting))
            all_changes = [self._changes(signal, "any")] if self.signals == "fully-enabled" else []
            if self.signals in ("input-enabled", "io-enabled"):
                for transition in users[id]:
                    changes = self._changes(signal, ("in", transition))
                    all_changes.append(changes)
                    for source, target, weight, kind in plain_arcs:
                        if target == transition and kind != "inhibitor":
                            self.net.arcs += [(source, change, weight, "read") for change in changes]
            if self.signals == "io-enabled":
                for transition in users[id]:
                    changes = self._changes(signal, ("out", transition))
                    all_changes.append(changes)
                    for source, target, weight, kind in plain_arcs:
                        if source == transition:
                            self.net.arcs += [(target, change, weight, "read") for change in changes]
                        elif target == transition and kind == "read":
                            self.net.arcs += [(source, change, weight, "read") for change in changes]
            for changes in all_changes:
                self._count_literals(id, changes, disjunctions)

    def _changes(self, signal: sym.InputSignal, why: Name) -> Changes:
        """Make the transitions from each setting to each other one."""
        found: Changes = {}
        for before, after in itertools.permutations(_settings(signal), 2):
            change = self.net.transition(("change", signal.id, before, after, why))
            self.net.move(change, [("is", signal.id, before)], [("is", signal.id, after)])
            found[change] = before, after
        return found

    def _count_literals(
        self, id: str, changes: Changes, disjunctions: list[tuple[Name, sym.Disjunction]]
    ) -> None:
        for name, disjunction in disjunctions:
            for literal in disjunction.literals:
                for change, (before, after) in changes.items() if literal.signal.id == id else ():
                    held, holds = _is_true(literal, before), _is_true(literal, after)
                    if holds and not held:
                        self.net.move(change, [], [name])
                    elif held and not holds:
                        self.net.move(change, [name], [])


def _settings(signal: sym.InputSignal) -> list[bool | str]:
    return [str(value.name) for value in signal.values] or [True, False]


def _start(signal: sym.InputSignal) -> bool | str:
    if not signal.values:
        return bool(signal.initial)
    return signal.start or str(signal.values[0].name)


def _is_true(literal: sym.Literal, setting: bool | str) -> bool:
    return (setting == (literal.value or True)) is not literal.negated


def _starts_true(literal: sym.Literal) -> bool:
    return _is_true(literal, _start(literal.signal))


def _is_disjunction(name: Name) -> bool:
    return isinstance(name, tuple) and name[0] == "D"


def _page(node: pn.Node) -> pn.Page:
    assert node.page is not None
    return node.page


def _node_net(node: pn.Node) -> str:
    page = node.page
    while not isinstance(page, sym.NodeNet):
        assert page is not None
        page = page.page
    return page.id
