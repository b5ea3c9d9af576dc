"""Properties of each kind of record, declared once, so that all users of records can loop over the kinds.

They are used by the saved state of a node, conformance, the roles of transitions, messages, scripts of
generated tests, the trace page and its breakpoints.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

TokenMove: TypeAlias = Literal["", "leaves", "arrives", "may arrive"]
"""The move of a record's token at its place; ``may arrive``: the place may be missing."""

CallChange: TypeAlias = Literal["", "begins", "is served", "is answered", "ends", "is given up"]
"""The effect on a service call."""

GoalChange: TypeAlias = Literal[
    "",
    "is sent",
    "is accepted",
    "is known to be accepted",
    "is known to be rejected",
    "is asked to cancel",
    "is to be canceled",
    "is not canceled",
    "gives feedback",
    "has its feedback heard",
    "ends",
    "is known to have ended",
]
"""The effect on a goal of an action."""


@dataclass(frozen=True, kw_only=True)
class Declaration:
    """The common properties of all records of a kind.

    Texts have placeholders for fields of the record.

    Attributes
    ----------
    does : str
        Action of the node, for messages; its subject is the place.
    does_nameless : str
        The same if the message has no id.
    token : TokenMove
        Its effect on the node's marking.
    call : CallChange
        Its effect on a service call; empty: none.
    goal : GoalChange
        Its effect on a goal of an action; empty: none.
    end : {"", "client", "server"}
        The participant of the call or goal.
    port : str
        The feature of that port for the place of the record; empty for a goal: the place depends on the
        outcome. For a step of no call and no goal, the port is that of a topic.
    receives : str
        The event of the record that sends the message which this one receives, by the same id; empty: it
        receives none.
    mark : str
        The letter of its mark on the lane of a trace; empty: there is no mark.
    state : str
        State of the call or goal after it, in exported files; empty: that of its outcome.
    happens : str
        Description on the trace page: ``{client}`` and ``{server}`` are described, ``{service}`` is named.
        For goals, ``{client}``, ``{slot}``, ``{goal}`` (``{own}`` or ``{asked}`` after its client) and how it
        ``{ends}`` are described, ``{action}`` is named.
    comes_last : bool
        Whether it is replayed only if nothing else can be: no other step waits for it.
    needs_time : str
        Why a script of steps cannot contain it, since scripts have no time; empty: it can.
    without_it : str
        The meaning of a trace without such steps.
    """

    does: str = ""
    does_nameless: str = ""
    token: TokenMove = ""
    call: CallChange = ""
    goal: GoalChange = ""
    end: Literal["", "client", "server"] = ""
    port: str = ""
    receives: str = ""
    mark: str = ""
    state: str = ""
    happens: str = ""
    comes_last: bool = False
    needs_time: str = ""
    without_it: str = ""

    @property
    def is_of_topic(self) -> bool:
        """Whether it is a step at the port of a topic."""
        return bool(self.port) and not self.call and not self.goal

    def words(self, record: object) -> str:
        """Return the action of the node, with the fields of a record of this kind."""
        does = self.does if getattr(record, "message", None) else self.does_nameless
        return does.format(**vars(record))
