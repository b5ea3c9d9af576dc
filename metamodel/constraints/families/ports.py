"""Places of ports: in a node net, used by ports that go together; how ports map fields of ROS interfaces."""

from __future__ import annotations

import re

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.calls import PARTS_OF_GOALS
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index, PortUse
from dineros.metamodel.constraints.wording import listed
from dineros.metamodel.errors import DinerosError, near_matches

_PATH = re.compile(r"[A-Za-z]\w*(\[\d+\])?(\.[A-Za-z]\w*(\[\d+\])?)*", re.ASCII)


@constraint(
    "{it} has its place outside of all node nets", fix="move the place into the node net that the port is of"
)
def port_place_in_node_net(port: sym.TopicPort, index: Index) -> Outcome:
    """The place of a publisher or subscriber belongs to a node net."""
    return index.node_net_of(port.place) is not None


@constraint(
    "{it} both receives and sends by channels ({found})",
    fix="use two places with a transition between them",
    guard=lambda place, index: place in index.port_uses,
)
def place_receives_or_sends(place: pn.Place, index: Index) -> Outcome:
    """Channels put tokens on a place or take them from it, not both, but for a message that is a request."""
    uses = index.port_uses[place]
    # One port with both its ends here violates a constraint on services instead.
    mixed = [
        (receiver, sender)
        for receiver in uses
        for sender in uses
        if not receiver.sends and sender.sends and receiver.port is not sender.port
        if not (_subscribes(receiver) and _asks(sender))
    ]
    return not mixed or listed(use.port for use in mixed[0])


def _subscribes(use: PortUse) -> bool:
    return isinstance(use.port, (sym.SubscriberPort, rtm.SubscriberPort))


def _asks(use: PortUse) -> bool:
    asking = (sym.ClientPort, rtm.ClientPort, sym.ActionClientPort, rtm.ActionClientPort)
    return isinstance(use.port, asking) and use.sends


@constraint(
    "{it} is sent by {found}: each token goes to only one of them",
    fix="give each of them a place of its own",
    guard=lambda place, index: place in index.port_uses,
)
def place_sent_once(place: pn.Place, index: Index) -> Outcome:
    """Tokens of a place are sent by one port, or by clients of one service or action."""
    senders = [use for use in index.port_uses[place] if use.sends]
    return len(senders) < 2 or _are_clients_of_one_service(senders) or listed(use.port for use in senders)


def _are_clients_of_one_service(senders: list[PortUse]) -> bool:
    return all(map(_asks, senders)) and len({use.channel for use in senders}) == 1


@constraint(
    "{it} receives each message of the topic {found} twice",
    fix="remove one of the subscriber ports",
    guard=lambda place, index: place in index.port_uses,
)
def place_subscribed_once(place: pn.Place, index: Index) -> Outcome:
    """A place subscribes to a topic once."""
    topics = [name for kind, name in _received(index.port_uses[place]) if kind == "topic"]
    twice = next((name for name in topics if topics.count(name) > 1), None)
    return twice is None or repr(twice)


def _received(uses: list[PortUse]) -> list[tuple[str, str]]:
    return [use.channel for use in uses if not use.sends]


@constraint(
    "{it} receives messages but is on the server page {found}: the instance that a message is for is "
    "undefined",
    fix="put it on a callback page next to the server page and use a reference place there",
    guard=lambda place, index: place in index.port_uses and index.server_page_of(place) is not None,
)
def subscriber_outside_server_page(place: pn.Place, index: Index) -> Outcome:
    """A subscriber's place is not on a server page: messages are for the node, not for an instance."""
    page = index.server_page_of(place)
    assert page is not None
    return not any(map(_subscribes, index.port_uses[place])) or repr(page.id)


@constraint(
    "{it} maps to the token field {element.tokenField!r}, which the token type does not have",
    fix="use a field of the token type or add this one",
)
def mapped_field_known(mapping: sym.FieldMapping, index: Index) -> Outcome:
    """A mapping names a field of the token type that the places of its channel have."""
    fields, name = index.fields_of(_mapped_type(mapping, index)), mapping.tokenField
    return fields is None or name in fields or DinerosError(name, hint=near_matches(name, fields))


def _mapped_type(mapping: sym.FieldMapping, index: Index) -> sym.TokenType | None:
    """Return the type of the tokens that a mapping concerns."""
    holder = mapping.eContainer()
    place = index.place_of_part(holder, str(mapping.part)) if holder is not None else None
    return index.first_token_type if place is None else index.token_type_of(place)


@constraint(
    "{it} is for tokens that are the ROS message {found} themselves",
    fix="remove the mapping, or give the places a token type with fields of its own",
)
def mapped_type_is_own(mapping: sym.FieldMapping, index: Index) -> Outcome:
    """Only fields of token types that the model declares are mapped."""
    mapped = _mapped_type(mapping, index)
    return mapped is None or not mapped.ros or mapped.ros


@constraint(
    "{it} is for a {element.part}, which {found} does not have",
    fix="use message for a topic, request or response for a service, goal, result or feedback for an action",
)
def mapped_part_of_channel(mapping: sym.FieldMapping, index: Index) -> Outcome:
    """Topics have messages; services requests and responses; actions goals, results and feedback."""
    holder = mapping.eContainer()
    if isinstance(holder, (sym.TopicChannel, rtm.PublisherPort, rtm.SubscriberPort)):
        return mapping.part == sym.MessagePart.message or "a topic"
    if isinstance(holder, (sym.ActionChannel, rtm.ActionClientPort, rtm.ActionServerPort)):
        return str(mapping.part) in PARTS_OF_GOALS or "an action"
    return str(mapping.part) in ("request", "response") or "a service"


@constraint("{it} is not a path in a ROS interface", fix="write it like pose.position.x or ranges[0]")
def mapped_path_valid(mapping: sym.FieldMapping, index: Index) -> Outcome:
    """A mapping names a field of a ROS interface by a path."""
    return bool(_PATH.fullmatch(mapping.messageField))


def _mapped(mapping: sym.FieldMapping) -> tuple[EObject | None, str, str]:
    return (mapping.eContainer(), str(mapping.part), mapping.messageField)


@constraint("{it} is mapped twice", fix="remove one of the mappings")
def mapped_once(mapping: sym.FieldMapping, index: Index) -> Outcome:
    """A field of a ROS interface carries one token field."""
    return index.earliest(mapping, sym.FieldMapping, _mapped) is mapping


@constraint(
    "{it} has mappings but no type of ROS interface",
    fix="set its type, or remove the mappings",
    severity="warning",
    guard=lambda channel, index: len(channel.mappings) > 0,
)
def mappings_have_type(channel: sym.Channel, index: Index) -> Outcome:
    """Only a channel with an existing ROS interface needs mappings."""
    return bool(channel.type)
