"""Parts of a time Petri net that nothing else decides about: what holds there holds in the whole net.

A part has some places. Its transitions are those that change tokens there, and they test no place outside.
Others, its guests, may only take tokens there and put the same ones back. In the part they do so at any time.

Each run of the net is one of the part, without the firings that touch nothing there. The tokens are the same,
so the same transitions of the part are enabled. A clock starts again at the same firings: those that take
tokens of its transition are all in the part. So each firing of the part is in time, and none is missed.
The part can do more than the net, hence it proves what never happens and what always comes within a time, and
shows nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from dineros.analysis.logic.language.atoms import BoundAtoms, Linear, SomeEnabled, SomeFired
from dineros.analysis.logic.language.bounded import Bounded, is_step
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.syntax import Fired, Formula
from dineros.analysis.nets.compiled import Transition
from dineros.analysis.timed.nets import TimedNet

MOST = 0.7
"""Maximum share of the transitions of a net in a part that is analysed alone."""


@dataclass(frozen=True)
class NetPart:
    """A part of a net.

    Attributes
    ----------
    net : TimedNet
        The part, with the numbers of the whole net: what is left out never fires.
    own : frozenset of int
        Transitions that fire in the part as in the whole net.
    """

    net: TimedNet
    own: frozenset[int]


def part_of_formula(net: TimedNet, formula: Formula, names: Names) -> NetPart | None:
    """Return the part that decides about a formula; None if that is nearly the net, or not known.

    Firings that touch nothing in the part are left out. So conditions on firings are followed only where such
    a firing makes no difference.
    """
    if isinstance(formula, Bounded):
        trigger = formula.trigger
        if trigger is not None and is_step(trigger) and not isinstance(trigger, Fired):
            return None
        if formula.always and is_step(formula.condition):
            return None
    elif is_step(formula):
        return None
    places: set[int] = set()
    for condition in BoundAtoms(net.untimed, formula, names).conditions.values():
        match condition:
            case Linear(factors):
                places.update(factors)
            case SomeEnabled(asked) | SomeFired(asked):
                for transition in asked:
                    places |= net.untimed.tested(transition)
            case _:
                return None
    return part_around(net, places)


def part_of_firing(net: TimedNet, transition: int) -> NetPart | None:
    """Return the part that decides whether a transition ever fires; None if that is nearly the net."""
    return part_around(net, net.untimed.tested(transition))


def part_around(net: TimedNet, places: Iterable[int]) -> NetPart | None:
    """Return the smallest part with some places.

    None if it has nearly all transitions, no place or all places, or if priorities decide what fires.
    """
    inside = _closed(net, places)
    if not inside or len(inside) == len(net.untimed.places) or net.has_priorities:
        return None
    every = range(len(net.intervals))
    own = {
        t
        for t in every
        if net.untimed.tested(t) <= inside and (net.untimed.tested(t) or _changes(net, t, inside))
    }
    guests = {t for t in every if t not in own and any(place in inside for place, _ in net.take.row(t))}
    if len(own) + len(guests) > MOST * len(every):
        return None
    return NetPart(_cut(net, inside, own, guests), frozenset(own))


def _closed(net: TimedNet, places: Iterable[int]) -> set[int]:
    """Return places, and all those that transitions test that change tokens on one of them."""
    inside: set[int] = set()
    todo = list(places)
    while todo:
        place = todo.pop()
        if place in inside:
            continue
        inside.add(place)
        for transition in net.untimed.changing[place]:
            todo.extend(net.untimed.tested(transition) - inside)
    return inside


def _changes(net: TimedNet, transition: int, inside: set[int]) -> bool:
    return any(place in inside for place in net.untimed.delta[transition])


def _cut(net: TimedNet, inside: set[int], own: set[int], guests: set[int]) -> TimedNet:
    """Return the net of a part: what is left out never fires, and guests fire at any time."""
    tokens, rows = net.by_names()
    kept = {name for place, name in enumerate(net.untimed.places) if place in inside}
    never = next(name for name in tokens if name not in kept)
    for t, row in enumerate(rows):
        if t in own or t in guests:
            rows[t] = Transition(
                row.name, *({p: w for p, w in arcs.items() if p in kept} for arcs in row[1:])
            )
        else:
            rows[t] = Transition(row.name, {never: 1})
    intervals = {rows[t].name: net.intervals[t] for t in own}
    return TimedNet.build({p: n if p in kept else 0 for p, n in tokens.items()}, rows, intervals)
