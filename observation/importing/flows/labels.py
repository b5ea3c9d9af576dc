"""The steps and branches of a callback."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from dineros.sources.branches import FALSE, TRUE
from dineros.sources.variables import Known


@dataclass(frozen=True)
class Step:
    """A step of a callback."""

    verb: str
    """Publish a message; call a service and wait for the answer; send a request and continue; send a goal;
    wait until a goal is accepted or refused; ask to cancel it; wait until the callback of a subscription has
    taken a message; wait until the result of a goal is there: ``publish``, ``call``, ``send``, ``goal``,
    ``accepted``, ``cancel``, ``wait``, ``result``.
    """
    name: str
    """Full name of the topic, service or action."""
    times: str = ""
    """Once; once or not at all; any number of times: empty, ``?``, ``*``."""
    at: str = field(default="", compare=False)
    """The line of the code that says so, as ``file:line``."""
    timeout: float | None = field(default=None, compare=False)
    """Seconds after which a call gives up; None: never."""
    group: str | None = field(default=None, compare=False)
    """Callback group of the client that calls, if the node has several of one service: a name, or empty for
    the node's default group. None: the group that is given of the client.
    """
    sends: tuple[tuple[str, str], ...] = ()
    """Fields of the published message that decide about branches and have this value each time."""
    answer: tuple[str, str] | None = None
    """Of a call: the field of the response that decides about branches, and its value; None: any."""

    def __str__(self) -> str:
        return f"{self.verb} {self.name}{f' {self.times}' if self.times else ''}"


WAITS = ("call", "accepted", "wait", "result")
"""Verbs of steps that wait."""


@dataclass(frozen=True)
class Set:
    """A callback sets a variable of its node."""

    variable: str
    value: str
    """`variable`, `value`: names."""
    at: str = field(default="", compare=False)
    """The line of the code."""
    before: frozenset[str] | None = None
    """Possible previous values; None: any."""


@dataclass(frozen=True)
class Ask:
    """A callback continues if a variable of its node has one of some values, by a test in the code."""

    variable: str
    values: frozenset[str]
    at: str = field(default="", compare=False)


@dataclass(frozen=True)
class Mark:
    """A place in a callback that is needed while a flow is built."""

    word: str


@dataclass(frozen=True)
class Has:
    """A callback was started by a response with this value of a field."""

    name: str
    value: str
    at: str = field(default="", compare=False)


@dataclass(frozen=True)
class Answers:
    """The callback of a service ends with a response with this value of a field; None: any value."""

    name: str
    value: str | None


@dataclass(frozen=True)
class Know:
    """Here a field of a response becomes known; None: it may have any value. Only while a flow is built."""

    key: object
    value: str | None


@dataclass(frozen=True)
class Test:
    """Here a field of a response has one of some values. Only while a flow is built."""

    key: object
    values: frozenset[str]


Label: TypeAlias = Step | Set | Ask | Mark | Has | Answers | Know | Test | None
"""The effect of an edge of a flow; None: none."""


@dataclass(frozen=True)
class Edge:
    """An edge of a flow, from one state to another."""

    source: int
    label: Label
    target: int


@dataclass(frozen=True)
class Flow:
    """The behaviour of a callback, in branches: a graph with a first and a last state."""

    edges: tuple[Edge, ...]
    start: int
    end: int


@dataclass(frozen=True)
class Received:
    """The behaviour of a callback that tests a field of the message that it receives."""

    name: str
    """The field."""
    branches: tuple[tuple[str, Flow], ...]
    """What the callback does for each value of the field."""
    at: str = field(default="", compare=False)
    """The line of the test."""


@dataclass(frozen=True)
class Deciding:
    """A field of the messages of a topic, or of responses of a service, on which callbacks depend."""

    type: str
    """Of the messages, or of the service."""
    name: str
    """Of the field."""
    texts: tuple[str, ...] = ("true", "false")
    """The values that the model distinguishes, as guards write them."""
    numbers: tuple[int, ...] = ()
    """Their numbers; none: the field is a truth value."""
    known: Mapping[Known, str] = field(default_factory=lambda: {TRUE: "true", FALSE: "false"})
    """What the code writes for them."""

    def among(self, values: Iterable[Known]) -> frozenset[str] | None:
        """Return the values that the code writes as guards write them; None: one of them is unknown."""
        found = [self.known.get(each) for each in values]
        return None if None in found else frozenset(each for each in found if each is not None)


def of_service(name: str) -> str:
    """Return the key of a service where topics have their names: both may have one name."""
    return f"service {name}"


@dataclass(frozen=True)
class GivenVariable:
    """An attribute of a node on which its callbacks depend."""

    values: tuple[str, ...]
    """All its possible values."""
    first: str
    """Its value at the start."""
    at: str = field(default="", compare=False)
    """The line of the code."""
