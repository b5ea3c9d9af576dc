"""Node nets and callback pages: one ROS node each, closed but for channels (paper, Sect. 5.1)."""

from __future__ import annotations

import math
from collections.abc import Iterator

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.families.callbacks import group_of_node_net, in_own_group
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe, listed


def _is_outside(node: pn.Node, index: Index) -> bool:
    return index.is_distributed and index.node_net_of(node) is None


@constraint("{it} is inside {found}", fix="put it next to the other node net; node nets do not nest")
def node_net_not_nested(node_net: sym.NodeNet, index: Index) -> Outcome:
    """A node net is not inside another node net."""
    outer = index.node_net_of(node_net.page) if node_net.page is not None else None
    return outer is None or describe(outer)


@constraint(
    "{it} is outside of all node nets",
    fix="move it into the node net of the ROS node that it is part of",
    guard=lambda node, index: (
        _is_outside(node, index) and len(index.reached_from.get(node, ())) < 2 and node not in index.port_uses
    ),
)
def node_in_node_net(node: pn.Node, index: Index) -> Outcome:
    """Every place, transition and reference of a system model or run-time model belongs to a node net."""
    return False


@constraint(
    "{it} joins {found} outside of them",
    fix="put it into one of them and join them by a topic or a service",
    guard=_is_outside,
)
def node_not_shared(node: pn.Node, index: Index) -> Outcome:
    """Node nets do not share places or transitions of a page outside of them."""
    node_nets = index.reached_from.get(node, [])
    return len(node_nets) < 2 or listed(node_nets)


@constraint(
    "{it} refers to {found} of another node net",
    fix="join the node nets by a topic or a service",
    guard=lambda node, index: isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition)),
)
def reference_within_node_net(node: pn.Node, index: Index) -> Outcome:
    """A reference refers to a node of its own node net."""
    assert isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition))
    own, other = index.node_net_of(node), index.node_net_of(node.target)
    return own is None or other is None or own is other or describe(node.target)


@constraint(
    "{it} overrides {found} of another node net",
    fix="remove the priority; ROS nodes do not wait for each other's transitions",
)
def overrides_within_node_net(transition: pn.Transition, index: Index) -> Outcome:
    """A transition has priority only over transitions of its own node net."""
    own = index.node_net_of(transition)
    foreign = [lower for lower in transition.overrides if index.node_net_of(lower) is not own]
    return not foreign or listed(foreign)


@constraint("{it} has {element.threads} threads", fix="give it 1 thread or more")
def threads_positive(node_net: sym.NodeNet, index: Index) -> Outcome:
    """A node net has 1 thread or more."""
    return node_net.threads >= 1


@constraint(
    "{it} has {element.threads} threads but a single-threaded executor",
    fix="set the executor to multi or the threads to 1",
    severity="warning",
)
def threads_need_multi(node_net: sym.NodeNet, index: Index) -> Outcome:
    """Several threads go with a multi-threaded executor."""
    return node_net.threads <= 1 or node_net.executor == sym.Executor.multi


@constraint(
    "{it} is outside of all node nets",
    fix="move it into the node net of the ROS node that calls it",
    guard=lambda page, index: index.is_distributed,
)
def callback_page_in_node_net(page: sym.CallbackPage, index: Index) -> Outcome:
    """A callback page belongs to a node net."""
    return index.node_net_of(page) is not None


@constraint("{it} is inside {found}", fix="put it next to that", severity="warning")
def callback_page_not_nested(page: sym.CallbackPage, index: Index) -> Outcome:
    """A callback page is not inside another callback page."""
    outer = index.callback_page_of(page.page) if page.page is not None else None
    return outer is None or describe(outer)


@group_of_node_net
def callback_group_of_node_net(page: sym.CallbackPage, index: Index) -> Outcome:
    """The group of a callback page belongs to the node net of the page."""
    return in_own_group(page, index)


@constraint(
    "{it} is called by a timer with {found}",
    fix="set timer to a period above 0",
    guard=lambda page, index: page.kind == sym.CallbackKind.timer,
)
def timer_positive(page: sym.CallbackPage, index: Index) -> Outcome:
    """A timer callback has a positive, finite period."""
    if page.timer is None:
        return "no period"
    return (math.isfinite(page.timer) and page.timer > 0) or f"the period {page.timer}"


@constraint(
    "{it} is called by a timer but is on the server page {found}: all instances have one timer in common",
    fix="put it next to the server page",
    guard=lambda page, index: page.kind == sym.CallbackKind.timer,
)
def timer_outside_server_page(page: sym.CallbackPage, index: Index) -> Outcome:
    """A timer callback is not on a server page."""
    outer = index.server_page_of(page)
    return outer is None or repr(outer.id)


@constraint(
    "{it} has a timer but is called by a {element.kind}",
    fix="remove the timer or set the kind to timer",
    severity="warning",
    guard=lambda page, index: page.timer is not None,
)
def timer_used(page: sym.CallbackPage, index: Index) -> Outcome:
    """Only timer callbacks have a period."""
    return page.kind == sym.CallbackKind.timer


@constraint(
    "{it} is a {element.kind} callback, but {found}",
    fix="set its kind to what calls it, or add the port",
    severity="warning",
    guard=lambda page, index: not (page in index.server_pages and runs_callbacks(index.node_net_of(page))),
)
def callback_page_called(page: sym.CallbackPage, index: Index) -> Outcome:
    """A subscriber's page holds its place, a server's is a server page, a client's gets what it asked for."""
    if page in index.server_pages:
        port = index.server_pages[page][0]
        if isinstance(port, (sym.ActionServerPort, rtm.ActionServerPort)):
            return page.kind == sym.CallbackKind.goal or "it is the server page of an action"
        return page.kind == sym.CallbackKind.server or "it is the server page of a service"
    if page.kind == sym.CallbackKind.server:
        return "it is not the server page of a service"
    if page.kind == sym.CallbackKind.goal:
        return "it is not the server page of an action"
    if page.kind == sym.CallbackKind.client:
        return page in _called(index) or "it does not receive the response to a request from another page"
    return (
        page.kind != sym.CallbackKind.subscriber
        or page in _called(index)
        or "no subscriber has a place on it"
    )


def _called(index: Index) -> set[sym.CallbackPage | None]:
    """Return the pages that subscribers have a place on, or that responses begin the callback of."""
    return index.once("callback pages that are called", lambda: set(_called_pages(index)))


def _asked(port: EObject) -> EObject | None:
    """Return the place from which a client asks."""
    if isinstance(port, sym.ClientPort):
        return port.request
    return port.goal if isinstance(port, sym.ActionClientPort) else port.eContainer()


def _called_pages(index: Index) -> Iterator[sym.CallbackPage | None]:
    for place, uses in index.port_uses.items():
        page = index.callback_page_of(place)
        for use in uses:
            if isinstance(use.port, (sym.SubscriberPort, rtm.SubscriberPort)):
                yield page
            elif not use.sends and page is not None and page.kind == sym.CallbackKind.client:
                asked = _asked(use.port)
                if asked is not None and index.callback_page_of(asked) is not page:
                    yield page


@constraint(
    "{it} is timed but has no interval",
    fix="set its interval, or its kind to discrete",
    severity="warning",
    guard=lambda transition, index: transition.kind == sym.TransitionKind.timed,
)
def timed_transition_has_interval(transition: sym.Transition, index: Index) -> Outcome:
    """A timed transition has a firing interval."""
    return transition.interval is not None


@constraint(
    "{it} has a lifecycle, which the rules of {element.net.middleware} do not know",
    fix="set the middleware of the model to ros2, or remove it",
    severity="warning",
    guard=lambda node_net, index: (
        node_net.lifecycle is not None and isinstance(node_net.net, sym.SystemModel)
    ),
)
def lifecycle_has_effect(node_net: sym.NodeNet, index: Index) -> Outcome:
    """A node net has a lifecycle under the rules of ROS 2."""
    return not isinstance(node_net.net, sym.SystemModel) or node_net.net.middleware == sym.Middleware.ros2


@constraint("{it} has the {found}", fix="use a step of 1 or more, or 0 for any time")
def start_steps_positive(lifecycle: sym.Lifecycle, index: Index) -> Outcome:
    """Steps of the start order are counted from 1; 0 is at any time."""
    steps = {"configure": lifecycle.configureStep, "activate": lifecycle.activateStep}
    return next((f"{name} step {step}" for name, step in steps.items() if step < 0), True)


@constraint(
    "{it} is configured in step {element.configureStep}, and activated in step {element.activateStep}",
    fix="set a later step for its activation",
    guard=lambda lifecycle, index: lifecycle.configureStep > 0 and lifecycle.activateStep > 0,
)
def configured_before_active(lifecycle: sym.Lifecycle, index: Index) -> Outcome:
    """The start order configures a node before it activates it."""
    return lifecycle.configureStep < lifecycle.activateStep
