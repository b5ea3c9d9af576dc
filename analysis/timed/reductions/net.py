"""A time Petri net that rules can make smaller, by names."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from dineros.analysis.nets.compiled import Transition
from dineros.analysis.reductions.certificates import GuardedBounds
from dineros.analysis.reductions.net import MutableNet
from dineros.analysis.timed.nets import Interval, TimedNet

Row = dict[str, int]


@dataclass
class TimedArcs:
    """What a transition does.

    Attributes
    ----------
    take, put, test, inhibitors : dict
        By place: tokens taken, put, that must be there (taken ones included), and from which on it is
        disabled.
    above : frozenset of str
        Transitions with priority over it, directly or through others.
    """

    take: Row
    put: Row
    test: Row
    inhibitors: Row
    interval: Interval
    above: frozenset[str]


@dataclass
class SmallerNet:
    """A net from which places and transitions are removed.

    Attributes
    ----------
    places : dict
        Name -> initial tokens.
    transitions : dict
        Name -> `TimedArcs`.
    """

    places: Row
    transitions: dict[str, TimedArcs] = field(default_factory=dict)

    @classmethod
    def of(cls, net: TimedNet) -> SmallerNet:
        """Copy a net."""
        plain, names = net.untimed, net.untimed.places
        made = cls(dict(zip(names, plain.initial.tolist(), strict=True)))
        for t, name in enumerate(plain.transitions):
            take, put, test, inhibitors = (
                {names[p]: int(w) for p, w in table.row(t)}
                for table in (net.take, net.put, plain.pre, plain.inhibitor)
            )
            above = frozenset(plain.transitions[high] for high in net.above[t])
            made.transitions[name] = TimedArcs(take, put, test, inhibitors, net.intervals[t], above)
        return made

    def compile(self) -> TimedNet:
        """Return the net as it is now."""
        rows = [
            Transition(
                name,
                arcs.take,
                arcs.put,
                arcs.inhibitors,
                {p: w - arcs.take.get(p, 0) for p, w in arcs.test.items() if w > arcs.take.get(p, 0)},
            )
            for name, arcs in self.transitions.items()
        ]
        intervals = {name: arcs.interval for name, arcs in self.transitions.items()}
        priorities = [(high, low) for low, arcs in self.transitions.items() for high in sorted(arcs.above)]
        return TimedNet.build(self.places, rows, intervals, priorities)

    @cached_property
    def plain(self) -> MutableNet:
        """The net without its times: it has all markings that the net has."""
        return MutableNet.of(self.compile().untimed)

    @cached_property
    def bounds(self) -> GuardedBounds:
        """Results of the state equation of the net without its times."""
        return GuardedBounds(self.plain)

    def remove_place(self, place: str) -> None:
        """Remove a place with its arcs."""
        del self.places[place]
        for arcs in self.transitions.values():
            for row in (arcs.take, arcs.put, arcs.test, arcs.inhibitors):
                row.pop(place, None)
        self._forget()

    def remove_transition(self, transition: str) -> None:
        """Remove a transition; what it has priority over loses that."""
        del self.transitions[transition]
        for arcs in self.transitions.values():
            arcs.above -= {transition}
        self._forget()

    def _forget(self) -> None:
        for name in ("plain", "bounds"):
            self.__dict__.pop(name, None)

    def under(self, transition: str) -> frozenset[str]:
        """Return what a transition has priority over."""
        return frozenset(name for name, arcs in self.transitions.items() if transition in arcs.above)

    def excludes_twice(self, first: str, second: str) -> bool:
        """Whether no marking enables the second transition after the first has taken its tokens.

        Asked of the net without times, by the state equation.
        """
        one, other = self.transitions[first], self.transitions[second]
        guard = dict(one.test)
        for place, weight in other.test.items():
            guard[place] = max(guard.get(place, 0), one.take.get(place, 0) + weight)
        return self.bounds.excludes(guard)
