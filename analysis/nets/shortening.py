"""Shorter witnesses: firings that the goal does not need are removed, verified by a replay.

A trace translated from a reduced net, or found depth first, has many firings that are irrelevant for its
goal. After removing a part, and then all firings that are no longer enabled, the rest often still reaches the
goal. Parts are tried from halves down to single firings, as in delta debugging (Zeller and Hildebrandt, IEEE
TSE 28(2), 2002), so that no single firing of the result can be removed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import FiringRows, can_fire

Marking = list[int]
#: Maximum number of firings tried: about a second.
MOST_FIRINGS = 500_000


def shortened(
    net: CompiledNet, trace: Sequence[int], is_goal: Callable[[Marking], bool], most: int = MOST_FIRINGS
) -> tuple[int, ...]:
    """Return a firing sequence to a goal that is at most as long as the given one.

    Parameters
    ----------
    trace
        A firing sequence from the initial marking that leads to the goal.
    is_goal
        Returns whether a marking fulfils the goal.
    most
        Maximum number of firings tried; then the best sequence so far is returned.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 1}, [("turn", {"a": 1}, {"a": 1}), ("move", {"a": 1}, {})])
    >>> shortened(net, [0, 0, 1], lambda marking: marking[0] == 0)
    (1,)
    """
    work = _Shortening(net, is_goal, most)
    best = work.replay(net.initial.tolist(), trace)
    assert best is not None, "a trace that does not lead to its goal"
    size = max(1, len(best) // 2)
    while True:
        best = work.without_parts(_without_cycles(net, best), size)
        if size == 1 or work.left <= 0:
            return tuple(best)
        size //= 2


def way_before(net: CompiledNet, trace: Sequence[int], then: Sequence[int]) -> tuple[int, ...]:
    """Return a firing sequence after which other transitions can fire, at most as long as the given one."""
    most = MOST_FIRINGS // 5  # each marking is asked whether they can fire
    return shortened(net, trace, lambda marking: can_fire(net, then, marking), most)


class _Shortening:
    def __init__(self, net: CompiledNet, is_goal: Callable[[Marking], bool], most: int) -> None:
        self._rows = FiringRows(net)
        self._initial: Marking = net.initial.tolist()
        self._is_goal = is_goal
        self.left = most

    def replay(self, marking: Marking, trace: Sequence[int]) -> list[int] | None:
        """Fire the enabled transitions of a sequence, up to the goal; None: the goal is not reached."""
        fired: list[int] = []
        if self._is_goal(marking):
            return fired
        self.left -= len(trace)
        marking = list(marking)
        for t in trace:
            if self._rows.fire(t, marking):
                fired.append(t)
                if self._is_goal(marking):
                    return fired
        return None

    def without_parts(self, trace: list[int], size: int) -> list[int]:
        """Remove every part of a size that is not needed."""
        at = 0
        marking = list(self._initial)
        while at < len(trace) and self.left > 0:
            rest = self.replay(marking, trace[at + size :])
            if rest is not None and at + len(rest) < len(trace):
                trace = trace[:at] + rest
                continue
            for t in trace[at : at + size]:
                self._rows.fire(t, marking)
            at += size
        return trace


def _without_cycles(net: CompiledNet, trace: Sequence[int]) -> list[int]:
    """Remove firings that lead back to an earlier marking."""
    marking: Marking = net.initial.tolist()
    path = [tuple(marking)]
    depth = {path[0]: 0}
    kept: list[int] = []
    for t in trace:
        marking = net.fire(t, marking)
        known = depth.get(tuple(marking))
        if known is None:
            kept.append(t)
            path.append(tuple(marking))
            depth[path[-1]] = len(kept)
        else:
            for gone in path[known + 1 :]:
                del depth[gone]
            del path[known + 1 :], kept[known:]
    return kept
