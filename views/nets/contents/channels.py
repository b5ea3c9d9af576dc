"""Channels in a view: first-class elements between the node nets, joined to the places of their ports."""

from __future__ import annotations

from dineros.metamodel import elements, pn, rtm, sym
from dineros.metamodel.calls import OUTCOMES, UNLIMITED, CallCircleError, instance_counts
from dineros.metamodel.elements import label
from dineros.views.nets.contents.model import Caption, Edge, EdgeKind, Node, NodeKind, ViewModel
from dineros.views.nets.contents.positions import position_of
from dineros.views.nets.contents.times import interval_words

DISPATCHER_LIMIT = 16
"""Default capacity of a dispatcher queue."""


def draw_channels(model: sym.SystemModel, view: ViewModel) -> None:
    """Add the channels of a system model and the lines to the places of their ports."""
    try:
        counts = instance_counts(model)
    except CallCircleError:  # a picture shows models that are not valid, too
        counts = {}
    for channel in model.channels:
        if isinstance(channel, sym.TopicChannel):
            _topic(channel, view, model.middleware == sym.Middleware.ros2)
        elif isinstance(channel, sym.ServiceChannel):
            _service(channel, view, counts.get(channel, channel.instances))
        elif isinstance(channel, sym.ActionChannel):
            _action(channel, view, counts.get(channel, channel.instances))


def draw_ports(model: rtm.RuntimeModel, view: ViewModel) -> None:
    """Add the channels that the places of a run-time model send to and receive from."""
    histories = model.middleware == sym.Middleware.ros2
    for place in elements.places(model):
        for port in place.ports if isinstance(place, rtm.Place) else []:
            if isinstance(port, rtm.PublisherPort):
                node = _channel(view, port.channel, "topic", port.topic, "topic", port.type)
                _line(view, "publish", place.id, node.id, _queue(port, histories))
            elif isinstance(port, rtm.SubscriberPort):
                node = _channel(view, port.channel, "topic", port.topic, "topic", port.type)
                queues = _queues(port, None if histories else port.dispatcherLimit)
                _line(view, "subscribe", node.id, place.id, queues)
            elif isinstance(port, rtm.ClientPort):
                node = _channel(view, port.channel, "service", port.service, "service", port.type)
                _asks(view, port, place, node.id)
            elif isinstance(port, rtm.ActionClientPort):
                node = _channel(view, port.channel, "service", port.action, "action", port.type)
                _goals(view, port, place, node.id)
            elif isinstance(port, rtm.ActionServerPort):
                note = _several("action", port.instances, "slot")
                node = _channel(view, port.channel, "service", port.action, note, port.type)
                _works(view, port, place, node.id)
            elif isinstance(port, rtm.ServerPort):
                note = _several("service", port.instances, "instance")
                node = _channel(view, port.channel, "service", port.service, note, port.type)
                _line(view, "call", node.id, place.id, "")
                for exit_ in filter(None, [port.exit]):
                    _line(view, "return", exit_.id, node.id, "")


def _topic(channel: sym.TopicChannel, view: ViewModel, histories: bool) -> None:
    node = _drawn(channel, view, "topic", "Topic", channel.topic)
    if channel.qos is not None:
        node.detail["Quality of service"] = f"{channel.qos.reliability}, {channel.qos.durability}"
    for publisher in channel.publishers:
        _join(view, "publish", publisher.place, channel, _queue(publisher, histories) + _late(publisher))
    limits: dict[sym.NodeNet | None, int] = {found.node: found.limit for found in channel.dispatchers}
    for subscriber in channel.subscribers:
        limit = limits.get(elements.node_net_of(subscriber.place), DISPATCHER_LIMIT)
        queues = _queues(subscriber, None if histories else limit)
        _join(view, "subscribe", channel, subscriber.place, queues + _late(subscriber))


def _late(port: sym.PublisherPort | sym.SubscriberPort | sym.ClientPort) -> str:
    """Return the latency of a port, appended to its other texts."""
    return "" if port.latency is None else f", {interval_words(port.latency)} on the way"


def _service(channel: sym.ServiceChannel, view: ViewModel, instances: int | None) -> None:
    _drawn(channel, view, _several("service", instances, "instance"), "Service", channel.service)
    for client in channel.clients:
        _asks(view, client, client.request, channel.id)
    for server in filter(None, [channel.server]):
        _join(view, "call", channel, server.entry, "")
        _join(view, "return", server.exit, channel, "")


def _asks(
    view: ViewModel, port: sym.ClientPort | rtm.ClientPort, request: pn.Place | None, channel: str
) -> None:
    """Draw the request, the response and the time-out place of a client."""
    number = port.outstanding or 1
    several = "" if number == 1 else f", {'any number' if number == UNLIMITED else number} at a time"
    gives_up = "" if port.timeout is None else f"gives up after {port.timeout:g} s"
    told = port.timedOut if gives_up else None
    late = _late(port) if isinstance(port, sym.ClientPort) else ""
    asked = f"{port.client}{several}{late}" + (f", {gives_up}" if gives_up and told is None else "")
    if request is not None:
        _line(view, "request", request.id, channel, asked)
    if port.response is not None:
        also = f", or {gives_up}" if told is port.response else ""
        _line(view, "response", channel, port.response.id, f"{port.client}{also}")
    if told is None or told is port.response:
        return
    for edge in view.edges:
        if (edge.kind, edge.source, edge.target) == ("response", channel, told.id):  # clients may share it
            edge.label += f", {port.client} {gives_up}"
            return
    _line(view, "response", channel, told.id, f"{port.client} {gives_up}")


def _action(channel: sym.ActionChannel, view: ViewModel, slots: int | None) -> None:
    _drawn(channel, view, _several("action", slots, "slot"), "Action", channel.action)
    for client in channel.clients:
        _goals(view, client, client.goal, channel.id)
    for server in filter(None, [channel.server]):
        _works(view, server, server.entry, channel.id)


def _goals(
    view: ViewModel, port: sym.ActionClientPort | rtm.ActionClientPort, goal: pn.Place | None, channel: str
) -> None:
    """Draw the messages of an action client; a place with several outcomes has one line."""
    for place, word in ((goal, ""), (port.cancel, ": cancel")):
        if place is not None:
            _line(view, "request", place.id, channel, f"{port.client}{word}")
    words: dict[pn.Place, list[str]] = {}
    for role in (*OUTCOMES, "rejected", "accepted", "feedback"):
        place = getattr(port, role)
        if place is not None:
            words.setdefault(place, []).append(role)
    for place, roles in words.items():
        _line(view, "response", channel, place.id, f"{port.client}: {', '.join(roles)}")


def _works(
    view: ViewModel, port: sym.ActionServerPort | rtm.ActionServerPort, entry: pn.Place | None, channel: str
) -> None:
    """Draw the messages of a server."""
    for place, word in ((entry, ""), (port.cancel, "cancel")):
        if place is not None:
            _line(view, "call", channel, place.id, word)
    for role in (*OUTCOMES, "feedback"):
        place = getattr(port, role)
        if place is not None:
            _line(view, "return", place.id, channel, role)


def _several(what: str, number: int | None, each: str) -> str:
    return what if number is None else f"{what}, {number} {each}{'' if number == 1 else 's'}"


def _drawn(channel: sym.Channel, view: ViewModel, note: str, heading: str, name: str) -> Node:
    """Draw a channel of a system model at its stored position; its ROS name may differ."""
    kind: NodeKind = "topic" if isinstance(channel, sym.TopicChannel) else "service"
    if channel.latency is not None:
        note += f", {interval_words(channel.latency)} on the way"
    node = _channel(view, channel.id, kind, label(channel), note, channel.type)
    node.position = position_of(channel)
    if name != node.label:
        node.detail[heading] = name
    return node


def _channel(view: ViewModel, id: str, kind: NodeKind, name: str, note: str, type: str | None) -> Node:
    """Return the node of a channel, which several ports may share."""
    for node in view.nodes:
        if node.id == id and node.kind in ("topic", "service"):
            if len(note) > len(node.captions[0].text):
                node.captions[0].text = note
            return node
    node = Node(id, kind, name, captions=[Caption(note, "note")])
    if type:
        node.detail["ROS interface"] = type
    view.nodes.append(node)
    return node


def _join(
    view: ViewModel, kind: EdgeKind, source: pn.Element | None, target: pn.Element | None, text: str
) -> None:
    """Add a line; a model that is not valid may lack an end."""
    if source is not None and target is not None:
        _line(view, kind, source.id, target.id, text)


def _line(view: ViewModel, kind: EdgeKind, source: str, target: str, text: str) -> None:
    view.edges.append(Edge(f"{kind} {source} {target}", source, target, kind, text))


def _queue(port: sym.TopicPort | rtm.PublisherPort | rtm.SubscriberPort, histories: bool) -> str:
    """Return the queue of a port in words: a history under the rules of ROS 2."""
    if not histories:
        return f"queue {port.limit}"
    best_effort = port.qos is not None and port.qos.reliability == sym.Reliability.bestEffort
    return f"history {port.limit}{', best effort' if best_effort else ''}"


def _queues(port: sym.SubscriberPort | rtm.SubscriberPort, dispatcher: int | None) -> str:
    """Return the queue in which a message waits before it is taken; ROS 2 has no dispatcher."""
    if dispatcher is None:
        return _queue(port, histories=True)
    return f"dispatcher {dispatcher}, {_queue(port, histories=False)}"
