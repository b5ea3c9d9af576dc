"""Which executors take callbacks in an order that the rules know: those with one thread and a wait result.

The executors of rclcpp and rclpy with one thread take what was ready at one moment, timers before messages,
and look again when nothing of that is left. The rules know it where nothing else decides whether a callback
that is ready can begin. Otherwise all orders are explored, which is safe.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import has_clients, readers_of, runs_callbacks, threads_of
from dineros.metamodel.elements import arcs, nodes, resolve, system_model_of
from dineros.metamodel.times.given import lifespan_between
from dineros.metamodel.times.runs import places_of_ports

_KINDS = (sym.CallbackKind.timer, sym.CallbackKind.subscriber)


def keeps_order(node: sym.NodeNet) -> bool:
    """Return whether the rules take the callbacks of a node in the order that it names.

    A node with one callback has nothing to choose: all orders are that one.
    """
    callbacks = [each for each in node.eAllContents() if isinstance(each, sym.CallbackPage)]
    return node.order != sym.CallbackOrder.any and len(callbacks) > 1 and not why_any(node)


def is_ignored(node: sym.NodeNet) -> bool:
    """Return whether a node names an order, and all orders are explored."""
    callbacks = [each for each in node.eAllContents() if isinstance(each, sym.CallbackPage)]
    return node.order != sym.CallbackOrder.any and len(callbacks) > 1 and bool(why_any(node))


def why_any(node: sym.NodeNet) -> str:
    """Return why all orders of callbacks are explored, in words; empty if the rules know the order."""
    if not runs_callbacks(node):
        return "it does not run callbacks"
    if threads_of(node) > 1:
        return "its executor has several threads"
    if node.lifecycle is not None:
        return "it is a managed node"
    model = system_model_of(node)
    if model is None:
        return "it belongs to no system model"
    away = {resolve(each) for each in nodes(model) if isinstance(each, pn.ReferencePlace)}
    for page in (each for each in node.eAllContents() if isinstance(each, sym.CallbackPage)):
        if page.kind not in _KINDS:
            return f"{page.id} is called neither by a timer nor by messages"
        if reason := _why_not_at_once(page, away, model):
            return reason
    if has_clients(node):
        return "it has clients of services or actions"
    return ""


def begins_in_every_state(page: sym.CallbackPage) -> bool:
    """Return whether the callback of a timer can begin whenever a thread and its group are free."""
    model = system_model_of(page)
    return model is not None and any(_is_always_enabled(each, model) for each in Body(page).beginnings())


def _why_not_at_once(page: sym.CallbackPage, away: Collection[pn.Node | None], model: sym.SystemModel) -> str:
    """Return why a callback that is ready may be unable to begin on a free thread; empty if it always can."""
    readers = readers_of(page)
    if page.kind == sym.CallbackKind.timer:
        if readers:
            return f"{page.id} is called by a timer and by messages"
        return "" if begins_in_every_state(page) else f"{page.id} can begin only in some states"
    if len(readers) != 1:
        return f"{page.id} is not called by one subscription"
    (reader,) = readers
    writers = () if reader.channel is None else reader.channel.publishers
    if any(lifespan_between(each, reader) is not None for each in writers):
        return f"a message for {page.id} may expire in a wait result"
    place = reader.place
    takes = [each for each in place.outgoing if each.kind == pn.ArcKind.normal]
    puts = [each for each in place.incoming if not isinstance(each.page, pnm.Sheet)]
    is_plain = (
        reader.inHand is None
        and not place.capacity
        and not place.tokens
        and takes
        and all(each.weight == 1 for each in place.outgoing)
        and not puts
        and place not in away
    )
    return "" if is_plain else f"what {page.id} holds of messages is not one at a time"


def _is_always_enabled(transition: pn.Transition, model: sym.SystemModel) -> bool:
    """Return whether a transition only needs places that are never empty while its thread is free."""
    if getattr(transition, "clause", None) is not None:
        return False
    needs: Counter[pn.Place | pn.Transition] = Counter()
    for each in transition.incoming:
        if each.kind == pn.ArcKind.inhibitor:
            return False
        needs[resolve(each.source)] += each.weight
    return all(_keeps(place, weight, model) for place, weight in needs.items())


def _keeps(place: pn.Place | pn.Transition, weight: int, model: sym.SystemModel) -> bool:
    """Return whether a place holds so many tokens at the start, and each transition puts back what it takes.

    A callback may work between the two, but no other callback of the thread begins meanwhile.
    """
    if not isinstance(place, pn.Place) or place.tokens < weight or place in places_of_ports(model):
        return False
    left: Counter[pn.Place | pn.Transition] = Counter()
    for each in arcs(model):
        if resolve(each.source) is place and each.kind == pn.ArcKind.normal:
            left[resolve(each.target)] -= each.weight
        elif resolve(each.target) is place:
            left[resolve(each.source)] += each.weight
    return all(change >= 0 for change in left.values())
