"""A second reading of system models under the rules of ROS 2: an interpreter that makes no net.

It plays the model itself: places with tokens, a history for each writer and reader, calls as small state
machines, signals as truth values. It shares no code with `dineros.transformations` or `dineros.analysis`.
Events are named as the documentation names the transitions of a flattened net.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.under_way import goal_counts
from tests.support.references.actions import ActionPlayer
from tests.support.references.calls import ServicePlayer
from tests.support.references.waiting import UNLIMITED, outstanding_of

State: TypeAlias = tuple[int, ...]
Effect: TypeAlias = Mapping[int, int]
Guard: TypeAlias = Callable[[State], bool]


class TooManyStatesError(Exception):
    """There are more states than asked for."""


@dataclass(frozen=True)
class Event:
    """Something that can happen: what it needs, and what it changes (by slot of the state)."""

    name: str
    guard: Guard
    effect: Effect


@dataclass
class _Use:
    """What a transition needs and does, by slot of places."""

    needs: dict[int, int] = field(default_factory=dict)
    below: dict[int, int] = field(default_factory=dict)
    gives: dict[int, int] = field(default_factory=dict)
    tested: dict[int, int] = field(default_factory=dict)
    """What read arcs need, which `needs` counts as well."""

    def effect(self) -> dict[int, int]:
        change = dict(self.gives)
        for slot, tokens in self.needs.items():
            change[slot] = change.get(slot, 0) - tokens + self.tested.get(slot, 0)
        return {slot: tokens for slot, tokens in change.items() if tokens}


def quality_of(port: sym.TopicPort) -> sym.QualityOfService:
    """Return the quality of service of a port: its own, or its topic's, or the usual one."""
    channel = port.channel  # type: ignore[attr-defined]
    return port.qos or channel.qos or sym.QualityOfService()


def are_matched(writer: sym.PublisherPort, reader: sym.SubscriberPort) -> bool:
    """Tell whether what a writer offers is what a reader requests (DDS 1.4, Sect. 2.2.3)."""
    offered, requested = quality_of(writer), quality_of(reader)
    forever = float("inf")
    return not (
        (str(offered.reliability), str(requested.reliability)) == ("bestEffort", "reliable")
        or (str(offered.durability), str(requested.durability)) == ("volatile", "transientLocal")
        or (str(offered.liveliness), str(requested.liveliness)) == ("automatic", "manualByTopic")
        or _or(offered.deadline, forever) > _or(requested.deadline, forever)
        or _or(offered.leaseDuration, forever) > _or(requested.leaseDuration, forever)
    )


def _or(value: float | None, default: float) -> float:
    return default if value is None else value


class Interpreter:
    """The behaviour of a system model under ROS 2; `events` are all that can ever happen."""

    def __init__(self, model: sym.SystemModel, signals: str = "none") -> None:
        self.start_values: list[int] = []
        self.events: list[Event] = []
        self.bounds: dict[int, int] = {}
        """Slots that hold no more than so many."""
        self.moving_bounds: dict[int, Callable[[State], int]] = {}
        """Slots that hold no more than a number that depends on the state."""
        self.outstanding = outstanding_of(model)
        """How many requests each client has under way at most."""
        self.goals = goal_counts(model)
        """How many goals each client has under way at most."""
        self.under_way: dict[tuple[sym.ClientPort, int], list[int]] = {}
        """Slots of what a client has asked, of each copy of it."""
        self._slots: dict[object, int] = {}
        self._variant = signals
        self._services = [c for c in model.channels if isinstance(c, sym.ServiceChannel)]
        self._topics = [c for c in model.channels if isinstance(c, sym.TopicChannel)]
        self._actions = [c for c in model.channels if isinstance(c, sym.ActionChannel)]
        self._home: dict[pn.Page, sym.ServiceChannel | sym.ActionChannel] = {}
        self._pages: list[pn.Page] = []
        for page in model.pages:
            self._collect(page, None)
        self._uses: dict[str, _Use] = {}
        self._clauses: dict[str, sym.InputClause] = {}
        self._requests: set[int] = set()
        self._places()
        self._transitions()
        for service in self._services:
            ServicePlayer(self, service)
        goals = [ActionPlayer(self, action) for action in self._actions]
        self._signals()
        for topic in self._topics:
            self._topic(topic)
        for name, use in self._uses.items():
            self._happens(name, self._guard(name, use), use.effect())
        for topic in self._topics:
            self._bound_ports(topic)
        for client, copy in self.under_way:
            self._bound_requests(client, copy)
        for players in goals:
            players.finish()

    # ------------------------------------------------------------------------------------- state

    @property
    def start(self) -> State:
        return tuple(self.start_values)

    def _slot(self, key: object, value: int = 0) -> int:
        assert key not in self._slots, key
        self._slots[key] = len(self.start_values)
        self.start_values.append(value)
        return self._slots[key]

    def _happens(self, name: str, guard: Guard, effect: Effect) -> None:
        self.events.append(Event(name, guard, effect))

    def successors(self, state: State) -> Iterator[tuple[str, State]]:
        """Yield what can happen, and what is then."""
        for event in self.events:
            if not event.guard(state):
                continue
            after = list(state)
            for slot, tokens in event.effect.items():
                after[slot] += tokens
            if all(
                after[slot] <= self.bounds[slot]
                for slot, tokens in event.effect.items()
                if tokens > 0 and slot in self.bounds
            ) and all(
                after[slot] <= self.moving_bounds[slot](state)
                for slot, tokens in event.effect.items()
                if tokens > 0 and slot in self.moving_bounds
            ):
                yield event.name, tuple(after)

    def count(self, limit: int = 1_000_000) -> tuple[int, int, int]:
        """Return the numbers of states, of steps, and of states without any step."""
        seen, queue, steps, dead = {self.start}, deque([self.start]), 0, 0
        while queue:
            before = steps
            for _, after in self.successors(queue.popleft()):
                steps += 1
                if after not in seen:
                    seen.add(after)
                    queue.append(after)
                    if len(seen) > limit:
                        raise TooManyStatesError
            dead += steps == before
        return len(seen), steps, dead

    # ------------------------------------------------------------------------------------- pages

    def _collect(self, page: pn.Page, service: sym.ServiceChannel | sym.ActionChannel | None) -> None:
        served: list[sym.ServiceChannel | sym.ActionChannel] = [*self._services, *self._actions]
        service = next((each for each in served if each.server.page is page), service)
        self._pages.append(page)
        if service is not None:
            self._home[page] = service
        for inner in page.objects:
            if isinstance(inner, pn.Page):
                self._collect(inner, service)

    def _instances(self, service: sym.ServiceChannel | sym.ActionChannel) -> int:
        if service.instances is not None:
            return service.instances
        if isinstance(service, sym.ActionChannel):
            return self._slots_of(service)
        return sum(len(self._copies(client.request)) for client in service.clients)

    def _slots_of(self, action: sym.ActionChannel) -> int:
        """One for each client; where one does not wait, also for each thread, or two where work awaits."""
        clients, page = len(action.clients), action.server.page
        assert isinstance(page.page, sym.NodeNet)
        node = page.page
        if UNLIMITED not in {self.goals[client] for client in action.clients}:
            return clients
        if str(node.execution) != "callbacks":
            return clients
        threads = node.threads if str(node.executor) == "multi" else 1
        return max(clients, 2 if page.awaits else min(threads, 3))  # type: ignore[attr-defined]

    def _copies(self, node: pn.Node) -> list[int]:
        """Return the instances that have a copy of a node; 0 stands for what is there once."""
        assert node.page is not None
        if node.page not in self._home:
            return [0]
        return list(range(1, self._instances(self._home[node.page]) + 1))

    def _name(self, node: pn.Node, copy: int) -> str:
        while isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition)):
            node = node.target
        assert node.page is not None
        service = self._home.get(node.page)
        return str(node.id) if service is None else f"{service.id}[{copy}].{node.id}"

    def _place(self, node: pn.Node, copy: int) -> int:
        return self._slots[self._name(node, copy)]

    # ------------------------------------------------------------------------------- node nets

    def _places(self) -> None:
        for page in self._pages:
            for node in page.objects:
                if isinstance(node, pn.Place):
                    for copy in self._copies(node):
                        slot = self._slot(self._name(node, copy), node.tokens)
                        if node.capacity is not None:
                            self.bounds[slot] = node.capacity

    def _transitions(self) -> None:
        for page in self._pages:
            for node in page.objects:
                if isinstance(node, pn.Transition):
                    for copy in self._copies(node):
                        self._uses[self._name(node, copy)] = _Use()
                        if isinstance(node, sym.Transition) and node.clause is not None:
                            self._clauses[self._name(node, copy)] = node.clause
        for page in self._pages:
            for arc in page.arcs:
                for copy in self._copies(arc.source):
                    self._arc(arc, copy)

    def _arc(self, arc: pn.Arc, copy: int) -> None:
        source, target = self._name(arc.source, copy), self._name(arc.target, copy)
        if source not in self._slots:
            gives = self._uses[source].gives
            gives[self._slots[target]] = gives.get(self._slots[target], 0) + arc.weight
            return
        use, slot = self._uses[target], self._slots[source]
        if str(arc.kind) == "inhibitor":
            use.below[slot] = min(arc.weight, use.below.get(slot, arc.weight))
            return
        use.needs[slot] = use.needs.get(slot, 0) + arc.weight
        if str(arc.kind) == "read":
            use.tested[slot] = use.tested.get(slot, 0) + arc.weight

    def _guard(self, name: str, use: _Use) -> Guard:
        needs, below = list(use.needs.items()), list(use.below.items())
        form = [] if self._variant == "none" or name not in self._clauses else self._form(self._clauses[name])

        def guard(state: State) -> bool:
            return (
                all(state[slot] >= tokens for slot, tokens in needs)
                and all(state[slot] < tokens for slot, tokens in below)
                and all(any(state[slot] == value for slot, value in part) for part in form)
            )

        return guard

    def _form(self, clause: sym.InputClause) -> list[list[tuple[int, int]]]:
        return [
            [(self._slots["signal", literal.signal], int(not literal.negated)) for literal in part.literals]
            for part in clause.disjunctions
        ]

    # ---------------------------------------------------------------------------------- signals

    def _signals(self) -> None:
        if self._variant == "none":
            return
        users: dict[sym.InputSignal, list[str]] = {}
        for name, clause in self._clauses.items():
            for part in clause.disjunctions:
                for literal in part.literals:
                    if name not in users.setdefault(literal.signal, []):
                        users[literal.signal].append(name)
        for signal, names in users.items():
            slot = self._slot(("signal", signal), int(signal.initial))
            if self._variant == "fully-enabled":
                self._changes(signal, slot, "", {})
                continue
            for name in names:
                use = self._uses[name]
                self._changes(signal, slot, f".{name}", use.needs)
                if self._variant == "io-enabled":
                    outputs = dict(use.gives)
                    for place, tokens in use.tested.items():
                        outputs[place] = outputs.get(place, 0) + tokens
                    self._changes(signal, slot, f"Out.{name}", outputs)

    def _changes(self, signal: sym.InputSignal, slot: int, suffix: str, marked: Effect) -> None:
        """Let a signal change while some places are marked."""
        for word, value in (("toTrue", 0), ("toFalse", 1)):

            def guard(state: State, value: int = value) -> bool:
                return state[slot] == value and all(state[p] >= tokens for p, tokens in marked.items())

            self._happens(f"{signal.id}.{word}{suffix}", guard, {slot: 1 - 2 * value})

    # ----------------------------------------------------------------------------------- topics

    def _topic(self, topic: sym.TopicChannel) -> None:
        arrived = {reader: self._reader(topic, reader) for reader in topic.subscribers}
        for writer in topic.publishers:
            written = [
                self._writer(topic, writer, reader, arrived[reader])
                for reader in topic.subscribers
                if are_matched(writer, reader)
            ]
            for copy in self._copies(writer.place):
                sent = self._place(writer.place, copy)
                self._happens(
                    f"{topic.id}.publisher.{self._name(writer.place, copy)}.publish",
                    lambda s, sent=sent: s[sent] > 0,  # type: ignore[misc]
                    {sent: -1, **dict.fromkeys(written, 1)},
                )

    def _reader(self, topic: sym.TopicChannel, reader: sym.SubscriberPort) -> int:
        name = f"{topic.id}.reader.{self._name(reader.place, 0)}"
        arrived = self._history(name, reader.limit, self._place(reader.place, 0))
        self.bounds[arrived] = 1
        return arrived

    def _writer(
        self, topic: sym.TopicChannel, writer: sym.PublisherPort, reader: sym.SubscriberPort, onward: int
    ) -> int:
        name = f"{topic.id}.writer.{writer.place.id}.{reader.place.id}"
        written = self._history(name, writer.limit, onward)
        self.bounds[written] = 1
        if "bestEffort" in (str(quality_of(writer).reliability), str(quality_of(reader).reliability)):
            kept = self._slots["kept", name]
            self._happens(f"{name}.lose", lambda s: s[kept] > 0, {kept: -1})
        return written

    def _history(self, name: str, depth: int, onward: int) -> int:
        """Add a history of so many messages, and return where they come."""
        come, kept = self._slot(("come", name)), self._slot(("kept", name))
        self._happens(f"{name}.in", lambda s: s[come] > 0 and s[kept] < depth, {come: -1, kept: 1})
        self._happens(f"{name}.drop", lambda s: s[come] > 0 and s[kept] == depth, {come: -1})
        self._happens(f"{name}.out", lambda s: s[kept] > 0, {kept: -1, onward: 1})
        return come

    def _bound_ports(self, topic: sym.TopicChannel) -> None:
        """Bound what waits to be published, and what is taken and not worked on."""
        for writer in topic.publishers:
            for copy in self._copies(writer.place):
                slot = self._place(writer.place, copy)
                if writer.place.capacity is None:
                    puts = [use.gives.get(slot, 0) for use in self._uses.values()]
                    self._bound(slot, max(1, writer.place.tokens, *puts))
        for reader in topic.subscribers:
            slot = self._place(reader.place, 0)
            taken = slot in self._requests or any(
                use.effect().get(slot, 0) < 0 for use in self._uses.values()
            )
            if reader.place.capacity is not None or reader.inHand == -1 or not taken:
                continue
            needs = [use.needs.get(slot, 0) for use in self._uses.values()]
            usual = max(1, reader.place.tokens, *needs)
            self._bound(slot, usual if reader.inHand is None else reader.inHand)

    def _bound_requests(self, client: sym.ClientPort, copy: int) -> None:
        """Bound what waits to be asked, where that is sent at once."""
        if self.outstanding[client] == UNLIMITED and client.request.capacity is None:
            slot = self._place(client.request, copy)
            puts = [use.gives.get(slot, 0) for use in self._uses.values()]
            self._bound(slot, max(1, client.request.tokens, *puts))

    def _bound(self, slot: int, tokens: int) -> None:
        self.bounds[slot] = min(tokens, self.bounds.get(slot, tokens))
