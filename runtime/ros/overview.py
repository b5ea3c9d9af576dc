"""A running application according to the ``/diagnostics`` of its nodes, as shown by `dineros top`.

Any program may publish there, so the data is untrusted: status messages of other programs are skipped, texts
are shortened and freed of control characters, and at most `MOST` nodes are kept.
"""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from graphlib import CycleError, TopologicalSorter
from typing import Any, Protocol

from dineros.runtime.nodes.health import MOST as MOST_VALUES
from dineros.runtime.ros.diagnostics import TOPIC
from dineros.runtime.ros.process.session import Session

MOST = 1000
"""Maximum number of nodes."""

LONGEST = 300
"""Maximum length of a text, in characters."""

LARGEST = 1e15
"""Largest number that is plausible."""

_PARTS = ("state", "places", "queues", "services", "signals", "handlers", "callbacks", "waits")
_NAME = re.compile(rf"(/[\w/]{{1,255}}): ({'|'.join(_PARTS)})")
_WAIT = re.compile(r"(service|action|handler|room|proceed) (.*) ([0-9.]+) s")
_RESPONSE = re.compile(r"response ([0-9.e+-]{1,20}) s\b")
_FILL = re.compile(r"(\d+)/(\d+) (.*)")


class KeyValue(Protocol):
    """``diagnostic_msgs/msg/KeyValue``."""

    key: str
    value: str


class DiagnosticStatus(Protocol):
    """``diagnostic_msgs/msg/DiagnosticStatus``."""

    level: bytes
    name: str
    message: str
    hardware_id: str
    values: list[KeyValue]


@dataclass(frozen=True)
class Waiting:
    """What a part of a node waits for, for example a client for a service, and the node that serves it."""

    element: str
    kind: str
    on: str
    seconds: float
    node: str | None = None


@dataclass
class NodeView:
    """The last reported state of a node.

    Attributes
    ----------
    name, application : str
        Its name in ROS, and the id of its system model.
    level : int
        The worst level of its parts: 0 OK, 1 warning, 2 error.
    heard : float
        When it was received, by the machine's clock.
    parts : dict
        Part -> its values; see `dineros.runtime.ros.diagnostics.parts_of`.
    said : dict of str to str
        Part -> description of its problem.
    """

    name: str
    application: str = ""
    level: int = 0
    heard: float = 0.0
    parts: dict[str, dict[str, str]] = field(default_factory=dict)
    said: dict[str, str] = field(default_factory=dict)

    @property
    def state(self) -> str:
        """``running``, ``halted`` and so on."""
        return self.parts.get("state", {}).get("state", "")

    def count(self, name: str) -> float:
        """Return a number of the part ``state``, such as ``firings``; 0 if it is not a plausible number."""
        return _number(self.parts.get("state", {}).get(name, "0"))

    @property
    def lost(self) -> int:
        """Number of lost messages."""
        return int(sum(self.count(name) for name in self.parts.get("state", {}) if name.startswith("lost ")))

    @property
    def fullest(self) -> tuple[int, int, str] | None:
        """For the fullest queue: the messages that waited, its capacity, and its place."""
        found = [
            (int(_number(fill[1])), int(_number(fill[2])), place)
            for place, text in self.parts.get("queues", {}).items()
            if (fill := _FILL.fullmatch(text)) and _number(fill[1]) and _number(fill[2])
        ]
        return max(found, key=lambda each: each[0] / each[1], default=None)

    @property
    def slowest(self) -> tuple[float, str] | None:
        """The longest response time in the last message, in seconds, and its callback."""
        found = [
            (seconds, callback)
            for callback, text in self.parts.get("callbacks", {}).items()
            if (response := _RESPONSE.match(text)) and (seconds := _number(response[1]))
        ]
        return max(found, default=None)

    @property
    def tokens(self) -> dict[str, int]:
        """Places with tokens, with their number."""
        places = self.parts.get("places", {})
        return {place: int(count) for place, text in places.items() if (count := _number(text)) >= 1}


class Overview:
    """The last reported states of all nodes; from any thread.

    Parameters
    ----------
    clock : callable
        Returns the time in seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._nodes: dict[str, NodeView] = {}

    def take(self, statuses: Iterable[DiagnosticStatus]) -> None:
        """Process one message, which has all parts of its node."""
        found: dict[str, NodeView] = {}
        for status in statuses:
            named = _NAME.fullmatch(status.name)
            if named is None or (named[1] not in found and len(found) >= MOST):
                continue
            view = found.setdefault(named[1], NodeView(named[1], _plain(status.hardware_id)))
            level = min(2, status.level[0]) if status.level else 0
            view.level = max(view.level, level)
            pairs = status.values[: MOST_VALUES + 50]
            view.parts[named[2]] = {_plain(pair.key): _plain(pair.value) for pair in pairs}
            if status.message and (named[2] != "state" or level):
                view.said[named[2]] = _plain(status.message)
        with self._lock:
            for name, view in found.items():
                if "firings" in view.parts.get("state", {}) and (
                    name in self._nodes or len(self._nodes) < MOST
                ):
                    view.heard = self._clock()
                    self._nodes[name] = view

    def nodes(self) -> list[NodeView]:
        """Return the nodes, sorted by name."""
        with self._lock:
            return [self._nodes[name] for name in sorted(self._nodes)]

    def silent(self, view: NodeView) -> float:
        """Return the seconds since the last message of a node."""
        return max(0.0, self._clock() - view.heard)


def waits_of(nodes: Iterable[NodeView]) -> dict[str, list[Waiting]]:
    """Return what the nodes wait for, by their names; the servers of services are found among them."""
    views = list(nodes)
    serving = {service: view.name for view in views for service in view.parts.get("services", {})}
    found: dict[str, list[Waiting]] = {}
    for view in views:
        for element, text in view.parts.get("waits", {}).items():
            if wait := _WAIT.fullmatch(text):
                kind, on, seconds = wait[1], wait[2], _number(wait[3])
                node = serving.get(on) if kind == "service" else None
                found.setdefault(view.name, []).append(Waiting(element, kind, on, seconds, node))
    return found


def circle_of(waits: Mapping[str, list[Waiting]]) -> list[str]:
    """Return nodes each of which waits for the next, and the last one for the first; empty: no circle.

    This need not be a deadlock: each of them may have other things to do.
    """
    on = {name: {each.node for each in found if each.node is not None} for name, found in waits.items()}
    try:
        TopologicalSorter(on).prepare()
    except CycleError as error:
        circle: list[str] = error.args[1]
        return circle[:0:-1]  # the sorter returns predecessors, with the first one repeated
    return []


def _number(text: str) -> float:
    """Return a number from a node's text; 0 if it is invalid, negative, or implausibly large."""
    try:
        number = float(text)
    except ValueError:
        return 0.0
    return number if 0 <= number <= LARGEST else 0.0  # false for NaN


def _plain(text: str) -> str:
    """Return a text shortened and without control characters."""
    return "".join(each if each.isprintable() else "?" for each in text[:LONGEST])


class DiagnosticsListener:
    """Subscribes to ``/diagnostics``, on its own thread, while the block lasts.

    Raises
    ------
    RosError
        ROS is not available, or has no package diagnostic_msgs.
    """

    def __init__(self, overview: Overview) -> None:
        self._overview = overview
        self._session: Session | None = None

    def __enter__(self) -> DiagnosticsListener:
        session = self._session = Session("dineros_top")
        try:
            self._subscribe(session)
        except BaseException:
            session.close()
            raise
        session.start()
        return self

    def _subscribe(self, session: Session) -> None:
        from dineros.runtime.ros.process.session import RosError

        try:
            from diagnostic_msgs.msg import DiagnosticArray
        except ImportError as error:
            raise RosError(
                f"the ROS package diagnostic_msgs is not installed: {error}",
                hint="install it, or dineros[ros]",
            ) from error

        def heard(message: Any) -> None:
            self._overview.take(message.status)

        session.node.create_subscription(DiagnosticArray, TOPIC, heard, 1000)

    def __exit__(self, *exception: object) -> None:
        if self._session is not None:
            self._session.close()
