"""Enforces capacities of places by arcs in a net without channels; resolves references for rules."""

from __future__ import annotations

from dineros.metamodel import pn, pnm
from dineros.metamodel.elements import arcs, elements, fresh_id, places, resolve


def bounded(net: pn.Net) -> pn.Net:
    """Return a net whose arcs enforce the capacities of its places: a copy, or the net itself without any.

    The copy has no capacities any more.
    """
    if all(place.capacity is None for place in places(net)):
        return net
    # Most nets have no capacities, and do not need the rules.
    from dineros.transformations.language.copying import deep_copy
    from dineros.transformations.language.engine import Engine
    from dineros.transformations.rules.catalogue import rules_of
    from dineros.transformations.rules.phases import Phase

    working, _ = deep_copy(net)
    assert isinstance(working, pn.Net)
    taken = {element.id for element in elements(working) if element.id}
    sheet = pnm.Sheet(id=fresh_id("free room", taken))
    working.pages.append(sheet)
    join(working, pn.ReferenceTransition)
    join(working, pn.ReferencePlace)
    Engine(working).run(rule for rule in rules_of("none", "weighted") if rule.phase >= Phase.bounds)
    for made in (*sheet.objects, *sheet.arcs):
        made.id = fresh_id(made.id, taken)
    for place in places(working):
        place.capacity = None
    return working


def join(net: pn.Net, kind: type[pn.Node]) -> None:
    """Resolve references of a kind, so that rules see all arcs of the referenced nodes."""
    for arc in arcs(net):
        if isinstance(arc.source, kind):
            arc.source = resolve(arc.source)
        if isinstance(arc.target, kind):
            arc.target = resolve(arc.target)
