"""Nodes that run callbacks: where callbacks begin and end, their groups, what they await."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import (
    Asking,
    begins_callback,
    callback_page_of,
    group_or_node,
    is_awaited,
    is_goal_awaited,
    place_of,
    runs_callbacks,
    works_on_goals,
)
from dineros.metamodel.calls import answers
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.errors import DinerosError

_BY_CALLBACKS = "set the execution of its node net to callbacks and the middleware of the model to ros2"
_OWN_EXECUTOR = "for an executor of its own: a callback group of its own and one more thread for the node net"


def _has_executors(index: Index) -> bool:
    """Return whether the rules of the model know executors."""
    return isinstance(index.net, sym.SystemModel) and index.net.middleware == sym.Middleware.ros2


def _runs(element: EObject | None, index: Index) -> bool:
    return element is not None and runs_callbacks(index.node_net_of(element))


def _body(page: sym.CallbackPage, index: Index) -> Body:
    return index.once(("body", page), lambda: Body(page, index.once("calls", lambda: _calls(index))))


def _calls(index: Index) -> list[tuple[pn.Place, pn.Place]]:
    calls = [(port.request, port.response) for port in index.all(sym.ClientPort)]
    senders = index.all(sym.ActionClientPort)
    return [*calls, *((port.goal, place) for port in senders for place in answers(port))]


def _is_complete(page: sym.CallbackPage, index: Index) -> bool:
    """Return whether all arcs and references of a page lead somewhere."""
    parts = [part for part in page.eAllContents() if isinstance(part, (pn.Node, pn.Arc))]
    if any(part in index.incomplete for part in parts):
        return False
    return all(index.final(part) is not None for part in parts if isinstance(part, pn.Node))


@constraint(
    "{it} runs callbacks, which the rules of ros1 do not know",
    fix="set the middleware of the model to ros2, or the execution of the node net to net",
    guard=lambda node_net, index: runs_callbacks(node_net),
)
def callbacks_under_ros2(node_net: sym.NodeNet, index: Index) -> Outcome:
    """Only the rules of ROS 2 know executors."""
    return not isinstance(index.net, sym.SystemModel) or _has_executors(index)


@constraint(
    "{it} has no transition from which it is clear that it begins its callback",
    fix="set the kind of the transition that begins it to start",
    guard=lambda page, index: page.kind == sym.CallbackKind.timer and _has_executors(index),
)
def timer_callback_begins(page: sym.CallbackPage, index: Index) -> Outcome:
    """A timer's callback begins with a transition of the kind start, or with one that nothing goes before."""
    if not _is_complete(page, index):
        return True
    body = _body(page, index)
    return not body.transitions or bool(body.beginnings())


@constraint(
    "{it} has no transition from which it is clear that it ends its callback",
    fix="set the kind of the transition that ends it to end",
    guard=lambda page, index: (
        _runs(page, index) and page.kind not in (sym.CallbackKind.server, sym.CallbackKind.goal)
    ),
)
def callback_ends(page: sym.CallbackPage, index: Index) -> Outcome:
    """A callback ends with a transition of the kind end, or with one that nothing comes after."""
    return not _is_complete(page, index) or bool(_body(page, index).ends())


@constraint(
    "{it} takes messages on {found}, and the node runs callbacks",
    fix=f"put its place on a callback page of the kind subscriber; {_OWN_EXECUTOR}",
    guard=lambda port, index: _runs(port.place, index),
)
def subscriber_begins_callback(port: sym.SubscriberPort, index: Index) -> Outcome:
    """If a node runs callbacks, messages begin one."""
    page = callback_page_of(port.place)
    if page is None:
        return "no callback page"
    return page.kind == sym.CallbackKind.subscriber or describe(page)


@constraint(
    "{it} serves on {found}, and the node runs callbacks",
    fix=f"use a callback page of the kind server; {_OWN_EXECUTOR}",
    guard=lambda port, index: _runs(port.page, index),
)
def server_begins_callback(port: sym.ServerPort, index: Index) -> Outcome:
    """If a node runs callbacks, requests begin one."""
    page = port.page
    if not isinstance(page, sym.CallbackPage):
        return describe(page)
    return page.kind == sym.CallbackKind.server or describe(page)


@constraint(
    "{it} holds {element.tokens} tokens at the start, which began no callback",
    fix="make it empty at the start",
    guard=lambda place, index: (
        place.tokens > 0
        and _runs(place, index)
        and index.callback_page_of(place) is not None
        and any(not use.sends for use in index.port_uses.get(place, ()))
    ),
)
def callbacks_begin_later(place: pn.Place, index: Index) -> Outcome:
    """If a node runs callbacks, nothing has come to its ports at the start."""
    return False


def _is_of_node_net(asking: Asking, index: Index) -> bool:
    return asking.group is not None and asking.group.eContainer() is index.node_net_of(place_of(asking))


group_of_node_net = constraint(
    "{it} is in {found} of another node net",
    fix="use a callback group of its own node net",
    guard=lambda asking, index: asking.group is not None,
)
"""Makes a constraint from a finding of `in_own_group` about a callback or a client."""

group_has_effect = constraint(
    "{it} is in {found}, which has no effect",
    fix=f"{_BY_CALLBACKS}, or do not rely on it",
    severity="warning",
    guard=_is_of_node_net,
)
"""Makes a constraint from a finding of `in_group_that_counts` about a callback or a client."""


def in_own_group(asking: Asking, index: Index) -> Outcome:
    """Return whether the group of a callback or a client is of its own node net."""
    return _is_of_node_net(asking, index) or _named(asking)


def in_group_that_counts(asking: Asking, index: Index) -> Outcome:
    """Return whether the node of a callback or a client runs callbacks, under the rules of ROS 2."""
    return (_runs(place_of(asking), index) and _has_executors(index)) or _named(asking)


def _named(asking: Asking) -> str:
    assert asking.group is not None
    return describe(asking.group)


@group_of_node_net
def client_group_of_node_net(port: sym.ClientPort, index: Index) -> Outcome:
    """The group of a client belongs to the node net of the client."""
    return in_own_group(port, index)


@group_has_effect
def callback_group_has_effect(page: sym.CallbackPage, index: Index) -> Outcome:
    """The callback group of a callback counts where its node runs callbacks, under the rules of ROS 2."""
    return in_group_that_counts(page, index)


@group_has_effect
def client_group_has_effect(port: sym.ClientPort, index: Index) -> Outcome:
    """The callback group of a client counts where its node runs callbacks, under the rules of ROS 2."""
    return in_group_that_counts(port, index)


@constraint(
    "responses to {it} begin {found}",
    fix="let the page name no group (rclpy), or page and client the same one (rclcpp)",
    severity="warning",
    guard=lambda port, index: _runs(port.response, index) and begins_callback(port),
)
def response_callback_group(port: sym.ClientPort, index: Index) -> Outcome:
    """A response starts its callback in no callback group, as in rclpy, or in its client's, as in rclcpp."""
    page = callback_page_of(port.response)
    if page is None or page.group is None or page.group is group_or_node(port):
        return True
    return f"{describe(page)} in {describe(page.group)}, in which its client is not"


@constraint(
    "{it} awaits responses, but {found}",
    fix="take it away",
    severity="warning",
    guard=lambda page, index: bool(page.awaits),
)
def awaits_has_effect(page: sym.CallbackPage, index: Index) -> Outcome:
    """A callback that awaits works on goals or calls a service on its page, and its node runs callbacks."""
    if not (_runs(page, index) and _has_executors(index)):
        return DinerosError("its node does not run callbacks", hint=f"{_BY_CALLBACKS}, or remove it")
    if page in _awaiting(index) or works_on_goals(page):
        return True
    return DinerosError(
        "it calls nothing on its page", hint="put request and response of a client there, or remove it"
    )


def _awaiting(index: Index) -> set[sym.CallbackPage | None]:
    def pages() -> set[sym.CallbackPage | None]:
        calls = {callback_page_of(port.request) for port in index.all(sym.ClientPort) if is_awaited(port)}
        sent = (port for port in index.all(sym.ActionClientPort) if is_goal_awaited(port))
        return calls | {callback_page_of(port.goal) for port in sent}

    return index.once("callback pages that await", pages)


@constraint(
    "{it} awaits one response at a time, but continues in several ways after {found}",
    fix="put one call after the other, or set awaits to false",
    guard=lambda page, index: bool(page.awaits) and _runs(page, index) and page in _awaiting(index),
)
def awaits_in_turn(page: sym.CallbackPage, index: Index) -> Outcome:
    """A callback that awaits makes one call after the other."""
    if not _is_complete(page, index):
        return True
    body = _body(page, index)
    return next((describe(each) for each in body.transitions if body.continues(each) > 1), True)
