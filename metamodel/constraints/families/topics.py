"""Topic channels: publishers, subscribers, dispatchers and their limits (paper, Sect. 5.3.1)."""

from __future__ import annotations

from dineros.metamodel import rtm, sym
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe

_LIMIT = "give it a limit of 1 or more"


def _receiver(dispatcher: sym.Dispatcher) -> tuple[sym.TopicChannel | None, sym.NodeNet]:
    return (dispatcher.channel, dispatcher.node)


@constraint("{it} has no publisher", fix="add a publisher port", severity="warning")
def topic_has_publisher(channel: sym.TopicChannel, index: Index) -> Outcome:
    """Something is published on a topic."""
    return len(channel.publishers) > 0


@constraint("{it} has no subscriber", fix="add a subscriber port", severity="warning")
def topic_has_subscriber(channel: sym.TopicChannel, index: Index) -> Outcome:
    """A topic has a subscription."""
    return len(channel.subscribers) > 0


@constraint(
    "messages of {it} are lost when a node continues after a restart: {found}",
    fix="drop its quality of service: by default nothing is lost, and the limits are the depth",
    severity="warning",
    guard=lambda channel, index: (
        channel.qos is not None and (channel.type is None or len(channel.publishers) > 0)
    ),
)
def topic_survives_restarts(channel: sym.TopicChannel, index: Index) -> Outcome:
    """A topic keeps its last messages for subscribers that come back, and sends again what was lost."""
    assert channel.qos is not None
    if channel.type is None and channel.qos.durability == sym.Durability.volatile:
        return "it is volatile, so that nothing is kept for a subscriber that is down"
    return channel.qos.reliability == sym.Reliability.reliable or "it is bestEffort"


@constraint("{it} has the limit {element.limit}", fix=_LIMIT)
def port_limit(port: sym.TopicPort, index: Index) -> Outcome:
    """The limit of a publisher or subscriber is 1 or more."""
    return port.limit >= 1


@constraint("{it} has the limit {element.limit}", fix=_LIMIT)
def dispatcher_limit(dispatcher: sym.Dispatcher, index: Index) -> Outcome:
    """The limit of a dispatcher is 1 or more."""
    return dispatcher.limit >= 1


@constraint("{it} is for a node net that does not subscribe", fix="remove it or add a subscriber port")
def dispatcher_subscribes(dispatcher: sym.Dispatcher, index: Index) -> Outcome:
    """A dispatcher is for a node net that subscribes to its topic."""
    channel = dispatcher.channel
    return channel is None or dispatcher.node in index.once(
        ("subscribing node nets", channel),
        lambda: {
            index.node_net_of(port.place) for port in channel.subscribers if port not in index.incomplete
        },
    )


@constraint("{it} is for {found}, as another one is", fix="keep one of them")
def dispatcher_once(dispatcher: sym.Dispatcher, index: Index) -> Outcome:
    """A node net has at most one dispatcher for a topic."""
    first = index.earliest(dispatcher, sym.Dispatcher, _receiver)
    return first is dispatcher or describe(dispatcher.node)


@constraint(
    "{it} has its place {found}",
    fix="put the place on a callback page of the kind subscriber",
    severity="warning",
    guard=lambda port, index: (
        index.node_net_of(port.place) is not None
        and index.server_page_of(port.place) is None
        and not runs_callbacks(index.node_net_of(port.place))
    ),
)
def subscriber_on_callback_page(port: sym.SubscriberPort, index: Index) -> Outcome:
    """The place of a subscriber is on a subscriber callback page."""
    page = index.callback_page_of(port.place)
    if page is None:
        return "on no callback page"
    return page.kind == sym.CallbackKind.subscriber or f"on a {page.kind} callback page"


@constraint("{it} has the limit {element.limit}", fix=_LIMIT)
def runtime_publisher_limit(port: rtm.PublisherPort, index: Index) -> Outcome:
    """The limit of a publisher of a run-time model is 1 or more."""
    return port.limit >= 1


@constraint(
    "{it} has the limit {element.limit} and the dispatcher limit {element.dispatcherLimit}",
    fix="give it limits of 1 or more",
)
def runtime_subscriber_limits(port: rtm.SubscriberPort, index: Index) -> Outcome:
    """The limits of a subscriber of a run-time model are 1 or more."""
    return port.limit >= 1 and port.dispatcherLimit >= 1
