"""The records of actions: goals, their answers, cancel requests, ends, and feedback.

A goal has an id, ``message``, which is the text of its UUID in ROS; it identifies the steps of both ends that
belong to one goal.
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
        The slot of the server, from 1: in steps of its node, and in a cancel request of a witness.
    place : str or None
        The place that loses or gets a token; None: the model has no such place.
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
    """The server accepts a goal with this `data`, and begins to execute it."""

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
    """A client is informed that its goal is refused; the token has the goal's `data`."""

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
    """A client's token leaves as a cancel request for a goal.

    Without a `message`, and in a witness without an `instance`, there is no goal for it, and it is dropped.
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
    """The server receives a cancel request and agrees to cancel the goal; its token has this `data`."""

    declared = Declaration(
        does="the server receives the request to cancel goal {message}",
        does_nameless="the server receives the request to cancel no goal",
        token="may arrive",
        goal="is to be canceled",
        end="server",
        port="cancel",
        receives="cancel",
        mark="x",
        state="canceling",
        happens="{slot} of action {action} receives the request to cancel {goal}",
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
    """Feedback with this `data` arrives at the client; `number` is 0 if it has none."""

    declared = Declaration(
        does="the client receives feedback on goal {message}",
        does_nameless="the client receives feedback on no goal",
        token="may arrive",
        goal="has its feedback heard",
        end="client",
        port="feedback",
        receives="feedback",
        mark="h",
        state="heard",
        happens="{client} receives feedback of action {action}",
    )

    number: int = 0
    data: Data = field(default_factory=dict)


class Finish(GoalStep, event="finish"):
    """A goal ends: the server's token leaves as its result.

    Attributes
    ----------
    outcome : {"succeeded", "aborted", "canceled"}
        The outcome.
    unheeded : int or None
        Id of the cancel token that the goal's execution did not take, and that is removed with the goal;
        None: there is none. Only in runs.
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
    """The result of a goal, with this `data`, arrives at the client."""

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
    """A client is informed that its goal is accepted; the token, if there is one, has this `data`."""

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
    """A client is informed that a cancel request came too late, or is refused."""

    declared = Declaration(
        goal="is not canceled",
        end="client",
        happens="{client} learns that its request to cancel came too late",
    )

    channel: str
    client: str | None = None
    message: str | None = None
