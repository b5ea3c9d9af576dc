"""Nets as guarded translations over fewer places: determined places dropped, guards turned into boxes.

A transition becomes one or more *events*: a box (an interval of tokens for some places) and a translation.
A place that an invariant determines from others, ``D = c + sum k_i x_i``, needs no room in a stored
marking: what arcs ask of D is asked of the x_i instead. Where that is no box, the event is split into
disjoint boxes, so that the events of a transition never overlap and counts of arcs stay exact.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import prod

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.structure import PlaceInvariant

Box = dict[int, tuple[int, int]]

#: Combinations of values looked at when a determined place's guard is turned into boxes; beyond it the
#: place is kept.
LARGEST_PRODUCT = 256


@dataclass(frozen=True)
class Event:
    """One box of a transition's guard and the change of the kept places.

    Attributes
    ----------
    transition : int
    guard : dict
        Place -> (fewest, most) tokens, both inclusive. Places not named are free.
    change : dict
        Place -> tokens gained, never 0.
    """

    transition: int
    guard: Box
    change: dict[int, int]


@dataclass(frozen=True)
class Determined:
    """A dropped place: its tokens are ``constant + sum(factor * tokens of place)`` over kept places."""

    constant: int
    factors: dict[int, int]


@dataclass(frozen=True)
class BoxNet:
    """A net over its kept places only.

    Attributes
    ----------
    net : CompiledNet
    bounds : tuple of int
        Largest number of tokens assumed per place (of all places); proved, or a cap to be checked when
        firing.
    determined : dict
        Dropped place -> how to recover it.
    events_of : tuple of tuple of Event
        By transition: its events, over kept places; events whose guard can never hold are left out.
    touching : dict
        Place -> transitions; an event of another transition never names the place.
    """

    net: CompiledNet
    bounds: tuple[int, ...]
    determined: dict[int, Determined]
    events_of: tuple[tuple[Event, ...], ...]
    touching: dict[int, frozenset[int]]

    @cached_property
    def kept(self) -> tuple[int, ...]:
        """Places whose tokens are stored."""
        return tuple(p for p in range(len(self.net.places)) if p not in self.determined)

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """All events, in the order of their transitions."""
        return tuple(event for events in self.events_of for event in events)

    def drop(self, flow: PlaceInvariant, place: int, largest_growth: int) -> BoxNet | None:
        """The same net without `place`, determined by an exact invariant over otherwise kept places.

        Returns None when the guards on the place cannot be recovered with at most `largest_growth`
        additional events.
        """
        sign = flow.weights[place]
        if abs(sign) != 1 or not flow.exact or any(p in self.determined for p in flow.weights):
            return None
        rule = Determined(flow.constant * sign, {p: -w * sign for p, w in flow.weights.items() if p != place})
        growth = 0
        events_of = list(self.events_of)
        for transition in self.touching[place]:
            events: list[Event] = []
            for event in events_of[transition]:
                change = {p: tokens for p, tokens in event.change.items() if p != place}
                boxes = [event.guard]
                if place in event.guard:
                    split = _split(event.guard, place, rule, self.bounds)
                    if split is None:
                        return None
                    boxes = split
                    growth += max(0, len(boxes) - 1)
                events.extend(Event(transition, box, change) for box in boxes)
            events_of[transition] = tuple(events)
            if growth > largest_growth:
                return None
        touching = dict(self.touching)
        for p in rule.factors:
            touching[p] |= touching[place]
        return replace(
            self,
            determined={**self.determined, place: rule},
            events_of=tuple(events_of),
            touching=touching,
        )

    def renumbered(self, net: CompiledNet, places: Sequence[int], transitions: Sequence[int]) -> BoxNet:
        """The same boxes in the numbers of another net: place n is ``places[n]`` there."""
        bounds = [0] * len(places)
        for place, bound in zip(places, self.bounds, strict=True):
            bounds[place] = bound
        determined = {
            places[p]: Determined(rule.constant, {places[q]: factor for q, factor in rule.factors.items()})
            for p, rule in self.determined.items()
        }
        events_of: list[tuple[Event, ...]] = [()] * len(transitions)
        for transition, events in zip(transitions, self.events_of, strict=True):
            events_of[transition] = tuple(
                Event(
                    transition,
                    {places[p]: interval for p, interval in event.guard.items()},
                    {places[p]: tokens for p, tokens in event.change.items()},
                )
                for event in events
            )
        touching = {places[p]: frozenset(transitions[t] for t in ts) for p, ts in self.touching.items()}
        return BoxNet(net, tuple(bounds), determined, tuple(events_of), touching)

    def over_kept(self, flow: PlaceInvariant) -> PlaceInvariant:
        """The same invariant written over kept places."""
        weights: dict[int, int] = {}
        constant = flow.constant
        for place, weight in flow.weights.items():
            rule = self.determined.get(place)
            constant -= weight * rule.constant if rule else 0
            for p, factor in (rule.factors if rule else {place: 1}).items():
                weights[p] = weights.get(p, 0) + weight * factor
        return PlaceInvariant({p: w for p, w in weights.items() if w}, constant, flow.exact)

    def full_marking(self, tokens: dict[int, int]) -> list[int]:
        """Marking of all places from the tokens of the kept ones."""
        marking = [tokens.get(p, 0) for p in range(len(self.net.places))]
        for place, rule in self.determined.items():
            marking[place] = rule.constant + sum(k * tokens[p] for p, k in rule.factors.items())
        return marking

    def guard_boxes(self, guard: Box) -> list[Box]:
        """A guard over all places as disjoint boxes over the kept ones.

        Raises
        ------
        ValueError
            If a determined place's guard needs more combinations than are looked at.
        """
        boxes = [dict(guard)]
        for place, rule in self.determined.items():
            split: list[Box] = []
            for box in boxes:
                parts = _split(box, place, rule, self.bounds) if place in box else [box]
                if parts is None:
                    raise ValueError(f"guard on {self.net.places[place]!r} is not a small union of boxes")
                split.extend(parts)
            boxes = split
        return boxes


def box_net(net: CompiledNet, bounds: Sequence[int]) -> BoxNet:
    """The net with every place kept."""
    events_of: list[tuple[Event, ...]] = []
    touching: list[set[int]] = [set() for _ in net.places]
    for transition, change in enumerate(net.delta):
        guard = {p: (weight, bounds[p]) for p, weight in net.pre.row(transition)}
        for p, weight in net.inhibitor.row(transition):
            low, high = guard.get(p, (0, bounds[p]))
            guard[p] = (low, min(high, weight - 1))
        guard = {p: interval for p, interval in guard.items() if interval != (0, bounds[p])}
        can_fire = all(low <= high for low, high in guard.values())
        events_of.append((Event(transition, guard, dict(change)),) if can_fire else ())
        for p in (*guard, *change):
            touching[p].add(transition)
    return BoxNet(
        net, tuple(bounds), {}, tuple(events_of), {p: frozenset(ts) for p, ts in enumerate(touching)}
    )


def drop_determined(
    net: BoxNet,
    flows: Iterable[PlaceInvariant],
    largest_growth: int,
    candidates: Container[int] | None = None,
) -> BoxNet:
    """Drop places that short invariants determine, shortest first.

    Of an invariant the place with the largest bound goes first, then the one that the fewest guards ask
    for; places that determine another one stay.

    Parameters
    ----------
    net
        The net.
    flows
        Exact invariants.
    largest_growth
        Additional events allowed for each dropped place.
    candidates
        Places that may be dropped; all of them by default.
    """
    locked: set[int] = {p for rule in net.determined.values() for p in rule.factors}
    asked = [0] * len(net.bounds)
    for event in net.events:
        for p in event.guard:
            asked[p] += 1
    for original in sorted(flows, key=lambda y: len(y.weights)):
        flow = net.over_kept(original)
        if len(flow.weights) < 2:
            continue
        for place in sorted(flow.weights, key=lambda p: (-net.bounds[p], asked[p], -p)):
            if place in locked or (candidates is not None and place not in candidates):
                continue
            smaller = net.drop(flow, place, largest_growth)
            if smaller is not None:
                net = smaller
                locked.update(net.determined[place].factors)
                break
    return net


def _split(guard: Box, place: int, rule: Determined, bounds: Sequence[int]) -> list[Box] | None:
    low, high = guard[place]
    rest = {p: interval for p, interval in guard.items() if p != place}
    places = sorted(rule.factors)
    ranges = [rest.get(p, (0, bounds[p])) for p in places]
    if len(places) == 1:  # however many values: those that fit are an interval
        interval = _solved(rule.factors[places[0]], low - rule.constant, high - rule.constant, ranges[0])
        return [] if interval is None else [_with(rest, places, (interval,), bounds)]
    if prod(b - a + 1 for a, b in ranges) > LARGEST_PRODUCT:
        return None
    good = {
        values
        for values in product(*(range(a, b + 1) for a, b in ranges))
        if low
        <= rule.constant + sum(rule.factors[p] * v for p, v in zip(places, values, strict=True))
        <= high
    }
    return [_with(rest, places, intervals, bounds) for intervals in _cover(good, len(places))]


def _with(
    guard: Box, places: Sequence[int], intervals: Sequence[tuple[int, int]], bounds: Sequence[int]
) -> Box:
    """Return a guard with intervals for further places, where they say something."""
    box = dict(guard)
    for p, interval in zip(places, intervals, strict=True):
        if interval != (0, bounds[p]) or p in guard:
            box[p] = interval
    return box


def _solved(factor: int, low: int, high: int, within: tuple[int, int]) -> tuple[int, int] | None:
    """Return the numbers v of an interval with ``low <= factor * v <= high``; None where there are none."""
    if factor < 0:
        factor, low, high = -factor, -high, -low
    first, last = max(within[0], -(-low // factor)), min(within[1], high // factor)
    return (first, last) if first <= last else None


def _cover(values: set[tuple[int, ...]], width: int) -> list[tuple[tuple[int, int], ...]]:
    """Return disjoint boxes that cover exactly a set of vectors, split on the first coordinate."""
    if not values:
        return []
    if width == 0:
        return [()]
    tails: dict[int, frozenset[tuple[int, ...]]] = {}
    for first in sorted({value[0] for value in values}):
        tails[first] = frozenset(value[1:] for value in values if value[0] == first)
    boxes: list[tuple[tuple[int, int], ...]] = []
    firsts = sorted(tails)
    start = 0
    while start < len(firsts):
        end = start
        while end + 1 < len(firsts) and firsts[end + 1] == firsts[end] + 1:
            if tails[firsts[end + 1]] != tails[firsts[start]]:
                break
            end += 1
        interval = (firsts[start], firsts[end])
        boxes.extend((interval, *tail) for tail in _cover(set(tails[firsts[start]]), width - 1))
        start = end + 1
    return boxes
