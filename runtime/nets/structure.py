"""The structure of a runtime model as plain tuples, which the engine runs without any model object.

Server pages are instantiated, references are resolved, and places and transitions are named as in the
flattened net (`Pick[2].TPick` is the transition `TPick` of the second server instance of the channel `Pick`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.callbacks.bodies import Body, calls_of, timers_of
from dineros.metamodel.calls import copy_id
from dineros.metamodel.clauses import SignalSetting, start_value
from dineros.metamodel.elements import fresh_id, label, resolve
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.guards.conditions import Condition
from dineros.metamodel.limits import exceeds
from dineros.metamodel.token_data import TokenType, Value, read_data
from dineros.metamodel.token_types.declared import token_type_of, type_of_place
from dineros.runtime.nets.capacities import Arcs, capacities_of, limits_of, raises_of
from dineros.runtime.nets.guards import Decision, decision_of, kinds_of
from dineros.runtime.nets.port_reading import PagePort, PortReading, served_pages
from dineros.runtime.nets.ports import Ports

Clause = tuple[tuple[tuple[int, SignalSetting, bool], ...], ...]
"""Disjunctions of literals: a signal's index, the value it is compared with, and whether it must differ."""


@dataclass(frozen=True)
class Structure:
    """A runtime model, ready to run. Places, transitions and signals are numbers: positions in these tuples.

    Attributes
    ----------
    places, transitions, signals : tuple of str
        Ids, as in the flattened net.
    place_names, transition_names : tuple of str
        Ids in the model: without the server instance.
    transition_labels : tuple of str
        Names in the model.
    instances : tuple of int or None
        For each transition, the number of its server instance, from 1.
    channels : tuple of str or None
        For each transition, the channel of the service or action whose server page it is on.
    inputs, outputs : tuple of Arcs
        For each transition, the tokens it takes and puts.
    capacities : tuple of int or None
        For each place, the most tokens that the model lets it hold; None: any number.
    limits : tuple of int or None
        For each place, the most tokens in a run: its capacity, or the result of `limits_of`.
    raises : tuple of Arcs
        For each transition, the places with a limit whose tokens it increases, and by how many.
    reads, inhibitors : tuple of Arcs
        For each transition, the total number of tokens that a place must hold (including those that the
        transition takes), and the number that it must not hold.
    superiors : tuple of tuple of int
        For each transition, the transitions of higher priority, direct or transitive: while one of them is
        enabled, it may not fire.
    intervals : tuple
        For each transition, the earliest and latest time in seconds after it became ready, or None; closed
        bounds within an open interval.
    timers : tuple of tuple of int
        For each timer of the ports, the transitions by which its callback begins.
    clauses : tuple of Clause
        For each transition, its input clause.
    decisions : tuple of Decision
        For each transition, its guard and its assignments.
    kinds : tuple of (int, Condition)
        The places and conditions that occur in guards, each once.
    initial : tuple
        For each place, the data of its initial tokens.
    initial_signals : tuple of bool or str
        Values at the start.
    types : tuple of TokenType
        For each place, its token type; equal types are the same object.
    ports : Ports
        The ports of the node.
    """

    places: tuple[str, ...]
    place_names: tuple[str, ...]
    transitions: tuple[str, ...]
    transition_names: tuple[str, ...]
    transition_labels: tuple[str, ...]
    instances: tuple[int | None, ...]
    channels: tuple[str | None, ...]
    inputs: tuple[Arcs, ...]
    outputs: tuple[Arcs, ...]
    capacities: tuple[int | None, ...]
    limits: tuple[int | None, ...]
    raises: tuple[Arcs, ...]
    reads: tuple[Arcs, ...]
    inhibitors: tuple[Arcs, ...]
    superiors: tuple[tuple[int, ...], ...]
    intervals: tuple[tuple[float, float | None] | None, ...]
    timers: tuple[tuple[int, ...], ...]
    clauses: tuple[Clause, ...]
    decisions: tuple[Decision, ...]
    kinds: tuple[tuple[int, Condition], ...]
    signals: tuple[str, ...]
    initial: tuple[tuple[dict[str, Value], ...], ...]
    initial_signals: tuple[SignalSetting, ...]
    types: tuple[TokenType, ...]
    ports: Ports

    def most_put_at_once(self, place: int) -> int:
        """Return the most tokens that one firing, or the start, puts on a place; at least 1."""
        puts = (weight for arcs in self.outputs for each, weight in arcs if each == place)
        return max(1, len(self.initial[place]), *puts)


_MARGIN = 0.001
"""Maximum distance, in seconds, that a run keeps from an excluded bound."""


class _Instance(NamedTuple):
    """A server instance: the port's channel, the number, the page it copies."""

    channel: str
    number: int
    page: pn.Page

    def id_of(self, element: pn.Element) -> str:
        return copy_id(self.channel, self.number, element.id)


def read_structure(model: rtm.RuntimeModel) -> Structure:
    """Return the structure of a runtime model.

    Raises
    ------
    DinerosError
        The model cannot run: it has no node net, a reference has no target, an arc leads into a server page,
        or a guard is invalid.
        SizeLimitError
            It exceeds the size limits; see `dineros.metamodel.limits`.
    """
    return _Reading(model).structure()


class _Reading:
    """One pass over a model."""

    def __init__(self, model: rtm.RuntimeModel) -> None:
        if model.node is None:
            raise DinerosError(f"the runtime model {model.id!r} names no node net", element=model.id)
        self.model = model
        self._types: dict[sym.TokenType | None, TokenType] = {}
        self.token_type = self._type(model.tokenType)
        self.servers: dict[pn.Page, PagePort] = served_pages(model)
        # The page that is copied for each instance, by node: for all nodes on it or on its subpages.
        self.prototypes: dict[pn.Node, pn.Page] = {}
        self.places: dict[tuple[pn.Node, int], int] = {}
        self.transitions: dict[tuple[pn.Node, int], int] = {}
        self.place_ids: list[str] = []
        self.transition_ids: list[str] = []

    def structure(self) -> Structure:
        placed = list(self._walk())
        self._require("elements", sum(1 + len(page.objects) + len(page.arcs) for page, _ in placed))
        taken = {node.id for page, instance in placed if instance is None for node in page.objects}
        for page, instance in placed:
            for node in page.objects:
                if isinstance(node, (pn.Place, pn.Transition)):
                    self._add(node, instance, taken)
        joined = _Arcs(len(self.transitions))
        for page, instance in placed:
            for arc in page.arcs:
                self._join(arc, instance, joined)
        places = [node for node, _ in self.places]
        transitions = [node for node, _ in self.transitions]
        signals = {signal: index for index, signal in enumerate(self.model.node.signals)}
        self._require_few_tokens(places)
        inputs, outputs, reads = _tuples(joined.inputs), _tuples(joined.outputs), _tuples(joined.needs())
        capacities = capacities_of(self.model, list(self.places), inputs, outputs, reads)
        limits = limits_of(capacities, list(self.places), inputs, outputs)
        types = [self._type_at(place) for place in places]
        marked = [place for place in places if isinstance(place, pn.Place)]
        decisions = tuple(
            decision_of(transition, each, marked, types.__getitem__)
            for transition, *each in zip(transitions, inputs, outputs, reads, strict=True)
        )
        return Structure(
            places=tuple(self.place_ids),
            place_names=tuple(place.id for place in places),
            transitions=tuple(self.transition_ids),
            transition_names=tuple(transition.id for transition in transitions),
            transition_labels=tuple(label(transition) for transition in transitions),
            instances=tuple(number or None for _, number in self.transitions),
            channels=tuple(
                self.servers[self.prototypes[transition]].channel if number else None
                for transition, number in self.transitions
            ),
            inputs=inputs,
            outputs=outputs,
            capacities=capacities,
            limits=limits,
            raises=raises_of(limits, inputs, outputs),
            reads=reads,
            inhibitors=_tuples(joined.inhibitors),
            superiors=self._superiors(),
            intervals=tuple(_interval(transition) for transition in transitions),
            timers=self._timers(),
            clauses=tuple(_clause(transition, signals) for transition in transitions),
            decisions=decisions,
            kinds=kinds_of(decisions),
            signals=tuple(signal.id for signal in signals),
            initial=tuple(self._initial(place) for place in places),
            initial_signals=tuple(start_value(signal) for signal in signals),
            types=tuple(types),
            ports=PortReading(self.model, self.places, self.place_ids, self.prototypes, self._type_at).ports(
                self.token_type, self._place_types()
            ),
        )

    def _require(self, limit: str, size: int) -> None:
        """Refuse a size above a limit, before anything is created."""
        id = self.model.node.id
        if (error := exceeds(limit, size, f"the node net {id!r} has", id)) is not None:
            raise error

    def _require_few_tokens(self, places: list[pn.Node]) -> None:
        marked = [place for place in places if isinstance(place, pn.Place) and place.tokens]
        self._require("tokens", sum(place.tokens for place in marked))
        values = (
            place.tokens * sum(_size(field.default) for field in self._type_at(place).fields)
            for place in marked
        )
        self._require("values", sum(values))

    def _type_at(self, place: pn.Node) -> TokenType:
        return self._type(type_of_place(place, self.model))

    def _type(self, declared: sym.TokenType | None) -> TokenType:
        if declared not in self._types:
            self._types[declared] = token_type_of(declared)
        return self._types[declared]

    def _walk(self) -> Iterator[tuple[pn.Page, _Instance | None]]:
        """Yield the pages in model order, those of a server once per instance."""
        stack: list[tuple[pn.Page, _Instance | None]] = []
        stack.extend((page, None) for page in reversed(list(self.model.pages)))
        while stack:
            page, instance = stack.pop()
            port = self.servers.get(page)
            if port is not None and instance is None:
                count = max(1, port.instances)
                self._require("instances", count)
                stack.extend((page, _Instance(port.channel, n, page)) for n in range(count, 0, -1))
                continue
            yield page, instance
            inner = [part for part in page.objects if isinstance(part, pn.Page)]
            stack.extend((part, instance) for part in inner[::-1])

    def _add(self, node: pn.Place | pn.Transition, instance: _Instance | None, taken: set[str]) -> None:
        if instance is None:
            id, number = node.id, 0
        else:
            id, number = fresh_id(instance.id_of(node), taken), instance.number
            self.prototypes[node] = instance.page
        table, ids = (
            (self.places, self.place_ids)
            if isinstance(node, pn.Place)
            else (self.transitions, self.transition_ids)
        )
        table[node, number] = len(ids)
        ids.append(id)

    def _key(self, node: pn.Node, instance: _Instance | None) -> tuple[pn.Node, int]:
        """Return the key of a node, with the instance to which an element of this page refers."""
        final = resolve(node)
        prototype = self.prototypes.get(final)
        if prototype is None:
            return final, 0
        if instance is None or prototype is not instance.page:
            raise DinerosError(
                f"{node.id!r} leads into the server page {prototype.id!r} from outside",
                element=node.id,
                hint="only the elements of a server page may use its places",
            )
        return final, instance.number

    def _join(self, arc: pn.Arc, instance: _Instance | None, joined: _Arcs) -> None:
        source, target = self._key(arc.source, instance), self._key(arc.target, instance)
        if source in self.places and target in self.transitions:
            place, transition = self.places[source], self.transitions[target]
            if arc.kind == pn.ArcKind.inhibitor:
                joined.inhibit(transition, place, arc.weight)
            elif arc.kind == pn.ArcKind.read:
                joined.add(joined.reads, transition, place, arc.weight)
            else:
                joined.add(joined.inputs, transition, place, arc.weight)
        elif source in self.transitions and target in self.places and arc.kind == pn.ArcKind.normal:
            joined.add(joined.outputs, self.transitions[source], self.places[target], arc.weight)
        else:
            raise DinerosError(
                f"the {arc.kind} arc {arc.id!r} joins {arc.source.id!r} and {arc.target.id!r}", element=arc.id
            )

    def _superiors(self) -> tuple[tuple[int, ...], ...]:
        copies: dict[pn.Node, list[tuple[int, int]]] = {}
        for (node, number), index in self.transitions.items():
            copies.setdefault(node, []).append((number, index))
        superiors: list[list[int]] = [[] for _ in self.transitions]
        for (node, number), index in self.transitions.items():
            assert isinstance(node, pn.Transition)
            for lower in _overridden(node):
                same = self.prototypes.get(lower) is self.prototypes.get(node)
                for instance, below in copies.get(lower, ()):
                    if not same or instance == number:
                        superiors[below].append(index)
        return tuple(tuple(above) for above in superiors)

    def _timers(self) -> tuple[tuple[int, ...], ...]:
        calls = calls_of(self.model)
        begins = (Body(page, calls).beginnings() for page in timers_of(self.model))
        known = self.transitions
        return tuple(tuple(known[each, 0] for each in some if (each, 0) in known) for some in begins)

    def _initial(self, place: pn.Node) -> tuple[dict[str, Value], ...]:
        assert isinstance(place, pn.Place)
        fields = {field.name: field for field in self._type_at(place).fields}
        default = {name: field.default for name, field in fields.items()}
        balloons = list(place.balloons)[: place.tokens] if isinstance(place, sym.Place) else []
        data = [default | read_data(balloon.data or "{}", fields) for balloon in balloons]
        return (*data, *[default] * (place.tokens - len(data)))

    def _place_types(self) -> dict[str, TokenType]:
        """Return the token types of places that do not have the default type."""
        types: dict[str, TokenType] = {}
        for (place, _), index in self.places.items():
            type_ = self._type_at(place)
            if type_ is not self.token_type:
                types[place.id] = types[self.place_ids[index]] = type_
        return types


class _Arcs:
    """Arcs of each transition: place -> weight, in arc order; parallel arcs of one kind add up."""

    def __init__(self, transitions: int) -> None:
        self.inputs: list[dict[int, int]] = [{} for _ in range(transitions)]
        self.outputs: list[dict[int, int]] = [{} for _ in range(transitions)]
        self.reads: list[dict[int, int]] = [{} for _ in range(transitions)]
        self.inhibitors: list[dict[int, int]] = [{} for _ in range(transitions)]

    def add(self, table: list[dict[int, int]], transition: int, place: int, weight: int) -> None:
        table[transition][place] = table[transition].get(place, 0) + weight

    def inhibit(self, transition: int, place: int, weight: int) -> None:
        self.inhibitors[transition][place] = min(weight, self.inhibitors[transition].get(place, weight))

    def needs(self) -> list[dict[int, int]]:
        """Return the total number of tokens that places with read arcs must hold."""
        return [
            {place: weight + inputs.get(place, 0) for place, weight in reads.items()}
            for reads, inputs in zip(self.reads, self.inputs, strict=True)
        ]


def _size(value: Value) -> int:
    """Return the number of values in a default."""
    if isinstance(value, (list, dict)):
        return sum(map(_size, value if isinstance(value, list) else value.values()))
    return 1


def _tuples(tables: list[dict[int, int]]) -> tuple[Arcs, ...]:
    return tuple(tuple(table.items()) for table in tables)


def _clause(transition: pn.Node, signals: dict[sym.InputSignal, int]) -> Clause:
    clause = transition.clause if isinstance(transition, sym.Transition) else None
    if clause is None:
        return ()
    return tuple(
        tuple(
            (signals[each.signal], True if each.value is None else each.value, bool(each.negated))
            for each in disjunction.literals
        )
        for disjunction in clause.disjunctions
    )


def _overridden(transition: pn.Transition) -> list[pn.Transition]:
    """Return the transitions that a transition has priority over, direct or transitive, each once."""
    found: dict[pn.Transition, None] = {}
    todo = list(transition.overrides)
    while todo:
        lower = todo.pop()
        if lower not in found:
            found[lower] = None
            todo.extend(lower.overrides)
    return list(found)


def _interval(transition: pn.Node) -> tuple[float, float | None] | None:
    interval = transition.interval if isinstance(transition, pn.Transition) else None
    if interval is None:
        return None
    earliest, latest = float(interval.earliest), None if interval.latest is None else float(interval.latest)
    margin = _MARGIN if latest is None else min(_MARGIN, (latest - earliest) / 4)
    if interval.earliestExcluded:
        earliest += margin
    if latest is not None and interval.latestExcluded:
        latest -= margin
    return earliest, latest
