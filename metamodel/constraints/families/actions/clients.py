"""Clients of actions: their places, what they fetch, and their callback groups."""

from __future__ import annotations

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.calls import CLIENT_PLACES, OUTCOMES, answers
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.families.callbacks import (
    group_has_effect,
    group_of_node_net,
    in_group_that_counts,
    in_own_group,
)
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe


def _client_id(port: sym.ActionClientPort) -> tuple[sym.ActionChannel | None, str]:
    return (port.channel, port.client)


@constraint("{it} has its goals in {found}", fix="put all its places into one node net")
def goal_client_in_one_node_net(port: sym.ActionClientPort, index: Index) -> Outcome:
    """All places of an action's client belong to the same node net."""
    own = index.node_net_of(port.goal)
    if own is None:
        return "no node net"
    for role in CLIENT_PLACES:
        place: pn.Place | None = getattr(port, role)
        if place is not None and index.node_net_of(place) is not own:
            return f"{describe(own)}, and {describe(place)} elsewhere"
    return True


@constraint("{it} has {found} for several purposes", fix="use a place for each purpose")
def goal_client_places_differ(port: sym.ActionClientPort, index: Index) -> Outcome:
    """An action's client has different places for goals, feedback and results."""
    return _used_twice(port, port.goal)


@constraint("{it} has {found} for several purposes", fix="use a place for each purpose")
def runtime_goal_client_places_differ(port: rtm.ActionClientPort, index: Index) -> Outcome:
    """In a run-time model, too, an action's client has a place for each purpose."""
    own = port.eContainer()
    return _used_twice(port, own if isinstance(own, pn.Place) else None)


def _used_twice(port: sym.ActionClientPort | rtm.ActionClientPort, goal: pn.Place | None) -> Outcome:
    """Answers may share a place: what counts is that the goal is over."""
    own: list[pn.Place] = []
    for place in (goal, port.accepted, port.cancel, port.feedback):
        if place is None:
            continue
        if place in own or place in answers(port):
            return describe(place)
        own.append(place)
    return True


@constraint("{it} has the id of another client of the action", fix="give it another client id")
def goal_client_unique(port: sym.ActionClientPort, index: Index) -> Outcome:
    """The clients of an action have different ids."""
    return index.earliest(port, sym.ActionClientPort, _client_id) is port


@constraint(
    "{it} has a place on {found}, of which there is one for each call or goal",
    fix="put its places next to that page, and let the page reach them by references",
)
def goal_client_outside_server_pages(port: sym.ActionClientPort, index: Index) -> Outcome:
    """No client of an action is on the page of a server."""
    places = (port.goal, *(getattr(port, role) for role in CLIENT_PLACES))
    pages = (index.server_page_of(place) for place in places if place is not None)
    return next((describe(page) for page in pages if page is not None), True)


@constraint("{it} has {element.outstanding} goals under way at most", fix="set it to 1 goal or more")
def outstanding_goals_positive(port: sym.ActionClientPort, index: Index) -> Outcome:
    """A client of an action may have 1 goal under way or more."""
    return port.outstanding is None or port.outstanding >= 1


@constraint(
    "{it} does not fetch results of goals that are {found}",
    fix="name a place for them; it may be the same one for all ends of a goal",
    severity="warning",
    guard=lambda port, index: port.channel is not None and port.channel.server is not None,
)
def results_are_fetched(port: sym.ActionClientPort, index: Index) -> Outcome:
    """A client learns of each way in which its goals may end."""
    assert port.channel is not None
    server = port.channel.server
    lost = [end for end in OUTCOMES if getattr(server, end) is not None and getattr(port, end) is None]
    return not lost or " or ".join(lost)


@constraint(
    "{it} asks to cancel goals, which {found} refuses",
    fix="name a place of the server that gets a token when the goal is to be canceled",
    severity="warning",
    guard=lambda port, index: (
        port.cancel is not None and port.channel is not None and port.channel.server is not None
    ),
)
def cancels_are_taken(port: sym.ActionClientPort, index: Index) -> Outcome:
    """A client asks to cancel goals only where the server takes such requests."""
    assert port.channel is not None
    return port.channel.server.cancel is not None or describe(port.channel.server)


@group_of_node_net
def goal_client_group_of_node_net(port: sym.ActionClientPort, index: Index) -> Outcome:
    """The group of an action's client belongs to the node net of the client."""
    return in_own_group(port, index)


@group_has_effect
def goal_client_group_has_effect(port: sym.ActionClientPort, index: Index) -> Outcome:
    """The callback group of an action's client counts where its node runs callbacks, under ROS 2."""
    return in_group_that_counts(port, index)
