"""The records of actions: goals, how they are answered, canceled and ended, and the feedback between.

A goal has an id, ``message``, which is the text of its UUID in ROS: by it the steps of both ends are known
to be of one goal.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from dineros.metamodel.records.base import Data, Record
from dineros.metamodel.records.steps import Step

OutcomeKind: TypeAlias = Literal["succeeded", "aborted", "canceled"]
"""How a goal ends."""


@dataclass(frozen=True, kw_only=True)
class GoalStep(Step):
    """A step of a goal.

    Attributes
    ----------
    channel : str
        Id of the action channel.
    client : str or None
        The client's id, in the steps of its node.
    instance : int or None
        The slot of the server, from 1, in the steps of its node.
    place : str or None
        The place that loses or gets a token; None where the model names none.
    token : int or None
        Id of that token; only in runs.
    message : str or None
        Id of the goal; only in runs.
    """

    channel: str
    client: str | None = None
    instance: int | None = None
    place: str | None = None
    token: int | None = None
    message: str | None = None


@dataclass(frozen=True, kw_only=True)
class Goal(GoalStep):
    """A client's token leaves as a goal."""

    event = "goal"


@dataclass(frozen=True, kw_only=True)
class Accept(GoalStep):
    """The server accepts a goal, carrying `data`, and begins to work on it."""

    event = "accept"

    data: Data = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Reject(GoalStep):
    """A client learns that its goal, whose `data` the token carries, is refused."""

    event = "reject"

    data: Data = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Cancel(GoalStep):
    """A client's token leaves as a request to cancel a goal; no `message`: none is under way any more."""

    event = "cancel"


@dataclass(frozen=True, kw_only=True)
class Canceling(GoalStep):
    """The server learns that a goal is to be canceled, and will do so: its token there carries `data`."""

    event = "canceling"

    data: Data = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Feedback(GoalStep):
    """A token of the server leaves as feedback, the goal's `number`-th."""

    event = "feedback"

    number: int = 0


@dataclass(frozen=True, kw_only=True)
class Hear(GoalStep):
    """Feedback, carrying `data`, arrives at the client; `number` is 0 where it has none."""

    event = "hear"

    number: int = 0
    data: Data = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Finish(GoalStep):
    """A goal ends: the server's token leaves as its result.

    Attributes
    ----------
    outcome : {"succeeded", "aborted", "canceled"}
        How it ends.
    unheeded : int or None
        Id of the token by which the work was to learn that the goal is to be canceled, and which goes with
        it; None: there is none left. Only in runs.
    """

    event = "finish"

    outcome: OutcomeKind
    unheeded: int | None = None


@dataclass(frozen=True, kw_only=True)
class Outcome(GoalStep):
    """The result of a goal, carrying `data`, arrives at the client."""

    event = "outcome"

    outcome: OutcomeKind
    data: Data = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Accepted(Record):
    """A client learns that its goal is accepted."""

    event = "accepted"

    channel: str
    client: str | None = None
    message: str | None = None


@dataclass(frozen=True, kw_only=True)
class TooLate(Record):
    """A client learns that a request to cancel has come too late, or is refused."""

    event = "tooLate"

    channel: str
    client: str | None = None
    message: str | None = None


GOAL_EVENTS: tuple[type[Record], ...] = (
    Goal,
    Accept,
    Accepted,
    Reject,
    Cancel,
    Canceling,
    TooLate,
    Feedback,
    Hear,
    Finish,
    Outcome,
)
"""The classes of these records."""
