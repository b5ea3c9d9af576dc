"""Callbacks that can wait forever, found on the way, where not all markings can be seen.

A circle that has closed stays closed, so that a run which goes anywhere long enough ends in one. A proof
that a callback never ends from a marking uses an upper bound of the transitions that can still fire: a
transition can fire again only if each of its places holds enough, or something that can fire puts tokens
there. Nothing is taken away in that, so that what is out of reach then is out of reach in the net (the
relaxed reachability of J. Hoffmann, B. Nebel, *The FF planning system*, JAIR 14, 2001). Circles that are not
found may exist.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from random import Random
from typing import TypeAlias

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks.blocking import Blocked
from dineros.analysis.callbacks.circles import Circle, Waiter
from dineros.analysis.callbacks.waiting import Callback, Waiting
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.shortening import shortened
from dineros.analysis.nets.witness import last_marking, replay

WALKS = 24
"""Runs that are tried."""

STEPS = 1_500
"""Firings of each."""

CLOSING = 600
"""Firings from where a callback never ends to where its circle is looked for at last."""

LOOKS = 50
"""Firings between two looks at what waits."""

LOOKS_CLOSELY = 5
"""The same for a run that only continues what a callback has begun."""

NEWEST = 20
"""Firings at the end of a run whose tokens are followed."""

SHORTENING = 50_000
"""Firings that may be tried to shorten a run."""


Choice: TypeAlias = Callable[[Sequence[int], Sequence[int]], int | None]
"""Chooses an enabled transition for a marking and the run that led to it; None: no further one."""


class Walks:
    """Runs of a net in which callbacks come to wait forever."""

    def __init__(self, net: CompiledNet, waiting: Waiting) -> None:
        self._net = net
        self._waiting = waiting
        count = range(len(net.transitions))
        self._raises = [[p for p, tokens in net.delta[t].items() if tokens > 0] for t in count]
        self._ends = {
            id(callback): [
                t
                for t in sorted({t for place in callback.places for t in net.changing[place]})
                if sum(net.delta[t].get(p, 0) for p in callback.places) < 0
            ]
            for callback in waiting.callbacks.values()
        }

    def found(self, budget: Budget) -> Iterator[Blocked]:
        """Yield callbacks that never end after some run."""
        for seed in range(WALKS):
            if budget.is_over:
                return
            yield from self.after((), Random(seed), budget)

    def after(
        self, begun: Sequence[int], draw: Random, budget: Budget, known: Callback | None = None
    ) -> Iterator[Blocked]:
        """Yield callbacks that never end after a run, which continues until their circle is closed.

        Parameters
        ----------
        begun : sequence of int
            How the run begins.
        draw : Random
            Draws how it continues.
        budget : Budget
            Its time.
        known : Callback, optional
            One that is known never to end after that: only circles are of interest that it waits for.
        """
        order = list(range(len(self._net.transitions)))

        def drawn(marking: Sequence[int], _: Sequence[int]) -> int | None:
            draw.shuffle(order)
            return next((t for t in order if self._net.is_enabled(t, marking)), None)

        trace, doomed = self._walk(list(begun), drawn, budget, known)
        for callback, circle in doomed:
            yield Blocked(callback.waiter, circle, tuple(trace))

    def closed_after(self, begun: Sequence[int], budget: Budget, known: Callback) -> Blocked | None:
        """Return the circle that a callback waits for after a run, which continues with what it has begun.

        The run follows its newest tokens, so that what it asked for is answered, and nothing else happens.
        In large nets, a run that is drawn does not come that far.
        """
        net, last = self._net, len(begun)

        def newest(marking: Sequence[int], trace: Sequence[int]) -> int | None:
            for fired in reversed(trace[max(0, last - NEWEST) :]):
                for place in self._raises[fired]:
                    for t in net.consumers[place]:
                        if net.is_enabled(t, marking) and t not in trace[last:]:
                            return t
            return None

        trace, doomed = self._walk(list(begun), newest, budget, known, LOOKS_CLOSELY)
        callback, circle = next(iter(doomed), (known, None))
        return None if circle is None else Blocked(callback.waiter, circle, tuple(trace))

    def _walk(
        self, trace: list[int], choose: Choice, budget: Budget, known: Callback | None, looks: int = LOOKS
    ) -> tuple[list[int], list[tuple[Callback, Circle | None]]]:
        """Fire what is chosen until callbacks never end, in a circle if there is one."""
        net = self._net
        marking = last_marking(net, trace)
        most = len(trace) + (STEPS if known is None else CLOSING)
        is_first = True
        while True:
            chosen = choose(marking, trace)
            ends = chosen is None or len(trace) >= most or budget.is_over
            if ends or len(trace) % looks == 0:
                doomed = self._doomed(marking, known)
                if ends or any(circle is not None for _, circle in doomed):
                    return trace, doomed
                if doomed and is_first:
                    is_first, most = False, min(most, len(trace) + CLOSING)
            assert chosen is not None
            marking = net.fire(chosen, marking)
            trace.append(chosen)

    def _doomed(self, marking: list[int], known: Callback | None) -> list[tuple[Callback, Circle | None]]:
        """Return the callbacks that have begun and can never end, with the circle that is closed."""
        begun = [each for each in self._waiting.callbacks.values() if each.has_begun(marking)]
        possible = self._possible(marking) if begun else set()
        endless = [each for each in begun if each is known or possible.isdisjoint(self._ends[id(each)])]
        if not endless:
            return []
        circle = self._waiting.circle(marking, None if known is None else known.waiter)
        of = {each.waiter: each for each in begun}
        inside = [of[waiter] for waiter in (circle.waiters if circle is not None else ()) if waiter in of]
        if inside and all(each in endless for each in inside):  # else it may open again
            return [(inside[0], circle)]
        return [(each, None) for each in endless]

    def endless_after(self, traces: Iterable[Sequence[int]]) -> dict[Waiter, tuple[int, ...]]:
        """Return the callbacks that never end after one of some runs, each with the run up to there."""
        found: dict[Waiter, tuple[int, ...]] = {}
        for trace in traces:
            markings = replay(self._net, trace)
            for callback, _ in self._doomed(markings[-1], None):
                if callback.waiter not in found:
                    end = self._first(markings, partial(self._waits_so, callback, None))
                    found[callback.waiter] = tuple(trace[:end])
        return found

    @staticmethod
    def _first(markings: Sequence[list[int]], is_so: Callable[[list[int]], bool]) -> int:
        """Return the number of the first marking of a run of which something is true; what is so stays so."""
        return bisect_left(range(len(markings) - 1), True, key=lambda number: is_so(markings[number]))

    def never_ends_at_best(self, callback: Callback, marking: Sequence[int]) -> bool:
        """Return whether a callback never ends from a marking on, even if no thread or group were missing."""
        free = list(marking)
        for resource in self._waiting.resources:
            free[resource] = max(free[resource], int(self._net.pre.weight.max(initial=1)))
        return self._possible(free).isdisjoint(self._ends[id(callback)])

    def blocked_after(self, trace: tuple[int, ...]) -> Iterator[Blocked]:
        """Yield callbacks that never end after a run, each with the beginning of the run that is enough."""
        markings = replay(self._net, trace)
        for callback, circle in self._doomed(markings[-1], None):
            end = self._first(markings, partial(self._waits_so, callback, circle))
            yield Blocked(callback.waiter, circle, trace[:end])

    def _waits_so(self, callback: Callback, circle: Circle | None, marking: list[int]) -> bool:
        """Whether a callback has begun and never ends from a marking on, in a circle if there is one."""
        if not callback.has_begun(marking):
            return False
        if not self._possible(marking).isdisjoint(self._ends[id(callback)]):
            return False
        return circle is None or self._waiting.circle(marking, callback.waiter) == circle

    def shortest(self, blocked: Blocked) -> Blocked:
        """Return the same with a run that goes no further, without what it does not need.

        A callback that never ends may be certain to wait forever before it begins to wait; the run is
        extended until it waits.
        """
        circle = blocked.circle
        callback = next(c for c in self._waiting.callbacks.values() if c.waiter == blocked.callback)
        end, page = last_marking(self._net, blocked.trace), callback.waiter.element
        waits = circle is None and bool(self._waiting.lacking(page, end))

        def is_there(marking: list[int]) -> bool:
            if waits and not self._waiting.lacking(page, marking):
                return False
            return self._waits_so(callback, circle, marking)

        if not is_there(end):
            return blocked  # that it never ends is proved for this run only
        found = shortened(self._net, blocked.trace, is_there, SHORTENING)
        replay(self._net, found)
        return replace(blocked, trace=found)

    def _possible(self, marking: list[int]) -> set[int]:
        """Return the transitions that may still fire, if nothing were ever taken away."""
        raised: set[int] = set()
        possible: set[int] = set()

        def may_fire(transition: int) -> bool:
            needs = self._net.pre.row(transition)
            return all(place in raised or marking[place] >= weight for place, weight in needs)

        waiting = list(range(len(self._net.transitions)))
        while waiting:
            transition = waiting.pop()
            if transition in possible or not may_fire(transition):
                continue
            possible.add(transition)
            for place in self._raises[transition]:
                if place not in raised:
                    raised.add(place)
                    waiting.extend(self._net.consumers[place])
        return possible
