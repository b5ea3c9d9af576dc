"""A topic of which every reliable publisher is heard, and the last value of those that keep it.

ROS joins a subscription and a publisher only where the publisher offers what the subscription requests: one
that requests transient local, to get what was published before, does not match a publisher with the default
quality of service. So there is a volatile subscription for all, and one for what transient-local publishers
have kept, from the start: they may be gone soon. What they publish live comes by both, and counts once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from dineros.runtime.ros.channels.quality import reliable_quality

KEPT = 128
"""Messages that are remembered, so that none counts twice; more than both histories hold."""


class LatchedTopic:
    """Listens to a topic.

    Parameters
    ----------
    node : rclpy.node.Node
        The ROS node.
    interface : class
        The message's class.
    topic : str
        Its name.
    heard : callable
        Called with each message.
    """

    def __init__(self, node: Any, interface: Any, topic: str, heard: Callable[[Any], None]) -> None:
        from rclpy.event_handler import SubscriptionEventCallbacks

        self._node = node
        self._heard = heard
        self._lock = threading.Lock()
        self._messages: dict[tuple[int, int], None] = {}
        self._newest = 0  # when the last message that came by the volatile subscription was sent
        # That most publishers do not match the second one is as it should be, and nothing to warn of; what
        # else there is to say of a publisher, the first one says. Events cost time at each message.
        no_events = SubscriptionEventCallbacks(use_default_callbacks=False)
        self._subscriptions = [
            node.create_subscription(interface, topic, self._arrived_live, reliable_quality()),
            node.create_subscription(
                interface,
                topic,
                self._arrived_kept,
                reliable_quality(is_kept=True),
                event_callbacks=no_events,
            ),
        ]

    def _arrived_live(self, message: Any, info: Any) -> None:
        self._arrived(message, info, is_live=True)

    def _arrived_kept(self, message: Any, info: Any) -> None:
        self._arrived(message, info, is_live=False)

    def _arrived(self, message: Any, info: Any, *, is_live: bool) -> None:
        """Hand a message on, unless it or a later one came by the other subscription."""
        sent = int(info["source_timestamp"])
        key = sent, int(info["publication_sequence_number"])
        with self._lock:
            is_new = key not in self._messages and (is_live or sent > self._newest)
            if is_live:
                self._newest = max(self._newest, sent)
            self._messages[key] = None
            if len(self._messages) > KEPT:
                del self._messages[next(iter(self._messages))]
        if is_new:
            self._heard(message)

    def close(self) -> None:
        """Listen no more."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._subscriptions.clear()
