"""Groups of places that share a level, since at most one of them is marked, with one token.

Semiflows give groups whose tokens never get lost: state machines. Other groups lose their token at times: the
values that a program may read next, until it has read one. Their weightings bound places, but are not
semiflows.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence, Set
from heapq import heapify, heappop, heappush

from dineros.analysis.nets.bounds import Bound, grown, producers_of, weighted_sum
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.structure import PlaceInvariant

#: Places of a group by bounds: more get several levels, as the tables of a level grow with its square.
MOST_TOGETHER = 64
#: Groups by bounds serve if they leave at most this part of the levels. Which groups there are depends on the
#: marking, and orders are used again for the same net with more tokens.
WORTH_GROUPING = 0.5
#: Groups of more places go last. The tables of a level have an entry for each of its places and each
#: transition that touches one of them: a bus that each of 50 processors takes for each of 50 memories is one
#: group of 2 451 places, with 12 million entries; groups of 52 places, one for each processor, have 300 000.
WIDE = 512


def groups_of_flows(kept: Iterable[int], flows: Sequence[PlaceInvariant]) -> list[tuple[int, ...]]:
    """Return disjoint groups of kept places with at most one token together, largest first.

    Groups of more than `WIDE` places go last.
    """
    free = set(kept)
    groups: list[tuple[int, ...]] = []
    # The free part of a flow only shrinks: a size that is still correct when it is reached is the largest.
    sizes = [(len(flow.weights) > WIDE, -len(flow.weights), number) for number, flow in enumerate(flows)]
    heapify(sizes)
    while sizes:
        _, size, number = heappop(sizes)
        group = tuple(sorted(free & flows[number].weights.keys()))
        if len(group) < 2:
            continue
        if -len(group) != size:
            heappush(sizes, (len(group) > WIDE, -len(group), number))
            continue
        groups.append(group)
        free.difference_update(group)
    return groups


def groups_of_wide_net(
    net: CompiledNet, places: Iterable[int], bounds: Iterable[Bound | None]
) -> list[tuple[int, ...]]:
    """Return groups of places from the weightings that bound them, if one of these has very many places.

    There, linear programs would propose the widest groups first, and take long.
    """
    weightings = {id(bound.weights): bound for bound in bounds if bound is not None}.values()
    if all(len(bound.weights) <= WIDE for bound in weightings):
        return []
    flows = [
        PlaceInvariant(bound.weights, 1)
        for bound in weightings
        if set(bound.weights.values()) == {1} and weighted_sum(net, bound.weights) == 1
    ]
    return groups_of_flows(places, flows)


def groups_of_bounds(
    net: CompiledNet, places: Iterable[int], bounds: Sequence[Bound | None], others: int = 0
) -> list[tuple[int, ...]]:
    """Return disjoint groups of some places that lose their token, if they make far fewer levels.

    They are found by the weightings that bound places.

    Parameters
    ----------
    bounds
        By place: its bound.
    others
        Number of levels of other places.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 1, "b": 0, "c": 0},
    ...     [("t", {"a": 1}, {"b": 1}), ("u", {"a": 1}, {"c": 1}), ("v", {"b": 1}, {})])
    >>> groups_of_bounds(net, range(3), [Bound(1, {0: 1, 1: 1})] * 3)
    [(0, 1, 2)]
    """
    free = set(places)
    most = (len(free) + others) * WORTH_GROUPING
    groups: list[tuple[int, ...]] = []
    producers = producers_of(net)
    for place in sorted(free):
        bound = bounds[place]
        if place not in free or bound is None or set(bound.weights.values()) != {1}:
            continue
        if sum(int(net.initial[p]) for p in bound.weights) > 1:
            continue
        whole = grown(net, bound.weights, producers)
        if not _loses(net, whole):
            continue
        group = tuple(sorted(whole & free))
        if len(group) > 1:
            groups += (group[at : at + MOST_TOGETHER] for at in range(0, len(group), MOST_TOGETHER))
            free.difference_update(group)
    return groups if len(groups) + len(free) + others <= most else []


def _loses(net: CompiledNet, places: Set[int]) -> bool:
    """Return whether some transition takes more tokens from a set of places than it puts there."""
    changing = {transition for place in places for transition in net.changing[place]}
    return any(
        sum(tokens for place, tokens in net.delta[transition].items() if place in places) < 0
        for transition in changing
    )
