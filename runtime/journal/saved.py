"""What a run needs to continue where it ended: the state of a node, as a ``checkpoint`` record tells it."""

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
    """What a node continues with of its calls; see `SavedState`."""

    requests: dict[str, list[PendingRequest]]
    serving: dict[str, str]
    responses: dict[str, dict[str, dict[str, Value]]]
    kept_responses: dict[str, int]


class GoalState(TypedDict):
    """What a node continues with of goals; see `SavedState`."""

    goals: dict[str, list[PendingGoal]]
    slots: dict[str, SlotGoal]
    results: dict[str, dict[str, GoalResult]]


class ChannelState(CallState, GoalState):
    """What a node continues with of its channels; see `SavedState`."""

    run: str
    numbers: dict[str, int]
    queues: dict[str, int]
    history: dict[str, list[RecordedToken]]
    seen: dict[str, dict[str, int]]
    seen_apart: dict[str, dict[str, list[list[int]]]]
    missing: dict[str, int]


class SavedState(ChannelState):
    """All a node needs to continue: the fields of a ``checkpoint`` record, JSON throughout.

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
        Publishing place -> how many messages its queue holds.
    kept : dict
        What handlers keep (`Firing.memory`): name -> JSON value.
    seen : dict
        ``CHANNEL/PLACE`` of a subscriber -> sender (a message's id without its number) -> number of its last
        message, where all before it came or were lost.
    seen_apart : dict
        ``CHANNEL/PLACE`` -> sender -> first and last number of each further range of messages that came.
    missing : dict
        ``CHANNEL/PLACE`` -> messages that were lost since the last one came.
    requests : dict
        ``CHANNEL/CLIENT`` -> the requests under way, the oldest first: message id, data, attempts so far, and
        for how many seconds.
    serving : dict
        Entry place of a server instance -> message id of the request that it serves.
    responses : dict
        Channel of a server -> message id -> data of the responses kept for requests that come twice, oldest
        first.
    kept_responses : dict
        Channel of a server -> how many responses to each sender it keeps, where that is more than one.
    goals : dict
        ``CHANNEL/CLIENT`` of an action -> the goals under way, the oldest first.
    slots : dict
        Entry place of a slot of an action's server -> the goal that it works on.
    results : dict
        Channel of an action's server -> id of a goal -> ``outcome`` and ``data``, the oldest first.
    aside : dict
        Transition -> place -> ids of tokens put aside.
    run : str
        What the ids of this run's messages carry besides the node's id; survives a restart.
    lifecycle : str
        The state of a managed node; other nodes have none.
    """

    marking: dict[str, list[RecordedToken]]
    signals: dict[str, SignalSetting]
    next_token: int
    kept: dict[str, Json]
    aside: dict[str, dict[str, list[int]]]
    lifecycle: NotRequired[State]


class PendingGoal(TypedDict):
    """A client's goal that has not ended: whether it is accepted, and asked to be canceled.

    ``heard`` is the number of the feedback that came last, ``attempts`` how often it was sent.
    """

    message: str
    data: dict[str, Value]
    accepted: bool
    canceled: bool
    heard: int
    attempts: int


class SlotGoal(TypedDict):
    """A goal that a slot works on, whether it is to be canceled, and how much feedback it has given.

    ``feedback`` holds number and data of the last ones, ``depth`` at most.
    """

    message: str
    data: dict[str, Value]
    canceling: bool
    sent: int
    feedback: list[RecordedToken]
    depth: int


class GoalResult(TypedDict):
    """How a goal ended."""

    outcome: OutcomeKind
    data: dict[str, Value]


class PendingRequest(TypedDict):
    """A request that has no response yet."""

    message: str
    data: dict[str, Value]
    attempts: int
    age: float
