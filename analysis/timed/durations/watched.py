"""A net with an observer next to it: further transitions that measure time and change nothing.

All transitions of the net read one more place, the gate, that an observer may empty: then the net stops. Only
the observer takes from it, so no clock of the net is disturbed. The numbers of places and transitions of the
net stay.

A transition is *noticed* by a copy of itself with the same interval, which also puts a token for the
observer. A transition and its copy take and put back one token of a place of their own, so that the firing of
one starts the clock of the other again, as it does its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from dineros.analysis.nets.compiled import Transition, unused
from dineros.analysis.timed.nets import Interval, TimedNet

Arcs = Mapping[str, int]


@dataclass(frozen=True)
class Watcher:
    """A transition of an observer.

    Attributes
    ----------
    takes, puts, reads : tuple of str
        Places of the observer, one token each.
    """

    name: str
    interval: Interval
    takes: tuple[str, ...] = ()
    puts: tuple[str, ...] = ()
    reads: tuple[str, ...] = ()


@dataclass(frozen=True)
class Watched:
    """A net with its observer.

    Attributes
    ----------
    original, net : TimedNet
        Without and with the observer.
    copy_of : dict of int to int
        By copy of a transition that is noticed, the transition.
    """

    original: TimedNet
    net: TimedNet
    place: dict[str, int]
    transition: dict[str, int]
    copy_of: dict[int, int]

    def in_original(self, transition: int) -> int | None:
        """Return the transition of the net that one fires; None for one of the observer."""
        own = self.copy_of.get(transition, transition)
        return own if own < len(self.original.untimed.transitions) else None

    def trace_of(self, trace: Iterable[int]) -> tuple[int, ...]:
        """Return the firings of the net in a sequence."""
        return tuple(t for t in map(self.in_original, trace) if t is not None)


GATE = "gate"


def watched(
    net: TimedNet,
    places: Mapping[str, int],
    watchers: Sequence[Watcher],
    noticed: Iterable[int] = (),
    takes: tuple[str, ...] = (),
    puts: tuple[str, ...] = (),
) -> Watched:
    """Add an observer to a net.

    Parameters
    ----------
    places
        Places of the observer with their tokens; `GATE` is added, with one.
    watchers
        Its transitions.
    noticed
        Transitions of the net that get a copy.
    takes, puts
        What such a copy takes from and puts to places of the observer.
    """
    untimed = net.untimed
    names = {name: unused(f"observer {name}", untimed.places) for name in (GATE, *places)}
    tokens, rows = net.by_names()
    tokens |= {names[name]: count for name, count in {GATE: 1, **places}.items()}
    made = [row._replace(reads={**row.reads, names[GATE]: 1}) for row in rows]
    intervals = dict(zip(untimed.transitions, net.intervals, strict=True))
    pairs = [(high, low) for low, row in enumerate(net.above) for high in row]
    copies: list[Transition] = []
    copy_of: dict[int, int] = {}
    copies_of: dict[int, list[str]] = {}
    for t in noticed:
        lock = unused(f"lock of {untimed.transitions[t]}", tokens)
        tokens[lock] = 1
        one = made[t]
        made[t] = one._replace(inputs={**one.inputs, lock: 1}, outputs={**one.outputs, lock: 1})
        name = unused(f"{one.name} noticed", intervals)
        intervals[name] = net.intervals[t]
        copy = made[t]._replace(
            name=name,
            inputs={**made[t].inputs, **{names[p]: 1 for p in takes}},
            outputs={**made[t].outputs, **{names[p]: 1 for p in puts}},
        )
        copy_of[len(untimed.transitions) + len(copies)] = t
        copies_of[t] = [name]
        copies.append(copy)
    own: dict[str, int] = {}
    for watcher in watchers:
        name = unused(f"observer {watcher.name}", intervals)
        own[watcher.name] = len(untimed.transitions) + len(copies) + len(own)
        intervals[name] = watcher.interval
    of_observer = [
        Transition(
            list(intervals)[own[each.name]],
            {names[p]: 1 for p in each.takes},
            {names[p]: 1 for p in each.puts},
            {},
            {names[p]: 1 for p in each.reads},
        )
        for each in watchers
    ]
    priorities = [
        (high, low)
        for above, below in pairs
        for high in (untimed.transitions[above], *copies_of.get(above, ()))
        for low in (untimed.transitions[below], *copies_of.get(below, ()))
    ]
    extended = TimedNet.build(tokens, [*made, *copies, *of_observer], intervals, priorities)
    index = {name: number for number, name in enumerate(extended.untimed.places)}
    return Watched(net, extended, {name: index[own_name] for name, own_name in names.items()}, own, copy_of)
