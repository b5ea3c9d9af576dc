"""The saved state of a node, with which it continues: the fields of a ``checkpoint`` record."""

from __future__ import annotations

from typing import NotRequired, TypedDict

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.lifecycles.states import State
from dineros.metamodel.token_data import Value
from dineros.runtime.journal.kept import Json
from dineros.runtime.nets.ports import OutcomeKind

RecordedToken = list[object]
"""``[id, data]``; of a message, ``[number, data]``."""


class CallState(TypedDict):
    """The saved state of calls; see `SavedState`."""

    requests: dict[str, list[PendingRequest]]
    serving: dict[str, str]
    responses: dict[str, dict[str, dict[str, Value]]]
    kept_responses: dict[str, int]


class GoalState(TypedDict):
    """The saved state of goals; see `SavedState`."""

    goals: dict[str, list[PendingGoal]]
    slots: dict[str, SlotGoal]
    results: dict[str, dict[str, GoalResult]]


class ChannelState(CallState, GoalState):
    """The saved state of channels; see `SavedState`."""

    run: str
    numbers: dict[str, int]
    queues: dict[str, int]
    history: dict[str, list[RecordedToken]]
    seen: dict[str, dict[str, int]]
    seen_apart: dict[str, dict[str, list[list[int]]]]
    missing: dict[str, int]


class SavedState(ChannelState):
    """All data that a node needs to continue: the fields of a ``checkpoint`` record, all JSON.

    Attributes
    ----------
    marking : dict
        Place id -> its tokens in order; places without tokens are left out.
    signals : dict
        Signal id -> value.
    next_token : int
        The next token's id.
    numbers : dict
        Sending place -> number of its last message.
    history : dict
        Publishing place -> number and data of its last messages, as many as its queue
        holds, the oldest first.
    queues : dict
        Publishing place -> number of messages that its queue holds.
    kept : dict
        Values kept by handlers (`Firing.memory`): name -> JSON value.
    seen : dict
        ``CHANNEL/PLACE`` of a subscriber -> sender (a message id without its number) -> number of the last
        message up to which all messages were received or lost.
    seen_apart : dict
        ``CHANNEL/PLACE`` -> sender -> first and last number of each further range of received messages.
    missing : dict
        ``CHANNEL/PLACE`` -> number of messages lost since the last one was received.
    requests : dict
        ``CHANNEL/CLIENT`` -> the requests under way, the oldest first: message id, data, attempts so far, and
        age in seconds.
    serving : dict
        Entry place of a server instance -> message id of the request that it serves.
    responses : dict
        Channel of a server -> message id -> data of the responses kept for repeated requests, the oldest
        first.
    kept_responses : dict
        Channel of a server -> number of responses kept for each sender, if more than one.
    goals : dict
        ``CHANNEL/CLIENT`` of an action -> the goals under way, the oldest first.
    slots : dict
        Entry place of a slot of an action server -> the goal that it executes.
    results : dict
        Channel of an action's server -> id of a goal -> ``outcome`` and ``data``, the oldest first.
    aside : dict
        Transition -> place -> ids of tokens put aside.
    run : str
        Part of the ids of this run's messages, after the node's id; unchanged by a restart.
    lifecycle : str
        Lifecycle state of a managed node; missing for other nodes.
    """

    marking: dict[str, list[RecordedToken]]
    signals: dict[str, SignalSetting]
    next_token: int
    kept: dict[str, Json]
    aside: dict[str, dict[str, list[int]]]
    lifecycle: NotRequired[State]


class PendingGoal(TypedDict):
    """A client's goal that has not ended: whether it was accepted, and whether its cancel was requested.

    ``heard`` is the number of the last feedback received, ``attempts`` the number of times it was sent.
    """

    message: str
    data: dict[str, Value]
    accepted: bool
    canceled: bool
    heard: int
    attempts: int


class SlotGoal(TypedDict):
    """A goal that a slot executes: whether it is to be canceled, and how much feedback it has sent.

    ``feedback`` has number and data of the last feedback, at most ``depth`` entries.
    """

    message: str
    data: dict[str, Value]
    canceling: bool
    sent: int
    feedback: list[RecordedToken]
    depth: int


class GoalResult(TypedDict):
    """The outcome of a goal and its result."""

    outcome: OutcomeKind
    data: dict[str, Value]


class PendingRequest(TypedDict):
    """A request without a response so far."""

    message: str
    data: dict[str, Value]
    attempts: int
    age: float
