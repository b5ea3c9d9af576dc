"""The first round of every question about a net: what costs little, before any engine stores markings.

Random walks meet what is not rare, however far away it is. Goals that they miss are searched for directly: a
smallest solution of the state equation says how often each transition fires on the way, and a walk fires that
first, and others only where it cannot. A place that may grow is aimed at in the same way, by firings that
take nothing and add a token there, from wherever the walk is.

References
----------
M. Blondin, C. Haase, P. Offtermatt, *Directed reachability for infinite-state systems*, TACAS 2021, LNCS
12652. Y. Thierry-Mieg, *Symbolic and structural model-checking*, Fundamenta Informaticae 183(3-4), 2021.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.evidence import Row
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.coverability import Pumping
from dineros.analysis.walks.arrays import Int64Array
from dineros.analysis.walks.firing_counts import firings
from dineros.analysis.walks.scouting import Scout, short_pumping

WORK, SHARE = (1_500_000, 4_000_000, 12_000_000), 0.1
"""Of random walks, and of walks aimed at something: firings by turn, and part of the time left for each.

Firings count, not seconds, so that the same walks are made on any machine. A turn whose firings would take
more than its part of the time left is not begun, except for the first one. What an earlier turn has found
stays as it is. So more time finds more, and shows the same run for what less time finds.
"""

FIRINGS_PER_SECOND = 5_000_000
"""Firings of walks in a second, roughly, in nets of any size."""

PROGRAM_WORK, SHORTENING_WORK = 25, 1_000_000
"""Work in firings: of an integer program, for each of its coefficients, and of shortening a loop."""

PATIENCE, LEAST_WORK = 2.0, 1_500_000
"""Random walks end after `PATIENCE` times the firings up to their last find, and at least `LEAST_WORK`."""

FRUITLESS = 5_000
"""They also end after so many in a row that find nothing: each may end after a few firings."""

TRIES, PUMPS = 16, 400
"""Walks aimed at one transition, and at a place that may grow: a loop has to close."""

LEAST_TRIES = 4
"""Walks to one transition that are compared; one quarter of all tries is made even if they take long."""

DETOUR, ROOM, DEEPER = 6, 2_000, 5
"""Firings of such a walk: so many for each that it is to fire, and some more; doubled so often, in turn."""


@dataclass
class FirstRound:
    """What is found.

    Attributes
    ----------
    ways : dict of int to tuple of int
        By transition that was met: a firing sequence that ends with it, often a long way round; `short_way`
        leaves out what it does not need.
    deadlock : tuple of int or None
        A firing sequence to a marking that enables nothing.
    pumpings : list of Pumping
        Loops that leave more tokens than they found, replayed; each adds some at a place that those before
        it leave alone.
    """

    ways: dict[int, tuple[int, ...]] = field(default_factory=dict)
    deadlock: tuple[int, ...] | None = None
    pumpings: list[Pumping] = field(default_factory=list)


def first_round(
    net: CompiledNet,
    budget: Budget,
    transitions: Iterable[int] = (),
    asks_deadlock: bool = False,
    growing: Collection[int] = (),
) -> FirstRound:
    """Look for transitions that can fire, for a deadlock, and for places that grow.

    Parameters
    ----------
    growing : collection of int
        Places of which it is asked whether they grow without bound.
    """
    work = _Round(net, budget.begun(), list(transitions), asks_deadlock)
    for turn, firings_of_turn in enumerate(WORK):
        if not work.has_time_for(turn):
            break
        budget.stage("random walks")
        work.walk(turn, firings_of_turn)
        budget.stage("walks along solutions of the state equation")
        work.aim(turn, firings_of_turn)
        work.settle()
        work.pump(turn, firings_of_turn, growing)
    return work.found


class _Round:
    def __init__(self, net: CompiledNet, budget: Budget, wanted: list[int], asks_deadlock: bool) -> None:
        self.net, self.budget, self.wanted = net, budget, wanted
        self.asks_deadlock = asks_deadlock
        self.scout = Scout(net)
        self.found = FirstRound()
        self._walks_find = True
        self._counts: dict[int, Int64Array | None] = {}
        self._growing: dict[int, list[Int64Array]] = {}
        self._program_work = PROGRAM_WORK * sum(map(len, net.delta))

    @property
    def _left(self) -> list[int]:
        return [t for t in self.wanted if t not in self.scout.ways]

    @property
    def _is_done(self) -> bool:
        return not self._left and (not self.asks_deadlock or self.scout.deadlock is not None)

    def has_time_for(self, turn: int) -> bool:
        """Whether a turn can be begun."""
        left = self.budget.left
        return turn == 0 or left is None or WORK[turn] <= SHARE * left * FIRINGS_PER_SECOND

    def settle(self) -> None:
        """Keep what has been met, as it is."""
        for t in self.wanted:
            if t in self.scout.ways:
                self.found.ways.setdefault(t, self.scout.ways[t])
        if self.asks_deadlock and self.found.deadlock is None:
            self.found.deadlock = self.scout.deadlock

    def walk(self, turn: int, most: int) -> None:
        """Walk at random, as long as that finds something."""
        if not self._walks_find:
            return
        self.scout.begin(turn)
        limit, last, fruitless = _Limit(self.scout, most, self.budget), 0, 0
        while not self._is_done and not limit.is_over and fruitless < FRUITLESS:
            if limit.spent > max(LEAST_WORK, PATIENCE * last):
                break
            fruitless += 1
            if self.scout.walk():
                last, fruitless = limit.spent, 0
        self._walks_find = PATIENCE * last >= limit.spent

    def aim(self, turn: int, most: int) -> None:
        """Walk to each remaining transition, guided by the state equation."""
        limit, left = _Limit(self.scout, most, self.budget), self._left
        for number, t in enumerate(left):
            if limit.is_over:
                return
            if t in self.scout.ways:
                continue
            self.scout.work += self._program_work
            if t not in self._counts:
                rows = [({p: 1}, weight) for p, weight in self.net.pre.row(t)]
                self._counts[t] = firings(self.net, rows)
            counts = self._counts[t]
            if counts is not None:
                self.scout.begin(turn, t)
                self._try(counts, limit.part(len(left) - number), partial(self.scout.ways.__contains__, t))

    def pump(self, turn: int, most: int, growing: Collection[int]) -> None:
        """Walk so that places grow."""
        limit = _Limit(self.scout, most, self.budget)
        nothing = self.net.with_initial(dict.fromkeys(self.net.places, 0))
        for number, place in enumerate(growing):
            if limit.is_over:
                return
            if any(place in known.places for known in self.found.pumpings):
                continue
            self.scout.work += 2 * self._program_work
            if place not in self._growing:
                self._growing[place] = self._loops(nothing, place)
            loops = self._growing[place]
            for tried, counts in enumerate(loops):
                self.scout.begin(turn, place, tried)
                own = limit.part((len(growing) - number) * (len(loops) - tried))
                self._try(counts, own, lambda: self.scout.pumping is not None, [place])
                found = self.scout.taken()
                self.scout.work += SHORTENING_WORK * len(found)
                self.found.pumpings += [short_pumping(self.net, each, [place]) for each in found]
                if found:
                    break

    def _loops(self, nothing: CompiledNet, place: int) -> list[Int64Array]:
        """Return firings of loops that add tokens to a place: at first those before which little is needed.

        A step that needs a full queue is short in the loop, but the way to it is long.
        """
        initial = self.net.initial.tolist()
        filled = [
            sum(max(0, weight - initial[p]) for p, weight in self.net.pre.row(t))
            for t in range(len(self.net.transitions))
        ]
        rows: list[Row] = [({place: 1}, 1)]
        found = [firings(nothing, rows, -1 - np.array(filled), is_loop=True)]
        found.append(firings(nothing, rows, is_loop=True))
        first, second = found
        if first is not None and second is not None and (first == second).all():
            return [first]
        return [counts for counts in found if counts is not None]

    def _try(
        self,
        counts: Int64Array,
        limit: _Limit,
        is_met: Callable[[], bool],
        growing: Collection[int] = (),
    ) -> None:
        """Walk so a few times, each further, until something is met."""
        room, tries = ROOM + DETOUR * int(counts.sum()), PUMPS if growing else TRIES
        for number in range(tries):
            if (limit.is_over and number >= tries // LEAST_TRIES) or self.budget.is_over:
                return
            # Another way to the same may be a shorter one.
            if is_met() and (growing or number >= LEAST_TRIES):
                return
            self.scout.walk(counts, growing, room << (number % DEEPER))


class _Limit:
    """A limit of the work of a scout, within a budget."""

    def __init__(self, scout: Scout, most: int, budget: Budget) -> None:
        self._scout, self._began, self._most, self._budget = scout, scout.work, most, budget

    @property
    def spent(self) -> int:
        """Work done."""
        return self._scout.work - self._began

    @property
    def is_over(self) -> bool:
        """Whether all is done."""
        return self.spent >= self._most or self._budget.is_over

    def part(self, count: int) -> _Limit:
        """Return the limit of an equal part of what is left, for one of some that are left."""
        return _Limit(self._scout, (self._most - self.spent) // count, self._budget)
