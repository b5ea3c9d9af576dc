"""Building nets in Python: arcs that read like the flow they describe.

>>> from dineros.metamodel import pn
>>> from dineros.metamodel.build import flow
>>> page = pn.Page(id="page")
>>> idle, start, busy = pn.Place(id="idle", tokens=1), pn.Transition(id="start"), pn.Place(id="busy")
>>> page.objects.extend([idle, start, busy])
>>> [arc.id for arc in flow(idle, start, busy)]
['idle-start', 'start-busy']
"""

from __future__ import annotations

from itertools import pairwise

from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError


def flow(*nodes: pn.Node, weight: int = 1) -> list[pn.Arc]:
    """Join nodes of one page by a chain of normal arcs, in the order given.

    Raises
    ------
    DinerosError
        Two neighbours do not stand on the same page.
    """
    return [_arc(source, target, weight, "normal") for source, target in pairwise(nodes)]


def read(place: pn.PlaceNode, transition: pn.TransitionNode, weight: int = 1) -> pn.Arc:
    """Let a transition test a place for `weight` tokens without taking them."""
    return _arc(place, transition, weight, "read")


def inhibit(place: pn.PlaceNode, transition: pn.TransitionNode, weight: int = 1) -> pn.Arc:
    """Let a transition be enabled only while a place holds fewer than `weight` tokens."""
    return _arc(place, transition, weight, "inhibitor")


def _arc(source: pn.Node, target: pn.Node, weight: int, kind: str) -> pn.Arc:
    page = source.page
    if page is None or page is not target.page:
        raise DinerosError(
            f"{source.id} and {target.id} do not stand on the same page",
            element=source.id,
            hint="use a reference place or a reference transition",
        )
    suffix = "" if kind == "normal" else f"-{kind}"
    return pn.Arc(
        id=f"{source.id}-{target.id}{suffix}",
        source=source,
        target=target,
        weight=weight,
        kind=kind,
        page=page,
    )
