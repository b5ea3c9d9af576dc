"""Proofs by the tree of Karp and Miller: dead transitions, and unbounded places.

The tree does not support inhibitor arcs. Those at places with a proved bound become read arcs of complements,
which is exact. The others are removed, which allows more runs: dead transitions are still dead in the net,
but transitions that can fire may be dead in the net.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from dineros.analysis.answers.budget import Budget
from dineros.analysis.covering.growing import Limited, limited
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.compiled import ArcTable, CompiledNet
from dineros.analysis.nets.coverability import OmegaMarking, Pumping, coverability

MOST_NODES = 10_000
"""Maximum number of nodes of the tree."""

LARGEST_COMPLEMENT = 1_000
"""Largest bound of a place for which a complement is added."""


@dataclass(frozen=True)
class Tree:
    """The results of the tree for a net.

    Attributes
    ----------
    maximal : tuple of OmegaMarking or None
        The maximal markings, by place, with `inf` for no limit; None: the tree is too large.
    is_exact : bool
        Whether the maximal markings are exact; otherwise they are upper bounds.
    pumping : Pumping or None
        If places are unbounded: a proof that can be replayed in the net.
    covered : tuple of OmegaMarking
        If the tree is too large: the maximal markings of the part that was built.
    """

    maximal: tuple[OmegaMarking, ...] | None
    is_exact: bool
    dead: frozenset[int] = frozenset()
    pumping: Pumping | None = None
    covered: tuple[OmegaMarking, ...] = ()
    reason: str = ""


def tree_of(net: CompiledNet, budget: Budget) -> Tree:
    """Build the pruned tree of Karp and Miller."""
    budget = budget.begun()
    same = with_complements(net)
    plain = without_inhibitors(same.net)
    known = coverability(plain, MOST_NODES, budget)
    is_exact = plain is same.net
    pumping = None
    if known.pumping is not None and is_exact:
        places = tuple(p for p in range(len(net.places)) if same.place[p] in known.pumping.places)
        pumping = Pumping(same.back(known.pumping.prefix), same.back(known.pumping.suffix), places)
    if known.maximal is None:
        covered = _of_net(net, same, known.covered)
        return Tree(None, is_exact, pumping=pumping, covered=covered, reason=known.reason or "")
    images, maximal = same.images(), known.maximal
    dead = {
        t
        for t in range(len(net.transitions))
        if not any(
            all(marking[p] >= w for p, w in plain.pre.row(image))
            for image in images.get(t, ())
            for marking in maximal
        )
    }
    return Tree(_of_net(net, same, maximal), is_exact, frozenset(dead), pumping)


def _of_net(net: CompiledNet, same: Limited, markings: Iterable[OmegaMarking]) -> tuple[OmegaMarking, ...]:
    """Return markings without the complements."""
    return tuple(sorted({tuple(m[same.place[p]] for p in range(len(net.places))) for m in markings}))


def with_complements(net: CompiledNet) -> Limited:
    """Return the net without inhibitor arcs at bounded places, which are replaced by complements."""
    inhibiting = set(net.inhibitor.place.tolist())
    limits: dict[int, int] = {}
    if inhibiting:
        bounds = place_bounds(net)
        limits = {
            place: bound.value
            for place in sorted(inhibiting)
            if (bound := bounds[place]) is not None and 0 < bound.value <= LARGEST_COMPLEMENT
        }
    if not limits:
        return Limited.same(net)
    return limited(net, limits)


def without_inhibitors(net: CompiledNet) -> CompiledNet:
    """Return the net without its inhibitor arcs; the same object if it has none."""
    if not net.inhibitor.place.size:
        return net
    return replace(net, inhibitor=ArcTable.from_rows([{} for _ in net.transitions]))
