"""The flattened net on which runs are replayed, with lookups of recorded steps."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property

from dineros.analysis.conformance.data.decisions import Decisions
from dineros.analysis.conformance.topics.finding import QueueFinder
from dineros.analysis.conformance.topics.parts import HistoryTopic, Queue, Topic
from dineros.analysis.model.channels import channel_words
from dineros.analysis.model.step_roles import StepRole, step_roles
from dineros.analysis.model.subject import Subject, subject_of
from dineros.analysis.model.wording import signal_setting, topic_port
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.under_way import outstanding_counts
from dineros.metamodel.clauses import SignalSetting, value_names
from dineros.metamodel.elements import node_net_of, node_nets, nodes
from dineros.metamodel.guards.using import guarded
from dineros.metamodel.records import (
    Drop,
    Fire,
    Lifecycle,
    Publish,
    Reply,
    Request,
    Response,
    Serve,
    Signal,
)
from dineros.metamodel.records.schema import ChannelStep, ServiceStep, Step

Key = tuple[object, ...]


class ConformanceNet:
    """A system model flattened with fully-enabled signals, with lookups of recorded steps.

    Traces are written by our engine, which runs the net of each node: executors and callback groups of
    handwritten nodes are not part of it.
    """

    def __init__(self, model: sym.SystemModel) -> None:
        self.model = model
        with _run_as_nets(model):
            self.subject: Subject = subject_of(model, "fully-enabled")
        self.net = self.subject.net
        self.nodes = [node.id for node in node_nets(model)]
        on_the_way = self._room_on_the_way()
        self.pre = [
            [(place, weight) for place, weight in self.net.pre.row(index) if place not in on_the_way]
            for index in range(len(self.net.transitions))
        ]
        self.inhibitor = [self.net.inhibitor.row(index) for index in range(len(self.net.transitions))]
        self.roles: dict[str, StepRole] = step_roles(self.subject.links())
        if self.subject.flattened is None:  # neither channels nor clauses: the model itself is the net
            for transition in self.subject.transition_index:
                self.roles[transition] = StepRole(Fire, node=self._node_of_transition.get(transition))
        self._steps: dict[Key, int] = {
            _key(role): self.subject.transition_index[name]
            for name, role in self.roles.items()
            if role.kind is not Fire
        }

    def _room_on_the_way(self) -> set[int]:
        """Return the places of room for messages under way between a client and a server.

        A run does not need this room: a client sends a request again, so a message under way may arrive at
        any later time.
        """
        return {
            self.subject.place_index[link.target.id]
            for link in self.subject.links()
            if link.meaning is not None and link.meaning.part == "way" and isinstance(link.target, pn.Place)
        }

    def fire(self, transition: str) -> int | None:
        """Return a transition of the model, by its id in the flattened net."""
        role = self.roles.get(transition)
        return self.subject.transition_index[transition] if role is not None and role.kind is Fire else None

    def end(self, kind: type[ChannelStep], channel: str, place: str) -> int | None:
        """Return the transition of a publisher's or subscriber's port."""
        return self._steps.get((kind, channel, place))

    def service(
        self, kind: type[ServiceStep], channel: str, client: str | None, instance: int | None
    ) -> int | None:
        """Return a transition of a call: of the client's port, or between it and a server instance.

        Without a client, the call belongs to a client that has given up.
        """
        if kind in (Request, Response):
            return self._steps.get((kind, channel, client))
        return self._steps.get((kind, channel, client, instance))

    def giving_up(
        self, channel: str, client: str, stage: type[ServiceStep], instance: int | None
    ) -> list[int]:
        """Return the transitions with which a client may give up a call with a known last step.

        A request that is not served is in the history, or lost; likelier cases come first.
        """
        parts = self._histories.get((channel, client), {})
        if stage is Request:
            before = [parts.get("request.enter"), parts.get("drop")]
        else:
            before = [self.service(stage, channel, client, instance or 1)]
        left = [
            {place for place, change in self.net.delta[index].items() if change > 0}
            for index in before
            if index is not None
        ]
        ways = self._giving_up[channel, client]
        return [way for places in left for way in ways if places & {place for place, _ in self.pre[way]}]

    @cached_property
    def _giving_up(self) -> dict[tuple[str, str], list[int]]:
        """The transitions with which each client gives up."""
        found: dict[tuple[str, str], list[int]] = defaultdict(list)
        for name, role in self.roles.items():
            if role.kind.declared.call == "is given up":
                found[role.channel or "", role.client or ""].append(self.subject.transition_index[name])
        return found

    @cached_property
    def _histories(self) -> dict[tuple[str, str], dict[str, int]]:
        """The transitions with which a client's requests enter the history of a service, or are lost."""
        found: dict[tuple[str, str], dict[str, int]] = defaultdict(dict)
        for name, role in self.roles.items():
            if role.queue == "request":
                found[role.channel or "", role.client or ""][role.stage or "drop"] = (
                    self.subject.transition_index[name]
                )
        return found

    def entering(self, channel: str, client: str) -> int | None:
        """Return the transition with which a client's request enters the history; None: there is none."""
        return self._histories.get((channel, client), {}).get("request.enter")

    @cached_property
    def depths(self) -> dict[str, int]:
        """Depth of the history of each service."""
        return {
            channel.id: channel.depth
            for channel in self.model.channels
            if isinstance(channel, sym.ServiceChannel)
        }

    @cached_property
    def signals(self) -> dict[str, tuple[str, tuple[SignalSetting, ...]]]:
        """Node net of each signal, and what the signal can be."""
        return {
            signal.id: (node.id, value_names(signal) or (False, True))
            for node in node_nets(self.model)
            for signal in node.signals
        }

    @cached_property
    def publishing_nodes(self) -> dict[str, tuple[str, ...]]:
        """The node nets that publish on each topic channel."""
        found: dict[str, dict[str, None]] = {channel: {} for channel in self.topics}
        for role in self.roles.values():
            if role.kind is Publish:
                found[role.channel or ""][role.node or ""] = None
        return {channel: tuple(nodes) for channel, nodes in found.items()}

    def ends_of_call(self, channel: str, client: str) -> tuple[str, str]:
        """Return the node nets of a client and of its server."""
        return self._ends[channel, client, Request], self._ends[channel, client, Reply]

    @cached_property
    def _ends(self) -> dict[tuple[str, str, type[Step]], str]:
        return {
            (role.channel or "", role.client or "", role.kind): role.node or ""
            for role in self.roles.values()
            if role.kind in (Request, Reply)
        }

    def clients_of(self, channel: str) -> tuple[str, ...]:
        """Return the clients of a service channel."""
        return tuple(client for of, client, kind in self._ends if of == channel and kind is Request)

    def asking_nodes(self, channel: str) -> tuple[str, ...]:
        """Return the node nets with clients of a service channel."""
        return tuple({self._ends[channel, client, Request]: None for client in self.clients_of(channel)})

    @cached_property
    def names_in_ros(self) -> dict[str, str]:
        """Topic, service or action of each channel, as text."""
        return {channel.id: channel_words(channel) for channel in self.model.channels}

    @cached_property
    def typed_channels(self) -> set[str]:
        """Channels with an existing message type: programs without ids may send there, too."""
        return {channel.id for channel in self.model.channels if channel.type}

    @cached_property
    def places_of(self) -> dict[str, dict[str, int]]:
        """Places of each node net, by id, with their index."""
        found: dict[str, dict[str, int]] = {node: {} for node in self.nodes}
        for name, original in self._originals(pn.Place):
            node = node_net_of(original)
            if node is not None:
                found[node.id][name] = self.subject.place_index[name]
        return found

    @cached_property
    def own_places(self) -> set[int]:
        """Places of all node nets."""
        return {index for places in self.places_of.values() for index in places.values()}

    def is_of_idle_server(self, place: str) -> bool:
        """Return whether a place belongs to a server without clients in the model.

        The net does not contain its page; but a node has it, for programs outside of the model.
        """
        channel, instance, _ = place.partition("[")
        return bool(instance) and channel in self._idle_servers

    @cached_property
    def _idle_servers(self) -> set[str]:
        services = (sym.ServiceChannel, sym.ActionChannel)
        return {each.id for each in self.model.channels if isinstance(each, services) and not each.clients}

    @cached_property
    def clients(self) -> dict[tuple[str, str], str]:
        """Client of each channel and request place, if the place has only one client."""
        found: dict[tuple[str, str], list[str]] = defaultdict(list)
        for role in self.roles.values():
            if role.kind is Request:
                found[role.channel or "", role.place or ""].append(role.client or "")
        return {key: names[0] for key, names in found.items() if len(names) == 1}

    @cached_property
    def instances(self) -> dict[tuple[str, str], int]:
        """Server instance of each channel and entry or exit place."""
        return {
            (role.channel or "", role.place or ""): role.instance or 0
            for role in self.roles.values()
            if role.kind in (Serve, Reply)
        }

    @cached_property
    def disjunctions(self) -> dict[int, sym.Disjunction]:
        """The disjunction of a clause whose true literals a place counts, by place."""
        return {
            self.subject.place_index[link.target.id]: source
            for link in self.subject.links()
            if isinstance(link.target, pn.Place)
            for source in link.sources
            if isinstance(source, sym.Disjunction)
        }

    @cached_property
    def setting_places(self) -> dict[tuple[str, SignalSetting], int]:
        """Place that is marked while a signal has a value, by both; only signals in use."""
        return {
            (link.sources[0].id, value): self.subject.place_index[link.target.id]
            for link in self.subject.links()
            if (value := signal_setting(link)) is not None
            if isinstance(link.target, pn.Place) and isinstance(link.sources[0], sym.InputSignal)
        }

    @cached_property
    def changes_of_signals(self) -> dict[tuple[str, SignalSetting], list[int]]:
        """Transitions that give a signal a value, by both; only signals in use."""
        found: dict[tuple[str, SignalSetting], list[int]] = {}
        for id, role in self.roles.items():
            if role.kind is Signal and role.signal is not None and role.value is not None:
                found.setdefault((role.signal, role.value), []).append(self.subject.transition_index[id])
        return found

    @cached_property
    def _finder(self) -> QueueFinder:
        return QueueFinder(self.subject, self.roles, self.node_of_state)

    @cached_property
    def topics(self) -> dict[str, Topic | HistoryTopic]:
        """Topic channels by id."""
        return self._finder.topics(self.model)

    @cached_property
    def ports(self) -> dict[tuple[str, str], str]:
        """Place of a publisher's port in message ids, by channel and place in the running net."""
        return {
            (role.channel or "", role.place or ""): port.place.id
            for link in self.subject.links()
            if (role := self.roles.get(link.target.id or "")) is not None
            if role.kind is Publish and (port := topic_port(link)) is not None
        }

    def changes_of(self, record: Lifecycle) -> list[int]:
        """Return the transitions for a recorded state change of a managed node."""
        wanted = StepRole(Lifecycle, record.node, label=record.label, state=record.state)
        return [self.subject.transition_index[name] for name, role in self.roles.items() if role == wanted]

    def discarding(self, record: Drop) -> list[int]:
        """Return the transitions with which a publisher loses a message while its node is not active."""
        wanted = StepRole(Drop, record.node, record.channel, "inactive", place=record.place)
        return [self.subject.transition_index[name] for name, role in self.roles.items() if role == wanted]

    @cached_property
    def node_of_state(self) -> dict[int, str]:
        """The managed node for each place of a lifecycle state."""
        return {
            self.subject.place_index[link.target.id]: str(getattr(link.sources[0], "id", ""))
            for link in self.subject.links()
            if link.meaning is not None and link.meaning.part.startswith("state.")
        }

    @cached_property
    def decisions(self) -> Decisions:
        """Guards and assignments on the data of tokens."""
        return Decisions(self.model, self.subject)

    @cached_property
    def emptying(self) -> dict[str, list[int]]:
        """The transitions that empty the histories of each node that has been cleaned up."""
        parts = ("left", "gone", "clear", "again", "forget")
        found: dict[str, list[int]] = defaultdict(list)
        for link in self.subject.links():
            if link.meaning is not None and link.meaning.part in parts and link.meaning.queue:
                for source in link.sources:
                    if isinstance(source, sym.NodeNet) and isinstance(link.target, pn.Transition):
                        found[source.id].append(self.subject.transition_index[link.target.id])
        return found

    @cached_property
    def feedback_queues(self) -> dict[tuple[str, str], Queue]:
        """The feedback history of each action client that receives feedback, by channel and client."""
        return self._finder.feedback()

    @cached_property
    def suppliers(self) -> dict[int, list[int]]:
        """Steps without records, by the places that they supply: ticks, requests that are kept or lost."""
        silent = []
        for link in self.subject.links():
            role = self.roles.get(link.target.id or "") if isinstance(link.target, pn.Transition) else None
            is_kept = role is not None and role.queue in ("request", "response")
            is_silent = role is not None and link.meaning is not None and link.meaning.part == "unrecorded"
            if is_kept or is_silent:
                silent.append(str(link.target.id))
        found: dict[int, list[int]] = defaultdict(list)
        for name in silent:
            transition = self.subject.transition_index[name]
            for place, tokens in self.net.delta[transition].items():
                if tokens > 0:
                    found[place].append(transition)
        return found

    @cached_property
    def follow_ups(self) -> list[int]:
        """Steps without records that are fired as soon as they are enabled."""
        return [
            self.subject.transition_index[link.target.id]
            for link in self.subject.links()
            if link.meaning is not None and link.meaning.part == "follow-up"
        ]

    @cached_property
    def room(self) -> dict[int, int]:
        """The place of free room of each place with a capacity."""
        index, flattened = self.subject.place_index, self.subject.flattened
        links = {link.target: link for link in self.subject.links()}
        return {
            index[invariant.terms[0].place.id]: index[free.id]
            for invariant in (flattened.net.certificate if flattened is not None else ())
            for free in (invariant.terms[-1].place,)
            if links[free].role.endswith("free")
        }

    @cached_property
    def _node_of_transition(self) -> dict[str, str]:
        return {
            name: node.id
            for name, original in self._originals(pn.Transition)
            if (node := node_net_of(original)) is not None
        }

    def _originals(self, kind: type[pn.Node]) -> list[tuple[str, pn.Node]]:
        """Return the nodes of the model or their copies per server instance, with their ids in the net."""
        if self.subject.flattened is None:
            return [(node.id, node) for node in nodes(self.model) if isinstance(node, kind)]
        return [
            (link.target.id, original)
            for link in self.subject.links()
            if link.role in ("place", "transition")
            and isinstance(link.target, kind)
            and isinstance(original := link.sources[0], pn.Node)
        ]


def _key(role: StepRole) -> Key:
    if role.kind is Signal:
        return Signal, role.signal, role.value
    if role.kind.declared.is_of_topic:
        return role.kind, role.channel, role.place
    if role.kind in (Request, Response):
        return role.kind, role.channel, role.client
    if role.kind in (Serve, Reply):
        return role.kind, role.channel, role.client, role.instance
    return role.kind, role.channel, role.queue, role.stage, role.node, role.place


@contextmanager
def _run_as_nets(model: sym.SystemModel) -> Iterator[None]:
    """Within the block, give all node nets of a model the execution of our engine, and no guards.

    The number of requests under way of a client in a node with callbacks does not change. The net counts
    tokens; `values` checks guards on their data.
    """
    by_hand = [node for node in node_nets(model) if node.execution == sym.Execution.callbacks]
    asked = {
        client: number for client, number in outstanding_counts(model).items() if client.outstanding is None
    }
    decisions = [(each, each.guard, each.assigns) for each in guarded(model)]
    for client, number in asked.items():
        client.outstanding = number
    for transition, _, _ in decisions:
        transition.guard = transition.assigns = None
    for node in by_hand:
        node.execution = sym.Execution.net
    try:
        yield
    finally:
        for node in by_hand:
            node.execution = sym.Execution.callbacks
        for client in asked:
            client.outstanding = None
        for transition, guard, assigns in decisions:
            transition.guard, transition.assigns = guard, assigns
