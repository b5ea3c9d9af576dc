"""How much data the tokens of a place carry, where others can fill it: such a place has room up to a size.

A number of tokens bounds memory only while messages are small. A place without a capacity of the model that
others can fill counts, besides its tokens, about how many bytes they carry. At the limit it has no room, like
a place at its number of tokens, until some are taken. It always has room for what one firing needs, and for a
few tokens, which are not weighed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from dineros.runtime.nets.enabling import Enabling
from dineros.runtime.nets.ports import Data
from dineros.runtime.nets.structure import Structure
from dineros.runtime.nets.tokens import Token

MOST_BYTES = 64 << 20
"""Bytes, about, that the tokens of such a place carry at most, and one token more."""

FEW = 8
"""With no more tokens than this, a place is not weighed: looking at all data would cost most of a firing."""

_CLOSED = 1 << 40
"""Room that is taken from a place at its limit: more than any place has."""
_NUMBER = 8
"""Bytes of a number or a truth value."""


def size_of(data: Data) -> int:
    """Return about how many bytes token data takes.

    Examples
    --------
    >>> size_of({"name": "left", "pose": [0.0, 1.0, 2.0], "seen": True})
    36
    """
    return sum(map(_size, data.values()))


def _size(value: object) -> int:
    if isinstance(value, (str, bytes)):
        return len(value)
    if isinstance(value, Mapping):
        return size_of(value)
    if isinstance(value, Sequence):
        if value and isinstance(value[0], (str, Mapping, Sequence)):
            return sum(map(_size, value))
        return _NUMBER * len(value)
    return _NUMBER


class Weights:
    """Bytes by place, of those places that have a limit which the model does not give.

    Parameters
    ----------
    structure : Structure
        The net.
    enabling : Enabling
        Gets the places that have no room any more, and those that have room again.
    tokens : sequence of iterable of Token
        The tokens of each place.

    Attributes
    ----------
    places : frozenset of int
        The places that are weighed.
    heavy : set of int
        Those at their limit.
    """

    def __init__(self, structure: Structure, enabling: Enabling, tokens: Sequence[Iterable[Token]]) -> None:
        self._enabling, self._tokens = enabling, tokens
        self.places = frozenset(
            place
            for place, limit in enumerate(structure.limits)
            if limit is not None and structure.capacities[place] is None
        )
        self.heavy: set[int] = set()
        self._bytes: dict[int, int] = {}
        """Of the places with more than a few tokens."""
        self._needs = dict.fromkeys(self.places, 1)
        for arcs in (*structure.inputs, *structure.reads):
            for place, weight in arcs:
                if place in self.places:
                    self._needs[place] = max(self._needs[place], weight)

    def add(self, place: int, tokens: Iterable[Token]) -> None:
        """Count tokens that are on a weighed place now."""
        if self._enabling.total[place] <= FEW:
            return
        known = self._bytes.get(place)
        # The place has more than a few tokens from now on: all of them are weighed once.
        added = tokens if known is not None else self._tokens[place]
        self._note(place, (known or 0) + sum(size_of(token.data) for token in added))

    def remove(self, place: int, tokens: Iterable[Token]) -> None:
        """Count tokens no more that were on a weighed place until now."""
        known = self._bytes.get(place)
        if known is None:
            return
        if self._enabling.total[place] <= FEW:
            self._note(place, 0)
            del self._bytes[place]
        else:
            self._note(place, known - sum(size_of(token.data) for token in tokens))

    def _note(self, place: int, total: int) -> None:
        self._bytes[place] = total
        is_heavy = total >= MOST_BYTES and self._enabling.total[place] >= self._needs[place]
        if is_heavy is not (place in self.heavy):
            self._enabling.change_room(place, -_CLOSED if is_heavy else _CLOSED)
            (self.heavy.add if is_heavy else self.heavy.discard)(place)
