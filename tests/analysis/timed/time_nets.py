"""Random time Petri nets, for the product and for the reference."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from random import Random

from dineros.analysis.nets.compiled import Transition
from dineros.analysis.timed.nets import Interval, TimedNet
from tests.support.references.regions import RegionGraph, TimedTransition


@dataclass(frozen=True)
class RandomNet:
    """A net as both sides take it."""

    initial: tuple[int, ...]
    transitions: list[TimedTransition]
    pairs: tuple[tuple[int, int], ...]

    @property
    def net(self) -> TimedNet:
        """The net of the product; its unit of time is a seventh."""
        places = {f"p{p}": tokens for p, tokens in enumerate(self.initial)}
        named = [
            Transition(one.name, *({f"p{p}": w for p, w in row.items()} for row in _rows(one)))
            for one in self.transitions
        ]
        intervals = {
            one.name: Interval(
                Fraction(one.earliest, 7),
                None if one.latest is None else Fraction(one.latest, 7),
                one.is_open_below,
                one.is_open_above,
            )
            for one in self.transitions
        }
        return TimedNet.build(places, named, intervals, [(f"t{high}", f"t{low}") for high, low in self.pairs])

    def regions(self, most: int = 20_000) -> RegionGraph:
        """The reference."""
        return RegionGraph(self.initial, self.transitions, most)


def _rows(one: TimedTransition) -> tuple[dict[int, int], ...]:
    return one.take, one.put, one.inhibitor, one.read


def random_net(random: Random, has_priorities: bool = False, is_closed: bool = False) -> RandomNet:
    """Return a net of few places, transitions and tokens; most keep the number of tokens."""
    places, count = random.randint(2, 5), random.randint(3, 6)
    initial = tuple(random.choice((0, 1, 1)) for _ in range(places))
    pairs = set()
    if has_priorities:
        for low in range(count):
            for high in range(low):
                if random.random() < 0.25:
                    pairs.add((high, low))
    made = []
    for number in range(count):
        take = {
            random.randrange(places): random.choice((1, 1, 1, 1, 2))
            for _ in range(random.choice((1, 1, 1, 2)))
        }
        put: dict[int, int] = {}
        for _ in range(min(sum(take.values()), random.choice((0, 1, 1, 1, 2, 2)))):
            place = random.randrange(places)
            put[place] = put.get(place, 0) + 1
        read = {random.randrange(places): 1} if random.random() < 0.2 else {}
        inhibitor = {random.randrange(places): random.choice((1, 2))} if random.random() < 0.2 else {}
        earliest = random.choice((0, 0, 1, 2, 3))
        latest = None if random.random() < 0.3 else earliest + random.choice((0, 0, 1, 2))
        opens_below = not is_closed and latest != earliest and random.random() < 0.2
        opens_above = not is_closed and latest not in (None, earliest) and random.random() < 0.2
        above: set[int] = set()
        todo = [number]
        while todo:
            low = todo.pop()
            for high, under in pairs:
                if under == low and high not in above:
                    above.add(high)
                    todo.append(high)
        made.append(
            TimedTransition(
                f"t{number}",
                take,
                put,
                read,
                inhibitor,
                earliest,
                latest,
                opens_below,
                opens_above,
                frozenset(above),
            )
        )
    return RandomNet(initial, made, tuple(sorted(pairs)))


def lively_net(
    random: Random, has_priorities: bool = False, is_closed: bool = False, most: int = 3_000
) -> RandomNet:
    """Return a random net with at least 5 markings and at most so many regions."""
    while True:
        net = random_net(random, has_priorities, is_closed)
        try:
            graph = net.regions(most)
        except OverflowError:
            continue
        if len(graph.markings) >= 5:
            return net


def prior_net(random: Random, most: int = 3_000) -> RandomNet:
    """Return a net with closed intervals and priorities; what stands above others has no earliest bound."""
    while True:
        net = lively_net(random, has_priorities=True, is_closed=True, most=most)
        higher = {high for high, _ in net.pairs}
        transitions = [
            replace(one, earliest=0) if number in higher else one
            for number, one in enumerate(net.transitions)
        ]
        made = replace(net, transitions=transitions)
        with suppress(OverflowError):
            if net.pairs and len(made.regions(most).markings) >= 5:
                return made
