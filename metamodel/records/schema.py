"""The kinds of records, each a class whose fields are those of the JSON object."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.records.base import Data, Record, StoredToken
from dineros.metamodel.records.goals import (
    GOAL_EVENTS,
    Accept,
    Accepted,
    Cancel,
    Canceling,
    Feedback,
    Finish,
    Goal,
    GoalStep,
    Hear,
    Outcome,
    Reject,
    TooLate,
)
from dineros.metamodel.records.steps import (
    ChannelStep,
    Drop,
    Fire,
    GiveUp,
    Lifecycle,
    Publish,
    Reply,
    Request,
    Response,
    Serve,
    ServiceStep,
    Signal,
    Step,
    Take,
    Transfer,
)

__all__ = [
    "EVENTS",
    "SCHEMA",
    "Accept",
    "Accepted",
    "Aside",
    "Cancel",
    "Canceling",
    "ChannelStep",
    "Checkpoint",
    "Data",
    "Drop",
    "Error",
    "Feedback",
    "Finish",
    "Fire",
    "GiveUp",
    "Goal",
    "GoalStep",
    "Header",
    "Hear",
    "Lifecycle",
    "Outcome",
    "Publish",
    "Record",
    "Reject",
    "Release",
    "Reply",
    "Request",
    "Response",
    "Serve",
    "ServiceStep",
    "Signal",
    "Start",
    "Step",
    "Stop",
    "StoredToken",
    "Take",
    "Timeout",
    "TooLate",
    "Transfer",
]

SCHEMA = 1
"""Version of the schema; a reader refuses a later one."""


@dataclass(frozen=True, kw_only=True)
class Header(Record):
    """First line of every file.

    Attributes
    ----------
    schema : int
        Version of the schema.
    kind : {"run", "witness"}
        What the file is.
    model, source : str
        Id of the model, and the file it comes from.
    settings : list of str
        How the model was changed for this run, as for `--set`.
    property : str or None
        Of a witness: what was asked, such as ``G a <= 1``.
    verdict : str or None
        Of a witness: the answer it proves, such as ``violated``.
    loop : int or None
        Of a witness: sequence of the first record that repeats for ever.
    signals, overflow : str or None
        Of a witness: how the model was flattened; None for a plain net.
    marking : dict of str to int
        Of a witness: initial marking of the flattened net; places that are not named are empty.
    signals_initial : dict of str to bool
        Of a witness: start value of each signal.
    cause : int or None
        Of a witness: sequence of the record with which its outcome may have begun; 0: it was so from the
        start.
    causes : list of int
        Of a witness: sequences of the records in the causal past of its outcome.
    decided : dict of str to list of int
        Of a witness: the conditions that decide its outcome; sequences of the record since which each is true
        (0: from the start), and of that up to which.
    """

    event = "header"

    schema: int = SCHEMA
    kind: Literal["run", "witness"]
    model: str
    source: str = ""
    settings: list[str] = field(default_factory=list)
    property: str | None = None
    verdict: str | None = None
    loop: int | None = None
    signals: str | None = None
    overflow: str | None = None
    marking: dict[str, int] = field(default_factory=dict)
    signals_initial: dict[str, bool] = field(default_factory=dict)
    cause: int | None = None
    causes: list[int] = field(default_factory=list)
    decided: dict[str, list[int]] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Start(Record):
    """A node begins, or goes on after a restart.

    Attributes
    ----------
    marking : dict of str to list of StoredToken
        Tokens of each place, the oldest first.
    signals : dict of str to bool
        Values of the signals.
    resumed : bool
        Whether the node goes on where an earlier run ended.
    seed : int or None
        Seed of the firing selection.
    """

    event = "start"

    marking: dict[str, list[StoredToken]] = field(default_factory=dict)
    signals: dict[str, bool] = field(default_factory=dict)
    resumed: bool = False
    seed: int | None = None


@dataclass(frozen=True, kw_only=True)
class Checkpoint(Start):
    """All that a node needs to go on from here: the second line of every file, and the first of a restart.

    Attributes
    ----------
    next_token : int
        Id of the next token.
    numbers : dict of str to int
        Number of the last message of each publisher's or client's port, by its place; instances of a server
        page share their publishers.
    history : dict of str to list of StoredToken
        Number and data of the last messages of each publishing place, as many as its queue holds: a node that
        goes on publishes them again, since the queue has died with its process.
    queues : dict of str to int
        How many messages the queue of each publishing place holds.
    kept : dict
        What handlers keep: name -> JSON value.
    seen : dict
        ``CHANNEL/PLACE`` of a subscriber -> sender (a message's id without its number) -> number of its last
        message, where all before it came or were lost.
    seen_apart : dict
        ``CHANNEL/PLACE`` -> sender -> first and last number of each further range of messages that came.
    missing : dict of str to int
        ``CHANNEL/PLACE`` -> messages that were lost since the last one came.
    requests : dict
        ``CHANNEL/CLIENT`` -> the requests under way, the oldest first: message id, data, attempts, and for
        how many seconds (`age`); earlier versions wrote the only one, without a list and an age.
    serving : dict of str to str
        Entry place of a server instance -> message id of the request that it serves.
    responses : dict
        Channel -> message id -> data of the responses kept for requests that come again, the oldest first.
    goals : dict
        ``CHANNEL/CLIENT`` of an action -> the goals under way, the oldest first: id, data, whether it is
        accepted and whether it is to be canceled, the number of the feedback heard last, attempts so far.
    slots : dict
        Entry place of a slot of an action's server -> the goal that it works on: id, data, whether it is to
        be canceled, the number of its last feedback, and number and data of the last ones.
    results : dict
        Channel of an action's server -> id of a goal -> its outcome and data, the oldest first.
    kept_responses : dict of str to int
        Channel -> how many responses to each sender are kept, where that is more than one.
    aside : dict
        Transition -> place -> ids of the tokens that it leaves alone after a failure.
    run : str
        What the ids of the run's messages carry besides the node's id.
    lifecycle : str
        The state of a managed node; empty: it is none.
    """

    event = "checkpoint"

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

    def pending(self, channel: str, client: str) -> list[dict[str, Any]]:
        """Return the requests that a client has under way, the oldest first.

        Raises
        ------
        DinerosError
            What the checkpoint says of them is none.
        """
        return requests_of(self.requests.get(f"{channel}/{client}", []), self.location)


def requests_of(value: Any, location: Location | None = None) -> list[dict[str, Any]]:
    """Return the requests under way that a checkpoint tells of a client.

    Raises
    ------
    DinerosError
        It tells something else.
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
        raise DinerosError("a checkpoint with a request that is none", location=location)
    return found


@dataclass(frozen=True, kw_only=True)
class Timeout(Record):
    """A request got no response in time and is sent again; `attempt` counts from 1."""

    event = "timeout"

    channel: str
    client: str | None = None
    message: str | None = None
    attempt: int = 1


@dataclass(frozen=True, kw_only=True)
class Error(Record):
    """A firing failed and left everything as it was.

    Attributes
    ----------
    transition, handler : str or None
        Where it failed.
    error : str
        What happened.
    attempt : int
        Which attempt it was, from 1.
    policy : str or None
        What is done about it: ``halt``, ``retry`` or ``aside``.
    """

    event = "error"

    transition: str | None = None
    handler: str | None = None
    error: str
    attempt: int = 1
    policy: str | None = None


@dataclass(frozen=True, kw_only=True)
class Aside(Record):
    """A transition leaves tokens alone after a failure: ids by place."""

    event = "aside"

    transition: str
    tokens: dict[str, list[int]] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Release(Record):
    """A transition may take these tokens again."""

    event = "release"

    transition: str
    tokens: dict[str, list[int]] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Stop(Record):
    """The node ends; `reason` says why."""

    event = "stop"

    reason: str | None = None


_KINDS: tuple[type[Record], ...] = (
    Header,
    Start,
    Checkpoint,
    Fire,
    Signal,
    Publish,
    Take,
    Drop,
    Request,
    Serve,
    Reply,
    Response,
    GiveUp,
    Lifecycle,
    *GOAL_EVENTS,
    Transfer,
    Timeout,
    Error,
    Aside,
    Release,
    Stop,
)

EVENTS: dict[str, type[Record]] = {kind.event: kind for kind in _KINDS}
"""Class of the records of each event."""
