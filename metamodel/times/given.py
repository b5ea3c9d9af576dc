"""The times that hold for the elements of a system model: their own, or the model's.

>>> from dineros.metamodel import pn, sym
>>> model = sym.SystemModel(id="robot", middleware="ros2", times=sym.DefaultTimes())
>>> says_times(model)
False
>>> model.times.duration = pn.TimeInterval(latest=0.02)
>>> says_times(model)
True
"""

from __future__ import annotations

from collections.abc import Iterator

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import (
    group_or_node,
    is_awaited,
    runs_callbacks,
    threads_of,
    works_on_goals,
)
from dineros.metamodel.elements import (
    channels,
    is_unseen,
    node_net_of,
    node_nets,
    pages,
    system_model_of,
    transitions,
)
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.matching import quality_of

_TIMES = ("interval", "duration", "offset", "jitter", "latency", "reaction")


def says_times(model: sym.SystemModel) -> bool:
    """Return whether times of a model decide something: it gives a latest time, a jitter or a lifespan.

    The period of a timer alone does not count, nor do earliest times alone: nothing ever has to happen.
    """
    decide = any(not isinstance(each, pn.TimeInterval) or each.latest is not None for each in _times(model))
    return decide or bool(with_lifespans(model))


def gives_times(model: sym.SystemModel) -> bool:
    """Return whether a model specifies any times; the period of a timer alone does not count."""
    return next(_times(model), None) is not None


def _times(model: sym.SystemModel) -> Iterator[pn.TimeInterval | float]:
    """Yield the intervals and the jitters that a model gives."""
    owners: list[EObject] = [*transitions(model), *pages(model)]
    owners += [each for channel in model.channels for each in (channel, *channel.eContents)]
    if model.times is not None:
        owners.append(model.times)
    for each in owners:
        for name in _TIMES:
            found = getattr(each, name, None)
            if found is not None:
                yield found


def with_lifespans(model: sym.SystemModel) -> list[sym.TopicChannel]:
    """Return the topics whose messages are removed when they are too old."""
    return [
        channel
        for channel in channels(model, sym.TopicChannel)
        if any(quality_of(port).lifespan is not None for port in (*channel.publishers, *channel.subscribers))
    ]


def require_known(model: sym.SystemModel) -> None:
    """Refuse times of a model that an analysis of latencies does not support.

    Raises
    ------
    DinerosError
        A topic or a port has a lifespan.
    """
    for channel in with_lifespans(model):
        raise DinerosError(
            f"topic {channel.topic} has a lifespan, which latencies do not follow yet",
            element=channel.id,
            hint="ask check --time, or take the lifespan away",
        )


def lifespan_between(writer: sym.PublisherPort, reader: sym.SubscriberPort) -> pn.TimeInterval | None:
    """Return how old a message is when it is removed before it is taken; None if it never is.

    By DDS, the writer's lifespan counts. Some implementations obey that of the reader instead. So a message
    certainly goes only if both say it; if one does, nothing bounds when.
    """
    given = [quality_of(port).lifespan for port in (writer, reader)]
    known = [each for each in given if each is not None]
    if not known:
        return None
    return pn.TimeInterval(earliest=min(known), latest=max(known) if len(known) == 2 else None)


def default_times(element: EObject | None) -> sym.DefaultTimes:
    """Return the times that apply to an element without times of its own, from the model around it."""
    model = system_model_of(element)
    found = None if model is None else model.times
    return found if found is not None else sym.DefaultTimes()


def duration_of(page: sym.CallbackPage) -> pn.TimeInterval | None:
    """Return how long a run of a callback takes a processor; None if that is open.

    A callback in which a transition has an interval says so itself: the model's duration is not for it.
    """
    if page.duration is not None:
        return page.duration
    if any(each.interval is not None for each in Body(page).transitions):
        return None
    return default_times(page).duration


def period_of(page: sym.CallbackPage) -> float | None:
    """Return the period of a timer in seconds; None if it is unknown: the timer may tick at any time.

    It is open if the period is only assumed, and if the node is invented: it then stands for unknown
    nodes at the other end of a channel.
    """
    if page.kind != sym.CallbackKind.timer or not page.timer or "period" in (page.assumed or "").split():
        return None
    return None if is_unseen(node_net_of(page)) else float(page.timer)


def latency_between(writer: sym.PublisherPort, reader: sym.SubscriberPort) -> pn.TimeInterval | None:
    """Return how long a message is in transit to a reader: as given there, at its writer, topic, or model."""
    for each in (reader, writer, writer.channel):
        if each is not None and each.latency is not None:
            return each.latency
    return default_times(writer).latency


def latency_of_calls(client: sym.ClientPort | sym.ActionClientPort) -> pn.TimeInterval | None:
    """Return how long each request and each response of a client is on its way."""
    for each in (client, client.channel):
        if each is not None and each.latency is not None:
            return each.latency
    return default_times(client).latency


def goals_taken_until(action: sym.ActionChannel, server: sym.NodeNet | None) -> float | None:
    """Return how long it takes at most until a server takes a goal that is sent, if it can; None if open.

    It is open with managed nodes, which may come and go meanwhile.

    Parameters
    ----------
    action
        The action.
    server
        The node of its server: while a model is flattened, the server's page has only copies.
    """
    found = [_taken_until(client, server, server) for client in action.clients]
    known = [each for each in found if each is not None]
    return max(known) if known and len(known) == len(found) else None


def results_taken_until(client: sym.ActionClientPort, server: sym.NodeNet | None) -> float | None:
    """Return how long it takes at most until a client takes a result that is sent; None if that is open."""
    if client.channel is None or goals_taken_until(client.channel, server) is None:
        return None
    return _taken_until(client, node_net_of(client.goal), server)


def _taken_until(
    client: sym.ActionClientPort, node: sym.NodeNet | None, server: sym.NodeNet | None
) -> float | None:
    """Return the latency of a client and the reaction of a node; None if one of them is open."""
    latency = latency_of_calls(client)
    if latency is None or latency.latest is None or node is None:
        return None
    if any(each is None or each.lifecycle is not None for each in (node_net_of(client.goal), server)):
        return None
    if runs_callbacks(node):
        return float(latency.latest)
    reaction = reaction_of(node)
    return None if reaction is None or reaction.latest is None else float(latency.latest + reaction.latest)


def gives_up_in_time(client: sym.ClientPort) -> bool:
    """Return whether it is known when a client gives up, at the earliest: it has one request under way.

    A callback that awaits needs a thread to give up; if nodes are managed, a server may be absent.
    """
    if not (client.timeout or 0) > 0 or client.outstanding not in (None, 1) or is_awaited(client):
        return False
    model = system_model_of(client)
    return model is not None and not any(node.lifecycle for node in node_nets(model))


def reaction_of(node: sym.NodeNet) -> pn.TimeInterval | None:
    """Return how long the engine of a node takes to fire; None if that is open."""
    return node.reaction if node.reaction is not None else default_times(node).reaction


def waits(page: sym.CallbackPage) -> bool:
    """Return whether a callback waits for a response, or for how a goal ends, before it ends."""
    return bool(Body(page).requests)


def runs_at_once(page: sym.CallbackPage) -> int:
    """Return how many runs of a callback there may be at the same time."""
    node = node_net_of(page)
    if node is None or not runs_callbacks(node):
        return 1
    return 1 if is_exclusive(page) else threads_of(node)


def is_exclusive(page: sym.CallbackPage) -> bool:
    """Return whether a callback is in an exclusive group, which it keeps from its beginning to its end."""
    group = None if works_on_goals(page) else group_or_node(page)
    return isinstance(group, sym.NodeNet) or (
        isinstance(group, sym.CallbackGroup) and group.kind == sym.CallbackGroupKind.exclusive
    )
