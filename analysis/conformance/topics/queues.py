"""Silent steps of topics with queues: messages are moved only when needed, as few as possible.

A message that has not been moved still fills its queue. So moving as late as possible keeps all drops
possible that any other choice would. The only real choice is which of several publishers' queues gives the
next message; queues in `keep`, whose drops are still to come, give last.
"""

from __future__ import annotations

from collections.abc import Callable, Collection

from dineros.analysis.conformance.player import Player
from dineros.analysis.conformance.topics.parts import Queue, Topic


class TopicFlow:
    """Moves messages of one topic.

    `keep`: places of publishers whose queues should stay as full as possible.
    """

    def __init__(self, player: Player, topic: Topic, keep: Collection[str] = ()) -> None:
        self.topic = topic
        self._marking, self._fire = player.marking, player.fire
        kept = {topic.publishers[place].load for place in keep if place in topic.publishers}
        self._keep = keep = {place for place, queue in topic.publishers.items() if queue.load in kept}
        self._sources = sorted(topic.publishers.items(), key=lambda item: item[0] in keep)

    def publish(self, place: str) -> None:
        """Put a message into a publisher's queue; if the queue is full, its first message leaves."""
        queue = self.topic.publishers[place]
        if not self._marking[queue.capacity]:
            self._fire(queue.leave)
        self._fire(queue.enter)

    def is_full(self, place: str) -> bool:
        """Return whether a publisher's queue is full."""
        queue = self.topic.publishers[place]
        return self._marking[queue.load] >= queue.limit

    def under_way_to_node(self, node: str) -> int:
        """Return the number of messages before or in the dispatcher queue of a node net."""
        queue = self.topic.dispatchers[node]
        loads = {publisher.load for publisher in self.topic.publishers.values()}
        sent = sum(self._marking[load] for load in loads)
        return sent + self._marking[self.topic.place] + self._in(queue)

    def under_way(self, place: str) -> int:
        """Return the number of messages that a subscriber can still take."""
        return self.under_way_to_node(self.topic.node_of[place]) + self._in(self.topic.subscribers[place])

    def take(self, place: str, publisher: str | None) -> bool:
        """Replay the take of a message, if possible one from a given publisher's place."""
        if not self.under_way(place):
            return False
        self._fill(self.topic.subscribers[place], 1, self._to_subscriber(place, publisher))
        self._fire(self.topic.subscribers[place].leave)
        return True

    def drop_at_subscriber(self, place: str) -> bool:
        """Let the full queue of a subscriber drop a message."""
        queue = self.topic.subscribers[place]
        if self.under_way(place) <= queue.limit:
            return False
        self._overflow(queue, self._to_subscriber(place, None))
        return True

    def drop_at_dispatcher(self, node: str) -> bool:
        """Let the full dispatcher queue of a node net drop a message."""
        queue = self.topic.dispatchers[node]
        if self.under_way_to_node(node) <= queue.limit:
            return False
        self._overflow(queue, lambda: self._to_dispatchers(None))
        return True

    def _in(self, queue: Queue) -> int:
        return self._marking[queue.source] + self._marking[queue.load]

    def _overflow(self, queue: Queue, supply: Callable[[], None]) -> None:
        self._fill(queue, queue.limit, supply)
        while self._marking[queue.source] <= 0:
            supply()
        self._fire(queue.drop)

    def _fill(self, queue: Queue, load: int, supply: Callable[[], None]) -> None:
        while self._marking[queue.load] < load:
            while self._marking[queue.source] <= 0:  # may be negative: see `beginnings`
                supply()
            self._fire(queue.enter)

    def _to_subscriber(self, place: str, publisher: str | None) -> Callable[[], None]:
        dispatcher = self.topic.dispatchers[self.topic.node_of[place]]

        def supply() -> None:
            self._fill(dispatcher, 1, lambda: self._to_dispatchers(publisher))
            self._fire(dispatcher.leave)

        return supply

    def _to_dispatchers(self, publisher: str | None) -> None:
        if not self._marking[self.topic.place]:
            sources = [(place, queue) for place, queue in self._sources if self._marking[queue.load]]
            chosen = next(
                (queue for place, queue in sources if place == publisher and place not in self._keep),
                sources[0][1],
            )
            self._fire(chosen.leave)
        self._fire(self.topic.transport)
