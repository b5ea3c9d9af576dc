"""Events about the goals of actions that a transport sends to a node.

The id of a goal is the text of a UUID. The client computes it from the number of the goal, so a client that
continues after a crash sends the same goal with the same id, and the server recognises it.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable, Sequence
from typing import NamedTuple

from dineros.runtime.nets.ports import Data, Message, OutcomeKind

_GOALS = uuid.uuid5(uuid.NAMESPACE_URL, "http://dineros.org/goals")


def goal_id(message_id: str) -> str:
    """Return the goal id that belongs to the id of a client's message.

    Examples
    --------
    >>> goal_id("office/Send/1")
    '620e0e27-d64d-544b-bfcb-79596e0d21a0'
    """
    return str(uuid.uuid5(_GOALS, message_id))


class GoalArrived(NamedTuple):
    """A server receives a goal; `answer` reports to its client whether it is accepted, and never raises."""

    message: Message
    answer: Callable[[bool], None]


class CancelArrived(NamedTuple):
    """A server is asked to cancel goals; `answer` reports which ones it cancels, and never raises."""

    goals: Sequence[str]
    answer: Callable[[Sequence[str]], None]


class GoalAnswered(NamedTuple):
    """The server accepts or refuses a client's goal."""

    goal: str
    is_accepted: bool


class GoalFailed(NamedTuple):
    """No server answered a client's goal; it is recorded and sent again with the same id."""

    goal: str
    reason: str


class GoalUnknown(NamedTuple):
    """The server does not know a client's goal."""

    goal: str


class CancelAnswered(NamedTuple):
    """The server agrees to cancel a client's goal, or refuses to."""

    goal: str
    is_accepted: bool


class FeedbackArrived(NamedTuple):
    """A client receives feedback on a goal; `number` counts from 1, or is 0 if the type has no number."""

    goal: str
    number: int
    data: Data


class GoalEnded(NamedTuple):
    """A client receives the result of a goal."""

    goal: str
    outcome: OutcomeKind
    data: Data


ServerEvent = GoalArrived | CancelArrived
ClientEvent = GoalAnswered | GoalFailed | GoalUnknown | CancelAnswered | FeedbackArrived | GoalEnded
ActionEvent = ServerEvent | ClientEvent


class KnownGoal(NamedTuple):
    """A goal of a server that continues after a restart.

    Attributes
    ----------
    message : Message
            Id of the goal; the data of the goal or, once it has ended, of its result.
    is_canceling : bool
        Whether it is to be canceled.
    outcome : str or None
            How it ended; None: it is still being executed.
    """

    message: Message
    is_canceling: bool = False
    outcome: OutcomeKind | None = None
