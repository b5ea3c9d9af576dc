"""The elements of a topic channel in the net: queues, and the places between them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Queue:
    """An overflow queue: its transitions and places, by index in the compiled net.

    Attributes
    ----------
    source, load, capacity : int
        Places: for arriving messages, for waiting messages, and for free room.
    enter, leave, drop : int
        Transitions. The instances of a server page share the queue of a publisher on it; each has only its
        own source, enter and drop.
    limit : int
        Capacity of the queue.
    text : str
        Description of the queue in terms of the model.
    """

    source: int
    load: int
    capacity: int
    enter: int
    leave: int
    drop: int
    limit: int
    text: str


@dataclass(frozen=True)
class Topic:
    """A topic channel: its queues, and the places between them.

    Attributes
    ----------
    place, transport : int
        Messages under way, and the transition that delivers one to every subscribing node.
    publishers : dict of str to Queue
        By place of the port.
    dispatchers : dict of str to Queue
        By node net.
    subscribers : dict of str to Queue
        By place of the port.
    node_of : dict of str to str
        Node net of each subscriber's place.
    """

    place: int
    transport: int
    publishers: dict[str, Queue]
    dispatchers: dict[str, Queue]
    subscribers: dict[str, Queue]
    node_of: dict[str, str]


@dataclass(frozen=True, eq=False)
class Pair:
    """A publisher and a subscriber of a topic of ROS 2 that match.

    Attributes
    ----------
    publisher, subscriber : str
        The places of the ports.
    publishers : tuple of str
        Places from which the publisher's messages come: on a server page, one for each instance.
    queue : Queue
        The writer history.
    lose : int or None
        The transition that loses a message in transit; None: the connection is reliable.
    miss : int or None
        The transition that loses a message because the subscriber is absent; None: it never is.
    replace : int or None
        The transition in which a new message replaces a delivered one in the history; None: none is kept.
    """

    publisher: str
    subscriber: str
    publishers: tuple[str, ...]
    queue: Queue
    lose: int | None
    miss: int | None = None
    replace: int | None = None


@dataclass(frozen=True)
class HistoryTopic:
    """A topic channel of ROS 2."""

    pairs: tuple[Pair, ...]
    """Publishers and subscribers that match."""
    publishers: dict[str, list[Pair]]
    """By place of the port."""
    subscribers: dict[str, Queue]
    """Reader histories, by place of the port."""
    node_of: dict[str, str]
    """Node net of each subscriber's place."""
