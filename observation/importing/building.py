"""A system model of a system that was seen: a node net for each node, a channel for each name."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.metamodel import sym
from dineros.observation.importing.assuming import Assumed
from dineros.observation.importing.channels import Channels
from dineros.observation.importing.given import Given
from dineros.observation.importing.nodes import NodeBuilder
from dineros.observation.importing.whole import whole
from dineros.observation.systems import ObservedSystem


@dataclass(frozen=True)
class Imported:
    """What an import made.

    Attributes
    ----------
    model : sym.SystemModel
        The model.
    assumed : tuple of Assumed
        What the source does not tell, and is taken.
    unseen : tuple of str
        Names of nodes that nobody has seen: they stand for whoever has the other end of a channel.
    left_out : tuple of str
        What was seen and a model cannot hold, a line each.
    recorded : tuple of str
        Recorded topics and services of which nothing is given: nobody knows whose they are.
    unused : tuple of str
        Names of nodes, topics and services that something is given of, and that were not seen.
    """

    model: sym.SystemModel
    assumed: tuple[Assumed, ...]
    unseen: tuple[str, ...]
    left_out: tuple[str, ...]
    recorded: tuple[str, ...]
    unused: tuple[str, ...]


def to_model(system: ObservedSystem, given: Given | None = None, id: str = "observed") -> Imported:
    """Return a system model of what was seen.

    Each node is a node net that runs callbacks: subscriptions, services, goals and timers are callback pages,
    whose behaviour is open (`dineros.observation.importing.bodies`) unless it is given.

    Parameters
    ----------
    system : ObservedSystem
        What was seen.
    given : Given, optional
        What people say of it.
    id : str
        Id of the model.

    Raises
    ------
    DinerosError
        What is given of a node speaks of ports that it does not have.
    """
    given = given or Given()
    found = whole(system, given)
    channels, assumed = Channels(), list[Assumed]()
    channels.ids.new(id)
    model = sym.SystemModel(id=id, middleware="ros2")
    for node in found.nodes:
        builder = NodeBuilder(node, given, channels, node.name in found.unseen, system.is_partial)
        model.pages.append(builder.build())
        assumed += builder.assumed
    model.channels.extend(channels.all())
    names = {node.name for node in found.nodes}
    topics = {topic.name for topic in system.topics}
    services = {service.name for service in system.services}
    unused = (
        *(set(given.nodes) - names),
        *(set(given.topics) - topics),
        *(set(given.services) - services),
    )
    return Imported(
        model,
        tuple(assumed),
        tuple(sorted(found.unseen)),
        found.left_out,
        (*sorted(topics - set(given.topics)), *sorted(services - set(given.services))),
        tuple(sorted(unused)),
    )
