"""How far places are from the initial marking: weights that grow with the firings of some transitions."""

from __future__ import annotations

from heapq import heapify, heappop, heappush

from dineros.analysis.nets.compiled import CompiledNet


def firing_distances(net: CompiledNet) -> list[int]:
    """Return for each place how many firings a token in it takes, as if no two firings shared a token.

    It is 0 for marked places, and for places that no firings mark. Inhibitor arcs are ignored.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 2, "b": 0, "c": 0},
    ...     [("t", {"a": 1}, {"b": 1}), ("u", {"b": 2}, {"c": 1})])
    >>> firing_distances(net)
    [0, 1, 3]
    """
    distance: list[int | None] = [0 if tokens else None for tokens in net.initial.tolist()]
    cost = [1] * len(net.transitions)
    missing = [len(net.pre.row(transition)) for transition in range(len(net.transitions))]
    heap = [(0, place) for place, far in enumerate(distance) if far is not None]
    heapify(heap)

    def fire(transition: int) -> None:
        for place, _ in net.post.row(transition):
            known = distance[place]
            if known is None or cost[transition] < known:
                distance[place] = cost[transition]
                heappush(heap, (cost[transition], place))

    for transition, places in enumerate(missing):
        if not places:
            fire(transition)
    settled: set[int] = set()
    while heap:
        far, place = heappop(heap)
        if place in settled:
            continue
        settled.add(place)
        for transition in net.consumers[place]:
            weight = next(tokens for p, tokens in net.pre.row(transition) if p == place)
            cost[transition] += weight * far
            missing[transition] -= 1
            if not missing[transition]:
                fire(transition)
    return [far or 0 for far in distance]


def rising(net: CompiledNet, weights: list[int]) -> list[int]:
    """Return the transitions that increase the weighted sum of tokens."""
    return [
        transition
        for transition, change in enumerate(net.delta)
        if sum(weights[place] * tokens for place, tokens in change.items()) > 0
    ]
