"""The records about a node itself: its start, its checkpoints, failures, its end."""

from __future__ import annotations

from dataclasses import field
from typing import Any, Literal

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.records.base import Data, Record, StoredToken
from dineros.metamodel.records.declarations import Declaration
from dineros.metamodel.records.steps import ChannelStep, ServiceStep, Step

__all__ = [
    "Aside",
    "ChannelStep",
    "Checkpoint",
    "Error",
    "Release",
    "ServiceStep",
    "Start",
    "Step",
    "Stop",
    "Timeout",
    "requests_of",
]


class Start(Record, event="start"):
    """A node starts, or continues after a restart.

    Attributes
    ----------
    marking : dict of str to list of StoredToken
        Tokens of each place, the oldest first.
    signals : dict of str to bool or str
        Values of the signals.
    resumed : bool
        Whether the node continues an earlier run.
    seed : int or None
        Seed of the firing selection.
    """

    marking: dict[str, list[StoredToken]] = field(default_factory=dict)
    signals: dict[str, SignalSetting] = field(default_factory=dict)
    resumed: bool = False
    seed: int | None = None


class Checkpoint(Start, event="checkpoint"):
    """All data that a node needs to continue from here: second line of each file, and first after a restart.

    Attributes
    ----------
    next_token : int
        Id of the next token.
    numbers : dict of str to int
        Number of the last message of each publisher's or client's port, by its place; instances of a server
        page share their publishers.
    history : dict of str to list of StoredToken
        Number and data of the last messages of each publishing place, as many as its queue holds: a restarted
        node publishes them again, since the queue was lost with its process.
    queues : dict of str to int
        Number of messages that the queue of each publishing place holds.
    kept : dict
        Values kept by handlers: name -> JSON value.
    seen : dict
        ``CHANNEL/PLACE`` of a subscriber -> sender (a message id without its number) -> number of the last
        message up to which all messages were received or lost.
    seen_apart : dict
        ``CHANNEL/PLACE`` -> sender -> first and last number of each further range of received messages.
    missing : dict of str to int
        ``CHANNEL/PLACE`` -> number of messages lost since the last one was received.
    requests : dict
        ``CHANNEL/CLIENT`` -> the requests under way, the oldest first: message id, data, attempts, and `age`
        in seconds; earlier versions wrote a single request, without a list and an age.
    serving : dict of str to str
        Entry place of a server instance -> message id of the request that it serves.
    responses : dict
        Channel -> message id -> data of the responses kept for repeated requests, the oldest first.
    goals : dict
        ``CHANNEL/CLIENT`` of an action -> the goals under way, the oldest first: id, data, whether it is
        accepted and whether its cancel was requested, the number of the last feedback, attempts so far.
    slots : dict
        Entry place of a slot of an action server -> the goal that it executes: id, data, whether it is to be
        canceled, the number of its last feedback, and number and data of the last feedback messages.
    results : dict
        Channel of an action's server -> id of a goal -> its outcome and data, the oldest first.
    kept_responses : dict of str to int
        Channel -> number of responses kept for each sender, if more than one.
    aside : dict
        Transition -> place -> ids of the tokens put aside after a failure.
    run : str
        Part of the ids of the run's messages, after the node's id.
    lifecycle : str
        The state of a managed node; empty for other nodes.
    apart : dict
        Field (``marking`` or ``history``) -> place -> reference to the list of its tokens' data, stored next
        to the trace. The field itself has these tokens in the same order, without their data.
    """

    next_token: int = 0
    numbers: dict[str, int] = field(default_factory=dict)
    history: dict[str, list[StoredToken]] = field(default_factory=dict)
    queues: dict[str, int] = field(default_factory=dict)
    kept: dict[str, Any] = field(default_factory=dict)
    seen: dict[str, dict[str, int]] = field(default_factory=dict)
    seen_apart: dict[str, dict[str, list[list[int]]]] = field(default_factory=dict)
    missing: dict[str, int] = field(default_factory=dict)
    requests: dict[str, Any] = field(default_factory=dict)
    serving: dict[str, str] = field(default_factory=dict)
    responses: dict[str, dict[str, Data]] = field(default_factory=dict)
    goals: dict[str, Any] = field(default_factory=dict)
    slots: dict[str, dict[str, Any]] = field(default_factory=dict)
    results: dict[str, dict[str, Any]] = field(default_factory=dict)
    kept_responses: dict[str, int] = field(default_factory=dict)
    aside: dict[str, dict[str, list[int]]] = field(default_factory=dict)
    run: str = ""
    lifecycle: Literal["", "unconfigured", "inactive", "active", "finalized"] = ""
    apart: dict[str, Any] = field(default_factory=dict)

    def pending(self, channel: str, client: str) -> list[dict[str, Any]]:
        """Return the requests that a client has under way, the oldest first.

        Raises
        ------
        DinerosError
            The checkpoint's entry has another form.
        """
        return requests_of(self.requests.get(f"{channel}/{client}", []), self.location)


def requests_of(value: Any, location: Location | None = None) -> list[dict[str, Any]]:
    """Return the requests under way in a checkpoint's entry for a client.

    Raises
    ------
    DinerosError
        It has another form.
    """
    found: list[dict[str, Any]] = []
    requests: list[Any] = value if isinstance(value, list) else [value]
    for request in requests:
        match request:
            case {"message": str(), "data": dict(), "attempts": int()}:
                age = request.get("age", 0.0)
                if isinstance(age, (int, float)) and age >= 0:
                    found.append({**request, "age": float(age)})
                    continue
        raise DinerosError("a checkpoint with a malformed request", location=location)
    return found


class Timeout(Record, event="timeout"):
    """A request got no response in time and is sent again; `attempt` counts from 1."""

    declared = Declaration(
        mark="o",
        state="timed out",
        happens="{client} of service {service} gets no response in time: sends its request again",
    )

    channel: str
    client: str | None = None
    message: str | None = None
    attempt: int = 1


class Error(Record, event="error"):
    """A firing failed; the marking is unchanged.

    Attributes
    ----------
    transition, handler : str or None
        The transition and the handler that failed.
    error : str
        The error, as text.
    attempt : int
        Number of the attempt, from 1.
    policy : str or None
        The policy applied: ``halt``, ``retry`` or ``aside``.
    """

    transition: str | None = None
    handler: str | None = None
    error: str
    attempt: int = 1
    policy: str | None = None


class Aside(Record, event="aside"):
    """Tokens are put aside for a transition after a failure: ids by place."""

    transition: str
    tokens: dict[str, list[int]] = field(default_factory=dict)


class Release(Record, event="release"):
    """A transition may take these tokens again."""

    transition: str
    tokens: dict[str, list[int]] = field(default_factory=dict)


class Stop(Record, event="stop"):
    """The node stops; `reason` gives the reason."""

    reason: str | None = None
