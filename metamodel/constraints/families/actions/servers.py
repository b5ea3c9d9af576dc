"""Servers of actions: their slots, the page that works on goals, and its places."""

from __future__ import annotations

from collections import Counter

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.calls import SERVER_PLACES, exits
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe, listed
from dineros.metamodel.elements import is_within


def _places(port: sym.ActionServerPort | rtm.ActionServerPort) -> list[pn.Place]:
    """Return the places of a server, its entry first."""
    entry = port.entry if isinstance(port, sym.ActionServerPort) else port.eContainer()
    others = (getattr(port, role) for role in SERVER_PLACES)
    return [place for place in (entry, *others) if isinstance(place, pn.Place)]


def _outside(port: sym.ActionServerPort | rtm.ActionServerPort) -> list[pn.Place]:
    return [place for place in _places(port) if not is_within(place, port.page)]


@constraint("{it} has no client", fix="add a client port", severity="warning")
def action_has_client(channel: sym.ActionChannel, index: Index) -> Outcome:
    """An action has a client."""
    return len(channel.clients) > 0


@constraint(
    "{it} works on {element.instances} goals at once",
    fix="let it work on 1 goal or more, or leave the number out to have a slot for each client",
    guard=lambda channel, index: channel.instances is not None,
)
def action_slots(channel: sym.ActionChannel, index: Index) -> Outcome:
    """An action has 1 slot for goals or more."""
    return channel.instances is not None and channel.instances >= 1


@constraint("{it} keeps {element.depth} feedback messages", fix="let it keep 1 or more")
def feedback_depth_positive(channel: sym.ActionChannel, index: Index) -> Outcome:
    """The feedback of an action has a depth of 1 or more."""
    return channel.depth >= 1


@constraint(
    "{it} has {found} outside of the page {element.page.id!r} that works on goals",
    fix="move the place to that page",
)
def goal_places_on_page(port: sym.ActionServerPort, index: Index) -> Outcome:
    """All places of an action's server are on the page that works on goals."""
    outside = _outside(port)
    return not outside or listed(outside)


@constraint("{it} uses {found} twice", fix="use a place for each purpose")
def goal_places_differ(port: sym.ActionServerPort, index: Index) -> Outcome:
    """Entry, exits, and the places of cancels and feedback of an action's server are different ones."""
    place, number = Counter(_places(port)).most_common(1)[0]
    return number == 1 or describe(place)


@constraint(
    "{it} has no place where a goal ends",
    fix="name a place for results of goals that succeed, or are aborted",
)
def goals_end(port: sym.ActionServerPort, index: Index) -> Outcome:
    """A goal can succeed, be aborted or be canceled."""
    return bool(exits(port))


@constraint(
    "{it} has a place for results of goals that are canceled, but none for requests to cancel",
    fix="name a place that gets a token when the goal is to be canceled",
    severity="warning",
)
def canceled_is_asked_for(port: sym.ActionServerPort, index: Index) -> Outcome:
    """Only a goal whose server takes requests to cancel is ever canceled."""
    return port.canceled is None or port.cancel is not None


@constraint("{it} has {found}", fix="put what works on goals on a page of its own inside a node net")
def goal_page_of_its_own(port: sym.ActionServerPort, index: Index) -> Outcome:
    """What works on goals is a page inside a node net, which serves nothing else, on no server page."""
    if isinstance(port.page, sym.NodeNet):
        return f"a server page that is all of {describe(port.page)}"
    if index.node_net_of(port.page) is None:
        return "a server page outside of all node nets"
    first = index.server_pages[port.page][0]
    if first is not port:
        return f"the server page of {describe(first)}"
    outer = index.server_page_of(port.page.page) if port.page.page is not None else None
    return outer is None or f"a server page inside {describe(outer)}, which is one too"


@constraint(
    "{it} has tokens at the start in {found}, where no goal is worked on yet",
    fix="make the places empty at the start",
)
def goal_places_empty(port: sym.ActionServerPort, index: Index) -> Outcome:
    """The places of an action's server are empty at the start."""
    marked = [place for place in _places(port) if place.tokens > 0]
    return not marked or listed(marked)


@constraint(
    "{it} is asked to cancel by {found} of its own page",
    fix="take the arc away: only requests of clients put tokens on that place",
    guard=lambda port, index: port.cancel is not None,
)
def cancels_come_from_clients(port: sym.ActionServerPort, index: Index) -> Outcome:
    """Nothing but requests of clients puts tokens on the place of requests to cancel."""
    arcs = (arc for arc in index.all(pn.Arc) if index.final(arc.target) is port.cancel)
    putting = next((arc.source for arc in arcs), None)
    return putting is None or describe(putting)


@constraint(
    "{it} works on goals on {found}, and the node runs callbacks",
    fix="use a callback page of the kind goal",
    guard=lambda port, index: runs_callbacks(index.node_net_of(port.page)),
)
def goals_begin_callback(port: sym.ActionServerPort, index: Index) -> Outcome:
    """If a node runs callbacks, goals that are accepted begin one."""
    page = port.page
    if not isinstance(page, sym.CallbackPage):
        return describe(page)
    return page.kind == sym.CallbackKind.goal or describe(page)


@constraint("{it} has {found}", fix="use places on the page that works on goals and 1 slot or more")
def runtime_action_server(port: rtm.ActionServerPort, index: Index) -> Outcome:
    """An action's server of a run-time model has its places on its page, and 1 slot or more."""
    if port.instances < 1:
        return f"{port.instances} slots"
    outside = _outside(port)
    return not outside or f"{listed(outside)} outside of its page {port.page.id!r}"
