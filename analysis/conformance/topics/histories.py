"""Silent steps of topics with histories (rules R1 to R4).

Messages are moved lazily; a message that is never taken counts as lost. A publisher never waits, so its
message must go somewhere: if its writer history is full, the oldest message moves to the reader, or is lost.
It is lost if its subscriber is known never to have taken it; if both histories are full, it is also lost, but
only if nothing else can be replayed, since the subscriber may have taken a message before. A loss in a
subscriber's trace that was not replayed yet is replayed where possible; the next message taken identifies the
sender of the lost one. If several publishers share a history, messages of others may have been taken in
between: before a message is taken from there, all messages known to be lost are lost, and while this is not
known, the take waits until nothing else can be replayed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass
from random import Random

from dineros.analysis.conformance.player import Player
from dineros.analysis.conformance.refusals import Fault, Refusal, Waiting
from dineros.analysis.conformance.topics.fates import Fates
from dineros.analysis.conformance.topics.parts import HistoryTopic, Pair
from dineros.metamodel.records import Drop, Publish, Take


@dataclass(frozen=True)
class _QueueHere:
    """Number of messages of a pair: those that arrive, and those in the history."""

    arriving: int
    load: int

    @property
    def all(self) -> int:
        return self.arriving + self.load


class HistoryFlow:
    """Moves the messages of one topic.

    Parameters
    ----------
    channel : str
        Id of the topic channel.
    draw : Random, optional
        Draws the losses of messages without ids; without it, they are lost when that is recorded.
    """

    def __init__(
        self, player: Player, channel: str, topic: HistoryTopic, fates: Fates, draw: Random | None = None
    ) -> None:
        self.topic = topic
        self._player = player
        self._net, self._marking, self._fire = player.net, player.marking, player.fire
        self._channel = channel
        self._fates = fates
        self._draw = draw
        self._readiness = 0.0 if draw is None else draw.random()  # to lose messages that may be lost
        self._told: Counter[str] = Counter()  # losses in each subscriber's trace so far
        self._under_way: dict[Pair, dict[str, None]] = {pair: {} for pair in topic.pairs}
        self._untold: Counter[Pair] = Counter()  # losses that the subscriber's trace has not reported yet

    def publish(self, record: Publish, transition: int, forced: bool) -> Refusal | None:
        """Write a message into the histories; `forced`: lose an older message if both are full."""
        pairs = self.topic.publishers[record.place]
        for pair in pairs:
            refusal = self._make_way(pair, forced) or self._finds_nobody(pair, record, forced)
            if refusal is not None:
                return refusal
        reason = self._player.why_not(transition)
        if reason:
            return Fault(reason)
        self._fire(transition)
        for pair in pairs:
            if self._is_away(pair) and pair.miss is not None:
                self._fire(pair.miss)
            elif record.message:
                self._under_way[pair][record.message] = None
        return None

    def _is_away(self, pair: Pair) -> bool:
        """Return whether the subscriber of a pair is absent, so that messages published for it are lost."""
        return pair.miss is not None and all(
            self._marking[place] >= weight
            for place, weight in self._net.pre[pair.miss]
            if place != pair.queue.source
        )

    def _finds_nobody(self, pair: Pair, record: Publish, forced: bool) -> Waiting | None:
        """Wait for a subscriber that is absent, but took the message, or may have taken it."""
        if not self._is_away(pair) or (fate := self._fate(pair, record.message or "")):
            return None
        if fate is None and forced:
            return None
        reason = f"{pair.subscriber} of node {self.topic.node_of[pair.subscriber]} does not exist yet"
        return Waiting(reason, (self.topic.node_of[pair.subscriber],), is_forcible=fate is None)

    def _make_way(self, pair: Pair, forced: bool) -> Waiting | None:
        marking, queue, reader = self._marking, pair.queue, self.topic.subscribers[pair.subscriber]
        if marking[queue.source] < 1:
            return None
        if marking[queue.capacity] > 0:
            self._enter(pair)
            return None
        victim = self._victim(pair)
        is_lost = victim is not None or self._is_drawn(pair.subscriber)
        has_way = marking[reader.source] < 1 or marking[reader.capacity] > 0
        has_way = has_way and self._is_there(pair)
        if not is_lost and has_way and (forced or self._are_decided(pair)):
            self._pass_on(pair)
            self._enter(pair)
        elif is_lost or (not has_way and (forced or self._is_left(pair))):
            self._fire(queue.drop)
            self._forget(pair, victim)
            self._untold[pair] += 1
        else:
            reason = f"the {queue.text} is full, and no loss was recorded"
            return Waiting(reason, (self.topic.node_of[pair.subscriber],), is_forcible=True)
        return None

    def _enter(self, pair: Pair) -> None:
        """Put a message into a writer history; a full history drops a message that was delivered."""
        needs = self._net.pre[pair.queue.enter]
        has_room = all(self._marking[place] >= weight for place, weight in needs)
        self._fire(pair.queue.enter if has_room or pair.replace is None else pair.replace)

    def _is_there(self, pair: Pair) -> bool:
        """Return whether messages can be delivered to the subscriber of a pair."""
        return all(
            self._marking[place] >= weight
            for place, weight in self._net.pre[pair.queue.leave]
            if place in self._net.node_of_state
        )

    def _victim(self, pair: Pair) -> str | None:
        """Return a message under way that is never taken."""
        found = (id for id in self._under_way[pair] if self._fate(pair, id))
        return next(found, None)

    def _fate(self, pair: Pair, message: str) -> bool | None:
        return self._fates.is_lost(self._channel, pair.subscriber, message)

    def _are_decided(self, pair: Pair) -> bool:
        return all(self._fate(pair, message) is not None for message in self._under_way[pair])

    def _is_left(self, pair: Pair) -> bool:
        """Return whether none of the messages under way is ever taken, so that no take is awaited."""
        return all(
            self._fates.is_left(self._channel, pair.subscriber, message) for message in self._under_way[pair]
        )

    def _forget(self, pair: Pair, message: str | None) -> None:
        under_way = self._under_way[pair]
        if message not in under_way:
            message = self._victim(pair) or next(iter(under_way), None)
        if message is not None:
            del under_way[message]

    def _pass_on(self, pair: Pair) -> None:
        """Move a message from a writer history to the arrival place of the reader."""
        reader = self.topic.subscribers[pair.subscriber]
        if self._marking[reader.source] >= 1:
            self._fire(reader.enter)
        if self._marking[pair.queue.load] < 1:
            self._enter(pair)
        self._fire(pair.queue.leave)

    def take(self, record: Take, leave: int) -> Refusal | bool:
        """Replay the take of a message; False: none is under way."""
        pairs = self._pairs_of(record)
        self._lose_early(record.place)
        if self._may_have_lost(record.place):
            reason = f"the {self.topic.subscribers[record.place].text} may have lost messages before"
            return Waiting(reason, (self.topic.node_of[record.place],), is_forcible=True)
        if not self._fill(record.place, 1, pairs):
            return False
        reason = self._player.why_not(leave)
        if reason:
            return Fault(reason)
        self._fire(leave)
        if record.message:
            for pair in pairs:
                self._forget(pair, record.message)
        return True

    def drop(self, record: Drop, following: Take | None) -> Refusal | None:
        """Lose the messages that a subscriber's trace reports as lost, except losses replayed already.

        `following`: the message before which they are missing: they are of the same publisher.
        """
        place = record.place or ""
        if record.queue not in ("subscriber", "restart"):
            return Fault(f"a topic of ROS 2 has no {record.queue} queue")
        if self.topic.node_of.get(place) != record.node:
            return Fault(f"{place!r} is not a subscriber of topic channel {record.channel!r}")
        pairs = [] if following is None else self._pairs_of(following)
        pairs = pairs or self._pairs_to(place)
        rest = max(0, record.count - sum(self._untold[pair] for pair in pairs))
        most = self._most_losses(place, pairs)
        if rest > most:
            reader = self.topic.subscribers[place]
            writers = self._net.publishing_nodes[record.channel]
            reason = f"the {reader.text} has lost {record.count}, at most {most} can be lost"
            unclear = self.is_unclear(place)
            in_hindsight = unclear or self._has_several_publishers(place)
            return Waiting(reason, writers, in_hindsight=in_hindsight, unclear=unclear)
        self._told[place] += record.count
        told = record.count - rest
        for pair in pairs:
            told -= (here := min(told, self._untold[pair]))
            self._untold[pair] -= here
        for _ in range(rest):
            self._lose(place, pairs)
        return None

    def _most_losses(self, place: str, pairs: Collection[Pair]) -> int:
        """Return how many messages to a subscriber can be lost now, at the subscriber or by these pairs."""
        reader, marking = self.topic.subscribers[place], self._marking
        lost, at_reader = 0, marking[reader.source] + marking[reader.load]
        for pair in self._pairs_to(place):
            here = self._here(pair)
            if pair.lose is not None and pair in pairs:
                lost += here.all
            else:
                overflows = pair in pairs and here.arriving >= 1 and here.load >= pair.queue.limit
                lost += overflows
                at_reader += here.all - overflows
        return lost + max(0, at_reader - reader.limit)

    def _lose(self, place: str, pairs: Collection[Pair]) -> None:
        reader, marking = self.topic.subscribers[place], self._marking
        for pair in pairs:
            here = self._here(pair)
            if pair.lose is not None and here.all >= 1:
                if here.load < 1:
                    self._enter(pair)
                self._fire(pair.lose)
            elif pair.lose is None and here.arriving >= 1 and here.load >= pair.queue.limit:
                self._fire(pair.queue.drop)
            else:
                continue
            self._forget(pair, None)
            return
        self._fill(place, reader.limit, pairs)
        if marking[reader.source] < 1:
            self._supply(place, pairs)
        self._fire(reader.drop)
        self._forget(min(pairs, key=lambda pair: self._victim(pair) is None), None)

    def _lose_early(self, place: str) -> None:
        """Let a full history lose messages that are known to be lost, as early as possible.

        The subscriber's trace reports a loss with the next message of the same publisher; other messages may
        have been taken after the loss and before that record. An early loss needs no other messages
        afterwards.
        """
        pairs = self._pairs_to(place)
        while pair := next((pair for pair in pairs if self._victim(pair) is not None), None):
            if not self._is_too_much(place):
                return
            self._overflow(pair)
        while self._is_too_much(place) and self._is_drawn(place):
            self._overflow(next((pair for pair in pairs if self._here(pair).all), pairs[0]))

    def _overflow(self, pair: Pair) -> None:
        """Let a history with too many messages under way lose one, before that is recorded."""
        reader = self.topic.subscribers[pair.subscriber]
        self._fill(pair.subscriber, reader.limit, [pair])
        if self._marking[reader.source] < 1:
            self._supply(pair.subscriber, [pair])
        self._fire(reader.drop)
        self._forget(pair, self._victim(pair))
        self._untold[pair] += 1

    def _is_drawn(self, place: str) -> bool:
        """Draw whether a loss that is recorded later happens now, if its sender is unknown."""
        if self._draw is None or not self._fates.are_nameless(self._channel, place):
            return False
        untold = sum(self._untold[pair] for pair in self._pairs_to(place))
        left = self._fates.told[self._channel, place] - self._told[place] - untold
        return left > 0 and self._draw.random() < self._readiness

    def is_unclear(self, place: str) -> bool:
        """Return whether a step might fit if other messages without ids had been lost."""
        is_nameless = self._fates.are_nameless(self._channel, place)
        return is_nameless and self._fates.may_lose_what_it_tells(self._channel, place)

    def _may_have_lost(self, place: str) -> bool:
        """Return whether a history of several publishers may have lost a message not known to be lost."""
        is_decided = all(map(self._are_decided, self._pairs_to(place)))
        return self._has_several_publishers(place) and not is_decided and self._is_too_much(place)

    def _has_several_publishers(self, place: str) -> bool:
        """Return whether messages of several publishers wait in a subscriber's history."""
        return len(self._pairs_to(place)) > 1

    def _is_too_much(self, place: str) -> bool:
        """Return whether more messages are under way to a subscriber than its history holds."""
        reader = self.topic.subscribers[place]
        there = self._marking[reader.source] + self._marking[reader.load]
        return there + sum(self._here(pair).all for pair in self._pairs_to(place)) > reader.limit

    def _fill(self, place: str, load: int, first: Collection[Pair]) -> bool:
        """Fill a reader history up to a load, from some pairs first; False: too few are under way."""
        reader, marking = self.topic.subscribers[place], self._marking
        while marking[reader.load] < load:
            if marking[reader.source] < 1 and not self._supply(place, first):
                return False
            self._fire(reader.enter)
        return True

    def _supply(self, place: str, first: Collection[Pair]) -> bool:
        """Let a message arrive at a reader, preferably from some pairs; False: none is under way."""
        pairs = sorted(self._pairs_to(place), key=lambda pair: pair not in first)
        pair = next((pair for pair in pairs if self._here(pair).all >= 1), None)
        if pair is not None:
            self._pass_on(pair)
        return pair is not None

    def _here(self, pair: Pair) -> _QueueHere:
        """Return the counts of a pair; negative counts at the beginning of traces are clamped to 0."""
        return _QueueHere(max(0, self._marking[pair.queue.source]), self._marking[pair.queue.load])

    def _pairs_of(self, record: Take) -> list[Pair]:
        """Return the pairs through which a message has passed; empty if its id does not identify them."""
        sender = (record.message or "").rpartition("/")[0].rpartition("/")[2]
        return [pair for pair in self._pairs_to(record.place) if pair.publisher == sender]

    def _pairs_to(self, place: str) -> list[Pair]:
        return [pair for pair in self.topic.pairs if pair.subscriber == place]

    def begin(self, sender: str, place: str, taken: int, sent: int) -> None:
        """Initialise the messages from a sender to a subscriber where traces begin; the excess is lost."""
        publisher = sender.rpartition("/")[2]
        for pair in (pair for pair in self._pairs_to(place) if publisher == pair.publisher):
            marking, reader, count = self._marking, self.topic.subscribers[place], sent - taken
            if count < 0:  # positive later, when the sender's trace has advanced
                marking[pair.queue.source] += count
                marking[self._net.room[pair.queue.source]] -= count
                return
            for queue in (reader, pair.queue):
                held = min(count, marking[queue.capacity])
                marking[queue.load] += held
                marking[queue.capacity] -= held
                count -= held
                if count and marking[queue.source] < 1:
                    marking[queue.source] += 1
                    marking[self._net.room[queue.source]] -= 1
                    count -= 1
            self._untold[pair] += count
            first = taken + count + 1
            self._under_way[pair] |= {f"{sender}/{number}": None for number in range(first, sent + 1)}
