"""Walks that note the way to what they meet: a transition that is enabled, a deadlock, tokens that grow.

A walk is repeated by its firings. So whatever is met far away has a firing sequence, however many markings
lie between; it is a long one as a rule, and is shortened before it is shown.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import partial
from math import inf

import numpy as np

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.coverability import Pumping, can_repeat
from dineros.analysis.nets.shortening import shortened
from dineros.analysis.nets.witness import replay
from dineros.analysis.walks.arrays import Int64Array, NetArrays
from dineros.analysis.walks.causal_past import CausalPast
from dineros.analysis.walks.kernels.walks import DEADLOCK, GREW, scout
from dineros.analysis.walks.used_part import UsedPart

SHORTEST_WALK, LONGEST_WALK = 1 << 6, 1 << 15
"""Firings of a walk before another one begins: short ones at first, longer ones later, and again."""

MOST_FIRINGS = 1 << 18
"""Firings of a walk that is aimed at something, at most."""

SHORTENING = 500_000
"""Firings that may be tried to shorten a way."""

MOST_TOKENS = 1_000_000
"""Tokens of a way, at most, that are followed one by one to find what it needs."""


class Scout:
    """Walks through a net, each from the initial marking.

    Attributes
    ----------
    ways : dict of int to tuple of int
        By transition that was met: the shortest sequence seen that ends with it.
    deadlock : tuple of int or None
        A sequence to a marking that enables nothing.
    pumping : Pumping or None
        A loop that was met which leaves more tokens than it found, replayed.
    last : int64 array
        The firings of the last walk.
    work : int
        How many firings all walks took so far, or would have taken in the time of other work.
    """

    def __init__(self, net: CompiledNet) -> None:
        self.net = net
        self.ways: dict[int, tuple[int, ...]] = {}
        self.deadlock: tuple[int, ...] | None = None
        self.pumping: Pumping | None = None
        self.last: Int64Array = np.empty(0, dtype=np.int64)
        self.work = 0
        self._arrays = NetArrays(net)
        self._random = np.random.default_rng(1)
        self._sequence = np.empty(MOST_FIRINGS, dtype=np.int64)
        self._length = SHORTEST_WALK
        self._known = np.full(len(net.transitions), np.iinfo(np.int64).max)

    def begin(self, *seeds: int) -> None:
        """Begin a row of walks that does not depend on the walks before it, and forget the loop they met."""
        self._random = np.random.default_rng([1, len(seeds), *seeds])
        self._length = SHORTEST_WALK
        self.pumping = None

    def walk(
        self,
        counts: Int64Array | None = None,
        growing: Collection[int] = (),
        length: int | None = None,
    ) -> bool:
        """Walk once; return whether something was met for the first time.

        Parameters
        ----------
        counts : int64 array, optional
            By transition, how often it is to be fired before others, again and again.
        growing : collection of int
            Places of which a loop that adds tokens is looked for; it ends the walk.
        length : int, optional
            Firings at most; by default from few to many in turn.
        """
        transitions, places = len(self.net.transitions), len(self.net.places)
        if not transitions:
            return False
        wanted = np.zeros(places, dtype=np.bool_)
        wanted[list(growing)] = True
        first = np.full(transitions, -1, dtype=np.int64)
        sequence = self._sequence[: min(length or self._length, MOST_FIRINGS)]
        firings, ending, start = scout(
            self._arrays.parts,
            self.net.initial,
            self._random.random(transitions),
            np.zeros(transitions, dtype=np.int64) if counts is None else counts,
            wanted,
            sequence,
            first,
            int(self._random.integers(1 << 31)),
        )
        if length is None:
            self._length = SHORTEST_WALK if self._length >= LONGEST_WALK else 4 * self._length
        self.last = sequence[:firings].copy()
        self.work += firings + transitions + places  # each walk reads the initial marking
        is_new = self._note_ways(sequence, first)
        if ending == DEADLOCK and (self.deadlock is None or firings < len(self.deadlock)):
            is_new |= self.deadlock is None
            self.deadlock = tuple(sequence[:firings].tolist())
        if ending == GREW and self.pumping is None:
            self.pumping = _loop(self.net, sequence[:start].tolist(), sequence[start:firings].tolist())
            is_new |= self.pumping is not None
        return is_new

    def taken(self) -> list[Pumping]:
        """Return the loop that was met, if there is one, and look for another one from now on."""
        taken, self.pumping = self.pumping, None
        return [] if taken is None else [taken]

    def _note_ways(self, sequence: Int64Array, first: Int64Array) -> bool:
        """Keep the ways that are new, or shorter than those known."""
        is_new = False
        for t in np.flatnonzero((first >= 0) & (first < self._known)).tolist():
            is_new |= t not in self.ways
            self._known[t] = first[t]
            self.ways[t] = (*sequence[: first[t]].tolist(), t)
        return is_new


def short_way(net: CompiledNet, way: Sequence[int]) -> tuple[int, ...]:
    """Return a way that ends with the same transition, without firings that it does not need."""
    part = UsedPart(net, way)
    *before, last = part.inside(way)
    small = part.net
    if _tokens_of(small, before) <= MOST_TOKENS:
        # Most firings of a long walk have nothing to do with the last one; trying to remove them takes long.
        needed = CausalPast(small, [*before, last]).of((), [len(before)])
        before = [before[position] for position in needed[:-1]]
    short = shortened(small, before, partial(small.is_enabled, last), SHORTENING)
    return (*part.outside(short), way[-1])


def _tokens_of(net: CompiledNet, way: Sequence[int]) -> int:
    """Return how many tokens the firings of a way take and make."""
    own = [
        sum(n for table in (net.pre, net.post) for _, n in table.row(t)) for t in range(len(net.transitions))
    ]
    return sum(own[t] for t in way)


def short_pumping(net: CompiledNet, pumping: Pumping, wanted: Collection[int]) -> Pumping:
    """Return a proof with a shorter loop, and a shorter way there, in which a wanted place grows."""
    start = replay(net, pumping.prefix)[-1]
    there = net.with_initial(dict(zip(net.places, start, strict=True)))

    def has_grown(marking: list[int]) -> bool:
        return any(marking[p] > start[p] for p in wanted) and all(
            now >= before for now, before in zip(marking, start, strict=True)
        )

    loop = shortened(there, pumping.suffix, has_grown, SHORTENING)
    rows = [(net.pre.row(t), net.inhibitor.row(t), list(net.delta[t].items())) for t in loop]
    least, below = _needs(rows)

    def can_begin(marking: list[int]) -> bool:
        return all(marking[p] >= tokens for p, tokens in least.items()) and all(
            marking[p] < tokens for p, tokens in below.items()
        )

    prefix = shortened(net, pumping.prefix, can_begin, SHORTENING)
    return _loop(net, prefix, loop) or pumping


_Arcs = Sequence[tuple[int, int]]
_Rows = Sequence[tuple[_Arcs, _Arcs, _Arcs]]
"""Of firings: what each needs, what inhibits it, and what it changes."""


def _needs(rows: _Rows) -> tuple[dict[int, int], dict[int, float]]:
    """Return how many tokens a sequence needs where it begins, and below how many it can be fired."""
    least: dict[int, int] = {}
    below: dict[int, float] = {}
    change: dict[int, int] = {}
    for needs, inhibitors, changes in rows:
        for p, weight in needs:
            least[p] = max(least.get(p, 0), weight - change.get(p, 0))
        for p, weight in inhibitors:
            below[p] = min(below.get(p, inf), weight - change.get(p, 0))
        for p, tokens in changes:
            change[p] = change.get(p, 0) + tokens
    return least, below


def _loop(net: CompiledNet, prefix: Sequence[int], suffix: Sequence[int]) -> Pumping | None:
    """Return a proof of growth; None if its loop cannot be repeated, since what grows inhibits it."""
    markings = replay(net, [*prefix, *suffix])
    start, marking = markings[len(prefix)], markings[-1]
    grown = tuple(p for p, tokens in enumerate(marking) if tokens > start[p])
    pumping = Pumping(tuple(prefix), tuple(suffix), grown)
    return pumping if can_repeat(net, pumping) else None
