"""Shortens long witnesses: repeated parts are written once, and firings are ordered so that rounds repeat."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.nets.compiled import CompiledNet, Int64Array

LONGEST_BLOCK = 60
"""Items of a block that repeats, at most."""

LEAST_SAVED = 4
"""Items that have to be saved by naming a block once."""

LEAST_STEPS, MOST_STEPS = 30, 5_000
"""Firings of a sequence that is ordered again."""


@dataclass(frozen=True)
class Block:
    """Items that repeat, or one item."""

    start: int
    length: int
    """`start`, `length`: where its first round begins, and how many items that has."""
    times: int
    """How often it comes in a row."""


def folded(items: Sequence[Hashable], values: NDArray[np.float64] | None = None) -> list[Block]:
    """Divide a sequence into blocks that repeat some items; a greedy choice makes them few.

    `values`: by item, numbers that change from one round to the next, for each item by as much each time.

    Examples
    --------
    >>> [(block.length, block.times) for block in folded("xababababababy")]
    [(1, 1), (2, 6), (1, 1)]
    """
    size = len(items)
    numbers: dict[Hashable, int] = {}
    row = np.array([numbers.setdefault(item, len(numbers)) for item in items], dtype=np.int64)
    best_saved, best_length = np.zeros(size, dtype=np.int64), np.ones(size, dtype=np.int64)
    for length in range(1, min(LONGEST_BLOCK, size // 2) + 1):
        count = size - length
        equal = _before(np.flatnonzero(row[:-length] != row[length:]), count, count)
        if values is not None:
            later = values[length:] - values[:-length]
            changes = ~np.isclose(later[:-length], later[length:], rtol=0, equal_nan=True).all(axis=1)
            equal = np.minimum(equal, length + _before(np.flatnonzero(changes), count, size))
        saved = equal // length * length
        is_better = saved > best_saved[: len(saved)]  # of equal ones, the shortest block
        best_saved[: len(saved)][is_better] = saved[is_better]
        best_length[: len(saved)][is_better] = length
    blocks: list[Block] = []
    at = 0
    while at < size:
        saved_here, length = int(best_saved[at]), int(best_length[at])
        is_block = saved_here >= LEAST_SAVED
        block = Block(at, length, 1 + saved_here // length) if is_block else Block(at, 1, 1)
        blocks.append(block)
        at += block.length * block.times
    return blocks


def _before(breaks: Int64Array, count: int, end: int) -> Int64Array:
    """By position: how many entries are before the next break, or before the end if there is none."""
    ends = np.append(breaks, end)
    places = np.arange(count)
    found: Int64Array = ends[np.searchsorted(ends[:-1], places)] - places
    return found


def in_rounds(net: CompiledNet, trace: Sequence[int]) -> tuple[int, ...]:
    """Return the same firings in an order in which rounds repeat, if that is shorter to read.

    The last firing stays the last one. After some firings, the firings that followed them before are
    repeated while they are enabled and still to be fired.
    """
    trace = tuple(trace)
    if not LEAST_STEPS <= len(trace) <= MOST_STEPS:
        return trace
    *firings, last = trace
    tried = [trace]
    for context, is_rare_first in product((1, 2, 3), (False, True)):
        ordered = _ordered(net, firings, context, is_rare_first)
        if ordered is not None:
            tried.append((*ordered, last))
    return min(tried, key=lines_of)


def lines_of(trace: Sequence[int]) -> int:
    """How many lines a sequence takes when it is printed."""
    return sum(block.length + (block.times > 1) for block in folded(trace))


def _ordered(net: CompiledNet, firings: Sequence[int], context: int, is_rare_first: bool) -> list[int] | None:
    """Fire them in an order of rounds; None if that run ends before all are fired.

    Parameters
    ----------
    context : int
        How many firings have to be the same, so that the one that followed them follows again.
    is_rare_first : bool
        Whether, where none follows, what is to be fired least often comes first; else what was fired first.
    """
    left = Counter(firings)
    needs = {t: (net.pre.row(t), net.inhibitor.row(t), list(net.delta[t].items())) for t in left}
    marking = net.initial.tolist()
    followed: dict[tuple[int, ...], int] = {}
    ordered: list[int] = []

    def can_follow(t: int) -> bool:
        inputs, inhibitors, _ = needs[t]
        return (
            left[t] > 0
            and all(marking[p] >= w for p, w in inputs)
            and all(marking[p] < w for p, w in inhibitors)
        )

    while len(ordered) < len(firings):
        before = tuple(ordered[-context:])
        wanted = followed.get(before)
        if wanted is None or not can_follow(wanted):
            able = [t for t in left if can_follow(t)]
            if not able:
                return None
            wanted = min(able, key=left.__getitem__) if is_rare_first else able[0]
        followed[before] = wanted
        left[wanted] -= 1
        ordered.append(wanted)
        for p, tokens in needs[wanted][2]:
            marking[p] += tokens
    return ordered
