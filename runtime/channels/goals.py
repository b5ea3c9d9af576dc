"""What a transport tells a node of the goals of actions, and what a node asks of a transport for them.

A goal has an id, the text of a UUID, which its client chooses by the number of the goal among its own: a
client that continues after a crash sends the same goal with the same id, and the server recognises it.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable, Sequence
from typing import NamedTuple

from dineros.runtime.nets.ports import Data, Message, OutcomeKind

_GOALS = uuid.uuid5(uuid.NAMESPACE_URL, "http://dineros.org/goals")


def goal_id(message_id: str) -> str:
    """Return the id of the goal that a client's message is.

    Examples
    --------
    >>> goal_id("office/Send/1")
    '620e0e27-d64d-544b-bfcb-79596e0d21a0'
    """
    return str(uuid.uuid5(_GOALS, message_id))


class GoalArrived(NamedTuple):
    """A goal comes to a server; `answer` tells its client whether it is accepted. It does not raise."""

    message: Message
    answer: Callable[[bool], None]


class CancelArrived(NamedTuple):
    """Some goals of a server are to be canceled; `answer` tells which will be. It does not raise."""

    goals: Sequence[str]
    answer: Callable[[Sequence[str]], None]


class GoalAnswered(NamedTuple):
    """The server accepts or refuses a client's goal."""

    goal: str
    is_accepted: bool


class GoalFailed(NamedTuple):
    """Nobody has answered a client's goal: it is recorded, and sent again with the same id."""

    goal: str
    reason: str


class GoalUnknown(NamedTuple):
    """The server knows nothing of a client's goal."""

    goal: str


class CancelAnswered(NamedTuple):
    """The server cancels a client's goal, or does not."""

    goal: str
    is_accepted: bool


class FeedbackArrived(NamedTuple):
    """Feedback on a client's goal comes: the goal's `number`-th, or 0 where it has no number."""

    goal: str
    number: int
    data: Data


class GoalEnded(NamedTuple):
    """The result of a client's goal comes."""

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
        Its id and data.
    is_canceling : bool
        Whether it is to be canceled.
    outcome : str or None
        How it has ended, and `message` carries its result; None: it is being worked on.
    """

    message: Message
    is_canceling: bool = False
    outcome: OutcomeKind | None = None
