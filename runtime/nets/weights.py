"""Limits the bytes of token data on places that other participants can fill.

A maximum number of tokens bounds memory only if messages are small. So for a place without a capacity in the
model that others can fill, the approximate size of its tokens is counted, too. At the size limit the place
has no room, as at its token limit, until tokens are taken. There is always room for the tokens of one firing,
and for a few tokens, whose size is not counted.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from dineros.runtime.nets.enabling import Enabling
from dineros.runtime.nets.ports import Data
from dineros.runtime.nets.structure import Structure
from dineros.runtime.nets.tokens import Token

MOST_BYTES = 64 << 20
"""Approximate maximum bytes of the tokens of such a place; the last token may exceed it."""

FEW = 8
"""With at most this number of tokens, sizes are not counted: counting would dominate firing costs."""

_CLOSED = 1 << 40
"""Room subtracted from a place at its size limit: more than any place has."""
_NUMBER = 8
"""Bytes of a number or a Boolean."""


def size_of(data: Data) -> int:
    """Return the approximate size of token data, in bytes.

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
    """Counts bytes on places whose limit is not given by the model.

    Parameters
    ----------
    structure : Structure
        The net.
    enabling : Enabling
        Receives the places that no longer have room, and those that have room again.
    tokens : sequence of iterable of Token
        The tokens of each place.

    Attributes
    ----------
    places : frozenset of int
        The places whose bytes are counted.
    heavy : set of int
        The places at their size limit.
    counted : dict of int to int
        Bytes on each place with more than a few tokens. Read-only for callers.
    """

    def __init__(self, structure: Structure, enabling: Enabling, tokens: Sequence[Iterable[Token]]) -> None:
        self._enabling, self._tokens = enabling, tokens
        self.places = frozenset(
            place
            for place, limit in enumerate(structure.limits)
            if limit is not None and structure.capacities[place] is None
        )
        self.heavy: set[int] = set()
        self.counted: dict[int, int] = {}
        self._needs = dict.fromkeys(self.places, 1)
        for arcs in (*structure.inputs, *structure.reads):
            for place, weight in arcs:
                if place in self.places:
                    self._needs[place] = max(self._needs[place], weight)

    def add(self, place: int, tokens: Iterable[Token]) -> None:
        """Count tokens that were put on such a place."""
        if self._enabling.total[place] <= FEW:
            return
        known = self.counted.get(place)
        # The place has more than a few tokens from now on: all of them are counted once.
        added = tokens if known is not None else self._tokens[place]
        self._note(place, (known or 0) + sum(size_of(token.data) for token in added))

    def remove(self, place: int, tokens: Iterable[Token]) -> None:
        """Stop counting tokens that were removed from such a place."""
        known = self.counted.get(place)
        if known is None:
            return
        if self._enabling.total[place] <= FEW:
            self._note(place, 0)
            del self.counted[place]
        else:
            self._note(place, known - sum(size_of(token.data) for token in tokens))

    def _note(self, place: int, total: int) -> None:
        self.counted[place] = total
        is_heavy = total >= MOST_BYTES and self._enabling.total[place] >= self._needs[place]
        if is_heavy is not (place in self.heavy):
            self._enabling.change_room(place, -_CLOSED if is_heavy else _CLOSED)
            (self.heavy.add if is_heavy else self.heavy.discard)(place)
