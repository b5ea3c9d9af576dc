"""Quality of service: what the model says of a port, as rclpy wants it.

The limit of a queue is the depth of the history that ROS keeps. Where it is full ROS overwrites the oldest
message, the paper's queue drops the newest: as many tokens are lost, but not the same ones.
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
"""Senders whose messages are counted, those heard last."""

SKIP_LIMIT = 1 << 20
"""Messages that can be told lost at a restart of their publisher: greater gaps have been forged."""

SERVICE_DEPTH = 100
"""Requests that wait for a callback, which takes them at once; ROS's 10 would lose some of a burst."""

KEPT_BY_PUBLISHERS = 10
"""Messages that a publisher is taken to keep where its subscriber keeps fewer: ROS's depth by default."""


def most_known(limit: int, seen: Mapping[str, int]) -> int:
    """Return how many messages that a subscriber has seen in an earlier life are sent to it again, at most.

    Publishers that continue send what they keep, as they cannot know what was taken. All of it comes at once,
    so that a history of the port's depth would lose what is new for what is known.

    Parameters
    ----------
    limit : int
        Depth of the subscriber's history; how deep those of its publishers are is not known here.
    seen : mapping of str to int
        Of each sender, the number of the last message.
    """
    return sum(min(number, max(limit, KEPT_BY_PUBLISHERS)) for number in seen.values())


def topic_quality(port: PublisherPort | SubscriberPort, known: int = 0) -> Any:
    """Return the QoS profile of a port; its history has room for messages that are known, besides."""
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
        # The model's words are ROS's, in another case.
        reliability=ReliabilityPolicy[snake_case(quality.reliability).upper()],
        durability=DurabilityPolicy[snake_case(quality.durability).upper()],
        liveliness=LivelinessPolicy[snake_case(quality.liveliness).upper()],
        **{name: Duration(seconds=seconds) for name, seconds in times.items() if seconds is not None},
    )


def overriding_options(port: PublisherPort | SubscriberPort) -> Any:
    """Let parameters such as ``qos_overrides.TOPIC.publisher_PLACE.depth`` change the quality of a port.

    All of it that matters for whether it matches others, and what else the model says of it.
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
    """Return the QoS profile of a topic or service on which nothing is lost on the way.

    Parameters
    ----------
    depth : int
        Of its history; the usual one is that of ROS.
    is_kept : bool
        Whether who comes later gets what was published before.
    """
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    durability = DurabilityPolicy.TRANSIENT_LOCAL if is_kept else DurabilityPolicy.VOLATILE
    return QoSProfile(depth=depth, reliability=ReliabilityPolicy.RELIABLE, durability=durability)


def companion_depth(limit: int) -> int:
    """Return the depth of a companion topic: what waits on the topic itself is always announced."""
    return 2 * max(1, limit) + 16


class LossCounter:
    """Counts the messages of a topic that did not come.

    Each publisher numbers its messages from 1, and rclpy tells the number; whose message it is tells its id.
    What was sent before this node came, or while it was down, is lost to it as well.

    Ids are only text, and anybody can publish. So what an id says is believed as far as it fits: there are
    no more senders than publishers, the numbers of a sender's ids keep step with those of its publisher,
    and a sender whose earlier publisher continues has not begun again.

    Parameters
    ----------
    seen : mapping of str to int, optional
        Of each sender (a message's id without its number), the number of the last message of an earlier life.
    """

    def __init__(self, seen: Mapping[str, int] | None = None) -> None:
        # Of each sender: its publisher's number of the last message, that of the id, the highest of its ids.
        self._last: dict[str, tuple[int, int, int]] = {
            sender: (0, number, number) for sender, number in (seen or {}).items()
        }
        self._heard: dict[str, None] = {}
        # Of senders that seem to have begun again: the numbers of their earlier publishers.
        self._before: dict[str, tuple[int, int]] = {}
        self._contested: dict[str, None] = {}

    def lost_at_restart(self, message_id: str, sequence: int) -> int:
        """Return how many messages of a publisher that began again are missing before this one.

        It publishes again what its queue held, so that its ids continue without a gap, unless more was under
        way than the queue holds. To be asked before `lost_before`, which counts the gaps of its numbers.
        """
        with contextlib.suppress(MessageIdError):
            sender, number = parse_id(message_id) or ("", 0)
            last, _, highest = self._last.get(sender, (0, 0, 0))
            skipped = number - highest - 1
            if sender in self._contested:
                return 0
            if highest and 0 < skipped <= SKIP_LIMIT and (sequence <= last or not last):
                return max(0, skipped - (sequence - 1 if not last else 0))
        return 0

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
            counted; and there are no more senders.
        """
        try:
            sender, number = parse_id(message_id) or ("", 0)
        except MessageIdError:
            return 0
        is_known = sender in self._last
        last, last_number, highest = self._last.pop(sender, (0, 0, 0))
        # A publisher that began again may send again what came before. What keeps step with neither it nor
        # its
        # predecessor is another one that uses its ids.
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
            return 0  # a publisher counts what it numbers: this is another one that uses its ids
        if not is_known and len(self._heard) > publishers():
            return 0  # a publisher has one sender: some of them are made up
        # A publisher that began again counts again, and may be ahead of its predecessor; the ids continue.
        return max(0, min(missing, skipped))

    def _contest(self, sender: str, sequence: int, number: int, last: tuple[int, int]) -> None:
        """Note a sender that seems to have begun again, and one whose earlier publisher still continues."""
        before = self._before.get(sender)
        if before is not None and sequence - before[0] == number - before[1] > 0:
            del self._before[sender]
            self._contested[sender] = None
        elif last[0] and sequence <= last[0]:
            self._before.setdefault(sender, last)


class FillMeter:
    """Tells how full the history of a subscription was, which rclpy cannot be asked for.

    With each message comes when the middleware received it. Those that were taken after that moment waited
    when it came, so that the fill is known exactly, if only in hindsight.

    Parameters
    ----------
    depth : int
        Of the history.
    """

    def __init__(self, depth: int) -> None:
        self._taken: deque[int] = deque(maxlen=max(1, depth))
        self._most = 0
        self.waited = 0.0
        """Seconds that the message that was taken last had waited."""

    def took(self, received: int) -> None:
        """Note that a message is taken now which was received then, in nanoseconds since the epoch."""
        if received <= 0:  # a middleware that does not say
            return
        self.waited = max(0.0, (time.time_ns() - received) / 1e9)
        waiting = 1 + len(self._taken) - bisect_right(self._taken, received)
        self._taken.append(time.time_ns())
        if waiting > self._most:
            self._most = min(waiting, self._taken.maxlen or waiting)

    def most_since(self) -> int:
        """Return how many messages waited at a time, at most, since this was asked last."""
        most, self._most = self._most, 0
        return most
