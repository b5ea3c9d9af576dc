"""Backward search: computes the minimal markings from which a target marking can be covered.

The markings from which a target can be covered are those above finitely many minimal ones. So the search
terminates, even if the tree of Karp and Miller is too large: either a minimal marking is covered by the
initial one, or no minimal marking is left, and the target is not coverable. Minimal markings that the initial
one cannot cover even by the state equation are discarded with all their predecessors: weights that no firing
increases, checked in integers, exclude many of them. Transitions that could not fire even if no firing took
tokens away are removed first.

Inhibitor arcs are handled as in the tree of Karp and Miller: those at bounded places become read arcs of
complements, the others are removed. Then unreachable targets are still proved, but a found sequence is not a
witness.

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
from dineros.analysis.nets.bounds import producers_of
from dineros.analysis.nets.compiled import ArcTable, CompiledNet
from dineros.analysis.nets.structure import never_possible
from dineros.analysis.nets.witness import replay, way_to

MOST_MINIMAL = 5_000
"""Maximum number of minimal markings stored for one target."""

MOST_WEIGHTS = 64
"""Number of weightings kept that excluded a marking; the last ones used are kept."""

LARGEST_TOKENS = 1 << 60
"""Maximum number of tokens of a minimal marking; with more, the search gives up."""

PULL = 10
"""Number of firings that is worth one missing token less in the initial marking."""

REPORTED = 500
"""Number of minimal markings between progress reports."""

MARKING_BYTES = 300
"""Approximate bytes of a stored marking besides its tokens, which are stored twice."""

Marking = tuple[int, ...]


class Backward:
    """Searches in a net, one for each target; they share the excluding weights."""

    def __init__(self, net: CompiledNet) -> None:
        self._same = with_complements(net)
        self._images = self._same.images()
        self._whole = without_inhibitors(self._same.net)
        self._is_exact = self._whole is self._same.net
        never = never_possible(self._whole)
        self._origin = [t for t in range(len(self._whole.transitions)) if t not in never]
        self._net = _with_transitions(self._whole, self._origin)
        count = range(len(self._net.transitions))
        self._needs = [self._net.pre.row(t) for t in count]
        self._changes = [list(change.items()) for change in self._net.delta]
        self._producers = producers_of(self._net)
        self._initial: Marking = tuple(self._net.initial.tolist())
        self._programs = CoveringPrograms(self._net)
        self._weightings: list[tuple[list[tuple[int, int]], int]] = []

    def way_to(
        self, transition: int, budget: Budget, most: int = MOST_MINIMAL
    ) -> tuple[tuple[int, ...] | None, bool]:
        """Search for a marking that enables a transition.

        Parameters
        ----------
        most : int
            Maximum number of stored minimal markings.

        Returns
        -------
        trace : tuple of int or None
            A firing sequence that ends with the transition.
        is_complete : bool
            Whether the search is exhaustive: then without a trace, the transition can never fire.
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
        """Search for a marking with at least these tokens, by place, like `way_to`."""
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
        """Transitions that put tokens on a marked place: all other predecessors need more tokens."""
        return sorted({t for p, tokens in enumerate(marking) if tokens for t in self._producers[p]})

    def _before(self, t: int, marking: Marking) -> Marking:
        """The minimal marking from which a firing leads to this marking or a larger one."""
        before = list(marking)
        for place, tokens in self._changes[t]:
            before[place] = max(0, before[place] - tokens)
        for place, weight in self._needs[t]:
            before[place] = max(before[place], weight)
        return tuple(before)

    def _lacking(self, marking: Marking) -> int:
        return sum(max(0, wanted - there) for wanted, there in zip(marking, self._initial, strict=True))

    def _is_excluded(self, marking: Marking) -> bool:
        """Whether weights prove that the initial marking never leads to this marking or a larger one."""
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
    """Pairwise incomparable markings; a marking keeps its number when a smaller one replaces it."""

    def __init__(self, places: int) -> None:
        self.markings: list[Marking] = []
        self._rows = np.zeros((64, places), dtype=np.int64)
        self._holds = np.zeros(64, dtype=np.bool_)

    def holds(self, number: int) -> bool:
        """Whether no smaller marking has been added since."""
        return bool(self._holds[number])

    def has_below(self, marking: Marking) -> bool:
        """Whether one of them is less than or equal to this one."""
        size = len(self.markings)
        below = (self._rows[:size] <= np.array(marking)).all(axis=1)
        return bool((below & self._holds[:size]).any())

    def add(self, marking: Marking) -> None:
        """Add a marking that has none below it; markings above it are removed."""
        size = len(self.markings)
        self._holds[:size] &= ~(self._rows[:size] >= np.array(marking)).all(axis=1)
        if size == len(self._holds):
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])
            self._holds = np.concatenate([self._holds, np.zeros_like(self._holds)])
        self._rows[size], self._holds[size] = marking, True
        self.markings.append(marking)


def _with_transitions(net: CompiledNet, kept: Sequence[int]) -> CompiledNet:
    """Return the net restricted to some of its transitions."""
    names = tuple(net.transitions[t] for t in kept)
    pre, post, inhibitor = (
        ArcTable.from_rows([dict(table.row(t)) for t in kept]) for table in (net.pre, net.post, net.inhibitor)
    )
    return CompiledNet(net.places, names, net.initial, pre, post, inhibitor)
