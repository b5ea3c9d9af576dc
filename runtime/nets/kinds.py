"""How many tokens of each place fulfil what guards ask: counted like places, so that enabling stays quick."""

from __future__ import annotations

from collections.abc import Collection

from dineros.metamodel.guards.conditions import Condition
from dineros.metamodel.guards.deciding import fulfils
from dineros.runtime.nets.enabling import Enabling
from dineros.runtime.nets.structure import Structure
from dineros.runtime.nets.tokens import Token


class Kinds:
    """Tells `Enabling` how many tokens of each place fulfil what some transition asks.

    Parameters
    ----------
    structure : Structure
        The net.
    enabling : Enabling
        Counts them behind the places.

    Attributes
    ----------
    places : frozenset of int
        The places that some guard asks about.
    """

    def __init__(self, structure: Structure, enabling: Enabling) -> None:
        self._enabling = enabling
        self._at: dict[int, list[tuple[int, Condition]]] = {}
        for number, (place, condition) in enumerate(structure.kinds, len(structure.places)):
            self._at.setdefault(place, []).append((number, condition))
        self.places = frozenset(self._at)

    def change(self, place: int, tokens: Collection[Token], free: int, total: int) -> None:
        """Count tokens of an asked place: how each of them changes the free tokens and all tokens."""
        for number, condition in self._at[place]:
            count = sum(fulfils(condition, token.data) for token in tokens)
            if count:
                self._enabling.change(number, free * count, total * count)

    def hide(self, transition: int, place: int, tokens: Collection[Token]) -> None:
        """Let a transition need one token more of what its guard asks than free ones that are put aside."""
        for number, condition in self._at.get(place, ()):
            if number in self._enabling.kinds_taken[transition]:
                hidden = sum(fulfils(condition, token.data) for token in tokens)
                self._enabling.set_need(transition, number, 1 + hidden)
