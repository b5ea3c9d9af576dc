"""Facts about a system that a graph does not show: a file that imports read and never overwrite.

It is TOML. All parts are optional; given facts replace assumptions::

    [node."/mapper"]
    threads = 2                             # of a multi-threaded executor
    order = "rclpy"                         # in which its executor takes callbacks: any, rclcpp, rclpy
    groups = {answers = "reentrant"}        # callback groups
    depths = {"/scan" = 5, "/map" = 1}      # of histories; 0: all is kept
    newest = {"/map" = true}                # whether a reader needs the newest message only
    timers = {tick = 0.1}                   # seconds; {}: it has none
    lifecycle = ["deactivates"]             # what may happen to a managed node, but for coming up

    [node."/mapper".callback."/scan"]       # by the name of topic, service, action or timer
    does = ["call /pose", "wait /scan", "sleep 0.1", "publish /map ?"]  # in this order; ?: or not
    group = "answers"                       # of a service that is called: of its client
    awaits = true
    takes = [0.01, 0.08]                    # seconds of one run, without what it waits for
    offset = [0, 0]                         # of a timer: when it strikes first
    jitter = 0.002                          # of a timer: how late a single strike may be, in seconds
    measured = "monday: 60 measured, ..."   # where these times come from

    [topic."/scan"]
    latency = [0, 0.002]                    # seconds that a message is on its way
    publishers = ["/driver"]                # which a recording does not contain
    subscribers = ["/mapper"]

    [service."/plan"]                       # and the same of an action
    latency = [0, 0.002]                    # of each request, and of each response
    servers = ["/planner"]                  # of a recording with service introspection
    clients = ["/commander"]

    [times]                                 # defaults of all elements without own times
    latency = [0, 0.002]
    takes = [0, 0.01]

    [properties]                            # that the model stores, in words
    Reacts = "/scan to /cmd_vel within 0.2"
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from dineros.observation.importing.flows.labels import (
    WAITS,
    Deciding,
    Flow,
    GivenVariable,
    Received,
    Step,
)

Span = tuple[float, float | None]
"""Least and greatest seconds; None: unbounded."""

LIFE = ("deactivates", "cleansUp", "shutsDown", "configureFails", "activateFails")
"""Possible changes of a managed node, as in `dineros.metamodel.sym.Lifecycle`."""

ORDERS = ("any", "rclcpp", "rclpy")
"""Orders in which an executor takes callbacks, as in `dineros.metamodel.sym.CallbackOrder`."""


@dataclass(frozen=True)
class GivenCallback:
    """The facts given for a callback; None: not given."""

    does: tuple[Step, ...] | None = None
    """Its steps, in order."""
    group: str | None = None
    """Its callback group; of a service that the node calls, the group of its client."""
    awaits: bool = False
    """Whether it releases its thread while it waits for responses."""
    at: str = field(default="", compare=False)
    """The line of the code where it begins."""
    takes: Span | None = None
    """Least and greatest seconds of one run, without waits."""
    jitter: float | None = None
    """Of a timer: how many seconds late a single strike may be."""
    measured: str = ""
    """Where these times come from."""
    offset: Span | None = None
    """Of a timer: when it strikes first."""
    flow: Flow | None = None
    """Its steps in branches, if it depends on variables or responses, or gives one; of an action client, its
    handling of results.
    """
    accepted: Flow | None = None
    rejected: Flow | None = None
    """`accepted`, `rejected`: of an action client: its handling of accepted and rejected goals."""
    received: Received | None = None
    """Its steps in branches, if it depends on a field of the message that it receives."""
    has_open_group: bool = field(default=False, compare=False)
    """Whether the code does not say its group, so that the default group is assumed."""
    overlaps: int | None = None
    """Of a timer or a subscription: how many of its runs the model has at once at most."""
    outstanding: int | None = None
    """Of an action client: how many goals the program has under way at most."""

    @property
    def may_wait(self) -> bool:
        """Whether a step may wait for another callback, or its steps are not given."""
        flow = () if self.flow is None else [each.label for each in self.flow.edges]
        steps = [*(self.does or ()), *(each for each in flow if isinstance(each, Step))]
        return (self.does is None and self.flow is None) or any(each.verb in WAITS for each in steps)


@dataclass(frozen=True)
class OpenThreads:
    """What the code states about the threads of an executor, without their number."""

    at: str
    """The line of the node."""
    words: str
    """What the code says."""
    least: int = 1
    """The least possible number."""
    may_be_shared: bool = False
    """Whether other nodes may use the same threads: the code does not say which executor it is."""


@dataclass(frozen=True)
class GivenNode:
    """The facts given for a node; None, or absent: not given."""

    threads: int | None = None
    groups: Mapping[str, str] = field(default_factory=dict)
    depths: Mapping[str, int] = field(default_factory=dict)
    timers: Mapping[str, float] | None = None
    lifecycle: tuple[str, ...] | None = None
    callbacks: Mapping[str, GivenCallback] = field(default_factory=dict)
    newest: Mapping[str, bool] = field(default_factory=dict)
    at: str = field(default="", compare=False)
    is_shared: bool = field(default=False, compare=False)
    """Whether it represents several nodes that share an executor."""
    order: str | None = None
    open_timers: frozenset[str] = frozenset()
    """Timers with an unknown period: they may tick at any time."""
    variables: Mapping[str, GivenVariable] = field(default_factory=dict)
    """Attributes that flows of its callbacks set and test."""
    answers_hold_groups: bool = field(default=False, compare=False)
    """Whether callbacks of responses, results and feedback hold the group of their client (`rclcpp`)."""
    open_threads: OpenThreads | None = field(default=None, compare=False)
    """What the code states about its threads without their number; then that number is assumed."""

    def callback(self, name: str) -> GivenCallback:
        """Return the facts given for a callback; empty ones if there are none."""
        return self.callbacks.get(name, GivenCallback())

    def at_once(self, service: str) -> int:
        """Return the number of simultaneous requests of a service: several in a reentrant group."""
        group = self.callback(service).group
        is_reentrant = group is not None and self.groups[group] == "reentrant"
        return (self.threads or 1) if is_reentrant else 1


@dataclass(frozen=True)
class GivenTopic:
    """Publishers, subscribers and latency of a recorded topic."""

    publishers: tuple[str, ...] = ()
    subscribers: tuple[str, ...] = ()
    latency: Span | None = None


@dataclass(frozen=True)
class GivenService:
    """Servers, clients and latency of a recorded service or action."""

    servers: tuple[str, ...] = ()
    clients: tuple[str, ...] = ()
    latency: Span | None = None


@dataclass(frozen=True)
class Given:
    """All facts given for a system."""

    nodes: Mapping[str, GivenNode] = field(default_factory=dict)
    topics: Mapping[str, GivenTopic] = field(default_factory=dict)
    path: Path | None = None
    services: Mapping[str, GivenService] = field(default_factory=dict)
    actions: Mapping[str, GivenService] = field(default_factory=dict)
    latency: Span | None = None
    takes: Span | None = None
    properties: Mapping[str, str] = field(default_factory=dict)
    deciding: Mapping[str, Deciding] = field(default_factory=dict)

    def node(self, name: str) -> GivenNode:
        """Return the facts given for a node."""
        return self.nodes.get(name, GivenNode())
