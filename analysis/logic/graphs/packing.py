"""Markings packed into 64-bit words, a field per place with one guard bit on top.

The guard bit is 0 in every stored marking. That makes enabling and overflow a few operations per word instead
of per place: subtracting arc weights from a word with all guards set keeps a guard exactly where the tokens
suffice, and a guard that is set after firing tells that a field is too small. Fields start small and are
widened when that happens, so no bounds need to be known and nets may be unbounded.

References
----------
H. S. Warren, *Hacker's Delight*, 2nd ed., 2013, section 2-18 (arithmetic on the fields of a word).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.nets.compiled import CompiledNet

Words = NDArray[np.uint64]

WIDEST_FIELD = 62
"""Most bits for the tokens of one place."""


@dataclass(frozen=True)
class Layout:
    """Where the tokens of each place stand.

    Attributes
    ----------
    bits : tuple of int
        Bits for the tokens of each place, without the guard.
    extra : int
        Bits of one more field, for the state of an automaton; may be 0.
    """

    bits: tuple[int, ...]
    extra: int = 0

    @classmethod
    def smallest(cls, net: CompiledNet, extra: int = 0) -> Layout:
        """Return the smallest layout that holds the initial marking and every arc's weight."""
        largest = net.initial.tolist()
        for table in (net.pre, net.post, net.inhibitor):
            for place, weight in zip(table.place.tolist(), table.weight.tolist(), strict=True):
                largest[place] = max(largest[place], weight)
        return cls(tuple(max(1, tokens.bit_length()) for tokens in largest), extra)

    @cached_property
    def fields(self) -> tuple[tuple[int, int], ...]:
        """(word, shift) of each place, then of the additional field."""
        found, word, used = [], 0, 0
        for bits in (*self.bits, self.extra):
            if used + bits + 1 > 64:
                word, used = word + 1, 0
            found.append((word, used))
            used += bits + 1
        return tuple(found)

    @property
    def words(self) -> int:
        """Words per marking."""
        return self.fields[-1][0] + 1

    @cached_property
    def guards(self) -> Words:
        """The guard bits of all places, by word."""
        guards = [0] * self.words
        for bits, (word, shift) in zip(self.bits, self.fields, strict=False):
            guards[word] |= 1 << (shift + bits)
        return np.array(guards, dtype=np.uint64)

    def pack(self, marking: Sequence[int], extra: int = 0) -> Words:
        """Return a marking as words."""
        words = [0] * self.words
        for tokens, (word, shift) in zip((*marking, extra), self.fields, strict=True):
            words[word] |= int(tokens) << shift
        return np.array(words, dtype=np.uint64)

    def unpack(self, words: Words) -> tuple[int, ...]:
        """Return the tokens of every place."""
        plain = words.tolist()
        return tuple(
            plain[word] >> shift & ((1 << bits) - 1)
            for bits, (word, shift) in zip(self.bits, self.fields, strict=False)
        )

    def sum_by_word(self, amounts: dict[int, int]) -> list[tuple[int, int]]:
        """Return pairs (word, value): amounts by place, shifted to their fields and added, modulo 2**64."""
        values: dict[int, int] = {}
        for place, amount in amounts.items():
            word, shift = self.fields[place]
            values[word] = (values.get(word, 0) + (amount << shift)) % 2**64
        return sorted(values.items())

    def widened(self, marking: Sequence[int]) -> Layout:
        """Return a layout that also holds this marking.

        Raises
        ------
        OverflowError
            If a place holds more tokens than fit into `WIDEST_FIELD` bits.
        """
        bits = tuple(max(have, tokens.bit_length()) for have, tokens in zip(self.bits, marking, strict=True))
        if max(bits, default=0) > WIDEST_FIELD:
            raise OverflowError("a place holds too many tokens")
        return Layout(bits, self.extra)

    def convert(self, words: Words, target: Layout) -> Words:
        """Return rows of this layout in a wider layout."""
        result = np.zeros((len(words), target.words), dtype=np.uint64)
        widths = (*self.bits, self.extra)
        for bits, (word, shift), (new_word, new_shift) in zip(
            widths, self.fields, target.fields, strict=True
        ):
            field = words[:, word] >> np.uint64(shift)
            field &= np.uint64((1 << bits) - 1)
            field <<= np.uint64(new_shift)
            result[:, new_word] |= field
        return result
