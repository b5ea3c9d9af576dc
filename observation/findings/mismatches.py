"""Faults that are visible from ports: publishers and subscriptions, clients and servers, nodes and names."""

from __future__ import annotations

import difflib
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.metamodel.errors import listed
from dineros.metamodel.matching import shown, unmet
from dineros.observation.systems import (
    Endpoint,
    ObservedNode,
    ObservedSystem,
    TopicEndpoint,
    is_house_topic,
    name_of,
)

QUALITY = Fault(
    "quality-not-matched",
    "error",
    "A subscription requests a stricter quality of service than a publisher offers: it receives nothing from "
    "it.",
    "{subscriber} receives nothing on {topic} from {publisher}: the {policy} of {publisher} is {offered}, "
    "and {subscriber} requests {requested}",
)
TYPE = Fault(
    "types-differ",
    "error",
    "Nodes use one name with different types: they do not communicate.",
    "{name} has different types: {types}",
)
UNHEARD = Fault(
    "topic-unheard",
    "warning",
    "No node subscribes to a topic.",
    "no node subscribes to {topic}, which {nodes} publishes",
)
UNFILLED = Fault(
    "topic-unfilled",
    "warning",
    "No node publishes a topic that a node subscribes to.",
    "no node publishes {topic}, to which {nodes} subscribes",
)
NEAR = Fault(
    "names-near",
    "warning",
    "Two names are similar, and each has one end only: one of them may be misspelt.",
    "{first}, of {givers}, and {second}, of {takers}, are similar: one may be misspelt",
)
UNSERVED = Fault(
    "service-unserved",
    "warning",
    "A node calls a service or action that no node serves.",
    "no node serves {name}, which {nodes} calls",
)
SERVERS = Fault(
    "servers-share-name",
    "error",
    "Several nodes serve one name: it is not determined which of them answers.",
    "{name} has several servers: {nodes}",
)
DOUBLE = Fault(
    "nodes-share-name", "error", "Several nodes have one name.", "there is more than one node {node}"
)
TIME = Fault(
    "time-mixed",
    "warning",
    "Some nodes use simulated time, and others do not.",
    "{simulated} uses simulated time, and {real} does not",
)
DEPARTED = Fault(
    "node-departed",
    "warning",
    "A node disappeared while the graph was watched.",
    "{node} disappeared while the graph was watched: the model has what was seen of it",
)

FAULTS = {
    fault.rule: fault
    for fault in (QUALITY, TYPE, UNHEARD, UNFILLED, NEAR, UNSERVED, SERVERS, DOUBLE, TIME, DEPARTED)
}
"""All of them, by name."""

ENDS = frozenset({UNHEARD.rule, UNFILLED.rule, UNSERVED.rule, NEAR.rule})
"""Rules for names with one end only."""

_EACH_SERVES = (
    *("describe_parameters", "get_parameters", "get_parameter_types", "list_parameters"),
    *("set_parameters", "set_parameters_atomically"),
)
"""Services that the library makes for each node."""
_MANAGED_SERVES = (
    *("change_state", "get_state", "get_available_states", "get_available_transitions"),
    "get_transition_graph",
)
"""Services that the library makes for each managed node."""
_NEAR = 0.8
"""Least similarity of two names that nearly match, by `difflib.SequenceMatcher`; 1: equal."""
_MOST_COMPARED = 200
"""Limit of the names that are compared with each other: the time grows with the square."""


def mismatches(system: ObservedSystem) -> list[Finding]:
    """Return the faults of a system that do not depend on the behaviour of its nodes.

    The elements of a finding are full names of ROS: of the topic, service or node, then of the nodes.
    """
    return [*_of_nodes(system), *_of_topics(system), *_of_services(system)]


def of_part(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings of a system of which only a part is known, for a check of its model.

    That a name has no other end is a note: drivers and tools are elsewhere. Quality of service is left to the
    check, which says how to fix it.
    """
    return [
        replace(finding, severity="note") if finding.rule in ENDS else finding
        for finding in findings
        if finding.rule != QUALITY.rule
    ]


def of_separate_programs(findings: Iterable[Finding], programs: Mapping[str, str]) -> list[Finding]:
    """Return the findings of programs for which it is unknown whether they run together.

    Several programs that serve the same names may be alternatives, such as a robot and its simulation: one
    note names all of these programs and names. Nodes of one program run together.

    Parameters
    ----------
    findings : iterable of Finding
        Of all programs, as if they ran together.
    programs : mapping of str to str
        The program of each node.
    """
    kept: list[Finding] = []
    shared: dict[tuple[str, ...], list[str]] = {}
    for finding in findings:
        name, *nodes = finding.elements
        if finding.rule == SERVERS.rule and len({programs.get(node, node) for node in nodes}) == len(nodes):
            shared.setdefault(tuple(nodes), []).append(name)
        else:
            kept.append(finding)
    for together, names in shared.items():
        found = SERVERS.found(*names, *together, name=listed(names), nodes=listed(together))
        message = f"{found.message}; this matters if they run together: --launch FILE says what runs"
        kept.append(replace(found, severity="note", message=message))
    return kept


def _of_nodes(system: ObservedSystem) -> Iterator[Finding]:
    for name in system.duplicates:
        yield DOUBLE.found(name, node=name)
    for name in system.departed:
        yield DEPARTED.found(name, node=name)
    simulated = [node.name for node in system.nodes if node.use_sim_time]
    real = [node.name for node in system.nodes if node.use_sim_time is False]
    if simulated and real:
        yield TIME.found(*simulated, *real, simulated=listed(simulated), real=listed(real))


Ends = dict[str, list[tuple[ObservedNode, Any]]]
"""By name of topic, service or action: the ports, each with its node."""


def _of_topics(system: ObservedSystem) -> Iterator[Finding]:
    publishers, subscribers = _by_name(system, "publishers"), _by_name(system, "subscribers")
    for topic in sorted({*publishers, *subscribers}):
        yield from _of_types(topic, [*publishers[topic], *subscribers[topic]])
        for sender, offer in publishers[topic]:
            for receiver, request in subscribers[topic]:
                policy = unmet(offer.quality, request.quality)
                if policy is not None and offer.type == request.type:
                    yield QUALITY.found(
                        *(topic, sender.name, receiver.name),
                        topic=topic,
                        publisher=sender.name,
                        subscriber=receiver.name,
                        policy=policy.replace("_", " "),
                        offered=shown(getattr(offer.quality, policy)),
                        requested=shown(getattr(request.quality, policy)),
                    )
    unheard = _without(subscribers, publishers)
    unfilled = _without(publishers, subscribers)
    yield from _of_names(unheard, unfilled)
    for topic, nodes in sorted(unheard.items()):
        yield UNHEARD.found(topic, *nodes, topic=topic, nodes=listed(nodes))
    for topic, nodes in sorted(unfilled.items()):
        yield UNFILLED.found(topic, *nodes, topic=topic, nodes=listed(nodes))


def _without(others: Ends, ends: Ends) -> dict[str, list[str]]:
    """Return the nodes at the topics that have one end only; ROS itself is at the other end of some."""
    return {
        topic: _names(found)
        for topic, found in ends.items()
        if found and not others[topic] and not is_house_topic(topic, found[0][1].type)
    }


def _of_types(name: str, ends: Iterable[tuple[ObservedNode, TopicEndpoint | Endpoint]]) -> Iterator[Finding]:
    ends = list(ends)
    types: dict[str, list[str]] = defaultdict(list)
    for node, endpoint in ends:
        if node.name not in types[endpoint.type]:
            types[endpoint.type].append(node.name)
    if len(types) > 1:
        said = "; ".join(f"{type} at {listed(nodes)}" for type, nodes in types.items())
        nodes = dict.fromkeys(node for nodes in types.values() for node in nodes)
        found = TYPE.found(name, *nodes, name=name, types=said)
        if len(nodes) == 1 and all(getattr(endpoint, "is_optional", False) for _, endpoint in ends):
            words = "the code creates each of them in a branch, perhaps never two of them in one run"
            found = replace(found, severity="warning", message=f"{found.message}; {words}")
        yield found


def _of_services(system: ObservedSystem) -> Iterator[Finding]:
    by_library = {
        f"{node.name}/{service}"
        for node in system.nodes
        for service in (*_EACH_SERVES, *(_MANAGED_SERVES if node.lifecycle is not None else ()))
    }
    for servers, clients in (("servers", "clients"), ("action_servers", "action_clients")):
        served, called = _by_name(system, servers), _by_name(system, clients)
        for name in sorted({*served, *called}):
            yield from _of_types(name, [*served[name], *called[name]])
            if len(served[name]) > 1:
                nodes = [node.name for node, _ in served[name]]
                yield SERVERS.found(name, *nodes, name=name, nodes=listed(nodes))
        unserved = {
            name: _names(ends)
            for name, ends in called.items()
            if ends and not served[name] and name not in by_library
        }
        uncalled = {name: _names(ends) for name, ends in served.items() if ends and not called[name]}
        yield from _of_names(uncalled, unserved)
        for name, nodes in sorted(unserved.items()):
            yield UNSERVED.found(name, *nodes, name=name, nodes=listed(nodes))


def _of_names(givers: Mapping[str, list[str]], takers: Mapping[str, list[str]]) -> Iterator[Finding]:
    """Yield names without a receiver that are similar to names without a sender, with the nodes of each."""
    for first, second in _near(givers, takers):
        if givers[first] == takers[second] and len(givers[first]) == 1:
            continue  # an input and an output of one node
        yield NEAR.found(
            *(first, second, *givers[first], *takers[second]),
            first=first,
            second=second,
            givers=listed(givers[first]),
            takers=listed(takers[second]),
        )


def _by_name(system: ObservedSystem, role: str) -> Ends:
    found: Ends = defaultdict(list)
    for node, port in system.ports(role):
        found[name_of(port)].append((node, port))
    return found


def _names(ends: Iterable[tuple[ObservedNode, object]]) -> list[str]:
    return list(dict.fromkeys(node.name for node, _ in ends))


def _near(givers: Iterable[str], takers: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield pairs of names that nearly match, or differ in their namespace only.

    If more names have the same end, it is a usual one, such as ``image_raw``: only namespaces are compared.
    """
    ends = Counter(each.rpartition("/")[2] for each in (*givers, *takers))
    for first in sorted(givers)[:_MOST_COMPARED]:
        for second in sorted(takers)[:_MOST_COMPARED]:
            (one, _, end), (other, _, other_end) = first.rpartition("/"), second.rpartition("/")
            is_usual = end == other_end and ends[end] > 2
            texts = (one, other) if is_usual else (first, second)
            matcher = difflib.SequenceMatcher(None, texts[0].lower(), texts[1].lower())
            is_near = matcher.quick_ratio() >= _NEAR and matcher.ratio() >= _NEAR
            if is_near or (end == other_end and not is_usual):
                yield first, second
