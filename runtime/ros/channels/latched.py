"""A topic with all reliable publishers, including the last value of transient-local ones.

ROS connects a subscription only to publishers that offer the requested quality of service. A subscription
that requests transient local, to get earlier messages, does not match a publisher with the default quality.
So there are two subscriptions from the start: a volatile one for all publishers, and one for the kept
messages of transient-local publishers, which may end soon. New messages of the latter arrive at both and
count once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from dineros.runtime.ros.channels.quality import reliable_quality

KEPT = 128
"""Number of messages remembered to detect copies; more than both histories hold."""


class LatchedTopic:
    """Listens to a topic; `heard` is called with each message."""

    def __init__(self, node: Any, interface: Any, topic: str, heard: Callable[[Any], None]) -> None:
        from rclpy.event_handler import SubscriptionEventCallbacks

        self._node = node
        self._heard = heard
        self._lock = threading.Lock()
        self._messages: dict[tuple[int, int], None] = {}
        self._newest = 0  # sending time of the last message of the volatile subscription
        # Most publishers do not match the second subscription, which is expected and needs no warning; the
        # first one
        # reports other problems of a publisher. Events cost time at each message.
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
        """Deliver a message, unless the other subscription has delivered it or a later one."""
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
        """Stop listening."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._subscriptions.clear()
