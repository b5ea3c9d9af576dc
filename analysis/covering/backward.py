"""Backward search: from what is to be covered to the smallest markings from which a firing leads there.

The markings from which a target can be covered are those above finitely many smallest ones, so the search
ends, also where Karp and Miller's tree explodes: with a smallest marking that the initial one covers, or with
none left, and then the target can never be covered. Smallest markings that the initial one cannot cover even
by the state equation are left out, with all that would come of them: weights that no firing raises, checked
in integers, serve many of them. Transitions that can never fire even in fractions, because some place before
them never gets a token, are left out beforehand.

Inhibitor arcs go as in Karp and Miller's tree: those at places with a bound become read arcs of complements,
the others are left out; then what is out of reach still is, and what is found is not a witness.

References
----------
P. A. Abdulla, K. Cerans, B. Jonsson, Y.-K. Tsay, *General decidability theorems for infinite-state systems*,
LICS 1996. M. Blondin, A. Finkel, C. Haase, S. Haddad, *Approaching the coverability problem continuously*,
TACAS 2016, LNCS 9636.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from heapq import heappop, heappush

import numpy as np

from dineros.analysis.answers.budget import Budget, Progress
from dineros.analysis.covering.distance import CoveringPrograms
from dineros.analysis.covering.tree import with_complements, without_inhibitors
from dineros.analysis.nets.compiled import ArcTable, CompiledNet
from dineros.analysis.nets.witness import replay, way_to

MOST_MINIMAL = 5_000
"""Smallest markings that a search for one target may store."""

MOST_WEIGHTS = 64
"""Weightings kept that excluded something, those used last."""

LARGEST_TOKENS = 1 << 60
"""Of a smallest marking: with more, the search gives way."""

PULL = 10
"""How many firings are worth one token that the initial marking lacks less."""

REPORTED = 500
"""Smallest markings after which progress is told."""

MARKING_BYTES = 300
"""About what a stored marking takes beside its tokens, which are stored twice."""

Marking = tuple[int, ...]


class Backward:
    """Searches of a net, one for each target; they share the weights that exclude.

    Parameters
    ----------
    net : CompiledNet
        The net.
    """

    def __init__(self, net: CompiledNet) -> None:
        self._same = with_complements(net)
        self._images = self._same.images()
        self._whole = without_inhibitors(self._same.net)
        self._is_exact = self._whole is self._same.net
        self._origin = fireable_in_fractions(self._whole)
        self._net = _with_transitions(self._whole, self._origin)
        count = range(len(self._net.transitions))
        self._needs = [self._net.pre.row(t) for t in count]
        self._changes = [list(change.items()) for change in self._net.delta]
        self._producers: list[list[int]] = [[] for _ in self._net.places]
        for t, change in enumerate(self._changes):
            for place, tokens in change:
                if tokens > 0:
                    self._producers[place].append(t)
        self._initial: Marking = tuple(self._net.initial.tolist())
        self._programs = CoveringPrograms(self._net)
        self._weightings: list[tuple[list[tuple[int, int]], int]] = []

    def way_to(
        self, transition: int, budget: Budget, most: int = MOST_MINIMAL
    ) -> tuple[tuple[int, ...] | None, bool]:
        """Search for a marking that enables a transition.

        Parameters
        ----------
        transition : int
            The transition.
        budget : Budget
            Of its time, its memory and its states.
        most : int
            Smallest markings that may be stored.

        Returns
        -------
        trace : tuple of int or None
            A firing sequence that ends with the transition.
        is_complete : bool
            Whether there is no more to be seen: without a trace, it can never fire.
        """
        is_complete = True
        for image in self._images.get(transition, ()):
            trace, ends = self._decide(dict(self._whole.pre.row(image)), budget, most)
            if trace is not None:
                return (*trace, transition), True
            is_complete = is_complete and ends
        return None, is_complete

    def covering(
        self, target: Mapping[int, int], budget: Budget, most: int = MOST_MINIMAL
    ) -> tuple[tuple[int, ...] | None, bool]:
        """Search for a marking with at least so many tokens, by place, as `way_to` does."""
        return self._decide({self._same.place[p]: tokens for p, tokens in target.items()}, budget, most)

    def _decide(
        self, target: Mapping[int, int], budget: Budget, most: int
    ) -> tuple[tuple[int, ...] | None, bool]:
        found, ends = self._search(target, budget, most)
        if found is None:
            return None, ends
        own = [self._origin[t] for t in found]
        last = replay(self._whole, own)[-1]
        assert all(last[p] >= tokens for p, tokens in target.items()), "a sequence that does not cover"
        return (self._same.back(own), True) if self._is_exact else (None, False)

    def _search(self, target: Mapping[int, int], budget: Budget, most: int) -> tuple[list[int] | None, bool]:
        start = tuple(target.get(p, 0) for p in range(len(self._initial)))
        if max(start, default=0) > LARGEST_TOKENS:
            return None, False
        if self._is_excluded(start):
            return None, True
        marking_bytes = MARKING_BYTES + 16 * len(start)
        limits = (most, budget.states, budget.memory_bytes and budget.memory_bytes // marking_bytes)
        most = min(limit for limit in limits if limit is not None)
        minimal = _Minimal(len(start))
        minimal.add(start)
        parents, depths = [(-1, -1)], [0]
        queue, told = [(self._lacking(start), 0)], 0
        while queue:
            if budget.is_over:
                return None, False
            if budget.progress is not None and len(parents) > told + REPORTED:
                told = len(parents)
                budget.progress(Progress("markings", told, told * marking_bytes))
            _, node = heappop(queue)
            if not minimal.holds(node):
                continue
            marking = minimal.markings[node]
            if self._lacking(marking) == 0:
                return list(reversed(way_to(parents, node))), True
            for t in self._leading_to(marking):
                before = self._before(t, marking)
                if minimal.has_below(before) or self._is_excluded(before):
                    continue
                if len(parents) >= most or max(before) > LARGEST_TOKENS:
                    return None, False
                minimal.add(before)
                parents.append((node, t))
                depths.append(depths[node] + 1)
                heappush(queue, (depths[-1] + PULL * self._lacking(before), len(parents) - 1))
                if not minimal.holds(node):
                    break
        return None, True

    def _leading_to(self, marking: Marking) -> list[int]:
        """Transitions that put tokens where the marking has some: before all others, more is needed."""
        return sorted({t for p, tokens in enumerate(marking) if tokens for t in self._producers[p]})

    def _before(self, t: int, marking: Marking) -> Marking:
        """The smallest marking from which a firing leads to this one or more."""
        before = list(marking)
        for place, tokens in self._changes[t]:
            before[place] = max(0, before[place] - tokens)
        for place, weight in self._needs[t]:
            before[place] = max(before[place], weight)
        return tuple(before)

    def _lacking(self, marking: Marking) -> int:
        return sum(max(0, wanted - there) for wanted, there in zip(marking, self._initial, strict=True))

    def _is_excluded(self, marking: Marking) -> bool:
        """Whether weights prove that the initial marking never leads to this one or more."""
        if self._lacking(marking) == 0:
            return False
        for number, (weights, there) in enumerate(self._weightings):
            if sum(w * marking[p] for p, w in weights) > there:
                self._weightings.insert(0, self._weightings.pop(number))
                return True
        target = {p: tokens for p, tokens in enumerate(marking) if tokens}
        proof = self._programs.excluding(self._initial, target)
        if proof is None:
            return False
        there = sum(w * self._initial[p] for p, w in proof.items())
        self._weightings.insert(0, (list(proof.items()), there))
        del self._weightings[MOST_WEIGHTS:]
        return True


class _Minimal:
    """Markings none of which is above another; each keeps its number when a smaller one takes its place."""

    def __init__(self, places: int) -> None:
        self.markings: list[Marking] = []
        self._rows = np.zeros((64, places), dtype=np.int64)
        self._holds = np.zeros(64, dtype=np.bool_)

    def holds(self, number: int) -> bool:
        """Whether no smaller marking has come since."""
        return bool(self._holds[number])

    def has_below(self, marking: Marking) -> bool:
        """Whether one of them is not above this one in any place."""
        size = len(self.markings)
        below = (self._rows[:size] <= np.array(marking)).all(axis=1)
        return bool((below & self._holds[:size]).any())

    def add(self, marking: Marking) -> None:
        """Add one that has none below; those above it leave."""
        size = len(self.markings)
        self._holds[:size] &= ~(self._rows[:size] >= np.array(marking)).all(axis=1)
        if size == len(self._holds):
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])
            self._holds = np.concatenate([self._holds, np.zeros_like(self._holds)])
        self._rows[size], self._holds[size] = marking, True
        self.markings.append(marking)


def fireable_in_fractions(net: CompiledNet) -> list[int]:
    """Transitions before which every place can get a token; no other can fire, not even in fractions.

    The forward part of the fixed point of E. Fraca and S. Haddad, *Complexity analysis of continuous Petri
    nets*, Fundamenta Informaticae 137(1), 2015. Inhibitor arcs are not looked at.

    Examples
    --------
    >>> rows = [("stay", {"a": 1}, {"a": 1}), ("turn", {"b": 1}, {"b": 2})]
    >>> fireable_in_fractions(CompiledNet.build({"a": 1, "b": 0}, rows))
    [0]
    """
    missing = [len(net.pre.row(t)) for t in range(len(net.transitions))]
    fired = [t for t, count in enumerate(missing) if count == 0]
    marked = {p for p, tokens in enumerate(net.initial.tolist()) if tokens}
    fresh = sorted(marked)
    told = 0
    while fresh or told < len(fired):
        for place in fresh:
            for t in net.consumers[place]:
                missing[t] -= 1
                if missing[t] == 0:
                    fired.append(t)
        made = {p for t in fired[told:] for p, _ in net.post.row(t)} - marked
        told = len(fired)
        marked |= made
        fresh = sorted(made)
    return sorted(fired)


def _with_transitions(net: CompiledNet, kept: Sequence[int]) -> CompiledNet:
    """Return the net with some of its transitions only."""
    names = tuple(net.transitions[t] for t in kept)
    pre, post, inhibitor = (
        ArcTable.from_rows([dict(table.row(t)) for t in kept]) for table in (net.pre, net.post, net.inhibitor)
    )
    return CompiledNet(net.places, names, net.initial, pre, post, inhibitor)
