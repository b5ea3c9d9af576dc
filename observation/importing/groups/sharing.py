"""Joins nodes that share an executor into one node net: they share threads, and each keeps its groups."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from dineros.observation.importing.assuming import Taken, of_client
from dineros.observation.importing.flows.graphs import relabelled
from dineros.observation.importing.flows.labels import Ask, Flow, GivenVariable, Label, Received, Set, Step
from dineros.observation.importing.given import GivenCallback, GivenNode
from dineros.observation.systems import ObservedNode
from dineros.sources.facts import NodeFact

OF_NODES = "of_nodes_"
"""Begin of the names of callback groups that several nodes use."""


def free_name(wanted: str, used: Iterable[str]) -> str:
    """Return a name that is not used yet."""
    names, found, number = set(used), wanted or "callback", 2
    while found in names:
        found, number = f"{wanted}_{number}", number + 1
    return found


def share_executors(
    kept: Iterable[tuple[NodeFact, str]],
    nodes: dict[str, ObservedNode],
    given: dict[str, GivenNode],
    taken: Taken,
) -> None:
    """Join nodes that share an executor: they share its threads, and each keeps a group of its own."""
    pools: dict[tuple[str, int], list[str]] = {}
    for fact, name in kept:
        if fact.pool:
            pools.setdefault((fact.program, fact.pool), []).append(name)
    for names in pools.values():
        if len(names) > 1:
            _join(names, nodes, given, taken)


def _regrouped(
    steps: tuple[Step, ...] | None, own: str, renamed: Mapping[str, str]
) -> tuple[Step, ...] | None:
    """Return steps whose clients are in the groups of a joined node."""
    return None if steps is None else tuple(_of_group(step, own, renamed) for step in steps)


def _of_group(step: Step, own: str, renamed: Mapping[str, str]) -> Step:
    return step if step.group is None else replace(step, group=renamed.get(step.group, own))


def _moved(
    flow: Flow | None, own: str, groups: Mapping[str, str], variables: Mapping[str, str]
) -> Flow | None:
    """Return a flow in a joined node."""

    def change(label: Label) -> Label:
        if isinstance(label, Step):
            return _of_group(label, own, groups)
        if isinstance(label, (Set, Ask)):
            return replace(label, variable=variables[label.variable])
        return label

    return None if flow is None else relabelled(flow, change)


def _received(received: Received | None, move: Callable[[Flow | None], Flow | None]) -> Received | None:
    """Return the branches of a callback by its message, with the names of the joined node."""
    if received is None:
        return None
    moved = [(value, move(branch)) for value, branch in received.branches]
    return replace(received, branches=tuple((value, flow) for value, flow in moved if flow is not None))


def _heard(names: list[str], nodes: Mapping[str, ObservedNode]) -> dict[str, ObservedNode] | None:
    """Return nodes whose subscriptions of one topic have distinct keys; None: no topic has several."""
    read: set[str] = set()
    found: dict[str, ObservedNode] = {}
    for name in names:
        ports = nodes[name].subscribers
        keyed = tuple(replace(port, reader=name) if port.topic in read else port for port in ports)
        read |= {port.topic for port in ports}
        if any(port.reader for port in keyed):
            found[name] = replace(nodes[name], subscribers=keyed)
    return found or None


def _waits(names: list[str], given: Mapping[str, GivenNode]) -> bool:
    """Return whether a callback waits for a message of a topic, so that its subscription matters."""
    callbacks = (each for name in names for each in given[name].callbacks.values())
    return any(step.verb == "wait" for each in callbacks for step in each.does or ())


def _join(
    names: list[str], nodes: dict[str, ObservedNode], given: dict[str, GivenNode], taken: Taken
) -> None:
    asked = [port.name for name in names for port in (*nodes[name].clients, *nodes[name].action_clients)]
    heard = _heard(names, nodes)
    if len(asked) != len(set(asked)) or (heard is not None and _waits(names, given)):
        taken.lack(
            f"nodes {', '.join(names)} share an executor; they are treated as nodes with an executor each"
        )
        given.update({name: replace(given[name], order=None) for name in names})
        return
    first = names[0]
    nodes |= heard or {}
    ports: dict[str, Any] = {
        role: tuple(port for name in names for port in getattr(nodes[name], role))
        for role in ("publishers", "subscribers", "servers", "clients", "action_servers", "action_clients")
    }
    orders = {given[name].order for name in names}
    joined = GivenNode(
        at=given[first].at,
        threads=given[first].threads,
        open_threads=given[first].open_threads,
        is_shared=True,
        answers_hold_groups=given[first].answers_hold_groups,
        order="rclcpp" if orders == {"rclcpp"} else None,  # rclpy takes callbacks node by node
    )
    groups: dict[str, str] = {}
    timers: dict[str, float] = {}
    callbacks: dict[str, GivenCallback] = {}
    newest: dict[str, bool] = {}
    open_timers: set[str] = set()
    variables: dict[str, GivenVariable] = {}
    for name in names:
        own = free_name(f"of_{name.strip('/').replace('/', '_')}", groups)
        groups[own] = "exclusive"
        keys = {port.topic: port.given_as for port in nodes[name].subscribers}
        renamed = {
            group: group if group.startswith(OF_NODES) else free_name(group, groups)
            for group in given[name].groups
        }
        groups |= {renamed[group]: kind for group, kind in given[name].groups.items()}
        known = {each: free_name(each, variables) for each in given[name].variables}
        variables |= {known[each]: variable for each, variable in given[name].variables.items()}
        move = partial(_moved, own=own, groups=renamed, variables=known)
        for topic, callback in given[name].callbacks.items():
            key = keys.get(topic, topic)
            group = own if callback.group is None else renamed.get(callback.group, callback.group)
            at = key if key.startswith("/") else free_name(key, timers)
            if at in callbacks and key.startswith("/"):  # one serves what another calls
                is_client = any(
                    key == port.name for port in (*nodes[name].clients, *nodes[name].action_clients)
                )
                if not is_client:
                    callbacks[of_client(key)] = callbacks[key]
                at = of_client(key) if is_client else key
            if not key.startswith("/"):
                timers[at] = (given[name].timers or {}).get(key, 1.0)
                if key in given[name].open_timers:
                    open_timers.add(at)
            callbacks[at] = replace(
                callback,
                group=group,
                does=_regrouped(callback.does, own, renamed),
                flow=move(callback.flow),
                accepted=move(callback.accepted),
                rejected=move(callback.rejected),
                received=_received(callback.received, move),
            )
        newest |= {keys.get(topic, topic): each for topic, each in given[name].newest.items()}
    given[first] = replace(
        joined,
        groups=groups,
        timers=timers,
        callbacks=callbacks,
        newest=newest,
        open_timers=frozenset(open_timers),
        variables=variables,
    )
    nodes[first] = replace(nodes[first], **ports)
    for name in names[1:]:
        del nodes[name], given[name]
    taken.add(f"nodes {', '.join(names)} share an executor: one node net, {first}, represents them")
