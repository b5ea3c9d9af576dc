"""Another run to the same fault, in which a few firings repeat: it is shorter to read.

A queue of ten messages is full after many firings, and the ways that engines find fill it differently each
time. Here a part of such a run is repeated as often as it can be, and firings around it are removed if the
run still leads to the fault. Each run is fired step by step, so that none is claimed that the net does
not have.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.shortening import shortened
from dineros.analysis.nets.witness import FiringRows, can_fire
from dineros.analysis.walks.used_part import UsedPart
from dineros.analysis.witnesses.folding import in_rounds, lines_of

LEAST_LINES = 30
"""Lines that a run takes at least, for another one to be looked for."""

LONGEST_ROUND = 24
"""Firings of a round, at most."""

MOST_CHANGED = 6
"""Places that a round changes, at most: those of queues that it fills."""

MOST_TIMES = 100
"""How often a round is repeated, at most."""

MOST_TRIED = 600_000
"""Firings tried, at most: about half a second."""

MOST_SHORTENED = 20_000
"""Firings around the rounds that are tried, at most."""

BEST = 4
"""Runs whose firings around the rounds are removed."""

Marking = list[int]


def repeating_way(
    net: CompiledNet, trace: Sequence[int], then: Sequence[int], most_tried: int | None = None
) -> tuple[int, ...]:
    """Return a firing sequence after which other transitions can fire, the shortest to read that is found.

    Parameters
    ----------
    trace
        A firing sequence from the initial marking after which they can fire.
    then
        The transitions that can fire after it, in order.
    most_tried
        Firings that are tried, at most; by default `MOST_TRIED`.
    """
    twins = [each for t in then for each in _twins(net, t)]
    part = UsedPart(net, [*trace, *twins])
    most = MOST_TRIED if most_tried is None else most_tried
    return tuple(part.outside(_repeating_way(part.net, part.inside(trace), part.inside(then), most)))


def _repeating_way(
    net: CompiledNet, trace: Sequence[int], then: Sequence[int], most_tried: int
) -> tuple[int, ...]:
    ordered = in_rounds(net, trace)
    if lines_of(ordered) < LEAST_LINES:
        return ordered
    search = _Rounds(net, then, most_tried)
    found = [ordered, *search.repeated(tuple(trace))]
    if ordered != tuple(trace):
        found += search.repeated(ordered)
    best = min(found, key=lambda way: (lines_of(way), len(way)))
    return best if can_fire(net, (*best, *then), net.initial.tolist()) else ordered


def _twins(net: CompiledNet, transition: int) -> tuple[int, ...]:
    """Return a transition and those that take and make what it does, and change other places as well.

    So a history that is not full takes a message where a full one loses one.
    """
    change = net.delta[transition]
    taken = {place for place, tokens in change.items() if tokens < 0}
    if not taken:
        return (transition,)
    near = sorted({t for place in taken for t in net.changing[place]})
    alike = [t for t in near if t != transition and all(net.delta[t].get(p) == n for p, n in change.items())]
    return (transition, *alike)


@dataclass(frozen=True)
class _Repeated:
    """Firings before a round, the round, and what is tried after it."""

    before: tuple[int, ...]
    round: tuple[tuple[int, ...], ...]
    after: tuple[int, ...]


class _Rounds:
    """Looks for runs with a round after which some transitions can fire."""

    def __init__(self, net: CompiledNet, then: Sequence[int], most_tried: int) -> None:
        self._net = net
        self._then = tuple(then)
        self._rows = FiringRows(net)
        self._left = most_tried
        self._repetitions = 0

    def repeated(self, trace: tuple[int, ...]) -> list[tuple[int, ...]]:
        """Return runs that repeat a part of a run, or what repeats afterwards."""
        found: list[tuple[int, int, _Repeated, tuple[int, ...]]] = []
        least = self._left // 2
        for round, end in self._rounds(trace):
            if self._left <= least:
                break
            tried = _Repeated(trace[:end], tuple((t,) for t in round), trace[end:])
            way = self._way(tried)
            if way is not None:
                # Other repetitions are not searched for, as that takes too long.
                found.append((len(way) - self._repetitions * len(round), len(found), tried, way))
        best = sorted(found)[:BEST]
        ways = [way for _, _, _, way in best]
        tried_shorter = [tried for _, _, tried, _ in best]
        if len(self._then) > 1:
            tried_shorter.insert(0, _Repeated(trace, tuple(_twins(self._net, t) for t in self._then), ()))
        for tried in tried_shorter:
            if self._left <= 0:
                break
            shorter = self._shorter(tried)
            if shorter is not None:
                ways.append(shorter)
        return ways

    def _rounds(self, trace: tuple[int, ...]) -> list[tuple[tuple[int, ...], int]]:
        """Return firings that can repeat, and where: a part of a run without what cannot fire again.

        Those come first that put most tokens for each firing where the transitions need more than there are
        at the beginning, and then those that change few other places.
        """
        markings: list[Marking] = [self._net.initial.tolist()]
        for t in trace:
            markings.append(self._net.fire(t, markings[-1]))
        needed = {p for t in self._then for p, weight in self._rows.needs[t] if markings[0][p] < weight}
        found: dict[tuple[int, ...], tuple[tuple[float, int, int], int]] = {}
        work = len(trace) * LONGEST_ROUND**2 // 2  # at most a quarter of what may be tried
        for start in range(0, len(trace), 1 + 4 * work // max(self._left, 1)):
            for end in range(start + 2, min(len(trace), start + LONGEST_ROUND) + 1):
                marking = list(markings[end])
                round = tuple(t for t in trace[start:end] if self._fires(t, marking))
                if not round or round in found:
                    continue
                changed = {
                    p: marking[p] - tokens for p, tokens in enumerate(markings[end]) if marking[p] != tokens
                }
                gained = sum(max(0, tokens) for p, tokens in changed.items() if p in needed)
                if changed and len(changed) <= MOST_CHANGED:
                    found[round] = (-gained / len(round), len(changed), end), end
        return [(round, end) for round, (_, end) in sorted(found.items(), key=lambda item: item[1])]

    def _way(self, tried: _Repeated) -> tuple[int, ...] | None:
        """Return the run with the round repeated until the transitions can fire, or None."""
        marking: Marking = self._net.initial.tolist()
        for t in tried.before:
            if not self._fires(t, marking):
                return None
        rest = self._from(marking, tried)
        return None if rest is None else (*tried.before, *rest)

    def _from(self, marking: Sequence[int], tried: _Repeated) -> tuple[int, ...] | None:
        """Repeat the round from a marking; return the firings until the transitions can fire, or None."""
        marking = list(marking)
        fired: list[int] = []
        for self._repetitions in range(MOST_TIMES):
            if self._can_end(marking):
                return tuple(fired)
            before = list(marking)
            once = self._once(marking, tried.round)
            if once is None or marking == before:
                marking = before
                break
            fired += once
        if not fired:
            return None
        for t in tried.after:
            if self._can_end(marking):
                return tuple(fired)
            if self._fires(t, marking):
                fired.append(t)
        return tuple(fired) if self._can_end(marking) else None

    def _once(self, marking: Marking, round: tuple[tuple[int, ...], ...]) -> list[int] | None:
        fired = []
        for alternatives in round:
            t = next((each for each in alternatives if self._fires(each, marking)), None)
            if t is None:
                return None
            fired.append(t)
        return fired

    def _shorter(self, tried: _Repeated) -> tuple[int, ...] | None:
        """Return the run without firings before the round that it does not need."""
        known: dict[tuple[int, ...], bool] = {}

        def leads(marking: Marking) -> bool:
            here = tuple(marking)
            if here not in known and self._left > 0:
                known[here] = self._from(marking, tried) is not None
            return known.get(here, False)

        marking: Marking = self._net.initial.tolist()
        start = 0
        while not leads(marking):
            if start == len(tried.before) or not self._fires(tried.before[start], marking):
                return None
            start += 1
        before = shortened(self._net, tried.before[:start], leads, MOST_SHORTENED)
        return self._way(_Repeated(before, tried.round, tried.after))

    def _can_end(self, marking: Sequence[int]) -> bool:
        here = list(marking)
        return all(self._fires(t, here) for t in self._then)

    def _fires(self, t: int, marking: Marking) -> bool:
        """Fire a transition in place, if it is enabled."""
        self._left -= 1
        return self._rows.fire(t, marking)
