"""Random runs of a system model, recorded per node, by a simulator that shares nothing with the engines.

It plays the system model itself: token lists, queues as lists of messages, calls as small state machines;
so what it records is a behaviour of the model by construction. The runs are as the recorders write them.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import node_net_of, node_nets, nodes, resolve
from dineros.metamodel.records import (
    Drop,
    Fire,
    Header,
    Publish,
    Record,
    Reply,
    Request,
    Response,
    Serve,
    Signal,
    Start,
    Stop,
    StoredToken,
    Take,
)

Action = Callable[[], None]


@dataclass
class _Transition:
    name: str
    node: str
    inputs: dict[str, int] = field(default_factory=dict)
    outputs: dict[str, int] = field(default_factory=dict)
    inhibitors: dict[str, int] = field(default_factory=dict)
    clause: list[list[tuple[str, bool]]] = field(default_factory=list)


@dataclass
class _Queue:
    limit: int
    arriving: list[str] = field(default_factory=list)
    load: list[str] = field(default_factory=list)


class ReferenceRun:
    """One run; `records` has what each node recorded."""

    def __init__(self, model: sym.SystemModel, seed: int) -> None:
        self.model = model
        self.random = random.Random(seed)
        self.nodes = [node.id for node in node_nets(model)]
        self.records: dict[str, list[Record]] = {node: [] for node in self.nodes}
        self.signals = {
            signal.id: bool(signal.initial) for node in node_nets(model) for signal in node.signals
        }
        self.clock = 1000.0
        self.next_token = dict.fromkeys(self.nodes, 0)
        self.node_of: dict[str, str] = {}
        self.tokens: dict[str, list[int]] = {}
        self.numbers: dict[str, int] = {}
        self.sender_of: dict[str, str] = {}  # place of each copy of a publisher's port -> of the port
        self.transitions: dict[str, _Transition] = {}
        self._load()
        self.topics = [_Topic(self, c) for c in model.channels if isinstance(c, sym.TopicChannel)]
        self.services = [_Service(self, c) for c in model.channels if isinstance(c, sym.ServiceChannel)]
        for node in self.nodes:
            marking = {
                place: [StoredToken(id, {}) for id in ids]
                for place, ids in self.tokens.items()
                if ids and self.node_of[place] == node
            }
            signals = {
                signal.id: bool(signal.initial)
                for net in node_nets(model)
                if net.id == node
                for signal in net.signals
            }
            self.record(node, Header, kind="run", model=model.id)
            self.record(node, Start, marking=marking, signals=signals)

    def _load(self) -> None:
        self.copies: dict[pn.Node, list[str]] = {}
        self.pages = {
            channel.server.page: channel
            for channel in self.model.channels
            if isinstance(channel, sym.ServiceChannel)
        }
        for node in nodes(self.model):
            channel = self.server_of(node)
            self.copies[node] = [node.id]
            if channel is not None:
                self.copies[node] = [f"{prefix}.{node.id}" for prefix in self.prefixes(channel)]
        copies = self.copies
        for original, names in copies.items():
            net = node_net_of(original)
            if net is None or isinstance(original, (pn.ReferencePlace, pn.ReferenceTransition)):
                continue
            for number, name in enumerate(names):
                if isinstance(original, pn.Place):
                    self.node_of[name] = net.id
                    self.tokens[name] = []
                    self._put(name, original.tokens)
                elif isinstance(original, pn.Transition):
                    self.transitions[name] = self._transition(original, name, net.id, number, copies)

    def server_of(self, node: pn.Node) -> sym.ServiceChannel | None:
        """Return the service on whose server page a node stands."""
        page = node.page
        while page is not None and page not in self.pages:
            page = page.page
        return None if page is None else self.pages[page]

    def prefixes(self, channel: sym.ServiceChannel) -> list[str]:
        """Return the names of a service's instances: as many as it declares, else one for each client."""
        count = channel.instances
        if count is None:
            callers = [self.server_of(port.request) for port in channel.clients]
            count = sum(1 if caller is None else len(self.prefixes(caller)) for caller in callers)
        return [f"{channel.id}[{number}]" for number in range(1, count + 1)]

    def _transition(
        self, original: pn.Transition, name: str, node: str, number: int, copies: dict[pn.Node, list[str]]
    ) -> _Transition:
        made = _Transition(name, node)

        def end(place: pn.Node) -> str:
            names = copies[resolve(place)]
            return names[number] if len(names) > number and names[0] != resolve(place).id else names[0]

        for arc in _arcs_of(self.model, original):
            if resolve(arc.target) is original:
                place = end(arc.source)
                if arc.kind == pn.ArcKind.inhibitor:
                    made.inhibitors[place] = min(arc.weight, made.inhibitors.get(place, arc.weight))
                    continue
                made.inputs[place] = made.inputs.get(place, 0) + arc.weight
                if arc.kind == pn.ArcKind.read:
                    made.outputs[place] = made.outputs.get(place, 0) + arc.weight
            else:
                place = end(arc.target)
                made.outputs[place] = made.outputs.get(place, 0) + arc.weight
        clause = getattr(original, "clause", None)
        if clause is not None:
            made.clause = [
                [(literal.signal.id, bool(literal.negated)) for literal in disjunction.literals]
                for disjunction in clause.disjunctions
            ]
        return made

    def _put(self, place: str, count: int = 1) -> list[int]:
        node = self.node_of[place]
        ids = list(range(self.next_token[node], self.next_token[node] + count))
        self.next_token[node] += count
        self.tokens[place].extend(ids)
        return ids

    def record(self, node: str, made: type[Record], /, **fields: object) -> None:
        self.clock += self.random.random()
        self.records[node].append(
            made(sequence=len(self.records[node]), time=self.clock, node=node, **fields)  # type: ignore[arg-type]
        )

    def actions(self) -> list[tuple[Action, float]]:
        """All that can happen now, each with a weight."""
        found: list[tuple[Action, float]] = []
        for transition in self.transitions.values():
            if self._enabled(transition):
                found.append((lambda t=transition: self._fire(t), 1.0))  # type: ignore[misc]
        for signal in self.signals:
            found.append((lambda s=signal: self._flip(s), 0.2))  # type: ignore[misc]
        channels: list[_Topic | _Service] = [*self.topics, *self.services]
        for channel in channels:
            found.extend((action, 1.0) for action in channel.actions())
        return found

    def run(self, steps: int) -> ReferenceRun:
        """Take steps at random."""
        for _ in range(steps):
            found = self.actions()
            if not found:
                break
            actions, weights = zip(*found, strict=True)
            self.random.choices(actions, weights)[0]()
        return self

    def stop(self) -> ReferenceRun:
        """End all nodes in good order."""
        for node in self.nodes:
            self.record(node, Stop, reason="end")
        return self

    def _enabled(self, transition: _Transition) -> bool:
        return (
            all(len(self.tokens[place]) >= weight for place, weight in transition.inputs.items())
            and all(len(self.tokens[place]) < weight for place, weight in transition.inhibitors.items())
            and all(
                any(self.signals[signal] != negated for signal, negated in disjunction)
                for disjunction in transition.clause
            )
        )

    def _fire(self, transition: _Transition) -> None:
        change = {place: -weight for place, weight in transition.inputs.items()}
        taken = {}
        for place, weight in transition.inputs.items():
            taken[place] = self.tokens[place][:weight]
            del self.tokens[place][:weight]
        made = {}
        for place, weight in transition.outputs.items():
            change[place] = change.get(place, 0) + weight
            made[place] = [StoredToken(id, {}) for id in self._put(place, weight)]
        self.record(
            transition.node,
            Fire,
            transition=transition.name,
            change={place: tokens for place, tokens in change.items() if tokens},
            taken=taken,
            made=made,
        )

    def _flip(self, signal: str) -> None:
        node = next(net.id for net in node_nets(self.model) if any(s.id == signal for s in net.signals))
        self.signals[signal] = not self.signals[signal]
        self.record(node, Signal, signal=signal, value=self.signals[signal], source="test")

    def depart(self, place: str, kind: type[Record], message: str | None = None, **fields: object) -> str:
        """Let the oldest token of a place leave; return the message's id."""
        node = self.node_of[place]
        if message is None:
            sender = self.sender_of.get(place, place)
            self.numbers[sender] = self.numbers.get(sender, 0) + 1
            message = f"{node}/{sender}/{self.numbers[sender]}"
        token = self.tokens[place].pop(0)
        self.record(node, kind, place=place, token=token, message=message, change={place: -1}, **fields)
        return message

    def arrive(self, place: str, kind: type[Record], message: str, **fields: object) -> None:
        """Let a message be a token of a place."""
        (token,) = self._put(place)
        self.record(
            self.node_of[place],
            kind,
            place=place,
            token=token,
            message=message,
            change={place: 1},
            **fields,
        )


class _Topic:
    def __init__(self, run: ReferenceRun, channel: sym.TopicChannel) -> None:
        self.run, self.channel = run, channel
        self.publishers: dict[str, _Queue] = {}
        self.leaving: list[_Queue] = []
        for port in channel.publishers:
            queue = _Queue(port.limit)  # one, whichever instance of a server page writes to it
            self.leaving.append(queue)
            self.publishers |= dict.fromkeys(run.copies[port.place], queue)
            run.sender_of |= dict.fromkeys(run.copies[port.place], port.place.id)
        self.subscribers = {port.place.id: _Queue(port.limit) for port in channel.subscribers}
        limits = {dispatcher.node.id: dispatcher.limit for dispatcher in channel.dispatchers}
        receivers = dict.fromkeys(run.node_of[place] for place in self.subscribers)
        self.dispatchers = {node: _Queue(limits.get(node, 16)) for node in receivers}
        self.under_way: list[str] = []

    def actions(self) -> Iterator[Action]:
        run, id = self.run, self.channel.id
        for place, queue in self.publishers.items():
            if run.tokens[place]:
                yield lambda p=place, q=queue: self._publish(p, q)  # type: ignore[misc]
        for queue in self.leaving:
            if queue.load:
                yield lambda q=queue: self.under_way.append(q.load.pop(0))  # type: ignore[misc]
        if self.under_way:
            yield self._deliver
        for node, queue in self.dispatchers.items():
            if queue.arriving:
                yield lambda n=node, q=queue: self._enter(q, n, "dispatcher", None)  # type: ignore[misc]
            if queue.load:
                yield lambda n=node, q=queue: self._dispatch(n, q)  # type: ignore[misc]
        for place, queue in self.subscribers.items():
            if queue.arriving:
                yield lambda p=place, q=queue: self._enter(q, run.node_of[p], "subscriber", p)  # type: ignore[misc]
            if queue.load:
                yield lambda p=place, q=queue: run.arrive(p, Take, q.load.pop(0), channel=id)  # type: ignore[misc]

    def _publish(self, place: str, queue: _Queue) -> None:
        if len(queue.load) < queue.limit:
            queue.load.append(self.run.depart(place, Publish, channel=self.channel.id))
            return
        token = self.run.tokens[place].pop(0)
        self.run.record(
            self.run.node_of[place],
            Drop,
            channel=self.channel.id,
            queue="publisher",
            place=place,
            token=token,
            change={place: -1},
        )

    def _deliver(self) -> None:
        message = self.under_way.pop(0)
        for queue in self.dispatchers.values():
            queue.arriving.append(message)

    def _enter(self, queue: _Queue, node: str, kind: str, place: str | None) -> None:
        message = queue.arriving.pop(0)
        if len(queue.load) < queue.limit:
            queue.load.append(message)
        else:
            self.run.record(node, Drop, channel=self.channel.id, queue=kind, place=place)

    def _dispatch(self, node: str, queue: _Queue) -> None:
        message = queue.load.pop(0)
        for place, subscriber in self.subscribers.items():
            if self.run.node_of[place] == node:
                subscriber.arriving.append(message)


@dataclass(frozen=True)
class _Client:
    name: str
    request: str
    response: str


class _Service:
    def __init__(self, run: ReferenceRun, channel: sym.ServiceChannel) -> None:
        self.run, self.channel = run, channel
        count = len(run.prefixes(channel))
        self.serving: dict[int, str | None] = dict.fromkeys(range(1, count + 1))
        self.message: dict[str, str] = {}
        self.clients: list[_Client] = []
        for port in channel.clients:
            caller = run.server_of(port.request)
            names = [port.client]
            if caller is not None:
                names = [f"{prefix}.{port.client}" for prefix in run.prefixes(caller)]
            ends = zip(names, run.copies[port.request], run.copies[port.response], strict=True)
            self.clients += [_Client(*each) for each in ends]
        self.stage: dict[str, str] = {client.name: "ready" for client in self.clients}

    def actions(self) -> Iterator[Action]:
        run = self.run
        for client in self.clients:
            stage = self.stage[client.name]
            if stage == "ready" and run.tokens[client.request]:
                yield lambda c=client: self._request(c)  # type: ignore[misc]
            elif stage == "requested":
                for instance in [number for number, served in self.serving.items() if served is None]:
                    yield lambda c=client, i=instance: self._serve(c, i)  # type: ignore[misc]
            elif stage == "answered":
                yield lambda c=client: self._respond(c)  # type: ignore[misc]
        for instance, served in self.serving.items():
            if served is not None and run.tokens[self._place(self.channel.server.exit, instance)]:
                yield lambda i=instance: self._reply(i)  # type: ignore[misc]

    def _place(self, place: pn.Place, instance: int) -> str:
        return f"{self.channel.id}[{instance}].{place.id}"

    def _request(self, client: _Client) -> None:
        fields = {"channel": self.channel.id, "client": client.name}
        self.message[client.name] = self.run.depart(client.request, Request, **fields)
        self.stage[client.name] = "requested"

    def _serve(self, client: _Client, instance: int) -> None:
        self.serving[instance] = client.name
        self.stage[client.name] = "served"
        entry = self._place(self.channel.server.entry, instance)
        fields = {"channel": self.channel.id, "instance": instance}
        self.run.arrive(entry, Serve, self.message[client.name], **fields)

    def _reply(self, instance: int) -> None:
        client = self.serving[instance]
        assert client is not None
        self.serving[instance] = None
        self.stage[client] = "answered"
        exit_ = self._place(self.channel.server.exit, instance)
        fields = {"channel": self.channel.id, "instance": instance}
        self.run.depart(exit_, Reply, self.message[client], **fields)

    def _respond(self, client: _Client) -> None:
        self.stage[client.name] = "ready"
        fields = {"channel": self.channel.id, "client": client.name}
        self.run.arrive(client.response, Response, self.message[client.name], **fields)


def _arcs_of(model: sym.SystemModel, transition: pn.Transition) -> Iterator[pn.Arc]:
    from dineros.metamodel.elements import arcs

    for arc in arcs(model):
        if transition in (resolve(arc.source), resolve(arc.target)):
            yield arc
