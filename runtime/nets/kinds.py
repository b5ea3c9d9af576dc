"""Counts the tokens that fulfil guards, like the tokens of places, so that enabling stays fast."""

from __future__ import annotations

from collections.abc import Collection

from dineros.metamodel.guards.conditions import Condition
from dineros.metamodel.guards.deciding import fulfils
from dineros.runtime.nets.enabling import Enabling
from dineros.runtime.nets.structure import Structure
from dineros.runtime.nets.tokens import Token


class Kinds:
    """Reports to `Enabling` how many tokens of each place fulfil the guard of some transition.

    Parameters
    ----------
    structure : Structure
        The net.
    enabling : Enabling
        Keeps these counts after those of the places.

    Attributes
    ----------
    places : frozenset of int
        The places that occur in guards.
    """

    def __init__(self, structure: Structure, enabling: Enabling) -> None:
        self._enabling = enabling
        self._at: dict[int, list[tuple[int, Condition]]] = {}
        for number, (place, condition) in enumerate(structure.kinds, len(structure.places)):
            self._at.setdefault(place, []).append((number, condition))
        self.places = frozenset(self._at)

    def change(self, place: int, tokens: Collection[Token], free: int, total: int) -> None:
        """Update the counts: each of these tokens changes the free tokens and all tokens by these amounts."""
        for number, condition in self._at[place]:
            count = sum(fulfils(condition, token.data) for token in tokens)
            if count:
                self._enabling.change(number, free * count, total * count)

    def hide(self, transition: int, place: int, tokens: Collection[Token]) -> None:
        """Raise a transition's need by its matching free tokens that are put aside."""
        for number, condition in self._at.get(place, ()):
            if number in self._enabling.kinds_taken[transition]:
                hidden = sum(fulfils(condition, token.data) for token in tokens)
                self._enabling.set_need(transition, number, 1 + hidden)
