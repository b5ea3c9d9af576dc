"""Replays the steps of topics (publish, take and drop) by the rules of both middlewares."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import partial
from random import Random

from dineros.analysis.conformance.messages import Messages
from dineros.analysis.conformance.player import Player
from dineros.analysis.conformance.refusals import Fault, Refusal, Waiting
from dineros.analysis.conformance.topics.fates import Fates
from dineros.analysis.conformance.topics.histories import HistoryFlow
from dineros.analysis.conformance.topics.parts import HistoryTopic
from dineros.analysis.conformance.topics.queues import TopicFlow
from dineros.metamodel.records import Drop, Publish, Record, Take


class Topics:
    """The messages of all topics.

    Parameters
    ----------
    keep : collection of (str, str)
        Channel and place of publishers whose queues should stay as full as possible.
    draw : Random, optional
        Draws decisions about messages without ids.
    """

    def __init__(
        self,
        player: Player,
        messages: Messages,
        keep: Collection[tuple[str, str]],
        fates: Fates,
        draw: Random | None,
    ) -> None:
        self._net, self._marking = player.net, player.marking
        self._messages = messages
        self._player = player
        self._flows: dict[str, TopicFlow] = {}
        self._histories: dict[str, HistoryFlow] = {}
        self._nameless: set[str] = set()
        for channel, topic in player.net.topics.items():
            if isinstance(topic, HistoryTopic):
                self._histories[channel] = HistoryFlow(player, channel, topic, fates, draw)
            else:
                kept = {place for other, place in keep if other == channel}
                self._flows[channel] = TopicFlow(player, topic, kept)

    def is_full(self, record: Publish) -> bool:
        """Return whether the queue of a publisher is full."""
        flow = self._flows.get(record.channel)
        return flow is not None and record.place in flow.topic.publishers and flow.is_full(record.place)

    def lose(self, record: Record) -> None:
        """Lose messages although no queue was full, to continue after a deviation."""
        assert isinstance(record, (Publish, Drop))
        if record.channel in self._histories:
            assert isinstance(record, Drop)
            self._messages.dropped(record)
            return
        queue = self._flows[record.channel].topic.publishers[record.place or ""]
        self._marking[queue.source] -= 1
        if isinstance(record, Publish):
            self._messages.sent(record)

    def begin(self, channel: str, sender: str, place: str, taken: int, sent: int) -> None:
        """Put the messages on a topic that were sent and not taken before the traces begin."""
        self._messages.began_taking(channel, place, sender, taken)
        if channel in self._histories:
            self._histories[channel].begin(sender, place, taken, sent)
        else:
            self._marking[self._flows[channel].topic.subscribers[place].source] += sent - taken

    def publish(self, record: Publish, dropped: bool, forced: bool) -> Refusal | None:
        """Publish a message; `dropped`: a queue lost it; `forced`: a history may lose another one for it."""
        enter = self._net.end(Publish, record.channel, record.place)
        if enter is None:
            return Fault(f"{record.place} is not a publisher of topic channel {record.channel!r}")
        refusal = self._player.at(record, enter) or self._messages.may_send(record)
        histories = self._histories.get(record.channel)
        if refusal is None and histories is not None:
            refusal = histories.publish(record, enter, forced)
            if refusal is None:
                self._messages.sent(record)
            return refusal
        if refusal is not None:
            return refusal
        flow = self._flows[record.channel]
        queue = flow.topic.publishers[record.place]
        if not self._marking[queue.source]:
            return Fault(f"{record.place} holds no token, 1 needed")
        if dropped:
            if not flow.is_full(record.place):
                full = f"{self._marking[queue.load]} of {queue.limit}"
                return Fault(f"the {queue.text} was not full ({full}) when it dropped it", record.place)
            self._player.fire(queue.drop)
        else:
            flow.publish(record.place)
        self._messages.sent(record)
        return None

    def take(self, record: Take) -> Refusal | None:
        """Let a subscriber take a message."""
        leave = self._net.end(Take, record.channel, record.place)
        if leave is None:
            return Fault(f"{record.place} is not a subscriber of topic channel {record.channel!r}")
        refusal = self._player.at(record, leave) or self._messages.may_take(record)
        if refusal is not None:
            return refusal
        taken = self._take_from(record, leave)
        if isinstance(taken, (Fault, Waiting)):
            return taken
        if not taken:
            outside = (
                f"a program outside of the model also publishes on {self._net.names_in_ros[record.channel]}"
            )
            return Waiting(
                "no message of the model is under way to it",
                self._net.publishing_nodes[record.channel],
                # An earlier message without an id may have been taken for this one.
                outside if not record.message or record.channel in self._nameless else "",
                unclear=record.channel in self._histories
                and self._histories[record.channel].is_unclear(record.place),
            )
        if not record.message:
            self._nameless.add(record.channel)
        self._messages.taken(record)
        return None

    def _take_from(self, record: Take, leave: int) -> Refusal | bool:
        histories = self._histories.get(record.channel)
        if histories is not None:
            return histories.take(record, leave)
        reason = _without_room(self._player, leave)
        if reason:
            return Fault(reason)
        sender = (record.message or "").rpartition("/")[0].rpartition("/")[2]
        ports = self._net.ports
        places = self._flows[record.channel].topic.publishers
        publisher = next((place for place in places if ports[record.channel, place] == sender), None)
        return self._flows[record.channel].take(record.place, publisher)

    def drop(self, record: Drop, following: Record | None) -> Refusal | None:
        """Lose messages according to a record of losses in a queue or a history."""
        if record.channel not in self._net.topics:
            return Fault(f"the model has no topic channel {record.channel!r}")
        if record.queue == "inactive":
            discards = self._net.discarding(record)
            if not discards:
                return Fault("no such publisher has a lifecycle")
            chosen = next(filter(self._player.is_enabled, discards), discards[0])
            return self._player.fire_recorded(record, chosen)
        if record.channel in self._histories:
            return self._drop_from_history(record, following)
        if record.queue == "restart":
            self._messages.dropped(record)
            return Fault(_RESTARTED)
        flow = self._flows[record.channel]
        if record.queue == "publisher":
            return self._drop_at_publisher(flow, record)
        return self._drop_at_receiver(flow, record)

    def _drop_at_receiver(self, flow: TopicFlow, record: Drop) -> Refusal | None:
        if record.queue == "subscriber":
            place = record.place or ""
            if flow.topic.node_of.get(place) != record.node:
                return Fault(f"{place!r} is not a subscriber of topic channel {record.channel!r}")
            queue, count = flow.topic.subscribers[place], flow.under_way(place)
            drop = partial(flow.drop_at_subscriber, place)
        else:
            node = record.node or ""
            if node not in flow.topic.dispatchers:
                return Fault(f"node {node} has no subscriber of topic channel {record.channel!r}")
            queue, count = flow.topic.dispatchers[node], flow.under_way_to_node(node)
            drop = partial(flow.drop_at_dispatcher, node)
        if count < queue.limit + record.count:
            reason = (
                f"the {queue.text} was not full: at most {count} messages were under way to its {queue.limit}"
            )
            return Waiting(reason, self._net.publishing_nodes[record.channel])
        for _ in range(record.count):
            assert drop()
        self._messages.dropped(record)
        return None

    def _drop_from_history(self, record: Drop, following: Record | None) -> Refusal | None:
        """Lose messages of a history, including those under way to a publisher's readers when it ended."""
        at = record.channel, record.place
        if not isinstance(following, Take) or (following.channel, following.place) != at:
            following = None
        if following is not None and isinstance(early := self._messages.may_take(following), Waiting):
            return early  # the lost message was sent before the following one
        refusal = self._histories[record.channel].drop(record, following)
        if isinstance(refusal, Waiting) and record.queue == "restart":
            refusal = replace(refusal, reason=_RESTARTED)
        if refusal is None:
            self._messages.dropped(record)
        return refusal

    def _drop_at_publisher(self, flow: TopicFlow, record: Drop) -> Refusal | None:
        if not any(record.change.values()):
            self._messages.dropped(record)
            return None  # their losses were replayed when they were published
        queue = flow.topic.publishers.get(record.place or "")
        if queue is None:
            return Fault(f"{record.place!r} is not a publisher of topic channel {record.channel!r}")
        if self._marking[queue.load] < queue.limit:
            full = f"{self._marking[queue.load]} of {queue.limit}"
            return Fault(f"the {queue.text} was not full ({full})", record.place)
        return self._player.fire_recorded(record, queue.drop)


def _without_room(player: Player, leave: int) -> str:
    """Return why a message cannot leave a queue for its place; empty if the place has room."""
    short = {place for place, weight in player.net.pre[leave] if player.marking[place] < weight}
    return player.why_not(leave) if short & set(player.net.room.values()) else ""


_RESTARTED = (
    "the publisher was restarted, and had sent more messages in the meantime than its queue holds: "
    "a larger limit of the queue helps"
)
