"""Guards and assignments of the flattened net's transitions, by the ids of places."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any, NamedTuple

from dineros.analysis.model.subject import Subject
from dineros.metamodel import pn, sym
from dineros.metamodel.guards.conditions import Condition
from dineros.metamodel.guards.deciding import as_value, read_step
from dineros.metamodel.token_data import FieldType, Value, read_data
from dineros.metamodel.token_types.declared import token_type_of, type_of_place

Fields = dict[str, FieldType]


class Decision(NamedTuple):
    """The guard and the assignments of a transition; places are given by their ids in the net."""

    takes: Mapping[str, Condition]
    reads: Mapping[str, Condition]
    """`takes`, `reads`: for each place that it takes from or reads, the condition for the token."""
    assigns: Mapping[str, Mapping[str, Any]]
    """For each place and field, a value, or the place and field that are copied."""


class Decisions:
    """The guards and assignments of all transitions of a net.

    `subject`: the flattened net, with guards not unfolded.

    Attributes
    ----------
    of : dict of str to Decision
        By transition of the net.
    fields : dict of str to dict
        The fields of the tokens on each place whose data is tracked.
    initial : dict of str to list of dict
        The data of the initial tokens on each of these places.
    typed : dict of str to dict
        By place of the net: the fields of its tokens, if the model declares their type.
    """

    def __init__(self, model: sym.SystemModel, subject: Subject) -> None:
        self.of: dict[str, Decision] = {}
        self.fields: dict[str, Fields] = {}
        self.initial: dict[str, list[dict[str, Value]]] = {}
        self.typed: dict[str, Fields] = {}
        self._model = model
        if subject.flattened is None:
            return
        links = {link.target: link.sources[0] for link in subject.links() if link.maker is None}
        self._originals = {
            target: source
            for target, source in links.items()
            if isinstance(target, pn.Place) and isinstance(source, pn.Place)
        }
        for place, original in self._originals.items():
            declared = type_of_place(original, model)
            if declared is None or declared.ros:  # constants of installed messages limit nothing
                continue
            self.typed[place.id] = self._fields(original)
        decided = {
            target: source
            for target, source in links.items()
            if isinstance(target, pn.Transition) and isinstance(source, sym.Transition)
            if source.guard is not None or source.assigns is not None
        }
        arcs: dict[pn.Node, list[pn.Arc]] = {transition: [] for transition in decided}
        for arc in subject.flattened.net.pages[0].arcs if decided else ():
            for end in (arc.source, arc.target):
                if end in arcs:
                    arcs[end].append(arc)
        for transition, source in decided.items():
            self.of[transition.id] = self._read(source, transition, arcs[transition])
        for place, original in self._originals.items():
            if place.id in self.fields:
                self.initial[place.id] = self._initial(original, self.fields[place.id])

    @staticmethod
    def _initial(place: pn.Place, fields: Fields) -> list[dict[str, Value]]:
        balloons = list(place.balloons) if isinstance(place, sym.Place) else []
        default = {name: field.default for name, field in fields.items()}
        data = [default | read_data(each.data or "{}", fields) for each in balloons]
        return [*data, *[default] * (place.tokens - len(data))][: place.tokens]

    def _fields(self, place: pn.Place) -> Fields:
        return {field.name: field for field in token_type_of(type_of_place(place, self._model)).fields}

    def _read(self, source: sym.Transition, transition: pn.Transition, arcs: list[pn.Arc]) -> Decision:
        seen: Counter[pn.Place] = Counter()
        takes: set[pn.Place] = set()
        puts: list[pn.Place] = []
        names: dict[pn.Place, str] = {}
        for arc in arcs:
            end = arc.source if arc.target is transition else arc.target
            place = self._originals.get(end) if isinstance(end, pn.Place) else None
            if place is None or arc.kind == pn.ArcKind.inhibitor:
                continue
            names[place] = end.id
            self.fields.setdefault(end.id, self._fields(place))
            if arc.source is transition:
                puts.append(place)
                continue
            seen[place] += arc.weight
            if arc.kind != pn.ArcKind.read:
                takes.add(place)
        step = read_step(source, seen, puts, self._fields)
        return Decision(
            {names[place]: asked for place, asked in step.guard.items() if place in takes},
            {names[place]: asked for place, asked in step.guard.items() if place not in takes},
            {
                names[place]: {
                    name: (names[value[0]], value[1])
                    if isinstance(value, tuple)
                    else as_value(value, self.fields[names[place]][name])
                    for name, value in given.items()
                }
                for place, given in step.assigned.items()
            },
        )
