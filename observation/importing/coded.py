"""Converts the facts of code to an observed system and given facts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from dineros.observation.importing.assuming import Taken
from dineros.observation.importing.correcting import merged
from dineros.observation.importing.flows.fields import deciding_fields, deciding_responses
from dineros.observation.importing.given import Given, GivenNode
from dineros.observation.importing.groups.sharing import share_executors
from dineros.observation.importing.groups.threads import lacks_of_threads
from dineros.observation.importing.of_code.behaviour import behaviour_of
from dineros.observation.importing.of_code.node import CodedNode
from dineros.observation.importing.of_code.ports import ports_of
from dineros.observation.systems import ObservedNode, ObservedSystem
from dineros.sources.alternatives import taken_of, types_of
from dineros.sources.facts import Effect, Facts, NodeFact
from dineros.sources.interfaces import Interfaces
from dineros.sources.libraries.requested import waits_in_transition, with_requested


@dataclass(frozen=True)
class Coded:
    """A system described by code."""

    system: ObservedSystem
    """Its nodes and their ports."""
    given: Given
    """Behaviour, groups and threads from the code."""
    taken: tuple[str, ...]
    """Assumptions about facts that the code does not determine, a line each."""
    apart: ObservedSystem
    """The nodes before those that share an executor are joined."""
    lacks: tuple[str, ...] = ()
    """What the model lacks, a line each: what could not be read, ports and nodes that are left out, waits
    that are not modelled. Proofs about the model may not hold for the code.
    """
    programs: Mapping[str, str] = field(default_factory=dict)
    """The program of each node."""
    modelled: frozenset[Effect] = frozenset()
    """Waits of loops that the model has by variables: findings about them come from the model."""

    def with_people(self, said: Given) -> Given:
        """Return the facts of the code, overridden by facts that users give."""
        return merged(self.given, said)

    def lacks_of_threads(self, said: Given) -> tuple[str, ...]:
        """Return the assumed numbers of threads on which answers may depend, a line for each."""
        return lacks_of_threads(self.system, said)


def coded(read: Iterable[tuple[str, Facts]], source: str) -> Coded:
    """Return the system described by the facts of folders.

    Parameters
    ----------
    read : iterable of (str, Facts)
        Each folder with its facts; lines of code are reported with the folder.
    source : str
        The folders, in words.
    """
    nodes: dict[str, ObservedNode] = {}
    given: dict[str, GivenNode] = {}
    taken = Taken()
    kept: list[tuple[NodeFact, str]] = []
    read = list(read)
    coded_nodes = [
        CodedNode(with_requested(fact), taken, folder) for folder, facts in read for fact in facts.nodes
    ]
    _lack_transitions(coded_nodes, taken)
    types = types_of(each.names for each in coded_nodes)
    named = [(one.fact, one.names) for one in coded_nodes]
    interfaces = Interfaces()
    for _, facts in read:
        interfaces.add(facts.interfaces)
    deciding = {**deciding_fields(named, interfaces), **deciding_responses(named, interfaces)}
    for number, one in enumerate(coded_nodes):
        fact = one.fact
        one.chosen = taken_of(one.names, number, types)
        one.deciding = deciding
        if one.name in nodes:
            taken.lack(
                f"{one.at(fact.at)}: node {one.name} of {fact.program} is omitted: another node has this name"
            )
            continue
        for place, words in fact.others:
            taken.add(f"{one.at(place)}: {words}")
        for place, path in fact.lent_to:
            words = "code outside of the folder, gets the node and may use it; omitted in the model"
            taken.lack(f"{one.at(place)}: {path}, {words}")
        nodes[one.name], given[one.name] = ports_of(one), behaviour_of(one)
        kept.append((fact, one.name))
    apart = ObservedSystem(source, tuple(nodes[name] for name in sorted(nodes)))
    share_executors(kept, nodes, given, taken)
    ordered = tuple(nodes[name] for name in sorted(nodes))
    system = ObservedSystem(source, ordered, is_partial=True)
    lacks = (*unread(read), *taken.lacks)
    programs = {name: fact.program or name for fact, name in kept}
    modelled = frozenset(wait for one in coded_nodes for wait in one.modelled)
    return Coded(system, Given(given, deciding=deciding), taken.lines, apart, lacks, programs, modelled)


def _lack_transitions(nodes: Iterable[CodedNode], taken: Taken) -> None:
    """Name clients of transitions that wait themselves: in the model, the response comes at any time."""
    nodes = list(nodes)
    clients = {name: one.name for one in nodes for each, name in one.names.items() if each.kind == "clients"}
    for one in nodes:
        client = clients.get(f"{one.name}/change_state")
        waiting = [each for each in one.fact.callbacks if waits_in_transition(each)]
        if client is not None and one.fact.managed and waiting:
            names = ", ".join(each.name for each in waiting)
            words = f"{client} requests transitions of {one.name}, and {names} waits, too; in the model, "
            taken.lack(f"{one.at(waiting[0].at)}: {words}the response may come before that")


def unread(read: Iterable[tuple[str, Facts]]) -> tuple[str, ...]:
    """Return what could not be read in folders, a line each."""
    return tuple(
        f"not read: {line}" if folder == "." else f"not read: {folder}/{line}"
        for folder, facts in read
        for line in facts.unread
    )
