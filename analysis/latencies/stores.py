"""Values that a callback leaves on a place of its node, and that another callback reads later.

A subscription stores the newest message, and a timer samples it: after topics, the commonest way of data
through a node. A callback stores a value by a transition that puts a token on the place, whether it takes the
old one or not. Another callback reads it by a read arc, or takes it, or takes it and puts it back at once. A
callback that takes the token by one transition and puts it back by another one uses the place as a lock.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field

from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.elements import node_net_of, pages, resolve
from dineros.metamodel.times.runs import places_of_ports


@dataclass(frozen=True)
class Stored:
    """A value from a callback to another one, over a place that both use."""

    place: pn.Place
    writer: sym.CallbackPage
    reader: sym.CallbackPage


@dataclass
class _Uses:
    """How the transitions of a callback use a place."""

    only_puts: bool = False
    only_takes: bool = False
    loops: bool = False
    reads: bool = False
    numbers: set[int] = field(default_factory=set)

    @property
    def is_lock(self) -> bool:
        return self.only_puts and self.only_takes


def stored_values(model: sym.SystemModel) -> list[Stored]:
    """Return the ways of data from callbacks to callbacks over places of their node, in model order."""
    ports = places_of_ports(model)
    uses: dict[pn.Place, dict[sym.CallbackPage, _Uses]] = defaultdict(dict)
    for page in pages(model):
        if isinstance(page, sym.CallbackPage) and runs_callbacks(node_net_of(page)):
            for place, use in _uses(page).items():
                if place not in ports:
                    uses[place][page] = use
    return [
        Stored(place, writer, reader)
        for place, of in uses.items()
        if not any(each.is_lock or each.numbers - {1} for each in of.values())
        for writer, puts in of.items()
        for reader, takes in of.items()
        if writer is not reader and (puts.only_puts or puts.loops)
        if takes.reads or takes.only_takes or takes.loops
    ]


def _uses(page: sym.CallbackPage) -> dict[pn.Place, _Uses]:
    found: dict[pn.Place, _Uses] = defaultdict(_Uses)
    for transition in Body(page).transitions:
        taken, put = set[pn.Place](), set[pn.Place]()
        for arc in transition.incoming:
            place = resolve(arc.source)
            if isinstance(place, pn.Place) and arc.kind != pn.ArcKind.inhibitor:
                found[place].numbers.add(arc.weight)
                if arc.kind == pn.ArcKind.normal:
                    taken.add(place)
                else:
                    found[place].reads = True
        for arc in transition.outgoing:
            place = resolve(arc.target)
            if isinstance(place, pn.Place):
                found[place].numbers.add(arc.weight)
                put.add(place)
        for place in taken | put:
            use = found[place]
            use.loops |= place in taken and place in put
            use.only_takes |= place not in put
            use.only_puts |= place not in taken
    return found
