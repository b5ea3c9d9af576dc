"""Coverability: which places can hold any number of tokens, with a sequence that pumps some of them.

The minimal coverability set of Karp and Miller, by the algorithm with pruning of Reynier and Servais: a node
of the tree is a marking in which some places have omega, "any number of tokens"; branches are cut if a larger
node makes them redundant, but ancestors that were cut are still used to find repeatable sequences.

References
----------
R. M. Karp, R. E. Miller, *Parallel program schemata*, JCSS 3(2), 1969. P.-A. Reynier, F. Servais, *Minimal
coverability set for Petri nets: Karp and Miller algorithm with pruning*, Petri Nets 2011, LNCS 6709.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import WitnessError, replay

#: Tokens by place; `inf` is omega.
OmegaMarking = tuple[float, ...]


@dataclass(frozen=True)
class Pumping:
    """A proof that places are unbounded, replayed on the net.

    Attributes
    ----------
    prefix, suffix : tuple of int
        Transitions from the initial marking on, and transitions that can then be repeated forever.
    places : tuple of int
        Places that gain tokens with each repetition; no place loses any.
    """

    prefix: tuple[int, ...]
    suffix: tuple[int, ...]
    places: tuple[int, ...]


@dataclass(frozen=True)
class Coverability:
    """The known facts about the tokens of places.

    Attributes
    ----------
    is_bounded : bool or None
        Whether the net is bounded; None: unknown, see `reason`.
    bounds : tuple of float, optional
        For each place, the most tokens in a reachable marking, `inf` for no limit. None: unknown.
    pumping : Pumping, optional
        If the net is unbounded: the proof.
    maximal : tuple of tuples of float, optional
        The minimal coverability set: the maximal markings, with `inf` for omega. None: unknown.
    covered : tuple of tuples of float
        If the tree was not finished: the maximal markings so far, with `inf` for omega.
    """

    is_bounded: bool | None
    bounds: tuple[float, ...] | None = None
    pumping: Pumping | None = None
    maximal: tuple[OmegaMarking, ...] | None = None
    covered: tuple[OmegaMarking, ...] = ()
    reason: str | None = None


def coverability(
    net: CompiledNet, limit: int = 10_000, budget: Budget = UNLIMITED, only_boundedness: bool = False
) -> Coverability:
    """Decide boundedness, and the most tokens of each place.

    With inhibitor arcs the question is undecidable. The net without them has all firing sequences of the net
    and more, so its bounds hold for the net. If it is unbounded, its pumping sequence is used if the net can
    repeat it, too; otherwise the result is unknown.

    Parameters
    ----------
    limit
        Maximum number of nodes of the tree.
    only_boundedness
        Whether to stop as soon as the net is known to be unbounded.
    """
    tree = _Tree(net, limit, budget.begun(), only_boundedness)
    finished = tree.build()
    pumping = tree.pumping
    has_inhibitors = bool(net.inhibitor.place.size)
    if pumping is not None and has_inhibitors and not can_repeat(net, pumping):
        return Coverability(None, reason="inhibitor arcs: the net may or may not be unbounded")
    if pumping is not None:
        assert can_repeat(net, pumping), "a pumping sequence does not replay"
    if not finished:
        reason = f"more than {limit} nodes in the coverability tree"
        if only_boundedness and pumping is not None:
            reason = "only boundedness was asked for"
        elif tree.budget.is_over:
            reason = f"time ran out after {tree.nodes} nodes of the coverability tree"
        is_bounded = None if pumping is None else False
        return Coverability(is_bounded, pumping=pumping, covered=tree.maximal(), reason=reason)
    maximal = tree.maximal()
    bounds = tuple(max(column) for column in zip(*maximal, strict=True))
    if has_inhibitors:
        # Bounds of the net without inhibitor arcs may not be reached.
        reason = "inhibitor arcs: the exact bounds are not known"
        return Coverability(pumping is None, pumping=pumping, reason=reason)
    return Coverability(pumping is None, bounds, pumping, maximal)


class _Tree:
    """The tree, one row per node; a row's parent comes before it."""

    def __init__(self, net: CompiledNet, limit: int, budget: Budget, only_boundedness: bool) -> None:
        self.budget, self._only_boundedness = budget, only_boundedness
        self._needs = [net.pre.row(t) for t in range(len(net.transitions))]
        self._deltas = net.delta
        self._limit = limit
        self._markings = np.zeros((64, len(net.places)))
        self._is_active = np.zeros(64, dtype=np.bool_)
        self._parents: list[int] = []
        self._transitions: list[int] = []
        self._active: set[OmegaMarking] = set()
        self.pumping: Pumping | None = None
        self._add(tuple(float(n) for n in net.initial.tolist()), -1, -1)

    def build(self) -> bool:
        """Build the tree; False: the limit was exceeded, or the time is over."""
        waiting = deque([0])
        while waiting:
            if self.budget.is_over or (self._only_boundedness and self.pumping is not None):
                return False
            node = waiting.popleft()
            marking = self._marking(node)
            for t, needs in enumerate(self._needs):
                # A child may have made its parent redundant.
                if not self._is_active[node]:
                    break
                if any(marking[p] < weight for p, weight in needs):
                    continue
                child = self._accelerated(node, marking, t)
                if child in self._active or self._is_covered(child):
                    continue
                if len(self._parents) >= self._limit:
                    return False
                self._prune(child, node)
                waiting.append(self._add(child, node, t))
        return True

    @property
    def nodes(self) -> int:
        """Number of nodes so far."""
        return len(self._parents)

    def maximal(self) -> tuple[OmegaMarking, ...]:
        """Return the markings of the active nodes."""
        size = len(self._parents)
        return tuple(sorted(tuple(row) for row in self._markings[:size][self._is_active[:size]].tolist()))

    def _marking(self, node: int) -> OmegaMarking:
        return tuple(self._markings[node].tolist())

    def _add(self, marking: OmegaMarking, parent: int, transition: int) -> int:
        node = len(self._parents)
        if node == len(self._is_active):
            self._markings = np.concatenate([self._markings, np.zeros_like(self._markings)])
            self._is_active = np.concatenate([self._is_active, np.zeros_like(self._is_active)])
        self._markings[node] = marking
        self._is_active[node] = True
        self._parents.append(parent)
        self._transitions.append(transition)
        self._active.add(marking)
        return node

    def _branch(self, node: int) -> list[int]:
        """Return the nodes from the root to this one."""
        branch = []
        while node >= 0:
            branch.append(node)
            node = self._parents[node]
        return branch[::-1]

    def _accelerated(self, parent: int, marking: OmegaMarking, t: int) -> OmegaMarking:
        row = list(marking)
        for place, gain in self._deltas[t].items():
            row[place] += gain
        reached = np.array(row)
        branch = self._branch(parent)
        rows = self._markings[branch]
        smaller = np.flatnonzero((rows <= reached).all(axis=1) & (rows < reached).any(axis=1))
        if self.pumping is None and smaller.size:
            self.pumping = self._pumping(branch, int(smaller[-1]), t, reached)
        for position in smaller:
            for place in np.flatnonzero(rows[position] < reached).tolist():
                row[place] = inf
        return tuple(row)

    def _pumping(self, branch: list[int], position: int, t: int, reached: NDArray[np.float64]) -> Pumping:
        """Sequence of the first acceleration: no omega occurs above it, so it can be fired unchanged."""
        path = [*(self._transitions[node] for node in branch[1:]), t]
        gaining = np.flatnonzero(self._markings[branch[position]] < reached).tolist()
        return Pumping(tuple(path[:position]), tuple(path[position:]), tuple(gaining))

    def _is_covered(self, marking: OmegaMarking) -> bool:
        size = len(self._parents)
        support = [p for p, tokens in enumerate(marking) if tokens]
        covering = (self._markings[:size, support] >= np.array(marking)[support]).all(axis=1)
        return bool((covering & self._is_active[:size]).any())

    def _prune(self, marking: OmegaMarking, parent: int) -> None:
        """Deactivate the nodes that the new node makes redundant: each smaller node with its descendants.

        A smaller ancestor that was already inactive does not count: a node is not cut because of its own
        ancestor.
        """
        size = len(self._parents)
        smaller: NDArray[np.bool_] = np.all(self._markings[:size] <= np.array(marking), axis=1)
        if not smaller.any():
            return
        for node in self._branch(parent):
            smaller[node] &= self._is_active[node]
        for node in range(1, size):
            smaller[node] |= smaller[self._parents[node]]
        for node in np.flatnonzero(smaller & self._is_active[:size]).tolist():
            self._is_active[node] = False
            self._active.discard(self._marking(node))


def can_repeat(net: CompiledNet, pumping: Pumping) -> bool:
    """Return whether the net can fire prefix and suffix, and then the suffix forever, gaining tokens."""
    try:
        markings = replay(net, [*pumping.prefix, *pumping.suffix])
    except WitnessError:
        return False
    start, marking = markings[len(pumping.prefix)], markings[-1]
    gained = tuple(p for p, tokens in enumerate(marking) if tokens > start[p])
    inhibiting = {p for t in pumping.suffix for p, _ in net.inhibitor.row(t)}
    return (
        gained == pumping.places
        and bool(gained)
        and all(tokens >= before for tokens, before in zip(marking, start, strict=True))
        and inhibiting.isdisjoint(gained)
    )
