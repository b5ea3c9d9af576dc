"""The elements of a topic channel in the net: queues, and the places between them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Queue:
    """An overflow queue: its transitions and places, by index in the compiled net."""

    source: int
    load: int
    capacity: int
    """`source`, `load`, `capacity`: places for arriving messages, for waiting messages, for free room."""
    enter: int
    leave: int
    drop: int
    """`enter`, `leave`, `drop`: transitions. The instances of a server page share the queue of a publisher on
    it; each has only its own source, enter and drop.
    """
    limit: int
    """Capacity of the queue."""
    text: str
    """Description of the queue in terms of the model."""


@dataclass(frozen=True)
class Topic:
    """A topic channel: its queues, and the places between them."""

    place: int
    transport: int
    """`place`, `transport`: messages under way, and the transition that delivers one to every subscribing
    node.
    """
    publishers: dict[str, Queue]
    """By place of the port."""
    dispatchers: dict[str, Queue]
    """By node net."""
    subscribers: dict[str, Queue]
    """By place of the port."""
    node_of: dict[str, str]
    """Node net of each subscriber's place."""


@dataclass(frozen=True, eq=False)
class Pair:
    """A publisher and a subscriber of a topic of ROS 2 that match."""

    publisher: str
    subscriber: str
    """`publisher`, `subscriber`: the places of the ports."""
    publishers: tuple[str, ...]
    """Places from which the publisher's messages come: on a server page, one for each instance."""
    queue: Queue
    """The writer history."""
    lose: int | None
    """The transition that loses a message in transit; None: the connection is reliable."""
    miss: int | None = None
    """The transition that loses a message because the subscriber is absent; None: it never is."""
    replace: int | None = None
    """The transition in which a new message replaces a delivered one in the history; None: none is kept."""


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
