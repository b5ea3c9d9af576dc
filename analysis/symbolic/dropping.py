"""A net as guarded translations; places that invariants determine are dropped one by one.

A transition becomes one or more *events*: a box (an interval of tokens for some places) and a translation.
If a condition on a dropped place is not a box over the other places, events are split into disjoint ones.
The events of a transition never overlap, so that counts of arcs stay exact.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.structure import PlaceInvariant
from dineros.analysis.symbolic.boxes import Box, BoxNet, Determined, split_box


@dataclass(frozen=True)
class Event:
    """One box of the guard of a transition, and the change of the kept places.

    Attributes
    ----------
    guard : dict
        Place -> (fewest, most) tokens, both inclusive. Places not named are free.
    change : dict
        Place -> tokens gained, never 0.
    """

    transition: int
    guard: Box
    change: dict[int, int]


class GuardedNet:
    """A net with its events, at first over all places.

    Parameters
    ----------
    bounds : sequence of int
        Largest assumed number of tokens of each place.

    Attributes
    ----------
    determined : dict
        Dropped place -> formula for its tokens.
    """

    def __init__(self, net: CompiledNet, bounds: Sequence[int]) -> None:
        self._net = net
        self._bounds = tuple(bounds)
        self.determined: dict[int, Determined] = {}
        #: By transition: its events, over kept places; events whose guard can never hold are omitted.
        self._events_of: list[list[Event]] = []
        #: By place: transitions whose events may name the place; events of other transitions never name it.
        self._touching: list[set[int]] = [set() for _ in net.places]
        for transition, change in enumerate(net.delta):
            guard = {p: (weight, bounds[p]) for p, weight in net.pre.row(transition)}
            for p, weight in net.inhibitor.row(transition):
                low, high = guard.get(p, (0, bounds[p]))
                guard[p] = (low, min(high, weight - 1))
            guard = {p: interval for p, interval in guard.items() if interval != (0, bounds[p])}
            can_fire = all(low <= high for low, high in guard.values())
            self._events_of.append([Event(transition, guard, dict(change))] if can_fire else [])
            for p in (*guard, *change):
                self._touching[p].add(transition)

    @property
    def events(self) -> Iterator[Event]:
        """All events, in the order of their transitions."""
        return (event for events in self._events_of for event in events)

    @property
    def kept(self) -> list[int]:
        """Places that are not dropped."""
        return [p for p in range(len(self._bounds)) if p not in self.determined]

    def boxes(self) -> BoxNet:
        """Return the kept places and the formulas for the others."""
        return BoxNet(self._net, self._bounds, self.determined)

    def over_kept(self, flow: PlaceInvariant) -> PlaceInvariant:
        """The same invariant written over kept places."""
        weights: dict[int, int] = {}
        constant = flow.constant
        for place, weight in flow.weights.items():
            rule = self.determined.get(place)
            if rule is None:
                weights[place] = weights.get(place, 0) + weight
                continue
            constant -= weight * rule.constant
            for p, factor in rule.factors.items():
                weights[p] = weights.get(p, 0) + weight * factor
        return PlaceInvariant({p: w for p, w in weights.items() if w}, constant)

    def drop(self, flow: PlaceInvariant, place: int, largest_growth: int) -> bool:
        """Drop a place that an invariant over otherwise kept places determines.

        Returns False and changes nothing if the guards on the place cannot be rewritten with at most
        `largest_growth` additional events.
        """
        sign = flow.weights[place]
        if abs(sign) != 1 or any(p in self.determined for p in flow.weights):
            return False
        rule = Determined(flow.constant * sign, {p: -w * sign for p, w in flow.weights.items() if p != place})
        growth = 0
        changed: dict[int, list[Event]] = {}
        for transition in self._touching[place]:
            events = changed[transition] = []
            for event in self._events_of[transition]:
                change = {p: tokens for p, tokens in event.change.items() if p != place}
                boxes: list[Box] = [event.guard]
                if place in event.guard:
                    split = split_box(event.guard, place, rule, self._bounds)
                    if split is None:
                        return False
                    boxes = split
                    growth += max(0, len(boxes) - 1)
                events.extend(Event(transition, box, change) for box in boxes)
            if growth > largest_growth:
                return False
        for transition, events in changed.items():
            self._events_of[transition] = events
        for p in rule.factors:
            self._touching[p] |= self._touching[place]
        self.determined[place] = rule
        return True

    def drop_determined(
        self,
        flows: Iterable[PlaceInvariant],
        largest_growth: int,
        candidates: Container[int] | None = None,
    ) -> None:
        """Drop places that short invariants determine, shortest first.

        Of an invariant, the place with the largest bound is dropped first; on a tie, the one in the fewest
        guards. Places that determine another one are kept.

        Parameters
        ----------
        largest_growth
            Additional events allowed for each dropped place.
        candidates
            Places that may be dropped; all of them by default.
        """
        bounds = self._bounds
        locked: set[int] = {p for rule in self.determined.values() for p in rule.factors}
        asked = [0] * len(bounds)
        for event in self.events:
            for p in event.guard:
                asked[p] += 1
        for original in sorted(flows, key=lambda y: len(y.weights)):
            flow = self.over_kept(original)
            if len(flow.weights) < 2:
                continue
            for place in sorted(flow.weights, key=lambda p: (-bounds[p], asked[p], -p)):
                if place in locked or (candidates is not None and place not in candidates):
                    continue
                if self.drop(flow, place, largest_growth):
                    locked.update(self.determined[place].factors)
                    break
