"""Boxes of tokens over some places of a net; conditions on the other places are rewritten.

A place that an invariant determines from others, ``D = c + sum k_i x_i``, is not stored in a marking.
Conditions of arcs on D become conditions on the x_i. If such a condition is not a box, it is split into
disjoint boxes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from math import prod
from operator import mul

from dineros.analysis.nets.compiled import CompiledNet

Box = dict[int, tuple[int, int]]

#: Largest number of value combinations tried when the guard of a determined place is turned into boxes; with
#: more, the place is kept.
LARGEST_PRODUCT = 256


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
    bounds : tuple of int
        Largest assumed number of tokens of each place (including dropped ones): proved, or a cap that is
        checked when firing.
    determined : dict
        Dropped place -> formula for its tokens.
    """

    net: CompiledNet
    bounds: tuple[int, ...]
    determined: dict[int, Determined]

    @cached_property
    def kept(self) -> tuple[int, ...]:
        """Places whose tokens are stored."""
        return tuple(p for p in range(len(self.net.places)) if p not in self.determined)

    def renumbered(self, net: CompiledNet, places: Sequence[int]) -> BoxNet:
        """Return the same object with the numbers of another net: place n is ``places[n]`` there."""
        bounds = [0] * len(places)
        for place, bound in zip(places, self.bounds, strict=True):
            bounds[place] = bound
        determined = {
            places[p]: Determined(rule.constant, {places[q]: factor for q, factor in rule.factors.items()})
            for p, rule in self.determined.items()
        }
        return BoxNet(net, tuple(bounds), determined)

    def full_marking(self, tokens: dict[int, int]) -> list[int]:
        """Return the marking of all places from the tokens of the kept ones."""
        marking = [tokens.get(p, 0) for p in range(len(self.net.places))]
        for place, rule in self.determined.items():
            marking[place] = rule.constant + sum(k * tokens[p] for p, k in rule.factors.items())
        return marking

    def guard_boxes(self, guard: Box) -> list[Box]:
        """Return a guard over all places as disjoint boxes over the kept ones.

        Raises
        ------
        ValueError
            If the guard of a determined place needs too many combinations of values.
        """
        boxes = [dict(guard)]
        for place, rule in self.determined.items():
            split: list[Box] = []
            for box in boxes:
                parts = split_box(box, place, rule, self.bounds) if place in box else [box]
                if parts is None:
                    raise ValueError(f"guard on {self.net.places[place]!r} is not a small union of boxes")
                split.extend(parts)
            boxes = split
        return boxes


def split_box(guard: Box, place: int, rule: Determined, bounds: Sequence[int]) -> list[Box] | None:
    """Rewrite a box's condition on a determined place as disjoint boxes without it; None: too many values."""
    low, high = guard[place]
    rest = {p: interval for p, interval in guard.items() if p != place}
    places = sorted(rule.factors)
    ranges = [rest.get(p, (0, bounds[p])) for p in places]
    if len(places) == 1:  # for any number of values: the values that fit form an interval
        interval = _solved(rule.factors[places[0]], low - rule.constant, high - rule.constant, ranges[0])
        return [] if interval is None else [_with(rest, places, (interval,), bounds)]
    if prod(b - a + 1 for a, b in ranges) > LARGEST_PRODUCT:
        return None
    factors = tuple(rule.factors[p] for p in places)
    covering = _covering(low - rule.constant, high - rule.constant, factors, tuple(ranges))
    return [_with(rest, places, intervals, bounds) for intervals in covering]


@lru_cache(maxsize=1 << 10)
def _covering(
    low: int, high: int, factors: tuple[int, ...], ranges: tuple[tuple[int, int], ...]
) -> list[tuple[tuple[int, int], ...]]:
    """Return disjoint boxes of the values whose weighted sum lies between two numbers."""
    good = {
        values
        for values in product(*(range(a, b + 1) for a, b in ranges))
        if low <= sum(map(mul, factors, values)) <= high
    }
    return _cover(good, len(factors))


def _with(
    guard: Box, places: Sequence[int], intervals: Sequence[tuple[int, int]], bounds: Sequence[int]
) -> Box:
    """Return a guard with intervals for further places, without intervals that exclude nothing."""
    box = dict(guard)
    for p, interval in zip(places, intervals, strict=True):
        if interval != (0, bounds[p]) or p in guard:
            box[p] = interval
    return box


def _solved(factor: int, low: int, high: int, within: tuple[int, int]) -> tuple[int, int] | None:
    """Return the numbers v of an interval with ``low <= factor * v <= high``; None if there are none."""
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
