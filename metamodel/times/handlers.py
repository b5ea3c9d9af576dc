"""Handlers in flight in node nets of the execution `net`: how long they take, and what they keep from firing.

While a handler works, the engine reserves the tokens that its transition takes, and room for those that it
puts. The tokens stay where they are until it ends, and read and inhibitor arcs see them. So a transition that
takes one of them is not fired meanwhile, although the marking enables it.
"""

from __future__ import annotations

from collections.abc import Iterator

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.callbacks.groups import callback_page_of, runs_callbacks
from dineros.metamodel.elements import resolve
from dineros.metamodel.times.given import default_times, reaction_of
from dineros.metamodel.times.runs import ports_at, stand_for


def handled_for(move: pn.Transition) -> pn.TimeInterval | None:
    """Return how long the handler of a transition is in flight; None if no duration is given."""
    if not isinstance(move, sym.Transition):
        return None
    return move.duration if move.duration is not None else default_times(move).duration


def is_kept_back(move: pn.Transition) -> bool:
    """Return whether a handler in flight can keep an engine from firing a transition that is enabled."""
    needed = {each for each, kind in _sources(move) if kind == pn.ArcKind.normal}
    filled = {each for each in _targets(move) if each.capacity}
    takers = {each for place in needed for each in _takers(place)}
    takers |= {each for place in filled for each in _putters(place)}
    return any(each is not move and handled_for(each) is not None for each in takers)


def handled_until(node: sym.NodeNet, move: pn.Transition) -> float | None:
    """Return the time after which an enabled transition with a handler has fired; None if that is open.

    Nothing else may take the tokens that it needs, or fill the place of those that it puts. Then the handler
    begins within the reaction, and nothing ends it before its time. It is open for what belongs to an
    instance, a timer or a managed node, and for what signals, data or places that others test decide.
    """
    duration, reaction = handled_for(move), reaction_of(node)
    if duration is None or reaction is None or duration.latest is None or reaction.latest is None:
        return None
    assert isinstance(move, sym.Transition)
    page = callback_page_of(move)
    decided = move.interval is not None or move.clause is not None or move.guard is not None
    others = [each for each in node.eAllContents() if isinstance(each, pn.Transition)]
    decided |= bool(move.overrides) or any(move in each.overrides for each in others)
    if decided or runs_callbacks(node) or node.lifecycle is not None:
        return None
    if page is not None and page.kind != sym.CallbackKind.subscriber:
        return None
    for place, kind in _sources(move):
        if kind != pn.ArcKind.normal or place.capacity or any(each is not move for each in _takers(place)):
            return None
        if any(not isinstance(port, sym.SubscriberPort) for port in ports_at(place)):
            return None
    if any(place.capacity for place in _targets(move)):
        return None
    return reaction.latest + duration.latest


def _sources(move: pn.Transition) -> Iterator[tuple[pn.Place, pn.ArcKind]]:
    """Yield the places that a transition needs or tests in the model, without what rules add."""
    for arc in move.incoming:
        place = resolve(arc.source)
        if isinstance(place, pn.Place) and not isinstance(arc.page, pnm.Sheet):
            yield place, arc.kind


def _targets(move: pn.Transition) -> Iterator[pn.Place]:
    for arc in move.outgoing:
        place = resolve(arc.target)
        if isinstance(place, pn.Place):
            yield place


def _takers(place: pn.Place) -> Iterator[pn.Transition]:
    """Yield the transitions of the model that take from a place."""
    for each in stand_for(place):
        for arc in each.outgoing:
            is_of_model = arc.kind == pn.ArcKind.normal and not isinstance(arc.page, pnm.Sheet)
            if is_of_model and isinstance(arc.target, pn.Transition):
                yield arc.target


def _putters(place: pn.Place) -> Iterator[pn.Transition]:
    for each in stand_for(place):
        for arc in each.incoming:
            if isinstance(arc.source, pn.Transition):
                yield arc.source
