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

    `dineros.metamodel.records.Checkpoint` says what they mean. Places without tokens are left out; only the
    state of a managed node has a ``lifecycle``.
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
