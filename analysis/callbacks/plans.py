"""Short runs that fire a transition, planned without search.

In the *relaxed* net, firings take no tokens away, so that all that can ever be marked is found in one pass.
The first transition that marks a place there is planned for it, and what that one needs before it. The plan
is then tried in the net. It fails where tokens are needed more than once. It is found in milliseconds where a
request leads to a callback, which is what large models of programs mostly consist of (the relaxed plans of
J. Hoffmann, B. Nebel, *The FF planning system*, JAIR 14, 2001).
"""

from __future__ import annotations

from collections import deque

from dineros.analysis.nets.compiled import CompiledNet


class Plans:
    """Plans for the transitions of a net.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 1, "b": 0, "c": 0},
    ...     [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"c": 1}), ("v", {"a": 1, "c": 1}, {})])
    >>> Plans(net).way_to(1), Plans(net).way_to(2)
    ((0, 1), None)
    """

    def __init__(self, net: CompiledNet) -> None:
        self._net = net
        self._rank: dict[int, int] = {}  #: by transition, how many can fire before it in the relaxed net
        self._maker: dict[int, int] = {}  #: by place, the first transition that marks it there
        missing = [
            sum(not net.initial[place] for place, _ in net.pre.row(t)) for t in range(len(net.transitions))
        ]
        ready = deque(t for t, places in enumerate(missing) if not places)
        while ready:
            transition = ready.popleft()
            self._rank[transition] = len(self._rank)
            for place, _ in net.post.row(transition):
                if net.initial[place] or place in self._maker:
                    continue
                self._maker[place] = transition
                for consumer in net.consumers[place]:
                    missing[consumer] -= 1
                    if not missing[consumer]:
                        ready.append(consumer)

    def way_to(self, transition: int) -> tuple[int, ...] | None:
        """Return a firing sequence that ends with a transition; None: the plan fails."""
        if transition not in self._rank:
            return None
        plan = {transition}
        open_places = [place for place, _ in self._net.pre.row(transition)]
        while open_places:
            maker = self._maker.get(open_places.pop())
            if maker is not None and maker not in plan:
                plan.add(maker)
                open_places += [place for place, _ in self._net.pre.row(maker)]
        left, way = sorted(plan, key=self._rank.__getitem__), list[int]()
        marking = self._net.initial.tolist()
        while transition in left:
            chosen = next((each for each in left if self._net.is_enabled(each, marking)), None)
            if chosen is None:
                return None
            left.remove(chosen)
            marking = self._net.fire(chosen, marking)
            way.append(chosen)
        return tuple(way)
