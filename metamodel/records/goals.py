"""The records of actions: goals, how they are answered, canceled and ended, and the feedback between.

A goal has an id, ``message``, which is the text of its UUID in ROS: by it the steps of both ends are known
to be of one goal.
"""

from __future__ import annotations

from dataclasses import field
from typing import Literal, TypeAlias

from dineros.metamodel.records.base import Data, Record
from dineros.metamodel.records.declarations import Declaration
from dineros.metamodel.records.steps import Step

OutcomeKind: TypeAlias = Literal["succeeded", "aborted", "canceled"]
"""How a goal ends."""


class GoalStep(Step):
    """A step of a goal.

    Attributes
    ----------
    channel : str
        Id of the action channel.
    client : str or None
        The client's id, in the steps of its node.
    instance : int or None
        The slot of the server, from 1, in the steps of its node, and of a request to cancel in a witness.
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


class Goal(GoalStep, event="goal"):
    """A client's token leaves as a goal."""

    declared = Declaration(
        does="the client sends goal {message}",
        does_nameless="the client sends no goal",
        token="leaves",
        goal="is sent",
        end="client",
        port="goal",
        mark="q",
        state="sent",
        happens="{client} sends a goal of action {action}",
    )


class Accept(GoalStep, event="accept"):
    """The server accepts a goal, carrying `data`, and begins to work on it."""

    declared = Declaration(
        does="the server accepts goal {message}",
        does_nameless="the server accepts no goal",
        token="may arrive",
        goal="is accepted",
        end="server",
        port="entry",
        receives="goal",
        mark="s",
        state="accepted",
        happens="{slot} of action {action} accepts {goal}",
    )

    data: Data = field(default_factory=dict)


class Reject(GoalStep, event="reject"):
    """A client learns that its goal, whose `data` the token carries, is refused."""

    declared = Declaration(
        does="the client learns of the refusal of goal {message}",
        does_nameless="the client learns of the refusal of no goal",
        token="may arrive",
        goal="is known to be rejected",
        end="client",
        port="rejected",
        mark="a",
        happens="{client} learns that {own} {ends}",
    )

    data: Data = field(default_factory=dict)


class Cancel(GoalStep, event="cancel"):
    """A client's token leaves as a request to cancel a goal.

    Without a `message`, and without an `instance` in a witness, it finds none, and is gone.
    """

    declared = Declaration(
        does="the client asks to cancel goal {message}",
        does_nameless="the client asks to cancel no goal",
        token="leaves",
        goal="is asked to cancel",
        end="client",
        port="cancel",
        mark="c",
        state="asked to cancel",
        happens="{client} asks to cancel {asked}",
    )


class Canceling(GoalStep, event="canceling"):
    """The server learns that a goal is to be canceled, and will do so: its token there carries `data`."""

    declared = Declaration(
        does="the server hears of the request to cancel goal {message}",
        does_nameless="the server hears of the request to cancel no goal",
        token="may arrive",
        goal="is to be canceled",
        end="server",
        port="cancel",
        receives="cancel",
        mark="x",
        state="canceling",
        happens="{slot} of action {action} hears that {goal} is to be canceled",
    )

    data: Data = field(default_factory=dict)


class Feedback(GoalStep, event="feedback"):
    """A token of the server leaves as feedback, the goal's `number`-th."""

    declared = Declaration(
        does="the server gives feedback on goal {message}",
        does_nameless="the server gives feedback on no goal",
        token="leaves",
        goal="gives feedback",
        end="server",
        port="feedback",
        mark="b",
        state="feedback",
        happens="{slot} of action {action} gives feedback to {client}",
    )

    number: int = 0


class Hear(GoalStep, event="hear"):
    """Feedback, carrying `data`, arrives at the client; `number` is 0 where it has none."""

    declared = Declaration(
        does="the client hears feedback on goal {message}",
        does_nameless="the client hears feedback on no goal",
        token="may arrive",
        goal="has its feedback heard",
        end="client",
        port="feedback",
        receives="feedback",
        mark="h",
        state="heard",
        happens="{client} hears feedback of action {action}",
    )

    number: int = 0
    data: Data = field(default_factory=dict)


class Finish(GoalStep, event="finish"):
    """A goal ends: the server's token leaves as its result.

    Attributes
    ----------
    outcome : {"succeeded", "aborted", "canceled"}
        How it ends.
    unheeded : int or None
        Id of the token by which the work was to learn that the goal is to be canceled, and which goes with
        it; None: there is none left. Only in runs.
    """

    declared = Declaration(
        does="the server ends goal {message}",
        does_nameless="the server ends no goal",
        token="leaves",
        goal="ends",
        end="server",
        mark="r",
        state="finished",
        happens="{goal} {ends}",
    )

    outcome: OutcomeKind
    unheeded: int | None = None


class Outcome(GoalStep, event="outcome"):
    """The result of a goal, carrying `data`, arrives at the client."""

    declared = Declaration(
        does="the client learns of the end of goal {message}",
        does_nameless="the client learns of the end of no goal",
        token="may arrive",
        goal="is known to have ended",
        end="client",
        receives="finish",
        mark="a",
        happens="{client} learns that {own} {ends}",
    )

    outcome: OutcomeKind
    data: Data = field(default_factory=dict)


class Accepted(GoalStep, event="accepted"):
    """A client learns that its goal is accepted; the token for that, if there is one, carries `data`."""

    declared = Declaration(
        does="the client learns of the acceptance of goal {message} ({channel})",
        does_nameless="the client learns of the acceptance of no goal ({channel})",
        token="may arrive",
        goal="is known to be accepted",
        end="client",
        port="accepted",
        receives="accept",
        happens="{client} learns that {own} is accepted",
    )

    data: Data = field(default_factory=dict)


class TooLate(Record, event="tooLate"):
    """A client learns that a request to cancel has come too late, or is refused."""

    declared = Declaration(
        goal="is not canceled",
        end="client",
        happens="{client} learns that its request to cancel came too late",
    )

    channel: str
    client: str | None = None
    message: str | None = None
