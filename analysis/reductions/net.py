"""A net that rules can change: dictionaries by name, with the arcs of each place and transition."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from dineros.analysis.nets.compiled import CompiledNet, NetError, Transition, unused

Marking = dict[str, int]


class Arcs(NamedTuple):
    """Arcs of one transition by name of place; never changed in place, so that they can be shared."""

    inputs: Mapping[str, int]
    outputs: Mapping[str, int]
    inhibitors: Mapping[str, int]

    @property
    def places(self) -> set[str]:
        """Every place that the transition has an arc with."""
        return {*self.inputs, *self.outputs, *self.inhibitors}

    @property
    def delta(self) -> dict[str, int]:
        """Tokens gained by place when the transition fires, without zeros."""
        change = {place: -weight for place, weight in self.inputs.items()}
        for place, weight in self.outputs.items():
            change[place] = change.get(place, 0) + weight
        return {place: tokens for place, tokens in change.items() if tokens}

    def without(self, places: Iterable[str]) -> Arcs:
        """The same arcs, except those with some places."""
        gone = set(places)
        return Arcs(*({p: w for p, w in row.items() if p not in gone} for row in self))

    def without_inhibitor(self, place: str) -> Arcs:
        """The same arcs, except an inhibitor arc."""
        return Arcs(self.inputs, self.outputs, {p: w for p, w in self.inhibitors.items() if p != place})

    def renamed(self, names: Mapping[str, str]) -> Arcs:
        """The same arcs with places renamed; weights of places that become one add up."""
        rows = []
        for row in self:
            renamed: dict[str, int] = {}
            for place, weight in row.items():
                name = names.get(place, place)
                renamed[name] = renamed.get(name, 0) + weight
            rows.append(renamed)
        return Arcs(*rows)


@dataclass(frozen=True)
class Change:
    """The effect of one application of a rule on a net; it can be undone.

    A transition in both ``removed_transitions`` and ``added_transitions`` has its arcs replaced.
    """

    removed_places: Mapping[str, int] = field(default_factory=dict)
    added_places: Mapping[str, int] = field(default_factory=dict)
    removed_transitions: Mapping[str, Arcs] = field(default_factory=dict)
    added_transitions: Mapping[str, Arcs] = field(default_factory=dict)

    def inverse(self) -> Change:
        """The change that undoes this one."""
        return Change(
            self.added_places, self.removed_places, self.added_transitions, self.removed_transitions
        )


class MutableNet:
    """Places and transitions by name.

    Attributes
    ----------
    places : dict
        Name -> initial tokens.
    transitions : dict
        Name -> `Arcs`.
    consumers, producers, inhibited : dict
        Name of place -> names of the transitions with an input, output or inhibitor arc with it, as the keys
        of a dictionary, because sets of text have no reproducible order.
    """

    def __init__(self) -> None:
        self.places: dict[str, int] = {}
        self.transitions: dict[str, Arcs] = {}
        self.consumers: dict[str, dict[str, None]] = {}
        self.producers: dict[str, dict[str, None]] = {}
        self.inhibited: dict[str, dict[str, None]] = {}
        self.changes = 0

    @classmethod
    def of(cls, net: CompiledNet) -> MutableNet:
        """Copy a compiled net."""
        result, (places, transitions) = cls(), net.by_names()
        for name, tokens in places.items():
            result._add_place(name, tokens)
        for row in transitions:
            result._add_transition(row.name, Arcs(row.inputs, row.outputs, row.inhibitors))
        return result

    def copy(self) -> MutableNet:
        """An independent copy."""
        result = MutableNet()
        result.places = dict(self.places)
        result.transitions = dict(self.transitions)
        result.consumers = {place: dict(row) for place, row in self.consumers.items()}
        result.producers = {place: dict(row) for place, row in self.producers.items()}
        result.inhibited = {place: dict(row) for place, row in self.inhibited.items()}
        return result

    def compile(self) -> CompiledNet:
        """The net as flat arrays."""
        return CompiledNet.build(
            self.places,
            [
                Transition(name, arcs.inputs, arcs.outputs, arcs.inhibitors)
                for name, arcs in self.transitions.items()
            ],
        )

    def apply(self, change: Change) -> None:
        """Apply a change."""
        self.changes += 1
        for name, arcs in change.removed_transitions.items():
            self._unlink(name, arcs)
            if name not in change.added_transitions:
                del self.transitions[name]
        for name in change.removed_places:
            if self.consumers.pop(name) or self.producers.pop(name) or self.inhibited.pop(name):
                raise NetError(f"place {name!r} is removed but still has arcs")
            del self.places[name]
        for name, tokens in change.added_places.items():
            self._add_place(name, tokens)
        for name, arcs in change.added_transitions.items():
            self._add_transition(name, arcs)

    def removing_places(self, places: Iterable[str]) -> Change:
        """The change that removes places together with their arcs."""
        gone = {place: self.places[place] for place in places}
        touched = {t: self.transitions[t] for place in gone for t in self.neighbours(place)}
        return Change(
            removed_places=gone,
            removed_transitions=touched,
            added_transitions={t: arcs.without(gone) for t, arcs in touched.items()},
        )

    def removing_transitions(self, transitions: Iterable[str]) -> Change:
        """The change that removes transitions."""
        return Change(removed_transitions={t: self.transitions[t] for t in transitions})

    def neighbours(self, place: str) -> list[str]:
        """Every transition with an arc of any kind with a place, each once."""
        return list({**self.consumers[place], **self.producers[place], **self.inhibited[place]})

    def fresh_place(self, name: str) -> str:
        """Return a name that no place has, as close to the given one as possible."""
        return unused(name, self.places)

    def fresh_transition(self, name: str, taken: Container[str] = ()) -> str:
        """Return a name that no transition has, as close to the given one as possible."""
        return unused(name, self.transitions, taken)

    def is_enabled(self, transition: str, marking: Mapping[str, int]) -> bool:
        """Plain firing rule."""
        arcs = self.transitions[transition]
        return all(marking[p] >= w for p, w in arcs.inputs.items()) and all(
            marking[p] < w for p, w in arcs.inhibitors.items()
        )

    def fire(self, transition: str, marking: Marking) -> None:
        """Change a marking by firing an enabled transition.

        Raises
        ------
        NetError
            If the transition is not enabled.
        """
        if not self.is_enabled(transition, marking):
            raise NetError(f"transition {transition!r} is not enabled")
        for place, tokens in self.transitions[transition].delta.items():
            marking[place] += tokens

    def _add_place(self, name: str, tokens: int) -> None:
        self.places[name] = tokens
        self.consumers[name], self.producers[name], self.inhibited[name] = {}, {}, {}

    def _add_transition(self, name: str, arcs: Arcs) -> None:
        self.transitions[name] = arcs
        for row, index in zip(arcs, (self.consumers, self.producers, self.inhibited), strict=True):
            for place in row:
                index[place][name] = None

    def _unlink(self, name: str, arcs: Arcs) -> None:
        for row, index in zip(arcs, (self.consumers, self.producers, self.inhibited), strict=True):
            for place in row:
                del index[place][name]
