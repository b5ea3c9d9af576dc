"""Packed markings: the representation of a marking in few machine words.

Places are combined into *cells*. A cell's tokens are numbered by a linear *code*, the sum of factor times
tokens, which is different for all combinations that the invariants allow. Places that are determined by
others have the factor 0 and need no bits, and k places that share one token need log2 k bits. As codes are
linear, firing a transition adds one constant to each word of the marking. Unbounded places have their own
cells, with a guard bit that detects an overflow.

References
----------
K. Schmidt, *Using Petri net invariants in state space construction*, TACAS 2003, LNCS 2619 (leaving out
places that invariants determine). H. S. Warren, *Hacker's Delight*, 2nd ed., 2013, section 2-18 (arithmetic
on fields of a word).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.nets.bounds import flows_and_bounds, of_part
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.structure import PlaceInvariant, place_invariants, proportional_places

Int64Array = NDArray[np.int64]

#: Maximum number of codes of a cell: tables by code must fit into the cache of a core.
LARGEST_CELL = 256
#: Maximum number of combinations examined while cells are joined.
LARGEST_JOIN = 1 << 14
#: Initial number of bits of an unbounded place.
FIRST_BITS = 6
WORD_BITS = 64
#: Most bits of a place, one less than a positive word for its guard.
WIDEST = 61


class TooManyTokensError(OverflowError):
    """A place has more tokens than fit into a word."""


@dataclass(frozen=True)
class Cell:
    """Some places, with the representation of their tokens.

    Attributes
    ----------
    factors : tuple of int
        The code is the sum of factor times tokens.
    values : int64 array, shape (codes, places), optional
        Tokens by code, -1 in codes that do not occur. None for a *wide* cell: one place, whose code is its
        tokens.
    bits : int
        Bits of the code.
    has_guard : bool
        Whether the next higher bit is kept free to detect an overflow.
    """

    places: tuple[int, ...]
    factors: tuple[int, ...]
    values: Int64Array | None
    bits: int
    has_guard: bool = False


@dataclass(frozen=True)
class Layout:
    """Cells and their positions in the words of a marking."""

    cells: tuple[Cell, ...]
    word: Int64Array
    shift: Int64Array
    words: int

    @classmethod
    def of(cls, cells: Sequence[Cell]) -> Layout:
        """Assign a position to each cell: widest first, each in the first word with room."""
        used: list[int] = []
        word = np.zeros(len(cells), dtype=np.int64)
        shift = np.zeros(len(cells), dtype=np.int64)
        for k in sorted(range(len(cells)), key=lambda k: -cells[k].bits - cells[k].has_guard):
            size = cells[k].bits + cells[k].has_guard
            at = next((w for w, bits in enumerate(used) if bits + size <= WORD_BITS), len(used))
            if at == len(used):
                used.append(0)
            word[k], shift[k] = at, min(used[at], WORD_BITS - 1)
            used[at] += size
        return cls(tuple(cells), word, shift, max(1, len(used)))

    def with_number(self, size: int) -> Layout:
        """Return the layout with an additional last cell, for a number below `size` that is no place's."""
        return Layout.of(
            [*self.cells, Cell((), (), np.zeros((size, 0), dtype=np.int64), (size - 1).bit_length())]
        )

    @property
    def is_bounded(self) -> bool:
        """Whether no place can overflow its cell."""
        return not any(cell.has_guard for cell in self.cells)

    @property
    def masks(self) -> Int64Array:
        """For each cell, the mask of its code."""
        return np.array([(1 << cell.bits) - 1 for cell in self.cells], dtype=np.int64)

    @property
    def guards(self) -> Int64Array:
        """For each word, its guard bits."""
        guards = [0] * self.words
        for k, cell in enumerate(self.cells):
            if cell.has_guard:
                guards[self.word[k]] |= 1 << int(self.shift[k]) + cell.bits
        return signed(guards)

    def pack(self, tokens: Sequence[int] | dict[int, int]) -> Int64Array:
        """Words of a marking, or of a change of a marking (place -> tokens)."""
        words = [0] * self.words
        for place, amount in tokens.items() if isinstance(tokens, dict) else enumerate(tokens):
            word, factor = self._homes[place]
            words[word] += amount * factor
        return signed(words)

    @cached_property
    def _homes(self) -> dict[int, tuple[int, int]]:
        """For each place, its word, and the increment of that for one token."""
        return {
            place: (word, factor << shift)
            for cell, word, shift in zip(self.cells, self.word.tolist(), self.shift.tolist(), strict=True)
            for place, factor in zip(cell.places, cell.factors, strict=True)
        }

    def unpack(self, words: Int64Array) -> list[int]:
        """Tokens of every place."""
        plain = [value % 2**WORD_BITS for value in words.tolist()]
        tokens = [0] * sum(len(cell.places) for cell in self.cells)
        for k, cell in enumerate(self.cells):
            code = plain[self.word[k]] >> int(self.shift[k]) & ((1 << cell.bits) - 1)
            found = [code] if cell.values is None else cell.values[code].tolist()
            for place, value in zip(cell.places, found, strict=True):
                tokens[place] = value
        return tokens

    def overflowing(self, net: CompiledNet, marking: Sequence[int]) -> set[int]:
        """Places that overflow their cells by some firing in a marking."""
        sizes = {cell.places[0]: 1 << cell.bits for cell in self.cells if cell.has_guard}
        return {
            place
            for t in range(len(net.transitions))
            if net.is_enabled(t, marking)
            for place, tokens in net.delta[t].items()
            if place in sizes and marking[place] + tokens >= sizes[place]
        }

    def widened(self, places: set[int]) -> Layout:
        """The same cells with twice the bits for some wide ones."""
        cells = []
        for cell in self.cells:
            if cell.values is None and cell.places[0] in places:
                if cell.bits == WIDEST:
                    raise TooManyTokensError("a place holds too many tokens")
                cells.append(replace(cell, bits=min(2 * cell.bits, WIDEST)))
            else:
                cells.append(cell)
        return Layout.of(cells)


def signed(words: Sequence[int]) -> Int64Array:
    """Words, modulo 2**64, as signed numbers of the same bits."""
    return np.array([word % 2**WORD_BITS for word in words], dtype=np.uint64).view(np.int64)


def layout(net: CompiledNet) -> Layout:
    """Choose cells for the places of a net; call it by `CompiledNet.once`."""
    cells = _joined_by_use(net, net.once(small_cells))
    for p, proved in enumerate(net.once(flows_and_bounds)[1]):
        bound = None if proved is None else proved.value
        if bound is None:
            cells.append(Cell((p,), (1,), None, _first_bits(net, p), has_guard=True))
        elif bound >= LARGEST_CELL:
            if bound.bit_length() > WIDEST:
                raise TooManyTokensError(f"place {net.places[p]!r} may hold too many tokens")
            cells.append(Cell((p,), (1,), None, bound.bit_length()))
    return Layout.of(cells)


def small_cells(net: CompiledNet) -> list[Cell]:
    """Return cells of places that invariants connect, without those with many tokens or no known bound."""
    flows, bounds = net.once(flows_and_bounds)
    known = [*place_invariants(net), *(proportional_places(net) if flows is None else flows)]
    limits = {tuple(y.weights.items()): y for y in known}
    parts = [
        _LayoutPart((p,), np.arange(b.value + 1)[:, None])
        for p, b in enumerate(bounds)
        if b is not None and b.value < LARGEST_CELL
    ]
    parts = _joined_by_invariants(
        parts, sorted(limits.values(), key=lambda y: (len(y.weights), abs(y.constant)))
    )
    return [_encoded(part) for part in parts]


def learn_of_whole(part: CompiledNet, whole: CompiledNet, number: Mapping[int, int]) -> None:
    """Tell a part of a net what its layout needs, as far as the whole net has it.

    Each transition of the whole net changes only places of the part, or only others.

    Parameters
    ----------
    number
        For each place of the part, by its number in the whole net, its number in the part.
    """
    facts = whole.once(flows_and_bounds)
    if facts[0] is None:
        return  # the part alone may have few semiflows
    part.know(flows_and_bounds, of_part(facts, part, number))
    cells = [
        replace(cell, places=tuple(number[p] for p in cell.places))
        for cell in whole.once(small_cells)
        if cell.places[0] in number
    ]
    part.know(small_cells, cells)


def _first_bits(net: CompiledNet, place: int) -> int:
    """Number of bits such that one firing from any value in them cannot pass the guard."""
    largest = int(net.initial[place])
    for table in (net.pre, net.post, net.inhibitor):
        largest = max(largest, int(table.weight[table.place == place].max(initial=0)))
    if largest.bit_length() > WIDEST:
        raise TooManyTokensError(f"place {net.places[place]!r} holds too many tokens")
    return max(FIRST_BITS, largest.bit_length())


@dataclass(frozen=True)
class _LayoutPart:
    """Places with the combinations of their tokens that are not known to be impossible."""

    places: tuple[int, ...]
    states: Int64Array


def _joined_by_invariants(
    parts: list[_LayoutPart], invariants: Sequence[PlaceInvariant]
) -> list[_LayoutPart]:
    """Join the parts that an invariant connects, if few combinations result."""
    home = {p: part for part in parts for p in part.places}
    for y in invariants:
        if not y.weights.keys() <= home.keys():
            continue
        joined = _join(list({id(home[p]): home[p] for p in y.weights}.values()), y)
        if joined is not None:
            home.update(dict.fromkeys(joined.places, joined))
    return list({id(part): part for part in home.values()}.values())


def _join(parts: list[_LayoutPart], y: PlaceInvariant) -> _LayoutPart | None:
    sums = [part.states @ np.array([y.weights.get(p, 0) for p in part.places]) for part in parts]
    if len(parts) == 1 and (sums[0] == y.constant).all():
        return None  # known before
    if not 0 < _combinations(sums, y.constant) <= LARGEST_CELL:
        return None
    smallest, largest = sum(int(s.min()) for s in sums), sum(int(s.max()) for s in sums)
    places: tuple[int, ...] = ()
    states = np.zeros((1, 0), dtype=np.int64)
    total = np.zeros(1, dtype=np.int64)
    for part, gain in zip(parts, sums, strict=True):
        if len(states) * len(gain) > LARGEST_JOIN:
            return None
        smallest, largest = smallest - int(gain.min()), largest - int(gain.max())
        both = total[:, None] + gain[None, :]
        # The remaining places must be able to complete the sum.
        left, right = np.nonzero((both + smallest <= y.constant) & (both + largest >= y.constant))
        states = np.hstack([states[left], part.states[right]])
        total = both[left, right]
        places += part.places
    return _LayoutPart(places, states)


def _combinations(sums: Sequence[Int64Array], constant: int) -> int:
    """Number of ways to choose one number of each array with a constant sum; 0: too many."""
    smallest, largest = sum(int(s.min()) for s in sums), sum(int(s.max()) for s in sums)
    ways = {0: 1}
    for numbers in sums:
        counts = Counter(numbers.tolist())
        if len(ways) * len(counts) > LARGEST_JOIN:
            return 0
        smallest, largest = smallest - min(counts), largest - max(counts)
        both: dict[int, int] = {}
        for total, number in ways.items():
            for gain, times in counts.items():
                if smallest <= constant - total - gain <= largest:
                    both[total + gain] = both.get(total + gain, 0) + number * times
        ways = both
    return ways.get(constant, 0)


def _encoded(part: _LayoutPart) -> Cell:
    """Return a code for a part: each factor is the smallest one that distinguishes all combinations."""
    kept = list(range(len(part.places)))
    largest = part.states.max(axis=0)
    if len(part.places) > 1:
        for k in sorted(kept, key=lambda k: -int(largest[k])):
            rest = [other for other in kept if other != k]
            if _different(part.states[:, rest]) == len(part.states):
                kept = rest
    factors = [0] * len(part.places)
    codes = np.zeros(len(part.states), dtype=np.int64)
    done: list[int] = []
    for k in sorted(kept, key=lambda k: int(largest[k])):
        done.append(k)
        different = _different(part.states[:, done])
        # If the first factor exceeds all codes so far, all codes differ, so the search ends.
        factors[k] = next(
            a
            for a in range(1, int(codes.max()) + 2)
            if len(set((codes + a * part.states[:, k]).tolist())) == different
        )
        codes = codes + factors[k] * part.states[:, k]
    values = np.full((int(codes.max()) + 1, len(part.places)), -1, dtype=np.int64)
    values[codes] = part.states
    return Cell(part.places, tuple(factors), values, (len(values) - 1).bit_length())


def _different(rows: Int64Array) -> int:
    """Count the different rows; for the few rows of a cell, a set is faster than sorting."""
    return len(set(map(tuple, rows.tolist())))


def _joined_by_use(net: CompiledNet, cells: list[Cell]) -> list[Cell]:
    """Join small cells to larger ones, first those used by the same transitions: fewer bits are wasted."""
    users: dict[int, set[int]] = {}
    for t in range(len(net.transitions)):
        for p, _ in [*net.pre.row(t), *net.inhibitor.row(t)]:
            users.setdefault(p, set()).add(t)
    touching = {id(cell): set().union(*(users.get(p, set()) for p in cell.places)) for cell in cells}
    open_cells = sorted(cells, key=lambda cell: -_codes(cell))
    result = []
    while open_cells:
        cell = open_cells.pop(0)
        touched = set(touching[id(cell)])
        while True:
            fitting = [c for c in open_cells if _codes(c) * _codes(cell) <= LARGEST_CELL]
            if not fitting:
                break
            best = max(
                fitting,
                key=lambda c: (len(touching[id(c)] & touched) - len(touching[id(c)] - touched), _codes(c)),
            )
            open_cells = [c for c in open_cells if c is not best]
            touched |= touching[id(best)]
            cell = _product(cell, best)
        result.append(cell)
    return result


def _codes(cell: Cell) -> int:
    assert cell.values is not None
    return len(cell.values)


def _product(one: Cell, other: Cell) -> Cell:
    assert one.values is not None and other.values is not None
    size = len(one.values)
    values = np.hstack([np.tile(one.values, (len(other.values), 1)), np.repeat(other.values, size, axis=0)])
    # A code does not occur if one half of it does not occur.
    values[(values < 0).any(axis=1)] = -1
    factors = one.factors + tuple(factor * size for factor in other.factors)
    return Cell(one.places + other.places, factors, values, (len(values) - 1).bit_length())
