"""Builds a system model of an observed system: a node net for each node, a channel for each name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from dineros.metamodel import pn, sym
from dineros.metamodel.build import seconds
from dineros.metamodel.elements import is_unseen, node_net_of
from dineros.metamodel.errors import printable
from dineros.observation.importing.assuming import Assumed
from dineros.observation.importing.channels import Channels
from dineros.observation.importing.flows.fields import certain
from dineros.observation.importing.given import Given, GivenService, GivenTopic, Span
from dineros.observation.importing.nodes import NodeBuilder
from dineros.observation.importing.whole.system import whole
from dineros.observation.systems import ObservedSystem


@dataclass(frozen=True)
class Imported:
    """The result of an import."""

    model: sym.SystemModel
    assumed: tuple[Assumed, ...]
    """Assumptions about facts that the source does not have."""
    unseen: tuple[str, ...]
    """Names of invented nodes: they represent unknown nodes at the other end of a channel."""
    left_out: tuple[str, ...]
    """What was observed and cannot be modelled, a line each."""
    recorded: tuple[str, ...]
    """Recorded topics and services without given facts: their nodes are unknown."""
    unused: tuple[str, ...]
    """Names of nodes, topics and services that something is given of, and that were not seen."""


def to_model(
    system: ObservedSystem, given: Given | None = None, id: str = "observed", lacks: Iterable[str] = ()
) -> Imported:
    """Return a system model of an observed system.

    Each node is a node net that runs callbacks: subscriptions, services, goals and timers are callback pages,
    whose behaviour is open (`dineros.observation.importing.bodies`) unless it is given.

    Parameters
    ----------
    system : ObservedSystem
        What was seen.
    given : Given, optional
        Hand-written facts about it.
    id : str
        Id of the model.
    lacks : iterable of str
        What the system has and its description lacks or presumes, a line each; the model states it, together
        with what the model cannot hold.

    Raises
    ------
    DinerosError
        The given facts of a node name ports that it does not have.
    """
    given = given or Given()
    found = whole(system, given)
    channels, assumed = Channels(certain(given.deciding, found.nodes, system.nodes, given)), list[Assumed]()
    channels.ids.new(id)
    model = sym.SystemModel(id=id, middleware="ros2")
    if given.latency is not None or given.takes is not None:
        model.times = sym.DefaultTimes(latency=_interval(given.latency), duration=_interval(given.takes))
    for node in found.nodes:
        builder = NodeBuilder(node, given, channels, node.name in found.unseen, system.is_partial)
        model.pages.append(builder.build())
        assumed += builder.assumed
    for service in channels.services.values():
        if service.clients and all(is_unseen(node_net_of(each.request)) for each in service.clients):
            # Each invented caller has one request at a time: more instances only cost markings.
            service.instances = min(service.instances or 1, len(service.clients))
    model.channels.extend(channels.all())
    model.otherTokenTypes.extend(channels.types.values())
    for name, text in given.properties.items():
        model.properties.append(sym.Property(id=channels.ids.new(name), text=text))
    for line in (*lacks, *found.left_out):
        model.assumptions.append(sym.SourceAssumption(id=channels.ids.new("source"), text=printable(line)))
    names = {node.name for node in found.nodes}
    topics = {topic.name for topic in system.topics}
    services = {service.name for service in system.services}
    unused = (
        *(set(given.nodes) - names),
        *_latencies(given.topics, channels.topics, topics),
        *_latencies(given.services, channels.services, services),
        *_latencies(given.actions, channels.actions, set()),
    )
    return Imported(
        model,
        tuple(assumed),
        tuple(sorted(found.unseen)),
        found.left_out,
        (*sorted(topics - set(given.topics)), *sorted(services - set(given.services))),
        tuple(sorted(unused)),
    )


def _latencies(
    given: Mapping[str, GivenTopic | GivenService], made: Mapping[str, sym.Channel], recorded: set[str]
) -> set[str]:
    """Set the latencies of channels; return the names whose given facts are not used.

    Given ends are used for recorded channels only: for others, they are known from the nodes.
    """
    for name, said in given.items():
        if said.latency is not None and name in made:
            made[name].latency = _interval(said.latency)
    return {
        name
        for name, said in given.items()
        if name not in recorded and (name not in made or said.latency is None)
    }


def _interval(span: Span | None) -> pn.TimeInterval | None:
    return None if span is None else seconds(*span)
