"""Time Petri nets that an observer is added to: transitions are split into cases.

A case of a transition fires instead of it under more conditions, and does more. Cases keep its interval, so a
place that distinguishes them must not change while the transition is enabled, unless it fires at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from dineros.analysis.nets.compiled import Transition
from dineros.analysis.timed.nets import Interval, TimedNet

Arcs = dict[str, int]


@dataclass(frozen=True)
class Case:
    """Further effects of one case of a transition, and their times."""

    take: Mapping[str, int] = field(default_factory=dict)
    put: Mapping[str, int] = field(default_factory=dict)
    read: Mapping[str, int] = field(default_factory=dict)
    """`take`, `put`, `read`: more arcs; those of `take` and `read` add up."""
    inhibit: Mapping[str, int] = field(default_factory=dict)
    """Places that must hold fewer tokens."""
    rename: Mapping[str, str] = field(default_factory=dict)
    """Places that stand for others in the arcs of the transition itself."""
    instead: Mapping[str, str] = field(default_factory=dict)
    """Places that get one of the tokens that the transition puts on others."""
    drop: frozenset[str] = frozenset()
    """Places whose arcs are left out, before they are renamed."""


PLAIN = Case()
"""As without the observer."""


@dataclass(frozen=True)
class Firing:
    """A transition, or a case of one."""

    name: str
    take: Arcs
    put: Arcs
    read: Arcs
    inhibit: Arcs
    interval: Interval

    def in_case(self, case: Case, number: int) -> Firing:
        """Return a case of it."""
        take, put, read = (_renamed(arcs, case) for arcs in (self.take, self.put, self.read))
        inhibit = _renamed(self.inhibit, case)
        for place, other in case.instead.items():
            put[place] -= 1
            put[other] = put.get(other, 0) + 1
        put = {place: weight for place, weight in put.items() if weight}
        for place, below in case.inhibit.items():
            inhibit[place] = min(below, inhibit.get(place, below))
        return Firing(
            f"{self.name}#{number}",
            _sum(take, case.take),
            _sum(put, case.put),
            _sum(read, case.read),
            inhibit,
            self.interval,
        )


class EditedNet:
    """A time Petri net to which an observer is added.

    `net`: it stays as it is.
    """

    def __init__(self, net: TimedNet) -> None:
        untimed = net.untimed
        names = untimed.transitions
        self.places, rows = net.by_names()
        self.cases: dict[str, list[Firing]] = {}
        self._above = [(names[high], names[low]) for low, row in enumerate(net.above) for high in row]
        for row, interval in zip(rows, net.intervals, strict=True):
            take, put, inhibit, read = map(dict, row[1:])
            self.cases[row.name] = [Firing(row.name, take, put, read, inhibit, interval)]

    def original(self, name: str) -> Firing:
        """Return the first case of a transition."""
        return self.cases[name][0]

    def place(self, name: str, tokens: int = 0) -> str:
        """Add a place; return its name."""
        assert name not in self.places, name
        self.places[name] = tokens
        return name

    def add(self, firing: Firing) -> None:
        """Add a transition."""
        assert firing.name not in self.cases, firing.name
        self.cases[firing.name] = [firing]

    def split(self, name: str, cases: Sequence[Case]) -> None:
        """Split each case of a transition into cases."""
        self.cases[name] = [
            old if case is PLAIN else old.in_case(case, number)
            for old in self.cases[name]
            for number, case in enumerate(cases)
        ]

    def extend(self, name: str, **more: Arcs) -> None:
        """Add arcs to all cases of a transition: `take`, `put` or `read`."""
        for kind, arcs in more.items():
            changed = [{kind: _sum(getattr(each, kind), arcs)} for each in self.cases[name]]
            cases = zip(self.cases[name], changed, strict=True)
            self.cases[name] = [replace(each, **change) for each, change in cases]  # type: ignore[arg-type]

    def redirect(self, name: str, old: str, new: str) -> None:
        """Let a transition put tokens on another place."""
        self.cases[name] = [
            replace(each, put={new if place == old else place: w for place, w in each.put.items()})
            for each in self.cases[name]
        ]

    def producers(self, place: str) -> list[str]:
        """Return the transitions that leave more tokens on a place than they take."""
        return [
            name
            for name, cases in self.cases.items()
            if any(each.put.get(place, 0) > each.take.get(place, 0) for each in cases)
        ]

    def consumers(self, place: str) -> list[str]:
        """Return the transitions that take more tokens from a place than they leave there."""
        return [
            name
            for name, cases in self.cases.items()
            if any(each.take.get(place, 0) > each.put.get(place, 0) for each in cases)
        ]

    def originals(self) -> dict[str, str]:
        """Return by case of a transition the transition that was split."""
        return {each.name: name for name, cases in self.cases.items() for each in cases}

    def compiled(
        self, wanted: Iterable[str], goes: str, free: Iterable[str], *, is_whole: bool = False
    ) -> TimedNet:
        """Return the net, without what cannot matter for some places.

        Parameters
        ----------
        wanted
            Places that are looked at.
        goes
            A place that everything reads that does not take it.
        free
            Transitions that fire without it.
        is_whole
            Whether nothing is left out.
        """
        firings = [each for cases in self.cases.values() for each in cases]
        is_whole = is_whole or bool(self._above)
        kept, places = (firings, set(self.places)) if is_whole else _relevant(firings, wanted)
        places.add(goes)
        excepted = set(free)
        made = [
            Transition(
                each.name,
                each.take,
                each.put,
                each.inhibit,
                each.read if goes in each.take or each.name in excepted else {**each.read, goes: 1},
            )
            for each in kept
        ]
        trimmed = [
            one._replace(outputs={place: w for place, w in one.outputs.items() if place in places})
            for one in made
        ]
        there = {each.name for each in kept}
        priorities = [
            (high.name, low.name)
            for above, below in self._above
            for high in self.cases[above]
            for low in self.cases[below]
            if high.name in there and low.name in there
        ]
        return TimedNet.build(
            {place: n for place, n in self.places.items() if place in places},
            trimmed,
            {each.name: each.interval for each in kept},
            priorities,
        )


def _relevant(firings: Sequence[Firing], wanted: Iterable[str]) -> tuple[list[Firing], set[str]]:
    """Return the transitions that take or put tokens of places that matter, and these places.

    Other transitions neither enable nor disable anything
    that matters, and time passes whether they fire or not.
    """
    by_place: dict[str, list[Firing]] = {}
    for each in firings:
        for place in {*each.take, *each.put}:
            by_place.setdefault(place, []).append(each)  # taking and giving back disturbs clocks, too
    places: set[str] = set()
    kept: set[str] = set()
    todo = list(wanted)
    while todo:
        place = todo.pop()
        if place in places:
            continue
        places.add(place)
        for each in by_place.get(place, ()):
            if each.name not in kept:
                kept.add(each.name)
                todo.extend((*each.take, *each.read, *each.inhibit))
    return [each for each in firings if each.name in kept], places


def _renamed(arcs: Mapping[str, int], case: Case) -> Arcs:
    return _sum({}, {case.rename.get(p, p): w for p, w in arcs.items() if p not in case.drop})


def _sum(one: Mapping[str, int], other: Mapping[str, int]) -> Arcs:
    return {place: one.get(place, 0) + other.get(place, 0) for place in (*one, *other)}
