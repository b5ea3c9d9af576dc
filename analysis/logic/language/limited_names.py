"""Names of a net on another one that was made of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.names import Names


@dataclass(frozen=True)
class LimitedNames:
    """Names of a net on one in which places left, and transitions became several.

    Attributes
    ----------
    original : Names
        Names of the net.
    place : mapping of int to int
        By place of the net: the one that stands for it; places that left have none.
    images : mapping of int to sequence of int
        By transition of the net: those that fire it.
    """

    original: Names
    place: Mapping[int, int]
    images: Mapping[int, Sequence[int]]

    def places(self, name: str) -> Sequence[int]:
        """Return the places that stand for those of the name."""
        return [self._there(place, name) for place in self.original.places(name)]

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transitions that fire those of the name."""
        return [image for t in self.original.transitions(name) for image in self.images.get(t, ())]

    def signal(self, name: str) -> int:
        """Return the place that stands for the signal."""
        return self._there(self.original.signal(name), name)

    def _there(self, place: int, name: str) -> int:
        if place not in self.place:
            raise FormulaError(f"the place of {name!r} is left out")
        return self.place[place]
