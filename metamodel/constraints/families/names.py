"""Ids and names: present, unique where they must be, and valid for ROS 2."""

from __future__ import annotations

import re
from collections.abc import Iterator

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.clauses import value_names
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe, kind_of
from dineros.metamodel.elements import label
from dineros.metamodel.errors import with_article
from dineros.metamodel.ros_names import (
    full_name,
    hidden_part,
    reserved_services,
    reserved_topics,
    resource_name,
)

_BLANK = re.compile(r"\s")
# What quotes, comments, tags, variables and tables are made of in XML, Python, C, CMake, shells and Markdown.
_NOT_IN_IDS = frozenset("\"'`\\<>&{}|$;")
_NODE_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_PACKAGE = re.compile(r"[a-z][a-z0-9_]*[a-z0-9]")
_NAMESPACE = re.compile(r"/|(/[A-Za-z_][A-Za-z0-9_]*)+")
_TOKEN = r"(?:[A-Za-z_]|\{[A-Za-z_][A-Za-z0-9_]*\})(?:[A-Za-z0-9_]|\{[A-Za-z_][A-Za-z0-9_]*\})*"
_TOPIC = re.compile(rf"(?:/|~/)?{_TOKEN}(?:/{_TOKEN})*|~")
_INTERFACE = r"[a-z][a-z0-9_]*/{}/[A-Z][A-Za-z0-9]*"
_MESSAGE, _SERVICE = re.compile(_INTERFACE.format("msg")), re.compile(_INTERFACE.format("srv"))
_ACTION = re.compile(_INTERFACE.format("action"))
_RULES = "use letters, digits, _ and /, with no part that starts with a digit, as ROS 2 requires"


_KINDS = ("topic", "service", "action")


def _id(element: pn.Element) -> str:
    return element.id


def _ros_name(node_net: sym.NodeNet) -> tuple[str, str]:
    return (node_net.namespace or "/", label(node_net))


def _ros_name_of(named: sym.Channel | rtm.PlacePort) -> str | None:
    """Return the name of the topic, service or action of a channel or port."""
    return next((getattr(named, kind) for kind in _KINDS if hasattr(named, kind)), None)


def _absolute_name(channel: sym.Channel) -> str:
    return "/" + (_ros_name_of(channel) or "").removeprefix("/")


@constraint("{found} has no id", fix="give it an id of its own")
def id_present(element: pn.Element, index: Index) -> Outcome:
    """Every element has an id."""
    return bool(element.id) or _kind_and_place(element)


def _kind_and_place(element: pn.Element) -> str:
    holder, kind = element.eContainer(), kind_of(element)
    named = f" named {element.name!r}" if element.name else ""
    return f"{with_article(kind)}{named}" + (f" in {describe(holder)}" if holder else "")


@constraint(
    "{it} has white space in its id",
    fix="write the id without blanks, and put the readable text into the name",
)
def id_without_blanks(element: pn.Element, index: Index) -> Outcome:
    """An id has no white space."""
    return not (element.id and _BLANK.search(element.id))


@constraint(
    "{it} has {found} in its id",
    fix="write the id with letters, digits and characters such as _ - . @, and put the readable text into "
    "the name",
    guard=lambda element, index: index.is_distributed and bool(element.id),
)
def id_characters(element: pn.Element, index: Index) -> Outcome:
    """An id in a system model has characters that every generated format carries: no quotes, no braces."""
    for character in element.id:
        if character in _NOT_IN_IDS or not (character.isprintable() or character.isspace()):
            return repr(character)
    return True


@constraint(
    "{it} has the id of another element, {found}",
    fix="give one of them another id: all elements of a file, channels too, share one space of ids",
    guard=lambda element, index: bool(element.id),
)
def id_unique(element: pn.Element, index: Index) -> Outcome:
    """No two elements have the same id."""
    first = index.earliest(element, pn.Element, _id)
    return first is element or _kind_and_place(first)


@constraint("{it} has the ROS name of {found}", fix="give one of them another name or namespace")
def node_net_name_unique(node_net: sym.NodeNet, index: Index) -> Outcome:
    """No two node nets have the same name and namespace."""
    first = index.earliest(node_net, sym.NodeNet, _ros_name)
    return first is node_net or describe(first)


@constraint(
    "{it} is called {found}, which is not a name for a ROS node",
    fix="use letters, digits and _, not starting with a digit",
    severity="warning",
    guard=lambda node_net, index: bool(label(node_net)),
)
def node_name_valid(node_net: sym.NodeNet, index: Index) -> Outcome:
    """The name of a node net is a valid name of a ROS node."""
    return bool(_NODE_NAME.fullmatch(label(node_net))) or repr(label(node_net))


@constraint(
    "{it} has the package {element.package!r}, which is not a name for a ROS package",
    fix="use two or more small letters, digits and _, starting with a letter, as REP 144 requires",
    guard=lambda node_net, index: node_net.package is not None,
)
def package_name_valid(node_net: sym.NodeNet, index: Index) -> Outcome:
    """The package of a node net has a valid name."""
    return bool(node_net.package and _PACKAGE.fullmatch(node_net.package))


@constraint(
    "{it} has the namespace {element.namespace!r}, which is not a ROS namespace",
    fix="write it like /left/arm",
    guard=lambda node_net, index: node_net.namespace is not None,
)
def namespace_valid(node_net: sym.NodeNet, index: Index) -> Outcome:
    """The namespace of a node net is a valid, absolute ROS namespace."""
    return bool(node_net.namespace and _NAMESPACE.fullmatch(node_net.namespace))


@constraint("{it} has the topic {element.topic!r}, which is not a ROS topic name", fix=_RULES)
def topic_name_valid(channel: sym.TopicChannel, index: Index) -> Outcome:
    """A topic has a valid ROS name."""
    return bool(_TOPIC.fullmatch(channel.topic))


@constraint("{it} has the service {element.service!r}, which is not a ROS service name", fix=_RULES)
def service_name_valid(channel: sym.ServiceChannel, index: Index) -> Outcome:
    """A service has a valid ROS name."""
    return bool(_TOPIC.fullmatch(channel.service))


@constraint("{it} has the action {element.action!r}, which is not a ROS action name", fix=_RULES)
def action_name_valid(channel: sym.ActionChannel, index: Index) -> Outcome:
    """An action has a valid ROS name."""
    return bool(_TOPIC.fullmatch(channel.action))


@constraint("{it} is for {found}, which is not a ROS name", fix=_RULES)
def port_name_valid(port: rtm.PlacePort, index: Index) -> Outcome:
    """A port of a run-time model is for a topic, service or action with a valid ROS name."""
    name = _ros_name_of(port)
    return name is None or bool(_TOPIC.fullmatch(name)) or repr(name)


@constraint(
    "{it} is for the topic {element.topic!r}, as is {found}",
    fix="join their ports in one channel or rename one",
)
def topic_unique(channel: sym.TopicChannel, index: Index) -> Outcome:
    """Every topic has exactly one channel."""
    first = index.earliest(channel, sym.TopicChannel, _absolute_name)
    return first is channel or describe(first)


@constraint(
    "{it} is for the service {element.service!r}, as is {found}",
    fix="join their clients in one channel or rename one",
)
def service_unique(channel: sym.ServiceChannel, index: Index) -> Outcome:
    """Every service has exactly one channel."""
    first = index.earliest(channel, sym.ServiceChannel, _absolute_name)
    return first is channel or describe(first)


@constraint(
    "{it} is for the action {element.action!r}, as is {found}",
    fix="join their clients in one channel or rename one",
)
def action_unique(channel: sym.ActionChannel, index: Index) -> Outcome:
    """Every action has exactly one channel."""
    first = index.earliest(channel, sym.ActionChannel, _absolute_name)
    return first is channel or describe(first)


@constraint(
    "{it} has the type {element.type!r}, not one such as {found}",
    fix="name a ROS interface, or leave it out to generate one from the token type",
    guard=lambda channel, index: channel.type is not None,
)
def channel_type_valid(channel: sym.Channel, index: Index) -> Outcome:
    """The type of a channel is a message for a topic, and an interface of its kind for others."""
    wanted, example = _SERVICE, "std_srvs/srv/Trigger"
    if isinstance(channel, sym.TopicChannel):
        wanted, example = _MESSAGE, "std_msgs/msg/String"
    elif isinstance(channel, sym.ActionChannel):
        wanted, example = _ACTION, "example_interfaces/action/Fibonacci"
    return bool(wanted.fullmatch(channel.type or "")) or example


@constraint(
    "{it} is called {found}, which is not a name for a ROS interface",
    fix="start with a capital letter and use letters and digits",
    severity="warning",
    guard=lambda token_type, index: bool(label(token_type)) and not token_type.ros,
)
def token_type_name_valid(token_type: sym.TokenType, index: Index) -> Outcome:
    """The name of a token type can name the ROS interfaces generated from it."""
    return bool(re.fullmatch(r"[A-Z][A-Za-z0-9]*", label(token_type))) or repr(label(token_type))


_RESERVED = "rename it: each node also has topics and services of its own"


def _node_names(index: Index) -> dict[sym.NodeNet, tuple[str, str, str]]:
    """Return namespace, name and full name of each node."""

    def make() -> dict[sym.NodeNet, tuple[str, str, str]]:
        found = {}
        for node in index.all(sym.NodeNet):
            above, name = (node.namespace or "").rstrip("/"), resource_name(label(node))
            found[node] = (above, name, f"{above}/{name}")
        return found

    return index.once("names of nodes in ROS", make)


def _full_names(channel: sym.Channel, index: Index) -> set[str]:
    """Return the names that a channel has for the nodes with a port in it."""
    places = (
        place
        for part in channel.eContents
        for name in ("place", "entry", "request", "goal")
        if (place := getattr(part, name, None)) is not None
    )
    nodes = {index.node_net_of(place) for place in places}
    known = _node_names(index)
    found = {full_name(_ros_name_of(channel) or "", *known[node][:2]) for node in nodes if node in known}
    return {name for name in found if name is not None}


_Reserved = dict[str, list[tuple[sym.NodeNet, str]]]


def _reserved(index: Index) -> tuple[_Reserved, _Reserved, _Reserved]:
    """Return what nodes have themselves: services, topics, and topics on which only they publish.

    Of a service it says what it does, of a topic its type; by full name, with the nodes that have it.
    """

    def make() -> tuple[_Reserved, _Reserved, _Reserved]:
        services, topics, owned = _Reserved(), _Reserved(), _Reserved()
        for node, (_, _, own) in _node_names(index).items():
            signals = {signal.id: value_names(signal) for signal in node.signals if signal.id}
            is_managed = node.lifecycle is not None
            for name, what in reserved_services(own, signals, is_managed).items():
                services.setdefault(name, []).append((node, what))
            for name, (type, is_own) in reserved_topics(own, signals, is_managed).items():
                for table in (topics, owned) if is_own else (topics,):
                    table.setdefault(name, []).append((node, type))
        return services, topics, owned

    return index.once("reserved names", make)


def _taken(channel: sym.Channel, index: Index) -> Iterator[tuple[sym.NodeNet, str]]:
    """Yield what a channel takes away from nodes: each node, and the reason in words."""
    services, topics, owned = _reserved(index)
    for name in sorted(_full_names(channel, index)):
        if isinstance(channel, sym.TopicChannel):
            for node, type in topics.get(name, ()):
                if channel.type != type:
                    yield node, f"{name}, a topic of the type {type} that nodes have themselves"
            for node, _ in owned.get(name, ()) if len(channel.publishers) else ():
                yield node, f"{name}, on which only {describe(node)} itself publishes"
        elif isinstance(channel, sym.ServiceChannel):
            for node, what in services.get(name, ()):
                yield node, f"{name}, a service of {describe(node)} itself, which {what}"


@constraint("{it} has the reserved name {found}", fix=_RESERVED)
def channel_name_reserved(channel: sym.Channel, index: Index) -> Outcome:
    """No topic or service has a name that the nodes of the model need for themselves."""
    name = _ros_name_of(channel) or ""
    part = hidden_part(name)
    if part is not None:
        return f"{name}, because {part} is a placeholder for another name"
    made_here = (why for node, why in _taken(channel, index) if node.execution == sym.Execution.net)
    return next(made_here, True)


@constraint("{it} has the reserved name {found}", fix=_RESERVED, severity="warning")
def channel_name_reserved_by_hand(channel: sym.Channel, index: Index) -> Outcome:
    """A topic or service has no name that a node written by hand would need if its net ran instead."""
    by_hand = (why for node, why in _taken(channel, index) if node.execution != sym.Execution.net)
    return next(by_hand, True)
