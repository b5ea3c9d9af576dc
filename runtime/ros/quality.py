"""Quality of service: what the model says of a port, as rclpy wants it.

The limit of a queue is the depth of the history that ROS keeps. Where it is full ROS overwrites the oldest
message, the paper's queue drops the newest: as many tokens are lost, but not the same ones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from dineros.runtime.transport import PublisherPort, SubscriberPort

SERVICE_DEPTH = 100
"""Requests that wait for a callback, which takes them at once; ROS's 10 would lose some of a burst."""


def topic_quality(port: PublisherPort | SubscriberPort) -> Any:
    """Return the QoS profile of a port."""
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=max(1, port.limit),
        reliability=(
            ReliabilityPolicy.BEST_EFFORT if port.reliability == "bestEffort" else ReliabilityPolicy.RELIABLE
        ),
        durability=(
            DurabilityPolicy.TRANSIENT_LOCAL
            if port.durability == "transientLocal"
            else DurabilityPolicy.VOLATILE
        ),
    )


def signal_quality() -> Any:
    """Return the QoS profile of a signal's topic: whoever comes later gets the last value."""
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    return QoSProfile(
        depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
    )


def service_quality() -> Any:
    """Return the QoS profile of services."""
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    return QoSProfile(
        depth=SERVICE_DEPTH, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.VOLATILE
    )


class LossCounter:
    """Counts the messages of a topic that did not come.

    Each publisher numbers its messages from 1, and rclpy tells the number; whose message it is tells its id.
    What was sent before this node came, or while it was down, is lost to it as well.

    Parameters
    ----------
    seen : mapping of str to int, optional
        Of each sender (a message's id without its number), the number of the last message of an earlier life.
    """

    def __init__(self, seen: Mapping[str, int] | None = None) -> None:
        self._last = {sender: (0, number) for sender, number in (seen or {}).items()}

    def lost_before(self, message_id: str, sequence: int, publishers: Callable[[], int]) -> int:
        """Return how many messages are missing just before this one.

        Parameters
        ----------
        message_id : str
            Its id; empty where the publisher gives none.
        sequence : int
            Its number among the messages of its publisher.
        publishers : callable
            Tells how many publishers there are: without ids, several cannot be told apart, and nothing is
            counted.
        """
        sender, _, text = message_id.rpartition("/")
        number = int(text) if text.isdecimal() else 0
        last, last_number = self._last.get(sender, (0, 0))
        self._last[sender] = (sequence, number)
        missing = sequence - last - 1
        if missing <= 0:
            return 0
        if sender:
            # A publisher that began anew counts anew, and may be ahead of its predecessor; the ids go on.
            return max(0, min(missing, number - last_number - 1))
        return missing if last and publishers() == 1 else 0
