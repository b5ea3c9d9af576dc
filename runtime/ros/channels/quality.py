"""Quality of service of a port as rclpy needs it.

The limit of a queue is the depth of its ROS history. A full ROS history overwrites the oldest message, the
paper's queue drops the newest one: the number of lost tokens is the same, but not the tokens.
"""

from __future__ import annotations

import contextlib
import time
from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from dineros.metamodel.message_ids import MessageIdError, parse_id
from dineros.metamodel.ros_names import resource_names, snake_case
from dineros.runtime.nets.ports import PublisherPort, SubscriberPort

SENDER_LIMIT = 256
"""Number of senders whose messages are counted; the most recent ones are kept."""

SKIP_LIMIT = 1 << 20
"""Maximum plausible number of messages lost at a restart of their publisher; larger gaps are forged ids."""

SERVICE_DEPTH = 100
"""Requests that wait for their callback, which takes them at once; ROS's default of 10 would lose bursts."""

KEPT_BY_PUBLISHERS = 10
"""Assumed history depth of a publisher whose subscriber's history is smaller: the default of ROS."""


def most_known(limit: int, seen: Mapping[str, int]) -> int:
    """Return the most messages, already received before a restart, that are sent to a subscriber again.

    Publishers that continue send all messages that they keep, since they do not know which were received.
    These arrive at once, so a history of only the port's depth would lose new messages to known ones.

    Parameters
    ----------
    limit : int
        Depth of the subscriber's history; the depths of its publishers are not known here.
    seen : mapping of str to int
        For each sender, the number of its last message.
    """
    return sum(min(number, max(limit, KEPT_BY_PUBLISHERS)) for number in seen.values())


def topic_quality(port: PublisherPort | SubscriberPort, known: int = 0) -> Any:
    """Return the QoS profile of a port; its history has additional room for known messages."""
    from rclpy.duration import Duration
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

    quality = port.quality
    times = {
        "deadline": quality.deadline,
        "lifespan": quality.lifespan,
        "liveliness_lease_duration": quality.lease_duration,
    }
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=max(1, port.limit + known),
        # The values of the model are those of ROS, written differently.
        reliability=ReliabilityPolicy[snake_case(quality.reliability).upper()],
        durability=DurabilityPolicy[snake_case(quality.durability).upper()],
        liveliness=LivelinessPolicy[snake_case(quality.liveliness).upper()],
        **{name: Duration(seconds=seconds) for name, seconds in times.items() if seconds is not None},
    )


def overriding_options(port: PublisherPort | SubscriberPort) -> Any:
    """Let parameters such as ``qos_overrides.TOPIC.publisher_PLACE.depth`` change the quality of a port.

    This covers all policies that decide whether two ends match, and the others that the model sets.
    """
    from rclpy.qos import QoSPolicyKind as Kind
    from rclpy.qos_overriding_options import QoSOverridingOptions

    kinds = [Kind.HISTORY, Kind.DEPTH, Kind.RELIABILITY, Kind.DURABILITY]
    quality = port.quality
    more = {
        Kind.LIVELINESS: quality.liveliness != "automatic",
        Kind.DEADLINE: quality.deadline is not None,
        Kind.LIVELINESS_LEASE_DURATION: quality.lease_duration is not None,
        Kind.LIFESPAN: quality.lifespan is not None,
    }
    kinds += [kind for kind, is_said in more.items() if is_said]
    return QoSOverridingOptions(kinds, entity_id=resource_names([port.place])[port.place])


def reliable_quality(depth: int = 10, *, is_kept: bool = False) -> Any:
    """Return the QoS profile of a topic or service that loses no message in transit.

    Parameters
    ----------
    depth : int
        Depth of its history; by default that of ROS.
    is_kept : bool
        Whether late subscribers get earlier messages.
    """
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    durability = DurabilityPolicy.TRANSIENT_LOCAL if is_kept else DurabilityPolicy.VOLATILE
    return QoSProfile(depth=depth, reliability=ReliabilityPolicy.RELIABLE, durability=durability)


def companion_depth(limit: int) -> int:
    """Return the depth of a companion topic, sufficient for all messages that wait on the topic itself."""
    return 2 * max(1, limit) + 16


class LossCounter:
    """Counts the lost messages of a topic.

    Each publisher numbers its messages from 1, and rclpy reports the number; the id of a message identifies
    its sender. Messages sent before this node started, or while it was down, also count as lost.

    Ids are untrusted text, since any program can publish. So an id is believed only as far as it is
    plausible: there are no more senders than publishers, the numbers in a sender's ids advance with those of
    its publisher, and a sender whose earlier publisher continues has not restarted.

    Parameters
    ----------
    seen : mapping of str to int, optional
        For each sender (a message id without its number), the number of its last message before a restart.
    is_resumed : bool
        Whether this node was restarted: then a sender that also was may have sent messages to it before.
    """

    def __init__(self, seen: Mapping[str, int] | None = None, *, is_resumed: bool = False) -> None:
        self._is_resumed = is_resumed
        # For each sender: the publisher's number of its last message, the number in that id, its highest
        # number.
        self._last: dict[str, tuple[int, int, int]] = {
            sender: (0, number, number) for sender, number in (seen or {}).items()
        }
        self._heard: dict[str, None] = {}
        # For senders that seem to have restarted: the numbers of their earlier publishers.
        self._before: dict[str, tuple[int, int]] = {}
        self._contested: dict[str, None] = {}

    def lost_at_restart(
        self, message_id: str, sequence: int, publishers: Callable[[], int] = lambda: 0
    ) -> int:
        """Return how many messages of a restarted publisher are missing before this one.

        The publisher sends the messages in its queue again, so its ids continue without a gap, unless more
        messages were under way than the queue holds. Call it before `lost_before`, which counts gaps of its
        numbers. If this node was restarted too, it may not have received any message of the sender yet.

        Parameters
        ----------
        message_id, sequence, publishers
            See `lost_before`.
        """
        with contextlib.suppress(MessageIdError):
            sender, number = parse_id(message_id) or ("", 0)
            last, _, highest = self._last.get(sender, (0, 0, 0))
            skipped = number - highest - 1
            if sender in self._contested:
                return 0
            if highest and 0 < skipped <= SKIP_LIMIT and (sequence <= last or not last):
                return max(0, skipped - (sequence - 1 if not last else 0))
            is_new = self._is_resumed and bool(sender) and sender not in self._last
            # A publisher has one sender: more senders than publishers are forged.
            if is_new and 0 < number - sequence <= SKIP_LIMIT and len(self._heard) < publishers():
                return number - sequence
        return 0

    def lost_before(self, message_id: str, sequence: int, publishers: Callable[[], int]) -> int:
        """Return how many messages are missing just before this one.

        Parameters
        ----------
        message_id : str
            Its id; empty if the publisher gives none.
        sequence : int
            Its number among the messages of its publisher.
        publishers : callable
            Returns the number of publishers. Without ids, several publishers cannot be distinguished, so
            nothing is counted; and there cannot be more senders than publishers.
        """
        try:
            sender, number = parse_id(message_id) or ("", 0)
        except MessageIdError:
            return 0
        is_known = sender in self._last
        last, last_number, highest = self._last.pop(sender, (0, 0, 0))
        # A restarted publisher may send earlier messages again. A message that fits neither this publisher
        # nor its
        # predecessor comes from another one that uses its ids.
        is_step = sequence <= last or not last or number - last_number == sequence - last
        self._contest(sender, sequence, number, (last, last_number))
        self._last[sender] = (sequence, number, max(highest, number) if is_step else highest)
        self._heard[sender] = None
        for known in (self._last, self._heard, self._before, self._contested):
            if len(known) > SENDER_LIMIT:
                del known[next(iter(known))]
        missing = sequence - last - 1
        if missing <= 0:
            return 0
        if not sender:
            return missing if last and publishers() == 1 else 0
        skipped = number - highest - 1
        if not is_step or (missing > skipped and (last or not is_known)):
            return 0  # a publisher counts its messages: another one uses its ids
        if not is_known and len(self._heard) > publishers():
            return 0  # a publisher has one sender: some senders are forged
        # A restarted publisher counts from 1, and may be ahead of its predecessor; the ids continue.
        return max(0, min(missing, skipped))

    def _contest(self, sender: str, sequence: int, number: int, last: tuple[int, int]) -> None:
        """Record a sender that seems to have restarted, and one whose earlier publisher still continues."""
        before = self._before.get(sender)
        if before is not None and sequence - before[0] == number - before[1] > 0:
            del self._before[sender]
            self._contested[sender] = None
        elif last[0] and sequence <= last[0]:
            self._before.setdefault(sender, last)


class FillMeter:
    """Determines the fill level of a subscription's history, which rclpy does not report.

    Each message has the time when the middleware received it. Messages taken after that time were waiting
    when it arrived. So the fill level is known exactly, but only afterwards.

    Parameters
    ----------
    depth : int
        Depth of the history.
    """

    def __init__(self, depth: int) -> None:
        self._taken: deque[int] = deque(maxlen=max(1, depth))
        self._most = 0
        self.waited = 0.0
        """Seconds that the message taken last had waited."""

    def took(self, received: int) -> None:
        """Record that a message is taken now; `received`: its arrival, in nanoseconds since the epoch."""
        if received <= 0:  # the middleware does not report it
            return
        self.waited = max(0.0, (time.time_ns() - received) / 1e9)
        waiting = 1 + len(self._taken) - bisect_right(self._taken, received)
        self._taken.append(time.time_ns())
        if waiting > self._most:
            self._most = min(waiting, self._taken.maxlen or waiting)

    def most_since(self) -> int:
        """Return the most messages that waited at once since the last call."""
        most, self._most = self._most, 0
        return most
