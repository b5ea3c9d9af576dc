"""Converts the facts of code to an observed system and given facts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from dineros.metamodel.matching import Quality
from dineros.metamodel.ros_names import snake_case
from dineros.observation.importing.assuming import Taken, of_client
from dineros.observation.importing.correcting import merged
from dineros.observation.importing.flows.deciding import Decisions
from dineros.observation.importing.flows.fields import deciding_fields, deciding_responses
from dineros.observation.importing.flows.labels import Deciding, Received, Step
from dineros.observation.importing.given import Given, GivenCallback, GivenNode, OpenThreads
from dineros.observation.importing.groups.of_node import GroupsOfNode
from dineros.observation.importing.groups.sharing import free_name, share_executors
from dineros.observation.importing.groups.threads import lacks_of_threads, threads_in_code
from dineros.observation.importing.steps import Behaviour
from dineros.observation.importing.timing import order_of, sleeps_of, stops_of
from dineros.observation.systems import Endpoint, ObservedNode, ObservedSystem, TopicEndpoint
from dineros.sources.alternatives import taken_of, types_of
from dineros.sources.facts import CallbackFact, Entity, Facts, NodeFact, is_open
from dineros.sources.interfaces import Interfaces
from dineros.sources.libraries.requested import AT_ANY_TIME, waits_in_transition, with_requested
from dineros.sources.places import Place, located
from dineros.sources.resolving import full_name_of, full_node_name

_MIDDLEWARE = ("system default", "best available")
"""Qualities that the middleware decides."""
MAIN = "main"
"""Name of the timer that represents the actions of a node outside of callbacks."""
_ASK = ("clients", "action_clients")
_OUTSIDE = ("constructor", "main", "thread")
"""Kinds of code that runs outside of callbacks."""
_AT_ANY_TIME = ("event", "task")
"""Kinds of callbacks that are outside of callback groups, and may run at any time."""


@dataclass(frozen=True)
class Coded:
    """A system described by code.

    Attributes
    ----------
    system : ObservedSystem
        Its nodes and their ports.
    given : Given
        Behaviour, groups and threads from the code.
    taken : tuple of str
        Assumptions about facts that the code does not determine, a line each.
    apart : ObservedSystem
        The nodes before those that share an executor are joined.
    lacks : tuple of str
        What the model lacks, a line each: what could not be read, ports and nodes that are left out, waits
        that are not modelled. Proofs about the model may not hold for the code.
    programs : mapping of str to str
        The program of each node.
    """

    system: ObservedSystem
    given: Given
    taken: tuple[str, ...]
    apart: ObservedSystem
    lacks: tuple[str, ...] = ()
    programs: Mapping[str, str] = field(default_factory=dict)

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
        _CodedNode(with_requested(fact), taken, folder) for folder, facts in read for fact in facts.nodes
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
        nodes[one.name], given[one.name] = one.observed(), one.given()
        kept.append((fact, one.name))
    apart = ObservedSystem(source, tuple(nodes[name] for name in sorted(nodes)))
    share_executors(kept, nodes, given, taken)
    ordered = tuple(nodes[name] for name in sorted(nodes))
    system = ObservedSystem(source, ordered, is_partial=True)
    lacks = (*unread(read), *taken.lacks)
    programs = {name: fact.program or name for fact, name in kept}
    return Coded(system, Given(given, deciding=deciding), taken.lines, apart, lacks, programs)


def _lack_transitions(nodes: Iterable[_CodedNode], taken: Taken) -> None:
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


class _CodedNode:
    """Converts the facts of one node.

    Parameters
    ----------
    fact : NodeFact
        The node.
    taken : Taken
        Gets the assumptions.
    folder : str
        The folder of its files.
    """

    def __init__(self, fact: NodeFact, taken: Taken, folder: str) -> None:
        self.fact = fact
        self._folder = folder
        self._taken = taken
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
        self._groups = GroupsOfNode(fact, taken, self.at)
        self._open_timers: set[str] = set()
        self.deciding: dict[str, Deciding] = {}
        self.is_spun = fact.threads != "not spun"
        self.names: dict[Entity, str] = {}
        self._renamed: dict[Entity, str] = {}
        self.chosen: dict[tuple[str, str], Entity] = {}
        for entity in fact.entities:
            if entity.kind != "groups" and entity.is_enabled and not (entity.name and is_open(entity.name)):
                name = full_name_of(entity, fact) if entity.name else ""
                if is_open(name):
                    self._renamed[entity] = name
                else:
                    self.names[entity] = name

    def at(self, place: Place) -> str:
        """Return a line of code, with its folder."""
        return located(place, self._folder)

    # ---------------------------------------------------------------------------------------------- ports

    def observed(self) -> ObservedNode:
        """Return the node with its ports."""
        return ObservedNode(
            self.name,
            tuple(self._topics("publishers")),
            tuple(self._topics("subscriptions")) if self.is_spun else (),
            tuple(self._others("services")) if self.is_spun else (),
            tuple(self._others("clients")),
            tuple(self._others("action_servers")) if self.is_spun else (),
            tuple(self._others("action_clients")),
            lifecycle="unconfigured" if self.fact.managed else None,
        )

    def _kept(self, kind: str) -> Iterable[tuple[Entity, str]]:
        for entity in self.fact.of(kind):
            if not entity.is_enabled or (kind in _ASK and self._is_idle(entity)):
                continue
            name = self.names.get(entity)
            several = re.match(r"open: (\w+/(?:msg|srv|action)/\w+) or ", entity.type)
            if several is not None:
                self._taken.add(f"{self.at(entity.at)}: the type is {entity.type}; the first is assumed")
                entity.type = several[1]
            if name is None:
                self._taken.lack(
                    f"{self.at(entity.at)}: omitted in the model, because its name is "
                    f"{self._renamed.get(entity, entity.name)}"
                )
            elif is_open(entity.type):
                self._taken.lack(
                    f"{self.at(entity.at)}: omitted in the model, because its type is {entity.type}"
                )
            elif (
                "conditional" in entity.details
                and (other := self.chosen.get((kind, name), entity)).type != entity.type
            ):
                self._taken.lack(
                    f"{self.at(entity.at)}: omitted in the model: {name} of line {other.at.line} is used "
                    "instead"
                )
            else:
                yield entity, name

    def _is_idle(self, client: Entity) -> bool:
        """Return whether a library made a client that no code uses, such as one of those for parameters."""
        if not client.details.get("via") or client.is_lent:
            return False
        return not any(each.is_open for each in self.fact.callbacks) and not any(
            effect.entity is client for each in self.fact.callbacks for effect in each.effects
        )

    def _topics(self, kind: str) -> Iterable[TopicEndpoint]:
        for entity, name in self._kept(kind):
            depth = entity.details.get("depth")
            yield TopicEndpoint(
                name,
                entity.type,
                self._quality(entity),
                depth if isinstance(depth, int) and depth > 0 else None,
                self.at(entity.at),
            )

    def _quality(self, entity: Entity) -> Quality:
        reliability, durability = entity.details.get("reliability"), entity.details.get("durability")
        for key, value in (("reliability", reliability), ("durability", durability)):
            if is_open(value) or value in _MIDDLEWARE:
                usual = "reliable" if key == "reliability" else "volatile"
                # With another value the ports may not match, so that no message ever arrives.
                say = self._taken.lack if is_open(value) else self._taken.add
                say(f"{self.at(entity.at)}: the {key} of {entity.name} is {value}; {usual} is assumed")
        return Quality(
            "bestEffort" if reliability == "best_effort" else "reliable",
            "transientLocal" if durability == "transient_local" else "volatile",
            *("automatic", None, None, None),
        )

    def _others(self, kind: str) -> Iterable[Endpoint]:
        seen: dict[str, Entity] = {}
        for entity, name in self._kept(kind):
            first = seen.setdefault(name, entity)
            if first is entity:
                yield Endpoint(name, entity.type, self.at(entity.at))
            elif kind != "clients" and entity.details.get("group") != first.details.get("group"):
                self._taken.add(f"{self.at(entity.at)}: treated as the same as that of line {first.at.line}")

    # ------------------------------------------------------------------------------------------ behaviour

    def given(self) -> GivenNode:
        """Return the node's behaviour from the code."""
        behaviour = Behaviour(
            self.names,
            self._taken,
            self._folder,
            self.fact.entities,
            self._groups_of_clients(),
            self.deciding,
        )
        self._decisions = Decisions(
            self.fact,
            self.names,
            behaviour.in_branch,
            lambda fact: behaviour.steps(fact) is None,
            self.is_spun,
            self._folder,
            self.deciding,
        )
        callbacks: dict[str, GivenCallback] = {}
        timers: dict[str, float] = {}
        for entity, name in self.names.items():
            if entity.kind in ("subscriptions", "services"):
                callbacks[name] = self._callback(entity, entity.callbacks.get("callback"), behaviour)
            elif entity.kind == "action_servers":
                callbacks[name] = self._callback(entity, entity.callbacks.get("execute"), behaviour)
            elif entity.kind == "timers" and self.is_spun:
                self._timer(entity, behaviour, timers, callbacks)
        served = set(callbacks)
        for entity, name in self.names.items():
            if entity.kind in ("clients", "action_clients"):
                steps = behaviour.after(entity, self.fact.callbacks)
                key = of_client(name) if name in served else name
                first = callbacks.get(key)
                if first is None:
                    callbacks[key] = GivenCallback(
                        steps,
                        self._groups.of(entity),
                        at=self.at(entity.at),
                        flow=self._decisions.after(entity),
                        accepted=self._decisions.told(entity, True),
                        rejected=self._decisions.told(entity, False),
                        has_open_group=self._groups.is_open(entity),
                    )
                else:  # several clients of one name are treated as one
                    both = None if steps is None or first.does is None else (*first.does, *steps)
                    callbacks[key] = replace(first, does=both)
        self._meanwhile(behaviour, timers, callbacks)
        self._outside(behaviour, timers, callbacks)
        threads, open_threads = self._threads()
        return GivenNode(
            threads=threads,
            groups=self._groups.kinds,
            answers_hold_groups=self._groups.answers_hold,
            timers=timers,
            callbacks=callbacks,
            newest=self._newest(),
            at=self.at(self.fact.at),
            order=None if self._groups.has_outside else order_of(self.fact),
            open_timers=frozenset(self._open_timers),
            variables=self._decisions.variables,
            open_threads=open_threads,
        )

    def _groups_of_clients(self) -> Mapping[Entity, str]:
        """Return the groups of clients that are in another one than the first client of their service."""
        first: dict[str, Entity] = {}
        found: dict[Entity, str] = {}
        for entity, name in self.names.items():
            if entity.kind == "clients" and self.fact.group_of(
                first.setdefault(name, entity)
            ) is not self.fact.group_of(entity):
                found[entity] = self._groups.of(entity) or ""
                self._taken.add(
                    f"{self.at(entity.at)}: responses that no callback waits for are treated as those of the "
                    f"client of line {first[name].at.line}"
                )
        return found

    def _callback(self, entity: Entity, fact: CallbackFact | None, behaviour: Behaviour) -> GivenCallback:
        if fact is None:
            steps: tuple[Step, ...] | None = None if "open" in str(entity.details) else ()
            has_open_group = self._groups.is_open(entity)
            return GivenCallback(
                steps, self._groups.of(entity), at=self.at(entity.at), has_open_group=has_open_group
            )
        return GivenCallback(
            behaviour.steps(fact),
            self._groups.of(entity),
            behaviour.gives_back(fact),
            self.at(fact.at),
            sleeps_of(fact),
            flow=self._decisions.of(entity, "execute" if entity.kind == "action_servers" else "callback"),
            received=self._received(entity),
            has_open_group=self._groups.is_open(entity),
        )

    def _received(self, entity: Entity) -> Received | None:
        """Return the branches of a subscription's callback, if a field of its message decides."""
        deciding = self.deciding.get(self.names.get(entity, "")) if entity.kind == "subscriptions" else None
        found = None if deciding is None else self._decisions.received(entity, deciding)
        if found is not None:
            words = f"{found.name} decides; {self.names[entity]} is assumed to have the known publishers only"
            self._taken.lack(f"{found.at}: {words}")  # another publisher may send other values
        return found

    def _timer(
        self,
        entity: Entity,
        behaviour: Behaviour,
        timers: dict[str, float],
        callbacks: dict[str, GivenCallback],
    ) -> None:
        fact = entity.callbacks.get("callback")
        said = fact.name if fact is not None else "timer"
        said = said.removeprefix("on_") if entity.details.get("period") == AT_ANY_TIME else said
        name = free_name(re.sub(r"\W+", "_", said).strip("_"), timers)
        period = entity.details.get("period")
        if period == AT_ANY_TIME:
            period = 1.0
            self._open_timers.add(name)
        elif not isinstance(period, (int, float)) or not 0 < period < 1e9:
            self._taken.add(f"{self.at(entity.at)}: the period of a timer is {period}; 1 s is assumed")
            period = 1.0
            self._open_timers.add(name)
        timers[name] = float(period)
        stops = stops_of(entity, self.fact)
        if stops is not None:
            line = f"{self.at(stops.at)}: {stops.words}; in the model it ticks at any time, and never stops"
            self._taken.lack(f"{line}: that it does is left out")
            self._open_timers.add(name)
        callbacks[name] = self._callback(entity, fact, behaviour)

    def _meanwhile(
        self, behaviour: Behaviour, timers: dict[str, float], callbacks: dict[str, GivenCallback]
    ) -> None:
        """Add the callbacks that goals begin until they end: timers that tick at any time."""
        effects = (effect for fact in self.fact.callbacks for effect in fact.effects)
        for client, fact in {
            id(fact): (effect.entity, fact) for effect in effects for fact in effect.meanwhile
        }.values():
            steps = behaviour.steps(fact)
            if client not in self.names or steps == ():
                continue
            name = free_name(re.sub(r"\W+", "_", fact.name).strip("_") or fact.kind, timers)
            timers[name] = 1.0
            self._open_timers.add(name)
            callbacks[name] = GivenCallback(steps, self._groups.of(client), at=self.at(fact.at))

    def _outside(
        self, behaviour: Behaviour, timers: dict[str, float], callbacks: dict[str, GivenCallback]
    ) -> None:
        """Add the actions outside of callbacks: timers that tick at any time, each in a group of its own.

        One stands for constructors, the main function and threads. Each function that unknown code calls has
        its own: nothing says in which thread it runs, and what runs next to it.
        """
        own: list[Step] = []
        for fact in self.fact.callbacks:
            if fact.is_open and fact.at.file and fact.kind in (*_OUTSIDE, *_AT_ANY_TIME):
                words = f"not all that the {fact.kind} {fact.name} does could be read; omitted in the model"
                self._taken.lack(f"{self.at(fact.at)}: {words}")
            if fact.kind in _OUTSIDE:
                own += _at_any_time(behaviour.steps(fact))
        if own:
            self._at_any_time(MAIN, own, self.fact.at, timers, callbacks)
        for fact in self.fact.callbacks:
            steps = _at_any_time(behaviour.steps(fact)) if fact.kind in _AT_ANY_TIME else []
            if steps:
                name = re.sub(r"\W+", "_", fact.name).strip("_") or "event"
                self._at_any_time(name, steps, fact.at, timers, callbacks)

    def _at_any_time(
        self,
        name: str,
        steps: list[Step],
        at: Place,
        timers: dict[str, float],
        callbacks: dict[str, GivenCallback],
    ) -> None:
        name = free_name(name, timers)
        timers[name] = 1.0
        self._open_timers.add(name)
        done = tuple(dict.fromkeys(steps))
        callbacks[name] = GivenCallback(done, self._groups.outside(), at=self.at(at))

    def _threads(self) -> tuple[int | None, OpenThreads | None]:
        if self.is_spun:
            if self.fact.apart and (self.fact.pool or self.fact.threads != 1):
                names = ", ".join(self.fact.apart)
                words = f"{names} has threads of its own; in the model, all threads run all groups"
                self._taken.lack(f"{self.at(self.fact.at)}: {words}")
            return threads_in_code(self.fact, self.at(self.fact.at))
        self._taken.add(
            f"{self.at(self.fact.at)}: no executor spins node {self.name}: its callbacks never run"
        )
        return 1, None

    def _newest(self) -> Mapping[str, bool]:
        """Return the topics whose subscriptions request best-effort delivery, so that losses are intended."""
        return {
            self.names[entity]: True
            for entity in self.fact.of("subscriptions")
            if entity in self.names and self.is_spun and entity.details.get("reliability") == "best_effort"
        }


def _at_any_time(steps: tuple[Step, ...] | None) -> list[Step]:
    """Return steps that are taken or not, and that do not wait: the waits need no thread of an executor."""
    return [
        replace(
            step,
            verb="send" if step.verb == "call" else step.verb,
            times="?" if step.times == "" else step.times,
        )
        for step in steps or ()
        if step.verb not in ("accepted", "result")
    ]
