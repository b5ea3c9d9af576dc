"""What Karp and Miller's tree proves: transitions that can never fire, and places without a bound.

Inhibitor arcs do not go with it. Those at places with a proved bound become read arcs of complements, which
changes nothing; the others are left out, which lets more happen: then what can never fire still never can,
and what can may not.
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
"""Nodes of the tree."""

LARGEST_COMPLEMENT = 1_000
"""Bound up to which a place gets a complement."""


@dataclass(frozen=True)
class Tree:
    """What is known of a net.

    Attributes
    ----------
    maximal : tuple of OmegaMarking or None
        The largest markings, by place, with `inf` where there is no limit; None where the tree is too large.
    is_exact : bool
        Whether the largest markings are those of the net; otherwise it has smaller ones only.
    dead : frozenset of int
        Transitions that can never fire, as far as the tree proves it.
    pumping : Pumping or None
        Where places are unbounded: the proof, which the net can repeat.
    covered : tuple of OmegaMarking
        Where it is too large: the largest markings of what was made of it.
    reason : str
        Why something is not known.
    """

    maximal: tuple[OmegaMarking, ...] | None
    is_exact: bool
    dead: frozenset[int] = frozenset()
    pumping: Pumping | None = None
    covered: tuple[OmegaMarking, ...] = ()
    reason: str = ""


def tree_of(net: CompiledNet, budget: Budget) -> Tree:
    """Make the tree of Karp and Miller, pruned.

    Parameters
    ----------
    net : CompiledNet
        The net.
    budget : Budget
        Of its time.
    """
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
    """Return the net in which places with a bound are no longer looked at by inhibitor arcs."""
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
    """Return the net without its inhibitor arcs; the same one where it has none."""
    if not net.inhibitor.place.size:
        return net
    return replace(net, inhibitor=ArcTable.from_rows([{} for _ in net.transitions]))
