"""Converts a system to one that a model can represent: one server per service, one type per name."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from reprlib import Repr
from typing import Any

from dineros.metamodel.errors import listed
from dineros.metamodel.ros_names import hidden_part
from dineros.observation.importing.given import Given, GivenService
from dineros.observation.importing.names import is_type
from dineros.observation.importing.whole.triggers import used_by_themselves
from dineros.observation.systems import (
    USUAL,
    Endpoint,
    ObservedNode,
    ObservedSystem,
    TopicEndpoint,
    full_name,
    is_name,
    name_of,
)

_SHORT = Repr()
_SHORT.maxstring = 200
"""Longest name in a message: names of ROS 2 have at most 255 characters."""

_KINDS = {
    "publishers": "msg",
    "subscribers": "msg",
    "servers": "srv",
    "clients": "srv",
    "action_servers": "action",
    "action_clients": "action",
}
_WORDS = {
    "publishers": "publisher",
    "subscribers": "subscription",
    "servers": "server",
    "clients": "client",
    "action_servers": "action server",
    "action_clients": "action client",
}


@dataclass(frozen=True)
class Whole:
    """A system whose services and actions have one server each, and whose channels one type."""

    nodes: tuple[ObservedNode, ...]
    """The nodes, including those that represent unknown nodes."""
    unseen: frozenset[str]
    """Names of invented nodes: unknown publishers of a recorded topic, or servers of a service without a
    known server.
    """
    left_out: tuple[str, ...]
    """What was observed and is left out, a line each."""


def whole(system: ObservedSystem, given: Given) -> Whole:
    """Return the part of a system that a model can represent, and the omitted parts."""
    left_out: list[str] = []
    left_out += [
        f"service {service.name}: its events do not show which node serves it"
        for service in system.services
        if service.name not in given.services
    ]
    nodes = _joined([*system.nodes, *_recorded(system, given)])
    seen = {node.name for node in system.nodes}
    seen.update(name for said in given.topics.values() for name in (*said.publishers, *said.subscribers))
    seen.update(name for said in given.services.values() for name in (*said.servers, *said.clients))
    kept = [_named(node, left_out) for node in nodes if _is_kept(node, left_out)]
    types = _types(kept)
    kept = [_of_one_type(node, types, left_out) for node in kept]
    kept = list(_one_server(kept, left_out))
    callers = _callers_of_the_uncalled(kept, given, left_out) if system.is_partial else []
    kept += [*_servers_of_the_unserved(kept), *callers]
    return Whole(
        tuple(sorted(kept, key=lambda node: node.name)),
        frozenset(node.name for node in kept if node.name not in seen),
        tuple(left_out),
    )


def _recorded(system: ObservedSystem, given: Given) -> Iterable[ObservedNode]:
    """Yield nodes with the ports of recorded topics: given ones, otherwise one for each topic.

    Services are included only if their nodes are given: an unknown server would not answer.
    """
    for topic in system.topics:
        said = given.topics.get(topic.name)
        offered = topic.offered or (USUAL,)
        publishers = said.publishers if said is not None else ()
        for name in publishers or (f"/unseen/publisher{full_name(topic.name)}",):
            yield ObservedNode(
                name, publishers=tuple(TopicEndpoint(topic.name, topic.type, each) for each in offered[:1])
            )
        for name in said.subscribers if said is not None else ():
            # The recording has the offers of publishers; a subscription that requested more would have
            # received nothing.
            yield ObservedNode(name, subscribers=(TopicEndpoint(topic.name, topic.type, offered[0]),))
    for service in system.services:
        ends = given.services.get(service.name, GivenService())
        endpoint = (Endpoint(service.name, service.type),)
        yield from (ObservedNode(name, servers=endpoint) for name in ends.servers)
        yield from (ObservedNode(name, clients=endpoint) for name in ends.clients)


def _joined(nodes: Iterable[ObservedNode]) -> list[ObservedNode]:
    """Return nodes with distinct names, each with the ports of all nodes of that name."""
    found: dict[str, ObservedNode] = {}
    for node in nodes:
        before = found.get(node.name)
        ports = {role: getattr(before, role) + getattr(node, role) for role in _KINDS} if before else {}
        found[node.name] = replace(before, **ports) if before else node
    return list(found.values())


def _shortened(name: str) -> str:
    """Return a name from outside in quotes, without its middle if it is long."""
    return _SHORT.repr(name)


def _is_kept(node: ObservedNode, left_out: list[str]) -> bool:
    if is_name(node.name):
        return True
    left_out.append(f"node {_shortened(node.name)}: not a name that ROS 2 allows")
    return False


def _named(node: ObservedNode, left_out: list[str]) -> ObservedNode:
    """Return a node without the ports whose name or type a model cannot have."""
    changed: dict[str, Any] = {}
    for role, kind in _KINDS.items():
        ports = getattr(node, role)
        fit = tuple(
            each
            for each in ports
            if _has_name(each) and is_type(each.type, kind) and hidden_part(name_of(each)) is None
        )
        for each in ports:
            if each not in fit:
                left_out.append(
                    f"{_WORDS[role]} {_shortened(name_of(each))} of {node.name}, of the type "
                    f"{_shortened(each.type)}: not a name and type that ROS 2 allows"
                )
        changed[role] = tuple(sorted(fit, key=lambda each: (name_of(each), each.type)))
    return replace(node, **changed)


def _has_name(port: TopicEndpoint | Endpoint) -> bool:
    """Return whether a model can have the name of a port; a recorded topic may lack the leading slash."""
    return is_name(full_name(port.topic) if isinstance(port, TopicEndpoint) else port.name)


def _types(nodes: Iterable[ObservedNode]) -> dict[tuple[str, str], str]:
    """Return the type of each topic, service and action: of its first provider by the names of nodes."""
    found: dict[tuple[str, str], str] = {}
    ordered = sorted(nodes, key=lambda node: node.name)
    for roles in (("publishers", "servers", "action_servers"), ("subscribers", "clients", "action_clients")):
        for node in ordered:
            for role in roles:
                for port in getattr(node, role):
                    found.setdefault((_KINDS[role], name_of(port)), port.type)
    return found


def _of_one_type(node: ObservedNode, types: dict[tuple[str, str], str], left_out: list[str]) -> ObservedNode:
    changed: dict[str, Any] = {}
    for role, kind in _KINDS.items():
        ports = getattr(node, role)
        fit = tuple(each for each in ports if each.type == types[kind, name_of(each)])
        for each in ports:
            if each not in fit:
                of, other = f"{_WORDS[role]} {name_of(each)} of {node.name}", types[kind, name_of(each)]
                left_out.append(f"{of}, of the type {each.type}: others have {other}")
        changed[role] = fit
    return replace(node, **changed)


def _one_server(nodes: Iterable[ObservedNode], left_out: list[str]) -> Iterable[ObservedNode]:
    """Yield the nodes; of several servers of one name, the first is kept."""
    first: dict[tuple[str, str], str] = {}
    for node in sorted(nodes, key=lambda node: node.name):
        changed: dict[str, Any] = {}
        others: dict[str, list[str]] = defaultdict(list)
        for role in ("servers", "action_servers"):
            fit = []
            for each in getattr(node, role):
                if (role, each.name) in first:
                    others[first[role, each.name]].append(f"{_WORDS[role]} {each.name}")
                else:
                    first[role, each.name] = node.name
                    fit.append(each)
            changed[role] = tuple(fit)
        left_out += [
            f"{listed(ports)} of {node.name}: {other} serves the same" for other, ports in others.items()
        ]
        yield replace(node, **changed)


def _servers_of_the_unserved(nodes: Iterable[ObservedNode]) -> list[ObservedNode]:
    """Return a node that never responds for each service and action without a server."""
    wanted: dict[tuple[str, str], str] = {}
    served: dict[str, set[str]] = defaultdict(set)
    for node in nodes:
        for clients, servers in (("clients", "servers"), ("action_clients", "action_servers")):
            served[servers].update(each.name for each in getattr(node, servers))
            wanted.update({(servers, each.name): each.type for each in getattr(node, clients)})
    found = []
    for (role, name), type in wanted.items():
        if name not in served[role]:
            ports: dict[str, Any] = {role: (Endpoint(name, type),)}
            found.append(ObservedNode(f"/unseen/{role.removesuffix('s')}{name}", **ports))
    return found


def _callers_of_the_uncalled(
    nodes: Sequence[ObservedNode], given: Given, left_out: list[str]
) -> list[ObservedNode]:
    """Return nodes for each topic, service and action that no node uses: another package may at any time.

    Nodes that start only each other use nothing by themselves.

    A service whose callback may wait has as many callers as requests that it works on at once, at most
    `MOST_CALLERS`: together they may hold all threads.
    """
    wanted: dict[tuple[str, str], TopicEndpoint | Endpoint] = {}
    used = used_by_themselves(nodes, given)
    callers: dict[tuple[str, str], int] = {}
    for node in nodes:
        for role, other in _CALLERS.items():
            for each in getattr(node, other):
                wanted.setdefault((role, name_of(each)), each)
        for each in node.servers:
            said = given.node(node.name)
            waits = said.callback(each.name).may_wait
            callers["clients", each.name] = said.at_once(each.name) if waits else 1
    found = []
    for (role, name), each in wanted.items():
        if (role, name) in used:
            continue
        count = callers.get((role, name), 1)
        if count > MOST_CALLERS:
            left_out.append(
                f"callers of service {name} outside of this code: more than {MOST_CALLERS} at a time"
            )
        ports: dict[str, Any] = {role: (replace(each, at=""),)}
        for number in range(1, min(count, MOST_CALLERS) + 1):
            ending = f"_{number}" if number > 1 else ""
            found.append(ObservedNode(f"/unseen/{role.removesuffix('s')}{full_name(name)}{ending}", **ports))
    return found


_CALLERS = {"publishers": "subscribers", "clients": "servers", "action_clients": "action_servers"}
"""The users of the other end, by kind."""
MOST_CALLERS = 3
"""Invented callers of a service, at most: each multiplies the markings."""
