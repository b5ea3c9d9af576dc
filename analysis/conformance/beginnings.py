"""Traces that begin in the middle of a run, because their older parts were deleted.

Each trace begins with a checkpoint of its node, at its own moment. The checkpoint has the tokens of the
node's own places. The messages under way between two nodes follow from their numbers: a topic holds for a
subscriber the messages that its publisher had sent, minus those that the subscriber had taken. If the
subscriber's trace begins later than the publisher's, this number may be negative; it becomes zero when the
publisher's trace has advanced. The same applies to the steps of calls, whose effects on the places between
client and server add up in any order.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import islice

from dineros.analysis.conformance.replay import Replay
from dineros.analysis.conformance.services.stages import Before
from dineros.metamodel import pn, sym
from dineros.metamodel.elements import node_net_of
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.message_ids import parse_id
from dineros.metamodel.records import Checkpoint, Header, Record, Reply, Request, Serve

Checkpoints = Mapping[str, Checkpoint]
"""The checkpoint with which the trace of each node begins."""


def beginnings(traces: Mapping[str, Iterable[Record]]) -> dict[str, Checkpoint]:
    """Return the checkpoints with which traces begin; empty if all traces begin with the run.

    Raises
    ------
    DinerosError
        A trace begins neither with the run nor with a header and a checkpoint.
    """
    found: dict[str, Checkpoint] = {}
    is_partial = False
    for node, records in traces.items():
        first = list(islice(records, 2))
        if len(first) == 2 and isinstance(first[0], Header) and isinstance(first[1], Checkpoint):
            found[node] = first[1]
        if first and first[0].sequence != 0:
            is_partial = True
            if node not in found:
                raise DinerosError(
                    f"the trace begins with record {first[0].sequence}",
                    location=first[0].location or Location(),
                    hint="also give the earlier parts",
                )
    return found if is_partial else {}


def begin_within(replay: Replay, checkpoints: Checkpoints) -> None:
    """Initialise a replay at the beginning of the traces.

    Raises
    ------
    DinerosError
        A channel has an existing message type, so that messages under way are unknown if they have no ids; or
        the channel is an action.
    """
    net = replay.net
    capacity = {bounded: replay.marking[bounded] + replay.marking[free] for bounded, free in net.room.items()}
    for node, checkpoint in checkpoints.items():
        for place, index in net.places_of.get(node, {}).items():
            replay.marking[index] = len(checkpoint.marking.get(place, ()))
    for channel in net.model.channels:
        if channel.id in net.typed_channels:
            raise DinerosError(
                f"the traces start in the middle of the run, and channel {channel.id} may have messages "
                "without ids",
                hint="keep all parts of the traces",
            )
        if isinstance(channel, sym.ActionChannel):
            raise DinerosError(
                f"the traces start in the middle of the run, and goals of {channel.id} may have been under "
                "way",
                hint="keep all parts of the traces",
            )
        if isinstance(channel, sym.TopicChannel):
            _begin_topic(replay, channel, checkpoints)
        elif isinstance(channel, sym.ServiceChannel):
            for client in channel.clients:
                _begin_call(replay, channel, client, checkpoints)
    for bounded, free in net.room.items():
        if bounded in net.own_places:
            replay.marking[free] = capacity[bounded] - replay.marking[bounded]


def _begin_topic(replay: Replay, channel: sym.TopicChannel, checkpoints: Checkpoints) -> None:
    topic = replay.net.topics[channel.id]
    for publisher in channel.publishers:
        sender, sent = _sender(publisher.place, checkpoints)
        replay.messages.began(channel.id, sender, sent)
        for place in topic.subscribers:
            checkpoint = checkpoints.get(topic.node_of[place])
            taken = 0 if checkpoint is None else _last_taken(checkpoint, f"{channel.id}/{place}", sender)
            replay.topics.begin(channel.id, sender, place, taken, sent)


def _last_taken(checkpoint: Checkpoint, port: str, sender: str) -> int:
    """Return the number of the last message taken: all messages before it were received or lost."""
    ranges = checkpoint.seen_apart.get(port, {}).get(sender, [])
    return max([checkpoint.seen.get(port, {}).get(sender, 0), *(last for _, last in ranges)])


def _begin_call(
    replay: Replay, channel: sym.ServiceChannel, client: sym.ClientPort, checkpoints: Checkpoints
) -> None:
    net = replay.net
    sender, requested = _sender(client.request, checkpoints)
    asking, serving = net.ends_of_call(channel.id, client.client)
    pending = checkpoints[asking].pending(channel.id, client.client) if asking in checkpoints else []
    before = Before(
        sender,
        requested,
        frozenset(_numbers((request["message"] for request in pending), sender)),
        *_served(net.instances, channel.id, sender, checkpoints.get(serving)),
        gives_up=client.timeout is not None,
    )
    replay.messages.began(channel.id, sender, requested)
    replay.messages.began_calling(channel.id, client.client, before)
    calls = replay.calls
    for number in before.pending:
        stage = before.stage(number)
        calls.begin(Request, channel.id, client.client)
        if stage is not Request:
            calls.begin(Serve, channel.id, client.client, before.serving.get(number, 1))
        if stage is Reply:
            calls.begin(Reply, channel.id, client.client)
    for number in before.serving.keys() - before.pending:
        instance = before.serving[number]
        if not before.is_over(number):
            calls.begin_instance(channel.id, client.client, instance)
        elif before.gives_up:
            calls.begin_late(channel.id, client.client, instance)
        else:
            calls.begin(Request, channel.id, client.client)
            calls.begin(Serve, channel.id, client.client, instance)


def _served(
    instances: Mapping[tuple[str, str], int], channel: str, sender: str, checkpoint: Checkpoint | None
) -> tuple[dict[int, int], frozenset[int]]:
    """Return the requests being served, with their instances, and the last requests that were answered."""
    if checkpoint is None:
        return {}, frozenset()
    serving = {}
    for entry, message in checkpoint.serving.items():
        for number in _numbers([message], sender):
            if (channel, entry) in instances:
                serving[number] = instances[channel, entry]
    return serving, frozenset(_numbers(checkpoint.responses.get(channel, {}), sender))


def _numbers(messages: Iterable[str], sender: str) -> Iterable[int]:
    known = (parse_id(message) for message in messages)
    return (each[1] for each in known if each is not None and each[0] == sender)


def _sender(place: pn.Place, checkpoints: Checkpoints) -> tuple[str, int]:
    """Return the prefix of the ids of a place's messages, and the number of its last message."""
    net = node_net_of(place)
    node = net.id if net is not None else ""
    checkpoint = checkpoints.get(node)
    if checkpoint is None:
        return f"{node}/{place.id}", 0
    run = f"@{checkpoint.run}" if checkpoint.run else ""
    return f"{node}{run}/{place.id}", checkpoint.numbers.get(place.id, 0)
