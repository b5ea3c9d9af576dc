"""Callbacks that can wait for ever, found on the way, where not all markings can be seen.

A circle that has closed stays closed, so that a run which goes anywhere long enough ends in one. That a
callback never ends from a marking on is proved there by what the net can still do at most: a transition can
fire again only if each of its places holds enough, or something that can fire puts tokens there. Nothing is
taken away in that, so that what is out of reach then is out of reach in the net (the relaxed reachability of
J. Hoffmann, B. Nebel, *The FF planning system*, JAIR 14, 2001). What is not found may be there all the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks.blocking import Blocked
from dineros.analysis.callbacks.waiting import Callback, Circle, Waiting
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.shortening import shortened
from dineros.analysis.nets.witness import replay

WALKS = 24
"""Runs that are tried."""

STEPS = 1_500
"""Firings of each."""

LOOKS = 50
"""Firings between two looks at what waits."""

SHORTENING = 50_000
"""Firings that may be tried to shorten a run."""


def blocked_on_the_way(net: CompiledNet, waiting: Waiting, budget: Budget) -> Iterator[Blocked]:
    """Yield callbacks that can wait for ever: each circle once, and each other callback once.

    Parameters
    ----------
    net : CompiledNet
        The net.
    waiting : Waiting
        What waits for what in it.
    budget : Budget
        Its time.
    """
    search = _Search(net, waiting)
    known: set[tuple[object, Circle | None]] = set()
    for seed in range(WALKS):
        if budget.is_over:
            return
        trace, doomed = search.walk(Random(seed), budget)
        for callback, circle in doomed:
            key = (callback.waiter if circle is None else None, circle)
            if key not in known:
                known.add(key)
                yield Blocked(callback.waiter, circle, search.shortest(trace, callback, circle))


class _Search:
    def __init__(self, net: CompiledNet, waiting: Waiting) -> None:
        self._net = net
        self._waiting = waiting
        count = range(len(net.transitions))
        self._pre = [net.pre.row(t) for t in count]
        self._raises = [[p for p, tokens in net.delta[t].items() if tokens > 0] for t in count]
        self._takers: list[list[int]] = [[] for _ in net.places]
        for t in count:
            for place, _ in self._pre[t]:
                self._takers[place].append(t)
        self._ends = {
            id(callback): [t for t in count if sum(net.delta[t].get(p, 0) for p in callback.places) < 0]
            for callback in waiting.callbacks.values()
        }

    def walk(self, draw: Random, budget: Budget) -> tuple[list[int], list[tuple[Callback, Circle | None]]]:
        """Fire what is enabled, as it is drawn, until callbacks never end; return the run and those."""
        net = self._net
        marking = [int(tokens) for tokens in net.initial]
        trace: list[int] = []
        order = list(range(len(net.transitions)))
        while len(trace) < STEPS and not budget.is_over:
            draw.shuffle(order)
            chosen = next((t for t in order if net.is_enabled(t, marking)), None)
            if chosen is not None:
                marking = net.fire(chosen, marking)
                trace.append(chosen)
            if (chosen is None or len(trace) % LOOKS == 0) and (doomed := self.doomed(marking)):
                return trace, doomed
            if chosen is None:
                break
        return trace, []

    def doomed(self, marking: list[int]) -> list[tuple[Callback, Circle | None]]:
        """Return the callbacks that have begun and can never end, with the circle that is closed."""
        begun = [each for each in self._waiting.callbacks.values() if each.has_begun(marking)]
        possible = self._possible(marking) if begun else set()
        endless = [each for each in begun if possible.isdisjoint(self._ends[id(each)])]
        if not endless:
            return []
        circle = self._waiting.circle(marking)
        of = {each.waiter: each for each in begun}
        inside = [of[waiter] for waiter in (circle.waiters if circle is not None else ()) if waiter in of]
        if inside and all(each in endless for each in inside):  # else it may open again
            return [(inside[0], circle)]
        return [(each, None) for each in endless]

    def shortest(self, trace: list[int], callback: Callback, circle: Circle | None) -> tuple[int, ...]:
        """Return a run to where the callback never ends, without what that does not need."""

        def is_there(marking: list[int]) -> bool:
            if not callback.has_begun(marking):
                return False
            if not self._possible(marking).isdisjoint(self._ends[id(callback)]):
                return False
            return circle is None or self._waiting.circle(marking) == circle

        found = shortened(self._net, trace, is_there, SHORTENING)
        replay(self._net, found)
        return found

    def _possible(self, marking: list[int]) -> set[int]:
        """Return the transitions that may still fire, if nothing were ever taken away."""
        raised: set[int] = set()
        possible: set[int] = set()

        def may_fire(transition: int) -> bool:
            return all(place in raised or marking[place] >= weight for place, weight in self._pre[transition])

        waiting = list(range(len(self._pre)))
        while waiting:
            transition = waiting.pop()
            if transition in possible or not may_fire(transition):
                continue
            possible.add(transition)
            for place in self._raises[transition]:
                if place not in raised:
                    raised.add(place)
                    waiting.extend(self._takers[place])
        return possible
