"""Tokens put aside for one transition after a failure: it may not take them, other transitions may."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from dineros.runtime.nets.enabling import Enabling, Kinds
from dineros.runtime.nets.passing import Tokens
from dineros.runtime.nets.structure import Structure
from dineros.runtime.nets.tokens import Token


class PutAside:
    """The tokens put aside, and the higher thresholds of the transitions that may not take them.

    Parameters
    ----------
    structure, enabling, kinds
        The structure of the net, and what decides which transitions are enabled.
    tokens : sequence of sequence of Token
        The tokens of each place; shared with the engine.
    reserved : mapping of int to int
        The reserved tokens, by id, with their places; shared with the engine.

    Attributes
    ----------
    by_transition : dict of int to dict
        Transition -> place -> ids of tokens; empty if no tokens are put aside.
    """

    def __init__(
        self,
        structure: Structure,
        enabling: Enabling,
        kinds: Kinds,
        tokens: Sequence[Sequence[Token]],
        reserved: Mapping[int, int],
    ) -> None:
        self.by_transition: dict[int, dict[int, set[int]]] = {}
        self._structure = structure
        self._enabling = enabling
        self._kinds = kinds
        self._tokens = tokens
        self._reserved = reserved

    def put(self, transition: int, taken: Tokens) -> None:
        """Keep a transition from taking these free tokens."""
        by_place = self.by_transition.setdefault(transition, {})
        for place, tokens in taken:
            by_place.setdefault(place, set()).update(token.id for token in tokens)
        self.refresh(place for place, _ in taken)

    def tokens(self) -> dict[int, dict[int, frozenset[int]]]:
        """Return the tokens put aside: transition -> place -> ids."""
        return {
            transition: {place: frozenset(ids) for place, ids in by_place.items()}
            for transition, by_place in self.by_transition.items()
        }

    def release(self, transition: int) -> dict[int, frozenset[int]]:
        """Let a transition take again the tokens put aside for it; return them: place -> ids."""
        released = self.tokens().get(transition, {})
        if released:
            self.by_transition[transition] = {place: set() for place in released}
            self.refresh(released)
            del self.by_transition[transition]
        return released

    def refresh(self, places: Iterable[int]) -> None:
        """Raise the thresholds by the number of free tokens put aside."""
        for place in set(places):
            for transition, by_place in self.by_transition.items():
                if place in by_place:
                    hidden = [
                        token
                        for token in self._tokens[place]
                        if token.id in by_place[place] and token.id not in self._reserved
                    ]
                    weight = dict(self._structure.inputs[transition])[place]
                    self._enabling.set_need(transition, place, weight + len(hidden))
                    self._kinds.hide(transition, place, hidden)

    def forget(self, taken: Tokens) -> None:
        """Remove tokens that no longer exist."""
        for place, tokens in taken:
            gone = {token.id for token in tokens} - {token.id for token in self._tokens[place]}
            for by_place in self.by_transition.values():
                if place in by_place:
                    by_place[place] -= gone
        self.refresh(place for place, _ in taken)
        for transition, by_place in list(self.by_transition.items()):
            if kept := {place: ids for place, ids in by_place.items() if ids}:
                self.by_transition[transition] = kept
            else:
                del self.by_transition[transition]
