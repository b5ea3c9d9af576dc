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
    publishers = ["/driver"]                # of a recording, which does not tell
    subscribers = ["/mapper"]

    [service."/plan"]                       # and the same of an action
    latency = [0, 0.002]                    # of each request, and of each response
    servers = ["/planner"]                  # of a recording with service introspection
    clients = ["/commander"]

    [times]                                 # of all that says nothing of its own
    latency = [0, 0.002]
    takes = [0, 0.01]

    [properties]                            # that the model stores, in words
    Reacts = "/scan to /cmd_vel within 0.2"
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from dineros.metamodel.errors import DinerosError, Location, near_matches
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.files.toml import decode_toml
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
    """The facts given for a callback; None: not given.

    Attributes
    ----------
    does : tuple of Step or None
        Its steps, in order.
    group : str or None
        Its callback group; of a service that the node calls, the group of its client.
    awaits : bool
        Whether it releases its thread while it waits for responses.
    at : str
        The line of the code where it begins.
    takes : Span or None
        Least and greatest seconds of one run, without waits.
    offset : Span or None
        Of a timer: when it strikes first.
    jitter : float or None
        Of a timer: how many seconds late a single strike may be.
    measured : str
        Where these times come from.
    flow : Flow or None
        Its steps in branches, if it depends on variables or responses, or gives one; of an action client, its
        handling of results.
    accepted, rejected : Flow or None
        Of an action client: its handling of accepted and rejected goals.
    received : Received or None
        Its steps in branches, if it depends on a field of the message that it receives.
    has_open_group : bool
        Whether the code does not say its group, so that the default group is assumed.
    """

    does: tuple[Step, ...] | None = None
    group: str | None = None
    awaits: bool = False
    at: str = field(default="", compare=False)
    takes: Span | None = None
    jitter: float | None = None
    measured: str = ""
    offset: Span | None = None
    flow: Flow | None = None
    accepted: Flow | None = None
    rejected: Flow | None = None
    received: Received | None = None
    has_open_group: bool = field(default=False, compare=False)

    @property
    def may_wait(self) -> bool:
        """Whether a step may wait for another callback, or its steps are not given."""
        flow = () if self.flow is None else [each.label for each in self.flow.edges]
        steps = [*(self.does or ()), *(each for each in flow if isinstance(each, Step))]
        return (self.does is None and self.flow is None) or any(each.verb in WAITS for each in steps)


@dataclass(frozen=True)
class OpenThreads:
    """What the code states about the threads of an executor, without their number.

    Attributes
    ----------
    at : str
        The line of the node.
    words : str
        What the code says.
    least : int
        The least possible number.
    may_be_shared : bool
        Whether other nodes may use the same threads: the code does not say which executor it is.
    """

    at: str
    words: str
    least: int = 1
    may_be_shared: bool = False


@dataclass(frozen=True)
class GivenNode:
    """The facts given for a node; None, or absent: not given.

    Attributes
    ----------
    is_shared : bool
        Whether it represents several nodes that share an executor.
    open_timers : frozenset of str
        Timers with an unknown period: they may tick at any time.
    variables : mapping of str to GivenVariable
        Attributes that flows of its callbacks set and test.
    answers_hold_groups : bool
        Whether callbacks of responses, results and feedback hold the group of their client (`rclcpp`).
    open_threads : OpenThreads or None
        What the code states about its threads without their number; then that number is assumed.
    """

    threads: int | None = None
    groups: Mapping[str, str] = field(default_factory=dict)
    depths: Mapping[str, int] = field(default_factory=dict)
    timers: Mapping[str, float] | None = None
    lifecycle: tuple[str, ...] | None = None
    callbacks: Mapping[str, GivenCallback] = field(default_factory=dict)
    newest: Mapping[str, bool] = field(default_factory=dict)
    at: str = field(default="", compare=False)
    is_shared: bool = field(default=False, compare=False)
    order: str | None = None
    open_timers: frozenset[str] = frozenset()
    variables: Mapping[str, GivenVariable] = field(default_factory=dict)
    answers_hold_groups: bool = field(default=False, compare=False)
    open_threads: OpenThreads | None = field(default=None, compare=False)

    def at_once(self, service: str) -> int:
        """Return the number of simultaneous requests of a service: several in a reentrant group."""
        group = self.callbacks.get(service, GivenCallback()).group
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


MOST_BYTES = 1 << 20
"""Limit of the bytes of a file of given facts."""


def given_beside(model: Path) -> Path:
    """Return the path of the file of given facts for a model.

    Examples
    --------
    >>> given_beside(Path("maps/robot.sym.xmi")).as_posix()
    'maps/robot.given.toml'
    """
    return model.with_name(f"{model.name.removesuffix(model.suffix).removesuffix('.sym')}.given.toml")


def read_given(path: Path) -> Given:
    """Read the file of given facts.

    Raises
    ------
    DinerosError
        The file cannot be read, is not TOML, or contains something unknown or of the wrong kind.
    """
    return _Reading(path).given(decode_toml(read_bytes(path, MOST_BYTES), path))


_Channel = TypeVar("_Channel", GivenTopic, GivenService)
_STEP = re.compile(r"(publish|call|send|goal|accepted|cancel|wait|result)\s+(\S+?)(?:\s*([?*]))?")
_PROPERTY = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,99}")
_SLEEP = re.compile(r"sleep\s+(\d{1,8}(?:\.\d{1,9})?)(?:\s*(\?))?")


class _Reading:
    """Turns tables of TOML into plain values; every error names the key."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def given(self, found: Mapping[str, Any]) -> Given:
        self._known(found, "", ("node", "topic", "service", "action", "times", "properties"))
        nodes, times = self._table(found, "node", ""), self._table(found, "times", "")
        properties = self._table(found, "properties", "")
        for name in properties:
            if not _PROPERTY.fullmatch(name):
                raise self._wrong(f"properties.{name}", "is not a name", "letters, digits and _")
        self._known(times, "times", ("latency", "takes"))
        return Given(
            {name: self._node(self._table(nodes, name, "node"), f"node.{name}") for name in nodes},
            self._channels(found, "topic", GivenTopic, ("publishers", "subscribers")),
            self._path,
            self._channels(found, "service", GivenService, ("servers", "clients")),
            self._channels(found, "action", GivenService, ()),
            self._span(times, "latency", "times"),
            self._span(times, "takes", "times"),
            {name: self._text(properties, name, "properties") for name in properties},
        )

    def _node(self, table: Mapping[str, Any], at: str) -> GivenNode:
        known = ("threads", "order", "groups", "depths", "newest", "timers", "lifecycle", "callback")
        self._known(table, at, known)
        if "order" in table:
            self._one_of(table, "order", at, ORDERS)
        groups = self._table(table, "groups", at)
        for name in groups:
            self._one_of(groups, name, f"{at}.groups", ("exclusive", "reentrant"))
        depths, timers = self._table(table, "depths", at), self._table(table, "timers", at)
        callbacks, newest = self._table(table, "callback", at), self._table(table, "newest", at)
        for name in newest:
            self._truth(newest, name, f"{at}.newest")
        life = self._texts(table, "lifecycle", at) if "lifecycle" in table else None
        for each in life or ():
            if each not in LIFE:
                raise self._wrong(f"{at}.lifecycle", f"{each!r} is not one of {', '.join(LIFE)}")
        return GivenNode(
            threads=self._number(table, "threads", at, 1, 1000) if "threads" in table else None,
            order=table.get("order"),
            groups=dict(groups),
            depths={name: self._number(depths, name, f"{at}.depths", 0, 1_000_000) for name in depths},
            newest=dict(newest),
            timers=(
                {name: self._seconds(timers, name, f"{at}.timers") for name in timers}
                if "timers" in table
                else None
            ),
            lifecycle=life,
            callbacks={
                name: self._callback(
                    self._table(callbacks, name, f"{at}.callback"), f"{at}.callback.{name}", groups
                )
                for name in callbacks
            },
        )

    def _callback(self, table: Mapping[str, Any], at: str, groups: Mapping[str, Any]) -> GivenCallback:
        self._known(table, at, ("does", "group", "awaits", "takes", "offset", "jitter", "measured"))
        group = table.get("group")
        if group is not None:
            self._one_of(table, "group", at, tuple(groups), "is not a callback group of its node")
        awaits = self._truth(table, "awaits", at) if "awaits" in table else False
        takes, offset = self._span(table, "takes", at), self._span(table, "offset", at)
        jitter = self._seconds(table, "jitter", at, least=0) if "jitter" in table else None
        measured = self._text(table, "measured", at) if "measured" in table else ""
        if "does" not in table:
            return GivenCallback(None, group, awaits, "", takes, jitter, measured, offset)
        steps: list[Step] = []
        least, most, sleeps = 0.0, 0.0, False
        for text in self._texts(table, "does", at):
            sleep = _SLEEP.fullmatch(text.strip())
            if sleep is None:
                steps.append(self._step(text, at))
                continue
            sleeps = True
            least += 0.0 if sleep[2] else float(sleep[1])
            most += float(sleep[1])
        if sleeps:  # it also works, for an unknown time, unless it is in `takes`
            end = None if takes is None or takes[1] is None else round(takes[1] + most, 9)
            takes = (round((takes[0] if takes is not None else 0.0) + least, 9), end)
        return GivenCallback(tuple(steps), group, awaits, "", takes, jitter, measured, offset)

    def _step(self, text: str, at: str) -> Step:
        match = _STEP.fullmatch(text.strip())
        if match is None:
            raise self._wrong(
                f"{at}.does",
                f"{text!r} is not a step",
                "write it like 'publish /map', 'call /pose ?', 'goal /go *', 'wait /scan', 'sleep 0.5'",
            )
        return Step(match[1], match[2], match[3] or "")

    def _channels(
        self, found: Mapping[str, Any], kind: str, made: Callable[..., _Channel], ends: tuple[str, ...]
    ) -> dict[str, _Channel]:
        """Return the facts given for channels of a kind: latencies, and the nodes of their ends."""
        tables, channels = self._table(found, kind, ""), dict[str, _Channel]()
        for name in tables:
            table, at = self._table(tables, name, kind), f"{kind}.{name}"
            self._known(table, at, (*ends, "latency"))
            given = {end: self._texts(table, end, at) for end in ends if end in table}
            channels[name] = made(**given, latency=self._span(table, "latency", at))
        return channels

    def _known(self, table: Mapping[str, Any], at: str, known: tuple[str, ...]) -> None:
        for key in table:
            if key not in known:
                hint = near_matches(key, known) or f"known are {', '.join(known)}"
                raise self._wrong(f"{at}.{key}".lstrip("."), "is unknown", hint)

    def _table(self, table: Mapping[str, Any], key: str, at: str) -> Mapping[str, Any]:
        found = table.get(key, {})
        if not isinstance(found, dict):
            raise self._wrong(f"{at}.{key}".lstrip("."), "is not a table")
        return found

    def _texts(self, table: Mapping[str, Any], key: str, at: str) -> tuple[str, ...]:
        found = table[key]
        if not isinstance(found, list) or not all(isinstance(each, str) for each in found):
            raise self._wrong(f"{at}.{key}", "is not a list of strings")
        return tuple(found)

    def _truth(self, table: Mapping[str, Any], key: str, at: str) -> bool:
        found = table[key]
        if not isinstance(found, bool):
            raise self._wrong(f"{at}.{key}", "is neither true nor false")
        return found

    def _number(self, table: Mapping[str, Any], key: str, at: str, least: int, most: int) -> int:
        found = table[key]
        if not isinstance(found, int) or isinstance(found, bool) or not least <= found <= most:
            raise self._wrong(f"{at}.{key}", f"is not a whole number from {least} to {most:,}")
        return found

    def _text(self, table: Mapping[str, Any], key: str, at: str) -> str:
        found = table[key]
        if not isinstance(found, str):
            raise self._wrong(f"{at}.{key}", "is not a string")
        return found

    def _seconds(self, table: Mapping[str, Any], key: str, at: str, least: float = 1e-9) -> float:
        found = table[key]
        if not isinstance(found, (int, float)) or isinstance(found, bool) or not least <= found < 1e9:
            raise self._wrong(f"{at}.{key}", f"is not a time in seconds {'above' if least else 'from'} 0")
        return float(found)

    def _span(self, table: Mapping[str, Any], key: str, at: str) -> Span | None:
        if key not in table:
            return None
        found = table[key]
        if (
            not isinstance(found, list)
            or len(found) != 2
            or not all(isinstance(each, (int, float)) and not isinstance(each, bool) for each in found)
            or not 0 <= found[0] <= found[1] < 1e9
        ):
            raise self._wrong(f"{at}.{key}", "is not [LEAST, MOST] in seconds")
        return float(found[0]), float(found[1])

    def _one_of(
        self, table: Mapping[str, Any], key: str, at: str, known: tuple[str, ...], otherwise: str = ""
    ) -> None:
        found = table[key]
        if not isinstance(found, str) or found not in known:
            said = otherwise or f"is not one of {', '.join(known)}"
            raise self._wrong(f"{at}.{key}", f"{found!r} {said}")

    def _wrong(self, key: str, message: str, hint: str | None = None) -> DinerosError:
        return DinerosError(f"{key}: {message}", location=Location(self._path), hint=hint)
