"""Compiled nets: place/transition nets as flat integer arrays, the common input of all engines.

A `CompiledNet` is built once from names and weights and is never changed afterwards. Arcs are kept in
compressed sparse row (CSR) form: the arcs of transition ``t`` are the entries ``pointer[t]:pointer[t + 1]``
of two parallel arrays, one of place indices and one of weights.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

Int64Array = NDArray[np.int64]
Known = TypeVar("Known")


class NetError(ValueError):
    """A net cannot be compiled: unknown place, duplicate name, or a weight below one."""


class Transition(NamedTuple):
    """A transition in plain Python, as used by `CompiledNet.build`.

    Every mapping goes from the name of a place to the weight (at least 1) of the arc. ``inhibitors`` with
    weight w allow firing while the place holds fewer than w tokens; ``reads`` stand for a pair of normal
    arcs.
    """

    name: str
    inputs: Mapping[str, int] = {}
    outputs: Mapping[str, int] = {}
    inhibitors: Mapping[str, int] = {}
    reads: Mapping[str, int] = {}


@dataclass(frozen=True)
class ArcTable:
    """Arcs of one kind in CSR form: one row per transition.

    Attributes
    ----------
    pointer : int64 array, shape (transitions + 1,)
    place : int64 array, shape (arcs,)
        Index of the place of each arc, ascending within a row.
    weight : int64 array, shape (arcs,)
    """

    pointer: Int64Array
    place: Int64Array
    weight: Int64Array

    @classmethod
    def from_rows(cls, rows: Sequence[Mapping[int, int]]) -> ArcTable:
        """Build the table from one mapping place index -> weight per transition."""
        pointer = np.zeros(len(rows) + 1, dtype=np.int64)
        pointer[1:] = np.cumsum([len(row) for row in rows])
        items = [item for row in rows for item in sorted(row.items())]
        place = np.array([place for place, _ in items], dtype=np.int64)
        weight = np.array([weight for _, weight in items], dtype=np.int64)
        for array in (pointer, place, weight):
            array.setflags(write=False)
        return cls(pointer, place, weight)

    def row(self, transition: int) -> tuple[tuple[int, int], ...]:
        """Pairs (place index, weight) of one transition."""
        return self._rows[transition]

    @cached_property
    def _rows(self) -> list[tuple[tuple[int, int], ...]]:
        pairs = tuple(zip(self.place.tolist(), self.weight.tolist(), strict=True))
        return [pairs[start:end] for start, end in pairwise(self.pointer.tolist())]


@dataclass(frozen=True)
class CompiledNet:
    """A place/transition net with inhibitor arcs, as flat arrays.

    Attributes
    ----------
    places, transitions : tuple of str
        Names; positions are the indices used everywhere else.
    initial : int64 array, shape (places,)
        Initial marking, in tokens.
    pre, post, inhibitor : ArcTable
        Input, output and inhibitor arcs, by transition. A read arc is an input and an output arc of equal
        weight.
    """

    places: tuple[str, ...]
    transitions: tuple[str, ...]
    initial: Int64Array
    pre: ArcTable
    post: ArcTable
    inhibitor: ArcTable

    @classmethod
    def build(
        cls,
        places: Mapping[str, int],
        transitions: Iterable[Transition | tuple[object, ...]],
    ) -> CompiledNet:
        """Compile a net given by names.

        Parameters
        ----------
        places
            Name of each place -> its initial number of tokens.
        transitions
            `Transition` tuples (or plain tuples with the same fields; trailing ones may be left out).

        Raises
        ------
        NetError
            If an arc names an unknown place, a name occurs twice, a weight is below 1 or a marking is
            negative.

        Examples
        --------
        >>> net = CompiledNet.build({"idle": 2, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})])
        >>> net.places, net.initial.tolist(), net.pre.row(0)
        (('idle', 'busy'), [2, 0], ((0, 1),))
        """
        index = {name: position for position, name in enumerate(places)}
        for name, tokens in places.items():
            if tokens < 0:
                raise NetError(f"place {name!r} starts with {tokens} tokens")
        names: list[str] = []
        rows: tuple[list[dict[int, int]], ...] = ([], [], [])
        for item in transitions:
            transition = Transition(*item)
            names.append(transition.name)
            groups = [transition.inputs, transition.outputs, transition.inhibitors, transition.reads]
            inputs, outputs, inhibitors, reads = (_row(transition.name, index, group) for group in groups)
            for place, weight in reads.items():
                inputs[place] = inputs.get(place, 0) + weight
                outputs[place] = outputs.get(place, 0) + weight
            for store, row in zip(rows, (inputs, outputs, inhibitors), strict=True):
                store.append(row)
        if len(set(names)) != len(names):
            twice = sorted({name for name in names if names.count(name) > 1})
            raise NetError(f"transition names occur more than once: {', '.join(twice)}")
        initial = np.array(list(places.values()), dtype=np.int64)
        initial.setflags(write=False)
        pre, post, inhibitor = (ArcTable.from_rows(store) for store in rows)
        return cls(tuple(places), tuple(names), initial, pre, post, inhibitor)

    @cached_property
    def delta(self) -> tuple[dict[int, int], ...]:
        """For each transition, the change of tokens: place index -> tokens gained (never 0) when it fires."""
        changes = []
        for transition in range(len(self.transitions)):
            change = {place: -weight for place, weight in self.pre.row(transition)}
            for place, weight in self.post.row(transition):
                change[place] = change.get(place, 0) + weight
            changes.append({place: tokens for place, tokens in sorted(change.items()) if tokens})
        return tuple(changes)

    @cached_property
    def changing(self) -> tuple[tuple[int, ...], ...]:
        """For each place, the transitions that change its tokens."""
        rows: list[list[int]] = [[] for _ in self.places]
        for transition, change in enumerate(self.delta):
            for place in change:
                rows[place].append(transition)
        return tuple(map(tuple, rows))

    @cached_property
    def consumers(self) -> tuple[tuple[int, ...], ...]:
        """For each place, the transitions with an input arc from it."""
        lists: list[list[int]] = [[] for _ in self.places]
        for transition in range(len(self.transitions)):
            for place, _ in self.pre.row(transition):
                lists[place].append(transition)
        return tuple(tuple(entries) for entries in lists)

    @cached_property
    def _known(self) -> dict[Callable[[CompiledNet], Any], Any]:
        return {}

    def once(self, question: Callable[[CompiledNet], Known]) -> Known:
        """Return the result of a function for the net, called only once; the result must not be changed."""
        if question not in self._known:
            self._known[question] = question(self)
        answer: Known = self._known[question]
        return answer

    def know(self, question: Callable[[CompiledNet], Known], answer: Known) -> None:
        """Record the result of a function for the net, so that `once` does not call it."""
        self._known[question] = answer

    def by_names(self) -> tuple[dict[str, int], list[Transition]]:
        """The net in the form of `build`; read arcs are pairs of arcs."""
        names = self.places
        rows = (
            [
                {names[place]: weight for place, weight in table.row(t)}
                for table in (self.pre, self.post, self.inhibitor)
            ]
            for t in range(len(self.transitions))
        )
        transitions = [Transition(name, *row) for name, row in zip(self.transitions, rows, strict=True)]
        return dict(zip(names, self.initial.tolist(), strict=True)), transitions

    def tested(self, transition: int) -> set[int]:
        """Places that decide whether a transition is enabled."""
        return {place for table in (self.pre, self.inhibitor) for place, _ in table.row(transition)}

    def is_enabled(self, transition: int, marking: Sequence[int] | Int64Array) -> bool:
        """Plain firing rule: every input place holds its weight and every inhibitor holds."""
        return all(marking[place] >= weight for place, weight in self.pre.row(transition)) and all(
            marking[place] < weight for place, weight in self.inhibitor.row(transition)
        )

    def fire(self, transition: int, marking: Sequence[int] | Int64Array) -> list[int]:
        """Marking after firing an enabled transition.

        Raises
        ------
        NetError
            If the transition is not enabled.
        """
        if not self.is_enabled(transition, marking):
            raise NetError(f"transition {self.transitions[transition]!r} is not enabled")
        result: list[int] = marking.tolist() if isinstance(marking, np.ndarray) else list(marking)
        for place, tokens in self.delta[transition].items():
            result[place] += tokens
        return result

    def with_initial(self, initial: Mapping[str, int]) -> CompiledNet:
        """The same net with some initial markings replaced (tokens by name of place)."""
        marking = self.initial.copy()
        for name, tokens in initial.items():
            marking[self.places.index(name)] = tokens
        marking.setflags(write=False)
        return CompiledNet(self.places, self.transitions, marking, self.pre, self.post, self.inhibitor)


def unused(name: str, *taken: Container[str]) -> str:
    """Return an unused name, as similar to the given one as possible."""
    while any(name in names for names in taken):
        name += "'"
    return name


def _row(transition: str, index: Mapping[str, int], arcs: Mapping[str, int]) -> dict[int, int]:
    row: dict[int, int] = {}
    for name, weight in arcs.items():
        if name not in index:
            raise NetError(f"transition {transition!r} has an arc with an unknown place {name!r}")
        if weight < 1:
            raise NetError(f"transition {transition!r} has an arc of weight {weight} with place {name!r}")
        row[index[name]] = int(weight)
    return row
