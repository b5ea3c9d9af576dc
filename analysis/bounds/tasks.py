"""The tasks of executors, and the lanes that exclude each other.

A task is a callback with what releases it: its timer, one of its reader histories, or the requests to a
service. Tasks that exclude each other are in one lane: those of a node with one thread, or of an exclusive
callback group. `dineros.analysis.bounds.reading` makes them of a system model.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from dineros.analysis.bounds.work import Work
from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.elements import label, node_net_of


@dataclass(eq=False, repr=False)
class Lane:
    """Tasks of which one at a time runs, or those of one reentrant callback."""

    node: sym.NodeNet
    is_exclusive: bool = True
    """Whether one of the tasks at a time runs."""
    tasks: list[Task] = field(default_factory=list)
    reason: str = ""
    """Why nothing bounds when they run; empty if their works and arrivals do."""
    keeps_order: bool = False
    """Whether the rules take the callbacks of the node in an order that is known."""
    most_at_once: int | None = None
    """Maximum number of threads that its runs use at the same time; None without a limit."""


@dataclass(frozen=True)
class Source:
    """Where messages of a task come from; times in units."""

    task: Task
    """What publishes them, or asks for them."""
    writer: sym.PublisherPort | sym.ClientPort | sym.ActionClientPort
    most: int
    """Messages of one run."""
    separation: int
    """Least time that runs of that callback take; 0 if they may overlap."""
    only_at_end: bool
    """Whether it publishes only when it ends."""
    latency: tuple[int, int]
    """Least and greatest time on the way."""
    paces: tuple[tuple[int, int], ...] | None = None
    """For each step that publishes, how many messages it publishes at one moment at most, and the least time
    between two such moments; None if a step has no such time.
    """
    goals: tuple[Source, ...] = ()
    """Where goals come from whose ends call the task, if they do; a run of `most` goals calls it as often."""
    under_way: int = 0
    """Runs of the task that can begin, or are under way, for goals that were sent before."""


Engine = tuple[sym.PublisherPort, tuple[int, int]]
"""A publisher of a node whose engine publishes, with the least and greatest time on the way, in units."""


@dataclass(eq=False, repr=False)
class EngineReader:
    """A history that the engine of a node of the execution `net` reads, and where its messages come from."""

    reader: sym.SubscriberPort
    sources: list[Source] = field(default_factory=list)
    engines: list[Engine] = field(default_factory=list)
    reason: str = ""
    """Why nothing bounds when messages come."""

    @property
    def name(self) -> str:
        """How reports call it."""
        return f"reader history of {label(self.reader.place)}"


@dataclass(eq=False, repr=False)
class Task:
    """A callback, and what releases it; times in units."""

    page: sym.CallbackPage
    reader: sym.SubscriberPort | None
    """The history that releases it; None of a timer and a server."""
    lane: Lane
    work: Work | None = None
    """None if nothing bounds what a run does; then `reason` says why."""
    reason: str = ""
    """Why nothing bounds when it is released, or how long it works."""
    least: int = 0
    most: int = 0
    """`least`, `most`: how long a run takes."""
    period: int = 0
    jitter: int = 0
    """`period`, `jitter`: of a timer."""
    sources: list[Source] = field(default_factory=list)
    """Of a subscription and a server."""
    engines: list[Engine] = field(default_factory=list)
    """Of a subscription."""
    server: sym.ServerPort | None = None
    """What gets the requests that release it."""
    requests: int | None = None
    """How many requests its clients have under way at once; None without a limit."""
    is_held: bool = False
    """Whether what it works on counts among those that it holds: a client has its response not before the run
    has ended.
    """

    @property
    def is_timer(self) -> bool:
        """Whether a timer releases it."""
        return self.page.kind == sym.CallbackKind.timer

    @property
    def held(self) -> int | None:
        """How many of its messages, requests or ticks wait at once, at most; or are under way (`is_held`).

        None without a limit.
        """
        if self.server is not None:
            return self.requests
        return 1 if self.reader is None else int(self.reader.limit)

    @property
    def name(self) -> str:
        """How reports call it."""
        return f"callback {label(self.page)}"


def is_of_engine(port: sym.TopicPort) -> bool:
    """Return whether a port belongs to a node of the execution `net`."""
    node = node_net_of(port.place)
    return node is not None and not runs_callbacks(node)
