"""Finite sorts: the colours that tokens can have (ISO/IEC 15909-2, clause 5.3, symmetric nets).

The values of a sort are the numbers from 0 to `size` - 1, in the order of the declaration.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property


@dataclass(frozen=True)
class Sort:
    """A finite set of colours.

    Attributes
    ----------
    name : str
        Name for messages.
    """

    name: str

    @property
    def size(self) -> int:
        """Number of colours."""
        raise NotImplementedError

    def label(self, value: int) -> str:
        """Return the name of a colour."""
        raise NotImplementedError


@dataclass(frozen=True)
class Enumeration(Sort):
    """A list of colours. Enumerations with different names are different sorts."""

    labels: tuple[str, ...] = field(compare=False)

    @property
    def size(self) -> int:
        """Number of colours."""
        return len(self.labels)

    def label(self, value: int) -> str:
        """Return the name of a colour."""
        return self.labels[value]


@dataclass(frozen=True)
class IntegerRange(Sort):
    """Whole numbers from `first` to `last`; ranges with the same bounds are the same sort."""

    name: str = field(compare=False)
    first: int
    last: int

    @property
    def size(self) -> int:
        """Number of colours."""
        return self.last - self.first + 1

    def label(self, value: int) -> str:
        """Return the number."""
        return str(self.first + value)


@dataclass(frozen=True)
class Product(Sort):
    """Tuples of colours, the last component varies fastest; products of the same sorts are the same sort."""

    name: str = field(compare=False)
    parts: tuple[Sort, ...]

    @cached_property
    def size(self) -> int:
        """Number of colours."""
        return math.prod(part.size for part in self.parts)

    @cached_property
    def _factors(self) -> tuple[tuple[int, int], ...]:
        """For each component: its number of values, and the distance of two of them."""
        found, distance = [], 1
        for part in reversed(self.parts):
            found.append((part.size, distance))
            distance *= part.size
        return tuple(reversed(found))

    def split(self, value: int) -> tuple[int, ...]:
        """Return the components of a tuple."""
        return tuple(value // distance % size for size, distance in self._factors)

    def join(self, components: Sequence[int]) -> int:
        """Return the tuple with these components."""
        return sum(value * distance for value, (_, distance) in zip(components, self._factors, strict=True))

    def label(self, value: int) -> str:
        """Return the labels of the components, with commas."""
        return ",".join(part.label(each) for part, each in zip(self.parts, self.split(value), strict=True))


DOT = Enumeration("dot", ("dot",))
"""The one colour of plain tokens."""
BOOL = Enumeration("bool", ("false", "true"))
"""The truth values."""
