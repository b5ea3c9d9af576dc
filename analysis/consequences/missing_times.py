"""The times on which the load of a channel or of a node depends, and that a model does not give."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from dineros.analysis.model.channels import channel_words, ends_of
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.elements import is_unseen, label, node_net_of, system_model_of
from dineros.metamodel.matching import are_matched
from dineros.metamodel.times.given import (
    duration_of,
    latency_between,
    latency_of_calls,
    period_of,
    reaction_of,
)


def missing_times(channel: sym.Channel) -> Iterator[str]:
    """Yield the times that a model does not give and on which the load of a channel depends, in words."""
    yield from missing_times_of(_nodes_of(channel))


def missing_times_of(nodes: Iterable[sym.NodeNet]) -> Iterator[str]:
    """Yield the times that a model does not give and on which the load of some nodes depends, in words."""
    for node in _with_senders(nodes):
        if is_unseen(node) or node.lifecycle is not None:
            yield f"nothing says when node {label(node)} is active"
        elif not runs_callbacks(node):
            given = reaction_of(node)
            if given is None or given.latest is None:
                yield f"the reaction of node {label(node)} is not given"
        else:
            pages = [each for each in node.eAllContents() if isinstance(each, sym.CallbackPage)]
            yield from (missing for page in pages for missing in _missing(page))
        for other in _sending(node):
            if not all(map(_ends, _latencies(other, node))):
                yield f"the model gives no latency for {channel_words(other)}"


def nodes_around(channel: sym.Channel) -> list[sym.NodeNet]:
    """Return the nodes at a channel, and all on which these depend."""
    return _with_senders(_nodes_of(channel))


def _with_senders(nodes: Iterable[sym.NodeNet]) -> list[sym.NodeNet]:
    """Return some nodes, and all on which these depend."""
    todo, seen = list(nodes), list[sym.NodeNet]()
    while todo:
        node = todo.pop(0)
        if node not in seen:
            seen.append(node)
            todo += [each for other in _sending(node) for each in _nodes_of(other)]
    return seen


def _sending(node: sym.NodeNet) -> list[sym.Channel]:
    """Return the channels by which a node gets something."""
    model = system_model_of(node)
    found = []
    for other in () if model is None else model.channels:
        is_topic = isinstance(other, sym.TopicChannel)
        places = ends_of(other)[1] if is_topic else [place for end in ends_of(other) for place in end]
        if node in map(node_net_of, places):
            found.append(other)
    return found


def _missing(page: sym.CallbackPage) -> Iterator[str]:
    """Yield which times of a callback are missing: a greatest duration of it or its steps, and the period."""
    if page.kind == sym.CallbackKind.timer and period_of(page) is None:
        yield f"the period of callback {label(page)} is not given"
    steps = [each.interval for each in Body(page).transitions]
    if not _ends(duration_of(page)) and not (steps and all(map(_ends, steps))):
        yield f"the duration of callback {label(page)} is not given"


def _ends(interval: pn.TimeInterval | None) -> bool:
    return interval is not None and interval.latest is not None


def _latencies(channel: sym.Channel, node: sym.NodeNet) -> list[pn.TimeInterval | None]:
    """Return the latencies of what a node gets from a channel; of requests and goals, of all of them."""
    if isinstance(channel, sym.TopicChannel):
        return [
            latency_between(writer, reader)
            for reader in channel.subscribers
            for writer in channel.publishers
            if node_net_of(reader.place) is node and are_matched(writer, reader)
        ]
    if isinstance(channel, sym.ServiceChannel | sym.ActionChannel):
        return [latency_of_calls(client) for client in channel.clients]
    return []


def _nodes_of(channel: sym.Channel) -> list[sym.NodeNet]:
    nodes = [node_net_of(place) for end in ends_of(channel) for place in end]
    return [each for each in nodes if each is not None]
