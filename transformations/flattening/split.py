"""Splitting of SyM to RTMs: one runtime model per node net, with ports on its places (paper, Sect. 5.4)."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TypedDict

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.under_way import outstanding_counts
from dineros.metamodel.calls import (
    CLIENT_PLACES,
    SERVER_PLACES,
    UNLIMITED,
    Served,
    action_places,
    instance_counts,
)
from dineros.metamodel.elements import elements, node_net_of, node_nets, places, token_types
from dineros.metamodel.errors import DinerosError
from dineros.transformations.language.copying import deep_copy
from dineros.transformations.rules.topics import DISPATCHER_LIMIT

_RUNTIME_CLASSES: dict[type[EObject], type[EObject]] = {pn.Place: rtm.Place, sym.Place: rtm.Place}


class CoverageError(DinerosError):
    """The runtime models do not cover the system model exactly once."""


def split(model: sym.SystemModel) -> list[rtm.RuntimeModel]:
    """Split a system model into one runtime model per node net, in model order; the model is not changed.

    Pages that span several node nets are copied into each. Every other element, including the ports of
    channels, is in exactly one runtime model, which is checked.

    Raises
    ------
    CoverageError
        An element belongs to no node net, or is referenced from another one.
    CallCircleError
        Services call each other in a cycle without a given number of instances.
    """
    split_models = []
    counts = instance_counts(model)
    copies: Counter[EObject] = Counter()
    for node in node_nets(model):
        runtime_model, images = _runtime_model(model, node, counts)
        split_models.append(runtime_model)
        copies.update(list(images))
        _require_closed(node, images)
    _require_covered(model, copies)
    return split_models


def file_names(parts: Sequence[rtm.RuntimeModel]) -> list[str]:
    """Return a file name for each runtime model: the id of its node net, with only valid characters."""
    names: list[str] = []
    for part in parts:
        stem = re.sub(r"[^\w.+-]", "_", part.node.id).lstrip(".") or "_"
        name, number = f"{stem}.rtm.xmi", 1
        while name in names:
            number += 1
            name = f"{stem}~{number}.rtm.xmi"
        names.append(name)
    return names


def _runtime_model(
    model: sym.SystemModel, node: sym.NodeNet, counts: dict[Served, int]
) -> tuple[rtm.RuntimeModel, dict[EObject, EObject]]:
    outer = list(_outer_pages(node))
    others = {
        part
        for page, inner in zip(outer[1:], outer, strict=False)
        for part in (*page.objects, *page.arcs)
        if part is not inner
    }
    top, images = deep_copy(outer[-1], omit=others, classes=_RUNTIME_CLASSES)
    copied = images[node]
    assert isinstance(top, pn.Page) and isinstance(copied, sym.NodeNet)
    runtime_model = rtm.RuntimeModel(
        id=f"{model.id}.{node.id}",
        name=node.name,
        systemModel=model.id,
        middleware=model.middleware,
        pages=[top],
        node=copied,
    )
    _copy_token_types(model, runtime_model)
    for channel in model.channels:
        for place, port in _ports(channel, node, images, counts):
            place.ports.append(port)
    return runtime_model, images


def _copy_token_types(model: sym.SystemModel, runtime_model: rtm.RuntimeModel) -> None:
    """Copy the first token type, and those that its places name, to a runtime model."""
    named = {place.tokenType for place in places(runtime_model) if isinstance(place, sym.Place)}
    types: dict[EObject | None, sym.TokenType | None] = {None: None}
    for token_type in token_types(model):
        if token_type is not model.tokenType and token_type not in named:
            continue
        copied, _ = deep_copy(token_type)
        assert isinstance(copied, sym.TokenType)
        types[token_type] = copied
        if token_type is model.tokenType:
            runtime_model.tokenType = copied
        else:
            runtime_model.otherTokenTypes.append(copied)
    for place in places(runtime_model):
        if isinstance(place, sym.Place) and place.tokenType is not None:
            if place.tokenType not in types:
                raise CoverageError(
                    f"the place {place.id!r} has a token type that the model does not have",
                    element=place.id,
                    hint="name a token type of the model, or omit it for the first one",
                )
            place.tokenType = types[place.tokenType]


def _outer_pages(node: sym.NodeNet) -> Iterator[pn.Page]:
    """Yield a node net and the pages around it, inner before outer."""
    page: pn.Page | None = node
    while page is not None:
        yield page
        page = page.page


def _ports(
    channel: sym.Channel,
    node: sym.NodeNet,
    images: dict[EObject, EObject],
    counts: dict[Served, int],
) -> Iterator[tuple[rtm.Place, rtm.PlacePort]]:
    """Yield the ports of a channel in a node net, each with its place."""
    if isinstance(channel, sym.TopicChannel):
        yield from _topic_ports(channel, node, images)
    elif isinstance(channel, sym.ServiceChannel):
        yield from _service_ports(channel, images, counts)
    elif isinstance(channel, sym.ActionChannel):
        yield from _action_ports(channel, images, counts)


def _topic_ports(
    channel: sym.TopicChannel, node: sym.NodeNet, images: dict[EObject, EObject]
) -> Iterator[tuple[rtm.Place, rtm.PlacePort]]:
    for publisher in channel.publishers:
        place = images.get(publisher.place)
        if isinstance(place, rtm.Place):
            qos = _quality(channel, publisher)
            sent = rtm.PublisherPort(
                **_interface(channel), topic=channel.topic, limit=publisher.limit, qos=qos
            )
            yield place, sent
    limits = [dispatcher.limit for dispatcher in channel.dispatchers if dispatcher.node is node]
    for subscriber in channel.subscribers:
        place = images.get(subscriber.place)
        if isinstance(place, rtm.Place):
            port = rtm.SubscriberPort(
                **_interface(channel),
                topic=channel.topic,
                limit=subscriber.limit,
                dispatcherLimit=limits[0] if limits else DISPATCHER_LIMIT,
                inHand=subscriber.inHand,
                qos=_quality(channel, subscriber),
            )
            missed = images.get(subscriber.missed) if subscriber.missed is not None else None
            if isinstance(missed, rtm.Place) and _runs_on_ros2(channel):
                port.missed = missed
            yield place, port


def _runs_on_ros2(channel: sym.Channel) -> bool:
    """Return whether a channel belongs to ROS 2."""
    return channel.model is not None and channel.model.middleware == sym.Middleware.ros2


def _service_ports(
    channel: sym.ServiceChannel, images: dict[EObject, EObject], counts: dict[Served, int]
) -> Iterator[tuple[rtm.Place, rtm.PlacePort]]:
    # In the paper's rules, a client has one request under way and waits for it.
    asked = {} if channel.model is None else outstanding_counts(channel.model)
    for client in channel.clients:
        place, response = images.get(client.request), images.get(client.response)
        if isinstance(place, rtm.Place) and isinstance(response, rtm.Place):
            port = rtm.ClientPort(
                **_interface(channel), service=channel.service, client=client.client, response=response
            )
            if _runs_on_ros2(channel):
                port.outstanding, port.timeout = asked[client], client.timeout
                told = images.get(client.timedOut) if client.timedOut is not None else None
                port.timedOut = told if isinstance(told, rtm.Place) else None
            yield place, port
    server = channel.server
    entry, exit_, page = images.get(server.entry), images.get(server.exit), images.get(server.page)
    if isinstance(entry, rtm.Place) and isinstance(exit_, rtm.Place) and isinstance(page, pn.Page):
        serving = rtm.ServerPort(
            **_interface(channel),
            service=channel.service,
            exit=exit_,
            page=page,
            # A server without clients still has one instance.
            instances=max(1, counts[channel]),
            depth=channel.depth,
            outstanding=_most_asked([asked[client] for client in channel.clients if _runs_on_ros2(channel)]),
        )
        yield entry, serving


def _most_asked(counts: list[int]) -> int:
    """Return the most requests that one of several clients has under way."""
    return UNLIMITED if UNLIMITED in counts else max([1, *counts])


def _action_ports(
    channel: sym.ActionChannel, images: dict[EObject, EObject], counts: dict[Served, int]
) -> Iterator[tuple[rtm.Place, rtm.PlacePort]]:
    for client in channel.clients:
        goal = images.get(client.goal)
        if isinstance(goal, rtm.Place):
            port = rtm.ActionClientPort(
                **_interface(channel),
                action=channel.action,
                client=client.client,
                outstanding=client.outstanding or 1,
                depth=channel.depth,
            )
            for role in CLIENT_PLACES:
                setattr(port, role, images.get(getattr(client, role)))
            yield goal, port
    server = channel.server
    entry, page = images.get(server.entry), images.get(server.page)
    if isinstance(entry, rtm.Place) and isinstance(page, pn.Page):
        # An action server without clients still has one slot.
        serving = rtm.ActionServerPort(
            **_interface(channel),
            action=channel.action,
            page=page,
            mayReject=server.mayReject,
            instances=max(1, counts[channel]),
            depth=channel.depth,
        )
        for role in SERVER_PLACES:
            setattr(serving, role, images.get(getattr(server, role)))
        yield entry, serving


class _Interface(TypedDict):
    channel: str
    type: str | None
    mappings: list[sym.FieldMapping]


def _interface(channel: sym.Channel) -> _Interface:
    """Return the values that all ports of a channel have in common."""
    mappings = []
    for mapping in channel.mappings:
        copied, _ = deep_copy(mapping)
        assert isinstance(copied, sym.FieldMapping)
        mappings.append(copied)
    return {"channel": channel.id, "type": channel.type, "mappings": mappings}


def _quality(channel: sym.TopicChannel, port: sym.TopicPort) -> sym.QualityOfService | None:
    """Return the quality of service of a port; None: no port of its topic has one.

    If only another port has one, this port gets the default values explicitly, which decide whether they
    match.
    """
    quality = port.qos or channel.qos
    if quality is None:
        is_said = any(other.qos is not None for other in (*channel.publishers, *channel.subscribers))
        return sym.QualityOfService() if is_said else None
    copied, _ = deep_copy(quality)
    assert isinstance(copied, sym.QualityOfService)
    return copied


def _require_closed(node: sym.NodeNet, images: dict[EObject, EObject]) -> None:
    """Refuse arcs and references from a node net to elements outside of it."""
    for original in images:
        ends: tuple[EObject | None, ...] = ()
        if isinstance(original, pn.Arc):
            ends = (original.source, original.target)
        elif isinstance(original, (pn.ReferencePlace, pn.ReferenceTransition)):
            ends = (original.target,)
        elif isinstance(original, sym.Literal):
            ends = (original.signal,)
        for end in ends:
            if end not in images:
                other = node_net_of(end)
                raise CoverageError(
                    f"{original!r} of {node.id} leads to {end!r} in {other.id if other else 'no node net'}",
                    element=node.id,
                    hint="node nets are connected only by channels",
                )


def _require_covered(model: sym.SystemModel, copies: Counter[EObject]) -> None:
    """Check that each element is in one runtime model; pages around node nets may be in several."""
    for element in elements(model):
        if element is model or isinstance(element, (sym.TokenType, sym.Channel)):
            continue
        if isinstance(element, pn.Page) and node_net_of(element) is None:
            continue
        if copies[element] != 1:
            raise CoverageError(
                f"{element!r} is in {copies[element]} runtime models",
                element=element.id,
                hint="everything except channels belongs to exactly one node net",
            )
    for port in _port_places(model):
        if copies[port] != 1:
            raise CoverageError(f"the port at {port!r} is in {copies[port]} runtime models", element=port.id)


def _port_places(model: sym.SystemModel) -> Iterator[pn.Place]:
    for channel in model.channels:
        if isinstance(channel, sym.TopicChannel):
            for topic_port in (*channel.publishers, *channel.subscribers):
                yield topic_port.place
            yield from (port.missed for port in channel.subscribers if port.missed is not None)
        elif isinstance(channel, sym.ServiceChannel):
            yield from (channel.server.entry, channel.server.exit)
            for client in channel.clients:
                yield from (client.request, client.response)
                if client.timedOut is not None:
                    yield client.timedOut
        elif isinstance(channel, sym.ActionChannel):
            yield from action_places(channel)
