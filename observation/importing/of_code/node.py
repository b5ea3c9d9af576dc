"""The names of a node in code and of its ports."""

from __future__ import annotations

from dataclasses import replace

from dineros.metamodel.ros_names import snake_case
from dineros.observation.importing.assuming import Taken
from dineros.observation.importing.flows.labels import Deciding
from dineros.observation.importing.groups.of_node import GroupsOfNode
from dineros.sources.facts import Effect, Entity, NodeFact, is_open
from dineros.sources.places import Place, located
from dineros.sources.resolving import full_name_of, full_node_name


class CodedNode:
    """The facts of one node with its resolved names.

    Parameters
    ----------
    taken : Taken
        Gets the assumptions.
    folder : str
        The folder of its files.
    """

    def __init__(self, fact: NodeFact, taken: Taken, folder: str) -> None:
        self.fact = fact
        self.folder = folder
        self.taken = taken
        name = fact.name
        if is_open(name):
            name = snake_case(fact.cls) or "node"
            taken.add(f"{self.at(fact.at)}: the name of the node is open; {name} is assumed")
            fact = self.fact = replace(fact, name=name)
        if is_open(fact.namespace):
            taken.lack(
                f"{self.at(fact.at)}: the namespace of node {name} is {fact.namespace}; none is assumed"
            )
        for source, target in fact.remappings.items():
            if is_open(source):
                words = f"a launch file gives a name of {name} the name {target}; which one is open"
                taken.lack(f"{self.at(fact.at)}: {words}")
        self.name = full_node_name(fact)
        """Full name of the node."""
        self.groups = GroupsOfNode(fact, taken, self.at)
        self.deciding: dict[str, Deciding] = {}
        """Fields of messages that decide what a callback does, by the name of the topic or service."""
        self.modelled: set[Effect] = set()
        """Waits of loops that the model has, because it has the variables that they ask for."""
        self.is_spun = fact.threads != "not spun"
        self.names: dict[Entity, str] = {}
        """Full names of its ports, and the empty text for entities without a name."""
        self.renamed: dict[Entity, str] = {}
        """For ports whose full name is open, why it is."""
        self.chosen: dict[tuple[str, str], Entity] = {}
        """The entity that is used, of those of one kind and name."""
        for entity in fact.entities:
            if entity.kind != "groups" and entity.is_enabled and not (entity.name and is_open(entity.name)):
                name = full_name_of(entity, fact) if entity.name else ""
                if is_open(name):
                    self.renamed[entity] = name
                else:
                    self.names[entity] = name

    def at(self, place: Place) -> str:
        """Return a line of code, with its folder."""
        return located(place, self.folder)
