"""Capacities of places of a net without channels, obeyed by arcs; and references resolved for rules."""

from __future__ import annotations

from dineros.metamodel import pn, pnm
from dineros.metamodel.elements import arcs, elements, places, resolve


def bounded(net: pn.Net) -> pn.Net:
    """Return a net whose arcs obey the capacities of its places: a copy, or the net itself without any.

    The copy says no capacities any more.
    """
    if all(place.capacity is None for place in places(net)):
        return net
    # Most nets have no capacities, and need no rules.
    from dineros.transformations.language.copying import deep_copy
    from dineros.transformations.language.engine import Engine
    from dineros.transformations.rules.catalogue import rules_of
    from dineros.transformations.rules.phases import Phase

    working, _ = deep_copy(net)
    assert isinstance(working, pn.Net)
    taken = {element.id for element in elements(working) if element.id}
    sheet = pnm.Sheet(id=fresh("free room", taken))
    working.pages.append(sheet)
    join(working, pn.ReferenceTransition)
    join(working, pn.ReferencePlace)
    Engine(working).run(rule for rule in rules_of("none", "weighted") if rule.phase >= Phase.bounds)
    for made in (*sheet.objects, *sheet.arcs):
        made.id = fresh(made.id, taken)
    for place in places(working):
        place.capacity = None
    return working


def join(net: pn.Net, kind: type[pn.Node]) -> None:
    """Resolve references of a kind, so that rules about the arcs of what they refer to see all of them."""
    for arc in arcs(net):
        if isinstance(arc.source, kind):
            arc.source = resolve(arc.source)
        if isinstance(arc.target, kind):
            arc.target = resolve(arc.target)


def fresh(id: str, taken: set[str]) -> str:
    """Return an id that nothing else has; the second ``a-b`` becomes ``a-b~2``."""
    found, number = id, 1
    while found in taken:
        number += 1
        found = f"{id}~{number}"
    taken.add(found)
    return found
