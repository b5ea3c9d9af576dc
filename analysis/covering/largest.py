"""The greatest number of tokens of a place while another place is marked, or a run by which it grows."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf

from dineros.analysis.answers.budget import Budget
from dineros.analysis.covering.growing import growing_places, without_growth
from dineros.analysis.covering.tree import tree_of
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.coverability import Pumping
from dineros.analysis.nets.witness import way_to

MOST_MARKINGS = 5_000
"""Markings of the search for a loop."""


def largest_beside(net: CompiledNet, place: int, others: Iterable[int], budget: Budget) -> float | None:
    """Return the most tokens of a place in a reachable marking that also marks one of some other places.

    Parameters
    ----------
    net : CompiledNet
        The net; its state space may be infinite.

    Returns
    -------
    float or None
        The number; `inf` if it is unbounded, and -1 if no reachable marking marks one of the other places.
        None if that is not decided: the coverability tree is too large, or inhibitor arcs make it inexact.
    """
    others = list(others)
    small = None if {place, *others}.intersection(growing_places(net)) else without_growth(net)
    if small is not None:
        net, place, others = small.net, small.place[place], [small.place[other] for other in others]
    tree = tree_of(net, budget)
    if not tree.is_exact:
        return None
    known = tree.covered if tree.maximal is None else tree.maximal
    largest = max((m[place] for m in known if any(m[other] >= 1 for other in others)), default=-1)
    # A larger part of the tree could show more tokens, but infinity is final.
    return largest if tree.maximal is not None or largest == inf else None


def loop_raising(net: CompiledNet, place: int, budget: Budget) -> Pumping | None:
    """Search breadth first for a loop that can be repeated forever and adds tokens to a place.

    Returns
    -------
    Pumping or None
        In the loop, no place loses tokens, and none that gains tokens inhibits it; None: none is near.
    """
    budget = budget.begun()
    count = range(len(net.transitions))
    inhibitors = [{p for p, _ in net.inhibitor.row(t)} for t in count]
    start = tuple(net.initial.tolist())
    markings, came, seen = [start], [(-1, -1)], {start}
    for number, marking in enumerate(markings):
        if budget.is_over or len(markings) > MOST_MARKINGS:
            return None
        for t in count:
            if not net.is_enabled(t, marking):
                continue
            after = tuple(net.fire(t, marking))
            if after in seen:
                continue
            seen.add(after)
            markings.append(after)
            came.append((number, t))
            loop: list[int] = []
            back = len(markings) - 1
            while back:
                back, fired = came[back]
                loop.append(fired)
                before = markings[back]
                if after[place] > before[place] and all(a >= b for a, b in zip(after, before, strict=True)):
                    grown = tuple(p for p, (a, b) in enumerate(zip(after, before, strict=True)) if a > b)
                    if all(inhibitors[fired].isdisjoint(grown) for fired in loop):
                        return Pumping(way_to(came, back), tuple(reversed(loop)), grown)
    return None
