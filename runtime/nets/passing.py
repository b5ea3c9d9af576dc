"""Which data a firing passes from the tokens that it takes to those that it puts."""

from __future__ import annotations

from collections.abc import Callable

from dineros.metamodel.token_data import Value
from dineros.metamodel.token_types.passing import passing
from dineros.runtime.nets.ports import Data
from dineros.runtime.nets.structure import Structure
from dineros.runtime.nets.tokens import Token, TokenChecker

Tokens = list[tuple[int, list[Token]]]
"""Tokens by place, in arc order."""


class Passing:
    """The data that firings pass on, by the arcs, types and assignments of a net.

    Parameters
    ----------
    structure : Structure
        The net.
    would_read : callable
        Returns the tokens that the read arcs of a ready transition see.

    Attributes
    ----------
    checkers : tuple of TokenChecker
        For each place, the checker of its token data.
    demands : tuple of tuple of int
        For each transition, the places for which its handlers must give data.
    assigns : tuple of dict
        For each transition, what it assigns to the fields of tokens: place -> pairs of field and value.
    loops : tuple of frozenset of int
        For each transition, the places that it takes from and puts on.
    """

    def __init__(self, structure: Structure, would_read: Callable[[int], Tokens]) -> None:
        self._structure = structure
        self._would_read = would_read
        checkers = {id(type_): TokenChecker(type_) for type_ in {id(t): t for t in structure.types}.values()}
        self.checkers = tuple(checkers[id(type_)] for type_ in structure.types)
        self._free = TokenChecker(structure.ports.token_type)
        self.assigns = tuple(dict(decision.assigns) for decision in structure.decisions)
        self.loops = tuple(
            frozenset(place for place, _ in inputs) & frozenset(place for place, _ in outputs)
            for inputs, outputs in zip(structure.inputs, structure.outputs, strict=True)
        )
        passed = [
            passing(inputs, outputs, [place for place, _ in reads], structure.types.__getitem__)
            for inputs, outputs, reads in zip(
                structure.inputs, structure.outputs, structure.reads, strict=True
            )
        ]
        self._results = tuple(each.result for each in passed)
        self.demands = tuple(each.demanded for each in passed)

    def result_checker(self, transition: int) -> TokenChecker:
        """Return the checker of the data that is passed on."""
        place = self._results[transition]
        return self._free if place is None else self.checkers[place]

    def passed_on(self, transition: int, taken: Tokens) -> Data:
        """Return the data passed on: the first taken token's, in arc order, with the assigned values.

        Tokens of loops are used only if there are no others, and tokens of read arcs only after those. Data
        is not merged: data on a control token must not get into other tokens. If the transition puts tokens
        of other types than it takes, see `dineros.metamodel.token_types.passing`.
        """
        place = self._results[transition]
        if place is None:
            return self._free.default
        data, assigns = self.data_for(transition, taken, place), self.assigns[transition]
        if not assigns:
            return data
        outputs = [
            each for each, _ in self._structure.outputs[transition] if self.is_result(transition, each)
        ]
        assigned = [self.assigned(transition, taken, each) for each in outputs]
        same = {
            name: value
            for name, value in (assigned[0] if assigned else {}).items()
            if all(each.get(name) == value for each in assigned)
        }
        return self.checkers[place].complete(same, data)

    def assigned(self, transition: int, taken: Tokens, place: int) -> dict[str, Value]:
        """Return the values that a transition assigns to the fields of tokens that it puts on a place."""
        given = self.assigns[transition].get(place, ())
        if not given:
            return {}
        seen = dict((*self._would_read(transition), *taken))
        return {
            name: seen[value[0]][0].data[value[1]] if isinstance(value, tuple) else value
            for name, value in given
        }

    def data_for(self, transition: int, taken: Tokens, place: int) -> Data:
        """Return the data for a place from the taken tokens: that of the first token of its type.

        If there is none, return the defaults of the type.
        """
        loops, types = self.loops[transition], self._structure.types
        wanted = types[place]
        for source, tokens in taken:
            if source not in loops and types[source] is wanted:
                return tokens[0].data
        for source, tokens in (*taken, *self._would_read(transition)):
            if types[source] is wanted:
                return tokens[0].data
        return self.checkers[place].default

    def is_result(self, transition: int, place: int) -> bool:
        """Return whether the data that is passed on has the type of a place."""
        result, types = self._results[transition], self._structure.types
        return result is not None and types[place] is types[result]
