"""The description of an observed system: nodes, topics, services and actions, for all sources.

A running graph shows the node of each port; a recording shows only topics and the offers on them. Facts that
a source does not have are `None`: nothing is guessed.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from dineros.metamodel.matching import Quality

USUAL = Quality("reliable", "volatile", "automatic", None, None, None)
"""The quality of service that a port has by default in ROS 2."""

ALL_KEPT = 5000
"""Depth in models of a history that keeps all: the default limit of samples of Fast DDS."""


MOST_CHARACTERS = 255
"""Limit of the characters of a name; DDS allows no more."""

_NAME = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")


@dataclass(frozen=True)
class TopicEndpoint:
    """A publisher or a subscription of a node."""

    topic: str
    """Full name, such as ``/scan``."""
    type: str
    """Such as ``std_msgs/msg/String``."""
    quality: Quality = USUAL
    """Quality of service, as discovered."""
    depth: int | None = None
    """Depth of the history; None: unknown (Fast DDS announces none). 0: all messages are kept."""
    at: str = field(default="", compare=False)
    """The line of the code that creates it, as ``file:line``; empty if no code was read."""
    reader: str = field(default="", compare=False)
    """The node of the code that reads it, if several nodes of one executor read the topic; else empty."""
    is_optional: bool = field(default=False, compare=False)
    """Whether the code creates it in a branch, so that it may be missing."""

    @property
    def given_as(self) -> str:
        """The name of its callback in given facts."""
        return f"{self.topic} of {self.reader}" if self.reader else self.topic


@dataclass(frozen=True)
class Endpoint:
    """A server or a client of a service or of an action."""

    name: str
    """Full name, such as ``/arm/grip``."""
    type: str
    """Such as ``std_srvs/srv/Trigger`` or ``example_interfaces/action/Fibonacci``."""
    at: str = field(default="", compare=False)
    """The line of the code that creates it, as ``file:line``; empty if no code was read."""


@dataclass(frozen=True)
class ObservedNode:
    """An observed node."""

    name: str
    """Full name, such as ``/arm/gripper``."""
    publishers: tuple[TopicEndpoint, ...] = ()
    subscribers: tuple[TopicEndpoint, ...] = ()
    """`publishers`, `subscribers`: without those that every node has (``/rosout``, ``/parameter_events``) and
    those of actions.
    """
    servers: tuple[Endpoint, ...] = ()
    clients: tuple[Endpoint, ...] = ()
    """`servers`, `clients`: of services, without those that every node has (parameters, lifecycle) and those
    of actions.
    """
    action_servers: tuple[Endpoint, ...] = ()
    action_clients: tuple[Endpoint, ...] = ()
    """`action_servers`, `action_clients`: of actions."""
    use_sim_time: bool | None = None
    """Whether it obeys simulated time; None: unknown."""
    lifecycle: str | None = None
    """State of a managed node: ``unconfigured``, ``inactive``, ``active``, ``finalized``; ``unknown`` where
    it did not answer; None: the node is not managed.
    """


@dataclass(frozen=True)
class RecordedTopic:
    """A topic that carried messages between unknown nodes."""

    name: str
    """Full name."""
    type: str
    """Such as ``std_msgs/msg/String``."""
    offered: tuple[Quality, ...] = ()
    """The offer of each publisher in the recording; the nodes are unknown."""
    messages: int | None = None
    """The number of recorded events; None: unknown."""


@dataclass(frozen=True)
class RecordedService:
    """A service whose introspection events were recorded; the events do not name nodes."""

    name: str
    """Full name."""
    type: str
    """Such as ``std_srvs/srv/Trigger``."""
    events: int | None = None
    """The number of recorded events; None: unknown."""


@dataclass(frozen=True)
class Watched:
    """The observation of a running graph."""

    seconds: float
    """The total time."""
    quiet: float
    """Seconds at the end without changes."""
    is_stable: bool = True
    """Whether the graph was stable; otherwise parts may be missing."""
    is_checked: bool = False
    """Whether it was examined again, since something seemed to be wrong with it."""

    def __str__(self) -> str:
        again = ", because something seemed to be missing" if self.is_checked else ""
        if not self.is_stable:
            return f"watched for {self.seconds:.1f} s, and the graph was still changing: parts may be missing"
        return f"watched for {self.seconds:.1f} s{again}; nothing new in the last {self.quiet:.1f} s"


@dataclass(frozen=True)
class ObservedSystem:
    """An observed system."""

    source: str
    """The source, in words: ``ROS domain 3``, or the path of a recording."""
    nodes: tuple[ObservedNode, ...] = ()
    """In order of their names."""
    topics: tuple[RecordedTopic, ...] = ()
    """Topics seen without their nodes, in order of their names: those of a recording."""
    departed: tuple[str, ...] = ()
    """Names of nodes that went while they were watched. They are in `nodes`, with what was seen of them."""
    duplicates: tuple[str, ...] = ()
    """Names that more than one node has; what was seen of these nodes is in one of `nodes`."""
    services: tuple[RecordedService, ...] = ()
    """Services seen without their nodes, in order of their names: those of a recording."""
    left_out: tuple[str, ...] = ()
    """What was seen and cannot be asked about or held by a model, in words."""
    watched: Watched | None = field(default=None, compare=False)
    """The observation of a running graph."""
    is_partial: bool = field(default=False, compare=False)
    """Whether there may be other nodes, in addition to those of a package."""

    def publishers(self) -> Iterator[tuple[ObservedNode, TopicEndpoint]]:
        """Yield each publisher and its node."""
        return self.ports("publishers")

    def subscribers(self) -> Iterator[tuple[ObservedNode, TopicEndpoint]]:
        """Yield each subscription and its node."""
        return self.ports("subscribers")

    def ports(self, role: str) -> Iterator[tuple[ObservedNode, Any]]:
        """Yield each port of a role, such as ``servers``, and its node."""
        return ((node, port) for node in self.nodes for port in getattr(node, role))


def name_of(port: TopicEndpoint | Endpoint) -> str:
    """Return the name of the topic, service or action of a port."""
    return port.topic if isinstance(port, TopicEndpoint) else port.name


def quality_of_profile(profile: Any, seconds: Callable[[Any], float | None]) -> Quality:
    """Return the quality of service of a profile of ROS 2; missing parts have their defaults.

    Parameters
    ----------
    profile : rclpy.qos.QoSProfile or rosbags.interfaces.Qos
        The quality of service.
    seconds : callable
        Reads its durations; None: without bound.
    """
    return Quality(
        "bestEffort" if profile.reliability.name == "BEST_EFFORT" else "reliable",
        "transientLocal" if profile.durability.name == "TRANSIENT_LOCAL" else "volatile",
        "manualByTopic" if profile.liveliness.name == "MANUAL_BY_TOPIC" else "automatic",
        seconds(profile.deadline),
        seconds(profile.liveliness_lease_duration),
        seconds(profile.lifespan),
    )


def is_name(name: str) -> bool:
    """Return whether a full name of a node, topic, service or action is valid in ROS 2.

    Examples
    --------
    >>> is_name("/arm/joint_states"), is_name("arm"), is_name("/2nd")
    (True, False, False)
    """
    return len(name) <= MOST_CHARACTERS and _NAME.fullmatch(name) is not None


def full_name(topic: str) -> str:
    """Return the full name of a topic: names without a slash are in the root namespace.

    Examples
    --------
    >>> full_name("scan"), full_name("/scan")
    ('/scan', '/scan')
    """
    return topic if topic.startswith("/") else f"/{topic}"


def within(
    system: ObservedSystem, namespaces: Sequence[str] = (), without: Sequence[str] = ()
) -> ObservedSystem:
    """Return a system with only the nodes of some namespaces (all if none are given), without some."""
    starts = tuple(f"/{name.strip('/')}/".replace("//", "/") for name in namespaces or ("/",))
    kept = tuple(node for node in system.nodes if node.name.startswith(starts) and node.name not in without)
    names = {node.name for node in kept}
    departed, duplicates = (
        tuple(name for name in found if name in names) for found in (system.departed, system.duplicates)
    )
    return replace(system, nodes=kept, departed=departed, duplicates=duplicates)


REQUEST_SENT, REQUEST_RECEIVED, RESPONSE_SENT, RESPONSE_RECEIVED = SERVICE_EVENTS = (
    *("request sent", "request received", "response sent", "response received"),
)
"""Events of a call of a service, in the order of their numbers in ``service_msgs/msg/ServiceEventInfo``."""

OF_EVENTS = "/_service_event"
"""Suffix of the topic on which a service publishes events of its calls."""


def event_name(service: str, event: str) -> str:
    """Return the name of events of a service among messages; no topic has such a name.

    Examples
    --------
    >>> event_name("/plan", REQUEST_SENT)
    '/plan (request sent)'
    """
    return f"{service} ({event})"


def named(name: str) -> str:
    """Return the topic of a message, the service of an event.

    Examples
    --------
    >>> named("/plan (request sent)"), named("/scan")
    ('/plan', '/scan')
    """
    return name.partition(" (")[0]


_EVERY_TOPIC = frozenset({"/rosout", "/parameter_events", "/clock"})
_EVERY_SERVICE = frozenset(
    f"rcl_interfaces/srv/{name}"
    for name in (
        *("DescribeParameters", "GetParameters", "GetParameterTypes", "ListParameters"),
        *("SetParameters", "SetParametersAtomically", "GetLoggerLevels", "SetLoggerLevels"),
    )
) | {"type_description_interfaces/srv/GetTypeDescription"}
_OF_LIFECYCLES = "lifecycle_msgs/"
_OF_ACTIONS = "/_action/"


def is_house_topic(name: str, type: str) -> bool:
    """Return whether ROS creates a topic itself: for logs, parameters, time, states."""
    return name in _EVERY_TOPIC or type.startswith(_OF_LIFECYCLES) or name.endswith(OF_EVENTS)


def is_house_service(type: str) -> bool:
    """Return whether nodes have a service by default, by its type: of parameters, lifecycle."""
    return type in _EVERY_SERVICE or type.startswith(_OF_LIFECYCLES)


def is_of_action(name: str) -> bool:
    """Return whether a topic or a service belongs to an action."""
    return _OF_ACTIONS in name
