"""Traces that begin in the middle of a run, since their older parts are not kept any more.

Each begins with a checkpoint of its node, at a moment of its own. What the node's own places hold is known
from it. What was under way between two nodes follows from their numbers: a topic holds for a subscriber what
its publisher had sent, less what the subscriber had taken. Where the subscriber's trace begins later, that
is less than nothing: what it owes comes when the publisher's trace has got there. The same holds for the
steps of calls, whose effects on the places between client and server add up in any order.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from dineros.analysis.conformance.messages import Past
from dineros.analysis.conformance.replay import Replay
from dineros.metamodel import pn, sym
from dineros.metamodel.elements import node_net_of
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.message_ids import parse_id
from dineros.metamodel.records import Checkpoint, Header, Record, Reply, Request, Response, Serve

Checkpoints = Mapping[str, Checkpoint]
"""The checkpoint with which the trace of each node begins."""


def beginnings(traces: Mapping[str, Iterable[Record]]) -> dict[str, Checkpoint]:
    """Return the checkpoints that traces begin with; none where all are there from the start of the run.

    Raises
    ------
    DinerosError
        A trace begins neither with the run nor with a header and a checkpoint.
    """
    found: dict[str, Checkpoint] = {}
    is_partial = False
    for node, records in traces.items():
        first = list(_first_two(records))
        if len(first) == 2 and isinstance(first[0], Header) and isinstance(first[1], Checkpoint):
            found[node] = first[1]
        if first and first[0].sequence != 0:
            is_partial = True
            if node not in found:
                raise DinerosError(
                    f"the trace begins with record {first[0].sequence}",
                    location=first[0].location or Location(),
                    hint="give the parts before it, too",
                )
    return found if is_partial else {}


def begin_within(replay: Replay, checkpoints: Checkpoints) -> None:
    """Put a replay where the traces begin.

    Raises
    ------
    DinerosError
        A channel has an existing message type: if its messages had no ids, nobody knows what was under way.
        Or it is an action.
    """
    net = replay.net
    own = {index for places in net.places_of.values() for index in places.values()}
    capacity = {bounded: replay.marking[bounded] + replay.marking[free] for bounded, free in net.room.items()}
    for node, checkpoint in checkpoints.items():
        for place, index in net.places_of.get(node, {}).items():
            replay.marking[index] = len(checkpoint.marking.get(place, ()))
    for channel in net.model.channels:
        if channel.id in net.typed_channels:
            raise DinerosError(
                f"the traces begin within the run, and channel {channel.id} may have messages without ids",
                hint="keep all parts of the traces",
            )
        if isinstance(channel, sym.ActionChannel):
            raise DinerosError(
                f"the traces begin within the run, and goals of {channel.id} may have been under way",
                hint="keep all parts of the traces",
            )
        if isinstance(channel, sym.TopicChannel):
            _begin_topic(replay, channel, checkpoints)
        elif isinstance(channel, sym.ServiceChannel):
            for client in channel.clients:
                _begin_call(replay, channel, client, checkpoints)
    for bounded, free in net.room.items():
        if bounded in own:
            replay.marking[free] = capacity[bounded] - replay.marking[bounded]


def _begin_topic(replay: Replay, channel: sym.TopicChannel, checkpoints: Checkpoints) -> None:
    topic = replay.net.topics[channel.id]
    for publisher in channel.publishers:
        sender, sent = _sender(publisher.place, checkpoints)
        replay.messages.began(channel.id, sender, sent)
        for place in topic.subscribers:
            checkpoint = checkpoints.get(topic.node_of[place])
            taken = 0 if checkpoint is None else _last_taken(checkpoint, f"{channel.id}/{place}", sender)
            replay.begin_topic(channel.id, sender, place, taken, sent)


def _last_taken(checkpoint: Checkpoint, port: str, sender: str) -> int:
    """Return the number of the last message taken: those before it have come or are lost."""
    ranges = checkpoint.seen_apart.get(port, {}).get(sender, [])
    return max([checkpoint.seen.get(port, {}).get(sender, 0), *(last for _, last in ranges)])


def _begin_call(
    replay: Replay, channel: sym.ServiceChannel, client: sym.ClientPort, checkpoints: Checkpoints
) -> None:
    net = replay.net
    sender, requested = _sender(client.request, checkpoints)
    asking, serving = net.ends_of_call(channel.id, client.client)
    is_pending = asking in checkpoints and f"{channel.id}/{client.client}" in checkpoints[asking].requests
    responded = requested - is_pending
    served, open_at = _served(net.instances, channel.id, sender, checkpoints.get(serving))
    replied = served - (open_at is not None)
    past = Past(requested, served, replied, responded)
    replay.messages.began(channel.id, sender, requested)
    replay.messages.began_calling(channel.id, client.client, sender, past)
    done = min(past)  # whole calls leave nothing between client and server
    for kind, instance, times in (
        (Request, None, requested - done),
        (Serve, 1, replied - done),
        (Reply, 1, replied - done),
        (Serve, open_at, served - replied),
        (Response, None, responded - done),
    ):
        transition = net.service(kind, channel.id, client.client, instance) if times else None
        if transition is not None:
            replay.add_between(transition, times)


def _served(
    instances: Mapping[tuple[str, str], int], channel: str, sender: str, checkpoint: Checkpoint | None
) -> tuple[int, int | None]:
    """Return the number of the last request that was served, and the instance that still serves it."""
    if checkpoint is None:
        return 0, None
    for entry, message in checkpoint.serving.items():
        known = parse_id(message)
        if known is not None and known[0] == sender and (channel, entry) in instances:
            return known[1], instances[channel, entry]
    answered = [parse_id(message) for message in checkpoint.responses.get(channel, {})]
    return max((known[1] for known in answered if known is not None and known[0] == sender), default=0), None


def _sender(place: pn.Place, checkpoints: Checkpoints) -> tuple[str, int]:
    """Return what the ids of a place's messages begin with, and the number of its last message."""
    net = node_net_of(place)
    node = net.id if net is not None else ""
    checkpoint = checkpoints.get(node)
    if checkpoint is None:
        return f"{node}/{place.id}", 0
    run = f"@{checkpoint.run}" if checkpoint.run else ""
    return f"{node}{run}/{place.id}", checkpoint.numbers.get(place.id, 0)


def _first_two(records: Iterable[Record]) -> Iterable[Record]:
    for number, record in enumerate(records):
        yield record
        if number:
            return
