"""Compares a model with an observed system."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any

from dineros.analysis.witnesses.findings import Fault, Finding, Report
from dineros.metamodel import sym
from dineros.metamodel.errors import near_matches
from dineros.metamodel.matching import Quality, shown
from dineros.observation.differences.described import Described, described
from dineros.observation.systems import (
    Endpoint,
    ObservedNode,
    ObservedSystem,
    TopicEndpoint,
    full_name,
    name_of,
    within,
)

NO_NODE = Fault("node-missing", "error", "A node of the model is missing.", "node {node} is missing{near}")
MORE_NODES = Fault(
    "node-extra", "error", "A node exists that the model does not have.", "the model has no node {node}"
)
NO_PORT = Fault(
    "port-missing",
    "error",
    "A node lacks a port that it has in the model.",
    "node {node} has no {role} {name}{near}",
)
MORE_PORTS = Fault(
    "port-extra",
    "error",
    "A node has a port that it does not have in the model.",
    "node {node} has the {role} {name}, which the model does not have",
)
TYPE = Fault(
    "type-differs",
    "error",
    "A port has another type than in the model.",
    "the {role} {name} of node {node} has the type {found}; in the model {expected}",
)
QUALITY = Fault(
    "quality-differs",
    "error",
    "A port has another quality of service than in the model.",
    "the {role} {name} of node {node} has the {policy} {found}; in the model {expected}",
)
MANAGED = Fault(
    "lifecycle-differs",
    "error",
    "A node is managed only in the model, or only in the observed system.",
    "node {node} is {found}; in the model it is {expected}",
)
NOT_RECORDED = Fault(
    "topic-not-recorded",
    "note",
    "A topic of the model is not in the recording.",
    "topic {topic} is not in the recording",
)
MORE_TOPICS = Fault(
    "topic-extra",
    "error",
    "A topic was recorded that the model does not have.",
    "the model has no topic {topic}{near}",
)
NO_EVENTS = Fault(
    "service-not-recorded",
    "note",
    "The recording contains no calls of a service of the model.",
    "the recording contains no calls of service {service}",
)
MORE_SERVICES = Fault(
    "service-extra",
    "error",
    "A service was recorded that the model does not have.",
    "the model has no service {service}{near}",
)
RECORDED_SERVICE = Fault(
    "type-differs",
    "error",
    TYPE.meaning,
    "service {service} was recorded with the type {found}; in the model it has {expected}",
)
RECORDED_TYPE = Fault(
    "type-differs",
    "error",
    TYPE.meaning,
    "topic {topic} was recorded with the type {found}; in the model it has {expected}",
)
RECORDED_QUALITY = Fault(
    "quality-differs",
    "error",
    QUALITY.meaning,
    "a publisher of {topic} was recorded that matches no publisher of the model: {found}",
)

FAULTS = {
    fault.rule: fault
    for fault in (
        *(NO_NODE, MORE_NODES, NO_PORT, MORE_PORTS, TYPE, QUALITY),
        MANAGED,
        *(NOT_RECORDED, MORE_TOPICS, NO_EVENTS, MORE_SERVICES),
    )
}
"""All of them, by name."""

ROLES = {
    "publishers": "publisher of",
    "subscribers": "subscription to",
    "servers": "server of",
    "clients": "client of",
    "action_servers": "server of action",
    "action_clients": "client of action",
}
"""Names of the kinds of ports, by the attribute of `ObservedNode`."""


def differences(
    model: sym.SystemModel,
    system: ObservedSystem,
    namespaces: Sequence[str] = (),
    without: Sequence[str] = (),
) -> Report:
    """Return the differences between a system and a model; nodes and topics that agree are proved.

    Parameters
    ----------
    system : ObservedSystem
        The observed system: nodes with their ports, or only topics and services.
    namespaces : sequence of str
        Only nodes in these are compared; all where there are none.
    without : sequence of str
        Full names of nodes that are left out.
    """
    is_recorded = bool(system.topics or system.services)
    said, report = described(model, with_unseen=is_recorded), Report()
    expected = within(said.system, namespaces, without)
    if is_recorded:
        _compare_topics(expected, system, report, said)
        _compare_services(expected, system, report, said)
    else:
        compare_nodes(expected, within(system, namespaces, without), report, said)
    return report


def compare_nodes(expected: ObservedSystem, found: ObservedSystem, report: Report, said: Described) -> None:
    """Add the differences between observed and expected nodes to a report."""
    there, wanted = ({node.name: node for node in system.nodes} for system in (found, expected))
    there = {name: node for name, node in there.items() if name not in found.departed}
    for name, node in wanted.items():
        id = said.elements[name, "", ""]
        if name not in there:
            near = _near(name, [other for other in there if other not in wanted])
            report.findings.append(NO_NODE.found(id, node=name, near=near))
            continue
        findings = list(_compare_node(node, there[name], said))
        report.findings += findings
        if not findings:
            report.proved.append(f"node {name} is as in the model")
    for name in there:
        if name not in wanted:
            report.findings.append(MORE_NODES.found(name, node=name))


def _compare_node(wanted: ObservedNode, there: ObservedNode, said: Described) -> Iterator[Finding]:
    is_managed = wanted.name in said.managed
    if is_managed != (there.lifecycle is not None):
        states = "not managed", "managed"
        yield MANAGED.found(
            said.elements[wanted.name, "", ""],
            node=wanted.name,
            found=states[not is_managed],
            expected=states[is_managed],
        )
    for role, words in ROLES.items():
        expected, found = (_by_name(getattr(node, role)) for node in (wanted, there))
        for name in sorted({*expected, *found}):
            id = said.elements.get((wanted.name, role, name), said.elements[wanted.name, "", ""])
            common: dict[str, Any] = {"node": wanted.name, "role": words, "name": name}
            pairs = _paired(expected[name], found[name])
            for one, other in pairs:
                if other is None:
                    near = _near(name, [each for each in found if each not in expected])
                    yield NO_PORT.found(id, name, near=near, **common)
                elif one is None:
                    yield MORE_PORTS.found(id, name, **common)
                elif one.type != other.type:
                    yield TYPE.found(id, name, found=other.type, expected=one.type, **common)
                elif isinstance(one, TopicEndpoint) and isinstance(other, TopicEndpoint):
                    for policy, wants, has in _policies(one, other):
                        yield QUALITY.found(id, name, policy=policy, found=has, expected=wants, **common)


Port = TopicEndpoint | Endpoint


def _by_name(ports: Sequence[Port]) -> dict[str, list[Port]]:
    found: dict[str, list[Port]] = defaultdict(list)
    for port in ports:
        found[name_of(port)].append(port)
    return found


def _paired(wanted: list[Port], there: list[Port]) -> Iterator[tuple[Port | None, Port | None]]:
    """Yield ports of one name in pairs: equal ones first, then the rest in order."""
    rest = list(there)
    alone = []
    for port in wanted:
        same = next((other for other in rest if _is_same(port, other)), None)
        if same is None:
            alone.append(port)
        else:
            rest.remove(same)
    for number in range(max(len(alone), len(rest))):
        yield (
            alone[number] if number < len(alone) else None,
            rest[number] if number < len(rest) else None,
        )


def _is_same(one: Port, other: Port) -> bool:
    if one.type != other.type:
        return False
    if isinstance(one, TopicEndpoint) and isinstance(other, TopicEndpoint):
        return not any(_policies(one, other))
    return True


def _policies(wanted: TopicEndpoint, there: TopicEndpoint) -> Iterator[tuple[str, str, str]]:
    """Yield the policies that differ, with expected and found values; depths only if both are known."""
    yield from _of_quality(wanted.quality, there.quality)
    if None not in (wanted.depth, there.depth) and wanted.depth != there.depth:
        yield "depth", str(wanted.depth), str(there.depth)


def _of_quality(wanted: Quality, there: Quality) -> Iterator[tuple[str, str, str]]:
    for policy, one, other in zip(Quality._fields, wanted, there, strict=True):
        if isinstance(one, float) and isinstance(other, float) and math.isclose(one, other, rel_tol=1e-6):
            continue
        if one != other:
            yield policy.replace("_", " "), shown(one), shown(other)


def _compare_topics(expected: ObservedSystem, found: ObservedSystem, report: Report, said: Described) -> None:
    """Compare recorded topics: a recording does not show to which nodes they belong."""
    wanted: dict[str, list[tuple[str, TopicEndpoint]]] = defaultdict(list)
    for role in ("publishers", "subscribers"):
        for node, endpoint in expected.ports(role):
            wanted[endpoint.topic].append((said.elements[node.name, role, endpoint.topic], endpoint))
    offered: dict[str, list[Quality]] = defaultdict(list)
    for _, endpoint in expected.publishers():
        offered[endpoint.topic].append(endpoint.quality)
    recorded = {full_name(topic.name) for topic in found.topics}
    for topic in found.topics:
        name = full_name(topic.name)
        if name not in wanted:
            near = _near(name, [each for each in wanted if each not in recorded])
            report.findings.append(MORE_TOPICS.found(topic.name, topic=topic.name, near=near))
            continue
        findings = []
        id, endpoint = wanted[name][0]
        if topic.type != endpoint.type:
            findings.append(
                RECORDED_TYPE.found(
                    *(id, topic.name), topic=topic.name, found=topic.type, expected=endpoint.type
                )
            )
        for quality in topic.offered:
            known = offered[name]
            if known and all(any(_of_quality(each, quality)) for each in known):
                least = min((list(_of_quality(each, quality)) for each in known), key=len)
                words = "; ".join(f"{policy} {has}, in the model {wants}" for policy, wants, has in least)
                findings.append(RECORDED_QUALITY.found(id, topic.name, topic=topic.name, found=words))
        report.findings += dict.fromkeys(findings)
        if not findings:
            report.proved.append(f"topic {topic.name} is as in the model")
    for name in sorted(set(wanted) - recorded):
        report.findings.append(NOT_RECORDED.found(wanted[name][0][0], topic=name))


def _compare_services(
    expected: ObservedSystem, found: ObservedSystem, report: Report, said: Described
) -> None:
    """Compare services with recorded events; without any events, introspection was not configured."""
    if not found.services:
        return
    wanted = {
        each.name: (said.elements[node.name, role, each.name], each.type)
        for role in ("clients", "servers")
        for node, each in expected.ports(role)
    }
    recorded = {service.name for service in found.services}
    for service in found.services:
        name = service.name
        if name not in wanted:
            near = _near(name, [each for each in wanted if each not in recorded])
            report.findings.append(MORE_SERVICES.found(name, service=name, near=near))
            continue
        id, type = wanted[name]
        if service.type != type:
            report.findings.append(
                RECORDED_SERVICE.found(*(id, name), service=name, found=service.type, expected=type)
            )
        else:
            report.proved.append(f"service {name} is as in the model")
    for name in sorted(set(wanted) - recorded):
        report.findings.append(NO_EVENTS.found(wanted[name][0], service=name))


def _near(name: str, others: Sequence[str]) -> str:
    hint = near_matches(name, others)
    return f" ({hint})" if hint else ""
