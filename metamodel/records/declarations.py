"""What a kind of record declares once, so that all who handle records loop over the kinds.

The saved state of a node, conformance, the roles of transitions, messages, scripts of generated tests, the
trace page and its breakpoints take from here what they need.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

TokenMove: TypeAlias = Literal["", "leaves", "arrives", "may arrive"]
"""What happens to the token of a record at its place: ``may arrive`` where the place may be absent."""

CallChange: TypeAlias = Literal["", "begins", "is served", "is answered", "ends", "is given up"]
"""What becomes of a call of a service."""

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
"""What becomes of a goal of an action."""


@dataclass(frozen=True, kw_only=True)
class Declaration:
    """What is the same for all records of a kind.

    Texts have placeholders for the fields of the record.

    Attributes
    ----------
    does : str
        What the node does, for messages; its subject is the place.
    does_nameless : str
        The same where the message has no id.
    token : TokenMove
        What it does to the node's marking.
    call : CallChange
        What it does to a call of a service; empty: it is about something else.
    goal : GoalChange
        What it does to a goal of an action; empty: it is about something else.
    end : {"", "client", "server"}
        Who takes part in the call or the goal.
    port : str
        The feature of that port which is the place of the record; empty for a goal: that of its outcome. Of a
        step that is of no call and no goal, the port is that of a topic.
    receives : str
        The event of the record that sends what this one receives, by the same id; empty: it receives
        nothing.
    mark : str
        The letter of its mark on the lane of a trace; empty: nothing is drawn.
    state : str
        What the call or goal of that mark is then, in exported files; empty: what its outcome says.
    happens : str
        What happens, on the trace page: ``{client}`` and ``{server}`` are described, ``{service}`` is named.
        Of goals, ``{client}``, ``{slot}``, ``{goal}`` (``{own}`` or ``{asked}`` after its client) and how it
        ``{ends}`` are described, ``{action}`` is named.
    comes_last : bool
        Whether it is replayed only when nothing else can be: no other step waits for it.
    needs_time : str
        What a script of steps cannot say, since it knows no time; empty: it can.
    without_it : str
        What is so in a trace without such steps.
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
        """Return what the node does, with the fields of a record of this kind."""
        does = self.does if getattr(record, "message", None) else self.does_nameless
        return does.format(**vars(record))
