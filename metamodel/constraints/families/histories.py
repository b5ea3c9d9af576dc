"""Capacities of places, messages in hand, whether publishers and subscribers match."""

from __future__ import annotations

import math

from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.groups import callback_page_of, runs_callbacks
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.families.services import in_one_node_net
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.matching import mismatch, quality_of

_UNLIMITED = -1


def _is_bounded(place: pn.Place, index: Index) -> bool:
    return place.capacity is not None


def _has_in_hand(port: sym.SubscriberPort, index: Index) -> bool:
    return port.inHand is not None


@constraint(
    "{it} has the capacity {element.capacity}",
    fix="give it a capacity of 1 or more, or none",
    guard=_is_bounded,
)
def capacity_positive(place: pn.Place, index: Index) -> Outcome:
    """A capacity is 1 or more."""
    return place.capacity is None or place.capacity >= 1


@constraint(
    "{it} holds {element.tokens} tokens at the start, and its capacity is {element.capacity}",
    fix="give it fewer tokens or more capacity",
    guard=lambda place, index: place.capacity is not None and place.capacity >= 1,
)
def capacity_holds_tokens(place: pn.Place, index: Index) -> Outcome:
    """The tokens that a place has at the start fit into its capacity."""
    return place.capacity is None or place.tokens <= place.capacity


@constraint(
    "{it} has {element.inHand} messages in hand",
    fix="use 1 or more, or -1 for any number",
    guard=_has_in_hand,
)
def in_hand_positive(port: sym.SubscriberPort, index: Index) -> Outcome:
    """A node takes 1 message or more at a time, or any number."""
    return port.inHand is None or port.inHand >= 1 or port.inHand == _UNLIMITED


@constraint(
    "{it} gives the number of messages in hand, and its place {element.place.id!r} has a capacity",
    fix="give only one of the two",
    guard=_has_in_hand,
)
def in_hand_or_capacity(port: sym.SubscriberPort, index: Index) -> Outcome:
    """The number of messages that a node holds is given once: by the port or by its place's capacity."""
    return port.place.capacity is None


@constraint(
    "{it} has {element.inHand} messages in hand, and its place holds {element.place.tokens} at the start",
    fix="give the place fewer tokens, or the port more in hand",
    guard=lambda port, index: port.inHand is not None and port.inHand >= 1,
)
def in_hand_holds_tokens(port: sym.SubscriberPort, index: Index) -> Outcome:
    """The messages that a node has in hand at the start are as many as it may have."""
    return port.inHand is None or port.place.tokens <= port.inHand


@constraint("{it} has the {found}", fix="use a time in seconds above 0, or none")
def quality_times_positive(quality: sym.QualityOfService, index: Index) -> Outcome:
    """Times of a quality of service are above 0; one that is absent is without bound."""
    for name, words in (
        ("deadline", "deadline"),
        ("lifespan", "lifespan"),
        ("leaseDuration", "lease duration"),
    ):
        seconds = getattr(quality, name)
        if seconds is not None and not (seconds > 0 and math.isfinite(seconds)):
            return f"{words} {seconds}"
    return True


def _has_missed(port: sym.SubscriberPort, index: Index) -> bool:
    return port.missed is not None


@constraint(
    "{it} names the place {element.missed.id!r} for missed deadlines, and has no deadline",
    fix="give its quality of service a deadline, or name no place",
    guard=_has_missed,
)
def missed_has_deadline(port: sym.SubscriberPort, index: Index) -> Outcome:
    """A subscriber that names a place for missed deadlines has a deadline."""
    return quality_of(port).deadline is not None


@constraint(
    "{it} has its messages in {found}",
    fix="put both places into one node net",
    guard=_has_missed,
)
def missed_in_one_node_net(port: sym.SubscriberPort, index: Index) -> Outcome:
    """The place of missed deadlines belongs to the node net that takes the messages."""
    assert port.missed is not None
    return in_one_node_net(port.place, port.missed, index, "the place of its missed deadlines")


@constraint(
    "{it} has its place for missed deadlines on {found}, which a missed deadline does not begin",
    fix="put the place on the callback page that takes the messages, or on none",
    guard=lambda port, index: port.missed is not None and runs_callbacks(index.node_net_of(port.missed)),
)
def missed_begins_no_callback(port: sym.SubscriberPort, index: Index) -> Outcome:
    """If a node runs callbacks, a missed deadline does not begin a callback."""
    page = callback_page_of(port.missed)
    return page is None or page is callback_page_of(port.place) or describe(page)


@constraint(
    "{it} names a place for missed deadlines, which the rules of ros1 do not have",
    fix="set the model's middleware to ros2, or name no place",
    severity="warning",
    guard=lambda port, index: (
        port.missed is not None
        and isinstance(index.net, sym.SystemModel)
        and index.net.middleware == sym.Middleware.ros1
    ),
)
def deadlines_of_ros2(port: sym.SubscriberPort, index: Index) -> Outcome:
    """Only subscribers of ROS 2 have deadlines."""
    return False


@constraint(
    "{it} receives no message of {found}",
    fix="set the publisher to offer what the subscriber requests",
    severity="warning",
)
def ports_match(port: sym.SubscriberPort, index: Index) -> Outcome:
    """A subscriber requests no more quality of service than each publisher offers."""
    publishers = port.channel.publishers if port.channel is not None else ()
    for publisher in publishers:
        if publisher not in index.incomplete and (found := mismatch(publisher, port)) is not None:
            return DinerosError(f"{describe(publisher)}: {found.reason}", hint=found.fix)
    return True
