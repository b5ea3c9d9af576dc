"""Attributes published messages to running callbacks of nodes, by the events of ros2_tracing.

A callback publishes on the thread that runs it, between its ``callback_start`` and its ``callback_end``.
Callbacks nest if one spins an executor of its own. Up to ROS 2 Jazzy, a callback of a service that answers
later has no ``callback_end`` (https://github.com/ros2/rclcpp/pull/2670): a message that its thread publishes
after the executor continued belongs to the callback only if its end follows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sized
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeVar

from dineros.metamodel.errors import Location
from dineros.observation.tracing.errors import TracingError
from dineros.observation.tracing.reading import TracedEvent, Tracing

MOST = 100_000
"""Limit of the remembered objects of each kind: handles, callbacks, threads in callbacks."""

CLOSE = 1_000_000
"""Nanoseconds between two callbacks of a thread if one may have waited for the other."""

MOST_NESTED = 100
"""Limit of nested callbacks on a thread; beyond it, the end of the outermost one was lost."""

K = TypeVar("K")
V = TypeVar("V")
Kind = Literal["subscription", "service", "timer"]
Effect = tuple[str, str]
"""A node, and a topic on which it publishes."""


class Callback(NamedTuple):
    """A callback of a node."""

    node: str
    """Full name of the node."""
    kind: Kind
    """Its kind of trigger: ``subscription``, ``service``, ``timer``."""
    name: str
    """Full name of the topic or service; of a timer, the signature of its function."""
    period: int = 0
    """Of a timer, in nanoseconds."""


class Publication(NamedTuple):
    """A published message: time (nanoseconds), node and topic."""

    time: int
    node: str
    topic: str


@dataclass
class Sent:
    """The messages of a run on a topic: their number, and the nanoseconds from its start to the first one."""

    count: int
    first: int


@dataclass(frozen=True)
class Run:
    """A run of a callback."""

    callback: Callback
    """Which."""
    published: dict[Effect, Sent]
    """Its messages: by node, which may be another one, and topic."""
    ended: bool = True
    """Whether it ended before the trace did, if known."""
    began: int = 0
    """When it began, in nanoseconds."""
    took: int | None = None
    """Nanoseconds from its beginning to its end; None if the trace does not contain its end."""
    waited: bool = False
    """Whether its thread ran another callback until then, for which it may have waited."""


@dataclass
class Uncertain:
    """Counts of data that a trace does not attribute."""

    callbacks: int = 0
    """Runs of callbacks with an unknown node: the trace was started after the node."""
    messages: int = 0
    """Messages of publishers with an unknown node."""


@dataclass
class _Frame:
    """A running callback of a thread, with its messages; `unsure`: those after the executor continued."""

    address: str
    callback: Callback | None
    began: int
    sure: dict[Effect, Sent] = field(default_factory=dict)
    unsure: dict[Effect, Sent] = field(default_factory=dict)
    left: bool = False
    waited: bool = False

    def published(self, effect: Effect, time: int) -> None:
        into = self.unsure if self.left else self.sure
        if effect in into:
            into[effect].count += 1
        else:
            into[effect] = Sent(1, time - self.began)

    def run(self, *, has_end: bool, ended: bool = True, end: int | None = None) -> Iterator[Run]:
        if self.callback is None:
            return
        if has_end:
            for effect, sent in self.unsure.items():
                if effect in self.sure:
                    self.sure[effect].count += sent.count
                else:
                    self.sure[effect] = sent
        took = None if end is None else end - self.began
        yield Run(self.callback, self.sure, ended, self.began, took, self.waited)


@dataclass
class _Thread:
    """The callbacks that run on a thread, the innermost last, and whose message went within the process.

    `free` is when the last callback ended.
    """

    frames: list[_Frame] = field(default_factory=list)
    free: int | None = None
    within: str | None = None


def runs(tracing: Tracing, uncertain: Uncertain | None = None) -> Iterator[Run | Publication]:
    """Yield the messages of a trace as they are published, and the runs of callbacks as they end.

    Parameters
    ----------
    tracing : Tracing
        The files.
    uncertain : Uncertain, optional
        Gets the counts of unknown data.

    Raises
    ------
    TracingError
        They cannot be read, contain no node, or more nodes than any system has.
    """
    found = _Attributing(tracing, uncertain or Uncertain())
    for event in tracing.events():
        yield from found.take(event)
    yield from found.finish()


class _Attributing:
    """Names of objects with an address, and the state of each thread."""

    def __init__(self, tracing: Tracing, uncertain: Uncertain) -> None:
        self._tracing = tracing
        self._uncertain = uncertain
        self._nodes: dict[tuple[str, str], str] = {}
        self._publishers: dict[tuple[str, str], Effect] = {}
        # By handle: node, as an address, and topic or service.
        self._handles: dict[tuple[str, str], tuple[str, str]] = {}
        self._subscriptions: dict[tuple[str, str], str] = {}
        self._callbacks: dict[tuple[str, str], tuple[Kind, str]] = {}
        self._periods: dict[tuple[str, str], int] = {}
        self._timer_nodes: dict[tuple[str, str], str] = {}
        self._symbols: dict[tuple[str, str], str] = {}
        self._threads: dict[str, _Thread] = {}

    def take(self, event: TracedEvent) -> Iterator[Run | Publication]:
        """Process an event; yield its messages and runs."""
        name = event.name
        if name == "callback_start":
            yield from self._started(event)
        elif name == "callback_end":
            yield from self._ended(event)
        elif name in ("rcl_publish", "rclcpp_intra_publish"):
            yield from self._published(event, within=name == "rclcpp_intra_publish")
        elif name.startswith("rclcpp_executor"):
            if event.thread in self._threads:
                thread = self._threads[event.thread]
                thread.within = None
                for frame in thread.frames:
                    frame.left = True
        else:
            self._register(event)

    def finish(self) -> Iterator[Run]:
        """Yield the runs that had not ended when the trace did.

        Raises
        ------
        TracingError
            The trace contains no node.
        """
        for thread in self._threads.values():
            for frame in thread.frames:
                yield from frame.run(has_end=False, ended=False)
        if not self._nodes:
            raise TracingError(
                "contains no node (rcl_node_init)",
                location=Location(self._tracing.path),
                hint="start tracing before the nodes, with all events: `ros2 trace`",
            )

    def _started(self, event: TracedEvent) -> Iterator[Run]:
        (address,) = event.fields
        thread = self._thread(event.thread)
        thread.within = None
        # A callback does not begin again before it has ended: its end and those of nested ones are missing.
        yield from self._unwound(thread, address)
        callback = self._callback(event.process, address)
        if callback is None:
            self._uncertain.callbacks += 1
        waited = bool(thread.frames) or (thread.free is not None and event.time - thread.free <= CLOSE)
        thread.frames.append(_Frame(address, callback, event.time, waited=waited))
        if len(thread.frames) > MOST_NESTED:
            yield from thread.frames.pop(0).run(has_end=False)

    def _ended(self, event: TracedEvent) -> Iterator[Run]:
        (address,) = event.fields
        thread = self._threads.get(event.thread)
        if thread is None:
            return
        thread.within = None
        yield from self._unwound(thread, address, event.time)
        thread.free = event.time

    def _thread(self, name: str) -> _Thread:
        if name not in self._threads and len(self._threads) >= MOST:
            self._threads = {its: thread for its, thread in self._threads.items() if thread.frames}
        thread = self._threads.setdefault(name, _Thread())
        self._bound(self._threads, "threads")
        return thread

    @staticmethod
    def _unwound(thread: _Thread, address: str, end: int | None = None) -> Iterator[Run]:
        """End a callback and nested ones, whose ends are missing; its own end is known if `end` is given."""
        places = [place for place, frame in enumerate(thread.frames) if frame.address == address]
        if places:
            for frame in reversed(thread.frames[places[-1] + 1 :]):
                yield from frame.run(has_end=False)
            yield from thread.frames[places[-1]].run(has_end=end is not None, end=end)
            del thread.frames[places[-1] :]

    def _published(self, event: TracedEvent, *, within: bool) -> Iterator[Publication]:
        (handle,) = event.fields
        thread = self._threads.get(event.thread)
        # A message within the process and to others has two consecutive events.
        again = not within and thread is not None and thread.within == handle
        if within and thread is None:
            thread = self._thread(event.thread)
        if thread is not None:
            thread.within = handle if within else None
        if again:
            return
        effect = self._publishers.get((event.process, handle))
        if effect is None:
            self._uncertain.messages += 1
            return
        if thread is not None and thread.frames:
            thread.frames[-1].published(effect, event.time)
        yield Publication(event.time, *effect)

    def _register(self, event: TracedEvent) -> None:
        process, values = event.process, event.fields
        match event.name:
            case "rcl_node_init":
                handle, name, namespace = values
                self._keep(self._nodes, (process, handle), f"{namespace.rstrip('/')}/{name}", "nodes")
            case "rcl_publisher_init":
                handle, node, topic = values
                known = self._nodes.get((process, node))
                if known is not None:
                    self._keep(self._publishers, (process, handle), (known, topic), "publishers")
            case "rcl_subscription_init" | "rcl_service_init":
                handle, node, name = values
                self._keep(self._handles, (process, handle), (node, name), "subscriptions and services")
            case "rclcpp_subscription_init":
                handle, subscription = values
                self._keep(self._subscriptions, (process, subscription), handle, "subscriptions")
            case "rclcpp_subscription_callback_added":
                self._add(process, values, "subscription")
            case "rclcpp_service_callback_added":
                self._add(process, values, "service")
            case "rclcpp_timer_callback_added":
                self._add(process, values, "timer")
            case "rcl_timer_init":
                handle, period = values
                self._keep(self._periods, (process, handle), int(period, 0), "timers")
            case "rclcpp_timer_link_node":
                handle, node = values
                self._keep(self._timer_nodes, (process, handle), node, "timers")
            case "rclcpp_callback_register":
                callback, symbol = values
                self._keep(self._symbols, (process, callback), symbol, "callbacks")

    def _add(self, process: str, values: tuple[str, ...], kind: Kind) -> None:
        owner, callback = values
        self._keep(self._callbacks, (process, callback), (kind, owner), "callbacks")

    def _keep(self, known: dict[K, V], key: K, value: V, what: str) -> None:
        known[key] = value
        self._bound(known, what)

    def _callback(self, process: str, address: str) -> Callback | None:
        kind, owner = self._callbacks.get((process, address), ("timer", ""))
        if kind == "timer":
            node = self._nodes.get((process, self._timer_nodes.get((process, owner), "")))
            symbol = self._symbols.get((process, address), "")
            period = self._periods.get((process, owner), 0)
            return Callback(node, kind, symbol, period) if node else None
        handle = self._subscriptions.get((process, owner), "") if kind == "subscription" else owner
        at, name = self._handles.get((process, handle), ("", ""))
        node = self._nodes.get((process, at))
        return Callback(node, kind, name) if node else None

    def _bound(self, known: Sized, what: str) -> None:
        if len(known) > MOST:
            raise TracingError(f"contains more than {MOST:,} {what}", location=Location(self._tracing.path))
