"""Facts of a model for the picture of a trace: owners, clauses, channels, and all transitions."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from dineros.metamodel import pn, sym
from dineros.metamodel.calls import Served, copy_id, instance_counts, server_pages, services, serving
from dineros.metamodel.clauses import value_names
from dineros.metamodel.elements import label, node_net_of, node_nets, nodes, resolve

_INSTANCE = re.compile(r"^(?P<channel>.+?)\[(?P<number>[0-9]+)\]\.(?P<element>.+)$")

DISPATCHER_LIMIT = 16
"""Default capacity of a dispatcher queue (paper, Sect. 5.5.2)."""

Literal = tuple[str, bool] | tuple[str, bool, str]
"""A signal, whether it is negated, and the value that it is compared with, if it has values."""


@dataclass(frozen=True)
class Clause:
    """An input clause: its text, and its conjunctive normal form as lists of literals."""

    text: str
    disjunctions: tuple[tuple[Literal, ...], ...]


@dataclass(frozen=True)
class Facts:
    """Facts of the model; all empty without a model.

    Attributes
    ----------
    owner : dict of str to str
        Node net of each place, transition and signal.
    labels : dict of str to str
        Name of each element, where it differs from its id.
    clauses : dict of str to Clause
        Clause of each transition that has one.
    transitions : list of str
        Transitions as a running node has them: once for each server instance.
    places : list of str
        Places of the model, without instances.
    limits : dict of (str, str) to int
        Capacity of the queue between a channel and a place, or a node net's dispatcher.
    depths : dict of (str, str) to int
        Depth of the request history between a service and the entry of its server.
    subscribers : set of (str, str)
        The channel and place of each subscriber port.
    channels : dict of str to str
        Topic, service or action of each channel.
    ports : dict of (str, str) to str
        The client whose request or response place this is, by channel and place.
    goals : dict of (str, str) to str
        The place of the goals of each client of an action, by channel and client.
    values : dict of str to list of str
        The names of the values of each signal that has some.
    managed : list of str
        Node nets that are managed.
    has_histories : bool
        Whether queues are histories (ROS 2), which hold no more than their depth: what comes pushes out.
    """

    owner: dict[str, str] = field(default_factory=dict)
    labels: dict[str, str] = field(default_factory=dict)
    clauses: dict[str, Clause] = field(default_factory=dict)
    transitions: list[str] = field(default_factory=list)
    places: list[str] = field(default_factory=list)
    limits: dict[tuple[str, str], int] = field(default_factory=dict)
    depths: dict[tuple[str, str], int] = field(default_factory=dict)
    subscribers: set[tuple[str, str]] = field(default_factory=set)
    channels: dict[str, str] = field(default_factory=dict)
    ports: dict[tuple[str, str], str] = field(default_factory=dict)
    goals: dict[tuple[str, str], str] = field(default_factory=dict)
    values: dict[str, list[str]] = field(default_factory=dict)
    managed: list[str] = field(default_factory=list)
    has_histories: bool = False

    def owner_of(self, element: str | None) -> str | None:
        """Return the node net of an element; that of its prototype for one of a server instance."""
        return None if element is None else self.owner.get(element) or self.owner.get(prototype(element))

    def label_of(self, element: str) -> str:
        """Return the displayed name, with the server instance if there is one."""
        original = prototype(element)
        return element.removesuffix(original) + self.labels.get(original, original)

    def channel_name(self, channel: str) -> str:
        """Return the topic, service or action of a channel; its id if the model does not have it."""
        return self.channels.get(channel, channel)

    def only_client(self, channel: str) -> str | None:
        """Return the client of an action; None if it has several."""
        clients = [client for action, client in self.goals if action == channel]
        return clients[0] if len(clients) == 1 else None

    def client_words(self, client: str) -> str:
        """Return a client: ``client L``, or the server instance that calls from its own page."""
        found = _INSTANCE.match(client)
        if found is None or found["channel"] not in self.channels:
            return f"client {client}"
        return f"instance {found['number']} of service {self.channels[found['channel']]}"


def prototype(element: str) -> str:
    """Return the id in the system model of an element of a server instance.

    Examples
    --------
    >>> prototype("Pick[2].TPick"), prototype("TStop")
    ('TPick', 'TStop')
    """
    while match := _INSTANCE.match(element):
        element = match["element"]
    return element


def facts_of(model: pn.Net | None) -> Facts:
    """Read the facts of a model for pictures of its traces."""
    if model is None:
        return Facts()
    is_of_ros2 = isinstance(model, sym.SystemModel) and model.middleware == sym.Middleware.ros2
    facts = Facts(has_histories=is_of_ros2)
    counts = instance_counts(model)
    replicas = _replicas(model, counts)
    for node in nodes(model):
        owner = node_net_of(node)
        if owner is not None:
            facts.owner[node.id] = owner.id
        if label(node) != node.id:
            facts.labels[node.id] = label(node)
        if isinstance(node, pn.Place):
            facts.places.append(node.id)
        if isinstance(node, pn.Transition):
            facts.transitions.extend(replicas.get(id(node.page), {}).get(node.id) or [node.id])
            clause = getattr(node, "clause", None)
            if clause is not None:
                facts.clauses[node.id] = _clause(clause)
    for net in node_nets(model):
        facts.owner.update({signal.id: net.id for signal in net.signals})
        facts.values.update({each.id: list(value_names(each)) for each in net.signals if each.values})
        if net.lifecycle is not None:
            facts.managed.append(net.id)
    for channel in model.channels if isinstance(model, sym.SystemModel) else ():
        _add_channel(facts, channel)
    pages = server_pages(model)
    for service in services(model):
        for client in service.clients:
            _add_client(facts, service, client, serving(client.request, pages), counts)
    return facts


def _clause(clause: sym.InputClause) -> Clause:
    disjunctions = tuple(
        tuple(
            (str(each.signal.id), bool(each.negated))
            if each.value is None
            else (str(each.signal.id), bool(each.negated), each.value)
            for each in disjunction.literals
        )
        for disjunction in clause.disjunctions
    )
    return Clause(clause.text, disjunctions)


def _replicas(model: pn.Net, counts: dict[Served, int]) -> dict[int, dict[str, list[str]]]:
    """Return the ids of the transitions of server pages in their instances, by the page's identity."""
    found: dict[int, dict[str, list[str]]] = {}
    for channel in model.channels if isinstance(model, sym.SystemModel) else ():
        if not isinstance(channel, (sym.ServiceChannel, sym.ActionChannel)) or channel.server is None:
            continue
        instances = counts[channel]
        stack = [channel.server.page]
        while stack:
            page = stack.pop()
            stack += [inner for inner in page.objects if isinstance(inner, pn.Page)]
            found[id(page)] = {
                node.id: [copy_id(channel.id, number, node.id) for number in range(1, instances + 1)]
                for node in page.objects
                if isinstance(node, pn.Transition)
            }
    return found


def _add_channel(facts: Facts, channel: sym.Channel) -> None:
    if isinstance(channel, sym.TopicChannel):
        facts.channels[channel.id] = channel.topic
        for port in (*channel.publishers, *channel.subscribers):
            facts.limits[channel.id, resolve(port.place).id] = port.limit
        facts.subscribers.update((channel.id, resolve(port.place).id) for port in channel.subscribers)
        for port in channel.subscribers:
            owner = node_net_of(resolve(port.place))
            if owner is not None:
                facts.limits.setdefault((channel.id, owner.id), DISPATCHER_LIMIT)
        for dispatcher in channel.dispatchers:
            facts.limits[channel.id, dispatcher.node.id] = dispatcher.limit
    elif isinstance(channel, sym.ServiceChannel):
        facts.channels[channel.id] = channel.service
        facts.depths[channel.id, channel.server.entry.id] = channel.depth
    elif isinstance(channel, sym.ActionChannel):
        facts.channels[channel.id] = channel.action
        for client in channel.clients:
            facts.goals[channel.id, client.client] = resolve(client.goal).id


def _add_client(
    facts: Facts,
    channel: sym.ServiceChannel,
    client: sym.ClientPort,
    caller: Served | None,
    counts: dict[Served, int],
) -> None:
    """Add a client; one on a server page exists for each instance."""
    for place in filter(None, (client.request, client.response)):
        if caller is None:
            facts.ports[channel.id, resolve(place).id] = client.client
            continue
        for number in range(1, counts[caller] + 1):
            copy = copy_id(caller.id, number, place.id)
            facts.ports[channel.id, copy] = copy_id(caller.id, number, client.client)
