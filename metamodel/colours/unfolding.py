"""Unfolding: the plain net of a coloured net, without the colours that can never occur.

Colours are followed from the initial marking: a binding is made once all the colours that it takes can occur.
This keeps all reachable markings, because only dead transitions are omitted. Bindings are found by matching
each new colour with the inputs that can take it (semi-naive evaluation, as in Datalog; module `patterns`).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from dineros.metamodel.colours.patterns import Bound, Occurring, Pattern, Plan, Tries
from dineros.metamodel.colours.sorts import Product, Sort
from dineros.metamodel.colours.terms import (
    Condition,
    Constant,
    Mapped,
    Multiset,
    NegativeCountError,
    Shift,
    TooLargeError,
    TooManyValuesError,
    Tuple,
    Variable,
    multiset_of,
    summands_of,
    variables_of,
)

ARCS = 50
"""Arcs of the plain net for each place and transition that it may have, at most."""

TRIES = 100
"""Values that are tried of variables that no token binds, for each place and transition, at most."""


@dataclass(frozen=True)
class ColouredPlace:
    """A place.

    Attributes
    ----------
    id : str
        Its id.
    sort : Sort
        Colours of its tokens.
    marking : mapping of int to int
        Initial number of tokens, by colour.
    """

    id: str
    sort: Sort
    marking: Mapping[int, int]


@dataclass(frozen=True)
class ColouredTransition:
    """A transition.

    Attributes
    ----------
    id : str
        Its id.
    condition : Condition
        Condition that its bindings satisfy.
    takes, puts : tuple of (int, Multiset)
        By arc: index of the place, and the tokens.
    """

    id: str
    condition: Condition
    takes: tuple[tuple[int, Multiset], ...]
    puts: tuple[tuple[int, Multiset], ...]

    def variables(self) -> dict[str, Variable]:
        """Return all variables by name, in the order in which they occur."""
        terms = [*(term for _, term in (*self.takes, *self.puts)), self.condition]
        return {variable.name: variable for term in terms for variable in variables_of(term)}


@dataclass(frozen=True)
class Firing:
    """A transition with a binding: a transition of the plain net.

    Attributes
    ----------
    transition : int
        Index of the transition.
    binding : mapping of str to int
        Value of each variable.
    takes, puts : mapping of (int, int) to int
        Number of tokens by place and colour.
    """

    transition: int
    binding: Mapping[str, int]
    takes: Mapping[tuple[int, int], int]
    puts: Mapping[tuple[int, int], int]


class Unfolding:
    """Unfolds a coloured net.

    Parameters
    ----------
    places, transitions : list
        The net.
    most : int
        Largest number of places and transitions of the plain net.

    Attributes
    ----------
    colours : list of set of int
        By place: the colours that can occur.
    firings : list of Firing
        The transitions of the plain net.

    Raises
    ------
    TooLargeError
        The plain net has more than `most` places and transitions, or `ARCS` times as many arcs.
    TooManyValuesError
        More than `TRIES` times as many values of variables that no token binds would have to be tried.
    NegativeCountError
        An arc takes away more tokens than there are.
    """

    def __init__(self, places: list[ColouredPlace], transitions: list[ColouredTransition], most: int) -> None:
        self._places, self._transitions, self._most = places, transitions, most
        self.colours: list[set[int]] = [set() for _ in places]
        self.firings: list[Firing] = []
        self._occurring = [
            Occurring(place.sort if isinstance(place.sort, Product) else None) for place in places
        ]
        self._new: deque[tuple[int, int]] = deque()
        self._made: list[set[tuple[int, ...]]] = [set() for _ in transitions]
        self._effects = [_Effect(transition, most) for transition in transitions]
        self._waiting: list[list[tuple[int, Plan]]] = [[] for _ in places]
        """By place: the transitions with a plan that starts with one of its tokens."""
        self._arcs = 0
        self._run()

    def _run(self) -> None:
        tries = Tries(TRIES * self._most)
        for index, place in enumerate(self._places):
            self._occur((index, value) for value, count in sorted(place.marking.items()) if count)
        for number, transition in enumerate(self._transitions):
            variables = transition.variables()
            patterns = [
                Pattern(place, term)
                for place, multiset in transition.takes
                for _, term in summands_of(multiset)
                if isinstance(term, (Variable, Constant, Shift, Mapped, Tuple))
            ]
            for pattern in patterns:
                plan = Plan(patterns, transition.condition, variables, tries, pattern)
                self._waiting[pattern.place].append((number, plan))
            if not patterns:
                self._make(number, Plan((), transition.condition, variables, tries).bindings(self._occurring))
        while self._new:
            place_index, value = self._new.popleft()
            self._occurring[place_index].add(value)
            for number, plan in self._waiting[place_index]:
                self._make(number, plan.bindings(self._occurring, value))

    def _make(self, number: int, bindings: Iterator[Bound]) -> None:
        effect, known = self._effects[number], self._made[number]
        for binding in bindings:
            key = tuple(binding[name] for name in effect.names)
            if key in known:
                continue
            known.add(key)
            takes, puts = effect.takes(binding), effect.puts(binding)
            ordered = dict(zip(effect.names, key, strict=True))
            self.firings.append(Firing(number, ordered, takes, puts))
            self._arcs += len(takes) + len(puts)
            self._occur(iter(takes))
            self._occur(iter(puts))
            self._check_size()

    def _occur(self, found: Iterator[tuple[int, int]]) -> None:
        for place, value in found:
            if value not in self.colours[place]:
                self.colours[place].add(value)
                self._new.append((place, value))

    def _check_size(self) -> None:
        if len(self.firings) > self._most or self._arcs > ARCS * self._most:
            raise TooLargeError


class _Effect:
    """Tokens that a transition takes and puts under a binding."""

    def __init__(self, transition: ColouredTransition, most: int) -> None:
        self.names = tuple(transition.variables())
        self._takes, self._puts = (
            [(place, multiset_of(term, most)) for place, term in arcs]
            for arcs in (transition.takes, transition.puts)
        )

    def takes(self, binding: Bound) -> dict[tuple[int, int], int]:
        return self._tokens(self._takes, binding)

    def puts(self, binding: Bound) -> dict[tuple[int, int], int]:
        return self._tokens(self._puts, binding)

    @staticmethod
    def _tokens(
        arcs: Sequence[tuple[int, Callable[[Bound], dict[int, int]]]], binding: Bound
    ) -> dict[tuple[int, int], int]:
        total: dict[tuple[int, int], int] = {}
        for place, of in arcs:
            for value, count in of(binding).items():
                if count:
                    total[place, value] = total.get((place, value), 0) + count
        return total


__all__ = [
    "ColouredPlace",
    "ColouredTransition",
    "Firing",
    "NegativeCountError",
    "TooLargeError",
    "TooManyValuesError",
    "Unfolding",
]
