"""A shorter way to where firings can be repeated: what the way does not need is left out."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.nets.compiled import CompiledNet

MOST_FIRINGS = 300_000
"""Firings that are tried in all, about half a second: what was found until then counts."""


def shortened(net: CompiledNet, way: Sequence[int], then: Sequence[int]) -> tuple[int, ...]:
    """Return a part of a firing sequence after which other firings are still possible, in their order.

    A stretch is left out, and with it every later firing that is no longer enabled without it, if the other
    firings are possible then. Long stretches are tried first, then shorter ones, down to single firings.

    Parameters
    ----------
    net : CompiledNet
        The net.
    way : sequence of int
        Transitions from the initial marking.
    then : sequence of int
        Transitions that can fire after it.
    """
    return _Shortening(net, way, then).shortest()


class _Shortening:
    def __init__(self, net: CompiledNet, way: Sequence[int], then: Sequence[int]) -> None:
        self._initial = net.initial.tolist()
        self._way = list(way)
        self._then = list(then)
        self._rules = {
            t: (net.pre.row(t), net.inhibitor.row(t), list(net.delta[t].items())) for t in {*way, *then}
        }
        self._fired = 0

    def shortest(self) -> tuple[int, ...]:
        size = max(1, len(self._way) // 2)
        while self._fired < MOST_FIRINGS:
            before = len(self._way)
            self._leave_out(size)
            if size == 1 and len(self._way) == before:
                break
            size = max(1, size // 2)
        return tuple(self._way)

    def _leave_out(self, size: int) -> None:
        """Leave out stretches of a size, the earliest first."""
        start, marking = 0, list(self._initial)
        while start < len(self._way) and self._fired < MOST_FIRINGS:
            rest = self._rest(self._way[start + size :], list(marking))
            if rest is not None and len(rest) < len(self._way) - start:
                self._way[start:] = rest
            else:
                for t in self._way[start : start + size]:
                    self._fire(t, marking)
                start += size

    def _rest(self, firings: Sequence[int], marking: list[int]) -> list[int] | None:
        """Return which of some firings are possible in turn; None if what must follow is not."""
        fired = [t for t in firings if self._fire(t, marking)]
        return fired if all(self._fire(t, marking) for t in self._then) else None

    def _fire(self, t: int, marking: list[int]) -> bool:
        """Fire a transition if it is enabled."""
        inputs, inhibitors, change = self._rules[t]
        self._fired += 1
        for place, weight in inputs:
            if marking[place] < weight:
                return False
        for place, weight in inhibitors:
            if marking[place] >= weight:
                return False
        for place, tokens in change:
            marking[place] += tokens
        return True
