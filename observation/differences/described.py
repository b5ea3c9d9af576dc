"""Describes the nodes and ports of a system model as an observed system."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import is_unseen, label, node_net_of, node_nets
from dineros.metamodel.matching import Quality, plain, quality_of
from dineros.metamodel.ros_names import resource_name
from dineros.metamodel.token_data import TokenType
from dineros.metamodel.token_types.declared import type_of_place
from dineros.observation.systems import (
    ALL_KEPT,
    Endpoint,
    ObservedNode,
    ObservedSystem,
    TopicEndpoint,
    name_of,
)
from dineros.runtime.ros.conversion.messages import action_interface, service_interface, token_interface


@dataclass(frozen=True)
class Described:
    """A model as a system."""

    system: ObservedSystem
    """Its nodes."""
    elements: dict[tuple[str, str, str], str] = field(default_factory=dict)
    """Id of the model's element, by full name of the node, role (empty for the node itself) and name."""
    managed: frozenset[str] = frozenset()
    """Full names of managed nodes."""


def described(model: sym.SystemModel, *, with_unseen: bool = False) -> Described:
    """Return the nodes and ports of a model.

    Parameters
    ----------
    model : sym.SystemModel
        A valid model. If it names no interface, the generated interface is used.
    with_unseen : bool
        Whether to include invented nodes, which represent unknown nodes at the other end of a channel.
    """
    ports: dict[str, dict[str, list[Any]]] = {}
    elements: dict[tuple[str, str, str], str] = {}
    managed = set()
    names = {}
    for node in node_nets(model):
        if is_unseen(node) and not with_unseen:
            continue
        names[node] = name = full_name(node)
        ports[name] = {}
        elements[name, "", ""] = str(node.id)
        if node.lifecycle is not None:
            managed.add(name)
    for place, role, port, id in _ports(model):
        net = node_net_of(place)
        if net in names:
            # The real nodes behind such a node are unknown, and so is their namespace.
            absolute = _absolute(port, "/" if is_unseen(net) else names[net])
            ports[names[net]].setdefault(role, []).append(absolute)
            elements.setdefault((names[net], role, name_of(absolute)), id)
    nodes = []
    for name, known in sorted(ports.items()):
        by_role: dict[str, Any] = {role: tuple(found) for role, found in known.items()}
        nodes.append(ObservedNode(name, **by_role))
    return Described(ObservedSystem(str(model.id), tuple(nodes)), elements, frozenset(managed))


def full_name(node: sym.NodeNet) -> str:
    """Return the full name of the ROS node of a node net.

    Examples
    --------
    >>> full_name(sym.NodeNet(id="left_arm", name="arm", namespace="/left"))
    '/left/arm'
    """
    return f"/{(node.namespace or '').strip('/')}/{resource_name(label(node))}".replace("//", "/")


def _absolute(port: TopicEndpoint | Endpoint, node: str) -> TopicEndpoint | Endpoint:
    """Return a port with its full name, resolved at its node."""
    name = name_of(port)
    if name.startswith("~"):
        full = f"{node}{name[1:]}"
    else:
        full = name if name.startswith("/") else f"{node.rpartition('/')[0]}/{name}"
    if isinstance(port, TopicEndpoint):
        return replace(port, topic=full)
    return replace(port, name=full)


def _ports(model: sym.SystemModel) -> Iterator[tuple[pn.Place, str, TopicEndpoint | Endpoint, str]]:
    """Yield each port: its place, its role, its description, and the id of its element."""
    for channel in model.channels:
        match channel:
            case sym.TopicChannel():
                for role, ports in (("publishers", channel.publishers), ("subscribers", channel.subscribers)):
                    for port in ports:
                        yield port.place, role, _topic(model, channel, port), port.place.id
            case sym.ServiceChannel():
                type = channel.type or service_interface(model.id, channel.id)
                endpoint = Endpoint(channel.service, type)
                yield channel.server.entry, "servers", endpoint, channel.server.page.id
                yield from _once("clients", endpoint, [each.request for each in channel.clients])
            case sym.ActionChannel():
                type = channel.type or action_interface(model.id, channel.id)
                endpoint = Endpoint(channel.action, type)
                yield channel.server.entry, "action_servers", endpoint, channel.server.page.id
                yield from _once("action_clients", endpoint, [each.goal for each in channel.clients])


def _once(
    role: str, endpoint: Endpoint, places: Iterable[pn.Place]
) -> Iterator[tuple[pn.Place, str, Endpoint, str]]:
    """Yield one client for each node, even if several callbacks call the service."""
    nodes = set()
    for place in places:
        node = node_net_of(place)
        if node not in nodes:
            nodes.add(node)
            yield place, role, endpoint, place.id


def _topic(
    model: sym.SystemModel, channel: sym.TopicChannel, port: sym.PublisherPort | sym.SubscriberPort
) -> TopicEndpoint:
    declared = type_of_place(port.place, model)
    existing = channel.type or (declared.ros if declared is not None else None)
    named = TokenType(label(declared) if declared is not None else "Token", (), existing)
    depth = None if "limit" in (port.assumed or "").split() else 0 if port.limit == ALL_KEPT else port.limit
    return TopicEndpoint(channel.topic, token_interface(model.id, named), _quality(port, existing), depth)


def _quality(port: sym.PublisherPort | sym.SubscriberPort, existing: str | None) -> Quality:
    """Return the quality of service of a port; if the model has none, the one of the generated node."""
    if port.qos is None and (port.channel is None or port.channel.qos is None) and existing is None:
        return plain(sym.QualityOfService())._replace(durability="transientLocal")
    return plain(quality_of(port))
