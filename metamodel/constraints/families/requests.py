"""How services of ROS 2 are asked: how many requests wait, how many a client sends, when it gives up."""

from __future__ import annotations

import math

from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import callback_page_of, runs_callbacks
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.families.services import IN_ONE_INSTANCE, in_one_instance, in_one_node_net
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe

_TIME_OUTS = "the place of its time-outs"


def _tells_of_time_outs(port: sym.ClientPort, index: Index) -> bool:
    return port.timedOut is not None


@constraint("{it} keeps {element.depth} requests", fix="give it a depth of 1 or more")
def request_depth_positive(channel: sym.ServiceChannel, index: Index) -> Outcome:
    """A service keeps 1 request or more."""
    return channel.depth >= 1


@constraint(
    "{it} has {element.outstanding} requests under way at most",
    fix="use 1 or more, or -1 for any number",
)
def outstanding_positive(port: sym.ClientPort, index: Index) -> Outcome:
    """A client has 1 request under way or more, or any number."""
    return port.outstanding is None or port.outstanding >= 1 or port.outstanding == UNLIMITED


@constraint("{it} has the time-out {element.timeout}", fix="use a time in seconds above 0, or none")
def timeout_positive(port: sym.ClientPort, index: Index) -> Outcome:
    """A client gives up after a positive, finite time."""
    return port.timeout is None or (port.timeout > 0 and math.isfinite(port.timeout))


@constraint(
    "{it} names the place {element.timedOut.id!r} for time-outs, but waits forever",
    fix="give it a time-out, or name no place",
    guard=_tells_of_time_outs,
)
def timed_out_has_timeout(port: sym.ClientPort, index: Index) -> Outcome:
    """A client that names a place for time-outs has one."""
    return port.timeout is not None


@constraint(
    "{it} has its request in {found}",
    fix="put both places into the node net of the client",
    guard=_tells_of_time_outs,
)
def timed_out_in_one_node_net(port: sym.ClientPort, index: Index) -> Outcome:
    """The place of a client's time-outs belongs to the node net of its requests."""
    assert port.timedOut is not None
    return in_one_node_net(port.request, port.timedOut, index, _TIME_OUTS)


@constraint("{it} has its request {found}", fix=IN_ONE_INSTANCE, guard=_tells_of_time_outs)
def timed_out_in_one_instance(port: sym.ClientPort, index: Index) -> Outcome:
    """The server instance that asked gets the token of a time-out."""
    assert port.timedOut is not None
    return in_one_instance(port.request, port.timedOut, index, _TIME_OUTS)


@constraint(
    "{it} has {found}, which the rules of ros1 do not have",
    fix="set the model's middleware to ros2, or remove it",
    severity="warning",
    guard=lambda port, index: (
        isinstance(index.net, sym.SystemModel) and index.net.middleware == sym.Middleware.ros1
    ),
)
def calls_of_ros2(port: sym.ClientPort, index: Index) -> Outcome:
    """Only clients of ROS 2 have several requests under way, give up, or wait for their service."""
    asked = port.outstanding or 1
    found = [f"{'any number of' if asked == UNLIMITED else asked} requests under way"] if asked != 1 else []
    if port.timeout is not None:
        found.append(f"a time-out of {port.timeout:g} s")
    if port.waitsForService:
        found.append("a wait for its service")
    return not found or " and ".join(found)


@constraint(
    "{it} gives up without a token, and its callback {found} never continues",
    fix="name a place for time-outs on that callback page",
    severity="warning",
    guard=lambda port, index: port.timeout is not None and _waiting_callback(port, index) is not None,
)
def waiting_callback_is_told(port: sym.ClientPort, index: Index) -> Outcome:
    """If a node runs callbacks, a callback that waits for a response gets the token of a time-out."""
    page = _waiting_callback(port, index)
    return port.timedOut is not None or page is None or repr(page.id)


def _waiting_callback(port: sym.ClientPort, index: Index) -> sym.CallbackPage | None:
    """Return the callback page that waits for a client's response."""
    page = callback_page_of(port.request)
    waits = page is callback_page_of(port.response) and runs_callbacks(index.node_net_of(port.request))
    return page if waits else None


@constraint(
    "{it} names the place {element.timedOut.id!r} for time-outs on {found}, which a time-out does not start",
    fix="put the place on the callback page that asks, or on none",
    guard=lambda port, index: port.timedOut is not None and runs_callbacks(index.node_net_of(port.timedOut)),
)
def timed_out_begins_no_callback(port: sym.ClientPort, index: Index) -> Outcome:
    """If a node runs callbacks, only the callback that asks gets the token of a time-out."""
    page = callback_page_of(port.timedOut)
    return page is None or page is callback_page_of(port.request) or describe(page)
