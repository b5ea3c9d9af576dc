"""Topics, services and actions of a model: their names in ROS, and the places at their ends."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import label


def channel_words(channel: sym.Channel) -> str:
    """Return a channel by its name in ROS, such as ``topic scan``."""
    match channel:
        case sym.TopicChannel():
            return f"topic {channel.topic}"
        case sym.ServiceChannel():
            return f"service {channel.service}"
        case sym.ActionChannel():
            return f"action {channel.action}"
    return label(channel)


def ends_of(channel: sym.Channel | None) -> tuple[list[pn.Place], list[pn.Place]]:
    """Return the places of those who write into a channel, and of those who read."""
    match channel:
        case sym.TopicChannel():
            return [port.place for port in channel.publishers], [port.place for port in channel.subscribers]
        case sym.ServiceChannel():
            return [port.request for port in channel.clients], [channel.server.entry]
        case sym.ActionChannel():
            return [port.goal for port in channel.clients], [channel.server.entry]
    return [], []
